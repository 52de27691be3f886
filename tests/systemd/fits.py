#!/usr/bin/env python3
"""Runs hapticd under the unit's limits and counts: fits.py HAPTICD UNIT

As root that may raise limits it first drops to nobody with RLIMIT_RTPRIO, RLIMIT_MEMLOCK and RLIMIT_RTTIME of the unit and no capability, as the
service runs; there it must obtain real-time scheduling and lock its memory. Threads and locked memory of four device
groups, the builder, sixteen sessions and a deformable mesh of a million triangles must fit into TasksMax and LimitMEMLOCK.
"""
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time

MILLION = 1_000_000
# proto/snapshot.h for a triangle soup: 0.5 M vertices, 0.7 nodes a triangle (0.59 measured), 3 M uploaded vertices.
MESH_BYTES = (12 * MILLION // 2 + (12 + 12) * MILLION + 32 * 7 * MILLION // 10      # the mesh and its tree
              + 4 * (7 * MILLION // 10 + MILLION // 2 + 3 * MILLION + MILLION + 3 * MILLION))  # what moves need
SESSION_BYTES = 700_000  # regions A and B, 550 kB
GROUPS = 4
NOBODY = 65534


def unit_value(unit, key):
    with open(unit, encoding="utf-8") as file:
        found = re.search(rf"(?m)^{key}=(.+)$", file.read())
    return found.group(1)


def as_bytes(text):
    scale = {"K": 2**10, "M": 2**20, "G": 2**30}.get(text[-1])
    return int(text[:-1]) * scale if scale else int(text)


def status_of(pid, key):
    with open(f"/proc/{pid}/status", encoding="utf-8") as file:
        found = re.search(rf"(?m)^{key}:\s+(\d+)", file.read())
    return int(found.group(1)) if found else 0


def children(pid):
    found = []
    for thread in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{thread}/children", encoding="utf-8") as file:
            found += [int(child) for child in file.read().split()]
    return found


def may_raise(memlock):
    """Whether this process may set the unit's limits (CAP_SYS_RESOURCE, which containers often lack)."""
    before = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    try:
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (before[0], max(before[1], memlock) + 4096 if before[1] >= 0 else -1))
    except ValueError:
        return False
    return True


def main():
    hapticd, unit = sys.argv[1:]
    memlock, tasks = as_bytes(unit_value(unit, "LimitMEMLOCK")), int(unit_value(unit, "TasksMax"))
    priority = int(unit_value(unit, "LimitRTPRIO"))
    root = os.getuid() == 0
    as_service = root and may_raise(memlock)
    if not as_service:
        print("limits cannot be raised here: counted as the present user, without the unit's limits")

    def enter():
        if not as_service:
            return
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (memlock, memlock))
        resource.setrlimit(resource.RLIMIT_RTPRIO, (priority, priority))
        resource.setrlimit(resource.RLIMIT_RTTIME, (100_000, 300_000))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.setgroups([])
        os.setresgid(NOBODY, NOBODY, NOBODY)
        os.setresuid(NOBODY, NOBODY, NOBODY)

    faults = []
    with tempfile.TemporaryDirectory() as scratch:
        if as_service:
            os.chown(scratch, NOBODY, NOBODY)
        config = os.path.join(scratch, "hapticd.toml")
        with open(config, "w", encoding="utf-8") as file:
            for i in range(GROUPS):
                file.write(f'[[group]]\nname = "g{i}"\ndevices = ["sim://falcon?serial={i}"]\n')
            if not root:
                file.write("[servo]\nallow_no_rt = true\n")
        log = open(os.path.join(scratch, "log"), "w+", encoding="utf-8")
        daemon = subprocess.Popen([hapticd, "--config", config, "--socket", os.path.join(scratch, "c.sock")], preexec_fn=enter,
                                  env={"MALLOC_ARENA_MAX": "1", "PATH": "/usr/bin"}, stdout=log, stderr=log)
        text = ""
        try:
            for _ in range(300):
                log.seek(0)
                text = log.read()
                if "ready" in text or daemon.poll() is not None:
                    break
                time.sleep(0.05)
            if "ready" not in text:
                sys.exit(f"hapticd did not get ready:\n{text}")
            if as_service and ("SCHED_OTHER" in text or "not locked" in text or text.count("real-time") < GROUPS):
                faults.append(f"without capabilities, within the unit's limits, it is not real-time:\n{text}")
            locked = status_of(daemon.pid, "VmLck") * 1024
            counted = status_of(daemon.pid, "Threads") + sum(status_of(child, "Threads") for child in children(daemon.pid))
            if not children(daemon.pid):
                faults.append("the builder is not there")
            need = locked + MESH_BYTES + 16 * SESSION_BYTES
            print(f"{counted} tasks of {tasks}; {locked >> 20} MiB locked with {GROUPS} groups, {need >> 20} MiB with sessions "
                  f"and a mesh of a million triangles, of {memlock >> 20} MiB")
            if root and locked == 0:
                faults.append("nothing is locked")
            if counted > tasks // 2:
                faults.append(f"{counted} tasks leave too little room under TasksMax={tasks}")
            if need > memlock:
                faults.append(f"{need} bytes do not fit LimitMEMLOCK={memlock}")
        finally:
            daemon.send_signal(signal.SIGTERM)
            daemon.wait(60)
            log.close()
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
