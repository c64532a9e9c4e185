"""Streams with one fault each: what a decoder has to refuse, and where."""

from __future__ import annotations

from collections.abc import Callable

from snhc.reference_impl.bitstream.errors import (
    ForbiddenValue,
    InconsistentSemantics,
    InputFormat,
    MarkerBit,
    RangeViolation,
    ReservedValue,
    ResourceLimit,
    SnhcError,
    Truncated,
)
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import write_faulty, write_stream
from snhc.reference_impl.systems.visual import StreamItem

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
)
from ..manifest import CONCEAL, REJECT, DecodeOptions
from ..recipe import Reject, family, vector

# A decoder that does not look at markers loses nothing: they carry no data.
_MAY_CONCEAL = (REJECT, CONCEAL)


def _full() -> list[StreamItem]:
    """A stream in which most elements stand: the valid one that the mutations break."""
    face = intra(
        {3: 5, 31: -6, 48: 7, 61: 8}, quant=2, ranges=all_lists(9), viseme=(1, 2, 3, 0), expression=(1, 2, 3, 4, 0, 0),
        rate=(25, 0, 0), time=(1, 2, 3), skip=16,
    )  # fmt: skip
    first = body({8: 1, 9: 2}, ranges=all_lists(7), face=face)
    return stream(first, inter(first, {3: 1}, baps={8: 1}))


@family(
    {
        "group 1": ("plane[0].fap.group[1]", 0, "FBA-10"),
        "group 2": ("plane[0].fap.group[2]", 0, "FBA-10"),
        "group 10": ("plane[0].fap.group[10]", 0, "FBA-10"),
        "i_max first": ("plane[0].fap.new_minmax[0]", 0, "FBA-16"),
        "i_min second": ("plane[0].fap.new_minmax[1]", 1, "FBA-16"),
        "p_max in the middle": ("plane[0].fap.new_minmax[2]", 9, "FBA-16"),
        "p_min last": ("plane[0].fap.new_minmax[3]", 17, "FBA-16"),
        "time code": ("plane[0]", 0, "FBA-7"),
        "body group 1": ("plane[0].bap.group[1]", 0, "FBA-40"),
        "body group 24": ("plane[0].bap.group[24]", 0, "FBA-40"),
        "body list": ("plane[0].bap.new_minmax[2]", 3, "FBA-40"),
    },
    id="fba.error.marker.{case}",
    title="Marker bit 0: {case}",
    tier="error",
    rules=["CNF-7"],
    features=["marker"],
)
def marker(case: tuple[str, int, str]) -> Reject:
    """The marker bit is 0 ({case}); everything else is in place. A decoder may pass over it."""
    path, occurrence, rule = case
    mutation = Mutation("marker_bit", "wire", 0, path, occurrence)
    return Reject(_full(), MarkerBit, rule, (mutation,), allowed=_MAY_CONCEAL)


@family(
    {
        "hours 24": ("time_code_hours", 24),
        "hours 31": ("time_code_hours", 31),
        "minutes 60": ("time_code_minutes", 60),
        "minutes 63": ("time_code_minutes", 63),
        "seconds 60": ("time_code_seconds", 60),
        "seconds 63": ("time_code_seconds", 63),
    },
    id="fba.error.time-code.{case}",
    title="Time code out of range: {case}",
    tier="error",
    rules=["FBA-7"],
    features=["time-code"],
    value_classes=["above-max"],
)
def time_code(case: tuple[str, int]) -> Reject:
    """A field of the time code is out of its range: {case}."""
    element, value = case
    return Reject(_full(), ForbiddenValue, "FBA-7", (Mutation(element, "value", value),))


@vector(
    id="fba.error.rate-zero",
    title="Frame rate 0",
    tier="error",
    rules=["FBA-6", "FBA-37"],
    features=["frame-rate"],
    value_classes=["zero"],
)
def rate_zero() -> Reject:
    """frame_rate and seconds are both 0: there is no such rate. The fault lies over the 13 bits of the rate."""
    return Reject(stream(intra({3: 1}, rate=(0, 0, 1))), ForbiddenValue, "FBA-37", bits=(36, 49))


