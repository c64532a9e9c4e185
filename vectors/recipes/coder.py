"""The arithmetic coder: models, guards, ends of segments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from snhc.reference_impl.bitstream.errors import MarkerBit
from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.base import PLANE
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import trace_stream, write_stream

from ..builders import all_lists, body, empty, inter, intra, stream
from ..manifest import CONCEAL, REJECT
from ..recipe import Accept, Reject, family, vector
from ..seeded import Seeded

_GUARD_AFTER = 22
_LOOK_AHEAD = 14


def _segments(data: bytes) -> list[SegmentTrace]:
    return [segment for part in trace_stream(data) for segment, _ in part.trace.segments.values()]


def _trailing_zeros(data: bytes, segment: SegmentTrace) -> int:
    bits = format(int.from_bytes(data, "big"), f"0{8 * len(data)}b")[segment.start : segment.end]
    return len(bits) - len(bits.rstrip("0"))


def _must(ok: bool, what: str) -> None:
    if not ok:
        raise AssertionError(f"the stream does not show what it is made for: {what}")


@vector(
    id="fap.arith.segment.one-symbol",
    title="Segments of one symbol",
    tier="syntax",
    rules=["FBA-21", "FBA-22", "FBA-23", "FBA-26"],
    features=["inter"],
)
def one_symbol() -> Accept:
    """One FAP, levels of both signs and 0: the shortest segments that hold something."""
    first = intra({48: 1})
    planes = [first, *(inter(first, {48: level}) for level in (0, -1, 600, -600, 300, 0))]
    return Accept(stream(*planes), values={(0, 48): 170, (3, 48): 102000, (6, 48): 51000})


@vector(
    id="fap.arith.guard.several",
    title="Several guards in one segment",
    tier="stress",
    rules=["FBA-25", "FBA-26"],
    features=["guard"],
    value_classes=["max"],
)
def several_guards() -> Accept:
    """Eight FAPs at the highest level: about 90 zero bits, with a guard after every 22.

    The count begins anew with the data bit behind a guard, not with the guard.
    """
    faps = (5, 10, 11, 48, 49, 50, 52, 57)
    first = intra(dict.fromkeys(faps, 1860))
    items = stream(first, inter(first, dict.fromkeys(faps, 600)))
    segments = _segments(write_stream(items))
    _must(len(segments[0].guards) >= 3 and len(segments[1].guards) >= 3, "three guards")
    return Accept(stream(first, inter(first, dict.fromkeys(faps, 600))), values={(0, 5): 3720, (1, 48): 418200})


@vector(
    id="fap.arith.guard.ends-on-22-zeros",
    title="A segment that ends on 22 zeros has no guard",
    tier="stress",
    rules=["FBA-25", "FBA-26"],
    features=["guard"],
    value_classes=["guard-22"],
)
def ends_on_22_zeros() -> Accept:
    """The last 22 bits of the segment are 0. No data bit follows, so there is no guard; an inter plane follows at once.

    A decoder that takes its bits ahead must not take a guard that is not there.
    """
    first = _ending_on_22_zeros()
    data = write_stream(stream(first, inter(first, {61: 1})))
    segment = _segments(data)[0]
    _must(_trailing_zeros(data, segment) == _GUARD_AFTER and not segment.guards, "22 zeros at the end, no guard")
    first = _ending_on_22_zeros()
    return Accept(stream(first, inter(first, {61: 1})), values={(0, 61): -55, (1, 61): -54})


def _ending_on_22_zeros() -> FbaPlane:
    v = {48: 2, 49: 2, 61: 1}
    return intra({48: 0, 49: 0, 61: -55}, ranges={"i_max": v, "i_min": v})


@vector(
    id="fap.arith.guard.ends-on-21-zeros",
    title="A segment that ends on 21 zeros, zeros behind it",
    tier="stress",
    rules=["FBA-25", "FBA-26", "FBA-27"],
    features=["guard", "look-ahead"],
    value_classes=["guard-21"],
)
def ends_on_21_zeros() -> Accept:
    """The segment ends on 21 zeros and the plane behind it begins with zeros: the count is within the segment alone.

    The 22nd zero and the bit behind it lie in the look-ahead; they belong to the next plane.
    """

    def plane() -> FbaPlane:
        v = {48: 1, 49: 1, 61: 1}
        return intra({48: 0, 49: 0, 61: -14}, ranges={"i_max": v, "i_min": v})

    first = plane()
    data = write_stream(stream(first, inter(first, {61: 1})))
    _must(_trailing_zeros(data, _segments(data)[0]) == _GUARD_AFTER - 1, "21 zeros at the end")
    first = plane()
    return Accept(stream(first, inter(first, {61: 1})), values={(0, 61): -14, (1, 61): -13})


def _guard_in_look_ahead(data: bytes, segment: SegmentTrace) -> int:
    """The value of the guard that a decoder meets behind the end of a segment, -1 where it meets none."""
    bits = format(int.from_bytes(data, "big"), f"0{8 * len(data)}b")
    zeros = _trailing_zeros(data, segment)
    for position in range(segment.end, segment.end + _LOOK_AHEAD):
        if zeros == _GUARD_AFTER:
            return int(bits[position])
        zeros = 0 if bits[position] == "1" else zeros + 1
    return -1


@vector(
    id="fap.arith.guard.in-look-ahead",
    title="A guard of value 1 in the look-ahead",
    tier="stress",
    rules=["FBA-26", "FBA-27"],
    features=["guard", "look-ahead", "plane-without-data"],
)
def guard_in_look_ahead() -> Accept:
    """The segment ends on 12 zeros; two planes without data and the first bits of the next make 22, then a 1 follows.

    The coder's 14 bits of look-ahead meet a guard there that is no guard but plane data. A decoder that goes back by
    a fixed 14 bits slips by one.
    """

    def planes() -> list[FbaPlane]:
        v = {48: 1, 49: 1}
        first = intra({48: 45, 49: 45}, ranges={"i_max": v, "i_min": v})
        return [first, empty(), empty(), inter(first, {48: 1})]

    trial = planes()
    data = write_stream(stream(*trial))
    _must(all(plane.boundary == PLANE for plane in trial), "no start code between the planes")
    _must(_guard_in_look_ahead(data, _segments(data)[0]) == 1, "a guard of value 1 in the look-ahead")
    return Accept(stream(*planes()), lines=4, values={(3, 48): 46 * 170, (3, 49): 45 * 170})


@vector(
    id="fap.arith.guard.in-look-ahead-zero",
    title="A guard of value 0 in the look-ahead",
    tier="stress",
    rules=["FBA-26", "FBA-27"],
    features=["guard", "look-ahead", "plane-without-data"],
)
def zero_guard_in_look_ahead() -> Accept:
    """The segment ends on 13 zeros and three planes without data follow: a guard of value 0 within the look-ahead.

    It is plane data and no fault. A decoder that checks guards as it fetches bits refuses the stream.
    """

    def planes() -> list[FbaPlane]:
        v = {48: 1, 49: 1}
        first = intra({48: 30, 49: 30}, ranges={"i_max": v, "i_min": v})
        return [first, empty(), empty(), empty(), inter(first, {48: 1})]

    trial = planes()
    data = write_stream(stream(*trial))
    _must(all(plane.boundary == PLANE for plane in trial), "no start code between the planes")
    _must(_guard_in_look_ahead(data, _segments(data)[0]) == 0, "a guard of value 0 in the look-ahead")
    return Accept(stream(*planes()), lines=5, values={(4, 48): 31 * 170})


def _behind_inter(levels: tuple[int, int], idle: int) -> list[FbaPlane]:
    v = {48: 1, 49: 1}
    first = intra({48: 0, 49: 0}, ranges=dict.fromkeys(all_lists(1), v))
    second = inter(first, {48: levels[0], 49: levels[1]})
    return [first, second, *(empty() for _ in range(idle)), inter(first, {48: 1})]


def _behind_bodies(levels: tuple[int, int], idle: int) -> list[FbaPlane]:
    first = body({8: 0, 9: 0}, quant=0, ranges=all_lists(1))
    second = inter(first, baps={8: levels[0], 9: levels[1]})
    return [first, second, *(empty() for _ in range(idle)), inter(first, baps={8: 1})]


def _behind_intra_bodies(levels: tuple[int, int], idle: int) -> list[FbaPlane]:
    first = body({8: levels[0], 9: levels[1]}, quant=0, ranges=all_lists(1))
    return [first, *(empty() for _ in range(idle)), inter(first, baps={8: 1})]


@family(
    {
        "inter, value 1": (_behind_inter, (45, 45), 2, 1, 1),
        "inter, value 0": (_behind_inter, (55, -21), 3, 1, 0),
        "body, value 1": (_behind_intra_bodies, (55, -21), 3, 0, 1),
        "body, value 0": (_behind_intra_bodies, (55, -21), 4, 0, 0),
        "inter body, value 1": (_behind_bodies, (55, -21), 3, 1, 1),
        "inter body, value 0": (_behind_bodies, (55, -21), 4, 1, 0),
    },
    id="fba.guard.in-look-ahead.{case}",
    title="A guard in the look-ahead of another segment: {case}",
    tier="stress",
    rules=["FBA-26", "FBA-27"],
    features=["guard", "look-ahead", "plane-without-data"],
)
def other_guards_in_look_ahead(
    case: tuple[Callable[[tuple[int, int], int], list[FbaPlane]], tuple[int, int], int, int, int],
) -> Accept:
    """The segment ends on zeros and planes without data follow: a guard within the look-ahead that is none ({case})."""
    make, levels, idle, which, value = case
    planes = make(levels, idle)
    data = write_stream(stream(*planes))
    _must(all(plane.boundary == PLANE for plane in planes), "no start code between the planes")
    _must(_guard_in_look_ahead(data, _segments(data)[which]) == value, f"a guard of value {value} in the look-ahead")
    return Accept(stream(*make(levels, idle)), lines=len(planes))


_HIGH_LEVEL = {
    "expression, value 0": ("expression", 0, (0, 0, 3, 3), 1860, 0),
    "expression, value 1": ("expression", 0, (0, 0, 3, 3), 1859, 1),
    "inter expression, value 0": ("expression", 1, (0, 0, 5, 8), 600, 0),
    "inter expression, value 1": ("expression", 1, (0, 0, 5, 8), 599, 1),
    "viseme, value 0": ("viseme", 0, (0, 7, 1), 1860, 0),
    "viseme, value 1": ("viseme", 0, (0, 14, 3), 1858, 1),
    "inter viseme, value 0": ("viseme", 1, (0, 3, 35), 600, 0),
    "inter viseme, value 1": ("viseme", 1, (1, 10, 53), 598, 1),
}


def _before_zeros(kind: str, plane: int, levels: tuple[int, ...], fap: int) -> list[FbaPlane]:
    """The segment ends on zeros, its flags are 0, and the FAP segment behind it begins with zeros."""
    none = (0,) * len(levels)

    def given(values: tuple[int, ...]) -> dict[str, Any]:
        return {kind: (*values, 0) if kind == "viseme" else (*values, 0, 0)}

    if not plane:
        return [intra(dict.fromkeys((48, 49, 50), fap), **given(levels))]
    first = intra(dict.fromkeys((48, 49, 50), 0), **given(none))
    return [first, inter(first, dict.fromkeys((48, 49, 50), fap), **given(levels))]


@family(
    _HIGH_LEVEL,
    id="fap.highlevel.guard.in-look-ahead.{case}",
    title="A guard in the look-ahead of a segment of FAP 1 or 2: {case}",
    tier="stress",
    rules=["FBA-26", "FBA-27", "FBA-28"],
    features=["guard", "look-ahead", "viseme", "expression"],
)
def high_level_look_ahead(case: tuple[str, int, tuple[int, ...], int, int]) -> Accept:
    """The segment and its flags end on zeros, the next segment begins with zeros: 22 within the look-ahead ({case}).

    What stands behind the 22nd is data of the next segment and no guard of this one.
    """
    kind, plane, levels, fap, value = case
    planes = _before_zeros(kind, plane, levels, fap)
    data = write_stream(stream(*planes))
    segment = _segments(data)[2 * plane]
    _must(_guard_in_look_ahead(data, segment) == value, f"a guard of value {value} in the look-ahead")
    return Accept(stream(*_before_zeros(kind, plane, levels, fap)), lines=len(planes))


def _rare(kind: str) -> list[FbaPlane]:
    """Planes in which nothing changes, until the largest difference is so rare that it costs more than 7 bits."""
    if kind == "viseme":
        first = intra(viseme=(0, 0, 0, 0))
        return [first, *(inter(first) for _ in range(230)), inter(first, viseme=(14, 14, 63, 0))]
    first = intra(expression=(0, 0, 0, 0, 0, 0))
    return [first, *(inter(first) for _ in range(60)), inter(first, expression=(6, 63, 6, 63, 0, 0))]


@vector(
    id="fap.highlevel.guard.viseme",
    title="A guard in a viseme segment",
    tier="stress",
    rules=["FBA-24", "FBA-25", "FBA-28"],
    features=["guard", "viseme", "inter"],
    value_classes=["max"],
)
def viseme_guard() -> Accept:
    """Three symbols make 22 zeros once their models have adapted to something else: 230 planes without a change."""
    _must(len(_segments(write_stream(stream(*_rare("viseme"))))[-2].guards) == 1, "a guard")
    line = '"viseme":{"select1":14,"select2":14,"blend":63,"def":0}'
    return Accept(stream(*_rare("viseme")), lines=232, text={231: line})


@family(
    {"viseme": "viseme", "expression": "expression"},
    id="fap.highlevel.error.guard-zero.{case}",
    title="A guard of value 0 in a segment of the {case}",
    tier="error",
    rules=["FBA-25", "FBA-28"],
    features=["guard", "viseme", "expression", "inter"],
)
def high_level_guard(kind: str) -> Reject:
    """The last plane's {case} segment has 22 zeros, and the guard behind them is 0."""
    planes = _rare(kind)
    mutation = Mutation(f"{kind}_segment", "guard", path=f"plane[{len(planes) - 1}]")
    return Reject(stream(*planes), MarkerBit, "FBA-25", (mutation,), allowed=(REJECT, CONCEAL))


