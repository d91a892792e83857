"""The rules of the house that a compiler does not check. Each check takes the project's root and yields findings."""

import pathlib
import re
import subprocess
import sys

# Which rooms a room's sources may include, besides itself; what those include comes along.
MAY_INCLUDE = {
    "base": [],
    "field": ["base"],
    "points": ["field"],
    "simulate": ["field", "points"],
    "mesh": ["base"],
    "files": ["base"],
    "gl": ["base"],
    "sandbox": ["base"],
    "plugin_host": ["field", "files", "sandbox"],
    "volume_io": ["points", "plugin_host"],
    "particle_io": ["points", "volume_io"],
    "mesh_io": ["mesh", "files"],
    "extract": ["field", "mesh", "files"],
    "gpu": ["gl", "extract"],
    "edit": ["mesh"],
    "check": ["mesh"],
    "accuracy": ["extract"],
    "bench": ["accuracy"],
    "image_io": ["files"],
    "render": ["gl", "field", "mesh"],
    "convert": ["particle_io", "mesh_io", "gpu", "edit", "check", "accuracy", "image_io", "render"],
    "batch": ["convert"],
    "cli": ["batch", "bench", "simulate", "render"],
}

LINE_LIMIT = 500

# Rooms at the top, which no other room includes.
OPEN_ROOMS = ("cli/",)

# What only some places may use: pattern, the rooms or files that may, what to do instead.
RESERVED = [
    (r"#\s*include\s*[<\"](GL|GLES\d?|EGL|epoxy)/", ["gl", "gpu", "render"], "GL and EGL belong to gl, gpu and render"),
    (r"\b(_|quick_|std::)?exit\s*\(|\bstd::(abort|terminate)\b|\babort\s*\(", ["cli", "sandbox/detail/server.cpp"],
     "return an Error instead"),
    (r"\bargv\b", ["cli"], "only cli reads the command line"),
    (r"\bstd::w?(cout|cerr|clog)\b|\b(stdout|stderr)\b", ["cli"], "only cli speaks; return text or an Error"),
    (r"\b(v?[fd]?w?printf|puts|fputs|putw?char|perror|psignal)\s*\(", ["cli"], "only cli speaks"),
    (r"\b(std|fmt)::v?print(ln)?\b|\bwrite\s*\(\s*[12]\s*,", ["cli"], "only cli speaks"),
    (r"#\s*include\s*<spdlog/", ["cli"], "only cli speaks"),
    (r"#\s*include\s*[<\"]CLI/", ["cli/parser.cpp"], "options are declared as cli/option.hpp has them"),
    (r"\bSTDOUT_FILENO\b", ["cli", "files/output_file.cpp", "sandbox/worker.cpp", "sandbox/detail/server.cpp"], "write through OutputFile"),
    (r"\btbb::parallel_(for|reduce|deterministic_reduce)\b", ["base/parallel.cpp"],
     "base/parallel.hpp has loops whose machinery is compiled once, not for every body"),
    (r"\bContext\s*&\s*\w+\s*=\s*(Context\b|\{)", ["cli"], "a forgotten context has no limit and no end: let the caller pass it"),
]

# An option's name at the start of a word of a text: "--iso", but no "a--b".
OPTION_NAME = re.compile(r"(?<![\w-])--[A-Za-z]")

MACHINE_PATH = re.compile(r"(^|[^A-Za-z0-9_.~}])/(work|tmp|root|home|Users)/")


def reach(room):
    """The rooms that `room` may include: itself, and what its neighbors reach."""
    return {room}.union(*(reach(neighbor) for neighbor in MAY_INCLUDE[room]))


TOKEN = re.compile(
    r'(?P<include>^[ \t]*#[ \t]*include[^\n]*)'
    r'|(?P<raw>R"(?P<mark>[^()\s\\]{0,16})\(.*?\)(?P=mark)")'
    r'|(?P<comment>//[^\n]*|/\*.*?\*/)'
    r"|(?P<number>\b[0-9][0-9a-fA-FxX']*)"
    r'|(?P<text>"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\')',
    re.DOTALL | re.MULTILINE,
)


def blanked(match):
    return "\n" * match.group().count("\n") or " "


def without_comments_and_text(source):
    """C++ source with comments and the insides of literals blanked; line numbers stay. Include paths are kept."""
    kept = ("include", "number")
    return TOKEN.sub(lambda match: match.group() if match.lastgroup in kept else blanked(match), source)


