#!/usr/bin/python3
"""Closed or not: what admesh, PrusaSlicer and MeshLab say about STL files, beside `isoextract check`.

    scripts/compare_verdicts.py [--data FOLDER] [--isoextract FILE] [--json FILE]

Makes STL files of unlike kinds by the commands of CASES, from the volumes of the tests (ISOEXTRACT_DATA, or shared/data
beside the checkout). Prints a table with a row for each file: whether each program finds the mesh closed, and its
volume. All four must agree about that; on the number of parts and the volume if it is closed; on the number of open
edges if these are its only defects. Only the files of NOT_CLOSED may be open or not manifold.

Needs Debian's packages admesh, prusa-slicer, meshlab, xvfb, xauth, python3-numpy and python3-scipy
(scripts/setup.sh viewers), and runs with Debian's own python3. scripts/measure makes a page of the file that --json
writes. Ends with 0 if the verdicts are as expected, 1 if not, 2 if something is missing.
"""

import argparse
import dataclasses
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

from measuring import programs, record
from measuring.tables import number
from measuring.verdicts import verdict_table

# Volumes may differ by this part: admesh and PrusaSlicer add float32 numbers.
VOLUME_TOLERANCE = 1e-4
PARTS = ("closed", "manifold", "oriented", "outward", "no-zero-area", "no-duplicates")

# Commands with the files that they make. med, mol and so on are folders of the data; the other inputs are made first.
PRINTABLE = "--cap --triangles 50000 --require printable"
CASES = (
    ("isoextract med/HeadMRVolume.raw --dims 48,62,42 --dtype u8 --iso 60 --cap -o head.stl", ["head"]),
    ("isoextract med/HeadMRVolume.raw --dims 48,62,42 --dtype u8 --iso 60 -o open.stl", ["open"]),
    ("isoextract med/tooth.nhdr --iso 500 --cap --blur 1 --largest --fill-cavities --smooth 10:sinc -o tooth.stl", ["tooth"]),
    ("isoextract med/tooth.nhdr --iso 500 --cap --largest --hollow 3voxel --require printable -o hollow.stl", ["hollow"]),
    (f"isoextract med/MR.nii.gz --iso 120 --voxel-size 2 {PRINTABLE} -o mr.stl", ["mr"]),
    (f"isoextract med/FLAIR.nrrd --iso 60 {PRINTABLE} -o brain.stl", ["brain"]),
    (f"isoextract vdb/smoke.vdb --iso 0.5 {PRINTABLE} -o smoke.stl", ["smoke"]),
    ("isoextract vdb/sphere.vdb --iso 0 --method mt -o sphere.stl", ["sphere"]),
    ("isoextract mol/betaGal.npy --iso 0.05 --clip 1,2,0.3,140 --cap -o cut.stl", ["cut"]),
    ("isoextract vdb/c42_gas_seq/fluid_data_0010.vdb --grid density --iso 0.5 --simplify 0.1 -o gas.stl", ["gas"]),
    ("isoextract terrain/jacksboro_elevation.npy --heightfield --base 0 -o terrain.stl", ["terrain"]),
    ("isoextract particles/octocat_32614_particles.bgeo --radius 0.025 --iso 0.6 -o octocat.stl", ["octocat"]),
    ("isoextract med/FLAIR.nrrd --iso 60 --voxel-size 2 --method surface-nets -o mask.stl", ["mask"]),
    ("isoextract med/FLAIR.nrrd --iso 60 --voxel-size 2 --method voxels -o voxels.stl", ["voxels"]),
    ("isoextract med/FLAIR.nrrd --iso 60 --voxel-size 2 --method voxels --touching keep -o keep.stl", ["keep"]),
    ("isoextract label.npy --voxel-size 3 --labels all -o 'label_{label}.stl'", ["label_1", "label_3", "label_5"]),
    ("isoextract cells.npy --labels 7 --triangles 10% -o cell.stl", ["cell"]),
    ("isoextract broken.stl --repair --require printable -o repaired.stl", ["broken", "repaired"]),
    ("isoextract 'demo:random?size=24' --iso 0.3 --cap --require printable -o noise.stl", ["noise"]),
)
NOT_CLOSED = ("open", "keep", "broken")  # the other files must be closed


