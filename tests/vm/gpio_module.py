"""gpio-sim for Debian's kernel, which leaves it out: built from Debian's own kernel source and headers, unpacked, not installed."""
import pathlib
import shutil
import subprocess
import tempfile

SOURCE = "linux-source-6.1"
FILES = ["drivers/gpio/gpio-sim.c", "drivers/gpio/gpiolib.h", "kernel/irq/irq_sim.c"]


def run(*command, **options):
    return subprocess.run([str(word) for word in command], check=True, **options)


def build(release, target):
    """Puts gpio-sim.ko and irq_sim.ko for the kernel `release` into the folder `target`."""
    common = release.removesuffix("rt-amd64") + "common-rt"
    headers = [f"linux-headers-{release}", f"linux-headers-{common}", "linux-kbuild-6.1"]
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        run("apt-get", "download", "-qq", SOURCE, *headers, cwd=scratch, stderr=subprocess.DEVNULL)
        tree = scratch / "headers"
        for name in headers:
            run("dpkg-deb", "-x", next(scratch.glob(f"{name}_*.deb")), tree)
        include = tree / "usr/src"
        (include / f"linux-headers-{release}/Makefile").write_text(f"include {include}/linux-headers-{common}/Makefile\n",
                                                                   encoding="ascii")
        with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", next(scratch.glob(f"{SOURCE}_*.deb"))],
                              stdout=subprocess.PIPE) as package:
            run("tar", "-x", "-C", scratch, f"./usr/src/{SOURCE}.tar.xz", stdin=package.stdout)
        run("tar", "-x", "-C", scratch, "-f", scratch / f"usr/src/{SOURCE}.tar.xz", *(f"{SOURCE}/{name}" for name in FILES))
        module = scratch / "module"
        module.mkdir()
        for name in FILES:
            shutil.copy(scratch / SOURCE / name, module)
        simulated = module / "irq_sim.c"
        text = simulated.read_text(encoding="utf-8")
        called = "handle_simple_irq(irq_to_desc(irqnum))"  # not exported to modules
        if called not in text:
            raise RuntimeError("irq_sim.c is not the one that this was written for")
        simulated.write_text(text.replace(called, "generic_handle_irq(irqnum)") +
                             '\n#include <linux/module.h>\nMODULE_LICENSE("GPL");\n', encoding="utf-8")
        (module / "Kbuild").write_text("obj-m := gpio-sim.o irq_sim.o\n", encoding="ascii")
        run("make", "-s", "-C", include / f"linux-headers-{release}", f"M={module}", "modules", stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        target.mkdir(parents=True, exist_ok=True)
        for name in ("gpio-sim.ko", "irq_sim.ko"):
            shutil.copy(module / name, target)