@vector(
    id="fba.error.rate-zero.second-plane",
    title="Frame rate 0 in a later plane",
    tier="error",
    rules=["FBA-37"],
    features=["frame-rate"],
    value_classes=["zero"],
)
def rate_zero_later() -> Reject:
    """The line of the first plane stands; the second plane is at fault."""
    mutation = Mutation("frame_rate", "value", 0, "plane[1]")
    items = stream(intra({3: 1}, rate=(25, 0, 0)), intra({3: 1}, rate=(25, 0, 0)))
    write_faulty(items, [mutation])
    start = mutation.spans[0][0]
    return Reject(
        items, ForbiddenValue, "FBA-37", (Mutation("frame_rate", "value", 0, "plane[1]"),), (start, start + 13)
    )


@vector(
    id="fba.error.body.mask-type-2",
    title="Body mask type 2",
    tier="error",
    rules=["FBA-40"],
    features=["bap", "mask-type-2"],
)
def body_mask_type() -> Reject:
    """Mask type 2 does not exist for bodies."""
    return Reject(_full(), ForbiddenValue, "FBA-40", (Mutation("bap_mask_type", "value", 2, "plane[0].bap.group[5]"),))


@family(
    {
        "viseme select 15": ((14, 0, 0), (1, 0, 0)),
        "viseme select negative": ((0, 0, 0), (0, -1, 0)),
        "viseme select far out": ((14, 14, 0), (0, 14, 0)),
    },
    id="fba.error.select.{case}",
    title="Select out of range: {case}",
    tier="error",
    rules=["FBA-29", "FBA-32"],
    features=["viseme"],
    value_classes=["above-max", "negative"],
)
def viseme_select(case: tuple[tuple[int, int, int], tuple[int, int, int]]) -> Reject:
    """An inter difference takes a select of the viseme out of 0..14: {case}."""
    start, difference = case

    def items() -> list[StreamItem]:
        first = intra(viseme=(*start, 0))
        return stream(first, inter(first, viseme=(*difference, 0)))

    return Reject(items(), RangeViolation, "FBA-32", bits=_span(items(), "viseme_segment", "plane[1]"))


@family(
    {"7": ((6, 0, 0, 0), (1, 0, 0, 0)), "negative": ((0, 0, 2, 0), (0, 0, -3, 0))},
    id="fba.error.select.expression-{case}",
    title="Expression select out of range: {case}",
    tier="error",
    rules=["FBA-29", "FBA-32"],
    features=["expression"],
    value_classes=["above-max", "negative"],
)
def expression_select(case: tuple[tuple[int, int, int, int], tuple[int, int, int, int]]) -> Reject:
    """An inter difference takes a select of the expression out of 0..6 ({case})."""
    start, difference = case

    def items() -> list[StreamItem]:
        first = intra(expression=(*start, 0, 0))
        return stream(first, inter(first, expression=(*difference, 0, 0)))

    return Reject(items(), RangeViolation, "FBA-32", bits=_span(items(), "expression_segment", "plane[1]"))


def _span(items: list[StreamItem], element: str, path: str = "", occurrence: int = 0) -> tuple[int, int]:
    """Where the writer puts an element."""
    # A flip of the element records its span; for a segment it changes nothing.
    mutation = Mutation(element, "flip", 0, path, occurrence)
    write_faulty(items, [mutation])
    return mutation.spans[0]


@vector(
    id="fap.arith.error.guard-zero",
    title="A guard of value 0",
    tier="error",
    rules=["FBA-25", "FBA-27"],
    features=["guard"],
)
def guard_zero() -> Reject:
    """The guard of worked stream 2 is 0. A decoder may pass over it: it carries no data."""
    first = intra({48: 1860, 49: 1860}, rate=(25, 0, 0))
    items = stream(first, inter(first, {48: -3, 49: 2}))
    return Reject(items, MarkerBit, "FBA-25", (Mutation("fap_segment", "guard"),), allowed=_MAY_CONCEAL)


