"""A glTF binary as the standard describes it, at one moment: placements, triangles, materials, lights.

Shares nothing with the engine's loader. It reads what the scenes of the comparison hold, and stops at what else could
be mistaken ("not needed so far"). The extension NG_scene: engine/asset/README.md.
"""

import io
import json
import os
import struct
from dataclasses import dataclass

import numpy as np
from PIL import Image

COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
REPEAT, CLAMP = 10497, 33071


@dataclass
class Texture:
    """pixels: [height][width][4], 0 to 1 as stored; wrap: "repeat" or "clamp"."""

    pixels: np.ndarray
    wrap: str

    def linear(self):
        """Colour, decoded from sRGB."""
        c = self.pixels[..., :3]
        return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


@dataclass
class Triangles:
    """In the node's own space. normals: as interpolated, or None: flat; uvs: [n][2] or None."""

    positions: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    indices: np.ndarray


@dataclass
class Node:
    name: str
    matrix: np.ndarray  # to world, column vectors
    source: dict

    def components(self):
        return self.source.get("extensions", {}).get("NG_scene", {}).get("components", {})


class Document:
    def __init__(self, path, time=0.0):
        with open(path, "rb") as file:
            data = file.read()
        magic, version, _, size = struct.unpack_from("<4sIII", data)
        assert (magic, version) == (b"glTF", 2), path
        self.folder = os.path.dirname(path)
        self.json = json.loads(data[20 : 20 + size])
        self.binary = data[28 + size :]
        self.textures = [self._texture(t) for t in self.json.get("textures", [])]
        self.nodes = self._place(self._animated(time))

    def accessor(self, index):
        a = self.json["accessors"][index]
        assert "sparse" not in a and not a.get("normalized"), "not needed so far"
        view = self.json["bufferViews"][a["bufferView"]]
        assert "byteStride" not in view, "not needed so far"
        width = WIDTHS[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        values = np.frombuffer(self.binary, COMPONENTS[a["componentType"]], a["count"] * width, start)
        return values.reshape(-1, width)

    def triangles(self, primitive):
        attributes = primitive["attributes"]
        get = {name: self.accessor(i).astype(np.float64) for name, i in attributes.items()}
        assert "TANGENT" not in get and primitive.get("mode", 4) == 4, "not needed so far"
        count = len(get["POSITION"])
        indices = self.accessor(primitive["indices"]) if "indices" in primitive else np.arange(count)
        return Triangles(
            get["POSITION"], get.get("NORMAL"), get.get("TEXCOORD_0"), indices.reshape(-1, 3).astype(np.uint32)
        )

    def camera(self):
        """The first one: its placement and vertical field of view."""
        node = next(n for n in self.nodes if "camera" in n.source)
        return node.matrix, self.json["cameras"][node.source["camera"]]["perspective"]["yfov"]

    def _texture(self, texture):
        view = self.json["bufferViews"][self.json["images"][texture["source"]]["bufferView"]]
        start = view.get("byteOffset", 0)
        picture = Image.open(io.BytesIO(self.binary[start : start + view["byteLength"]])).convert("RGBA")
        sampler = self.json["samplers"][texture["sampler"]]
        wraps = {sampler.get(key, REPEAT) for key in ("wrapS", "wrapT")}
        assert len(wraps) == 1, "not needed so far"
        return Texture(np.asarray(picture) / 255.0, {REPEAT: "repeat", CLAMP: "clamp"}[wraps.pop()])

    def _animated(self, time):
        """node -> {"translation": ...} of every channel at a time, as section 3.11 and appendix C have it."""
        changes = {}
        for animation in self.json.get("animations", []):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                path = channel["target"]["path"]
                assert path in ("translation", "scale"), "not needed so far"
                times, values = (self.accessor(sampler[key]).astype(np.float64) for key in ("input", "output"))
                value = _sample(sampler.get("interpolation", "LINEAR"), times[:, 0], values, time)
                changes.setdefault(channel["target"]["node"], {})[path] = value
        return changes

    def _place(self, changes):
        nodes, waiting = [], [(i, np.eye(4)) for i in self.json["scenes"][self.json.get("scene", 0)]["nodes"]]
        while waiting:
            index, parent = waiting.pop()
            source = self.json["nodes"][index]
            matrix = parent @ _local({**source, **changes.get(index, {})})
            nodes.append(Node(source.get("name", ""), matrix, source))
            waiting += [(child, matrix) for child in source.get("children", [])]
        return nodes


def _sample(interpolation, times, values, t):
    t = np.clip(t, times[0], times[-1])
    k = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    step = times[k + 1] - times[k]
    s = (t - times[k]) / step
    if interpolation == "STEP":
        return values[k + 1 if s >= 1 else k]
    if interpolation == "LINEAR":
        return values[k] * (1 - s) + values[k + 1] * s
    keys = values.reshape(len(times), 3, -1)  # tangent before, value, tangent after
    before, after = keys[k], keys[k + 1]
    return (
        (2 * s**3 - 3 * s**2 + 1) * before[1]
        + (s**3 - 2 * s**2 + s) * step * before[2]
        + (3 * s**2 - 2 * s**3) * after[1]
        + (s**3 - s**2) * step * after[0]
    )


def _local(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    rotation = np.array(node.get("rotation", (0, 0, 0, 1)), float)
    x, y, z, w = rotation / np.linalg.norm(rotation)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ] * np.array(node.get("scale", (1, 1, 1)))
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def read_refined(path):
    """Triangles by node name, as tests/eval/refined_triangles writes them (safetensors)."""
    with open(path, "rb") as file:
        data = file.read()
    (size,) = struct.unpack_from("<Q", data)
    arrays = {}
    for name, tensor in json.loads(data[8 : 8 + size]).items():
        if name != "__metadata__":
            start, end = (8 + size + offset for offset in tensor["data_offsets"])
            dtype = {"F32": np.float32, "I32": np.uint32}[tensor["dtype"]]
            arrays[name] = np.frombuffer(data[start:end], dtype).reshape(tensor["shape"])
    nodes = {name.rsplit(".", 1)[0] for name in arrays}
    return {n: Triangles(arrays[f"{n}.positions"], arrays[f"{n}.normals"], None, arrays[f"{n}.indices"]) for n in nodes}
