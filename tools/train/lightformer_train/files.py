"""Files that are whole or not there, kept apart from those of others. It does without PyTorch and NumPy."""

import errno
import fcntl
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PART = ".part"  # the end of the name of a file that is being written


class FileError(ValueError):
    """A file that is not what it should be, or cannot be written; the message names it."""


def unreadable(path: Path, error: OSError) -> FileError:
    """What to raise of a file that the system does not give."""
    missing = isinstance(error, (FileNotFoundError, NotADirectoryError))
    return FileError(f"{path}: {'there is none' if missing else f'cannot be read ({error.strerror})'}")


def write_atomically(path: Path, data: bytes) -> None:
    """Whole or not at all; then FileError, and what was there is there. A link stays one, a replaced file keeps its
    mode; one that is write-protected is not replaced."""
    with _beside(path) as (unfinished, target):
        _fill(unfinished, data)
        os.replace(unfinished, target)
        _to_disk(target.parent)


def check_target(path: Path, size: int) -> None:
    """FileError if no file of so many bytes can be written there; what is there stays as it is."""
    if path.is_dir():
        raise FileError(f"{path}: is a folder; the name of a file is needed")
    with _beside(path) as (unfinished, _):
        _fill(unfinished, bytes(size))


def remove_unfinished(path: Path) -> None:
    """What writers of this file left that were killed. Nobody else may be writing it."""
    target = _target(path)
    if target.parent.is_dir():
        for name in os.listdir(target.parent):
            if name.startswith(f"{target.name}.") and name.endswith(PART):
                (target.parent / name).unlink(missing_ok=True)


@contextmanager
def locked(path: Path, what: str) -> Iterator[int]:
    """Nobody else holds this file meanwhile, nor while a process lives that inherits the descriptor. FileError, which
    begins with `what`, if another does. Where the file system knows no locks, there is none."""
    try:
        descriptor = _lock(path)
    except BlockingIOError:
        raise FileError(f"{what} is at work there") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be written ({error.strerror})") from None
    try:
        yield descriptor
    finally:
        path.unlink(missing_ok=True)
        os.close(descriptor)


def _lock(path: Path) -> int:
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno not in (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP):
                os.close(descriptor)
                raise
        if os.fstat(descriptor).st_nlink:
            return descriptor
        os.close(descriptor)  # who held it has just removed it


def _target(path: Path) -> Path:
    """Where a link leads."""
    return Path(os.path.realpath(path))


@contextmanager
def _beside(path: Path) -> Iterator[tuple[Path, Path]]:
    """A new file, which is gone afterwards unless it was renamed, and the name that it is for. FileError for what the
    system says."""
    target = _target(path)
    unfinished = target.with_name(f"{target.name}.{secrets.token_hex(8)}{PART}")
    try:
        try:
            _create(unfinished, target)
            yield unfinished, target
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(f"{path}: cannot be written ({error.strerror})") from None


def _create(unfinished: Path, target: Path) -> None:
    """With the mode of the file that it replaces."""
    mode = target.stat().st_mode if target.exists() else None
    if mode is not None and not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "not a regular file is there")
    if mode is not None and not mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH):
        raise PermissionError(errno.EACCES, "it is write-protected")
    descriptor = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666)
    try:
        if mode is not None:
            os.fchmod(descriptor, stat.S_IMODE(mode) | stat.S_IWUSR)
    finally:
        os.close(descriptor)


def _fill(path: Path, data: bytes) -> None:
    """To the disk, so that a full one is noticed."""
    with open(path, "r+b") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _to_disk(folder: Path) -> None:
    """The names in a folder, where the file system can: a rename, too, must outlast a power cut."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
