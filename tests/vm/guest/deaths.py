"""The daemon dies with a hand pressed against a wall: of a signal, of SIGKILL, of a servo that stands still or never waits.

Each time the device stands in the list of armed ones, hapticd-safe is run for it, the list is empty afterwards and systemd
has brought the daemon back disarmed. A simulated device's force ends with the daemon; its mechanism is just that.
"""
import os
import pathlib
import signal

from guest import hand, tracing
from guest.report import UNIT, device, ensure, eventually, journal_cursor, journal_since, ran, restarted, text, unit


def dies(how, says, seconds=30.0):
    """Presses, calls how(pid), and checks what followed."""
    text("systemctl", "reset-failed", UNIT)
    cursor = journal_cursor()
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        ensure(armed_list() == ["sim://default"], "armed list", armed_list())
        pid = int(unit("MainPID"))
        how(pid)
        restarted(pid, seconds)
    now = device()
    ensure(not now["armed"] and now["force"] == [0, 0, 0], "it came back", now)
    log = journal_since(cursor)
    for line in (says, "made safe: sim://default"):
        ensure(line in log, f"'{line}' is not in the journal:", log)
    ensure(armed_list() == [], "armed list", armed_list())


def armed_list():
    return [line for line in pathlib.Path("/run/hapticd/armed").read_text(encoding="ascii").splitlines() if line.strip()]


def check_a_proper_end_leaves_nothing_to_do():
    cursor = journal_cursor()
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        text("systemctl", "restart", UNIT)
    ensure("made safe" not in journal_since(cursor), "hapticd-safe found something to do")
    eventually(lambda: armed_list() == [], "the list is empty")


def check_disarming_takes_it_off_the_list():
    with hand.armed():
        ensure(armed_list() == ["sim://default"], "armed list", armed_list())
    eventually(lambda: armed_list() == [], "the list is empty")
    status, _, errors = ran("/usr/libexec/hapticd/hapticd-safe", user="hapticd")
    ensure(status == 3 and "another process" in errors, "beside a daemon that lives:", status, errors)


def servo_of(pid):
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if os.sched_getparam(int(task.name)).sched_priority == 80:
            return int(task.name)
    raise ProcessLookupError(f"process {pid} has no servo")


def check_killed():
    dies(lambda pid: os.kill(pid, signal.SIGKILL), "status=9/KILL")


def check_crashed():
    dies(lambda pid: os.kill(pid, signal.SIGSEGV), "status=11/SEGV")


def check_a_servo_that_stands_still_is_noticed():
    dies(lambda pid: tracing.stall(servo_of(pid)), "Watchdog timeout")


def check_a_servo_that_never_waits_is_ended():
    dies(lambda pid: tracing.spin(servo_of(pid)), "status=24/XCPU")


def check_stopped_as_a_whole():
    dies(lambda pid: os.kill(pid, signal.SIGSTOP), "Watchdog timeout")
