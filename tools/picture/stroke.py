#!/usr/bin/python3
"""Plans how a hand strokes a mesh from above: a path for hapticctl hand.

A round trip over the mesh; the fingertip is meant to go a little below the surface, so that it presses, and lifts in
time for what stands in its way. Writes CSV t,x,y,z in metres to standard output.

    stroke.py MESH.stl --scale METRES --at X,Y,Z --seconds N
"""
import argparse
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import mesh  # noqa: E402
import render  # noqa: E402

CELL = 0.0005   # Of the height map [m].
AHEAD = 0.007   # So far ahead the hand heeds what it comes to [m].
STEP = 0.003    # What rises more within that is a wall to lift over [m].
LAND = 0.003    # Beyond it the hand comes down no sooner: one that lags would dive before it [m].
SPEED = 0.06    # Of an exploring fingertip [m/s].
WIDEST = 2.0    # No hand reaches farther, and the height map of a mesh in another unit fills the memory [m].


class FromAbove(render.Camera):
    """One pixel per cell, depth is the height in metres."""

    def __init__(self, corners):
        self.lower = corners.reshape(-1, 3).min(0)
        upper = corners.reshape(-1, 3).max(0)
        self.width, self.height = (np.ceil((upper - self.lower)[:2] / CELL).astype(int) + 1).tolist()
        self.axes = np.eye(3)

    def project(self, points):
        out = points - self.lower
        out[..., :2] /= CELL
        out[..., 2] += self.lower[2]
        return out


def widest(heights, cells):
    """Highest within so many cells: where a fingertip of that size would rest."""
    for axis in (0, 1):
        padded = np.pad(heights, [(cells, cells) if a == axis else (0, 0) for a in (0, 1)], constant_values=-np.inf)
        heights = np.max([np.take(padded, np.arange(s, s + heights.shape[axis]), axis) for s in range(2 * cells + 1)], axis=0)
    return heights


def eroded(solid, cells):
    """True where everything within so many cells is solid."""
    return ~(widest(np.where(solid, -np.inf, 1.0), cells) > 0)


def tour(solid, way, steps):
    """A smooth path over the solid cells, a round trip where that length allows it, at constant speed: steps x (x, y) [m]."""
    for margin in (0.006, 0.003, 0.001, 0):
        inner = np.argwhere(eroded(solid, int(margin / CELL)))[:, ::-1]
        if len(inner) > 50:
            break
    if len(inner) == 0:
        raise mesh.MeshError("nowhere is it level and wide enough to be stroked (a larger --scale)")
    inner = inner[:: max(len(inner) // 4000, 1)] * CELL
    chosen = [inner[len(inner) // 2]]
    distance = np.full(len(inner), np.inf)
    line = None
    while len(chosen) < 60:  # The farthest point from all chosen, until the path through them is long enough.
        distance = np.minimum(distance, np.linalg.norm(inner - chosen[-1], axis=1))
        chosen.append(inner[distance.argmax()])
        if len(chosen) >= 4:
            line = spline(shortened(np.array(chosen)))
            length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
            if length[-1] > way:
                break
    even = np.linspace(0, min(length[-1], way), steps, endpoint=False)  # No faster than a hand explores.
    return np.stack([np.interp(even, length, line[:, axis]) for axis in (0, 1)], 1)


def shortened(points):
    """A short round trip: 2-opt, turning a stretch round wherever that saves way."""
    order, n = list(range(len(points))), len(points)
    gap = lambda a, b: np.linalg.norm(points[order[a % n]] - points[order[b % n]])
    better = True
    while better:
        better = False
        for i in range(n - 1):
            for j in range(i + 2, n):
                if gap(i, j) + gap(i + 1, j + 1) < gap(i, i + 1) + gap(j, j + 1) - 1e-9:
                    order[i + 1:j + 1] = order[i + 1:j + 1][::-1]
                    better = True
    return points[order]


def spline(points, steps=60):
    """Catmull-Rom through the points and back to the first."""
    a, b, c, d = (np.roll(points, shift, axis=0)[:, None] for shift in (1, 0, -1, -2))
    s = np.linspace(0, 1, steps, endpoint=False)[None, :, None]
    line = b + s / 2 * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)))
    line = line.reshape(-1, 2)
    return np.vstack([line, line[:1]])


def plan(corners, start, seconds, press, rate=200):
    """Rows t, x, y, z: from `start` down to the surface, strokes for `seconds`, and back up."""
    width = np.ptp(corners.reshape(-1, 3), axis=0)[:2].max()
    if not width <= WIDEST:
        raise mesh.MeshError(f"it is {width:.4g} m wide (at most {WIDEST:g} m: another --scale)")
    camera = FromAbove(corners)
    heights, _ = render.rasterise(camera, corners, np.zeros_like(corners) + [0, 0, 1.0])
    solid = np.isfinite(heights)
    near = render.blur(solid.astype(float), 0.008 / CELL)
    around = render.blur(np.where(solid, heights, 0.0), 0.008 / CELL) / np.maximum(near, 1e-3)
    base = np.where(solid, heights, np.where(near > 1e-3, around, heights[solid].mean()))
    # Where a wall is near, or the mesh ends, the hand lifts over it: pressed against a wall it would stay there.
    highest = widest(base, int(AHEAD / CELL))
    steep = (highest - base > STEP) | ~eroded(solid, int(0.002 / CELL))
    steep = widest(steep.astype(float), int(LAND / CELL)) > 0
    height = np.where(steep, highest + 0.002, base - press)

    xy = tour(solid & ~steep, seconds * SPEED, max(int(seconds * rate), 1))
    cell = np.clip((xy / CELL).astype(int), 0, [camera.width - 1, camera.height - 1])
    stroke = np.column_stack([xy + camera.lower[:2], height[cell[:, 1], cell[:, 0]]])
    stroke[:, 2] = render.blur(np.repeat(stroke[:, 2:], 3, axis=1), 0.02 * rate)[:, 1]  # Wrists move smoothly.

    ease = lambda s: (10 * s ** 3 - 15 * s ** 4 + 6 * s ** 5)[:, None]  # Minimum jerk.
    move = ease(np.linspace(0, 1, int(0.8 * rate), endpoint=False))
    above = stroke[0] + [0, 0, 0.02]
    approach = np.vstack([np.asarray(start) + move * (above - start), above + move * (stroke[0] - above)])
    leave = stroke[-1] + ease(np.linspace(0, 1, int(0.6 * rate))) * [0, 0, 0.02 + press]
    path = np.vstack([approach, stroke, leave])
    return np.column_stack([np.arange(len(path)) / rate, path])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh")
    parser.add_argument("--scale", type=float, required=True, help="metres per file unit")
    parser.add_argument("--at", default="0,0,0", help="where the middle of its box stands [m]")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--press", type=float, default=0.008, help="how far below the surface the hand means to go [m]")
    arguments = parser.parse_args()
    try:
        corners = mesh.load_stl(arguments.mesh)
    except (OSError, mesh.MeshError) as error:
        sys.exit(f"stroke: {error}")
    flat = corners.reshape(-1, 3)
    corners = (corners - (flat.min(0) + flat.max(0)) / 2) * arguments.scale + [float(v) for v in arguments.at.split(",")]
    try:
        rows = plan(corners, np.zeros(3), arguments.seconds, arguments.press)
    except mesh.MeshError as error:
        sys.exit(f"stroke: {arguments.mesh}: {error}")
    print("t,x,y,z")
    for row in rows:
        print(",".join(f"{value:.6f}" for value in row))


if __name__ == "__main__":
    main()
