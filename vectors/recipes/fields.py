"""Small fields, value by value; planes, boundaries and ends of segments that stand nowhere else."""

from __future__ import annotations

from collections.abc import Callable

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.base import END, STUFFED_END, ZERO_PADDING
from snhc.reference_impl.syntax.faulty import Mutation

from ..builders import (
    all_lists,
    body,
    empty,
    end_code,
    face_object,
    inter,
    intra,
    sequence,
    stream,
    visual_object,
    with_code,
)
from ..dct_builders import coefficients, dct_inter, dct_intra
from ..recipe import Accept, Reject, family, vector
from .dct import NOTES, TOOLS


@vector(
    id="fba.header.rate.every-sixteenth",
    title="Every value of seconds",
    tier="semantic",
    rules=["FBA-6", "FBA-37", "FBA-38"],
    features=["frame-rate"],
    value_classes=["every-value"],
)
def sixteenths() -> Accept:
    """Sixteen planes with the rates 24, 24 1/16, .. 24 15/16: times are sums of periods 16 / (384 + i), exactly.

    1/24 + 16/385 = 769/9240.
    """
    planes = [intra({3: 1}, rate=(24, i, 0)) for i in range(16)]
    return Accept(stream(*planes), times={0: "0/1", 1: "1/24", 2: "769/9240"}, lines=16)


@vector(
    id="fba.header.skip.every-value",
    title="Every number of skipped frames 0..14",
    tier="semantic",
    rules=["FBA-8", "FBA-38"],
    features=["skip"],
    value_classes=["every-value"],
)
def skips() -> Accept:
    """Plane k at 10 Hz skips k frames: plane k lies at (1 + 2 + .. + k) / 10 seconds."""
    planes = [intra({3: 1}, rate=(10, 0, 0), skip=k) for k in range(15)]
    planes.append(intra({3: 1}))
    return Accept(stream(*planes), times={1: "1/10", 4: "1/1", 7: "14/5", 15: "12/1"})


@family(
    {str(verid): verid for verid in range(16)},
    id="sys.visual-object.verid.{case}",
    title="visual_object_verid {case}",
    tier="syntax",
    rules=["SYS-3"],
    features=["visual-object"],
    value_classes=["every-value"],
)
def verid(value: int) -> Accept:
    """visual_object_verid {case}, with one of the priorities 1..7: neither changes what the object means."""
    items = [
        sequence(0x61),
        visual_object(verid=value, priority=value % 7 + 1),
        face_object([intra({3: 5})]),
        end_code(),
    ]
    return Accept(items, values={(0, 3): 20}, findings=())


# -- planes and boundaries ---------------------------------------------------------------------------------------------


@vector(
    id="fba.plane.start-codes.all-kinds",
    title="A start code before every kind of plane",
    tier="syntax",
    rules=["FBA-2", "FBA-3", "FBA-5"],
    features=["plane-start-code", "plane-without-data", "bap"],
)
def codes_everywhere() -> Accept:
    """Planes of FAP data, BAP data, both, and none, intra and inter, each behind a start code."""
    both = body({8: 1}, face=intra({3: 1}))
    planes = [both, inter(both, {3: 1}), body({8: 2}), empty(is_intra=1), empty()]
    return Accept(stream(*(with_code(plane) for plane in planes)), values={(1, 3): 8, (4, 3): 8}, lines=5)


@family(
    {"end": END, "stuffed end": STUFFED_END, "zero padding": ZERO_PADDING},
    id="fba.object.empty.{case}",
    title="An object without planes: {case}",
    tier="syntax",
    rules=["FBA-3", "FBA-42", "FBA-44"],
    features=["empty-object"],
)
def empty_object(end: int) -> Accept:
    """The data ends behind the object start code ({case}): no lines, and no fault."""
    item = face_object([], end=end)
    assert item.fba is not None
    item.fba.padding = 32 if end == ZERO_PADDING else 0
    padding = ("zero-padding",) if end == ZERO_PADDING else ()
    return Accept([item], lines=0, findings=(*padding, "no-end-code", "empty-object"))


