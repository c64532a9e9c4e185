"""What an encoder is asked to code: text files turned into one request per plane.

Rules: FBA-14, FBA-37, FBA-52, FBA-54.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Generic, TypeVar

from ..bitstream.errors import EncodeError, InconsistentSemantics
from ..syntax.temporal import TemporalHeader
from .bap_text import BapFile, BapTextFrame
from .epf_text import CodedFrame, PartParameters
from .fap_text import FapFile, FapTextFrame
from .parameters import ParameterSet, bap_set, fap_set

_Frame = TypeVar("_Frame", FapTextFrame, BapTextFrame)


@dataclass(slots=True)
class PartRequest:
    """What one plane is to carry of the FAPs or the BAPs.

    Rules: FBA-14, FBA-43, FBA-52.

    `targets`: value by number. `mask_types`, `masks`: per group, as they are sent. `quant`, `gender`, `coding_type`:
    in force from an intra plane on. `limits`: the lists i_max, i_min, p_max, p_min by number, or None: the encoder's
    choice. `viseme`, `expression`: as in the text format.
    """

    targets: dict[int, int]
    mask_types: list[int]
    masks: list[int]
    quant: int = 1
    gender: int = 0
    coding_type: int = 0
    limits: list[dict[int, int] | None] = field(default_factory=lambda: [None, None, None, None])
    viseme: tuple[int, int, int, int] | None = None
    expression: tuple[int, int, int, int, int, int] | None = None


@dataclass(slots=True)
class PlaneRequest:
    """What one plane is to carry. Rules: FBA-43, FBA-54.

    `number`: frame number of the source, for findings. `is_intra` None: the encoder's choice.
    """

    number: int
    header: TemporalHeader
    is_intra: bool | None
    face: PartRequest | None
    body: PartRequest | None = None


def rate_fields(rate: Fraction) -> tuple[int, int, int, Fraction]:
    """(frame_rate, seconds, frequency_offset, what they say) closest to a rate; exact where possible.

    Rules: FBA-37. Raises EncodeError for a rate that is not above 0 or 256 and more.
    """
    best: tuple[Fraction, int, int, int, Fraction] | None = None
    for offset in (0, 1):
        factor = Fraction(1000, 1001) if offset else Fraction(1)
        sixteenths = round(rate / factor * 16)
        if not 0 < sixteenths < 256 * 16:
            continue
        said = Fraction(sixteenths, 16) * factor
        distance = abs(said - rate)
        if best is None or distance < best[0]:
            best = (distance, sixteenths >> 4, sixteenths & 15, offset, said)
    if best is None:
        raise EncodeError("FBA-37", "frame rate", value=str(rate), allowed="1/16 .. 255 15/16")
    return best[1], best[2], best[3], best[4]


def set_rate(header: TemporalHeader, rate: Fraction) -> Fraction:
    """Put a rate into a header; returns the rate that it then says. Rules: FBA-6, FBA-37."""
    header.frame_rate, header.seconds, header.frequency_offset, said = rate_fields(rate)
    header.is_frame_rate = 1
    return said


def group_masks_of(parameters: ParameterSet, wanted: set[int], partial_type: int) -> tuple[list[int], list[int]]:
    """Mask types and masks that select a set of parameters.

    Rules: FBA-10, FBA-14. `partial_type`: 1 or 2, for groups of which only some are wanted.
    """
    types: list[int] = []
    masks: list[int] = []
    for group in parameters.groups:
        bits = [number in wanted for number in group]
        mask = 0
        for bit in bits:
            mask = mask << 1 | bit
        if all(bits):
            types.append(3)
            masks.append(0)
        elif any(bits):
            types.append(partial_type)
            masks.append(mask)
        else:
            types.append(0)
            masks.append(0)
    return types, masks


def selected_of(parameters: ParameterSet, types: list[int], masks: list[int]) -> list[int]:
    """The parameters that mask types and masks select, in coding order. Rules: FBA-10, FBA-14."""
    out: list[int] = []
    for group, mask_type, mask in zip(parameters.groups, types, masks, strict=True):
        last = len(group) - 1
        for i, number in enumerate(group):
            if mask_type == 3 or (mask_type and mask >> (last - i) & 1):
                out.append(number)
    return out


class _Ascending(Generic[_Frame]):
    """The frames of a text, read as far as they are asked for; their numbers ascend."""

    def __init__(self, frames: Iterable[_Frame]) -> None:
        self._rest: Iterator[_Frame] = iter(frames)
        self.at: _Frame | None = next(self._rest, None)

    def step(self) -> None:
        """To the next frame; `at` is None behind the last."""
        self.at = next(self._rest, None)

    def find(self, number: int) -> _Frame | None:
        """The frame of this number, None where there is none; what lies before it is passed."""
        while self.at is not None and self.at.number < number:
            self.step()
        return self.at if self.at is not None and self.at.number == number else None

    def finish(self) -> None:
        """Read to the end: a fault there is one, too."""
        while self.at is not None:
            self.step()


def requests_of(
    faps: FapFile,
    *,
    quant: int = 1,
    gender: int = 0,
    coding_type: int = 0,
    partial_type: int = 1,
    baps: BapFile | None = None,
    bap_quant: int = 1,
) -> Iterator[PlaneRequest]:
    """One request per frame of a `.fap` file, as `requests_for`. Rules: FBA-54."""
    return requests_for(
        faps.frames,
        faps.frame_rate,
        quant=quant,
        gender=gender,
        coding_type=coding_type,
        partial_type=partial_type,
        bodies=baps.frames if baps is not None else (),
        bap_quant=bap_quant,
    )


def requests_for(
    frames: Iterable[FapTextFrame],
    rate: Fraction,
    *,
    quant: int = 1,
    gender: int = 0,
    coding_type: int = 0,
    partial_type: int = 1,
    bodies: Iterable[BapTextFrame] = (),
    bap_quant: int = 1,
) -> Iterator[PlaneRequest]:
    """One request per frame of a text.

    Rules: FBA-53, FBA-54, CNF-22. A gap in the frame numbers becomes `skip_frames` of the plane before it; the rate
    stands in the first plane. BAP frames (`bodies`) of the same number ride along; others are an
    InconsistentSemantics. Both texts are read in step, one frame is held back.
    """
    body = _Ascending(bodies)
    for request in _face_requests(frames, rate, quant, gender, coding_type, partial_type):
        if body.at is not None and body.at.number <= request.number:
            if body.at.number < request.number:
                raise _no_face(body.at)
            request.body = _body_request(body.at, bap_quant, gender)
            body.step()
        yield request
    if body.at is not None:
        raise _no_face(body.at)


def _no_face(frame: BapTextFrame) -> InconsistentSemantics:
    allowed = "one that the .fap file has"
    return InconsistentSemantics("FBA-53", "frame number", value=frame.number, line=frame.line, allowed=allowed)


def _face_requests(
    frames: Iterable[FapTextFrame], rate: Fraction, quant: int, gender: int, coding_type: int, partial_type: int
) -> Iterator[PlaneRequest]:
    mask: tuple[int, ...] = ()
    types: list[int] = []
    masks: list[int] = []
    held: PlaneRequest | None = None
    for frame in frames:
        if held is not None:
            _skip(held.header, frame.number - held.number - 1)
            yield held
        header = TemporalHeader()
        if held is None:
            set_rate(header, rate)
        if frame.mask != mask:
            mask = frame.mask
            types, masks = group_masks_of(fap_set(), {n + 1 for n, bit in enumerate(mask) if bit}, partial_type)
        face = PartRequest(_targets(frame), types, masks, quant, gender, coding_type)
        face.viseme = frame.viseme
        face.expression = frame.expression
        held = PlaneRequest(frame.number, header, None, face)
    if held is not None:
        yield held


def _body_request(frame: BapTextFrame, quant: int, gender: int) -> PartRequest:
    wanted = {n + 1 for n, bit in enumerate(frame.mask) if bit}
    types, masks = group_masks_of(bap_set(), wanted, 1)
    return PartRequest(_targets(frame), types, masks, quant, gender)


def _targets(frame: FapTextFrame | BapTextFrame) -> dict[int, int]:
    return {number: value for number, value in enumerate(frame.values, 1) if value is not None}


def _skip(header: TemporalHeader, skipped: int) -> None:
    header.skip_frames = 1 if skipped else 0
    header.number_of_frames_to_skip = skipped


def requests_with(
    blocks: Iterable[CodedFrame],
    frames: Iterable[FapTextFrame],
    rate: Fraction,
    *,
    quant: int = 1,
    bap_quant: int = 1,
    gender: int = 0,
    coding_type: int = 0,
    partial_type: int = 1,
    bodies: Iterable[BapTextFrame] = (),
) -> Iterator[PlaneRequest]:
    """One request per coded frame of an `.epf` text.

    Rules: FBA-52, CNF-22. Its masks override those of the text files; what it does not say stays as last said. `rate`
    stands in the first plane where the parameters name none. The numbers of frames ascend; a frame that the text does
    not have, or a value that it does not give, is an InconsistentSemantics. The other arguments hold until the
    parameters say otherwise. All texts are read in step, to their ends.
    """
    face_text, body_text = _Ascending(frames), _Ascending(bodies)
    face_state = _Sticky(10, quant, gender, coding_type, partial_type)
    body_state = _Sticky(24, bap_quant, gender, 0, 1)
    last_face = last_body = -1
    for i, coded in enumerate(blocks):
        header = TemporalHeader()
        _header_of(header, coded.body)
        _header_of(header, coded.face)
        if i == 0 and not header.is_frame_rate:
            set_rate(header, rate)
        face = body = None
        number = i
        if coded.fba_object_mask & 1:
            number = last_face = _number_of("FFR", coded.face, i, last_face, coded)
            text = face_text.find(number)
            if text is None:
                raise _missing("FFR", number, coded, "a frame of the .fap file")
            face = face_state.request(coded.face, fap_set(), text, coded)
            face.viseme = text.viseme
            face.expression = text.expression
            _needs_high_level(face, coded)
        if coded.fba_object_mask & 2:
            number = last_body = _number_of("BFR", coded.body, i, last_body, coded)
            text_body = body_text.find(number)
            if text_body is None:
                raise _missing("BFR", number, coded, "a frame of the .bap file")
            body = body_state.request(coded.body, bap_set(), text_body, coded)
        yield PlaneRequest(number, header, coded.is_intra, face, body)
    face_text.finish()
    body_text.finish()


def _number_of(tag: str, part: PartParameters, block: int, last: int, coded: CodedFrame) -> int:
    number = block if part.frame is None else part.frame
    if number <= last:
        # A reader sees to the numbers that stand there; the number of a block may lie below them.
        what = f"{tag} (the number of the block)" if part.frame is None else tag
        raise _missing(what, number, coded, f"a number above {last}")
    return number


def _missing(tag: str, number: int, coded: CodedFrame, allowed: str) -> InconsistentSemantics:
    return InconsistentSemantics("FBA-52", tag, value=number, line=coded.line, column=1, allowed=allowed)


def _needs_high_level(face: PartRequest, coded: CodedFrame) -> None:
    selected = selected_of(fap_set(), face.mask_types, face.masks)
    for fap, given in ((1, face.viseme), (2, face.expression)):
        if fap in selected and given is None:
            raise _missing("FMT", fap, coded, "FAPs that the .fap frame gives values for")


def _header_of(header: TemporalHeader, part: PartParameters) -> None:
    if part.frame_rate is not None:
        header.is_frame_rate = 1
        header.frame_rate, header.seconds, header.frequency_offset = part.frame_rate
    if part.time_code is not None:
        header.is_time_code = 1
        header.time_code_hours, header.time_code_minutes, header.time_code_seconds = part.time_code
    if part.skip:
        _skip(header, part.skip)


class _Sticky:
    """What an `.epf` part said last. Rules: FBA-15, FBA-52."""

    def __init__(self, groups: int, quant: int, gender: int, coding_type: int, partial_type: int) -> None:
        self.types = [0] * groups
        self.masks = [0] * groups
        self.quant = quant
        self.gender = gender
        self.coding_type = coding_type
        self.partial_type = partial_type
        self.said_masks = False

    def request(
        self, part: PartParameters, parameters: ParameterSet, text: FapTextFrame | BapTextFrame, coded: CodedFrame
    ) -> PartRequest:
        if part.mask_types is not None:
            self.types = list(part.mask_types)
            self.masks = [_number(mask) for mask in part.masks] if part.masks is not None else [0] * len(self.types)
            self.said_masks = True
        elif not self.said_masks:
            wanted = {n + 1 for n, bit in enumerate(text.mask) if bit}
            masks = group_masks_of(parameters, wanted, self.partial_type)
            if coded.is_intra is False and masks != (self.types, self.masks):
                # Inter planes cannot send masks (FBA-15).
                raise _missing("mask", text.number, coded, "the masks of the intra plane before it, or ISI 1")
            self.types, self.masks = masks
        if part.quant is not None:
            self.quant = part.quant
        if part.gender is not None:
            self.gender = part.gender
        if part.coding_type is not None:
            self.coding_type = part.coding_type
        targets = _targets(text)
        first = 3 if len(self.types) == 10 else 1
        for number in selected_of(parameters, self.types, self.masks):
            if number >= first and number not in targets:
                raise _missing("mask", number, coded, "parameters that the text frame gives values for")
        limits = [
            None if given is None else dict(zip(_limit_numbers(parameters, len(given)), given, strict=True))
            for given in (part.i_max, part.i_min, part.p_max, part.p_min)
        ]
        return PartRequest(
            targets, list(self.types), list(self.masks), self.quant, self.gender, self.coding_type, limits
        )


def _limit_numbers(parameters: ParameterSet, count: int) -> range:
    first = 3 if len(parameters.groups) == 10 else 1
    return range(first, first + count)


def _number(mask: tuple[int, ...] | None) -> int:
    out = 0
    for bit in mask or ():
        out = out << 1 | bit
    return out
