"""Emergency stop, dead-man switch and outputs on a simulated GPIO chip, through the kernel and libgpiod."""
import os
import pathlib
import signal
import time

from guest import hand
from guest.load import CONFIG
from guest.report import UNIT, device, ensure, eventually, text, unit

NAMES = ["ESTOP", "DEADMAN", "HOME", "ENABLE", "BEAT", "LED"]
ROLES = ["stop", "deadman", "home", "enable", "heartbeat", "led"]
HERE = pathlib.Path("/sys/kernel/config/gpio-sim/panel")


def line(name):
    chip = (HERE / "bank0/chip_name").read_text().strip()
    return pathlib.Path("/sys/devices/platform") / (HERE / "dev_name").read_text().strip() / chip / f"sim_gpio{NAMES.index(name)}"


def pull(name, up):
    (line(name) / "pull").write_text("pull-up" if up else "pull-down")


def value(name):
    return int((line(name) / "value").read_text())


def check_lines_are_taken():
    text("modprobe", "gpio-sim")
    if not HERE.parent.exists():
        text("mount", "-t", "configfs", "none", "/sys/kernel/config")
    (HERE / "bank0").mkdir(parents=True)
    (HERE / "bank0/num_lines").write_text(str(len(NAMES)))
    (HERE / "bank0/label").write_text("panel")
    for i, name in enumerate(NAMES):
        (HERE / f"bank0/line{i}").mkdir()
        (HERE / f"bank0/line{i}/name").write_text(name)
    (HERE / "live").write_text("1")
    # As hapticd.toml(5) says.
    text("cp", "/usr/share/hapticd/gpio/61-hapticd-gpio.rules", "/etc/udev/rules.d/")
    text("udevadm", "control", "--reload")
    text("udevadm", "trigger", "--settle", "--subsystem-match=gpio")
    text("install", "-D", "-t", "/etc/systemd/system/hapticd.service.d", "/usr/share/hapticd/gpio/hapticd-gpio.conf")
    text("systemctl", "daemon-reload")
    pull("ESTOP", True)
    pull("DEADMAN", True)
    lines = "".join(f'\n[[line]]\nrole = "{role}"\nchip = "panel"\nname = "{name}"\ndebounce_ms = 1\n'
                    for role, name in zip(ROLES, NAMES))
    CONFIG.write_text(CONFIG.read_text(encoding="utf-8") + lines, encoding="utf-8")
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "restart", UNIT)
    eventually(lambda: device()["fault"] == 0, "no fault with a closed stop")


def check_the_stop_cuts_the_force():
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        ensure(value("ENABLE") == 1, "the amplifier is not enabled")
        pull("ESTOP", False)
        time.sleep(0.005)  # virtual; a status costs more than the stop
        ensure(value("ENABLE") == 0, "the amplifier is still enabled")
        now = device()
        ensure(not now["armed"] and now["force"] == [0, 0, 0] and "stop" in now["fault_text"], now)
    pull("ESTOP", True)


def check_the_deadman_too():
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        pull("DEADMAN", False)
        eventually(lambda: not device()["armed"] and device()["force"] == [0, 0, 0], "zero when it is let go", 1.0)
    pull("DEADMAN", True)


def beats(seconds):
    seen, last, end = 0, value("BEAT"), time.monotonic() + seconds
    while time.monotonic() < end:
        now = value("BEAT")
        seen += now != last
        last = now
    return seen


def check_the_heartbeat_ends_with_the_daemon():
    ensure(beats(0.5) >= 25, "the heartbeat does not beat")
    pid = int(unit("MainPID"))
    os.kill(pid, signal.SIGSTOP)
    ensure(beats(0.3) == 0, "it beats without a daemon")
    os.kill(pid, signal.SIGCONT)


def check_a_missing_line_is_named():
    good = CONFIG.read_text(encoding="utf-8")
    CONFIG.write_text(good.replace('"ESTOP"', '"NOSUCH"'), encoding="utf-8")
    text("systemctl", "stop", UNIT)
    begin = text("journalctl", "-n", "0", "--show-cursor").split("-- cursor: ")[1].strip()
    os.system(f"systemctl start {UNIT} 2>/dev/null")
    ensure("NOSUCH" in text("journalctl", "-o", "cat", "--after-cursor", begin), "the journal does not name the line")
    ensure(unit("ActiveState") != "active", "it runs without its emergency stop")
    CONFIG.write_text(good.split("\n[[line]]\nrole")[0] + "\n", encoding="utf-8")
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "start", UNIT)
