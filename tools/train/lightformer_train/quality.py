"""How good a network is on crops that it did not learn from."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import torch
from torch import Tensor

from .data import Batch
from .network import Network


@dataclass
class Pictures:
    """Of one crop, [3, h, w], the reference's mean being 1; zero where there is no surface."""

    ours: dict[str, Tensor]  # "direct", "indirect", "total", "unshadowed"
    reference: dict[str, Tensor]


@dataclass
class Quality:
    """Means over crops. RSE as in lightformer/metrics: divided by the mean of the crop's reference, whose noise is part
    of the error."""

    rse: dict[str, float]
    mean_ratio: dict[str, float]  # mean of ours / mean of the reference
    crops: int
    samples_per_pixel: int  # of the reference

    def __str__(self) -> str:
        parts = (f"{name} {self.rse[name]:.4f} (mean {self.mean_ratio[name]:.3f})" for name in self.rse)
        return "RSE " + ", ".join(parts)

    def is_finite(self) -> bool:
        """Whether every figure is a number."""
        return all(math.isfinite(x) for values in (self.rse, self.mean_ratio) for x in values.values())

    def as_json(self) -> dict:
        """For a file's metadata."""
        rounded = ({name: round(x, 5) for name, x in values.items()} for values in (self.rse, self.mean_ratio))
        return dict(zip(("rse", "mean_ratio"), rounded)) | {
            "crops": self.crops,
            "samples_per_pixel": self.samples_per_pixel,
        }


def relative_squared_error(ours: Tensor, reference: Tensor) -> Tensor:
    """Mean of (A - B)^2 / (B^2 + 0.01)."""
    return ((ours - reference) ** 2 / (reference**2 + 0.01)).mean()


@torch.no_grad()
def judge(network: Network, batches: Iterable[Batch], samples_per_pixel: int) -> tuple[Quality, list[Pictures]]:
    """Of all crops of some batches, whose reference has so many samples a pixel."""
    pictures = [picture for batch in batches for picture in _pictures(network, batch)]
    names = list(pictures[0].ours)
    rse, ratio = {}, {}
    for name in names:
        rse[name] = float(sum(relative_squared_error(p.ours[name], p.reference[name]) for p in pictures)) / len(
            pictures
        )
        ratio[name] = float(
            sum(p.ours[name].mean() for p in pictures)
            / sum(p.reference[name].mean() for p in pictures).clamp_min(1e-12)
        )
    return Quality(rse, ratio, len(pictures), samples_per_pixel), pictures


def _pictures(network: Network, batch: Batch) -> list[Pictures]:
    out = network(batch.inputs, batch.lights)
    out["total"] = out["direct"] + out["indirect"]
    reference = {"unshadowed": batch.unshadowed, "direct": batch.direct, "indirect": batch.indirect}
    reference["total"] = batch.direct + batch.indirect
    found = []
    for i, mask in enumerate(batch.weight):
        scale = mask / (reference["total"][i] * mask).mean().clamp_min(1e-12)
        found.append(Pictures(*({name: x[i] * scale for name, x in kind.items()} for kind in (out, reference))))
    return found
