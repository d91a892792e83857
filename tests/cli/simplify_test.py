"""--simplify, --triangles: fewer triangles within a stated distance or to a stated number, told, reported, and checked by compare."""

import json
import math
import re

from support import DATA, SPHERE, ProgramTest, main, needs_data, read_ply

FINE = "demo:sphere?size=48"


class SimplifyTest(ProgramTest):
    def both(self, name, *arguments):
        """The mesh as it is and simplified; what compare says of the two."""
        self.convert(*arguments, "-o", f"full_{name}")
        run = self.convert(*arguments, "--simplify", "0.1", "-o", name, "--report", "report.json")
        (record,) = json.loads((self.folder / "report.json").read_text())["simplifications"]
        report = json.loads(self.convert("compare", "--json", f"full_{name}", name).text)
        self.assertEqual(record["triangles_before"], report["a"]["triangles"])
        self.assertEqual(record["triangles_after"], report["b"]["triangles"])
        self.assertEqual(record["asked"], {"distance": 0.1, "unit": "voxel"})
        self.assertLessEqual(record["measured"]["voxels"]["upper"], 0.1)
        self.assertLessEqual(report["hausdorff"][0], record["measured"]["world"]["upper"] + report["resolution"])
        for fact in ("closed", "components", "genus", "open_edges"):
            self.assertEqual(report["a"][fact], report["b"][fact], fact)
        self.assertLess((self.folder / name).stat().st_size, (self.folder / f"full_{name}").stat().st_size)
        return run, record, report

    def test_every_format(self):
        for name in ("a.glb", "a.ply", "a.obj", "a.stl", "a.gltf"):
            run, record, _ = self.both(name, FINE, "--iso", "0")
            self.assertLess(record["triangles_after"], 0.3 * record["triangles_before"])
            self.assertRegex(run.err, rf"simplified at iso 0: {record['triangles_after']} of "
                                      rf"{record['triangles_before']} triangles left .* requested at most 0.1 voxels, "
                                      r"measured \S+ to \S+ voxels, in the mesh's units \S+ to \S+; \S+ s")

    def test_uneven_spacing_and_scale(self):
        _, record, report = self.both("a.ply", FINE, "--iso", "0", "--spacing", "1,2,5", "--scale", "0.001")
        self.assertTrue(report["b"]["closed"])
        self.assertLess(record["triangles_after"], 0.5 * record["triangles_before"])

    def test_world_units(self):
        self.convert(FINE, "--iso", "0", "-o", "full.ply")
        run = self.convert(FINE, "--iso", "0", "--simplify", "0.004world", "-o", "a.ply")
        self.assertIn("requested at most 0.004 of the mesh's units", run.err)
        self.convert("compare", "full.ply", "a.ply", "--max-distance", "0.004")

    def test_several_isos_and_the_explanation(self):
        run = self.convert(FINE, "--iso", "0", "--iso", "0.2", "--simplify", "0.05voxel", "--explain", "-o", "a.glb")
        self.assertEqual(len(re.findall("simplified at iso", run.err)), 2)
        self.assertEqual(len(re.findall(r"simplified in .* rounds? over \d+ patch", run.err)), 2)

    def test_smooth_normals_are_kept(self):
        self.convert(FINE, "--iso", "0", "--normals", "smooth", "-o", "full.ply")
        self.convert(FINE, "--iso", "0", "--normals", "smooth", "--simplify", "0.1", "-o", "a.ply")
        full, less = (read_ply((self.folder / name).read_bytes()) for name in ("full.ply", "a.ply"))
        known = dict(zip(full.vertices, full.normals))
        self.assertTrue(less.vertices)
        for vertex, normal in zip(less.vertices, less.normals):
            self.assertEqual(known[vertex], normal)

    def test_nothing_to_gain_is_told(self):
        self.convert(SPHERE, "--iso", "0", "-o", "full.ply")
        run = self.convert(SPHERE, "--iso", "0", "--simplify", "1e-9", "-o", "a.ply")
        self.assertIn("not simplified at iso 0: removing any", run.err)
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "full.ply").read_bytes())

    def test_same_bytes_for_any_number_of_threads(self):
        for threads in (1, 3):
            self.convert("demo:gyroid?size=40", "--iso", "0", "--simplify", "0.1", "--threads", threads, "-o",
                         f"a{threads}.ply")
        self.assertEqual((self.folder / "a1.ply").read_bytes(), (self.folder / "a3.ply").read_bytes())

    def count(self, *arguments, name="a.ply"):
        """The run and its record."""
        run = self.convert(*arguments, "-o", name, "--report", "report.json")
        (record,) = json.loads((self.folder / "report.json").read_text())["simplifications"]
        return run, record

    def test_a_number_of_triangles(self):
        arguments = ("demo:gyroid?size=40", "--iso", "0", "--cap", "--spacing", "1,2,5")
        self.convert(*arguments, "-o", "full.ply")
        run, record = self.count(*arguments, "--triangles", "5000")
        report = json.loads(self.convert("compare", "--json", "full.ply", "a.ply").text)
        self.assertEqual(record["asked"], None)
        self.assertEqual(record["asked_triangles"], "5000")
        self.assertEqual(record["triangles_before"], report["a"]["triangles"])
        self.assertEqual(record["triangles_after"], report["b"]["triangles"])
        self.assertIn(record["triangles_after"], (4999, 5000))
        lower, upper = (record["measured"]["world"][end] for end in ("lower", "upper"))
        self.assertLess(0, lower)
        self.assertLessEqual(lower, report["hausdorff"][1] + report["resolution"])
        self.assertLessEqual(report["hausdorff"][0], upper + report["resolution"])
        for fact in ("closed", "components", "genus", "open_edges"):
            self.assertEqual(report["a"][fact], report["b"][fact], fact)
        self.assertRegex(run.err, r"requested 5000 triangles, measured \S+ to \S+ voxels")

    def test_a_part_of_the_triangles(self):
        _, record = self.count(FINE, "--iso", "0", "--triangles", "12.5%")
        self.assertEqual(record["asked_triangles"], "12.5%")
        self.assertLessEqual(abs(record["triangles_after"] - record["triangles_before"] // 8), 1)
        voxel = 2 / 47
        self.assertAlmostEqual(record["measured"]["world"]["upper"] / record["measured"]["voxels"]["upper"], voxel, 6)

    def test_a_number_and_a_distance(self):
        _, alone = self.count(FINE, "--iso", "0", "--simplify", "0.05")
        run, both = self.count(FINE, "--iso", "0", "--simplify", "0.05", "--triangles", "20")
        self.assertLess(alone["triangles_after"] * 0.5, both["triangles_after"])
        self.assertLess(both["triangles_after"], alone["triangles_after"] * 2)
        self.assertLessEqual(both["measured"]["voxels"]["upper"], 0.05)
        self.assertIn("requested 20 triangles and at most 0.05 voxels", run.err)
        self.assertIn("fewer triangles would exceed the distance", run.err)
        _, enough = self.count(FINE, "--iso", "0", "--simplify", "0.5", "--triangles", "6000")
        self.assertIn(enough["triangles_after"], (5999, 6000))

    def test_more_triangles_than_topology_needs(self):
        run, record = self.count("demo:gyroid?size=24", "--iso", "0", "--cap", "--triangles", "1")
        self.assertGreater(record["triangles_after"], 1)
        self.assertIn("fewer triangles would change the topology", run.err)

    def test_as_many_as_there_are(self):
        self.convert(SPHERE, "--iso", "0", "-o", "full.ply")
        for asked in ("100%", "1000000"):
            run, record = self.count(SPHERE, "--iso", "0", "--triangles", asked)
            self.assertIn(f"the mesh has {record['triangles_before']} triangles, and the target is", run.err)
            self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "full.ply").read_bytes())

    def test_same_triangles_for_any_number_of_threads(self):
        for threads in (1, 3):
            self.convert("demo:gyroid?size=64", "--iso", "0", "--triangles", "3000", "--threads", threads, "-o",
                         f"a{threads}.ply")
        self.assertEqual((self.folder / "a1.ply").read_bytes(), (self.folder / "a3.ply").read_bytes())

    def test_no_surface(self):
        run = self.convert(SPHERE, "--iso", "9", "--empty", "write", "--simplify", "0.1", "-o", "a.ply")
        self.assertIn("not simplified at iso 9: the mesh has no triangles", run.err)

    def specks(self):
        """Single samples among zeros: octahedra a voxel wide."""
        self.write_raw("specks.raw", (40, 40, 40),
                       lambda x, y, z: float(x % 4 == 1 and y % 4 == 2 and z % 4 == 2 and (x * 7 + y * 5 + z * 3) % 5 > 1))
        return ("specks.raw", "--dims", "40,40,40", "--dtype", "f32", "--iso", "0.5")

    def test_thin_shells_are_not_turned_inside_out(self):
        """Their sides would have to pass through each other."""
        def sheets(x, y, z):
            waves = (8 * k + 4 + 1.5 * math.sin(x / 3 + k) * math.cos(y / 4) for k in range(5))
            return -100.0 if math.hypot(x - 20, y - 20) > 15 else -min(abs(z - wave) for wave in waves)

        self.write_raw("sheets.raw", (40, 40, 40), sheets)
        thin = ("sheets.raw", "--dims", "40,40,40", "--dtype", "f32", "--iso", "-0.6")
        for distance in ("4", "0.2"):
            run, record = self.count(*thin, "--simplify", distance)
            mesh = json.loads(self.run_program("check", "a.ply", "--json").text)["mesh"]
            self.assertEqual(record["components"], mesh["components"])
            self.assertEqual((mesh["shells"]["inside out"], mesh["self_intersections"]["pairs"]), (0, 0))
            self.assertEqual(record["turned_inside_out"], 0)
            self.assertNotIn("inside out", run.err)

    def test_cavities_do_not_leave_their_bodies(self):
        """A ball with a cavity right under its surface at the right: chords of a coarse ball pass to the left of it."""

        def ball(x, y, z):
            return min(14 - math.dist((x, y, z), (16.2, 16.1, 16)), math.dist((x, y, z), (27.3, 16.1, 16)) - 2)

        self.write_raw("ball.raw", (33, 33, 33), ball)
        thin = ("ball.raw", "--dims", "33,33,33", "--dtype", "f32", "--iso", "0")
        for distance in ("3", "0.1"):
            run, record = self.count(*thin, "--simplify", distance)
            mesh = json.loads(self.run_program("check", "a.ply", "--json").text)["mesh"]
            self.assertEqual((mesh["components"], mesh["shells"]["body"], mesh["shells"]["inside out"]), (2, 1, 0))
            self.assertEqual(mesh["self_intersections"]["pairs"], 0)
            self.assertEqual((record["left_bodies"], record["turned_inside_out"]), (0, 0))
            self.assertNotIn("out of the surrounding body", run.err)

    def test_components_that_keep_the_number_up_are_told_of(self):
        run, record = self.count(*self.specks(), "--triangles", "10")
        self.assertRegex(run.err, rf"{record['components']} components, each of which stays, have many of the")
        self.assertNotIn("each of which stays", self.count(SPHERE, "--iso", "0", "--triangles", "100")[0].err)

    def test_usage(self):
        for wrong in ("0", "-1", "0.1mm", "world", "nan", "1e999", ""):
            self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--simplify", wrong), "--simplify")
        for wrong in ("0", "-1", "1.5", "0%", "101%", "nan", "%", "1e999", "ten", ""):
            self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--triangles", wrong), "--triangles")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--target-reduction", "0.9"), "--triangles 10%")

    @needs_data("med/MR.nii.gz")
    def test_a_noisy_scan(self):
        _, record, _ = self.both("a.glb", DATA / "med/MR.nii.gz", "--iso", "120", "--roi", "-340,-20,440,-300,60,500",
                                 "--cap")
        self.assertLess(record["triangles_after"], record["triangles_before"])


if __name__ == "__main__":
    main()
