"""isoextract render --backend gpu: the pictures of the processor, drawn on a device; here Mesa's llvmpipe."""

import json

from support import NO_GPU, SPHERE, Png, ProgramTest, main

SIZE = ("--size", "64x48")


class RenderGpuTest(ProgramTest):
    def both(self, *arguments):
        """How far a picture from each backend is apart, in steps of 8 bits; and what the GPU's run told as JSON."""
        pictures = []
        for backend in ("cpu", "gpu"):
            name = f"{backend}.png"
            self.convert("render", *arguments, *SIZE, "--backend", backend, "--json", "told.json", "-o", name)
            pictures.append(Png((self.folder / name).read_bytes()))
        return pictures[0].difference(pictures[1]), json.loads((self.folder / "told.json").read_text())

    def test_a_volume_looks_the_same(self):
        difference, told = self.both(SPHERE)
        self.assertLessEqual(difference, 2)
        self.assertNotIn("CPU", told["device"])
        self.assertGreater(told["pictures"][0]["samples"], 1000)
        self.assertGreater(told["pictures"][0]["bricks"], 0)

    def test_a_turn_opens_the_device_once(self):
        run = self.convert("render", SPHERE, *SIZE, "--frames", "3", "--backend", "gpu", "-o", "{:02}.png")
        self.assertEqual(self.files(), ["01.png", "02.png", "03.png"])
        self.assertEqual(run.err.count("drawn in"), 3)

    def test_a_surface_in_a_volume_is_there(self):
        plain = self.convert("render", SPHERE, *SIZE, "--backend", "gpu", "-o", "plain.png")
        self.assertEqual(plain.code, 0)
        self.convert("render", SPHERE, "--iso", "0", "--opacity", "0.5", *SIZE, "--backend", "gpu", "-o", "with.png")
        apart = Png((self.folder / "plain.png").read_bytes()).difference(Png((self.folder / "with.png").read_bytes()))
        self.assertGreater(apart, 8)

    def test_smooth_edges_and_labels_look_the_same(self):
        difference, _ = self.both(SPHERE, "--tf", "none", "--iso", "0", "--antialias", "2")
        self.assertLessEqual(difference, 2)
        self.assertTrue(any(0 < pixel[3] < 255 for pixel in Png((self.folder / "gpu.png").read_bytes()).pixels()))
        self.write_raw("map.raw", (9, 9, 9), lambda x, y, z: 1 + (x > 4) if min(x, y, z) > 1 and max(x, y, z) < 7 else 0, "B")
        difference, _ = self.both("map.raw", "--dims", "9,9,9", "--dtype", "u8", "--labels", "all")
        self.assertLessEqual(difference, 2)

    def test_one_that_is_not_there_is_an_error(self):
        run = self.run_program("render", SPHERE, *SIZE, "--backend", "gpu", "-o", "a.png", env=NO_GPU)
        self.assert_fails(3, run, "--backend cpu")
        run = self.run_program("render", SPHERE, *SIZE, "--backend", "gpu", "--device", "99", "-o", "a.png")
        self.assert_fails(3, run, "99")
        self.assertEqual(self.files(), [])

    def test_without_one_auto_takes_the_processor(self):
        run = self.run_program("render", SPHERE, *SIZE, "--backend", "auto", "-v", "-o", "a.png", env=NO_GPU)
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("cpu, because", run.err)

    def test_too_little_memory_of_the_device_is_told(self):
        run = self.run_program("render", SPHERE, *SIZE, "--backend", "gpu", "--gpu-memory", "64K", "-o", "a.png")
        self.assert_fails(3, run, "--gpu-memory")
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
