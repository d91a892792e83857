"""A conversion is a batch of one frame: both write the same bytes, and reports that differ in names and times alone."""

import json
import math
import pathlib
import struct
import unittest

from support import PROGRAM, ProgramTest, main

PLUGIN = pathlib.Path(PROGRAM).parent / "plugins" / "isoextract-grids-openvdb.so"
TIMES = ("wall_seconds", "cpu_seconds", "peak_memory_bytes", "arguments")


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(held) for key, held in value.items() if key not in TIMES}
    return [without_times(held) for held in value] if isinstance(value, list) else value


class OneFrame(ProgramTest):
    def setUp(self):
        super().setUp()
        n = range(16)
        values = [math.sin(x / 2) + math.cos(y / 2) + math.sin(z / 3) for z in n for y in n for x in n]
        head = "NRRD0005\ntype: float\ndimension: 3\nsizes: 16 16 16\nencoding: raw\nendian: little\nspacings: 1 1 1\n\n"
        (self.folder / "f_7.nrrd").write_bytes(head.encode() + struct.pack("<4096f", *values))
        labels = [(x // 5 + y // 7 + z // 6) % 3 for z in n for y in n for x in n]
        (self.folder / "l_7.nrrd").write_bytes(head.replace("float", "uint8").encode() + bytes(labels))
        rows = "".join(f"{math.cos(i)} {math.sin(i)} {i / 20} {i}\n" for i in range(60))
        (self.folder / "p_7.csv").write_text("x,y,z,id\n" + rows.replace(" ", ","))

    def check(self, stem, extension, *options):
        name = f"mesh.{extension}"
        self.convert(f"{stem}_7.{'csv' if stem == 'p' else 'nrrd'}", *options, "-o", name, "--report", "one.json")
        self.convert(f"{stem}_{{}}.{'csv' if stem == 'p' else 'nrrd'}", *options, "-o", f"mesh_{{}}.{extension}",
                     "--report", "batch_{}.json")
        one, batch = self.folder / name, self.folder / f"mesh_7.{extension}"
        self.assertEqual(one.read_bytes(), batch.read_bytes())
        told = [
            without_times(json.loads((self.folder / report).read_text().replace(f"mesh_7.{extension}", name)))
            for report in ("one.json", "batch_7.json")
        ]
        if "--labels" in options:  # how many labels are made at the same time differs from run to run
            for report in told:
                self.assertGreater(report.pop("reserved_memory_bytes"), 0)
        self.assertEqual(told[0], told[1])
        self.assertNotIn("mesh_7", str(told))
        self.assertIn("stages", told[0])

    def test_meshes_of_volumes(self):
        self.check("f", "ply", "--iso", "0")
        self.check("f", "glb", "--iso", "0", "--iso", "0.5", "--cap", "--draco")
        self.check("f", "obj", "--iso", "p60", "--method", "mt", "--normals", "area")
        self.check("f", "stl", "--iso", "0.2", "--smooth", "5", "--simplify", "0.1", "--largest", "--error")

    def test_pictures(self):
        self.check("f", "png", "--iso", "0.1")

    @unittest.skipUnless(PLUGIN.exists(), "the plug-ins around OpenVDB were not built")
    def test_fields(self):
        self.check("f", "vdb", "--blur", "1")

    def test_labels(self):
        self.check("l", "glb", "--labels", "all", "--method", "surface-nets")

    def test_particles(self):
        self.check("p", "ply", "--radius", "0.2", "--attribute", "id")

    def test_an_empty_frame(self):
        self.check("f", "ply", "--iso", "90", "--empty", "write")

    def test_failures_end_alike(self):
        one = self.run_program("f_7.nrrd", "--iso", "90", "-o", "mesh.ply", "--report", "one.json")
        batch = self.run_program("f_{}.nrrd", "--iso", "90", "-o", "mesh_{}.ply", "--report", "batch_{}.json")
        self.assertEqual((one.code, batch.code), (2, 5))
        errors = [json.loads((self.folder / name).read_text())["error"] for name in ("one.json", "batch_7.json")]
        self.assertEqual(errors[0], errors[1])
        self.assertEqual([path.name for path in self.folder.glob("mesh*")], [])


if __name__ == "__main__":
    main()
