"""What the command-line tests share: running the program, and reading what it wrote with nothing but the standard
library."""

import functools
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.environ["ISOEXTRACT_PROGRAM"]
SOURCE = pathlib.Path(os.environ["ISOEXTRACT_SOURCE_DIR"])
DATA = pathlib.Path(os.environ.get("ISOEXTRACT_DATA", SOURCE / ".." / "shared" / "data"))

SPHERE = "demo:sphere?size=24"
# EGL's loader finds no driver, as on a machine that has none.
NO_GPU = dict(os.environ, __EGL_VENDOR_LIBRARY_FILENAMES="/nowhere/vendor.json")


class Run:
    """One finished run of the program."""

    def __init__(self, finished):
        self.code = finished.returncode
        self.out = finished.stdout
        self.err = finished.stderr.decode()

    @property
    def text(self):
        return self.out.decode()


class ProgramTest(unittest.TestCase):
    """Each test runs in a fresh folder of its own."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-test-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_program(self, *arguments, **options):
        options.setdefault("cwd", self.folder)
        options.setdefault("stdin", subprocess.DEVNULL)
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        command = [PROGRAM, *(str(argument) for argument in arguments)]
        return Run(subprocess.run(command, timeout=120, check=False, **options))

    def convert(self, *arguments):
        """A conversion that must succeed."""
        run = self.run_program(*arguments)
        self.assertEqual(run.code, 0, run.err)
        return run

    def assert_fails(self, code, run, *parts):
        """Exit code, the form of the message, and what the message and hint must contain. stdout stays empty."""
        self.assertEqual(run.code, code, run.err)
        self.assertEqual(run.out or b"", b"")
        self.assertTrue(run.err.startswith("isoextract: error: "), run.err)
        for part in parts:
            self.assertIn(part, run.err)

    def files(self):
        """Names in the test's folder, hidden ones too."""
        return sorted(path.name for path in self.folder.iterdir())

    def write_raw(self, name, dims, value_at, code="f"):
        """A raw file of the values value_at(x, y, z); little-endian."""
        values = [value_at(x, y, z) for z in range(dims[2]) for y in range(dims[1]) for x in range(dims[0])]
        path = self.folder / name
        path.write_bytes(struct.pack(f"<{len(values)}{code}", *values))
        return path


INSTALL = "scripts/setup.sh test installs it"


def needs_program(name):
    """Without the program the test fails: one that is skipped checks nothing, and nobody misses it."""

    def wrap(test):
        @functools.wraps(test)
        def run(self):
            self.assertIsNotNone(shutil.which(name), f"no {name}: {INSTALL}")
            test(self)

        return run

    return wrap


def needs_data(name):
    return unittest.skipUnless((DATA / name).exists(), f"no {DATA / name}: set ISOEXTRACT_DATA to the data folder")


class Mesh:
    """Vertices in output coordinates, normals where there are any, triangles."""

    def __init__(self, vertices, triangles, normals=()):
        self.vertices = vertices
        self.triangles = triangles
        self.normals = normals

    def bounds(self):
        return ([min(v[axis] for v in self.vertices) for axis in range(3)],
                [max(v[axis] for v in self.vertices) for axis in range(3)])

    def open_edges(self):
        """Edges that no triangle runs along the other way."""
        edges = set()
        for a, b, c in self.triangles:
            for edge in ((a, b), (b, c), (c, a)):
                if edge in edges:
                    raise AssertionError(f"edge {edge} is used twice in one direction")
                edges.add(edge)
        return sum(1 for (a, b) in edges if (b, a) not in edges)

    def volume(self):
        total = 0.0
        for a, b, c in self.triangles:
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (self.vertices[i] for i in (a, b, c))
            total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        return total / 6


PLY_TYPES = {"float": "f", "double": "d", "uchar": "B", "uint8": "B", "int": "i", "uint": "I", "int32": "i",
             "uint32": "I", "float32": "f", "float64": "d"}


