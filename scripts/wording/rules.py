"""The rules of wording. Each takes a text and its room, and yields (offset, what is wrong)."""

import functools
import multiprocessing
import re

from wording import glossary, texts

WORDS_AT_MOST = 35


def plain(text):
    """The text with a letter in place of each span of code or address, as long as before."""
    if not re.search("[`:(]", text):
        return text
    return re.sub(r"`[^`]*`|https?://\S+|\]\([^)]*\)", lambda found: "x" * len(found.group()), text)


def check_words(text, room):
    """Words that the glossary names otherwise."""
    is_name = text.kind == "name"
    words = glossary.name_as_text(text.words) if is_name else text.words
    lower = words.lower()
    for word in glossary.WORDS:
        if word.sign in lower and (word.in_names or not is_name):
            for found in word.hits(words, room):
                yield 0 if is_name else found.start(), f"'{found.group()}': {word.instead}"


SENTENCE_END = re.compile(r"(?<!\be\.g)(?<!\bi\.e)(?<!\bvs)(?<!\bet al)[.!?][\"')\]*_]*(?:\s+|$)|\n|<br>")


def check_length(text, _room):
    """Sentences of more than 35 words."""
    if text.kind == "name" or text.words.count(" ") < WORDS_AT_MOST:
        return
    words, start = plain(text.words), 0
    for end in [*(found.end() for found in SENTENCE_END.finditer(words)), len(words)]:
        count = sum(1 for word in words[start:end].split() if re.search(r"\w|\{\}", word))
        if count > WORDS_AT_MOST:
            yield start, f"{count} words in a sentence"
        start = end


# First words that leave the reader to find the noun.
SAME = r"the same(?=[,.;:]| (?:of|in|for|as|by|with|way)\b|$)"
RIDDLE = re.compile(
    rf"(Of|Or|What|That|Those|Whose|Likewise|{SAME.replace('the', 'The', 1)}|One that|Nothing|All that|It|Also(?! [a-z]+s\b)"
    r"|Some(?=[,.;:]| of\b| that\b)|(?:Where|As)(?=[^,.]*(?:\.|$)))(?=[\s,.;:]|$)"
)
RIDDLE_BEHIND = re.compile(rf"(what|that|those|whose|nothing|one that|all that|it|likewise|{SAME})(?=[\s,.;:]|$)", re.IGNORECASE)

# Words that end like a verb, and are one only before an object: "Leaves the mesh as it is."
PLURALS = set("""
Arguments Axes Bits Boxes Bytes Cells Chunks Columns Components Coordinates Corners Depths Edges Elements Entries Errors Faces
Files Frames Glyphs Grids Indices Items Labels Layers Leaves Lines Members Messages Meshes Normals Options Pages Pairs
Particles Pieces Pixels Positions Radii Rows Sentences Sides Sizes Surfaces Tiles Times Triangles Units Values Vertices Views
Volumes Voxels Weights Words
""".split())
OBJECT = re.compile(r"(the|a|an|every|each|all|no|its|both)\b|`")
NO_VERBS = {"As", "This", "Its", "Less", "Plus", "Across", "Towards"}
# What seldom follows a verb, but a plural: "Names of the fields".
AFTER_PLURAL = re.compile(r"(of|are|which|whose|have)\b")
BEGINNINGS = {"Whether", "True", "False", "Never", "Always", "Also", "Call", "Called", "Example"}
# Sentences with a subject and a verb: "All arguments must outlive the run.", "If there is none, returns the first."
FINITE = (
    r"\b(?:is|are|has|have|must|may|can|cannot|needs?|stays?|holds|counts|means|does|gets?|reach(?:es)?|decides?|includes?"
    r"|converts?|returns?|becomes?|keeps?|gives?|makes?|stores?|belongs?|begins?)\b"
)
SUBJECT = (
    r"(?:\([^()]*\)|(?!\b(?:that|which|who|whose|where|as|there|they|it|how|what|if|when)\b)[^.,:;()]){3,60}?"
)
SENTENCE = re.compile(
    r"(?!(?:How|Why|Before|After|For|By|In|On|At|From|To|With|Without|Into|Past|Until|Once|About|Beyond|Behind|Only|If|When|Step)"
    rf"\b){SUBJECT}{FINITE}"
    r"|(?:If|When|After|Before|Once|For|By default|Without|With|Step \d)\b(?:[^.:]|::)*?[,:]? "
    rf"(?:[a-z]+s (?:the|a|an|every|each|all|no|its|one|whether)\b|(?:the|a|an|every|each|no) {SUBJECT}{FINITE})"
    r"|Like \w+(?:::\w+|\(\)|_\w+)"
)


