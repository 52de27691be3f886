#!/usr/bin/python3
"""What haptic-emu takes on its command line and what it refuses. Usage: emu_options_test.py HAPTIC_EMU"""
import subprocess
import sys
import unittest

DEVICES = ("falcon", "woodyhid", "spacemouse", "hidpid")


class Options(unittest.TestCase):
    def refusal(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 2, (arguments, done.stdout, done.stderr))
        self.assertEqual(done.stdout, "", "nothing is played")
        return done.stderr

    def test_numbers_are_finite(self):
        for device in DEVICES:
            for option in ("--press", "--period", "--every"):
                for value in ("nan", "-nan", "inf", "1e999", "0x1", "1 m"):
                    self.assertIn(f"{option}: '{value}' is not a finite number", self.refusal(device, f"{option}={value}"))
        self.assertIn("--port: ", self.refusal("falcon", "--port=nan"))

    def test_numbers_keep_their_bounds(self):
        for device in DEVICES:
            for option, value in (("--press", "-0.001"), ("--press", "0.05"), ("--period", "0.09"), ("--period", "61"),
                                  ("--every", "-1"), ("--every", "1e10")):
                self.assertIn(f"{option}: {value} is out of range: from ", self.refusal(device, f"{option}={value}"))
        for value in ("-1", "8"):
            self.assertIn("--port: ", self.refusal("falcon", f"--port={value}"))

    def test_faults_are_known_before_anything_is_played(self):
        for device in DEVICES:
            for fault, words in (("silnce@1", "there are silence"), ("silence@nan", "no time in seconds"),
                                 ("silence@1+inf", "no length in seconds"), ("unplug@-1", "no time in seconds")):
                self.assertIn(words, self.refusal(device, "--fault", "silence@1+1", fault))


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
