"""Fields written as NRRD, NumPy and VTK files in place of meshes."""

import json
import pathlib
import re
import struct
import subprocess
import unittest

from support import PROGRAM, ProgramTest, main

HAS_OPENVDB = (pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so").exists()
# The system's Python has Debian's modules, which another one that runs the tests may lack.
SYSTEM_PYTHON = "/usr/bin/python3"


def needs_module(name):
    """Skips a test unless the system's Python has the module."""
    has = pathlib.Path(SYSTEM_PYTHON).exists() and subprocess.run([SYSTEM_PYTHON, "-c", f"import {name}"], capture_output=True).returncode == 0
    return unittest.skipUnless(has, f"{SYSTEM_PYTHON} has no module {name}")


class FieldFormatsTest(ProgramTest):
    def bytes(self, name):
        return (self.folder / name).read_bytes()

    def ask(self, script):
        """The JSON that a script of the system's Python prints."""
        done = subprocess.run([SYSTEM_PYTHON, "-c", script], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def report(self, *arguments):
        run = self.convert(*arguments, "--report", "report.json")
        return json.loads((self.folder / "report.json").read_text()), run

    def write_box(self, name="box.nrrd", directions="(0,0.5,0) (-0.25,0,0) (0,0,2)", kind="short", code="h"):
        values = [x + 10 * y - 100 * z for z in range(3) for y in range(4) for x in range(5)]
        header = f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: 5 4 3\nspace directions: {directions}\n" \
                 "space origin: (1,-3,0.125)\nendian: little\nencoding: raw\n\n"
        (self.folder / name).write_bytes(header.encode() + struct.pack(f"<60{code}", *values))
        return values

    def test_a_box_of_samples_keeps_type_and_place(self):
        values = self.write_box()
        report, run = self.report("box.nrrd", "-o", "copy.nrrd")
        self.assertIn("box.nrrd -> copy.nrrd: 5 x 4 x 3 samples, as 16 bits each", run.err)
        self.assertEqual((report["options"]["format"], report["options"]["field_file"]), ("nrrd", {"half": False, "format": "nrrd"}))
        self.assertEqual(report["files"], [{"path": "copy.nrrd", "bytes": len(self.bytes("copy.nrrd"))}])
        header = self.bytes("copy.nrrd").split(b"\n\n", 1)[0].decode()
        for line in ("type: int16", "space: left-posterior-superior", "space directions: (0,0.5,0) (-0.25,0,0) (0,0,2)", "space origin: (1,-3,0.125)"):
            self.assertIn(line + "\n", header + "\n")
        self.assertEqual(self.bytes("copy.nrrd").split(b"\n\n", 1)[1], struct.pack("<60h", *values))
        for name in ("box.nrrd", "copy.nrrd"):
            self.convert(name, "--iso", "-90.5", "-o", f"{name}.ply")
        self.assertEqual(self.bytes("box.nrrd.ply"), self.bytes("copy.nrrd.ply"))
        self.convert("box.nrrd", "-o", "copy.vti")
        self.assertIn(b'Origin="1 -3 0.125" Spacing="0.5 0.25 2" Direction="0 -1 0 1 0 0 0 0 1"', self.bytes("copy.vti"))
        self.assertIn(struct.pack("<Q60h", 120, *values), self.bytes("copy.vti"))
        run = self.convert("box.nrrd", "-o", "turned.npy")
        self.assertIn("note[placement-not-stored]: turned.npy: the file does not state the placement, which turns or mirrors the samples", run.err)
        self.assertTrue(self.bytes("turned.npy").endswith(struct.pack("<60h", *values)))

    def test_npy_says_how_to_read_it(self):
        self.convert("demo:torus?size=20", "-o", "torus.nrrd")
        run = self.convert("demo:torus?size=20", "-o", "torus.npy")
        options = re.search(r"note\[placement-not-stored\]: torus.npy: the file does not state the spacing (\S+) and the origin (\S+)\n", run.err)
        self.convert("torus.npy", "--spacing", options[1], f"--origin={options[2]}", "--iso", "0", "-o", "npy.ply")
        self.convert("torus.nrrd", "--iso", "0", "-o", "nrrd.ply")
        self.convert("demo:torus?size=20", "--iso", "0", "-o", "direct.ply")
        self.assertEqual(self.bytes("npy.ply"), self.bytes("direct.ply"))
        self.assertEqual(self.bytes("nrrd.ply"), self.bytes("direct.ply"))
        # To standard output, in half floats, and by --format.
        run = self.convert("demo:torus?size=20", "--half", "--format", "npy", "-o", "-")
        self.assertIn(b"'<f2'", run.out[:80])
        self.assertEqual(len(run.out), 128 + 2 * 20**3)

    def test_sparse_fields_become_dense(self):
        (self.folder / "p.csv").write_text("x,y,z\n" + "".join(f"{x / 4},{y / 4},{z / 4}\n" for x in range(5) for y in range(4) for z in range(3)))
        command = ("p.csv", "--radius", "0.15")
        report, run = self.report(*command, "-o", "p.nrrd")
        self.assertIn("note[sparse-made-dense]", run.err)
        self.assertEqual(report["options"]["format"], "nrrd")
        self.convert("p.nrrd", "--iso", "0.6", "-o", "dense.obj")
        self.convert(*command, "--iso", "0.6", "-o", "direct.obj")
        compared = json.loads(self.convert("compare", "dense.obj", "direct.obj", "--json").text)
        self.assertLess(compared["distance"]["max"] if "distance" in compared else 0, 1e-6, compared)
        run = self.run_program(*command, "--memory-limit", "64K", "-o", "q.nrrd")
        self.assert_fails(2, run, "memory")
        self.assertFalse((self.folder / "q.nrrd").exists())

    @unittest.skipUnless(HAS_OPENVDB, "the plug-ins around OpenVDB were not built")
    def test_level_sets_say_their_side(self):
        (self.folder / "p.csv").write_text("x,y,z\n0,0,0\n0.5,0,0\n0.25,0.4,0.1\n")
        command = ("p.csv", "--particles", "spheres", "--radius", "0.4")
        run = self.convert(*command, "-o", "s.nrrd")
        self.assertRegex(run.err, r"s.nrrd: the file does not state that inside is below the iso value\n")
        self.convert("s.nrrd", "--inside", "below", "--iso", "0", "-o", "dense.ply")
        self.convert(*command, "-o", "direct.ply")
        dense, direct = (json.loads(self.convert("check", name, "--json").text) for name in ("dense.ply", "direct.ply"))
        self.assertEqual(dense["mesh"]["triangles"], direct["mesh"]["triangles"])
        self.assertTrue(dense["mesh"]["closed"])

    def test_doubles_stay_doubles(self):
        self.write_box("double.nrrd", kind="double", code="d", directions="(1,0,0) (0,1,0) (0,0,1)")
        report, _ = self.report("double.nrrd", "-o", "a.npy")
        self.assertIn(b"'<f8'", self.bytes("a.npy")[:80])
        self.assertEqual([work for work in report["work"] if work.get("done") == "rounded"], [])

    def test_refusals(self):
        self.write_box("skew.nrrd", directions="(1,0,0) (0.5,1,0) (0,0,1)")
        self.assert_fails(4, self.run_program("skew.nrrd", "-o", "a.vti"), "a.vti: vti files cannot store axes that are not perpendicular")
        for name in ("a.nrrd", "a.vti"):
            self.assert_fails(1, self.run_program("demo:torus", "--half", "-o", name), "which has no 16-bit floats", "use .vdb or .npy")
            self.assert_fails(1, self.run_program("demo:torus", "--iso", "0", "-o", name), "the output is the field itself")
        self.assert_fails(1, self.run_program("demo:torus", "--iso", "0", "-o", "a.raw"), ".vdb, .nrrd, .npy or .vti for the field itself")
        self.assertEqual(self.files(), ["skew.nrrd"])

    @needs_module("numpy")
    def test_numpy_reads_it(self):
        values = self.write_box()
        self.convert("box.nrrd", "-o", "a.npy")
        read = self.ask("import numpy, json; a = numpy.load('a.npy'); print(json.dumps([a.shape, str(a.dtype), a.ravel().tolist()]))")
        self.assertEqual(read, [[3, 4, 5], "int16", values])

    @needs_module("vtk")
    def test_vtk_reads_it(self):
        for kind, code in (("short", "h"), ("float", "f"), ("double", "d"), ("unsigned char", "B")):
            if code == "B":
                values = list(range(60))
                self.write_box()
                header = self.bytes("box.nrrd").split(b"\n\n", 1)[0].replace(b"short", b"uchar")
                (self.folder / "box.nrrd").write_bytes(header + b"\n\n" + bytes(values))
            else:
                values = self.write_box(kind=kind, code=code)
            self.convert("box.nrrd", "-o", "a.vti")
            read = self.ask("""
import json, vtk
reader = vtk.vtkXMLImageDataReader()
reader.SetFileName("a.vti")
reader.Update()
image = reader.GetOutput()
scalars = image.GetPointData().GetScalars()
place = [0.0, 0.0, 0.0]
image.TransformIndexToPhysicalPoint([4, 3, 2], place)
print(json.dumps([scalars.GetName(), image.GetDimensions(), [scalars.GetValue(i) for i in range(scalars.GetNumberOfTuples())], place]))
""")
            self.assertEqual(read, ["box", [5, 4, 3], values, [1 - 0.25 * 3, -3 + 0.5 * 4, 0.125 + 4]])


if __name__ == "__main__":
    main()
