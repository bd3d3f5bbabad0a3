"""Crops from the shards of `lightformer dataset`, as batches that a network takes.

A shard holds the inputs of lightformer/net/inputs.inc under their names, so nothing here knows how they come about.
Shards are mapped into memory; of the rows (direct VPLs, RSM texels) each batch draws a few, stratified, so that their
mean is right on average.
"""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import permutations, product
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from . import manifest, shard, weights
from .manifest import Manifest
from .network import Lights
from .program import INPUTS, INPUTS_VERSION, PICTURES, ROWS, Checked
from .shard import TARGETS

# Inputs of three channels that turn with the world; the others of three channels are colours.
VECTORS = {name for name in INPUTS if name.rpartition(".")[2] in ("position", "offset", "normal", "view", "direction")}
NEITHER = {"light.kind"}
# What the radius R of the scene is in: divided by it, by its square, or multiplied by that.
LENGTHS = {name for name in INPUTS if name.rpartition(".")[2] in ("position", "offset", "distance", "occluder")}
POWERS = {"frame.mean_power", "light.power", "light.share"}
RADIANCES = {"view.diffuse", "view.glossy", "view.bounce"}
MIRROR = {name for name in INPUTS if "mirror" in name}


def required_inputs(checked: Checked) -> frozenset[str]:
    """What a program reads, and what every training reads beside it."""
    found = frozenset(checked.inputs) | {"pixel.mask", "frame.radiance", "vpl.normal", "texel.normal"}
    return found | {"light.share", "light.kind"}


@dataclass(frozen=True)
class Options:
    """How batches are drawn."""

    vpls: int = 128  # rows of each light
    texels: int = 512
    augment: bool = True
    mirror_dropout: float = 0.15  # of the crops, the mirror clue is missing
    radii: float = 1.0  # crops are as if the scene's radius were up to so many times larger or smaller
    names: frozenset[str] = frozenset(INPUTS)  # inputs that are read


@dataclass(frozen=True)
class Crop:
    """One crop of one sample."""

    shard: int
    seed: int
    index: int


@dataclass
class Batch:
    """What a step learns from. Targets: [B, 3, h, w] radiance; `weight`: 1 where a pixel counts; `unit`: [B, 1], the
    frame.radiance that a frame has by its scene's own radius, whatever radius was drawn."""

    inputs: dict[str, Tensor]
    lights: Lights
    unshadowed: Tensor
    direct: Tensor
    indirect: Tensor
    weight: Tensor
    unit: Tensor

    def to(self, device: torch.device) -> "Batch":
        """The same on a device."""
        if device.type == "cpu":
            return self
        lights = Lights(
            self.lights.frames,
            self.lights.owner.to(device),
            {name: rows.to(device) for name, rows in self.lights.rows.items()},
        )
        moved = (x.to(device) for x in (self.unshadowed, self.direct, self.indirect, self.weight, self.unit))
        return Batch({name: x.to(device) for name, x in self.inputs.items()}, lights, *moved)


