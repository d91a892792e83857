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
    caveat = "" if left < 0.01 else f"\n**Up to {left:.0%} of an input stayed in the page cache: cold is not cold here.**\n"
    tables = "\n".join(map(comparison, comparisons))
    return f"""Wall time, processor time and the peak of memory of processes, by `scripts/compare_speed.py`.

- **Cold** is the first run of a command, before which the input's pages were dropped from the system's page cache, so
  that it comes from the disk. The programs and their libraries were not dropped; below a virtual machine, its host may
  still have held the pages.
- **Warm** is the median of {figures['runs']} rounds after it, in which the commands ran in turn; so are processor time and peak.
- The last columns are the first row's figures over this row's, below 1 where the first row's were less: of one run cold,
  the median of the rounds' ratios warm.
{caveat}
{tables}
## Start

`isoextract --version`: {number(1000 * start['cold'])} ms with the program's own file dropped from the page cache (its libraries were not),
{number(1000 * start['median'])} ms after that (median of {len(start['rounds'])}).
"""
