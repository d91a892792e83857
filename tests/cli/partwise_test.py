"""Meshes that go to their file while they are made: the same bytes, in memory that does not grow with the mesh."""

import csv
import io
import itertools
import json
import os
import random
import re
import resource
import struct
import threading

from support import SOURCE, ProgramTest, main
from vdb_files import grid, vdb

MIB = 1 << 20
# Files whose parts are written to their places, and files that are written in order.
PLACED = (("a.ply",), ("a.glb",))
ORDERED = (("a.obj",), ("a.stl",), ("a.ply", "--ascii"), ("a.stl", "--ascii"))
# Normals of faces, which need the vertices of two parts.
FLAT = (("a.ply", "--normals", "flat"), ("a.ply", "--normals", "flat", "--ascii"), ("a.obj", "--normals", "flat"))
GYROID = ("demo:gyroid?size=80", "--iso", 0)
WHOLE = ("--require", "no-duplicates")  # needs the mesh in memory, and changes nothing


class PartwiseTest(ProgramTest):
    def assert_same_bytes(self, name, *arguments, whole=WHOLE):
        """Returns the bytes."""
        self.convert(*arguments, "-o", f"parts_{name}")
        self.convert(*arguments, "-o", f"whole_{name}", *whole, "--quiet")
        parts, whole = ((self.folder / f"{how}_{name}").read_bytes() for how in ("parts", "whole"))
        self.assertEqual(len(parts), len(whole), arguments)
        self.assertTrue(parts == whole, arguments)
        return parts

    def test_bytes_are_those_of_whole_meshes(self):
        for arguments in self.conversions(GYROID):
            for name, in PLACED:
                with self.subTest(arguments=arguments, name=name):
                    self.assert_same_bytes(name, *arguments)

    def test_model_and_data_are_those_of_whole_meshes(self):
        for normals in ("none", "smooth", "flat"):
            files = []
            for folder, whole in (("parts", ()), ("whole", WHOLE)):
                self.convert(*GYROID, "--normals", normals, *whole, "-o", f"{folder}/a.gltf", "--mkdir")
                files.append([(self.folder / folder / name).read_bytes() for name in ("a.gltf", "a.bin")])
            self.assertTrue(files[0] == files[1], normals)

    def test_bytes_in_order_are_those_of_whole_meshes(self):
        for arguments in self.conversions(("demo:gyroid?size=40", "--iso", 0)):
            for name, *form in ORDERED:
                if name != "a.stl" or "--normals" not in arguments:  # STL has no choice
                    with self.subTest(arguments=arguments, name=name, form=form):
                        self.assert_same_bytes(name, *arguments, *form)

    @staticmethod
    def conversions(gyroid):
        region = ("--roi", "-.5,-.4,-.3,.9,.9,.8")
        more = ((), ("--cap",), ("--cap", "--normals", "none"), ("--normals", "smooth"), ("--normals", "flat"),
                ("--method", "mt"), ("--method", "mt", "--cap"), region, (*region, "--roi-snap"), ("--clip", "1,0,0,.1"),
                ("--smooth", 3), ("--threads", 1), ("--scale", 1e-3))
        return [(*gyroid, *options) for options in more] + [("demo:sphere?size=20", "--iso", 0)]

    def test_bodies_are_selected_by_parts_if_memory_does_not_hold_the_mesh(self):
        """Of noise: thousands of components, cavities, and one body through all parts. Nothing else may differ."""
        size, noise = 73, random.Random(5)  # the last part has vertices without triangles
        samples = [noise.random() for _ in range(size**3)]
        for step in (1, size, size * size):  # means of neighbors
            samples = [(a + b) / 2 for a, b in zip(samples, samples[step:] + samples[:step])]
        (self.folder / "a.raw").write_bytes(struct.pack(f"<{size**3}f", *samples))
        raw = ("a.raw", "--dims", f"{size},{size},{size}", "--dtype", "f32", "--report", "r.json")
        cavities = 0
        for iso, *options in ((0.54, "--largest"), (0.45, "--largest", 2), (0.5, "--drop-components", 40),
                              (0.5, "--drop-components", "area:30"), (0.45, "--drop-components", "volume:2world"),
                              (0.4, "--fill-cavities"), (0.42, "--drop-components", 9, "--cap", "--largest", 1),
                              (0.5, "--method", "mt", "--largest"), (0.5, "--drop-components", 3, "--threads", 1),
                              (0.5, "--drop-components", 1)):
            limit = ("--memory-limit", "48M" if "mt" in options else "24M" if iso >= 0.45 else "16M")
            for name, *form in (*PLACED, *ORDERED) if iso == 0.54 else PLACED[:1] if iso == 0.5 else ORDERED[:2]:
                with self.subTest(iso=iso, options=options, name=name, form=form):
                    arguments = (*raw, "--iso", iso, *options, *form, *(() if name == "a.stl" else ("--normals", "none")))
                    parts, whole = (self.selected(name, *arguments, *given) for given in (limit, WHOLE))
                    self.assertEqual((parts.pop("by_parts"), whole.pop("by_parts")), (True, False))
                    self.assertTrue(parts.pop("bytes") == whole.pop("bytes"))
                    self.assertEqual(parts, whole)
                    cavities += parts["pieces"]["after"]["components"] > parts["pieces"]["after"]["bodies"]
        self.assertGreater(cavities, 5)

    def test_a_small_rest_needs_no_whole_mesh(self):
        """A GLB of few vertices is not written by parts, and neither is a mesh without triangles."""
        # 31,301 small components, 7 MiB of mesh.
        noise = (*self.write_noise(72)[:-1], 251, "--normals", "none", "--report", "r.json")
        limit = ("--memory-limit", "26M")
        small = (*noise, "--largest", 3)
        parts, whole = (self.selected("a.glb", *small, *given) for given in (limit, ()))
        self.assertFalse(parts["by_parts"])
        self.assertEqual(parts, whole)
        self.assert_fails(2, self.run_program(*small, *limit, *WHOLE, "-o", "b.glb"), "memory")
        for given in (limit, ()):
            run = self.run_program(*noise, "--drop-components", 10**7, *given, "-o", "b.ply")
            self.assert_fails(2, run, "noise.raw: none of the", "components at iso 251 has the requested size")
            self.convert(*noise, "--drop-components", 10**7, "--empty", "write", *given, "-o", "b.ply")
            self.assertIn(b"element face 0\n", (self.folder / "b.ply").read_bytes())
            (self.folder / "b.ply").unlink()

    def selected(self, name, *arguments):
        """All that a conversion makes and tells of the bodies."""
        run = self.convert(*arguments, "-v", "-o", name)
        report = json.loads((self.folder / "r.json").read_text())
        (pieces,) = report["pieces"]
        return {"bytes": (self.folder / name).read_bytes(), "by_parts": "extracted and written" in run.err,
                "meshes": report["meshes"], "pieces": {key: pieces[key] for key in ("before", "after", "without_volume")},
                "notes": [note["id"] for note in report["notes"]]}

    def test_coordinates_far_from_the_origin(self):
        """Vertices then have an origin of their own, or are doubles."""
        self.write_raw("a.raw", (40, 40, 40), lambda x, y, z: (x * 7 + y * 5 + z * 3) % 11)
        raw = ("a.raw", "--dims", "40,40,40", "--dtype", "f32", "--iso", 5)
        for name in ("a.ply", "a.glb", "a.obj"):
            self.assert_same_bytes(name, *raw, "--origin", "1e7,0,0")
            self.assert_same_bytes(name, *raw)

    def assert_by_parts(self, by_parts, *arguments):
        self.assertEqual("extracted and written" in self.convert(*arguments, "-v").err, by_parts, arguments)

    def test_which_files_are_written_by_parts(self):
        for name, *form in (*PLACED, *ORDERED):
            output = (*form, "-o", name)
            self.assert_by_parts(True, *GYROID, *output)
            normals = () if name == "a.stl" else ("--normals", "none")
            self.assert_by_parts(True, *GYROID, *normals, "--cap", *output)
            self.assert_by_parts(False, *GYROID, "--method", "voxels", *output)
        self.assert_by_parts(True, *GYROID, "--touching", "apart", "-o", "a.ply")
        for name, *form in FLAT:
            self.assert_by_parts(True, *GYROID, *form, "--cap", "-o", name)
        self.assert_by_parts(True, *GYROID, "-o", "a.gltf")
        for name in ("a.gltf", "a.glb"):
            self.assert_by_parts(False, *GYROID, "--normals", "flat", "-o", name)

    def assert_early(self, early, *arguments):
        """Whether vertices go to the file while others are counted."""
        err = self.convert(*arguments, "-v").err
        found = re.search(r"s to compare samples, count and make (\d+) vertices, .* s to make the rest of the mesh", err)
        self.assertEqual(found is not None, early, err)
        if early:
            self.assertGreater(int(found[1]), 20000)

    def test_which_files_get_vertices_while_counting(self):
        none = ("--normals", "none")
        one = ("--threads", 1, "-o")  # several threads may leave all vertices to the later pass
        for name in ("a.ply", "a.glb", "a.gltf"):
            self.assert_early(True, *GYROID, *none, *one, name)
            self.assert_early(True, *GYROID, *none, "--cap", "--method", "mt", *one, name)
            self.assert_early(False, *GYROID, *none, "--report", "a.json", *one, name)  # measures the parts first
        self.assert_early(True, *GYROID, *one, "a.ply")
        self.assert_early(False, *GYROID, *one, "a.glb")  # normals follow all positions
        for name, *form in ORDERED:
            self.assert_early(False, *GYROID, *form, "-o", name)
        self.assert_early(False, *GYROID, *none, "--nan", "hole", "-o", "a.ply")
        self.assert_early(False, *GYROID, *none, "--drop-components", 10, "-o", "a.ply")

    def written_to_pipe(self, name, *arguments):
        """The bytes that a named pipe gets."""
        pipe = self.folder / name
        os.mkfifo(pipe)
        read = []
        reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
        reader.start()
        self.convert(*arguments, "-o", name)
        reader.join(60)
        pipe.unlink()
        return read[0]

    def test_sparse_fields(self):
        """Grids of a VDB file: the metaballs, and voxels at the lowest corner of a leaf, below which no leaf is."""
        metaballs = (SOURCE / "samples/metaballs.vdb", "--iso", 0.5)
        corners = {(8 * x, 8 * y, 8 * z): 1.0 for x, y, z in itertools.product(range(6), repeat=3)}
        (self.folder / "corners.vdb").write_bytes(vdb(grid(voxels=corners)))
        for arguments, has_order in ((metaballs, True), (("corners.vdb", "--iso", 0.5), False)):
            for options in ((), ("--method", "mt"), ("--report", "r.json")):
                for name, *form in (*PLACED, *ORDERED, *FLAT):
                    with self.subTest(arguments=arguments, options=options, name=name, form=form):
                        output = (*arguments, *options, *form, "-o")
                        self.assert_same_bytes(name, *arguments, *options, *form)
                        needs_order = name == "a.stl" or "flat" in form or "--report" in options
                        is_small = name == "a.glb"  # its indices have 16 bits
                        self.assert_by_parts(not is_small and (has_order or not needs_order), *output, name)

    def test_streams_get_the_bytes_of_files_part_by_part(self):
        for name, *form in (*PLACED, *ORDERED, *FLAT):
            shapes = ((*GYROID, "--normals", "smooth"), (*GYROID, "--cap"), ("demo:sphere?size=20", "--iso", 0))
            for arguments in shapes if name != "a.stl" and "flat" not in form else shapes[1:]:
                with self.subTest(name=name, form=form, arguments=arguments):
                    self.convert(*arguments, *form, "-o", name)
                    file = (self.folder / name).read_bytes()
                    run = self.convert(*arguments, *form, "-o", "-", "--format", name[2:], "-v")
                    self.assertTrue(run.out == file)
                    # The indices of a small GLB have 16 bits, and caps with smooth normals need the whole mesh.
                    is_whole = name == "a.glb" and arguments != shapes[0]
                    self.assertEqual("extracted and written" in run.err, not is_whole)
                    self.assertTrue(self.written_to_pipe(f"pipe_{name}", *arguments, *form) == file)

    def test_stl_of_a_skewed_grid(self):
        """Where two axes are almost parallel, vertices on different edges share a position, and move apart."""
        samples = bytes((x * 7 + y * 5 + z * 3) % 4 for z in range(20) for y in range(20) for x in range(20))
        for skewed, axis in ((False, "(1,-1,0)"), (True, "(1,1.000001,0)")):
            (self.folder / "a.nrrd").write_bytes(
                f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 20 20\nencoding: raw\nspace dimension: 3\n"
                f"space directions: (1,1,0) {axis} (0,0,1)\n\n".encode() + samples)
            for form in ((), ("--touching", "keep")):
                self.assert_by_parts(not skewed, "a.nrrd", "--iso", 2, "-o", "a.stl", *form)
                # If touching vertices stay, some triangles get the corners of others.
                self.assert_same_bytes("a.stl", "a.nrrd", "--iso", 2, *form, whole=("--drop-components", 1))

    def test_holes_around_nan(self):
        samples = [((x * 7 + y * 5 + z * 3) % 11) / 11 for z in range(9) for y in range(9) for x in range(9)]
        samples[400] = float("nan")
        (self.folder / "nan.raw").write_bytes(struct.pack("<729f", *samples))
        raw = ("nan.raw", "--dims", "9,9,9", "--dtype", "f32", "--iso", .5)
        for policy in ("hole", "outside"):
            self.assert_same_bytes("a.ply", *raw, "--nan", policy)
            self.assert_same_bytes("b.ply", *raw, "--nan", policy, "--normals", "smooth")
            self.assert_same_bytes("c.stl", *raw, "--nan", policy)
            self.assert_same_bytes("c.obj", *raw, "--nan", policy, "--normals", "smooth")

    def test_json_of_a_glb_has_room_for_any_bounds(self):
        content = self.assert_same_bytes("a.glb", *GYROID)
        [length] = struct.unpack("<I", content[12:16])
        text = content[20:20 + length]
        model = json.loads(text)
        self.assertEqual(model["accessors"][0]["min"], [-1, -1, -1])
        self.assertEqual(model["accessors"][0]["max"], [1, 1, 1])
        self.assertEqual(content[20 + length + 4:20 + length + 8], b"BIN\0")

    def figures(self, *arguments):
        """The figures of the mesh in the report, and whether it was written by parts."""
        run = self.convert(*arguments, "--report", "r.json", "-v")
        report = json.loads((self.folder / "r.json").read_text())
        return report["meshes"], "extracted and written" in run.err

    def assert_same_figures(self, *arguments):
        by_parts, is_by_parts = self.figures(*arguments)
        whole, is_not = self.figures(*arguments, *WHOLE)
        self.assertEqual((is_by_parts, is_not), (True, False), arguments)
        self.assertEqual(by_parts, whole, arguments)
        return by_parts[0]

    def write_noise(self, size):
        """Random bytes, of which a seventh is inside: many small components, some of them cut by the data boundary."""
        samples = random.Random(7).choices((0, 255, 10, 20, 30, 90, 60), k=size**3)
        (self.folder / "noise.raw").write_bytes(bytes(samples))
        return ("noise.raw", "--dims", f"{size},{size},{size}", "--iso", 99.5)

    def test_report_has_the_figures_of_the_whole_mesh(self):
        noise = self.write_noise(40)
        many = self.assert_same_figures(*noise, "-o", "a.ply", "--normals", "none")
        self.assertGreater(many["components"], 1000)
        self.assertGreater(many["triangles"], 2 << 15)  # several ranges of the sums, and several parts in each
        self.assertGreater(many["component_table"]["others"]["components"], 900)
        for options in (("--cap",), ("--method", "mt"), ("--method", "mt", "--cap"), ("--threads", 1), ("--threads", 5),
                        ("--roi", "3,4,5,35,30,31", "--roi-snap", "--cap"), ("--spacing", "1,2,.3"), ("--normals", "smooth")):
            normals = () if "--normals" in options else ("--normals", "none")
            with self.subTest(options=options):
                figures = self.assert_same_figures(*noise, *options, *normals, "-o", "a.ply")
                self.assertEqual(figures["closed"], "--cap" in options)
        for name, *form in (*PLACED, *ORDERED):
            with self.subTest(name=name, form=form):
                self.assert_same_figures(*GYROID, *form, "-o", name)
        self.assert_same_figures("demo:sphere?size=20", "--iso", 0, "-o", "a.ply")

    def test_the_error_is_that_of_the_whole_mesh(self):
        noise = (*self.write_noise(24), "--normals", "none", "--error")
        for options in ((), ("--method", "mt"), ("--roi", "3,4,5,20,21,22", "--roi-snap")):
            figures = self.assert_same_figures(*noise, *options, "-o", "a.ply")
            self.assertGreater(figures["error"]["coverage"]["components"], 100)
        self.assert_by_parts(False, *noise, "--cap", "-o", "a.ply")
        self.assert_by_parts(False, *noise, "--largest", "-o", "a.ply")
        self.assert_by_parts(False, *noise, "--resolution", 12, "-o", "a.ply")
        self.assert_by_parts(False, *GYROID, "--error", "-o", "a.ply")  # has a formula

    def test_the_error_of_a_large_mesh_is_measured_in_windows(self):
        layers = (*self.write_layers(80), "--normals", "none", "--error", "-o", "a.ply")
        parts, _ = self.figures(*layers, "--memory-limit", "140M")
        self.assertEqual(self.figures(*layers, *WHOLE), (parts, False))
        (figures,) = parts
        self.assertGreater(figures["triangles"], 900_000)
        self.assertEqual(figures["error"]["coverage"]["components"], 79)
        # A plane between samples of 0 and 255, at 100.
        self.assertLess(figures["error"]["interior"]["max"]["voxels"], 1e-4)

    def test_threads_and_memory_change_no_figure(self):
        noise = (*self.write_noise(40), "-o", "a.ply", "--normals", "none", "--cap")
        figures = [self.figures(*noise, *how) for how in ((), ("--threads", 1), ("--memory-limit", "16M", "--threads", 2))]
        self.assertEqual(figures[1:], figures[:1] * 2)
        self.assertTrue(figures[0][1])

    def test_tables_take_no_whole_mesh(self):
        raw, *layers = self.write_layers(112)  # 48 MiB of mesh
        for frame in (1, 2):
            (self.folder / f"in_{frame}.raw").hardlink_to(self.folder / raw)
        self.convert("in_#.raw", *layers, "--normals", "none", "-o", "out/{}.ply", "--mkdir", "--jobs", 1, "--memory-limit", "32M",
                     "--table", "t.csv")
        [row, *_] = csv.DictReader(io.StringIO((self.folder / "t.csv").read_text()))
        self.convert(raw, *layers, "--normals", "none", "-o", "a.ply", "--report", "r.json")
        [whole] = json.loads((self.folder / "r.json").read_text())["meshes"]
        self.assertEqual((int(row["triangles"]), float(row["area"])), (whole["triangles"], whole["area"]))

    def test_requirements_are_tested_before_anything_is_written(self):
        self.assert_by_parts(True, *GYROID, "--normals", "none", "--cap", "--require", "closed,manifold,oriented", "-o", "a.ply")
        (self.folder / "a.ply").unlink()
        whole = self.run_program(*GYROID, "--require", "closed,no-duplicates", "-o", "a.ply")
        for form in ("ply", "obj", "stl", "glb"):
            run = self.run_program(*GYROID, "--require", "closed,one-component", "-o", "-", "--format", form)
            self.assert_fails(6, run, "the mesh does not meet the requirement closed", "open edges", "--cap")
            self.assertEqual(run.out, b"")
            count = re.search(r"([0-9]+) open edges", whole.err)
            self.assertIn(count[0], run.err)
        self.assertEqual(self.files(), [])

    def write_layers(self, size):
        """Bytes whose surface has 2 size^3 triangles: every second layer of samples is inside."""
        layer = [bytes([255 * (z % 2)]) * size**2 for z in range(2)]
        (self.folder / "layers.raw").write_bytes(b"".join(layer[z % 2] for z in range(size)))
        return ("layers.raw", "--dims", f"{size},{size},{size}", "--iso", 100)

    def test_memory_does_not_grow_with_the_mesh(self):
        layers = self.write_layers(160)
        for name in ("a.ply", "a.glb"):
            # 8 million triangles: 96 MiB of triangles and 48 MiB of vertices.
            self.convert(*layers, "--normals", "none", "-o", name, "--memory-limit", "24M")  # with any number of threads
            self.assertGreater((self.folder / name).stat().st_size, 130 * MIB)
            (self.folder / name).unlink()
            whole = self.run_program(*layers, "--normals", "none", "-o", name, "--memory-limit", "24M", *WHOLE)
            self.assert_fails(2, whole, "triangles", "--memory-limit", "PLY, glTF, OBJ and STL files take a mesh in parts")
            # The figures of the mesh need two parts, and the corners at their vertices.
            self.convert(*layers, "--normals", "none", "-o", name, "--memory-limit", "60M", "--report", "r.json")
            (self.folder / "r.json").unlink()
            (self.folder / name).unlink()
            # Not even the marks of all samples fit: each sample is compared twice.
            self.convert(*layers, "--normals", "none", "-o", f"slabs_{name}", "--memory-limit", "13M", "--threads", 1)
            self.convert(*layers, "--normals", "none", "-o", name)
            slabs, plain = ((self.folder / f).read_bytes() for f in (f"slabs_{name}", name))
            self.assertTrue(slabs == plain)
            (self.folder / name).unlink()
            (self.folder / f"slabs_{name}").unlink()
        self.assertEqual(self.files(), ["layers.raw"])

    def test_memory_does_not_grow_with_a_mesh_that_is_written_in_order(self):
        layers = self.write_layers(112)
        for name, *form in (*ORDERED, *FLAT):
            with self.subTest(name=name, form=form):
                output = (*layers, *form, "-o", name)
                # 2.7 million triangles: 32 MiB of triangles and 16 MiB of vertices.
                whole = self.run_program(*output, "--memory-limit", "40M", *WHOLE)
                self.assert_fails(2, whole, "triangles", "--memory-limit")
                # A part has 3.4 MiB; of STL and flat normals, two are in memory.
                limit = ("--memory-limit", "8M" if name == "a.stl" or "flat" in form else "5M")
                self.convert(*output, *limit)
                limited = (self.folder / name).read_bytes()
                streamed = self.convert(*layers, *form, "-o", "-", "--format", name[2:], *limit)
                self.assertTrue(streamed.out == limited)
                self.convert(*output)
                self.assertTrue((self.folder / name).read_bytes() == limited)

    def test_sequences_take_no_whole_mesh_and_record_the_hash_of_each_file(self):
        raw, *layers = self.write_layers(160)
        for frame in (1, 2):
            (self.folder / f"in_{frame}.raw").hardlink_to(self.folder / raw)
        sequence = ("in_#.raw", *layers, "--normals", "none", "--memory-limit", "24M", "--jobs", 1)
        for name in ("a.ply", "a.glb"):
            with self.subTest(name=name):
                output = ("-o", f"out/{{}}_{name}", "--mkdir")
                self.convert(*sequence, *output)
                for frame in (1, 2):  # a GLB has the name of the input
                    self.convert(f"in_{frame}.raw", *layers, "--normals", "none", "-o", name)
                    single = (self.folder / name).read_bytes()
                    self.assertTrue((self.folder / f"out/{frame}_{name}").read_bytes() == single)
                # A file of another hash is made again, although its size and time are the same.
                changed = self.folder / f"out/2_{name}"
                times = changed.stat()
                with changed.open("r+b") as file:
                    file.seek(100 * MIB)
                    file.write(b"damage")
                os.utime(changed, ns=(times.st_atime_ns, times.st_mtime_ns))
                again = self.convert(*sequence, *output, "--resume")
                self.assertIn("1 of 2 frames done, 1 kept", again.err)
                self.assertTrue(changed.read_bytes() == single)

    def test_a_sequence_of_three_surfaces_holds_two_of_them_at_a_time(self):
        """Each surface takes 139 MiB; a manifest records the hash of the GLB that has all."""
        raw, *layers = self.write_layers(160)
        for frame in (1, 2):
            (self.folder / f"in_{frame}.raw").hardlink_to(self.folder / raw)
        surfaces = (*layers, "--iso", 150, "--iso", 200, "--normals", "none")
        self.convert("in_#.raw", *surfaces, "--jobs", 1, "--memory-limit", "300M", "-o", "out/{}.glb", "--mkdir")
        self.convert("in_2.raw", *surfaces, "-o", "2.glb")
        self.assertGreater((self.folder / "2.glb").stat().st_size, 400 * MIB)
        self.assertTrue((self.folder / "out/2.glb").read_bytes() == (self.folder / "2.glb").read_bytes())
        again = self.convert("in_#.raw", *surfaces, "-o", "out/{}.glb", "--resume")
        self.assertIn("2 kept", again.err)

    def test_no_file_is_left_if_writing_fails(self):
        for name, *form in (*PLACED, *ORDERED):
            def limit():
                resource.setrlimit(resource.RLIMIT_FSIZE, (MIB, MIB))
            run = self.run_program(*GYROID, *form, "-o", name, preexec_fn=limit)
            self.assert_fails(4, run, name, "ulimit -f")
            self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
