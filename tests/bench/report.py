#!/usr/bin/python3
"""The page of haptic-bench report: all tables and plots on it, nothing outside of it needed. Usage: report.py HAPTIC_BENCH"""
import html.parser
import pathlib
import re
import subprocess
import sys
import tempfile
import time


class Page(html.parser.HTMLParser):
    """Counts tags and gathers what would be fetched."""

    def __init__(self):
        super().__init__()
        self.count, self.fetched, self.cells = {}, [], []

    def handle_starttag(self, tag, attributes):
        self.count[tag] = self.count.get(tag, 0) + 1
        self.fetched += [value for name, value in attributes
                         if name in ("src", "href", "xlink:href", "data") and not value.startswith("#")]

    def handle_data(self, data):
        self.cells.append(data.strip())


COST = """# machine: none
benchmark,quantity,unit,round,value
""" + "".join(f"cost {triangles} triangles 0.1 m/s 10 s,{quantity},ns,{i + 1},{value + i}\n"
              for triangles, scale in ((1152, 1), (1002528, 3))
              for quantity, value in (("tick 0 mm median", 290 * scale), ("tick 0 mm mean", 300 * scale), ("tick 0 mm p99", 500 * scale),
                                      ("pointer chase", 50.5 * scale - 4))
              for i in range(7)) + "cost 1152 triangles 0.1 m/s 10 s,\"tick 0 mm sweeps, mean\",a tick,1,1.5\n"
FORMER_COST = "triangles,what,mean,median,p99,p99.9,max,chase\n1152,tick 0 mm,300,290,500,600,700,4\n"
LOAD = """benchmark,quantity,unit,round,value
""" + "".join(f'load,"1000 triangles, idle, native: {quantity}",us,0,{value}\n'
              for quantity, value in (("period mean", 1000), ("period p99", 1010.25), ("force error rms", 0.1)))
LOAD += "case,response,rate_hz,overlap_m\nball on ball,impulse,500,1.25e-05\n"  # Another benchmark's, behind it.


SWEEP = "benchmark,quantity,unit,round,value\n" + "".join(
    f"sweep sphere spiral,{name} k={k} mu={mu} speed={v} {quantity},1,{k * value}\n" for name in ("ours", "/some/where/mine.so:x=1")
    for k in (100, 300, 1000) for mu in (0, 0.3) for v in (1, 2) for quantity, value in (("force MSE,N^2", 0.0125), ("mean,ns", 7)))
RUN = "benchmark,quantity,unit,round,value\n" + "".join(
    f"run plane lissajous k=1000,{name} {quantity},{i + 1},{value + i}\n" for name in ("ours", "/some/where/mine.so:x=1") for i in range(7)
    for quantity, value in (("force MSE,N^2", 0), ("mean,ns", 300), ("p99,ns", 500)) if i == 0 or value)
MODELS = "benchmark,quantity,unit,round,value\n" + "".join(
    f'"models, 960 triangles",{k} N/m {what} - smooth: {figure},% of the force,1,{k / 8}\n' for k in (300, 1000)
    for what in ("native", "plane at 10 Hz", "plane at 100 Hz", "force at 10 Hz", "force at 100 Hz") for figure in ("rms", "change a tick"))
# Pushes nothing, and takes no large mesh.
PLUGIN = """
#include <stdio.h>
#include "haptic_algorithm.h"
static int one;
static void* create(const haptic_algorithm_problem* p, char* e, size_t n) {
  return p->triangle_count < 5000 ? (void*)&one : (snprintf(e, n, "too many triangles for it"), (void*)0);
}
static void destroy(void* i) { (void)i; }
static void start(void* i, const double h[3]) { (void)i, (void)h; }
static void step(void* i, const double h[3], const double v[3], double dt, haptic_algorithm_contact* contact) {
  (void)i, (void)h, (void)v, (void)dt, (void)contact;
}
const haptic_algorithm* haptic_algorithm_table(void) {
  static const haptic_algorithm table = {1, sizeof table, "idle", "pushes nothing", create, destroy, start, step, 0};
  return &table;
}
"""


def plugin(folder):
    """In a folder of its own, for its name is long then."""
    header = pathlib.Path(__file__).resolve().parents[2] / "tools" / "haptic-bench" / "plugin"
    (folder / "own").mkdir()
    made = folder / "own" / "idle.so"
    subprocess.run(["cc", "-x", "c", "-shared", "-fPIC", f"-I{header}", "-o", made, "-"], input=PLUGIN, text=True, check=True)
    return made


