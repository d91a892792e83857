"""The errors that the code makes: text, exit code and hint of each call, with … for what is known only at run time."""

import dataclasses
import re

TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\'|[A-Za-z_][\w]*(?:::[A-Za-z_]\w*)*|->|::|\s+|.', re.S)
EXIT_CODES = {"usage": 1, "placement": 1, "input": 2, "empty_grid": 2, "no_surface": 2, "out_of_memory": 2, "unavailable": 3,
              "output": 4, "frames": 5, "verification": 6, "cancelled": 130}
# Functions whose first argument is the message, with the code of their errors.
BY_MESSAGE = {"refuse_usage": "usage", "InvalidParticleFile": "input", "DamagedMesh": "input", "InvalidVdb": "input",
              "UnsupportedVdb": "input", "TruncatedFrame": "input", "VdbReadError": "input"}


@dataclasses.dataclass
class MessageError:
    room: str
    text: str
    code: int
    hints: set


def joined(literals):
    """The text of C++ literals that stand in a row."""
    texts = re.findall(r'"((?:[^"\\]|\\.)*)"', literals)
    return "".join(texts).replace('\\"', '"').replace("\\\\", "\\").replace("\\n", " ")


def tokens_of(source):
    return [t for t in TOKEN.findall(source) if not t.isspace() and not t.startswith(("//", "/*"))]


def arguments(tokens, start):
    """The arguments of the call whose bracket is at `start`, each as a list of tokens."""
    depth, found, now = 0, [], []
    for token in tokens[start:]:
        if token in "([{":
            depth += 1
            if depth == 1:
                continue
        elif token in ")]}":
            depth -= 1
            if depth == 0:
                break
        if token == "," and depth == 1:
            found.append(now)
            now = []
        else:
            now.append(token)
    if now:
        found.append(now)
    return found


NUMBERS = ({"is", "are"}, {"has", "have"}, {"was", "were"}, {"does", "do"})  # singular and plural of verbs


def chosen_word(tokens):
    """One word of `condition ? "is" : "are"` or `"need" : "needs"`, so that the page has verbs; … for other expressions."""
    branches = "".join(tokens).rpartition("?")[2].split(":") if "?" in tokens else []
    words = [found[1] for found in (re.fullmatch(r'"([a-z ]*)"', branch) for branch in branches) if found]
    same_but_number = len(words) == 2 and (words[0].strip() + "s" == words[1].strip() or
                                           words[1].strip() + "s" == words[0].strip() or set(words) in NUMBERS)
    return max(words, key=len) if same_but_number else "…"


def format_pattern(args):
    """The text of fmt::format, with … for the arguments that are known only at run time."""
    values = iter(args[1:])

    def replaced(found):
        if found[0] in ("{{", "}}"):
            return found[0][0]
        value = next(values, [])
        return chosen_word(value) if found[0] == "{}" else "…"

    return re.sub(r"\{\{|\}\}|\{[^{}]*\}", replaced, pattern(args[0]))


def pattern(tokens):
    """The text of an expression: its literals, with … for everything else. Empty if it has no literal."""
    if tokens[:1] == ["fmt::format"]:
        return format_pattern(arguments(tokens, 1))
    if tokens[:1] == ["std::string"] and tokens[1:2] == ["("]:
        return pattern(arguments(tokens, 1)[0])
    parts, operand, depth = [], [], 0
    for token in [*tokens, "+"]:
        depth += (token in "([{") - (token in ")]}")
        if token == "+" and depth == 0:
            parts.append(operand)
            operand = []
        else:
            operand.append(token)
    if not any(token.startswith('"') for token in tokens):
        return ""
    out = ""
    for part in parts:
        if part and all(token.startswith('"') for token in part):
            out += joined(" ".join(part))
        elif part[:1] == ["fmt::format"]:
            out += pattern(part)
        else:
            out += "…"
    return out


def alternatives(tokens):
    """The hints of `condition ? hint : other`, also of nested ones; else the expression itself."""
    depth, conditions, asked = 0, 0, -1
    for i, token in enumerate(tokens):
        depth += (token in "([{") - (token in ")]}")
        if depth == 0 and token == "?":
            asked = i if conditions == 0 else asked
            conditions += 1
        elif depth == 0 and token == ":" and conditions > 0:
            conditions -= 1
            if conditions == 0:
                return alternatives(tokens[asked + 1:i]) + alternatives(tokens[i + 1:])
    return [tokens]


