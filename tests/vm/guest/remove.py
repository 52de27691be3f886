"""The packages are replaced under a daemon that works; then they go, and nothing of them stays."""
import pathlib

from guest import hand
from guest.report import HERE, UNIT, device, ensure, eventually, journal_cursor, journal_since, ran, restarted, start, text, unit


def install_again():
    text("dpkg", "-i", str(next((HERE / "packages").glob("hapticd_*.deb"))), timeout=300)


def check_an_upgrade_restarts_an_armed_daemon_disarmed():
    pid = start()
    cursor = journal_cursor()
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        install_again()
        restarted(pid)
    now = device()
    ensure(not now["armed"] and now["force"] == [0, 0, 0], "it came back", now)
    ensure("made safe" not in journal_since(cursor), "hapticd-safe found something to do")


def check_an_upgrade_starts_nothing():
    text("systemctl", "stop", UNIT)
    install_again()
    ensure(unit("ActiveState") == "inactive", "the daemon was stopped, and is", unit("ActiveState"))


def check_removal_stops_the_service():
    names = [path.name.split("_")[0] for path in (HERE / "packages").glob("*.deb")]
    text("dpkg", "-r", *names, timeout=120)
    for each in ("hapticd.service", "hapticd.socket", "hapticd-admin.socket", "hapticd-vendor.socket"):
        ensure(ran("systemctl", "is-active", each)[1].strip() != "active", each, "still runs")
    ensure(ran("pgrep", "-u", "hapticd")[1] == "", "processes of hapticd are left")
    links = [str(path) for path in pathlib.Path("/etc/systemd/system").glob("*.wants/hapticd*")]
    ensure(not links, "links to units that are gone:", links)
    ensure(pathlib.Path("/etc/hapticd/hapticd.toml").exists(), "removal, not purge, took the configuration")


def check_purge_leaves_nothing():
    text("dpkg", "-P", "hapticd", timeout=120)
    left = [path for path in ("/etc/hapticd", "/var/lib/hapticd", "/run/hapticd", "/usr/libexec/hapticd",
                              "/etc/security/limits.d/hapticd.conf") if pathlib.Path(path).exists()]
    ensure(not left, left)
    out = ran("systemctl", "--failed", "--no-legend", "--plain")[1]
    ensure("hapticd" not in out, out)
