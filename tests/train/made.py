"""Inputs and data sets made of numbers, with a simple truth: shadows where something is nearer, indirect light in
proportion to the bounce clue."""

import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from unittest import mock

import numpy as np
import torch

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/train"))
from lightformer_train import weights  # noqa: E402
from lightformer_train.network import Lights  # noqa: E402
from lightformer_train.program import INPUTS, INPUTS_VERSION  # noqa: E402

SETTINGS = {"format": INPUTS_VERSION, "scene": "made.glb", "depth": "0", "vpls": "24", "camera": "", "time": "0"}
UNIT_VECTORS = {name for name in INPUTS if name.rpartition(".")[2] in ("normal", "direction", "view")}


def shape(name: str, lights: int, size: tuple[int, int], vpls: int, texels: int) -> tuple[int, ...]:
    """Of an input of one frame."""
    entry = INPUTS[name]
    return {
        "frame": (entry.channels,),
        "light": (lights, entry.channels),
        "vpl": (lights, entry.channels, vpls),
        "texel": (lights, entry.channels, texels),
        "pixel": (entry.channels, *size),
        "view": (lights, entry.channels, *size),
    }[entry.domain]


def frame(
    random: np.random.Generator, lights: int, size: tuple[int, int], vpls: int = 24, texels: int = 48
) -> dict[str, np.ndarray]:
    """All inputs of one frame. Row 0 of the pixels' first column has no surface."""
    values = {}
    for name in INPUTS:
        of = shape(name, lights, size, vpls, texels)
        if name in UNIT_VECTORS:
            x = random.normal(size=of)
            channel = 0 if INPUTS[name].domain == "pixel" else 1
            x /= np.sqrt((x * x).sum(channel, keepdims=True)) + 1e-9
        else:
            x = random.random(of)
        values[name] = x.astype(np.float32)
    if lights:
        values["light.share"] /= values["light.share"].sum()
        near = random.random(values["view.occluder"].shape) < 0.4
        values["view.occluder"] = np.where(near, 0.5, 1.0).astype(np.float32) * values["view.distance"]
    values["pixel.mask"][:] = 1
    for name, entry in INPUTS.items():
        if entry.domain in ("pixel", "view"):
            values[name][..., 0, 0] = 0
    return values


def frames(counts: list[int], size: tuple[int, int], seed: int, **rows: int) -> tuple[dict[str, torch.Tensor], Lights]:
    """A batch of frames with so many lights each, as a network takes it."""
    random = np.random.default_rng(seed)
    parts = [frame(random, count, size, **rows) for count in counts]
    return join(parts, counts)


def join(parts: list[dict[str, np.ndarray]], counts: list[int]) -> tuple[dict[str, torch.Tensor], Lights]:
    """Frames as a batch."""
    inputs = {}
    for name, entry in INPUTS.items():
        arrays = [part[name] for part in parts]
        whole = np.stack(arrays) if entry.domain in ("frame", "pixel") else np.concatenate(arrays)
        inputs[name] = torch.from_numpy(whole[..., None] if entry.domain in ("vpl", "texel") else whole)
    return inputs, Lights(len(parts), torch.repeat_interleave(torch.arange(len(parts)), torch.tensor(counts)), {})


def truth(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Targets of a frame."""
    share = values["light.share"].reshape(-1, 1, 1, 1) * values["frame.radiance"]
    seen = values["view.occluder"] >= values["view.distance"]
    clue = values["view.diffuse"] + values["view.glossy"]
    unshadowed = (share * clue).sum(0)
    direct = (share * clue * seen).sum(0)
    ratio = np.where(unshadowed > 0, direct / np.maximum(unshadowed, 1e-9), 1)
    indirect = (share * values["view.bounce"]).sum(0) * values["pixel.diffuse"]
    return {"target.unshadowed": unshadowed, "target.shadow": ratio, "target.indirect": indirect}


def dataset(
    folder: Path,
    samples: int = 12,
    crops: int = 2,
    size: int = 24,
    lights: int = 2,
    spp: int = 8,
    scene: str = SETTINGS["scene"],
) -> Path:
    """A data set as `lightformer dataset` lays it out."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(1)
    tensors: dict[str, np.ndarray] = {}
    for seed in range(samples):
        whole = [frame(random, lights, (size, size)) for _ in range(crops)]
        for name, entry in INPUTS.items():
            if entry.domain not in ("pixel", "view"):
                for crop in whole[1:]:
                    crop[name] = whole[0][name]
        for name, entry in INPUTS.items():
            pictures = entry.domain in ("pixel", "view")
            array = np.stack([crop[name] for crop in whole]) if pictures else whole[0][name]
            tensors[f"{seed}/{name}"] = array.astype(np.float16 if pictures else np.float32)
        for name in truth(whole[0]):
            tensors[f"{seed}/{name}"] = np.stack([truth(crop)[name] for crop in whole]).astype(np.float32)
    file = f"shard-{0:010d}-{samples - 1:010d}.safetensors"
    sizes = {"size": size, "crop": size, "crops": crops, "spp": spp}
    settings = SETTINGS | {"scene": scene} | {name: str(value) for name, value in sizes.items()}
    weights.write(folder / file, tensors, settings)
    shard = {"file": file, "first_seed": 0, "samples": samples}
    (folder / "manifest.json").write_text(json.dumps({"settings": settings, "shards": [shard]}))
    return folder


def train(*arguments: object) -> tuple[int, str, str]:
    """tools/train/train.py within this process, which has PyTorch already: exit code and what it says."""
    import train as program

    said, errors = io.StringIO(), io.StringIO()
    with mock.patch.object(sys, "argv", ["train.py", *map(str, arguments)]):
        with redirect_stdout(said), redirect_stderr(errors):
            try:
                status = program.main()
            except SystemExit as end:
                status = end.code
    return status, said.getvalue(), errors.getvalue()
