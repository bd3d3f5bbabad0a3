"""Presets: the families of networks at several widths, each with parts left out on demand."""

from dataclasses import dataclass

from . import lean, paper, structured
from .program import Operation


@dataclass(frozen=True)
class Preset:
    """A family at its widths."""

    family: str
    widths: object
    about: str


PRESETS = {
    "lean": Preset("lean", lean.Widths(), "the default: real time on CPUs, in any scene"),
    "structured-small": Preset("structured", structured.Widths(), "what neighbours, lights and directions tell, too"),
    "structured": Preset(
        "structured",
        structured.Widths(
            light=32,
            texel=(64, 96),
            indirect=48,
            view=(32, 48, 64, 64),
            clue=12,
            head=24,
            screen=(48, 64, 96, 96),
            features=24,
            decoder=48,
        ),
        "wider",
    ),
    "paper": Preset("paper", paper.Widths(), "the paper's architecture at its own widths"),
    "paper-small": Preset(
        "paper",
        paper.Widths(
            direct=(64, 64, 32),
            indirect=(64, 64, 32),
            specular=(16, 16),
            view=(8, 16, 24, 32, 48),
            query=32,
            decoder=64,
            latent=16,
            shadow=32,
        ),
        "the paper's architecture, small enough to train on CPUs",
    ),
}

FAMILIES = {"lean": lean, "paper": paper, "structured": structured}


def parts(preset: str) -> dict[str, str]:
    """What may be left out of a preset's network, and what that means."""
    return FAMILIES[PRESETS[preset].family].PARTS


def build(preset: str, without: frozenset[str] = frozenset()) -> list[Operation]:
    """The program of a preset. ValueError if it has no such part or preset."""
    if preset not in PRESETS:
        raise ValueError(f'no preset "{preset}"; there are {", ".join(PRESETS)}')
    unknown = without - parts(preset).keys()
    if unknown:
        raise ValueError(f'{preset} has no part "{min(unknown)}"; it has {", ".join(parts(preset))}')
    return FAMILIES[PRESETS[preset].family].build(PRESETS[preset].widths, without)
