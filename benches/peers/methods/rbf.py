"""Radial basis functions r³, and a linear part, through signed distances.

J. C. Carr and others, Reconstruction and representation of 3D objects with
radial basis functions, SIGGRAPH 2001. A dense system, solved as it stands."""

import numpy as np
from scipy.linalg import solve
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from lattice import Lattice
from sections import contour_points

#: About how many centres lie on outlines; the system is dense.
ON_OUTLINES = 1100
#: How many lie on a section's plane along the longer side of the box.
ON_PLANE = 12
#: How many lie along the sides of the box, where all is outside.
ON_BOX = 8
#: What the box has beyond the outlines, as a part of their diagonal.
BOX_MARGIN = 0.05
#: The finest lattice: the functions hold no more than their centres say.
FINEST = 128
#: Points whose distances to all centres are held at once.
AT_ONCE = 32
#: Along one axis, nodes that are looked at together.
BLOCK = 4


def reconstruct(sections, resolution):
    points = contour_points(sections)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = BOX_MARGIN * np.linalg.norm(high - low)
    low, high = low - margin, high + margin
    field = interpolant(*constraints(sections, low, high))
    lattice = Lattice.around(low, high, min(resolution, FINEST), 0)
    return lattice.surface(evaluated(field, lattice))


def interpolant(centres, values):
    """The function Σ weight · |x − centre|³ + linear part with these values."""
    size = len(centres)
    system = np.zeros((size + 4, size + 4))
    system[:size, :size] = cdist(centres, centres) ** 3
    system[:size, size] = system[size, :size] = 1
    system[:size, size + 1 :] = centres
    system[size + 1 :, :size] = centres.T
    weights = solve(system, np.append(values, np.zeros(4)))
    squares = (centres**2).sum(axis=1)

    def function(points):
        result = np.empty(len(points))
        for some in np.array_split(np.arange(len(points)), len(points) // AT_ONCE + 1):
            p = points[some]
            square = np.maximum((p**2).sum(axis=1)[:, None] + squares - 2 * p @ centres.T, 0)
            linear = weights[size] + p @ weights[size + 1 :]
            result[some] = (square * np.sqrt(square)) @ weights[:size] + linear
        return result

    return function


def constraints(sections, low, high):
    """Points and the values there: 0 on outlines; a little off them, on the
    planes and on the box, plus or minus the distance to the nearest outline of
    any section."""
    length = sum(
        np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).sum()
        for section in sections
        for loop in section.loops
    )
    spacing = length / ON_OUTLINES
    outlines = [section.outline(spacing / 8) for section in sections]
    dense = np.concatenate([s.raised(points) for s, (points, _) in zip(sections, outlines)])
    tree = cKDTree(dense)
    around, signs = [box_points(low, high)], [-np.ones(6 * ON_BOX**2)]
    for section, (points, across) in zip(sections, outlines):
        kept = thinned(points, spacing)
        sides = across[kept] * spacing / 2
        flat = [points[kept] + sides, points[kept] - sides, plane_points(section, low, high)]
        flat = np.concatenate(flat)
        around.append(section.raised(flat))
        signs.append(np.where(section.inside(flat), 1, -1))
    around = np.concatenate(around[1:] + around[:1])
    signs = np.concatenate(signs[1:] + signs[:1])
    on = dense[thinned(dense, spacing)]
    values = signs * tree.query(around)[0]
    # Two centres at nearly one place would make the system singular.
    everywhere = np.concatenate([on, around])
    values = np.concatenate([np.zeros(len(on)), values])
    kept = thinned(everywhere, spacing / 3)
    return everywhere[kept], values[kept]


def thinned(points, cell):
    """Indices of points: the first in every cube of this side."""
    _, first = np.unique(np.floor(points / cell).astype(int), axis=0, return_index=True)
    return np.sort(first)


def plane_points(section, low, high):
    """A grid of (u, v) on a section's plane, where it lies in the box."""
    corners = np.stack(np.meshgrid(*zip(low, high), indexing="ij"), axis=-1).reshape(-1, 3)
    flat = section.flat(corners)
    step = (high - low).max() / ON_PLANE
    sides = (np.arange(a + step / 2, b, step) for a, b in zip(flat.min(axis=0), flat.max(axis=0)))
    flat = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
    space = section.raised(flat)
    return flat[((space > low) & (space < high)).all(axis=1)]


def box_points(low, high):
    """Even points on the six faces of the box."""
    part = (np.arange(ON_BOX) + 0.5) / ON_BOX
    face = np.stack(np.meshgrid(part, part, indexing="ij"), axis=-1).reshape(-1, 2)
    faces = [np.insert(face, axis, end, axis=1) for axis in range(3) for end in (0.0, 1.0)]
    return low + np.concatenate(faces) * (high - low)


def evaluated(field, lattice):
    """The field on a lattice. In blocks whose middle is farther from the
    surface than their corners, by twice, all nodes have the middle's value."""
    blocks = tuple(-(-n // BLOCK) for n in lattice.shape)
    middles = Lattice(
        lattice.low + (BLOCK - 1) / 2 * lattice.steps, lattice.steps * BLOCK, blocks
    )
    coarse = field(middles.nodes()).reshape(blocks)
    values = coarse
    for axis in range(3):
        values = values.repeat(BLOCK, axis=axis)
    values = values[tuple(slice(n) for n in lattice.shape)].reshape(-1).copy()
    reach = np.linalg.norm(lattice.steps) * BLOCK / 2
    near = np.abs(values) < 2 * reach
    values[near] = field(lattice.nodes()[near])
    return values.reshape(lattice.shape)
