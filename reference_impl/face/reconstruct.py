"""The decoder's second half: levels become values, planes become frames.

Rules: FBA-31, FBA-32, FBA-33, FBA-34, FBA-40, DCT-3, DCT-5..7, DCT-11, DCT-13, DCT-14, CNF-1. The encoder
closes its loop with the same function.
"""

from __future__ import annotations

from functools import cache
from typing import Final

from ..tables import fap_dct_scale
from .dct_syntax import SEGMENT, SegmentData
from .dct_transform import DctReading, ac_steps, block_values, inverse_of
from .frames import FaceFrame
from .parameters import I_MAX, I_MIN, high_level_quantised
from .records import FbaPlane, ParameterData
from .state import FaceState, ParameterState

_NONE: Final[tuple[int | None, ...]] = (None,) * SEGMENT


def reconstruct(state: FaceState, plane: FbaPlane) -> list[FaceFrame]:
    """The frames of a plane; the state moves on.

    Rules: FBA-31, FBA-32, FBA-34, FBA-38. One frame, or 16 for a DCT segment.
    """
    header = plane.header
    time = state.clock.tick(header, state.readings.skipped_frames == "before")
    baps = None
    if plane.baps is not None:
        parameter_values(state.baps, plane.baps, plane.is_intra, False)
        values = state.baps.values
        baps = {number: values[number] for number in state.baps.selected}
    data = plane.faps
    if data is None:
        return [_frame(state, plane, time, shown_values(state), state.letters_without, baps)]
    if data.segment is None:
        fap_values(state, data, plane.is_intra)
        return [_frame(state, plane, time, shown_values(state), state.letters_with_data, baps)]
    frames: list[FaceFrame] = []
    letters = state.letters_with_data
    for t, shown in enumerate(segment_values(state, data.segment, plane.is_intra)):
        high_level_instant(state, data.segment, t)
        frames.append(_frame(state, plane, state.clock.after(time, t), shown, letters, baps if t == 0 else None))
    keep_high_level(state, data.segment)
    state.clock.span(len(frames) - 1)
    return frames


def _frame(
    state: FaceState,
    plane: FbaPlane,
    time: tuple[int, int],
    values: tuple[int | None, ...],
    letters: str,
    baps: dict[int, int] | None,
) -> FaceFrame:
    header = plane.faps if plane.is_intra else None
    frame = FaceFrame(
        state.index,
        time,
        bool(plane.is_intra),
        values,
        shown_viseme(state, letters),
        shown_expression(state, letters),
        letters,
        None if header is None else header.quant,
        None if header is None else header.gender,
        None if header is None else header.coding_type,
        baps,
    )
    state.index += 1
    return frame


def segment_values(state: FaceState, segment: SegmentData, is_intra: int) -> list[tuple[int | None, ...]]:
    """The 68 values of each of the 16 instants of a DCT segment; the state takes those of the last one.

    Rules: DCT-3, DCT-5, DCT-6, DCT-7, DCT-13, FBA-34, CNF-1.
    """
    readings = state.readings
    inverse = inverse_of(dct_reading(readings.dc_step_ratio, readings.normalisation))
    faps = state.faps
    selected = faps.selected
    values = faps.values
    steps = ac_steps(faps.quant)
    blocks = segment.blocks()
    assert len(blocks) == SEGMENT * len(selected)
    series: list[tuple[int | None, ...]] = [_NONE] * 68
    at = 0
    for fap in selected:
        dc = blocks[at]
        if not is_intra:
            dc += state.dct_dc[fap]
        state.dct_dc[fap] = dc
        numerator, denominator = steps[fap]
        instants = block_values(blocks, at, dc, numerator, denominator, inverse)
        values[fap] = instants[-1]
        series[fap - 1] = instants
        at += SEGMENT
    letters = state.letters_with_data
    for number in state.shown:
        # Those that are not coded keep their value.
        if letters[number - 1] == "R":
            series[number - 1] = (values[number],) * SEGMENT
    return list(zip(*series, strict=True))


