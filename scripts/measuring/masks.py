"""Surfaces of masks: terraces, volume, distance and time, by method and option, beside VTK's."""

import hashlib
import json
from concurrent.futures import ThreadPoolExecutor

from measuring import programs, record
from measuring.tables import median, number, percent, table

NAME = "masks"
TITLE = "Surfaces of masks"
PYTHON = "/usr/bin/python3"  # which has NumPy and SciPy
HERE = record.ROOT / "scripts" / "measuring"
NEWER_VTK = record.ROOT / "build" / "newer_vtk"
RADIUS = 20
FIRST = "ball"

# The name of a mask, its file, and the limit: samples above it are inside. Two heads are cut to their middle, to save time.
SCANS = (
    ("tooth", "med/tooth.nhdr", 500),
    ("head", "med/ch2.nii.gz", 60, 128),
    ("patient", "med/MR.nii.gz", 120, 128),
    ("brain", "med/FLAIR.nrrd", 60),
    ("small head", "med/HeadMRVolume.mhd", 60),
    ("chest", "med/LIDC2.vti", 130),
    ("enzyme", "mol/betaGal.npy", 0.05),
    ("orbital", "sim/hydrogen.vti", 0.1),
    ("smoke", "vdb/smoke.vdb", 0.5),
    ("vase", "sim/vase_1comp.vti", 60),
)
QUICK = ("tooth", "enzyme")
PICTURE = "masks.png"
PICTURED = "tooth"

NETS = ("--method", "surface-nets")
CUBES = ("--method", "mc", "--iso", "0.5")
OURS = (
    (*NETS, "--relax", "0"), NETS, (*NETS, "--relax", "30"), (*NETS, "--relax", "100"),
    CUBES, (*CUBES, "--blur", "1"), (*CUBES, "--smooth", "20:sinc"),
)
PEERS = (
    ("vtkSurfaceNets3D, not smoothed", "nets-0"),
    ("vtkSurfaceNets3D", "nets"),
    ("vtkSurfaceNets3D, 100 iterations", "nets-100"),
    ("vtkDiscreteFlyingEdges3D", "edges"),
    ("vtkDiscreteFlyingEdges3D, sinc filter 0.1", "edges-sinc-0.1"),
    ("vtkDiscreteFlyingEdges3D, sinc filter 0.01", "edges-sinc-0.01"),
)
SHOWN = (OURS.index(CUBES), OURS.index(NETS), len(OURS) + 1)  # of all ways
STAGES = (*programs.EXTRACTION, "filter", "smooth")  # from samples in memory to a mesh in memory


def quality(*arguments):
    return json.loads(programs.run([PYTHON, HERE / "mask_quality.py", *arguments]) or "null")


def mask_of(setting, name, file, limit, *cut):
    """Makes the mask of a scan; returns its path and its facts."""
    field, path = setting.data / file, setting.folder / "mask.npy"
    if field.suffix not in (".vti", ".mhd"):  # mask_quality.py reads .vti and .mhd with VTK
        field = setting.folder / "field.nrrd"
        programs.run([setting.isoextract, setting.data / file, "-o", field, "-q"])
    return path, {"name": name, "file": file, "limit": limit, **quality("mask", field, limit, path, *cut)}


def milliseconds(report, clock):
    return 1000 * sum(stage[clock] for stage in report["stages"] if stage["stage"] in STAGES)


def ours(setting, path, options, rounds, mesh):
    """Writes a mesh of the program; returns its row, still without the figures of quality."""
    report = setting.folder / "report.json"
    row = {"way": f"`{' '.join(options)}`", "ms": [], "cpu_ms": []}
    for _ in range(rounds):
        programs.run([setting.isoextract, path, *options, "-o", mesh, "--report", report, "-q"])
        found = json.loads(report.read_text())
        row["ms"].append(milliseconds(found, "wall_seconds"))
        row["cpu_ms"].append(milliseconds(found, "cpu_seconds"))
    for relaxation in found.get("relaxations", []):
        row["relaxation"] = {key: relaxation[key] for key in ("components", "changed_components", "worst_component")}
    return row


def peer(path, title, way, rounds, mesh, versions):
    """Writes a mesh of VTK; returns its row, still without the figures of quality."""
    found = json.loads(programs.run([HERE / "newer_vtk", "python", NEWER_VTK, HERE / "mask_peers.py", path, way, rounds, mesh]))
    versions["VTK"] = found["vtk"]
    return {"way": title, "ms": found["ms"], "cpu_ms": found["cpu_ms"]}


