"""A simulated surgeon's hand: brings a fragment near, presses gently, and lets the contact guide it."""
import math
from dataclasses import dataclass, field

import numpy as np

MM, DEGREE = 1e-3, math.pi / 180


def quaternion(turn: np.ndarray) -> np.ndarray:
    """w, x, y, z of a rotation vector [rad]."""
    angle = float(np.linalg.norm(turn))
    if angle < 1e-12:
        return np.array([1.0, 0, 0, 0])
    return np.concatenate([[math.cos(angle / 2)], math.sin(angle / 2) / angle * np.asarray(turn)])


def angle_of(q: np.ndarray) -> float:
    """Degrees from no rotation."""
    return 2 * math.degrees(math.atan2(float(np.linalg.norm(q[1:])), abs(float(q[0]))))


@dataclass
class Hand:
    """Home is the origin without rotation, the way in is -z. All the hand knows is roughly where that is, and what it feels.

    Toward the surface it moves as people reach, with the least jerk (Flash and Hogan 1985). Then it holds the push and yields
    to all other force and torque at the pace of an arm that is told to follow, and wiggles a little. A tremor of 8 to 12 Hz
    never leaves it until it rests.
    """
    start: np.ndarray = field(default_factory=lambda: np.array([12.0, -9, 30]) * MM)
    missed: np.ndarray = field(default_factory=lambda: np.array([2.5, -2, 9]) * MM)  # Where it believes to be over home.
    start_turn: np.ndarray = field(default_factory=lambda: np.array([9.0, -7, 10]) * DEGREE)
    missed_turn: np.ndarray = field(default_factory=lambda: np.array([4.0, -3, 5]) * DEGREE)
    push_n: float = 3.0
    approach_s: float = 2.0
    press_s: float = 4.0
    ease_s: float = 3.0
    rest_s: float = 1.5

    def __post_init__(self) -> None:
        self.p, self.turn = self.start.copy(), self.start_turn.copy()
        self.force, self.torque = np.zeros(3), np.zeros(3)
        self.last = 0.0

    @property
    def seconds(self) -> float:
        return self.approach_s + self.press_s + self.ease_s + self.rest_s

    def intent(self, t: float, force: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the hand wants to be t seconds after the start, feeling this [N, N m]: place [m] and quaternion."""
        dt, self.last = min(t - self.last, 0.05), t
        blend = 1 - math.exp(-2 * math.pi * 5 * dt)  # What it feels reaches the arm at 5 Hz.
        self.force += blend * (force - self.force)
        self.torque += blend * (torque - self.torque)
        pressing = self.approach_s + self.press_s
        if t < self.approach_s:
            s = t / self.approach_s
            s = s ** 3 * (10 - 15 * s + 6 * s * s)
            self.p = self.start + s * (self.missed - self.start)
            self.turn = self.start_turn + s * (self.missed_turn - self.start_turn)
        elif t < pressing + self.ease_s:
            push = self.push_n * (1 - 0.5 * min(1.0, max(0.0, 2 * (t - pressing) / self.ease_s)))
            yielding = np.array([8.0, 8.0, 5.0]) * MM * (self.force - [0, 0, push])  # [m/s] for newtons
            self.p += dt * np.clip(yielding, -12 * MM, 12 * MM)
            self.turn += dt * np.clip(10.0 * self.torque, -0.3, 0.3)  # [rad/s] for newton metres
        calm = min(1.0, max(0.0, 2 - 2 * (t - pressing) / self.ease_s))  # First it pushes less, then it wiggles less.
        shake = 0.1 * MM * calm * np.array([math.sin(2 * math.pi * (8.3 * t)) + math.sin(2 * math.pi * 11.2 * t + 1),
                                            math.sin(2 * math.pi * (9.1 * t) + 2) + math.sin(2 * math.pi * 10.4 * t),
                                            math.sin(2 * math.pi * (9.7 * t) + 4) + math.sin(2 * math.pi * 11.8 * t + 3)])
        wiggling = calm if t > self.approach_s else 0.0
        wiggle = 0.5 * MM * wiggling * np.array([math.sin(8 * t), math.cos(8 * t), 0])
        twist = 1.8 * DEGREE * wiggling * np.array([math.sin(7 * t), math.cos(6 * t), math.sin(5 * t)])
        return self.p + shake + wiggle, quaternion(self.turn + twist)
