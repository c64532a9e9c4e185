"""Levels and limits of the face's or the body's parameters, as the encoders choose them over one period.

Rules: FBA-9..12, FBA-15..17, FBA-20, FBA-36, FBA-40, FBA-41, FBA-43.
Not here: which planes there are (`encode`, `dct_planes`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from ..syntax.element import DEFAULT_READINGS
from .parameters import I_MAX, I_MIN, LARGEST_V, LIMIT_UNIT, P_MAX, P_MIN, SIGNS
from .reconstruct import parameter_values
from .records import ParameterData
from .requests import PartRequest
from .state import ParameterState

LARGEST_LIMIT: Final = LARGEST_V * LIMIT_UNIT


def quantise(x: int, step: int) -> int:
    """The level of a value or difference. Rules: FBA-36. `step` 0: the level is the value."""
    if step == 0:
        return x
    half = step >> 1
    if x > half:
        return (x + half) // step
    if x < -half:
        return -((half - x) // step)
    return 0


def smallest_v(level: int, divisor: int) -> int:
    """The smallest v whose limit, divided, still holds |level|. Rules: FBA-16, FBA-17."""
    return -(-abs(level) * divisor // LIMIT_UNIT)


class PartEncoder:
    """Levels and limits of the FAPs 3..68 or the BAPs, over one period. Rules: FBA-20, FBA-36, FBA-41, FBA-43.

    `state`: what a decoder will have. `request`: what the last intra plane with this part was asked for; `intra`: its
    data. `in_period`: the intra plane of this period carries the part; else its limits stand as they were sent before.
    """

    def __init__(self, state: ParameterState) -> None:
        self.state = state
        self.request: PartRequest | None = None
        self.intra: ParameterData | None = None
        # Per list and number, the largest magnitude that the period needs.
        self.needed: list[list[int]] = []
        self.sent: list[set[int]] = [set(), set(), set(), set()]
        self.in_period = False
        # What can be sent in inter and intra planes of this period; None until it is asked for.
        self._spans: list[tuple[list[int], list[int]] | None] = [None, None]
        # The last request that `changed` was asked about, and its levels: `put` needs them again.
        self._asked: PartRequest | None = None
        self._asked_levels: list[int] = []
        self.forget()

    def changed(self, wanted: PartRequest) -> bool:
        """Whether only an intra plane can carry this. Rules: FBA-15, FBA-43."""
        before = self.request
        if before is None or not self.in_period:
            return True
        if (wanted.mask_types, wanted.masks, wanted.quant, wanted.coding_type) != (
            before.mask_types, before.masks, before.quant, before.coding_type
        ):  # fmt: skip
            return True
        self._asked = wanted
        self._asked_levels = self.levels(wanted.targets, False)
        return not self.fits(self._asked_levels, False)

    def begin(self, wanted: PartRequest, data: ParameterData) -> None:
        """A period's intra plane, whose header and masks are in `data` and in force. Rules: FBA-15, FBA-43."""
        self.state.set_steps()
        self.request = wanted
        self.intra = data
        self.in_period = True
        self._spans = [None, None]

    def put(self, wanted: PartRequest, data: ParameterData, is_intra: bool) -> Iterator[str]:
        """The levels of one plane; yields what to say of each value that did not fit. Rules: FBA-36, FBA-43."""
        levels = self._asked_levels
        if self._asked is not wanted or is_intra:
            levels = self.levels(wanted.targets, is_intra)
        self._asked = None
        if not self.fits(levels, is_intra):
            for number, level, sent in self.clip(levels, is_intra):
                yield f"{self.state.parameters.labels[number]}: level {level} does not fit, {sent} sent"
        self.note(levels, is_intra)
        data.levels = levels
        parameter_values(self.state, data, int(is_intra), False)

    def _unsure(self, which: int, number: int) -> bool:
        """Whether decoders may disagree about a limit that was never sent: no default, or AMB-FBA-2."""
        if number in self.sent[which]:
            return False
        parameters = self.state.parameters
        return not parameters.has_defaults[number] or number in parameters.disputed

    def _bounds(self, number: int, is_intra: bool) -> tuple[int, int]:
        if not self.in_period:
            return self.state.in_force[P_MIN][number], self.state.in_force[P_MAX][number]
        divisor = self.state.scale or 1
        out = []
        for which in (I_MIN, I_MAX) if is_intra else (P_MIN, P_MAX):
            limit = LARGEST_LIMIT
            given = self.request.limits[which] if self.request is not None else None
            if given is not None:
                limit = abs(given.get(number, 0))
            out.append(SIGNS[which] * (limit // divisor))
        return out[0], out[1]

    def span(self, is_intra: bool) -> tuple[list[int], list[int]]:
        """The lowest and the highest levels that can be sent, in coding order; the same over a period.

        Rules: FBA-16, FBA-17.
        """
        which = 1 if is_intra else 0
        span = self._spans[which]
        if span is None:
            bounds = [self._bounds(number, is_intra) for number in self.state.selected]
            span = [low for low, _ in bounds], [high for _, high in bounds]
            self._spans[which] = span
        return span

    def levels(self, targets: dict[int, int], is_intra: bool) -> list[int]:
        """The levels of values, or of their differences, in coding order. Rules: FBA-20, FBA-36."""
        state = self.state
        values = state.values
        assert len(state.selected) == len(state.steps)
        if is_intra:
            return [quantise(targets[number], step) for number, step in zip(state.selected, state.steps)]
        return [quantise(targets[number] - values[number], step) for number, step in zip(state.selected, state.steps)]

    def fits(self, levels: list[int], is_intra: bool) -> bool:
        """Whether the levels can be sent. Rules: FBA-43."""
        lows, highs = self.span(is_intra)
        for level, low, high in zip(levels, lows, highs):  # noqa: SIM110 (a generator would cost a call per level)
            if level < low or level > high:
                return False
        return True

    def clip(self, levels: list[int], is_intra: bool) -> Iterator[tuple[int, int, int]]:
        """Clip levels in place; yields (number, wanted, sent) of those that were. Rules: FBA-43."""
        lows, highs = self.span(is_intra)
        for i, number in enumerate(self.state.selected):
            level = levels[i]
            if not lows[i] <= level <= highs[i]:
                levels[i] = min(max(level, lows[i]), highs[i])
                yield number, level, levels[i]

    def note(self, levels: list[int], is_intra: bool) -> None:
        """Remember what the limits must hold. Rules: FBA-43."""
        up = self.needed[I_MAX if is_intra else P_MAX]
        down = self.needed[I_MIN if is_intra else P_MIN]
        for number, level in zip(self.state.selected, levels):
            if level > 0:
                if level > up[number]:
                    up[number] = level
            elif -level > down[number]:
                down[number] = -level

    def set_limits(self, ranges: str) -> None:
        """Choose the lists of the period's intra plane, and keep the limits as a decoder will.

        Rules: FBA-16, FBA-19, FBA-40, FBA-41. `ranges`: as in `EncoderOptions`.
        """
        state, data, request = self.state, self.intra, self.request
        assert data is not None and request is not None
        divisor = state.scale or 1
        for which in (I_MAX, I_MIN, P_MAX, P_MIN):
            given = request.limits[which]
            chosen: dict[int, int] = {}
            for number in state.selected:
                if given is not None:
                    v = -(-abs(given.get(number, 0)) // LIMIT_UNIT)
                elif ranges == "max":
                    v = LARGEST_V
                else:
                    v = smallest_v(self.needed[which][number], divisor)
                chosen[number] = v
            in_force = state.limits[which]
            if given is not None:
                send = True
            elif ranges == "widen":
                send = any(
                    v * LIMIT_UNIT > abs(in_force[number]) or self._unsure(which, number)
                    for number, v in chosen.items()
                )
                if send:
                    chosen = {number: max(v, abs(in_force[number]) // LIMIT_UNIT) for number, v in chosen.items()}
            else:
                send = any(
                    v * LIMIT_UNIT != abs(in_force[number]) or self._unsure(which, number)
                    for number, v in chosen.items()
                )
            data.new[which] = 1 if send else 0
            if send:
                self.sent[which].update(chosen)
                for number, v in chosen.items():
                    data.limits[which][number] = v
        if any(not state.parameters.has_defaults[number] for number in state.selected):
            self._send_all(data)
        state.set_ranges(data, DEFAULT_READINGS)

    def _send_all(self, data: ParameterData) -> None:
        # BAPs without default limits need all four lists in each intra plane (FBA-40).
        for which in (I_MAX, I_MIN, P_MAX, P_MIN):
            if not data.new[which]:
                data.new[which] = 1
                for number in self.state.selected:
                    data.limits[which][number] = abs(self.state.limits[which][number]) // LIMIT_UNIT

    def forget(self) -> None:
        """The period is over. Rules: FBA-43."""
        self.in_period = False
        self.needed = [[0] * (self.state.parameters.count + 1) for _ in range(4)]
        self._spans = [None, None]


def take_header(data: ParameterData, request: PartRequest) -> None:
    """Quantiser, masks, gender and coding type of an intra plane. Rules: FBA-9..12."""
    data.quant = request.quant
    data.mask_type = list(request.mask_types)
    data.group_mask = list(request.masks)
    data.gender = request.gender
    data.coding_type = request.coding_type
