"""Fields made and written with OpenVDB: spheres of particles, filters of level sets, and fields in place of meshes."""

import functools
import json
import math
import os
import pathlib
import random
import resource
import shutil
import subprocess
import unittest

from support import PROGRAM, SPHERE, ProgramTest, main, needs_program, read_ply

PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so"
HAS_PLUGIN = PLUGIN.exists()
needs_plugin = unittest.skipUnless(HAS_PLUGIN, "the plug-ins around OpenVDB were not built")


class FieldsTest(ProgramTest):
    def write_csv(self, name, rows, header="x,y,z"):
        lines = [",".join(repr(float(c)) for c in row) for row in rows]
        (self.folder / name).write_text("\n".join([header, *lines]) + "\n")
        return name

    def mesh(self, name):
        return read_ply((self.folder / name).read_bytes())

    def bytes(self, name):
        return (self.folder / name).read_bytes()

    def report(self, *arguments):
        run = self.convert(*arguments, "--report", "report.json")
        return json.loads((self.folder / "report.json").read_text()), run

    def ball(self, name, radius=1.0, step=0.1, bump=0.0):
        """Particles on a lattice that fill a ball, moved by chance."""
        chance = random.Random(7)
        n = math.ceil(radius / step)
        places = [(step * i, step * j, step * k) for i in range(-n, n + 1) for j in range(-n, n + 1) for k in range(-n, n + 1)]
        return self.write_csv(name, [tuple(c + bump * chance.uniform(-1, 1) for c in p) for p in places
                                     if math.hypot(*p) <= radius])


