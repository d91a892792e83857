"""Writes VDB files byte by byte, including content that OpenVDB itself would not write."""

import itertools
import struct

NO_OFFSETS, OFFSETS = 0, 1
ACTIVE_MASK = 2  # compression that stores only a node's active values
BACKGROUND = b"\0"  # code of a node whose inactive values all equal the background


def text(value):
    """Encodes a name (str or bytes) as its length and its bytes."""
    value = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(value)) + value


def scale(voxel=1.0):
    """Encodes a transform with this voxel size."""
    vectors = (voxel, 1 / voxel, 1 / voxel**2, 1 / (2 * voxel), voxel)
    return text("UniformScaleMap") + b"".join(struct.pack("<3d", *(v,) * 3) for v in vectors)


def frustum():
    """Encodes a transform that is not linear."""
    return text("NonlinearFrustumMap") + struct.pack("<8d", 0, 0, 0, 9, 9, 9, 0.5, 1) + scale()


def mask(side, places):
    bits = sum(1 << (x * side + y) * side + z for x, y, z in places)
    return bits.to_bytes(side**3 // 8, "little")


def children(voxels, size, count):
    """Groups the voxels by the child that holds them, numbered among `count` children per axis."""
    by_child = {}
    for place in sorted(voxels, key=lambda p: tuple(c // size % count for c in p)):
        by_child.setdefault(tuple(c // size % count for c in place), []).append(place)
    return by_child


def tree(voxels, background=0.0):
    """Encodes a tree of floats; `voxels` maps the index of each active voxel to its value."""
    roots = {}
    for place in voxels:
        roots.setdefault(tuple(c // 4096 * 4096 for c in place), []).append(place)
    topology = [struct.pack("<ifII", 1, background, 0, len(roots))]
    leaves = []
    for origin in sorted(roots):
        uppers = children(roots[origin], 128, 32)
        topology += [struct.pack("<3i", *origin), mask(32, uppers), bytes(4096), BACKGROUND]
        for in_upper in uppers.values():
            lowers = children(in_upper, 8, 16)
            topology += [mask(16, lowers), bytes(512), BACKGROUND]
            for in_leaf in lowers.values():
                active = mask(8, [tuple(c % 8 for c in place) for place in in_leaf])
                topology.append(active)
                values = sorted((tuple(c % 8 for c in place), voxels[place]) for place in in_leaf)
                leaves += [active, BACKGROUND, *(struct.pack("<f", value) for _, value in values)]
    return b"".join(topology + leaves)


def counts(voxels):
    """Encodes metadata: the number of voxels and their box."""
    low = [min(place[axis] for place in voxels) for axis in range(3)]
    high = [max(place[axis] for place in voxels) for axis in range(3)]
    return {"file_voxel_count": ("int64", struct.pack("<q", len(voxels))),
            "file_bbox_min": ("vec3i", struct.pack("<3i", *low)), "file_bbox_max": ("vec3i", struct.pack("<3i", *high))}


def metadata(entries):
    return struct.pack("<I", len(entries)) + b"".join(
        text(name) + text(kind) + struct.pack("<I", len(value)) + value for name, (kind, value) in entries.items())


def grid(name="density", voxels=None, background=0.0, transform=None, kind="float_5_4_3", meta=None):
    """Returns a grid for vdb(), with its counts as metadata unless `meta` replaces them."""
    voxels = {} if voxels is None else voxels
    if meta is None:
        meta = counts(voxels) if voxels else {"file_voxel_count": ("int64", struct.pack("<q", 0))}
    body = struct.pack("<I", ACTIVE_MASK) + metadata(meta) + (scale() if transform is None else transform)
    return name, kind, body + tree(voxels, background)


def vdb(*grids, stream=False):
    """Returns the bytes of a file. Grids with the same name get a suffix after a separator, as in OpenVDB."""
    out = struct.pack("<qIIIB", 0x56444220, 224, 10, 0, NO_OFFSETS if stream else OFFSETS)
    out += b"01234567-89ab-cdef-0123-456789abcdef"  # OpenVDB finds no grids after an invalid UUID
    out += metadata({}) + struct.pack("<i", len(grids))
    numbers = {}
    for name, kind, body in grids:
        name = name.encode() if isinstance(name, str) else name
        number = numbers.setdefault(name, itertools.count())
        unique = name + b"\x1e%d" % next(number) if sum(1 for g in grids if text(g[0]) == text(name)) > 1 else name
        out += text(unique) + text("Tree_" + kind) + text("")
        begin = len(out) + 24
        out += struct.pack("<3q", *((0, 0, 0) if stream else (begin, begin, begin + len(body)))) + body
    return out
