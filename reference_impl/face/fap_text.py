"""`.fap` text: facial animation parameters, one frame per two lines.

Rules: FBA-50 (the plain form, which alone is written), FBA-51 (dialects, read and reported), FBA-29
(selects).
Not here: stream to text and back (FBA-54); clamping of blend and intensities (FBA-32), which are
given as read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Final

from snhc.reference_impl.bitstream.errors import EncodeError, RangeViolation
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
from snhc.reference_impl.face._text_lines import INT_MAX, INT_MIN
from snhc.reference_impl.tables import viseme_expression_symbols

_LAYOUT: Final = Layout("FBA-50", (68,), 69, 68, "text-69-columns", ("2.0", "2.2"))
_VISEME: Final = ("viseme_select1", "viseme_select2", "viseme_blend", "viseme_def")
_EXPRESSION: Final = (
    "expression_select1",
    "expression_intensity1",
    "expression_select2",
    "expression_intensity2",
    "init_face",
    "expression_def",
)
_INTENSITIES: Final = ("expression_intensity1", "expression_intensity2")
# What a single value of FAP 1 leaves open: viseme_blend 63 shows viseme_select1 alone.
_SINGLE_VISEME: Final = (0, 63, 0)

Viseme = tuple[int, int, int, int]
Expression = tuple[int, int, int, int, int, int]


@dataclass(slots=True)
class FapTextFrame:
    """One frame of a `.fap` text.

    Rules: FBA-50.

    `number`: frame number, 0..2^31-1. `mask`: 68 digits, index 0 is FAP 1. `values`: 68 entries alike,
    integers in the FAP's unit for FAP 3..68 with mask 1, else None (always None for FAP 1 and 2). `viseme`:
    select1, select2, blend, viseme_def; `expression`: select1, intensity1, select2, intensity2, init_face,
    expression_def; None where the mask is 0. `line`: of the mask, 0 if not read; not compared.
    """

    number: int
    mask: tuple[int, ...]
    values: list[int | None]
    viseme: Viseme | None = None
    expression: Expression | None = None
    line: int = field(default=0, compare=False)


@dataclass(slots=True)
class FapFile:
    """A whole `.fap` text.

    Rules: FBA-50, FBA-51.

    `frame_rate`: frames per second, exact. `nframes`: as the header says (number of frames read, if it has
    none). `comments`: the lines before the header, without `#`. `findings`: dialects met; not compared.
    """

    version: str = "2.1"
    name: str = ""
    frame_rate: Fraction = DEFAULT_RATE
    nframes: int = 0
    frames: list[FapTextFrame] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list, compare=False)


@cache
def _domains() -> dict[str, tuple[int, int]]:
    """Bounds of flags and selects; blend and intensities are free: decoding does not clip them (FBA-32)."""
    out = {"viseme_def": (0, 1), "init_face": (0, 1), "expression_def": (0, 1)}
    for symbol in viseme_expression_symbols():
        # M is of no account for selects.
        out[symbol.name] = (INT_MIN, INT_MAX) if symbol.quantised_by_fap_quant else symbol.intra_limits(63)
    return out


class FapReader(FrameTextReader):
    """Reads a `.fap` text frame by frame; the header is known at once.

    Rules: FBA-50, FBA-51, CNF-22, CNF-25.

    `stream`: binary file or iterable of bytes. `strict`: every dialect is `InputFormat`. Attributes
    `version`, `name`, `frame_rate`, `nframes`, `comments`, `has_header`; iterate for `FapTextFrame`;
    `findings()` is complete at the end. Memory does not grow with the file. Raises `InputFormat`,
    `RangeViolation`, `ForbiddenValue`, `InconsistentSemantics`, `Truncated`, `ResourceLimit`, each with line
    and column.
    """

    def __init__(self, stream: Iterable[bytes], *, strict: bool = False, limits: Limits = DEFAULT_LIMITS) -> None:
        self._domains = _domains()
        super().__init__(stream, _LAYOUT, strict, limits)

    def expected_fields(self) -> int:
        """Four integers for FAP 1, six for FAP 2, one for each other. Rules: FBA-50."""
        return len(self.selected) + 3 * self.mask[0] + 5 * self.mask[1]

    def short_fields(self) -> int:
        """FAP 1 as a single value. Rules: FBA-51."""
        return self.expected_fields() - 3 if self.mask[0] else -1

    def __iter__(self) -> Iterator[FapTextFrame]:
        while self.read_pair():
            yield self._frame()

    def _frame(self) -> FapTextFrame:
        fields = self.fields
        mask = self.mask
        at = 0
        viseme: Viseme | None = None
        expression: Expression | None = None
        if mask[0]:
            if len(fields) == self.short_fields():
                self.lines.note("text-single-viseme", self.lines.position(1))
                self._check(_VISEME[:1], 0)
                viseme = (fields[0], *_SINGLE_VISEME)
                at = 1
            else:
                self._check(_VISEME, 0)
                viseme = (fields[0], fields[1], fields[2], fields[3])
                at = 4
        if mask[1]:
            self._check(_EXPRESSION, at)
            a, b, c, d, e, f = fields[at : at + 6]
            expression = (a, b, c, d, e, f)
            at += 6
        values: list[int | None] = [None] * 68
        if at:
            fields = fields[at:]
        for i, value in zip(self.selected[mask[0] + mask[1] :], fields, strict=True):
            values[i] = value
        return FapTextFrame(self.number, mask, values, viseme, expression, self.line)

    def _check(self, names: tuple[str, ...], start: int) -> None:
        lines = self.lines
        for i, name in enumerate(names):
            value = self.fields[start + i]
            lo, hi = self._domains[name]
            if not lo <= value <= hi:
                at = lines.position(start + i + 1)
                lines.fault(at, name, b"%d" % value, f"{lo}..{hi}", RangeViolation)
            if value == -1 and name in _INTENSITIES:
                lines.note("text-intensity-minus-one", lines.position(start + i + 1))


def read_fap(stream: Iterable[bytes], *, strict: bool = False, limits: Limits = DEFAULT_LIMITS) -> FapFile:
    """Read a whole `.fap` text.

    Rules: FBA-50, FBA-51, CNF-22. Arguments and errors: `FapReader`; more than `limits.collected_planes`
    frames are `ResourceLimit`.
    """
    reader = FapReader(stream, strict=strict, limits=limits)
    frames: list[FapTextFrame] = []
    for frame in reader:
        check_collected(len(frames), frame.line, limits)
        frames.append(frame)
    return FapFile(
        reader.version,
        reader.name,
        reader.frame_rate,
        reader.nframes if reader.has_header else len(frames),
        frames,
        reader.comments,
        reader.findings(),
    )


def fap_header(name: str, frame_rate: Fraction, nframes: int, comments: Iterable[str] = ()) -> bytes:
    """Comment lines and the header of a plain 2.1 file.

    Rules: FBA-50. Blanks of the name become `_`, backslashes `/`, an empty name `_`. The rate is exact where
    20 decimal places can be, else the shortest decimal within 1e-6. Raises `EncodeError`.
    """
    return header_line("FBA-50", name, frame_rate, nframes, list(comments))


def fap_frame(frame: FapTextFrame, previous: int = -1, path: str = "frame") -> bytes:
    """The two lines of one frame.

    Rules: FBA-50. `previous`: number of the frame before, -1 for the first. `path`: for faults. Raises
    `EncodeError`.
    """
    rest = check_frame(_LAYOUT, frame.number, frame.mask, frame.values, previous, path, 2)
    fields: list[int] = []
    domains = _domains()
    for index, (names, group) in enumerate(((_VISEME, frame.viseme), (_EXPRESSION, frame.expression))):
        where = f"{path}.{'expression' if index else 'viseme'}"
        if (group is not None) != (frame.mask[index] == 1) or (group is not None and len(group) != len(names)):
            raise EncodeError(
                "FBA-50",
                f"FAP {index + 1}",
                allowed=f"{len(names)} integers where the mask is 1, else None",
                path=where,
            )
        if group is not None:
            for name, value in zip(names, group, strict=True):
                lo, hi = domains[name]
                if not lo <= value <= hi:
                    raise EncodeError("FBA-50", name, value=value, allowed=f"{lo}..{hi}", path=where)
                fields.append(value)
    return frame_lines(frame.number, frame.mask, [*fields, *rest])


def write_fap(fap: FapFile) -> Iterator[bytes]:
    """The plain 2.1 text of a file, piece by piece.

    Rules: FBA-50. The version written is 2.1 and nframes the number of frames, whatever the record says.
    Frame numbers rise. `read_fap` gives the same back, without findings where the first frame number is 0 and
    no intensity is -1. Raises `EncodeError`.
    """
    yield fap_header(fap.name, fap.frame_rate, len(fap.frames), fap.comments)
    previous = -1
    for i, frame in enumerate(fap.frames):
        yield fap_frame(frame, previous, f"frames[{i}]")
        previous = frame.number
