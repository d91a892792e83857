"""Small mesh files that tests write themselves: boxes, PLY and STL of given triangles, and a glTF scene."""

import json
import struct


def box(low, high):
    """Vertices and outward triangles of a box."""
    vertices = [tuple((low, high)[i >> axis & 1][axis] for axis in range(3)) for i in range(8)]
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def stl_bytes(vertices, triangles):
    records = [struct.pack("<12fH", 0, 0, 0, *(x for v in t for x in vertices[v]), 0) for t in triangles]
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(records)


def ply_text(vertices, triangles, colors=None, kind="float", quality=None):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property float {c}" for c in "xyz"),
             *(f"property uchar {c}" for c in ("red", "green", "blue") if colors),
             *([f"property {kind} quality"] if quality else []), f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    rows = [(*v, *(colors[i] if colors else ()), *([quality[i]] if quality else [])) for i, v in enumerate(vertices)]
    return "\n".join([*lines, *(" ".join(map(str, r)) for r in rows), *("3 %d %d %d" % t for t in triangles), ""])


def scene_bytes():
    """A binary glTF file: two boxes in one buffer; three nodes, one of them moved and mirrored, one mesh of two materials."""
    vertices, triangles = box((0, 0, 0), (1, 1, 1))
    positions = b"".join(struct.pack("<3f", *v) for v in vertices)
    indices = b"".join(struct.pack("<3H", *t) for t in triangles)
    uvs = bytes(8 * 8)
    binary = positions + indices + uvs
    half = {"bufferView": 1, "componentType": 5123, "count": 18, "type": "SCALAR"}
    model = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72},
                        {"buffer": 0, "byteOffset": 168, "byteLength": 64}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                      {**half, "count": 36}, half, {**half, "byteOffset": 36},
                      {"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC2"}],
        "materials": [{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}},
                      {"name": "glass", "pbrMetallicRoughness": {"baseColorFactor": [0, 0.5, 1, 0.25]},
                       "alphaMode": "BLEND", "doubleSided": True}],
        "meshes": [{"name": "data", "primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 4}, "indices": 1, "material": 0}]},
                   {"primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "material": 0},
                                   {"attributes": {"POSITION": 0}, "indices": 3, "material": 1}]}],
        "nodes": [{"name": "chair", "mesh": 0}, {"name": "lamp", "mesh": 0, "translation": [5, 0, 0], "scale": [-2, 1, 1]},
                  {"name": "table", "mesh": 1, "translation": [0, 3, 0]}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}],
        "scenes": [{"nodes": [0, 1, 2, 3]}]}
    text = json.dumps(model).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    return (struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text +
            struct.pack("<I4s", len(binary), b"BIN\0") + binary)