class SpheresTest(FieldsTest):
    @needs_plugin
    def test_spheres_have_their_size(self):
        self.write_csv("one.csv", [(0.3, -0.2, 5)])
        for method, more in (("spheres", ()), ("smooth", ("--smoothing-length", "1"))):
            run = self.convert("one.csv", "--particles", method, "--radius", "1.5", "--cell-size", "0.1", *more, "-o", "one.ply")
            self.assertIn("iso 0, the default of", run.err)
            mesh = self.mesh("one.ply")
            self.assertEqual(mesh.open_edges(), 0)
            self.assertAlmostEqual(mesh.volume(), 4 / 3 * math.pi * 1.5**3, delta=0.1)
            low, high = mesh.bounds()
            for axis, middle in enumerate((0.3, -0.2, 5)):
                self.assertAlmostEqual(low[axis], middle - 1.5, delta=0.02)
                self.assertAlmostEqual(high[axis], middle + 1.5, delta=0.02)

    @needs_plugin
    def test_a_ball_of_particles_has_no_holes_inside(self):
        self.ball("ball.csv")
        known = 4 / 3 * math.pi
        report, _ = self.report("ball.csv", "--particles", "smooth", "--radius", "0.05", "-o", "smooth.ply")
        self.assertEqual(report["meshes"][0]["components"], 1)
        self.assertTrue(0.85 * known < report["meshes"][0]["volume"] < 1.15 * known, report["meshes"][0]["volume"])
        self.assertEqual((report["particles"]["smoothing_length"], report["particles"]["spacing"]), (2, 0.025))
        self.assertAlmostEqual(report["particles"]["support"], 0.2)
        # Spheres that overlap leave nothing between them.
        report, _ = self.report("ball.csv", "--particles", "spheres", "--radius", "0.1", "-o", "spheres.ply")
        self.assertEqual(report["meshes"][0]["components"], 1)
        self.assertTrue(known < report["meshes"][0]["volume"] < known * 1.1**3, report["meshes"][0]["volume"])
        self.assertIsNone(report["particles"]["smoothing_length"])
        self.assertEqual(report["input"]["kind"], "level set")

    @needs_plugin
    def test_each_particle_has_its_own_radius(self):
        self.write_csv("a.csv", [(0, 0, 0, 1.0), (5, 0, 0, 0.5), (9, 0, 0, 1.0)], "x,y,z,pscale")
        report, run = self.report("a.csv", "--particles", "spheres", "--cell-size", "0.2", "-o", "a.ply")
        self.assertIn("each particle has its own radius ('pscale'); the median radius is 1", run.err)
        self.assertEqual(report["particles"]["radius_attribute"], "pscale")
        self.assertEqual(report["particles"]["radius"], 1)
        self.assertAlmostEqual(self.mesh("a.ply").volume(), 4 / 3 * math.pi * 2.125, delta=0.3)
        report, run = self.report("a.csv", "--particles", "spheres", "--radius", "1", "--cell-size", "0.2", "-o", "b.ply")
        self.assertNotIn("pscale", run.err)
        self.assertIsNone(report["particles"]["radius_attribute"])
        self.assertAlmostEqual(self.mesh("b.ply").volume(), 4 / 3 * math.pi * 3, delta=0.4)
        # One that is named otherwise says nothing, and what is no radius is refused.
        self.write_csv("c.csv", [(0, 0, 0, 1.0), (5, 0, 0, -2.0)], "x,y,z,radius")
        self.assert_fails(2, self.run_program("c.csv", "--particles", "spheres", "-o", "c.ply"),
                          "expected finite radii of 0 or more in the attribute 'radius', found -2 at particle 1", "--radius")
        self.assertIn("field", self.convert("info", "a.csv", "--particles", "spheres").text)

    @needs_plugin
    def test_small_and_broken_particles_are_told(self):
        self.write_csv("a.csv", [(0, 0, 0, 1.0), (5, 0, 0, 0.01), (9, 0, 0, 1.0)], "x,y,z,radius")
        report, run = self.report("a.csv", "--particles", "spheres", "--explain", "-o", "a.ply")
        self.assertIn("the surface leaves out 1 of 3 particles, those with a radius below 1.5 voxels", run.err)
        self.assertIn("left out: 1 of 3 particles, whose radius is below 1.5 sample spacings", run.err)
        self.assertEqual((report["particles"]["particles"], report["particles"]["too_small"]), (2, 1))
        self.assertEqual(report["meshes"][0]["components"], 2)
        run = self.run_program("a.csv", "--particles", "spheres", "--radius", "1", "--cell-size", "0.7", "-o", "b.ply")
        self.assert_fails(2, run, "at least 1.5 sample spacings (1.05 with a spacing of 0.7), found 3 particles, all smaller", "--cell-size")
        for method in ("spheres", "smooth"):
            self.write_csv("nan.csv", [(0, 0, 0), (math.nan, 1, 1), (3, 0, 0)])
            command = ("nan.csv", "--particles", method, "--radius", "1")
            self.assert_fails(2, self.run_program(*command, "-o", "n.ply"), "expected finite positions", "--nan outside")
            run = self.convert(*command, "--nan", "outside", "-o", "n.ply")
            self.assertIn("the conversion left out 1 particle whose position is not finite", run.err)
            self.assertEqual(self.mesh("n.ply").open_edges(), 0)
        self.assertFalse((self.folder / "b.ply").exists())

    @needs_plugin
    def test_the_same_bytes_for_any_number_of_threads(self):
        self.ball("ball.csv", bump=0.04)
        for method in ("spheres", "smooth"):
            for threads in (1, 2, 7):
                self.convert("ball.csv", "--particles", method, "--radius", "0.06", "--filter", "gaussian", "--threads",
                             threads, "-o", f"{threads}.ply")
                self.convert("ball.csv", "--particles", method, "--radius", "0.06", "--threads", threads, "-o",
                             f"{threads}.vdb")
            for threads in (2, 7):
                self.assertEqual(self.bytes("1.ply"), self.bytes(f"{threads}.ply"), (method, threads))
                self.assertEqual(self.bytes("1.vdb"), self.bytes(f"{threads}.vdb"), (method, threads))

    def test_options_that_make_no_sense(self):
        self.write_csv("a.csv", [(0, 0, 0)])
        for options, part in ((("--smoothing-length", "2"), "--smoothing-length sets the size of kernels, and --particles spheres"),
                              (("--weight", "2"), "--weight needs --particles weight"),
                              (("--nan", "hole"), "--nan hole")):
            self.assert_fails(1, self.run_program("a.csv", "--particles", "spheres", *options, "-o", "a.ply"), part)

    @needs_plugin
    def test_memory_is_reserved_first(self):
        self.ball("ball.csv")
        for method in ("spheres", "smooth"):
            run = self.run_program("ball.csv", "--particles", method, "--radius", "0.05", "--cell-size", "0.1",
                                   "--memory-limit", "20M", "-o", "a.ply")
            self.assert_fails(2, run, "ball.csv", "--memory-limit")
        self.assertEqual(self.files(), ["ball.csv"])


