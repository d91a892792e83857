"""The examples of README.md and docs: every isoextract command of their `sh` blocks runs, and writes what it names."""

import gzip
import os
import pathlib
import re
import shlex
import struct
import subprocess

from support import PROGRAM, SOURCE, ProgramTest, main
from vdb_files import grid, vdb

PAGES = ("README.md", "docs/formats.md", "docs/particles.md", "docs/reports.md", "docs/accuracy.md", "docs/gpu.md",
         "docs/sequences.md", "docs/simulate.md", "docs/render.md", "docs/previews.md",
         "docs/pieces.md", "docs/meshes.md", "docs/attributes.md", "docs/blender-and-meshlab.md", "docs/check.md", "docs/clusters.md",
         "docs/labels.md", "docs/voxels.md")
# Whole benchmarks take minutes; bench_test.py runs them in small.
PASSED_OVER = ("isoextract bench",)
# What only the plug-ins around OpenVDB do.
WITH_OPENVDB = re.compile(r"--filter|--particles (spheres|smooth)|-o \S+\.vdb|fluid\.vdb")
HAS_OPENVDB = (pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so").exists()


def commands_of(page):
    blocks = re.findall(r"^```sh\n(.*?)^```$", (SOURCE / page).read_text(), re.MULTILINE | re.DOTALL)
    lines = [line.replace("scripts/run ", "isoextract ") for block in blocks for line in block.splitlines()]
    return [line for line in lines if line.startswith(("isoextract ", "python3 ")) and not line.startswith(PASSED_OVER)]


def files_of(page):
    """What `toml` blocks hold, by the name in their first line."""
    return re.findall(r"^```toml\n# (\S+)\n(.*?)^```$", (SOURCE / page).read_text(), re.MULTILINE | re.DOTALL)


def ball(dims, spacing, top, code):
    """Values that fall from `top` in the middle to 0, x fastest."""
    center = [(n - 1) * spacing / 2 for n in dims]
    radius = min(center)

    def value(*place):
        away = sum((spacing * a - c) ** 2 for a, c in zip(place, center)) ** 0.5
        return max(0, round(top * (1 - away / (1.2 * radius))))

    values = [value(x, y, z) for z in range(dims[2]) for y in range(dims[1]) for x in range(dims[0])]
    return struct.pack(f"<{len(values)}{code}", *values)


def nifti(dims, spacing, samples):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *dims, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)  # unsigned char
    struct.pack_into("<8f", header, 76, 1, *(3 * [spacing]), 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2  # millimeters
    struct.pack_into("<h", header, 254, 1)
    for axis in range(3):
        struct.pack_into("<f", header, 280 + 20 * axis, spacing)
    header[344:348] = b"n+1\0"
    return gzip.compress(bytes(header) + samples)


def block(spacing):
    """6^3 places in a lattice, x fastest."""
    return [tuple(spacing * (n // 6**axis % 6) for axis in range(3)) for n in range(6**3)]


class ReadmeTest(ProgramTest):
    def write_particles(self):
        def write_ply(name, radius):
            properties = "".join(f"property float {p}\n" for p in ("x", "y", "z", "vx", "vy", "vz"))
            header = f"ply\nformat binary_little_endian 1.0\nelement vertex 216\n{properties}end_header\n".encode()
            data = b"".join(struct.pack("<6f", *p, *p) for p in block(2 * radius))
            (self.folder / name).write_bytes(header + data)

        for name in ("splash_0030.ply", "flip_0001.ply", "flip_0002.ply"):
            write_ply(name, 0.024)
        write_ply("dam.ply", 0.025)
        rows = "".join("{},{},{},{}\n".format(*p, p[0] / 0.003) for p in block(0.0005))
        (self.folder / "plate_0700.csv").write_text("x,y,z,damage\n" + rows)
        atoms = "".join("{} {} {} {} {}\n".format(n + 1, n % 3 + 1, *p) for n, p in enumerate(block(1)))
        dump = "".join(f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n216\nITEM: BOX BOUNDS ff ff ff\n"
                       f"0 6\n0 6\n0 6\nITEM: ATOMS id type x y z\n{atoms}"
                       for step in (0, 100))
        (self.folder / "run.lammpstrj").write_text(dump)
        images = "".join("{} 1 {} {} {} 0 0 0\n".format(n + 1, *p) for n, p in enumerate(block(1)))
        (self.folder / "melt.lammpstrj").write_text(
            dump.split("ITEM: ATOMS")[0].replace("ff ff ff", "pp pp pp") + f"ITEM: ATOMS id type x y z ix iy iz\n{images}")
        (self.folder / "melt.csv").write_text("x,y,z\n" + "".join("{},{},{}\n".format(*p) for p in block(1)))
        water = "".join("{} {} {} {}\n".format("HHO"[n % 3], *p) for n, p in enumerate(block(1)))
        (self.folder / "water.xyz").write_text(f"216\nwater\n{water}")
        (self.folder / "protein.pdb").write_text("".join(
            f"ATOM  {n + 1:5d}  CA  ALA A{n + 1:4d}    {3.8 * p[0]:8.3f}{3.8 * p[1]:8.3f}{3.8 * p[2]:8.3f}  1.00  0.00           C\n"
            for n, p in enumerate(block(1)[:40])) + "END\n")
        rows = "".join(f"    1SOL  {('OW', 'HW1', 'HW2')[n % 3]:>5}{n + 1:5d}{0.1 * p[0]:8.3f}{0.1 * p[1]:8.3f}{0.1 * p[2]:8.3f}\n"
                       for n, p in enumerate(block(1)))
        (self.folder / "water.gro").write_text(f"water\n  216\n{rows}   0.6   0.6   0.6\n")
        if HAS_OPENVDB:
            self.convert("dam.ply", "--particles", "smooth", "--radius", "0.025", "-o", "fluid.vdb")

    def setUp(self):
        super().setUp()
        (self.folder / "samples").symlink_to(SOURCE / "samples")
        (self.folder / "bin").mkdir()
        (self.folder / "bin" / "isoextract").symlink_to(PROGRAM)
        (self.folder / "smoke.vdb").symlink_to(SOURCE / "samples" / "metaballs.vdb")
        hot = {(n % 8, n // 8 % 8, n // 64): 1.0 for n in range(8**3)}
        (self.folder / "fire.vdb").write_bytes(vdb(grid("density", hot), grid("flame", hot)))
        head = ball((48, 62, 42), 1, 255, "B")
        (self.folder / "head.raw").write_bytes(head)
        for name in ("head.nii.gz", "scan.nii.gz"):
            (self.folder / name).write_bytes(nifti((48, 62, 42), 4, head))
        tooth = (f"NRRD0004\ntype: ushort\ndimension: 3\nsizes: 25 24 40\nspacings: 4 4 4\nencoding: raw\n"
                 f"endian: little\n").encode()
        samples = ball((25, 24, 40), 4, 1300, "H")
        (self.folder / "large.nrrd").write_bytes(tooth + b"\n" + samples)
        (self.folder / "tooth.raw").write_bytes(samples)
        (self.folder / "tooth.nhdr").write_bytes(tooth + b"data file: tooth.raw\n")
        (self.folder / "measure.py").write_text("import sys\nassert sys.stdin.buffer.read(3) == b'ply'\n"
                                                "sys.stdin.buffer.read()\n")
        heights = b"".join(struct.pack("<h", 500 + x * y) for y in range(8) for x in range(9))
        header = "{'descr': '<i2', 'fortran_order': False, 'shape': (8, 9)}".ljust(117) + "\n"
        (self.folder / "elevation.npy").write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header.encode() + heights)
        self.write_particles()

    def test_the_examples_run(self):
        path = f"{self.folder / 'bin'}:{os.environ['PATH']}"
        outputs = 0
        for page in PAGES:
            for name, text in files_of(page):
                (self.folder / name).write_text(text)
            found = commands_of(page)
            self.assertTrue(found, page)
            for line in found:
                if WITH_OPENVDB.search(line) and not HAS_OPENVDB:
                    continue
                if any(not pathlib.Path(name).exists() for name in re.findall(r"/usr/share/\S+", line)):
                    continue  # data of a package that is not installed
                run = subprocess.run(["bash", "-o", "pipefail", "-c", line], cwd=self.folder, capture_output=True, text=True,
                                     env={**os.environ, "PATH": path}, check=False, timeout=120)
                self.assertEqual(run.returncode, 0, f"{page}: {line}\n{run.stderr}")
                words = shlex.split(line.partition(" | ")[0], comments=True)
                for option, name in zip(words, words[1:]):
                    if option == "-o" and "{" in name:  # frames
                        frames = (self.folder / name).parent.glob("*" + pathlib.Path(name).suffix)
                        self.assertTrue(any(frames), f"{page}: {line}")
                    elif option in ("-o", "--report", "--table") and name != "-":
                        self.assertGreater((self.folder / name).stat().st_size, 100, f"{page}: {line}")
                        outputs += 1
        self.assertGreater(outputs, 12)

    def test_the_examples_are_found(self):
        self.assertEqual(len(commands_of("README.md")), 10)


if __name__ == "__main__":
    main()
