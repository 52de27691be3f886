"""One run of the virtual machine: boots, feeds the payload, reads what the guest says.

-icount gives the guest virtual time: each instruction takes 2 ns, idle time is skipped, and how busy the host is does not
show. Deadlines, priorities and watchdogs can so be asserted. It says nothing of the latency of real hardware. One
processor only: two of them under this emulator wait for each other for milliseconds.

What the guest waits for of the host has no time at all: while a guest is idle its clock leaps, and a disk whose host reads
for a second leaves it a minute behind. So its disks are memory (NVDIMM): a host that is slow there stops the clock too.
"""
import json
import pathlib
import subprocess
import tarfile
import time

QEMU = "qemu-system-x86_64"
COMMAND_LINE = ("console=ttyS0 quiet loglevel=3 panic=-1 no_timer_check tsc=reliable mitigations=off nokaslr "
                "random.trust_cpu=on systemd.show_status=false systemd.log_target=journal-or-kmsg rd.udev.log_level=3 audit=0 "
                "selinux=0 apparmor=0 cryptomgr.notests 8250.nr_uarts=1 lpj=2000000 net.ifnames=0")
MARK = "VMTEST "


# What the guest's kernel asks of a size: a section of memory.
DISK_STEP = 128 * 2**20


def pack(payload, entries):
    """A tar of {name in the guest: path here}, to be read as a raw disk."""
    with tarfile.open(payload, "w") as tar:
        for name, path in sorted(entries.items()):
            tar.add(path, arcname=name, filter=as_root)
    size = pathlib.Path(payload).stat().st_size
    with open(payload, "ab") as file:
        file.truncate(-(-size // DISK_STEP) * DISK_STEP)


def memory_disk(name, path):
    """A file as a disk of the guest; what the guest writes stays in the emulator's memory."""
    size = pathlib.Path(path).stat().st_size
    return ["-object", f"memory-backend-file,id={name},mem-path={path},size={size},share=off,readonly=off",
            "-device", f"nvdimm,id={name}_dimm,memdev={name}"]


def as_root(member):
    member.uid = member.gid = 0
    member.uname = member.gname = "root"
    return None if "__pycache__" in member.name else member


def boot(image, payload, serial, timeout_s, on_line):
    """Runs to the guest's power-off. Returns its reports, in order; each is given to on_line as it comes.

    A guest that does not end in timeout_s is killed; then the last report says late, and not end.
    """
    command = [QEMU, "-M", "q35,usb=off,vmport=off,nvdimm=on", "-accel", "tcg,thread=single,tb-size=512",
               "-icount", "shift=1,align=off,sleep=off", "-rtc", "clock=vm,base=2026-01-01", "-cpu", "max", "-smp", "1",
               "-m", "1G,slots=2,maxmem=4G", "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot",
               "-kernel", image.kernel, "-initrd", image.ramdisk, "-append", COMMAND_LINE,
               *memory_disk("root", image.disk), *memory_disk("payload", payload), "-serial", f"file:{serial}"]
    pathlib.Path(serial).write_bytes(b"")
    reports, seen = [], 0
    with subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL) as qemu:
        end = time.monotonic() + timeout_s
        try:
            while True:
                ended = qemu.poll() is not None
                text = pathlib.Path(serial).read_bytes().decode(errors="replace")
                complete = text.rfind("\n") + 1
                for line in text[seen:complete].splitlines():
                    if MARK in line:
                        reports.append(json.loads(line.split(MARK, 1)[1]))
                        on_line(reports[-1])
                seen = complete
                if ended:
                    return reports
                if time.monotonic() > end:
                    return [*reports, {"late": True}]
                time.sleep(0.2)
        finally:
            if qemu.poll() is None:
                qemu.kill()
