"""The tutorials and recipes of docs: the blocks of a page run from top to bottom in one folder, as a reader pastes them.

`sh` blocks run in bash, where each command must end with 0, or with N where its line ends with `# exit code N`. `python` blocks
that follow one another are one program. The files that commands write by name must be there at the end of the page.
A `text` block after a `sh` block shows what that prints: lines of it, in order, where `...` stands for anything.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from support import PROGRAM, SOURCE, ProgramTest, main, needs_program

PAGES = {"docs/get-started.md", "docs/json.md", *(f"docs/tutorials/{page.name}" for page in (SOURCE / "docs/tutorials").glob("*.md"))}
OUTPUT_OPTIONS = ("-o", "--report", "--table", "--html", "--contact-sheet")
HAS_OPENVDB = (pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so").exists()
SECONDS = 600


def python_with(modules):
    """Returns a Python that has these modules, or nothing."""
    for python in dict.fromkeys((sys.executable, "/usr/bin/python3")):
        imports = subprocess.run([python, "-c", f"import {', '.join(modules)}"], capture_output=True, check=False)
        if imports.returncode == 0:
            return python
    return None


def blocks_of(page):
    """(language, text) of the blocks that run or show output, with consecutive Python blocks joined."""
    blocks = []
    for language, text in re.findall(r"^```(sh|python|text)\n(.*?)^```$", (SOURCE / page).read_text(), re.MULTILINE | re.DOTALL):
        if language == "text" and (not blocks or blocks[-1][0] == "python"):
            continue
        if blocks and language == "python" == blocks[-1][0]:
            text = blocks.pop()[1] + text
        blocks.append((language, text))
    return blocks


def with_exit_codes(text):
    """Replaces `command  # exit code N` by a test of that exit code."""
    return re.sub(r"^(.*\S)\s+# exit code (\d+)$", r"code=0; \1 || code=$?; test $code = \2", text, flags=re.MULTILINE)


def first_line_not_printed(shown, printed):
    """The first line of a `text` block that is not in the output after those before it, or None. Times, memory and jobs
    may be those of another machine."""
    def without_measured(text):
        return re.sub(r"\d+(\.\d+)? (s|frames/s|MiB|at a time)\b", r"# \2", text)

    lines = iter(without_measured(printed).splitlines())
    for line in shown.splitlines():
        pattern = re.escape(without_measured(line)).replace(re.escape("..."), ".*")
        if line.strip() != "..." and not any(re.fullmatch(pattern, found) for found in lines):
            return line
    return None


def outputs_of(text):
    """The names that isoextract commands of a `sh` block write, as patterns of glob."""
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("isoextract ") and "# exit code" not in line and "--dry-run" not in line:
            words = shlex.split(line.partition("|")[0], comments=True)
            for option, name in zip(words, words[1:]):
                if option in OUTPUT_OPTIONS and name != "-":
                    yield re.sub(r"\{[^}]*\}", "*", name)


class TutorialsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        for name in ("samples", "docs"):
            (self.folder / name).symlink_to(SOURCE / name)
        (self.folder / "bin").mkdir()
        (self.folder / "bin" / "isoextract").symlink_to(PROGRAM)

    def run_page(self, page):
        text = (SOURCE / page).read_text()
        if "plug-in around OpenVDB" in text and not HAS_OPENVDB:
            self.skipTest(f"{page}: no plug-in around OpenVDB")
        modules = sorted(set(re.findall(r"^import (jsonschema|numpy|pandas)\b", text, re.MULTILINE)))
        python = python_with(modules or ["json"])
        if python is None:
            self.skipTest(f"{page}: no Python with {' and '.join(modules)}")
        (self.folder / "bin" / "python3").write_text(f'#!/bin/sh\nexec "{python}" "$@"\n')
        (self.folder / "bin" / "python3").chmod(0o755)

        environment = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"}
        blocks = blocks_of(page)
        self.assertTrue(blocks, page)
        printed = None  # by the last `sh` block
        for language, block in blocks:
            if language == "text":
                self.assertIsNone(first_line_not_printed(block, printed), f"{page} shows this line; printed was:\n{printed}")
                continue
            program = ["python3", "-c", block]
            if language == "sh":
                program = ["bash", "-e", "-o", "pipefail", "-c", with_exit_codes(block)]
            run = subprocess.run(program, cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 text=True, check=False, timeout=SECONDS)
            self.assertEqual(run.returncode, 0, f"{page}:\n{block}\n{run.stdout[-4000:]}")
            if language == "sh":
                printed = run.stdout
        for name in (name for language, block in blocks if language == "sh" for name in outputs_of(block)):
            self.assertTrue(any(path.stat().st_size > 0 for path in self.folder.glob(name)), f"{page}: {name}")

    @needs_program("jq")
    def test_the_pages_run_from_top_to_bottom(self):
        self.assertGreater(len(PAGES), 4)
        for page in sorted(PAGES):
            with self.subTest(page):
                self.run_page(page)
                for path in self.folder.iterdir():
                    if path.name not in ("samples", "docs", "bin"):
                        shutil.rmtree(path) if path.is_dir() else path.unlink()

    def test_shown_text_does_not_split_python_programs(self):
        self.assertEqual([language for language, _ in blocks_of("docs/tutorials/python.md")].count("python"), 1)

    def test_shown_lines_are_lines_of_the_output_in_order(self):
        printed = "a 1: 2 KiB; 0.05 s\nb\nc 12 of 3\n"
        self.assertIsNone(first_line_not_printed("a 1: 2 KiB; 0.41 s\n...\nc ... of 3\n", printed))
        self.assertEqual(first_line_not_printed("a 1: 3 KiB; 0.05 s\n", printed), "a 1: 3 KiB; 0.05 s")
        self.assertEqual(first_line_not_printed("b\na 1: 2 KiB; 0.05 s\n", printed), "a 1: 2 KiB; 0.05 s")

    def test_exit_codes_are_read_from_the_line(self):
        self.assertEqual(with_exit_codes("a\nb x   # exit code 6\n"), "a\ncode=0; b x || code=$?; test $code = 6\n")

    def test_outputs_are_read_from_commands(self):
        found = list(outputs_of("isoextract a --iso 1 \\\n  -o 'b/{:04}.ply' --table t.csv\nls -o x\n"))
        self.assertEqual(found, ["b/*.ply", "t.csv"])


if __name__ == "__main__":
    main()
