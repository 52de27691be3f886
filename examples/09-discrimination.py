#!/usr/bin/python3
"""09: a perceptual experiment. Two walls, one after the other: which is harder? Two right answers in a row make the next
difference smaller, a wrong one larger, so that it settles where 71 % are right (Levitt 1971). Each trial is a line of CSV.

    09-discrimination.py > results.csv              a simulated hand, and an observer who judges as people do
    09-discrimination.py --person > results.csv     you: press the wall, lift the hand, press again, lift, answer 1 or 2
    09-discrimination.py --person --resume results.csv >> results.csv      goes on where that was broken off

WARNING: the device moves. Keep the workspace free and hold the handle.
"""
import argparse
import csv
import math
import os
import re
import sys
import time
from typing import Dict, List, NamedTuple

import hapticclient as haptic
import numpy as np

REFERENCE = 400.0  # stiffness of the wall that all are compared with [N/m]
MOST = 3.0  # harder than that no wall becomes, as a part of the reference: devices buzz on the hardest
TOP = -0.02  # of the wall [m]
COLUMNS = ("seed", "trial", "t_s", "difference", "first_N_m", "second_N_m", "felt_first_N_m", "felt_second_N_m", "most_N",
           "limited", "missed", "answer", "right", "response_s")
MISSED = 5  # periods of the servo that a press may lack: more, and the wall was not what it should be


class Staircase:
    """Two down, one up: `level` by a factor, which becomes finer at the third reversal."""

    def __init__(self, level: float, reversals: int) -> None:
        self.level, self.turns, self._wanted, self._right, self._last = level, [], reversals, 0, 0

    def answer(self, right: bool) -> None:
        """Sets the next level."""
        self._right = self._right + 1 if right else 0
        way = -1 if self._right == 2 else 0 if right else 1
        if way == 0:
            return
        self._right = 0
        if way == -self._last:
            self.turns.append(self.level)
        self._last = way
        self.level = min(MOST, self.level * (1.6 if len(self.turns) < 3 else 1.2) ** way)

    @property
    def done(self) -> bool:
        """Whether there are as many reversals as wanted."""
        return len(self.turns) >= self._wanted

    def threshold(self) -> float:
        """Geometric mean of the levels at the reversals, but for the first three."""
        return math.exp(np.mean(np.log(self.turns[3:])))


class Observer:
    """Somebody who takes a wall for harder or softer than it is, by `noise` of its stiffness (a standard deviation)."""

    def __init__(self, noise: float, rng: np.random.Generator) -> None:
        self._noise, self._rng = noise, rng

    def harder(self, first: float, second: float) -> int:
        """1 or 2."""
        judged = np.log([first, second]) + self._rng.normal(0, self._noise, 2)
        return 1 + int(judged[1] > judged[0])


class Press(NamedTuple):
    """What the device did when a wall was pressed: force over depth [N/m], the greatest force [N], whether a limit reduced it,
    and the periods that the servo missed meanwhile."""
    stiffness: float
    force: float
    limited: bool
    missed: int


def press(session: haptic.Session, wall: int, stiffness: float) -> Press:
    """A wall as hard as that, pressed; again, if the servo was late."""
    for _ in range(5):
        touch = press_once(session, wall, stiffness)
        if touch.missed <= MISSED:
            break
        print(f"The servo missed {touch.missed} periods: press the same wall again.", file=sys.stderr, flush=True)
    return touch


def own(session: haptic.Session, samples: np.ndarray) -> np.ndarray:
    """Those of its device: drain() gives others of the group too."""
    return samples[samples["device"] == session.describe().device_index]


def press_once(session: haptic.Session, wall: int, stiffness: float) -> Press:
    """The wall becomes as hard as that while nobody touches it, and is pressed once."""
    session.push_object_material(wall, haptic.Material(stiffness, 0, 0, 0))
    session.drain()
    missed = session.latest()["missed"]
    kept, free_s = [], 0.0
    while not kept or free_s < 0.1:  # until the hand is off it again
        down = len(kept) < 15
        session.push_intent((0, 0, TOP + (-0.008 if down else 0.01)), latest=True)  # of a simulated hand
        time.sleep(0.01)
        samples = own(session, session.drain())
        if not session.latest()["flags"] & haptic.SampleFlag.ARMED:
            sys.exit("forces are off (hapticctl status says why). Once they may be on again, --resume goes on from here")
        touching = samples[samples["contact_object"] == wall]
        kept += [touching] if len(touching) else []
        free_s = 0.0 if len(touching) else free_s + 0.01
    touched = np.concatenate(kept)
    depth = touched["depth_m"].astype(float)
    force = touched["force"][:, 2] - touched["by_source"][:, haptic.Source.GRAVITY, 2]  # What carries the arm is no wall.
    limited = bool((touched["flags"] & (haptic.SampleFlag.LIMITED | haptic.SampleFlag.SATURATED)).any())
    return Press(float(force @ depth / (depth @ depth)), float(force.max()), limited,
                 int(touched["missed"].max() - missed))


