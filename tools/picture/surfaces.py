#!/usr/bin/python3
"""Draws docs/pictures/surfaces.png: what is asked of the hand by a relief, an impact and a vibration.

Usage: surfaces.py FILE.png, with a daemon that simulates a device (build/tests/with_daemon starts one).
"""
import math
import sys
import time

import hapticclient as haptic
import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  pylint: disable=wrong-import-position

BLUE, RED, FAINT = "#00798c", "#d1495b", "#8a949e"


def felt(scene, session, surface, hand, seconds):
    """Samples of a hand that follows hand(t) over a plane with that surface."""
    scene.set_surface("wall", surface)
    begin, samples = time.monotonic(), []
    while (t := time.monotonic() - begin) < seconds:
        session.push_intent(hand(t), latest=True)
        samples.append(session.drain())
        time.sleep(0.002)
    return np.concatenate(samples)


def main(path):
    with haptic.Client(name="picture") as client, client.open_session() as session:
        scene = client.scene
        scene.create("wall", haptic.ShapeKind.PLANE, pose=haptic.Pose((0, 0, -0.02)), material=haptic.Material(800, 2))
        session.arm()
        while session.latest()["flags"] & haptic.SampleFlag.RAMPING:
            time.sleep(0.01)
        x = np.linspace(0, 1, 128)
        grooves = scene.upload_relief(np.tile(0.5 + 0.5 * np.cos(2 * math.pi * 8 * x), (2, 1)))
        models = [haptic.VibrationModel(v, f, 0.02 * (1 + 40 * v), (-1.2, 0.72))
                  for v, f in ((0.005, 0.1), (0.2, 0.1), (0.005, 3.0))]
        cloth = scene.upload_vibration(2000, models, [[0, 1, 2]])
        press = -0.024
        relief = felt(scene, session, haptic.Surface(relief=grooves.id, relief_depth=0.001, relief_width=0.08),
                      lambda t: (0.03 * math.sin(2 * t), 0, press), 5)
        blow = felt(scene, session, haptic.Surface(transient_gain=20),
                    lambda t: (0, 0, press if t % 1 > 0.5 else 0), 2.5)
        buzz = felt(scene, session, haptic.Surface(vibration=cloth.id, vibration_mass=0.1),
                    lambda t: (0.03 * math.sin(2 * t), 0, press), 4)

    matplotlib.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": FAINT,
        "axes.grid": True, "grid.color": "#e4e8ec", "axes.axisbelow": True, "axes.titlelocation": "left", "axes.titlesize": 10.5,
        "axes.titleweight": "bold", "axes.titlepad": 22, "legend.frameon": False, "legend.fontsize": 8.5, "legend.borderaxespad": 0})
    figure, (a, b, c) = pyplot.subplots(1, 3, figsize=(12, 3.4), constrained_layout=True)
    part = relief[-2000:]
    a.plot(1000 * part["p"][:, 0], part["by_source"][:, 5, 0], color=BLUE, lw=0.9, label="texture, along x")
    a.plot(1000 * part["p"][:, 0], part["by_source"][:, 5, 2], color=RED, lw=0.9, label="texture, normal")
    a.set(title="Relief: grooves of 10 mm, 1 mm deep", xlabel="x [mm]", ylabel="force [N]")
    rings = blow["by_source"][:, 6, 2] != 0
    first = (np.flatnonzero(rings[1:] & ~rings[:-1]) + 1)[0]
    near = blow[first - 20:first + 80]
    ms = (near["t_ns"] - near["t_ns"][0]) / 1e6
    b.plot(ms, near["by_source"][:, 0, 2], color=BLUE, lw=1.2, label="surface")
    b.plot(ms, near["by_source"][:, 6, 2], color=RED, lw=1.2, label="transient")
    b.set(title="Impact: 20 N s/m, 150 Hz, 10 ms", xlabel="time [ms]", ylabel="force [N]")
    part = buzz[-2000:]
    seconds = (part["t_ns"] - part["t_ns"][0]) / 1e9
    c.plot(seconds, part["by_source"][:, 5, 1], color=BLUE, lw=0.5, label="texture, across the motion [N]")
    c.plot(seconds, np.abs(part["v"][:, 0]), color=RED, lw=1.2, label="speed [m/s]")
    c.set(title="Vibration: grows with the speed", xlabel="time [s]")
    for axes in (a, b, c):
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1.015), ncol=2, handlelength=1.2, columnspacing=1.2)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main(sys.argv[1])
