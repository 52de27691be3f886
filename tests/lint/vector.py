#!/usr/bin/python3
"""Files compiled for wider instructions must not define inline code: the linker could take it from there for everyone,
and the program would die on a processor without them.

Usage: vector.py OBJECT... Looks at the objects named *_avx*; exits 1 if one defines a weak function, or if there is none.
"""
import pathlib
import subprocess
import sys


def weak_functions(path):
    listing = subprocess.run(["nm", "--defined-only", path], capture_output=True, text=True, check=True).stdout
    for line in listing.splitlines():
        _, kind, name = line.split(maxsplit=2)
        if kind in "Wwi":
            yield f"{path}: {name} may be taken for everyone"


def main():
    wide = [path for path in sys.argv[1:] if "_avx" in pathlib.Path(path).name]
    found = [breach for path in wide for breach in weak_functions(path)]
    print("\n".join(found) if found else f"{len(wide)} files with wider instructions, none shared")
    return 1 if found or not wide else 0


if __name__ == "__main__":
    sys.exit(main())
