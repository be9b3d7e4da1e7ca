"""Volumes of labels as files that `transect slice` reads."""

import numpy as np


def write(path, voxels):
    """Bytes, unit spacing: the middle of voxel (i, j, k) is at (i, j, k)."""
    header = (
        "NRRD0004\ntype: uint8\ndimension: 3\nencoding: raw\n"
        f"sizes: {' '.join(map(str, voxels.shape))}\nspacings: 1 1 1\n\n"
    )
    # In the file the first axis is the fastest.
    path.write_bytes(header.encode() + voxels.astype(np.uint8).tobytes(order="F"))
