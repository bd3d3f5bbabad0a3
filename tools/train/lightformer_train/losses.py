"""What training minimizes, and what a picture is judged by.

Eq. 8 of the paper: L1 of log(1 + x) on each component, plus a perceptual term on the shadows. Two changes:

- The shadow's term is on T_d = T_l T_ls, since the bare ratio is 1 nearly everywhere, a minimum that training does not
  leave.
- L1 learns the median of noisy targets, which is too dark where paths are rare. A squared error relative to our own
  value (Lehtinen et al. 2018, Noise2Noise, 4.1) learns the mean: (a - b)^2 / (stop(a)^2 + eps). It rules T_i, which has
  little of L1, and the whole picture, which is what it is judged by. Where our value is far too bright, that would hide
  its own fault: so it is the lesser one of ours and of the mean of the target around, which has little noise.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

from .data import Batch

EPSILON = 0.02  # where the mean is about 1: dark pixels count, but do not rule
AROUND = 5  # pixels each way of that mean
LIMIT = 10.0  # relative errors, over which noise is likelier than a fault; 3 makes T_i 3 % too dark


@dataclass(frozen=True)
class Weights:
    """Of the terms."""

    unshadowed: float = 1.0
    direct: float = 2.0
    indirect: float = 0.25
    squared: float = 1.0  # of the relative squared errors, beside L1
    perceptual: float = 0.1


def radiance_unit(batches: Iterable[Batch]) -> float:
    """Mean radiance of these batches in units of frame.radiance: what makes pictures of order one."""
    total = count = 0.0
    for batch in batches:
        radiance = (batch.direct + batch.indirect) * batch.weight / _frame(batch)
        total += float(radiance.sum())
        count += 3 * float(batch.weight.sum())
    return total / max(count, 1) or 1.0


def _frame(batch: Batch) -> Tensor:
    return batch.unit.clamp_min(1e-20)[:, :, None, None]


class Loss:
    """Of the outputs of a network."""

    def __init__(self, weights: Weights, unit: float, perceptual: Callable[[Tensor, Tensor], Tensor]) -> None:
        self.weights = weights
        self.unit = unit
        self.perceptual = perceptual

    def __call__(self, out: dict[str, Tensor], batch: Batch) -> tuple[Tensor, dict[str, float]]:
        """The loss, and its terms for the report."""
        scale = 1 / (self.unit * _frame(batch))
        ours = {name: x * scale for name, x in out.items()}
        reference = {"unshadowed": batch.unshadowed, "direct": batch.direct, "indirect": batch.indirect}
        reference = {name: x * scale for name, x in reference.items()}
        logs = {name: (_log(ours[name]), _log(reference[name])) for name in ours}
        for pictures in (ours, reference):
            pictures["total"] = pictures["direct"] + pictures["indirect"]
        w, mask = self.weights, batch.weight
        terms = {name: getattr(w, name) * _mean(torch.abs(a - b), mask) for name, (a, b) in logs.items()}
        terms["perceptual"] = w.perceptual * self.perceptual(*(x * mask for x in logs["direct"]))
        for name in ("indirect", "total"):
            error = _mean(relative_squared(ours[name], reference[name]), mask)
            terms[f"{name} squared"] = w.squared * error
        total = sum(terms.values())
        return total, {name: float(term.detach()) for name, term in terms.items()}


def relative_squared(ours: Tensor, reference: Tensor) -> Tensor:
    """Least, over noisy references, at their mean. Beyond LIMIT it rises in a straight line: one path that found a
    light by chance must not decide a step."""
    around = F.avg_pool2d(reference, AROUND, stride=1, padding=AROUND // 2, count_include_pad=False)
    scale = torch.minimum(ours.detach(), around)
    error = (ours - reference).abs() / torch.sqrt(scale**2 + EPSILON)
    return torch.where(error < LIMIT, error**2, LIMIT * (2 * error - LIMIT))


def _log(x: Tensor) -> Tensor:
    return torch.log1p(x.clamp_min(0))


def _mean(x: Tensor, mask: Tensor) -> Tensor:
    return (x * mask).sum() / (mask.sum() * x.shape[1]).clamp_min(1)


def differences(ours: Tensor, reference: Tensor) -> Tensor:
    """Stands in for VGG features where they cost too much: L1 of differences between neighbours, at three scales."""
    difference = ours - reference
    total = difference.new_zeros(())
    for _ in range(3):
        total = total + (difference[..., 1:] - difference[..., :-1]).abs().mean()
        total = total + (difference[..., 1:, :] - difference[..., :-1, :]).abs().mean()
        difference = F.avg_pool2d(difference, 2)
    return total
