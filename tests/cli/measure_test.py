"""scripts/measure with the program: trial runs of what needs no other program, and the pages that come of them. What a dry
run tells of memory, against the measured peak."""

import json
import os
import subprocess
import sys

from support import PROGRAM, SOURCE, ProgramTest, main, needs_program


class MeasureTest(ProgramTest):
    def measure(self, *names):
        command = [sys.executable, SOURCE / "scripts" / "measure", "run", *names, "--quick", "--isoextract", PROGRAM,
                   "--bench", self.folder, "--folder", self.folder / "measured"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        records = {}
        for name in names:
            records[name] = json.loads((self.folder / "measured" / f"{name}.json").read_text())
            self.assertEqual((records[name]["measurement"], records[name]["quick"]), (name, True))
            self.assertIn("trial run", (self.folder / "measured" / f"{name}.md").read_text())
        return records

    def test_stability_and_simplify(self):
        records = self.measure("stability", "simplify")
        cases = records["stability"]["figures"]["cases"]
        self.assertEqual([case["case"] for case in cases], ["jump", "mirrored"])
        for case in cases:
            self.assertEqual(case["passed"], case["runs"])
            self.assertGreater(len(case["extreme"]), 10)
        self.assertTrue(cases[1]["plain"].startswith("survives"))
        for row in records["simplify"]["figures"]["rows"]:
            self.assertLess(row["after"], row["before"])
            self.assertLessEqual(row["measured_voxels"]["upper"], 0.1)

    def peak_mebibytes(self, arguments):
        with open(os.devnull, "wb") as nothing:
            process = subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stderr=nothing)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = status
        self.assertEqual(status, 0, arguments)
        return usage.ru_maxrss / 1024

    def test_a_dry_run_tells_the_memory_of_what_is_done_with_the_mesh(self):
        for size in (64, 96):
            for options in ((), ("--simplify", "0.1"), ("--triangles", "5%"), ("--triangles", "90%"), ("--draco",), ("--quantize",), ("--error",),
                            ("--simplify", "0.1", "--error"), ("--simplify", "0.1", "--draco")):
                arguments = [f"demo:gyroid?size={size}&time=0.{{:02}}", "--frames", "1-1", "--iso", "0", "--threads", "1",
                             "-o", "m{}.glb", *options]
                told = self.told_mib(*arguments)
                peak = self.peak_mebibytes(arguments)
                self.assertTrue(peak <= told <= 2 * peak, (size, options, told, peak))

    @needs_program("gnuplot")
    def test_error(self):
        figures = self.measure("error")["error"]["figures"]
        measured = [row for row in figures["benchmark"]["rows"] if "cold_ms" in row]
        self.assertEqual({(row["method"], row["size"]) for row in measured},
                         {(method, size) for method in ("mc", "mt") for size in ("16", "32")})
        for row in measured:
            self.assertEqual(len(row["cold_ms"]), 3)
            self.assertGreater(min(row["cold_ms"]), 0)
        self.assertEqual(figures["plot"]["file"], "error-time.svg")
        self.assertIn("<svg", (self.folder / "measured" / "error-time.svg").read_text())

    def test_gpu(self):
        figures = self.measure("gpu")["gpu"]["figures"]
        self.assertEqual(sorted(figures["fields"]), ["gyroid", "sphere"])
        for rows in figures["fields"].values():
            cold = {(row["method"], row["backend"]): row.get("cold_ms") for row in rows}
            self.assertEqual({key for key, times in cold.items() if times},
                             {(method, backend) for method in ("mc", "mt") for backend in ("cpu", "gpu")})
            self.assertEqual(len(cold), 6)
        self.assertEqual([level["size"] for level in figures["creation"]["gpu_threads"]], [16, 32])

    def test_sequences(self):
        figures = self.measure("sequences")["sequences"]["figures"]
        rows = figures["demo"]["rows"]
        self.assertEqual(len(rows), 4)
        self.assertEqual({(row["frames"], row["bytes"]) for row in rows}, {(6, rows[0]["bytes"])})
        self.assertEqual(rows[0]["wall_first_to_this"], 1)
        if figures["vdb"]:  # with the data and vdb_tool
            ours, loop, *theirs = (row["triangles"] for row in figures["vdb"]["rows"])
            self.assertEqual(ours, loop)
            for triangles in theirs:
                self.assertLess(abs(triangles - ours), 0.01 * ours)
        tiny = figures["tiny"]
        self.assertEqual(tiny["frames"], 300)
        self.assertLess(tiny["last_resident"]["median"], 1.5 * tiny["first_resident"]["median"])
        self.assertLess(tiny["last_files"]["max"], 20)


if __name__ == "__main__":
    main()
