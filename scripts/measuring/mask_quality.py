"""Masks for the measurement of their surfaces, and how good a surface is. Run by Python with NumPy, SciPy and VTK:

    mask_quality.py ball RADIUS MASK.npy        a ball
    mask_quality.py mask FIELD LIMIT MASK.npy [SIZE]
        the samples of a field above a limit; .nrrd, .vti or .mhd; of the middle SIZE samples along each axis
    mask_quality.py surface MASK.npy MESH.ply [RADIUS]
        figures of a mesh as JSON; with RADIUS, the distance is that to the ball
    mask_quality.py shift MESH.ply X OUT.ply    moves a mesh along x
"""

import json
import sys

import numpy as np

import label_maps

FARTHEST = 8  # voxels: farther distances are not measured
MARGIN = 2  # empty voxels around a mask, so that no surface leaves the grid
TYPES = {"float": "f4", "double": "f8", "unsigned char": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
         "unsigned short": "u2", "uint16": "u2"}


def read_nrrd(path):
    """Returns the samples of a raw NRRD file, indexed by z, y, x."""
    data = open(path, "rb").read()
    start = data.index(b"\n\n") + 2
    lines = (line.split(":", 1) for line in data[:start].decode().splitlines() if ": " in line)
    header = {name: value.strip() for name, value in lines}
    kind = np.dtype(TYPES[header["type"]]).newbyteorder("<" if header.get("endian", "little") == "little" else ">")
    return np.frombuffer(data, kind, offset=start).reshape([int(size) for size in header["sizes"].split()][::-1])


def read_by_vtk(path):
    """Returns the samples of a VTI or MetaImage file, indexed by z, y, x."""
    import vtk
    from vtk.util import numpy_support

    reader = vtk.vtkXMLImageDataReader() if path.endswith(".vti") else vtk.vtkMetaImageReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    return numpy_support.vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])