def resume(path: str, stairs: Staircase) -> List[Dict[str, str]]:
    """The trials of a file, answered once more."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            lines = file.readlines()
        trials = list(csv.DictReader(lines))
    except (UnicodeDecodeError, csv.Error) as error:
        sys.exit(f"{path}: no results of this experiment: {error}")
    for line, trial in enumerate(trials, 2):
        whole = tuple(trial) == COLUMNS and None not in trial.values()
        wanted = (trials[0].get("seed"), str(line - 1), f"{stairs.level:.4f}")
        whole = whole and re.fullmatch("[0-9]{1,18}", trial["seed"]) and re.fullmatch(r"[0-9]{1,9}(\.[0-9]*)?", trial["t_s"])
        if not whole or (trial["seed"], trial["trial"], trial["difference"]) != wanted:
            sys.exit(f"{path}, line {line}: it does not follow from the lines before it: is it whole, and of one experiment?")
        stairs.answer(trial["right"] == "1")
    if lines and not lines[-1].endswith("\n"):  # What is appended to it would go on in that line.
        sys.exit(f"{path}, line {len(lines)}: it does not end in a line end: is it whole? If so, add one: echo >> {path}")
    return trials


def report(seed: int, trials: int, stairs: Staircase) -> None:
    """Says what came out; standard output is for the trials."""
    print(f"seed {seed}, {trials} trials: {100 * stairs.threshold():.0f} % harder is told in 71 of 100", file=sys.stderr)


def ask() -> int:
    """1 or 2, from whoever sits there; standard output is for the results."""
    while True:
        print("Which was harder, 1 or 2? ", end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline()
        if not line:
            raise KeyboardInterrupt
        if line.strip() in ("1", "2"):
            return int(line)


def main() -> int:
    parser = argparse.ArgumentParser(description="Which of two walls is harder?")
    parser.add_argument("--person", action="store_true", help="you answer, with 1 or 2")
    parser.add_argument("--reversals", type=int, default=11, help="after as many the experiment ends, 4 at least (%(default)s)")
    parser.add_argument("--noise", type=float, default=0.15,
                        help="of the simulated observer, as a part of the stiffness (%(default)s)")
    parser.add_argument("--seed", type=int, help="for the same order of walls again; else drawn, and a column of the results")
    parser.add_argument("--resume", metavar="FILE", help="of an experiment that was broken off; new trials alone are written")
    options = parser.parse_args()
    if options.reversals < 4:
        parser.error("--reversals: the first three are not counted, so 4 at least")
    if not 0 < options.noise < 10:
        parser.error("--noise: more than 0 and less than 10")
    if options.seed is not None and options.seed < 0:
        parser.error("--seed: 0 or more")
    stairs, off = Staircase(0.5, options.reversals), []
    before = resume(options.resume, stairs) if options.resume else []
    seed = options.seed if options.seed is not None else int(np.random.default_rng().integers(1 << 31))
    if before and options.seed not in (None, int(before[0]["seed"])):
        parser.error(f"--seed: the experiment that is resumed has {before[0]['seed']}")
    if before:
        seed = int(before[0]["seed"])
    if stairs.done:  # All was answered before: no device is needed.
        report(seed, len(before), stairs)
        return 0
    trial, start = len(before), time.monotonic() - (float(before[-1]["t_s"]) if before else 0)
    tell = (lambda words: print(words, file=sys.stderr, flush=True)) if options.person else (lambda words: None)
    rows = csv.writer(sys.stdout)
    if not options.resume or os.path.getsize(options.resume) == 0:
        rows.writerow(COLUMNS)
    with haptic.Client(name="09-discrimination") as client, client.open_session() as session:
        wall = client.scene.create("wall", haptic.ShapeKind.BOX, (0.06, 0.06, 0.02), pose=haptic.Pose((0, 0, TOP - 0.02)))
        session.push_intent((0, 0, TOP + 0.01), latest=True)
        session.arm()
        tell(f"Lift the handle above {1000 * TOP:.0f} mm, and hold it: forces begin in some two seconds.")
        while session.latest()["flags"] & (haptic.SampleFlag.RAMPING | haptic.SampleFlag.WAITING):
            time.sleep(0.01)
        while not stairs.done:
            trial, difference = trial + 1, stairs.level
            walls = [REFERENCE, REFERENCE * (1 + difference)]
            rng = np.random.default_rng((seed, trial))  # of this trial, whichever were before it
            if rng.integers(2):
                walls.reverse()
            felt = []
            for name, stiffness in zip(("first", "second"), walls):
                tell(f"Trial {trial}: press the {name} wall, and lift the hand.")
                felt.append(press(session, wall, stiffness))
            asked = time.monotonic()
            answer = ask() if options.person else Observer(options.noise, rng).harder(felt[0].stiffness, felt[1].stiffness)
            now = time.monotonic()
            right = answer == (1 if walls[0] > walls[1] else 2)
            stairs.answer(right)
            off += [abs(touch.stiffness / stiffness - 1) for touch, stiffness in zip(felt, walls)
                    if not touch.limited and touch.missed <= MISSED]
            rows.writerow((seed, trial, f"{now - start:.3f}", f"{difference:.4f}", *(f"{stiffness:.1f}" for stiffness in walls),
                           *(f"{touch.stiffness:.1f}" for touch in felt), f"{max(touch.force for touch in felt):.2f}",
                           int(any(touch.limited for touch in felt)), sum(touch.missed for touch in felt), answer, int(right),
                           f"{now - asked:.3f}"))
            sys.stdout.flush()  # an experiment that is broken off keeps its trials
    report(seed, trial, stairs)
    if not off:
        sys.exit("no press was free of limits and of missed periods")
    print(f"walls were off by {100 * max(off):.1f} % at most", file=sys.stderr)
    return 0 if max(off) < 0.05 else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except haptic.HapticError as error:
        sys.exit(str(error))
    except OSError as error:
        sys.exit(f"{error.filename or 'results'}: {error.strerror}")
    except KeyboardInterrupt:
        sys.exit(130)
