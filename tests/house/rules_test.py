"""Plants one violation of each rule in a small project and sees that it, and nothing else, is found."""

import pathlib
import shutil
import tempfile
import unittest

import rules

CLEAN = {
    "src/base/CMakeLists.txt": "isoextract_room(base)\n",
    "src/base/error.hpp": "#pragma once\n",
    "src/volume_io/CMakeLists.txt": "isoextract_room(volume_io ROOMS base field LIBRARIES Some::lib)\n",
    "src/volume_io/reader.cpp": (
        '#include "volume_io/reader.hpp"\n#include <vector>\n#include "field/samples.hpp"\n#include "base/error.hpp"\n'
        '// std::cout and exit(1) in a comment\nconst char* s = "printf(\\"argv\\") // no end";\n'
        "int big = 1'000'000; char c = '\"';\n/* abort();\n exit(2); */\nvoid atexit_like(int on_exit);\n"
        'auto r = R"x(std::cerr " )" )x";\n'
    ),
    "src/cli/CMakeLists.txt": "isoextract_room(cli ROOMS base volume_io)\n",
    "src/cli/main.cpp": "#include <cstdio>\nint main(int, char** argv) { std::puts(argv[0]); std::exit(0); }\n",
}
CLEAN["src/README.md"] = "## The rooms\n### base: x\n`error.hpp`\n### volume_io: x\n### cli: x\n## The ways\n`no.hpp`\n"
SLASH = "/"


