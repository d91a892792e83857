"""--report: every document fits its schema, and its figures are those of the files themselves."""

import json
import math
import os
import pathlib
import struct
import sys
import unittest

from support import DATA, INSTALL, PROGRAM, SOURCE, SPHERE, ProgramTest, main, needs_data, read_glb, read_ply
from vdb_files import grid, vdb

try:
    import jsonschema
except ImportError:
    sys.exit(f"{sys.executable} has no module jsonschema: {INSTALL}, as python3-jsonschema, for Debian's own python3")

SCHEMA = json.loads((SOURCE / "docs" / "schemas" / "report.schema.json").read_text())
PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-openvdb.so"
METABALLS = SOURCE / "samples" / "metaballs.vdb"


class ReportTest(ProgramTest):
    def report(self, *arguments, code=0, name="report.json"):
        """The report of a run, checked against its schema; and the run."""
        run = self.run_program(*arguments, "--report", name)
        self.assertEqual(run.code, code, run.err)
        report = json.loads((self.folder / name).read_text(encoding="utf-8"))
        jsonschema.Draft202012Validator(SCHEMA).validate(report)
        self.assertEqual(report["status"], "done" if code == 0 else "failed")
        self.assertEqual(report["bytes"]["written"], sum(entry["bytes"] for entry in report["files"]))
        return report, run

    def fact(self, facts, what):
        (found,) = [fact for fact in facts if fact["what"] == what]
        return found

    def test_the_schema_is_one_and_refuses_what_it_does_not_know(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        report, _ = self.report(SPHERE, "--iso", "0")
        valid = jsonschema.Draft202012Validator(SCHEMA).is_valid
        self.assertTrue(valid(report))
        for change in ({"new": 1}, {"schema_version": 2}, {"status": "failed"}, {"input": None},
                       {"meshes": [{**report["meshes"][0], "volume": "much"}]}):
            self.assertFalse(valid({**report, **change}), change)

    def test_figures_of_a_closed_mesh_are_those_of_the_file(self):
        report, run = self.report(SPHERE, "--iso", "0", "-o", "a.ply", "--threads", "1")
        mesh = read_ply((self.folder / "a.ply").read_bytes())
        (facts,) = report["meshes"]
        self.assertEqual(facts["vertices"], len(mesh.vertices))
        self.assertEqual(facts["triangles"], len(mesh.triangles))
        self.assertEqual((facts["closed"], facts["open_edges"]), (True, mesh.open_edges()))
        edges = {tuple(sorted(edge)) for a, b, c in mesh.triangles for edge in ((a, b), (b, c), (c, a))}
        self.assertEqual(facts["euler"], len(mesh.vertices) - len(edges) + len(mesh.triangles))
        self.assertEqual((facts["components"], facts["genus"]), (1, 0))
        self.assertAlmostEqual(facts["volume"], mesh.volume(), delta=1e-6 * mesh.volume())
        self.assertEqual((facts["bounds"]["min"], facts["bounds"]["max"]), mesh.bounds())
        self.assertEqual(report["files"], [{"path": "a.ply", "bytes": (self.folder / "a.ply").stat().st_size}])
        self.assertEqual(report["arguments"], [SPHERE, "--iso", "0", "-o", "a.ply", "--threads", "1", "--report",
                                               "report.json"])
        self.assertEqual(report["device"]["threads"], 1)
        self.assertEqual(report["bytes"]["uploaded"], 0)
        self.assertEqual((report["input"]["format"], report["input"]["file_bytes"]), ("demo", None))
        self.assertIn(f"{facts['triangles']} triangles", run.err)

    def test_error_is_there_when_asked_for_and_is_what_was_told(self):
        report, _ = self.report(SPHERE, "--iso", "0", "-o", "a.ply")
        self.assertNotIn("error", report["meshes"][0])
        report, run = self.report(SPHERE, "--iso", "0", "-o", "a.glb", "--error", "tricubic", "--scale", "100")
        error = report["meshes"][0]["error"]
        self.assertEqual((error["interpolant"], report["options"]["error"]), ("tricubic", "tricubic"))
        self.assertEqual(error["interior"]["points"], 7 * report["meshes"][0]["triangles"])
        self.assertEqual(error["vertices"]["points"], report["meshes"][0]["vertices"])
        self.assertIn(f"rms {error['interior']['rms']['voxels']:.3g}, ", run.err)
        self.assertAlmostEqual(error["interior"]["rms"]["world"] / error["interior"]["rms"]["voxels"], 100 * 2 / 23)
        self.assertLess(error["storage"]["max"]["voxels"], 1e-5)
        truth = error["analytic"]
        self.assertTrue(truth["closed_form"])
        self.assertEqual(truth["area"]["measured"], report["meshes"][0]["area"])
        self.assertAlmostEqual(truth["volume"]["exact"], 4 / 3 * math.pi * 70**3, delta=1)
        self.assertLess(truth["smooth_normals"]["rms_degrees"], truth["flat_normals"]["rms_degrees"])
        report, _ = self.report("demo:random?size=9", "--iso", "0", "-o", "a.ply", "--error")
        self.assertIsNone(report["meshes"][0]["error"]["analytic"])

    def test_an_open_mesh_has_no_volume_and_no_genus(self):
        report, _ = self.report("demo:gyroid?size=20", "--iso", "0", "-o", "a.ply")
        (facts,) = report["meshes"]
        mesh = read_ply((self.folder / "a.ply").read_bytes())
        self.assertEqual((facts["closed"], facts["volume"], facts["genus"]), (False, None, None))
        self.assertEqual(facts["open_edges"], mesh.open_edges())
        report, _ = self.report("demo:gyroid?size=20", "--iso", "0", "-o", "a.ply", "--cap")
        self.assertTrue(report["meshes"][0]["closed"])
        self.assertNotIn("caps", [fact["what"] for fact in report["extractions"][0]["work"]])

    def test_report_and_explain_tell_the_same(self):
        arguments = (METABALLS, "--iso", "0.5", "--roi", "-9,-9,-9,9,9,9", "--empty", "skip", "-o", "a.glb")
        report, run = self.report(*arguments, "--explain")
        facts = report["work"] + report["extractions"][0]["work"]
        self.assertGreater(len(facts), 3)
        for fact in facts:
            self.assertIn(f"  {fact['done']}: {fact['text']}", run.err)
        told = [line for line in run.err.splitlines() if line.startswith("  ") and ": " in line]
        self.assertEqual(len(told), len(facts))

    def test_a_resolution_of_its_own(self):
        report, run = self.report(SPHERE, "--iso", "0", "--resolution", "30,40,50", "--explain", "-o", "a.ply")
        self.assertEqual(report["options"]["resolution"], [30, 40, 50])
        self.assertEqual(report["input"]["dims"], [24, 24, 24])
        self.assertEqual([stage["stage"] for stage in report["stages"]][:2], ["read", "resample"])
        fact = self.fact(report["work"], "resolution")
        self.assertEqual((fact["done"], fact["count"]), ("resampled", 30 * 40 * 50))
        self.assertIn(f"  resampled: {fact['text']}\n", run.err)
        self.assertIn("24 x 24 x 24 samples of f32 to 30 x 40 x 50 samples of f32", fact["text"])
        for axis, count in enumerate((30, 40, 50)):
            self.assertAlmostEqual(report["output_from_index"][axis][axis], 2 / (count - 1), delta=1e-12)
        self.assertIsNone(self.report(SPHERE, "--iso", "0", "-o", "a.ply")[0]["options"]["resolution"])
        report = self.report(SPHERE, "--iso", "0", "--voxel-size", "0.05,0.1,0.2", "-o", "a.ply")[0]
        self.assertEqual(report["options"]["voxel_size"], [0.05, 0.1, 0.2])
        self.assertIsNone(report["options"]["resolution"])

    def test_input_facts_of_a_raw_file(self):
        self.write_raw("a.raw", (6, 5, 4), lambda x, y, z: x + y + z)
        report, _ = self.report("a.raw", "--dims", "6,5,4", "--dtype", "f32", "--iso", "3.5", "--spacing", "1,2,3",
                                "--origin", "7,8,9", "-o", "a.glb", "--unit", "mm")
        given = report["input"]
        self.assertEqual((given["path"], given["name"], given["sample_type"]), ("a.raw", "a", "f32"))
        self.assertEqual((given["samples"], given["file_bytes"], given["stored_bytes"]), (120, 480, 480))
        self.assertEqual((given["dims"], given["box"]), ([6, 5, 4], {"min": [0, 0, 0], "max": [5, 4, 3]}))
        self.assertEqual(given["index_to_world"], [[1, 0, 0, 7], [0, 2, 0, 8], [0, 0, 3, 9]])
        self.assertTrue(480 <= report["bytes"]["read"] < 480 + 4096, report["bytes"])
        # z up became y up, and millimeters meters.
        rows = [[1, 0, 0, 7], [0, 0, 3, 9], [0, -2, 0, -8]]
        for row, expected in zip(report["output_from_index"], rows):
            for value, number in zip(row, expected):
                self.assertAlmostEqual(value, number * 1e-3)
        options = report["options"]
        self.assertEqual((options["unit"], options["scale"], options["up"], options["turned_to_y_up"]),
                         ("mm", 0.001, "z", True))
        self.assertEqual((options["normals"], options["format"], options["method"]), ("smooth", "glb", "mc"))

    def test_several_surfaces_and_a_missing_one(self):
        report, _ = self.report(SPHERE, "--iso", "0", "--iso", "0.2", "--iso", "9", "--empty", "skip", "-o", "a.glb")
        self.assertEqual([e["iso"] for e in report["extractions"]], [0, 0.2, 9])
        self.assertEqual([m["iso"] for m in report["meshes"]], [0, 0.2])
        meshes = read_glb((self.folder / "a.glb").read_bytes())
        self.assertEqual({m["name"]: m["triangles"] for m in report["meshes"]},
                         {name: len(mesh.triangles) for name, mesh in meshes.items()})
        self.assertTrue(any("no surface at iso 9" in note["text"] for note in report["notes"]))
        stages = [(stage["stage"], stage.get("iso")) for stage in report["stages"]]
        self.assertEqual(stages[0], ("read", None))
        for iso in (0, 0.2, 9):
            for stage in ("classify", "count", "emit"):
                self.assertIn((stage, iso), stages)
        self.assertLessEqual(sum(stage["wall_seconds"] for stage in report["stages"]), report["total"]["wall_seconds"])

    def test_a_skipped_surface_is_reported_with_no_mesh(self):
        report, _ = self.report(SPHERE, "--iso", "9", "--empty", "skip", "-o", "a.glb")
        self.assertEqual((report["meshes"], report["files"]), ([], []))
        self.assertEqual(report["extractions"][0]["triangles"], 0)
        self.assertEqual(self.files(), ["report.json"])

    def test_an_empty_mesh_has_no_bounds(self):
        report, _ = self.report(SPHERE, "--iso", "9", "--empty", "write", "-o", "a.ply")
        self.assertEqual((report["meshes"][0]["vertices"], report["meshes"][0]["bounds"]), (0, None))

    def test_nan_samples_are_counted(self):
        nan = float("nan")
        self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: nan if (x, y, z) in ((1, 1, 1), (2, 2, 2)) else x)
        report, _ = self.report("a.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5", "--nan", "outside")
        fact = self.fact(report["extractions"][0]["work"], "nan_samples")
        self.assertEqual((fact["done"], fact["count"]), ("taken as outside", 2))
        self.assertEqual(report["options"]["nan"], "outside")
        report, run = self.report("a.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5", "--nan", "hole",
                                  "--explain")
        work = report["extractions"][0]["work"]
        self.assertEqual((self.fact(work, "nan_samples")["done"], self.fact(work, "nan_samples")["count"]),
                         ("left as holes", 2))
        # Two blocks of eight cells that share one; all have a corner at x > 1 but the four at x = 0.
        self.assertEqual(self.fact(work, "hole_cells")["count"], 8 + 8 - 1 - 4)
        self.assertIn("11 cells", run.err)

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    def test_the_report_of_a_field_has_no_device(self):
        report, _ = self.report("demo:sphere?size=16", "-o", "x.vdb")
        self.assertIsNone(report["device"])
        (self.folder / "p.csv").write_text("x,y,z\n0,0,0\n1,0,0\n")
        particles, _ = self.report("p.csv", "--radius", "0.7", "-o", "p.vdb")
        self.assertIsNone(particles["device"])
        surface, _ = self.report(SPHERE, "--iso", "0")
        valid = jsonschema.Draft202012Validator(SCHEMA).is_valid
        self.assertFalse(valid({**surface, "device": None}))
        self.assertFalse(valid({**report, "device": surface["device"]}))

    def test_other_grids_are_left_out(self):
        run = self.run_program("info", "--json", METABALLS)
        grids = json.loads(run.text)[0]["grids"]
        report, _ = self.report(METABALLS, "--grid", grids[0]["name"], "--iso", "0.5")
        if len(grids) > 1:
            self.assertEqual(self.fact(report["work"], "grids")["count"], len(grids) - 1)
        else:
            self.assertEqual(report["work"], [])
        self.assertTrue(report["input"]["sparse"])
        self.assertEqual(report["input"]["samples"], grids[0]["voxels"])

    def test_to_stdout(self):
        report, run = self.report(SPHERE, "--iso", "0", "-o", "-", "--format", "ply")
        self.assertEqual(report["meshes"][0]["triangles"], len(read_ply(run.out).triangles))
        self.assertEqual(report["files"], [{"path": "-", "bytes": len(run.out)}])

    def test_a_failure_is_reported_with_its_reason(self):
        report, run = self.report("missing.vdb", "--iso", "0", code=2)
        self.assertEqual((report["error"]["kind"], report["error"]["exit_code"]), ("input", 2))
        self.assertIsNone(report["error"]["reason"])
        self.assertIn(report["error"]["message"], run.err)
        self.assertIsNone(report["input"])

        report, run = self.report(SPHERE, "--iso", "9", "-o", "a.glb", code=2)
        self.assertIn("no surface at iso 9", report["error"]["message"])
        self.assertEqual(report["error"]["reason"], "no_surface")
        self.assertIn(report["error"]["hint"], run.err)
        self.assertEqual((report["meshes"], report["files"]), ([], []))
        self.assertEqual([stage["stage"] for stage in report["stages"]],
                         ["read", "classify", "count", "emit", "statistics"])

        (self.folder / "empty.vdb").write_bytes(vdb(grid("nothing")))
        report, _ = self.report("empty.vdb", "--iso", "0.5", code=2)
        self.assertEqual((report["error"]["reason"], report["input"]["samples"]), ("empty_grid", 0))

        report, run = self.report(SPHERE, "--iso", "0", "-o", "nowhere/a.glb", code=4)
        self.assertEqual(report["error"]["kind"], "output")
        self.assertIsNone(report["input"], "the output is checked before anything is read")

    def test_options_that_make_no_conversion_are_reported(self):
        for arguments, message in (
                ((SPHERE, "--iso", "0", "--iso", "0.0"), "--iso 0 occurs twice"),
                (("--iso", "0"), "INPUT is missing"),
                ((SPHERE, "--iso", "0", "-o", "a.abc"), "a.abc: expected a name that ends in"),
                ((SPHERE, "--iso", "0", "-q", "-v"), "--quiet and --verbose"),
                ((SPHERE, "--iso", "0", "--scale", "2", "--unit", "mm"), "--scale and --unit"),
                ((SPHERE, "--iso", "0", "--dtype", "u8", "-o", "a{iso}.ply"), "--dims")):
            report, run = self.report(*arguments, code=1)
            self.assertIn(message, report["error"]["message"])
            self.assertIn(report["error"]["message"], run.err)
            self.assertEqual((report["error"]["kind"], report["error"]["exit_code"]), ("usage", 1))
            self.assertEqual((report["options"], report["device"], report["input"]), (None, None, None))
            self.assertEqual(report["arguments"], [*arguments, "--report", "report.json"])
            (self.folder / "report.json").unlink()

    def test_a_demo_field_that_there_is_none_of(self):
        report, _ = self.report("demo:spere", "--iso", "0", code=1)
        self.assertIn("no demo field 'spere'", report["error"]["message"])
        self.assertEqual(report["options"]["input"], "demo:spere")

    def test_a_device_that_is_not_there_is_reported(self):
        report, _ = self.report(SPHERE, "--iso", "0", "--backend", "gpu", "--device", "99", "-o", "a.ply", code=3)
        self.assertEqual((report["device"]["backend"], report["device"]["name"]), ("gpu", None))

    def test_a_command_line_that_cannot_be_read_is_reported(self):
        """The report of an earlier run would pass for that of this one."""
        for arguments in ((SPHERE, "--iso", "abc"), (SPHERE, "--iso", "0", "--mehtod", "mc"), (SPHERE, "--iso"),
                          (SPHERE, "--iso", "0", "-o=a.ply")):
            for words in (("--report", "r.json"), ("--report=r.json",)):
                (self.folder / "r.json").write_text("of an earlier run")
                self.assert_fails(1, self.run_program(*words, *arguments))
                report = json.loads((self.folder / "r.json").read_text())
                self.assertEqual((report["status"], report["options"]), ("failed", None))
                self.assertEqual(report["arguments"], [*words, *arguments])
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "--report", "stated.json"))
        self.assert_fails(1, self.run_program("--iso", "abc", "a.raw", "--report", "{stem}.json"))
        self.assertEqual(self.files(), ["a.json", "r.json", "stated.json"])
        for words in (("r.json", "--iso", "abc"), (SPHERE, "--iso", "abc", "-o", "./r.json"), ("info", SPHERE, "--bad"),
                      (SPHERE, "--iso", "abc", "-or.json"), (SPHERE, "--bad", "-o=r.json"), ("--bad=./r.json",),
                      (SPHERE, "--iso", "abc", "--html=r.json"), ("--bad", "--", "r.json")):
            (self.folder / "r.json").write_text("precious")
            self.assert_fails(1, self.run_program("--report", "r.json", *words) if words[0] != "info" else
                              self.run_program(*words, "--report", "r.json"))
            self.assertEqual((self.folder / "r.json").read_text(), "precious")

    def test_the_report_of_options_that_make_no_conversion_overwrites_nothing(self):
        for name in ("a.raw", "a.ply", "a.bin", "b.raw", "b0.5.ply", "a.glb"):
            (self.folder / name).write_text("precious")
        (self.folder / "b.nhdr").write_text("NRRD0005\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"
                                            "data file: b.raw\n\n")
        before = {name: (self.folder / name).read_bytes() for name in self.files()}
        twice = ("--iso", "0", "--iso", "0")
        for arguments, report in ((("a.raw", *twice), "a.raw"), (("a.raw", *twice), "./a.raw"),
                                  ((SPHERE, *twice, "-o", "a.ply"), "a.ply"),
                                  ((SPHERE, *twice, "-o", "a.gltf"), "a.bin"),
                                  (("b.nhdr", *twice), "b.raw"), (("a.raw", *twice), "a.glb"),
                                  ((SPHERE, "--iso", "0.5", "--iso", "0.50", "-o", "b{iso}.ply"), "b0.5.ply")):
            run = self.run_program(*arguments, "--report", report)
            self.assert_fails(1, run, "--report")
            self.assertEqual(run.err.count("isoextract: error: "), 2, run.err)
            self.assertEqual({name: (self.folder / name).read_bytes() for name in self.files()}, before)

    def test_a_failing_stdout_is_reported(self):
        with open("/dev/full", "wb") as full:
            run = self.run_program(SPHERE, "--iso", "0", "-o", "-", "--format", "ply", "--report", "r.json", stdout=full)
        self.assertEqual(run.code, 4)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual((report["status"], report["error"]["exit_code"], report["meshes"]), ("failed", 4, []))

    def test_the_report_is_checked_before_the_work(self):
        """The work would fail as soon as it begins, for want of memory."""
        arguments = ("demo:gyroid?size=400", "--iso", "0", "-o", "a.ply", "--memory-limit", "1M")
        self.assert_fails(2, self.run_program(*arguments), "--memory-limit")
        run = self.run_program(*arguments, "--report", "nowhere/r.json")
        self.assert_fails(4, run, "nowhere/r.json")
        self.assertEqual(self.files(), [])

    def test_the_report_overwrites_neither_input_nor_mesh(self):
        self.write_raw("a.raw", (4, 4, 4), lambda x, y, z: x)
        before = (self.folder / "a.raw").read_bytes()
        raw = ("a.raw", "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5")
        self.assert_fails(1, self.run_program(*raw, "--report", "./a.raw"), "this is the input", "--report")
        self.assertEqual((self.folder / "a.raw").read_bytes(), before)
        run = self.run_program(*raw, "-o", "x.gltf", "--report", f"../{self.folder.name}/x.bin")
        self.assert_fails(1, run, "the report and the mesh would share this file", "--report")
        for name in ("", "-"):
            self.assert_fails(1, self.run_program(*raw, "--report", name), "--report", "file")
        self.assertEqual(self.files(), ["a.raw"])

    def test_one_error_says_that_report_and_mesh_have_one_name(self):
        for name, part in (("x", "x: expected a name that ends in .glb"), ("x.ply", "the report and the mesh would share this file")):
            run = self.run_program(SPHERE, "--iso", "0", "-o", name, "--report", name)
            self.assert_fails(1, run, part)
            self.assertEqual(run.err.count("error: "), 1, run.err)
        self.assertEqual(self.files(), [])

    def test_mesh_and_report_are_not_one_stream(self):
        ply = (SPHERE, "--iso", "0", "-o", "-", "--format", "ply", "--report")
        for name in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
            run = self.run_program(*ply, name)
            self.assert_fails(1, run, f"{name}: the report and the mesh on standard output need different files", "--report")
        with open(self.folder / "out.ply", "wb") as out:
            run = self.run_program(*ply, "out.ply", stdout=out)
        self.assert_fails(1, run, "out.ply: the report and the mesh on standard output need different files")
        self.assertEqual((self.folder / "out.ply").stat().st_size, 0)
        os.mkfifo(self.folder / "pipe")
        os.link(self.folder / "pipe", self.folder / "twin")
        run = self.run_program(*ply[:4], "pipe", "--format", "ply", "--report", "twin")
        self.assert_fails(1, run, "twin: the report and the mesh would share this file")
        # The mesh in a file, the report to stdout.
        run = self.convert(SPHERE, "--iso", "0", "-o", "a.ply", "--report", "/dev/stdout")
        self.assertEqual(json.loads(run.text)["status"], "done")

    def test_a_report_of_the_gpu_fits_the_schema(self):
        report, _ = self.report("demo:gyroid?size=24", "--iso", "0", "--backend", "gpu", "--verify", "-o", "a.ply")
        self.assertEqual(self.fact(report["extractions"][0]["work"], "uploads")["done"], "uploaded")

    def test_the_facts_of_a_mesh_take_little_memory(self):
        # On one thread: what several hold at once depends on how busy the machine is.
        gyroid = ("demo:gyroid?size=224", "--iso", "0", "--threads", "1", "-o", "a.gltf")
        # The least of three runs: the peak that the system counts differs by several MiB from run to run.
        reports = [self.report(*gyroid)[0] for _ in range(3)]
        without = self.peak_mib(*gyroid) * 2**20
        [facts] = reports[0]["meshes"]  # glTF is written from the whole mesh, so the mesh is in memory in both runs
        peak = min(report["peak_memory_bytes"] for report in reports)
        self.assertLess(peak, without + 6 * (facts["vertices"] + facts["triangles"]))

    def test_samples_that_stay_in_their_file(self):
        # One plane, so that the mesh and its facts need less than the volume.
        self.write_raw("a.raw", (80, 20, 20), lambda x, y, z: x)
        raw = ("a.raw", "--dims", "80,20,20", "--dtype", "f32", "--iso", "3.5", "-o", "a.ply")
        limit = ("--memory-limit", "60K")
        report, run = self.report(*raw, "--explain", *limit)
        fact = self.fact(report["work"], "samples")
        self.assertEqual((fact["done"], fact["count"], fact["total"]), ("mapped", 32000, 32000))
        self.assertIn(f"  mapped: {fact['text']}\n", run.err)
        mesh = (self.folder / "a.ply").read_bytes()
        # The same volume in the other byte order is read, and compared with the limit.
        values = struct.unpack("<32000f", (self.folder / "a.raw").read_bytes())
        (self.folder / "a.raw").write_bytes(struct.pack(">32000f", *values))
        self.assertEqual(self.report(*raw, "--endian", "big")[0]["work"], [])
        self.assertEqual((self.folder / "a.ply").read_bytes(), mesh)
        run = self.run_program(*raw, "--endian", "big", *limit)
        self.assert_fails(2, run, "125 KiB", "60 KiB", "--memory-limit")

    def test_names_in_any_encoding(self):
        name = os.fsdecode(b"caf\xe9.raw")
        self.write_raw(name, (4, 4, 4), lambda x, y, z: x)
        report, _ = self.report(name, "--dims", "4,4,4", "--dtype", "f32", "--iso", "1.5", "-o", "a.glb", "-q")
        self.assertEqual(report["input"]["path"], "caf\ufffd.raw")

    def test_mesh_bytes_do_not_depend_on_the_report(self):
        self.convert(SPHERE, "--iso", "0", "-o", "a.glb")
        self.report(SPHERE, "--iso", "0", "-o", "b.glb")
        self.assertEqual((self.folder / "a.glb").read_bytes(), (self.folder / "b.glb").read_bytes())

    @needs_data("med/ch2.nii.gz")
    def test_packed_input_counts_as_it_lies_in_the_file(self):
        path = DATA / "med" / "ch2.nii.gz"
        report, _ = self.report(path, "--iso", "60", "-o", "a.ply")
        size = path.stat().st_size
        self.assertEqual(report["input"]["file_bytes"], size)
        self.assertTrue(0.9 * size < report["bytes"]["read"] < 1.1 * size + 8192, (size, report["bytes"]))
        self.assertGreater(report["input"]["stored_bytes"], size)
        self.assertGreater(report["peak_memory_bytes"], report["input"]["stored_bytes"])


if __name__ == "__main__":
    main()
