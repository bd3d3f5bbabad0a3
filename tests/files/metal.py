#!/usr/bin/env python3
"""Writes tests/files/materials/metal.gltf: a ball of few triangles with smooth normals on a floor, both of metal with a
bumpy normal map, without a light. tests/image/metal draws it with other roughness, bumps, and lights."""
import base64
import json
import math
import os
import struct
import zlib

TEXELS, BUMPS, STEEPNESS = 32, 1, 0.6


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def normal_map():
    rows = b""
    for y in range(TEXELS):
        rows += b"\0"
        for x in range(TEXELS):
            u, v = (2 * math.pi * BUMPS * (k + 0.5) / TEXELS for k in (x, y))
            n = (-STEEPNESS * math.cos(u) * math.cos(v), STEEPNESS * math.sin(u) * math.sin(v), 1)
            length = math.sqrt(sum(c * c for c in n))
            rows += bytes(round((c / length * 0.5 + 0.5) * 255) for c in n)
    header = struct.pack(">IIBBBBB", TEXELS, TEXELS, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def ball(around, down):
    points, normals, tangents, uvs, indices = [], [], [], [], []
    for j in range(down + 1):
        for i in range(around + 1):
            theta, phi = math.pi * j / down, 2 * math.pi * i / around
            n = (math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi))
            points.append(n)
            normals.append(n)
            tangents.append((-math.sin(phi), 0, -math.cos(phi), 1))
            uvs.append((i / around * 8, j / down * 4))
    for j in range(down):
        for i in range(around):
            a = j * (around + 1) + i
            c = a + around + 1
            indices += [a, c, a + 1] if j else []
            indices += [a + 1, c, c + 1] if j < down - 1 else []
    return points, normals, tangents, uvs, indices


def floor(half):
    points = [(-half, 0, -half), (half, 0, -half), (-half, 0, half), (half, 0, half)]
    return points, [(0, 1, 0)] * 4, [(1, 0, 0, 1)] * 4, [(0, 0), (8, 0), (0, 8), (8, 8)], [0, 2, 1, 1, 2, 3]


class Buffer:
    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []

    def view(self, data):
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data + b"\0" * (-len(data) % 4)
        return len(self.views) - 1

    def accessor(self, rows, kind):
        data = b"".join(struct.pack(f"<{len(r)}f", *r) for r in rows)
        self.accessors.append({"bufferView": self.view(data), "componentType": 5126, "count": len(rows), "type": kind})
        if kind == "VEC3":
            bounds = list(zip(*struct.iter_unpack("<3f", data)))
            self.accessors[-1] |= {"min": [min(b) for b in bounds], "max": [max(b) for b in bounds]}
        return len(self.accessors) - 1

    def indices(self, values):
        data = struct.pack(f"<{len(values)}H", *values)
        self.accessors.append({"bufferView": self.view(data), "componentType": 5123, "count": len(values), "type": "SCALAR"})
        return len(self.accessors) - 1

    def mesh(self, shape):
        points, normals, tangents, uvs, indices = shape
        attributes = {"POSITION": self.accessor(points, "VEC3"), "NORMAL": self.accessor(normals, "VEC3"),
                      "TANGENT": self.accessor(tangents, "VEC4"), "TEXCOORD_0": self.accessor(uvs, "VEC2")}
        return {"primitives": [{"attributes": attributes, "indices": self.indices(indices), "material": 0}]}


def main():
    b = Buffer()
    meshes = [b.mesh(ball(16, 8)), b.mesh(floor(4))]
    image = b.view(normal_map())
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0, "translation": [0, 1.05, 0]}, {"mesh": 1},
                  {"camera": 0, "translation": [0, 2.2, 5.5], "rotation": [-0.1246747, 0, 0, 0.9921977]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.05, "zfar": 100}}],
        "meshes": meshes,
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.85, 0.75, 1], "metallicFactor": 1,
                                                "roughnessFactor": 0.1},
                       "normalTexture": {"index": 0, "scale": 1.5}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": image, "mimeType": "image/png"}],
        "accessors": b.accessors,
        "bufferViews": b.views,
        "buffers": [{"byteLength": len(b.data),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(b.data).decode()}],
    }
    path = os.path.join(os.path.dirname(__file__), "materials", "metal.gltf")
    with open(path, "w", encoding="utf-8") as out:
        json.dump(scene, out, indent=1)
        out.write("\n")


main()
