"""Running what measures, and what it needs to know."""

import dataclasses
import json
import os
import pathlib
import subprocess

from measuring import record

# Drivers keep compiled shaders on disk; a cold run may not find them there.
NO_SHADER_CACHE = {"MESA_SHADER_CACHE_DISABLE": "true", "__GL_SHADER_DISK_CACHE": "0"}

# Stages of a conversion's report that are extraction, as `isoextract bench` times it.
EXTRACTION = ("classify", "compile", "upload", "count", "emit")


class Failed(Exception):
    """A program that a measurement runs did not end well, or is not there."""


@dataclasses.dataclass
class Setting:
    """Programs, folders and options of a measurement."""

    isoextract: pathlib.Path
    bench: pathlib.Path  # the build folder of preset bench
    data: pathlib.Path  # of real volumes
    out: pathlib.Path  # where records go
    folder: pathlib.Path  # for what is written and thrown away
    quick: bool


def run(command, cwd=None, env=None):
    """Standard output of a command that must succeed."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, cwd=cwd, env={**os.environ, **(env or {})}, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False)
    except OSError as error:
        raise Failed(f"{words[0]}: {error.strerror}") from error
    if done.returncode != 0:
        raise Failed(f"{shown(words)}\n{done.stderr}ended with {done.returncode}")
    return done.stdout


def shown(command):
    """A command as a reader would give it: programs and files by their names."""
    def name(word):
        path = pathlib.Path(word)
        if not path.is_absolute():
            return word
        return path.relative_to(record.ROOT).as_posix() if path.is_relative_to(record.ROOT) else path.name

    program, *words = map(str, command)
    words = [f"'{word}'" if "?" in word else name(word) for word in words]
    return " ".join([pathlib.Path(program).name, *words])


def bench(setting, *arguments, plot=None):
    """`isoextract bench`: its JSON, and the command for readers."""
    command = ["bench", *arguments]
    if plot:
        command += ["--plot", plot]
    file = setting.folder / "bench.json"
    run([setting.isoextract, *command, "--json", file, "-q"])
    return json.loads(file.read_text()), shown(["isoextract", *command])


def convert(setting, *arguments, env=None):
    """One conversion to PLY in a process of its own: its report."""
    mesh, report = setting.folder / "mesh.ply", setting.folder / "report.json"
    run([setting.isoextract, *arguments, "-o", mesh, "--report", report, "-q"], env=env)
    mesh.unlink()
    return json.loads(report.read_text())


def extraction_ms(report):
    """Milliseconds that a conversion took to extract its surface."""
    seconds = {stage["stage"]: stage["wall_seconds"] for stage in report["stages"] if stage["stage"] in EXTRACTION}
    if "emit" not in seconds:
        raise Failed(f"a report without the stage 'emit', of {[stage['stage'] for stage in report['stages']]}")
    return 1000 * sum(seconds.values())


def cold_extraction_ms(setting, field, size, method, iso, backend="cpu", processes=3):
    """Extractions of a demo field, each the first of its process, with no shaders from earlier ones."""
    arguments = [f"demo:{field}?size={size}", "--iso", iso, "--method", method, "--backend", backend]
    return [extraction_ms(convert(setting, *arguments, env=NO_SHADER_CACHE)) for _ in range(processes)]
