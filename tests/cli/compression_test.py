"""--draco, --quantize, --meshopt, --optimize-order and .drc: smaller files, what they lose told, measured and reported."""

import json
import random
import re
import struct

from support import DATA, SPHERE, ProgramTest, main, needs_data

GYROID = "demo:gyroid?size=32"
WAYS = {
    "draco": ["--draco"],
    "draco12": ["--draco=12"],
    "quantize": ["--quantize"],
    "meshopt": ["--meshopt"],
    "both": ["--quantize", "--meshopt"],
    "all": ["--quantize", "--meshopt", "--optimize-order"],
}


def gltf_json(path):
    """The JSON of a .glb or .gltf."""
    data = path.read_bytes()
    if path.suffix == ".gltf":
        return json.loads(data)
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length])


def quantized_places(path):
    """Positions of 16 bits where the one node of a .glb places them."""
    model = gltf_json(path)
    data = path.read_bytes()
    (json_length,) = struct.unpack_from("<I", data, 12)
    (node,) = [node for node in model["nodes"] if "mesh" in node]
    accessor = model["accessors"][model["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    view = model["bufferViews"][accessor["bufferView"]]
    first = 28 + json_length + view.get("byteOffset", 0)
    scale, origin = node["scale"][0], node["translation"]
    for index in range(accessor["count"]):
        place = struct.unpack_from("<3H", data, first + index * view["byteStride"])
        yield tuple(origin[axis] + scale * place[axis] for axis in range(3))


class CompressionTest(ProgramTest):
    def packed(self, name, *arguments):
        """A conversion that packs: its run and the one record of its report."""
        run = self.convert(*arguments, "-o", name, "--report", f"{name}.json")
        (record,) = json.loads((self.folder / f"{name}.json").read_text())["packings"]
        return run, record

    def compare(self, a, b):
        return json.loads(self.convert("compare", "--json", a, b).text)

    def test_every_way(self):
        self.convert(GYROID, "--iso", "0", "-o", "plain.glb")
        plain = (self.folder / "plain.glb").stat().st_size
        for name, options in WAYS.items():
            for extension in ("glb", "gltf"):
                with self.subTest(name=name, extension=extension):
                    file = f"{name}.{extension}"
                    run, record = self.packed(file, GYROID, "--iso", "0", *options)
                    self.assertIn("packed by ", run.err)
                    report = self.compare("plain.glb", file)
                    for fact in ("vertices", "triangles", "components", "open_edges", "closed"):
                        self.assertEqual(report["a"][fact], report["b"][fact], fact)
                    size = sum((self.folder / part).stat().st_size for part in self.files()
                               if part in (file, f"{name}.bin"))
                    self.assertLess(record["bytes_after"], record["bytes_before"])
                    self.assertLess(record["bytes_after"], size)
                    if extension == "glb":
                        self.assertLess(size, plain)
                    positions = record["positions"]
                    if name == "meshopt":
                        self.assertIsNone(positions)
                        self.assertIn("; lossless", run.err)
                        self.assertEqual(report["hausdorff"][1], 0)
                        continue
                    measured = positions["measured"]
                    self.assertGreater(measured["distance"]["world"], 0)
                    self.assertLessEqual(measured["axis"]["world"], positions["step"]["world"] / 2)
                    self.assertLessEqual(report["hausdorff"][0], measured["distance"]["world"] + report["resolution"])
                    if name != "draco12":
                        self.assertLessEqual(positions["step"]["voxels"], 1 / 32)
                    self.assertIn("vertices moved by at most", run.err)

    def test_what_the_json_requires(self):
        for name, extensions in {"draco": ["KHR_draco_mesh_compression"], "quantize": ["KHR_mesh_quantization"],
                                 "both": ["EXT_meshopt_compression", "KHR_mesh_quantization"]}.items():
            self.convert(SPHERE, "--iso", "0", *WAYS[name], "-o", "a.glb")
            model = gltf_json(self.folder / "a.glb")
            self.assertEqual(sorted(model["extensionsRequired"]), extensions)
            self.assertEqual(sorted(model["extensionsUsed"]), extensions)

    def test_drc(self):
        self.convert(SPHERE, "--iso", "0", "-o", "plain.ply")
        _, record = self.packed("a.drc", SPHERE, "--iso", "0")
        report = self.compare("plain.ply", "a.drc")
        self.assertEqual(report["a"]["triangles"], report["b"]["triangles"])
        self.assertTrue(report["b"]["closed"])
        self.assertLessEqual(report["hausdorff"][0], record["positions"]["measured"]["distance"]["world"] +
                             report["resolution"])
        data = self.convert(SPHERE, "--iso", "0", "--format", "drc", "-o", "-").out
        self.assertEqual(data, (self.folder / "a.drc").read_bytes())
        self.assertTrue(data.startswith(b"DRACO\2\2"))
        for damage in (data[:40], data[:-9], b"DRACO" + b"\xff" * 60, b"DRACO"):
            (self.folder / "bad.drc").write_bytes(damage)
            self.assert_fails(2, self.run_program("compare", "plain.ply", "bad.drc"), "bad.drc")

    def test_files_of_other_programs(self):
        """Semantics that share one packed attribute, primitives that share one packed mesh, indices that are none."""
        self.convert("demo:sphere?size=12", "--iso", "0", "--draco", "-o", "h.gltf")
        whole = json.loads((self.folder / "h.gltf").read_text())
        (primitive,) = whole["meshes"][0]["primitives"]
        ids = primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"]

        def changed(change):
            model = json.loads(json.dumps(whole))
            change(model, model["meshes"][0]["primitives"])
            (self.folder / "c.gltf").write_text(json.dumps(model))
            return "c.gltf"

        def share_normals(_, primitives):
            primitives[0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = ids["POSITION"]

        def share_custom(model, primitives):
            model["accessors"].append(dict(model["accessors"][primitive["attributes"]["POSITION"]]))
            primitives[0]["attributes"]["_ZZ"] = len(model["accessors"]) - 1
            primitives[0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["_ZZ"] = ids["POSITION"]

        def twice(model, primitives):
            second = json.loads(json.dumps(primitive))
            for name, accessor in second["attributes"].items():
                model["accessors"].append(dict(model["accessors"][accessor]))
                second["attributes"][name] = len(model["accessors"]) - 1
            model["accessors"].append(dict(model["accessors"][second["indices"]]))
            second["indices"] = len(model["accessors"]) - 1
            primitives.append(second)

        def positions_as_indices(model, primitives):
            primitives[0]["indices"] = primitive["attributes"]["POSITION"]
            model["accessors"][primitives[0]["indices"]]["count"] = model["accessors"][primitive["indices"]]["count"]

        triangles = self.compare("h.gltf", "h.gltf")["a"]["triangles"]
        for change, factor in ((share_normals, 1), (share_custom, 1), (twice, 2)):
            with self.subTest(change=change.__name__):
                self.assertEqual(self.compare("h.gltf", changed(change))["b"]["triangles"], factor * triangles)
        self.assert_fails(2, self.run_program("compare", "h.gltf", changed(positions_as_indices)), "c.gltf")

    def test_regions_share_their_boundary(self):
        """Two halves of one volume, each in its own file with its own number of bits to reach: no cracks between."""
        full = json.loads(self.convert("info", "--json", GYROID).text)[0]
        self.assertTrue(full)
        for options in (["--draco"], ["--draco=14"], ["--quantize"]):
            with self.subTest(options=options):
                corner = {}
                for half, box in {"low": "0,0,0,15,31,31", "high": "15,0,0,31,31,31"}.items():
                    self.convert(GYROID, "--iso", "0", "--space", "index", "--roi", box, *options, "-o", f"{half}.glb")
                    _, record = self.packed(f"{half}.glb", GYROID, "--iso", "0", "--space", "index", "--roi", box,
                                            *options)
                    corner[half] = record["positions"]["step"]
                self.assertEqual(corner["low"], corner["high"])

    def test_regions_of_a_long_volume_have_no_cracks_between(self):
        """Where regions have origins of their own, what they share could be rounded apart."""
        noise = random.Random(7)
        rows = (bytes(1000) + noise.randbytes(500) + bytes(2500) for _ in range(24 * 24))
        (self.folder / "long.raw").write_bytes(b"".join(rows))
        shared = {}
        for half, box in {"low": "0,0,0,3999,12,23", "high": "900,12,0,1600,23,23"}.items():
            self.convert("long.raw", "--dims", "4000,24,24", "--dtype", "u8", "--iso", "127.3123", "--space", "index",
                         "--roi", box, "--quantize", "--normals", "none", "-o", f"{half}.glb")
            # Those of edges that both have; others may be rounded onto the shared edge.
            shared[half] = {(x, y, z) for x, y, z in quantized_places(self.folder / f"{half}.glb")
                            if y == 12 and (x % 1 or z % 1)}
        self.assertGreater(len(shared["low"]), 2000)
        self.assertEqual(shared["low"], shared["high"])

    def test_the_same_bytes_for_any_number_of_threads(self):
        for name, options in WAYS.items():
            for threads in (1, 3):
                self.convert(GYROID, "--iso", "0", *options, "--threads", threads, "-o", f"{name}{threads}.glb")
            self.assertEqual((self.folder / f"{name}1.glb").read_bytes(), (self.folder / f"{name}3.glb").read_bytes())

    def test_several_isos_flat_normals_and_simplified(self):
        run = self.convert(GYROID, "--iso", "0", "--iso", "0.5", "--normals", "flat", "--simplify", "0.05", "--draco",
                           "--explain", "-o", "a.glb")
        self.assertEqual(len(re.findall("packed by Draco at iso", run.err)), 2)
        self.assertEqual(len(re.findall(r"packed in .* positions of \d+ bits in steps of .* normals turned", run.err)), 2)

    def test_an_empty_surface(self):
        self.convert(SPHERE, "--iso", "9", "--empty", "write", "--draco", "-o", "a.glb", "--report", "r.json")
        self.assertEqual(json.loads((self.folder / "r.json").read_text())["packings"], [])
        self.assert_fails(4, self.run_program(SPHERE, "--iso", "9", "--empty", "write", "-o", "a.drc"),
                          "Draco cannot store a mesh without triangles")

    def test_without_packing_the_report_has_none(self):
        self.convert(SPHERE, "--iso", "0", "-o", "a.glb", "--report", "r.json")
        self.assertNotIn("packings", json.loads((self.folder / "r.json").read_text()))

    def test_usage(self):
        for options, part in (
            (["--draco", "-o", "a.ply"], "--draco does not work with ply"),
            (["--draco", "-o", "a.stl"], "--draco does not work with stl"),
            (["--quantize", "-o", "a.obj"], "--quantize does not work with obj"),
            (["--meshopt", "-o", "a.ply"], "--meshopt does not work with ply"),
            (["--quantize", "-o", "a.drc"], "--quantize does not work with drc"),
            (["--draco", "--meshopt", "-o", "a.glb"], "--draco and --meshopt exclude each other"),
            (["--draco", "--quantize", "-o", "a.glb"], "--draco and --quantize exclude each other"),
            (["--draco", "--optimize-order", "-o", "a.glb"], "--optimize-order does not work with --draco"),
            (["--optimize-order", "-o", "a.drc"], "--optimize-order does not work with drc"),
            (["--draco=7", "-o", "a.glb"], "--draco"),
            (["--draco=23", "-o", "a.glb"], "--draco"),
            (["--draco=many", "-o", "a.glb"], "--draco"),
        ):
            with self.subTest(options=options):
                self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", *options), part)
        self.assertEqual(self.files(), [])

    @needs_data("vdb/smoke.vdb")
    def test_smoke(self):
        self.convert(DATA / "vdb/smoke.vdb", "--iso", "0.5", "-o", "plain.glb")
        _, record = self.packed("a.glb", DATA / "vdb/smoke.vdb", "--iso", "0.5", "--draco")
        self.assertLess(record["bytes_after"], 0.3 * record["bytes_before"])
        self.assertLessEqual(record["positions"]["measured"]["axis"]["voxels"], 1 / 64)
        report = self.compare("plain.glb", "a.glb")
        self.assertEqual(report["a"]["components"], report["b"]["components"])


if __name__ == "__main__":
    main()
