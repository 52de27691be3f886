#!/usr/bin/python3
"""Draws the page of haptic-bench report: one HTML file with its plots inside.

    report.py PAGE.html [RESULTS.csv ...] < DATA.json
    report.py --check [RESULTS.csv ...]
"""
import html
import io
import json
import pathlib
import re
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402
import results  # noqa: E402

INK, FAINT = "#26303a", "#8a949e"
COLOURS = {"ours": "#00798c", "god-object": "#d1495b", "nearest": "#8a949e", "thesis": "#edae49", "local:rate=30": "#7b5ea7",
           "local:rate=300": "#66a182", "voxel:cells=128": "#edae49"}
# The yardstick lies broad below what is measured by it, and shows beside a curve that covers it.
BROAD = {"lw": 5, "alpha": 0.45, "zorder": 1.5, "solid_capstyle": "butt"}
STYLE = """
body { font: 15px/1.45 sans-serif; color: #26303a; max-width: 1080px; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: .6em 0 1.6em; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .2em .7em; border-bottom: 1px solid #e4e8ec; }
th { border-bottom: 2px solid #8a949e; }
dt { font-weight: bold; } dd { margin: 0 0 .4em 2em; }
p.settings, figcaption { color: #5f6b76; } pre { background: #f4f6f8; padding: .8em; overflow-x: auto; }
figure { margin: 1em 0 2em; } svg { max-width: 100%; height: auto; }
@media print {
  body { font-size: 10pt; margin: 0; } pre { white-space: pre-wrap; }
  h2, h3, p.settings { break-after: avoid; } tr, pre, figure { break-inside: avoid; } table { width: 100%; }
}
"""

# Who is handed the page alone has neither the documentation nor the thesis.
METHOD = """<h2>Method</h2>
<p>A hand strokes a mesh, and each algorithm answers each of its positions with a force, all in one program, on the same
positions, without a device. A stroke is a way over the smooth surface that the mesh stands for: points <i>p</i>, outward
normals <i>n</i> and the force <i>F</i> with which the hand presses. Where the surface has the stiffness <i>k</i>, the hand is
at <i>p</i> &minus; (<i>F</i> / <i>k</i>) <i>n</i>, and should feel <i>F n</i>. The force MSE is the mean of the squared length
of the difference of both forces, over all samples; times are of one answer.</p>
<dl>
<dt>ours</dt><dd>The proxy of hapticd: constraint-based and swept; it goes around an edge to a nearer surface where a free way
leads there.</dd>
<dt>god-object</dt><dd>C. B. Zilles and J. K. Salisbury: A constraint-based god-object method for haptic display, IROS 1995. As
published: local, with at most three facets; over the same tree as ours.</dd>
<dt>nearest</dt><dd>The potential method: the nearest point of the mesh, every triangle tried. Inside is told by pseudo-normals
(J. A. B&aelig;rentzen and H. Aan&aelig;s, IEEE TVCG 11(3), 2005). It passes through thin plates.</dd>
<dt>voxel:cells=128</dt><dd>Signed distances, sampled on a grid of so many cells along the longest side, and interpolated.</dd>
<dt>local:rate=30</dt><dd>Tangent planes that a client sends so many times a second, each 5 ms late.</dd>
<dt>thesis</dt><dd>What chapter 4 of <i>Multirate and Perceptual Techniques for Haptic Rendering in Virtual Environments</i> (PhD
thesis, PERCRO, Scuola Superiore S. Anna) prints for its own machine and settings; table and figure numbers are its own.
Not all settings are given there, so its numbers stand beside ours as a hint.</dd>
</dl>
"""


def style():
    matplotlib.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 10, "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": FAINT,
        "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 10.5,
        "axes.titlelocation": "left", "axes.grid": True, "grid.color": "#e4e8ec", "axes.axisbelow": True,
        "legend.frameon": False, "svg.hashsalt": "haptic-bench"})


