#!/usr/bin/python3
"""Queries of a mesh must ask for memory before they need it: a compiler may take a function that only does so for one
without effect, and leave it out without a word. (A tick at a million triangles then takes a tenth longer.)

Usage: fetches.py OBJECT... Looks at the objects of the queries; exits 1 if one of them fetches nothing ahead, or is missing.
"""
import pathlib
import subprocess
import sys

QUERIES = ("ball_over_mesh", "mesh_sweep", "nearest_on_mesh", "vicinity")
FETCH = ("prefetch", "prfm")  # x86-64, AArch64


def fetches(path):
    listing = subprocess.run(["objdump", "--disassemble", "--no-show-raw-insn", path], capture_output=True, text=True,
                             check=True).stdout
    return any(name in listing for name in FETCH)


def main():
    objects = {pathlib.Path(path).name.split(".")[0]: path for path in sys.argv[1:]}
    lacking = [name for name in QUERIES if name not in objects or not fetches(objects[name])]
    print("\n".join(f"{objects.get(name, name)}: fetches nothing ahead" for name in lacking) if lacking
          else f"{len(QUERIES)} queries fetch ahead")
    return 1 if lacking else 0


if __name__ == "__main__":
    sys.exit(main())
