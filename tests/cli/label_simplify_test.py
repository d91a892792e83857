"""--simplify and --triangles on label maps: neighbors keep the same triangles on their common faces. --resolution and
--voxel-size: the label of most voxels. Both against NumPy."""

import collections
import json
import re

from support import ProgramTest, main, needs_modules, read_glb

needs_modules("numpy", "scipy")

import numpy  # noqa: E402
import scipy.spatial  # noqa: E402


def voronoi(size, cells, seed):
    """A label from 1 for each voxel, that of the nearest of random points."""
    points = numpy.random.default_rng(seed).uniform(0, size, (cells, 3))
    grid = numpy.indices((size, size, size)).reshape(3, -1).T
    return (scipy.spatial.cKDTree(points).query(grid)[1] + 1).reshape(size, size, size).astype("<u2")


def head(size):
    """Thin shells around a core, in air (0), on a column that reaches the data boundary."""
    z, y, x = numpy.indices((size, size, size)) - (size - 1) / 2
    radius = numpy.sqrt((x / 0.85) ** 2 + y ** 2 + ((z - 4) / 0.95) ** 2)
    labels = numpy.zeros((size, size, size), "<u2")
    for label, outer in enumerate((0.40, 0.355, 0.30, 0.25, 0.18), 1):
        labels[radius < outer * size] = label
    labels[(labels == 0) & (x ** 2 + y ** 2 < (0.16 * size) ** 2) & (z < 0)] = 6
    return labels


class Part:
    """The triangles of a label, as rows of positions."""

    def __init__(self, mesh):
        self.vertices = numpy.array(mesh.vertices, numpy.float64)
        self.triangles = numpy.array(mesh.triangles, numpy.int64)
        self.corners = self.vertices[self.triangles]

    def keys(self):
        """Each triangle as its positions, the least first: a tuple for each."""
        rows = [[tuple(p) for p in t] for t in self.corners]
        return [tuple(t[t.index(min(t)):] + t[:t.index(min(t))]) for t in rows]

    def volume(self):
        a, b, c = numpy.moveaxis(self.corners, 1, 0)
        return numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6

    def is_closed(self):
        edges = collections.Counter()
        for t in self.triangles:
            for a, b in ((0, 1), (1, 2), (2, 0)):
                edges[t[a], t[b]] += 1
        return all(count == 1 and edges[b, a] == 1 for (a, b), count in edges.items())

    def euler(self):
        edges = {tuple(sorted(e)) for t in self.triangles for e in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))}
        return len(set(self.triangles.flat)) - len(edges) + len(self.triangles)

    def points(self):
        """Vertices, middles of edges and centers."""
        middles = (self.corners + numpy.roll(self.corners, 1, axis=1)) / 2
        return numpy.unique(numpy.concatenate(
            (self.vertices[numpy.unique(self.triangles)], middles.reshape(-1, 3), self.corners.mean(axis=1))), axis=0)


def turned(key):
    a, b, c = key
    return a, c, b


def distances(points, triangles):
    """The distance of each point from the nearest triangle."""
    least = numpy.full(len(points), numpy.inf)
    for a, b, c in triangles:
        ab, ac, ap = b - a, c - a, points - a
        normal = numpy.cross(ab, ac)
        area = normal @ normal
        at_b = numpy.cross(ap, ac) @ normal / area
        at_c = numpy.cross(ab, ap) @ normal / area
        inside = (at_b >= 0) & (at_c >= 0) & (at_b + at_c <= 1)
        found = numpy.where(inside, numpy.abs(ap @ normal) / numpy.sqrt(area), numpy.inf)
        for p, q in ((a, b), (b, c), (c, a)):
            t = numpy.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
            found = numpy.minimum(found, numpy.linalg.norm(points - p - t[:, None] * (q - p), axis=1))
        least = numpy.minimum(least, found)
    return least


