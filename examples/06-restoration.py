#!/usr/bin/python3
"""06: virtual restoration. The picture of a cracked painting becomes its relief; the hand strokes over it, the painting is
restored, and the hand strokes again.

WARNING: the device moves. Keep the workspace free and hold the handle.
"""
import dataclasses
import math
import sys
import time

import hapticclient as haptic
import numpy as np

SIDE = 0.06  # of the painting [m]


def painting(cracked: bool) -> np.ndarray:
    """256 x 256 pixels: gentle brush strokes, and cracks two millimetres wide across it."""
    y, x = np.mgrid[0:256, 0:256]
    grey = 0.9 + 0.03 * np.sin(0.15 * x + 2 * np.sin(0.02 * y))
    if cracked:
        for middle in range(16, 256, 32):
            bent = x - middle - 5 * np.sin(0.05 * y)
            grey -= 0.8 * np.exp(-(bent / 4) ** 2)
    return grey.clip(0, 1)


def own(session: haptic.Session, samples: np.ndarray) -> np.ndarray:
    """Those of its device: drain() gives others of the group too."""
    return samples[samples["device"] == session.describe().device_index]


def stroke(session: haptic.Session, seconds: float) -> tuple[float, float]:
    """To and fro over the painting: standard deviation of the relief's force, mean of the whole, as asked for [N]."""
    begin, samples = time.monotonic(), []
    while (t := time.monotonic() - begin) < seconds:
        session.push_intent((0.02 * math.sin(4 * t), 0, -0.003), latest=True)  # of a simulated hand
        samples.append(session.drain())
        time.sleep(0.005)
    history = own(session, np.concatenate(samples))
    history = history[history["flags"] & haptic.SampleFlag.CONTACT != 0]
    force = history["by_source"]
    return force[:, haptic.Source.TEXTURE, 0].std(), np.linalg.norm(force[:, haptic.Source.SURFACE], axis=1).mean()


def main() -> int:
    with haptic.Client(name="06-restoration") as client, client.open_session() as session:
        scene = client.scene
        scene.create("painting", haptic.ShapeKind.BOX, (SIDE / 2, SIDE / 2, 0.005), pose=haptic.Pose((0, 0, -0.005)),
                     material=haptic.Material(800, 2))
        session.arm()
        felt = {}
        for state in ("cracked", "restored"):
            texture = scene.upload_relief(painting(state == "cracked"))
            surface = haptic.Surface(relief=texture.id, relief_depth=0.0008, relief_width=SIDE, relief_height=SIDE)
            scene.set_surface("painting", dataclasses.replace(surface, transient_gain=5))
            stroke(session, 2.5)  # arming, and coming down
            rough, pressed = felt[state] = stroke(session, 1.5)
            print(f"{state}: pressed with {pressed:.2f} N, the relief pushes aside by {1000 * rough:.0f} mN")
        if felt["cracked"][0] > 2 * felt["restored"][0] > 0:
            return 0
        print("The cracks were not felt. A simulated hand with a motion= of its own does not come; or something else stands in the "
              "way.", file=sys.stderr)
        return 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except haptic.HapticError as error:
        sys.exit(str(error))
