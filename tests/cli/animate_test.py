"""--animate: all frames in one GLB, the same bytes however many run side by side and however often it was ended."""

import json
import os
import random
import signal
import struct
import subprocess

from support import PROGRAM, SOURCE, ProgramTest, main, needs_program, read_glb

MOVING = "demo:metaballs?size=24&time=0.{:02}"


class Animated:
    """The nodes of an animated GLB: names, vertices, and when each is shown."""

    def __init__(self, path):
        data = path.read_bytes()
        (length,) = struct.unpack_from("<I", data, 12)
        self.model, binary = json.loads(data[20:20 + length]), data[28 + length:]
        self.nodes = {node["name"]: node for node in self.model["nodes"]}
        self.shown = {}
        self.length = 0  # in seconds

        def floats(accessor):
            view = self.model["bufferViews"][accessor["bufferView"]]
            width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
            start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            return struct.unpack_from(f"<{width * accessor['count']}f", binary, start)[::width]

        for channel in self.model["animations"][0]["channels"]:
            sampler = self.model["animations"][0]["samplers"][channel["sampler"]]
            times, sizes = (floats(self.model["accessors"][sampler[end]]) for end in ("input", "output"))
            self.length = max(self.length, *times)
            name = self.model["nodes"][channel["target"]["node"]]["name"]
            hidden = [time for time, size in zip(times, sizes) if size == 0]
            self.shown[name] = (times[sizes.index(1)], max(hidden) if hidden and sizes[-1] == 0 else None)

    def vertices(self, node):
        """Of a node's mesh, or of each of the nodes below it."""
        if "mesh" not in node:
            return [self.vertices(self.model["nodes"][child]) for child in node["children"]]
        (primitive,) = self.model["meshes"][node["mesh"]]["primitives"]
        return self.model["accessors"][primitive["attributes"]["POSITION"]]["count"]


