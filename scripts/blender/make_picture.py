"""Renders frames of a sequence side by side, through the add-on: how docs/pictures/sequence.png was made.

    blender -b --factory-startup --python scripts/blender/make_picture.py -- \\
      FILE OUT.png FRAMES [R,G,B] [AZIMUTH,ELEVATION]

FILE: any file of the sequence. FRAMES: 2,6,10. The camera stands still, so that all of them fit into the picture.
"""

import math
import pathlib
import sys
import tempfile

import bpy
import numpy as np

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(1, str(HERE.parent / "viewers"))

import isosurface_sequence  # noqa: E402
import picture_scene  # noqa: E402

WIDTH, HEIGHT = 320, 200


def pixels_of(path):
    image = bpy.data.images.load(str(path))
    pixels = np.empty(4 * WIDTH * HEIGHT, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(HEIGHT, WIDTH, 4)


def main(file, picture, frames, color="0.8,0.8,0.8", view="-55,25"):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    isosurface_sequence.register()
    bpy.ops.import_mesh.isosurface_sequence(filepath=str(pathlib.Path(file).resolve()))
    scene, item = bpy.context.scene, bpy.context.object
    picture_scene.paint([item], color)
    corners = []
    frames = [int(frame) for frame in frames.split(",")]
    for frame in frames:
        scene.frame_set(frame)
        corners += picture_scene.corners_of(item)
    picture_scene.set_up(corners, view)
    scene.camera.data.angle = math.radians(25)  # narrower than the default, which leaves room for turning
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    with tempfile.TemporaryDirectory() as folder:
        parts = []
        for frame in frames:
            scene.frame_set(frame)
            parts.append(f"{folder}/{frame}.png")
            picture_scene.render(parts[-1])
        pixels = np.concatenate([pixels_of(part) for part in parts], axis=1)
    image = bpy.data.images.new("sequence", pixels.shape[1], HEIGHT, alpha=True)
    image.pixels.foreach_set(pixels.reshape(-1))
    image.filepath_raw = str(pathlib.Path(picture).resolve())
    image.file_format = "PNG"
    image.save()


main(*sys.argv[sys.argv.index("--") + 1:])
