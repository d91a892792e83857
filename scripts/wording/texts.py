"""The texts of the project: comments, documents, messages, help and names, each with its file, lines and kind."""

import bisect
import dataclasses
import functools
import re
import subprocess

CPP = (".cpp", ".hpp", ".h", ".glsl", ".geom", ".vert", ".frag", ".tesc", ".tese", ".mjs")
HEADERS = (".hpp", ".h")
FOLDERS = ("src", "plugins", "shaders", "tests", "scripts", "docs", "cmake")
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
# Literals of these files are help: declarations of options and commands, and the topics of `isoextract help`.
HELP = re.compile(r"src/cli/(options/|help_topics|options\.hpp|commands?\.|\w+_command\.)")
MADE = ("docs/measurements/", "tests/fuzz/dictionaries/")  # pages that scripts/measure writes; words of file formats


@dataclasses.dataclass
class Text:
    """A paragraph. `kind`: comment, trailing (a comment behind code), page, message, help or name."""

    kind: str
    path: str
    parts: list  # (line number, text of the line)
    declaration: str = ""  # the code after a comment of a header, up to its parameters

    @functools.cached_property
    def words(self):
        return " ".join(part for _, part in self.parts)

    def line(self, offset):
        for number, part in self.parts:
            if offset <= len(part):
                return number
            offset -= len(part) + 1
        return self.parts[-1][0]


def room_of(path):
    """The row of the table that a file counts in: src/ROOM, a folder, or a page's name; None where it counts in none."""
    parts = path.split("/")
    if len(parts) == 1:
        return path.removesuffix(".md") if path in PAGES else None
    if parts[0] not in FOLDERS or path.startswith(MADE):
        return None
    return "/".join(parts[:2]) if parts[0] == "src" and len(parts) > 2 else parts[0]


def project_files(root):
    """Paths of the files that count, relative to the root: those that git does not ignore, or without git all."""
    listing = subprocess.run(["git", "-C", root, "ls-files", "-z", "-co", "--exclude-standard"], capture_output=True, check=False)
    if listing.returncode == 0 and listing.stdout:
        names = listing.stdout.decode().split("\0")
    else:
        names = [path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()]
    return sorted(name for name in set(names) if name and room_of(name) and (root / name).is_file())


ITEM = re.compile(r"\s*(?:[-*]|\d+[.)]) ")
# A line that is indented like code, or has columns.
DRAWN = re.compile(r"^(?: {4}|\t|\s*\|)|\S {3,}\S|^\s*(?:\$ |scripts/\w+ )")


def paragraphs(lines):
    """Splits (line number, text) at empty lines and at items of lists; leaves out code and tables."""
    parts = []
    for number, line in lines:
        item = ITEM.match(line)
        drawn = not item and DRAWN.search(line)
        if parts and (item or drawn or not line.strip()):
            yield parts
            parts = []
        if line.strip() and not drawn:
            parts.append((number, line[item.end() if item else 0 :].strip()))
    if parts:
        yield parts


# ---- C++ and GLSL

CPP_TOKEN = re.compile(
    r"(?=[/\"'R])(?:(?P<comment>//[^\n]*)|(?P<block>/\*.*?\*/)"
    r'|(?P<text>"(?:[^"\\\n]|\\.)*")|(?P<letter>\'(?:[^\'\\\n]|\\[^\'\n]+|\\\')\')'
    r'|(?P<raw>R"(?P<mark>[^()\s\\]{0,16})\(.*?\)(?P=mark)"))',
    re.DOTALL,
)
NO_PROSE = re.compile(r"//\s*(NOLINT|clang-format|namespace\b|eslint|prettier|=+$|-+$)")
IDENTIFIER = re.compile(r"\w+")
# Everything in ASCII but letters, digits and '_' becomes a blank.
BLANKS = {ord(letter): " " for letter in map(chr, range(128)) if not IDENTIFIER.fullmatch(letter)}
SCOPE = re.compile(r"\b(namespace|struct|class|enum|union|extern)\b")


