"""SSIM, MS-SSIM, FLIP and HDR-FLIP.

SSIM: Wang et al. 2004, Gaussian window of 11 x 11 with sigma 1.5, by scikit-image. MS-SSIM: Wang et al. 2003, five
scales with the paper's weights. FLIP: Andersson et al. 2020; HDR-FLIP: 2021, both by their authors' package, at
67 pixels per degree. All but HDR-FLIP look at tone-mapped pictures; HDR-FLIP chooses its exposures itself.
"""

import flip_evaluator
import numpy as np
from scipy.ndimage import gaussian_filter
from skimage.metrics import structural_similarity

SIGMA, RADIUS = 1.5, 5  # 11 taps
SCALE_WEIGHTS = 0.0448, 0.2856, 0.3001, 0.2363, 0.1333
MS_SSIM_MIN_SIDE = (2 * RADIUS + 1) * 2 ** (len(SCALE_WEIGHTS) - 1)  # 176: one window at the coarsest scale
C1, C2 = 0.01**2, 0.03**2  # for values in 0..1


def ssim(c):
    """Mean over counted pixels with a whole window around them; None if there are none."""
    if min(c.b.size) < 2 * RADIUS + 1:
        return None
    _, values = structural_similarity(c.shown_a, c.shown_b, full=True, channel_axis=-1, data_range=1.0,
                                      gaussian_weights=True, sigma=SIGMA, use_sample_covariance=False)
    inside = values[RADIUS:-RADIUS, RADIUS:-RADIUS][c.mask[RADIUS:-RADIUS, RADIUS:-RADIUS]]
    return float(inside.mean()) if inside.size else None


def ms_ssim(c):
    """None under 176 pixels, and with a mask: coarse scales would look at what it leaves out."""
    if min(c.b.size) < MS_SSIM_MIN_SIDE or not c.whole:
        return None
    return float(np.mean([_ms_ssim_channel(c.shown_a[..., i], c.shown_b[..., i]) for i in range(3)]))


def _ms_ssim_channel(a, b):
    product = 1.0
    for scale, weight in enumerate(SCALE_WEIGHTS):
        luminance, structure = _similarity(a, b)
        coarsest = scale == len(SCALE_WEIGHTS) - 1
        value = (luminance * structure if coarsest else structure).mean()
        product *= max(value, 0.0) ** weight  # a negative structure has no real power
        a, b = _halve(a), _halve(b)
    return product


def _similarity(a, b):
    """The luminance and the contrast-structure term where the window is whole."""
    def blur(x):
        return gaussian_filter(x, SIGMA, radius=RADIUS)[RADIUS:-RADIUS, RADIUS:-RADIUS]

    mean_a, mean_b = blur(a), blur(b)
    variance_a, variance_b = blur(a * a) - mean_a**2, blur(b * b) - mean_b**2
    covariance = blur(a * b) - mean_a * mean_b
    luminance = (2 * mean_a * mean_b + C1) / (mean_a**2 + mean_b**2 + C1)
    structure = (2 * covariance + C2) / (variance_a + variance_b + C2)
    return luminance, structure


def _halve(x):
    """Means of 2 x 2 pixels; an odd last row or column is left out."""
    x = x[: x.shape[0] // 2 * 2, : x.shape[1] // 2 * 2]
    return 0.25 * (x[::2, ::2] + x[1::2, ::2] + x[::2, 1::2] + x[1::2, 1::2])


def flip_map(c):
    """FLIP of each pixel, 0..1."""
    return _flip(c.shown_b, c.shown_a, "LDR")


def hdr_flip_map(c):
    """HDR-FLIP of each pixel, 0..1; None for pictures of a display."""
    if c.b.display:
        return None
    return _flip(np.maximum(c.reference, 0), np.maximum(c.a.pixels, 0), "HDR")


def _flip(reference, test, kind):
    values, _, _ = flip_evaluator.evaluate(np.float32(reference), np.float32(test), kind, inputsRGB=kind == "LDR",
                                           applyMagma=False, computeMeanError=False)
    return values[..., 0] if values.ndim == 3 else values
