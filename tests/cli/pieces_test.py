"""--largest, --drop-components, --fill-cavities, --split-components, --smooth and --blur: what is left, told and reported."""

import json
import math
import random

from support import DATA, SPHERE, ProgramTest, main, needs_data, read_glb, read_ply, read_stl

SIDE = 40
# Center, radius: a ball with a cavity with a pebble in it, and a small ball.
BALLS = (((15.2, 15.3, 15.1), 12), ((15.1, 15.4, 15.2), 8), ((15.3, 15.2, 15.5), 4), ((34.2, 34.1, 33.8), 3))
RAW = ("--dims", f"{SIDE},{SIDE},{SIDE}", "--dtype", "f32", "--iso", "0")


def depth(point):
    """Inside in an odd number of the balls."""
    depths = [radius - math.dist(center, point) for center, radius in BALLS]
    size = min(abs(d) for d in depths)
    return size if sum(d > 0 for d in depths) % 2 else -size


def ball_volume(radius):
    return 4 / 3 * math.pi * radius**3


class PiecesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_raw("balls.raw", (SIDE, SIDE, SIDE), lambda x, y, z: depth((x, y, z)))

    def balls(self, *arguments, output="a.ply"):
        run = self.convert("balls.raw", *RAW, *arguments, "-o", output, "--report", "report.json")
        report = json.loads((self.folder / "report.json").read_text())
        return run, report

    def test_each_piece_is_told_to_be_closed(self):
        run = self.convert("balls.raw", *RAW, "--split-components", "-o", "{piece}.ply")
        told = [line for line in run.err.splitlines() if " -> " in line]
        self.assertGreater(len(told), 1)
        for line in told:
            self.assertIn("; closed; ", line)

    def test_the_largest_with_its_cavity(self):
        run, report = self.balls("--largest")
        (mesh,) = report["meshes"]
        self.assertEqual((mesh["components"], mesh["closed"]), (2, True))
        self.assertAlmostEqual(mesh["volume"], ball_volume(12) - ball_volume(8), delta=0.03 * ball_volume(12))
        (record,) = report["pieces"]
        self.assertEqual((record["before"]["components"], record["before"]["bodies"]), (4, 3))
        self.assertEqual((record["after"]["components"], record["after"]["bodies"]), (2, 1))
        self.assertEqual(record["after"]["triangles"], mesh["triangles"])
        self.assertIn("components at iso 0: kept 1 of 3 bodies, 1 of 1 cavity, ", run.err)
        self.assertEqual(self.balls("--largest", "2")[1]["meshes"][0]["components"], 3)
        self.assertEqual(self.balls("--largest", "--fill-cavities")[1]["meshes"][0]["components"], 1)
        # The number is left out before an input.
        self.convert("--largest", "balls.raw", *RAW, "-o", "b.ply")
        self.convert("balls.raw", *RAW, "--largest", "1", "-o", "c.ply")
        self.assertEqual((self.folder / "b.ply").read_bytes(), (self.folder / "c.ply").read_bytes())

    def test_small_ones_go(self):
        for least, left in (("2", 4), ("area:130", 3), ("area:230", 2), (f"volume:{ball_volume(5)}", 2),
                            ("volume:2500voxel", 1)):
            self.assertEqual(self.balls("--drop-components", least)[1]["meshes"][0]["components"], left, least)
        # A hundredth of everything: areas a ten thousandth.
        for least, left in (("area:0.0130world", 3), ("area:130", 3), ("volume:0.0025world", 1)):
            report = self.balls("--spacing", "0.01", "--drop-components", least)[1]
            self.assertEqual(report["meshes"][0]["components"], left, least)
        # Bars of exactly three voxels, at many places: rounding decides nothing.
        self.write_raw("bars.raw", (64, 64, 64), lambda x, y, z: float(x % 4 == y % 4 == 1 and z % 6 > 2 and z < 60))
        bars = ("bars.raw", "--dims", "64,64,64", "--dtype", "f32", "--iso", "0.5", "-o", "bars.ply")
        for spacing, method in (("0.7", "voxels"), ("0.9", "voxels"), ("1", "surface-nets"), ("0.9", "surface-nets")):
            for least in ("volume:3", f"volume:{3 * float(spacing) ** 3:.12g}world", "area:14"):
                run = self.convert(*bars, "--spacing", spacing, "--method", method, "--drop-components", least)
                self.assertIn("kept 2560 of 2560 bodies", run.err, (spacing, method, least))
            run = self.run_program(*bars, "--spacing", spacing, "--method", method, "--drop-components", "volume:3.01")
            self.assertIn("none of the 2560 components", run.err)
        run = self.run_program("balls.raw", *RAW, "--drop-components", "999999", "-o", "none.ply")
        self.assert_fails(2, run, "none of the 4 components at iso 0 has the requested size", "--empty skip")
        self.convert("balls.raw", *RAW, "--drop-components", "999999", "--empty", "skip", "-o", "none.ply")
        run = self.convert("balls.raw", *RAW, "--drop-components", "999999", "--empty", "write", "--split-components", "-o",
                           "none_{piece}.ply")
        self.assertIn("the conversion did not write none_{piece}.ply", run.err)
        self.convert("balls.raw", *RAW, "--drop-components", "999999", "--empty", "write", "--split-components", "-o", "none.glb")
        self.assertIn("none.glb", self.files())
        self.assertNotIn("none.ply", self.files())

    def test_a_mesh_a_piece(self):
        _, report = self.balls("--split-components", output="a.glb")
        meshes = report["meshes"]
        self.assertEqual([mesh["name"] for mesh in meshes], [f"balls piece {n}" for n in (1, 2, 3)])
        self.assertEqual([mesh["components"] for mesh in meshes], [2, 1, 1])
        self.assertEqual(sorted((mesh["area"] for mesh in meshes), reverse=True), [mesh["area"] for mesh in meshes])
        self.assertEqual(len(read_glb((self.folder / "a.glb").read_bytes())), 3)

    def test_a_file_a_piece(self):
        run, report = self.balls("--split-components", "--drop-components", "area:130", output="part_{piece}.stl")
        self.assertEqual([name for name in self.files() if name.startswith("part")], ["part_1.stl", "part_2.stl"])
        self.assertEqual([file["path"] for file in report["files"]], ["part_1.stl", "part_2.stl"])
        triangles = [len(read_stl((self.folder / f"part_{n}.stl").read_bytes()).triangles) for n in (1, 2)]
        self.assertEqual(triangles, [mesh["triangles"] for mesh in report["meshes"]])
        self.assertIn("iso 0 -> part_2.stl: ", run.err)

    def test_too_many_pieces(self):
        self.write_raw("spots.raw", (23, 23, 23), lambda x, y, z: x & y & z & 1, "B")
        options = ("--dims", "23,23,23", "--dtype", "u8", "--iso", "0.5")
        run = self.run_program("spots.raw", *options, "--split-components", "-o", "s_{piece}.ply")
        self.assert_fails(2, run, "error: spots.raw iso 0.5: the surface has 1331 bodies", "--largest N")
        self.convert("spots.raw", *options, "-o", "mesh.ply")
        run = self.run_program("mesh.ply", "--split-components", "-o", "s_{piece}.ply")
        self.assert_fails(2, run, "error: mesh.ply: the surface has 1331 bodies")

    def test_the_table_of_components(self):
        (mesh,) = self.balls()[1]["meshes"]
        table = mesh["component_table"]
        self.assertEqual(table["others"], {"components": 0, "triangles": 0})
        self.assertEqual([row["cavity"] for row in table["largest"]], [False, True, False, False])
        for row, radius in zip(table["largest"], (12, 8, 4, 3)):
            self.assertAlmostEqual(abs(row["volume"]), ball_volume(radius), delta=0.1 * ball_volume(radius))
            self.assertEqual((row["closed"], row["genus"], row["volume"] < 0), (True, 0, row["cavity"]))
            self.assertAlmostEqual(row["bounds"]["max"][0] - row["bounds"]["min"][0], 2 * radius, delta=0.3)
        self.assertEqual(sum(row["triangles"] for row in table["largest"]), mesh["triangles"])
        noise = random.Random(1)
        self.write_raw("noise.raw", (24, 24, 24), lambda *_: noise.random())
        self.convert("noise.raw", "--dims", "24,24,24", "--dtype", "f32", "--iso", "0.8", "-o", "n.ply", "--report",
                     "n.json")
        (mesh,) = json.loads((self.folder / "n.json").read_text())["meshes"]
        table = mesh["component_table"]
        self.assertEqual(len(table["largest"]), 100)
        self.assertEqual(table["others"]["components"], mesh["components"] - 100)

    def test_usage(self):
        for option, wrong in (("--drop-components", ("0", "-1", "1.5", "area:", "area:0", "triangles:5", "5mm3", "volume:x")),
                              ("--largest", ("0", "-1")),
                              ("--smooth", ("0", "1001", "x", "5:median", "5:sinc:1", "5:sinc:0", "5:sinc:0.1:2", "")),
                              ("--blur", ("0", "-1", "17", "1mm", "median", "median:0", "median:9", "mean:1", "nan", ""))):
            for value in wrong:
                self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", f"{option}={value}", "-o", "a.ply"), option)
        split = (SPHERE, "--iso", "0", "--split-components")
        self.assert_fails(1, self.run_program(*split, "-o", "a.stl"), "{piece}.stl")
        self.assert_fails(1, self.run_program(*split, "--error", "-o", "a.glb"), "--error")
        self.assert_fails(1, self.run_program(*split, "--iso", "1", "-o", "a_{piece}.stl"), "{iso}")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "-o", "a_{piece}.stl"), "--split-components")
        self.assert_fails(1, self.run_program(SPHERE, "--largest", "-o", "a.vdb"), "--largest")
        self.assert_fails(1, self.run_program("balls.raw", *RAW[:4], "--method", "voxels", "--labels", "all", "--blur",
                                              "1", "-o", "a.glb"), "--blur")
        self.assertEqual(self.files(), ["balls.raw"])

    def test_a_piece_is_never_written_over_the_input(self):
        (self.folder / "part_2.ply").write_bytes((self.folder / "balls.raw").read_bytes())
        run = self.run_program("part_2.ply", "--input-format", "raw", *RAW, "--split-components", "-o", "part_{piece}.ply")
        self.assertEqual(run.code, 1, run.err)
        self.assertIn("part_2.ply: this is the input, and the mesh of a body of part_2.ply may get the same name; "
                      "the program does not overwrite its input", run.err)
        self.assertNotIn("part_1.ply", self.files())


