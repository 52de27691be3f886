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
        command = [sys.argv[1], "report", path, "--rounds", "1", "--with"]
        subprocess.run([*command, f"{folder}/cost.csv", f"{folder}/load.csv", f"{folder}/grasp.csv"], check=True, stdout=subprocess.DEVNULL)
        # Refused before anything is measured, else this took hours.
        command[command.index("1")] = "10000"
        for nonsense, words in ((b"a,b\n1\n", "holds no table"), (b"a,b\n1,2\n3\n", "holds no table"), (b"a,b\n\xff,2\n", "cannot be read"),
                                (COST.replace("870", "?").replace("900", "fast").encode(), "cannot be drawn"),
                                (COST.encode()[:-2], "is cut off"),
                                (FORMER_COST.encode(), "was written by an older version of haptic-bench cost (")):
            (pathlib.Path(folder) / "nonsense.csv").write_bytes(nonsense)
            refused = subprocess.run([*command, f"{folder}/nonsense.csv"], capture_output=True, text=True, check=False)
            if refused.returncode != 1 or f"nonsense.csv: {words}" not in refused.stderr.replace("it ", ""):
                sys.exit(f"{nonsense} was taken: {refused.stderr}")
        leavesNothing(folder)
        command[command.index(path)] = f"{folder}/none/page.html"
        nowhere = subprocess.run(command[:-1], capture_output=True, text=True, check=False)
        if nowhere.returncode != 1 or "none/page.html" not in nowhere.stderr:
            sys.exit(f"a folder that is not there was not named: {nowhere.stderr}")
        if sorted(file.name for file in pathlib.Path(folder).iterdir()) != ["cost.csv", "grasp.csv", "load.csv", "nonsense.csv", "page.html"]:
            sys.exit(f"files are left: {list(pathlib.Path(folder).iterdir())}")
        page = Page()
        page.feed(path.read_text(encoding="utf-8"))
    missing = [text for text in ("16128", "0.5018370", "22.349", "2.885208", "0.201283", "0.0417", "god-object", "voxel:cells=128",
                                "150.5", "147.5 .. 153.5", "1010.25", "1.4375", "1.0074", "-3.25") if text not in page.cells]
    words = " ".join(page.cells)
    missing += [text for text in ("thesis MSE [N²]", "ours [µs]", "MSE 45° [N²]", "[µs] at 85°", "thesis init [s]", "mean of a trajectory's steps, median of the rounds",
                              "haptic-bench report --rounds 1\n", "Zilles", "Multirate and Perceptual Techniques", "Figure 4. ", "Figure 8. ")
                if text not in words]
    if re.search(r"e\+1\d .{1,40}hash", words) or not re.search(r" ours forces +[0-9a-f]{12} ", words):
        sys.exit("the page shows hashes as numbers that have lost their end")
    if one := next((text for text in page.cells if re.fullmatch(r"(\S+) \.\. \1", text)), None):
        sys.exit(f"the page shows an interval of one value: {one}")
    if missing or page.count.get("svg") != 8 or page.count.get("table", 0) < 11 or page.fetched:
        sys.exit(f"the page lacks {missing}, counts {page.count}, fetches {page.fetched[:5]}")


if __name__ == "__main__":
    main()
