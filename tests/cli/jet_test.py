"""isoextract simulate jet: particles as a sequence of files, and the animation that is made of them."""

import json
import re
import struct
import subprocess

from support import SOURCE, ProgramTest, main, needs_program, read_glb

# A tank of 24 x 16 x 24 with 1500 particles of radius 0.5; they come in over 21 frames.
SCENE = ("--count", "1500", "--radius", "0.5", "--tank", "24x16x24", "--nozzle", "3")
PLY_NAMES = ["x", "y", "z", "velocity_x", "velocity_y", "velocity_z", "age", "id"]


def read_rows(path):
    """Rows of a binary PLY file as simulate writes them: three doubles, then floats."""
    header, _, data = path.read_bytes().partition(b"end_header\n")
    names = re.findall(r"property (?:double|float) (\S+)", header.decode())
    count = int(re.search(r"element vertex (\d+)", header.decode()).group(1))
    rows = list(struct.iter_unpack(f"<3d{len(names) - 3}f", data))
    if len(rows) != count:
        raise AssertionError(f"{path}: {count} particles in the header, {len(rows)} in the file")
    return names, rows


class JetTest(ProgramTest):
    def simulate(self, *arguments, code=0, **options):
        run = self.run_program("simulate", "jet", *arguments, **options)
        self.assertEqual(run.code, code, run.err)
        self.assertEqual(run.out, b"")
        return run

    def test_frames_hold_what_left_the_nozzle(self):
        run = self.simulate(*SCENE, "--frames", "21", "-o", "jet_{:04}.ply")
        self.assertEqual(self.files(), [f"jet_{frame:04}.ply" for frame in range(1, 22)])
        self.assertRegex(run.err, r"1500 particles of radius 0\.5 in the tank; 21 frames in \d+ steps: [\d.]+ million "
                                  r"particles moved, [\d.]+ million per second")
        self.assertIn("-> jet_0001.ply to jet_0021.ply: 21 files", run.err)
        self.assertNotIn("not left the nozzle", run.err)
        for frame in range(1, 22):
            names, rows = read_rows(self.folder / f"jet_{frame:04}.ply")
            self.assertEqual(names, PLY_NAMES)
            # 29 places of the lattice are in a circle of radius 3; at speed 60 a layer leaves every 1/60 s.
            self.assertEqual(len(rows), min(1500, 29 * (frame * 5 // 2 + 1)))
            for number, (x, y, z, *_, age, identity) in enumerate(rows):
                self.assertTrue(max(abs(x) / 24, abs(y) / 16, abs(z) / 24) <= 0.5)
                self.assertEqual(identity, number)
                self.assertAlmostEqual(age, frame / 24 - number // 29 / 60, places=5)
        info = json.loads(self.convert("info", "jet_0021.ply", "--json").text)[0]
        self.assertEqual(info["particles"]["count"], 1500)

    def test_the_same_bytes_for_any_number_of_threads_and_other_ones_for_another_seed(self):
        for name, options in (("one", ("--threads", "1")), ("two", ("--threads", "2")), ("other", ("--seed", "5"))):
            self.simulate(*SCENE, "--frames", "14", *options, "-o", f"{name}.ply")
        one, two, other = ((self.folder / f"{name}.ply").read_bytes() for name in ("one", "two", "other"))
        self.assertEqual(one, two)
        self.assertEqual(len(one), len(other))
        self.assertNotEqual(one, other)

    def test_formats_hold_the_same_numbers(self):
        for extension in ("ply", "npy", "xyz"):
            self.simulate(*SCENE, "--frames", "3", "-o", f"a.{extension}")
        self.simulate(*SCENE, "--frames", "3", "--format", "npy", "-o", "b.bin")
        self.assertEqual((self.folder / "a.npy").read_bytes(), (self.folder / "b.bin").read_bytes())
        meshes = {}
        for extension in ("ply", "npy", "xyz"):
            self.convert(f"a.{extension}", "--particles", "weight", "--radius", "0.5", "--attribute", "velocity", "--attribute",
                         "age", "-o", f"mesh_{extension}.ply")
            meshes[extension] = (self.folder / f"mesh_{extension}.ply").read_bytes()
        self.assertEqual(meshes["ply"], meshes["npy"])
        self.assertEqual(meshes["ply"], meshes["xyz"])
        _, rows = read_rows(self.folder / "a.ply")
        script = ("import numpy as np\na = np.load('a.npy')\nprint(a.dtype.names, len(a), *a['position'][7], "
                  "*a['velocity'][7], a['id'][7])")
        run = subprocess.run(["/usr/bin/python3", "-c", script], cwd=self.folder, capture_output=True, text=True, check=False)
        if "No module named 'numpy'" not in run.stderr:
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertTrue(run.stdout.startswith(f"('position', 'velocity', 'age', 'id') {len(rows)} "), run.stdout)
            found = [float(word) for word in run.stdout.split(") ")[1].split()[1:]]
            x, y, z, *velocity, _, number = rows[7]
            self.assertEqual(found[:3], [x, y, z])
            for one, other in zip(found[3:], [*velocity, number], strict=True):
                self.assertAlmostEqual(one, other, places=4)

    @needs_program("node")
    def test_the_animation_of_the_paper(self):
        """The line that it tells makes one GLB of all frames: closed manifolds at iso value 0.15, weight 0.1."""
        run = self.simulate(*SCENE, "--frames", "24", "-o", "jet_{:04}.ply")
        line = re.search(r"convert with: isoextract (.*)", run.err).group(1)
        self.assertEqual(line, "'jet_{:04}.ply' --particles weight --iso 0.15 --radius 0.5 --animate --fps 24 -o jet.glb")
        self.convert(*line.replace("'", "").split(), "--report", "report_{:04}.json")
        model = (self.folder / "jet.glb").read_bytes()
        (length,) = struct.unpack_from("<I", model, 12)
        nodes = [node["name"] for node in json.loads(model[20:20 + length])["nodes"]]
        for frame in range(1, 25):
            self.assertIn(f"jet_{frame:04}", nodes)
        volumes = []
        for path in sorted(self.folder.glob("report_*.json")):
            (facts,) = json.loads(path.read_text())["meshes"]
            self.assertEqual((facts["closed"], facts["open_edges"], facts["nonmanifold_edges"], facts["misoriented_edges"],
                              facts["nonmanifold_vertices"], facts["zero_area_triangles"]), (True, 0, 0, 0, 0, 0), path.name)
            volumes.append(facts["volume"])
        self.assertEqual(len(volumes), 24)
        # While it comes in, and before it splashes, the jet's surface encloses more and more.
        self.assertEqual(volumes[:6], sorted(volumes[:6]))
        self.assertGreater(volumes[5], 4 * volumes[0])
        # A surface at the outermost samples is wider than the cube of liquid of each particle.
        self.assertTrue(800 < volumes[-1] < 4500, volumes[-1])
        run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", self.folder / "jet.glb"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_one_frame_as_a_mesh(self):
        self.simulate(*SCENE, "--frames", "6", "-o", "last.ply")
        self.convert("last.ply", "--particles", "weight", "--iso", "0.15", "--radius", "0.5", "-o", "last.glb")
        (mesh,) = read_glb((self.folder / "last.glb").read_bytes()).values()
        self.assertEqual(mesh.open_edges(), 0)
        # A bar along x that bends down: in glTF y is up. It is on its way for 1/4 s.
        low, high = mesh.bounds()
        self.assertTrue(-14 <= low[0] <= -11 and 3 <= high[0] <= 7, (low, high))

    def test_standard_output_takes_one_frame(self):
        self.simulate(*SCENE, "--frames", "2", "-o", "a.ply")
        run = self.run_program("simulate", "jet", *SCENE, "--frames", "2", "--format", "ply", "-o", "-")
        self.assertEqual((run.code, run.out), (0, (self.folder / "a.ply").read_bytes()))

    def test_verbose_prints_times_and_memory(self):
        run = self.simulate(*SCENE, "--frames", "2", "-v", "-o", "jet_{}.ply")
        self.assertRegex(run.err, r"(?m)^simulated in [\d.]+ s, written in [\d.]+ s, peak memory [\d.]+ MiB$")

    def test_it_can_be_told_to_be_quiet(self):
        self.assertEqual(self.simulate(*SCENE, "--frames", "2", "-q", "-o", "a_{}.ply").err, "")
        self.assertEqual(self.files(), ["a_1.ply", "a_2.ply"])

    def test_what_is_left_in_the_nozzle_is_told(self):
        run = self.simulate(*SCENE, "--frames", "2", "-o", "a.ply")
        self.assertIn("note[simulation-limits]: 1326 of 1500 particles have not left the nozzle", run.err)

    def test_folders_and_files_that_are_there(self):
        self.simulate(*SCENE, "--frames", "3", "-o", "out/jet_{:02}.ply", "--mkdir")
        first = self.folder / "out/jet_02.ply"
        first.write_bytes(b"mine")
        run = self.simulate(*SCENE, "--frames", "3", "-o", "out/jet_{:02}.ply", "--no-clobber")
        self.assertIn("3 of 3 frames exist already", run.err)
        self.assertEqual(first.read_bytes(), b"mine")

    def test_refusals(self):
        for arguments, code, parts in (
            ((), 1, ("expected -o FILE, the output file of the simulation, found none", "jet_{:04}.ply")),
            (("-o", "a.vdb"), 1, ("a.vdb", ".ply, .npy, .xyz")),
            (("-o", "a_{iso}.ply"), 1, ("{iso}", "no iso value")),
            (("-o", "a.ply", "--count", "0"), 1, ("--count", "'0'")),
            (("-o", "a.ply", "--count", "100000000"), 1, ("1 to 16777216 particles",)),
            (("-o", "a.ply", "--tank", "4x4"), 1, ("--tank", "'4x4'")),
            (("-o", "a.ply", "--speed", "0"), 1, ("--speed",)),
            (("-o", "a.ply", "--gravity", "-1"), 1, ("--gravity",)),
            (("-o", "a.ply", "--viscosity", "0.7"), 1, ("viscosity from 0 to 0.5, found 0.7",)),
            (("-o", "a.ply", "--iterations", "9999999999"), 1, ("a number of iterations from 1 to 1000",)),
            (("-o", "a.ply", "--fps", "0.001"), 1, ("steps (a step moves a particle by at most",)),
            (("-o", "a.ply", "--frames", "0"), 1, ("--frames",)),
            (("-o", "a.ply", "--radius", "2", "--count", "20000"), 1, ("expected at most 3037 particles", "found 20000")),
            (("-o", "a_{}.ply", "--frames", "2000000"), 1, ("--frames 2000000",)),
            (("-o", "a.ply", "--every", "2"), 1, ("--every",)),
            (("-o", "none/a.ply"), 4, ("none",)),
            (("-o", "a.ply", "--count", "1000000", "--memory-limit", "20M"), 2, ("1000000 particles", "--memory-limit")),
        ):
            with self.subTest(arguments):
                self.assert_fails(code, self.run_program("simulate", "jet", *arguments), *parts)
                self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
