"""What the scripts that render pictures have in common, inside Blender: material, camera, light, Cycles on the CPU."""

import math

import bpy
from mathutils import Vector

WIDTH, HEIGHT, SAMPLES = 480, 420, 40


def corners_of(item):
    """The corners of the box of an object, in the scene."""
    return [item.matrix_world @ Vector(corner) for corner in item.bound_box]


def paint(items, color):
    """Gives the objects one material. color: "R,G,B", or "vertices" for the objects' vertex colors."""
    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    if color == "vertices":
        vertices = material.node_tree.nodes.new("ShaderNodeVertexColor")
        vertices.layer_name = items[0].data.color_attributes[0].name
        material.node_tree.links.new(vertices.outputs["Color"], shader.inputs["Base Color"])
    else:
        shader.inputs["Base Color"].default_value = (*(float(c) for c in color.split(",")), 1)
    shader.inputs["Roughness"].default_value = 0.45
    for item in items:
        item.data.materials.clear()
        item.data.materials.append(material)


def set_up(corners, view):
    """Camera, light and Cycles, so that the box of the corners fills the picture. view: "AZIMUTH,ELEVATION"."""
    low = Vector(min(c[a] for c in corners) for a in range(3))
    high = Vector(max(c[a] for c in corners) for a in range(3))
    center, radius = (low + high) / 2, (high - low).length / 2
    azimuth, elevation = (math.radians(float(a)) for a in view.split(","))
    direction = Vector(
        (math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation))
    )
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle = math.radians(30)
    camera.location = center + direction * radius * 3.8
    camera.data.clip_start, camera.data.clip_end = radius / 10, radius * 10
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


def render(path):
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
