"""Help, man page and completions: all made from the declarations, so all must know every option."""

import re
import subprocess

from support import SOURCE, ProgramTest, main, needs_program


class DocumentsTest(ProgramTest):
    def text(self, *arguments):
        run = self.run_program(*arguments)
        self.assertEqual((run.code, run.err), (0, ""))
        return run.text

    def commands(self):
        """All of them, those of two words as well, from the one document that is easiest to read."""
        commands = re.findall(r"command_is ([a-z ]+)' -s h -l help", self.text("generate", "fish"))
        self.assertLessEqual({"convert", "info", "simulate", "simulate jet", "generate"}, set(commands))
        return commands

    def options(self, command):
        """The long options of a command, from the same."""
        lines = [line for line in self.text("generate", "fish").splitlines() if f"command_is {command}'" in line]
        return [option for line in lines for option in re.findall(r" -l (\S+)", line)]

    def test_every_option_is_in_every_document(self):
        man = self.text("generate", "man").replace("\\-", "-")
        scripts = [self.text("generate", shell) for shell in ("bash", "zsh")]
        for command in self.commands():
            options = self.options(command)
            self.assertIn("help", options)
            pages = [self.text(*command.split(), detail) for detail in ("--help", "--help-all")]
            for option in options:
                for document in (*pages, man, *scripts):
                    self.assertIn(f"--{option}", document)
        self.assertGreater(len(self.options("convert")), 25)

    def test_topics_cover_the_options_of_convert(self):
        topics = "".join(self.text("help", topic) for topic in ("input", "particles", "frames", "surface", "pieces", "vertices", "placement", "output", "run"))
        for option in self.options("convert"):
            self.assertIn(f"--{option}", topics)

    def test_overview_names_all_commands_and_topics(self):
        overview = self.text("help")
        self.assertEqual(overview, self.text("--help"))
        self.assertEqual(overview, self.text("-h"))
        for name in self.commands():
            if " " not in name:
                self.assertRegex(overview, rf"\n  {name} ")
                self.assertGreater(len(self.text("help", name)), 100)
        topics = re.search(r"Topics: ([a-z \n-]+)", overview).group(1).split()
        self.assertLessEqual({"input", "surface", "demo", "coordinates", "exit-codes", "examples"}, set(topics))
        for name in topics:
            self.assertGreater(len(self.text("help", name)), 100)

    def test_overview_fits_a_screen(self):
        overview = self.text("--help")
        self.assertLessEqual(len(overview.splitlines()), 40)
        self.assertEqual(len(re.findall(r"\n  isoextract .* # ", overview)), 5)
        self.assertEqual(len(re.findall(r"\n  (?:-o, )?--", overview)), 10)

    def test_help_has_a_line_an_option_and_help_all_its_details(self):
        """The first sentence, which is to say on one line what the option is."""
        for command in self.commands():
            lines = self.text(*command.split(), "--help").splitlines()
            for line, after in zip(lines, lines[1:]):
                if re.match(r"  \S", line):
                    has_text = len(line) > 25 and line[24] == " "
                    self.assertNotEqual(has_text, after.startswith(" " * 25), f"{command}: {line}")
        all_texts = self.text("--help-all")
        self.assertEqual(all_texts, self.text("convert", "--help-all"))
        self.assertGreater(len(all_texts.splitlines()), 2 * len(self.text("convert", "--help").splitlines()))

    def test_help_of_a_command(self):
        self.assertEqual(self.text("help", "info"), self.text("info", "--help"))
        self.assertEqual(self.text("help", "convert"), self.text("x.vdb", "--iso", "abc", "-h"))
        self.assertIn("Examples:", self.text("convert", "--help-all"))
        self.assertIn(self.text("help", "examples"), self.text("convert", "--help-all"))

    def test_topics_come_from_the_tables(self):
        formats = self.text("formats")
        for name in ("vdb", "nrrd", "nifti", "npy", "raw", "glb", "gltf", "ply", "obj", "stl"):
            self.assertRegex(formats, rf"\n  {name} ")
        self.assertIn("demo:gyroid", self.text("help", "demo"))

    def test_help_says_where_a_file_has_its_placement(self):
        """As docs/formats.md does, and as compare reads it: binary STL has it in its header."""
        coordinates = " ".join(self.text("help", "coordinates").split())
        self.assertIn("except stl as text, and binary stl if its header of 80 bytes is too short", coordinates)
        self.convert(SOURCE / "samples" / "metaballs.vdb", "--iso", "0.5", "--scale", "2", "-o", "a.stl")
        self.assertIn(b"scale", (self.folder / "a.stl").read_bytes()[:80])

    def test_question_marks_of_examples_are_quoted(self):
        """A shell may take them for patterns, and zsh ends there."""
        man = self.text("generate", "man").replace("\\(aq", "'")
        pages = [(SOURCE / page).read_text() for page in ("README.md", *sorted((SOURCE / "docs").rglob("*.md")))]
        examples = 0
        for text in (man, self.text("help"), self.text("convert", "--help-all"), *pages):
            for line in text.splitlines():
                if not re.search(r"isoextract |--iso ", line):
                    continue
                examples += len(re.findall(r"'demo:[a-z-]+\?", line))
                self.assertNotRegex(line, r"(?<!')demo:[a-z-]+\?")
        self.assertGreater(examples, 8)

    def test_help_fits_a_terminal(self):
        for arguments in (("help",), ("convert", "--help"), ("convert", "--help-all"), ("info", "--help"), ("help", "formats"), ("help", "placement")):
            for line in self.text(*arguments).splitlines():
                self.assertLessEqual(len(line), 80, line)

    def test_unknown_topic(self):
        self.assert_fails(1, self.run_program("help", "fromats"), "TOPIC", "did you mean 'formats'?")

    def test_version(self):
        self.assertEqual(self.text("--version"), "isoextract 0.2.0\n")

    def test_generate_needs_a_document(self):
        self.assert_fails(1, self.run_program("generate"), "man|bash|zsh|fish")
        self.assert_fails(1, self.run_program("generate", "csh"), "man, bash, zsh, fish")

    def test_the_man_page_in_the_sources_is_current(self):
        self.assertEqual((SOURCE / "man/isoextract.1").read_text(), self.text("generate", "man"),
                         "update it with: isoextract generate man > man/isoextract.1")

    @needs_program("mandoc")
    def test_the_man_page_is_well_formed(self):
        run = subprocess.run(["mandoc", "-T", "lint", "-W", "warning", SOURCE / "man/isoextract.1"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.stdout, "")
        page = subprocess.run(["mandoc", "-T", "ascii", SOURCE / "man/isoextract.1"], capture_output=True, text=True,
                              check=True).stdout
        self.assertIn("--normals", re.sub(".\x08", "", page))

    def bash_completes(self, line):
        script = self.folder / "completion"
        script.write_text(self.text("generate", "bash"))
        command = ('source "$1"; COMP_LINE=$2 COMP_POINT=${#2} COMP_WORDBREAKS=$\' \\t\\n"\\\'><=;|&(:\'; _isoextract; '
                   'printf "%s\\n" "${COMPREPLY[@]}"')
        run = subprocess.run(["bash", "--norc", "-c", command, "bash", script, line], cwd=self.folder,
                             capture_output=True, text=True, check=True)
        self.assertEqual(run.stderr, "")
        return sorted(run.stdout.split())

    def test_bash(self):
        (self.folder / "in.vdb").touch()
        (self.folder / "in.nrrd").touch()
        for line, wanted in (
                ("isoextract --meth", ["--method"]),
                ("isoextract in.vdb --iso 0 --meth", ["--method"]),
                ("isoextract convert --meth", ["--method"]),
                ("isoextract in.vdb --method ", ["mc", "mt", "surface-nets", "voxels"]),
                ("isoextract in.vdb --method=m", ["mc", "mt"]),
                ("isoextract in.vdb --format g", ["glb", "gltf"]),
                ("isoextract in.vdb --iso ", []),
                # Placeholders such as N, R and FILE are no words.
                ("isoextract in.vdb --radius ", ["auto"]),
                ("isoextract in.vdb --labels ", ["all"]),
                ("isoextract in.vdb --volume ", ["all"]),
                ("isoextract in.vdb --base ", ["none"]),
                ("isoextract in.vdb --device ", []),
                ("isoextract render in.vdb --frames ", []),
                ("isoextract render in.vdb --tf g", ["gray"]),
                ("isoextract render in.vdb --tf=s", ["smoke"]),
                ("isoextract render in.vdb --tf i", ["in.nrrd", "in.vdb"]),
                ("isoextract in.vdb --i", ["--in-process", "--input-format", "--inside", "--iso", "--iso-table"]),
                ("isoextract in", ["in.nrrd", "in.vdb", "info"]),
                ("isoextract info in", ["in.nrrd", "in.vdb"]),
                ("isoextract info --js", ["--json"]),
                ("isoextract info --meth", []),
                ("isoextract in.vdb -o in.v", ["in.vdb"]),
                ("isoextract demo:gy", ["gyroid"]),
                ("isoextract --vers", ["--version"]),
                ("isoextract generate ", ["bash", "fish", "man", "zsh"]),
                ("isoextract help form", ["formats"])):
            self.assertEqual(self.bash_completes(line), wanted, line)

    def test_placeholders_are_no_words(self):
        """Words in capitals, such as N in 'N|cuda:N|NAME'."""
        values = re.findall(r'values="([^"]*)" ;;', self.text("generate", "bash"))
        values += re.findall(r":value:\(([^)]*)\)|:value: _isoextract_files_or ([a-z ]*)'", self.text("generate", "zsh"))
        values += re.findall(r" -a '([^']*)'", self.text("generate", "fish"))
        self.assertGreater(len(values), 100)
        for words in values:
            self.assertEqual(re.findall(r"\S*[A-Z]\S*", " ".join(words) if isinstance(words, tuple) else words), [])

    def test_bash_completes_commands(self):
        self.assertTrue({name for name in self.commands() if " " not in name} <= set(self.bash_completes("isoextract ")))

    def test_bash_keeps_names_with_spaces_whole(self):
        (self.folder / "a file.vdb").touch()
        self.assertEqual(self.bash_completes("isoextract a"), ["a", "file.vdb"])  # one line; split() is the test's

    @needs_program("zsh")
    def test_zsh_parses(self):
        script = self.folder / "_isoextract"
        script.write_text(self.text("generate", "zsh"))
        subprocess.run(["zsh", "-n", script], check=True)

    @needs_program("fish")
    def test_fish(self):
        script = self.folder / "isoextract.fish"
        script.write_text(self.text("generate", "fish"))
        subprocess.run(["fish", "-n", script], check=True)
        for line, wanted in (("isoextract --meth", ["--method"]),
                             ("isoextract x --method ", ["mc", "mt", "surface-nets", "voxels"]),
                             ("isoextract x --radius ", ["auto"]), ("isoextract x --device ", []),
                             ("isoextract render x --tf g", ["gray"]), ("isoextract render x --tf isoe", ["isoextract.fish"]),
                             ("isoextract info --js", ["--json"]), ("isoextract info --meth", []),
                             ("isoextract generate ", ["bash", "fish", "man", "zsh"])):
            run = subprocess.run(["fish", "--no-config", "-c", 'source $argv[1]; complete -C $argv[2]', script, line],
                                 cwd=self.folder, capture_output=True, text=True, check=True)
            self.assertEqual(sorted(row.split("\t")[0] for row in run.stdout.splitlines()), wanted, line)


if __name__ == "__main__":
    main()
