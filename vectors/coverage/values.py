"""Value classes of syntax elements.

Rules: CNF-8. What an element can hold follows from its declaration (domain, meanings) and its width. Small fields have
a class per value; of larger ones the ends, zero and what lies between. Values outside the domain are classes too: the
first ones outside, and the largest that the field can hold.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.syntax.element import Element

# Up to this many bits every value is a class of its own.
SMALL_BITS: Final = 4


def bounds(el: Element, n: int, signed: bool) -> tuple[int, int, int, int]:
    """(lowest, highest) that the field can hold, then that the domain allows. Rules: CNF-7."""
    least, most = (-(1 << (n - 1)), (1 << (n - 1)) - 1) if signed else (0, (1 << n) - 1)
    lo = least if el.lo is None else max(least, el.lo)
    hi = most if el.hi is None else min(most, el.hi)
    return least, most, lo, hi


def all_classes(el: Element, n: int, signed: bool) -> list[str]:
    """Every value class of an element of n bits. Rules: CNF-8."""
    least, most, lo, hi = bounds(el, n, signed)
    if n <= SMALL_BITS and not signed:
        return [named(el, value) for value in range(least, most + 1)]
    out = [f"min {lo}", f"max {hi}"]
    if lo < 0 < hi:
        out += ["zero", "negative", "positive"]
    elif hi - lo > 1:
        out.append("between")
    out += [refused(value) for value in _outside(el, least, most, lo, hi)]
    out += [named(el, value) for value in el.meaning if el.allows(value) and value not in (lo, hi)]
    return out


def classes_of(el: Element, n: int, signed: bool, value: int) -> list[str]:
    """The classes that a value read lies in. Rules: CNF-8."""
    least, most, lo, hi = bounds(el, n, signed)
    if n <= SMALL_BITS and not signed:
        return [named(el, value)]
    if not el.allows(value):
        return [refused(value)] if value in _outside(el, least, most, lo, hi) else []
    out = [named(el, value)] if value in el.meaning and value not in (lo, hi) else []
    if value == lo:
        out.append(f"min {lo}")
    elif value == hi:
        out.append(f"max {hi}")
    elif lo < 0 < hi:
        out.append("zero" if value == 0 else "negative" if value < 0 else "positive")
    else:
        out.append("between")
    return out


def named(el: Element, value: int) -> str:
    """The class of one value, in words where it has a meaning. Rules: CNF-8."""
    if not el.allows(value):
        return refused(value)
    meaning = el.meaning.get(value, "")
    return f"{value} ({meaning})" if meaning else str(value)


def refused(value: int) -> str:
    """The class of a value outside the domain. Rules: CNF-7."""
    return f"refused {value}"


def _outside(el: Element, least: int, most: int, lo: int, hi: int) -> list[int]:
    out = {lo - 1, hi + 1, least, most, *el.forbidden}
    return sorted(value for value in out if least <= value <= most and not el.allows(value))