class RulesTest(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-house-"))
        self.addCleanup(shutil.rmtree, self.root)
        for name, text in CLEAN.items():
            self.plant(name, text)

    def plant(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def plant_in_room(self, room, text):
        """A file of a room that the map knows."""
        self.plant(f"src/{room}/planted.cpp", text)
        self.plant("src/README.md", CLEAN["src/README.md"] + f"### {room}: x\n")

    def findings(self):
        return [finding for check in rules.CHECKS for finding in check(self.root)]

    def expect_one(self, *parts):
        findings = self.findings()
        self.assertEqual(len(findings), 1, findings)
        for part in parts:
            self.assertIn(part, findings[0])

    def test_a_clean_project_has_no_findings(self):
        self.assertEqual(self.findings(), [])

    def test_include_across_rooms(self):
        self.plant_in_room("base", '#include <string>\n#include "field/samples.hpp"\n')
        self.expect_one("src/base/planted.cpp:2", "base may not include field")

    def test_include_in_angle_brackets_and_with_spaces(self):
        self.plant_in_room("volume_io", "  #  include <extract/extractor.hpp>\n")
        self.expect_one("src/volume_io/planted.cpp:1", "volume_io may not include extract")

    def test_include_of_what_is_another_rooms_own(self):
        self.plant_in_room("volume_io", '#include "field/detail/tables.hpp"\n#include "volume_io/detail/mine.hpp"\n')
        self.expect_one("src/volume_io/planted.cpp:1", "for field alone")

    def test_namespace_of_another_room(self):
        self.plant_in_room("volume_io", "namespace isoextract::volume_io {\n}\nnamespace isoextract::field {\n}\n")
        self.expect_one("src/volume_io/planted.cpp:3", "expected isoextract::volume_io")

    def test_include_by_relative_path(self):
        self.plant_in_room("base", '#include "../field/samples.hpp"\n')
        self.expect_one("src/base/planted.cpp:1", "room/header.hpp")

    def test_include_without_room(self):
        self.plant_in_room("volume_io", '#include "reader.hpp"\n')
        self.expect_one("src/volume_io/planted.cpp:1", "room/header.hpp")

    def test_room_outside_the_table(self):
        self.plant_in_room("util", "int x;\n")
        self.expect_one("src/util/planted.cpp", "'util'")

    def test_link_line_beyond_the_table(self):
        self.plant("src/volume_io/CMakeLists.txt", "isoextract_room(volume_io ROOMS base extract LIBRARIES x)\n")
        self.expect_one("volume_io may not link extract")

    def test_link_beside_the_room_declaration(self):
        text = CLEAN["src/base/CMakeLists.txt"] + "target_link_libraries(isoextract_base PRIVATE isoextract_mesh)\n"
        self.plant("src/base/CMakeLists.txt", text)
        self.expect_one("base may not link mesh")

    def test_graphics_headers(self):
        self.plant_in_room("volume_io", "#include <epoxy/gl.h>\n")
        self.expect_one("src/volume_io/planted.cpp:1", "gl, gpu and render")

    def test_what_only_cli_may_do(self):
        for code in (
            "exit(1);", "std::exit (1);", "_exit(1);", "std::abort();", "f(argv);", "std::cout << 1;",
            'std::fprintf(stderr, "x");', 'printf("x");', 'fmt::print("x");', "#include <spdlog/spdlog.h>",
            "write(STDOUT_FILENO, p, n);", "::write(1, p, n);", "std::wcout << 1;", 'vprintf("x", a);', 'dprintf(2, "x");',
            "std::putchar(c);", 'fmt::println("x");', 'std::print("x");', 'fmt::vprint("x", a);', 'fputs("x", stdout);',
        ):  # fmt: skip
            for room in ("volume_io", "convert"):
                with self.subTest(code=code, room=room):
                    self.plant_in_room(room, f"int x;\n{code}\n")
                    findings = self.findings()
                    found = findings and all(f"src/{room}/planted.cpp:2" in finding for finding in findings)
                    self.assertTrue(found, findings)
                    (self.root / f"src/{room}/planted.cpp").unlink()

    def test_what_looks_like_printing_and_is_not(self):
        self.plant_in_room("volume_io", "file.write(1024, p);\nwrite(file, p);\nint fingerprint(int n);\nsnprintf(p, n, f);\n")
        self.assertEqual(self.findings(), [])

    def test_contexts_that_no_caller_passes(self):
        for default in ("Context()", "{}"):
            with self.subTest(default=default):
                self.plant_in_room("volume_io", f"int x;\nvoid read(const Context& context = {default});\n")
                self.expect_one("src/volume_io/planted.cpp:2", "let the caller pass it")
        self.plant_in_room("volume_io", "const Context& context = file.context();\n")
        self.assertEqual(self.findings(), [])

    def test_reservations_that_no_variable_holds(self):
        for code in ("f();\n  TRY(context_.reserve(1, what));", "f();\nif (a) TRY(set->memory().reserve(1));"):
            with self.subTest(code=code):
                self.plant_in_room("volume_io", code)
                self.expect_one("src/volume_io/planted.cpp:2", "hold what reserve() returns")
        self.plant_in_room("volume_io", "const auto memory =\n    TRY(context.reserve(1, what));\n")
        self.assertEqual(self.findings(), [])

    def test_names_of_options_below_cli(self):
        for text in ('"use --iso V"', '"--iso"', "f(\"(--nan outside)\")", 'R"(a\n--cap)"'):
            with self.subTest(text=text):
                self.plant_in_room("volume_io", f"int x;\nauto s = {text};\n".replace("\\n", "\n"))
                self.expect_one("src/volume_io/planted.cpp:", "names an option")

    def test_options_named_a_second_time(self):
        main = CLEAN["src/cli/main.cpp"]
        for code in ('bool b = given("--iso");', 'Pair p{flags.cap, "--cap"};', 'auto s = is_long ? "-o,--output" : "";'):
            with self.subTest(code=code):
                self.plant("src/cli/main.cpp", main + code + "\n")
                self.expect_one("src/cli/main.cpp:", "an option is named a second time")
        for code in ('Value<int> n{*this, "--threads", "N"};', 'Flag cap{in(Group::surface), "--cap"};',
                     'struct Nan : Value<int> { Nan(Place place) : Value(place, "--nan") {} };', 'auto s = "give --iso V";'):
            with self.subTest(code=code):
                self.plant("src/cli/main.cpp", main + code + "\n")
                self.assertEqual(self.findings(), [])

    def test_cli11_outside_the_parser(self):
        self.plant("src/cli/parser.cpp", "#include <CLI/CLI.hpp>\n")
        self.assertEqual(self.findings(), [])
        self.plant("src/cli/main.cpp", "#include <CLI/App.hpp>\n")
        self.expect_one("src/cli/main.cpp:1", "options are declared as")

    def test_names_that_hide_those_of_base(self):
        self.plant("src/base/error.hpp", "namespace isoextract {\n[[nodiscard]] constexpr int value_of(int x) {\n  return x;\n}\n}\n")
        self.plant_in_room("volume_io", "namespace {\nint other(int x) { return value_of(x); }\n}\nint value_of(int);\n")
        self.assertEqual(self.findings(), [])
        self.plant_in_room("volume_io", "int x;\nnamespace {\nint f() { return 1; }\n\nint value_of(int x) { return x; }\n}\n")
        self.expect_one("src/volume_io/planted.cpp:5", "value_of hides what base declares")

    def test_loops_of_tbb_elsewhere(self):
        self.plant("src/base/parallel.cpp", "void f() { tbb::parallel_for(r, body); }\n")
        self.assertEqual(self.findings(), [])
        self.plant_in_room("volume_io", "int x;\nauto s = tbb::parallel_deterministic_reduce(r, body);\n")
        self.expect_one("src/volume_io/planted.cpp:2", "base/parallel.hpp")

    def test_commands_known_by_name(self):
        self.plant("src/cli/merge_command.cpp", 'auto m = CommandOf({"merge", "FOLDER"});\nauto hint = "merge";\n')
        self.plant("src/cli/plan.cpp", 'auto hint = "merge";\n')
        walk = '#include "cli/command.hpp"\n// "merge"\nbool b = name() == '
        self.plant("src/cli/main.cpp", walk + '"a merge";\n')
        self.assertEqual(self.findings(), [])
        self.plant("src/cli/main.cpp", walk + '"merge";\n')
        self.expect_one("src/cli/main.cpp:3", "known by its name")

    def test_what_looks_like_an_option_and_is_none(self):
        code = '// the words of --iso are in cli\nint i = n--a; auto s = "a--b -- c -d ----";\n/* "--iso" */\n'
        self.plant_in_room("volume_io", code)
        self.plant("src/cli/main.cpp", CLEAN["src/cli/main.cpp"] + 'auto hint = "use --iso V";\n')
        self.assertEqual(self.findings(), [])

    def test_map_of_the_rooms(self):
        page = CLEAN["src/README.md"]
        self.plant("src/README.md", page.replace("### volume_io: x\n", ""))
        self.expect_one("no heading for volume_io")
        self.plant("src/README.md", page + "### points: x\n")
        self.expect_one("names the room points")
        self.plant("src/README.md", page.replace("### cli: x\n", "### cli: x\n`plan.hpp`\n"))
        self.expect_one("names cli/plan.hpp")

    def test_headers_that_no_other_room_uses(self):
        self.plant("src/volume_io/open.hpp", '#include "volume_io/part.hpp"\n')
        self.plant("src/volume_io/part.hpp", "int x;\n")
        self.plant("src/cli/main.cpp", '#include "volume_io/open.hpp"\n')
        self.assertEqual(self.findings(), [])
        self.plant("src/cli/main.cpp", "")
        self.plant("src/volume_io/reader.cpp", '#include "volume_io/open.hpp"\n#include "base/error.hpp"\n')
        findings = self.findings()
        self.assertEqual(len(findings), 2, findings)
        self.assertIn("src/volume_io/open.hpp", findings[0])
        self.assertIn("src/volume_io/part.hpp", findings[1])
        (self.root / "src/volume_io/detail").mkdir()
        for name in ("open", "part"):
            (self.root / f"src/volume_io/{name}.hpp").rename(self.root / f"src/volume_io/detail/{name}.hpp")
        self.assertEqual(self.findings(), [])

    def test_length(self):
        self.plant("tests/long_test.cpp", "int x;\n" * rules.LINE_LIMIT)
        self.assertEqual(self.findings(), [])
        self.plant("tests/long_test.cpp", "int x;\n" * (rules.LINE_LIMIT + 1))
        self.expect_one("tests/long_test.cpp", str(rules.LINE_LIMIT + 1))

    def test_machine_paths(self):
        self.plant("docs/notes.md", f"see\n{SLASH}home{SLASH}me/x\n")
        self.expect_one("docs/notes.md:2", "absolute path")

    def test_remedies(self):
        error = ("// one_in_a_comment\nenum class Remedy {\n  none,\n  one,  // text\n  two\n};\n"
                 "enum class Setting {\n  none,\n  four,\n};\n")
        self.plant("src/base/error.hpp", error)
        self.plant_in_room("volume_io", "f(Remedy::one, Setting::four); g(Remedy::two);\n")
        words = "switch (r) {\n  case Remedy::none: break;\n  case Remedy::one: return x;\n  case Remedy::two: return y;\n}\nx = Setting::four;\n"
        self.plant("src/cli/remedies.cpp", words)
        self.assertEqual(self.findings(), [])
        self.plant("src/volume_io/planted.cpp", "f(Remedy::one, Setting::four);  // Remedy::two\n")
        self.expect_one("base/error.hpp", "no hint has Remedy::two")
        self.plant("src/volume_io/planted.cpp", "f(Remedy::one, Setting::four); g(Remedy::two);\n")
        self.plant("src/cli/remedies.cpp", words.replace("Remedy::one", "Remedy::One"))
        self.expect_one("cli/remedies.cpp", "no words for Remedy::one")

    def test_stages_compared_as_strings(self):
        for code in ('if (word_of(report.stage) == "smooth") f();', 'if (stage != "smooth") f();', 'x = "a" == r->stage_;',
                     "x = word == word_of(StageName::smooth);", "x = word_of(Key::iso) != word;"):
            with self.subTest(code=code):
                self.plant_in_room("volume_io", f"int x;\n{code}\n")
                self.expect_one("src/volume_io/planted.cpp:2", "as a string")
        self.plant_in_room("volume_io", 'x = a.stage == Stage::b; f(word_of(stage)); // stage == "a"\ng("stage == 1");\n')
        self.assertEqual(self.findings(), [])

    def test_a_table_without_cycles(self):
        for room in rules.MAY_INCLUDE:
            neighbors = [rules.reach(other) for other in rules.MAY_INCLUDE[room]]
            self.assertFalse(any(room in reached for reached in neighbors), room)


if __name__ == "__main__":
    unittest.main()
