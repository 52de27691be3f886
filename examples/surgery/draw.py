"""The picture of a run: the fragment before and after, and how misalignment and force went."""
import pathlib
import sys

import numpy as np
from hand import MM, quaternion

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/picture"))
import mesh  # noqa: E402
import picture  # noqa: E402
import render  # noqa: E402

BONE, PIECE = (0.80, 0.76, 0.68), (0.80, 0.42, 0.30)


def turned(q, points):
    """Points turned by a quaternion w, x, y, z."""
    w, v = q[0], np.asarray(q[1:])
    across = 2 * np.cross(v, points)
    return points + w * across + np.cross(v, across)


def view(axes, camera, body, fragment):
    """Both meshes (corners, normals) in their colours."""
    layers = [render.rasterise(camera, *part) for part in (body, fragment)]
    nearer = layers[1][0] > layers[0][0]
    depth = np.where(nearer, layers[1][0], layers[0][0])
    normal = np.where(nearer[..., None], layers[1][1], layers[0][1])
    colour = np.where(nearer[..., None], PIECE, BONE)
    axes.imshow(render.halve(render.shade(depth, normal, colour)), interpolation="antialiased")
    axes.set_axis_off()


def posed(part, pose):
    corners, normals = part
    return turned(pose[1], corners) + pose[0], turned(pose[1], normals)


def draw(output, parts, hand, rows, end, title):
    """`parts`: vertices [mm] and triangles by name, at home; `end`: where the fragment came to rest, mm and quaternion."""
    picture.style()
    import matplotlib.pyplot as plt

    shapes = {}
    for name, (vertices, triangles) in parts.items():
        corners = vertices[triangles]
        shapes[name] = corners, mesh.smooth_normals(corners)
    start = hand.start / MM, quaternion(hand.start_turn)
    before, after = posed(shapes["fragment"], start), posed(shapes["fragment"], end)
    figure = plt.figure(figsize=(16, 9))
    eye = [0.75, -0.55, 0.62]
    about = shapes["fragment"][0].reshape(-1, 3)
    close = np.vstack([about * 1.35, before[0].reshape(-1, 3)])
    everything = np.vstack([shapes["body"][0].reshape(-1, 3), before[0].reshape(-1, 3)])
    for box, what, points, fragment in (((0.0, 0.36, 0.36, 0.55), "Before", everything, before),
                                        ((0.34, 0.36, 0.33, 0.55), "Before, near", close, before),
                                        ((0.67, 0.36, 0.33, 0.55), "After", close, after)):
        axes = figure.add_axes(box)
        camera = render.Camera(eye, points, 1000, 960)
        view(axes, camera, shapes["body"], fragment)
        axes.set_title(what)
    t = np.array([row[0] for row in rows])
    place = np.stack([row[1] for row in rows])
    for box, name, values, unit in (
            ((0.05, 0.07, 0.26, 0.21), "Off home", np.linalg.norm(place, axis=1), "mm"),
            ((0.38, 0.07, 0.26, 0.21), "Turned", np.array([row[2] for row in rows]), "degrees"),
            ((0.71, 0.07, 0.26, 0.21), "Force on the hand", np.array([row[3] for row in rows]), "N")):
        axes = figure.add_axes(box)
        axes.plot(t, values, color="#00798c" if unit != "N" else "#d1495b", linewidth=1.3)
        axes.set(title=name, xlabel="time [s]", ylabel=unit, xlim=(0, t[-1]))
        axes.set_ylim(0, 1.12 * axes.get_ylim()[1])  # Room for the words.
        for at, what in ((hand.approach_s, "press"), (hand.approach_s + hand.press_s, "ease"), (hand.seconds - hand.rest_s, "rest")):
            axes.axvline(at, color="#8a949e", linewidth=0.8)
            axes.annotate(what, (at, 1), (3, -3), xycoords=("data", "axes fraction"), textcoords="offset points", va="top", fontsize=8.5)
    figure.text(0.025, 0.95, title, fontsize=15, fontweight="bold")
    figure.savefig(output, dpi=100)
    from PIL import Image

    Image.open(output).convert("RGB").quantize(128, kmeans=1).save(output, optimize=True)
