"""Temporal error in closed form."""

import unittest

import numpy as np
from files import radiance

from evaluation.comparison import prepare
from evaluation.pictures import Picture
from evaluation.temporal import temporal_error

SIZE = 24
STILL = np.zeros((SIZE, SIZE, 2))


def frame(a, b):
    return prepare(Picture("a", np.float64(a)), Picture("b", np.float64(b)))


class Temporal(unittest.TestCase):
    def setUp(self):
        self.b = np.float64(radiance(SIZE, SIZE, 3))

    def test_steady_difference_costs_nothing(self):
        before, now = frame(self.b + 0.5, self.b), frame(self.b + 0.5, self.b)
        self.assertAlmostEqual(temporal_error(before, now, STILL), 0)

    def test_flicker(self):
        """A goes from B - c to B + c: 2 c over the mean."""
        before, now = frame(self.b - 0.25, self.b), frame(self.b + 0.25, self.b)
        self.assertAlmostEqual(temporal_error(before, now, STILL), 0.5 / self.b.mean())

    def test_lag(self):
        """The reference brightens, A does not."""
        before, now = frame(self.b, self.b), frame(self.b, self.b + 1)
        self.assertAlmostEqual(temporal_error(before, now, STILL), 1 / (self.b + 1).mean())

    def test_motion(self):
        """A's own error moves along with the picture, 3 pixels right and 2 down: no flicker; without motion, some."""
        error = np.float64(radiance(SIZE, SIZE, 4))
        moved = [np.roll(x, (2, 3), axis=(0, 1)) for x in (self.b + error, self.b)]
        before, now = frame(self.b + error, self.b), frame(*moved)
        motion = STILL + (3, 2)
        self.assertAlmostEqual(temporal_error(before, now, motion), 0)
        self.assertGreater(temporal_error(before, now, STILL), 0.01)

    def test_no_history(self):
        """Flicker on another entity's ground, or from outside of the picture, has no history to differ from."""
        before, now = frame(self.b, self.b), frame(self.b + 1, self.b)
        entities = np.zeros((SIZE, SIZE), np.uint32)
        self.assertIsNone(temporal_error(before, now, STILL, entities, entities + 1))
        self.assertIsNone(temporal_error(before, now, STILL + (SIZE, 0)))
