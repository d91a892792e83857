#!/usr/bin/python3
"""Writes small, valid files for the fuzz targets of the plug-ins to start from: make_plugin_seeds.py FOLDER makes
FOLDER/KIND/*. What a format offers (encodings, byte orders, compressions, layouts) appears at least once."""

import bz2
import gzip
import io
import lzma
import pathlib
import struct
import subprocess
import sys
import tarfile
import zipfile

import h5py
import netCDF4
import numpy as np
import segyio
import tifffile
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))

import dicom_files as dicom  # noqa: E402
import vtk_files as vtk  # noqa: E402

RANDOM = np.random.default_rng(33)
VALUES = (RANDOM.random((4, 5, 6)) * 200).astype("f4")  # [z, y, x]


def vtk_seeds(put):
    for code, order in (("i1", "<"), ("i2", ">"), ("f4", "<"), ("u2", "<"), ("f2", ">")):
        put("mrc", code, vtk.mrc(VALUES.astype(code), (1.5, 2, 3), start=(-2, 3, 4), order=order))
    put("mrc", "turned", vtk.mrc(VALUES, axes=(3, 1, 2), angles=(80, 100, 110)))
    put("mrc", "stack", vtk.mrc(VALUES, volumes=2))

    place = "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 0.5 2 3\nAnatomicalOrientation = RAI\n"
    for code in ("|u1", ">i2", "<f4", ">f8", "<i8"):
        put("mha", f"plain_{code[1:]}", vtk.meta_image(VALUES.astype(code), place)[0])
    put("mha", "packed", vtk.meta_image(VALUES, place, compressed=True)[0])
    put("mha", "missing", vtk.meta_image(VALUES, place, local=False)[0])
    put("mha", "list", b"NDims = 4\nDimSize = 6 5 3 2\nElementType = MET_UCHAR\nElementDataFile = LIST\na.raw\nb.raw\n")

    axes = ((0.5, 0, 0), (0.1, 0.25, 0), (0, 0, 1))
    values = RANDOM.random((3, 4, 5, 2))
    put("cube", "density", vtk.cube(values[..., 0], axes, (1, 2, 3)))
    put("cube", "orbitals", vtk.cube(values, axes, (1, 2, 3), -1, (7, 8)))
    put("dem", "heights", vtk.elevation_model(RANDOM.integers(100, 900, (150, 3)), (1000, 2000), (30, 10), 0.5))

    arrays = [("p", "Float32", 1, VALUES), ("v", "Float32", 3, RANDOM.random((*VALUES.shape, 3)).astype("f4"))]
    for encoding in ("ascii", "binary", "appended"):
        put("vti", encoding, vtk.image_data(arrays, (6, 5, 4), 'Spacing="1 2 3"', encoding=encoding))
    put("vti", "packed", vtk.image_data(arrays[:1], (6, 5, 4), encoding="binary", compressor="ZLib"))
    grid = ("DIMENSIONS 6 5 4", "ORIGIN 1 2 3", "SPACING 0.5 1 2")
    put("vtk", "text", vtk.legacy("STRUCTURED_POINTS", grid, VALUES))
    put("vtk", "binary", vtk.legacy("STRUCTURED_POINTS", grid, VALUES, True))


def seismic_seeds(put):
    for kind, dtype in ((1, "f4"), (2, "i4"), (3, "i2"), (5, "f4"), (8, "i1")):
        spec = segyio.spec()
        spec.format, spec.samples, spec.tracecount = kind, np.arange(12) * 2.0, 12
        with segyio.create(str(put.scratch), spec) as file:
            file.bin.update(hdt=2000, hns=12, format=kind, rev=1)
            for n in range(12):
                file.header[n] = {189: 10 + n // 4, 193: 100 + n % 4, 71: -100, 181: 3000 * (n // 4), 185: 4000 * (n % 4), 115: 12, 117: 2000}
                file.trace[n] = (RANDOM.normal(size=12) * 40).astype(dtype)
        put("sgy", f"format{kind}", put.scratch.read_bytes())


def exr(channels, height, width):
    """A file of scan lines without compression: (name, "half" or "float") of each channel."""
    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

    kinds = {"half": (1, "<f2"), "float": (2, "<f4")}
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", kinds[kind][0], 0, 1, 1) for name, kind in channels)
    box = struct.pack("<4i", -2, 3, width - 3, height + 2)
    head = b"".join([
        struct.pack("<II", 20000630, 2), attribute(b"channels", b"chlist", listed + b"\0"),
        attribute(b"compression", b"compression", b"\0"), attribute(b"dataWindow", b"box2i", box),
        attribute(b"displayWindow", b"box2i", box), attribute(b"lineOrder", b"lineOrder", b"\0"),
        attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)), b"\0"])
    lines = []
    for y in range(height):
        data = b"".join(RANDOM.random(width).astype(kinds[kind][1]).tobytes() for _, kind in channels)
        lines.append(struct.pack("<ii", 3 + y, len(data)) + data)
    first = len(head) + 8 * height
    offsets = [first + sum(map(len, lines[:y])) for y in range(height)]
    return head + struct.pack(f"<{height}Q", *offsets) + b"".join(lines)


