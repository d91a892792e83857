"""In a fresh Blender, a saved sequence is rendered as an animation; every picture must show the file of its frame.

Run by scripts/blender/check: blender -b saved.blend --addons isosurface_sequence --python rendered.py -- FOLDER
What a picture covers is compared with a picture of the file as Blender's own importer brings it in.
"""

import pathlib
import sys

import bpy
import numpy as np

FOLDER = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
SHOWN = {1: 1, 4: 3, 10: 10}  # the file that frames show; 4 is a gap
SIZE = 160


def set_up():
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0, -6, 0), (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    light = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    light.rotation_euler = (0.6, 0.3, 0)
    scene.collection.objects.link(light)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 4
    scene.cycles.use_denoising = False
    scene.render.film_transparent = True
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "PNG"


def coverage(path):
    """Of each pixel, how much of it is covered."""
    image = bpy.data.images.load(str(path))
    pixels = np.empty(4 * SIZE * SIZE, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(SIZE, SIZE, 4)[:, :, 3]


def main():
    scene = bpy.context.scene
    set_up()
    found = {}
    for frame in SHOWN:
        scene.frame_start = scene.frame_end = frame
        scene.render.filepath = str(FOLDER / "animation_")
        bpy.ops.render.render(animation=True)
        found[frame] = coverage(FOLDER / f"animation_{frame:04}.png")
    for item in [item for item in bpy.data.objects if item.type == "MESH"]:
        bpy.data.objects.remove(item)
    for frame, number in SHOWN.items():
        bpy.ops.import_scene.gltf(filepath=str(FOLDER / "glb" / f"f_{number}.glb"), import_shading="SMOOTH")
        scene.render.filepath = str(FOLDER / f"single_{number}.png")
        bpy.ops.render.render(write_still=True)
        wanted = coverage(scene.render.filepath)
        bpy.data.objects.remove(bpy.context.object)
        for other, picture in found.items():
            difference = np.abs(picture - wanted).mean()
            print(f"frame {other} against file {number}: {difference:.5f} of the picture differs")
            if (difference < 1e-4) != (other == frame) or not 0.05 < wanted.mean() < 0.95:
                sys.exit(f"frame {other} against file {number}: not what it should show")


main()
