"""Sequences of label maps: a file for each label of each frame, and the notes in the reports of the frames."""

import json

from support import ProgramTest, main

SIDE = 10
OPTIONS = ("--dims", f"{SIDE},{SIDE},{SIDE}", "--dtype", "u8", "--labels", "all")
NAME = "out/{frame}_{label}.stl"
TABLE = "1 Liver 255 0 0 255\n2 Spleen 0 255 0 255\n"


class LabelSequencesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "out").mkdir()
        for frame in (1, 2, 3):
            self.write_labels(frame, 1, frame + 1)

    def write_labels(self, frame, low, high):
        """Two cubes: label `low` next to the origin, label `high` far from it."""
        self.write_raw(f"m_{frame}.raw", (SIDE, SIDE, SIDE),
                       lambda *at: low if max(at) < 4 else high if min(at) > 5 else 0, "B")

    def batch(self, *arguments, name=NAME):
        return self.run_program("m_{}.raw", *OPTIONS, "-o", name, *arguments)

    def meshes(self):
        return sorted(path.name for path in (self.folder / "out").iterdir() if path.suffix != ".manifest")

    def test_no_clobber_keeps_frames_with_a_file_of_a_label(self):
        self.assertEqual(self.batch().code, 0)
        self.assertEqual(self.meshes(), ["1_1.stl", "1_2.stl", "2_1.stl", "2_3.stl", "3_1.stl", "3_4.stl"])
        for name in ("1_1.stl", "2_1.stl", "2_3.stl"):
            (self.folder / "out" / name).unlink()
        (self.folder / "out/2_x.stl").write_bytes(b"no label has this name")
        (self.folder / "out/1_2.stl").write_bytes(b"mine")
        run = self.batch("--no-clobber")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("1 of 3 frames done, 2 kept", run.err)
        self.assertEqual(self.meshes(), ["1_2.stl", "2_1.stl", "2_3.stl", "2_x.stl", "3_1.stl", "3_4.stl"])
        self.assertEqual((self.folder / "out/1_2.stl").read_bytes(), b"mine")

    def test_no_clobber_finds_names_data_files_and_bodies(self):
        (self.folder / "m_1.ctbl").write_text(TABLE)
        for name, options in (("out/{name} {frame}.ply", ()), ("out/{label}_{frame}.gltf", ()),
                              ("out/{frame}_{label}_{piece}.obj", ("--split-components",))):
            run = self.batch(*options, name=name)
            self.assertEqual(run.code, 0, run.err)
            before = {path: path.stat().st_mtime_ns for path in (self.folder / "out").iterdir()}
            run = self.batch("--no-clobber", *options, name=name)
            self.assertIn("0 of 3 frames done, 3 kept", run.err, name)
            self.assertEqual({path: path.stat().st_mtime_ns for path in before if path.suffix != ".manifest"},
                             {path: time for path, time in before.items() if path.suffix != ".manifest"})

    def test_no_old_mesh_of_a_label_stays_where_a_frame_fails(self):
        self.assertEqual(self.batch().code, 0)
        (self.folder / "out/2_9.stl").write_bytes(b"of another program")
        (self.folder / "m_2.raw").write_bytes(b"short")
        run = self.batch()
        self.assertEqual(run.code, 5, run.err)
        self.assertEqual(self.meshes(),
                         ["1_1.stl", "1_2.stl", "2_1.stl.old", "2_3.stl.old", "2_9.stl", "3_1.stl", "3_4.stl"])
        self.assertIn("note[old-pieces]: this run renamed 2 old meshes of failed frames", run.err)

    def test_a_second_batch_replaces_the_labels_of_a_shard(self):
        self.assertEqual(self.batch("--shard", "1/2").code, 0)
        run = self.batch("--shard", "1/2", "--method", "voxels")
        self.assertEqual(run.code, 0, run.err)
        run = self.batch("--shard", "1/2", name="out/n_{frame}_{label}.stl")
        self.assert_fails(4, run, "this run would replace the manifest")

    def test_no_label_file_replaces_the_input_of_another_frame(self):
        """Label 1 of frame 2 gets the name of frame 12."""
        for frame, old in ((2, 1), (12, 2)):
            (self.folder / f"m_{old}.raw").rename(self.folder / f"y_{frame}.raw")
        before = (self.folder / "y_12.raw").read_bytes()
        run = self.run_program("y_{}.raw", *OPTIONS, "-o", "y_{label}{frame}.raw", "--format", "stl")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("frame 2: y_12.raw: ", run.err)
        self.assertEqual((self.folder / "y_12.raw").read_bytes(), before)

    def test_folders_cannot_be_named_after_labels(self):
        for word in ("{label}", "{name}"):
            run = self.batch("--mkdir", name=f"out/{word}/{{frame}}.stl")
            self.assert_fails(1, run, f"the name of a folder contains {word}")
        self.assertEqual(self.meshes(), [])

    def test_equal_errors_of_label_files_are_told_once(self):
        for frame in (1, 2, 3):
            (self.folder / f"out/{frame}_1.stl").mkdir()
        run = self.batch()
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("3 frames: expected a file, found a folder; first: frame ", run.err)

    def notes(self, path):
        return [(note["id"], note["text"]) for note in json.loads((self.folder / path).read_text())["notes"]]

    def test_reports_of_frames_have_the_note_about_the_table(self):
        (self.folder / "m_1.ctbl").write_text(TABLE)
        run = self.batch("--report", "r_{}.json", name="out/{frame}.glb")
        self.assertEqual(run.code, 0, run.err)
        note = ("label-table", "names and colors of labels come from m_1.ctbl, which lies beside m_1.raw "
                               "(--label-names none: from no table)")
        self.assertEqual(run.err.count(f"note[{note[0]}]: {note[1]}"), 1, run.err)
        for frame in (1, 2, 3):
            self.assertEqual(self.notes(f"r_{frame}.json"), [note])
        self.convert("m_1.raw", *OPTIONS, "-o", "alone.glb", "--report", "alone.json")
        self.assertEqual(self.notes("alone.json"), [note])
        self.assertEqual(self.batch("--report", "n_{}.json", "--label-names", "none", name="out/{frame}.glb").code, 0)
        self.assertEqual(self.notes("n_1.json"), [])

    def test_reports_of_frames_have_the_note_about_the_labels(self):
        for frame in (1, 2):
            head = ("NRRD0004", "type: unsigned char", "dimension: 3", "sizes: 10 10 10", "encoding: raw",
                    "Segment0_Name:=Liver", "Segment0_LabelValue:=1", "Segment0_Layer:=0", "Segment0_Color:=1 0 0",
                    "Segment0_ID:=Segment_1", "", "")
            (self.folder / f"s_{frame}.seg.nrrd").write_bytes("\n".join(head).encode() +
                                                              (self.folder / "m_1.raw").read_bytes())
        run = self.run_program("s_{}.seg.nrrd", "-o", "out/{frame}.glb", "--report", "s_{}.json")
        self.assertEqual(run.code, 0, run.err)
        self.convert("s_1.seg.nrrd", "-o", "alone.glb", "--report", "alone.json")
        alone = [note for note in self.notes("alone.json") if note[0] == "iso-chosen"]
        self.assertEqual(len(alone), 1)
        self.assertIn("all labels, because the file names its labels", alone[0][1])
        for frame in (1, 2):
            self.assertEqual([note for note in self.notes(f"s_{frame}.json") if note[0] == "iso-chosen"], alone)


if __name__ == "__main__":
    main()
