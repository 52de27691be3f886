#!/usr/bin/python3
"""haptic-bench device: what no machine's pace changes. In virtual time each delay follows from two rates of 1 kHz whose
phase goes evenly round: at most a period, half of it in the middle. With threads and processes there is no time to
assert, but an order: no answer to a command can be seen before the next tick. Usage: device.py HAPTIC_BENCH"""
import csv
import subprocess
import sys

PERIOD_US, GRAIN_US = 1000, 62.5
READINGS_HZ = {"falcon": 1000, "woodyhid": 1000, "hidpid": 1000, "pantograph": 1000, "spacemouse": 250, "sample": 1000, "dhd": 1000}
ANSWER = {"falcon": "threads", "woodyhid": "threads", "pantograph": "threads", "sample": "threads", "dhd": "process", "openhaptics": "process"}


def main():
    program = sys.argv[1]
    run = [program, "device", "--csv", "--rounds", "1", "--seconds", "0.3"]
    done = subprocess.run(run, check=True, capture_output=True, text=True).stdout
    text = [line for line in done.splitlines() if not line.startswith("#")]
    rows = {row["quantity"]: float(row["value"]) for row in csv.DictReader(text)}

    def expect(name, least, most):
        if name not in rows:
            sys.exit(f"no '{name}' in\n{done}")
        if not least <= rows[name] <= most:
            sys.exit(f"{name}: {rows[name]}, not within {least} and {most}")

    for device, hertz in READINGS_HZ.items():
        expect(f"{device}: readings", hertz, hertz)
        expect(f"{device}: wrong or late on the wire", 0, 0)
        delays = ["age of a reading"] + (["command to motors"] if device != "spacemouse" else [])
        for delay in delays:
            expect(f"{device}: {delay}, worst", PERIOD_US - GRAIN_US, PERIOD_US)
            expect(f"{device}: {delay}, median", PERIOD_US / 2 - GRAIN_US, PERIOD_US / 2)
        expect(f"{device}: driver", 1e-3, PERIOD_US)
    if "spacemouse: command to motors, worst" in rows:
        sys.exit("a SpaceMouse has no motors")
    for device, by in ANSWER.items():
        # A servo that wakes late, then in time, sees its ticks nearer to each other than a period.
        expect(f"{device}: {by}, round trip max", PERIOD_US / 4, float("inf"))
        expect(f"{device}: {by}, age p50", 0, float("inf"))
    for device in ("dhd", "openhaptics"):
        expect(f"{device}: hapticd-vendor", 0.1, PERIOD_US)
        expect(f"{device}: servo, read and write", 1e-3, PERIOD_US)
    # At once, not after the ten thousand rounds of the others.
    missing = subprocess.run([program, "device", "--rounds", "10000", "--sdk", "/nowhere/libdhd.so.3"], capture_output=True,
                             text=True, check=False)
    if missing.returncode != 1 or "/nowhere/libdhd.so.3" not in missing.stderr:
        sys.exit(f"a library that is not there: {missing.returncode}, {missing.stderr}")


if __name__ == "__main__":
    main()
