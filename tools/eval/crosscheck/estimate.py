"""Pictures by Mitsuba's path integrator, with the variance of every pixel."""

import drjit as dr
import mitsuba as mi
import numpy as np


def render(scene, camera, size, samples, seed=0):
    """The mean of `samples` paths a pixel and its variance, both [height][width][3].

    camera: placement, vertical field of view in radians; size: width, height. Paths start at the pixels' centres: the
    integrator is called without a sensor and a film, which would put them elsewhere.
    """
    width, height = size
    count = width * height * samples
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    integrator = mi.load_dict({"type": "path", "max_depth": -1})
    radiance, _, _ = integrator.sample(scene, sampler, _pixel_centres(camera, width, height, count))
    values = np.moveaxis(np.array(radiance, np.float64).reshape(3, samples, height, width), 0, -1)
    return values.mean(axis=0), values.var(axis=0, ddof=1) / samples


def _pixel_centres(camera, width, height, count):
    """Rays through all pixels row by row, again and again."""
    matrix, fov = camera
    pixel = dr.arange(mi.UInt32, count) % (width * height)
    x, y = mi.Float(pixel % width) + 0.5, mi.Float(pixel // width) + 0.5
    tangent = np.tan(fov / 2)
    toward = mi.Vector3f((2 * x / width - 1) * tangent * (width / height), (1 - 2 * y / height) * tangent, -1)
    turned = mi.Matrix3f(matrix[:3, :3].tolist()) @ toward
    return mi.RayDifferential3f(o=mi.Point3f(matrix[:3, 3].tolist()), d=dr.normalize(turned))