@vector(
    id="fap.arith.model.adapts",
    title="P models adapt over inter planes and are reset by intra planes",
    tier="semantic",
    rules=["FBA-22", "FBA-24", "FBA-30"],
    features=["inter"],
    seed=1,
)
def models_adapt() -> Accept:
    """Sixty inter planes with small differences of four FAPs, in three periods that begin with intra planes.

    A decoder that forgets to reset, or resets too often, goes wrong soon after.
    """
    numbers = Seeded(1)
    planes: list[FbaPlane] = []
    for _ in range(3):
        first = intra({fap: numbers.between(-50, 50) for fap in (3, 31, 48, 61)})
        planes.append(first)
        planes += [inter(first, {fap: numbers.between(-3, 3) for fap in (3, 31, 48, 61)}) for _ in range(20)]
    return Accept(stream(*planes), lines=63)


_RESCALED_PLANES = 12_720


@vector(
    id="fap.arith.model.rescale",
    title="The frequencies of a model are halved",
    tier="stress",
    rules=["FBA-22", "FBA-24"],
    features=["inter", "rescale"],
    value_classes=["max-frequency"],
    seed=3,
    notes="A model of 3,721 symbols, the largest there is, reaches Max_frequency soonest: after 12,662 planes.",
)
def rescale() -> Accept:
    """One FAP over so many inter planes that the total reaches 16,383: every frequency f becomes (f + 1) / 2.

    Decoders halve to f / 2, halve after the update, or one symbol early or late: nothing fits from there on. (The
    first plane sets all FAPs to 0, which are retained: `0` is shorter than `null`, in so many lines.)
    """
    numbers = Seeded(3)
    first = intra({48: 0}, quant=0, ranges=all_lists(31))
    planes = [intra(types=dict.fromkeys(range(2, 11), 3), quant=0, ranges=all_lists(31)), first]
    value = 0
    for i in range(2, _RESCALED_PLANES):
        level = numbers.between(-2, 2) if i % 50 else numbers.between(-1860, 1860)
        # Towards 0, so that the values stay small.
        level = -abs(level) if value > 0 else abs(level)
        value += level
        planes.append(inter(first, {48: level}))
    return Accept(stream(*planes), lines=_RESCALED_PLANES, values={(_RESCALED_PLANES - 1, 48): value})
