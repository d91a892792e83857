"""Arrays as they come: .npz, several numbers a sample, orders of axes, values for no data; and surfaces that are cut."""

import json
import math
import re
import struct
import zipfile

from support import SPHERE, ProgramTest, main, read_ply

DIMS = (12, 11, 10)  # x, y, z
CENTER = (5.5, 5, 4.5)
RADIUS = 3.3


def npy(descr, shape, samples):
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}"
    text += " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text.encode() + samples


def vectors():
    """From the center, z slowest, the component fastest."""
    nx, ny, nz = DIMS
    return [c for k in range(nz) for j in range(ny) for i in range(nx)
            for c in (i - CENTER[0], j - CENTER[1], k - CENTER[2])]


def lengths():
    flat = vectors()
    return [math.dist(flat[at:at + 3], (0, 0, 0)) for at in range(0, len(flat), 3)]


class ArraysTest(ProgramTest):
    def setUp(self):
        super().setUp()
        shape = (DIMS[2], DIMS[1], DIMS[0])
        flat = vectors()
        self.vectors = npy("<f4", (*shape, 3), struct.pack(f"<{len(flat)}f", *flat))
        self.lengths = npy("<f4", shape, struct.pack(f"<{len(flat) // 3}f", *lengths()))
        (self.folder / "v.npy").write_bytes(self.vectors)
        (self.folder / "r.npy").write_bytes(self.lengths)
        for name, packing in (("stored.npz", zipfile.ZIP_STORED), ("packed.npz", zipfile.ZIP_DEFLATED)):
            with zipfile.ZipFile(self.folder / name, "w", packing) as archive:
                for member, data in (("v.npy", self.vectors), ("r.npy", self.lengths)):
                    with archive.open(member, "w", force_zip64=True) as out:  # as NumPy does
                        out.write(data)

    def mesh(self, *arguments, name="a.ply"):
        self.convert(*arguments, "-o", name)
        return read_ply((self.folder / name).read_bytes())

    def test_members_of_archives_are_the_arrays(self):
        alone = self.mesh("r.npy", "--iso", RADIUS, "--inside", "below")
        self.assertEqual(alone.open_edges(), 0)
        for archive in ("stored.npz", "packed.npz"):
            member = self.mesh(archive, "--grid", "r", "--iso", RADIUS, "--inside", "below")
            self.assertEqual((member.vertices, member.triangles), (alone.vertices, alone.triangles))
            run = self.run_program(archive, "--iso", RADIUS)
            self.assert_fails(2, run, "expected one scalar grid, found 2", "--grid NAME")
            run = self.run_program(archive, "--grid", "x", "--iso", RADIUS)
            self.assert_fails(2, run, "there is no grid 'x'\n")
            run = self.run_program(archive, "--grid", "rr", "--iso", RADIUS)
            self.assert_fails(2, run, "there is no grid 'rr' (did you mean 'r'?)", "--grid NAME")
        listed = json.loads(self.convert("info", "--json", "packed.npz").text)[0]
        self.assertEqual([(grid["name"], grid["volumes"]) for grid in listed["grids"]], [("v", 10), ("r", 1)])
        # info takes the first of 10 volumes, whether the grid is named as itself or as a path.
        for name in ("v", "/v"):
            self.assertIn(f"--grid {name} --volume 0", self.convert("info", "packed.npz", "--grid", name).text)

    def test_a_component_and_the_length_of_all(self):
        alone = self.mesh("r.npy", "--iso", RADIUS, "--inside", "below")
        for source in (("v.npy",), ("stored.npz", "--grid", "v"), ("packed.npz", "--grid", "v")):
            length = self.mesh(*source, "--component", "length", "--iso", RADIUS, "--inside", "below")
            self.assertEqual(length.triangles, alone.triangles)
            for a, b in zip(length.vertices, alone.vertices):
                self.assertLess(math.dist(a, b), 1e-5)
            plane = self.mesh(*source, "--component", "1", "--iso", "0.25")
            self.assertEqual({y for _, y, _ in plane.vertices}, {5.25})
        info = json.loads(self.convert("info", "--json", "v.npy", "--component", "2").text)[0]
        self.assertEqual((info["component"], info["grids"][0]["components"]), (2, 3))
        self.assertAlmostEqual(info["field"]["values"]["max"], 4.5)
        self.assertIn("3, counted from 0; this report describes the length of the vector",
                      self.convert("info", "v.npy", "--component", "length").text)
        self.assert_fails(2, self.run_program("v.npy", "--component", "3", "--iso", "1"), "there is no component 3")
        self.assert_fails(1, self.run_program("v.npy", "--component", "y", "--iso", "1"),
                          "--component: expected the number of a component, counted from 0, or the word 'length'")
        self.assert_fails(1, self.run_program(SPHERE, "--component", "0", "--iso", "0"), "this is demo")

    def test_hints_name_their_options(self):
        """Complex arrays, and arrays whose axes are others than those of a volume."""
        (self.folder / "z.npy").write_bytes(npy("<c8", (2, 3, 4), bytes(192)))
        (self.folder / "five.npy").write_bytes(npy("|u1", (2, 3, 3, 3, 2), bytes(108)))
        (self.folder / "six.npy").write_bytes(npy("|u1", (2, 2, 3, 3, 3, 2), bytes(216)))
        for name, option in (("z.npy", "--component K, K from 0 to 1: the real and the imaginary part"),
                             ("z.npy", "--component length"),
                             ("v.npy", "--volume K, K from 0 to 9; use --component 0 to 2, or length, if the last axis (length 3) holds the components of a vector"),
                             ("v.npy", "choose one of them with --volume K"),
                             ("five.npy", "use --component 0 to 1, or length, if the last axis (length 2) holds the components"),
                             ("six.npy", "take a part with fewer axes in NumPy first, for example a[0]")):
            self.assert_fails(2, self.run_program(name, "--iso", "1", "-o", "a.ply"), "hint: ", option)
        self.assert_fails(2, self.run_program("r.npy", "--component", "1", "--iso", "1"), "leave --component out")
        self.assert_fails(1, self.run_program(SPHERE, "--component", "0", "--iso", "0"), "leave --component out")
        self.assert_fails(1, self.run_program(SPHERE, "--axis-order", "xyz", "--iso", "0"), "leave --axis-order out")

    def test_axes_in_the_other_order(self):
        nx, ny, nz = DIMS
        values = lengths()
        turned = [values[i + nx * (j + ny * k)] for i in range(nx) for j in range(ny) for k in range(nz)]
        samples = struct.pack(f"<{len(turned)}f", *turned)
        (self.folder / "t.npy").write_bytes(npy("<f4", DIMS, samples))
        (self.folder / "t.raw").write_bytes(samples)
        alone = self.mesh("r.npy", "--iso", RADIUS, "--inside", "below")
        for source in (("t.npy",), ("t.raw", "--dims", "12,11,10", "--dtype", "f32")):
            mesh = self.mesh(*source, "--axis-order", "xyz", "--iso", RADIUS, "--inside", "below")
            self.assertEqual((mesh.vertices, mesh.triangles), (alone.vertices, alone.triangles))
        self.assert_fails(1, self.run_program(SPHERE, "--axis-order", "xyz", "--iso", "0"), "this is demo")

    def test_samples_of_the_value_for_no_data_are_not_numbers(self):
        def value(x, y, z):
            return -9999 if (x, y, z) == (3, 3, 3) else x
        self.write_raw("a.raw", (7, 7, 7), value)
        raw = ("a.raw", "--dims", "7,7,7", "--dtype", "f32", "--iso", "2.5")
        with_it = self.mesh(*raw, "--nodata", "-9999")
        self.assertLess(max(x for x, _, _ in with_it.vertices), 4.1)
        hole = self.mesh(*raw, "--nodata", "-9999", "--nan", "hole")
        self.assertEqual({x for x, _, _ in hole.vertices}, {2.5})
        self.assertGreater(hole.open_edges(), with_it.open_edges())
        run = self.run_program(*raw, "--nodata", "-9999", "--nan", "error", "-o", "b.ply")
        self.assert_fails(2, run, "(3, 3, 3)", "--nan")
        info = json.loads(self.convert("info", "--json", *raw[:-2], "--nodata", "-9999").text)[0]["field"]
        self.assertEqual((info["values"]["nan"], info["values"]["min"]), (1, 0))
        self.assertIn("no sample has the no-data value 77", self.convert(*raw, "--nodata", "77", "-o", "b.ply").err)

    def test_what_was_asked_for_is_in_the_report(self):
        self.convert("v.npy", "--component", "length", "--axis-order", "zyx", "--nodata", "0", "--iso", RADIUS,
                     "--clip", "0,0,1,4", "--resolution", "20", "--kernel", "cubic", "-o", "a.ply", "--report", "r.json")
        options = json.loads((self.folder / "r.json").read_bytes())["options"]
        self.assertEqual([options[name] for name in ("component", "axis_order", "no_data", "kernel")],
                         ["length", "zyx", 0, "cubic"])
        self.assertEqual(options["clip"], [{"normal": [0, 0, 1], "offset": 4}])

    def test_planes_cut_triangles(self):
        whole = self.mesh(SPHERE, "--iso", "0")
        half = self.mesh(SPHERE, "--iso", "0", "--clip", "0,0,2,0.2")
        self.assertAlmostEqual(min(z for _, _, z in half.vertices), 0.1, delta=1e-6)
        self.assertAlmostEqual(max(z for _, _, z in half.vertices), max(z for _, _, z in whole.vertices))
        ring = [v for v in half.vertices if abs(v[2] - 0.1) < 1e-6]
        self.assertEqual(half.open_edges(), len(ring))
        slab = self.mesh(SPHERE, "--iso", "0", "--clip", "0,0,1,-0.1", "--clip", "0,0,-1,-0.1", "--scale", "10")
        self.assertAlmostEqual(slab.bounds()[0][2], -1, delta=1e-5)
        self.assertAlmostEqual(slab.bounds()[1][2], 1, delta=1e-5)
        # In the input's world, whatever the output's axes.
        self.convert(SPHERE, "--iso", "0", "--clip", "0,0,1,0.1", "-o", "a.glb")
        self.convert("verify", SPHERE, "a.glb", "--iso", "0", "--clip", "0,0,1,0.1")
        self.assertEqual(self.run_program("verify", SPHERE, "a.glb", "--iso", "0").code, 6)
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--clip", "0,0,0,1"), "--clip: expected a normal")
        run = self.run_program(SPHERE, "--iso", "0", "--clip", "0,0,1,9", "-o", "a.ply")
        self.assert_fails(2, run, "clipping removes the whole surface at iso 0; the surface lies in (-0.697284, -0.697284,")
        self.assertIn("hint: check --clip NX,NY,NZ,D: a plane keeps the points with", run.err)
        # Where a plane passes between components nothing is cut, and nothing is open.
        self.write_raw("two.raw", (24, 8, 8), lambda x, y, z: float(x in (4, 19) and (y, z) == (4, 4)))
        run = self.convert("two.raw", "--dims", "24,8,8", "--dtype", "f32", "--iso", "0.5", "--clip", "1,0,0,12", "-o",
                           "a.ply")
        self.assertIn("clipping kept 8 of 16 triangles and cut none\n", run.err)

    def test_the_result_line_does_not_call_what_was_cut_closed(self):
        for cap, text in (((), "; open where --clip cut it (--cap closes it); "), (("--cap",), "; closed; ")):
            run = self.convert("demo:sphere?size=20", "--iso", "0", "--clip", "1,0,0,0.1", *cap, "-o", "a.ply")
            self.assertIn(text, run.err)

    def test_a_cap_closes_what_planes_cut(self):
        def volume(mesh):
            def of(t):
                a, b, c = (mesh.vertices[i] for i in t)
                return sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3)) / 6
            return sum(of(t) for t in mesh.triangles)

        whole = volume(self.mesh(SPHERE, "--iso", "0", "--normals", "flat"))
        plane = ("--normals", "flat", "--cap", "--clip")
        parts = [self.mesh(SPHERE, "--iso", "0", *plane, "0.3,0.2,1,0.1"),
                 self.mesh(SPHERE, "--iso", "0", *plane, "-0.3,-0.2,-1,-0.1")]
        for part in parts:
            self.assertEqual(part.open_edges(), 0)
        self.assertAlmostEqual(sum(map(volume, parts)), whole, delta=1e-6)
        eighth = self.mesh(SPHERE, "--iso", "0", *plane, "1,0,0,0", "--clip", "0,1,0,0", "--clip", "0,0,1,0")
        self.assertEqual(eighth.open_edges(), 0)
        self.assertAlmostEqual(volume(eighth), whole / 8, delta=1e-3 * whole)

        run = self.convert(SPHERE, "--iso", "0", "--cap", "--clip", "0,0,1,0.1", "-o", "a.ply", "--report", "r.json")
        self.assertIn("triangles close the surface at the cuts", run.err)
        self.convert("check", "a.ply", "--require", "printable")
        self.convert(SPHERE, "--iso", "0", "--cap", "--clip", "0,0,1,0.1", "--normals", "smooth", "-o", "n.ply")
        mesh = read_ply((self.folder / "n.ply").read_bytes())
        # Each vertex of the rim twice, with the normal of each side.
        flat = [n for v, n in zip(mesh.vertices, mesh.normals) if abs(v[2] - 0.1) < 1e-6]
        self.assertGreater(len(flat), 20)
        self.assertEqual(sum(abs(n[2] + 1) < 1e-6 for n in flat) * 2, len(flat))
        self.convert("verify", SPHERE, "a.ply", "--iso", "0", "--clip", "0,0,1,0.1", "--cap")
        self.assertEqual(self.run_program("verify", SPHERE, "a.ply", "--iso", "0", "--clip", "0,0,1,0.1").code, 6)
        # Nothing of the cap is measured, as nothing of it is on the isosurface.
        self.convert(SPHERE, "--iso", "0", "--cap", "--clip", "0,0,1,0.1", "--error", "-o", "e.ply", "--report", "r.json")
        error = json.loads((self.folder / "r.json").read_bytes())["meshes"][0]["error"]
        self.assertGreater(error["cap_triangles"], 20)
        self.assertLess(error["interior"]["max"]["voxels"], 0.2)
        smooth = self.mesh(SPHERE, "--iso", "0", "--cap", "--clip", "0,0,1,0.1", "--smooth", "10")
        self.assertAlmostEqual(min(z for _, _, z in smooth.vertices), 0.1, delta=1e-6)
        threads = [self.convert(SPHERE, "--iso", "0", "--cap", "--clip", "1,2,3,0.1", "--threads", n, "-o", f"{n}.ply")
                   and (self.folder / f"{n}.ply").read_bytes() for n in ("1", "4")]
        self.assertEqual(*threads)

    def test_a_cut_that_ends_at_a_hole_is_not_closed(self):
        size = 9
        samples = [math.dist((x, y, z), (4, 4, 4)) if (x, y, z) != (7, 4, 4) else math.nan
                   for z in range(size) for y in range(size) for x in range(size)]
        (self.folder / "h.npy").write_bytes(npy("<f4", (size,) * 3, struct.pack(f"<{size ** 3}f", *samples)))
        raw = ("h.npy", "--axis-order", "zyx", "--iso", "3.2", "--nan", "hole", "--cap", "-o", "a.ply")
        self.assert_fails(2, self.run_program(*raw, "--clip", "0,0,1,4.1"), "h.npy", "cannot cap the cut")
        self.assertFalse((self.folder / "a.ply").exists())
        self.convert(*raw, "--clip", "-1,0,0,-4")

    def test_a_region_on_oblique_axes_is_cut_at_its_faces(self):
        c, s = math.cos(0.5), math.sin(0.5)
        header = ("NRRD0004\ntype: float\ndimension: 3\nsizes: 12 11 10\nencoding: raw\nendian: little\nspace: LPS\n"
                  f"space directions: ({c},{s},0) ({-s},{c},0) (0,0,1)\nspace origin: (0,0,0)\n\n")
        (self.folder / "t.nrrd").write_bytes(header.encode() + self.lengths[128:])
        cx, cy = c * CENTER[0] - s * CENTER[1], s * CENTER[0] + c * CENTER[1]
        box = (cx - 1.3, cy - 9, 3, cx + 2.1, cy + 0.7, 30)
        roi = ",".join(str(number) for number in box)
        arguments = ("t.nrrd", "--iso", RADIUS, "--inside", "below", "--roi", roi)
        run = self.convert(*arguments, "-o", "a.ply")
        self.assertRegex(run.err, r"oblique to the region, so the conversion extracts the \d+ x \d+ x \d+ samples that cover the region, and clips")
        low, high = read_ply((self.folder / "a.ply").read_bytes()).bounds()
        for found, wanted in ((low[0], box[0]), (high[0], box[3]), (high[1], box[4]), (low[2], box[2])):
            self.assertAlmostEqual(found, wanted, delta=2e-6)
        self.assertAlmostEqual(low[1], cy - RADIUS, delta=0.15)
        self.convert("verify", "t.nrrd", "a.ply", *arguments[1:])
        capped = self.convert(*arguments, "--cap", "-o", "b.ply")
        self.assertIn("that cover the region, and clips the surface at its faces", capped.err)
        whole = read_ply((self.folder / "b.ply").read_bytes())
        self.assertEqual(whole.open_edges(), 0)
        # The samples cover the box: cut at its planes, it is all there.
        planes = [(-1 if side else 1, axis, box[axis + 3 * side]) for axis in range(3) for side in range(2)]
        clips = [option for sign, axis, at in planes for option in
                 ("--clip", ",".join(str(sign if k == axis else 0) for k in range(3)) + f",{sign * at}")]
        volumes = []
        for region in ((), ("--roi", roi)):
            self.convert(*arguments[:-2], *region, "--cap", *clips, "-o", "c.ply")
            volumes.append(read_ply((self.folder / "c.ply").read_bytes()).volume())
        self.assertAlmostEqual(volumes[0], volumes[1], delta=1e-4 * volumes[0])
        self.assertAlmostEqual(volumes[0], whole.volume(), delta=1e-4 * volumes[0])

    def test_parts_that_the_mesh_lost_are_told(self):
        run = self.convert(SPHERE, "--iso", "0", "--error", "-o", "a.ply", "--report", "r.json")
        self.assertIn("the mesh has the surface's only component", run.err)
        found = json.loads((self.folder / "r.json").read_bytes())["meshes"][0]["error"]["coverage"]
        self.assertEqual((found["components"], found["lost_components"]), (1, 0))
        self.assertTrue(1e-4 < found["distances"]["max"]["voxels"] <= found["max_at_most"]["voxels"] < 0.3, found)

        def balls(x, y, z):
            return max(4 - math.dist((x, y, z), (5, 5, 5)), 1.1 - math.dist((x, y, z), (14, 5, 5)))
        self.write_raw("b.raw", (21, 11, 11), balls)
        raw = ("b.raw", "--dims", "21,11,11", "--dtype", "f32", "--iso", "0", "--error", "-o", "a.ply")
        self.assertIn("the mesh has all 2 components", self.convert(*raw).err)
        coarse = self.convert(*raw, "--resolution", "7,4,4").err
        self.assertIn("the mesh lacks 1 of 2 components", coarse)
        worst = float(re.search(r"from the surface of the data to the mesh: .*? max (\S+) voxels", coarse).group(1))
        self.assertGreater(worst, 5)

    def test_kernels_between_samples(self):
        coarse = ("demo:sphere?size=9", "--iso", "0", "--resolution", "65", "--error", "tricubic")
        rms = {}
        for kernel in ("linear", "cubic", "bspline"):
            err = self.convert(*coarse, "--kernel", kernel, "-o", "a.ply").err
            rms[kernel] = float(re.search(r"interpolant: rms (\S+),", err).group(1))
        self.assertLess(rms["cubic"], rms["linear"] / 4)
        self.assertGreater(rms["bspline"], rms["cubic"])
        self.assert_fails(1, self.run_program(SPHERE, "--iso", "0", "--kernel", "cubic"), "needs --resolution or --voxel-size",
                          "--resolution")


if __name__ == "__main__":
    main()
