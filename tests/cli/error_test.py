"""--error: how far the mesh is from the isosurface it stands for."""

import json
import math
import re

from support import SPHERE, ProgramTest, main


class ErrorTest(ProgramTest):
    def rms_and_max(self, err):
        """In voxels, of the summary line."""
        found = re.search(r"interpolant: rms (\S+), 99 % \S+, max (\S+) voxels", err)
        self.assertTrue(found, err)
        return float(found.group(1)), float(found.group(2))

    def test_it_is_told_with_and_without_a_value(self):
        linear = self.convert("--error", "demo:torus?size=40", "--iso", "0", "-o", "a.ply")
        self.assertIn("error at iso 0 against the trilinear interpolant", linear.err)
        rms, worst = self.rms_and_max(linear.err)
        self.assertTrue(0 < rms < worst < 0.2, linear.err)
        for arguments in (("--error", "tricubic"), ("--error=tricubic",)):
            cubic = self.convert("demo:torus?size=40", "--iso", "0", "-o", "a.ply", *arguments)
            self.assertIn("against the tricubic interpolant", cubic.err)
        self.assertIn("trilinear", self.convert(SPHERE, "--iso", "0", "-o", "a.ply", "--error").err)

    def test_nothing_is_measured_unless_asked_for(self):
        run = self.convert(SPHERE, "--iso", "0", "-o", "a.ply", "--explain")
        self.assertNotIn("interpolant", run.err)
        self.assertIn("left out: the error of the mesh; --error measures it", run.err)

    def test_the_mesh_is_the_same(self):
        self.convert(SPHERE, "--iso", "0", "-o", "a.ply")
        self.convert(SPHERE, "--iso", "0", "-o", "b.ply", "--error")
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())

    def test_it_is_in_the_units_of_the_mesh(self):
        world = r"mesh's units rms (\S+), 99 % \S+, max (\S+) at \((\S+), (\S+), (\S+)\)"
        runs = [self.convert("demo:sphere?size=21", "--iso", "0", "--error", "--scale", scale, "-o", "a.glb").err
                for scale in ("1", "1000")]
        small, large = ([float(x) for x in re.search(world, err).groups()] for err in runs)
        self.assertEqual(self.rms_and_max(runs[0]), self.rms_and_max(runs[1]))
        self.assertAlmostEqual(large[0] / small[0], 1000, delta=20)
        self.assertAlmostEqual(math.hypot(*large[2:]), 700, delta=50)
        rms, _ = self.rms_and_max(runs[0])
        self.assertAlmostEqual(small[0] / rms, 0.1, delta=0.002)

    def test_demo_fields_are_measured_against_their_formula(self):
        run = self.convert("demo:torus?size=64", "--iso", "0", "-o", "a.glb", "--error")
        line = re.search(r"against the formula: rms (\S+), .*normals rms (\S+) degrees smooth, (\S+) degrees flat; "
                         r"area ([-+]\S+) %, volume ([-+]\S+) %", run.err)
        self.assertTrue(line, run.err)
        rms, smooth, flat, area, volume = (float(text) for text in line.groups())
        self.assertTrue(0 < rms < 0.05 and smooth < flat / 5 and abs(area) < 1 and -1 < volume < 0, run.err)
        run = self.convert("demo:gyroid?size=32", "--iso", "0", "-o", "a.ply", "--error")
        self.assertRegex(run.err, r"against the formula: .* degrees flat\n")
        self.assertNotIn("formula", self.convert("demo:random?size=9", "--iso", "0", "-o", "a.ply", "--error").err)

    def test_a_part_is_not_compared_with_the_size_of_the_whole(self):
        for part in (("--clip", "1,0,0,0"), ("--clip", "1,0,0,0", "--cap"), ("--roi", "0,0,0,16,31,31", "--cap")):
            run = self.convert("demo:sphere?size=32", "--iso", "0.5", *part, "-o", "a.ply", "--error", "--report", "r.json")
            self.assertRegex(run.err, r"against the formula: .*; area and volume not compared: the mesh covers a part of the surface")
            (mesh,) = json.loads((self.folder / "r.json").read_text())["meshes"]
            self.assertEqual([mesh["error"]["analytic"][size] for size in ("area", "volume")], [None, None])
            self.assertGreater(mesh["error"]["analytic"]["interior"]["points"], 0)

    def test_each_iso_value_has_its_own(self):
        run = self.convert(SPHERE, "--iso", "0", "--iso", "0.2", "-o", "a.glb", "--error")
        self.assertIn("error at iso 0 against", run.err)
        self.assertIn("error at iso 0.2 against", run.err)

    def test_explain_adds_vertices_and_storage(self):
        run = self.convert(SPHERE, "--iso", "0", "-o", "a.ply", "--error", "--explain", "--method", "mt")
        for part in ("at the ", "storage error (float32", "error measured in"):
            self.assertIn(part, run.err)

    def test_what_cannot_be_measured_is_counted(self):
        self.write_raw("nan.raw", (6, 6, 6), lambda x, y, z: math.nan if (x, y, z) == (3, 3, 3) else x - 2.5)
        run = self.convert("nan.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "0", "--nan", "outside", "--error",
                           "-o", "a.ply")
        self.assertRegex(run.err, r"not measured: \d+ of \d+ points: \d+ beside samples that are not finite")

    def test_the_way_back_is_not_that_of_vertices(self):
        run = self.convert("demo:random?size=12", "--iso", "0", "--error", "-o", "a.ply", "--explain")
        back = re.search(r"from the surface of the data to the mesh: rms (\S+), 99 % \S+, max (\S+) voxels, everywhere at most "
                         r"about (\S+); ", run.err)
        self.assertTrue(back, run.err)
        rms, most, at_most = map(float, back.groups())
        self.assertTrue(0.02 < rms < most <= at_most < 1.5, run.err)
        self.assertRegex(run.err, r"the distance to the mesh, at \d+ points of the isosurface, found with cells divided into 4 parts")

    def test_a_mesh_far_from_the_data_is_measured(self):
        """Coarse voxels are more than two voxels of the data away, and no point is left out."""
        self.convert("demo:sphere?size=65", "--iso", "0", "--resolution", "7", "--error", "-o", "a.ply", "--report", "r.json")
        error = json.loads((self.folder / "r.json").read_text())["meshes"][0]["error"]
        self.assertEqual([error["interior"][key] for key in ("not_finite", "outside", "unreached")], [0, 0, 0])
        self.assertGreater(error["interior"]["max"]["voxels"], 1.5)
        # From the formula of a sphere that is sampled so finely, the same.
        truth = error["analytic"]["interior"]
        self.assertAlmostEqual(error["interior"]["rms"]["voxels"], truth["rms"]["voxels"], delta=0.02 * truth["rms"]["voxels"])

    def test_memory_that_is_not_there_is_refused_before_the_work(self):
        arguments = ("demo:random?size=32", "--iso", "0", "--error", "--threads", "1", "-o", "a.ply", "--report", "r.json")
        self.convert(*arguments)
        report = json.loads((self.folder / "r.json").read_text())
        (self.folder / "a.ply").unlink()
        limit = report["reserved_memory_bytes"] // 3
        run = self.run_program(*arguments, "--memory-limit", f"{limit}B")
        self.assert_fails(2, run, "demo:random?size=32: the surface at iso 0 and the measurement of its error need at least",
                          "--memory-limit SIZE")
        self.assertEqual(json.loads((self.folder / "r.json").read_text())["extractions"], [], "nothing was extracted")

    def test_caps_that_simplification_moved_are_left_out(self):
        self.write_raw("ball.raw", (32, 32, 32), lambda x, y, z: 10 - math.dist((x, y, z), (15.3, 15.7, 15.1)))
        ball = ("ball.raw", "--dims", "32,32,32", "--dtype", "f32", "--simplify", "0.1", "--error", "--cap", "-o", "a.ply")
        # In a region's faces, in a plane, and in the data boundary.
        for part in (("--iso", "0", "--roi", "7,7,7,10.5,20,20"), ("--iso", "0", "--clip", "1,1,1,40"), ("--iso", "-8")):
            rms, worst = self.rms_and_max(self.convert(*ball, *part).err)
            self.assertTrue(0.02 < rms < 0.06 and rms < worst < 0.25, (part, rms, worst))

    def test_other_values_are_refused(self):
        run = self.run_program(SPHERE, "--iso", "0", "--error=cubic", "-o", "a.ply")
        self.assert_fails(1, run, "--error", "trilinear, tricubic", "cubic")
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
