"""Streams that the readings of the ambiguity register decode differently."""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import ForbiddenValue, MarkerBit
from snhc.reference_impl.bitstream.startcodes import FBA_OBJECT_PLANE
from snhc.reference_impl.syntax.base import BARE_CODE, ZERO_PADDING
from snhc.reference_impl.systems.stream import decode_planes, write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import all_lists, body, empty, face_object, inter, intra, stream, with_code
from ..recipe import Ambiguous, vector


@vector(
    id="fap.ambiguous.mask-order",
    title="Order of the bits of fap_group_mask",
    tier="semantic",
    rules=["FBA-10"],
    features=["mask-type-1"],
)
def mask_order() -> Ambiguous:
    """The mask 100 of group 7 selects FAP 48, or FAP 50 where the last bit stands for the lowest number."""
    first = intra({48: 5})
    return Ambiguous(stream(first, inter(first, {48: 1})), "AMB-FBA-1")


@vector(
    id="fap.ambiguous.default-range-47",
    title="Default range of FAP 47",
    tier="semantic",
    rules=["FBA-18"],
    features=["default-ranges"],
)
def default_range_47() -> Ambiguous:
    """FAP 47 is coded with its default range; the two known tables give different numbers of symbols.

    The plane behind it is such that it can be read either way.
    """
    return Ambiguous(stream(intra({47: 0}), empty(is_intra=1)), "AMB-FBA-2")


@vector(
    id="fap.ambiguous.limits-after-quant",
    title="Limits that are not sent again after a change of fap_quant",
    tier="semantic",
    rules=["FBA-17", "FBA-19"],
    features=["ranges", "fap-quant"],
)
def limits_after_quant() -> Ambiguous:
    """Limits come with fap_quant 10; the next intra plane has fap_quant 2 and sends none.

    They are divided by 2 now, or stay divided by 10. The last plane is such that it can be read either way.
    """
    first = intra({3: 20}, quant=10, ranges=all_lists(10))
    return Ambiguous(stream(first, intra({3: 1}, quant=2), empty()), "AMB-FBA-3")


@vector(
    id="fap.ambiguous.clipping",
    title="Sums outside the range",
    tier="semantic",
    rules=["FBA-32"],
    features=["inter"],
    value_classes=["above-max"],
)
def clipping() -> Ambiguous:
    """An inter plane takes FAP 3 past the intra limit, another takes it back. A decoder that clips ends elsewhere."""
    first = intra({3: 60}, ranges=all_lists(1))
    return Ambiguous(stream(first, inter(first, {3: 60}), inter(first, {3: -60})), "AMB-FBA-4")


@vector(
    id="fap.ambiguous.clipping.high-level",
    title="Intensities outside 0..63",
    tier="semantic",
    rules=["FBA-32"],
    features=["viseme", "expression", "inter"],
    value_classes=["above-max", "negative"],
)
def clipping_high_level() -> Ambiguous:
    """Blend goes to 73 and back by 10, intensity1 to -5 and back by 5: a decoder that clips ends at 53 and at 5."""
    first = intra(viseme=(1, 2, 60, 0), expression=(1, 2, 3, 40, 0, 0))
    there = inter(first, viseme=(0, 0, 13, 0), expression=(0, -7, 0, 0, 0, 0))
    back = inter(first, viseme=(0, 0, -10, 0), expression=(0, 5, 0, 0, 0, 0))
    return Ambiguous(stream(first, there, back), "AMB-FBA-4")


@vector(
    id="fba.ambiguous.base-steps",
    title="Base steps of bodies",
    tier="semantic",
    rules=["FBA-40"],
    features=["bap"],
)
def base_steps() -> Ambiguous:
    """BAP 4 at bap_quant 1: 128 or 170 for each level."""
    first = body({4: 10})
    return Ambiguous(stream(first, inter(first, baps={4: -1})), "AMB-FBA-5")


@vector(
    id="fba.ambiguous.skipped-frames",
    title="Where skipped frames lie",
    tier="semantic",
    rules=["FBA-8", "FBA-38"],
    features=["skip"],
)
def skipped_frames() -> Ambiguous:
    """The second plane skips 5 frames: they lie behind it, or before it."""
    first = intra({3: 1}, rate=(10, 0, 0))
    return Ambiguous(stream(first, inter(first, {3: 1}, skip=5), inter(first, {3: 1})), "AMB-FBA-6")


@vector(
    id="fba.ambiguous.empty-plane-header",
    title="The header of a plane without data",
    tier="semantic",
    rules=["FBA-5", "FBA-41"],
    features=["plane-without-data"],
)
def empty_plane_header() -> Ambiguous:
    """Two intra planes without data, then one with: 6 bits each with a header, 3 bits each without.

    Without a header the zero bits of it are read as planes.
    """
    first = intra({3: 5})
    return Ambiguous(stream(empty(is_intra=1), empty(is_intra=1), first), "AMB-FBA-7")


def _unstuffed() -> list[StreamItem]:
    return stream(with_code(intra({3: 5}), FBA_OBJECT_PLANE, BARE_CODE))


@vector(
    id="fba.ambiguous.unstuffed-plane",
    title="A plane start code directly behind the object start code",
    tier="semantic",
    rules=["FBA-3", "FBA-44"],
    features=["plane-start-code", "stuffing"],
)
def unstuffed_plane() -> Ambiguous:
    """000001BA 000001BB without stuffing: taken, refused, or the plane start code read as plane data.

    Read as plane data it makes six planes, and then a marker of value 0.
    """
    faults = {"error": (ForbiddenValue, "FBA-3", (32, 64)), "plane-data": (MarkerBit, "FBA-10", (88, 89))}
    return Ambiguous(_unstuffed(), "AMB-FBA-8", faults)


@vector(
    id="fba.ambiguous.trailing-zeros",
    title="Zero bits up to the end of the data",
    tier="semantic",
    rules=["FBA-42"],
    features=["zero-padding", "plane-without-data"],
)
def trailing_zeros() -> Ambiguous:
    """The last plane is followed by zero bits alone: padding, or planes without data."""
    used = next(decode_planes(write_stream(stream(intra({3: 5}))))).end
    item = face_object([intra({3: 5})], end=ZERO_PADDING)
    assert item.fba is not None
    item.fba.padding = 64 - used % 8
    return Ambiguous([item], "AMB-FBA-9", findings=("zero-padding", "no-end-code"))
