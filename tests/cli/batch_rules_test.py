"""Sequences: what counts as done, which frames are missing, how failures are reported, and what tables contain."""

import csv
import io
import json
import os
import random
import re
import select
import subprocess
import time

from support import PROGRAM, ProgramTest, main

RAW = ("--dims", "6,6,6", "--iso", "50", "--mkdir")
FRAMES = ("in_{:03}.raw", *RAW)


class BatchRulesTest(ProgramTest):
    def write_frames(self, numbers, name="in_{:03}.raw"):
        """Raw files of 6 x 6 x 6 bytes with one voxel that is inside: a closed mesh each."""
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number
            (self.folder / name.format(number)).write_bytes(bytes(samples))

    def damage(self, *numbers):
        for number in numbers:
            (self.folder / f"in_{number:03}.raw").write_bytes(b"short")

    def names(self, folder="out"):
        return sorted(path.name for path in (self.folder / folder).iterdir() if path.suffix != ".manifest")

    def table(self, name="t.csv"):
        return list(csv.DictReader(io.StringIO((self.folder / name).read_text(), newline="")))

    def run_batch(self, *arguments, code=0, **options):
        run = self.run_program(*FRAMES, *arguments, **options)
        self.assertEqual(run.code, code, run.err)
        return run

    # Names with decimal numbers

    def test_decimal_times_order_the_frames_by_their_value(self):
        times = ("0.25", "0.5", "0.75")
        for i, time_ in enumerate(times):
            (self.folder / f"t_{time_}.raw").write_bytes(bytes(86) + bytes([101 + i]) + bytes(129))
            (self.folder / f"s_1e-{3 - i}.raw").write_bytes(bytes(86) + bytes([101 + i]) + bytes(129))
        (self.folder / "d").mkdir()
        for time_ in times:
            os.link(self.folder / f"t_{time_}.raw", self.folder / "d" / f"t_{time_}.raw")
        names = [f"t_{time_}.raw" for time_ in times]
        for inputs, expected in ((names, names), (("d",), [f"d/{name}" for name in names]),
                                 (("s_1e-1.raw", "s_1e-2.raw", "s_1e-3.raw"), ["s_1e-3.raw", "s_1e-2.raw", "s_1e-1.raw"])):
            with self.subTest(inputs=inputs):
                run = self.convert(*inputs, *RAW, "-o", "o/a.glb", "--animate", "--table", "t.csv")
                self.assertEqual([(row["frame"], row["input"]) for row in self.table()], [(str(i + 1), name) for i, name in enumerate(expected)])
                self.assertIn(f"numbers the frames 1 to 3 by its value, from {expected[0].split('/')[-1]} to {expected[2].split('/')[-1]}", run.err)
                self.assertNotIn("lack the frames", run.err)
        for pattern, listed in (("t_0.{}.raw", "t_0.*.raw"), ("s_1e-{}.raw", "s_1e-*.raw")):
            self.assert_fails(1, self.run_program(pattern, *RAW, "-o", "o/{}.ply"), "expected whole frame numbers, found decimal numbers in the names",
                              f"list the files, without quotes: {listed}")

    # Dry runs, and the volumes of one file

    def test_a_dry_runs_memory_is_that_of_the_largest_of_several_frames_of_one_size(self):
        side = 64
        noise = random.Random(1).randbytes(side**3)
        volumes = [noise[:side * side * layers] + bytes(side * side * (side - layers)) for layers in (1, 2, 4, 64, 16, 20, 24)]
        for number, volume in enumerate(volumes):
            (self.folder / f"h_{number}.raw").write_bytes(volume)
        (self.folder / "all.raw").write_bytes(b"".join(volumes))
        dims = ("--iso", "127.5", "--threads", "1", "-o", "{}.ply", "--dry-run")
        alone = self.convert("h_{}.raw", "--dims", "64,64,64", *dims, "--frames", "3").text
        most = re.search(r"memory: about (\d+) MiB \((.*) for frame 3, 1 at a time\)\n", alone)
        for inputs in (("h_{}.raw", "--dims", "64,64,64"), ("all.raw", "--dims", "64,64,64", "--volume", "all")):
            text = self.convert(*inputs, *dims).text
            self.assertIn(f"memory: about {most[1]} MiB ({most[2]} for frame 3, 1 at a time; largest of the estimates for frames 0, 3, 6)\n", text)
        self.assertIn("frames: 7, 1.75 MiB of inputs;", text)
        (self.folder / "h_3.raw").unlink()
        last = int(re.search(r"memory: about (\d+) MiB \(.* for frame 6, .* frames 0, 4, 6\)",
                             self.convert("h_{}.raw", "--dims", "64,64,64", *dims).text)[1])
        self.assertLess(last, int(most[1]))

    def test_all_volumes_are_those_of_one_file(self):
        for name in ("s_1.raw", "s_2.raw"):
            (self.folder / name).write_bytes(bytes(432))
        raw = ("--dims", "6,6,6", "--iso", "50", "--volume", "all", "-o", "{}.ply")
        for inputs, what in ((("s_{}.raw",), "and the pattern s_{}.raw stands for several"), ((".",), "and the pattern . stands for several"),
                             (("s_1.raw", "s_2.raw"), "found several files")):
            self.assert_fails(1, self.run_program(*inputs, *raw), f"--volume all takes the volumes of one file, {what}",
                              "give one file, and convert each further file in a run of its own")

    # Tables

    def test_each_row_has_the_file_of_its_surface(self):
        self.write_frames((1, 2))
        self.run_batch("--iso", "60", "-o", "out/{}_{iso}.ply", "--table", "t.csv")
        rows = self.table()
        self.assertEqual([(row["frame"], row["iso"], row["output"]) for row in rows],
                         [("1", "50", "out/1_50.ply"), ("1", "60", "out/1_60.ply"), ("2", "50", "out/2_50.ply"), ("2", "60", "out/2_60.ply")])
        for row in rows:
            self.assertEqual(int(row["bytes"]), (self.folder / row["output"]).stat().st_size)
        self.run_batch("--iso", "60", "-o", "out/{}_{iso}.ply", "--table", "again.csv", "--resume")  # kept, from the manifest
        same = [key for key in rows[0] if key not in ("status", "seconds", "memory")]
        self.assertEqual([[row[key] for key in same] for row in self.table("again.csv")], [[row[key] for key in same] for row in rows])
        # Several surfaces in one file have its size each; a model of two files that of both.
        self.run_batch("--iso", "60", "-o", "one/{}.gltf", "--table", "t.csv")
        for row in self.table():
            both = sum((self.folder / row["output"]).with_suffix(suffix).stat().st_size for suffix in (".gltf", ".bin"))
            self.assertEqual((row["output"], int(row["bytes"])), (f"one/{row['frame']}.gltf", both))

    def test_rows_have_the_error_where_it_is_measured(self):
        self.run_program("demo:sphere?size={}", "--frames", "8-16x8", "--iso", "0", "-o", "out/{}.ply", "--mkdir", "--error",
                         "--table", "t.csv", "--report", "r_{}.json")
        rows = self.table()
        self.assertEqual(len(rows), 2)
        for row in rows:
            error = json.loads((self.folder / f"r_{row['frame']}.json").read_text())["meshes"][0]["error"]
            self.assertEqual(float(row["error_rms"]), error["interior"]["rms"]["voxels"])
            self.assertEqual(float(row["error_max"]), error["interior"]["max"]["voxels"])
            self.assertEqual(float(row["coverage_max"]), error["coverage"]["distances"]["max"]["voxels"])
        self.run_program("demo:sphere?size={}", "--frames", "8", "--iso", "0", "-o", "out/{}.ply", "--table", "t.csv")
        self.assertEqual(self.table()[0]["error_rms"], "")

    def test_rows_have_the_time_step_of_the_file(self):
        step = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\nITEM: ATOMS id x y z\n1 1 1 1\n2 2 2 2\n"
        (self.folder / "a.dump").write_text(step.format(0) + step.format(2500))
        self.convert("a.dump", "--volume", "all", "--radius", "1", "-o", "out/{}.ply", "--mkdir", "--table", "t.csv")
        self.assertEqual([(row["frame"], row["step"], row["time"]) for row in self.table()], [("0", "0", ""), ("1", "2500", "")])

    def test_a_dump_that_was_cut_off_in_its_last_frame(self):
        """As where the simulation was ended: the program converts the frames before, with a note about the last one."""
        lammps = "ITEM: TIMESTEP\n{0}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\nITEM: ATOMS id x y z\n1 1 1 1\n2 2 2 2\n"
        xyz = "2\nframe {0}\nH 1 1 1\nH 2 2 2\n"
        for name, frame, cuts in (("a.dump", lammps, (8, 20, 60, 90)), ("a.xyz", xyz, (8, 16, 20))):
            for cut in cuts:
                with self.subTest(name=name, cut=cut):
                    (self.folder / name).write_text(frame.format(0) + frame.format(1) + frame.format(2)[:-cut])
                    info = self.convert("info", name, "--volume", "0")
                    self.assertRegex(info.out.decode(), "frames +2,")
                    told = f"the last frame (2) of {name} is incomplete: "
                    self.assertIn("note[incomplete-frame]: " + told, info.err)
                    run = self.convert(name, "--volume", "all", "--radius", "1", "-o", "out/{}.ply", "--mkdir")
                    self.assertIn("2 of 2 frames", run.err)
                    self.assertIn(told, run.err)
                    self.assert_fails(2, self.run_program(name, "--volume", "2", "--radius", "1", "-o", "x.ply"),
                                      f"{name}: frame 2 is incomplete: ")
                    for made in (self.folder / "out").iterdir():
                        made.unlink()

    def test_empty_surfaces_are_told_as_empty(self):
        self.write_frames((1, 2))
        self.run_batch("--iso", "101.5", "-o", "out/{}_{iso}.ply", "--empty", "skip", "--table", "t.csv")
        self.assertEqual([(row["frame"], row["iso"], row["status"], row["output"]) for row in self.table()],
                         [("1", "50", "done", "out/1_50.ply"), ("1", "101.5", "empty", ""), ("2", "50", "done", "out/2_50.ply"),
                          ("2", "101.5", "done", "out/2_101.5.ply")])
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso", "101.5", "-o", "out/{}.ply", "--empty", "skip", "--table", "t.json")
        self.assertIn("2 of 2 frames done", run.err)
        self.assertEqual([row["status"] for row in json.loads((self.folder / "t.json").read_text())], ["empty", "done"])

    def test_cells_are_no_formulas(self):
        for name in ("=1+1.raw", "+1.raw", "@a.raw"):
            self.write_frames((1,), name)
        run = self.run_program("=1+1.raw", "+1.raw", "@a.raw", *RAW, "--iso", "-1", "--inside", "below", "--empty", "skip", "-o", "./{stem}_{iso}.ply",
                               "--table", "t.csv")
        self.assertEqual(run.code, 0, run.err)
        rows = self.table()
        self.assertEqual({row["input"] for row in rows}, {"'=1+1.raw", "'+1.raw", "'@a.raw"})
        self.assertEqual({row["iso"] for row in rows}, {"50", "-1"})  # numbers stay numbers
        self.assertEqual({row["frame"] for row in rows}, {"1", "2", "3"})

    # What is done

    def test_the_environment_alone_takes_no_frame_away(self):
        self.write_frames(range(1, 6))
        slurm = dict(os.environ, SLURM_ARRAY_TASK_ID="2", SLURM_ARRAY_TASK_MIN="1", SLURM_ARRAY_TASK_COUNT="5")
        kubernetes = dict(os.environ, JOB_COMPLETION_INDEX="2", JOB_COMPLETIONS="5")
        for folder, environment, variable in (("a", slurm, "SLURM_ARRAY_TASK_ID"), ("b", kubernetes, "JOB_COMPLETION_INDEX")):
            run = self.run_batch("-o", folder + "/{}.ply", env=environment)
            self.assertEqual(self.names(folder), ["1.ply", "2.ply", "3.ply", "4.ply", "5.ply"])
            self.assertIn(f"the environment has {variable}, but this run converts all frames: give --shard auto", run.err)
        self.run_batch("-o", "c/{}.ply", "--shard", "auto", env=slurm)
        self.assertEqual(self.names("c"), ["2.ply"])
        self.run_batch("-o", "d/{}.ply", "--shard", "auto", env=kubernetes)
        self.assertEqual(self.names("d"), ["3.ply"])
        self.assert_fails(1, self.run_program(*FRAMES, "-o", "e/{}.ply", "--shard", "auto"), "--shard auto", "SLURM_ARRAY_TASK_ID", "--shard K/N")

    def test_frames_of_the_range_that_are_not_there(self):
        self.write_frames((1, 2))
        run = self.run_batch("--frames", "1-5", "-o", "out/{}.ply", "--table", "t.csv", code=5)
        self.assertEqual(self.names(), ["1.ply", "2.ply"])
        self.assertIn("2 of 2 frames done, 3 missing", run.err)
        self.assertIn("error: 3 requested frames have no input: 3-5\n  hint: --missing note", run.err)
        self.run_batch("--frames", "1-5", "-o", "out/{}.ply", "--missing", "note")
        run = self.run_batch("--frames", "1-5", "-o", "none/{}.ply", "--fail-fast", code=5)
        self.assertFalse((self.folder / "none").exists())
        self.write_frames((4,))
        self.assertIn("note[missing-frames]: the inputs lack the frames 3", self.run_batch("-o", "out/{}.ply").err)  # no range was given
        self.run_batch("-o", "out/{}.ply", "--missing", "error", code=5)
        run = self.run_batch("--frames", "1-5", "-o", "out/{}.ply", "--progress", "json", code=5)
        lines = [json.loads(line) for line in run.err.splitlines() if line.startswith("{")]
        self.assertEqual(lines[-1]["missing"], 2)
        header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 6, 6, 6), }".ljust(117) + "\n"
        both = b"".join((self.folder / f"in_{number:03}.raw").read_bytes() for number in (1, 2))
        (self.folder / "steps.npy").write_bytes(b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header.encode() + both)
        run = self.run_program("steps.npy", "--volume", "all", "--frames", "0-3", "--iso", "50", "-o", "v/{}.ply", "--mkdir")
        self.assertEqual((run.code, self.names("v")), (5, ["0.ply", "1.ply"]))

    def test_no_old_mesh_stays_where_a_frame_fails(self):
        self.write_frames((1, 2, 3))
        self.run_batch("-o", "out/{}.ply")
        old = (self.folder / "out/3.ply").read_bytes()
        self.damage(3)
        run = self.run_batch("-o", "out/{}.ply", "--resume", "--table", "t.csv", code=5)
        self.assertEqual(self.names(), ["1.ply", "2.ply", "3.ply.old"])
        self.assertEqual((self.folder / "out/3.ply.old").read_bytes(), old)
        self.assertIn("note[old-pieces]: this run renamed the old mesh of a failed frame to out/3.ply.old", run.err)
        self.assertIn("the old mesh is now out/3.ply.old", self.table()[2]["error"])
        self.write_frames((3,))
        self.run_batch("-o", "out/{}.ply", "--resume")
        self.damage(3)
        self.run_batch("-o", "out/{}.ply", code=5)
        self.assertEqual(self.names(), ["1.ply", "2.ply", "3.ply.old", "3.ply.old.2"])

    def test_old_models_of_two_files_and_old_pieces_go_together(self):
        self.write_frames((1,))
        for output in (("-o", "a/{}.gltf"), ("-o", "b/{}_{piece}.obj", "--split-components")):
            self.run_batch(*output)
        self.damage(1)
        for output in (("-o", "a/{}.gltf"), ("-o", "b/{}_{piece}.obj", "--split-components")):
            self.run_batch(*output, "--resume", code=5)
        self.assertEqual(self.names("a"), ["1.bin.old", "1.gltf.old"])
        self.assertEqual(self.names("b"), ["1_1.obj.old"])

    def test_a_batch_without_a_finished_frame_leaves_no_manifest(self):
        self.write_frames(range(1, 4))
        self.damage(1, 2, 3)
        self.run_batch("-o", "out/{}.ply", code=5)
        self.assertEqual(list((self.folder / "out").iterdir()), [])
        self.write_frames(range(1, 3))  # --resume works without it, and keeps the frames of its own manifest
        self.run_batch("-o", "out/{}.ply", "--resume", code=5)
        self.assertEqual(self.names(), ["1.ply", "2.ply"])
        self.assertTrue((self.folder / "out/isoextract.manifest").exists())
        self.damage(1, 2)
        self.run_batch("-o", "out/{}.ply", "--resume", code=5)
        self.assertTrue((self.folder / "out/isoextract.manifest").exists(), "an earlier run made it")
        # A shard's stays: merging reads which frames failed.
        self.run_batch("-o", "shards/{}.ply", "--shard", "1/2", code=5)
        self.assertTrue((self.folder / "shards/isoextract.1-of-2.manifest").exists())

    # Reports and notes

    def test_frames_that_fail_for_one_reason_are_told_together(self):
        self.write_frames(range(1, 21))
        self.damage(*range(2, 14))
        (self.folder / "in_020.raw").write_bytes(b"another size")
        run = self.run_batch("-o", "out/{}.ply", "--jobs", "1", code=5)
        told = [line for line in run.err.splitlines() if line.startswith("isoextract: error: frame ")]
        self.assertEqual([line.split(":")[2].strip() for line in told], ["frame 2", "frame 20"])
        self.assertRegex(run.err, r"isoextract: error: 12 frames: expected 216 bytes.*, found 5; first: frame 2; all: 2-13\n")
        self.assertIn("13 of 20 frames failed", run.err)
        run = self.run_batch("-o", "other/{}.ply", "--progress", "json", code=5)
        errors = [json.loads(line)["error"] for line in run.err.splitlines() if '"event":"frame"' in line]
        self.assertEqual(sum(error is not None for error in errors), 13)

    def test_a_line_of_progress_where_there_is_no_terminal(self):
        self.write_frames((1, 2))
        (self.folder / "out").mkdir()
        os.mkfifo(self.folder / "out/2.ply")  # it has no reader: the program waits
        process = subprocess.Popen([PROGRAM, *FRAMES, "-o", "out/{}.ply", "--jobs", "1"], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        start = time.monotonic()
        self.assertTrue(select.select([process.stderr], [], [], 60)[0], "nothing was told")
        self.assertGreater(time.monotonic() - start, 25)
        self.assertRegex(process.stderr.readline().decode(), r"^1/2 frames  .* left\n$")
        process.kill()
        process.communicate()

    def test_a_disk_that_is_full_leaves_no_empty_manifest(self):
        alone = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
        script = 'mount -t tmpfs -o size=64k none out && { head -c 100000 /dev/zero >out/filler || true; } && "$@"; code=$?; ls out >left; exit $code'
        (self.folder / "out").mkdir()
        tried = subprocess.run([*alone, "mount", "-t", "tmpfs", "none", "out"], cwd=self.folder, capture_output=True, text=True, check=False)
        if tried.returncode != 0:
            self.skipTest(f"no small disk can be made here: {tried.stderr.strip()}")
        self.write_frames((1, 2))
        run = subprocess.run([*alone, "bash", "-c", script, "-", PROGRAM, *FRAMES, "-o", "out/{}.ply"], cwd=self.folder, capture_output=True,
                             text=True, timeout=60, check=False)
        self.assertEqual(run.returncode, 4, run.stderr)
        self.assertIn("isoextract.manifest: cannot write: no space left", run.stderr)
        self.assertEqual((self.folder / "left").read_text().split(), ["filler"])


if __name__ == "__main__":
    main()
