"""Surfaces of voxels: beside NumPy, and a scene of land and water."""

import json

from measuring import programs, record
from measuring.tables import median, number, ratio, table

NAME = "voxels"
TITLE = "How fast surfaces of voxels are made"
PYTHON = "/usr/bin/python3"  # which has NumPy
SCRIPT = record.ROOT / "scripts" / "measuring" / "voxel_scene.py"
PAPER_MS = 3867  # a frame of the scene of 33,170 voxels: its mesh and its picture
WAYS = (("merged", ()), ("two triangles a rectangle", ("--t-junctions",)), ("each face by itself", ("--no-merge",)))


def script(*arguments):
    return programs.run([PYTHON, SCRIPT, *arguments])


def times(setting, rounds, *arguments):
    """Times and counts of conversions, each in a process of its own."""
    reports = [programs.convert(setting, *arguments, "--method", "voxels") for _ in range(rounds)]
    return {"ms": [programs.extraction_ms(report) for report in reports],
            "triangles": sum(mesh["triangles"] for mesh in reports[0]["meshes"]),
            "vertices": sum(mesh["vertices"] for mesh in reports[0]["meshes"]),
            "closed": all(mesh["closed"] for mesh in reports[0]["meshes"])}


def rows_of(setting, path, iso, rounds):
    rows = [{"way": f"isoextract, {way}", **times(setting, rounds, path, "--iso", iso, *options)} for way, options in WAYS]
    peer = json.loads(script("faces", path, iso, rounds))
    rows.append({"way": f"NumPy {peer.pop('numpy')}, each face by itself", "closed": None, **peer})
    return rows


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rounds = 2 if setting.quick else 7
    size = 48 if setting.quick else 512
    scene = setting.folder / "scene.npy"
    script("scene", scene)
    figures = {"rounds": rounds, "paper_ms": PAPER_MS, "size": size, "scene": rows_of(setting, scene, 0.5, rounds),
               "fields": {}}
    commands = ["voxel_scene.py scene scene.npy",
                "isoextract scene.npy --iso 0.5 --method voxels -o mesh.ply --report report.json",
                f"voxel_scene.py faces scene.npy 0.5 {rounds}"]
    for name in ("gyroid", "sphere"):
        path = setting.folder / f"{name}.npy"
        script("field", name, size, path)
        figures["fields"][name] = rows_of(setting, path, 127, rounds)
        path.unlink()
        commands += [f"voxel_scene.py field {name} {size} {name}.npy",
                     f"isoextract {name}.npy --iso 127 --method voxels -o mesh.ply --report report.json"]
    return measured.finish([record.cores()], {}, commands, figures)


def rows_table(rows):
    return table(["", "triangles:", "vertices:", "cold, ms:", "median, ms:", "first row / this row:"],
                 [[row["way"], number(row["triangles"]), number(row["vertices"]), number(row["ms"][0]),
                   number(median(row["ms"])), ratio(median(rows[0]["ms"]) / median(row["ms"]))] for row in rows])


def page(measured):
    figures = measured["figures"]
    fields = "\n".join(f"## {name[0].upper() + name[1:]}, {figures['size']}³ samples of 8 bits\n\n{rows_table(rows)}\n"
                       for name, rows in figures["fields"].items())
    ours = median(figures["scene"][0]["ms"])
    return f"""Times are for `--method voxels`, from samples in memory to a mesh in memory, {figures['rounds']} runs for each row. Each run of isoextract is a new
process, so all its times are **cold**: the process touches its memory for the first time. All NumPy runs of a row are in one process,
so only the first is cold. NumPy makes each face with four vertices of its own (`np.diff` along each axis). isoextract welds vertices,
and its meshes are closed, except with two triangles a rectangle (`--t-junctions`).

## Land and water, 33,170 voxels

30,170 voxels of land and 3,000 of water over a height field. The [report](../papers.md) on water with voxels states {number(figures['paper_ms'])} ms per frame
for a scene of as many voxels, including a picture of 1920 x 1080 pixels, on another machine. That is {ratio(figures['paper_ms'] / ours)} times the median
of the first row, which is for the mesh alone.

{rows_table(figures['scene'])}

{fields}"""
