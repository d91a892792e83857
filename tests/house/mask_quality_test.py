"""The figures of scripts/measuring/mask_quality.py, of meshes whose figures are known: mask_quality_test.py PROJECT_FOLDER"""

import pathlib
import sys
import unittest

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(sys.argv.pop(1)) / "scripts" / "measuring"))

import mask_quality  # noqa: E402


def faces_of(mask):
    """Returns the middles, z, y, x, of the faces between voxels inside and outside, by axis."""
    found = []
    for axis in range(3):
        steps = np.diff(mask.astype(int), axis=axis)
        found.append([(np.argwhere(steps == side) + np.eye(3)[axis] / 2, side) for side in (1, -1)])
    return found


def mesh_of(mask):
    """Returns the faces of the voxels as triangles that wind counter-clockwise seen from outside; points are x, y, z."""
    squares = []
    for axis, sides in enumerate(faces_of(mask)):
        one, other = np.eye(3)[(axis + 1) % 3] / 2, np.eye(3)[(axis + 2) % 3] / 2
        for middles, side in sides:
            corners = np.stack([middles - one - other, middles + one - other, middles + one + other, middles - one + other], 1)
            squares.append(corners if side == 1 else corners[:, ::-1])  # x, y, z turns the order
    corners = np.concatenate(squares)[:, :, ::-1]
    points, places = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    places = places.reshape(-1, 4)
    return points, np.concatenate([places[:, [0, 1, 2]], places[:, [0, 2, 3]]])


def box():
    return np.pad(np.ones((5, 4, 3), np.uint8), 4)


class MaskQualityTest(unittest.TestCase):
    def figures(self, mask, x=0.0):
        points, triangles = mesh_of(mask)
        return mask_quality.figures(mask, points + (x, 0, 0), triangles)

    def test_a_box(self):
        found = self.figures(box())
        squares = 2 * (5 * 4 + 4 * 3 + 3 * 5)
        self.assertEqual(found["triangles"], 2 * squares)
        self.assertAlmostEqual(found["volume"], 1)
        self.assertEqual((found["distance"], found["lost"], found["gained"]), (0, 0, 0))
        bent = 4 * (5 + 4 + 3)  # unit edges of the box, of the three edges for each two triangles
        self.assertAlmostEqual(found["angle"], 90 * bent / (3 * squares))

    def test_a_box_that_moved(self):
        for x, layers in ((0.3, 0), (0.7, 1), (1.6, 2), (-2.4, 2)):
            found = self.figures(box(), x)
            self.assertAlmostEqual(found["volume"], 1)
            self.assertAlmostEqual(found["distance"], abs(x))
            self.assertEqual((found["lost"], found["gained"]), (layers * 20, layers * 20))

    def test_a_box_that_is_larger(self):
        points, triangles = mesh_of(box())
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        found = mask_quality.figures(box(), middle + 1.2 * (points - middle), triangles)
        self.assertAlmostEqual(found["volume"], 1.2 ** 3)

    def test_a_mask_is_cut_to_the_middle_and_to_its_bounds(self):
        field = np.zeros((10, 7, 3))
        field[0, 0, 0] = field[9, 6, 2] = field[4:6, 3, 1] = 2
        self.assertEqual([mask_quality.above(field, 1, size).sum() for size in (10, 4)], [4, 2])
        self.assertEqual(mask_quality.above(field, 1, 4).shape, (6, 5, 5))

    def test_noise(self):
        mask = np.pad((np.random.default_rng(1).random((6, 7, 8)) < 0.4).astype(np.uint8), 2)
        found = self.figures(mask)
        self.assertAlmostEqual(found["volume"], 1)
        self.assertEqual((found["distance"], found["lost"], found["gained"]), (0, 0, 0))

    def test_distances_are_those_to_every_face(self):
        random = np.random.default_rng(2)
        for count, share in [(1, 0.01)] * 10 + [(1, 0.1)] * 10 + [(50, 0.4)] * 5:
            mask = np.pad((random.random((7, 7, 7)) < share).astype(np.uint8), 1)
            mask[4, 4, 4] = 1
            points = 9 * random.random((count, 3)) - 0.5
            nearest = np.full(count, np.inf)
            for axis, sides in enumerate(faces_of(mask)):
                half = np.where(np.arange(3) == axis, 0, 0.5)
                for middles, _ in sides:
                    beyond = np.maximum(np.abs(points[:, None] - middles) - half, 0)
                    nearest = np.minimum(nearest, np.linalg.norm(beyond, axis=2).min(axis=1, initial=np.inf))
            self.assertAlmostEqual(mask_quality.to_faces(points, mask), nearest.max())

    def test_a_straight_way_is_nearer_than_an_oblique_one_to_a_nearer_voxel(self):
        mask = np.zeros((9, 9, 9), np.uint8)
        mask[5, 5, 5] = mask[6, 4, 4] = 1
        self.assertAlmostEqual(mask_quality.to_faces(np.array([[4.4, 3.5, 3.5]]), mask), 1.1)

    def test_a_distance_that_is_not_measured(self):
        mask = np.zeros((30, 5, 5), np.uint8)
        mask[2, 2, 2] = 1
        with self.assertRaises(ValueError):
            mask_quality.to_faces(np.array([[25.0, 2, 2]]), mask)


if __name__ == "__main__":
    unittest.main()