class Source:
    """A source file, cut into tokens that hold no code, and the code between them."""

    def __init__(self, path, text, token):
        self.path, self.text = path, text
        self.tokens = list(token.finditer(text))
        self.starts = [token.start() for token in self.tokens]
        self.lines = [0] + [found.end() for found in re.finditer("\n", text)]

    def line(self, offset):
        return bisect.bisect_right(self.lines, offset)

    def in_code(self, offset):
        at = bisect.bisect_right(self.starts, offset) - 1
        return at < 0 or offset >= self.tokens[at].end()

    def stands_alone(self, token):
        return not self.text[self.lines[self.line(token.start()) - 1] : token.start()].strip()

    def names(self, looks_wrong):
        """Texts of the identifiers for which looks_wrong(name) is true, each once."""
        for name in sorted(filter(looks_wrong, set(self.text.translate(BLANKS).split()))):
            place = self.text.find(name)
            while place >= 0 and not (self.is_word(place, name) and self.in_code(place)):
                place = self.text.find(name, place + 1)
            if place >= 0:
                yield Text("name", self.path, [(self.line(place), name)])

    def is_word(self, place, name):
        end = place + len(name)
        return not IDENTIFIER.match(self.text[place - 1 : place]) and not IDENTIFIER.match(self.text[end : end + 1])


class CppSource(Source):
    def comments(self):
        """Texts of comments: those of successive lines are one."""
        block = []
        for token in self.tokens:
            if token.lastgroup not in ("comment", "block"):
                continue
            number, prose = self.line(token.start()), token.lastgroup == "comment" and not NO_PROSE.match(token.group())
            alone = self.stands_alone(token)
            if block and not (alone and prose and number == block[-1][0] + 1):
                yield from self.of_block(block)
                block = []
            if token.lastgroup == "block" and "\n" in token.group():
                rows = token.group()[2:-2].split("\n")
                yield from self.of_block([(number + i, re.sub(r"^\s*\*", "", row)) for i, row in enumerate(rows)])
            elif prose and alone:
                block.append((number, token.group()[2:]))
            elif prose:
                yield Text("trailing", self.path, [(number, token.group()[2:].strip())])
        if block:
            yield from self.of_block(block)

    def of_block(self, block):
        for i, parts in enumerate(paragraphs((n, row[1:] if row.startswith(" ") else row) for n, row in block)):
            after = self.declaration_after(block[-1][0]) if i == 0 and self.path.endswith(HEADERS) else ""
            yield Text("comment", self.path, parts, after)

    def declaration_after(self, number):
        """What is declared in the line after that one, up to its semicolon or body; "" in a function's body."""
        if number >= len(self.lines) or self.lines[number] in self.bodies:
            return ""
        start = self.lines[number]
        if self.blanked.startswith("\n", start):
            return ""
        return re.split(r"[;{]", self.blanked[start : start + 800], maxsplit=1)[0]

    @functools.cached_property
    def blanked(self):
        """The code, with spaces in place of comments and literals."""
        code, last = [], 0
        for token in self.tokens:
            code += [self.text[last : token.start()], re.sub(r"[^\n]", " ", token.group())]
            last = token.end()
        return "".join([*code, self.text[last:]])

    @functools.cached_property
    def bodies(self):
        """Starts of the lines that lie in bodies of functions."""
        inside, stack, statement = set(), [], 0
        offsets = iter([*self.lines, len(self.text)])
        line = next(offsets)
        for found in re.finditer(r"[{};]", self.blanked):
            while line <= found.start():
                if "body" in stack:
                    inside.add(line)
                line = next(offsets)
            if found.group() == "{":
                stack.append("scope" if SCOPE.search(self.blanked, statement, found.start()) else "body")
            elif found.group() == "}" and stack:
                stack.pop()
            statement = found.end()
        return inside

    def literals(self):
        """Texts of literals that have several words; what the compiler joins is one."""
        kind = "help" if HELP.match(self.path) else "message"
        parts, end = [], 0
        for token in self.tokens:
            if token.lastgroup != "text":
                continue
            if parts and self.text[end : token.start()].strip():
                yield from self.of_literal(kind, parts)
                parts = []
            parts.append((self.line(token.start()), token.group()[1:-1].replace('\\"', '"')))
            end = token.end()
        yield from self.of_literal(kind, parts)

    def of_literal(self, kind, parts):
        if " " in "".join(part for _, part in parts).strip():
            # A literal's words may go on in the next one without a space.
            yield Literal(kind, self.path, [(number, part.replace("\\n", "\n")) for number, part in parts])


class Literal(Text):
    @functools.cached_property
    def words(self):
        return "".join(part for _, part in self.parts)

    def line(self, offset):
        for number, part in self.parts:
            if offset < len(part):
                return number
            offset -= len(part)
        return self.parts[-1][0]


