"""What a data set says of itself (lightformer/dataset/README.md, "A folder")."""

import json
import shlex
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from . import files

REPEATED = ("size", "crop", "crops", "spp", "depth", "vpls", "time", "camera")  # settings that are options
LARGEST_SHARD = 64  # samples: more than the fewest that explain the files


@dataclass(frozen=True, order=True)
class Shard:
    """A file of consecutive seeds."""

    first: int
    samples: int
    file: str

    @property
    def end(self) -> int:
        """The seed after its last."""
        return self.first + self.samples


@dataclass(frozen=True)
class Manifest:
    """Of one folder."""

    folder: Path
    text: bytes
    settings: dict[str, str]
    shards: list[Shard]

    @property
    def samples_per_pixel(self) -> int:
        """Of its targets."""
        return int(self.settings["spp"])

    @property
    def crops(self) -> int:
        """Of each sample."""
        return int(self.settings["crops"])

    @property
    def crop(self) -> int:
        """Pixels a side."""
        return int(self.settings["crop"])

    def command(self) -> str:
        """What makes it anew, by names alone; several commands if its seeds have gaps."""
        return " && ".join(self._command(run) for run in self._runs())

    def _command(self, run: list[Shard]) -> str:
        settings = self.settings
        words = ["lightformer", "dataset", settings["scene"], "-o", self.folder.resolve().name]
        words += ["--seed", str(run[0].first), "--count", str(run[-1].end - run[0].first)]
        for name in REPEATED:
            if settings[name]:
                words += [f"--{name}", settings[name]]
        words += ["--shard", str(_samples_of_a_shard(run) * int(settings["crops"]))]
        return shlex.join(words)

    def _runs(self) -> list[list[Shard]]:
        """Shards of consecutive seeds."""
        shards = sorted(self.shards)
        cuts = [i + 1 for i, (a, b) in enumerate(pairwise(shards)) if a.end != b.first]
        return [shards[a:b] for a, b in pairwise([0, *cuts, len(shards)])]


def _samples_of_a_shard(run: list[Shard]) -> int:
    """The fewest that cut these seeds where the files are cut: at multiples (lightformer/dataset/dataset.h)."""
    largest = max(shard.samples for shard in run)
    sizes = range(largest, largest + LARGEST_SHARD)
    return next((size for size in sizes if _cuts(run, size)), largest)


def _cuts(run: list[Shard], size: int) -> bool:
    return all(s.first // size == (s.end - 1) // size for s in run) and all(s.first % size == 0 for s in run[1:])


def read(folder: Path) -> Manifest:
    """FileError if it is not one."""
    path = folder / "manifest.json"
    try:
        text = path.read_bytes()
        content = json.loads(text)
        settings = {name: str(content["settings"][name]) for name in ("format", "scene", *REPEATED)}
        shards = [Shard(int(s["first_seed"]), int(s["samples"]), str(s["file"])) for s in content["shards"]]
        if any(int(settings[name]) < 1 for name in ("spp", "crops", "crop")):
            raise ValueError("a number is out of range")
        if any(s.first < 0 or s.samples < 1 or Path(s.file).name != s.file for s in shards):
            raise ValueError("a shard is none of this folder")
    except OSError as error:
        raise files.unreadable(path, error) from None
    except (ValueError, OverflowError, KeyError, TypeError, RecursionError) as error:
        raise files.FileError(f"{path}: not the manifest of a data set ({error})") from None
    return Manifest(folder, text, settings, shards)
