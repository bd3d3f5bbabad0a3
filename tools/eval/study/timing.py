"""What a frame costs: by network, by path tracing, by denoising.

A network's frame and a sample a pixel of path tracing come from one run of `lightformer bench`, which measures them in
turns: every light, texel and pixel is redone in every frame. The sample ends paths after five segments and leaves out
bringing the tree of the scene up to date, while the pictures that are judged have paths of any length: in favour of
path tracing. Denoising is measured before and after each of these runs.
"""

import statistics
from pathlib import Path

import numpy as np

from .methods import OIDN_QUALITIES, Method, denoise
from .renderer import Renderer

BENCH_FRAMES = 16


def measure(renderer: Renderer, scene: Path, size: int, methods: list[Method]) -> dict:
    """Milliseconds: of a frame of each method that the renderer draws, of a sample a pixel, of denoising."""
    frames, samples, denoising = {}, [], [_denoising(size)]
    for method in methods:
        found = _bench(renderer, scene, size, method)
        frames[f"frame:{method.name}"] = found.get("neural", {}).get("frame_ms", found["frame_ms"]["median"])
        samples += [found["neural"]["sample_ms"]] if "neural" in found else []
        denoising.append(_denoising(size))
    if not samples:
        traced = renderer.measure(str(scene), "--reference", *_pixels(size))
        samples.append(1000 * size * size / traced["samples_s"])
    return (
        {"size": size, "sample": statistics.median(samples)}
        | frames
        | {f"oidn:{quality}": statistics.median(turn[quality] for turn in denoising) for quality in OIDN_QUALITIES}
    )


def _bench(renderer: Renderer, scene: Path, size: int, method: Method) -> dict:
    weights = ("--weights", str(method.weights)) if method.weights else ()
    return renderer.measure(
        str(scene), "--budget", "--frames", str(BENCH_FRAMES), *_pixels(size), *method.options, *weights
    )


def _pixels(size: int) -> tuple[str, str]:
    return "--size", f"{size}x{size}"


def _denoising(size: int) -> dict[str, float]:
    """Of noise: what is in a picture does not matter. The second call, so that nothing is prepared any more."""
    noise = np.random.default_rng(0).uniform(0, 1, (3, size, size, 3)).astype(np.float32)
    guide = {"albedo": noise[1], "normal": 2 * noise[2] - 1}
    return {quality: 1000 * [denoise(noise[0], guide, quality)[1] for _ in range(2)][1] for quality in OIDN_QUALITIES}


def of_frame(times: dict, name: str) -> float:
    """Of a method that the renderer draws."""
    return times[f"frame:{name}"]


def of_paths(times: dict, spp: int, quality: str | None = None) -> float:
    """Of path tracing with so many samples a pixel, and denoising it."""
    return spp * times["sample"] + (times[f"oidn:{quality}"] if quality else 0.0)


def paths_that_fit(times: dict, milliseconds: float) -> int:
    """Samples a pixel in that time; at least one, even where it takes longer."""
    return max(1, int(milliseconds / times["sample"]))
