"""The planes that solids are cut by, and solids as sections."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from program import run

PARALLEL, ALONG_EACH_AXIS, RANDOM, SEEDS = 15, 5, 20, (1, 2, 3)


@dataclass
class Cut:
    """A file of sections of a solid, and the table that it belongs to."""

    kind: str
    name: str
    file: Path


#: The tables, in their order.
KINDS = {
    "parallel": f"{PARALLEL} parallel planes across the longest side",
    "axes": f"3 × {ALONG_EACH_AXIS} axis planes",
    "random": f"{RANDOM} random planes, {len(SEEDS)} draws",
    "given": "sections that came with the solid",
}


def cuts(solid, file, folder, kinds):
    """The sections of a mesh by every kind of cut, written into a folder."""
    low, high = solid.box
    longest = "xyz"[np.argmax(high - low)]
    arguments = {
        ("parallel", ""): ["--axis", longest, "--count", PARALLEL],
        ("axes", ""): axis_planes(low, high),
    }
    for seed in SEEDS:
        arguments["random", f" {seed}"] = ["--random", RANDOM, "--seed", seed]
    for (kind, suffix), planes in arguments.items():
        if kind in kinds:
            sections = Path(folder) / f"{file.stem}-{kind}{suffix.strip()}.csl"
            run("slice", file, *planes, "-o", sections, "--quiet")
            yield Cut(kind, suffix, sections)


def axis_planes(low, high):
    """Planes normal to each axis, in the middles of equal parts of the box."""
    arguments = []
    for axis, normal in enumerate(("1,0,0", "0,1,0", "0,0,1")):
        for part in (np.arange(ALONG_EACH_AXIS) + 0.5) / ALONG_EACH_AXIS:
            place = float(low[axis] + part * (high[axis] - low[axis]))
            arguments += ["--plane", f"{normal},{-place!r}"]
    return arguments
