"""Lattices: which of their nodes are inside a mesh, and meshes around nodes."""

from dataclasses import dataclass, field

import numpy as np
from skimage.measure import marching_cubes

from mesh import Mesh

#: Pairs of a triangle and a line that are held at once.
PAIRS = 4_000_000


@dataclass
class Lattice:
    """Nodes `low + (index * steps) @ axes`, `shape` of them along each axis.
    The axes are unit vectors of a right-handed frame."""

    low: np.ndarray
    steps: np.ndarray
    shape: tuple
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    @staticmethod
    def around(low, high, resolution, margin):
        """Cubes, `resolution` of them along the longest side, and `margin`
        more beyond every face. The middles of cubes are the nodes."""
        step = (high - low).max() / resolution
        shape = np.ceil((high - low) / step).astype(int) + 2 * margin
        return Lattice(low + (0.5 - margin) * step, np.full(3, step), tuple(map(int, shape)))

    def along(self, axis):
        """Coordinates along one axis, in the lattice's frame."""
        low = self.axes @ self.low
        return low[axis] + self.steps[axis] * np.arange(self.shape[axis])

    def nodes(self):
        index = np.stack(np.meshgrid(*map(np.arange, self.shape), indexing="ij"), axis=-1)
        return self.low + (index.reshape(-1, 3) * self.steps) @ self.axes

    def inside(self, mesh):
        """Which nodes a closed mesh is around: lines along the first axis are
        followed backwards, and pass the surface inwards or outwards."""
        corners = ((mesh.vertices - self.low) @ self.axes.T / self.steps)[mesh.triangles]
        turns = np.zeros(self.shape, np.int32)
        for some in in_parts(corners, self.shape):
            add_crossings(turns, *some)
        return np.cumsum(turns[::-1], axis=0)[::-1] > 0

    def surface(self, values):
        """The mesh around the nodes with values above 0; beyond the lattice is outside."""
        outside = min(values.min(), -1e-9)
        padded = np.pad(values, 1, constant_values=outside)
        if padded.max() <= 0:
            return Mesh(np.empty((0, 3)), np.empty((0, 3), np.int64))
        vertices, triangles, _, _ = marching_cubes(padded, 0.0, gradient_direction="ascent")
        vertices = self.low + ((vertices.astype(float) - 1) * self.steps) @ self.axes
        return Mesh(vertices, triangles.astype(np.int64))


def in_parts(corners, shape):
    """Triangles that lines may meet, with the first such line along the second
    and third axis and how many there are along each; in parts of not too many
    lines."""
    a, b, c = np.moveaxis(corners[:, :, 1:], 1, 0)
    first = np.ceil(np.minimum(np.minimum(a, b), c)).clip(0).astype(int)
    last = np.floor(np.maximum(np.maximum(a, b), c)).astype(int)
    wide = (np.minimum(last, np.array(shape[1:]) - 1) - first + 1).clip(0)
    lines = wide[:, 0] * wide[:, 1]
    met = np.flatnonzero(lines)
    part = np.cumsum(lines[met]) // PAIRS
    for some in np.split(met, np.flatnonzero(np.diff(part)) + 1):
        yield corners[some], first[some], wide[some]


def add_crossings(turns, corners, first, wide):
    """Where a line leaves the solid through a triangle, 1 is added at the last
    node before, and where it enters, subtracted. Corners are in steps of the
    lattice."""
    lines = wide[:, 0] * wide[:, 1]
    triangle = np.repeat(np.arange(len(corners)), lines)
    number = np.arange(lines.sum()) - np.repeat(np.cumsum(lines) - lines, lines)
    j = first[triangle, 0] + number // wide[triangle, 1]
    k = first[triangle, 1] + number % wide[triangle, 1]
    x, y, z = np.moveaxis(corners[triangle], 2, 0)
    areas, around = turns_around(y - j[:, None], z - k[:, None])
    whole = areas.sum(axis=1)
    met = (around != 0) & (whole != 0)
    place = (areas[met] * x[met]).sum(axis=1) / whole[met]
    before = np.minimum(np.ceil(place).astype(int) - 1, turns.shape[0] - 1)
    seen = before >= 0
    np.add.at(turns, (before[seen], j[met][seen], k[met][seen]), around[met][seen])


def turns_around(y, z):
    """Of triangles in the plane, twice the areas that the origin makes with the
    sides opposite to each corner, and how often they run around it.

    Sides are counted that pass the half-line z = 0, y > 0; a corner with z = 0
    is below it. A side's area changes nothing but its sign with its direction,
    so two triangles that share it agree about it, and none is counted twice."""
    areas, around = [], 0
    for a, b in ((1, 2), (2, 0), (0, 1)):
        area = y[:, a] * z[:, b] - z[:, a] * y[:, b]
        upwards = (z[:, a] <= 0) & (z[:, b] > 0) & (area > 0)
        downwards = (z[:, a] > 0) & (z[:, b] <= 0) & (area < 0)
        around = around + upwards.astype(np.int32) - downwards
        areas.append(area)
    return np.stack(areas, axis=1), around
