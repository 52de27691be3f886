#!/usr/bin/python3
"""05: events and history in Python. Taps a plate of the scene, hears the touch, and looks at every servo sample since.

WARNING: the device moves. Keep the workspace free and hold the handle.
"""
import sys
import time

import hapticclient as haptic
import numpy as np


def main() -> int:
    with haptic.Client(name="05-python") as client, client.open_session() as session, \
         client.subscribe(haptic.EventKind.TOUCH, haptic.EventKind.UNTOUCH) as events:
        client.scene.create("plate", haptic.ShapeKind.BOX, (0.05, 0.05, 0.005), pose=haptic.Pose((0, 0, -0.025)),
                            material=haptic.Material(1000, 2, 0.3, 0.2))
        session.arm()
        while session.latest()["flags"] & haptic.SampleFlag.RAMPING:
            time.sleep(0.01)
        session.drain()  # forget what came before
        lost_before = session.lost

        heard, samples = [], []
        end = time.monotonic() + 10
        while len(heard) < 4 and time.monotonic() < end:  # two taps
            down = time.monotonic() % 0.5 < 0.25
            session.push_intent((0, 0, -0.03 if down else 0.01), latest=True)  # of a simulated hand
            samples.append(session.drain())  # 1024 samples are kept: come at least once a second
            if (event := events.next(timeout_s=0.02)) is not None:
                heard.append(event.name)
                print(f"tick {event.tick}: {event.name} {event.object}, {event.force:.2f} N")

        history = np.concatenate(samples)
        history = history[history["device"] == session.describe().device_index]  # others of its group are there too
        force = np.linalg.norm(history["by_source"][:, haptic.Source.SURFACE], axis=1)
        touching = history["flags"] & haptic.SampleFlag.CONTACT != 0
        period = np.median(np.diff(history["t_ns"])) / 1e6
        print(f"{len(history)} samples, {session.lost - lost_before} lost, period {period:.3f} ms")
        print(f"in contact {100 * touching.mean():.0f} % of the time, at most {force.max():.2f} N before the limits, "
              f"{1000 * history['depth_m'].max():.2f} mm deep")
        if len(heard) == 4 and force.max() > 0.5:
            return 0
        print("The plate was not tapped twice. A simulated hand with a motion= of its own does not come; or something else stands "
              "in the way.", file=sys.stderr)
        return 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except haptic.HapticError as error:
        sys.exit(str(error))
