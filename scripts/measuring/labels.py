"""Surfaces of label maps: beside VTK's discrete ones, whether they meet, and how near balls come to their size."""

import json
import math
import shutil

from measuring import processes, programs, record
from measuring.tables import median, number, table

NAME = "labels"
TITLE = "Surfaces of label maps"
PYTHON = "/usr/bin/python3"  # which has NumPy, and VTK
SCRIPT = record.ROOT / "scripts" / "measuring" / "label_maps.py"
WAYS = (("surface nets", ()), ("surface nets, not smoothed", ("--relax", "0")), ("voxels", ("--method", "voxels")))
PEERS = (("vtkDiscreteMarchingCubes", "cubes"), ("vtkDiscreteFlyingEdges3D", "edges"),
         ("vtkDiscreteFlyingEdges3D, vtkWindowedSincPolyDataFilter", "edges+sinc"))
LABELS = "1,2,3,4,5"


def script(*arguments):
    return programs.run([PYTHON, SCRIPT, *arguments])


def converted(setting, path, *options):
    report = setting.folder / "report.json"
    programs.run([setting.isoextract, path, "--labels", LABELS, *options, "-o", setting.folder / "part_{iso}.ply", "--report",
                  report, "-q"])
    return json.loads(report.read_text())


def all_labels_ms(report):
    """What a conversion took to extract the surfaces of all labels: a report has the stages of each."""
    return 1000 * sum(stage["wall_seconds"] for stage in report["stages"] if stage["stage"] in programs.EXTRACTION)


def head(setting, rounds):
    path = setting.folder / "head.npy"
    script("head", setting.data / "med" / "ch2.nii.gz", path)
    rows = []
    for way, options in WAYS:
        reports = [converted(setting, path, *options) for _ in range(rounds)]
        rows.append({"way": f"isoextract, {way}", "ms": [all_labels_ms(report) for report in reports],
                     "triangles": sum(mesh["triangles"] for mesh in reports[0]["meshes"]),
                     "area": sum(mesh["area"] for mesh in reports[0]["meshes"]),
                     "closed": all(mesh["closed"] for mesh in reports[0]["meshes"])})
    converted(setting, path)
    meet = json.loads(script("meet", path, setting.folder / "part_{iso}.ply"))
    versions = {}
    for way, peer in PEERS:
        figures = json.loads(script("vtk", path, peer, rounds))
        versions["VTK"] = figures.pop("vtk")
        rows.append({"way": way, **figures})
    return rows, meet, versions


def balls(setting):
    rows = []
    for radius in (5, 10, 20) if setting.quick else (5, 10, 20, 40, 80):
        path = setting.folder / "ball.npy"
        script("ball", radius, path)
        row = {"radius": radius}
        for word, options in (("nets", ()), ("voxels", ("--method", "voxels"))):
            mesh = programs.convert(setting, path, "--labels", "1", *options)["meshes"][0]
            row[word] = {"area": mesh["area"] / (4 * math.pi * radius ** 2),
                         "volume": mesh["volume"] / (4 / 3 * math.pi * radius ** 3)}
        rows.append(row)
    return rows


# Side, labels, type.
MAPS = ((64, 512, "u2"), (64, 1000, "u2"), (64, 2197, "u2"), (64, 4096, "u2"), (256, 3000, "u4"), (256, 3000, "u8"),
        (256, 32768, "u4"), (512, 100000, "u8"))


