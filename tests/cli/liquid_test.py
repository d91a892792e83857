"""Surfaces of liquids: spheres of unlike radii, bodies between particles, and smoothing by weights."""

import json
import math
import pathlib
import random
import unittest

from support import PROGRAM, SPHERE, ProgramTest, main, read_ply

HAS_PLUGIN = (pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so").exists()
needs_plugin = unittest.skipUnless(HAS_PLUGIN, "the plug-ins around OpenVDB were not built")


def ball_volume(radius):
    return 4 / 3 * math.pi * radius**3


def lattice(inside, half, jitter=0.0, seed=7):
    """Touching particles of radius 1 on a lattice, shifted by up to `jitter` radii."""
    chance = random.Random(seed)
    points = [(2 * i, 2 * j, 2 * k) for i in range(-half, half + 1) for j in range(-half, half + 1) for k in range(-half, half + 1)]
    return [tuple(c + jitter * chance.uniform(-1, 1) for c in p) for p in points if inside(p)]


def bodies(mesh):
    """Returns the vertices of each component."""
    parent = list(range(len(mesh.vertices)))

    def root(v):
        while parent[v] != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    for a, b, c in mesh.triangles:
        parent[root(b)] = root(a)
        parent[root(c)] = root(a)
    found = {}
    for v, place in enumerate(mesh.vertices):
        found.setdefault(root(v), []).append(place)
    return list(found.values())


class LiquidTest(ProgramTest):
    def write_csv(self, name, rows, header="x,y,z"):
        lines = [",".join(repr(float(c)) for c in row) for row in rows]
        (self.folder / name).write_text("\n".join([header, *lines]) + "\n")

    def report(self, *arguments, out="o.ply"):
        run = self.convert(*arguments, "-o", out, "--report", "r.json")
        return json.loads((self.folder / "r.json").read_text()), run

    def mesh(self, name="o.ply"):
        return read_ply((self.folder / name).read_bytes())


class SpheresTest(LiquidTest):
    ROWS = [(0, 0, 0, 1.0), (5, 0, 0, 0.3), (9, 0, 0, 1.0)]

    def write_radii(self, name, rows=None):
        self.write_csv(name, rows or self.ROWS, "x,y,z,pscale")

    @needs_plugin
    def test_cells_are_fine_enough_for_the_smallest_sphere(self):
        self.write_radii("a.csv")
        for method in ("spheres", "smooth"):
            report, run = self.report("a.csv", "--particles", method)
            self.assertEqual((report["particles"]["particles"], report["particles"]["too_small"]), (3, 0))
            self.assertAlmostEqual(report["particles"]["spacing"], 0.2, delta=1e-6)
            self.assertEqual(report["meshes"][0]["components"], 3)
            self.assertIn("note[cell-size]: a.csv: the samples are 0.2 apart, 0.2 radii instead of 0.5, so that the surface "
                          "keeps particles of the radius 0.3", run.err)
            self.assertNotIn("leave", run.err)
            if method == "spheres":
                self.assertAlmostEqual(report["meshes"][0]["volume"], 2 * ball_volume(1) + ball_volume(0.3), delta=0.3)
        # One radius for all has the usual cells.
        report, run = self.report("a.csv", "--particles", "spheres", "--radius", "1")
        self.assertEqual(report["particles"]["spacing"], 0.5)
        self.assertNotIn("cell-size", run.err)
        self.assertIn("samples 0.2 apart", self.convert("info", "a.csv", "--particles", "spheres").text)

    @needs_plugin
    def test_a_given_cell_size_stays_and_the_note_says_which_keeps_all(self):
        self.write_radii("a.csv")
        report, run = self.report("a.csv", "--particles", "spheres", "--cell-size", "0.5")
        self.assertEqual((report["particles"]["spacing"], report["particles"]["too_small"]), (0.5, 1))
        note = ("the surface will leave out particles with a radius below 0.75; a cell size of 0.2 radii keeps all")
        self.assertIn(note, run.err)
        self.assertLess(run.err.index(note), run.err.index("the surface leaves out 1 of 3 particles"))
        report, run = self.report("a.csv", "--particles", "spheres", "--cell-size", "0.2")
        self.assertEqual(report["particles"]["too_small"], 0)
        self.assertNotIn("note[cell-size]", run.err)
        # Resampling, too, says that the cells are the user's.
        report, run = self.report("a.csv", "--particles", "spheres", "--voxel-size", "0.5")
        self.assertEqual((report["particles"]["spacing"], report["particles"]["too_small"]), (0.5, 1))

    @needs_plugin
    def test_a_stray_tiny_sphere_does_not_refine_the_cells(self):
        self.write_radii("a.csv", [*self.ROWS, (20, 0, 0, 0.001), (30, 0, 0, 1.0), (40, 0, 0, 0)])
        report, run = self.report("a.csv", "--particles", "spheres")
        self.assertAlmostEqual(report["particles"]["spacing"], 0.2, delta=1e-6)
        self.assertEqual(report["particles"]["too_small"], 2)
        self.assertIn("a cell size of 0.000666 radii keeps all, but takes cells more than 4 times finer than usual", run.err)

    @needs_plugin
    def test_the_memory_limit_bounds_the_refinement(self):
        rows = [(3 * i, 3 * j, 3 * k, 1.0) for i in range(8) for j in range(8) for k in range(8)]
        self.write_radii("a.csv", [*rows, (-5, 0, 0, 0.2)])
        report, _ = self.report("a.csv", "--particles", "spheres")
        self.assertAlmostEqual(report["particles"]["spacing"], 0.2 / 1.5, delta=1e-6)
        report, run = self.report("a.csv", "--particles", "spheres", "--memory-limit", "150M")
        self.assertGreater(report["particles"]["spacing"], 0.15)
        self.assertEqual(report["particles"]["too_small"], 1)
        self.assertIn("but may take more than 37.5 MiB, a quarter of the memory limit", run.err)

    @needs_plugin
    def test_frames_of_a_sequence_share_their_cells(self):
        self.write_radii("s_1.csv", [(0, 0, 0, 1.0), (5, 0, 0, 1.0)])
        self.write_radii("s_2.csv")
        self.write_radii("s_3.csv", [(0, 0, 0, 2.0), (5, 0, 0, 2.0)])
        run = self.convert("s_{}.csv", "--particles", "spheres", "-o", "o_{}.ply", "--report", "r_{}.json")
        self.assertIn("all frames have samples 0.2 apart, which keeps particles of the radius 0.3", run.err)
        for number in (1, 2, 3):
            report = json.loads((self.folder / f"r_{number}.json").read_text())
            self.assertAlmostEqual(report["particles"]["spacing"], 0.2, delta=1e-6)
            self.assertEqual(report["options"]["particles"]["sequence_spacing"], report["particles"]["spacing"])
        whole = [(self.folder / f"o_{n}.ply").read_bytes() for n in (1, 2, 3)]
        self.convert("s_{}.csv", "--particles", "spheres", "-o", "p_{}.ply", "--shard", "1/3")
        self.assertEqual((self.folder / "p_1.ply").read_bytes(), whole[0])
        self.assertIn("all frames have samples 0.2 apart", self.convert("info", "s_{}.csv", "--particles", "spheres").err)
        run = self.convert("s_{}.csv", "--particles", "spheres", "--cell-size", "0.3", "-o", "q_{}.ply")
        self.assertNotIn("all frames have samples", run.err)


class SmoothSpheresTest(LiquidTest):
    def distance_of_bodies(self, rows):
        """How far the farthest body is from the nearest sphere; 0 if every body reaches into one."""
        self.write_csv("s.csv", rows, "x,y,z,pscale")
        self.convert("s.csv", "--particles", "smooth", "--cell-size", "0.25", "-o", "o.ply")
        return max(max(0, min(math.dist(v, row[:3]) - row[3] for v in body for row in rows)) for body in bodies(self.mesh()))

    @needs_plugin
    def test_there_is_no_body_without_a_particle(self):
        for distance in (2.5, 3, 3.5, 4, 5, 6, 7):
            for radii in ((2, 1, 0.5), (1, 1, 1)):
                rows = [(distance * math.cos(a) + 0.1, distance * math.sin(a), 0.2, r)
                        for a, r in zip((0, 2.2, 4.1), radii)]
                self.assertLess(self.distance_of_bodies(rows), 0.05, (distance, radii))
        # Two particles almost two reaches apart: a disc half way between them.
        self.assertLess(self.distance_of_bodies([(0, 0, 0, 1), (7, 0, 0, 1)]), 0.05)

    @needs_plugin
    def test_spheres_beyond_the_reach_of_the_median_are_whole(self):
        self.write_csv("a.csv", [(0, 0, 0, 8), (12, 0, 0, 1), (0, 14, 0, 1)], "x,y,z,pscale")
        report, _ = self.report("a.csv", "--particles", "smooth")
        self.assertAlmostEqual(report["meshes"][0]["volume"] / (ball_volume(8) + 2 * ball_volume(1)), 1, delta=0.02)

    @needs_plugin
    def test_a_filled_ball_keeps_its_volume_and_its_roughness(self):
        for jitter, roughness in ((0, 0.29), (0.4, 0.35)):
            points = lattice(lambda p: math.hypot(*p) <= 16, 8, jitter)
            self.write_csv("b.csv", points)
            report, _ = self.report("b.csv", "--particles", "smooth", "--radius", "1")
            self.assertEqual(report["meshes"][0]["components"], 1)
            self.assertAlmostEqual(report["meshes"][0]["volume"] / (8 * len(points)), 0.98, delta=0.02)
            radii = [math.hypot(*v) for v in self.mesh().vertices]
            mean = sum(radii) / len(radii)
            self.assertLess(math.sqrt(sum((r - mean)**2 for r in radii) / len(radii)), roughness)


class WeightedSmoothTest(LiquidTest):
    SMOOTH = ("--smooth", "25:weighted")

    def volumes(self, *options):
        """The volume of the mesh before and after smoothing."""
        plain, _ = self.report(*options)
        smooth, _ = self.report(*options, *self.SMOOTH)
        return plain["meshes"][0]["volume"], smooth["meshes"][0]["volume"]

    def roughness_of_top(self):
        """Root mean square distance from the mean height, away from the rim of a slab of 30 x 30 radii."""
        heights = [z for x, y, z in self.mesh().vertices if max(abs(x), abs(y)) < 10 and z > 0]
        mean = sum(heights) / len(heights)
        return math.sqrt(sum((z - mean)**2 for z in heights) / len(heights))

    def write_slab(self):
        self.write_csv("slab.csv", lattice(lambda p: max(abs(p[0]), abs(p[1])) <= 15 and abs(p[2]) <= 4, 8, 0.5))

    def test_droplets_keep_their_volume(self):
        corners = [(2 * i, 2 * j, 2 * k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
        for count in (1, 2, 3, 8):
            self.write_csv("few.csv", corners[:count])
            before, after = self.volumes("few.csv", "--radius", "1")
            self.assertAlmostEqual(after / before, 1, delta=0.01)

    def test_a_slab_becomes_flat(self):
        self.write_slab()
        self.report("slab.csv", "--radius", "1")
        before = self.roughness_of_top()
        report, run = self.report("slab.csv", "--radius", "1", *self.SMOOTH)
        self.assertLess(self.roughness_of_top(), before / 2)
        (entry,) = report["smoothings"]
        self.assertEqual((entry["method"], entry["passes"], entry["pass_band"]), ("weighted", 25, None))
        self.assertTrue(0.5 < entry["mean_weight"] < 1, entry["mean_weight"])
        self.assertRegex(run.err, r"smoothed at iso 0.6: 25 passes of weighted, mean weight 0\.\d+; vertices moved by at most")
        self.assertEqual(self.mesh().open_edges(), 0)

    def test_a_ball_keeps_its_volume(self):
        self.write_csv("ball.csv", lattice(lambda p: math.hypot(*p) <= 30, 15, 0.4))
        before, after = self.volumes("ball.csv", "--radius", "1")
        self.assertAlmostEqual(after / before, 1, delta=0.01)

    def test_weights_are_those_of_the_input_in_any_placement(self):
        self.write_slab()
        self.convert("slab.csv", "--radius", "1", *self.SMOOTH, "-o", "a.ply")
        self.convert("slab.csv", "--radius", "1", *self.SMOOTH, "--scale", "0.01", "--up", "y", "-o", "b.ply")
        a, b = self.mesh("a.ply"), self.mesh("b.ply")
        self.assertAlmostEqual(b.volume() * 1e6 / a.volume(), 1, delta=1e-4)

    def test_any_number_of_threads_and_method_of_kernels(self):
        self.write_slab()
        for threads in (1, 3):
            self.convert("slab.csv", "--radius", "1", *self.SMOOTH, "--threads", threads, "-o", f"{threads}.glb")
        self.assertEqual((self.folder / "1.glb").read_bytes(), (self.folder / "3.glb").read_bytes())
        for method in ("anisotropic", *(("smooth",) if HAS_PLUGIN else ())):
            report, _ = self.report("slab.csv", "--radius", "1", "--particles", method, *self.SMOOTH)
            self.assertGreater(report["smoothings"][0]["mean_weight"], 0.5)
        # With attributes, which come from the same particles.
        self.write_csv("T.csv", [(2 * i, 0, 0, i) for i in range(5)], "x,y,z,T")
        report, _ = self.report("T.csv", "--radius", "1", "--attribute", "T", *self.SMOOTH)
        self.assertEqual([entry["name"] for entry in report["attributes"]], ["T"])

    def test_it_needs_particles_with_kernels(self):
        self.write_csv("a.csv", [(0, 0, 0)])
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", *self.SMOOTH, "-o", "a.ply"),
                          "weighted smoothing needs particles and a method with kernels or averaged positions, found a volume")
        for method, title in (("weight", "summed weights"), ("spheres", "united spheres")):
            self.assert_fails(1, self.run_program("a.csv", "--particles", method, "--radius", "1", *self.SMOOTH, "-o", "a.ply"),
                              f"found {title}")
        self.assert_fails(1, self.run_program("a.csv", "--smooth", "25:weighted:0.1", "-o", "a.ply"), "25:weighted")
        self.assertEqual(self.files(), ["a.csv"])


if __name__ == "__main__":
    main()
