"""Framing: start codes, stuffing, planes that follow bit by bit, and where an object ends."""

from __future__ import annotations

from collections.abc import Callable

from snhc.reference_impl.bitstream.errors import TrailingData
from snhc.reference_impl.bitstream.startcodes import DRAFT_OBJECT, DRAFT_PLANE
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.base import END, PLANE, STUFFED_END
from snhc.reference_impl.systems.stream import decode_planes, write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import body, empty, end_code, face_object, inter, intra, stream, trailing, with_code
from ..manifest import DecodeOptions
from ..recipe import Accept, Reject, family, vector


@vector(
    id="fba.framing.plane-code.every",
    title="A start code before every plane",
    tier="syntax",
    rules=["FBA-2", "FBA-3"],
    features=["plane-start-code"],
)
def code_before_every_plane() -> Accept:
    """The optional plane start code stands before every plane, the first one included (`000001BA 7F 000001BB`)."""
    first = intra({3: 5, 4: -5})
    planes = [first, inter(first, {3: 1}), inter(first, {4: 2})]
    return Accept(stream(*[with_code(plane) for plane in planes]), lines=3, values={(2, 3): 24, (2, 4): -6})


@vector(
    id="fba.framing.plane-code.some",
    title="A start code before some planes",
    tier="syntax",
    rules=["FBA-2", "FBA-3", "FBA-41"],
    features=["plane-start-code"],
)
def code_before_some_planes() -> Accept:
    """Planes with and without a start code in one object: a decoder has to look at every plane boundary."""
    first = intra({3: 5})
    planes = [first, inter(first, {3: 1}), with_code(inter(first, {3: 1})), inter(first, {3: 1}), inter(first, {3: 1})]
    return Accept(stream(*planes), lines=5, values={(4, 3): 36})


@vector(
    id="fba.framing.plane-code.first-aligned",
    title="Stuffing of a whole byte",
    tier="syntax",
    rules=["FBA-3"],
    features=["plane-start-code", "stuffing"],
    value_classes=["stuffing-8"],
)
def stuffing_when_aligned() -> Accept:
    """Stuffing is never empty: at a byte boundary it is the byte 7F."""
    return Accept(stream(with_code(intra({3: 5}))), lines=1)


def _ending_at(phase: int) -> FbaPlane:
    # Masks and levels change the length of the plane; the first that ends at the wanted bit of a byte is taken.
    for fap in (3, 31, 39, 43, 48, 51):
        for level in range(40):
            if _end_of(intra({fap: level})) % 8 == phase:
                return intra({fap: level})
    raise AssertionError(f"no plane ends at bit {phase} of a byte")


def _end_of(plane: FbaPlane) -> int:
    return next(decode_planes(write_stream(stream(plane)))).end


@family(
    {str(8 - phase): phase for phase in range(8)},
    id="fba.framing.stuffing.{case}-bits",
    title="Stuffing of {case} bits before the end code",
    tier="syntax",
    rules=["FBA-3", "FBA-26"],
    features=["stuffing"],
    value_classes=["stuffing-length"],
)
def stuffing_length(phase: int) -> Accept:
    """The last plane leaves {case} bits to the byte boundary: one 0 bit, then 1 bits, then the end code."""
    return Accept(stream(_ending_at(phase)), lines=1)


@vector(
    id="fba.framing.last-plane-short",
    title="A last plane of four bits",
    tier="syntax",
    rules=["FBA-3", "FBA-5", "FBA-41"],
    features=["plane-without-data", "stuffing"],
)
def short_last_plane() -> Accept:
    """The object ends with a plane of fewer than 8 bits in the last byte before the end code.

    Stuffing is recognised by its exact bits. A decoder that takes anything up to a byte boundary with a start code
    behind it for stuffing drops the last plane.
    """
    return Accept(stream(_ending_at(0), empty()), lines=2)


