#!/usr/bin/python3
"""Draws what haptic-bench zwidth --csv found: stiffness over damping, a panel for each rate and delay.

    plot.py ZWIDTH.csv --output PICTURE.png
"""
import argparse
import csv
import sys

INK, FAINT = "#26303a", "#8a949e"
# Column of the CSV, label, line.
THEORY = [("eigenvalue", "eigenvalue limit", {"color": INK, "lw": 1.2}),
          ("slowest", "the same, estimator at its slowest", {"color": INK, "lw": 1, "ls": ":"}),
          ("colgate_delayed", "Colgate and Schenkel", {"color": "#00798c", "lw": 1.2, "marker": "x"}),
          ("friction_limit", "friction against steps", {"color": FAINT, "lw": 1, "ls": "--"})]
COLUMNS = {name for name, *_ in THEORY} | {"rate_hz", "delay_ticks", "step_m", "friction_n", "damping", "off", "on"}


def is_number(field):
    try:
        float(field)
    except ValueError:
        return False
    return True


def load(path):
    """The rows of its table of walls."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            lines = [line for line in file if not line.startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"plot.py: {path}: it cannot be read: {error}")
    header, rows, tables = [], [], 0
    try:
        for fields in filter(None, csv.reader(lines)):
            if not any(map(is_number, fields)):  # Of another table, as compare and report have it.
                header = fields
                tables += COLUMNS <= set(header)
            elif COLUMNS <= set(header):
                rows.append(dict(zip(header, map(float, fields), strict=True)))
    except (ValueError, csv.Error):
        rows = []
    if not rows:
        sys.exit(f"plot.py: {path}: holds nothing that haptic-bench zwidth --csv has written")
    if tables > 1:  # Of another device, perhaps: drawn together each would hide the other.
        sys.exit(f"plot.py: {path}: holds {tables} tables of walls: draw each alone, or haptic-bench report --with all")
    return rows


def numbers(rows):
    """The same of rows that were read as text."""
    return [{name: float(value) for name, value in row.items()} for row in rows]


def curve(rows, name):
    points = sorted((row["damping"], row[name]) for row in rows if 0 < row[name] < float("inf"))
    return [x for x, _ in points], [y for _, y in points]


def panel(axes, rows):
    ideal = [row for row in rows if (row["step_m"], row["friction_n"]) == (1e-9, 0)]
    device = [row for row in rows if row not in ideal] or ideal  # Whose own encoder may be ideal too.
    most = max(row["friction_n"] for row in device)
    device = [row for row in device if row["friction_n"] == most]
    for name, label, style in THEORY:
        axes.plot(*curve(device, name), label=label, **style)
    axes.plot(*curve(ideal, "off"), "o", mfc="none", color=INK, ms=4.5, label="found, ideal encoder, no friction")
    axes.plot(*curve(device, "off"), "o", color="#d1495b", ms=4.5, label="found, the device as it is")
    axes.plot(*curve(device, "on"), "^", color="#edae49", ms=5, label="the same with the passivity controller")
    axes.set_xscale("symlog", linthresh=1)
    axes.set_yscale("log")
    axes.grid(True, color="#e4e8ec", lw=0.7)
    axes.set_title(f"{rows[0]['rate_hz']:g} Hz, delay {rows[0]['delay_ticks']:g} ticks", fontsize=9.5, loc="left")


def draw(rows):
    """The figure; matplotlib's backend is the caller's choice."""
    import matplotlib.pyplot as plt

    rates = sorted({row["rate_hz"] for row in rows})
    delays = sorted({row["delay_ticks"] for row in rows})
    figure, grid = plt.subplots(len(rates), len(delays), figsize=(3.4 * len(delays) + 1, 2.9 * len(rates) + 0.8), squeeze=False,
                                sharex=True, sharey="row")
    for i, rate in enumerate(rates):
        for j, delay in enumerate(delays):
            walls = [row for row in rows if row["rate_hz"] == rate and row["delay_ticks"] == delay]
            if walls:  # Else the sweep was ended before it came here.
                panel(grid[i][j], walls)
        grid[i][0].set_ylabel("stiffness K [N/m]")
    for axes in grid[-1]:
        axes.set_xlabel("damping of the wall B [N s/m]")
    handles, labels = next(lines for axes in grid.flat if any(lines := axes.get_legend_handles_labels()))
    figure.legend(handles, labels, loc="lower center", ncol=4 if len(delays) > 1 else 1, frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.5 / figure.get_figheight() if len(delays) > 1 else 1.5 / figure.get_figheight(), 1, 1))
    return figure


def main():
    parser = argparse.ArgumentParser(description="Draws what haptic-bench zwidth --csv found.")
    parser.add_argument("csv")
    parser.add_argument("--output", required=True)
    options = parser.parse_args()
    rows = load(options.csv)

    import matplotlib

    matplotlib.use("Agg")
    figure = draw(rows)
    try:
        figure.savefig(options.output, dpi=110)
    except (OSError, ValueError) as error:
        sys.exit(f"plot.py: {options.output}: it cannot be written: {error}")


if __name__ == "__main__":
    main()
