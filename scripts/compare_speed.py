#!/usr/bin/env python3
"""Whole commands, from file to file: isoextract beside OpenVDB's vdb_tool and a small program of VTK.

    scripts/setup.sh bench && cmake --preset bench && cmake --build --preset bench
    scripts/compare_speed.py [--runs N] [--size N] [--json FILE]

A level set is made with vdb_tool and a gyroid with the benchmark. The commands of a comparison run in turn: first cold,
the input's pages having been dropped from the system's page cache before each of them, then in rounds, warm. Every
output is removed before the next run, off the clock. Prints wall time, processor time (user and system) and peak memory,
and the ratios of isoextract to each other program: the medians over the rounds. Skips programs that are not installed,
with a message. scripts/measure makes a page of the file that --json writes.
"""

import argparse
import contextlib
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

from measuring import page_cache, programs, record
from measuring.processes import ply_triangles, run_once, summary

ROOT = record.ROOT
START_UPS = 20
MEASURES = ("wall", "cpu", "peak")


def words_of(command, folder):
    """A command for readers: programs by their names, files without the folder of this run."""
    program, *words = map(str, command)
    return " ".join([os.path.basename(program), *(word.replace(f"{folder}/", "") for word in words)])


def alternate(title, volume, commands, runs):
    """Runs [(label, command, output)] on a volume in turn; the first is what the others are compared with."""
    measured = {label: [] for label, _, _ in commands}
    cold, facts = {}, {}
    for label, command, output in commands:
        output.unlink(missing_ok=True)
        left = page_cache.evict(volume)
        cold[label] = run_once(command) | {"input_in_page_cache": left}
        facts[label] = {"bytes": output.stat().st_size}
        if output.suffix == ".ply":
            facts[label]["triangles"] = ply_triangles(output)
    for _ in range(runs):
        for label, command, output in commands:
            output.unlink(missing_ok=True)
            measured[label].append(run_once(command))
    rows = []
    first = measured[commands[0][0]]
    for label, command, output in commands:
        own = measured[label]
        row = {"program": label, "command": words_of(command, output.parent), "output": facts[label],
               "cold": cold[label]}
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
    print(f"\n{title}; cold, and median of {runs} alternating rounds\n")
    print("| command | cold, s | wall, s | CPU, s | peak, MiB | isoextract to this: wall | CPU | peak | triangles |"
          " MB written |")
    print("|---|" + "---:|" * 9)
    for row in rows:
        ratios = " | ".join(f"{row[f'{measure}_isoextract_to_this']:.2f}" for measure in MEASURES)
        print(
            f"| {row['program']} | {row['cold']['wall']:.3f} | {row['wall']['median']:.3f} |"
            f" {row['cpu']['median']:.3f} | {row['peak']['median']:.0f} | {ratios} |"
            f" {row['output'].get('triangles', '')} |"
            f" {row['output']['bytes'] / 1e6:.1f} |"
        )
    counts = {row["output"]["triangles"] for row in rows if "triangles" in row["output"]}
    if len(counts) > 1:
        print("\nThe numbers of triangles differ.")
    sys.stdout.flush()


def measure_start_up(isoextract):
    left = page_cache.evict(isoextract)
    cold = run_once([isoextract, "--version"])["wall"]
    found = summary([run_once([isoextract, "--version"])["wall"] for _ in range(START_UPS)])
    found |= {"cold": cold, "program_in_page_cache": left}
    print(f"\n`isoextract --version`: cold {1000 * cold:.1f} ms, then {1000 * found['median']:.1f} ms,"
          f" median of {START_UPS}")
    return found


