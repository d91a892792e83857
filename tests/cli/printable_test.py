"""--require on a conversion, and edits and cuts that make no triangles intersect."""

import json
import math
import random

from support import DATA, ProgramTest, main, needs_data, read_ply

NOISE = ("demo:random?size=20", "--iso", "0.5", "--cap")


class PrintableTest(ProgramTest):
    def check(self, name):
        return json.loads(self.run_program("check", name, "--json").out)["mesh"]

    def pairs(self, name):
        return self.check(name)["self_intersections"]["pairs"]

    def test_noise_is_made_printable(self):
        self.convert(*NOISE, "-o", "raw.stl")
        before = self.pairs("raw.stl")
        self.assertGreater(before, 0)
        for more in ((), ("--triangles", "50%"), ("--smooth", "5:sinc")):
            with self.subTest(more=more):
                run = self.convert(*NOISE, "--require", "printable", *more, "-o", "out.stl", "--report", "r.json")
                self.assertIn("untangled at iso 0.5: 0 of ", run.err)
                found = self.run_program("check", "out.stl", "--require", "printable")
                self.assertEqual(found.code, 0, found.err)
                (entry,) = json.loads((self.folder / "r.json").read_text())["untanglings"]
                self.assertGreater(entry["pairs"]["before"], 0)
                self.assertEqual(entry["pairs"]["after"], 0)
                self.assertLess(entry["greatest_move"], 1)

    def test_unmet_requirements_write_no_file(self):
        # With the whole mesh in memory, the loops of the open edges are known, too.
        for more, found in (((), "1050 open edges\n"), (("--drop-components", "1"), "1050 open edges in ")):
            run = self.run_program("demo:gyroid?size=16", "--iso", "0", "--require", "closed,manifold", *more, "-o", "out.ply")
            self.assert_fails(6, run, f"the mesh does not meet the requirement closed: {found}", "use --cap")
            self.assertNotIn("out.ply", self.files())
        run = self.run_program(*NOISE, "--require", "one-component", "-o", "out.ply")
        self.assert_fails(6, run, "the mesh does not meet the requirement one-component")
        run = self.run_program(*NOISE, "--require", "normals", "-o", "out.ply")
        self.assert_fails(1, run, "isoextract check --require normals")

    def test_an_open_surface_is_not_untangled(self):
        run = self.run_program(*NOISE[:3], "--require", "printable", "-o", "out.ply")
        self.assert_fails(6, run, "the mesh does not meet the requirements closed, ", "no-self-intersections: ", "use --cap")
        self.assertNotIn("untangled", run.err)
        self.convert(*NOISE[:3], "-o", "open.ply")
        run = self.run_program("open.ply", "--require", "closed", "-o", "out.ply")
        self.assert_fails(6, run, "the mesh does not meet the requirement closed: ", "use --repair")
        run = self.run_program("open.ply", "--repair=4", "--require", "closed", "-o", "out.ply")
        self.assert_fails(6, run, "the mesh does not meet the requirement closed: ", "give a larger --repair EDGES")
        self.assertRegex(self.convert("open.ply", "--repair=4", "-o", "out.ply").err, r"left \d+ holes open, \d+ of more than 4 edges")

    def test_a_mesh_that_repair_helps_is_told_so(self):
        self.convert("demo:sphere?size=12", "--iso", "0", "-o", "ball.obj")
        text = (self.folder / "ball.obj").read_text()
        lines = [" ".join([line.split()[0], *line.split()[:0:-1]]) if line.startswith("f ") else line for line in text.splitlines()]
        (self.folder / "turned.obj").write_text("\n".join(lines) + "\n")
        run = self.run_program("turned.obj", "--require", "printable", "-o", "out.stl")
        self.assert_fails(6, run, "the mesh does not meet the requirement outward: 1 component inside out", "use --repair")
        self.convert("turned.obj", "--require", "printable", "--repair", "-o", "out.stl")

    def test_met_requirements_change_nothing(self):
        for edit in (("--triangles", "500"), ("--smooth", "10"), ("--clip", "1,2,3,0.1")):
            self.convert("demo:torus?size=24", "--iso", "0", "--cap", *edit, "-o", "a.ply")
            self.convert("demo:torus?size=24", "--iso", "0", "--cap", *edit, "--require", "printable", "-o", "b.ply")
            self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())

    def test_edits_make_no_new_pairs(self):
        self.convert(*NOISE, "--method", "mt", "-o", "raw.ply")
        self.assertEqual(self.pairs("raw.ply"), 0)
        for edit in (("--triangles", "30%"), ("--simplify", "0.5"), ("--smooth", "20:sinc"), ("--smooth", "20")):
            self.convert(*NOISE, "--method", "mt", *edit, "-o", "out.ply")
            self.assertEqual(self.pairs("out.ply"), 0, edit)

    def test_planes_through_vertices_edges_and_triangles(self):
        ball = ("demo:sphere?size=20", "--iso", "0")
        self.convert(*ball, "-o", "ball.ply")
        mesh = read_ply((self.folder / "ball.ply").read_bytes())
        chance = random.Random(4)

        def minus(p, q):
            return [a - b for a, b in zip(p, q)]

        def cross(p, q):
            return [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]

        for number in range(60):
            a, b, c = (mesh.vertices[v] for v in mesh.triangles[chance.randrange(len(mesh.triangles))])
            normal = [chance.gauss(0, 1) for _ in range(3)]
            if number % 3 == 1:
                normal = cross(normal, minus(b, a))
            elif number % 3 == 2:
                normal = [-x for x in cross(minus(b, a), minus(c, a))]
            size = math.sqrt(sum(x * x for x in normal))
            normal = [x / size for x in normal]
            offset = sum(n * x for n, x in zip(normal, a))
            plane = ",".join(f"{x:.17g}" for x in [*normal, offset])
            self.convert(*ball, "--cap", f"--clip={plane}", "--empty", "write", "-o", "cut.ply")
            found = self.check("cut.ply")
            if found["triangles"] == 0:
                continue
            self.assertTrue(found["closed"], plane)
            self.assertEqual(found["self_intersections"]["pairs"], 0, plane)
            self.assertEqual(found["zero_area_triangles"] + found["duplicate_triangles"], 0, plane)

    def test_the_distance_includes_untangling(self):
        noise = ("demo:random?size=20", "--iso", "0.3", "--cap")
        self.convert(*noise, "-o", "raw.ply")
        self.convert(*noise, "--simplify", "0.001", "--require", "printable", "-o", "out.ply", "--report", "r.json")
        report = json.loads((self.folder / "r.json").read_text())
        (untangled,) = report["untanglings"]
        self.assertGreater(untangled["distance"], 0.1)
        measured = report["simplifications"][0]["measured"]
        self.assertGreaterEqual(measured["voxels"]["upper"], untangled["distance"])
        lower, upper = json.loads(self.run_program("compare", "raw.ply", "out.ply", "--json").out)["hausdorff"]
        self.assertLessEqual(lower, measured["world"]["upper"])
        self.assertGreater(upper, 0.5 * measured["world"]["upper"])

    def test_coarse_coordinates_are_named(self):
        far = (*NOISE, "--origin", "600000,6000000,0", "--require", "printable")
        self.assert_fails(6, self.run_program(*far, "-o", "out.stl"), "the mesh does not meet the requirements manifold, ", "use --center, ")
        self.convert(*far, "-o", "out.ply")

    @needs_data("vdb/smoke.vdb")
    def test_smoke_with_tunnels_that_flips_cannot_open(self):
        self.convert(str(DATA / "vdb/smoke.vdb"), "--grid", "density", "--iso", "0.5", "--triangles", "50000", "--require", "printable",
                     "-o", "smoke.stl")
        self.assertEqual(self.run_program("check", "smoke.stl", "--require", "printable").code, 0)

    @needs_data("med/tooth.nhdr")
    def test_a_scan(self):
        self.convert(str(DATA / "med/tooth.nhdr"), "--iso", "500", "--cap", "--triangles", "20000", "--require", "printable",
                     "-o", "tooth.stl")
        self.assertEqual(self.run_program("check", "tooth.stl", "--require", "printable").code, 0)

    def test_the_error_names_the_files_before_it(self):
        """Of labels with a file each, those before the failing one stay, and the message says so."""
        labels = {(2, 2, 2): 1, (5, 5, 5): 2, (2, 5, 2): 3, (5, 2, 5): 3}  # 3 has two components
        self.write_raw("labels.raw", (8, 8, 8), lambda *p: labels.get(p, 0), "B")
        run = self.run_program("labels.raw", "--dims", "8,8,8", "--dtype", "u8", "--labels", "all", "--require",
                               "one-component", "-o", "label_{label}.ply")
        self.assert_fails(6, run, "one-component", "; 2 files written before stay: label_1.ply and label_2.ply")
        self.assertEqual([f for f in self.files() if f.endswith(".ply")], ["label_1.ply", "label_2.ply"])


if __name__ == "__main__":
    main()
