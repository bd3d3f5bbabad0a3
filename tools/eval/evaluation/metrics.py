"""RSE, L1, PSNR and the ratio of means, as lightformer/metrics/README.md defines them."""

import numpy as np

RSE_EPSILON = 0.01


def rse_map(c):
    """Relative squared error of each pixel and channel; its mean over counted pixels is the RSE."""
    a, b, b1 = (x / c.mean for x in (c.a.pixels, c.reference, c.b.pixels))
    b2 = b1 if c.b2 is None else c.b2.pixels / c.mean
    return (a - b1) * (a - b2) / (b * b + RSE_EPSILON)


def l1_map(c):
    """Absolute difference over the reference's mean, of each pixel and channel."""
    return np.abs(c.a.pixels - c.reference) / c.mean


def compute(c):
    """The four figures of `lightformer compare`; PSNR None where the pictures are equal."""
    square = ((c.shown_a - c.shown_b)[c.mask] ** 2).mean()
    return {
        "rse": float(rse_map(c)[c.mask].mean()),
        "l1": float(l1_map(c)[c.mask].mean()),
        "psnr": float(-10 * np.log10(square)) if square > 0 else None,
        "mean_ratio": float(c.a.pixels[c.mask].mean() / c.mean),
    }
