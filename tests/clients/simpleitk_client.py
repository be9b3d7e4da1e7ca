"""Overlaps and distances of labels by SimpleITK: between two volumes, for each label."""

import json
import sys

import numpy
import SimpleITK


def distances(one, other):
    """From the voxels on the border of one to those of the other."""
    border = [SimpleITK.LabelContour(volume, False) for volume in (one, other)]
    field = SimpleITK.SignedMaurerDistanceMap(
        border[1], insideIsPositive=False, squaredDistance=False, useImageSpacing=True
    )
    field = numpy.abs(SimpleITK.GetArrayFromImage(field))
    return field[SimpleITK.GetArrayFromImage(border[0]) > 0]


def measured(one, other):
    overlap = SimpleITK.LabelOverlapMeasuresImageFilter()
    overlap.Execute(one, other)
    both = numpy.concatenate([distances(one, other), distances(other, one)])
    hausdorff = SimpleITK.HausdorffDistanceImageFilter()
    hausdorff.Execute(one, other)
    return {
        "dice": overlap.GetDiceCoefficient(),
        "jaccard": overlap.GetJaccardCoefficient(),
        "hausdorff": hausdorff.GetHausdorffDistance(),
        "surface_hausdorff": float(both.max()),
        "assd": float(both.mean()),
        "volume": float(SimpleITK.GetArrayFromImage(one).sum() * numpy.prod(one.GetSpacing())),
    }


one, other = (SimpleITK.ReadImage(path) for path in sys.argv[1:])
labels = numpy.unique(SimpleITK.GetArrayFromImage(one))
found = {int(label): measured(one == int(label), other == int(label)) for label in labels if label}
print("RESULT", json.dumps(found))