def cpp_texts(path, text, looks_wrong):
    source = CppSource(path, text, CPP_TOKEN)
    yield from source.comments()
    if path.startswith(("src/", "plugins/")):
        yield from source.literals()
    yield from source.names(looks_wrong)


# ---- Python, shell, CMake

PYTHON_TOKEN = re.compile(
    r'(?P<long>"""(?:\\.|[^\\])*?""")|(?P<text>"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\')|(?P<comment>#[^\n]*)', re.DOTALL
)


def python_texts(path, text, looks_wrong):
    """Comments and documentation strings; other literals are left out, as they quote what the program says."""
    source = Source(path, text, PYTHON_TOKEN)
    comments = []
    for token in source.tokens:
        number = source.line(token.start())
        before = text[max(0, token.start() - 200) : token.start()].rstrip()
        if token.lastgroup == "comment":
            prose = not token.group().startswith(("#!", "# noqa", "# fmt", "# pylint"))
            line = token.group()[1:].removeprefix(" ") if prose else ""
            if source.stands_alone(token):
                comments.append((number, line))
            elif line:
                yield Text("trailing", path, [(number, line)])
        elif source.stands_alone(token) and (before.endswith((":", "python3")) or not before):
            rows = token.group().strip("\"'").split("\n")
            margin = min((len(row) - len(row.lstrip()) for row in rows[1:] if row.strip()), default=0)
            for parts in paragraphs((number + i, row[margin:] if i else row) for i, row in enumerate(rows)):
                yield Text("comment", path, parts)
    yield from comment_texts(path, comments)
    yield from source.names(looks_wrong)


def comment_texts(path, comments):
    """Paragraphs of comments, of which successive lines are one."""
    block = []
    for number, row in comments:
        if block and number != block[-1][0] + 1:
            for parts in paragraphs(block):
                yield Text("comment", path, parts)
            block = []
        block.append((number, row))
    for parts in paragraphs(block):
        yield Text("comment", path, parts)


def script_texts(path, text):
    rows = enumerate(text.split("\n"), 1)
    comments = [(n, row.strip()[1:].removeprefix(" ")) for n, row in rows if re.match(r"\s*#( |$)", row)]
    yield from comment_texts(path, comments)


# ---- Documents


def page_texts(path, text):
    """Paragraphs, items, headings and cells of tables of Markdown, without blocks of code."""
    fenced, block = False, []
    for number, row in enumerate(text.split("\n"), 1):
        fence = re.match(r"\s*(```|~~~)", row)
        if fence or fenced or re.match(r"\s*(#|\||<!--|<\w)", row):
            yield from (Text("page", path, parts) for parts in paragraphs(block))
            block = []
            fenced = fenced != bool(fence)
            if not fence and not fenced and re.match(r"\s*[#|]", row):
                for cell in re.split(r"(?<!\\)\|", row.strip().strip("#|")):
                    if re.search(r"\w", cell):
                        yield Text("page", path, [(number, cell.strip())])
        else:
            # Lines of an item are indented under it.
            block.append((number, row if re.match(r"\s*([-*]|\d+[.)]) ", row) else row.strip()))
    yield from (Text("page", path, parts) for parts in paragraphs(block))


def schema_texts(path, text):
    for found in re.finditer(r'"description": "((?:\\.|[^"\\])*)"', text):
        yield Text("page", path, [(text.count("\n", 0, found.start()) + 1, found.group(1).replace('\\"', '"'))])


def texts_of(root, path, looks_wrong):
    """The texts of one file, in no order; of its identifiers those for which looks_wrong(name) is true."""
    data = (root / path).read_bytes()
    if b"\0" in data:
        return
    text = data.decode(errors="replace")
    if path.endswith(CPP):
        yield from cpp_texts(path, text, looks_wrong)
    elif path.endswith(".py") or text.startswith("#!/usr/bin/env python3"):
        yield from python_texts(path, text, looks_wrong)
    elif path.endswith(".md"):
        yield from page_texts(path, text)
    elif path.endswith(".schema.json"):
        yield from schema_texts(path, text)
    elif path.endswith((".sh", ".cmake", ".sbatch", "CMakeLists.txt")) or text.startswith("#!"):
        yield from script_texts(path, text)
