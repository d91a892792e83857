"""--config: options from a TOML file, under those of the command line."""

import json

from support import SPHERE, ProgramTest, main, read_ply


class ConfigTest(ProgramTest):
    def write(self, text, name="job.toml"):
        (self.folder / name).write_text(text)

    def arguments(self):
        """Of the run that began the manifest here."""
        header = (self.folder / "isoextract.manifest").read_text().splitlines()[0]
        return json.loads(header[33:])["arguments"]

    def test_a_file_says_what_the_command_line_would(self):
        self.write(f'# a job\ninput = "{SPHERE}"\niso = [0.1, -0.2] # two\noutput = "a.glb"\nroi = [-1, -1, -1, 1, 0.5, 1]\n'
                   'cap = true\nexplain = false\nnormals = "flat"\nerror = true\nthreads = 2\n')
        run = self.convert("--config", "job.toml")
        self.assertIn("iso 0.1, -0.2 -> a.glb", run.err)
        self.convert(SPHERE, "--iso", "0.1", "--iso", "-0.2", "-o", "b.glb", "--roi", "-1,-1,-1,1,0.5,1", "--cap",
                     "--normals", "flat")
        self.assertEqual((self.folder / "a.glb").read_bytes(), (self.folder / "b.glb").read_bytes())

    def test_true_gives_an_option_without_its_value(self):
        self.convert(SPHERE, "--iso", "0", "--largest", "-o", "a.ply")
        (self.folder / "job.toml").write_text(f'input = "{SPHERE}"\niso = 0\nlargest = true\n')
        self.convert("--config", "job.toml", "-o", "b.ply")
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())

    def test_the_command_line_wins(self):
        self.write(f'input = "nothing.vdb"\niso = [0.1, 0.2]\noutput = "a.ply"\nformat = "stl"\nmethod = "mt"\n')
        self.convert("convert", SPHERE, "--config=job.toml", "--iso", "0", "--method", "mc", "--format", "ply")
        self.convert(SPHERE, "--iso", "0", "-o", "b.ply")
        self.assertEqual(read_ply((self.folder / "a.ply").read_bytes()).vertices,
                         read_ply((self.folder / "b.ply").read_bytes()).vertices)
        self.write("iso = 0.1\n")
        run = self.convert("--config", "job.toml", "-o", "c.ply", "--", SPHERE)
        self.assertIn("iso 0.1 -> c.ply", run.err)

    def test_texts_that_a_path_would_cut_are_refused(self):
        (self.folder / "a").write_text("mine")
        self.write(f'input = "{SPHERE}"\niso = 0\noutput = "a\\u0000b.glb"\n')
        self.assert_fails(1, self.run_program("--config", "job.toml"), "job.toml:3: output:", "NUL")
        self.assertEqual((self.folder / "a").read_text(), "mine")

    def test_frames(self):
        """Numbering is no comment; what was used stands in the manifest and the reports."""
        self.write('input = "in_####.raw"\ndims = "6x6x6"\niso = 50\noutput = "w.glb"\nanimate = true\nfps = 12\n'
                   'report = "r_{}.json"\n')
        for number in (1, 2):
            samples = bytearray(216)
            samples[86] = 99
            (self.folder / f"in_{number:04}.raw").write_bytes(bytes(samples))
        run = self.convert("--config", "job.toml", "--dry-run")
        self.assertIn("frame 2: in_0002.raw (216 B) -> w.glb\nframes: 2", run.text)
        self.assertIn("animation: w.glb, 12 frames per second", run.text)
        self.convert("--config", "job.toml", "--jobs", "1")
        used = ["--animate", "--dims=6x6x6", "--fps=12", "--iso=50", "--output=w.glb", "--report=r_{}.json", "in_####.raw",
                "--config", "job.toml", "--jobs", "1"]
        self.assertEqual(sorted(self.arguments()), sorted(used))
        self.assertEqual(json.loads((self.folder / "r_2.json").read_text())["arguments"], self.arguments())
        self.write('input = ["in_0001.raw", "in_0002.raw"]\ndims = [6, 6, 6]\niso = 50\nframes = "1-2x2"\n')
        self.convert("--config", "job.toml", "-o", "f_{}.ply")
        self.assertIn("f_1.ply", self.files())
        self.assertNotIn("f_2.ply", self.files())

    def test_what_is_wrong_is_said_of_the_file(self):
        for text, parts in (
                ("iso = 0\nisoo = 1\n", ("job.toml:2: unknown key 'isoo'", "did you mean 'iso'?")),
                ("-o = 'a.glb'\n", ("job.toml:1: unknown key '-o'", "the long names of the options of convert")),
                ("help = true\n", ("unknown key 'help'",)),
                ("config = 'other.toml'\n", ("unknown key 'config'",)),
                ("[frames]\njobs = 2\n", ("job.toml:1: frames: expected a text, a number or a list of them, found a table",)),
                ("[batch]\njobs = 2\n", ("job.toml:1: unknown key 'batch'",)),
                ("iso = 'abc'\n", ("job.toml: --iso: expected a finite number, auto, zero or a percentile from p0 to p100, found 'abc'",)),
                ("iso = true\n", ("job.toml:1: iso: expected a text, a number or a list of them, found true or false",)),
                ("iso = [[1]]\n", ("job.toml:1: iso: expected a text, a number or a list of them, found a list",)),
                ("iso = 1979-05-27\n", ("found a date or time",)),
                ("method = ['mc', 'mt']\n", ("job.toml:1: method: expected one value, found a list of 2",)),
                ("method = 'mx'\n", ("job.toml: --method: expected one of mc, mt, voxels, surface-nets, found 'mx'",)),
                ("cap = 1\n", ("job.toml:1: cap: expected true or false, found a number",)),
                ("grid = ''\n", ("job.toml: --grid needs a value",)),
                ("iso = 1\niso = 2\n", ("job.toml:2: ",)),
                ("iso = \n", ("job.toml:1: ",)),
                ("\xff\n", ("job.toml:1: ",))):
            self.write(text)
            (self.folder / "job.toml").write_bytes(text.encode("latin-1"))
            # Also where the command line has the option itself.
            self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "-o", "a.ply", "--config", "job.toml"), *parts)
        self.write("fps = 3\n")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "-o", "a.ply", "--config", "job.toml"),
                          "--fps sets the speed", "(some options come from job.toml)")
        self.write('unit = "file"\n')
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "-o", "a.ply", "--config", "job.toml"),
                          "the file states no unit of length (some options come from job.toml)")
        self.assertEqual(self.files(), ["job.toml"])

    def test_a_file_that_cannot_be_read(self):
        (self.folder / "folder").mkdir()
        (self.folder / "empty.toml").touch()
        for name in ("none.toml", "folder", "empty.toml"):
            run = self.run_program(SPHERE, "--iso", "0", "-o", "a.ply", "--config", name, "--report", "r.json")
            self.assert_fails(2, run, name)
            self.assertEqual(json.loads((self.folder / "r.json").read_text())["status"], "failed")
        (self.folder / "long.toml").write_bytes(b"#" * (2 ** 20 + 1))
        self.assert_fails(2, self.run_program(SPHERE, "--iso", "0", "-o", "a.ply", "--config", "long.toml"),
                          "long.toml: expected a file of options of at most 1 MiB, found")
        self.assert_fails(1, self.run_program(SPHERE, "--config", "-"), "--config needs the name of a file")
        self.assert_fails(1, self.run_program(SPHERE, "--config"), "--config needs a value")
        self.assert_fails(1, self.run_program(SPHERE, "--config", "a", "--config", "b"), "--config takes one value, found 2")


if __name__ == "__main__":
    main()
