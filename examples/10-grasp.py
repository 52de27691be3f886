#!/usr/bin/python3
"""10: two fingers hold a block beside its middle. Between points it tips over; soft fingers keep it as it is, until they
press less: then it turns between them, and slides a little. The daemon needs two devices in one group: 10-grasp.toml.

WARNING: the devices move. Keep the workspace free and hold the handles.
"""
import math
import sys
import time

import hapticclient as haptic

WIDE, MASS, OFF = 0.03, 0.1, 0.008  # of the block, and how far from its middle it is held [m, kg, m]


def press(fingers, depth, x, z=0.0, seconds=0.5):
    """Index on the right, thumb on the left: hands that want to be so deep in the block."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for finger, side in zip(fingers, (1, -1)):
            finger.push_intent((x, side * (WIDE / 2 - depth), z), latest=True)
        time.sleep(0.01)


def tilt(client):
    """Of the block's long side from level [degrees]."""
    w, x, y, z = client.get("/objects/held/rot")
    return math.degrees(math.asin(max(-1.0, min(1.0, 2 * (w * y - x * z)))))


def finger_words(finger):
    """Sets a finger again that was read."""
    if finger is None:
        return "none"
    numbers = "".join(f",{name}={finger[name]}" for name in ("arm", "radius", "stiffness", "damping", "cue"))
    return finger["law"] + numbers + ("" if finger["coupled"] else ",uncoupled")


def lift(client, fingers, devices, finger):
    """Takes the block up by 20 mm. How far it has tipped then, how far when the fingers have pressed less, how high it is."""
    client.set("/world/gravity?value=0,0,0")
    press(fingers, -0.01, OFF)
    for device in devices:
        client.set(f"/devices/{device}/finger?value={finger}")
    client.scene.create("held", haptic.ShapeKind.BOX, (0.03, WIDE / 2, 0.015),
                        material=haptic.Material(stiffness=1000, damping=1, friction_static=0.8, friction_dynamic=0.7))
    client.set(f"/objects/held/mass?value={MASS}")
    press(fingers, 0.012, OFF, seconds=1)
    client.set("/world/gravity?value=0,0,-9.81")
    for step in range(20):
        press(fingers, 0.012, OFF, 0.001 * step, 0.05)
    press(fingers, 0.012, OFF, 0.02)
    held = tilt(client)
    for depth in (0.009, 0.006, 0.0036, 0.012):
        press(fingers, depth, OFF, 0.02, 0.3)
    loose, up = tilt(client), client.get("/objects/held/pos")[2]
    client.scene.remove("held")
    return held, loose, up


def main() -> int:
    with haptic.Client(name="10-grasp") as client:
        devices = client.status().devices
        if len(devices) < 2 or devices[0].group != devices[1].group:
            sys.exit("two devices in one group are needed: /usr/sbin/hapticd --allow-no-rt --config 10-grasp.toml")
        names = [device.name for device in devices[:2]]
        with client.open_session(devices[0].uri) as index, client.open_session(devices[1].uri) as thumb:
            fingers = (index, thumb)
            press(fingers, -0.01, OFF)
            for finger in fingers:
                finger.arm()
            results = {}
            gravity, worn = client.get("/world/gravity"), [client.get(f"/devices/{name}/finger") for name in names]
            try:
                for finger in ("none", "soft"):
                    results[finger] = held, loose, up = lift(client, fingers, names, finger)
                    print(f"{'points' if finger == 'none' else finger}: tipped by {-held:.0f} degrees, "
                          f"by {-loose:.0f} after less grip, {1000 * up:.0f} mm up")
            finally:  # They are the world's and the devices', not this program's: the next one's bodies would fall.
                client.set("/world/gravity?value=" + ",".join(map(str, gravity)))
                for name, finger in zip(names, worn):
                    client.set(f"/devices/{name}/finger?value={finger_words(finger)}")
            (points, _, _), (soft, turned, _) = results.values()
            return 0 if abs(points) > 30 and abs(soft) < 10 and abs(turned) > abs(soft) + 5 else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except haptic.HapticError as error:
        sys.exit(str(error))