def begins_with_verb(words):
    first, _, rest = words.partition(" ")
    first = first.rstrip(",.:;")
    if first in BEGINNINGS:
        return True
    if first in PLURALS:
        return bool(OBJECT.match(rest))
    return first.endswith("s") and first not in NO_VERBS and not AFTER_PLURAL.match(rest)


FUNCTION = re.compile(r"~?\w+\s*\((?!\s*\*)")


def is_function(declaration):
    """Whether the code declares a function, and not a member, a type or a macro."""
    code = re.sub(r"\boperator\s*(\(\)|[^\s\w(]+)", "operator_", declaration)
    code = re.sub(r"\[\[.*?\]\]|\balignas\s*\([^)]*\)|\bexplicit\s*\(\w+\)", " ", code)
    code = re.sub(r"\brequires\s*\((?:[^()]|\([^()]*\))*\)", " ", code).strip()
    if re.match(r"#|(using|typedef|namespace|static_assert|enum|return|if|for|while|switch)\b|[A-Z_]+\(", code):
        return False
    longer = None
    while code != longer:  # arguments of templates go, the inner ones first
        longer, code = code, re.sub(r"<[^<>()]*>|<[^<>]*\([^<>]*\)[^<>]*>", " ", code)
    code = re.sub(r"^\s*template\s*", "", code)
    head = FUNCTION.search(code)
    before = code[: head.start()] if head else ""
    return bool(head) and not re.search(r"=|\.|->|\b(concept|struct|class|union)\b", before)


def check_comments(text, _room):
    """Comments of headers that begin without a noun; comments of functions that do not begin with a verb."""
    if not text.path.endswith((".hpp", ".h")) or text.kind not in ("comment", "trailing"):
        return
    words = text.words
    riddle = (RIDDLE if text.kind == "comment" else RIDDLE_BEHIND).match(words)
    if riddle:
        yield 0, f"begins with '{riddle.group()}': name what it is"
    elif text.declaration and is_function(text.declaration):
        first = re.match(r"[A-Z][a-z-]*(?=[\s,.:;]|$)", words)
        if first and not begins_with_verb(words) and not SENTENCE.match(words):
            yield 0, f"a function's comment begins with '{first.group()}': begin with a verb, such as Returns"


PASSIVE = re.compile(
    r"\b(?:is|are|was|were|be|been|being)\s+(?:not\s+|also\s+|only\s+|never\s+)?"
    r"(?P<done>\w{2,}ed|told|made|held|taken|given|kept|left|read|cut|written|chosen|drawn|done|shown|known"
    r"|thrown|found|meant|said|sent|put|set|built|lost|broken|hidden|begun)\b"
)
# States rather than deeds: who did it is of no concern.
STATES = set("""
needed allowed expected required supported closed limited connected truncated damaged corrupted compressed uncompressed oriented
unsigned bounded unbounded mixed encrypted aligned nested shared sorted unsorted indeed rotated sheared mirrored isolated
interlaced disabled enabled installed based unlimited related reversed undefined fixed named
""".split())


def check_passive(text, _room):
    """Messages that do not say who does it."""
    if text.kind != "message":
        return
    for found in PASSIVE.finditer(text.words):
        if found["done"] not in STATES:
            yield found.start(), f"'{found.group()}': say who does it"


# With the hyphens of an option in front.
WORD = re.compile(r"(?:--)?\w[\w-]*")


def check_spelling(text, _room):
    """British spellings."""
    if text.kind == "name":
        return [(0, f"'{text.words}': {glossary.british(text.words)}")] if glossary.british(text.words) else []
    if not glossary.BRITISH_SIGN.search(text.words.lower()):
        return []
    words = plain(text.words)
    return [
        (found.start(), f"'{found.group()}': {glossary.british(found.group())}")
        for found in WORD.finditer(words)
        if glossary.british(found.group()) and not found.group().startswith("--")
    ]


RULES = {
    "word": check_words,
    "long": check_length,
    "comment": check_comments,
    "passive": check_passive,
    "spelling": check_spelling,
}


def findings_of(root, path):
    """(line, rule, what is wrong, where) of one file."""
    room, findings = texts.room_of(path), []
    for text in texts.texts_of(root, path, glossary.looks_wrong):
        for rule, check in RULES.items():
            for offset, wrong in check(text, room):
                where = text.words[max(0, offset - 40) : offset + 80].replace("\n", " ").strip()
                findings.append((text.line(offset), rule, wrong, where))
    return sorted(findings)


def findings_of_all(root, paths):
    """(path, its findings) of each file, in their order."""
    with multiprocessing.Pool() as pool:
        return list(zip(paths, pool.imap(functools.partial(findings_of, root), paths, chunksize=40)))
