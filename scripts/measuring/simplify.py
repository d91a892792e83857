"""Fewer triangles within a stated distance, and to a stated number, beside gltfpack and VTK."""

import json

from measuring import compression, processes, programs, record
from measuring.tables import number, percent, table

NAME = "simplify"
TITLE = "Simplification: triangles, distance and time"
BOUND = 0.1
LADDER = (0.01, 0.03, 0.1, 0.3, 1, 3)
PYTHON = "/usr/bin/python3"  # which has NumPy, and VTK
SCRIPT = record.ROOT / "scripts" / "measuring" / "simplify_peers.py"
PEERS_OF_VTK = ("vtkQuadricDecimation", "vtkDecimatePro")
BOX = "box.npy"

# A file of the data folder, one that simplify_peers.py makes, or a demo field; and its options.
INPUTS = (
    (BOX, "--iso", "0"),
    ("med/ch2.nii.gz", "--iso", "60"),
    ("med/MR.nii.gz", "--iso", "120", "--cap"),
    ("med/tooth.nhdr", "--iso", "500"),
    ("demo:sphere?size=256", "--iso", "0"),
    ("demo:gyroid?size=128", "--iso", "0", "--cap"),
)
QUICK = ((BOX, "--iso", "0"), ("demo:gyroid?size=32", "--iso", "0", "--cap"))
BESIDE = (BOX, "med/ch2.nii.gz", "med/tooth.nhdr", "demo:gyroid?size=32")
PLAIN = ("--space", "index", "--normals", "none")  # in voxels; the peers have no normals to look after either


def inputs(setting):
    for name, *options in QUICK if setting.quick else INPUTS:
        if name == BOX:
            path = setting.folder / BOX
            programs.run([PYTHON, SCRIPT, "box", "40" if setting.quick else "220", path])
        else:
            path = name if name.startswith("demo:") else setting.data / name
        if name in (BOX, path) or path.exists():
            yield name, [path, *options]


def bounded(setting, arguments):
    """Triangles left at each distance; time and measured distance at BOUND."""
    row = {"command": programs.shown(["isoextract", *arguments, "--simplify", BOUND, "-o", "mesh.ply"]), "ladder": []}
    for distance in LADDER:
        report = programs.convert(setting, *arguments, "--simplify", distance)
        (found,) = report["simplifications"]
        row["ladder"].append(found["triangles_after"])
        if distance != BOUND:
            continue
        row |= {"before": found["triangles_before"], "after": found["triangles_after"],
                "measured_voxels": found["measured"]["voxels"], "simplify_seconds": found["time"]["wall_seconds"],
                "closed": report["meshes"][0]["closed"]}
    return row


def compared(setting, full, mesh):
    report = json.loads(programs.run([setting.isoextract, "compare", "--json", full, mesh]))
    return {"triangles": report["b"]["triangles"], "distance": report["hausdorff"],
            **{what: [report[side][what] for side in "ab"] for what in ("components", "genus", "closed")}}


def beside(setting, arguments, rounds, versions):
    """Ours within a distance, then ours and the peers to as many triangles."""
    full = {kind: setting.folder / f"full.{kind}" for kind in ("ply", "glb")}
    for file in full.values():
        programs.run([setting.isoextract, *arguments, *PLAIN, "-o", file, "-q"])
    rows = []

    def ours(*options):
        seconds = []
        for _ in range(rounds):
            file, report = setting.folder / "ours.ply", setting.folder / "report.json"
            programs.run([setting.isoextract, *arguments, *PLAIN, *options, "-o", file, "--report", report, "-q"])
            (found,) = json.loads(report.read_text())["simplifications"]
            seconds.append(found["time"]["wall_seconds"])
        rows.append({"way": f"`isoextract {' '.join(options)}`", "seconds": seconds, **compared(setting, full["ply"], file)})
        return found["triangles_before"], found["triangles_after"]

    before, wanted = ours("--simplify", str(BOUND))
    ours("--triangles", str(wanted))

    file = setting.folder / "gltfpack.glb"
    packing = [compression.NODE / "node_modules" / ".bin" / "gltfpack", "-i", full["glb"], "-o", file, "-noq", "-se", "1", "-si"]
    only_packed, seconds = ([processes.run_once([*packing, ratio])["wall"] for _ in range(rounds)]
                            for ratio in ("1", f"{wanted / before:.8f}"))
    rows.append({"way": f"`gltfpack -noq -se 1 -si {wanted / before:.3g}`", "seconds": [t - min(only_packed) for t in seconds],
                 **compared(setting, full["glb"], file)})

    for name in PEERS_OF_VTK:
        file, seconds = setting.folder / "vtk.ply", []
        for _ in range(rounds):
            found = json.loads(programs.run([PYTHON, SCRIPT, "vtk", name, wanted, full["ply"], file]))
            seconds.append(found["seconds"])
        versions["VTK"] = found["vtk"]
        rows.append({"way": name, "seconds": seconds, **compared(setting, full["ply"], file)})
    return {"command": programs.shown(["isoextract", *arguments]), "before": before, "rows": rows}


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    versions = {"gltfpack": compression.packages()["gltfpack"]}
    rounds = 1 if setting.quick else 3
    rows, others = [], []
    for name, arguments in inputs(setting):
        rows.append(bounded(setting, arguments))
        if name in BESIDE:
            others.append(beside(setting, arguments, rounds, versions))
    commands = [f"simplify_peers.py box 220 {BOX}", *(row["command"] for row in rows)]
    figures = {"bound_voxels": BOUND, "ladder": LADDER, "rounds": rounds, "rows": rows, "beside": others, "costs": earlier_costs()}
    return measured.finish([record.cores()], versions, commands, figures)


