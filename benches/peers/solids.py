"""The solids: a folder of meshes of our own, and the references of the data."""

import os
from dataclasses import dataclass
from pathlib import Path

from program import ROOT

#: The sections that came with a reference; eight_20 is the solid of eight_15.
GIVEN = {"hand_ok": ["hand_ok"], "eight_15": ["eight_15", "eight_20"], "Elephant": ["Elephant"]}


@dataclass
class Solid:
    """A closed mesh, and files of sections that came with it."""

    name: str
    file: Path
    given: list


def solids(folder, only):
    """Those whose names contain one of the words, or all of them."""
    found = [*own(folder), *references()]
    return [solid for solid in found if not only or any(word in solid.name for word in only)]


def own(folder):
    if folder is None or not Path(folder).is_dir():
        print("skipped: no folder of solids (--solids); ./x bench peers makes one")
        return []
    return [Solid(file.stem, file, []) for file in sorted(Path(folder).glob("*.ply"))]


def references():
    data = Path(os.environ.get("TRANSECT_DATA", ROOT.parent / "shared/data"))
    if not (data / "reference").is_dir():
        print(f"skipped: {data / 'reference'} is absent")
        return []
    found = []
    for name, given in GIVEN.items():
        sections = [data / f"csl/{each}.csl" for each in given]
        found.append(Solid(name, data / f"reference/{name}_scaled.stl", sections))
    return found
