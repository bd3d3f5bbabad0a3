"""Processes that tests wait for."""

import time
from pathlib import Path


def wait_until(done):
    """Fails by the time limit of the test as a whole."""
    while not done():
        time.sleep(0.2)


def find_processes(program, folder):
    """Those of a program whose command names a file in a folder."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = entry.read_bytes().split(b"\0")
        except OSError:
            continue
        if any(word.endswith(program.encode()) for word in words) and any(bytes(folder) in word for word in words):
            found.append(int(entry.parent.name))
    return found
