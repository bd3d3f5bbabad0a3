"""What makes pictures that are judged: networks, the rasterizer, the path tracer, and Open Image Denoise after it."""

import os
import threading
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import OpenEXR
import pyoidn

from evaluation.pictures import load

from .renderer import Renderer, Shot

LIGHT = ("direct", "unshadowed", "indirect")
GUIDES = ("albedo", "specular", "normal")  # what the denoiser is told about surfaces
REFERENCE_SEEDS = 1, 2
JUDGED_SEED = 3  # of path tracing that is judged: independent of the references
OIDN_QUALITIES = "high", "fast"


@dataclass(frozen=True)
class Method:
    """A row of the tables."""

    name: str
    options: tuple[str, ...]
    layers: tuple[str, ...] = ()  # of light, besides the picture as a whole
    weights: Path | None = None
    spp: int = 0  # of path tracing
    denoiser: str | None = None  # the quality of Open Image Denoise

    def shot(self, at: Shot) -> Shot:
        """Its picture of a frame, before denoising."""
        return replace(at, options=at.options + self.options, layers=self.layers, weights=self.weights)


def network(name: str, weights: Path) -> Method:
    """The method "neural" with these weights."""
    return Method(name, ("--method", "neural"), LIGHT, weights)


def raster() -> Method:
    """Direct light alone."""
    return Method("raster", ("--method", "raster"), ("direct", "unshadowed"))


def paths(spp: int) -> Method:
    """Path tracing with so many samples a pixel."""
    return Method(f"paths {spp} spp", _traced(spp, JUDGED_SEED), LIGHT, spp=spp)


def denoised(spp: int, quality: str) -> Method:
    """Path tracing and Open Image Denoise."""
    name = f"paths {spp} spp + OIDN" + (f" {quality}" if quality != "high" else "")
    return Method(name, _traced(spp, JUDGED_SEED), spp=spp, denoiser=quality)


def references(at: Shot, spp: int) -> list[Shot]:
    """Two independent pictures of the truth, which also know surfaces and motion."""
    layers = LIGHT + GUIDES + ("motion", "entity")
    return [replace(at, options=at.options + _traced(spp, seed), layers=layers) for seed in REFERENCE_SEEDS]


def _traced(spp: int, seed: int) -> tuple[str, ...]:
    return "--method", "reference", "--spp", str(spp), "--seed", str(seed)


def make(renderer: Renderer, method: Method, at: Shot, surfaces: Path) -> Path:
    """The file with a method's picture of a frame. `surfaces`: a picture of it with the layers that guide a denoiser;
    all pictures of the path tracer start at pixel centres, so that any will do."""
    shot = method.shot(at)
    path = renderer.picture(shot)
    if not method.denoiser:
        return path
    clean = renderer.path(shot, f"-oidn-{method.denoiser}")
    if not clean.exists():
        write(clean, denoise(load(str(path)).pixels, guides(surfaces), method.denoiser)[0])
    return clean


def guides(surfaces: Path) -> dict[str, np.ndarray]:
    """Clean albedo and normals. The albedo is the share of light that comes back, so that of metals is not black."""
    albedo, specular, normal = (load(str(surfaces), layer).pixels for layer in GUIDES)
    return {"albedo": np.float32(np.clip(albedo + specular, 0, 1)), "normal": np.float32(normal)}


def denoise(noisy: np.ndarray, guide: dict[str, np.ndarray], quality: str) -> tuple[np.ndarray, float]:
    """By Open Image Denoise, at its best for exact guides; and the seconds that it took."""
    color = np.float32(np.maximum(noisy, 0))
    begun = time.perf_counter()
    clean = pyoidn.denoise(color, **guide, hdr=True, clean_aux=True, quality=quality)
    return clean, time.perf_counter() - begun


def write(path: Path, pixels: np.ndarray) -> None:
    """An OpenEXR file with R, G, B; whole or not there."""
    channels = {name: np.ascontiguousarray(pixels[..., i], np.float32) for i, name in enumerate("RGB")}
    unfinished = path.with_name(f"unfinished-{os.getpid()}-{threading.get_ident()}.tmp")
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write(
        str(unfinished)
    )
    unfinished.replace(path)
