"""Pictures as arrays: a layer of an OpenEXR file, or a PNG. The rules are those of lightformer/metrics/picture.h."""

import os
from dataclasses import dataclass

import numpy as np
import OpenEXR
from PIL import Image

from . import BadInput
from .tonemap import srgb_decode

TRIPLES = ("R", "G", "B"), ("X", "Y", "Z")


@dataclass(frozen=True)
class Picture:
    """pixels: [height][width][3], float64, linear Rec. 709; display: of a PNG, tone-mapped already."""

    name: str
    pixels: np.ndarray
    display: bool = False

    @property
    def size(self):
        """Width and height."""
        return self.pixels.shape[1], self.pixels.shape[0]


def load(path, layer=None):
    """The picture of a PNG, or of a layer of an OpenEXR file (None: R, G, B at the root)."""
    magic = _first_bytes(path)
    if magic == b"\x76\x2f\x31\x01":
        name = f"{path}, layer {layer}" if layer else path
        return Picture(name, _interleave(path, layer, _layer_planes(read_planes(path), layer)))
    if magic == b"\x89PNG":
        if layer:
            raise BadInput(f'{path}: no layer "{layer}"; a PNG has no layers')
        return Picture(path, srgb_decode(_read_png(path)), display=True)
    raise BadInput(f"{path}: neither an OpenEXR nor a PNG file")


def read_planes(path):
    """All channels of an OpenEXR file's first part: name -> [height][width]."""
    try:
        with OpenEXR.File(path, separate_channels=True) as exr:
            return {name: channel.pixels for name, channel in exr.channels().items()}
    except Exception as error:  # the binding raises several kinds
        raise BadInput(f"{path}: {str(error).splitlines()[0]}") from error


def _first_bytes(path):
    try:
        with open(path, "rb") as file:
            return file.read(4)
    except OSError as error:
        raise BadInput(f"{path}: {os.strerror(error.errno)}") from error


def _read_png(path):
    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGB"), np.float64) / 255.0
    except (OSError, SyntaxError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from error


def _layer_planes(planes, layer):
    """Channel -> plane of one layer."""
    parts = {name: name.rpartition(".") for name in planes}
    return {parts[name][2]: plane for name, plane in planes.items() if parts[name][0] == (layer or "")}


def _interleave(path, layer, channels):
    for triple in TRIPLES:
        if all(name in channels for name in triple):
            return np.stack([channels[name] for name in triple], axis=-1).astype(np.float64)
    colour = [plane for name, plane in channels.items() if name != "A"]
    if len(colour) == 1:
        return np.repeat(colour[0][..., None], 3, axis=-1).astype(np.float64)
    if colour:
        raise BadInput(f"{path}: the {len(colour)} channels of {layer or 'the root'} are neither R, G, B nor "
                       "X, Y, Z nor one alone")
    layers = sorted({name.rpartition(".")[0] for name in read_planes(path)} - {""})
    raise BadInput(f'{path}: no layer "{layer or "R, G, B"}"; it has {", ".join(layers) or "no layers, only a root"}')
