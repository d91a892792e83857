"""Inputs that are compressed as a whole, and archives of the files of one input."""

import bz2
import gzip
import io
import json
import lzma
import math
import os
import pathlib
import shutil
import struct
import subprocess
import tarfile
import zipfile

from support import ProgramTest, main, needs_program

TEST_PLUGINS = pathlib.Path(os.environ["ISOEXTRACT_TEST_PLUGINS"])
DIMS = (12, 11, 10)


def zstd(data, *options):
    return subprocess.run(["zstd", "-q", "-c", *options], input=data, stdout=subprocess.PIPE, check=True).stdout


def xz(data, window):
    """With a window of any size, which the decoder takes whatever the size of the data."""
    return lzma.compress(data, filters=[{"id": lzma.FILTER_LZMA2, "preset": 0, "dict_size": window}])


PACKERS = {".xz": lzma.compress, ".zst": zstd, ".bz2": bz2.compress, ".gz": gzip.compress}


def samples():
    index = [(i, j, k) for k in range(DIMS[2]) for j in range(DIMS[1]) for i in range(DIMS[0])]
    return struct.pack(f"<{len(index)}f", *(3.7 - math.dist(at, (5.2, 5, 4.6)) for at in index))


def npy():
    head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {DIMS[::-1]}, }}".encode()
    head += b" " * (-(len(head) + 11) % 64) + b"\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head + samples()


def nrrd(data_file=None):
    lines = ["NRRD0004", "type: float", "dimension: 3", "sizes: {} {} {}".format(*DIMS), "spacings: 1 0.5 2",
             "encoding: raw", "endian: little"]
    if data_file:
        return "\n".join([*lines, f"data file: {data_file}", ""]).encode()
    return "\n".join([*lines, "", ""]).encode() + samples()


def nifti():
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, *DIMS, 1, 1, 1, 1)
    struct.pack_into("<hh", head, 70, 16, 32)
    struct.pack_into("<8f", head, 76, 1, 1, 1, 1, 0, 0, 0, 0)
    struct.pack_into("<ff", head, 108, 352, 1)
    struct.pack_into("<h", head, 254, 1)  # sform
    for row in range(3):
        struct.pack_into("<4f", head, 280 + 16 * row, *(float(row == column) for column in range(4)))
    head[344:348] = b"n+1\0"
    return bytes(head) + samples()


class CompressedTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        self.environment = dict(os.environ, TMPDIR=str(self.temporary))

    def write(self, name, data):
        (self.folder / name).write_bytes(data)

    def mesh(self, *arguments, **options):
        run = self.run_program(*arguments, "--iso", "0", "-o", "out.ply", env=self.environment, **options)
        self.assertEqual(run.code, 0, run.err)
        self.err = run.err
        self.assertEqual(list(self.temporary.iterdir()), [], "the temporary folder is removed")
        return (self.folder / "out.ply").read_bytes()

    def refused(self, code, *arguments, said=""):
        run = self.run_program(*arguments, "--iso", "0", "-o", "no.ply", env=self.environment)
        self.assert_fails(code, run, said)
        self.assertFalse((self.folder / "no.ply").exists())
        self.assertEqual(list(self.temporary.iterdir()), [])
        return run


