"""Sections of the page of haptic-bench report for what other benchmarks wrote with --csv: a plot where there is one for it, and
the machine and the rows as they stand in the file, of rounds their medians."""
import csv
import functools
import html
import importlib.util
import itertools
import math
import pathlib
import re
import sys

from palette import FAINT, called, colour, look, shorten

HERE = pathlib.Path(__file__).resolve().parent


def beside(path):
    """The script that draws that benchmark by itself."""
    spec = importlib.util.spec_from_file_location(pathlib.Path(path).stem, HERE.parent / path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def load(path, rows):
    script = beside("load/figure.py")
    return script.draw(script.gather(path, rows))  # Other tables may stand in the file.


def zwidth(_, rows):
    script = beside("zwidth/plot.py")
    return script.draw(script.numbers(rows))


def grasp(path, columns, draw):
    """One of the drawings of grasp/plot.py, of the table with these columns."""
    import matplotlib.pyplot as plt

    script = beside("grasp/plot.py")
    figure, axes = plt.subplots(figsize=(6, 3.6))
    getattr(script, draw)(axes, script.table(path, script.lines_of(path), getattr(script, columns), "--csv"))
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    return figure


@functools.cache
def rank(count):
    """Of so many sorted rounds, the first in the interval that holds the true median with 95 %; of fewer than six all are."""
    below, at = 0.0, 0
    while at < count // 2:
        below += math.exp(math.lgamma(count + 1) - math.lgamma(at + 1) - math.lgamma(count - at + 1) - count * math.log(2))
        if 2 * below > 0.05:
            break
        at += 1
    return max(0, at - 1)


def estimate(values):
    """Median of some rounds and its interval."""
    values = sorted(values)
    count, at = len(values), rank(len(values))
    return (values[(count - 1) // 2] + values[count // 2]) / 2, values[at], values[-1 - at]


def rounds(rows):
    """{(benchmark, quantity, unit): values} of a file with a line for each round."""
    series = {}
    for row in rows:
        series.setdefault((row["benchmark"], row["quantity"], row["unit"]), []).append(float(row["value"]))
    return series


def cost(_, rows):
    """Mean and 99th percentile of a tick over the triangles, and a pointer chase over as many bytes, with their intervals."""
    import matplotlib.pyplot as plt

    curves = {}
    for (benchmark, quantity, _), values in rounds(rows).items():
        triangles, stroke = re.fullmatch(r"cost (\d+) triangles (.*)", benchmark).groups()
        curves.setdefault((stroke, quantity), []).append((int(triangles), *(value / 1e3 for value in estimate(values))))
    figure, axis = plt.subplots(figsize=(6, 3.6))
    several = len({stroke for stroke, _ in curves}) > 1

    def draw(stroke, quantity, label, style, **look):
        x, median, low, high = zip(*sorted(curves[stroke, quantity]))
        spread = [[m - l for m, l in zip(median, low)], [h - m for m, h in zip(median, high)]]
        axis.errorbar(x, median, yerr=spread, fmt=style, capsize=2, label=f"{label}, {stroke}" if several else label, **look)

    ways = list(dict.fromkeys((stroke, quantity[:-5]) for stroke, quantity in curves if re.fullmatch("tick .* mean", quantity)
                              and "," not in quantity))
    for (stroke, way), hue in zip(ways, itertools.cycle(("#00798c", "#d1495b", "#edae49"))):
        for column, line in (("mean", "o-"), ("p99", "^:")):
            draw(stroke, f"{way} {column}", f"{way}, {column}", line, color=hue, ms=4)
    for stroke in dict.fromkeys(stroke for stroke, _ in curves):
        draw(stroke, "pointer chase", "one step of a pointer chase", "--", color=FAINT)
    axis.set(xscale="log", yscale="log", xlabel="triangles", ylabel="time [µs]")
    axis.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    return figure


LEAST = 1e-12  # What is less is rounding, and drawn as that: else it would stretch the axis over twenty decades.


def below(errors):
    """What there is to say of errors that are less."""
    return f"; what is below {LEAST:g} is drawn there" if min(errors) <= LEAST else ""


def ran(_, rows):
    """Error over time of a step, a point for each algorithm: to the left and below is better."""
    import matplotlib.pyplot as plt

    found = {}
    for (_, quantity, unit), values in rounds(rows).items():
        if one := re.fullmatch(r"(.*) (force MSE|proxy RMS|mean|p99)", quantity):
            found.setdefault(one[1], {})[one[2]] = (unit, estimate(values))
    what = next((error for error in ("force MSE", "proxy RMS") if all(error in one for one in found.values())), None)
    if len(found) < 2 or not what:
        return None  # Nothing to compare, or nobody knows the truth of that way.
    shorten(found)
    figure, axis = plt.subplots(figsize=(6, 3.6))
    for name, one in found.items():
        (unit, (error, _, _)), (_, mean), (_, tail) = one[what], one["mean"], one["p99"]
        median, low, high = (value / 1e3 for value in mean)
        error = max(LEAST, error)
        axis.errorbar(median, error, xerr=[[median - low], [high - median]], fmt="o", ms=6, capsize=3, color=colour(name), label=called(name))
        axis.plot(tail[0] / 1e3, error, "^", ms=5, mfc="none", color=colour(name))
    axis.set(xscale="log", yscale="log", xlabel="time of a step [µs]", ylabel=f"{what} [{unit.replace('^2', '²')}]")
    axis.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    figure.set_label(f"{rows[0]['benchmark']}: {what} against the truth of the trajectory, over the time of a step: circles are the mean, with "
                     f"the interval of the rounds, triangles the 99th percentile{below(one[what][1][0] for one in found.values())}.")
    return figure


SWEPT = ("stiffness", "friction", "speed")


def swept(_, rows):
    """Error over what was swept in most values; a panel for each value of the next, a line for each of the last."""
    import matplotlib.pyplot as plt

    found = {}
    for (_, quantity, unit), values in rounds(rows).items():
        if cell := re.fullmatch(r"(.*) k=(\S+) mu=(\S+) speed=(\S+) (force MSE|proxy RMS)", quantity):
            found.setdefault((cell[5], unit), {})[cell[1], *map(float, cell.groups()[1:4])] = max(LEAST, estimate(values)[0])
    if not found:
        return None  # Nobody knows the truth of that way.
    (what, unit), errors = next(iter(sorted(found.items())))
    values = [sorted({key[1 + k] for key in errors}) for k in range(3)]
    over, panel, line = sorted(range(3), key=lambda k: -len(values[k]))
    wide = min(3, len(values[panel]))
    figure, axes = plt.subplots(-(-len(values[panel]) // wide), wide, figsize=(3 + 2.7 * wide, 3.2 * -(-len(values[panel]) // wide)),
                                sharex=True, sharey=True, squeeze=False, layout="constrained")
    names = list(dict.fromkeys(key[0] for key in errors))
    shorten(names)
    for axis in axes.flat[len(values[panel]):]:
        axis.set_axis_off()
    for axis, of_panel in zip(axes.flat, values[panel]):
        for name in names:
            for of_line, style in zip(values[line], itertools.cycle(("-", "--", ":", "-."))):
                points = [(key[1 + over], error) for key, error in sorted(errors.items())
                          if key[0] == name and key[1 + panel] == of_panel and key[1 + line] == of_line]
                label = called(name) + (f", {SWEPT[line]} {of_line:g}" if len(values[line]) > 1 else "")
                axis.plot(*zip(*points), marker="o", ms=4, **look(name) | ({"ls": style} if len(values[line]) > 1 else {}) | {"label": label})
        axis.set(yscale="log", xlabel=SWEPT[over] + (" [N/m]" if over == 0 else ""), title=f"{SWEPT[panel]} {of_panel:g}")
        if values[over][0] > 0:
            axis.set_xscale("log")
    axes[0][0].set_ylabel(f"{what} [{unit.replace('^2', '²')}]")
    axes[0][-1].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    figure.set_label(f"{rows[0]['benchmark']}: {what} over {SWEPT[over]}, against the truth of the trajectory"
                     f"{below(errors.values())}.")
    return figure


def models(_, rows):
    """What the forces of clients are off the smooth surface, over their rate: a column for each stiffness."""
    import matplotlib.pyplot as plt

    found = {}
    for (_, quantity, _), values in rounds(rows).items():
        if cell := re.fullmatch(r"(\S+) N/m (\S+)(?: at (\S+) Hz)? - smooth: (rms|change a tick)", quantity):
            curve = found.setdefault(float(cell[1]), {}).setdefault((cell[4], cell[2]), [])
            curve.append((cell[3] and float(cell[3]), estimate(values)[0]))
    figure, axes = plt.subplots(2, len(found), figsize=(3 + 2.7 * len(found), 5.6), sharex=True, sharey="row", squeeze=False,
                                layout="constrained")
    for column, (stiffness, curves) in zip(axes.T, sorted(found.items())):
        for (what, source), points in curves.items():
            axis = column[int(what != "rms")]
            if points[0][0] is None:
                axis.axhline(points[0][1], ls="--", color=FAINT, label=f"{source} scene")
            else:
                axis.plot(*zip(*sorted(points)), marker="o", ms=4, color=colour(source), label=source)
        column[0].set(title=f"{stiffness:g} N/m", xscale="log", yscale="log")
        column[1].set(xlabel="rate of the client [Hz]", yscale="log")
    axes[0][0].set_ylabel("force error, RMS [%]")
    axes[1][0].set_ylabel("its most change in a tick [%]")
    axes[0][-1].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    figure.set_label("What a hand feels of a mesh by what a client sends, over its rate, against the smooth surface that the mesh stands "
                     "for: above, the root mean square of the force's error; below, the most that it changes from one tick to the next; "
                     "both as parts of the mean force. The native scene stands beside, flat as it is.")
    return figure


# Columns that tell whose file it is, the heading, how it is drawn.
KINDS = [({"eigenvalue", "damping", "off", "on"}, "The closed loop: haptic-bench zwidth", zwidth),
         ({"slips_n", "held_n"}, "Cubes held by two fingers: haptic-bench grasp", lambda path, _: grasp(path, "CUBES", "grips")),
         ({"slid_10_m", "turned_5_rad"}, "Bars that are let go: haptic-bench grasp", None),
         ({"wanted_deg", "error_deg"}, "Bars that are let turn: haptic-bench grasp", lambda path, _: grasp(path, "ALIGN", "boxes"))]
ROUNDS = {"benchmark", "quantity", "unit", "round", "value"}
FORMER_COST = {"triangles", "what", "p99", "chase"}


def tables_of(lines):
    """Each table's rows as dictionaries: a line without any number is the header of another."""
    tables = []
    for fields in filter(None, csv.reader(lines)):
        if not any(is_number(field) for field in fields):
            tables.append((fields, []))
        elif not tables or len(fields) != len(tables[-1][0]):
            return []
        else:
            tables[-1][1].append(dict(zip(tables[-1][0], fields)))
    return [rows for _, rows in tables] if all(rows for _, rows in tables) else []


def is_number(field):
    try:
        float(field)
    except ValueError:
        return False
    return True


def read(path):
    """The lines of the machine and the tables."""
    machine, lines = [], []
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            for line in file:
                if line.startswith("#"):
                    machine.append(line[1:].strip())
                else:
                    lines.append(line)
        if lines and not lines[-1].endswith("\n"):  # As compare has it: the last number may lack its end.
            sys.exit(f"haptic-bench report: {path}: it is cut off: its last line does not end (write it with --csv)")
        tables = tables_of(lines)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        sys.exit(f"haptic-bench report: {path}: it cannot be read: {error} (write it with --csv)")
    if not tables:
        sys.exit(f"haptic-bench report: {path}: holds no table with a header (write it with --csv)")
    if FORMER_COST <= tables[0][0].keys():
        sys.exit(f"haptic-bench report: {path}: was written by an older version of haptic-bench cost (write it again with --csv)")
    return machine, tables


def kind(path, rows):
    for columns, title, draw in KINDS:
        if columns <= rows[0].keys():
            return title, draw
    benchmark = rows[0].get("benchmark")
    if benchmark and benchmark.startswith("cost "):
        return "A tick, by the size of the mesh: haptic-bench cost", cost
    if benchmark == "load":
        return "A busy machine: haptic-bench load", load
    for begin, title, draw in (("run ", "Algorithms: haptic-bench run", ran),
                               ("sweep ", "Over stiffness, friction and speed: haptic-bench sweep", swept),
                               ("models, ", "By the rate of a client: haptic-bench models", models)):
        if benchmark and benchmark.startswith(begin):
            return title, draw
    return (f"haptic-bench {benchmark}" if benchmark else pathlib.Path(path).name), None


def table(header, rows):
    cells = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f"<table><thead><tr>{''.join(f'<th>{html.escape(name)}</th>' for name in header)}</tr></thead>\n{cells}</table>"


def summary(rows):
    """The table of a file with a line for each round: medians with their intervals."""
    def figures(unit, values):
        median, low, high = estimate(values)
        if unit == "hash":
            return f"{int(median):012x}", ""
        return f"{median:.6g}", "" if low == high else f"{low:.4g} .. {high:.4g}"

    return table(("benchmark", "quantity", "median", "interval", "unit", "rounds"),
                 ((benchmark, quantity, *figures(unit, values), unit, str(len(values)))
                  for (benchmark, quantity, unit), values in rounds(rows).items()))


def sections(path):
    """(heading, lines of the machine, figure or None, table as HTML) of each table of a file."""
    machine, tables = read(path)
    for rows in tables:
        title, draw = kind(path, rows)
        try:
            shown = summary(rows) if ROUNDS <= rows[0].keys() else table(rows[0], (row.values() for row in rows))
            figure = draw(path, rows) if draw else None
        except (AttributeError, KeyError, ValueError) as error:
            sys.exit(f"haptic-bench report: {path}: it cannot be drawn: {error} (write it with --csv)")
        yield title, machine, figure, shown
        machine = []
