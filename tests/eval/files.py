"""Files for tests, in the test's scratch directory."""

import os

import numpy as np
import OpenEXR

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def scratch(name):
    return os.path.join(os.environ["NG_TEST_DIR"], name)


def write_exr(name, **layers):
    """layers: [height][width][3] by name (beauty is the root), or channels [height][width] as entity__id."""
    channels = {}
    for layer, values in layers.items():
        if values.ndim == 2:
            channels[layer.replace("__", ".")] = np.ascontiguousarray(values)
            continue
        prefix = "" if layer == "beauty" else f"{layer}."
        for i, channel in enumerate("RGB"):
            channels[prefix + channel] = np.ascontiguousarray(values[..., i], np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(scratch(name))
    return scratch(name)


def radiance(width, height, seed):
    """Smooth light with bright spots over several stops."""
    y, x = np.mgrid[:height, :width] / 16.0
    noise = np.random.default_rng(seed).uniform(0.9, 1.1, (height, width, 3))
    base = np.stack([np.exp(1.5 * np.sin(x + y * k)) for k in (0.5, 0.7, 1.1)], axis=-1)
    return (base * noise).astype(np.float32)
