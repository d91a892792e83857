"""Bodies and cavities of surface nets are those of the samples, however often vertices are relaxed. A flood fill says
which there are."""

import json
import math
import random

from support import DATA, ProgramTest, main, needs_data

SIDE = 22
RAW = ("noise.raw", "--dims", f"{SIDE},{SIDE},{SIDE}", "--dtype", "f32", "--iso", "0", "--method", "surface-nets")
FACES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
AROUND = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)
          if 0 < abs(x) + abs(y) + abs(z) < 3]


def neighbors(voxel, steps):
    return [tuple(a + b for a, b in zip(voxel, step)) for step in steps]


def threshold(voxel):
    """Many bodies on one side; on the other side one with many cavities, a large one with bodies in it."""
    if voxel[0] > 14:
        return 0.56
    return 0.56 if math.dist(voxel, (7, 11, 11)) < 5.2 else 0.3


class Shells:
    """Samples inside are joined by faces, those outside by edges as well; beyond the data all is outside."""

    def __init__(self, inside):
        voxels = [(x, y, z) for x in range(-1, SIDE + 1) for y in range(-1, SIDE + 1) for z in range(-1, SIDE + 1)]
        self.label = {}
        self.insides = []
        for start in voxels:  # the first is beyond the data
            if start in self.label:
                continue
            name, is_inside = len(self.insides), inside(start)
            self.insides.append(is_inside)
            self.label[start] = name
            waiting = [start]
            while waiting:
                for other in neighbors(waiting.pop(), FACES if is_inside else AROUND):
                    if max(other) <= SIDE and min(other) >= -1 and other not in self.label and inside(other) == is_inside:
                        self.label[other] = name
                        waiting.append(other)
        self.area = {}  # of pairs of a body and what is outside of it, in faces
        for voxel in voxels:
            if self.insides[self.label[voxel]]:
                for other in neighbors(voxel, FACES):
                    if not self.insides[self.label[other]]:
                        pair = (self.label[voxel], self.label[other])
                        self.area[pair] = self.area.get(pair, 0) + 1
        self.around = {}  # of each body what it lies in; what is left of the pairs are cavities
        level = {0}
        while level:
            bodies = {body for body, outside in self.area if outside in level and body not in self.around}
            self.around.update({body: next(o for b, o in self.area if b == body and o in level) for body in bodies})
            level = {outside for body, outside in self.area if body in bodies and outside != self.around[body]}

    def cavities(self, body):
        return sum(1 for other, outside in self.area if other == body and outside != self.around[body])

    def largest(self):
        return max(self.around, key=lambda body: self.area[body, self.around[body]])


class NetSidesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        rng = random.Random(4)
        noise = {(x, y, z): rng.random() for x in range(SIDE) for y in range(SIDE) for z in range(SIDE)}
        values = {v: (noise[v] + sum(noise.get(n, 0.5) for n in neighbors(v, FACES))) / 7 - threshold(v) for v in noise}
        self.write_raw("noise.raw", (SIDE, SIDE, SIDE), lambda x, y, z: values[x, y, z])
        self.shells = Shells(lambda voxel: values.get(voxel, -1) > 0)

    def pieces(self, relax, *options):
        self.convert(*RAW, "--relax", relax, *options, "-o", "a.glb", "--report", "r.json")
        report = json.loads((self.folder / "r.json").read_text())
        (record,) = report.get("pieces", [None])
        return report, record

    def test_sides_are_those_of_the_samples(self):
        shells = self.shells
        bodies, largest = len(shells.around), shells.largest()
        self.assertGreater(len(shells.area), bodies + 20)
        self.assertGreater(sum(1 for body in shells.around.values() if body != 0), 0)
        free = [body for body, around in shells.around.items() if around == 0]
        for relax in (0, 1, 10, 100, 200):
            report, record = self.pieces(relax, "--largest")
            self.assertEqual(sum(one["cavity"] for one in report["meshes"][0]["component_table"]["largest"]),
                             shells.cavities(largest), relax)
            self.assertEqual((record["before"]["components"], record["before"]["bodies"]), (len(shells.area), bodies), relax)
            self.assertEqual((record["after"]["components"], record["after"]["bodies"]),
                             (1 + shells.cavities(largest), 1), relax)
            _, record = self.pieces(relax, "--fill-cavities")
            self.assertEqual((record["after"]["components"], record["after"]["bodies"]), (len(free), len(free)), relax)

    def test_what_is_dropped_does_not_depend_on_relaxation(self):
        for least in ("volume:3", "area:20"):
            after = [self.pieces(relax, "--drop-components", least)[1]["after"] for relax in (0, 3, 10, 60)]
            self.assertEqual(after, after[:1] * 4, least)

    def test_a_piece_has_its_own_cavities(self):
        expected = sorted(1 + self.shells.cavities(body) for body in self.shells.around)
        for more in ((), ("--simplify", "0.5"), ("--smooth", "10")):
            for relax in (0, 10):
                report, _ = self.pieces(relax, "--split-components", *more)
                self.assertEqual(sorted(mesh["components"] for mesh in report["meshes"]), expected, (relax, more))

    @needs_data("med/MR.nii.gz")
    def test_a_scan(self):
        head = (DATA / "med/MR.nii.gz", "--iso", "120", "--method", "surface-nets", "--largest", "-o", "a.ply")
        found = []
        for relax in (0, 10):
            self.convert(*head, "--relax", relax, "--report", "r.json")
            (record,) = json.loads((self.folder / "r.json").read_text())["pieces"]
            found.append((record["before"], record["after"]))
        self.assertEqual(found[0], found[1])
        self.assertGreater(found[1][1]["components"], 3200)


if __name__ == "__main__":
    main()
