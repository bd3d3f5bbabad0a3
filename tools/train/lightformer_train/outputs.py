"""What a training writes: the network, a report beside it, and, while it works, a checkpoint and a lock."""

import io
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile

import torch

from . import files, weights


class Stopped(RuntimeError):
    """A training that cannot begin or go on; the message says why."""


@dataclass(frozen=True)
class Outputs:
    """Named after the network."""

    network: Path

    @property
    def report(self) -> Path:
        """What the training was and came to, to look at."""
        return self.network.with_suffix(".html")

    @property
    def checkpoint(self) -> Path:
        """From which an interrupted training goes on."""
        return self.network.with_suffix(".checkpoint")

    @property
    def lock(self) -> Path:
        """Of the training at work."""
        return self.network.with_suffix(".checkpoint.lock")

    def clash(self, folders: list[Path]) -> Path | None:
        """The first of what is written that is a manifest or a shard of the data, by whatever path."""
        data = [file for folder in folders for name in ("manifest.json", "shard-*") for file in folder.glob(name)]
        for path in (self.network, self.report, self.checkpoint, self.lock):
            if path.exists() and any(path.samefile(entry) for entry in data):
                return path
        return None

    def refuse_to_overwrite(self) -> None:
        """Stopped, if an earlier training would be lost."""
        if self.checkpoint.exists():
            raise Stopped(
                f"{self.checkpoint}: an interrupted training left it; --resume goes on from there, "
                "--force begins anew and overwrites it"
            )
        self.refuse_to_replace()

    def refuse_to_replace(self) -> None:
        """Stopped, if a network or a report is there."""
        for path in (self.network, self.report):
            if path.exists():
                raise Stopped(f"{path}: is there already; --force overwrites it, another -o keeps it")

    def holds(self, training: str, dataset: str) -> bool:
        """Whether the network is what this training with these data has written."""
        try:
            _, notes, _ = weights.read_header(self.network)
        except weights.FileError:
            return False
        return (notes.get("training"), notes.get("dataset")) == (training, dataset)

    def check(self, size: int) -> None:
        """FileError or Stopped if a network of about so many bytes, or what comes beside it, cannot be written there."""
        files.check_target(self.network, size)
        for beside in (self.checkpoint, self.report, self.lock):
            if beside == self.network:
                raise Stopped(f"{self.network}: is the name of a file beside the network; name that .safetensors")
        for beside in (self.checkpoint, self.report):
            files.check_target(beside, 0)

    def remove_unfinished(self) -> None:
        """Of trainings that were killed."""
        for path in (self.network, self.report, self.checkpoint):
            files.remove_unfinished(path)


def write_checkpoint(path: Path, state: dict) -> None:
    """Tensors, whole numbers, texts and their collections, which is all that `read_checkpoint` of torch 1.13 takes. Whole
    or not at all; then FileError, and the one before is still there."""
    buffer = io.BytesIO()
    torch.save(state, buffer)
    files.write_atomically(path, buffer.getvalue())


def read_checkpoint(path: Path, device: torch.device) -> dict:
    """What `write_checkpoint` wrote; a pickle that names anything else is refused before that is called. Of other files
    it raises anything, OSError if the system does not give them."""
    with open(path, "rb") as file:
        if file.read(4) != b"PK\x03\x04":  # torch would look for its older formats, whose readers trust more
            raise ValueError("it does not begin as one")
        with ZipFile(file) as archive:  # whose checksums torch does not look at
            if archive.testzip():
                raise ValueError("its checksums do not fit")
            if any(name.endswith("constants.pkl") for name in archive.namelist()):
                raise ValueError("it holds a program")  # of TorchScript, which torch would load
        file.seek(0)
        return torch.load(file, map_location=device, weights_only=True)
