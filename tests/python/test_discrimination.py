#!/usr/bin/python3
"""examples/09-discrimination.py against an observer whose threshold is known. Usage: test_discrimination.py EXAMPLE"""
import io
import math
import pathlib
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np

from program import load

experiment = load(sys.argv.pop())


def settled(noise, seed, reversals=40):
    """Where the staircase of one simulated observer ends."""
    observer = experiment.Observer(noise, np.random.default_rng(seed))
    stairs = experiment.Staircase(0.5, reversals)
    for _ in range(5000):
        if stairs.done:
            break
        stairs.answer(observer.harder(400, 400 * (1 + stairs.level)) == 2)
    return stairs.threshold()


class Stairs(unittest.TestCase):
    def test_settle_where_two_right_answers_are_as_likely_as_not(self):
        # Two observations with that noise: right with Phi(ln(1 + d) / (noise sqrt 2)); two in a row in one of two where it is
        # sqrt(1/2). Steps of a fifth draw the mean at the reversals down by some 0.015.
        for noise in (0.05, 0.15, 0.3):
            mean = math.exp(np.mean([math.log(settled(noise, seed)) for seed in range(200)]))
            right = (1 + math.erf(math.log1p(mean) / noise / 2)) / 2
            self.assertAlmostEqual(right, math.sqrt(0.5), delta=0.025)

    def test_go_down_after_two_right_answers_and_up_after_one_wrong(self):
        stairs, levels = experiment.Staircase(0.5, 4), [0.5]
        for right in (1, 1, 1, 0, 1, 0, 1, 1, 1, 1, 0, 1, 1):
            self.assertFalse(stairs.done)
            stairs.answer(bool(right))
            levels.append(stairs.level)
        c, f = math.log(1.6), math.log(1.2)
        np.testing.assert_allclose(np.diff(np.log(levels)), (0, -c, 0, c, 0, c, 0, -c, 0, -c, f, 0, -f), atol=1e-12)
        np.testing.assert_allclose(stairs.turns, (0.5 / 1.6, 0.8, 0.5 / 1.6, 0.6 / 1.6))
        self.assertTrue(stairs.done)
        self.assertAlmostEqual(stairs.threshold(), 0.6 / 1.6)

    def test_end_below_what_a_device_can_show(self):
        stairs = experiment.Staircase(0.5, 4)
        for _ in range(20):
            stairs.answer(False)
        self.assertEqual(stairs.level, experiment.MOST)
        self.assertLess(experiment.REFERENCE * (1 + experiment.MOST), 2000)


