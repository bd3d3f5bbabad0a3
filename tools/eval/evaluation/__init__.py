"""Metrics of pictures against their references: lightformer/metrics/README.md has the definitions."""


class BadInput(Exception):
    """What is wrong with a file or with two of them, in one line."""
