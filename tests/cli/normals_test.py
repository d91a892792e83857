"""Normals that agree with the triangles, where there are caps and where triangles were left out; what is closed stays
closed for every viewer; the side that is inside, and how materials show it."""

import json
import math
import random
import struct

from support import DATA, SPHERE, ProgramTest, main, needs_data, read_glb, read_obj, read_ply

HALF = ("demo:sphere?size=24", "--iso", "0", "--roi", "-2,-2,-2,2,2,0.2")


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def against(mesh):
    """The fraction of corners whose normal points to the other side of the triangle than its winding does."""
    count = wrong = 0
    for triangle in mesh.triangles:
        a, b, c = (mesh.vertices[v] for v in triangle)
        normal = cross(minus(b, a), minus(c, a))
        if not any(normal):
            continue
        count += 3
        wrong += sum(dot(normal, mesh.normals[v]) < 0 for v in triangle)
    return wrong / count


def degrees_off(mesh, center):
    """The angles between the normals and those of a ball around `center`."""
    return [math.degrees(math.acos(max(-1, min(1, dot(normal, minus(place, center)) / math.dist(place, center)))))
            for place, normal in zip(mesh.vertices, mesh.normals)]


def places(mesh):
    return len(set(mesh.vertices))


class NormalsTest(ProgramTest):
    def read(self, name):
        data = (self.folder / name).read_bytes()
        return read_ply(data) if name.endswith(".ply") else next(iter(read_glb(data).values()))

    def gltf(self, name):
        data = (self.folder / name).read_bytes()
        return json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])

    def rough(self):
        numbers = random.Random(5)
        return self.write_raw("rough.raw", (24, 24, 24), lambda x, y, z: numbers.random() + 0.3 * math.sin(x / 3)), \
            ("--dims", "24,24,24", "--dtype", "f32", "--iso", "0.6")

    def check_fractions(self, *arguments):
        self.convert(*arguments, "-o", "plain.glb")
        plain = self.read("plain.glb")
        most = against(plain)
        self.assertGreater(most, 0.001)
        self.assertEqual(places(plain), len(plain.vertices))
        for options in (("--simplify", "0.5"), ("--simplify", "2"), ("--cap",), ("--cap", "--simplify", "0.5")):
            self.convert(*arguments, *options, "-o", "a.glb")
            mesh = self.read("a.glb")
            self.assertLessEqual(against(mesh), most, options)
            if "--simplify" in options:
                self.assertLess(against(mesh), 0.001, options)
                # Parted where it has to be, not everywhere.
                self.assertLess(len(mesh.vertices), 2 * places(mesh), options)

    def test_rough_data(self):
        path, options = self.rough()
        self.check_fractions(path, *options)

    @needs_data("vdb/smoke.vdb")
    def test_smoke(self):
        self.check_fractions(DATA / "vdb/smoke.vdb", "--iso", "0.5")

    def test_a_cap_is_flat_and_the_surface_keeps_its_normals(self):
        for name in ("a.ply", "a.glb"):
            open_name = f"open_{name}"
            self.convert(*HALF, "--normals", "smooth", "-o", open_name)
            self.convert(*HALF, "--normals", "smooth", "--cap", "-o", name)
            mesh, surface = self.read(name), self.read(open_name)
            known = dict(zip(surface.vertices, surface.normals))
            flat = (0, 0, 1) if name.endswith(".ply") else (0, 1, 0)
            axis = flat.index(1)
            top = max(v[axis] for v in mesh.vertices)
            caps = 0
            for triangle in mesh.triangles:
                is_cap = all(mesh.vertices[v][axis] == top for v in triangle)
                caps += is_cap
                for v in triangle:
                    if is_cap:
                        self.assertGreater(dot(mesh.normals[v], flat), 0.999999)
                    else:
                        self.assertEqual(mesh.normals[v], known[mesh.vertices[v]])
            self.assertGreater(caps, 50)
            self.assertGreater(len(mesh.vertices), places(mesh))
        # Without normals there is nothing to copy a vertex for.
        self.convert(*HALF, "--cap", "-o", "none.ply")
        self.assertEqual(self.read("none.ply").open_edges(), 0)

    def test_a_tilted_frame_is_no_other(self):
        path = self.write_raw("ball.raw", (24, 24, 24), lambda x, y, z: 9 - math.dist((x, y, z), (11.3, 12.1, 20.2)))
        data = path.read_bytes()
        directions = "(0.6,0.64,-0.48) (-0.8,0.48,-0.36) (0,0.6,0.8)"
        for origin in ("(0,0,0)", "(4000,-3000,100)"):
            header = ("NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 24\n"
                      f"space directions: {directions}\nspace origin: {origin}\nendian: little\nencoding: raw\n\n")
            (self.folder / "ball.nrrd").write_bytes(header.encode() + data)
            self.convert("ball.nrrd", "--iso", "0", "--cap", "--normals", "smooth", "-o", "a.ply")
            mesh = self.read("a.ply")
            up = (0, 0.6, 0.8)
            top = max(dot(v, up) for v in mesh.vertices)
            seen = 0
            for triangle in mesh.triangles:
                if all(abs(dot(mesh.vertices[v], up) - top) < 1e-3 for v in triangle):
                    seen += 1
                    for v in triangle:
                        self.assertGreater(dot(mesh.normals[v], up), 0.9999)
            self.assertGreater(seen, 50)

    def test_obj_has_each_place_once(self):
        self.convert(*HALF, "--cap", "--normals", "smooth", "-o", "a.obj")
        self.convert(*HALF, "--cap", "--normals", "smooth", "-o", "a.ply")
        mesh, copies = read_obj((self.folder / "a.obj").read_bytes()), self.read("a.ply")
        self.assertEqual(mesh.open_edges(), 0)
        self.assertEqual(len(mesh.vertices), places(copies))
        self.assertEqual(len(mesh.normals), len(copies.vertices))
        corners = [word.split("//") for line in (self.folder / "a.obj").read_text().splitlines()
                   if line.startswith("f ") for word in line.split()[1:]]
        for (vertex, normal), corner in zip(corners, (v for t in copies.triangles for v in t)):
            for a, b in zip(mesh.vertices[int(vertex) - 1], copies.vertices[corner]):
                self.assertAlmostEqual(a, b, 6)
            for a, b in zip(mesh.normals[int(normal) - 1], copies.normals[corner]):
                self.assertAlmostEqual(a, b, 5)

    def test_reports_and_compare_see_through_copies(self):
        arguments = (*HALF, "--cap", "--normals", "smooth")
        self.convert(*HALF, "--cap", "-o", "plain.ply")
        for name in ("a.glb", "a.gltf", "a.ply", "a.obj", "m.glb"):
            more = ("--meshopt",) if name == "m.glb" else ()
            self.convert(*arguments, *more, "-o", name, "--report", "report.json")
            (record,) = json.loads((self.folder / "report.json").read_text())["meshes"]
            self.assertTrue(record["closed"], name)
            if name in ("a.glb", "a.ply"):
                self.assertEqual(record["vertices"], len(self.read(name).vertices))
            told = json.loads(self.convert("compare", "--json", name, "plain.ply").text)
            self.assertTrue(told["a"]["closed"], name)
            self.assertEqual(told["a"]["open_edges"], 0, name)
            self.assertEqual(told["a"]["vertices"], told["b"]["vertices"], name)
        self.convert("verify", *HALF, "--cap", "a.glb")
        # What is open stays open.
        self.convert(*HALF, "-o", "open.glb")
        told = json.loads(self.convert("compare", "--json", "open.glb", "plain.ply").text)
        self.assertGreater(told["a"]["open_edges"], 0)

    def test_normals_of_the_triangles(self):
        self.convert(SPHERE, "--iso", "0", "--normals", "area", "-o", "a.ply")
        self.convert(SPHERE, "--iso", "0", "--normals", "smooth", "-o", "b.ply")
        mesh, smooth = self.read("a.ply"), self.read("b.ply")
        self.assertEqual(mesh.vertices, smooth.vertices)
        self.assertEqual(mesh.triangles, smooth.triangles)
        self.assertNotEqual(mesh.normals, smooth.normals)
        sums = [(0.0, 0.0, 0.0)] * len(mesh.vertices)
        for triangle in mesh.triangles:
            a, b, c = (mesh.vertices[v] for v in triangle)
            area = cross(minus(b, a), minus(c, a))
            for v in triangle:
                sums[v] = tuple(x + y for x, y in zip(sums[v], area))
        for total, normal in zip(sums, mesh.normals):
            self.assertGreater(dot(total, normal), 0.99999 * math.hypot(*total))
        # A method without gradients has these.
        self.convert(SPHERE, "--iso", "0", "--method", "voxels", "--normals", "area", "-o", "v.ply")
        self.assertEqual(self.read("v.ply").open_edges(), 0)
        self.convert(*HALF, "--cap", "--normals", "area", "-o", "cap.ply")
        self.assertEqual(against(self.read("cap.ply")), 0)
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--normals", "area", "-o", "a.stl"), "--normals area")

    def test_same_bytes_for_any_number_of_threads(self):
        path, options = self.rough()
        for threads in (1, 3):
            self.convert(path, *options, "--cap", "--simplify", "0.3", "--threads", threads, "-o", f"a{threads}.glb")
        self.assertEqual((self.folder / "a1.glb").read_bytes(), (self.folder / "a3.glb").read_bytes())

    def test_materials(self):
        for options, double_sided in (((), True), (("--cap",), False)):
            self.convert(*HALF, *options, "-o", "a.glb")
            (material,) = self.gltf("a.glb")["materials"]
            self.assertEqual(material.get("doubleSided", False), double_sided)
            self.assertEqual(material["name"], "sphere")
        self.convert(SPHERE, "--iso", "0", "--iso", "0.2", "-o", "a.glb")
        model = self.gltf("a.glb")
        self.assertEqual([m["name"] for m in model["materials"]], [n["name"] for n in model["nodes"]])
        self.assertEqual(len(model["materials"]), 2)
        self.assertFalse(any(m.get("doubleSided", False) for m in model["materials"]))
        # A hole opens the surface as well.
        numbers = self.write_raw("hole.raw", (12, 12, 12), lambda x, y, z: math.nan if (x, y, z) == (9, 6, 6)
                                 else 4 - math.dist((x, y, z), (5.5, 5.5, 5.5)))
        self.convert(numbers, "--dims", "12,12,12", "--dtype", "f32", "--iso", "0", "--nan", "hole", "-o", "a.glb")
        self.assertTrue(self.gltf("a.glb")["materials"][0]["doubleSided"])

    def test_smooth_normals_beside_samples_that_are_no_numbers(self):
        """They are the field's where it has a gradient, else those of the triangles; never a direction of the grid."""
        center = (23.5, 23.5, 23.5)
        raw = ("--dims", "48,48,48", "--dtype", "f32", "--normals", "smooth")

        def angles(iso, *options):
            self.convert("a.raw", *raw, "--iso", iso, *options, "-o", "a.ply")
            mesh = self.read("a.ply")
            self.assertTrue(all(abs(math.hypot(*normal) - 1) < 1e-5 for normal in mesh.normals))
            self.assertEqual(against(mesh), 0)
            found = degrees_off(mesh, center)
            return sum(found) / len(found), max(found)

        # A scan whose background is masked: the surface is that of the mask, whatever the values in it.
        for value in (lambda *p: 100, lambda x, y, z: 100 + x + 2 * y):
            inside = lambda *p: math.dist(p, center) < 16  # noqa: E731
            self.write_raw("a.raw", (48, 48, 48), lambda *p: value(*p) if inside(*p) else math.nan)
            mean, most = angles("50", "--nan", "outside")
            self.assertLess(mean, 15)
            self.assertLess(most, 45)
            self.assertLess(angles("50", "--nan", "outside", "--method", "mt")[0], 30)  # its triangles are rougher
        self.write_raw("a.raw", (48, 48, 48), lambda *p: 100 if inside(*p) else 0)
        self.assertLess(angles("50", "--nodata", "0")[0], 15)
        # The field's own surface, with NaN from its far side on, and with NaN here and there.
        self.write_raw("a.raw", (48, 48, 48), lambda *p: 16 - math.dist(p, center) if math.dist(p, center) < 17.8 else math.nan)
        for policy in ("outside", "hole"):
            mean, most = angles("0", "--nan", policy)
            self.assertLess(mean, 0.1)
            self.assertLess(most, 1)
        numbers = random.Random(3)
        self.write_raw("a.raw", (48, 48, 48), lambda *p: math.nan if numbers.random() < 0.001 else 16 - math.dist(p, center))
        mean, _ = angles("0", "--nan", "hole")
        self.assertLess(mean, 1)
        # A lone one in a ramp: the normals of its walls lead into it, not along the ramp.
        self.write_raw("a.raw", (48, 48, 48), lambda *p: math.nan if p == (24, 24, 24) else 100 + p[0])
        self.convert("a.raw", *raw, "--iso", "50", "--nan", "outside", "-o", "a.ply")
        walls = self.read("a.ply")
        self.assertEqual(len(walls.vertices), 6)
        for place, normal in zip(walls.vertices, walls.normals):
            self.assertGreater(sum(n * (24 - p) for n, p in zip(normal, place)), 0)


