"""merge and runs without shards: what one keeps of the other, one shard alone, shards without frames."""

from support import main
from sharded_frames import FRAMES, RAW, ShardedFramesTest


class MergeTest(ShardedFramesTest):
    def test_a_run_without_shards_keeps_what_shards_made_and_merge_sees_it(self):
        for rest in ((), ("--shard", "1/1")):
            with self.subTest(rest=rest):
                self.write_frames(range(1, 9))
                (self.folder / "in_05.raw").write_bytes(b"short")
                for number in (1, 2, 3):
                    run = self.run_program(*FRAMES, "--shard", f"{number}/3")
                    self.assertEqual(run.code, 5 if number == 2 else 0, run.err)
                self.write_frames((5,))
                self.assertIn("1 of 8 frames done, 7 kept", self.convert(*FRAMES, "--resume", *rest).err)
                self.assertIn("8 frames of 3 shards, complete", self.convert("merge", "out").err)
                self.assertIn("8 frames of 3 shards, complete", self.convert("merge", "out").err)
                self.assertIn("0 of 8 frames done, 8 kept", self.convert(*FRAMES, "--resume").err)
                for path in (self.folder / "out").iterdir():
                    path.unlink()

    def test_a_run_without_shards_does_the_part_of_a_shard_that_never_ran(self):
        self.write_frames(range(1, 7))
        self.run_shards(3, which=(1, 3))
        self.assertIn("2 of 6 frames done, 4 kept", self.convert(*FRAMES, "--resume").err)
        self.assertIn("6 frames of 3 shards, complete", self.convert("merge", "out").err)
        self.assertIn("0 of 2 frames done, 2 kept", self.run_shards(3, "--resume", which=(2,))[0])

    def test_frames_that_a_run_without_shards_made_anew_are_its_own(self):
        self.write_frames(range(1, 5))
        self.run_shards(2)
        (self.folder / "in_02.raw").write_bytes(bytes(86) + bytes([200]) + bytes(129))
        self.assertIn("1 of 4 frames done, 3 kept", self.convert(*FRAMES, "--resume").err)
        self.assertIn("4 frames of 2 shards, complete", self.convert("merge", "out").err)

    def test_frames_of_another_batch_are_not_taken_for_those_that_are_missing(self):
        self.write_frames(range(1, 5))
        self.convert("in_{:02}.raw", *RAW, "--normals", "flat", "-o", "out/n_{:02}.ply")
        (self.folder / "in_03.raw").write_bytes(b"short")
        self.run_shards(2, which=(2,))
        self.run_shards(2, which=(1,), code=5)
        self.assert_fails(2, self.run_program("merge", "out"), "expected 4 frames, found 3: 1 is missing: 3")

    def test_one_shard_is_a_batch_of_one_part(self):
        self.write_frames(range(1, 5))
        self.run_shards(1)
        self.assertIn("4 frames of 1 shard, complete", self.convert("merge", "out").err)
        self.convert(*FRAMES[:-1], "an/a.glb", "--animate", "--shard", "1/1")
        self.assertIn("4 frames of 1 shard, complete", self.convert("merge", "an").err)
        (self.folder / "in_02.raw").write_bytes(b"short")
        self.run_shards(1, "--resume", code=5)
        self.assert_fails(2, self.run_program("merge", "out"), "expected 4 frames, found 3: 1 is missing: 2")
        self.run_shards(1, "--frames", "1-6", "--resume", code=5)
        self.assert_fails(2, self.run_program("merge", "out"), "1 is missing: 2", "requested frames without input: 5-6")
        (self.folder / "out/m_01.ply").write_bytes(b"changed")
        self.write_frames((2,))
        self.assertEqual(self.run_program("in_{:02}.raw", *FRAMES[1:], "--frames", "2", "--resume").code, 0)
        self.assertIn("1 frame of 1 shard, complete", self.convert("merge", "out").err)
        self.assert_fails(2, self.run_program("merge", "an/.."), "this folder has no manifest of a shard")

    def test_a_shard_without_frames_makes_its_folder(self):
        self.write_frames((1, 2))
        self.assertIn("0 of 0 frames done", self.run_shards(3, which=(3,))[0])
        self.run_shards(3, which=(1, 2))
        self.assertIn("2 frames of 3 shards, complete", self.convert("merge", "out").err)
        self.assert_fails(4, self.run_program("in_{:02}.raw", "--dims", "6,6,6", "--iso", "50", "-o", "no/{}.ply", "--shard", "3/3"),
                          "no: there is no such folder", "--mkdir")

    def test_a_second_batch_does_not_replace_one_that_is_not_joined(self):
        self.write_frames(range(1, 5))
        self.run_shards(2)
        before = (self.folder / "out/isoextract.1-of-2.manifest").read_bytes()
        second = ("in_{:02}.raw", *RAW, "--normals", "flat", "-o", "out/n_{:02}.ply", "--shard", "1/2")
        for resume in ((), ("--resume",)):
            run = self.run_program(*second, *resume)
            self.assert_fails(4, run, "out/isoextract.1-of-2.manifest: this run would replace the manifest, which has 2 frames of another, unmerged batch",
                              "merge that batch first: isoextract merge out;")
        self.assertEqual((self.folder / "out/isoextract.1-of-2.manifest").read_bytes(), before)
        self.convert("merge", "out")
        self.assertIn("2 of 2 frames done", self.convert(*second).err)
        self.assertIn("0 of 4 frames done, 4 kept", self.convert(*FRAMES, "--resume").err)

    def test_a_second_batch_that_writes_the_same_files_replaces_the_first(self):
        self.write_frames(range(1, 5))
        self.run_shards(2)
        self.run_shards(2, "--normals", "flat")
        self.assertIn("4 frames of 2 shards, complete", self.convert("merge", "out").err)


if __name__ == "__main__":
    main()
