"""Volumes that the memory limit does not hold and that cannot be mapped: a temporary file holds their samples."""

import hashlib
import json
import os
import pathlib
import subprocess
import unittest

from support import PROGRAM, SYSTEM_PYTHON, ProgramTest, main, needs_modules

needs_modules("h5py", "numpy")  # for the processes below: this one stays small, as its peak counts for the program

PLUGINS = pathlib.Path(PROGRAM).parent / "plugins"
MIB = 1 << 20
SIZE = 320  # 125 MiB of floats
LIMIT = 40 * MIB
PEAK = 88 * MIB  # with the program itself; less than the samples
LAYOUT = ("--dims", f"{SIZE},{SIZE},{SIZE}", "--dtype")
GYROID = f"""
import gzip, h5py, numpy as np
t = np.linspace(0, 9, {SIZE}, dtype='f4')
s, c = np.sin(t), np.cos(t)
def at(*axes): return np.einsum('k,j,i->kji', *axes)
one = np.ones_like(t)
a = at(one, c, s) + at(c, s, one) + at(s, one, c) + at(one, one, t / 50)
a = a.astype('<f4')
def nrrd(name, encoding, endian, data, type='float'):
    with open(name, 'wb') as f:
        f.write(f'NRRD0004\\ntype: {{type}}\\ndimension: 3\\nsizes: {SIZE} {SIZE} {SIZE}\\n'
                f'endian: {{endian}}\\nencoding: {{encoding}}\\n\\n'.encode() + data)
"""


class ScratchTest(ProgramTest):
    def write(self, script):
        subprocess.run([SYSTEM_PYTHON, "-B", "-c", GYROID + script], cwd=self.folder, check=True)

    def mesh(self, *arguments, limited=True):
        """A hash of the mesh, without the names in its header; sets self.report."""
        options = ["--memory-limit", f"{LIMIT}B"] if limited else []
        run = self.convert(*arguments, *options, "--normals", "none", "-o", "out.ply", "--report", "report.json")
        self.report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual("samples-in-file" in [note["id"] for note in self.report["notes"]], limited)
        if limited:
            self.assertLess(self.report["peak_memory_bytes"], PEAK)
        hashed = hashlib.sha256()
        with (self.folder / "out.ply").open("rb") as file:
            self.assertTrue(any(line == b"end_header\n" for line in iter(file.readline, b"")))
            for part in iter(lambda: file.read(MIB), b""):
                hashed.update(part)
        return hashed.hexdigest()

    def mapped(self, *arguments, dtype="f32", iso="0.11"):
        return self.mesh("a.raw", *LAYOUT, dtype, "--iso", iso, *arguments, limited=False)

    def test_packed_samples(self):
        self.write("a.tofile('a.raw'); nrrd('a.nrrd', 'gzip', 'little', gzip.compress(a.tobytes(), 1))")
        self.assertEqual(self.mesh("a.nrrd", "--iso", "0.11"), self.mapped())
        # Without a limit, memory holds the samples.
        self.assertEqual(self.mesh("a.nrrd", "--iso", "0.11", limited=False), self.mapped())

    def test_samples_of_the_other_byte_order(self):
        self.write("a.tofile('a.raw'); nrrd('a.nrrd', 'raw', 'big', a.astype('>f4').tobytes())")
        self.assertEqual(self.mesh("a.nrrd", "--iso", "0.11"), self.mapped())
        # Passes over all samples release their memory, too.
        self.mesh("a.nrrd", "--iso", "p60")

    def test_samples_whose_last_axis_is_the_fastest(self):
        self.write("a.tofile('a.raw'); np.save('a.npy', a.transpose(2, 1, 0).copy())")
        self.assertEqual(self.mesh("a.npy", "--axis-order", "xyz", "--iso", "0.11"), self.mapped())

    def test_wide_integers(self):
        """64-bit integers become doubles."""
        self.write("b = (a * 1000).astype('<i8'); b.astype('<f8').tofile('a.raw')\n"
                   "nrrd('b.nrrd', 'raw', 'little', b.tobytes(), 'int64')")
        self.assertEqual(self.mesh("b.nrrd", "--iso", "110.5"), self.mapped(dtype="f64", iso="110.5"))

    def test_lengths_of_vectors(self):
        self.write("b = np.zeros(a.shape + (3,), dtype='u1'); b[..., 1] = np.abs(a) * 50\n"
                   "b.tofile('b.raw'); b[..., 1].astype('<f4').tofile('a.raw')")
        lengths = self.mesh("b.raw", *LAYOUT, "u8", "--components", "3", "--component", "length", "--iso", "70.5")
        self.assertEqual(lengths, self.mapped(iso="70.5"))

    @unittest.skipUnless((PLUGINS / "isoextract-volume-hdf5.so").exists(), "the plug-in for HDF5 was not built")
    def test_samples_from_a_plug_in(self):
        """Runs of layers end within chunks. With and without a process of its own; all samples and those of a region."""
        self.write("a.tofile('a.raw')\nwith h5py.File('a.h5', 'w') as f: f.create_dataset('v', data=a, chunks=(24, 64, 40))")
        expected = self.mapped()
        self.assertEqual(self.mesh("a.h5", "--iso", "0.11"), expected)
        self.assertEqual(self.mesh("a.h5", "--iso", "0.11", "--in-process"), expected)
        region = ("--roi", "3,2,5,317,316,310", "--roi-snap", "--space", "index")
        self.assertEqual(self.mesh("a.h5", "--iso", "0.11", *region), self.mapped(*region))

    def test_no_place_for_the_file(self):
        """The refusal has the memory, the folder and the remedies."""
        self.write("nrrd('a.nrrd', 'raw', 'big', a.astype('>f4').tobytes())")
        for folder, reason in (("/dev/shm", "it is in memory"), (self.folder / "none", "No such file or directory")):
            run = self.run_program("a.nrrd", "--iso", "0.11", "-o", "a.ply", "--memory-limit", f"{LIMIT}B",
                                   env={**os.environ, "TMPDIR": str(folder)})
            self.assert_fails(2, run, "a.nrrd: 320x320x320 f32 samples would take 125 MiB, the limit is 40 MiB",
                              "a temporary file of 125 MiB", reason, "set the environment variable TMPDIR", "--memory-limit")
        self.assertEqual(self.files(), ["a.nrrd"])


if __name__ == "__main__":
    main()
