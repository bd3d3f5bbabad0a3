"""The report of a training as one HTML file: what was run, curves, and pictures of crops it never saw."""

import base64
import html
import math
import struct
import zlib
from dataclasses import dataclass, field

import numpy as np
from torch import Tensor

from .quality import Pictures, Quality

COLORS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b", "#17becf")
WIDTH, HEIGHT, MARGIN = 680, 260, 46

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; color: #222; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; }
table { border-collapse: collapse; } th, td { padding: .15em .8em .15em 0; text-align: left; font-weight: normal; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
code { background: #f3f3f3; padding: .1em .3em; } figure { margin: 0 0 1.2em; }
.row { display: flex; gap: 6px; } .row div { flex: 1; font-size: 13px; }
.row img { width: 100%; image-rendering: pixelated; }
svg text { font-size: 12px; fill: #444; }
"""


@dataclass
class History:
    """What a training leaves behind: points (step, value) of each curve."""

    loss: dict[str, list[tuple[int, float]]] = field(default_factory=dict)
    rse: dict[str, list[tuple[int, float]]] = field(default_factory=dict)

    @staticmethod
    def note(curves: dict[str, list[tuple[int, float]]], step: int, values: dict[str, float]) -> None:
        """Adds a point to each curve."""
        for name, value in values.items():
            curves.setdefault(name, []).append((step, value))

    @classmethod
    def restored(cls, loss: dict, rse: dict) -> "History":
        """Of what a file says. ValueError, TypeError or AttributeError if these are no curves."""
        return cls(*({str(name): [(int(step), float(value)) for step, value in curve] for name, curve in of.items()}
                     for of in (loss, rse)))


def page(title: str, facts: dict[str, str], history: History, quality: Quality, pictures: list[Pictures]) -> str:
    """The whole file."""
    rows = "".join(f"<tr><th>{html.escape(k)}</th><td>{html.escape(v)}</td></tr>" for k, v in facts.items())
    figures = "".join(
        f'<tr><td>{name}</td><td class="number">{quality.rse[name]:.4f}</td>'
        f'<td class="number">{quality.mean_ratio[name]:.3f}</td></tr>'
        for name in quality.rse
    )
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{STYLE}</style>"
        f"<h1>{html.escape(title)}</h1><table>{rows}</table>"
        f"<h2>Held-out crops</h2><table><tr><th>component</th><th>RSE</th><th>mean ratio</th></tr>{figures}</table>"
        f"<p>Radiance is divided by the mean of each crop's reference, also that of its components. References have "
        f"{quality.samples_per_pixel} samples a pixel, whose noise is part of the RSE.</p>"
        f"<h2>Loss, by term</h2>{chart(history.loss)}<h2>RSE of held-out crops</h2>{chart(history.rse)}"
        f"<h2>Pictures</h2>{''.join(_crop(p) for p in pictures)}</html>\n"
    )


def chart(curves: dict[str, list[tuple[int, float]]]) -> str:
    """Curves over steps as SVG, logarithmic."""
    points = [p for curve in curves.values() for p in curve if p[1] > 0]
    if not points:
        return "<p>Too short for a curve.</p>"
    last = max(step for step, _ in points) or 1
    low = math.floor(math.log10(min(value for _, value in points)))
    high = max(math.ceil(math.log10(max(value for _, value in points))), low + 1)

    def place(step: int, value: float) -> str:
        x = MARGIN + (WIDTH - 2 * MARGIN) * step / last
        y = HEIGHT - 30 - (HEIGHT - 45) * (math.log10(max(value, 10.0**low)) - low) / (high - low)
        return f"{x:.1f},{y:.1f}"

    parts = [f'<svg viewBox="0 0 {WIDTH + 150} {HEIGHT}" role="img">']
    for power in range(low, high + 1):
        y = place(0, 10.0**power).split(",")[1]
        parts.append(
            f'<path d="M{MARGIN} {y}H{WIDTH - MARGIN}" stroke="#ddd"/><text x="4" y="{y}">{10.0**power:g}</text>'
        )
    parts.append(f'<text x="{WIDTH - MARGIN - 60}" y="{HEIGHT - 8}">{last} steps</text>')
    for i, (name, curve) in enumerate(curves.items()):
        color = COLORS[i % len(COLORS)]
        line = " ".join(place(*point) for point in curve)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="1.5"/>')
        parts.append(
            f'<text x="{WIDTH - MARGIN + 8}" y="{30 + 18 * i}" style="fill:{color}">{html.escape(name)}</text>'
        )
    return "".join(parts) + "</svg>"


def _crop(pictures: Pictures) -> str:
    rows = []
    for name in ("total", "direct", "indirect"):
        ours, reference = pictures.ours[name], pictures.reference[name]
        error = ((ours - reference) ** 2 / (reference**2 + 0.01)).mean(0, keepdim=True).expand(3, -1, -1)
        cells = (
            ("ours", tone(ours)),
            ("reference", tone(reference)),
            ("relative squared error, white: 1", _bytes(error)),
        )
        images = "".join(f'<div><img alt="" src="{data_url(image)}">{name}, {what}</div>' for what, image in cells)
        rows.append(f'<div class="row">{images}</div>')
    return f"<figure>{''.join(rows)}</figure>"


def tone(picture: Tensor) -> np.ndarray:
    """Radiance of mean 1 as sRGB: the mean becomes 0.18, what is over white is cut."""
    x = (picture * 0.18).clamp(0, 1)
    return _bytes((x * 12.92).where(x <= 0.0031308, 1.055 * x.clamp_min(1e-8) ** (1 / 2.4) - 0.055))


def _bytes(picture: Tensor) -> np.ndarray:
    return (picture.clamp(0, 1) * 255 + 0.5).permute(1, 2, 0).to("cpu").numpy().astype(np.uint8)


def data_url(image: np.ndarray) -> str:
    """A picture of bytes, [h, w, 3], as a PNG within a page."""
    return "data:image/png;base64," + base64.b64encode(png(image)).decode()


def png(image: np.ndarray) -> bytes:
    """The smallest writer that makes a valid file."""
    height, width = image.shape[:2]
    lines = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines.tobytes(), 6)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body
