#!/usr/bin/python3
"""Draws what haptic-bench grasp --csv found: grip forces, and how blocks turn and slide between two fingers.

    plot.py GRASP.csv --samples SAMPLES.csv --output PICTURE.png
"""
import argparse
import csv
import math
import sys

INK, FAINT, A, B = "#26303a", "#8a949e", "#00798c", "#d1495b"
CUBES = ["mass_kg", "friction", "stiffness", "hold", "slips_n", "fell", "held_n"]
ALIGN = ["condition", "lever_m", "wanted_deg", "mass_kg", "person", "off_deg", "error_deg", "slid_m", "lost"]
SAMPLES = ["condition", "arm_m", "lever_m", "t", "y", "z", "turned_rad", "slid_m", "grip_n"]
TICKS = (0.5, 1, 2, 5)  # [N]
SOFTNESS = ["#edae49", A, INK]  # From the softest to the stiffest.


def fail(path, words):
    sys.exit(f"plot.py: {path}: {words}")


def lines_of(path):
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            return [line for line in file if not line.startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        fail(path, f"it cannot be read: {error}")


def table(path, lines, columns, what):
    """The rows below the header that these columns make: words where the column is one, else numbers."""
    rows, inside = [], False
    for fields in csv.reader(lines):
        if fields == columns or not inside or len(fields) != len(columns):
            inside = fields == columns
            continue
        try:
            rows.append({name: field if name == "condition" else {"true": 1.0, "false": 0.0}.get(field) if name == "lost" and field in
                         ("true", "false") else float(field) for name, field in zip(columns, fields)})
        except ValueError:
            inside = False
    if not rows:
        fail(path, f"holds nothing that haptic-bench grasp {what} has written")
    return rows


def grips(axes, cubes):
    """Figures 2.6 and 2.7: the force with which each cube is held, over that at which it slips."""
    for stiffness, colour in zip(sorted({row["stiffness"] for row in cubes}), SOFTNESS):
        of = [row for row in cubes if row["stiffness"] == stiffness]
        axes.plot([row["slips_n"] for row in of], [row["held_n"] for row in of], "o", mfc="none", ms=4.5, color=colour,
                  label=f"{stiffness:g} N/m")
    ends = [min(row["slips_n"] for row in cubes), max(row["held_n"] for row in cubes)]
    axes.plot(ends, ends, color=FAINT, lw=1, ls="--", label="it slips")
    axes.set(xscale="log", yscale="log", xticks=TICKS, yticks=TICKS, xlabel="it slips at $m g / 2 \\mu_s$ [N]", ylabel="it is held with [N]")
    axes.set_xticklabels(map(str, TICKS))
    axes.set_yticklabels(map(str, TICKS))
    axes.minorticks_off()
    axes.set_title("27 cubes, held for 10 s", fontsize=9.5, loc="left")


def course(axes, samples, lever):
    """Figures 2.20 and 2.23: how it turns and slides as the fingers open."""
    slides = axes.twinx()
    for condition, colour in (("coupled", A), ("uncoupled", B)):
        of = [row for row in samples if row["condition"] == condition and row["lever_m"] == lever]
        t = [row["t"] for row in of]
        axes.plot(t, [-math.degrees(row["turned_rad"]) for row in of], color=colour, lw=1.4, label=f"{condition}: turned")
        slides.plot(t, [1e3 * row["slid_m"] for row in of], color=colour, lw=1.2, ls=":")
        axes.plot([], [], color=colour, lw=1.2, ls=":", label=f"{condition}: slid")
    axes.set(xlabel="time [s]", ylabel="turned [degrees]")
    slides.set_ylabel("slid [mm]")
    arm = next(row["arm_m"] for row in samples if row["lever_m"] == lever)
    axes.set_title(f"let go: L = {1e3 * lever:.1f} mm, $L_0$ = {1e3 * arm:.2f} mm", fontsize=9.5, loc="left")


def boxes(axes, rows):
    """Figure 2.25: how far a bar is from the angle at which it was to stand."""
    levers = sorted({row["lever_m"] for row in rows})
    for side, (condition, colour) in zip((-0.18, 0.18), (("coupled", A), ("uncoupled", B))):
        data = [[row["error_deg"] for row in rows if row["condition"] == condition and row["lever_m"] == lever] for lever in levers]
        drawn = axes.boxplot(data, positions=[i + side for i in range(len(levers))], widths=0.28, patch_artist=True)
        for part in ("boxes", "whiskers", "caps", "medians", "fliers"):
            for line in drawn[part]:
                line.set(color=colour)
        for box in drawn["boxes"]:
            box.set(facecolor="white")
        for flier in drawn["fliers"]:
            flier.set(marker=".", markeredgecolor=colour)
        axes.plot([], [], color=colour, label=condition)
    axes.set_xticks(range(len(levers)), [f"{1e3 * lever:g}" for lever in levers])
    axes.set(xlabel="held from its centre of mass [mm]", ylabel="off, 30 or 60 if it fell [degrees]")
    axes.set_title("let turn to 30 or 60 degrees", fontsize=9.5, loc="left")


def draw(cubes, align, samples):
    """The figure; matplotlib's backend is the caller's choice."""
    import matplotlib.pyplot as plt

    figure, grid = plt.subplots(2, 2, figsize=(9.6, 6.6))
    (first, second), (third, last) = grid
    grips(first, cubes)
    boxes(last, align)
    narrow = min(row["arm_m"] for row in samples)
    levers = sorted({row["lever_m"] for row in samples if row["arm_m"] == narrow})
    course(second, samples, levers[len(levers) // 2 - 1])
    course(third, samples, levers[-1])
    for axes in grid.flat:
        axes.grid(True, color="#e4e8ec", lw=0.7)
        axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    return figure


def main():
    parser = argparse.ArgumentParser(description="Draws what haptic-bench grasp --csv and --samples have written.")
    parser.add_argument("csv")
    parser.add_argument("--samples", required=True)
    parser.add_argument("--output", required=True)
    options = parser.parse_args()
    lines = lines_of(options.csv)
    cubes, align = table(options.csv, lines, CUBES, "--csv"), table(options.csv, lines, ALIGN, "--csv")
    samples = table(options.samples, lines_of(options.samples), SAMPLES, "--samples")

    import matplotlib

    matplotlib.use("Agg")
    figure = draw(cubes, align, samples)
    try:
        figure.savefig(options.output, dpi=110)
    except (OSError, ValueError) as error:
        fail(options.output, f"it cannot be written: {error}")


if __name__ == "__main__":
    main()