def above(field, limit, size):
    """Returns the mask of the middle samples of a field above a limit, cut to its bounds with a margin."""
    inside = field[tuple(slice(max((side - size) // 2, 0), (side + size) // 2) for side in field.shape)] > limit
    ranges = [np.flatnonzero(inside.any(axis=tuple({0, 1, 2} - {axis}))) for axis in range(3)]
    cut = inside[tuple(slice(found[0], found[-1] + 1) for found in ranges)]
    return np.pad(cut, MARGIN).astype(np.uint8)


def bodies(mask):
    """Returns how many sets of voxels, connected through faces, a mask has."""
    from scipy import ndimage

    return int(ndimage.label(mask)[1])


def normals(points, triangles):
    """Returns a vector a triangle, as long as twice its area."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def mean_angle(points, triangles):
    """Returns the mean angle in degrees between the normals of two triangles with a common edge."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    ends.sort(axis=1)
    keys = ends[:, 0] * len(points) + ends[:, 1]
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    first = first[counts == 2]
    pairs = order[np.stack([first, first + 1])] % len(triangles)
    one, other = normals(points, triangles)[pairs]
    cosine = np.einsum("ij,ij->i", one, other)
    sine = np.linalg.norm(np.cross(one, other), axis=1)
    return float(np.degrees(np.arctan2(sine, cosine)[(sine != 0) | (cosine != 0)].mean()))


def signed_volume(points, triangles):
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def to_boxes(points, cells, state, mask, reach):
    """Returns the distance of each point to the nearest voxel of another state within `reach` voxels of its own."""
    found = np.full(len(points), np.inf)
    offsets = range(-reach, reach + 1)
    for step in ((z, y, x) for z in offsets for y in offsets for x in offsets if (z, y, x) != (0, 0, 0)):
        other = np.clip(cells + step, 0, np.array(mask.shape) - 1)
        beyond = np.maximum(np.abs(points - (cells + step)) - 0.5, 0)
        squares = np.einsum("ij,ij->i", beyond, beyond)
        np.minimum(found, np.where(mask[tuple(other.T)] != state, squares, np.inf), out=found)
    return np.sqrt(found)


def to_faces(points, mask):
    """Returns the largest distance of points to the faces between voxels inside and outside."""
    cells = np.clip(np.rint(points), 0, np.array(mask.shape) - 1).astype(np.int64)
    state = mask[tuple(cells.T)]
    bound = np.full(len(points), np.inf)  # the distance to the nearest face of the own voxel: no distance is larger
    for axis in range(3):
        for side in (-1, 1):
            other = cells.copy()
            other[:, axis] = np.clip(other[:, axis] + side, 0, mask.shape[axis] - 1)
            gap = np.maximum(0.5 - side * (points[:, axis] - cells[:, axis]), 0)
            bound = np.where(mask[tuple(other.T)] != state, np.minimum(bound, gap), bound)
    largest = 0.0
    order = np.argsort(-bound, kind="stable")
    for begin in range(0, len(order), 50000):
        some = order[begin:begin + 50000]
        some = some[bound[some] > largest]
        if not len(some):
            break
        for reach in (1, 3, FARTHEST):
            distances = to_boxes(points[some], cells[some], state[some], mask, reach)
            sure = distances <= reach  # voxels beyond are further off
            largest = max(largest, distances[sure].max(initial=0))
            some = some[~sure]
            if not len(some):
                break
        if len(some):
            raise ValueError(f"a point is more than {FARTHEST} voxels from all faces")
    return float(largest)


def enclosed(points, triangles, shape):
    """Returns which centers of voxels a mesh encloses: those around which its triangles wind."""
    crossings = np.zeros((shape[0], shape[1], shape[2] + 1), np.int32)
    corners = points[triangles] - (0, 0.000137, 0.000211)  # so that no line along x meets an edge or vertex
    x, y, z = (corners[:, :, axis] for axis in range(3))
    low_y, low_z = np.ceil(y.min(axis=1)).astype(int), np.ceil(z.min(axis=1)).astype(int)
    many_y, many_z = np.floor(y.max(axis=1)).astype(int) - low_y + 1, np.floor(z.max(axis=1)).astype(int) - low_z + 1
    for step_y in range(many_y.max()):
        for step_z in range(many_z.max()):
            some = np.flatnonzero((step_y < many_y) & (step_z < many_z))
            row, layer = low_y[some] + step_y, low_z[some] + step_z
            dy, dz = y[some] - row[:, None], z[some] - layer[:, None]
            weights = np.stack([dy[:, (k + 1) % 3] * dz[:, (k + 2) % 3] - dy[:, (k + 2) % 3] * dz[:, (k + 1) % 3]
                                for k in range(3)], axis=1)
            hit = (weights > 0).all(axis=1) | (weights < 0).all(axis=1)
            total = weights[hit].sum(axis=1)
            at = np.einsum("ij,ij->i", weights[hit], x[some][hit]) / total
            column = np.clip(np.ceil(at), 0, shape[2]).astype(int)
            np.add.at(crossings, (layer[hit], row[hit], column), np.sign(total).astype(np.int32))
    return crossings.cumsum(axis=2)[:, :, :-1] != 0


def figures(mask, points, triangles, radius=None):
    """Returns the figures of a mesh in voxels; points are x, y, z."""
    points = points.astype(float)
    triangles = triangles.astype(np.int64)
    found = enclosed(points, triangles, mask.shape)
    samples = np.concatenate([points, points[triangles].mean(axis=1)])
    if radius is None:
        distance = to_faces(samples[:, ::-1], mask)
    else:
        center = (np.array(mask.shape[::-1]) - 1) / 2 - label_maps.OFF_CENTER
        distance = float(np.abs(np.linalg.norm(samples - center, axis=1) - radius).max())
    return {"triangles": len(triangles), "angle": mean_angle(points, triangles),
            "volume": abs(signed_volume(points, triangles)) / int(mask.sum()), "distance": distance,
            "lost": int((mask.astype(bool) & ~found).sum()), "gained": int((~mask.astype(bool) & found).sum())}


def main(what, *arguments):
    if what == "ball":
        np.save(arguments[1], label_maps.ball(int(arguments[0])))
    elif what == "mask":
        field = (read_nrrd if arguments[0].endswith(".nrrd") else read_by_vtk)(arguments[0])
        mask = above(field, float(arguments[1]), int(arguments[3]) if arguments[3:] else max(field.shape))
        np.save(arguments[2], mask)
        print(json.dumps({"size": mask.shape[::-1], "voxels": int(mask.sum()), "bodies": bodies(mask)}))
    elif what == "shift":
        points, triangles = label_maps.read_ply(arguments[0])
        label_maps.write_ply(arguments[2], points + (float(arguments[1]), 0, 0), triangles)
    else:
        mask = np.load(arguments[0])
        print(json.dumps(figures(mask, *label_maps.read_ply(arguments[1]), *map(float, arguments[2:]))))


if __name__ == "__main__":
    main(*sys.argv[1:])
