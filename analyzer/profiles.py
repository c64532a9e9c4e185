"""Whether a stream keeps to a profile and level: what was measured, the limit where one is known, the verdict.

Rules: SYS-8, SYS-9, SYS-10, SYS-11, SYS-12. Tools outside the signalled profile are found by the reader itself (SYS-9);
what is asked for instead of what is signalled is looked at here.

Limits are known for the Simple Face object type only, in Simple Face Animation. Everything else is measured and
`not_checked`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Final

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.bitstream.startcodes import VISUAL_OBJECT_SEQUENCE
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options
from snhc.reference_impl.systems.visual import AnyPlane, tools_outside
from snhc.reference_impl.tables import ProfileLevel, profile_level_codes

from .windows import Peak, RunningPeak, collected_peaks, sized_planes, time_of

PASS: Final = "pass"
FAIL: Final = "fail"
NOT_CHECKED: Final = "not_checked"
INFO: Final = "info"
_SHORT: Final = "animation"
"""A word that names of profiles may leave out: `simple-face@L1`."""


@dataclass(frozen=True, slots=True)
class _Limits:
    faces: int
    bit_rate: int  # bit/s over all faces
    frame_rate: int  # Hz over all faces: what a decoder must render
    rate_finding: str


# SYS-10: the Simple Face object type.
_SIMPLE_FACE: Final = {
    1: _Limits(1, 16_000, 15, "rate-above-15"),
    2: _Limits(4, 32_000, 60, "rate-sum-above-60"),
}


@dataclass(frozen=True, slots=True)
class Criterion:
    """One measured quantity.

    Rules: SYS-10, SYS-11, SYS-12. `limit`: the largest allowed value, None where none is known or it does not bind.
    `verdict`: pass, fail, not_checked (the limit is not in our sources), info (there is none). `detail`: where it was
    measured, in words.
    """

    name: str
    unit: str
    measured: Fraction
    limit: Fraction | None
    verdict: str
    detail: str = ""

    def as_json(self) -> dict[str, Any]:
        """Exact numbers as in CNF-1."""
        return {
            "name": self.name, "unit": self.unit, "measured": _exact(self.measured),
            "limit": None if self.limit is None else _exact(self.limit), "verdict": self.verdict, "detail": self.detail,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class LevelReport:
    """A stream against a profile and level.

    Rules: SYS-8, SYS-10. `signalled`: the indication of the first sequence, None without one. `checked`: what the
    stream was held against, None where that is no known profile. `asked`: it was asked for, not signalled. `outside`:
    there is data of a tool that what was checked does not contain.
    """

    signalled: int | None
    checked: ProfileLevel | None
    asked: bool
    criteria: tuple[Criterion, ...]
    findings: tuple[Finding, ...]
    outside: bool

    @property
    def verdict(self) -> str:
        """`fail` where a criterion fails or a tool lies outside; not_checked where a limit is unknown; else `pass`."""
        verdicts = {criterion.verdict for criterion in self.criteria}
        if FAIL in verdicts or self.outside:
            return FAIL
        return NOT_CHECKED if NOT_CHECKED in verdicts else PASS

    def as_json(self) -> dict[str, Any]:
        """The report; its keys stand in docs/check.md."""
        return {
            "format": "snhc-profile", "version": 1,
            "signalled": self.signalled,
            "checked": None if self.checked is None else name_of(self.checked),
            "asked": self.asked,
            "verdict": self.verdict,
            "criteria": [criterion.as_json() for criterion in self.criteria],
        }  # fmt: skip


def name_of(entry: ProfileLevel) -> str:
    """`simple-face-animation@L1`. Rules: SYS-8."""
    return f"{entry.profile.lower().replace(' ', '-')}@L{entry.level}"


def profile_of(text: str) -> ProfileLevel | None:
    """The profile and level that a text of the form NAME@LEVEL names; None for none.

    Rules: SYS-8. Case, blanks and hyphens do not count, nor does the word `animation` (`simple-face@L1`, `Simple Face
    Animation@1`).
    """
    name, _, level = text.partition("@")
    wanted = (_plain(name), re.sub(r"^[lL]", "", level.strip()))
    for entry in profile_level_codes():
        if (_plain(entry.profile), str(entry.level)) == wanted:
            return entry
    return None


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]+", "", name.lower().replace(_SHORT, ""))


@dataclass(slots=True)
class _Object:
    number: int
    planes: int = 0
    bits: int = 0
    first: Fraction = Fraction(0)
    last: Fraction = Fraction(0)
    # The windows with most bits and most planes; None where they are not known.
    peaks: tuple[Peak | None, Peak | None] | None = None
    rates: set[Fraction] = field(default_factory=set)
    tools: dict[str, int] = field(default_factory=dict)  # name -> first bit of the plane that has it
    first_data: Fraction | None = None
    end: Fraction = Fraction(0)


def check_profile(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    asked: ProfileLevel | None = None,
    on_finding: Callable[[Finding], None] = lambda finding: None,
) -> LevelReport:
    """Measure all objects of a stream and hold them against a profile and level, by default the signalled one.

    Rules: SYS-8..12. `on_finding` gets what reading the stream finds; what only this check finds stands in the report.
    Memory does not grow with the stream, but where windows of one second reach over several objects or a clock that
    goes back: then times and sizes of planes are kept, in a second reading. Raises what ends the stream.
    """
    in_stream: set[str] = set()

    def found(finding: Finding) -> None:
        in_stream.add(finding.id)
        on_finding(finding)

    objects: list[_Object] = []
    # Of the object that is read: a stream may hold very many.
    fullest, busiest = RunningPeak(), RunningPeak()

    def ended() -> None:
        if objects:
            peaks = fullest.peak(), busiest.peak()
            objects[-1].peaks = peaks if fullest.ordered else None

    signalled: int | None = None
    for number, item, plane, bits in sized_planes(source, options, found):
        if number == len(objects):
            ended()
            objects.append(_Object(number))
            fullest, busiest = RunningPeak(), RunningPeak()
        if plane is not None:
            time = time_of(plane)
            fullest.add(time, bits)
            busiest.add(time, 1)
            _take(objects[-1], plane, time, bits)
        elif signalled is None and item.code == VISUAL_OBJECT_SEQUENCE:
            signalled = item.profile
    ended()
    known = next((row for row in profile_level_codes() if row.code == signalled), None)
    checked = asked if asked is not None else known

    def collected(wanted: set[int]) -> tuple[Peak | None, Peak | None]:
        return collected_peaks(source, options, wanted)

    criteria = tuple(_criteria(objects, checked, options.readings, collected))
    own = tuple(_findings(objects, known, checked, criteria))
    # The reader looks at what is signalled.
    seen = in_stream if checked == known else {finding.id for finding in own}
    return LevelReport(signalled, checked, asked is not None, criteria, own, "profile-tool" in seen)


def _take(one: _Object, plane: AnyPlane, time: Fraction, bits: int) -> None:
    one.first = min(one.first, time) if one.planes else time
    one.last = max(one.last, time) if one.planes else time
    one.planes += 1
    one.bits += bits
    if plane.header.is_frame_rate:
        rate = Fraction(plane.header.frame_rate * 16 + plane.header.seconds, 16)
        one.rates.add(rate * 1000 / 1001 if plane.header.frequency_offset else rate)
    elif not one.rates:
        one.rates.add(Fraction(30))
    last = Fraction(*plane.frames[-1].time)
    if isinstance(plane, FbaPlane):
        if plane.fba_object_mask & 1:
            one.tools.setdefault("face", plane.start)
            one.first_data = time if one.first_data is None else min(one.first_data, time)
            one.end = max(one.end, last)
        if plane.fba_object_mask & 2:
            one.tools.setdefault("body", plane.start)
    else:
        one.tools.setdefault("mesh", plane.start)


def _criteria(
    objects: list[_Object],
    checked: ProfileLevel | None,
    readings: Readings,
    collected: Callable[[set[int]], tuple[Peak | None, Peak | None]],
) -> Iterator[Criterion]:
    simple_face = checked is not None and checked.profile == "Simple Face Animation"
    limits = _SIMPLE_FACE.get(checked.level) if checked is not None and simple_face else None
    faces = [one for one in objects if one.first_data is not None]
    count = _overlapping(faces)
    yield _criterion("faces", "faces at the same time", Fraction(count), limits.faces if limits else None)

    # Without a face profile everything that the stream holds is measured.
    measured = faces if limits else objects
    with_planes = [one for one in measured if one.planes]
    known = with_planes[0].peaks if len(with_planes) == 1 else None
    fullest, busiest = known or collected({one.number for one in with_planes})
    peak = fullest or Peak(Fraction(0), 0, 0)
    detail = f"largest window of 1 s, from {_seconds(peak.start)}: {peak.bits} bits, {peak.planes} planes"
    yield _criterion("bit_rate", "bit/s", Fraction(peak.bits), limits.bit_rate if limits else None, detail)
    free = INFO if limits else NOT_CHECKED
    yield Criterion("mean_bit_rate", "bit/s", _mean(measured), None, free)
    rate = sum((max(one.rates) for one in measured if one.rates), Fraction(0))
    bound = limits.frame_rate if limits and readings.chosen.get("AMB-SYS-2") == "coded" else None
    declared = _criterion("frame_rate", "Hz", rate, bound, "declared, the sum over all objects")
    yield declared if bound is not None else replace(declared, verdict=free)
    count = busiest.bits if busiest is not None else 0
    yield Criterion("planes_per_second", "planes", Fraction(count), None, free, "in the busiest second")


def _criterion(name: str, unit: str, measured: Fraction, limit: int | None, detail: str = "") -> Criterion:
    if limit is None:
        return Criterion(name, unit, measured, None, NOT_CHECKED, detail)
    return Criterion(name, unit, measured, Fraction(limit), PASS if measured <= limit else FAIL, detail)


def _overlapping(faces: list[_Object]) -> int:
    """The largest number of faces whose FAP data covers the same time."""
    events = [(one.first_data, 0, 1) for one in faces if one.first_data is not None]
    events += [(one.end, 1, -1) for one in faces]
    most = now = 0
    for _, _, step in sorted(events):
        now += step
        most = max(most, now)
    return most


def _mean(objects: list[_Object]) -> Fraction:
    with_planes = [one for one in objects if one.planes]
    if not with_planes:
        return Fraction(0)
    period = 1 / min(rate for one in with_planes for rate in one.rates)
    first, last = min(one.first for one in with_planes), max(one.last for one in with_planes)
    return sum(one.bits for one in with_planes) / (last - first + period)


def _findings(
    objects: list[_Object], known: ProfileLevel | None, checked: ProfileLevel | None, criteria: tuple[Criterion, ...]
) -> Iterator[Finding]:
    if checked is not None and checked != known:
        outside = tools_outside(checked.code)
        for tool in sorted(outside):
            first = min((one.tools[tool] for one in objects if tool in one.tools), default=None)
            if first is not None:
                text = f"{tool} data, which {checked.profile} does not contain"
                yield Finding("profile-tool", "error", "SYS-9", text, (first, first + 1))
    for criterion in criteria:
        if criterion.verdict == FAIL and criterion.limit is not None:
            text = f"{_number(criterion.measured)} {criterion.unit}, the level allows {_number(criterion.limit)}" + (
                f" ({criterion.detail})" if criterion.detail else ""
            )
            yield Finding(f"level-{criterion.name.replace('_', '-')}", "error", _RULES[criterion.name], text)
    if checked is None or checked.profile != "Simple Face Animation":
        return
    limits = _SIMPLE_FACE[checked.level]
    rate = next(criterion.measured for criterion in criteria if criterion.name == "frame_rate")
    if rate > limits.frame_rate and not any(c.name == "frame_rate" and c.verdict == FAIL for c in criteria):
        text = f"{_number(rate)} Hz declared, a decoder of level {checked.level} must render {limits.frame_rate} Hz"
        yield Finding(limits.rate_finding, "info", "SYS-12", text)


_RULES: Final = {"faces": "SYS-10", "bit_rate": "SYS-11", "frame_rate": "SYS-12"}


def report_lines(report: LevelReport) -> Iterator[str]:
    """The report for people, line by line. Rules: SYS-10."""
    if report.checked is None:
        signalled = "nothing" if report.signalled is None else f"0x{report.signalled:02X}"
        yield f"profile: the stream signals {signalled}; measured only\n"
    else:
        how = "as asked" if report.asked else "as signalled"
        yield f"profile: {report.checked.profile} L{report.checked.level} ({how}): {report.verdict}\n"
    width = max(len(criterion.name) for criterion in report.criteria)
    for criterion in report.criteria:
        limit = f", at most {_number(criterion.limit)}" if criterion.limit is not None else ""
        verdict = f": {criterion.verdict}" if criterion.verdict != INFO else ""
        detail = f"  ({criterion.detail})" if criterion.detail else ""
        yield f"  {criterion.name:<{width}}  {_number(criterion.measured)} {criterion.unit}{limit}{verdict}{detail}\n"


def _number(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else f"{float(value):.3f}"


def _seconds(value: Fraction) -> str:
    return f"{float(value):.3f} s"


def _exact(value: Fraction) -> int | str:
    return value.numerator if value.denominator == 1 else f"{value.numerator}/{value.denominator}"
