"""Facts of a mesh on which two programs must agree."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Mesh:
    positions: np.ndarray  # n x 3, float64
    triangles: np.ndarray  # m x 3


@dataclass
class Facts:
    """Facts of all meshes of a file together."""
    vertices: int
    triangles: int
    open_edges: int     # of one triangle
    crossed_edges: int  # of more than two
    minimum: list
    maximum: list


def merged(mesh):
    """The mesh with one vertex per position, without triangles that then have two equal corners."""
    places, vertex_of = np.unique(mesh.positions + 0.0, axis=0, return_inverse=True)  # + 0.0: -0 is 0
    triangles = vertex_of.reshape(-1)[mesh.triangles]
    a, b, c = triangles.T
    return Mesh(places, triangles[(a != b) & (b != c) & (c != a)])


def without_repeats(mesh):
    """The mesh without triangles that have the corners of another one."""
    kept = np.unique(np.sort(mesh.triangles, axis=1), axis=0, return_index=True)[1]
    return Mesh(mesh.positions, mesh.triangles[np.sort(kept)])


def edge_uses(triangles):
    """How many triangles use each edge, whatever its direction."""
    if len(triangles) == 0:
        return np.zeros(0, dtype=np.int64)
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    keys = ends[:, 0].astype(np.uint64) << np.uint64(32) | ends[:, 1].astype(np.uint64)
    return np.unique(keys, return_counts=True)[1]


def bounds(meshes):
    """Smallest and largest coordinates; zeros if there are none."""
    corners = [(mesh.positions.min(axis=0), mesh.positions.max(axis=0)) for mesh in meshes if len(mesh.positions)]
    if not corners:
        return [0.0] * 3, [0.0] * 3
    return (np.min([low for low, _ in corners], axis=0).tolist(),
            np.max([high for _, high in corners], axis=0).tolist())


def measure(meshes):
    uses = [edge_uses(mesh.triangles) for mesh in meshes]
    minimum, maximum = bounds(meshes)
    return Facts(vertices=sum(len(mesh.positions) for mesh in meshes),
                 triangles=sum(len(mesh.triangles) for mesh in meshes),
                 open_edges=int(sum((use == 1).sum() for use in uses)),
                 crossed_edges=int(sum((use > 2).sum() for use in uses)),
                 minimum=minimum, maximum=maximum)
