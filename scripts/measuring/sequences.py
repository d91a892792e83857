"""Sequences of many frames in one run, beside loops of single conversions."""

import shutil

from measuring import processes, programs, record
from measuring.tables import median, number, ratio, table

NAME = "sequences"
TITLE = "Sequences: time, memory and open files"
LIMIT = "256M"  # --memory-limit of the first part
MEASURES = ("wall", "cpu", "peak")


def alternate(setting, contestants, rounds):
    """Shell commands [(what it is, command, folder of its outputs, their number)] in turn, after a round that is thrown
    away. The first is what the others are compared with."""
    measured = {name: [] for name, *_ in contestants}
    facts = {}
    for i in range(rounds + 1):
        for name, command, output, frames in contestants:
            folder = setting.folder / output
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            found = processes.run_once(["bash", "-ec", f"PATH={setting.folder / 'bin'}:$PATH; {command}"], cwd=setting.folder)
            files = [path for path in folder.iterdir() if path.suffix != ".manifest"]
            if len(files) != frames:
                raise programs.Failed(f"{command}\nmade {len(files)} files of {frames}")
            facts[name] = {"bytes": sum(path.stat().st_size for path in files)}
            if files[0].suffix == ".ply":
                facts[name]["triangles"] = sum(map(processes.ply_triangles, files))
            if i > 0:
                measured[name].append(found)
    rows = []
    first = measured[contestants[0][0]]
    for name, command, _, frames in contestants:
        row = {"name": name, "command": command, "frames": frames, **facts[name]}
        for measure in MEASURES:
            row[measure] = processes.summary([one[measure] for one in measured[name]])
            row[f"{measure}_first_to_this"] = median([a[measure] / b[measure] for a, b in zip(first, measured[name])])
        rows.append(row)
    shutil.rmtree(setting.folder / contestants[0][2])
    return rows


def demo_frames(setting, rounds):
    frames, size = (6, 32) if setting.quick else (200, 192)
    name = f"demo:metaballs?size={size}&time=0.{{:03}}"
    batch = f"isoextract '{name}' --frames 0-{frames - 1} --iso 0.5 --memory-limit {LIMIT} -q -o 'frames/f_{{:03}}.glb'"
    loop = (f"for i in $(seq -w 000 {frames - 1:03}); do isoextract 'demo:metaballs?size={size}&time=0.'$i --iso 0.5 "
            f"--memory-limit {LIMIT} -q -o frames/f_$i.glb; done")
    cores = record.cores()
    contestants = [("frames side by side", f"{batch} --jobs {cores}", "frames", frames),
                   ("one frame at a time, on all threads", f"{batch} --jobs 1", "frames", frames),
                   ("one frame at a time, on one thread", f"{batch} --jobs 1 --threads 1", "frames", frames),
                   ("a loop of single conversions", loop, "frames", frames)]
    return {"frames": frames, "memory_limit": LIMIT, "rows": alternate(setting, contestants, rounds)}


def vdb_frames(setting, rounds):
    """A sequence of real files, repeated by links. vdb_tool makes meshes of level sets only, so the copies call their
    grids that; samples and sizes stay as they are, and so does isoextract's mesh."""
    found = sorted((setting.data / "vdb" / "c42_gas_seq").glob("*.vdb"))
    if not found or not shutil.which("vdb_tool"):
        return None
    frames = 5 if setting.quick else 50
    folder = setting.folder / "vdb"
    folder.mkdir(exist_ok=True)
    for i, path in enumerate(found):
        (folder / f"copy_{i}.vdb").write_bytes(path.read_bytes().replace(b"fog volume", b"level set "))
    for i in range(frames):
        (folder / f"in_{i:03}.vdb").symlink_to(f"copy_{i % len(found)}.vdb")
    surface, mesh = "--grid density --iso 0.5 -q", "-ls2mesh adapt=0 iso=0.5"
    numbers = f"$(seq -w 000 {frames - 1:03})"
    commands = {
        "isoextract, all in one run": f"isoextract 'vdb/in_{{:03}}.vdb' {surface} -o 'frames/f_{{:03}}.ply'",
        "isoextract, a loop": f"for i in {numbers}; do isoextract vdb/in_$i.vdb {surface} -o frames/f_$i.ply; done",
        "vdb_tool, all in one run": f"vdb_tool -quiet -for n=0,{frames} -read grids=density 'vdb/in_{{$n:3:pad0}}.vdb' "
                                    f"{mesh} -write 'frames/f_{{$n:3:pad0}}.ply' -end",
        "vdb_tool, a loop": f"for i in {numbers}; do vdb_tool -quiet -read grids=density vdb/in_$i.vdb {mesh} "
                            "-write frames/f_$i.ply; done"}
    contestants = [(name, command, "frames", frames) for name, command in commands.items()]
    return {"frames": frames, "files": [path.name for path in found], "rows": alternate(setting, contestants, rounds)}


