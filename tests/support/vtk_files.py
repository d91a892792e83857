"""Files of VTK and of the formats that its plug-in reads, written by hand for tests. They need numpy."""

import itertools
import pathlib
import struct
import zlib

import numpy as np


def values_and_text(values):
    return " ".join(f"{value:.9g}" for value in values.ravel())


def data_array(values, name, kind, components=1, encoding="ascii", words="<I", compress=None, offset=None):
    """A DataArray element, and the bytes that belong into the appended data."""
    start = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format='
    if encoding == "ascii":
        return f'{start}"ascii">{values_and_text(values)}</DataArray>', b""
    raw = values.tobytes()
    if compress:
        size = 100
        blocks = [raw[at:at + size] for at in range(0, len(raw), size)]
        packed = [compress(block) for block in blocks]
        last = len(raw) % size
        header = b"".join(struct.pack(words, n) for n in (len(blocks), size, last, *map(len, packed)))
        parts = [header, b"".join(packed)]
    else:
        parts = [struct.pack(words, len(raw)) + raw]
    if encoding == "binary":
        from base64 import b64encode
        return f'{start}"binary">{"".join(b64encode(part).decode() for part in parts)}</DataArray>', b""
    return f'{start}"appended" offset="{offset}"/>', b"".join(parts)


def image_data(arrays, dims, attributes="", extent=None, cells=(), encoding="ascii", order="LittleEndian", words="<I",
               compressor=None):
    """A .vti file; `arrays` and `cells` are (name, type, components, values)."""
    compress = {None: None, "ZLib": zlib.compress}[compressor]
    appended, elements = b"", {"PointData": "", "CellData": ""}
    for place, listed in (("PointData", arrays), ("CellData", cells)):
        for name, kind, components, values in listed:
            element, more = data_array(values, name, kind, components, encoding, words, compress, len(appended))
            elements[place] += element
            appended += more
    extent = extent or [0, dims[0] - 1, 0, dims[1] - 1, 0, dims[2] - 1]
    whole = " ".join(map(str, extent))
    head = f' header_type="{"UInt64" if words[1] == "Q" else "UInt32"}"'
    if compressor:
        head += f' compressor="vtk{compressor}DataCompressor"'
    text = (f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="{order}"{head}>\n'
            f'<ImageData WholeExtent="{whole}" {attributes}><Piece Extent="{whole}">'
            f'<PointData>{elements["PointData"]}</PointData><CellData>{elements["CellData"]}</CellData></Piece></ImageData>\n')
    if appended:
        return text.encode() + b'<AppendedData encoding="raw">_' + appended + b"</AppendedData></VTKFile>\n"
    return (text + "</VTKFile>\n").encode()


def legacy(kind, grid, values, binary=False, title="by hand"):
    """A legacy file with the point data `p`; `grid` is lines and arrays of the data set."""
    parts = [b"# vtk DataFile Version 3.0", title.encode(), b"BINARY" if binary else b"ASCII", b"DATASET " + kind.encode()]
    for part in (*grid, f"POINT_DATA {values.size}", "SCALARS p float 1", "LOOKUP_TABLE default", values.astype(">f4")):
        if isinstance(part, str):
            parts.append(part.encode())
        else:
            parts.append(part.tobytes() if binary else values_and_text(part).encode())
    return b"\n".join(parts) + b"\n"


def meta_image(values, header, local=True, compressed=False):
    names = {"u1": "UCHAR", "i2": "SHORT", "u2": "USHORT", "f4": "FLOAT", "f8": "DOUBLE", "i8": "LONG_LONG"}
    data = zlib.compress(values.tobytes()) if compressed else values.tobytes()
    dims = " ".join(map(str, values.shape[::-1]))
    text = (f"ObjectType = Image\nNDims = {values.ndim}\nBinaryData = True\nBinaryDataByteOrderMSB = {values.dtype.str[0] == '>'}\n"
            f"CompressedData = {compressed}\n{header}DimSize = {dims}\nElementType = MET_{names[values.dtype.str[1:]]}\n"
            f"ElementDataFile = {'LOCAL' if local else 'image.raw'}\n")
    return text.encode() + (data if local else b""), data


