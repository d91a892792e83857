"""Volumes that the plug-in around VTK reads: files of other writers, their values and placement, and damaged ones."""

import json
import math
import os
import pathlib
import subprocess
import unittest

from support import DATA, PROGRAM, ProgramTest, main, needs_data, needs_modules, read_ply
from mutations import mutate

needs_modules("numpy")
import numpy as np  # noqa: E402 - where there is one
from vtk_files import (  # noqa: E402
    cube, elevation_model, image_data, legacy, linear, meta_image, mrc, open_foam_case, tetrahedra, unstructured)

PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-vtk.so"
SEEDS = int(os.environ.get("ISOEXTRACT_MUTATIONS", "24"))  # of each kind of file


@unittest.skipUnless(PLUGIN.exists(), "the plug-in of VTK for volumes was not built")
class VtkVolumesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.random = np.random.default_rng(1)

    def write(self, name, data):
        (self.folder / name).write_bytes(data)
        return name

    def field(self, name, *options):
        """The samples [z, y, x] and the placement; self.input is what the report says of the input."""
        for path in ("field.npy", "field.json"):
            (self.folder / path).unlink(missing_ok=True)
        self.convert(name, *options, "-o", "field.npy", "--report", "field.json")
        self.input = json.loads((self.folder / "field.json").read_text())["input"]
        return np.load(self.folder / "field.npy"), np.array(self.input["index_to_world"])

    def grids(self, name):
        return json.loads(self.convert("info", "--json", name).out)[0]["grids"]

    def test_image_data_in_every_encoding(self):
        dims = (7, 5, 4)
        turn = [[math.cos(0.3), -math.sin(0.3), 0], [math.sin(0.3), math.cos(0.3), 0], [0, 0, 1]]
        attributes = (f'Origin="10 -20 30" Spacing="0.5 1.25 2" '
                      f'Direction="{" ".join(str(v) for row in turn for v in row)}"')
        extent = [-3, 3, 5, 9, 2, 5]
        placed = np.array(turn) * [0.5, 1.25, 2]
        for encoding, order, words, compressor, kind in (
                ("ascii", "<", "I", None, "Float32"), ("binary", "<", "I", None, "Int16"), ("binary", ">", "Q", "ZLib", "Float64"),
                ("appended", "<", "Q", None, "UInt8"), ("appended", ">", "I", None, "Float32"), ("appended", "<", "I", "ZLib", "UInt16")):
            code = {"Float32": "f4", "Int16": "i2", "Float64": "f8", "UInt8": "u1", "UInt16": "u2"}[kind]
            values = (self.random.random(dims[::-1]) * 200).astype(order + code)
            vectors = self.random.random((*dims[::-1], 3)).astype(order + "f4")
            cells = self.random.integers(-99, 99, [n - 1 for n in dims[::-1]]).astype(order + "i4")
            data = image_data([("p", kind, 1, values), ("v", "Float32", 3, vectors)], dims, attributes, extent,
                              [("p", "Int32", 1, cells)], encoding, {"<": "LittleEndian", ">": "BigEndian"}[order], order + words,
                              compressor)
            with self.subTest(encoding=encoding, order=order, words=words, compressor=compressor, kind=kind):
                name = self.write("image.vti", data)
                found, placement = self.field(name, "--array", "p")
                np.testing.assert_array_equal(found, values)
                np.testing.assert_allclose(placement[:, :3], placed, atol=1e-12)
                np.testing.assert_allclose(placement[:, 3], [10, -20, 30] + placed @ [-3, 5, 2], atol=1e-12)
                # A sample of cells is at the center of its cell.
                found, placement = self.field(name, "--array", "cell:p")
                np.testing.assert_array_equal(found, cells)
                np.testing.assert_allclose(placement[:, 3], [10, -20, 30] + placed @ [-2.5, 5.5, 2.5], atol=1e-12)
                found, _ = self.field(name, "--array", "v", "--component", "1")
                np.testing.assert_array_equal(found, vectors[..., 1])
        found, _ = self.field(name, "--array", "v", "--component", "length")
        np.testing.assert_allclose(found, np.linalg.norm(vectors.astype(float), axis=-1), rtol=1e-6)
        self.assertEqual([grid["type"] for grid in self.grids(name)], ["UInt16 of points", "Float32 of points", "Int32 of cells"])

    def test_pieces_of_image_data(self):
        values = self.random.random((4, 5, 7)).astype("<f4")
        for part, (first, last) in enumerate(((0, 3), (3, 6))):
            extent = [first, last, 0, 4, 0, 3]
            self.write(f"part{part}.vti", image_data([("p", "Float32", 1, values[:, :, first:last + 1])], (4, 5, 4), "", extent))
        pieces = "".join(f'<Piece Extent="{a} {b} 0 4 0 3" Source="part{i}.vti"/>' for i, (a, b) in enumerate(((0, 3), (3, 6))))
        whole = ('<?xml version="1.0"?><VTKFile type="PImageData" version="1.0" byte_order="LittleEndian">'
                 '<PImageData WholeExtent="0 6 0 4 0 3" GhostLevel="0" Origin="1 2 3" Spacing="1 1 2">'
                 f'<PPointData><PDataArray type="Float32" Name="p"/></PPointData>{pieces}</PImageData></VTKFile>')
        self.write("whole.pvti", whole.encode())
        found, placement = self.field("whole.pvti")
        np.testing.assert_array_equal(found, values)
        np.testing.assert_allclose(placement[:, 3], [1, 2, 3])
        self.write("whole.pvti", whole.replace('<Piece Extent="3 6 0 4 0 3" Source="part1.vti"/>', "").encode())
        self.assert_fails(2, self.run_program("whole.pvti", "-o", "a.npy"), "pieces that cover the whole extent")

    def test_legacy_structured_points(self):
        values = self.random.random((4, 5, 6)).astype("f4")
        for binary in (False, True):
            # The content decides: .vtk files may also have particles.
            grid = ("DIMENSIONS 6 5 4", "ORIGIN 1 2 3", "SPACING 0.5 1 2")
            self.write("points.vtk", legacy("STRUCTURED_POINTS", grid, values, binary))
            found, placement = self.field("points.vtk")
            np.testing.assert_allclose(found, values, rtol=1e-6)
            np.testing.assert_allclose(placement, [[0.5, 0, 0, 1], [0, 1, 0, 2], [0, 0, 2, 3]])

    def test_rectilinear_grids(self):
        values = self.random.random((6, 4, 5)).astype("f4")

        def write(z):
            grid = ["DIMENSIONS 5 4 6"]
            for axis, coordinates in (("X", np.arange(5) * 0.1 + 3), ("Y", np.arange(4) * 2.0), ("Z", np.array(z, float))):
                grid += [f"{axis}_COORDINATES {coordinates.size} float", coordinates.astype(">f4")]
            self.write("grid.vtk", legacy("RECTILINEAR_GRID", grid, values))

        write([0, 0.5, 1, 1.5, 2, 2.5])
        found, placement = self.field("grid.vtk")
        np.testing.assert_allclose(found, values, rtol=1e-6)
        np.testing.assert_allclose(placement, [[0.1, 0, 0, 3], [0, 2, 0, 0], [0, 0, 0.5, 0]], atol=1e-6)
        z = [0, 1, 2, 4, 8, 9]
        write(z)
        run = self.run_program("grid.vtk", "-o", "a.npy")
        self.assert_fails(2, run, "evenly spaced samples, found distances from 1 to 4 along z", "--resample")
        found, placement = self.field("grid.vtk", "--resample")
        expected = [[[np.interp(k, z, values[:, j, i]) for i in range(5)] for j in range(4)] for k in range(10)]
        np.testing.assert_allclose(found, expected, atol=1e-5)

    def test_rectilinear_grids_of_floats_and_doubles(self):
        """Each axis is even within the rounding of its own type: 32-bit floats near 1e6 are 1/16 apart."""
        values = self.random.random((6, 4, 5)).astype("f4")
        grid = ["DIMENSIONS 5 4 6"]
        for axis, name, kind, coordinates in (("X", "double", ">f8", np.arange(5) * 0.1), ("Y", "float", ">f4", np.arange(4.0)),
                                              ("Z", "float", ">f4", 1e6 + np.arange(6) * 0.2)):
            grid += [f"{axis}_COORDINATES {coordinates.size} {name}", coordinates.astype(kind)]
        self.write("grid.vtk", legacy("RECTILINEAR_GRID", grid, values))
        found, placement = self.field("grid.vtk")
        np.testing.assert_allclose(found, values, rtol=1e-6)
        np.testing.assert_allclose(placement[2], [0, 0, 0.2, 1e6], atol=0.02)

    def test_cells_are_resampled(self):
        points, cells = tetrahedra(4)
        values = linear(*points.T)
        centers = points[cells].mean(axis=1)
        self.write("cells.vtu", unstructured(points, cells, values, linear(*centers.T)))
        found, placement = self.field("cells.vtu", "--array", "p", "--voxel-size", "0.5")
        self.assertEqual(found.shape, (9, 9, 9))
        z, y, x = np.indices(found.shape)
        np.testing.assert_allclose(placement, np.hstack([np.eye(3) / 2, np.zeros((3, 1))]), atol=1e-12)
        np.testing.assert_allclose(found, linear(x / 2, y / 2, z / 2), atol=1e-6)
        run = self.convert("cells.vtu", "--array", "cell:p", "--iso", "1", "-o", "cells.ply")
        self.assertIn("resamples 384 cells, which do not lie on a lattice, onto", run.err)
        self.assertIn("the value of a point is the mean of its cells' values", run.err)
        # Legacy files of cells are volumes; the type of the first cell tells them from particles.
        listed = np.insert(cells, 0, 4, axis=1).astype(">i4")
        grid = (f"POINTS {len(points)} float", points.astype(">f4"), f"CELLS {len(cells)} {listed.size}", listed,
                f"CELL_TYPES {len(cells)}", np.full(len(cells), 10, ">i4"))
        for binary in (False, True):
            self.write("cells.vtk", legacy("UNSTRUCTURED_GRID", grid, values, binary))
            found, _ = self.field("cells.vtk", "--voxel-size", "0.5")
            np.testing.assert_allclose(found, linear(x / 2, y / 2, z / 2), atol=1e-4)
        # Without the cells of the lower half, its samples are NaN.
        upper = cells[centers[:, 2] > 2]
        self.write("half.vtu", unstructured(points, upper, values, np.zeros(len(upper))))
        found, placement = self.field("half.vtu", "--array", "p", "--voxel-size", "0.5")
        self.assertEqual(found.shape, (5, 9, 9))
        self.assertAlmostEqual(placement[2, 3], 2)

    def test_curved_grid(self):
        r, angle, height = np.meshgrid(np.linspace(1, 2, 9), np.linspace(0, 2, 12), np.linspace(0, 1, 6), indexing="ij")
        points = np.stack([r * np.cos(angle), r * np.sin(angle), height], axis=-1).transpose(2, 1, 0, 3)
        values = linear(*np.moveaxis(points, -1, 0))
        grid = ("DIMENSIONS 9 12 6", f"POINTS {values.size} float", points.astype(">f4"))
        self.write("curved.vtk", legacy("STRUCTURED_GRID", grid, values, binary=True))
        run = self.run_program("curved.vtk", "--iso", "1", "-o", "curved.ply")
        self.assert_fails(2, run, "NaN", "--nan")
        found, placement = self.field("curved.vtk", "--nan", "outside", "--voxel-size", "0.1")
        z, y, x = np.indices(found.shape)
        places = placement[:, :3] @ np.stack([x.ravel(), y.ravel(), z.ravel()]) + placement[:, 3:]
        radius, turned = np.hypot(*places[:2]), np.arctan2(places[1], places[0])
        within = (radius > 1.02) & (radius < 1.98) & (turned > 0.02) & (turned < 1.98)
        np.testing.assert_allclose(found.ravel()[within], linear(*places)[within], atol=0.02)
        outside = (radius < 0.98) | (radius > 2.02)
        self.assertTrue(np.isnan(found.ravel()[outside]).all())

    def test_time_steps_may_have_different_boxes(self):
        steps = [self.random.random((3, 4, 5 + step)).astype("<f4") for step in range(3)]
        for step, values in enumerate(steps):
            self.write(f"step{step}.vti", image_data([("p", "Float32", 1, values)], values.shape[::-1], f'Origin="{step} 0 0"'))
        sets = "".join(f'<DataSet timestep="{step / 2}" part="0" file="step{step}.vti"/>' for step in range(3))
        self.write("steps.pvd", f'<VTKFile type="Collection" version="0.1"><Collection>{sets}</Collection></VTKFile>'.encode())
        files = [{"name": f"step{step}.vti", "time": step / 2} for step in range(3)]
        self.write("steps.vti.series", json.dumps({"file-series-version": "1.0", "files": files}).encode())
        for name in ("steps.pvd", "steps.vti.series"):
            for step, values in enumerate(steps):
                found, placement = self.field(name, "--volume", step)
                np.testing.assert_array_equal(found, values)
                self.assertEqual(placement[0, 3], step)
            self.assertEqual(self.grids(name)[0]["times"], [0, 0.5, 1])

    def test_meta_images(self):
        matrix = [0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6]
        header = (f"TransformMatrix = {' '.join(map(str, matrix))}\nOffset = 1 2 3\nAnatomicalOrientation = RAI\n"
                  "ElementSpacing = 0.5 2 3\n")
        for code, local, compressed in (("|u1", True, True), (">i2", False, False), ("<f4", True, False), (">f8", False, True),
                                        ("<i8", True, False)):
            with self.subTest(code=code, local=local, compressed=compressed):
                values = (self.random.random((4, 5, 6)) * 200).astype(code)
                text, data = meta_image(values, header, local, compressed)
                self.write("image.mhd", text)
                self.write("image.raw", data)
                found, placement = self.field("image.mhd")
                np.testing.assert_array_equal(found, values)
                for axis, spacing in enumerate((0.5, 2, 3)):
                    np.testing.assert_allclose(placement[:, axis], spacing * np.array(matrix[3 * axis:3 * axis + 3]), atol=1e-12)
                np.testing.assert_allclose(placement[:, 3], [1, 2, 3])
                self.assertEqual(self.input["world_space"], "left-posterior-superior")
                self.assertEqual(self.input["length_unit"], "mm")
        # No other folder's file.
        self.write("image.mhd", text.replace(b"LOCAL", b"../image.raw"))
        self.assert_fails(2, self.run_program("image.mhd", "-o", "a.npy"), "the same folder or below it, found ../image.raw")

    def test_meta_images_in_slices_and_time_steps(self):
        values = self.random.integers(0, 200, (2, 3, 5, 6)).astype("u1")
        for index in range(6):
            self.write(f"slice{index + 1:03}.raw", values.reshape(6, 5, 6)[index].tobytes())
        text = "NDims = 4\nDimSize = 6 5 3 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 2 0.5\nElementDataFile = "
        names = "".join(f"\nslice{index + 1:03}.raw" for index in range(6))
        for files in ("slice%03d.raw 1 6 1\n", f"LIST{names}\n"):
            self.write("image.mhd", (text + files).encode())
            for volume in (0, 1):
                found, placement = self.field("image.mhd", "--volume", volume)
                np.testing.assert_array_equal(found, values[volume])
            self.assertEqual(self.grids("image.mhd")[0]["times"], [0, 0.5])

    def test_mrc_maps(self):
        shape = (4, 5, 6)
        for code, order in (("i1", "<"), ("i2", ">"), ("f4", "<"), ("u2", "<"), ("f2", ">")):
            values = (self.random.random(shape) * 100).astype(code)
            self.write("map.mrc", mrc(values, (1.5, 2, 3), start=(-2, 3, 4), order=order))
            found, placement = self.field("map.mrc")
            np.testing.assert_array_equal(found, values)
            np.testing.assert_allclose(placement, [[1.5, 0, 0, -3], [0, 2, 0, 6], [0, 0, 3, 12]])
        self.assertEqual(self.input["length_unit"], "angstrom")
        # Columns along z, rows along x, sections along y; start indices are of columns, rows and sections.
        self.write("map.mrc", mrc(values, (1.5, 2, 3), axes=(3, 1, 2), start=(-2, 3, 4)))
        _, placement = self.field("map.mrc")
        np.testing.assert_allclose(placement, [[0, 1.5, 0, 4.5], [0, 0, 2, 8], [3, 0, 0, -6]])
        # An origin counts, not the start indices.
        self.write("map.mrc", mrc(values, origin=(7, 8, 9), start=(1, 1, 1)))
        _, placement = self.field("map.mrc")
        np.testing.assert_allclose(placement[:, 3], [7, 8, 9])
        # A skewed cell: Rupp, Biomolecular Crystallography, 2010, the orthogonalization matrix.
        alpha, beta, gamma = np.radians([80, 100, 110])
        self.write("map.mrc", mrc(values, (1.5, 2, 3), angles=(80, 100, 110)))
        _, placement = self.field("map.mrc")
        volume = math.sqrt(1 - sum(math.cos(a) ** 2 for a in (alpha, beta, gamma)) +
                           2 * math.cos(alpha) * math.cos(beta) * math.cos(gamma))
        expected = [[1.5, 2 * math.cos(gamma), 3 * math.cos(beta)],
                    [0, 2 * math.sin(gamma), 3 * (math.cos(alpha) - math.cos(beta) * math.cos(gamma)) / math.sin(gamma)],
                    [0, 0, 3 * volume / math.sin(gamma)]]
        np.testing.assert_allclose(placement[:, :3], expected, atol=1e-9)
        stack = self.random.random((6, 5, 4)).astype("f4")
        self.write("map.mrc", mrc(stack, volumes=2))
        for index in (0, 1):
            found, _ = self.field("map.mrc", "--volume", index)
            np.testing.assert_array_equal(found, stack[3 * index:3 * index + 3])
        self.write("map.mrc", mrc(stack)[:-1])
        self.assert_fails(2, self.run_program("map.mrc", "-o", "a.npy"), "expected 4 x 5 x 6 x 1 numbers of 4 bytes, found 479")

    def test_open_foam_case(self):
        open_foam_case(self.folder / "case", 4, ("0", "0.5"))
        self.write("case/case.foam", b"for ParaView\n")
        for name in ("case", "case/case.foam"):
            for volume, time in enumerate((0, 0.5)):
                found, placement = self.field(name, "--volume", volume, "--voxel-size", "0.5")
                np.testing.assert_allclose(placement, np.hstack([np.eye(3) / 2, np.zeros((3, 1))]), atol=1e-9)
                z, y, x = np.indices(found.shape) / 2
                # Points at the walls have fewer cells around them.
                within = (slice(2, 7),) * 3
                np.testing.assert_allclose(found[within], (2 * x + y - z + time)[within], atol=1e-5)
        self.assertEqual([(grid["name"], grid["times"]) for grid in self.grids("case")], [("p", [0, 0.5])])

    def test_finer_amr_levels_count(self):
        coarse = np.zeros((4, 4, 4), "<f4")
        fine = np.full((4, 4, 4), 5, "<f4")
        for name, values, origin, spacing in (("coarse", coarse, 0, 1), ("fine", fine, 1, 0.5)):
            (self.folder / "levels").mkdir(exist_ok=True)
            attributes = f'Origin="{origin} {origin} {origin}" Spacing="{spacing} {spacing} {spacing}"'
            self.write(f"levels/{name}.vti", image_data([], (5, 5, 5), attributes, cells=[("q", "Float32", 1, values)]))
        self.write("levels.vth", b'<VTKFile type="vtkOverlappingAMR" version="1.1" byte_order="LittleEndian">'
                   b'<vtkOverlappingAMR origin="0 0 0" grid_description="XYZ"><Block level="0" spacing="1 1 1">'
                   b'<DataSet index="0" amr_box="0 3 0 3 0 3" file="levels/coarse.vti"/></Block><Block level="1" spacing="0.5 0.5 0.5">'
                   b'<DataSet index="0" amr_box="2 5 2 5 2 5" file="levels/fine.vti"/></Block></vtkOverlappingAMR></VTKFile>')
        found, placement = self.field("levels.vth", "--voxel-size", "0.5")
        self.assertEqual(found.shape, (9, 9, 9))
        np.testing.assert_allclose(placement[:, :3], np.eye(3) / 2)
        self.assertTrue((found[2:7, 2:7, 2:7] == 5).all())
        self.assertTrue((found[0] == 0).all())

    def test_elevation_models(self):
        heights = self.random.integers(100, 900, (150, 3))
        heights[149, 1] = -32767
        self.write("heights.dem", elevation_model(heights, (1000, 2000), (30, 10), 0.5))
        found, placement = self.field("heights.dem")
        np.testing.assert_allclose(found.reshape(heights.shape), np.where(heights > 0, heights * 0.5, np.nan))
        np.testing.assert_allclose(placement, [[30, 0, 0, 1000], [0, 10, 0, 2000], [0, 0, 1, 0]])
        self.assertEqual(self.input["length_unit"], "m")

    def test_gaussian_cubes(self):
        axes = ((0.5, 0, 0), (0.1, 0.25, 0), (0, 0, 1))
        values = self.random.random((3, 4, 5, 2))
        self.write("density.cube", cube(values[..., 0], axes, (1, 2, 3)))
        found, placement = self.field("density.cube")
        np.testing.assert_allclose(found, values[..., 0].transpose(2, 1, 0), rtol=1e-4)
        np.testing.assert_allclose(placement, [[0.5, 0.1, 0, 1], [0, 0.25, 0, 2], [0, 0, 1, 3]])
        self.assertEqual(self.input["length_unit"], "bohr")
        self.write("orbitals.cube", cube(values, axes, (1, 2, 3), -1, (7, 8)))
        for index in (0, 1):
            found, _ = self.field("orbitals.cube", "--volume", index)
            np.testing.assert_allclose(found, values[..., index].transpose(2, 1, 0), rtol=1e-4)
        self.assertEqual(self.input["length_unit"], "angstrom")

    def test_real_files_have_the_known_surfaces(self):
        expected = json.loads((DATA / "EXPECTED.json").read_text())
        for name, iso, known, options in (
                ("sim/hydrogen.vti", 0.1, "sim/hydrogen.vti", ()), ("sim/vase_1comp.vti", 60, "sim/vase_1comp.vti", ()),
                ("sim/vase_4comp.vti", 60, "sim/vase_1comp.vti", ("--component", "0")), ("mol/betaGal.mrc", 0.05, "mol/betaGal.npy", ())):
            with self.subTest(name=name):
                self.convert(DATA / name, "--iso", iso, *options, "--space", "index", "-o", f"{pathlib.Path(name).stem}.ply")
                mesh = read_ply((self.folder / f"{pathlib.Path(name).stem}.ply").read_bytes())
                corners = np.array(mesh.vertices)[np.array(mesh.triangles)]
                crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                area = np.linalg.norm(crosses, axis=1).sum() / 2
                self.assertLess(abs(area / expected[known]["area"] - 1), 0.005)
                bounds = [*corners.min(axis=(0, 1)), *corners.max(axis=(0, 1))]
                np.testing.assert_allclose(bounds, expected[known]["bounds"], atol=0.02)

    test_real_files_have_the_known_surfaces = needs_data("EXPECTED.json")(test_real_files_have_the_known_surfaces)

    def test_same_meshes_as_other_readers(self):
        pairs = ((DATA / "mol/betaGal.mrc", DATA / "mol/betaGal.npy", 0.05, ("--space", "index"), ()),
                 (DATA / "med/HeadMRVolume.mhd", DATA / "med/HeadMRVolume.raw", 60, (),
                  ("--dims", "48,62,42", "--dtype", "u8", "--spacing", "4,4,4")))
        for index, (name, other, iso, options, more) in enumerate(pairs):
            self.convert(name, "--iso", iso, *options, "-o", f"{index}.ply")
            self.convert(other, "--iso", iso, *options, *more, "-o", f"{index}_other.ply")
            self.assertEqual((self.folder / f"{index}.ply").read_bytes(), (self.folder / f"{index}_other.ply").read_bytes())
        _, placement = self.field(DATA / "mol/m4_TotalDensity.cube")
        _, expected = self.field(DATA / "mol/m4_TotalDensity.nrrd")
        np.testing.assert_allclose(placement, expected, atol=1e-12)

    test_same_meshes_as_other_readers = needs_data("mol/betaGal.mrc")(test_same_meshes_as_other_readers)

    def test_the_program_itself_is_not_linked_with_it(self):
        linked = subprocess.run(["ldd", PROGRAM], check=True, capture_output=True, text=True).stdout
        self.assertIn("libtbb", linked)
        self.assertNotIn("vtk", linked)

    def samples_of_formats(self):
        values = (self.random.random((4, 5, 6)) * 200).astype("f4")
        points, cells = tetrahedra(2)
        grid = ("DIMENSIONS 6 5 4", "ORIGIN 1 2 3", "SPACING 0.5 1 2")
        return {"ascii.vti": image_data([("p", "Float32", 1, values)], (6, 5, 4)),
                "inline.vti": image_data([("p", "Float32", 1, values)], (6, 5, 4), encoding="binary", compressor="ZLib"),
                "raw.vti": image_data([("p", "Float32", 1, values)], (6, 5, 4), encoding="appended"),
                "text.vtk": legacy("STRUCTURED_POINTS", grid, values),
                "binary.vtk": legacy("STRUCTURED_POINTS", grid, values, True),
                "cells.vtu": unstructured(points, cells, linear(*points.T), np.zeros(len(cells))),
                "plain.mha": meta_image(values, "")[0], "packed.mha": meta_image(values, "", compressed=True)[0],
                "heights.dem": elevation_model(values[0].astype(int), (0, 0), (1, 1), 1).rstrip() + b" " * 59, "map.mrc": mrc(values),
                "density.cube": cube(values.astype(float).transpose(2, 1, 0), np.eye(3), (0, 0, 0))}

    def test_damaged_files_are_errors_of_their_input(self):
        for name, data in self.samples_of_formats().items():
            stem, extension = name.split(".")
            array = ("--array", "p") if extension in ("vti", "vtk", "vtu") else ()
            self.write(name, data)
            # A layer of heights has no surface.
            is_layer = stem == "heights"
            wanted = () if is_layer else ("--iso", "1" if stem == "cells" else "100", "--nan", "outside")
            out = "npy" if is_layer else "ply"
            self.convert(name, *array, *wanted, "-o", f"{stem}.{out}")
            # Every cut loses samples: only what follows the last ones may be missing.
            count = SEEDS // 2
            for index in range(count):
                self.write(f"{stem}_{index:04}.{extension}", data[:(len(data) - 60) * (index + 1) // count])
            for index in range(count, SEEDS):
                self.write(f"{stem}_{index:04}.{extension}", mutate(data, f"{name} {index}"))
            wanted += () if is_layer else ("--empty", "skip")
            run = self.run_program(f"{stem}_####.{extension}", "--input-format", "vtk", *array, *wanted, "--memory-limit", "256M",
                                   "-o", f"{stem}_####.{out}", env=dict(os.environ, ISOEXTRACT_PLUGIN_SECONDS="5"))
            self.assertIn(run.code, (2, 5), run.err)
            written = {int(path.stem[-4:]) for path in self.folder.glob(f"{stem}_????.{out}")}
            with self.subTest(name=name):
                self.assertEqual(written & set(range(count)), set(), run.err)
                for line in run.err.splitlines():
                    self.assertRegex(line, r"^(isoextract: |  |\d+ of \d+ frames?)", "a library has spoken")


if __name__ == "__main__":
    main()
