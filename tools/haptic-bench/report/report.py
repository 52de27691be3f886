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
import figures  # noqa: E402
import results  # noqa: E402
from palette import FAINT, INK, called, shorten  # noqa: E402

STYLE = """
body { font: 15px/1.45 sans-serif; color: #26303a; max-width: 1080px; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: .6em 0 1.6em; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .2em .7em; border-bottom: 1px solid #e4e8ec; }
th { border-bottom: 2px solid #8a949e; }
dt { font-weight: bold; } dd { margin: 0 0 .4em 2em; }
p.settings, figcaption { color: #5f6b76; } pre { background: #f4f6f8; padding: .8em; overflow-x: auto; }
table.all { font-size: 12.5px; } table.all td { padding: .1em .5em; white-space: nowrap; } td.name { text-align: left; }
figure { margin: 1em 0 2em; } svg { max-width: 100%; height: auto; }
@media print {
  body { font-size: 10pt; margin: 0; } pre { white-space: pre-wrap; }
  @page { margin: 14mm; }
  h2, h3, p.settings { break-after: avoid; } tr, pre, figure { break-inside: avoid; } table { width: 100%; font-size: 7.4pt; }
  th, td { padding: .15em .3em; } table.all { font-size: 6.5pt; } table.all td { padding: .1em .3em; }
}
"""
# Wide tables fit by their letters, on the screen and on a sheet.
STYLE += "".join(f"table.c{n} {{ font-size: {210 / n:.1f}px; }} @media print {{ table.c{n} {{ font-size: {96 / n:.1f}pt; }} }}\n" for n in range(14, 40))

# What is folded is printed too: a browser opens nothing for paper by itself.
UNFOLD = """<script>
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
</script>
"""

REFUSED = 3  # Of haptic-bench report: what is wrong with a file has been told.

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
{more}</dl>
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


def heading(name):
    """A column's name as text has it, with units and degrees as print has them."""
    for plain, printed in ((r"\bMSE( \d+)?$", r"MSE\1 [N²]"), (r"\bus\b", "[µs]"), (r"\bs\b", "[s]"), (r" (\d+)\b", r" \1°")):
        name = re.sub(plain, printed, name)
    return name


def more(algorithms):
    """What there is to say of those that were asked for."""
    return "".join(f"<dt>{html.escape(called(one['name']))}</dt><dd>{html.escape(one['summary'] or 'A plug-in.')}</dd>\n"
                   for one in algorithms if f"<dt>{one['name']}</dt>" not in METHOD)


def with_tails(table):
    """The table's columns and rows with the 99th percentiles of its times, which a mean hides."""
    tail = {(cell["algorithm"], cell["model"]): f"{s['median'] / 1e3:.4g}"
            for cell in table["cells"] for s in cell["series"] if s["name"] == "p99"}
    models = list(dict.fromkeys(cell["model"] for cell in table["cells"]))
    if table["columns"][0] == "algorithm":
        rows = [[*row, tail.get((row[0], models[-1]), "-")] for row in table["rows"]]
        return [*table["columns"], table["columns"][-2].replace("us", "p99 us")], rows
    names = [column.removesuffix(" us") for column in table["columns"] if column.endswith(" us") and column != "thesis us"]
    rows = [[*row, *(tail.get((name, model), "-") for name in names)] for row, model in zip(table["rows"], models)]
    return [*table["columns"], *(f"{name} p99 us" for name in names)], rows


def table_html(table):
    columns, rows = with_tails(table)
    for name in {cell["algorithm"] for cell in table["cells"]}:
        columns = [c.replace(f"{name} ", f"{called(name)} ") if c.startswith(f"{name} ") else c for c in columns]
    head = "".join(f"<th>{html.escape(heading(c))}</th>" for c in columns)
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(called(c))}</td>" for c in row) + "</tr>\n" for row in rows)
    return (f"<h3>{html.escape(table['title'])}</h3>\n<p class=settings>{html.escape(table['settings'])}</p>\n"
            f"<table class=c{len(columns)}><thead><tr>{head}</tr></thead>\n{rows}</table>\n")


# Factors to the units in which the page has them.
SHOWN = {"ns": (1e-3, "µs"), "m": (1e3, "mm"), "s": (1e3, "ms"), "byte": (1e-3, "kB"), "N^2": (1, "N²")}


def shown(s):
    """A quantity with its interval."""
    if s["unit"] == "samples":
        return f"{s['median']:.0f}"
    if s["unit"] == "hash":
        return f"{int(s['median']):012x}"
    median, low, high = (SHOWN.get(s["unit"], (1, ""))[0] * s[one] for one in ("median", "low", "high"))
    low, high = f"{low:.4g}", f"{high:.4g}"
    return f"{median:.4g}" + (f"<br><small>{low} .. {high}</small>" if low != high else "")


