"""The packages: they install under a running systemd, make user and group, and start nothing."""
import grp
import pwd

from guest.report import HERE, ensure, ran, text


def check_packages_install():
    text("dpkg", "-i", *sorted(str(path) for path in (HERE / "packages").glob("*.deb")), timeout=300)
    ensure(pwd.getpwnam("hapticd").pw_dir == "/var/lib/hapticd", pwd.getpwnam("hapticd"))
    ensure("hapticd" in grp.getgrnam("haptic").gr_mem or pwd.getpwnam("hapticd").pw_gid == grp.getgrnam("haptic").gr_gid,
           "hapticd is not of group haptic")
    # Whom the other checks act as: alice may, mallory may not.
    text("useradd", "--create-home", "--groups", "haptic", "alice")
    text("useradd", "--create-home", "mallory")


def check_nothing_is_started():
    for unit in ("hapticd.service", "hapticd.socket", "hapticd-admin.socket"):
        ensure(ran("systemctl", "is-active", unit)[1].strip() == "inactive", unit, "runs after installation")
        ensure(ran("systemctl", "is-enabled", unit)[1].strip() == "disabled", unit, "is enabled by installation")


def check_python_module_loads():
    text("python3", "-B", "-c", "import hapticclient")
