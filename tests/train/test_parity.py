"""Both executors run the same list: `lightformer net run` against PyTorch, on random weights and inputs.

NMSE = sum (a - b)^2 / sum b^2 of each output: at most 1e-7 in fp32, 1e-5 with bf16 products.
"""

import os
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np
import torch
from made import ROOT, frame, join

from lightformer_train import families, network_file, program, weights
from lightformer_train.builder import Builder
from lightformer_train.network import Network

SCRATCH = Path(os.environ["NG_TEST_DIR"])
LIGHTFORMER = os.environ["LIGHTFORMER"]
FP32_BOUND = 1e-7
BF16_BOUND = 1e-5


def run_c(network: Network, values: dict[str, np.ndarray], kernel: str) -> dict[str, torch.Tensor] | None:
    """The outputs of lightformer; None where this CPU has no such kernel."""
    weights_path, inputs_path, out_path = (SCRATCH / f"{name}.safetensors" for name in ("network", "inputs", "out"))
    network_file.save(weights_path, network, {"family": "test"})
    weights.write(inputs_path, by_light(values), {})
    paths = [str(weights_path), "--run", str(inputs_path), "-o", str(out_path)]
    command = [LIGHTFORMER, "net", *paths, "--kernel", kernel]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "does not run on this CPU" in done.stderr:
        return None
    if done.returncode:
        raise AssertionError(done.stderr)
    tensors, _ = weights.read(out_path)
    return {name: torch.from_numpy(tensors[name].copy()) for name in program.OUTPUTS}


