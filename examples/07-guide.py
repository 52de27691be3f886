#!/usr/bin/python3
"""07: a needle's way. A curve draws an unsteady hand to it, tissue drags, and a buzz tells that the target is reached.

WARNING: the device moves. Keep the workspace free and hold the handle.
"""
import math
import sys
import time

import hapticclient as haptic
import numpy as np

WAY = [(0.04 * math.cos(a), 0.04 * math.sin(a), 0) for a in np.linspace(0, math.pi / 2, 6)]  # a quarter of a circle


def own(session, samples):
    """Those of its device: drain() gives others of the group too."""
    return samples[samples["device"] == session.describe().device_index]


def follow(session, seconds):
    """A clumsy hand goes along the way; mean distance from it [m], mean force of effects [N]."""
    begin, samples = time.monotonic(), []
    while (t := time.monotonic() - begin) < seconds:
        a, off = math.pi / 2 * t / seconds, 0.008 * math.sin(7 * t)
        session.push_intent(((0.04 + off) * math.cos(a), (0.04 + off) * math.sin(a), off), latest=True)
        samples.append(session.drain())
        time.sleep(0.005)
    history = own(session, np.concatenate(samples))
    p, force = history["p"], history["by_source"][:, haptic.Source.EFFECT]
    apart = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.04, p[:, 2])
    return apart.mean(), np.linalg.norm(force, axis=1).mean()


def main() -> int:
    with haptic.Client(name="07-guide") as client, client.open_session() as session:
        for name in ("tissue", "way", "done"):  # groups: nothing to touch
            client.scene.create(name)
        client.scene.set_effect("tissue", haptic.EffectKind.VISCOUS, damping=2, reach=0.1)
        session.arm()
        session.push_intent((0.04, 0, 0), latest=True)
        time.sleep(2.5)
        felt = {}
        for kind in (haptic.EffectKind.NONE, haptic.EffectKind.GUIDE):
            client.scene.set_effect("way", kind, path=WAY, stiffness=800, force=4)
            follow(session, 0.5)  # come in
            session.drain()
            felt[kind] = follow(session, 3)
            print(f"{kind.name.lower()}: {1000 * felt[kind][0]:.1f} mm from the way, {felt[kind][1]:.2f} N of effects")
        time.sleep(0.5)  # the hand comes to rest
        session.drain()
        client.scene.set_effect("done", haptic.EffectKind.VIBRATION, reach=1, hz=80, duration_s=0.3)  # ends by itself
        time.sleep(0.6)
        buzz = own(session, session.drain())["by_source"][:, haptic.Source.EFFECT, 2]
        print(f"reached: effects swing by {np.ptp(buzz) / 2:.1f} N")
        if felt[haptic.EffectKind.GUIDE][0] < 0.7 * felt[haptic.EffectKind.NONE][0] and np.ptp(buzz) > 1:
            return 0
        print("The hand was not guided. A simulated one with a motion= of its own does not come; or something else stands in the "
              "way.", file=sys.stderr)
        return 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except haptic.HapticError as error:
        sys.exit(str(error))