def image_seeds(put):
    pages = VALUES.astype("u2")
    for name, samples, options in (
            ("plain", pages, {}), ("big", pages, {"bigtiff": True, "byteorder": ">"}),
            ("deflate", pages, {"compression": "zlib", "predictor": True, "rowsperstrip": 2}),
            ("tiles", VALUES, {"tile": (16, 16), "compression": "zlib"}), ("half", VALUES.astype("f2"), {}),
            ("double", VALUES.astype("f8"), {"compression": "lzma"})):
        data = io.BytesIO()
        tifffile.imwrite(data, samples, photometric="minisblack", metadata=None, **options)
        put("tif", name, data.getvalue())
    for name, options in (("imagej", {"imagej": True, "resolution": (2, 4), "metadata": {"axes": "ZYX", "spacing": 3, "unit": "um"}}),
                          ("ome", {"ome": True, "metadata": {"axes": "ZYX", "PhysicalSizeX": 0.5, "PhysicalSizeZ": 2}})):
        data = io.BytesIO()
        tifffile.imwrite(data, pages, **options)
        put("tif", name, data.getvalue())
    rgb = (RANDOM.random((5, 6, 3)) * 255).astype("u1")
    for kind in ("tif", "png"):
        data = io.BytesIO()
        Image.fromarray(rgb).save(data, kind.replace("tif", "tiff"), **({"compression": "tiff_lzw"} if kind == "tif" else {}))
        put(kind, "rgb", data.getvalue())
    for name, samples in (("gray", pages[0]), ("bits", pages[0] > 100), ("bytes", pages[0].astype("u1"))):
        data = io.BytesIO()
        Image.fromarray(samples).save(data, "png")
        put("png", name, data.getvalue())
    put("exr", "one", exr([("Z", "float")], 5, 6))
    put("exr", "two", exr([("A", "half"), ("left.Z", "float")], 5, 6))


def dicom_seeds(put):
    def saved(data):
        dicom.save(data, put.scratch)
        return put.scratch.read_bytes()

    pages = VALUES.astype("i2")
    for syntax in (dicom.ExplicitVRLittleEndian, dicom.pydicom.uid.ImplicitVRLittleEndian, dicom.pydicom.uid.ExplicitVRBigEndian,
                   dicom.pydicom.uid.DeflatedExplicitVRLittleEndian):
        put("dcm", str(syntax), saved(dicom.image(pages[0], (0, 0, 0), slope=2, intercept=-1000, syntax=syntax)))
    places = [(0, 0, 2.5 * k) for k in range(4)]
    put("dcm", "enhanced", saved(dicom.enhanced(pages, places, slopes=[(1, k) for k in range(4)])))
    masks = [VALUES > 50, VALUES > 150]
    for kind in ("BINARY", "FRACTIONAL"):
        put("dcm", kind, saved(dicom.segmentation(masks, ["Liver", "Spleen"], [(255, 0, 0), (0, 255, 0)], kind)))


def hdf5_seeds(put):
    with h5py.File(put.scratch, "w") as file:
        file["plain"] = VALUES
        file.create_dataset("packed", data=VALUES.astype("u2"), chunks=(2, 3, 4), compression="gzip", shuffle=True)
        file["packed"].attrs["element_size_um"] = [2, 0.5, 0.25]
    put("h5", "arrays", put.scratch.read_bytes())
    with h5py.File(put.scratch, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Version"] = [1, 0]
        group.attrs.create("Type", np.bytes_("ImageData"))
        group.attrs["WholeExtent"] = [0, 5, 0, 4, 0, 3]
        group.attrs["Spacing"] = [1.0, 2.0, 3.0]
        group["PointData/p"] = VALUES
    put("h5", "vtk", put.scratch.read_bytes())


def netcdf_seeds(put):
    for kind in ("NETCDF3_CLASSIC", "NETCDF3_64BIT_DATA", "NETCDF4"):
        put.scratch.unlink(missing_ok=True)
        file = netCDF4.Dataset(put.scratch, "w", format=kind)
        for name, length in (("time", None), ("lev", 4), ("lat", 5), ("lon", 6)):
            file.createDimension(name, length)
            axis = file.createVariable(name, "f8", (name,))
            axis[:] = np.arange(length or 2) * 0.5
        file["time"].units, file["lon"].units = "days since 1950-01-01", "degrees_east"
        values = file.createVariable("p", "i2", ("time", "lev", "lat", "lon"), fill_value=-99)
        values.scale_factor, values.add_offset = 0.5, 10.0
        values[:] = np.stack([VALUES, VALUES + 1])
        file.close()
        put("nc", kind, put.scratch.read_bytes())


def archive_seeds(put):
    array = io.BytesIO()
    np.save(array, VALUES)
    array = array.getvalue()
    for name, pack in (("gzip", gzip.compress), ("bzip2", bz2.compress), ("xz", lzma.compress)):
        put("archive", name, pack(array))
    put("archive", "zstd", subprocess.run(["zstd", "-qc"], input=array, stdout=subprocess.PIPE, check=True).stdout)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("a.npy", array)
    put("archive", "zip", packed.getvalue())
    for mode in ("w", "w:gz"):
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode=mode) as file:
            member = tarfile.TarInfo("folder/a.npy")
            member.size = len(array)
            file.addfile(member, io.BytesIO(array))
        put("archive", "tar" + mode[1:].replace(":", "_"), packed.getvalue())


class Put:
    """Writes FOLDER/KIND/NAME. `scratch` is a file for writers that need one."""

    def __init__(self, folder):
        self.folder = folder
        self.scratch = folder / "scratch"

    def __call__(self, kind, name, data):
        (self.folder / kind).mkdir(parents=True, exist_ok=True)
        (self.folder / kind / name).write_bytes(data)


def main():
    put = Put(pathlib.Path(sys.argv[1]))
    put.folder.mkdir(parents=True, exist_ok=True)
    for seeds in (vtk_seeds, seismic_seeds, image_seeds, dicom_seeds, hdf5_seeds, netcdf_seeds, archive_seeds):
        seeds(put)
    put.scratch.unlink(missing_ok=True)


if __name__ == "__main__":
    main()
