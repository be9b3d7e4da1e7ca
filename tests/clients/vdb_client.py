"""Opens volumes with tinyvdb, which shares no code with OpenVDB, and scenes with Pixar's USD."""

import struct
import sys

import tinyvdb
from pxr import Gf, Usd, UsdGeom, UsdVol
from tinyvdb import _tinyvdb_nanovdb as nanovdb

from solids import tell

# So many values of each grid are told.
TOLD = 200


def grids(path):
    """Where the float grids of a .vdb are, and values at some nodes."""
    file = tinyvdb.open(path)
    file.read_grids()
    found = {}
    for number in range(file.grid_count):
        grid = file.grid(number)
        values = []
        if "float" in grid.type_name:
            sparse = grid.to_sparse()
            nodes = list(struct.iter_unpack("<3i", sparse["coords"]))
            numbers = struct.unpack(f"<{sparse['count']}f", sparse["values"])
            step = max(1, len(nodes) // TOLD)
            values = [[*node, own] for node, own in zip(nodes[::step], numbers[::step])]
        transform = grid.transform
        found[grid.name] = {
            "type": grid.type_name,
            "voxel": transform["voxel_size"],
            "origin": transform["translation"],
            "half": bool(grid.metadata["is_saved_as_half_float"]),
            "values": values,
        }
    return found


def nano_grids(path, nodes):
    """The same of a .nvdb, at these nodes."""
    file = nanovdb.NanoVDBFile(path)
    found = {}
    for number in range(file.grid_count()):
        name = file.grid_name(number)
        found[name] = {
            "active": file.active_voxel_count(number),
            "voxel": file.voxel_size(number),
            # tinyvdb 0.9 looks up values in the first grid, whichever is named.
            "values": [[*node, file.get(0, *node)] for node in nodes[name]] if number == 0 else [],
        }
    return found


def scene(path):
    """What a .usda says of its fields, and where a point goes in metres."""
    stage = Usd.Stage.Open(path)
    volume = UsdVol.Volume(stage.GetDefaultPrim())
    to_world = UsdGeom.Xformable(volume).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    point = to_world.Transform(Gf.Vec3d(10, 20, 30)) * UsdGeom.GetStageMetersPerUnit(stage)
    fields = {}
    for place in volume.GetFieldPaths().values():
        field = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(place))
        fields[field.GetFieldNameAttr().Get()] = {
            "class": field.GetFieldClassAttr().Get(),
            "type": field.GetFieldDataTypeAttr().Get(),
            "file": field.GetFilePathAttr().Get().resolvedPath,
            "label": field.GetPrim().GetCustomDataByKey("label_name"),
        }
    return {"up": UsdGeom.GetStageUpAxis(stage), "point": list(point), "fields": fields}


volumes = {path: grids(path) for path in sys.argv[1:] if path.endswith(".vdb")}
nodes = {
    name: [value[:3] for value in grid["values"]]
    for found in volumes.values()
    for name, grid in found.items()
}
others = {path: nano_grids(path, nodes) for path in sys.argv[1:] if path.endswith(".nvdb")}
scenes = {path: scene(path) for path in sys.argv[1:] if path.endswith(".usda")}
tell({"volumes": volumes, "others": others, "scenes": scenes})
