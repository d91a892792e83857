"""Messages about surfaces that are empty, open or dropped, and hints that the command at hand can follow."""

import json
import math
import struct

from support import SPHERE, ProgramTest, main, read_ply, read_stl

NAN = float("nan")


class ToldTest(ProgramTest):
    def test_nothing_is_not_closed(self):
        for left_out in (("--iso", "9"), ("--iso", "0", "--drop-components", "99999"), ("--iso", "0", "--clip", "1,0,0,5")):
            run = self.convert(SPHERE, *left_out, "--empty", "write", "-o", "a.ply", "--report", "r.json")
            self.assertIn("; empty; ", run.err)
            self.assertNotIn("closed", run.err)
            mesh = json.loads((self.folder / "r.json").read_text())["meshes"][0]
            self.assertEqual((mesh["triangles"], mesh["closed"]), (0, False))
        run = self.run_program("check", "a.ply")
        self.assertNotRegex(run.text, r"volume|genus")

    def test_why_a_surface_is_left_out(self):
        skip = ("--empty", "skip", "-o", "a.ply")
        for options, told in ((("--iso", "9"), "no surface at iso 9; the conversion did not write a.ply"),
                              (("--iso", "0", "--drop-components", "99999"),
                               "no component has the requested size at iso 0; the conversion did not write a.ply"),
                              (("--iso", "0", "--clip", "1,0,0,5"),
                               "clipping removed every triangle at iso 0; the conversion did not write a.ply")):
            self.assertIn(told, self.convert(SPHERE, *options, *skip).err)
        run = self.convert(SPHERE, "--iso", "9", "--iso", "0", "--iso", "0.2", "--drop-components", "2000", "--empty",
                           "skip", "-o", "a.glb")
        self.assertIn("no component has the requested size at iso 0.2; no surface at iso 9; a.glb contains only the other surfaces", run.err)

    def test_whether_holes_leave_a_surface_open(self):
        def ball(at):
            return lambda x, y, z: NAN if (x, y, z) == at else 5 - math.dist((x, y, z), (6, 6, 6))

        for at, told in (((6, 6, 6), "; closed; without 8 cells"), ((6, 6, 11), "; open; without ")):
            self.write_raw("ball.raw", (13, 13, 13), ball(at))
            run = self.convert("ball.raw", "--dims", "13,13,13", "--dtype", "f32", "--iso", "0.3", "--nan", "hole", "-o",
                               "a.ply")
            self.assertIn(told, run.err)
            mesh = read_ply((self.folder / "a.ply").read_bytes())
            self.assertEqual(mesh.open_edges() == 0, "closed" in told)

    def test_hints_name_options_that_the_command_has(self):
        self.write_raw("nan.raw", (4, 4, 4), lambda x, y, z: NAN if x == 1 else float(x))
        raw = ("nan.raw", "--dims", "4,4,4", "--dtype", "f32")
        self.assert_fails(2, self.run_program(SPHERE, "--iso", "9", "-o", "a.ply"), "--empty skip")
        run = self.run_program("render", SPHERE, "--iso", "9", "-o", "a.png")
        self.assert_fails(2, run, "no surface at iso 9")
        self.assertNotIn("--empty", run.err)
        self.assert_fails(2, self.run_program("render", *raw, "--iso", "2.5", "-o", "a.png"), "--nan outside")

    def test_a_picture_tells_of_samples_that_are_no_numbers(self):
        self.write_raw("nan.raw", (9, 9, 9), lambda x, y, z: NAN if (x, y) == (1, 1) else float(x))
        run = self.convert("render", "nan.raw", "--dims", "9,9,9", "--dtype", "f32", "--size", "32x32", "-o", "a.png")
        self.assertIn("nan.raw: 9 of 729 samples are NaN: render draws nothing in cells with such samples", run.err)

    def test_planes_in_a_config(self):
        planes = ("clip = [1, 0, 0, 0.1]", "clip = [[1, 0, 0, 0.1]]", 'clip = "1,0,0,0.1"', 'clip = ["1,0,0,0.1"]',
                  "clip = [[1, 0, 0, 0.1], [0, 1, 0, 0]]", 'clip = ["1,0,0,0.1", "0,1,0,0"]')
        for plane in planes:
            (self.folder / "job.toml").write_text(f'input = "{SPHERE}"\niso = 0\noutput = "a.ply"\n{plane}\n')
            self.convert("--config", "job.toml")
            two = ("--clip", "0,1,0,0") if plane.count("0, 1") or plane.count("0,1,0") else ()
            self.convert(SPHERE, "--iso", "0", "--clip", "1,0,0,0.1", *two, "-o", "b.ply")
            self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes(), plane)

    def test_reports_of_frames_that_are_kept(self):
        for frame in (1, 2):
            self.write_raw(f"f{frame}.raw", (6, 6, 6), lambda x, y, z: float(x))
        frames = ("f{}.raw", "--dims", "6,6,6", "--dtype", "f32", "--iso", "2.5", "-o", "o{}.ply", "--resume")
        self.convert(*frames)
        self.convert(*frames, "--report", "r{}.json")
        for frame in (1, 2):
            report = json.loads((self.folder / f"r{frame}.json").read_text())
            self.assertEqual(report["meshes"][0]["file"], f"o{frame}.ply")
        before = (self.folder / "r1.json").stat().st_mtime_ns
        self.convert(*frames, "--report", "r{}.json")
        self.assertEqual((self.folder / "r1.json").stat().st_mtime_ns, before)

    def test_stl_says_its_unit_in_inches(self):
        sphere = (SPHERE, "--iso", "0", "--unit", "mm")
        self.convert(*sphere, "-o", "mm.ply")
        for more in ((), ("--up", "y", "--up-out", "z"), ("--up-out", "y")):
            self.convert(*sphere, "--to-unit", "in", *more, "-o", "in.stl")
            data = (self.folder / "in.stl").read_bytes()
            header = data[:80].rstrip(b"\0 ").decode()
            self.assertIn('"unit":"mm","to_unit":"in"}', header)
            low, high = read_stl(data).bounds()
            wide = [b - a for a, b in zip(*read_ply((self.folder / "mm.ply").read_bytes()).bounds())]
            self.assertAlmostEqual(max(high) - min(low), max(wide) / 25.4, delta=1e-3)
            self.assertIn("size", self.run_program("check", "in.stl").text)
            self.assertIn(" in", self.run_program("check", "in.stl").text)
            if not more:
                self.assertRegex(self.convert("compare", "in.stl", "mm.ply").text, r"Hausdorff +[\d.]+e-0[78] to")
            self.convert("verify", SPHERE, "--iso", "0", "in.stl")

    def test_verify_of_packed_files(self):
        field = ("demo:metaballs?size=24", "--iso", "0.5")
        for name, *packing in (("a.glb", "--quantize"), ("a.glb", "--draco"), ("a.glb", "--draco=12"), ("a.drc",),
                               ("a.glb", "--quantize", "--meshopt"), ("a.glb", "--unit", "mm", "--draco")):
            self.convert(*field, *packing, "-o", name)
            self.assertIn("same          yes", self.convert("verify", *field, name).text, packing)
            other = self.run_program("verify", field[0], "--iso", "0.47", name)
            self.assertEqual(other.code, 6, other.err)

    def test_unused_vertices_have_no_size(self):
        vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (100, 100, 100)]
        faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
        header = ("ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                  "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n")
        body = b"".join(struct.pack("<3f", *v) for v in vertices) + b"".join(struct.pack("<B3i", 3, *f) for f in faces)
        (self.folder / "u.ply").write_bytes(header.encode() + body)
        run = self.run_program("check", "u.ply")
        self.assertRegex(run.text, r"size +1 x 1 x 1;")
        self.assertRegex(run.text, r"bounds +\(0, 0, 0\) \.\. \(1, 1, 1\)")


if __name__ == "__main__":
    main()
