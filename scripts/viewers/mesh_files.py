"""Reads .glb, .gltf, .ply, .obj and .stl with numpy alone: as much of them as isoextract and MeshLab write."""

import json
import struct
import urllib.parse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mesh_facts import Mesh


@dataclass
class Content:
    meshes: list
    has_connectivity: bool  # False: every triangle has corners of its own


def read(path):
    path = Path(path)
    readers = {'.glb': read_glb, '.gltf': read_gltf, '.ply': read_ply, '.obj': read_obj, '.stl': read_stl}
    if path.suffix.lower() not in readers:
        raise ValueError(f'{path}: expected {", ".join(readers)}')
    return readers[path.suffix.lower()](path)


def read_glb(path):
    data = path.read_bytes()
    json_bytes = struct.unpack_from('<I', data, 12)[0]
    binary = data[20 + json_bytes + 8:]
    return gltf_content(json.loads(data[20:20 + json_bytes]), binary)


def read_gltf(path):
    model = json.loads(path.read_text(encoding='utf-8'))
    names = [urllib.parse.unquote(buffer['uri']) for buffer in model.get('buffers', [])]
    return gltf_content(model, path.with_name(names[0]).read_bytes() if names else b'')


def gltf_content(model, binary):
    types = {5123: '<u2', 5125: '<u4', 5126: '<f4'}

    def values(index):
        accessor = model['accessors'][index]
        view = model['bufferViews'][accessor['bufferView']]
        item = np.dtype(types[accessor['componentType']])
        width = {'SCALAR': 1, 'VEC3': 3}[accessor['type']]
        start = view.get('byteOffset', 0) + accessor.get('byteOffset', 0)
        stride = view.get('byteStride', width * item.itemsize)
        return np.ndarray((accessor['count'], width), item, binary, start, (stride, item.itemsize))

    meshes = []
    has_connectivity = True
    for node in (model['nodes'][i] for i in model['scenes'][model['scene']].get('nodes', [])):
        if 'mesh' not in node:
            continue
        primitive = model['meshes'][node['mesh']]['primitives'][0]
        positions = values(primitive['attributes']['POSITION']).astype(np.float64)
        if 'indices' in primitive:
            corners = values(primitive['indices']).astype(np.int64)
        else:
            corners = np.arange(len(positions))
            has_connectivity = False
        meshes.append(Mesh(positions + node.get('translation', [0, 0, 0]), corners.reshape(-1, 3)))
    return Content(meshes, has_connectivity)


def read_ply(path):
    data = path.read_bytes()
    end = data.index(b'end_header\n') + len(b'end_header\n')
    types = {'float': '<f4', 'double': '<f8', 'uchar': 'u1', 'int': '<i4', 'uint': '<u4'}
    elements = []
    ascii_text = False
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == 'format':
            ascii_text = words[1] == 'ascii'
        elif words[0] == 'element':
            elements.append((words[1], int(words[2]), []))
        elif words[0] == 'property' and words[1] == 'list':
            elements[-1][2].extend([('corners', types[words[2]]), ('triangle', types[words[3]], (3,))])
        elif words[0] == 'property':
            elements[-1][2].append((words[2], types[words[1]]))
    tables = {}
    numbers = np.fromstring(data[end:].decode(), sep=' ') if ascii_text else None
    for name, count, fields in elements:
        layout = np.dtype(fields)
        if ascii_text:
            width = sum(field[2][0] if len(field) > 2 else 1 for field in fields)
            table, numbers = np.split(numbers, [count * width])
            table = table.reshape(count, width)
            columns = {'x': table[:, 0], 'y': table[:, 1], 'z': table[:, 2]} if name == 'vertex' else {
                'corners': table[:, 0], 'triangle': table[:, 1:4].astype(np.int64)}
        else:
            columns = np.frombuffer(data, layout, count, end)
            end += count * layout.itemsize
        tables[name] = columns
    if not (tables['face']['corners'] == 3).all():
        raise ValueError(f'{path}: a face is not a triangle')
    vertices = tables['vertex']
    positions = np.stack([vertices[axis] for axis in 'xyz'], axis=1).astype(np.float64)
    return Content([Mesh(positions, tables['face']['triangle'].astype(np.int64))], True)


def read_obj(path):
    meshes = []
    before = 0  # vertices of earlier objects
    vertices, corners = [], []

    def finish():
        nonlocal before
        if vertices:
            triangles = np.array(corners, dtype=np.int64).reshape(-1, 3) - 1 - before
            meshes.append(Mesh(np.array(vertices, dtype=np.float64), triangles))
            before += len(vertices)
            vertices.clear()
            corners.clear()

    for line in path.read_bytes().split(b'\n'):
        if line.startswith(b'o '):
            finish()
        elif line.startswith(b'v '):
            vertices.append([float(word) for word in line.split()[1:]])
        elif line.startswith(b'f '):
            corners.extend(int(word.split(b'/')[0]) for word in line.split()[1:])
    finish()
    return Content(meshes, True)


def read_stl(path):
    data = path.read_bytes()
    if data.startswith(b'solid'):
        words = [line.split()[1:] for line in data.splitlines() if line.strip().startswith(b'vertex')]
        positions = np.array(words, dtype=np.float32).reshape(-1, 3)
    else:
        layout = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('attribute', '<u2')])
        count = struct.unpack_from('<I', data, 80)[0]
        positions = np.frombuffer(data, layout, count, 84)['corners'].reshape(-1, 3)
    return Content([Mesh(positions.astype(np.float64), np.arange(len(positions)).reshape(-1, 3))], False)
