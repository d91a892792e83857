"""The GPU backend beside the CPU's, and what making a GPU's threads costs."""

import json

from measuring import programs, record
from measuring.tables import median, number, power, table

NAME = "gpu"
TITLE = "GPU backend: time per pipeline"
FIELDS = ("sphere", "gyroid")
PIPELINES = {
    ("mc", "cpu"): "`mc` on the processor",
    ("mc", "gpu"): "`mc-tessellation`",
    ("mc", "gpu:points"): "`mc`, threads by number (`gpu:points`)",
    ("mt", "cpu"): "`mt` on the processor",
    ("mt", "gpu"): "`mt-geometry`",
    ("mt", "gpu:rows"): "`mt-geometry`, rows instead of groups (`gpu:rows`)",
}


def is_software(setting):
    devices = json.loads(programs.run([setting.isoextract, "devices", "--json"]))
    return all(device["software"] for device in devices if device["usable"])


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    software = is_software(setting)
    if setting.quick:
        sizes, grids = (16,), (16, 32)
    else:
        sizes, grids = ((128,), (64, 128, 256)) if software else ((128, 256, 512), (128, 256, 512, 1024))
    threads = record.cores()
    inputs = [f"demo:{field}" for field in FIELDS]
    fields, commands = {field: [] for field in FIELDS}, []
    for method in ("mc", "mt"):
        backends = ",".join(backend for of, backend in PIPELINES if of == method)
        found, command = programs.bench(setting, *inputs, "--sizes", ",".join(map(str, sizes)), "--methods", method,
                                        "--backends", backends, "--threads", threads, "--repeats", 3)
        commands.append(command)
        for field, benchmark in zip(FIELDS, found["benchmarks"]):
            for row in benchmark["rows"]:
                if row["backend"] in ("cpu", "gpu"):
                    row["cold_ms"] = programs.cold_extraction_ms(setting, field, row["size"], method,
                                                                 benchmark["iso"], row["backend"], 1)
                fields[field].append(row)
    creation, creation_command = programs.bench(setting, "gpu-threads", "--sizes", ",".join(map(str, grids)),
                                                "--repeats", 5)
    cold = programs.shown(["isoextract", "demo:FIELD?size=N", "--iso", 0, "--method", "M", "--backend", "B", "-o",
                           "mesh.ply", "--report", "report.json"])
    figures = {"software": software, "repeats": found["repeats"], "fields": fields, "creation": creation}
    commands += [f"MESA_SHADER_CACHE_DISABLE=true __GL_SHADER_DISK_CACHE=0 {cold}  # cold", creation_command]
    return measured.finish([threads], {}, commands, figures)


def pipeline_rows(figures):
    order = list(PIPELINES)
    for field, rows in figures["fields"].items():
        for row in sorted(rows, key=lambda row: (int(row["size"]), order.index((row["method"], row["backend"])))):
            seconds = (row["device"] or {}).get("seconds", {})
            stages = [number(1000 * seconds[stage]) if seconds else "" for stage in ("count", "capture", "weld")]
            cold = number(median(row["cold_ms"])) if "cold_ms" in row else "–"
            yield [f"{field} {power(row['size'])}", PIPELINES[row["method"], row["backend"]], number(row["triangles"]),
                   cold, number(1000 * row["seconds"]["median"]), *stages]


def memory(count):
    for unit in ("B", "KiB", "MiB", "GiB"):
        if count < 1024 or unit == "GiB":
            return f"{number(count)} {unit}"
        count /= 1024


def creation_rows(figures):
    for level in figures["creation"]["gpu_threads"]:
        cells = [power(level["size"])]
        for maker in level["makers"]:
            problem = maker.get("problem")
            cells += [problem, ""] if problem else [number(1000 * maker["seconds"]["median"]), memory(maker["vertex_bytes"])]
        yield cells


def memory_ratio(figures):
    """The vertex data of tessellation as a fraction of that of dummy vertices, for the largest grid."""
    used = {maker["threads_by"]: maker.get("vertex_bytes") for maker in figures["creation"]["gpu_threads"][-1]["makers"]}
    tessellation, dummies = used.get("tessellation"), used.get("dummy vertices")
    return f"1/{number(round(dummies / tessellation))}" if tessellation and dummies else "another ratio"


def page(measured):
    figures = measured["figures"]
    pipelines = table(["field", "pipeline", "triangles:", "cold, ms:", "warm, ms:", "count, ms:", "capture, ms:", "weld, ms:"],
                      pipeline_rows(figures))
    makers = [maker["threads_by"] for maker in figures["creation"]["gpu_threads"][0]["makers"]]
    columns = ["cells"] + [title for maker in makers for title in (f"{maker}, ms:", "memory:")]
    software = """
The device here is software: Mesa's llvmpipe runs the shaders on the processor. The tables show that the pipelines work, and
their run times on this device. They say nothing about the speed of a GPU.
""" if figures["software"] else ""
    return f"""`isoextract bench --backends` extracts the same fields by every pipeline; [the GPU backend](../gpu.md) describes them.
{software}
- **Cold** is the time of the first extraction in a process that has only made the samples and opened the device before, as the
  report of a conversion states it. It includes uploading the samples and compiling the shaders, because the driver's cache of
  compiled shaders is off. Pipelines that only `bench` offers have no cold time.
- **Warm** is the median of {figures['repeats']} extractions after a first one that does not count. Count, capture and weld are parts of it.

{pipelines}

## Starting one thread per cell

`isoextract bench gpu-threads` starts one thread for each cell of a grid, in three ways. The threads end at once, so the time is
that of starting them. *Memory* is the size of the vertex data that the driver needs. Times are warm: the median of
{figures['creation']['repeats']} passes. A first pass, in which the driver compiles the shaders, does not count.

Timokhin and Mikhaylyuk ([papers](../papers.md)) measured on a GTX 1080 Ti that tessellation takes a fifth of the time and an
eighth of the memory of dummy vertices. In the table it takes {memory_ratio(figures)} of the memory, because the table counts only the vertex data:
16 bytes for each patch, from which the tessellator starts up to 4,096 threads, against 4 bytes for each dummy vertex.

{table(columns, creation_rows(figures))}
"""