@family(
    {
        "viseme": lambda: intra(viseme=(1, 2, 3, 0)),
        "expression": lambda: intra(expression=(1, 2, 3, 4, 0, 0)),
        "body": lambda: body({8: 1}),
    },
    id="fba.object.ends-behind.{case}",
    title="The data ends directly behind a segment: {case}",
    tier="stress",
    rules=["FBA-26", "FBA-27"],
    features=["look-ahead", "inter"],
)
def ends_behind(first: Callable[[], FbaPlane]) -> Accept:
    """An intra plane alone, and then an inter plane behind it, without an end code ({case}).

    The coder looks 14 bits past the end of the data, where zeros are read.
    """
    plane = first()
    return Accept([face_object([plane, inter(plane)], end=STUFFED_END)], lines=2, findings=("no-end-code",))


@vector(
    id="fba.object.ends-behind.intra-body",
    title="The data ends directly behind an intra BAP segment",
    tier="stress",
    rules=["FBA-26", "FBA-27", "FBA-40"],
    features=["look-ahead", "bap"],
)
def ends_behind_body() -> Accept:
    """As above, with one intra plane of BAP data and nothing else."""
    return Accept([face_object([body({8: 1})], end=STUFFED_END)], lines=1, findings=("no-end-code",))


def _other_tails(*planes: FbaPlane) -> list[FbaPlane]:
    for plane in planes:
        for data in (plane.faps, plane.baps):
            if data is not None:
                data.tails = [1, 1, 1]
    return list(planes)


@vector(
    id="fba.segment.other-ends",
    title="Segments that do not end as an encoder ends them",
    tier="stress",
    rules=["FBA-26", "FBA-28", "FBA-40"],
    features=["inter", "bap", "viseme", "expression"],
)
def other_ends() -> Accept:
    """The last two bits of every segment are one more than an encoder sends: they decode to the same symbols.

    Viseme, expression, FAP and BAP segments, intra and inter; each is the finding segment-end.
    """
    first = body({8: 100}, face=intra({3: 50}, viseme=(3, 7, 20, 0), expression=(2, 30, 4, 40, 0, 0)))
    second = inter(first, {3: 7}, baps={8: 9}, viseme=(1, -1, 3, 0), expression=(1, 3, -1, 2, 0, 0))
    return Accept(
        stream(*_other_tails(first, second)), values={(0, 3): 200, (1, 3): 228}, findings=("segment-end",) * 8
    )


@vector(
    id="fap.highlevel.largest-differences",
    title="The largest differences of viseme and expression",
    tier="semantic",
    rules=["FBA-29", "FBA-32"],
    features=["viseme", "expression", "inter"],
    value_classes=["max", "min"],
)
def largest_differences() -> Accept:
    """From all 0 up to the largest values in one step, and back: +14, +6 and +63, then -14, -6 and -63."""
    first = intra(viseme=(0, 0, 0, 0), expression=(0, 0, 0, 0, 0, 0))
    up = inter(first, viseme=(14, 14, 63, 0), expression=(6, 63, 6, 63, 0, 0))
    down = inter(first, viseme=(-14, -14, -63, 0), expression=(-6, -63, -6, -63, 0, 0))
    line = '"viseme":{"select1":14,"select2":14,"blend":63,"def":0}'
    return Accept(stream(first, up, down), text={1: line, 2: '"viseme":{"select1":0,"select2":0,"blend":0,"def":0}'})


@vector(
    id="fap.highlevel.model.adapts",
    title="The models of the viseme adapt",
    tier="stress",
    rules=["FBA-22", "FBA-24", "FBA-28"],
    features=["viseme", "inter"],
)
def viseme_adapts() -> Accept:
    """Ninety inter planes in which nothing changes: symbols get so likely that they cost no bit, then blend moves."""
    first = intra(viseme=(3, 4, 5, 0))
    planes = [first, *(inter(first) for _ in range(90)), inter(first, viseme=(0, 0, 1, 0))]
    return Accept(stream(*planes), lines=92, text={91: '"blend":6'})


