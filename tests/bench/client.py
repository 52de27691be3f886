#!/usr/bin/python3
"""A program that renders as a client of the daemon is judged by haptic-bench: a plane that is right scores next to nothing, one
that is 0.1 mm too high scores that. Usage, within with_daemon: client.py HAPTIC_BENCH"""
import csv
import subprocess
import sys
import time

import hapticclient as haptic

COMMAND = [sys.argv[1], "run", "-a", "client:wait=5", "-m", "plane", "-t", "lissajous:seconds=3,rate=50", "--rounds", "1", "--csv"]


def await_it(bench):
    for line in bench.stderr:
        if "waits 5 s for a program that arms the device haptic-bench-client" in line:
            return
    sys.exit("it waits for nobody")


def judged(height, disarms=False):
    """Of a program that renders the plane z = height: exit code, {quantity: value} and what is said."""
    bench = subprocess.Popen(COMMAND, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    await_it(bench)
    with haptic.Client() as client, client.open_session("haptic-bench-client", "rendering") as session:
        session.push_plane((0, 0, height), (0, 0, 1), lease_s=10, material=haptic.Material(1000, 0))
        session.arm()
        if disarms:
            time.sleep(2.5)
            session.disarm()
        out, said = bench.communicate(timeout=300)
    rows = csv.DictReader(line for line in out.splitlines() if line[:1] != "#")
    return bench.returncode, {row["quantity"]: float(row["value"]) for row in rows}, said


def main():
    with haptic.Client() as client:
        before = [device.uri for device in client.devices() if device.open]
    code, right, said = judged(0.0)
    if code != 0 or not right["client:wait=5 force MSE"] < 1e-4:
        sys.exit(f"a plane that is right: {code}, {right}, {said}")
    code, high, said = judged(0.0001)
    if code != 0 or not 0.008 < high["client:wait=5 force MSE"] < 0.012:  # 0.1 N
        sys.exit(f"a plane 0.1 mm too high: {code}, {high}, {said}")
    code, _, said = judged(0.0, disarms=True)
    if code != 1 or "its device is not armed any more" not in said or "at sample" not in said:
        sys.exit(f"a program that disarms: {code}, {said}")
    alone = subprocess.run([word.replace("wait=5", "wait=0.1") for word in COMMAND], capture_output=True, text=True, check=False)
    if alone.returncode != 1 or "nobody has armed " not in alone.stderr:
        sys.exit(f"nobody came: {alone}")
    with haptic.Client() as client:
        if (after := [device.uri for device in client.devices() if device.open]) != before:
            sys.exit(f"it left open: {set(after) - set(before)}")


if __name__ == "__main__":
    main()
