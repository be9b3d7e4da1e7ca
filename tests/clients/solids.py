"""What the scripts beside this one say about a solid: how large, where, and whether it is closed."""

import json

import numpy


def measured(vertices, faces, color=None):
    """Of vertices in world units and triangles; vertices that are not shared leave gaps."""
    vertices = numpy.asarray(vertices, dtype=float)
    faces = numpy.asarray(faces, dtype=int)
    corners = vertices[faces]
    base = vertices[0]
    a, b, c = (corners[:, i] - base for i in range(3))
    volumes = numpy.einsum("ij,ij->i", a, numpy.cross(b, c)) / 6
    centroid = base + ((a + b + c) / 4 * volumes[:, None]).sum(axis=0) / volumes.sum()
    edges = numpy.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    # Every edge once each way.
    keys, turned = (numpy.sort(edges @ pair) for pair in ([len(vertices), 1], [1, len(vertices)]))
    closed = bool((keys[1:] != keys[:-1]).all() and (keys == turned).all())
    return {
        "closed": closed,
        "volume": float(volumes.sum()),
        "centroid": centroid.tolist(),
        "min": vertices.min(axis=0).tolist(),
        "max": vertices.max(axis=0).tolist(),
        "color": color,
    }


def from_gltf(places):
    """Metres with y up, as they are in LPS millimetres."""
    places = numpy.asarray(places, dtype=float) * 1000
    return numpy.stack([places[:, 0], -places[:, 2], places[:, 1]], axis=1)


def encoded(linear):
    """Linear light as 8 bits of sRGB."""
    bent = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    return round(255 * min(max(bent, 0), 1))


def tell(found):
    """What was found, on a line of its own."""
    print("\nRESULT " + json.dumps(found))
