"""VDB files of leaf nodes that are alike, written without OpenVDB: one float grid, values of active voxels only."""

import itertools
import struct

LEAF = 8  # voxels a side
LOWER = 16 * LEAF
UPPER = 32 * LOWER
FILE_VERSION = 224
ACTIVE_VALUES_ONLY = 2
REST_IS_BACKGROUND = b"\0"


def text(words):
    return struct.pack("<I", len(words)) + words.encode()


def mask(bits, size):
    """`size` bits, of which those numbered `bits` are on."""
    number = sum(1 << bit for bit in bits)
    return number.to_bytes(size // 8, "little")


def slots(places, size, sides):
    """What lies in each child of a node: the children's numbers, rising, with the places in them."""
    step = size // sides
    found = {}
    for place in places:
        x, y, z = (c % size // step for c in place)
        found.setdefault((x * sides + y) * sides + z, []).append(place)
    return sorted(found.items())


def topology(places, leaf_mask):
    """The tree of leaf nodes at `places`, whose coordinates are multiples of LEAF from 0 on."""
    roots = {}
    for place in places:
        roots.setdefault(tuple(c // UPPER * UPPER for c in place), []).append(place)
    parts = [struct.pack("<ifII", 1, 0, 0, len(roots))]
    for root, inside in sorted(roots.items()):
        uppers = slots(inside, UPPER, 32)
        parts += [struct.pack("<3i", *root), mask((slot for slot, _ in uppers), 32**3), bytes(32**3 // 8), REST_IS_BACKGROUND]
        for _, within in uppers:
            leaves = slots(within, LOWER, 16)
            parts += [mask((slot for slot, _ in leaves), 16**3), bytes(16**3 // 8), REST_IS_BACKGROUND]
            parts += len(leaves) * [leaf_mask]
    return b"".join(parts)


def write_leaves(path, places, values):
    """A grid of the background 0 with a leaf node at each of `places`; `values` are those of its voxels (x, y, z)."""
    numbered = sorted(((x * LEAF + y) * LEAF + z, value) for (x, y, z), value in values.items())
    leaf_mask = mask((number for number, _ in numbered), LEAF**3)
    leaf_values = leaf_mask + REST_IS_BACKGROUND + struct.pack(f"<{len(numbered)}f", *(value for _, value in numbered))
    scale = struct.pack("<15d", *itertools.repeat(1.0, 15))
    grid = struct.pack("<I", ACTIVE_VALUES_ONLY) + struct.pack("<I", 1) + text("class") + text("string") + text("fog volume")
    grid += text("UniformScaleMap") + scale
    tree = topology(places, leaf_mask)
    head = struct.pack("<qIIIB", 0x56444220, FILE_VERSION, 9, 1, 1) + 36 * b"0" + struct.pack("<Ii", 0, 1)
    descriptor = text("density") + text("Tree_float_5_4_3") + text("")
    begin = len(head) + len(descriptor) + 24
    values_begin = begin + len(grid) + len(tree)
    with open(path, "wb") as file:
        file.write(head + descriptor)
        file.write(struct.pack("<3q", begin, values_begin, values_begin + len(places) * len(leaf_values)))
        file.write(grid + tree)
        file.write(len(places) * leaf_values)
