"""What every check uses: running programs, waiting, saying how it went."""
import json
import os
import pathlib
import subprocess
import time

MARK = "VMTEST "
HERE = pathlib.Path("/run/vmtest")
UNIT = "hapticd.service"


class Failed(Exception):
    """A check that did not hold; the text says what was seen."""


def options():
    return json.loads((HERE / "options.json").read_text(encoding="utf-8"))


def run(topic, name, check):
    """Runs a check and prints its line. What it returns are its numbers."""
    begin = time.monotonic()
    line = {"check": f"{topic}.{name}", "ok": True}
    try:
        numbers = check()
        if numbers:
            line["numbers"] = numbers
    except Exception as error:  # also a fault of the check itself: it must not pass, nor end the others
        line["ok"] = False
        line["why"] = f"{type(error).__name__}: {error}"[-2000:]
        line["journal"] = ran("journalctl", "-u", UNIT, "-n", "25", "--no-pager", "-o", "cat", "-b")[1].splitlines()
    line["virtual_s"] = round(time.monotonic() - begin, 2)
    print("\n" + MARK + json.dumps(line), flush=True)


def ensure(condition, *seen):
    if not condition:
        raise Failed(" ".join(str(word) for word in seen))


def ran(*command, user=None, timeout=60):
    """Status, output and errors. `user`: run as that user, with the groups it has."""
    if user:
        command = ("setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups", *command)
    done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False,
                          env={**os.environ, "LC_ALL": "C", "SYSTEMD_PAGER": ""})
    return done.returncode, done.stdout, done.stderr


def text(*command, **options_of_run):
    """Output of a command that is to succeed."""
    status, out, errors = ran(*command, **options_of_run)
    ensure(status == 0, *command, "ended with", status, errors, out)
    return out


def ctl(*words, user="alice", **options_of_run):
    return text("hapticctl", *words, user=user, **options_of_run)


def status_json():
    return json.loads(ctl("--json", "status"))


def device():
    return status_json()["devices"][0]


def unit(key, name=UNIT):
    return text("systemctl", "show", "-P", key, name).strip()


def eventually(condition, what, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        seen = condition()
        if seen:
            return seen
        time.sleep(0.05)
    raise Failed(f"not within {seconds} s: {what}")


def start():
    text("systemctl", "reset-failed", UNIT)
    text("systemctl", "start", UNIT)
    return int(unit("MainPID"))


def restarted(pid, seconds=30.0):
    """Waits until systemd has brought the daemon back after `pid`; the new process."""
    def again():
        return unit("ActiveState") == "active" and int(unit("MainPID")) not in (0, pid)
    eventually(again, "the daemon comes back", seconds)
    return int(unit("MainPID"))


def journal_since(cursor):
    return text("journalctl", "--no-pager", "-o", "cat", "--after-cursor", cursor)


def journal_cursor():
    return text("journalctl", "--no-pager", "-n", "0", "--show-cursor").split("-- cursor: ")[1].strip()


def background(*command, user="alice"):
    """A program that goes on while the check does; the caller ends it."""
    return subprocess.Popen(("setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups", *command),
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
