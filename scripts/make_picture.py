"""Renders one mesh file to a PNG with headless Blender: how the pictures in docs/pictures were made.

    blender -b --python scripts/make_picture.py -- MESH.glb OUT.png [R,G,B] [AZIMUTH,ELEVATION in degrees]

Cycles on the CPU, so that no display and no GPU is needed. The mesh fills the frame whatever its size and place.
"""

import math
import sys

import bpy
from mathutils import Vector

WIDTH, HEIGHT, SAMPLES = 480, 420, 40


def main(mesh_path, picture_path, colour="0.8,0.8,0.8", view="-55,25"):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # With the default shading Blender 3.4 asks numpy for a name that Debian 12's no longer has.
    bpy.ops.import_scene.gltf(filepath=mesh_path, import_shading="SMOOTH")
    meshes = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    corners = [o.matrix_world @ Vector(c) for o in meshes for c in o.bound_box]
    low = Vector(min(c[a] for c in corners) for a in range(3))
    high = Vector(max(c[a] for c in corners) for a in range(3))
    centre, radius = (low + high) / 2, (high - low).length / 2

    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*(float(c) for c in colour.split(",")), 1)
    shader.inputs["Roughness"].default_value = 0.45
    for mesh in meshes:
        mesh.data.materials.clear()
        mesh.data.materials.append(material)

    azimuth, elevation = (math.radians(float(a)) for a in view.split(","))
    direction = Vector(
        (math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation))
    )
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle = math.radians(30)
    camera.location = centre + direction * radius * 3.8
    camera.data.clip_end = radius * 10
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera

    for turn, strength in ((0.8, 2.0), (-1.1, 0.5)):
        light = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        light.data.energy = strength
        light.data.angle = math.radians(8)
        towards = Vector((math.cos(azimuth + turn), math.sin(azimuth + turn), 0.9))
        light.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(light)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.9, 0.93, 1, 1)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.35

    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = False
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.filepath = picture_path
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1 :])
