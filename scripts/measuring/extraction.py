"""build/bench/extraction_benchmark: contestants in turn, in processes of which each begins cold."""

import json

from measuring import programs
from measuring.tables import median

# A contestant's row is the same in every process but for its times.
SAME = ("input", "dims", "type", "normals", "name", "program", "threads", "triangles", "vertices", "samples",
        "bytes_read", "bytes_written")


def measure(setting, arguments, processes, runs):
    """Rows of all contestants: the first times of each process, and of all processes the rounds after it."""
    rows = []
    for _ in range(processes):
        file = setting.folder / "rows.json"
        command = [setting.bench / "extraction_benchmark", *arguments, "--runs", runs, "--json", file]
        programs.run(command, env={"ISOEXTRACT_DATA": str(setting.data)})
        found = json.loads(file.read_text())["rows"]
        if not rows:
            rows = [{key: row[key] for key in SAME if key in row} | {"cold_ms": [], "warm_ms": []} for row in found]
        for row, other in zip(rows, found):
            row["cold_ms"].append(other["first_ms"])
            row["warm_ms"] += other["rounds_ms"]
    return rows


def shown(arguments):
    return programs.shown(["extraction_benchmark", *arguments])


def versions(rows):
    """Versions of the peers among rows: {"VTK": "9.1.0"}."""
    words = [row["program"].rpartition(" ") for row in rows if not ours(row) and row["program"] != "memory"]
    return {name: version for name, _, version in words}


def ours(row):
    return row["program"].startswith("isoextract")


def ratio(row, other, key):
    """The median, over the rounds, of one row's time divided by the other's."""
    return median([a / b for a, b in zip(row[key], other[key])])
