"""Runs that a signal ends: nothing unfinished stays, also where a file system has no unnamed files."""

import ctypes
import errno
import os
import platform
import signal
import struct
import subprocess
import time

from support import PROGRAM, SPHERE, ProgramTest, main

# openat by machine: the number of the system call.
OPENAT = {"x86_64": 257, "aarch64": 56}
TMPFILE_BIT = os.O_TMPFILE & ~os.O_DIRECTORY


def forbid_unnamed_files():
    """From now on this process finds no file system with unnamed files (O_TMPFILE): a filter of its system calls."""
    load, jump_equal, jump_set, give = 0x20, 0x15, 0x45, 0x06
    rules = [(load, 0, 0, 0), (jump_equal, 0, 3, OPENAT[platform.machine()]), (load, 0, 0, 32), (jump_set, 0, 1, TMPFILE_BIT),
             (give, 0, 0, 0x00050000 | errno.EOPNOTSUPP), (give, 0, 0, 0x7FFF0000)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *rule) for rule in rules))
    program = ctypes.create_string_buffer(struct.pack("@HP", len(rules), ctypes.addressof(code)))
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    for arguments in ((38, 1, 0, 0, 0), (22, 2, ctypes.addressof(program), 0, 0)):
        if prctl(*(ctypes.c_ulong(argument) for argument in arguments)) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


class InterruptedTest(ProgramTest):
    def start(self):
        """A conversion that has begun to write its file, which has a name from the start."""
        process = subprocess.Popen([PROGRAM, "demo:random?size=128", "--iso", "0", "-o", "out.obj"], cwd=self.folder,
                                   stderr=subprocess.PIPE, preexec_fn=forbid_unnamed_files)
        while process.poll() is None and not any(name.startswith(".isoextract-") for name in self.files()):
            time.sleep(0.002)
        return process

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
