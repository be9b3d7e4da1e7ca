"""Volumes of labels and structure sets, with the programs that people have for them.

volumes.py write FOLDER: a body drawn on every third slice, placed in several ways, as SimpleITK,
nibabel and pynrrd write it. volumes.py read FILE...: what SimpleITK, nibabel, pynrrd, VTK and
pydicom find. Places are in LPS and millimetres.
"""

import sys
import warnings
from pathlib import Path

import nibabel
import nrrd
import numpy
import pydicom
import SimpleITK
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

from solids import tell

warnings.simplefilter("error")

NAMES = ["liver", "left kidney", "gall bladder"]
SPACING = [0.8, 0.9, 2.4]
ORIGIN = numpy.array([-41.3, 17.7, 102.9])
# To RAS and back.
TURNED = numpy.diag([-1.0, -1.0, 1.0])


def leaning():
    """A direction matrix along none of the axes."""
    found, _ = numpy.linalg.qr(numpy.array([[3.0, -1, 0.5], [1, 2.5, -1], [-0.2, 1, 2]]))
    return found * numpy.sign(numpy.linalg.det(found))


DIRECTIONS = {
    "straight": numpy.eye(3),
    "turned": numpy.array([[0.0, 0, 1], [1, 0, 0], [0, -1, 0]]) @ numpy.diag([1.0, 1, -1]),
    "oblique": leaning(),
    "left_handed": leaning() @ numpy.diag([1.0, 1, -1]),
}


def body():
    """Three organs that touch, by i, j and k."""
    sizes = (64, 60, 28)
    places = numpy.stack(numpy.meshgrid(*map(numpy.arange, sizes), indexing="ij"), -1) * SPACING
    labels = numpy.zeros(sizes, numpy.uint8)
    organs = [([24, 25, 33], [16, 14, 24]), ([36, 28, 40], [12, 15, 17]), ([20, 38, 26], [7, 8, 15])]
    for number, (center, radii) in enumerate(organs, 1):
        labels[(((places - center) / radii) ** 2).sum(-1) < 1] = number
    return labels


def bodies(labels, steps, origin):
    """How large every label is, and where."""
    found = {}
    for label in numpy.unique(labels[labels > 0]):
        middle = numpy.argwhere(labels == label).mean(axis=0)
        volume = (labels == label).sum() * abs(numpy.linalg.det(steps))
        found[int(label)] = {"volume": float(volume), "centroid": (steps @ middle + origin).tolist()}
    return found


def itk(labels, direction):
    image = SimpleITK.GetImageFromArray(numpy.ascontiguousarray(labels.transpose()))
    image.SetSpacing(SPACING)
    image.SetOrigin(ORIGIN.tolist())
    image.SetDirection(direction.ravel().tolist())
    return image


def write(folder):
    full = body()
    drawn = numpy.where(numpy.arange(full.shape[2]) % 3 == 2, full, 0).astype(numpy.uint8)
    for name, direction in DIRECTIONS.items():
        steps = direction * SPACING
        at = lambda ending: str(Path(folder) / f"{name}.{ending}")
        image = itk(drawn, direction)
        SimpleITK.WriteImage(SimpleITK.Cast(image, SimpleITK.sitkInt16), at("mha"), True)
        SimpleITK.WriteImage(SimpleITK.Cast(image, SimpleITK.sitkFloat64), at("nrrd"), False)
        SimpleITK.WriteImage(itk(full, direction), at("like.nrrd"), True)
        affine = numpy.eye(4)
        affine[:3, :3], affine[:3, 3] = TURNED @ steps, TURNED @ ORIGIN
        image = nibabel.Nifti1Image(drawn, affine)
        image.header.set_xyzt_units("mm")
        # What has a qform alone is placed by it.
        image.set_sform(None if name == "oblique" else affine, 0 if name == "oblique" else 1)
        image.set_qform(affine, 1)
        nibabel.save(image, at("nii.gz"))
        header = {"space": "right-anterior-superior", "kinds": ["domain"] * 3, "encoding": "gzip"}
        header |= {"space directions": (TURNED @ steps).T, "space origin": TURNED @ ORIGIN}
        for number, organ in enumerate(NAMES):
            begin = f"Segment{number}_"
            header |= {begin + "ID": organ, begin + "Name": organ, begin + "Color": "0.8 0.2 0"}
            header |= {begin + "LabelValue": str(number + 1), begin + "Layer": "0"}
        nrrd.write(at("seg.nrrd"), drawn, header)
    tell({name: bodies(full, way * SPACING, ORIGIN) for name, way in DIRECTIONS.items()})


def by_itk(path):
    image = SimpleITK.ReadImage(path)
    steps = numpy.reshape(image.GetDirection(), (3, 3)) * image.GetSpacing()
    return bodies(SimpleITK.GetArrayFromImage(image).transpose(), steps, image.GetOrigin())


def by_nibabel(path):
    image = nibabel.load(path)
    steps, origin = TURNED @ image.affine[:3, :3], TURNED @ image.affine[:3, 3]
    return bodies(numpy.asarray(image.dataobj), steps, origin)


def by_nrrd(path):
    labels, header = nrrd.read(path)
    sign = {"right-anterior-superior": TURNED, "left-posterior-superior": numpy.eye(3)}
    sign = sign[header["space"]]
    if path.endswith(".seg.nrrd"):
        # In the same order; names that are not the file's own are made of numbers.
        names = [header[f"Segment{number}_Name"] for number in range(len(NAMES))]
        assert names in (NAMES, ["label 1", "label 2", "label 3"]), names
    return bodies(labels, sign @ header["space directions"].T, sign @ header["space origin"])


def by_vtk(path):
    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    space = image.GetFieldData().GetAbstractArray("SPACE").GetValue(0)
    sign = {"RAS": TURNED, "LPS": numpy.eye(3)}[space]
    matrix = image.GetDirectionMatrix()
    steps = [[matrix.GetElement(row, column) for column in range(3)] for row in range(3)]
    labels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
    steps = sign @ (numpy.array(steps) * image.GetSpacing())
    return bodies(labels.transpose(), steps, sign @ image.GetOrigin())


def by_pydicom(path):
    """Of contours, whose volume counts with the distance between slices."""
    data = pydicom.dcmread(path)
    found = {}
    for item in data.ROIContourSequence:
        area, moment = 0.0, numpy.zeros(3)
        for contour in item.ContourSequence:
            points = numpy.reshape([float(word) for word in contour.ContourData], (-1, 3))
            # By triangles from the first point.
            first, second = points[1:-1] - points[0], points[2:] - points[0]
            crosses = numpy.cross(first, second)
            normal = crosses.sum(axis=0) / numpy.linalg.norm(crosses.sum(axis=0))
            parts = crosses @ normal / 2
            area += parts.sum()
            moment += parts @ (points[0] + (first + second) / 3)
        label = int(item.ReferencedROINumber)
        found[label] = {"volume": float(area * SPACING[2]), "centroid": (moment / area).tolist()}
    return found


def read(paths):
    clients = {
        ".mha": [by_itk],
        ".nrrd": [by_itk, by_nrrd],
        ".gz": [by_itk, by_nibabel],
        ".vti": [by_vtk],
        ".dcm": [by_pydicom],
    }
    tell({f"{path} {own.__name__}": own(path) for path in paths for own in clients[Path(path).suffix]})


{"write": lambda paths: write(*paths), "read": read}[sys.argv[1]](sys.argv[2:])
