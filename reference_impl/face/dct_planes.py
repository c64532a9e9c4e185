"""The encoder of DCT segments: requests for instants become planes of 16 of them.

Rules: DCT-1..7, DCT-9, DCT-10, DCT-13, FBA-40, FBA-43. Informative: which coefficients are sent is the encoder's
choice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from copy import copy
from typing import Final

from ..bitstream.errors import EncodeError
from ..bitstream.findings import Finding
from ..bitstream.startcodes import FBA_OBJECT_PLANE
from ..rules import finding as registered_finding
from ..syntax.base import PLANE, STUFFED_CODE
from ..syntax.element import DEFAULT_READINGS
from .dct_encode import quantise_segment, run_levels
from .dct_syntax import END_OF_SEGMENT, SEGMENT, CoefficientRun, SegmentData
from .dct_transform import ac_step
from .encode import Encoder, EncoderOptions
from .encode_part import PartEncoder, take_header
from .parameters import LARGEST_SELECT, fap_set
from .records import FbaPlane, ParameterData
from .requests import PartRequest, PlaneRequest, group_masks_of, selected_of
from .syntax import new_plane

SEGMENTS_PER_INTRA: Final = 8
_S16: Final = range(-32767, 32768)
_DC_TABLE: Final = range(-255, 256)
_AC_TABLE: Final = range(-256, 256)


class DctEncoder:
    """Turns plane requests into planes with DCT segments.

    Rules: DCT-1..7, DCT-9, DCT-10, DCT-13, FBA-40.

    Sixteen instants make a segment, whatever their masks: its mask is the union of theirs, and a FAP that a frame
    does not have keeps its last value (finding `masks-joined`). Skipped frames inside a segment repeat the frame
    before them. A segment is cut short only where the quantiser or the clock changes or an intra plane is asked for;
    it is then filled by repeating its last frame (finding `encode-extended`), as the last one is. The first segment,
    every eighth one and one with new masks are intra; `options.intra_period` counts planes, which are segments here.

    A plane has one set of BAPs, which belongs to its first instant: that of this instant, or where it has none the
    last one since the plane before. Others are left out (finding `baps-thinned`). New masks or another quantiser of
    the body make the plane intra. `body`: gives the body's part of the encoder whose planes stand around these.
    """

    def __init__(
        self,
        options: EncoderOptions | None = None,
        on_finding: Callable[[Finding], None] | None = None,
        body: Callable[[], PartEncoder] | None = None,
    ) -> None:
        self.options = options if options is not None else EncoderOptions()
        self._body = body if body is not None else Encoder(options).body
        self._waiting: PartRequest | None = None
        self._period: list[FbaPlane] = []
        self._ready: list[FbaPlane] = []
        self.findings: list[Finding] = []
        self._on_finding = on_finding if on_finding is not None else self.findings.append
        self._dc: dict[int, int] = {}
        self._last: dict[int, int] = {}
        self._last_viseme = (0, 0, 0, 0)
        self._last_expression = (0, 0, 0, 0, 0, 0)
        self._since_intra = 0
        self._in_force: tuple[list[int], list[int], int] | None = None

    def encode(self, requests: Iterable[PlaneRequest]) -> Iterator[FbaPlane]:
        """The planes of a sequence of requests; with BAPs a period is held back until it is complete.

        Rules: DCT-13, FBA-43. Raises EncodeError for a request without FAPs.
        """
        for plane in self._planes(requests):
            yield from self._drain()
            self._period.append(plane)
            if plane.baps is None and len(self._period) == 1:
                yield self._period.pop()
        self._end_period()
        yield from self._drain()

    def _drain(self) -> Iterator[FbaPlane]:
        yield from self._ready
        self._ready = []

    def _end_period(self) -> None:
        # The limits of the body are chosen once all levels up to the next intra plane are known.
        if self._period:
            self._body().set_limits(self.options.ranges)
            self._body().forget()
        self._ready += self._period
        self._period = []

    def _planes(self, requests: Iterable[PlaneRequest]) -> Iterator[FbaPlane]:
        batch: list[PlaneRequest] = []
        for request in requests:
            if request.face is None:
                raise EncodeError("DCT-1", "DCT segment", path=f"frame[{request.number}]", allowed="FAPs")
            if batch and (len(batch) == SEGMENT or _breaks(batch[-1], request)):
                yield self._plane(batch, 0)
                batch = []
            batch.append(request)
            skipped = request.header.number_of_frames_to_skip
            repeats = min(skipped, SEGMENT - len(batch))
            batch += [request] * repeats
            if skipped > repeats:
                yield self._plane(batch, skipped - repeats)
                batch = []
        if batch:
            yield self._plane(batch, 0)

    def _plane(self, batch: list[PlaneRequest], skipped: int) -> FbaPlane:
        first = batch[0]
        missing = SEGMENT - len(batch)
        if missing:
            message = f"the segment is filled up with {missing} times its last frame"
            self._report("encode-extended", batch[-1].number, message)
        instants = [request.face for request in batch if request.face is not None]
        instants += [instants[-1]] * missing
        header = self._joined(instants, first.number)
        types, masks, quant = header
        period = self.options.intra_period if self.options.intra_period is not None else SEGMENTS_PER_INTRA
        clock = first.header.is_frame_rate or first.header.is_time_code
        is_intra = header != self._in_force or bool(first.is_intra) or self._since_intra >= period or bool(clock)
        body = self._body_of(batch)
        is_intra = is_intra or (body is not None and self._body().changed(body))
        if is_intra:
            self._end_period()
        self._since_intra = 1 if is_intra else self._since_intra + 1
        plane = new_plane(1 if body is None else 3, int(is_intra))
        plane.header = copy(first.header)
        plane.header.skip_frames = 1 if skipped else 0
        plane.header.number_of_frames_to_skip = skipped
        with_code = self.options.start_codes == "all" or (self.options.start_codes == "intra" and is_intra)
        plane.boundary = STUFFED_CODE if with_code else PLANE
        plane.start_code = FBA_OBJECT_PLANE if with_code else 0
        assert plane.faps is not None
        if is_intra:
            take_header(plane.faps, instants[0])
            plane.faps.mask_type = list(types)
            plane.faps.group_mask = list(masks)
            self._in_force = header
            self._dc = {}
        plane.faps.segment = self._segment(
            selected_of(fap_set(), types, masks), quant, instants, is_intra, first.number
        )
        if body is not None and plane.baps is not None:
            self._put_body(body, plane.baps, is_intra, first.number)
        return plane

    def _body_of(self, batch: list[PlaneRequest]) -> PartRequest | None:
        """The BAPs of a segment's plane; those of its other instants wait for the next one, the last of them."""
        sent = batch[0].body if batch[0].body is not None else self._waiting
        self._waiting = None
        lost = set()
        for request in batch[1:]:
            if request.body is not None and request is not batch[0]:
                self._waiting = request.body
                if sent is None or request.body.targets != sent.targets:
                    lost.add(request.number)
        if lost:
            message = f"a segment has one set of BAPs; left out: {len(lost)} of other frames"
            self._report("baps-thinned", batch[0].number, message)
        return sent

    def _put_body(self, body: PartRequest, data: ParameterData, is_intra: bool, frame: int) -> None:
        part = self._body()
        if is_intra:
            take_header(data, body)
            part.state.select(data, DEFAULT_READINGS)
            part.begin(body, data)
        for message in part.put(body, data, is_intra):
            self._report("value-clipped", frame, message)

    def _joined(self, instants: list[PartRequest], frame: int) -> tuple[list[int], list[int], int]:
        """Masks of all instants together."""
        first = instants[0]
        if all((i.mask_types, i.masks) == (first.mask_types, first.masks) for i in instants):
            return first.mask_types, first.masks, first.quant
        wanted: set[int] = set()
        for instant in instants:
            wanted.update(selected_of(fap_set(), instant.mask_types, instant.masks))
        partial_type = 2 if any(2 in instant.mask_types for instant in instants) else 1
        self._report("masks-joined", frame, f"the masks of 16 instants differ; {len(wanted)} FAPs are coded")
        types, masks = group_masks_of(fap_set(), wanted, partial_type)
        return types, masks, first.quant

    def _report(self, id: str, frame: int, message: str) -> None:
        kind = registered_finding(id)
        self._on_finding(Finding(kind.id, kind.severity, kind.rule, message, path=f"frame[{frame}]"))

    def _segment(
        self, selected: list[int], quant: int, instants: list[PartRequest], is_intra: bool, frame: int
    ) -> SegmentData:
        segment = SegmentData()
        for number, instant in enumerate(instants, frame):
            if 1 in selected:
                self._last_viseme = instant.viseme or self._last_viseme
                select1, select2, blend, definition = self._last_viseme
                segment.viseme.append(self._legal(number, "viseme", (select1, select2, blend), 1))
                segment.viseme_def.append(definition)
            if 2 in selected:
                self._last_expression = instant.expression or self._last_expression
                select1, intensity1, select2, intensity2, init_face, definition = self._last_expression
                fields = (select1, select2, intensity1, intensity2)
                segment.expression.append(self._legal(number, "expression", fields, 2))
                segment.init_face.append(init_face)
                segment.expression_def.append(definition)
        for fap in selected:
            if fap > 2:
                segment.runs.append(self._run(fap, self._values(fap, instants), quant, is_intra))
        return segment

    def _values(self, fap: int, instants: list[PartRequest]) -> list[int]:
        """Sixteen values; where an instant has none the last one, at the very start the first to come."""
        value = self._last.get(fap)
        if value is None:
            value = next((i.targets[fap] for i in instants if fap in i.targets), 0)
        out = []
        for instant in instants:
            value = instant.targets.get(fap, value)
            out.append(value)
        self._last[fap] = value
        return out

    def _legal(self, frame: int, what: str, fields: tuple[int, ...], fap: int) -> list[int]:
        out = [min(max(value, 0), LARGEST_SELECT[fap] if i < 2 else 63) for i, value in enumerate(fields)]
        if out != list(fields):
            self._report("value-clipped", frame, f"{what}: {fields} is out of range, {tuple(out)} sent")
        return out

    def _run(self, fap: int, values: list[int], quant: int, is_intra: bool) -> CoefficientRun:
        coefficients = quantise_segment(values, ac_step(fap, quant))
        run = CoefficientRun()
        run.dc = coefficients[0] if is_intra else coefficients[0] - self._dc[fap]
        self._dc[fap] = coefficients[0]
        if is_intra:
            run.dc_escape = 0 if run.dc in _S16 else 1
        elif run.dc not in _DC_TABLE:
            run.dc_escape = 1 if run.dc in _S16 else 2
        for skipped, level in run_levels(coefficients):
            if skipped == END_OF_SEGMENT:
                break
            run.runs.append(skipped)
            run.levels.append(level)
            run.escapes.append(0 if level in _AC_TABLE else 1 if level in _S16 else 2)
        return run


def _breaks(before: PlaneRequest, request: PlaneRequest) -> bool:
    if request.header.is_frame_rate or request.header.is_time_code or request.is_intra:
        return True
    return before.face is not None and request.face is not None and before.face.quant != request.face.quant
