"""A generator of numbers that gives the same ones everywhere: splitmix64.

Rules: CNF-4.
"""

from __future__ import annotations

from typing import Final, final

_MASK: Final = (1 << 64) - 1


@final
class Seeded:
    """Whole numbers from a seed, by splitmix64; the same on every platform and Python version. Rules: CNF-4."""

    __slots__ = ("_state",)

    def __init__(self, seed: int) -> None:
        self._state = seed & _MASK

    def next(self) -> int:
        """The next number, 0 .. 2^64 - 1."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        z = self._state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
        return z ^ (z >> 31)

    def between(self, lo: int, hi: int) -> int:
        """A number lo .. hi, both included, each equally likely."""
        n = hi - lo + 1
        limit = (_MASK + 1) - (_MASK + 1) % n
        while (number := self.next()) >= limit:
            continue
        return lo + number % n
