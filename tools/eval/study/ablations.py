"""tools/eval/ablations: each part of the networks left out, trained for the same time, on the same test frames.

Networks that are there are not trained again, and a training that was interrupted goes on.
"""

import argparse
import os
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from evaluation import BadInput

from . import quality
from .renderer import ROOT

sys.path.insert(0, str(ROOT / "tools/train"))
from lightformer_train import families  # noqa: E402  (needs neither PyTorch nor anything else)

TRAIN = ROOT / "tools/train/train.py"


@dataclass(frozen=True)
class Ablation:
    """A network to train."""

    preset: str
    without: str = ""

    @property
    def name(self) -> str:
        """Of its row and its file."""
        return f"{self.preset}-without-{self.without}" if self.without else self.preset


def parse(arguments: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """The command line: our options, and those of tools/eval/quality."""
    parser = argparse.ArgumentParser(
        prog="tools/eval/ablations",
        description="Trains networks with one part left out each, and judges them. All other "
        "options are those of tools/eval/quality. Networks, logs and the result are written to --out.",
    )
    add = parser.add_argument
    add("data", nargs="+", type=Path, metavar="DATA", help="folder of a data set; before all options")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--minutes", default="10", metavar="M", help="of each training (default 10)")
    length.add_argument("--steps", metavar="N", help="instead of minutes")
    add(
        "--presets",
        nargs="+",
        choices=families.PRESETS,
        default=["structured-small", "paper-small"],
        metavar="PRESET",
        help="families at their widths (default: structured-small paper-small)",
    )
    add("--only", nargs="+", metavar="PART", help="leave out only these; none: no part")
    add("--list", action="store_true", help="print the names of the networks and do nothing")
    add("--out", type=Path, default=ROOT / "out/ablations", metavar="DIR", help="default out/ablations")
    return parser.parse_known_args(arguments)


def choose(presets: list[str], only: list[str] | None) -> list[Ablation]:
    """Each preset whole and without each of its parts."""
    return [
        Ablation(preset, part)
        for preset in presets
        for part in ("", *families.parts(preset))
        if not part or only is None or part in only
    ]


def file_of(ablation: Ablation, options: argparse.Namespace) -> Path:
    """Where a network is, or will be."""
    return options.out / f"{ablation.name}.safetensors"


def train(ablation: Ablation, options: argparse.Namespace) -> None:
    """Trains a network if it is not there."""
    output = file_of(ablation, options)
    if output.exists():
        return
    length = ["--steps", options.steps] if options.steps else ["--minutes", options.minutes]
    arguments = [*map(str, options.data), "-o", str(output), "--preset", ablation.preset, *length]
    arguments += ["--without", ablation.without] if ablation.without else []
    arguments += ["--resume"] if output.with_suffix(".checkpoint").exists() else []
    log = options.out / f"{ablation.name}.log"
    print(f"training {ablation.name}: {log}", file=sys.stderr, flush=True)
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    with open(log, "a", encoding="utf-8") as file:
        done = subprocess.run([TRAIN, *arguments], stdout=file, stderr=subprocess.STDOUT, env=environment, check=False)
    if done.returncode != 0:
        lines = log.read_text(encoding="utf-8").strip().splitlines()
        raise BadInput(lines[-1] if lines else f"{TRAIN}: exit code {done.returncode}")


def main() -> int:
    """The command."""
    options, others = parse(sys.argv[1:])
    chosen = choose(options.presets, options.only)
    if options.list:
        print("\n".join(ablation.name for ablation in chosen))
        return 0
    networks = [f"{ablation.name}={file_of(ablation, options)}" for ablation in chosen]
    judging = quality.parse([*networks, *others, "--only-networks", "--parts", "frames", "--out", str(options.out)])
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        for ablation in chosen:
            train(ablation, options)
        quality.Study(judging, "tools/eval/ablations " + shlex.join(sys.argv[1:])).run()
    except BadInput as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
