"""Particles to meshes: time, memory and error on balls of a known radius; beside `vdb_tool` and splashsurf's figures."""

import json
import multiprocessing
import pathlib
import shutil

from measuring import processes, programs, record
from measuring.tables import median, number, percent, ratio, table

import particle_clouds as clouds  # of tests/support, where `processes` looks for modules

NAME = "particles"
TITLE = "Particles: time, memory and error"
JITTER = 0.4  # of the lattice, in radii
METHODS = ("sph", "anisotropic", "weight", "smooth")
CELLS = (1.5, 1, 0.75, 0.5, 0.35)  # of the dented ball, in radii
STRAY = 1e5  # how far the stray is along each axis, in radii
# Files of splashsurf's own tests: their names in the shared data, and between which numbers of triangles its tests
# (splashsurf_lib/tests/integration_tests/test_full.rs) expect the mesh. All with these parameters.
SPLASHSURF = {"octocat_32614_particles.bgeo": (140000, 180000), "bunny_frame_14_7705_particles.vtk": (60000, 80000)}
SPLASHSURF_OPTIONS = ["--radius", "0.025", "--smoothing-length", "2", "--cell-size", "0.75", "--iso", "0.6"]
# Figures of splashsurf's README for a scene that is not in the shared data.
CANYON = {"particles": 13353401, "seconds": 2.93577, "triangles": 6023244, "version": "0.6.0",
          "machine": "Ryzen 9 5950X, 16 cores", "options": ["--smoothing-length", "2", "--cell-size", "1.5", "--iso", "0.6"]}
LATTICE = "double_dam_break_frame_01_4732_particles.vtk"


def from_known(x, y, z, radius):
    return (x * x + y * y + z * z) ** 0.5 - radius


def from_dented(x, y, z):
    return (x * x + y * y + z * z) ** 0.5 - clouds.dented_radius(x, y, z)


def mesh_facts(path, known):
    """Facts of a PLY file: triangles, volume, and distances from the shape `known`, a radius or "dented"."""
    vertices, polygons = clouds.polygons_of_ply(path)
    facts = {"triangles": sum(len(polygon) - 2 for polygon in polygons), "volume": clouds.volume_of(vertices, polygons)}
    if known == "dented":
        return facts | clouds.distance_facts(vertices, from_dented)
    return facts | clouds.distance_facts(vertices, lambda x, y, z: from_known(x, y, z, known))


def apart(function, *arguments):
    """Calls a function in a process of its own: its memory does not show in the peaks of later processes."""
    with multiprocessing.Pool(1) as pool:
        return pool.apply(function, arguments)


def write_cloud(kind, count, path, stray=False):
    """Writes a file of particles; returns its name, number of particles and radius."""
    radius, layers = getattr(clouds, kind)(count, JITTER)
    layers = list(layers)
    if stray:
        layers += clouds.as_layers([[STRAY * radius, -STRAY * radius, STRAY * radius]])
    return {"file": path.name, "particles": clouds.write_ply(path, layers), "radius": radius}


class Runs:
    """Commands that run in turn, after a round that is thrown away."""

    def __init__(self, setting):
        self.setting = setting
        self.contestants = []  # [facts, command, mesh, report or None]

    def ours(self, facts, cloud, *options):
        stem = self.setting.folder / f"mesh_{len(self.contestants)}"
        mesh, report = stem.with_suffix(".ply"), stem.with_suffix(".json")
        command = [self.setting.isoextract, self.setting.folder / cloud["file"], "--radius", f"{cloud['radius']:.8g}",
                   *options, "-o", mesh, "-q"]
        self.contestants.append((facts | {"command": programs.shown(command)}, command + ["--report", report], mesh, report))

    def other(self, facts, command, mesh):
        self.contestants.append((facts | {"command": programs.shown(command)}, command, mesh, None))

    def measure(self, rounds, known=None):
        """A row for each; `known` as mesh_facts() takes it."""
        rows = [facts for facts, *_ in self.contestants]
        found = [[] for _ in rows]
        for i in range(rounds + 1):
            for own, (_, command, _, report) in zip(found, self.contestants):
                one = processes.run_once(command, cwd=self.setting.folder)
                if report:
                    told = json.loads(report.read_text())
                    one |= {"field": told["particles"]["time"]["wall_seconds"], "peak": told["peak_memory_bytes"] / 2**20,
                            "reserved": told["reserved_memory_bytes"] / 2**20,
                            "closed": all(mesh["closed"] for mesh in told["meshes"])}
                if i > 0:
                    own.append(one)
        for row, own, (_, _, mesh, report) in zip(rows, found, self.contestants):
            for measure in ("wall", "cpu", "peak", *(("field", "reserved") if report else ())):
                row[measure] = processes.summary([one[measure] for one in own])
            if report:
                row["closed"] = own[-1]["closed"]
                report.unlink()
            if known is not None:
                row |= apart(mesh_facts, mesh, known)
            else:
                row["triangles"] = processes.ply_triangles(mesh)
            mesh.unlink()
        return rows


