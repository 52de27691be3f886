"""The disk of the virtual machine: Debian's PREEMPT_RT kernel and a small Debian 12 under systemd, from packages alone.

Nothing is mounted and no loop device is used, so that it also works in a container. What has been made is kept in the work
folder and made anew only when the kernel, the list of packages or this file changes.
"""
import hashlib
import pathlib
import re
import shutil
import subprocess

import gpio_module
import machine

KERNEL_METAPACKAGE = "linux-image-rt-amd64"
SUITE = "bookworm"
# What the guest has besides what our own packages ask for.
GUEST_PACKAGES = ["systemd", "systemd-sysv", "udev", "kmod", "dbus", "procps", "util-linux", "python3", "libgpiod2",
                  "libusb-1.0-0", "libhidapi-hidraw0", "libhidapi-libusb0"]
LEFT_OUT = ["/usr/share/doc/*", "/usr/share/man/*", "/usr/share/locale/*", "/usr/share/info/*", "/usr/share/lintian/*"]
BOOT_MODULES = ["nfit", "nd_pmem", "crc32c_generic", "ext4"]
GUEST_MODULES = BOOT_MODULES + ["uhid", "hid_generic", "usbhid", "vhci_hcd", "configfs", "autofs4"]
# Not wanted in a machine that lives for two minutes; each costs seconds of emulation.
MASKED = ["systemd-udev-settle.service", "systemd-journal-flush.service", "systemd-update-utmp.service",
          "systemd-update-utmp-runlevel.service", "systemd-random-seed.service", "systemd-pcrphase.service",
          "systemd-pcrphase-sysinit.service", "systemd-pstore.service", "systemd-hwdb-update.service",
          "systemd-binfmt.service", "systemd-timesyncd.service", "systemd-networkd.service", "systemd-logind.service",
          "systemd-firstboot.service", "systemd-user-sessions.service", "getty.target", "apt-daily.timer",
          "apt-daily-upgrade.timer", "dpkg-db-backup.timer", "e2scrub_all.timer", "e2scrub_reap.service",
          "fstrim.timer", "systemd-tmpfiles-clean.timer", "systemd-ask-password-wall.path",
          "systemd-ask-password-console.path", "sys-kernel-debug.mount", "sys-kernel-tracing.mount",
          "dev-hugepages.mount", "dev-mqueue.mount", "proc-sys-fs-binfmt_misc.automount"]
# One unit runs the tests, on the serial line, and switches off.
TEST_UNIT = """[Unit]
Description=Tests of hapticd in a virtual machine
Requires=basic.target
After=basic.target systemd-udevd.service systemd-udev-trigger.service dbus.socket
[Service]
Type=oneshot
ExecStartPre=/bin/mkdir -p /run/vmtest
ExecStartPre=/bin/tar -x -m -C /run/vmtest -f /dev/payload
Environment=PYTHONPATH=/run/vmtest
ExecStart=/usr/bin/python3 -B -m guest.run
StandardOutput=tty
StandardError=tty
TTYPath=/dev/ttyS0
TimeoutStartSec=infinity
ExecStopPost=/bin/systemctl --no-block poweroff -ff
[Install]
WantedBy=multi-user.target
"""
INIT = """#!/bin/busybox sh
b=/bin/busybox
$b mount -t devtmpfs dev /dev
while read -r module; do $b insmod "$module"; done < /modules
# The disks come in no order; the one without a file system is the payload.
for disk in /dev/pmem*; do $b mount -t ext4 -o rw "$disk" /newroot 2>/dev/null || $b ln -s "$disk" /dev/payload; done
$b mount --move /dev /newroot/dev
exec $b switch_root /newroot /usr/lib/systemd/systemd
"""


def run(*command, **options):
    return subprocess.run([str(word) for word in command], check=True, **options)


def output(*command):
    return run(*command, capture_output=True, text=True).stdout


def kernel_release():
    """The release that the metapackage depends on today: it moves with security updates."""
    found = re.search(r"Depends: linux-image-(\S+-rt-amd64)", output("apt-cache", "depends", KERNEL_METAPACKAGE))
    if not found:
        raise RuntimeError(f"apt-cache depends {KERNEL_METAPACKAGE} names no kernel; is main in the list of sources?")
    return found.group(1)


def mirror():
    for line in output("apt-get", "indextargets", "--format", "$(REPO_URI) $(RELEASE) $(COMPONENT)",
                       "Created-By: Packages").splitlines():
        uri, release, component = line.split()
        if component == "main" and release in (SUITE, "oldstable", "stable"):
            return uri
    raise RuntimeError(f"no {SUITE} main among the sources of apt")


def wanted_by(debs):
    """Packages of Debian that ours depend on, the first of each choice."""
    ours, wanted = set(), set()
    for deb in debs:
        ours.add(output("dpkg-deb", "-f", deb, "Package").strip())
        for entry in output("dpkg-deb", "-f", deb, "Depends").strip().split(","):
            name = entry.split("|")[0].split("(")[0].strip()
            if name:
                wanted.add(name)
    return sorted(wanted - ours)


