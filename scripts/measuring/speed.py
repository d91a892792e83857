"""Extraction in memory, beside others that do the same."""

from measuring import extraction, record
from measuring.tables import median, number, power, ratio, table

NAME = "speed"
TITLE = "Extraction time: isoextract, VTK and OpenVDB"

# Field, type of its samples, normals.
GROUPS = (
    ("sphere", "f32", "none"),
    ("sphere", "f32", "smooth"),
    ("gyroid", "f32", "none"),
    ("gyroid", "f32", "smooth"),
    ("gyroid", "i16", "none"),
    ("gyroid", "u8", "none"),
    ("marschner-lobb", "f32", "none"),
    ("mri", "u8", "none"),
    ("ct", "u16", "none"),
    ("level-set", "f32", "none"),
    ("fog", "f32", "none"),
)
NAMES = {
    "mri": "head scan `ch2.nii.gz`",
    "ct": "tooth `tooth.nhdr`",
    "level-set": "level set of a sphere, VDB",
    "fog": "fog in a sphere, VDB",
}


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    size, processes, runs = (64, 1, 2) if setting.quick else (512, 3, 3)
    threads = record.cores()
    groups, commands = [], []
    for field, kind, normals in GROUPS:
        arguments = ["--fields", field, "--sizes", size, "--types", kind, "--normals", normals, "--threads", threads,
                     "--peers", "FlyingEdges3D,volumeToMesh"]
        rows = extraction.measure(setting, arguments, processes, runs)
        if not rows:
            continue
        groups.append({"rows": rows})
        commands.append(extraction.shown([*arguments, "--runs", runs]))
    versions = {}
    for group in groups:
        versions |= extraction.versions(group["rows"])
    figures = {"processes": processes, "rounds": runs, "groups": groups}
    return measured.finish([threads], versions, commands, figures)


def group_rows(group):
    rows = group["rows"]
    own = next(row for row in rows if extraction.ours(row))
    floor = next(row for row in rows if row["name"] == "read and write")
    peers = [row for row in rows if not extraction.ours(row) and row["program"] != "memory"]
    x, y, z = own["dims"]
    size = power(x) if x == y == z else f"{x} x {y} x {z}"
    name = f"{NAMES.get(own['input'], own['input'])}, {size}, {own['type']}"
    if own["normals"] != "none":
        name += f", {own['normals']} normals"
    start = [name, number(own["triangles"]), number(median(own["cold_ms"])), number(median(own["warm_ms"])),
             number(median(floor["warm_ms"]))]
    for peer in peers or [None]:
        if peer is None:
            yield [*start, "", "", "", "", ""]
        else:
            yield [*start, f"{peer['program']} {peer['name']}", number(median(peer["cold_ms"])),
                   number(median(peer["warm_ms"])), ratio(extraction.ratio(own, peer, "cold_ms")),
                   ratio(extraction.ratio(own, peer, "warm_ms"))]


def page(measured):
    figures = measured["figures"]
    processes, rounds = figures["processes"], figures["rounds"]
    columns = ["input", "triangles:", "isoextract, cold, ms:", "warm, ms:", "memory alone, ms:", "other program",
               "other, cold, ms:", "other, warm, ms:", "isoextract / other, cold:", "warm:"]
    rows = [row for group in figures["groups"] for row in group_rows(group)]
    return f"""Samples in memory to welded vertices and triangles in memory, in one process, by `build/bench/extraction_benchmark`.

- **Cold** is the first extraction by a program in a new process; isoextract extracts first, then the other program. The system
  clears new pages of memory for it. The table has the median of {processes} processes.
- **Warm** is the median of {processes * rounds} later rounds, {rounds} in each process; each round runs every program once. isoextract keeps
  its memory for the next round, as a run with several iso values does; the other programs allocate theirs again.
- **Memory alone** is the time to read all samples once and to write as many bytes as the mesh has once, and nothing else.
- **isoextract / other** is the median of the ratios of the processes (cold) or rounds (warm); below 1, isoextract is
  faster. The mesh of the other program may differ in a few triangles.

{table(columns, rows)}
"""