@vector(
    id="fap.arith.error.guard-zero.second",
    title="Three guards of value 0 in an inter plane",
    tier="error",
    rules=["FBA-25", "FBA-27"],
    features=["guard", "inter"],
)
def guard_zero_inter() -> Reject:
    """All guards of the segment are 0; the first is the one reported. The line of the intra plane stands."""
    faps = (5, 10, 11, 48, 49, 50, 52, 57)
    first = intra(dict.fromkeys(faps, 0))
    items = stream(first, inter(first, dict.fromkeys(faps, 600)))
    mutation = Mutation("fap_segment", "guard", path="plane[1]")
    return Reject(items, MarkerBit, "FBA-25", (mutation,), allowed=_MAY_CONCEAL)


@family(
    {
        # Nothing is selected yet, so the segment is empty.
        "faps": lambda: [inter(intra())],
        "baps": lambda: [inter(body({}))],
    },
    id="fba.error.inter-first.{case}",
    title="Inter plane first: {case}",
    tier="error",
    rules=["FBA-35"],
    features=["inter"],
)
def inter_first(planes: Callable[[], list[FbaPlane]]) -> Reject:
    """The first plane with data ({case}) is an inter plane: there is nothing to add to. The fault is is_intra."""
    return Reject(stream(*planes()), InconsistentSemantics, "FBA-35", bits=(32, 33))


@vector(
    id="fba.error.inter-first.behind-body",
    title="Inter FAP data behind intra BAP data",
    tier="error",
    rules=["FBA-35", "FBA-40"],
    features=["inter", "bap"],
)
def inter_behind_body() -> Reject:
    """An intra plane of BAP data does not make an inter plane of FAP data decodable."""

    def items() -> list[StreamItem]:
        return stream(empty(), body({8: 1}), inter(intra()))

    return Reject(items(), InconsistentSemantics, "FBA-35", bits=_span(items(), "is_intra", "plane[2]"))


@vector(
    id="fba.error.limit.idle-planes",
    title="1,025 planes without data in a row",
    tier="error",
    rules=["FBA-42", "CNF-22"],
    features=["plane-without-data", "limits"],
    value_classes=["above-limit"],
)
def idle_planes() -> Reject:
    """More than 1,024 consecutive planes without data, no start code between them. Other decoders may have no limit."""

    def items() -> list[StreamItem]:
        # Intra planes without data begin with a 1, so that nothing reads as a start code.
        return stream(intra({3: 1}), *(empty(is_intra=1) for _ in range(1025)))

    start = _span(items(), "is_intra", "plane[1025]")[0]
    return Reject(items(), ResourceLimit, "FBA-42", bits=(start, start + 6), allowed=_MAY_CONCEAL)


@vector(
    id="fba.error.limit.skipped-frames",
    title="More frames skipped than the limit allows",
    tier="error",
    rules=["FBA-8", "FBA-44", "CNF-22", "CNF-26"],
    features=["skip", "limits"],
    value_classes=["above-limit"],
    options=DecodeOptions(limits={"skipped_frames": 40}),
)
def skipped_frames() -> Reject:
    """The limit is lowered to 40, the plane skips 50 frames: 15, 15, 15 pass it."""

    def items() -> list[StreamItem]:
        return stream(intra({3: 1}, skip=50))

    start = _span(items(), "number_of_frames_to_skip")[0]
    return Reject(items(), ResourceLimit, "FBA-8", bits=(start, start + 12))


@family(
    {
        "empty": (b"", (0, 0)),
        "three bytes": (b"\x00\x00\x01", (0, 24)),
        "text": (b"2.1 name 25 1\n", (0, 32)),
        "zeros": (bytes(64), (0, 32)),
        "no prefix": (bytes.fromhex("010001ba7f000001b1"), (0, 32)),
        "unknown code": (bytes.fromhex("000001dd7f000001b1"), (0, 32)),
    },
    id="fba.error.input.{case}",
    title="No known start code: {case}",
    tier="error",
    rules=["FBA-1", "FBA-44"],
    features=["input-format"],
)
def no_start_code(case: tuple[bytes, tuple[int, int]]) -> Reject:
    """The data begins with no start code of a visual stream: {case}."""
    data, bits = case
    return Reject(data, InputFormat, "FBA-1", bits=bits)


