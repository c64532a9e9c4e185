"""The reference decoder for parameter texts: `.fap` and `.bap` as a player reads them.

Rules: CNF-1, CNF-2, CNF-25, FBA-50, FBA-51, FBA-53, FBA-54.

A text says what a stream made from it without loss would say (FBA-54), so the lines are those of kind `fba`: one per
frame, its time the frame number less the first one, over the rate; every frame stands for itself (`intra`). A digit 1
of the mask is state T; a parameter whose digit is 0 keeps its last value (R), or never had one (U). `baps` holds the
BAPs that the frame gives. Values are as written: nothing is clamped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from io import BytesIO
from typing import Final

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.bap_text import BapReader
from snhc.reference_impl.face.decoded import frame_line, header_line
from snhc.reference_impl.face.fap_text import FapReader
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.systems.stream import Options

_FAPS: Final = 68


def fap_lines(data: bytes, options: Options, report: Callable[[Finding], None]) -> Iterator[str]:
    """Header and frames of a `.fap` text. Rules: CNF-1, FBA-50, FBA-51, FBA-54. Raises as `FapReader`."""
    reader = FapReader(BytesIO(data), strict=options.strict, limits=options.limits)
    yield header_line("fba", options.readings)
    held: list[int | None] = [None] * _FAPS
    viseme = expression = None
    first = -1
    for index, frame in enumerate(reader):
        if first < 0:
            first = frame.number
        for i, value in enumerate(frame.values):
            if value is not None:
                held[i] = value
        viseme = frame.viseme or viseme
        expression = frame.expression or expression
        known = [viseme is not None, expression is not None, *(value is not None for value in held[2:])]
        state = "".join("T" if digit else "R" if had else "U" for digit, had in zip(frame.mask, known, strict=True))
        time = _time(frame.number - first, reader.frame_rate)
        yield frame_line(FaceFrame(index, time, True, tuple(held), viseme, expression, state))
    for finding in reader.findings():
        report(finding)


def bap_lines(data: bytes, options: Options, report: Callable[[Finding], None]) -> Iterator[str]:
    """Header and frames of a `.bap` text. Rules: CNF-1, FBA-51, FBA-53, FBA-54. Raises as `BapReader`."""
    reader = BapReader(BytesIO(data), strict=options.strict, limits=options.limits)
    yield header_line("fba", options.readings)
    first = -1
    for index, frame in enumerate(reader):
        if first < 0:
            first = frame.number
        baps = {i + 1: value for i, value in enumerate(frame.values) if value is not None}
        time = _time(frame.number - first, reader.frame_rate)
        yield frame_line(FaceFrame(index, time, True, (None,) * _FAPS, None, None, "U" * _FAPS, baps=baps))
    for finding in reader.findings():
        report(finding)


def _time(periods: int, rate: Fraction) -> tuple[int, int]:
    time = periods / rate
    return time.numerator, time.denominator
