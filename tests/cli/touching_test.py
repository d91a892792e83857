"""--touching: STL files are closed 2-manifolds after welding by position; the summary says so only where it is true."""

import collections
import json
import random
import subprocess

from support import ProgramTest, main, needs_data, needs_program, DATA, read_ply, read_stl

VOXELS = ("--iso", "0.5", "--method", "voxels")
NETS = ("--iso", "0.5", "--method", "surface-nets")
WAYS = (VOXELS, (*VOXELS, "--no-merge"), (*NETS, "--relax", "0"), NETS, (*NETS, "--relax", "60"),
        (*NETS, "--smooth", "5"), (*NETS, "--simplify", "0.05"))
EDGE = {(1, 1, 1), (2, 2, 1)}
CORNER = {(1, 1, 1), (2, 2, 2)}


def defects(mesh):
    """Welds by position. Returns the edges without exactly two triangles, one each way, and the vertices whose
    triangles do not form one fan."""
    place = {}
    triangles = [[place.setdefault(mesh.vertices[v], len(place)) for v in t] for t in mesh.triangles]
    edges = collections.Counter()
    fans = collections.defaultdict(list)
    for t in triangles:
        for a, b, c in (t, t[1:] + t[:1], t[2:] + t[:2]):
            edges[a, b] += 1
            fans[a].append((b, c))
    bad_edges = {frozenset(e) for e, n in edges.items() if n != 1 or edges[e[1], e[0]] != 1}
    bad_vertices = 0
    for around in fans.values():
        following = dict(around)
        start = around[0][0]
        at, steps = following[start], 1
        while at != start and at in following and steps <= len(around):
            at, steps = following[at], steps + 1
        bad_vertices += steps != len(around)
    return len(bad_edges), bad_vertices


