"""Ways to fill the slices that were not kept: of a volume of labels and the
kept slices' numbers they give a volume of labels, looking at those slices alone."""

import tempfile
from importlib import import_module
from pathlib import Path

import numpy as np
from scipy.ndimage import distance_transform_edt

from lattice import Lattice
from mesh import Mesh
from methods.slicewise import cubics_through, filled, lines_through
from program import run

from . import nrrd

CURVES = {"slices-linear": lines_through, "slices-cubic": cubics_through}


def method(name):
    """A function of a volume, the kept slices' numbers, and the resolution."""
    if name == "itk":
        interpolate = import_module("methods.itk").interpolate
        return lambda volume, kept, _: interpolate(only(volume, kept), kept)
    if name in CURVES:
        return lambda volume, kept, _: deepest(volume, kept, CURVES[name])
    return lambda volume, kept, resolution: ours(name, volume, kept, resolution)


def only(volume, kept):
    """A volume in which all but the kept slices are empty."""
    sparse = np.zeros_like(volume)
    sparse[:, :, kept] = volume[:, :, kept]
    return sparse


def ours(name, volume, kept, resolution):
    """The program's surfaces, one a label, and the voxels inside of them. The
    outlines are cut from the kept slices by the program."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        nrrd.write(folder / "volume.nrrd", volume)
        planes = [word for k in kept for word in ("--plane", f"0,0,1,{-k}")]
        run("slice", folder / "volume.nrrd", *planes, "-o", folder / "slices.json", "--quiet")
        run("reconstruct", folder / "slices.json", "--method", name, "--quiet",
            "--resolution", resolution, "-o", folder / "label_{label}.ply")
        lattice = Lattice(np.zeros(3), np.ones(3), volume.shape)
        result = np.zeros_like(volume)
        for label in labels_of(volume):
            surface = folder / f"label_{label}.ply"
            if surface.exists():
                result[lattice.inside(Mesh.read(surface))] = label
        return result


def deepest(volume, kept, curves_through):
    """Each label's signed distances within the kept slices, interpolated; a
    voxel has the label, or the outside, that is deepest there."""
    result = np.zeros(volume.shape, np.uint8)
    largest = -signed_distances(volume > 0, kept, curves_through)
    for label in labels_of(volume):
        values = signed_distances(volume == label, kept, curves_through)
        better = values > largest
        largest[better] = values[better]
        result[better] = label
    return result


def signed_distances(mask, kept, curves_through):
    spacing = kept[1] - kept[0]
    places = np.array([kept[0] - spacing, *kept, kept[-1] + spacing])
    slices = [None, *(signed_distance(mask[:, :, k]) for k in kept), None]
    curve = curves_through(places, filled(slices))
    return np.stack([curve(k) for k in range(mask.shape[2])], axis=2)


def signed_distance(mask):
    """To the border between pixels, positive inside; None where there is nothing inside."""
    if not mask.any():
        return None
    return np.where(mask, distance_transform_edt(mask) - 0.5, 0.5 - distance_transform_edt(~mask))


def labels_of(volume):
    return [int(label) for label in np.unique(volume) if label != 0]
