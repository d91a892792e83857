"""Radii of particles from an attribute, for methods that need no plug-in."""

import json

from support import ProgramTest, main


def lattices():
    """Two blocks of 4 x 4 x 4 that touch, with particles 1/2 and 1/4 apart: x, y, z and the radius."""
    rows = []
    for spacing, x0 in ((0.5, 0), (0.25, 4)):
        n = int(4 / spacing)
        rows += [(x0 + spacing * (i + 0.5), spacing * (j + 0.5), spacing * (k + 0.5), spacing / 2)
                 for i in range(n) for j in range(n) for k in range(n)]
    return rows


class ParticleRadiiTest(ProgramTest):
    def write(self, name, rows, attribute="pscale"):
        (self.folder / name).write_text("\n".join([f"x,y,z,{attribute}", *(",".join(map(str, row)) for row in rows)]) + "\n")

    def report(self, *arguments):
        run = self.convert(*arguments, "-o", "out.ply", "--report", "r.json")
        return json.loads((self.folder / "r.json").read_text()), run

    def test_each_particle_has_its_size(self):
        for attribute in ("pscale", "radius"):
            self.write("two.csv", lattices(), attribute)
            report, run = self.report("two.csv", "--explain")
            self.assertAlmostEqual(report["meshes"][0]["volume"] / 128, 1, delta=0.02)
            self.assertEqual(report["meshes"][0]["components"], 1)
            self.assertEqual((report["particles"]["radius_attribute"], report["particles"]["radius"]), (attribute, 0.125))
            self.assertFalse(report["particles"]["radius_suggested"])
            self.assertIn(f"each particle has its own radius ('{attribute}'); the median radius is 0.125", run.err)
            self.assertIn("of radius 0.125, the median of their radii", run.err)
            self.assertEqual(self.convert("info", "two.csv").err.count("each particle has its own radius"), 1)
        # One radius for all: the coarse block falls apart.
        report, run = self.report("two.csv", "--radius", "0.125")
        self.assertIsNone(report["particles"]["radius_attribute"])
        self.assertNotIn("gives the radius", run.err)
        self.assertLess(report["meshes"][0]["volume"], 100)
        # A table without the attribute has one radius as well.
        self.write("other.csv", lattices(), "size")
        self.assertTrue(self.report("other.csv")[0]["particles"]["radius_suggested"])

    def test_other_methods_take_the_median(self):
        self.write("two.csv", lattices())
        for method in ("anisotropic", "weight"):
            report, run = self.report("two.csv", "--particles", method)
            self.assertEqual(report["particles"]["radius"], 0.125)
            self.assertIn("all particles have the radius 0.125, the median of the radii ('pscale')", run.err)

    def test_equal_radii_give_the_bytes_of_one_radius(self):
        self.write("equal.csv", [(*row[:3], 0.25) for row in lattices()])
        self.convert("equal.csv", "-o", "own.ply")
        self.convert("equal.csv", "--radius", "0.25", "-o", "given.ply")
        self.assertEqual((self.folder / "own.ply").read_bytes(), (self.folder / "given.ply").read_bytes())

    def test_info_and_sequences_take_them(self):
        self.write("two_1.csv", lattices())
        self.write("two_2.csv", lattices())
        (entry,) = json.loads(self.convert("info", "--json", "two_1.csv").text)
        self.assertEqual(entry["particles"]["field"]["radius"], 0.125)
        run = self.convert("two_{}.csv", "-o", "o_{}.ply", "--report", "r_{}.json")
        self.assertNotIn("all frames have the radius", run.err)
        report = json.loads((self.folder / "r_2.json").read_text())
        self.assertEqual((report["particles"]["radius_attribute"], report["options"]["particles"]["sequence_radius"]),
                         ("pscale", None))
        (entry,) = json.loads(self.convert("info", "--json", "two_{}.csv").text)
        self.assertIsNone(entry["radius"])

    def test_radii_that_are_too_small_or_invalid(self):
        rows = lattices()
        self.write("tiny.csv", [*rows, (50, 0, 0, 0), (60, 0, 0, 0.01)])
        report, run = self.report("tiny.csv")
        self.assertEqual((report["particles"]["too_small"], report["particles"]["particles"]), (2, len(rows)))
        self.assertIn("the field omits 2 particles with a radius below 0.25 sample spacings", run.err)
        self.write("bad.csv", [*rows, (5, 5, 5, -1)])
        self.assert_fails(2, self.run_program("bad.csv", "-o", "x.ply"), "expected finite radii of 0 or more", "pscale",
                          f"at particle {len(rows)}", "--radius R")
        self.assertFalse((self.folder / "x.ply").exists())
        self.report("bad.csv", "--radius", "0.25")


if __name__ == "__main__":
    main()