def svg(figure):
    """The figure as an element of the page; ids made its own, for a page has only one of each."""
    svg.count = getattr(svg, "count", 0) + 1
    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)
    drawn = text.getvalue()
    drawn = drawn[drawn.index("<svg"):]
    return re.sub(r'(id="|href="#|url\(#)', rf"\g<1>f{svg.count}-", drawn)


def look(name, **otherwise):
    """Colour and line of an algorithm's curve."""
    return {"color": COLOURS[name], "label": name, **otherwise, **(BROAD if name == "nearest" else {})}


def column(table, name):
    at = table["columns"].index(name)
    return [float(row[at]) if row[at] != "-" else None for row in table["rows"]]


def spheres(tables):
    tables = [t for t in tables if "Table 4.1" in t["title"]]
    figure, axes = plt.subplots(1, len(tables), figsize=(11, 3.4), sharey=True)
    for axis, table in zip(axes, tables):
        triangles = column(table, "triangles")
        for name in ("god-object", "ours", "nearest"):
            axis.loglog(triangles, column(table, name + " MSE"), "o-", ms=4, **look(name))
        thesis = column(table, "thesis MSE")
        if thesis[0] is not None:
            axis.loglog(triangles, thesis, "s--", color=COLOURS["thesis"], label="thesis", ms=4)
        axis.set_title(table["title"].split(": ")[1])
        axis.set_xlabel("triangles")
    axes[0].set_ylabel("force MSE [N²]")
    axes[0].legend()
    return svg(figure), ("Force error on spheres of ever more triangles, against the smooth sphere; settings as in the tables. The "
                         "nearest point of the facets is the yardstick; what blurs them may lie a little below it.")


def times(tables):
    tables = [t for t in tables if "Table 4.1" in t["title"]]
    figure, axis = plt.subplots(figsize=(5.5, 3.4))
    for name in ("ours", "god-object", "nearest"):
        axis.loglog(column(tables[-1], "triangles"), column(tables[-1], name + " us"), "o-", ms=4, **look(name))
    axis.set_xlabel("triangles")
    axis.set_ylabel("mean time of a step [µs]")
    axis.set_title(tables[-1]["title"].split(": ")[1])
    axis.legend()
    return svg(figure), "What an answer costs: the mean over a run. The nearest point tries every triangle."


def ridges(data):
    figure, axes = plt.subplots(2, len(data), figsize=(11, 5.6), sharey="row", layout="constrained")
    for k, ridge in enumerate(data):
        for name, one in ridge["algorithms"].items():
            x, z = zip(*one["proxy"])
            axes[0][k].plot([1e3 * v for v in x], [1e3 * v for v in z], **look(name, lw=1.4))
            axes[1][k].semilogy(ridge["t"], [max(e, 1e-6) for e in one["error"]], **look(name, lw=1))
        x, z = zip(*ridge["hand"])
        axes[0][k].plot([1e3 * v for v in x], [1e3 * v for v in z], ":", color=FAINT, lw=0.8, label="hand")
        axes[0][k].set(xlim=(-12, 12), title=f"{ridge['degrees']}°", xlabel="x [mm]")
        axes[1][k].set(ylim=(1e-4, 100), xlabel="time [s]")
    axes[0][0].set_ylabel("z [mm]")
    axes[0][-1].legend(fontsize=8, loc="upper right", bbox_to_anchor=(1.02, 1))
    axes[1][0].set_ylabel("force error [N]")
    return svg(figure), ("The ridges of table 4.3, stroked from left to right: above, the way of the contact point; below, the length "
                         "of the force's error. A local proxy waits at the foot. At 75° and 85° the hand is in the air for part of "
                         "the way, on the other side than it strokes.")


def sweep(data):
    figure, axis = plt.subplots(figsize=(5.5, 3.4))
    for name, mse in data["mse"].items():
        axis.loglog(data["stiffness"], mse, "o-", ms=4, **look(name))
    axis.set_xlabel("stiffness [N/m]")
    axis.set_ylabel("force MSE [N²]")
    axis.legend()
    return svg(figure), ("Force error over the surface's stiffness: "
                         f"{data['model']}, {data['trajectory']}, 1 N, 10 s at 1 kHz, against the smooth sphere.")


