#!/usr/bin/python3
"""The running daemon, judged by haptic-bench through the client library, feels what the trajectory says. Usage, within
with_daemon: daemon.py HAPTIC_BENCH"""
import subprocess
import sys


def main():
    command = [sys.argv[1], "run", "-a", "daemon", "-m", "plane:cells=3", "-t", "lissajous:seconds=0.5", "--rounds", "1", "--csv"]
    rows = [line.split(",") for line in subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()]
    (mse,) = (float(row[-1]) for row in rows if row[0][:1] != "#" and row[-4] == "daemon force MSE")
    if not mse < 1e-12:
        sys.exit(f"the daemon's force is off: mean square {mse} N^2")


if __name__ == "__main__":
    main()