class LabelSimplifyTest(ProgramTest):
    def made(self, labels, *options, name="m"):
        """The meshes by label, their keys, and the report."""
        labels.tofile(self.folder / f"{name}.raw")
        z, y, x = labels.shape
        run = self.convert(f"{name}.raw", "--dims", f"{x},{y},{z}", "--dtype", "u16", "--labels", "all", *options,
                           "--normals", "none", "--up", "y", "-o", "out.glb", "--report", "r.json")
        self.told = run.err
        meshes = read_glb((self.folder / "out.glb").read_bytes())
        return ({int(n.split()[-1]): Part(m) for n, m in meshes.items()},
                json.loads((self.folder / "r.json").read_text()))

    def check_common_faces(self, parts):
        """Counts common triangles by pair of labels; each occurs once in each of two labels, turned over in one."""
        owner = {}
        for label, part in parts.items():
            for key in part.keys():
                self.assertNotIn(key, owner)
                owner[key] = label
        common = collections.Counter()
        alone = []
        for key, label in owner.items():
            other = owner.get(turned(key))
            if other is None:
                alone.append(key)
            else:
                self.assertNotEqual(label, other)
                common[min(label, other), max(label, other)] += 1
        return common, numpy.array(alone)

    def check_simplified(self, labels, options, part_left, extraction=()):
        before, _ = self.made(labels, *extraction)
        pairs_before, alone_before = self.check_common_faces(before)
        after, report = self.made(labels, *extraction, *options)
        self.assertNotIn("separately", self.told)
        pairs, alone = self.check_common_faces(after)
        self.assertEqual(set(pairs), set(pairs_before))
        changes = {label: after[label].volume() / part.volume() - 1 for label, part in before.items()}
        most = max(changes, key=lambda label: abs(changes[label]))
        if abs(changes[most]) < 1e-7:
            self.assertIn("no label changed its volume", self.told)
        else:
            (told,) = re.findall(r"the volume changed most at label (\d+): ([\d.]+) % (more|less)", self.told)
            self.assertEqual((int(told[0]), told[2]), (most, "more" if changes[most] > 0 else "less"))
            self.assertAlmostEqual(float(told[1]), 100 * abs(changes[most]), delta=0.01 * 100 * abs(changes[most]))
        # Each triangle is in its report's sum once for each label.
        triangles = sum(len(p.triangles) for p in after.values())
        self.assertEqual(triangles, sum(pairs.values()) + len(alone))
        self.assertEqual(triangles, sum(entry["triangles_after"] for entry in report["simplifications"]))
        net = sum(pairs.values()) // 2 + len(alone)
        net_before = sum(pairs_before.values()) // 2 + len(alone_before)
        self.assertLessEqual(net, part_left * net_before)
        for label, part in after.items():
            self.assertTrue(part.is_closed(), label)
            self.assertEqual(part.euler(), before[label].euler(), label)
        # What the labels have in common cancels, so their volumes add up to that of what they do not have in common.
        outer = numpy.einsum("ij,ij->i", alone[:, 0], numpy.cross(alone[:, 1], alone[:, 2])).sum() / 6
        whole = sum(p.volume() for p in after.values())
        self.assertAlmostEqual(whole / outer, 1, delta=1e-9)
        (upper,) = {entry["measured"]["voxels"]["upper"] for entry in report["simplifications"]}
        for label, part in after.items():
            self.assertLessEqual(distances(before[label].points()[::23], part.corners).max(), upper + 1e-5, label)
            near = scipy.spatial.cKDTree(before[label].corners.mean(axis=1))
            for point in part.points()[::41]:
                candidates = before[label].corners[near.query_ball_point(point, upper + 1.5)]
                self.assertLessEqual(distances(point[None], candidates).max(), upper + 1e-5, label)
        return before, after, report, alone

    def test_a_voronoi_diagram_at_ten_percent(self):
        labels = voronoi(48, 30, 1)
        before, after, report, alone = self.check_simplified(labels, ("--triangles", "10%"), 0.1)
        # Only the faces of the box have one label.
        self.assertLess(numpy.abs(numpy.abs(alone - 23.5) .max(axis=2) - 24).max(),
                        report["simplifications"][0]["measured"]["voxels"]["upper"] + 1e-5)
        self.assertAlmostEqual(sum(p.volume() for p in after.values()) / 48 ** 3, 1, delta=2e-3)
        self.assertIn("30 labels together", self.told)

    def test_a_head_of_thin_layers_at_ten_percent(self):
        labels = head(48)
        before, after, _, _ = self.check_simplified(labels, ("--triangles", "10%"), 0.1)
        self.assertEqual(set(after), set(range(1, 7)))
        for label, part in after.items():
            self.assertAlmostEqual(part.volume() / before[label].volume(), 1, delta=0.1)

    def test_a_distance(self):
        labels = head(32)
        for method, most in (((), 0.7), (("--method", "voxels", "--no-merge"), 1)):
            _, _, report, _ = self.check_simplified(labels, ("--simplify", "0.4"), most, method)
            self.assertLessEqual(report["simplifications"][0]["measured"]["voxels"]["upper"], 0.4)

    def test_noise_stays_closed(self):
        """Labels that touch along edges and in corners, everywhere."""
        for seed in range(3):
            labels = numpy.random.default_rng(seed).integers(0, 4, (9, 8, 7)).astype("<u2")
            before, _ = self.made(labels)
            after, _ = self.made(labels, "--simplify", "0.5")
            self.assertEqual(set(self.check_common_faces(after)[0]), set(self.check_common_faces(before)[0]))
            for label, part in after.items():
                self.assertTrue(part.is_closed())
                self.assertEqual(part.euler(), before[label].euler())

    def test_threads_change_no_byte(self):
        labels = voronoi(24, 9, 5)
        files = set()
        for threads in (1, 2, 5):
            self.made(labels, "--triangles", "20%", "--threads", threads)
            files.add((self.folder / "out.glb").read_bytes())
        self.assertEqual(len(files), 1)

    def test_one_file_for_each_label_has_the_same_meshes(self):
        labels = voronoi(24, 4, 2)
        together, _ = self.made(labels, "--simplify", "0.3")
        self.convert("m.raw", "--dims", "24,24,24", "--dtype", "u16", "--labels", "all", "--simplify", "0.3", "--normals",
                     "none", "--up", "y", "-o", "part_{label}.glb")
        for label, part in together.items():
            (mesh,) = read_glb((self.folder / f"part_{label}.glb").read_bytes()).values()
            self.assertEqual(Part(mesh).keys(), part.keys())

    def test_t_junctions_are_refused(self):
        voronoi(12, 4, 2).tofile(self.folder / "m.raw")
        run = self.run_program("m.raw", "--dims", "12,12,12", "--dtype", "u16", "--labels", "all", "--method", "voxels",
                               "--t-junctions", "--triangles", "20%", "-o", "x.glb")
        self.assert_fails(1, run, "--triangles does not work with --t-junctions on labels", "leave --t-junctions out")


