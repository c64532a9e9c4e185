"""The temporal header of face and mesh planes, and the clock it sets.

Rules: FBA-6, FBA-7, FBA-8, FBA-37, FBA-38, FBA-39.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd
from typing import Final, final

from ..bitstream.errors import ForbiddenValue, ResourceLimit
from .base import SyntaxIO
from .element import Element, Fault, marker

IS_FRAME_RATE: Final = Element("is_frame_rate", "FBA-6")
FRAME_RATE: Final = Element("frame_rate", "FBA-6")
SECONDS: Final = Element("seconds", "FBA-6")
FREQUENCY_OFFSET: Final = Element("frequency_offset", "FBA-6", meaning={0: "x 1", 1: "x 1000/1001"})
IS_TIME_CODE: Final = Element("is_time_code", "FBA-7")
TIME_CODE_HOURS: Final = Element("time_code_hours", "FBA-7", lo=0, hi=23)
TIME_CODE_MINUTES: Final = Element("time_code_minutes", "FBA-7", lo=0, hi=59)
TIME_CODE_MARKER: Final = marker("FBA-7")
TIME_CODE_SECONDS: Final = Element("time_code_seconds", "FBA-7", lo=0, hi=59)
SKIP_FRAMES: Final = Element("skip_frames", "FBA-8")
NUMBER_OF_FRAMES_TO_SKIP: Final = Element(
    "number_of_frames_to_skip", "FBA-8", meaning={15: "15, and another number follows"}
)

_RATE_ZERO: Final = Fault(ForbiddenValue, "FBA-37", "frame rate", "a rate above 0")
_SKIP_LIMIT: Final = Fault(ResourceLimit, "FBA-8", "number_of_frames_to_skip", "")


@final
class TemporalHeader:
    """What the temporal header says. Rules: FBA-6, FBA-7, FBA-8.

    `frame_rate`: whole frames per second 0..255; `seconds`: sixteenths 0..15; `frequency_offset`: 1 = times
    1000/1001; `skip_frames`: 1 = `number_of_frames_to_skip` follows (the sum of its groups).
    """

    __slots__ = (
        "frame_rate", "frequency_offset", "is_frame_rate", "is_time_code", "number_of_frames_to_skip", "seconds",
        "skip_frames", "time_code_hours", "time_code_minutes", "time_code_seconds",
    )  # fmt: skip

    def __init__(self) -> None:
        self.is_frame_rate = 0
        self.frame_rate = 0
        self.seconds = 0
        self.frequency_offset = 0
        self.is_time_code = 0
        self.time_code_hours = 0
        self.time_code_minutes = 0
        self.time_code_seconds = 0
        self.skip_frames = 0
        self.number_of_frames_to_skip = 0


def temporal_header(io: SyntaxIO, h: TemporalHeader, is_intra: int) -> None:
    """Read or write the temporal header. Rules: FBA-6, FBA-7, FBA-8, FBA-37, FBA-39."""
    if is_intra:
        h.is_frame_rate = io.u(IS_FRAME_RATE, 1, h.is_frame_rate)
        if h.is_frame_rate:
            start = io.tell()
            h.frame_rate = io.u(FRAME_RATE, 8, h.frame_rate)
            h.seconds = io.u(SECONDS, 4, h.seconds)
            h.frequency_offset = io.u(FREQUENCY_OFFSET, 1, h.frequency_offset)
            io.require(h.frame_rate != 0 or h.seconds != 0, _RATE_ZERO, 0, start, io.tell())
        h.is_time_code = io.u(IS_TIME_CODE, 1, h.is_time_code)
        if h.is_time_code:
            h.time_code_hours = io.u(TIME_CODE_HOURS, 5, h.time_code_hours)
            h.time_code_minutes = io.u(TIME_CODE_MINUTES, 6, h.time_code_minutes)
            io.marker(TIME_CODE_MARKER)
            h.time_code_seconds = io.u(TIME_CODE_SECONDS, 6, h.time_code_seconds)
    h.skip_frames = io.u(SKIP_FRAMES, 1, h.skip_frames)
    if h.skip_frames:
        _number_of_frames_to_skip(io, h)


def _number_of_frames_to_skip(io: SyntaxIO, h: TemporalHeader) -> None:
    start = io.tell()
    total = 0
    group = 15
    while group == 15:
        rest = h.number_of_frames_to_skip - total
        group = io.u(NUMBER_OF_FRAMES_TO_SKIP, 4, 15 if rest > 15 else rest)
        total += group
        if total > io.limits.skipped_frames:
            fault = _SKIP_LIMIT.allowing(f"at most {io.limits.skipped_frames}")
            io.require(False, fault, total, start, io.tell())
    h.number_of_frames_to_skip = total


@final
class Clock:
    """Running time of an object, as exact fractions of seconds.

    Rules: FBA-37, FBA-38. Time = `_base` + `_periods` frame periods; `_base` changes only where the rate changes or
    a time code is sent.
    """

    __slots__ = ("_base", "_den", "_last", "_num", "_periods", "rate", "went_back")

    def __init__(self) -> None:
        self.rate = Fraction(30)
        self._num = 1
        self._den = 30
        self._base = Fraction(0)
        self._periods = 0
        self._last = (-1, 1)
        self.went_back = False

    def tick(self, h: TemporalHeader, skipped_before: bool) -> tuple[int, int]:
        """Take in a header; the plane's time as (numerator, denominator) in lowest terms.

        Rules: FBA-37, FBA-38. `skipped_before`: reading of AMB-FBA-6. `went_back` tells whether a time code went back.
        """
        if h.is_frame_rate:
            rate = Fraction(h.frame_rate * 16 + h.seconds, 16)
            if h.frequency_offset:
                rate = rate * 1000 / 1001
            if rate > 0 and rate != self.rate:
                self._base += Fraction(self._periods * self._num, self._den)
                self._periods = 0
                self.rate = rate
                self._num = rate.denominator
                self._den = rate.numerator
        if h.is_time_code:
            time_code = h.time_code_hours * 3600 + h.time_code_minutes * 60 + h.time_code_seconds
            self.went_back = time_code * self._last[1] < self._last[0]
            self._base = Fraction(time_code)
            self._periods = 0
        else:
            self.went_back = False
            if skipped_before:
                self._periods += h.number_of_frames_to_skip
        num = self._periods * self._num
        den = self._den
        if self._base:
            num = num * self._base.denominator + self._base.numerator * den
            den *= self._base.denominator
        common = gcd(num, den)
        num //= common
        den //= common
        self._last = (num, den)
        self._periods += 1 if skipped_before else h.number_of_frames_to_skip + 1
        return num, den

    def span(self, frames: int) -> None:
        """Let further frame periods pass: a segment of 16 frames is one plane. Rules: FBA-38, DCT-13."""
        self._periods += frames
        self._last = self.after(self._last, frames)

    def after(self, time: tuple[int, int], frames: int) -> tuple[int, int]:
        """The time `frames` periods after `time`. Rules: FBA-38, DCT-13."""
        num = time[0] * self._den + frames * self._num * time[1]
        den = time[1] * self._den
        common = gcd(num, den)
        return num // common, den // common
