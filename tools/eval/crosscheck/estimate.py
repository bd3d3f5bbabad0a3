"""Pictures by Mitsuba's path integrator, with the variance of every pixel."""

import drjit as dr
import mitsuba as mi
import numpy as np

LAYERS = 8  # of surfaces that the camera looks through at most


def render(scene, camera, size, samples, depth=-1, seed=0):
    """The mean of `samples` paths a pixel and its variance, both [height][width][3].

    camera: placement, vertical field of view in radians; size: width, height; depth: of the longest path, -1: any.
    Paths start at the pixels' centres: the integrator is called without a sensor and a film, which would put them
    elsewhere.
    """
    width, height = size
    count = width * height * samples
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    integrator = mi.load_dict({"type": "path", "max_depth": depth})
    rays = _see_through_backs(scene, _pixel_centres(camera, width, height, count))
    radiance, _, _ = integrator.sample(scene, sampler, rays)
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


def _see_through_backs(scene, rays):
    """Rays from where they have passed the backs of one-sided surfaces."""
    for _ in range(LAYERS):
        si = scene.ray_intersect(rays)
        one_sided = ~mi.has_flag(si.bsdf().flags(), mi.BSDFFlags.BackSide)
        passes = si.is_valid() & one_sided & (dr.dot(si.n, rays.d) > 0)
        rays.o = dr.select(passes, si.spawn_ray(rays.d).o, rays.o)
    return rays