@vector(
    id="fba.body.empty-segment",
    title="BAP data that selects nothing",
    tier="syntax",
    rules=["FBA-26", "FBA-40"],
    features=["bap"],
    value_classes=["empty"],
)
def empty_body() -> Accept:
    """No group is coded: the BAP segment is two bits, in the intra plane and in the inter plane."""
    first = body({})
    return Accept(stream(first, inter(first)), lines=2)


@vector(
    id="fba.body.models-of-one-size",
    title="One BAP in an inter plane",
    tier="syntax",
    rules=["FBA-22", "FBA-40"],
    features=["bap", "ranges"],
)
def one_bap() -> Accept:
    """BAP 9 alone, which ranges of its own; levels +60, -60, 0."""
    first = body({9: 60}, quant=0, ranges=all_lists(1))
    planes = [first, *(inter(first, baps={9: level}) for level in (-60, 60, 0))]
    return Accept(stream(*planes), text={1: '"baps":{"9":0}', 3: '"baps":{"9":60}'})


# -- the DCT mode ------------------------------------------------------------------------------------------------------


@vector(
    id="fap.dct.high-level.every-select",
    title="Every viseme and expression at the head of a segment",
    tier="semantic",
    rules=["DCT-9", "DCT-10", "DCT-12"],
    features=["viseme", "expression"],
    value_classes=["every-value"],
    tools=TOOLS,
    notes=NOTES,
)
def every_select() -> Accept:
    """Fifteen intra segments: select1 of the viseme is 0..14 and select2 14..0; expressions 0..6 and 6..0.

    Only the first instant of an intra segment holds the values themselves.
    """
    planes = [
        dct_intra(viseme=[(i, 14 - i, 63 - i, 0)], expression=[(i % 7, 6 - i % 7, 63 - i, 49 + i, 0, 0)])
        for i in range(15)
    ]
    line = '"viseme":{"select1":14,"select2":0,"blend":49,"def":0}'
    return Accept(stream(*planes), lines=240, text={239: line})


@family(
    {
        **{f"select1 {value}": ("expression_select1", value) for value in range(8, 16)},
        **{f"select2 {value}": ("expression_select2", value) for value in (7, *range(9, 16))},
    },
    id="fap.dct.error.high-level.expression-{case}",
    title="Expression {case} at the head of a segment",
    tier="error",
    rules=["DCT-12"],
    features=["expression"],
    value_classes=["above-max"],
    tools=TOOLS,
    notes=NOTES,
)
def no_expression(case: tuple[str, int]) -> Reject:
    """There are seven expressions, 0..6; the field of four bits can say {case}."""
    element, to = case
    items = stream(dct_intra(expression=[(1, 1, 5, 5, 0, 0)]))
    return Reject(items, RangeViolation, "DCT-12", (Mutation(element, "wire", to),))


@vector(
    id="fap.dct.escape.zero",
    title="Escapes that hold 0",
    tier="stress",
    rules=["DCT-2", "DCT-3", "DCT-4"],
    features=["escape"],
    value_classes=["zero"],
    tools=TOOLS,
    notes=NOTES,
)
def escaped_zero() -> Accept:
    """No writer needs an escape for 0, and every escape can hold it: DC of 31 bits, differences of 16 and 32, AC of 31.

    A coefficient 0 that is sent stands at its index like any other.
    """
    first = dct_intra({3: coefficients(0, {1: 0, 2: 5}, dc_escape=1, escapes={1: 2})})
    second = dct_inter(first, {3: coefficients(0, is_intra=False, dc_escape=1)})
    third = dct_inter(first, {3: coefficients(0, is_intra=False, dc_escape=2)})
    return Accept(stream(first, second, third), lines=48, values={(47, 3): 0})
