"""
A device behind its vendor's closed SDK, which is played: its library runs in a unit of its own behind a socket, with rights
that the daemon does not have, and whatever dies leaves the motors at zero. The library asks for an executable stack, as SDKs do.
"""
import contextlib
import mmap
import os
import pathlib
import pwd
import re
import shutil
import signal
import struct
import time

from guest import hand
from guest.load import CONFIG
from guest.report import HERE, UNIT, ctl, device, ensure, eventually, journal_cursor, journal_since, ran, restarted, status_json, text, unit

SOCKET = "hapticd-vendor.socket"
SDK, PLAIN = pathlib.Path("/opt/played/libdhd.so.3"), pathlib.Path("/opt/played/libplain.so")
STATE = pathlib.Path("/dev/shm/played-device")  # where unit and test both reach
URI = f"dhd://default?sdk={SDK}"
PLACE, FORCE, NETWORK = (0, 24), (24, 48), (48, 52)
MOST_EXPOSURE = 1.8
good = ""
memory = None


def place(z):
    memory[slice(*PLACE)] = struct.pack("3d", 0, 0, z)


def force():
    return struct.unpack("3d", memory[slice(*FORCE)])


def network():
    return struct.unpack("i", memory[slice(*NETWORK)])[0]


def helper():
    """The one unit of a helper, and its process."""
    lines = text("systemctl", "list-units", "--plain", "--no-legend", "--state=running", "hapticd-vendor@*").splitlines()
    if len(lines) != 1:
        return None
    name = lines[0].split()[0]
    return name, int(unit("MainPID", name))


def prepare():
    global good, memory
    SDK.parent.mkdir(parents=True)
    shutil.copy(HERE / "vendor_sdk.so", SDK)
    shutil.copy(HERE / "vendor_sdk_plain.so", PLAIN)
    STATE.write_bytes(bytes(4096))
    STATE.chmod(0o666)
    with open(STATE, "r+b") as file:
        memory = mmap.mmap(file.fileno(), 4096)
    place(0.02)
    for name in (UNIT, "hapticd-vendor@.service"):
        folder = pathlib.Path(f"/etc/systemd/system/{name}.d")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "played.conf").write_text(f"[Service]\nEnvironment=FAKE_SDK_STATE={STATE}\n", encoding="ascii")
    text("systemctl", "daemon-reload")
    good = CONFIG.read_text(encoding="utf-8")


def configured(uri):
    CONFIG.write_text(good + (f'\n[[group]]\nname = "sdk"\ndevices = ["{uri}"]\n' if uri else ""), encoding="utf-8")
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "restart", UNIT, timeout=120)


def check_within_the_daemons_sandbox_neither_stack_nor_network():
    prepare()
    text("systemctl", "restart", UNIT)
    ensure(unit("ActiveState", SOCKET) == "inactive", "installation or activation has started", SOCKET)
    status, out, errors = ran("hapticctl", "--socket", "/run/hapticd/admin.sock", "arm", URI)
    ensure(status != 0 and "executable stack" in out + errors, status, out, errors)
    ensure(network() == 0, "it was opened all the same")
    configured(f"dhd://default?sdk={PLAIN}")
    ensure(network() == -1, "a library that the daemon has started may use the network:", network())
    ensure(helper() is None, "there is a unit without its socket")


def check_the_daemon_starts_without_it():
    configured(URI)  # systemctl returns when the daemon is ready
    ensure(status_json()["devices"] == [], status_json()["devices"])
    eventually(lambda: f"{URI} missing" in unit("StatusText"), "the status names it")
    status, out, _ = ran("hapticctl", "doctor", user="alice")
    ensure(status != 0 and "missing device" in out and "executable stack" in out, out)


