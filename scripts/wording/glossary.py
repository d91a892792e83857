"""Words that the project does not use, with what it uses instead and where they are right all the same."""

import dataclasses
import functools
import re


@dataclasses.dataclass
class Word:
    """A word to avoid: `pattern`, without regard to case, unless `allowed` covers it. `rooms`: where; empty: all."""

    sign: str  # in every match, in lower case: most texts are left out by it, faster
    pattern: str
    instead: str
    allowed: str = r"(?!)"
    rooms: tuple = ()
    in_names: bool = False  # also as a part of an identifier, between '_' or capitals

    def __post_init__(self):
        self.finder = re.compile(self.pattern, re.IGNORECASE)
        self.exception = re.compile(self.allowed, re.IGNORECASE)

    def hits(self, text, room):
        """Matches in the text that no match of `allowed` covers."""
        if self.rooms and room not in self.rooms:
            return
        for found in self.finder.finditer(text):
            if not any(a.start() <= found.start() < a.end() for a in self.exception.finditer(text)):
                yield found


# Where a piece is a part of a surface; elsewhere files and memory have pieces.
OF_SURFACES = ("src/edit", "src/mesh", "src/check", "src/convert", "src/batch", "src/cli", "docs", "README", "CHANGELOG")

WORDS = [
    Word("piece", r"\bpieces?\b", "component, or body", r"--\w*pieces?|\{pieces?\}|`[^`]*`|\S+\.md\S*|\w+[/.]pieces\b"
         r"|pieces? of (?!a surface|the surface|the mesh|a mesh)\w+( \w+)?|\bpiece by piece|'?pieces'|\"pieces?\""
         r"|(^|[A-Za-z]+) ?piece (\d|\{)", OF_SURFACES),
    Word("crumb", r"\bcrumbs?\b", "small component", in_names=True),
    Word("lid", r"\blids?\b", "cap", in_names=True),
    Word("border", r"\bborders?\b", "data boundary, or boundary edge", r"border(-\w+)?:|border-\w+|(room's|their|ear's) borders?"
         r"|borders? (of|between) (the |two )?labels|borders in common|(common|label|patch) borders?|borders? of a rectangle"
         r"|^border vertices$",
         in_names=True),
    Word("neck", r"\bnecks?\b", "pinch point", in_names=True),
    Word("thing", r"\bthings?\b", "the name of the thing", in_names=True),
    Word("threshold", r"\bthresholds?\b", "iso value", r"Otsu's threshold|--[\w-]*threshold",
         ("src/cli", "src/convert", "docs", "README", "CHANGELOG")),
    Word("iso", r"\biso[- ]levels?\b", "iso value"),
    Word("side", r"\b(right|wrong) side\b", "inside, or outside", r"from the (right|wrong) side"),
    Word("end of the", r"\bend of the (data|grid|volume|mesh)\b", "data boundary, or boundary loop"),
    Word("together", r"\bhangs? together\b", "are connected"),
    Word("vertices", r"\b(joins?|joined|joining) ((the|two|equal|all|their) )*vertices\b|\bvertices (\w+ ){0,2}joined\b", "weld"),
    Word("help", r"\bwhat( may|) helps?\b", "remedy, or hint"),
    Word("vertex has", r"\bwhat a vertex has\b", "attribute"),
    Word("may be moved", r"\bwhat may be moved\b", "tolerance"),
    Word("way", r"\b(gave|gives?|given|giving) way\b|gave_way|give_way", "fall back to", in_names=True),
    Word("against", r"\b(held|holds?|holding) (?!back)(\w+ ){0,5}against\b", "compare with"),
    Word("told", r"\b(is|are|was|were|be|been) told\b(?! (apart|from))", "who says it: reports, names, lists"),
    Word("that which", r"\bthat which\b", "the name of the thing"),
    Word("what is there", r"\bwhat is there\b", "the name of the thing"),
    Word("torn", r"\btorn\b", "truncated", in_names=True),
    Word("mend", r"\bmend(s|ed|ing)?\b", "fix, or repair", in_names=True),
    Word("believ", r"\bbeliev(e|es|ed|ing)\b", "trust, or check"),
    Word("whoever", r"\bwhoever\b", "the caller, the user, a room ...", in_names=True),
    Word("body", r"\b(no|some|every|any)body\b", "the caller, the user, no room ...", in_names=True),
]

# British spellings: a pattern of the British part of a word, and the American one.
BRITISH = [
    (r"colour", "color"), (r"neighbour", "neighbor"), (r"behaviour", "behavior"), (r"favour", "favor"), (r"honour", "honor"),
    (r"\bgrey", "gray"), (r"(?<![a-z])grey", "gray"), (r"centre", "center"), (r"centring", "centering"),
    (r"\b(kilo|centi|milli|micro)?metre", "meter"), (r"\blitre", "liter"), (r"fibre", "fiber"), (r"\bcalibre", "caliber"),
    (r"(normal|quant|optim|initial|vector|stabil|organ|recogn|minim|maxim|serial|summar|visual|parallel|raster|discret"
     r"|polygon|general|linear|random|standard|sanit|final|synchron|special|voxel|util|character|emphas|priorit|custom|factor"
     r"|local|penal|regular|symmetr|orthogonal|diagonal|equal|author|material|canonical|token|real|memor|item|categor"
     r"|penal|capital|neutral|homogen|tetrahedral|triangul)is(e|es|ed|er|ers|ing|ation|ations)(?![a-z])", "-ize"),
    (r"(?<![a-z])(re)?analys(e|ed|ing|er)(?![a-z])", "analyze"),
    (r"(label|model|travel|signal|level|channel|tunnel)l(ed|ing|er)(?![a-z])", "one l"),
    (r"artefact", "artifact"), (r"catalogue", "catalog"), (r"\bdefence", "defense"), (r"\blicence", "license"),
    (r"\bwhilst\b", "while"), (r"\bprogramme", "program"), (r"\bmould", "mold"), (r"judgement", "judgment"),
]  # fmt: skip
ANY_BRITISH = re.compile("|".join(f"(?:{pattern})" for pattern, _ in BRITISH), re.IGNORECASE)
# In every British word, in lower case: faster than the above.
BRITISH_SIGN = re.compile(r"[lbvn]i?our|avour|grey|ntr|etre|[ib]bre|itre|is[ei]|isa|ys[ei]|ll[ei]|artef|catal|efence|icence"
                          r"|whils|programme|mould|judge")  # fmt: skip


@functools.cache
def british(word):
    """How American English spells the British part of a word; None where it has none."""
    if not BRITISH_SIGN.search(word.lower()):
        return None
    found = ANY_BRITISH.search(word)
    return found and next(instead for pattern, instead in BRITISH if re.search(pattern, found.group(), re.IGNORECASE))


def name_as_text(name):
    """`kTileCap_x` as "k tile cap x"."""
    return " ".join(re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)).lower()


NAME_SIGN = re.compile("|".join(word.sign for word in WORDS if word.in_names))


@functools.cache
def looks_wrong(name):
    """Whether a rule finds something in the identifier."""
    if british(name):
        return True
    if not NAME_SIGN.search(name.lower()):
        return False
    return any(word.in_names and word.finder.search(name_as_text(name)) for word in WORDS)
