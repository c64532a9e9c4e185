"""From text files to whole streams.

Rules: FBA-1, FBA-43, FBA-52, FBA-54, SYS-2, SYS-3.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import groupby

from ..bitstream.findings import Finding
from ..bitstream.startcodes import (
    FBA_OBJECT,
    VISUAL_OBJECT,
    VISUAL_OBJECT_SEQUENCE,
    VISUAL_OBJECT_SEQUENCE_END,
)
from ..face.bap_text import BapFile, BapReader, BapTextFrame
from ..face.dct_planes import DctEncoder
from ..face.encode import Encoder, EncoderOptions
from ..face.epf_text import CodedFrame, EncoderParameters, EpfReader
from ..face.fap_text import FapFile, FapReader, FapTextFrame
from ..face.masks import masked
from ..face.records import FbaObject, FbaPlane
from ..face.requests import PlaneRequest, rate_fields, requests_for, requests_with
from ..face.syntax import ARITHMETIC, DCT
from ..rules import finding as registered_finding
from ..syntax.base import STUFFED_CODE, STUFFED_END
from ..syntax.writer import Writer
from .stream import write_pieces
from .visual import StreamItem, VisualObjectHeader


def stream_of(planes: Iterable[FbaPlane], *, profile: int | None = None, end_code: bool = True) -> list[StreamItem]:
    """Planes as a stream.

    Rules: FBA-1, SYS-2, SYS-3. `profile`: profile_and_level_indication of a sequence header, None for none.
    """
    items = stream_around(iter(()), profile=profile, end_code=end_code)
    for item in items:
        if item.fba is not None:
            item.fba.planes = list(planes)
            item.fba.coming = None
    return items


def stream_around(planes: Iterator[FbaPlane], *, profile: int | None = None, end_code: bool = True) -> list[StreamItem]:
    """As `stream_of`, but the planes are not kept: a writer takes them one by one, once. Rules: FBA-1, SYS-2, SYS-3."""
    items: list[StreamItem] = []
    if profile is not None:
        sequence = StreamItem(VISUAL_OBJECT_SEQUENCE)
        sequence.profile = profile
        header = StreamItem(VISUAL_OBJECT)
        header.header = VisualObjectHeader()
        items += [sequence, header]
    face = StreamItem(FBA_OBJECT)
    face.fba = FbaObject()
    face.fba.coming = planes
    face.fba.end = STUFFED_CODE if end_code else STUFFED_END
    items.append(face)
    if end_code:
        items.append(StreamItem(VISUAL_OBJECT_SEQUENCE_END))
    return items


def encode_fap(
    faps: FapFile,
    options: EncoderOptions | None = None,
    *,
    epf: EncoderParameters | None = None,
    baps: BapFile | None = None,
    quant: int = 1,
    bap_quant: int = 1,
    gender: int = 0,
    partial_type: int = 1,
    mode: str = "arithmetic",
    profile: int | None = None,
    end_code: bool = True,
    on_finding: Callable[[Finding], None] | None = None,
    on_progress: Callable[[int], None] | None = None,
) -> list[StreamItem]:
    """A `.fap` file as a stream.

    Rules: FBA-43, FBA-52, FBA-54, DCT-13.

    `mode`: `arithmetic` or `dct`; `epf` says it per intra frame. `quant`, `bap_quant`: 0..31. `gender`: 1 male.
    `partial_type`: mask type (1 or 2) of groups of which only some FAPs are coded. `epf`: parameters per frame, which
    override these. `on_progress` is called with the number of planes so far.
    """
    planes = _planes(
        faps.frames, faps.frame_rate, options, epf.frames if epf is not None else None,
        baps.frames if baps is not None else (), _Defaults(quant, bap_quant, gender, mode, partial_type), on_finding,
        on_progress,
    )  # fmt: skip
    return stream_of(planes, profile=profile, end_code=end_code)


def encode_text(
    text: FapReader,
    writer: Writer,
    options: EncoderOptions | None = None,
    *,
    epf: EpfReader | None = None,
    baps: BapReader | None = None,
    masks: Collection[int] | None = None,
    quant: int = 1,
    bap_quant: int = 1,
    gender: int = 0,
    partial_type: int = 1,
    mode: str = "arithmetic",
    profile: int | None = None,
    end_code: bool = True,
    on_finding: Callable[[Finding], None] | None = None,
    on_progress: Callable[[int], None] | None = None,
) -> Iterator[bytes]:
    """A `.fap` text that is read while the stream is written, piece by piece.

    Rules: FBA-43, FBA-52, FBA-54, DCT-13, CNF-22. `epf`, `baps`: read in step with it; memory grows with none of
    them. `masks`: the FAPs that every frame is to code, None for its own. The other arguments as for `encode_fap`; the
    findings of the texts themselves are complete at the end (`text.findings()`).
    """
    planes = _planes(
        text if masks is None else masked(text, masks), text.frame_rate, options, epf, baps if baps is not None else (),
        _Defaults(quant, bap_quant, gender, mode, partial_type), on_finding, on_progress,
    )  # fmt: skip
    yield from write_pieces(stream_around(planes, profile=profile, end_code=end_code), writer)


@dataclass(frozen=True, slots=True)
class _Defaults:
    quant: int
    bap_quant: int
    gender: int
    mode: str
    partial_type: int


def _planes(
    frames: Iterable[FapTextFrame],
    rate: Fraction,
    options: EncoderOptions | None,
    blocks: Iterable[CodedFrame] | None,
    bodies: Iterable[BapTextFrame],
    defaults: _Defaults,
    on_finding: Callable[[Finding], None] | None,
    on_progress: Callable[[int], None] | None,
) -> Iterator[FbaPlane]:
    make = requests_for if blocks is None else partial(requests_with, blocks)
    requests = make(
        frames,
        rate,
        quant=defaults.quant,
        bap_quant=defaults.bap_quant,
        gender=defaults.gender,
        coding_type=DCT if defaults.mode == "dct" else ARITHMETIC,
        partial_type=defaults.partial_type,
        bodies=bodies,
    )
    if on_finding is not None:
        _check_rate(rate, on_finding)
    planes = encode_requests(requests, options, on_finding)
    return planes if on_progress is None else _counted(planes, on_progress)


def _check_rate(rate: Fraction, on_finding: Callable[[Finding], None]) -> None:
    *_, said = rate_fields(rate)
    # 29.97 in a text means 30000/1001; a closer look than the text's own digits would be noise.
    if abs(said - rate) * 10_000 > rate:
        kind = registered_finding("rate-rounded")
        on_finding(Finding(kind.id, kind.severity, kind.rule, f"{rate} Hz sent as {said} Hz"))


def encode_requests(
    requests: Iterable[PlaneRequest],
    options: EncoderOptions | None = None,
    on_finding: Callable[[Finding], None] | None = None,
) -> Iterator[FbaPlane]:
    """Planes of requests; runs of one coding type go to its encoder, each run begins with an intra plane.

    Rules: FBA-12, FBA-43, DCT-13.
    """
    # One arithmetic encoder for all runs: a decoder keeps the limits over DCT planes too (FBA-19).
    arithmetic = Encoder(options, on_finding)
    for is_dct, run in groupby(requests, _is_dct):
        if is_dct:
            yield from DctEncoder(options, on_finding, arithmetic.body).encode(run)
        else:
            yield from arithmetic.encode(run)


def _is_dct(request: PlaneRequest) -> bool:
    return request.face is not None and request.face.coding_type == DCT


def _counted(planes: Iterator[FbaPlane], on_progress: Callable[[int], None]) -> Iterator[FbaPlane]:
    for count, plane in enumerate(planes, 1):
        on_progress(count)
        yield plane