@vector(
    id="fba.framing.last-plane-zeros-stuffing",
    title="A last plane without data directly before a byte of stuffing",
    tier="syntax",
    rules=["FBA-3", "FBA-5", "FBA-42"],
    features=["plane-without-data", "stuffing"],
)
def short_last_plane_aligned() -> Accept:
    """The four zero bits of the last plane end at a byte boundary; stuffing 7F and the end code follow."""
    return Accept(stream(_ending_at(4), empty()), lines=2)


@vector(
    id="fba.framing.end.no-code",
    title="No end code: stuffing, then the end of the data",
    tier="syntax",
    rules=["FBA-1", "FBA-3"],
    features=["no-end-code"],
)
def no_end_code() -> Accept:
    """The data ends behind the stuffing without visual_object_sequence_end_code. That is odd, and no error."""
    first = intra({3: 5})
    planes = [first, inter(first, {3: 1})]
    return Accept([face_object(planes, end=STUFFED_END)], lines=2, findings=("no-end-code",))


@vector(
    id="fba.framing.end.no-code-no-stuffing",
    title="The data ends exactly behind the last plane",
    tier="syntax",
    rules=["FBA-1", "FBA-3", "FBA-27"],
    features=["no-end-code", "look-ahead"],
)
def ends_behind_plane() -> Accept:
    """The last segment ends at the last bit of the data: the look-ahead of the coder reads zeros past the end."""
    return Accept([face_object([_ending_at(0)], end=END)], lines=1, findings=("no-end-code",))


@vector(
    id="fba.framing.empty-object",
    title="An object without planes",
    tier="syntax",
    rules=["FBA-44"],
    features=["empty-object"],
    value_classes=["zero"],
)
def empty_object() -> Accept:
    """`000001BA 7F 000001B1`: legal; the decoded output is the header line alone."""
    return Accept(stream(), same_as=bytes.fromhex("000001ba7f000001b1"), lines=0, findings=("empty-object",))


@vector(
    id="fba.framing.empty-planes.five",
    title="Five planes without data in a row",
    tier="syntax",
    rules=["FBA-5", "FBA-41"],
    features=["plane-without-data", "emulation"],
)
def five_empty_planes() -> Accept:
    """Runs of planes without data are runs of zero bits: a start code has to be put in before they emulate one."""
    first = intra({3: 5})
    planes = [first, *(empty() for _ in range(5)), inter(first, {3: 1})]
    return Accept(stream(*planes), lines=7, values={(6, 3): 24}, times={6: "1/5"})


@vector(
    id="fba.framing.empty-planes.forty",
    title="Forty planes without data in a row",
    tier="stress",
    rules=["FBA-5", "FBA-41", "FBA-42"],
    features=["plane-without-data", "emulation"],
)
def forty_empty_planes() -> Accept:
    """A long pause. Each plane is a line; values are retained."""
    first = intra({3: 5, 48: -7})
    planes = [first, *(empty() for _ in range(40)), inter(first, {48: 1})]
    return Accept(stream(*planes), lines=42, values={(41, 48): -1020}, times={41: "41/30"}, states={(40, 3): "R"})


def _bodies(level: int) -> list[FbaPlane]:
    # Two of 1,201 symbols, the highest each: 21 zero bits and a 1. At bit 6: 01 | 0 0 000000000000000000000 1.
    first = body({48: level, 49: 0}, quant=0)
    return [first, inter(first, baps={48: 600, 49: 600})]


def _faces_and_bodies(level: int) -> list[FbaPlane]:
    # Three of 1,201 symbols, the highest each: 22 zero bits and the guard. At bit 5: 011 | 0 0000000000000000000000 1.
    # The empty masks of groups 5 and 6 shift everything behind them to the bit where the last plane has to stand.
    first = body({8: 0}, quant=0, face=intra({48: level, 49: 0, 50: 0}, quant=0, types={5: 1, 6: 1}))
    return [first, inter(first, {48: 600, 49: 600, 50: 600})]


