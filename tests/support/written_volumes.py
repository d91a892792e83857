"""Volumes that other programs write, with the modules of the system's Python, and NumPy arrays to compare with."""

import functools
import json
import os
import pathlib
import subprocess
import unittest

from support import PROGRAM, ProgramTest

# The system's Python has Debian's modules, which another one that runs the tests may lack.
SYSTEM_PYTHON = "/usr/bin/python3"
PLUGINS = pathlib.Path(PROGRAM).parent / "plugins"


@functools.cache
def lacking_modules(names):
    """Why the modules cannot be used; "" if they can."""
    if not pathlib.Path(SYSTEM_PYTHON).exists():
        return f"no {SYSTEM_PYTHON}"
    done = subprocess.run([SYSTEM_PYTHON, "-c", f"import {names}"], capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else f"{SYSTEM_PYTHON} has not all of {names}"


def needs_reader(plugin, modules="numpy"):
    """Skips tests without the plug-in, or without the modules that write its files."""
    if not (PLUGINS / f"isoextract-volume-{plugin}.so").exists():
        return unittest.skip(f"the plug-in {plugin} was not built (scripts/setup.sh {plugin})")
    why = lacking_modules(modules)
    return unittest.skipIf(why, why)


class WrittenVolumes(ProgramTest):
    def python(self, script, *arguments):
        """What a script of the system's Python prints, run in the test's folder."""
        done = subprocess.run([SYSTEM_PYTHON, "-c", script, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def report(self, *arguments):
        run = self.convert(*arguments, "--report", "report.json")
        return json.loads((self.folder / "report.json").read_text()), run

    def assert_same_samples(self, pairs):
        """Pairs of NPY files with equal values and sizes; NaN equals NaN."""
        found = self.python("""import numpy, sys
for a, b in zip(sys.argv[1::2], sys.argv[2::2]):
    p, q = numpy.load(a), numpy.load(b)
    if p.shape != q.shape or not numpy.array_equal(p.astype(float), q.astype(float), equal_nan=True):
        print(a, p.dtype, p.shape, b, q.dtype, q.shape)
""", *(name for pair in pairs for name in pair))
        self.assertEqual(found, "")

    def parts_left_out(self, report):
        """Chunks, slices or traces that were not read, of how many."""
        return next((entry["count"], entry["total"]) for entry in report["work"] if entry["what"] == "file_parts")

    def surface(self, *arguments):
        """Area, bounds and report of the surface in index space."""
        report, _ = self.report(*arguments, "--space", "index", "-o", "surface.ply")
        checked = json.loads(self.convert("check", "surface.ply", "--json").text)
        return checked["mesh"], report

    def assert_refuses_damage(self, path, positions, lengths):
        """A file with flipped bytes, or cut: read, or refused with exit code 2. Cut ones are always refused."""
        environment = dict(os.environ, ISOEXTRACT_PLUGIN_SECONDS="3")  # libraries hang on some damaged files
        whole = bytearray((self.folder / path).read_bytes())
        damaged = self.folder / f"damaged{pathlib.Path(path).suffix}"
        for length in lengths:
            damaged.write_bytes(whole[:length])
            run = self.run_program(damaged, "-o", "damaged.npy", env=environment)
            self.assertEqual(run.code, 2, f"{length} of {len(whole)} bytes: {run.err}")
        for position in positions:
            for value in {0xFF, whole[position] ^ 0x80} - {whole[position]}:
                damaged.write_bytes(whole[:position] + bytes([value]) + whole[position + 1:])
                run = self.run_program(damaged, "-o", "damaged.npy", env=environment)
                self.assertIn(run.code, (0, 2), f"byte {position} = {value}: {run.err}")
        self.assertFalse(any(name.startswith(".") for name in self.files()), self.files())
