"""Reads PLY files with numpy alone: binary of either byte order and ascii, as isoextract and other programs write them.

Polygons of more than three corners become fans of triangles. Properties of vertices that PLY gives no meaning become
attributes: `velocity_0`, `velocity_1`, `velocity_2` one of three components.
"""

import os
import re

import numpy as np

from .kinds import PROGRAM, kind_of, kinds_in
from .surface import Attribute, Surface, UnreadableFile, checked_triangles, linear_from_srgb

TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
         "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
         "float32": "f4", "float64": "f8"}
BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": None}
PLACES, NORMALS, COLORS = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue", "alpha")
CORNERS = ("vertex_indices", "vertex_index")
HEADER_LIMIT = 1 << 20


def read_ply(path):
    """The `Surface` of a file, in the axes of the file."""
    try:
        with open(path, "rb") as file:
            elements, order, kinds = _header(path, file)
            body = file.read()
        columns = _text_columns(elements, body) if order is None else _binary_columns(elements, order, body)
        return _surface(os.fspath(path), elements, columns, kinds)
    except OSError as error:
        raise UnreadableFile(f"{path}: {error.strerror or error}") from error
    except (KeyError, IndexError, ValueError, TypeError, OverflowError) as error:
        raise UnreadableFile(f"{path}: damaged PLY ({type(error).__name__}: {error})") from error


class _Element:
    def __init__(self, name, count):
        if count < 0:
            raise ValueError(f"{count} of element {name}")
        self.name = name
        self.count = count
        self.properties = []  # (name, type, type of a list's length or None)

    def is_fixed(self):
        return all(length is None for _, _, length in self.properties)


def _header(path, file):
    """The elements, the byte order or None for ascii, and the kinds of attributes, None where isoextract did not write
    the file; `file` is then where the data begins."""
    if file.readline(16).rstrip() != b"ply":
        raise UnreadableFile(f"{path}: not a PLY file")
    elements, order, is_ours, kinds = [], "", False, {}
    while True:
        line = file.readline(HEADER_LIMIT)
        words = line.decode("latin-1").split()
        if not line or file.tell() > HEADER_LIMIT:
            raise UnreadableFile(f"{path}: the header does not end")
        if words[:1] == ["format"]:
            order = BYTE_ORDERS[words[1]]
        elif words[:2] == ["comment", PROGRAM]:
            is_ours = True
        elif words[:2] == ["comment", "placement"]:
            kinds = kinds_in(line.decode("latin-1").partition("placement")[2])
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2])))
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append((words[4], TYPES[words[3]], TYPES[words[2]]))
        elif words[:1] == ["property"]:
            elements[-1].properties.append((words[2], TYPES[words[1]], None))
        elif words == ["end_header"]:
            break
    if order == "":
        raise UnreadableFile(f"{path}: the header names no format")
    return elements, order, kinds if is_ours else None


def _binary_columns(elements, order, body):
    """{element: {property: values}}; a list's values are one array with a row a list, or a list of arrays."""
    columns, place = {}, 0
    for element in elements:
        columns[element.name], place = _binary_element(element, order, body, place)
    return columns


def _binary_element(element, order, body, place):
    if element.count == 0:
        return {name: np.zeros((0, 3) if length else 0, kind) for name, kind, length in element.properties}, place
    # First as if all lists were as long as those of the first row, which is so in nearly every file.
    lengths = {}
    if not element.is_fixed():
        first, _ = _binary_row(element, order, body, place)
        lengths = {name: len(first[name]) for name, _, length in element.properties if length}
    fields = []
    for name, kind, length in element.properties:
        if length:
            fields.append(("length of " + name, order + length))
        fields.append((name, order + kind, (lengths[name],)) if length else (name, order + kind))
    row = np.dtype(fields)
    if place + row.itemsize * element.count <= len(body):
        rows = np.frombuffer(body, row, element.count, place)
        if all((rows["length of " + name] == length).all() for name, length in lengths.items()):
            return {name: rows[name] for name, _, _ in element.properties}, place + row.itemsize * element.count
    elif element.is_fixed():
        raise ValueError(f"the data ends within element {element.name}")
    values = {name: [] for name, _, _ in element.properties}
    for _ in range(element.count):
        found, place = _binary_row(element, order, body, place)
        for name, value in found.items():
            values[name].append(value)
    return {name: values[name] if length else np.array(values[name]) for name, _, length in element.properties}, place


def _binary_row(element, order, body, place):
    found = {}
    for name, kind, length in element.properties:
        count = 1
        if length:
            count = int(np.frombuffer(body, order + length, 1, place)[0])
            place += np.dtype(length).itemsize
            if count < 0:
                raise ValueError(f"a list of length {count}")
        values = np.frombuffer(body, order + kind, count, place) if count else np.zeros(0, kind)
        place += values.nbytes
        found[name] = values if length else values[0]
    return found, place


def _text_columns(elements, body):
    words = np.array(body.split(), dtype=np.float64)
    columns, place = {}, 0
    for element in elements:
        columns[element.name], place = _text_element(element, words, place)
    return columns


