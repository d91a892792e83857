"""What the command-line tests share: running the program, and reading what it wrote.

A test limits the processor time, the memory or the calls of a run, never how long it takes: see processor_time_below. A
test whose tool is missing fails and names the package (needs_program). Only tests on real volumes skip (needs_data).
"""

import contextlib
import ctypes
import errno
import functools
import importlib.util
import os
import pathlib
import platform
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

from mesh_readers import glb_json, read_glb, read_obj, read_ply, read_stl  # noqa: E402, F401 - for the tests
from png_reader import Png  # noqa: E402, F401 - likewise

PROGRAM = os.environ["ISOEXTRACT_PROGRAM"]
SOURCE = pathlib.Path(os.environ["ISOEXTRACT_SOURCE_DIR"])
DATA = pathlib.Path(os.environ.get("ISOEXTRACT_DATA", SOURCE / ".." / "shared" / "data"))

SPHERE = "demo:sphere?size=24"
# EGL's loader finds no driver, as on a machine that has none.
NO_GPU = dict(os.environ, __EGL_VENDOR_LIBRARY_FILENAMES="/nowhere/vendor.json")


# Of one run. A busy machine makes a run wait, which takes no processor time; one that waits for HANGING_SECONDS hangs.
PROCESSOR_SECONDS = 240
HANGING_SECONDS = 1200


def run_limited(command, preexec_fn=None, **options):
    """subprocess.run(), whose command ends by SIGXCPU once it has used PROCESSOR_SECONDS."""

    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS + 5))
        if preexec_fn is not None:
            preexec_fn()

    finished = subprocess.run(command, timeout=HANGING_SECONDS, check=False, preexec_fn=limit, **options)
    if finished.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        raise AssertionError(f"more than {PROCESSOR_SECONDS} s of processor time: {command}")
    return finished


@contextlib.contextmanager
def processor_time_below(seconds, told):
    """What runs meanwhile takes no more processor time: how long it waits on a busy machine says nothing of its work."""

    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = used()
    yield
    if used() - before >= seconds:
        raise AssertionError(f"{used() - before:.1f} s of processor time, not less than {seconds}: {told}")


class Run:
    """One finished run of the program."""

    def __init__(self, finished):
        self.code = finished.returncode
        self.out = finished.stdout
        self.err = finished.stderr.decode()

    @property
    def text(self):
        return self.out.decode()


def peak_mib_of(run):
    """The peak memory that a run with -v printed."""
    number, unit = re.search(r"peak memory ([\d.]+) (MiB|GiB)", run.err).groups()
    return float(number) * (1024 if unit == "GiB" else 1)


class ProgramTest(unittest.TestCase):
    """Each test runs in a fresh folder of its own."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-test-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_program(self, *arguments, **options):
        options.setdefault("cwd", self.folder)
        options.setdefault("stdin", subprocess.DEVNULL)
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        command = [PROGRAM, *(str(argument) for argument in arguments)]
        return Run(run_limited(command, **options))

    def convert(self, *arguments, **options):
        """A conversion that must succeed."""
        run = self.run_program(*arguments, **options)
        self.assertEqual(run.code, 0, run.err)
        return run

    def peak_mib(self, *arguments):
        """The peak memory of a conversion that must succeed."""
        return peak_mib_of(self.convert(*arguments, "-v"))

    def told_mib(self, *arguments):
        """The estimate of a dry run."""
        return int(re.search(r"memory: about (\d+) MiB", self.convert(*arguments, "--dry-run").text)[1])

    def assert_fails(self, code, run, *parts):
        """Exit code, the form of the message, and what the message and hint must contain. stdout stays empty."""
        self.assertEqual(run.code, code, run.err)
        self.assertEqual(run.out or b"", b"")
        self.assertRegex(run.err, r"\A(isoextract: note\[[a-z-]+\]: .*\n)*isoextract: error: ")
        for part in parts:
            self.assertIn(part, run.err)

    def files(self):
        """Names in the test's folder, hidden ones too."""
        return sorted(path.name for path in self.folder.iterdir())

    def write_raw(self, name, dims, value_at, code="f"):
        """A raw file of the values value_at(x, y, z); little-endian."""
        values = [value_at(x, y, z) for z in range(dims[2]) for y in range(dims[1]) for x in range(dims[0])]
        path = self.folder / name
        path.write_bytes(struct.pack(f"<{len(values)}{code}", *values))
        return path


