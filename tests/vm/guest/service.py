"""The unit as systemd runs it: activation, rights, limits, hardening."""
import os
import pathlib
import re

from guest.report import UNIT, ctl, device, ensure, eventually, ran, status_json, text, unit

MOST_EXPOSURE = 1.5


def check_a_connection_starts_it():
    text("systemctl", "enable", "--now", "hapticd.socket", "hapticd-admin.socket")
    ensure(unit("ActiveState") == "inactive", "the service runs before anybody has connected")
    ctl("list", timeout=120)  # answered before the servo has run the cycles that make it ready
    eventually(lambda: (unit("ActiveState"), unit("SubState")) == ("active", "running"), "active and running")
    ensure(not device()["armed"], "activation has armed the device")


def check_systemctl_start_returns_when_it_is_ready():
    text("systemctl", "stop", UNIT)
    ensure(unit("Result") == "success", "stopping:", unit("Result"))
    text("systemctl", "start", UNIT)  # Type=notify: returns after READY=1, which comes after clean cycles
    ensure(unit("ActiveState") == "active", unit("ActiveState"))
    ensure(device()["cycles"] > 0, device())
    ensure("1000 Hz" in unit("StatusText"), "status text:", unit("StatusText"))


def status_of(task):
    fields = {}
    for line in (task / "status").read_text().splitlines():
        key, _, value = line.partition(":")
        fields[key] = value.strip()
    return fields


def tasks():
    return list(pathlib.Path(f"/proc/{unit('MainPID')}/task").iterdir())


def check_user_and_no_capability():
    for task in tasks():
        fields = status_of(task)
        for set_of in ("CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb"):
            ensure(int(fields[set_of], 16) == 0, fields["Name"], set_of, fields[set_of])
        ensure(fields["NoNewPrivs"] == "1", "NoNewPrivs", fields["NoNewPrivs"])
        ensure(fields["Seccomp"] == "2", "Seccomp", fields["Seccomp"])
        ensure(fields["Uid"].split()[0] != "0", "runs as root")


def check_priorities_are_as_configured():
    seen = {}
    for task in tasks():
        pid = int(task.name)
        name = (task / "comm").read_text().strip()
        seen[name] = (os.sched_getscheduler(pid) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(pid).sched_priority)
    fifo = {name: priority for name, (policy, priority) in seen.items() if policy == os.SCHED_FIFO}
    ensure(sorted(fifo.values()) == [60, 70, 80], "FIFO threads:", seen)
    ensure(all(priority == 0 for policy, priority in seen.values() if policy != os.SCHED_FIFO), seen)
    return fifo


def check_memory_is_locked():
    main = status_of(pathlib.Path(f"/proc/{unit('MainPID')}"))
    locked_kb = int(main["VmLck"].split()[0])
    ensure(locked_kb > 1000, "VmLck", main["VmLck"])
    limits = pathlib.Path(f"/proc/{unit('MainPID')}/limits").read_text()
    most = int(re.search(r"Max locked memory\s+(\d+)", limits).group(1))
    ensure(most == int(unit("LimitMEMLOCK")), "limit", most, "unit", unit("LimitMEMLOCK"))
    ensure(re.search(r"Max realtime priority\s+(\d+)", limits).group(1) == unit("LimitRTPRIO"), limits)
    return {"locked_kb": locked_kb}


def check_doctor_is_green():
    for words in (("hapticctl", "doctor"),):
        status, out, errors = ran(*words, user="alice")
        ensure(status == 0 and "RED" not in out, out, errors)


def check_cpu_latency_is_held():
    ensure(any(os.path.realpath(link) == "/dev/cpu_dma_latency"
               for link in pathlib.Path(f"/proc/{unit('MainPID')}/fd").iterdir()), "not open: /dev/cpu_dma_latency")


def check_exposure():
    out = text("systemd-analyze", "security", "--no-pager", UNIT)
    exposure = float(re.search(r"Overall exposure level for [^:]+: ([0-9.]+)", out).group(1))
    ensure(exposure <= MOST_EXPOSURE, "exposure", exposure)
    return {"exposure": exposure}


def check_nothing_in_the_log_is_an_error():
    out = text("journalctl", "-u", UNIT, "-b", "--no-pager", "-o", "cat")
    bad = [line for line in out.splitlines() if " error " in line or "warn" in line or "Failed" in line]
    ensure(not bad, bad)
    ensure(status_json()["daemon"]["realtime"], status_json()["daemon"])