@dataclass
class Dataset:
    """The samples of some folders."""

    folders: list[Path]
    names: frozenset[str] = frozenset(INPUTS)  # inputs that every sample must have
    manifests: list[Manifest] = field(default_factory=list)
    paths: list[Path] = field(default_factory=list)  # of shards
    shards: list[shard.Arrays] = field(default_factory=list)
    scenes: list[str] = field(default_factory=list)  # name of each shard's
    crops: list[Crop] = field(default_factory=list)
    hash: str = ""

    def __post_init__(self) -> None:
        for folder in self.folders:
            found = manifest.read(folder)
            version = found.settings["format"]
            if version != INPUTS_VERSION:
                raise weights.FileError(
                    f"{folder}: its inputs are of version {version}, not {INPUTS_VERSION}; "
                    "make it anew (lightformer dataset --targets keeps what was traced)"
                )
            self.manifests.append(found)
            first = self.manifests[0]
            if found.crop != first.crop:
                raise weights.FileError(
                    f"{folder}: its crops have {found.crop} pixels a side, not {first.crop} as those of {first.folder}"
                )
            for listed in found.shards:
                self._add(found, listed)
        if not self.crops:
            raise weights.FileError(f"{', '.join(map(str, self.folders))}: no sample with a light")
        texts = b"".join(found.text for found in self.manifests)
        self.hash = f"{weights.hash_bytes(texts):016x}"

    def _add(self, found: Manifest, listed: manifest.Shard) -> None:
        tensors = shard.load(found, listed, self.names)
        for seed in range(listed.first, listed.end):
            if len(tensors[f"{seed}/light.share"]) > 0:
                self.crops += [Crop(len(self.shards), seed, index) for index in range(found.crops)]
        self.paths.append(found.folder / listed.file)
        self.shards.append(tensors)
        self.scenes.append(found.settings["scene"])

    def check_numbers(self) -> None:
        """FileError if a sample has others than finite ones. It reads everything: a second or two a gigabyte."""
        for path, tensors in zip(self.paths, self.shards):
            shard.check_numbers(path, tensors)

    def split(self, held_out: int) -> tuple[list[Crop], list[Crop]]:
        """Crops to learn from, and about so many of other samples, spread over all: of one sample at least. A sample
        that several data sets have, a seed of one scene, is on one side with all its crops."""
        order = sorted(self.crops, key=lambda crop: (crop.shard, crop.seed))
        samples = list(dict.fromkeys(map(self._sample, order)))
        share = max(min(held_out / len(self.crops), 0.5), (1 + 1e-9) / len(samples))
        kept = {sample for i, sample in enumerate(samples) if int((i + 1) * share) > int(i * share)}
        learn = [crop for crop in self.crops if self._sample(crop) not in kept]
        return learn, [crop for crop in self.crops if self._sample(crop) in kept]

    def _sample(self, crop: Crop) -> tuple[str, int]:
        return self.scenes[crop.shard], crop.seed

    def batch(self, crops: list[Crop], options: Options, random: np.random.Generator) -> Batch:
        """These crops; what is drawn of them follows from `random` alone."""
        parts = [_load(self.shards[crop.shard], crop, options, random) for crop in crops]
        counts = [len(part["light.share"]) for part in parts]
        inputs = {name: _join(name, [part[name] for part in parts]) for name in options.names}
        owner = torch.repeat_interleave(torch.arange(len(parts)), torch.tensor(counts))
        rows = {}
        if "texel.normal" in inputs:
            rows["texel"] = (inputs["texel.normal"] != 0).any(1, keepdim=True).float()
        targets = {name: torch.stack([part[name] for part in parts]) for name in TARGETS}
        unshadowed, shadow, indirect = (targets[name] for name in TARGETS)
        return Batch(
            inputs,
            Lights(len(parts), owner, rows),
            unshadowed,
            unshadowed * shadow,
            indirect,
            inputs["pixel.mask"],
            torch.stack([part["unit"] for part in parts]),
        )


def _join(name: str, parts: list[Tensor]) -> Tensor:
    """Arrays of frames as the network takes them: [B, ...] of frames and pixels, [N, ...] of lights."""
    of_frames = INPUTS[name].domain in ("frame", "pixel")
    whole = torch.stack(parts) if of_frames else torch.cat(parts)
    return whole[..., None] if INPUTS[name].domain in ROWS else whole