def measure_methods(setting, cloud, rounds):
    runs = Runs(setting)
    for method in METHODS:
        for threads in sorted({1, min(2, record.cores())}):
            runs.ours({"method": method, "threads": threads}, cloud, "--particles", method, "--threads", threads)
    return runs.measure(rounds, clouds.ball_radius(cloud["particles"], cloud["radius"]))


def measure_stray(setting, cloud, strayed, rounds):
    rows = []
    for method in METHODS:
        runs = Runs(setting)
        for one in (cloud, strayed):
            runs.ours({"method": method, "file": one["file"]}, one, "--particles", method)
        without, with_one = runs.measure(rounds)
        rows.append({"method": method, "without": without, "with": with_one})
    return rows


def measure_vdb_tool(setting, clouds_and_widths, rounds):
    """At a voxel of half a radius, the coarsest at which OpenVDB takes such particles. `widths`: radii of the balls that
    vdb_tool makes of particles, in particle radii."""
    if not shutil.which("vdb_tool"):
        return None
    parts = []
    for cloud, widths in clouds_and_widths:
        runs = Runs(setting)
        runs.ours({"name": "isoextract"}, cloud, "--cell-size", "0.5")
        for width in widths:
            mesh = setting.folder / f"vdb_{width}.ply"
            command = ["vdb_tool", "-quiet", "-read", setting.folder / cloud["file"], "-points2ls",
                       f"voxel={cloud['radius'] / 2:.8g}", f"radius={2 * width:g}", "-ls2mesh", "-write", mesh]
            runs.other({"name": f"vdb_tool, balls of {width:g} radii"}, command, mesh)
        parts.append({"cloud": cloud, "rows": runs.measure(rounds, clouds.ball_radius(cloud["particles"], cloud["radius"]))})
    return parts


def as_ply(setting, path):
    """Copies a file of the shared data; converts legacy VTK files, for which the program needs a plug-in, to PLY."""
    if path.suffix != ".vtk":
        shutil.copy(path, setting.folder / path.name)
        return path.name
    name = path.with_suffix(".ply").name
    clouds.write_ply(setting.folder / name, clouds.as_layers(clouds.vtk_points(path)))
    return name


def measure_splashsurf(setting, cloud, rounds):
    folder = setting.data / "particles"
    runs = Runs(setting)
    for name, expected in SPLASHSURF.items():
        if not (folder / name).exists():
            return None
        taken = {"file": as_ply(setting, folder / name), "radius": 0.025}
        runs.ours({"file": name, "expected": expected}, taken, *SPLASHSURF_OPTIONS[2:])
    rows = runs.measure(rounds)
    runs = Runs(setting)
    runs.ours({"particles": cloud["particles"]}, cloud, *CANYON["options"])
    return {"rows": rows, "canyon": CANYON, "ours": runs.measure(rounds)[0]}


def measure_dents(setting, cloud, rounds):
    runs = Runs(setting)
    for cell in CELLS[:2] if setting.quick else CELLS:
        for method in ("sph", "anisotropic"):
            runs.ours({"method": method, "cell": cell}, cloud, "--particles", method, "--cell-size", cell)
    return runs.measure(rounds, "dented")


def lattice_spreads(path, mesh, radius):
    """Spreads of the faces of the double dam break's two blocks, which lie on either side of x = 0."""
    points = clouds.vtk_points(path)
    vertices, _ = clouds.polygons_of_ply(mesh)
    spreads = []
    for side in (-1, 1):
        spreads.append(clouds.face_spreads([p for p in points if side * p[0] > 0], [v for v in vertices if side * v[0] > 0],
                                           radius))
    return spreads


def measure_lattice(setting):
    path = setting.data / "particles" / LATTICE
    if not path.exists():
        return None
    rows = []
    for method in ("sph", "anisotropic"):
        mesh = setting.folder / "lattice_mesh.ply"
        command = [setting.isoextract, setting.folder / as_ply(setting, path), "--radius", "0.025", "--particles", method, "-o",
                   mesh, "-q"]
        programs.run(command)
        rows.append({"method": method, "command": programs.shown(command), "spreads": lattice_spreads(path, mesh, 0.025)})
    return rows