def literals(source):
    """(line number, text) of every literal of C++ source, for one that spans lines those of each."""
    for match in TOKEN.finditer(source):
        if match.lastgroup not in ("raw", "text"):
            continue
        first = source.count("\n", 0, match.start()) + 1
        for number, line in enumerate(match.group().split("\n"), first):
            yield number, line


def room_sources(root):
    """(room, path, code) of every C++ file of src."""
    for path in sorted((root / "src").rglob("*.[ch]pp")):
        yield path.relative_to(root / "src").parts[0], path, without_comments_and_text(path.read_text())


def project_files(root):
    """What belongs to the project: what git does not ignore, or without git all but what is built and fetched."""
    listing = subprocess.run(
        ["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"], capture_output=True
    )
    if listing.returncode == 0 and listing.stdout:
        paths = [root / name for name in listing.stdout.decode().split("\0") if name]
    else:
        skipped = {"build", ".git", "node_modules", "__pycache__"}
        paths = [path for path in root.rglob("*") if not skipped & set(path.relative_to(root).parts)]
    return sorted(path for path in paths if path.is_file())


def text_of(path):
    data = path.read_bytes()
    return None if b"\0" in data else data.decode(errors="replace")


def numbered(root, path, text):
    for number, line in enumerate(text.splitlines(), 1):
        yield f"{path.relative_to(root)}:{number}", line


def check_includes(root):
    """A room includes itself and the rooms of its row, by "room/header.hpp" from src."""
    for room, path, code in room_sources(root):
        if room not in MAY_INCLUDE:
            yield f"{path.relative_to(root)}: the room '{room}' is not in the table of rooms"
            continue
        for place, line in numbered(root, path, code):
            include = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if not include:
                continue
            quoted, target = include.group(1) == '"', include.group(2)
            first = target.split("/")[0]
            if first in MAY_INCLUDE and "/" in target:
                if first not in reach(room):
                    yield f"{place}: {room} may not include {first} ({target})"
                elif first != room and target.count("/") > 1:
                    yield f"{place}: {target} is for {first} alone"
            elif quoted or first in (".", ".."):
                yield f'{place}: write "{target}" as "room/header.hpp"'


def check_links(root):
    """The link lines allow no more than the table."""
    for path in sorted((root / "src").glob("*/CMakeLists.txt")):
        room = path.parent.name
        text = re.sub(r"#[^\n]*", "", path.read_text())
        if room not in MAY_INCLUDE or f"isoextract_room({room}" not in text:
            yield f"{path.relative_to(root)}: declares no room '{room}' of the table"
            continue
        arguments = re.search(r"\bROOMS\b([^)]*?)(?=\bLIBRARIES\b|\))", text)
        linked = set(arguments.group(1).split()) if arguments else set()
        linked |= set(re.findall(r"\bisoextract_(\w+)", text)) & set(MAY_INCLUDE)
        for other in sorted(linked - reach(room)):
            yield f"{path.relative_to(root)}: {room} may not link {other}"


def check_namespaces(root):
    """What a room declares is in the namespace of its name; base, which all rooms speak, is the project's own."""
    for room, path, code in room_sources(root):
        expected = "isoextract" if room == "base" else f"isoextract::{room}"
        for place, line in numbered(root, path, code):
            declared = re.match(r"namespace (isoextract(::\w+)*)\b", line)
            if declared and declared.group(1) not in (expected, f"{expected}::detail"):
                yield f"{place}: {declared.group(1)}, expected {expected}"


# What is declared at the start of a line: functions, constants and types.
DECLARED = re.compile(
    r"^(?!return\b|using\b|namespace\b|static_assert\b)(?:\[\[nodiscard\]\] )?(?:inline |static |constexpr |const )*"
    r"(?:[A-Za-z_][\w:<>,*& ]*?[ &*>](?P<name>\w+)(?=\(| =|\{))",
    re.MULTILINE,
)


def unnamed_namespaces(code):
    """What stands in the unnamed namespaces of C++ source."""
    for start in re.finditer(r"^namespace \{$", code, re.MULTILINE):
        depth, end = 1, start.end()
        while depth > 0 and end < len(code):
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        yield start.end(), code[start.end() : end - 1]


def check_hidden_names(root):
    """A room compiles as one file: a name of base in an unnamed namespace would hide that of base from the files after."""
    sources = list(room_sources(root))
    of_base = {
        found["name"]
        for room, path, code in sources
        if room == "base" and path.suffix == ".hpp"
        for found in DECLARED.finditer(code)
    }
    for room, path, code in sources:
        if room == "base" or path.suffix != ".cpp":
            continue
        for offset, body in unnamed_namespaces(code):
            for found in DECLARED.finditer(body):
                if found["name"] in of_base:
                    line = code.count("\n", 0, offset + found.start("name")) + 1
                    yield f"{path.relative_to(root)}:{line}: {found['name']} hides what base declares: choose another name"


