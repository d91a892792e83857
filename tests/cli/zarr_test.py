"""Zarr and OME-Zarr: the same mesh as from the NPY with the same samples, placed by the metadata, from few chunks."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from support import PROGRAM, SOURCE, ProgramTest, main, needs_program, read_ply

TOOL = SOURCE / "tests" / "zarr" / "zarrita.mjs"
PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-zarr.so"
ISO = "35"


@unittest.skipUnless(PLUGIN.exists(), "the plug-in for Zarr was not built")
class ZarrTest(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.samples = pathlib.Path(tempfile.mkdtemp(prefix="isoextract-zarr-"))
        cls.addClassCleanup(shutil.rmtree, cls.samples)
        script = SOURCE / "tests" / "zarr" / "write_samples.py"
        subprocess.run(["/usr/bin/python3", "-B", script, cls.samples], check=True)

    def mesh(self, name, *options, iso=ISO, code=0):
        """Bytes of the mesh, without the names in its comments."""
        run = self.run_program(self.samples / name, "--iso", iso, "-o", "out.ply", "--report", "report.json", *options)
        self.assertEqual(run.code, code, f"{name}: {run.err}")
        return (self.folder / "out.ply").read_bytes().partition(b"end_header")[2]

    def report(self):
        return json.loads((self.folder / "report.json").read_text())

    def parts(self):
        """Chunks that were not read, and all of the volume; nothing if all were read."""
        return [(work["count"], work["total"]) for work in self.report()["work"] if work["what"] == "file_parts"]

    def info(self, name, *options):
        return json.loads(self.convert("info", "--json", self.samples / name, *options).text)[0]

    def assert_same_mesh(self, name, other, *options):
        self.assertEqual(self.mesh(name, "--space", "index", *options), self.mesh(other, "--space", "index"), name)

    def test_v2_with_every_compressor_filter_and_order(self):
        expected = self.mesh("field.npy")
        found = sorted(path.name for path in self.samples.glob("v2_*.zarr"))
        self.assertEqual(len(found), 13)
        for name in found:
            self.assertEqual(self.mesh(name), expected, name)

    def test_missing_chunks_have_the_fill_value(self):
        self.assert_same_mesh("missing_chunks.zarr", "missing_chunks.npy")
        self.mesh("missing_chunks.zarr")
        # One layer of 3 x 4 chunks of the three exists.
        self.assertEqual(self.parts(), [(24, 36)])

    def test_v3_with_shards_checksums_and_transposed_chunks(self):
        for name in ("shards_end.zarr", "transposed.zarr"):
            self.assert_same_mesh(name, "field.npy")
        self.assert_same_mesh("shards_start.zarr", "shards_start.npy")

    @needs_program("node")
    def test_v3_that_zarrita_writes(self):
        raw = {"name": "bytes", "configuration": {"endian": "little"}}
        blosc = {"cname": "lz4", "clevel": 5, "shuffle": "shuffle", "typesize": 4, "blocksize": 0}
        chains = {
            "plain": [raw],
            "zstd": [raw, {"name": "zstd", "configuration": {"level": 3, "checksum": True}}],
            "blosc": [raw, {"name": "blosc", "configuration": blosc}],
            "turned": [{"name": "transpose", "configuration": {"order": [1, 2, 0]}}, raw],
        }
        for name, codecs in chains.items():
            job = {"shape": [20, 24, 28], "chunkShape": [7, 8, 9], "dtype": "float32", "codecs": codecs, "fillValue": 0,
                   "dimensionNames": ["z", "y", "x"]}
            (self.folder / "job.json").write_text(json.dumps(job))
            subprocess.run(["node", TOOL, "write", self.folder / f"{name}.zarr", "job.json", self.samples / "field.raw"],
                           cwd=self.folder, check=True)
            self.assert_same_mesh(self.folder / f"{name}.zarr", "field.npy")

    @needs_program("node")
    def test_zarrita_reads_the_arrays_of_write_samples(self):
        for name in ("shards_end.zarr", "transposed.zarr", "ome5/0"):
            subprocess.run(["node", TOOL, "read", self.samples / name, self.folder / "read.raw"], check=True)
            self.assertEqual((self.folder / "read.raw").read_bytes(), (self.samples / "field.raw").read_bytes(), name)

    def test_integers_and_complex_numbers(self):
        run = self.run_program(self.samples / "too_large.zarr", "--iso", "1")
        self.assert_fails(2, run, "chunk '0.0.0'", "2^53", "sample (6, 5, 3)")
        self.assert_same_mesh("complex.zarr", "length.npy", "--component", "length")

    def test_ome_zarr_channels_times_and_levels(self):
        grids = self.info("ome.zarr", "--level", "0")["grids"]
        self.assertEqual([grid["name"] for grid in grids], ["DAPI", "GFP", "RFP", "labels/nuclei"])
        self.assertEqual((grids[1]["times"], grids[1]["time_unit"]), ([0, 0.1], "second"))
        # Channel 1 at time 1 is the field - 30.
        turned = self.mesh("ome.zarr", "--grid", "GFP", "--volume", "1", "--space", "index", iso="5")
        self.assertEqual(turned, self.mesh("field.npy", "--space", "index"))
        self.mesh("ome.zarr", "--grid", "GFP", "--volume", "1", iso="5")
        report = self.report()["input"]
        self.assertEqual((report["format"], report["length_unit"]), ("OME-Zarr 0.4", "micrometer"))
        self.assertEqual(report["index_to_world"], [[0.25, 0, 0, 0], [0, 0.25, 0, 0], [0, 0, 1, 20]])

        self.mesh("ome.zarr", "--grid", "GFP", "--volume", "1", "--level", "1", iso="5")
        report = self.report()["input"]
        self.assertEqual(report["dims"], [14, 12, 20])
        self.assertEqual(report["index_to_world"], [[0.5, 0, 0, 0.125], [0, 0.5, 0, 0.125], [0, 0, 1, 20]])
        run = self.run_program(self.samples / "ome.zarr", "--grid", "GFP", "--level", "7", "--iso", "5")
        self.assert_fails(2, run, "expected a level from 0 to 2, found 7", "1: 2 x 3 x 20 x 12 x 14")

    def test_labels_have_names_and_colors(self):
        found = self.info("ome.zarr", "--grid", "labels/nuclei")["grids"][3]["labels"]
        self.assertEqual(found, [{"label": 1, "name": "left", "color": [1, 0, 0], "layer": None},
                                 {"label": 2, "name": "right", "color": [0, 0.2, 1], "layer": None}])
        meshes = []
        for name, options in (("ome.zarr", ("--grid", "labels/nuclei")), ("labels.npy", ())):
            self.convert(self.samples / name, *options, "--labels", "2", "--space", "index", "-o", "label.stl")
            meshes.append((self.folder / "label.stl").read_bytes()[80:])  # without the colors of the named label
        self.assertEqual(*meshes)

    def test_ome_zarr_05_with_units_in_a_zip_file(self):
        shutil.make_archive(str(self.folder / "five"), "zip", self.samples, "ome5")
        for name in (self.samples / "ome5", self.folder / "five.zip"):
            self.assertEqual(self.mesh(name, "--space", "index"), self.mesh("field.npy", "--space", "index"))
            self.mesh(name)
            report = self.report()["input"]
            self.assertEqual((report["format"], report["length_unit"]), ("OME-Zarr 0.5", "nanometer"))
            self.assertEqual(report["index_to_world"], [[250, 0, 0, 0], [0, 500, 0, 0], [0, 0, 2000, 0]])
        self.assertEqual(self.mesh("group.zarr.zip"), self.mesh("field.npy"))

    def test_coordinates_and_scale_of_xarray(self):
        self.mesh("xarray.zarr", "--volume", "1", iso="20")
        report = self.report()["input"]
        grid = self.info("xarray.zarr", "--volume", "1")["grids"][0]
        self.assertEqual((grid["times"], grid["time_unit"]), ([3, 7], "days since 1950-01-01"))
        self.assertEqual(report["index_to_world"], [[-1, 0, 0, 0], [0, 2, 0, -23], [0, 0, 2.5, 5]])
        # 0.5 (field + 20) + 10 > 37.5 is field > 35.
        self.assertEqual(self.mesh("xarray.zarr", "--volume", "1", "--space", "index", iso="37.5"),
                         self.mesh("field.npy", "--space", "index"))

    def test_a_region_reads_its_chunks_only(self):
        self.mesh("shards_end.zarr", "--roi", "0,0,0,4,4,4")
        # Two samples beyond each face: x to 8, y and z to 6.
        self.assertEqual(self.parts(), [(35, 36)])

    def test_a_sparse_array_of_100000_chunks(self):
        self.mesh("sparse.zarr", "--roi", "396,396,36,412,412,52", iso="100")
        low, high = read_ply((self.folder / "out.ply").read_bytes()).bounds()
        self.assertTrue(399 < low[0] < 401 and 406 < high[0] < 408, (low, high))

    def test_what_cannot_be_read_is_named(self):
        run = self.run_program(self.samples / "unknown_filter.zarr", "--iso", ISO)
        self.assert_fails(2, run, "the codec 'fixedscaleoffset'", "the array ''")

    def test_damaged_metadata_and_chunks(self):
        for name, metadata, chunk in (("v2_zstd.zarr", ".zarray", "0.0.0"), ("shards_end.zarr", "zarr.json", "c/0/0/0")):
            whole = (self.samples / name / metadata).read_bytes()
            for cut in range(0, len(whole) - 1, max(1, len(whole) // 8)):
                self.try_damaged(name, metadata, whole[:cut])
            whole = (self.samples / name / chunk).read_bytes()
            for cut in (0, 1, 7, len(whole) // 2, len(whole) - 1):
                self.try_damaged(name, chunk, whole[:cut])

    def try_damaged(self, name, key, data):
        copy = self.folder / "damaged.zarr"
        shutil.copytree(self.samples / name, copy)
        (copy / key).write_bytes(data)
        self.assert_fails(2, self.run_program(copy, "--iso", ISO), "damaged.zarr: ")
        shutil.rmtree(copy)

    def test_sizes_that_no_file_has(self):
        base = {"zarr_format": 2, "shape": [8, 8, 8], "chunks": [8, 8, 8], "dtype": "<f4", "compressor": None,
                "fill_value": 0, "order": "C", "filters": None}
        copy = self.folder / "hostile.zarr"
        copy.mkdir()
        (copy / "0.0.0").write_bytes(bytes(2048))
        for change in ({"shape": [2**62, 2**62, 2]}, {"chunks": [2**40, 8, 8]}, {"chunks": [0, 8, 8]},
                       {"chunks": [2**20, 2**20, 2**20]}, {"shape": [1.5, 8, 8]}, {"shape": [-1, 8, 8]},
                       {"chunks": [8, 8]}, {"fill_value": "x"}, {"dtype": "|O"}, {"zarr_format": 7},
                       {"compressor": {"id": "zlib"}, "chunks": [1024, 1024, 1024]}, {"shape": []}):
            (copy / ".zarray").write_text(json.dumps({**base, **change}))
            self.assert_fails(2, self.run_program(copy, "--iso", "1"), "hostile.zarr: ")

    def test_deeply_nested_metadata(self):
        copy = self.folder / "deep.zarr"
        copy.mkdir()
        (copy / ".zarray").write_text('{"zarr_format": 2, "shape": ' + 200000 * "[" + 200000 * "]" + "}")
        self.assert_fails(2, self.run_program(copy, "--iso", "1"), "deep.zarr: expected values nested at most 64 deep")

    def test_paths_stay_inside(self):
        copy = self.folder / "escape.zarr"
        copy.mkdir()
        (copy / ".zgroup").write_text('{"zarr_format": 2}')
        for path in ("../ome.zarr/0", "/etc", "a/../../b", "."):
            pyramid = {"version": "0.4", "datasets": [{"path": path}]}
            (copy / ".zattrs").write_text(json.dumps({"multiscales": [pyramid]}))
            self.assert_fails(2, self.run_program(copy, "--iso", "1"), "escape.zarr: ")
        (copy / ".zattrs").unlink()
        os.symlink(".", copy / "again")
        self.assert_fails(2, self.run_program(copy, "--iso", "1"), "escape.zarr: ")


if __name__ == "__main__":
    main()