@dataclasses.dataclass
class Verdict:
    open_edges: int
    defects: str  # in words; empty if there are none besides open edges
    parts: int
    volume: float | None

    def closed(self):
        return self.open_edges == 0 and not self.defects

    def words(self):
        found = [f"{number(self.open_edges)} open edges"] * (self.open_edges > 0) + [self.defects] * bool(self.defects)
        return ", ".join(found) or "closed"


def counts_in_words(counts):
    return ", ".join(f"{number(count)} {what}" for what, count in counts.items() if count)


def answer(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, errors="replace", check=False)
    return done.stdout + done.stderr


def first(pattern, text, kind=int, default=None):
    found = re.search(pattern, text, re.MULTILINE)
    if not found and default is None:
        raise programs.Failed(f"no '{pattern}' in:\n{text}")
    return kind(found[1]) if found else default


def by_admesh(path):
    told = answer(["admesh", path])
    edges = sum(count * first(rf"^Facets with {count} disconnected edges? +: +(\d+)", told) for count in (1, 2, 3))
    counts = {what: first(rf"^{name} +: +(\d+)", told) for name, what in (
        ("Degenerate facets", "degenerate"), ("Facets reversed", "reversed"), ("Backwards edges", "backwards edges"))}
    # admesh counts reversed facets and measures the volume after it has filled holes.
    return Verdict(edges, "" if edges else counts_in_words(counts), first(r"^Number of parts +: +(\d+)", told),
                   None if edges else first(r"Volume +: +(\S+)", told, float))


def by_prusa(path):
    told = answer(["prusa-slicer", "--info", path])
    edges = first(r"^open_edges = (\d+)", told, default=0)
    counts = {name.replace("_", " "): first(rf"^{name} = +(\d+)", told, default=0)
              for name in ("degenerate_facets", "edges_fixed", "facets_removed", "facets_reversed", "backwards_edges")}
    counts["defects that it does not name"] = first(r"^manifold = (\w+)", told, str) == "no" and not edges
    return Verdict(edges, counts_in_words(counts), first(r"^number_of_parts = +(\d+)", told),
                   first(r"^volume = (\S+)", told, float))


def by_meshlab(path):
    script = path.with_suffix(".mlx")
    script.write_text('<!DOCTYPE FilterScript>\n<FilterScript>\n <filter name="Compute Topological Measures"/>\n'
                      ' <filter name="Compute Geometric Measures"/>\n</FilterScript>\n')
    told = answer(["xvfb-run", "-a", "meshlabserver", "-i", path, "-s", script])
    counts = {f"crossed {what}": first(rf"^Mesh has (\d+) non two manifold {names}", told, default=0)
              for what, names in (("edges", "edges"), ("vertices", "vertices|vertexes"))}
    return Verdict(first(r"^Boundary Edges (\d+)", told), counts_in_words(counts),
                   first(r"^Mesh is composed by (\d+) connected", told),
                   first(r"^Mesh Volume +is (\S+)", told, float, default=float("nan")))


def by_check(program, path):
    report = path.with_suffix(".json")
    answer([program, "check", path, "--weld", "--require", ",".join(PARTS), "--report", report])
    told = json.loads(report.read_text())
    mesh = told["mesh"]
    counts = {"crossed edges": mesh["nonmanifold_edges"], "crossed vertices": mesh["nonmanifold_vertices"]}
    others = [f"not {row['requirement']}" for row in told["required"][2:] if not row["met"]]
    return Verdict(mesh["open_edges"], ", ".join([*filter(None, [counts_in_words(counts)]), *others]), mesh["components"],
                   mesh["volume"])


def write_broken(source, path):
    """An STL file with one triangle turned, one missing, and one twice."""
    data = source.read_bytes()
    rows = [data[start:start + 50] for start in range(84, len(data), 50)]
    rows[100] = rows[100][:12] + rows[100][24:36] + rows[100][12:24] + rows[100][36:]
    rows[200] = rows[300]
    path.write_bytes(data[:84] + b"".join(rows))


