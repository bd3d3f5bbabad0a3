#!/usr/bin/python3
"""How much faster a network runs than in PyTorch: the same weights, pixels, lights and threads.

    tests/net/compare_torch.py NETWORK [--lights 2] [--size 512] [--threads 2] [--rounds 5] [--precision auto] [--json]

The executors take turns, round by round, so that all see the same machine; ratios are medians over rounds. "best" is PyTorch's best
setting: channels last, what is the same for all pixels of a light multiplied once, products in bf16 where the CPU multiplies it and
fp32 elsewhere. "plain" is the plain form: fp32 eager, every operand repeated and concatenated.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import torch

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools/train"), str(ROOT / "tests/train")]
import made  # noqa: E402
from lightformer_train import files, machine, network, network_file  # noqa: E402
from lightformer_train.arguments import Parser, whole  # noqa: E402

VPLS, TEXELS = 128, 2048  # as tools/lightformer/bench_net.c


class Plain(network.Network):
    """Nothing is hoisted: every operand is repeated to the size of the result."""

    def __init__(self, checked, precision):
        super().__init__(checked, precision)
        self.unpacked = set()  # results are unpacked as they are

    def _product(self, operation, weights, inputs, domains, lights):
        out = self._domain(operation["out"])
        x = network._join([network._repeat(part, domain, out, lights) for part, domain in zip(inputs, domains)])
        weight, bias = (weights[f"{operation['name']}.{part}"] for part in ("weight", "bias"))
        if x.dim() == 2:
            total = torch.nn.functional.linear(x, weight, bias)
        else:
            weight = weight if weight.dim() == 4 else weight[:, :, None, None]
            total = torch.nn.functional.conv2d(x, weight, bias, padding=weight.shape[-1] // 2)
        return network._activate(total, operation.get("act", "none"))


def time_of(run) -> float:
    """Milliseconds."""
    start = time.perf_counter()
    run()
    return 1e3 * (time.perf_counter() - start)


def ours(arguments: argparse.Namespace) -> dict:
    """The median frame of a run of the executor."""
    command = [arguments.program, "bench", arguments.network, "--net", "--json", "--frames", "5"]
    command += ["--size", f"{arguments.size}x{arguments.size}", "--lights", str(arguments.lights)]
    command += ["--threads", str(arguments.threads)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode:
        raise files.FileError((done.stderr.strip().splitlines() or [f"{arguments.program}: has failed"])[-1])
    return json.loads(done.stdout)


def parse() -> argparse.Namespace:
    """The command line."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("network", help="a file of weights")
    add("--program", default=str(ROOT / "build/release/bin/lightformer"), help="default %(default)s")
    add("--lights", type=whole(1, 1024), default=2, help="default %(default)s")
    add("--size", type=whole(1, 4096), default=512, help="pixels a side (default %(default)s)")
    add("--threads", type=whole(1, 1024), default=os.cpu_count(), help="of each (default: all cores)")
    add("--rounds", type=whole(1), default=5, help="default %(default)s")
    choices = (machine.AUTO, *machine.PRECISIONS)
    add("--precision", choices=choices, default=machine.AUTO, help='of the products of "best" (default %(default)s)')
    add("--json", action="store_true", help="print JSON")
    return parser.parse_args()


def main() -> int:
    """The command."""
    arguments = parse()
    torch.set_num_threads(arguments.threads)
    try:
        compare(arguments)
    except (files.FileError, OSError) as error:
        print(f"compare_torch: {error}", file=sys.stderr)
        return 1
    return 0


def compare(arguments: argparse.Namespace) -> None:
    """Measures and prints."""
    cpu = torch.device("cpu")
    precision = machine.precision(arguments.precision, cpu)
    print(machine.said(precision, cpu), file=sys.stderr)

    inputs, lights = made.frames([arguments.lights], (arguments.size, arguments.size), 1, vpls=VPLS, texels=TEXELS)
    last = {name: x.contiguous(memory_format=torch.channels_last) if x.dim() == 4 else x for name, x in inputs.items()}
    best, plain = (load(arguments.network, *how) for how in ((network.Network, precision), (Plain, torch.float32)))
    times: dict[str, list[float]] = {"ours": [], "best": [], "plain": []}
    with torch.inference_mode():
        for index in range(arguments.rounds + 1):
            found = ours(arguments)
            round_times = {
                "ours": found["median_ms"]["frame"],
                "best": min(time_of(lambda: best(last, lights)) for _ in range(3)),
                "plain": time_of(lambda: plain(inputs, lights)),
            }
            for name, ms in round_times.items():
                if index:  # the first warms up
                    times[name].append(ms)
    ratios = {
        f"torch_{name}_to_ours": statistics.median(a / b for a, b in zip(times[name], times["ours"]))
        for name in ("best", "plain")
    }
    result = {
        "kernel": found["kernel"],
        "precision": machine.name_of(precision),
        "ms": {name: statistics.median(x) for name, x in times.items()},
        "ratios": ratios,
    }
    if arguments.json:
        print(json.dumps(result, indent=1))
        return
    for name, ms in result["ms"].items():
        print(f"{name:5} {ms:9.1f} ms")
    for name, ratio in ratios.items():
        print(f"{name} {ratio:.2f}")


def load(path: str, kind: type, precision: torch.dtype) -> network.Network:
    """The network of a file, as one of the two."""
    loaded, _ = network_file.load(Path(path))
    made_network = kind(loaded.checked, precision)
    made_network.load_state_dict(loaded.state_dict())
    return made_network.eval()


if __name__ == "__main__":
    sys.exit(main())
