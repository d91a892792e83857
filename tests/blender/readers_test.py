"""The readers of the Blender add-on, and how it finds the files of a sequence; without Blender."""

import json
import os
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import warnings

SOURCE = pathlib.Path(os.environ["ISOEXTRACT_SOURCE_DIR"])
sys.path.insert(0, str(SOURCE / "scripts" / "blender"))
sys.path.insert(0, str(SOURCE / "tests" / "support"))

try:
    import numpy as np
except ImportError:
    sys.exit(f"no numpy for {sys.executable}: scripts/setup.sh test installs it")

import mesh_readers  # noqa: E402
from isosurface_sequence.cache import SurfaceCache  # noqa: E402
from isosurface_sequence.frames import Sequence, pattern_of, sequences_of  # noqa: E402
from isosurface_sequence.glb import read_glb  # noqa: E402
from isosurface_sequence.kinds import kind_by_name  # noqa: E402
from isosurface_sequence.ply import read_ply  # noqa: E402
from isosurface_sequence.surface import UnreadableFile  # noqa: E402

PROGRAM = os.environ["ISOEXTRACT_PROGRAM"]
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], np.float32)


class FolderTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-blender-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def write(self, name, data):
        path = self.folder / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return path

    def convert(self, name, *arguments):
        path = self.folder / name
        done = subprocess.run([PROGRAM, *arguments, "-o", path], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return path

    def assert_unreadable(self, read, path, *parts):
        with self.assertRaises(UnreadableFile) as raised:
            read(path)
        for part in (path.name, *parts):
            self.assertIn(part, str(raised.exception))


class WrittenByIsoextract(FolderTest):
    """What the add-on's readers say is what the tests' own readers say."""

    def assert_as_read_by_the_tests(self, surface, meshes):
        vertices = np.array([vertex for mesh in meshes for vertex in mesh.vertices])
        starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
        triangles = np.concatenate([np.array(mesh.triangles) + start for mesh, start in zip(meshes, starts)])
        step = np.abs(surface.positions).max() * 2.0**-23
        np.testing.assert_allclose(surface.positions + surface.origin, vertices, rtol=0, atol=step)
        np.testing.assert_array_equal(surface.triangles, triangles)
        if meshes[0].normals:
            normals = [normal for mesh in meshes for normal in mesh.normals]
            np.testing.assert_allclose(surface.normals, normals, rtol=0, atol=2.0**-24)  # a text's have more digits
        else:
            self.assertIsNone(surface.normals)

    def test_meshes(self):
        far = ("--spacing", "0.1", "--origin", "12345678.9,-2e6,3e6")
        for options in ((), ("--normals", "flat"), ("--normals", "smooth"), ("--normals", "none"), far):
            path = self.convert("a.glb", "demo:gyroid?size=12", "--iso", "0", *options)
            self.assert_as_read_by_the_tests(read_glb(path), list(mesh_readers.read_glb(path.read_bytes()).values()))
            for form in ((), ("--ascii",)):
                path = self.convert("a.ply", "demo:gyroid?size=12", "--iso", "0", *options, *form)
                surface, mesh = read_ply(path), mesh_readers.read_ply(path.read_bytes())
                self.assert_as_read_by_the_tests(surface, [mesh])
                self.assertEqual(surface.flat, "flat" in options)
        self.assertGreater(np.abs(surface.origin).max(), 1e6)

    def test_several_surfaces_in_one_file(self):
        path = self.convert("a.glb", "demo:gyroid?size=12", "--iso", "0", "--iso", "0.5")
        surface, meshes = read_glb(path), list(mesh_readers.read_glb(path.read_bytes()).values())
        self.assert_as_read_by_the_tests(surface, meshes)
        self.assertEqual(np.bincount(surface.parts).tolist(), [len(mesh.triangles) for mesh in meshes])
        self.assertEqual(len(set(surface.part_names)), 2)

    def test_an_empty_surface(self):
        for name, read in (("a.glb", read_glb), ("a.ply", read_ply)):
            path = self.convert(name, "demo:sphere?size=12", "--iso", "100", "--empty", "write")
            surface = read(path)
            self.assertEqual((len(surface.positions), len(surface.triangles)), (0, 0))

    def test_a_file_cut_off_anywhere_is_unreadable(self):
        random.seed(1)
        for name, read in (("a.glb", read_glb), ("a.ply", read_ply)):
            path = self.convert(name, "demo:sphere?size=8", "--iso", "0")
            data = path.read_bytes()
            for length in [0, 1, 4, 19, len(data) - 1] + [random.randrange(len(data)) for _ in range(50)]:
                path.write_bytes(data[:length])
                self.assert_unreadable(read, path)

    def test_damaged_bytes_raise_nothing_else(self):
        random.seed(2)
        for name, read in (("a.glb", read_glb), ("a.ply", read_ply), ("ascii.ply", read_ply)):
            options = ("--ascii",) if name.startswith("ascii") else ()
            path = self.convert(name, "demo:sphere?size=6", "--iso", "0", "--normals", "smooth", *options)
            data = path.read_bytes()
            refused = 0
            for _ in range(150):
                damaged = bytearray(data)
                for _ in range(random.randrange(1, 4)):
                    damaged[random.randrange(min(len(data), 1500))] = random.choice(b"\0\xff 0918-.xe{[\"\n")
                path.write_bytes(damaged)
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")  # numbers too large for their type
                        read(path)
                except UnreadableFile:
                    refused += 1
            self.assertGreater(refused, 15, name)


class AttributesThatTurn(FolderTest):
    """Vectors, points and normals have Blender's axes, as the positions have."""

    def setUp(self):
        super().setUp()
        rows = ["x,y,z,v:0,v:1,v:2,dir:0,dir:1,dir:2"]
        rows += [f"{i},{j},{k},1,2,3,1,2,3" for i in range(3) for j in range(3) for k in range(3)]
        self.write("in.csv", "\n".join(rows) + "\n")

    def values(self, name, y_is_up, *arguments):
        words = ("--radius", "0.6", *(word for a in ("v", "dir", "w=dir:point", "s=v:scalar") for word in ("--attribute", a)))
        path = self.convert(name, self.folder / "in.csv", *words, *arguments)
        surface = SurfaceCache(1 << 30).surface(path, y_is_up)
        return {attribute.name: attribute.values.mean(axis=0).round(5).tolist() for attribute in surface.attributes}

    def test_what_isoextract_turned_is_turned_back(self):
        """In both formats, whatever the axis that is up in the file."""
        for name, y_is_up, arguments in (("a.glb", True, ()), ("a.ply", False, ()), ("b.ply", True, ("--up-out", "y"))):
            self.assertEqual(self.values(name, y_is_up, *arguments),
                             {"v": [1, 2, 3], "w": [1, 2, 3], "dir": [1, 2, 3], "s": [1, 2, 3]})
        # As it is in the file, the vector and the point are turned, and what nothing says to be one is not.
        self.assertEqual(self.values("a.glb", False), {"v": [1, 3, -2], "w": [1, 3, -2], "dir": [1, 2, 3], "s": [1, 2, 3]})

    def test_names_say_it_of_other_programs_files(self):
        columns = [("_v", "v"), ("_N", "N"), ("_dir", "dir")]
        values = np.array([[1, 3, -2]] * 3, np.float32)
        path = self.write("a.glb", triangle_glb(attributes=[(semantic, values, {}) for semantic, _ in columns]))
        for y_is_up, turned in ((True, [1, 2, 3]), (False, [1, 3, -2])):
            surface = SurfaceCache(1 << 30).surface(path, y_is_up)
            self.assertEqual({a.name: a.values[0].tolist() for a in surface.attributes},
                             {"v": turned, "N": turned, "dir": [1, 3, -2]})

    def test_old_files_of_ours_hold_what_was_not_turned(self):
        values = np.array([[1, 2, 3]] * 3, np.float32)
        for extras in ({}, {"extras": {"placement": {"up": "z"}}}, {"extras": {"placement": "damaged"}}):
            asset = {"version": "2.0", "generator": "isoextract 0.1", **extras}
            path = self.write("a.glb", triangle_glb(attributes=[("_v", values, {})], asset=asset))
            (attribute,) = SurfaceCache(1 << 30).surface(path, True).attributes
            self.assertEqual(attribute.values[0].tolist(), [1, 2, 3])

    def test_the_names_are_those_of_isoextract(self):
        """kinds.kind_by_name() has the rules of kind_by_name() in C++: the words of its source."""
        source = (SOURCE / "src/base/attribute_kind.cpp").read_text()
        tables = {table: re.findall(r'\{"([^"]+)", AttributeKind::(\w+)\}', body)
                  for table, body in re.findall(r"NamedKind, \d+> (\w+)\{\s*\{(.*?)\}\};", source, re.DOTALL)}
        self.assertEqual(set(tables), {"kNames", "kBeginnings", "kWords"})
        for table, pattern in (("kNames", "{}"), ("kBeginnings", "{}_old"), ("kWords", "wind_{}_old")):
            for name, kind in tables[table]:
                if name == "x y z":
                    continue  # the position of particles, which no mesh has
                found = kind_by_name(pattern.format(name).upper())
                self.assertEqual(found, None if kind == "color" else kind, name)
        for name in ("w", "vorticity", "angular_velocity", "dir", "heat", "uv"):
            self.assertIsNone(kind_by_name(name))


def glb(document, binary=b""):
    text = json.dumps({"asset": {"version": "2.0"}, **document}).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def triangle_glb(nodes=({"mesh": 0},), attributes=(), positions=TRIANGLE, stride=None, primitive=(), **document):
    """A GLB file of one triangle without indices. attributes: (semantic, values, what else its accessor says)."""
    binary, views, accessors, semantics = b"", [], [], {}
    for semantic, values, more in [("POSITION", positions, {}), *attributes]:
        width = values.shape[1]
        kind = {"f4": 5126, "u1": 5121, "i1": 5120, "u2": 5123, "i2": 5122}[values.dtype.str[1:]]
        row = values.dtype.itemsize * width
        step = stride or row + -row % 4
        data = b"".join(item.tobytes() + bytes(step - row) for item in values)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "byteStride": step})
        semantics[semantic] = len(accessors)
        accessors.append({"bufferView": len(views) - 1, "componentType": kind, "count": len(values),
                          "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[width], **more})
        binary += data
    return glb({"buffers": [{"byteLength": len(binary)}], "bufferViews": views, "accessors": accessors,
                "meshes": [{"primitives": [{"attributes": semantics, **dict(primitive)}]}], "nodes": list(nodes),
                "scene": 0, "scenes": [{"nodes": [0]}], **document}, binary)


class GlbTest(FolderTest):
    def read(self, data):
        return read_glb(self.write("a.glb", data))

    def test_nodes_are_applied_from_the_root_down(self):
        half = 0.5**0.5
        surface = self.read(triangle_glb([
            {"children": [1], "translation": [10, 0, 0], "rotation": [0, 0, half, half]},  # x to y
            {"mesh": 0, "scale": [2, 2, 2], "translation": [0, 5, 0]},
        ]))
        np.testing.assert_allclose(surface.origin, [5, 0, 0], atol=1e-12)
        np.testing.assert_allclose(surface.positions, [[0, 0, 0], [0, 2, 0], [-4, 0, 0]], atol=1e-6)

    def test_a_mirror_keeps_the_outside(self):
        normals = np.array([[0, 0, 1]] * 3, np.float32)
        surface = self.read(triangle_glb([{"mesh": 0, "scale": [-1, 1, 1]}], [("NORMAL", normals, {})]))
        a, b, c = surface.positions[surface.triangles[0]]
        self.assertGreater(np.cross(b - a, c - a)[2], 0)
        np.testing.assert_array_equal(surface.normals, normals)

    def test_a_matrix_is_columns(self):
        surface = self.read(triangle_glb([{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]}]))
        np.testing.assert_array_equal(surface.origin, [7, 8, 9])

    def test_a_node_of_no_size_is_not_there(self):
        surface = self.read(triangle_glb([{"children": [1, 2]}, {"mesh": 0, "scale": [0, 0, 0]},
                                          {"mesh": 0, "translation": [0, 0, 1]}]))
        self.assertEqual(len(surface.triangles), 1)
        np.testing.assert_array_equal(surface.origin, [0, 0, 1])

    def test_gaps_between_values(self):
        np.testing.assert_array_equal(self.read(triangle_glb(stride=28)).positions, TRIANGLE)

    def test_quantized_positions(self):
        places = np.array([[0, 0, 0], [32767, 0, 0], [0, -32767, 0]], np.int16)
        surface = self.read(triangle_glb([{"mesh": 0, "scale": [3, 3, 3]}], positions=places,
                                         extensionsRequired=["KHR_mesh_quantization"]))
        np.testing.assert_array_equal(surface.positions, places.astype(np.float32) * 3)

    def test_attributes_and_colors(self):
        surface = self.read(triangle_glb(attributes=[
            ("_DENSITY", np.array([[1], [2], [3]], np.float32), {}),
            ("_id", np.array([[1], [2], [300]], np.uint16), {}),
            ("_part", np.array([[0, 255]] * 3, np.uint8), {"normalized": True}),
            ("COLOR_0", np.array([[0, 51, 255]] * 3, np.uint8), {"normalized": True}),
        ]))
        found = {attribute.name: attribute for attribute in surface.attributes}
        np.testing.assert_array_equal(found["DENSITY"].values, [[1], [2], [3]])
        self.assertEqual((found["id"].values.dtype, found["id"].values[2, 0]), (np.int32, 300))
        np.testing.assert_array_equal(found["part"].values[0], [0, 1])
        self.assertTrue(found["Color"].is_color)
        np.testing.assert_allclose(found["Color"].values[0], [0, 0.2, 1, 1])

    def test_compressed_files_are_refused_by_name(self):
        for extension, name in (("KHR_draco_mesh_compression", "Draco"), ("EXT_meshopt_compression", "meshopt")):
            path = self.write("a.glb", triangle_glb(extensionsRequired=[extension]))
            self.assert_unreadable(read_glb, path, name, "without compression")
        path = self.write("a.glb", triangle_glb(primitive={"extensions": {"KHR_draco_mesh_compression": {}}}))
        self.assert_unreadable(read_glb, path, "Draco")
        path = self.write("a.glb", triangle_glb(extensionsRequired=["EXT_other"]))
        self.assert_unreadable(read_glb, path, "EXT_other")

    def test_damaged_files(self):
        self.assert_unreadable(read_glb, self.folder / "none.glb", "No such file")
        good = triangle_glb()
        for damaged, told in (
            (b"glTX" + good[4:], "not a GLB"),
            (good[:4] + b"\1" + good[5:], "version 1"),
            (good.replace(b'"count": 3', b'"count": 9'), "beyond"),
            (good.replace(b'"byteOffset": 0', b'"byteOffset":-9'), "beyond"),
            (good.replace(b'"bufferView": 0', b'"bufferView": 7'), "damaged"),
            (good.replace(b'"mesh": 0', b'"mesh": {'), "damaged"),
            (triangle_glb([{"children": [0]}]), "twice"),
            (triangle_glb(primitive={"indices": 0}), "no indices"),
            (triangle_glb(attributes=[("_i", np.array([[0], [1], [3]], np.uint8), {})],
                          primitive={"indices": 1}), "corner"),
            (triangle_glb(attributes=[("NORMAL", TRIANGLE[:2], {})]), "2 of 3"),
        ):
            self.assert_unreadable(read_glb, self.write("a.glb", damaged), told)


def ply(form, body, *lines):
    return "\n".join(["ply", f"format {form} 1.0", *lines, "end_header", ""]).encode() + body


XYZ = ("property float x", "property float y", "property float z")
FACES = "property list uchar int vertex_indices"


class PlyTest(FolderTest):
    def read(self, data):
        return read_ply(self.write("a.ply", data))

    def test_polygons_become_fans(self):
        corners = b"0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
        head = ("element vertex 4", *XYZ, "element face 2", FACES)
        for faces, wanted in ((b"4 0 1 2 3\n4 3 2 1 0\n", [[0, 1, 2], [0, 2, 3], [3, 2, 1], [3, 1, 0]]),
                              (b"3 0 1 2\n4 0 1 2 3\n", [[0, 1, 2], [0, 1, 2], [0, 2, 3]]),
                              (b"2 0 1\n3 1 2 3\n", [[1, 2, 3]])):
            text = self.read(ply("ascii", corners + faces, *head))
            np.testing.assert_array_equal(text.triangles, wanted)
            for order, mark in (("little", "<"), ("big", ">")):
                body = struct.pack(mark + "12f", *(float(word) for word in corners.split()))
                for line in faces.splitlines():
                    numbers = [int(word) for word in line.split()]
                    body += struct.pack(f"{mark}B{len(numbers) - 1}i", *numbers)
                binary = self.read(ply(f"binary_{order}_endian", body, *head))
                np.testing.assert_array_equal(binary.triangles, wanted)
                np.testing.assert_array_equal(binary.positions, text.positions)

    def test_what_other_programs_write(self):
        # Windows' line ends, comments, face properties on both sides of the list, an element in between.
        surface = self.read(ply(
            "ascii", b"0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 255 0 0 255\n7 8\n1 3 0 1 2 0.5\n",
            "comment x", "obj_info y", "element vertex 3", *XYZ, "property uchar red", "property uchar green",
            "property uchar blue", "property uchar alpha", "element edge 1", "property int a", "property int b",
            "element face 1", "property uchar flags", "property list uint8 uint32 vertex_index",
            "property float quality",
        ).replace(b"\n", b"\r\n"))
        np.testing.assert_array_equal(surface.triangles, [[0, 1, 2]])
        np.testing.assert_array_equal(surface.attributes[0].values[0], [1, 0, 0, 1])
        self.assertTrue(surface.attributes[0].is_color)

    def test_lists_on_vertices_are_passed_over(self):
        surface = self.read(ply("ascii", b"0 0 0 1 9\n1 0 0 2 8 7\n0 1 0 0\n3 0 1 2\n", "element vertex 3", *XYZ,
                                "property list uchar int neighbours", "element face 1", FACES))
        np.testing.assert_array_equal(surface.positions[:, 0], [0, 1, 0])
        self.assertEqual(surface.attributes, [])

    def test_attributes_of_several_components(self):
        names = ("v_0", "v_1", "v_2", "t_1", "id", "big")
        kinds = ("float", "float", "float", "float", "int", "uint")
        surface = self.read(ply("ascii", b"0 0 0 1 2 3 4 5 4294967295\n", "element vertex 1", *XYZ,
                                *(f"property {kind} {name}" for kind, name in zip(kinds, names))))
        found = {attribute.name: attribute.values for attribute in surface.attributes}
        self.assertEqual({name: values.tolist() for name, values in found.items()},
                         {"v": [[1, 2, 3]], "t_1": [[4]], "id": [[5]], "big": [[4294967296]]})
        self.assertEqual(found["id"].dtype, np.int32)

    def test_doubles_keep_what_floats_would_lose(self):
        rows = b"".join(struct.pack("<3d", 1e8 + x, 0, 0) for x in (0.001, 0.002, 0.004))
        surface = self.read(ply("binary_little_endian", rows, "element vertex 3", "property double x",
                                "property double y", "property double z"))
        np.testing.assert_allclose(surface.positions_from([1e8, 0, 0])[:, 0], [0.001, 0.002, 0.004], atol=2e-8)

    def test_damaged_files(self):
        head = ("element vertex 3", *XYZ, "element face 1", FACES)
        body = b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
        good = ply("ascii", body, *head)
        self.read(good)
        for damaged, told in (
            (good[1:], "not a PLY"),
            (good.replace(b"end_header", b"end"), "does not end"),
            (good.replace(b"ascii", b"text"), "damaged"),
            (good.replace(b"3 0 1 2", b"3 0 1 3"), "corner"),
            (good.replace(b"3 0 1 2", b"3 0 1 -1"), "corner"),
            (good.replace(b"3 0 1 2", b"-3 0 1 2"), "damaged"),
            (good.replace(b"3 0 1 2", b"3 0 x 2"), "damaged"),
            (good.replace(b"vertex 3", b"vertex 999999999"), "damaged"),
            (good.replace(b"vertex 3", b"vertex -3"), "damaged"),
            (good.replace(b"float y", b"float yy"), "no x, y and z"),
        ):
            self.assert_unreadable(read_ply, self.write("a.ply", damaged), told)


class SequenceTest(FolderTest):
    def touch(self, *names):
        for name in names:
            (self.folder / name).write_bytes(b"")

    def test_natural_order_and_gaps(self):
        self.touch("f_1.glb", "f_2.glb", "f_10.glb", "f_4.ply", "g_3.glb", "f_3.glb.part")
        sequence = Sequence.in_folder(str(self.folder), "f_{}.glb")
        self.assertEqual(sequence.names, ("f_1.glb", "f_2.glb", "f_10.glb"))
        self.assertEqual(sequence.missing(), 7)
        at = [sequence.number_at(frame, 1, 1, 10, False) for frame in (-5, 1, 2, 3, 9, 10, 11)]
        self.assertEqual(at, [1, 1, 2, 2, 2, 10, 10])
        self.assertEqual(sequence.path(10), str(self.folder / "f_10.glb"))
        self.assertIsNone(sequence.number_at(1, 1, 3, 9, False))

    def test_loops_and_offsets(self):
        self.touch(*(f"f_{n:04}.ply" for n in (1, 3, 5, 7)))
        sequence = Sequence.in_folder(str(self.folder), "f_{}.ply")
        self.assertEqual(sequence.missing(), 0)
        # The last one lasts as long as the others.
        self.assertEqual([sequence.number_at(frame, 100, 1, 7, True) for frame in range(98, 110)],
                         [7, 7, 1, 1, 3, 3, 5, 5, 7, 7, 1, 1])
        self.assertEqual([sequence.number_at(frame, 0, 3, 5, False) for frame in (-1, 0, 1, 2, 9)], [3, 3, 3, 5, 5])

    def test_the_number_that_changes_is_the_frames(self):
        self.touch("sim2_0001_iso05.glb", "sim2_0002_iso05.glb", "sim2_0003_iso05.glb", "sim3_0001_iso05.glb")
        self.touch("a7b.glb")
        folder = str(self.folder)
        self.assertEqual(pattern_of(folder, "sim2_0002_iso05.glb"), "sim2_{}_iso05.glb")
        self.assertEqual(pattern_of(folder, "a7b.glb"), "a{}b.glb")
        self.touch("still.glb", "odd{}1.glb")
        self.assertEqual(pattern_of(folder, "still.glb"), "still.glb")
        self.assertEqual(sequences_of(folder, ["still.glb"]), [("still.glb", 0, 0)])
        with self.assertRaises(UnreadableFile):
            pattern_of(folder, "odd{}1.glb")

    def test_chosen_files(self):
        self.touch(*(f"a{n}.glb" for n in range(1, 6)), "b1.ply", "b2.ply")
        folder = str(self.folder)
        self.assertEqual(sequences_of(folder, ["a3.glb"]), [("a{}.glb", 1, 5)])
        self.assertEqual(sequences_of(folder, ["a4.glb", "a2.glb", "b1.ply"]), [("a{}.glb", 2, 4), ("b{}.ply", 1, 2)])
        with self.assertRaisesRegex(UnreadableFile, "no such file"):
            sequences_of(folder, ["c1.glb"])

    def test_files_that_come_later_are_seen(self):
        self.touch("a1.glb")
        self.assertEqual(Sequence.in_folder(str(self.folder), "a{}.glb").numbers, (1,))
        self.touch("a2.glb")
        os.utime(self.folder, ns=(1, 1))  # clocks of file systems may be coarse
        self.assertEqual(Sequence.in_folder(str(self.folder), "a{}.glb").numbers, (1, 2))


class CacheTest(FolderTest):
    def test_what_was_used_last_is_kept_within_the_limit(self):
        paths = [str(self.write(f"{n}.glb", triangle_glb())) for n in range(4)]
        cache = SurfaceCache(0)
        first = cache.surface(paths[0], True)
        cache.limit = 3 * first.bytes()
        for path in paths:
            cache.surface(path, True)
            self.assertLessEqual(cache.bytes(), cache.limit)
        self.assertIsNot(cache.surface(paths[0], True), first)
        self.assertIs(cache.surface(paths[3], True), cache.surface(paths[3], True))

    def test_a_changed_file_is_read_again(self):
        path = self.write("a.glb", triangle_glb())
        cache = SurfaceCache(1 << 20)
        before = cache.surface(str(path), True)
        path.write_bytes(triangle_glb([{"mesh": 0, "translation": [1, 2, 3]}]))
        after = cache.surface(str(path), True)
        self.assertEqual((before.origin.tolist(), after.origin.tolist()), ([0, 0, 0], [1, -3, 2]))
        self.assertEqual(cache.surface(str(path), False).origin.tolist(), [1, 2, 3])
        with self.assertRaisesRegex(UnreadableFile, "reads .glb and .ply"):
            cache.surface(str(self.write("a.obj", b"")), True)


if __name__ == "__main__":
    unittest.main()
