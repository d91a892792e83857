"""How the tests limit a run: by its processor time, not by how long a busy machine lets it wait."""

import sys
import unittest

import support


class LimitTest(unittest.TestCase):
    def setUp(self):
        before = support.PROCESSOR_SECONDS
        self.addCleanup(setattr, support, "PROCESSOR_SECONDS", before)
        support.PROCESSOR_SECONDS = 1

    def run_python(self, text, **options):
        return support.run_limited([sys.executable, "-c", text], **options)

    def test_waiting_is_not_limited(self):
        self.assertEqual(self.run_python("import time; time.sleep(3)").returncode, 0)

    def test_work_is_limited(self):
        with self.assertRaisesRegex(AssertionError, "more than 1 s of processor time"):
            self.run_python("while True: pass")

    def test_what_a_test_wants_before_the_program_starts_is_done(self):
        run = self.run_python("import os; print(os.umask(0))", preexec_fn=lambda: support.os.umask(0o123), capture_output=True)
        self.assertEqual(run.stdout, b"83\n")


if __name__ == "__main__":
    unittest.main()
