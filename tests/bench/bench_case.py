"""What tests of haptic-bench share: a folder of their own, and the program as a user calls it."""
import csv
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop()


class BenchCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def bench(self, *arguments, code=0):
        done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code == 0 else done.stderr

    def results(self, *arguments):
        """{quantity: [value of each round]}"""
        lines = [line for line in self.bench(*arguments, "--csv").splitlines() if not line.startswith("#")]
        values = {}
        for row in csv.DictReader(lines):
            values.setdefault(row["quantity"], []).append(float(row["value"]))
        return values
