"""How small glTF files get, and what that takes."""

import json
import shutil

from measuring import processes, programs, record
from measuring.tables import number, percent, table

NAME = "compression"
TITLE = "How small glTF files get, beside `gltfpack`"
NODE = record.ROOT / "scripts" / "measuring" / "gltf"
ISO = "0.5"

# Options of a conversion to GLB; the first is what the others are compared with.
OURS = ((), ("--quantize",), ("--meshopt",), ("--quantize", "--meshopt"), ("--quantize", "--meshopt", "--optimize-order"),
        ("--draco",), ("--draco=16",))
# Options of gltfpack, which reads what the first of them wrote. 16 bits as isoextract's.
PACKED = (("-noq", "-c"), ("-vp", "16"), ("-vp", "16", "-c"), ("-vp", "16", "-cc"))


def packages():
    """Node's packages; installed where they are not yet."""
    if not shutil.which("npm"):
        raise programs.Failed("no npm: scripts/setup.sh measure installs it")
    installed, wanted = NODE / "node_modules" / ".package-lock.json", NODE / "package-lock.json"
    if not installed.exists() or installed.stat().st_mtime < wanted.stat().st_mtime:
        programs.run(["npm", "ci", "--prefix", NODE, "--no-audit", "--no-fund"])
    return json.loads((NODE / "package.json").read_text())["dependencies"]


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    versions = packages()
    source = "demo:gyroid?size=48" if setting.quick else setting.data / "vdb" / "smoke.vdb"
    if not setting.quick and not source.exists():
        raise programs.Failed(f"no {source.name}: --data names the folder of real volumes")
    iso = "0" if setting.quick else ISO
    rounds = 2 if setting.quick else 9
    runs = []  # [the program, its command, its file]
    for options in OURS:
        file = setting.folder / f"isoextract_{len(runs)}.glb"
        runs.append(("isoextract", [setting.isoextract, source, "--iso", iso, *options, "-o", file, "-q"], file))
    plain = runs[0][2]
    for options in PACKED:
        file = setting.folder / f"gltfpack_{len(runs)}.glb"
        runs.append(("gltfpack", [NODE / "node_modules" / ".bin" / "gltfpack", "-i", plain, "-o", file, *options], file))
    times = [[] for _ in runs]
    for i in range(rounds + 1):
        for own, (_, command, _) in zip(times, runs):
            found = processes.run_once(command)
            if i > 0:
                own.append(found["wall"])
    decoded = json.loads(programs.run(["node", NODE / "decode.mjs", rounds, *(file for *_, file in runs)]))
    rows = []
    for (program, command, file), own, reading in zip(runs, times, decoded):
        rows.append({"program": program, "command": programs.shown(command), "bytes": file.stat().st_size,
                     "seconds": processes.summary(own), "triangles": reading["triangles"], "vertices": reading["vertices"],
                     "decode_ms": processes.summary(reading["milliseconds"])})
    return measured.finish([record.cores()], versions, [row["command"] for row in rows], {"rounds": rounds, "rows": rows})


def page(measured):
    figures = measured["figures"]
    first = figures["rows"][0]
    plain = first["bytes"]
    rows = [[f"`{row['command']}`", number(row["triangles"]), number(row["bytes"] / 1e6), percent(row["bytes"] / plain),
             number(row["bytes"] / row["triangles"]), number(row["seconds"]["median"]),
             number(row["seconds"]["median"] - first["seconds"]["median"]) if row["program"] == "isoextract" else "",
             number(row["decode_ms"]["median"])] for row in figures["rows"]]
    columns = ["command", "triangles:", "MB:", "of plain:", "bytes a triangle:", "whole command, s:", "more than plain, s:",
               "reading, ms:"]
    return f"""One mesh with smooth normals as GLB. isoextract goes from the volume to the file, so what packing takes is the time beyond
that of a plain file; `gltfpack`, the npm package, goes from the plain file to its own, with the start of Node in its time.
`--meshopt` alone loses nothing, and `-noq` keeps floats; `--quantize` and `-vp 16` round positions to 16 bits, `--draco` to
a 32nd of a voxel at most. Reading is by glTF-Transform with the decoders of Draco and meshoptimizer as WebAssembly, in memory.
All are warm: the median of {figures['rounds']} after a first, the commands in turn.

{table(columns, rows)}
"""
