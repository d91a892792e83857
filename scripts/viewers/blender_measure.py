"""Runs inside Blender for check_in_viewers.py: blender -b --python blender_measure.py -- JOBS ANSWER

JOBS is a JSON list of {path, merge}; the facts of each file go to ANSWER as JSON by path, null where Blender could not
open it. merge: vertices at one place become one first.
"""

import dataclasses
import json
import sys
from pathlib import Path

import bmesh
import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from mesh_facts import Facts, Mesh, bounds  # noqa: E402

# Coordinates stay as they are in the file, but for glTF, where Blender turns Y up into Z up: see from_blender.
# glTF with import_shading SMOOTH: with the default, NORMALS, Blender 3.4 uses a name (np.bool) that Debian 12's numpy no
# longer has, and opens nothing.
IMPORTERS = {
    '.glb': lambda path: bpy.ops.import_scene.gltf(filepath=path, import_shading='SMOOTH'),
    '.gltf': lambda path: bpy.ops.import_scene.gltf(filepath=path, import_shading='SMOOTH'),
    '.ply': lambda path: bpy.ops.import_mesh.ply(filepath=path),
    '.obj': lambda path: bpy.ops.wm.obj_import(filepath=path, forward_axis='Y', up_axis='Z'),
    '.stl': lambda path: bpy.ops.import_mesh.stl(filepath=path, axis_forward='Y', axis_up='Z'),
}


def local_positions(mesh):
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get('co', flat)
    return flat.reshape(-1, 3)


def merge_vertices(mesh):
    """Vertices at one place become one; faces that collapse go."""
    # Not remove_doubles: with a distance of 0 it does nothing.
    places = local_positions(mesh) + np.float32(0)  # + 0: -0 is 0
    _, first, place = np.unique(places, axis=0, return_index=True, return_inverse=True)
    targets = first[place.reshape(-1)].tolist()
    edited = bmesh.new()
    edited.from_mesh(mesh)
    edited.verts.ensure_lookup_table()
    bmesh.ops.weld_verts(edited, targetmap={edited.verts[vertex]: edited.verts[target]
                                            for vertex, target in enumerate(targets) if vertex != target})
    edited.to_mesh(mesh)
    edited.free()


def world_positions(item):
    matrix = np.array(item.matrix_world, dtype=np.float64)
    return local_positions(item.data).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def from_blender(positions, suffix):
    """Blender puts glTF's (x, y, z) at (x, -z, y)."""
    if suffix not in ('.glb', '.gltf'):
        return positions
    return np.stack([positions[:, 0], positions[:, 2], -positions[:, 1]], axis=1)


def measure_file(path, merge):
    suffix = Path(path).suffix.lower()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    try:
        IMPORTERS[suffix](path)
    except RuntimeError as error:
        print(error)
        return None
    facts = Facts(0, 0, 0, 0, [], [])
    meshes = []
    for item in (item for item in bpy.context.scene.objects if item.type == 'MESH'):
        if merge:
            merge_vertices(item.data)
        mesh = item.data
        if any(len(polygon.vertices) != 3 for polygon in mesh.polygons):
            print(f'{path}: a face is not a triangle')
            return None
        edge_of_loop = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.loops.foreach_get('edge_index', edge_of_loop)
        uses = np.bincount(edge_of_loop, minlength=len(mesh.edges))
        facts.vertices += len(mesh.vertices)
        facts.triangles += len(mesh.polygons)
        facts.open_edges += int((uses == 1).sum())
        facts.crossed_edges += int((uses > 2).sum())
        meshes.append(Mesh(from_blender(world_positions(item), suffix), None))
    if not meshes:
        return None
    facts.minimum, facts.maximum = bounds(meshes)
    return dataclasses.asdict(facts)


def main():
    jobs, answer = sys.argv[sys.argv.index('--') + 1:]
    facts = {job['path']: measure_file(job['path'], job['merge']) for job in json.loads(jobs)}
    Path(answer).write_text(json.dumps(facts))


main()
