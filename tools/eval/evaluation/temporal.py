"""Temporal error: what changes from frame to frame beyond what changes in the reference.

Each frame is compared with the frame before it, moved along the reference's motion (pixel now - pixel before):
D(X) = X_t - warp(X_(t-1)). The error is mean(|D(A) - D(B)|) / mean(B): a steady difference costs nothing, flicker
and lag do. Pixels whose origin is outside the picture or, where the reference has entity.id, on another entity
have no history and do not count.
"""

from dataclasses import dataclass

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


@dataclass(frozen=True)
class History:
    """Where each pixel was in the frame before (x, y), and whether it counts."""

    x: np.ndarray
    y: np.ndarray
    counted: np.ndarray

    def change(self, before, now):
        """X_t - warp(X_(t-1)) of each counted pixel."""
        moved = [map_coordinates(before[..., i], (self.y, self.x), order=1) for i in range(3)]
        return (now - np.stack(moved, axis=-1))[self.counted]


def find_history(motion, mask_before, mask_now, entities_before=None, entities_now=None):
    """None if no pixel has a history. Entities may be unknown."""
    height, width = motion.shape[:2]
    y, x = np.mgrid[:height, :width]
    x, y = x - motion[..., 0], y - motion[..., 1]
    counted = mask_now & np.isfinite(x + y) & (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)
    x, y = np.where(counted, x, 0), np.where(counted, y, 0)
    nearest = np.rint(y).astype(int), np.rint(x).astype(int)
    counted &= mask_before[nearest]
    if entities_before is not None and entities_now is not None:
        counted &= entities_before[nearest] == entities_now
    return History(x, y, counted) if counted.any() else None


def temporal_error(before, now, motion, entities_before=None, entities_now=None):
    """Of two comparisons that follow each other; None if no pixel has a history."""
    history = find_history(motion, before.mask, now.mask, entities_before, entities_now)
    if history is None:
        return None
    change = history.change(before.a.pixels, now.a.pixels) - history.change(before.reference, now.reference)
    return float(np.abs(change).mean() / now.mean)
