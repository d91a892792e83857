"""--hollow: the outer surface stays, and the inner wall is at the asked distance from it, against formulas."""

import json
import math
import struct

from support import ProgramTest, main, read_ply

EXACT = 1e-5  # of a position in float32


def sphere(center, radius, spacing=(1, 1, 1)):
    return lambda *p: radius - math.dist([i * s for i, s in zip(p, spacing)], center)


class HollowTest(ProgramTest):
    def hollow(self, *arguments, thickness, name="out.ply"):
        """Returns the mesh, the vertices and triangles of the inner wall, and its entry in the report."""
        options = (*arguments, "--report", "r.json")
        self.convert(*options, "-o", "solid_" + name)
        self.last = self.convert(*options, "--hollow", thickness, "-o", name)
        solid = read_ply((self.folder / ("solid_" + name)).read_bytes())
        mesh = read_ply((self.folder / name).read_bytes())
        count = len(solid.vertices)
        self.assertEqual(mesh.vertices[:count], solid.vertices)
        self.assertEqual(mesh.triangles[:len(solid.triangles)], solid.triangles)
        inner = mesh.triangles[len(solid.triangles):]
        self.assertTrue(all(v >= count for t in inner for v in t))
        (record,) = json.loads((self.folder / "r.json").read_text())["hollows"]
        self.assertEqual(record["triangles"], len(inner))
        self.assertAlmostEqual(mesh.volume() + record["volume"], solid.volume(), delta=1e-4 * solid.volume())
        return mesh, mesh.vertices[count:], inner, record

    def is_printable(self, name="out.ply"):
        self.assertEqual(self.run_program("check", name, "--require", "printable").code, 0)

    def test_a_ball_has_a_wall_of_the_thickness(self):
        for spacing in ((1, 1, 1), (0.5, 1, 1.5)):
            with self.subTest(spacing=spacing):
                radius, thickness = 10, 2.5
                dims = [round(26 / s) + 1 for s in spacing]
                self.write_raw("ball.raw", dims, sphere((13, 13, 13), radius, spacing))
                _, vertices, _, record = self.hollow(
                    "ball.raw", "--dims", ",".join(map(str, dims)), "--dtype", "f32", "--iso", "0",
                    "--spacing", ",".join(map(str, spacing)), thickness=f"{thickness}world")
                for v in vertices:
                    # The triangles of the outer surface are up to 0.04 inside the sphere.
                    self.assertAlmostEqual(math.dist(v, (13, 13, 13)), radius - thickness, delta=0.06)
                self.assertEqual(record["cavities"], 1)
                true = 4 / 3 * math.pi * (radius - thickness) ** 3
                self.assertAlmostEqual(record["volume"] / true, 1, delta=0.02)
                self.assertIn("hollowed at iso 0: wall of 2.5; 1 cavity", self.last.err)
                self.is_printable()

    def test_a_box_has_exact_distances(self):
        """The surface of voxels is a box, so that the distance inside it has a formula."""
        low, high = (2, 2, 2), (17, 13, 11)
        self.write_raw("box.raw", (20, 16, 14), lambda *p: all(a <= i <= b for a, i, b in zip(low, p, high)), "B")
        spacing = (1, 2, 0.5)
        mesh, vertices, inner, record = self.hollow(
            "box.raw", "--dims", "20,16,14", "--dtype", "u8", "--iso", "0.5", "--method", "voxels", "--spacing",
            "1,2,0.5", thickness="1.25world")
        corners = [((a - 0.5) * s, (b + 0.5) * s) for a, b, s in zip(low, high, spacing)]

        def distance(p):
            return min(min(x - a, b - x) for x, (a, b) in zip(p, corners))

        for v in vertices:
            # The ends of grid edges are a thousandth of a cell away.
            self.assertAlmostEqual(distance(v), 1.25, delta=1e-3 * record["step"] + EXACT)
        middles = [distance([sum(mesh.vertices[v][i] for v in t) / 3 for i in range(3)]) for t in inner]
        self.assertGreater(min(middles), math.sqrt(1.25 ** 2 - record["step"] ** 2))
        self.assertLess(max(middles), 1.25 + record["step"])
        self.assertGreaterEqual(min(middles), record["min"] - EXACT)
        self.assertLessEqual(max(middles), record["max"] + EXACT)
        true = math.prod(b - a - 2.5 for a, b in corners)
        self.assertAlmostEqual(record["volume"] / true, 1, delta=0.01)
        self.is_printable()

    def test_a_turned_grid(self):
        """A rotation and a mirroring of the grid do not change the wall."""
        c, s = math.cos(0.4), math.sin(0.4)
        axes = [(c, s, 0), (-s * 1.5, c * 1.5, 0), (0, 0, -0.75)]
        dims = (28, 20, 38)
        values = []
        for k in range(dims[2]):
            for j in range(dims[1]):
                values += [9 - math.dist((i - 13.5, 1.5 * (j - 9.5), 0.75 * (k - 18.5)), (0, 0, 0))
                           for i in range(dims[0])]
        header = ("NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: 28 20 38\nencoding: raw\n"
                  "endian: little\nspace units: \"mm\" \"mm\" \"mm\"\nspace origin: (100,0,0)\nspace directions: "
                  + " ".join("(" + ",".join(map(repr, a)) + ")" for a in axes) + "\n\n")
        (self.folder / "ball.nrrd").write_bytes(header.encode() + struct.pack(f"<{len(values)}f", *values))
        center = [100 * (i == 0) + sum(a[i] * m for a, m in zip(axes, (13.5, 9.5, 18.5))) for i in range(3)]
        volumes = []
        for thickness in ("2mm", "0.2cm", "2world"):
            _, vertices, _, record = self.hollow("ball.nrrd", "--iso", "0", thickness=thickness)
            for v in vertices:
                self.assertAlmostEqual(math.dist(v, center), 7, delta=0.06)
            volumes.append(record["volume"])
        self.assertEqual(max(volumes), min(volumes))

    def test_cavities_and_several_bodies(self):
        """A wall goes around a cavity that is there. A body that is too thin stays solid."""
        def value(*p):
            big = min(12 - math.dist(p, (14, 14, 14)), math.dist(p, (14, 14, 14)) - 4)
            return max(big, 6 - math.dist(p, (36, 14, 14)), 1.9 - math.dist(p, (36, 14, 27)))

        self.write_raw("bodies.raw", (46, 32, 32), value)
        source = ("bodies.raw", "--dims", "46,32,32", "--dtype", "f32", "--iso", "0")
        mesh, vertices, _, record = self.hollow(*source, thickness="2voxel")
        self.assertEqual((record["cavities"], record["bodies"]), (2, 1))  # the wall around the cavity is loose
        self.assertIn("; 1 wall around a cavity of the surface does not touch the outer wall;", self.last.err)
        for v in vertices:
            if v[0] > 28:
                self.assertAlmostEqual(math.dist(v, (36, 14, 14)), 4, delta=0.1)
            else:
                radius = math.dist(v, (14, 14, 14))
                self.assertAlmostEqual(radius, 10 if radius > 8 else 6, delta=0.1)
        self.is_printable()
        self.convert(*source, "--hollow", "2voxel", "--split-components", "-o", "part_{piece}.ply")
        self.assertEqual([p for p in self.files() if p.startswith("part")], ["part_1.ply", "part_2.ply", "part_3.ply"])
        whole = sum(read_ply((self.folder / f"part_{n}.ply").read_bytes()).volume() for n in (1, 2, 3))
        self.assertAlmostEqual(whole, mesh.volume(), delta=1e-3 * whole)

    def test_what_stays_solid_or_open(self):
        self.write_raw("ball.raw", (12, 12, 12), sphere((5.5, 5.5, 5.5), 4))
        source = ("ball.raw", "--dims", "12,12,12", "--dtype", "f32", "--iso", "0")
        _, vertices, _, record = self.hollow(*source, thickness="5world")
        self.assertEqual((vertices, record["cavities"], record["min"]), ([], 0, None))
        self.assertIn("no part is thicker than two walls of 5world each, 5 in the units of the mesh", self.last.err)
        self.assertIn("a thinner wall can leave a cavity", self.last.err)
        self.assertNotIn("null", self.last.err)
        self.assertEqual(str(record["volume"]), "0.0")
        self.hollow(*source, thickness="30voxels")  # the plural, too
        self.assertIn("two walls of 30voxel each", self.last.err)
        # No grid is made where the whole surface is too thin: that of this wall would have 12,000 cells along each axis.
        self.hollow(*source, "--memory-limit", "64M", thickness="6000voxel")
        self.assertIn("hollowed at iso 0: no cavity", self.last.err)
        self.write_raw("cut.raw", (12, 12, 12), sphere((5.5, 5.5, 0), 4))
        cut = ("cut.raw", *source[1:], "--hollow", "1world")
        run = self.run_program(*cut, "-o", "cut.ply")
        self.assert_fails(2, run, "only a closed surface can be hollow", "boundary edges", "--cap")
        self.convert(*cut, "--cap", "-o", "cut.ply")
        self.is_printable("cut.ply")
        self.assert_fails(1, self.run_program(*source, "--hollow", "2", "-o", "x.ply"), "with its unit")
        self.assert_fails(2, self.run_program(*source, "--hollow", "2mm", "-o", "x.ply"), "neither the file nor an option states")
        self.assert_fails(2, self.run_program(*source, "--hollow", "1e-9world", "-o", "x.ply"), "error: ball.raw iso 0: a wall of 1e-09 is too thin")
        self.assert_fails(1, self.run_program(*source, "--hollow", "1world", "--error", "-o", "x.ply"), "--error")
        self.assertNotIn("x.ply", self.files())

    def test_a_mesh_file(self):
        self.convert("demo:sphere?size=24", "--iso", "0", "-o", "ball.stl")
        _, _, _, record = self.hollow("ball.stl", thickness="0.1world")
        self.assertEqual(record["cavities"], 1)
        self.is_printable()
        self.assert_fails(1, self.run_program("ball.stl", "--hollow", "1voxel", "-o", "x.ply"), "voxels")

    def test_with_other_edits(self):
        self.convert("demo:metaballs?size=40", "--iso", "0", "--hollow", "0.05world", "--smooth", "5", "--triangles", "50%",
                     "--require", "printable", "-o", "out.stl", "--report", "r.json")
        self.is_printable("out.stl")
        report = json.loads((self.folder / "r.json").read_text())
        self.assertLess(report["simplifications"][0]["triangles_after"],
                        report["simplifications"][0]["triangles_before"] * 0.51)


if __name__ == "__main__":
    main()