def make_inputs(program, data, folder):
    for room in data.iterdir():
        (folder / room.name).symlink_to(room.resolve())
    maps = [sys.executable, record.ROOT / "scripts" / "measuring" / "label_maps.py"]
    programs.run([*maps, "head", data / "med" / "ch2.nii.gz", folder / "label.npy"])
    programs.run([*maps, "cells", 64, 30, "u2", folder / "cells.npy"])
    programs.run([program, data / "mol" / "m4_TotalDensity.nrrd", "--iso", "0.05", "-q", "-o", folder / "molecule.stl"])
    write_broken(folder / "molecule.stl", folder / "broken.stl")


def agree(verdicts):
    closed = {verdict.closed() for verdict in verdicts.values()}
    if closed == {True}:
        volumes = [verdict.volume for verdict in verdicts.values()]
        return (len({verdict.parts for verdict in verdicts.values()}) == 1
                and max(volumes) - min(volumes) <= VOLUME_TOLERANCE * abs(volumes[-1]))
    # An edge of three or four triangles is an open edge for some programs.
    only_open = not any(verdict.defects for verdict in verdicts.values())
    return closed == {False} and (not only_open or len({verdict.open_edges for verdict in verdicts.values()}) == 1)


def compare(program, data, folder):
    """A row for each file."""
    make_inputs(program, data, folder)
    rows = []
    for command, names in CASES:
        programs.run([program, *shlex.split(command)[1:], "-q"], cwd=folder)
        for name in names:
            path = folder / f"{name}.stl"
            verdicts = {"admesh": by_admesh(path), "PrusaSlicer": by_prusa(path), "MeshLab": by_meshlab(path),
                        "isoextract": by_check(program, path)}
            as_expected = agree(verdicts) and verdicts["isoextract"].closed() == (name not in NOT_CLOSED)
            rows.append({"file": f"{name}.stl", "command": command, "triangles": (path.stat().st_size - 84) // 50,
                         "agree": agree(verdicts), "as_expected": as_expected,
                         "verdicts": {who: {"words": verdict.words(), "parts": verdict.parts, "volume": verdict.volume}
                                      for who, verdict in verdicts.items()}})
            print(f"{name} {'' if as_expected else 'UNEXPECTED'}", file=sys.stderr)
    return rows


def versions():
    return {name: programs.run(["dpkg-query", "-W", "-f", "${Version}", package])
            for name, package in (("admesh", "admesh"), ("PrusaSlicer", "prusa-slicer"), ("MeshLab", "meshlab"))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, help="folder of real volumes",
                        default=os.environ.get("ISOEXTRACT_DATA", record.ROOT / ".." / "shared" / "data"))
    parser.add_argument("--isoextract", type=pathlib.Path, default=record.ROOT / "build" / "release" / "isoextract",
                        help="the program (default: build/release/isoextract)")
    parser.add_argument("--json", type=pathlib.Path, help="write all figures to this file")
    options = parser.parse_args()
    missing = [name for name in ("admesh", "prusa-slicer", "meshlabserver", "xvfb-run") if not shutil.which(name)]
    if missing:
        print(f"not installed: {', '.join(missing)}; scripts/setup.sh viewers installs them", file=sys.stderr)
        return 2
    measured = record.Record("verdicts", options.isoextract, False) if options.json else None
    try:
        with tempfile.TemporaryDirectory() as folder:
            rows = compare(options.isoextract.resolve(), options.data.resolve(), pathlib.Path(folder))
    except programs.Failed as error:
        print(f"compare_verdicts: {error}", file=sys.stderr)
        return 2
    print(verdict_table(rows))
    if options.json:
        record.write(measured.finish([record.cores()], versions(), [command for command, _ in CASES], {"rows": rows}),
                     options.json)
    unexpected = [row["file"] for row in rows if not row["as_expected"]]
    print(f"{len(rows)} files; not as expected: {', '.join(unexpected) or 'none'}")
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
