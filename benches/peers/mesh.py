"""Closed triangle meshes."""

from dataclasses import dataclass

import igl
import numpy as np
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


@dataclass
class Mesh:
    """Triangles (indices of vertices) with their normals outward."""

    vertices: np.ndarray
    triangles: np.ndarray

    @staticmethod
    def read(path):
        """A mesh of any kind that trimesh reads; vertices at one place become one."""
        read = trimesh.load_mesh(path, process=False)
        vertices, number = np.unique(read.vertices, axis=0, return_inverse=True)
        triangles = number.reshape(-1)[read.faces]
        return Mesh(np.array(vertices, float), np.ascontiguousarray(triangles, np.int64))

    @property
    def box(self):
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    @property
    def diagonal(self):
        low, high = self.box
        return float(np.linalg.norm(high - low))

    @property
    def volume(self):
        return float(self.volumes().sum())

    def volumes(self):
        """Of each triangle the volume of the tetrahedron that it makes with the origin."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        return np.einsum("ij,ij->i", a, np.cross(b, c)) / 6

    def sample(self, count, seed):
        """Points on the surface, uniform by area."""
        random = np.random.default_rng(seed)
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        chosen = random.choice(len(areas), count, p=areas / areas.sum())
        s, t = np.sqrt(random.random((count, 1))), random.random((count, 1))
        return a[chosen] * (1 - s) + b[chosen] * s * (1 - t) + c[chosen] * s * t

    def distances(self, points):
        """How far points are from the surface."""
        squares = igl.point_mesh_squared_distance(points, self.vertices, self.triangles)[0]
        return np.sqrt(squares)

    def pieces(self):
        """How many pieces the solid has: closed surfaces with their insides
        within. Those turned inside out are the walls of cavities."""
        if len(self.triangles) == 0:
            return 0
        ends = self.triangles[:, [0, 1, 1, 2]].reshape(-1, 2).T
        size = len(self.vertices)
        joined = coo_array((np.ones(ends.shape[1]), tuple(ends)), shape=(size, size))
        count, piece = connected_components(joined, directed=False)
        volumes = np.bincount(piece[self.triangles[:, 0]], self.volumes(), minlength=count)
        return int((volumes > 0).sum())
