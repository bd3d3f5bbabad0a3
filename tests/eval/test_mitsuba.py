"""The path tracer against Mitsuba 3: the same scenes, pixel by pixel, in standard deviations.

Both take independent samples, so that the variance of each pixel is known, and z = (ours - theirs) / deviation has a
mean of 0 and a deviation of 1 where both renderers converge to the same. Figures are printed; pictures (ours, theirs, z
from -5, blue, to 5, red) are left in the test's scratch directory.
"""

import os
import subprocess
import tempfile
import unittest
from dataclasses import dataclass

import numpy as np
from evaluation import pictures, tonemap
from files import ROOT, scratch
from PIL import Image

os.environ["HOME"] = scratch("")  # where Mitsuba's compiler keeps what it has compiled; read when it is imported
from crosscheck import estimate, gltf, scene  # noqa: E402

SIZE = 96
BLOCK = 8
ROUNDING = 1e-4  # of radiance in fp32: sharp highlights of point lights have no noise


@dataclass
class Comparison:
    ours: np.ndarray
    theirs: np.ndarray
    deviation: np.ndarray  # of the difference

    def z(self):
        """[height][width][3]; 0 where both are black."""
        return (self.ours - self.theirs) / np.maximum(self.deviation, 1e-12)

    def lit_z(self):
        """[n], where there is light."""
        return self.z()[(self.ours > 0) | (self.theirs > 0)]

    def blocks(self):
        """z of the sums over blocks of pixels: what is wrong by little, but in one place."""
        height, width, _ = self.ours.shape
        difference, variance = (
            x.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).sum(axis=(1, 3))
            for x in (self.ours - self.theirs, self.deviation**2)
        )
        return difference / np.sqrt(np.maximum(variance, 1e-24))

    def relative(self):
        return self.ours.mean() / self.theirs.mean() - 1

    def relative_deviation(self):
        """Of `relative`, if the channels of a pixel vary together."""
        return np.sqrt((self.deviation**2).sum(axis=(0, 1))).sum() / self.theirs.sum()


def render_ours(path, time, samples, depth):
    with tempfile.NamedTemporaryFile(suffix=".exr", dir=scratch("")) as out:
        command = [os.environ["LIGHTFORMER"], "render", path, "--method", "reference", "--sampler", "independent"]
        command += ["--size", f"{SIZE}x{SIZE}", "--spp", str(samples), "--time", str(time)]
        command += ["--depth", str(depth)]
        subprocess.run([*command, "--aov", "variance", "-o", out.name], check=True, capture_output=True)
        return pictures.load(out.name).pixels, pictures.load(out.name, "variance").pixels


def render_theirs(path, time, samples, depth):
    with tempfile.NamedTemporaryFile(suffix=".safetensors", dir=scratch("")) as out:
        subprocess.run([os.environ["REFINED_TRIANGLES"], path, out.name], check=True)
        refined = gltf.read_refined(out.name)
    document = gltf.Document(path, time)
    return estimate.render(scene.build(document, refined), document.camera(), (SIZE, SIZE), samples, depth or -1)


def compare(what, columns):
    """what: scene, time, samples, depth; columns: of the picture, from the left."""
    ours, our_variance, theirs, their_variance = (x[:, :columns] for x in (*render_ours(*what), *render_theirs(*what)))
    deviation = np.sqrt(our_variance + their_variance + (ROUNDING * theirs) ** 2)
    return Comparison(ours, theirs, deviation)


def write_picture(name, c):
    exposure = tonemap.MIDDLE_GREY / c.theirs.mean()
    z = np.clip(c.z().mean(axis=-1, keepdims=True) / 5, -1, 1)
    z_map = np.concatenate([1 + np.minimum(z, 0), 1 - abs(z), 1 - np.maximum(z, 0)], axis=-1)
    row = np.concatenate([*(tonemap.show(x, exposure, False) for x in (c.ours, c.theirs)), z_map], axis=1)
    picture = Image.fromarray((row * 255 + 0.5).astype(np.uint8))
    picture.resize((picture.width * 3, picture.height * 3), Image.Resampling.NEAREST).save(scratch(f"{name}.png"))


class Mitsuba(unittest.TestCase):
    def check(self, scene_name, time=0.0, samples=256, depth=0, columns=SIZE):
        """depth: of the longest path; 0: any."""
        c = compare((os.path.join(ROOT, "content", f"{scene_name}.glb"), time, samples, depth), columns)
        name = self.id().rsplit(".test_", 1)[1]
        z, blocks = c.lit_z(), c.blocks()
        outside = (abs(z) > 3).mean()
        print(
            f"\n{name}: mean {100 * c.relative():+.3f} % (deviation {100 * c.relative_deviation():.3f} %); "
            f"z: mean {z.mean():+.3f}, deviation {z.std():.3f}, beyond 3: {100 * outside:.2f} %, "
            f"largest {abs(z).max():.1f}, of blocks {abs(blocks).max():.1f}",
            flush=True,
        )
        write_picture(name, c)
        self.assertLess(abs(c.relative()), min(0.01, 5 * c.relative_deviation()))
        self.assertLess(abs(z.mean()), 0.1)
        self.assertLess(z.std(), 1.05)
        self.assertLess(outside, 0.006)  # 0.0027 of a normal distribution
        self.assertLess(abs(blocks).max(), 5)

    def test_chess(self):
        self.check("chess/chess", time=2.5, samples=128)

    def test_point(self):
        self.check("unit/light_point")

    def test_spot(self):
        self.check("unit/light_spot", samples=512)

    def test_directional(self):
        self.check("unit/light_directional")

    def test_rectangle(self):
        self.check("unit/light_rectangle")

    def test_rectangle_textured(self):
        self.check("unit/light_rectangle_textured")

    def test_disk(self):
        self.check("unit/light_disk")

    def test_sphere(self):
        self.check("unit/light_sphere")

    def test_mesh_textured(self):
        self.check("unit/light_mesh")

    def test_environment(self):
        self.check("unit/light_environment")

    def test_textures(self):
        self.check("unit/textures")

    def test_glossy(self):
        self.check("unit/materials")

    def test_glossy_direct(self):
        """Without what several bounces add to the noise, the BRDF alone decides."""
        self.check("unit/materials", samples=512, depth=2)

    def test_normal_map(self):
        """The panel on the left: on the ball, Mitsuba ends light at the interpolated normal, not at the triangle's."""
        self.check("unit/normal_map", columns=SIZE // 2)

    def test_sides(self):
        """The camera looks through the back of a one-sided surface; no other ray does."""
        self.check("unit/double_sided")

    def test_mirrored(self):
        self.check("unit/mirrored")
