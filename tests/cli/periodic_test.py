"""Periodic boxes of simulations: read, shown, and surfaces that continue from each face to the opposite one."""

import json
import random

from support import ProgramTest, main, read_ply

RADIUS = 0.25
CUBE = ((1, -2, 3), ((6, 0, 0), (0, 6, 0), (0, 0, 6)))
SHEARED = ((1, -2, 3), ((6, 0, 0), (1.5, 5.5, 0), (-1, 2, 5)))


def along(box, fractions):
    origin, edges = box
    return tuple(origin[k] + sum(edges[e][k] * fractions[e] for e in range(3)) for k in range(3))


def ball(center, size=1.4):
    """Particles of a ball, a little off a lattice."""
    jitter = random.Random(3)
    steps = [0.5 * i for i in range(-3, 4)]
    return [tuple(center[k] + p[k] + jitter.uniform(-0.05, 0.05) for k in range(3))
            for p in ((x, y, z) for x in steps for y in steps for z in steps)
            if p[0] ** 2 + p[1] ** 2 + p[2] ** 2 < size ** 2]


def lammps(points, box=CUBE, flags="pp pp pp", step=0, columns="x y z", more=None):
    (x, y, z), (a, b, c) = box
    xy, xz, yz = b[0], c[0], c[1]
    bounds = [(x + min(0, xy, xz, xy + xz), x + a[0] + max(0, xy, xz, xy + xz), xy),
              (y + min(0, yz), y + b[1] + max(0, yz), xz), (z, z + c[2], yz)]
    tilted = (xy, xz, yz) != (0, 0, 0)
    lines = ["ITEM: TIMESTEP", step, "ITEM: NUMBER OF ATOMS", len(points),
             "ITEM: BOX BOUNDS " + ("xy xz yz " if tilted else "") + flags]
    lines += [" ".join(str(v) for v in row[:3 if tilted else 2]) for row in bounds]
    lines += ["ITEM: ATOMS " + columns]
    lines += [" ".join(repr(v) for v in (*p, *(more(p) if more else ()))) for p in points]
    return "\n".join(str(line) for line in lines) + "\n"


