"""Puts a `Surface` into a mesh of Blender's, in place of what it held. Materials and all users of the mesh stay."""

import bpy
import numpy as np

# Blender before 3.6 wants it, later ones find it out by themselves.
NEEDS_LOOP_TOTAL = not bpy.types.MeshPolygon.bl_rna.properties["loop_total"].is_readonly
TYPES = {1: ("FLOAT", "value"), 2: ("FLOAT2", "vector"), 3: ("FLOAT_VECTOR", "vector"), 4: ("FLOAT_COLOR", "color")}


def fill(mesh, surface, place, is_smooth, keeps_normals):
    """The vertices of `mesh` become those of `surface` relative to `place`."""
    mesh.clear_geometry()
    count = len(surface.triangles)
    mesh.vertices.add(len(surface.positions))
    mesh.vertices.foreach_set("co", _flat(surface.positions_from(place)))
    if count:
        mesh.loops.add(3 * count)
        mesh.loops.foreach_set("vertex_index", _flat(surface.triangles))
        mesh.polygons.add(count)
        mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
        if NEEDS_LOOP_TOTAL:
            mesh.polygons.foreach_set("loop_total", np.full(count, 3, dtype=np.int32))
        smooth = is_smooth and not surface.flat
        mesh.polygons.foreach_set("use_smooth", np.full(count, smooth, dtype=bool))
        if surface.parts is not None:
            mesh.polygons.foreach_set("material_index", surface.parts)
    mesh.update(calc_edges=True)
    for attribute in surface.attributes:
        _add_attribute(mesh, attribute)
    if count and keeps_normals and is_smooth and surface.normals is not None:
        if hasattr(mesh, "use_auto_smooth"):  # before 4.1, normals count only with it
            mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices(surface.normals.tolist())  # a list is faster


def _flat(array):
    return np.ascontiguousarray(array).reshape(-1)


def _add_attribute(mesh, attribute):
    values = attribute.values[:, :4]
    kind, member = TYPES[values.shape[1]]
    if kind == "FLOAT" and values.dtype.kind == "i":
        kind = "INT"
    # Blender's own names are taken: position, and some of edges and faces.
    name = attribute.name
    while name in mesh.attributes:
        name += "_"
    if attribute.is_color:
        layer = mesh.color_attributes.new(name, "FLOAT_COLOR", "POINT")
        mesh.color_attributes.active_color = layer
    else:
        layer = mesh.attributes.new(name, kind, "POINT")
    layer.data.foreach_set(member, _flat(values if kind == "INT" else values.astype(np.float32)))
