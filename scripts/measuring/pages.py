"""The pages of docs/measurements, each from one record and nothing else; and checks of them."""

import hashlib

from measuring import (commands, compression, error, gpu, labels, masks, particle_methods, particles, record, render, sequences,
                       simplify, speed, stability, threads, topology, verdicts, voxels)
from measuring.tables import table

MEASUREMENTS = {module.NAME: module for module in (speed, commands, threads, gpu, error, topology, stability, simplify,
                                                   sequences, compression, particles, particle_methods, render, voxels,
                                                   labels, masks, verdicts)}

QUICK = """
> These figures are of a trial run with small inputs. They show that the script works, and nothing else.
"""


def machine_text(machine):
    return (f"{machine['cpu']}, {machine['cores']} {'core' if machine['cores'] == 1 else 'cores'}, "
            f"{machine['memory_gib']} GiB, {machine['os']}; device: {machine['gpu']}")


def commit_text(measured):
    text = f"`{measured['commit'][:12]}`"
    if measured["dirty"]:
        text += " with changes that are in no commit"
    return text


def header(measured):
    versions = ", ".join(f"{name} {version}" for name, version in measured["versions"].items())
    counts = " and ".join(map(str, measured["threads"]))
    rows = [
        ["commit", commit_text(measured)],
        ["program", f"`{measured['program']}`" if "/" in measured["program"] else measured["program"]],
        ["date", measured["date"].replace("T", " ").replace("Z", " UTC")],
        ["machine", machine_text(measured["machine"])],
        ["system load before", f"{measured['load']:.2f}"],
        ["threads", counts],
        ["versions", versions],
        ["run time", f"{measured['seconds']} s"],
    ]
    commands_text = "\n".join(measured["commands"])
    return f"""{table(["condition", "value"], rows)}

To repeat it: `scripts/measure run {measured['measurement']}`, which runs commands such as

```sh
{commands_text}
```
"""


def page(measured):
    name = measured["measurement"]
    module = MEASUREMENTS[name]
    return f"""# {module.TITLE}

<!-- Made by `scripts/measure pages` from {name}.json. -->
{QUICK if measured['quick'] else ''}
{module.page(measured)}
## When and where it was measured

{header(measured)}"""


def index(records):
    rows = [[f"[{MEASUREMENTS[name].TITLE}]({name}.md)", commit_text(measured), measured["date"][:10],
             measured["machine"]["cpu"], measured["machine"]["cores"], f"{measured['seconds']} s",
             "trial run" if measured["quick"] else ""] for name, measured in records.items()]
    places = {(measured["commit"], measured["dirty"], str(measured["machine"])) for measured in records.values()}
    mixed = "" if len(places) < 2 else """
These pages are not all of one commit and one machine: compare figures within a page only.
"""
    return f"""# Measurements

<!-- Made by `scripts/measure pages` from the JSON files beside it. -->

`scripts/measure run NAME` measures and writes `NAME.json` with the results, the commit, the date, the machine and the
commands. `scripts/measure pages` makes these pages from those files, and a test checks that pages and files agree.
`scripts/measure run all` repeats everything; [CONTRIBUTING.md](../../CONTRIBUTING.md#measurements) says what it needs.

Each page with times says whether a time is of a first run (*cold*) or of later runs (*warm*). A page with both has separate columns.
{mixed}
{table(["page", "commit", "date", "processor", "cores:", "run time:", ""], rows)}
"""


def wanted(folder):
    """{file name: text} of all pages that a folder's records give, and the records. ValueError for a bad record."""
    records = {}
    for name in MEASUREMENTS:
        path = folder / f"{name}.json"
        if path.exists():
            records[name] = record.read(path)
            if records[name]["measurement"] != name:
                raise ValueError(f"{path}: holds the measurement '{records[name]['measurement']}'")
    pages = {f"{name}.md": page(measured) for name, measured in records.items()}
    pages["README.md"] = index(records)
    return pages, records


def write(folder):
    for name, text in wanted(folder)[0].items():
        (folder / name).write_text(text)


def problems(folder):
    """Lines about pages and files that differ from the records."""
    try:
        pages, records = wanted(folder)
    except (ValueError, KeyError) as error:
        return [f"{error}"]
    found = []
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text() != text:
            found.append(f"{path}: not what its JSON gives; `scripts/measure pages` makes it anew")
    files = {file["file"]: file["sha256"] for name, measured in records.items()
             for file in getattr(MEASUREMENTS[name], "files", lambda _: [])(measured)}
    for name, digest in files.items():
        path = folder / name
        if not path.exists() or hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            found.append(f"{path}: not the file that was measured")
    known = {*pages, *files, *(f"{name}.json" for name in MEASUREMENTS)}
    for path in sorted(folder.iterdir()):
        if path.name not in known:
            found.append(f"{path}: belongs to no measurement")
    for name in MEASUREMENTS:
        if name not in records:
            found.append(f"{folder / name}.json: not there; `scripts/measure run {name}` makes it")
    return found
