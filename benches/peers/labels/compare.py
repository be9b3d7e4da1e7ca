"""Runs the second comparison."""

import sys

import numpy as np
from scipy.ndimage import label as connected

from measures import dice
from shapes import timed

from .methods import labels_of, method
from .volumes import volumes

#: Neighbours that hang together: those that share a face, an edge or a corner.
TOUCHING = np.ones((3, 3, 3), int)


def compare(names, options):
    """A row of figures for every volume and method; rbf knows no labels."""
    rows = []
    for volume in volumes():
        if options.only and not any(word in volume.name for word in options.only):
            continue
        for name in names:
            if name == "rbf":
                continue
            result, seconds = timed(
                method(name), volume.voxels, volume.kept, options.resolution
            )
            if result is not None:
                row = {"input": volume.name, "method": name, "seconds": seconds}
                rows.append(row | measures(result, volume.voxels))
                what = f"{volume.name}: {name}: Dice {rows[-1]['dice']:.3f}, {seconds:.1f} s"
                print(what, file=sys.stderr, flush=True)
    return rows


def measures(result, truth):
    """Dice of every label over the whole volume, the part of voxels with the
    right label of those that either has a material at, and the pieces of all
    labels."""
    labels = labels_of(truth)
    figures = [dice(result == label, truth == label) for label in labels]
    either = (result > 0) | (truth > 0)
    return {
        "dice": float(np.mean(figures)),
        "least_dice": min(figures),
        "voxels": float((result == truth)[either].mean()),
        "pieces": pieces(result, labels),
        "true_pieces": pieces(truth, labels),
    }


def pieces(voxels, labels):
    return sum(connected(voxels == label, TOUCHING)[1] for label in labels)
