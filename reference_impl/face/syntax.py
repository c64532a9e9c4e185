"""The syntax of FBA objects: every table once, for all machines.

Rules: FBA-1, FBA-2, FBA-3, FBA-5, FBA-9..13, FBA-15, FBA-16, FBA-28, FBA-35, FBA-40, FBA-41, FBA-42, FBA-44.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from ..bitstream.errors import (
    ForbiddenValue,
    InconsistentSemantics,
    RangeViolation,
    ResourceLimit,
    Unsupported,
)
from ..bitstream.startcodes import DRAFT_OBJECT, DRAFT_PLANE, FBA_OBJECT, FBA_OBJECT_PLANE
from ..entropy.model import Model
from ..syntax.base import BARE_CODE, END, PLANE, STUFFED_CODE, STUFFED_END, ZERO_PADDING, SyntaxIO
from ..syntax.element import Element, Fault, Step
from ..syntax.temporal import temporal_header
from .dct_syntax import SegmentData, dct_segment
from .parameters import EXPRESSION_LABELS, LARGEST_SELECT, VISEME_LABELS, bap_set, fap_set
from .reconstruct import high_level_values, reconstruct
from .records import FbaObject, FbaPlane, ParameterData
from .state import FaceState, ParameterState

FBA_OBJECT_START_CODE: Final = Element("fba_object_start_code", "FBA-1", fixed=True)
FBA_OBJECT_PLANE_START_CODE: Final = Element("fba_object_plane_start_code", "FBA-2", fixed=True)
NEXT_START_CODE: Final = Element("stuffing", "FBA-3", fixed=True)
PADDING: Final = Element("zero_padding", "FBA-42")
IS_INTRA: Final = Element("is_intra", "FBA-5")
FBA_OBJECT_MASK: Final = Element(
    "fba_object_mask", "FBA-5", meaning={0: "no data", 1: "FAP data", 2: "BAP data", 3: "FAP and BAP data"}
)
FBA_SUGGESTED_GENDER: Final = Element("fba_suggested_gender", "FBA-11", meaning={0: "female", 1: "male"})
FBA_OBJECT_CODING_TYPE: Final = Element("fba_object_coding_type", "FBA-12", meaning={0: "arithmetic", 1: "DCT"})
BAP_SUGGESTED_GENDER: Final = Element("bap_suggested_gender", "FBA-40", meaning={0: "female", 1: "male"})
BAP_CODING_TYPE: Final = Element("bap_object_coding_type", "FBA-40", meaning={0: "arithmetic", 1: "DCT"})
FAP_SEGMENT: Final = Element("fap_segment", "FBA-28")
VISEME_SEGMENT: Final = Element("viseme_segment", "FBA-28")
EXPRESSION_SEGMENT: Final = Element("expression_segment", "FBA-28")
BAP_SEGMENT: Final = Element("bap_segment", "FBA-40")
VISEME_DEF: Final = Element("viseme_def", "FBA-28")
INIT_FACE: Final = Element("init_face", "FBA-28")
EXPRESSION_DEF: Final = Element("expression_def", "FBA-28")

ARITHMETIC: Final = 0
DCT: Final = 1
FAP_GROUPS: Final = 10
BAP_GROUPS: Final = 24

AT_PLANE: Final = Step("plane")
AT_FAP: Final = Step("fap")
AT_BAP: Final = Step("bap")
AT_GROUP: Final = Step("group")
AT_LIST: Final = Step("new_minmax")

_INTER_FIRST: Final = Fault(
    InconsistentSemantics, "FBA-35", "is_intra", "1, before any inter plane with data of this kind"
)
_SELECT: Final = {
    1: Fault(RangeViolation, "FBA-32", "viseme_select", "0..14"),
    2: Fault(RangeViolation, "FBA-32", "expression_select", "0..6"),
}
_IDLE: Final = Fault(ResourceLimit, "FBA-42", "consecutive planes without data", "")
_NO_LIMITS: Final = Fault(
    Unsupported, "FBA-40", "ranges of BAPs without default limits", "all four range lists with the intra plane"
)
_BAP_DCT: Final = Fault(Unsupported, "FBA-40", "bap_object_coding_type", "0 (the DCT mode of bodies is not built)")
_PLANE_CODE: Final = Fault(ForbiddenValue, "FBA-2", "fba_object_plane_start_code", "000001bb")
_BARE: Final = Fault(ForbiddenValue, "FBA-3", "fba_object_plane_start_code", "stuffing before it (AMB-FBA-8)")


def new_plane(mask: int, is_intra: int = 0) -> FbaPlane:
    """An empty plane record with the data that `mask` asks for; range lists in intra planes only. Rules: FBA-5."""
    plane = FbaPlane()
    plane.is_intra = is_intra
    plane.fba_object_mask = mask
    if mask & 1:
        plane.faps = new_fap_data() if is_intra else ParameterData(FAP_GROUPS)
    if mask & 2:
        plane.baps = new_bap_data() if is_intra else ParameterData(BAP_GROUPS)
    return plane


def new_fap_data() -> ParameterData:
    """An empty FAP data record, with range lists to fill in. Rules: FBA-9..13, FBA-16."""
    data = ParameterData(FAP_GROUPS)
    data.limits = [[0] * (fap_set().count + 1) for _ in range(4)]
    return data


def new_bap_data() -> ParameterData:
    """An empty BAP data record, with range lists to fill in. Rules: FBA-40."""
    data = ParameterData(BAP_GROUPS)
    data.limits = [[0] * (bap_set().count + 1) for _ in range(4)]
    return data


def fba_object(io: SyntaxIO, obj: FbaObject, planes: Iterator[FbaPlane]) -> Iterator[FbaPlane]:
    """`fba_object()`: the start code, then its planes one by one, each with its frames.

    Rules: FBA-1, FBA-2, FBA-3, FBA-41, FBA-42, FBA-44. `planes`: for a reader, fresh planes without end; for a
    writer, the planes to write. Leaves a following start code for the caller.
    """
    state = FaceState(io.readings)
    start = io.tell()
    obj.start_code = io.u(FBA_OBJECT_START_CODE, 32, obj.start_code)
    if obj.start_code == DRAFT_OBJECT:
        io.finding("draft-start-code", "object start code of a draft", start, start + 32)
    idle = 0
    index = 0
    while True:
        plane = next(planes, None)
        io.enter(AT_PLANE, index)
        kind = io.boundary(obj.end if plane is None else plane.boundary, index == 0)
        if kind == STUFFED_CODE:
            start = io.tell()
            width = 8 - (start & 7)
            io.u(NEXT_START_CODE, width, (1 << (width - 1)) - 1)
            code = io.next_code(0 if plane is None else plane.start_code)
            if code != FBA_OBJECT_PLANE and not (io.draft and code == DRAFT_PLANE) and not (plane and not io.reading):
                obj.end = kind
                io.leave()
                break
        elif kind in (STUFFED_END, END, ZERO_PADDING):
            _end_of_data(io, obj, kind)
            io.leave()
            break
        assert plane is not None
        plane.boundary = kind
        _plane_start_code(io, plane)
        plane.start = io.tell()
        fba_object_plane(io, state, plane)
        plane.end = io.tell()
        if io.protect(plane.start):
            plane.boundary = STUFFED_CODE
            plane.start_code = FBA_OBJECT_PLANE
            moved = io.tell() - plane.end
            plane.start += moved
            plane.end += moved
        if plane.fba_object_mask:
            idle = 0
        else:
            idle = 1 if plane.start_code else idle + 1
            if idle > io.limits.idle_planes:
                fault = _IDLE.allowing(f"at most {io.limits.idle_planes}")
                io.require(False, fault, idle, plane.start, plane.end)
        plane.frames = reconstruct(state, plane)
        if state.clock.went_back:
            io.finding("time-code-back", "the time code is earlier than the plane before", plane.start, plane.end)
        io.leave()
        yield plane
        index += 1
    if index == 0:
        io.finding("empty-object", "an object without planes", start, io.tell())


def _plane_start_code(io: SyntaxIO, plane: FbaPlane) -> None:
    if plane.boundary == PLANE:
        plane.start_code = 0
        return
    start = io.tell()
    plane.start_code = io.u(FBA_OBJECT_PLANE_START_CODE, 32, plane.start_code)
    known = plane.start_code in (FBA_OBJECT_PLANE, DRAFT_PLANE)
    io.require(known, _PLANE_CODE, f"{plane.start_code:08x}", start, io.tell())
    if plane.boundary == BARE_CODE:
        io.require(io.readings.unstuffed_plane != "error", _BARE, f"{plane.start_code:08x}", start, io.tell())
        io.finding("no-stuffing", "a plane start code directly behind the object start code", start, io.tell())
    if plane.start_code == DRAFT_PLANE:
        io.finding("draft-start-code", "plane start code of a draft", start, io.tell())


def _end_of_data(io: SyntaxIO, obj: FbaObject, kind: int) -> None:
    start = io.tell()
    obj.end = kind
    if kind == STUFFED_END:
        width = 8 - (start & 7)
        io.u(NEXT_START_CODE, width, (1 << (width - 1)) - 1)
    elif kind == ZERO_PADDING:
        obj.padding = io.zeros(PADDING, obj.padding)
        io.finding("zero-padding", f"{obj.padding} zero bits to the end of the data", start, io.tell())
    io.finding("no-end-code", "the data ends without visual_object_sequence_end_code", start, io.tell())


def fba_object_plane(io: SyntaxIO, state: FaceState, plane: FbaPlane) -> None:
    """`fba_object_plane()` behind its start code. Rules: FBA-5, FBA-35, FBA-39, SYS-9 (bodies)."""
    start = io.tell()
    plane.is_intra = io.u(IS_INTRA, 1, plane.is_intra)
    plane.fba_object_mask = io.u(FBA_OBJECT_MASK, 2, plane.fba_object_mask)
    mask = plane.fba_object_mask
    if not plane.is_intra:
        if mask & 1:
            io.require(state.faps.has_intra, _INTER_FIRST, 0, start, start + 1)
        if mask & 2:
            io.require(state.baps.has_intra, _INTER_FIRST, 0, start, start + 1)
    if mask or io.readings.empty_plane_header == "header":
        temporal_header(io, plane.header, plane.is_intra)
    if mask & 1:
        data = plane.faps
        if data is None:
            data = ParameterData(FAP_GROUPS)
            plane.faps = data
        io.enter(AT_FAP, -1)
        if plane.is_intra:
            fap_data_header(io, state, data)
        fap_levels(io, state, data, plane.is_intra)
        io.leave()
    if mask & 2:
        data = plane.baps
        if data is None:
            data = ParameterData(BAP_GROUPS)
            plane.baps = data
        io.enter(AT_BAP, -1)
        io.tool("body")
        bap_data(io, state.baps, data, plane.is_intra)
        io.leave()


def fap_data_header(io: SyntaxIO, state: FaceState, data: ParameterData) -> None:
    """FAP data of an intra plane, up to its segments. Rules: FBA-9, FBA-10, FBA-11, FBA-12, FBA-13."""
    faps = state.faps
    data.quant = io.u(faps.parameters.quant, 5, data.quant)
    group_masks(io, faps, data)
    data.gender = io.u(FBA_SUGGESTED_GENDER, 1, data.gender)
    data.coding_type = io.u(FBA_OBJECT_CODING_TYPE, 1, data.coding_type)
    state.select_faps(data)
    if data.coding_type == ARITHMETIC:
        new_minmax(io, faps, data)
        faps.set_ranges(data, io.readings)
        state.set_high_level_models()
    faps.has_intra = True


def group_masks(io: SyntaxIO, state: ParameterState, data: ParameterData) -> None:
    """Marker, mask type and mask of each group. Rules: FBA-10, FBA-14, FBA-40."""
    parameters = state.parameters
    for g, group in enumerate(parameters.groups):
        io.enter(AT_GROUP, g + 1)
        io.marker(parameters.group_marker)
        mask_type = io.u(parameters.mask_type, 2, data.mask_type[g])
        data.mask_type[g] = mask_type
        if mask_type in (1, 2):
            data.group_mask[g] = io.u(parameters.group_mask, len(group), data.group_mask[g])
        io.leave()


def new_minmax(io: SyntaxIO, state: ParameterState, data: ParameterData) -> None:
    """The four flags, and the range lists that they announce. Rules: FBA-13, FBA-16, FBA-40."""
    parameters = state.parameters
    for which, flag in enumerate(parameters.new_flags):
        data.new[which] = io.u(flag, 1, data.new[which])
    if not any(data.new):
        return
    if not data.limits:
        data.limits = [[0] * (parameters.count + 1) for _ in range(4)]
    selected = set(state.selected)
    for which, element in enumerate(parameters.limit_elements):
        if not data.new[which]:
            continue
        io.enter(AT_LIST, which)
        limits = data.limits[which]
        for group in parameters.range_groups:
            for position, number in enumerate(group):
                # Counted from the start of each group, whether or not the parameters are selected.
                if position & 3 == 0:
                    io.marker(parameters.limit_marker)
                if number in selected:
                    limits[number] = io.u(element, 5, limits[number])
        io.leave()


def fap_levels(io: SyntaxIO, state: FaceState, data: ParameterData, is_intra: int) -> None:
    """`ifap()` and `pfap()`: up to three arithmetic segments, or one DCT segment.

    Rules: FBA-12, FBA-15, FBA-28, FBA-30, FBA-32, DCT-1.
    """
    if state.faps.coding_type != ARITHMETIC:
        if data.segment is None:
            data.segment = SegmentData()
        start = io.tell()
        dct_segment(
            io,
            data.segment,
            is_intra,
            state.faps.selected,
            state.dct_viseme if state.has_viseme else None,
            state.dct_expression if state.has_expression else None,
        )
        if io.profile.provisional and not state.seen_dct:
            message = f"entropy profile {io.profile.name}: {', '.join(io.profile.provisional_tables)} are provisional"
            io.finding("provisional-tables", message, start, io.tell())
        state.seen_dct = True
        return
    high = state.high_i_models if is_intra else state.high_p_models
    if state.has_viseme:
        start = io.tell()
        data.viseme = _segment(io, VISEME_SEGMENT, high[:3], VISEME_LABELS, data.viseme, data.tails, 0)
        _check_high_level(io, state, data.viseme, 0, is_intra, start)
        data.viseme_def = io.u(VISEME_DEF, 1, data.viseme_def)
    if state.has_expression:
        start = io.tell()
        data.expression = _segment(io, EXPRESSION_SEGMENT, high[3:], EXPRESSION_LABELS, data.expression, data.tails, 1)
        _check_high_level(io, state, data.expression, 3, is_intra, start)
        data.init_face = io.u(INIT_FACE, 1, data.init_face)
        data.expression_def = io.u(EXPRESSION_DEF, 1, data.expression_def)
    faps = state.faps
    models = faps.i_models if is_intra else faps.p_models
    data.levels = _segment(io, FAP_SEGMENT, models, faps.labels, data.levels, data.tails, 2)


def _segment(
    io: SyntaxIO, el: Element, models: list[Model], labels: list[str], levels: list[int], tails: list[int], which: int
) -> list[int]:
    start = io.tell()
    levels = io.segment(el, models, labels, levels, tails[which])
    tails[which] = io.tail
    if io.tail:
        io.finding("segment-end", "the segment does not end as an encoder ends it", start, io.tell())
    return levels


def _check_high_level(io: SyntaxIO, state: FaceState, levels: list[int], first: int, is_intra: int, start: int) -> None:
    values = high_level_values(state, levels, first, is_intra)
    selects, amounts = ((0, 1), (2,)) if first == 0 else ((0, 2), (1, 3))
    fap = 2 if first else 1
    for i in selects:
        io.require(0 <= values[i] <= LARGEST_SELECT[fap], _SELECT[fap], values[i], start, io.tell())
    for i in amounts:
        if not 0 <= values[i] <= 63:
            labels = EXPRESSION_LABELS if first else VISEME_LABELS
            io.finding("intensity-range", f"{labels[i]} is {values[i]}, outside 0..63", start, io.tell())


def bap_data(io: SyntaxIO, state: ParameterState, data: ParameterData, is_intra: int) -> None:
    """BAP data of a plane. Rules: FBA-40."""
    if is_intra:
        parameters = state.parameters
        data.quant = io.u(parameters.quant, 5, data.quant)
        group_masks(io, state, data)
        data.gender = io.u(BAP_SUGGESTED_GENDER, 1, data.gender)
        start = io.tell()
        data.coding_type = io.u(BAP_CODING_TYPE, 1, data.coding_type)
        io.require(data.coding_type == 0, _BAP_DCT, data.coding_type, start, start + 1)
        state.select(data, io.readings)
        start = io.tell()
        new_minmax(io, state, data)
        bare = next((number for number in state.selected if not parameters.has_defaults[number]), 0)
        io.require(not bare or all(data.new), _NO_LIMITS, parameters.labels[bare], start, io.tell())
        state.set_ranges(data, io.readings)
        state.has_intra = True
    models = state.i_models if is_intra else state.p_models
    data.levels = _segment(io, BAP_SEGMENT, models, state.labels, data.levels, data.tails, 2)


def is_fba_object(io: SyntaxIO, code: int) -> bool:
    """Whether a start code begins an FBA object. Rules: FBA-1, FBA-4."""
    return code == FBA_OBJECT or (io.draft and code == DRAFT_OBJECT)
