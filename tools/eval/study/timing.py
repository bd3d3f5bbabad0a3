"""What a frame costs, by network, by path tracing and by denoising, measured in turns on one machine.

Rounds go through all of them, so that what else the machine does touches all alike; figures are medians over rounds.
A network's frame is that of `lightformer bench`: everything moves, every light's map is redrawn. Path tracing pays for
its samples and for bringing its tree of the scene up to date.
"""

import statistics
from pathlib import Path

import numpy as np

from .methods import OIDN_QUALITIES, Method, denoise
from .renderer import Renderer

BENCH_FRAMES = 8
BENCH_SPP = 2


def measure(renderer: Renderer, scene: Path, size: int, methods: list[Method], rounds: int) -> dict:
    """Milliseconds: of a frame of each method that the renderer draws, of a sample a pixel, of denoising."""
    turns = [_turn(renderer, scene, size, methods) for _ in range(rounds)]
    keys = turns[0].keys()
    return {"rounds": rounds, "size": size} | {key: statistics.median(turn[key] for turn in turns) for key in keys}


def _turn(renderer: Renderer, scene: Path, size: int, methods: list[Method]) -> dict[str, float]:
    pixels = ("--size", f"{size}x{size}")
    traced = renderer.measure(str(scene), "--reference", "--spp", str(BENCH_SPP), *pixels)
    times = {"sample": 1000 * size * size / traced["samples_s"], "refit": traced["refit_ms"]}
    for method in methods:
        weights = ("--weights", str(method.weights)) if method.weights else ()
        drawn = renderer.measure(str(scene), "--frames", str(BENCH_FRAMES), *pixels, *method.options, *weights)
        times[f"frame:{method.name}"] = drawn["frame_ms"]["median"]
    return times | {f"oidn:{quality}": _denoising(size, quality) for quality in OIDN_QUALITIES}


def _denoising(size: int, quality: str) -> float:
    """Of noise: what is in a picture does not matter. The second call, so that nothing is prepared any more."""
    noise = np.random.default_rng(0).uniform(0, 1, (3, size, size, 3)).astype(np.float32)
    guide = {"albedo": noise[1], "normal": 2 * noise[2] - 1}
    denoise(noise[0], guide, quality)
    return 1000 * denoise(noise[0], guide, quality)[1]


def of_frame(times: dict, name: str) -> float:
    """Of a method that the renderer draws."""
    return times[f"frame:{name}"]


def of_paths(times: dict, spp: int, quality: str | None = None) -> float:
    """Of path tracing with so many samples a pixel, and denoising it."""
    return times["refit"] + spp * times["sample"] + (times[f"oidn:{quality}"] if quality else 0.0)


def paths_that_fit(times: dict, milliseconds: float) -> int:
    """Samples a pixel in that time; at least one, even where it takes longer."""
    return max(1, int((milliseconds - times["refit"]) / times["sample"]))