class FilterTest(FieldsTest):
    @needs_plugin
    def test_a_bumpy_ball_becomes_smoother(self):
        self.ball("ball.csv", bump=0.05)
        common = ("ball.csv", "--particles", "spheres", "--radius", "0.08")
        plain, _ = self.report(*common, "-o", "plain.ply")
        areas = [plain["meshes"][0]["area"]]
        volume = plain["meshes"][0]["volume"]
        for filters in (("gaussian",), ("mean:2", "mean:2"), ("median:2",)):
            words = [word for step in filters for word in ("--filter", step)]
            report, run = self.report(*common, *words, "--explain", "-o", "filtered.ply")
            self.assertRegex(run.err, rf"filtered: the level set by {filters[0].split(':')[0]}:\d: \d+ active voxels")
            self.assertEqual([step["filter"] for step in report["options"]["filters"]], [s.split(":")[0] for s in filters])
            self.assertEqual([stage["stage"] for stage in report["stages"]].count("filter"), len(filters))
            self.assertLess(report["meshes"][0]["area"], areas[0])
            self.assertAlmostEqual(report["meshes"][0]["volume"], volume, delta=0.1 * volume)
            self.assertEqual(self.mesh("filtered.ply").open_edges(), 0)
        # In the order given.
        for name, words in (("a", ("median", "gaussian:2")), ("b", ("gaussian:2", "median"))):
            self.convert(*common, "--filter", words[0], "--filter", words[1], "-o", f"{name}.ply")
        self.assertNotEqual(self.bytes("a.ply"), self.bytes("b.ply"))

    @needs_plugin
    def test_level_sets_of_files(self):
        self.ball("ball.csv", bump=0.05)
        self.convert("ball.csv", "--particles", "spheres", "--radius", "0.08", "-o", "ball.vdb")
        self.convert("ball.csv", "--particles", "spheres", "--radius", "0.08", "--filter", "mean", "-o", "direct.ply")
        self.convert("ball.vdb", "--iso", "0", "--filter", "mean", "-o", "file.ply")
        self.assertEqual(self.bytes("direct.ply"), self.bytes("file.ply"))
        run = self.convert("verify", "ball.vdb", "file.ply", "--iso", "0", "--filter", "mean")
        self.assertEqual(run.code, 0)
        self.assertEqual(self.run_program("verify", "ball.vdb", "file.ply", "--iso", "0").code, 6)
        self.convert("ball.vdb", "--iso", "0", "--filter", "mean", "--resolution", "30", "-o", "coarse.ply")

    def test_densities_are_refused(self):
        run = self.run_program(SPHERE, "--iso", "0", "--filter", "mean", "-o", "a.ply")
        self.assert_fails(2, run, "the filter needs the narrow band of a level set; found a density", "leave --filter out")
        run = self.run_program(SPHERE, "--iso", "0", "--filter", "mean", "--inside", "below", "-o", "a.ply")
        self.assertIn(run.code, (1, 2))
        self.write_csv("a.csv", [(0, 0, 0)])
        run = self.run_program("a.csv", "--particles", "sph", "--filter", "mean", "-o", "a.ply")
        self.assert_fails(1, run, "--filter works on level sets, and --particles sph makes a density")
        for text in ("box", "mean:", "mean:0", "mean:65", "mean:1.5", "mean:-1"):
            run = self.run_program(SPHERE, "--iso", "0", "--filter", text, "-o", "a.ply")
            self.assert_fails(1, run, "--filter", f"'{text}'", "gaussian:2")
        self.assertEqual(self.files(), ["a.csv"])


