"""Units, axes and the origin: what input files state, what meshes say of it, and undoing it."""

import csv
import gzip
import json
import struct

from attribute_kinds_test import bgeo
from support import DATA, SPHERE, ProgramTest, main, needs_data, read_glb, read_ply

DIMS = (3, 4, 5)
SPIKE = (1, 2, 3)
# In the octahedron around the spike, which is at (12, 26, 42), in the world's z-up coordinates.
LOW, HIGH = (11, 24.5, 40), (13, 27.5, 44)
PLACED = ("--spacing", "2,3,4", "--origin", "10,20,30", "--iso", "0.5")


def spike():
    values = [float((x, y, z) == SPIKE) for z in range(DIMS[2]) for y in range(DIMS[1]) for x in range(DIMS[0])]
    return struct.pack(f"<{len(values)}f", *values)


def nifti(unit):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *DIMS, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 16, 32)
    struct.pack_into("<8f", header, 76, 1, 2, 3, 4, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[123] = unit
    struct.pack_into("<hh", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, 2, 0, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30)
    header[344:348] = b"n+1\0"
    return bytes(header) + spike()


def nrrd(fields):
    head = "NRRD0004\ntype: float\ndimension: 3\nsizes: 3 4 5\nendian: little\nencoding: raw\n"
    return (head + fields + "\n").encode() + spike()


SPACE = "space: LPS\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n"


class FramesTest(ProgramTest):
    def write(self, name, data):
        (self.folder / name).write_bytes(data)
        return name

    def raw(self):
        return (self.write("spike.raw", spike()), "--dims", "3,4,5", "--dtype", "f32", *PLACED)

    def bounds(self, name):
        data = (self.folder / name).read_bytes()
        mesh = read_ply(data) if name.endswith("ply") else next(iter(read_glb(data).values()))
        self.assertGreater(mesh.volume(), 0)
        return [number for corner in mesh.bounds() for number in corner]

    def assert_near(self, found, wanted):
        self.assertEqual(len(found), len(wanted))
        for got, number in zip(found, wanted):
            self.assertAlmostEqual(got, number, delta=1e-6 * max(1e-3, abs(number)))

    def test_the_unit_of_a_file(self):
        files = [(self.write(f"{code}.nii", nifti(code)), meters) for code, meters in ((1, 1), (2, 1e-3), (3, 1e-6))]
        units = '"{0}" "{0}" "{0}"\n'
        for i, (unit, meters) in enumerate((("mm", 1e-3), ("Microns", 1e-6), ("\u00b5m", 1e-6), ("centimeters", 1e-2),
                                            ("inches", 0.0254), ("feet", 0.3048), ("\u00c5", 1e-10), ("nm", 1e-9))):
            files.append((self.write(f"space{i}.nrrd", nrrd(SPACE + "space units: " + units.format(unit))), meters))
            axes = "spacings: 2 3 4\naxis mins: 9 18.5 28\nunits: " + units.format(unit)
            files.append((self.write(f"axes{i}.nrrd", nrrd(axes)), meters))
        for name, meters in files:
            run = self.convert(name, "--iso", 0.5, "--unit", "file", "--up", "y", "-o", "out.glb", "--report", "r.json")
            self.assert_near(self.bounds("out.glb"), [meters * x for x in (*LOW, *HIGH)])
            report = json.loads((self.folder / "r.json").read_text())
            self.assertEqual(report["options"]["unit"], "file")
            self.assertEqual(report["placement"]["to_unit"], "m")
            self.assertAlmostEqual(report["placement"]["scale"], meters, delta=1e-15 * meters)
            self.assertNotIn("(file", run.err)
            # The file's unit stays where no format prescribes another, and --to-unit goes before both.
            self.convert(name, "--iso", 0.5, "--unit", "file", "-o", "out.ply")
            self.assert_near(self.bounds("out.ply"), (*LOW, *HIGH))
            self.convert(name, "--iso", 0.5, "--unit", "file", "--to-unit", "cm", "-o", "out.ply")
            self.assert_near(self.bounds("out.ply"), [100 * meters * x for x in (*LOW, *HIGH)])

    def test_tables_say_the_unit_of_lengths(self):
        for number, (unit, step) in enumerate((("mm", 1), ("m", 0.001))):
            axes = "spacings: {0} {0} {0}\nunits: \"{1}\" \"{1}\" \"{1}\"\n".format(step, unit)
            self.write(f"p_{number}.nrrd", nrrd(axes))
        batch = ("p_{}.nrrd", "--iso", 0.5, "-o", "p_{}.ply")

        def units(*options):
            run = self.convert(*batch, *options, "--table", "t.csv")
            with (self.folder / "t.csv").open(newline="") as table:
                found = [row["unit"] for row in csv.DictReader(table)]
            self.convert(*batch, *options, "--table", "t.json")
            self.assertEqual([row["unit"] or "" for row in json.loads((self.folder / "t.json").read_text())], found)
            return found, "different length units" in run.err, run.err

        found, told, said = units("--unit", "file")
        self.assertEqual((found, told), (["mm", "m"], True))
        self.assertIn("(m in 1 frame, mm in 1 frame)", said)
        self.assertIn("--unit file --to-unit mm", said)
        self.assertEqual(units()[:2], (["mm", "m"], True))
        self.assertEqual(units("--resume")[:2], (["mm", "m"], True))
        self.assertEqual(units("--unit", "file", "--to-unit", "cm")[:2], (["cm", "cm"], False))
        self.assertEqual(units("--unit", "in")[:2], (["in", "in"], False))
        self.assertEqual(units("--scale", "2")[:2], (["", ""], False))
        self.assertEqual(units("--space", "index")[:2], (["", ""], False))

    def test_a_file_that_does_not_say_its_unit(self):
        none = "the file states no unit of length"
        files = {self.write("unknown.nii", nifti(0)): none, self.write("odd.nii", nifti(7)): "found 'code 7'",
                 self.write("none.nrrd", nrrd(SPACE)): none,
                 self.write("parsec.nrrd", nrrd(SPACE + 'space units: "pc" "pc" "pc"\n')): "found 'pc'",
                 self.write("mixed.nrrd", nrrd(SPACE + 'space units: "mm" "mm" "cm"\n')): "found 'mm, mm, cm'",
                 "demo:sphere?size=8": none}
        for name, said in files.items():
            iso = 0 if name.startswith("demo") else 0.5
            run = self.run_program(name, "--iso", iso, "--unit", "file", "-o", "out.ply")
            self.assert_fails(1, run, said)
            self.assertIn("hint: give --unit UNIT, for example --unit mm", run.err)
            self.assertFalse((self.folder / "out.ply").exists())
        run = self.run_program("unknown.nii", "--iso", 0.5, "--to-unit", "mm", "-o", "out.ply")
        self.assert_fails(1, run, "--to-unit needs the unit")
        self.assertIn("--unit file if the input states its unit", run.err)

    def test_particles_have_units_too(self):
        atoms = "".join(f"{i} {i % 4} {i // 4 % 4} {i // 16}\n" for i in range(64))
        box = "ITEM: BOX BOUNDS ff ff ff\n" + "0 4\n" * 3
        dump = f"ITEM: UNITS\nmetal\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n64\n{box}ITEM: ATOMS id x y z\n{atoms}"
        self.write("atoms.dump", dump.encode())
        self.convert("atoms.dump", "--iso", "auto", "-o", "plain.ply")
        self.convert("atoms.dump", "--iso", "auto", "--unit", "file", "--to-unit", "nm", "-o", "out.ply")
        self.assert_near(self.bounds("out.ply"), [x / 10 for x in self.bounds("plain.ply")])

    def test_info_tells_of_units_and_spaces(self):
        self.write("mm.nii", nifti(2))
        text = self.convert("info", "mm.nii").text
        self.assertIn("unit          mm; use it with --unit file", text)
        self.assertIn("world space   RAS", text)
        self.assertEqual(json.loads(self.convert("info", "--json", "mm.nii").text)[0]["field"]["length_unit"], "mm")
        self.write("pc.nrrd", nrrd(SPACE + 'space units: "pc" "pc" "pc"\n'))
        text = self.convert("info", "pc.nrrd").text
        self.assertIn("unit          pc\n", text)
        self.assertNotIn("--unit file", text)

    def test_the_middle_goes_to_the_origin(self):
        half = [(high - low) / 2 for low, high in zip(LOW, HIGH)]
        # Of samples from (10, 20, 30) to (14, 29, 46).
        at = [12 - 12, 26 - 24.5, 42 - 38]
        low, high = [x - h for x, h in zip(at, half)], [x + h for x, h in zip(at, half)]
        run = self.convert(*self.raw(), "--center", "-o", "out.ply", "--report", "r.json")
        self.assert_near(self.bounds("out.ply"), (*low, *high))
        self.assertIn("world coordinates, moved by (-12, -24.5, -38)", run.err)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["placement"]["moved_by"], [-12, -24.5, -38])
        # After scales and turns, so that it is the mesh in its file whose middle is at the origin.
        self.convert(*self.raw(), "--center", "--unit", "mm", "-o", "out.glb")
        turned = (low[0], low[2], -high[1], high[0], high[2], -low[1])
        self.assert_near(self.bounds("out.glb"), [x / 1000 for x in turned])
        # Of the region where there is one, which is the same for every frame.
        self.convert(*self.raw(), "--center", "--roi", "10,23,34,14,29,46", "-o", "out.ply")
        self.assert_near(self.bounds("out.ply"), (-1, -1.5, 0, 1, 1.5, 4))
        self.assert_fails(1, self.run_program(*self.raw(), "--center", "--space", "index", "-o", "out.ply"),
                          "--space index gives voxel coordinates, which --center cannot change")
        self.assert_fails(1, self.run_program(*self.raw()[:5], "--spacing", 1, "--center", "-o", "out.vdb"), "--center")

    def test_far_coordinates_come_near(self):
        """What is beyond the numbers of STL is not, once it is at the origin."""
        far = (*self.raw()[:5], "--spacing", "1", "--origin", "1e9,0,0", "--iso", 0.5)
        self.assert_fails(4, self.run_program(*far, "-o", "out.stl"), "use --center")
        self.convert(*far, "--center", "-o", "out.stl")
        self.convert(*far, "-o", "far.ply")
        self.convert(*far, "--center", "-o", "near.ply")
        report = json.loads(self.convert("compare", "far.ply", "near.ply", "--json").text)
        self.assertEqual(report["hausdorff"][0], 0)
        self.assertIsNone(report["a"]["undone"])
        self.assertIn("moved by (-1000000001, -1.5, -2)", report["b"]["undone"])

    def test_compare_undoes_what_meshes_say(self):
        self.write("scan.nii.gz", gzip.compress(nifti(2)))
        self.convert("scan.nii.gz", "--iso", 0.5, "-o", "plain.ply")
        changes = (("--unit", "file", "--to-unit", "m"), ("--scale", "0.3"), ("--up-out", "y"),
                   ("--to-space", "lps"), ("--center",), ("--up", "y", "--up-out", "z"),
                   ("--unit", "file", "--to-unit", "in", "--to-space", "lps", "--up-out", "y", "--center"))
        for change in changes:
            for name in ("out.ply", "out.obj", "out.glb", "out.gltf", "out.drc"):
                self.convert("scan.nii.gz", "--iso", 0.5, *change, "-o", name)
                report = json.loads(self.convert("compare", "plain.ply", name, "--json").text)
                self.assertLess(report["hausdorff"][1], 0.05 if name == "out.drc" else 1e-5, (change, name))
                self.assertAlmostEqual(report["a"]["volume"], report["b"]["volume"],
                                       delta=0.2 if name == "out.drc" else 0.001)
                if name != "out.drc":  # whose places are rounded
                    run = self.convert("verify", "scan.nii.gz", "--iso", 0.5, name)
                    self.assertIn("places the surface accordingly" if name[-3:] in ("ply", "obj") else "same", run.err + run.text)

    def test_one_axis_mirrored(self):
        """Triangles wind the other way round then, and so they do where that is undone."""
        self.write("las.nrrd", nrrd(SPACE.replace("LPS", "LAS")))
        self.convert("las.nrrd", "--iso", 0.5, "-o", "plain.ply")
        for name in ("out.ply", "out.glb"):
            self.convert("las.nrrd", "--iso", 0.5, "--to-space", "ras", "--center", "-o", name)
            report = json.loads(self.convert("compare", "plain.ply", name, "--json").text)
            self.assertEqual(report["hausdorff"], [0, 0])
            self.assertAlmostEqual(report["b"]["volume"], 4, delta=1e-5)
            self.assertIn("same          yes", self.convert("verify", "las.nrrd", "--iso", 0.5, name).text)

    def test_check_tells_the_unit(self):
        for unit, said in (("mm", "as millimeters: 2 x 3 x 4 mm, as the file states."), ("in", "the file states in: scale by 25.4"),
                           (None, "the file states no unit")):
            self.convert(*self.raw(), *(("--unit", unit) if unit else ()), "--center", "-o", "a.ply")
            self.assertIn(said, " ".join(self.run_program("check", "a.ply").text.split()))
            report = json.loads(self.run_program("check", "a.ply", "--json").text)
            self.assertEqual(report["unit"], unit)

    def test_frames_that_move_against_each_other_are_told_of(self):
        for frame in range(2):
            self.write(f"f{frame}.raw", spike())
        sequence = ("f{}.raw", *self.raw()[1:], "--center", "-o", "o{frame}.ply")
        self.assertIn("note[frames-move]: --center moves each frame by the center of its own samples", self.convert(*sequence).err)
        self.assertNotIn("--center", self.convert(*sequence, "--roi", "10,20,30,14,29,46").err)

    def test_meshes_that_nothing_was_done_to_say_nothing(self):
        for name in ("a.ply", "a.obj", "a.glb", "a.gltf"):
            self.convert(*self.raw(), "-o", name)
            self.assertNotIn(b"placement", (self.folder / name).read_bytes())

    def test_meshes_that_other_programs_made_of_ours(self):
        """They lose what our files say, and stay where they are."""
        for name in ("a.obj", "a.gltf"):
            self.convert(*self.raw(), "--unit", "mm", "--to-unit", "in", "--up", "y", "--up-out", "z", "--center", "-o", name)
            text = (self.folder / name).read_text()
            other = "b" + name[1:]
            (self.folder / other).write_text(text.replace("isoextract 0", "somebody 0").replace("placement", "nothing"))
            report = json.loads(self.convert("compare", name, other, "--json").text)
            self.assertEqual((report["hausdorff"], report["a"]["undone"], report["b"]["undone"]), ([0, 0], None, None))

    def test_meshes_that_other_programs_made_of_ours_in_another_format(self):
        for up in ("y", "z"):
            placed = (*self.raw(), "--unit", "mm", "--to-unit", "in", "--up", up, "--center")
            self.convert(*placed, "-o", "a.obj")
            self.convert(*placed, "-o", "a.gltf")
            text = (self.folder / "a.gltf").read_text()
            (self.folder / "b.gltf").write_text(text.replace("isoextract 0", "somebody 0").replace("placement", "nothing"))
            report = json.loads(self.convert("compare", "a.obj", "b.gltf", "--json").text)
            self.assertLess(report["hausdorff"][1], 1e-5)
            self.assertAlmostEqual(report["b"]["volume"], report["a"]["volume"], delta=1e-4 * report["a"]["volume"])

    def test_stl_says_what_fits_into_its_header(self):
        self.convert(*self.raw(), "--scale", 3.7, "-o", "a.obj")
        self.convert(*self.raw(), "--scale", 3.7, "-o", "a.stl")
        report = json.loads(self.convert("compare", "a.obj", "a.stl", "--json").text)
        self.assertLess(report["hausdorff"][1], 1e-5)
        self.assertIsNone(report["b"]["undone"])
        self.convert(*self.raw(), "-o", "plain.stl")
        report = json.loads(self.convert("compare", "plain.stl", "a.stl", "--json").text)
        self.assertLess(report["hausdorff"][1], 1e-5)
        self.assertEqual(len((self.folder / "a.stl").read_bytes()), len((self.folder / "plain.stl").read_bytes()))
        self.convert(*self.raw(), "--unit", "mm", "--to-unit", "in", "--up-out", "y", "--center", "-o", "a.stl")
        run = self.convert("compare", "plain.stl", "a.stl")
        self.assertIn("a.stl: the file has no readable placement record", run.err)
        run = self.run_program("verify", *self.raw(), "a.stl")
        self.assertIn("a.stl: the file has no readable placement record", run.err)
        self.assertEqual(run.code, 6)

    def test_animations_say_it_too(self):
        self.write("f1.raw", spike())
        self.write("f2.raw", spike())
        frames = ("f{}.raw", *self.raw()[1:], "--scale", 3.7)
        self.convert(*frames, "--animate", "-o", "a.glb")
        self.convert(*self.raw(), "-o", "plain.ply")
        self.assertIn(b'"placement":{"scale":3.7', (self.folder / "a.glb").read_bytes())
        report = json.loads(self.convert("compare", "plain.ply", "a.glb", "--json").text)
        self.assertLess(report["hausdorff"][1], 1e-5)

    def test_voxels_and_the_world_are_not_compared_without_a_word(self):
        self.convert(*self.raw(), "--space", "index", "-o", "a.ply")
        self.convert(*self.raw(), "-o", "b.ply")
        run = self.convert("compare", "a.ply", "b.ply")
        self.assertIn("a.ply is in voxel coordinates, and b.ply is in world coordinates", run.err)

    def test_pictures_of_meshes_stand_as_these_say(self):
        for name, *options in (("a.ply",), ("b.glb", "--up", "y"), ("c.ply", "--up", "y", "--scale", 2), ("d.ply", "--space", "index")):
            self.convert(*self.raw(), *options, "-o", name)
        self.convert("render", "a.ply", "--up", "y", "-o", "y.png", "--json", "y.json")
        for name in ("b.glb", "c.ply"):
            self.convert("render", name, "-o", "o.png", "--json", "o.json")
            self.assertEqual((self.folder / "o.png").read_bytes(), (self.folder / "y.png").read_bytes())
        run = self.convert("render", self.raw()[0], *self.raw()[1:7], "--origin", "10,20,30", "d.ply", "-o", "d.png")
        self.assertIn("d.ply: the mesh is in voxel coordinates, but render draws the volume in world coordinates", run.err)

    def test_voxel_coordinates_say_so(self):
        for name in ("a.glb", "a.ply"):
            self.convert(*self.raw(), "--space", "index", "-o", name)
        report = json.loads(self.convert("compare", "a.glb", "a.ply", "--json").text)
        self.assertEqual((report["hausdorff"], report["a"]["undone"]), ([0, 0], None))
        self.assertIn("same          yes", self.convert("verify", *self.raw(), "a.glb").text)

    def test_what_a_mesh_says_is_not_trusted(self):
        self.convert(*self.raw(), "--scale", 2, "-o", "a.obj")
        self.convert(*self.raw(), "-o", "b.obj")
        good = (self.folder / "a.obj").read_text()
        self.assertIn('"scale":2', good)
        for bad in ("{", "[]", '{"up":"x"}', '{"up":"z","scale":0}', '{"up":"z","scale":-2}', '{"up":"z","scale":1e999}',
                    '{"up":"z","scale":"2"}', '{"up":"z","moved_by":[1,2]}', '{"up":"z","moved_by":[1,2,"3"]}',
                    '{"up":"z","turned":"over"}', '{"up":"z","mirrored":"z"}', '{"up":"z","unit":"furlong"}', "{}",
                    '{"up":"z","unit":"mm"}', '{"up":"z","mirrored":"x"}', '{"up":"z","scale":1e-60}',
                    '{"up":"z","moved_by":[1e308,0,0]}'):
            text = "\n".join("# placement " + bad if line.startswith("# placement") else line
                             for line in good.split("\n"))
            (self.folder / "a.obj").write_text(text)
            run = self.run_program("compare", "a.obj", "b.obj", "--json")
            self.assertEqual(run.code, 0, run.err)
            self.assertIn("the file has no readable placement record", run.err)
            self.assertGreater(json.loads(run.text)["hausdorff"][0], 10)
        # Nor is it looked for in files of others.
        (self.folder / "a.obj").write_text(good.replace("# isoextract", "# somebody"))
        run = self.run_program("compare", "a.obj", "b.obj", "--json")
        self.assertGreater(json.loads(run.text)["hausdorff"][0], 10)
        self.assertNotIn("placement", run.err)


