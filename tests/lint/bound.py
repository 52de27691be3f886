#!/usr/bin/python3
"""What runs in real time must be bound when it is loaded: else a thread's first call of each of a library's functions
goes through the dynamic linker, which searches all libraries for it.

Usage: bound.py PROGRAM_OR_LIBRARY... Exits 1 if one of them is bound lazily.
"""
import subprocess
import sys


def is_bound(path):
    listing = subprocess.run(["readelf", "--dynamic", "--wide", path], capture_output=True, text=True, check=True).stdout
    return any("(FLAGS_1)" in line and "NOW" in line.split() for line in listing.splitlines())


def main():
    lazy = [path for path in sys.argv[1:] if not is_bound(path)]
    print("\n".join(f"{path} is bound lazily" for path in lazy) if lazy else f"{len(sys.argv) - 1} are bound when loaded")
    return 1 if lazy or len(sys.argv) == 1 else 0


if __name__ == "__main__":
    sys.exit(main())