def faults(text):
    """What a page of four figures of its own lacks, of those of the files beside it, and of an algorithm asked for."""
    plots = re.findall("<svg.*?</svg>", text, re.S)
    drawn = [set(re.findall("<!-- (.*?) -->", svg)) for svg in plots]
    rows = [re.findall("<t[dh][^>]*>(.*?)</t[dh]>", row) for row in re.findall("<tr>(.*?)</tr>", text, re.S)]
    for k, words in ((0, {"idle.so", "thesis"}), (1, {f"spheres of {one}" for one in ("1 mm at 2000 N/m", "50 mm at 100 N/m", "50 mm at 1000 N/m")}),
                     (1, {"idle.so", "99th percentile"}), (2, {"idle.so", "85°", "god-object"}), (3, {"idle.so", "against the mesh as it is"}),
                     (-3, {"time of a step [µs]", "force MSE [N²]", "ours", "mine.so:x=1"}),
                     (-2, {"friction 0", "friction 0.3", "ours, speed 1", "mine.so:x=1, speed 2", "stiffness [N/m]"}),
                     (-1, {"300 N/m", "1000 N/m", "plane", "force", "native scene", "rate of the client [Hz]"})):
        if lacks := words - drawn[k]:
            yield f"figure {k} lacks {lacks}"
    if any("<g id=\"f%d-legend_1\"" % (k + 1) in axes for k in (0, 1, 3) for axes in [plots[k][:plots[k].index("-axes_2\"")]]):
        yield "a legend covers curves"
    balls = [row for row in rows if row[0] in ("triangles", "3968", "16128")][:3]
    if [row[-4:] for row in balls][0] != ["ours p99 [µs]", "god-object p99 [µs]", "nearest p99 [µs]", "idle.so p99 [µs]"]:
        yield f"the first table has no 99th percentiles: {balls[0]}"
    idle = balls[0].index("idle.so MSE [N²]") if "idle.so MSE [N²]" in balls[0] else 0
    if (balls[1][idle], balls[2][idle], balls[2][-1]) != ("1", "-", "-"):
        yield f"of the algorithm that was asked for: {balls}"
    if [row[-1] for row in rows if row[0] == "algorithm"] != ["p99 [µs] at 85°"]:
        yield "the ridges have no 99th percentiles"
    every = [row for row in rows if row[:2] == ["sphere:radius=0.001,stacks=4", "ours"]]
    if len(every) != 2 or not any(re.fullmatch("[0-9a-f]{12}", cell) for cell in every[0]):
        yield f"every quantity: {every}, of which hashes are no numbers that have lost their end"
    if "<details" in text[:text.index("<h2>Every quantity")] or "<details" in text[:text.index("A tick, by the size")]:
        yield "its own quantities are folded"
    if text.count("<table class=c16>") != 3 or text.count("table.c16 { font-size: ") != 2:
        yield "its widest tables do not fit on a sheet"
    if "99th percentile; what is below 1e-12 is drawn there" not in text:
        yield "that an exact answer has no logarithm is not told"
    if (begun := text.count("<table")) == 0 or text.count("<thead><tr><th>") != begun:
        yield "a table that goes on on the next sheet has no heads of its columns there"
    if 'addEventListener("beforeprint"' not in text:
        yield "what is folded is not printed"
    if not re.search("stroke-dasharray[^>]*stroke: #d1495b", plots[2]):
        yield "the god-object hides what it lies upon"
    if one := re.search(r"(?<![\d.])([\d.e-]+) \.\. \1(?![\d.e-])", " ".join(cell for row in rows for cell in row)):
        yield f"an interval of one value: {one[0]}"


def commandOf(process):
    """Its words; none when it has gone."""
    try:
        return pathlib.Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return []


def leavesNothing(folder):
    """Killed while the page is being drawn: what draws it goes on for a moment, into nothing."""
    killed = subprocess.Popen([sys.argv[1], "report", f"{folder}/killed.html", "--rounds", "1"], stdout=subprocess.DEVNULL)
    children = pathlib.Path(f"/proc/{killed.pid}/task/{killed.pid}/children")
    drawing = None
    while killed.poll() is None and not drawing:
        time.sleep(0.02)
        for child in children.read_text().split():
            words = commandOf(child)
            if any(word.endswith(b"report.py") for word in words) and b"--check" not in words:
                drawing = child
    killed.terminate()
    killed.wait()
    while any(commandOf(drawing)):
        time.sleep(0.1)
    if left := list(pathlib.Path(folder).glob("killed*")):
        sys.exit(f"a report that was killed left {left}")