class CreatorTest(ProgramTest):
    """Houdini's volumes are y up, and say who made them."""

    ADVICE = r"note\[up-axis\]: {}\.vdb\[density\]: Houdini/SOP_OpenVDB_Write wrote the file, whose up axis is y, but isoextract assumes z: {}; add --up y\n"

    def setUp(self):
        super().setUp()
        for name in ("smoke.vdb", "f_1.vdb", "f_2.vdb"):
            (self.folder / name).symlink_to(DATA / "vdb" / "smoke.vdb")

    def advice(self, consequence, name="smoke"):
        return self.ADVICE.format(name, consequence)

    @needs_data("vdb/smoke.vdb")
    def test_info_names_the_option_and_suggests_it(self):
        text = self.convert("info", "smoke.vdb").text
        self.assertIn("creator       Houdini/SOP_OpenVDB_Write; y is the up axis: add --up y\n", text)
        self.assertRegex(text, r"\n  isoextract smoke\.vdb --up y --iso \S+ -o smoke\.glb\n")
        suggested = json.loads(self.convert("info", "smoke.vdb", "--json").text)[0]["field"]["suggestion"]["command"]
        self.assertIn(" --up y ", suggested)
        run = self.convert(*suggested.split()[1:])
        self.assertNotIn("--up", run.err)
        self.assertNotIn("--up", self.convert("info", SPHERE).text)

    @needs_data("vdb/smoke.vdb")
    def test_meshes_and_pictures_that_lie_on_their_side_are_told(self):
        coarse = ("smoke.vdb", "--iso", 2, "--resolution", 32)
        for consequence, *options in (("the mesh lies on its side", "-o", "a.glb"),
                                      ("the mesh lies on its side", "-o", "a.ply", "--up-out", "y"),
                                      ("the picture shows it on its side", "-o", "a.png", "--size", "64x48"),
                                      ("--html shows it on its side", "-o", "a.ply", "--html", "a.html"),
                                      ("--contact-sheet shows it on its side", "-o", "b.ply", "--contact-sheet", "b.png")):
            with self.subTest(options=options):
                run = self.convert(*coarse, *options, "--report", "r.json")
                self.assertRegex(run.err, self.advice(consequence))
                self.assertEqual(sum("add --up y" in note["text"] for note in json.loads((self.folder / "r.json").read_text())["notes"]), 1)
                upright = self.convert(*coarse, *options, "--up", "y")
                self.assertNotIn("--up", upright.err)
                self.assertNotIn("wrote the file", self.convert(*coarse, *options, "--up", "z").err)
        self.convert(*coarse, "-o", "a.ply", "--html", "a.html")
        self.assertIn("add --up y", (self.folder / "a.html").read_text())
        for options in (("-o", "a.ply"), ("--space", "index", "-o", "a.glb")):
            self.assertNotIn("wrote the file", self.convert(*coarse, *options).err)

    def test_particles_in_houdinis_format(self):
        """Geometry files are Houdini's as well, from any program."""
        for name in ("p.bgeo", "p_1.bgeo", "p_2.bgeo"):
            (self.folder / name).write_bytes(bgeo([]))
        text = self.convert("info", "p.bgeo").text
        self.assertIn("creator       Houdini's format; y is the up axis: add --up y\n", text)
        self.assertRegex(text, r"\n  isoextract p\.bgeo --up y --iso \S+ -o p\.glb\n")
        advice = r"note\[up-axis\]: {}: the file has Houdini's format, whose up axis is y, but isoextract assumes z: {}; add --up y\n"
        run = self.convert("p.bgeo", "--radius", "0.3", "-o", "p.glb")
        self.assertRegex(run.err, advice.format(r"p\.bgeo", "the mesh lies on its side"))
        run = self.convert("p_{}.bgeo", "--radius", "0.3", "-o", "p_{}.glb")
        self.assertEqual(run.err.count("add --up y"), 1)
        run = self.convert("render", "p.bgeo", "--iso", "0.6", "--tf", "none", "--size", "48x32", "-o", "a.png")
        self.assertRegex(run.err, advice.format(r"p\.bgeo", "the picture shows it on its side"))
        for options in (("--up", "y", "-o", "p.glb"), ("--up", "z", "-o", "p.glb"), ("-o", "p.ply")):
            self.assertNotIn("add --up", self.convert("p.bgeo", "--radius", "0.3", *options).err)

    @needs_data("vdb/smoke.vdb")
    def test_a_batch_tells_it_once(self):
        run = self.convert("f_{}.vdb", "--iso", 2, "--resolution", 32, "-o", "f_{}.glb", "--jobs", 2)
        self.assertRegex(run.err, self.advice("the mesh lies on its side", "f_[12]"))
        self.assertEqual(run.err.count("add --up y"), 1)
        quiet = self.convert("f_{}.vdb", "--iso", 2, "--resolution", 32, "--up", "y", "-o", "f_{}.glb")
        self.assertNotIn("--up", quiet.err)

    @needs_data("vdb/smoke.vdb")
    def test_render(self):
        small = ("--size", "48x32", "--backend", "cpu", "-o", "a.png")
        for options in ((), ("--iso", 2, "--tf", "none"), ("--iso", 2)):
            run = self.convert("render", "smoke.vdb", *options, *small)
            self.assertRegex(run.err, self.advice("the picture shows it on its side"))
            self.assertNotIn("--up", self.convert("render", "smoke.vdb", *options, *small, "--up", "y").err)
        run = self.convert("render", "f_{}.vdb", "--size", "48x32", "--backend", "cpu", "-o", "p_{}.png")
        self.assertEqual(run.err.count("add --up y"), 1)

    def test_render_draws_meshes_with_the_axis_that_is_asked_for(self):
        self.convert("demo:torus?size=24", "--iso", 0, "--up", "y", "-o", "y.glb")
        cameras = []
        for options in ((), ("--up", "y"), ("--up", "z")):
            self.convert("render", "y.glb", *options, "--size", "32x32", "-o", "a.png", "--json", "a.json")
            cameras.append(json.loads((self.folder / "a.json").read_text())["pictures"][0]["camera"]["up"])
        self.assertEqual([max(range(3), key=lambda axis: up[axis]) for up in cameras], [1, 1, 2])


if __name__ == "__main__":
    main()
