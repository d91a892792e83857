"""isoextract render: pictures of volumes, surfaces and meshes, as files and on stdout."""

import json
import math
import struct

from support import NO_GPU, SPHERE, Png, ProgramTest, main
from vdb_files import grid, vdb

SMALL = ("--size", "48x32", "--backend", "cpu")


def exr_channels(data):
    """Names and types (1 is half, 2 is float) of the channels of an OpenEXR file."""
    assert data[:4] == b"\x76\x2f\x31\x01"
    at = data.index(b"channels\0chlist\0") + len(b"channels\0chlist\0") + 4
    channels = {}
    while data[at]:
        end = data.index(b"\0", at)
        channels[data[at:end].decode()] = struct.unpack("<i", data[end + 1 : end + 5])[0]
        at = end + 17
    return channels


class RenderTest(ProgramTest):
    def picture(self, *arguments, name="out.png"):
        self.convert("render", *arguments, *SMALL, "-o", name)
        return Png((self.folder / name).read_bytes())

    def test_a_volume(self):
        run = self.convert("render", SPHERE, *SMALL, "-o", "out.png")
        self.assertRegex(run.err, r"demo:sphere\?size=24 -> out.png: 48 x 32 pixels; drawn in [0-9.]+ s\n")
        self.assertEqual(self.files(), ["out.png"])
        picture = Png((self.folder / "out.png").read_bytes())
        self.assertEqual(picture.shape, (32, 48, 4))
        self.assertEqual(picture.pixel(0, 0), (0, 0, 0, 0))
        self.assertGreater(picture.pixel(24, 16)[3], 40)
        self.convert("render", SPHERE, *SMALL)
        self.assertEqual(self.files(), ["out.png", "sphere.png"])
        self.assertEqual((self.folder / "sphere.png").read_bytes(), (self.folder / "out.png").read_bytes())

    def test_threads_and_shortcuts_change_nothing(self):
        usual = self.picture("demo:gyroid?size=40", "--termination", "0")
        for options in (("--threads", "1"), ("--no-skipping",)):
            self.assertEqual(self.picture("demo:gyroid?size=40", "--termination", "0", *options).difference(usual), 0, options)
        ended = self.picture("demo:gyroid?size=40")
        self.assertLessEqual(ended.difference(usual), 8)

    def test_stdout(self):
        run = self.convert("render", SPHERE, *SMALL, "-o", "-")
        self.assertEqual(Png(run.out).shape, (32, 48, 4))
        self.assertEqual(self.files(), [])

    def test_meshes_alone_and_with_surfaces(self):
        self.convert(SPHERE, "--iso", "0", "-o", "sphere.ply")
        self.convert(SPHERE, "--iso", "0", "-o", "sphere.glb")
        surface = self.picture(SPHERE, "--tf", "none", "--iso", "0", "--background", "black")
        self.assertEqual(surface.shape, (32, 48, 3))
        self.assertGreater(min(surface.pixel(24, 16)), 100)
        # The mesh's box and the field's differ, and with them the camera's distance. Turned back from y up, the mesh of the
        # glb is where the other is.
        ply, glb = (self.picture(mesh, "--background", "black") for mesh in ("sphere.ply", "sphere.glb"))
        self.assertGreater(min(ply.pixel(24, 16)), 100)
        self.assertLessEqual(ply.difference(glb), 3)
        both = self.picture(SPHERE, "sphere.ply", "--opacity", "0.5", "--shading", "flat")
        self.assertEqual(both.shape, (32, 48, 4))

    def test_stdin_is_a_mesh_or_a_volume(self):
        for extension in ("glb", "ply", "obj", "stl", "drc"):
            name = f"ball.{extension}"
            self.convert(SPHERE, "--iso", 0, "-o", name)
            self.picture(name)
            expected = (self.folder / "out.png").read_bytes()
            with (self.folder / name).open("rb") as file:
                run = self.convert("render", "-", *SMALL, "-o", "piped.png", stdin=file)
            self.assertIn("standard input -> piped.png: ", run.err)
            self.assertEqual((self.folder / "piped.png").read_bytes(), expected, name)
        volume = self.write_raw("v.raw", (12, 12, 12), lambda x, y, z: x - 5.5)
        described = ("--dims", "12,12,12", "--dtype", "f32")
        self.picture("v.raw", *described, name="v.png")
        with volume.open("rb") as file:
            self.convert("render", "-", *described, *SMALL, "-o", "piped.png", stdin=file)
        self.assertEqual((self.folder / "piped.png").read_bytes(), (self.folder / "v.png").read_bytes())
        with (self.folder / "ball.glb").open("rb") as file:
            self.convert("render", "v.raw", "-", *described, *SMALL, "-o", "both.png", stdin=file)
        self.assertNotEqual((self.folder / "both.png").read_bytes(), (self.folder / "v.png").read_bytes())

    def test_colors_and_opacity_of_surfaces(self):
        options = ("--tf", "none", "--iso", "-0.2", "--iso", "0.2", "--color-by", "iso")
        seen = self.picture("demo:sphere?size=24", *options)
        middle = seen.pixel(24, 16)
        self.assertGreater(max(middle[:3]) - min(middle[:3]), 30)
        opaque = self.picture("demo:sphere?size=24", *options, "--opacity", "1")
        self.assertGreater(max(abs(a - b) for a, b in zip(opaque.pixel(24, 16), middle)), 10)

    def test_edges_of_surfaces_are_smooth(self):
        for mesh in (False, True):
            if mesh:
                self.convert(SPHERE, "--iso", "0", "-o", "ball.glb")
            scene = ("ball.glb",) if mesh else (SPHERE, "--tf", "none", "--iso", "0")
            usual, twice, hard = (self.picture(*scene, *rays) for rays in ((), ("--antialias", "2"), ("--antialias", "1")))
            self.assertEqual(usual.difference(twice), 0)
            self.assertEqual({pixel[3] for pixel in hard.pixels()}, {0, 255})
            between = [pixel[3] for pixel in usual.pixels() if 0 < pixel[3] < 255]
            # Four rays a pixel: quarters, along the whole silhouette.
            self.assertLessEqual(set(between), {63, 64, 127, 128, 191, 192})
            self.assertGreater(len(between), 20)
            # The area covered stays the same.
            covered = [sum(pixel[3] for pixel in picture.pixels()) / 255 for picture in (usual, hard)]
            self.assertAlmostEqual(covered[0] / covered[1], 1, delta=0.05)
        finer = self.picture(SPHERE, "--tf", "none", "--iso", "0", "--antialias", "4")
        self.assertGreater(len({pixel[3] for pixel in finer.pixels()}), 6)
        volume = self.picture(SPHERE)
        self.assertEqual(volume.difference(self.picture(SPHERE, "--antialias", "1")), 0)

    def test_labels_have_their_colors(self):
        """The labels' surfaces as in -o x.png: a label in the middle of the picture, in the color of the table."""
        self.write_raw("map.raw", (15, 9, 9), lambda x, y, z: 1 + x // 5 if 2 <= y < 7 and 2 <= z < 7 and x % 5 else 0, "B")
        (self.folder / "lut.txt").write_text("1 Left 255 0 0 0\n2 Middle 0 200 0 0\n3 Right 0 0 255 0\n")
        arguments = ("map.raw", "--dims", "15,9,9", "--dtype", "u8", "--label-names", "lut.txt")
        view = ("--size", "64x40", "--camera", "0,0")

        def colors(command, labels, *more):
            self.convert(*command, *arguments, "--labels", labels, *view, *more, "-o", "a.png")
            png = Png((self.folder / "a.png").read_bytes())
            found = []
            for pixel in (png.pixel(x, 20) for x in range(64)):
                strong = max(range(3), key=lambda i: pixel[i])
                rest = max(pixel[i] for i in range(3) if i != strong)
                if pixel[strong] > 60 and pixel[strong] > 2 * rest and (not found or found[-1] != strong):
                    found.append(strong)
            return found

        for command in (("render",), ()):
            self.assertEqual(colors(command, "1-40"), [0, 1, 2], command)
            self.assertEqual(colors(command, "Left,3"), [0, 2], command)
            self.assertEqual(colors(command, "all", "--method", "voxels"), [0, 1, 2], command)
        self.assertEqual(colors(("render",), "all", "--opacity", "0.9"), [0, 1, 2])
        # Numbers of labels are no densities: without --tf only the surfaces are drawn.
        labels = self.picture(*arguments, "--labels", "2", name="a.png")
        alone = self.picture(*arguments, "--labels", "2", "--tf", "none", name="b.png")
        self.assertEqual(labels.difference(alone), 0)
        gray = self.picture(*arguments, "--labels", "2", "--tf", "gray", name="c.png")
        self.assertGreater(labels.difference(gray), 10)
        old_name = self.picture(*arguments, "--labels", "2", "--tf", "grey", name="d.png")
        self.assertEqual(gray.difference(old_name), 0)

    def test_materials_of_meshes_are_seen(self):
        """A glb with two labels in the colors of a table; a contact sheet shows them, too."""
        self.write_raw("map.raw", (11, 7, 7), lambda x, y, z: 1 + x // 6 if 1 <= y < 6 and 1 <= z < 6 and x % 6 else 0, "B")
        (self.folder / "lut.txt").write_text("1 Left 255 0 0 0\n2 Right 0 0 255 0\n")
        arguments = ("map.raw", "--dims", "11,7,7", "--dtype", "u8", "--label-names", "lut.txt", "--labels")
        view = ("--camera", "0,0", "--size", "64x40")
        self.convert(*arguments, "all", "-o", "two.glb", "--contact-sheet", "sheet.png", *view)
        self.convert(*arguments, "2", "-o", "one.glb")
        self.convert(*arguments, "2", "-o", "one.ply")
        self.convert(*arguments, "all", "--opacity", "0.25", "-o", "faint.glb")

        def strong(pixel):
            return [i for i in range(3) if pixel[i] > 60 and pixel[i] > 2 * max(pixel[j] for j in range(3) if j != i)]

        two = self.picture("two.glb", "--camera", "0,0")
        self.assertEqual((strong(two.pixel(14, 16)), strong(two.pixel(33, 16))), ([0], [2]))
        sheet = Png((self.folder / "sheet.png").read_bytes())
        self.assertEqual((strong(sheet.pixel(4 + 20, 4 + 12)), strong(sheet.pixel(4 + 44, 4 + 12))), ([0], [2]))
        for name in ("one.glb", "one.ply"):
            self.assertEqual(strong(self.picture(name, "--camera", "0,0").pixel(24, 16)), [2], name)
        green = self.picture("two.glb", "--camera", "0,0", "--mesh-color", "00ff00")
        self.assertEqual((strong(green.pixel(14, 16)), strong(green.pixel(33, 16))), ([1], [1]))
        # Front and back of a surface of opacity 1/4 leave (3/4)^2 of the light.
        faint = self.picture("faint.glb", "--camera", "0,0")
        self.assertAlmostEqual(faint.pixel(33, 16)[3] / 255, 1 - 0.75**2, delta=0.02)
        self.assertEqual(strong(faint.pixel(33, 16)), [2])

    def test_label_maps_and_masks_are_told(self):
        self.write_raw("map.raw", (20, 20, 20), lambda x, y, z: 1 + x // 7 if min(x, y, z) > 3 and max(x, y, z) < 17 else 0, "B")
        self.write_raw("mask.raw", (20, 20, 20), lambda x, y, z: 1 if min(x, y, z) > 3 and max(x, y, z) < 17 else 0, "B")
        shape = ("--dims", "20,20,20", "--dtype", "u8", *SMALL, "-o", "a.png")
        note = "note[iso-of-labels]: "
        for name, options, words in (("map.raw", (), "--labels all draws the surface of each label"),
                                     ("map.raw", ("--iso", "0.5"), "--labels all makes a mesh of each label"),
                                     ("mask.raw", ("--iso", "0.5"), "--method surface-nets makes a smooth one"),
                                     ("mask.raw", (), None), ("map.raw", ("--labels", "all"), None)):
            run = self.convert("render", name, *options, *shape)
            self.assertEqual(run.err.count(note), 1 if words else 0, (name, options))
            self.assertIn(words or "", run.err)

    def test_the_camera_frames_what_is_visible(self):
        """A ball in a corner fills the picture; a voxel far from it, as of noise, changes nothing."""
        def ball(x, y, z):
            return 9 if math.dist((x, y, z), (12, 12, 12)) < 8 or (x, y, z) == (38, 38, 38) else 0
        for name in ("b_1.raw", "b_2.raw"):
            self.write_raw(name, (40, 40, 40), ball, "B")
        shape = ("--dims", "40,40,40", "--dtype", "u8", "--camera", "0,0", "--json", "a.json")
        picture = self.picture("b_1.raw", *shape)
        (told,) = json.loads((self.folder / "a.json").read_text())["pictures"]
        for at in told["camera"]["target"]:
            self.assertAlmostEqual(at, 12, delta=0.6)
        self.assertGreater(picture.alpha(), 0.25)  # of a picture whose height is 2/3 of its width
        # The planes of the camera enclose all of the volume.
        self.assertGreater(told["camera"]["far"] - math.dist(told["camera"]["eye"], told["camera"]["target"]), 26 * 3**0.5)
        # Later frames of a sequence may show more: it frames the whole volume.
        self.convert("render", "b_{}.raw", *shape, *SMALL, "-o", "p_{}.png")
        told = json.loads((self.folder / "a.json").read_text())["pictures"][0]
        for at in told["camera"]["target"]:
            self.assertAlmostEqual(at, 19.5, delta=1e-9)

    def test_the_usual_range_leaves_out_noise(self):
        """A bright block in values around 100, of which more than half are noise: the corner is transparent."""
        state = [1]

        def noisy(x, y, z):
            state[0] = state[0] * 1103515245 + 12345 & 0x7fffffff
            return 100 + state[0] // 65536 % 11 - 5 + (100 if max(abs(x - 10), abs(y - 10), abs(z - 10)) < 5 else 0)
        self.write_raw("n.raw", (20, 20, 20), noisy, "B")
        view = ("n.raw", "--dims", "20,20,20", "--dtype", "u8", "--camera", "0,0,60", "--look-at", "10,10,10")
        usual = self.picture(*view)
        everything = self.picture(*view, "--tf-range", "94,206")
        self.assertGreater(usual.pixel(24, 16)[3], 60)
        self.assertLessEqual(usual.pixel(24 + 6, 16)[3], 2)
        self.assertGreater(everything.pixel(24 + 6, 16)[3], 10)

    def test_blackbody_colors_follow_the_temperature(self):
        """Slabs of 1050, 2000 and 3000 K: from dark red to light orange."""
        self.write_raw("t.raw", (12, 6, 6), lambda x, y, z: (1050, 2000, 3000)[x // 4])
        picture = self.picture("t.raw", "--dims", "12,6,6", "--dtype", "f32", "--tf", "blackbody", "--tf-range", "1000,3000",
                               "--unit-length", "0.02", "--camera", "0,0,16", "--background", "black", "--look-at", "5.5,2.5,2.5")
        cold, warm, hot = (picture.pixel(x, 16) for x in (15, 24, 33))
        for red, green, blue in (cold, warm, hot):
            self.assertGreater(red, green)
            self.assertGreaterEqual(green, blue)
        self.assertLess(cold[0], warm[0])
        self.assertLess(warm[0], hot[0])
        self.assertEqual(cold[2], 0)
        self.assertGreater(hot[2], 70)

    def test_particles_inside_of_their_surface_are_seen(self):
        spots = "".join(f"{x} {y} {z}\n" for z in range(6) for y in range(6) for x in range(6))
        (self.folder / "block.xyz").write_text(f"216\nblock\n{spots}")
        options = ("--particles", "sph", "--radius", "0.6", "--tf", "smoke", "--unit-length", "4", "--antialias", "1",
                   "--camera", "35,20,14", "--look-at", "2.5,2.5,2.5")
        alone = self.picture("block.xyz", *options, name="alone.png")
        self.assertGreater(alone.pixel(24, 16)[3], 40)
        # Next to nothing of a surface: what is seen is the volume, without a hole where the surface asks for no samples.
        both = self.picture("block.xyz", *options, "--iso", "0.5", "--opacity", "0.001")
        self.assertLessEqual(both.difference(alone), 5)

    def test_exr(self):
        self.convert("render", SPHERE, "--iso", "0", *SMALL, "-o", "out.exr")
        channels = exr_channels((self.folder / "out.exr").read_bytes())
        self.assertEqual(channels, {"A": 1, "B": 1, "G": 1, "N.X": 1, "N.Y": 1, "N.Z": 1, "R": 1, "Z": 2})

    def test_a_turn(self):
        self.convert("render", "demo:torus?size=24", *SMALL, "--frames", "4", "-o", "turn_{:02}.png", "--camera", "0,30")
        self.assertEqual(self.files(), [f"turn_{i:02}.png" for i in (1, 2, 3, 4)])
        pictures = [Png((self.folder / name).read_bytes()) for name in self.files()]
        # A single picture is framed by itself, from closer. All pictures of the turn have one distance.
        self.convert("render", "demo:torus?size=24", *SMALL, "--frames", "4", "-o", "turn_{:02}.png", "--camera", "0,30",
                     "--json", "turn.json")
        cameras = [picture["camera"] for picture in json.loads((self.folder / "turn.json").read_text())["pictures"]]
        distances = [math.dist(camera["eye"], camera["target"]) for camera in cameras]
        for distance in distances:
            self.assertAlmostEqual(distance, distances[0], delta=1e-9)
        turned = self.picture("demo:torus?size=24", "--camera", f"90,30,{distances[1]!r}", name="turned.png")
        self.assertEqual(turned.difference(pictures[1]), 0)
        self.picture("demo:torus?size=24", "--camera", "90,30", "--json", "one.json")
        (alone,) = json.loads((self.folder / "one.json").read_text())["pictures"]
        self.assertLess(math.dist(alone["camera"]["eye"], alone["camera"]["target"]), distances[1])

    def test_a_sequence_stands_still(self):
        for frame, size in ((1, 12), (2, 8)):
            self.write_raw(f"f_{frame}.raw", (16, 16, 16), lambda x, y, z: 1 if max(x, y, z) < size else 0)
        run = self.convert("render", "f_{}.raw", "--dims", "16,16,16", "--dtype", "f32", *SMALL, "-o", "p_{:03}.png",
                           "--json", "all.json")
        self.assertEqual(run.err.count(" -> p_00"), 2)
        pictures = json.loads((self.folder / "all.json").read_text())["pictures"]
        self.assertEqual([picture["frame"] for picture in pictures], [1, 2])
        self.assertEqual(pictures[0]["camera"], pictures[1]["camera"])
        first, second = (Png((self.folder / f"p_00{i}.png").read_bytes()).alpha() for i in (1, 2))
        self.assertGreater(first, 1.5 * second)
        for name in ("p_001.png", "p_002.png"):
            (self.folder / name).unlink()
        self.convert("render", "f_{}.raw", "--dims", "16,16,16", "--dtype", "f32", *SMALL, "-o", "p_{:03}.png", "--frames", "2")
        self.assertEqual([name for name in self.files() if name.startswith("p_")], ["p_002.png"])

    def test_frames_that_show_nothing(self):
        """Smoke begins with an empty grid: its frames are drawn, with the camera of the first that shows something."""
        voxels = {(x, y, z): 1.0 for x in range(6) for y in range(6) for z in range(6)}
        for frame, there in ((1, {}), (2, voxels), (3, {})):
            (self.folder / f"f_{frame}.vdb").write_bytes(vdb(grid(voxels=there)))
        for more in (("--tf-range", "0,1"), ("--iso", "0.5"), ("--iso", "0.5", "--tf", "none")):
            with self.subTest(more):
                run = self.convert("render", "f_{}.vdb", *SMALL, *more, "-o", "p_{}.png", "--json", "all.json")
                self.assertEqual(run.err.count(": the picture shows no volume\n"), 2, run.err)
                alpha = [Png((self.folder / f"p_{i}.png").read_bytes()).alpha() for i in (1, 2, 3)]
                self.assertEqual((alpha[0], alpha[2]), (0, 0))
                self.assertGreater(alpha[1], 0)
                pictures = json.loads((self.folder / "all.json").read_text())["pictures"]
                self.assertEqual(sorted(picture["frame"] for picture in pictures), [1, 2, 3])
        self.assert_fails(2, self.run_program("render", "f_1.vdb", *SMALL, "-o", "a.png"), "f_1.vdb: the grid has no active voxels")

    def test_frames_that_are_not_there(self):
        for frame in (1, 2):
            self.write_raw(f"f_{frame}.raw", (8, 8, 8), lambda x, y, z: x)
        sequence = ("render", "f_{}.raw", "--dims", "8,8,8", "--dtype", "f32", *SMALL, "-o", "p_{}.png")
        run = self.run_program(*sequence, "--frames", "1-4")
        self.assertEqual(run.code, 5, run.err)
        self.assertIn("isoextract: error: the inputs lack the frames 3-4\n", run.err)
        self.assertEqual(sum(name.endswith(".png") for name in self.files()), 2)
        self.convert(*sequence, "--frames", "1-2")

    def test_a_sequence_that_leaves_the_picture_is_told(self):
        for frame, at in ((1, 4), (2, 60)):
            self.write_raw(f"f_{frame}.raw", (64, 8, 8), lambda x, y, z, at=at: 1 if max(abs(x - at), abs(y - 4), abs(z - 4)) < 3 else 0)
        sequence = ("render", "f_{}.raw", "--dims", "64,8,8", "--dtype", "f32", *SMALL, "--tf", "none", "--iso", "0.5", "-o", "p_{}.png")
        for more in ((), ("--background", "white"), ("--camera", "0,0,40")):
            run = self.convert(*sequence, *more)
            self.assertEqual(run.err.count("note[one-camera]: the first picture sets the camera for all pictures"), 1)
            self.assertNotIn("p_1.png: the picture is empty", run.err)
            self.assertIn("note[empty-picture]: p_2.png: the picture is empty: the scene is outside the camera's view, or the transfer function makes it transparent\n", run.err)
        run = self.convert(*sequence, "--camera", "0,0,100", "--look-at", "32,4,4", "--no-note", "iso-of-labels")
        self.assertNotIn("note[", run.err)
        seen = [Png((self.folder / name).read_bytes()).alpha() for name in ("p_1.png", "p_2.png")]
        self.assertGreater(min(seen), 0)
        self.assertAlmostEqual(seen[1] / seen[0], 1, delta=0.2)
        self.assertNotIn("the picture is empty", self.convert("render", "f_1.raw", *sequence[2:-1], "a.png").err)

    def test_transfer_functions_of_files(self):
        (self.folder / "a.tf").write_text("# red inside\n-1 0 0 0 0\n0 0 0 0 0\n0 1 0 0 1\n1 1 0 0 1\n")
        picture = self.picture(SPHERE, "--tf", "a.tf", "--unit-length", "0.01")
        self.assertEqual(picture.pixel(24, 16)[3], 255)
        self.assertGreater(picture.pixel(24, 16)[0], 250)
        self.assertEqual(picture.pixel(24, 16)[1], 0)
        (self.folder / "b.tf").write_text("0 0 0 0 0\n1 1 0 0\n")
        run = self.run_program("render", SPHERE, "--tf", "b.tf", "-o", "no.png")
        self.assert_fails(2, run, "b.tf: line 2: expected a value, red, green, blue and opacity", "found 4 numbers")
        self.assertNotIn("no.png", self.files())

    def test_figures_add_up(self):
        def figures(*options):
            self.convert("render", "demo:sphere?size=64", *SMALL, "-o", "out.png", "--json", "out.json", *options)
            picture = json.loads((self.folder / "out.json").read_text())["pictures"][0]
            self.assertEqual((picture["width"], picture["height"], picture["file"]), (48, 32, "out.png"))
            return picture

        every = figures("--no-skipping", "--termination", "0")
        self.assertEqual((every["samples_skipped"], every["samples_terminated"]), (0, 0))
        usual = figures("--tf-range", "0,1")
        self.assertEqual(usual["samples"] + usual["samples_skipped"] + usual["samples_terminated"], every["samples"])
        self.assertGreater(usual["samples_skipped"], 0)

    def test_refusals(self):
        for arguments, code, part in (
            ((), 1, "INPUT is missing"),
            ((SPHERE, "-o", "a.jpg"), 1, "a.jpg: expected a name that ends in .png or .exr"),
            ((SPHERE, "--size", "0x5"), 1, "--size: expected "),
            ((SPHERE, "--camera", "30"), 1, "--camera: expected azimuth and elevation"),
            ((SPHERE, "--tf", "smoek"), 1, "did you mean 'smoke'?"),
            ((SPHERE, "--tf", "none"), 1, "the scene is empty"),
            ((SPHERE, "--tf-range", "3,1"), 1, "expected two values MIN,MAX"),
            ((SPHERE, "--opacity", "0.5"), 1, "--opacity applies to surfaces and meshes"),
            ((SPHERE, "--cap"), 1, "--cap applies to surfaces of a volume"),
            ((SPHERE, "--frames", "3", "-o", "a.png"), 1, "a.png"),
            ((SPHERE, "--frames", "3", "-o", "-"), 1, "render writes several pictures to files"),
            ((SPHERE, "--frames", "1-5"), 1, "expected the number of pictures for one turn of the camera"),
            ((SPHERE, "--frames", "3", "-o", "a_{stem}.png"), 1, "with {} or {:04} in it, the number of the picture\n"),
            ((SPHERE, "demo:gyroid", "-o", "a.png"), 1, "with {}, {:04} or {stem} in it, the number of the frame"),
            ((SPHERE, "-o", "a_{iso}.png"), 1, "-o a_{iso}.png: a picture shows all surfaces, not one\n  hint: leave {iso} out"),
            ((SPHERE, "--iso", "0", "-o", "a_{label}.png"), 1, "leave {label} out"),
            ((SPHERE, "--clip", "1,0,0,0"), 1, "--clip applies to surfaces of a volume and needs --iso or --labels"),
            ((SPHERE, "--mesh-color", "ff0000"), 1, "--mesh-color applies to meshes that are inputs"),
            ((SPHERE, "--iso", "0", "--tf", "none", "--samples", "2"), 1, "--samples applies to the drawn volume"),
            (("a.ply", "--no-skipping"), 1, "--no-skipping applies to the drawn volume"),
            (("a.ply", "--mesh-color", "ff0000,00ff00"), 1, "found 2 colors for 1 mesh\n"),
            ((SPHERE, "--background", "blue"), 1, "expected none, black, white or a color as RRGGBB"),
            ((SPHERE, "--antialias", "5"), 1, "--antialias: expected a whole number from 1 to 4, found '5'"),
            ((SPHERE, "--labels", "1", "--iso", "0"), 1, "--labels and --iso exclude each other"),
            ((SPHERE, "--labels", "1", "--method", "mc"), 1, "--labels does not work with marching cubes"),
            ((SPHERE, "--labels", "1", "--blur", "1"), 1, "--blur does not work with --labels"),
            ((SPHERE, "--labels", "all", "--opacity", "0.5,0.6"), 1, "any number of labels"),
            ((SPHERE, "--labels", "1", "--tf-range", "0,1"), 1, "--tf-range applies to the drawn volume"),
            ((SPHERE, "--label-names", "a.txt"), 1, "--label-names needs --labels"),
            (("a.ply", "--labels", "1"), 1, "--labels needs a volume"),
            ((SPHERE, "--iso", "7"), 2, "iso"),
            (("none.nrrd",), 2, "none.nrrd"),
            (("none.ply",), 2, "none.ply"),
            ((SPHERE, "--memory-limit", "100K"), 2, "memory"),
        ):
            self.assert_fails(code, self.run_program("render", *arguments), part)
            self.assertEqual(self.files(), [], arguments)

    def test_hints_fit_the_input(self):
        run = self.run_program("render", SPHERE, "--frames", "0", "-o", "a_{}.png")
        self.assert_fails(1, run, "expected the number of pictures for one turn of the camera, 1 to 100000, found '0'")
        self.assertNotIn("range of frames", run.err)
        run = self.convert("render", SPHERE, *SMALL, "--iso", "0", "--clip", "1,0,0,0", "-o", "a.png")
        self.assertIn("note[no-effect]: --clip cuts only the surfaces: render draws the whole volume", run.err)

    def test_a_gpu_that_is_not_there(self):
        run = self.run_program("render", SPHERE, "--backend", "gpu", "-o", "a.png", env=NO_GPU)
        self.assert_fails(3, run, "--backend cpu")
        self.assertEqual(self.files(), [])

    def test_what_cannot_be_written_leaves_nothing(self):
        run = self.run_program("render", SPHERE, *SMALL, "-o", "nowhere/a.png")
        self.assert_fails(4, run, "nowhere")
        run = self.run_program("render", SPHERE, *SMALL, "-o", "/dev/full")
        self.assertNotEqual(run.code, 0)
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
