"""`.bap` text: body animation parameters, laid out as `.fap` text.

Rules: FBA-53, and FBA-50, FBA-51 through `_text_frames`.
Not here: body bitstreams (FBA-40).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.face._text_frames import (
    DEFAULT_RATE,
    FrameTextReader,
    Layout,
    check_collected,
    check_frame,
    frame_lines,
    header_line,
)

# No rule says which versions .bap files carry: any is taken, and reported unless 2.1.
_LAYOUT: Final = Layout("FBA-53", (186, 296), 295, 296, "text-295-columns", ())


@dataclass(slots=True)
class BapTextFrame:
    """One frame of a `.bap` text.

    Rules: FBA-53.

    `number`: frame number, 0..2^31-1. `mask`: 186 or 296 digits, index 0 is BAP 1. `values`: as many entries,
    integers in the BAP's unit where the mask is 1, else None. `line`: of the mask, 0 if not read; not
    compared.
    """

    number: int
    mask: tuple[int, ...]
    values: list[int | None]
    line: int = field(default=0, compare=False)


@dataclass(slots=True)
class BapFile:
    """A whole `.bap` text; the fields are those of `FapFile`. Rules: FBA-53."""

    version: str = "2.1"
    name: str = ""
    frame_rate: Fraction = DEFAULT_RATE
    nframes: int = 0
    frames: list[BapTextFrame] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list, compare=False)


class BapReader(FrameTextReader):
    """Reads a `.bap` text frame by frame; the header is known at once.

    Rules: FBA-53, FBA-51, CNF-22, CNF-25. Arguments, attributes and errors: `FapReader`.
    """

    def __init__(self, stream: Iterable[bytes], *, strict: bool = False, limits: Limits = DEFAULT_LIMITS) -> None:
        super().__init__(stream, _LAYOUT, strict, limits)

    def __iter__(self) -> Iterator[BapTextFrame]:
        while self.read_pair():
            values: list[int | None] = [None] * len(self.mask)
            for i, value in zip(self.selected, self.fields, strict=True):
                values[i] = value
            yield BapTextFrame(self.number, self.mask, values, self.line)


def read_bap(stream: Iterable[bytes], *, strict: bool = False, limits: Limits = DEFAULT_LIMITS) -> BapFile:
    """Read a whole `.bap` text. Rules: FBA-53, FBA-51, CNF-22. Arguments and errors: `read_fap`."""
    reader = BapReader(stream, strict=strict, limits=limits)
    frames: list[BapTextFrame] = []
    for frame in reader:
        check_collected(len(frames), frame.line, limits)
        frames.append(frame)
    return BapFile(
        reader.version,
        reader.name,
        reader.frame_rate,
        reader.nframes if reader.has_header else len(frames),
        frames,
        reader.comments,
        reader.findings(),
    )


def bap_header(name: str, frame_rate: Fraction, nframes: int, comments: Iterable[str] = ()) -> bytes:
    """Comment lines and header, as `fap_header`. Rules: FBA-53, FBA-50. Raises `EncodeError`."""
    return header_line("FBA-53", name, frame_rate, nframes, list(comments))


def bap_frame(frame: BapTextFrame, previous: int = -1, path: str = "frame") -> bytes:
    """The two lines of one frame, as `fap_frame`. Rules: FBA-53. Raises `EncodeError`."""
    fields = check_frame(_LAYOUT, frame.number, frame.mask, frame.values, previous, path, 0)
    return frame_lines(frame.number, frame.mask, fields)


def write_bap(bap: BapFile) -> Iterator[bytes]:
    """The plain text of a file, piece by piece, as `write_fap`.

    Rules: FBA-53, FBA-50. Raises `EncodeError`.
    """
    yield bap_header(bap.name, bap.frame_rate, len(bap.frames), bap.comments)
    previous = -1
    for i, frame in enumerate(bap.frames):
        yield bap_frame(frame, previous, f"frames[{i}]")
        previous = frame.number
