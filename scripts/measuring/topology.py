"""Surfaces with the right topology."""

from measuring import programs, record
from measuring.tables import number, table

NAME = "topology"
TITLE = "Which meshes have the right topology"


def measure(setting):
    file = setting.folder / "topology.json"
    options = ["--fields", 200, "--quick"] if setting.quick else []
    # By its first line, because Debian's VTK and scikit-image are for Debian's Python.
    programs.run([record.ROOT / "scripts" / "compare_topology.py", "--isoextract", setting.isoextract, *options,
                  "--json", file])
    return record.read(file)


def page(measured):
    figures, versions = measured["figures"], measured["versions"]
    kinds = list(figures["rows"][0]["right"])
    rows = []
    for row in figures["rows"]:
        name = f"{row['program']} {versions[row['program']]} {row['method']}"
        rows.append([name, *(f"{100 * row['right'][kind] / figures['fields']:.2f} %" for kind in kinds)])
    size = figures["samples"]
    return f"""Random fields of {size} x {size} x {size} samples, {number(figures['fields'])} a column. A surface is right when each of its components has
the right Euler number; the truth is counted in voxels of the refined trilinear field, which leaves {number(figures['undecided'])} of all fields
undecided. In small integers many samples and saddles have the very iso value; there other programs may be right on
either side of it.

{table(["program", *(f"{kind.replace('_', ' ')}:" for kind in kinds)], rows)}
"""