def quantities(table):
    """Every quantity of a table's runs: errors, which repeat, and then times."""
    units = {s["name"]: SHOWN.get(s["unit"], (1, s["unit"]))[1] for cell in table["cells"] for s in cell["series"]}
    timed = [name for name in units if units[name] in ("µs", "ms")]
    text = f"<h3>{html.escape(table['title'])}</h3>\n"
    for names in ([name for name in units if name not in timed], timed):
        head = "".join(f"<th>{html.escape(name)}{f' [{units[name]}]' if units[name] not in ('hash', 'samples') else ''}</th>" for name in names)
        rows = ""
        for cell in table["cells"]:
            held = {s["name"]: shown(s) for s in cell["series"]}
            rows += (f"<tr><td class=name>{html.escape(cell['model'])}</td><td class=name>{html.escape(called(cell['algorithm']))}</td>"
                     + "".join(f"<td>{held.get(name, '-')}</td>" for name in names) + "</tr>\n")
        text += f"<table class=all><thead><tr><th>model</th><th>algorithm</th>{head}</tr></thead>\n{rows}</table>\n"
    return text


def spread(tables, rounds):
    """Medians of all rounds with their intervals: the numbers to cite."""
    what = ("of one round" if rounds == 1 else
            f"medians of {rounds} rounds, and below each the "
            + ("interval that holds the true one with 95 %" if rounds >= 6 else "range of the rounds"))
    return (f"<h2>Every quantity</h2>\n<p>Times: {what}. Errors are the same in every round. Mean to max are of the steps of a "
            "run, init is what loading takes, memory what it then holds, and forces a hash of all bits of all forces.</p>\n"
            + "".join(map(quantities, tables)))


def figure_html(drawn, words):
    """With its number on the page."""
    figure_html.count = getattr(figure_html, "count", 0) + 1
    return f"<figure>{drawn}<figcaption>Figure {figure_html.count}. {html.escape(words)}</figcaption></figure>\n"


def added(path):
    """What another benchmark wrote."""
    return "".join(map(section_html, *zip(*results.sections(path))))


def section_html(title, machine, figure, table):
    told = f"<pre>{html.escape(chr(10).join(machine))}</pre>\n" if machine else ""
    drawn = figure_html(svg(figure), figure.get_label() or title) if figure else ""
    return (f"<h2>{html.escape(title)}</h2>\n{told}{drawn}"
            f"<details{'' if figure else ' open'}><summary>The figures</summary>\n{table}</details>\n")


def main():
    style()
    if sys.argv[1] == "--check":
        for path in sys.argv[2:]:
            added(path)
        return
    data = json.load(sys.stdin)
    shorten([one["name"] for one in data["more"]])
    balls = [table for table in data["tables"] if "Table 4.1" in table["title"]]
    plots = [figures.spheres(balls), figures.times(balls, data["rounds"]), figures.ridges(data["ridges"]), figures.sweep(data["sweep"])]
    command = f"haptic-bench report --rounds {data['rounds']}" + (" -a " + " ".join(one["name"] for one in data["more"]) if data["more"] else "")
    machine = "\n".join([f"hapticd {data['version']}", *data["machine"], *data["versions"], f"command: {command}",
                         "seeds: synthetic recording 1; everything else has no random part"])
    page = ["<!doctype html>\n<html lang=en><meta charset=utf-8><title>haptic-bench</title>\n<style>", STYLE, "</style>\n", UNFOLD,
            "<h1>Three degrees of freedom, measured</h1>\n<pre>", html.escape(machine), "</pre>\n", METHOD.format(more=more(data["more"])),
            "<h2>Tables</h2>\n",
            "<p>Times of a step: mean of a trajectory's steps and their 99th percentile (p99), each the median of the rounds; their "
            "intervals stand under \"Every quantity\".</p>\n",
            *map(table_html, data["tables"]), "<h2>Plots</h2>\n",
            *(figure_html(svg(figure), words) for figure, words in plots),
            spread(data["tables"], data["rounds"]), *map(added, sys.argv[2:]), "</html>\n"]
    pathlib.Path(sys.argv[1]).write_text("".join(page), encoding="utf-8")


if __name__ == "__main__":
    try:
        main()
    except SystemExit as end:
        if not isinstance(end.code, str):
            raise
        print(end.code, file=sys.stderr)
        sys.exit(REFUSED)