def quarters(samples):
    """Median and largest of resident memory and of open files, in the first and the last quarter of the samples."""
    part = max(1, len(samples) // 4)
    found = {}
    for name, chosen in (("first", samples[:part]), ("last", samples[-part:])):
        for i, key in ((1, "resident"), (2, "files")):
            values = [sample[i] for sample in chosen]
            found[f"{name}_{key}"] = {"median": median(values), "max": max(values)}
    return found


def tiny_frames(setting):
    frames, seconds = (300, 0.002) if setting.quick else (10000, 0.05)
    command = ["isoextract", "demo:sphere?size=16&time=0.{:05}", "--frames", f"0-{frames - 1}", "--iso", 0, "-q", "-o",
               "tiny/f_{:05}.glb", "--mkdir"]
    first = setting.folder / "tiny" / "f_00000.glb"
    watcher = processes.Watcher(seconds, first.exists)
    found = processes.run_once([setting.isoextract, *command[1:]], cwd=setting.folder, watch=watcher)
    shutil.rmtree(setting.folder / "tiny")
    if len(watcher.samples) < 4:
        raise programs.Failed(f"a run of {frames} frames was over before it was looked at")
    words = [f"'{word}'" if set("?{") & set(str(word)) else str(word) for word in command]
    return {"command": " ".join(words), "frames": frames, **found, "samples": len(watcher.samples), "every": seconds,
            **quarters(watcher.samples)}


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    rounds = 1 if setting.quick else 3
    (setting.folder / "bin").mkdir(exist_ok=True)
    (setting.folder / "bin" / "isoextract").unlink(missing_ok=True)
    (setting.folder / "bin" / "isoextract").symlink_to(setting.isoextract)
    # wait4 reports at least the memory that the parent had when it started the process.
    floor = processes.run_once(["true"])["peak"]
    figures = {"rounds": rounds, "peak_floor": floor, "demo": demo_frames(setting, rounds), "vdb": vdb_frames(setting, rounds),
               "tiny": tiny_frames(setting)}
    commands = [row["command"] for part in ("demo", "vdb") if figures[part] for row in figures[part]["rows"]]
    versions = {}
    if figures["vdb"]:
        versions["vdb_tool"] = record.first_line(["vdb_tool", "-version"]).removeprefix("vdb_tool: ")
    return measured.finish([record.cores()], versions, [*commands, figures["tiny"]["command"]], figures)


def rows_of(part):
    for row in part["rows"]:
        others = [ratio(row[f"{measure}_first_to_this"]) for measure in MEASURES]
        yield [row["name"], number(row.get("triangles")), number(row["bytes"] / 2**20), number(row["wall"]["median"]),
               number(part["frames"] / row["wall"]["median"]), number(row["cpu"]["median"]),
               number(round(row["peak"]["median"])), *(["", "", ""] if row is part["rows"][0] else others)]


COLUMNS = ["what", "triangles:", "written, MiB:", "wall, s:", "frames per second:", "processor time, s:", "peak, MiB:",
           "first row / this row, wall:", "processor time:", "peak:"]


def vdb_page(part):
    if not part:
        return "## Files\n\nNot measured: the files or `vdb_tool` were not there.\n"
    return f"""## Files, beside `vdb_tool`

{part['frames']} frames, which are links to {len(part['files'])} files of a smoke simulation, {part['files'][0]} to {part['files'][-1]}: grid `density`,
iso value 0.5, to PLY without normals. `vdb_tool` makes meshes of level sets only. So both programs read copies of the files
that declare their grids to be level sets; the samples are the same. `vdb_tool` ran without adaptivity, and each of its
quads counts as two triangles.

{table(COLUMNS, rows_of(part))}
"""


def page(measured):
    figures = measured["figures"]
    demo, tiny = figures["demo"], figures["tiny"]
    watched = [[name, number(tiny[f"first_{key}"]["median"]), number(tiny[f"first_{key}"]["max"]),
                number(tiny[f"last_{key}"]["median"]), number(tiny[f"last_{key}"]["max"]),
                ratio(tiny[f"last_{key}"]["median"] / tiny[f"first_{key}"]["median"])]
               for name, key in (("resident memory, MiB", "resident"), ("open files", "files"))]
    by_name = {row["name"]: row for row in demo["rows"]}
    size = demo["rows"][0]["command"].partition("size=")[2].partition("&")[0]
    cores = measured["threads"][0]
    alone = by_name["one frame at a time, on one thread"]["wall_first_to_this"]
    shared = by_name["one frame at a time, on all threads"]["wall_first_to_this"]
    return f"""Wall time, processor time and peak memory of commands that convert many frames.

- In the first two sections, times are warm: the median of {figures['rounds']} rounds. Each round runs all commands in turn; a first round
  does not count. The last section is a single run.
- The columns *first row / this row* compare each command with that of the first row. They are the median of the rounds'
  ratios; below 1, the first row is faster or needs less memory.
- *Peak* is the largest memory of one process. A peak below {number(figures['peak_floor'])} MiB, which the measuring process needs itself, shows as
  that number.

## Frames side by side

{demo['frames']} frames of a demo field of {size}³ samples to GLB, on {cores} cores, with `--memory-limit {demo['memory_limit']}`. {cores} frames at a time,
each on one thread, are {number(1 / alone)} times as fast as one frame at a time on one thread, and {number(1 / shared)} times as fast as one frame
at a time on all threads.

{table(COLUMNS, rows_of(demo))}

{vdb_page(figures['vdb'])}
## {number(tiny['frames'])} small frames

A sphere of 16³ samples in each frame: one run took {number(tiny['wall'])} s, {number(tiny['frames'] / tiny['wall'])} frames per second. The table has the
resident memory and the open files of the process, which were read from `/proc` every {number(tiny['every'])} s, {number(tiny['samples'])} times:

{table(["what", "first quarter, median:", "first quarter, most:", "last quarter, median:", "last quarter, most:", "last / first, median:"], watched)}
"""
