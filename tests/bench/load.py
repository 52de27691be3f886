#!/usr/bin/python3
"""haptic-bench load with a daemon and clients of its own: every cell is there and felt, the figure is drawn, and bad
input is named. Counts and structure, never times. Usage: load.py HAPTIC_BENCH HAPTICD SOURCE_DIRECTORY"""
import csv
import os
import pathlib
import resource
import subprocess
import sys
import tempfile


def interrupt(run):
    """It is told to end in the middle: what it started ends, what it measured is printed, nothing is left."""
    with tempfile.TemporaryDirectory() as folder:
        bench = subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "TMPDIR": folder})
        bench.stderr.readline()  # A cell is done.
        bench.terminate()
        out, words = bench.communicate()
        if bench.returncode != 1 or "interrupted" not in words or "native: period mean" not in out:
            sys.exit(f"interrupted it ended with {bench.returncode}: {words}{out}")
        if list(pathlib.Path(folder).iterdir()):
            sys.exit(f"interrupted it left {list(pathlib.Path(folder).iterdir())}")


def main():
    program, daemon, source = sys.argv[1:]
    run = [program, "load", "--csv", "--rounds", "1", "--seconds", "0.8", "--triangles", "3000", "--rates", "100", "--levels",
           "idle", "clients"]
    with tempfile.TemporaryDirectory() as folder:
        results, figure = pathlib.Path(folder) / "load.csv", pathlib.Path(folder) / "load.svg"
        results.write_bytes(subprocess.run([*run, "--daemon", daemon], check=True, capture_output=True).stdout)
        text = [line for line in results.read_text(encoding="ascii").splitlines() if not line.startswith("#")]
        rows = {row["quantity"]: float(row["value"]) for row in csv.DictReader(text)}
        for level in ("idle", "clients"):
            for client in ("native", "plane 100 Hz", "patch 100 Hz", "force 100 Hz"):
                cell = f"3024 triangles, {level}, {client}: "
                for quantity in ("period mean", "period p99", "period max", "missed periods", "force error rms", "mean force"):
                    if cell + quantity not in rows:
                        sys.exit(f"no {cell + quantity} in\n" + "\n".join(rows))
                if not rows[cell + "mean force"] > 0.05:
                    sys.exit(f"{cell}nothing was touched")
                if client != "native" and not rows[cell + "client period mean"] > 0:
                    sys.exit(f"{cell}the client did nothing")
        if not rows["3024 triangles, idle, native: force error rms"] < 1:
            sys.exit("the native scene is not itself")
        drawing = source + "/tools/haptic-bench/load/figure.py"
        subprocess.run(["/usr/bin/python3", drawing, results, figure], check=True)
        if b"<svg" not in figure.read_bytes():
            sys.exit("no figure")
    interrupt([program, "load", "--csv", "--rounds", "10000", "--seconds", "0.8", "--triangles", "3000", "--daemon", daemon])
    homeless = subprocess.run(run, env={**os.environ, "TMPDIR": f"{folder}/gone"}, capture_output=True, text=True, check=False)
    if homeless.returncode != 1 or "TMPDIR" not in homeless.stderr:
        sys.exit("a temporary folder that is not there was not named: " + homeless.stderr)
    # The disk's program cannot write its first 4 MB: that is no measurement of a busy disk.
    small = subprocess.run([program, "load", "--rounds", "1", "--seconds", "0.8", "--triangles", "1000", "--levels", "disk", "--daemon",
                            daemon], capture_output=True, text=True, check=False,
                           preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (3 << 20, 3 << 20)))
    if small.returncode != 1 or "load, disk: a program of it ended" not in small.stderr:
        sys.exit(f"a load that was none was measured, {small.returncode}: {small.stderr}")
    missing = subprocess.run([*run, "--daemon", f"{folder}/gone"], capture_output=True, text=True, check=False)
    if missing.returncode != 1 or f"{folder}/gone" not in missing.stderr:
        sys.exit("a daemon that is not there was not named: " + missing.stderr)


if __name__ == "__main__":
    main()
