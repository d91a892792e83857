"""The header of every measurement: the commit, the day, the machine, the programs, the commands.

A record is one JSON file of docs/measurements: this header, and under "figures" what was measured.
"""

import datetime
import json
import os
import pathlib
import platform
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDER = ROOT / "docs" / "measurements"

# The keys of a record and what they hold; "figures" is each measurement's own.
FIELDS = {
    "measurement": str,
    "quick": bool,  # small sizes and few runs, which show that the script works and nothing else
    "commit": str,
    "dirty": bool,  # the checkout had changes that are in no commit
    "program": str,  # where the measured program comes from
    "date": str,
    "seconds": (int, float),
    "machine": dict,
    "load": (int, float),  # the system's, over the minute before
    "threads": list,
    "versions": dict,
    "commands": list,
    "figures": dict,
}


def text_of(command):
    """The standard output of a command, or nothing where there is no such program or it fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout


def first_line(command):
    """The first line that a program tells of itself, on either stream."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return "unknown"
    lines = (done.stdout + done.stderr).strip().splitlines()
    return lines[0] if lines else "unknown"


def commit():
    """The hash of the checkout's commit, and whether anything but measurements differs from it."""
    changes = ["git", "status", "--porcelain", "--", ".", ":(exclude)docs/measurements"]
    return text_of(["git", "rev-parse", "HEAD"]).strip() or "unknown", bool(text_of(changes).strip())


def processor():
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def cores():
    return len(os.sched_getaffinity(0))


def system():
    try:
        name = platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        name = platform.system()
    return f"{name}, Linux {re.match(r'[0-9.]*[0-9]', platform.release())[0]}"


def gpu(isoextract):
    """The device that draws: the first usable one, hardware before software."""
    try:
        devices = json.loads(text_of([isoextract, "devices", "--json"]))
    except ValueError:
        devices = []
    usable = [device for device in devices if device["usable"]]
    usable.sort(key=lambda device: device["software"])
    return f"{usable[0]['renderer']}, OpenGL {usable[0]['version']}" if usable else "none"


def machine(isoextract):
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {
        "cpu": processor(),
        "cores": cores(),
        "memory_gib": round(memory / 2**30, 1),
        "os": system(),
        "gpu": gpu(isoextract),
    }


def isoextract_version(isoextract):
    return first_line([isoextract, "--version"]).removeprefix("isoextract ")


def origin(isoextract):
    """Where a program was built: in this checkout, whose commit it then is, or elsewhere."""
    path = pathlib.Path(isoextract).resolve()
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else "built elsewhere"


class Record:
    """Starts the clock; finish() makes the record."""

    def __init__(self, name, isoextract, quick):
        self.started = datetime.datetime.now(datetime.timezone.utc).replace(microsecond=0)
        hash_of, dirty = commit()
        self.header = {
            "measurement": name,
            "quick": quick,
            "commit": hash_of,
            "dirty": dirty,
            "program": origin(isoextract),
            "date": self.started.isoformat().replace("+00:00", "Z"),
            "machine": machine(isoextract),
            "load": round(os.getloadavg()[0], 2),
            "versions": {"isoextract": isoextract_version(isoextract)},
        }

    def finish(self, threads, versions, commands, figures):
        header = dict(self.header)
        header["seconds"] = round((datetime.datetime.now(datetime.timezone.utc) - self.started).total_seconds())
        header["versions"] |= versions
        header |= {"threads": threads, "commands": commands, "figures": figures}
        return {field: header[field] for field in FIELDS}


def write(record, path):
    pathlib.Path(path).write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n")


def read(path):
    """The record in a file. ValueError where a field is missing, unknown or of another type."""
    record = json.loads(pathlib.Path(path).read_text())
    if set(record) != set(FIELDS):
        raise ValueError(f"{path}: the fields {sorted(set(record) ^ set(FIELDS))} are missing or too many")
    for field, kind in FIELDS.items():
        if not isinstance(record[field], kind):
            raise ValueError(f"{path}: '{field}' is {record[field]!r}")
    return record