def _load(
    arrays: shard.Arrays, crop: Crop, options: Options, random: np.random.Generator
) -> dict[str, Tensor]:
    """One crop's arrays, fp32: [C] of the frame, [L, C] of lights, [L, C, P], [C, h, w], [L, C, h, w]."""
    without_mirror = random.random() < options.mirror_dropout
    axes, signs, channels, flip = _draw_symmetry(random) if options.augment else _IDENTITY
    wanted = {"vpl": options.vpls, "texel": options.texels}
    chosen = {name: _choose_rows(arrays, crop, name, count, random) for name, count in wanted.items()}
    part = {}
    for name in (*sorted(options.names | {"light.share", "frame.radiance"}), *TARGETS):
        array = arrays[f"{crop.seed}/{name}"]
        domain = INPUTS[name].domain if name in INPUTS else "pixel"
        if domain in PICTURES:
            array = array[crop.index, ..., ::flip]
        elif domain in ROWS:
            array = _take_rows(array, chosen[domain], wanted[domain])
        axis = 0 if domain in ("frame", "pixel") else 1
        if name in VECTORS:
            array = array.take(axes, axis)
        elif array.shape[axis] == 3 and name not in NEITHER:
            array = array.take(channels, axis)
        values = torch.from_numpy(array.copy()).float()  # PyTorch widens halves several times faster
        if name in MIRROR and without_mirror:
            values.zero_()
        if name in VECTORS:
            values *= signs.reshape(-1, *(1,) * (array.ndim - axis - 1))
        part[name] = values
    part["unit"] = part["frame.radiance"].clone()
    # The power of a light at infinity follows from the radius, too, and so do the shares of all.
    if options.radii > 1 and not arrays[f"{crop.seed}/light.kind"][:, 2].any():
        _divide_radius(part, options.radii ** random.uniform(-1, 1))
    return part


def _divide_radius(part: dict[str, Tensor], by: float) -> None:
    """As if the scene had a smaller radius, which changes its units and not its light: targets stay."""
    for name in LENGTHS & part.keys():
        part[name] *= by
    for name in POWERS & part.keys():
        part[name] *= by**2
    for name in RADIANCES & part.keys():
        part[name] /= by**2


_IDENTITY = np.arange(3), torch.ones(3), np.arange(3), 1
_ORDERS = [np.array(order) for order in permutations(range(3))]
_SIGNS = [torch.tensor(signs, dtype=torch.float32) for signs in product((1, -1), repeat=3)]


def _draw_symmetry(random: np.random.Generator) -> tuple[np.ndarray, Tensor, np.ndarray, int]:
    """Light does not care how axes are named, which way they point, how channels are named, or whether a picture is
    mirrored: order and signs of the world's axes, order of the channels, step through the columns."""
    axes, channels = (_ORDERS[i] for i in random.integers(0, len(_ORDERS), 2))
    return axes, _SIGNS[random.integers(0, len(_SIGNS))], channels, int(random.choice((1, -1)))


def _choose_rows(
    arrays: shard.Arrays, crop: Crop, domain: str, wanted: int, random: np.random.Generator
) -> list[np.ndarray]:
    """For each light, as many of its rows as are wanted, one of each stratum; all texels where it has fewer."""
    chosen = []
    for normals in arrays[f"{crop.seed}/{domain}.normal"]:
        # A point's direct VPL has no normal and counts; a texel without is one that other lights have more.
        count = normals.shape[1] if domain == "vpl" else int((normals != 0).any(0).sum())
        rows = (np.arange(wanted) + random.random(wanted)) * (count / wanted)
        chosen.append(rows.astype(np.int64) if domain == "vpl" or count > wanted else np.arange(count))
    return chosen


def _take_rows(array: np.ndarray, chosen: list[np.ndarray], wanted: int) -> np.ndarray:
    """The chosen rows of each light, then zeros."""
    taken = np.zeros((*array.shape[:2], wanted), array.dtype)
    for light, rows, to in zip(array, chosen, taken):
        to[:, : len(rows)] = light[:, rows]
    return taken


def steps(
    dataset: Dataset, crops: list[Crop], size: int, options: Options, seed: int, numbers: Iterable[int], rank: int = 0
) -> Iterator[Batch]:
    """Batches of steps, each following from seed, step and rank alone; the next is made while one is worked on."""

    def make(step: int) -> Batch:
        random = np.random.default_rng([seed, step, rank])
        return dataset.batch([crops[i] for i in random.integers(0, len(crops), size)], options, random)

    with ThreadPoolExecutor(1) as worker:
        pending = None
        for step in numbers:
            following = worker.submit(make, step)
            if pending is not None:
                yield pending.result()
            pending = following
        if pending is not None:
            yield pending.result()
