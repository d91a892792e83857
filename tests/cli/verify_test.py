"""isoextract verify: a written mesh against its volume, one backend against the other; exit code 6."""

import json
import struct

from support import SOURCE, SPHERE, ProgramTest, main, read_stl

FORMATS = ("glb", "gltf", "ply", "obj", "stl")
METABALLS = SOURCE / "samples" / "metaballs.vdb"
GYROID = "demo:gyroid?size=24"


class VerifyTest(ProgramTest):
    def write(self, name, *arguments):
        self.convert(*arguments, "-o", name)

    def verify(self, name, *arguments, code=0):
        """The JSON of a verification, with the exit code that it must have."""
        run = self.run_program("verify", *arguments, name, "--json")
        self.assertEqual(run.code, code, run.err)
        report = json.loads(run.text)
        self.assertEqual(report["passed"], code == 0)
        self.assertEqual(report["differences"] == [], code == 0)
        return report, run

    def test_every_format_with_nothing_but_its_name(self):
        for end in FORMATS:
            self.write(f"a.{end}", SPHERE, "--iso", 0)
            report, run = self.verify(f"a.{end}", SPHERE, "--iso", 0)
            self.assertEqual(run.err, "")
            self.assertEqual(report["triangles"][0], report["triangles"][1])
            self.assertEqual(report["triangles_only"], [0, 0])
            self.assertEqual(report["vertices_only"], [0, 0])
            self.assertEqual(report["distance"], [0, 0, 0])

    def test_a_recorded_placement_that_the_volume_does_not_allow(self):
        self.convert(SPHERE, "-o", "plain.nrrd")
        header, samples = (self.folder / "plain.nrrd").read_bytes().split(b"\n\n", 1)
        space = header.replace(b"space dimension: 3", b"space: left-posterior-superior")
        self.assertNotEqual(space, header)
        (self.folder / "lps.nrrd").write_bytes(space + b"\n\n" + samples)
        self.write("ras.ply", "lps.nrrd", "--iso", "0", "--inside", "below", "--to-space", "ras")
        run = self.run_program("verify", "plain.nrrd", "--iso", "0", "--inside", "below", "ras.ply")
        self.assert_fails(2, run, "ras.ply: verify cannot apply the placement that this mesh file records: plain.nrrd: ")

    def test_a_label_map_without_labels(self):
        """The mesh records a placement, which is not at fault."""
        self.write_raw("map.raw", (12, 12, 12),
                       lambda x, y, z: (1 + x // 6 + 2 * (y // 6)) * (2 <= x < 10 and 2 <= y < 10 and 2 <= z < 10), "B")
        volume = ("map.raw", "--dims", "12,12,12")
        self.write("one.ply", *volume, "--labels", "1", "--center", "--unit", "mm")
        run = self.run_program("verify", *volume, "one.ply")
        self.assert_fails(1, run, "map.raw: expected labels or an iso value, found neither; the samples look like a label map",
                          "  hint: use --labels all ")
        self.assertNotIn("cannot apply the placement", run.err)
        self.verify("one.ply", *volume, "--labels", "1")
        run = self.run_program("verify", *volume, "--iso", "0.5", "one.ply")
        self.assertEqual(run.code, 6, run.err)
        self.assertIn("give the --iso or --labels, ", run.err)

    def test_text_and_flat_normals_and_sparse_input(self):
        for name, *options in (("a.ply", "--ascii"), ("b.stl", "--ascii"), ("c.glb", "--normals", "flat"),
                               ("d.ply", "--normals", "smooth"), ("e.obj", "--normals", "flat")):
            self.write(name, METABALLS, "--iso", "0.6", *options)
            self.verify(name, METABALLS, "--iso", "0.6")

    def test_options_of_surface_and_placement(self):
        for end in FORMATS:
            options = ("--iso", "0.1", "--method", "mt", "--cap", "--roi", "-0.5,-0.6,-0.7,0.5,0.6,0.7", "--unit", "mm",
                       "--to-unit", "m", "--up", "y")
            self.write(f"a.{end}", GYROID, *options)
            self.verify(f"a.{end}", GYROID, *options)
            self.verify(f"a.{end}", GYROID, *options[:-6], "--up", "y", code=6)
            self.verify(f"a.{end}", GYROID, *options[:-6])  # as the file says
            self.write(f"b.{end}", GYROID, "--iso", "0.1", "--space", "index")
            self.verify(f"b.{end}", GYROID, "--iso", "0.1", "--space", "index")

    def test_holes(self):
        self.write_raw("holes.raw", (20, 20, 20),
                       lambda x, y, z: float("nan") if x * y * z % 17 == 3 else (x * 7 + y * 5 + z * 3) % 11)
        options = (self.folder / "holes.raw", "--dims", "20,20,20", "--dtype", "f32", "--nan", "hole", "--iso", "4")
        for end in FORMATS:
            self.write(f"a.{end}", *options)
            self.verify(f"a.{end}", *options)

    def test_far_from_the_origin(self):
        """What each format keeps of coordinates far away is enough."""
        for far in ("1e5", "1e7"):
            options = (SPHERE, "--iso", "0", "--origin", f"{far},-{far},5")
            for end in FORMATS:
                if (end, far) == ("stl", "1e7"):
                    continue  # refused: far_test.py
                self.write(f"a.{end}", *options)
                self.verify(f"a.{end}", *options)

    def test_text(self):
        self.write("a.glb", SPHERE, "--iso", 0)
        text = self.convert("verify", SPHERE, "--iso", 0, "a.glb").text
        for part in ("a.glb and demo:sphere", "iso 0", "triangles", "vertices", "identical", "allowed",
                     "same          yes"):
            self.assertIn(part, text)
        run = self.run_program("verify", SPHERE, "--iso", "0.1", "a.glb")
        self.assertEqual(run.code, 6)
        self.assertIn("same          no", run.text)

    def test_where_nothing_matches_no_distance_is_told(self):
        self.write("a.glb", SPHERE, "--iso", 0)
        for iso in ("0.1", "9"):
            run = self.run_program("verify", SPHERE, "--iso", iso, "a.glb")
            self.assertEqual(run.code, 6)
            self.assertNotIn("identical", run.text)
            self.assertRegex(run.text, r"positions +no vertex has the same position in both\n")
            self.assertIsNone(self.verify("a.glb", SPHERE, "--iso", iso, code=6)[0]["distance"])

    def test_several_surfaces(self):
        isos = ("--iso", "0", "--iso", "0.2", "--iso", "-0.1")
        for end in ("glb", "gltf", "obj"):
            self.write(f"a.{end}", SPHERE, *isos)
            report, run = self.verify(f"a.{end}", SPHERE, *isos)
            self.assertEqual((report["vertices_only"], report["distance"]), ([0, 0], [0, 0, 0]))
            self.verify(f"a.{end}", SPHERE, *isos[4:], *isos[:4])
            run = self.convert("verify", SPHERE, *isos, f"a.{end}")
            self.assertIn("demo:sphere?size=24 iso 0, 0.2, -0.1\n", run.text)
            report, run = self.verify(f"a.{end}", SPHERE, *isos[:4], code=6)
            self.assertEqual(report["vertices_only"][1], 0)
            self.assertIn("hint: the mesh holds more than that surface: give every --iso", run.err)
            report, _ = self.verify(f"a.{end}", SPHERE, *isos, "--iso", "0.3", code=6)
            self.assertEqual(report["vertices_only"][0], 0)
        self.write("b.glb", SPHERE, *isos, "--iso", "9", "--empty", "skip")
        self.verify("b.glb", SPHERE, *isos, "--iso", "9")

    def test_several_surfaces_of_two_backends(self):
        run = self.run_program("verify", SPHERE, "--iso", "0", "--iso", "0.2", "--json")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual([(record["iso"], record["passed"]) for record in json.loads(run.text)], [(0, True), (0.2, True)])
        text = self.convert("verify", SPHERE, "--iso", "0", "--iso", "0.2").text
        self.assertEqual(text.count("same          yes"), 2)
        self.assertIn("passed", json.loads(self.convert("verify", SPHERE, "--iso", "0", "--json").text))

    def test_another_iso(self):
        self.write("a.glb", SPHERE, "--iso", 0)
        report, run = self.verify("a.glb", SPHERE, "--iso", "0.01", code=6)
        self.assertGreater(report["vertices_only"][0], 0)
        self.assertTrue(run.err.startswith("isoextract: error: a.glb: the mesh is not the surface of demo:sphere"), run.err)
        self.assertIn("hint: give the --iso", run.err)

    def test_the_other_method(self):
        self.write("a.ply", SPHERE, "--iso", 0, "--method", "mt")
        self.verify("a.ply", SPHERE, "--iso", 0, code=6)

    def test_damage(self):
        self.write("a.stl", SPHERE, "--iso", 0)
        data = (self.folder / "a.stl").read_bytes()
        count = len(read_stl(data).triangles)

        def check(name, damaged, triangles_only):
            (self.folder / name).write_bytes(damaged)
            report, _ = self.verify(name, SPHERE, "--iso", 0, code=6)
            if triangles_only is not None:
                self.assertEqual(report["triangles_only"], triangles_only)
                self.assertEqual(report["vertices_only"], [0, 0])
            return report

        # One triangle less, one turned over, one twice, one corner moved.
        check("less.stl", data[:80] + struct.pack("<I", count - 1) + data[84:-50], [0, 1])
        first = 84 + 12
        turned = data[:first] + data[first + 12:first + 24] + data[first:first + 12] + data[first + 24:]
        check("turned.stl", turned, [1, 1])
        check("twice.stl", data[:80] + struct.pack("<I", count + 1) + data[84:] + data[-50:], [1, 0])
        x, = struct.unpack_from("<f", data, first)
        moved = bytearray(data)
        struct.pack_into("<f", moved, first, x + 1e-4)
        self.assertEqual(check("moved.stl", bytes(moved), None)["vertices_only"][0], 1)

    def test_a_truncated_file_is_an_input_error(self):
        self.write("a.ply", SPHERE, "--iso", 0)
        (self.folder / "b.ply").write_bytes((self.folder / "a.ply").read_bytes()[:-7])
        self.assert_fails(2, self.run_program("verify", SPHERE, "--iso", 0, "b.ply"), "b.ply")

    def test_a_simplified_mesh_is_told_where_to_go(self):
        fine = "demo:sphere?size=48"
        self.write("a.glb", fine, "--iso", 0, "--simplify", "0.1")
        report, run = self.verify("a.glb", fine, "--iso", 0, code=6)
        self.assertLess(report["triangles"][0], report["triangles"][1])
        self.assertEqual(report["vertices_only"][0], 0)
        self.assertIn("the mesh looks simplified: give the --simplify or --triangles", run.err)
        self.assertIn("'isoextract compare'", run.err)

    def test_nothing_on_both_sides(self):
        self.write("a.glb", SPHERE, "--iso", "9", "--empty", "write")
        self.verify("a.glb", SPHERE, "--iso", "9")
        self.verify("a.glb", SPHERE, "--iso", "0", code=6)

    def test_same_for_any_number_of_threads(self):
        self.write("a.glb", SPHERE, "--iso", 0)
        one, run = self.verify("a.glb", SPHERE, "--iso", "0.05", "--threads", 1, code=6)
        two, other = self.verify("a.glb", SPHERE, "--iso", "0.05", "--threads", 2, code=6)
        self.assertEqual((one, run.err), (two, other.err))

    def test_usage(self):
        self.assert_fails(1, self.run_program("verify"), "INPUT is missing", "isoextract verify INPUT --iso V [MESH]")
        self.assert_fails(1, self.run_program("verify", SPHERE), "try --iso auto")
        self.assert_fails(1, self.run_program("verify", SPHERE, "--iso", "0", "a.xyz"), "a.xyz: expected a name that ends in")
        self.assert_fails(1, self.run_program("verify", SPHERE, "--iso", "0", "a.glb", "b.glb"), "'b.glb'")
        self.assert_fails(1, self.run_program("verify", SPHERE, "--iso", "0", "--iso", "0.0", "a.glb"), "--iso 0", "twice")
        self.assert_fails(1, self.run_program("verify", SPHERE, "--iso", "0", "a.glb", "--space", "index", "--scale", "2"),
                          "--space index")
        self.assert_fails(2, self.run_program("verify", SPHERE, "--iso", "0", "missing.glb"), "missing.glb")
        self.assert_fails(2, self.run_program("verify", "missing.vdb", "--iso", "0", "--json", "missing.ply"), "missing")


if __name__ == "__main__":
    main()
