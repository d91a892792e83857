"""Sequences: frames found and named, side by side, gone on with after any end, in shards, as tables."""

import csv
import io
import json
import os
import random
import struct
import re
import signal
import subprocess
import time

from support import PROGRAM, ProgramTest, main, read_ply

FRAME = "demo:metaballs?size=24&time=0.{:02}"


class BatchTest(ProgramTest):
    def write_frames(self, numbers, name="in_{:03}.raw"):
        """Raw files of 6 x 6 x 6 bytes with one voxel that is inside: a closed mesh each."""
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number
            (self.folder / name.format(number)).write_bytes(bytes(samples))

    def batch(self, *arguments, code=0):
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50", "--mkdir", *arguments)
        self.assertEqual(run.code, code, run.err)
        return run

    def content(self, folder):
        """Of all files but the manifests."""
        return {path.name: path.read_bytes() for path in (self.folder / folder).iterdir() if path.suffix != ".manifest"}

    def table(self, name):
        return list(csv.DictReader(io.StringIO((self.folder / name).read_text(), newline="")))

    def test_every_frame_is_what_a_conversion_of_its_own_gives(self):
        self.write_frames((1, 2, 3, 7))
        run = self.batch("-o", "out/m_{:04}.ply", "--jobs", "3")
        self.assertIn("4 of 4 frames done", run.err)
        self.assertIn("the inputs lack the frames 4-6", run.err)
        self.assertEqual(sorted(self.content("out")), ["m_0001.ply", "m_0002.ply", "m_0003.ply", "m_0007.ply"])
        for number in (1, 2, 3, 7):
            self.convert(f"in_{number:03}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "one.ply")
            self.assertEqual((self.folder / "one.ply").read_bytes(), self.content("out")[f"m_{number:04}.ply"])

    def test_frames_are_named_in_many_ways(self):
        self.write_frames(range(1, 5))
        for inputs, output, names in (
                (("in_###.raw",), "a/%02d.ply", ["01.ply", "02.ply", "03.ply", "04.ply"]),
                (("in_%03d.raw", "--frames", "2-4x2"), "b/{stem}.ply", ["in_002.ply", "in_004.ply"]),
                (("in_003.raw", "in_001.raw"), "c/{frame:02}_{iso}.ply", ["01_50.ply", "03_50.ply"]),
                ((".",), "d/", ["in_001.glb", "in_002.glb", "in_003.glb", "in_004.glb"])):
            run = self.run_program(*inputs, "--dims", "6,6,6", "--iso", "50", "-o", output, "--mkdir")
            self.assertEqual(run.code, 0, run.err)
            self.assertEqual(sorted(self.content(output.split("/")[0])), names)
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "one.ply")
        self.assert_fails(1, run, "one.ply", "in_001.raw", "in_002.raw")
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "none/{:03}.ply")
        self.assert_fails(4, run, "none: there is no such folder", "--mkdir")
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "-", "--format", "ply")
        self.assert_fails(1, run, "not to stdout")

    def test_a_bad_frame_stops_no_other_and_resume_converts_it_when_fixed(self):
        self.write_frames(range(1, 6))
        (self.folder / "in_003.raw").write_bytes(b"short")
        run = self.batch("-o", "out/{:03}.ply", "--table", "t.csv", code=5)
        self.assertIn("frame 3: in_003.raw: expected 216 bytes", run.err)
        self.assertIn("1 of 5 frames failed", run.err)
        self.assertEqual(sorted(self.content("out")), ["001.ply", "002.ply", "004.ply", "005.ply"])
        rows = self.table("t.csv")
        self.assertEqual([row["status"] for row in rows], ["done", "done", "failed", "done", "done"])
        self.assertIn("expected 216 bytes", rows[2]["error"])
        self.assertEqual((rows[0]["closed"], rows[0]["components"], rows[0]["triangles"]), ("1", "1", "8"))
        self.write_frames((3,))
        run = self.batch("-o", "out/{:03}.ply", "--resume")
        self.assertIn("1 of 5 frames done, 4 kept from an earlier run", run.err)
        (self.folder / "out/002.ply").write_bytes(b"truncated")
        (self.folder / "out/004.ply").unlink()
        run = self.batch("-o", "out/{:03}.ply", "--resume", "--table", "t.json")
        self.assertIn("2 of 5 frames done, 3 kept", run.err)
        self.assertEqual([row["status"] for row in json.loads((self.folder / "t.json").read_text())],
                         ["kept", "done", "kept", "done", "kept"])
        run = self.batch("-o", "out/{:03}.ply", "--resume", "--normals", "flat", "--method", "mt")
        self.assertIn("5 of 5 frames done", run.err)

    def test_the_first_failure_can_end_it(self):
        self.write_frames(range(1, 6))
        (self.folder / "in_002.raw").write_bytes(b"short")
        run = self.batch("-o", "out/{:03}.ply", "--fail-fast", "--jobs", "1", code=5)
        self.assertIn("1 of 5 frames failed, 3 not started", run.err)
        self.assertEqual(sorted(self.content("out")), ["001.ply"])

    def test_frames_in_work_when_another_one_fails_have_not_failed(self):
        side = 100
        for number in (1, 2, 3, 4):
            (self.folder / f"in_{number:03}.raw").write_bytes(random.Random(number).randbytes(side**3) if number != 2 else b"short")
        (self.folder / "out").mkdir()
        (self.folder / "out/m_1.ply").write_bytes(b"old")
        run = self.run_program("in_{:03}.raw", "--dims", f"{side},{side},{side}", "--iso", "127.5", "-o", "out/m_{}.ply",
                               "--fail-fast", "--jobs", "2", "--threads", "2", "--table", "t.csv")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("1 of 4 frames failed, 1 cancelled, 2 not started", run.err)
        self.assertIn("0 of 4 frames done, 1 failed, 1 cancelled, 2 not started", run.err)
        self.assertEqual(run.err.count("isoextract: error: frame"), 1, run.err)
        self.assertEqual([row["status"] for row in self.table("t.csv")], ["cancelled", "failed", "not started", "not started"])
        self.assertEqual(self.content("out"), {"m_1.ply": b"old"})

    def test_a_frame_that_waits_for_its_turn_in_an_animation_is_cancelled_when_the_one_before_fails(self):
        for number, side in ((1, 150), (2, 8), (3, 8)):
            header = f"{{'descr': '|u1', 'fortran_order': False, 'shape': ({side}, {side}, {side}), }}".ljust(117) + "\n"
            samples = bytearray(side**3)
            if number > 1:
                samples[292] = 100
            (self.folder / f"f_{number}.npy").write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", 118) + header.encode() + samples)
        run = self.run_program("f_{}.npy", "--iso", "50", "-o", "a.glb", "--animate", "--fail-fast", "--jobs", "2", "--threads", "2",
                               "--table", "t.csv")
        self.assertIn("1 of 3 frames failed, 1 cancelled, 1 not started", run.err)
        self.assertEqual([row["status"] for row in self.table("t.csv")], ["failed", "cancelled", "not started"])

    def test_what_is_there_can_be_left_alone(self):
        self.write_frames((1, 2))
        (self.folder / "out").mkdir()
        (self.folder / "out/001.ply").write_bytes(b"precious")
        run = self.batch("-o", "out/{:03}.ply", "--no-clobber")
        self.assertIn("1 of 2 frames done, 1 kept", run.err)
        self.assertEqual(self.content("out")["001.ply"], b"precious")

    def test_a_dry_run_does_nothing(self):
        self.write_frames((1, 2, 4))
        before = self.files()
        run = self.batch("-o", "out/{:03}.ply", "--dry-run", "--jobs", "2")
        self.assertEqual(self.files(), before)
        self.assertIn("frame 4: in_004.raw (216 B) -> out/004.ply\n", run.text)
        self.assertIn("missing: 3", run.text)
        self.assertRegex(run.text, r"memory: about \d+ MiB \(")
        self.assertEqual(run.err, "")

    def test_a_dry_runs_memory_is_that_of_the_grid_that_is_extracted_from(self):
        self.write_frames((1, 2))
        batch = ("-o", "out/{:03}.ply", "--resolution", "240", "--threads", "1", "--report", "r_{}.json")
        run = self.batch(*batch, "--dry-run")
        estimate = int(re.search(r"memory: about (\d+) MiB", run.text)[1])
        self.batch(*batch)
        report = json.loads((self.folder / "r_1.json").read_text())
        self.assertGreaterEqual(estimate * 2**20, report["reserved_memory_bytes"])

    def test_iso_values_by_frame(self):
        self.write_frames((1, 2))
        (self.folder / "iso.csv").write_text("frame,iso\n1,50\n2,101.5\n")
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso-table", "iso.csv", "-o", "{frame}_{iso}.ply")
        self.assertEqual(run.code, 0, run.err)
        self.assertTrue({"1_50.ply", "2_101.5.ply"} <= set(self.files()))
        (self.folder / "iso.csv").write_text("frame,iso\n1,50\n")
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso-table", "iso.csv", "-o", "{frame}_{iso}.ply")
        self.assert_fails(2, run, "iso.csv", "2")

    def test_the_volumes_of_a_file_are_frames(self):
        samples = bytearray(4 * 216)
        for step in range(4):
            samples[216 * step + 86] = 100 + step
        header = "{'descr': '|u1', 'fortran_order': False, 'shape': (4, 6, 6, 6), }".ljust(117) + "\n"
        (self.folder / "steps.npy").write_bytes(b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header.encode() +
                                               bytes(samples))
        run = self.run_program("steps.npy", "--volume", "all", "--iso", "50", "-o", "s_{:02}.ply")
        self.assertEqual(run.code, 0, run.err)
        self.write_frames(range(4))
        self.batch("-o", "out/s_{:02}.ply")
        for name, mesh in self.content("out").items():
            self.assertEqual(read_ply((self.folder / name).read_bytes()).vertices, read_ply(mesh).vertices)
        run = self.run_program("steps.npy", "--volume", "all", "--frames", "1-9x2", "--iso", "50", "-o", "o/{}.ply", "--mkdir")
        self.assertEqual(sorted(self.content("o")), ["1.ply", "3.ply"], run.err)

    def test_the_volumes_of_a_raw_file_are_frames(self):
        samples = bytearray(b"head" + bytes(3 * 216))
        for step in range(3):
            samples[4 + 216 * step + 86] = 100 + step
        (self.folder / "steps.raw").write_bytes(bytes(samples))
        raw = ("steps.raw", "--dims", "6,6,6", "--skip", "4", "--iso", "50")
        run = self.run_program(*raw, "-o", "a.ply")
        self.assertEqual(run.code, 2)
        self.assertIn("steps.raw: expected the number of one volume, because the file has 3 volumes", run.err)
        self.assertIn("--volume K, K from 0 to 2", run.err)
        run = self.run_program(*raw, "--volume", "all", "-o", "out/s_{:02}.ply", "--mkdir")
        self.assertEqual(run.code, 0, run.err)
        for step in range(3):
            (self.folder / "one.raw").write_bytes(bytes(samples[4 + 216 * step:4 + 216 * (step + 1)]))
            self.convert("one.raw", "--dims", "6,6,6", "--iso", "50", "-o", "one.ply")
            self.convert(*raw, "--volume", step, "-o", "two.ply")
            one, two, frame = (read_ply((self.folder / name).read_bytes())
                               for name in ("one.ply", "two.ply", f"out/s_{step:02}.ply"))
            self.assertEqual(one.vertices, two.vertices)
            self.assertEqual(one.vertices, frame.vertices)

    def test_a_manifest_has_a_largest_size(self):
        self.write_frames(range(1))
        (self.folder / "out").mkdir()
        with open(self.folder / "out/isoextract.manifest", "wb") as manifest:
            manifest.truncate(2 ** 32 + 1)  # no block of it is on the disk
        run = self.batch("-o", "out/s_{:02}.ply", code=4)
        self.assertIn("isoextract.manifest: expected the manifest of a batch of at most 4 GiB, found", run.err)

    def test_progress_for_programs(self):
        self.write_frames((1, 2))
        (self.folder / "in_002.raw").write_bytes(b"short")
        run = self.batch("-o", "out/{:03}.ply", "--progress", "json", "--jobs", "1", code=5)
        events = [json.loads(line) for line in run.err.splitlines() if line.startswith("{")]
        self.assertEqual([event["event"] for event in events], ["begin", "frame", "frame", "end"])
        self.assertEqual([event["status"] for event in events[1:3]], ["done", "failed"])
        self.assertEqual((events[3]["done"], events[3]["failed"], events[3]["frames"]), (1, 1, 2))

    def test_reports_by_frame_and_a_picture(self):
        self.write_frames((1, 2))
        self.batch("-o", "out/{:03}.ply", "--report", "r_{:02}.json", "--plot", "p.svg")
        report = json.loads((self.folder / "r_02.json").read_text())
        self.assertEqual((report["status"], report["files"][0]["path"]), ("done", "out/002.ply"))
        self.assertIn("components", (self.folder / "p.svg").read_text())
        run = self.run_program("in_{:03}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "o_{}.ply", "--report", "r.json")
        self.assert_fails(1, run, "r.json", "--report r_{:04}.json", "--table")

    def test_two_runs_in_one_folder_do_not_mix(self):
        frame = FRAME.replace("24", "64")  # slow enough that it still runs when the folder has its manifest
        arguments = [PROGRAM, frame, "--frames", "0-99", "--iso", "0.5", "-o", "out/{:02}.ply", "--mkdir", "--jobs", "1"]
        first = subprocess.Popen(arguments, cwd=self.folder, stderr=subprocess.PIPE)
        while first.poll() is None and not (self.folder / "out/isoextract.manifest").exists():
            time.sleep(0.002)
        first.send_signal(signal.SIGSTOP)  # else it may end before the second run looks
        self.assert_fails(4, self.run_program(*arguments[1:]), "another run writes into this folder")
        first.kill()
        first.communicate()
        self.assertEqual(self.run_program(*arguments[1:], "--resume").code, 0)

    def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(self):
        arguments = ["demo:metaballs?size=40&time=0.{:02}", "--frames", "0-59", "--iso", "0.5", "--mkdir", "--jobs", "2",
                     "--table", "t.csv", "-o"]
        run = self.run_program(*arguments, "whole/{:02}.glb")
        self.assertEqual(run.code, 0, run.err)
        whole = self.content("whole")
        self.assertEqual(len(whole), 60)
        chance = random.Random(13)
        kills = 0
        for _ in range(500):
            process = subprocess.Popen([PROGRAM, *arguments, "out/{:02}.glb", "--resume"], cwd=self.folder,
                                       stderr=subprocess.DEVNULL)
            try:
                process.wait(timeout=chance.uniform(0.005, 0.15))
                for path in (self.folder / "out").glob("*.glb"):  # so that there is work for the next run
                    path.unlink()
            except subprocess.TimeoutExpired:
                process.send_signal(chance.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGINT, signal.SIGTERM)))
                process.wait()
                kills += 1
            for path in (self.folder / "out").glob("*.glb"):
                self.assertEqual(path.read_bytes(), whole[path.name], path.name)
            if kills == 25:
                break
        self.assertEqual(kills, 25)
        self.assertEqual(self.run_program(*arguments, "out/{:02}.glb", "--resume").code, 0)
        self.assertEqual(self.content("out"), whole)

    def test_shards_joined_are_one_run(self):
        arguments = [FRAME, "--frames", "0-19", "--iso", "0.5", "--mkdir"]
        self.assertEqual(self.run_program(*arguments, "-o", "whole/{:02}.ply").code, 0)
        shards = [*arguments, "-o", "out/{:02}.ply"]
        self.assertEqual(self.run_program(*shards, "--shard", "1/3").code, 0)
        third = dict(os.environ, SLURM_ARRAY_TASK_ID="3", SLURM_ARRAY_TASK_MIN="1", SLURM_ARRAY_TASK_COUNT="3")
        self.assertEqual(self.run_program(*shards, "--shard", "auto", env=third).code, 0)
        self.assert_fails(2, self.run_program("merge", "out"), "shard 2 of 3 is missing")
        process = subprocess.Popen([PROGRAM, *shards, "--shard", "2/3", "--jobs", "1"], cwd=self.folder,
                                   stderr=subprocess.DEVNULL)
        while process.poll() is None and not (self.folder / "out/01.ply").exists():
            time.sleep(0.001)
        process.kill()
        process.wait()
        if len(self.content("out")) < 20:
            self.assert_fails(2, self.run_program("merge", "out"), "expected 20 frames")
        self.assertEqual(self.run_program(*shards, "--shard", "2/3", "--resume").code, 0)
        run = self.convert("merge", "out")
        self.assertIn("20 frames of 3 shards, complete", run.err)
        self.assertEqual(self.content("out"), self.content("whole"))
        run = self.run_program(*shards, "--resume")
        self.assertIn("0 of 20 frames done, 20 kept", run.err)
        (self.folder / "out/07.ply").write_bytes(b"another")
        self.assert_fails(2, self.run_program("merge", "out"), "out/07.ply: this file has changed since its shard wrote it")

    def four_frames(self, iso, *arguments):
        output = "out/" + iso + "_{:02}.ply"
        return self.convert(FRAME, "--frames", "0-3", "--iso", iso, "-o", output, "--mkdir", *arguments)

    def test_shards_of_other_options_are_joined_as_well(self):
        for iso in ("0.4", "0.5"):
            for shard in ("1/2", "2/2"):
                self.four_frames(iso, "--shard", shard, "--resume")
            self.assertIn("4 frames of 2 shards, complete", self.convert("merge", "out").err)

    def test_records_hold_until_their_frame_is_begun_anew(self):
        self.write_frames((1, 2, 3, 4))
        batch = ("-o", "out/m_{}.ply", "--jobs", "1")
        self.batch(*batch)
        self.assertIn("4 kept", self.batch(*batch, "--no-clobber").err)
        self.assertIn("0 of 4 frames done, 4 kept", self.batch(*batch, "--resume").err)
        sound = (self.folder / "in_001.raw").read_bytes()
        (self.folder / "in_001.raw").write_bytes(sound[:100])
        self.batch(*batch, "--fail-fast", code=5)
        (self.folder / "in_001.raw").write_bytes(sound)
        self.assertIn("1 of 4 frames done, 3 kept", self.batch(*batch, "--resume").err)

    def test_a_frame_that_fails_when_it_is_done_anew_is_missing(self):
        self.write_frames((1, 2, 3, 4))
        for shard in ("1/2", "2/2"):
            self.batch("-o", "out/m_{}.ply", "--shard", shard)
        self.convert("merge", "out")
        (self.folder / "in_001.raw").write_bytes(b"short")
        self.batch("-o", "out/m_{}.ply", "--shard", "1/2", "--resume", code=5)
        self.assert_fails(2, self.run_program("merge", "out"), "expected 4 frames, found 3")

    def test_tables_count_what_was_written(self):
        self.write_frames((1, 2))
        changed = ("-o", "out/m_{}.ply", "--simplify", "0.5", "--largest")
        self.batch(*changed)
        self.batch(*changed, "--resume", "--table", "t.csv")
        counts = [read_ply((self.folder / f"out/m_{number}.ply").read_bytes()) for number in (1, 2)]
        self.assertEqual([int(row["triangles"]) for row in self.table("t.csv")], [len(mesh.triangles) for mesh in counts])
        self.batch("-o", "out/m_{}.ply", "--clip", "1,0,0,99", "--empty", "skip", "--table", "t.csv")
        self.assertEqual([row["triangles"] for row in self.table("t.csv")], ["0", "0"])

    def test_another_batch_in_the_folder_costs_no_work(self):
        self.four_frames("0.4")
        self.four_frames("0.5")
        self.assertIn("0 of 4 frames done, 4 kept", self.four_frames("0.4", "--resume").err)
        self.assertIn("4 of 4 frames done", self.four_frames("0.5").err)


if __name__ == "__main__":
    main()