def _text_element(element, words, place):
    count, properties = element.count, element.properties
    if count == 0:
        return {name: np.zeros((0, 3) if length else 0, kind) for name, kind, length in properties}, place
    # As above: first as if all lists were as long as those of the first row.
    lengths, starts, width = {}, {}, 0
    for name, _, length in properties:
        starts[name] = width
        width += 1
        if length:
            lengths[name] = _whole(words[place + starts[name]])
            width += lengths[name]
    if place + count * width <= len(words):
        rows = words[place:place + count * width].reshape(count, width)
        if all((rows[:, starts[name]] == length).all() for name, length in lengths.items()):
            return {
                name: (rows[:, starts[name] + 1:starts[name] + 1 + lengths[name]] if length
                       else rows[:, starts[name]]).astype(kind)
                for name, kind, length in properties
            }, place + count * width
    elif element.is_fixed():
        raise ValueError(f"the data ends within element {element.name}")
    values = {name: [] for name, _, _ in properties}
    for _ in range(count):
        for name, kind, length in properties:
            size = _whole(words[place]) if length else 1
            place += 1 if length else 0
            found = words[place:place + size].astype(kind)
            if len(found) != size:
                raise ValueError(f"the data ends within element {element.name}")
            place += size
            values[name].append(found if length else found[0])
    return {name: values[name] if length else np.array(values[name]) for name, _, length in properties}, place


def _whole(number):
    if not 0 <= number < 2**31 or number != int(number):
        raise ValueError(f"a list of length {number}")
    return int(number)


def _surface(path, elements, columns, kinds):
    vertices, faces = columns.get("vertex", {}), columns.get("face", {})
    types = {name: kind for element in elements if element.name == "vertex" for name, kind, _ in element.properties}
    if any(name not in vertices for name in PLACES):
        raise UnreadableFile(f"{path}: its vertices have no x, y and z")
    if "tristrips" in columns:
        raise UnreadableFile(f"{path}: has strips of triangles, which this add-on does not read")
    positions, origin = _positions(vertices, types)
    corners = next((faces[name] for name in CORNERS if name in faces), np.zeros((0, 3), np.int32))
    normals = None
    if all(name in vertices for name in NORMALS):
        normals = np.stack([vertices[name] for name in NORMALS], axis=1).astype(np.float32)
    return Surface(
        positions,
        checked_triangles(_fans(corners), len(positions), path),
        origin,
        normals,
        flat=normals is None and all(name in faces for name in NORMALS),
        attributes=_attributes(vertices, types, kinds),
    )


def _positions(vertices, types):
    """Positions and the origin that they are relative to: where numbers are of 64 bits, the middle of their box."""
    places = np.stack([vertices[name] for name in PLACES], axis=1)
    if not len(places) or all(types[name] != "f8" for name in PLACES):
        return places.astype(np.float32), np.zeros(3)
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    if not np.isfinite(middle).all():
        raise ValueError("a vertex is not at a finite place")
    return (places - middle).astype(np.float32), middle


def _fans(corners):
    """Polygons as triangles."""
    if isinstance(corners, np.ndarray):
        sides = corners.shape[1]
        if sides < 3:
            return np.zeros((0, 3), np.int64)
        fans = [corners[:, [0, i, i + 1]] for i in range(1, sides - 1)]
        return np.stack(fans, axis=1).reshape(-1, 3)
    triangles = [(polygon[0], polygon[i], polygon[i + 1]) for polygon in corners for i in range(1, len(polygon) - 1)]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _attributes(vertices, types, kinds):
    attributes = []
    left = {name: vertices[name] for name in vertices
            if name not in (*PLACES, *NORMALS) and isinstance(vertices[name], np.ndarray) and vertices[name].ndim == 1}
    if all(name in left for name in COLORS[:3]):
        scale = {"u1": 255, "u2": 65535}.get(types["red"], 1)
        columns = [left.pop(name) / np.float32(scale) for name in COLORS if name in left]
        if len(columns) == 3:
            columns.append(np.ones(len(columns[0]), np.float32))
        colors = np.stack(columns, axis=1).astype(np.float32)
        attributes.append(Attribute("Color", colors if scale == 1 else linear_from_srgb(colors), True))
    groups = {}
    for name in left:
        stem = re.fullmatch(r"(.+)_([0-3])", name)
        groups.setdefault(stem.group(1) if stem else name, []).append(name)
    for stem, names in groups.items():
        if names == [stem] or names != [f"{stem}_{i}" for i in range(len(names))] or len(names) == 1:
            attributes += [Attribute(name, _numbers(left[name][:, None])) for name in names]
        else:
            values = _numbers(np.stack([left[name] for name in names], axis=1))
            attributes.append(Attribute(stem, values, kind=kind_of(stem, values.shape[1], kinds)))
    return attributes


def _numbers(values):
    """As float32 or int32, which is all that Blender has; numbers that do not fit into int32 become float32."""
    fits = values.dtype.kind in "iu" and (values.dtype.itemsize < 4 or values.dtype.kind == "i"
                                          or not values.size or values.max() < 2**31)
    return values.astype(np.int32 if fits else np.float32)
