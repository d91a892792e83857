"""Numerical stability: extreme samples and transforms."""

import json

from measuring import programs, record
from measuring.tables import number, table

NAME = "stability"
TITLE = "Numerical stability: extreme samples and transforms"
WORST = ("ulps", "voxels")


def described(text):
    """Reads `isoextract stability --list`: for each case, what is extreme and the result of plain float32."""
    found, name = {}, None
    for line in text.splitlines():
        if not line.startswith(" "):
            name = line.strip()
            found[name] = {"extreme": "", "plain": ""}
        elif line.strip().startswith("Plain float32: "):
            found[name]["plain"] = line.strip().removeprefix("Plain float32: ")
        else:
            found[name]["extreme"] = line.strip()
    return found


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    chosen = ["--case", "jump", "--case", "mirrored"] if setting.quick else []
    rows = json.loads(programs.run([setting.isoextract, "stability", *chosen, "--json"]))["rows"]
    texts = described(programs.run([setting.isoextract, "stability", "--list"]))
    cases = {}
    for row in rows:
        case = cases.setdefault(row["case"], {"case": row["case"], **texts[row["case"]], "runs": 0, "passed": 0,
                                              **{key: 0 for key in WORST}})
        case["runs"] += 1
        case["passed"] += row["passed"]
        for key in WORST:
            case[key] = max(case[key], row[key] or 0)
    figures = {"methods": sorted({row["method"] for row in rows}), "backends": sorted({row["backend"] for row in rows}),
               "ulps_allowed": max(row["ulps_allowed"] for row in rows if row["ulps_allowed"] is not None), "cases": list(cases.values())}
    command = programs.shown(["isoextract", "stability", *chosen])
    return measured.finish([record.cores()], {}, [command, "isoextract stability --list"], figures)


def page(measured):
    figures = measured["figures"]
    rows = [[f"`{case['case']}`", case["extreme"], f"{case['passed']} of {case['runs']}", number(case["ulps"], 2),
             case["plain"]] for case in figures["cases"]]
    methods = " and ".join(f"`{name}`" for name in figures["methods"])
    backends = " and ".join(f"`{name}`" for name in figures["backends"])
    return f"""`isoextract stability` extracts extreme fields by {methods} on {backends}, without and with a cap. It checks that every vertex is finite
and inside its grid edge, that no two vertices coincide, and that no triangle has zero area. The mesh must be closed where the options
require it. *Off by* is the largest distance of a vertex from the crossing computed in long double, in units in the last place of the
mesh's local coordinates; {number(figures['ulps_allowed'])} are allowed.

*Plain float32* says how the same case fails (or *survives*) if crossings and positions are computed in float32 only. The unit tests of
`bench` check for each case which of the two it is.

{table(["case", "what is extreme", "passes", "off by, ulps:", "plain float32"], rows)}
"""