class TouchingTest(ProgramTest):
    def write(self, name, size, inside):
        self.write_raw(name, (size,) * 3, lambda *p: p in inside, "B")
        return (name, "--dims", ",".join([str(size)] * 3), "--dtype", "u8")

    def stl(self, *arguments):
        self.last = self.convert(*arguments, "-o", "out.stl", "--report", "r.json")
        return read_stl((self.folder / "out.stl").read_bytes())

    def intersections(self):
        """What check says of them."""
        out = self.run_program("check", "out.stl").out.decode()
        (line,) = [" ".join(line.split()) for line in out.splitlines() if line.startswith("  intersections")]
        return line

    def test_edges_and_corners_are_apart(self):
        for inside in (EDGE, CORNER):
            source = self.write("two.raw", 4, inside)
            for way in (VOXELS, NETS):
                with self.subTest(inside=inside, way=way):
                    kept = self.stl(*source, *way, "--touching", "keep")
                    self.assertNotEqual(defects(kept), (0, 0))
                    edges = "1 edge" if inside is EDGE else "0 edges"
                    self.assertIn(f"not manifold: readers weld touching sheets at {edges} and", self.last.err)
                    self.assertNotIn("closed", self.last.err)
                    facts = json.loads((self.folder / "r.json").read_text())["meshes"][0]
                    self.assertFalse(facts["closed"])
                    self.assertEqual(facts["nonmanifold_edges"], 1 if inside is EDGE else 0)
                    mesh = self.stl(*source, *way)
                    self.assertEqual(defects(mesh), (0, 0))
                    self.assertIn("; closed;", self.last.err)
                    self.assertIn("note[moved-apart]: sheets of 1 surface touch", self.last.err)
                    report = json.loads((self.folder / "r.json").read_text())
                    self.assertTrue(report["meshes"][0]["closed"])
                    (record,) = report["touching"]
                    self.assertEqual((record["touching"], record["moved"]), (4, 4) if inside is EDGE else (2, 2))
                    self.assertAlmostEqual(record["greatest_move"], 0.001, delta=1e-6)
                    self.assertAlmostEqual(record["volume"]["before"], kept.volume(), delta=1e-5)
                    self.assertAlmostEqual(record["volume"]["after"], mesh.volume(), delta=1e-5)
                    moved = sum(a != b for a, b in zip(kept.vertices, mesh.vertices))
                    self.assertGreater(moved, 0)
                    for a, b in zip(kept.vertices, mesh.vertices):
                        self.assertLess(sum((p - q) ** 2 for p, q in zip(a, b)) ** 0.5, 0.00101)
                    self.assertEqual(self.run_program("check", "out.stl", "--require", "manifold").code, 0)

    def noise(self, percent, size=9):
        draw = random.Random(percent)
        return {(x, y, z) for x in range(size) for y in range(size) for z in range(size) if draw.random() < percent / 100}

    def test_noise_of_any_density(self):
        for percent in (10, 30, 50, 80):
            source = self.write("noise.raw", 9, self.noise(percent))
            for way in WAYS:
                with self.subTest(percent=percent, way=way):
                    mesh = self.stl(*source, *way)
                    self.assertEqual(defects(mesh), (0, 0))
                    self.assertIn("; closed;", self.last.err)
                    if way[-2] in ("--smooth", "--simplify"):  # which may make triangles intersect
                        continue
                    found = self.intersections()
                    if way[:4] == NETS and way[-2:] != ("--relax", "0"):  # so may relaxing, in dense noise
                        self.stl(*source, *way, "--touching", "keep")
                        self.assertEqual(found, self.intersections())
                    else:
                        self.assertIn("intersections none", found)

    def test_sheets_without_a_way_off_move_apart_too(self):
        """Relaxed next to other labels, two sheets share an edge and are too bent to move off all of their triangles."""
        planes = ("2024400 0100040 1100000 1111100 0111110 0110200 0202210",
                  "4040020 2024440 0111240 0100010 1110110 0111010 0200110",
                  "0002220 4444220 0244440 1111240 0010020 1110010 1111110",
                  "0022000 2222200 4444220 4444440 1222240 1111120 0010010",
                  "0101000 2220200 2222020 0442220 4440440 1024000 1111240")
        rows = [plane.split() for plane in planes]
        self.write_raw("bent.raw", (7, 7, 5), lambda x, y, z: int(rows[z][y][x]), "B")
        source = ("bent.raw", "--dims", "7,7,5", "--dtype", "u8", "--labels", "1")
        self.assertEqual(defects(self.stl(*source)), (0, 0))
        self.assertIn("; closed;", self.last.err)
        self.assertEqual(self.run_program("check", "out.stl", "--require", "closed,manifold,oriented").code, 0)

    def test_grids_with_long_voxels_and_far_origins(self):
        source = self.write("noise.raw", 9, self.noise(30))
        for place in (("--spacing", "0.2,0.7,5"), ("--origin", "3000,-2000,500"), ("--spacing", "1e-6"),
                      ("--origin", "20000,0,0")):
            with self.subTest(place=place):
                mesh = self.stl(*source, *NETS, *place)
                self.assertEqual(defects(mesh), (0, 0))
                self.assertIn("; closed;", self.last.err)

    def test_other_formats_keep_their_bytes(self):
        source = self.write("edge.raw", 4, EDGE)
        for name in ("a.ply", "a.glb", "a.obj"):
            self.convert(*source, *VOXELS, "-o", name)
            kept = (self.folder / name).read_bytes()
            self.convert(*source, *VOXELS, "--touching", "keep", "-o", name)
            self.assertEqual((self.folder / name).read_bytes(), kept)
        self.convert(*source, *VOXELS, "--touching", "apart", "-o", "apart.ply")
        mesh = read_ply((self.folder / "apart.ply").read_bytes())
        self.assertEqual(len(set(mesh.vertices)), len(mesh.vertices))

    def test_without_contacts_nothing_is_told(self):
        self.stl("demo:sphere?size=16", "--iso", "0")
        self.assertIn("; closed;", self.last.err)
        self.assertNotIn("moved-apart", self.last.err)
        (record,) = json.loads((self.folder / "r.json").read_text())["touching"]
        self.assertEqual((record["touching"], record["moved"], record["volume"]), (0, 0, None))

    def test_verify_moves_them_too(self):
        source = self.write("noise.raw", 9, self.noise(30))
        self.stl(*source, *NETS)
        self.convert("verify", *source, *NETS, "out.stl")
        run = self.run_program("verify", *source, *NETS, "--touching", "keep", "out.stl")
        self.assertEqual(run.code, 6)

    def test_words(self):
        run = self.run_program("demo:sphere?size=16", "--iso", "0", "--touching", "split", "-o", "a.stl")
        self.assert_fails(1, run, "apart", "keep")

    @needs_program("admesh")
    def test_admesh_agrees(self):
        for inside in (EDGE, self.noise(40)):
            self.stl(*self.write("noise.raw", 9, inside), *VOXELS)
            found = subprocess.run(["admesh", "out.stl"], cwd=self.folder, capture_output=True, text=True, check=True).stdout
            for words in ("Total disconnected facets        :     0", "Facets reversed       :     0",
                          "Backwards edges       :     0"):
                self.assertIn(words, found)

    @needs_data("med/FLAIR.nrrd")
    def test_mask_of_a_scan(self):
        scan = (DATA / "med/FLAIR.nrrd", "--voxel-size", "4")
        for method in ("voxels", "surface-nets"):
            mesh = self.stl(*scan, "--iso", "60", "--method", method)
            self.assertEqual(defects(mesh), (0, 0))
            self.assertIn("; closed;", self.last.err)
            self.assertGreater(json.loads((self.folder / "r.json").read_text())["touching"][0]["touching"], 100)


if __name__ == "__main__":
    main()
