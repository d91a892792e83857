"""How often files are opened: an input once in a conversion and in a batch, an output once and never read again."""

import collections
import gzip
import os
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))

from support import ProgramTest, SOURCE, main  # noqa: E402

BEGINNINGS = 512 * 1024
LIBRARY = os.environ["ISOEXTRACT_COUNT_OPENS"]


class Opens(ProgramTest):
    def count(self, *arguments):
        """Runs the program; of each file in the test's folder how often it was opened, and the bytes that were read."""
        log = self.folder / "opens.log"
        log.unlink(missing_ok=True)
        run = self.convert(*arguments, env=dict(os.environ, LD_PRELOAD=LIBRARY, COUNT_OPENS=str(log)))
        opened, read = collections.Counter(), collections.Counter()
        for line in log.read_text().splitlines():
            number, way, path = line.split(" ", 2)
            if way == "bytes":
                read[path] += int(number)
            elif not path.startswith("/"):
                opened[path] += 1
        self.assertNotEqual(opened, {}, run.err)
        return opened, read

    def write_inputs(self):
        ramp = [x + y + z for z in range(64) for y in range(64) for x in range(64)]
        samples = struct.pack("<262144f", *ramp)
        header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 64 64 64\nendian: little\nencoding: {}\n\n"
        (self.folder / "plain.nrrd").write_bytes(header.format("raw").encode() + samples)
        (self.folder / "packed.nrrd").write_bytes(header.format("gzip").encode() + gzip.compress(samples))
        descr = "{'descr': '<f4', 'fortran_order': False, 'shape': (64, 64, 64), }"
        descr = descr.ljust(117) + "\n"
        (self.folder / "array.npy").write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + descr.encode() + samples)
        (self.folder / "v.raw").write_bytes(samples)
        (self.folder / "v.vdb").write_bytes((SOURCE / "samples/metaballs.vdb").read_bytes())
        rows = "\n".join(f"{x} {y} {z}" for x in range(40) for y in range(40) for z in range(40))
        (self.folder / "p.xyz").write_text("64000\n\n" + "\n".join(f"Ar {row}" for row in rows.split("\n")) + "\n")
        (self.folder / "p.csv").write_text("x,y,z\n" + rows.replace(" ", ",") + "\n")
        return {"plain.nrrd": ("--iso", 40), "packed.nrrd": ("--iso", 40), "array.npy": ("--iso", 40),
                "v.raw": ("--iso", 40, "--dims", "64,64,64", "--dtype", "f32"), "v.vdb": ("--iso", 0.5),
                "p.xyz": ("--radius", 0.6), "p.csv": ("--radius", 0.6, "--particles", "weight")}

    def test_a_conversion_opens_its_input_once(self):
        for name, options in self.write_inputs().items():
            with self.subTest(name):
                opened, read = self.count(name, *options, "-o", "out.ply", "--report", "r.json")
                self.assertEqual(opened[name], 1)
                # A file's beginning is read to tell its format, to list its grids, and with the rest.
                passes = 2 if name == "p.csv" else 1  # rows of a table are counted before they are read
                self.assertLessEqual(read[name], passes * (self.folder / name).stat().st_size + BEGINNINGS)

    def test_a_batch_opens_each_input_once_and_no_output_again(self):
        for name, options in self.write_inputs().items():
            with self.subTest(name):
                stem, extension = name.split(".")
                frames = [f"{stem}_{i}.{extension}" for i in (1, 2, 3)]
                for frame in frames:
                    (self.folder / frame).write_bytes((self.folder / name).read_bytes())
                opened, _ = self.count(*frames, *options, "-o", f"{stem}-{extension}/", "--jobs", 2)
                self.assertEqual({frame: opened[frame] for frame in frames}, dict.fromkeys(frames, 1))
                outputs = [path for path in opened if path.startswith(f"{stem}-{extension}/") and path.endswith(".glb")]
                self.assertEqual(outputs, [])  # they get their names when they are whole


if __name__ == "__main__":
    main()
