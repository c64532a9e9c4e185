"""Header and pairs of lines: the structure that `.fap` and `.bap` text share.

Rules: FBA-50, FBA-51, FBA-53 (structure, widths, dialects), CNF-22 (frames when collecting).
Not here: the fields of FAP 1 and 2 (`fap_text`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    InconsistentSemantics,
    InputFormat,
    ResourceLimit,
    Truncated,
)
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.face._text_lines import INT_MAX, INT_MIN, TextLines, decoded, printed_rate

DEFAULT_RATE: Final = Fraction(30)
"""The rate before any is sent (FBA-37)."""

_VERSION: Final = re.compile(rb"[0-9]{1,3}\.[0-9]{1,3}")
_BLANKS: Final = re.compile(r"[\x00-\x20]")


@dataclass(frozen=True, slots=True)
class Layout:
    """What differs between the two formats.

    Rules: FBA-50, FBA-53. `widths`: mask columns. `odd_width`: columns of the tolerated mask, `odd_finding`
    its finding, `odd_full` the width it stands for. `versions`: accepted beside 2.1, empty for any.
    """

    rule: str
    widths: tuple[int, ...]
    odd_width: int
    odd_full: int
    odd_finding: str
    versions: tuple[str, ...]


class FrameTextReader:
    """Reads the header at once, then one pair of lines per call.

    Rules: FBA-50, FBA-51, FBA-53, CNF-25.

    `version`, `name`, `frame_rate`, `nframes`, `comments` (those before the header, without `#`) and
    `has_header` are known after construction. After `read_pair` is true: `number`, `mask`, `fields` (the
    integers behind the frame number), `selected` (indices of the mask's ones), `line` (of the mask). Raises
    `InputFormat`, `ResourceLimit`.
    """

    def __init__(self, stream: Iterable[bytes], layout: Layout, strict: bool, limits: Limits) -> None:
        self.layout = layout
        self.lines = TextLines(stream, layout.rule, strict, limits.text_line_bytes)
        self.version = "2.1"
        self.name = ""
        self.frame_rate = DEFAULT_RATE
        self.nframes = 0
        self.has_header = True
        self.comments: list[str] = []
        self.frames_read = 0
        self.number = -1
        self.mask: tuple[int, ...] = ()
        self.selected: list[int] = []
        self.fields: list[int] = []
        self.line = 0
        self._mask_text = b""
        self._mask_width = 0
        # What the mask calls for; asked once per mask.
        self._counts = (0, -1)
        self._header_line = 0
        self._nframes_column = 0
        self._pending = False
        self._ended = False
        self._header()

    def findings(self) -> list[Finding]:
        """The dialects met so far, one finding per kind. Rules: FBA-51, CNF-23."""
        return self.lines.findings()

    def expected_fields(self) -> int:
        """Integers that the mask calls for, without the frame number. Rules: FBA-53."""
        return len(self.selected)

    def short_fields(self) -> int:
        """A tolerated other count of integers, or -1. Rules: FBA-51."""
        return -1

    def _next(self) -> bool:
        lines = self.lines
        while lines.next_line():
            if not lines.is_comment():
                return True
            lines.note("text-comment-between", lines.position(0))
        return False

    def _header(self) -> None:
        lines = self.lines
        size = 0
        while lines.next_line():
            if not lines.is_comment():
                break
            size += len(lines.raw)
            if size > lines.max_line:
                lines.fault(0, "comment lines", b"", f"{lines.max_line} bytes", ResourceLimit, rule="CNF-22")
            self.comments.append(decoded(lines.raw.lstrip(b" \t")[1:].rstrip(b"\r")))
        else:
            raise InputFormat(self.layout.rule, "empty file", allowed="a header and frames", line=1, column=1)
        lines.plain()
        raw = lines.raw.rstrip(b" \t")
        tokens = raw.split(None, 4)
        if len(tokens) > 4 and not raw.translate(None, b" \t01"):
            self.has_header = False
            self._pending = True
            lines.note("text-no-header", lines.position(0))
            return
        start = len(raw) - len(raw.lstrip(b" \t"))
        version = tokens[0]
        if _VERSION.fullmatch(version) is None or (
            self.layout.versions and version != b"2.1" and version.decode() not in self.layout.versions
        ):
            allowed = ", ".join(sorted({"2.1", *self.layout.versions})) if self.layout.versions else "digits.digits"
            lines.fault(start, "version", version, allowed)
        if len(tokens) < 4:
            lines.fault(start, "header of fewer than four fields", raw, "version name fps nframes")
        if version != b"2.1":
            lines.note("text-version", start, version.decode())
        self.version = version.decode()
        before, rate, count = raw.rsplit(None, 2)
        count_at = len(raw) - len(count)
        rate_at = len(raw[:count_at].rstrip(b" \t")) - len(rate)
        name_at = start + len(version)
        name_at += len(raw[name_at:]) - len(raw[name_at:].lstrip(b" \t"))
        name = before[name_at:]
        if b" " in name or b"\t" in name:
            lines.note("text-blank-in-name", name_at)
        if b"\\" in name:
            lines.note("text-backslash-in-name", name_at + name.index(b"\\"))
        self.name = decoded(name)
        self.frame_rate = lines.rate(rate_at, rate)
        self.nframes = lines.integer(count_at, "nframes", count, 0)
        self._header_line = lines.number
        self._nframes_column = lines.column(count_at)

    def read_pair(self) -> bool:
        """Read the two lines of the next frame; False at the end of the text.

        Rules: FBA-50, FBA-51, FBA-53. Raises `InputFormat`, `RangeViolation`, `InconsistentSemantics` (frame
        number), `Truncated` (no line behind the mask), `ResourceLimit`.
        """
        lines = self.lines
        if not self._pending and (self._ended or not self._next()):
            if not self._ended:
                self._ended = True
                self._end()
            return False
        self._pending = False
        self.line = lines.number
        self._read_mask()
        if not self._next():
            raise Truncated(
                self.layout.rule,
                "frame",
                allowed="a line of values behind the mask",
                line=self.line,
                column=1,
            )
        self._read_values()
        self.frames_read += 1
        return True

    def _end(self) -> None:
        if self.has_header and self.nframes != self.frames_read:
            self.lines.note(
                "text-nframes",
                0,
                f"{self.nframes}, read {self.frames_read}",
                self._header_line,
                self._nframes_column,
            )

    def _read_mask(self) -> None:
        lines = self.lines
        layout = self.layout
        raw = lines.raw
        if raw != self._mask_text:
            tokens = raw.split()
            if raw.translate(None, b" \t01") or any(len(token) > 1 for token in tokens):
                lines.plain()
                for i, token in enumerate(tokens):
                    if token not in (b"0", b"1"):
                        lines.fault(lines.position(i), f"mask column {i + 1}", token, "0, 1")
            width = len(tokens)
            if width != layout.odd_width and width not in layout.widths:
                wanted = " or ".join(str(n) for n in layout.widths)
                at = lines.position(min(max(layout.widths), width))
                lines.fault(at, "mask columns", b"%d" % width, expected=wanted)
            mask = tuple([1 if token == b"1" else 0 for token in tokens])
            if width == layout.odd_width:
                if width > layout.odd_full and mask[-1]:
                    lines.fault(lines.position(width - 1), f"mask column {width}", tokens[-1], "0")
                mask = mask[: layout.odd_full] + (0,) * (layout.odd_full - width)
            self.mask = mask
            self.selected = [i for i, digit in enumerate(mask) if digit]
            self._mask_text = raw
            self._mask_width = width
            self._counts = (self.expected_fields(), self.short_fields())
        if self._mask_width == layout.odd_width:
            lines.note(layout.odd_finding, len(raw.rstrip(b" \t")))

    def _read_values(self) -> None:
        lines = self.lines
        raw = lines.raw
        tokens = raw.split()
        # A plain line is converted at once; everything else goes token by token, with its column.
        plain = len(raw) < 4000 and not raw.translate(None, b" \t0123456789-")
        if not plain and raw.translate(None, b" \t0123456789+-.eE"):
            lines.plain()
            for i, token in enumerate(tokens):
                if token.translate(None, b"0123456789+-.eE"):
                    lines.fault(lines.position(i), self._what(i), token, "a number")
        read = len(tokens) - 1
        expected, short = self._counts
        if read != expected and read != short:
            at = lines.position(min(read, expected) + 1)
            lines.fault(at, f"values of frame {shown_number(tokens[0])}", b"%d" % read, expected=expected)
        numbers: list[int] | None = None
        if plain:
            try:
                numbers = list(map(int, tokens))
            except ValueError:
                pass
            else:
                if min(numbers) < INT_MIN or max(numbers) > INT_MAX:
                    numbers = None
        if numbers is None or numbers[0] < 0:
            number = lines.integer(lines.position(0), "frame number", tokens[0], 0)
        else:
            number = numbers[0]
        if number <= self.number:
            lines.fault(lines.position(0), "frame number", tokens[0], f"above {self.number}", InconsistentSemantics)
        if self.number < 0 and number > 0:
            lines.note("text-first-frame-one", lines.position(0), str(number))
        self.number = number
        self.fields = self._slow(tokens) if numbers is None else numbers[1:]

    def _slow(self, tokens: list[bytes]) -> list[int]:
        lines = self.lines
        out: list[int] = []
        at = 0
        raw = lines.raw
        for i, token in enumerate(tokens):
            at = raw.index(token, at)
            if i:
                out.append(lines.rounded(at, self._what(i), token))
            at += len(token)
        return out

    def _what(self, index: int) -> str:
        return "frame number" if index == 0 else f"value {index} of the line"


def check_collected(read: int, line: int, limits: Limits) -> None:
    """Refuse to keep more frames than the limit. Rules: CNF-22. Raises `ResourceLimit`."""
    if read >= limits.collected_planes:
        raise ResourceLimit("CNF-22", "frames kept", allowed=f"at most {limits.collected_planes}", line=line, column=1)


def shown_number(token: bytes) -> str:
    """The frame number as a message shows it. Rules: CNF-25."""
    return token[:12].decode("ascii", "replace")


def header_line(rule: str, name: str, frame_rate: Fraction, nframes: int, comments: Sequence[str]) -> bytes:
    """Comment lines and header of a plain 2.1 file.

    Rules: FBA-50, FBA-51. Blanks and control characters of the name become `_`, backslashes `/`, an empty
    name `_`. Raises `EncodeError`.
    """
    if not 0 <= nframes <= INT_MAX:
        raise EncodeError(rule, "nframes", value=nframes, allowed=f"0..{INT_MAX}", path="nframes")
    clean = _BLANKS.sub("_", name).replace("\\", "/") or "_"
    rows: list[str] = []
    for i, comment in enumerate(comments):
        if "\n" in comment or comment.endswith("\r") or "\0" in comment:
            raise EncodeError(rule, "line end or NUL", allowed="one line", path=f"comments[{i}]")
        rows.append(f"#{comment}\n")
    rows.append(f"2.1 {clean} {printed_rate(frame_rate)} {nframes}\n")
    try:
        return "".join(rows).encode("utf-8")
    except UnicodeEncodeError:
        raise EncodeError(rule, "name or comment with a lone surrogate", allowed="Unicode text", path="name") from None


def check_frame(
    layout: Layout,
    number: int,
    mask: Sequence[int],
    values: Sequence[int | None],
    previous: int,
    path: str,
    first: int,
) -> list[int]:
    """The values of the masked parameters from index `first` on, checked for writing.

    Rules: FBA-50, FBA-53. `previous`: number of the frame before, -1 for the first. Raises `EncodeError`.
    """
    if not previous < number <= INT_MAX:
        raise EncodeError(
            layout.rule,
            "frame number",
            value=number,
            allowed=f"{previous + 1}..{INT_MAX}",
            path=f"{path}.number",
        )
    if len(mask) not in layout.widths or any(digit not in (0, 1) for digit in mask):
        wanted = " or ".join(str(n) for n in layout.widths)
        raise EncodeError(layout.rule, "mask", allowed=f"{wanted} digits 0, 1", path=f"{path}.mask")
    if len(values) != len(mask):
        raise EncodeError(layout.rule, "values", value=len(values), expected=len(mask), path=f"{path}.values")
    out: list[int] = []
    for i, value in enumerate(values):
        coded = i >= first and mask[i] == 1
        if coded != (value is not None) or (value is not None and not INT_MIN <= value <= INT_MAX):
            raise EncodeError(
                layout.rule,
                "value",
                value=value,
                allowed="32-bit integers where the mask is 1, else None",
                path=f"{path}.values[{i}]",
            )
        if value is not None:
            out.append(value)
    return out


def frame_lines(number: int, mask: Sequence[int], fields: Sequence[int]) -> bytes:
    """The two lines of a frame. Rules: FBA-50, FBA-53."""
    digits = " ".join(["1" if digit else "0" for digit in mask])
    return f"{digits}\n{' '.join([str(n) for n in (number, *fields)])}\n".encode("ascii")
