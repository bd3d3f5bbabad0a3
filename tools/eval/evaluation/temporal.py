"""Temporal error: what changes from frame to frame beyond what changes in the reference.

Each frame is compared with the frame before it, moved along the reference's motion (pixel now - pixel before):
D(X) = X_t - warp(X_(t-1)). The error is mean(|D(A) - D(B)|) / mean(B): a steady difference costs nothing, flicker
and lag do. Pixels whose origin is outside the picture or, where the reference has entity.id, on another entity
have no history and do not count.
"""

import numpy as np
from scipy.ndimage import map_coordinates

from . import BadInput
from .pictures import read_planes


def read_motion(path):
    """Motion [height][width][2] (x right, y down) and entity ids or None, of a reference's frame."""
    planes = read_planes(path)
    if not ("motion.X" in planes and "motion.Y" in planes):
        raise BadInput(f"{path}: no layer motion, which a sequence's reference needs: render it with --aov motion,entity")
    motion = np.stack([planes["motion.X"], planes["motion.Y"]], axis=-1).astype(np.float64)
    return motion, planes.get("entity.id")


def temporal_error(before, now, motion, entities_before=None, entities_now=None):
    """Of two comparisons that follow each other; None if no pixel has a history."""
    x, y = _origin(motion)
    height, width = motion.shape[:2]
    counted = now.mask & np.isfinite(x + y) & (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)
    x, y = np.where(counted, x, 0), np.where(counted, y, 0)
    nearest = np.rint(y).astype(int), np.rint(x).astype(int)
    counted &= before.mask[nearest]
    if entities_before is not None and entities_now is not None:
        counted &= entities_before[nearest] == entities_now
    if not counted.any():
        return None
    change_a = now.a.pixels - _warp(before.a.pixels, x, y)
    change_b = now.reference - _warp(before.reference, x, y)
    return float(np.abs(change_a - change_b)[counted].mean() / now.mean)


def _origin(motion):
    """Where each pixel was in the frame before."""
    y, x = np.mgrid[: motion.shape[0], : motion.shape[1]]
    return x - motion[..., 0], y - motion[..., 1]


def _warp(picture, x, y):
    """Bilinear samples of every channel."""
    return np.stack([map_coordinates(picture[..., i], (y, x), order=1) for i in range(3)], axis=-1)
