"""What this machine and this process of a training are."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import torch
import torch.distributed as distributed
from torch import Tensor

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of malloc.h
LARGEST_BLOCK = 1 << 30


class Lost(RuntimeError):
    """A process of the training is not there any more; the message says so."""


@contextmanager
def _together() -> Iterator[None]:
    """What all processes do together: where one is missing, the others learn it here."""
    try:
        yield
    except RuntimeError:
        raise Lost("another process of the training has ended") from None


class Processes:
    """The processes of one training, as torchrun starts them; one if it did not."""

    def __init__(self) -> None:
        self.rank = int(os.environ.get("RANK", 0))
        self.count = int(os.environ.get("WORLD_SIZE", 1))
        self.here = int(os.environ.get("LOCAL_WORLD_SIZE", 1))
        self.device = torch.device("cpu")
        if torch.cuda.is_available():
            self.device = torch.device("cuda", int(os.environ.get("LOCAL_RANK", 0)))
        if self.count > 1 and not distributed.is_initialized():
            with _together():
                distributed.init_process_group("nccl" if self.device.type == "cuda" else "gloo")

    @property
    def first(self) -> bool:
        """Whether this is the one that writes and speaks."""
        return self.rank == 0

    def average(self, tensors: list[Tensor]) -> None:
        """Over all processes, in place. Lost: nothing is changed."""
        if self.count == 1:
            return
        flat = torch.cat([x.flatten() for x in tensors])
        with _together():
            distributed.all_reduce(flat)
        flat /= self.count
        for x, part in zip(tensors, flat.split([x.numel() for x in tensors])):
            x.copy_(part.view_as(x))

    def agree(self, number: int) -> int:
        """The first process's number. Lost as above."""
        if self.count == 1:
            return number
        shared = torch.tensor([number], device=self.device)
        with _together():
            distributed.broadcast(shared, 0)
        return int(shared)

    def finish(self) -> None:
        """Ends the group."""
        if distributed.is_available() and distributed.is_initialized():
            distributed.destroy_process_group()


def set_threads(wanted: int, processes: Processes) -> int:
    """As many as asked for, or as the cores that fall to this process; torch alone may choose one."""
    threads = wanted or max(1, (os.cpu_count() or 1) // processes.here)
    torch.set_num_threads(threads)
    return threads


def keep_memory() -> None:
    """Large blocks stay with the process, where glibc would return each to the system and have it zeroed anew."""
    libc = ctypes.CDLL(None)
    if hasattr(libc, "mallopt"):
        libc.mallopt(M_MMAP_THRESHOLD, LARGEST_BLOCK)
        libc.mallopt(M_TRIM_THRESHOLD, LARGEST_BLOCK)


PRECISIONS = {"fp32": torch.float32, "bf16": torch.bfloat16}  # of products
AUTO = "auto"  # bf16 where the hardware multiplies it
CPU_FLAGS = {"avx512_bf16", "amx_bf16"}  # with one of which it does; others emulate it, ten times as slowly as fp32
CUDA_CAPABILITY = 8  # from which it does


def precision(name: str, device: torch.device) -> torch.dtype:
    """Of PRECISIONS, or AUTO."""
    if name != AUTO:
        return PRECISIONS[name]
    return torch.bfloat16 if _has_bf16(device) else torch.float32


def name_of(chosen: torch.dtype) -> str:
    """The name of a precision."""
    return next(name for name, dtype in PRECISIONS.items() if dtype == chosen)


def said(chosen: torch.dtype, device: torch.device) -> str:
    """What is used, and why: whether it is the fast one there."""
    return f"products in {name_of(chosen)}: {_reason(chosen, device)}"


def _reason(chosen: torch.dtype, device: torch.device) -> str:
    where = "this GPU" if device.type == "cuda" else "this CPU"
    has = _has_bf16(device)
    if chosen == torch.bfloat16:
        return f"{where} multiplies it" if has else f"as asked for; {where} emulates it, slowly"
    return f"as asked for; {where} also multiplies bf16, faster" if has else f"{where} multiplies no bf16"


def _has_bf16(device: torch.device) -> bool:
    if device.type == "cuda":
        return torch.cuda.get_device_capability(device)[0] >= CUDA_CAPABILITY
    return not CPU_FLAGS.isdisjoint(_cpu_flags())


def _cpu_flags() -> list[str]:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    return next((line.split() for line in lines if line.startswith("flags")), [])
