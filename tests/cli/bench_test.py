"""isoextract bench: the table, CSV, JSON and the picture; what is refused before the work."""

import csv
import io
import json
import os
import xml.etree.ElementTree

from support import ProgramTest, main, needs_program

QUICK = ("--sizes", "12,20,32", "--repeats", "1", "--threads", "1")


class BenchTest(ProgramTest):
    def bench(self, *arguments):
        return self.convert("bench", *arguments).text

    def refused(self, code, *arguments, **options):
        """The message of a run that ends before the work: no table, no file."""
        before = self.files()
        run = self.run_program("bench", *arguments, **options)
        self.assert_fails(code, run)
        self.assertEqual(self.files(), before)
        return run.err

    def test_table_csv_and_json_say_the_same(self):
        text = self.bench("demo:sphere", *QUICK, "--csv", "b.csv", "--json", "b.json")
        self.assertEqual(self.files(), ["b.csv", "b.json"])
        rows = list(csv.DictReader(io.StringIO((self.folder / "b.csv").read_text())))
        document = json.loads((self.folder / "b.json").read_text())
        (benchmark,) = document["benchmarks"]
        self.assertEqual((document["repeats"], benchmark["input"], benchmark["iso"]), (1, "demo:sphere", 0))
        self.assertEqual([(r["size"], r["method"]) for r in rows],
                         [(size, method) for size in ("12", "20", "32") for method in ("mc", "mt")])
        self.assertEqual(len(benchmark["rows"]), len(rows))
        for row, other in zip(rows, benchmark["rows"]):
            self.assertEqual(int(row["triangles"]), other["triangles"])
            self.assertEqual(float(row["rms_world"]), other["position"]["rms"]["world"])
            self.assertEqual(float(row["median_seconds"]), other["seconds"]["median"])
            self.assertEqual(row["on_front"] == "1", other["on_front"])
            self.assertIn(f" {row['triangles']} ", text)
        self.assertTrue(any(row["on_front"] == "1" for row in rows))
        for order in benchmark["orders"]:
            self.assertAlmostEqual(order["position"]["slope"], 2, delta=0.2)
            self.assertAlmostEqual(order["flat_normals"]["slope"], 1, delta=0.2)
            self.assertIn(f"{order['position']['slope']:.2f} ({order['position']['last']:.2f})", text)
        self.assertIn("in closed form", text)

    def test_every_method_is_measured(self):
        """Voxels are off by a good part of a voxel, whatever the size of it, and nets by less."""
        for source in (("demo:sphere", "--sizes", "16,32"), ("demo:metaballs", "--sizes", "16,32")):
            self.bench(*source, "--methods", "mc,voxels,surface-nets", "--repeats", "1", "--threads", "1", "--csv", "b.csv")
            rows = list(csv.DictReader(io.StringIO((self.folder / "b.csv").read_text())))
            self.assertEqual([row["method"] for row in rows], ["mc", "voxels", "surface-nets"] * 2)
            for row in rows:
                voxels = float(row["rms_world"]) / (2 / (int(row["size"]) - 1))
                low, high = {"mc": (0.001, 0.1), "voxels": (0.25, 0.4), "surface-nets": (0.05, 0.3)}[row["method"]]
                self.assertTrue(low < voxels < high, row)
                self.assertEqual(row["smooth_normals_degrees"] == "", row["method"] != "mc", row)

    def test_the_default_input_is_the_torus(self):
        self.assertTrue(self.bench(*QUICK, "--methods", "mt").startswith("demo:torus at iso 0\n"))

    def test_verbose_prints_times_and_memory(self):
        run = self.convert("bench", "demo:sphere", *QUICK, "-v")
        self.assertRegex(run.err, r"(?m)^demo:sphere: measured in [\d.]+ s$")
        self.assertRegex(run.err, r"(?m)^peak memory [\d.]+ MiB$")

    def test_several_inputs(self):
        run = self.convert("bench", "demo:sphere", "demo:metaballs", *QUICK, "--iso", "0.1", "--methods", "mc")
        self.assertIn("demo:sphere at iso 0.1\n", run.text)
        self.assertIn("\ndemo:metaballs at iso 0.1\n", run.text)
        self.assertEqual(run.text.count("Orders of convergence"), 2)
        self.assertNotIn("Orders", self.bench("--sizes", "8", "--repeats", "1", "--threads", "1"))

    def test_an_open_surface_has_no_area_or_volume_to_compare(self):
        self.write_raw("plane.raw", (35, 35, 35), lambda x, y, z: x + y / 2 + z / 3 - 30.1)
        text = self.bench("plane.raw", "--dims", "35,35,35", "--dtype", "f32", "--iso", "0", "--threads", "1",
                          "--repeats", "1", "--methods", "mc", "--csv", "b.csv", "--json", "b.json")
        rows = list(csv.DictReader(io.StringIO((self.folder / "b.csv").read_text())))
        self.assertEqual([(row["area_error"], row["volume_error"]) for row in rows], [("", "")] * 3)
        (benchmark,) = json.loads((self.folder / "b.json").read_text())["benchmarks"]
        self.assertEqual([row["area_error"] for row in benchmark["rows"]], [None] * 3)
        self.assertEqual(benchmark["orders"][0]["area"], None)
        self.assertEqual(benchmark["orders"][0]["position"], None, "an exact surface: rounding has no order")
        for part in ("no errors of area and volume with 8, 17 samples", "coarser by 4: without the last 3, 3 and 3 samples"):
            self.assertIn(part, text)
            self.assertTrue(any(part in note for note in benchmark["notes"]), benchmark["notes"])

    def test_a_file_is_compared_with_coarser_versions_of_itself(self):
        self.write_raw("ball.raw", (33, 33, 33), lambda x, y, z: 10 - ((x - 16) ** 2 + (y - 16) ** 2 + (z - 15.7) ** 2) ** 0.5)
        raw = ("ball.raw", "--dims", "33,33,33", "--dtype", "f32", "--iso", "0", "--threads", "1", "--repeats", "1")
        run = self.convert("bench", *raw, "--methods", "mc", "--csv", "b.csv")
        self.assertIn("bench does not coarsen by 8", run.err)
        self.assertIn("the trilinear interpolant of the finest data (33)", run.text)
        rows = list(csv.DictReader(io.StringIO((self.folder / "b.csv").read_text())))
        self.assertEqual([row["size"] for row in rows], ["8", "16", "33"])
        errors = [float(row["rms_world"]) for row in rows]
        self.assertTrue(errors[0] > 2 * errors[1] > 4 * errors[2], errors)
        self.assertEqual([row["area_error"] == "" for row in rows], [False, False, True])
        self.assertIn("16", self.bench(*raw, "--coarser", "2", "--methods", "mc"))
        self.bench(*raw, "--coarser", "2", "--methods", "mc,voxels,surface-nets", "--csv", "b.csv")
        rows = list(csv.DictReader(io.StringIO((self.folder / "b.csv").read_text())))
        for row in rows:
            voxels = float(row["rms_world"] or 0) / ((33 - 1) / (int(row["size"]) - 1))
            self.assertTrue(voxels < 0.2 if row["method"] == "mc" else 0.02 < voxels < 0.5, row)

    @needs_program("gnuplot")
    def test_the_picture(self):
        name = "it's {a}_b \"c\".raw"
        self.write_raw(name, (17, 17, 17), lambda x, y, z: 6 - ((x - 8) ** 2 + (y - 8) ** 2 + (z - 7.7) ** 2) ** 0.5)
        self.bench(name, "--dims", "17,17,17", "--dtype", "f32", "--iso", "0", "--repeats", "1", "--plot", "p.svg")
        tree = xml.etree.ElementTree.parse(self.folder / "p.svg")
        text = "".join(tree.getroot().itertext())
        for part in (name, "marching cubes, 1 thread", "marching tetrahedra", "extraction, ms"):
            self.assertIn(part, text)
        self.bench("--sizes", "8", "--threads", "1", "--repeats", "1", "--plot", "p.svg")
        tree = xml.etree.ElementTree.parse(self.folder / "p.svg")
        texts = {part.strip() for part in tree.getroot().itertext()}
        self.assertGreaterEqual(len(texts & {"0.001", "0.01", "0.1", "1", "100"}), 2, texts)  # of time; "10" is error's
        self.bench(*QUICK, "--plot", "p.png")
        self.assertTrue((self.folder / "p.png").read_bytes().startswith(b"\x89PNG\r\n"))
        self.assertEqual(self.files(), sorted([name, "p.png", "p.svg"]))

    def test_without_gnuplot_a_plot_is_refused_before_the_work(self):
        environment = {**os.environ, "PATH": str(self.folder)}
        err = self.refused(3, *QUICK, "--plot", "p.svg", env=environment)
        self.assertIn("gnuplot, which is not installed", err)
        self.assertIn("apt-get install gnuplot-nox", err)
        self.assertIn("at iso 0", self.run_program("bench", *QUICK, env=environment).text)

    def test_a_gnuplot_that_fails_leaves_no_picture(self):
        program = self.folder / "gnuplot"
        program.write_text("#!/bin/sh\nread line\n[ \"$line\" = exit ] && exit 0\necho no good >&2\nexit 1\n")
        program.chmod(0o755)
        run = self.run_program("bench", *QUICK, "--plot", "p.svg",
                               env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.assertEqual(run.code, 3)
        self.assertIn("no good", run.err)
        self.assertEqual(self.files(), ["gnuplot"])

    def test_what_is_refused(self):
        self.write_raw("a.vdb", (2, 2, 2), lambda x, y, z: x)
        for arguments, part in (
                (("demo:random",), "no formula"),
                (("demo:cube",), "no demo field 'cube'"),
                (("a.vdb",), "--iso"),
                (("a.vdb", "--iso", "1", "--sizes", "8"), "--sizes"),
                (("--coarser", "2"), "--coarser"),
                (("--sizes", "32,8,x"), "--sizes: expected"),
                (("--sizes", "32,32"), "each number once"),
                (("--coarser", "3", "a.vdb", "--iso", "1"), "powers of two"),
                (("--methods", "mc,cubes"), "--methods: expected"),
                (("--threads", "0"), "--threads: expected"),
                (("--threads", "1,1024"), "found 1024"),
                (("demo:torus?size=16",), "--sizes 16"),
                (("--repeats", "0"), "--repeats: expected"),
                (("--plot", "p.pdf"), ".svg or .png"),
                (("--csv", "-"), "name of a file"),
                (("--csv", "same", "--json", "./same"), "two options name this output file"),
                (("--frobnicate",), "unknown option")):
            self.assertIn(part, self.refused(1, *arguments))
        self.assertIn("no surface at iso 9", self.refused(2, "--iso", "9", "--sizes", "16", "--repeats", "1"))
        self.assertIn("the values range from", self.refused(2, "--iso", "9", "--sizes", "16", "--repeats", "1"))
        self.refused(2, "missing.vdb", "--iso", "1")
        self.assertIn("no such file", self.refused(2, "demo:torus", "missing.npy"))
        self.refused(4, *QUICK, "--csv", "no/folder/b.csv")

    def test_a_closed_pipe_is_an_error(self):
        read_end, write_end = os.pipe()
        os.close(read_end)
        run = self.run_program("bench", *QUICK, stdout=write_end)
        os.close(write_end)
        self.assertEqual(run.code, 4)


if __name__ == "__main__":
    main()
