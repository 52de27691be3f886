#!/usr/bin/python3
"""The scripts that draw results, and the one that plans a stroke, say what is wrong with a file instead of a traceback.
Usage: drawings.py SOURCE_DIRECTORY"""
import importlib.util
import pathlib
import struct
import subprocess
import sys
import tempfile

LOAD = "benchmark,quantity,unit,round,value\n"
CELL = 'load,"3024 triangles, idle, native: period mean",us,1,{}\n' + "".join(
    f'load,"3024 triangles, idle, native: {quantity}",us,1,1\n' for quantity in ("period p99", "force error rms"))
WALL = ("rate_hz,delay_ticks,step_m,friction_n,damping,colgate,colgate_delayed,friction_limit,eigenvalue,slowest,off,on,displayed,"
        "buzz_off,buzz_on\n1000,0,1e-05,0.1,0,1000,1000,20000,13000,13000,{},118000,1,0,0\n")

OTHER = "case,response,rate_hz,overlap_m\nball on ball,impulse,500,1e-05\n"


HELD = ("mass_kg,friction,stiffness,hold,slips_n,fell,held_n\n0.1,0.4,500,1,1.2,1,{}\n# said\n"
        "condition,lever_m,wanted_deg,mass_kg,person,off_deg,error_deg,slid_m,lost\n"
        "coupled,0.01,30,0.1,1,-3,3,0.001,false\nuncoupled,0.01,30,0.1,1,-30,30,0.03,true\n")
COURSE = ("condition,arm_m,lever_m,t,y,z,turned_rad,slid_m,grip_n\n"
          + "".join(f"{word},0.006,{lever},{t},0,0,-0.1,0.001,1\n" for word in ("coupled", "uncoupled") for lever in (0.003, 0.012) for t in (0, 1)))


PLATE = [((0, 0, 0), (40, 0, 0), (40, 40, 0)), ((0, 0, 0), (40, 40, 0), (0, 40, 0))]
WORDS = "solid plate\n" + "".join(f"vertex {x} {y} {z}\n" for triangle in PLATE for x, y, z in triangle) + "endsolid plate\n"
BINARY = bytes(80) + struct.pack("<I", 2) + b"".join(struct.pack("<12fH", *(0, 0, 1), *sum(triangle, ()), 0) for triangle in PLATE)


def planned(folder, scale, *options, stl=WORDS.encode()):
    """What is said of a stroke over a plate of 40, and its rows."""
    plate = folder / "plate.stl"
    plate.write_bytes(stl)
    done = subprocess.run(["/usr/bin/python3", pathlib.Path(sys.argv[1]) / "tools/picture/stroke.py", plate, "--scale", scale, *options],
                          capture_output=True, text=True, check=False)
    return done.stderr, done.stdout.splitlines()


def strokes(folder):
    said, rows = planned(folder, "0.001", "--seconds", "0.001")  # A time is no fault, however short.
    if said or rows[0] != "t,x,y,z" or len(rows) < 400:
        sys.exit(f"a short stroke: {said}{rows[:3]}")
    # What hapticctl load reads: with less than a triangle behind it, and in capitals too.
    for stl in (BINARY, BINARY + b"\r\n", BINARY + bytes(49), WORDS.upper().encode()):
        if planned(folder, "0.001", "--seconds", "0.001", stl=stl) != (said, rows):
            sys.exit(f"a plate of {len(stl)} bytes is planned otherwise")
    for stl in (BINARY[:-1], BINARY + bytes(50)):
        if planned(folder, "0.001", stl=stl) != (f"stroke: {folder}/plate.stl: is no STL file\n", []):
            sys.exit(f"a plate of {len(stl)} bytes is planned")
    for scale, words in (("0.00001", "nowhere is it level and wide enough to be stroked ("), ("1", "it is 40 m wide ("), ("nan", "it is nan m wide (")):
        said, rows = planned(folder, scale)
        if not said.startswith(f"stroke: {folder}/plate.stl: {words}") or rows:
            sys.exit(f"a plate at {scale} m a unit: {said}")