GRASP = """# cpu: x
mass_kg,friction,stiffness,hold,slips_n,fell,held_n
0.1,0.4,500,1,1.22625,1.01,1.4375
# said
condition,arm_m,lever_m,closed_n,yields,slid_10_m,slid_30_m,turned_5_rad
coupled,0.006,0.003,0.605,1.0074,nan,nan,0.0223
condition,lever_m,wanted_deg,mass_kg,person,off_deg,error_deg,slid_m,lost
coupled,0.01,30,0.1,1,-3.25,3.25,0.001,false
uncoupled,0.01,30,0.1,1,-30,30,0.03,true
"""


def main():
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "page.html"
        (pathlib.Path(folder) / "cost.csv").write_text(COST, encoding="utf-8")
        (pathlib.Path(folder) / "load.csv").write_text(LOAD, encoding="utf-8")
        (pathlib.Path(folder) / "grasp.csv").write_text(GRASP, encoding="utf-8")
        (pathlib.Path(folder) / "run.csv").write_text(RUN, encoding="utf-8")
        (pathlib.Path(folder) / "sweep.csv").write_text(SWEEP, encoding="utf-8")
        (pathlib.Path(folder) / "models.csv").write_text(MODELS, encoding="utf-8")
        own = plugin(pathlib.Path(folder))
        command = [sys.argv[1], "report", path, "--rounds", "1", "--with"]
        files = [f"{folder}/{name}.csv" for name in ("cost", "load", "grasp", "run", "sweep", "models")]
        made = subprocess.run([*command, *files, "-a", own], check=True, capture_output=True, text=True)
        if "sphere:radius=0.05,stacks=64: left out: " not in made.stderr or "too many triangles for it" not in made.stderr:
            sys.exit(f"a model that an algorithm refused was not told: {made.stderr}")
        # Refused before anything is measured, else this took hours.
        command[command.index("1")] = "10000"
        for nonsense, words in ((b"a,b\n1\n", "holds no table"), (b"a,b\n1,2\n3\n", "holds no table"), (b"a,b\n\xff,2\n", "cannot be read"),
                                (COST.replace("870", "?").replace("900", "fast").encode(), "cannot be drawn"),
                                (COST.encode()[:-2], "is cut off"),
                                (FORMER_COST.encode(), "was written by an older version of haptic-bench cost (")):
            (pathlib.Path(folder) / "nonsense.csv").write_bytes(nonsense)
            refused = subprocess.run([*command, f"{folder}/nonsense.csv"], capture_output=True, text=True, check=False)
            if refused.returncode != 1 or f"nonsense.csv: {words}" not in refused.stderr.replace("it ", "") or "install python3" in refused.stderr:
                sys.exit(f"{nonsense} was taken: {refused.stderr}")
        for algorithms, words in ((("local:rat=30",), "rat"), (("theirs",), "no such algorithm"), ((own, own), "named twice")):
            refused = subprocess.run([*command[:-1], "-a", *algorithms], capture_output=True, text=True, check=False)
            if refused.returncode != 1 or words not in refused.stderr:
                sys.exit(f"{algorithms} were taken: {refused.stderr}")
        leavesNothing(folder)
        command[command.index(path)] = f"{folder}/none/page.html"
        nowhere = subprocess.run(command[:-1], capture_output=True, text=True, check=False)
        if nowhere.returncode != 1 or "none/page.html" not in nowhere.stderr:
            sys.exit(f"a folder that is not there was not named: {nowhere.stderr}")
        if sorted(file.name for file in pathlib.Path(folder).iterdir()) != ["cost.csv", "grasp.csv", "load.csv", "models.csv", "nonsense.csv", "own", "page.html", "run.csv", "sweep.csv"]:
            sys.exit(f"files are left: {list(pathlib.Path(folder).iterdir())}")
        page = Page()
        text = path.read_text(encoding="utf-8")
        page.feed(text)
    missing = [text for text in ("16128", "0.5018370", "22.349", "2.885208", "0.201283", "0.0417", "god-object", "voxel:cells=128",
                                "150.5", "147.5 .. 153.5", "1010.25", "1.25e-05", "1.4375", "1.0074", "-3.25") if text not in page.cells]
    words = " ".join(page.cells)
    missing += [text for text in ("thesis MSE [N²]", "ours [µs]", "MSE 45° [N²]", "[µs] at 85°", "thesis init [s]", "mean of a trajectory's steps and their 99th percentile (p99), each the median of the rounds",
                              "haptic-bench report --rounds 1 -a /", "Zilles", "Multirate and Perceptual Techniques", "Figure 4. ", "Figure 11. ", "pushes nothing")
                if text not in words]
    missing += faults(text)
    if missing or page.count.get("svg") != 11 or page.count.get("table", 0) < 11 or page.fetched:
        sys.exit(f"the page lacks {missing}, counts {page.count}, fetches {page.fetched[:5]}")


if __name__ == "__main__":
    main()
