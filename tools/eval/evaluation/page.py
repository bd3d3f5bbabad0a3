"""The page that shows a comparison: page.html with its data inside, so that one file is all there is."""

import base64
import hashlib
import html
import json
import os
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lightformer_train import files

from . import BadInput, metrics
from .comparison import Comparison

# What the page says about each figure: its range or the value of equal pictures, and what it looks at.
MEANINGS = {
    "rse": ("0", "mean((a - b)² / (b² + 0.01)), both over the reference's mean"),
    "l1": ("0", "mean absolute difference over the reference's mean"),
    "psnr": ("∞", "peak signal to noise of the tone-mapped pictures"),
    "mean_ratio": ("1", "mean of A over mean of B: bias"),
    "ssim": ("1", "structural similarity, Gaussian window of 11"),
    "ms_ssim": ("1", "structural similarity over five scales"),
    "flip": ("0", "perceived difference when flipping between the tone-mapped pictures"),
    "hdr_flip": ("0", "the same over a range of exposures"),
    "lpips": ("0", "distance of AlexNet features"),
}


@dataclass(frozen=True)
class Shown:
    """A picture beside its reference. `figures` are (key, name, digits), `values` by key, `maps` by key or None."""

    name: str
    comparison: Comparison
    figures: tuple
    values: dict
    maps: dict


def frame(name, reference, pictures, mantissa=10):
    """What the page shows of pictures (Shown) that have one reference of this name; `mantissa`: bits that are kept."""
    c = pictures[0].comparison
    width, height = c.b.size
    return {
        "name": name,
        "width": width,
        "height": height,
        "exposure": float(c.exposure),
        "reference": {"name": reference, "data": _pack(c.reference, mantissa)},
        "pictures": [{"name": p.name, "data": _pack(p.comparison.a.pixels, mantissa), "maps": _maps(p, mantissa),
                      "figures": [_figure(p, *figure) for figure in p.figures if figure[0] in p.values]}
                     for p in pictures],
    }


def about(what):
    """The mark of a page about the same things, which it may replace."""
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:16]


def refuse_to_overwrite(path, mark):
    """BadInput if another file than a page with this mark is there."""
    try:
        with open(path, "rb") as file:
            start = file.read(1024)
    except OSError:
        return
    if mark.encode() not in start:
        raise BadInput(f"{path}: is there already, and no page about this; --force overwrites it")


def write_page(path, title, frames, layer=None, display=False, sections="", *, about, force=False):
    """Writes the page with these frames. `sections`: HTML below them. `about`: its mark."""
    if not force:
        refuse_to_overwrite(path, about)
    template = (Path(__file__).parent / "page.html").read_text(encoding="utf-8")
    data = {"frames": frames, "layer": layer, "display": display}
    text = template.replace("{{title}}", html.escape(title)).replace("{{sections}}", sections)
    text = text.replace("{{about}}", about)
    text = text.replace("{{data}}", json.dumps(data).replace("<", "\\u003c"))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"{path}: {os.strerror(error.errno)}") from error
    files.write_atomically(path, text.encode())


def _figure(picture, key, name, digits):
    best, meaning = MEANINGS[key]
    value = picture.values[key]
    if value is None:
        shown = "∞" if key == "psnr" else "–"
    else:
        shown = digits.format(value)
    return {"key": key, "name": name, "value": shown, "equal": best, "meaning": meaning}


def _maps(picture, mantissa):
    c = picture.comparison
    named = [
        ("Relative squared error", metrics.rse_map(c).mean(axis=-1), None),
        ("Absolute error over the mean", metrics.l1_map(c).mean(axis=-1), None),
        ("FLIP", picture.maps.get("flip"), 1.0),
        ("HDR-FLIP", picture.maps.get("hdr_flip"), 1.0),
    ]
    return [_map(name, values, top, c.mask, mantissa) for name, values, top in named if values is not None]


def _map(name, values, top, mask, mantissa):
    """Pixels that do not count are not numbers. The top of the scale leaves out the worst percent."""
    if top is None:
        top = float(np.percentile(values[mask], 99)) or 1.0
    return {"name": name, "top": top, "data": _pack(np.where(mask, values, np.nan), mantissa)}


def _pack(values, mantissa):
    """Little-endian half floats, deflated, in base64. A picture that a mask excuses may hold any value.

    Fewer bits of the mantissa, of ten, make smaller files; what is cut is rounded."""
    limit = float(np.finfo(np.float16).max)
    halves = np.clip(values, -limit, limit).astype("<f2")
    cut = 10 - mantissa
    if cut:
        bits = halves.view("<u2").astype(np.uint32)
        rounded = np.minimum(bits & 0x7FFF, 0x7BFF - (1 << cut)) + (1 << cut >> 1) >> cut << cut
        halves = np.where(np.isnan(halves), bits, bits & 0x8000 | rounded).astype("<u2")
    return base64.b64encode(zlib.compress(halves.tobytes(), 9)).decode()
