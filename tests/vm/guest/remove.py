"""The packages go, and nothing of them stays."""
import pathlib

from guest.report import HERE, ensure, ran, text


def check_removal_stops_the_service():
    names = [path.name.split("_")[0] for path in (HERE / "packages").glob("*.deb")]
    text("dpkg", "-r", *names, timeout=120)
    for unit in ("hapticd.service", "hapticd.socket", "hapticd-admin.socket", "hapticd-vendor.socket"):
        ensure(ran("systemctl", "is-active", unit)[1].strip() != "active", unit, "still runs")
    ensure(ran("pgrep", "-u", "hapticd")[1] == "", "processes of hapticd are left")
    ensure(pathlib.Path("/etc/hapticd/hapticd.toml").exists(), "removal, not purge, took the configuration")


def check_purge_leaves_nothing():
    text("dpkg", "-P", "hapticd", timeout=120)
    left = [path for path in ("/etc/hapticd", "/var/lib/hapticd", "/run/hapticd", "/usr/libexec/hapticd",
                              "/etc/security/limits.d/hapticd.conf") if pathlib.Path(path).exists()]
    ensure(not left, left)
    out = ran("systemctl", "--failed", "--no-legend", "--plain")[1]
    ensure("hapticd" not in out, out)
