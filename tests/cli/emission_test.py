"""isoextract render --emission: a second grid of the file makes the volume glow."""

import io
import json
import math
import struct
import zipfile
import zlib

from support import SPHERE, Png, ProgramTest, main
from vdb_files import grid, scale, vdb

SIZE = ("--size", "48x32")
SMALL = (*SIZE, "--backend", "cpu")
VIEW = ("--camera", "20,10,60", "--look-at", "11.5,11.5,11.5")
BLACK = ("--background", "black")
SIDE = 24


def smoke(x, y, z):
    """A ball of smoke whose middle is free of smoke."""
    r = math.dist((x, y, z), (11.5, 11.5, 11.5))
    return 1.0 if 5 < r < 11 else 0.0


def heat(x, y, z):
    return max(0.0, 2600 - 240 * math.dist((x, y, z), (11.5, 11.5, 11.5)))


def voxels(value_at, side=SIDE):
    places = ((x, y, z) for x in range(side) for y in range(side) for z in range(side))
    return {place: value for place in places if (value := value_at(*place)) != 0}


def npy(value_at, side=SIDE):
    """An array [z, y, x] of floats."""
    values = [value_at(x, y, z) for z in range(side) for y in range(side) for x in range(side)]
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {(side,) * 3}}}"
    header += " " * (-(len(header) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + struct.pack(f"<{len(values)}f", *values)


def npz(**arrays):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            archive.writestr(f"{name}.npy", array)
    return file.getvalue()


def exr_planes(data):
    """The half floats of each channel of an OpenEXR file with ZIP compression: 16 lines in each block."""
    at = data.index(b"channels\0chlist\0") + len(b"channels\0chlist\0") + 4
    channels = []
    while data[at]:
        end = data.index(b"\0", at)
        channels.append((data[at:end].decode(), 2 if data[end + 1] == 1 else 4))
        at = end + 17
    at = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    left, top, right, bottom = struct.unpack_from("<4i", data, at)
    width, height = right - left + 1, bottom - top + 1
    planes = {name: [] for name, size in channels if size == 2}
    blocks = (height + 15) // 16
    # The table of the blocks' places follows the header, whose last byte is 0; the first block follows the table.
    table = next(at for at in range(at, len(data)) if struct.unpack_from("<Q", data, at)[0] == at + 8 * blocks)
    for block, place in enumerate(struct.unpack_from(f"<{blocks}Q", data, table)):
        lines = min(16, height - 16 * block)
        size, = struct.unpack_from("<i", data, place + 4)
        raw = data[place + 8 : place + 8 + size]
        if size < lines * width * sum(size for _, size in channels):
            mixed = bytearray(zlib.decompress(raw))
            for i in range(1, len(mixed)):
                mixed[i] = (mixed[i - 1] + mixed[i] - 128) & 255
            half = (len(mixed) + 1) // 2
            raw = bytearray(len(mixed))
            raw[0::2], raw[1::2] = mixed[:half], mixed[half:]
        at = 0
        for _ in range(lines):
            for name, size in channels:
                if size == 2:
                    planes[name] += struct.unpack_from(f"<{width}e", raw, at)
                at += size * width
    return planes


class EmissionTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("fire.vdb", vdb(grid("density", voxels(smoke)), grid("temperature", voxels(heat)),
                                   grid("flames", voxels(lambda x, y, z: heat(x, y, z) / 2600)), grid("nothing")))

    def write(self, name, data):
        (self.folder / name).write_bytes(data)

    def picture(self, *arguments, name="out.png", backend="cpu"):
        self.convert("render", *arguments, *SIZE, "--backend", backend, "-o", name)
        return Png((self.folder / name).read_bytes())

    def fire(self, *arguments, emission="temperature", name="out.png", backend="cpu"):
        return self.picture("fire.vdb", "--grid", "density", "--emission", emission, *arguments, name=name, backend=backend)

    def refused(self, code, *arguments, parts, without=()):
        before = self.files()
        run = self.run_program("render", *arguments, *SMALL, "-o", "no.png")
        self.assert_fails(code, run, *parts)
        for part in without:
            self.assertNotIn(part, run.err)
        self.assertEqual(self.files(), before)

    def test_the_middle_glows(self):
        plain = self.picture("fire.vdb", "--grid", "density", *BLACK)
        fire = self.fire(*BLACK)
        red, green, blue = fire.pixel(24, 16)
        self.assertGreater(red, plain.pixel(24, 16)[0] + 60)
        self.assertGreater(red, green + 20)
        self.assertGreater(green, blue)
        self.assertEqual(fire.pixel(0, 0), (0, 0, 0))
        # Without an emission the picture is the same as before, and more smoke hides more of the fire.
        self.assertEqual(self.picture("fire.vdb", "--grid", "density", *BLACK).difference(plain), 0)
        (self.folder / "thin.tf").write_text("0 0 0 0 0\n1 0 0 0 0.01\n")
        (self.folder / "thick.tf").write_text("0 0 0 0 0\n1 0 0 0 0.08\n")
        thin, thick = (self.fire(*BLACK, "--tf", name).pixel(24, 16) for name in ("thin.tf", "thick.tf"))
        self.assertGreater(thin[0], 150)
        self.assertLess(thick[0], 0.7 * thin[0])
        self.assertGreater(thick[0], 0)

    def test_skipping_and_threads_change_nothing(self):
        far = {(60, 60, 60): 1.0}  # so that there are empty bricks
        self.write("fire.vdb", vdb(grid("density", voxels(smoke) | far), grid("temperature", voxels(heat)),
                                   grid("flames", voxels(lambda x, y, z: heat(x, y, z) / 2600))))
        usual = self.fire("--termination", "0")
        for options in (("--no-skipping",), ("--threads", "1")):
            self.assertEqual(self.fire("--termination", "0", *options).difference(usual), 0, options)
        self.fire("--json", "a.json")
        (told,) = json.loads((self.folder / "a.json").read_text())["pictures"]
        self.assertGreater(told["samples_skipped"], 0)
        self.assertEqual(told["emission"], {"grid": "temperature", "greatest_value": told["emission"]["greatest_value"], "range": None})
        self.assertAlmostEqual(told["emission"]["greatest_value"], heat(11, 11, 11), delta=0.01)
        self.fire("--json", "a.json", emission="flames:0,2.5")
        (told,) = json.loads((self.folder / "a.json").read_text())["pictures"]
        self.assertEqual((told["emission"]["grid"], told["emission"]["range"]), ("flames", [0, 2.5]))

    def test_a_gpu_draws_the_same(self):
        for more in ((), ("--iso", "0.5", "--opacity", "0.4", "--antialias", "1")):
            cpu = self.fire(*BLACK, *more)
            gpu = self.fire(*BLACK, *more, name="gpu.png", backend="gpu")
            apart = sum(max(abs(a - b) for a, b in zip(*pair)) > 3 for pair in zip(cpu.pixels(), gpu.pixels()))
            self.assertLessEqual(apart, 4 if more else 0)
            self.assertGreater(cpu.difference(self.picture("fire.vdb", "--grid", "density", *BLACK, *more)), 40)

    def test_ranges(self):
        """800 and 3000 K at the ends: the same picture as with kelvins that are scaled by hand."""
        self.write("kelvin.vdb", vdb(grid("density", voxels(smoke)),
                                     grid("t", voxels(lambda x, y, z: 800 + 2200 * heat(x, y, z) / 2600))))
        kelvin = self.picture("kelvin.vdb", "--grid", "density", "--emission", "t", *VIEW, *BLACK)
        flames = self.fire(*VIEW, *BLACK, emission="flames:0,1")
        self.assertLessEqual(kelvin.difference(flames), 2)

        def brightness(picture):
            return sum(sum(pixel) for pixel in picture.pixels())

        self.assertGreater(brightness(self.fire(*VIEW, *BLACK, emission="flames:-1,1")), 1.1 * brightness(flames))
        self.assertLess(brightness(self.fire(*VIEW, *BLACK, emission="flames:0.7,1")), 0.9 * brightness(flames))
        self.write("odd.vdb", vdb(grid("density", voxels(smoke)), grid("t:0,x", voxels(heat)), grid("t:1", voxels(heat))))
        self.refused(1, "odd.vdb", "--grid", "density", "--emission", "t:0,x", parts=("--emission: expected two values MIN,MAX",))
        self.picture("odd.vdb", "--grid", "density", "--emission", "t:1")
        self.picture("odd.vdb", "--grid", "density", "--emission", "t:0,x:0,2000")

    def test_values_that_are_no_kelvins(self):
        self.refused(2, "fire.vdb", "--grid", "density", "--emission", "flames", parts=(
            "--emission: fire.vdb[flames]: expected temperatures in kelvin, found values up to 0.92", "--emission flames:0,0.92"))
        for emission, words in (("cold", "fire.vdb[cold]: no value is above 800 K, where bodies begin to glow, so the grid emits no light"),
                                ("cold:600,900", "fire.vdb[cold]: no value is above 600, so the grid emits no light"),
                                ("nothing", "fire.vdb[nothing]: the grid has no voxels, so it emits no light")):
            self.write("fire.vdb", vdb(grid("density", voxels(smoke)), grid("cold", {(5, 5, 5): 500.0}), grid("nothing")))
            run = self.convert("render", "fire.vdb", "--grid", "density", "--emission", emission, *SMALL, "-o", "a.png")
            self.assertIn(f"note[no-effect]: {words}\n", run.err)
            plain = self.picture("fire.vdb", "--grid", "density", name="b.png")
            self.assertEqual(Png((self.folder / "a.png").read_bytes()).difference(plain), 0)

    def test_nan_and_negative_values_emit_nothing(self):
        self.write("a.vdb", vdb(grid("density", {(x, y, z): 1e-3 for x in range(9) for y in range(9) for z in range(9)}),
                                grid("t", {(x, y, z): math.nan if x < 4 else -4000.0 if x > 5 else 2500.0
                                           for x in range(9) for y in range(9) for z in range(9)})))
        picture = self.picture("a.vdb", "--grid", "density", "--emission", "t", "--camera", "0,0,20", "--look-at", "4,4,4", *BLACK,
                               "--tf", "gray", "--tf-range", "0,1")
        lit = [x for x in range(48) if picture.pixel(x, 16)[0] > 40]
        self.assertGreater(len(lit), 2)
        self.assertLess(max(lit) - min(lit), 16)

    def test_fire_without_smoke(self):
        """Light where the density is 0, and outside of its grid; a PNG without background keeps it."""
        self.write("apart.vdb", vdb(grid("density", voxels(lambda x, y, z: 1.0, 6)),
                                    grid("temperature", {(x + 30, y, z): 2500.0 for x in range(6) for y in range(6) for z in range(6)})))
        for background in (BLACK, ()):
            for backend, more in (("cpu", ()), ("cpu", ("--no-skipping",)), ("gpu", ())):
                picture = self.picture("apart.vdb", "--grid", "density", "--emission", "temperature", "--camera", "0,0", "--tf-range",
                                       "0,1", "--unit-length", "0.3", *background, *more, backend=backend)
                row = [picture.pixel(x, 16) for x in range(48)]
                smoky, fiery = row[:20], row[28:]
                self.assertGreater(max(pixel[0] for pixel in fiery), 200, more)
                for pixel in fiery:
                    self.assertGreaterEqual(pixel[0], pixel[1])
                    self.assertLessEqual(pixel[2], pixel[0] // 2 + 1)
                self.assertTrue(any(max(pixel[:3]) - min(pixel[:3]) <= 1 and pixel[0] > 20 for pixel in smoky))
                if not background:
                    self.assertGreater(max(pixel[3] for pixel in fiery), 200)

    def test_grids_with_transforms_of_their_own(self):
        """The temperature on a grid of half the voxels per axis, in the same place of the world."""
        coarse = {(x, y, z): value for (x, y, z), value in voxels(lambda x, y, z: heat(2 * x, 2 * y, 2 * z), SIDE // 2).items()}
        self.write("coarse.vdb", vdb(grid("density", voxels(smoke)), grid("temperature", coarse, transform=scale(2.0))))
        coarse = self.picture("coarse.vdb", "--grid", "density", "--emission", "temperature", *VIEW, *BLACK)
        fine = self.fire(*VIEW, *BLACK)
        self.assertLessEqual(coarse.difference(fine), 24)
        turned = [self.picture(name, "--grid", "density", "--emission", "temperature", "--up", "y", *VIEW, *BLACK)
                  for name in ("coarse.vdb", "fire.vdb")]
        self.assertLessEqual(turned[0].difference(turned[1]), 24)

    def test_other_formats_with_grids(self):
        self.write("fire.npz", npz(density=npy(smoke), temperature=npy(heat)))
        view = (*VIEW, *BLACK, "--tf-range", "0,1", "--unit-length", "0.3")
        arrays = self.picture("fire.npz", "--grid", "density", "--emission", "temperature", *view)
        self.assertLessEqual(arrays.difference(self.fire(*view)), 6)

    def test_a_sequence(self):
        for frame, hot in ((1, {}), (2, voxels(heat))):
            self.write(f"f_{frame}.vdb", vdb(grid("density", voxels(smoke)), grid("temperature", hot)))
        run = self.convert("render", "f_{}.vdb", "--grid", "density", "--emission", "temperature", *SMALL, *BLACK, "-o", "p_{}.png",
                           "--json", "all.json")
        self.assertEqual(run.err.count("f_1.vdb[temperature]: the grid has no voxels, so it emits no light\n"), 1)
        first, second = (Png((self.folder / f"p_{i}.png").read_bytes()).pixel(24, 16) for i in (1, 2))
        self.assertGreater(second[0], first[0] + 40)
        pictures = json.loads((self.folder / "all.json").read_text())["pictures"]
        self.assertEqual(["emission" in picture for picture in pictures], [False, True])
        self.convert("render", "fire.vdb", "--grid", "density", "--emission", "temperature", *SMALL, "--frames", "3", "-o", "t_{}.png")
        self.assertIn("t_3.png", self.files())

    def test_light_beyond_white(self):
        """The picture is white where the light is too bright; the EXR has all of it."""
        self.write("hot.vdb", vdb(grid("density", voxels(smoke)), grid("temperature", voxels(lambda x, y, z: 3 * heat(x, y, z)))))
        arguments = ("hot.vdb", "--grid", "density", "--emission", "temperature")
        self.assertEqual(self.picture(*arguments, *BLACK).pixel(24, 16), (255, 255, 255))
        self.convert("render", *arguments, *SMALL, "-o", "a.exr")
        planes = exr_planes((self.folder / "a.exr").read_bytes())
        self.assertGreater(max(planes["R"]), 2)
        self.assertLessEqual(max(planes["A"]), 1)
        self.assertLess(max(planes["A"]), max(planes["R"]) / 4)  # only of the smoke

    def test_an_infinite_background_is_no_greatest_value(self):
        self.write("fire.vdb", vdb(grid("density", voxels(smoke)), grid("temperature", voxels(heat), background=math.inf)))
        self.fire("--json", "a.json")
        (told,) = json.loads((self.folder / "a.json").read_text())["pictures"]
        self.assertAlmostEqual(told["emission"]["greatest_value"], heat(11, 11, 11), delta=0.01)

    def test_refusals(self):
        fire = ("fire.vdb", "--grid", "density")
        self.refused(2, *fire, "--emission", "temprature", parts=(
            "--emission: fire.vdb: there is no grid 'temprature' (did you mean 'temperature'?)",
            "choose one of them with --emission GRID\n", "flames"), without=("--grid",))
        self.write("v.vdb", vdb(grid("density", voxels(smoke)), grid("velocity", {(1, 1, 1): 1.0}, kind="vec3s_5_4_3")))
        self.refused(2, "v.vdb", "--grid", "density", "--emission", "velocity", parts=(
            "--emission: v.vdb: expected a grid with one number per voxel, but 'velocity' holds vectors (vec3s)",), without=("--grid",))
        self.refused(1, *fire, "--emission", "", parts=("--emission: expected the name of a grid",))
        self.refused(1, *fire, "--emission", "flames:1,0", parts=("--emission: expected two values MIN,MAX",))
        self.refused(1, *fire, "--emission", "temperature", "--iso", "0.5", "--tf", "none", parts=(
            "--emission applies to the drawn volume",))
        self.refused(1, "a.ply", "--emission", "temperature", parts=("--emission applies to the drawn volume",))
        self.write_raw("map.raw", (12, 12, 12), lambda x, y, z: 1 + x // 4, "B")
        raw = ("map.raw", "--dims", "12,12,12", "--dtype", "u8")
        self.refused(1, *raw, "--labels", "all", "--emission", "temperature", parts=("--emission applies to the drawn volume",))
        self.refused(2, *raw, "--emission", "temperature", parts=("map.raw: expected a file with named grids",))
        self.refused(2, SPHERE, "--emission", "temperature", parts=("expected a file with named grids",))
        (self.folder / "p.xyz").write_text("2\nparticles\n0 0 0\n1 1 1\n")
        self.refused(1, "p.xyz", "--radius", "1", "--emission", "temperature", parts=(
            "--emission: p.xyz: expected a volume with the grid 'temperature', found particles",))
        self.refused(2, *fire, "--emission", "temperature", "--memory-limit", "100K", parts=("memory",))

    def test_memory_counts(self):
        """A limit that fits the density alone, but not both grids."""
        self.write("big.vdb", vdb(grid("density", voxels(lambda x, y, z: 1 + x, 56)), grid("t", voxels(lambda x, y, z: 900 + x, 56))))
        command = ("render", "big.vdb", "--grid", "density", *SMALL, "--tf-range", "0,90", "--threads", "1", "-o", "a.png")

        def least(*more):
            """The smallest limit in KiB that is enough."""
            low, high = 0, 1 << 17
            while high - low > 64:
                middle = (low + high) // 2
                run = self.run_program(*command, *more, "--memory-limit", f"{middle}K")
                low, high = (low, middle) if run.code == 0 else (middle, high)
            return high

        # 56^3 floats are 686 KiB.
        self.assertGreater(least("--emission", "t"), least() + 600)


if __name__ == "__main__":
    main()
