"""A glTF document as a scene of Mitsuba: shapes, materials and lights by its own plugins wherever there is one."""

import os

import mitsuba as mi
import numpy as np

from . import plugins  # noqa: F401: registers "metallic_roughness" and "khr_spot"

# Mitsuba's rectangle and disk shine along +Z, ours along -Z: half a turn about Y, which leaves textures upside down.
HALF_TURN = np.diag([-1.0, 1.0, -1.0, 1.0])
FINER = 8  # a map of the environment is resampled to so many texels for one


def build(document, refined=None):
    """refined: Triangles by node name, instead of those of the file (surfaces that the engine subdivides)."""
    builder = _Builder(document, refined or {})
    for node in document.nodes:
        builder.add_surfaces(node)
        builder.add_lights(node)
    return mi.load_dict({"type": "scene", **{f"part{i}": part for i, part in enumerate(builder.parts)}})


class _Builder:
    def __init__(self, document, refined):
        self.document = document
        self.refined = refined
        self.parts = []
        self.bsdfs = [mi.load_dict(_bsdf(document, m)) for m in document.json.get("materials", [])]

    def add_surfaces(self, node):
        if "mesh" not in node.source:
            return
        light = node.components().get("light_mesh")
        for primitive in self.document.json["meshes"][node.source["mesh"]]["primitives"]:
            material = primitive["material"]
            emitter = _emission(self.document, self.document.json["materials"][material], light) if light else None
            triangles = self.refined.get(node.name) or self.document.triangles(primitive)
            self.parts.append(_mesh(triangles, node.matrix, self.bsdfs[material], emitter))

    def add_lights(self, node):
        for name, light in node.components().items():
            if name in LIGHTS:
                self.parts.append(LIGHTS[name](self.document, node.matrix, light))
        punctual = node.source.get("extensions", {}).get("KHR_lights_punctual")
        if punctual:
            light = self.document.json["extensions"]["KHR_lights_punctual"]["lights"][punctual["light"]]
            self.parts.append(PUNCTUAL[light["type"]](node.matrix, light))


# ---- surfaces ------------------------------------------------------------------------------------------------------
def _rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def _textured(document, reference, factor, pixels_of):
    """A texture times its factor, or the factor alone."""
    if reference is None:
        return _rgb(factor)
    texture = document.textures[reference]
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(pixels_of(texture) * factor, np.float32)),
        "raw": True,
        "format": "variant",
        "filter_type": "bilinear",
        "wrap_mode": texture.wrap,
    }


def _index(source, name):
    return source[name]["index"] if name in source else None


def _bsdf(document, material):
    assert material.get("alphaMode", "OPAQUE") == "OPAQUE", "not needed so far"
    pbr = material.get("pbrMetallicRoughness", {})
    color = pbr.get("baseColorFactor", (1, 1, 1, 1))[:3]
    rough = (0, pbr.get("roughnessFactor", 1), pbr.get("metallicFactor", 1))
    texture = _index(pbr, "metallicRoughnessTexture")
    bsdf = {
        "type": "metallic_roughness",
        "base_color": _textured(document, _index(pbr, "baseColorTexture"), color, lambda t: t.linear()),
        "metallic_roughness": _textured(document, texture, rough, lambda t: t.pixels[..., :3]),
        "sides": 2 if material.get("doubleSided") else 1,
    }
    return _bent(document, material["normalTexture"], bsdf) if "normalTexture" in material else bsdf


def _bent(document, reference, bsdf):
    assert reference.get("scale", 1) == 1, "not needed so far"
    return {
        "type": "normalmap",
        "normalmap": _textured(document, reference["index"], 1, lambda t: t.pixels[..., :3]),
        "nested": bsdf,
        "flip_invalid_normals": False,
        "use_shadowing_function": False,
    }


def _emission(document, material, light):
    """Of an emissive mesh that is a light."""
    assert not material.get("doubleSided"), "not needed so far"
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
    factor = np.multiply(material["emissiveFactor"], strength * _strength(light, "scale"))
    return _area(_textured(document, _index(material, "emissiveTexture"), factor, lambda t: t.linear()))


def _mesh(triangles, matrix, bsdf, emission):
    linear = matrix[:3, :3]
    positions = triangles.positions @ linear.T + matrix[:3, 3]
    indices = triangles.indices if np.linalg.det(linear) > 0 else triangles.indices[:, ::-1]
    props = mi.Properties()
    props["bsdf"] = bsdf
    if emission:
        props["emitter"] = mi.load_dict(emission)
    # Mitsuba weighs the light of a mesh by its shading normals, so a mesh that shines has none.
    smooth = triangles.normals is not None and not emission
    mesh = mi.Mesh("mesh", len(positions), len(indices), props, smooth, triangles.uvs is not None)
    params = mi.traverse(mesh)
    params["vertex_positions"] = _flat(positions)
    params["faces"] = np.ascontiguousarray(indices).ravel()
    if smooth:
        normals = triangles.normals @ np.linalg.inv(linear)
        params["vertex_normals"] = _flat(normals / np.linalg.norm(normals, axis=1, keepdims=True))
    if triangles.uvs is not None:
        params["vertex_texcoords"] = _flat(triangles.uvs)
    params.update()
    return mesh


