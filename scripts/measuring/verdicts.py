"""STL files of unlike kinds: what admesh, PrusaSlicer, MeshLab and `isoextract check` say about them."""

from measuring import programs, record
from measuring.tables import number, table

NAME = "verdicts"
TITLE = "STL files in admesh, PrusaSlicer, MeshLab and check"


def measure(setting):
    file = setting.folder / "verdicts.json"
    # Runs the script by its first line: Debian's Python has SciPy.
    programs.run([record.ROOT / "scripts" / "compare_verdicts.py", "--isoextract", setting.isoextract, "--data", setting.data,
                  "--json", file])
    return record.read(file)


def cell(verdict):
    """The verdict of a program; number of parts and volume of a closed mesh."""
    if verdict["words"] != "closed":
        return verdict["words"]
    return f"closed, {number(verdict['parts'])}, {verdict['volume']:.6g}"


def verdict_table(rows):
    return table(["file", "triangles:", *rows[0]["verdicts"], ""],
                 [[f"`{row['file']}`", number(row["triangles"]), *map(cell, row["verdicts"].values()),
                   ("agree" if row["agree"] else "disagree") + ("" if row["as_expected"] else ": UNEXPECTED")]
                  for row in rows])


def page(measured):
    rows = measured["figures"]["rows"]
    return f"""The table shows for {len(rows)} STL files of different kinds whether three programs that weld vertices by position, and `isoextract check
--weld`, find the mesh closed. `open.stl`, `keep.stl` and `broken.stl` are deliberately not closed. Each cell has the verdict of the
program, and for a closed mesh its number of components and its volume.

{verdict_table(rows)}

`scripts/compare_verdicts.py` makes this table. It fails if the programs disagree, or if a file other than these three is not closed.
It also makes the inputs `label.npy`, `cells.npy` and `broken.stl` of the commands below.
The programs agree if all find the mesh closed, with equal numbers of components and volumes within 0.01 %. They also agree if none finds
it closed; if open edges are the only defects, their numbers must be equal.

- **Volumes** of admesh and PrusaSlicer are sums of float32 numbers; those of MeshLab and `check` are sums of doubles.
- **An edge of four triangles** (`keep.stl`) is two edges for admesh and PrusaSlicer, which pair its triangles in the order of the
  file. Pairs of triangles of different sheets then look reversed, or stay open. MeshLab and `check` count the edge once.
- **A missing and a doubled triangle** (`broken.stl`) leave three open edges and three edges of three triangles. admesh and
  PrusaSlicer count all six as open. `repaired.stl` is the same mesh after `--repair`.
- admesh fills holes before it counts reversed triangles, so the table omits this count for open meshes.
- None of the three other programs looks for self-intersections; [`check`](../check.md) does.
"""
