"""Writes the Zarr hierarchies that tests/cli/zarr_test.py reads: write_samples.py FOLDER, with Debian's python3.

python3-zarr writes v2. The arrays with shards, gzip and CRC-32C in v3 are written here, by the specification, because
neither python3-zarr nor zarrita writes them; zarrita reads them as a check. All hold the field of field.npy.
"""

import itertools
import json
import os
import pathlib
import struct
import sys

import numcodecs
import numpy as np
import zarr

SHAPE = (20, 24, 28)
folder = pathlib.Path(sys.argv[1])
os.chdir(folder)
z, y, x = np.meshgrid(*(np.arange(n) for n in SHAPE), indexing="ij")
# Rounded, so that it is the same in every type of 16 bits or more.
FIELD = np.round(100 * (np.sin(x / 3) * np.cos(y / 3) + np.sin(y / 3) * np.cos(z / 3) + np.sin(z / 3) * np.cos(x / 3)))
np.save("field.npy", FIELD.astype("f4"))
FIELD.astype("<f4").tofile("field.raw")


def write_v2(name, dtype="<f4", chunks=(7, 8, 9), data=FIELD, **options):
    array = zarr.open(name, mode="w", shape=data.shape, chunks=chunks, dtype=dtype, **options)
    array[...] = data
    return array


def crc32c(data):
    """Bit by bit (RFC 3720)."""
    value = 0xFFFFFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ (0x82F63B78 if value & 1 else 0)
    return struct.pack("<I", value ^ 0xFFFFFFFF)


BYTES = {"name": "bytes", "configuration": {"endian": "little"}}
CRC = {"name": "crc32c"}
GZIP = {"name": "gzip", "configuration": {"level": 5}}


def v3_array(name, chunk, codecs, shape=SHAPE, dtype="float32", **more):
    os.makedirs(name)
    with open(f"{name}/zarr.json", "w", encoding="utf-8") as file:
        json.dump({"zarr_format": 3, "node_type": "array", "shape": shape, "data_type": dtype,
                   "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
                   "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
                   "codecs": codecs, "fill_value": 0, "attributes": {}, **more}, file)


