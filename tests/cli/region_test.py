"""Surfaces of a --roi end at the faces of its box, wherever the samples are. The whole surface, clipped here polygon by
polygon, says what each part must have."""

import json
import math
import struct

from support import SOURCE, SPHERE, ProgramTest, main, read_glb, read_ply

WHOLE = "-2,-2,-2,2,2,2"
# No face on a sample of demo:sphere?size=24, whose spacing is 2.5 / 23.
BOXES = ("-2,-2,-2,0.03,2,2", "0.03,-2,-2,2,2,2")
CORNER = "-0.41,-0.52,-0.33,0.62,0.71,0.27"


def clipped(polygon, axis, sign, offset):
    """The part of a convex polygon where sign * p[axis] >= sign * offset (Sutherland and Hodgman)."""
    kept = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        depth_a, depth_b = (sign * (p[axis] - offset) for p in (a, b))
        if depth_a >= 0:
            kept.append(a)
        if (depth_a < 0) != (depth_b < 0):
            t = depth_a / (depth_a - depth_b)
            kept.append(tuple(p + t * (q - p) for p, q in zip(a, b)))
    return kept


def area_of(polygon):
    total = [0.0, 0.0, 0.0]
    for a, b in zip(polygon[1:], polygon[2:]):
        u, v = ([q - p for p, q in zip(polygon[0], other)] for other in (a, b))
        for i in range(3):
            total[i] += u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2]
    return math.hypot(*total) / 2


def area_in(mesh, box):
    """Of a mesh, the area within a box."""
    low_high = [float(number) for number in box.split(",")]
    total = 0.0
    for triangle in mesh.triangles:
        polygon = [mesh.vertices[i] for i in triangle]
        for axis in range(3):
            for sign, offset in ((1, low_high[axis]), (-1, low_high[3 + axis])):
                polygon = polygon and clipped(polygon, axis, sign, offset)
        total += area_of(polygon)
    return total


