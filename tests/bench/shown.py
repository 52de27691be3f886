#!/usr/bin/python3
"""What haptic-bench shows of its results, and what it says beside them. Usage: shown.py HAPTIC_BENCH"""
import re
import subprocess
import unittest

from bench_case import PROGRAM, BenchCase


class Shown(BenchCase):
    def test_what_is_shown_says_what_it_is(self):
        run = ("run", "-a", "ours", "-m", "plane", "-t", "lissajous:seconds=0.1", "--rounds")
        few, many = self.bench(*run, 5), self.bench(*run, 6)
        self.assertRegex(few, r"b=0\n +median +range +rounds")
        lines = few.splitlines()
        at = next(i for i, line in enumerate(lines) if "median" in line)
        self.assertEqual(lines[at - 1], "run plane lissajous:seconds=0.1 k=1000 mu_s=0 mu_d=0 b=0")
        error = lines[at + 1]  # The columns' names stand above the columns.
        self.assertEqual(error.index(" N^2"), lines[at].index("median") + len("median"))
        self.assertRegex(many, r"b=0\n +median +95 % interval +rounds")
        self.assertRegex(many, r"ours forces +[0-9a-f]{12} hash +1\n")  # What is told once has no interval.
        self.assertRegex(many, r"ours mean +[\d.]+ [nu]s +[\d.e+]+ \.\. +[\d.e+]+ +6\n")
        self.assertRegex(many, r"ours memory +[\d.]+ kB ")  # Whatever a byte is in results.
        self.assertRegex(self.bench(*run, 1), r"b=0\n +value\n.*ours force MSE +[\d.e-]+ N\^2\n")  # One round has no range.
        self.assertIn("b=0 r=0.001\n", self.bench(*run, 1, "--radius", 0.001))  # Another benchmark than with a point.

    def test_several_algorithms_stand_below_one_another(self):
        names = ("ours", "nearest", "local:rate=30,latency=0.01")
        run = ("run", "-a", *names, "-m", "sphere:stacks=8", "-t", "spiral:seconds=0.5", "--rounds")
        said, values = self.bench(*run, 2), self.results(*run, 2)
        lines = said.splitlines()
        heads = [i for i, line in enumerate(lines) if re.match(r" .*(force MSE|median) ", line + " ")]
        self.assertEqual(len(heads), 2, said)
        self.assertTrue(all(len(line) <= 80 for line in lines if not line.startswith("#")), said)  # But for what describes the machine.
        for name in names:
            rows = [line for line in lines if line.startswith(name + " ")]
            self.assertGreater(len(rows), 1)
            at = rows[0].split()[1]
            self.assertAlmostEqual(float(at), values[name + " force MSE"][0], delta=1e-3 * values[name + " force MSE"][0])
        # The columns' names and units stand above the columns.
        end = lines[heads[0]].index("force MSE") + len("force MSE")
        self.assertEqual(lines[heads[0] + 1][end - 3:end], "N^2")
        self.assertNotEqual(lines[heads[0] + 2][end - 1], " ")
        self.assertEqual(lines[heads[0] + 2][end:end + 1].strip(), "")
        self.assertIn("Medians of 2 rounds.", said)
        self.assertNotIn("Medians", self.bench(*run, 1))
        swept = self.bench("sweep", "-a", "ours", "nearest", "-t", "spiral:seconds=0.5", "--stiffness", "500,1000", "--speed", "0.5,2",
                           "--threshold", 0.001, "--rounds", 1)
        self.assertIn("above 0.001 m", swept)
        self.assertEqual({line.split("  ")[0] for line in swept.splitlines() if line.startswith(("ours", "nearest"))},
                         {f"{a} k={k} mu=0 speed={v}" for a in ("ours", "nearest") for k in (500, 1000) for v in (0.5, 2)})

    def test_forces_of_another_unit_are_told(self):
        way = self.folder / "way.csv"
        for unit, told in (("", True), ("_mN", False)):
            way.write_text(f"t,x,y,z,fn{unit}\n" + "".join(f"{i / 1000},{i / 1e5},0,0,{700 + i}\n" for i in range(100)), encoding="ascii")
            done = subprocess.run([PROGRAM, "sweep", "--stiffness", "1000,2000", "-m", "plane", "-t", way, "--out", "--rounds", "1"],
                                  capture_output=True, text=True, check=True)
            self.assertEqual("reach 799 N" in done.stderr, told, done.stderr)
        with open(way, "a", encoding="ascii") as file:
            file.write("1,0,0,0,1")
        done = subprocess.run([PROGRAM, "sweep", "--stiffness", "1000,2000", "-m", "plane", "-t", way, "--out", "--max-gap", "2", "--rounds", "1"],
                              capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr.count("its last line does not end"), 1, done.stderr)  # However often it is read.


if __name__ == "__main__":
    unittest.main()
