"""A played Falcon behind vhci_hcd: found by the udev rules, homed, felt through usbfs and libusb; zero when the daemon dies."""
import grp
import json
import os
import pathlib
import signal
import subprocess

from guest import hand
from guest.report import HERE, UNIT, ctl, device, ensure, eventually, journal_cursor, journal_since, ran, restarted, text, unit

FIRMWARE = pathlib.Path("/var/lib/hapticd/falcon.bin")
TOLD = pathlib.Path("/run/falcon.json")
WALL = 500.0  # N/m, 5 mm toward the base
player = None


def play():
    """
    Plugs it in, with a user who homes it and presses 2 cm toward the base, every two seconds. A device is never late: it plays
    at FIFO, and so do the kernel's threads that carry its packets; else our own checks would starve it on one processor.
    """
    global player
    with open(TOLD, "w", encoding="ascii") as out:
        player = subprocess.Popen(["chrt", "--fifo", "55", str(HERE / "haptic-emu"), "falcon", "--press", "0.02", "--period", "2", "--every", "0.05"],
                                  stdout=out)
    carriers = eventually(lambda: ran("pgrep", "vhci_[rt]x")[1].split(), "the kernel's vhci threads")
    for carrier in carriers:
        text("chrt", "--fifo", "--pid", "57", carrier)


def told():
    """What the hand feels: the newest whole line."""
    lines = TOLD.read_text(encoding="ascii").splitlines(keepends=True)
    whole = [line for line in lines[-2:] if line.endswith("\n")]
    return json.loads(whole[-1]) if whole else {"orders": 0, "homed": False, "most_n": 0, "t_s": 0}


def check_udev_gives_it_to_the_group():
    text("modprobe", "vhci_hcd")
    text("systemctl", "stop", UNIT)
    FIRMWARE.write_bytes(bytes(range(256)) * 16)
    os.chmod(FIRMWARE, 0o644)
    play()

    def nodes():
        out = text("udevadm", "trigger", "--dry-run", "--verbose", "--subsystem-match=usb", "--attr-match=idVendor=0403")
        return [path for path in out.splitlines() if path]
    path = eventually(nodes, "the kernel sees a device 0403")[0]
    text("udevadm", "settle")
    node = text("udevadm", "info", "--query=name", "--path", path).strip()
    seen = os.stat("/dev/" + node)
    ensure(grp.getgrgid(seen.st_gid).gr_name == "haptic" and seen.st_mode & 0o777 == 0o660, node, oct(seen.st_mode), seen.st_gid)


def check_it_is_taken_by_itself_and_homed():
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "start", UNIT, timeout=120)
    ensure(device()["uri"].startswith("falcon://"), device())
    eventually(lambda: told()["homed"], "the user homes it", 30)
    ensure(told()["most_n"] == 0, "it has pushed before it was homed", told())


def felt():
    return told()["most_n"]


def check_a_wall_is_felt():
    ctl("add", "plane", "--name", "wall", "--at", "-0.005,0,0", "--rotate", "y,90", "--stiffness", str(WALL), "--damping", "2")
    with hand.armed():
        eventually(lambda: felt() > 1.0, "the hand feels the wall", 30)
        strongest = felt()
        ensure(strongest <= device()["limits"]["force"] * 1.2, strongest, device()["limits"])
        status = device()
    ensure(status["fault"] == 0, status)
    eventually(lambda: felt() == 0, "zero after the holder has gone")
    return {"most_n": strongest, "rate_hz": status["rate_hz"], "stale": status["stale"], "missed": status["missed"]}


def check_zero_after_a_kill():
    text("systemctl", "reset-failed", UNIT)
    begin = journal_cursor()
    with hand.armed():
        ctl("add", "plane", "--name", "wall", "--at", "-0.005,0,0", "--rotate", "y,90", "--stiffness", str(WALL), "--replace")
        eventually(lambda: felt() > 1.0, "the hand feels the wall", 30)
        pid = int(unit("MainPID"))
        os.kill(pid, signal.SIGKILL)
        killed = told()["t_s"]
        eventually(lambda: felt() == 0 and told()["t_s"] > killed, "the motors are off")
        after = told()["t_s"] - killed
    restarted(pid)
    log = journal_since(begin)
    ensure("made safe: falcon://" in log, log)
    ensure(after <= 2.0, "force for", after, "s after the death")
    return {"force_for_s": round(after, 3)}


def check_unplugged_and_plugged_in_again():
    ctl("add", "plane", "--name", "wall", "--at", "-0.005,0,0", "--rotate", "y,90", "--stiffness", str(WALL), "--replace")
    eventually(lambda: told()["homed"], "homed")
    with hand.armed():
        eventually(lambda: felt() > 1.0, "the hand feels the wall", 30)
        hand.end(player)
        eventually(lambda: device()["fault"] != 0 and not device()["armed"], "the daemon notices")
    ensure(unit("ActiveState") == "active", unit("ActiveState"))
    play()
    eventually(lambda: told()["homed"], "found and homed again", 60)
    ensure(told()["most_n"] == 0, "it pushes without being armed", told())


def check_without_it_the_simulator_is_back():
    hand.end(player)
    FIRMWARE.unlink()
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "restart", UNIT, timeout=120)
    ensure(device()["uri"].startswith("sim://"), device())
