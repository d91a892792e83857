"""Reads GLB files (glTF 2.0, binary) with numpy alone: all triangles of the scene, with what their vertices carry.

Read are the translations, rotations and scales of nodes, accessors with gaps between their values (byteStride) and
those of whole numbers (KHR_mesh_quantization). A node of no size, as animations hide one, shows nothing and is left out.
Attributes are taken to be in the axes of the scene: nodes do not change them.
Compressed files are refused with a message that says what to do.
"""

import json
import math
import os
import struct

import numpy as np

from .kinds import PROGRAM, kind_of, kinds_in
from .surface import Attribute, Surface, UnreadableFile, checked_triangles

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
KNOWN_EXTENSIONS = {"KHR_mesh_quantization", "KHR_materials_unlit", "KHR_texture_transform"}
COMPRESSIONS = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt"}
TRIANGLES = 4


def read_glb(path):
    """The `Surface` of a file, with y up, as glTF has it."""
    try:
        with open(path, "rb") as file:
            data = file.read()
        return _Model(path, *_chunks(path, data)).surface()
    except OSError as error:
        raise UnreadableFile(f"{path}: {error.strerror or error}") from error
    except (LookupError, TypeError, AttributeError, ValueError, RecursionError, np.linalg.LinAlgError,
            struct.error) as error:
        raise UnreadableFile(f"{path}: damaged glTF ({type(error).__name__}: {error})") from error


def _chunks(path, data):
    """The JSON document and the binary chunk, which may be missing."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise UnreadableFile(f"{path}: not a GLB file")
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise UnreadableFile(f"{path}: glTF version {version}, expected 2")
    if length > len(data):
        raise UnreadableFile(f"{path}: cut off: {len(data)} bytes, expected {length}")
    json_length, kind = struct.unpack_from("<I4s", data, 12)
    if kind != b"JSON" or 20 + json_length > length:
        raise UnreadableFile(f"{path}: the first chunk is not a whole JSON chunk")
    document = json.loads(data[20:20 + json_length].decode("utf-8"))
    start = 20 + json_length
    if start + 8 > length:
        return document, memoryview(b"")
    binary_length, kind = struct.unpack_from("<I4s", data, start)
    if kind != b"BIN\0" or start + 8 + binary_length > length:
        raise UnreadableFile(f"{path}: the second chunk is not a whole BIN chunk")
    return document, memoryview(data)[start + 8:start + 8 + binary_length]


class _Model:
    def __init__(self, path, document, binary):
        self.path = os.fspath(path)
        self.document = document
        self.binary = binary
        asset = document.get("asset", {})
        is_ours = str(asset.get("generator", "")).startswith(PROGRAM + " ")
        self.kinds = kinds_in(asset.get("extras", {}).get("placement")) if is_ours else None

    def surface(self):
        self._refuse_what_is_not_read()
        parts = [part for node, matrix in self._visible_nodes() for part in self._node_parts(node, matrix)]
        if not parts:
            return Surface(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
        return _joined(parts)

    def _refuse_what_is_not_read(self):
        for name in self.document.get("extensionsRequired", []):
            if name in COMPRESSIONS:
                raise UnreadableFile(
                    f"{self.path}: compressed with {COMPRESSIONS[name]} ({name}), which this add-on does not read; "
                    f"write the sequence without compression, or unpack the files with 'gltf-transform copy'"
                )
            if name not in KNOWN_EXTENSIONS:
                raise UnreadableFile(f"{self.path}: needs {name}, which this add-on does not read")

    def _visible_nodes(self):
        """(node, 4 x 4 matrix) of all nodes of the scene that have a mesh and a size."""
        nodes = self.document.get("nodes", [])
        scenes = self.document.get("scenes", [])
        if scenes:
            roots = scenes[self.document.get("scene", 0)].get("nodes", [])
        else:
            children = {child for node in nodes for child in node.get("children", [])}
            roots = [index for index in range(len(nodes)) if index not in children]
        found, left, seen = [], [(index, np.eye(4)) for index in reversed(roots)], set()
        while left:
            index, parent = left.pop()
            if index in seen:
                raise UnreadableFile(f"{self.path}: node {index} is in the scene twice")
            seen.add(index)
            matrix = parent @ _local_matrix(nodes[index])
            if "mesh" in nodes[index] and np.linalg.det(matrix[:3, :3]) != 0:
                found.append((nodes[index], matrix))
            left += [(child, matrix) for child in reversed(nodes[index].get("children", []))]
        return found

    def _node_parts(self, node, matrix):
        mesh = self.document["meshes"][node["mesh"]]
        name = node.get("name", mesh.get("name", ""))
        for primitive in mesh["primitives"]:
            if any(extension in COMPRESSIONS for extension in primitive.get("extensions", {})):
                self.document = {**self.document, "extensionsRequired": list(primitive["extensions"])}
                self._refuse_what_is_not_read()
            if primitive.get("mode", TRIANGLES) == TRIANGLES and "POSITION" in primitive["attributes"]:
                yield self._part(name, primitive, matrix)

    def _part(self, name, primitive, matrix):
        names = primitive["attributes"]
        turn = matrix[:3, :3]
        is_turned = not np.array_equal(turn, np.eye(3))
        positions = self._numbers(names["POSITION"], 3)
        if is_turned:
            positions = (positions.astype(np.float64) @ turn.T).astype(np.float32)
        normals = None
        if "NORMAL" in names:
            normals = self._numbers(names["NORMAL"], 3)
            if is_turned:
                normals = normals @ np.linalg.inv(turn)
                normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
                normals = normals.astype(np.float32)
        if "indices" in primitive:
            corners = self._values(primitive["indices"])
            if corners.dtype.kind != "u" or corners.shape[1] != 1:
                raise UnreadableFile(f"{self.path}: accessor {primitive['indices']} holds no indices")
            corners = corners[:, 0]
        else:
            corners = np.arange(len(positions))
        triangles = checked_triangles(corners[:len(corners) - len(corners) % 3], len(positions), self.path)
        if np.linalg.det(turn) < 0:
            triangles = np.ascontiguousarray(triangles[:, ::-1])
        attributes = []
        for semantic, accessor in names.items():
            if semantic == "COLOR_0":
                attributes.append(Attribute("Color", self._colors(accessor), True))
            elif semantic.startswith("_"):
                values = self._attribute(accessor)
                kind = kind_of(semantic[1:], values.shape[1], self.kinds)
                attributes.append(Attribute(semantic[1:], values, kind=kind))
        for array in (normals, *(attribute.values for attribute in attributes)):
            if array is not None and len(array) != len(positions):
                raise UnreadableFile(f"{self.path}: '{name}' has values for {len(array)} of {len(positions)} vertices")
        return Surface(positions, triangles, matrix[:3, 3].copy(), normals, part_names=(name,), attributes=attributes)

    def _values(self, index):
        """An accessor's values, as they are stored: a row each."""
        accessor = self.document["accessors"][index]
        if "sparse" in accessor:
            raise UnreadableFile(f"{self.path}: has sparse accessors, which this add-on does not read")
        kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        count = accessor["count"]
        if "bufferView" not in accessor:
            raise UnreadableFile(f"{self.path}: accessor {index} has no data")
        view = self.document["bufferViews"][accessor["bufferView"]]
        if view.get("buffer", 0) != 0 or "uri" in self.document["buffers"][0]:
            raise UnreadableFile(f"{self.path}: has data in another file, which this add-on does not read")
        row = kind.itemsize * width
        stride = view.get("byteStride", row)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        end = start + (stride * (count - 1) + row if count else 0)
        if min(start, count) < 0 or stride < row or end > view.get("byteOffset", 0) + view["byteLength"] \
                or end > len(self.binary):
            raise UnreadableFile(f"{self.path}: accessor {index} reaches beyond the data")
        if not count:
            return np.zeros((0, width), kind)
        return np.ndarray((count, width), kind, self.binary, start, (stride, kind.itemsize))

    def _numbers(self, index, width=None):
        """An accessor's values as float32; whole numbers that stand for fractions become those."""
        values = self._values(index)
        if width is not None and values.shape[1] != width:
            raise UnreadableFile(f"{self.path}: accessor {index} has {values.shape[1]} components, expected {width}")
        result = values.astype(np.float32)
        if self.document["accessors"][index].get("normalized") and values.dtype.kind in "iu":
            result = np.maximum(result / np.float32(np.iinfo(values.dtype).max), np.float32(-1))
        return result

    def _colors(self, index):
        colors = self._numbers(index)
        if colors.shape[1] == 3:
            colors = np.concatenate([colors, np.ones((len(colors), 1), np.float32)], axis=1)
        return colors

    def _attribute(self, index):
        accessor = self.document["accessors"][index]
        if accessor["componentType"] == 5126 or accessor.get("normalized"):
            return self._numbers(index)
        return self._values(index).astype(np.int32)


