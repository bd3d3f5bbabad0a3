"""Flicker: how much pictures of a sequence change beyond what motion explains.

Each frame is compared with the one before it, moved along the reference's motion: D(X) = X_t - warp(X_(t-1)). Two
figures, both over the reference's mean: the change mean(|D(A)|), which of the reference is the moving light itself and
its noise, and the temporal error mean(|D(A) - D(B)|) of evaluation/temporal.py.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from evaluation.comparison import prepare
from evaluation.pictures import load
from evaluation.temporal import find_history, read_motion, temporal_error

from . import methods
from .figures import summarize
from .methods import Method
from .renderer import Renderer, moment

FIRST_FRAME = 30  # of Chess: several pieces are on their way


def judge(renderer: Renderer, scene: Path, count: int, size: int, spp: int, judged: list[Method]) -> dict:
    """Change and temporal error of each method, of the reference, and of a second reference with other noise."""
    frames = range(FIRST_FRAME, FIRST_FRAME + count)
    truth = [
        tuple(renderer.picture(shot) for shot in methods.references(moment(scene, frame, size), spp))
        for frame in frames
    ]
    rows = {"reference": [first for first, _ in truth], "second reference": [second for _, second in truth]}
    for method in judged:
        rows[method.name] = [
            methods.make(renderer, method, moment(scene, frame, size), first)
            for frame, (first, _) in zip(frames, truth)
        ]
    measured = {name: of_pictures(pictures, rows["reference"]) for name, pictures in rows.items()}
    own = measured["reference"]["change"]["mean"]
    return {
        "scene": scene.stem,
        "frames": count,
        "size": size,
        "spp": spp,
        "methods": {name: figures | {"ratio": figures["change"]["mean"] / own} for name, figures in measured.items()},
    }


def of_pictures(pictures: list[Path], reference: list[Path]) -> dict:
    """Change and temporal error, means over pairs of frames. The last picture is shown in the report."""
    pairs = list(_pairs(pictures, reference))
    return {
        "change": summarize([change for change, _ in pairs]),
        "temporal_error": summarize([error for _, error in pairs]),
        "picture": str(pictures[-1]),
        "reference": str(reference[-1]),
    }


def _pairs(pictures: list[Path], reference: list[Path]) -> Iterator[tuple[float | None, float | None]]:
    before = None
    for picture, truth in zip(pictures, reference):
        now = prepare(load(str(picture)), load(str(truth)))
        motion, entities = read_motion(str(truth))
        if before:
            history = find_history(motion, before[0].mask, now.mask, before[1], entities)
            change = history and float(np.abs(history.change(before[0].a.pixels, now.a.pixels)).mean() / now.mean)
            yield change, temporal_error(before[0], now, motion, before[1], entities)
        before = now, entities
