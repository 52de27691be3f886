"""A hand at work: an armed device, a simulated hand that moves, and what it feels."""
import contextlib
import pathlib
import signal
import tempfile

from guest.report import background, ctl, device, eventually, status_json

STIFFNESS = 500.0  # N/m
SURFACE = -0.010   # m, along z


def force_z():
    return device()["force"][2]


@contextlib.contextmanager
def armed(name=""):
    """Holds the lease and the first device, or that of the name, armed, beyond the ramp."""
    def is_armed():
        return any(d["armed"] for d in status_json()["devices"] if name in ("", d["name"]))
    holder = background("hapticctl", "arm", *([name] if name else []))
    try:
        eventually(is_armed, "the device is armed")
        yield holder
    finally:
        end(holder)


@contextlib.contextmanager
def wanting(*rows, loop=False):
    """The hand wants to be at (t, x, y, z), and stays at the last."""
    with tempfile.NamedTemporaryFile("w", suffix=".csv", delete=False) as file:
        file.write("t,x,y,z\n" + "".join(f"{t},{x},{y},{z}\n" for t, x, y, z in rows))
    pathlib.Path(file.name).chmod(0o644)
    program = background("hapticctl", "hand", *(["--loop"] if loop else []), file.name)
    try:
        yield program
    finally:
        end(program)


@contextlib.contextmanager
def wall():
    ctl("add", "plane", "--name", "wall", "--at", f"0,0,{SURFACE}", "--stiffness", str(STIFFNESS), "--damping", "2", "--replace")
    try:
        yield
    finally:
        with contextlib.suppress(Exception):  # the daemon may have died on purpose: its scene is gone too
            ctl("remove", "wall")


def pressing(depth=0.010):
    """Down to `depth` below the wall in 2 s, then at rest there."""
    return wanting((0, 0, 0, 0), (2, 0, 0, SURFACE - depth), (600, 0, 0, SURFACE - depth))


def end(program):
    if program.poll() is None:
        program.send_signal(signal.SIGINT)
        with contextlib.suppress(Exception):
            program.wait(10)
    if program.poll() is None:
        program.kill()
        program.wait()
    if program.stderr:
        program.stderr.close()
