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


def main():
    command = [sys.argv[1], "run", "-a", "daemon", "-m", "plane:cells=3", "-t", "lissajous:seconds=0.5", "--rounds", "1", "--csv"]
    rows = [line.split(",") for line in subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()]
    (mse,) = (float(row[-1]) for row in rows if row[0][:1] != "#" and row[-4] == "daemon force MSE")
    if not mse < 1e-12:
        sys.exit(f"the daemon's force is off: mean square {mse} N^2")
    stand_still()


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
