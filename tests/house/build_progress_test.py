"""A build without a terminal tells how far it is, also within a long step, and shows what it printed only if it fails."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(sys.argv.pop(1)) / "scripts/build_release.sh"
STEPS = 'echo "[1/3] one"; sleep 2.5; echo "[2/3] two"; printf half; sleep 1.5; echo " a line"; printf "the end"; exit '


class BuildProgressTest(unittest.TestCase):
    def run_build(self, code):
        """What it says, and its log."""
        with tempfile.TemporaryDirectory() as folder:
            script = f'. "{SCRIPT}"; build="$1"; progress_seconds=1; quietly bash -c "$2"'
            run = subprocess.run(["bash", "-uc", script, "bash", folder, STEPS + str(code)], capture_output=True, text=True,
                                 check=False)
            self.assertEqual(run.stdout, "")
            self.assertEqual(run.returncode, code and 1)
            return run.stderr, (pathlib.Path(folder) / "build.log").read_text()

    def test_a_build_that_goes_well(self):
        told, log = self.run_build(0)
        self.assertEqual(log, "[1/3] one\n[2/3] two\nhalf a line\nthe end\n")
        lines = [re.fullmatch(r"isoextract: build: (\d) of 3 steps, (\d+) s", line) for line in told.splitlines()]
        self.assertTrue(all(lines), told)
        self.assertEqual(lines[0][1], "1")
        self.assertEqual(lines[-1][1], "2")
        seconds = [int(line[2]) for line in lines]
        self.assertGreaterEqual(len(seconds), 3)
        self.assertEqual(seconds, sorted(set(seconds)))

    def test_a_build_that_fails(self):
        told, log = self.run_build(3)
        self.assertTrue(told.endswith(log), told)


if __name__ == "__main__":
    unittest.main()