def read_ply(data):
    """A PLY file, binary little-endian or ascii."""
    header, body = data.split(b"end_header\n", 1)
    lines = header.decode().split("\n")
    if lines[0] != "ply":
        raise AssertionError(f"not a PLY file: {lines[0]}")
    ascii_format = "format ascii 1.0" in lines
    counts, properties, element = {}, {}, None
    for line in lines:
        words = line.split()
        if words[:1] == ["element"]:
            element = words[1]
            counts[element] = int(words[2])
            properties[element] = []
        elif words[:1] == ["property"]:
            properties[element].append(words[1:])
    names = [words[-1] for words in properties["vertex"]]
    xyz = [names.index(name) for name in "xyz"]
    normal = [names.index("n" + name) for name in "xyz"] if "nx" in names else None
    if ascii_format:
        rows = [line.split() for line in body.decode().splitlines()]
        records = [[float(word) for word in row] for row in rows[:counts["vertex"]]]
        triangles = [tuple(int(word) for word in row[1:4]) for row in rows[counts["vertex"]:]]
    else:
        record = struct.Struct("<" + "".join(PLY_TYPES[words[0]] for words in properties["vertex"]))
        end = record.size * counts["vertex"]
        records = list(record.iter_unpack(body[:end]))
        _, count_type, index_type, _ = properties["face"][0]
        others = "".join(PLY_TYPES[words[0]] for words in properties["face"][1:])
        face = struct.Struct("<" + PLY_TYPES[count_type] + 3 * PLY_TYPES[index_type] + others)
        triangles = [row[1:4] for row in face.iter_unpack(body[end:])]
    if len(triangles) != counts["face"]:
        raise AssertionError(f"{len(triangles)} faces where the header says {counts['face']}")
    return Mesh([tuple(row[i] for i in xyz) for row in records], triangles,
                [tuple(row[i] for i in normal) for row in records] if normal else ())


def read_glb(data):
    """All meshes of a GLB file by the names of their nodes, with the nodes' translations applied."""
    magic, version, length = struct.unpack_from("<4sII", data)
    if (magic, version, length) != (b"glTF", 2, len(data)):
        raise AssertionError("not a GLB file of the length it says")
    json_length, json_type = struct.unpack_from("<I4s", data, 12)
    if json_type != b"JSON":
        raise AssertionError("the first chunk is not JSON")
    model = json.loads(data[20:20 + json_length])
    binary = data[20 + json_length + 8:]

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
        primitive = model["meshes"][node["mesh"]]["primitives"][0]
        shift = node.get("translation", [0, 0, 0])
        vertices = [tuple(p[i] + shift[i] for i in range(3)) for p in accessor(primitive["attributes"]["POSITION"])]
        normals = accessor(primitive["attributes"]["NORMAL"]) if "NORMAL" in primitive["attributes"] else ()
        if "indices" in primitive:
            flat = [index for (index,) in accessor(primitive["indices"])]
        else:
            flat = list(range(len(vertices)))
        meshes[node["name"]] = Mesh(vertices, list(zip(flat[0::3], flat[1::3], flat[2::3])), normals)
    return meshes


def read_obj(data):
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
    """A binary STL file; every corner is a vertex of its own."""
    (count,) = struct.unpack_from("<I", data, 80)
    if len(data) != 84 + 50 * count:
        raise AssertionError(f"{len(data)} bytes for {count} triangles")
    rows = [struct.unpack_from("<12f", data, 84 + 50 * i) for i in range(count)]
    vertices = [row[3 + 3 * corner:6 + 3 * corner] for row in rows for corner in range(3)]
    triangles = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)]
    return Mesh(vertices, triangles, [row[0:3] for row in rows])


def main():
    program = unittest.main(argv=[sys.argv[0], *sys.argv[1:]], verbosity=1, exit=False)
    # scripts/test shows these lines: for CTest a file of which a part was skipped has passed.
    for test, reason in program.result.skipped:
        print(f"skipped: {test.id().removeprefix('__main__.')}: {reason}", file=sys.stderr)
    sys.exit(not program.result.wasSuccessful())
