"""The closed-loop encoder of arithmetic-coded face and body planes.

Rules: FBA-20, FBA-29, FBA-31, FBA-36, FBA-41, FBA-43. The DCT mode is in `dct_planes.py`.

Limits and masks travel in intra planes only. An intra plane and the inter planes behind it form a period; its planes
are quantised first, against what a decoder will have reconstructed, and the smallest limits that hold their levels
are then put into its intra plane.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from ..bitstream.errors import EncodeError
from ..bitstream.findings import Finding
from ..bitstream.startcodes import FBA_OBJECT_PLANE
from ..rules import finding as registered_finding
from ..syntax.base import PLANE, STUFFED_CODE
from ..syntax.element import DEFAULT_READINGS
from .parameters import (
    EXPRESSION_LABELS,
    I_MAX,
    I_MIN,
    LARGEST_SELECT,
    LARGEST_V,
    LIMIT_UNIT,
    P_MAX,
    P_MIN,
    SIGNS,
    VISEME_LABELS,
    high_level_quantised,
)
from .reconstruct import high_level_values, parameter_values
from .records import FbaPlane, ParameterData
from .requests import PartRequest, PlaneRequest
from .state import FaceState, ParameterState
from .syntax import new_plane

LARGEST_LIMIT: Final = LARGEST_V * LIMIT_UNIT
LONGEST_PERIOD: Final = 250


@dataclass(frozen=True, slots=True)
class EncoderOptions:
    """How to encode.

    Rules: FBA-41, FBA-43.

    `intra_period`: planes from one intra plane to the next; None: one second, at most 250. `ranges`: `auto` (the
    smallest limits, sent where they change), `widen` (the limits in force stay as long as they hold), `max` (31 in
    every list). `start_codes`: `none`, `intra` or `all` planes get a plane start code.
    """

    intra_period: int | None = None
    ranges: str = "auto"
    start_codes: str = "none"


def quantise(x: int, step: int) -> int:
    """The level of a value or difference. Rules: FBA-36. `step` 0: the level is the value."""
    if step == 0:
        return x
    magnitude = abs(x)
    if magnitude <= step // 2:
        return 0
    level = (magnitude + step // 2) // step
    return level if x > 0 else -level


def smallest_v(level: int, divisor: int) -> int:
    """The smallest v whose limit, divided, still holds |level|. Rules: FBA-16, FBA-17."""
    return -(-abs(level) * divisor // LIMIT_UNIT)


class _Part:
    """Levels and limits of the FAPs 3..68 or the BAPs, over one period."""

    def __init__(self, state: ParameterState) -> None:
        self.state = state
        self.request: PartRequest | None = None
        self.intra: ParameterData | None = None
        # Per list and number, the largest magnitude that the period needs.
        self.needed: list[dict[int, int]] = [{}, {}, {}, {}]
        self.sent: list[set[int]] = [set(), set(), set(), set()]
        # Whether the intra plane of this period carries the part; else its limits stand as they were sent before.
        self.in_period = False

    def _unsure(self, which: int, number: int) -> bool:
        """Whether decoders may disagree about a limit that was never sent: no default, or AMB-FBA-2."""
        if number in self.sent[which]:
            return False
        parameters = self.state.parameters
        return not parameters.has_defaults[number] or number in parameters.disputed

    def bounds(self, number: int, is_intra: bool) -> tuple[int, int]:
        """The levels that can be sent at all."""
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

    def levels(self, targets: dict[int, int], is_intra: bool) -> list[int]:
        state = self.state
        values = state.values
        return [
            quantise(targets[number] - (0 if is_intra else values[number]), step)
            for number, step in zip(state.selected, state.steps, strict=True)
        ]

    def fits(self, levels: list[int]) -> bool:
        """Whether the levels of an inter plane can be sent."""
        for number, level in zip(self.state.selected, levels, strict=True):
            low, high = self.bounds(number, False)
            if not low <= level <= high:
                return False
        return True

    def clip(self, levels: list[int], is_intra: bool) -> Iterator[tuple[int, int, int]]:
        """Clip levels in place; yields (number, wanted, sent) of those that were."""
        for i, number in enumerate(self.state.selected):
            low, high = self.bounds(number, is_intra)
            level = levels[i]
            if not low <= level <= high:
                levels[i] = min(max(level, low), high)
                yield number, level, levels[i]

    def note(self, levels: list[int], is_intra: bool) -> None:
        for number, level in zip(self.state.selected, levels, strict=True):
            which = (I_MAX if level > 0 else I_MIN) if is_intra else (P_MAX if level > 0 else P_MIN)
            needed = self.needed[which]
            if abs(level) > needed.get(number, 0):
                needed[number] = abs(level)

    def set_limits(self, ranges: str) -> None:
        """Choose the lists of the period's intra plane, and keep the limits as a decoder will."""
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
                    v = smallest_v(self.needed[which].get(number, 0), divisor)
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
        self.in_period = False
        self.needed = [{}, {}, {}, {}]