def majority(labels, resolution):
    """The label of most voxels in each cell, in whole numbers; of the nearest voxel if it is one of several."""
    def cells(old, new):
        n, s = old - 1, new - 1
        for i in range(new):
            center = 2 * i * n
            below, rest = divmod(i * n, s)
            nearest = below + (2 * rest > s)
            if new >= old:
                yield nearest, {nearest: 1}
                continue
            half = min(n, 2 * min(i * n, (s - i) * n) + s)
            weights = {j: min(center + half, (2 * j + 1) * s) - max(center - half, (2 * j - 1) * s) for j in range(old)}
            yield nearest, {j: w for j, w in weights.items() if w > 0}

    result = numpy.zeros(resolution, labels.dtype)
    zs, ys, xs = (list(cells(old, new)) for old, new in zip(labels.shape, resolution))
    for k, (near_z, of_z) in enumerate(zs):
        for j, (near_y, of_y) in enumerate(ys):
            for i, (near_x, of_x) in enumerate(xs):
                votes = collections.Counter()
                for z, wz in of_z.items():
                    for y, wy in of_y.items():
                        for x, wx in of_x.items():
                            votes[labels[z, y, x]] += wz * wy * wx
                most = max(votes.values())
                winners = [label for label, votes_of in votes.items() if votes_of == most]
                center = labels[near_z, near_y, near_x]
                result[k, j, i] = center if center in winners else min(winners)
    return result


class LabelGridTest(ProgramTest):
    def resampled(self, labels, resolution, *options):
        """The samples of the new grid, read from an uncompressed file of them."""
        z, y, x = labels.shape
        labels.tofile(self.folder / "m.raw")
        self.convert("m.raw", "--dims", f"{x},{y},{z}", "--dtype", "u16", "--kernel", "majority", "--resolution",
                     ",".join(str(n) for n in resolution[::-1]), *options, "-o", "grid.npy")
        return numpy.load(self.folder / "grid.npy")

    def test_a_coarser_grid_takes_the_label_of_most_voxels(self):
        random = numpy.random.default_rng(7)
        smooth = voronoi(20, 40, 3)
        noise = random.integers(1, 4, (12, 13, 11)).astype("<u2")
        stripes = numpy.broadcast_to(numpy.arange(12) % 2 + 3, (12, 12, 12)).astype("<u2")
        for labels, resolution in ((smooth, (10, 10, 10)), (smooth, (7, 5, 20)), (noise, (6, 5, 4)), (noise, (2, 2, 2)),
                                   (stripes, (4, 4, 6)), (noise, (5, 24, 4))):
            self.assertTrue((self.resampled(labels, resolution) == majority(labels, resolution)).all(), resolution)

    def test_labels_use_it(self):
        """Walls one voxel thick are in no cell of four voxels the label of most of them."""
        labels = numpy.full((25, 25, 25), 1, "<u2")
        labels[2::4] = 2
        labels[:, :12] = 3
        labels.tofile(self.folder / "m.raw")
        raw = ("m.raw", "--dims", "25,25,25", "--dtype", "u16", "--labels", "all", "-o", "a.glb", "--report", "r.json")
        run = self.convert(*raw, "--resolution", "7")
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(report["options"]["kernel"], "majority")
        self.assertIn("no mesh for 1 of 3 labels (2)", run.err)
        left = numpy.unique(majority(labels, (7, 7, 7)))
        self.assertEqual([m["name"] for m in report["meshes"]], [f"m label {label}" for label in left])
        volumes = {m["name"]: m["volume"] for m in report["meshes"]}
        count = (majority(labels, (7, 7, 7)) == 3).sum()
        self.assertAlmostEqual(volumes["m label 3"] / (count * 4 ** 3), 1, delta=2e-3)


if __name__ == "__main__":
    main()