def name_of(option):
    """--grid of --grid NAME, :volume= of :volume=K."""
    if option.startswith(":"):
        return option[:option.find("=") + 1]
    return option.split(" ")[0] if option.startswith("--") else option


def listed(options, last_word):
    return f"{', '.join(options[:-1])} {last_word} {options[-1]}" if len(options) > 1 else options[0]


class Hints:
    """Words of hints, as cli/remedies.cpp prints them where the command has all options."""

    def __init__(self, root):
        source = (root / "src/cli/remedies.cpp").read_text()
        self.settings = {}
        for name, options, note in re.findall(
                r'case Setting::(\w+):\s*return \{\{((?:[^{}])*)\},\s*("(?:[^"\\]|\\.)*")\};', source):
            self.settings[name] = (re.findall(r'"([^"]*)"', options), joined(note))
        self.constants = {}
        for header in sorted((root / "src").rglob("*.hpp")):
            for name, literals in re.findall(r'constexpr const char\* (k\w+) =\s*((?:"(?:[^"\\]|\\.)*"\s*)+);', header.read_text()):
                self.constants[name] = joined(literals)

    def words(self, tokens):
        """The hint that an argument makes; empty if it is known only at run time."""
        if tokens[:1] == ["Hint"]:
            tokens = tokens[1:]
        if len(tokens) == 1 and tokens[0] in self.constants:
            return self.constants[tokens[0]]
        if tokens[:1] not in (["("], ["{"]):
            return pattern(tokens)
        args = arguments(tokens, 0)
        if args and args[0] and args[0][0].startswith("Remedy::"):
            return self.step(args)
        return "; ".join(filter(None, (self.words(arg) for arg in args if arg)))

    def step(self, args):
        """Does as step_words() of cli/remedies.cpp."""
        remedy = args[0][0].removeprefix("Remedy::")
        setting = args[1][0].removeprefix("Setting::") if len(args) > 1 else ""
        if setting not in self.settings:
            return ""
        options, note = self.settings[setting]
        text = self.words(args[2]) or "…" if len(args) > 2 and args[2] else ""
        name, names = name_of(options[0]), [name_of(option) for option in options]
        value = re.split("[ =]", options[0])[-1]
        one, every = listed(options, "or") + note, listed(options, "and")
        named = name + ("" if name.endswith("=") else " ") + text
        reason = f": {text}" if text else ""
        leaving = f"leave {names[0]} out" if len(names) == 1 else f"leave out {listed(names, 'and')}"
        return {
            "raise": f"give a larger {one}",
            "lower": f"give a smaller {one}",
            "give": f"give {every}{note}{reason}",
            "choose": f"choose one of them with {one}" + (f", {value} {text}" if text else ""),
            "change": f"choose another {one}" + (f" {text}" if text else ""),
            "leave_out": leaving + reason,
            "use": f"use {one}",
            "set": f"use {named}",
            "try_value": f"try {named}",
            "check": f"check {every}{reason}",
            "see": f"see {one}",
            "report": f"please report it and include the output of {one}",
        }[remedy]


def errors_of(room, source, hints):
    tokens = tokens_of(source)
    for i, token in enumerate(tokens[:-1]):
        if tokens[i + 1] not in ("(", "{"):
            continue
        if token in ("fail", "Error", "return") and i > 0 and tokens[i - 1] not in ("class", "struct"):
            args = arguments(tokens, i + 1)
            if not args or not args[0] or not args[0][0].startswith("ErrorCode::"):
                continue
            code, rest = args[0][0].removeprefix("ErrorCode::"), args[1:]
        elif token in BY_MESSAGE:
            args = arguments(tokens, i + 1)
            code, rest = BY_MESSAGE[token], args[:1] if token == "TruncatedFrame" else args  # its second text is no hint
        elif token == "expected_found":
            args = arguments(tokens, i + 1)
            expected = pattern(args[0]) if args else ""
            if expected:
                yield MessageError(room, f"expected {expected}, found '…'", EXIT_CODES["usage"], set())
            continue
        else:
            continue
        if not rest or not rest[0]:
            continue
        text = re.sub("……+", "…", pattern(rest[0]))
        if text.strip("…:, '"):
            words = [hints.words(hint) for hint in alternatives(rest[1])] if len(rest) > 1 and rest[1] else []
            yield MessageError(room, text, EXIT_CODES[code], {hint for hint in words if hint.strip("… ")})


def errors(root):
    hints = Hints(root)
    found = []
    for path in sorted((root / "src").rglob("*.cpp")):
        room = path.relative_to(root / "src").parts[0]
        found += errors_of(room, path.read_text(), hints)
    return found