def check_a_unit_of_its_own():
    text("systemctl", "enable", "--now", SOCKET)
    eventually(lambda: status_json()["devices"], "it is found once its process has its own unit", 40)
    ensure(device()["uri"] == URI, device())
    name, pid = eventually(helper, "a running hapticd-vendor@")
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        fields = dict(line.split(":", 1) for line in (task / "status").read_text().splitlines())
        ensure(int(fields["Uid"].split()[0]) == pwd.getpwnam("hapticd-vendor").pw_uid, "user", fields["Uid"])
        ensure(all(int(fields[key], 16) == 0 for key in ("CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb")), fields)
        ensure(fields["NoNewPrivs"].strip() == "1" and fields["Seccomp"].strip() == "2", fields)
    fifo = {(task / "comm").read_text().strip(): os.sched_getparam(int(task.name)).sched_priority
            for task in pathlib.Path(f"/proc/{pid}/task").iterdir()
            if os.sched_getscheduler(int(task.name)) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO}
    ensure(fifo == {"vendor-io": 85}, "FIFO threads:", fifo)
    locked_kb = int(re.search(r"VmLck:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text()).group(1))
    ensure(locked_kb > 1000, "VmLck", locked_kb)
    out = text("systemd-analyze", "security", "--no-pager", name)
    exposure = float(re.search(r"Overall exposure level for [^:]+: ([0-9.]+)", out).group(1))
    ensure(exposure <= MOST_EXPOSURE, "exposure", exposure)
    return {"exposure": exposure, "locked_kb": locked_kb}


def check_stack_and_network_there_alone():
    _, pid = helper()
    daemon = int(unit("MainPID"))

    def stack_of(process):
        return re.search(r"\s([rwxps-]{4}) .*\[stack\]", pathlib.Path(f"/proc/{process}/maps").read_text()).group(1)
    ensure(stack_of(pid) == "rwxp", "the library's stack", stack_of(pid))
    ensure(stack_of(daemon) == "rw-p", "the daemon's stack", stack_of(daemon))
    ensure(network() == 1, "the library has no network")
    families = unit("RestrictAddressFamilies").split()
    ensure(sorted(families) == ["AF_NETLINK", "AF_UNIX"], "the daemon's families", families)
    ensure("played" not in pathlib.Path(f"/proc/{daemon}/maps").read_text(), "the daemon has loaded the library")


@contextlib.contextmanager
def pressed():
    """Armed, and from above 4 mm into the plane, until the motors push; the grip is lifted afterwards."""
    place(0.02)  # before it is armed: a jump is a fault
    time.sleep(0.2)
    with hand.armed():
        press()
        yield
    place(0.02)


def press():
    for step in range(240):
        place(0.02 - step * 1e-4)
        time.sleep(0.002)
    eventually(lambda: force()[2] > 1, "the motors push")


def check_a_wall_is_felt():
    ctl("add", "plane", "--name", "floor", "--stiffness", "500", "--replace")
    with pressed():
        depth = -device()["pose"]["p"][2]
        eventually(lambda: abs(force()[2] - 500 * depth) < 0.1, "Hooke, once it is ramped up")
        felt = force()[2]
        ensure(force()[:2] == (0, 0), force())
    eventually(lambda: force() == (0, 0, 0), "zero after the holder has gone")
    return {"force_n": round(felt, 3), "depth_mm": round(depth * 1e3, 3)}


def check_a_killed_helper_is_a_fault_that_ends_at_zero():
    _, pid = helper()
    with pressed():
        os.kill(pid, signal.SIGKILL)
        begin = time.monotonic()
        eventually(lambda: force() == (0, 0, 0), "the motors are off", 10)
        after = time.monotonic() - begin
        eventually(lambda: device()["fault"] != 0 and not device()["armed"], "the daemon notices")
        named = device()["fault_text"]
    ensure("device" in named, named)
    ensure(after < 2, "force for", after, "s")
    eventually(lambda: (helper() or (0, pid))[1] != pid, "another helper")
    ensure(unit("ActiveState") == "active", unit("ActiveState"))
    with pressed():
        pass
    return {"force_for_s": round(after, 3)}


def check_a_killed_daemon_leaves_zero():
    text("systemctl", "reset-failed", UNIT)
    cursor, pid = journal_cursor(), int(unit("MainPID"))
    with pressed():
        os.kill(pid, signal.SIGKILL)
        begin = time.monotonic()
        while force() != (0, 0, 0) and time.monotonic() < begin + 10:
            time.sleep(0.001)
        after = time.monotonic() - begin
    ensure(after < 0.1, "the helper has let the motors push for", after, "s")  # hapticd-safe alone would take longer
    restarted(pid)
    log = journal_since(cursor)
    ensure(f"made safe: {URI}" in log, log)
    eventually(helper, "one helper again")
    ensure(device()["uri"] == URI and not device()["armed"] and force() == (0, 0, 0), device(), force())
    return {"force_for_s": round(after, 4)}


def check_it_ends_with_the_daemon():
    place(0.02)
    text("systemctl", "stop", UNIT)
    eventually(lambda: ran("pgrep", "-u", "hapticd-vendor")[1] == "", "no process of the library is left")
    ensure("failed" not in text("systemctl", "list-units", "--all", "--no-legend", "hapticd-vendor@*"), "a unit has failed")
    for name in (UNIT, "hapticd-vendor@.service"):
        pathlib.Path(f"/etc/systemd/system/{name}.d/played.conf").unlink()
    text("systemctl", "daemon-reload")
    configured("")
    ensure(device()["uri"].startswith("sim://"), device())