def _local_matrix(node):
    """A node's own 4 x 4 matrix."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    length = math.sqrt(x * x + y * y + z * z + w * w) or 1
    x, y, z, w = x / length, y / length, z / length, w / length
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def _joined(parts):
    """The parts as one surface. What only some of them carry is 0 in the others; normals need all."""
    if len(parts) == 1:
        return parts[0]
    origin = parts[0].origin
    starts = np.cumsum([0] + [len(part.positions) for part in parts])
    normals = None
    if all(part.normals is not None for part in parts):
        normals = np.concatenate([part.normals for part in parts])
    attributes = []
    for name in dict.fromkeys(attribute.name for part in parts for attribute in part.attributes):
        of_part = [next((a for a in part.attributes if a.name == name), None) for part in parts]
        first = next(attribute for attribute in of_part if attribute)
        width = max(attribute.values.shape[1] for attribute in of_part if attribute)
        values = np.zeros((starts[-1], width), np.result_type(*(a.values for a in of_part if a)))
        for start, attribute in zip(starts, of_part):
            if attribute:
                rows = attribute.values
                values[start:start + len(rows), :rows.shape[1]] = rows
        attributes.append(Attribute(name, values, first.is_color, first.kind if width == 3 else None))
    return Surface(
        np.concatenate([part.positions_from(origin) for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, starts)]).astype(np.int32),
        origin,
        normals,
        parts=np.repeat(np.arange(len(parts), dtype=np.int32), [len(part.triangles) for part in parts]),
        part_names=tuple(name for part in parts for name in part.part_names),
        attributes=attributes,
    )
