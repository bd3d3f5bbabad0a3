"""Command lines: what is wrong with one is said in one line, exit code 2."""

import argparse
from collections.abc import Callable
from pathlib import Path

SEEDS = 1 << 32


class Parser(argparse.ArgumentParser):
    """Without the usage before the line."""

    def error(self, message: str) -> None:
        """Ends the program."""
        self.exit(2, f"{Path(self.prog).stem}: {message}\n")


def whole(least: int, most: int = 10**9) -> Callable[[str], int]:
    """Type of an option: a whole number of a range."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"a whole number from {least} to {most} is needed, not {text!r}")
        return value

    return parse


def factor(text: str) -> float:
    """Type of an option: a number that is not below one."""
    return _number(text, lambda value: 1 <= value <= 1000, "a number from 1 to 1000 is needed")


def positive(text: str) -> float:
    """Type of an option: a number above zero."""
    return _number(text, lambda value: 0 < value <= 1e9, "a number above 0 is needed, up to 1e9")


def _number(text: str, fits: Callable[[float], bool], wanted: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0  # which fits no option
    if not fits(value):
        raise argparse.ArgumentTypeError(f"{wanted}, not {text!r}")
    return value
