"""isoextract stability: the table, its JSON, its exit codes."""

import json

from support import NO_GPU, SOURCE, ProgramTest, main


class StabilityTest(ProgramTest):
    def test_all_cases_pass_on_every_method(self):
        run = self.run_program("stability", "--json")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual([line for line in run.err.splitlines() if "gpu does not have" not in line], [])
        report = json.loads(run.text)
        self.assertTrue(report["passed"])
        names = [entry["case"] for entry in json.loads(self.run_program("stability", "--list", "--json").text)]
        self.assertEqual(names.pop(), "water")
        self.assertGreaterEqual(len(names), 30)
        self.assertEqual([(row["case"], row["method"], row["backend"]) for row in report["rows"]],
                         [(name, method, backend) for name in names for method in ("mc", "mt", "voxels", "surface-nets")
                          for backend in ("cpu", "gpu") if backend == "cpu" or method in ("mc", "mt")])
        for row in report["rows"]:
            self.assertEqual((row["passed"], row["failures"]), (True, []))
            if row["method"] in ("mc", "mt"):
                self.assertLessEqual(row["ulps"], row["ulps_allowed"])
                self.assertLessEqual(row["voxels"], row["voxels_allowed"])
            else:
                self.assertEqual((row["off_edge"], row["ulps"], row["voxels"], row["open_edges"]), (None, None, None, 0))
                self.assertTrue(any("do not lie on edges of the grid" in why for why in row["not_applicable"]), row)
        self.assertGreater(sum(row["vertices"] > 100 for row in report["rows"]), 80)

    def test_the_table_has_a_line_a_run(self):
        run = self.run_program("stability", "--case", "jump", "--case", "float-max", "--backends", "gpu:points")
        self.assertEqual((run.code, run.err), (0, ""))
        lines = run.text.splitlines()
        self.assertEqual([line.split()[0] for line in lines[1:3]], ["float-max", "jump"])
        self.assertTrue(all(line.endswith("pass") and " gpu:points " in line for line in lines[1:3]), run.text)
        self.assertEqual(lines[3:], [
            "Checked of marching cubes: finite vertices, each inside its own grid edge and at its crossing; triangles "
            "with an area, none repeated; manifold, oriented, closed with a cap", "2 of 2 passed"])

    def test_what_holds_for_each_method_is_told(self):
        text = self.run_program("stability", "--case", "jump", "--backends", "cpu").text
        self.assertEqual([line.split()[1] for line in text.splitlines()[1:5]], ["mc", "mt", "voxels", "surface-nets"])
        for method in ("voxels", "surface nets"):
            self.assertIn(f"Checked of {method}: finite vertices; triangles with an area, none repeated; manifold, oriented, "
                          "closed everywhere\n", text)
            self.assertIn(f"Not applicable: {method}: the vertices do not lie on edges of the grid\n", text)
        self.assertTrue(text.endswith("4 of 4 passed\n"), text)

    def test_water_is_kept_by_one_rule_and_not_by_the_other(self):
        rows = json.loads(self.run_program("stability", "--case", "water", "--json").text)["water"]
        self.assertEqual(len(rows), 24)
        self.assertEqual({(row["friction"], row["flow_div"]) for row in rows},
                         {(friction, flow_div) for friction in (0, 1) for flow_div in (1, 2, 3, 4)})
        for row in rows:
            self.assertEqual((row["conservative"]["failures"], row["conservative"]["steps"]), ([], 10_000))
            self.assertLessEqual(row["conservative"]["drift"], row["drift_allowed"])
            self.assertGreaterEqual(row["conservative"]["least_depth"], 0)
        self.assertGreater(sum(not row["printed"]["passed"] for row in rows), 12)
        run = self.run_program("stability", "--case", "water")
        self.assertEqual((run.code, run.err), (0, ""))
        self.assertIn("printed, as expected: ", run.text)
        self.assertIn(f"```text\n{run.text}```\n", (SOURCE / "docs/simulate.md").read_text())
        self.assertRegex(run.text.splitlines()[-1], r"water: 24 of 24 cases pass with the conservative rule, \d+ with the printed rule")

    def test_threads_do_not_matter(self):
        texts = {self.run_program("stability", "--backends", "cpu,gpu", "--threads", threads).text
                 for threads in ("1", "3")}
        self.assertEqual(len(texts), 1)

    def test_verbose_prints_times_and_memory(self):
        run = self.run_program("stability", "--case", "jump", "--backends", "cpu", "-v")
        self.assertEqual(run.code, 0, run.err)
        self.assertRegex(run.err, r"\A4 surfaces extracted and checked in [\d.]+ s\npeak memory [\d.]+ MiB\n\Z")

    def test_the_list_says_what_is_extreme(self):
        run = self.run_program("stability", "--list", "--case", "far-frame")
        self.assertEqual(run.text.splitlines()[0], "far-frame")
        self.assertIn("1e7", run.text)
        self.assertIn("Plain float32: ", run.text)

    def test_without_a_gpu_the_cpu_is_tested_and_the_rest_is_said(self):
        run = self.run_program("stability", "--case", "jump", "--json", env=NO_GPU)
        self.assertEqual(run.code, 0)
        self.assertEqual([row["backend"] for row in json.loads(run.text)["rows"]], ["cpu"] * 4)
        self.assertIn("note[backend]: stability tests no GPU, because", run.err)
        self.assert_fails(3, self.run_program("stability", "--case", "jump", "--backends", "cpu,gpu", env=NO_GPU), "EGL")

    def test_what_is_not_there(self):
        self.assert_fails(1, self.run_program("stability", "--backends", "gpu,gpu"), "--backends", "each at most once")
        self.assert_fails(1, self.run_program("stability", "--case", "flaot-max"), "flaot-max", "'float-max'")
        self.assert_fails(1, self.run_program("stability", "far-frame"), "unexpected argument", "far-frame")
        with open("/dev/full", "wb") as full:
            self.assertEqual(self.run_program("stability", "--list", stdout=full).code, 4)


if __name__ == "__main__":
    main()
