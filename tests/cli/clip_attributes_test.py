"""Colors and attributes of mesh files: edits keep them, and cuts interpolate them."""

import math
import struct
import zipfile

from attribute_files_test import ball, npy
from attributes_test import Glb, columns
from support import ProgramTest, main, read_ply

PLANE = 0.3
CAPS = ((), ("--cap",))


def wave(x, y, z):
    return 0.5 + x + 2 * y - 3 * z


def color(x, y, z):
    return 10 + 200 * x, 240 - 100 * y, 7 + 50 * z


def box():
    """Vertices of a unit cube, and its outward triangles."""
    vertices = [tuple(i >> axis & 1 for axis in range(3)) for i in range(8)]
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def ply_bytes(vertices, triangles, waves):
    names = [f"float {axis}" for axis in "xyz"] + [f"uchar {c}" for c in ("red", "green", "blue")]
    names += ["float wave", "double depth", "int label"]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *(f"property {name}" for name in names),
             f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = [struct.pack("<3f3Bfdi", *v, *color(*v), waves[i], v[0] / 7, 100 if v[0] < 0.5 else 300) for i, v in enumerate(vertices)]
    return "\n".join(lines).encode() + b"".join(rows) + b"".join(struct.pack("<B3i", 3, *t) for t in triangles)


class ClipAttributesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        vertices, triangles = box()
        (self.folder / "a.ply").write_bytes(ply_bytes(vertices, triangles, [wave(*v) for v in vertices]))

    def clip(self, source, output, *more):
        return self.convert(source, "--clip", f"1,0,0,{PLANE}", *more, "-o", output)

    def test_ply(self):
        for cap in CAPS:
            for more in ((), ("--clip", "0,-1,0,-0.6"), ("--repair",)):
                with self.subTest(cap=cap, more=more):
                    self.clip("a.ply", "b.ply", "--ascii", *cap, *more)
                    self.assertEqual(read_ply((self.folder / "b.ply").read_bytes()).open_edges() == 0, bool(cap))
                    found = columns(self.folder / "b.ply")
                    self.assertEqual(list(found)[-6:], ["red", "green", "blue", "wave", "depth", "label"])
                    self.assertGreater(len(found["x"]), 8)
                    for i, place in enumerate(zip(found["x"], found["y"], found["z"])):
                        self.assertAlmostEqual(found["wave"][i], wave(*place), delta=1e-6)
                        self.assertAlmostEqual(found["depth"][i], place[0] / 7, delta=1e-7)
                        if "--clip" not in more:  # which cuts edges that the first cut has made
                            self.assertEqual(found["label"][i], 100 if place[0] < 0.5 else 300)
                        for name, value in zip(("red", "green", "blue"), color(*place)):
                            self.assertAlmostEqual(found[name][i], value, delta=1.01)

    def test_glb(self):
        """From PLY to glTF, which turns the mesh, and from glTF to glTF."""
        self.convert("a.ply", "-o", "a.glb")
        for source in ("a.ply", "a.glb"):
            for cap in CAPS:
                with self.subTest(source=source, cap=cap):
                    self.clip(source, "b.glb", *cap)
                    glb = Glb((self.folder / "b.glb").read_bytes())
                    places, waves, colors = (glb.values(name) for name in ("POSITION", "_wave", "COLOR_0"))
                    self.assertEqual((len(waves), len(colors)), (len(places), len(places)))
                    # The reds at x = 0 and x = 1, in linear light, which glTF stores.
                    low, high = 65535 * 10 / 255 / 12.92, 65535 * ((210 / 255 + 0.055) / 1.055) ** 2.4
                    for (x, y, z), (value,), (red, *_) in zip(places, waves, colors):
                        self.assertAlmostEqual(value, wave(x, -z, y), delta=1e-6)
                        self.assertAlmostEqual(red, low + x * (high - low), delta=3)

    def test_a_cut_of_a_cut(self):
        self.convert("a.ply", "-o", "a.glb")
        self.clip("a.glb", "b.glb", "--cap")
        self.convert("b.glb", "--clip", "0,1,0,0.25", "--cap", "--largest", "1", "-o", "c.ply", "--ascii")
        found = columns(self.folder / "c.ply")
        self.assertGreaterEqual(min(found["z"]), 0.25 - 1e-6)
        for *place, value in zip(found["x"], found["y"], found["z"], found["wave"]):
            self.assertAlmostEqual(value, wave(*place), delta=1e-6)

    def test_colors_by_an_attribute(self):
        for cap in CAPS:
            run = self.clip("a.ply", "b.ply", "--color-by", "wave:gray", "--ascii", *cap)
            found = columns(self.folder / "b.ply")
            low, high = min(found["wave"]), max(found["wave"])
            self.assertIn("colors of mesh: wave, gray from", run.err)
            for value, red in zip(found["wave"], found["red"]):
                self.assertAlmostEqual(red, 255 * (value - low) / (high - low), delta=1)

    def test_normals_keep_length_1(self):
        with zipfile.ZipFile(self.folder / "v.npz", "w") as archive:
            archive.writestr("d.npy", npy(ball))
            center = (4, 3.6, 3.1)
            for axis in range(3):
                archive.writestr(f"N.{'xyz'[axis]}.npy",
                                 npy(lambda *at, axis=axis: (at[axis] - center[axis]) / (math.dist(at, center) or 1)))
        self.convert("v.npz", "--grid", "d", "--iso", "0.5", "--attribute", "N", "-o", "a.glb")
        for cap in CAPS:
            self.convert("a.glb", "--clip", "1,0.3,0.1,4.2", *cap, "-o", "b.glb")
            normals = Glb((self.folder / "b.glb").read_bytes()).values("_N")
            self.assertGreater(len(normals), 50)
            for normal in normals:
                self.assertAlmostEqual(math.hypot(*normal), 1, delta=1e-6)

    def test_other_edits_keep_attributes(self):
        for edit in (("--repair",), ("--smooth", "2"), ("--triangles", "8"), ("--largest", "1"), ("--drop-components", "1"),
                     ("--fill-cavities",), ("--hollow", "0.1world"), ("--normals", "area"), ("--normals", "flat"),
                     ("--require", "closed")):
            with self.subTest(edit=edit):
                self.convert("a.ply", *edit, "--ascii", "-o", "b.ply")
                found = columns(self.folder / "b.ply")
                self.assertEqual(list(found)[-6:], ["red", "green", "blue", "wave", "depth", "label"])
                self.assertLessEqual(set(found["label"]), {100, 300})
                self.assertGreater(len(set(found["wave"])), 2)

    def test_repair_counts_the_attributes_it_drops(self):
        vertices, triangles = box()
        soup = [vertices[v] for t in triangles for v in t]
        each = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(12)]
        told = "note[corners-joined]: b.ply: the repair drops the attributes of 1 of 28 merged vertices"
        for last in (0, 9):
            waves = [wave(*v) for v in soup]
            waves[-1] += last
            (self.folder / "b.ply").write_bytes(ply_bytes(soup, each, waves))
            run = self.convert("b.ply", "--repair", "-o", "c.ply")
            self.assertEqual(told in run.err, last > 0, run.err)


if __name__ == "__main__":
    main()
