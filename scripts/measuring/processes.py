"""Whole processes: their time and memory, and what they wrote."""

import os
import pathlib
import statistics
import subprocess
import sys
import threading
import time

from measuring import record
from measuring.programs import Failed

sys.path.insert(0, str(record.ROOT / "tests" / "support"))

import mesh_readers  # noqa: E402


def run_once(command, cwd=None, watch=None):
    """Returns wall seconds, processor seconds, and the peak of memory in MiB; of the children that a shell waits
    for as well. `watch` is called with the process when it has begun."""
    start = time.perf_counter()
    process = subprocess.Popen([str(word) for word in command], cwd=cwd, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    if watch:
        watch(process)
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.stderr.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise Failed(f"{' '.join(map(str, command))}\n{errors.decode(errors='replace')}ended with {process.returncode}")
    return {"wall": wall, "cpu": usage.ru_utime + usage.ru_stime, "peak": usage.ru_maxrss / 1024}


class Watcher:
    """Resident memory and open files of a process, read from /proc every `seconds`. Begins when `begun()` is true: a
    process that still loads its libraries does not work yet."""

    def __init__(self, seconds, begun):
        self.seconds = seconds
        self.begun = begun
        self.samples = []  # [seconds since the start, resident MiB, open files]

    def __call__(self, process):
        threading.Thread(target=self.look, args=(pathlib.Path("/proc") / str(process.pid),), daemon=True).start()

    def look(self, folder):
        start = time.perf_counter()
        page = os.sysconf("SC_PAGE_SIZE") / 2**20
        while True:
            try:
                resident = int((folder / "statm").read_text().split()[1]) * page
                files = len(os.listdir(folder / "fd"))
            except (OSError, IndexError):
                return  # over
            if resident > 0 and (self.samples or self.begun()):
                self.samples.append([round(time.perf_counter() - start, 3), round(resident, 2), files])
            time.sleep(self.seconds)


def summary(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values), "rounds": values}


def ply_triangles(path):
    """Triangles of a binary PLY file of triangles and quads, a quad as two: by its header and its size."""
    with open(path, "rb") as file:
        header = mesh_readers.PlyHeader(file)
        left = os.path.getsize(path) - file.tell()
    left -= sum(count * header.fixed_size(element) for element, count in header.counts.items())
    corners = left // header.index_size()
    quads = corners - 3 * header.counts["face"]
    return header.counts["face"] + quads
