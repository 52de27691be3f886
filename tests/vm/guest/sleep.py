"""The machine goes to sleep with a hand pressed against a wall. logind is real, what it starts for sleep only waits.

There is no polkit here, so logind gives the service's user no lock: devices are stopped, but sleep does not wait for it.
"""
import contextlib
import pathlib

from guest import hand
from guest.report import UNIT, device, ensure, eventually, journal_cursor, journal_since, ran, start, text, unit

AWAKE = pathlib.Path("/run/systemd/system/systemd-suspend.service.d/awake.conf")
ASLEEP_S = 10


@contextlib.contextmanager
def logind():
    """Runs, and nobody really sleeps."""
    AWAKE.parent.mkdir(parents=True)
    AWAKE.write_text(f"[Service]\nExecStart=\nExecStart=/bin/sleep {ASLEEP_S}\n", encoding="ascii")
    text("systemctl", "unmask", "systemd-logind.service")
    text("systemctl", "daemon-reload")
    try:
        text("systemctl", "start", "systemd-logind.service", timeout=120)
        yield
    finally:
        ran("systemctl", "stop", "systemd-logind.service")
        AWAKE.unlink()
        text("systemctl", "mask", "systemd-logind.service")
        text("systemctl", "daemon-reload")


def check_what_is_armed_is_stopped_before_the_machine_sleeps():
    with logind():
        text("systemctl", "restart", UNIT)  # It asks logind when it starts.
        pid = start()
        cursor = journal_cursor()
        with hand.wall(), hand.armed(), hand.pressing():
            eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
            text("systemctl", "suspend")
            eventually(lambda: hand.force_z() == 0 and device()["fault"] != 0, "zero and latched before sleep", ASLEEP_S / 2)
            status, _, errors = ran("hapticctl", "arm", "--for", "1", user="alice")
            ensure(status != 0 and "sleep" in errors, "arming before sleep:", status, errors)
        eventually(lambda: "the machine is awake" in journal_since(cursor), "told that it is awake", 60.0)
        ensure(not device()["armed"], "armed by itself", device())
        with hand.armed():
            pass
        ensure(int(unit("MainPID")) == pid, "the daemon is another one")
    ensure("stopped, for the machine goes to sleep" in journal_since(cursor), journal_since(cursor))
