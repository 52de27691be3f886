#!/usr/bin/python3
"""08: haptic pool. The hand is the cue: what it presses into a ball becomes the ball's momentum. The ball slides over the
cloth, rolls on, meets the other ball and the cushions. A hand of your own plays longer: 08-pool.py --seconds 60

WARNING: the device moves. Keep the workspace free and hold the handle.
"""
import argparse
import math
import sys
import time

import hapticclient as haptic
import numpy as np

R, MASS, INERTIA = 0.012, 0.1, 0.4 * 0.1 * 0.012**2  # of a ball [m, kg, kg m^2]
HALF, CLOTH = np.array([0.07, 0.05]), -0.03  # of the table, and its height [m]
SLIDING, ROLLING = 0.2 * 9.81, 5 / 7 * 0.01 * 9.81  # what the cloth takes from a ball [m/s^2]
KEPT = 0.9  # of the speed, by a collision
LONGEST = 0.005  # step between looks for collisions [s]
UP = np.array([0, 0, 1.0])


class Ball:
    """A ball on the cloth, by the equations of friction and rolling alone; no step is too long for them."""

    def __init__(self, x: float, y: float) -> None:
        self.p, self.v, self.w = np.array([x, y, CLOTH + R]), np.zeros(3), np.zeros(3)

    def slip(self) -> np.ndarray:
        """Velocity of the point that touches the cloth."""
        return self.v + np.cross(self.w, -R * UP)

    def strike(self, impulse: np.ndarray, at: np.ndarray) -> None:
        """Momentum [N s], given at a place of the ball. What goes up or down the cloth takes."""
        self.v += impulse * [1, 1, 0] / MASS
        self.w += np.cross(at - self.p, impulse) / INERTIA

    def move(self, dt: float) -> None:
        """Friction -mu m g acts along the slip, which keeps its direction and loses 7/2 mu g: as long as there is any, the
        ball slides. Then it rolls, slowed by the cloth's give alone."""
        slip = self.slip()
        speed = np.linalg.norm(slip)
        t = min(dt, speed / (3.5 * SLIDING))
        if t > 0:
            lost = SLIDING * t * slip / speed
            self.p += t * (self.v - lost / 2)
            self.v -= lost
            self.w += np.cross(R * UP, lost) * MASS / INERTIA
            dt -= t
        speed = np.linalg.norm(self.v)
        if dt > 0 and speed > 0:
            t = min(dt, speed / ROLLING)
            lost = ROLLING * t * self.v / speed
            self.p += t * (self.v - lost / 2)
            self.v -= lost
        if dt > 0:
            self.w = np.cross(UP, self.v) / R + self.w * UP


def collide(balls: list[Ball]) -> None:
    """Cushions turn balls back, balls of the same mass exchange what brings them together."""
    for ball in balls:
        for k in (0, 1):
            if abs(ball.p[k]) > HALF[k] - R and ball.p[k] * ball.v[k] > 0:
                ball.v[k] *= -KEPT
    for i, a in enumerate(balls):
        for b in balls[:i]:
            n = (a.p - b.p) / np.linalg.norm(a.p - b.p)
            nearing = (b.v - a.v) @ n
            if nearing > 0 and np.linalg.norm(a.p - b.p) < 2 * R:
                a.v += (1 + KEPT) / 2 * nearing * n
                b.v -= (1 + KEPT) / 2 * nearing * n


def struck(samples: np.ndarray, ball: Ball, number: int, period: float) -> float:
    """Hands the ball what the hand felt of it, the other way: force times time, however often the servo looks [N s]. That is
    what the surface asks for, less what a limit takes off it."""
    touching = samples[samples["contact_object"] == number]
    source = touching["by_source"].astype(float)
    impulses = -period * (source[:, haptic.Source.SURFACE] + source[:, haptic.Source.GUARD])
    for impulse, at in zip(impulses, touching["proxy"]):
        ball.strike(impulse, at)
    return float(np.linalg.norm(impulses.sum(axis=0)))


