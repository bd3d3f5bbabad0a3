"""A picture beside its reference, checked, with what every metric starts from."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from . import BadInput
from .tonemap import MIDDLE_GREY, show


@dataclass(frozen=True)
class Comparison:
    """a is judged, b the reference, b2 a second one or None; mask: [height][width], bool."""

    a: object
    b: object
    b2: object
    mask: np.ndarray

    @cached_property
    def reference(self):
        """The mean of the references."""
        return self.b.pixels if self.b2 is None else 0.5 * (self.b.pixels + self.b2.pixels)

    @cached_property
    def mean(self):
        """Of the reference, over counted pixels and channels."""
        return self.reference[self.mask].mean()

    @property
    def exposure(self):
        """Puts the reference's mean to middle grey; 1 for pictures of a display."""
        return 1.0 if self.b.display else MIDDLE_GREY / self.mean

    @cached_property
    def shown_a(self):
        return show(self.a.pixels, self.exposure, self.b.display)

    @cached_property
    def shown_b(self):
        return show(self.reference, self.exposure, self.b.display)

    @property
    def whole(self):
        """Whether every pixel counts."""
        return bool(self.mask.all())


def prepare(a, b, b2=None, mask=None):
    """Checks what lightformer/metrics/metrics.h checks, and says it in the same way. mask: a picture or None."""
    if mask is not None:
        _check_size(mask, b)
    counted = np.ones(b.pixels.shape[:2], bool) if mask is None else (mask.pixels != 0).any(axis=-1)
    if not counted.any():
        raise BadInput(f"{mask.name}: the mask is 0 everywhere, so that no pixel is left to compare")
    pictures = [a, b] if b2 is None else [a, b, b2]
    for picture in pictures:
        _check_size(picture, b)
        _check_kind(picture, b)
        _check_finite(picture, counted)
    comparison = Comparison(a, b, b2, counted)
    if not comparison.mean > 0:
        raise BadInput(f"{b.name}: the mean is {comparison.mean:g}, but errors are relative to a reference's light, "
                       "which must be positive")
    return comparison


def _check_size(p, b):
    if p.size != b.size:
        raise BadInput(f"{p.name} is {p.size[0]} x {p.size[1]} pixels, but {b.name} is {b.size[0]} x {b.size[1]}: "
                       "only pictures of one size can be compared")


def _check_kind(p, b):
    if p.display != b.display:
        png, exr = (p, b) if p.display else (b, p)
        raise BadInput(f"{png.name} is tone-mapped and {exr.name} is radiance: compare two PNG or two OpenEXR files")


def _check_finite(p, counted):
    bad = counted & ~np.isfinite(p.pixels).all(axis=-1)
    if bad.any():
        y, x = np.argwhere(bad)[0]
        value = " ".join(f"{v:g}" for v in p.pixels[y, x])
        raise BadInput(f"{p.name}: pixel ({x}, {y}) is {value}; pixels that are not finite: {bad.sum()}")
