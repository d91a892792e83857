"""Error against run time."""

import hashlib

from measuring import programs, record
from measuring.tables import median, number, percent, power, ratio, table

NAME = "error"
TITLE = "Error against run time"
FIELD = "torus"
PLOT = "error-time.svg"


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    sizes = (16, 32) if setting.quick else (32, 64, 128, 256)
    plot = setting.out / PLOT
    found, command = programs.bench(setting, f"demo:{FIELD}", "--sizes", ",".join(map(str, sizes)), plot=plot)
    (benchmark,) = found["benchmarks"]
    threads = max(row["threads"] for row in benchmark["rows"])
    for row in benchmark["rows"]:
        if row["threads"] == threads:
            row["cold_ms"] = programs.cold_extraction_ms(setting, FIELD, row["size"], row["method"], benchmark["iso"])
    cold = programs.shown(["isoextract", f"demo:{FIELD}?size=N", "--iso", benchmark["iso"], "--method", "M", "-o",
                           "mesh.ply", "--report", "report.json"])
    figures = {"repeats": found["repeats"], "benchmark": benchmark,
               "plot": {"file": PLOT, "sha256": hashlib.sha256(plot.read_bytes()).hexdigest()}}
    return measured.finish(sorted({row["threads"] for row in benchmark["rows"]}), {}, [command, f"{cold}  # cold"], figures)


def files(measured):
    """Names and hashes of the files beside the record."""
    return [measured["figures"]["plot"]]


def page(measured):
    figures = measured["figures"]
    benchmark = figures["benchmark"]
    rows = []
    for row in sorted((row for row in benchmark["rows"] if "cold_ms" in row),
                      key=lambda row: (row["method"], int(row["size"]))):
        position = row["position"]
        rows.append([f"`{row['method']}`", power(row["size"]), number(row["triangles"]), number(median(row["cold_ms"])),
                     number(1000 * row["seconds"]["median"]), number(position["rms"]["voxels"], 2),
                     number(position["max"]["voxels"], 2), f"{number(row['smooth_normals']['rms_degrees'], 2)}°",
                     f"{number(row['flat_normals']['rms_degrees'], 2)}°", percent(row["area_error"]), percent(row["volume_error"])])
    columns = ["method", "samples", "triangles:", "cold, ms:", "warm, ms:", "rms, voxels:", "max, voxels:",
               "smooth normals:", "flat normals:", "area:", "volume:"]
    threads = max(row["threads"] for row in benchmark["rows"])
    processes = len(next(row["cold_ms"] for row in benchmark["rows"] if "cold_ms" in row))
    number_word = {3: "three"}.get(processes, processes)
    orders = [[f"`{order['method']}`", *(ratio(order[key]["slope"]) for key in
              ("position", "smooth_normals", "flat_normals", "area", "volume"))] for order in benchmark["orders"]]
    return f"""`isoextract bench` extracts a field of a known formula at several resolutions and measures every mesh against the formula.

![Error over run time for marching cubes and marching tetrahedra]({figures['plot']['file']})

- The table is for {threads} threads; the picture also shows one thread.
- **Cold** is the time of the extraction in a process that has only made the samples before, as the report of a
  conversion states it: the median of {number_word} processes. **Warm** is the median of {figures['repeats']} extractions in one process, after a first
  one that does not count; the picture shows warm times.
- Errors of positions and normals are root mean squares, except *max*. Errors of area and volume are relative.

{table(columns, rows)}

The order of convergence, from error ~ spacing^order over all sizes:

{table(["method", "position:", "smooth normals:", "flat normals:", "area:", "volume:"], orders)}
"""