def high_level_instant(state: FaceState, segment: SegmentData, t: int) -> None:
    """Take instant t of a DCT segment into the values of FAP 1 and 2. Rules: DCT-9, DCT-10, DCT-11."""
    if not (state.has_viseme or state.has_expression):
        return
    scale = fap_dct_scale()[state.faps.quant] if state.readings.dct_intensity == "scaled" else 1
    if state.has_viseme:
        select1, select2, blend = segment.viseme[t]
        state.viseme = [select1, select2, blend * scale, segment.viseme_def[t]]
    if state.has_expression:
        select1, select2, intensity1, intensity2 = segment.expression[t]
        state.expression = [
            select1,
            intensity1 * scale,
            select2,
            intensity2 * scale,
            segment.init_face[t],
            segment.expression_def[t],
        ]


def keep_high_level(state: FaceState, segment: SegmentData) -> None:
    """What the first instant of the next DCT segment is predicted from. Rules: DCT-9, DCT-10, DCT-13."""
    if state.has_viseme:
        state.dct_viseme = segment.viseme[-1]
    if state.has_expression:
        state.dct_expression = segment.expression[-1]


@cache
def dct_reading(dc_step_ratio: int, normalisation: str) -> DctReading:
    """The transform's readings of AMB-DCT-1 and AMB-DCT-2. Rules: DCT-5, DCT-7."""
    if normalisation == "orthonormal":
        return DctReading(dc_step_ratio, "orthonormal")
    return DctReading(dc_step_ratio, "unnormalised")


def shown_values(state: FaceState) -> tuple[int | None, ...]:
    """The 68 values of a line: those of states T and R. Rules: FBA-34, CNF-1."""
    values = state.faps.values
    out: list[int | None] = [None] * 68
    for number in state.shown:
        out[number - 1] = values[number]
    return tuple(out)


def shown_viseme(state: FaceState, letters: str) -> tuple[int, int, int, int] | None:
    """FAP 1 of a line, None while unset or to be interpolated. Rules: FBA-34, CNF-1."""
    if not state.seen_viseme or letters[0] == "I":
        return None
    select1, select2, blend, definition = state.viseme
    return select1, select2, blend, definition


def shown_expression(state: FaceState, letters: str) -> tuple[int, int, int, int, int, int] | None:
    """FAP 2 of a line, None while unset or to be interpolated. Rules: FBA-34, CNF-1."""
    if not state.seen_expression or letters[1] == "I":
        return None
    select1, intensity1, select2, intensity2, init_face, definition = state.expression
    return select1, intensity1, select2, intensity2, init_face, definition


def fap_values(state: FaceState, data: ParameterData, is_intra: int) -> None:
    """Take the levels of FAP data into the values. Rules: FBA-31, FBA-32, FBA-33."""
    if state.has_viseme:
        state.viseme = [*high_level_values(state, data.viseme, 0, is_intra), data.viseme_def]
    if state.has_expression:
        state.expression = [
            *high_level_values(state, data.expression, 3, is_intra), data.init_face, data.expression_def,
        ]  # fmt: skip
    parameter_values(state.faps, data, is_intra, state.readings.clipping == "clip")


def high_level_values(state: FaceState, levels: list[int], first: int, is_intra: int) -> list[int]:
    """Values of the symbols of FAP 1 (`first` 0) or FAP 2 (`first` 3) that their levels give.

    Rules: FBA-31, FBA-32. Does not change the state.
    """
    previous = state.expression if first else state.viseme
    quantised = high_level_quantised()
    clip = state.readings.clipping == "clip"
    step = state.faps.quant if state.faps.quant else 1
    out: list[int] = []
    for i, level in enumerate(levels):
        value = level * step if quantised[first + i] else level
        if not is_intra:
            value += previous[i]
        if clip and quantised[first + i]:
            value = min(max(value, 0), 63)
        out.append(value)
    return out


def parameter_values(state: ParameterState, data: ParameterData, is_intra: int, clip: bool) -> None:
    """Take the levels of the selected parameters into their values. Rules: FBA-31, FBA-32, FBA-40."""
    values = state.values
    assert len(data.levels) == len(state.selected)
    if is_intra:
        for number, level, step in zip(state.selected, data.levels, state.steps):
            values[number] = level * step
    else:
        for number, level, step in zip(state.selected, data.levels, state.steps):
            values[number] += level * step
    if clip:
        # AMB-FBA-4, reading clip: the range is that of the intra limits, in values.
        base_steps = state.parameters.base_steps
        for number in state.selected:
            unit = base_steps[number] if state.scale else 1
            lo, hi = state.limits[I_MIN][number] * unit, state.limits[I_MAX][number] * unit
            values[number] = min(max(values[number], lo), hi)
