"""Inputs for the measurement of label maps, its peers, and whether meshes meet. Run by Python with NumPy, and VTK:

    label_maps.py head CH2.nii.gz FILE.npy   five labels by the values of a head
    label_maps.py ball RADIUS FILE.npy       a ball as label 1
    label_maps.py cells SIDE N TYPE FILE.npy the cells of N random points in a cube, as labels of a type
    label_maps.py vtk FILE.npy FILTER RUNS   its surfaces by a filter of VTK; times, triangles and area as JSON
    label_maps.py skimage FILE.npy           its surfaces by scikit-image, each label in its bounding box
    label_maps.py meet FILE.npy PATTERN      of PLY files by label: the triangles that two of them have in common
"""

import json
import struct
import sys
import time

import numpy as np

LABELS = (1, 2, 3, 4, 5)
LIMITS = (20, 60, 90, 110, 140)
OFF_CENTER = 0.137  # of a ball, along each axis, so that it is not symmetrical


def head(path):
    import gzip  # here, because that of Python 3.14 would find compression.py of this folder

    data = gzip.open(path).read()
    dims = struct.unpack_from("<3h", data, 42)
    start = int(struct.unpack_from("<f", data, 108)[0])
    samples = np.frombuffer(data[start:start + dims[0] * dims[1] * dims[2]], np.uint8).reshape(dims[::-1])
    return np.digitize(samples, LIMITS).astype(np.uint8)


def ball(radius):
    side = 2 * radius + 8
    z, y, x = np.mgrid[:side, :side, :side] - (side - 1) / 2 + OFF_CENTER
    return (x * x + y * y + z * z < radius * radius).astype(np.uint8)


def cells(side, count, kind):
    from scipy.spatial import cKDTree

    tree = cKDTree(np.random.default_rng(1).random((count, 3)) * side)
    ids = np.arange(1, count + 1).astype(kind)
    if np.dtype(kind).itemsize == 8:
        ids = np.random.default_rng(5).integers(10 ** 17, 9 * 10 ** 18, count).astype(kind)
    y, x = (axis.ravel() for axis in np.mgrid[:side, :side])
    slices = (tree.query(np.stack([np.full(x.size, z), y, x], 1))[1] for z in range(side))
    return np.stack([ids[nearest].reshape(side, side) for nearest in slices])


def area_of(points, triangles):
    a, b, c = (points[triangles[:, corner]].astype(float) for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def by_vtk(labels, name, runs):
    import vtk
    from vtk.util import numpy_support

    image = vtk.vtkImageData()
    image.SetDimensions(*labels.shape[::-1])
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(labels.ravel()))
    figures = {"ms": [], "vtk": vtk.vtkVersion().GetVTKVersion()}
    for _ in range(runs):
        begin = time.perf_counter()
        surfaces = {"cubes": vtk.vtkDiscreteMarchingCubes, "edges": vtk.vtkDiscreteFlyingEdges3D}[name.split("+")[0]]()
        surfaces.SetInputData(image)
        surfaces.GenerateValues(len(LABELS), LABELS[0], LABELS[-1])
        surfaces.Update()
        made = surfaces.GetOutput()
        if name.endswith("+sinc"):
            smooth = vtk.vtkWindowedSincPolyDataFilter()
            smooth.SetInputData(made)
            smooth.SetNumberOfIterations(20)
            smooth.SetPassBand(0.1)
            smooth.NormalizeCoordinatesOn()
            smooth.BoundarySmoothingOff()
            smooth.NonManifoldSmoothingOn()
            smooth.Update()
            made = smooth.GetOutput()
        figures["ms"].append(1000 * (time.perf_counter() - begin))
    triangles = numpy_support.vtk_to_numpy(made.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    points = numpy_support.vtk_to_numpy(made.GetPoints().GetData())
    return figures | {"triangles": len(triangles), "area": area_of(points, triangles)}


def by_skimage(labels):
    from scipy.ndimage import find_objects
    from skimage.measure import marching_cubes

    labels = np.pad(labels, 1)
    for label, box in enumerate(find_objects(labels.astype(np.int32)), 1):
        if box is not None:
            around = tuple(slice(part.start - 1, part.stop + 1) for part in box)
            marching_cubes((labels[around] == label).astype(np.float32), 0.5)


def read_ply(path):
    """Points and triangles of a binary PLY file as isoextract writes it without normals."""
    data = open(path, "rb").read()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    words = data[:start].split()
    vertices, faces = (int(words[words.index(element) + 1]) for element in (b"vertex", b"face"))
    points = np.frombuffer(data, "<f4", 3 * vertices, start).reshape(-1, 3)
    record = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    return points, np.frombuffer(data, record, faces, start + points.nbytes)["corners"]


def write_ply(path, points, triangles):
    """Writes points and triangles as read_ply reads them."""
    record = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    record["count"], record["corners"] = 3, triangles
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
              f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    with open(path, "wb") as file:
        file.write(header.encode() + points.astype("<f4").tobytes() + record.tobytes())


def meet(labels, pattern):
    points, triangles, first = [], [], 0
    for label in LABELS:
        of_label, corners = read_ply(pattern.replace("{iso}", str(label)))
        points.append(of_label)
        triangles.append(corners.astype(np.int64) + first)
        first += len(of_label)
    points = np.ascontiguousarray(np.concatenate(points))
    _, place = np.unique(points.view(np.dtype((np.void, points.itemsize * 3))).ravel(), return_inverse=True)
    corners = place.reshape(-1)[np.concatenate(triangles)]
    rolled = np.stack([np.roll(corners, -turn, axis=1) for turn in range(3)])
    corners = rolled[corners.argmin(axis=1), np.arange(len(corners))]
    turned = corners[:, [0, 2, 1]]

    def keys(of):
        return (of[:, 0] << 42) + (of[:, 1] << 21) + of[:, 2] if place.max() < 1 << 21 else \
            np.ascontiguousarray(of).view(np.dtype((np.void, of.itemsize * 3))).ravel()

    common = int(np.isin(keys(corners), keys(turned)).sum())
    faces = 0
    for axis in range(3):
        low, high = (np.take(labels, np.arange(labels.shape[axis] - 1) + step, axis) for step in (0, 1))
        faces += int(((low != high) & (low > 0) & (high > 0)).sum())
    return {"triangles": len(corners), "common": common // 2, "faces": faces}


def main(what, *arguments):
    if what == "head":
        np.save(arguments[1], head(arguments[0]))
    elif what == "ball":
        np.save(arguments[1], ball(int(arguments[0])))
    elif what == "cells":
        np.save(arguments[3], cells(int(arguments[0]), int(arguments[1]), arguments[2]))
    elif what == "skimage":
        by_skimage(np.load(arguments[0]))
    elif what == "vtk":
        print(json.dumps(by_vtk(np.load(arguments[0]), arguments[1], int(arguments[2]))))
    else:
        print(json.dumps(meet(np.load(arguments[0]), arguments[1])))


if __name__ == "__main__":
    main(*sys.argv[1:])
