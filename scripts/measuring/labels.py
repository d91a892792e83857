"""Surfaces of label maps: beside VTK's discrete ones, whether they meet, and how near balls come to their size."""

import json
import math
import shutil

from measuring import processes, programs, record
from measuring.tables import median, number, table

NAME = "labels"
TITLE = "Label maps: time and quality"
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
    """Milliseconds of a conversion for the surfaces of all labels: a report has the stages of each label."""
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
    """Time and memory for thousands of labels, with reading and writing; and of scikit-image, label by label."""
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
    columns = ["map", "labels:", "program", "time, s:", "processor time, s:", "processor time per label, µs:", "peak, MiB:", "input, MiB:"]
    return f"""
## Thousands of labels

The labels are the Voronoi cells of random points in a cube. Times are for the whole command, which reads the map, extracts `--labels all` on
two threads and writes the meshes: the median of {figures['rounds']} runs, or one run for the largest map. Processor time is user plus system time.
scikit-image runs `marching_cubes` on one thread in the bounding box of each label. It keeps the steps of the voxels and writes no files.

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
    return f"""Times are for the extraction of all labels in one run, from samples in memory to meshes in memory, {figures['rounds']} runs for each row. Each run
of isoextract is a new process, so all its times are **cold**: the process touches its memory for the first time. All VTK runs of a row
are in one process, so only the first is cold.

## Five labels of a head

The labels 1 to 5 are ranges of the values in `ch2.nii.gz`, an MRI scan of a head with 181 x 217 x 181 voxels. The ranges begin at 20, 60,
90, 110 and 140, so the labels have all the noise of the scan. VTK extracts one label after the other. Its last row smooths each surface
by itself, with 20 iterations and a pass band of 0.1. VTK 9.1 has no `vtkSurfaceNets3D`; [Surfaces of masks](masks.md) has it, from a newer VTK.

{times}

{number(meet['faces'])} faces of voxels separate two labels. {number(meet['common'])} triangles are in the meshes of two labels, with the same coordinates and
opposite winding: two for each face, and one more for each vertex in the middle of a voxel edge where four faces of one label meet.

## Balls

The label is a ball. The table has the area and volume of its mesh, divided by those of the true ball. The steps between voxels add about
half of the area, at any radius.

{sizes}
{cells_text(figures)}"""
