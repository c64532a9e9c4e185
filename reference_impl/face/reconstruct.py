"""The decoder's second half: levels become values, planes become frames.

Rules: FBA-31, FBA-32, FBA-33, FBA-34, FBA-40, CNF-1. The encoder closes its loop with the same function.
"""

from __future__ import annotations

from .frames import FaceFrame
from .parameters import I_MAX, I_MIN, high_level_quantised
from .records import FbaPlane, ParameterData
from .state import FaceState, ParameterState


def reconstruct(state: FaceState, plane: FbaPlane) -> list[FaceFrame]:
    """The frames of a plane; the state moves on.

    Rules: FBA-31, FBA-32, FBA-34, FBA-38. One frame, or 16 for a DCT segment.
    """
    header = plane.header
    time = state.clock.tick(header, state.readings.skipped_frames == "before")
    letters = state.letters_without
    fap_quant = gender = coding_type = None
    if plane.faps is not None:
        letters = state.letters_with_data
        fap_values(state, plane.faps, plane.is_intra)
        if plane.is_intra:
            fap_quant, gender, coding_type = plane.faps.quant, plane.faps.gender, plane.faps.coding_type
    baps = None
    if plane.baps is not None:
        parameter_values(state.baps, plane.baps, plane.is_intra, False)
        values = state.baps.values
        baps = {number: values[number] for number in state.baps.selected}
    frame = FaceFrame(
        state.index,
        time,
        bool(plane.is_intra),
        shown_values(state),
        shown_viseme(state, letters),
        shown_expression(state, letters),
        letters,
        fap_quant,
        gender,
        coding_type,
        baps,
    )
    state.index += 1
    return [frame]


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
    if is_intra:
        for number, level, step in zip(state.selected, data.levels, state.steps, strict=True):
            values[number] = level * step
    else:
        for number, level, step in zip(state.selected, data.levels, state.steps, strict=True):
            values[number] += level * step
    if clip:
        # AMB-FBA-4, reading clip: the range is that of the intra limits, in values.
        base_steps = state.parameters.base_steps
        for number in state.selected:
            unit = base_steps[number] if state.scale else 1
            lo, hi = state.limits[I_MIN][number] * unit, state.limits[I_MAX][number] * unit
            values[number] = min(max(values[number], lo), hi)
