"""samples/resumed_batch writes the same meshes as the program, and resumes a run that was ended."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

EXAMPLE, PROGRAM = sys.argv[1:3]
FRAMES = ["demo:sphere?size=12", "demo:sphere?size=13", "demo:sphere?size=14"]


def run(*arguments):
    return subprocess.run(arguments, capture_output=True, text=True, timeout=120)


class ResumedBatch(unittest.TestCase):
    def test_second_run_converts_missing_frames(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder, "meshes")
            first = run(EXAMPLE, out, "0", *FRAMES)
            self.assertEqual(sorted(first.stdout.splitlines()), [f"frame {i}: done" for i in (1, 2, 3)])
            self.assertEqual((first.returncode, first.stderr), (0, ""))
            for number, frame in enumerate(FRAMES, 1):
                alone = pathlib.Path(folder, "alone.ply")
                made = run(PROGRAM, frame, "--iso", "0", "-o", alone)
                self.assertEqual(made.returncode, 0, made.stderr)
                self.assertEqual((out / f"frame_{number:04}.ply").read_bytes(), alone.read_bytes())
            (out / "frame_0002.ply").unlink()
            second = run(EXAMPLE, out, "0", *FRAMES)
            self.assertEqual(sorted(second.stdout.splitlines()),
                             ["frame 1: kept", "frame 2: done", "frame 3: kept"])

    def test_failed_frame_is_printed_with_reason(self):
        with tempfile.TemporaryDirectory() as folder:
            made = run(EXAMPLE, pathlib.Path(folder, "meshes"), "0", FRAMES[0], pathlib.Path(folder, "none.vdb"))
            self.assertEqual(made.returncode, 5)
            self.assertIn("frame 1: done\n", made.stdout)
            self.assertRegex(made.stdout, r"frame 2: failed: .*none\.vdb")


unittest.main(argv=sys.argv[:1])