class SmoothTest(ProgramTest):
    def test_triangles_without_area_are_told(self):
        """Many passes pull the sheets of a gyroid of voxels together."""
        boxes = ("demo:gyroid?size=16", "--iso", "0.5", "--method", "voxels", "-o", "a.ply", "--report", "a.json")
        for passes in (20, 200):
            run = self.convert(*boxes, "--smooth", passes)
            report = json.loads((self.folder / "a.json").read_text())
            counted = report["smoothings"][0]["zero_area_triangles"]
            self.assertEqual(counted, {"before": 0, "after": report["meshes"][0]["zero_area_triangles"]})
            note = (f"note[zero-area]: demo:gyroid?size=16 iso 0.5: smoothing left {counted['after']} of "
                    f"{report['meshes'][0]['triangles']} triangles without area (before: 0)\n")
            self.assertEqual(note in run.err, counted["after"] > 0, run.err)
            self.assertEqual(counted["after"] > 0, passes == 200)

    def test_told_and_measured(self):
        self.convert("demo:gyroid?size=32", "--iso", "0", "--cap", "-o", "full.ply")
        run = self.convert("demo:gyroid?size=32", "--iso", "0", "--cap", "--smooth", "20:sinc", "--error", "-o", "a.ply",
                           "--report", "a.json")
        report = json.loads((self.folder / "a.json").read_text())
        (record,) = report["smoothings"]
        self.assertEqual((record["method"], record["passes"], record["border_vertices"]), ("sinc", 20, 0))
        self.assertGreater(record["cap_vertices"], 100)
        full, smooth = (read_ply((self.folder / name).read_bytes()) for name in ("full.ply", "a.ply"))
        self.assertEqual(full.triangles, smooth.triangles)
        most = max(math.dist(a, b) for a, b in zip(full.vertices, smooth.vertices))
        self.assertAlmostEqual(record["greatest_move"]["world"], most, delta=1e-5)
        (mesh,) = report["meshes"]
        self.assertTrue(mesh["closed"])
        self.assertAlmostEqual(record["volume"]["after"], mesh["volume"], delta=1e-6 * mesh["volume"])
        self.assertLess(abs(record["volume"]["after"] / record["volume"]["before"] - 1), 0.01)
        self.assertRegex(run.err, r"smoothed at iso 0: 20 passes of sinc, pass band 0.1; vertices moved by at most \S+ voxels, "
                                  r"in the mesh's units \S+; volume \S+ % (more|less); \d+ vertices of caps stayed")
        # Vertices are no longer on the surface of the data, and the error says so.
        self.assertGreater(mesh["error"]["vertices"]["max"]["voxels"], 0.01)
        self.assertLess(mesh["error"]["vertices"]["max"]["voxels"], most / mesh_voxel(report) + 0.1)

    def test_every_format_and_any_number_of_threads(self):
        for name in ("a.glb", "a.stl", "a.obj"):
            written = []
            for threads in (1, 3):
                self.convert("demo:gyroid?size=32", "--iso", "0", "--blur", "median:1", "--blur", "0.8", "--smooth", "5",
                             "--largest", "--threads", threads, "-o", name)
                written.append((self.folder / name).read_bytes())
            self.assertEqual(*written)

    def test_normals_follow(self):
        self.convert(SPHERE, "--iso", "0", "--normals", "smooth", "--smooth", "10", "-o", "a.ply")
        mesh = read_ply((self.folder / "a.ply").read_bytes())
        center = [sum(axis) / len(mesh.vertices) for axis in zip(*mesh.vertices)]
        for vertex, normal in zip(mesh.vertices, mesh.normals):
            outward = [a - b for a, b in zip(vertex, center)]
            self.assertGreater(sum(a * b for a, b in zip(outward, normal)), 0.97 * math.hypot(*outward))

    def test_with_attributes_colors_and_simplify(self):
        self.write_raw("a.raw", (24, 24, 24), lambda x, y, z: 9 - math.dist((x, y, z), (11.4, 11.6, 11.5)))
        run = self.convert("a.raw", "--dims", "24,24,24", "--dtype", "f32", "--iso", "0", "--smooth", "5", "--simplify",
                           "0.1", "--color-by", "iso", "-o", "a.glb")
        at = [run.err.index(word) for word in ("smoothed at", "simplified at")]
        self.assertEqual(at, sorted(at))

    @needs_data("med/MR.nii.gz")
    def test_a_scan_for_the_printer(self):
        self.convert(DATA / "med/MR.nii.gz", "--iso", "60", "--cap", "--blur", "1", "--largest", "--fill-cavities", "--smooth",
                     "10", "-o", "a.stl", "--report", "a.json")
        (mesh,) = json.loads((self.folder / "a.json").read_text())["meshes"]
        self.assertEqual((mesh["closed"], mesh["components"], mesh["zero_area_triangles"]), (True, 1, 0))