def v3_chunk(name, index, data):
    path = pathlib.Path(name, "c", *map(str, index))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def chunks_of(data, chunk):
    """Index and samples of each chunk, filled up with 0."""
    for index in itertools.product(*(range(-(-n // c)) for n, c in zip(data.shape, chunk))):
        part = np.zeros(chunk, data.dtype)
        found = data[tuple(slice(i * c, (i + 1) * c) for i, c in zip(index, chunk))]
        part[tuple(slice(0, n) for n in found.shape)] = found
        yield index, part


def write_sharded(name, shard, chunk, location, data=FIELD, missing=()):
    """Zarr v3, sharding_indexed 1.0: chunks with gzip, an index with a checksum."""
    settings = {"chunk_shape": chunk, "codecs": [BYTES, GZIP], "index_codecs": [BYTES, CRC], "index_location": location}
    v3_array(name, shard, [{"name": "sharding_indexed", "configuration": settings}], data.shape)
    number = int(np.prod([s // c for s, c in zip(shard, chunk)]))
    gzip = numcodecs.GZip(5)
    for index, samples in chunks_of(data.astype("<f4"), shard):
        offset = 16 * number + 4 if location == "start" else 0
        entries, body = [], b""
        for inner, part in chunks_of(samples, chunk):
            if (index, inner) in missing:
                entries += [2**64 - 1, 2**64 - 1]
                continue
            packed = bytes(gzip.encode(part))
            entries += [offset + len(body), len(packed)]
            body += packed
        table = struct.pack(f"<{len(entries)}Q", *entries)
        table += crc32c(table)
        v3_chunk(name, index, table + body if location == "start" else body + table)


# v2: each compressor, byte order, order of axes and separator.
COMPRESSORS = {"none": None, "blosc": numcodecs.Blosc("lz4", 5, numcodecs.Blosc.SHUFFLE),
               "bitshuffle": numcodecs.Blosc("zstd", 3, numcodecs.Blosc.BITSHUFFLE), "zstd": numcodecs.Zstd(3),
               "zlib": numcodecs.Zlib(5), "gzip": numcodecs.GZip(5), "bz2": numcodecs.BZ2(5), "lz4": numcodecs.LZ4(),
               "lzma": numcodecs.LZMA()}
for name, compressor in COMPRESSORS.items():
    write_v2(f"v2_{name}.zarr", compressor=compressor)
write_v2("v2_big_endian.zarr", ">f4", order="F", dimension_separator="/")
write_v2("v2_delta.zarr", "<i2", filters=[numcodecs.Delta("<i2"), numcodecs.Shuffle(2)], compressor=numcodecs.Zstd(3))
write_v2("v2_int64.zarr", "<i8")
write_v2("v2_half.zarr", "<f2")
write_v2("unknown_filter.zarr", filters=[numcodecs.FixedScaleOffset(0, 1, "<f4")])
large = write_v2("too_large.zarr", "<u8", data=np.zeros(SHAPE, "u8"), compressor=None)
large[3, 5, 6] = 2**53 + 1
partial = zarr.open("missing_chunks.zarr", mode="w", shape=SHAPE, chunks=(7, 8, 9), dtype="f4", fill_value=50)
partial[:7] = FIELD[:7]
values = FIELD.copy()
values[7:] = 50
np.save("missing_chunks.npy", values.astype("f4"))
complex_array = write_v2("complex.zarr", "<c8", data=3 * FIELD + 4j * FIELD)
np.save("length.npy", np.abs(5 * FIELD).astype("f4"))

# v3
write_sharded("shards_end.zarr", (14, 16, 18), (7, 8, 9), "end")
write_sharded("shards_start.zarr", (14, 16, 18), (7, 8, 9), "start", missing={((0, 0, 0), (0, 0, 0))})
values = FIELD.copy()
values[:7, :8, :9] = 0
np.save("shards_start.npy", values.astype("f4"))
v3_array("transposed.zarr", (7, 8, 9), [{"name": "transpose", "configuration": {"order": [2, 0, 1]}},
                                        {"name": "bytes", "configuration": {"endian": "big"}}, GZIP, CRC])
for index, samples in chunks_of(FIELD.astype(">f4"), (7, 8, 9)):
    data = bytes(numcodecs.GZip(5).encode(np.ascontiguousarray(samples.transpose(2, 0, 1))))
    v3_chunk("transposed.zarr", index, data + crc32c(data))

# OME-Zarr 0.4: three channels, two times, three levels, a label image.
AXES = [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"},
        *({"name": name, "type": "space", "unit": "micrometer"} for name in "zyx")]


def datasets(levels):
    return [{"path": str(i), "coordinateTransformations": [
        {"type": "scale", "scale": [1, 1, 0.5, 0.25 * 2**i, 0.25 * 2**i]},
        {"type": "translation", "translation": [0, 0, 10, 0.125 * (2**i - 1), 0.125 * (2**i - 1)]}]}
            for i in range(levels)]


ome = zarr.open_group("ome.zarr", mode="w")
pixels = np.zeros((2, 3, *SHAPE), "i2")
for time, channel in itertools.product(range(2), range(3)):
    pixels[time, channel] = FIELD + 10 * channel - 40 * time
for level in range(3):
    ome.create_dataset(str(level), data=pixels[..., ::2**level, ::2**level], chunks=(1, 1, 7, 8, 9), dimension_separator="/")
ome.attrs["multiscales"] = [{"version": "0.4", "axes": AXES, "datasets": datasets(3),
                             "coordinateTransformations": [{"type": "scale", "scale": [0.1, 1, 2, 1, 1]}]}]
ome.attrs["omero"] = {"channels": [{"label": "DAPI"}, {"label": "GFP"}, {"label": "RFP"}]}
nuclei = ome.create_group("labels").create_group("nuclei")
ome["labels"].attrs["labels"] = ["nuclei"]
labels = np.where(FIELD > 60, np.where(np.arange(SHAPE[2]) < 14, 1, 2), 0)
nuclei.create_dataset("0", data=labels[None, None].astype("u4"), chunks=(1, 1, 7, 8, 9), dimension_separator="/")
nuclei.attrs["multiscales"] = [{"version": "0.4", "axes": AXES, "datasets": datasets(1)}]
nuclei.attrs["image-label"] = {
    "colors": [{"label-value": 1, "rgba": [255, 0, 0, 255]}, {"label-value": 2, "rgba": [0, 51, 255, 255]}],
    "properties": [{"label-value": 1, "name": "left"}, {"label-value": 2, "name": "right"}]}
np.save("labels.npy", labels.astype("u4"))

# OME-Zarr 0.5, in a ZIP file, with other units along z.
os.makedirs("ome5")
write_sharded("ome5/0", (14, 16, 18), (7, 8, 9), "end")
pathlib.Path("ome5/zarr.json").write_text(json.dumps({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {
    "version": "0.5", "multiscales": [{"name": "field", "axes": [
        {"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "nanometer"},
        {"name": "x", "type": "space", "unit": "nanometer"}], "datasets": [{"path": "0", "coordinateTransformations": [
            {"type": "scale", "scale": [2, 500, 250]}]}]}]}}}), encoding="utf-8")

# xarray: coordinates, scale, an uneven time axis; two arrays.
group = zarr.open_group("xarray.zarr", mode="w")
temperature = group.create_dataset("T", data=np.stack([FIELD, FIELD + 20]).astype("i2"), chunks=(1, 7, 8, 9))
temperature.attrs.update(_ARRAY_DIMENSIONS=["time", "z", "y", "x"], scale_factor=0.5, add_offset=10)
for name, coordinates, unit in (("time", [3, 7], "days since 1950-01-01"), ("z", 5 + 2.5 * np.arange(20), "m"),
                                ("y", np.linspace(-23, 23, 24), "m"), ("x", np.arange(28) * -1.0, "m")):
    axis = group.create_dataset(name, data=np.array(coordinates, "f8"))
    axis.attrs.update(_ARRAY_DIMENSIONS=[name], units=unit)
group.create_dataset("names", data=np.array([[b"a", b"b"]]))
zarr.consolidate_metadata("xarray.zarr")

store = zarr.ZipStore("group.zarr.zip", mode="w")
zarr.group(store).create_dataset("A/B", data=FIELD.astype("f4"), chunks=(7, 8, 9))
store.close()

# 100 x 100 x 10 chunks, of which one exists.
sparse = zarr.open("sparse.zarr", mode="w", shape=(80, 800, 800), chunks=(8, 8, 8), dtype="u2", fill_value=0)
sparse[40:48, 400:408, 400:408] = np.arange(512).reshape(8, 8, 8)