def cells(setting, rounds):
    """What thousands of labels take, with reading and writing; and scikit-image, one label after the other."""
    rows = []
    path = setting.folder / "cells.npy"
    for side, count, kind in MAPS[:1] if setting.quick else MAPS:
        script("cells", side, count, kind, path)
        about = {"side": side, "labels": count, "type": kind, "input_mib": path.stat().st_size / 2**20}
        large = side > 256
        for output in ("{label}.ply",) if large else ("{label}.ply", "cells.glb"):
            for _ in range(1 if large else rounds):
                command = [setting.isoextract, path, "--labels", "all", "-o", setting.folder / "out" / output, "--mkdir", "-q"]
                rows.append(about | {"output": output, **processes.run_once(command)})
                shutil.rmtree(setting.folder / "out")
        if kind != "u8":  # find_objects() makes a list as long as the largest label
            rows.append(about | {"output": "skimage", **processes.run_once([PYTHON, SCRIPT, "skimage", path])})
    path.unlink()
    return rows


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rounds = 1 if setting.quick else 5
    rows, meet, versions = head(setting, rounds)
    figures = {"rounds": rounds, "head": rows, "meet": meet, "balls": balls(setting), "cells": cells(setting, rounds)}
    commands = ["label_maps.py head ch2.nii.gz head.npy",
                f"isoextract head.npy --labels {LABELS} -o 'part_{{iso}}.ply' --report report.json",
                "label_maps.py meet head.npy 'part_{iso}.ply'", f"label_maps.py vtk head.npy edges+sinc {rounds}",
                "label_maps.py cells 64 512 u2 cells.npy", "isoextract cells.npy --labels all -o out/{label}.ply --mkdir -q",
                "isoextract cells.npy --labels all -o out/cells.glb --mkdir -q", "label_maps.py skimage cells.npy",
                "label_maps.py ball 20 ball.npy", "isoextract ball.npy --labels 1 -o mesh.ply --report report.json"]
    return measured.finish([record.cores()], versions, commands, figures)


def cells_text(figures):
    """The section about many labels."""
    named = {"u2": "u16", "u4": "u32", "u8": "u64"}
    outputs = {"{label}.ply": "isoextract, a file each", "cells.glb": "isoextract, one GLB", "skimage": "scikit-image, no files"}
    groups = {}
    for row in figures["cells"]:
        groups.setdefault((row["side"], row["labels"], row["type"], row["output"]), []).append(row)
    lines = []
    for (side, count, kind, output), runs in groups.items():
        wall, cpu = (median([run[what] for run in runs]) for what in ("wall", "cpu"))
        peak = max(run["peak"] for run in runs)
        lines.append([f"{side}³, {named[kind]}", number(count), outputs[output], number(wall), number(cpu), number(1e6 * cpu / count),
                      number(round(peak)), number(round(runs[0]["input_mib"]))])
    columns = ["map", "labels:", "program", "time, s:", "processor time, s:", "of it per label, µs:", "peak, MiB:", "input, MiB:"]
    return f"""
## Thousands of labels

The cells of random points (Voronoi) in a cube: the whole program with reading, `--labels all` and writing, on two threads; the median of
{figures['rounds']} runs, or one run for the largest map. Processor time is that of user and system. scikit-image runs
`marching_cubes` in the bounding box of each label, on one thread; its surfaces have the steps of the voxels, and it writes no files.

{table(columns, lines)}
"""


def page(measured):
    figures = measured["figures"]
    meet = figures["meet"]
    times = table(["", "triangles:", "area, mm²:", "cold, ms:", "median, ms:"],
                  [[row["way"], number(row["triangles"]), number(round(row["area"])), number(row["ms"][0]),
                    number(median(row["ms"]))] for row in figures["head"]])
    sizes = table(["radius, voxels:", "area, surface nets:", "volume, surface nets:", "area, voxels:", "volume, voxels:"],
                  [[str(row["radius"]), *(f"{row[way][what]:.4f}" for way in ("nets", "voxels") for what in ("area", "volume"))]
                   for row in figures["balls"]])
    return f"""`--labels`: from samples in memory to meshes in memory, of all labels in one run, {figures['rounds']} times each. Every time of
isoextract is of a process of its own, so all are **cold**: pages of memory are taken for the first time. VTK's are of one process a
row, of which the first is cold.

## Five labels of a head

The values of `ch2.nii.gz`, a head by MRI of 181 x 217 x 181 voxels, between 20, 60, 90, 110, 140 and above: noise and all. VTK's
surfaces are of one label after the other; its last row smooths them with 20 iterations and a pass band of 0.1. That filter moves
the surface of each label by itself. VTK 9.1 has no `vtkSurfaceNets3D` yet: [Surfaces of masks](masks.md) has that of a newer VTK.

{times}

Between two labels there are {number(meet['faces'])} faces of voxels. {number(meet['common'])} triangles are in the meshes of two labels,
turned over, with the same numbers: two a face, and one more for each vertex in the middle of an edge that has four faces of one label.

## Balls

Area and volume, as parts of the true ones, of a ball that is a label. Steps between voxels give half as much area again, of any
radius.

{sizes}
{cells_text(figures)}"""
