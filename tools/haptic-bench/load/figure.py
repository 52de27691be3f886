#!/usr/bin/python3
"""Draws what haptic-bench load --csv wrote: the servo's period and the error of the force, by load, mesh and client.

    figure.py RESULTS.csv FIGURE.svg
"""
import csv
import re
import statistics
import sys

NAME = re.compile(r"(\d+) triangles, (\w+), (\w+)(?: (\S+) Hz)?: (.+)")
# Quantity, label of its axis, scale.
ROWS = [("period mean", "servo period, mean [µs]", "linear"), ("period p99", "servo period, p99 [µs]", "linear"),
        ("force error rms", "force error, rms [% of the mean force]", "log")]
COLOURS = {"native": "#26303a", "plane": "#edae49", "patch": "#00798c", "force": "#d1495b"}
MARKERS = "osD^v"  # By rate.


def read(path):
    """{quantity: {(triangles, level, source, rate): median over the rounds}}; the machine's lines."""
    machine = []
    try:
        with open(path, encoding="utf-8-sig") as file:
            lines = [line for line in file if not (line.startswith("#") and machine.append(line[2:].strip()) is None)]
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"figure.py: {path}: it cannot be read: {error}")
    return gather(path, csv.DictReader(lines)), machine


def gather(path, rows):
    """The first of read(), of these rows."""
    values = {}
    for number, row in enumerate(rows, 1):
        match = NAME.fullmatch(row.get("quantity") or "")
        try:
            value = float(row.get("value") or "")
        except ValueError:
            match = None
        if row.get("benchmark") != "load" or not match:
            sys.exit(f"figure.py: {path}: row {number} is not of haptic-bench load --csv")
        triangles, level, source, rate, quantity = match.groups()
        key = (int(triangles), level, source, float(rate or 0))
        values.setdefault(quantity, {}).setdefault(key, []).append(value)
    if lacks := [quantity for quantity, *_ in ROWS if quantity not in values]:
        sys.exit(f"figure.py: {path}: holds no {lacks[0]} of haptic-bench load --csv")
    return {q: {key: statistics.median(v) for key, v in cells.items()} for q, cells in values.items()}


def ordered(keys):
    return list(dict.fromkeys(keys))


def draw(values):
    """The figure; matplotlib's backend is the caller's choice."""
    import matplotlib.pyplot as plt

    cells = values["period mean"]
    meshes, levels = ordered(k[0] for k in cells), ordered(k[1] for k in cells)
    clients = ordered(k[2:] for k in cells)
    figure, axes = plt.subplots(3, len(meshes), figsize=(5 * len(meshes) + 1, 10), sharex=True, sharey="row", squeeze=False)
    for column, mesh in enumerate(meshes):
        for row, (quantity, label, scale) in enumerate(ROWS):
            axis = axes[row][column]
            for source, rate in clients:
                y = [values[quantity].get((mesh, level, source, rate)) for level in levels]
                nth = [r for s, r in clients if s == source].index(rate)
                axis.plot(levels, [max(v, 1e-4) if v is not None else None for v in y], marker=MARKERS[nth % len(MARKERS)],
                          markersize=4.5, color=COLOURS[source], linewidth=0.8 + 0.4 * nth, label=f"{source} {rate:g} Hz" if rate else source)
            axis.set_yscale(scale)
            axis.grid(True, color="#e4e8ec")
            if row == 0:
                axis.set_title(f"{mesh} triangles")
            if column == 0:
                axis.set_ylabel(label)
    axes[0][-1].legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=8)
    figure.suptitle("Load: what the servo's period and the force come to", x=0.02, ha="left", weight="bold")
    return figure


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    values, machine = read(sys.argv[1])
    import matplotlib

    matplotlib.use("Agg")
    figure = draw(values)
    figure.text(0.02, 0.005, "; ".join(machine), fontsize=6)
    try:
        figure.savefig(sys.argv[2], bbox_inches="tight")
    except (OSError, ValueError) as error:
        sys.exit(f"figure.py: {sys.argv[2]}: it cannot be written: {error}")


if __name__ == "__main__":
    main()
