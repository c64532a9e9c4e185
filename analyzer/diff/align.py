"""Pairing what belongs together in two sequences, one pass over both.

Rules: CNF-17.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Final, TypeVar

TIME: Final = "time"
NUMBER: Final = "number"
WAYS: Final = (TIME, NUMBER)


T = TypeVar("T")


def pairs(a: Iterable[T], b: Iterable[T], key: Callable[[T], Any] | None) -> Iterator[tuple[T | None, T | None]]:
    """(from a, from b): both where their keys are equal, else the one with the smaller key alone.

    Rules: CNF-17. `key`: None pairs by number. Keys that fall back (a time code) pair as far as they can; every
    element comes exactly once, in the order of its own sequence.
    """
    left, right = iter(a), iter(b)
    x, y = next(left, None), next(right, None)
    while x is not None or y is not None:
        if x is None or y is None or key is None or key(x) == key(y):
            yield x, y
            x, y = next(left, None), next(right, None)
        elif key(x) < key(y):
            yield x, None
            x = next(left, None)
        else:
            yield None, y
            y = next(right, None)
