"""The first comparison: solids, cut by planes, reconstructed by every method."""

import sys
import tempfile
import time

import cuts
from measures import Truth
from mesh import Mesh
from methods import method
from methods.stack import NotParallel
from sections import read_csl
from solids import solids


def compare(names, options):
    """A row of figures for every solid, cut and method."""
    rows = []
    for solid in solids(options.solids, options.only):
        mesh = Mesh.read(solid.file)
        truth = Truth(mesh)
        with tempfile.TemporaryDirectory() as folder:
            for cut in all_cuts(solid, mesh, folder, options.cuts):
                rows += compared(truth, cut, names, options.resolution, solid.name)
    return rows


def all_cuts(solid, mesh, folder, kinds):
    yield from cuts.cuts(mesh, solid.file, folder, kinds)
    if "given" in kinds:
        for file in solid.given:
            yield cuts.Cut("given", "", file)


def compared(truth, cut, names, resolution, solid):
    """A row for each method that can take these sections."""
    sections = read_csl(cut.file)
    name = cut.file.stem if cut.kind == "given" else solid + cut.name
    rows = []
    for each in names:
        result, seconds = timed(method(each), cut.file, sections, resolution)
        if result is not None:
            row = {"cut": cut.kind, "input": name, "method": each, "seconds": seconds}
            rows.append(row | truth.measures(result, sections))
            what = f"{name}, {cut.kind}: {each}: IoU {rows[-1]['iou']:.3f}, {seconds:.1f} s"
            print(what, file=sys.stderr, flush=True)
    return rows


def timed(reconstruct, *arguments):
    """The result and the seconds it took; nothing, with a word, where it failed."""
    start = time.perf_counter()
    try:
        return reconstruct(*arguments), time.perf_counter() - start
    except NotParallel:
        return None, None
    except Exception as error:  # A peer's failure must not end the comparison.
        print(f"failed: {error}", file=sys.stderr)
        return None, None
