"""Parallel sections as a stack, for the methods that know nothing else."""

from dataclasses import dataclass

import numpy as np

from lattice import Lattice
from sections import contour_points

#: Nodes that a lattice has beyond the outlines within the sections' planes.
MARGIN = 4


class NotParallel(Exception):
    """The method is for parallel sections alone."""


@dataclass
class Stack:
    """Parallel sections in the order of their offsets."""

    sections: list

    @staticmethod
    def of(sections):
        first = sections[0].normal
        if any(np.abs(section.normal - first).max() > 1e-9 for section in sections):
            raise NotParallel
        return Stack(sorted(sections, key=lambda section: section.offset))

    @property
    def offsets(self):
        return np.array([section.offset for section in self.sections])

    @property
    def spacing(self):
        return float(np.median(np.diff(self.offsets)))

    def lattice(self, resolution):
        """Nodes on every section of an even stack, and one spacing beyond the ends."""
        points = self.sections[0].flat(contour_points(self.sections))
        low, high = points.min(axis=0), points.max(axis=0)
        bottom, top = self.offsets[0] - self.spacing, self.offsets[-1] + self.spacing
        step = max(*(high - low), top - bottom) / resolution
        step = self.spacing / max(1, round(self.spacing / step))
        shape = np.ceil((high - low) / step).astype(int) + 2 * MARGIN
        layers = round((top - bottom) / step) + 1
        axes = np.stack([*self.sections[0].axes, self.sections[0].normal])
        corner = np.array([*(low - MARGIN * step), bottom]) @ axes
        return Lattice(corner, np.full(3, step), (*map(int, shape), layers), axes)


def layer_nodes(lattice):
    """The (u, v) of the nodes of one layer of a stack's lattice."""
    grids = np.meshgrid(lattice.along(0), lattice.along(1), indexing="ij")
    return np.stack(grids, axis=-1).reshape(-1, 2)
