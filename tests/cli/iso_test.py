"""--iso by words: what `info` suggests, and percentiles of the samples."""

import csv
import json
import math

from support import ProgramTest, main, read_glb, read_ply

DIMS = ("--dims", "6,5,4", "--dtype", "f32")


def two_heaps(x, y, z):
    """0 to 59, and 60 more far above."""
    n = x + 6 * (y + 5 * z)
    return float(n if n < 60 else 1000 + n)


def percentile(values, percent):
    return sorted(values)[max(math.ceil(len(values) * percent / 100), 1) - 1]


HEAPS = [two_heaps(x, y, z) for z in range(4) for y in range(5) for x in range(6)]


class IsoTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_raw("a.raw", (6, 5, 4), two_heaps)

    def suggestion(self, name="a.raw"):
        run = self.convert("info", "--json", name, *DIMS)
        told = json.loads(run.text)[0]["field"]["suggestion"]
        return dict(told, text=repr(told["iso"]).removesuffix(".0"))

    def report(self, *arguments):
        run = self.convert(*arguments, "--report", "r.json")
        return json.loads((self.folder / "r.json").read_text()), run

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def test_auto_is_what_info_suggests(self):
        told = self.suggestion()
        report, run = self.report("a.raw", *DIMS, "--iso", "auto", "-o", "a.ply")
        self.assertIn(f"note[iso-chosen]: a.raw: iso auto is {told['text']}: {told['method']}", run.err)
        self.assertEqual(report["iso_values"], [{"asked": "auto", "iso": told["iso"], "found_by": told["method"]}])
        self.assertEqual(report["options"]["iso"], ["auto"])
        self.assertEqual(report["options"]["outputs"][0]["iso"], ["auto"])
        self.assertEqual((report["extractions"][0]["iso"], report["extractions"][0]["asked"]), (told["iso"], "auto"))
        self.assertIn("statistics", [stage["stage"] for stage in report["stages"]])
        self.convert("a.raw", *DIMS, "--iso", told["iso"], "-o", "b.ply")
        self.assertEqual(self.bytes_of("a.ply"), self.bytes_of("b.ply"))

    def test_numbers_are_as_ever(self):
        report, run = self.report("a.raw", *DIMS, "--iso", "500", "-o", "a.ply")
        self.assertNotIn("iso_values", report)
        self.assertNotIn("asked", report["extractions"][0])
        self.assertEqual(report["options"]["iso"], [500])
        self.assertNotIn("note", run.err)

    def test_percentiles_are_those_of_the_samples(self):
        words = {"p50": 50, "p0.5": 0.5, "p98.9": 98.9, "p60.000": 60}
        isos = [word for name in words for word in ("--iso", name)]
        report, run = self.report("a.raw", *DIMS, *isos, "--iso", "17.5", "-o", "a.glb", "--explain")
        for found, percent in zip(report["iso_values"], words.values()):
            self.assertEqual(found["iso"], percentile(HEAPS, percent), found)
        self.assertEqual(report["iso_values"][4], {"asked": 17.5, "iso": 17.5, "found_by": None})
        self.assertIn("iso p50 is 59: percentile 50 of the samples", run.err)
        self.assertIn("iso values found in 0.", run.err)
        # Surfaces have names that are the same in every frame.
        names = sorted(read_glb(self.bytes_of("a.glb")))
        self.assertEqual([name.split(" iso ")[1] for name in names], ["17.5", "p0.5", "p50", "p60", "p98.9"])

    def test_names_of_files_have_the_word(self):
        self.convert("a.raw", *DIMS, "--iso", "p50", "--iso", "auto", "--iso", "59", "-o", "{iso}.ply")
        self.assertEqual(self.files(), ["59.ply", "a.raw", "auto.ply", "p50.ply"])
        self.assertEqual(self.bytes_of("59.ply"), self.bytes_of("p50.ply"))

    def test_one_surface_where_two_come_to_the_same(self):
        report, run = self.report("a.raw", *DIMS, "--iso", "59", "--iso", "p50", "-o", "a.glb")
        self.assertIn("iso 59 and p50 are the same value, 59: a.glb has one surface for both", run.err)
        self.assertEqual([e["iso"] for e in report["extractions"]], [59])
        self.assertEqual(len(read_glb(self.bytes_of("a.glb"))), 1)
        self.assert_fails(1, self.run_program("a.raw", *DIMS, "--iso", "p50", "--iso", "p50.0", "-o", "b.glb"),
                          "--iso p50 occurs twice")

    def test_the_whole_input_counts(self):
        _, whole = self.report("a.raw", *DIMS, "--iso", "p40", "-o", "a.ply")
        self.assertIn("iso p40 is 47", whole.err)
        for more in (("--roi", "0,0,0,5,4,1"), ("--resolution", "9")):
            self.assertIn("iso p40 is 47", self.convert("a.raw", *DIMS, "--iso", "p40", *more, "-o", "b.ply").err)

    def test_nothing_is_guessed(self):
        self.write_raw("flat.raw", (6, 5, 4), lambda x, y, z: 3.0)
        run = self.run_program("flat.raw", *DIMS, "--iso", "auto", "-o", "b.ply", "--report", "r.json")
        self.assert_fails(2, run, "flat.raw: expected two groups of sample values, to choose an iso value between them; found 3 "
                          "everywhere", "no iso value separates these samples into two groups")
        self.assertEqual(json.loads(self.bytes_of("r.json"))["error"]["reason"], "no_surface")
        self.convert("flat.raw", *DIMS, "--iso", "auto", "--empty", "skip", "-o", "b.ply")
        self.assertNotIn("b.ply", self.files())
        self.assert_fails(2, self.run_program("a.raw", *DIMS, "--iso", "p100", "-o", "b.ply"),
                          "no surface at iso p100 (1119)", "range from 0 to 1119")
        self.write_raw("nan.raw", (6, 5, 4), lambda x, y, z: math.nan)
        for word in ("auto", "p50"):
            self.assert_fails(2, self.run_program("nan.raw", *DIMS, "--iso", word, "--nan", "outside", "-o", "b.ply"),
                              "no sample is a finite number")

    def test_level_sets_have_their_zero(self):
        self.write_raw("ls.raw", (6, 5, 4), lambda x, y, z: x - 2.5)
        run = self.convert("ls.raw", *DIMS, "--inside", "below", "--iso", "auto", "-o", "b.ply")
        self.assertIn("iso auto is 0: the zero of the level set", run.err)
        # A field that does not cross zero has no surface; the message names its values.
        self.assert_fails(2, self.run_program("a.raw", *DIMS, "--inside", "below", "--iso", "auto", "-o", "b.ply"),
                          "no surface at iso auto (0)", "range from 0 to 1119")

    def test_a_level_set_needs_no_iso_value(self):
        self.write_raw("ls.raw", (6, 5, 4), lambda x, y, z: x - 2.25)
        level_set = ("ls.raw", *DIMS, "--inside", "below")
        run = self.convert(*level_set, "-o", "a.ply")
        self.assertIn("note[iso-chosen]: ls.raw: iso 0: the surface of the level set\n", run.err)
        self.assertEqual(read_ply(self.bytes_of("a.ply")).bounds(), ([2.25, 0, 0], [2.25, 4, 3]))
        self.convert(*level_set, "--iso", "0", "-o", "b.ply")
        self.assertEqual(self.bytes_of("a.ply"), self.bytes_of("b.ply"))
        self.convert("verify", *level_set, "a.ply")
        # Of the frames of a sequence each; one that is a density is refused.
        for frame in (1, 2):
            self.write_raw(f"f{frame}.raw", (6, 5, 4), lambda x, y, z: x - 2.25)
        run = self.convert("f{}.raw", *DIMS, "--inside", "below", "-o", "out_{}.ply")
        self.assertEqual(self.bytes_of("out_1.ply"), self.bytes_of("a.ply"))
        self.assertNotIn("jump", run.err)
        self.assert_fails(1, self.run_program("ls.raw", *DIMS, "-o", "c.ply"), "ls.raw: expected an iso value, found none",
                          "a density has no default iso value", "try --iso auto", "isoextract info")
        self.assertNotIn("c.ply", self.files())

    def test_zero_is_for_level_sets(self):
        self.write_raw("ls.raw", (6, 5, 4), lambda x, y, z: x - 2.25)
        run = self.convert("ls.raw", *DIMS, "--inside", "below", "--iso", "zero", "-o", "a.ply")
        self.assertIn("note[iso-chosen]: ls.raw: iso zero is 0: the surface of the level set\n", run.err)
        self.assert_fails(1, self.run_program("ls.raw", *DIMS, "--iso", "zero", "-o", "b.ply"),
                          "ls.raw: the iso value 'zero' is for level sets: expected a level set, found a density",
                          "try --iso auto")
        (self.folder / "p.csv").write_text("x,y,z\n0,0,0\n1,0,0\n0,1,0\n")
        self.assert_fails(1, self.run_program("p.csv", "--particles", "sph", "--radius", "1", "--iso", "zero", "-o", "b.ply"),
                          "p.csv: the iso value 'zero' is for level sets: expected a level set, found a density (SPH interpolation)")
        self.assertEqual(self.files(), ["a.ply", "a.raw", "ls.raw", "p.csv"])

    def test_words_that_are_none(self):
        for word in ("Auto", "p", "p101", "p-1", "p1e1", "50%", "p0.0000001", "median", "nan", ""):
            self.assert_fails(1, self.run_program("a.raw", *DIMS, "--iso", word, "-o", "b.ply"),
                              "--iso: expected a finite number, auto, zero or a percentile from p0 to p100")

    def test_verify_takes_the_same_words(self):
        isos = ("--iso", "auto", "--iso", "p70", "--iso", "p69.9")  # the last two are the same sample
        self.convert("a.raw", *DIMS, *isos, "-o", "a.glb")
        run = self.convert("verify", "a.raw", *DIMS, *isos, "a.glb")
        self.assertIn(f"iso auto ({self.suggestion()['text']}), p70 (1083)\n", run.text)
        self.assertIn("iso p70 is 1083: percentile 70 of the samples", run.err)
        run = self.run_program("verify", "a.raw", *DIMS, "--iso", "p71", "--iso", "auto", "a.glb")
        self.assertEqual(run.code, 6)

    def test_each_frame_has_its_own(self):
        for k in range(3):
            self.write_raw(f"in_{k}.raw", (6, 5, 4), lambda x, y, z, k=k: two_heaps(x, y, z) + 7 * k)
        arguments = ("in_{}.raw", *DIMS, "--iso", "p30", "--iso", "40", "-o", "f_{}_{iso}.ply")
        run = self.convert(*arguments, "--table", "t.csv", "-v")
        self.assertEqual(run.err.count("each frame gets its own iso value"), 1)
        self.assertIn("frame 2: in_2.raw: iso p30 is 49", run.err)
        rows = list(csv.DictReader((self.folder / "t.csv").read_text().splitlines()))
        self.assertEqual([(row["iso"], row["asked"]) for row in rows],
                         [("35", "p30"), ("40", ""), ("42", "p30"), ("40", ""), ("49", "p30"), ("40", "")])
        self.assertEqual([name for name in self.files() if name.startswith("f_1")], ["f_1_40.ply", "f_1_p30.ply"])
        # The choice is what a later run goes by.
        self.convert(*arguments, "--resume", "--table", "t.json")
        frames = json.loads(self.bytes_of("t.json"))
        self.assertEqual([frame["status"] for frame in frames], ["kept"] * 3)
        self.assertEqual([s["asked"] for s in frames[0]["surfaces"]], ["p30", None])
        dry = self.convert(*arguments, "--dry-run")
        self.assertIn("f_2_p30.ply", dry.text)
        self.assertRegex(dry.text, r"memory: about \d+ MiB")

    def test_a_table_of_frames_takes_them_too(self):
        for k in range(2):
            self.write_raw(f"in_{k}.raw", (6, 5, 4), two_heaps)
        (self.folder / "iso.csv").write_text("frame,iso\n0,p50\n1,auto\n1,7\n")
        run = self.convert("in_{}.raw", *DIMS, "--iso-table", "iso.csv", "-o", "{frame}.glb", "--table", "t.csv")
        self.assertNotIn("its own iso value", run.err)
        rows = list(csv.DictReader((self.folder / "t.csv").read_text().splitlines()))
        self.assertEqual([(row["frame"], row["asked"]) for row in rows], [("0", "p50"), ("1", "auto"), ("1", "")])

    def test_particles_have_that_of_their_method(self):
        rows = "".join(f"{x},{y},{z}\n" for x in range(4) for y in range(4) for z in range(4))
        (self.folder / "p.csv").write_text("x,y,z\n" + rows)
        report, run = self.report("p.csv", "--iso", "auto", "-o", "a.ply")
        self.assertIn("p.csv: iso auto is 0.6: the default of SPH interpolation", run.err)
        self.assertEqual(report["iso_values"][0]["iso"], 0.6)
        self.convert("p.csv", "--iso", "0.6", "-o", "b.ply")
        self.assertEqual(self.bytes_of("a.ply"), self.bytes_of("b.ply"))
        self.assertEqual(read_ply(self.bytes_of("a.ply")).open_edges(), 0)
        run = self.convert("p.csv", "--particles", "weight", "--iso", "auto", "-o", "a.ply")
        self.assertIn("iso auto is 0.15", run.err)
        self.assert_fails(1, self.run_program("p.csv", "--iso", "p99", "-o", "c.ply"),
                          "p.csv: expected a number or 'auto' as the iso value of particles, found 'p99'",
                          "the default iso value of SPH interpolation is 0.6")
        self.convert("verify", "p.csv", "--particles", "weight", "--iso", "auto", "a.ply")


if __name__ == "__main__":
    main()
