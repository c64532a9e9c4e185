"""Data that ends inside an element, for every class of element.

A byte has to end inside the element, so each recipe tries streams of different lengths until one does.
"""

from __future__ import annotations

from collections.abc import Iterator

from snhc.reference_impl.bitstream.errors import Truncated
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import write_faulty, write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import all_lists, body, empty, end_code, face_object, inter, intra, sequence, visual_object
from ..manifest import CONCEAL, REJECT
from ..recipe import Reject, family


def _streams() -> Iterator[tuple[list[StreamItem], str]]:
    """Streams, and the path of their plane with all fields."""
    # What stands before the plane with all fields moves it to any bit of a byte; empty masks move what is behind them.
    for variant in range(64):
        odd, groups, idle = variant & 1, variant >> 1 & 3, variant >> 3
        face = intra(
            {3: 50, 31: -60, 48: 70, 61: 80}, quant=2, types={1: 3, 5: groups & 1, 6: groups >> 1},
            ranges=all_lists(9), viseme=(3, 7, 1, 1), expression=(1, 2, 3, 1, 1, 1), rate=(25, 15, 1),
            time=(23, 59, 59), skip=15 if idle & 1 else None,
        )  # fmt: skip
        start = [intra({48: 5}, types={6: odd}), *(empty(is_intra=1) for _ in range(idle // 2))]
        first = body({8: 100, 9: 200}, ranges=all_lists(7), face=face)
        last = inter(first, {3: 100, 48: -200}, baps={8: 9}, viseme=(1, 1, 1, 0), skip=40)
        headers = [sequence(0x61), visual_object(verid=2, priority=5)]
        yield [*headers, face_object([*start, first, last]), end_code()], f"plane[{len(start)}]"


# Element -> rule. No byte ends inside visual_object_verid and visual_object_priority, which always stand at one place;
# data that ends before is_intra ends the object, and is no fault.
_ELEMENTS = {
    "profile_and_level_indication": "SYS-2",
    "visual_object_type": "SYS-4",
    "fba_object_mask": "FBA-5",
    "is_frame_rate": "FBA-6",
    "frame_rate": "FBA-6",
    "seconds": "FBA-6",
    "frequency_offset": "FBA-6",
    "is_time_code": "FBA-7",
    "time_code_hours": "FBA-7",
    "time_code_minutes": "FBA-7",
    "time_code_seconds": "FBA-7",
    "skip_frames": "FBA-8",
    "number_of_frames_to_skip": "FBA-8",
    "fap_quant": "FBA-9",
    "fap_mask_type": "FBA-10",
    "fap_group_mask": "FBA-10",
    "fba_suggested_gender": "FBA-11",
    "fba_object_coding_type": "FBA-12",
    "is_i_new_max": "FBA-13",
    "is_p_new_min": "FBA-13",
    "fap_new_i_max": "FBA-16",
    "fap_new_i_min": "FBA-16",
    "fap_new_p_max": "FBA-16",
    "fap_new_p_min": "FBA-16",
    "viseme_segment": "FBA-27",
    "viseme_def": "FBA-28",
    "expression_segment": "FBA-27",
    "init_face": "FBA-28",
    "expression_def": "FBA-28",
    "fap_segment": "FBA-27",
    "bap_quant": "FBA-40",
    "bap_mask_type": "FBA-40",
    "bap_group_mask": "FBA-40",
    "bap_suggested_gender": "FBA-40",
    "bap_new_p_max": "FBA-40",
    "bap_segment": "FBA-27",
}


def _spans(items: list[StreamItem], element: str, path: str) -> Iterator[tuple[int, int]]:
    for occurrence in range(60):
        # A flip records the span and leaves the flow as it is; what is cut off is the flipped stream's twin.
        mutation = Mutation(element, "flip", 0, path, occurrence)
        write_faulty(items, [mutation])
        if not mutation.spans:
            return
        yield mutation.spans[0]


@family(
    {element: (element, rule) for element, rule in _ELEMENTS.items()},
    id="fba.error.truncated.{case}",
    title="The data ends inside {case}",
    tier="error",
    rules=["CNF-21"],
    features=["truncated"],
    value_classes=["every-element"],
)
def truncated(case: tuple[str, str]) -> Reject:
    """The data ends inside {case}, or where it should begin. The fault lies from its first bit to the end of the data.

    A decoder may give the lines before it and accept the stream, if there are any.
    """
    element, rule = case
    # Before the object there is nothing that a decoder could go on with.
    allowed = (REJECT,) if rule.startswith("SYS") else (REJECT, CONCEAL)
    best: tuple[bytes, tuple[int, int]] | None = None
    single = False
    for items, plane in _streams():
        # In an intra plane: the first bits of an inter plane can be stuffing, which ends the object at the end of data.
        for start, end in _spans(items, element, "" if rule.startswith("SYS") else plane):
            boundary = -(-start // 8) * 8
            single = end - start == 1
            if boundary >= end:
                continue
            data = write_stream(items)[: boundary // 8]
            if boundary > start:
                return Reject(data, Truncated, rule, bits=(start, boundary), allowed=allowed)
            best = best or (data, (start, boundary))
            break
        # An element of one bit has no inside.
        if best is not None and single:
            break
    assert best is not None, element
    return Reject(best[0], Truncated, rule, bits=best[1], allowed=allowed)
