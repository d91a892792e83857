"""What the values of an attribute mean, which decides whether they turn with the mesh.

isoextract says it in its files: `"attributes": {"v": "vector"}` of the placement, without those that stay as they are.
Of files of other programs the names say it, by the same rules as in isoextract (src/base/attribute_kind.cpp).
"""

import json
import re

TURNING = ("vector", "point", "normal")
PROGRAM = "isoextract"
NAMES = (
    (r".*angular.*", None),
    (r"v|u|f|momenta|disp|impulse", "vector"),
    (r"n", "normal"),
    (r"p|pos|positions?|points?|pref|rest|restp|rest_position|coords?|coordinates?|location|center|centre", "point"),
    (r"vel.*|force.*|accel.*", "vector"),
    (r"normal.*", "normal"),
    (r".*(velocity|acceleration|displacement|momentum).*", "vector"),
)


def kind_by_name(name):
    """The kind of an attribute of three components that turns with the mesh, by its name; None: it stays as it is."""
    return next((kind for pattern, kind in NAMES if re.fullmatch(pattern, name, re.IGNORECASE | re.DOTALL)), None)


def kinds_in(placement):
    """{name: kind} of a placement, as text or as the JSON object that it is; {} of one that cannot be read."""
    if isinstance(placement, str):
        try:
            placement = json.loads(placement)
        except (ValueError, RecursionError):
            return {}
    kinds = placement.get("attributes", {}) if isinstance(placement, dict) else {}
    return kinds if isinstance(kinds, dict) else {}


def kind_of(name, width, kinds):
    """The kind of an attribute: `kinds` are those that the file has, or None where isoextract did not write it."""
    if width != 3:
        return None
    if kinds is None:
        return kind_by_name(name)
    kind = kinds.get(re.sub(r"[^A-Za-z0-9]", "_", name.encode("utf-8", "surrogateescape").decode("latin-1")))
    return kind if kind in TURNING else None