def _flat(array):
    return array.astype(np.float32).ravel()


# ---- lights --------------------------------------------------------------------------------------------------------
def _transform(matrix):
    return mi.ScalarTransform4f(np.asarray(matrix, np.float64).tolist())


def _strength(light, name):
    return np.multiply(light.get("color", (1, 1, 1)), light.get(name, 1))


def _area(radiance):
    return {"type": "area", "radiance": radiance}


def _light_surface(light, shape, radiance):
    """Surfaces of lights are dielectrics of roughness 1."""
    albedo = _rgb(light.get("albedo", (0, 0, 0)))
    bsdf = {"type": "metallic_roughness", "base_color": albedo, "metallic_roughness": _rgb((0, 1, 0)), "sides": 1}
    return {**shape, "bsdf": bsdf, "emitter": _area(radiance)}


def _rectangle(document, matrix, light):
    width, height = light["size"]
    place = matrix @ np.diag([width / 2, height / 2, 1, 1]) @ HALF_TURN
    texture = light["texture"]["texture"] if "texture" in light else None
    radiance = _textured(document, texture, _strength(light, "radiance"), lambda t: t.linear()[::-1])
    return _light_surface(light, {"type": "rectangle", "to_world": _transform(place)}, radiance)


def _disk(_, matrix, light):
    place = matrix @ np.diag([light["radius"], light["radius"], 1, 1]) @ HALF_TURN
    shape = {"type": "disk", "to_world": _transform(place)}
    return _light_surface(light, shape, _rgb(_strength(light, "radiance")))


def _sphere(_, matrix, light):
    radius = light["radius"] * np.linalg.norm(matrix[:3, :3], axis=0).max()
    shape = {"type": "sphere", "center": matrix[:3, 3].tolist(), "radius": float(radius)}
    return _light_surface(light, shape, _rgb(_strength(light, "radiance")))


def _environment(document, matrix, light):
    picture = np.array(mi.Bitmap(os.path.join(document.folder, light["map"]["uri"])))[..., :3]
    # Mitsuba's first and last rows lie on the poles, the file's half a texel from them. Hence a finer map, of what
    # bilinear lookups in the file give at the places of Mitsuba's texels.
    height, width = picture.shape[:2]
    rows = np.linspace(0, 1, height * FINER) * height - 0.5
    columns = (np.arange(width * FINER) + 0.5) / FINER - 0.5
    fine = _bilinear(picture, rows, columns) * _strength(light, "intensity")
    # The middle of our map is -Z; of Mitsuba's, +Z.
    place = _transform(matrix @ HALF_TURN)
    return {"type": "envmap", "bitmap": mi.Bitmap(fine.astype(np.float32)), "to_world": place}


def _bilinear(picture, rows, columns):
    """Of texels with centres at whole numbers; rows end at the poles, columns close on themselves."""
    height, width = picture.shape[:2]
    y, x = np.floor(rows).astype(int), np.floor(columns).astype(int)
    fy, fx = (rows - y)[:, None, None], (columns - x)[None, :, None]
    y0, y1 = (np.clip(y + i, 0, height - 1)[:, None] for i in (0, 1))
    x0, x1 = ((x + i) % width for i in (0, 1))
    top = picture[y0, x0] * (1 - fx) + picture[y0, x1] * fx
    bottom = picture[y1, x0] * (1 - fx) + picture[y1, x1] * fx
    return top * (1 - fy) + bottom * fy


def _point(matrix, light):
    return {"type": "point", "position": matrix[:3, 3].tolist(), "intensity": _rgb(_strength(light, "intensity"))}


def _directional(matrix, light):
    irradiance = _rgb(_strength(light, "intensity"))
    return {"type": "directional", "direction": (-matrix[:3, 2]).tolist(), "irradiance": irradiance}


def _spot(matrix, light):
    return {
        "type": "khr_spot",
        "to_world": _transform(matrix),
        "intensity": mi.ScalarColor3f(_strength(light, "intensity").tolist()),
        "inner": light["spot"].get("innerConeAngle", 0.0),
        "outer": light["spot"].get("outerConeAngle", np.pi / 4),
    }


LIGHTS = {
    "light_disk": _disk,
    "light_environment": _environment,
    "light_rectangle": _rectangle,
    "light_sphere": _sphere,
}
PUNCTUAL = {"point": _point, "directional": _directional, "spot": _spot}
