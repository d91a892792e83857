"""Where vertices land. The field is one sample of 1 among zeros, so that at iso 0.5 the surface is an octahedron whose
corners lie half a voxel from that sample: every coordinate can be computed by hand."""

import math
import struct

from support import SPHERE, ProgramTest, main, read_glb, read_obj, read_ply, read_stl

DIMS = (3, 4, 5)
SPIKE = (1, 2, 3)
RAW = ("spike.raw", "--dims", "3,4,5", "--dtype", "f32", "--iso", "0.5")
PLACED = (*RAW, "--spacing", "2,3,4", "--origin", "10,20,30")  # the spike is at (12, 26, 42)
READERS = {"ply": read_ply, "obj": read_obj, "stl": read_stl, "glb": lambda data: next(iter(read_glb(data).values()))}


class PlacementTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_raw("spike.raw", DIMS, lambda x, y, z: float((x, y, z) == SPIKE))

    def bounds(self, name, *arguments):
        """Bounds of the mesh in the file `name` that the arguments make, which must be turned the right way round."""
        run = self.convert(*arguments, "-o", name)
        mesh = READERS[name.split(".")[-1]]((self.folder / name).read_bytes())
        self.assertGreater(mesh.volume(), 0)
        return mesh.bounds(), run.err

    def assert_bounds(self, found, low, high):
        for got, wanted in zip((*found[0], *found[1]), (*low, *high)):
            self.assertAlmostEqual(got, wanted, delta=1e-6 * max(1.0, abs(wanted)))

    def test_spacing_and_origin(self):
        for name in ("out.ply", "out.obj", "out.stl"):
            found, said = self.bounds(name, *PLACED)
            self.assert_bounds(found, (11, 24.5, 40), (13, 27.5, 44))
            self.assertIn("; world coordinates;", said)

    def test_gltf_turns_z_up_to_y_up(self):
        found, said = self.bounds("out.glb", *PLACED)
        self.assert_bounds(found, (11, 40, -27.5), (13, 44, -24.5))
        self.assertIn("turned from z up to y up", said)
        self.assert_bounds(self.bounds("out.glb", *PLACED, "--up", "z")[0], (11, 40, -27.5), (13, 44, -24.5))

    def test_y_up_input_is_not_turned(self):
        found, said = self.bounds("out.glb", *PLACED, "--up", "y")
        self.assert_bounds(found, (11, 24.5, 40), (13, 27.5, 44))
        self.assertNotIn("turned", said)

    def test_up_changes_nothing_for_formats_without_an_up_axis(self):
        for up in "yz":
            found, said = self.bounds("out.ply", *PLACED, "--up", up)
            self.assert_bounds(found, (11, 24.5, 40), (13, 27.5, 44))
            self.assertIn("note[no-effect]: --up changes nothing", said)

    def test_scale(self):
        found, said = self.bounds("out.ply", *PLACED, "--scale", "2")
        self.assert_bounds(found, (22, 49, 80), (26, 55, 88))
        self.assertIn("scaled by 2", said)

    def test_units_become_metres_where_the_format_prescribes_them(self):
        for unit, meters in (("um", 1e-6), ("mm", 1e-3), ("cm", 1e-2), ("m", 1), ("in", 0.0254), ("ft", 0.3048)):
            found, said = self.bounds("out.glb", *PLACED, "--unit", unit, "--up", "y")
            for got, wanted in zip((*found[0], *found[1]), (11, 24.5, 40, 13, 27.5, 44)):
                self.assertAlmostEqual(got, wanted * meters, delta=1e-6 * wanted * meters)
            self.assertIn("in m" if unit == "m" else f"({unit} to m)", said)

    def test_other_formats_keep_the_unit(self):
        for name in ("out.ply", "out.obj", "out.stl"):
            self.convert(*PLACED, "-o", "plain." + name)
            found, said = self.bounds(name, *PLACED, "--unit", "mm")
            self.assert_bounds(found, (11, 24.5, 40), (13, 27.5, 44))
            self.assertIn(", in mm", said)
            same = (self.folder / name).read_bytes()
            for entry in (b"comment placement", b"# placement"):  # which says what the unit is
                same = b"\n".join(line for line in same.split(b"\n") if not line.startswith(entry))
            plain = (self.folder / ("plain." + name)).read_bytes()
            header = 80 if name.endswith("stl") else 0
            self.assertEqual(same[header:], plain[header:])

    def test_any_unit_into_any(self):
        for name in ("out.stl", "out.glb"):
            found, said = self.bounds(name, *PLACED, "--unit", "in", "--to-unit", "mm", "--up", "y")
            self.assert_bounds(found, [25.4 * x for x in (11, 24.5, 40)], [25.4 * x for x in (13, 27.5, 44)])
            self.assertIn("scaled by 25.4 (in to mm)", said)
            self.assertEqual("note[length-unit]: --to-unit mm" in said, name == "out.glb")
        self.assert_fails(1, self.run_program(*PLACED, "--to-unit", "mm", "-o", "no.stl"), "--to-unit", "--unit mm")
        self.assert_fails(1, self.run_program(*PLACED, "--space", "index", "--unit", "mm", "-o", "no.stl"), "--unit")

    def test_lengths_that_gltf_does_not_prescribe_are_noted(self):
        def said(unit, out, *options):
            head = ("NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace dimension: 3\nencoding: raw\n"
                    f'space units: "{unit}" "{unit}" "{unit}"\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n\n')
            samples = bytes(9 if index == 21 else 0 for index in range(64))
            (self.folder / "in.nrrd").write_bytes(head.encode() + samples)
            return self.convert("in.nrrd", "--iso", "4", "-o", out, *options).err

        self.assertIn("note[length-unit]: in.nrrd: the coordinates are in mm", said("mm", "out.glb"))
        for unit, out, options in (("mm", "out.stl", ()), ("m", "out.glb", ()), ("mm", "out.glb", ("--unit", "file")),
                                   ("mm", "out.glb", ("--scale", "0.001")), ("mm", "out.glb", ("--space", "index"))):
            self.assertNotIn("length-unit", said(unit, out, *options), (unit, out, options))

    def test_any_format_can_be_turned(self):
        turned, kept = ((11, 40, -27.5), (13, 44, -24.5)), ((11, 24.5, 40), (13, 27.5, 44))
        lying = ((11, -44, 24.5), (13, -40, 27.5))
        for name in ("out.ply", "out.obj", "out.stl", "out.glb"):
            for up, out, wanted in (("z", "y", turned), ("z", "z", kept), ("y", "y", kept), ("y", "z", lying)):
                found, said = self.bounds(name, *PLACED, "--up", up, "--up-out", out)
                self.assert_bounds(found, *wanted)
                self.assertEqual(f"turned from {up} up to {out} up" in said, up != out)
                self.assertEqual("show the mesh on its side" in said, name == "out.glb" and out == "z")
        self.assert_fails(1, self.run_program(*PLACED, "--up-out", "y", "--space", "index"), "--up-out")
        self.assert_fails(1, self.run_program(*PLACED, "--up-out", "y", "-o", "a.png"), "--up-out")

    def test_written_meshes_are_verified_as_they_were_placed(self):
        placed = ("--unit", "mm", "--to-unit", "cm", "--up-out", "y")
        for name in ("out.ply", "out.stl", "out.glb"):
            self.convert(*PLACED, *placed, "-o", name)
            self.assertEqual(self.run_program("verify", *PLACED, *placed, name).code, 0)
        self.assertEqual(self.run_program("verify", *PLACED, "--unit", "mm", "out.ply").code, 6)

    def write_scan(self, name, space):
        header = ("NRRD0004\ntype: float\ndimension: 3\nsizes: 3 4 5\nencoding: raw\nendian: little\n"
                  f"space{space}\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n\n")
        values = [float((x, y, z) == SPIKE) for z in range(5) for y in range(4) for x in range(3)]
        (self.folder / name).write_bytes(header.encode() + struct.pack("<60f", *values))

    def test_anatomical_spaces(self):
        low, high = (11, 24.5, 40), (13, 27.5, 44)
        for space, x, y in (("right-anterior-superior", 1, 1), ("left-anterior-superior", -1, 1),
                            ("left-posterior-superior", -1, -1)):
            self.write_scan("scan.nrrd", ": " + space)
            for to, sign in (("ras", 1), ("lps", -1)):
                found, said = self.bounds("out.obj", "scan.nrrd", "--iso", "0.5", "--to-space", to)
                corners = [[sign * s * c for s, c in zip((x, y, sign), corner)] for corner in (low, high)]
                self.assert_bounds(found, [min(c) for c in zip(*corners)], [max(c) for c in zip(*corners)])
                self.assertIn(f", in {to}", said)
        self.write_scan("scan.nrrd", " dimension: 3")
        run = self.run_program("scan.nrrd", "--iso", "0.5", "--to-space", "ras", "-o", "no.obj")
        self.assert_fails(1, run, "scan.nrrd", "RAS, LAS or LPS")
        self.assertNotIn("no.obj", self.files())

    def test_turn_and_scale_together(self):
        found, _ = self.bounds("out.glb", *PLACED, "--unit", "cm")
        self.assert_bounds(found, (0.11, 0.40, -0.275), (0.13, 0.44, -0.245))

    def test_index_space(self):
        for name in ("out.ply", "out.glb"):
            found, said = self.bounds(name, *PLACED, "--space", "index")
            self.assert_bounds(found, (0.5, 1.5, 2.5), (1.5, 2.5, 3.5))
            self.assertIn("voxel coordinates", said)

    def test_a_scale_that_leaves_the_numbers(self):
        for scale in ("1e300", "1e-300"):
            self.assert_fails(1, self.run_program(*PLACED, "--scale", scale), "the range of 64-bit floats", "--scale")

    def test_far_away_frames_keep_their_accuracy(self):
        for name in ("out.ply", "out.obj", "out.glb"):
            found, _ = self.bounds(name, *RAW, "--spacing", "0.01", "--origin", "10000000,0,0", "--up", "y")
            self.assertAlmostEqual(found[0][0], 1e7 + 0.005, delta=1e-6)
            self.assertAlmostEqual(found[1][0], 1e7 + 0.015, delta=1e-6)

    def test_roi_includes_the_samples_on_its_faces(self):
        self.write_raw("ramp.raw", (6, 6, 6), lambda x, y, z: float(x))
        ramp = ("ramp.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "2.5")
        # 0.3 / 0.1 is a little less than 3.
        self.convert(*ramp, "--spacing", "0.1", "--roi", "0,0.1,0.1,0.5,0.3,0.3", "-o", "out.ply")
        found = read_ply((self.folder / "out.ply").read_bytes()).bounds()
        self.assert_bounds(found, (0.25, 0.1, 0.1), (0.25, 0.3, 0.3))
        self.convert(*ramp, "--spacing", "0.1", "--space", "index", "--roi", "0,1,1.5,5,3,4.5", "-o", "out.ply")
        found = read_ply((self.folder / "out.ply").read_bytes()).bounds()
        self.assert_bounds(found, (2.5, 1, 1.5), (2.5, 3, 4.5))

    def test_roi_is_in_the_input_world_whatever_the_output(self):
        self.convert(*PLACED, "--roi", "8,20,36,14,32,48", "--scale", "10", "-o", "out.glb")
        self.assert_fails(2, self.run_program(*PLACED, "--roi", "80,200,360,140,320,480", "--scale", "10"), "--roi",
                          "(10, 20, 30) .. (14, 29, 46)")

    def test_oblique_axes(self):
        # Turned by 30 degrees about z, x and z mirrored.
        c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
        axes = ((-2 * c, -2 * s, 0.0), (-3 * s, 3 * c, 0.0), (0.0, 0.0, -4.0))
        directions = " ".join("({!r},{!r},{!r})".format(*axis) for axis in axes)
        header = ("NRRD0004\ntype: float\ndimension: 3\nsizes: 3 4 5\nencoding: raw\nendian: little\n"
                  f"space: right-anterior-superior\nspace directions: {directions}\nspace origin: (10,20,30)\n\n")
        values = [float((x, y, z) == SPIKE) for z in range(5) for y in range(4) for x in range(3)]
        (self.folder / "turned.nrrd").write_bytes(header.encode() + struct.pack("<60f", *values))
        found, said = self.bounds("out.obj", "turned.nrrd", "--iso", "0.5")
        center = [10 - 2 * c - 6 * s, 20 - 2 * s + 6 * c, 30 - 12]
        reach = [max(abs(axis[i]) / 2 for axis in axes) for i in range(3)]
        self.assert_bounds(found, [p - r for p, r in zip(center, reach)], [p + r for p, r in zip(center, reach)])
        self.assertNotIn("oblique", said)
        run = self.convert("turned.nrrd", "--iso", "0.5", "--roi", "-20,0,-20,20,40,40", "-o", "roi.obj")
        self.assertIn("note[", run.err)
        self.assertIn("oblique", run.err)
        self.assertEqual((self.folder / "roi.obj").read_bytes(), (self.folder / "out.obj").read_bytes())


class ZeroTest(ProgramTest):
    def test_a_surface_that_is_centered_already_is_not_moved(self):
        for name in ("a.ply", "a.glb"):
            run = self.convert(SPHERE, "--iso", "0", "--center", "-o", name)
            self.assertNotIn("moved by", run.err)
            self.assertNotIn("note[placement-differs]", self.convert("verify", SPHERE, name, "--iso", "0").err)
            self.assertNotIn("moved by", self.convert(name, "--center", "-o", "b.ply").err)
        self.assertNotIn("moved by", self.convert("compare", "a.ply", "a.glb").text)
        self.convert(SPHERE, "--iso", "0", "--scale", "2", "-o", "c.ply")
        self.assertIn("note[placement-differs]: c.ply: ", self.convert("verify", SPHERE, "c.ply", "--iso", "0").err)

    def test_no_figure_is_negative_zero(self):
        rows = "".join(f"{-1.0 * x},{-1.0 * y},{-1.0 * z},{-1.0 * x}\n" for x in range(3) for y in range(3) for z in range(3))
        self.assertIn("-0.0,", rows)
        (self.folder / "p.csv").write_text("x,y,z,heat\n" + rows)
        self.write_raw("v.raw", (4, 4, 4), lambda x, y, z: -0.0 if x < 2 else 1.0)
        (self.folder / "v.nhdr").write_text("NRRD0004\ntype: float\ndimension: 3\nspace: LPS\nsizes: 4 4 4\nendian: little\n"
                                            "space directions: (-1,0,0) (0,-1,0) (0,0,1)\nspace origin: (-0,-0,-0)\n"
                                            "encoding: raw\ndata file: v.raw\n\n")
        texts = [self.convert("info", name).text for name in ("p.csv", "v.nhdr")]
        texts.append(self.convert("p.csv", "--center", "--radius", "1", "-o", "a.ply").err)
        texts.append(self.convert("demo:sphere", "--iso", "0", "--center", "-o", "a.glb").err)
        for text in texts:
            self.assertNotRegex(text, r"(?m)-0(?![\w.])", text)


if __name__ == "__main__":
    main()
