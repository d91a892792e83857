"""Formats that plug-ins read: as good as built in where they are, and said to be missing where they are not."""

import json
import os
import pathlib
import shutil

from support import ProgramTest, main, read_ply

PLUGINS = pathlib.Path(os.environ["ISOEXTRACT_TEST_PLUGINS"])


def ball(size):
    """A sphere of radius 3 as the text that the plug-in reads; its spacing is 0.5, its first sample at x = 10."""
    middle = (size - 1) / 2
    values = [((x - middle)**2 + (y - middle)**2 + (z - middle)**2)**0.5 - 3
              for z in range(size) for y in range(size) for x in range(size)]
    return f"textvolume\nball {size} {size} {size}\n" + " ".join(map(str, values)) + "\n"


class PluginTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "ball.tvol").write_text(ball(11))

    def with_plugins(self, *arguments, folder=PLUGINS):
        return self.run_program(*arguments, env=dict(os.environ, ISOEXTRACT_PLUGINS=str(folder)))

    def test_a_file_becomes_a_mesh(self):
        run = self.with_plugins("ball.tvol", "--iso", "0", "-o", "ball.ply", "--report", "report.json")
        self.assertEqual(run.code, 0, run.err)
        mesh = read_ply((self.folder / "ball.ply").read_bytes())
        self.assertEqual(mesh.open_edges(), 0)
        # Inside is where the level set is below 0: a ball of radius 1.5 about (12.5, 2.5, 2.5).
        self.assertAlmostEqual(mesh.volume(), 4 / 3 * 3.14159 * 1.5**3, delta=1.2)
        low, high = mesh.bounds()
        for axis, middle in enumerate((12.5, 2.5, 2.5)):
            self.assertAlmostEqual((low[axis] + high[axis]) / 2, middle, places=5)
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(report["input"]["format"], "text")

    def test_info_and_help_know_it(self):
        run = self.with_plugins("info", "ball.tvol")
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("11 x 11 x 11", run.text)
        self.assertIn("text", self.with_plugins("help", "formats").text)

    def test_by_name_whatever_the_file_is_called(self):
        shutil.copy(self.folder / "ball.tvol", self.folder / "ball.dat")
        run = self.with_plugins("ball.dat", "--input-format", "text", "--iso", "0", "-o", "ball.ply")
        self.assertEqual(run.code, 0, run.err)

    def test_one_of_another_version(self):
        (self.folder / "ball.newer").write_text(ball(3))
        run = self.with_plugins("ball.newer", "--iso", "0", "-o", "ball.ply")
        self.assert_fails(3, run, "ball.newer", "isoextract-volume-newer.so", "version 5", "expected 4", "install")
        self.assertEqual(self.files(), ["ball.newer", "ball.tvol"])

    def test_a_table_without_its_plugin(self):
        tables = self.folder / "tables"
        tables.mkdir()
        shutil.copy(PLUGINS / "isoextract-volume-text.txt", tables)
        run = self.with_plugins("ball.tvol", "--iso", "0", "-o", "ball.ply", folder=tables)
        self.assert_fails(3, run, "ball.tvol", "isoextract-volume-text.so", str(tables), "ISOEXTRACT_PLUGINS")

    def test_a_missing_plugin_is_listed_with_its_package(self):
        tables = self.folder / "tables"
        tables.mkdir()
        (tables / "isoextract-volume-abc.txt").write_text(
            "title: a b c\nextensions: .abc\nmagic: 2 4142\nlibrary: libabc\npackage: libabc-dev\n")
        (self.folder / "found").write_bytes(b"..AB, by its content")
        run = self.with_plugins("found", "--iso", "0", "-o", "ball.ply", folder=tables)
        self.assert_fails(3, run, "found", "isoextract-volume-abc.so", "libabc-dev")
        listed = json.loads(self.with_plugins("formats", "--json", folder=tables).text)
        [abc] = [entry for entry in listed if entry["id"] == "abc"]
        self.assertEqual((abc["library"], abc["package"], abc["is_there"], abc["plugin"]),
                         ("libabc", "libabc-dev", False, None))
        [vdb] = [entry for entry in listed if entry["id"] == "vdb" and entry["use"] == "read volume"]
        self.assertTrue(vdb["is_there"])
        self.assertIn("missing; the package libabc-dev", self.with_plugins("formats", folder=tables).text)

    def test_a_batch_survives_files_that_kill_their_reader(self):
        for number in range(1, 21):
            text = "hostile open crash\n" if number % 4 == 0 else "hostile open nothing\n"
            (self.folder / f"f_{number:02}.hostile").write_text(text)
        run = self.with_plugins("f_{:02}.hostile", "--iso", "0.5", "-o", "f_{:02}.ply")
        self.assertEqual(run.code, 5, run.err)
        meshes = [name for name in self.files() if name.endswith(".ply")]
        self.assertEqual(len(meshes), 15)
        self.assertNotIn("f_04.ply", meshes)
        self.assertIn("crashed (signal 11)", run.err)

    def test_a_region_reads_only_its_samples(self):
        run = self.with_plugins("ball.tvol", "--iso", "0", "--roi", "10,0,0,12.2,5,5", "-o", "part.ply", "--report", "r.json")
        self.assertEqual(run.code, 0, run.err)
        whole = self.with_plugins("ball.tvol", "--iso", "0", "--clip", "-1,0,0,-12.2", "-o", "whole.ply")
        self.assertEqual(whole.code, 0, whole.err)
        part, all_of_it = (read_ply((self.folder / name).read_bytes()) for name in ("part.ply", "whole.ply"))
        self.assertEqual(part.bounds(), all_of_it.bounds())
        self.assertEqual(len(part.triangles), len(all_of_it.triangles))
        work = json.loads((self.folder / "r.json").read_text())["work"]
        [parts] = [fact for fact in work if fact["what"] == "file_parts"]
        # x up to 12.2 is before sample 5, and two beyond: 8 of 11 samples along x.
        self.assertEqual((parts["count"], parts["total"]), (3 * 11 * 11, 11**3))

    def test_without_plugins_the_format_is_unknown(self):
        run = self.run_program("ball.tvol", "--iso", "0", "-o", "ball.ply")
        self.assert_fails(2, run, "ball.tvol")


if __name__ == "__main__":
    main()