class FieldFileTest(FieldsTest):
    def same_mesh(self, original, written, iso, *more):
        """The mesh of a written field is, byte for byte, that of what was written."""
        self.convert(*original, "--iso", iso, "-o", "direct.ply", *more)
        self.convert(written, "--iso", iso, "-o", "stored.ply", *more)
        self.assertEqual(self.bytes("direct.ply"), self.bytes("stored.ply"))

    @needs_plugin
    def test_particles_of_every_method(self):
        self.ball("ball.csv", step=0.15)
        for method, iso in (("sph", 0.6), ("anisotropic", 0.6), ("weight", 0.15), ("spheres", 0), ("smooth", 0)):
            command = ("ball.csv", "--particles", method, "--radius", "0.1")
            report, run = self.report(*command, "-o", "field.vdb")
            self.assertRegex(run.err, r"ball.csv -> field.vdb: samples in \d+ bricks")
            # Nothing is left out that another iso value, or a renderer of volumes, would look at.
            self.assertEqual(report["particles"]["left_out_inside"], 0)
            self.assertEqual(report["options"]["format"], "vdb")
            self.assertEqual((report["options"]["iso"], report["meshes"], report["device"]), ([], [], None))
            self.assertEqual(report["files"], [{"path": "field.vdb", "bytes": (self.folder / "field.vdb").stat().st_size}])
            self.same_mesh(command, "field.vdb", iso)
            kind = "level set" if iso == 0 else "density"
            self.assertEqual(json.loads(self.convert("info", "field.vdb", "--json").text)[0]["grids"][0]["name"], "ball")
            self.report("field.vdb", "--iso", iso, "-o", "again.ply")
            self.assertEqual(json.loads((self.folder / "report.json").read_text())["input"]["kind"], kind)

    @needs_plugin
    def test_what_is_read_and_written_stays_the_same(self):
        self.ball("ball.csv", step=0.15)
        self.convert("ball.csv", "--particles", "sph", "--radius", "0.1", "-o", "a.vdb")
        self.convert("a.vdb", "-o", "b.vdb")
        self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"))

    @needs_plugin
    def test_boxes_of_samples(self):
        """Of a full box the numbers of vertices are others, as sparse samples are walked through in another order; the
        surface is the same to the last bit."""
        for field, iso in (("demo:metaballs?size=40", "1"), ("demo:torus?size=33", "0")):
            report, run = self.report(field, "-o", "field.vdb")
            self.assertIn("samples, as 32 bits each", run.err)
            self.convert(field, "--iso", iso, "-o", "direct.obj")
            self.convert("field.vdb", "--iso", iso, "-o", "stored.obj")
            direct, stored = (self.triangles(f"{name}.obj") for name in ("direct", "stored"))
            self.assertGreater(len(direct), 500)
            self.assertEqual(direct, stored)

    def triangles(self, name):
        """Sorted, by the text of their corners' places."""
        places, triangles = [], []
        for line in (self.folder / name).read_text().splitlines():
            words = line.split()
            if words[:1] == ["v"]:
                places.append(tuple(words[1:4]))
            elif words[:1] == ["f"]:
                corners = [places[int(word.split("/")[0]) - 1] for word in words[1:4]]
                first = corners.index(min(corners))
                triangles.append(tuple(corners[first:] + corners[:first]))
        return sorted(triangles)

    @needs_plugin
    def test_half_floats(self):
        self.convert("demo:metaballs?size=32", "-o", "float.vdb")
        report, run = self.report("demo:metaballs?size=32", "--half", "--explain", "-o", "half.vdb")
        self.assertIn("as 16 bits each", run.err)
        self.assertIn("rounded: values of f32 to 16-bit floats", run.err)
        self.assertEqual(report["options"]["field_file"], {"half": True, "format": "vdb"})
        self.assertLess(len(self.bytes("half.vdb")), 0.7 * len(self.bytes("float.vdb")))
        self.convert("float.vdb", "--iso", "1", "-o", "float.ply")
        self.convert("half.vdb", "--iso", "1", "-o", "half.ply")
        run = self.run_program("compare", "float.ply", "half.ply", "--max-distance", "0.01")
        self.assertEqual(run.code, 0, run.err)
        self.write_raw("large.raw", (3, 3, 3), lambda x, y, z: 1e5 * x)
        run = self.run_program("large.raw", "--dims", "3,3,3", "--dtype", "f32", "--half", "-o", "large.vdb")
        self.assert_fails(4, run, "expected samples with absolute values up to 65504, the limit of half floats; found 200000", "leave --half out")
        self.assertFalse((self.folder / "large.vdb").exists())
        self.write_raw("huge.raw", (3, 3, 3), lambda x, y, z: 1e300 * x, "d")
        run = self.run_program("huge.raw", "--dims", "3,3,3", "--dtype", "f64", "-o", "large.vdb")
        self.assert_fails(4, run, "the limit of floats; found 2e+300")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--half", "-o", "a.ply"), "--half")

    @needs_plugin
    def test_resolution_and_placement_of_the_file(self):
        self.write_raw("a.raw", (9, 8, 7), lambda x, y, z: 3 - math.dist((x, y, z), (4, 3.5, 3)))
        common = ("a.raw", "--dims", "9,8,7", "--dtype", "f32", "--spacing", "0.5,1,2", "--origin", "10,20,30")
        self.convert(*common, "--resolution", "20,20,20", "-o", "a.vdb")
        self.convert(*common, "--resolution", "20,20,20", "--iso", "1", "-o", "direct.obj")
        self.convert("a.vdb", "--iso", "1", "-o", "stored.obj")
        direct, stored = (sorted(set(c for t in self.triangles(f"{n}.obj") for c in t)) for n in ("direct", "stored"))
        self.assertEqual(len(direct), len(stored))
        for a, b in zip(direct, stored):
            for left, right in zip(a, b):
                self.assertAlmostEqual(float(left), float(right), places=4)

    @needs_plugin
    @needs_program("vdb_print")
    def test_openvdbs_own_tool_reads_it(self):
        self.ball("ball.csv", step=0.2)
        self.convert("ball.csv", "--particles", "spheres", "--radius", "0.1", "-o", "surface.vdb")
        self.convert(SPHERE, "--half", "-o", "sphere.vdb")
        stream = self.convert(SPHERE, "--format", "vdb", "-o", "-")
        self.assertEqual(stream.out[:8], b" BDV\0\0\0\0")
        (self.folder / "stream.vdb").write_bytes(stream.out)
        for name, parts in (("surface.vdb", ("ball", "level set", "float")), ("sphere.vdb", ("sphere", "fog volume", "half")),
                            ("stream.vdb", ("sphere", "fog volume"))):
            run = subprocess.run(["vdb_print", "-l", self.folder / name], capture_output=True, text=True, check=False)
            self.assertEqual(run.returncode, 0, run.stderr)
            for part in parts:
                self.assertIn(part, run.stdout)
        self.convert("stream.vdb", "--iso", "0", "-o", "stream.ply")
        self.convert(SPHERE, "-o", "whole.vdb")
        self.convert("whole.vdb", "--iso", "0", "-o", "whole.ply")
        self.assertEqual(self.bytes("stream.ply"), self.bytes("whole.ply"))

    @needs_plugin
    def test_batches(self):
        for frame in (1, 2, 3):
            self.ball(f"in_{frame:04}.csv", radius=0.3 + 0.1 * frame)
        command = ("in_{:04}.csv", "--radius", "0.1", "-o", "out_{:04}.vdb", "--table", "t.csv", "--report", "r_{:04}.json")
        self.convert(*command)
        self.assertEqual([n for n in self.files() if n.startswith("out_")], [f"out_000{k}.vdb" for k in (1, 2, 3)])
        self.assertEqual(json.loads((self.folder / "r_0002.json").read_text())["files"][0]["path"], "out_0002.vdb")
        times = {k: (self.folder / f"out_000{k}.vdb").stat().st_mtime_ns for k in (1, 2, 3)}
        (self.folder / "out_0002.vdb").unlink()
        run = self.convert(*command, "--resume")
        self.assertEqual((self.folder / "out_0001.vdb").stat().st_mtime_ns, times[1])
        self.assertTrue((self.folder / "out_0002.vdb").exists())
        before = self.bytes("out_0003.vdb")
        self.convert(*command, "--resume", "--half")
        self.assertLess(len(self.bytes("out_0003.vdb")), len(before))
        (self.folder / "sub").mkdir()
        self.convert("in_{:04}.csv", "--radius", "0.1", "--format", "vdb", "-o", "sub/")
        self.assertTrue((self.folder / "sub/in_0001.vdb").exists())
        self.assertIn("out_0003.vdb", self.convert(*command, "--dry-run").text)
        run = self.convert("in_0001.csv", "--radius", "0.1", "--format", "vdb", "-o", "other.ply")
        self.assertIn("other.ply: isoextract writes vdb because of --format", run.err)

    def test_options_of_surfaces_are_refused(self):
        for options in (("--iso", "0"), ("--method", "mt"), ("--normals", "flat"), ("--simplify", "0.1"), ("--cap",),
                        ("--roi", "0,0,0,1,1,1"), ("--attribute", "v"), ("--space", "index"), ("--up", "y"), ("--scale", "2"),
                        ("--unit", "mm"), ("--to-unit", "m"), ("--up-out", "y"), ("--to-space", "ras"), ("--center",), ("--ascii",),
                        ("--draco",), ("--quantize",), ("--meshopt",), ("--optimize-order",),
                        ("--error",), ("--verify",), ("--backend", "cpu"), ("--animate",), ("--plot", "a.svg")):
            run = self.run_program(SPHERE, *options, "-o", "a.vdb")
            self.assert_fails(1, run, f"{options[0]} needs a surface, but the output is the field itself")
        run = self.run_program(SPHERE, "--cap", "--iso", "0", "--smooth", "3", "--center", "-o", "a.vdb")
        self.assert_fails(1, run, "--iso, --cap, --smooth, --center need a surface", "leave --iso, --cap, --smooth, --")
        self.assert_fails(1, self.run_program(SPHERE, "--nan", "hole", "-o", "a.vdb"), "--nan hole")
        self.assert_fails(1, self.run_program(SPHERE, "-o", "a_{iso}.vdb"), "{iso} is the iso value of a surface, but the output is the field itself")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "-o", "a.abc"), ".vdb, .nrrd, .npy or .vti for the field")
        self.assertEqual(self.files(), [])

    @needs_plugin
    def test_nothing_to_write(self):
        self.write_csv("none.csv", [])
        self.assert_fails(2, self.run_program("none.csv", "-o", "a.vdb"), "there are no particles", "--empty")
        (self.folder / "a.vdb").write_bytes(b"old")
        run = self.convert("none.csv", "--empty", "skip", "-o", "a.vdb")
        self.assertIn("the conversion did not write a.vdb and removed the old file", run.err)
        self.assertEqual(self.files(), ["none.csv"])
        self.convert("none.csv", "--empty", "write", "-o", "a.vdb")
        self.assertTrue((self.folder / "a.vdb").exists())
        # No part of a file, and no file but whole ones.
        run = self.run_program(SPHERE, "-o", "no/folder.vdb")
        self.assertEqual(run.code, 4)
        run = self.run_program("demo:sphere?size=64", "--memory-limit", "2M", "-o", "b.vdb")
        self.assertEqual(run.code, 2, run.err)
        self.assertEqual(self.files(), ["a.vdb", "none.csv"])
        run = self.run_program("a.vdb", "-o", "a.vdb")
        self.assert_fails(1, run, "this is the input; it is not overwritten")