def check_reserved(root):
    """Graphics headers, output, the command line and the end of the program each have their place."""
    for room, path, code in room_sources(root):
        inside = path.relative_to(root / "src").as_posix()
        for pattern, places, instead in RESERVED:
            if room in places or inside in places:
                continue
            for place, line in numbered(root, path, code):
                if re.search(pattern, line):
                    yield f"{place}: `{line.strip()}`: {instead}"


def check_reservations(root):
    """Memory is reserved as long as the reservation lives: a reservation without an owner ends at once."""
    for _, path, code in room_sources(root):
        for dropped in re.finditer(r"(?:[;{})]|\belse)\s+TRY\(\s*(?:[\w().]|->)*\breserve\(", code):
            yield f"{path.relative_to(root)}:{code.count(chr(10), 0, dropped.end()) + 1}: hold what reserve() returns"


def check_option_names(root):
    """Below cli no room knows the names of options: hints are steps of a Remedy and a Setting, which cli puts into words."""
    for path in sorted((root / "src").rglob("*.[ch]pp")):
        if path.relative_to(root / "src").parts[0] == "cli":
            continue
        for number, text in literals(path.read_text()):
            if OPTION_NAME.search(text):
                yield f"{path.relative_to(root)}:{number}: `{text}`: names an option"


# A text that is the name of an option, or its names: "--iso", "-o,--output".
WHOLE_NAME = re.compile(r"(-[A-Za-z],)?--[A-Za-z][A-Za-z-]*")
# What comes before the text in a declaration: the type and the name of a member, or the base of an option's own type.
# Members of ViewFlags, which several commands share, are declared in its constructor, the name of one with each command.
DECLARATION = re.compile(
    r"(?:(?:Value|Values|Flag|ViewFlags)(?:<[^;{}]*>)?(?:\s+\w+\{|\()[^;\"]*|\w+\{\s*command != nullptr [^;\"]*"
    r"|kHelpNames = )$")
WORDS_HINTS = ["cli/remedies.cpp", "cli/foreign_options.cpp", "cli/gnuplot.cpp"]  # gnuplot's are options of gnuplot


def check_options_once(root):
    """An option is named where it is declared (src/cli/options): elsewhere its member is asked for its name."""
    for path in sorted((root / "src" / "cli").rglob("*.[ch]pp")):
        if path.relative_to(root / "src").as_posix() in WORDS_HINTS:
            continue
        source = re.sub(r"//[^\n]*", "", path.read_text())
        for found in re.finditer(r'"([^"\\\n]*)"', source):
            if not WHOLE_NAME.fullmatch(found.group(1)):
                continue
            if not DECLARATION.search(source[max(0, found.start() - 300) : found.start()]):
                number = source.count("\n", 0, found.start()) + 1
                yield f"{path.relative_to(root)}:{number}: `{found.group(0)}`: an option is named a second time"


# A command's declaration: the name is the first of its words.
COMMAND = re.compile(r'\b(?:CommandOf|PlannedCommand|CommandWords)\s*[({]+\s*"(\w+)"')


def check_commands_by_name(root):
    """A command's name is in its own file: what walks over commands (cli/command.hpp) knows none of them by name."""
    sources = {path: re.sub(r"//[^\n]*", "", path.read_text()) for path in sorted((root / "src" / "cli").rglob("*.[ch]pp"))}
    commands = {path for path in sources if path.name.endswith("_command.cpp")}
    names = {name for path in commands for name in COMMAND.findall(sources[path])}
    for path, source in sources.items():
        if path in commands or '#include "cli/command.hpp"' not in source:
            continue
        for found in re.finditer(r'"(\w+)"', source):
            if found.group(1) in names:
                number = source.count("\n", 0, found.start()) + 1
                yield f"{path.relative_to(root)}:{number}: `{found.group(0)}`: a command is known by its name"


def check_map(root):
    """src/README.md has a heading for every room, and the headers that it names as doors of a room are there."""
    page = root / "src" / "README.md"
    sections = re.split(r"^### (\w+)", page.read_text() if page.exists() else "", flags=re.MULTILINE)
    named = dict(zip(sections[1::2], sections[2::2]))
    rooms = {room for room, _, _ in room_sources(root)}
    for room in sorted(rooms - set(named)):
        yield f"src/README.md: no heading for {room}"
    for room in sorted(set(named) - rooms):
        yield f"src/README.md: names the room {room}, which is not there"
    for room in sorted(rooms & set(named)):
        for header in re.findall(r"`(\w+\.hpp)`", re.split(r"^## ", named[room], flags=re.MULTILINE)[0]):
            if not (root / "src" / room / header).exists():
                yield f"src/README.md: names {room}/{header}, which is not there"


