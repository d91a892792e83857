"""Particles: read, made a field, and extracted, with everything that volumes have."""

import itertools
import json
import math
import random
import re
import struct

from support import DATA, ProgramTest, main, needs_data, read_glb, read_obj, read_ply, read_stl

STEP = 0.5  # of the lattice; a radius is half of it
OCTOCAT = DATA / "particles/octocat_32614_particles.bgeo"
DAM = DATA / "particles/dam_break_frame_9_6859_particles.bgeo"


def block(n=5, at=(0, 0, 0)):
    """n^3 particles on a lattice."""
    return [tuple(at[a] + STEP * index[a] for a in range(3)) for index in
            ((i, j, k) for i in range(n) for j in range(n) for k in range(n))]


class ParticlesTest(ProgramTest):
    def write_csv(self, name, points, header="x,y,z", more=None):
        rows = [",".join(repr(float(c)) for c in (*p, *(more(p) if more else ()))) for p in points]
        (self.folder / name).write_text("\n".join([header, *rows]) + "\n")
        return name

    def write_ply(self, name, points):
        """With the attributes pressure, which is x, and velocity, which is the place."""
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
        header += [f"property float {p}" for p in ("x", "y", "z", "pressure", "vx", "vy", "vz")] + ["end_header", ""]
        body = b"".join(struct.pack("<7f", *p, p[0], *p) for p in points)
        (self.folder / name).write_bytes("\n".join(header).encode() + body)
        return name

    def write_xyz(self, name, frames):
        text = "".join(f"{len(points)}\nframe {k}\n" + "".join("W {} {} {}\n".format(*p) for p in points)
                       for k, points in enumerate(frames))
        (self.folder / name).write_text(text)
        return name

    def mesh(self, name):
        return read_ply((self.folder / name).read_bytes())

    def move_back(self, name, steps):
        """Subtracts the steps from the vertices of an OBJ file."""
        lines = (self.folder / name).read_text().splitlines()
        for n, line in enumerate(lines):
            if line.startswith("v "):
                lines[n] = "v {!r} {!r} {!r}".format(*(float(c) - s for c, s in zip(line.split()[1:4], steps)))
        (self.folder / name).write_text("\n".join(lines) + "\n")

    def report(self, *arguments):
        run = self.convert(*arguments, "--report", "report.json")
        return json.loads((self.folder / "report.json").read_text()), run

    def check_block(self, mesh, n=5, at=(0, 0, 0)):
        """Closed, and around the block at a distance of about its radius."""
        self.assertEqual(mesh.open_edges(), 0)
        self.assertGreater(mesh.volume(), 0.7 * (STEP * n) ** 3)
        self.assertLess(mesh.volume(), 1.3 * (STEP * n) ** 3)
        low, high = mesh.bounds()
        for axis in range(3):
            self.assertAlmostEqual(low[axis], at[axis] - STEP / 2, delta=STEP / 2)
            self.assertAlmostEqual(high[axis], at[axis] + STEP * (n - 0.5), delta=STEP / 2)

    def test_decimal_commas_between_spaces_without_names(self):
        rows = [(x * STEP, y * STEP, 0.5) for x in range(4) for y in range(4)]
        text = "".join(" ".join(f"{value:.3f}" for value in row) + "\n" for row in rows)
        (self.folder / "points.csv").write_text(text)
        (self.folder / "commas.csv").write_text(text.replace(".", ","))
        for name in ("points", "commas"):
            self.convert(f"{name}.csv", "--radius", STEP, "-o", f"{name}.ply")
        self.assertEqual((self.folder / "points.ply").read_bytes(), (self.folder / "commas.ply").read_bytes())

    def test_a_comma_behind_a_space_is_no_decimal_comma(self):
        rows = [(x, y, 3) for x in range(4) for y in range(4)]
        for name, between in (("tight", ","), ("loose", " ,")):
            text = "".join(between.join(str(value) for value in row) + "\n" for row in rows)
            (self.folder / f"{name}.csv").write_text(text)
            self.convert(f"{name}.csv", "--radius", "1", "-o", f"{name}.ply")
        self.assertEqual((self.folder / "tight.ply").read_bytes(), (self.folder / "loose.ply").read_bytes())

    def test_chosen_columns_of_lammps_are_scaled_as_what_they_are(self):
        """Fractions along a box of 4 x 4 x 4 from (2, 10, -3), whichever axis they become."""
        points = [(0.25 + 0.1 * i, 0.5, 0.75) for i in range(5)]
        head = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n5\nITEM: BOX BOUNDS pp pp pp\n2 6\n10 14\n-3 1\nITEM: ATOMS "
        rows = "".join("{} {} {}\n".format(*p) for p in points)
        (self.folder / "s.dump").write_text(head + "xs ys zs\n" + rows)
        (self.folder / "m.dump").write_text(head + "xs y zs\n" + rows)
        for name, columns, low in (("s.dump", "x=zs,y=xs,z=ys", (0, 3, 12)), ("s.dump", "x=1,y=2,z=3", (3, 12, 0)),
                                   ("s.dump", "x=ys,y=xs,z=zs", (12, 3, 0)), ("m.dump", "x=xs,y=y,z=zs", (3, 0.5, 0))):
            (told,) = json.loads(self.convert("info", "--json", name, "--columns", columns, "--radius", "0.2").text)
            for found, wanted in zip(told["particles"]["bounds"]["min"], low):
                self.assertAlmostEqual(found, wanted, places=6, msg=columns)

    def test_names_of_houdinis_spreadsheet(self):
        """Brackets with a letter count components: a velocity is a vector, and P is where the particles are."""
        header = "P[x],P[y],P[z],v[x],v[y],v[z]"
        self.write_csv("a.csv", block(), header, more=lambda p: (1, 5, 9))
        self.write_csv("b.csv", block(), "x,y,z,v[x],v[y],v[z]", more=lambda p: (1, 5, 9))
        for name in ("a.csv", "b.csv"):
            self.convert(name, "--radius", STEP / 2, "--attribute", "v", "--ascii", "-o", "a.ply")
            text = (self.folder / "a.ply").read_text()
            for c in range(3):
                self.assertIn(f"property float v_{c}\n", text, name)
            run = self.convert(name, "--radius", STEP / 2, "--color-by", "v", "-o", "b.ply")
            self.assertRegex(run.err, "viridis from 10.34")  # the length
            self.check_block(self.mesh("b.ply"))
        by_name = self.convert("a.csv", "--columns", "x=P[x],y=P[y],z=P[z]", "--radius", STEP / 2, "-o", "c.ply")
        self.assertNotIn("column", by_name.err)
        self.assertEqual(self.mesh("c.ply").vertices, self.mesh("b.ply").vertices)

    def test_every_method_and_every_text_format(self):
        self.write_csv("a.csv", block())
        self.write_ply("a.ply", block())
        self.write_xyz("a.xyz", [block()])
        for name in ("a.csv", "a.ply", "a.xyz"):
            run = self.convert(name, "-o", "out.ply")
            self.assertIn("iso 0.6, the default of SPH interpolation; choose another with --iso V", run.err)
            self.check_block(self.mesh("out.ply"))
        # Averaged centers draw so small a body together.
        run = self.convert("a.csv", "--particles", "anisotropic", "--radius", STEP / 2, "-o", "out.ply")
        self.assertIn("iso 0.6, the default of anisotropic kernels", run.err)
        mesh = self.mesh("out.ply")
        self.assertEqual(mesh.open_edges(), 0)
        for low, high in zip(*mesh.bounds()):
            self.assertAlmostEqual(low + high, STEP * 4, delta=STEP / 5)
            self.assertGreater(high - low, STEP * 2)
        run = self.convert("a.csv", "--particles", "weight", "--deposit", "nearest", "-o", "out.ply")
        self.assertIn("iso 0.15, the default of summed weights", run.err)
        self.assertEqual(self.mesh("out.ply").open_edges(), 0)
        many = self.convert("a.csv", "--particles", "weight", "--weight", "0.5", "--cell-size", "2", "-o", "more.ply")
        self.assertIn("closed", many.err)
        self.assertNotEqual(self.mesh("more.ply").bounds(), self.mesh("out.ply").bounds())

    def test_the_same_bytes_for_any_number_of_threads(self):
        self.write_ply("a.ply", block())
        for threads in (1, 3):
            self.convert("a.ply", "--threads", threads, "--attribute", "pressure", "-o", f"{threads}.ply")
        self.assertEqual((self.folder / "1.ply").read_bytes(), (self.folder / "3.ply").read_bytes())

    def test_every_output(self):
        self.write_csv("a.csv", block())
        readers = {"ply": read_ply, "stl": read_stl, "obj": read_obj}
        self.convert("a.csv", "--iso", "0.5", "-o", "a.glb", "--up", "y")
        (expected,) = read_glb((self.folder / "a.glb").read_bytes()).values()
        self.check_block(expected)
        for name, reader in readers.items():
            self.convert("a.csv", "--iso", "0.5", "-o", f"a.{name}")
            mesh = reader((self.folder / f"a.{name}").read_bytes())
            self.assertEqual(len(mesh.triangles), len(expected.triangles))
        for more in (("--draco",), ("--quantize", "--meshopt"), ("--simplify", "0.1"), ("--error",), ("--cap",)):
            self.assertIn("closed", self.convert("a.csv", "--iso", "0.5", *more, "-o", "b.glb").err)
        self.convert("a.csv", "--iso", "0.3", "--iso", "0.6", "-o", "two.glb")
        self.assertEqual(len(read_glb((self.folder / "two.glb").read_bytes())), 2)

    def test_what_is_left_out_inside_changes_no_surface(self):
        self.write_csv("a.csv", block(24))
        report, _ = self.report("a.csv", "--iso", "0.6", "-o", "one.ply")
        self.assertGreater(report["particles"]["left_out_inside"], 0)
        self.assertIn("particles_inside", [fact["what"] for fact in report["work"]])
        report, _ = self.report("a.csv", "--iso", "0.6", "--iso", "0.3", "--format", "ply", "-o", "{iso}.ply")
        self.assertEqual(report["particles"]["left_out_inside"], 0)
        self.assertEqual((self.folder / "one.ply").read_bytes(), (self.folder / "0.6.ply").read_bytes())
        # What looks at other samples has them all.
        for more in (("--error",), ("--resolution", "40")):
            report, _ = self.report("a.csv", "--iso", "0.6", *more, "-o", "other.ply")
            self.assertEqual(report["particles"]["left_out_inside"], 0)

    def test_the_report_and_the_explanation(self):
        self.write_csv("a.csv", block())
        report, run = self.report("a.csv", "--radius", "0.25", "--smoothing-length", "1.8", "--cell-size", "0.5",
                                  "--explain", "-o", "a.ply")
        self.assertRegex(run.err, r"particles to field in \d")
        self.assertRegex(run.err, r"made into a field: 125 particles of radius 0.25, with samples 0.125 apart")
        made = report["particles"]
        self.assertEqual((made["format"], made["method"], made["particles"], made["radius"]), ("csv", "sph", 125, 0.25))
        self.assertEqual((made["smoothing_length"], made["spacing"], made["support"]), (1.8, 0.125, 0.9))
        self.assertFalse(made["radius_suggested"])
        stages = [stage["stage"] for stage in report["stages"]]
        self.assertLess(stages.index("read"), stages.index("particles to field"))
        self.assertEqual(report["options"]["particles"]["radius"], 0.25)
        self.assertEqual(report["options"]["iso"], [0.6])

    def test_frames_in_files(self):
        for k in range(3):
            self.write_csv(f"in_{k}.csv", block(3 + k))
        self.convert("in_{}.csv", "--radius", "0.25", "-o", "out_{}.ply", "--table", "t.csv")
        for k in range(3):
            self.check_block(self.mesh(f"out_{k}.ply"), 3 + k)
        run = self.convert("in_{}.csv", "--radius", "0.25", "-o", "out_{}.ply", "--resume")
        self.assertIn("3 ", run.err)
        before = (self.folder / "out_1.ply").stat().st_mtime_ns, (self.folder / "out_2.ply").stat().st_mtime_ns
        self.write_csv("in_2.csv", block(2))
        self.convert("in_{}.csv", "--radius", "0.25", "-o", "out_{}.ply", "--resume")
        after = (self.folder / "out_1.ply").stat().st_mtime_ns, (self.folder / "out_2.ply").stat().st_mtime_ns
        self.assertEqual(before[0], after[0])
        self.assertNotEqual(before[1], after[1])
        dry = self.convert("in_{}.csv", "-o", "out_{}.ply", "--dry-run")
        self.assertRegex(dry.text, r"memory: about \d+ MiB")

    def test_frames_in_one_file(self):
        self.write_xyz("a.xyz", [block(3), block(4), block(5, (10, 0, 0))])
        self.assert_fails(2, self.run_program("a.xyz", "--radius", "0.25", "-o", "a.ply"), "3 frames",
                          "choose one of them with --volume K; use --volume all to convert every frame")
        self.assert_fails(2, self.run_program("a.xyz", "--radius", "0.25", "--volume", "3", "-o", "a.ply"),
                          "there is no frame 3")
        self.convert("a.xyz", "--radius", "0.25", "--volume", "2", "-o", "a.ply")
        self.check_block(self.mesh("a.ply"), 5, (10, 0, 0))
        self.convert("a.xyz", "--radius", "0.25", "--volume", "all", "-o", "f_{}.ply")
        self.assertEqual((self.folder / "f_2.ply").read_bytes(), (self.folder / "a.ply").read_bytes())
        self.convert("a.xyz", "--radius", "0.25", "--volume", "all", "--animate", "-o", "a.glb")
        self.assertEqual(len(read_glb((self.folder / "a.glb").read_bytes())), 3)

    def test_attributes_of_vertices(self):
        self.write_ply("a.ply", block())
        report, _ = self.report("a.ply", "--radius", "0.25", "--attribute", "pressure", "--attribute", "vx", "-o",
                                "out.ply", "--ascii")
        self.assertIn("attributes", [stage["stage"] for stage in report["stages"]])
        self.assertEqual([a["name"] for a in report["options"]["attributes"]], ["pressure", "vx"])
        text = (self.folder / "out.ply").read_text()
        head, body = text.split("end_header\n")
        names = re.findall(r"property float (\w+)", head)
        self.assertEqual(names[-2:], ["pressure", "vx"])
        count = int(re.search(r"element vertex (\d+)", head)[1])
        for line in body.splitlines()[:count]:
            values = [float(word) for word in line.split()]
            self.assertAlmostEqual(values[-2], min(max(values[0], 0), 4 * STEP), delta=0.6 * STEP)
            self.assertEqual(values[-2], values[-1])
        self.convert("a.ply", "--radius", "0.25", "--attribute", "pressure", "--simplify", "0.1", "-o", "out.glb")
        data = (self.folder / "out.glb").read_bytes()
        model = json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])
        attributes = model["meshes"][0]["primitives"][0]["attributes"]
        self.assertEqual(model["accessors"][attributes["_pressure"]]["count"],
                         model["accessors"][attributes["POSITION"]]["count"])

    def test_attributes_follow_the_places_of_the_world(self):
        """Whatever is done to the coordinates of the mesh, the attributes are those of the same particles."""
        self.write_ply("a.ply", block(4, (3, 1, 2)))
        values = []
        for more in ((), ("--scale", "0.001"), ("--space", "index")):
            self.convert("a.ply", "--radius", "0.25", "--attribute", "pressure", *more, "--ascii", "-o", "b.ply")
            header, lines = (self.folder / "b.ply").read_text().split("end_header\n")
            count = int(re.search(r"element vertex (\d+)", header)[1])
            values.append([float(line.split()[-1]) for line in lines.splitlines()[:count]])
            self.assertTrue(values[-1])
        for other in values[1:]:
            self.assertEqual(len(other), len(values[0]))
            for a, b in zip(values[0], other):
                self.assertAlmostEqual(a, b, places=4)

    def test_no_particles(self):
        self.write_ply("none.ply", [])
        self.assert_fails(2, self.run_program("none.ply", "-o", "a.ply"), "there are no particles", "--empty skip")
        self.convert("none.ply", "--empty", "skip", "-o", "a.ply")
        self.assertFalse((self.folder / "a.ply").exists())
        self.convert("none.ply", "--empty", "write", "--attribute", "pressure", "-o", "a.ply")
        self.assertEqual(self.mesh("a.ply").vertices, [])

    def test_bench_is_about_volumes(self):
        self.write_csv("a.csv", block())
        self.write_xyz("a.xyz", [block(3)])
        for words in (("a.csv",), ("a.xyz", "--input-format", "xyz")):
            self.assert_fails(1, self.run_program("bench", *words, "--iso", "0.6"), f"{words[0]}: expected a volume, found particles")
        self.write_ply("a.ply", block(3))
        with (self.folder / "a.ply").open("rb") as file:
            self.assert_fails(1, self.run_program("bench", "-", "--iso", "0.6", stdin=file),
                              "standard input: expected a volume, found particles")

    def estimate(self, *arguments):
        (told,) = json.loads(self.convert("info", "--json", *arguments).text)
        return told["field"]["memory"]["conversion"], told["field"]["suggestion"]["triangles"]

    def check_estimate(self, *arguments):
        memory, triangles = self.estimate(*arguments)
        report, _ = self.report(*arguments, "-o", "a.glb")
        made = report["extractions"][0]["triangles"]
        taken = self.peak_mib(*arguments, "-o", "a.glb")
        for told in (memory / 2**20, self.told_mib(*arguments, "-o", "a.glb")):
            self.assertAlmostEqual(told / taken, 1, delta=0.25, msg=str((arguments, told, taken)))
        self.assertAlmostEqual(triangles / made, 1, delta=0.5, msg=str((arguments, triangles, made)))

    @needs_data("particles/octocat_32614_particles.bgeo")
    def test_memory_is_estimated(self):
        for method in ("sph", "anisotropic"):
            self.check_estimate(OCTOCAT, "--particles", method, "--radius", "0.02")
        self.check_estimate(OCTOCAT, "--particles", "weight")

    def test_memory_of_a_sheet_is_estimated(self):
        """It faces one axis alone."""
        for axis in range(3):
            self.write_ply("a.ply", [p[axis:] + p[:axis] for p in ((0, STEP * i, STEP * j) for i in range(60) for j in range(60))])
            self.check_estimate("a.ply", "--radius", "0.25", "--cell-size", "0.3")

    def test_the_surface_does_not_move_on_its_grid(self):
        """The same particles, moved by parts of a cell, have the same surface, moved as far."""
        chance = random.Random(5)
        points = [[c + chance.uniform(-STEP / 8, STEP / 8) for c in p]
                  for p in block(13) if math.dist(p, (6 * STEP,) * 3) < 6.2 * STEP]
        points += [(STEP * i, STEP * j, -4 * STEP) for i in range(14) for j in range(14)]  # a sheet
        radius = STEP / 2
        for method in ("sph", "anisotropic"):
            steps = [part * 0.75 * radius for part in (0.3, 0.45, 0.2)]
            self.write_csv("a.csv", points)
            self.write_csv("b.csv", [[c + s for c, s in zip(p, steps)] for p in points])
            options = ("--particles", method, "--radius", radius, "--normals", "none")
            self.convert("a.csv", *options, "-o", "a.obj")
            self.convert("b.csv", *options, "-o", "b.obj")
            self.move_back("b.obj", steps)
            run = self.run_program("compare", "a.obj", "b.obj", "--json")
            self.assertLess(json.loads(run.out)["rms"] / radius, 0.03, method)

    def test_one_particle(self):
        self.write_csv("one.csv", [(1, 2, 3)])
        self.assert_fails(2, self.run_program("one.csv", "-o", "a.ply"), "two or more positions", "give --radius R")
        self.convert("one.csv", "--radius", "0.1", "--iso", "0.2", "-o", "a.ply")
        mesh = self.mesh("a.ply")
        self.assertEqual(mesh.open_edges(), 0)
        for vertex in mesh.vertices:
            self.assertLess(math.dist(vertex, (1, 2, 3)), 0.4)

    def test_places_that_are_no_numbers(self):
        points = block()
        self.write_csv("a.csv", [*points, (math.nan, 0, 0), (0, math.inf, 0)])
        self.assert_fails(2, self.run_program("a.csv", "-o", "a.ply"), "found (nan, 0, 0) at particle 125",
                          "use --nan outside to leave such particles out")
        report, run = self.report("a.csv", "--nan", "outside", "-o", "a.ply")
        self.assertIn("the conversion left out 2 particles whose positions are not finite", run.err)
        self.assertEqual(report["particles"]["not_finite"], 2)
        self.check_block(self.mesh("a.ply"))
        told = self.convert("info", "a.csv").text
        self.assertIn("2 particles; skip them with --nan outside", told)
        self.convert(*re.search(r"^  isoextract (.+)$", told, re.MULTILINE)[1].split())

    def test_columns(self):
        self.write_csv("a.csv", [(7, *p) for p in block()], "id,Px,Py,Pz")
        for columns in ("x=Px,y=Py,z=Pz", "z=4,x=2,y=3"):
            self.convert("a.csv", "--columns", columns, "-o", "a.ply")
            self.check_block(self.mesh("a.ply"))
        self.assert_fails(2, self.run_program("a.csv", "--columns", "x=Px,y=Py,z=Q", "-o", "a.ply"), "a.csv",
                          "no column 'Q'")
        for wrong in ("1,2,3", "x=1,y=2", "x=1,x=2,z=3", "x=1,y=2,z=", "x=1,y=2,z=3,"):
            self.assert_fails(1, self.run_program("a.csv", "--columns", wrong), "--columns: expected the columns")

    def test_arrays_of_rows_are_particles_where_that_is_said(self):
        points = block()
        header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({len(points)}, 3), }}".ljust(117) + "\n"
        data = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode()
        (self.folder / "a.npy").write_bytes(data + b"".join(struct.pack("<3f", *p) for p in points))
        self.assert_fails(2, self.run_program("a.npy", "--iso", "0.6", "-o", "a.ply"), "expected an array with 3 axes",
                          "use --particles METHOD, such as --particles sph, to read each row of the array as a particle")
        self.convert("a.npy", "--particles", "sph", "-o", "a.ply")
        self.check_block(self.mesh("a.ply"))
        self.convert("a.npy", "--input-format", "npy", "--radius", "0.25", "-o", "a.ply")
        self.check_block(self.mesh("a.ply"))

    def test_structured_arrays_are_particles_where_that_is_said(self):
        points = block()
        header = ("{'descr': [('pos', '<f4', (3,)), ('heat', '<f4')], 'fortran_order': False, "
                  f"'shape': ({len(points)},), }}").ljust(117) + "\n"
        data = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode()
        (self.folder / "a.npy").write_bytes(data + b"".join(struct.pack("<4f", *p, 1) for p in points))
        self.assert_fails(2, self.run_program("info", "a.npy"), "found a structure",
                          "use --particles METHOD, such as --particles sph, to read each row of the array as a particle")
        self.convert("a.npy", "--particles", "sph", "--attribute", "heat", "-o", "a.ply")
        self.check_block(self.mesh("a.ply"))

    def test_a_folder_of_them_is_a_sequence(self):
        for k in range(3):
            self.write_ply(f"drops_{k}.ply", block(3, (k, 0, 0)))
        (self.folder / "d").mkdir()
        for name in [name for name in self.files() if name.startswith("drops")]:
            (self.folder / name).rename(self.folder / "d" / name)
        self.convert("d", "--radius", "0.25", "-o", "out_{}.obj")
        self.assertEqual({"out_0.obj", "out_1.obj", "out_2.obj"} - set(self.files()), set())

    def test_what_makes_no_sense_is_refused(self):
        self.write_csv("a.csv", block())
        self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: x)
        for volume in (("demo:sphere", "--iso", "0"), ("a.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1")):
            for option in (("--radius", "1"), ("--particles", "sph")):
                self.assert_fails(1, self.run_program(*volume, *option, "-o", "a.ply"), "found a volume",
                                  "options of particles")
        for option in (("--spacing", "2"), ("--grid", "a"), ("--inside", "below"), ("--origin", "1,2,3")):
            self.assert_fails(1, self.run_program("a.csv", *option, "-o", "a.ply"), "the input has particles", "leave out")
        for option in (("--radius", "0"), ("--cell-size", "-1"), ("--smoothing-length", "nan"), ("--weight", "0")):
            self.assert_fails(1, self.run_program("a.csv", *option), option[0])
        self.assert_fails(1, self.run_program("a.csv", "--weight", "1", "-o", "a.ply"), "--particles weight")
        self.assert_fails(1, self.run_program("a.csv", "--particles", "weight", "--smoothing-length", "2"), "kernels")
        self.assert_fails(1, self.run_program("a.csv", "--particles", "sph", "--nan", "hole"), "--nan outside")
        self.assert_fails(1, self.run_program("a.csv", "--attribute", "a", "-o", "a.stl"), "stl cannot store vertex attributes")
        self.assert_fails(1, self.run_program("a.csv", "--attribute", "a", "--attribute", "a"), "twice")
        self.assert_fails(2, self.run_program("a.csv", "--attribute", "nix", "-o", "a.ply"), "no attribute 'nix'")
        self.assert_fails(1, self.run_program("a.csv", "--cell-size", "9", "-o", "a.ply"), "a.csv: expected a sample spacing",
                          "give a smaller --cell-size")
        self.assert_fails(1, self.run_program("a.csv", "--particles", "blobs"), "weight, sph, anisotropic")
        self.assert_fails(2, self.run_program("nothing.csv"), "nothing.csv: ")
        self.assertFalse([name for name in self.files() if name.endswith((".ply", ".stl", ".glb"))])

    def test_from_standard_input(self):
        self.write_ply("a.ply", block())
        with (self.folder / "a.ply").open("rb") as file:
            self.convert("-", "--radius", "0.25", "-o", "b.ply", stdin=file)
        self.check_block(self.mesh("b.ply"))
        self.write_csv("a.csv", block())
        with (self.folder / "a.csv").open("rb") as file:
            run = self.convert("-", "--input-format", "csv", "-o", "c.ply", stdin=file)
        self.assertIn("iso 0.6, the default", run.err)
        self.check_block(self.mesh("c.ply"))

    def test_radius_fits_eight_a_cell(self):
        """FLIP places eight particles anywhere in a cell; nearest neighbors are much closer than on a lattice."""
        chance = random.Random(4)
        points = [tuple(2 * c + chance.uniform(0, 2) for c in cell) for cell in
                  itertools.product(range(6), repeat=3) for _ in range(8)]
        self.write_csv("flip.csv", points)
        (entry,) = json.loads(self.convert("info", "--json", "flip.csv").text)
        particles = entry["particles"]
        self.assertAlmostEqual(particles["suggested_radius"], 0.5, delta=0.03)
        self.assertLess(particles["neighbors"]["median"], 0.7)
        run = self.convert("flip.csv", "-o", "flip.ply", "--report", "flip.json", "--explain")
        self.assertRegex(run.err, r"1728 particles of radius 0\.\d+, which fits their density")
        report = json.loads((self.folder / "flip.json").read_text())
        self.assertEqual(report["particles"]["radius"], particles["suggested_radius"])
        self.assertTrue(report["particles"]["radius_suggested"])

    def test_info(self):
        self.write_ply("a.ply", block())
        text = self.convert("info", "a.ply").text
        self.assertIn("125", text)
        self.assertIn("nearest at 0.5 .. 0.5, median 0.5", text)
        self.assertRegex(text, r"0\.2[45]\d*: fits the density of the particles; radii in the file or --radius R")
        self.assertRegex(text, r"pressure +\S+ +0 \.\. 2")
        command = re.search(r"isoextract (a\.ply --iso 0\.6 -o \S+)", text)
        self.assertIsNotNone(command, text)
        self.convert(*command[1].split())
        (entry,) = json.loads(self.convert("info", "--json", "a.ply", "--radius", "0.3").text)
        particles = entry["particles"]
        self.assertEqual((particles["count"], particles["frames"]), (125, 1))
        self.assertAlmostEqual(particles["suggested_radius"], 0.25, delta=0.01)
        self.assertEqual(particles["bounds"], {"min": [0, 0, 0], "max": [2, 2, 2]})
        self.assertEqual([a["name"] for a in particles["attributes"]], ["pressure", "v"])
        self.assertEqual(particles["field"]["radius"], 0.3)
        self.assertGreater(entry["field"]["memory"]["conversion"], 1 << 20)
        self.assertEqual(entry["field"]["suggestion"]["iso"], 0.6)
        self.write_csv("one.csv", [(1, 2, 3)])
        self.assertIn("field", self.convert("info", "one.csv").text)
        self.write_xyz("a.xyz", [block(3), block(4)])
        self.assertIn("2, counted from 0; this report describes 0", self.convert("info", "a.xyz").text)

    def test_verify(self):
        self.write_csv("a.csv", block())
        self.convert("a.csv", "--radius", "0.25", "--iso", "0.6", "-o", "a.ply")
        self.convert("verify", "a.csv", "--radius", "0.25", "--iso", "0.6", "a.ply")
        self.assertEqual(self.run_program("verify", "a.csv", "--radius", "0.3", "--iso", "0.6", "a.ply").code, 6)

    def test_memory_limit(self):
        rng = random.Random(1)
        self.write_csv("a.csv", [[rng.random() for _ in range(3)] for _ in range(2000)])
        self.assert_fails(2, self.run_program("a.csv", "--radius", "0.01", "--memory-limit", "1M", "-o", "a.ply"),
                          "the limit is 1", "--memory-limit")
        self.assertEqual(self.files(), ["a.csv"])

    @needs_data("particles/octocat_32614_particles.bgeo")
    def test_octocat(self):
        report, _ = self.report(OCTOCAT, "--radius", "0.025", "--smoothing-length", "2", "--cell-size", "0.75", "--iso",
                                "0.6", "-o", "a.ply")
        (mesh,) = report["meshes"]
        self.assertTrue(mesh["closed"])
        self.assertTrue(140000 <= mesh["triangles"] <= 180000, mesh["triangles"])

    @needs_data("particles/dam_break_frame_9_6859_particles.bgeo")
    def test_dam_break(self):
        report, _ = self.report(DAM, "--radius", "0.025", "--attribute", "density", "--attribute", "velocity", "-o", "a.ply")
        (mesh,) = report["meshes"]
        self.assertTrue(mesh["closed"])
        self.assertGreater(mesh["volume"], 0.6 * 6859 * 0.05 ** 3)
        self.assertLess(mesh["volume"], 1.4 * 6859 * 0.05 ** 3)
        self.assertIn(b"property float velocity_2", (self.folder / "a.ply").read_bytes()[:1000])


if __name__ == "__main__":
    main()