def meshes_of(setting, path, rounds, versions):
    """Returns the meshes of a mask and their rows, still without the figures of quality."""
    meshes = [setting.folder / f"mesh_{n}.ply" for n in range(len(OURS) + len(PEERS))]
    rows = [ours(setting, path, options, rounds, mesh) for options, mesh in zip(OURS, meshes)]
    rows += [peer(path, *of_peer, rounds, mesh, versions) for of_peer, mesh in zip(PEERS, meshes[len(OURS):])]
    return meshes, rows


def judged(path, meshes, rows, radius):
    """Returns the rows with the quality of their meshes. Runs on all cores, so nothing is timed meanwhile."""
    with ThreadPoolExecutor(record.cores()) as pool:
        found = pool.map(lambda mesh: quality("surface", path, mesh, *radius), meshes)
        return [{**row, **of_mesh} for row, of_mesh in zip(rows, found)]


def picture(setting, meshes, width):
    """Draws the meshes of SHOWN side by side; returns name and hash of the picture."""
    shown = [setting.folder / f"shown_{place}.ply" for place in range(len(SHOWN))]
    for place, (way, mesh) in enumerate(zip(SHOWN, shown)):
        quality("shift", meshes[way], place * width, mesh)
    path = setting.out / PICTURE
    programs.run([setting.isoextract, "render", *shown, "--shading", "flat", "--camera", f"0,15,{2.5 * width:g}", "--size", "960x400",
                  "--background", "eaecf0", "--backend", "cpu", "-o", path, "-q"])
    return {"file": PICTURE, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def measure(setting):
    programs.run([HERE / "newer_vtk", "unpack", NEWER_VTK])
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rounds = 2 if setting.quick else 5
    versions, figures = {}, {"rounds": rounds, "masks": []}
    ball = setting.folder / "ball.npy"
    quality("ball", RADIUS, ball)
    for name, *scan in ((FIRST,), *SCANS):
        if setting.quick and name not in (FIRST, *QUICK):
            continue
        path, mask = (ball, {"name": name}) if name == FIRST else mask_of(setting, name, *scan)
        meshes, rows = meshes_of(setting, path, rounds, versions)
        if name == PICTURED:
            figures["picture"] = picture(setting, meshes, mask["size"][0])
        figures["masks"].append({**mask, "rows": judged(path, meshes, rows, [RADIUS] if name == FIRST else [])})
    commands = [f"mask_quality.py ball {RADIUS} mask.npy", "isoextract tooth.nhdr -o field.nrrd",
                "mask_quality.py mask field.nrrd 500 mask.npy",
                *(f"isoextract mask.npy {' '.join(options)} -o mesh.ply --report report.json" for options in OURS),
                "newer_vtk unpack build/newer_vtk",
                *(f"newer_vtk python build/newer_vtk mask_peers.py mask.npy {way} {rounds} mesh.ply" for _, way in PEERS),
                "mask_quality.py surface mask.npy mesh.ply",
                "isoextract render shown_0.ply shown_1.ply shown_2.ply --shading flat -o masks.png"]
    return measured.finish([record.cores()], versions, commands, figures)


def files(measured):
    """Returns names and hashes of the files beside the record."""
    return [measured["figures"]["picture"]]


def changed(value):
    """Returns a volume, as a part of another one, as a difference in percent."""
    return f"{100 * (value - 1):+.2f} %"


def ball_table(rows):
    return table(["", "triangles:", "terraces:", "volume:", "distance, voxels:", "lost, voxels:", "gained:", "cold, ms:", "processor, ms:"],
                 [[row["way"], number(row["triangles"]), f"{row['angle']:.1f}°", changed(row["volume"]), f"{row['distance']:.2f}",
                   number(row["lost"]), number(row["gained"]), number(median(row["ms"])), number(median(row["cpu_ms"]))] for row in rows])


def summary(masks):
    """Returns the table of all scans: a row for each way."""
    rows = []
    for ways in zip(*(mask["rows"] for mask in masks)):
        volumes = [row["volume"] for row in ways]
        rows.append([ways[0]["way"], f"{median([row['angle'] for row in ways]):.1f}°",
                     f"{changed(min(volumes))} to {changed(max(volumes))}", f"{max(row['distance'] for row in ways):.2f}",
                     number(sum(row["lost"] for row in ways)), number(sum(row["gained"] for row in ways)),
                     *(number(sum(median(row[clock]) for row in ways)) for clock in ("ms", "cpu_ms"))])
    return table(["", "terraces, median:", "volume:", "largest distance, voxels:", "lost, voxels:", "gained:", "cold, ms, sum:",
                  "processor, ms, sum:"], rows)


def by_mask(masks, text):
    """Returns the table of one figure: a row for each way, a column for each mask."""
    return table(["", *(f"{mask['name']}:" for mask in masks)],
                 [[ways[0]["way"], *map(text, ways)] for ways in zip(*(mask["rows"] for mask in masks))])


def components(masks):
    """Returns the table of the components whose volume the smoothing changed, as the reports have it."""
    def text(row):
        found = row["relaxation"]
        worst = found["worst_component"]
        return f"{number(found['changed_components'])}; {changed(worst['after'] / worst['before'])}"

    relaxed = [[row for row in mask["rows"] if "relaxation" in row] for mask in masks]
    return table(["", "components:", *(f"{row['way']}:" for row in relaxed[0])],
                 [[mask["name"], number(rows[0]["relaxation"]["components"]), *map(text, rows)]
                  for mask, rows in zip(masks, relaxed)])


def page(measured):
    figures = measured["figures"]
    ball, *scans = figures["masks"]
    sizes = table(["mask", "file", "samples above:", "size, voxels:", "voxels inside:", "bodies:"],
                  [[mask["name"], f"`{mask['file']}`", number(mask["limit"]), " x ".join(map(str, mask["size"])),
                    number(mask["voxels"]), number(mask["bodies"])] for mask in scans])
    sections = "\n\n".join(f"### {title}\n\n{by_mask(scans, text)}" for title, text in (
        ("Terraces", lambda row: f"{row['angle']:.1f}°"),
        ("Volume", lambda row: changed(row["volume"])),
        ("Largest distance, voxels", lambda row: f"{row['distance']:.2f}"),
        ("Voxels lost", lambda row: number(row["lost"])),
        ("Voxels gained", lambda row: number(row["gained"])),
        ("Cold time, ms", lambda row: number(median(row["ms"]))),
        ("Triangles", lambda row: number(row["triangles"]))))
    return f"""For people who have a mask, such as one organ of a scan, and choose how its surface is made.

| figure | meaning |
|---|---|
| terraces | the mean angle between the normals of two triangles with a common edge: large if the surface still has the steps of the voxels |
| volume | the volume of the mesh compared with that of the voxels |
| distance | the largest distance from a vertex or the center of a triangle to the nearest face between voxels inside and outside (first table: to the ball) |
| lost, gained | voxels of the mask whose center is outside the mesh; voxels outside the mask whose center is inside the mesh |
| cold, ms | wall time from samples in memory to a mesh in memory, each run in a new process; median of {figures['rounds']} runs |
| processor, ms | processor time of all threads in the same runs |

NumPy computes the first four figures from the written mesh, without code of isoextract. Lengths are in voxels, whatever the spacing of the scan.

Rows with `--` are isoextract, the others VTK with default settings unless the row names others. VTK has surface nets since version 9.3, so
`scripts/measuring/newer_vtk` unpacks a newer VTK than Debian 12 has. "Sinc filter 0.1" is `vtkWindowedSincPolyDataFilter` with 20 iterations
and the pass band 0.1; 3D Slicer uses 0.01 if its smoothing factor is 0.5. Both programs use all cores. VTK extracts the surface of a few
voxels before the clock starts, so its times exclude loading libraries and starting threads. isoextract's times include starting threads.

## A ball

A ball with a radius of {RADIUS} voxels. Distances are to the ball itself, not to the faces of its voxels.

{ball_table(ball["rows"])}

## Ten scans

Each mask has the samples of a file above a limit, with all noise. `head` and `patient` have only the middle 128 samples along each axis.
*Bodies* counts the sets of voxels that are connected through faces.

{sizes}

The tooth by {", ".join(ball["rows"][way]["way"] for way in SHOWN)}, from left to right:

![The surface of a tooth in three ways]({figures["picture"]["file"]})

All masks together:

{summary(scans)}

The last step of `--method surface-nets` gives each component the volume of its voxels. For some components, neighboring voxels leave too
little room for this. The table has the number of components whose volume changed by more than 0.1 %, and the largest change of a component.

{components(scans)}

{sections}
"""
