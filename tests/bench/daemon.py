#!/usr/bin/python3
"""The running daemon, judged by haptic-bench through the client library, feels what the trajectory says. Usage, within
with_daemon: daemon.py HAPTIC_BENCH"""
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time

import hapticclient as haptic


def opened():
    with haptic.Client() as client:
        return [device.uri for device in client.devices() if device.open]


def closes_its_device(how, before):
    """What it opened is closed again, however the run has ended: nobody else would do it."""
    if (after := opened()) != before:
        sys.exit(f"{how} it left open: {set(after) - set(before)}")


def interrupt(signal_number, before):
    command = [sys.argv[1], "run", "-a", "daemon", "-m", "plane:cells=3", "-t", "lissajous:seconds=60", "--rounds", "1"]
    bench = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while opened() == before:
        time.sleep(0.01)
    time.sleep(0.3)
    bench.send_signal(signal_number)
    words = bench.communicate()[1]
    if bench.returncode != 1 or "daemon: it was interrupted" not in words:
        sys.exit(f"interrupted it ended with {bench.returncode}: {words}")
    closes_its_device("interrupted", before)


def main():
    before = opened()
    command = [sys.argv[1], "run", "-a", "daemon", "-m", "plane:cells=3", "-t", "lissajous:seconds=0.5", "--rounds", "1", "--csv"]
    rows = [line.split(",") for line in subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()]
    (mse,) = (float(row[-1]) for row in rows if row[0][:1] != "#" and row[-4] == "daemon force MSE")
    if not mse < 1e-12:
        sys.exit(f"the daemon's force is off: mean square {mse} N^2")
    closes_its_device("after a run", before)
    refused = subprocess.run([*command, "--damping", "2"], capture_output=True, text=True, check=False)
    if refused.returncode != 1 or "--damping: " not in refused.stderr:
        sys.exit(f"it does not go at the trajectory's speed, and yet takes --damping: {refused}")
    for signal_number in (signal.SIGINT, signal.SIGTERM):
        interrupt(signal_number, before)
    stand_still()
    closes_its_device("after a failure", before)


def stand_still():
    """A daemon that stops in the middle is an answer with its sample, at once, not after two seconds for each sample."""
    command = [sys.argv[1], "run", "-a", "daemon", "-m", "plane:cells=3", "-t", "lissajous:seconds=60", "--rounds", "1"]
    with socket.socket(socket.AF_UNIX) as control:
        control.connect(os.environ["HAPTICD_SOCKET"])
        (daemon,) = struct.unpack("i8x", control.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))
    bench = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(1.5)
    os.kill(daemon, signal.SIGSTOP)
    time.sleep(3.5)
    os.kill(daemon, signal.SIGCONT)
    words = bench.communicate()[1]
    if bench.returncode != 1 or not re.search("pose for 2 s .*at sample|no answer|cannot be read .*at sample", words):
        sys.exit(f"a daemon that stood still: {bench.returncode}, {words}")


if __name__ == "__main__":
    main()
