"""What a data set says of itself (lightformer/dataset/README.md, "A folder")."""

import json
from dataclasses import dataclass
from pathlib import Path

from . import weights

SETTINGS = ("format", "scene", "crops", "spp")


@dataclass(frozen=True, order=True)
class Shard:
    """A file of consecutive seeds."""

    first: int
    samples: int
    file: str


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


def read(folder: Path) -> Manifest:
    """FileError if it is not one."""
    path = folder / "manifest.json"
    try:
        text = path.read_bytes()
        content = json.loads(text)
        settings = {name: str(content["settings"][name]) for name in SETTINGS}
        shards = [Shard(int(s["first_seed"]), int(s["samples"]), str(s["file"])) for s in content["shards"]]
        if int(settings["spp"]) < 1 or int(settings["crops"]) < 1 or any(s.first < 0 or s.samples < 1 for s in shards):
            raise ValueError("a number is out of range")
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise weights.FileError(f"{path}: not the manifest of a data set ({error})") from None
    return Manifest(folder, text, settings, shards)
