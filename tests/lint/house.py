#!/usr/bin/python3
"""Keeps the house rules of source files: formatted as .clang-format says, at most 500 lines, real-time code free of
names it must not use, no path of a build machine anywhere, and every lane of tools/test in CI.

Usage: house.py ROOT. Prints each breach and exits 1.
"""
import pathlib
import re
import subprocess
import sys

ROOMS = ["proto", "rt", "drivers", "daemon", "libclient", "tools", "tests", "examples"]
CODE = {".h", ".hpp", ".cc", ".c"}
TEXT = CODE | {".py", ".sh", ".md", ".cmake", ".toml", ".capnp", ".txt", ""}
MAX_LINES = 500
NOT_IN_RT = re.compile(r"std::(mutex|lock_guard|condition_variable|shared_ptr|cout|cerr)\b|\bprintf\(|^[^/]*\bthrow\b")
MACHINE_PATH = re.compile(r"/wor" r"k/|/hom" r"e/\w")


def files(root, suffixes):
    for room in ROOMS + ["systemd", "docs"]:
        for path in sorted((root / room).rglob("*")):
            if path.is_file() and path.suffix in suffixes and "__pycache__" not in path.parts:
                yield path


def breaches(root):
    code = list(files(root, CODE))
    for path in code:
        if path.read_text(encoding="utf-8").count("\n") > MAX_LINES:
            yield f"{path.relative_to(root)}: more than {MAX_LINES} lines: two ideas"
    for path in code:
        if path.relative_to(root).parts[0] != "rt":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if NOT_IN_RT.search(line.split("//")[0]):
                yield f"{path.relative_to(root)}:{number}: not in rt: {line.strip()}"
    for path in files(root, TEXT):
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
            if MACHINE_PATH.search(line):
                yield f"{path.relative_to(root)}:{number}: a path of a build machine: {line.strip()}"
    formatted = subprocess.run(["clang-format-14", "--dry-run", "-Werror", *map(str, code)], capture_output=True,
                               text=True, check=False)
    for line in formatted.stderr.splitlines():
        if "error:" in line:
            yield line.replace(str(root) + "/", "").replace("code should be clang-formatted", "run clang-format-14 -i")
    lanes = re.search(r"\$\{\*:-([a-z ]+)\}", (root / "tools/test").read_text(encoding="utf-8")).group(1).split()
    run = re.findall(r"^\./tools/test (.+)$", (root / ".ci/run").read_text(encoding="utf-8"), re.MULTILINE)
    for lane in sorted(set(lanes) - set(" ".join(run).split())):
        yield f".ci/run: leaves out lane {lane} of tools/test"


def main():
    found = list(breaches(pathlib.Path(sys.argv[1]).resolve()))
    print("\n".join(found) if found else "the house is in order")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
