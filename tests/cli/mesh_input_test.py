"""A mesh file as the input of a conversion: formats, edits, placement, and the options that need a field."""

import json
import subprocess

import jsonschema
from support import SOURCE, SPHERE, ProgramTest, main, glb_json, needs_modules, read_glb, read_obj, read_ply, read_stl
from written_meshes import box, ply_text, scene_bytes, stl_bytes  # beside mesh_readers

needs_modules("numpy")

import numpy  # noqa: E402

BLOB = ("demo:gyroid?size=24", "--iso", "0.2", "--cap")
RING = ("demo:torus?size=40", "--iso", "0")


def triangles_of(mesh, turn=lambda x, y, z: (x, y, z)):
    """The triangles by the float32 positions of their corners, each turned so that its smallest corner comes first."""
    places = [tuple((numpy.array(turn(*v), "f4") + 0).tolist()) for v in mesh.vertices]
    found = []
    for t in mesh.triangles:
        corners = [places[v] for v in t]
        first = corners.index(min(corners))
        found.append(tuple(corners[first:] + corners[:first]))
    return sorted(found)


def only(meshes):
    (mesh,) = meshes.values()
    return mesh


class MeshInputTest(ProgramTest):
    def mesh(self, name):
        data = (self.folder / name).read_bytes()
        return only(read_glb(data)) if name.endswith(".glb") else {
            "ply": read_ply, "obj": read_obj, "stl": read_stl}[name[-3:]](data)

    def test_formats_keep_the_triangles(self):
        self.convert(*BLOB, "-o", "a.stl")
        for before, after in (("a.stl", "b.glb"), ("b.glb", "c.ply"), ("c.ply", "d.obj"), ("d.obj", "e.gltf"),
                              ("e.gltf", "f.stl")):
            run = self.convert(before, "-o", after)
            self.assertIn(f"{before} -> {after}: ", run.err)
            self.assertIn("; closed; the file's coordinates", run.err)
        expected = triangles_of(self.mesh("a.stl"))
        self.assertGreater(len(expected), 5000)
        for name in ("c.ply", "d.obj", "f.stl"):
            self.assertEqual(triangles_of(self.mesh(name)), expected, name)
        self.assertEqual(triangles_of(self.mesh("b.glb"), lambda x, y, z: (x, -z, y)), expected)
        self.convert("a.stl", "-o", "g.drc")
        self.convert("g.drc", "-o", "h.ply")
        self.assertEqual(len(self.mesh("h.ply").triangles), len(expected))

    def test_the_content_tells_the_format_of_standard_input(self):
        self.convert(*BLOB, "-o", "a.stl")
        self.convert("a.stl", "-o", "text.stl", "--ascii")
        for name in ("a.stl", "text.stl", "b.obj", "c.ply", "d.glb", "e.drc"):
            if name[0] != "a" and name != "text.stl":
                self.convert("a.stl", "-o", name)
            edits = ("--triangles", "50%", "--smooth", "3")
            self.convert(name, *edits, "-o", "file.ply")
            with open(self.folder / name, "rb") as file:  # mapped
                self.convert("-", *edits, "-o", "stdin.ply", stdin=file)
            with subprocess.Popen(["cat", self.folder / name], stdout=subprocess.PIPE) as cat:
                run = self.convert("-", *edits, "-o", "pipe.ply", stdin=cat.stdout)
            self.assertIn("standard input -> pipe.ply: ", run.err)
            expected = (self.folder / "file.ply").read_bytes()
            for made in ("stdin.ply", "pipe.ply"):
                self.assertEqual((self.folder / made).read_bytes(), expected, name)
        with open(self.folder / "a.stl", "rb") as file:
            run = self.run_program("-", "--iso", "1", "-o", "x.ply", stdin=file)
            self.assert_fails(1, run, "--iso has no effect on the mesh standard input")
        # The samples of a raw file may begin in any way.
        (self.folder / "a.raw").write_bytes(b"solid" + (self.folder / "a.stl").read_bytes()[:7995])
        with open(self.folder / "a.raw", "rb") as file:
            run = self.convert("-", "--dims", "20,20,20", "--dtype", "u8", "--iso", "20", "-o", "raw.ply", stdin=file)
            self.assertIn("standard input iso 20 -> raw.ply", run.err)

    def test_edits_give_the_bytes_that_the_volume_gives(self):
        self.convert(*RING, "-o", "mesh.ply")
        for edit in ((), ("--simplify", "0.002world"), ("--triangles", "30%"), ("--triangles", "900"),
                     ("--smooth", "20:sinc"), ("--smooth", "9"), ("--largest", "1"), ("--drop-components", "2000"),
                     ("--clip", "1,2,3,0.1"), ("--clip", "1,2,3,0.1", "--smooth", "5", "--triangles", "40%"),
                     ("--fill-cavities",), ("--scale", "2"), ("--normals", "area"), ("--triangles", "40%", "--normals", "area")):
            for form in ("ply", "obj"):
                with self.subTest(edit=edit, form=form):
                    self.convert(*RING, *edit, "-o", f"volume.{form}")
                    self.convert("mesh.ply", *edit, "-o", f"mesh2.{form}")
                    volume, mesh = ((self.folder / f"{name}.{form}").read_bytes() for name in ("volume", "mesh2"))
                    self.assertEqual(volume.replace(b"o torus\n", b""), mesh.replace(b"o mesh\n", b""))

    def test_clip_and_cap(self):
        vertices, triangles = box((0, 0, 0), (1, 2, 3))
        (self.folder / "box.stl").write_bytes(stl_bytes(vertices, triangles))
        run = self.convert("box.stl", "--clip", "0,0,1,1", "--cap", "-o", "a.ply")
        self.assertIn("; closed;", run.err)
        self.assertAlmostEqual(self.mesh("a.ply").volume(), 4, places=5)
        run = self.convert("box.stl", "--clip", "0,0,1,1", "-o", "b.ply")
        self.assertIn("; open where --clip cut it (--cap closes it);", run.err)
        run = self.run_program("box.stl", "--clip", "0,0,1,7", "-o", "c.ply")
        self.assert_fails(2, run, "box.stl: clipping removes the whole surface; the surface lies in (0, 0, 0) .. (1, 2, 3)")

    def test_placement(self):
        vertices, triangles = box((1, 1, 1), (2, 3, 4))
        (self.folder / "box.stl").write_bytes(stl_bytes(vertices, triangles))
        for options, bounds in (
                ((), ([1, 1, 1], [2, 3, 4])),
                (("--scale", "2"), ([2, 2, 2], [4, 6, 8])),
                (("--center",), ([-0.5, -1, -1.5], [0.5, 1, 1.5])),
                (("--unit", "mm", "--to-unit", "cm"), ([0.1, 0.1, 0.1], [0.2, 0.3, 0.4])),
                (("--up", "y", "--up-out", "z"), ([1, -4, 1], [2, -1, 3]))):
            self.convert("box.stl", *options, "-o", "a.ply")
            found = self.mesh("a.ply").bounds()
            for mine, theirs in zip(found, bounds):
                for a, b in zip(mine, theirs):
                    self.assertAlmostEqual(a, b, places=6, msg=options)
        # The file records how it was placed, also after another conversion.
        self.convert(*BLOB, "--scale", "2", "-o", "a.ply")
        self.convert("a.ply", "--scale", "3", "--center", "-o", "b.glb")
        self.convert("b.glb", "-o", "c.ply")
        self.convert("verify", *BLOB, "c.ply")

    def test_colors_of_vertices_are_srgb_but_in_gltf(self):
        vertices, triangles = box((0, 0, 0), (1, 1, 1))
        colors = [(i * 32, 255 - i, 7 * i) for i in range(8)]
        (self.folder / "a.ply").write_text(ply_text(vertices, triangles, colors))
        self.convert("a.ply", "-o", "b.glb")
        self.convert("b.glb", "-o", "c.ply", "--ascii")
        lines = (self.folder / "c.ply").read_text().split("end_header\n")[1].splitlines()[:8]
        found = {tuple(float(x) for x in line.split()[:3]): tuple(int(x) for x in line.split()[3:6]) for line in lines}
        self.assertEqual(found, dict(zip(vertices, colors)))
        data = (self.folder / "b.glb").read_bytes()
        model = glb_json(data)
        entry = model["accessors"][model["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]]
        view = model["bufferViews"][entry["bufferView"]]
        start = data.index(b"BIN\0") + 4 + view["byteOffset"]
        linear = numpy.frombuffer(data, "<u2", 32, start).reshape(8, 4) / 65535
        srgb = numpy.array(colors) / 255
        expected = numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        self.assertLess(abs(linear[:, :3] - expected).max(), 1e-5)
        self.assertEqual(linear[:, 3].min(), 1)

    def test_frames_of_meshes_share_the_range_of_colors(self):
        vertices, triangles = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
        for frame, values in ((1, [0, 1, 2, 3]), (2, [1, -2, 2, 2])):
            (self.folder / f"m_{frame}.ply").write_text(ply_text(vertices, triangles, quality=values))
        run = self.convert("m_{}.ply", "--color-by", "quality", "-o", "out_{}.ply", "--report", "r_{}.json")
        self.assertIn("the colors range from -2 to 3, the values of all 2 frames", run.err)
        for frame in (1, 2):
            self.assertRegex((self.folder / f"r_{frame}.json").read_text(), r'"range": \[\s*-2.0,\s*3.0\s*\]')

    def test_colors_by_an_attribute_of_the_file(self):
        vertices = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        triangles = [(0, 3, 1), (0, 2, 3), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
                     (2, 7, 3), (2, 6, 7), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
        wrong = [(1, 2, 3)] * 8
        for kind, values in (("float", [0, .5, 1, 2, 3, 4, 5, 6]), ("double", [1e-3 * i for i in range(8)]),
                             ("uchar", [0, 1, 5, 255, 3, 4, 5, 6]), ("short", [-5, 1, 5, 300, 3, 4, 5, 6])):
            (self.folder / "a.ply").write_text(ply_text(vertices, triangles, wrong, kind, values))
            for limits in ((), (-1.0, 4.0)):
                low, high = limits or (min(values), max(values))
                option = "quality:gray" + (f":{low},{high}" if limits else "")
                run = self.convert("a.ply", "--color-by", option, "-o", "b.ply", "--ascii")
                self.assertIn(f"colors of mesh: quality, gray from {low:g} to {high:g}", run.err)
                header, made = (self.folder / "b.ply").read_text().split("end_header\n")
                self.assertEqual(header.count("property uchar red"), 1)
                names = [line.split()[-1] for line in header.splitlines() if line.startswith("property") and "list" not in line]
                for row in made.splitlines()[:8]:
                    found = dict(zip(names, row.split()))
                    at = vertices.index(tuple(int(float(found[axis])) for axis in "xyz"))
                    gray = round(255 * min(max((values[at] - low) / (high - low), 0), 1))
                    self.assertAlmostEqual(int(found["red"]), gray, delta=1)
                    self.assertAlmostEqual(float(found["quality"]), values[at], delta=1e-9 + 1e-7 * abs(values[at]))
        self.convert("a.ply", "--color-by", "quality", "-o", "b.glb")
        for option, code, message in (("qualty", 2, "expected the vertex attribute 'qualty', found quality"),
                                      ("quality?", 1, "takes no =FROM, '?' or settings"),
                                      ("quality=x.vdb", 1, "takes no =FROM"), ("iso", 1, "only a field has iso values")):
            self.assert_fails(code, self.run_program("a.ply", "--color-by", option, "-o", "c.ply"), message)
            self.assertFalse((self.folder / "c.ply").exists())
        self.assertIn("did you mean 'quality'?", self.run_program("a.ply", "--color-by", "qualty", "-o", "c.ply").err)

    def test_options_that_need_a_field(self):
        vertices, triangles = box((0, 0, 0), (1, 1, 1))
        (self.folder / "a.stl").write_bytes(stl_bytes(vertices, triangles))
        for option, *value in (
                ("--iso", "0.5"), ("--method", "mt"), ("--roi", "0,0,0,1,1,1"), ("--roi-snap",), ("--resolution", "9"),
                ("--voxel-size", "1"), ("--kernel", "cubic"), ("--filter", "median"), ("--blur", "1"), ("--nan", "hole"),
                ("--labels", "all"), ("--labels-min-voxels", "3"), ("--background", "1"), ("--label-names", "a.txt"),
                ("--relax", "3"), ("--no-merge",), ("--t-junctions",), ("--attribute", "v"),
                ("--to-space", "ras"), ("--half",), ("--error",), ("--verify",),
                ("--backend", "gpu"), ("--device", "0"), ("--grid", "a"), ("--volume", "1"), ("--component", "1"),
                ("--spacing", "1"), ("--origin", "0,0,0"), ("--inside", "below"), ("--nodata", "0"),
                ("--dims", "1,1,1"), ("--particles", "sph"), ("--radius", "1"), ("--select", "x > 1")):
            with self.subTest(option=option):
                run = self.run_program("a.stl", option, *value, "-o", "b.ply")
                self.assert_fails(1, run, f"{option} has no effect on the mesh a.stl: ", f"hint: leave out {option}")
        for options, parts in (
                (("--simplify", "0.1"), ("voxels, which a mesh does not have", "--simplify 0.1world")),
                (("--drop-components", "area:4"), ("voxels", "--drop-components area:4world")),
                (("--smooth", "9:weighted"), ("particles",)),
                (("--cap",), ("--clip",)),
                (("--space", "index"), ("voxel coordinates",)),
                (("--normals", "smooth"), ("gradient of a field", "--normals area"))):
            with self.subTest(options=options):
                self.assert_fails(1, self.run_program("a.stl", *options, "-o", "b.ply"), *parts)
        for output in ("b.vdb", "b.npy", "b.bgeo", "b_{iso}.ply"):
            self.assert_fails(1, self.run_program("a.stl", "-o", output), output, "mesh")
        self.assertEqual(self.files(), ["a.stl"])

    def test_defects_are_told(self):
        vertices, triangles = box((0, 0, 0), (1, 1, 1))
        turned = [t[::-1] for t in triangles[:1]] + triangles[1:]
        for name, some, part in (("open", triangles[1:], "; open at 3 edges;"),
                                 ("turned", turned, "; not manifold: 3 edges between opposite windings;"),
                                 ("twice", triangles + triangles[:1], "; not manifold: 3 edges with more than two triangles")):
            (self.folder / f"{name}.ply").write_text(ply_text(vertices, some))
            run = self.convert(f"{name}.ply", "-o", f"{name}.obj")
            self.assertIn(part, run.err)
            self.assertNotIn("; closed", run.err)

    def test_damaged_files_give_no_output(self):
        self.convert("demo:sphere?size=8", "--iso", "0", "-o", "a.stl")
        self.convert("demo:sphere?size=8", "--iso", "0", "-o", "a.glb")
        self.convert("demo:sphere?size=8", "--iso", "0", "-o", "a.drc")
        self.convert("demo:sphere?size=8", "--iso", "0", "-o", "a.ply")
        whole = {name: (self.folder / name).read_bytes() for name in self.files()}
        for name, data in whole.items():
            for size in (0, 3, 50, 90, len(data) // 3, len(data) // 2, len(data) - 1):
                (self.folder / name).write_bytes(data[:size])
                run = self.run_program(name, "--smooth", "3", "-o", "out.obj")
                with self.subTest(name=name, size=size):
                    self.assertEqual(run.code, 2, run.err)
                    self.assertNotIn("out.obj", self.files())
        self.assert_fails(2, self.run_program("gone.stl", "-o", "out.obj"), "gone.stl")
        (self.folder / "empty.obj").write_text("# nothing\n")
        self.assert_fails(2, self.run_program("empty.obj", "-o", "out.ply"), "empty.obj: the file has no triangles")
        self.convert("empty.obj", "-o", "out.ply", "--empty", "skip")
        self.assertNotIn("out.ply", self.files())

    def test_info_names_the_command(self):
        self.convert(*RING, "-o", "a.stl")
        self.convert(*RING, "-o", "a.ply")
        for name in ("a.stl", "a.ply"):
            self.assert_fails(2, self.run_program("info", name), f"isoextract {name} -o OUT.glb")
        self.convert("a.ply", "--triangles", "1k", "-o", "b.ply")
        self.assertEqual(len(self.mesh("b.ply").triangles), 1000)

    def test_its_own_file_is_not_overwritten(self):
        self.convert("demo:sphere?size=8", "--iso", "0", "-o", "a.glb")
        before = (self.folder / "a.glb").read_bytes()
        self.assert_fails(1, self.run_program("a.glb"), "a.glb")
        self.assert_fails(1, self.run_program("a.glb", "-o", "a.glb"), "a.glb")
        self.assertEqual((self.folder / "a.glb").read_bytes(), before)

    def test_pictures_and_reports(self):
        self.convert("demo:sphere?size=16", "--iso", "0", "-o", "a.stl")
        self.convert("a.stl", "-o", "a.png", "--size", "64x48")
        self.convert("a.stl", "--triangles", "50%", "-o", "b.glb", "--report", "r.json", "--html", "h.html")
        report = json.loads((self.folder / "r.json").read_text())
        schema = json.loads((SOURCE / "docs" / "schemas" / "report.schema.json").read_text())
        jsonschema.Draft202012Validator(schema).validate(report)
        (entry,) = report["mesh_files"]
        self.assertEqual((entry["path"], entry["format"], entry["parts"]), ("a.stl", "STL, binary", 1))
        self.assertEqual(entry["triangles"], len(self.mesh("a.stl").triangles))
        self.assertEqual([mesh["iso"] for mesh in report["meshes"]], ["mesh"])
        self.assertTrue(report["meshes"][0]["closed"])
        self.assertIsNone(report["device"])

    # Scenes

    def test_a_scene_keeps_names_materials_and_places(self):
        (self.folder / "a.glb").write_bytes(scene_bytes())
        run = self.convert("a.glb", "-o", "b.glb")
        self.assertIn("note[data-left-out]: a.glb: the reader leaves out cameras, metalness, roughness and light of "
                      "materials, texture coordinates", run.err)
        self.assertIn("a.glb (4 meshes) -> b.glb: 36 triangles", run.err)
        meshes = read_glb((self.folder / "b.glb").read_bytes())
        self.assertEqual(list(meshes), ["chair", "lamp", "table red", "table glass"])
        self.assertEqual(meshes["lamp"].bounds(), ([3, 0, 0], [5, 1, 1]))
        self.assertAlmostEqual(meshes["lamp"].volume(), 2)
        self.assertEqual(meshes["table glass"].bounds()[0][1], 3)
        model = glb_json((self.folder / "b.glb").read_bytes())
        looks = {node["name"]: model["materials"][model["meshes"][node["mesh"]]["primitives"][0]["material"]]
                 for node in model["nodes"]}
        color = {name: look["pbrMetallicRoughness"]["baseColorFactor"] for name, look in looks.items()}
        self.assertEqual(color["chair"], [1, 0, 0, 1])
        self.assertEqual(color["table glass"], [0, 0.5, 1, 0.25])
        self.assertEqual((looks["table glass"]["alphaMode"], looks["table glass"]["doubleSided"]), ("BLEND", True))
        # The same again, from isoextract's own file.
        run = self.convert("b.glb", "-o", "c.glb")
        again = glb_json((self.folder / "c.glb").read_bytes())
        self.assertEqual(again["materials"], model["materials"])
        self.assertEqual([n["name"] for n in again["nodes"]], [n["name"] for n in model["nodes"]])
        run = self.convert("b.glb", "-o", "d.obj")
        self.assertIn("obj has no materials, so the output lacks those of 4 meshes", run.err)
        self.convert("d.obj", "-o", "e.glb")
        self.assertEqual(list(read_glb((self.folder / "e.glb").read_bytes())), list(meshes))

    def test_formats_for_one_mesh_get_all_meshes(self):
        (self.folder / "a.glb").write_bytes(scene_bytes())
        run = self.convert("a.glb", "-o", "b.ply", "--ascii")
        self.assertIn("the 4 meshes of the file become one, without their names", run.err)
        mesh = self.mesh("b.ply")
        self.assertEqual(len(mesh.triangles), 36)
        self.assertAlmostEqual(mesh.volume(), 1 + 2 + 1, places=5)
        rows = (self.folder / "b.ply").read_text().split("end_header\n")[1].splitlines()
        colors = [tuple(int(x) for x in row.split()[3:6]) for row in rows[:len(mesh.vertices)]]
        self.assertEqual(colors[0], (255, 0, 0))
        self.assertEqual(colors[-1], (0, 188, 255))  # linear 0.5 is 188 in sRGB
        self.convert("a.glb", "--split-components", "-o", "p_{piece}.stl")
        self.assertEqual(sum(1 for name in self.files() if name.startswith("p_")), 4)

    # Repair

    def damaged(self, name, vertices, triangles):
        (self.folder / name).write_text(ply_text(vertices, triangles))
        run = self.convert(name, "--repair", "-o", "out.ply", "--report", "r.json")
        (entry,) = json.loads((self.folder / "r.json").read_text())["repairs"]
        return self.mesh("out.ply"), entry, run

    def test_repair_of_each_damage(self):
        vertices, triangles = box((0, 0, 0), (1, 2, 3))
        soup = [v for t in triangles for v in (vertices[i] for i in t)]
        each = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(12)]
        flipped = [t[::-1] if i in (1, 4, 7) else t for i, t in enumerate(triangles)]
        inward = [t[::-1] for t in triangles]
        middle = [*vertices, tuple((a + b) / 2 for a, b in zip(vertices[triangles[0][0]], vertices[triangles[0][1]]))]
        a, b, c = triangles[0]
        split = [(a, 8, c), (8, b, c), *triangles[1:], (a, b, 8)]  # a triangle without area closes the T-junction
        for name, some, many, figure, count in (
                ("unwelded", soup, each, "welded", 28), ("twice", vertices, triangles + triangles[2:4], "duplicates", 2),
                ("flipped", vertices, flipped, "turned", 3), ("inward", vertices, inward, "components_turned", 1),
                ("open", vertices, triangles[2:], "holes_filled", 1), ("cut", vertices, triangles[1:3] + triangles[4:], "holes_filled", 2),
                ("flat", middle, split, "without_area", 1),
                ("repeated", vertices, [*triangles, (1, 1, 2)], "without_area", 1)):
            with self.subTest(name=name):
                mesh, entry, run = self.damaged(f"{name}.ply", some, many)
                self.assertEqual(entry[figure], count, entry)
                self.assertEqual(mesh.open_edges(), 0)
                self.assertAlmostEqual(mesh.volume(), 6, places=6)
                self.assertEqual(entry["verdict"], "printable")
                self.assertIn("; closed;", run.err)
                self.assertIn("then printable", run.err)

    def test_repair_of_everything_at_once(self):
        self.convert("demo:gyroid?size=20", "--iso", "0.2", "--cap", "-o", "a.ply")
        whole = self.mesh("a.ply")
        volume = self.numpy_volume(whole)
        random = numpy.random.default_rng(7)
        triangles = list(whole.triangles)
        gone = set(random.choice(len(triangles), 12, replace=False).tolist())
        rest = [t for i, t in enumerate(triangles) if i not in gone]
        rest = [t[::-1] if random.random() < 0.3 else t for t in rest] + rest[5:9]
        soup = [whole.vertices[v] for t in rest for v in t]
        order = random.permutation(len(rest))
        each = [(3 * i, 3 * i + 1, 3 * i + 2) for i in order]
        mesh, entry, _ = self.damaged("b.ply", soup, each)
        self.assertEqual(mesh.open_edges(), 0)
        self.assertAlmostEqual(self.numpy_volume(mesh) / volume, 1, places=3)
        self.assertEqual(entry["duplicates"], 4)
        self.assertEqual(len(mesh.triangles), len(triangles))
        self.assertLessEqual(entry["holes_filled"], 12)

    @staticmethod
    def numpy_volume(mesh):
        corners = numpy.array(mesh.vertices)[numpy.array(mesh.triangles)]
        return numpy.einsum("ij,ij->i", corners[:, 0], numpy.cross(corners[:, 1], corners[:, 2])).sum() / 6

    def test_shells_are_turned_by_nesting(self):
        parts = [box((0, 0, 0), (9, 9, 9)), box((1, 1, 1), (4, 4, 4)), box((2, 2, 2), (3, 3, 3)), box((20, 0, 0), (21, 1, 1))]
        vertices, triangles = [], []
        for some, many in parts:
            triangles += [tuple(i + len(vertices) for i in t) for t in many]
            vertices += some
        mesh, entry, _ = self.damaged("nested.ply", vertices, triangles)
        self.assertEqual(entry["components_turned"], 1)
        self.assertAlmostEqual(mesh.volume(), 729 - 27 + 1 + 1, places=4)

    def test_what_repair_leaves(self):
        sheet = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        mesh, entry, run = self.damaged("sheet.ply", sheet, [(0, 1, 2), (0, 2, 3)])
        self.assertEqual((entry["holes_left"], len(mesh.triangles)), (1, 2))
        self.assertIn("not printable: 4 open edges", run.err)
        strip = [(numpy.cos(a) * (3 + w * numpy.cos(a / 2)), numpy.sin(a) * (3 + w * numpy.cos(a / 2)), w * numpy.sin(a / 2))
                 for a in numpy.linspace(0, 2 * numpy.pi, 20, endpoint=False) for w in (-1, 1)]
        faces = []
        for i in range(20):
            a, b, c, d = 2 * i, 2 * i + 1, (2 * i + 2) % 40, (2 * i + 3) % 40
            if i == 19:
                c, d = d, c
            faces += [(a, b, c), (b, d, c)]
        _, entry, run = self.damaged("moebius.ply", strip, faces)
        self.assertEqual(entry["contradictions"], 1)
        vertices, triangles = box((0, 0, 0), (1, 2, 3))
        (self.folder / "open.ply").write_text(ply_text(vertices, triangles[2:]))
        run = self.convert("open.ply", "--repair=0", "-o", "out.ply")
        self.assertIn("left 1 hole open", run.err)
        self.assertEqual(self.mesh("out.ply").open_edges(), 4)
        self.assert_fails(1, self.run_program("open.ply", "--repair=2000", "-o", "out.ply"), "--repair", "0 to 1000")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--repair", "-o", "o.ply"), "--repair", "mesh")


if __name__ == "__main__":
    main()
