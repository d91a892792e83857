"""Renders one mesh file to a PNG with headless Blender: how the pictures in docs/pictures were made.

    blender -b --python scripts/make_picture.py -- MESH.glb OUT.png [R,G,B|vertices] [AZIMUTH,ELEVATION in degrees]

Cycles on the CPU, so that no display and no GPU is needed. The mesh fills the frame whatever its size and place.
"""

import pathlib
import sys

import bpy

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "viewers"))

from picture_scene import corners_of, paint, render, set_up  # noqa: E402


def main(mesh_path, picture_path, colour="0.8,0.8,0.8", view="-55,25"):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # With the default shading Blender 3.4 asks numpy for a name that Debian 12's no longer has.
    bpy.ops.import_scene.gltf(filepath=mesh_path, import_shading="SMOOTH")
    meshes = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    paint(meshes, colour)
    set_up([corner for mesh in meshes for corner in corners_of(mesh)], view)
    render(picture_path)


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1 :])
