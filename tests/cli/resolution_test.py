"""--resolution: a surface from a grid of another resolution than the input's, in the same place."""

import math
import random
import re

from support import SOURCE, SPHERE, ProgramTest, main, read_ply

METABALLS = SOURCE / "samples" / "metaballs.vdb"
COARSE = "demo:sphere?size=9"


class ResolutionTest(ProgramTest):
    def mesh(self, *arguments, name="a.ply"):
        self.convert(*arguments, "-o", name)
        return read_ply((self.folder / name).read_bytes())

    def rms(self, err):
        return float(re.search(r"interpolant: rms (\S+),", err).group(1))

    def assert_same_place(self, a, b, tolerance):
        for low, high in zip(a.bounds(), b.bounds()):
            for x, y in zip(low, high):
                self.assertAlmostEqual(x, y, delta=tolerance)

    def test_the_own_resolution_changes_nothing(self):
        self.mesh(SPHERE, "--iso", "0", name="a.ply")
        run = self.convert(SPHERE, "--iso", "0", "--resolution", "24", "--explain", "-o", "b.ply")
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())
        self.assertIn("left out: resampling, because the data has the requested resolution", run.err)

    def test_finer_coarser_and_uneven_grids_keep_the_place(self):
        placed = ("--spacing", "0.5,2,1", "--origin", "10,-20,3e3")
        for space in ((), ("--space", "index")):
            own = self.mesh(SPHERE, "--iso", "0", *placed, *space)
            for resolution in ("48", "30,50,24", "61x23x40"):
                other = self.mesh(SPHERE, "--iso", "0", *placed, *space, "--resolution", resolution)
                self.assertNotEqual(len(own.triangles), len(other.triangles))
                self.assertEqual(other.open_edges(), 0)
                self.assert_same_place(own, other, 0.1)

    def test_error_is_that_against_the_data_and_falls(self):
        errors = [self.rms(self.convert(COARSE, "--iso", "0", "--error", "--resolution", n, "-o", "a.ply").err)
                  for n in (33, 65, 129)]
        for coarse, fine in zip(errors, errors[1:]):
            self.assertTrue(1.7 < math.log2(coarse / fine) < 2.3, errors)
        self.assertLess(errors[0], self.rms(self.convert(COARSE, "--iso", "0", "--error", "-o", "a.ply").err))
        # Coarser than the data: voxels of error, but all of it measured.
        coarse = self.convert("demo:torus?size=65", "--iso", "0", "--error", "--resolution", "9", "-o", "a.ply").err
        self.assertGreater(self.rms(coarse), 0.5)
        self.assertNotIn("not measured", coarse)
        self.assertIn("against the formula", coarse)

    def test_roi_and_cap(self):
        for space, roi in ((), "-1,-1,-1,0,1,1"), (("--space", "index"), "0,0,0,4,8,8"):
            half = self.mesh(COARSE, "--iso", "0", *space, "--resolution", "33", "--roi", roi, "--cap")
            whole = self.mesh(COARSE, "--iso", "0", *space, "--resolution", "33")
            self.assertEqual(half.open_edges(), 0)
            self.assertAlmostEqual(half.volume() / whole.volume(), 0.5, delta=1e-3)
            self.assertAlmostEqual(half.bounds()[1][0], 4 if space else 0, delta=1e-5)
        run = self.run_program(COARSE, "--iso", "0", "--resolution", "33", "--roi", "9,9,9,10,10,10", "--space", "index")
        self.assert_fails(2, run, "the data extend over (0, 0, 0) .. (8, 8, 8)")

    def test_simplify_means_voxels_of_the_grid(self):
        run = self.convert("demo:sphere?size=25", "--iso", "0", "--resolution", "49", "--simplify", "0.2", "-o", "a.ply")
        found = re.search(r"measured \S+ to (\S+) voxels, in the mesh's units \S+ to (\S+);", run.err)
        self.assertAlmostEqual(float(found.group(2)) / float(found.group(1)), 2 / 48, delta=1e-4)

    def test_a_sparse_grid_becomes_dense_and_says_so(self):
        sparse = self.mesh(METABALLS, "--iso", "0.5")
        run = self.convert(METABALLS, "--iso", "0.5", "--resolution", "80,90,100", "--error", "-o", "b.ply")
        self.assertRegex(run.err, r"note\[sparse-made-dense\]: .*its sparse samples become 80 x 90 x 100 samples of f32 \(2\.75 MiB\), which "
                                  r"cover the voxels \(.*\) \.\. \(.*\)\n")
        self.assertNotIn("not measured", run.err)
        dense = read_ply((self.folder / "b.ply").read_bytes())
        self.assertEqual(dense.open_edges(), 0)
        self.assertAlmostEqual(dense.volume() / sparse.volume(), 1, delta=0.02)
        self.assert_same_place(sparse, dense, 0.1 * max(sparse.bounds()[1]))

    def test_nan(self):
        self.write_raw("nan.raw", (6, 6, 6), lambda x, y, z: math.nan if (x, y, z) == (3, 3, 3) else x - 2.4)
        raw = ("nan.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "0", "--resolution", "11")
        self.assert_fails(2, self.run_program(*raw), "the first at index (2.5, 2.5, 2.5)", "--nan")
        hole = self.mesh(*raw, "--nan", "hole")
        self.assertGreater(hole.open_edges(), 4 * 10)
        # Beside NaN the others have all the weight; farther away nothing changes.
        for x, y, z in hole.vertices:
            self.assertAlmostEqual(x, 2.4, delta=0.5 if abs(y - 3) < 1 and abs(z - 3) < 1 else 1e-5)

    def test_nan_is_left_out_of_coarser_and_finer_grids(self):
        """A ball in NaN or in no data keeps its volume, and dead voxels leave nothing."""
        side = (48, 48, 48)
        raw = ("--dims", "48,48,48", "--dtype", "f32")
        depth = lambda *p: 16 - math.dist(p, (23.5, 23.5, 23.5))  # noqa: E731
        dead = random.Random(0)
        self.write_raw("mask.raw", side, lambda *p: 100 if depth(*p) > 0 else math.nan)
        self.write_raw("zero.raw", side, lambda *p: 100 if depth(*p) > 0 else 0)
        self.write_raw("ok.raw", side, depth)
        self.write_raw("dead.raw", side, lambda *p: math.nan if dead.random() < 0.002 else depth(*p))
        own = self.mesh("mask.raw", *raw, "--iso", "50", "--nan", "outside").volume()
        for resolution in (("--resolution", "24"), ("--resolution", "36"), ("--resolution", "24,48,36"),
                           ("--voxel-size", "2"), ("--resolution", "75"), ("--resolution", "60", "--kernel", "cubic")):
            masked = self.mesh("mask.raw", *raw, "--iso", "50", "--nan", "outside", *resolution)
            self.assertAlmostEqual(masked.volume() / own, 1, delta=0.03 if "2" in resolution else 0.02, msg=resolution)
            self.assertEqual(masked.open_edges(), 0)
            other = self.mesh("zero.raw", *raw, "--iso", "50", "--nodata", "0", *resolution, name="b.ply")
            self.assertEqual((masked.vertices, masked.triangles), (other.vertices, other.triangles))
        for resolution in ("24", "12"):
            size = [(mesh.volume(), mesh.area()) for mesh in (
                self.mesh(name, *raw, "--iso", "0", "--nan", "outside", "--resolution", resolution)
                for name in ("ok.raw", "dead.raw"))]
            for ok, found in zip(*size):
                self.assertAlmostEqual(found / ok, 1, delta=0.005)
        for name, iso in (("mask.raw", "50"), ("dead.raw", "0")):
            self.assert_fails(2, self.run_program(name, *raw, "--iso", iso, "--resolution", "24", "-o", "no.ply"),
                              "not a number (NaN)", "--nan outside")

    def test_streams_and_threads(self):
        arguments = ("demo:gyroid?size=20", "--iso", "0", "--resolution", "41,33,50", "--format", "ply", "-o", "-", "-q")
        one, three = (self.convert(*arguments, "--threads", n) for n in (1, 3))
        self.assertEqual((one.err, one.out), ("", three.out))
        self.assertGreater(len(read_ply(one.out).triangles), 1000)

    def test_voxels_of_a_size_in_the_world(self):
        placed = (SPHERE, "--iso", "0", "--spacing", "0.5,2,1", "--origin", "10,-20,3e3")
        own = self.mesh(*placed, name="a.ply")
        run = self.convert(*placed, "--voxel-size", "0.5,2,1", "--explain", "-o", "b.ply")
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())
        self.assertIn("left out: resampling, because the data has the requested resolution", run.err)
        self.assertNotIn("note[voxel-size]", run.err)
        # 23 steps of 0.5, 2 and 1 as 46, 23 and 46; with --scale the same samples.
        for scale in ((), ("--scale", "0.01")):
            by_count = self.mesh(*placed, *scale, "--resolution", "47,24,47", name="a.ply")
            run = self.convert(*placed, *scale, "--voxel-size", "0.25,2,0.5", "-o", "b.ply")
            self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())
            self.assertNotIn("note[voxel-size]", run.err)
        self.assertNotEqual(len(own.triangles), len(by_count.triangles))
        # What does not divide the box becomes what does: 11.5, 46 and 23 by 3 are 4, 15 and 8 steps.
        self.mesh(*placed, "--resolution", "5,16,9", name="a.ply")
        run = self.convert(*placed, "--voxel-size", "3", "-o", "b.ply")
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())
        self.assertIn("voxels of 2.875 x 3.06667 x 2.875 instead of 3 x 3 x 3", run.err)

    def test_voxels_of_a_sparse_grid_of_the_same_size(self):
        sparse = self.mesh(METABALLS, "--iso", "0.5")
        run = self.convert(METABALLS, "--iso", "0.5", "--voxel-size", str(2 / 47), "-o", "b.ply")
        self.assertIn("its sparse samples become 46 x 45 x 45", run.err)
        self.assertNotIn("note[voxel-size]", run.err)
        dense = read_ply((self.folder / "b.ply").read_bytes())
        self.assertEqual((len(dense.vertices), len(dense.triangles)), (len(sparse.vertices), len(sparse.triangles)))
        for ours, theirs in zip(sorted(dense.vertices), sorted(sparse.vertices)):
            for x, y in zip(ours, theirs):
                self.assertAlmostEqual(x, y, delta=1e-5)

    def test_voxel_sizes_that_are_refused(self):
        for value in ("0", "-1", "1,1", "nan", "x", ""):
            self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--voxel-size", value),
                              "--voxel-size: expected one or three numbers above 0")
        both = self.run_program(SPHERE, "--iso", "0", "--resolution", "8", "--voxel-size", "1", "-o", "a.ply")
        self.assert_fails(1, both, "--resolution and --voxel-size both")
        for value in ("500", "1e-12"):
            run = self.run_program(SPHERE, "--iso", "0", "--voxel-size", value, "-o", "a.ply")
            self.assert_fails(1, run, f"(twice the extent of the samples), found {value}")
        self.assertEqual(self.files(), [])

    def test_bad_values(self):
        for value in ("1", "0", "-4", "4,4", "4,1,4", "4,4,4,4", "4.5", "", "x", "4,,4", "99999999999"):
            run = self.run_program(SPHERE, "--iso", "0", "--resolution", value)
            self.assert_fails(1, run, "--resolution: expected one or three whole numbers, 2 or above", f"'{value}'")

    def test_what_cannot_be_resampled(self):
        self.write_raw("flat.raw", (4, 4, 1), lambda x, y, z: x)
        flat = ("flat.raw", "--dims", "4,4,1", "--dtype", "f32", "--iso", "1.5", "-o", "a.ply")
        self.assert_fails(2, self.run_program(*flat), "at least 2 samples along each axis, found 4 x 4 x 1")
        self.assert_fails(2, self.run_program(*flat, "--resolution", "8"),
                          "at least 2 samples along each axis, found 4 x 4 x 1")
        for resolution, size in (("1000", "3.73 GiB"), ("2147483647", "")):
            run = self.run_program(SPHERE, "--iso", "0", "--resolution", resolution, "--memory-limit", "1G", "-o", "a.ply")
            self.assert_fails(2, run, f"{resolution} x {resolution} x {resolution} samples of f32 would take", size,
                              "--memory-limit")
        # A ball that falls between the samples.
        run = self.run_program(SPHERE, "--iso", "0.6", "--resolution", "2", "-o", "a.ply")
        self.assert_fails(2, run, "no surface at iso 0.6 after resampling")
        self.assertEqual(self.files(), ["flat.raw"])
        self.convert(SPHERE, "--iso", "0.6", "--resolution", "2", "--empty", "skip", "-o", "a.ply")


if __name__ == "__main__":
    main()
