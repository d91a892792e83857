"""Choosing particles: --select, --type, --species and --stride."""

import json

from support import ProgramTest, main, read_ply

SPACING = 0.5
CORNERS = [(x * SPACING, y * SPACING, z * SPACING) for x in range(4) for y in range(4) for z in range(4)]
FAR = [(x + 50, y, z) for x, y, z in CORNERS]


class ChoiceTest(ProgramTest):
    """Two blocks of 64 particles: one at the origin of type 1 and species O, one at x = 50 of type 2 and species Si."""

    def write_xyz(self, name, frames=1):
        rows = [f"O {x} {y} {z}" for x, y, z in CORNERS] + [f"Si {x} {y} {z}" for x, y, z in FAR]
        (self.folder / name).write_text((f"{len(rows)}\n\n" + "\n".join(rows) + "\n") * frames)
        return name

    def write_dump(self, name):
        rows = [f"{i + 1} {1 if p in CORNERS else 2} {'O' if p in CORNERS else 'Si'} {p[0]} {p[1]} {p[2]}"
                for i, p in enumerate(CORNERS + FAR)]
        (self.folder / name).write_text(
            f"ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS ff ff ff\n0 60\n0 60\n0 60\n"
            "ITEM: ATOMS id type element x y z\n" + "\n".join(rows) + "\n")
        return name

    def write_csv(self, name, points):
        (self.folder / name).write_text("x,y,z,heat,v[x],v[y],v[z]\n" + "".join(
            f"{x},{y},{z},{0.1 if x < 9 else 'nan'},{x},0,0\n" for x, y, z in points))
        return name

    def write_gro(self, name):
        rows = [f"{1:5d}{'SOL':<5}{'OW' if p in CORNERS else 'HW1':>5}{i + 1:5d}{p[0]:8.3f}{p[1]:8.3f}{p[2]:8.3f}"
                for i, p in enumerate(CORNERS + FAR)]
        (self.folder / name).write_text(f"blocks\n{len(rows):5d}\n" + "\n".join(rows) + "\n  60.0  60.0  60.0\n")
        return name

    def refuse(self, code, part, *arguments):
        run = self.run_program(*arguments)
        self.assert_fails(code, run, part)
        return run

    def made(self, *arguments):
        self.convert(*arguments, "--radius", SPACING / 2, "-o", "out.ply")
        return (self.folder / "out.ply").read_bytes()

    def test_the_mesh_is_that_of_the_chosen_particles_alone(self):
        wanted = self.made(self.write_csv("near.csv", CORNERS))
        far = self.made(self.write_csv("far.csv", FAR))
        self.assertGreater(read_ply(far).bounds()[0][0], 49)
        table = self.write_csv("both.csv", CORNERS + FAR)
        dump = self.write_dump("both.dump")
        xyz = self.write_xyz("both.xyz")
        for arguments in ((table, "--select", "x < 25"), (table, "--select", "heat == 0.1"),
                          (table, "--select", "|v| <= 10 && !(v.x > 10) and v[1] in {0}"),
                          (dump, "--type", "1"), (dump, "--type", "0..1"), (dump, "--species", "O,H"),
                          (dump, "--select", "id <= 64"), (dump, "--select", "element != Si"),
                          (dump, "--type", "1,2", "--species", "O", "--select", "x<1e9"),
                          (xyz, "--species", "O"), (xyz, "--select", "species in {O, 'C a'}")):
            self.assertEqual(self.made(*arguments), wanted, arguments)
        for arguments in ((table, "--select", "x >= 25"), (table, "--select", "!(heat == 0.1)"),
                          (dump, "--type", "2"), (xyz, "--species", "Si")):
            self.assertEqual(self.made(*arguments), far, arguments)
        self.assertNotEqual(self.made(table, "--select", "heat != 0.1 or x < 25"), far)  # NaN differs from no number

    def test_names_of_atoms(self):
        wanted = self.made(self.write_csv("near.csv", CORNERS))
        self.assertEqual(self.made(self.write_gro("a.gro"), "--select", "name == OW && residue == SOL"), wanted)

    def test_standard_input_sequences_and_every_frame(self):
        wanted = self.made(self.write_csv("near.csv", CORNERS))
        self.write_xyz("a_1.xyz")
        self.write_xyz("a_2.xyz", frames=2)
        with (self.folder / "a_1.xyz").open("rb") as xyz:
            run = self.convert("-", "--input-format", "xyz", "--species", "O", "--radius", SPACING / 2, "-o", "-",
                               "--format", "ply", stdin=xyz)
        self.assertEqual(run.out, wanted)
        self.convert("a_2.xyz", "--volume", "all", "--species", "O", "--radius", SPACING / 2, "-o", "f_{}.ply")
        for name in ("f_0.ply", "f_1.ply"):
            self.assertEqual((self.folder / name).read_bytes(), wanted)
        # --resume converts again with another condition.
        sequence = ("a_{}.xyz", "--frames", "1", "--radius", SPACING / 2, "-o", "s_{}.ply", "--resume")
        for species, same in (("O", True), ("Si", False), ("O", True)):
            self.convert(*sequence, "--species", species)
            self.assertEqual((self.folder / "s_1.ply").read_bytes() == wanted, same, species)

    def test_stride_takes_every_nth_of_the_chosen(self):
        wanted = self.made(self.write_csv("thin.csv", FAR[::3]))
        table = self.write_csv("both.csv", CORNERS + FAR)
        self.assertEqual(self.made(table, "--select", "x > 25", "--stride", "3"), wanted)
        (told,) = json.loads(self.convert("info", "--json", table, "--stride", "1000").text)
        self.assertEqual((told["particles"]["chosen"], told["particles"]["count"]), (1, 128))
        self.refuse(1, "--stride", table, "--stride", "0", "-o", "out.ply")

    def test_counts_are_told(self):
        dump = self.write_dump("both.dump")
        run = self.convert(dump, "--type", "2", "--radius", SPACING / 2, "--explain", "--report", "r.json", "-o", "out.ply")
        self.assertIn("64 of 128 particles chosen by the condition 'type in {2}'", run.err)
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual((report["particles"]["chosen"], report["particles"]["chosen_of"]), (64, 128))
        self.assertEqual(report["options"]["particles"]["select"], "type in {2}")
        run = self.convert("info", dump, "--species", "Si", "--radius", SPACING / 2)
        self.assertIn("64 of 128 chosen", run.text)
        self.assertRegex(run.text, r"element +text +Si 64\n")
        (told,) = json.loads(self.convert("info", "--json", self.write_xyz("both.xyz")).text)
        (species,) = told["particles"]["attributes"]
        self.assertEqual(species["words"], [{"word": "O", "count": 64}, {"word": "Si", "count": 64}])
        self.assertIsNone(told["particles"]["chosen"])

    def test_nothing_chosen(self):
        dump = self.write_dump("both.dump")
        run = self.refuse(2, "the condition 'type in {9}' chooses none of 128 particles", dump, "--type", "9",
                          "--radius", "1", "-o", "out.ply")
        self.assertIn("--empty", run.err)
        self.assertFalse((self.folder / "out.ply").exists())
        self.convert(dump, "--type", "9", "--radius", "1", "--empty", "write", "-o", "out.ply")
        self.assertEqual(read_ply((self.folder / "out.ply").read_bytes()).triangles, [])

    def test_errors_point_at_the_place(self):
        dump = self.write_dump("both.dump")
        for condition, code, told, place in (
                ("type = 1", 1, "--select: expected '==', found '='", 5),
                ("tpye == 1", 2, "there is no attribute 'tpye' (did you mean 'type'?)", 0),
                ("x > 1 && element > 2", 2, "expected a number, found 'element', which holds words", 9),
                ("type == O", 2, "there is no attribute 'O'", 8)):
            run = self.refuse(code, told, dump, "--select", condition, "-o", "out.ply")
            self.assertIn(f"look at this place:\n    {condition}\n    {' ' * place}^\n", run.err)
        self.refuse(1, "--species", dump, "--species", "O,,H", "-o", "out.ply")
        self.refuse(1, "--type", dump, "--type", "1..", "-o", "out.ply")
        self.refuse(1, "particles", "demo:sphere", "--select", "x > 1", "--iso", "0", "-o", "out.ply")


if __name__ == "__main__":
    main()
