"""ITK's morphological contour interpolation of label volumes.

D. Zukić, J. Vicory, M. McCormick, L. Wisse, G. Gerig, P. Yushkevich and
S. Aylward, ND morphological contour interpolation, The Insight Journal, 2016;
the packages itk and itk-morphologicalcontourinterpolation."""

import itk
import numpy as np

from .stack import Stack, layer_nodes


def reconstruct(sections, resolution):
    stack = Stack.of(sections)
    lattice = stack.lattice(resolution)
    nodes = layer_nodes(lattice)
    voxels = np.zeros(lattice.shape, np.uint8)
    bottom, step = lattice.along(2)[0], lattice.steps[2]
    layers = np.rint((stack.offsets - bottom) / step).astype(int)
    for section, layer in zip(stack.sections, layers):
        voxels[:, :, layer] = section.inside(nodes).reshape(lattice.shape[:2])
    # Below and above the sections is an empty layer, towards which parts taper.
    solid = interpolate(voxels, [0, *layers, lattice.shape[2] - 1])
    return lattice.surface(solid - 0.5)


def interpolate(voxels, layers):
    """Fills the layers along the last axis between those that are given, label
    by label. A given layer may be empty."""
    # The last axis of numpy is the first of ITK.
    volume = itk.image_from_array(np.ascontiguousarray(voxels))
    contours = itk.MorphologicalContourInterpolator.New(volume)
    contours.SetAxis(0)
    contours.SetUseCustomSlicePositions(True)
    for label in np.unique(voxels[voxels > 0]):
        contours.SetLabeledSliceIndices(0, int(label), [int(layer) for layer in layers])
    contours.Update()
    return itk.array_from_image(contours.GetOutput()).astype(voxels.dtype)


# The first use loads what ITK is made of, for seconds that are not the method's.
interpolate(np.ones((1, 1, 3), np.uint8), [0, 2])
