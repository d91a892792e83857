"""Values that all frames of a sequence share: the radius of particles and the range of colors."""

import json
import struct

from support import ProgramTest, main


def block(spacing, n=6):
    return [(spacing * i, spacing * j, spacing * k) for i in range(n) for j in range(n) for k in range(n)]


class SequenceValuesTest(ProgramTest):
    def write_csv(self, name, points, value=None):
        rows = [",".join(repr(float(c)) for c in (*p, *value(p))) if value else ",".join(map(repr, p)) for p in points]
        header = "x,y,z,p,vx,vy,vz" if value else "x,y,z"
        (self.folder / name).write_text("\n".join([header, *rows]) + "\n")

    def write_frames(self):
        """The particles move apart: each frame alone has a larger radius."""
        for number, spacing in ((3, 0.5), (4, 0.6), (5, 0.75)):
            self.write_csv(f"a_{number}.csv", block(spacing))

    def write_colored(self):
        for number in (1, 2, 3):
            self.write_csv(f"c_{number}.csv", block(0.5), lambda p, n=number: (n * p[0], 3 * n, 4 * n * p[1] / 2.5, 0))

    def radii(self, *options, out="o"):
        run = self.convert("a_{}.csv", *options, "-o", f"{out}_{{}}.ply", "--report", "r_{}.json")
        return [json.loads((self.folder / f"r_{n}.json").read_text())["particles"]["radius"] for n in (3, 4, 5)], run

    def own_radius(self, name):
        return json.loads(self.convert("info", "--json", name).text)[0]["particles"]["suggested_radius"]

    def meshes(self, pattern):
        return {path.name.split("_")[-1]: path.read_bytes() for path in sorted(self.folder.glob(pattern))}

    # Radius

    def test_one_radius_for_all_frames(self):
        self.write_frames()
        own = [self.own_radius(f"a_{n}.csv") for n in (3, 4, 5)]
        self.assertAlmostEqual(own[2] / own[0], 1.5, delta=1e-6)
        found, run = self.radii()
        self.assertEqual(found, [own[0]] * 3)
        self.assertRegex(run.err, rf"note\[particle-radius\]: all frames have the radius {own[0]:.6g}, which fits the "
                                  r"particles of frame 3; .*--radius auto:each")
        report = json.loads((self.folder / "r_4.json").read_text())
        self.assertEqual((report["options"]["particles"]["radius"], report["options"]["particles"]["sequence_radius"]),
                         (None, own[0]))
        self.assertTrue(report["particles"]["radius_suggested"])
        self.assertTrue(any("all frames have the radius" in note["text"] for note in report["notes"]))
        self.assertEqual(self.radii("--radius", "auto")[0], [own[0]] * 3)
        each, run = self.radii("--radius", "auto:each")
        self.assertEqual(each, own)
        self.assertNotIn("all frames have", run.err)
        self.assertEqual(self.radii("--radius", "0.3")[0], [0.3] * 3)
        # A single conversion takes its own, by any name.
        for name in ((), ("--radius", "auto"), ("--radius", "auto:each")):
            self.convert("a_5.csv", *name, "-o", "one.ply", "--report", "one.json")
            self.assertEqual(json.loads((self.folder / "one.json").read_text())["particles"]["radius"], own[2])
        self.assert_fails(1, self.run_program("a_5.csv", "--radius", "each", "-o", "x.ply"),
                          "expected a number above 0, auto or auto:each")

    def test_shards_resume_and_dry_run_take_the_radius_of_the_first_frame(self):
        self.write_frames()
        self.convert("a_{}.csv", "-o", "w_{}.ply")
        for shard in ("1/2", "2/2"):
            self.convert("a_{}.csv", "-o", "s_{}.ply", "--shard", shard)
        whole = self.meshes("w_*.ply")
        self.assertEqual(len(whole), 3)
        self.assertEqual(self.meshes("s_*.ply"), whole)
        (self.folder / "w_5.ply").unlink()
        again = self.convert("a_{}.csv", "-o", "w_{}.ply", "--resume")
        self.assertIn("1 of 3 frames done, 2 kept", again.err)
        self.assertEqual(self.meshes("w_*.ply"), whole)
        other = self.convert("a_{}.csv", "-o", "w_{}.ply", "--resume", "--radius", "auto:each")
        self.assertIn("3 of 3 frames done", other.err)
        self.assertRegex(self.convert("a_{}.csv", "-o", "w_{}.ply", "--dry-run").err, "all frames have the radius")

    def test_info_of_a_sequence_shows_the_radius_of_convert(self):
        self.write_frames()
        own = self.own_radius("a_3.csv")
        (entry,) = json.loads(self.convert("info", "--json", "a_{}.csv").text)
        self.assertEqual(entry["radius"], {"radius": own, "frame": 3})
        self.assertIn(f"{own:.6g} in all frames, which fits frame 3", self.convert("info", "a_{}.csv").text)
        for options in (("--radius", "auto:each"), ("--radius", "0.3")):
            (entry,) = json.loads(self.convert("info", "--json", "a_{}.csv", *options).text)
            self.assertIsNone(entry["radius"])

    def test_render_draws_the_radius_of_convert(self):
        self.write_frames()
        own = {n: self.own_radius(f"a_{n}.csv") for n in (3, 4, 5)}
        view = ("--iso", "auto", "--tf", "none", "--camera", "30,20,15", "--look-at", "2,2,2", "--size", "48x32",
                "--backend", "cpu")

        def pictures(*options):
            run = self.convert("render", "a_{}.csv", *view, *options, "-o", "s_{}.png")
            return {n: (self.folder / f"s_{n}.png").read_bytes() for n in own}, run.err

        def picture(n, radius):
            self.convert("render", f"a_{n}.csv", *view, "--radius", repr(radius), "-o", "one.png")
            return (self.folder / "one.png").read_bytes()

        drawn, err = pictures()
        self.assertIn(f"note[particle-radius]: all frames have the radius {own[3]:.6g}, which fits the particles of frame 3",
                      err)
        self.assertEqual(drawn, {n: picture(n, own[3]) for n in own})
        each, err = pictures("--radius", "auto:each")
        self.assertNotIn("all frames have", err)
        self.assertEqual(each, {n: picture(n, own[n]) for n in own})
        self.assertNotEqual(each[5], drawn[5])

    def test_frames_without_a_density_do_not_give_the_radius(self):
        self.write_frames()
        own = self.own_radius("a_3.csv")
        self.write_csv("a_0.csv", [(0, 0, 0)])
        self.write_csv("a_1.csv", [(0, 0, 0), (9, 0, 0)])
        (self.folder / "a_2.csv").write_text("x,y,z\n1,2\n")
        run = self.run_program("a_{}.csv", "-o", "o_{}.ply", "--report", "r_{}.json", "--empty", "skip")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("which fits the particles of frame 3", run.err)
        self.assertIn("1 of 6 frames failed", run.err)
        for number in (0, 1, 3, 4, 5):
            report = json.loads((self.folder / f"r_{number}.json").read_text())
            self.assertEqual(report["particles"]["radius"], own)
        for path in self.folder.glob("a_[2-5].csv"):
            path.unlink()
        self.assertIn("the radius 4.5, which fits the particles of frame 1",
                      self.convert("a_{}.csv", "-o", "few_{}.ply").err)

    # Range of colors

    def colors(self, *options, code=0):
        run = self.run_program("c_{}.csv", "--radius", "0.25", *options, "--ascii", "-o", "o_{}.ply", "--report", "r_{}.json")
        self.assertEqual(run.code, code, run.err)
        stages = [json.loads((self.folder / f"r_{n}.json").read_text())["colors"] for n in (1, 2, 3)]
        return [entry for (entry,) in stages], run

    def test_one_range_for_all_frames(self):
        self.write_colored()
        found, run = self.colors("--color-by", "p:gray")
        self.assertEqual([(entry["range"], entry["own_range"]) for entry in found], [([0, 7.5], False)] * 3)
        self.assertRegex(run.err, r"note\[color-range\]: --color-by p: the colors range from 0 to 7.5, the values of all 3 "
                                  r"frames; add :MIN,MAX to save")
        found, run = self.colors("--color-by", "p:gray:0,2")
        self.assertEqual([entry["range"] for entry in found], [[0, 2]] * 3)
        self.assertNotIn("note[color-range]", run.err)
        # Vectors count by their length.
        found, _ = self.colors("--color-by", "v")
        self.assertEqual(found[0]["range"], [3, 15])
        # A single conversion has the range of its vertices.
        self.convert("c_1.csv", "--radius", "0.25", "--color-by", "p", "-o", "one.ply", "--report", "one.json")
        (entry,) = json.loads((self.folder / "one.json").read_text())["colors"]
        self.assertTrue(entry["own_range"])

    def test_shards_and_resume_have_the_range_of_all_frames(self):
        self.write_colored()
        options = ("--radius", "0.25", "--color-by", "p")
        self.convert("c_{}.csv", *options, "-o", "w_{}.glb")
        self.convert("c_{}.csv", *options, "-o", "s_{}.glb", "--shard", "1/3")
        whole = self.meshes("w_*.glb")
        self.assertEqual(self.meshes("s_*.glb")["1.glb"], whole["1.glb"])
        self.assertIn("0 of 3 frames done, 3 kept", self.convert("c_{}.csv", *options, "-o", "w_{}.glb", "--resume").err)
        # Frame 3 gets larger values, so the colors of all frames change.
        self.write_csv("c_3.csv", block(0.5), lambda p: (40 * p[0], 0, 0, 0))
        self.assertIn("3 of 3 frames done", self.convert("c_{}.csv", *options, "-o", "w_{}.glb", "--resume").err)
        self.assertNotEqual(self.meshes("w_*.glb")["1.glb"], whole["1.glb"])

    def test_frames_that_cannot_be_read_or_lack_the_attribute_do_not_count(self):
        self.write_colored()
        self.write_csv("c_2.csv", block(0.5))
        run = self.run_program("c_{}.csv", "--radius", "0.25", "--color-by", "p?:gray", "--ascii", "-o", "o_{}.ply")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("from 0 to 7.5", run.err)
        (self.folder / "c_2.csv").write_text("broken\n")
        run = self.run_program("c_{}.csv", "--radius", "0.25", "--color-by", "p:gray", "-o", "o_{}.ply")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("from 0 to 7.5", run.err)

    def test_range_of_volumes(self):
        n = 8
        for number in (1, 2):
            for name, value in (("d", lambda i, j, k: 3.2 - max(abs(2 * i - 7), abs(2 * j - 7), abs(2 * k - 7)) / 2),
                                ("t", lambda i, j, k, m=number: m * 10.0 + i)):
                values = [value(i, j, k) for k in range(n) for j in range(n) for i in range(n)]
                (self.folder / f"{name}_{number}.nrrd").write_bytes(
                    b"NRRD0004\ntype: float\ndimension: 3\nsizes: 8 8 8\nendian: little\nencoding: raw\n\n" +
                    struct.pack(f"<{n ** 3}f", *values))
        run = self.convert("d_{}.nrrd", "--iso", "1", "--color-by", "t=t_{}.nrrd", "-o", "o_{}.ply", "--report", "r_{}.json")
        self.assertIn("from 10 to 27", run.err)
        for number in (1, 2):
            (entry,) = json.loads((self.folder / f"r_{number}.json").read_text())["colors"]
            self.assertEqual(entry["range"], [10, 27])


if __name__ == "__main__":
    main()
