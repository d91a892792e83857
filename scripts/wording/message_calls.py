"""The errors that the code makes: text, exit code and hint of each call, with … for what is known only at run time."""

import dataclasses
import re

TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\'|[A-Za-z_][\w]*(?:::[A-Za-z_]\w*)*|->|::|\s+|.', re.S)
EXIT_CODES = {"usage": 1, "input": 2, "empty_grid": 2, "no_surface": 2, "out_of_memory": 2, "unavailable": 3, "output": 4,
              "frames": 5, "verification": 6, "cancelled": 130}
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


def pattern(tokens):
    """The text of an expression: its literals, with … for everything else. Empty if it has no literal."""
    if tokens[:1] == ["fmt::format"]:
        tokens = arguments(tokens, 1)[0]
        return re.sub(r"\{\{|\}\}|\{[^{}]*\}", lambda found: {"{{": "{", "}}": "}"}.get(found[0], "…"), pattern(tokens))
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


class Hints:
    """Words of hints, by cli/remedies.cpp."""

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
        self.verbs = {"raise": "give a larger", "lower": "give a smaller", "give": "give", "choose": "choose one with",
                      "change": "choose another", "leave_out": "leave out", "use": "use", "set": "use", "try_value": "try",
                      "check": "check", "see": "see", "report": "please report it with"}

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
        return ", or ".join(filter(None, (self.words(arg) for arg in args if arg)))

    def step(self, args):
        remedy = args[0][0].removeprefix("Remedy::")
        setting = args[1][0].removeprefix("Setting::") if len(args) > 1 else ""
        if setting not in self.settings or remedy not in self.verbs:
            return ""
        options, note = self.settings[setting]
        value = self.words(args[2]) if remedy in ("set", "try_value") and len(args) > 2 else ""
        if value.strip("… "):
            return f"{self.verbs[remedy]} {re.split('[ =]', options[0])[0]} {value}"
        both = " and " if remedy in ("give", "leave_out", "check") else " or "
        shown = options if len(options) < 3 else [*options[:2], "…"]
        return f"{self.verbs[remedy]} {both.join(shown)}{note}"


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
        text = pattern(rest[0])
        if text.strip("…:, '"):
            hint = hints.words(rest[1]) if len(rest) > 1 and rest[1] else ""
            yield MessageError(room, text, EXIT_CODES[code], {hint} if hint.strip("… ") else set())


def errors(root):
    hints = Hints(root)
    found = []
    for path in sorted((root / "src").rglob("*.cpp")):
        room = path.relative_to(root / "src").parts[0]
        found += errors_of(room, path.read_text(), hints)
    return found
