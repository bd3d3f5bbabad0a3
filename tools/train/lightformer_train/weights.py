"""Safetensors files as lightformer reads and writes them: metadata begins with a hash of the whole file.

The hash is that of engine/base/hash.h over the file with the hash's own sixteen digits read as zeros.
"""

import json
import math
import os
import stat
import struct
from pathlib import Path

import numpy as np

from .files import FileError, unreadable, write_atomically

DTYPES = {"F32": np.dtype("<f4"), "F16": np.dtype("<f2"), "I32": np.dtype("<i4"), "U8": np.dtype("u1")}
NAMES = {dtype: name for name, dtype in DTYPES.items()}

HEAD = b'{"__metadata__":{"hash":"'
HASH_AT = 8 + len(HEAD)
ZEROS = b"0" * 16
MASK = (1 << 64) - 1


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
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:  # of a pipe: not waiting
            found = os.fstat(file.fileno())
            if not stat.S_ISREG(found.st_mode):
                raise ValueError("not a regular file")
            (length,) = struct.unpack("<Q", file.read(8))
            room = found.st_size - 8 - length
            if room < 0:
                raise ValueError("it is cut off")
            header = json.loads(file.read(length))
        notes = header.pop("__metadata__", {})
        if not all(isinstance(text, str) for text in notes.values()):
            raise ValueError("its metadata are not text")
        for name, entry in header.items():
            _check_entry(name, entry, room)
    except OSError as error:
        raise unreadable(path, error) from None
    except KeyError as error:
        raise FileError(f"{path}: not a safetensors file (a tensor without {error})") from None
    except (ValueError, TypeError, AttributeError, RecursionError, struct.error) as error:
        raise FileError(f"{path}: not a safetensors file ({error})") from None
    return header, notes, 8 + length


def _check_entry(name: str, entry: dict, room: int) -> None:
    """ValueError if a tensor is not within the `room` bytes of data."""
    dtype, shape, (begin, end) = entry["dtype"], entry["shape"], entry["data_offsets"]
    if dtype not in DTYPES:
        raise ValueError(f"{name} is of type {dtype}; there are {', '.join(DTYPES)}")
    if not all(type(x) is int and x >= 0 for x in (*shape, begin, end)):
        raise ValueError(f"{name} has a size or a place that is none")
    if end > room:
        raise ValueError(f"it is cut off: {name} ends {end - room} bytes behind it")
    if end - begin != math.prod(shape) * DTYPES[dtype].itemsize:
        raise ValueError(f"{name} takes other than the bytes of its shape")


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
