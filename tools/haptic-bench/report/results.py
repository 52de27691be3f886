"""Sections of the page of haptic-bench report for what other benchmarks wrote with --csv: a plot where there is one for it, and
the machine and the rows as they stand in the file."""
import csv
import html
import importlib.util
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
INK, FAINT = "#26303a", "#8a949e"


def beside(path):
    """The script that draws that benchmark by itself."""
    spec = importlib.util.spec_from_file_location(pathlib.Path(path).stem, HERE.parent / path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def load(path):
    script = beside("load/figure.py")
    return script.draw(script.read(path)[0])


def zwidth(path):
    script = beside("zwidth/plot.py")
    return script.draw(script.load(path))


def cost(path):
    """Mean and 99th percentile of a tick over the triangles, and a pointer chase over as many bytes."""
    import matplotlib.pyplot as plt

    _, rows = read(path)
    ways = [what for what in dict.fromkeys(row["what"] for row in rows) if what.startswith("tick")]
    figure, axis = plt.subplots(figsize=(6, 3.6))
    for way, colour in zip(ways, ("#00798c", "#d1495b", "#edae49")):
        mine = [row for row in rows if row["what"] == way]
        triangles = [float(row["triangles"]) for row in mine]
        for column, line in (("mean", "o-"), ("p99", "^:")):
            axis.loglog(triangles, [float(row[column]) / 1e3 for row in mine], line, color=colour, label=f"{way}, {column}", ms=4)
    chase = {float(row["triangles"]): float(row["chase"]) / 1e3 for row in rows}
    axis.loglog(list(chase), list(chase.values()), "--", color=FAINT, label="one step of a pointer chase")
    axis.set_xlabel("triangles")
    axis.set_ylabel("time [µs]")
    axis.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    return figure


# Columns that tell whose file it is, the heading, how it is drawn.
KINDS = [({"eigenvalue", "damping", "off", "on"}, "The closed loop: haptic-bench zwidth", zwidth),
         ({"triangles", "what", "p99", "chase"}, "A tick over a million triangles: haptic-bench cost", cost)]


def read(path):
    """The lines of the machine and the rows, each a dictionary."""
    machine, lines = [], []
    try:
        with open(path, encoding="utf-8", newline="") as file:
            for line in file:
                if line.startswith("#"):
                    machine.append(line[1:].strip())
                else:
                    lines.append(line)
        rows = list(csv.DictReader(lines))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        sys.exit(f"haptic-bench report: {path}: it cannot be read: {error} (write it with --csv)")
    if not rows or any(None in row or None in row.values() for row in rows):
        sys.exit(f"haptic-bench report: {path}: holds no table with a header (write it with --csv)")
    return machine, rows


def kind(path, rows):
    for columns, title, draw in KINDS:
        if columns <= rows[0].keys():
            return title, draw
    benchmark = rows[0].get("benchmark")
    if benchmark == "load":
        return "A busy machine: haptic-bench load", load
    return (f"haptic-bench {benchmark}" if benchmark else pathlib.Path(path).name), None


def section(path):
    """(heading, lines of the machine, figure or None, table as HTML) of a file."""
    machine, rows = read(path)
    title, draw = kind(path, rows)
    cells = "".join("<tr>" + "".join(f"<td>{html.escape(row[c])}</td>" for c in row) + "</tr>\n" for row in rows)
    head = "".join(f"<th>{html.escape(c)}</th>" for c in rows[0])
    try:
        figure = draw(path) if draw else None
    except (KeyError, ValueError) as error:
        sys.exit(f"haptic-bench report: {path}: it cannot be drawn: {error} (write it with --csv)")
    return title, machine, figure, f"<table><tr>{head}</tr>\n{cells}</table>"
