"""A machine that gives no more threads: one thread needs no other, and several are refused before the work."""

import json
import os
import resource
import subprocess
import unittest

from support import PROGRAM, SPHERE, ProgramTest, Run, main

# A user that has no process; root has no limit, so it becomes that one.
UNUSED_USER = 54321


def with_no_other_thread():
    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(UNUSED_USER)
        os.setuid(UNUSED_USER)
    resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))


class ThreadsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.folder.chmod(0o777)
        run = self.run_alone("--version")
        if run is None or run.code != 0:
            self.skipTest("another user than root cannot run the program here")

    def run_alone(self, *arguments):
        """The program where the system gives it no second thread; None where it cannot be run like that."""
        try:
            return Run(subprocess.run([PROGRAM, *(str(a) for a in arguments)], cwd=self.folder, capture_output=True,
                                      timeout=120, check=False, preexec_fn=with_no_other_thread))
        except (PermissionError, subprocess.SubprocessError):
            return None

    @unittest.skipIf(os.cpu_count() == 1, "one processor: there is no other thread to refuse")
    def test_several_threads_are_refused_before_the_work(self):
        for arguments in ((SPHERE, "--iso", "0", "-o", "a.ply"), (SPHERE, "--iso", "0", "--threads", "2", "-o", "a.ply"),
                          ("info", SPHERE), ("verify", SPHERE, "--iso", "0"), ("compare", "a.ply", "b.ply"),
                          ("bench", "demo:sphere", "--sizes", "8,16", "--repeats", "1"), ("stability", "--case", "x")):
            run = self.run_alone(*arguments)
            self.assert_fails(3, run, "cannot start ", "threads, only 1: ", "--threads 1")
            self.assertEqual(self.files(), [])
        run = self.run_alone(SPHERE, "--iso", "0", "-o", "a.ply", "--report", "a.json")
        self.assertEqual(run.code, 3)
        report = json.loads((self.folder / "a.json").read_text())
        self.assertEqual((report["error"]["kind"], report["options"]["input"]), ("unavailable", SPHERE))

    def test_drivers_of_gpus_need_threads_of_their_own(self):
        for arguments in ((SPHERE, "--iso", "0", "--backend", "gpu", "-o", "a.ply"), ("verify", SPHERE, "--iso", "0"),
                          (SPHERE, "--iso", "0", "--verify", "-o", "a.ply")):
            run = self.run_alone(*arguments, "--threads", "1")
            self.assert_fails(3, run, "GPU drivers start their own threads", "--backend cpu")
        run = self.run_alone(SPHERE, "--iso", "0", "--backend", "auto", "-o", "a.ply", "--threads", "1")
        self.assertEqual(run.code, 0, run.err)

    def test_one_thread_needs_no_other(self):
        for arguments in ((SPHERE, "--iso", "0", "--error", "--simplify", "0.1", "-o", "a.ply", "--report", "a.json"),
                          ("demo:gyroid?size=64", "--iso", "0", "-o", "a.glb"), ("info", SPHERE),
                          ("verify", "demo:gyroid?size=64", "--iso", "0", "a.glb"), ("compare", "a.glb", "a.glb"),
                          ("bench", "demo:sphere", "--sizes", "8,16", "--repeats", "1", "--backends", "cpu"),
                          ("stability", "--case", "far-frame", "--backends", "cpu")):
            run = self.run_alone(*arguments, "--threads", "1")
            self.assertEqual(run.code, 0, f"{arguments}: {run.err}")
        self.assertEqual(self.files(), ["a.glb", "a.json", "a.ply"])


if __name__ == "__main__":
    main()