def commands_of(figures):
    """The commands that ran, each once, in the order of the page."""
    rows = [*figures["methods"], *(part[which] for part in figures["stray"] for which in ("without", "with"))]
    rows += [row for part in figures["vdb_tool"] or () for row in part["rows"]]
    if figures["splashsurf"]:
        rows += [*figures["splashsurf"]["rows"], figures["splashsurf"]["ours"]]
    rows += [*figures["dents"], *(figures["lattice"] or ())]
    return list(dict.fromkeys(row["command"] for row in rows))


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rounds = 1 if setting.quick else 3
    many, fewer = (4000, 2000) if setting.quick else (1000000, 100000)
    made = {}
    for name, kind, count, stray in (("ball", "ball", many, False), ("stray", "ball", many, True),
                                     ("small", "ball", fewer, False), ("dented", "dented_ball", fewer, False)):
        made[name] = apart(write_cloud, kind, count, setting.folder / f"{name}.ply", stray)
    figures = {"rounds": rounds, "peak_floor": processes.run_once(["true"])["peak"], "clouds": made,
               "methods": measure_methods(setting, made["ball"], rounds),
               "stray": measure_stray(setting, made["ball"], made["stray"], 1 if setting.quick else 3),
               "vdb_tool": measure_vdb_tool(setting, ((made["small"], (1, 2)), (made["ball"], (2,))), rounds),
               "splashsurf": measure_splashsurf(setting, made["ball"], rounds),
               "dents": measure_dents(setting, made["dented"], rounds), "lattice": measure_lattice(setting)}
    versions = {}
    if figures["vdb_tool"]:
        versions["vdb_tool"] = record.first_line(["vdb_tool", "-version"]).removeprefix("vdb_tool: ")
    threads = sorted({row["threads"] for row in figures["methods"]} | {record.cores()})
    return measured.finish(threads, versions, commands_of(figures), figures)


def volume_error(row, known):
    return percent(row["volume"] / known - 1)


def ball_volume(cloud):
    return cloud["particles"] * (2 * cloud["radius"]) ** 3


def methods_table(figures):
    cloud = figures["clouds"]["ball"]
    rows = [[f"`{row['method']}`", row["threads"], number(row["wall"]["median"]), number(row["field"]["median"]),
             number(round(cloud["particles"] / row["wall"]["median"])), number(row["peak"]["median"]),
             number(row["reserved"]["median"]), number(row["triangles"]), volume_error(row, ball_volume(cloud)),
             number(row["mean"] / cloud["radius"], 2), number(row["rms_about_mean"] / cloud["radius"], 2),
             number(row["max"] / cloud["radius"], 2)] for row in figures["methods"]]
    return table(["`--particles`", "threads:", "whole command, s:", "field, s:", "particles per second:", "peak, MiB:",
                  "reserved, MiB:", "triangles:", "volume:", "mean distance, radii:", "rms about the mean:", "largest distance:"], rows)


def stray_table(figures):
    rows = []
    for part in figures["stray"]:
        for key, name in (("peak", "resident"), ("reserved", "reserved")):
            without, with_one = (part[which][key]["median"] for which in ("without", "with"))
            rows.append([f"`{part['method']}`", name, number(without), number(with_one), ratio(with_one / without)])
    return table(["`--particles`", "memory", "ball, MiB:", "ball and far particle, MiB:", "ratio:"], rows)


def vdb_part(part):
    cloud, rows = part["cloud"], part["rows"]
    first = rows[0]["wall"]["rounds"]
    cells = [[row["name"], number(row["triangles"]), number(row["wall"]["median"]), number(row["cpu"]["median"]),
              number(row["peak"]["median"]), volume_error(row, ball_volume(cloud)), number(row["mean"] / cloud["radius"], 2),
              number(row["max_about_mean"] / cloud["radius"], 2),
              "" if row is rows[0] else ratio(median([a / b for a, b in zip(first, row["wall"]["rounds"])]))] for row in rows]
    return f"""{number(cloud['particles'])} particles:

{table(["program", "triangles:", "whole command, s:", "processor, s:", "peak, MiB:", "volume:", "mean distance, radii:", "largest about the mean:", "isoextract / this row, time:"], cells)}
"""


def vdb_page(figures):
    if not figures["vdb_tool"]:
        return "## Beside `vdb_tool`\n\nNot measured: `vdb_tool` was not there.\n"
    return """## Beside `vdb_tool`

Whole commands from PLY to PLY. Samples are half a particle radius apart, because OpenVDB ignores particles with a radius below 1.5
voxels. `vdb_tool -points2ls` makes the union of balls. Balls of one particle radius leave gaps between them, and the mesh has the
surfaces of the gaps. Balls of two radii leave no gaps, but the surface is one radius farther out.

""" + "\n".join(map(vdb_part, figures["vdb_tool"]))


