"""Particles of molecular dynamics, and particles written for Houdini and VTK."""

import json
import pathlib
import subprocess
import unittest

from field_formats_test import SYSTEM_PYTHON, needs_module
from support import PROGRAM, ProgramTest, main

HAS_VTK = (pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-particles-vtk.so").exists()
POINTS = [(x, y, z) for z in range(3) for y in range(3) for x in range(3)]


class MoleculesTest(ProgramTest):
    def write(self, name, text):
        (self.folder / name).write_text(text)

    def gro(self, shift=0.0):
        rows = "".join(f"{1:5}{'SOL':5}{'OW':>5}{i % 99999:5}{x + shift:8.3f}{y:8.3f}{z:8.3f}\n" for i, (x, y, z) in enumerate(POINTS))
        return f"water t= {shift}\n{len(POINTS)}\n{rows}   5.0 5.0 5.0\n"

    def pdb(self, shift=0.0):
        return "".join(f"ATOM  {i:5}  O   HOH A{1:4}    {x + shift:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00           O\n" for i, (x, y, z) in enumerate(POINTS)) + "ENDMDL\n"

    def setUp(self):
        super().setUp()
        self.write("plain.csv", "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in POINTS))
        self.convert("plain.csv", "--radius", "0.6", "-o", "plain.ply")

    def test_they_equal_a_table(self):
        self.write("a.gro", self.gro())
        self.write("a.pdb", self.pdb())
        for name in ("a.gro", "a.pdb"):
            run = self.convert(name, "--radius", "0.6", "-o", "a.ply")
            self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "plain.ply").read_bytes(), name)
            self.assertEqual(run.out, b"")
        document = json.loads(self.convert("info", "a.pdb", "--json").text)[0]
        self.assertEqual(document["particles"]["count"], 27)
        self.assertIn("angstrom", json.dumps(document))

    def test_frames(self):
        for name, frame in (("t.gro", self.gro), ("t.pdb", self.pdb)):
            self.write(name, frame() + frame(1.0) + frame(2.0))
            self.assert_fails(2, self.run_program(name, "--radius", "0.6", "-o", "x.ply"), "3 frames", "--volume")
            run = self.convert(name, "--volume", "all", "--radius", "0.6", "-o", "f_{}.ply")
            self.assertEqual(run.out, b"")
            self.assertEqual((self.folder / "f_0.ply").read_bytes(), (self.folder / "plain.ply").read_bytes())
            self.convert(name, "--volume", "2", "--radius", "0.6", "-o", "two.ply")
            self.assertEqual((self.folder / "two.ply").read_bytes(), (self.folder / "f_2.ply").read_bytes())
        self.write("t.gro", self.gro().replace("   1.000", "   1.0x0", 1))
        self.assert_fails(2, self.run_program("t.gro", "--radius", "0.6", "-o", "x.ply"), "t.gro: line 4: expected a number as 'position:0'")


class WrittenParticlesTest(ProgramTest):
    def jet(self, name):
        self.convert("simulate", "jet", "--frames", "6", "--count", "300", "--radius", "0.9", "-o", name)

    def test_houdini_geometry_reads_back(self):
        self.jet("a_{}.ply")
        self.jet("a_{}.bgeo")
        rows = {}
        for name in ("ply", "bgeo"):
            self.convert(f"a_6.{name}", "-o", f"{name}.xyz")
            text = (self.folder / f"{name}.xyz").read_text()
            rows[name] = [[float(word) for word in line.split()] for line in text.splitlines()[2:]]
        # y is up in Houdini, z in the tank.
        turned = [[x, z, -y, u, w, -v, *rest] for x, y, z, u, v, w, *rest in rows["ply"]]
        self.assertGreater(len(turned), 100)
        self.assertEqual(turned, rows["bgeo"])
        about = [json.loads(self.convert("info", f"a_6.{name}", "--json").text)[0]["particles"] for name in ("ply", "bgeo")]
        self.assertEqual(about[0]["count"], about[1]["count"])
        self.assertEqual(sorted(a["name"] for a in about[0]["attributes"]), sorted(a["name"] for a in about[1]["attributes"]))

    def test_houdini_geometry_stands_upright(self):
        """info and the printed command name the up axis that the file has."""
        run = self.convert("simulate", "jet", "--frames", "2", "--count", "300", "--radius", "0.9", "-o", "a_{}.bgeo")
        self.assertIn("convert with: isoextract 'a_{}.bgeo' --up y --particles weight --iso ", run.err)
        self.assertRegex(self.convert("info", "a_2.bgeo").text, r"\n  isoextract a_2\.bgeo --up y --iso ")
        # The nozzle is three quarters up: 15 above the center of a tank of height 60.
        low, high = (json.loads(self.convert("info", "a_2.bgeo", "--json").text)[0]["particles"]["bounds"][key] for key in ("min", "max"))
        self.assertTrue(9 < low[1] < high[1] < 21, (low, high))

    @unittest.skipUnless(HAS_VTK, "the plug-in around VTK was not built")
    def test_unstructured_grids_read_back(self):
        self.jet("a_{}.ply")
        self.jet("a_{}.vtu")
        for name in ("ply", "vtu"):
            self.convert(f"a_6.{name}", "--radius", "0.9", "-o", f"{name}.obj")
        self.assertEqual((self.folder / "ply.obj").read_bytes(), (self.folder / "vtu.obj").read_bytes())

    @needs_module("vtk")
    def test_vtk_reads_unstructured_grids(self):
        self.jet("a_{}.vtu")
        script = """
import json, vtk
reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName("a_6.vtu")
reader.Update()
grid = reader.GetOutput()
data = grid.GetPointData()
print(json.dumps([grid.GetNumberOfPoints(), grid.GetNumberOfCells(), grid.GetCellType(0), [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())], grid.GetBounds()]))
"""
        done = subprocess.run([SYSTEM_PYTHON, "-c", script], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        points, cells, kind, names, bounds = json.loads(done.stdout)
        about = json.loads(self.convert("info", "a_6.vtu", "--json").text)[0]["particles"] if HAS_VTK else None
        self.assertEqual((cells, kind), (points, 1))
        if about:
            self.assertEqual(points, about["count"])
            self.assertEqual(names, [a["name"] for a in about["attributes"]])


if __name__ == "__main__":
    main()