def earlier_costs():
    """The rows of the page that compare commits: measured once, by hand."""
    file = record.ROOT / "docs" / "measurements" / f"{NAME}.json"
    return json.loads(file.read_text())["figures"].get("costs", []) if file.exists() else []


def costs_section(rows):
    if not rows:
        return ""
    lines = [[f"`{row['commit']}`", f"`{row['input']}`", number(row["threads"]), number(row["triangles"]),
              f"{row['cpu_seconds'][0]:.1f} to {row['cpu_seconds'][1]:.1f}", number(row["memory_mib"]),
              number(row["bytes_a_triangle"])] for row in rows]
    heads = ["commit", "mesh", "threads:", "triangles left:", "CPU, s:", "peak memory, MiB:", "bytes per triangle:"]
    return f"""
## Processor time and memory, commit by commit

Measured once, by hand, before the run that the rest of this page shows. Figures are for the simplification alone, with
`--simplify {BOUND}` and an optimized build. The builds of these commits ran in turn on two cores that other processes used, too. So
compare only rows of the same mesh; times on an idle machine are lower.

{table(heads, lines)}
"""


def kept(pair):
    before, after = ({True: "yes", False: "no"}[value] if isinstance(value, bool) else number(value) for value in pair)
    return after if before == after else f"**{before} to {after}**"


def page(measured):
    figures = measured["figures"]
    bound = figures["bound_voxels"]
    rows = [[f"`{row['command']}`", number(row["before"]), number(row["after"]), percent(row["after"] / row["before"]),
             f"{row['measured_voxels']['lower']:.4f} to {row['measured_voxels']['upper']:.4f}",
             number(row["simplify_seconds"]), number(1e6 * row["simplify_seconds"] / row["before"])]
            for row in figures["rows"]]
    columns = ["command", "triangles before:", "after:", "after / before:", "measured distance, voxels:", "cold, s:",
               "s per million triangles:"]
    ladder = table(["distance, voxels", *(f"{distance}:" for distance in figures["ladder"])],
                   [[f"`{row['command'].split(' --simplify')[0]}`", *map(number, row["ladder"])] for row in figures["rows"]])
    sections = []
    for one in figures["beside"]:
        lines = [[row["way"], number(row["triangles"]), f"{row['distance'][0]:.3g} to {row['distance'][1]:.3g}",
                  number(min(row["seconds"])), kept(row["components"]), kept(row["genus"]), kept(row["closed"])]
                 for row in one["rows"]]
        heads = ["", "triangles:", "distance, voxels:", "cold, s:", "components:", "genus:", "closed:"]
        sections.append(f"`{one['command']}`, {number(one['before'])} triangles:\n\n{table(heads, lines)}")
    peers = "\n\n".join(sections)
    return f"""`--simplify {bound}` removes triangles while the distance to the full mesh stays below {bound} voxels: at every point of both meshes, not
only at vertices. *Measured distance* is an interval that contains the largest distance.

Times are for the simplification alone, and **cold**: each is the first simplification of a new process. `box.npy` has the distances,
clamped to 3 voxels, from the surface of a cube 220 voxels wide, whose sides lie on planes of samples.

{table(columns, rows)}

## Triangles by distance

{ladder}

## Beside `gltfpack` and VTK

Each program is asked for as many triangles as `--simplify {bound}` leaves; the tables show how many it leaves. All meshes are in voxel
coordinates without normals, so counts differ a little from those above. `isoextract compare` measures the largest distance over all
points of both meshes, the components, the genus, and whether the mesh is closed; changes are in bold type. A mesh that is not closed
has no genus, so its table has a dash.

Times are for the simplification alone: the least of {figures['rounds']} runs, each in a process of its own. `gltfpack` is the npm package, which
runs in Node: its time is that of the whole command minus the least time of a run that simplifies nothing. `gltfpack` and VTK use one
thread, and do not measure a distance.

{peers}
{costs_section(figures.get("costs", []))}"""
