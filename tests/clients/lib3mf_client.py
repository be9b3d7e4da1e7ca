"""Opens .3mf files with lib3mf, the consortium's own library, which checks them."""

import sys

import lib3mf
from lib3mf import get_wrapper

from solids import measured, tell


def solids(wrapper, path):
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(path)
    assert reader.GetWarningCount() == 0, reader.GetWarning(0)
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    found = {}
    items = model.GetBuildItems()
    while items.MoveNext():
        mesh = model.GetMeshObjectByID(items.GetCurrent().GetObjectResource().GetResourceID())
        assert mesh.IsManifoldAndOriented(), mesh.GetName()
        resource, number, _ = mesh.GetObjectLevelProperty()
        color = model.GetBaseMaterialGroupByID(resource).GetDisplayColor(number)
        vertices = [list(vertex.Coordinates) for vertex in mesh.GetVertices()]
        faces = [list(triangle.Indices) for triangle in mesh.GetTriangleIndices()]
        color = [color.Red, color.Green, color.Blue]
        found[mesh.GetName()] = measured(vertices, faces, color)
    return found


wrapper = get_wrapper()
tell({path: solids(wrapper, path) for path in sys.argv[1:]})
