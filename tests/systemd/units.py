#!/usr/bin/env python3
"""Checks the units as systemd reads them: units.py UNIT_DIRECTORY SOURCE_DIRECTORY HAPTICD

verify: every directive is known and well formed. security: exposure at most 1.5, of the vendors' libraries 1.8; no driver's
device class is open without its drop-in; a wrong configuration is not started again. sysusers and tmpfiles do what they say
in a scratch root. Each check first shows that it can fail, on a copy with a planted fault.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

MOST_EXPOSURE = 1.5
MOST_VENDOR_EXPOSURE = 1.8  # An executable stack and the machine's own network more than the daemon.
DROP_INS = {  # Where it lies, and the classes it opens.
    "hapticd.service.d/falcon.conf": {"char-usb_device"},
    "hapticd.service.d/hid.conf": {"char-hidraw"},
    "gpio/hapticd-gpio.conf": {"char-gpiochip"},
    "serial/hapticd-serial.conf": {"char-ttyACM", "char-ttyUSB"},
}


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "SYSTEMD_PAGER": "", "LC_ALL": "C"})
    return done.returncode, done.stdout + done.stderr


def verify(directory):
    """What systemd-analyze has to say about our units: lines, empty when all is well."""
    names = ["hapticd.service", "hapticd.socket", "hapticd-admin.socket", "hapticd-vendor.socket",
             "hapticd-vendor@1.service"]
    status, text = run("systemd-analyze", "verify", "--man=no", "--recursive-errors=no",
                       *(os.path.join(directory, name) for name in names))
    lines = [line for line in text.splitlines() if "hapticd" in line]
    return lines or ([] if status == 0 else [text or f"status {status}"])


def exposure(unit):
    status, text = run("systemd-analyze", "security", "--offline=true", "--no-pager", f"--threshold={MOST_EXPOSURE * 10:.0f}", unit)
    found = re.search(r"Overall exposure level for [^:]+: ([0-9.]+)", text)
    if not found:
        sys.exit(f"systemd-analyze security said nothing usable:\n{text}")
    return float(found.group(1)), status == 0


def opened(text):
    """The device classes that a unit or drop-in opens."""
    return set(re.findall(r"(?m)^DeviceAllow=(char-\S+) rw$", text))


def lines_of(path, start):
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        return [line.strip() for line in file if line.startswith(start)]


def main():
    units, source, hapticd = sys.argv[1:]
    faults = []
    with tempfile.TemporaryDirectory() as scratch:
        for name in ("hapticd.service", "hapticd.socket", "hapticd-admin.socket", "hapticd-vendor@.service",
                     "hapticd-vendor.socket"):
            origin = units if name.endswith(".service") else source
            if name == "hapticd-vendor.socket":
                origin = os.path.join(source, "vendor")
            with open(os.path.join(origin, name), encoding="utf-8") as file:
                text = file.read()
            # The installed path is not there yet; the one just built is.
            text = re.sub(r"(?m)^ExecStart=\S+", f"ExecStart={hapticd}{'-vendor' if 'vendor' in name else ''}", text)
            text = re.sub(r"(?m)^ExecStopPost=-\S+", f"ExecStopPost=-{hapticd}-safe", text)
            with open(os.path.join(scratch, name), "w", encoding="utf-8") as file:
                file.write(text)
        with open(os.path.join(scratch, "hapticd.service"), encoding="utf-8") as file:
            if opened(file.read()):
                faults.append("hapticd.service opens device classes that belong into a driver's drop-in")
        os.makedirs(os.path.join(scratch, "hapticd.service.d"))
        for name, classes in DROP_INS.items():
            with open(os.path.join(source, name), encoding="utf-8") as file:
                if opened(file.read()) != classes:
                    faults.append(f"{name} opens something else than {classes}")
            shutil.copy(os.path.join(source, name), os.path.join(scratch, "hapticd.service.d"))
        stops = lines_of(os.path.join(units, "user/hapticd.service"), "ExecStopPost=")
        if len(stops) != 1 or not stops[0].endswith("/hapticd/hapticd-safe %t/hapticd/armed"):
            faults.append(f"user/hapticd.service brings nothing to zero when it has ended: {stops}")
        for start in ("WatchdogSec=", "TimeoutAbortSec=", "LimitRTTIME=", "LimitCORE=", "TimeoutStopSec="):
            ours, theirs = (lines_of(os.path.join(units, name), start) for name in ("hapticd.service", "user/hapticd.service"))
            if ours != theirs or not ours:
                faults.append(f"a user's own daemon has {theirs}, the service {ours}")
        for directory in (units, os.path.join(units, "user")):  # What no second start mends is not started again.
            if lines_of(os.path.join(directory, "hapticd.service"), "RestartPreventExitStatus=") != [
                    "RestartPreventExitStatus=1 2 3 5"]:
                faults.append(f"{directory}/hapticd.service starts hapticd again whatever it said")
        faults += verify(scratch)
        vendor, _ = exposure(os.path.join(scratch, "hapticd-vendor@.service"))
        print(f"exposure of hapticd-vendor@ {vendor}")
        if vendor > MOST_VENDOR_EXPOSURE:
            faults.append(f"exposure of hapticd-vendor@ {vendor} is above {MOST_VENDOR_EXPOSURE}")
        service = os.path.join(scratch, "hapticd.service")
        level, good = exposure(service)
        print(f"exposure {level}")
        if not good or level > MOST_EXPOSURE:
            faults.append(f"exposure {level} is above {MOST_EXPOSURE}")

        # Planted faults: an unknown directive, and the hardening taken away.
        with open(service, encoding="utf-8") as file:
            text = file.read()
        with open(service, "w", encoding="utf-8") as file:
            file.write(re.sub(r"(?m)^(Protect|Private|Restrict|SystemCallFilter|Capability).*\n", "", text)
                       .replace("[Service]", "[Service]\nProtectEverything=yes", 1))
        if not verify(scratch):
            faults.append("verify passes an unknown directive: it checks nothing")
        if exposure(service)[0] <= MOST_EXPOSURE:
            faults.append("security passes a unit without hardening: it checks nothing")

    with tempfile.TemporaryDirectory() as root:
        for kind in ("sysusers", "tmpfiles"):
            os.makedirs(os.path.join(root, f"usr/lib/{kind}.d"))
            shutil.copy(os.path.join(source, f"hapticd.{kind}"), os.path.join(root, f"usr/lib/{kind}.d/hapticd.conf"))
        os.makedirs(os.path.join(root, "etc"))
        users = run("systemd-sysusers", f"--root={root}", "hapticd.conf")
        folders = run("systemd-tmpfiles", "--create", f"--root={root}", "hapticd.conf")
        entry = lines_of(os.path.join(root, "etc/passwd"), "hapticd:")
        members = lines_of(os.path.join(root, "etc/group"), "haptic:")
        if len(entry) != 1 or "nologin" not in entry[0] or len(members) != 1 or "hapticd" not in members[0]:
            faults.append(f"sysusers: {users} {entry} {members}")
        if not os.path.isdir(os.path.join(root, "run/hapticd")):
            faults.append(f"tmpfiles: {folders}")

    with open(os.path.join(source, "60-hapticd.rules"), encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            line = line.strip()
            key = r'[A-Z]+(\{[A-Za-z_/]+\})?(==|!=|\+=|=)"[^"]*"'
            if line and not line.startswith("#") and not re.fullmatch(rf"{key}(, {key})*", line):
                faults.append(f"60-hapticd.rules:{number}: {line}")
            if "uaccess" in line.partition("#")[0]:
                faults.append(f"60-hapticd.rules:{number}: uaccess lets the seat's user in behind the daemon")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
