"""Frames converted in shards, the input for tests of shards and of merge."""

from support import ProgramTest

RAW = ("--dims", "6,6,6", "--iso", "50", "--mkdir")
FRAMES = ("in_{:02}.raw", *RAW, "-o", "out/m_{:02}.ply")


class ShardedFramesTest(ProgramTest):
    def write_frames(self, numbers):
        """Writes raw files of 6 x 6 x 6 bytes with one inside voxel, which give a closed mesh each."""
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number
            (self.folder / f"in_{number:02}.raw").write_bytes(bytes(samples))

    def run_shards(self, count, *arguments, code=0, which=None):
        """Returns the messages of the shards' runs, each of which must end with the exit code."""
        runs = []
        for number in which or range(1, count + 1):
            run = self.run_program(*FRAMES, "--shard", f"{number}/{count}", *arguments)
            self.assertEqual(run.code, code, run.err)
            runs.append(run.err)
        return runs
