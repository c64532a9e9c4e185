"""What differs in the values that two inputs decode to.

Rules: CNF-1, CNF-16, CNF-17, DCT-8.

PSNR of a channel: 10 log10(peak^2 / mean squared difference), peak the range (largest - smallest value) of A's. A
channel that does not move in A has none.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import log10, nan, sqrt
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import SnhcError

from .align import NUMBER, TIME, pairs
from .instants import Instant, Instants

SHOWN: Final = 20


@dataclass(frozen=True, slots=True)
class ValueDifference:
    """One value that differs.

    Rules: CNF-17. `index_a`, `index_b`: lines; None on the side that has no such instant. `place`: node or vertex.
    """

    time: Fraction
    index_a: int | None
    index_b: int | None
    channel: str
    place: int | None
    a: object
    b: object

    def as_json(self) -> dict[str, Any]:
        """The difference as an object of the report."""
        return {
            "time": f"{self.time.numerator}/{self.time.denominator}", "index": [self.index_a, self.index_b],
            "channel": self.channel, "place": self.place, "a": _plain(self.a), "b": _plain(self.b),
        }  # fmt: skip

    def __str__(self) -> str:
        index = self.index_a if self.index_a is not None else self.index_b
        where = f"line {index}" + (
            f" of A, {self.index_b} of B"
            if self.index_a != self.index_b and None not in (self.index_a, self.index_b)
            else ""
        )
        place = self.channel if self.place is None else f"{self.channel}[{self.place}]"
        if self.channel in ("only in A", "only in B"):
            return f"{where} (time {float(self.time):.3f} s): {self.channel}"
        return f"{where} (time {float(self.time):.3f} s), {place}: A {_short(self.a)}, B {_short(self.b)}"


def _plain(value: object) -> object:
    return None if value is None else value if isinstance(value, (int, float, str)) else _short(value)


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= 72 else text[:69] + "..."


@dataclass(slots=True)
class Channel:
    """Sums over one channel.

    Rules: CNF-16. `compared`: pairs of numbers; `different`: of them, by more than the tolerance; `missing`: a number
    on one side only. `largest`: of the absolute differences.
    """

    compared: int = 0
    different: int = 0
    missing: int = 0
    largest: float = 0.0
    squares: float = 0.0
    low: float | None = None
    high: float | None = None

    @property
    def rms(self) -> float:
        """Root of the mean squared difference."""
        return sqrt(self.squares / self.compared) if self.compared else 0.0

    @property
    def psnr(self) -> float | None:
        """dB; None where nothing differs or A does not move."""
        if not self.squares or self.low is None or self.high is None or self.high == self.low:
            return None
        return 10.0 * log10((self.high - self.low) ** 2 * self.compared / self.squares)

    def take(self, a: float, b: float, tolerance: float) -> bool:
        """Count a pair of numbers; whether they differ."""
        self.compared += 1
        self.low = a if self.low is None or a < self.low else self.low
        self.high = a if self.high is None or a > self.high else self.high
        if a == b:
            return False
        gap = abs(a - b)
        self.squares += gap * gap
        self.largest = max(self.largest, gap)
        # A value that is no number differs from everything.
        differs = not gap <= tolerance
        self.different += differs
        return differs

    def as_json(self) -> dict[str, Any]:
        """The sums as an object of the report."""
        psnr = self.psnr
        return {
            "compared": self.compared, "different": self.different, "missing": self.missing,
            "max": self.largest, "rms": round(self.rms, 6), "psnr": None if psnr is None else round(psnr, 3),
        }  # fmt: skip


@dataclass(slots=True)
class ValueDiff:
    """What differs in the values.

    Rules: CNF-16, CNF-17. `compared`: instants of both; `only_a`, `only_b`: instants without a partner. `words`: what
    is no number -> (compared, different). `first`: in order of time; `shown`: the first ones. `curves`: channel -> the
    two curves, with NaN for no value, and `times` with them, if they were asked for.
    """

    kind_a: str = ""
    kind_b: str = ""
    compared: int = 0
    only_a: int = 0
    only_b: int = 0
    differences: int = 0
    error_a: SnhcError | None = None
    error_b: SnhcError | None = None
    channels: dict[str, Channel] = field(default_factory=dict)
    words: dict[str, list[int]] = field(default_factory=dict)
    shown: list[ValueDifference] = field(default_factory=list)
    times: array[float] = field(default_factory=lambda: array("d"))
    curves: dict[str, tuple[array[float], array[float]]] = field(default_factory=dict)

    @property
    def equal(self) -> bool:
        """Whether nothing differs by more than the tolerance."""
        return not self.differences and (self.error_a is None) == (self.error_b is None)

    @property
    def first(self) -> ValueDifference | None:
        """The first difference."""
        return self.shown[0] if self.shown else None

    def as_json(self) -> dict[str, Any]:
        """The `values` of the report."""
        return {
            "kinds": [self.kind_a, self.kind_b],
            "compared": self.compared, "only_a": self.only_a, "only_b": self.only_b,
            "different": self.differences,
            "channels": {
                name: channel.as_json()
                for name, channel in self.channels.items()
                if channel.compared or channel.missing
            },
            "words": {name: {"compared": both, "different": differ} for name, (both, differ) in self.words.items()},
            "first": None if self.first is None else self.first.as_json(),
            "differences": [one.as_json() for one in self.shown],
        }  # fmt: skip


def diff_values(
    a: Instants, b: Instants, *, align: str = TIME, tolerance: float = 0.0, shown: int = SHOWN, curves: bool = False
) -> ValueDiff:
    """Compare the values of two inputs, instant by instant.

    Rules: CNF-16, CNF-17. `align`: pair instants by `time` or by `number`. `tolerance`: a difference of numbers up to
    it is none. Memory does not grow with the inputs, but for `curves`. Raises what reading either raises.
    """
    found = ValueDiff()
    for x, y in pairs(a, b, None if align == NUMBER else _time):
        if x is None or y is None:
            one = x if x is not None else y
            assert one is not None
            found.only_a += y is None
            found.only_b += x is None
            side = "only in A" if y is None else "only in B"
            _add(
                found,
                shown,
                _difference(one, None if x is None else one, None if y is None else one, side, None, None, None),
            )
            continue
        found.compared += 1
        _instant(found, x, y, tolerance, shown)
        if curves:
            _curves(found, x, y)
    found.kind_a, found.kind_b = a.kind, b.kind
    found.error_a, found.error_b = a.error, b.error
    return found


def _time(instant: Instant) -> Fraction:
    return instant.time


def _difference(
    when: Instant, x: Instant | None, y: Instant | None, channel: str, place: int | None, a: object, b: object
) -> ValueDifference:
    return ValueDifference(
        when.time, None if x is None else x.index, None if y is None else y.index, channel, place, a, b
    )


def _add(found: ValueDiff, most: int, difference: ValueDifference) -> None:
    found.differences += 1
    if len(found.shown) < most:
        found.shown.append(difference)


def _instant(found: ValueDiff, x: Instant, y: Instant, tolerance: float, shown: int) -> None:
    channels = found.channels
    if x.time != y.time:
        _add(found, shown, _difference(x, x, y, "time", None, str(x.time), str(y.time)))
    for name in (*x.values, *(name for name in y.values if name not in x.values)):
        ours: Sequence[float | None] = x.values.get(name, ())
        theirs: Sequence[float | None] = y.values.get(name, ())
        channel = channels.get(name)
        if channel is None:
            channel = channels[name] = Channel()
        single = len(ours) <= 1 and len(theirs) <= 1
        for place in range(max(len(ours), len(theirs))):
            a = ours[place] if place < len(ours) else None
            b = theirs[place] if place < len(theirs) else None
            if a is None and b is None:
                continue
            if a is None or b is None:
                channel.missing += 1
            elif not channel.take(a, b, tolerance):
                continue
            _add(found, shown, _difference(x, x, y, name, None if single else place, a, b))
    for name in (*x.words, *(name for name in y.words if name not in x.words)):
        counts = found.words.setdefault(name, [0, 0])
        counts[0] += 1
        if x.words.get(name) != y.words.get(name):
            counts[1] += 1
            _add(found, shown, _difference(x, x, y, name, None, x.words.get(name), y.words.get(name)))


def _curves(found: ValueDiff, x: Instant, y: Instant) -> None:
    found.times.append(float(x.time))
    for name, ours in x.values.items():
        theirs = y.values.get(name, ())
        if len(ours) != 1 or len(theirs) != 1:
            continue
        both = found.curves.get(name)
        if both is None:
            blank = [nan] * (len(found.times) - 1)
            both = found.curves[name] = (array("d", blank), array("d", blank))
        for curve, value in zip(both, (ours[0], theirs[0]), strict=True):
            curve.append(nan if value is None else value)
