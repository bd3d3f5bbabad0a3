"""The page that shows a comparison: page.html with its data inside, so that one file is all there is."""

import base64
import html
import json
import os
import zlib
from pathlib import Path

import numpy as np

from . import BadInput, metrics

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


def write_page(folder, description, figures, values, c, maps):
    """Writes folder/index.html. `figures` are (key, name, digits), `values` by key, `maps` by key or None."""
    template = (Path(__file__).parent / "page.html").read_text(encoding="utf-8")
    rows = [(key, name, digits) for key, name, digits in figures if key in values]
    text = template.replace("{{title}}", html.escape(f"{description['a']} against {description['b']}"))
    text = text.replace("{{rows}}", "\n".join(_row(*row, values) for row in rows))
    text = text.replace("{{data}}", json.dumps(_data(description, c, maps)).replace("<", "\\u003c"))
    try:
        os.makedirs(folder, exist_ok=True)
        path = Path(folder) / "index.html"
        unfinished = path.with_suffix(".tmp")
        unfinished.write_text(text, encoding="utf-8")
        os.replace(unfinished, path)
    except OSError as error:
        raise BadInput(f"{folder}: {os.strerror(error.errno)}") from error


def _row(key, name, digits, values):
    best, meaning = MEANINGS[key]
    value = values[key]
    if value is None:
        shown = "∞" if key == "psnr" else "–"
    else:
        shown = digits.format(value)
    return (f'<tr id="figure-{key}" title="{html.escape(meaning)}"><th scope="row">{name}</th>'
            f"<td>{shown}</td><td>{best}</td></tr>")


def _data(description, c, maps):
    width, height = c.b.size
    named = [
        ("Relative squared error", metrics.rse_map(c).mean(axis=-1), None),
        ("Absolute error over the mean", metrics.l1_map(c).mean(axis=-1), None),
        ("FLIP", maps["flip"], 1.0),
        ("HDR-FLIP", maps["hdr_flip"], 1.0),
    ]
    return {
        "width": width,
        "height": height,
        "exposure": float(c.exposure),
        "display": c.b.display,
        "a": {"name": description["a"], "data": _pack(c.a.pixels)},
        "b": {"name": description["b"], "data": _pack(c.reference)},
        "layer": description["layer"],
        "maps": [_map(name, values, top, c.mask) for name, values, top in named if values is not None],
    }


def _map(name, values, top, mask):
    """Pixels that do not count are not numbers. The top of the scale leaves out the worst percent."""
    if top is None:
        top = float(np.percentile(values[mask], 99)) or 1.0
    return {"name": name, "top": top, "data": _pack(np.where(mask, values, np.nan))}


def _pack(values):
    """Little-endian half floats, deflated, in base64. A picture that a mask excuses may hold any value."""
    limit = float(np.finfo(np.float16).max)
    halves = np.clip(values, -limit, limit).astype("<f2")
    return base64.b64encode(zlib.compress(halves.tobytes(), 6)).decode()
