"""What light does and `structured` must do with any weights: light adds up. And what batches must not change."""

import unittest

import torch
import torch.nn.functional as F
from made import frame, frames, join

import numpy as np
from lightformer_train import families, kernels, network_file
from lightformer_train.network import Lights
from lightformer_train.program import INPUTS

BOUND = 1e-3
SIZE = (13, 18)


def of_lights(name: str) -> bool:
    return INPUTS[name].domain in ("light", "vpl", "texel", "view")


def chosen(inputs: dict, lights: list[int]) -> tuple[dict, Lights]:
    """A frame with these of its lights."""
    owner = torch.zeros(len(lights), dtype=torch.long)
    return {name: x[lights] if of_lights(name) else x for name, x in inputs.items()}, Lights(1, owner, {})


class Structured(unittest.TestCase):
    preset = "structured-small"

    def setUp(self):
        torch.manual_seed(7)
        self.network = network_file.create(self.preset).eval()
        self.inputs, self.lights = frames([3], SIZE, seed=1)

    def picture(self, inputs: dict, lights: Lights) -> torch.Tensor:
        with torch.no_grad():
            out = self.network(inputs, lights)
        return torch.cat([out["unshadowed"], out["direct"], out["indirect"]], 1)

    def assert_same(self, a: torch.Tensor, b: torch.Tensor) -> None:
        self.assertGreater(float(b.abs().mean()), 0)
        self.assertLess(float((a - b).abs().max() / b.abs().max()), BOUND)

    def test_order_of_lights(self):
        self.assert_same(self.picture(*chosen(self.inputs, [2, 0, 1])), self.picture(self.inputs, self.lights))

    def test_no_light_is_black(self):
        inputs, lights = frames([0, 0], SIZE, seed=2)
        self.assertEqual(float(self.picture(inputs, lights).abs().max()), 0)

    def test_a_frame_without_light_among_others_is_black(self):
        inputs, lights = frames([2, 0, 1], SIZE, seed=2)
        inputs["frame.radiance"][1] = 0
        picture = self.picture(inputs, lights)
        self.assertEqual(float(picture[1].abs().max()), 0)
        self.assertGreater(float(picture[[0, 2]].abs().amin(0).max()), 0)

    def test_metal_shows_no_light_where_its_rays_meet_nothing(self):
        inputs = dict(self.inputs)
        for name in ("pixel.diffuse", "pixel.mirror", "pixel.mirror_light"):
            inputs[name] = torch.zeros_like(self.inputs[name])
        dark = dict(inputs)
        dark["pixel.mirror_missed"] = torch.ones_like(self.inputs["pixel.mirror_missed"])
        with torch.no_grad():
            self.assertEqual(float(self.network(dark, self.lights)["indirect"].abs().max()), 0)
            self.assertGreater(float(self.network(inputs, self.lights)["indirect"].abs().max()), 0)

    def test_brighter_lights_brighten_the_picture(self):
        brighter = dict(self.inputs)
        for name in ("frame.radiance", "frame.mean_power", "light.power"):
            brighter[name] = self.inputs[name] * 7.5
        self.assert_same(self.picture(brighter, self.lights) / 7.5, self.picture(self.inputs, self.lights))

    def test_two_halves_are_one(self):
        inputs, lights = chosen(self.inputs, [0, 1, 2, 2])
        inputs["light.share"] = inputs["light.share"] * torch.tensor([[1.0], [1.0], [0.5], [0.5]])
        self.assert_same(self.picture(inputs, lights), self.picture(self.inputs, self.lights))

    def test_a_light_without_power_changes_nothing(self):
        inputs, lights = frames([4], SIZE, seed=1)
        inputs["light.share"][1] = 0
        self.assert_same(self.picture(*chosen(inputs, [0, 2, 3])), self.picture(inputs, lights))

    def test_light_adds_up(self):
        """Of direct light, each light's picture alone, at its share, is its part of the whole."""
        whole = self.picture(self.inputs, self.lights)[:, :6]
        parts = [self.picture(*chosen(self.inputs, [i]))[:, :6] for i in range(3)]
        self.assert_same(sum(parts), whole)

    def test_shadows_only_darken(self):
        with torch.no_grad():
            out = self.network(self.inputs, self.lights)
        self.assertTrue(bool((out["direct"] <= out["unshadowed"] + 1e-6).all()))


class Lean(Structured):
    preset = "lean"


