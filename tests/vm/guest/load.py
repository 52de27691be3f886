"""The servo under six busy loops and a disk that is written: no overrun, and wake-ups as early as a bare loop's."""
import contextlib
import json
import pathlib
import re
import subprocess
import time

import hapticclient
from guest import hand
from guest.report import HERE, UNIT, ctl, device, ensure, options, text

CONFIG = pathlib.Path("/etc/hapticd/hapticd.toml")
# Six loops with arithmetic, and one that writes and syncs.
BUSY = "import itertools\nfor i in itertools.count(): i * i"
WRITES = "while :; do dd if=/dev/zero of=/var/tmp/written bs=64k count=100 conv=fsync status=none; done"


@contextlib.contextmanager
def busy():
    programs = [subprocess.Popen(["python3", "-S", "-c", BUSY]) for _ in range(6)]
    programs.append(subprocess.Popen(["sh", "-c", WRITES]))
    try:
        yield
    finally:
        for program in programs:
            program.kill()
        for program in programs:
            program.wait()


def bare(rate_hz, seconds):
    """A loop at the servo's priority that only waits and looks at the clock: quantiles of its lateness [ns]."""
    return json.loads(text(str(HERE / "bare_loop"), str(rate_hz), str(seconds), timeout=600))


def configured(rate_hz):
    good = CONFIG.read_text(encoding="utf-8")
    CONFIG.write_text(re.sub(r"(?m)^rate_hz = \d+", f"rate_hz = {rate_hz}", good, count=1), encoding="utf-8")
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "restart", UNIT)
    ensure(device()["rate_hz"] == rate_hz, device())


def statistics(reset=False):
    with contextlib.closing(hapticclient.Client(administration=True)) as client:
        return client.statistics(reset=reset)


def under_load(rate_hz):
    seconds = options()["load_s"]
    configured(rate_hz)
    rows = [(i * 0.05, 0.005 * (i % 7 - 3), 0.005 * (i % 5 - 2), hand.SURFACE - 0.004 * (1 + (i % 11 - 5) / 5)) for i in range(77)]
    with hand.wall(), hand.armed(), hand.wanting(*rows, loop=True), busy():
        loop = bare(rate_hz, min(seconds, 10))
        before = statistics(reset=True)
        time.sleep(seconds)
        after = statistics()
        ensure(device()["armed"], device())
    wake = next(h for h in after.histograms if h.name == "wake")
    cycles = after.cycles - before.cycles
    numbers = {"cycles": cycles, "missed": after.missed - before.missed, "wake_p999_us": wake.p999_ns / 1e3,
               "wake_max_us": wake.max_ns / 1e3, "bare_p999_us": loop["p999_ns"] / 1e3, "bare_max_us": loop["max_ns"] / 1e3}
    ensure(cycles >= 0.99 * seconds * rate_hz, numbers)
    ensure(numbers["missed"] == 0 and after.overruns == before.overruns, numbers)
    # A histogram's step is an eighth at most; the bare loop has no cache to refill and no second real-time thread beside it.
    ensure(wake.p999_ns <= 1.5 * loop["p999_ns"] + 20_000, numbers)
    return numbers


def check_1_khz():
    return under_load(1000)


def check_4_khz():
    return under_load(4000)


def check_back_to_normal():
    configured(1000)
    ctl("status")
