"""--heightfield: terrain of arrays and images, against NumPy."""

import json

from support import DATA, ProgramTest, main, needs_data, needs_modules, read_ply

needs_modules("numpy", "tifffile", "PIL")

import numpy  # noqa: E402
import tifffile  # noqa: E402
from PIL import Image  # noqa: E402


def diagonal_volume(heights, base):
    """Volume above the base: each square is cut from (0, 0) to (1, 1)."""
    h = heights.astype("f8") - base
    a, b, c, d = h[:-1, :-1], h[:-1, 1:], h[1:, 1:], h[1:, :-1]
    return ((a + b + c) / 6 + (a + c + d) / 6).sum()


class TerrainTest(ProgramTest):
    def check(self, name, *requirements):
        run = self.run_program("check", "--json", *requirements, name)
        self.assertEqual(run.code, 0, run.err + run.text)
        return json.loads(run.out)[0] if isinstance(json.loads(run.out), list) else json.loads(run.out)

    def mesh(self, name):
        return read_ply((self.folder / name).read_bytes())

    def volume(self, name):
        mesh = self.mesh(name)
        p = numpy.array(mesh.vertices, "f8")
        a, b, c = (p[numpy.array(mesh.triangles)[:, k]] for k in range(3))
        return numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6

    def open_edges(self, name):
        triangles = numpy.array(self.mesh(name).triangles)
        edges = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        forward = {tuple(edge) for edge in edges}
        self.assertEqual(len(forward), len(edges), "an edge has two triangles on one side")
        return sum((b, a) not in forward for a, b in forward)

    @needs_data("terrain/jacksboro_elevation.npy")
    def test_volume_of_real_terrain(self):
        heights = numpy.load(DATA / "terrain/jacksboro_elevation.npy")
        self.convert(DATA / "terrain/jacksboro_elevation.npy", "--heightfield", "--base", "200", "-o", "t.ply")
        rows, columns = heights.shape
        self.assertEqual(len(self.mesh("t.ply").triangles),
                         2 * (rows - 1) * (columns - 1) + 3 * 2 * (rows + columns - 2))
        weights = numpy.ones(heights.shape)
        weights[[0, -1]] /= 2
        weights[:, [0, -1]] /= 2
        trapezoid = ((heights - 200.0) * weights).sum()
        self.assertAlmostEqual(self.volume("t.ply") / trapezoid, 1, delta=1e-6)
        self.assertEqual(self.open_edges("t.ply"), 0)
        self.check("t.ply", "--require", "closed,manifold,oriented,outward,no-zero-area")

    def test_every_vertex_is_a_sample(self):
        heights = numpy.random.default_rng(1).integers(0, 50, (6, 9)).astype("f4")
        numpy.save(self.folder / "h.npy", heights)
        self.convert("h.npy", "--heightfield", "--base", "none", "--spacing", "2,3,0.5", "--origin", "10,20,30", "-o", "o.ply")
        mesh = self.mesh("o.ply")
        j, i = numpy.indices(heights.shape)
        expected = numpy.stack([10 + 2 * i, 20 + 3 * j, 30 + 0.5 * heights], -1).reshape(-1, 3)
        self.assertTrue(numpy.allclose(numpy.array(mesh.vertices), expected))
        p = numpy.array(mesh.vertices, "f8")
        a, b, c = (p[numpy.array(mesh.triangles)[:, k]] for k in range(3))
        self.assertTrue((numpy.cross(b - a, c - a)[:, 2] > 0).all(), "triangles face up")
        self.assertEqual(self.open_edges("o.ply"), 2 * (5 + 8))

    def test_default_floor_is_a_tenth_below(self):
        heights = numpy.random.default_rng(2).random((7, 5))
        numpy.save(self.folder / "h.npy", heights)
        self.convert("h.npy", "--heightfield", "-o", "t.ply")
        low, high = heights.min(), heights.max()
        floor = low - (high - low) / 10
        self.assertAlmostEqual(min(p[2] for p in self.mesh("t.ply").vertices), floor, places=6)
        self.assertAlmostEqual(self.volume("t.ply") / diagonal_volume(heights, floor), 1, delta=1e-6)

    def test_missing_heights_are_holes_and_the_solid_stays_closed(self):
        rng = numpy.random.default_rng(3)
        for share in (0.02, 0.1, 0.3):
            heights = rng.random((20, 25))
            heights[rng.random(heights.shape) < share] = numpy.nan
            numpy.save(self.folder / "h.npy", heights)
            self.convert("h.npy", "--heightfield", "--base", "-1", "-o", "t.ply")
            self.assertEqual(self.open_edges("t.ply"), 0)
            h = heights + 1
            a, b, c, d = h[:-1, :-1], h[:-1, 1:], h[1:, 1:], h[1:, :-1]
            self.assertAlmostEqual(self.volume("t.ply"), numpy.nansum((a + b + c) / 6 + (a + c + d) / 6 + 0 * (b + d)),
                                   delta=1e-4)
            self.check("t.ply", "--require", "closed,manifold,oriented,outward,no-zero-area")
        run = self.run_program("h.npy", "--heightfield", "--nan", "error", "-o", "t.ply")
        self.assert_fails(2, run, "NaN", "use --nan hole to leave holes around them")
        self.assertNotIn("outside", run.err)
        numpy.save(self.folder / "none.npy", numpy.array([[1, 2], [3, numpy.nan]]))
        run = self.run_program("none.npy", "--heightfield", "-o", "t.ply")
        self.assert_fails(2, run, "none.npy: there is no terrain: every square of four samples has a NaN sample")

    def test_messages_name_no_iso_value(self):
        numpy.save(self.folder / "h.npy", numpy.random.default_rng(5).random((12, 10)))
        edits = ("--simplify", "0.01", "--smooth", "2", "--clip", "1,0,0,3", "--cap")
        run = self.convert("h.npy", "--heightfield", *edits, "-v", "-o", "t.ply")
        self.assertIn("h.npy -> t.ply: ", run.err)
        self.assertIn("h.npy: extracted in ", run.err)
        self.assertNotRegex(run.err, r"\biso\b")
        run = self.convert("h.npy", "--heightfield", "--explain", "-o", "t.glb")
        self.assertNotRegex(run.err, r"\biso\b")
        run = self.run_program("h.npy", "--heightfield", "--clip", "1,0,0,50", "-o", "t.ply")
        self.assert_fails(2, run, "h.npy: clipping removes the whole surface; ")
        run = self.convert("h.npy", "--heightfield", "--clip", "1,0,0,50", "--empty", "skip", "-o", "t.ply")
        self.assertIn("h.npy: clipping removed every triangle; the conversion did not write t.ply", run.err)

    def test_images_and_their_placement(self):
        heights = numpy.random.default_rng(4).integers(0, 200, (8, 10)).astype("u1")
        Image.fromarray(heights).save(self.folder / "h.png")
        tags = [(33550, "d", 3, (30.0, 20.0, 0.0)), (33922, "d", 6, (0.0, 0.0, 0.0, 1000.0, 5000.0, 0.0))]
        tifffile.imwrite(self.folder / "h.tif", heights.astype("i2"), metadata=None, extratags=tags)
        self.convert("h.png", "--heightfield", "--base", "-10", "-o", "png.ply")
        self.assertAlmostEqual(self.volume("png.ply") / diagonal_volume(heights, -10), 1, delta=1e-6)
        # Rows of the map go south, which mirrors the samples; the mesh is not inside out.
        self.convert("h.tif", "--heightfield", "--base", "-10", "-o", "tif.ply")
        self.assertAlmostEqual(self.volume("tif.ply") / (600 * diagonal_volume(heights, -10)), 1, delta=1e-5)
        y = [p[1] for p in self.mesh("tif.ply").vertices]
        self.assertEqual((min(y), max(y)), (5000 - 20 * 7.5, 5000 - 20 * 0.5))

    def test_info_names_the_command(self):
        """One slice has no surface at an iso value."""
        numpy.save(self.folder / "h.npy", numpy.arange(20, dtype="f4").reshape(4, 5))
        Image.fromarray(numpy.arange(20, dtype="u1").reshape(4, 5)).save(self.folder / "h.png")
        run = self.run_program("info", "h.npy")
        self.assert_fails(2, run, "found shape (4, 5)", "make terrain of it with 'isoextract h.npy --heightfield -o h.glb'")
        run = self.convert("info", "h.png")
        self.assertIn("suggestion    --heightfield: terrain", run.text)
        self.assertNotIn("--iso", run.text)
        for line in (run.text.splitlines()[-1], "  isoextract h.npy --heightfield -o h.glb"):
            program, *arguments = line.split()
            self.assertEqual((program, arguments[1:]), ("isoextract", ["--heightfield", "-o", "h.glb"]))
            self.convert(*arguments)
        numpy.save(self.folder / "row.npy", numpy.arange(20, dtype="f4"))
        run = self.run_program("row.npy", "--iso", "1", "-o", "o.ply")
        self.assert_fails(2, run, "reshape the array in NumPy first")
        self.assertNotIn("--heightfield", run.err)

    def test_numbered_pictures_are_frames(self):
        for k in (1, 2):
            Image.fromarray(numpy.full((4, 5), 10 * k, "u1")).save(self.folder / f"h_{k}.png")
        self.convert("h_{}.png", "--heightfield", "--base", "0", "-o", "t_{}.ply")
        self.assertAlmostEqual(self.volume("t_2.ply"), 20 * 3 * 4, places=3)

    def test_edits_apply(self):
        heights = numpy.zeros((30, 40))
        heights[10:20, 10:20] = 5
        numpy.save(self.folder / "h.npy", heights)
        self.convert("h.npy", "--heightfield", "--base", "-1", "--simplify", "0.01", "-o", "s.ply")
        self.assertLess(len(self.mesh("s.ply").triangles), 500)
        self.assertEqual(self.open_edges("s.ply"), 0)
        self.convert("h.npy", "--heightfield", "--base", "-1", "--clip", "1,0,0,15", "--cap", "-o", "c.ply")
        self.assertEqual(self.open_edges("c.ply"), 0)

    def test_refusals(self):
        numpy.save(self.folder / "h.npy", numpy.ones((4, 5)))
        numpy.save(self.folder / "v.npy", numpy.ones((3, 4, 5)))
        self.assert_fails(2, self.run_program("h.npy", "--heightfield", "--base", "1", "-o", "t.ply"), "below all heights",
                          "--base")
        self.assert_fails(2, self.run_program("v.npy", "--heightfield", "-o", "t.ply"), "5 x 4 x 3 samples")
        self.assert_fails(1, self.run_program("h.npy", "--heightfield", "--iso", "1", "-o", "t.ply"), "no iso value")
        self.assert_fails(1, self.run_program("h.npy", "--base", "1", "--iso", "1", "-o", "t.ply"), "--heightfield")
        self.assert_fails(2, self.run_program("h.npy", "--iso", "1", "-o", "t.ply"), "--heightfield")


if __name__ == "__main__":
    main()
