"""--roi of particles: what lies far outside is left out first, and the surface inside stays as it is."""

import json
import random

from support import Png, ProgramTest, main, read_ply

RADIUS = 0.1
REGION = (-0.6, -0.5, -0.4, 0.5, 0.6, 0.3)
ROI = "--roi=" + ",".join(map(str, REGION))
# The same box by planes, which cut the surface of all particles.
PLANES = [word for axis in range(3) for side, at in ((1, REGION[axis]), (-1, REGION[axis + 3]))
          for word in ("--clip", ",".join(str(side * (k == axis)) for k in range(3)) + f",{side * at}")]


def blocks():
    """A jittered block with a hole, 2 x 2 x 2 units around the origin, and spray up to 8 units away."""
    jitter = random.Random(7)
    steps = [0.2 * i for i in range(-5, 6)]
    points = [(x, y, z) for x in steps for y in steps for z in steps if abs(x * x + y * y - 0.2) > 0.12 or z > 0.1]
    points += [tuple(jitter.uniform(-8, 8) for _ in range(3)) for _ in range(6000)]
    return [tuple(v + jitter.uniform(-0.04, 0.04) for v in p) for p in points]


class ParticleRegionTest(ProgramTest):
    def setUp(self):
        super().setUp()
        points = blocks()
        strays = [(1e8, 0, 0), (0, -3e9, 1)]
        for name, rows in (("all.csv", points), ("strays.csv", [*points[:50], *strays, *points[50:]])):
            (self.folder / name).write_text("x,y,z,heat\n" + "".join(f"{x!r},{y!r},{z!r},{x * y}\n" for x, y, z in rows))

    def surface(self, *arguments):
        self.convert(*arguments, "-o", "out.ply", "--report", "r.json")
        self.report = json.loads((self.folder / "r.json").read_text())
        return read_ply((self.folder / "out.ply").read_bytes())

    def assert_same(self, one, other, about):
        self.assertEqual(len(one.triangles), len(other.triangles), about)
        self.assertAlmostEqual(one.area() / other.area(), 1, delta=1e-6, msg=about)
        for a, b in zip(one.bounds(), other.bounds()):
            for k in range(3):
                self.assertAlmostEqual(a[k], b[k], delta=1e-6, msg=about)

    def test_the_surface_is_that_of_all_particles(self):
        for method in ("sph", "anisotropic", "weight", "spheres", "smooth"):
            options = ("--radius", RADIUS, "--particles", method)
            if method == "weight":
                options += ("--cell-size", 1, "--weight", 2)
            whole = self.surface("all.csv", *options, *PLANES)
            memory = self.report["reserved_memory_bytes"]
            part = self.surface("strays.csv", *options, ROI)
            self.assertGreater(len(part.triangles), 500)
            self.assert_same(part, whole, method)
            self.assertGreater(self.report["particles"]["outside_region"], 4000)
            self.assertLess(self.report["reserved_memory_bytes"], memory / 2, method)

    def vertices(self, *arguments):
        """Rows x, y, z, heat of the vertices, in an order that does not depend on the mesh's."""
        self.convert(*arguments, "--radius", RADIUS, "--blur", "2", "--attribute", "heat", "--ascii", "-o", "out.ply",
                     "--report", "r.json")
        lines = (self.folder / "out.ply").read_text().splitlines()
        self.assertIn("property float heat", lines)
        count = int(next(line for line in lines if line.startswith("element vertex")).split()[-1])
        first = lines.index("end_header") + 1
        return sorted(tuple(map(float, line.split())) for line in lines[first:first + count])

    def test_blurred_fields_and_attributes_are_those_of_all_particles(self):
        whole = self.vertices("all.csv", *PLANES)
        part = self.vertices("strays.csv", ROI)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertGreater(report["particles"]["outside_region"], 4000)
        self.assertGreater(len(part), 200)
        self.assertEqual(len(part), len(whole))

        def rounded(rows):
            return {tuple(round(1e4 * v) for v in row[:3]): row[3] for row in rows}

        far = rounded(whole)
        same = [abs(heat - far[key]) for key, heat in rounded(part).items() if key in far]
        self.assertGreater(len(same), 0.9 * len(part))  # others round to a neighboring place
        self.assertLess(max(same), 1e-3)

    def test_the_radius_fits_the_particles_inside(self):
        roi = "--roi=-1.1,-1.1,-1.1,1.1,1.1,1.1"
        self.surface("strays.csv", roi)
        self.assertAlmostEqual(self.report["particles"]["radius"], RADIUS, delta=0.05 * RADIUS)
        self.assertTrue(self.report["particles"]["radius_suggested"])
        # In a sequence as well.
        (self.folder / "s_1.csv").write_text((self.folder / "strays.csv").read_text())
        (self.folder / "s_2.csv").write_text((self.folder / "all.csv").read_text())
        run = self.convert("s_{}.csv", roi, "-o", "s_{}.ply", "--report", "s_{frame}.json")
        self.assertRegex(run.err, r"all frames have the radius 0\.(09|10)\d*, ")

    def test_explanations_count_them(self):
        run = self.convert("strays.csv", "--radius", RADIUS, ROI, "--explain", "-o", "out.ply")
        self.assertRegex(run.err, r"left out: \d+ of \d+ particles, so far outside the region")
        for more in (("--resolution", "40"), ("--space", "index")):
            self.surface("all.csv", "--radius", RADIUS, "--roi=-9,-9,-9,9,9,9", *more)
            self.assertIsNone(self.report["particles"]["outside_region"])

    def test_pictures_show_the_whole_field(self):
        shown = ("render", "all.csv", "--radius", RADIUS, "--size", "80x60", "--iso", "0.6")
        self.convert(*shown, "-o", "a.png")
        run = self.convert(*shown, ROI, "-o", "b.png")
        self.assertIn("--roi cuts only the surfaces", run.err)

        def drawn(name):
            png = Png((self.folder / name).read_bytes())
            pixels = [png.bytes[at:at + png.channels] for at in range(0, len(png.bytes), png.channels)]
            return sum(pixel != pixels[0] for pixel in pixels)

        self.assertGreater(drawn("b.png"), 0.8 * drawn("a.png"))

    def test_a_region_without_particles(self):
        run = self.run_program("strays.csv", "--radius", RADIUS, "--roi", "30,30,30,31,31,31", "-o", "out.ply")
        self.assert_fails(2, run, "none of 7", "lies in the region (30, 30, 30) .. (31, 31, 31)", "--roi", "--empty")
        self.convert("strays.csv", "--radius", RADIUS, "--roi", "30,30,30,31,31,31", "--empty", "write", "-o", "out.ply")

    def test_a_periodic_box_has_the_images_of_its_particles(self):
        jitter = random.Random(3)

        def is_in_balls(p):
            """One ball around the corner of the box, one in its middle."""
            corner = sum((v - 8 * (v > 4)) ** 2 for v in p)
            return corner < 3 or sum((v - 4) ** 2 for v in p) < 1.5

        points = [p for p in ([jitter.uniform(0, 8) for _ in range(3)] for _ in range(30000)) if is_in_balls(p)]
        (self.folder / "box.xyz").write_text(
            f"{len(points)}\n" 'Lattice="8 0 0 0 8 0 0 0 8" Properties=species:S:1:pos:R:3\n' +
            "".join("H {} {} {}\n".format(*p) for p in points))
        for method, *more in (("sph", "--smoothing-length", 1), ("spheres",)):
            options = ("box.xyz", "--radius", 0.15, "--particles", method, *more)
            whole = self.surface(*options, "--clip", "1,0,0,7.2", "--clip", "0,-1,0,-0.8")
            part = self.surface(*options, "--roi", "7.2,0,0,8,0.8,8")
            self.assertGreater(self.report["particles"]["outside_region"], 100)
            self.assertGreater(len(part.triangles), 100)
            self.assert_same(part, whole, method)


if __name__ == "__main__":
    main()