def main() -> int:
    parser = argparse.ArgumentParser(description="The hand is the cue.")
    parser.add_argument("--seconds", type=float, default=3, help="how long the game goes on (%(default)s)")
    seconds = parser.parse_args().seconds
    balls = [Ball(0.02, 0), Ball(-0.02, 0.004)]
    with haptic.Client(name="08-pool") as client, client.open_session() as session:
        create, Kind, wood = client.scene.create, haptic.ShapeKind, haptic.Material(1500, 2, 0.2, 0.15)
        create("cloth", Kind.BOX, (*HALF, 0.01), pose=haptic.Pose((0, 0, CLOTH - 0.01)), material=wood)
        for k, side in ((0, -1), (0, 1), (1, -1), (1, 1)):
            place, size = CLOTH * UP, np.array([*(HALF + 0.01), R])
            place[k], size[k] = side * (HALF[k] + 0.005), 0.005
            create(f"cushion{2 * k + (side > 0)}", Kind.BOX, tuple(size), pose=haptic.Pose(tuple(place)), material=wood)
        # Balls answer some 2 ms late: with less damping than stiffness times that, a stroke gave more than it took.
        ivory = haptic.Material(800, 3, 0.4, 0.3)
        numbers = [create(f"ball-{i}", Kind.SPHERE, (R,), pose=haptic.Pose(tuple(ball.p)), material=ivory)
                   for i, ball in enumerate(balls)]
        info = session.describe()
        own, period = info.device_index, info.period_ns / 1e9
        session.push_intent((0.06, 0, 0.02), latest=True)  # of a simulated hand
        session.arm()
        while session.latest()["flags"] & (haptic.SampleFlag.RAMPING | haptic.SampleFlag.WAITING):
            time.sleep(0.01)
        session.drain()
        given, fastest, t, stroke = [0.0, 0.0], [0.0, 0.0], 0.0, 0.5
        while t < seconds:
            time.sleep(0.002)
            if given[0] == 0 and t > stroke + 1:  # missed, for the machine was too busy for this program: once more
                stroke = t
            x = 0.06 - 0.4 * max(0, t - stroke)  # down behind the ball, into it, then up
            session.push_intent((max(0.02, x), 0, CLOTH + R if x > 0 else 0.02), latest=True)
            samples = session.drain()
            samples = samples[samples["device"] == own]  # another device of the group has samples too
            for i, (ball, number) in enumerate(zip(balls, numbers)):
                given[i] += struck(samples, ball, number, period)
            passed = period * len(samples)  # The table's time is the servo's.
            steps = math.ceil(passed / LONGEST)
            for _ in range(steps):
                collide(balls)
                for ball in balls:
                    ball.move(passed / steps)
            t += passed
            for i, (ball, number) in enumerate(zip(balls, numbers)):
                fastest[i] = max(fastest[i], float(np.linalg.norm(ball.v)))
                session.push_object_pose(number, tuple(ball.p), v=tuple(ball.v), w=tuple(ball.w), lease_s=0.1,
                                         latest=True)
    for i, ball in enumerate(balls):
        print(f"ball {i}: {1000 * given[i]:.0f} mN s from the hand, at most {fastest[i]:.2f} m/s, "
              f"now at {1000 * ball.p[0]:.0f}, {1000 * ball.p[1]:.0f} mm")
    if given[0] > 0.01 and fastest[1] > 0.05 and all(math.isfinite(ball.p @ ball.p) for ball in balls):
        return 0
    print("Ball 0 was not driven into ball 1. A simulated hand with a motion= of its own does not come; one misses where "
          "something else stands in the way, or where the machine is too busy for this program: more --seconds, more strokes.",
          file=sys.stderr)
    return 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except haptic.HapticError as error:
        sys.exit(str(error))
    except KeyboardInterrupt:
        sys.exit(130)
