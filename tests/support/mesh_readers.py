"""Reads mesh files with only the standard library, for tests and scripts that must not use the program's own
readers. Supports what isoextract, MeshLab and the programs it is compared with write; all else is an error."""

import io
import json
import math
import pathlib
import struct
import urllib.parse


class Mesh:
    """Vertices in output coordinates, triangles, and normals if any. Without connectivity, every triangle has
    its own corners."""

    def __init__(self, vertices, triangles, normals=(), has_connectivity=True):
        self.vertices = vertices
        self.triangles = triangles
        self.normals = normals
        self.has_connectivity = has_connectivity

    def bounds(self):
        return ([min(v[axis] for v in self.vertices) for axis in range(3)],
                [max(v[axis] for v in self.vertices) for axis in range(3)])

    def open_edges(self):
        """Returns the edges that no triangle has in the opposite direction."""
        edges = set()
        for a, b, c in self.triangles:
            for edge in ((a, b), (b, c), (c, a)):
                if edge in edges:
                    raise AssertionError(f"edge {edge} is used twice in one direction")
                edges.add(edge)
        return sum(1 for (a, b) in edges if (b, a) not in edges)

    def area(self):
        total = 0
        for triangle in self.triangles:
            a, b, c = (self.vertices[v] for v in triangle)
            u, v = ([q - p for p, q in zip(a, end)] for end in (b, c))
            total += math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2
        return total

    def volume(self):
        total = 0.0
        for a, b, c in self.triangles:
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (self.vertices[i] for i in (a, b, c))
            total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        return total / 6


PLY_TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f"}
PLY_TYPES |= {"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f"}
PLY_TYPES |= {"double": "d", "float64": "d"}


class PlyHeader:
    """The header of a PLY file, binary little-endian or ascii; reads a file object up to the data."""

    def __init__(self, file):
        if file.readline().strip() != b"ply":
            raise AssertionError("not a PLY file")
        self.ascii_format = False
        self.counts = {}  # number of elements by name, in the file's order
        self.properties = {}  # by element: the words after "property"
        element = None
        while (words := file.readline().decode().split()) != ["end_header"]:
            if not words:
                raise AssertionError("the header does not end")
            if words[0] == "format":
                if words[1:] not in (["ascii", "1.0"], ["binary_little_endian", "1.0"]):
                    raise AssertionError(f"unknown format {words[1:]}")
                self.ascii_format = words[1] == "ascii"
            elif words[0] == "element":
                element = words[1]
                self.counts[element] = int(words[2])
                self.properties[element] = []
            elif words[0] == "property":
                self.properties[element].append(words[1:])

    def fixed_size(self, element):
        """Returns the bytes of one such element without the entries of its lists."""
        return sum(struct.calcsize(PLY_TYPES[words[1] if words[0] == "list" else words[0]])
                   for words in self.properties[element])

    def index_size(self):
        """Returns the bytes of a face's corner index."""
        return next(struct.calcsize(PLY_TYPES[words[2]]) for words in self.properties["face"] if words[0] == "list")


def read_ply(data):
    """Reads a PLY file of vertices and triangles."""
    file = io.BytesIO(data)
    header = PlyHeader(file)
    body = file.read()
    counts, properties = header.counts, header.properties
    names = [words[-1] for words in properties["vertex"]]
    xyz = [names.index(name) for name in "xyz"]
    normal = [names.index("n" + name) for name in "xyz"] if "nx" in names else None
    if header.ascii_format:
        rows = [line.split() for line in body.decode().splitlines()]
        records = [[float(word) for word in row] for row in rows[:counts["vertex"]]]
        faces = [[int(word) for word in row[:4]] for row in rows[counts["vertex"]:]]
    else:
        record = struct.Struct("<" + "".join(PLY_TYPES[words[0]] for words in properties["vertex"]))
        end = record.size * counts["vertex"]
        records = list(record.iter_unpack(body[:end]))
        _, count_type, index_type, _ = properties["face"][0]
        others = "".join(PLY_TYPES[words[0]] for words in properties["face"][1:])
        face = struct.Struct("<" + PLY_TYPES[count_type] + 3 * PLY_TYPES[index_type] + others)
        faces = list(face.iter_unpack(body[end:]))
    if len(faces) != counts["face"] or len(records) != counts["vertex"]:
        raise AssertionError(f"{len(records)} vertices and {len(faces)} faces where the header says {counts}")
    if any(row[0] != 3 for row in faces):
        raise AssertionError("a face is not a triangle")
    return Mesh([tuple(row[i] for i in xyz) for row in records], [tuple(row[1:4]) for row in faces],
                [tuple(row[i] for i in normal) for row in records] if normal else ())


