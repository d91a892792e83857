"""Fewer triangles within a stated distance."""

from measuring import programs, record
from measuring.tables import number, percent, table

NAME = "simplify"
TITLE = "What `--simplify` leaves, and how long it takes"
BOUND = "0.1"

# A file of the data folder or a demo field, and its options.
INPUTS = (
    ("med/ch2.nii.gz", "--iso", "60"),
    ("med/MR.nii.gz", "--iso", "120", "--cap"),
    ("med/tooth.nhdr", "--iso", "500"),
    ("demo:sphere?size=256", "--iso", "0"),
    ("demo:gyroid?size=128", "--iso", "0", "--cap"),
)
QUICK = (("demo:sphere?size=48", "--iso", "0"), ("demo:gyroid?size=32", "--iso", "0", "--cap"))


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rows = []
    for name, *options in QUICK if setting.quick else INPUTS:
        path = name if name.startswith("demo:") else setting.data / name
        if not name.startswith("demo:") and not path.exists():
            continue
        report = programs.convert(setting, path, *options, "--simplify", BOUND)
        (found,) = report["simplifications"]
        mesh = report["meshes"][0]
        rows.append({"command": programs.shown(["isoextract", path, *options, "--simplify", BOUND, "-o", "mesh.ply"]),
                     "before": found["triangles_before"], "after": found["triangles_after"],
                     "measured_voxels": found["measured"]["voxels"], "simplify_seconds": found["time"]["wall_seconds"],
                     "all_seconds": report["total"]["wall_seconds"], "closed": mesh["closed"]})
    commands = [row["command"] for row in rows]
    return measured.finish([record.cores()], {}, commands, {"bound_voxels": float(BOUND), "rows": rows})


def page(measured):
    figures = measured["figures"]
    rows = [[f"`{row['command']}`", number(row["before"]), number(row["after"]), percent(row["after"] / row["before"]),
             f"{row['measured_voxels']['lower']:.4f} to {row['measured_voxels']['upper']:.4f}",
             number(row["simplify_seconds"]), number(1e6 * row["simplify_seconds"] / row["before"])]
            for row in figures["rows"]]
    columns = ["command", "triangles before:", "after:", "left:", "measured distance, voxels:", "cold, s:",
               "s for a million:"]
    return f"""`--simplify {figures['bound_voxels']}` leaves out triangles as long as the distance to the full mesh, measured at any point of both and not
only at vertices, stays below that many voxels. What was measured is an interval that holds the distance.

A conversion simplifies once, in a process of its own: its time is **cold**, and a warm one does not exist.

{table(columns, rows)}
"""
