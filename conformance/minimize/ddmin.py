"""Delta debugging: the smallest part of a list that still passes a test.

Rules: CNF-17. Deterministic: the same test gives the same result.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

_T = TypeVar("_T")


def ddmin(units: Sequence[_T], test: Callable[[list[_T]], bool]) -> list[_T]:
    """A part of `units`, in their order, that passes, and from which no single unit can be left out.

    Rules: CNF-17. `test` is true for `units` themselves; it is not asked for them.
    """
    kept = list(units)
    if kept and test([]):
        return []
    size = len(kept) // 2
    while size >= 1:
        shrunk = False
        # From the end: what comes last is least likely to be needed by the rest.
        at = len(kept)
        while at > 0:
            first = max(0, at - size)
            smaller = kept[:first] + kept[at:]
            if smaller and test(smaller):
                kept = smaller
                shrunk = True
            at = first
        if size == 1 and not shrunk:
            break
        size = max(1, size // 2) if not (size == 1 and shrunk) else 1
    return kept


def lower(value: int, test: Callable[[int], bool]) -> int:
    """An integer nearer to 0 that passes: 0, else by halving, else by one. Rules: CNF-17. `test(value)` is true."""
    if value == 0 or test(0):
        return 0
    sign = 1 if value > 0 else -1
    low, high = 0, abs(value)  # low fails, high passes
    while high - low > 1:
        middle = (low + high) // 2
        if test(sign * middle):
            high = middle
        else:
            low = middle
    return sign * high
