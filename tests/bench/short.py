#!/usr/bin/python3
"""The short set of haptic-bench in two processes, one of them with the processor's best vector instructions, gives the same
errors and the same bits of force; a changed value is named. The errors are those that another machine and compiler had, too
(short.csv). Who changes them on purpose writes them anew, and looks at which and why:
haptic-bench short --csv | grep -v hash > tests/bench/short.csv. Usage: short.py HAPTIC_BENCH"""
import pathlib
import subprocess
import sys
import tempfile


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        first, second, spoilt = (pathlib.Path(folder) / name for name in ("first.csv", "second.csv", "spoilt.csv"))
        for path, instructions in ((first, "portable"), (second, "best")):
            path.write_bytes(subprocess.run([program, "short", "--path", instructions, "--csv"], check=True, capture_output=True).stdout)

        def compare(old, new, *options):
            return subprocess.run([program, "compare", "--errors", *options, old, new], capture_output=True, text=True,
                                  check=False)

        same = compare(first, second, "--hashes")
        elsewhere = pathlib.Path(__file__).with_suffix(".csv")
        worse, better = compare(elsewhere, first), compare(first, elsewhere)
        lines = second.read_text(encoding="ascii").splitlines()
        at = next(i for i, line in enumerate(lines) if ",hash," in line)
        lines[at] = lines[at][:-1] + ("1" if lines[at][-1] != "1" else "2")
        spoilt.write_text("\n".join(lines) + "\n", encoding="ascii")
        different = compare(first, spoilt, "--hashes")
    if same.returncode != 0:
        sys.exit("two runs differ:\n" + same.stdout + same.stderr)
    for what, found in (("worse", worse), ("better", better)):
        if found.returncode != 0:
            sys.exit(f"{what} than on another machine:\n" + found.stdout + found.stderr)
    if different.returncode != 1 or "worse" not in different.stdout:
        sys.exit("a changed hash was not named:\n" + different.stdout + different.stderr)


if __name__ == "__main__":
    main()
