#!/usr/bin/python3
"""Programs and libraries must be built as they are meant to run.

Bound when loaded: else a real-time thread's first call of each of a library's functions goes through the dynamic linker,
which searches all libraries for it. With no stack to execute, at a place drawn anew each time, and with guards on the stack,
as Debian asks of its packages.

Usage: hardened.py PROGRAM_OR_LIBRARY... Exits 1 and names what is lacking.
"""
import subprocess
import sys


def read(path, *what):
    return subprocess.run(["readelf", "--wide", *what, path], capture_output=True, text=True, check=True).stdout


def lacking(path):
    dynamic, headers, symbols = read(path, "--dynamic"), read(path, "--program-headers", "--file-header"), read(path, "--dyn-syms")
    if not any("(FLAGS_1)" in line and "NOW" in line.split() for line in dynamic.splitlines()):
        yield "is bound lazily"
    if "Type:                              DYN" not in headers:
        yield "is loaded at a fixed place"
    if any("GNU_STACK" in line and "E" in line.split()[-2] for line in headers.splitlines()):
        yield "has an executable stack"
    if "__stack_chk_fail" not in symbols:
        yield "has no guards on its stack"


def main():
    found = [f"{path} {fault}" for path in sys.argv[1:] for fault in lacking(path)]
    print("\n".join(found) if found else f"{len(sys.argv) - 1} are as they should be")
    return 1 if found or len(sys.argv) == 1 else 0


if __name__ == "__main__":
    sys.exit(main())