@vector(
    id="fba.error.start-code-cut",
    title="Stuffing, a prefix, and the end of the data",
    tier="error",
    rules=["FBA-3", "FBA-44"],
    features=["truncated"],
)
def start_code_cut() -> Reject:
    """The data ends within the end code: 000001 is there, its last byte is not."""
    data = write_stream(stream(intra({3: 5})))[:-1]
    end = 8 * len(data)
    return Reject(data, Truncated, "FBA-44", bits=(end - 24, end), allowed=_MAY_CONCEAL)


@family(
    {str(value): ("visual_object_type", value, ReservedValue, "SYS-4") for value in (0, *range(6, 16))},
    id="sys.error.object-type.{case}",
    title="visual_object_type {case}",
    tier="error",
    rules=["SYS-4"],
    features=["visual-object"],
    value_classes=["reserved"],
)
def object_type(case: tuple[str, int, type[SnhcError], str]) -> Reject:
    """The value {case} of visual_object_type is not assigned."""
    element, value, error, rule = case
    items = [sequence(0x61), visual_object(), face_object([intra({3: 5})]), end_code()]
    return Reject(items, error, rule, (Mutation(element, "wire", value),))


@vector(
    id="sys.error.priority-zero",
    title="visual_object_priority 0",
    tier="error",
    rules=["SYS-3"],
    features=["visual-object"],
    value_classes=["reserved", "zero"],
)
def priority_zero() -> Reject:
    """Priorities are 1..7; 0 is reserved."""
    items = [sequence(0x61), visual_object(verid=1), face_object([intra({3: 5})]), end_code()]
    return Reject(items, ReservedValue, "SYS-3", (Mutation("visual_object_priority", "wire", 0),))


@vector(
    id="sys.error.object-of-other-type",
    title="A mesh object where the header names a face object",
    tier="error",
    rules=["SYS-6"],
    features=["visual-object"],
)
def wrong_object() -> Reject:
    """visual_object_type is 4, and mesh_object_start_code follows."""
    data = write_stream([sequence(0x61), visual_object(), face_object([]), end_code()])
    at = data.index(bytes.fromhex("000001ba"))
    data = data[:at] + bytes.fromhex("000001bc") + data[at + 4 :]
    return Reject(data, InconsistentSemantics, "SYS-6", bits=(8 * at, 8 * at + 32))


@vector(
    id="sys.error.no-object",
    title="A sequence without an object",
    tier="error",
    rules=["SYS-2"],
    features=["visual-object"],
)
def no_object() -> Reject:
    """The end code stands where visual_object() must."""
    data = bytes.fromhex("000001b061000001b1")
    return Reject(data, InconsistentSemantics, "SYS-2", bits=(40, 72))


@vector(
    id="sys.error.object-without-header",
    title="A face object in a sequence, without visual_object() before it",
    tier="error",
    rules=["SYS-2"],
    features=["visual-object"],
)
def object_without_header() -> Reject:
    """fba_object_start_code directly behind profile_and_level_indication."""
    data = bytes.fromhex("000001b061") + write_stream([face_object([intra({3: 5})]), end_code()])
    return Reject(data, InconsistentSemantics, "SYS-2", bits=(40, 72))


@vector(
    id="sys.error.end-code-for-object",
    title="The end code where the object must stand",
    tier="error",
    rules=["SYS-6"],
    features=["visual-object"],
)
def end_code_for_object() -> Reject:
    """visual_object_type is 4, and visual_object_sequence_end_code follows."""
    data = bytes.fromhex("000001b061000001b523000001b1")
    return Reject(data, InconsistentSemantics, "SYS-6", bits=(80, 112))


@vector(
    id="sys.error.stuffing",
    title="Wrong stuffing behind the visual object header",
    tier="error",
    rules=["SYS-3", "FBA-3"],
    features=["visual-object", "stuffing"],
)
def object_stuffing() -> Reject:
    """Zero bits up to the byte boundary instead of one 0 and then 1 bits."""
    items = [sequence(0x61), visual_object(), face_object([intra({3: 5})]), end_code()]
    return Reject(items, ForbiddenValue, "FBA-3", (Mutation("stuffing", "wire", 0),), allowed=_MAY_CONCEAL)
