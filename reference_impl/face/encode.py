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
from .encode_part import PartEncoder, quantise, take_header
from .parameters import (
    EXPRESSION_LABELS,
    LARGEST_SELECT,
    VISEME_LABELS,
    high_level_quantised,
)
from .reconstruct import high_level_values
from .records import FbaPlane, ParameterData
from .requests import PartRequest, PlaneRequest
from .state import FaceState
from .syntax import new_plane

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


class Encoder:
    """Turns plane requests into planes. Rules: FBA-20, FBA-36, FBA-41, FBA-43."""

    def __init__(
        self, options: EncoderOptions | None = None, on_finding: Callable[[Finding], None] | None = None
    ) -> None:
        self.options = options if options is not None else EncoderOptions()
        self.findings: list[Finding] = []
        self._on_finding = on_finding if on_finding is not None else self.findings.append
        self._state = FaceState(DEFAULT_READINGS)
        self._face = PartEncoder(self._state.faps)
        self._body: PartEncoder | None = None
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
            if part_request is not None and part.changed(part_request):
                return True
        return False

    def body(self) -> PartEncoder:
        """The body's part, which goes on over planes that other encoders make. Rules: FBA-40."""
        if self._body is None:
            self._body = PartEncoder(self._state.baps)
        return self._body

    def _parts(self, request: PlaneRequest) -> list[tuple[PartEncoder, PartRequest | None]]:
        parts = [(self._face, request.face)]
        if request.body is not None:
            parts.append((self.body(), request.body))
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
            self._face.begin(request.face, plane.faps)
            self._high_level(request, request.face, plane.faps, True)
            self._levels(request, self._face, request.face, plane.faps, True)
        if request.body is not None and plane.baps is not None:
            take_header(plane.baps, request.body)
            self._state.baps.select(plane.baps, DEFAULT_READINGS)
            self.body().begin(request.body, plane.baps)
            self._levels(request, self.body(), request.body, plane.baps, True)
        return plane

    def _inter_plane(self, request: PlaneRequest) -> FbaPlane:
        plane = self._new_plane(request, 0)
        if request.face is not None and plane.faps is not None:
            self._high_level(request, request.face, plane.faps, False)
            self._levels(request, self._face, request.face, plane.faps, False)
        if request.body is not None and plane.baps is not None:
            self._levels(request, self.body(), request.body, plane.baps, False)
        return plane

    def _levels(
        self, request: PlaneRequest, part: PartEncoder, wanted: PartRequest, data: ParameterData, is_intra: bool
    ) -> None:
        for message in part.put(wanted, data, is_intra):
            self._clipped(request.number, message)

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
