"""Mesh files as the inputs of a conversion: sequences, folders, tables, and notes about meshes of a file."""

import csv
import json

import jsonschema
from support import SOURCE, SPHERE, ProgramTest, glb_json, main, read_stl
from written_meshes import box, ply_text, scene_bytes  # beside mesh_readers


class MeshSequencesTest(ProgramTest):
    def test_meshes_beside_other_inputs(self):
        (self.folder / "in").mkdir()
        (self.folder / "in/b.ply").write_text(ply_text(*box((0, 0, 0), (1, 1, 1))))
        points = ply_text(((0, 0, 0), (1, 0, 0)), ())
        for name in ("a.ply", "c.ply"):  # before and after the mesh
            (self.folder / "in" / name).write_text(points)
            for more in ((), ("--radius", "1")):
                run = self.run_program("in", "-o", "out_{stem}.ply", *more)
                self.assert_fails(1, run, f"in/b.ply is a mesh, in/{name} is none: expected inputs of one kind", "in runs of their own")
            (self.folder / "in" / name).unlink()
        self.assert_fails(1, self.run_program("in/b.ply", "demo:sphere", "-o", "out_{}.ply"), "in/b.ply is a mesh, demo:sphere is none")
        (self.folder / "in/c.ply").write_text(points)
        self.convert("in", "-o", "out_{stem}.ply", "--empty", "skip")  # may be an empty mesh
        self.assertIn("out_b.ply", self.files())
        run = self.run_program("in/b.ply", "in/gone.ply", "-o", "gone_{stem}.ply")  # a missing file is of no kind
        self.assert_fails(5, run, "in/gone.ply: cannot read the file")
        (self.folder / "in/torn.ply").write_bytes(b"")
        run = self.run_program("in/b.ply", "in/torn.ply", "-o", "torn_{stem}.ply")  # so is a damaged one
        self.assert_fails(5, run, "in/torn.ply: ")
        self.assertIn("torn_b.ply", self.files())

    def test_a_sequence(self):
        for frame in (1, 2, 4):
            self.convert(f"demo:gyroid?size={10 + frame}", "--iso", "0.2", "--cap", "-o", f"m_{frame:04}.ply")
        run = self.convert("m_{:04}.ply", "--triangles", "50%", "-o", "s_{:04}.stl", "--table", "t.json")
        self.assertIn("the inputs lack the frames 3", run.err)
        names = [f"s_{frame:04}.stl" for frame in (1, 2, 4)]
        self.assertLessEqual(set(names), set(self.files()))
        table = json.loads((self.folder / "t.json").read_text())
        schema = json.loads((SOURCE / "docs" / "schemas" / "table.schema.json").read_text())
        jsonschema.Draft202012Validator(schema).validate(table)
        for row, name in zip(table, names):
            surface, = row["surfaces"]
            mesh = read_stl((self.folder / name).read_bytes())
            self.assertEqual((surface["iso"], surface["triangles"], surface["closed"], surface["output"]),
                             ("mesh", len(mesh.triangles), True, name))
            self.assertGreater(min(surface["area"], surface["volume"], surface["components"]), 0)
        before = {name: (self.folder / name).stat().st_mtime_ns for name in names}
        (self.folder / names[1]).unlink()
        self.convert("demo:gyroid?size=20", "--iso", "0.2", "--cap", "-o", "m_0004.ply")
        run = self.convert("m_{:04}.ply", "--triangles", "50%", "-o", "s_{:04}.stl", "--resume")
        after = {name: (self.folder / name).stat().st_mtime_ns for name in names}
        self.assertEqual([before[name] == after[name] for name in names], [True, False, False])
        self.convert("m_{:04}.ply", "--triangles", "50%", "-o", "x_{:04}.stl", "--frames", "4")
        self.assertEqual((self.folder / names[2]).read_bytes(), (self.folder / "x_0004.stl").read_bytes())
        self.convert("m_{:04}.ply", "--animate", "-o", "all.glb")
        self.assertEqual(len(glb_json((self.folder / "all.glb").read_bytes())["animations"]), 1)

    def test_a_folder_of_meshes(self):
        (self.folder / "in").mkdir()
        for frame in (1, 2):
            self.convert(SPHERE, "--iso", "0", "-o", f"in/m_{frame}.stl")
        self.convert("in", "-o", "out_{}.ply")
        self.assertLessEqual({"out_1.ply", "out_2.ply"}, set(self.files()))
        self.convert("in/m_1.stl", "in/m_2.stl")
        self.assertLessEqual({"m_1.glb", "m_2.glb"}, set(self.files()))
        self.assert_fails(1, self.run_program("in/m_1.stl", "new.stl"), "new.stl: the last input", "-o new.stl")
        self.convert(SPHERE, "--iso", "0", "-o", "in/m_3.glb")
        run = self.run_program("in/m_1.stl", "in/m_3.glb", "-o", "mixed_{}.ply")
        self.assert_fails(1, run, "in/m_3.glb", "glTF has y up")
        self.assert_fails(1, self.run_program("in/m_1.stl", "in/m_2.stl", "--iso", "0", "-o", "o_{}.ply"), "--iso has no effect")

    # Meshes of one file

    def test_tables_have_a_row_for_each_mesh(self):
        (self.folder / "a.glb").write_bytes(scene_bytes())

        def rows(*arguments):
            self.convert(*arguments, "--table", "t.csv")
            with open(self.folder / "t.csv", newline="", encoding="utf-8") as file:
                return [tuple(row[key] for key in ("iso", "status", "triangles", "closed")) for row in csv.DictReader(file)]

        self.assertEqual(rows("a.glb", "-o", "b.glb"),
                         [("mesh 1", "done", "12", "1"), ("mesh 2", "done", "12", "1"), ("mesh 3", "done", "6", "0"), ("mesh 4", "done", "6", "0")])
        self.assertEqual(rows("a.glb", "-o", "b.stl"), [("mesh", "done", "36", "0")])
        # Clipping leaves chair (x < 1) and table; lamp (x > 3) is gone.
        clipped = rows("a.glb", "-o", "c.glb", "--clip", "-1,0,0,-2", "--empty", "skip")
        self.assertEqual([row[:3] for row in clipped],
                         [("mesh 1", "done", "12"), ("mesh 2", "empty", "0"), ("mesh 3", "done", "6"), ("mesh 4", "done", "6")])
        self.assertEqual(rows("a.glb", "-o", "d.stl", "--clip", "1,0,0,99", "--empty", "skip"), [("mesh", "empty", "0", "")])

    def test_counts_of_one_have_the_singular(self):
        (self.folder / "t.ply").write_text(ply_text(((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 1, 2),)))
        self.assertIn("t.ply -> t.glb: 1 triangle, 3 vertices, ", self.convert("t.ply", "-o", "t.glb").err)
        self.assertIn("so the output lacks those of 1 mesh\n", self.convert("t.glb", "-o", "u.stl").err)
        self.assertIn("1 of 1 frame done", self.convert("t.ply", "-o", "v.stl", "--table", "t.csv").err)
        run = self.convert("t.ply", "-o", "w.stl", "--clip", "1,0,0,-9", "--smooth", "1")
        self.assertIn("clipping cut nothing off; the mesh keeps its triangle\n", run.err)
        self.assertIn("smoothed: 1 pass of taubin", run.err)

    def test_notes_about_empty_meshes_name_them(self):
        (self.folder / "a.glb").write_bytes(scene_bytes())
        far = ("--clip", "1,0,0,99", "--empty", "skip")
        for arguments, note in ((("c.glb", "--clip", "1,0,0,2", "--empty", "skip"),
                                 "clipping removed every triangle in mesh 1, mesh 3, mesh 4; c.glb contains only the other surfaces"),
                                (("d.glb", *far), "clipping removed every triangle in mesh 1, mesh 2, mesh 3, mesh 4; the conversion did not write d.glb"),
                                (("d.stl", *far), "clipping removed every triangle; the conversion did not write d.stl"),
                                (("e.glb", "--drop-components", "99", "--empty", "skip"),
                                 "no component has the requested size in mesh 1, mesh 2, mesh 3, mesh 4; the conversion did not write e.glb")):
            self.assertIn(f"note[no-surface]: a.glb: {note}\n", self.convert("a.glb", "-o", *arguments).err)


if __name__ == "__main__":
    main()