class PeriodicTest(ProgramTest):
    def write(self, name, text):
        (self.folder / name).write_text(text)
        return name

    def mesh(self, name):
        return read_ply((self.folder / name).read_bytes())

    def info(self, *arguments):
        return json.loads(self.run_program("info", *arguments, "--json").out)[0]["particles"]

    def surface(self, name, *options):
        """The converted mesh, and stderr."""
        run = self.convert(name, "--radius", RADIUS, "-o", "out.ply", *options)
        return self.mesh("out.ply"), run.err

    def test_info_shows_the_box_of_lammps(self):
        self.write("a.lammpstrj", lammps(ball((3, 0, 5))))
        self.assertEqual(self.info("a.lammpstrj")["box"],
                         {"origin": [1, -2, 3], "edges": [[6, 0, 0], [0, 6, 0], [0, 0, 6]], "periodic": [True] * 3})
        text = self.run_program("info", "a.lammpstrj").text
        self.assertRegex(text, r"box +\(1, -2, 3\) \.\. \(7, 4, 9\)")
        self.assertRegex(text, r"periodic +x, y, z")
        self.write("b.lammpstrj", lammps(ball((3, 0, 5)), SHEARED, "pp ff pp"))
        box = self.info("b.lammpstrj")["box"]
        self.assertEqual((box["origin"], box["edges"]), ([1, -2, 3], [[6, 0, 0], [1.5, 5.5, 0], [-1, 2, 5]]))
        self.assertEqual(box["periodic"], [True, False, True])

    def test_info_shows_the_lattice_of_extended_xyz(self):
        points = "".join("H {} {} {}\n".format(*p) for p in ball((3, 0, 5)))
        head = f"{len(ball((3, 0, 5)))}\n"
        lattice = 'Lattice="6 0 0 1.5 5.5 0 -1 2 5" Properties=species:S:1:pos:R:3'
        for more, origin, periodic in (("", [0, 0, 0], [True] * 3),
                                       (' pbc="T F T" Origin="1 -2 3"', [1, -2, 3], [True, False, True]),
                                       (' pbc="[F, F, F]"', [0, 0, 0], [False] * 3)):
            self.write("a.xyz", head + lattice + more + "\n" + points)
            self.assertEqual(self.info("a.xyz")["box"], {"origin": origin, "periodic": periodic,
                                                         "edges": [[6, 0, 0], [1.5, 5.5, 0], [-1, 2, 5]]})
        self.write("b.xyz", head + "no lattice\n" + points)
        self.assertIsNone(self.info("b.xyz")["box"])
        for wrong in ('Lattice="6 0 0"', 'Lattice="1 0 0 0 1 0 2 2 0"', 'Lattice="nan 0 0 0 1 0 0 0 1"'):
            self.write("c.xyz", head + wrong + "\n" + points)
            described = self.info("c.xyz")
            self.assertIsNone(described["box"])
            self.assertIn("box-ignored", [note["id"] for note in described["notes"]])

    def test_a_ball_across_the_corner_is_the_ball_inside(self):
        for box in (CUBE, SHEARED):
            self.write("in.lammpstrj", lammps(ball(along(box, (0.5, 0.5, 0.5))), box))
            inside, said = self.surface("in.lammpstrj")
            self.assertIn("note[periodic-box]", said)
            self.assertIn("the box is periodic along " + ("x, y, z" if box is CUBE else "a, b, c"), said)
            self.assertIn("closed", said)
            # Whole cells: the lengths of the edges over the spacing of 0.75 radii, rounded.
            lengths = [sum(v * v for v in edge) ** 0.5 for edge in box[1]]
            cells = [round(length / (0.75 * RADIUS)) for length in lengths]
            for moved in ((1, 0, 0), (1, 1, 0), (1, 1, 1)):
                place = along(box, [0.5 + m * (n // 2) / n for m, n in zip(moved, cells)])
                self.write("over.lammpstrj", lammps(ball(place), box))
                over, said = self.surface("over.lammpstrj")
                self.assertIn("open at the faces of the periodic box (--cap closes it)", said)
                self.assertEqual(len(over.triangles), len(inside.triangles))
                self.assertAlmostEqual(over.area(), inside.area(), delta=1e-4 * inside.area())
                capped, said = self.surface("over.lammpstrj", "--cap")
                self.assertIn("closed", said)
                self.assertEqual(capped.open_edges(), 0)
                self.assertAlmostEqual(capped.volume(), inside.volume(), delta=1e-4 * inside.volume())
            single, said = self.surface("over.lammpstrj", "--periodic", "none")
            self.assertNotIn("periodic", said)
            self.assertEqual(single.open_edges(), 0)

    def test_a_filled_lattice_has_no_surface(self):
        points = [tuple(CUBE[0][k] + 0.5 * p[k] for k in range(3))
                  for p in ((x, y, z) for x in range(12) for y in range(12) for z in range(12))]
        self.write("full.lammpstrj", lammps(points))
        run = self.run_program("full.lammpstrj", "--radius", RADIUS, "-o", "out.ply")
        self.assert_fails(2, run, "no surface")
        capped, _ = self.surface("full.lammpstrj", "--cap")
        self.assertAlmostEqual(capped.volume(), 216, delta=1e-3)

    def test_box_and_periodic_replace_those_of_the_file(self):
        over = ball((7, 4, 9))
        self.write("a.csv", "x,y,z\n" + "".join("{},{},{}\n".format(*p) for p in over))
        self.write("a.lammpstrj", lammps(over))
        expected, _ = self.surface("a.lammpstrj")
        given, _ = self.surface("a.csv", "--box", "1,-2,3,7,4,9")
        self.assertEqual(len(given.triangles), len(expected.triangles))
        one, _ = self.surface("a.csv", "--box", "1,-2,3,7,4,9", "--periodic", "x")
        self.write("b.lammpstrj", lammps(over, flags="pp ff ss"))
        also, _ = self.surface("b.lammpstrj")
        self.assertEqual(len(one.triangles), len(also.triangles))
        self.assertEqual(len(one.triangles), len(expected.triangles))
        run = self.run_program("a.csv", "--radius", RADIUS, "--periodic", "x,y,z", "-o", "out.ply")
        self.assert_fails(2, run, "expected the box of the simulation, found none", "--box")
        for wrong in ("x,x", "w", "", "x,", "none,x"):
            run = self.run_program("a.csv", "--periodic", wrong, "-o", "out.ply")
            self.assert_fails(1, run, "none, or one or more of x,y,z with commas")
        run = self.run_program("a.csv", "--radius", RADIUS, "--box", "1,1,1,2,2,1", "-o", "out.ply")
        self.assert_fails(1, run, "expected a box with sides longer than 0")

    def test_unwrapped_bodies_are_whole(self):
        whole = ball((7, 1, 6))  # across the face x = 7 of the box
        wrapped = [(p[0] - 6 if p[0] >= 7 else p[0], p[1], p[2]) for p in whole]
        flags = {w: (1 if p[0] >= 7 else 0, 0, 0) for w, p in zip(wrapped, whole)}
        self.write("a.lammpstrj", lammps(wrapped, columns="x y z ix iy iz", more=lambda p: flags[p]))
        self.write("b.lammpstrj", lammps(whole, flags="ff ff ff"))
        unwrapped, said = self.surface("a.lammpstrj", "--unwrap")
        expected, _ = self.surface("b.lammpstrj")
        self.assertEqual(len(unwrapped.triangles), len(expected.triangles))
        self.assertEqual(unwrapped.open_edges(), 0)
        self.assertNotIn("periodic", said)
        run = self.run_program("b.lammpstrj", "--radius", RADIUS, "--unwrap", "-o", "out.ply")
        self.assert_fails(2, run, "expected the image flags ix, iy and iz to unwrap the positions, found no ix")
        run = self.run_program("a.lammpstrj", "--unwrap", "--periodic", "x", "-o", "out.ply")
        self.assert_fails(1, run, "--unwrap and --periodic contradict each other")
        self.write("c.lammpstrj", lammps([(p[0] + 6, *p[1:]) for p in whole], columns="x y z ix iy iz",
                                         more=lambda p: (1, 0, 0)))
        run = self.run_program("c.lammpstrj", "--radius", RADIUS, "--unwrap", "-o", "out.ply")
        self.assert_fails(2, run, "the file has unwrapped positions")

    def test_a_sequence_has_the_box_of_each_frame(self):
        text = ""
        for step, size in enumerate((6, 6.6, 7.2)):
            box = ((1, -2, 3), ((size, 0, 0), (0, size, 0), (0, 0, size)))
            text += lammps(ball(along(box, (0, 0.5, 0.5))), box, step=step)
        self.write("run.lammpstrj", text)
        self.convert("run.lammpstrj", "--volume", "all", "--radius", RADIUS, "--cap", "-o", "o_{}.ply")
        for step, size in enumerate((6, 6.6, 7.2)):
            low, high = self.mesh(f"o_{step}.ply").bounds()
            self.assertAlmostEqual(low[0], 1, places=5)
            self.assertAlmostEqual(high[0], 1 + size, places=5)

    def test_a_region_ends_at_the_box(self):
        self.write("a.lammpstrj", lammps(ball((7, 1, 6))))
        part, _ = self.surface("a.lammpstrj", "--roi", "0,-2,3,4,4,9", "--cap")
        low, high = part.bounds()
        self.assertAlmostEqual(low[0], 1, places=5)
        self.assertLess(high[0], 3)
        run = self.run_program("a.lammpstrj", "--radius", RADIUS, "--roi", "20,-2,3,24,4,9", "-o", "out.ply")
        self.assert_fails(2, run, "the region contains no cell of the periodic box")

    def test_resampling_is_refused(self):
        self.write("a.lammpstrj", lammps(ball((7, 1, 6))))
        run = self.run_program("a.lammpstrj", "--radius", RADIUS, "--resolution", "40", "-o", "out.ply")
        self.assert_fails(1, run, "--cell-size")

    def test_the_report_has_the_box(self):
        self.write("a.lammpstrj", lammps(ball((7, 1, 6)), SHEARED, "pp pp ff"))
        self.convert("a.lammpstrj", "--radius", RADIUS, "-o", "out.ply", "--report", "report.json")
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(report["particles"]["simulation_box"],
                         {"origin": [1, -2, 3], "edges": [[6, 0, 0], [1.5, 5.5, 0], [-1, 2, 5]],
                          "periodic": [True, True, False]})
        self.assertEqual(report["options"]["particles"]["simulation_box"],
                         {"bounds": None, "periodic": None, "unwrap": False})


if __name__ == "__main__":
    main()
