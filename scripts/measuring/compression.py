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
# Options of gltfpack, which reads the first file of OURS. 16 bits as in --draco=16.
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
    columns = ["command", "triangles:", "MB:", "of the plain file:", "bytes per triangle:", "whole command, s:", "more than plain, s:",
               "reading, ms:"]
    return f"""One mesh with smooth normals, written as GLB in several ways.

- **isoextract** extracts the surface and writes the file. The first row writes a *plain* file without compression. The column
  *more than plain* is the time of a row minus the time of the plain file: the time for compression.
- **`gltfpack`**, the npm package, reads the plain file and writes its own file. Its time includes the start of Node.
- **Precision**: `--meshopt` alone and `-noq` keep float32 positions. `--quantize` and `--draco` without a number round positions
  to steps of at most 1/32 voxel. `--draco=16` and `-vp 16` use at most 16 bits for the longest side.
- **Reading** is the time in which glTF-Transform decodes the file from memory, with the WebAssembly decoders of Draco and meshoptimizer.
- **All times are warm.** Each round runs every command once. A first round does not count; the table has the median of
  {figures['rounds']} rounds. Reading is the median of {figures['rounds']} runs per file, after one that does not count.

{table(columns, rows)}
"""
