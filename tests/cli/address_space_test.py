"""Volumes larger than the address space (ulimit -v): the program maps some layers at a time, and writes the same bytes."""

import functools
import json
import math
import resource
import struct

from support import ProgramTest, main

MIB = 1 << 20
LIMIT = 256 * MIB
DIMS = (352, 320, 640)  # 275 MiB of 32-bit floats
RAW = ("waves.raw", "--dims", ",".join(map(str, DIMS)), "--dtype", "f32")
ISO = ("--iso", "0.1")
NOTE = "isoextract: note[samples-in-windows]: the address space of the process is limited to 256 MiB, so "


class AddressSpaceTest(ProgramTest):
    def setUp(self):
        super().setUp()
        # Waves in the first and last layers and in some between; all other samples are 0, which take no disk.
        rows = [struct.pack(f"<{DIMS[0]}f", *(math.sin(0.05 * x + phase / 40) for x in range(DIMS[0])))
                for phase in range(97)]
        layer_bytes = 4 * DIMS[0] * DIMS[1]
        with (self.folder / "waves.raw").open("wb") as file:
            file.truncate(layer_bytes * DIMS[2])
            for z in (*range(11), *range(301, 323), *range(DIMS[2] - 5, DIMS[2])):
                file.seek(z * layer_bytes)
                file.write(b"".join(rows[(y + 3 * z + y * z // 64) % 97] for y in range(DIMS[1])))

    def run_limited(self, *arguments):
        limit = functools.partial(resource.setrlimit, resource.RLIMIT_AS, (LIMIT, LIMIT))
        return self.run_program(*arguments, preexec_fn=limit)

    def assert_same_bytes(self, name, *arguments):
        """The run with the limit maps layers, the other one the whole file."""
        command = (*RAW, *ISO, *arguments)
        free = self.convert(*command, "-o", f"free_{name}")
        self.assertNotIn("samples-in-windows", free.err)
        run = self.run_limited(*command, "-o", f"limited_{name}")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn(NOTE, run.err)
        free, limited = ((self.folder / f"{how}_{name}").read_bytes() for how in ("free", "limited"))
        self.assertGreater(len(free), 1000)
        self.assertTrue(free == limited, arguments)

    def test_bytes_are_those_of_a_mapped_file(self):
        for method in ("mc", "mt"):
            for normals in ("none", "smooth"):
                for name in ("a.ply", "a.glb"):
                    with self.subTest(method=method, normals=normals, name=name):
                        self.assert_same_bytes(name, "--method", method, "--normals", normals)

    def test_regions(self):
        """Slabs of a region begin at any layer. One region cuts triangles, which needs the whole mesh."""
        for region in (("--roi", "10,20,3,300,300,317", "--roi-snap"), ("--roi", "10,20,303,100,90,322", "--roi-snap"),
                       ("--roi", "-1,-1,636,400,400,639", "--roi-snap"), ("--roi", "10.5,20.5,300.5,100,90,310")):
            with self.subTest(region=region):
                self.assert_same_bytes("a.ply", "--normals", "smooth", *region)

    def test_other_work_on_the_mesh(self):
        part = ("--roi", "10,20,290,90,80,322", "--roi-snap")
        for arguments in (("--threads", "1"), ("--threads", "7"), ("--memory-limit", "64M"), ("--largest", "2"),
                          ("--normals", "area", *part), ("--smooth", "2", *part), ("--simplify", "0.2", *part),
                          ("--normals", "flat"), ("--require", "oriented"), ("--inside", "below"),
                          ("--scale", "2", "--up", "y")):
            with self.subTest(arguments=arguments):
                self.assert_same_bytes("a.ply", *arguments)
        for name in ("a.stl", "a.obj"):
            with self.subTest(name=name):
                self.assert_same_bytes(name)

    def test_reports(self):
        reports = []
        for run_command, name in ((self.run_program, "free"), (self.run_limited, "limited")):
            run = run_command(*RAW, *ISO, "-o", "a.ply", "--report", f"{name}.json", "-v", "--explain")
            self.assertEqual(run.code, 0, run.err)
            reports.append(json.loads((self.folder / f"{name}.json").read_text()))
            self.assertEqual("a few layers at a time" in run.err, name == "limited")
        free, limited = reports
        self.assertEqual(free["meshes"], limited["meshes"])
        self.assertEqual(free["bytes"], limited["bytes"])
        self.assertLess(limited["peak_memory_bytes"], LIMIT)

    def test_samples_that_are_not_numbers(self):
        """They are found in any layer, and the first one is named."""
        with (self.folder / "waves.raw").open("r+b") as file:
            for sample in ((7, 5, 500), (9, 8, 400)):
                file.seek(4 * (sample[0] + DIMS[0] * (sample[1] + DIMS[1] * sample[2])))
                file.write(struct.pack("<f", math.nan))
        run = self.run_limited(*RAW, *ISO, "-o", "a.ply")
        self.assert_fails(2, run, "2 of the samples are not a number (NaN), the first at index (9, 8, 400)")
        self.assert_same_bytes("a.ply", "--nan", "outside", "--normals", "smooth")

    def test_a_surface_that_is_not_there(self):
        run = self.run_limited(*RAW, "--iso", "5", "-o", "a.ply")
        self.assert_fails(2, run, "waves.raw: no surface at iso 5\n")

    def test_work_that_needs_the_whole_volume(self):
        refusal = "waves.raw: no memory for 288358400 bytes of samples, neither as a mapping of the file (mmap) nor as a copy: "
        before = self.files()
        for arguments in ((*ISO, "--blur", "1"), (*ISO, "--cap"), (*ISO, "--nan", "hole"), (*ISO, "--error"),
                          (*ISO, "--resolution", "64"), (*ISO, "--nodata", "0.5"), ("--iso", "auto"), ("--iso", "p50"),
                          (*ISO, "--method", "surface-nets"), (*ISO, "--method", "voxels"),
                          (*ISO, "--attribute", "v=waves.raw")):
            with self.subTest(arguments=arguments):
                run = self.run_limited(*RAW, *arguments, "-o", "a.ply")
                self.assert_fails(2, run, refusal, "the address space of the process is limited to 256 MiB")
                self.assertNotIn("samples-in-windows", run.err)
        self.assert_fails(2, self.run_limited("info", *RAW), refusal)
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    main()
