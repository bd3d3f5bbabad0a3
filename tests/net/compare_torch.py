#!/usr/bin/python3
"""How much faster a network runs than in PyTorch: the same weights, pixels, lights and threads.

    tests/net/compare_torch.py NETWORK [--lights 2] [--size 512] [--threads 2] [--rounds 5] [--json]

The executors take turns, round by round, so that all see the same machine; ratios are medians over rounds. "bf16" is PyTorch's best
setting: bf16, channels last, what is the same for all pixels of a light multiplied once. "fp32" is the plain form: fp32 eager, every
operand repeated and concatenated.
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
from lightformer_train import network, network_file  # noqa: E402

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
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("network")
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/lightformer"))
    parser.add_argument("--lights", type=int, default=2)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)

    inputs, lights = made.frames([arguments.lights], (arguments.size, arguments.size), 1, vpls=VPLS, texels=TEXELS)
    last = {name: x.contiguous(memory_format=torch.channels_last) if x.dim() == 4 else x for name, x in inputs.items()}
    fast, plain = (load(arguments.network, *how) for how in ((network.Network, torch.bfloat16), (Plain, torch.float32)))
    times: dict[str, list[float]] = {"ours": [], "bf16": [], "fp32": []}
    with torch.inference_mode():
        for index in range(arguments.rounds + 1):
            found = ours(arguments)
            round_times = {
                "ours": found["median_ms"]["frame"],
                "bf16": min(time_of(lambda: fast(last, lights)) for _ in range(3)),
                "fp32": time_of(lambda: plain(inputs, lights)),
            }
            for name, ms in round_times.items():
                if index:  # the first warms up
                    times[name].append(ms)
    ratios = {
        f"torch_{name}_to_ours": statistics.median(a / b for a, b in zip(times[name], times["ours"]))
        for name in ("bf16", "fp32")
    }
    result = {"kernel": found["kernel"], "ms": {name: statistics.median(x) for name, x in times.items()}, "ratios": ratios}
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
    main()
