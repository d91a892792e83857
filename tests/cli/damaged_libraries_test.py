"""Damaged files in the hands of libraries that trust them: each is read or refused, and the program goes on."""

import os
import pathlib
import re
import struct
import unittest

from support import PROGRAM, ProgramTest, main
from mutations import mutate

VTK = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-particles-vtk.so"
SEEDS = int(os.environ.get("ISOEXTRACT_MUTATIONS", "60"))  # of each kind of file
COUNT = 12


def legacy(binary):
    def numbers(code, values):
        return struct.pack(f">{len(values)}{code}", *values) if binary else " ".join(map(str, values)).encode()

    points = [0.25 * i for i in range(3 * COUNT)]
    cells = [number for i in range(COUNT) for number in (1, i)]
    return b"\n".join([
        b"# vtk DataFile Version 3.0", b"by hand", b"BINARY" if binary else b"ASCII", b"DATASET UNSTRUCTURED_GRID",
        b"POINTS %d float" % COUNT, numbers("f", points), b"CELLS %d %d" % (COUNT, 2 * COUNT), numbers("i", cells),
        b"CELL_TYPES %d" % COUNT, numbers("i", [1] * COUNT), b"POINT_DATA %d" % COUNT, b"SCALARS heat float 1",
        b"LOOKUP_TABLE default", numbers("f", points[:COUNT]), b"VECTORS v float", numbers("f", points),
        b"FIELD FieldData 1", b"id 1 %d int" % COUNT, numbers("i", list(range(COUNT))), b""])


def xml(kind):
    values = " ".join(str(0.25 * i) for i in range(3 * COUNT))
    point_data = f'<PointData><DataArray type="Float32" Name="heat" format="ascii">{" ".join("7" * COUNT)}</DataArray></PointData>'
    points = f'<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">{values}</DataArray></Points>'
    offsets = " ".join(str(i + 1) for i in range(COUNT))
    indices = " ".join(str(i) for i in range(COUNT))
    arrays = (f'<DataArray type="Int64" Name="connectivity" format="ascii">{indices}</DataArray>'
              f'<DataArray type="Int64" Name="offsets" format="ascii">{offsets}</DataArray>')
    if kind == "PolyData":
        counts = f'NumberOfVerts="{COUNT}" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0"'
        cells = f"<Verts>{arrays}</Verts>"
    else:
        counts = f'NumberOfCells="{COUNT}"'
        types = " ".join("1" * COUNT)
        cells = f'<Cells>{arrays}<DataArray type="UInt8" Name="types" format="ascii">{types}</DataArray></Cells>'
    return (f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="0.1" byte_order="LittleEndian">\n<{kind}>\n'
            f'<Piece NumberOfPoints="{COUNT}" {counts}>\n{point_data}\n{points}\n{cells}\n</Piece></{kind}></VTKFile>\n').encode()


@unittest.skipUnless(VTK.exists(), "the plug-in of VTK was not built")
class DamagedLibrariesTest(ProgramTest):
    def check(self, name, data, extension):
        good = self.folder / f"good.{extension}"
        good.write_bytes(data)
        run = self.run_program(good, "--particles", "weight", "--radius", "0.5", "--iso", "0.05", "-o", "good.ply")
        self.assertEqual(run.code, 0, run.err)
        for seed in range(SEEDS):
            (self.folder / f"{name}_{seed:04}.{extension}").write_bytes(mutate(data, f"{name} {seed}"))
        environment = dict(os.environ, ISOEXTRACT_PLUGIN_SECONDS="5")
        # The format by name: what no longer looks like it is to reach the library as well.
        run = self.run_program("--frames", f"0-{SEEDS - 1}", f"{name}_####.{extension}", "--input-format", "vtk",
                               "--particles", "weight", "--radius", "0.5", "--iso", "0.05", "--empty", "skip",
                               "--nan", "outside", "--memory-limit", "256M", "-o", "m_####.ply", "--report", "r_####.json",
                               env=environment)
        self.assertIn(run.code, (0, 2, 5), run.err)
        failed = set(re.findall(rf"({name}_\d+)\.{extension}: ", run.err))
        written = {path.stem[2:] for path in self.folder.glob("m_*.ply")}
        self.assertGreater(len(failed), SEEDS // 8, run.err)
        self.assertGreaterEqual(len(failed) + len(written), SEEDS // 2)
        for line in run.err.splitlines():
            self.assertRegex(line, r"^(isoextract: |  |\d+ of \d+ frames?)", "a library has spoken")

    def test_legacy_text(self):
        self.check("text", legacy(False), "vtk")

    def test_legacy_binary(self):
        self.check("binary", legacy(True), "vtk")

    def test_unstructured_grid(self):
        self.check("grid", xml("UnstructuredGrid"), "vtu")

    def test_poly_data(self):
        self.check("poly", xml("PolyData"), "vtp")


if __name__ == "__main__":
    main()
