"""Plants wording that scripts/words is to find, and wording that it is to leave alone: words_test.py PROJECT_FOLDER"""

import contextlib
import importlib.machinery
import importlib.util
import io
import pathlib
import shutil
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "scripts"))


def load(path):
    """The module of a script whose name has no ending."""
    spec = importlib.util.spec_from_loader(path.stem, importlib.machinery.SourceFileLoader(path.stem, str(path)))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


words = load(ROOT / "scripts" / "words")

THIRTY_SIX = "The reader " + "and the reader " * 11 + "ends."
THIRTY_FIVE = "The reader " + "and the reader " * 11 + "."


class WordsTest(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-house-"))
        self.addCleanup(shutil.rmtree, self.root)

    def plant(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text)

    def findings(self, path, text):
        """(line, rule) of what is found in a file with that text."""
        self.plant(path, text)
        return [(line, rule) for line, rule, _, _ in words.rules.findings_of(self.root, path)]

    def expect(self, path, found, clean):
        """Each of `found` is (text, line, rule), the one finding in the text; `clean` have none."""
        for text, line, rule in found:
            with self.subTest(text=text):
                self.assertEqual(self.findings(path, text), [(line, rule)])
        for text in clean:
            with self.subTest(text=text):
                self.assertEqual(self.findings(path, text), [])

    def test_words_of_the_glossary_in_pages(self):
        found = ["Drops crumbs.", "A cap is a lid.", "The border of the mesh.",
                 "The largest piece stays.", "This thing is large.", "The number of them is told.",
                 "Sizes are held against limits.", "A threshold of 0.5.", "The backend gave way to the CPU.",
                 "Parts that hang together.", "The hint is what helps.", "Whoever reads files.",
                 "Nobody knows.", "The wrong side of the surface.", "The program joins equal vertices."]
        clean = ["Valid slides.", "Give `{piece}` in the name.", "Write `--pieces` or [pieces](pieces.md).",
                 "Otsu's threshold of the histogram.", "Nothing is valid; something is.", "The set is told apart by names.",
                 "A piece of memory.", "The style is `border: 0`.", "Everything there helps.", "Compression level 5.",
                 "A body.", "The file `border_cap.hpp`.", "```sh\na border\n```", "It holds back errors against odds."]
        self.expect("docs/page.md", [("\n" + text + "\n", 2, "word") for text in found], clean)

    def test_words_of_the_glossary_in_code(self):
        found = [("// A border.\n", 1, "word"), ("int f();  // a crumb\n", 1, "word"), ("int kBorderCap = 1;\n", 1, "word"),
                 ("int x;\nint is_lid = 1;\nint y = is_lid;\n", 2, "word"), ("/* one\n   lid */\n", 2, "word"),
                 ('auto s = "drops "\n         "crumbs of it";\n', 2, "word")]
        clean = ['auto s = "lid";\n', "int boundary_cap, solid, embedded, nothing, recommend;\n", 'R"(a border)";\n',
                 "// NOLINTNEXTLINE(border)\n", "int n = 1'000'000;  // voxels\n", "// A piece of work.\n"]
        self.expect("src/extract/planted.cpp", found, clean)

    def test_pieces_are_parts_of_files_elsewhere(self):
        self.expect("src/edit/planted.cpp", [("// The piece is closed.\n", 1, "word")], ["// Reads a piece of the file.\n"])
        self.expect("src/files/planted.cpp", [], ["// The piece is long.\n"])

    def test_long_sentences(self):
        half = THIRTY_SIX[:80].rsplit(" ", 1)[0]
        rest = THIRTY_SIX[len(half) + 1 :]
        found = [(f"Short.\n{half}\n{rest}\n", 2, "long"), (f"- {THIRTY_SIX}\n", 1, "long"),
                 (f"| a | {THIRTY_SIX} |\n", 1, "long")]
        clean = [THIRTY_FIVE, THIRTY_SIX.replace(" and", ". And"), f"{half}\n\n{rest}\n", f"- {half}\n- {rest}\n",
                 f"```\n{THIRTY_SIX}\n```\n", f"`{THIRTY_SIX}`\n", f"| {half} | {rest} |\n"]
        self.expect("docs/page.md", found, clean)
        found = [(f"int x;\n// {half}\n// {rest}\n", 2, "long"), (f'auto s = "{half} "\n"{rest}";\n', 1, "long")]
        clean = [f"// {half}\n//\n// {rest}\n", f"// {half}\nint x;\n// {rest}\n", f'auto s = "{half}", t = "{rest}";\n',
                 f'auto s = "{half}\\n{rest}";\n', f"//     {THIRTY_SIX}\n", f"// {half}   {rest}\n"]
        self.expect("src/mesh/planted.cpp", found, clean)
        found = [(f'"""{THIRTY_SIX}"""\n', 1, "long"), (f'def f():\n    """{THIRTY_SIX}"""\n', 2, "long"),
                 (f"# {half}\n# {rest}\n", 1, "long")]
        self.expect("scripts/planted.py", found, [f'x = "{THIRTY_SIX}"\n', f"x = 1  # {half}\ny = 2  # {rest}\n",
                    f'f(\n    "{THIRTY_SIX}"\n)\n'])
        self.expect("src/cli/options/planted.hpp", [(f'Flag f{{"-x", "{THIRTY_SIX}"}};\n', 1, "long")], [])
        found = [(f'{{\n"description": "{THIRTY_SIX}"}}\n', 2, "long")]
        self.expect("docs/x.schema.json", found, [f'{{"title": "{THIRTY_SIX}"}}'])

    def test_comments_that_are_riddles(self):
        riddles = ["Of one skeleton.", "Or fails.", "What is not 0.", "That of the mesh.", "Those of `a`.",
                   "Whose name is long.", "Likewise.", "The same, backwards.", "One that is lost.", "Nothing.", "All that stays.",
                   "It has two.", "Also where it is.", "Some, and each once.", "As long as it was.",
                   "Where the next byte is."]
        found = [(f"int x;\n// {text}\nint y = 1;\n", 2, "comment") for text in riddles]
        found += [("int x;  // what it takes\n", 1, "comment"), ("int x;  // likewise\n", 1, "comment")]
        clean = ["// Some drivers report 0 here.\n", "// The vertices, sorted.\nint y;\n",
                 "// Offset of the first byte.\nint y;\n", "// Where the driver has no fences, the host waits.\n",
                 "// Items.\n", "int x;  // of the mesh\n", "// As OpenVDB has no order, the blocks are sorted.\nint y;\n",
                 "// Original order.\nint y;\n",
                 "int x;  // the same colors\n"]
        self.expect("src/mesh/planted.hpp", found, clean)
        self.expect("src/mesh/planted.cpp", [], ["// Of one skeleton.\n"])

    def test_comments_of_functions(self):
        functions = ["int f();", "[[nodiscard]] Result<std::vector<int>> f(int x,\n    int y);", "virtual void f() = 0;",
                     "template <class T, class = std::enable_if_t<sizeof(T) == 4>>\nT f(T x) { return x; }",
                     "inline constexpr bool operator==(int a, int b);", "explicit Mesh(int size);", "static auto f() -> int;",
                     "[[nodiscard]] const std::function<int(int)>& f() const;"]
        found = [(f"// The number of vertices.\n{code}\n", 1, "comment") for code in functions]
        found += [(f"// {text}\n{functions[0]}\n", 1, "comment") for text in ("Names of one skeleton.", "Vertices, sorted.",
                  "How many there are.", "By name.", "Values that are not 0.")]
        found.append(("class A {\n public:\n  // Vertices of one part.\n  int f() const;\n};\n", 3, "comment"))
        clean = [f"// {text}\n{functions[0]}\n" for text in ("Returns the number.", "Whether the mesh is closed.",
                 "True if it is closed.", "Throws DamagedMesh.", "Fails with ErrorCode::usage.", "Relabels every vertex.",
                 "Leaves the mesh.",
                 "`size` must be above 0.", '"mc, mt"', "All arguments must outlive the run.", "No point is nearer.",
                 "Also closes the file.", "Like f(), but twice.", "Step 1: measures the mesh.",
                 "If there is none, returns the first.", "Row (j, k) is one word.", "For files::A: returns the table.",
                 "Call once.", "The filter reaches 3 voxels.")]
        clean += [f"// The number of vertices.\n{code}\n" for code in ("int x = f(1);", "std::function<void(int)> f;",
                  "struct S {};", "class C : public B<int(int)> {};", "using F = int(int);",
                  'Value<int> x{*this, parse("N")};', "enum class E { a };", "void (*run)(int);", "alignas(16) int x;",
                  "#define F(x) x", "std::array<std::size_t, sizeof(int)> x{};",
                  "template <class T>\nconcept C = requires(T t) { f(t); };")]
        clean.append("inline int f() {\n  // The first vertex counts.\n  g(1);\n  return 1;\n}\n")
        clean.append("// The number of vertices.\n\nint f();\n")
        self.expect("src/mesh/planted.hpp", found, clean)

    def test_passive_messages(self):
        found = ["the file cannot be read", "{}: the name was given twice", "samples are not stored as text",
                 "no frame is written", "which labels there are is known later"]
        found = [(f'int x;\nreturn fail(Code::a, "{text}");\n', 2, "passive") for text in found]
        clean = ["expected a number, found '{}'", "a name is needed", "the mesh is closed", "the grid is truncated",
                 "numbers are even", "isoextract cannot read the file", "the axes are then mirrored",
                 "vertices are indeed sorted", "the file is empty"]
        clean = [f'return fail(Code::a, "{text}");\n' for text in clean] + ["// The file is read.\n",
                 'auto s = R"(is read)";\n']
        self.expect("src/mesh/planted.cpp", found, clean)
        self.expect("src/cli/options/planted.hpp", [], ['Flag f{"-x", "The file is read."};\n'])
        self.expect("tests/planted.cpp", [], ['expect("the file cannot be read");\n'])

    def test_spelling(self):
        found = ["int colour = 1;", "int neighbourCount = 1;", "// Normalised.", "// In the centre.", "// A grey one.",
                 "// Two metres.", 'auto s = "two colours";', "void visualise();", "// Quantisation.",
                 "// Labelled.", "// A licence."]
        clean = ["int color, size, rise, noise, raise, promise, precise, four;", '"colour";', '{"-x,--colour", "--grey"};',
                 "// Otherwise.", "// Clockwise, likewise.", "// Parametric, symmetric.", "// The caller called.",
                 "// An hour of labor.", "// Concentric.", "// Numerische Fehleranalyse.", "// Filled, filler.",
                 "// Raised, advised.", 'auto s = "use --colour 1";', "// A parser."]
        self.expect("src/mesh/planted.cpp", [(f"{text}\n", 1, "spelling") for text in found], [f"{text}\n" for text in clean])
        self.expect("README.md", [("In colour.\n", 1, "spelling")], ["See `colour` and [this](docs/colour.md).\n"])

    def test_rooms_and_check(self):
        for path in ("src/mesh/a.cpp", "src/mesh/detail/b.hpp", "tests/unit/a.cpp", "README.md"):
            self.plant(path, "// A border.\n")
        for path in ("samples/a.cpp", "docs/measurements/a.md", "NOTES.md"):
            self.plant(path, "A border.\n")
        self.assertEqual({room: sum(row.values()) for room, row in words.count(self.root).items()},
                         {"src/mesh": 2, "tests": 1, "README": 1})
        with contextlib.redirect_stdout(io.StringIO()) as out:
            self.assertEqual(words.check(self.root), 1)
        lines = out.getvalue().splitlines()
        self.assertEqual([line.split(":")[0] for line in lines],
                         ["README.md", "src/mesh/a.cpp", "src/mesh/detail/b.hpp", "tests/unit/a.cpp", "words"])
        self.assertIn("findings: 4;", lines[-1])
        for path in ("src/mesh/a.cpp", "src/mesh/detail/b.hpp", "tests/unit/a.cpp", "README.md"):
            self.plant(path, "// A boundary.\n")
        with contextlib.redirect_stdout(io.StringIO()) as out:
            self.assertEqual(words.check(self.root), 0)
        self.assertEqual(out.getvalue(), "")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
