"""Builders of planes and streams for recipes and tests: short to write, records as result.

Rules: FBA-1, FBA-2, FBA-5..16, FBA-28, FBA-40, SYS-2..5. Levels are what the wire says, not values: FBA-31 makes the
one from the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from snhc.reference_impl.bitstream.startcodes import (
    FBA_OBJECT,
    FBA_OBJECT_PLANE,
    USER_DATA,
    VISUAL_OBJECT,
    VISUAL_OBJECT_SEQUENCE,
    VISUAL_OBJECT_SEQUENCE_END,
)
from snhc.reference_impl.face.parameters import LIST_NAMES, ParameterSet, bap_set, fap_set
from snhc.reference_impl.face.records import FbaObject, FbaPlane, ParameterData
from snhc.reference_impl.face.syntax import new_plane
from snhc.reference_impl.syntax.base import STUFFED_CODE
from snhc.reference_impl.systems.visual import StreamItem, VisualObjectHeader

FAP_DATA: Final = 1
BAP_DATA: Final = 2

Ranges = Mapping[str, "int | Mapping[int, int]"]
"""Limits by list (`i_max`, `i_min`, `p_max`, `p_min`): one v for all coded parameters, or v by number."""


def all_lists(v: int) -> dict[str, int]:
    """All four range lists with the limit 60 v. Rules: FBA-16."""
    return dict.fromkeys(LIST_NAMES, v)


def timed(
    plane: FbaPlane,
    *,
    rate: tuple[int, int, int] | None = None,
    time: tuple[int, int, int] | None = None,
    skip: int | None = None,
) -> FbaPlane:
    """Set the temporal header of a plane. Rules: FBA-6, FBA-7, FBA-8.

    `rate`: frame_rate, seconds, frequency_offset; `time`: hours, minutes, seconds; `skip`: frames, 0 is sent too.
    """
    h = plane.header
    if rate is not None:
        h.is_frame_rate = 1
        h.frame_rate, h.seconds, h.frequency_offset = rate
    if time is not None:
        h.is_time_code = 1
        h.time_code_hours, h.time_code_minutes, h.time_code_seconds = time
    if skip is not None:
        h.skip_frames = 1
        h.number_of_frames_to_skip = skip
    return plane


def intra(
    faps: Mapping[int, int] | None = None,
    *,
    quant: int = 1,
    types: Mapping[int, int] | None = None,
    ranges: Ranges | None = None,
    viseme: tuple[int, int, int, int] | None = None,
    expression: tuple[int, int, int, int, int, int] | None = None,
    gender: int = 0,
    rate: tuple[int, int, int] | None = None,
    time: tuple[int, int, int] | None = None,
    skip: int | None = None,
) -> FbaPlane:
    """An intra plane with FAP data. Rules: FBA-5..16, FBA-28.

    `faps`: level by FAP 3..68. `types`: mask type by group 1..10; else 1 where a FAP of the group is given, else 0.
    `viseme`: levels of select1, select2, blend, and viseme_def; `expression`: select1, intensity1, select2,
    intensity2, init_face, expression_def.
    """
    plane = new_plane(FAP_DATA, 1)
    assert plane.faps is not None
    data = plane.faps
    levels = dict(faps or {})
    wanted = set(levels)
    if viseme is not None:
        wanted.add(1)
        data.viseme, data.viseme_def = list(viseme[:3]), viseme[3]
    if expression is not None:
        wanted.add(2)
        data.expression, data.init_face, data.expression_def = list(expression[:4]), expression[4], expression[5]
    data.quant = quant
    data.gender = gender
    _fill(data, fap_set(), levels, wanted, types or {}, ranges or {})
    return timed(plane, rate=rate, time=time, skip=skip)


def body(
    baps: Mapping[int, int],
    *,
    quant: int = 1,
    types: Mapping[int, int] | None = None,
    ranges: Ranges | None = None,
    gender: int = 0,
    face: FbaPlane | None = None,
) -> FbaPlane:
    """An intra plane with BAP data, alone or added to the FAP data of the plane `face`. Rules: FBA-40."""
    plane = new_plane(BAP_DATA, 1)
    assert plane.baps is not None
    plane.baps.quant = quant
    plane.baps.gender = gender
    _fill(plane.baps, bap_set(), dict(baps), set(baps), types or {}, ranges or {})
    if face is not None:
        face.fba_object_mask |= BAP_DATA
        face.baps = plane.baps
        return face
    return plane


def _fill(
    data: ParameterData,
    parameters: ParameterSet,
    levels: Mapping[int, int],
    wanted: set[int],
    types: Mapping[int, int],
    ranges: Ranges,
) -> None:
    for g, group in enumerate(parameters.groups):
        chosen = [number for number in group if number in wanted]
        data.mask_type[g] = types.get(g + 1, 1 if chosen else 0)
        if data.mask_type[g] in (1, 2):
            mask = 0
            for number in group:
                mask = (mask << 1) | (number in wanted)
            data.group_mask[g] = mask
    numbers = coded(data, parameters)
    data.levels = [levels.get(number, 0) for number in numbers]
    for which, name in enumerate(LIST_NAMES):
        if name in ranges:
            v = ranges[name]
            data.new[which] = 1
            for number in numbers:
                data.limits[which][number] = v if isinstance(v, int) else v[number]


def coded(data: ParameterData, parameters: ParameterSet) -> list[int]:
    """The numbers that the masks of an intra plane select, in coding order, FAP 1 and 2 left out. Rules: FBA-14."""
    faps = parameters is fap_set()
    out: list[int] = []
    for g, group in enumerate(parameters.groups):
        mask_type, mask = data.mask_type[g], data.group_mask[g]
        for i, number in enumerate(group):
            selected = mask_type == 3 or (mask_type in (1, 2) and (mask >> (len(group) - 1 - i)) & 1)
            if selected and not (faps and number <= 2):
                out.append(number)
    return out


def inter(
    first: FbaPlane,
    faps: Mapping[int, int] | None = None,
    *,
    baps: Mapping[int, int] | None = None,
    viseme: tuple[int, int, int, int] = (0, 0, 0, 0),
    expression: tuple[int, int, int, int, int, int] = (0, 0, 0, 0, 0, 0),
    skip: int | None = None,
) -> FbaPlane:
    """An inter plane with the same kinds of data as the intra plane `first`, whose masks are in force.

    Rules: FBA-15, FBA-28. Levels that are not given are 0.
    """
    plane = new_plane(first.fba_object_mask)
    if plane.faps is not None and first.faps is not None:
        levels = faps or {}
        plane.faps.levels = [levels.get(number, 0) for number in coded(first.faps, fap_set())]
        plane.faps.viseme, plane.faps.viseme_def = list(viseme[:3]), viseme[3]
        plane.faps.expression = list(expression[:4])
        plane.faps.init_face, plane.faps.expression_def = expression[4], expression[5]
    if plane.baps is not None and first.baps is not None:
        levels = baps or {}
        plane.baps.levels = [levels.get(number, 0) for number in coded(first.baps, bap_set())]
    return timed(plane, skip=skip)


def empty(
    *,
    is_intra: int = 0,
    rate: tuple[int, int, int] | None = None,
    time: tuple[int, int, int] | None = None,
    skip: int | None = None,
) -> FbaPlane:
    """A plane without data: time passes. Rules: FBA-5."""
    return timed(new_plane(0, is_intra), rate=rate, time=time, skip=skip)


def with_code(plane: FbaPlane, code: int = FBA_OBJECT_PLANE, boundary: int = STUFFED_CODE) -> FbaPlane:
    """Put a start code before a plane. Rules: FBA-2."""
    plane.boundary = boundary
    plane.start_code = code
    return plane


def face_object(planes: Iterable[FbaPlane], *, end: int = STUFFED_CODE, start_code: int = FBA_OBJECT) -> StreamItem:
    """An FBA object; `end` as in `FbaObject`. Rules: FBA-1."""
    item = StreamItem(start_code)
    item.fba = FbaObject()
    item.fba.start_code = start_code
    item.fba.planes = list(planes)
    item.fba.end = end
    return item


def sequence(profile: int) -> StreamItem:
    """`visual_object_sequence_start_code` and the profile. Rules: SYS-2."""
    item = StreamItem(VISUAL_OBJECT_SEQUENCE)
    item.profile = profile
    return item


def visual_object(*, verid: int | None = None, priority: int = 1, type: int = 4) -> StreamItem:
    """`visual_object()`; with `verid` the identifier is sent. Rules: SYS-3, SYS-4."""
    item = StreamItem(VISUAL_OBJECT)
    item.header = VisualObjectHeader()
    item.header.type = type
    if verid is not None:
        item.header.identifier = 1
        item.header.verid = verid
        item.header.priority = priority
    return item


def user_data(content: bytes) -> StreamItem:
    """`user_data()`. Rules: SYS-5."""
    item = StreamItem(USER_DATA)
    item.user_data = content
    return item


def trailing(content: bytes) -> StreamItem:
    """Bytes behind the end. Rules: FBA-3."""
    item = StreamItem(0)
    item.trailing = content
    return item


def end_code() -> StreamItem:
    """`visual_object_sequence_end_code`. Rules: FBA-1."""
    return StreamItem(VISUAL_OBJECT_SEQUENCE_END)


def stream(*planes: FbaPlane) -> list[StreamItem]:
    """The plain form: one FBA object, then the end code. Rules: FBA-1."""
    return [face_object(planes), end_code()]
