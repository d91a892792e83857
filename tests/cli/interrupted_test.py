"""Runs that a signal ends: nothing unfinished stays, also where a file system has no unnamed files."""

import signal
import subprocess
import time

from support import PROGRAM, SPHERE, ProgramTest, forbid_unnamed_files, main


class InterruptedTest(ProgramTest):
    def start(self):
        """A conversion that has begun to write its file, which has a name from the start."""
        process = subprocess.Popen([PROGRAM, "demo:random?size=128", "--iso", "0", "-o", "out.obj"], cwd=self.folder,
                                   stderr=subprocess.PIPE, preexec_fn=forbid_unnamed_files)
        while process.poll() is None and not self.has_begun():
            time.sleep(0.002)
        return process

    def has_begun(self):
        """Not an empty file: by making one the program tries whether it may write there, before it reads."""
        try:
            return any(path.stat().st_size > 0 for path in self.folder.glob(".isoextract-*"))
        except FileNotFoundError:
            return False

    def end(self, number, wait=0.0):
        """A run that the signal ended. On a busy machine one may be over before: then its file is whole."""
        for _ in range(20):
            process = self.start()
            time.sleep(wait)
            process.send_signal(number)
            _, err = process.communicate(timeout=30)
            if process.returncode != 0:
                self.assertEqual(process.returncode, -number, err)
                return
            self.assertEqual(self.files(), ["out.obj"])
            (self.folder / "out.obj").unlink()
        self.fail(f"20 runs were over before signal {number}")

    def test_interrupted_runs_leave_nothing(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGXCPU, signal.SIGUSR1):
            for wait in (0, 0.02, 0.1):
                self.end(number, wait)
                self.assertEqual(self.files(), [])

    def test_the_next_run_removes_what_a_killed_one_left(self):
        self.end(signal.SIGKILL)
        self.assertEqual(len(self.files()), 1)
        run = self.run_program(SPHERE, "--iso", "0", "-o", "out.ply", preexec_fn=forbid_unnamed_files)
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual(self.files(), ["out.ply"])

    def test_an_ignored_signal_stays_ignored(self):
        process = subprocess.Popen([PROGRAM, "demo:random?size=64", "--iso", "0", "-o", "out.obj"], cwd=self.folder,
                                   stderr=subprocess.DEVNULL,
                                   preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        while process.poll() is None:
            process.send_signal(signal.SIGHUP)
            time.sleep(0.01)
        self.assertEqual(process.returncode, 0)
        self.assertEqual(self.files(), ["out.obj"])


if __name__ == "__main__":
    main()
