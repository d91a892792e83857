"""Which surface is extracted: iso values, methods, normals, regions, caps, bad samples, empty surfaces."""

import math
import os

from support import SPHERE, ProgramTest, main, read_glb, read_obj, read_ply, read_stl

SPHERE_VOLUME = 4 / 3 * math.pi * 0.7**3


class SurfaceTest(ProgramTest):
    def ply(self, *arguments):
        self.convert(*arguments, "-o", "out.ply")
        return read_ply((self.folder / "out.ply").read_bytes())

    def test_both_methods_make_a_closed_sphere(self):
        counts = set()
        for method in ("mc", "mt"):
            mesh = self.ply("demo:sphere?size=40", "--iso", "0", "--method", method)
            self.assertEqual(mesh.open_edges(), 0)
            self.assertAlmostEqual(mesh.volume(), SPHERE_VOLUME, delta=0.01 * SPHERE_VOLUME)
            counts.add(len(mesh.triangles))
        self.assertEqual(len(counts), 2)

    def test_the_default_method_is_mc(self):
        self.assertEqual(self.ply(SPHERE, "--iso", "0").triangles,
                         self.ply(SPHERE, "--iso", "0", "--method", "mc").triangles)

    def test_several_iso_values_are_several_meshes(self):
        self.convert(SPHERE, "--iso", "0", "--iso", "0.2", "--iso", "-0.1", "-o", "out.glb")
        meshes = read_glb((self.folder / "out.glb").read_bytes())
        self.assertEqual(len(meshes), 3)
        for name, radius in (("0", 0.7), ("0.2", 0.5), ("-0.1", 0.8)):
            (mesh,) = (mesh for node, mesh in meshes.items() if node.split()[-1] == name)
            self.assertAlmostEqual(mesh.volume(), 4 / 3 * math.pi * radius**3, delta=0.02)

    def test_several_iso_values_in_one_obj(self):
        self.convert(SPHERE, "--iso", "0", "--iso", "0.2", "-o", "out.obj")
        mesh = read_obj((self.folder / "out.obj").read_bytes())
        self.assertEqual(mesh.open_edges(), 0)
        self.assertAlmostEqual(mesh.volume(), 4 / 3 * math.pi * (0.7**3 + 0.5**3), delta=0.03)

    def test_iso_pattern_gives_each_its_own_file(self):
        run = self.convert(SPHERE, "--iso", "0", "--iso", "-0.25", "-o", "s_{iso}.stl")
        self.assertEqual(self.files(), ["s_-0.25.stl", "s_0.stl"])
        self.assertEqual(run.err.count(" -> "), 2)
        volumes = [read_stl((self.folder / name).read_bytes()).volume() for name in self.files()]
        self.assertGreater(volumes[0], volumes[1])

    def test_cap_closes_what_leaves_the_data(self):
        self.assertGreater(self.ply("demo:gyroid?size=24", "--iso", "0").open_edges(), 0)
        self.assertEqual(self.ply("demo:gyroid?size=24", "--iso", "0", "--cap").open_edges(), 0)

    def test_roi_cuts_and_cap_closes_the_cut(self):
        half = ("--roi", "-1,-1,-1,0,1,1")
        open_mesh = self.ply("demo:sphere?size=41", "--iso", "0", *half)
        self.assertGreater(open_mesh.open_edges(), 0)
        self.assertAlmostEqual(open_mesh.bounds()[1][0], 0, places=6)
        capped = self.ply("demo:sphere?size=41", "--iso", "0", *half, "--cap")
        self.assertEqual(capped.open_edges(), 0)
        self.assertAlmostEqual(capped.volume(), SPHERE_VOLUME / 2, delta=0.01)

    def test_roi_outside_the_data(self):
        for roi, parts in (("5,5,5,6,6,6", ("contains no cell of the data along x", "(-1, -1, -1) .. (1, 1, 1)")),
                           ("0.01,0.01,0.01,0.02,0.02,0.02", ("no surface at iso 0 in the region",))):
            run = self.run_program("demo:sphere?size=41", "--iso", "0", "--roi", roi)
            self.assert_fails(2, run, "--roi", *parts)

    def test_inside_below_turns_the_surface_over(self):
        self.assertGreater(self.ply(SPHERE, "--iso", "0", "--inside", "above").volume(), 0.5)
        self.assertLess(self.ply(SPHERE, "--iso", "0", "--inside", "below").volume(), -0.5)

    def test_normals(self):
        self.convert(SPHERE, "--iso", "0", "-o", "default.glb")
        (mesh,) = read_glb((self.folder / "default.glb").read_bytes()).values()
        self.assertEqual(len(mesh.normals), len(mesh.vertices))
        for vertex, normal in zip(mesh.vertices, mesh.normals):
            self.assertGreater(sum(v * n for v, n in zip(vertex, normal)), 0.68)  # 0.7 if exactly radial
        self.convert(SPHERE, "--iso", "0", "--normals", "none", "-o", "none.glb")
        (mesh,) = read_glb((self.folder / "none.glb").read_bytes()).values()
        self.assertEqual(len(mesh.normals), 0)
        self.convert(SPHERE, "--iso", "0", "--normals", "flat", "-o", "flat.glb")
        (flat,) = read_glb((self.folder / "flat.glb").read_bytes()).values()
        self.assertEqual(len(flat.vertices), 3 * len(mesh.triangles))
        self.assertEqual(len(self.ply(SPHERE, "--iso", "0").normals), 0)
        self.assertGreater(len(self.ply(SPHERE, "--iso", "0", "--normals", "smooth").normals), 0)

    def test_samples_that_are_not_numbers(self):
        self.write_raw("nan.raw", (4, 4, 4), lambda x, y, z: math.nan if (x, y, z) == (3, 2, 1) else float(x))
        raw = ("nan.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5")
        run = self.run_program(*raw, "-o", "out.ply")
        self.assert_fails(2, run, "nan.raw", "3, 2, 1", "--nan outside")
        self.assertEqual(self.files(), ["nan.raw"])
        mesh = self.ply(*raw, "--nan", "outside")
        self.assertGreater(len(mesh.triangles), 0)
        for vertex in mesh.vertices:
            self.assertTrue(all(math.isfinite(c) for c in vertex))

    def test_holes_where_samples_are_not_numbers(self):
        self.write_raw("nan.raw", (6, 6, 6), lambda x, y, z: math.nan if (x, y, z) == (3, 2, 2) else float(x))
        raw = ("nan.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "2.5")
        hole = self.ply(*raw, "--nan", "hole")
        # A plane of five by five cells, less two by two: the outer boundary of 20 edges, and one of 8.
        self.assertEqual(len(hole.triangles), 2 * (25 - 4))
        self.assertEqual(hole.open_edges(), 20 + 8)
        self.assertTrue(all(vertex[0] == 2.5 for vertex in hole.vertices))
        self.assertEqual({index for triangle in hole.triangles for index in triangle}, set(range(len(hole.vertices))))

    def test_an_empty_surface_is_an_error_with_advice(self):
        run = self.run_program(SPHERE, "--iso", "9", "-o", "out.ply")
        self.assert_fails(2, run, "no surface at iso 9", "range from -1.03", "to 0.6", "try --iso 0 (the iso value of the demo field)")
        self.assertEqual(self.files(), [])

    def test_an_empty_surface_can_be_skipped(self):
        run = self.convert(SPHERE, "--iso", "9", "--empty", "skip", "-o", "out.ply")
        self.assertEqual(self.files(), [])
        self.assertIn("note[", run.err)
        self.assertIn("the conversion did not write out.ply", run.err)
        self.assertNotIn("removed", run.err)
        self.convert(SPHERE, "--iso", "9", "--iso", "0", "--empty", "skip", "-o", "out.glb")
        self.assertEqual(len(read_glb((self.folder / "out.glb").read_bytes())), 1)

    def test_what_is_skipped_leaves_no_old_file_behind(self):
        skip = (SPHERE, "--iso", "9", "--empty", "skip", "-o")
        for form in ("ply", "obj", "gltf"):
            self.convert(SPHERE, "--iso", "0", "-o", f"out.{form}")
            (self.folder / "out.txt").touch()
            run = self.convert(*skip, f"out.{form}")
            removed = "out.gltf and out.bin" if form == "gltf" else f"out.{form}"
            self.assertIn(f"the conversion did not write out.{form} and removed the old {removed}\n", run.err)
            self.assertEqual(self.files(), ["out.txt"])
        (self.folder / "out.bin").write_text("of another program")
        self.convert(*skip, "out.gltf")
        self.assertEqual(self.files(), ["out.bin", "out.txt"])
        for model in ('{"asset":{"version":"2.0"},"buffers":[{"byteLength":1,"uri":"other.bin"}]}', "no JSON"):
            (self.folder / "out.gltf").write_text(model)
            run = self.convert(*skip, "out.gltf")
            self.assertIn("and removed the old out.gltf\n", run.err)
            self.assertEqual(self.files(), ["out.bin", "out.txt"])
        # One of several frames; through a link the file goes that would have been replaced.
        self.convert(SPHERE, "--iso", "0", "-o", "frame.ply")
        (self.folder / "s_9.ply").symlink_to("frame.ply")
        run = self.convert(*skip[:-1], "--iso", "0", "-o", "s_{iso}.ply")
        self.assertIn("and removed the old s_9.ply", run.err)
        self.assertFalse((self.folder / "frame.ply").exists())
        self.assertTrue((self.folder / "s_0.ply").exists())

    def test_what_is_skipped_takes_away_files_only(self):
        skip = (SPHERE, "--iso", "9", "--empty", "skip", "-o")
        os.mkfifo(self.folder / "pipe.ply")
        for name in ("pipe.ply", "/dev/null"):
            self.assertNotIn("removed", self.convert(*skip, name, "--format", "ply").err)
        self.assertTrue((self.folder / "pipe.ply").exists())
        self.convert(*skip, "-", "--format", "ply")
        # A failure leaves the old file, and so does a file that may not be replaced.
        (self.folder / "old.ply").write_text("old")
        self.assertEqual(self.run_program(SPHERE, "--iso", "9", "-o", "old.ply").code, 2)
        self.assertEqual((self.folder / "old.ply").read_text(), "old")

    def test_an_empty_surface_can_be_written(self):
        for name, read in (("out.ply", read_ply), ("out.obj", read_obj), ("out.stl", read_stl)):
            run = self.convert(SPHERE, "--iso", "9", "--empty", "write", "-o", name)
            self.assertIn(" 0 triangles", run.err)
            self.assertEqual(len(read((self.folder / name).read_bytes()).triangles), 0)

    def test_an_empty_part_of_a_full_field_points_to_the_roi(self):
        run = self.run_program("demo:sphere?size=41", "--iso", "0", "--roi", "-0.2,-0.2,-0.2,0.2,0.2,0.2")
        self.assert_fails(2, run, "in the region", "give a larger --roi X0,Y0,Z0,X1,Y1,Z1")


if __name__ == "__main__":
    main()
