#!/usr/bin/python3
"""Shows what a preset's network is, or writes it with random weights.

tools/train/program.py                                    the presets
tools/train/program.py structured-small                   its parts and its cost
tools/train/program.py structured-small --without mirror -o out/random.safetensors --seed 1
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from lightformer_train import families, program  # noqa: E402
from lightformer_train.arguments import SEEDS, Parser, whole  # noqa: E402


def main() -> int:
    """The command."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("preset", nargs="?", choices=families.PRESETS, help="none: what there is")
    parser.add_argument("--without", nargs="+", default=[], metavar="PART", help="leave parts out")
    parser.add_argument("--json", action="store_true", help="print the program itself")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the network with random weights")
    parser.add_argument("--force", action="store_true", help="overwrite a file that is there")
    parser.add_argument("--seed", type=whole(0, SEEDS - 1), default=0, help="of the weights (default 0)")
    arguments = parser.parse_args()
    if arguments.preset is None:
        for name, preset in families.PRESETS.items():
            print(f"{name:18} {preset.about}")
        return 0
    without = frozenset(arguments.without)
    try:
        operations = families.build(arguments.preset, without)
    except ValueError as error:
        print(f"program: {error}", file=sys.stderr)
        return 2
    if arguments.json:
        print(json.dumps(operations, indent=1))
    else:
        print(describe(arguments.preset, program.check(operations)))
    try:
        if arguments.output:
            if arguments.output.is_file() and not arguments.force:
                raise ValueError(f"{arguments.output}: is there already; --force overwrites it")
            write_random(arguments.preset, without, arguments.seed, arguments.output)
    except (ModuleNotFoundError, ValueError) as error:  # no PyTorch; a file that cannot be written
        print(f"program: {error}", file=sys.stderr)
        return 1
    return 0


def describe(preset: str, checked: program.Checked) -> str:
    """Parts and cost in words."""
    cost = program.cost(checked)
    lines = [f"{preset}: {families.PRESETS[preset].about}"]
    lines += [f"  {part:18} {meaning}" for part, meaning in families.parts(preset).items()]
    lines.append(f"{len(checked.operations)} operations, {checked.parameters} parameters")
    lines.append(f"reads {', '.join(checked.inputs)}")
    lines.append(
        f"multiply-adds: {cost.pixel:.0f} a pixel and {cost.view:.0f} a pixel and light"
        f" ({cost.per_pixel(2):.0f} with 2 lights, {cost.per_pixel(3):.0f} with 3),"
        f" {cost.vpl:.0f} a direct VPL, {cost.texel:.0f} a texel, {cost.light:.0f} a light"
    )
    return "\n".join(lines)


def write_random(preset: str, without: frozenset[str], seed: int, path: Path) -> None:
    """The network before any training."""
    import torch

    from lightformer_train import network_file

    torch.manual_seed(seed)
    network = network_file.create(preset, without)
    description = network_file.Description(preset, without, training=f"none, seed {seed}")
    network_file.save(path, network, description.notes())


if __name__ == "__main__":
    sys.exit(main())