def mrc(values, voxel=(1, 1, 1), angles=(90, 90, 90), axes=(1, 2, 3), start=(0, 0, 0), origin=(0, 0, 0), order="<", volumes=1):
    modes = {"i1": 0, "i2": 1, "f4": 2, "u2": 6, "f2": 12}
    nx, ny, nz = values.shape[::-1]
    steps = [0, 0, 0]
    for size, axis in zip((nx, ny, nz // volumes), axes):
        steps[axis - 1] = size
    cell = [n * size for n, size in zip(steps, voxel)]
    head = struct.pack(order + "10i6f3i3f2i", nx, ny, nz, modes[values.dtype.str[1:]], *start, *steps, *cell, *angles, *axes,
                       0, 0, 0, 401 if volumes > 1 else 1, 0)
    head = head.ljust(196, b"\0") + struct.pack(order + "3f", *origin) + b"MAP " + (b"DD\0\0" if order == "<" else b"\x11\x11\0\0")
    return head.ljust(1024, b"\0") + values.astype(values.dtype.newbyteorder(order)).tobytes()


def cube(values, axes, origin, sign=1, orbitals=()):
    """`values` is [x, y, z, orbital]."""
    lines = ["by hand", "density", f"{-1 if orbitals else 1} {' '.join(map(str, origin))}"]
    lines += [f"{sign * count} {' '.join(map(str, axis))}" for count, axis in zip(values.shape, axes)]
    lines.append("6 6.0 0 0 0")
    if orbitals:
        lines.append(" ".join(map(str, (len(orbitals), *orbitals))))
    lines += [" ".join(f"{value:.5E}" for value in row.ravel()) for row in values.reshape(-1, *values.shape[2:])]
    return ("\n".join(lines) + "\n").encode()


TETRAHEDRA = ((0, 1, 3, 7), (0, 1, 5, 7), (0, 4, 5, 7), (0, 4, 6, 7), (0, 2, 6, 7), (0, 2, 3, 7))


def tetrahedra(count):
    """Points, cells (point numbers) of a cube of count^3 cells, each cut into six tetrahedra."""
    points = [(x, y, z) for z in range(count + 1) for y in range(count + 1) for x in range(count + 1)]
    cells = []
    for z, y, x in itertools.product(range(count), repeat=3):
        corners = [((z + (c >> 2)) * (count + 1) + y + (c >> 1 & 1)) * (count + 1) + x + (c & 1) for c in range(8)]
        cells += [[corners[c] for c in cell] for cell in TETRAHEDRA]
    return np.array(points, float), np.array(cells)


def unstructured(points, cells, point_values, cell_values):
    counts = f'NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}"'
    offsets = np.arange(1, len(cells) + 1) * 4

    def array(kind, name, values, components=1):
        return data_array(np.asarray(values), name, kind, components)[0]

    return (f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">\n<UnstructuredGrid>'
            f'<Piece {counts}><PointData>{array("Float64", "p", point_values)}</PointData>'
            f'<CellData>{array("Float64", "p", cell_values)}</CellData><Points>{array("Float32", "points", points, 3)}</Points>'
            f'<Cells>{array("Int64", "connectivity", cells)}{array("Int64", "offsets", offsets)}'
            f'{array("UInt8", "types", np.full(len(cells), 10))}</Cells></Piece></UnstructuredGrid></VTKFile>\n').encode()


def open_foam_case(folder, count, times):
    """A case with a cube of count^3 cells of size 1 and the scalar `p` of cells, 2x + y - z + time at their centers."""

    def point(x, y, z):
        return (z * (count + 1) + y) * (count + 1) + x

    def face(axis, x, y, z):
        a, b = [(0, 1, 0), (0, 0, 1), (1, 0, 0)][axis], [(0, 0, 1), (1, 0, 0), (0, 1, 0)][axis]
        corners = ((0, 0, 0), a, tuple(i + j for i, j in zip(a, b)), b)
        return [point(x + i, y + j, z + k) for i, j, k in corners]

    inner, outer = [], []
    cells = list(itertools.product(range(count), repeat=3))
    for cell, (z, y, x) in enumerate(cells):
        for axis, stride in enumerate((1, count, count * count)):
            at = [x, y, z]
            if at[axis] == 0:
                outer.append((cell, face(axis, *at)[::-1]))
            at[axis] += 1
            if at[axis] == count:
                outer.append((cell, face(axis, *at)))
            else:
                inner.append((cell, face(axis, *at), cell + stride))
    faces = inner + outer

    def put(path, kind, text):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        head = f"FoamFile {{ version 2.0; format ascii; class {kind}; object {pathlib.Path(path).name}; }}\n"
        (folder / path).write_text(head + text)

    def listed(lines):
        return "\n".join([str(len(lines)), "(", *lines, ")", ""])

    corners = [(x, y, z) for z in range(count + 1) for y in range(count + 1) for x in range(count + 1)]
    put("constant/polyMesh/points", "vectorField", listed([f"({x} {y} {z})" for x, y, z in corners]))
    put("constant/polyMesh/faces", "faceList", listed([f"4({' '.join(map(str, each[1]))})" for each in faces]))
    put("constant/polyMesh/owner", "labelList", listed([str(each[0]) for each in faces]))
    put("constant/polyMesh/neighbour", "labelList", listed([str(each[2]) for each in inner]))
    walls = f"1\n(\nwalls {{ type wall; nFaces {len(outer)}; startFace {len(inner)}; }}\n)\n"
    put("constant/polyMesh/boundary", "polyBoundaryMesh", walls)
    put("system/controlDict", "dictionary", "startTime 0; endTime 1; deltaT 0.5; writeControl timeStep; writeInterval 1;\n")
    for time in times:
        values = listed([str(2 * x + y - z + 1 + float(time)) for z, y, x in cells])
        put(f"{time}/p", "volScalarField", f"dimensions [0 2 -2 0 0 0 0];\ninternalField nonuniform List<scalar>\n{values};\n"
            "boundaryField { walls { type zeroGradient; } }\n")


def elevation_model(heights, corner, step, resolution):
    """A USGS DEM of [y, x] whole heights; its records have fixed columns."""

    def number(value):
        return f"{value:24.15E}".replace("E", "D")

    rows, columns = heights.shape
    head = "by hand".ljust(144) + "".join(f"{n:6}" for n in (1, 1, 1, 13)) + number(0) * 15 + "".join(f"{n:6}" for n in (2, 2, 4))
    head += number(0) * 8 + number(heights.min()) + number(heights.max()) + number(0) + f"{0:6}"
    head += "".join(f"{value:12.6E}" for value in (*step, resolution)) + f"{1:6}{columns:6}"
    records = [head]
    for column in range(columns):
        start = f"{1:6}{column + 1:6}{rows:6}{1:6}{number(corner[0] + column * step[0])}{number(corner[1])}" + number(0) * 3
        numbers = [f"{height:6}" for height in heights[:, column]]
        records.append(start + "".join(numbers[:146]))
        records += ["".join(numbers[at:at + 170]) for at in range(146, rows, 170)]
    return "".join(record.ljust(1024) for record in records).encode()


def linear(x, y, z):
    return 2 * x - 3 * y + 0.5 * z + 1