def _emulating(make: Callable[[int], list[FbaPlane]]) -> list[FbaPlane]:
    """Planes whose last one stands where its bits read as stuffing and a start code prefix."""
    for level in range(200):
        planes = make(level)
        write_stream(stream(*planes))
        if planes[-1].boundary != PLANE:
            return make(level)
    raise AssertionError("no plane reads as a start code")


@vector(
    id="fba.framing.emulation.bap-plane",
    title="An inter plane of BAP data that reads as a start code",
    tier="stress",
    rules=["FBA-3", "FBA-40", "FBA-41"],
    features=["emulation", "bap"],
)
def emulated_by_bap_plane() -> Accept:
    """The bits of the last plane, at the bit where it would stand, are stuffing and 000001.

    A writer has to put a plane start code before it; without one the object would end there.
    """
    planes = _emulating(_bodies)
    return Accept(stream(*planes), lines=2)


@vector(
    id="fba.framing.emulation.face-and-body-plane",
    title="An inter plane of FAP and BAP data that reads as a start code",
    tier="stress",
    rules=["FBA-3", "FBA-40", "FBA-41"],
    features=["emulation", "bap"],
)
def emulated_by_face_and_body_plane() -> Accept:
    """As with BAP data alone, for fba_object_mask 3."""
    planes = _emulating(_faces_and_bodies)
    return Accept(stream(*planes), lines=2)


@vector(
    id="fba.framing.trailing-data",
    title="Bytes behind the end code",
    tier="syntax",
    rules=["FBA-3", "FBA-44"],
    features=["trailing-data"],
)
def trailing_data() -> Accept:
    """What follows the end code and begins no sequence or object is no part of the stream. It is no error."""
    return Accept([*stream(intra({3: 5})), trailing(b"trailing")], lines=1, findings=("trailing-data",))


@vector(
    id="fba.framing.trailing-data.strict",
    title="Bytes behind the end code, refused",
    tier="error",
    rules=["FBA-3"],
    features=["trailing-data"],
    options=DecodeOptions(strict=True),
)
def trailing_data_strict() -> Reject:
    """With the option `strict` bytes behind the end are an error."""
    data = write_stream(stream(intra({3: 5})))
    end = 8 * len(data)
    return Reject(data + b"trailing", TrailingData, "FBA-3", bits=(end, end + 64))


def _two_objects() -> list[StreamItem]:
    return [face_object([intra({3: 5})]), face_object([intra({4: 7})]), end_code()]


@vector(
    id="fba.framing.objects.first-of-two",
    title="Two objects in a file, the first is decoded",
    tier="syntax",
    rules=["FBA-3", "FBA-44"],
    features=["several-objects"],
)
def first_of_two_objects() -> Accept:
    """Decoding stops at the end of the first object: another object start code ends it."""
    return Accept(_two_objects(), lines=1, values={(0, 3): 20, (0, 4): None}, findings=("trailing-data",))


@vector(
    id="fba.framing.objects.second-of-two",
    title="Two objects in a file, the second is decoded",
    tier="syntax",
    rules=["FBA-44"],
    features=["several-objects"],
    options=DecodeOptions(object_number=1),
)
def second_of_two_objects() -> Accept:
    """The second object begins with a state of its own: FAP 3 of the first one is unset."""
    return Accept(_two_objects(), lines=1, values={(0, 3): None, (0, 4): 14})


@vector(
    id="fba.framing.draft-codes",
    title="Start codes of the drafts",
    tier="syntax",
    rules=["FBA-4"],
    features=["draft"],
    options=DecodeOptions(draft=True),
)
def draft_codes() -> Accept:
    """Object start code 00000101, plane start code 00000103: taken with the option `compat draft` only."""
    first = intra({3: 5})
    planes = [with_code(first, DRAFT_PLANE), inter(first, {3: 1}), with_code(inter(first, {3: 1}), DRAFT_PLANE)]
    return Accept(
        [face_object(planes, start_code=DRAFT_OBJECT), end_code()], lines=3, values={(2, 3): 28},
        findings=("draft-start-code",) * 3,
    )  # fmt: skip