class ResampledLevelSetTest(FieldsTest):
    """A level set that is written with other voxels has distances up to three of them, and no means of the old band."""

    SPHERE = ("one.csv", "--particles", "spheres", "--radius", "1.5", "--cell-size", "0.1")  # voxels of 0.15

    def setUp(self):
        super().setUp()
        self.write_csv("one.csv", [(0.3, -0.2, 5)])

    def values(self, name):
        """Shape, least and greatest value, and the gradient's length near the surface, of an array."""
        script = f"""import json, numpy
a = numpy.load({name!r}).astype(float)
near = abs(a) < 0.6 * a.max()
g = numpy.sqrt(sum(d**2 for d in numpy.gradient(a)))[near]
print(json.dumps([a.shape, a.min(), a.max(), g.mean(), abs(a[0]).min(), int((a < 0).sum())]))"""
        run = subprocess.run(["/usr/bin/python3", "-c", script], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(run.stdout)

    @needs_plugin
    def test_other_voxels_have_the_whole_band(self):
        self.convert(*self.SPHERE, "-o", "own.vdb")
        for voxel in (0.25, 0.04):
            with self.subTest(voxel):
                report, run = self.report("own.vdb", "--voxel-size", voxel, "--explain", "-o", "other.vdb")
                self.assertRegex(run.err, rf"resampled: the level set, with voxels of {voxel} and a band of 3 voxels on either side: \d+ active")
                self.assertNotIn("note[", run.err.replace("note[grid-chosen]", ""))
                self.assertEqual([s["stage"] for s in report["stages"]].count("resample"), 1)
                field = json.loads(self.convert("info", "other.vdb", "--json").text)[0]["field"]
                self.assertEqual((field["kind"], field["spacing"]), ("level set", [voxel] * 3))
                self.assertAlmostEqual(field["background"], 3 * voxel, delta=1e-6)
                self.convert("other.vdb", "-o", "other.ply")
                # A mesh of voxels this large has its facets inside the sphere, in the same way as one made with them.
                self.convert(*self.SPHERE[:-1], voxel / 1.5, "-o", "direct.ply")
                self.assertAlmostEqual(self.mesh("other.ply").volume() / self.mesh("direct.ply").volume(), 1, delta=0.01)
                low, high = self.mesh("other.ply").bounds()
                for axis, middle in enumerate((0.3, -0.2, 5)):
                    self.assertAlmostEqual(low[axis], middle - 1.5, delta=0.02)
                    self.assertAlmostEqual(high[axis], middle + 1.5, delta=0.02)
                # Dense files have the same samples.
                self.convert("own.vdb", "--voxel-size", voxel, "-o", "other.npy")
                shape, least, greatest, gradient, outermost, inside = self.values("other.npy")
                self.assertAlmostEqual(greatest, 3 * voxel, delta=1e-6)
                self.assertAlmostEqual(least, -3 * voxel, delta=1e-6)
                self.assertAlmostEqual(gradient / voxel, 1, delta=0.03)
                self.assertAlmostEqual(outermost, 3 * voxel, delta=1e-6)
                self.assertAlmostEqual(inside * voxel**3 / (4 / 3 * math.pi * 1.5**3), 1, delta=0.06)

    @needs_plugin
    def test_the_same_bytes_for_any_number_of_threads(self):
        self.ball("ball.csv", bump=0.04)
        for threads in (1, 2, 7):
            self.convert("ball.csv", "--particles", "spheres", "--radius", "0.1", "--voxel-size", "0.07", "--threads", threads,
                         "-o", f"{threads}.vdb")
        self.assertEqual(self.bytes("1.vdb"), self.bytes("2.vdb"))
        self.assertEqual(self.bytes("1.vdb"), self.bytes("7.vdb"))

    @needs_plugin
    def test_what_is_interpolated_says_so(self):
        self.convert(*self.SPHERE, "-o", "own.vdb")
        for options, why in ((("--voxel-size", "0.2", "--kernel", "cubic"), "because the options choose a kernel: its narrow band ends 2.25 new voxels"),
                             (("--voxel-size", "0.2,0.1,0.2"), "because the new voxels are not cubic"),
                             (("--resolution", "20,20,21"), "because the new voxels are not cubic")):
            run = self.convert("own.vdb", *options, "-o", "other.vdb")
            self.assertIn("note[level-set-interpolated]: own.vdb", run.err)
            self.assertIn(why, run.err)
        run = self.convert("own.vdb", "--resolution", "20", "-o", "other.npy")
        self.assertIn("because the options set the number of samples", run.err)
        self.assertEqual(self.values("other.npy")[0], [20, 20, 20])
        # Half the steps along each axis are cubic voxels; neither meshes nor densities say anything.
        run = self.convert("own.vdb", "--resolution", "53,55,55", "--explain", "-o", "cube.vdb")
        self.assertIn("resampled: the level set, with voxels of 0.075 and a band of 3 voxels", run.err)
        for command in (("own.vdb", "--voxel-size", "0.2", "-o", "a.ply"), (SPHERE, "--voxel-size", "0.2", "-o", "a.vdb"),
                        ("own.vdb", "--inside", "above", "--voxel-size", "0.2", "-o", "a.vdb")):
            self.assertNotIn("level-set-interpolated", self.convert(*command).err)
        # The same voxels are the same file.
        run = self.convert("own.vdb", "--voxel-size", "0.15", "--explain", "-o", "same.vdb")
        self.assertIn("left out: resampling, because the data has the requested resolution", run.err)
        self.assertEqual(self.bytes("own.vdb"), self.bytes("same.vdb"))

    @needs_plugin
    def test_memory_and_nothing(self):
        run = self.run_program(*self.SPHERE, "--voxel-size", "0.01", "--memory-limit", "50M", "-o", "a.vdb")
        self.assert_fails(2, run, "rebuilding the level set", "--memory-limit")
        self.write_csv("none.csv", [])
        self.convert("none.csv", "--particles", "spheres", "--radius", "1", "--voxel-size", "0.2", "--empty", "write", "-o", "none.vdb")
        self.assertTrue((self.folder / "none.vdb").exists())


class PluginTest(FieldsTest):
    def test_the_program_is_linked_with_none_of_the_large_libraries(self):
        linked = subprocess.run(["ldd", PROGRAM], check=True, capture_output=True, text=True).stdout.lower()
        self.assertIn("libtbb", linked)
        for library in ("openvdb", "libvtk"):
            self.assertNotIn(library, linked)

    def test_what_is_missing_is_named(self):
        alone = self.folder / "alone" / "isoextract"
        alone.parent.mkdir()
        shutil.copy(PROGRAM, alone)
        self.write_csv("a.csv", [(0, 0, 0), (1, 0, 0)])
        for command in ([SPHERE, "-o", "a.vdb"], ["a.csv", "--particles", "spheres", "-o", "a.ply"],
                        ["a.csv", "--particles", "smooth", "-o", "a.ply"]):
            none = {name: value for name, value in os.environ.items() if name != "ISOEXTRACT_PLUGINS"}
            run = subprocess.run([alone, *command], cwd=self.folder, check=False, capture_output=True, text=True, env=none)
            self.assertEqual(run.returncode, 3, run.stderr)
            for part in ("isoextract-grids-openvdb.so", "install the plug-in", "ISOEXTRACT_PLUGINS"):
                self.assertIn(part, run.stderr)
            if HAS_PLUGIN:
                found = dict(os.environ, ISOEXTRACT_PLUGINS=str(PLUGIN.parent))
                run = subprocess.run([alone, *command], cwd=self.folder, check=False, capture_output=True, env=found)
                self.assertEqual(run.returncode, 0, run.stderr)
                (self.folder / command[-1]).unlink()
        self.assertEqual(self.files(), ["a.csv", "alone"])
        for environment in (none, found) if HAS_PLUGIN else (none,):
            listed = json.loads(subprocess.check_output([alone, "formats", "--json"], env=environment))
            [vdb] = [one for one in listed if (one["use"], one["id"]) == ("write field", "vdb")]
            self.assertEqual((vdb["is_plugin"], vdb["is_there"]), (True, environment is not none))

    @needs_plugin
    def test_a_limited_address_space(self):
        """OpenVDB's libraries, which are given too little of it as they are loaded, end the process or wait for ever."""
        self.write_csv("p.csv", [(0, 0, 0), (0.3, 0, 0)])
        refused = 0
        for mebibytes in range(80, 181, 10):
            with self.subTest(mebibytes):
                limit = (mebibytes << 20,) * 2
                run = self.run_program("p.csv", "--radius", "0.4", "--particles", "spheres", "-o", "v.vdb",
                                       preexec_fn=functools.partial(resource.setrlimit, resource.RLIMIT_AS, limit))
                self.assertIn(run.code, (0, 2, 3), run.err)
                if run.code == 3:
                    self.assertIn("raise that limit (ulimit -v unlimited", run.err)
                    refused += 1
        self.assertGreater(refused, 2)


if __name__ == "__main__":
    main()
