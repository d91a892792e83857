"""isoextract check: what is wrong with a mesh, exit code 6, the document and its schema."""

import json
import math
import struct
import subprocess
import sys

from support import INSTALL, SOURCE, SPHERE, ProgramTest, main, peak_mib_of, read_ply

try:
    import jsonschema
except ImportError:
    sys.exit(f"{sys.executable} has no module jsonschema: {INSTALL}, as python3-jsonschema, for Debian's own python3")

MIB = 1 << 20
# The program and its libraries, the stacks of its threads, and small allocations without a reservation.
OVERHEAD = 64 * MIB
SCHEMA = json.loads((SOURCE / "docs" / "schemas" / "check.schema.json").read_text())
FORMATS = ("glb", "gltf", "ply", "obj", "stl", "drc")
CUBE = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5),
         (3, 7, 5)]


class CheckTest(ProgramTest):
    def write_obj(self, name, vertices, faces, normals=()):
        rows = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"vn {x} {y} {z}" for x, y, z in normals]
        rows += ["f " + " ".join(f"{i + 1}//{i + 1}" if normals else str(i + 1) for i in face) for face in faces]
        (self.folder / name).write_text("\n".join(rows) + "\n")

    def json(self, *arguments):
        run = self.convert("check", "--json", *arguments)
        document = json.loads(run.text)
        jsonschema.Draft202012Validator(SCHEMA).validate(document)
        return document

    def test_a_sound_mesh_in_every_format(self):
        for extension in FORMATS:
            name = f"sphere.{extension}"
            # As few bits as Draco has unless told leave some triangles no area.
            self.convert(SPHERE, "--iso", 0, "-o", name, *(["--draco", "20"] if extension == "drc" else []))
            report = self.json(name, "--require", "printable,one-component,no-unused-vertices")
            mesh = report["mesh"]
            self.assertTrue(mesh["closed"], name)
            self.assertEqual((mesh["components"], mesh["genus"], mesh["shells"]["body"]), (1, 0, 1))
            self.assertEqual(mesh["self_intersections"]["pairs"], 0)
            self.assertAlmostEqual(mesh["volume"], mesh["largest_components"][0]["volume"])
            self.assertEqual(report["unit"], "m" if extension in ("glb", "gltf") else None)
            self.assertTrue(all(one["met"] for one in report["required"]))
            self.assertEqual(len(report["required"]), 9)

    def test_cubes_that_touch_are_one_story(self):
        """Closed, not manifold, and a body with a volume: two cubes that share an edge, a vertex, or nothing."""
        second = [[(x + dx, y + dy, z + dz) for x, y, z in CUBE] for dx, dy, dz in ((1, 1, 0), (1, 1, 1), (3, 0, 0))]
        for name, cube, shared, problem in (("edge", second[0], 2, "no: 1 edge of more than two triangles"),
                                            ("vertex", second[1], 1, "no: 1 vertex where surfaces touch"),
                                            ("apart", second[2], 0, "yes")):
            vertices = list(dict.fromkeys(CUBE + cube))
            self.assertEqual(len(vertices), 16 - shared)
            faces = FACES + [tuple(vertices.index(cube[i]) for i in face) for face in FACES]
            self.write_obj(f"{name}.obj", vertices, faces)
            text = self.convert("check", f"{name}.obj").text
            for part in ("closed        yes\n", f"manifold      {problem}", "outward       yes\n", "volume        2\n",
                         f"components    {2 if name == 'apart' else 1}: {2 if name == 'apart' else 1} body\n"):
                self.assertIn(part, text, name)
            self.assertNotIn(" open", text, name)
            self.assertEqual("genus" in text.split("components")[0], name == "apart")
            mesh = self.json(f"{name}.obj")["mesh"]
            self.assertTrue(mesh["closed"])
            self.assertAlmostEqual(mesh["volume"], 2)
            self.assertEqual((mesh["shells"]["open"], mesh["shells"]["not oriented"]), (0, 0))
            # A slicer needs edges of two triangles, but no fans.
            self.assertNotIn("the mesh is closed, manifold", text)
            self.assertEqual("surfaces touch at 1 vertex, which slicers accept" in text, name == "vertex")
            # Turned inside out as a whole, it is inside out.
            self.write_obj("turned.obj", vertices, [face[::-1] for face in faces])
            turned = self.convert("check", "turned.obj").text
            self.assertIn("inside out", turned)
            self.assertIn("volume        -2\n", turned)
        # One cube turned against the other, along their common edge: closed, but without one inside.
        vertices = list(dict.fromkeys(CUBE + second[0]))
        faces = FACES + [tuple(vertices.index(second[0][i]) for i in face) for face in FACES]
        self.write_obj("flap.obj", vertices, faces[:-1] + [faces[-1][::-1]])
        text = self.convert("check", "flap.obj").text
        for part in ("components    1: 1 not oriented\n", "closed        yes\n", "outward       unknown: no component has an inside\n"):
            self.assertIn(part, text)
        self.assertIsNone(self.json("flap.obj")["mesh"]["volume"])

    def test_voxels_that_touch_are_one_story(self):
        for name, inside in (("edge", ((2, 2, 2), (3, 3, 2))), ("vertex", ((2, 2, 2), (3, 3, 3)))):
            self.write_raw("v.raw", (6, 6, 6), lambda x, y, z: 1 if (x, y, z) in inside else 0, "B")
            for method in ("voxels", "surface-nets"):
                self.convert("v.raw", "--dims", "6,6,6", "--dtype", "u8", "--iso", "0.5", "--method", method, "--touching", "keep",
                             "-o", "v.stl")
                text = self.convert("check", "v.stl").text
                self.assertIn("components    1: 1 body\n", text)
                self.assertIn("closed        yes\n", text)
                self.assertIn("outward       yes\n", text)
                self.assertIn("manifold      no: ", text)

    def test_a_mesh_from_stdin(self):
        """Its content says which format it is, from a pipe as from a file; the figures are those of the file."""
        for extension, *options in (("glb",), ("ply",), ("ply", "--ascii"), ("obj",), ("stl",), ("stl", "--ascii"), ("drc",)):
            name = f"sphere.{extension}"
            self.convert(SPHERE, "--iso", 0, "-o", name, *options)
            expected = {**self.json(name), "file": "standard input"}
            with (self.folder / name).open("rb") as file:
                self.assertEqual(json.loads(self.convert("check", "-", "--json", stdin=file).text), expected, name)
            with subprocess.Popen(["cat", self.folder / name], stdout=subprocess.PIPE) as pipe:
                run = self.convert("check", "-", "--report", "r.json", stdin=pipe.stdout)
            self.assertTrue(run.text.startswith("standard input\n"), run.text)
            self.assertEqual(json.loads((self.folder / "r.json").read_text()), expected)
        (self.folder / "faces.obj").write_text("# by hand\n\no one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        with (self.folder / "faces.obj").open("rb") as file:
            self.assert_fails_after_report(self.run_program("check", "-", "--require", "closed", stdin=file))
        for content, part in ((b"1 2 3\n", "standard input: expected a mesh (.glb"), (b"", "standard input: it is empty"),
                              (b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin", "byteLength": 4}], "bufferViews": '
                               b'[{"buffer": 0, "byteLength": 4}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": '
                               b'1, "type": "SCALAR"}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": '
                               b'[{"mesh": 0}], "scenes": [{"nodes": [0]}]}', "standard input: the header names the data file 'a.bin'")):
            (self.folder / "in").write_bytes(content)
            with (self.folder / "in").open("rb") as file:
                self.assert_fails(2, self.run_program("check", "-", stdin=file), part)

    def assert_fails_after_report(self, run):
        self.assertEqual(run.code, 6, run.err)
        self.assertIn("isoextract: error: standard input: the mesh does not meet the requirement closed", run.err)

    def test_normals_in_every_format(self):
        """Of facets, of vertices, and of corners whose vertices were welded."""
        for extension in FORMATS:
            for kind in ("smooth", "flat", "none"):
                name = f"{kind}.{extension}"
                options = [] if extension == "stl" else ["--normals", kind]
                self.convert(SPHERE, "--iso", 0, *options, "-o", name, *(["--draco", "20"] if extension == "drc" else []))
                mesh = self.json(name)["mesh"]
                if (kind == "none" and extension != "stl") or name == "flat.ply":
                    self.assertIsNone(mesh["normals"], name)
                    continue
                self.assertEqual(mesh["normals"], {"corners": 3 * mesh["triangles"], "against": 0, "missing": 0, "not_unit": 0}, name)

    def test_the_schema_is_one_and_refuses_what_it_does_not_know(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        self.write_obj("cube.obj", CUBE, FACES)
        report = self.json("cube.obj")
        valid = jsonschema.Draft202012Validator(SCHEMA).is_valid
        self.assertTrue(valid(report))
        self.assertFalse(valid({**report, "new": 1}))
        self.assertFalse(valid({**report, "mesh": {**report["mesh"], "new": 1}}))
        self.assertFalse(valid({**report, "meshes": [report["mesh"]]}))  # without a name
        self.assertTrue(valid({**report, "meshes": [{"name": "", **report["mesh"]}]}))
        self.assertFalse(valid({**report, "meshes": [{"name": "", "new": 1, **report["mesh"]}]}))

    def test_the_table(self):
        self.write_obj("open.obj", CUBE, FACES[1:])
        text = self.convert("check", "open.obj").text
        for part in ("open.obj\n", "OBJ", "1 x 1 x 1; the file states no unit", "no: 3 open edges in 1 loop; the longest has 3 edges and length 3.41421",
                     "1: 1 open", "slicer        It fills 1 hole", "slicer        It reads the numbers as millimeters", "engine"):
            self.assertIn(part, text)
        self.assertNotIn("volume", text)
        self.write_obj("cube.obj", CUBE, FACES)
        text = self.convert("check", "cube.obj").text
        for part in ("volume        1\n", "genus         0\n", "closed        yes\n", "intersections none\n",
                     "slicer        It needs no repair"):
            self.assertIn(part, text)

    def test_requirements(self):
        self.write_obj("open.obj", CUBE, FACES[1:])
        self.convert("check", "open.obj", "--require", "manifold,oriented")
        run = self.run_program("check", "open.obj", "--require", "manifold,closed,normals")
        self.assertEqual(run.code, 6)
        self.assertIn("closed        no", run.text)
        self.assertEqual(run.err, "isoextract: error: open.obj: the mesh does not meet the requirements closed, normals: 3 open edges in 1 loop; no normals\n")
        run = self.run_program("check", "open.obj", "--json", "--require", "closed", "--report", "report.json")
        self.assertEqual(run.code, 6)
        document = json.loads(run.text)
        self.assertEqual(document["required"], [{"requirement": "closed", "met": False, "found": "3 open edges in 1 loop"}])
        self.assertEqual((self.folder / "report.json").read_text(), run.text)

    def test_usage(self):
        self.write_obj("cube.obj", CUBE, FACES)
        self.assert_fails(1, self.run_program("check"), "expected one mesh, found 0")
        self.assert_fails(1, self.run_program("check", "a.ply", "b.ply"), "found 2: a.ply, b.ply")
        self.assert_fails(1, self.run_program("check", "cube.obj", "--require", "close"), "expected a comma-separated list of closed, ", "'closed'?")
        self.assert_fails(1, self.run_program("check", "cube.obj", "--require", ""), "found ''")
        self.assert_fails(1, self.run_program("check", "cube.obj", "--report", "cube.obj"), "cube.obj")
        self.assert_fails(4, self.run_program("check", "cube.obj", "--report", "no/folder.json"), "no/folder.json")
        self.assertEqual(self.files(), ["cube.obj"])

    def test_planted_faults(self):
        def mesh(vertices, faces):
            self.write_obj("planted.obj", vertices, faces)
            return self.json("planted.obj")["mesh"]

        moved = [(x + 0.5, y + 0.25, z + 0.125) for x, y, z in CUBE]
        second = [tuple(i + 8 for i in face) for face in FACES]
        through = mesh(CUBE + moved, FACES + second)
        self.assertGreater(through["self_intersections"]["pairs"], 6)
        self.assertEqual((through["self_intersections"]["in_one_plane"], through["components"]), (0, 2))
        inner = [(0.25 + x / 2, 0.25 + y / 2, 0.25 + z / 2) for x, y, z in CUBE]
        turned = [(a, c, b) for a, b, c in second]
        with_cavity = mesh(CUBE + inner, FACES + turned)
        self.assertEqual((with_cavity["shells"]["cavity"], with_cavity["shells"]["body"]), (1, 1))
        self.assertAlmostEqual(with_cavity["volume"], 1 - 1 / 8)
        self.assertEqual(mesh(CUBE + inner, FACES + second)["shells"]["body within a body"], 1)
        self.assertEqual(mesh(CUBE, [(a, c, b) for a, b, c in FACES])["shells"]["inside out"], 1)
        within_open = mesh(CUBE + inner, FACES[1:] + turned)["shells"]
        self.assertEqual((within_open["open"], within_open["cavity or inside out"], within_open["inside out"]), (1, 1, 0))
        beside_open = mesh(CUBE + [(x + 5, y, z) for x, y, z in CUBE], FACES[1:] + turned)["shells"]
        self.assertEqual((beside_open["cavity or inside out"], beside_open["inside out"]), (0, 1))
        twice = mesh(CUBE, FACES + FACES[:1])
        self.assertEqual((twice["duplicate_triangles"], twice["nonmanifold_edges"]), (1, 3))
        needle = mesh(CUBE + [(2, 2, 2), (3, 3, 3), (4, 4, 4), (9, 9, 9)], FACES + [(8, 9, 10), (8, 8, 9)])
        self.assertEqual([needle[key] for key in ("zero_area_triangles", "repeated_index_triangles", "unused_vertices")], [2, 1, 1])
        wrong = mesh(CUBE, [(0, 1, 2)] + FACES[1:])
        self.assertEqual(wrong["misoriented_edges"], 3)

    def test_vertices_at_one_place(self):
        corners = [CUBE[i] for face in FACES for i in face]
        self.write_obj("seams.obj", corners, [(i, i + 1, i + 2) for i in range(0, 36, 3)])
        apart = self.json("seams.obj")["mesh"]
        self.assertEqual((apart["open_edges"], apart["repeated_vertices"], apart["if_joined"]["open_edges"]), (36, 28, 0))
        run = self.run_program("check", "seams.obj", "--require", "closed")
        self.assertEqual(run.code, 6)
        self.assertIn("hint: with --weld", run.err)
        joined = self.json("seams.obj", "--weld", "--require", "printable,one-component,no-unused-vertices")["mesh"]
        self.assertEqual((joined["vertices"], joined["genus"], joined["if_joined"]), (8, 0, None))

    def test_normals_of_files(self):
        centered = [(x - 0.5, y - 0.5, z - 0.5) for x, y, z in CUBE]
        self.write_obj("good.obj", centered, FACES, [tuple(v / math.sqrt(0.75) for v in corner) for corner in centered])
        self.convert("check", "good.obj", "--require", "normals")
        self.write_obj("bad.obj", centered, FACES, [(-x, -y, -z) for x, y, z in centered])
        normals = self.json("bad.obj")["mesh"]["normals"]
        self.assertEqual(normals, {"corners": 36, "against": 36, "missing": 0, "not_unit": 36})
        self.assertIn("36 of 36 corners point against", self.convert("check", "bad.obj").text)
        # The facets of an STL file, one of them turned and one without a normal.
        records = b""
        for number, face in enumerate(FACES):
            a, b, c = (centered[i] for i in face)
            u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
            normal = [u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]
            normal = [-n for n in normal] if number == 3 else [0, 0, 0] if number == 5 else normal
            records += struct.pack("<12fH", *normal, *a, *b, *c, 0)
        (self.folder / "facets.stl").write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + records)
        normals = self.json("facets.stl")["mesh"]["normals"]
        self.assertEqual(normals, {"corners": 33, "against": 3, "missing": 3, "not_unit": 0})

    def test_seams_beside_an_extension_that_leaves_positions_alone(self):
        self.convert("demo:gyroid?size=12", "--iso", 0, "--cap", "-o", "seams.gltf")
        model = json.loads((self.folder / "seams.gltf").read_text())
        model["extensionsUsed"] = [*model.get("extensionsUsed", []), "KHR_materials_variants"]
        model["extensions"] = {**model.get("extensions", {}), "KHR_materials_variants": {"variants": [{"name": "one"}]}}
        for primitive in model["meshes"][0]["primitives"]:
            primitive["extensions"] = {"KHR_materials_variants": {"mappings": []}}
        (self.folder / "variants.gltf").write_text(json.dumps(model))
        found = [self.json(name)["mesh"] for name in ("seams.gltf", "variants.gltf")]
        self.assertTrue(found[0]["closed"])
        self.assertEqual(found[0], found[1])

    def test_normals_turn_with_the_nodes_of_gltf(self):
        self.convert("demo:torus?size=24", "--iso", 0, "-o", "torus.gltf")
        model = json.loads((self.folder / "torus.gltf").read_text())
        nodes = [node for node in model["nodes"] if "mesh" in node]
        for change in ({"scale": [1, 5, 1]}, {"scale": [-1, 2, 3]}, {"rotation": [0.5, 0.5, 0.5, 0.5]},
                       {"matrix": [1, 0, 0, 0, 2, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}):
            for node in nodes:
                for key in ("scale", "rotation", "matrix"):
                    node.pop(key, None)
                node.update(change)
            (self.folder / "turned.gltf").write_text(json.dumps(model))
            normals = self.json("turned.gltf")["mesh"]["normals"]
            self.assertEqual((normals["against"], normals["missing"], normals["not_unit"]), (0, 0, 0), change)

    def test_damaged_normals(self):
        self.write_obj("range.obj", CUBE, FACES, [(0, 0, 1)] * 7)
        self.assert_fails(2, self.run_program("check", "range.obj"), "range.obj: expected normal indices below 7", "found 7")
        self.write_obj("some.obj", CUBE, FACES, CUBE)
        text = (self.folder / "some.obj").read_text()
        (self.folder / "some.obj").write_text(text.replace("f 1//1 3//3 2//2", "f 1 3/ 2/2/"))
        self.assertEqual(self.json("some.obj")["mesh"]["normals"]["missing"], 3 + 2)  # and one vertex's is of length 0
        self.convert(SPHERE, "--iso", 0, "-o", "sphere.gltf")
        model = json.loads((self.folder / "sphere.gltf").read_text())
        (primitive,) = model["meshes"][0]["primitives"]
        model["accessors"][primitive["attributes"]["NORMAL"]]["count"] -= 1
        (self.folder / "sphere.gltf").write_text(json.dumps(model))
        self.assert_fails(2, self.run_program("check", "sphere.gltf"), "sphere.gltf: expected ", " normals of component type 5126 (float) or 5120 to 5123 (bytes, shorts), found")
        self.convert("compare", "sphere.gltf", "sphere.gltf")  # which does without

    def test_each_mesh_of_a_file_and_all(self):
        self.convert(SPHERE, "--iso", -0.2, "--iso", 0.2, "-o", "two.glb")
        report = self.json("two.glb")
        self.assertEqual(len(report["meshes"]), 2)
        self.assertEqual([mesh["components"] for mesh in (*report["meshes"], report["mesh"])], [1, 1, 2])
        self.assertEqual(sum(mesh["triangles"] for mesh in report["meshes"]), report["mesh"]["triangles"])
        self.assertEqual(report["mesh"]["shells"]["body within a body"], 1)
        self.assertEqual([mesh["shells"]["body"] for mesh in report["meshes"]], [1, 1])
        self.assertNotEqual(report["meshes"][0]["name"], report["meshes"][1]["name"])
        text = self.convert("check", "two.glb").text
        self.assertIn("meshes        2; the figures below are for all meshes together", text)
        for mesh in report["meshes"]:
            self.assertIn(f"\n{mesh['name']}\n", text)
        self.convert(SPHERE, "--iso", 0, "-o", "one.glb")
        self.assertEqual(self.json("one.glb")["meshes"], [])

    def test_what_cannot_be_checked(self):
        self.assert_fails(2, self.run_program("check", "missing.ply"), "missing.ply")
        self.write_obj("nan.obj", [*CUBE[:7], ("nan", 0, 0)], FACES)
        self.assert_fails(2, self.run_program("check", "nan.obj"), "nan.obj: expected finite coordinates", "vertex 7")
        self.write_obj("range.obj", CUBE, [*FACES, (0, 1, 8)])
        self.assert_fails(2, self.run_program("check", "range.obj"), "range.obj: expected indices below 8", "found 8 in triangle 12")
        self.write_obj("cube.obj", CUBE, FACES)
        self.assert_fails(2, self.run_program("check", "cube.obj", "--memory-limit", "1K"), "--memory-limit")

    def test_odd_meshes(self):
        (self.folder / "empty.obj").write_text("# nothing\n")
        report = self.json("empty.obj")
        self.assertEqual((report["mesh"]["triangles"], report["mesh"]["closed"]), (0, False))
        run = self.run_program("check", "empty.obj", "--require", "closed")
        self.assertEqual(run.code, 6)
        self.assertIn("empty.obj: the mesh does not meet the requirement closed: no triangles", run.err)
        self.write_obj("one.obj", CUBE[:3], [(0, 1, 2)])
        one = self.json("one.obj")["mesh"]
        self.assertEqual((one["components"], one["open_edges"], one["loops"]), (1, 3, 1))
        huge = [(x * 1e30, y * 1e30, z * 1e30) for x, y, z in CUBE]
        self.write_obj("huge.obj", huge, FACES)
        self.convert("check", "huge.obj", "--require", "printable,one-component")
        self.assertAlmostEqual(self.json("huge.obj")["mesh"]["volume"] / 1e90, 1, places=5)

    def write_ply(self, name, vertices, triangles):
        """Both as packed numbers."""
        header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices) // 12}\nproperty float x\nproperty float y\n"
                  f"property float z\nelement face {len(triangles) // 13}\nproperty list uchar int vertex_indices\nend_header\n")
        (self.folder / name).write_bytes(header.encode() + vertices + triangles)

    def test_memory_is_reserved_before_it_is_taken(self):
        """With less than the process took, but for its libraries and stacks, it must refuse."""
        self.convert("demo:gyroid?size=224", "--iso", 0, "-o", "gyroid.glb")
        count = 500000
        corners = [(i % 500, i // 500, 0.25 * (i % 3)) for i in range(count)]
        self.write_ply("soup.ply", b"".join(struct.pack("<9f", x, y, z, x + 0.9, y, z, x, y + 0.9, z) for x, y, z in corners),
                       b"".join(struct.pack("<B3i", 3, i, i + 1, i + 2) for i in range(0, 3 * count, 3)))
        for name in ("gyroid.glb", "soup.ply"):
            run = self.convert("check", name, "--verbose")
            peak = peak_mib_of(run) * MIB
            self.assertGreater(peak, 2 * OVERHEAD, name)
            refused = self.run_program("check", name, "--memory-limit", f"{int(peak - OVERHEAD)}B")
            self.assert_fails(2, refused, "--memory-limit")

    def test_same_figures_for_any_number_of_threads(self):
        self.convert("demo:gyroid?size=40", "--iso", 0, "-o", "gyroid.ply")
        mesh = read_ply((self.folder / "gyroid.ply").read_bytes())
        shaken = [tuple(c + 0.06 * math.sin(50 * i + axis) for axis, c in enumerate(v)) for i, v in enumerate(mesh.vertices)]
        self.write_obj("shaken.obj", shaken, mesh.triangles)
        one = self.convert("check", "shaken.obj", "--json", "--threads", 1).out
        self.assertGreater(json.loads(one)["mesh"]["self_intersections"]["pairs"], 100)
        self.assertEqual(one, self.convert("check", "shaken.obj", "--json", "--threads", 3).out)


if __name__ == "__main__":
    main()
