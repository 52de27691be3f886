"""The figures of the page of haptic-bench report itself: each a figure and the words below it."""
import math

import matplotlib.pyplot as plt

from palette import COLOURS, FAINT, look

FIRST = ("nearest", "ours", "god-object")  # In which order they are drawn.


def in_order(names):
    return [*(name for name in FIRST if name in names), *(name for name in names if name not in FIRST)]


def curves(table):
    """{algorithm: ([triangles], {quantity: [(median, low, high)]})}"""
    found = {}
    for cell in table["cells"]:
        triangles, quantities = found.setdefault(cell["algorithm"], ([], {}))
        triangles.append(cell["triangles"])
        for s in cell["series"]:
            quantities.setdefault(s["name"], []).append((s["median"], s["low"], s["high"]))
    return {name: found[name] for name in in_order(found)}


def name_beside(axes):
    """The legend, beside the last: the more algorithms there are, the more curves it would cover."""
    axes[-1].legend(*axes[0].get_legend_handles_labels(), fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))


def bars_are(rounds):
    """What an interval of medians is, in words."""
    if rounds == 1:
        return "There was one round, and so no interval"
    return (f"Bars: {'the interval that holds the true median with 95 %' if rounds >= 6 else 'the range'}, of {rounds} rounds")


def spheres(tables):
    figure, axes = plt.subplots(1, len(tables), figsize=(11, 3.4), sharey=True)
    for axis, table in zip(axes, tables):
        for name, (triangles, quantities) in curves(table).items():
            axis.loglog(triangles, [median for median, _, _ in quantities["force MSE"]], marker="o", ms=4, **look(name))
        at = table["columns"].index("thesis MSE")
        if thesis := [(float(row[0]), float(row[at])) for row in table["rows"] if row[at] != "-"]:
            axis.loglog(*zip(*thesis), "s--", color=COLOURS["thesis"], label="thesis", ms=4)
        axis.set_title(table["title"].split(": ")[1])
        axis.set_xlabel("triangles")
    axes[0].set_ylabel("force MSE [N²]")
    name_beside(axes)
    return figure, ("Force error on spheres of ever more triangles, against the smooth sphere; settings as in the tables. The nearest "
                    "point of the facets is the yardstick; what blurs them may lie below it. Errors are the same in every "
                    "round, and have no interval.")


def times(tables, rounds):
    figure, axes = plt.subplots(1, len(tables), figsize=(11, 3.6), sharey=True)
    for axis, table in zip(axes, tables):
        for name, (triangles, quantities) in curves(table).items():
            style = look(name, ms=4)
            for quantity, line in (("mean", {"marker": "o"}), ("p99", {"marker": "^", "ls": ":", "lw": 1, "alpha": 1, "label": None})):
                median, low, high = ([1e-3 * one for one in ones] for ones in zip(*quantities[quantity]))
                spread = [[m - l for m, l in zip(median, low)], [h - m for h, m in zip(high, median)]]
                axis.errorbar(triangles, median, yerr=spread, capsize=2, elinewidth=1, **style | line)
        axis.set(xscale="log", yscale="log", title=table["title"].split(": ")[1], xlabel="triangles")
    axes[0].set_ylabel("time of a step [µs]")
    axes[0].plot([], [], "^:", color=FAINT, lw=1, ms=4, label="99th percentile")
    name_beside(axes)
    return figure, ("What an answer costs: circles are the mean over a run, triangles its 99th percentile, both medians of the rounds. "
                    f"{bars_are(rounds)}. Where the mean lies above the percentile, a few steps took very long, as by other work of the "
                    "machine. The nearest point tries every triangle.")


def ridges(data):
    figure, axes = plt.subplots(2, len(data), figsize=(11, 5.6), sharey="row", layout="constrained")
    for k, ridge in enumerate(data):
        for name in in_order(ridge["algorithms"]):
            one = ridge["algorithms"][name]
            x, z = zip(*one["proxy"])
            axes[0][k].plot([1e3 * v for v in x], [1e3 * v for v in z], **look(name, lw=1.8))
            axes[1][k].semilogy(ridge["t"], [max(e, 1e-6) for e in one["error"]], **look(name, lw=1.4))
            # Where it is at last: a contact that stays behind looks like one that has gone on.
            axes[0][k].plot(1e3 * x[-1], 1e3 * z[-1], "o", ms=6, mfc="none", color=COLOURS[name], zorder=4)
        x, z = zip(*ridge["hand"])
        axes[0][k].plot([1e3 * v for v in x], [1e3 * v for v in z], ":", color=FAINT, lw=0.8, label="hand")
        wide = 5 / math.tan(math.radians(ridge["degrees"])) + 4  # 4 mm beside each foot.
        axes[0][k].set(xlim=(-wide, wide), title=f"{ridge['degrees']}°", xlabel="x [mm]")
        axes[1][k].set(ylim=(1e-4, 100), xlabel="time [s]")
    axes[0][0].set_ylabel("z [mm]")
    axes[0][-1].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    axes[1][0].set_ylabel("force error [N]")
    return figure, ("The ridges of table 4.3, stroked from left to right: above, the way of the contact point; below, the length "
                    "of the force's error. A straight line through the air is a jump. A local proxy (god-object, dashed) stays on the "
                    "side that rises: it jumps onto the plane late, and at 85° not at all (ring: where a contact is at last). At 75° "
                    "and 85° the hand is in the air for part of the way, on the other side than it strokes.")


def sweep(data):
    figure, axes = plt.subplots(1, 2, figsize=(11, 3.6), sharey=True, layout="constrained")
    for axis, errors, truth in ((axes[0], data["mse"], "against the smooth sphere"), (axes[1], data["mesh"], "against the mesh as it is")):
        for name in in_order(errors):
            axis.loglog(data["stiffness"], [math.nan if e is None else e for e in errors[name]], marker="o", ms=4, **look(name))
        axis.set(title=truth, xlabel="stiffness [N/m]")
    axes[0].set_ylabel("force MSE [N²]")
    name_beside(axes)
    return figure, (f"Force error over the surface's stiffness: {data['model']}, {data['trajectory']}, 1 N, 10 s at 1 kHz. Left, the truth is "
                    "the smooth sphere: the facets lie inside of it, so what feels them exactly pushes too little, by the stiffness times "
                    "that gap, and on a stiff surface this is most of the error. A slow client's plane is held while the hand goes on "
                    "beyond its facet, where it lies above the mesh: that makes up for part of the gap, and so 30 Hz may beat ours on a "
                    "stiff surface, by one error that hides another. Right, the truth is what the nearest point of the facets answers: "
                    "there the plane has nothing to make up for, and ours is off at single samples, at which two facets are equally near.")
