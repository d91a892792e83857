#!/usr/bin/env python3
"""Whole commands, from file to file: isoextract beside OpenVDB's vdb_tool and a small program of VTK.

    scripts/setup.sh bench && cmake --preset bench && cmake --build --preset bench
    scripts/compare_speed.py [--runs N] [--size N] [--json FILE]

A level set is made with vdb_tool and a gyroid with the benchmark; both are in the page cache when they are read. The
commands of a comparison run in turn, after one warm-up each; every output is removed before the next run, off the clock.
Prints wall time, processor time (user and system) and peak memory, and how isoextract's relate to each other's: the
median over the rounds of the ratio. What is not installed is left out, and said so.
"""

import argparse
import contextlib
import json
import os
import pathlib
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
START_UPS = 20
PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
PLY_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4, "float64": 8}
MEASURES = ("wall", "cpu", "peak")


def run_once(command):
    """Seconds by the clock, seconds of processors, and the peak of memory in MiB."""
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.stderr.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{errors.decode(errors='replace')}ended with {process.returncode}")
    return {"wall": wall, "cpu": usage.ru_utime + usage.ru_stime, "peak": usage.ru_maxrss / 1024}


def ply_triangles(path):
    """Triangles of a binary PLY file of triangles and quads, a quad as two: by its header and its size."""
    with open(path, "rb") as file:
        elements, line = [], b""
        while line != b"end_header":
            line = file.readline().strip()
            words = line.decode().split()
            if words[:1] == ["element"]:
                elements.append({"name": words[1], "count": int(words[2]), "size": 0, "index": 0})
            elif words[:2] == ["property", "list"]:
                elements[-1]["size"] += PLY_SIZES[words[2]]
                elements[-1]["index"] = PLY_SIZES[words[3]]
            elif words[:1] == ["property"]:
                elements[-1]["size"] += PLY_SIZES[words[1]]
        left = os.path.getsize(path) - file.tell()
    faces = next(element for element in elements if element["name"] == "face")
    left -= sum(element["count"] * element["size"] for element in elements)
    corners = left // faces["index"]
    quads = corners - 3 * faces["count"]
    return faces["count"] + quads


def first_line(command):
    done = subprocess.run(command, capture_output=True, text=True)
    lines = (done.stdout + done.stderr).strip().splitlines()
    return lines[0] if lines else "unknown"


def processor():
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def summary(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values), "rounds": values}


def alternate(title, commands, runs):
    """Runs [(label, command, output)] in turn; the first is what the others are compared with."""
    measured = {label: [] for label, _, _ in commands}
    facts = {}
    for turn in range(runs + 1):
        for label, command, output in commands:
            output.unlink(missing_ok=True)
            result = run_once(command)
            if turn > 0:
                measured[label].append(result)
                continue
            facts[label] = {"bytes": output.stat().st_size}
            if output.suffix == ".ply":
                facts[label]["triangles"] = ply_triangles(output)
    rows = []
    first = measured[commands[0][0]]
    for label, command, output in commands:
        own = measured[label]
        row = {"program": label, "command": " ".join(map(str, command)), "output": facts[label]}
        for measure in MEASURES:
            row[measure] = summary([one[measure] for one in own])
            row[f"{measure}_isoextract_to_this"] = statistics.median(
                [a[measure] / b[measure] for a, b in zip(first, own)]
            )
        rows.append(row)
        output.unlink()
    print_rows(title, rows, runs)
    return {"title": title, "rows": rows}


def print_rows(title, rows, runs):
    print(f"\n{title}; median of {runs} alternating rounds\n")
    print("| command | wall, s | CPU, s | peak, MiB | isoextract to this: wall | CPU | peak | triangles | MB written |")
    print("|---|" + "---:|" * 8)
    for row in rows:
        ratios = " | ".join(f"{row[f'{measure}_isoextract_to_this']:.2f}" for measure in MEASURES)
        print(
            f"| {row['program']} | {row['wall']['median']:.3f} | {row['cpu']['median']:.3f} |"
            f" {row['peak']['median']:.0f} | {ratios} | {row['output'].get('triangles', '')} |"
            f" {row['output']['bytes'] / 1e6:.1f} |"
        )
    counts = {row["output"]["triangles"] for row in rows if "triangles" in row["output"]}
    if len(counts) > 1:
        print("\nThe numbers of triangles differ.")
    sys.stdout.flush()


