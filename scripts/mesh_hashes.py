#!/usr/bin/env python3
"""The hashes of the meshes that isoextract makes of real volumes, to see that a change leaves every byte as it was.

  scripts/mesh_hashes.py PROGRAM > before.txt              hash every volume x method x backend x format
  scripts/mesh_hashes.py PROGRAM --against before.txt      the same, and say what differs; exit code 1 if anything does
  scripts/mesh_hashes.py PROGRAM --only ch2 --backends cpu --formats ply

The volumes are those of ISOEXTRACT_DATA, or of shared/data beside the checkout. Each line is a hash and what was run.
The version that files name as their generator is left out of the comparison by hashing with it blanked.
"""

import argparse
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

VOLUMES = {
    "vdb/smoke.vdb": ["--iso", "0.5"],
    "vdb/sphere.vdb": ["--iso", "0"],
    **{f"vdb/c42_gas_seq/fluid_data_{n:04}.vdb": ["--iso", "0.5", "--grid", "density"] for n in range(2, 11, 2)},
    "med/FLAIR.nrrd": ["--iso", "60"],
    "med/tooth.nhdr": ["--iso", "500"],
    "med/HeadMRVolume.raw": ["--iso", "60", "--dims", "48,62,42", "--dtype", "u8", "--spacing", "4"],
    "mol/betaGal.npy": ["--iso", "0.05"],
    "mol/m4_TotalDensity.nrrd": ["--iso", "0.05"],
    "med/ch2.nii.gz": ["--iso", "60"],
    "med/MR.nii.gz": ["--iso", "120"],
}
METHODS = ["mc", "mt"]
BACKENDS = ["cpu", "gpu"]
FORMATS = ["glb", "ply", "obj", "stl"]


def data_folder():
    beside = pathlib.Path(__file__).resolve().parents[2] / "shared" / "data"
    return pathlib.Path(os.environ.get("ISOEXTRACT_DATA", beside))


def hash_of(path, generator):
    return hashlib.sha256(path.read_bytes().replace(generator, b"-")).hexdigest()


def rows(arguments):
    """(what was run, the hash of what it wrote) of every combination."""
    generator = subprocess.run([arguments.program, "--version"], capture_output=True, check=True).stdout.strip()
    folder = data_folder()
    with tempfile.TemporaryDirectory(prefix="isoextract-hashes-") as made:
        for volume, options in VOLUMES.items():
            if arguments.only and arguments.only not in volume:
                continue
            if not (folder / volume).exists():
                print(f"{folder / volume} is not there: skipped", file=sys.stderr)
                continue
            for backend in arguments.backends.split(","):
                for method in arguments.methods.split(","):
                    for kind in arguments.formats.split(","):
                        output = pathlib.Path(made) / f"mesh.{kind}"
                        command = [arguments.program, folder / volume, *options, "-q"]
                        command += ["--method", method, "--backend", backend, "-o", output]
                        done = subprocess.run(command, capture_output=True, text=True)
                        found = hash_of(output, generator) if done.returncode == 0 else f"failed-{done.returncode}"
                        yield f"{volume} {method} {backend} {kind}", found
                        output.unlink(missing_ok=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--against", type=pathlib.Path, metavar="FILE", help="hashes to compare with")
    parser.add_argument("--only", metavar="TEXT", help="volumes whose path holds TEXT")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--backends", default=",".join(BACKENDS))
    parser.add_argument("--formats", default=",".join(FORMATS))
    arguments = parser.parse_args()
    before = {}
    if arguments.against:
        before = dict(reversed(line.split(" ", 1)) for line in arguments.against.read_text().splitlines())
    compared = differing = 0
    for what, found in rows(arguments):
        if not arguments.against:
            print(found, what, flush=True)
            continue
        if what not in before:
            print(f"new: {what}")
            continue
        compared += 1
        if before[what] != found:
            differing += 1
            print(f"differs: {what}: {before[what]} before, {found} now", flush=True)
    if arguments.against:
        print(f"{compared} meshes compared, {differing} differ")
        sys.exit(1 if differing or not compared else 0)


if __name__ == "__main__":
    main()
