"""DCT streams with one fault each. The entropy tables are those of profile P1, which are provisional."""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, MarkerBit, RangeViolation, Truncated
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import write_faulty
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import stream
from ..dct_builders import coefficients, dct_inter, dct_intra, listed
from ..manifest import CONCEAL, REJECT
from ..recipe import Reject, family, vector
from .dct import NOTES, TOOLS


@family(
    {"14": (1, 14), "10": (5, 10), "7": (9, 7), "1": (14, 1)},
    id="fap.dct.error.run-past-end.{case}",
    title="Run {case} leads past index 15",
    tier="error",
    rules=["DCT-4"],
    features=["run"],
    value_classes=["max"],
    tools=TOOLS,
    notes=NOTES,
)
def run_past_end(case: tuple[int, int]) -> Reject:
    """Behind a coefficient, a run of {case} zeros whose coefficient would stand at index 16.

    A decoder that does not look writes behind its array.
    """
    before, run = case
    plane = dct_intra({3: coefficients(1, {before: 2, 15: 3}), 4: listed([1])})
    return Reject(stream(plane), RangeViolation, "DCT-4", (Mutation("run", "value", run, "plane[0].fap.fap[3]", 1),))


@vector(
    id="fap.dct.error.run-past-end.in-inter",
    title="Run past index 15 in an inter segment",
    tier="error",
    rules=["DCT-4"],
    features=["inter", "run"],
    tools=TOOLS,
    notes=NOTES,
)
def run_past_end_inter() -> Reject:
    """The 16 lines of the intra segment are good."""
    first = dct_intra({3: coefficients(1, {4: 2})})
    second = dct_inter(first, {3: coefficients(1, {9: 2, 12: 1}, is_intra=False)})
    return Reject(stream(first, second), RangeViolation, "DCT-4", (Mutation("run", "value", 6, "plane[1]", 1),))


@family(
    {
        "viseme select1 15": ("viseme_select1", 15, 0),
        "viseme select2 15": ("viseme_select2", 15, 0),
        "expression select1 7": ("expression_select1", 7, 0),
        "expression select2 8": ("expression_select2", 8, 0),
        "viseme select1 above": ("viseme_select1_difference", 28, 1),
        "viseme select2 below": ("viseme_select2_difference", 0, 1),
        "blend above": ("viseme_blend_difference", 126, 1),
        "blend below": ("viseme_blend_difference", 0, 1),
        "expression select1 above": ("expression_select1_difference", 12, 1),
        "expression select2 below": ("expression_select2_difference", 0, 1),
        "intensity1 above": ("expression_intensity1_difference", 126, 1),
        "intensity2 below": ("expression_intensity2_difference", 0, 1),
    },
    id="fap.dct.error.high-level.{case}",
    title="Outside its set: {case}",
    tier="error",
    rules=["DCT-12"],
    features=["expression", "viseme"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)
def high_level(case: tuple[str, int, int]) -> Reject:
    """A select or intensity leaves its legal set ({case}), at its first value or by a difference."""
    element, to, plane = case
    first = dct_intra(viseme=[(1, 1, 5, 0)], expression=[(1, 1, 5, 5, 0, 0)])
    second = dct_inter(first, viseme=[(1, 1, 5, 0)], expression=[(1, 1, 5, 5, 0, 0)])
    # On the wire only: what follows need not make sense any more, and cannot always be written.
    mutation = Mutation(element, "wire", to, f"plane[{plane}]")
    return Reject(stream(first, second), RangeViolation, "DCT-12", (mutation,))


def _all_escapes() -> list[StreamItem]:
    first = dct_intra({3: coefficients(40_000, {1: 300, 2: -40_000}), 4: listed([4])})
    later = [
        {3: coefficients(300, {1: 300, 2: -40_000}, is_intra=False)},
        {3: coefficients(-70_000, {1: 1}, is_intra=False)},
    ]
    return stream(first, *(dct_inter(first, faps) for faps in later))


@family(
    {
        name: (name, rule)
        for name, rule in (
            ("dc", "DCT-2"),
            ("dc_escape", "DCT-2"),
            ("dc_difference_escape", "DCT-3"),
            ("dc_difference_escape_wide", "DCT-3"),
            ("ac_escape", "DCT-4"),
            ("ac_escape_wide", "DCT-4"),
        )
    },
    id="fap.dct.error.truncated.{case}",
    title="The data ends inside {case}",
    tier="error",
    rules=["CNF-21"],
    features=["escape", "truncation"],
    tools=TOOLS,
    notes=NOTES,
)
def truncated(case: tuple[str, str]) -> Reject:
    """The data ends inside the field {case}; the span runs to the end of the data."""
    element, rule = case
    mutation = Mutation(element, "cut", 8)
    data = write_faulty(_all_escapes(), [mutation])
    return Reject(data, Truncated, rule, bits=(mutation.spans[0][0], 8 * len(data)))


@vector(
    id="fap.dct.error.inter-first",
    title="An inter segment before any intra segment",
    tier="error",
    rules=["DCT-13", "FBA-35"],
    features=["inter"],
    tools=TOOLS,
    notes=NOTES,
)
def inter_first() -> Reject:
    """is_intra of the only plane is 0: nothing says which FAPs there are."""
    mutation = Mutation("is_intra", "wire", 0)
    return Reject(stream(dct_intra({3: listed([4])})), InconsistentSemantics, "FBA-35", (mutation,))


@family(
    {"group 1": 1, "group 10": 10},
    id="fap.dct.error.marker.{case}",
    title="Marker bit 0 behind a DCT segment: {case}",
    tier="error",
    rules=["FBA-10", "DCT-15"],
    features=["marker"],
    tools=TOOLS,
    notes=NOTES,
)
def marker(group: int) -> Reject:
    """The marker of {case} of the second plane is 0. Its 16 lines cannot come; a decoder may pass over the bit."""
    plane = dct_intra({3: listed([4, 1])})
    mutation = Mutation("marker_bit", "wire", 0, f"plane[1].fap.group[{group}]")
    return Reject(
        stream(plane, dct_intra({3: listed([-4])})), MarkerBit, "FBA-10", (mutation,), allowed=(REJECT, CONCEAL)
    )


@vector(
    id="fap.dct.error.truncated.behind-segment",
    title="The data ends inside the segment behind a good one",
    tier="error",
    rules=["CNF-21", "DCT-2", "DCT-13"],
    features=["truncation"],
    tools=TOOLS,
    notes=NOTES,
)
def truncated_segment() -> Reject:
    """Of 20 DC values of the second plane the last is cut: 16 lines of the first plane, none of the second."""
    plane = dct_intra({3: listed([4])})
    second = dct_intra({fap: listed([1_000]) for fap in range(3, 23)})
    mutation = Mutation("dc", "cut", 8, "plane[1].fap.fap[22]")
    data = write_faulty(stream(plane, second), [mutation])
    return Reject(data, Truncated, "DCT-2", bits=(mutation.spans[0][0], 8 * len(data)))