class Image:
    """Kernel, small initial ramdisk and disk, made where they are missing."""

    def __init__(self, work, debs, log):
        self.work = pathlib.Path(work)
        self.log = log
        self.release = kernel_release()
        self.packages = sorted({*GUEST_PACKAGES, *wanted_by(debs)})
        recipe = pathlib.Path(__file__).read_bytes() + pathlib.Path(gpio_module.__file__).read_bytes() + repr((self.release, self.packages)).encode()
        self.base = self.work / f"base-{hashlib.sha256(recipe).hexdigest()[:16]}"
        self.kernel, self.ramdisk, self.disk = (self.base / name for name in ("vmlinux", "initrd", "disk.ext4"))
        if not (self.base / "complete").exists():
            self._build()

    def _build(self):
        for old in self.work.glob("base-*"):
            shutil.rmtree(old)
        self.base.mkdir(parents=True)
        self.log(f"kernel {self.release}")
        self._kernel()
        self.log(f"root file system of {len(self.packages)} packages and what they need")
        self._root()
        self.log("disk")
        self._disk()
        shutil.rmtree(self.base / "root")
        shutil.rmtree(self.base / "unpacked")
        (self.base / "complete").touch()

    def _kernel(self):
        unpacked = self.base / "unpacked"
        run("apt-get", "download", "-qq", f"linux-image-{self.release}", cwd=self.base, stderr=subprocess.DEVNULL)
        deb = next(self.base.glob("linux-image-*.deb"))
        run("dpkg-deb", "-x", deb, unpacked)
        deb.unlink()
        run("depmod", "-b", unpacked, self.release)
        # The ELF inside the compressed kernel: QEMU starts it directly, and the guest need not unpack it.
        packed = (unpacked / "boot" / f"vmlinuz-{self.release}").read_bytes()
        start = packed.index(b"\xfd7zXZ\x00")
        plain = subprocess.run(["xz", "-dc"], input=packed[start:], capture_output=True, check=False).stdout
        if not plain.startswith(b"\x7fELF"):  # xz complains of what follows the stream; only the result counts
            raise RuntimeError("no ELF image in the kernel package")
        self.kernel.write_bytes(plain)

    def _modules_of(self, names):
        """Paths below lib/modules, in the order in which they can be loaded."""
        paths = []
        for name in names:
            for line in output("modprobe", "-d", self.base / "unpacked", "-S", self.release, "--show-depends",
                               name).splitlines():
                if line.startswith("insmod "):
                    path = line.split()[1].split("/lib/modules/")[1]
                    if path not in paths:
                        paths.append(path)
        return paths

    def _copy_modules(self, names, to):
        paths = self._modules_of(names)
        for path in paths:
            target = to / "usr/lib/modules" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(self.base / "unpacked/lib/modules" / path, target)
        for name in ("modules.order", "modules.builtin", "modules.builtin.modinfo"):
            shutil.copy(self.base / "unpacked/lib/modules" / self.release / name, to / "usr/lib/modules" / self.release)
        return paths

    def _root(self):
        root = self.base / "root"
        run("mmdebstrap", "--quiet", "--variant=minbase", '--aptopt=APT::Install-Recommends "false"',
            *(f"--dpkgopt=path-exclude={path}" for path in LEFT_OUT), "--include=" + ",".join(self.packages), SUITE, root,
            mirror())
        self._copy_modules(GUEST_MODULES, root)
        gpio_module.build(self.release, root / "usr/lib/modules" / self.release / "extra")
        run("depmod", "-b", root, self.release)
        (root / "etc/machine-id").write_text("", encoding="ascii")
        (root / "etc/hostname").write_text("vmtest\n", encoding="ascii")
        (root / "etc/fstab").write_text("", encoding="ascii")
        units = root / "etc/systemd/system"
        for unit in MASKED:
            (units / unit).unlink(missing_ok=True)
            (units / unit).symlink_to("/dev/null")
        (units / "vmtest.service").write_text(TEST_UNIT, encoding="ascii")
        wants = units / "multi-user.target.wants"
        wants.mkdir(exist_ok=True)
        (wants / "vmtest.service").symlink_to("../vmtest.service")
        for path in (root / "var/cache/apt", root / "var/lib/apt/lists"):
            shutil.rmtree(path, ignore_errors=True)
        shutil.rmtree(root / "dev", ignore_errors=True)
        (root / "dev").mkdir()

    def _disk(self):
        root = self.base / "root"
        step = machine.DISK_STEP // 2**20
        megabytes = -(-(int(output("du", "-sm", root).split()[0]) + 192) // step) * step
        run("mke2fs", "-q", "-t", "ext4", "-O", "^has_journal", "-E", "root_owner=0:0", "-d", root, self.disk,
            f"{megabytes}M", stdout=subprocess.DEVNULL)
        small = self.base / "small"
        for name in ("bin", "dev", "newroot"):
            (small / name).mkdir(parents=True)
        shutil.copy("/bin/busybox", small / "bin")
        paths = self._copy_modules(BOOT_MODULES, small)
        (small / "modules").write_text("".join(f"/usr/lib/modules/{path}\n" for path in paths), encoding="ascii")
        (small / "init").write_text(INIT, encoding="ascii")
        (small / "init").chmod(0o755)
        names = "\n".join(str(path.relative_to(small)) for path in sorted(small.rglob("*")))
        with open(self.ramdisk, "wb") as file:
            run("cpio", "-o", "-H", "newc", "-R", "0:0", "--quiet", input=names.encode(), stdout=file, cwd=small)
        shutil.rmtree(small)
