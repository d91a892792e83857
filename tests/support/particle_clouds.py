"""Particles for tests and measurements: sets of a known shape, files of them, and a mesh's distance from that shape.
Uses only the standard library. Lengths are in world units unless a name says radii."""

import array
import math
import random
import struct

import mesh_readers


def ball_radius(count, radius):
    """Returns the radius of the ball with the volume of that many cubes of two particle radii."""
    return radius * (6 * count / math.pi) ** (1 / 3)


def jittered_lattice(radius, half_width, inside, jitter, seed=7):
    """Yields layers of particles as floats x y z: the points of a lattice of touching particles around 0 for which
    inside(x, y, z) is true. Then shifts each by up to `jitter` radii along each axis."""
    shift = random.Random(seed).uniform
    step, most = 2 * radius, int(half_width / (2 * radius)) + 1
    for i in range(-most, most + 1):
        layer = array.array("f")
        for j in range(-most, most + 1):
            for k in range(-most, most + 1):
                if inside(i * step, j * step, k * step):
                    layer.extend(step * n + radius * shift(-jitter, jitter) for n in (i, j, k))
        yield layer


def ball(count, jitter):
    """Returns the radius and the layers of about `count` particles that fill the unit ball around 0."""
    radius = 1 / ball_radius(count, 1)
    return radius, jittered_lattice(radius, 1, lambda x, y, z: x * x + y * y + z * z <= 1, jitter)


DENTS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
DENT_DEPTH = 0.1
DENT_WIDTH = 0.3  # angle at which a dent has 1/e of its depth


def dented_radius(x, y, z):
    """Returns the distance of the dented ball's surface from its center in that direction; 1 away from dents."""
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0:
        return 1
    dents = 0.0
    for a, b, c in DENTS:
        angle = math.acos(max(-1.0, min(1.0, (a * x + b * y + c * z) / length)))
        dents += math.exp(-((angle / DENT_WIDTH) ** 2))
    return 1 - DENT_DEPTH * dents


def dented_ball(count, jitter):
    """Returns the same for the ball with dents, without the particles that the dents cut off."""
    radius = 1 / ball_radius(count, 1)

    def inside(x, y, z):
        return x * x + y * y + z * z <= dented_radius(x, y, z) ** 2

    return radius, jittered_lattice(radius, 1, inside, jitter)


def write_ply(path, layers):
    """Writes positions as binary PLY and returns their number. Writes the header last, when the number is known."""
    head = "ply\nformat binary_little_endian 1.0\nelement vertex {:012}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    count = 0
    with open(path, "wb") as file:
        file.write(head.format(0).encode())
        for layer in layers:
            count += len(layer) // 3
            file.write(struct.pack(f"<{len(layer)}f", *layer))
        file.seek(0)
        file.write(head.format(count).encode())
    return count


def vtk_points(path):
    """Reads the points of a legacy VTK file with binary floats, as (x, y, z)."""
    data = path.read_bytes()
    start = data.index(b"POINTS ")
    end = data.index(b"\n", start)
    _, count, kind = data[start:end].split()
    if kind != b"float":
        raise AssertionError(f"{path}: points of {kind}")
    return list(struct.iter_unpack(">3f", data[end + 1:end + 1 + 12 * int(count)]))


def as_layers(points):
    return [array.array("f", (c for point in points for c in point))]


def polygons_of_ply(path):
    """Reads the vertices and polygons, with any number of corners, of a binary PLY file."""
    with open(path, "rb") as file:
        header = mesh_readers.PlyHeader(file)
        body = memoryview(file.read())
    types = mesh_readers.PLY_TYPES
    vertex = struct.Struct("<" + "".join(types[words[0]] for words in header.properties["vertex"]))
    names = [words[-1] for words in header.properties["vertex"]]
    x, y, z = (names.index(axis) for axis in "xyz")
    end = vertex.size * header.counts["vertex"]
    vertices = [(v[x], v[y], v[z]) for v in vertex.iter_unpack(body[:end])]
    _, count_type, index_type, _ = header.properties["face"][0]
    faces = body[end:]
    records = {n: struct.Struct("<" + types[count_type] + n * types[index_type]) for n in (3, 4)}
    # All polygons have the same number of corners, as in the files of most writers.
    for n, record in records.items():
        if len(faces) == record.size * header.counts["face"] and len(faces) > 0 and faces[0] == n:
            return vertices, [face[1:] for face in record.iter_unpack(faces)]
    polygons = []
    at = 0
    for _ in range(header.counts["face"]):
        record = records[faces[at]]
        polygons.append(record.unpack_from(faces, at)[1:])
        at += record.size
    return vertices, polygons


def volume_of(vertices, polygons):
    """Returns the volume for either winding; OpenVDB's polygons face inwards. Sums relative to a vertex, since products
    of large coordinates would cancel."""
    total = 0.0
    x, y, z = vertices[0]
    for first, *others in polygons:
        ax, ay, az = vertices[first]
        ax, ay, az = ax - x, ay - y, az - z
        for b, c in zip(others, others[1:]):
            bx, by, bz = vertices[b]
            cx, cy, cz = vertices[c]
            bx, by, bz, cx, cy, cz = bx - x, by - y, bz - z, cx - x, cy - y, cz - z
            total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return abs(total) / 6


def distance_facts(vertices, distance):
    """Statistics of distance(x, y, z), positive outside, over all vertices: the mean, the root mean square about it,
    and the largest of either sign, from 0 and from the mean."""
    values = [distance(*vertex) for vertex in vertices]
    mean = math.fsum(values) / len(values)
    spread = math.sqrt(math.fsum((value - mean) ** 2 for value in values) / len(values))
    return {"mean": mean, "rms_about_mean": spread, "max": max(map(abs, values)),
            "max_about_mean": max(abs(value - mean) for value in values)}


def face_spreads(points, vertices, radius, rim=4):
    """For a block of particles that fills its box: the spread, in radii, of the mesh's vertices over each of the six
    faces along the face's normal. Skips a rim of that many radii."""
    low = [min(point[axis] for point in points) for axis in range(3)]
    high = [max(point[axis] for point in points) for axis in range(3)]
    spreads = []
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        over = [v[axis] for v in vertices
                if all(low[o] + rim * radius <= v[o] <= high[o] - rim * radius for o in others)]
        for side in ([h for h in over if high[axis] - radius < h < high[axis] + 3 * radius],
                     [h for h in over if low[axis] - 3 * radius < h < low[axis] + radius]):
            if not side:
                raise AssertionError(f"no vertex over a face across axis {axis}")
            spreads.append((max(side) - min(side)) / radius)
    return spreads
