"""--method voxels: files of boxes, labels, what is refused and in which words."""

import json
import subprocess

from support import NO_GPU, SOURCE, SPHERE, ProgramTest, main, needs_program, read_glb, read_ply, read_stl

VOXELS = ("--method", "voxels")


class VoxelsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        # Two labels that touch, one far from both; 90 voxels of 1, 24 of 5 and 1 of 200.
        def label(x, y, z):
            if x < 10 and y < 3 and z < 3:
                return 1
            if x < 10 and 3 <= y < 6 and z == 0 and x >= 2:
                return 5
            return 200 if (x, y, z) == (69, 8, 8) else 0

        self.write_raw("labels.raw", (70, 9, 9), label, "B")
        self.labels = ("labels.raw", "--dims", "70,9,9", *VOXELS)

    def ply(self, *arguments):
        self.convert(*arguments, "-o", "out.ply")
        return read_ply((self.folder / "out.ply").read_bytes())

    def test_volume_is_that_of_the_voxels(self):
        mesh = self.ply(*self.labels, "--iso", "0")
        self.assertEqual(mesh.open_edges(), 0)
        self.assertAlmostEqual(mesh.volume(), 115)
        self.assertEqual(mesh.bounds(), ([-0.5, -0.5, -0.5], [69.5, 8.5, 8.5]))

    def test_smoothing_keeps_the_size(self):
        run = self.convert("demo:sphere?size=24", "--iso", "0", *VOXELS, "--smooth", "10", "-o", "a.ply")
        self.assertIn("the extraction merges no faces", run.err)
        self.convert("demo:sphere?size=24", "--iso", "0", *VOXELS, "-o", "b.ply")
        smooth, whole = (read_ply((self.folder / name).read_bytes()).volume() for name in ("a.ply", "b.ply"))
        self.assertAlmostEqual(smooth, whole, delta=0.03 * whole)
        self.convert("verify", "demo:sphere?size=24", "--iso", "0", *VOXELS, "--smooth", "10", "a.ply")
        run = self.run_program("demo:sphere?size=24", "--iso", "0", *VOXELS, "--smooth", "1", "--t-junctions", "-o", "a.ply")
        self.assert_fails(1, run, "--smooth does not work with --t-junctions")

    def test_spacing_origin_and_turns_place_boxes(self):
        mesh = self.ply(*self.labels, "--iso", "0", "--spacing", "0.5,2,3", "--origin", "10,20,30")
        self.assertAlmostEqual(mesh.volume(), 3 * 115)
        self.assertEqual(mesh.bounds()[0], [9.75, 19, 28.5])

    def test_merged_plain_and_fewest(self):
        merged = self.ply(*self.labels, "--iso", "0")
        plain = self.ply(*self.labels, "--iso", "0", "--no-merge")
        run = self.convert(*self.labels, "--iso", "0", "--t-junctions", "-o", "fewest.ply", "--report", "r.json")
        fewest = read_ply((self.folder / "fewest.ply").read_bytes())
        self.assertEqual(plain.open_edges(), 0)
        self.assertLess(len(fewest.triangles), len(merged.triangles))
        self.assertLess(len(merged.triangles), len(plain.triangles) / 3)
        for mesh in (plain, fewest):
            self.assertAlmostEqual(mesh.volume(), 115)
        self.assertIn("closed, except for T-junctions along edges (--t-junctions)", run.err)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["options"]["voxel_faces"], "rectangles")
        self.assertFalse(report["meshes"][0]["closed"])
        self.assertIn("border_vertices", [fact["what"] for fact in report["extractions"][0]["work"]])

    def test_the_surface_is_closed_at_the_data_boundary(self):
        run = self.convert("demo:gyroid?size=20", "--iso", "0", *VOXELS, "-o", "g.stl")
        self.assertIn("; closed;", run.err)
        self.assertGreater(read_stl((self.folder / "g.stl").read_bytes()).volume(), 0)
        self.assertEqual(self.ply("demo:gyroid?size=20", "--iso", "0", *VOXELS).open_edges(), 0)
        run = self.convert("demo:gyroid?size=20", "--iso", "0", *VOXELS, "--cap", "-o", "h.stl")
        self.assertIn("--cap changes nothing: the surface of voxels is closed everywhere", run.err)
        self.assertEqual((self.folder / "g.stl").read_bytes(), (self.folder / "h.stl").read_bytes())

    def test_labels_are_a_mesh_each(self):
        run = self.convert(*self.labels, "--labels", "all", "-o", "all.glb", "--report", "r.json")
        self.assertIn("label 1, 5, 200 -> all.glb", run.err)
        meshes = read_glb((self.folder / "all.glb").read_bytes())
        self.assertEqual({name: round(mesh.volume()) for name, mesh in meshes.items()},
                         {"labels label 1": 90, "labels label 5": 24, "labels label 200": 1})
        for mesh in meshes.values():
            self.assertEqual(mesh.open_edges(), 0)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["options"]["outputs"][0]["iso"], ["all labels"])
        self.assertEqual([(one["iso"], one["asked"]) for one in report["extractions"]],
                         [(1, "label 1"), (5, "label 5"), (200, "label 200")])
        self.assertTrue(all(mesh["closed"] for mesh in report["meshes"]))
        self.convert(*self.labels, "--labels", "200,1", "-o", "two.glb")
        self.assertEqual(list(read_glb((self.folder / "two.glb").read_bytes())), ["labels label 200", "labels label 1"])

    def test_labels_into_files_of_their_own(self):
        self.convert(*self.labels, "--labels", "5,200", "-o", "part_{iso}.stl")
        volumes = [round(read_stl((self.folder / f"part_{label}.stl").read_bytes()).volume()) for label in (5, 200)]
        self.assertEqual(volumes, [24, 1])

    def test_a_label_is_the_surface_of_its_value_alone(self):
        self.write_raw("one.raw", (70, 9, 9), lambda x, y, z: int(x < 10 and y < 3 and z < 3), "B")
        alone = self.ply("one.raw", "--dims", "70,9,9", *VOXELS, "--iso", "0")
        label = self.ply(*self.labels, "--labels", "1")
        self.assertEqual((label.vertices, label.triangles), (alone.vertices, alone.triangles))

    def test_labels_in_a_sequence_and_again(self):
        for frame in (1, 2):
            self.write_raw(f"in_{frame}.raw", (9, 9, 9), lambda x, y, z, f=frame: f if x < 4 else 0, "B")
        command = ("in_{}.raw", "--dims", "9,9,9", *VOXELS, "--labels", "all", "-o", "out_{}.glb", "--resume")
        self.convert(*command)
        self.assertEqual(list(read_glb((self.folder / "out_2.glb").read_bytes())), ["in_2 label 2"])
        self.assertIn("2", self.convert(*command).err)
        self.assertEqual(self.run_program(*command, "--dry-run").code, 0)

    def test_labels_that_are_not_there(self):
        self.assert_fails(2, self.run_program(*self.labels, "--labels", "1,7", "-o", "a.glb"), "no sample has label 7",
                          "--empty")
        run = self.convert(*self.labels, "--labels", "1,7", "-o", "a.glb", "--empty", "skip")
        self.assertIn("no surface at label 7", run.err)
        self.assertEqual(list(read_glb((self.folder / "a.glb").read_bytes())), ["labels label 1"])
        self.write_raw("zeros.raw", (4, 4, 4), lambda x, y, z: 0, "B")
        self.assert_fails(2, self.run_program("zeros.raw", "--dims", "4,4,4", *VOXELS, "--labels", "all", "-o", "a.glb"),
                          "no sample has a label other than 0")

    def test_colors_by_label(self):
        self.convert(*self.labels, "--labels", "all", "--color-by", "iso", "-o", "all.glb")
        model = (self.folder / "all.glb").read_bytes()
        self.assertEqual(json.loads(model[20:20 + int.from_bytes(model[12:16], "little")])["materials"].__len__(), 3)

    def refused(self, *arguments, code=1):
        run = self.run_program(*arguments, "-o", "x.glb")
        self.assert_fails(code, run)
        self.assertNotIn("x.glb", self.files())
        return run.err

    def test_what_is_refused(self):
        self.assertIn("--labels does not work with marching cubes", self.refused("labels.raw", "--labels", "all", "--method", "mc"))
        self.assertIn("--labels and --iso exclude each other", self.refused(*self.labels, "--labels", "1", "--iso", "0"))
        self.assertIn("expected all, or numbers, ranges and names", self.refused(*self.labels, "--labels", "1,,5"))
        self.assertIn("each label once", self.refused(*self.labels, "--labels", "1,1"))
        self.assertIn("whole numbers from -16777216 to 16777216 (sample type f32), found ",
                      self.refused(SPHERE, *VOXELS, "--labels", "all", code=2))
        self.assertIn("--normals smooth: voxels", self.refused(*self.labels, "--iso", "0", "--normals", "smooth"))
        self.assertIn("--nan hole: voxels", self.refused(*self.labels, "--iso", "0", "--nan", "hole"))
        self.assertIn("exclude each other", self.refused(*self.labels, "--iso", "0", "--no-merge", "--t-junctions"))
        for option in ("--no-merge", "--t-junctions"):
            self.assertIn(f"{option} does not work with marching cubes", self.refused(SPHERE, "--iso", "0", option))
        run = self.run_program(*self.labels, "--labels", "all", "-o", "x.stl")
        self.assert_fails(1, run, "one stl file holds one surface, but all labels can give several",
                          "put {label} or {name} into the name to get a file for each, or write all into a glb")
        self.assertIn("one stl file holds one surface, found 2 labels", self.run_program(*self.labels, "--labels", "1,5", "-o", "x.stl").err)

    def test_the_gpu_does_not_have_it(self):
        for which in (("--iso", "0"), ("--labels", "1")):
            run = self.run_program(*self.labels, *which, "--backend", "gpu", "-o", "x.ply")
            self.assertEqual(run.code, 3, run.err)
            run = self.convert(*self.labels, *which, "--backend", "auto", "-o", "y.ply", env=NO_GPU)
            self.assertTrue((self.folder / "y.ply").exists())

    def test_the_error_is_measured(self):
        run = self.convert("demo:sphere?size=24", "--method", "voxels", "--iso", "0", "--error", "-o", "x.ply")
        self.assertRegex(run.err, r"against the trilinear interpolant: rms 0\.[1-4]\d*, ")
        self.assertRegex(run.err, r"from the surface of the data to the mesh: rms 0\.[1-4]\d*, ")

    def test_threads_change_no_byte(self):
        files = set()
        for threads in (1, 2, 5):
            self.convert("demo:gyroid?size=70", "--iso", "0", *VOXELS, "--threads", threads, "-o", "t.ply")
            files.add((self.folder / "t.ply").read_bytes())
        self.assertEqual(len(files), 1)

    @needs_program("node")
    def test_the_validator_of_gltf_finds_nothing(self):
        self.convert(*self.labels, "--labels", "all", "-o", "w.glb")
        run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", self.folder / "w.glb"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    main()
