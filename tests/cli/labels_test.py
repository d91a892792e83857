"""--labels: smooth meshes of label maps, names and colors from tables, what is refused and in which words."""

import collections
import gzip
import json
import random
import resource
import struct
import unittest.mock

from support import (
    DATA, NO_GPU, SOURCE, SPHERE, ProgramTest, glb_json, main, needs_data, read_glb, read_obj, read_ply, read_stl)

ITK_SNAP = '# labels\n1 255 0 0 1 1 1 "Left kidney"\n5 0 255 0 1 1 1 "Tumour"\n6 0 0 255 1 1 1 "not there"\n'
FREE_SURFER = "#No. Label Name: R G B A\n1  Left-Kidney  0 0 255 0\n5  Tumour  255 255 0 0\n"


def placed_triangles(mesh):
    """Each as its corners' positions, the least first: how often it occurs."""
    found = collections.Counter()
    for triangle in mesh.triangles:
        corners = [tuple(mesh.vertices[v]) for v in triangle]
        least = corners.index(min(corners))
        found[tuple(corners[least:] + corners[:least])] += 1
    return found


def without_gaps(meshes):
    """How many triangles two meshes have in common; each is turned over in the other, and occurs once."""
    everywhere = collections.Counter()
    for mesh in meshes:
        everywhere.update(placed_triangles(mesh))
    assert max(everywhere.values()) == 1
    return sum((a, c, b) in everywhere for a, b, c in everywhere) // 2


class LabelsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        # Two halves of a ball of 12 voxels radius, labeled 1 and 5, and 9 far from both.
        def label(x, y, z):
            if (x - 15.3) ** 2 + (y - 14.6) ** 2 + (z - 14.9) ** 2 < 144:
                return 1 if x < 15 else 5
            return 9 if x > 33 else 0

        self.write_raw("map.raw", (36, 30, 30), label, "B")
        self.map = ("map.raw", "--dims", "36,30,30")
        (self.folder / "snap.txt").write_text(ITK_SNAP)
        (self.folder / "lut.txt").write_text(FREE_SURFER)

    def glb(self, *arguments):
        run = self.convert(*self.map, *arguments, "-o", "out.glb")
        return read_glb((self.folder / "out.glb").read_bytes()), run

    def test_a_cut_is_closed_label_by_label_and_neighbors_still_meet(self):
        """Caps close each mesh: what is cut off and what stays have the volume of the whole, and the color."""
        for method in ("surface-nets", "voxels"):
            arguments = ("--labels", "all", "--label-names", "snap.txt", "--method", method, "--report", "r.json")

            def made(*cut, where=arguments):
                meshes, run = self.glb(*where, *cut)
                report = json.loads((self.folder / "r.json").read_text())
                colors = {m["name"]: m["pbrMetallicRoughness"]["baseColorFactor"]
                           for m in glb_json((self.folder / "out.glb").read_bytes())["materials"]}
                return meshes, {m["name"]: m for m in report["meshes"]}, colors, run.err

            whole, facts, colors, _ = made()
            sides = []
            for x, y, z, offset in ((0, 0.3, 1, 18.4), (0, -0.3, -1, -18.4)):
                cut = ("--clip", f"{x},{y},{z},{offset}")
                open_meshes, open_facts, _, _ = made(*cut)
                meshes, cut_facts, cut_colors, told = made(*cut, "--cap")
                self.assertNotIn("--cap changes nothing", told)
                self.assertIn("map.raw label 5: ", told)
                self.assertEqual(cut_colors, {name: colors[name] for name in meshes})
                self.assertFalse(open_facts["Tumour"]["closed"])
                for name, mesh in meshes.items():
                    self.assertTrue(cut_facts[name]["closed"], name)
                    self.assertEqual(mesh.vertices, open_meshes[name].vertices)
                # The wall between the two halves, and its end in the plane: the same places in both, bit for bit.
                common = set(map(tuple, meshes["Left kidney"].vertices)) & set(map(tuple, meshes["Tumour"].vertices))
                # glTF is y up: (x, y, z) became (x, z, -y).
                on_plane = [v for v in common if abs(-y * v[2] + z * v[1] - offset) < 1e-4]
                self.assertGreater(len(on_plane), 10)
                if method == "surface-nets":  # faces of voxels are merged to rectangles mesh by mesh
                    self.assertGreater(without_gaps([open_meshes["Left kidney"], open_meshes["Tumour"]]), 100)
                sides.append(cut_facts)
            for name in whole:
                volume = sum(side[name]["volume"] for side in sides if name in side)
                self.assertAlmostEqual(volume / facts[name]["volume"], 1, delta=1e-5)

    def test_what_changes_each_mesh_by_itself_is_told(self):
        run = self.convert(*self.map, "--labels", "all", "--smooth", "5", "-o", "a.glb")
        self.assertIn("--smooth changes the mesh of each label separately", run.err)

    def test_one_run_makes_smooth_closed_meshes_without_gaps(self):
        meshes, run = self.glb("--labels", "all", "--report", "r.json")
        self.assertEqual(list(meshes), ["map label 1", "map label 5", "map label 9"])
        self.assertIn("closed", run.err)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["options"]["method"], "surface-nets")
        self.assertEqual(report["options"]["relaxations"], 15)
        self.assertTrue(all(mesh["closed"] for mesh in report["meshes"]))
        halves = report["meshes"][:2]
        ball = 4 / 3 * 3.14159265 * 12 ** 3
        self.assertAlmostEqual(sum(mesh["volume"] for mesh in halves) / ball, 1, delta=0.01)
        # Half a ball's area and a disc each; of voxels the round parts would have half as much again.
        self.assertAlmostEqual(sum(mesh["area"] for mesh in halves) / (6 * 3.14159265 * 144), 1, delta=0.03)
        self.assertGreater(without_gaps([meshes["map label 1"], meshes["map label 5"]]), 700)

    def test_check_requires_of_each_mesh_what_the_conversion_does(self):
        required = ("--require", "printable")
        self.convert(*self.map, "--labels", "all", "--normals", "none", *required, "-o", "a.glb")
        report = json.loads(self.convert("check", "a.glb", *required, "--json").out)
        self.assertGreater(report["mesh"]["duplicate_triangles"], 100)  # the common faces of neighbors
        self.assertTrue(all(entry["met"] for entry in report["required"]))
        run = self.run_program("check", "a.glb", "--require", "normals")
        self.assertEqual(run.code, 6)
        self.assertIn("the mesh does not meet the requirement normals: map label 1 has no normals; 3 of 3 meshes fail", run.err)

    def test_the_choice_changes_no_mesh(self):
        everything, _ = self.glb("--labels", "all")
        one, _ = self.glb("--labels", "5")
        self.assertEqual(list(one), ["map label 5"])
        self.assertEqual(one["map label 5"].vertices, everything["map label 5"].vertices)
        self.assertEqual(one["map label 5"].triangles, everything["map label 5"].triangles)

    def test_relaxing_makes_it_smooth(self):
        areas = []
        for rounds in (0, 3, 30):
            self.convert(*self.map, "--labels", "1", "--relax", rounds, "-o", "a.ply", "--report", "r.json")
            areas.append(json.loads((self.folder / "r.json").read_text())["meshes"][0]["area"])
        self.assertEqual(areas, sorted(areas, reverse=True))
        self.assertGreater(areas[0] / areas[2], 1.25)

    def test_a_label_that_is_cut_away_is_told_of(self):
        run = self.run_program(*self.map, "--labels", "5", "--clip", "1,0,0,1000", "-o", "a.ply")
        self.assert_fails(2, run, "clipping removes the whole surface at label 5", "hint: check --clip NX,NY,NZ,D: a plane keeps")

    def test_what_is_done_to_a_mesh_is_told_by_label(self):
        run = self.convert(*self.map, "--labels", "5", "--smooth", "5", "--simplify", "0.2", "--largest", "-o", "a.ply")
        for done in ("components", "smoothed", "simplified"):
            self.assertIn(f"  {done} at label 5: ", run.err)

    def test_files_of_their_own(self):
        self.convert(*self.map, "--labels", "1,9", "-o", "part_{iso}.stl")
        self.assertEqual(round(read_stl((self.folder / "part_9.stl").read_bytes()).volume()), 2 * 900)
        self.assertLess(read_stl((self.folder / "part_1.stl").read_bytes()).volume(), 3700)

    def test_names_and_colors_of_itk_snap(self):
        meshes, _ = self.glb("--labels", "all", "--label-names", "snap.txt")
        self.assertEqual(list(meshes), ["Left kidney", "Tumour", "map label 9"])
        colors = [material["pbrMetallicRoughness"]["baseColorFactor"] for material in
                   glb_json((self.folder / "out.glb").read_bytes())["materials"]]
        self.assertEqual(colors[:2], [[1, 0, 0, 1], [0, 1, 0, 1]])
        self.assertNotIn(colors[2], colors[:2])
        self.convert(*self.map, "--labels", "all", "--label-names", "snap.txt", "-o", "o.obj")
        self.assertIn("Left", (self.folder / "o.obj").read_text())

    def test_nodes_meshes_and_materials_have_the_names(self):
        for table, names in (((), ["map label 1", "map label 5", "map label 9"]),
                             (("--label-names", "snap.txt"), ["Left kidney", "Tumour", "map label 9"])):
            for extension in ("glb", "gltf"):
                out = self.folder / f"named.{extension}"
                self.convert(*self.map, "--labels", "all", *table, "-o", out.name)
                model = glb_json(out.read_bytes()) if extension == "glb" else json.loads(out.read_text())
                nodes = [node for node in model["nodes"] if "mesh" in node]
                self.assertEqual([node["name"] for node in nodes], names)
                for node in nodes:
                    mesh = model["meshes"][node["mesh"]]
                    self.assertEqual(mesh["name"], node["name"])
                    for primitive in mesh["primitives"]:
                        self.assertEqual(model["materials"][primitive["material"]]["name"], node["name"])

    def test_names_and_colors_of_freesurfer(self):
        meshes, _ = self.glb("--labels", "1", "--label-names", "lut.txt", "--opacity", "0.5")
        self.assertEqual(list(meshes), ["Left-Kidney"])
        factor = glb_json((self.folder / "out.glb").read_bytes())["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
        self.assertEqual(factor, [0, 0, 1, 0.5])
        self.convert(*self.map, "--labels", "5", "--label-names", "lut.txt", "--ascii", "-o", "o.ply")
        text = (self.folder / "o.ply").read_text()
        self.assertIn("property uchar red", text)
        self.assertTrue(text.split("end_header\n")[1].split("\n")[0].endswith(" 255 255 0"))
        self.convert(*self.map, "--labels", "5", "--ascii", "-o", "o.ply")
        self.assertNotIn("uchar red", (self.folder / "o.ply").read_text())

    def test_colors_without_a_table_differ_and_colors_by_number_are_asked_for(self):
        self.glb("--labels", "all")
        self.assertEqual(len(glb_json((self.folder / "out.glb").read_bytes())["materials"]), 3)
        usual = (self.folder / "out.glb").read_bytes()
        self.glb("--labels", "all", "--color-by", "iso")
        self.assertNotEqual((self.folder / "out.glb").read_bytes(), usual)

    def test_tables_that_are_none(self):
        for text, words in (("1 a b\n", "line 1: expected a label line of ITK-SNAP"), ("", ""),
                            ("1 a 1 2 3 0\n1 b 1 2 3 0\n", "expected each label once"),
                            ("#\n1 a 1 2 999 0\n", "line 2"), ("\x1b[2J\n", "\\x1b")):
            (self.folder / "bad.txt").write_text(text)
            run = self.run_program(*self.map, "--labels", "all", "--label-names", "bad.txt", "-o", "x.glb")
            self.assert_fails(2, run, "bad.txt", words)
            self.assertNotIn("\x1b", run.err)
        (self.folder / "bad.txt").write_bytes(bytes(range(256)) * 64)
        self.assert_fails(2, self.run_program(*self.map, "--labels", "all", "--label-names", "bad.txt", "-o", "x.glb"))
        self.assert_fails(2, self.run_program(*self.map, "--labels", "1", "--label-names", "no.txt", "-o", "x.glb"), "no.txt")
        self.assertNotIn("x.glb", self.files())

    def test_what_is_refused(self):
        def refused(*arguments, code=1):
            run = self.run_program(*self.map, *arguments, "-o", "x.glb")
            self.assert_fails(code, run)
            self.assertNotIn("x.glb", self.files())
            return run.err

        self.assertIn("--labels does not work with marching cubes", refused("--labels", "all", "--method", "mc"))
        self.assertIn("--label-names needs --labels", refused("--iso", "0", "--label-names", "lut.txt"))
        self.assertIn("--relax does not work with voxels", refused("--labels", "1", "--method", "voxels", "--relax", "3"))
        self.assertIn("--relax", refused("--labels", "1", "--relax", "-1"))
        self.assertIn("--no-merge does not work with surface nets", refused("--labels", "1", "--no-merge"))
        self.assertIn("--normals smooth: surface nets", refused("--labels", "1", "--normals", "smooth"))
        self.assertIn("no sample has label 7", refused("--labels", "1,7", code=2))
        self.assertIn("expected a label map of whole numbers from", self.run_program(
            SPHERE, "--labels", "all", "-o", "x.glb").err)
        self.assertEqual(self.run_program(*self.map, "--labels", "1", "--backend", "gpu", "-o", "x.glb").code, 3)
        self.convert(*self.map, "--labels", "1", "--backend", "auto", "-o", "y.glb", env=NO_GPU)

    def write_npy(self, name, typecode, values):
        kinds = {"q": "<i8", "Q": "<u8", "f": "<f4", "d": "<f8", "i": "<i4"}
        header = f"{{'descr': '{kinds[typecode]}', 'fortran_order': False, 'shape': (6, 6, 6), }}\n".encode()
        (self.folder / name).write_bytes(b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header +
                                         struct.pack(f"<216{typecode}", *values))

    def test_wide_integers_and_whole_floats_are_labels(self):
        """Ids as other programs write them: each type gives the mesh of i32, or the id that it cannot hold is named."""
        def block(label, background=0):
            return [label if 1 <= n % 6 < 4 and 1 <= n // 6 % 6 < 4 and n // 36 in (2, 3) else background
                    for n in range(216)]

        def made(name, labels="all"):
            run = self.convert(name, "--labels", labels, "-o", "out.glb")
            return read_glb((self.folder / "out.glb").read_bytes()), run.err

        self.write_npy("i32.npy", "i", block(7))
        expected, _ = made("i32.npy")
        for typecode in "qQfd":
            self.write_npy("wide.npy", typecode, block(7))
            meshes, told = made("wide.npy")
            self.assertEqual(list(meshes), ["wide label 7"])
            self.assertEqual(meshes["wide label 7"].triangles, expected["i32 label 7"].triangles)
            self.assertEqual(meshes["wide label 7"].vertices, expected["i32 label 7"].vertices)
            held = "f32" if typecode == "f" else "f64"
            words = f"all of its samples, stored as {held}, are whole numbers: the program uses them as labels"
            self.assertEqual(words in told, typecode in "fd", told)
        for typecode, label in (("q", 2 ** 53 + 1), ("q", -2 ** 60 - 1), ("Q", 2 ** 63 - 1), ("f", 2 ** 24)):
            self.write_npy("wide.npy", typecode, block(label))
            self.assertEqual(list(made("wide.npy")[0]), [f"wide label {label}"])
            self.assertEqual(list(made("wide.npy", label)[0]), [f"wide label {label}"])
        for typecode, label, found in (
                ("Q", 2 ** 64 - 1, "up to 9223372036854775807, found 18446744073709551615 at sample (1, 1, 2)"),
                ("d", 2 ** 53 + 2, "f64, or 64-bit integers), found 9007199254740994 at sample (1, 1, 2)"),
                ("f", 2 ** 24 + 2, "from -16777216 to 16777216 (sample type f32), found 16777218 at sample (1, 1, 2)"),
                ("f", 7.5, "(sample type f32), found 7.5 at sample (1, 1, 2)"),
                ("d", float("nan"), "found nan at sample (1, 1, 2)")):
            self.write_npy("wide.npy", typecode, block(label))
            run = self.run_program("wide.npy", "--labels", "all", "-o", "x.glb")
            self.assert_fails(2, run, found)
            if typecode in "qQ":
                self.assertIn("renumber", run.err)
                self.assertNotIn("as integers", run.err)
        for typecode in "fd":
            self.write_npy("wide.npy", typecode, block(float("-inf")))
            run = self.run_program("wide.npy", "--labels", "all", "-o", "x.glb")
            self.assert_fails(2, run, "found -inf at sample (1, 1, 2)", "in place of the infinite values")
            self.assertNotRegex(run.err, "renumber|as integers")

    def test_notes_say_what_does_not_apply(self):
        run = self.convert(*self.map, "--labels", "1", "--cap", "--error", "-o", "x.ply")
        self.assertIn("--cap changes nothing: the surface of surface nets is closed everywhere", run.err)
        self.assertIn("the program cannot measure the error of labels: they have no isosurface between the samples", run.err)

    def test_a_table_that_changes_makes_frames_anew(self):
        for frame in (1, 2):
            self.write_raw(f"in_{frame}.raw", (9, 9, 9), lambda x, y, z, f=frame: f if x < 4 else 0, "B")
        command = ("in_{}.raw", "--dims", "9,9,9", "--labels", "all", "--label-names", "lut.txt", "-o", "out_{}.glb",
                   "--resume")
        self.convert(*command)
        self.assertEqual(list(read_glb((self.folder / "out_1.glb").read_bytes())), ["Left-Kidney"])
        (self.folder / "lut.txt").write_text("1 Other 1 2 3 0\n")
        self.convert(*command)
        self.assertEqual(list(read_glb((self.folder / "out_1.glb").read_bytes())), ["Other"])

    def test_a_mask_by_its_iso_value(self):
        self.convert(*self.map, "--iso", "0", "--method", "surface-nets", "-o", "m.obj")
        self.assertEqual(read_obj((self.folder / "m.obj").read_bytes()).open_edges(), 0)

    def test_another_grid_has_no_label_that_the_map_does_not_have(self):
        """Each sample of it is one of the map: means of ids 8 and 16 would be 12, and other labels."""
        def label(x, y, z):
            if not (4 <= x < 12 and 4 <= y < 12):
                return 0
            return 8 if 4 <= z < 10 else 16 if 10 <= z < 13 else 0

        for dtype, typecode in (("u8", "B"), ("u16", "H"), ("i32", "i"), ("f32", "f")):
            self.write_raw("ids.raw", (16, 16, 16), label, typecode)
            volume = ("ids.raw", "--dims", "16,16,16", "--dtype", dtype)
            for grid in (("--resolution", "31"), ("--resolution", "9"), ("--voxel-size", "0.5"), ("--voxel-size", "0.4"),
                         ("--resolution", "31", "--kernel", "nearest")):
                self.convert(*volume, "--labels", "all", *grid, "-o", "a.glb")
                self.assertEqual(list(read_glb((self.folder / "a.glb").read_bytes())), ["ids label 8", "ids label 16"])
        # Samples half as far apart: eight times as many of each label, an eighth as large.
        self.convert(*volume, "--labels", "8", "--relax", "0", "--resolution", "31", "-o", "a.ply", "--report", "r.json")
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["options"]["kernel"], "majority")
        self.assertAlmostEqual(report["meshes"][0]["volume"], 8 * 8 * 6, delta=1e-3)
        self.assertEqual(self.run_program("verify", *volume, "--labels", "8", "--relax", "0", "--resolution", "31",
                                          "a.ply").code, 0)

    def test_sparse_labels_on_another_grid(self):
        run = self.convert(SOURCE / "samples" / "metaballs.vdb", "--iso", "0.5", "--kernel", "nearest",
                           "--resolution", "20", "-o", "a.ply")
        self.assertIn("its sparse samples become", run.err)
        self.assertEqual(read_ply((self.folder / "a.ply").read_bytes()).open_edges(), 0)

    def test_options_that_mean_nothing_to_labels_are_refused(self):
        for options, words in ((("--inside", "below"), "--inside does not work with --labels"),
                               (("--inside", "above"), "--inside does not work with --labels"),
                               (("--component", "length"), "--component length does not work with --labels"),
                               (("--blur", "1"), "--blur does not work with --labels"),
                               (("--resolution", "9", "--kernel", "cubic"), "--kernel cubic does not work with --labels"),
                               (("--resolution", "9", "--kernel", "linear"), "--kernel linear does not work with")):
            self.assert_fails(1, self.run_program(*self.map, "--labels", "all", *options, "-o", "x.glb"), words)

    def test_samples_without_data_have_no_label(self):
        def label(x, y, z, no_data):
            return no_data if x == 0 else 3 if 4 <= min(x, y, z) and max(x, y, z) < 10 else 0

        def made(*arguments):
            run = self.convert("gaps.raw", "--dims", "12,12,12", *arguments, "--labels", "all", "-o", "g.glb")
            return read_glb((self.folder / "g.glb").read_bytes()), run.err

        self.write_raw("gaps.raw", (12, 12, 12), lambda x, y, z: label(x, y, z, 0), "B")
        expected, _ = made()
        self.write_raw("gaps.raw", (12, 12, 12), lambda x, y, z: label(x, y, z, float("nan")), "f")
        nan = ("--dtype", "f32")
        self.assert_fails(2, self.run_program("gaps.raw", "--dims", "12,12,12", *nan, "--labels", "all", "-o", "x.glb"),
                          "found nan at sample (0, 0, 0)", "--nan outside")
        self.assertEqual(made(*nan, "--nan", "outside")[0]["gaps label 3"].vertices, expected["gaps label 3"].vertices)
        for method in ("surface-nets", "voxels"):
            meshes, told = made(*nan, "--nan", "outside", "--method", method, "--explain")
            self.assertEqual(list(meshes), ["gaps label 3"])
            self.assertIn("samples except NaN, stored as f32, are whole numbers", told)
            self.assertIn("144 samples that are not numbers", told)
        for typecode, dtype in (("B", "u8"), ("H", "u16"), ("i", "i32")):
            self.write_raw("gaps.raw", (12, 12, 12), lambda x, y, z: label(x, y, z, 255), typecode)
            meshes, told = made("--dtype", dtype, "--nodata", "255")
            self.assertEqual(list(meshes), ["gaps label 3"])
            self.assertEqual(meshes["gaps label 3"].vertices, expected["gaps label 3"].vertices)
            self.assertIn("144 of 1728 samples have the no-data value 255", told)

    def relaxed(self, label, *options, side=40):
        """What is printed of all labels in a cube of voxels, and the report's entries about relaxing."""
        self.write_raw("thin.raw", (side, side, side), label, "B")
        run = self.convert("thin.raw", "--dims", f"{side},{side},{side}", "--labels", "all", *options, "-o", "t.glb",
                           "--report", "r.json")
        report = json.loads((self.folder / "r.json").read_text())
        return run.err, report.get("relaxations"), report["meshes"]

    def test_relaxing_keeps_volumes(self):
        def bar(x, y, z):
            return x == y == 35 and 5 <= z < 35

        def ball(x, y, z):
            return (x - 15) ** 2 + (y - 15) ** 2 + (z - 20) ** 2 < 144

        def hole(*p):
            return all(14 <= a < 16 for a in p)

        for rounds in ((), ("--relax", "1"), ("--relax", "100")):
            told, records, meshes = self.relaxed(
                lambda *p: 5 if ball(*p) and not hole(*p) else 2 if bar(*p) else 3 if p == (30, 30, 30) else 0, *rounds)
            self.assertNotIn("relaxing changed", told)
            self.assertEqual([record["components"] for record in records], [1, 1, 2])
            for record, mesh, voxels in zip(records, meshes, (30, 1, None)):
                before, after = record["volume"]["before"], record["volume"]["after"]
                if voxels:
                    self.assertAlmostEqual(before, voxels, delta=1e-4)
                self.assertAlmostEqual(after / before, 1, delta=0.001)
                self.assertAlmostEqual(after / mesh["volume"], 1, delta=1e-4)
                self.assertEqual(record["changed_components"], 0)
        told, records, _ = self.relaxed(lambda *p: int(ball(*p)), "--relax", "0")
        self.assertIsNone(records)
        # A plane cuts the smooth surface elsewhere than the voxels.
        self.assertEqual(self.relaxed(lambda *p: int(ball(*p)), "--clip", "1,0,0,10", "--cap")[1], [])

    def test_volumes_that_relaxing_cannot_keep_are_told(self):
        rng = random.Random(7)
        noise = {(x, y, z): rng.randrange(4) for x in range(14) for y in range(14) for z in range(14)}
        told, records, _ = self.relaxed(lambda *p: noise[p], side=14)
        changed = sum(record["changed_components"] for record in records)
        components = sum(record["components"] for record in records)
        self.assertGreater(changed, 0)
        self.assertLess(changed, components / 2)
        self.assertRegex(told, rf"relaxing changed the volume of .*{changed} of {components} components by more than 0.1 %, "
                               r"most in .*thin.raw label [123], from \S+ to \S+ \(\S+ % (less|more)\): --relax 0 keeps")

    def test_surface_nets_of_a_mask_need_one_option(self):
        self.write_raw("mask.raw", (20, 20, 20), lambda *p: 255 if sum((a - 9.5) ** 2 for a in p) < 50 else 0, "B")
        raw = ("mask.raw", "--dims", "20,20,20", "--dtype", "u8")
        run = self.convert(*raw, "--method", "surface-nets", "-o", "net.ply")
        self.assertIn("iso 0.5, because the samples are integers, such as those of a mask: all above 0 are inside", run.err)
        self.convert(*raw, "--labels", "255", "-o", "label.ply")
        self.assertEqual((self.folder / "net.ply").read_bytes(), (self.folder / "label.ply").read_bytes())
        run = self.convert("verify", *raw, "--method", "surface-nets", "net.ply")
        self.assertIn("note[iso-chosen]: iso 0.5, because the samples are integers", run.err)
        self.assertRegex(run.text, r"same +yes")
        # Without integers, an iso value is needed.
        self.write_raw("density.raw", (8, 8, 8), lambda x, y, z: x / 8)
        refused = self.run_program("density.raw", "--dims", "8,8,8", "--dtype", "f32", "--method", "surface-nets", "-o", "a.ply")
        self.assert_fails(1, refused, "a density has no default iso value")

    def test_work_grows_with_the_labels_and_not_with_its_cube(self):
        """Cubes of 2 voxels, each with a label of its own: 8000 in 40 voxels along an axis."""
        self.write_raw("many.raw", (40, 40, 40), lambda x, y, z: 1 + x // 2 + 20 * (y // 2) + 400 * (z // 2), "H")
        many = ("many.raw", "--dims", "40,40,40", "--dtype", "u16", "--labels", "all", "--threads", "1", "-o", "x.glb")
        with unittest.mock.patch("support.PROCESSOR_SECONDS", 20):
            self.assertEqual(self.convert(*many, "-q").err, "")

    def test_labels_that_a_coarser_grid_loses_are_told(self):
        def label(*p):
            return 2 if all(14 <= a < 16 for a in p) else 3 if all(2 <= a < 4 for a in p) else int(all(5 <= a < 25 for a in p))

        self.write_raw("l.raw", (30, 30, 30), label, "B")
        raw = ("l.raw", "--dims", "30,30,30")
        for coarse in (("--voxel-size", "6"), ("--resolution", "6")):
            run = self.convert(*raw, "--labels", "all", *coarse, "-o", "x.glb", "--report", "r.json")
            self.assertIn("note[labels-lost]: l.raw: no mesh for 2 of 3 labels (2, 3): the coarser grid has no sample of these labels", run.err)
            (fact,) = (fact for fact in json.loads((self.folder / "r.json").read_text())["work"] if fact["what"] == "labels")
            self.assertEqual((fact["done"], fact["count"], fact["total"]), ("left out", 2, 3))
            self.assertIn(": 2, 3", fact["text"])
        for fine in ((), ("--voxel-size", "0.5")):
            self.assertNotIn("no mesh for", self.convert(*raw, "--labels", "all", *fine, "-o", "x.glb").err)
        # The first few of many.
        self.write_raw("many.raw", (30, 30, 30), lambda x, y, z: x + 1 if y == z == 14 else 0, "B")
        run = self.run_program("many.raw", "--dims", "30,30,30", "--labels", "all", "--resolution", "6", "--empty", "skip", "-o", "x.glb")
        self.assertIn("no mesh for 30 of 30 labels (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, ...)", run.err)

    def test_threads_change_no_byte(self):
        files = set()
        for threads in (1, 2, 5):
            self.convert(*self.map, "--labels", "all", "--threads", threads, "-o", "t.glb")
            files.add((self.folder / "t.glb").read_bytes())
        self.assertEqual(len(files), 1)

    @needs_data("med/ch2.nii.gz")
    def test_five_labels_of_a_head_meet_without_gaps(self):
        data = gzip.decompress((DATA / "med/ch2.nii.gz").read_bytes())
        start = int(struct.unpack_from("<f", data, 108)[0])
        # A slab of it, through the middle.
        width, height, depth = 181, 217, 12
        first = start + width * height * 80
        kinds = bytes(sum(value >= limit for limit in (20, 60, 90, 110, 140)) for value in range(256))
        (self.folder / "head.raw").write_bytes(data[first:first + width * height * depth].translate(kinds))
        self.convert("head.raw", "--dims", f"{width},{height},{depth}", "--labels", "all", "-o", "h.glb", "--report", "r.json")
        meshes = read_glb((self.folder / "h.glb").read_bytes())
        self.assertEqual(len(meshes), 5)
        self.assertGreater(without_gaps(meshes.values()), 100_000)
        self.assertTrue(all(mesh["closed"] for mesh in json.loads((self.folder / "r.json").read_text())["meshes"]))


if __name__ == "__main__":
    main()