def by_light(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """A frame's inputs as lightformer takes them: those of a light behind its number."""
    found = {}
    for name, array in values.items():
        if program.INPUTS[name].domain in ("frame", "pixel"):
            found[name] = array
        else:
            found |= {f"light.{i}/{name}": light for i, light in enumerate(array)}
    return found


def nmse(a: torch.Tensor, b: torch.Tensor) -> float:
    difference, size = float(((a - b).double() ** 2).sum()), float((b.double() ** 2).sum())
    return difference / size if size else difference


class Parity(unittest.TestCase):
    def compare(self, network: Network, values: dict[str, np.ndarray], kernel: str, bound: float) -> None:
        found = run_c(network, values, kernel)
        if found is None:
            self.skipTest(f"no {kernel} on this CPU")
        with torch.no_grad():
            expected = network(*join([values], [len(values["light.share"])]))
        for name, picture in expected.items():
            self.assertLessEqual(nmse(found[name], picture[0]), bound, name)


def to_outputs(b: Builder, value: str) -> Network:
    """A network whose outputs show any value."""
    placeholder = [
        {"op": "affine", "in": ["pixel.diffuse"], "out": name, "scale": 1.0, "offset": 0.0} for name in program.OUTPUTS
    ]
    found = program.check([*b.operations, *placeholder]).values[value]
    if found.domain in program.ROWS:
        value = b.apply("mean", value)
    if found.domain in ("light", "view", *program.ROWS):
        value = b.apply("sum", value, "light.share")
    if found.domain in program.PICTURES:
        value = b.up(value, found.level)
    seen = b.linear("show", [value, "pixel.mask"], 3, act="none")
    for scale, name in zip((1.0, 2.0, 3.0), program.OUTPUTS):
        b.apply("affine", seen, out=name, scale=scale, offset=0.0)
    return Network(program.check(b.operations))


def operations() -> dict[str, tuple]:
    """Name -> a function that writes the operation and returns its result."""

    def product(op: str, *inputs: str, act: str = "none", channels: int = 5):
        return lambda b: b.apply(op, *inputs, name="x", channels=channels, act=act)

    def plain(op: str, *inputs: str, **parameters: object):
        return lambda b: b.apply(op, *inputs, **parameters)

    def packed(op: str):
        return lambda b: b.apply(op, b.linear("wide", [b.apply("pack", "view.diffuse")], 8, act="none"))

    cases = {f"linear {act}": product("linear", "pixel.normal", act=act) for act in program.ACTIVATIONS}
    cases |= {f"conv {act}": product("conv", "view.diffuse", act=act) for act in program.ACTIVATIONS}
    cases |= {
        "linear of frame": product("linear", "frame.radiance"),
        "linear of light": product("linear", "light.color", "frame.radiance"),
        "linear of vpl": product("linear", "vpl.normal", "light.color", channels=33),
        "linear of texel": product("linear", "texel.normal", "texel.flux", "frame.mean_power", channels=17),
        "linear of all": product(
            "linear", "pixel.normal", "view.diffuse", "light.color", "frame.radiance", channels=65
        ),
        "linear, domains mixed": product("linear", "light.color", "view.glossy", "pixel.diffuse", "view.bounce"),
        "linear, pixel and light": product("linear", "pixel.diffuse", "light.color"),
        "conv of pixel": product("conv", "pixel.diffuse", "pixel.normal", channels=34),
        "conv of both": product("conv", "pixel.diffuse", "view.glossy", channels=7),
        "concat": plain("concat", "light.color", "view.glossy", "pixel.roughness"),
        "slice": plain("slice", "view.glossy", **{"from": 1, "to": 3}),
        "affine": plain("affine", "view.glossy", scale=-1.5, offset=0.25),
        "clamp": plain("clamp", "view.glossy", low=0.2, high=0.6),
        "dot": plain("dot", "pixel.normal", "view.direction"),
        "length": plain("length", "pixel.position"),
        "normalize": plain("normalize", "vpl.offset"),
        "mean": plain("mean", "texel.flux"),
        "pool": plain("pool", "view.glossy"),
        "pack": plain("pack", "pixel.normal"),
        "up": packed("up"),
        "unpack": packed("unpack"),
        "deep pool": lambda b: b.pool("view.glossy", 3),
        "sum": plain("sum", "view.diffuse"),
        "sum, weighted": plain("sum", "view.diffuse", "light.share"),
        "sum of light": plain("sum", "light.color", "light.share"),
    }
    cases |= {f"{op} by channel": plain(op, "view.glossy", "pixel.normal") for op in program.BINARY if op != "div"}
    cases |= {f"{op} by one": plain(op, "pixel.normal", "light.share") for op in program.BINARY if op != "div"}
    cases["div"] = lambda b: b.apply("div", "pixel.normal", b.affine("view.distance", 1.0, 0.5))
    for op in program.UNARY:
        cases[op] = lambda b, op=op: b.apply(op, b.affine("view.bounce", *((1.0, 0.0) if "log" in op else (6.0, -3.0))))
    for gate in ("sigmoid", "softmax"):
        for weight in ((), ("light.share",)):
            cases[f"attend {gate} {len(weight)}"] = lambda b, gate=gate, weight=weight: b.apply(
                "attend",
                b.linear("q", ["pixel.normal"], 8, act="none"),
                b.linear("k", ["light.color"], 8, act="none"),
                b.linear("v", ["view.diffuse"], 12, act="none"),
                *weight,
                heads=4,
                gate=gate,
            )
    return cases


class Operations(Parity):
    def test_each(self):
        values = frame(np.random.default_rng(1), 3, (13, 21))
        for name, write in operations().items():
            with self.subTest(name):
                torch.manual_seed(4)
                b = Builder()
                self.compare(to_outputs(b, write(b)), values, "plain", FP32_BOUND)

    def test_rows_of_no_light_and_of_no_texel(self):
        for lights, texels in ((0, 4), (2, 0)):
            with self.subTest(lights=lights, texels=texels):
                torch.manual_seed(4)
                network = network_file.create("structured-small")
                values = frame(np.random.default_rng(1), lights, (13, 21), texels=texels)
                self.compare(network, values, "plain", FP32_BOUND)


class Families(Parity):
    def networks(self):
        for preset in ("lean", "structured-small", "paper-small"):
            for without in (frozenset(), *(frozenset([part]) for part in families.parts(preset))):
                torch.manual_seed(5)
                yield preset, without, network_file.create(preset, without)

    def test_every_ablation(self):
        values = frame(np.random.default_rng(2), 2, (17, 22))
        for preset, without, network in self.networks():
            with self.subTest(preset=preset, without=without):
                self.compare(network, values, "plain", FP32_BOUND)

    def test_sizes_and_lights(self):
        torch.manual_seed(6)
        network = network_file.create("structured-small")
        for lights, size in ((1, (1, 1)), (2, (3, 17)), (5, (16, 16)), (9, (33, 47)), (3, (64, 31))):
            for kernel in ("plain", "avx2", "avx512"):
                with self.subTest(lights=lights, size=size, kernel=kernel):
                    values = frame(np.random.default_rng(lights), lights, size)
                    self.compare(network, values, kernel, FP32_BOUND)

    def test_bf16(self):
        for preset in ("lean", "structured-small", "paper-small"):
            torch.manual_seed(7)
            network = network_file.create(preset)
            values = frame(np.random.default_rng(7), 3, (40, 56))
            for kernel in ("bf16", "amx"):
                with self.subTest(preset=preset, kernel=kernel):
                    self.compare(network, values, kernel, BF16_BOUND)

    def test_large_presets(self):
        for preset in ("structured", "paper"):
            with self.subTest(preset):
                torch.manual_seed(8)
                values = frame(np.random.default_rng(8), 2, (12, 20))
                self.compare(network_file.create(preset), values, "plain", FP32_BOUND)


class PlainForm(unittest.TestCase):
    """What tests/net/compare_torch.py compares speed with."""

    def test_it_gives_the_same(self):
        sys.path.append(str(ROOT / "tests/net"))
        from compare_torch import Plain

        values = join([frame(np.random.default_rng(9), 2, (17, 22))], [2])
        for preset in ("lean", "structured-small", "paper-small"):
            torch.manual_seed(9)
            network = network_file.create(preset)
            plain = Plain(network.checked, torch.float32)
            plain.load_state_dict(network.state_dict())
            with torch.no_grad():
                found, expected = plain(*values), network(*values)
            for name, picture in expected.items():
                self.assertLessEqual(nmse(found[name], picture), FP32_BOUND, (preset, name))
