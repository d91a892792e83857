#!/usr/bin/python3
"""Topology of random trilinear fields: isoextract and other programs against an oracle that counts voxels.

    scripts/compare_topology.py [--fields N]

Builds what writes the fields (tests/topology, in build/topology), runs the peers that are installed (Debian packages
python3-vtk9 and python3-skimage) on the same samples, and prints how many surfaces have the right components with the
right Euler numbers. Peers are right with either topology where samples or saddles have the very value iso.
"""

import argparse
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
KINDS = ("uniform", "near_saddle", "small_integers")
SIZE = 5


def euler_numbers(points, triangles):
    """Of the components of a mesh, sorted. Equal positions are one point; triangles without area are left out."""
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
        f"VTK {version} MarchingCubes": run(filters.vtkMarchingCubes),
        f"VTK {version} FlyingEdges3D": run(filters.vtkFlyingEdges3D),
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

    return {f"scikit-image {skimage.__version__} Lewiner": extract}


def write_fields(count, folder):
    build = ROOT / "build" / "topology"
    quiet = {"stdout": subprocess.DEVNULL, "check": True}
    subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DISOEXTRACT_TESTS=ON"], **quiet)
    subprocess.run(["cmake", "--build", build, "--target", "write_random_fields"], **quiet)
    subprocess.run([build / "tests" / "write_random_fields", str(count), folder], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fields", type=int, default=10000, help="fields of each kind (default: 10000)")
    count = parser.parse_args().fields
    peers = vtk_peers() | skimage_peers()
    table = {name: [] for name in ("isoextract mc", *peers)}
    undecided = 0
    with tempfile.TemporaryDirectory() as folder:
        write_fields(count, folder)
        for kind in KINDS:
            facts = json.loads(pathlib.Path(folder, f"{kind}.json").read_text())
            fields = numpy.fromfile(pathlib.Path(folder, f"{kind}.f32"), numpy.float32).reshape(-1, SIZE, SIZE, SIZE)
            undecided += sum(fact["above"] is None or fact["below"] is None for fact in facts)
            table["isoextract mc"].append(sum(fact["isoextract"] == fact["above"] for fact in facts))
            for name, extract in peers.items():
                right = 0
                for fact, samples in zip(facts, fields):
                    right += euler_numbers(*extract(samples)) in (fact["above"], fact["below"])
                table[name].append(right)
    print(f"Right topology, of {count} random fields of {SIZE}^3 samples each ({undecided} undecided by the oracle)\n")
    print(f"| program | {' | '.join(kind.replace('_', ' ') for kind in KINDS)} |")
    print("|---|" + "---:|" * len(KINDS))
    for name, row in table.items():
        print(f"| {name} | {' | '.join(f'{100 * right / count:.2f} %' for right in row)} |")
    return 0 if table["isoextract mc"] == [count] * len(KINDS) else 1


if __name__ == "__main__":
    sys.exit(main())
