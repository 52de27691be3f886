"""Colours and lines of the algorithms' curves, the same in every figure of a page."""
import itertools
import re

INK, FAINT = "#26303a", "#8a949e"
COLOURS = {"ours": "#00798c", "god-object": "#d1495b", "nearest": "#8a949e", "thesis": "#edae49", "local:rate=30": "#7b5ea7",
           "local:rate=300": "#66a182", "voxel:cells=128": "#c77d0a"}
# The yardstick lies broad below what is measured by it, and shows beside a curve that covers it.
BROAD = {"lw": 5, "alpha": 0.45, "zorder": 1.5, "solid_capstyle": "butt"}
# Above ours, which shows in its gaps: where both are the same, neither hides the other.
DASHED = {"ls": (0, (3, 2)), "mfc": "white", "zorder": 3}
MORE = itertools.cycle(("#b5179e", "#3a5a40", "#8d5524", "#1d3557", "#f3722c", "#577590"))


def colour(name):
    """One that a figure does not know gets the next that is free, and keeps it."""
    if name not in COLOURS:
        COLOURS[name] = next(MORE)
    return COLOURS[name]


SHORT = {}


def shorten(names):
    """Plug-ins are called without their folders, where that tells them apart."""
    files = {name: re.sub("^[^:]*/", "", name) for name in names}
    SHORT.update({name: file for name, file in files.items() if list(files.values()).count(file) == 1})


def called(name):
    """An algorithm as the page calls it."""
    return SHORT.get(name, name)


def look(name, **otherwise):
    """Colour and line of an algorithm's curve."""
    special = {"nearest": BROAD, "god-object": DASHED}.get(name, {})
    return {"color": colour(name), "label": called(name), **otherwise, **special}
