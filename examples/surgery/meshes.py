"""Triangle meshes as numpy arrays: PLY as hapticctl writes it, and a small skull by formula."""
import math
import pathlib

import numpy as np

FACE = np.dtype([("corners", "u1"), ("vertex", "<u4", 3)])
Mesh = tuple[np.ndarray, np.ndarray]  # vertices n x 3 [mm], triangles m x 3


class Unusable(Exception):
    """A mesh or a place of which no fragment can be cut: what is wrong, and the remedy."""


def read_ply(path: pathlib.Path) -> Mesh:
    """Binary, floats x, y, z, triangles. Unusable if it is none."""
    data = path.read_bytes()
    try:
        end = data.index(b"end_header\n") + len(b"end_header\n")
        count = {words[1]: int(words[2]) for words in (line.split() for line in data[:end].decode("ascii").splitlines())
                 if words[0] == "element"}
        vertices = np.frombuffer(data, "<f4", 3 * count["vertex"], end).reshape(-1, 3)
        faces = np.frombuffer(data, FACE, count["face"], end + vertices.nbytes)
        if not (faces["corners"] == 3).all() or not len(faces) or faces["vertex"].max() >= len(vertices):
            raise ValueError("its faces are no triangles of its vertices")
    except (ValueError, KeyError, IndexError) as error:
        raise Unusable(f"{path}: {error} (a binary PLY as hapticctl import --output writes it)") from error
    return vertices.astype(float), faces["vertex"].astype(np.int64)


def write_ply(path: pathlib.Path, mesh: Mesh) -> None:
    vertices, triangles = mesh
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {len(triangles)}\nproperty list uchar uint vertex_indices\nend_header\n")
    faces = np.empty(len(triangles), FACE)
    faces["corners"], faces["vertex"] = 3, triangles
    path.write_bytes(head.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())


def _bowl(radii: np.ndarray, thinner: float, rings: int, around: int) -> Mesh:
    """An ellipsoid with relief, so many mm inside of the outermost."""
    polar = np.linspace(0, math.pi, rings + 1)[1:-1, None]
    turn = np.linspace(0, 2 * math.pi, around, endpoint=False)[None, :]
    way = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar) + 0 * turn], -1).reshape(-1, 3)
    way = np.vstack([[0, 0, 1], way, [0, 0, -1]])
    relief = 1 + 0.02 * np.sin(5 * way[:, 0] + 1) * np.sin(4 * way[:, 1]) + 0.015 * np.sin(7 * way[:, 2] + 3 * way[:, 0])
    vertices = way * ((radii - thinner) * relief[:, None])
    at = lambda ring, i: 1 + ring * around + i % around  # noqa: E731
    i = np.arange(around)
    faces = [np.stack([0 * i, at(0, i), at(0, i + 1)], 1)]
    for ring in range(rings - 2):
        a, b, c, d = at(ring, i), at(ring + 1, i), at(ring + 1, i + 1), at(ring, i + 1)
        faces += [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    faces.append(np.stack([at(rings - 2, i), 0 * i + len(vertices) - 1, at(rings - 2, i + 1)], 1))
    return vertices, np.vstack(faces)


def small_skull() -> tuple[Mesh, np.ndarray, np.ndarray]:
    """A hollow ellipsoid with relief, 5 mm thick; a place 9 mm above its vault, and the way out there."""
    radii = np.array([34.0, 29.0, 26.0])
    outer, inner = _bowl(radii, 0, 60, 100), _bowl(radii, 5, 60, 100)
    whole = np.vstack([outer[0], inner[0]]), np.vstack([outer[1], inner[1][:, ::-1] + len(outer[0])])
    return whole, np.array([0, 0, outer[0][0, 2] + 9]), np.array([0.0, 0.0, 1.0])


def vault_of(mesh: Mesh, toward: np.ndarray, above: float) -> tuple[np.ndarray, np.ndarray]:
    """Where a ray from the middle of the box last leaves the mesh: a place so far above it, and the mean way out there.

    Unusable if the ray meets nothing, or no outer face.
    """
    vertices, triangles = mesh
    corner = vertices[triangles]
    middle = (vertices.min(0) + vertices.max(0)) / 2
    there = " ".join(f"{x:g}" for x in toward)
    if not 0 < np.linalg.norm(toward) < np.inf:
        raise Unusable(f"--toward {there}: no direction (three numbers, as 0 0 1 for up)")
    way = toward / np.linalg.norm(toward)
    ab, ac = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    across = np.cross(way, ac)  # Moeller and Trumbore
    det = (ab * across).sum(1)
    det[np.abs(det) < 1e-12] = np.inf
    from_a = middle - corner[:, 0]
    u = (from_a * across).sum(1) / det
    beside = np.cross(from_a, ab)
    v, t = beside @ way / det, (ac * beside).sum(1) / det
    ahead = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    if not ahead.any():
        at = ", ".join(f"{x:.0f}" for x in middle)
        raise Unusable(f"--toward {there}: nothing of the skull lies there, seen from the middle of its box at {at} mm "
                       "(choose a way that meets its vault)")
    last = np.where(ahead, t, 0).argmax()
    hit = middle + t[last] * way
    near = np.linalg.norm(corner.mean(1) - hit, axis=1) < 12
    near[last] = True  # However large.
    out = np.cross(ab, ac)[near]
    out = out[out @ way > 0].sum(0)  # The outer face alone.
    if not out.any():
        raise Unusable(f"--toward {there}: the skull's triangles there face inwards (turn the order of their corners round)")
    out /= np.linalg.norm(out)
    return hit + above * out, out