def heading(name):
    """A column's name as text has it, with units and degrees as print has them."""
    for plain, printed in ((r"\bMSE( \d+)?$", r"MSE\1 [N²]"), (r"\bus\b", "[µs]"), (r"\bs\b", "[s]"), (r" (\d+)\b", r" \1°")):
        name = re.sub(plain, printed, name)
    return name


def table_html(table):
    head = "".join(f"<th>{html.escape(heading(c))}</th>" for c in table["columns"])
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>\n" for row in table["rows"])
    return (f"<h3>{html.escape(table['title'])}</h3>\n<p class=settings>{html.escape(table['settings'])}</p>\n"
            f"<table><tr>{head}</tr>\n{rows}</table>\n")


def spread(tables, rounds):
    """Medians of all rounds with their intervals: the numbers to cite. Of fewer than six rounds that is their range."""
    what = "one round" if rounds == 1 else f"median of {rounds} rounds, {'95 % interval' if rounds >= 6 else 'range'}"
    def figures(s):
        if s["unit"] == "hash":
            return f"<td>{int(s['median']):012x}</td><td></td>"
        interval = "" if s["low"] == s["high"] else f"{s['low']:.4g} .. {s['high']:.4g}"
        return f"<td>{s['median']:.6g}</td><td>{interval}</td>"

    rows = "".join(f"<tr><td>{html.escape(s['name'])}</td>{figures(s)}<td>{html.escape(s['unit'])}</td></tr>\n"
                   for t in tables for s in t["series"])
    return (f"<details><summary>Every quantity: {what}</summary>\n<table><tr><th>quantity</th>"
            f"<th>median</th><th>interval</th><th>unit</th></tr>\n{rows}</table></details>\n")


def figure_html(drawn, words):
    """With its number on the page."""
    figure_html.count = getattr(figure_html, "count", 0) + 1
    return f"<figure>{drawn}<figcaption>Figure {figure_html.count}. {html.escape(words)}</figcaption></figure>\n"


def added(path):
    """What another benchmark wrote."""
    return "".join(map(section_html, *zip(*results.sections(path))))


def section_html(title, machine, figure, table):
    told = f"<pre>{html.escape(chr(10).join(machine))}</pre>\n" if machine else ""
    drawn = figure_html(svg(figure), title) if figure else ""
    return (f"<h2>{html.escape(title)}</h2>\n{told}{drawn}"
            f"<details{'' if figure else ' open'}><summary>The figures</summary>\n{table}</details>\n")


def main():
    style()
    if sys.argv[1] == "--check":
        for path in sys.argv[2:]:
            added(path)
        return
    data = json.load(sys.stdin)
    plots = [spheres(data["tables"]), times(data["tables"]), ridges(data["ridges"]), sweep(data["sweep"])]
    machine = "\n".join([f"hapticd {data['version']}", *data["machine"], *data["versions"], f"command: haptic-bench report --rounds {data['rounds']}",
                         "seeds: synthetic recording 1; everything else has no random part"])
    page = ["<!doctype html>\n<html lang=en><meta charset=utf-8><title>haptic-bench</title>\n<style>", STYLE, "</style>\n",
            "<h1>Three degrees of freedom, measured</h1>\n<pre>", html.escape(machine), "</pre>\n", METHOD, "<h2>Tables</h2>\n",
            "<p>Times of a step: mean of a trajectory's steps, median of the rounds.</p>\n",
            *map(table_html, data["tables"]), "<h2>Plots</h2>\n",
            *(figure_html(drawn, words) for drawn, words in plots),
            spread(data["tables"], data["rounds"]), *map(added, sys.argv[2:]), "</html>\n"]
    pathlib.Path(sys.argv[1]).write_text("".join(page), encoding="utf-8")


if __name__ == "__main__":
    main()
