"""isoextract verify with a mesh that was changed after its extraction: the same options make the same triangles."""

import json

from support import ProgramTest, main

# Several bodies with cavities, in a box that cuts some of them.
NOISE = "demo:gyroid?size=24"
ISO = ("--iso", "0.3")
FORMATS = ("glb", "gltf", "ply", "obj", "stl")

# Options of an edit, and others that give another mesh.
EDITS = {
    "smooth": (("--smooth", "6"), ("--smooth", "7"), ("--smooth", "6:sinc")),
    "simplify": (("--simplify", "0.2"), ("--simplify", "0.4"), ("--triangles", "30%")),
    "triangles": (("--triangles", "3000"), ("--triangles", "3100"), ("--simplify", "0.2")),
    "clip": (("--clip", "1,2,3,0.1"), ("--clip", "1,2,3,0.2"), ("--clip", "1,2,3,0.1", "--cap")),
    "cap": (("--clip", "0,0,1,0.1", "--cap"), ("--clip", "0,0,1,0.1"), ("--cap", )),
    "largest": (("--cap", "--largest"), ("--cap", "--largest", "2"), ("--cap", )),
    "least": (("--cap", "--drop-components", "100"), ("--cap", "--drop-components", "100000"), ("--cap", )),
    "all": (("--cap", "--largest", "3", "--smooth", "4", "--simplify", "0.1"),
            ("--cap", "--largest", "3", "--smooth", "4"), ("--cap", "--smooth", "4", "--simplify", "0.1")),
}
STAGES = {
    "smooth": ["smoothed"], "simplify": ["simplified"], "triangles": ["simplified"], "clip": ["clipped"],
    "cap": ["clipped"], "largest": ["components removed"], "least": ["components removed"],
    "all": ["components removed", "smoothed", "simplified"],
}


class VerifyEditsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        # Balls of several sizes, one with a cavity, and one with a ball in its cavity.
        balls = ((6, 6, 6, 4.3), (16, 7, 8, 5.2), (8, 17, 12, 5.7), (17, 17, 17, 4.4), (2, 20, 3, 1.3), (20, 2, 20, 1.6))

        def value(x, y, z):
            near = max(r - ((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) ** 0.5 for a, b, c, r in balls)
            hole = 2.4 - ((x - 8) ** 2 + (y - 17) ** 2 + (z - 12) ** 2) ** 0.5
            return min(near, -hole)

        self.write_raw("balls.raw", (24, 24, 24), value)
        self.balls = ("balls.raw", "--dims", "24,24,24", "--dtype", "f32", "--iso", "0.1")

    def verify(self, code, *arguments):
        run = self.run_program("verify", *arguments, "--json")
        self.assertEqual(run.code, code, run.err)
        report = json.loads(run.text)
        self.assertEqual(report["passed"], code == 0)
        return report, run

    def test_the_same_options_make_the_same_triangles(self):
        for name, (options, *others) in EDITS.items():
            source = self.balls if name in ("largest", "least", "all") else (NOISE, *ISO)
            for end in FORMATS if name in ("smooth", "all", "cap") else ("glb", "stl"):
                mesh = f"{name}.{end}"
                self.convert(*source, *options, "-o", mesh)
                report, _ = self.verify(0, *source, *options, mesh)
                self.assertEqual(report["stages"], ["extracted", *STAGES[name]])
                self.assertEqual(report["backend"], "cpu")
                self.assertEqual((report["distance"], report["vertices_only"]), ([0, 0, 0], [0, 0]))
            for other in others:
                with self.subTest(written=options, verified=other):
                    self.verify(6, *source, *other, f"{name}.glb")

    def test_repair_is_not_offered(self):
        """It works on mesh files, and verify extracts the surface of a field."""
        run = self.run_program("verify", NOISE, *ISO, "--repair", "a.glb")
        self.assert_fails(1, run, "unknown option '--repair' for 'verify'")
        self.assertNotIn("--repair", self.convert("verify", "--help-all").text)
        self.assertIn("--repair", self.convert("--help-all").text)

    def test_without_them_the_hint_names_them(self):
        for name, hint in (("smooth", "--smooth"), ("simplify", "--simplify or --triangles"),
                           ("triangles", "--simplify or --triangles"), ("clip", "--clip")):
            self.convert(NOISE, *ISO, *EDITS[name][0], "-o", "a.glb")
            _, run = self.verify(6, NOISE, *ISO, "a.glb")
            self.assertIn(hint, run.err[run.err.index("  hint: "):])
        self.convert(*self.balls, "--largest", "-o", "a.glb")
        _, run = self.verify(6, *self.balls, "a.glb")
        self.assertIn("hint: the mesh is a part of that surface: give the --largest", run.err)
        self.convert(*self.balls, "-o", "a.glb")
        _, run = self.verify(6, *self.balls, "--largest", "2", "a.glb")
        self.assertIn("leave out all other options", run.err)
        _, run = self.verify(6, *self.balls, "--simplify", "0.1", "a.glb")
        self.assertIn("--backend gpu", run.err)

    def test_threads_change_nothing(self):
        options = EDITS["all"][0]
        self.convert(*self.balls, *options, "--threads", "1", "-o", "a.glb")
        self.verify(0, *self.balls, *options, "--threads", "2", "a.glb")

    def test_pieces_in_one_file(self):
        self.convert(*self.balls, "--split-components", "--smooth", "3", "-o", "a.glb")
        self.verify(0, *self.balls, "--split-components", "--smooth", "3", "a.glb")
        # It is the same surface, in however many meshes.
        self.verify(0, *self.balls, "--smooth", "3", "a.glb")

    def test_voxels_and_relaxing(self):
        for options, other in ((("--method", "voxels", "--no-merge"), ("--method", "voxels")),
                               (("--method", "voxels", "--t-junctions"), ("--method", "voxels")),
                               (("--method", "surface-nets", "--relax", "3"), ("--method", "surface-nets"))):
            self.convert(NOISE, *ISO, *options, "-o", "a.ply")
            self.verify(0, NOISE, *ISO, *options, "a.ply")
            self.verify(6, NOISE, *ISO, *other, "a.ply")

    def test_labels(self):
        self.write_raw("map.raw", (20, 20, 20), lambda x, y, z: 0 if (x - 9) ** 2 + (y - 9) ** 2 + (z - 9) ** 2 > 70
                       else 1 + (x > 9) + 2 * (z > 11), "B")
        volume = ("map.raw", "--dims", "20,20,20")
        for more in ((), ("--clip", "0,0.2,1,9.1", "--cap"), ("--smooth", "3"), ("--method", "voxels")):
            self.convert(*volume, "--labels", "all", *more, "-o", "a.glb")
            _, run = self.verify(0, *volume, "--labels", "all", *more, "a.glb")
            _, run = self.verify(6, *volume, "--labels", "1,2,4", *more, "a.glb")
            self.assertIn("map.raw label 1, 2, 4: ", run.err)
        self.convert(*volume, "--labels", "1,3", "-o", "a_{iso}.stl")
        self.verify(0, *volume, "--labels", "3", "a_3.stl")
        self.verify(6, *volume, "--labels", "1", "a_3.stl")

    def test_nothing_is_written(self):
        """Not even tried: the folder of the mesh may be closed to this user."""
        self.convert(NOISE, *ISO, "--smooth", "2", "-o", "a.glb")
        before = self.folder.stat().st_mtime_ns
        self.verify(0, NOISE, *ISO, "--smooth", "2", "a.glb")
        self.assertEqual(self.folder.stat().st_mtime_ns, before)

    def test_an_empty_mesh(self):
        options = (NOISE, *ISO, "--drop-components", "1000000", "--smooth", "2")
        self.convert(*options, "--empty", "write", "-o", "a.glb")
        self.verify(0, *options, "a.glb")
        self.verify(6, *options[:3], "a.glb")

    def test_several_surfaces_and_values_that_are_found(self):
        isos = ("--iso", "0.1", "--iso", "p80", "--simplify", "0.1", "--smooth", "2")
        self.convert(NOISE, *isos, "-o", "a.glb")
        self.verify(0, NOISE, *isos, "a.glb")
        run = self.convert("verify", NOISE, *isos, "a.glb")
        self.assertRegex(run.text, r"a\.glb and demo:gyroid\?size=24 iso 0\.1, p80 \([0-9.]+\)\n")
        self.assertIn("new surface   by cpu: extracted, smoothed, simplified", run.text)

    def test_files_of_another_kind_are_told_where_to_go(self):
        self.convert(NOISE, *ISO, "-o", "a.glb")
        self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: x)
        (self.folder / "a.nii.gz").write_bytes(b"no volume, but its name is that of one")
        for command in (("check", ), ("compare", "a.glb")):
            run = self.run_program(*command, "a.nii.gz")
            self.assert_fails(2, run, "expected a mesh", "hint: the file name is that of a volume", "isoextract info a.nii.gz")
            self.assertNotIn("hint", self.run_program(*command, "missing.nii.gz").err)
        for command in (("info", "a.glb"), ("verify", "a.glb", *ISO, "a.glb")):
            self.assert_fails(2, self.run_program(*command), "hint: the file is a mesh", "isoextract check a.glb")
        self.assertNotIn("hint", self.run_program("info", "missing.glb").err)
        self.assert_fails(1, self.run_program("verify", "a.glb", *ISO, "a.raw"), "give the volume first")
        self.assert_fails(1, self.run_program("verify", NOISE, *ISO, "--normals", "flat", "a.glb"),
                          "unknown option '--normals' for 'verify'", "leave --normals out")
        self.assert_fails(1, self.run_program("check", "a.glb", "--iso", "0"), "--iso is an option of convert")
        self.assert_fails(1, self.run_program("check", "a.glb", "--report", "a.glb"), "another name with --report")

    def test_what_is_refused(self):
        for option in (("--smooth", "2"), ("--simplify", "0.1"), ("--triangles", "9"), ("--largest", ),
                       ("--drop-components", "9"), ("--fill-cavities", ), ("--split-components", ),
                       ("--clip", "0,0,1,0")):
            run = self.run_program("verify", NOISE, *ISO, *option)
            self.assert_fails(1, run, f"{option[0]} edits an extracted surface", "give the mesh")
        self.assert_fails(1, self.run_program("verify", NOISE, "--labels", "all"), "--labels needs MESH")
        self.assert_fails(1, self.run_program("verify", NOISE, *ISO, "--backend", "cpu"), "--backend needs MESH")
        self.assert_fails(1, self.run_program("verify", NOISE, *ISO, "--split-components", "a_1.ply"),
                          "verify cannot tell which body this ply file holds", "into one glb")
        for word in ("{iso}", "{piece}"):
            self.assert_fails(1, self.run_program("verify", NOISE, *ISO, "--split-components", f"a_{word}.glb"),
                              f"{word} stands for several files")
        self.convert(NOISE, *ISO, "-o", "a.glb")
        self.assert_fails(1, self.run_program("verify", NOISE, *ISO, "--no-merge", "a.glb"), "--no-merge does not work with")


if __name__ == "__main__":
    main()
