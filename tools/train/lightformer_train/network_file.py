"""Networks in files (lightformer/net/README.md, "The file")."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch

from . import families, program, weights
from .network import Network

FORMAT = "lightformer-net"
VERSION = "1"


@dataclass
class Description:
    """What a file says of its network beside the program."""

    preset: str = ""
    without: frozenset[str] = frozenset()
    training: str = ""  # the command
    data: str = ""  # the commands that made its data sets
    dataset: str = ""  # hash of its manifest
    quality: dict = field(default_factory=dict)
    precision: str = ""  # of products in training, as "bf16, fp32 from step 31"

    def notes(self) -> dict[str, str]:
        """The file's metadata."""
        return {
            "family": families.PRESETS[self.preset].family,
            "preset": self.preset + "".join(f" without {part}" for part in sorted(self.without)),
            "training": self.training,
            "data": self.data,
            "dataset": self.dataset,
            "quality": json.dumps(self.quality),
            "precision": self.precision,
        }


def create(preset: str, without: frozenset[str] = frozenset(), precision: torch.dtype = torch.float32) -> Network:
    """An untrained network; its weights follow from torch's seed."""
    return Network(program.check(families.build(preset, without)), precision)


def save(path: Path, network: Network, notes: dict[str, str]) -> None:
    """Whole or not at all."""
    tensors = {name: value.numpy().astype(np.float32) for name, value in network.tensors().items()}
    head = {"format": FORMAT, "version": VERSION, "inputs": program.INPUTS_VERSION}
    text = json.dumps(network.checked.operations, separators=(",", ":"))
    weights.write(path, tensors, {**head, "program": text, **notes})


def load(path: Path, precision: torch.dtype = torch.float32) -> tuple[Network, dict[str, str]]:
    """A network and its file's metadata. FileError if it is not one."""
    tensors, notes = weights.read(path)
    if notes.get("format") != FORMAT or notes.get("version") != VERSION:
        raise weights.FileError(f"{path}: not a network of version {VERSION}")
    if notes.get("inputs") != program.INPUTS_VERSION:
        raise weights.FileError(f"{path}: trained with inputs of another version than {program.INPUTS_VERSION}")
    try:
        network = Network(program.check(json.loads(notes["program"])), precision)
        network.load({name: torch.from_numpy(value.astype(np.float32)) for name, value in tensors.items()})
    except (KeyError, ValueError, RuntimeError) as error:
        raise weights.FileError(f"{path}: {str(error).splitlines()[0]}") from None
    return network, notes
