"""Opens surfaces with Blender: blender --background --python blender_client.py -- FILE..."""

import sys
from pathlib import Path

import bpy
import numpy

# Blender 3.4's importer of glTF asks for a name that the numpy beside it in Debian 12 has no more.
if "bool" not in vars(numpy):
    numpy.bool = bool

sys.path.insert(0, str(Path(__file__).parent))
from solids import encoded, measured, tell  # noqa: E402


def load(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ending = Path(path).suffix
    if ending == ".glb":
        bpy.ops.import_scene.gltf(filepath=path)
    elif ending == ".obj":
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    elif bpy.app.version >= (4, 0, 0):
        bpy.ops.wm.ply_import(filepath=path, forward_axis="Y", up_axis="Z")
    else:
        bpy.ops.import_mesh.ply(filepath=path)


def color(path, mesh):
    """The colour of the material: linear in glTF, taken as it is written in OBJ."""
    if path.endswith(".ply"):
        # One for each corner or vertex, here all of them the same.
        layer = mesh.color_attributes[0].data
        return [encoded(channel) for channel in layer[0].color[:3]]
    shader = mesh.materials[0].node_tree.nodes["Principled BSDF"]
    found = list(shader.inputs["Base Color"].default_value)[:3]
    return [encoded(c) if path.endswith(".glb") else round(255 * c) for c in found]


def solids(path):
    load(path)
    found = {}
    for thing in bpy.data.objects:
        if thing.type != "MESH":
            continue
        mesh = thing.data
        mesh.calc_loop_triangles()
        places = numpy.array([thing.matrix_world @ vertex.co for vertex in mesh.vertices])
        if path.endswith(".glb"):
            # Blender turns it upright again: what is left are the metres.
            places = places * 1000
        faces = [list(triangle.vertices) for triangle in mesh.loop_triangles]
        found[thing.name] = measured(places, faces, color(path, mesh))
    return found


tell({path: solids(path) for path in sys.argv[sys.argv.index("--") + 1 :]})
