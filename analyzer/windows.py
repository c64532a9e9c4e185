"""Bit rates over windows of one second, while a stream is read.

Rules: SYS-11, SYS-12.

Planes come nearly in the order of time, but for streams whose time code goes far back and for objects side by side. In
order, the fullest second is known with a few seconds of planes in memory. Else any plane may lie beside any other: then
the times and sizes are read once more, and kept.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import itemgetter
from typing import Final

from snhc.reference_impl.bitstream.errors import ResourceLimit
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.systems.stream import Options, is_object, reader
from snhc.reference_impl.systems.visual import AnyPlane, StreamItem, fresh_items, visual_stream

# Seconds, and times in them, that a plane may come late.
_LATE: Final = 2
_MOST: Final = 4096
_time: Final = itemgetter(0)


@dataclass(frozen=True, slots=True)
class Peak:
    """The fullest window of one second. Rules: SYS-11. `start`: seconds; `bits`, `planes` in [start, start + 1)."""

    start: Fraction
    bits: int
    planes: int


def peak_window(times: Sequence[Fraction], bits: Sequence[int]) -> Peak | None:
    """Over every plane's time t, the largest sum of the planes in [t, t + 1 s), the earliest of equals. Rules: SYS-11.

    `times`: in any order.
    """
    running = RunningPeak()
    for n in sorted(range(len(times)), key=lambda n: times[n]):
        running.add(times[n], bits[n])
    return running.peak()


class RunningPeak:
    """The fullest window of planes that come one by one; a few seconds of them are kept.

    Rules: SYS-11. `ordered`: no plane came later than it can be put in its place; without, `peak` has no meaning. A
    time code counts whole seconds, so that a clock of 30000/1001 Hz goes back a little with each: that is put right.
    """

    __slots__ = ("_best", "_bits", "_coming", "_planes", "_window", "ordered")

    def __init__(self) -> None:
        self.ordered = True
        self._best: Peak | None = None
        # (time, bits, planes), in order; planes at the same time start the same window.
        self._coming: list[tuple[Fraction, int, int]] = []
        self._window: deque[tuple[Fraction, int, int]] = deque()
        self._bits = 0
        self._planes = 0

    def add(self, time: Fraction, bits: int) -> None:
        """Take a plane in. Rules: SYS-11. `bits`: 0 or more."""
        if not self.ordered:
            return
        coming = self._coming
        if not coming or time > coming[-1][0]:
            coming.append((time, bits, 1))
        else:
            place = bisect_left(coming, time, key=_time)
            if coming[place][0] == time:
                _, more, planes = coming[place]
                coming[place] = (time, bits + more, planes + 1)
            else:
                coming.insert(place, (time, bits, 1))
        if len(coming) > _MOST or coming[0][0] + _LATE < coming[-1][0]:
            self._pass(coming.pop(0))

    def _pass(self, entry: tuple[Fraction, int, int]) -> None:
        time, bits, planes = entry
        window = self._window
        if window:
            if time <= window[-1][0]:
                # Nothing is known any more: nothing more is kept.
                self.ordered = False
                self._coming.clear()
                window.clear()
                return
            while window and time >= window[0][0] + 1:
                self._close()
        window.append(entry)
        self._bits += bits
        self._planes += planes

    def _close(self) -> None:
        start, bits, planes = self._window.popleft()
        if self._best is None or self._bits > self._best.bits:
            self._best = Peak(start, self._bits, self._planes)
        self._bits -= bits
        self._planes -= planes

    def peak(self) -> Peak | None:
        """The fullest window, the earliest of equals; None without planes. No plane may follow. Rules: SYS-11."""
        while self._coming:
            self._pass(self._coming.pop(0))
        while self._window:
            self._close()
        return self._best


def sized_planes(
    source: Source | bytes, options: Options, on_finding: Callable[[Finding], None]
) -> Iterator[tuple[int, StreamItem, AnyPlane | None, int]]:
    """What a stream holds: (number of the object, from 0, its item, plane, bits of the plane).

    Rules: SYS-11. Items without a plane stand for themselves (bits 0), the object's number is then the last one's, -1
    before the first. Raises what ends the stream.
    """
    current: StreamItem | None = None
    number = -1
    behind = 0
    for item, plane in visual_stream(reader(source, options, on_finding), fresh_items()):
        if plane is None:
            if is_object(item) and item is not current:
                current = item
                number += 1
            yield number, item, None, 0
        else:
            yield number, item, plane, plane.end - behind
            behind = plane.end


def time_of(plane: AnyPlane) -> Fraction:
    """When a plane is shown; a DCT segment, when its first frame is. Rules: SYS-11, FBA-38."""
    return Fraction(*plane.frames[0].time)


def check_collected(count: int, limits: Limits) -> None:
    """Raise ResourceLimit where no more than `count` planes may be kept already. Rules: CNF-22."""
    if count >= limits.collected_planes:
        raise ResourceLimit("CNF-22", "planes", value=count + 1, allowed=f"at most {limits.collected_planes}")


def collected_peaks(
    source: Source | bytes, options: Options, wanted: Collection[int]
) -> tuple[Peak | None, Peak | None]:
    """The windows with most bits and most planes over all objects whose number is wanted, in any order of time.

    Rules: SYS-11, SYS-12, CNF-22. Reads the stream once more; keeps time and size of each plane.
    """
    times: list[Fraction] = []
    sizes: list[int] = []
    for number, _, plane, bits in sized_planes(source, options, lambda finding: None):
        if plane is not None and number in wanted:
            check_collected(len(times), options.limits)
            times.append(time_of(plane))
            sizes.append(bits)
    return peak_window(times, sizes), peak_window(times, [1] * len(times))
