"""Particles at the limits: headers that lie, packed bombs, places that are no numbers, one particle or many at one place,
far away, far apart, too large and too small."""

import gzip
import json
import math
import struct

from support import ProgramTest, main, processor_time_below, read_glb, read_obj, read_ply

from particle_clouds import polygons_of_ply, volume_of  # where `support` looks for modules

MIB = 1 << 20
# The program and its libraries, the stacks of its threads, and small allocations without a reservation.
OVERHEAD = 64 * MIB
STEP = 0.0625  # of lattices; powers of two, so that a set can be moved without rounding
RADIUS = STEP / 2
SPACING = 0.75 * RADIUS
# Where samples are relative to particles is the same there: whole bricks of eight samples.
FAR = (2 ** 26 * 8 * SPACING, -(2 ** 26) * 8 * SPACING, 2 ** 26 * 8 * SPACING)
METHODS = ("sph", "anisotropic", "weight")


def block(n, at=(0.0, 0.0, 0.0), step=STEP):
    """n^3 particles on a lattice."""
    return [tuple(at[axis] + step * index[axis] for axis in range(3)) for index in
            ((i, j, k) for i in range(n) for j in range(n) for k in range(n))]


def ply(points, count=None, kind="double"):
    code = {"double": "d", "float": "f"}[kind]
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points) if count is None else count}\n"
    head += "".join(f"property {kind} {axis}\n" for axis in "xyz") + "end_header\n"
    return head.encode() + b"".join(struct.pack(f"<3{code}", *p) for p in points)


def ply_text(points, count=None):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points) if count is None else count}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    return (head + "".join("{!r} {!r} {!r}\n".format(*p) for p in points)).encode()


def bgeo(points, count=None):
    head = b"BgeoV" + struct.pack(">9i", 5, len(points) if count is None else count, *[0] * 7)
    return head + b"".join(struct.pack(">4f", *p, 1) for p in points) + b"\0\0"


def npy(points, count=None):
    shape = (len(points) if count is None else count, 3)
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + b"".join(
        struct.pack("<3d", *p) for p in points)


def xyz(points, count=None):
    head = f"{len(points) if count is None else count}\na frame\n"
    return (head + "".join("W {!r} {!r} {!r}\n".format(*p) for p in points)).encode()


def lammps(points, count=None):
    head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(points) if count is None else count}\n"
    head += "ITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS x y z\n"
    return (head + "".join("{!r} {!r} {!r}\n".format(*p) for p in points)).encode()


def csv(points, count=None):
    assert count is None  # a table has no count
    return ("x,y,z\n" + "".join("{!r},{!r},{!r}\n".format(*p) for p in points)).encode()


# By the name of a file: what writes it, and the largest number that its header can tell of.
COUNTED = {"a.ply": (ply, 2 ** 62), "b.ply": (ply_text, 2 ** 62), "a.bgeo": (bgeo, 2 ** 31 - 1), "a.npy": (npy, 2 ** 60),
           "a.xyz": (xyz, 2 ** 62), "a.dump": (lammps, 2 ** 62)}
FORMATS = {**{name: write for name, (write, _) in COUNTED.items()}, "a.csv": csv}


