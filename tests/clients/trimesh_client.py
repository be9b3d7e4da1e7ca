"""Opens surfaces with trimesh."""

import sys
from pathlib import Path

import trimesh

from solids import encoded, from_gltf, measured, tell


def color(path, mesh):
    """The one colour of a mesh, 8 bits a channel, where trimesh reads it."""
    if path.endswith((".stl", ".off", ".3mf")):
        return None
    if path.endswith(".glb"):
        return [encoded(channel / 255) for channel in mesh.visual.material.baseColorFactor[:3]]
    visual = getattr(mesh.visual, "material", mesh.visual)
    return [int(channel) for channel in visual.main_color[:3]]


def solids(path):
    # In STL alone vertices are shared by their places, elsewhere as they are written.
    loaded = trimesh.load(path, process=path.endswith(".stl"))
    if isinstance(loaded, trimesh.Trimesh):
        assert loaded.is_watertight, path
        places = from_gltf(loaded.vertices) if path.endswith(".glb") else loaded.vertices
        return {Path(path).stem: measured(places, loaded.faces, color(path, loaded))}
    found = {}
    for node in loaded.graph.nodes_geometry:
        transform, name = loaded.graph[node]
        mesh = loaded.geometry[name].copy()
        mesh.apply_transform(transform)
        assert mesh.is_watertight, (path, node)
        places = from_gltf(mesh.vertices) if path.endswith(".glb") else mesh.vertices
        found[node] = measured(places, mesh.faces, color(path, mesh))
    return found


tell({path: solids(path) for path in sys.argv[1:]})
