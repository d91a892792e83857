"""The words that the program's C++ code writes for its enums, read from the sources by small patterns."""

import functools
import pathlib
import re

# The body is on the same line, or ends with a brace at the start of a line.
TABLE = re.compile(r"constexpr auto words_of\((?:\w+::)*(\w+) /\*type\*/\) \{( [^\n]* \}$|\n.*?^\})", re.DOTALL | re.MULTILINE)


class CodeWords:
    """Finds words in the sources under `root`. Every search that finds nothing raises an AssertionError."""

    def __init__(self, root):
        self.root = pathlib.Path(root)

    @functools.lru_cache
    def text(self, path):
        return (self.root / "src" / path).read_text()

    def found(self, words, place):
        assert words, f"no words in {place}"
        return frozenset(words)

    @functools.cached_property
    def tables(self):
        """The words of each words_of() table, by room and enum: "convert::Backend"."""
        tables = {}
        for path in sorted((self.root / "src").rglob("*.hpp")):
            relative = path.relative_to(self.root / "src")
            text = self.text(relative)
            found = TABLE.findall(text)
            declared = len(re.findall(r"constexpr auto words_of\(\w", text)) - (relative == pathlib.Path("base/enum_words.hpp"))
            assert len(found) == declared, f"{relative}: {len(found)} of {declared} tables read"
            for enum, body in found:
                words = re.findall(r'Word\{[\w:]+,\s*"([^"]*)"\}', body)
                if "kMethods" in body:
                    words = re.findall(r'\.id = "([^"]*)"', text)
                elif "kStages" in body:
                    words = [stage for stage, _ in self.stages()]
                elif "ISOEXTRACT_FIGURES" in body:
                    words = re.findall(r"\bNAME\((\w+)\)", text)
                name = f"{relative.parts[0]}::{enum}"
                assert name not in tables, f"two tables of {name}"
                tables[name] = self.found(words, f"{relative}: {enum}")
        return tables

    def stages(self):
        """Word and declaration of each stage of a conversion, in their order."""
        body = self.text("convert/stages.hpp").partition("kStages{")[2].partition("\n};")[0]
        rows = re.findall(r'StageInfo\{(?:\.name = )?StageName::\w+,\s*(?:\.word = )?"([^"]*)"(.*?)\}(?=,\n    StageInfo|,$)', body,
                          re.DOTALL)
        assert len(rows) == body.count("StageInfo{"), "not every stage was read"
        return rows

    def timed_stages(self):
        return self.found([word for word, rest in self.stages() if ".is_timed = false" not in rest], "kStages")

    def stages_of_meshes(self):
        """What `verify` says of the stages of a mesh: from the extraction on."""
        first = [word for word, _ in self.stages()].index("extract")
        done = [re.search(r'\.done = "([^"]*)"', rest) for _, rest in self.stages()[first:]]
        return self.found([match[1] for match in done if match], "kStages")

    def literals(self, path, function, pattern=r'"([^"]+)"'):
        """What the pattern finds in the body of a function: all texts unless told otherwise."""
        body = re.search(rf"\b{function}\([^)]*\) \{{\n(.*?)^\}}", self.text(path), re.DOTALL | re.MULTILINE)
        assert body, f"{path}: no function {function}"
        return self.found(re.findall(pattern, body[1]), f"{path}: {function}")

    def matches(self, path, pattern):
        """Everything that a pattern with one group finds in a file."""
        return self.found(re.findall(pattern, self.text(path)), f"{path}: {pattern}")
