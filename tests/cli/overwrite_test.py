"""Nothing that is written takes the place of what is read, and nothing of others is removed."""

import os

from support import ProgramTest, main

HEADER = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: {0} 6 4\nencoding: raw\ndata file: {1}\n"


class OverwriteTest(ProgramTest):
    def write_islands(self, count, header, data):
        """A row of single voxels that are inside, each a piece of the surface at 50; samples in a file of their own."""
        samples = bytearray(4 * count * 24)
        for island in range(count):
            samples[4 * count * 9 + 4 * island + 1] = 100
        (self.folder / data).write_bytes(bytes(samples))
        (self.folder / header).write_text(HEADER.format(4 * count, data) + "\n")
        return header

    def refused(self, keeps, *arguments, says="it is not overwritten"):
        before = {name: (self.folder / name).read_bytes() for name in keeps}
        run = self.run_program(*arguments)
        self.assertEqual(run.code, 1, run.err)
        self.assertIn(says, run.err)
        for name, data in before.items():
            self.assertEqual((self.folder / name).read_bytes(), data, name)

    def test_pieces_and_the_samples(self):
        self.write_islands(3, "d.nhdr", "d-1.bin")
        self.refused(["d-1.bin"], "d.nhdr", "--iso", 50, "--split-components", "-o", "d-{piece}.gltf")
        self.write_islands(3, "e.nhdr", "e-2.bin")
        raw = ("e-2.bin", "--dims", "12,6,4", "--iso", 50, "--split-components", "-o", "e-{piece}.gltf")
        self.refused(["e-2.bin"], *raw, says="the program does not overwrite its input")
        self.assertEqual([name for name in self.files() if name.endswith("gltf")], [])

    def test_pieces_and_the_samples_of_another_frame(self):
        for frame in (1, 2):
            self.write_islands(2, f"f_{frame}.nhdr", f"m_{3 - frame}_1.bin")
        before = (self.folder / "m_2_1.bin").read_bytes()
        run = self.run_program("f_{}.nhdr", "--iso", 50, "--split-components", "-o", "m_{frame}_{piece}.gltf")
        self.assert_fails(1, run, "m_1_1.bin: this holds samples or attributes of the input; it is not overwritten")
        for frame in (1, 2):
            self.assertEqual((self.folder / f"m_{frame}_1.bin").read_bytes(), before)

    def test_pieces_of_two_surfaces_have_two_names(self):
        self.write_islands(11, "t.nhdr", "t.raw")
        self.refused([], "t.nhdr", "--iso", 11, "--iso", 1, "--split-components", "-o", "q{iso}{piece}.obj",
                     says="bodies of two surfaces may get the same file name")
        self.convert("t.nhdr", "--iso", 11, "--iso", 1, "--split-components", "-o", "q{iso}_{piece}.obj")

    def test_a_report_is_no_piece(self):
        self.write_islands(2, "d.nhdr", "d.raw")
        self.refused([], "d.nhdr", "--iso", 50, "--split-components", "-o", "a-{piece}.obj", "--report", "./a-2.obj",
                     says="a body of d.nhdr may get this file name")
        self.convert("d.nhdr", "--iso", 50, "--split-components", "-o", "a-{piece}.obj", "--report", "a-b.obj")

    def test_old_pieces_of_others(self):
        self.write_islands(1, "d.nhdr", "d.raw")
        mine = "# my own model, fitted to what isoextract made\n"
        (self.folder / "a-2.obj").write_text(mine)
        (self.folder / "other").mkdir()
        self.convert("d.nhdr", "--iso", 50, "-o", "other/keep.obj")
        os.symlink("other/keep.obj", self.folder / "b-2.obj")
        for name in ("a", "b"):
            self.convert("d.nhdr", "--iso", 50, "--split-components", "-o", name + "-{piece}.obj")
        self.assertEqual((self.folder / "a-2.obj").read_text(), mine)
        self.assertTrue((self.folder / "b-2.obj").exists())

    def test_old_pieces_of_ours(self):
        for extension in ("obj", "ply", "stl", "glb", "gltf", "drc"):
            self.write_islands(3, "d.nhdr", "d.raw")
            self.convert("d.nhdr", "--iso", 50, "--split-components", "-o", f"a-{{piece}}.{extension}")
            self.write_islands(1, "d.nhdr", "d.raw")
            self.convert("d.nhdr", "--iso", 50, "--split-components", "-o", f"a-{{piece}}.{extension}")
            self.assertEqual([name for name in self.files() if name.endswith(extension)], [f"a-1.{extension}"])

    def test_verification_removes_nothing(self):
        self.write_islands(3, "d.nhdr", "d.raw")
        self.convert("d.nhdr", "--iso", 50, "--split-components", "-o", "a.glb")
        os.rename(self.folder / "a.glb", self.folder / "a-{piece}.glb")
        self.convert("d.nhdr", "--iso", 50, "-o", "a-4.glb")
        self.convert("verify", "d.nhdr", "--iso", 50, "--split-components", "a-{piece}.glb")
        self.assertIn("a-4.glb", self.files())

    def test_pictures_and_what_is_written_beside_them(self):
        self.write_islands(1, "d.nhdr", "d.raw")
        self.convert("d.nhdr", "--iso", 50, "-o", "m.obj")
        self.convert("d.nhdr", "--iso", 50, "-o", "m.gltf")
        (self.folder / "tf.txt").write_text("0 0 0 0 0\n100 1 1 1 1\n")
        self.refused(["m.obj"], "render", "m.obj", "-o", "m.png", "--json", "m.obj")
        self.refused(["m.bin"], "render", "m.gltf", "-o", "m.png", "--json", "m.bin")
        self.refused(["d.raw"], "render", "d.nhdr", "--iso", 50, "-o", "m.png", "--json", "d.raw")
        self.refused(["tf.txt"], "render", "d.nhdr", "--tf", "tf.txt", "-o", "m.png", "--json", "tf.txt")
        self.refused(["m.bin"], "check", "m.gltf", "--report", "m.bin")
        self.assertNotIn("m.png", self.files())

    def test_tables(self):
        for frame in (1, 2):
            (self.folder / f"p_{frame}.csv").write_text("x,y,z\n" + "".join(f"{i % 3},{i // 3},0\n" for i in range(9)))
        points = ("p_{}.csv", "--particles", "sph", "--radius", 1, "-o", "o_{frame}.ply")
        self.refused(["p_1.csv"], *points, "--table", "p_1.csv")
        for frame in (1, 2):
            self.write_islands(1, f"f_{frame}.nhdr", f"f_{frame}.raw")
        (self.folder / "isos.csv").write_text("frame,iso\n1,50\n2,50\n")
        frames = ("f_{}.nhdr", "-o", "o_{frame}.ply")
        self.refused(["isos.csv"], *frames, "--iso-table", "isos.csv", "--table", "isos.csv")
        self.refused([], *frames, "--iso", 50, "--html", "o_1.ply", says="the page and the mesh of frame 1")
        self.assertEqual([name for name in self.files() if name.startswith("o_")], [])
        self.convert(*frames, "--iso", 50, "--table", "t.csv")
        self.convert(*frames, "--iso", 50, "--table", "t.csv")  # its own is written anew


if __name__ == "__main__":
    main()