class OneFileTest(CompressedTest):
    def test_every_format_in_every_compression(self):
        for name, data in (("a.npy", npy()), ("a.nrrd", nrrd()), ("a.nii", nifti()), ("a.raw", samples())):
            layout = ("--dims", "12,11,10", "--dtype", "f32") if name == "a.raw" else ()
            self.write(name, data)
            plain = self.mesh(name, *layout)
            for ending, pack in PACKERS.items():
                self.write(name + ending, pack(data))
                self.assertEqual(self.mesh(name + ending, *layout), plain, name + ending)
                # By content: the name tells nothing of the compression.
                if not layout and ending != ".gz":
                    shutil.copy(self.folder / (name + ending), self.folder / "other")
                    self.assertEqual(self.mesh("other"), plain)

    def test_names_and_report(self):
        self.write("a.nrrd.xz", lzma.compress(nrrd()))
        self.mesh("a.nrrd.xz", "--report", "r.json")
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual((report["input"]["path"], report["input"]["name"]), ("a.nrrd.xz", "a"))
        (told,) = json.loads(self.convert("info", "a.nrrd.xz", "--json").text)
        self.assertEqual((told["input"], told["field"]["format"], told["field"]["spacing"]), ("a.nrrd.xz", "NRRD", [1, 0.5, 2]))
        # Without -o, the mesh is named like the file in it.
        self.convert("a.nrrd.xz", "--iso", "0")
        self.assertIn("a.glb", self.files())

    def test_from_standard_input(self):
        self.write("a.nrrd", nrrd())
        plain = self.mesh("a.nrrd")
        for pack in PACKERS.values():
            self.write("packed", pack(nrrd()))
            with open(self.folder / "packed", "rb") as file:
                self.assertEqual(self.mesh("-", stdin=file), plain)
            with subprocess.Popen(["cat", str(self.folder / "packed")], stdout=subprocess.PIPE) as cat:
                self.assertEqual(self.mesh("-", stdin=cat.stdout), plain)

    def test_a_header_finds_its_data(self):
        self.write("a.nrrd", nrrd())
        plain = self.mesh("a.nrrd")
        self.write("d.raw", samples())
        self.write("d.nhdr.zst", zstd(nrrd("d.raw")))
        self.assertEqual(self.mesh("d.nhdr.zst"), plain)

    def test_particles(self):
        table = "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x in range(4) for y in range(4) for z in range(4))
        self.write("p.csv", table.encode())
        plain = self.mesh("p.csv", "--radius", "0.7")
        for ending in (".xz", ".zst", ".bz2"):
            self.write("p.csv" + ending, PACKERS[ending](table.encode()))
            self.assertEqual(self.mesh("p.csv" + ending, "--radius", "0.7"), plain)

    def test_a_sequence(self):
        for n in range(3):
            self.write(f"f_{n}.npy.xz", lzma.compress(npy()))
        self.convert("f_{}.npy.xz", "--iso", "0", "-o", "o_{}.ply", env=self.environment)
        self.assertEqual([n for n in self.files() if n.startswith("o_")], ["o_0.ply", "o_1.ply", "o_2.ply"])
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_plugin_formats(self):
        side = range(7)
        text = "textvolume\nball 7 7 7\n" + " ".join(str(math.dist((x, y, z), (3, 3, 3)) - 2) for z in side for y in side for x in side)
        self.write("a.tvol", text.encode())
        ours = pathlib.Path(os.environ["ISOEXTRACT_PROGRAM"]).parent / "plugins"
        self.environment["ISOEXTRACT_PLUGINS"] = f"{TEST_PLUGINS}:{ours}"
        plain = self.mesh("a.tvol")
        for ending, pack in PACKERS.items():
            self.write("b.tvol" + ending, pack(text.encode()))
            if ending != ".gz":
                self.assertEqual(self.mesh("b.tvol" + ending), plain)
            self.assertEqual(self.mesh("b.tvol" + ending, "--input-format", "text"), plain)
            with open(self.folder / ("b.tvol" + ending), "rb") as file:
                self.assertEqual(self.mesh("-", "--input-format", "text", stdin=file), plain)
        with subprocess.Popen(["cat", str(self.folder / "a.tvol")], stdout=subprocess.PIPE) as cat:
            self.assertEqual(self.mesh("-", "--input-format", "text", stdin=cat.stdout), plain)

    def test_damaged_files(self):
        for ending, pack in PACKERS.items():
            good = pack(npy())
            for length in sorted({*range(0, 40, 9), *range(40, len(good) - 1, max(1, len(good) // 7)), len(good) - 1}):
                self.write("cut.npy" + ending, good[:length])
                run = self.run_program("cut.npy" + ending, "--iso", "0", "-o", "no.ply", env=self.environment)
                self.assertEqual(run.code, 2, (ending, length, run.err))
                self.assertNotIn("crashed", run.err)
            for at in range(len(good) // 3, len(good), len(good) // 3):
                self.write("flip.npy" + ending, good[:at] + bytes([good[at] ^ 0x55]) + good[at + 1:])
                run = self.run_program("flip.npy" + ending, "--iso", "0", "-o", "no.ply", env=self.environment)
                self.assertIn(run.code, (0, 2) if ending == ".zst" else (2,), (ending, at, run.err))
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_the_memory_limit_holds_for_the_content(self):
        packer = lzma.LZMACompressor()
        part = bytes(1 << 20)
        data = b"".join(packer.compress(part) for _ in range(300)) + packer.flush()
        self.write("zeros.raw.xz", data)
        self.refused(2, "zeros.raw.xz", "--dims", "1024,1024,300", "--memory-limit", "100M", said="memory")

    def test_the_memory_limit_holds_for_the_window_of_the_decoder(self):
        data = bytearray(40 << 20)
        data[len(data) // 2 + 500 * 1024 + 500] = 255
        layout = ("--dims", "1024,1024,40", "--dtype", "u8", "--iso", "100", "-o", "out.ply", "--memory-limit", "82M")
        for megabytes, code in ((1, 0), (64, 2)):
            self.write("a.raw.xz", xz(bytes(data), megabytes << 20))
            run = self.run_program("a.raw.xz", *layout, env=self.environment)
            self.assertEqual(run.code, code, run.err)
        self.assertIn("the limit is 82 MiB", run.err)

    @needs_program("zstd")
    def test_a_small_file_with_a_large_window(self):
        self.write("a.npy", npy())
        plain = self.mesh("a.npy")
        # The decoder fills little of this window.
        self.write("a.npy.xz", xz(npy(), 64 << 20))
        self.assertEqual(self.mesh("a.npy.xz", "--memory-limit", "24M"), plain)
        # The process that unpacks cannot get this window, and the memory limit is the reason.
        self.write("a.npy.zst", zstd(npy(), "-1", "--long=27"))
        run = self.refused(2, "a.npy.zst", "--memory-limit", "64M", said="the limit is 64 MiB")
        self.assertNotIn("damaged", run.err)
        self.assertEqual(self.mesh("a.npy.zst", "--memory-limit", "256M"), plain)
        # The library accepts at most 128 MiB.
        self.write("a.npy.zst", zstd(npy(), "-1", "--long=31"))
        run = self.refused(2, "a.npy.zst", said="expected a window that the library accepts, found one of 2048 MiB")
        self.assertNotIn("damaged", run.err)


class ArchiveTest(CompressedTest):
    def archive(self, name, members):
        if name.endswith(".zip"):
            with zipfile.ZipFile(self.folder / name, "w", zipfile.ZIP_DEFLATED) as opened:
                for member, data in members.items():
                    opened.writestr(member, data)
            return
        with tarfile.open(self.folder / name, "w:" + {"tar": "", "tgz": "gz", "gz": "gz", "xz": "xz"}[name.split(".")[-1]]) as opened:
            for member, data in members.items():
                entry = tarfile.TarInfo(member)
                entry.size = len(data)
                opened.addfile(entry, io.BytesIO(data))

    def test_one_volume(self):
        self.write("a.nrrd", nrrd())
        plain = self.mesh("a.nrrd")
        for name in ("a.zip", "a.tar", "a.tgz", "a.tar.xz", "a.tar.gz"):
            self.archive(name, {"folder/a.nrrd": nrrd(), "folder/.hidden": b"x", "__MACOSX/._a.nrrd": b"x", "folder/empty": b""})
            self.assertEqual(self.mesh(name), plain, name)
            if name != "a.zip":  # a zip file goes by its name as well
                shutil.copy(self.folder / name, self.folder / "unnamed")
                self.assertEqual(self.mesh("unnamed"), plain, name)
            self.archive(name, {"deep/er/d.nhdr": nrrd("d.raw"), "deep/er/d.raw": samples()})
            self.assertEqual(self.mesh(name), plain, name)

    def test_what_is_refused(self):
        self.archive("out.zip", {"../a.nrrd": nrrd()})
        self.refused(2, "out.zip", said="expected relative file names inside the archive's folder, found '../a.nrrd'")
        self.archive("two.zip", {"a.nrrd": nrrd(), "b.nrrd": nrrd()})
        self.refused(2, "two.zip", said="two.zip: expected the files of one input in the archive, such as the slices of a volume, "
                                        "found 2 inputs: a.nrrd, b.nrrd\n  hint: unpack the archive with 'unzip two.zip', then")
        self.archive("five.tar", {f"in/d{k}/a.nrrd": nrrd() for k in (1, 2, 3, 10, 20)})
        self.refused(2, "five.tar", said="found 5 inputs: d1/a.nrrd, d2/a.nrrd, d3/a.nrrd and 2 more\n  hint: unpack the archive "
                                         "with 'tar -xf five.tar', then")
        self.archive("none.zip", {"a.txt": b"x", "b.txt": b"y"})
        self.refused(2, "none.zip", said="found none among 2 files: a.txt, b.txt\n")
        self.archive("tables.zip", {"a.csv": b"x,y,z\n1,2,3\n", "b.csv": b"x,y,z\n1,2,3\n"})
        run = self.run_program("tables.zip", "--particles", "sph", "-o", "no.ply", env=self.environment)
        self.assert_fails(2, run, "found 2 inputs: a.csv, b.csv")
        run = self.run_program("two.zip", "--masks", "-o", "no.glb", env=self.environment)
        self.assert_fails(2, run, "two.zip: expected the files of one input in the archive", "unpack the archive")
        self.archive("none.tar", {"empty": b""})
        self.refused(2, "none.tar", said="none.tar")
        self.archive("text.zip", {"read.me": b"hello there"})
        self.refused(2, "text.zip", said="text.zip")

    def test_a_zip_with_a_wrong_checksum(self):
        with zipfile.ZipFile(self.folder / "a.zip", "w", zipfile.ZIP_STORED) as opened:
            opened.writestr("a.npy", npy())
        packed = bytearray((self.folder / "a.zip").read_bytes())
        packed[len(packed) // 2] ^= 0x55
        self.write("a.zip", packed)
        self.refused(2, "a.zip", said="a.zip: expected whole content, found damaged data: ZIP bad CRC")

    def test_damaged_archives(self):
        for name in ("a.zip", "a.tar", "a.tar.xz"):
            self.archive(name, {"a.npy": npy()})
            good = (self.folder / name).read_bytes()
            # The end of a tar archive is nothing but zeros, and readers stop where they begin.
            for length in range(300, len(good) - 11000 if name == "a.tar" else len(good) * 8 // 10, len(good) // 6):
                self.write(name, good[:length])
                run = self.run_program(name, "--iso", "0", "-o", "no.ply", env=self.environment)
                self.assertEqual(run.code, 2, (name, length, run.err))


if __name__ == "__main__":
    main()
