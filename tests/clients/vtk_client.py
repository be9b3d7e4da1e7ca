"""Opens surfaces with VTK, as ParaView and Slicer do."""

import sys
from pathlib import Path

import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

from solids import measured, tell

READERS = {
    ".obj": vtk.vtkOBJReader,
    ".ply": vtk.vtkPLYReader,
    ".stl": vtk.vtkSTLReader,
    ".vtm": vtk.vtkXMLMultiBlockDataReader,
    ".vtp": vtk.vtkXMLPolyDataReader,
    ".vtu": vtk.vtkXMLUnstructuredGridReader,
}


def faces(data):
    cells = data.GetPolys() if data.IsA("vtkPolyData") else data.GetCells()
    return vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, 3)


def points(data):
    return vtk_to_numpy(data.GetPoints().GetData())


def strings(data, name):
    array = data.GetFieldData().GetAbstractArray(name)
    return [array.GetValue(i) for i in range(array.GetNumberOfValues())] if array else []


def by_label(data):
    """The closed surface of every label, out of the network."""
    pairs = vtk_to_numpy(data.GetCellData().GetArray("boundary_labels"))
    for side, name in enumerate(("label_back", "label_front")):
        assert (vtk_to_numpy(data.GetCellData().GetArray(name)) == pairs[:, side]).all()
    ids = vtk_to_numpy(data.GetFieldData().GetArray("label_ids"))
    colors = vtk_to_numpy(data.GetFieldData().GetArray("label_colors"))
    triangles = faces(data)
    found = {}
    for label, name, color in zip(ids, strings(data, "label_names"), colors):
        behind, before = triangles[pairs[:, 0] == label], triangles[pairs[:, 1] == label]
        own = [*behind.tolist(), *before[:, ::-1].tolist()]
        used = sorted({corner for triangle in own for corner in triangle})
        number = {corner: i for i, corner in enumerate(used)}
        own = [[number[corner] for corner in triangle] for triangle in own]
        found[name] = measured(points(data)[used], own, color.tolist())
    return found


def space(reader, data):
    """The frame, as Slicer looks for it."""
    if isinstance(reader, vtk.vtkSTLReader):
        text = reader.GetHeader()
    elif isinstance(reader, vtk.vtkOBJReader):
        text = reader.GetComment()
    elif isinstance(reader, vtk.vtkPLYReader):
        comments = reader.GetComments()
        text = " ".join(comments.GetValue(i) for i in range(comments.GetNumberOfValues()))
    else:
        text = "SPACE=" + "".join(strings(data, "SPACE"))
    return [frame for frame in ("LPS", "RAS") if f"SPACE={frame}" in text]


def solids(path):
    reader = READERS[Path(path).suffix]()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    if path.endswith(".vtm"):
        found = {}
        for block in range(data.GetNumberOfBlocks()):
            name = data.GetMetaData(block).Get(vtk.vtkCompositeDataSet.NAME())
            part = data.GetBlock(block)
            assert space(reader, part) == ["LPS"], (path, name)
            found[name] = measured(points(part), faces(part), by_label(part)[name]["color"])
        return found
    assert space(reader, data) == ["LPS"], path
    if path.endswith((".vtp", ".vtu")):
        return by_label(data)
    if path.endswith(".stl"):
        # It shares vertices by their places.
        return {Path(path).stem: measured(points(data), faces(data))}
    assert data.GetNumberOfPolys() > 0, path
    return {}


tell({path: solids(path) for path in sys.argv[1:]})