# Numbers of system calls by machine.
OPENAT = {"x86_64": 257, "aarch64": 56}
MEMFD_CREATE = {"x86_64": 319, "aarch64": 279}
PRCTL = {"x86_64": 157, "aarch64": 167}
TMPFILE_BIT = os.O_TMPFILE & ~os.O_DIRECTORY
LOAD, JUMP_EQUAL, JUMP_SET, GIVE = 0x20, 0x15, 0x45, 0x06
ERROR, ALLOW = 0x00050000, 0x7FFF0000


def forbid_unnamed_files():
    """From now on this process finds no file system with unnamed files (O_TMPFILE): a filter of its system calls."""
    filter_system_calls([(LOAD, 0, 0, 0), (JUMP_EQUAL, 0, 3, OPENAT[platform.machine()]), (LOAD, 0, 0, 32),
                         (JUMP_SET, 0, 1, TMPFILE_BIT), (GIVE, 0, 0, ERROR | errno.EOPNOTSUPP), (GIVE, 0, 0, ALLOW)])


def forbid_shared_memory():
    """From now on this process and its children find no memfd_create."""
    filter_system_calls([(LOAD, 0, 0, 0), (JUMP_EQUAL, 0, 1, MEMFD_CREATE[platform.machine()]),
                         (GIVE, 0, 0, ERROR | errno.ENOSYS), (GIVE, 0, 0, ALLOW)])


def forbid_filters():
    """From now on this process and its children find a kernel without seccomp."""
    set_seccomp = 22
    filter_system_calls([(LOAD, 0, 0, 0), (JUMP_EQUAL, 0, 3, PRCTL[platform.machine()]), (LOAD, 0, 0, 16),
                         (JUMP_EQUAL, 0, 1, set_seccomp), (GIVE, 0, 0, ERROR | errno.EINVAL), (GIVE, 0, 0, ALLOW)])


def filter_system_calls(rules):
    code = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *rule) for rule in rules))
    program = ctypes.create_string_buffer(struct.pack("@HP", len(rules), ctypes.addressof(code)))
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    for arguments in ((38, 1, 0, 0, 0), (22, 2, ctypes.addressof(program), 0, 0)):
        if prctl(*(ctypes.c_ulong(argument) for argument in arguments)) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


INSTALL = "scripts/setup.sh test installs it"
# It has Debian's modules, which another Python that runs the tests may lack.
SYSTEM_PYTHON = "/usr/bin/python3"


def needs_modules(*names):
    """Runs this file with the system's Python if this one lacks a module. Call before importing the modules."""
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing and os.path.realpath(sys.executable) != os.path.realpath(SYSTEM_PYTHON):
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])
    if missing:
        sys.exit(f"{sys.executable} has no module {', '.join(missing)}: {INSTALL}")


def needs_program(name):
    """Without the program the test fails: a skipped test checks nothing, and remains unnoticed."""

    def wrap(test):
        @functools.wraps(test)
        def run(self):
            self.assertIsNotNone(shutil.which(name), f"no {name}: {INSTALL}")
            test(self)

        return run

    return wrap


def needs_data(name):
    return unittest.skipUnless((DATA / name).exists(), f"no {DATA / name}: set ISOEXTRACT_DATA to the data folder")


def main():
    program = unittest.main(argv=[sys.argv[0], *sys.argv[1:]], verbosity=1, exit=False)
    # scripts/test shows these lines: for CTest a file of which a part was skipped has passed.
    for test, reason in program.result.skipped:
        print(f"skipped: {test.id().removeprefix('__main__.')}: {reason}", file=sys.stderr)
    sys.exit(not program.result.wasSuccessful())
