"""Calls of our own program."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/transect"


def run(*arguments):
    """Runs transect; what it says against it becomes the exception."""
    command = [str(PROGRAM), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr.strip()}")


def knows_method(name):
    """Whether `reconstruct` lists this method."""
    command = [str(PROGRAM), "help", "reconstruct"]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    words = text.replace("[", " ").replace("]", " ").replace(",", " ").replace(":", " ").split()
    return name in words
