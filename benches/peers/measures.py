"""How far a reconstruction is from the solid, and from its sections."""

import numpy as np

from lattice import Lattice

#: Voxels along the longest side of the solid, on which volumes are compared.
VOXELS = 128
#: Voxels beyond the solid's box.
MARGIN = 8
#: Points on each surface for distances.
POINTS = 30_000
#: What a section's pixels cover beyond its outlines, as a part of the diagonal.
PIXEL_MARGIN = 0.05


class Truth:
    """A solid, and what every result is held against."""

    def __init__(self, solid):
        self.solid = solid
        self.diagonal = solid.diagonal
        self.lattice = Lattice.around(*solid.box, VOXELS, MARGIN)
        self.inside = self.lattice.inside(solid)
        self.points = solid.sample(POINTS, seed=1)
        self.pieces = solid.pieces()

    def measures(self, result, sections):
        """All figures of one result; None where it has no surface."""
        inside = self.lattice.inside(result)
        either = (inside | self.inside).sum()
        mean, largest = self.distances(result)
        pixel, margin = self.lattice.steps[0], PIXEL_MARGIN * self.diagonal
        dice = section_dice(result, sections, pixel, margin)
        return {
            "iou": float((inside & self.inside).sum() / either),
            "distance": mean,
            "largest": largest,
            "volume": result.volume / self.solid.volume,
            "pieces": result.pieces(),
            "true_pieces": self.pieces,
            "dice": float(np.mean(dice)) if dice else None,
            "least_dice": float(np.min(dice)) if dice else None,
        }

    def distances(self, result):
        """The mean of both directions' means, and the largest distance of all,
        in thousandths of the solid's diagonal."""
        if len(result.triangles) == 0:
            return None, None
        there = self.solid.distances(result.sample(POINTS, seed=2))
        back = result.distances(self.points)
        scale = 1000 / self.diagonal
        mean = (there.mean() + back.mean()) / 2
        return float(mean * scale), float(max(there.max(), back.max()) * scale)


def dice(a, b):
    """Twice the common part over the sum; None where both are empty."""
    both = a.sum() + b.sum()
    return float(2 * (a & b).sum() / both) if both else None


def section_dice(result, sections, pixel, margin):
    """For every section that has an outline, its agreement with the result's
    cut by its plane."""
    figures = []
    for section in sections:
        if section.loops:
            raster = pixels(section, pixel, margin)
            shown = section.inside(section.flat(raster.nodes())).reshape(raster.shape)
            figures.append(dice(shown, raster.inside(result)) or 0.0)
    return figures


def pixels(section, pixel, margin):
    """The middles of pixels around a section's outlines. They are shifted by
    odd parts of a pixel, so as not to lie on straight outlines."""
    corners = np.concatenate(section.flat_loops)
    low = corners.min(axis=0) - margin + np.array([0.3719, 0.7133]) * pixel
    shape = np.ceil((corners.max(axis=0) + margin - low) / pixel).astype(int)
    frame = np.stack([*section.axes, section.normal])
    return Lattice(section.raised(low), np.full(3, pixel), (*map(int, shape), 1), frame)