class Encoder:
    """Turns plane requests into planes. Rules: FBA-20, FBA-36, FBA-41, FBA-43."""

    def __init__(
        self, options: EncoderOptions | None = None, on_finding: Callable[[Finding], None] | None = None
    ) -> None:
        self.options = options if options is not None else EncoderOptions()
        self.findings: list[Finding] = []
        self._on_finding = on_finding if on_finding is not None else self.findings.append
        self._state = FaceState(DEFAULT_READINGS)
        self._face = _Part(self._state.faps)
        self._body: _Part | None = None
        self._period: list[FbaPlane] = []
        self._length = LONGEST_PERIOD
        self._idle = 0

    def encode(self, requests: Iterable[PlaneRequest]) -> Iterator[FbaPlane]:
        """The planes of a sequence of requests; a period is held back until it is complete. Rules: FBA-43."""
        for request in requests:
            yield from self._encode(request)
        yield from self._close()

    def _encode(self, request: PlaneRequest) -> Iterator[FbaPlane]:
        if request.header.is_frame_rate and self.options.intra_period is None:
            rate = Fraction(request.header.frame_rate * 16 + request.header.seconds, 16)
            self._length = max(1, min(LONGEST_PERIOD, round(rate)))
        if self.options.intra_period is not None:
            self._length = self.options.intra_period
        if self._starts_period(request):
            yield from self._close()
            self._period.append(self._intra_plane(request))
        else:
            self._period.append(self._inter_plane(request))

    def _starts_period(self, request: PlaneRequest) -> bool:
        if request.is_intra is not None:
            never = any(wanted is not None and part.request is None for part, wanted in self._parts(request))
            if request.is_intra or (self._period and not never):
                return request.is_intra
            raise EncodeError("FBA-35", "is_intra", value=0, path=f"frame[{request.number}]", allowed="1 first")
        if not self._period or len(self._period) >= self._length:
            return True
        if request.header.is_frame_rate or request.header.is_time_code:
            # Rate and time code travel in intra planes only (FBA-6, FBA-7).
            return True
        for part, part_request in self._parts(request):
            if part_request is None:
                continue
            before = part.request
            if (
                before is None
                or not part.in_period
                or (
                    (part_request.mask_types, part_request.masks, part_request.quant, part_request.coding_type)
                    != (before.mask_types, before.masks, before.quant, before.coding_type)
                )
            ):
                return True
            if not part.fits(part.levels(part_request.targets, False)):
                return True
        return False

    def _parts(self, request: PlaneRequest) -> list[tuple[_Part, PartRequest | None]]:
        parts = [(self._face, request.face)]
        if request.body is not None:
            if self._body is None:
                self._body = _Part(self._state.baps)
            parts.append((self._body, request.body))
        return parts

    def _new_plane(self, request: PlaneRequest, is_intra: int) -> FbaPlane:
        mask = (1 if request.face is not None else 0) | (2 if request.body is not None else 0)
        plane = new_plane(mask, is_intra)
        plane.header = request.header
        wanted = self.options.start_codes
        with_code = wanted == "all" or (wanted == "intra" and is_intra)
        self._idle = 0 if mask else self._idle + 1
        if self._idle == 5:
            # A run of zero bits would emulate a start code (FBA-41).
            with_code = True
            self._idle = 1
        plane.boundary = STUFFED_CODE if with_code else PLANE
        plane.start_code = FBA_OBJECT_PLANE if with_code else 0
        return plane

    def _intra_plane(self, request: PlaneRequest) -> FbaPlane:
        plane = self._new_plane(request, 1)
        if request.face is not None and plane.faps is not None:
            take_header(plane.faps, request.face)
            self._state.select_faps(plane.faps)
            self._state.faps.set_steps()
            self._face.request = request.face
            self._face.intra = plane.faps
            self._face.in_period = True
            self._high_level(request, request.face, plane.faps, True)
            self._levels(request, self._face, request.face, plane.faps, True)
        if request.body is not None and plane.baps is not None:
            take_header(plane.baps, request.body)
            self._state.baps.select(plane.baps, DEFAULT_READINGS)
            self._state.baps.set_steps()
            body = self._parts(request)[1][0]
            body.request = request.body
            body.intra = plane.baps
            body.in_period = True
            self._levels(request, body, request.body, plane.baps, True)
        return plane

    def _inter_plane(self, request: PlaneRequest) -> FbaPlane:
        plane = self._new_plane(request, 0)
        if request.face is not None and plane.faps is not None:
            self._high_level(request, request.face, plane.faps, False)
            self._levels(request, self._face, request.face, plane.faps, False)
        if request.body is not None and plane.baps is not None:
            self._levels(request, self._parts(request)[1][0], request.body, plane.baps, False)
        return plane

    def _levels(
        self, request: PlaneRequest, part: _Part, wanted: PartRequest, data: ParameterData, is_intra: bool
    ) -> None:
        levels = part.levels(wanted.targets, is_intra)
        for number, level, sent in part.clip(levels, is_intra):
            label = part.state.parameters.labels[number]
            self._clipped(request.number, f"{label}: level {level} does not fit, {sent} sent")
        part.note(levels, is_intra)
        data.levels = levels
        parameter_values(part.state, data, int(is_intra), False)

    def _high_level(self, request: PlaneRequest, wanted: PartRequest, data: ParameterData, is_intra: bool) -> None:
        state = self._state
        if state.has_viseme and wanted.viseme is not None:
            *targets, data.viseme_def = wanted.viseme
            data.viseme = self._high_levels(request.number, targets, 0, is_intra)
            state.viseme = [*high_level_values(state, data.viseme, 0, int(is_intra)), data.viseme_def]
        if state.has_expression and wanted.expression is not None:
            *targets, data.init_face, data.expression_def = wanted.expression
            data.expression = self._high_levels(request.number, targets, 3, is_intra)
            values = high_level_values(state, data.expression, 3, int(is_intra))
            state.expression = [*values, data.init_face, data.expression_def]

    def _high_levels(self, frame: int, targets: list[int], first: int, is_intra: bool) -> list[int]:
        previous = self._state.expression if first else self._state.viseme
        labels = EXPRESSION_LABELS if first else VISEME_LABELS
        out = []
        for i, target in enumerate(targets):
            quantised = high_level_quantised()[first + i]
            largest = 63 if quantised else LARGEST_SELECT[2 if first else 1]
            if not 0 <= target <= largest:
                self._clipped(frame, f"{labels[i]}: {target} is outside 0..{largest}")
                target = min(max(target, 0), largest)
            step = self._state.faps.quant if quantised else 1
            out.append(quantise(target - (0 if is_intra else previous[i]), step))
        return out

    def _clipped(self, frame: int, message: str) -> None:
        kind = registered_finding("value-clipped")
        self._on_finding(Finding(kind.id, kind.severity, kind.rule, message, path=f"frame[{frame}]"))

    def _close(self) -> Iterator[FbaPlane]:
        if not self._period:
            return
        first = self._period[0]
        if first.faps is not None:
            self._face.set_limits(self.options.ranges)
        if first.baps is not None and self._body is not None:
            self._body.set_limits(self.options.ranges)
        self._face.forget()
        if self._body is not None:
            self._body.forget()
        yield from self._period
        self._period = []


def take_header(data: ParameterData, request: PartRequest) -> None:
    """Quantiser, masks, gender and coding type of an intra plane. Rules: FBA-9..12."""
    data.quant = request.quant
    data.mask_type = list(request.mask_types)
    data.group_mask = list(request.masks)
    data.gender = request.gender
    data.coding_type = request.coding_type
