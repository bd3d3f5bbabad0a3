"""Shards: files of `lightformer dataset` as arrays of the shapes that a training relies on."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from . import weights
from .manifest import Manifest, Shard
from .program import INPUTS

TARGETS = ("target.unshadowed", "target.shadow", "target.indirect")
REALS = {np.dtype("<f4"), np.dtype("<f2")}
LETTERS = ("K", "L", "V", "T", "h")  # crops, lights, direct VPLs and texels of a light, side of a crop
BLOCK = 1 << 20  # numbers that are looked at at once: of the size of a cache

Arrays = dict[str, np.ndarray]  # "SEED/NAME"


def load(found: Manifest, shard: Shard, names: Iterable[str]) -> Arrays:
    """A shard, mapped, with these inputs and the targets of each of its samples. FileError, which names the file, if
    it is none or another than the manifest says."""
    path = found.folder / shard.file
    tensors, notes = weights.map_tensors(path)
    for key, value in found.settings.items():
        if notes.get(key, value) != value:
            raise weights.FileError(
                f'{path}: was made with other settings than manifest.json says ({key} is "{notes[key]}", not "{value}")'
            )
    seeds = {name.partition("/")[0] for name in tensors}
    if len(seeds) != shard.samples or not all(str(shard.first + i) in seeds for i in range(shard.samples)):
        raise weights.FileError(f"{path}: holds other samples than manifest.json says")
    for seed in range(shard.first, shard.end):
        _check_sample(path, tensors, seed, sorted(names), found)
    return tensors


def _check_sample(path: Path, tensors: Arrays, seed: int, names: list[str], found: Manifest) -> None:
    sizes = {"K": found.crops, "h": found.crop}
    for name in (*names, *TARGETS):
        array = tensors.get(f"{seed}/{name}")
        if array is None:
            raise weights.FileError(
                f"{path}: sample {seed} has no {name}; make the data set anew, or train without what reads it"
            )
        if array.dtype not in REALS:
            raise weights.FileError(f"{path}: sample {seed}, {name}: numbers of type {array.dtype}, not F16 or F32")
        _check_shape(f"{path}: sample {seed}, {name}", array.shape, shape_of(name), sizes)


def _check_shape(what: str, shape: tuple[int, ...], wanted: tuple[int | str, ...], sizes: dict[str, int]) -> None:
    """`sizes`: of the letters, which the first array that has one decides."""
    if len(shape) == len(wanted):
        sizes |= {letter: size for letter, size in zip(wanted, shape) if letter not in sizes and letter in LETTERS}
    known = [sizes.get(letter, letter) for letter in wanted]
    if list(shape) != known or ("V" in wanted and sizes["V"] == 0 < sizes["L"]):
        raise weights.FileError(f"{what}: {_times(shape)} numbers, not {_times(known)}")


def _times(sizes: Iterable[int | str]) -> str:
    return " x ".join(map(str, sizes))


def shape_of(name: str) -> tuple[int | str, ...]:
    """Sizes of an array, as in lightformer/dataset/README.md; LETTERS are those that arrays of a sample share."""
    if name in TARGETS:
        return "K", 3, "h", "h"
    channels = INPUTS[name].channels
    return {
        "frame": (channels,),
        "light": ("L", channels),
        "vpl": ("L", channels, "V"),
        "texel": ("L", channels, "T"),
        "pixel": ("K", channels, "h", "h"),
        "view": ("K", "L", channels, "h", "h"),
    }[INPUTS[name].domain]


def check_numbers(path: Path, arrays: Arrays) -> None:
    """FileError if a number is infinite or none: it would spoil all weights at once."""
    for name, array in arrays.items():
        seed, _, rest = name.partition("/")
        if array.dtype in REALS and not _is_finite(array):
            raise weights.FileError(
                f"{path}: sample {seed}, {rest}: has values that are not numbers; delete the file and run "
                "lightformer dataset again"
            )


def _is_finite(array: np.ndarray) -> bool:
    flat = array.reshape(-1)
    blocks = (flat[at : at + BLOCK] for at in range(0, flat.size, BLOCK))
    if flat.dtype == np.float16:  # by the bits of the exponent: NumPy widens each half first
        return all(((block.view(np.uint16) & 0x7FFF) < 0x7C00).all() for block in blocks)
    return all(np.isfinite(block).all() for block in blocks)
