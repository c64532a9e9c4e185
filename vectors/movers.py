"""What moves in the sequences of this suite, made from a seed: numbers, springs, eyes, heads.

Rules: CNF-4 (own generator; floats are made of + - * / alone, in one fixed order).
"""

from __future__ import annotations

from typing import Final, final

from .seeded import Seeded

ANGLES: Final = frozenset((23, 24, 25, 26, 48, 49, 50))
"""The FAPs that are angles: their numbers are large."""

LONGEST_STEP: Final = 0.7
"""Of a spring, in its own time (stiffness * seconds): longer ones are not stable."""


@final
class Spring:
    """A critically damped spring: follows a target without overshoot."""

    __slots__ = ("_speed", "_stiffness", "target", "value")

    def __init__(self, stiffness: float) -> None:
        self._stiffness = stiffness
        self._speed = 0.0
        self.value = 0.0
        self.target = 0.0

    def step(self, seconds: float) -> float:
        """The value after some more seconds. Long steps go in parts: past 0.8 of its own time a spring swings up."""
        parts = 1
        while self._stiffness * seconds > LONGEST_STEP * parts:
            parts += 1
        part = seconds / parts
        for _ in range(parts):
            pull = self._stiffness * self._stiffness * (self.target - self.value) - 2.0 * self._stiffness * self._speed
            self._speed = self._speed + pull * part
            self.value = self.value + self._speed * part
        return self.value


@final
class Draw:
    """Numbers of a seed, as the sequences want them."""

    __slots__ = ("_seeded",)

    def __init__(self, seed: int) -> None:
        self._seeded = Seeded(seed)

    def among(self, lo: int, hi: int) -> int:
        """A whole number lo .. hi."""
        return self._seeded.between(lo, hi)

    def between(self, lo: float, hi: float) -> float:
        """One of 4,097 equally spaced numbers."""
        return lo + (hi - lo) * self._seeded.between(0, 4096) / 4096.0

    def one_of(self, choices: tuple[int, ...]) -> int:
        """One of them, each equally likely."""
        return choices[self._seeded.between(0, len(choices) - 1)]


def smooth(x: float) -> float:
    """0 to 1 for x = 0 to 1, with level ends."""
    if x <= 0.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    return x * x * (3.0 - 2.0 * x)


@final
class Eyes:
    """Blinks, jumps of gaze."""

    __slots__ = ("_blink", "_draw", "_jump", "_pitch", "_pitch_target", "_yaw", "_yaw_target")

    def __init__(self, draw: Draw) -> None:
        self._draw = draw
        self._blink = draw.between(0.5, 3.0)
        self._jump = draw.between(0.3, 1.5)
        self._yaw = self._pitch = self._yaw_target = self._pitch_target = 0.0

    def add(self, now: float, values: dict[int, float]) -> None:
        """Add lids and gaze of an instant to the values by FAP."""
        if now > self._blink + 0.3:
            self._blink = now + self._draw.between(1.5, 6.0)
        since = now - self._blink
        closed = smooth(since / 0.08) * (1.0 - smooth((since - 0.1) / 0.18))
        if now > self._jump:
            self._jump = now + self._draw.between(0.4, 2.5)
            self._yaw_target = self._draw.between(-9_000.0, 9_000.0)
            self._pitch_target = self._draw.between(-5_000.0, 5_000.0)
        # A jump takes two or three frames.
        self._yaw = self._yaw + 0.7 * (self._yaw_target - self._yaw)
        self._pitch = self._pitch + 0.7 * (self._pitch_target - self._pitch)
        for fap, share in ((19, 1.0), (20, 0.98), (21, 0.12), (22, 0.12)):
            values[fap] = values.get(fap, 0.0) + share * 960.0 * closed
        for fap, value in ((23, self._yaw), (24, self._yaw), (25, self._pitch), (26, self._pitch)):
            values[fap] = value


@final
class Head:
    """Head and brows, which follow phrases."""

    __slots__ = ("_brows", "_draw", "_next", "_turns")

    def __init__(self, draw: Draw) -> None:
        self._draw = draw
        self._turns = (Spring(5.0), Spring(4.0), Spring(3.0))
        self._brows = Spring(9.0)
        self._next = 0.0

    def add(self, now: float, seconds: float, values: dict[int, float]) -> None:
        """Add turns and brows of an instant, so many seconds after the last one, to the values by FAP."""
        if now >= self._next:
            self._next = now + self._draw.between(0.4, 1.6)
            for spring, size in zip(self._turns, (5_000.0, 8_000.0, 3_000.0), strict=True):
                spring.target = self._draw.between(-size, size)
            self._brows.target = self._draw.between(0.0, 130.0) if self._draw.among(0, 2) == 0 else 0.0
        for fap, spring in zip((48, 49, 50), self._turns, strict=True):
            values[fap] = values.get(fap, 0.0) + spring.step(seconds)
        raised = self._brows.step(seconds)
        for fap, share in ((31, 0.8), (32, 0.78), (33, 1.0), (34, 0.98), (35, 0.7), (36, 0.68)):
            values[fap] = values.get(fap, 0.0) + share * raised
