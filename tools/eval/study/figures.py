"""Figures of pictures over test frames, with how sure they are."""

import hashlib
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy import stats

from evaluation import BadInput, lpips, metrics, perceptual
from evaluation.comparison import Comparison, prepare
from evaluation.pictures import load
from lightformer_train import files

CONFIDENCE = 0.95
BEAUTY = "beauty"
# Of the whole picture, in the order of the tables: key, name, digits.
WHOLE = (
    ("rse", "RSE", "{:.5f}"),
    ("hdr_flip", "HDR-FLIP", "{:.4f}"),
    ("ssim", "SSIM", "{:.4f}"),
    ("lpips", "LPIPS", "{:.4f}"),
    ("mean_ratio", "mean ratio", "{:.4f}"),
)
# The paper's name of each layer of light.
COMPONENTS = {BEAUTY: "beauty", "unshadowed": "T_l", "direct": "T_d", "indirect": "T_i"}


@dataclass(frozen=True)
class Truth:
    """The two references of a frame."""

    first: Path
    second: Path

    def compare(self, picture: Path, layer: str = BEAUTY) -> Comparison:
        """A picture's layer beside that of both references."""
        name = None if layer == BEAUTY else layer
        return prepare(*(load(str(path), name) for path in (picture, self.first, self.second)))

    def noise(self) -> float:
        """The RSE of one reference alone: half of what the two differ."""
        first, second = (load(str(path)).pixels for path in (self.first, self.second))
        mean = 0.5 * (first + second)
        unit = mean.mean()
        return float((0.5 * (first - second) ** 2 / (mean**2 + metrics.RSE_EPSILON * unit**2)).mean())


def judge(picture: Path, truth: Truth, layers: tuple[str, ...]) -> dict:
    """All figures of one picture: of the whole, and RSE and mean ratio of each layer of light.

    They are kept beside the picture under a name that follows from the references and from what computes them.
    """
    key = hashlib.sha256(f"{truth.first.name} {truth.second.name} {layers} {_version()}".encode()).hexdigest()[:12]
    kept = picture.with_name(f"{picture.stem}-figures-{key}.json")
    if not kept.exists():
        files.write_atomically(kept, json.dumps(_judge(picture, truth, layers)).encode())
    return json.loads(kept.read_text(encoding="utf-8"))


@cache
def _version() -> str:
    """Of what computes figures."""
    sources = [Path(__file__), *sorted(Path(metrics.__file__).parent.glob("*.py"))]
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


def _judge(picture: Path, truth: Truth, layers: tuple[str, ...]) -> dict:
    whole = truth.compare(picture)
    components = {layer: _component(truth.compare(picture, layer)) for layer in layers}
    return _component(whole) | {
        "hdr_flip": float(perceptual.hdr_flip_map(whole).mean()),
        "ssim": perceptual.ssim(whole),
        "lpips": lpips.lpips(whole),
        "layers": components,
    }


def rse(picture: Path, truth: Truth) -> float:
    """The relative squared error of one picture."""
    return float(metrics.rse_map(truth.compare(picture)).mean())


def _component(comparison: Comparison) -> dict[str, float]:
    return {
        "rse": float(metrics.rse_map(comparison).mean()),
        "mean_ratio": float(comparison.a.pixels.mean() / comparison.mean),
    }


def summarize(values: list[float | None]) -> dict[str, float | None] | None:
    """Mean over frames and half the width of its confidence interval (Student's t); None if no frame has one."""
    known = np.array([value for value in values if value is not None])
    if not known.size:
        return None
    half = None
    if known.size > 1:
        half = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, known.size - 1) * stats.sem(known))
    return {"mean": float(known.mean()), "half": half}


def summarize_frames(frames: list[dict]) -> dict:
    """The figures of `judge` over frames, of the same shape."""
    if not frames:
        raise BadInput("no frames")
    first = frames[0]
    return {
        key: (
            _summarize_layers([frame[key] for frame in frames])
            if key == "layers"
            else summarize([frame[key] for frame in frames])
        )
        for key in first
        if key not in ("seed", "picture")
    }


def _summarize_layers(frames: list[dict]) -> dict:
    return {
        layer: {key: summarize([frame[layer][key] for frame in frames]) for key in figures}
        for layer, figures in frames[0].items()
    }