def splashsurf_page(figures):
    part = figures["splashsurf"]
    if not part:
        return "## Beside splashsurf's figures\n\nNot measured: the files were not there.\n"
    rows = [[f"`{row['file']}`", "{:,} to {:,}".format(*row["expected"]), number(row["triangles"]),
             "yes" if row["expected"][0] < row["triangles"] < row["expected"][1] else "**no**",
             "yes" if row["closed"] else "**no**", number(row["wall"]["median"])] for row in part["rows"]]
    canyon, ours = part["canyon"], part["ours"]
    return f"""## Beside splashsurf's figures

Files of splashsurf's own tests, with the parameters of these tests: radius 0.025, smoothing length 2 radii, cells of 0.75 radii, iso value 0.6.

{table(["file", "triangles that the test expects", "triangles:", "in this range", "closed", "whole command, s:"], rows)}

splashsurf's README states {number(canyon['seconds'])} s for {number(canyon['particles'])} particles ({canyon['machine']}, version {canyon['version']}, a smoothing length
of 2 radii, cells of 1.5 radii): {number(round(canyon['particles'] / canyon['seconds'] / 16))} particles per second and core. With the same parameters, isoextract converts the
ball above in {number(ours['wall']['median'])} s of wall time and {number(ours['cpu']['median'])} s of processor time: {number(round(ours['particles'] / ours['cpu']['median']))} particles per second of processor time.
Scenes and machines differ, so compare only the orders of magnitude.
"""


def dents_table(figures):
    cloud = figures["clouds"]["dented"]
    rows = [[f"`{row['method']}`", row["cell"], number(row["triangles"]), number(row["wall"]["median"]),
             number(row["mean"] / cloud["radius"], 2), number(row["rms_about_mean"] / cloud["radius"], 2),
             number(row["max_about_mean"] / cloud["radius"], 2)]
            for row in sorted(figures["dents"], key=lambda row: (row["method"] != "sph", -row["cell"]))]
    return table(["`--particles`", "`--cell-size`:", "triangles:", "whole command, s:", "mean distance, radii:",
                  "rms about the mean:", "largest about the mean:"], rows)


def gain(figures):
    """A sentence on time and roughness of anisotropic kernels, relative to `sph`, at their default cell size."""
    cells = sorted({row["cell"] for row in figures["dents"]}, key=lambda cell: abs(cell - 0.75))
    sph, anisotropic = ({row["method"]: row for row in figures["dents"] if row["cell"] == cells[0]}[method]
                        for method in ("sph", "anisotropic"))
    return (f"With cells of {cells[0]} radii, anisotropic kernels take {ratio(anisotropic['wall']['median'] / sph['wall']['median'])} times "
            f"the time of `sph`, and the surface has {ratio(anisotropic['rms_about_mean'] / sph['rms_about_mean'])} times its roughness.")


def lattice_page(figures):
    if not figures["lattice"]:
        return "## Flat faces\n\nNot measured: the file was not there.\n"
    rows = [[f"`{row['method']}`", number(max(max(block) for block in row["spreads"]), 2),
             number(median([spread for block in row["spreads"] for spread in block]), 2)] for row in figures["lattice"]]
    return f"""## Flat faces

`{LATTICE}`: two blocks of particles on a lattice, with twelve faces in all. The figure of a face is the range of
its vertices along the normal of the face, in radii, without a rim of four radii. A test allows at most 0.1.

{table(["`--particles`", "largest of the twelve faces:", "median:"], rows)}
"""


def page(measured):
    figures = measured["figures"]
    cloud, dented = figures["clouds"]["ball"], figures["clouds"]["dented"]
    return f"""Times are for whole commands, from PLY to PLY, and warm: the median of {figures['rounds']} rounds. Each round runs every command once; a first
round does not count. *Peak* is the resident memory of the process. A peak below {number(figures['peak_floor'])} MiB, which the measuring process
needs itself, shows as that number. *Reserved* is the memory that the program counts against `--memory-limit`.

## A ball

{number(cloud['particles'])} particles on a lattice within a ball, each shifted by up to {JITTER} radii along each axis. Each particle has the volume of a
cube two radii wide. Distances are those of the vertices from the ball that has the volume of all particles; positive is outside. Lengths are
in particle radii; the radius of the ball is {number(1 / cloud['radius'])}. The spacing of the samples is the default: 0.75 radii, 4 for `weight`, 0.5 for `smooth`.

{methods_table(figures)}

## One particle far away

The same ball and one more particle, {number(int(STRAY))} radii away along each axis: memory depends on the particles, not on the box around them.

{stray_table(figures)}

{vdb_page(figures)}
{splashsurf_page(figures)}
## Anisotropic kernels

A ball of {number(dented['particles'])} particles with {len(clouds.DENTS)} dents, which are {number(100 * clouds.DENT_DEPTH, 2)} % of its radius deep. Distances are along the radius. The iso value
determines the mean distance; the rms about the mean is the roughness. {gain(figures)}

{dents_table(figures)}

{lattice_page(figures)}"""
