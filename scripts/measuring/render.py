"""Pictures: how long one takes, by backend, with and without what rays leave out."""

import json

from measuring import programs, record
from measuring.tables import median, number, ratio, table

NAME = "render"
TITLE = "Ray casting: time per picture"
BACKENDS = ("cpu", "gpu")
SHORTCUTS = {
    "all": [],
    "no early termination": ["--termination", 0],
    "no empty-space skipping": ["--no-skipping"],
    "neither": ["--termination", 0, "--no-skipping"],
}
# A function that shows the inside of a ball, which is dense, and nothing of what is around it.
TRANSFER = "-1 0 0 0 0\n0 0.1 0.2 0.8 0\n0.3 0.9 0.6 0.2 0.2\n1 1 1 1 0.9\n"


def draw(setting, arguments):
    """The figures of one picture; None if the backend is not available (exit code 3)."""
    file = setting.folder / "render.json"
    command = [setting.isoextract, "render", *arguments, "-o", setting.folder / "render.png", "--json", file, "-q"]
    try:
        programs.run(command)
    except programs.Failed as problem:
        if "ended with 3" in str(problem):
            return None
        raise
    return json.loads(file.read_text())["pictures"][0]


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    sizes, picture, repeats = ((24,), "64x36", 1) if setting.quick else ((128, 256, 512), "1920x1080", 3)
    transfer = setting.folder / "ball.tf"
    transfer.write_text(TRANSFER)
    rows, commands = [], []
    for size in sizes:
        for backend in BACKENDS:
            for name, options in SHORTCUTS.items():
                arguments = [f"demo:sphere?size={size}", "--tf", transfer, "--size", picture, "--backend", backend, *options]
                drawn = [draw(setting, arguments) for _ in range(1 + repeats)]
                row = {"size": size, "backend": backend, "shortcuts": name}
                rows.append(row)
                if drawn[0] is None:
                    continue
                row["cold_s"] = drawn[0]["seconds"]["draw"]
                row["warm_s"] = [one["seconds"]["draw"] for one in drawn[1:]]
                row |= {key: drawn[0][key] for key in ("rays", "samples", "samples_skipped", "samples_terminated")}
    commands.append(programs.shown(["isoextract", "render", "demo:sphere?size=N", "--tf", "ball.tf", "--size", picture,
                                    "--backend", "B", "-o", "render.png", "--json", "render.json"]))
    return measured.finish([record.cores()], {}, commands, {"picture": picture, "repeats": repeats, "rows": rows})


def page(measured):
    figures = measured["figures"]
    rows = figures["rows"]
    warm = {(row["size"], row["backend"], row["shortcuts"]): median(row["warm_s"]) for row in rows if "warm_s" in row}
    lines = []
    for row in rows:
        key = row["size"], row["backend"], row["shortcuts"]
        cells = [f"{row['size']}³", row["backend"], row["shortcuts"]]
        if key not in warm:
            lines.append([*cells, "not there", "", "", "", "", ""])
            continue
        cpu = warm.get((row["size"], "cpu", row["shortcuts"]))
        lines.append([*cells, number(row["cold_s"]), number(warm[key]), ratio(cpu / warm[key]) if cpu else "",
                      number(row["samples"]), number(row["samples_skipped"]), number(row["samples_terminated"])])
    columns = ["samples", "backend", "shortcuts", "cold, s:", "warm, s:", "cpu / this row:", "samples taken:",
               "skipped in empty bricks:", "skipped by termination:"]
    return f"""`isoextract render` draws a ball by ray casting, {figures['picture']} pixels ([render](../render.md)). Times cover the search for empty
bricks, the upload to the GPU and the drawing, but neither reading nor writing of files.

- **Cold** is the first process. On a GPU, the driver compiles the shaders in it.
- **Warm** is the median of {figures['repeats']} more processes, each of which opens the device again.
- **Shortcuts**: rays skip empty bricks (*empty-space skipping*) and end where opaque samples hide the rest (*early termination*).
  The last three columns count samples along all rays: those taken, and those that each shortcut skipped.
- Rows other than "all" have `--termination 0`, `--no-skipping` or both. The script writes `ball.tf`, the transfer function.
- **cpu / this row** is the warm time of the CPU with the same samples and shortcuts, divided by the warm time of this row. The paper on hybrid ray casting ([papers](../papers.md))
  reports more than 10 for a GTX 780 and a Core i7-4790K, and higher values for larger volumes. If a processor emulates the GPU
  (llvmpipe), the rows of the GPU show the speed of the shaders on that processor.

{table(columns, lines)}
"""
