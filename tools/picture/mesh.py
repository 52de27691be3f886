"""Triangles of an STL file, binary or text, with numpy alone."""
import pathlib

import numpy as np

RECORD = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])


class MeshError(Exception):
    """Says which file, and what is wrong with it."""


def load_stl(path):
    """The corners, n x 3 x 3, in the file's own unit."""
    data = pathlib.Path(path).read_bytes()
    if len(data) >= 84:
        count = int.from_bytes(data[80:84], "little")
        spare = len(data) - 84 - count * RECORD.itemsize  # Some programs end it with a line's end, or fill a block.
        if 0 <= spare < RECORD.itemsize and count > 0:
            return _checked(path, np.frombuffer(data, RECORD, count, 84)["corner"].astype(float))
    words = data.split()
    at = [i for i, word in enumerate(words) if word.lower() == b"vertex"]
    if not at or len(at) % 3 != 0:
        raise MeshError(f"{path}: is no STL file")
    index = np.asarray(at)[:, None] + np.arange(1, 4)
    try:
        corners = np.array(words, dtype=object)[index].astype(float)
    except (ValueError, IndexError) as error:
        raise MeshError(f"{path}: a vertex is no number: {error}") from error
    return _checked(path, corners.reshape(-1, 3, 3))


def _checked(path, corners):
    if not np.isfinite(corners).all():
        raise MeshError(f"{path}: triangle {np.argwhere(~np.isfinite(corners))[0][0]} is not finite")
    return corners


def smooth_normals(corners, crease_degrees=35.0):
    """A normal per corner: the mean of the faces about its vertex, but its own face's where they meet at a crease."""
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    points, vertex = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    mean = np.zeros_like(points)
    for axis in range(3):  # The cross product is twice the area: bigger faces weigh more.
        mean[:, axis] = np.bincount(vertex.ravel(), np.repeat(face[:, axis], 3), len(points))
    unit = lambda v: v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-30)
    corner = unit(mean)[vertex.ravel()].reshape(corners.shape)
    own = np.broadcast_to(unit(face)[:, None, :], corners.shape)
    return np.where((corner * own).sum(-1, keepdims=True) > np.cos(np.radians(crease_degrees)), corner, own)
