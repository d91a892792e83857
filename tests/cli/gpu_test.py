"""--backend, --device, --gpu-memory, --verify and the devices: what is captured on a GPU is what the CPU extracts."""

import json
import random

from support import NO_GPU, SOURCE, SPHERE, ProgramTest, main


class GpuTest(ProgramTest):
    def report(self, *arguments):
        self.convert(*arguments, "--report", "report.json")
        return json.loads((self.folder / "report.json").read_text())

    def test_devices_are_listed(self):
        run = self.run_program("devices", "--json")
        self.assertEqual((run.code, run.err), (0, ""))
        devices = json.loads(run.text)
        self.assertEqual([device["index"] for device in devices], list(range(len(devices))))
        self.assertTrue(any(device["usable"] for device in devices))
        first = next(device for device in devices if device["usable"])
        self.assertRegex(first["version"], r"^4\.[3-9]")
        table = self.run_program("devices").text
        self.assertIn(f"{first['index']}  {first['renderer']}\n", table)

    def test_both_methods_verify(self):
        for method in ("mc", "mt"):
            report = self.report("demo:gyroid?size=40", "--iso", 0.2, "--method", method, "--cap", "--backend", "gpu",
                                 "--verify", "-o", f"{method}.glb")
            self.assertEqual(report["device"]["backend"], "gpu")
            self.assertGreater(report["bytes"]["uploaded"], 40**3 * 4 // 2)
            verification, = report["verification"]
            self.assertTrue(verification["passed"])
            self.assertEqual(verification["triangles_only"], [0, 0])
            self.assertLessEqual(verification["ulps"], 2)
            self.assertIn("upload", [stage["stage"] for stage in report["stages"]])

    def test_a_written_mesh_verifies_against_the_cpu(self):
        self.convert("demo:torus?size=48", "--iso", 0, "--backend", "gpu", "-o", "torus.ply")
        run = self.run_program("verify", "demo:torus?size=48", "--iso", 0, "torus.ply")
        self.assertEqual(run.code, 0, run.err)

    def test_memory_does_not_change_the_bytes(self):
        whole = ("demo:gyroid?size=72", "--iso", 0, "--backend", "gpu", "--explain")
        self.convert(*whole, "-o", "whole.glb")
        run = self.convert(*whole, "--gpu-memory", "1M", "-o", "slabs.glb")
        self.assertEqual((self.folder / "whole.glb").read_bytes(), (self.folder / "slabs.glb").read_bytes())
        self.assertIn(f"to upload {72**3 * 4 / 2**20:.2f} MiB", run.err)

    def test_a_batch_draws_what_conversions_of_their_own_do(self):
        pattern = "demo:sphere?size=32&time=0.{:02}"
        frames = (0, 10, 20, 30)
        for frame in frames:
            self.convert(pattern.format(frame), "--iso", 0, "--backend", "gpu", "-o", f"one_{frame:02}.glb")
        for jobs in (1, 2):
            self.convert(pattern, "--frames", "0-30x10", "--iso", 0, "--backend", "gpu", "--jobs", jobs, "--verify",
                         "-o", f"{jobs}/{{:02}}.glb", "--mkdir")
            for frame in frames:
                self.assertEqual((self.folder / f"{jobs}/{frame:02}.glb").read_bytes(),
                                 (self.folder / f"one_{frame:02}.glb").read_bytes(), (jobs, frame))

    def test_frames_upload_the_bricks_that_changed(self):
        samples = bytearray(random.Random(5).randbytes(32**3))
        for frame, changed in enumerate((None, None, 32 * 32 * 12 + 32 * 12 + 12)):
            if changed is not None:
                samples[changed] ^= 1
            (self.folder / f"in_{frame}.raw").write_bytes(samples)
        self.convert("in_{}.raw", "--dims", "32,32,32", "--iso", 127.5, "--backend", "gpu", "--jobs", 1, "-o", "out/{}.ply",
                     "--mkdir", "--report", "r_{frame}.json")
        for frame, uploaded in enumerate((64, 0, 1)):
            report = json.loads((self.folder / f"r_{frame}.json").read_text())
            resident, = (fact for fact in report["extractions"][0]["work"] if fact["what"] == "resident")
            self.assertEqual((resident["count"], resident["total"]), (64 - uploaded, 64))
            self.assertEqual(report["bytes"]["uploaded"], 512 * uploaded)
            self.convert(f"in_{frame}.raw", "--dims", "32,32,32", "--iso", 127.5, "--backend", "gpu", "-o", "one.ply")
            self.assertEqual((self.folder / "one.ply").read_bytes(), (self.folder / f"out/{frame}.ply").read_bytes())

    def test_surfaces_of_one_field_share_what_was_uploaded(self):
        run = self.convert("demo:gyroid?size=40", "--iso", 0, "--iso", 0.1, "--backend", "gpu", "--explain", "-o", "two.glb")
        self.assertIn("uploads of 0 of 216 bricks", run.err)
        self.assertIn("uploads of 216 of 216 bricks (8x8x8 samples), which the device has", run.err)
        for iso in (0, 0.1):
            one = self.convert("demo:gyroid?size=40", "--iso", iso, "--backend", "gpu", "--explain", "-o", "one.glb")
            self.assertNotIn("uploads of", one.err)

    def test_a_batch_without_a_gpu(self):
        batch = ("demo:sphere?size=16&time=0.{}", "--frames", "0-2", "--iso", 0, "-o", "{}.glb", "--backend")
        # One job at a time: of several frames that fail for one reason, the program names the first to fail.
        failed = self.run_program(*batch, "gpu", "--jobs", 1, env=NO_GPU)
        self.assert_fails(5, failed, "frame 0: ", "EGL", "3 of 3 frames failed")
        self.assertEqual([name for name in self.files() if name.endswith(".glb")], [])
        self.assertEqual(self.run_program(*batch, "auto", env=NO_GPU).code, 0)
        for frame in range(3):
            self.convert(f"demo:sphere?size=16&time=0.{frame}", "--iso", 0, "-o", "one.glb")
            self.assertEqual((self.folder / f"{frame}.glb").read_bytes(), (self.folder / "one.glb").read_bytes())

    def test_sparse_grids_upload_leaves(self):
        report = self.report(SOURCE / "samples" / "metaballs.vdb", "--iso", 0.5, "--backend", "gpu", "--verify", "-o", "m.glb")
        self.assertTrue(report["verification"][0]["passed"])
        uploaded = report["bytes"]["uploaded"]
        self.assertEqual(uploaded % (512 * 2), 0, "whole leaves")
        box = report["input"]["box"]
        voxels = 1
        for low, high in zip(box["min"], box["max"]):
            voxels *= high - low + 1
        self.assertLess(uploaded, 4 * voxels)

    def test_verify_compares_the_backends(self):
        run = self.run_program("verify", SPHERE, "--iso", 0, "--json")
        self.assertEqual(run.code, 0, run.err)
        self.assertTrue(json.loads(run.text)["passed"])

    def test_without_a_gpu(self):
        asked = self.run_program(SPHERE, "--iso", 0, "--backend", "gpu", "-o", "s.glb", env=NO_GPU)
        self.assert_fails(3, asked, "EGL", "--backend cpu")
        self.assertFalse((self.folder / "s.glb").exists())
        automatic = self.run_program(SPHERE, "--iso", 0, "--backend", "auto", "-o", "s.glb", "--report", "r.json",
                                     env=NO_GPU)
        self.assertEqual(automatic.code, 0)
        note = json.loads((self.folder / "r.json").read_text())["notes"][0]
        self.assertIn("backend: cpu, because", note["text"])
        self.assertIn(f"note[{note['id']}]: {note['text']}\n", automatic.err)
        self.assertTrue((self.folder / "s.glb").exists())
        self.assert_fails(3, self.run_program("devices", env=NO_GPU), "EGL")
        self.assert_fails(3, self.run_program("verify", SPHERE, "--iso", 0, env=NO_GPU), "EGL")
        self.assert_fails(3, self.run_program(SPHERE, "--iso", 0, "--verify", "-o", "v.glb", env=NO_GPU), "EGL")
        self.assertFalse((self.folder / "v.glb").exists())

    def test_a_library_that_is_none_is_a_message(self):
        (self.folder / "libEGL.so.1").write_text("no library")
        environment = dict(NO_GPU, LD_LIBRARY_PATH=str(self.folder))
        run = self.run_program(SPHERE, "--iso", 0, "--backend", "gpu", "-o", "s.glb", env=environment)
        self.assert_fails(3, run, "EGL failed to load", "libegl1")

    def test_options_that_make_no_sense(self):
        convert = (SPHERE, "--iso", 0, "-o", "s.glb")
        self.assert_fails(1, self.run_program(*convert, "--device", 0), "--device", "--backend gpu")
        self.assert_fails(1, self.run_program(*convert, "--gpu-memory", "1G"), "--gpu-memory", "--backend gpu")
        self.assert_fails(1, self.run_program(*convert, "--backend", "gpu", "--gpu-memory", "9"), "--gpu-memory")
        self.assert_fails(1, self.run_program(*convert, "--backend", "cuda"), "--backend", "cpu, gpu, auto")
        self.assert_fails(1, self.run_program(*convert, "--backend", "gpu", "--device", "cuda:x"), "cuda:")
        self.assert_fails(3, self.run_program(*convert, "--backend", "gpu", "--device", 99), "no device 99", "devices")
        self.assert_fails(3, self.run_program(*convert, "--backend", "gpu", "--device", "no such"), "no such")

    def test_bench_times_the_pipelines(self):
        run = self.run_program("bench", "demo:sphere", "--sizes", "8,16", "--repeats", 1, "--threads", 1,
                               "--backends", "cpu,gpu,gpu:points,gpu:rows", "--json", "bench.json")
        self.assertEqual(run.code, 0, run.err)
        rows = json.loads((self.folder / "bench.json").read_text())["benchmarks"][0]["rows"]
        self.assertEqual([(row["method"], row["backend"]) for row in rows if row["size"] == "16"],
                         [("mc", "cpu"), ("mc", "gpu"), ("mc", "gpu:points"), ("mc", "gpu:rows"),
                          ("mt", "cpu"), ("mt", "gpu"), ("mt", "gpu:rows")])
        self.assertEqual(len({row["triangles"] for row in rows if row["size"] == "16" and row["method"] == "mc"}), 1)
        self.assertEqual([row["device"] is None for row in rows[:2]], [True, False])
        self.assertIn("cells/s", run.text)

    def test_bench_gpu_threads(self):
        run = self.run_program("bench", "gpu-threads", "--sizes", "8,20,66,67", "--repeats", 1, "--json", "threads.json")
        self.assertEqual(run.code, 0, run.err)
        levels = json.loads((self.folder / "threads.json").read_text())["gpu_threads"]
        self.assertEqual([level["size"] for level in levels], [8, 20, 66, 67])
        self.assertEqual([maker for level in levels for maker in level["makers"] if "problem" in maker], [])
        dummy = next(maker for maker in levels[1]["makers"] if maker["threads_by"] == "dummy vertices")
        self.assertEqual(dummy["vertex_bytes"], 4 * 20**3)
        self.assert_fails(1, self.run_program("bench", "gpu-threads", "--iso", 1), "gpu-threads", "--iso")
        self.assert_fails(1, self.run_program("bench", "gpu-threads", "demo:torus"), "gpu-threads", "no other input")


if __name__ == "__main__":
    main()
