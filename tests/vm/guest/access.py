"""Who may talk to the daemon: the group haptic on one socket, root on the other."""
import os
import stat

from guest.report import ctl, device, ensure, ran, text


def check_group_haptic_may():
    ctl("list", user="alice")


def check_others_are_refused():
    status, out, errors = ran("hapticctl", "list", user="mallory")
    ensure(status != 0, "mallory was let in:", out)
    ensure("group haptic" in errors, "does not say why:", errors)


def check_administration_is_roots():
    status, out, _ = ran("hapticctl", "--admin", "limits", "--force", "11", user="alice")
    ensure(status != 0, "alice may raise limits:", out)
    before = device()["limits"]["force"]
    text("hapticctl", "--admin", "limits", "--force", str(before - 1))
    ensure(device()["limits"]["force"] == before - 1, device()["limits"])
    text("hapticctl", "--admin", "limits", "--force", str(before))


def check_modes_of_the_sockets():
    for path, mode in (("/run/hapticd/control.sock", 0o660), ("/run/hapticd/admin.sock", 0o600)):
        seen = stat.S_IMODE(os.stat(path).st_mode)
        ensure(seen == mode, path, oct(seen))
