"""{piece} in the names of a sequence: a file for each piece of each frame, in the table and for --resume."""

import csv
import json
import math

from support import ProgramTest, main, read_ply

SIDE = 20
BALLS = (((5.1, 5.2, 5.3), 3), ((14.2, 14.1, 14.3), 4), ((5.2, 14.3, 5.1), 2.5))
OPTIONS = ("--dims", f"{SIDE},{SIDE},{SIDE}", "--dtype", "f32", "--iso", "0", "--split-components")
NAME = "out/{frame}_{piece}.ply"


class PieceSequencesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "out").mkdir()
        for frame, balls in ((1, 3), (2, 2), (3, 0), (11, 1)):
            self.write_balls(frame, balls)

    def write_balls(self, frame, count):
        self.write_raw(f"p_{frame}.raw", (SIDE, SIDE, SIDE),
                       lambda *at: max((radius - math.dist(center, at) for center, radius in BALLS[:count]), default=-9))

    def batch(self, *arguments, name=NAME):
        return self.run_program("p_{}.raw", *OPTIONS, "--empty", "skip", "-o", name, *arguments)

    def meshes(self):
        return sorted(path.name for path in (self.folder / "out").glob("*.ply"))

    def table(self):
        with open(self.folder / "t.csv", encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def test_a_file_for_each_piece_of_each_frame(self):
        run = self.batch("--table", "t.csv")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual(self.meshes(), ["11_1.ply", "1_1.ply", "1_2.ply", "1_3.ply", "2_1.ply", "2_2.ply"])
        self.assert_a_row_a_file(self.table())
        alone = self.convert("p_1.raw", *OPTIONS, "-o", "alone_{piece}.ply", "--report", "r.json")
        for n in (1, 2, 3):
            self.assertEqual((self.folder / f"alone_{n}.ply").read_bytes(),
                             (self.folder / f"out/1_{n}.ply").read_bytes(), alone.err)
        areas = [mesh["area"] for mesh in json.loads((self.folder / "r.json").read_text())["meshes"]]
        self.assertEqual([float(row["area"]) for row in self.table() if row["frame"] == "1"], areas)

    def assert_a_row_a_file(self, rows):
        """Each with the figures of its file. Frame 3 has none."""
        rows = [row for row in rows if row["output"]]
        self.assertEqual([row["output"] for row in rows],
                         [f"out/{name}.ply" for name in ("1_1", "1_2", "1_3", "2_1", "2_2", "11_1")])
        for row in rows:
            content = (self.folder / row["output"]).read_bytes()
            mesh = read_ply(content)
            self.assertEqual([int(row[name]) for name in ("bytes", "triangles", "vertices", "components")],
                             [len(content), len(mesh.triangles), len(mesh.vertices), 1], row["output"])
            self.assertGreater(float(row["volume"]), 0)
            self.assertIn(row["closed"], ("1", True))

    def test_tables_and_progress_have_a_row_for_each_file(self):
        run = self.batch("--table", "t.json", "--progress", "json")
        self.assertEqual(run.code, 0, run.err)
        frames = json.loads((self.folder / "t.json").read_text())
        self.assert_a_row_a_file([surface for frame in frames for surface in frame["surfaces"]])
        events = [json.loads(line) for line in run.err.splitlines()]
        told = {event["frame"]: event["surfaces"] for event in events if event["event"] == "frame"}
        self.assert_a_row_a_file([surface for frame in (1, 2, 11) for surface in told[frame]])
        self.batch("--resume", "--table", "t.csv")
        self.assert_a_row_a_file(self.table())
        self.assertEqual({row["status"] for row in self.table()}, {"kept", "empty"})

    def test_a_pair_of_files_is_one_row(self):
        run = self.batch("--table", "t.csv", name="out/{frame}_{piece}.gltf")
        self.assertEqual(run.code, 0, run.err)
        rows = [row for row in self.table() if row["output"]]
        self.assertEqual([row["output"] for row in rows if row["frame"] == "2"], ["out/2_1.gltf", "out/2_2.gltf"])
        for row in rows:
            pair = (self.folder / row["output"], (self.folder / row["output"]).with_suffix(".bin"))
            self.assertEqual(int(row["bytes"]), sum(path.stat().st_size for path in pair))

    def test_a_plot_has_the_whole_surface(self):
        self.assertEqual(self.batch("--plot", "p.svg").code, 0)
        self.assertNotIn("surface 2", (self.folder / "p.svg").read_text())

    def test_resume_does_frames_again_whose_pieces_changed(self):
        self.assertEqual(self.batch().code, 0)
        self.assertIn("4 kept from an earlier run", self.batch("--resume", "--table", "t.csv").err)
        (self.folder / "out/1_2.ply").unlink()
        (self.folder / "out/2_1.ply").write_bytes(b"damaged")
        run = self.batch("--resume", "--table", "t.csv")
        self.assertEqual({row["frame"] for row in self.table() if row["status"] == "done"}, {"1", "2"}, run.err)
        self.assertEqual(len(self.meshes()), 6)

    def test_pieces_of_an_earlier_run_go(self):
        self.assertEqual(self.batch().code, 0)
        self.write_balls(1, 1)
        self.write_balls(2, 0)
        run = self.batch("--resume", "-v")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual(self.meshes(), ["11_1.ply", "1_1.ply"])
        self.assertIn("the run removed files of an earlier run: out/1_2.ply and out/1_3.ply", run.err)

    def test_files_of_others_stay(self):
        for end in ("ply", "stl", "obj", "glb", "gltf", "drc"):
            name = (f"p_1.{end}", f"p_2.{end}", f"p_3.{end}", f"p_4.{end}")
            split = (*OPTIONS, "-o", f"p_{{piece}}.{end}")
            self.convert("p_1.raw", *split)
            (self.folder / name[3]).write_bytes(b"mine")
            self.convert("p_11.raw", *split)
            self.assertEqual([(self.folder / n).exists() for n in name], [True, False, False, True], end)
            self.convert("p_1.raw", *split)
            (self.folder / name[1]).write_bytes(b"mine")
            self.convert("p_11.raw", *split)
            self.assertEqual([(self.folder / n).exists() for n in name], [True, True, True, True], end)

    def test_a_piece_that_is_read_stays(self):
        (self.folder / "a_3.ply").write_bytes((self.folder / "p_2.raw").read_bytes())
        self.assert_fails(1, self.run_program("a_3.ply", "--input-format", "raw", *OPTIONS, "-o", "a_{piece}.ply"),
                          "a_3.ply: this is the input, and the mesh of a body of a_3.ply may get the same name")
        self.assertEqual((self.folder / "a_3.ply").read_bytes(), (self.folder / "p_2.raw").read_bytes())

    def test_names_that_could_be_the_same(self):
        for name, told in (("out/{piece}.ply", "would both write"), ("out/{frame}{piece}.ply", "may get the same file name"),
                           ("out/{piece}{frame}.ply", "may get the same file name"), ("out{piece}/{frame}.ply", "folder"),
                           ("out/{frame}.ply", "{piece}.ply"), ("p_{piece}.raw", "")):
            form = ("--format", "ply") if name.endswith("raw") else ()
            self.assert_fails(1, self.batch(*form, name=name), told)
        self.assert_fails(1, self.batch("--iso", "1"), "{iso}")
        whole = self.run_program("p_{}.raw", *OPTIONS[:-1], "-o", NAME)
        self.assert_fails(1, whole, "--split-components")
        self.assert_fails(1, self.batch("--report", "r_{frame}_{piece}.json"), "--report")
        self.assertEqual(self.meshes(), [])
        for name in ("out/{frame:04}{piece}.ply", "out/{piece}_{frame}.ply", "out/{stem}_{iso}_{piece}.ply"):
            self.assertEqual(self.batch("--dry-run", name=name).code, 0, name)

    def test_no_clobber_sees_the_first_piece(self):
        (self.folder / "out/1_1.ply").write_bytes(b"mine")
        self.assertEqual(self.batch("--no-clobber").code, 0)
        self.assertEqual(self.meshes(), ["11_1.ply", "1_1.ply", "2_1.ply", "2_2.ply"])
        self.assertEqual((self.folder / "out/1_1.ply").read_bytes(), b"mine")

    def test_pieces_of_labels(self):
        for frame in (1, 2):
            self.write_raw(f"l_{frame}.raw", (SIDE, SIDE, SIDE),
                           lambda x, y, z: 1 if abs(z - 10) in (6, 7) else 2 if z == 10 else 0, "B")
        run = self.run_program("l_{}.raw", *OPTIONS[:3], "u8", "--labels", "1,2", "--split-components", "-o",
                               "out/{frame}_{iso}_{piece}.ply")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual(self.meshes(), [f"{frame}_{rest}.ply" for frame in (1, 2) for rest in ("1_1", "1_2", "2_1")])


if __name__ == "__main__":
    main()
