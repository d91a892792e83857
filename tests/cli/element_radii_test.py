"""--radii: the radii of atoms by their elements."""

import json
import math

from support import ProgramTest, main

RADII = {"element": {"H": 1.10, "O": 1.52, "Na": 2.27, "Fe": 2.44}, "covalent": {"H": 0.31, "O": 0.66, "Na": 1.66, "Fe": 1.32}}


def ball(radius):
    return 4 / 3 * math.pi * radius ** 3


def xyz(atoms):
    return f"{len(atoms)}\n\n" + "".join(f"{element} {x} {y} {z}\n" for element, x, y, z in atoms)


def gro(atoms):
    rows = [f"{1:5d}{residue:<5}{name:>5}{i + 1:5d}{x:8.3f}{y:8.3f}{z:8.3f}" for i, (residue, name, x, y, z) in enumerate(atoms)]
    return f"atoms\n{len(rows):5d}\n" + "\n".join(rows) + "\n  9.0  9.0  9.0\n"


def pdb(atoms):
    return "".join(f"HETATM{i + 1:5d} {name:4s} {'LIG':3s} A{1:4d}    {x:8.3f}{y:8.3f}{z:8.3f}{1:6.2f}{0:6.2f}          {element:>2s}\n"
                   for i, (element, name, x, y, z) in enumerate(atoms)) + "END\n"


class ElementRadiiTest(ProgramTest):
    def write(self, name, text):
        (self.folder / name).write_text(text)
        return name

    def converted(self, *arguments):
        run = self.convert(*arguments, "-o", "out.ply", "--report", "r.json")
        self.report = json.loads((self.folder / "r.json").read_text())
        return run

    def volume(self, *arguments):
        self.converted("--particles", "spheres", "--cell-size", 0.08, *arguments)
        (mesh,) = self.report["meshes"]
        return mesh["volume"]

    def test_an_atom_has_the_volume_of_its_element(self):
        for radii, table in RADII.items():
            for element, radius in table.items():
                self.write("one.xyz", xyz([(element, 0, 0, 0)]))
                volume = self.volume("one.xyz", "--radii", radii)
                self.assertAlmostEqual(volume / ball(radius), 1, delta=0.01, msg=(element, radii))
                self.assertAlmostEqual(self.report["particles"]["radius"], radius, delta=1e-6)
                self.assertEqual(self.report["particles"]["radius_attribute"], "radius")
        self.assertEqual(self.report["options"]["particles"]["element_radii"], "covalent")

    def test_each_atom_has_its_own_radius(self):
        self.write("two.xyz", xyz([("O", 0, 0, 0), ("Na", 9, 0, 0), ("O", 0, 9, 0)]))
        volume = self.volume("two.xyz", "--radii", "element")
        self.assertAlmostEqual(volume / (2 * ball(1.52) + ball(2.27)), 1, delta=0.01)
        # Every method takes them: the kernels of sph as well.
        self.converted("two.xyz", "--radii", "element")
        self.assertIn("note[particle-radius]", self.convert("two.xyz", "--radii", "element", "-o", "b.ply").err)
        self.assertEqual(self.report["meshes"][0]["components"], 3)

    def test_the_unit_is_that_of_the_file_or_of_the_option(self):
        run = self.converted(self.write("a.xyz", xyz([("Fe", 0, 0, 0)])), "--radii", "element")
        self.assertIn("note[element-radii]: a.xyz: the radii of the elements are in angstrom, because the file states no known unit", run.err)
        run = self.converted("a.xyz", "--radii", "element", "--unit", "nm", "--to-unit", "nm")
        self.assertNotIn("element-radii", run.err)
        self.assertAlmostEqual(self.report["particles"]["radius"], 0.244, delta=1e-6)
        run = self.converted(self.write("a.pdb", pdb([("FE", "FE", 0, 0, 0)])), "--radii", "element")
        self.assertNotIn("element-radii", run.err)
        self.assertAlmostEqual(self.report["particles"]["radius"], 2.44, delta=1e-6)

    def test_names_of_atoms_give_elements(self):
        water = [("SOL", "OW", 1, 1, 1), ("SOL", "HW1", 3, 1, 1), ("SOL", "HW2", 5, 1, 1), ("NA", "NA", 7, 1, 1)]
        self.write("a.gro", gro(water))
        volume = self.volume("a.gro", "--radii", "element")
        self.assertAlmostEqual(volume / (ball(0.152) + 2 * ball(0.110) + ball(0.227)), 1, delta=0.01)
        run = self.converted("a.gro", "--radii", "covalent")
        self.assertIn("note[element-radii]: a.gro: the names of the atoms give their elements: the first letter", run.err)
        self.assertNotIn("angstrom", run.err)
        # The element column of a PDB file counts, not the name: CA is carbon here and calcium there.
        self.write("a.pdb", pdb([("C", " CA", 0, 0, 0), ("CA", "CA", 9, 0, 0)]))
        self.assertAlmostEqual(self.volume("a.pdb", "--radii", "element") / (ball(1.70) + ball(2.31)), 1, delta=0.01)

    def test_dumps_with_elements(self):
        self.write("a.dump", "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 9\n0 9\n0 9\n"
                   "ITEM: ATOMS id element x y z\n1 O 1 1 1\n2 H 6 6 6\n")
        self.assertAlmostEqual(self.volume("a.dump", "--radii", "covalent") / (ball(0.66) + ball(0.31)), 1, delta=0.01)

    def test_info_shows_the_radius(self):
        self.write("a.xyz", xyz([("O", 0, 0, 0), ("O", 2, 0, 0)]))
        (told,) = json.loads(self.convert("info", "--json", "a.xyz", "--radii", "element").text)
        self.assertAlmostEqual(told["particles"]["field"]["radius"], 1.52, delta=1e-6)
        self.assertIn("element-radii", [note["id"] for note in told["particles"]["notes"]])

    def test_sequences_and_regions(self):
        for k in (1, 2):
            self.write(f"s_{k}.xyz", xyz([("O", 0, 0, 0), ("Fe", 8, 0, k)]))
        run = self.convert("s_{}.xyz", "--radii", "element", "--roi=-3,-3,-3,3,3,3", "--particles", "spheres", "-o", "s_{}.ply",
                           "--report", "s_{frame}.json")
        self.assertNotIn("all frames have the radius", run.err)
        for k in (1, 2):
            report = json.loads((self.folder / f"s_{k}.json").read_text())
            self.assertAlmostEqual(report["particles"]["radius"], 1.52, delta=1e-6)
            self.assertEqual(report["meshes"][0]["components"], 1)

    def test_unknown_elements_are_refused(self):
        self.write("a.xyz", xyz([("O", 0, 0, 0), ("Qq", 2, 0, 0), ("M", 3, 0, 0)]))
        run = self.run_program("a.xyz", "--radii", "element", "-o", "out.ply")
        self.assert_fails(2, run, "expected elements with a van der Waals radius in the attribute 'species', found 'Qq' at "
                          "particle 1; 2 of 3 particles have no such element", "--radius")
        self.convert("a.xyz", "--radii", "element", "--species", "O", "-o", "out.ply")
        self.write("a.csv", "x,y,z\n0,0,0\n1,0,0\n")
        self.assert_fails(2, self.run_program("a.csv", "--radii", "element", "-o", "out.ply"), "expected an attribute 'species', 'element' or 'symbol'")
        self.assert_fails(1, self.run_program("a.xyz", "--radii", "element", "--radius", "1", "-o", "out.ply"), "--radii", "--radius")


if __name__ == "__main__":
    main()
