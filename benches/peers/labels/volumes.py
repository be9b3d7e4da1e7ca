"""Volumes of labels from formulas. Slices lie along the last axis."""

from dataclasses import dataclass

import numpy as np

#: Voxels along each axis.
SIZE = 128
#: Every so many slices one is kept.
STEP = 6


@dataclass
class LabelVolume:
    """A label for every voxel, 0 is outside, and the slices that are kept."""

    name: str
    voxels: np.ndarray

    @property
    def kept(self):
        return np.arange(STEP // 2, self.voxels.shape[2], STEP)


def volumes():
    return [LabelVolume("folds", folds()), LabelVolume("organs", organs())]


def places():
    """Coordinates from −1 to 1 of all voxels' middles."""
    line = (np.arange(SIZE) + 0.5) * 2 / SIZE - 1
    return np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1)


def folds(parts=9, seed=4):
    """A ball with folds, a little like a brain's, divided among the nearest of
    some centres; the borders between parts are bent."""
    x = places()
    random = np.random.default_rng(seed)
    radius = np.linalg.norm(x, axis=-1)
    depth = np.zeros(radius.shape)
    for _ in range(6):
        wave, phase = random.normal(size=3) * 4, random.uniform(0, 2 * np.pi)
        depth += np.abs(np.sin(x @ wave + phase)) ** 0.5
    inside = radius < 0.95 - 0.35 * (1 - depth / 6)
    bent = x + 0.07 * np.sin(5 * x[..., [1, 2, 0]] + random.uniform(0, 2 * np.pi, 3))
    centres = spread(random, parts)
    squares = [((bent - centre) ** 2).sum(axis=-1) for centre in centres]
    return np.where(inside, 1 + np.argmin(squares, axis=0), 0).astype(np.uint8)


def spread(random, count):
    """Places in the ball, each the best of some for being far from the others."""
    centres = [np.zeros(3)]
    while len(centres) < count:
        offers = random.uniform(-0.7, 0.7, (12, 3))
        offers = offers[np.linalg.norm(offers, axis=1) < 0.75]
        if len(offers):
            apart = np.linalg.norm(offers[:, None] - np.array(centres), axis=2).min(axis=1)
            centres.append(offers[np.argmax(apart)])
    return centres


def organs():
    """Two materials as several separate bodies: bent and leaning ellipsoids,
    some of them near each other."""
    x = places()
    bodies = [
        (1, (-0.45, -0.20, 0.00), (0.30, 0.22, 0.62), (0.35, 0.0, 0.2)),
        (1, (0.50, -0.30, -0.15), (0.22, 0.26, 0.48), (-0.5, 0.3, -0.2)),
        (1, (0.15, 0.60, 0.55), (0.30, 0.15, 0.20), (0.0, 0.4, 0.3)),
        (2, (0.05, 0.25, -0.25), (0.20, 0.30, 0.55), (0.2, -0.6, 0.3)),
        (2, (-0.55, 0.60, 0.40), (0.14, 0.14, 0.40), (0.6, 0.2, -0.3)),
    ]
    voxels = np.zeros(x.shape[:3], np.uint8)
    for label, centre, radii, lean in bodies:
        y = x - centre
        height = y[..., 2]
        u = (y[..., 0] - lean[0] * height - lean[2] * height**2) / radii[0]
        v = (y[..., 1] - lean[1] * height) / radii[1]
        voxels[(u**2 + v**2 + (height / radii[2]) ** 2 < 1) & (voxels == 0)] = label
    return voxels
