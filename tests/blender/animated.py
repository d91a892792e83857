"""Whether Blender plays an animated GLB file: at every frame the node of that frame, and no other, has scale 1.

Run by scripts/blender/check --animated: blender -b --factory-startup --python-exit-code 1 --python animated.py -- FILE
Which node is whose is read from the file: every node's scale is animated by STEP, and is 0 or 1.
"""

import json
import pathlib
import struct
import sys

import bpy
import numpy as np

FILE = pathlib.Path(sys.argv[sys.argv.index("--") + 1])


def read(path):
    """{node's name: (times, sizes)}, and {node's name: number of triangles}"""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    model, binary = json.loads(data[20:20 + length]), data[20 + length + 8:]

    def values(index):
        accessor = model["accessors"][index]
        view = model["bufferViews"][accessor["bufferView"]]
        kind = {5126: "<f4", 5121: "<u1", 5120: "<i1"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        item = np.dtype(kind).itemsize
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", item * width)
        return np.ndarray((accessor["count"], width), kind, binary, start, (stride, item)).astype(float)

    def triangles(mesh):
        return sum(model["accessors"][primitive["indices"] if "indices" in primitive
                                      else primitive["attributes"]["POSITION"]]["count"] // 3
                   for primitive in model["meshes"][mesh]["primitives"])

    tracks = {}
    (animation,) = model["animations"]
    for channel in animation["channels"]:
        assert channel["target"]["path"] == "scale", channel
        sampler = animation["samplers"][channel["sampler"]]
        assert sampler["interpolation"] == "STEP", sampler
        sizes = values(sampler["output"])
        assert (sizes == sizes[:, :1]).all(), "scales by axis differ"
        name = model["nodes"][channel["target"]["node"]]["name"]
        assert name not in tracks, f"two animated nodes are called {name}"
        tracks[name] = (values(sampler["input"])[:, 0], sizes[:, 0])
    counts = {node["name"]: triangles(node["mesh"]) for node in model["nodes"] if "mesh" in node}
    return tracks, counts


def main():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    tracks, counts = read(FILE)
    times = np.unique(np.concatenate([times for times, _ in tracks.values()]))
    # A frame of the scene for each frame of the file: the importer makes of a time its product with the scene's rate.
    rate = 1 / np.diff(times).min()
    rate = min(round(rate), round(rate * 1.001) / 1.001, key=lambda usual: abs(usual - rate))
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = round(rate), round(rate) / rate
    bpy.ops.import_scene.gltf(filepath=str(FILE), import_shading="SMOOTH")
    shown_nodes = set()
    for time in times:
        frame = round(time * rate)
        scene.frame_set(frame)
        wanted = {name for name, (at, sizes) in tracks.items()
                  if sizes[max(0, np.searchsorted(at, time + 0.01 / rate) - 1)] == 1}
        found = {}
        for item in scene.objects:
            if item.name in tracks:
                found[item.name] = tuple(item.evaluated_get(bpy.context.evaluated_depsgraph_get()).scale)
                if item.type == "MESH" and item.name in counts and len(item.data.polygons) > counts[item.name]:
                    sys.exit(f"{item.name}: {len(item.data.polygons)} triangles, {counts[item.name]} in the file")
        if set(found) != set(tracks) or not set(found.values()) <= {(0, 0, 0), (1, 1, 1)}:
            sys.exit(f"frame {frame}: scales {found}")
        shown = {name for name, scale in found.items() if scale == (1, 1, 1)}
        if shown != wanted:
            sys.exit(f"frame {frame}: shows {sorted(shown)}, the file says {sorted(wanted)}")
        if len(shown) > 1:
            sys.exit(f"frame {frame}: shows {sorted(shown)} at once")
        shown_nodes |= shown
    if shown_nodes != set(tracks):
        sys.exit(f"never shown: {sorted(set(tracks) - shown_nodes)}")
    print(f"{FILE.name}: {len(times)} times, {len(tracks)} nodes: each frame shows its node")


main()
