"""Whole commands, from file to file."""

import sys

from measuring import programs, record
from measuring.tables import number, ratio, table

NAME = "commands"
TITLE = "How fast whole commands are, from file to file"


def measure(setting):
    file = setting.folder / "commands.json"
    options = ["--runs", 2, "--size", 64] if setting.quick else ["--runs", 5]
    programs.run([sys.executable, record.ROOT / "scripts" / "compare_speed.py", "--isoextract", setting.isoextract,
                  "--build", setting.bench, *options, *(["--quick"] if setting.quick else []), "--json", file])
    return record.read(file)


def comparison(figures):
    title, rows = figures["title"], figures["rows"]
    first = rows[0]
    lines = []
    for row in rows:
        others = [ratio(first["cold"]["wall"] / row["cold"]["wall"]), *(
            ratio(row[f"{key}_isoextract_to_this"]) for key in ("wall", "cpu", "peak"))]
        lines.append([f"`{row['command']}`", number(row["output"].get("triangles")), number(row["cold"]["wall"]),
                      number(row["wall"]["median"]), number(row["cpu"]["median"]), number(round(row["peak"]["median"])),
                      *(["", "", "", ""] if row is first else others)])
    columns = ["command", "triangles:", "cold, s:", "warm, s:", "processor time, s:", "peak, MiB:",
               "first row / this row, cold:", "warm:", "processor:", "peak:"]
    return f"## {title}\n\n{table(columns, lines)}\n"


def page(measured):
    figures = measured["figures"]
    comparisons = figures["comparisons"]
    left = max(row["cold"]["input_in_page_cache"] for one in comparisons for row in one["rows"])
    start = figures["start_up_seconds"]
    caveat = "" if left < 0.01 else f"\n**Up to {left:.0%} of an input stayed in the page cache: the cold times are too short.**\n"
    tables = "\n".join(map(comparison, comparisons))
    return f"""Wall time, processor time and peak memory of whole processes, measured by `scripts/compare_speed.py`.

- **Cold** is the first run of a command. Before it, the script drops the input from the system's page cache, so the program reads
  the input from the disk. The programs and their libraries stay in the cache. On a virtual machine, the host may still cache the input.
- **Warm** is the median of {figures['runs']} later rounds; each round runs every command once. Processor time and peak are medians of the
  same rounds.
- **First row / this row** compares each command with that of the first row; below 1, the first row is faster or needs less memory.
  The cold ratio is of one run each, the others are the median of the rounds' ratios.
{caveat}
{tables}
## Start

`isoextract --version` takes {number(1000 * start['cold'])} ms if the program's file, but not its libraries, was dropped from the page cache, and
{number(1000 * start['median'])} ms after that (median of {len(start['rounds'])} runs).
"""
