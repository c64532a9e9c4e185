"""The encoder of DCT segments: requests for instants become planes of 16 of them.

Rules: DCT-1..7, DCT-9, DCT-10, DCT-13, FBA-43. Informative: which coefficients are sent is the encoder's choice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Final

from ..bitstream.errors import EncodeError
from ..bitstream.findings import Finding
from ..rules import finding as registered_finding
from ..syntax.base import PLANE, STUFFED_CODE
from .dct_encode import quantise_segment, run_levels
from .dct_syntax import END_OF_SEGMENT, SEGMENT, CoefficientRun, SegmentData
from .dct_transform import ac_step
from .encode import EncoderOptions, take_header
from .parameters import LARGEST_SELECT, fap_set
from .records import FbaPlane
from .requests import PartRequest, PlaneRequest, selected_of
from .syntax import FBA_OBJECT_PLANE, new_plane

SEGMENTS_PER_INTRA: Final = 8
_S16: Final = range(-32767, 32768)
_DC_TABLE: Final = range(-255, 256)
_AC_TABLE: Final = range(-256, 256)


class DctEncoder:
    """Turns plane requests into planes with DCT segments.

    Rules: DCT-1..7, DCT-9, DCT-10, DCT-13.

    A segment is cut where the masks or the quantiser change or frames are skipped; one that is shorter than 16
    instants is filled by repeating the last frame (finding `encode-extended`). The first segment, every eighth one
    and one with new masks are intra. `options.intra_period` counts planes, which are segments here.
    """

    def __init__(
        self, options: EncoderOptions | None = None, on_finding: Callable[[Finding], None] | None = None
    ) -> None:
        self.options = options if options is not None else EncoderOptions()
        self.findings: list[Finding] = []
        self._on_finding = on_finding if on_finding is not None else self.findings.append
        self._dc: dict[int, int] = {}
        self._since_intra = 0
        self._in_force: PartRequest | None = None

    def encode(self, requests: Iterable[PlaneRequest]) -> Iterator[FbaPlane]:
        """The planes of a sequence of requests. Rules: DCT-13. Raises EncodeError for a request without FAPs."""
        batch: list[PlaneRequest] = []
        for request in requests:
            if batch and (len(batch) == SEGMENT or self._breaks(batch[-1], request)):
                yield self._plane(batch)
                batch = []
            batch.append(request)
        if batch:
            yield self._plane(batch)

    def _breaks(self, before: PlaneRequest, request: PlaneRequest) -> bool:
        if before.header.skip_frames or request.header.is_frame_rate or request.header.is_time_code:
            return True
        if request.is_intra is not None and request.is_intra:
            return True
        return _header(before.face) != _header(request.face)

    def _plane(self, batch: list[PlaneRequest]) -> FbaPlane:
        first, last = batch[0], batch[-1]
        wanted = first.face
        if wanted is None or any(request.body is not None for request in batch):
            raise EncodeError("DCT-1", "DCT segment", path=f"frame[{first.number}]", allowed="FAPs, and no BAPs beside")
        period = self.options.intra_period if self.options.intra_period is not None else SEGMENTS_PER_INTRA
        changed = self._in_force is None or _header(self._in_force) != _header(wanted)
        is_intra = changed or bool(first.is_intra) or self._since_intra >= period
        if first.header.is_frame_rate or first.header.is_time_code:
            is_intra = True
        self._since_intra = 1 if is_intra else self._since_intra + 1
        missing = SEGMENT - len(batch)
        if missing:
            kind = registered_finding("encode-extended")
            message = f"the segment is filled up with {missing} times its last frame"
            self._on_finding(Finding(kind.id, kind.severity, kind.rule, message, path=f"frame[{last.number}]"))
        instants = [request.face for request in batch if request.face is not None]
        instants += [instants[-1]] * missing
        plane = new_plane(1, int(is_intra))
        plane.header = first.header
        # Skipped frames lie behind the segment (DCT-13); the filling takes their place first.
        skipped = max(0, last.header.number_of_frames_to_skip - missing)
        plane.header.skip_frames = 1 if skipped else 0
        plane.header.number_of_frames_to_skip = skipped
        with_code = self.options.start_codes == "all" or (self.options.start_codes == "intra" and is_intra)
        plane.boundary = STUFFED_CODE if with_code else PLANE
        plane.start_code = FBA_OBJECT_PLANE if with_code else 0
        assert plane.faps is not None
        if is_intra:
            take_header(plane.faps, wanted)
            self._in_force = wanted
            self._dc = {}
        plane.faps.segment = self._segment(wanted, instants, is_intra, first.number)
        return plane

    def _segment(self, wanted: PartRequest, instants: list[PartRequest], is_intra: bool, frame: int) -> SegmentData:
        segment = SegmentData()
        selected = selected_of(fap_set(), wanted.mask_types, wanted.masks)
        if 1 in selected:
            for number, instant in enumerate(instants, frame):
                select1, select2, blend, definition = instant.viseme or (0, 0, 0, 0)
                segment.viseme.append(self._legal(number, "viseme", (select1, select2, blend), 2, 1))
                segment.viseme_def.append(definition)
        if 2 in selected:
            for number, instant in enumerate(instants, frame):
                select1, intensity1, select2, intensity2, init_face, definition = instant.expression or (0,) * 6
                fields = (select1, select2, intensity1, intensity2)
                segment.expression.append(self._legal(number, "expression", fields, 2, 2))
                segment.init_face.append(init_face)
                segment.expression_def.append(definition)
        for fap in selected:
            if fap > 2:
                values = [instant.targets[fap] for instant in instants]
                segment.runs.append(self._run(fap, values, wanted.quant, is_intra))
        return segment

    def _legal(self, frame: int, what: str, fields: tuple[int, ...], selects: int, fap: int) -> list[int]:
        out = [min(max(value, 0), LARGEST_SELECT[fap] if i < selects else 63) for i, value in enumerate(fields)]
        if out != list(fields):
            kind = registered_finding("value-clipped")
            message = f"{what}: {fields} is out of range, {tuple(out)} sent"
            self._on_finding(Finding(kind.id, kind.severity, kind.rule, message, path=f"frame[{frame}]"))
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


def _header(request: PartRequest | None) -> tuple[list[int], list[int], int] | None:
    return None if request is None else (request.mask_types, request.masks, request.quant)