class Axes:
    """Takes what is plotted instead of drawing it."""

    def __init__(self):
        self.curves = {}

    def plot(self, x, y, *_, label, **_look):
        self.curves[label] = list(zip(x, y))

    def __getattr__(self, name):
        return lambda *_, **_look: None


def walls(script):
    """Each device's walls are its own, also where its encoder is as fine as the ideal one."""
    spec = importlib.util.spec_from_file_location("plot", script)
    plot = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plot)
    names = WALL.splitlines()[0].split(",")
    rows = [dict.fromkeys(names, 1.0) | {"step_m": step, "friction_n": friction, "damping": damping, "off": off}
            for step, friction, off in ((1e-9, 0.0, 100.0), (0.0, 0.0, 200.0), (0.0, 0.1, 300.0)) for damping in (0.0, 5.0)]
    axes = Axes()
    plot.panel(axes, rows)
    for label, off in (("found, ideal encoder, no friction", 100.0), ("found, the device as it is", 300.0)):
        if axes.curves[label] != [(0.0, off), (5.0, off)]:
            sys.exit(f"{label}: {axes.curves[label]}")


def main():
    tools = pathlib.Path(sys.argv[1]) / "tools/haptic-bench"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        strokes(folder)
        walls(tools / "zwidth/plot.py")

        def draw(script, text, output, words):
            given = folder / "given.csv"
            given.unlink(missing_ok=True)
            if text is not None:
                given.write_bytes(text)
            options = [folder / output] if "figure" in script else ["--output", folder / output]
            if "grasp" in script:
                course = folder / "course.csv"
                course.write_text(COURSE, encoding="ascii")
                options += ["--samples", course]
            done = subprocess.run(["/usr/bin/python3", tools / script, given, *options], capture_output=True, text=True, check=False)
            place = f"{script.split('/')[-1]}: {folder / output if 'written' in words else given}: "
            if (done.returncode == 0) != (words == "") or (words and not done.stderr.startswith(place)) or words not in done.stderr:
                sys.exit(f"{script} said of {text}: {done.stderr}")

        for script, whole, wrong in (("load/figure.py", LOAD + CELL, "row 1 is not of"), ("zwidth/plot.py", WALL, "holds nothing"),
                                     ("grasp/plot.py", HELD, "holds nothing")):
            good = whole.format(1000).encode()
            draw(script, None, "out.svg", "cannot be read")
            draw(script, b"\xff\n", "out.svg", "cannot be read")
            draw(script, whole.format("fast").encode(), "out.svg", wrong)
            draw(script, b"a,b\n1,2\n", "out.svg", wrong)
            draw(script, b"a,b\n1,2,3\n", "out.svg", wrong)
            gone = good.replace(b"period p99", b"gone").replace(b",off,", b",gone,").replace(b",error_deg,", b",gone,")
            draw(script, gone, "out.svg", "holds no")
            draw(script, b"\xef\xbb\xbf# cpu: as a spreadsheet saves it\n" + good, "out.svg", "")
            draw(script, good, "none/out.svg", "cannot be written")
            draw(script, good, "out.nonsense", "cannot be written")
        good = WALL.format(1000)
        draw("zwidth/plot.py", (OTHER + good + LOAD + CELL.format(1000)).encode(), "out.svg", "")  # As compare takes it.
        row = good.splitlines(keepends=True)[1]
        other = row.replace("1000,0,", "1000,1,", 1) + row.replace("1000,0,", "2000,0,", 1)  # Without 2000,1: it was ended.
        for given in (good + other, good.replace(row, other)):
            draw("zwidth/plot.py", given.encode(), "out.svg", "")
        draw("zwidth/plot.py", (good + "1,2\n").encode(), "out.svg", "holds nothing")
        draw("zwidth/plot.py", (good + good).encode(), "out.svg", "holds 2 tables of walls")


if __name__ == "__main__":
    main()
