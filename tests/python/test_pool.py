#!/usr/bin/python3
"""examples/08-pool.py against what is known of balls on a cloth. Usage: test_pool.py EXAMPLE"""
import sys
import unittest

import hapticclient as haptic
import numpy as np

from program import load

pool = load(sys.argv.pop())
G, MU, R = 9.81, 0.2, pool.R


def rolled(v, w, seconds, step):
    """A ball after so long."""
    ball = pool.Ball(0, 0)
    ball.p, ball.v, ball.w = np.zeros(3), np.array(v, float), np.array(w, float)
    for _ in range(round(seconds / step)):
        ball.move(step)
    return ball


class Cloth(unittest.TestCase):
    def test_a_ball_that_slid_rolls_at_five_sevenths(self):
        for v in (0.1, 0.35, 2.0):
            until = 2 * v / (7 * MU * G)
            ball = rolled((v, 0, 0), (0, 0, 0), until, until)
            np.testing.assert_allclose(ball.v, (5 / 7 * v, 0, 0), atol=1e-12)
            np.testing.assert_allclose(ball.w, (0, 5 / 7 * v / R, 0), atol=1e-9)
            np.testing.assert_allclose(ball.p, (12 * v * v / (49 * MU * G), 0, 0), atol=1e-12)

    def test_rolling_loses_speed_evenly_and_ends(self):
        v, slower = 0.3, 5 / 7 * 0.01 * G
        roll = (0, v / R, 0)
        self.assertAlmostEqual(rolled((v, 0, 0), roll, 1, 0.01).v[0], v - slower, 12)
        at_rest = rolled((v, 0, 0), roll, 10, 0.01)
        self.assertAlmostEqual(at_rest.p[0], v * v / (2 * slower), 12)
        np.testing.assert_array_equal((at_rest.v, at_rest.w), np.zeros((2, 3)))

    def test_backspin_stops_a_ball_or_brings_it_back(self):
        v = 0.4
        self.assertAlmostEqual(rolled((v, 0, 0), (0, -2.5 * v / R, 0), 0.3, 0.001).v[0], 0, 12)
        self.assertLess(rolled((v, 0, 0), (0, -4 * v / R, 0), 0.3, 0.001).v[0], -0.1)

    def test_the_way_does_not_depend_on_the_step(self):
        start = (0.3, -0.1, 0), (5, 20, 3)
        fine, coarse = rolled(*start, 0.5, 0.00025), rolled(*start, 0.5, 0.05)
        np.testing.assert_allclose(fine.p, coarse.p, atol=1e-12)
        np.testing.assert_allclose(fine.v, coarse.v, atol=1e-12)
        np.testing.assert_allclose(fine.w, coarse.w, atol=1e-9)

    def test_sideways_spin_bends_the_way_as_the_equations_of_motion_do(self):
        # m dv/dt = f, I dw/dt = (-R n) x f with f = -mu m g u/|u|, in steps of a microsecond.
        p, v, w, n, dt = np.zeros(3), np.array([0.3, 0.0, 0]), np.array([25.0, -10, 0]), np.array([0, 0, 1.0]), 1e-6
        for _ in range(20000):
            u = v + np.cross(w, -R * n)
            a = -MU * G * u / np.linalg.norm(u)
            p = p + dt * v
            v = v + dt * a
            w = w + dt * np.cross(-R * n, a) / (0.4 * R * R)
        ball = rolled((0.3, 0, 0), (25, -10, 0), 0.02, 0.005)
        self.assertGreater(abs(v[1]), 0.02)  # it does bend
        np.testing.assert_allclose(ball.p, p, atol=1e-7)
        np.testing.assert_allclose(ball.v, v, atol=1e-6)
        np.testing.assert_allclose(ball.w, w, atol=1e-3)


class Strike(unittest.TestCase):
    def test_two_fifths_above_the_middle_a_ball_rolls_at_once(self):
        ball = pool.Ball(0, 0)
        ball.strike(np.array([0.02, 0, 0]), ball.p + (-R, 0, 0.4 * R))
        self.assertAlmostEqual(ball.v[0], 0.02 / pool.MASS, 15)
        np.testing.assert_allclose(ball.slip(), np.zeros(3), atol=1e-15)

    def test_the_same_push_gives_the_same_momentum_at_any_rate(self):
        # 5.1 of the thesis takes a force times one period: four times the rate would give a quarter of it.
        for rate in (1000, 4000):
            t = (np.arange(rate // 50) + 0.5) / rate
            samples = np.zeros(len(t), haptic.session.SAMPLE)
            samples["contact_object"] = np.where(t < 0.015, 7, 8)  # the rest is another object's
            samples["by_source"][:, haptic.Source.SURFACE, 0] = 3 * np.sin(np.pi * t / 0.015)
            samples["by_source"][:, haptic.Source.GRAVITY, 0] = -1  # carries the arm
            ball = pool.Ball(0, 0)
            samples["proxy"] = ball.p
            self.assertAlmostEqual(pool.struck(samples, ball, 7, 1 / rate), 3 * 0.015 * 2 / np.pi, delta=1e-4)
            np.testing.assert_allclose(ball.v, (-3 * 0.015 * 2 / np.pi / pool.MASS, 0, 0), rtol=2e-3)
            np.testing.assert_allclose(ball.w, 0, atol=1e-12)

    def test_what_a_limit_takes_off_the_hand_the_ball_does_not_get(self):
        samples = np.zeros(10, haptic.session.SAMPLE)
        samples["contact_object"] = 7
        samples["by_source"][:, haptic.Source.SURFACE, 0] = 8
        samples["by_source"][:, haptic.Source.GUARD, 0] = -5  # of a device of 3 N
        samples["force"][:, 0] = 3
        ball = pool.Ball(0, 0)
        samples["proxy"] = ball.p
        self.assertAlmostEqual(pool.struck(samples, ball, 7, 0.001), 0.03, 6)
        np.testing.assert_allclose(ball.v, (-0.03 / pool.MASS, 0, 0), rtol=1e-6)


class Collision(unittest.TestCase):
    def test_balls_keep_their_momentum_and_part_of_their_speed(self):
        a, b = pool.Ball(0, 0), pool.Ball(1.6 * R, 1.1 * R)
        a.v, b.v = np.array([0.5, 0.1, 0]), np.array([-0.2, 0, 0])
        n = (a.p - b.p) / np.linalg.norm(a.p - b.p)
        momentum, nearing, across = a.v + b.v, (b.v - a.v) @ n, a.v - a.v @ n * n
        for _ in range(2):  # They part, so the second time nothing happens.
            pool.collide([a, b])
            np.testing.assert_allclose(a.v + b.v, momentum, atol=1e-15)
            self.assertAlmostEqual((a.v - b.v) @ n, pool.KEPT * nearing, 12)
            np.testing.assert_allclose(a.v - a.v @ n * n, across, atol=1e-15)

    def test_balls_beside_each_other_do_nothing(self):
        a, b = pool.Ball(0, 0), pool.Ball(2.1 * R, 0)
        a.v[0] = 0.5
        pool.collide([a, b])
        self.assertEqual((a.v[0], b.v[0]), (0.5, 0))

    def test_a_cushion_turns_a_ball_back_once(self):
        ball = pool.Ball(0, -pool.HALF[1] + 0.9 * R)
        ball.v[:] = 0.2, -0.3, 0
        for _ in range(2):
            pool.collide([ball])
            np.testing.assert_allclose(ball.v, (0.2, 0.3 * pool.KEPT, 0), atol=1e-15)


if __name__ == "__main__":
    unittest.main()
