"""Figures of solids for which they are known."""

import unittest

import numpy as np

from lattice import Lattice
from measures import Truth
from mesh import Mesh
from methods import slicewise
from sections import Section


def box(low, high):
    """A box of twelve triangles, normals outward."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    low, high = np.array(low, float), np.array(high, float)
    return Mesh(low + corners * (high - low), np.array(triangles))


def square(z, side):
    loop = np.array([[0, 0, z], [side, 0, z], [side, side, z], [0, side, z]], float)
    return Section(np.array([0.0, 0, 1]), float(z), [loop])


def joined(a, b):
    return Mesh(
        np.concatenate([a.vertices, b.vertices]),
        np.concatenate([a.triangles, b.triangles + len(a.vertices)]),
    )


class Measures(unittest.TestCase):
    def test_half_a_box(self):
        """Half of a cube: half of the volume, and of the pixels of a section across."""
        truth = Truth(box([0, 0, 0], [1, 1, 1]))
        across = Section(np.array([0.0, 0, 1]), 0.5, square(0.5, 1.0).loops)
        found = truth.measures(box([0, 0, 0], [0.5, 1, 1]), [across])
        self.assertAlmostEqual(found["iou"], 0.5)
        self.assertAlmostEqual(found["volume"], 0.5)
        # Twice a half over one and a half.
        self.assertAlmostEqual(found["dice"], 2 / 3, delta=0.01)
        # The far face is half a side away, and a cube's diagonal is √3.
        self.assertAlmostEqual(found["largest"], 500 / np.sqrt(3), delta=1)

    def test_the_solid_itself(self):
        cube = box([0, 0, 0], [1, 1, 1])
        found = Truth(cube).measures(cube, [square(0.5, 1.0)])
        self.assertEqual((found["iou"], found["dice"], found["pieces"]), (1, 1, 1))
        self.assertLess(found["largest"], 1e-3)

    def test_a_cavity_is_no_piece(self):
        within = box([0.3] * 3, [0.6] * 3)
        hollow = joined(box([0] * 3, [1] * 3), Mesh(within.vertices, within.triangles[:, ::-1]))
        self.assertEqual(hollow.pieces(), 1)
        self.assertEqual(joined(box([0] * 3, [1] * 3), box([2] * 3, [3] * 3)).pieces(), 2)
        lattice = Lattice(np.full(3, 0.45), np.array([0.3, 1, 1]), (2, 1, 1))
        self.assertEqual(lattice.inside(hollow).ravel().tolist(), [False, True])

    def test_lines_through_corners(self):
        """Nodes on a box's faces, edges and corners: of every two opposite ones, one is inside."""
        lattice = Lattice(np.zeros(3), np.full(3, 0.5), (3, 3, 3))
        inside = lattice.inside(box([0, 0, 0], [1, 1, 1]))
        self.assertTrue(inside[1, 1, 1])
        self.assertEqual(inside.sum(), 2**3)


class Slices(unittest.TestCase):
    def test_a_prism(self):
        """Equal squares make a prism, which ends rounded within a spacing."""
        sections = [square(z, 1.0) for z in (0.0, 0.25, 0.5, 0.75, 1.0)]
        # Beside the ends a cubic bulges: from 0 to 0 with slopes 0 and −¼ (half of
        # 0 to −½) it rises to ¼ · 4/27.
        for method, bulge in ((slicewise.linear, 0.0), (slicewise.cubic, 1 / 27)):
            mesh = method(sections, 64)
            low, high = mesh.box
            sides = [[-bulge] * 2, [1 + bulge] * 2]
            np.testing.assert_allclose([low[:2], high[:2]], sides, atol=0.01)
            # Halfway to the empty slice, where the square is deepest.
            np.testing.assert_allclose([low[2], high[2]], [-0.125, 1.125], atol=0.03)

    def test_distances_in_a_square(self):
        section = square(0.0, 1.0)
        flat = section.flat(np.array([[0.5, 0.5, 0], [1.5, 0.5, 0]]))
        np.testing.assert_allclose(section.distance(flat, 0.01), [0.5, -0.5], atol=1e-3)


if __name__ == "__main__":
    unittest.main()
