#!/usr/bin/python3
"""Checks that a shared library exports what its headers declare, and nothing else; and that it stays when it is unloaded.

Usage: symbols.py LIBRARY HEADER_DIRECTORY
"""
import pathlib
import re
import subprocess
import sys


def main():
    library, headers = sys.argv[1], pathlib.Path(sys.argv[2])
    listed = subprocess.run(["nm", "--dynamic", "--defined-only", "--format=posix", library], capture_output=True,
                            text=True, check=True).stdout
    symbols = [line.split() for line in listed.splitlines()]
    exported = {name.split("@")[0] for name, kind, *_ in symbols if kind != "A"}  # A: the version's own name
    declared = set()
    for path in headers.rglob("*.h"):
        declared |= set(re.findall(r"^HAPTIC_API [^(]*?\b(haptic_\w+)\(", path.read_text(encoding="utf-8"), re.M))
    for name in sorted(exported - declared):
        print(f"exported but not declared: {name}")
    for name in sorted(declared - exported):
        print(f"declared but not exported: {name}")
    print(f"{len(exported)} exported, {len(declared)} declared")
    flags = subprocess.run(["readelf", "--dynamic", library], capture_output=True, text=True, check=True).stdout
    stays = re.search(r"\(FLAGS_1\).*\bNODELETE\b", flags) is not None
    if not stays:
        print("dlclose() would take the code from under its threads: -z nodelete is missing")
    return 0 if exported == declared and declared and stays else 1


if __name__ == "__main__":
    sys.exit(main())