def compare(options, folder):
    isoextract, size = options.isoextract, options.size
    benchmark, flying_edges = options.build / "extraction_benchmark", options.build / "flying_edges_to_ply"
    vdb_tool = shutil.which("vdb_tool")
    versions, comparisons = {}, []

    if vdb_tool:
        versions["vdb_tool"] = record.first_line([vdb_tool, "-version"]).removeprefix("vdb_tool: ")
        # vdb_print is of the same package; vdb_tool does not print the library's version.
        versions["OpenVDB"] = record.first_line(["vdb_print", "--version"]).removeprefix("OpenVDB library version: ")
        volume = folder / f"sphere{size}.vdb"
        if not volume.exists():
            run_once([vdb_tool, "-sphere", f"dim={size}", "radius=1.0", "-write", volume])
        ours, theirs = folder / "isoextract.ply", folder / "vdb_tool.ply"
        commands = [
            ("isoextract", [isoextract, volume, "--iso", "0", "-o", ours], ours),
            ("vdb_tool", [vdb_tool, "-read", volume, "-ls2mesh", "-write", theirs], theirs),
        ]
        comparisons.append(
            alternate(f"Level set of a sphere, {size} voxels across, VDB to PLY", volume, commands, options.runs)
        )
    else:
        print("vdb_tool is not installed (Debian: libopenvdb-tools): left out", file=sys.stderr)

    if benchmark.exists() and flying_edges.exists():
        versions["flying_edges_to_ply"] = record.first_line([flying_edges, "--version"])
        volume = folder / f"gyroid{size}.raw"
        if not volume.exists():
            run_once([benchmark, "--write-raw", "gyroid", str(size), volume])
        layout = [volume, "--dims", f"{size},{size},{size}", "--dtype", "f32", "--iso", "0"]
        ours, theirs = folder / "isoextract.ply", folder / "vtk.ply"
        commands = [
            ("isoextract", [isoextract, *layout, "-o", ours], ours),
            ("VTK FlyingEdges3D", [flying_edges, *layout, "-o", theirs], theirs),
        ]
        comparisons.append(alternate(f"Gyroid of {size}³ f32 samples, raw to PLY", volume, commands, options.runs))
        commands = []
        for name in ("ply", "glb", "obj", "stl"):
            output = folder / f"isoextract.{name}"
            commands.append((f"isoextract to {name}", [isoextract, *layout, "-o", output], output))
        comparisons.append(alternate("The same by isoextract to its formats", volume, commands, options.runs))
    else:
        print(f"no benchmark in {options.build} (cmake --build --preset bench): left out", file=sys.stderr)

    start_up = measure_start_up(isoextract)
    print("\n" + "\n".join(f"{name}: {version}" for name, version in versions.items()))
    print(f"{record.processor()}, {record.cores()} threads")
    return versions, {"runs": options.runs, "comparisons": comparisons, "start_up_seconds": start_up}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=7, help="warm rounds (default: 7)")
    parser.add_argument("--size", type=int, default=512, help="samples along an axis (default: 512)")
    parser.add_argument("--isoextract", type=pathlib.Path, default=ROOT / "build" / "release" / "isoextract",
                        help="the program (default: build/release/isoextract)")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "bench",
                        help="where the preset bench was built (default: build/bench)")
    parser.add_argument("--keep", type=pathlib.Path,
                        help="make the inputs here and keep them, instead of in a temporary folder")
    parser.add_argument("--json", type=pathlib.Path, help="write all figures to this file")
    parser.add_argument("--quick", action="store_true", help="mark the figures as those of a trial run")
    options = parser.parse_args()
    if options.runs < 1 or options.size < 2:
        parser.error("--runs is 1 or more, and --size 2 or more")
    if not options.isoextract.exists():
        parser.error(f"no {options.isoextract}: build the preset release, or name the program with --isoextract")
    options.isoextract = options.isoextract.resolve()
    options.build = options.build.resolve()
    measured = record.Record("commands", options.isoextract, options.quick)
    with contextlib.ExitStack() as stack:
        if options.keep:
            options.keep.mkdir(parents=True, exist_ok=True)
            folder = options.keep.resolve()
        else:
            folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        try:
            versions, figures = compare(options, folder)
        except programs.Failed as error:
            sys.exit(str(error))
    if options.json:
        command = f"scripts/compare_speed.py --runs {options.runs} --size {options.size}"
        record.write(measured.finish([record.cores()], versions, [command], figures), options.json)


if __name__ == "__main__":
    main()
