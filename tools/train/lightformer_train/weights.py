"""Safetensors files as lightformer reads and writes them: metadata begins with a hash of the whole file.

The hash is that of engine/base/hash.h over the file with the hash's own sixteen digits read as zeros.
"""

import json
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

DTYPES = {"F32": np.dtype("<f4"), "F16": np.dtype("<f2"), "I32": np.dtype("<i4"), "U8": np.dtype("u1")}
NAMES = {dtype: name for name, dtype in DTYPES.items()}

HEAD = b'{"__metadata__":{"hash":"'
HASH_AT = 8 + len(HEAD)
ZEROS = b"0" * 16
MASK = (1 << 64) - 1


class FileError(ValueError):
    """A file that is not what it should be, or cannot be written; the message names it."""


def unreadable(path: Path, error: OSError) -> FileError:
    """What to raise of a file that the system does not give."""
    missing = isinstance(error, (FileNotFoundError, NotADirectoryError))
    return FileError(f"{path}: {'there is none' if missing else f'cannot be read ({error.strerror})'}")


def hash_bytes(data: bytes) -> int:
    """ng_hash_bytes with seed 0."""
    state = _combine(0, len(data))
    words = struct.unpack(f"<{len(data) // 8}Q", data[: len(data) // 8 * 8])
    for word in words:
        state = _combine(state, word)
    rest = data[len(data) // 8 * 8 :]
    if rest:
        state = _combine(state, int.from_bytes(rest, "little"))
    return state


def _combine(seed: int, value: int) -> int:
    x = (seed + 0x9E3779B97F4A7C15 + value) & MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & MASK
    return x ^ (x >> 31)


def write_atomically(path: Path, data: bytes) -> None:
    """Whole or not at all; then FileError."""
    with _beside(path) as beside:
        _write_through(beside, data)
        os.replace(beside, path)


def check_target(path: Path, size: int) -> None:
    """FileError if no file of so many bytes can be written there; what is there stays as it is."""
    if path.is_dir():
        raise FileError(f"{path}: is a folder; the name of a file is needed")
    with _beside(path) as beside:
        _write_through(beside, bytes(size))


def _write_through(path: Path, data: bytes) -> None:
    """To the disk, so that a full one is noticed."""
    with open(path, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def _beside(path: Path) -> Iterator[Path]:
    """The name of a file to write in place of another, which is gone afterwards. FileError for what the system says."""
    beside = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        try:
            yield beside
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(f"{path}: cannot be written ({error.strerror})") from None


def write(path: Path, tensors: dict[str, np.ndarray], notes: dict[str, str]) -> None:
    """Writes named arrays with metadata; wide elements come first, so that each is aligned."""
    arrays = {name: np.ascontiguousarray(tensor) for name, tensor in tensors.items()}
    order = sorted(arrays, key=lambda name: -arrays[name].dtype.itemsize)
    header: dict[str, object] = {"__metadata__": {"hash": ZEROS.decode(), **notes}}
    offset = 0
    for name in order:
        array = arrays[name]
        end = offset + array.nbytes
        header[name] = {"dtype": NAMES[array.dtype], "shape": list(array.shape), "data_offsets": [offset, end]}
        offset = end
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    data = bytearray(struct.pack("<Q", len(text)) + text + b"".join(arrays[name].tobytes() for name in order))
    data[HASH_AT : HASH_AT + 16] = b"%016x" % hash_bytes(bytes(data))
    write_atomically(path, bytes(data))


def read_header(path: Path) -> tuple[dict[str, dict], dict[str, str], int]:
    """Tensors by name, metadata, and where the data begin. FileError if that is not what the file holds."""
    try:
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            (length,) = struct.unpack("<Q", file.read(8))
            if length > size - 8:
                raise ValueError("it is cut off")
            header = json.loads(file.read(length))
        notes = header.pop("__metadata__", {})
        for entry in header.values():
            begin, end = entry["data_offsets"]
            count = int(np.prod(entry["shape"], dtype=np.int64))
            if not 0 <= begin <= end <= size - 8 - length or end - begin != count * DTYPES[entry["dtype"]].itemsize:
                raise ValueError("a tensor lies outside")
    except OSError as error:
        raise unreadable(path, error) from None
    except (ValueError, KeyError, TypeError, AttributeError, struct.error) as error:
        raise FileError(f"{path}: not a safetensors file ({error})") from None
    return header, notes, 8 + length


def read(path: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """All tensors and the metadata, the hash checked."""
    header, notes, begin = read_header(path)
    data = bytearray(path.read_bytes())
    digits = bytes(data[HASH_AT : HASH_AT + 16])
    data[HASH_AT : HASH_AT + 16] = ZEROS
    if digits != b"%016x" % hash_bytes(bytes(data)):
        raise FileError(f"{path}: damaged (its hash does not fit)")
    tensors = {}
    for name, entry in header.items():
        first, last = entry["data_offsets"]
        array = np.frombuffer(
            data, DTYPES[entry["dtype"]], (last - first) // DTYPES[entry["dtype"]].itemsize, begin + first
        )
        tensors[name] = array.reshape(entry["shape"])
    return tensors, notes


def map_tensors(path: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """As `read`, but mapped, not read, and so without the check of the hash (`lightformer dataset --check` has it)."""
    header, notes, begin = read_header(path)
    file = np.memmap(path, np.uint8, "r")
    tensors = {}
    for name, entry in header.items():
        first, last = entry["data_offsets"]
        tensors[name] = file[begin + first : begin + last].view(DTYPES[entry["dtype"]]).reshape(entry["shape"])
    return tensors, notes
