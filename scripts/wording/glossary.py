"""Words that the project does not use, with what it uses instead and where they are right all the same."""

import dataclasses
import re


@dataclasses.dataclass
class Word:
    """`pattern` is looked for without regard to case, `allowed` around it; `rooms` are where it is looked for (all)."""

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
    Word(r"\bpieces?\b", "component, or body", r"--\w*pieces?|\{pieces?\}|`[^`]*`|\S+\.md\S*|\w+[/.]pieces\b"
         r"|pieces? of (?!a surface|the surface|the mesh|a mesh)\w+( \w+)?|\bpiece by piece|'?pieces'|\"pieces?\""
         r"|[A-Za-z]+ piece \d", OF_SURFACES),
    Word(r"\bcrumbs?\b", "small component", in_names=True),
    Word(r"\blids?\b", "cap", in_names=True),
    Word(r"\bborders?\b", "data boundary, or boundary edge", r"border(-\w+)?:|border-\w+|(room's|their) borders?", in_names=True),
    Word(r"\bhollows?\b", "cavity", in_names=True),
    Word(r"\bnecks?\b", "pinch point", in_names=True),
    Word(r"\bthings?\b", "the name of the thing", in_names=True),
    Word(r"\bthresholds?\b", "iso value", r"Otsu's threshold|--[\w-]*threshold"),
    Word(r"\biso[- ]levels?\b", "iso value"),
    Word(r"\b(right|wrong) side\b", "inside, or outside"),
    Word(r"\bend of the (data|grid|volume|mesh)\b", "data boundary, or boundary loop"),
    Word(r"\bhangs? together\b", "are connected"),
    Word(r"\b(joins?|joined|joining) ((the|two|equal|all|their) )*vertices\b|\bvertices (\w+ ){0,2}joined\b", "weld"),
    Word(r"\bwhat( may|) helps?\b", "remedy, or hint"),
    Word(r"\bwhat a vertex has\b", "attribute"),
    Word(r"\bwhat may be moved\b", "tolerance"),
    Word(r"\b(gave|gives?|given|giving) way\b|gave_way|give_way", "fall back to", in_names=True),
    Word(r"\b(held|holds?|holding) (?!back)(\w+ ){0,5}against\b", "compare with"),
    Word(r"\b(is|are|was|were|be|been) told\b", "who says it: reports, names, lists"),
    Word(r"\bthat which\b|\bwhat is there\b", "the name of the thing"),
    Word(r"\btorn\b", "truncated", in_names=True),
    Word(r"\bmend(s|ed|ing)?\b", "fix, or repair", in_names=True),
    Word(r"\bbeliev(e|es|ed|ing)\b", "trust, or check"),
    Word(r"\b(nobody|somebody|everybody|anybody|whoever)\b", "the caller, the user, no room ...", in_names=True),
]

ANY_WORD = re.compile("|".join(word.pattern for word in WORDS), re.IGNORECASE)

# British spellings: a pattern of the British part of a word, and the American one.
BRITISH = [
    (r"colour", "color"), (r"neighbour", "neighbor"), (r"behaviour", "behavior"), (r"favour", "favor"), (r"honour", "honor"),
    (r"\bgrey", "gray"), (r"(?<![a-z])grey", "gray"), (r"centre", "center"), (r"centring", "centering"),
    (r"\b(kilo|centi|milli|micro)?metre", "meter"), (r"\blitre", "liter"), (r"fibre", "fiber"), (r"\bcalibre", "caliber"),
    (r"(normal|quant|optim|initial|vector|stabil|organ|recogn|minim|maxim|serial|summar|visual|parallel|raster|discret"
     r"|polygon|general|linear|random|standard|sanit|final|synchron|special|voxel|util|character|emphas|priorit|custom|factor"
     r"|local|penal|regular|symmetr|orthogonal|diagonal|equal|author|material|canonical|token|real|memor|item|categor"
     r"|penal|capital|neutral|homogen|tetrahedral|triangul)is(e|es|ed|er|ers|ing|ation|ations)(?![a-z])", "-ize"),
    (r"analys(e|ed|ing|er)(?![a-z])", "analyze"), (r"(label|model|travel|signal|level|channel|tunnel)l(ed|ing|er)(?![a-z])", "one l"),
    (r"artefact", "artifact"), (r"catalogue", "catalog"), (r"\bdefence", "defense"), (r"\blicence", "license"),
    (r"\bwhilst\b", "while"), (r"\bprogramme", "program"), (r"\bmould", "mold"), (r"judgement", "judgment"),
]  # fmt: skip
ANY_BRITISH = re.compile("|".join(f"(?:{pattern})" for pattern, _ in BRITISH), re.IGNORECASE)


def american(word):
    """How the British word found is spelled in American English, or its ending."""
    return next(instead for pattern, instead in BRITISH if re.search(pattern, word, re.IGNORECASE))


# Identifiers that the rules look at: any with one of these letters in a row; what they mean is decided part by part.
NAMES = re.compile(
    r"\b\w*(?:crumb|lid|border|hollow|neck|thing|gave_way|give_way|torn|mend|nobody|somebody|everybody|anybody|whoever"
    r"|our|grey|ntr[ei]|etre|itre|ibre|is[ei]|isa|ys[ei]|ll[ei]|artef|catal|efence|icence|whilst|programme|mould|judge)\w*",
    re.IGNORECASE,
)  # fmt: skip


def name_as_text(name):
    """`kBorderCap_x` as "border cap x"."""
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    return " ".join(part.lower() for part in parts)
