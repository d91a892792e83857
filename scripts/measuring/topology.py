"""Surfaces with the right topology."""

from measuring import programs, record
from measuring.tables import number, table

NAME = "topology"
TITLE = "Which meshes have the right topology"


def measure(setting):
    file = setting.folder / "topology.json"
    options = ["--fields", 200, "--quick"] if setting.quick else []
    # Runs the script by its first line: Debian's Python has VTK and scikit-image.
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
    return f"""How often each program's mesh has the topology of the trilinear field that it is extracted from. Each column has
{number(figures['fields'])} random fields of {size} x {size} x {size} samples, with the iso value 0:

- **uniform**: samples are uniform in -1 to 1.
- **near saddle**: as uniform, but one face or cell has a saddle whose value is 1e-6 to 1e-2 away from the iso value.
- **small integers**: samples are whole numbers from -2 to 2, so many samples and saddles have exactly the iso value.

A mesh is right if it has the true number of components and each has its true Euler number. The truth comes from sampling the
trilinear field on finer and finer grids and counting voxels; it is undecided for {number(figures['undecided'])} fields.

Where samples or saddles have exactly the iso value, two topologies are possible: those just above and just below it.
isoextract must match the one just above; the other programs count as right with either.

{table(["program", *(f"{kind.replace('_', ' ')}:" for kind in kinds)], rows)}
"""