def check_doors(root):
    """A header at the top of a room is one that other rooms use, themselves or by another that they use."""
    included_by = {}
    for place in ("src", "plugins", "samples"):
        for path in (root / place).rglob("*.[ch]pp") if (root / place).exists() else []:
            inside = path.relative_to(root / "src").as_posix() if place == "src" else place
            for header in re.findall(r'^\s*#\s*include\s*"([\w/]+\.hpp)"', path.read_text(), re.MULTILINE):
                included_by.setdefault(header, set()).add(inside)
    headers = {path.relative_to(root / "src").as_posix() for path in (root / "src").glob("*/*.hpp")}
    headers = {header for header in headers if not header.startswith(OPEN_ROOMS)}
    used = {h for h in headers if any(user.split("/")[0] != h.split("/")[0] for user in included_by.get(h, ()))}
    found = True
    while found:
        found = {h for h in headers - used if included_by.get(h, set()) & used}
        used |= found
    for header in sorted(headers - used):
        yield f"src/{header}: no other room uses it: it belongs into {header.split('/')[0]}/detail"


def check_length(root):
    """No file of sources, tests or shaders is too long to read; the map has a line for each of them."""
    for path in project_files(root):
        parts = path.relative_to(root).parts
        if parts[0] not in ("src", "tests", "shaders") or path.name in ("package-lock.json", "README.md"):
            continue
        text = text_of(path)
        lines = len(text.splitlines()) if text is not None else 0
        if lines > LINE_LIMIT:
            yield f"{path.relative_to(root)}: {lines} lines, at most {LINE_LIMIT}"


def check_machine_paths(root):
    """No file names a folder of one machine."""
    for path in project_files(root):
        text = text_of(path)
        for place, line in numbered(root, path, text or ""):
            if MACHINE_PATH.search(line):
                yield f"{place}: `{line.strip()}`: an absolute path of one machine"


def check_remedies(root):
    """Every remedy and every setting is in a hint of a room below cli, and cli has words for it."""
    code_of = {path.relative_to(root / "src").as_posix(): code for _, path, code in room_sources(root)}
    given = " ".join(code for name, code in code_of.items() if not name.startswith("cli/"))
    enums = re.findall(r"\benum class (Remedy|Setting) \{(.*?)\}", code_of.get("base/error.hpp", ""), re.DOTALL)
    for enum, names in enums:
        for name in re.findall(r"\w+", names)[1:]:  # the first is that of steps that are words
            if not re.search(rf"\b{enum}::{name}\b", given):
                yield f"src/base/error.hpp: no hint has {enum}::{name}"
            if not re.search(rf"\b{enum}::{name}\b", code_of.get("cli/remedies.cpp", "")):
                yield f"src/cli/remedies.cpp: no words for {enum}::{name}"


STAGE_AS_STRING = re.compile(
    r"word_of\([^;()]*\b(stage|key)\w*\b[^;()]*\)\s*[!=]="
    r"|[!=]=\s*word_of\([^;()]*\b(stage|key)\w*\b|[!=]=\s*word_of\((StageName|Key)::"
    r"|\bword_of\((StageName|Key)::\w+\)\s*[!=]="
    r'|\bstage\w*\s*[!=]=\s*"|"\s*[!=]=\s*(\w+(\.|->))*stage'
)


def check_stage_names(root):
    """Stages and figures are told apart by the values of StageName and Key; their words are for documents."""
    for path in sorted((root / "src").rglob("*.[ch]pp")):
        code = TOKEN.sub(lambda found: blanked(found) if found.lastgroup == "comment" else found.group(), path.read_text())
        for place, line in numbered(root, path, code):
            if STAGE_AS_STRING.search(line):
                yield f"{place}: `{line.strip()}`: compares a stage or a figure as a string"


CHECKS = [
    check_includes, check_links, check_namespaces, check_reserved, check_reservations, check_option_names, check_options_once,
    check_commands_by_name,
    check_map, check_doors, check_length, check_machine_paths, check_remedies, check_stage_names, check_hidden_names,
]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    findings = [(check, finding) for check in CHECKS for finding in check(root)]
    for check, finding in findings:
        print(f"{finding}\n    rule: {check.__doc__}")
    if not any(True for _ in room_sources(root)):
        sys.exit(f"no sources under {root}")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