class ParticleLimitsTest(ProgramTest):
    def write(self, name, data):
        (self.folder / name).write_bytes(data)
        return name

    def take(self, name, *options):
        """The arguments that read a file as particles."""
        return (name, "--particles", "sph", *options) if name.endswith(".npy") else (name, *options)

    def mesh(self, name):
        return read_ply((self.folder / name).read_bytes())

    def volume(self, *arguments):
        """Of a conversion's mesh, which must be closed."""
        run = self.convert(*arguments, "-o", "volume.ply", "--report", "report.json")
        (facts,) = self.report()["meshes"]
        self.assertTrue(facts["closed"], run.err)
        self.assertEqual(facts["nonmanifold_edges"], 0)
        vertices, polygons = polygons_of_ply(self.folder / "volume.ply")
        self.assertAlmostEqual(facts["volume"] / volume_of(vertices, polygons), 1, delta=1e-3)
        return facts["volume"]

    def report(self):
        return json.loads((self.folder / "report.json").read_text())

    def refused_within(self, peak, code, arguments, *parts):
        """No mesh, no part of one, and no more memory than that."""
        with processor_time_below(20, arguments):
            run = self.run_program(*arguments, "-o", "out.ply", "--report", "report.json", "-q")
        self.assert_fails(code, run, *parts)
        self.assertLess(self.report()["peak_memory_bytes"], peak, arguments)
        self.assertEqual([name for name in self.files() if name.startswith(("out", "."))], [])

    def test_a_header_that_tells_of_more_than_there_is(self):
        for name, (write, most) in COUNTED.items():
            for count in (9, 10 ** 6, most):
                with self.subTest(name=name, count=count):
                    self.write(name, write(block(2), count))
                    self.refused_within(OVERHEAD, 2, self.take(name), name)
                    run = self.run_program("info", *self.take(name))
                    self.assertIn(run.code, (0, 2), run.err)  # the header alone may be listed

    def test_a_header_that_lies_in_a_packed_file(self):
        for name, (write, most) in COUNTED.items():
            if name.endswith(".npy"):
                continue  # not read packed
            with self.subTest(name=name):
                packed = name if name.endswith(".bgeo") else name + ".gz"
                self.write(packed, gzip.compress(write(block(2), most)))
                self.refused_within(OVERHEAD, 2, (packed,), packed)

    def write_packed(self, name, head, part, times):
        """Piece by piece: a process begins with the peak of the one that made it."""
        with gzip.open(self.folder / name, "wb", compresslevel=1) as file:
            file.write(head)
            for _ in range(times):
                file.write(part)
        self.assertLess((self.folder / name).stat().st_size, MIB)

    def test_packed_bombs_are_held_against_the_memory_limit(self):
        count = 2 * 10 ** 6
        for name, head, part in (("bomb.bgeo", bgeo([], count)[:-2], bytes(16000)),
                                 ("bomb.csv.gz", b"x,y,z\n", b"0,0,0\n" * 1000),
                                 ("bomb.xyz.gz", f"{count}\n\n".encode(), b"0 0 0\n" * 1000),
                                 ("bomb.ply.gz", ply([], count), bytes(24000))):
            with self.subTest(name=name):
                self.write_packed(name, head, part, count // 1000)
                self.refused_within(16 * MIB + OVERHEAD, 2, (name, "--radius", 1, "--memory-limit", "16M"),
                                    f"{count} particles would take", "--memory-limit")

    def test_a_packed_line_without_an_end(self):
        self.write_packed("line.csv.gz", b"", b"1" * MIB, 64)
        self.refused_within(OVERHEAD, 2, ("line.csv.gz", "--memory-limit", "16M"), "line 1: expected the end of a line within")

    def test_places_that_are_no_numbers_in_every_format(self):
        for name, write in FORMATS.items():
            for bad in (math.nan, math.inf, -math.inf):
                with self.subTest(name=name, bad=bad):
                    points = block(4)
                    points[5] = (0.0, bad, 0.0)
                    self.write(name, write(points))
                    options = ("--radius", RADIUS)
                    self.refused_within(OVERHEAD, 2, self.take(name, *options), "at particle 5", "--nan outside")
                    volume = self.volume(*self.take(name, *options), "--nan", "outside")
                    self.assertEqual(self.report()["particles"]["not_finite"], 1)
                    self.write(name, write([p for p in points if math.isfinite(p[1])]))
                    self.assertEqual(self.volume(*self.take(name, *options)), volume)

    def test_none_but_such_are_as_no_particles(self):
        self.write("a.csv", csv([(math.nan, 0.0, 0.0)] * 3))
        options = ("a.csv", "--nan", "outside", "--radius", 1)
        self.refused_within(OVERHEAD, 2, options, "there are no particles", "--empty skip")
        self.convert(*options, "--empty", "write", "-o", "a.ply")
        self.assertEqual(self.mesh("a.ply").vertices, [])

    def test_no_particles_in_every_format_and_by_every_method(self):
        for name, write in FORMATS.items():
            self.write(name, write([]))
            for method in METHODS if name == "a.ply" else ("sph",):
                with self.subTest(name=name, method=method):
                    options = (name, "--particles", method)
                    self.refused_within(OVERHEAD, 2, options, "there are no particles", "--empty skip")
                    self.convert(*options, "--empty", "skip", "-o", "none.ply")
                    self.assertNotIn("none.ply", self.files())
                    self.convert(*options, "--empty", "write", "-o", "none.ply")
                    self.assertEqual(self.mesh("none.ply").triangles, [])
                    (self.folder / "none.ply").unlink()

    def test_one_particle_by_every_method(self):
        self.write("one.csv", csv([(1.01, 2.02, 3.03)]))
        # The field is W / W(0): 0.6 at 0.31 of the support. Kernels of those that are alone are half as long and eight
        # times as high for anisotropic: 0.6 at 0.66 of half the support.
        for method, size in (("sph", 1.25), ("anisotropic", 1.33)):
            options = ("one.csv", "--radius", RADIUS, "--particles", method)
            expected = 4 / 3 * math.pi * (size * RADIUS) ** 3
            self.assertAlmostEqual(self.volume(*options) / expected, 1, delta=0.35)
            self.assertAlmostEqual(self.volume(*options, "--cell-size", 0.2) / expected, 1, delta=0.06)
        options = ("one.csv", "--radius", RADIUS, "--particles", "weight")
        # A particle by itself weighs less than the usual iso value.
        self.refused_within(OVERHEAD, 2, (*options, "--deposit", "nearest"), "--empty skip")
        self.assertLess(self.volume(*options, "--deposit", "nearest", "--weight", "0.3"), (2 * 4 * RADIUS) ** 3)
        self.assertGreater(self.volume(*options, "--deposit", "nearest", "--weight", "0.3"), 0)

    def test_many_at_one_place_are_as_one(self):
        self.write("one.csv", csv([(1.01, 2.02, 3.03)]))
        self.write("many.csv", csv([(1.01, 2.02, 3.03)] * 5000))
        for method in ("sph", "anisotropic"):
            options = ("--radius", RADIUS, "--particles", method)
            one = self.volume("one.csv", *options)
            self.assertAlmostEqual(self.volume("many.csv", *options) / one, 1, delta=1e-5)
        options = ("--radius", RADIUS, "--particles", "weight")
        self.assertGreater(self.volume("many.csv", *options), 0)
        self.refused_within(OVERHEAD, 2, ("many.csv",), "two or more positions", "give --radius R")

    def test_pairs_are_as_single_ones(self):
        points = block(6)
        self.write("single.csv", csv(points))
        self.write("pairs.csv", csv([p for p in points for _ in range(2)]))
        for method, delta in (("sph", 1e-5), ("anisotropic", 0.05)):
            single = self.volume("single.csv", "--particles", method)
            # The radius is found by those that are elsewhere.
            self.assertAlmostEqual(self.volume("pairs.csv", "--particles", method) / single, 1, delta=delta)
            self.assertAlmostEqual(self.report()["particles"]["radius"], RADIUS, delta=0.04 * RADIUS)

    def test_far_away_the_mesh_keeps_its_shape(self):
        self.assertGreater(min(map(abs, FAR)), 1e7)
        self.write("near.ply", ply(block(6)))
        for name, write in (("far.ply", ply), ("far.csv", csv), ("far.xyz", xyz), ("far.dump", lammps), ("far.npy", npy)):
            self.write(name, write(block(6, FAR)))
        for method in METHODS:
            options = ("--particles", method, "--radius", RADIUS)
            near = self.volume("near.ply", *options)
            for name in ("far.ply", "far.csv", "far.xyz", "far.dump", "far.npy") if method == "sph" else ("far.ply",):
                self.convert(name, *options, "-o", "out.ply", "--report", "report.json")
                (facts,) = self.report()["meshes"]
                self.assertTrue(facts["closed"])
                self.assertAlmostEqual(facts["volume"] / near, 1, delta=1e-3)
        for form, reader in (("ply", read_ply), ("obj", read_obj),
                             ("glb", lambda data: next(iter(read_glb(data).values())))):
            self.convert("far.ply", "--radius", RADIUS, "--up", "y", "-o", f"out.{form}") if form == "glb" else self.convert(
                "far.ply", "--radius", RADIUS, "-o", f"out.{form}")
            mesh = reader((self.folder / f"out.{form}").read_bytes())
            self.assertEqual(mesh.open_edges(), 0)
            # Sums of coordinates of 1e7 cancel: around a vertex of its own.
            origin = mesh.vertices[0]
            mesh.vertices = [tuple(v[axis] - origin[axis] for axis in range(3)) for v in mesh.vertices]
            self.assertAlmostEqual(mesh.volume() / self.volume("near.ply", "--radius", RADIUS), 1, delta=1e-3)

    def test_formats_that_cannot_hold_what_is_far_refuse(self):
        self.write("far.ply", ply(block(3, FAR)))
        for form in ("stl", "drc"):
            run = self.run_program("far.ply", "--radius", RADIUS, "-o", f"out.{form}")
            self.assert_fails(4, run, "keep the corners of triangles distinct", "--format")
        self.assertEqual(self.files(), ["far.ply"])

    def test_places_that_the_file_itself_rounds_together(self):
        # In float32 these are a few positions: the program reports that, or makes a surface around them.
        self.write("far.ply", ply(block(4, FAR), kind="float"))
        run = self.run_program("far.ply", "-o", "out.ply")
        self.assert_fails(2, run, "two or more positions", "give --radius R")

    def test_memory_does_not_follow_the_box_around_two_clusters(self):
        half = 2 ** 19 * RADIUS  # a million radii from one to the other
        self.write("one.csv", csv(block(12)))
        self.write("two.csv", csv(block(12, (-half,) * 3) + block(12, (half,) * 3)))
        for method, cell in (("sph", 2), ("anisotropic", 2), ("weight", 4)):
            with self.subTest(method=method):
                options = ("--particles", method, "--radius", RADIUS, "--cell-size", cell)
                one = self.volume("one.csv", *options)
                reserved = self.report()["reserved_memory_bytes"]
                self.convert("two.csv", *options, "-o", "two.ply", "--report", "report.json")
                (facts,) = self.report()["meshes"]
                self.assertEqual((facts["closed"], facts["components"]), (True, 2))
                # Positions of one mesh are float32, around an origin between the two.
                self.assertAlmostEqual(facts["volume"] / (2 * one), 1, delta=0.01)
                self.assertLess(self.report()["reserved_memory_bytes"], 2.2 * reserved)

    def test_clusters_too_far_apart_for_one_mesh_can_be_had_one_by_one(self):
        apart = 2 ** 20 * RADIUS
        self.write("one.csv", csv(block(6)))
        self.write("two.csv", csv(block(6) + block(6, (apart,) * 3)))
        options = ("--radius", RADIUS)  # with samples 0.75 radii apart
        one = self.volume("one.csv", *options)
        self.refused_within(OVERHEAD, 2, ("two.csv", *options), "extend over more than about 2^20 samples", "--roi")
        for low, high in ((-1, 1), (apart - 1, apart + 1)):
            roi = ",".join(map(str, (low,) * 3 + (high,) * 3))
            self.assertAlmostEqual(self.volume("two.csv", *options, f"--roi={roi}") / one, 1, delta=1e-3)

    def test_a_far_reach_at_a_fine_spacing_is_refused_at_once(self):
        self.write("two.csv", csv([(0.0, 0.0, 0.0), (0.05, 0.0, 0.0)]))
        for options in (("--cell-size", "1e-4"), ("--cell-size", "1e-3"), ("--smoothing-length", "1e5"), ("--cell-size", "1e-8")):
            for method in ("sph", "anisotropic"):
                with self.subTest(options=options, method=method):
                    self.refused_within(OVERHEAD, 2, ("two.csv", "--radius", 1, "--particles", method, *options,
                                                      "--memory-limit", "1G"), "two.csv")

    def test_a_radius_so_small_that_particles_do_not_touch(self):
        self.write("a.csv", csv(block(3)))
        for method in ("sph", "anisotropic"):
            options = ("--particles", method, "--radius", RADIUS / 16)
            volume = self.volume("a.csv", *options)
            self.assertEqual(self.report()["meshes"][0]["components"], 27)
            self.write("one.csv", csv([(0.0, 0.0, 0.0)]))
            self.assertAlmostEqual(volume / (27 * self.volume("one.csv", *options)), 1, delta=0.1)
        # So small that the grid cannot be numbered.
        self.refused_within(OVERHEAD, 2, ("a.csv", "--radius", "1e-12"), "samples at a spacing of")


if __name__ == "__main__":
    main()
