"""The memory limit is kept by whole conversions: what the process takes at most, against what it was allowed."""

import gzip
import hashlib
import itertools
import json
import multiprocessing
import os
import random
import resource
import struct

from support import DATA, ProgramTest, main, needs_data, peak_mib_of
from vdb_files import grid, vdb

MIB = 1 << 20
# The program and its libraries, the stacks of its threads, and small allocations without a reservation.
OVERHEAD = 64 * MIB
# What Mesa's software renderer takes beside textures and buffers: its compiler, and the pages it draws to.
SOFTWARE_RENDERER = 256 * MIB

GYROID = "demo:gyroid?size=224"
LARGE_GYROID = "demo:gyroid?size=272"  # large enough without its mesh, which goes to the file by parts


class MemoryTest(ProgramTest):
    def write_waves(self, size):
        """Smooth waves of float samples, as NRRD packed by gzip."""
        row = [struct.pack(f"<{size}f", *(((x * 5 + shift) % 61 - 30) / 30 for x in range(size))) for shift in range(61)]
        samples = b"".join(row[(3 * y + 7 * z) % 61] for z in range(size) for y in range(size))
        header = f"NRRD0004\ntype: float\ndimension: 3\nsizes: {size} {size} {size}\nendian: little\nencoding: gzip\n\n"
        (self.folder / "waves.nrrd").write_bytes(header.encode() + gzip.compress(samples, 1))
        return "waves.nrrd"

    def report(self, *arguments, **variables):
        run = self.run_program(*arguments, "--report", "report.json", "--quiet", env={**os.environ, **variables})
        return run, json.loads((self.folder / "report.json").read_text())

    def hash(self, name):
        """Of a file, read in small pieces: the peak of this process counts for those that it starts."""
        with (self.folder / name).open("rb") as file:
            hashed = hashlib.sha256()
            for part in iter(lambda: file.read(MIB), b""):
                hashed.update(part)
        return hashed.hexdigest()

    def check(self, *arguments, allowed=OVERHEAD, peak_at_least=64 * MIB):
        """Three runs: what it needs; with a limit that is just enough; with one that is too small."""
        run, report = self.report(*arguments)
        self.assertEqual(run.code, 0, run.err)
        needed = report["reserved_memory_bytes"]
        # The case is large enough for a lost reservation to be seen.
        self.assertGreater(needed, peak_at_least)
        self.assertLess(report["peak_memory_bytes"], needed + allowed, f"{arguments}: more than is reserved")
        before = self.files()
        run, report = self.report(*arguments, "--memory-limit", f"{needed + MIB}B")
        self.assertEqual(run.code, 0, run.err)
        self.assertLess(report["peak_memory_bytes"], needed + MIB + allowed)
        kept = {"waves.nrrd", "leaves.vdb", "map.raw", "report.json"}
        for name in set(self.files()) - kept:
            (self.folder / name).unlink()
        run, report = self.report(*arguments, "--memory-limit", f"{needed // 2}B")
        self.assert_fails(2, run, "memory", "--memory-limit")
        self.assertLess(report["peak_memory_bytes"], needed // 2 + allowed)
        self.assertEqual(set(self.files()), set(before) & kept)

    def test_dense_samples(self):
        self.check(LARGE_GYROID, "--iso", "0", "-o", "a.ply")

    def test_samples_from_a_packed_file(self):
        """They are in memory, or with half of it in a temporary file (scratch_test.py)."""
        arguments = (self.write_waves(272), "--iso", "0.1", "-o", "a.glb")
        run, report = self.report(*arguments)
        self.assertEqual(run.code, 0, run.err)
        needed = report["reserved_memory_bytes"]
        self.assertGreater(needed, 4 * 272**3)
        self.assertLess(report["peak_memory_bytes"], needed + OVERHEAD)
        run, report = self.report(*arguments, "--memory-limit", f"{needed // 2}B")
        self.assertEqual(run.code, 0, run.err)
        self.assertLess(report["peak_memory_bytes"], needed // 2 + OVERHEAD)

    def test_marching_tetrahedra_with_smooth_normals(self):
        self.check(GYROID, "--iso", "0", "--method", "mt", "--normals", "smooth", "-o", "a.obj")

    def test_label_maps(self):
        # Layers of 59 labels, and noise in every eighth, so that there is much of all that a net has.
        size, noise = 88, random.Random(1)
        layers = [noise.randbytes(size * size).translate(bytes(n % 60 for n in range(256))) if z % 8 == 0
                  else bytes((x // 3 * 7 + y // 2 * 5 + z) % 60 for y in range(size) for x in range(size))
                  for z in range(size)]
        (self.folder / "map.raw").write_bytes(b"".join(layers))
        # One thread: with several, it depends on their timing how much they hold at the same time.
        arguments = ("map.raw", "--dims", f"{size},{size},{size}", "--labels", "all", "-o", "a.glb", "--threads", "1")
        run, report = self.report(*arguments)
        self.assertEqual(run.code, 0, run.err)
        self.assertNotIn("voxels-in-files", [note["id"] for note in report["notes"]])
        needed = report["reserved_memory_bytes"]
        self.assertGreater(needed, 64 * MIB)
        self.assertLess(report["peak_memory_bytes"], needed + OVERHEAD)
        whole = self.hash("a.glb")
        # The arrays of the net get half of the limit. With 3/5 of the memory that it takes, the first attempt fails, as
        # noise has many bodies.
        for limit, in_files in ((2 * needed, False), (needed * 3 // 5, True)):
            (self.folder / "a.glb").unlink()
            run, report = self.report(*arguments, "--memory-limit", f"{limit}B")
            self.assertEqual(run.code, 0, run.err)
            self.assertEqual("voxels-in-files" in [note["id"] for note in report["notes"]], in_files)
            self.assertLessEqual(report["reserved_memory_bytes"], limit)
            self.assertLess(report["peak_memory_bytes"], limit + OVERHEAD)
            self.assertEqual(self.hash("a.glb"), whole)
        (self.folder / "a.glb").unlink()
        # Without a folder for files, memory is used as before.
        run, report = self.report(*arguments, "--memory-limit", f"{needed + MIB}B", TMPDIR="/dev/shm")
        self.assertEqual(run.code, 0, run.err)
        self.assertNotIn("voxels-in-files", [note["id"] for note in report["notes"]])
        self.assertEqual(self.hash("a.glb"), whole)
        (self.folder / "a.glb").unlink()
        run = self.run_program(*arguments, "--memory-limit", f"{needed // 4}B", env={**os.environ, "TMPDIR": "/dev/shm"})
        self.assert_fails(2, run, "memory", "a temporary file", "it is in memory (tmpfs)", "for the voxels and points of the net",
                          "TMPDIR", "--memory-limit")
        self.assertNotIn("a.glb", self.files())

    def test_a_file_of_many_meshes(self):
        """Meshes wait for a GLB until they take an eighth of the limit; then their data is written and moved."""
        size, noise = 88, random.Random(2)
        (self.folder / "map.raw").write_bytes(noise.randbytes(size**3).translate(bytes(n % 40 for n in range(256))))
        arguments = ("map.raw", "--dims", f"{size},{size},{size}", "--labels", "all", "--method", "voxels", "-o", "a.glb",
                     "--threads", "1")
        run, report = self.report(*arguments)
        self.assertEqual(run.code, 0, run.err)
        whole = self.hash("a.glb")
        limit = report["reserved_memory_bytes"] // 3
        self.assertLess(limit, (self.folder / "a.glb").stat().st_size / 4)
        run, report = self.report(*arguments, "--memory-limit", f"{limit}B")
        self.assertEqual(run.code, 0, run.err)
        self.assertLess(report["peak_memory_bytes"], limit + OVERHEAD)
        self.assertEqual(self.hash("a.glb"), whole)

    def test_packed_meshes_are_estimated(self):
        """Of several meshes, each is freed when it is packed."""
        several = ("--iso", 0.5, "--iso", -0.5)
        for options in (("a.drc",), ("a.glb", "--meshopt"), ("a.glb", "--draco", *several), ("a.glb", "--meshopt", *several),
                        ("a.glb", "--quantize", *several), ("a.glb", *several), ("a.gltf", *several)):
            with self.subTest(options):
                run = ("demo:gyroid?size=176", "--iso", 0, "--threads", 2, "-o", *options)
                self.assertAlmostEqual(self.told_mib(*run) / self.peak_mib(*run), 1, delta=0.25)

    def test_the_distance_of_a_simplified_mesh(self):
        """Faces that lie in planes at right angles to others: rounding made parts of triangles without end, 1.6 GiB."""
        for demo, share in (("sphere?size=24", "50%"), ("torus?size=16", "50%"), ("metaballs?size=20", "25%")):
            run, report = self.report(f"demo:{demo}", "--iso", "0", "--method", "voxels", "--triangles", share, "-o", "a.ply")
            self.assertEqual(run.code, 0, run.err)
            self.assertLess(report["peak_memory_bytes"], report["reserved_memory_bytes"] + OVERHEAD, demo)

    def test_another_resolution(self):
        self.check("demo:gyroid?size=160", "--iso", "0", "--resolution", "256", "-o", "a.ply")

    def test_a_hollow_mesh(self):
        self.check("demo:sphere?size=128", "--iso", "0", "--hollow", "1.5voxel", "-o", "a.ply")

    @needs_data("vdb/smoke.vdb")
    def test_sparse_samples(self):
        self.check(DATA / "vdb/smoke.vdb", "--iso", "0.1", "-o", "a.ply", peak_at_least=12 * MIB)

    def write_scattered(self, side, step):
        """side^3 leaf nodes, one every `step` voxels, each with one voxel that is inside, at its corner."""

        def write():
            places = itertools.product(range(0, side * step, step), repeat=3)
            (self.folder / "leaves.vdb").write_bytes(vdb(grid(voxels=dict.fromkeys(places, 1.0))))

        # A process begins with the peak of the one that starts it.
        writer = multiprocessing.get_context("fork").Process(target=write)
        writer.start()
        writer.join()
        self.assertEqual(writer.exitcode, 0)
        return "leaves.vdb"

    def test_leaves_in_nodes_of_their_own(self):
        """What finds them takes many times what they do."""
        self.check(self.write_scattered(16, 128), "--iso", "0.5", "-o", "a.ply")
        (told,) = json.loads(self.convert("info", "leaves.vdb", "--json").text)
        run, report = self.report("leaves.vdb", "--iso", "0.5", "-o", "a.glb")
        self.assertEqual(run.code, 0, run.err)
        self.assertAlmostEqual(told["field"]["memory"]["conversion"] / report["peak_memory_bytes"], 1, delta=0.3)

    def write_raw_waves(self, name):
        """A file of 91 MiB, with an edge in almost every cell. Returns the options that read it."""
        size = 288
        row = [struct.pack(f"<{size}f", *(((x * 5 + shift) % 61 - 30) / 30 for x in range(size))) for shift in range(61)]
        (self.folder / name).write_bytes(
            b"".join(row[(3 * y + 7 * z) % 61] for z in range(size) for y in range(size)))
        return ("--dims", f"{size},{size},{size}", "--dtype", "f32", "--threads", 2)

    def test_info_tells_what_a_mapped_file_takes(self):
        """The samples are not in memory, nor is the mesh, unless an option needs it."""
        raw = ("waves.raw", *self.write_raw_waves("waves.raw"))
        (told,) = json.loads(self.convert("info", *raw, "--json").text)
        memory = told["field"]["memory"]
        iso = ("--iso", told["field"]["suggestion"]["iso"])
        self.assertAlmostEqual(memory["conversion"] / MIB / self.peak_mib(*raw, *iso, "-o", "a.glb"), 1, delta=0.3)
        self.assertLess(memory["conversion"], memory["samples"])
        whole = self.peak_mib(*raw, *iso, "-o", "a.glb", "--drop-components", "1")
        self.assertAlmostEqual(memory["whole_mesh"] / MIB / whole, 1, delta=0.3)

    def test_a_dry_run_tells_what_parts_of_a_mesh_take(self):
        """The samples stay in the file, and one part after another is written."""
        raw = (*self.write_raw_waves("waves_1.raw"), "--iso", 0.1)
        for name in ("a.ply", "a.obj", "a.stl"):
            for more in ((), ("--report", "r_1.json")):
                with self.subTest(name=name, more=more):
                    told = self.told_mib("waves_#.raw", *raw, "-o", f"{{}}_{name}",
                                     *(word.replace("1", "{}") for word in more))
                    self.assertAlmostEqual(told / self.peak_mib("waves_1.raw", *raw, "-o", name, *more), 1, delta=0.25)

    def test_a_dry_run_knows_what_options_take(self):
        """Of a mapped file of 81 MiB: what options add to the mesh, and that its pages go when they were read."""
        self.convert("demo:gyroid?size=277", "-o", "gyroid.nrrd")
        for options in (("a.glb",), ("a.ply", "--threads", 1), ("a.ply", "--method", "mt"), ("a.ply", "--cap"),
                        ("a.ply", "--roi", "-1,-1,-1,0.2,0.3,0"), ("a.ply", "--nan", "hole"), ("a.ply", "--blur", 1),
                        ("a.ply", "--blur", "median:1"), ("a.ply", "--resolution", "200,200,200"),
                        ("a.ply", "--method", "voxels"), ("a.glb", "--iso", 0.5), ("a.glb", "--quantize")):
            with self.subTest(options):
                threads = () if "--threads" in options else ("--threads", 2)
                run = ("gyroid.nrrd", "--iso", 0, *threads, "-o", *options)
                self.assertAlmostEqual(self.told_mib(*run) / self.peak_mib(*run), 1, delta=0.25)

    def test_the_samples_of_a_mapped_label_map_are_released(self):
        """Slice by slice, when the labels in them are found."""
        size = 432
        slices = [bytes((x // 27 + n) % 16 for x in range(size)) * size for n in range(16)]
        (self.folder / "map.raw").write_bytes(b"".join(slices[z // 27] for z in range(size)))
        run = self.convert("map.raw", "--dims", f"{size},{size},{size}", "--labels", "3", "--method", "voxels",
                           "-o", "a.ply", "-v", "--threads", "2")
        self.assertLess(peak_mib_of(run) * MIB, size**3 * 0.8)

    def test_label_maps_are_estimated(self):
        """Cells of 12x11x17 voxels with 250 labels; the mapped file is released when its labels are found."""
        size = 160
        rows = {}
        for y, z in itertools.product(range(0, size, 11), range(0, size, 17)):
            rows[y // 11, z // 17] = bytes(((x // 12) * 7 + (y // 11) * 31 + (z // 17) * 57) % 251 for x in range(size))
        (self.folder / "map.raw").write_bytes(
            b"".join(rows[(y + z // 4) % size // 11, z // 17] for z in range(size) for y in range(size)))
        raw = ("map.raw", "--dims", f"{size},{size},{size}", "--threads", "2")
        for name, *options in (("a.glb",), ("a.glb", "--method", "voxels"), ("a.glb", "--relax", "0"), ("a.gltf",),
                               ("a.glb", "--quantize"), ("a.gltf", "--quantize"), ("{label}.ply",),
                               ("a.glb", "--simplify", "0.1")):
            with self.subTest(name=name, options=options):
                run = (*raw, "--labels", "all", *options, "-o", name)
                self.assertAlmostEqual(self.told_mib(*run) / self.peak_mib(*run), 1, delta=0.25)
        one = (*raw, "--labels", "3", "-o", "a.glb")
        self.assertAlmostEqual(self.told_mib(*one) / self.peak_mib(*one), 1, delta=0.25)
        (found,) = json.loads(self.convert("info", *raw, "--json").text)
        told = self.told_mib(*raw, "--labels", "all", "-o", "a.glb")
        self.assertAlmostEqual(found["field"]["memory"]["conversion"] / MIB, told, delta=1)

    def test_leaves_beside_nothing(self):
        """What lies beside them is listed before it is known how much that is."""
        limit = 500 * MIB
        run, report = self.report(self.write_scattered(60, 24), "--iso", "0.5", "-o", "a.ply", "--memory-limit", f"{limit}B")
        self.assert_fails(2, run, "216000 blocks", "--memory-limit")
        self.assertLess(report["peak_memory_bytes"], limit + OVERHEAD // 2)

    def test_a_mesh_in_stl(self):
        self.check(LARGE_GYROID, "--iso", "0.3", "-o", "a.stl")

    def test_two_surfaces(self):
        self.check(GYROID, "--iso", "0", "--iso", "0.5", "-o", "a.glb")

    def test_a_capped_part(self):
        self.check("demo:metaballs?size=256", "--iso", "0.5", "--cap", "--nan", "hole", "-o", "a.ply")

    def test_simplification(self):
        self.check("demo:gyroid?size=96", "--iso", "0", "--triangles", "20%", "-o", "a.ply", peak_at_least=32 * MIB)

    def test_simplification_in_windows(self):
        """With less memory than the whole mesh needs, it is simplified in windows, to the same distance."""
        simplify = ("demo:gyroid?size=160", "--iso", "0", "--simplify", "0.1", "-o", "a.ply")
        run, report = self.report(*simplify)
        self.assertEqual(run.code, 0, run.err)
        (whole,) = report["simplifications"]
        self.assertEqual(whole["windows"], 0)
        for share in (2, 4):
            limit = report["reserved_memory_bytes"] // share
            estimate = self.told_mib(*simplify, "--memory-limit", f"{limit}B") * MIB
            run, limited = self.report(*simplify, "--memory-limit", f"{limit}B")
            self.assertEqual(run.code, 0, run.err)
            self.assertLess(limited["peak_memory_bytes"], limit + OVERHEAD)
            self.assertAlmostEqual(estimate / limited["peak_memory_bytes"], 1, delta=0.35)
            (windows,) = limited["simplifications"]
            self.assertGreater(windows["windows"], 2)
            self.assertIn("simplified-in-windows", [note["id"] for note in limited["notes"]])
            self.assertLessEqual(windows["measured"]["voxels"]["upper"], 0.1)
            self.assertLess(windows["triangles_after"], 1.03 * whole["triangles_after"])
        before = set(self.files())
        run = self.run_program(*simplify[:-1], "b.ply", "--memory-limit", "60M")
        self.assert_fails(2, run, "memory", "--memory-limit")
        self.assertEqual(set(self.files()), before)

    def test_packing(self):
        self.check("demo:gyroid?size=112", "--iso", "0", "--draco", "-o", "a.glb")
        self.check("demo:gyroid?size=80", "--iso", "0", "--draco", "--normals", "flat", "-o", "a.glb")
        self.check(GYROID, "--iso", "0", "--quantize", "--meshopt", "--optimize-order", "-o", "a.glb")

    def test_the_error(self):
        self.check("demo:gyroid?size=128", "--iso", "0", "--error", "-o", "a.ply")

    def test_a_limited_address_space(self):
        """Where the system refuses memory, the message names the limit that it has set, and not the budget's."""
        with (self.folder / "map.raw").open("wb") as file:
            file.truncate(4 * 400**3)
        limit = 200 * MIB

        def limit_address_space():
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

        told = r"the address space of the process is limited to 200 MiB\n  hint: raise that limit \(ulimit -v unlimited; "
        # Without --cap, the program maps a few layers at a time (address_space_test.py).
        run = self.run_program("map.raw", "--dims", "400,400,400", "--dtype", "f32", "--iso", "0.5", "--cap", "-o", "a.ply",
                               preexec_fn=limit_address_space)
        self.assert_fails(2, run, "map.raw: no memory for 256000000 bytes of samples, neither as a mapping of the file (mmap) "
                          "nor as a copy: ")
        self.assertRegex(run.err, told)
        run = self.run_program("demo:gyroid?size=400", "--iso", "0", "-o", "a.ply", preexec_fn=limit_address_space)
        self.assertEqual(run.code, 2, run.err)
        self.assertRegex(run.err, told)
        self.assertNotIn("--memory-limit", run.err)
        self.assertEqual(self.files(), ["map.raw"])

    def test_the_gpu(self):
        self.check("demo:gyroid?size=128", "--iso", "0", "--backend", "gpu", "--gpu-memory", "64M", "-o", "a.ply",
                   allowed=OVERHEAD + SOFTWARE_RENDERER, peak_at_least=32 * MIB)


if __name__ == "__main__":
    main()
