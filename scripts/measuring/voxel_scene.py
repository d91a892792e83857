"""Inputs for the measurement of voxels, and its peer: faces of voxels by NumPy. Run by Python with NumPy:

    voxel_scene.py scene FILE.npy            land and water over a height field, as labels 1 and 2
    voxel_scene.py field NAME SIZE FILE.npy  gyroid or sphere as bytes, inside above 127
    voxel_scene.py faces FILE.npy ISO RUNS   exposed faces as triangles; times and counts as JSON
"""

import json
import sys
import time

import numpy as np

LAND, WATER = 30170, 3000  # voxels of the scene that is to be compared with


def scene():
    side, depth = 64, 32
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    hills = np.sin(x / 7.0) + np.cos(y / 9.0) + np.sin((x + 2 * y) / 13.0)
    heights = np.maximum(1, np.round(LAND / side**2 + 1.6 * hills)).astype(int).ravel()
    # Reaches LAND exactly: one column after the other gains or loses a voxel.
    for column in np.argsort(np.sin(np.arange(side**2)), kind="stable"):
        missing = LAND - heights.sum()
        if missing != 0 and heights[column] + np.sign(missing) >= 1:
            heights[column] += np.sign(missing)
    level = 1
    while np.maximum(0, level + 1 - heights).sum() <= WATER:
        level += 1
    surface = np.maximum(heights, level)
    for column in np.flatnonzero(heights <= level)[:WATER - np.maximum(0, level - heights).sum()]:
        surface[column] = level + 1
    z = np.arange(depth)[:, None]
    labels = np.where(z < heights, 1, np.where(z < surface, 2, 0)).astype(np.uint8).reshape(depth, side, side)
    assert (labels == 1).sum() == LAND and (labels == 2).sum() == WATER
    return labels


def field(name, size):
    axis = np.linspace(-1, 1, size, dtype=np.float32)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    if name == "sphere":
        value = 1 - np.sqrt(x * x + y * y + z * z)
    else:
        scale = np.float32(2 * np.pi)
        value = (np.sin(scale * x) * np.cos(scale * y) + np.sin(scale * y) * np.cos(scale * z) +
                 np.sin(scale * z) * np.cos(scale * x)) / 3
    return np.clip(value * 127 + 127.5, 0, 255).astype(np.uint8)


def faces(samples, iso):
    """Corners (n, 4, 3) of the exposed faces, and their triangles: each face by itself."""
    inside = np.pad(samples > iso, 1).astype(np.int8)
    corners = []
    for axis in range(3):
        step = np.diff(inside, axis=axis)
        u, v = (a for a in range(3) if a != axis)
        for sign in (1, -1):
            lower = np.argwhere(step == sign).astype(np.float32)
            lower[:, axis] += 1
            quad = np.repeat(lower[:, None, :] - np.float32(1.5), 4, axis=1)
            quad[:, [1, 2], u] += 1
            quad[:, [2, 3], v] += 1
            # u x v points along the axis, but against the middle axis; a step of 1 is where the inside begins.
            corners.append(quad[:, ::-1] if (sign == 1) != (axis == 1) else quad)
    quads = np.concatenate(corners)
    first = 4 * np.arange(len(quads), dtype=np.uint32)[:, None]
    triangles = np.concatenate([first + np.array([[0, 1, 2]], np.uint32), first + np.array([[0, 2, 3]], np.uint32)])
    return quads, triangles


def measure_faces(path, iso, runs):
    samples = np.load(path)
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        quads, triangles = faces(samples, iso)
        seconds.append(time.perf_counter() - start)
    return {"ms": [1000 * s for s in seconds], "triangles": len(triangles), "vertices": 4 * len(quads),
            "numpy": np.__version__}


def main(what, *words):
    if what == "scene":
        np.save(words[0], scene())
    elif what == "field":
        np.save(words[2], field(words[0], int(words[1])))
    else:
        print(json.dumps(measure_faces(words[0], float(words[1]), int(words[2]))))


if __name__ == "__main__":
    main(*sys.argv[1:])
