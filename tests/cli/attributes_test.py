"""Attributes and colors of vertices: from particles, from grids of a file, from other files."""

import gzip
import json
import math
import pathlib
import struct
import subprocess
import unittest

from support import DATA, PROGRAM, SOURCE, ProgramTest, main, needs_data, needs_program, read_ply

STEP = 0.5
PERI = DATA / "particles/lammps_peri"
PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-volume-openvdb.so"
GAS = DATA / "vdb/c42_gas_seq"
CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def linear(x, y, z):
    return 0.25 + 2 * x - 3 * y + 0.5 * z


def nrrd(dims, spacing, origin, value_at):
    """A NRRD file of doubles: value_at of places of the world."""
    head = ["NRRD0004", "type: double", "dimension: 3", "sizes: {} {} {}".format(*dims), "encoding: raw", "endian: little",
            "space: left-posterior-superior", "space directions: ({},0,0) (0,{},0) (0,0,{})".format(*spacing),
            "space origin: ({},{},{})".format(*origin), "", ""]
    values = [value_at(*(origin[a] + spacing[a] * index[a] for a in range(3)))
              for index in ((i, j, k) for k in range(dims[2]) for j in range(dims[1]) for i in range(dims[0]))]
    return "\n".join(head).encode() + struct.pack(f"<{len(values)}d", *values)


class Glb:
    """The numbers of a GLB file that is not packed, by mesh and attribute."""

    def __init__(self, data):
        length = struct.unpack_from("<I", data, 12)[0]
        self.model = json.loads(data[20:20 + length])
        self.binary = data[28 + length:]

    def primitive(self, mesh=0):
        return self.model["meshes"][mesh]["primitives"][0]

    def material(self, mesh=0):
        return self.model["materials"][self.primitive(mesh)["material"]]

    def values(self, name, mesh=0):
        accessor = self.model["accessors"][self.primitive(mesh)["attributes"][name]]
        view = self.model["bufferViews"][accessor["bufferView"]]
        item = struct.Struct(f"<{COUNTS[accessor['type']]}{CODES[accessor['componentType']]}")
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return [item.unpack_from(self.binary, start + i * view.get("byteStride", item.size)) for i in range(accessor["count"])]


def columns(path):
    """The vertices of a PLY file of text, by the names of their properties."""
    head, body = path.read_text().split("end_header\n")
    names = [line.split()[-1] for line in head.split("element face")[0].splitlines() if line.startswith("property")]
    count = int(head.split("element vertex ")[1].split()[0])
    rows = [line.split() for line in body.splitlines()[:count]]
    return {name: [float(row[i]) for row in rows] for i, name in enumerate(names)}


class AttributesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        # A sphere of radius 4 around (6, 5, 4), and a linear function on a coarser grid around it.
        self.write("ball.nrrd", nrrd((13, 11, 9), (1, 1, 1), (0, 0, 0),
                                     lambda x, y, z: 3.3 - math.dist((x, y, z), (6, 5, 4))))
        self.write("linear.nrrd", nrrd((6, 7, 5), (3, 2.5, 4), (-2, -1, -3), linear))

    def write(self, name, data):
        (self.folder / name).write_bytes(data)

    def ply(self, *arguments):
        self.convert("ball.nrrd", "--iso", "0", *arguments, "--ascii", "-o", "out.ply")
        return columns(self.folder / "out.ply")

    def particles(self, name="a.ply", n=5):
        """With the attributes pressure, which is x, and velocity, which is the place."""
        places = [(STEP * i, STEP * j, STEP * k) for i in range(n) for j in range(n) for k in range(n)]
        names = ("x", "y", "z", "pressure", "vx", "vy", "vz")
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(places)}",
                  *(f"property float {p}" for p in names), "end_header", ""]
        self.write(name, "\n".join(header).encode() + b"".join(struct.pack("<7f", *p, p[0], *p) for p in places))

    def validate(self, *names):
        run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", *(self.folder / name for name in names)],
                             capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_a_linear_function_comes_out_exactly(self):
        """Wherever the mesh is put, the attribute is that of its places in the world."""
        heat = ("--attribute", "heat=linear.nrrd")
        back = {(): lambda p: p, ("--space", "index"): lambda p: p, ("--up-out", "y"): lambda p: [p[0], -p[2], p[1]],
                ("--unit", "mm", "--to-unit", "m"): lambda p: [1000 * c for c in p],
                ("--scale", "3"): lambda p: [c / 3 for c in p], ("--roi", "0,0,0,6,11,9"): lambda p: p,
                ("--resolution", "20"): lambda p: p, ("--simplify", "0.2"): lambda p: p}
        for more, world_of in back.items():
            with self.subTest(more=more):
                found = self.ply(*heat, *more)
                self.assertGreater(len(found["heat"]), 20)
                for *place, value in zip(found["x"], found["y"], found["z"], found["heat"]):
                    wanted = linear(*world_of(place))
                    self.assertAlmostEqual(value, wanted, delta=3e-6 * (1 + abs(wanted)))
        self.convert("ball.nrrd", "--iso", "0", *heat, "-o", "out.glb")  # which is turned
        glb = Glb((self.folder / "out.glb").read_bytes())
        for (x, y, z), (value,) in zip(glb.values("POSITION"), glb.values("_heat")):
            self.assertAlmostEqual(value, linear(x, -z, y), delta=1e-5 * (1 + abs(value)))
        self.assertNotIn("outside", self.convert("ball.nrrd", "--iso", "0", *heat, "-o", "out.ply").err)

    def test_outside_and_numbers_that_are_none(self):
        self.write("small.nrrd", nrrd((3, 3, 3), (2, 2, 2), (4, 3, 2), linear))
        self.write("holes.nrrd", nrrd((13, 11, 9), (1, 1, 1), (0, 0, 0), lambda x, y, z: math.nan if x > 8 else x))
        run = self.convert("ball.nrrd", "--iso", "0", "--attribute", "heat=small.nrrd", "--attribute", "h=holes.nrrd",
                           "--report", "r.json", "-o", "out.glb")
        self.assertRegex(run.err, r"\d+ of \d+ vertices lie outside small\.nrrd; their 'heat' is the value at the nearest point of its boundary")
        self.assertRegex(run.err, r"'h' is not finite at \d+ of \d+ vertices")
        self.assertIn("the writer omits the attribute 'h', which has such values", run.err)
        first, second = json.loads((self.folder / "r.json").read_text())["attributes"]
        self.assertEqual((first["name"], second["name"], first["components"]), ("heat", "h", 1))
        self.assertTrue(0 < first["outside"] < first["vertices"])
        self.assertTrue(0 < second["not_finite"] < second["vertices"])
        gray = self.ply("--color-by", "h=holes.nrrd:gray")
        self.assertTrue(any((r, g, b) == (128, 128, 128) for r, g, b in zip(gray["red"], gray["green"], gray["blue"])))
        self.assertNotIn("h", gray)

    def test_the_same_bytes_for_any_number_of_threads(self):
        self.particles()
        for threads in (1, 3):
            self.convert("ball.nrrd", "--iso", "0", "--threads", threads, "--attribute", "heat=linear.nrrd", "--color-by",
                         "heat", "-o", f"v{threads}.glb")
            self.convert("a.ply", "--threads", threads, "--color-by", "pressure", "-o", f"p{threads}.glb")
        for kind in "vp":
            self.assertEqual((self.folder / f"{kind}1.glb").read_bytes(), (self.folder / f"{kind}3.glb").read_bytes())

    def test_colors_of_particles(self):
        self.particles()
        run = self.convert("a.ply", "--radius", "0.25", "--attribute", "p=pressure", "--color-by", "p:gray:0,2", "--ascii",
                           "-o", "out.ply")
        self.assertIn("p, gray from 0 to 2", run.err)
        found = columns(self.folder / "out.ply")
        for p, *rgb in zip(found["p"], found["red"], found["green"], found["blue"]):
            self.assertEqual(len(set(rgb)), 1)
            self.assertAlmostEqual(rgb[0], 255 * min(max(p / 2, 0), 1), delta=1)
        # glTF's colors are linear light, of 16 bits.
        self.convert("a.ply", "--radius", "0.25", "--attribute", "p=pressure", "--color-by", "p:gray:0,2", "-o", "out.glb")
        glb = Glb((self.folder / "out.glb").read_bytes())
        self.assertEqual(glb.material()["pbrMetallicRoughness"].get("baseColorFactor", [1, 1, 1, 1]), [1, 1, 1, 1])
        for (p,), (red, _, _, alpha) in zip(glb.values("_p"), glb.values("COLOR_0")):
            srgb = min(max(p / 2, 0), 1)
            wanted = srgb / 12.92 if srgb <= 0.04045 else ((srgb + 0.055) / 1.055) ** 2.4
            self.assertAlmostEqual(red / 65535, wanted, delta=0.004)
            self.assertEqual(alpha, 65535)
        # Without an attribute of its own, by its own range.
        run = self.convert("a.ply", "--radius", "0.25", "--color-by", "pressure", "-o", "out.glb")
        self.assertRegex(run.err, r"pressure, viridis from \S+ to \S+, the range of its vertices")
        self.assertEqual(sorted(Glb((self.folder / "out.glb").read_bytes()).primitive()["attributes"]),
                         ["COLOR_0", "NORMAL", "POSITION"])

    def test_each_surface_has_the_range_of_its_own_vertices(self):
        self.convert("ball.nrrd", "--iso", "0", "--iso", "2", "--attribute", "heat=linear.nrrd", "--color-by", "heat:gray",
                     "-o", "two.glb")
        glb = Glb((self.folder / "two.glb").read_bytes())
        ranges = set()
        for mesh in range(2):
            pairs = sorted(zip(glb.values("_heat", mesh), glb.values("COLOR_0", mesh)))
            self.assertEqual((pairs[0][1][0], pairs[-1][1][0]), (0, 65535))
            middle = (pairs[0][0][0] + pairs[-1][0][0]) / 2
            _, color = min((abs(value - middle), color) for (value,), color in pairs)
            self.assertAlmostEqual(color[0] / 65535, 0.214, delta=0.05)  # half of sRGB, as linear light
            ranges.add((pairs[0][0], pairs[-1][0]))
        self.assertEqual(len(ranges), 2)

    def test_several_attributes_are_not_mixed_up(self):
        self.particles()
        for order in (("v", "p=pressure"), ("p=pressure", "v")):
            words = [word for name in order for word in ("--attribute", name)]
            self.convert("a.ply", "--radius", "0.25", *words, "--ascii", "-o", "out.ply")
            found = columns(self.folder / "out.ply")
            self.assertEqual(found["p"], found["v_0"])  # pressure is x
            for c, axis in enumerate("xyz"):
                for place, value in zip(found[axis], found[f"v_{c}"]):
                    self.assertAlmostEqual(value, min(max(place, 0), 4 * STEP), delta=0.6 * STEP)

    @needs_program("node")
    def test_everything_that_makes_the_file_smaller_keeps_them(self):
        self.particles()
        names = []
        for k, more in enumerate(((), ("--draco",), ("--quantize",), ("--quantize", "--meshopt", "--optimize-order"),
                                  ("--simplify", "0.2"), ("--normals", "flat"), ("--normals", "none"))):
            names.append(f"{k}.glb")
            self.convert("a.ply", "--radius", "0.25", "--attribute", "pressure", "--color-by", "pressure", *more, "-o",
                         names[-1])
            glb = Glb((self.folder / names[-1]).read_bytes())
            self.assertLessEqual({"COLOR_0", "_pressure"}, set(glb.primitive()["attributes"]), more)
        self.convert("a.ply", "--radius", "0.25", "--color-by", "pressure", "-o", "7.gltf")
        self.validate(*names, "7.gltf")
        # What was packed has both; without quantized positions the vertices are the same, and so are the values.
        self.convert("a.ply", "--radius", "0.25", "--attribute", "pressure", "--color-by", "pressure", "--meshopt", "-o",
                     "8.glb")
        for name in ("1.glb", "3.glb", "8.glb"):
            packed = json.loads(self.convert("compare", "0.glb", name, "--json").text)["attributes"]
            self.assertEqual({a["name"] for a in packed["both"]}, {"pressure", "color"})
            self.assertEqual(packed["same_vertices"], name == "8.glb")
        self.assertEqual([a["difference"]["largest"] for a in packed["both"]], [0, 0])

    @needs_program("node")
    def test_sequences(self):
        for k in range(3):
            self.particles(f"in_{k}.ply", 3 + k)
        run = self.convert("in_{}.ply", "--radius", "0.25", "--color-by", "pressure", "--animate", "-o", "all.glb")
        self.assertIn("--color-by pressure: the colors range from 0 to 2, the values of all 3 frames", run.err)
        other = self.convert("in_{}.ply", "--radius", "0.25", "--color-by", "p?=pressure:gray", "-o", "out_{}.glb")
        self.assertIn("--color-by p: the colors range from 0 to 2, the values of all 3 frames", other.err)
        self.convert("in_{}.ply", "--radius", "0.25", "--color-by", "p?=pressure:gray:0,2", "-o", "out_{}.glb")
        self.assertNotIn("MIN,MAX", self.convert("in_{}.ply", "--radius", "0.25", "--color-by", "pressure:0,2", "-o",
                                                 "out_{}.glb").err)
        self.validate("all.glb", *(f"out_{k}.glb" for k in range(3)))

    def test_other_files_of_a_sequence(self):
        for k in (1, 2):
            self.write(f"ball_{k:03}.nrrd", (self.folder / "ball.nrrd").read_bytes())
            self.write(f"heat_{k:03}.nrrd", nrrd((2, 2, 2), (20, 20, 20), (-4, -4, -4), lambda x, y, z, k=k: k))
        job = ("ball_{:03}.nrrd", "--iso", "0", "--attribute", "heat=heat_{:03}.nrrd", "--ascii", "-o", "out_{:03}.ply")
        self.convert(*job)
        for k in (1, 2):
            self.assertEqual(set(columns(self.folder / f"out_{k:03}.ply")["heat"]), {k})
        # What the attribute is read from counts for --resume.
        self.write("heat_002.nrrd", nrrd((2, 2, 2), (20, 20, 20), (-4, -4, -4), lambda x, y, z: 7))
        self.convert(*job, "--resume")
        self.assertEqual(set(columns(self.folder / "out_002.ply")["heat"]), {7})
        # And it is not written over.
        self.assert_fails(1, self.run_program("ball.nrrd", "--iso", "0", "--attribute", "h=linear.nrrd", "--format", "ply",
                                              "-o", "linear.nrrd"), "linear.nrrd")

    @needs_program("node")
    def test_surfaces_with_materials(self):
        isos = ("--iso", "2", "--iso", "0", "--iso", "1")
        self.convert("ball.nrrd", *isos, "--color-by", "iso:gray", "-o", "out.glb")
        glb = Glb((self.folder / "out.glb").read_bytes())
        looks = [glb.material(m) for m in range(3)]
        colors = [look["pbrMetallicRoughness"].get("baseColorFactor", [1, 1, 1, 1]) for look in looks]
        self.assertEqual([color[3] for color in colors], [1, 0.25, 0.625])
        self.assertEqual([color[0] for color in colors][:2], [1, 0])
        self.assertAlmostEqual(colors[2][0], 0.2140, delta=0.003)
        self.assertEqual([look.get("alphaMode", "OPAQUE") for look in looks], ["OPAQUE", "BLEND", "BLEND"])
        self.convert("ball.nrrd", *isos, "--color-by", "iso:0,4", "--opacity", "1,0.5,0.75", "-o", "set.gltf")
        self.convert("ball.nrrd", "--iso", "0", "--opacity", "0.5", "-o", "one.glb")
        one = Glb((self.folder / "one.glb").read_bytes()).material()
        self.assertEqual((one["alphaMode"], one["pbrMetallicRoughness"]["baseColorFactor"]),
                         ("BLEND", [0.8, 0.8, 0.8, 0.5]))
        self.validate("out.glb", "set.gltf", "one.glb")

    def test_compare_and_verify(self):
        heat = ("ball.nrrd", "--iso", "0", "--attribute", "heat=linear.nrrd")
        self.convert(*heat, "--color-by", "heat", "-o", "a.ply")
        self.convert(*heat, "--attribute", "more=linear.nrrd", "--color-by", "heat:plasma", "-o", "b.ply")
        self.convert(*heat, "--color-by", "heat", "-o", "c.glb", "--up", "y")
        text = self.convert("compare", "a.ply", "b.ply").text
        self.assertRegex(text, r"heat +the same values\n")
        self.assertRegex(text, r"more +only in the second mesh\n")
        self.assertRegex(text, r"color +largest difference 0\.\d+, at vertex \d+; mean 0\.\d+")
        self.assertRegex(self.convert("compare", "a.ply", "c.glb", "--up", "y").text, r"color +3 and 4 components")
        found = json.loads(self.convert("compare", "a.ply", "b.ply", "--json").text)["attributes"]
        (same,) = [match for match in found["both"] if match["name"] == "heat"]
        self.assertEqual((found["same_vertices"], found["b_only"], same["difference"]["largest"]), (True, ["more"], 0))
        for name in ("a.ply", "c.glb"):
            run = self.convert("verify", "ball.nrrd", "--iso", "0", name, *(("--up", "y") if name == "c.glb" else ()))
            self.assertIn("verify does not check attributes and colors of vertices: ", run.err)

    def test_what_is_refused(self):
        ball = ("ball.nrrd", "--iso", "0")
        for more, part in ((("--attribute", "a=linear.nrrd", "-o", "a.stl"), "stl cannot store vertex attributes"),
                           (("--color-by", "a=linear.nrrd", "-o", "a.obj"), "--color-by: obj cannot store vertex attributes"),
                           (("--color-by", "iso", "-o", "a.ply"), "--color-by iso: ply cannot store materials"),
                           (("--opacity", "0.5", "-o", "a.ply"), "--opacity: ply cannot store materials"),
                           (("--opacity", "0.5,0.6"), "one value, or one for each number of --iso"),
                           (("--opacity", "0"), "above 0"), (("--opacity", "1.5"), "at most 1"),
                           (("--attribute", "=a"), "NAME=FROM"), (("--attribute", "a="), "NAME=FROM"),
                           (("--color-by", "a:virids"), "did you mean 'viridis'?"),
                           (("--color-by", "a:1,1"), "MIN below MAX"),
                           (("--color-by", "a:0,1:gray"), "as in a:gray:0,1"),
                           (("--attribute", "a=linear.nrrd", "--attribute", "a=b"), "occurs twice"),
                           (("--attribute", "a=linear.nrrd", "--color-by", "a=b.nrrd"), "another name")):
            self.assert_fails(1, self.run_program(*ball, *more), part)
        for more, part in ((("--attribute", "heat"), "expected a file with grids, to read the attribute from its grid 'heat', found NRRD"),
                           (("--attribute", "heat=none.nrrd"), "none.nrrd"), (("--color-by", "x=a.raw"), "a.raw")):
            run = self.run_program(*ball, *more, "-o", "a.ply")
            self.assertIn(run.code, (1, 2), run.err)
            self.assertIn(part, run.err)
        # Options of the input do not help.
        (self.folder / "a.raw").write_bytes(bytes(8))
        for wrong, part in (("a=linear.nrrd[x]", "leave the name of a grid out"), ("a=a.raw", "a file format that states dimensions and sample type")):
            run = self.run_program(*ball, "--attribute", wrong, "-o", "a.ply")
            self.assertIn(part, run.err)
            self.assertNotRegex(run.err, "--(grid|dims)")
        self.particles()
        self.assert_fails(2, self.run_program("a.ply", "--color-by", "nix", "-o", "b.ply"), "no attribute" , "'nix'")
        self.assertFalse({"a.stl", "a.obj", "b.ply"} & set(self.files()))

    @needs_data("vdb/c42_gas_seq/fluid_data_0008.vdb")
    def test_other_grids_of_a_vdb_file(self):
        gas = GAS / "fluid_data_0008.vdb"
        run = self.convert(gas, "--grid", "density", "--iso", "0.5", "--attribute", "again=density", "--attribute",
                           f"other={gas}[density]", "--ascii", "-o", "out.ply")
        self.assertNotIn("outside", run.err)
        found = columns(self.folder / "out.ply")
        self.assertEqual(found["again"], found["other"])
        # Marching cubes puts vertices where the linear interpolant has the iso value.
        for value in found["again"]:
            self.assertAlmostEqual(value, 0.5, delta=1e-4)
        self.assert_fails(2, self.run_program(gas, "--grid", "density", "--iso", "0.5", "--attribute", "nix", "-o", "a.ply"),
                          "the attribute 'nix'", "nix", "choose one of the file's grids for the attribute\n", "\n  density ")

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    @needs_data("vdb/c42_gas_seq/fluid_data_0002.vdb")
    def test_a_grid_of_vectors_as_a_whole(self):
        gas = GAS / "fluid_data_0002.vdb"
        parts = [word for axis in "xyz" for word in ("--attribute", f"{axis}{axis}=velocity[{axis}]")]
        self.convert(gas, "--grid", "density", "--iso", "0.5", "--attribute", "v=velocity", *parts, "--color-by", "v:gray",
                     "--attribute", f"w={gas}[velocity]", "--ascii", "-o", "out.ply")
        found = columns(self.folder / "out.ply")
        for c, axis in enumerate("xyz"):
            self.assertEqual(found[f"v_{c}"], found[2 * axis])
            self.assertEqual(found[f"w_{c}"], found[2 * axis])
            self.assertGreater(len(set(found[2 * axis])), 100)
        # The longest is white, and the shortest black.
        lengths = [math.hypot(*v) for v in zip(found["v_0"], found["v_1"], found["v_2"])]
        self.assertEqual(found["red"][lengths.index(max(lengths))], 255)
        self.assertEqual(found["red"][lengths.index(min(lengths))], 0)

    @needs_data("particles/lammps_peri/peri_0500.csv")
    def test_millimetres(self):
        run = self.convert(PERI / "peri_0500.csv", "--radius", "0.00025", "--color-by", "damage:coolwarm:0,1", "--attribute",
                           "damage", "-o", "peri.ply")
        self.assertIn("damage, coolwarm from 0 to 1", run.err)
        self.assertGreater(len(read_ply((self.folder / "peri.ply").read_bytes()).vertices), 1000)

    def test_the_explanation_and_packed_files(self):
        (self.folder / "packed.nrrd.gz").write_bytes(gzip.compress(b"no volume"))
        run = self.convert("ball.nrrd", "--iso", "0", "--attribute", "heat=linear.nrrd", "--explain", "-o", "a.ply")
        self.assertIn("the attribute 'heat' from linear.nrrd: 6 x 7 x 5 samples of f64", run.err)
        self.assertRegex(run.err, r"attributes read in \d")
        self.assert_fails(2, self.run_program("ball.nrrd", "--iso", "0", "--attribute", "a=packed.nrrd.gz", "-o", "b.ply"),
                          "packed.nrrd.gz")


if __name__ == "__main__":
    main()
