"""SEG-Y files, read by the plug-in around segyio: lines, traces, coordinates, sample formats."""

import pathlib
import sys

from support import DATA, SOURCE, main, needs_data

sys.path.insert(0, str(SOURCE / "tests" / "support"))

from written_volumes import WrittenVolumes, needs_reader  # noqa: E402

F3 = DATA / "segy" / "f3.sgy"

# segyio drops the last bytes of a file unless a trace has a multiple of 4.
# A survey with inlines 10, 12, ..., crosslines 100, 101, ... and rotated coordinates; arguments: name, format, and words.
WRITE = """import sys, segyio, numpy as np
name, kind, words = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
a = np.rint(np.random.default_rng(kind).normal(size=(4, 5, 12)) * 40)
spec = segyio.spec()
spec.format = kind; spec.samples = np.arange(12) * 2.0
places = [(i, j) for i in range(4) for j in range(5)]
if 'crosslines' in words: places.sort(key=lambda p: (p[1], p[0]))
if 'shuffled' in words: np.random.default_rng(0).shuffle(places)
if 'holes' in words: places = [p for p in places if p not in ((0, 0), (2, 3))]
if 'twice' in words: places = [p for p in places for _ in range(2)]
spec.tracecount = len(places)
dtype = {1: 'f4', 2: 'i4', 3: 'i2', 5: 'f4', 8: 'i1'}[kind]
with segyio.create(name, spec) as f:
    f.bin.update(hdt=2000, hns=12, format=kind, rev=1, mfeet=2)
    for n, (i, j) in enumerate(places):
        f.header[n] = {189: 0 if 'unnumbered' in words else 10 + 2 * i, 193: 100 + j, 37: n % 2 * 50 if 'offsets' in words else 0,
                       71: -100, 109: 8, 115: 12, 117: 2000}
        if 'coordinates' in words:
            f.header[n].update({181: int(100 * (5000 + 30 * i - 4 * j)), 185: int(100 * (7000 + 3 * i + 40 * j))})
        f.trace[n] = a[i, j].astype(dtype)
if 'little' in words:  # segyio itself swaps pairs of 16-bit samples
    data = bytearray(open(name, 'rb').read())
    def swap(at, size): data[at:at + size] = data[at:at + size][::-1]
    for at in (3216, 3220, 3224, 3254, 3500): swap(at, 2)
    size = np.dtype(dtype).itemsize
    for trace in range(3600, len(data), 240 + 12 * size):
        for at in (36, 180, 184, 188, 192): swap(trace + at, 4)
        for at in (70, 108, 114, 116): swap(trace + at, 2)
        for at in range(12): swap(trace + 240 + at * size, size)
    open(name, 'wb').write(data)
if 'holes' in words: a[0, 0] = a[2, 3] = np.nan
np.save('expected.npy', a.transpose(1, 0, 2) if 'crosslines' in words else a)
"""