class SidesTest(ProgramTest):
    RAW = ("--dims", "30,16,16", "--dtype", "f32")

    def both_signs(self):
        """A positive blob, and a negative one."""
        return self.write_raw("signs.raw", (30, 16, 16), lambda x, y, z: math.exp(-math.dist((x, y, z), (8, 7, 7))**2 / 12)
                              - math.exp(-math.dist((x, y, z), (21, 8, 8))**2 / 12))

    def volumes(self, name="a.glb"):
        return {key: mesh.volume() for key, mesh in read_glb((self.folder / name).read_bytes()).items()}

    def test_each_surface_faces_away_from_zero(self):
        path = self.both_signs()
        isos = ("--iso", "0.3", "--iso", "-0.3")
        self.convert(path, *self.RAW, *isos, "-o", "a.glb")
        positive, negative = self.volumes().values()
        self.assertGreater(positive, 100)
        self.assertLess(negative, -100)
        self.convert(path, *self.RAW, *isos, "--inside", "away-from-zero", "-o", "a.glb", "--report", "report.json",
                     "--color-by", "iso")
        positive, negative = self.volumes().values()
        self.assertGreater(positive, 100)
        self.assertGreater(negative, 100)
        for mesh in read_glb((self.folder / "a.glb").read_bytes()).values():
            self.assertEqual(against(mesh), 0)
            self.assertEqual(mesh.open_edges(), 0)
        data = (self.folder / "a.glb").read_bytes()
        model = json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])
        colors = [m["pbrMetallicRoughness"]["baseColorFactor"] for m in model["materials"]]
        self.assertNotEqual(colors[0][:3], colors[1][:3])
        # Neither is around the other.
        self.assertEqual([color[3] for color in colors], [1, 1])
        options = json.loads((self.folder / "report.json").read_text())["options"]
        self.assertTrue(options["away_from_zero"])
        # The same as each by itself.
        for iso, side in (("0.3", "above"), ("-0.3", "below")):
            self.convert(path, *self.RAW, "--iso", iso, "--inside", side, "--normals", "smooth", "-o", "one.ply")
            self.convert(path, *self.RAW, "--iso", iso, "--inside", "away-from-zero", "--normals", "smooth", "-o",
                         "other.ply")
            self.assertEqual((self.folder / "one.ply").read_bytes(), (self.folder / "other.ply").read_bytes())

    def test_errors_and_backends_know_the_side(self):
        path = self.both_signs()
        arguments = (path, *self.RAW, "--iso", "0.3", "--iso", "-0.3", "--inside", "away-from-zero")
        self.convert(*arguments, "--verify", "--error", "trilinear", "-o", "a.glb")
        self.convert("verify", *arguments)
        self.convert("verify", *arguments, "a.glb")
        wrong = self.run_program("verify", *arguments[:-2], "a.glb")
        self.assertEqual(wrong.code, 6, wrong.err)
        self.convert(*arguments, "--backend", "gpu", "-o", "gpu.glb")
        self.assertEqual([round(v) for v in self.volumes("gpu.glb").values()],
                         [round(v) for v in self.volumes().values()])

    def test_a_value_equal_to_iso_is_outside_of_either_side(self):
        path = self.write_raw("point.raw", (30, 16, 16), lambda x, y, z: {(8, 7, 7): 0.5, (20, 7, 7): -0.5}.get((x, y, z), 0))
        for iso in ("0.5", "-0.5"):
            run = self.run_program(path, *self.RAW, "--iso", iso, "--inside", "away-from-zero", "-o", "a.glb")
            self.assert_fails(2, run, "no surface at iso")
        for iso in ("0.49", "-0.49"):
            self.convert(path, *self.RAW, "--iso", iso, "--inside", "away-from-zero", "-o", "a.glb")
            self.assertGreater(next(iter(self.volumes().values())), 0)

    def test_at_zero_the_field_decides(self):
        path = self.both_signs()
        self.convert(path, *self.RAW, "--iso", "0", "-o", "a.ply")
        self.convert(path, *self.RAW, "--iso", "0", "--inside", "away-from-zero", "-o", "b.ply")
        self.assertEqual((self.folder / "a.ply").read_bytes(), (self.folder / "b.ply").read_bytes())

    def test_a_cap_closes_the_inside(self):
        path = self.write_raw("ramp.raw", (30, 16, 16), lambda x, y, z: x - 14.5)
        for iso, side, samples in (("4", "away-from-zero", 10), ("-4", "away-from-zero", 10), ("4", "below", 18)):
            self.convert(path, *self.RAW, "--iso", iso, "--inside", side, "--cap", "-o", "a.ply")
            mesh = read_ply((self.folder / "a.ply").read_bytes())
            self.assertEqual(mesh.open_edges(), 0)
            self.assertAlmostEqual(mesh.volume(), (samples + 0.5) * 15 * 15, delta=1)

    def test_usage(self):
        (self.folder / "p.xyz").write_text("2\n\nA 0 0 0\nA 1 0 0\n")
        self.assert_fails(1, self.run_program("p.xyz", "--inside", "away-from-zero", "-o", "a.glb"), "inside")
        self.assert_fails(1, self.run_program("info", SPHERE, "--inside", "away-from-zero"), "--inside away-from-zero")
        self.assert_fails(1, self.run_program("bench", SPHERE, "--inside", "away-from-zero"), "--inside away-from-zero")
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--inside", "away", "-o", "a.glb"), "away-from-zero")


if __name__ == "__main__":
    main()
