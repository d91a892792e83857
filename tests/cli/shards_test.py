"""Shards: what merge joins and what it misses, other numbers of shards, and the files that shards have beside meshes."""

import csv
import io
import os

from support import main
from sharded_frames import FRAMES, RAW, ShardedFramesTest


class ShardsTest(ShardedFramesTest):
    # Frames that are missing

    def test_merge_names_frames_that_never_were_there(self):
        self.write_frames((1, 2, 3, 4, 5, 6, 7, 9, 10))
        self.run_shards(3, "--frames", "1-12", code=5)
        run = self.run_program("merge", "out")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("9 frames of 3 shards\n", run.err)
        self.assertIn("3 requested frames have no input: 8,11-12", run.err)
        self.assertNotIn(", complete", run.err)
        self.assertIn("0 of 9 frames done, 9 kept", self.run_program(*FRAMES, "--resume").err)

    def test_merge_names_the_one_frame_that_never_was_there(self):
        self.write_frames((1, 2, 4))
        self.run_shards(2, "--frames", "1-4", code=5)
        run = self.run_program("merge", "out")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("1 requested frame has no input: 3", run.err)

    def test_frames_that_may_be_absent_are_not_missed(self):
        self.write_frames((1, 2, 4))
        self.run_shards(2, "--frames", "1-4", code=5)
        self.run_shards(2, "--frames", "1-4", "--missing", "note", "--resume")
        self.assertIn("3 frames of 2 shards, complete", self.convert("merge", "out").err)
        self.run_shards(2)
        self.assertIn("3 frames of 2 shards, complete", self.convert("merge", "out").err)

    def test_a_frame_that_comes_later_is_added(self):
        self.write_frames((1, 2, 4, 5))
        self.run_shards(2, "--frames", "1-5", code=5)
        self.write_frames((3,))
        self.run_shards(2, "--frames", "1-5", "--resume")
        self.assertIn("5 frames of 2 shards, complete", self.convert("merge", "out").err)

    def test_merge_names_frames_that_failed(self):
        self.write_frames(range(1, 9))
        for number in (2, 5, 6):
            (self.folder / f"in_{number:02}.raw").write_bytes(b"short")
        self.run_shards(2, code=5)
        self.assert_fails(2, self.run_program("merge", "out"), "expected 8 frames, found 5: 3 are missing: 2,5-6")
        self.write_frames((2, 6))
        self.run_shards(2, "--resume", code=0, which=(2,))
        self.run_shards(2, "--resume", code=5, which=(1,))
        self.assert_fails(2, self.run_program("merge", "out"), "expected 8 frames, found 7: 1 is missing: 5")

    # Other numbers of shards, other batches

    def test_another_number_of_shards_goes_on(self):
        self.write_frames(range(1, 9))
        self.run_shards(2, "--fail-fast", which=(1,))
        runs = self.run_shards(3, "--resume")
        self.assertEqual([run.count("frames done, ") for run in runs], [1, 1, 1], runs)
        self.assertIn("1 of 3 frames done, 2 kept", runs[0])
        self.assertIn("8 frames of 3 shards, complete", self.convert("merge", "out").err)
        self.assertIn("8 frames of 3 shards, complete", self.convert("merge", "out").err)

    def test_another_number_of_shards_after_a_merge_makes_nothing_again(self):
        self.write_frames(range(1, 9))
        self.run_shards(2)
        self.convert("merge", "out")
        for run in self.run_shards(3, "--resume"):
            self.assertRegex(run, "0 of [23] frames done, [23] kept")
        self.assertIn(", complete", self.convert("merge", "out").err)

    def test_a_joined_batch_is_not_in_the_way_of_the_next(self):
        self.write_frames(range(1, 5))
        self.run_shards(2)
        self.convert("merge", "out")
        for number in (1, 2, 3):
            self.convert("in_{:02}.raw", *RAW, "--normals", "flat", "-o", "out/n_{:02}.ply", "--shard", f"{number}/3")
        self.assertIn("4 frames of 3 shards, complete", self.convert("merge", "out").err)

    def test_a_newer_group_of_shards_that_has_not_all_frames_is_passed_over(self):
        self.write_frames(range(1, 9))
        self.run_shards(3)
        for number in (1, 2, 3):
            os.utime(self.folder / f"out/isoextract.{number}-of-3.manifest", (1, 1))
        self.run_shards(2, "--resume", which=(1,))
        self.assertIn("8 frames of 3 shards, complete", self.convert("merge", "out").err)

    def test_two_batches_that_are_not_joined_are_told_with_a_hint(self):
        self.write_frames(range(1, 5))
        self.run_shards(2)
        os.utime(self.folder / "out/isoextract.1-of-2.manifest", (1, 1))
        os.utime(self.folder / "out/isoextract.2-of-2.manifest", (1, 1))
        for number in (1, 2, 3):
            self.convert("in_{:02}.raw", *RAW, "--normals", "flat", "-o", "out/n_{:02}.ply", "--shard", f"{number}/3")
        run = self.run_program("merge", "out")
        self.assert_fails(2, run, "this manifest and out/isoextract.1-of-2.manifest are of different batches", "remove the manifests",
                          ": out/isoextract.1-of-2.manifest out/isoextract.2-of-2.manifest\n")
        for number in (1, 2):
            (self.folder / f"out/isoextract.{number}-of-2.manifest").unlink()
        self.assertIn("4 frames of 3 shards, complete", self.convert("merge", "out").err)

    # What job schedulers say

    def test_a_job_of_kubernetes_without_its_number_of_parts_is_told_what_to_set(self):
        self.write_frames((1, 2, 3))
        run = self.run_program(*FRAMES, "--shard", "auto", env=dict(os.environ, JOB_COMPLETION_INDEX="0"))
        self.assert_fails(1, run, "but JOB_COMPLETIONS, the number of shards, is missing", "spec.completions",
                          '(name: JOB_COMPLETIONS, value: "8")')
        run = self.run_program(*FRAMES, "--shard", "auto", env=dict(os.environ, JOB_COMPLETION_INDEX="0", JOB_COMPLETIONS="2"))
        self.assertIn("2 of 2 frames done", run.err)

    # Files beside the meshes

    def rows(self, name):
        return [row["frame"] for row in csv.DictReader(io.StringIO((self.folder / name).read_text(), newline=""))]

    def test_each_shard_has_a_table_of_its_own(self):
        self.write_frames(range(1, 6))
        self.convert(*FRAMES[:-1], "whole/m_{:02}.ply", "--table", "whole.csv")
        for run in self.run_shards(2, "--table", "out/t.csv"):
            self.assertRegex(run, r"note\[shard\]: out/t\.[12]-of-2\.csv: covers the frames of this shard only; to cover all frames, run isoextract merge")
        self.assertEqual(self.rows("out/t.1-of-2.csv"), ["1", "3", "5"])
        self.assertEqual(self.rows("out/t.2-of-2.csv"), ["2", "4"])
        self.assertFalse((self.folder / "out/t.csv").exists())
        self.convert("merge", "out")
        self.convert(*FRAMES, "--resume", "--table", "out/t.csv")
        tables = [list(csv.DictReader(io.StringIO((self.folder / name).read_text(), newline="")))
                  for name in ("out/t.csv", "whole.csv")]
        columns = ("frame", "triangles", "vertices", "area", "volume", "closed", "components", "bytes")
        self.assertEqual(*([[row[name] for name in columns] for row in table] for table in tables))
        self.assertTrue(all(row["area"] for row in tables[0]))

    def test_each_shard_has_pages_of_its_own(self):
        self.write_frames(range(1, 5))
        self.run_shards(2, "--html", "page.html", "--plot", "plot.svg", "--table", "t.json")
        for name in ("page.{}-of-2.html", "plot.{}-of-2.svg", "t.{}-of-2.json"):
            for number in (1, 2):
                self.assertTrue((self.folder / name.format(number)).exists(), name)
            self.assertFalse((self.folder / name.replace(".{}-of-2", "")).exists(), name)
        self.convert(*FRAMES, "--shard", "1/1", "--table", "t.csv")
        self.assertEqual(self.rows("t.csv"), ["1", "2", "3", "4"])


if __name__ == "__main__":
    main()