@needs_reader("segy", "numpy, segyio")
class SegyTest(WrittenVolumes):
    def write(self, kind, *words):
        self.python(WRITE, "a.sgy", kind, *words)

    def test_sample_formats(self):
        for kind, words in ((1, ()), (2, ()), (3, ()), (5, ()), (8, ()), (3, ("little",)), (5, ("little",)), (8, ("little",)), (1, ("little", "holes")), (5, ("crosslines",)),
                            (2, ("holes",)), (3, ("holes",)), (8, ("holes", "crosslines")), (1, ("holes",))):
            self.write(kind, *words)
            self.convert("a.sgy", "-o", "read.npy")
            self.assert_same_samples([("read.npy", "expected.npy")])

    def test_order_of_the_traces_does_not_matter(self):
        self.write(5, "shuffled")
        self.convert("a.sgy", "-o", "read.npy")
        # Neither line number varies slower.
        done = self.python("import numpy as n; a, b = n.load('read.npy'), n.load('expected.npy'); "
                           "print(n.array_equal(a, b) or n.array_equal(a, b.transpose(1, 0, 2)))")
        self.assertEqual(done.strip(), "True")

    def test_coordinates_place_the_samples(self):
        self.write(5, "coordinates")
        report, run = self.report("a.sgy", "--iso", 0, "-o", "a.ply")
        for row, expected in zip(report["input"]["index_to_world"], ([0, -4, 30, 5000], [0, 40, 3, 7000], [-2, 0, 0, -8]), strict=False):
            for found, wanted in zip(row, expected, strict=True):
                self.assertAlmostEqual(found, wanted, places=6)
        self.assertIn("grid axes are samples, crosslines, inlines", run.err)
        self.assertIn("fitted within 0; inlines are 30.14963, crosslines 40.1995 apart", run.err.replace("e-", "E"))
        self.assertIn("x and y are in feet", run.err)

    def test_without_coordinates_line_numbers_place_them(self):
        self.write(5)
        report, run = self.report("a.sgy", "--iso", 0, "-o", "a.ply")
        self.assertEqual(report["input"]["index_to_world"][:3], [[0, 0, 2, 10], [0, 1, 0, 100], [-2, 0, 0, -8]])
        self.assertIn("x is the inline number, y the crossline number", run.err)

    def test_missing_traces_have_no_data(self):
        self.write(3, "holes", "coordinates")
        run = self.convert("a.sgy", "--nan", "hole", "--iso", 0, "-o", "a.ply")
        self.assertIn("2 of 20 traces are missing and have no data", run.err)
        self.assert_fails(2, self.run_program("a.sgy", "--iso", 0, "-o", "b.ply"), "NaN")

    def test_only_the_traces_of_a_region_are_read(self):
        self.write(5)
        report, _ = self.report("a.sgy", "--iso", 0, "--roi", "9,99,-99,99,100.5,99", "-o", "a.ply")
        # Crosslines 100 to 103 of 100 to 104: two samples more than the box, for gradients.
        self.assertEqual(self.parts_left_out(report), (4, 20))

    def test_files_that_are_no_lattice_are_refused(self):
        for words, message in ((("twice",), "expected one trace per place, found several at inline 10, crossline 100"),
                               (("twice", "offsets"), "of offsets 0 and 50: the file has traces before stacking"),
                               (("unnumbered",), "several inlines (bytes 189-192) in its trace headers, found only number 0")):
            self.write(5, *words)
            self.assert_fails(2, self.run_program("a.sgy", "--iso", 0, "-o", "a.ply"), message)

    @needs_data("segy/f3.sgy")
    def test_f3_has_the_surface_that_vtk_finds(self):
        self.python("import segyio, sys, numpy; numpy.save('cube.npy', segyio.tools.cube(segyio.open(sys.argv[1])))", F3)
        # VTK 9.1 FlyingEdges3D on segyio's cube [inline, crossline, sample]. The samples are so rough that the area depends on how
        # ambiguous cells are resolved: 469.5 and 734.0 there, 489.0 and 736.5 here.
        for iso, bounds in ((5000, (19.9678, 0, 0, 73.0518, 17, 22)), (-5000, (12.3976, 0, 0, 58.4639, 17, 22))):
            self.convert("cube.npy", f"--iso={iso}", "--space", "index", "-o", "cube.ply")
            report, _ = self.report(F3, f"--iso={iso}", "--space", "index", "-o", "f3.ply")
            cube, mesh = ((self.folder / name).read_bytes().split(b"end_header\n", 1)[1] for name in ("cube.ply", "f3.ply"))
            self.assertEqual(cube, mesh)
            found = report["meshes"][0]["bounds"]
            for found, wanted in zip((*found["min"], *found["max"]), bounds, strict=True):
                self.assertAlmostEqual(found, wanted, delta=0.02)
        # The first trace: inline 111, crossline 875, coordinates in tenths of a meter, delay 4 ms; lines 25 m apart.
        offset = [row[3] for row in report["input"]["index_to_world"][:3]]
        for found, wanted in zip(offset, (620197.2, 6074232.9, -4), strict=True):
            self.assertAlmostEqual(found, wanted, delta=0.07)

    def test_damaged_files_are_refused(self):
        self.write(3, "coordinates")
        size = pathlib.Path(self.folder / "a.sgy").stat().st_size
        trace = 240 + 2 * 12
        self.assert_refuses_damage("a.sgy", [3213, 3216, 3220, 3221, 3224, 3225, 3504, 3600 + 114, 3600 + 188, 3600 + 193],
                                   [0, 1, 3200, 3599, 3600, 3601, 3600 + trace + 1, size - trace + 240, size - 1])


if __name__ == "__main__":
    main()
