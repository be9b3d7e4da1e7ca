"""Our own methods, by the program as it is built."""

import tempfile
from pathlib import Path

from mesh import Mesh
from program import run


def reconstruct(method, file, resolution):
    """The mesh that `transect reconstruct` makes of a file of sections."""
    with tempfile.TemporaryDirectory() as folder:
        surface = Path(folder) / "surface.ply"
        run("reconstruct", file, "--method", method, "--resolution", resolution, "--quiet",
            "-o", surface)
        return Mesh.read(surface)
