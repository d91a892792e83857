"""isoextract simulate water: the files of a sequence, the messages about them, and the errors."""

import math
import pathlib
import re
import struct
import subprocess

from support import PROGRAM, ProgramTest, main, read_ply

HAS_OPENVDB = (pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so").exists()
WATER = ("simulate", "water")
SMALL = (*WATER, "--size", "24x18", "--relief", "8")


def npy(path):
    """Shape and numbers of an array of little-endian floats."""
    data = path.read_bytes()
    start = 10 + struct.unpack_from("<H", data, 8)[0]
    header = data[10:start].decode()
    size = int(re.search(r"'descr': '<f(\d)'", header)[1])
    shape = tuple(int(n) for n in re.search(r"\(([\d, ]+)\)", header)[1].split(",") if n.strip())
    count = math.prod(shape)
    return shape, struct.unpack_from(f"<{count}{'d' if size == 8 else 'f'}", data, start)


class SimulateTest(ProgramTest):
    def simulate(self, *arguments):
        run = self.run_program(*arguments)
        self.assertEqual((run.code, run.out), (0, b""), run.err)
        return run

    def test_a_sequence_of_volumes_becomes_closed_meshes(self):
        run = self.simulate(*SMALL, "--steps", 60, "--every", 30, "-o", "w/w_{:04}.nrrd", "--mkdir")
        self.assertEqual(sorted(path.name for path in (self.folder / "w").iterdir()),
                         ["w_0000.nrrd", "w_0001.nrrd", "w_0002.nrrd"])
        self.assertRegex(run.err, r"60 steps of 24 x 18 cells by the conservative rule: [\d.]+ million cells per second")
        self.assertIn("-> w/w_0000.nrrd to w/w_0002.nrrd: 3 files", run.err)
        self.convert("w/w_{:04}.nrrd", "--frames", "1-2", "--iso", "0.5", "--cap", "-o", "m_{:04}.ply", "-q")
        for frame in (1, 2):
            mesh = read_ply((self.folder / f"m_{frame:04}.ply").read_bytes())
            self.assertGreater(len(mesh.triangles), 50)
            self.assertEqual(mesh.open_edges(), 0)

    def test_verbose_prints_times_and_memory(self):
        told = r"(?m)^simulated in [\d.]+ s, written in [\d.]+ s, peak memory [\d.]+ MiB$"
        self.assertRegex(self.simulate(*SMALL, "--steps", 20, "-o", "w.nrrd", "-v").err, told)
        self.assertNotRegex(self.simulate(*SMALL, "--steps", 20, "-o", "w.nrrd").err, told)

    def test_mass_is_kept_in_what_is_written(self):
        self.simulate(*SMALL, "--steps", 200, "--every", 100, "--source", "5,9,0.75", "--what", "heights",
                      "-o", "h_{grid}_%02d.npy", "-q")
        for frame in (0, 1, 2):
            shape, depths = npy(self.folder / f"h_water_{frame:02}.npy")
            self.assertEqual(shape, (18, 24))
            self.assertGreaterEqual(min(depths), 0)
            self.assertAlmostEqual(math.fsum(depths), 75 * frame, delta=1e-10)
        shape, land = npy(self.folder / "h_terrain_00.npy")
        self.assertAlmostEqual(max(land) - min(land), 8, places=12)
        self.assertEqual((self.folder / "h_terrain_00.npy").read_bytes(), (self.folder / "h_terrain_02.npy").read_bytes())

    def test_volumes_hold_what_the_columns_hold(self):
        common = (*SMALL, "--level", 4, "--steps", 20, "-q")
        self.simulate(*common, "--what", "heights", "-o", "{grid}.npy")
        self.simulate(*common, "--what", "both", "-o", "v_{grid}.npy")
        for name in ("water", "terrain"):
            (ny, nx), heights = npy(self.folder / f"{name}.npy")
            (nz, *rest), parts = npy(self.folder / f"v_{name}.npy")
            self.assertEqual(rest, [ny, nx])
            for cell in range(nx * ny):
                self.assertAlmostEqual(math.fsum(parts[cell :: nx * ny]), heights[cell], delta=1e-5)

    def test_numpy_reads_it(self):
        self.simulate(*SMALL, "--steps", 20, "-o", "w.npy", "-q")
        script = "import numpy; a = numpy.load('w.npy'); print(a.shape[1:], a.dtype, a.min() >= 0, a.max() <= 1)"
        run = subprocess.run(["/usr/bin/python3", "-c", script], cwd=self.folder, capture_output=True, text=True)
        if "No module named" in run.stderr:
            self.skipTest("no NumPy")
        self.assertEqual(run.stdout, "(18, 24) float32 True True\n", run.stderr)

    def test_a_raw_file_is_read_as_it_is_told(self):
        run = self.simulate(*SMALL, "--steps", 40, "--spacing", "0.5", "-o", "w.raw")
        told = re.search(r"read with: isoextract (w\.raw --iso 0\.5 .*)\n", run.err)[1]
        self.convert(*told.split(), "-o", "raw.ply", "-q")
        self.simulate(*SMALL, "--steps", 40, "--spacing", "0.5", "-o", "w.nrrd", "-q")
        self.convert("w.nrrd", "--iso", "0.5", "-o", "nrrd.ply", "-q")
        self.assertEqual((self.folder / "raw.ply").read_bytes(), (self.folder / "nrrd.ply").read_bytes())

    def test_threads_and_seeds(self):
        def volume(*options):
            self.simulate(*WATER, "--size", "300x120", "--steps", 30, "-o", "w.raw", "-q", *options)
            return (self.folder / "w.raw").read_bytes()

        one = volume("--threads", 1)
        self.assertEqual(one, volume("--threads", 2))
        self.assertEqual(one, volume("--seed", 1))
        self.assertNotEqual(one, volume("--seed", 2))
        self.assertNotEqual(one, volume("--rule", "printed"))

    def test_a_vdb_holds_both_grids(self):
        if not HAS_OPENVDB:
            self.skipTest("no plug-in around OpenVDB")
        self.simulate(*SMALL, "--steps", 20, "--what", "both", "-o", "w.vdb", "-q")
        info = self.run_program("info", "w.vdb", "--grid", "terrain")
        self.assertEqual(info.code, 0, info.err)
        for grid in ("terrain", "water"):
            self.convert("w.vdb", "--grid", grid, "--iso", "0.5", "-o", f"{grid}.ply", "-q")
        self.simulate(*SMALL, "--steps", 20, "--what", "terrain", "-o", "t.nrrd", "-q")
        # Beyond its box a VDB grid is empty, so that its surface closes there.
        self.convert("t.nrrd", "--iso", "0.5", "--cap", "-o", "t.ply", "-q")
        compared = self.run_program("compare", "t.ply", "terrain.ply", "--max-distance", "1")
        self.assertEqual(compared.code, 0, compared.err)
        self.assert_fails(1, self.run_program(*SMALL, "--what", "both", "-o", "{grid}.vdb"), "one file holds all grids")

    def test_stdout_and_folders(self):
        self.simulate(*SMALL, "--steps", 20, "-o", "w.nrrd", "-q")
        run = self.run_program(*SMALL, "--steps", 20, "-o", "-", "--format", "nrrd", "-q")
        self.assertEqual((run.code, run.out), (0, (self.folder / "w.nrrd").read_bytes()))
        self.simulate(*SMALL, "--steps", 20, "-o", "out/", "--format", "npy", "-q")
        self.assertEqual(sorted(path.name for path in (self.folder / "out").iterdir()),
                         ["water_0000.npy", "water_0001.npy", "water_0002.npy"])

    def test_files_that_are_there_can_be_left_alone(self):
        (self.folder / "w_0001.npy").write_text("mine")
        command = (*SMALL, "--steps", 20, "-o", "w_####.npy")
        run = self.simulate(*command, "--no-clobber")
        self.assertIn("1 of 3 frames exist already", run.err)
        self.assertEqual((self.folder / "w_0001.npy").read_text(), "mine")
        last = (self.folder / "w_0002.npy").read_bytes()
        self.simulate(*command, "-q")
        self.assertEqual((self.folder / "w_0002.npy").read_bytes(), last)
        self.assertNotEqual((self.folder / "w_0001.npy").read_bytes(), b"mine")

    def test_the_printed_rule_is_told(self):
        run = self.simulate(*SMALL, "--steps", 20, "--rule", "printed", "--friction", 0, "-o", "w.npy")
        self.assertRegex(run.err, r"note\[simulation-limits\]: \d+ of 432 cells have a depth below 0, which the printed rule allows")
        run = self.run_program(*SMALL, "--steps", 2000, "--rule", "printed", "--friction", 0, "-o", "x.npy")
        self.assert_fails(4, run, "step 2000", "of terrain plus water below 65536 cells")
        self.assertEqual(self.files(), ["w.npy"])
        # The limit of --flow-div and --friction belongs to the conservative rule.
        run = self.simulate(*SMALL, "--steps", 20, "--rule", "printed", "--friction", 0.5, "-o", "w.npy")
        self.assertNotIn("come to rest", run.err)
        run = self.simulate(*SMALL, "--steps", 100, "--friction", 0, "-o", "w.npy")
        self.assertNotIn("below 0", run.err)
        self.assertIn("note[simulation-limits]: the water does not come to rest with --flow-div 6 and --friction 0", run.err)
        self.assertNotIn("come to rest", self.simulate(*SMALL, "--steps", 10, "-o", "w.npy").err)

    def test_what_makes_no_sense(self):
        def refused(*arguments):
            run = self.run_program(*arguments)
            self.assertEqual(self.files(), [])
            return run

        self.assert_fails(1, refused("simulate"), "simulate needs a subcommand, one of water")
        self.assert_fails(1, refused("simulate", "wtaer"), "found 'wtaer'", "did you mean 'water'?")
        self.assert_fails(1, refused(*WATER), "expected -o FILE, the output file of the simulation, found none", "water_{:04}.nrrd")
        self.assert_fails(1, refused(*WATER, "-o", "w.glb"), "expected a name that ends in .npy, .nrrd, .raw, .vdb")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "x.vdb"), "unexpected argument 'x.vdb'")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--stpes", "3"), "'--stpes' for 'simulate water'", "'--steps'")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--every", "5"), "no placeholder for the frame number")
        self.assert_fails(1, refused(*WATER, "-o", "w_{}.npy", "--steps", "25"), "a multiple of --every (10 by default)",
                          "--steps 30")
        self.assert_fails(1, refused(*WATER, "-o", "w_{iso}.npy"), "no iso value")
        self.assert_fails(1, refused(*WATER, "-o", "w_{}.npy", "--what", "both"), "{grid}")
        self.assert_fails(1, refused(*WATER, "-o", "w_{grid}.nrrd", "--what", "heights"), "NPY")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--source", "96,0,1"), "--source 96,0,1", "96 x 96")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--drain", "1,2"), "--drain", "X,Y,RATE")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--friction", "1.1"), "--friction", "0 to 1")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--flow-div", "0.5"), "--flow-div", "1 or more")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--size", "1x5"), "--size", "NXxNY")
        self.assert_fails(1, refused(*WATER, "-o", "w.npy", "--rule", "print"), "conservative, printed")
        self.assert_fails(4, refused(*WATER, "-o", "none/w.npy"), "no such folder", "--mkdir")
        self.assert_fails(2, refused(*WATER, "-o", "w.npy", "--memory-limit", "100K"), "--memory-limit")

    def test_help_and_completions_know_the_sub_command(self):
        self.assertIn("simulate water ", self.run_program("simulate", "--help").text)
        page = self.run_program(*WATER, "--help").text
        self.assertIn("Usage: isoextract simulate water -o FILE [options]", page)
        self.assertTrue(all(len(line) <= 80 for line in page.splitlines()))
        for option in ("--rule", "--source", "--flow-div", "--every", "--what"):
            self.assertIn(option, page)
        self.assertIn("OPTIONS OF SIMULATE WATER", self.run_program("generate", "man").text)
        (self.folder / "completion").write_text(self.run_program("generate", "bash").text)
        for line, wanted in (("isoextract simulate ", "water"), ("isoextract simulate water --rul", "--rule"),
                             ("isoextract simulate water --rule ", "conservative printed")):
            script = 'source completion; COMP_LINE=$1 COMP_POINT=${#1}; _isoextract; echo "${COMPREPLY[@]}"'
            run = subprocess.run(["bash", "--norc", "-c", script, "bash", line], cwd=self.folder, capture_output=True,
                                 text=True, check=True)
            self.assertIn(wanted, run.stdout.strip())


if __name__ == "__main__":
    main()