def mesh_voxel(report):
    rows = report["output_from_index"]
    return math.hypot(*(row[0] for row in rows))


class BlurTest(ProgramTest):
    def test_a_spike_becomes_a_gaussian(self):
        # Of a spike of 1000, the sample at distance d is 1000 w(d) / sum of w; the surface at that value goes through it.
        self.write_raw("spike.raw", (21, 21, 21), lambda x, y, z: 1000 if (x, y, z) == (10, 10, 10) else 0)
        line = [math.exp(-d * d / (2 * 1.5**2)) for d in range(-5, 6)]
        peak = 1000 / sum(line) ** 3
        iso = peak * math.exp(-(3**2) / (2 * 1.5**2))
        for blur, spacing in (("1.5", "1"), ("1.5voxel", "2"), ("3world", "2")):
            self.convert("spike.raw", "--dims", "21,21,21", "--dtype", "f32", "--spacing", spacing, "--blur", blur, "--iso", iso,
                         "--explain", "-o", "a.ply")
            mesh = read_ply((self.folder / "a.ply").read_bytes())
            reach = max(vertex[0] for vertex in mesh.vertices) / float(spacing) - 10
            self.assertAlmostEqual(reach, 3, delta=0.01)

    def test_median_takes_single_samples(self):
        self.write_raw("spikes.raw", (24, 24, 24), lambda x, y, z: 9 - math.dist((x, y, z), (11.5,) * 3)
                       if (x * 7 + y * 5 + z * 3) % 31 else 100)
        arguments = ("spikes.raw", "--dims", "24,24,24", "--dtype", "f32", "--iso", "0", "--report", "a.json", "-o", "a.ply")
        components = []
        for more in ((), ("--blur", "median:1")):
            run = self.convert(*arguments, *more)
            components.append(json.loads((self.folder / "a.json").read_text())["meshes"][0]["components"])
        self.assertGreater(components[0], 100)
        self.assertEqual(components[1], 1)
        self.assertIn("  blurred: the samples by a median of 1 voxel on either side: 13824 samples of f32", run.err)
        options = json.loads((self.folder / "a.json").read_text())["options"]
        self.assertEqual(options["blurs"], [{"kind": "median", "width": 1, "in_world_units": False}])

    def test_the_error_is_that_against_the_data(self):
        errors = []
        for more in ((), ("--blur", "2")):
            self.convert("demo:gyroid?size=32", "--iso", "0", *more, "--error", "-o", "a.ply", "--report", "a.json")
            (mesh,) = json.loads((self.folder / "a.json").read_text())["meshes"]
            errors.append(mesh["error"]["vertices"]["max"]["voxels"])
        self.assertLess(errors[0], 1e-3)
        self.assertGreater(errors[1], 0.01)

    def test_a_level_set_stays_sparse(self):
        run = self.convert("demo:sphere?size=64", "--iso", "0", "--resolution", "64", "--blur", "1", "-o", "dense.ply")
        self.assertIn("the samples by a Gaussian of 1 voxel: ", run.err)
        self.assertIn("closed", run.err)
        run = self.run_program("verify", SPHERE, "--iso", "0", "--blur", "1", "--json")
        self.assertEqual(run.code, 0, run.err)
        found = json.loads(run.out)
        self.assertTrue(found["passed"] and found["triangles"][0] == found["triangles"][1] > 0, found)

    def test_too_wide_in_the_world(self):
        run = self.run_program(SPHERE, "--iso", "0", "--spacing", "0.01", "--blur", "1world", "-o", "a.ply")
        self.assert_fails(1, run, "100 x 100 x 100 voxels; the limit is 16 voxels")


if __name__ == "__main__":
    main()
