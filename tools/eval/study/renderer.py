"""Pictures by the command line `lightformer`, each made once.

A picture's file is named after all that it follows from: the scene's bytes, the options and, except for references,
the program's and the weights' bytes. So an interrupted study goes on where it was, and a new program or new weights
give new pictures beside the same references.
"""

import hashlib
import json
import os
import shlex
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from urllib.parse import unquote

from evaluation import BadInput

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ.get("LIGHTFORMER", ROOT / "build/release/bin/lightformer"))


@dataclass(frozen=True)
class Shot:
    """One picture to make. `options` are those of `lightformer render`, without scene, output, size and layers."""

    scene: Path
    size: int  # pixels a side
    options: tuple[str, ...]
    layers: tuple[str, ...] = ()
    weights: Path | None = None

    @property
    def traced(self) -> bool:
        """Whether the path tracer makes it."""
        return "reference" in self.options


def variation(scene: Path, seed: int, size: int) -> Shot:
    """A test frame: the sample that a data set would have under this seed."""
    return Shot(scene, size, ("--variation", str(seed)))


def moment(scene: Path, frame: int, size: int) -> Shot:
    """A frame of the scene's own animation."""
    return Shot(scene, size, ("--frames", f"{frame}..{frame}"))


@cache
def digest(path: Path) -> str:
    """The hash of a file's bytes."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    except OSError as error:
        raise BadInput(f"{path}: {os.strerror(error.errno)}") from error


@cache
def scene_digest(path: Path) -> str:
    """The same of a scene and of the files that it names."""
    named = [path.parent / unquote(uri) for uri in _uris(_content(path))]
    hashes = [digest(path), *(digest(file) for file in named if file.is_file())]
    return hashlib.sha256(" ".join(hashes).encode()).hexdigest()[:16] if len(hashes) > 1 else hashes[0]


def _content(path: Path) -> object:
    """The JSON of a glTF file; None if it is not one, which lightformer will say."""
    data = path.read_bytes() if path.is_file() else b""
    if data[:4] == b"glTF":
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    try:
        return json.loads(data)
    except (ValueError, RecursionError):
        return None


def _uris(content: object) -> Iterator[str]:
    """Of files, wherever they stand."""
    if isinstance(content, list):
        for part in content:
            yield from _uris(part)
    elif isinstance(content, dict):
        for key, part in content.items():
            if key == "uri" and isinstance(part, str) and not part.startswith("data:"):
                yield part
            else:
                yield from _uris(part)


class Renderer:
    """Makes pictures in a folder."""

    def __init__(self, folder: Path, program: Path = PROGRAM) -> None:
        self.folder, self.program = folder, program
        self.making: dict[Path, threading.Lock] = {}  # one thread makes a picture, others wait for it
        self.running: set[subprocess.Popen] = set()
        self.stopped = False
        if not os.access(program, os.X_OK):
            raise BadInput(f"{program}: no such program: run tools/build")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInput(f"{folder}: {os.strerror(error.errno)}") from error

    @property
    def version(self) -> str:
        """Of the program: a hash of its bytes."""
        return digest(self.program)

    def path(self, shot: Shot, suffix: str = "") -> Path:
        """Where a picture is, or will be. `suffix`: of what is made from it."""
        made_by = [scene_digest(shot.scene), shot.size, shot.options, shot.layers]
        if not shot.traced:
            made_by += [self.version, shot.weights and digest(shot.weights)]
        key = hashlib.sha256(json.dumps(made_by).encode()).hexdigest()[:12]
        return self.folder / f"{shot.scene.stem}-{shot.options[1].partition('.')[0]}-{key}{suffix}.exr"

    def picture(self, shot: Shot) -> Path:
        """The file of a picture, made if it is not there."""
        path = self.path(shot)
        with self.making.setdefault(path, threading.Lock()):
            if not path.exists():
                self._make(shot, path)
        return path

    def _make(self, shot: Shot, path: Path) -> None:
        arguments = [*shot.options, "--size", f"{shot.size}x{shot.size}"]
        if shot.weights:
            arguments += ["--weights", str(shot.weights)]
        if shot.layers:
            arguments += ["--aov", ",".join(shot.layers)]
        begun = time.monotonic()
        unfinished = path.with_name(f"unfinished-{os.getpid()}-{threading.get_ident()}.exr")
        printed = self.run("render", str(shot.scene), "-o", str(unfinished), *arguments)
        made = Path(printed.strip())  # numbered, if it is a frame
        if not made.is_file():
            raise BadInput(f"{self.program}: made no picture; is it lightformer?")
        os.replace(made, path)
        print(f"{time.monotonic() - begun:8.1f} s  {' '.join(shot.options)}", file=sys.stderr)

    def measure(self, *arguments: str) -> dict:
        """What `lightformer bench --json` says."""
        try:
            return json.loads(self.run("bench", *arguments, "--json"))
        except ValueError as error:
            raise BadInput(f"{self.program}: bench --json: {error}; is it lightformer?") from None

    def run(self, *arguments: str) -> str:
        """What the program prints."""
        process = subprocess.Popen(
            [self.program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.running.add(process)
        if self.stopped:
            process.terminate()
        try:
            printed, errors = process.communicate()
        except BaseException:
            process.terminate()
            raise
        finally:
            self.running.discard(process)
        if process.returncode != 0:
            ended = f"signal {-process.returncode}" if process.returncode < 0 else f"exit code {process.returncode}"
            lines = errors.strip().splitlines() or [ended]
            raise BadInput(f"lightformer {shlex.join(arguments)}: {lines[-1]}")
        return printed

    def stop(self) -> None:
        """Ends what is running, in whatever thread, for good."""
        self.stopped = True
        for process in list(self.running):
            process.terminate()
