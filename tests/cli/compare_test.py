"""isoextract compare: facts of two meshes, distances, exit code 6."""

import json
import math

from support import SPHERE, ProgramTest, main


class CompareTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.convert(SPHERE, "--iso", 0, "-o", "sphere.glb")

    def json(self, *arguments):
        run = self.convert("compare", "--json", *arguments)
        self.assertEqual(run.err, "")
        return json.loads(run.text)

    def test_a_mesh_and_itself_in_every_format(self):
        for name in ("sphere.ply", "sphere.obj", "sphere.stl", "sphere.gltf"):
            self.convert(SPHERE, "--iso", 0, "-o", name)
            report = self.json("sphere.glb", name, "--max-distance", 0)
            for side in (report["a"], report["b"]):
                self.assertTrue(side["closed"], name)
                self.assertEqual((side["components"], side["genus"]), (1, 0))
            self.assertEqual(report["a"]["vertices"], report["b"]["vertices"])
            self.assertAlmostEqual(report["a"]["volume"], report["b"]["volume"])
            self.assertEqual(report["hausdorff"], [0, 0])
            self.assertEqual((report["rms"], report["percentile99"]), (0, 0))

    def test_gltf_is_turned_back_where_the_other_mesh_is_none(self):
        """A torus lies on its side where the axes are mixed up: the example of the help."""
        torus = ("demo:torus?size=24", "--iso", 0)
        for name in ("a.glb", "a.gltf", "b.ply", "b.obj", "b.stl"):
            self.convert(*torus, "-o", name)
        for name in ("a.glb", "a.gltf"):
            for other in ("b.ply", "b.obj", "b.stl"):
                report = self.json(name, other, "--max-distance", 0)
                self.assertEqual(report["hausdorff"], [0, 0])
                self.assertEqual([report[side]["undone"] for side in "ab"], ["turned from z up to y up", None])
                self.assertEqual(report["a"]["bounds"], report["b"]["bounds"])
        text = self.convert("compare", "b.ply", "a.glb").text
        self.assertEqual(text.count("undone        turned from z up to y up"), 1)
        self.assertLess(text.index("a.glb\n"), text.index("undone"))
        for same in (("a.glb", "a.gltf"), ("b.ply", "b.stl")):
            self.assertEqual([self.json(*same)[side]["undone"] for side in "ab"], [None, None])
            self.assertIn("note[no-effect]: --up changes nothing: ", self.run_program("compare", *same, "--up", "y").err)

    def without_placement(self, name):
        """As other programs write such files."""
        path = self.folder / name
        lines = path.read_text().splitlines(keepends=True)
        path.write_text("".join(line for line in lines if not line.startswith("# placement")))

    def test_up_says_what_points_up_in_the_other_mesh(self):
        self.convert("demo:torus?size=24", "--iso", 0, "-o", "a.glb")
        self.convert("demo:torus?size=24", "--iso", 0, "--up-out", "y", "-o", "b.obj")
        self.assertEqual(self.json("a.glb", "b.obj", "--max-distance", 0)["hausdorff"], [0, 0])
        self.without_placement("b.obj")
        run = self.run_program("compare", "a.glb", "b.obj", "--max-distance", "0.1")
        self.assertEqual(run.code, 6)
        self.assertIn("hint: compare turned a.glb from y up to z up; --up y compares it", run.err)
        report = self.json("a.glb", "b.obj", "--max-distance", 0, "--up", "y")
        self.assertEqual([report[side]["undone"] for side in "ab"], [None, None])
        self.assert_fails(1, self.run_program("compare", "a.glb", "b.obj", "--up", "x"), "expected one of y, z")

    def write_particles(self):
        """A column of particles with velocities, so that axes and components are told apart."""
        rows = [f"0.1,0.2,{0.25 * i},1,{i},3" for i in range(8)]
        (self.folder / "in.csv").write_text("\n".join(["x,y,z,v:0,v:1,v:2", *rows]) + "\n")

    def by_another_program(self, name):
        """Takes away what a glTF or OBJ file says of who wrote it, and how it is placed."""
        path = self.folder / name
        if name.endswith(".obj"):
            lines = path.read_text().splitlines(keepends=True)
            path.write_text("".join(line for line in lines if not line.startswith("#")))
            return
        model = json.loads(path.read_text())
        model["asset"] = {"version": "2.0"}
        path.write_text(json.dumps(model))

    def test_up_that_is_given_holds_against_what_a_file_says(self):
        """A vector attribute gives a mesh a record of its placement, with an axis that no option requested."""
        self.write_particles()
        surface = ("in.csv", "--radius", "0.3")
        self.convert(*surface, "-o", "plain.ply")
        self.convert(*surface, "--attribute", "v", "-o", "record.ply")
        self.convert(*surface, "--up", "y", "-o", "other.gltf")  # the same coordinates
        self.by_another_program("other.gltf")
        for ours in ("record.ply", "plain.ply"):
            report = self.json(ours, "other.gltf", "--up", "y", "--max-distance", 0)
            self.assertEqual([report[side]["undone"] for side in "ab"], [None, None], ours)
            for up in ((), ("--up", "z")):
                run = self.run_program("compare", ours, "other.gltf", *up, "--max-distance", "0.1")
                self.assertEqual(run.code, 6, ours)
                self.assertIn("turned from z up to y up", run.text)
                self.assertEqual("--up y compares it without this turn" in run.err, not up, ours)

    def test_up_of_a_mesh_of_another_program(self):
        """glTF of ours that says how it was turned, and a mesh of another program that lies as --up says."""
        self.write_particles()
        for world in ((), ("--up", "y")):
            self.convert("in.csv", "--radius", "0.3", "--attribute", "v", *world, "-o", "record.gltf")
            self.convert("in.csv", "--radius", "0.3", *world, "--up-out", "y", "-o", "y.obj")
            self.convert("in.csv", "--radius", "0.3", *world, "--up-out", "z", "-o", "z.obj")
            for up in "yz":
                self.by_another_program(f"{up}.obj")
                report = self.json("record.gltf", f"{up}.obj", "--up", up, "--max-distance", 0)
                self.assertEqual([report[side]["undone"] for side in "ab"] == [None, None], up == "y", (world, up))

    def test_up_against_a_mesh_that_was_turned_is_refused(self):
        self.convert("demo:torus?size=24", "--iso", 0, "--up-out", "y", "-o", "turned.ply")
        self.convert("demo:torus?size=24", "--iso", 0, "-o", "other.gltf")
        self.by_another_program("other.gltf")
        self.json("turned.ply", "other.gltf", "--up", "y", "--max-distance", 0)
        run = self.run_program("compare", "turned.ply", "other.gltf", "--up", "z")
        self.assert_fails(
            1, run, "turned.ply: --up z contradicts the placement that the file records (turned from z up to y up)", "leave --up out")

    def test_note_that_up_changes_nothing_appears_only_then(self):
        """Of two glTF files, only the one without a placement record depends on --up."""
        torus = ("demo:torus?size=24", "--iso", 0)
        self.convert(*torus, "-o", "default.glb")
        self.convert(*torus, "--up", "y", "-o", "record.glb")
        self.assertEqual(self.json("default.glb", "record.glb")["hausdorff"], [0, 0])
        for pair in (("default.glb", "record.glb"), ("record.glb", "default.glb")):
            report = self.json(*pair, "--up", "y")  # without a note
            self.assertGreater(report["hausdorff"][0], 0.5)
            self.assertEqual(self.json(*pair, "--up", "z")["hausdorff"], [0, 0])
        for pair in (("default.glb", "default.glb"), ("record.glb", "record.glb")):
            for up in "yz":
                err = self.convert("compare", *pair, "--up", up).err
                self.assertIn("note[no-effect]: --up changes nothing: both meshes are glTF with y up", err)

    def test_a_mesh_and_itself_far_away(self):
        for name in ("far.glb", "far.ply", "far.obj"):
            self.convert(SPHERE, "--iso", 0, "--origin", "1e7,-3e6,0.1", "-o", name)
            self.assertEqual(self.json(name, name, "--max-distance", 0)["hausdorff"], [0, 0])

    def test_polygons_of_very_many_corners(self):
        """What takes quadratic time with them takes minutes."""
        corners = 64000
        for name, radius in (("a.obj", 1), ("b.obj", 1.01)):
            rows = [f"v {radius * math.cos(a):.7g} {radius * math.sin(a):.7g} {radius - 1:.7g}"
                    for a in (2 * math.pi * i / corners for i in range(corners))]
            face = " ".join(str(i + 1) for i in range(corners))
            (self.folder / name).write_text("\n".join(rows) + f"\nf {face}\n")
        report = self.json("a.obj", "b.obj")
        self.assertEqual(report["a"]["triangles"], corners - 2)
        self.assertAlmostEqual(report["hausdorff"][0], 0.01 * math.sqrt(2), delta=2e-4)
        self.assertEqual(self.json("a.obj", "a.obj")["hausdorff"], [0, 0])

    def test_moved_apart(self):
        self.convert(SPHERE, "--iso", 0, "--origin", "-0.75,-1,-1", "-o", "moved.ply")
        report = self.json("sphere.glb", "moved.ply")
        lower, upper = report["hausdorff"]
        self.assertLessEqual(lower, 0.25 + 1e-6)
        self.assertGreaterEqual(upper, 0.24)
        self.assertLess(report["rms"], lower)
        self.assertLess(report["mean"], report["rms"])
        self.assertLessEqual(report["percentile99"], upper)
        text = self.convert("compare", "sphere.glb", "moved.ply").text
        for part in ("sphere.glb\n", "moved.ply\n", "PLY, binary", "yes; genus 0", "first to second", "Hausdorff", "farthest at",
                     "volume", "bounds"):
            self.assertIn(part, text)

    def test_open_meshes(self):
        self.convert("demo:gyroid?size=24", "--iso", 0, "-o", "open.obj")
        report = self.json("open.obj", "open.obj")
        self.assertFalse(report["a"]["closed"])
        self.assertIsNone(report["a"]["genus"])
        self.assertGreater(report["a"]["open_edges"], 0)
        self.assertIn(" open edges", self.convert("compare", "open.obj", "open.obj").text)

    def test_max_distance(self):
        self.convert(SPHERE, "--iso", 0, "--origin", "-0.75,-1,-1", "-o", "moved.ply")
        self.convert("compare", "sphere.glb", "moved.ply", "--max-distance", "0.3")
        run = self.run_program("compare", "sphere.glb", "moved.ply", "--max-distance", "0.1")
        self.assertEqual(run.code, 6)
        self.assertIn("Hausdorff", run.text)
        self.assertTrue(run.err.startswith("isoextract: error: sphere.glb and moved.ply: the Hausdorff distance is "
                                           "at least 0.2"), run.err)

    def test_usage(self):
        self.assert_fails(1, self.run_program("compare", "sphere.glb"), "two meshes, found 1: sphere.glb")
        self.assert_fails(1, self.run_program("compare"), "two meshes, found 0")
        self.assert_fails(1, self.run_program("compare", "a", "b", "c"), "found 3")
        self.assert_fails(1, self.run_program("compare", "a", "b", "--max-distance", "-1"), "0 or above")

    def test_bad_meshes(self):
        self.assert_fails(2, self.run_program("compare", "sphere.glb", "missing.ply"), "missing.ply")
        (self.folder / "bad.ply").write_text("ply\nformat ascii 1.0\n")
        self.assert_fails(2, self.run_program("compare", "bad.ply", "sphere.glb"), "bad.ply: expected 'end_header'")
        self.convert(SPHERE, "--iso", 9, "--empty", "write", "-o", "empty.ply")
        self.assert_fails(2, self.run_program("compare", "sphere.glb", "empty.ply"), "empty.ply, has no triangles",
                          "isoextract info", "the iso value")
        self.convert(SPHERE, "--iso", 9, "--empty", "write", "-o", "empty.obj")
        self.assert_fails(2, self.run_program("compare", "sphere.glb", "empty.obj"), "empty.obj, has no triangles")
        self.assert_fails(2, self.run_program("compare", "sphere.glb", "sphere.glb", "--memory-limit", "1K"),
                          "--memory-limit")

    def test_what_was_left_out_is_said_before_the_distance_fails(self):
        (self.folder / "lines.obj").write_text("v 0 0 0\nv 1 0 0\nl 1 2\n")
        run = self.run_program("compare", "lines.obj", "sphere.glb")
        self.assertEqual((run.code, run.text), (2, ""))
        # No hint: an iso value is nothing to a mesh that another program wrote.
        note, error = run.err.splitlines()
        self.assertIn("note[data-left-out]: lines.obj: the reader skips 1 lines and points", note)
        self.assertIn("the first mesh, lines.obj, has no triangles", error)

    def test_far_places_are_no_small_distance(self):
        (self.folder / "far.obj").write_text("v 1e200 0 0\nv 1e200 1 0\nv 1e200 0 1\nf 1 2 3\n")
        run = self.run_program("compare", "sphere.glb", "far.obj", "--max-distance", "0.1")
        self.assert_fails(2, run, "1e+150 apart")

    def test_same_figures_for_any_number_of_threads(self):
        self.convert("demo:sphere?size=40", "--iso", 0, "-o", "fine.ply")
        one = self.convert("compare", "sphere.glb", "fine.ply", "--json", "--threads", 1).out
        self.assertEqual(one, self.convert("compare", "sphere.glb", "fine.ply", "--json", "--threads", 3).out)


if __name__ == "__main__":
    main()