def measure_start_up(isoextract):
    seconds = [run_once([isoextract, "--version"])["wall"] for _ in range(START_UPS + 1)][1:]
    found = summary(seconds)
    print(f"\n`isoextract --version`: {1000 * found['median']:.1f} ms, median of {START_UPS}")
    return found


def compare(options, folder):
    isoextract, size = options.isoextract, options.size
    benchmark, flying_edges = options.build / "extraction_benchmark", options.build / "flying_edges_to_ply"
    vdb_tool = shutil.which("vdb_tool")
    versions = {"isoextract": first_line([isoextract, "--version"]).removeprefix("isoextract ")}
    comparisons = []

    if vdb_tool:
        versions["vdb_tool"] = first_line([vdb_tool, "-version"]).removeprefix("vdb_tool: ")
        # Of the same package: vdb_tool does not tell the library's version.
        versions["OpenVDB"] = first_line(["vdb_print", "--version"]).removeprefix("OpenVDB library version: ")
        volume = folder / f"sphere{size}.vdb"
        if not volume.exists():
            run_once([vdb_tool, "-sphere", f"dim={size}", "radius=1.0", "-write", volume])
        ours, theirs = folder / "isoextract.ply", folder / "vdb_tool.ply"
        commands = [
            ("isoextract", [isoextract, volume, "--iso", "0", "-o", ours], ours),
            ("vdb_tool", [vdb_tool, "-read", volume, "-ls2mesh", "-write", theirs], theirs),
        ]
        comparisons.append(alternate(f"Level set of a sphere, {size} voxels across, VDB to PLY", commands, options.runs))
    else:
        print("vdb_tool is not installed (Debian: libopenvdb-tools): left out", file=sys.stderr)

    if benchmark.exists() and flying_edges.exists():
        versions["flying_edges_to_ply"] = first_line([flying_edges, "--version"])
        volume = folder / f"gyroid{size}.raw"
        if not volume.exists():
            run_once([benchmark, "--write-raw", "gyroid", str(size), volume])
        layout = [volume, "--dims", f"{size},{size},{size}", "--dtype", "f32", "--iso", "0"]
        ours, theirs = folder / "isoextract.ply", folder / "vtk.ply"
        commands = [
            ("isoextract", [isoextract, *layout, "-o", ours], ours),
            ("VTK FlyingEdges3D", [flying_edges, *layout, "-o", theirs], theirs),
        ]
        comparisons.append(alternate(f"Gyroid of {size}^3 f32 samples, raw to PLY", commands, options.runs))
        commands = []
        for name in ("ply", "glb", "obj", "stl"):
            output = folder / f"isoextract.{name}"
            commands.append((f"isoextract to {name}", [isoextract, *layout, "-o", output], output))
        comparisons.append(alternate("The same by isoextract to its formats", commands, options.runs))
    else:
        print(f"no benchmark in {options.build} (cmake --build --preset bench): left out", file=sys.stderr)

    start_up = measure_start_up(isoextract)
    print("\n" + "\n".join(f"{name}: {version}" for name, version in versions.items()))
    print(f"{processor()}, {os.cpu_count()} threads")
    return {"processor": processor(), "threads": os.cpu_count(), "versions": versions, "runs": options.runs,
            "comparisons": comparisons, "start_up_seconds": start_up}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=7, help="rounds, after one warm-up (default: 7)")
    parser.add_argument("--size", type=int, default=512, help="samples along an axis (default: 512)")
    parser.add_argument("--isoextract", type=pathlib.Path, default=ROOT / "build" / "release" / "isoextract",
                        help="the program (default: build/release/isoextract)")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "bench",
                        help="where the preset bench was built (default: build/bench)")
    parser.add_argument("--keep", type=pathlib.Path,
                        help="make the inputs here and keep them, instead of in a temporary folder")
    parser.add_argument("--json", type=pathlib.Path, help="write all figures to this file")
    options = parser.parse_args()
    if options.runs < 1 or options.size < 2:
        parser.error("--runs is 1 or more, and --size 2 or more")
    if not options.isoextract.exists():
        parser.error(f"no {options.isoextract}: build the preset release, or name the program with --isoextract")
    options.isoextract = options.isoextract.resolve()
    options.build = options.build.resolve()
    with contextlib.ExitStack() as stack:
        if options.keep:
            options.keep.mkdir(parents=True, exist_ok=True)
            folder = options.keep.resolve()
        else:
            folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        report = compare(options, folder)
    if options.json:
        options.json.write_text(json.dumps(report, indent=2) + "\n")


if __name__ == "__main__":
    main()
