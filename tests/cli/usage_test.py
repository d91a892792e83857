"""What is refused before anything is opened: exit code 1, a message that names the option, a hint that helps."""

import json

from support import SPHERE, ProgramTest, main


class UsageTest(ProgramTest):
    def refused(self, *arguments):
        """The run of a command line that must be refused and must leave nothing behind."""
        run = self.run_program(*arguments)
        self.assert_fails(1, run)
        self.assertEqual(self.files(), [])
        return run.err

    def test_no_argument_shows_a_short_usage(self):
        run = self.run_program()
        self.assertEqual(run.code, 1)
        self.assertEqual(run.out, b"")
        self.assertIn("usage: isoextract [convert] INPUT... --iso V", run.err)
        self.assertLessEqual(run.err.count("\n"), 15)

    def test_unknown_options_have_a_suggestion(self):
        for given, meant in (("--mehtod", "--method"), ("--norm", "--normals"), ("--thread=2", "--threads"),
                             ("--isos", "--iso"), ("--verison", "--version"), ("--outputs", "--output")):
            err = self.refused(SPHERE, "--iso", "0", given)
            self.assertIn(f"unknown option '{given.split('=')[0]}'", err)
            self.assertIn(f"did you mean '{meant}'?", err)

    def test_options_of_other_programs_have_a_suggestion(self):
        for given, meant in (("--decimate=0.5", "--simplify"), ("--threshold", "--iso V"), ("--isovalue=3", "--iso V"),
                             ("--crop", "--roi"), ("--watertight", "--cap")):
            err = self.refused(SPHERE, "--iso", "0", given)
            self.assertIn(f"unknown option '{given.split('=')[0]}'", err)
            self.assertIn(f"hint: {meant}", err)
        # No other command has what is hinted at.
        self.assertNotIn("--simplify", self.refused("info", SPHERE, "--decimate"))
        self.assertIn("--iso several times", self.refused(SPHERE, "--iso", "0.5,1"))

    def test_an_output_without_its_option(self):
        err = self.refused("a.vdb", "b.glb", "--iso", "0")
        self.assertIn("b.glb: the last input has the name of a mesh file", err)
        self.assertIn("hint: give the output with -o: -o b.glb", err)

    def test_unknown_options_without_a_near_one_point_to_the_help(self):
        for given in ("--frobnicate", "-x"):
            err = self.refused(SPHERE, "--iso", "0", given)
            self.assertIn(f"unknown option '{given}'", err)
            self.assertIn("'isoextract convert --help'", err)

    def test_options_of_another_command_are_unknown(self):
        self.assertIn("unknown option '--cap' for 'info'", self.refused("info", SPHERE, "--cap"))

    def test_missing_iso_names_info(self):
        err = self.refused("demo:sphere?size=12")
        self.assertIn("try --iso auto, the value that 'isoextract info' suggests", err)

    def test_missing_input(self):
        self.assertIn("INPUT is missing", self.refused("--iso", "0"))
        self.assertIn("INPUT is missing", self.refused("info"))

    def test_several_inputs_are_frames_and_need_files_of_their_own(self):
        err = self.refused("a.vdb", "b.vdb", "--iso", "0", "-o", "c.ply")
        for name in ("a.vdb", "b.vdb", "c.ply"):
            self.assertIn(name, err)

    def test_usage_lines_name_operands_as_the_lists_do(self):
        for command, usage in (("check", "MESH"), ("compare", "MESH MESH"), ("verify", "INPUT --iso V [MESH]")):
            text = self.convert(command, "--help").text
            self.assertIn(f"Usage: isoextract {command} {usage} [options]\n", text)
            self.assertRegex(text, r"\n  MESH +[A-Z]")
            self.assertNotRegex(text, r"\n  FILE ")

    def test_misspelt_command(self):
        self.assertIn("did you mean 'isoextract info'?", self.refused("inof", "a.vdb"))

    def test_an_output_without_a_name(self):
        for options in ((), ("--format", "ply"), ("--format", "vdb")):
            self.assert_fails(1, self.run_program(SPHERE, *(("--iso", "0") if "vdb" not in options else ()), *options, "-o", ""),
                              "-o needs the name of a file")

    def test_ascii_of_a_format_that_is_text(self):
        run = self.run_program(SPHERE, "--iso", "0", "--ascii", "-o", "a.obj")
        self.assert_fails(1, run, "--ascii applies to ply and stl only, found obj, which is always text", "hint: leave --ascii out\n")

    def test_an_input_from_stdin_has_no_name_for_its_mesh(self):
        self.assertIn("stdin", self.refused("-", "--iso", "0"))

    def test_numbers(self):
        for option, value in (("--iso", "abc"), ("--iso", ""), ("--iso", "1,2"), ("--iso", "0x10"), ("--iso", "1e999"),
                              ("--scale", "0"), ("--scale", "-1"), ("--threads", "0"), ("--threads", "-2"),
                              ("--threads", "1.5"), ("--threads", "99999"), ("--dims", "4,4"), ("--dims", "4,0,4"),
                              ("--dims", "4,-4,4"), ("--dims", "4x4x4x4"), ("--dims", "99999999999,1,1"),
                              ("--spacing", "1,2"), ("--spacing", "0"), ("--spacing", "1,-1,1"), ("--origin", "1,2"),
                              ("--origin", "nan,0,0"), ("--skip", "-1"), ("--skip", "x"), ("--memory-limit", "2Q"),
                              ("--roi", "1,2,3"), ("--roi", "0,0,0,1,1,inf")):
            err = self.refused(SPHERE, "--iso", "0", option, value)
            self.assertIn(f"error: {option}: expected ", err)
            self.assertIn(f"'{value}'", err)

    def test_a_memory_size_without_a_unit_is_not_taken_for_bytes(self):
        for value in ("20", "0.5", "2000000"):
            for command in ((SPHERE, "--iso", "0"), ("simulate", "water")):
                err = self.refused(*command, "--memory-limit", value)
                self.assertIn(f"--memory-limit: expected a size with a unit, such as 512M or 2G, found '{value}'", err)
                self.assertIn(f"add a unit: K, M, G or T, or B for bytes, as in {value}B", err)
        self.assertIn("--gpu-memory: expected a size with a unit", self.refused(SPHERE, "--iso", "0", "--gpu-memory", "4"))
        self.assert_fails(2, self.run_program(SPHERE, "--iso", "0", "-o", "a.ply", "--memory-limit", "20B"), "memory")
        self.convert(SPHERE, "--iso", "0", "-o", "a.ply", "--memory-limit", "4294967296")

    def test_iso_must_be_finite(self):
        for value in ("nan", "inf", "-inf"):
            self.assertIn("a finite number", self.refused(SPHERE, "--iso", value))

    def test_words(self):
        for option, value, meant in (("--method", "mz", "mc"), ("--dtype", "u9", "u8"), ("--normals", "smoth", "smooth"),
                                     ("--format", "gbl", "glb"), ("--unit", "mmm", "mm"), ("--endian", "litle", "little")):
            err = self.refused(SPHERE, "--iso", "0", option, value)
            self.assertIn(f"error: {option}: expected one of ", err)
            self.assertIn(f"did you mean '{meant}'?", err)

    def test_roi_corners_in_order(self):
        err = self.refused(SPHERE, "--iso", "0", "--roi", "0,5,0,1,-5,1")
        self.assertIn("--roi", err)
        self.assertIn("Y0 = 5 is above Y1 = -5", err)

    def test_missing_values(self):
        self.assertIn("--iso needs a value", self.refused(SPHERE, "--iso"))
        self.assertIn("-o needs a value", self.refused(SPHERE, "--iso", "0", "-o"))
        self.assertIn("--method needs a value", self.refused(SPHERE, "--iso", "0", "--method="))

    def test_flags_take_no_value(self):
        self.assertIn("--cap takes no value", self.refused(SPHERE, "--iso", "0", "--cap=yes"))

    def test_options_given_twice(self):
        self.assertIn("--method takes one value, found 2", self.refused(SPHERE, "--iso", "0", "--method", "mc", "--method", "mt"))
        self.assertIn("--iso 0.5 occurs twice", self.refused(SPHERE, "--iso", "0.5", "--iso", "5e-1"))

    def test_combinations(self):
        for parts, arguments in (
                (("--scale", "--unit"), ("--scale", "2", "--unit", "mm")),
                (("--space index", "--up"), ("--space", "index", "--up", "y")),
                (("--space index", "--scale"), ("--space", "index", "--scale", "2")),
                (("--space index", "--unit"), ("--space", "index", "--unit", "mm")),
                (("--quiet", "--verbose"), ("-q", "-v")),
                (("--quiet", "--explain"), ("-q", "--explain")),
                (("--dtype", "--dims"), ("--dtype", "u8")),
                (("--endian", "--dims"), ("--endian", "big")),
                (("--skip", "--dims"), ("--skip", "8")),
                (("-o -", "--format"), ("-o", "-")),
                (("stdout", "glb"), ("-o", "-", "--format", "gltf")),
                (("a.abc", ".glb, .gltf, .ply, .obj, .stl, .drc", "--format"), ("-o", "a.abc")),
                (("--ascii", "glb"), ("--ascii",)),
                (("--ascii", "obj"), ("--ascii", "-o", "a.obj")),
                (("--normals smooth", "stl"), ("--normals", "smooth", "-o", "a.stl")),
                (("--normals none", "stl"), ("--normals", "none", "-o", "a.stl")),
                (("ply", "2 iso values", "with {iso} in it"), ("--iso", "0.1", "-o", "a.ply")),
                (("stl", "2 iso values", "with {iso} in it"), ("--iso", "0.1", "--format", "stl"))):
            err = self.refused(SPHERE, "--iso", "0", *arguments)
            for part in parts:
                self.assertIn(part, err)

    def test_demo_fields(self):
        self.assertIn("sphere", self.refused("demo:spere", "--iso", "0"))
        self.assertIn("size", self.refused("demo:sphere?size=1", "--iso", "0"))

    def test_negative_numbers_are_values(self):
        self.convert(SPHERE, "--iso", "-0.5", "--roi", "-1,-1,-1,1,1,1", "--origin", "-1,-1,-1", "-o", "a.ply")
        self.convert(SPHERE, "--iso=-0.5", "--roi=-1,-1,-1,1,1,1", "-o", "a.ply")

    def test_convert_is_the_default_command(self):
        self.convert("convert", SPHERE, "--iso", "0", "-o", "a.ply")
        self.convert(SPHERE, "--iso", "0", "-o", "b.ply")
        self.convert("--iso", "0", "-o", "c.ply", SPHERE)
        data = {(self.folder / name).read_bytes() for name in ("a.ply", "b.ply", "c.ply")}
        self.assertEqual(len(data), 1)

    def test_a_file_named_like_a_command(self):
        for name in ("info", "[x]"):
            self.write_raw(name, (2, 2, 2), lambda x, y, z: x)
            self.convert(f"./{name}", "--dims", "2,2,2", "--dtype", "f32", "--iso", "0.5", "-o", "a.ply")
        run = self.run_program("x.vdb", "--iso", "0", "-o", "a.ply", "info")  # not the command: it is not the first word
        self.assert_fails(1, run, "a.ply", "x.vdb", "info")

    def test_options_come_before_two_dashes(self):
        err = self.refused("--", "-f.vdb", "--iso", "0.5")
        self.assertIn("'--iso' comes after '--', where every word is a file name", err)
        self.assertIn("hint: put options before '--'", err)
        self.assertIn("'--iso=0.5' comes after '--'", self.refused("--", "-f.vdb", "--iso=0.5"))
        self.assertIn("unexpected argument 'c'", self.refused("verify", "--iso", "0", "--", "a", "b", "c"))
        err = self.refused("--iso", "0", "-o", "c.ply", "--", "-a.vdb", "-b.vdb")
        self.assertIn("-a.vdb", err)
        self.assertIn("-b.vdb", err)

    def test_a_file_named_like_an_option_is_told_how_it_is_written(self):
        self.write_raw("-f.raw", (2, 2, 2), lambda x, y, z: x)
        run = self.run_program("-f.raw", "--dims", "2,2,2", "--dtype", "f32", "--iso", "0.5")
        self.assert_fails(1, run, "unknown option '-f.raw'", "./-f.raw")

    def test_short_options_take_no_equals_sign(self):
        for given in ("-o=x.ply", "-qo=x.ply"):
            err = self.refused(SPHERE, "--iso", "0", given)
            self.assertIn(f"error: {given}: -o takes no '='", err)
            self.assertIn("write -o x.ply or --output=x.ply", err)
        self.assertIn("-q takes no value", self.refused(SPHERE, "--iso", "0", "-q=yes"))
        self.convert(SPHERE, "--iso", "0", "-oa=b.ply")
        self.assertEqual(self.files(), ["a=b.ply"])

    def test_words_after_two_dashes_are_inputs(self):
        self.write_raw("--odd", (2, 2, 2), lambda x, y, z: x)
        raw = ("--dims", "2,2,2", "--dtype", "f32", "--iso", "0.5")
        self.convert(*raw, "-o", "a.ply", "--", "--odd")
        self.convert("verify", *raw, "--", "--odd", "a.ply")
        self.write_raw("--cap", (2, 2, 2), lambda x, y, z: x)  # an option's name, and a file's
        self.convert(*raw, "-o", "a.ply", "--", "--cap")
        self.assertEqual(len(json.loads(self.convert("info", "--json", *raw[:4], "--", "--odd", "--cap").text)), 2)


if __name__ == "__main__":
    main()
