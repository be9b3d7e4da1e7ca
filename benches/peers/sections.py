"""Sections: planes with the outlines of one solid on them, read from .csl."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree
from skimage.measure import points_in_poly


def axes_of(normal):
    """Two unit vectors that, with the normal, are perpendicular to each other.

    The same for every plane with the same normal, so that parallel sections
    share their coordinates (u, v)."""
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(helper, normal)
    u /= np.linalg.norm(u)
    return u, np.cross(normal, u)


@dataclass
class Section:
    """The plane normal · x = offset, the normal of unit length and its largest
    part positive, with loops of points in space. A point is inside when an odd
    number of loops is around it: there is one material."""

    normal: np.ndarray
    offset: float
    loops: list

    @cached_property
    def axes(self):
        return np.stack(axes_of(self.normal))

    @cached_property
    def flat_loops(self):
        return [self.flat(loop) for loop in self.loops]

    def flat(self, points):
        """Coordinates (u, v) of points in space."""
        return points @ self.axes.T

    def raised(self, flat):
        """Points in space of coordinates (u, v)."""
        return flat @ self.axes + self.offset * self.normal

    def inside(self, flat):
        parity = np.zeros(len(flat), bool)
        for loop in self.flat_loops:
            parity ^= points_in_poly(flat, loop)
        return parity

    def outline(self, step):
        """Points (u, v) on the loops, at most a step apart, and the unit
        vectors perpendicular to the loops there."""
        points, across = [np.empty((0, 2))], [np.empty((0, 2))]
        for loop in self.flat_loops:
            sides = np.roll(loop, -1, axis=0) - loop
            lengths = np.linalg.norm(sides, axis=1)
            counts = np.maximum(1, np.ceil(lengths / step)).astype(int)
            side = np.repeat(np.arange(len(loop)), counts)
            first = np.repeat(np.cumsum(counts) - counts, counts)
            part = (np.arange(counts.sum()) - first) / counts[side]
            points.append(loop[side] + part[:, None] * sides[side])
            turned = sides[:, ::-1] * [1, -1] / np.maximum(lengths, 1e-300)[:, None]
            across.append(turned[side])
        return np.concatenate(points), np.concatenate(across)

    def distance(self, flat, step):
        """The distance to the outline within the plane, positive inside, to an
        error of a sixteenth of the step at most. None where there is no outline."""
        outline, _ = self.outline(step / 8)
        if len(outline) == 0:
            return None
        away, _ = cKDTree(outline).query(flat)
        return np.where(self.inside(flat), away, -away)


def contour_points(sections):
    """All corners of all loops."""
    return np.concatenate([loop for section in sections for loop in section.loops])


def read_csl(path):
    """The sections of a .csl file (docs/formats.md); labels are not looked at."""
    lines = [line.split() for line in Path(path).read_text().splitlines() if line.strip()]
    records = iter(lines[1:])
    return [read_section(records) for _ in range(int(next(records)[0]))]


def read_section(records):
    _, points, loops, *plane = next(records)[:7]
    normal, offset = np.array(plane[:3], float), -float(plane[3])
    scale = np.linalg.norm(normal) * np.sign(normal[np.argmax(np.abs(normal))])
    points = np.array([next(records)[:3] for _ in range(int(points))], float).reshape(-1, 3)
    loops = [points[np.array(next(records)[2:], int)] for _ in range(int(loops))]
    return Section(normal / scale, offset / scale, loops)