class RegionTest(ProgramTest):
    def mesh(self, *arguments, name="a.ply"):
        self.convert(*arguments, "-o", name)
        data = (self.folder / name).read_bytes()
        return next(iter(read_glb(data).values())) if name.endswith(".glb") else read_ply(data)

    def box_of(self, mesh):
        return ",".join(repr(number) for corner in mesh.bounds() for number in corner)

    def assert_in(self, mesh, box, delta=1e-6):
        low_high = [float(number) for number in box.split(",")]
        low, high = mesh.bounds()
        for axis in range(3):
            self.assertGreaterEqual(low[axis], low_high[axis] - delta)
            self.assertLessEqual(high[axis], low_high[3 + axis] + delta)

    def test_parts_have_the_area_that_the_whole_has_in_their_boxes(self):
        for method in ("mc", "mt"):
            sphere = (SPHERE, "--iso", "0", "--method", method)
            whole = self.mesh(*sphere)
            parts = [self.mesh(*sphere, "--roi", box) for box in BOXES]
            for part, box in zip(parts, BOXES):
                self.assert_in(part, box)
                self.assertAlmostEqual(area_in(part, WHOLE), area_in(whole, box), delta=1e-6)
            self.assertAlmostEqual(sum(area_in(part, WHOLE) for part in parts), area_in(whole, WHOLE), delta=1e-6)
            # Both sides have the same vertices in the plane, bit for bit.
            rims = [{v for v in part.vertices if abs(v[0] - 0.03) < 1e-6} for part in parts]
            self.assertEqual(*rims)
            self.assertGreater(len(rims[0]), 20)
            corner = self.mesh(*sphere, "--roi", CORNER)
            self.assert_in(corner, CORNER)
            self.assertAlmostEqual(area_in(corner, WHOLE), area_in(whole, CORNER), delta=1e-6)

    def test_capped_parts_have_the_volume_of_the_whole(self):
        sphere = (SPHERE, "--iso", "0", "--normals", "none")
        whole = self.mesh(*sphere).volume()
        parts = [self.mesh(*sphere, "--cap", "--roi", box) for box in BOXES]
        for part in parts:
            self.assertEqual(part.open_edges(), 0)
        self.assertAlmostEqual(sum(part.volume() for part in parts), whole, delta=1e-6)
        # All of a box is inside of a sphere around it.
        inner = self.mesh(*sphere, "--cap", "--roi", "-0.31,-0.22,-0.13,0.34,0.27,0.18")
        self.assertEqual(inner.open_edges(), 0)
        self.assertAlmostEqual(inner.volume(), 0.65 * 0.49 * 0.31, delta=1e-6)
        self.assert_in(inner, "-0.31,-0.22,-0.13,0.34,0.27,0.18")

    def test_a_region_within_a_cell(self):
        self.write_raw("ramp.raw", (4, 4, 4), lambda x, y, z: float(x))
        ramp = ("ramp.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5")
        part = self.mesh(*ramp, "--roi", "1.25,1.25,1.125,1.75,1.5,1.875")
        self.assertAlmostEqual(area_in(part, "0,0,0,3,3,3"), 0.25 * 0.75, delta=1e-7)
        self.assert_fails(2, self.run_program(*ramp, "--roi", "3,1.25,1.125,4,1.5,1.875", "-o", "b.ply"),
                          "contains no cell of the data along x", "(0, 0, 0) .. (3, 3, 3)")
        # The surface is in a cell that the box touches, and not in the box.
        self.assert_fails(2, self.run_program(*ramp, "--roi", "1.6,1,1,3,2,2", "-o", "b.ply"),
                          "clipping removes the whole surface at iso 1.5", "give a larger --roi X0,Y0,Z0,X1,Y1,Z1")

    def test_axes_that_are_exchanged_and_mirrored(self):
        header = ("NRRD0004\ntype: float\ndimension: 3\nsizes: 6 7 8\nencoding: raw\nendian: little\n"
                  "space: right-anterior-superior\nspace directions: (0,-2,0) (0,0,3) (-4,0,0)\nspace origin: (10,20,30)\n\n")
        values = [math.sin(x) + math.cos(1.3 * y) + math.sin(0.7 * z) for z in range(8) for y in range(7) for x in range(6)]
        (self.folder / "turned.nrrd").write_bytes(header.encode() + struct.pack("<336f", *values))
        whole = self.mesh("turned.nrrd", "--iso", "0.3")
        for box in ("-9.5,11.3,31,3,17,44", "-30,11.3,31,3,40,44", "-17,10,30,10,19.1,48"):
            part = self.mesh("turned.nrrd", "--iso", "0.3", "--roi", box)
            self.assert_in(part, box, 1e-5)
            self.assertAlmostEqual(area_in(part, "-99,-99,-99,99,99,99") / area_in(whole, box), 1, delta=1e-6)
            closed = self.mesh("turned.nrrd", "--iso", "0.3", "--roi", box, "--cap")
            self.assertEqual(closed.open_edges(), 0)
            self.assertGreater(closed.volume(), 0)

    def test_faces_on_samples_cut_nothing(self):
        self.write_raw("waves.raw", (9, 9, 9), lambda x, y, z: math.sin(x) + math.cos(1.3 * y) + math.sin(0.7 * z))
        waves = ("waves.raw", "--dims", "9,9,9", "--dtype", "f32", "--iso", "0.3", "--spacing", "0.1")
        for cap in ((), ("--cap",)):
            exact, snapped = (self.mesh(*waves, *cap, *snap, "--roi", "0.2,0.1,0.3,0.6,0.7,9", name=f"{len(snap)}.ply")
                              for snap in ((), ("--roi-snap",)))
            self.assertEqual((self.folder / "0.ply").read_bytes(), (self.folder / "1.ply").read_bytes())
            self.assertEqual(exact.triangles, snapped.triangles)
        # Between samples, it ends at those within.
        run = self.convert(*waves, "--roi-snap", "--roi", "0.15,0.05,0.25,0.65,0.75,9", "-o", "2.ply")
        self.assertIn("note[region-at-samples]: waves.raw: the faces of the region lie between samples, so surfaces end at the 5 x 7 x 6 samples "
                      "inside the region\n", run.err)
        self.convert(*waves, "--roi", "0.2,0.1,0.3,0.6,0.7,9", "-o", "3.ply")
        self.assertEqual((self.folder / "2.ply").read_bytes(), (self.folder / "3.ply").read_bytes())
        self.assert_fails(1, self.run_program(*waves, "--roi-snap", "-o", "b.ply"), "--roi-snap", "--roi X0,Y0,Z0,X1,Y1,Z1")

    def test_only_bricks_that_the_box_touches_are_visited(self):
        bricks = {}
        for name, roi in (("part", ("--roi", "-0.3,-0.3,0.5,0.3,0.3,1.2")), ("whole", ())):
            self.convert("demo:sphere?size=200", "--iso", "0", *roi, "--explain", "-o", "a.ply", "--report", "r.json")
            facts = json.loads((self.folder / "r.json").read_text())["extractions"][0]["work"]
            bricks[name] = next(fact["count"] for fact in facts if fact["what"] == "samples")
        self.assertLess(bricks["part"], bricks["whole"] / 20)

    def test_the_middle_of_the_box_is_centered(self):
        part = self.mesh(SPHERE, "--iso", "0", "--cap", "--center", "--roi", "-0.31,-0.22,-0.13,0.34,0.27,0.18")
        for low, high, half in zip(*part.bounds(), (0.325, 0.245, 0.155)):
            self.assertAlmostEqual(low, -half, delta=1e-6)
            self.assertAlmostEqual(high, half, delta=1e-6)

    def test_the_line_of_a_file_says_where_it_was_cut(self):
        cut = (SPHERE, "--iso", "0", "--roi", BOXES[0])
        self.assertIn("; open at the boundary of --roi (--cap closes it); ", self.convert(*cut, "-o", "a.ply").err)
        self.assertIn("; closed; ", self.convert(*cut, "--cap", "-o", "a.ply").err)
        # All of the surface is in the box.
        run = self.convert(SPHERE, "--iso", "0", "--roi=-1.01,-1.02,-1.03,1.01,1.02,1.03", "-o", "a.ply")
        self.assertIn("; closed; ", run.err)
        self.assertNotIn("cut", run.err)
        both = self.convert(*cut, "--clip", "0,1,0,0.1", "-o", "a.ply").err
        self.assertIn("(--cap closes it); ", both)

    def test_what_follows_the_cut(self):
        roi = ("--roi", CORNER)
        for more in (("--simplify", "0.2"), ("--smooth", "5"), ("--error",), ("--largest",), ("--verify",),
                     ("--attribute", f"d={SPHERE}"), ("--cap", "--simplify", "0.2"), ("--cap", "--error"),
                     ("--resolution", "31"), ("--method", "mt", "--cap", "--smooth", "3")):
            if "--attribute" in more:
                self.write_raw("x.raw", (24, 24, 24), lambda x, y, z: float(x))
            run = self.convert(SPHERE, "--iso", "0", *roi, *more, "-o", "a.ply")
            mesh = read_ply((self.folder / "a.ply").read_bytes())
            self.assertGreater(len(mesh.triangles), 10)
            self.assert_in(mesh, CORNER, 1e-2 if "--simplify" in more or "--smooth" in more else 1e-6)
            if "--cap" in more:
                self.assertEqual(mesh.open_edges(), 0, run.err)
        edited = (SPHERE, "--iso", "0", *roi, "--cap", "--simplify", "0.2")
        self.convert(*edited, "-o", "a.ply")
        self.convert("verify", *edited, "a.ply")

    def test_help_says_where_the_surface_of_a_part_ends(self):
        for told in (self.convert("help", "coordinates").out.decode(), (SOURCE / "man/isoextract.1").read_text()):
            told = " ".join(told.replace("\\", "").split())
            self.assertIn("The surface ends exactly at its faces", told)
            self.assertNotIn("the smallest box of samples that covers it", told)

    def test_error_of_a_part_is_that_of_its_triangles(self):
        errors = []
        for roi in ((), ("--roi", CORNER)):
            self.convert("demo:sphere?size=24", "--iso", "0", *roi, "--error", "-o", "a.ply", "--report", "r.json")
            mesh = json.loads((self.folder / "r.json").read_text())["meshes"][0]
            errors.append(mesh["error"]["interior"]["rms"]["voxels"])
        self.assertAlmostEqual(errors[1] / errors[0], 1, delta=0.5)


if __name__ == "__main__":
    main()