class AnimateTest(ProgramTest):
    def test_frames_of_a_file_start_at_its_times(self):
        frame = "1\nProperties=pos:R:3 Time={}\n1 1 1\n"
        run = {}
        for name, times in (("even", (5, 7, 9, 11)), ("uneven", (5, 6, 9, 11)), ("none", (5, "x", 9, 11))):
            (self.folder / f"{name}.xyz").write_text("".join(frame.format(time) for time in times))
            run[name] = self.animate("-o", f"{name}.glb", "--fps", "10", inputs=(f"{name}.xyz", "--volume", "all", "--radius", "1"))
        self.assertIn("note[animation-times]: uneven.glb: the frames start at their times in uneven.xyz, 5 to 11; a second of the "
                      "animation covers 20 of this time; --fps 10 is the mean", run["uneven"].err)
        for name, starts in (("even", (0, 0.1, 0.2, 0.3)), ("uneven", (0, 0.05, 0.2, 0.3)), ("none", (0, 0.1, 0.2, 0.3))):
            played = Animated(self.folder / f"{name}.glb")
            self.assertAlmostEqual(played.length, 0.4, places=6)
            for k, start in enumerate(starts):
                self.assertAlmostEqual(played.shown[f"{name}_{k:04}"][0], start, places=6)
            if name != "uneven":
                self.assertNotIn("animation-times", run[name].err)

    def write_frames(self, numbers):
        """Raw files of 6 x 6 x 6 bytes with one voxel that is inside."""
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number
            (self.folder / f"in_{number:03}.raw").write_bytes(bytes(samples))

    def animate(self, *arguments, code=0, inputs=("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50"), **options):
        run = self.run_program(*inputs, "--animate", *arguments, **options)
        self.assertEqual(run.code, code, run.err)
        return run

    def moving(self, last, *arguments, **options):
        return self.animate("--frames", f"0-{last}", *arguments, inputs=(MOVING, "--iso", "0.5"), **options)

    def test_each_frame_is_a_node_with_what_a_conversion_of_its_own_gives(self):
        self.write_frames((1, 2, 3, 7))
        run = self.animate("-o", "water.glb", "--fps", "25", "--table", "t.csv", "--report", "r_{}.json")
        for part in ("4 of 4 frames done", "water.glb: 25 frames per second", "the inputs lack the frames 4-6"):
            self.assertIn(part, run.err)
        played = Animated(self.folder / "water.glb")
        self.assertEqual(sorted(played.shown), ["water_0001", "water_0002", "water_0003", "water_0007"])
        for number, shown in ((1, (0, 1 / 25)), (3, (2 / 25, 6 / 25)), (7, (6 / 25, None))):
            self.convert(f"in_{number:03}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "one.glb")
            (alone,) = read_glb((self.folder / "one.glb").read_bytes()).values()
            self.assertEqual(played.vertices(played.nodes[f"water_{number:04}"]), len(alone.vertices))
            for found, wanted in zip(played.shown[f"water_{number:04}"], shown):
                self.assertEqual(found is None, wanted is None)
                self.assertAlmostEqual(found or 0, wanted or 0, places=6)
        self.assertIn("water.glb,done", (self.folder / "t.csv").read_text())
        report = json.loads((self.folder / "r_7.json").read_text())
        self.assertEqual((report["status"], report["files"], len(report["meshes"])), ("done", [], 1))

    @needs_program("node")
    def test_the_validator_of_gltf_finds_nothing(self):
        self.write_frames((1, 2, 4))
        self.animate("-o", "w.glb", "--iso", "20")
        run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", self.folder / "w.glb"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_packed_frames_need_memory_beside_others(self):
        """If packing finds no room beside waiting frames, the program drops these from memory."""
        for limit, jobs in ((None, 1), ("360K", 1), ("360K", 6), ("450K", 6)):
            limits = ["--memory-limit", limit] if limit else []
            self.moving(8, "--draco", "--jobs", jobs, "--threads", "6", *limits, "-o", f"{limit}{jobs}/w.glb", "--mkdir")
        files = {path.read_bytes() for path in self.folder.glob("*/w.glb")}
        self.assertEqual(len(files), 1)

    def test_what_is_there_in_place_of_nothing_is_not_left(self):
        self.write_frames((1, 2))
        arguments = ("-o", "e.glb", "--empty", "skip", "--iso", "250")
        inputs = ("in_{:03}.raw", "--dims", "6,6,6")
        self.animate(*arguments, inputs=inputs)
        self.assertIn("stays unchanged", self.animate(*arguments, "--resume", inputs=inputs).err)
        (self.folder / "e.glb").write_text("foreign")
        self.animate(*arguments, "--resume", inputs=inputs)
        self.assertFalse((self.folder / "e.glb").exists())

    def test_rates_that_no_frame_can_have_are_refused_at_once(self):
        self.write_frames((1, 2, 3))
        for rate in ("1e-300", "1e300", "1e-39"):
            run = self.animate("-o", "w.glb", "--fps", rate, code=1)
            self.assertIn("frames per second", run.err)
        self.assertEqual([name for name in self.files() if not name.endswith(".raw")], [])

    @needs_program("node")
    def test_packed_frames(self):
        """Each as a conversion of its own packs it, on one lattice, and told in the frame's report."""
        for options in (["--draco"], ["--quantize", "--meshopt", "--optimize-order"]):
            with self.subTest(options=options):
                self.moving(4, *options, "-o", "w.glb", "--report", "r_{}.json")
                run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", self.folder / "w.glb"],
                                     capture_output=True, text=True, check=False)
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
                self.convert(MOVING.format(3), "--iso", "0.5", *options, "-o", "one.glb", "--report", "one.json")
                (alone,) = json.loads((self.folder / "one.json").read_text())["packings"]
                (packed,) = json.loads((self.folder / "r_3.json").read_text())["packings"]
                for fact in ("compression", "bytes_before", "bytes_after", "positions", "flattened_triangles"):
                    self.assertEqual(packed[fact], alone[fact], fact)
                steps = {json.loads((self.folder / f"r_{frame}.json").read_text())["packings"][0]["positions"]["step"]["world"]
                         for frame in range(5)}
                self.assertEqual(len(steps), 1)

    def test_surfaces_are_below_the_frame(self):
        self.write_frames((1, 2))
        self.animate("-o", "w.glb", "--iso", "20")
        played = Animated(self.folder / "w.glb")
        self.assertEqual(sorted(played.shown), ["w_0001", "w_0002"])
        self.assertEqual(played.vertices(played.nodes["w_0002"]), [6, 6])
        (self.folder / "iso.csv").write_text("frame,iso\n1,50\n2,20\n2,50\n")
        self.animate("-o", "t.glb", "--iso-table", "iso.csv", inputs=("in_{:03}.raw", "--dims", "6,6,6"))
        played = Animated(self.folder / "t.glb")
        self.assertEqual([played.vertices(played.nodes[name]) for name in ("t_0001", "t_0002")], [6, [6, 6]])

    def test_frames_without_a_surface(self):
        self.write_frames((1, 2, 3))
        (self.folder / "in_002.raw").write_bytes(bytes(216))
        run = self.animate("-o", "w.glb", code=5)
        self.assertIn("frame 2: ", run.err)
        self.assertEqual(Animated(self.folder / "w.glb").shown["w_0001"][1], Animated(self.folder / "w.glb").shown["w_0003"][0])
        for empty in ("skip", "write"):
            self.animate("-o", f"{empty}.glb", "--empty", empty)
            shown = Animated(self.folder / f"{empty}.glb").shown
            self.assertEqual(sorted(shown), [f"{empty}_0001", f"{empty}_0003"])
            self.assertAlmostEqual(shown[f"{empty}_0001"][1], 1 / 24, places=6)
        run = self.animate("-o", "w.glb", "--empty", "skip", inputs=("in_{:03}.raw", "--dims", "6,6,6", "--iso", "250"))
        self.assertIn("no frame has a surface; the run did not write w.glb and removed the old file", run.err)
        self.assertNotIn("w.glb", self.files())

    def test_a_frame_that_fails_is_left_out(self):
        self.write_frames(range(1, 6))
        whole = (self.folder / "in_003.raw").read_bytes()
        (self.folder / "in_003.raw").write_bytes(whole[:100])
        run = self.animate("-o", "w.glb", "--jobs", "3", code=5)
        self.assertIn("frame 3: in_003.raw: expected 216 bytes", run.err)
        self.assertIn("w.glb lacks the frames that failed: 3; the animation shows the preceding frame during their time", run.err)
        shown = Animated(self.folder / "w.glb").shown
        self.assertEqual(sorted(shown), [f"w_000{k}" for k in (1, 2, 4, 5)])
        self.assertEqual(shown["w_0002"][1], shown["w_0004"][0])
        run = self.animate("-o", "w.glb", "--resume", code=5)  # it is not done: not left alone
        (self.folder / "in_003.raw").write_bytes(whole)
        run = self.animate("-o", "w.glb", "--resume")
        self.assertIn("5 of 5 frames done", run.err)
        (self.folder / "in_004.raw").write_bytes(b"short")
        before = (self.folder / "w.glb").read_bytes()
        run = self.animate("-o", "w.glb", "--fail-fast", code=5)
        self.assertIn("the run did not write w.glb", run.err)
        self.assertEqual((self.folder / "w.glb").read_bytes(), before)
        for number in (1, 2, 3, 5):
            (self.folder / f"in_{number:03}.raw").write_bytes(b"short")
        run = self.animate("-o", "none.glb", code=5)
        self.assertIn("5 of 5 frames failed", run.err)
        self.assertNotIn("none.glb", self.files())

    def test_frames_that_fail_first_and_last_keep_their_time(self):
        self.write_frames(range(1, 8))
        for number in (1, 2, 4, 6, 7):
            (self.folder / f"in_{number:03}.raw").write_bytes(bytes(216))
        run = self.animate("-o", "w.glb", code=5)
        self.assertIn("w.glb lacks the frames that failed: 1-2,4,6-7; the animation shows nothing during the time of 1-2, and the "
                      "preceding frame during the time of the others", run.err)
        played = Animated(self.folder / "w.glb")
        for found, frame in ((played.shown["w_0003"][0], 2), (played.shown["w_0003"][1], 4), (played.shown["w_0005"][0], 4),
                             (played.length, 7)):
            self.assertAlmostEqual(found, frame / 24, places=6)
        self.assertIsNone(played.shown["w_0005"][1])
        self.write_frames((4, 6, 7))
        run = self.animate("-o", "w.glb", code=5)
        self.assertIn("that failed: 1-2; the animation shows nothing during their time, because no frame precedes them", run.err)

    def test_the_bytes_do_not_depend_on_how_it_was_done(self):
        """Nor on memory: with little of it frames are turned away while they wait, and repeated."""
        inputs = ("demo:gyroid?size=48&time=0.{:02}", "--frames", "0-9", "--iso", "0")
        self.animate("-o", "w.glb", "--jobs", "1", "--threads", "1", "--report", "r_{}.json", inputs=inputs)
        one = (self.folder / "w.glb").read_bytes()
        needs = max(json.loads((self.folder / f"r_{k}.json").read_text())["reserved_memory_bytes"] for k in range(10))
        for arguments in (("--jobs", "2"), ("--jobs", "4", "--threads", "2"), ("--jobs", "3", "--memory-limit", f"{needs}B"),
                          ("--jobs", "4", "--memory-limit", f"{needs * 3 // 2}B"), ("--jobs", "4", "--memory-limit", f"{2 * needs}B")):
            self.animate("-o", "w.glb", *arguments, inputs=inputs)
            self.assertEqual((self.folder / "w.glb").read_bytes(), one, arguments)

    def test_resume_takes_all_or_nothing(self):
        self.moving(9, "-o", "w.glb")
        whole = (self.folder / "w.glb").read_bytes()
        run = self.moving(9, "-o", "w.glb", "--resume", "--table", "t.json")
        self.assertIn("0 of 10 frames done, 10 kept from an earlier run", run.err)
        self.assertIn("w.glb stays unchanged: no frame needs a conversion", run.err)
        rows = json.loads((self.folder / "t.json").read_text())
        self.assertEqual({(row["status"], *row["outputs"]) for row in rows}, {("kept", "w.glb")})
        run = self.moving(9, "-o", "w.glb", "--resume", "--fps", "25")
        self.assertIn("10 of 10 frames done", run.err)
        self.assertNotEqual((self.folder / "w.glb").read_bytes(), whole)
        run = self.moving(9, "-o", "w.glb", "--resume")
        self.assertIn("10 of 10 frames done", run.err)
        self.assertEqual((self.folder / "w.glb").read_bytes(), whole)
        (self.folder / "w.glb").write_bytes(b"another")
        run = self.moving(9, "-o", "w.glb", "--no-clobber")
        self.assertIn("10 kept", run.err)
        self.moving(9, "-o", "w.glb", "--resume")
        self.assertEqual((self.folder / "w.glb").read_bytes(), whole)
        # A frame alone, written under that name, is no animation.
        run = self.run_program(MOVING, "--frames", "3", "--iso", "0.5", "-o", "w.glb", "--resume")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("1 of 1 frame done", run.err)

    def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(self):
        arguments = (40, "-o", "w.glb", "--jobs", "2")
        self.moving(*arguments)
        whole = (self.folder / "w.glb").read_bytes()
        (self.folder / "w.glb").unlink()
        command = [PROGRAM, MOVING, "--iso", "0.5", "--animate", "--frames", "0-40", "-o", "w.glb", "--jobs", "2",
                   "--resume"]
        chance = random.Random(11)
        kills = 0
        for _ in range(300):
            process = subprocess.Popen(command, cwd=self.folder, stderr=subprocess.DEVNULL)
            try:
                process.wait(timeout=chance.uniform(0.005, 0.2))
                (self.folder / "w.glb").unlink()
            except subprocess.TimeoutExpired:
                process.send_signal(chance.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM)))
                process.wait()
                kills += 1
            if (self.folder / "w.glb").exists():
                self.assertEqual((self.folder / "w.glb").read_bytes(), whole)
            if kills == 10:
                break
        self.assertEqual(kills, 10)
        self.moving(*arguments, "--resume")
        self.assertEqual((self.folder / "w.glb").read_bytes(), whole)

    def test_other_ways_to_name_frames(self):
        samples = bytearray(3 * 216)
        for step in range(3):
            samples[216 * step + 86] = 100 + step
        header = "{'descr': '|u1', 'fortran_order': False, 'shape': (3, 6, 6, 6), }".ljust(117) + "\n"
        (self.folder / "steps.npy").write_bytes(b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header.encode() +
                                               bytes(samples))
        self.animate("-o", "out/s.glb", "--mkdir", inputs=("steps.npy", "--volume", "all", "--iso", "50"))
        self.assertEqual(sorted(Animated(self.folder / "out/s.glb").shown), ["s_0000", "s_0001", "s_0002"])
        self.animate("-o", "one.glb", inputs=("demo:sphere?size=12", "--iso", "0"))
        self.assertEqual(sorted(Animated(self.folder / "one.glb").nodes), ["one_0001"])
        self.write_frames((3,))
        self.animate("-o", "{{a}}.glb", "--progress", "json", inputs=("in_003.raw", "--dims", "6,6,6", "--iso", "50"))
        self.assertIn("{a}.glb", self.files())

    def test_a_dry_run_names_the_file(self):
        self.write_frames((1, 2))
        before = self.files()
        run = self.animate("-o", "w.glb", "--fps", "12.5", "--dry-run")
        self.assertIn("frame 2: in_002.raw (216 B) -> w.glb\n", run.text)
        self.assertIn("animation: w.glb, 12.5 frames per second\n", run.text)
        self.assertEqual(self.files(), before)

    def test_what_makes_no_sense_is_refused(self):
        self.write_frames((1, 2))
        inputs = ("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50")
        self.assert_fails(1, self.run_program(*inputs, "-o", "w.glb"), "would both write this file", "--animate")
        for arguments, parts in (
                ((), ("--animate writes all frames into one file and needs its name", "-o water.glb")),
                (("-o", "w_{:03}.glb"), ("this file name contains a placeholder for 'frame'",)),
                (("-o", "w_{iso}.glb"), ("this file name contains a placeholder for 'iso'",)),
                (("-o", "w/"), ("this path is a folder",)),
                (("-o", "."), ("this path is a folder",)),
                (("-o", "-", "--format", "glb"), ("not to stdout",)),
                (("-o", "w.ply"), ("--animate writes glb, found ply", "each frame gets its own file")),
                (("-o", "w.glb", "--format", "gltf"), ("--animate writes glb, found gltf",)),
                (("-o", "w.glb", "--ascii"), ("--ascii applies to ply and stl only, found glb",)),
                (("-o", "w.glb", "--fps", "0"), ("--fps: expected a number above 0, found '0'",)),
                (("-o", "w.glb", "--fps", "nan"), ("--fps: expected a number above 0",)),
                (("-o", "w.glb", "--fps", "inf"), ("--fps: expected a number above 0",)),
                (("-o", "w.glb", "--shard", "2/3"), ("this process converts shard 2/3", "run on one machine")),
                (("-o", "w.glb", "--explain"), ("--explain",)),
                (("-o", "in_001.raw", "--format", "glb"), ("in_001.raw", "it is not overwritten")),
                (("-o", "w.glb", "--resume", "--no-clobber"), ("exclude each other",)),
                (("-o", "w.glb", "--report", "r.json"), ("--report r_{:04}.json",))):
            self.assert_fails(1, self.run_program(*inputs, "--animate", *arguments), *parts)
        self.assert_fails(1, self.run_program(*inputs, "-o", "w_{}.glb", "--fps", "24"), "--fps", "give --animate")
        slurm = dict(os.environ, SLURM_ARRAY_TASK_ID="2", SLURM_ARRAY_TASK_MIN="1", SLURM_ARRAY_TASK_COUNT="3")
        self.assert_fails(1, self.run_program(*inputs, "--animate", "-o", "w.glb", "--shard", "auto", env=slurm),
                          "this process converts shard 2/3")
        self.assert_fails(4, self.run_program(*inputs, "--animate", "-o", "none/w.glb"), "there is no such folder", "--mkdir")
        self.assertEqual(self.files(), ["in_001.raw", "in_002.raw"])


if __name__ == "__main__":
    main()