def glb_json(data):
    """The JSON of a GLB file."""
    return json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])


def read_glb(data):
    """Reads all meshes of a GLB file by node name, with the nodes' translations applied."""
    magic, version, length = struct.unpack_from("<4sII", data)
    if (magic, version, length) != (b"glTF", 2, len(data)):
        raise AssertionError("not a GLB file of the length it says")
    json_length, json_type = struct.unpack_from("<I4s", data, 12)
    if json_type != b"JSON":
        raise AssertionError("the first chunk is not JSON")
    return gltf_meshes(json.loads(data[20:20 + json_length]), data[20 + json_length + 8:])


def read_gltf(path):
    """Reads a glTF file with one buffer file in the same way."""
    model = json.loads(path.read_text(encoding="utf-8"))
    names = [urllib.parse.unquote(buffer["uri"]) for buffer in model.get("buffers", [])]
    return gltf_meshes(model, path.with_name(names[0]).read_bytes() if names else b"")


def gltf_meshes(model, binary):
    def accessor(index):
        entry = model["accessors"][index]
        view = model["bufferViews"][entry["bufferView"]]
        code = {5126: "f", 5125: "I", 5123: "H"}[entry["componentType"]]
        item = struct.Struct("<" + {"SCALAR": 1, "VEC3": 3}[entry["type"]] * code)
        start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
        stride = view.get("byteStride", item.size)
        return [item.unpack_from(binary, start + i * stride) for i in range(entry["count"])]

    meshes = {}
    for node in model["nodes"]:
        if "mesh" not in node:
            continue
        if node["name"] in meshes:
            raise AssertionError(f"two nodes are called {node['name']}")
        primitive = model["meshes"][node["mesh"]]["primitives"][0]
        shift = node.get("translation", [0, 0, 0])
        vertices = [tuple(p[i] + shift[i] for i in range(3)) for p in accessor(primitive["attributes"]["POSITION"])]
        normals = accessor(primitive["attributes"]["NORMAL"]) if "NORMAL" in primitive["attributes"] else ()
        indexed = "indices" in primitive
        flat = [index for (index,) in accessor(primitive["indices"])] if indexed else list(range(len(vertices)))
        meshes[node["name"]] = Mesh(vertices, list(zip(flat[0::3], flat[1::3], flat[2::3])), normals, indexed)
    return meshes


def read_obj(data):
    """Reads all objects of an OBJ file as one mesh."""
    vertices, normals, triangles = [], [], []
    for line in data.decode().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append(tuple(float(word) for word in words[1:4]))
        elif words[:1] == ["vn"]:
            normals.append(tuple(float(word) for word in words[1:4]))
        elif words[:1] == ["f"]:
            triangles.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:]))
    return Mesh(vertices, triangles, normals)


def read_stl(data):
    """Reads an STL file, binary or text; every corner becomes a vertex."""
    if data.startswith(b"solid"):
        rows = [line.split() for line in data.decode().splitlines()]
        vertices = [tuple(float(word) for word in words[1:4]) for words in rows if words[:1] == ["vertex"]]
        normals = [tuple(float(word) for word in words[2:5]) for words in rows if words[:1] == ["facet"]]
        count = len(normals)
        if len(vertices) != 3 * count:
            raise AssertionError(f"{len(vertices)} corners of {count} triangles")
    else:
        (count,) = struct.unpack_from("<I", data, 80)
        if len(data) != 84 + 50 * count:
            raise AssertionError(f"{len(data)} bytes for {count} triangles")
        rows = [struct.unpack_from("<12f", data, 84 + 50 * i) for i in range(count)]
        vertices = [row[3 + 3 * corner:6 + 3 * corner] for row in rows for corner in range(3)]
        normals = [row[0:3] for row in rows]
    return Mesh(vertices, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)], normals, False)


def read(path):
    """Reads the meshes of a .glb, .gltf, .ply, .obj or .stl file."""
    path = pathlib.Path(path)
    suffix = path.suffix.lower()
    if suffix == ".gltf":
        return list(read_gltf(path).values())
    if suffix == ".glb":
        return list(read_glb(path.read_bytes()).values())
    readers = {".ply": read_ply, ".obj": read_obj, ".stl": read_stl}
    if suffix not in readers:
        raise ValueError(f"{path}: expected .glb, .gltf, {', '.join(readers)}")
    return [readers[suffix](path.read_bytes())]