class Batches(unittest.TestCase):
    def test_frames_of_a_batch_do_not_meet(self):
        """Each frame alone gives what it gives among others, with another number of lights each."""
        counts = [1, 3, 9, 2]
        random = np.random.default_rng(5)
        parts = [frame(random, count, SIZE) for count in counts]
        for preset in ("lean", "structured-small", "paper-small"):
            torch.manual_seed(1)
            network = network_file.create(preset)
            with torch.no_grad():
                together = network(*join(parts, counts))
                for i, (part, count) in enumerate(zip(parts, counts)):
                    alone = network(*join([part], [count]))
                    for name, picture in alone.items():
                        with self.subTest(preset=preset, frame=i, output=name):
                            bound = 1e-5 * float(picture.abs().max())
                            self.assertLess(float((together[name][i] - picture[0]).abs().max()), bound)

    def test_rows_that_do_not_exist_do_not_count(self):
        inputs, lights = frames([2], SIZE, seed=3, texels=40)
        cut = {name: x[:, :, :25] if INPUTS[name].domain == "texel" else x for name, x in inputs.items()}
        exists = (torch.arange(40) < 25).float().reshape(1, 1, 40, 1).expand(2, -1, -1, -1)
        network = network_file.create("structured-small")
        with torch.no_grad():
            masked = network(inputs, Lights(1, lights.owner, {"texel": exists}))
            fewer = network(cut, lights)
        for name in masked:
            self.assertTrue(torch.allclose(masked[name], fewer[name], rtol=1e-4, atol=1e-6), name)

    def test_every_weight_learns(self):
        """Of all presets that train on CPUs: no operation is left out of the outputs."""
        for preset in ("lean", "structured-small", "paper-small"):
            network = network_file.create(preset)
            out = network(*frames([2], (32, 32), seed=4))
            sum(x.sum() for x in out.values()).backward()
            for name, gradient in network.split(network.parameter.grad).items():
                with self.subTest(preset=preset, weight=name):
                    self.assertGreater(float(gradient.abs().max()), 0)

    def test_bf16_is_near_fp32(self):
        for preset in families.PRESETS:
            if not preset.endswith("small"):
                continue
            torch.manual_seed(2)
            exact = network_file.create(preset)
            rough = network_file.create(preset, precision=torch.bfloat16)
            rough.load_state_dict(exact.state_dict())
            inputs, lights = frames([2], (16, 24), seed=6)
            with torch.no_grad():
                a, b = rough(inputs, lights), exact(inputs, lights)
            for name in a:
                error = float(((a[name] - b[name]) ** 2).mean() / (b[name] ** 2).mean())
                self.assertLess(error, 1e-5, f"{preset} {name}")


class Kernels(unittest.TestCase):
    """What is done by hand is what PyTorch does, and so are its gradients."""

    def compare(self, ours, theirs, *shapes, last: bool = False) -> None:
        torch.manual_seed(7)
        inputs = [torch.randn(shape, dtype=torch.float64, requires_grad=True) for shape in shapes]
        first = inputs[0].contiguous(memory_format=torch.channels_last) if last else inputs[0]
        values = [f(first, *inputs[1:]) for f in (ours, theirs)]
        self.assertTrue(torch.allclose(*values))
        weight = torch.randn_like(values[0])
        gradients = [torch.autograd.grad((value * weight).sum(), inputs, retain_graph=True) for value in values]
        for a, b in zip(*gradients):
            self.assertTrue(torch.allclose(a, b))

    def test_products(self):
        self.compare(
            kernels.multiply,
            lambda x, weight, bias: F.conv2d(x, weight[:, :, None, None], bias),
            *((3, 5, 6, 7), (4, 5), (4,)),
            last=True,
        )

    def test_gradients_of_many_rows_are_added_in_parts(self):
        a, b = torch.randn(kernels.PARTS * 256, 3), torch.randn(kernels.PARTS * 256, 5)
        self.assertTrue(torch.allclose(kernels._sum_of_products(a, b), a.t() @ b, rtol=1e-3, atol=1e-3))

    def test_sizes(self):
        def pool(x: torch.Tensor) -> torch.Tensor:
            return F.avg_pool2d(x, 2, ceil_mode=True, count_include_pad=False)

        def up(x: torch.Tensor) -> torch.Tensor:
            return F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)

        for size in ((6, 8), (5, 7), (1, 3)):
            for last in (False, True):
                with self.subTest(size=size, last=last):
                    self.compare(kernels.halve, pool, (2, 3, *size), last=last)
                    self.compare(kernels.double, up, (2, 3, *size), last=last)

    def test_packing(self):
        self.compare(kernels.pack, lambda x: F.pixel_unshuffle(x, 2), (2, 3, 6, 8))

        def blocks(x: torch.Tensor) -> torch.Tensor:
            return kernels.unpack_blocks(x.unflatten(1, (-1, 4)).transpose(1, 2).flatten(1, 2))

        for last in (False, True):
            self.compare(blocks, lambda x: F.pixel_shuffle(x, 2), (2, 12, 3, 4), last=last)

    def test_lights_of_frames(self):
        owner = torch.tensor([0, 0, 2])
        for last in (False, True):
            self.compare(lambda x: kernels.of_lights(x, owner), lambda x: x[owner], (3, 4, 5, 6), last=last)
            self.compare(
                lambda x: kernels.over_lights(x, owner, 3),
                lambda x: torch.stack([x[:2].sum(0), 0 * x[0], x[2]]),
                (3, 4, 5, 6),
                last=last,
            )
