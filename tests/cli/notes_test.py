"""Notes with their ids: what hides them, where they are kept, and what is suggested for a misspelled name."""

import json
import math
import re

from support import SPHERE, ProgramTest, main

CUT = (SPHERE, "--iso", "0", "--clip", "1,0,0,0", "-o", "a.ply", "--report", "r.json")


class NotesTest(ProgramTest):
    def test_note_shows_its_id_and_report_keeps_it(self):
        run = self.convert(*CUT)
        self.assertRegex(run.err, r"isoextract: note\[open-mesh\]: .* the surface is open at the cuts\n")
        notes = json.loads((self.folder / "r.json").read_text())["notes"]
        self.assertEqual([note["id"] for note in notes], ["open-mesh"])
        self.assertIn(notes[0]["text"], run.err)

    def test_no_note_hides_only_notes_of_its_ids(self):
        both = (*CUT, "--up", "y")  # ply has no up axis, so --up has no effect
        self.assertIn("note[no-effect]: ", self.convert(*both).err)
        run = self.convert(*both, "--no-note", "open-mesh")
        self.assertNotIn("note[open-mesh]", run.err)
        self.assertIn("note[no-effect]: ", run.err)
        run = self.convert(*both, "--no-note", "open-mesh,no-effect")
        self.assertNotIn("note[", run.err)
        notes = json.loads((self.folder / "r.json").read_text())["notes"]
        self.assertEqual({note["id"] for note in notes}, {"open-mesh", "no-effect"})

    def test_no_note_in_config_and_batch(self):
        (self.folder / "c.toml").write_text('no-note = "missing-frames"\n')
        for number in (1, 3):
            self.write_raw(f"in_{number}.raw", (6, 6, 6), lambda x, y, z: 2.0 - x)
        raw = ("in_{}.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "0.5", "-o", "out/{}.ply", "--mkdir")
        self.assertIn("note[missing-frames]: ", self.run_program(*raw, "--frames", "1-3", "--missing", "note").err)
        hidden = self.run_program(*raw, "--frames", "1-3", "--missing", "note", "--config", "c.toml")
        self.assertEqual(hidden.code, 0, hidden.err)
        self.assertNotIn("note[", hidden.err)

    def test_unknown_id_is_refused_with_the_nearest(self):
        self.assert_fails(1, self.run_program(*CUT, "--no-note", "open-mehs"), "--no-note", "'open-mehs' (did you mean 'open-mesh'?)")
        self.assert_fails(1, self.run_program(*CUT, "--no-note", "open-mesh,open-mesh"), "each id once")
        self.assertFalse((self.folder / "a.ply").exists())

    def test_help_lists_all_ids(self):
        text = self.run_program("help", "notes").text
        for name in ("open-mesh", "no-effect", "up-axis"):
            self.assertIn(name, text)
        named = set(re.findall(r"--[a-z][a-z-]+", text))
        self.assertGreater(len(named), 20)
        self.assertEqual(named - set(re.findall(r"--[a-z][a-z-]+", self.run_program("generate", "bash").text)), set())

    def test_particle_values_that_are_not_finite_are_counted(self):
        rows = "".join(f"{x},{y},{z},{'nan' if (x, y, z) == (1, 1, 1) else 5}\n"
                       for z in range(3) for y in range(3) for x in range(3))
        (self.folder / "p.csv").write_text("x,y,z,heat\n" + rows)
        run = self.convert("p.csv", "--radius", "0.5", "--attribute", "heat", "-o", "a.ply", "--report", "r.json")
        attribute, = json.loads((self.folder / "r.json").read_text())["attributes"]
        self.assertGreater(attribute["not_finite"], 0)
        self.assertLess(attribute["not_finite"], attribute["vertices"])
        self.assertIn("note[nan-attribute]: ", run.err)

    def test_nan_samples_stay_nan(self):
        """The note counts them; without NaN samples there is none."""
        for name, lost in (("full.raw", ()), ("holes.raw", ((1, 1, 1), (2, 1, 1)))):
            self.write_raw(name, (4, 4, 4), lambda x, y, z, lost=lost: math.nan if (x, y, z) in lost else x)
        read = ("--dims", "4,4,4", "--dtype", "f32", "-o", "out.nrrd")
        for options in (("--nan", "outside"), ("--nodata", "3")):
            run = self.convert("holes.raw", *read, *options)
            self.assertIn(f"note[nan-samples]: holes.raw: {2 if options[0] == '--nan' else 18} of 64 samples stay NaN in the file", run.err)
        self.assertNotIn("nan-samples", self.convert("full.raw", *read, "--nan", "outside").err)
        self.assertNotIn("nan-samples", self.convert("full.raw", *read, "--nodata", "77").err)
        self.assertNotIn("nan-samples", self.convert("holes.raw", *read).err)

    def test_report_goes_into_the_folder_that_the_run_makes(self):
        self.convert(SPHERE, "--iso", "0", "-o", "new/", "--report", "new/r.json")
        self.assertTrue((self.folder / "new/r.json").is_file())

    def test_links_in_a_loop_are_no_internal_error(self):
        (self.folder / "loop").symlink_to("loop")
        self.assert_fails(2, self.run_program("loop", "--iso", "0", "-o", "a.ply"), "loop: cannot read the file")

    def test_example_of_info_repeats_flags_without_value(self):
        run = self.convert("info", "--json", SPHERE, "--in-process")
        self.assertIn("--in-process --iso 0 ", json.loads(run.text)[0]["field"]["suggestion"]["command"] + " ")

    def test_misspelled_names_get_a_suggestion(self):
        run = self.run_program("demo:sphre", "--iso", "0", "-o", "a.glb")
        self.assert_fails(1, run, "'sphre' (did you mean 'sphere'?)")
        self.assert_fails(1, self.run_program("verfy"), "did you mean 'isoextract verify'?")
        (self.folder / "p.csv").write_text("x,y,z,heat\n0,0,0,1\n1,0,0,2\n0,1,0,3\n0,0,1,4\n")
        run = self.run_program("p.csv", "--radius", "1", "--attribute", "haet", "-o", "a.glb")
        self.assert_fails(2, run, "'haet' (did you mean 'heat'?)")
        run = self.run_program("p.csv", "--radius", "1", "--columns", "x=x,y=y,z=zz", "-o", "a.glb")
        self.assert_fails(2, run, "'zz' (did you mean 'z'?)")


if __name__ == "__main__":
    main()
