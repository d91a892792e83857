"""Far and fine: a sphere of radius 1 at 1e7 keeps the relative accuracy of one at 0, in every format that can."""

import math

from support import ProgramTest, main, read_glb, read_obj, read_ply

SIZE = 33
SPACING = 0.0625  # exact in binary, so that both spheres have the same samples
HALF = SPACING * (SIZE - 1) / 2  # 1, the radius of the ball that the samples span
FAR = (1e7, -2e7, 3e7)
DOUBLE_STEP = 4e-9  # of doubles at 3e7
FLOAT_ROUNDING = 2.0 ** -23  # of coordinates up to 2: what float32 costs, near or far


def turned(p):
    """z up to y up, as glTF wants it."""
    return (p[0], p[2], -p[1])


READERS = {"glb": lambda data: next(iter(read_glb(data).values())), "ply": read_ply, "obj": read_obj}


class FarTest(ProgramTest):
    def sphere(self, center, form, *options, ascii_text=False):
        """The mesh of a sphere around `center`, as the tests' own parser reads it."""
        origin = ",".join(repr(c - HALF) for c in center)
        extra = ("--ascii",) if ascii_text else ()
        name = f"sphere.{form}"
        self.convert(f"demo:sphere?size={SIZE}", "--iso", "0", "--spacing", SPACING, f"--origin={origin}", "-o", name,
                     "-q", *options, *extra)
        return READERS[form]((self.folder / name).read_bytes())

    def assert_same_up_to_a_move(self, near, far, move, scale=1.0):
        self.assertEqual(near.triangles, far.triangles)
        allowed = 2 * (FLOAT_ROUNDING + DOUBLE_STEP) * scale
        worst = max(abs(b[axis] - move[axis] - a[axis])
                    for a, b in zip(near.vertices, far.vertices) for axis in range(3))
        self.assertLessEqual(worst, allowed)

    def radii(self, mesh, center):
        return [math.dist(vertex, center) for vertex in mesh.vertices]

    def test_every_format_keeps_the_accuracy(self):
        for form, ascii_text in (("glb", False), ("ply", False), ("ply", True), ("obj", False)):
            with self.subTest(form=form, ascii=ascii_text):
                near = self.sphere((0.0, 0.0, 0.0), form, ascii_text=ascii_text)
                far = self.sphere(FAR, form, ascii_text=ascii_text)
                center = turned(FAR) if form == "glb" else FAR
                self.assert_same_up_to_a_move(near, far, center)
                # And as spheres: the spread of the radii is that of the sampling, near and far.
                near_radii, far_radii = self.radii(near, (0, 0, 0)), self.radii(far, center)
                self.assertAlmostEqual(min(near_radii), min(far_radii), delta=1e-6)
                self.assertAlmostEqual(max(near_radii), max(far_radii), delta=1e-6)

    def test_up_scale_and_unit_keep_it(self):
        for options, scale in ((("--up", "z"), 1.0), (("--up", "y"), 1.0), (("--scale", "3.7"), 3.7),
                               (("--unit", "mm", "--to-unit", "m"), 1e-3), (("--scale", "1e-4", "--up", "y"), 1e-4)):
            for form in ("glb", "ply", "obj"):
                with self.subTest(form=form, options=options):
                    near = self.sphere((0.0, 0.0, 0.0), form, *(o for o in options if form == "glb" or o not in
                                                                ("--up", "y", "z")))
                    far = self.sphere(FAR, form, *(o for o in options if form == "glb" or o not in ("--up", "y", "z")))
                    is_turned = form == "glb" and "y" not in options
                    center = [scale * c for c in (turned(FAR) if is_turned else FAR)]
                    self.assert_same_up_to_a_move(near, far, center, scale)

    def test_neighboring_vertices_stay_apart(self):
        # A spacing of 1e-5 at 1e7, a few thousand steps of double: float32 has steps of 1 there.
        for form in ("glb", "ply", "obj"):
            origin = ",".join(repr(c) for c in FAR)
            name = f"fine.{form}"
            self.convert(f"demo:sphere?size={SIZE}", "--iso", "0", "--spacing", "1e-5", f"--origin={origin}", "-o", name)
            mesh = READERS[form]((self.folder / name).read_bytes())
            self.assertEqual(len(set(mesh.vertices)), len(mesh.vertices))
            self.assertEqual(mesh.open_edges(), 0)
            low, high = mesh.bounds()
            for axis in range(3):
                self.assertTrue(1e-5 * 10 < high[axis] - low[axis] < 1e-5 * SIZE, (low, high))

    def test_what_the_numbers_of_a_format_would_destroy_is_refused(self):
        """Float32 at 1e7 has steps of 1 and double at 1e16 steps of 2, where the voxels are 0.0625 wide."""

        def refused(origin, name, *hints):
            run = self.run_program(f"demo:sphere?size={SIZE}", "--iso", "0", "--spacing", SPACING,
                                   f"--origin={origin}", "-o", name)
            self.assert_fails(4, run, f"{name}: expected ", "--origin X,Y,Z or --space index", *hints)
            self.assertEqual(self.files(), [])

        refused("1e7,-2e7,3e7", "a.stl", "hint: use --format glb, gltf, ply, obj; use --center, ")
        for origin in ("1e16,0,0", "0,1e17,0", "0,0,-1e40", "1e300,0,0", "1e300,1e300,1e300"):
            for form in ("glb", "gltf", "ply", "obj", "stl"):
                with self.subTest(origin=origin, form=form):
                    run = self.run_program(f"demo:sphere?size={SIZE}", "--iso", "0", "--spacing", SPACING,
                                           f"--origin={origin}", "-o", f"a.{form}")
                    self.assertNotEqual(run.code, 0)
                    self.assertTrue(run.err.startswith("isoextract: error: "), run.err)
                    self.assertIn("  hint: ", run.err)
                    self.assertEqual(self.files(), [])
        refused("1e16,0,0", "a.ply", "to place the volume nearer to the origin")
        refused("0,0,-1e40", "a.glb", "float32")

    def test_scans_in_millimetres_are_written_in_every_format(self):
        """Voxels of 0.1 at 1000, and at 100 000 they are still there."""
        for far in (1000, 10000, 100000):
            for form in ("glb", "gltf", "ply", "obj", "stl"):
                self.convert(f"demo:torus?size={SIZE}", "--iso", "0", "--spacing", "0.1",
                             f"--origin=-{far},{far},{far}", "-o", f"a.{form}")


if __name__ == "__main__":
    main()
