"""isoextract info: text and JSON."""

import json
import re
import math
import pathlib
import subprocess
import sys

from support import DATA, INSTALL, PROGRAM, SOURCE, SPHERE, ProgramTest, main, needs_data

from vdb_files import counts, grid, vdb

try:
    import jsonschema
except ImportError:
    sys.exit(f"{sys.executable} has no module jsonschema: {INSTALL}, as python3-jsonschema, for Debian's own python3")

SCHEMA = json.loads((SOURCE / "docs" / "schemas" / "info.schema.json").read_text())

RAMP = ("ramp.raw", "--dims", "4,5,6", "--dtype", "f32")


class InfoTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_raw("ramp.raw", (4, 5, 6), lambda x, y, z: float(x))

    def info(self, *arguments):
        run = self.convert("info", *arguments)
        self.assertEqual(run.err, "")
        return run.text

    def json(self, *arguments):
        document = json.loads(self.info("--json", *arguments))
        jsonschema.Draft202012Validator(SCHEMA).validate(document)
        return document

    def test_the_schema_is_one_and_refuses_what_it_does_not_know(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        (report,) = self.json(*RAMP)
        valid = jsonschema.Draft202012Validator(SCHEMA).is_valid
        for change in ({"new": 1}, {"particles": {}}, {"field": {}}, {"grids": None}, {"error": "none"}):
            self.assertFalse(valid([dict(report, **change)]), change)

    def write_frames(self, numbers):
        for number in numbers:
            self.write_raw(f"s_{number:04}.raw", (4, 5, 6), lambda x, y, z, n=number: float(n * x))

    def test_a_sequence(self):
        self.write_frames((1, 2, 4, 8))
        text = self.info("s_####.raw", *RAMP[1:], "--spacing", "2,3,4")
        for part in ("s_####.raw\n", "4: 1-2,4,8", "3,5-7", "0 to 24 over all frames", "the median of the frames' suggestions",
                     "     4  s_0004.raw  0 to 12  iso", "\ns_0001.raw\n", "Otsu",
                     "isoextract 's_####.raw' --dims 4,5,6 --dtype f32 --spacing 2,3,4 --iso 3 -o 's_{:04}.glb'"):
            self.assertIn(part, text)
        (report,) = self.json("s_####.raw", *RAMP[1:])
        self.assertEqual((report["count"], report["missing"], report["min"], report["max"]), (4, "3,5-7", 0, 24))
        self.assertEqual([(frame["frame"], frame["max"]) for frame in report["frames"]], [(1, 3), (2, 6), (4, 12), (8, 24)])
        suggested = sorted(frame["iso"] for frame in report["frames"])
        self.assertEqual(report["suggestion"]["iso"], suggested[1])
        self.assertEqual(report["suggestion"]["frames"], sum(report["suggestion"]["iso"] < frame["max"] for frame in report["frames"]))
        self.assertEqual(report["first"]["input"], "s_0001.raw")
        (report,) = self.json("s_{}.raw", *RAMP[1:], "--frames", "2-9x2")
        self.assertEqual((report["count"], report["missing"]), (3, "6"))

    def test_the_command_for_a_sequence_converts_it(self):
        self.write_frames((2, 3, 4))
        (self.folder / "folder").mkdir()
        for number in (2, 3):
            header = "{'descr': '<f4', 'fortran_order': True, 'shape': (4, 5, 6), }".ljust(117) + "\n"
            (self.folder / f"folder/n{number}.npy").write_bytes(
                b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header.encode() + (self.folder / f"s_000{number}.raw").read_bytes())
        for words, made in ((("s_$F4.raw", *RAMP[1:]), ["s_0002.glb", "s_0003.glb", "s_0004.glb"]),
                            (("folder/",), ["folder_0002.glb", "folder_0003.glb"])):
            (report,) = self.json(*words)
            command = report["suggestion"]["command"].replace("isoextract", f"'{PROGRAM}'", 1)
            run = subprocess.run(["bash", "-c", command], cwd=self.folder, capture_output=True, check=False, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertTrue(set(made) <= {path.name for path in self.folder.iterdir()}, command)

    def test_a_sequence_of_sparse_grids_has_its_background_around_it(self):
        """Constant fog, and fog without a sample that is as thin as the iso value: both have a surface."""
        for frame, values in ((1, (1, 1)), (2, (1, 1)), (3, (5, 6))):
            voxels = {(x, y, z): float(values[(x + y + z) % 2]) for x in range(4) for y in range(4) for z in range(4)}
            (self.folder / f"fog_{frame}.vdb").write_bytes(vdb(grid(voxels=voxels)))
        (report,) = self.json("fog_{}.vdb")
        self.assertEqual((report["suggestion"]["iso"], report["suggestion"]["frames"]), (0.5, 3))
        self.convert("fog_{}.vdb", "--iso", "0.5", "-o", "m_{}.ply")
        self.assertEqual(sum(name.endswith(".ply") for name in self.files()), 3)

    def test_a_sequence_with_a_frame_that_cannot_be_read(self):
        self.write_frames((1, 2, 3))
        (self.folder / "s_0001.raw").write_bytes(b"short")
        run = self.run_program("info", "s_{:04}.raw", *RAMP[1:])
        self.assertEqual(run.code, 2)
        self.assertIn("s_0001.raw: expected 480 bytes", run.err)
        for part in ("unreadable", "1 of 3 frames", "1  s_0001.raw  unreadable", "\ns_0002.raw\n"):
            self.assertIn(part, run.text)
        run = self.run_program("info", "--json", "s_{:04}.raw", *RAMP[1:])
        (report,) = json.loads(run.text)
        jsonschema.Draft202012Validator(SCHEMA).validate([report])
        self.assertIn("expected 480 bytes", report["frames"][0]["error"]["message"])
        self.assert_fails(2, self.run_program("info", "t_{:04}.raw", *RAMP[1:]), "t_{:04}.raw: no file matches this pattern")

    def test_text(self):
        text = self.info(*RAMP, "--spacing", "2,3,4", "--origin", "10,20,30")
        for part in ("ramp.raw\n", "4 x 5 x 6", "2, 3, 4", "(10, 20, 30) .. (16, 32, 50)", "0 .. 3, mean 1.5", "f32",
                     "480 B", "density", "above", "50 %: ", "##", "Otsu"):
            self.assertIn(part, text)
        self.assertNotIn("not finite", text)
        self.assertLessEqual(max(len(line) for line in text.splitlines()), 110)

    def test_json(self):
        (report,) = self.json(*RAMP, "--spacing", "2,3,4", "--origin", "10,20,30")
        self.assertEqual(report["input"], "ramp.raw")
        field = report["field"]
        self.assertEqual(field["type"], "f32")
        self.assertEqual(field["box"], {"min": [0, 0, 0], "max": [3, 4, 5]})
        self.assertEqual(field["spacing"], [2, 3, 4])
        self.assertEqual(field["index_to_world"], [[2, 0, 0, 10], [0, 3, 0, 20], [0, 0, 4, 30]])
        self.assertEqual(field["world_box"], {"min": [10, 20, 30], "max": [16, 32, 50]})
        values = field["values"]
        self.assertEqual((values["finite"], values["nan"], values["infinite"]), (120, 0, 0))
        self.assertEqual((values["min"], values["max"]), (0, 3))
        self.assertAlmostEqual(values["mean"], 1.5)
        self.assertEqual(sum(values["histogram"]), 120)
        self.assertEqual(list(values["percentiles"]), ["1", "5", "25", "50", "75", "95", "99"])
        self.assertEqual(field["memory"]["samples"], 480)
        self.assertGreater(field["memory"]["conversion"], 480)
        self.assertTrue(0 < field["suggestion"]["iso"] < 3)

    def test_not_finite(self):
        bad = {(0, 0, 0): math.nan, (1, 0, 0): math.inf, (2, 0, 0): -math.inf}
        self.write_raw("bad.raw", (4, 5, 6), lambda x, y, z: bad.get((x, y, z), float(x)))
        text = self.info("bad.raw", *RAMP[1:])
        self.assertIn("1 NaN, 2 infinite", text)
        (report,) = self.json("bad.raw", *RAMP[1:])
        self.assertEqual(report["field"]["values"]["nan"], 1)
        self.assertEqual(report["field"]["values"]["infinite"], 2)

    def test_the_command_of_a_volume_with_nan_works(self):
        self.write_raw("gap_1.raw", (8, 8, 8), lambda x, y, z: math.nan if x == 0 else float(x + y), "f")
        self.write_raw("gap_2.raw", (8, 8, 8), lambda x, y, z: math.nan if x == 0 else float(x + y), "f")
        for words in (("gap_1.raw",), ("gap_{}.raw",), ("gap_1.raw", "--nodata", "9")):
            (report,) = json.loads(self.convert("info", "--json", *words, "--dims", "8,8,8", "--dtype", "f32").text)
            suggestion = report["suggestion"] if "{" in words[0] else report["field"]["suggestion"]
            self.assertEqual("--nan outside" in suggestion["command"], "--nodata" not in words)
            command = suggestion["command"].replace("isoextract", f"'{PROGRAM}'", 1)
            run = subprocess.run(["bash", "-c", command], cwd=self.folder, capture_output=True, check=False, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)

    def test_values_of_labels(self):
        """Each value of integers, where there are few, and how often it occurs."""
        def label(x, y, z):
            return 1004 if x == 7 else 8 if x == y else 0

        counts = [(0, 448 - 56), (8, 56), (1004, 64)]
        for dtype, typecode in (("i16", "h"), ("u16", "H"), ("i32", "i"), ("u32", "I")):
            self.write_raw("map.raw", (8, 8, 8), label, typecode)
            (report,) = self.json("map.raw", "--dims", "8,8,8", "--dtype", dtype)
            values = report["field"]["values"]
            self.assertEqual([(one["value"], one["count"]) for one in values["distinct"]], counts)
            self.assertEqual((values["min"], values["max"], values["percentiles"]["50"]), (0, 1004, 0))
            self.assertEqual(sum(values["histogram"]), 512)
        text = self.info("map.raw", "--dims", "8,8,8", "--dtype", "u32")
        self.assertIn("distinct      3 values, with the number of samples of each\n", text)
        self.assertRegex(text, r"\n +0: 392 +8: 56 +1004: 64\n")
        # Of more values none is listed, nor of numbers that are no integers.
        self.write_raw("map.raw", (8, 8, 8), lambda x, y, z: x + 8 * y + 64 * z, "H")
        self.assertNotIn("distinct", self.json("map.raw", "--dims", "8,8,8", "--dtype", "u16")[0]["field"]["values"])
        self.assertNotIn("distinct", self.json(*RAMP)[0]["field"]["values"])
        self.write_raw("map.raw", (8, 8, 8), lambda x, y, z: x + 8 * y, "H")
        self.assertIn("64 values, with", self.info("map.raw", "--dims", "8,8,8", "--dtype", "u16"))
        self.write_raw("map.raw", (8, 8, 8), lambda x, y, z: x + 8 * y + (64 if z else 0), "H")
        self.assertIn("128 values; --json lists them", self.info("map.raw", "--dims", "8,8,8", "--dtype", "u16"))

    def test_only_nan(self):
        self.write_raw("nan.raw", (4, 5, 6), lambda x, y, z: math.nan)
        text = self.info("nan.raw", *RAMP[1:])
        self.assertIn("120 NaN", text)
        self.assertNotIn("suggestion", text)
        self.json("nan.raw", *RAMP[1:])

    def test_a_constant_volume_has_no_suggestion(self):
        self.write_raw("flat.raw", (4, 5, 6), lambda x, y, z: 3.0)
        text = self.info("flat.raw", *RAMP[1:])
        self.assertIn("suggestion    none: the field is constant and has no surface\n", text)
        self.assertNotIn("--iso", text)
        (report,) = self.json("flat.raw", *RAMP[1:])
        self.assertIsNone(report["field"]["suggestion"])
        self.assertEqual(set(report["field"]["values"]["percentiles"].values()), {3})
        text = self.info("flat.raw", *RAMP[1:], "--inside", "below")
        self.assertIn("suggestion    none: ", text)

    def test_a_level_set_that_does_not_pass_zero_has_no_suggestion(self):
        text = self.info(*RAMP, "--inside", "below", "--origin", "0,0,0")
        self.assertIn("suggestion    none: no surface at 0, the zero of the level set\n", text)

    def test_a_level_set_passes_zero_between_its_far_values(self):
        """The statistics leave out the background and its negative, but the surface is between these."""
        def write(name, voxels):
            meta = {"class": ("string", b"level set"), **counts(voxels)}
            (self.folder / name).write_bytes(vdb(grid(name="sdf", voxels=voxels, background=3.0, meta=meta)))

        inside = {(x, y, z): -3.0 for x in range(4) for y in range(4) for z in range(4)}
        write("set_1.vdb", inside | {(4, 0, 0): 1.0})
        write("set_2.vdb", inside)
        write("outside.vdb", {(4, 0, 0): 1.0})
        for name, finite in (("set_1.vdb", 1), ("set_2.vdb", 0)):
            self.assertIn("suggestion    --iso 0: the zero of the level set\n", self.info(name))
            (report,) = self.json(name)
            self.assertEqual((report["field"]["values"]["finite"], report["field"]["suggestion"]["iso"]), (finite, 0))
            self.convert(name, "-o", "m.ply")
        (report,) = self.json("set_{}.vdb")
        self.assertEqual(report["suggestion"]["frames"], 2)
        (report,) = self.json("outside.vdb")
        self.assertIsNone(report["field"]["suggestion"])
        self.assert_fails(2, self.run_program("set_1.vdb", "--iso", "5", "-o", "n.ply"),
                          "no surface at iso 5", "values range from 1 to 1", "try --iso 0 (the zero of the level set)")
        self.assert_fails(2, self.run_program("set_2.vdb", "--iso", "5", "-o", "n.ply"),
                          "no surface at iso 5", "values range from -3 to 3", "try --iso 0 (the zero of the level set)")
        self.assert_fails(2, self.run_program("set_1.vdb", "--roi", "40,40,40,50,50,50", "-o", "n.ply"), "--roi")

    def test_percentiles_of_integers_are_those_of_the_samples(self):
        for dtype, code, low, high in (("u8", "B", 0, 255), ("i16", "h", -3000, 3000), ("i32", "i", -(2**31), 2**31 - 1),
                                       ("u32", "I", 0, 2**32 - 1)):
            values = [low if n % 10 < 6 else low + (n * n * 7919 + n) % (high - low + 1) for n in range(120)]
            self.write_raw("a.raw", (4, 5, 6), lambda x, y, z, v=values: v[x + 4 * (y + 5 * z)], code)
            (report,) = self.json("a.raw", "--dims", "4,5,6", "--dtype", dtype)
            order = sorted(values)
            for percent, found in report["field"]["values"]["percentiles"].items():
                self.assertEqual(found, order[math.ceil(int(percent) * 120 / 100) - 1], (dtype, percent))

    def test_the_suggested_command_works(self):
        (report,) = self.json(*RAMP, "--spacing", "2,3,4", "--inside", "above")
        command = report["field"]["suggestion"]["command"]
        self.assertIn(command, self.info(*RAMP, "--spacing", "2,3,4", "--inside", "above"))
        self.assertTrue(command.startswith("isoextract ramp.raw --dims 4,5,6 --dtype f32 --spacing 2,3,4 "), command)
        program = pathlib.Path(PROGRAM)
        subprocess.run(["bash", "-c", command], cwd=self.folder, check=True, capture_output=True,
                       env={"PATH": f"{program.parent}:/usr/bin:/bin"})
        self.assertEqual(self.files(), ["ramp.glb", "ramp.raw"])

    def test_the_estimate_of_triangles_is_near(self):
        (report,) = self.json("demo:sphere?size=64")
        iso = report["field"]["suggestion"]["iso"]
        run = self.convert("demo:sphere?size=64", "--iso", iso)
        triangles = int(run.err.split(": ")[1].split()[0])
        self.assertAlmostEqual(report["field"]["suggestion"]["triangles"], triangles, delta=0.25 * triangles)

    def test_particles_as_json(self):
        rows = [f"{x},{y},0,{x * y},w\n" for x in range(4) for y in range(4)]
        (self.folder / "p.csv").write_text("x,y,z,mass,kind\n" + "".join(rows))
        (self.folder / "one.csv").write_text("x,y,z\n1,2,3\nnan,0,0\n")
        (self.folder / "f.xyz").write_text("".join(f"2\nstep {k}\nW {k} 0 0\nW {k + 1 + k} 0 0\n" for k in range(3)))
        run = self.convert("info", "--json", "p.csv", "one.csv", "f.xyz")
        entries = json.loads(run.text)
        jsonschema.Draft202012Validator(SCHEMA).validate(entries)
        plane, one, frames = (entry["particles"] for entry in entries)
        self.assertEqual((plane["count"], plane["frames"], plane["frame"], plane["neighbors"]["median"]), (16, 1, None, 1))
        self.assertEqual([(a["name"], a["numeric"], a["max"]) for a in plane["attributes"]], [("mass", True, 9), ("kind", False, None)])
        self.assertEqual((one["finite"], one["not_finite"], one["neighbors"], one["field"]), (1, 1, None, None))
        self.assertIn("--radius", one["no_field"]["hint"])
        self.assertEqual((frames["frames"], frames["frame"]), (3, 0))
        self.assertAlmostEqual(frames["suggested_radius"], 0.5)
        self.assertNotIn("grids", self.convert("info", "p.csv").text)
        # A frame that is chosen, and from stdin.
        file = (self.folder / "f.xyz").open("rb")
        self.addCleanup(file.close)
        for words, more in ((("f.xyz",), {}), (("-", "--input-format", "xyz"), {"stdin": file})):
            (entry,) = json.loads(self.convert("info", "--json", *words, "--volume", "2", **more).text)
            told = entry["particles"]
            self.assertEqual((entry["volume"], told["frame"], told["suggested_radius"], told["bounds"]["min"]), (2, 2, 1.5, [2, 0, 0]))
        run = self.run_program("info", "f.xyz", "--volume", "3")
        self.assert_fails(2, run, "f.xyz: there is no frame 3", "from 0 to 2")

    def test_several_inputs(self):
        text = self.info(SPHERE, "demo:torus?size=24")
        self.assertIn(SPHERE + "\n", text)
        self.assertIn("\ndemo:torus?size=24\n", text)
        self.assertEqual([entry["input"] for entry in self.json(SPHERE, "demo:torus?size=24")],
                         [SPHERE, "demo:torus?size=24"])

    def test_a_bad_input_among_good_ones(self):
        run = self.run_program("info", SPHERE, "missing.vdb", "demo:torus?size=24")
        self.assertEqual(run.code, 2)
        self.assertIn("missing.vdb", run.err)
        self.assertIn(SPHERE, run.text)
        self.assertIn("demo:torus", run.text)
        run = self.run_program("info", "--json", SPHERE, "missing.vdb")
        self.assertEqual(run.code, 2)
        entries = json.loads(run.text)
        jsonschema.Draft202012Validator(SCHEMA).validate(entries)
        self.assertIn("missing.vdb", entries[1]["error"]["message"])

    def test_same_figures_for_any_number_of_threads(self):
        one, three = (self.info("demo:gyroid?size=64", "--threads", threads) for threads in (1, 3))
        memory = r"takes about [\d.]+ MiB of memory"  # of which each thread has a part
        self.assertRegex(one, memory)
        self.assertEqual(re.sub(memory, "", one), re.sub(memory, "", three))

    @needs_data("vdb/c42_gas_seq/fluid_data_0010.vdb")
    def test_several_grids_are_listed(self):
        path = DATA / "vdb/c42_gas_seq/fluid_data_0010.vdb"
        text = self.info(path)
        for part in ("24", "density", "velocity", "--grid NAME", "51 x 71 x 29"):
            self.assertIn(part, text)
        (report,) = self.json(path)
        self.assertEqual(len(report["grids"]), 24)
        self.assertIsNone(report["field"])
        self.assertIn("percentiles", self.info(path, "--grid", "density"))

    @needs_data("vdb/sphere.vdb")
    def test_level_set(self):
        text = self.info(DATA / "vdb/sphere.vdb")
        for part in ("level set", "below the iso value is inside", "--iso 0: the zero of the level set", "ls_sphere"):
            self.assertIn(part, text)

    @needs_data("med/MR.nii.gz")
    def test_scaled_values(self):
        (report,) = self.json(DATA / "med/MR.nii.gz")
        self.assertAlmostEqual(report["field"]["values"]["max"], 512, delta=0.01)
        # Stored as whole numbers, scaled: nearly half of them are 0.
        percentiles = report["field"]["values"]["percentiles"]
        self.assertEqual([percentiles[percent] for percent in ("1", "5", "25")], [0, 0, 0])
        stored = percentiles["50"] / (512 / 255)
        self.assertAlmostEqual(stored, round(stored), delta=1e-4)
        for got, wanted in zip(report["field"]["spacing"], (1, 0.898, 0.898)):
            self.assertAlmostEqual(got, wanted, delta=0.001)


if __name__ == "__main__":
    main()
