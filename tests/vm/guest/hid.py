"""Played HID devices behind uhid: nodes by the udev rules, forces through hidraw and hidapi, zero when the daemon dies."""
import contextlib
import grp
import json
import os
import pathlib
import signal
import subprocess

from guest import hand
from guest.load import CONFIG
from guest.report import HERE, UNIT, ctl, device, ensure, eventually, restarted, status_json, text, unit

TOLD = pathlib.Path("/run/hid.json")


def told():
    """What the hand feels: the newest whole line."""
    lines = TOLD.read_text(encoding="ascii").splitlines(keepends=True)
    whole = [line for line in lines[-2:] if line.endswith("\n")]
    return json.loads(whole[-1]) if whole else {"t_s": -1, "force_n": [0, 0, 0], "most_n": 0}


def nodes():
    return set(pathlib.Path("/dev").glob("hidraw*"))


@contextlib.contextmanager
def plugged(uris, *words):
    """The played device at real-time priority, as a device is never late, and the daemon with a group of `uris`."""
    text("modprobe", "uhid")
    text("systemctl", "stop", UNIT)
    before = nodes()
    with open(TOLD, "w", encoding="ascii") as out:
        player = subprocess.Popen(["chrt", "--fifo", "55", str(HERE / "haptic-emu"), *words, "--press", "0.03", "--period", "2",
                                   "--every", "0.05"], stdout=out)
    good = CONFIG.read_text(encoding="utf-8")
    try:
        node = eventually(lambda: nodes() - before, "a hidraw node").pop()
        text("udevadm", "settle")
        seen = node.stat()
        ensure(grp.getgrgid(seen.st_gid).gr_name == "haptic" and seen.st_mode & 0o777 == 0o660, node, oct(seen.st_mode), seen.st_gid)
        listed = ", ".join(f'"{uri}"' for uri in uris)
        CONFIG.write_text(good + f'\n[[group]]\nname = "hid"\ndevices = [{listed}]\n', encoding="utf-8")
        text("systemctl", "reset-failed", UNIT)
        text("systemctl", "start", UNIT, timeout=120)
        yield player
    finally:
        CONFIG.write_text(good, encoding="utf-8")
        hand.end(player)
        text("systemctl", "reset-failed", UNIT)
        text("systemctl", "restart", UNIT, timeout=120)


def feels_and_loses(axis, sign, wall, within):
    """Presses on a wall, then kills the daemon: a force along sign * axis, and none `within` seconds after the death."""
    text("systemctl", "reset-failed", UNIT)
    ctl("add", "plane", "--name", "wall", *wall, "--stiffness", "300", "--replace")
    pid = int(unit("MainPID"))
    with hand.armed():
        eventually(lambda: sign * told()["force_n"][axis] > 0.5, "the hand feels the wall", 30)
        most = told()["most_n"]
        ensure(device()["fault"] == 0, device())
        os.kill(pid, signal.SIGKILL)
        killed = told()["t_s"]
        eventually(lambda: told()["t_s"] > killed and told()["most_n"] == 0, "the motors are off", 10)
        after = told()["t_s"] - killed
    restarted(pid)
    ensure(after <= within, "force for", after, "s after the death")
    return {"most_n": round(most, 2), "force_for_s": round(after, 3)}


def check_woodenhaptics():
    with plugged(["woodyhid://woodenhaptics_v2015"], "woodyhid"):
        eventually(lambda: told().get("calibrated"), "the user calibrates it", 30)
        return feels_and_loses(0, 1, ("--at", "-0.005,0,0", "--rotate", "y,90"), 2.0)


def check_joystick_with_pid():
    with plugged(["hidpid://default"], "hidpid"):
        return feels_and_loses(1, -1, ("--at", "0,0.005,0", "--rotate", "x,90"), 2.0)


def check_spacemouse_is_the_deadman():
    """
    Its button is let go for every fifth second: then the device beside it in the group gives no force. A new one: the
    kernel's own driver for the old ones takes them behind USB alone.
    """
    with plugged(["sim://default", "spacemouse://default?deadman=1"], "spacemouse", "new"):
        mouse = status_json()["devices"][1]
        ensure(mouse["uri"].startswith("spacemouse://") and mouse["fault"] == 0, mouse)
        eventually(lambda: not told().get("held", True), "it is let go")
        eventually(lambda: told()["held"], "it is held again")
        with hand.wall(), hand.armed(device()["name"]), hand.pressing():
            eventually(lambda: hand.force_z() > 0.5, "the wall pushes")
            eventually(lambda: not told()["held"], "it is let go", 6)
            eventually(lambda: not device()["armed"] and device()["force"] == [0, 0, 0], "zero when it is let go", 1.0)
