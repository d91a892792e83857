"""Several --grid of one file: each has its own surfaces in one GLB, or a file each, with the iso values of all."""

import csv
import io
import json
import struct
import zipfile

from support import DATA, ProgramTest, main, needs_data, read_glb, read_obj
from vdb_files import grid, scale, vdb

BOTH = ("--grid", "density", "--grid", "flame")
PAIRS = [(name, iso) for name in ("density", "flame") for iso in (0.5, 1.0)]


def ball(radius, size=12):
    """Active voxels of a ball: 2 in the middle, 0 at its rim."""
    middle = (size - 1) / 2
    places = [(x, y, z) for x in range(size) for y in range(size) for z in range(size)]
    far = {place: sum((c - middle)**2 for c in place)**0.5 for place in places}
    return {place: 2 * (1 - distance / radius) for place, distance in far.items() if distance < radius}


def npy(values):
    side = round(len(values)**(1 / 3))
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({side}, {side}, {side}), }}".ljust(117) + "\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header.encode() + struct.pack(f"<{len(values)}f", *values)


class SeveralGridsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("fire.vdb", 5, 3)

    def write(self, name, density, flame):
        """Two balls with voxels of 1 and of 0.5, and a third grid to take colors from."""
        (self.folder / name).write_bytes(vdb(grid("density", ball(density)), grid("flame", ball(flame), transform=scale(0.5)),
                                             grid("heat", {place: float(place[0]) for place in ball(5)})))

    def read(self, name):
        return (self.folder / name).read_bytes()

    def meshes(self, name):
        return read_glb(self.read(name))

    def report(self, name="r.json"):
        return json.loads(self.read(name))

    def alone(self, name, iso, *options, source="fire.vdb", output="alone.glb"):
        """The bytes of a conversion of one grid."""
        self.convert(source, "--grid", name, "--iso", iso, *options, "-o", output)
        return self.read(output)

    def assert_meshes(self, meshes, expected, *options):
        """Names in their order, and the vertices and triangles of conversions of one grid and one iso value."""
        self.assertEqual(list(meshes), list(expected))
        for title, (name, iso) in expected.items():
            (mesh,) = read_glb(self.alone(name, iso, *options)).values()
            self.assertGreater(len(mesh.triangles), 0)
            self.assertEqual((meshes[title].vertices, meshes[title].triangles), (mesh.vertices, mesh.triangles), title)

    def test_surfaces_of_both_are_in_one_file(self):
        run = self.convert("fire.vdb", *BOTH, "--iso", 0.5, "--up", "y", "-o", "both.glb", "--report", "r.json")
        self.assert_meshes(self.meshes("both.glb"), {"density": ("density", 0.5), "flame": ("flame", 0.5)}, "--up", "y")
        self.assertIn("fire.vdb[density], fire.vdb[flame] iso 0.5 -> both.glb: ", run.err)
        self.assertIn("the other 1 grids of the file", self.read("r.json").decode())  # heat
        report = self.report()
        self.assertEqual([(one["grid"], one["iso"]) for one in report["extractions"]], [("density", 0.5), ("flame", 0.5)])
        self.assertEqual([(one["grid"], one["name"]) for one in report["meshes"]], [("density", "density"), ("flame", "flame")])
        self.assertEqual((report["input"]["name"], [one["name"] for one in report["more_grids"]]), ("density", ["flame"]))
        self.assertEqual((report["options"]["grid"], report["options"]["more_grids"]), ("density", ["flame"]))
        self.convert("fire.vdb", "--grid", "flame", "--grid", "density", "--iso", 0.5, "-o", "both.glb")
        self.assert_meshes(self.meshes("both.glb"), {"flame": ("flame", 0.5), "density": ("density", 0.5)})
        self.convert("fire.vdb", *BOTH, "--iso", 0.5, "-o", "both.obj")
        triangles = [len(mesh.triangles) for mesh in self.meshes("both.glb").values()]
        self.assertEqual(len(read_obj(self.read("both.obj")).triangles), sum(triangles))

    def test_standard_input_is_read_for_each(self):
        with open(self.folder / "fire.vdb", "rb") as file:
            self.convert("-", *BOTH, "--iso", 0.5, "-o", "both.glb", stdin=file)
        self.assert_meshes(self.meshes("both.glb"), {"density": ("density", 0.5), "flame": ("flame", 0.5)})

    def test_each_has_each_iso_value(self):
        self.convert("fire.vdb", *BOTH, "--iso", 0.5, "--iso", 1, "-o", "both.glb")
        self.assert_meshes(self.meshes("both.glb"), {f"{name} iso {iso:g}": (name, iso) for name, iso in PAIRS})
        run = self.convert("fire.vdb", *BOTH, "--iso", "auto", "--iso", 1, "-o", "both_{iso}.glb", "--report", "r.json", "--error")
        self.assert_meshes(self.meshes("both_1.glb"), {"density": ("density", 1), "flame": ("flame", 1)})
        self.assert_meshes(self.meshes("both_auto.glb"), {"density": ("density", "auto"), "flame": ("flame", "auto")})
        self.assertEqual(run.err.count("fire.vdb[flame]: iso auto is"), 1)  # though flame is read for each file
        report = self.report()
        self.assertEqual([one["name"] for one in report["more_grids"]], ["flame"])
        self.assertEqual(len(report["iso_values"]), 4)
        self.assertEqual([one["grid"] for one in report["meshes"]], ["density", "flame"] * 2)

    def test_a_file_each_with_the_bytes_of_one_grid(self):
        options = ("--up", "y", "--color-by", "heat")
        self.convert("fire.vdb", *BOTH, "--iso", 0.5, "--iso", 1, *options, "-o", "{grid}_{iso}.ply", "--report", "r.json")
        for name, iso in PAIRS:
            alone = self.alone(name, iso, *options, output="alone.ply")
            self.assertEqual(self.read(f"{name}_{iso:g}.ply"), alone, (name, iso))
        self.assertEqual([(one["grid"], one["iso"], one["file"]) for one in self.report()["meshes"]],
                         [(name, iso, f"{name}_{iso:g}.ply") for name, iso in PAIRS])
        self.assertEqual([(one["path"], one["grid"]) for one in self.report()["options"]["outputs"]],
                         [(f"{name}_{iso:g}.ply", name) for name, iso in PAIRS])
        run = self.run_program("fire.vdb", *BOTH, "--iso", 0.5, "-o", "one.ply")
        self.assert_fails(1, run, "fire.vdb: one ply file holds one surface, found 2 grids", "{grid}")

    def test_sequences_tables_and_records(self):
        for frame in (1, 2):
            self.write(f"f_{frame}.vdb", 4 + frame, 2 + frame)
        both = ("f_{}.vdb", *BOTH, "--iso", 0.5, "--iso", 1)
        self.convert(*both, "-o", "o_{}.glb", "--table", "t.csv", "--error", "--jobs", 2)
        rows = list(csv.DictReader(io.StringIO(self.read("t.csv").decode())))
        self.assertEqual([(row["frame"], row["grid"], float(row["iso"])) for row in rows],
                         [(str(frame), name, iso) for frame in (1, 2) for name, iso in PAIRS])
        figures = []
        for row in rows:
            mesh = self.meshes(f"o_{row['frame']}.glb")[f"{row['grid']} iso {row['iso']}"]
            self.assertEqual((int(row["triangles"]), int(row["vertices"])), (len(mesh.triangles), len(mesh.vertices)))
            self.alone(row["grid"], row["iso"], "--error", "--table", "one.csv", "--jobs", 1, source=f"f_{row['frame']}.vdb")
            (one,) = csv.DictReader(io.StringIO(self.read("one.csv").decode()))
            self.assertEqual(one["grid"], "")
            for name in ("area", "volume", "closed", "components", "error_rms", "error_max", "coverage_rms", "coverage_max"):
                self.assertEqual(row[name], one[name], (row, name))
            figures.append(row["volume"])
        self.assertEqual(len(set(figures)), 8)
        again = self.convert(*both, "-o", "o_{}.glb", "--table", "t.json", "--error", "--resume")
        self.assertIn("2 kept", again.err)
        kept = [one for frame in json.loads(self.read("t.json")) for one in frame["surfaces"]]
        self.assertEqual([(one["grid"], one["triangles"]) for one in kept], [(row["grid"], int(row["triangles"])) for row in rows])
        other = self.convert("f_{}.vdb", "--grid", "density", "--grid", "heat", "--iso", 0.5, "--iso", 1, "-o", "o_{}.glb", "--error", "--resume")
        self.assertNotIn("kept", other.err)
        self.convert(*both, "-o", "{grid}_{frame:02}_{iso}.ply")
        self.assertEqual(self.read("flame_02_1.ply"), self.alone("flame", 1, source="f_2.vdb", output="alone.ply"))
        self.assertEqual(sum(name.endswith("0.5.ply") for name in self.files()), 4)
        self.convert(*both, "-o", "all.glb", "--animate")
        self.assertIn(b"flame iso 1", self.read("all.glb"))

    def test_records_of_one_grid_are_as_before(self):
        """A manifest of before names no grid in its records, and is read."""
        self.write("f_1.vdb", 5, 3)
        self.write("f_2.vdb", 4, 3)
        command = ("f_{}.vdb", "--grid", "flame", "--iso", 0.5, "-o", "out/o_{}.glb", "--mkdir")
        self.convert(*command)
        records = [json.loads(line.partition(" ")[2]) for line in self.read("out/isoextract.manifest").decode().splitlines()[1:]]
        surfaces = [one for record in records for one in record.get("figures", {}).get("surfaces", [])]
        self.assertEqual(len(surfaces), 2)
        for surface in surfaces:
            self.assertNotIn("grid", surface)
        self.assertIn("2 kept", self.convert(*command, "--resume").err)

    def test_a_grid_without_a_surface(self):
        run = self.run_program("fire.vdb", *BOTH, "--iso", 99, "-o", "both.glb")
        self.assert_fails(2, run, "fire.vdb[density]: no surface at iso 99")
        self.write("fire.vdb", 5, 0.1)  # the flame has no voxel
        self.assert_fails(2, self.run_program("fire.vdb", *BOTH, "--iso", 0.5, "-o", "both.glb"), "fire.vdb[flame]")
        self.assertEqual(self.files(), ["fire.vdb"])
        run = self.convert("fire.vdb", *BOTH, "--iso", 0.5, "--iso", 1, "--empty", "skip", "-o", "both.glb", "--report", "r.json")
        self.assertIn("note[no-surface]: fire.vdb[flame]: no surface at iso 0.5, 1; both.glb contains only the other surfaces\n", run.err)
        self.assertNotIn("fire.vdb[density]: no surface", run.err)
        self.assert_meshes(self.meshes("both.glb"), {"density iso 0.5": ("density", 0.5), "density iso 1": ("density", 1)})
        run = self.convert("fire.vdb", *BOTH, "--iso", 0.5, "--empty", "skip", "-o", "{grid}.glb")
        self.assertIn("note[no-surface]: fire.vdb[flame]: no surface at iso 0.5; the conversion did not write flame.glb\n", run.err)

    def test_what_is_told_names_the_grid(self):
        wall = {(x, y, z): 2.0 for x in range(4) for y in range(4) for z in range(4)}
        (self.folder / "fire.vdb").write_bytes(vdb(grid("density", wall, background=2.0), grid("flame", ball(5))))
        run = self.convert("fire.vdb", *BOTH, "--iso", 1, "--error", "--roi", "1,1,1,5,20,20", "-o", "both.glb", "--empty", "skip")
        self.assertIn("fire.vdb[density]: no surface at iso 1", run.err)
        self.assertIn("-> both.glb: ", run.err)
        self.assertIn("  fire.vdb[flame]: error", run.err)
        run = self.convert("fire.vdb", "--grid", "flame", "--grid", "density", "--iso", 1, "--smooth", 2, "-o", "both.glb", "--empty", "skip")
        self.assertIn("  fire.vdb[flame]: ", run.err)

    def test_ends_are_those_of_each_surface(self):
        values = [2 - 0.4 * sum((c - 3)**2 for c in (n % 7, n // 7 % 7, n // 49))**0.5 for n in range(343)]
        self.write_npz(inner=values, cut=[value + 1 for value in values])
        run = self.convert("both.npz", "--grid", "cut", "--grid", "inner", "--iso", 1, "-o", "both.glb")
        self.assertIn("open at the data boundary of both.npz[cut] iso 1 (--cap closes it)", run.err)
        self.assertIn("; closed; ", self.convert("both.npz", "--grid", "cut", "--grid", "inner", "--iso", 1, "--cap", "-o", "both.glb").err)

    def write_npz(self, **arrays):
        with zipfile.ZipFile(self.folder / "both.npz", "w") as archive:
            for name, values in arrays.items():
                archive.writestr(f"{name}.npy", npy(values))

    def test_samples_on_a_gpu_are_those_of_each_grid(self):
        values = [2 - 0.4 * sum((c - 3)**2 for c in (n % 7, n // 7 % 7, n // 49))**0.5 for n in range(343)]
        self.write_npz(density=values, flame=[value / 2 for value in values])
        for backend in ("cpu", "gpu"):
            self.convert("both.npz", *BOTH, "--iso", 0.9, "--iso", 0.95, "--cap", "--backend", backend, "-o", f"{backend}.glb")
        meshes = [{name: set(mesh.vertices) for name, mesh in self.meshes(f"{backend}.glb").items()} for backend in ("cpu", "gpu")]
        self.assertEqual(len(meshes[0]), 4)
        self.assertEqual({name: len(one) for name, one in meshes[0].items()}, {name: len(one) for name, one in meshes[1].items()})

    def test_attributes_and_edits_are_of_each_surface(self):
        self.convert("fire.vdb", *BOTH, "--iso", 0.5, "--color-by", "heat", "--simplify", "0.5", "--smooth", 2, "--largest", "-o", "both.glb",
                     "--report", "r.json")
        report = self.report()
        for section in ("attributes", "colors", "pieces", "smoothings", "simplifications"):
            self.assertEqual([one["grid"] for one in report[section]], ["density", "flame"], section)
        self.assertNotEqual(report["colors"][0]["range"], report["colors"][1]["range"])

    def test_a_missing_grid_is_refused_before_the_work(self):
        run = self.run_program("fire.vdb", *BOTH, "--grid", "none", "--iso", 0.5, "-o", "{grid}.glb")
        self.assert_fails(2, run, "fire.vdb: there is no grid 'none'", "density", "flame", "heat")
        self.assertEqual(self.files(), ["fire.vdb"])
        self.write("f_1.vdb", 5, 3)
        (self.folder / "f_2.vdb").write_bytes(vdb(grid("density", ball(5))))
        run = self.convert("f_1.vdb", "--jobs", 1, *BOTH, "--iso", 0.5, "-o", "{grid}_{}.glb", "--dry-run")
        self.assertIn("flame_1.glb", run.text + run.err)
        run = self.run_program("f_{}.vdb", *BOTH, "--iso", 0.5, "-o", "{grid}_{}.glb")
        self.assertEqual(run.code, 5)
        self.assertIn("f_2.vdb: there is no grid 'flame'", run.err)
        self.assertEqual([name for name in self.files() if name.endswith(".glb")], ["density_1.glb", "flame_1.glb"])
        (self.folder / "two.vdb").write_bytes(vdb(grid("smoke", ball(5)), grid("smoke", ball(4))))
        run = self.run_program("two.vdb", "--grid", "smoke", "--grid", "smoke[1]", "--iso", 0.5, "-o", "a.glb")
        self.assert_fails(2, run, "2 grids are named 'smoke'")
        self.convert("two.vdb", "--grid", "smoke[0]", "--grid", "smoke[1]", "--iso", 0.5, "-o", "a.glb")
        self.assertEqual(list(self.meshes("a.glb")), ["smoke[0]", "smoke[1]"])
        run = self.run_program("demo:sphere?size=8", *BOTH, "--iso", 0.5, "-o", "a.glb")
        self.assert_fails(1, run, "a grid name applies to formats with named grids")

    def test_what_is_of_one_grid_is_refused(self):
        for options, part in ((("--center",), "--center"), (("--draco",), "--draco"), (("--quantize",), "--quantize"),
                              (("--split-components",), "--split-components"), (("--space", "index"), "--space index"),
                              (("--particles", "sph"), "particles"), (("--grid", "flame"), "--grid flame occurs twice")):
            run = self.run_program("fire.vdb", *BOTH, "--iso", 0.5, *options, "-o", "both.glb")
            self.assert_fails(1, run, part, "hint: convert each grid in a run of its own" if "flame" not in options else "hint: ")
        self.assert_fails(1, self.run_program("fire.vdb", *BOTH, "--labels", "1", "-o", "both.glb"), "--labels")
        self.assert_fails(1, self.run_program("fire.vdb", *BOTH, "-o", "both.vdb"), "a field as output is one grid")
        for command in (("info",), ("verify", "--iso", 0.5), ("render", "-o", "a.png"), ("bench", "--iso", 0.5)):
            run = self.run_program(*command, "fire.vdb", *BOTH)
            self.assert_fails(1, run, f"{command[0]} takes one --grid, found 2")
        self.assertEqual(self.files(), ["fire.vdb"])

    @needs_data("vdb/c42_gas_seq/fluid_data_0010.vdb")
    def test_density_and_flame_of_a_simulation(self):
        name = DATA / "vdb/c42_gas_seq/fluid_data_0010.vdb"
        self.convert(name, "--grid", "density", "--grid", "temperature", "--iso", 0.3, "-o", "sim.glb")
        self.assertEqual(list(self.meshes("sim.glb")), ["density", "temperature"])


if __name__ == "__main__":
    main()
