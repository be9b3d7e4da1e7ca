"""Signed distances within each slice, interpolated from slice to slice.

S. P. Raya and J. K. Udupa, Shape-based interpolation of multidimensional
objects, IEEE Transactions on Medical Imaging 9(1), 1990; with cubics:
G. T. Herman, J. Zheng and C. A. Bucholtz, Shape-based interpolation, IEEE
Computer Graphics and Applications 12(3), 1992."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from .stack import Stack, layer_nodes


def linear(sections, resolution):
    return interpolated(sections, resolution, lines_through)


def cubic(sections, resolution):
    return interpolated(sections, resolution, cubics_through)


def interpolated(sections, resolution, curves_through):
    stack = Stack.of(sections)
    lattice = stack.lattice(resolution)
    places, values = with_ends(stack, slices(stack, lattice))
    curves = curves_through(places, values)
    field = np.stack([curves(place) for place in lattice.along(2)], axis=-1)
    return lattice.surface(field)


def slices(stack, lattice):
    """The distances on each section; None for one that is empty."""
    nodes, step = layer_nodes(lattice), lattice.steps[0]
    flat = (section.distance(nodes, step) for section in stack.sections)
    return [None if each is None else each.reshape(lattice.shape[:2]) for each in flat]


def with_ends(stack, values):
    """An empty slice beyond either end, and depths for the empty ones."""
    offsets, spacing = stack.offsets, stack.spacing
    places = np.array([offsets[0] - spacing, *offsets, offsets[-1] + spacing])
    return places, filled([None, *values, None])


def filled(values):
    """An empty slice has no outline to be far from. It counts as outside by
    the greatest depth of the nearest slices that are not empty: where the solid
    is thickest it then ends halfway between them, elsewhere sooner. Where these
    are farther outside, so is it: a jump would make a cubic curve overshoot."""
    known = [i for i, value in enumerate(values) if value is not None]
    result = []
    for i, value in enumerate(values):
        if value is None:
            below, above = [k for k in known if k < i][-1:], [k for k in known if k > i][:1]
            beside = np.maximum.reduce([values[k] for k in below + above])
            value = np.minimum(beside, -beside.max())
        result.append(value)
    return np.stack(result)


def lines_through(places, values):
    def curve(place):
        after = np.clip(np.searchsorted(places, place), 1, len(places) - 1)
        part = (place - places[after - 1]) / (places[after] - places[after - 1])
        return (1 - part) * values[after - 1] + part * values[after]

    return curve


def cubics_through(places, values):
    """Four slices make each piece (Catmull and Rom's curves). Splines through
    all slices were worse here where a part ends: they overshoot for slices on."""
    return CubicHermiteSpline(places, values, np.gradient(values, places, axis=0))
