#!/usr/bin/python3
"""Topology of random trilinear fields: isoextract and other programs against an oracle that counts voxels.

    scripts/compare_topology.py [--fields N] [--json FILE]

Builds the program that writes the fields (tests/topology, in build/topology) and runs the installed peers (Debian
packages python3-vtk9 and python3-skimage) on the same samples. Prints how many surfaces have the right components with
the right Euler numbers. Peers are right with either topology where samples or saddles have exactly the iso value.
scripts/measure makes a page of the file that --json writes.
"""

import argparse
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy
from measuring import record

ROOT = record.ROOT
BUILD = ROOT / "build" / "topology"
KINDS = ("uniform", "near_saddle", "small_integers")
SIZE = 5


def euler_numbers(points, triangles):
    """Sorted Euler numbers of a mesh's components. Merges equal positions, and drops triangles without area."""
    _, names = numpy.unique(points, axis=0, return_inverse=True)
    names = numpy.ravel(names)
    triangles = names[triangles]
    parents = list(range(int(names.max()) + 1 if len(names) else 0))

    def find(a):
        while parents[a] != a:
            parents[a] = parents[parents[a]]
            a = parents[a]
        return a

    corners, edges, faces = set(), set(), []
    for a, b, c in triangles.tolist():
        if a == b or b == c or c == a:
            continue
        parents[find(a)] = find(b)
        parents[find(b)] = find(c)
        corners.update((a, b, c))
        edges.update(tuple(sorted(edge)) for edge in ((a, b), (b, c), (c, a)))
        faces.append(a)
    numbers = collections.Counter()
    for corner in corners:
        numbers[find(corner)] += 1
    for a, _ in edges:
        numbers[find(a)] -= 1
    for a in faces:
        numbers[find(a)] += 1
    return sorted(numbers.values())


def vtk_peers():
    try:
        import vtkmodules.vtkCommonCore as core
        import vtkmodules.vtkCommonDataModel as model
        import vtkmodules.vtkFiltersCore as filters
        from vtkmodules.util import numpy_support
    except ImportError:
        print("VTK is not installed (Debian: python3-vtk9): left out", file=sys.stderr)
        return {}

    def run(make):
        def extract(samples):
            image = model.vtkImageData()
            image.SetDimensions(SIZE, SIZE, SIZE)
            image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(samples.ravel(), deep=True))
            contour = make()
            contour.SetInputData(image)
            contour.SetValue(0, 0.0)
            contour.ComputeNormalsOff()
            contour.Update()
            mesh = contour.GetOutput()
            if mesh.GetNumberOfPolys() == 0:
                return numpy.zeros((0, 3)), numpy.zeros((0, 3), int)
            cells = numpy_support.vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            return numpy_support.vtk_to_numpy(mesh.GetPoints().GetData()), cells

        return extract

    version = core.vtkVersion.GetVTKVersion()
    return {
        ("VTK", version, "MarchingCubes"): run(filters.vtkMarchingCubes),
        ("VTK", version, "FlyingEdges3D"): run(filters.vtkFlyingEdges3D),
    }


def skimage_peers():
    try:
        import skimage
        from skimage.measure import marching_cubes
    except ImportError:
        print("scikit-image is not installed (Debian: python3-skimage): left out", file=sys.stderr)
        return {}

    def extract(samples):
        if not (samples > 0).any():
            return numpy.zeros((0, 3)), numpy.zeros((0, 3), int)
        points, triangles, _, _ = marching_cubes(samples, 0.0, method="lewiner", allow_degenerate=False)
        return points, triangles

    return {("scikit-image", skimage.__version__, "Lewiner"): extract}


def build_writer():
    quiet = {"stdout": subprocess.DEVNULL, "check": True}
    subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", "-DISOEXTRACT_TESTS=ON"], **quiet)
    subprocess.run(["cmake", "--build", BUILD, "--target", "write_random_fields"], **quiet)


def count_right(count, peers):
    """For each program (name, version, method), how many surfaces of each kind of field are right; for how many fields
    the oracle does not know the topology."""
    ours = ("isoextract", "", "mc")
    table = {name: [] for name in (ours, *peers)}
    undecided = 0
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([BUILD / "tests" / "write_random_fields", str(count), folder], check=True)
        for kind in KINDS:
            facts = json.loads(pathlib.Path(folder, f"{kind}.json").read_text())
            fields = numpy.fromfile(pathlib.Path(folder, f"{kind}.f32"), numpy.float32).reshape(-1, SIZE, SIZE, SIZE)
            undecided += sum(fact["above"] is None or fact["below"] is None for fact in facts)
            table[ours].append(sum(fact["isoextract"] == fact["above"] for fact in facts))
            for name, extract in peers.items():
                right = 0
                for fact, samples in zip(facts, fields):
                    right += euler_numbers(*extract(samples)) in (fact["above"], fact["below"])
                table[name].append(right)
    return table, undecided


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fields", type=int, default=10000, help="fields of each kind (default: 10000)")
    parser.add_argument("--json", type=pathlib.Path, help="write all figures to this file")
    parser.add_argument("--quick", action="store_true", help="mark the figures as those of a trial run")
    parser.add_argument("--isoextract", type=pathlib.Path, default=ROOT / "build" / "release" / "isoextract",
                        help="asked for its version, with --json (default: build/release/isoextract)")
    options = parser.parse_args()
    count = options.fields
    build_writer()
    measured = record.Record("topology", options.isoextract, options.quick) if options.json else None
    peers = vtk_peers() | skimage_peers()
    table, undecided = count_right(count, peers)
    print(f"Right topology, of {count} random fields of {SIZE}^3 samples each ({undecided} undecided by the oracle)\n")
    print(f"| program | {' | '.join(kind.replace('_', ' ') for kind in KINDS)} |")
    print("|---|" + "---:|" * len(KINDS))
    for name, row in table.items():
        print(f"| {' '.join(filter(None, name))} | {' | '.join(f'{100 * right / count:.2f} %' for right in row)} |")
    if options.json:
        figures = {
            "fields": count,
            "samples": SIZE,
            "undecided": undecided,
            "rows": [
                {"program": program, "method": method, "right": dict(zip(KINDS, row))}
                for (program, _, method), row in table.items()
            ],
        }
        versions = {program: version for program, version, _ in peers}
        command = f"scripts/compare_topology.py --fields {count}"
        record.write(measured.finish([record.cores()], versions, [command], figures), options.json)
    return 0 if all(row == [count] * len(KINDS) for name, row in table.items() if name[0] == "isoextract") else 1


if __name__ == "__main__":
    sys.exit(main())