class Resumed(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "results.csv"
        self.stairs = experiment.Staircase(0.5, 11)
        rows = [experiment.COLUMNS]
        for trial, right in enumerate((1, 1, 0, 1, 1, 1, 1, 0, 1), 1):
            row = {"seed": 7, "trial": trial, "t_s": trial, "difference": f"{self.stairs.level:.4f}", "right": right}
            rows.append([row.get(column, 0) for column in experiment.COLUMNS])
            self.stairs.answer(bool(right))
        self.lines = [",".join(map(str, row)) + "\n" for row in rows]

    def resumed(self, lines):
        self.file.write_text("".join(lines), encoding="utf-8")
        stairs = experiment.Staircase(0.5, 11)
        return stairs, experiment.resume(str(self.file), stairs)

    def test_goes_on_where_it_was_broken_off(self):
        stairs, trials = self.resumed(self.lines)
        self.assertEqual((stairs.level, stairs.turns), (self.stairs.level, self.stairs.turns))
        for right in (True, False, True, True):
            stairs.answer(right)
            self.stairs.answer(right)
        self.assertEqual((stairs.level, stairs.turns), (self.stairs.level, self.stairs.turns))
        self.assertEqual((len(trials), trials[-1]["seed"], trials[-1]["t_s"]), (9, "7", "9"))
        self.assertEqual(self.resumed([])[1], [])

    def test_of_a_file_that_is_damaged_names_the_line(self):
        other = self.lines[5].replace("7,", "8,", 1)
        for lines, line in ((self.lines[:4] + self.lines[5:], 5), (self.lines[:8] + [self.lines[8][:12]], 9),
                            (self.lines[:5] + [other] + self.lines[6:], 6), (["a,b\n1,2\n"], 2),
                            ([line.replace("7,", "x,", 1) for line in self.lines], 2),
                            (self.lines[:1] + [self.lines[1].replace("7,1,1,", "7,1,x,")], 2)):
            with self.assertRaisesRegex(SystemExit, f"results.csv, line {line}: it does not follow"):
                self.resumed(lines)

    def test_of_what_is_no_text_is_refused(self):
        self.file.write_bytes("".join(self.lines).encode() + b"\xff\n")
        with self.assertRaisesRegex(SystemExit, "results.csv: no results of this experiment: "):
            experiment.resume(str(self.file), experiment.Staircase(0.5, 11))

    def test_of_a_file_without_its_last_line_end_is_refused(self):
        with self.assertRaisesRegex(SystemExit, "results.csv, line 10: it does not end in a line end"):
            self.resumed(self.lines[:-1] + [self.lines[-1].rstrip("\n")])

    def test_when_all_is_answered_needs_no_device(self):
        stairs, _ = self.resumed(self.lines)
        self.assertEqual(len(stairs.turns), 3)
        last = self.lines[9].replace("7,9,9,", "7,10,10,").replace(self.lines[9].split(",")[3], f"{stairs.level:.4f}")
        self.file.write_text("".join(self.lines + [last]), encoding="utf-8")
        with unittest.mock.patch.object(sys, "argv", ["09", "--reversals", "4", "--resume", str(self.file)]), \
             unittest.mock.patch.object(experiment.haptic, "Client", side_effect=AssertionError("connects")), \
             unittest.mock.patch.object(sys, "stderr", io.StringIO()) as said, \
             unittest.mock.patch.object(sys, "stdout", io.StringIO()) as written:
            self.assertEqual(experiment.main(), 0)
        self.assertRegex(said.getvalue(), "^seed 7, 10 trials: .* harder")
        self.assertEqual(written.getvalue(), "")


class Pressed(unittest.TestCase):
    SAMPLE = [("device", "u4"), ("contact_object", "u8"), ("flags", "u4"), ("missed", "u8"), ("depth_m", "f4"),
              ("force", "f8", 3), ("by_source", "f8", (len(experiment.haptic.Source), 3))]

    def test_counts_its_own_device_and_not_what_carries_the_arm(self):
        armed, drained = experiment.haptic.SampleFlag.ARMED, 0

        def drain():
            nonlocal drained
            drained += 1
            both = np.zeros(2, self.SAMPLE)  # The other one stays at the wall, and has no force.
            both["device"], both["flags"], both["contact_object"], both["depth_m"] = [0, 1], armed, 1, 0.01
            both["force"][1, 2], both["by_source"][1, experiment.haptic.Source.GRAVITY, 2] = 5, 1
            return both if drained <= 15 else both[:1]

        session = unittest.mock.MagicMock()
        session.drain.side_effect = drain
        session.describe.return_value.device_index = 1
        session.latest.return_value = {"missed": 0, "flags": armed}
        touch = experiment.press_once(session, 1, 400)
        self.assertAlmostEqual(touch.stiffness, 400, places=3)
        self.assertAlmostEqual(touch.force, 4, places=6)

    def test_ends_where_forces_are_off(self):
        # Trials without a force were written as if there had been one.
        session, nothing = unittest.mock.MagicMock(), np.zeros(0, self.SAMPLE)
        session.drain.side_effect = [nothing] * 9
        session.latest.return_value = {"missed": 0, "flags": experiment.haptic.SampleFlag.FAULT}
        with self.assertRaisesRegex(SystemExit, "forces are off"):
            experiment.press_once(session, 1, 400)


class Answer(unittest.TestCase):
    def test_is_asked_until_it_is_one(self):
        with unittest.mock.patch.object(sys, "stdin", io.StringIO("3\n\none\n 2 \n")), \
             unittest.mock.patch.object(sys, "stderr", io.StringIO()) as asked:
            self.assertEqual(experiment.ask(), 2)
            self.assertEqual(asked.getvalue().count("?"), 4)
            with self.assertRaises(KeyboardInterrupt):
                experiment.ask()  # the end of input


if __name__ == "__main__":
    unittest.main()
