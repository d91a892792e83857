"""Grids of VDB files as the command line shows and takes them: their names, streams, places, grids without voxels."""

import json
import re
import subprocess

from support import PROGRAM, ProgramTest, main, processor_time_below, read_ply
from vdb_files import frustum, grid, scale, text, vdb

VOXELS = {(1, 2, 3): 1.0, (2, 2, 3): 1.0}
ODD = b"\x1b[31mred\nline\0nul\xff"
ODD_SHOWN = r"\x1b[31mred\nline\x00nul\xff"


class GridsTest(ProgramTest):
    def write(self, name, *grids, **options):
        (self.folder / name).write_bytes(vdb(*grids, **options))

    def mesh(self, *arguments):
        self.convert(*arguments, "-o", "mesh.ply")
        return read_ply((self.folder / "mesh.ply").read_bytes())

    def grids(self, name):
        return json.loads(self.convert("info", "--json", name).text)[0]["grids"]

    def assert_printable(self, shown):
        self.assertTrue(all(c == "\n" or c.isprintable() for c in shown), repr(shown))

    def test_streams_are_read_like_files(self):
        meshes = []
        for name, stream in (("file.vdb", False), ("stream.vdb", True)):
            self.write(name, grid("a", {(8, 8, 8): 2.0}), grid("b", VOXELS), stream=stream)
            self.assertEqual([entry["voxels"] for entry in self.grids(name)], [1, 2])
            meshes.append(self.mesh(name, "--grid", "b", "--iso", "0.5"))
        self.assertEqual(meshes[0].triangles, meshes[1].triangles)
        self.assertEqual(meshes[0].vertices, meshes[1].vertices)
        self.assertEqual(len(meshes[0].triangles), 16)

    def test_errors_tell_damaged_files_from_unsupported_ones(self):
        whole = vdb(grid("a", VOXELS), stream=True)
        (self.folder / "cut.vdb").write_bytes(whole[:-1])
        self.assert_fails(2, self.run_program("cut.vdb", "--iso", "0.5"), "the VDB file is damaged: expected")
        (self.folder / "old.vdb").write_bytes(whole[:8] + bytes([213]) + whole[9:])
        self.assert_fails(2, self.run_program("old.vdb", "--iso", "0.5"), "the VDB file is not supported: ", "213")

    def test_names_from_files_are_shown_printable(self):
        self.write("odd.vdb", grid(ODD, VOXELS))
        run = self.convert("odd.vdb", "--iso", "0.5", "-o", "a.ply", "-v", "--report", "r.json")
        self.assertIn(f"odd.vdb[{ODD_SHOWN}] iso 0.5 -> a.ply: 16 triangles", run.err)
        self.assert_printable(run.err)
        self.assertIn("\x1b[31mred\nline\0nul", json.loads((self.folder / "r.json").read_bytes())["input"]["name"])
        run = self.run_program("odd.vdb", "--iso", "9")
        self.assert_fails(2, run, f"odd.vdb[{ODD_SHOWN}]: no surface")
        self.assert_printable(run.err)
        shown = self.convert("info", "odd.vdb").text
        self.assertIn(ODD_SHOWN, shown)
        self.assert_printable(shown)
        self.assertEqual(self.grids("odd.vdb")[0]["name"], ODD_SHOWN)
        self.mesh("odd.vdb", "--iso", "0.5", "--grid", ODD_SHOWN)

    def test_names_of_files_are_shown_printable(self):
        name = "a\x1b[2J\nisoextract: error: b.vdb"
        self.write(name, grid("a", VOXELS))
        shown = r"a\x1b[2J\nisoextract: error: b.vdb"
        for run in (self.convert(name, "--iso", "0.5", "-o", name + ".ply"), self.run_program(name, "--iso", "9"),
                    self.run_program("no" + name, "--iso", "0.5")):
            self.assertIn(shown, run.err)
            self.assert_printable(run.err)
        run = self.convert("info", name)
        self.assertTrue(run.text.startswith(shown + "\n"), run.text)
        self.assert_printable(run.text)

    def test_grid_takes_what_info_lists(self):
        voxels = [{(place, 0, 0): 1.0} for place in range(6)]
        names = ("flèche", "flèche", "density", "density", "density[0]", b"\xff")
        self.write("many.vdb", *(grid(name, at) for name, at in zip(names, voxels)))
        labels = ["flèche[0]", "flèche[1]", "density[1]", "density[2]", "density[0]", r"\xff"]
        self.assertEqual([entry["name"] for entry in self.grids("many.vdb")], labels)
        listed = self.convert("info", "many.vdb").text
        for place, label in enumerate(labels):
            self.assertIn(f"    {label} ", listed)
            low, high = self.mesh("many.vdb", "--iso", "0.5", "--grid", label).bounds()
            self.assertEqual((low[0], high[0]), (place - 0.5, place + 0.5))
        self.assert_fails(2, self.run_program("many.vdb", "--iso", "0.5", "--grid", "density"),
                          "2 grids are named 'density'", "--grid NAME", "flèche[1]")

    def test_info_lists_grids_that_it_cannot_place(self):
        for transform, reason, plugin in ((frustum(), "the plug-in for openvdb", "openvdb"),
                                          (text("SpiralMap") + bytes(40), "found 'SpiralMap'", None)):
            self.write("bent.vdb", grid("bent", VOXELS, transform=transform), grid("velocity", kind="vec3s_5_4_3", meta={}))
            listed = self.convert("info", "bent.vdb").text
            for part in ("bent", "2 active voxels", reason, "velocity", "voxels not counted"):
                self.assertIn(part, listed)
            bent, velocity = self.grids("bent.vdb")
            if plugin:
                self.assertEqual((bent["problem"], bent["plugin"]["id"]), (None, plugin))
            else:
                self.assertIn(reason, bent["problem"])
            self.assertEqual((bent["voxels"], velocity["voxels"], velocity["problem"]), (2, None, None))
        self.assert_fails(2, self.run_program("bent.vdb", "--iso", "0.5"), reason)
        self.write("flat.vdb", grid("flat", VOXELS, transform=scale(float("inf"))))
        self.assert_fails(2, self.run_program("info", "flat.vdb", "--grid", "flat"), "--spacing")
        for name, transform in (("flat.vdb", scale(float("inf"))), ("bent.vdb", frustum())):
            self.write(name, grid("v", VOXELS, transform=transform))
            self.assertIn("percentiles", self.convert("info", name, "--spacing", "1").text)

    def test_a_region_of_voxels_far_apart(self):
        far = 1 << 24
        self.write("far.vdb", grid("far", {(0, 0, 0): 1.0, (far, 0, 0): 1.0}))
        for options in ((), ("--space", "index")):
            run = self.run_program("far.vdb", "--iso", "0.5", *options)
            self.assert_fails(2, run, "extend over more than about 2^20 samples", "--roi")
            for place in (0, far):
                roi = f"--roi={place - 3},-3,-3,{place + 3},3,3"
                mesh = self.mesh("far.vdb", "--iso", "0.5", roi, "--error", *options)
                self.assertEqual((len(mesh.triangles), mesh.open_edges()), (8, 0))
                low, high = mesh.bounds()
                self.assertEqual((low[0], high[0], low[1], high[1]), (place - 0.5, place + 0.5, -0.5, 0.5))

    def test_info_suggests_no_command_that_fails(self):
        self.write("apart.vdb", grid("apart", {(0, 0, 0): 1.0, (1 << 26, 0, 0): 1.0}))
        shown = self.convert("info", "apart.vdb").text
        self.assertIn("too far apart for one mesh: extract regions with --roi", shown)
        self.assertNotIn("isoextract apart.vdb", shown)
        self.write("a\nb.vdb", grid("a", VOXELS))
        shown = self.convert("info", "a\nb.vdb").text
        (command,) = re.findall(r"(?m)^  isoextract (\$'a\\nb\.vdb' --iso \S+ -o \$'a\\nb\.glb')$", shown)
        subprocess.run(["bash", "-c", f"{PROGRAM} {command}"], cwd=self.folder, check=True, capture_output=True)
        self.assertIn("a\nb.glb", self.files())

    def test_holes_far_apart_take_no_time(self):
        """Whether a surface with holes is open depends on the surface, not on all of a region's faces."""
        far = 1 << 17
        voxels = {(x, y, 0): 2.0 for x in range(3) for y in range(3)}
        self.write("holes.vdb", grid("holes", voxels | {(1, 1, 0): float("nan"), (far, far, far): 2.0}))
        with processor_time_below(30, "a look at all of it takes minutes"):
            for roi, ends in (((1, 0, -2, far + 2, far + 2, far + 2), "open at the boundary of --roi"),
                              ((-2, -2, -2, far + 2, far + 2, far + 2), "around NaN samples")):
                run = self.convert("holes.vdb", "--iso", "1", "--nan", "hole", "--roi=" + ",".join(map(str, roi)),
                                   "-o", "a.ply")
                self.assertIn(ends, run.err)
            self.assertNotIn("open at", run.err)

    def test_a_cap_far_from_all_voxels(self):
        """Where the background is inside, the cap of a region stands wherever the region is."""
        self.write("block.vdb", grid("block", {(x, y, z): -2.0 for x in range(4) for y in range(4) for z in range(4)}))
        for place in (1 << 24, 100_000_000, 1 << 28):
            mesh = self.mesh("block.vdb", "--iso", "-1", "--cap", f"--roi={place},0,0,{place + 10},10,10")
            self.assertEqual(mesh.bounds(), ([place, 0, 0], [place + 10, 10, 10]))
            self.assertAlmostEqual(mesh.volume(), 1000)
            self.assertEqual(mesh.open_edges(), 0)
        # Without a cap nothing is drawn so far away, however large the region is.
        mesh = self.mesh("block.vdb", "--iso", "-1", "--roi=-8,-8,-8,400000000,10,10")
        self.assertEqual(mesh.open_edges(), 0)
        self.assertLess(mesh.bounds()[1][0], 5)

    def test_results_name_the_grid_as_info_does(self):
        self.write("twice.vdb", grid("density", VOXELS), grid("density", {(1, 1, 1): 1.0}), grid("density[0]", VOXELS))
        for entry in self.grids("twice.vdb"):
            run = self.convert("twice.vdb", "--grid", entry["name"], "--iso", "0.5", "-o", "a.ply")
            self.assertTrue(run.err.startswith(f"twice.vdb[{entry['name']}] iso 0.5 -> a.ply: "), run.err)

    def test_voxels_beyond_the_limit_are_not_supported_and_no_damage(self):
        self.write("out.vdb", grid("out", {(600_000_000, 0, 0): 1.0}))
        self.assert_fails(2, self.run_program("out.vdb", "--iso", "0.5"), "not supported: expected voxel indices from -2^29 to 2^29 - 1 along x")

    def test_an_empty_grid_is_told_from_a_file_that_cannot_be_read(self):
        self.write("empty.vdb", grid("nothing"))
        (self.folder / "cut.vdb").write_bytes((self.folder / "empty.vdb").read_bytes()[:-4])
        reasons = {}
        for name in ("empty", "cut"):
            run = self.run_program(name + ".vdb", "--iso", "0.5", "-o", "a.ply", "--report", "r.json")
            error = json.loads((self.folder / "r.json").read_text())["error"]
            self.assertEqual((run.code, error["kind"], error["exit_code"]), (2, "input", 2))
            self.assertIn(error["message"], run.err)
            self.assertIn(error["hint"], run.err)
            reasons[name] = error["reason"], error["hint"] != ""
        self.assertEqual(reasons, {"empty": ("empty_grid", True), "cut": (None, False)})
        run = self.run_program("empty.vdb", "--iso", "0.5", "--resolution", "8", "-q")
        self.assert_fails(2, run, "empty.vdb[nothing]: the grid is empty: it has no voxels", "--empty skip", "--empty write")
        self.assertIn("the conversion did not write a.ply", self.convert("empty.vdb", "--iso", "0.5", "--empty", "skip", "-o", "a.ply").err)
        self.assertEqual(self.mesh("empty.vdb", "--iso", "0.5", "--empty", "write").triangles, [])


if __name__ == "__main__":
    main()
