"""Lines, numbers and dialects: what the text formats of face animation share.

Rules: FBA-51 (dialects, reported once per kind and file), CNF-21 and CNF-25 (line and column), CNF-22 (text
line).
Not here: headers, masks and frames (`_text_frames`), tags (`epf_text`).

Lines stay bytes: blanks are then blanks and tabs only (a name may hold any other character), and a column is
found only when a fault or finding needs it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from typing import Final, NoReturn, cast

from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    ForbiddenValue,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from snhc.reference_impl.bitstream.findings import Finding

INT_MIN: Final = -(1 << 31)
INT_MAX: Final = (1 << 31) - 1
_INT_ALLOWED: Final = "-2147483648..2147483647"

_CHUNK: Final = 1 << 16
_BINARY_WINDOW: Final = 4096
_RATE_PLACES: Final = 20
_EXPONENT_MAX: Final = 308

_CONTROL: Final = re.compile(rb"[\x00-\x08\x0a-\x1f]")
_TOKEN: Final = re.compile(rb"[^ \t]+")
_INTEGER: Final = re.compile(rb"[+-]?[0-9]+")
# Possessive: a long number that ends in a letter is not tried once per digit.
_DECIMAL: Final = re.compile(rb"([+-]?)([0-9]*+)(?:\.([0-9]*+))?(?:[eE]([+-]?)([0-9]++))?")

DIALECTS: Final[dict[str, tuple[str, str]]] = {
    "text-crlf": ("info", "line end CR LF"),
    "text-tabs": ("info", "tab between fields"),
    "text-trailing-blanks": ("info", "blanks at the end of a line, or an empty line"),
    "text-blank-in-name": ("info", "blank in the name"),
    "text-backslash-in-name": ("info", "backslash in the name"),
    "text-no-header": ("warning", "no header, version 2.1 and 30 frames per second assumed"),
    "text-comment-between": ("info", "comment behind the header"),
    "text-decimal": ("warning", "decimal value, rounded half away from zero"),
    "text-69-columns": ("info", "mask of 69 columns, the last one left out"),
    "text-295-columns": ("info", "mask of 295 columns, BAP 296 taken as not coded"),
    "text-single-viseme": (
        "warning",
        "single value of FAP 1, taken as viseme_select1 (viseme_select2 0, viseme_blend 63, viseme_def 0)",
    ),
    "text-first-frame-one": ("info", "first frame number is not 0"),
    "text-version": ("info", "version is not 2.1"),
    "text-nframes": ("warning", "nframes differs from the number of frames"),
    "text-no-final-newline": ("info", "no line end after the last line"),
    "text-intensity-minus-one": ("warning", "expression intensity -1, kept as it is (applied to a face: 0)"),
}
"""Severity and words of each accepted dialect, by finding id (FBA-51, FBA-53)."""


def shown(token: bytes) -> str:
    """A token as an error shows it: ASCII, at most 40 characters. Rules: CNF-25."""
    text = token[:41].decode("ascii", "backslashreplace")
    return text if len(text) <= 40 else text[:37] + "..."


def decoded(raw: bytes) -> str:
    """A name or comment: UTF-8, else Latin-1, which loses nothing. Rules: FBA-51."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def _chunks(stream: Iterable[bytes]) -> Iterator[bytes]:
    # read1 hands on what a pipe has; read would wait until the whole chunk is there.
    reader = getattr(stream, "read1", None) or getattr(stream, "read", None)
    if reader is None:
        yield from stream
        return
    read = cast("Callable[[int], bytes]", reader)
    while chunk := read(_CHUNK):
        yield chunk


def _split(stream: Iterable[bytes], rule: str, max_line: int) -> Iterator[tuple[bytes, bool]]:
    """Lines without their LF, and whether there was one; at most one line and one chunk are held."""
    source = _chunks(stream)
    head = bytearray()
    for chunk in source:
        if 0 in chunk and chunk.index(0) + len(head) < _BINARY_WINDOW:
            # Where a NUL stands in a binary file means nothing; column 1 of line 1 says "the file".
            raise InputFormat(rule, "binary data", allowed="a text file", line=1, column=1)
        head += chunk
        if len(head) >= _BINARY_WINDOW:
            break
    carry: list[bytes] = []
    held = 0
    number = 1
    chunk = bytes(head)
    while chunk:
        lines = chunk.split(b"\n")
        last = lines.pop()
        for part in lines:
            if carry:
                carry.append(part)
                part = b"".join(carry)
                carry.clear()
                held = 0
            if len(part) > max_line and len(part) > max_line + part.endswith(b"\r"):
                raise _too_long(number, max_line)
            yield part, True
            number += 1
        if last:
            carry.append(last)
            held += len(last)
            # One more may be the CR of a CR LF, which is not part of the line.
            if held > max_line + 1:
                raise _too_long(number, max_line)
        chunk = next(filter(None, source), b"")
    if held > max_line:
        raise _too_long(number, max_line)
    if carry:
        yield b"".join(carry), False


def _too_long(line: int, limit: int) -> ResourceLimit:
    return ResourceLimit("CNF-22", "text line", allowed=f"at most {limit} bytes", line=line, column=limit + 1)


class TextLines:
    """The lines of one text input, with its dialects counted.

    Rules: FBA-51, CNF-22, CNF-25.

    `stream`: a binary file, or an iterable of bytes whose concatenation is the text. `rule`: the rule of the
    format, for faults. `strict`: a dialect is `InputFormat` at its place. `max_line`: bytes. After
    `next_line`: `raw` is the line without its end, `number` its number from 1.
    """

    __slots__ = ("_counts", "_source", "max_line", "number", "raw", "rule", "strict")

    def __init__(self, stream: Iterable[bytes], rule: str, strict: bool, max_line: int) -> None:
        self.rule = rule
        self.strict = strict
        self.max_line = max_line
        self.number = 0
        self.raw = b""
        self._source = _split(stream, rule, max_line)
        self._counts: dict[str, tuple[int, int, str]] = {}

    def next_line(self) -> bool:
        """Go to the next line that is not empty; False at the end of the text.

        Rules: FBA-51, CNF-22. Raises `ResourceLimit`, `InputFormat` (NUL bytes).
        """
        for raw, ended in self._source:
            self.number += 1
            if raw.endswith(b"\r") and ended:
                raw = raw[:-1]
                self.raw = raw
                self.note("text-crlf", len(raw))
            self.raw = raw
            if 0 in raw:
                self.fault(raw.index(0), "NUL byte", b"")
            if not ended:
                self.note("text-no-final-newline", len(raw))
            if raw[-1:] in (b" ", b"\t", b""):
                stripped = raw.rstrip(b" \t")
                if not stripped.lstrip(b" \t").startswith(b"#"):
                    self.note("text-trailing-blanks", len(stripped))
                if not stripped:
                    continue
            if b"\t" in raw and not self.is_comment():
                self.note("text-tabs", raw.index(b"\t"))
            return True
        return False

    def is_comment(self) -> bool:
        """Whether the line is a `#` comment. Rules: FBA-50."""
        raw = self.raw
        return raw[:1] == b"#" or (raw[:1] in (b" ", b"\t") and raw.lstrip(b" \t")[:1] == b"#")

    def column(self, position: int) -> int:
        """Column from 1, in characters, of a byte position of the line. Rules: CNF-25."""
        return len(self.raw[:position].decode("utf-8", "replace")) + 1

    def position(self, index: int) -> int:
        """Byte position of token `index`; behind the last token where there are fewer. Rules: CNF-25."""
        for i, match in enumerate(_TOKEN.finditer(self.raw)):
            if i == index:
                return match.start()
        return len(self.raw.rstrip(b" \t"))

    def note(self, finding: str, position: int, detail: str = "", line: int = 0, column: int = 0) -> None:
        """Count one occurrence of a dialect; under strict, refuse it.

        Rules: FBA-51, CNF-23. `position`: byte in this line. `line`, `column`: where it stands, if not in
        this line.
        """
        if self.strict:
            raise InputFormat(
                self.rule,
                DIALECTS[finding][1] + (f" ({detail})" if detail else ""),
                allowed="plain text of this format (strict)",
                line=line or self.number,
                column=column or self.column(position),
            )
        first, count, words = self._counts.get(finding, (line or self.number, 0, detail))
        self._counts[finding] = (first, count + 1, words)

    def findings(self) -> list[Finding]:
        """One finding per kind of dialect met so far, at its first line, by line. Rules: CNF-23, FBA-51."""
        out: list[Finding] = []
        for name, (line, count, detail) in self._counts.items():
            severity, text = DIALECTS[name]
            if detail:
                text += f" ({detail})"
            if count > 1:
                text += f", {count} times"
            out.append(Finding(name, severity, "FBA-53" if name == "text-295-columns" else "FBA-51", text, line=line))
        return sorted(out, key=lambda finding: finding.line or 0)

    def fault(
        self,
        position: int,
        what: str,
        token: bytes,
        allowed: str = "",
        kind: type[SnhcError] = InputFormat,
        expected: int | str | None = None,
        rule: str = "",
    ) -> NoReturn:
        """Raise `kind` at a byte position of this line. Rules: CNF-7, CNF-25."""
        raise kind(
            rule or self.rule,
            what,
            value=shown(token) if token else None,
            allowed=allowed,
            line=self.number,
            column=self.column(position),
            expected=expected,
        )

    def plain(self) -> None:
        """Refuse control characters. Rules: FBA-50. Raises `InputFormat`."""
        match = _CONTROL.search(self.raw)
        if match is not None:
            self.fault(match.start(), "control character", match.group(), "printable characters, blanks, tabs")

    def integer(self, position: int, what: str, token: bytes, lo: int = INT_MIN, hi: int = INT_MAX) -> int:
        """An integer token in lo..hi. Rules: FBA-50, CNF-7. Raises `InputFormat`, `RangeViolation`."""
        if _INTEGER.fullmatch(token) is None:
            self.fault(position, what, token, "an integer")
        digits = token.lstrip(b"+-").lstrip(b"0")
        # Compared by length first: converting a megabyte of digits is quadratic.
        value = int(digits or b"0") if len(digits) <= 10 else INT_MAX + 1
        if token[:1] == b"-":
            value = -value if len(digits) <= 10 else INT_MIN - 1
        if not lo <= value <= hi:
            self.fault(position, what, token, f"{lo}..{hi}", RangeViolation)
        return value

    def rounded(self, position: int, what: str, token: bytes) -> int:
        """A value token: an integer of 32 bits, or a decimal rounded half away from zero (noted).

        Rules: FBA-51. Exact: decided by digits, never by a float. Raises `InputFormat`, `RangeViolation`.
        """
        if _INTEGER.fullmatch(token) is not None:
            return self.integer(position, what, token)
        match = _DECIMAL.fullmatch(token)
        if match is None or not (match[2] or match[3]):
            self.fault(position, what, token, "a number")
        exponent = (match[5] or b"").lstrip(b"0") or b"0"
        if len(exponent) > 3 or int(exponent) > _EXPONENT_MAX:
            self.fault(position, what, token, f"a number, exponents -{_EXPONENT_MAX}..{_EXPONENT_MAX}")
        fraction = match[3] or b""
        digits = match[2] + fraction
        point = len(match[2]) + (-int(exponent) if match[4] == b"-" else int(exponent))
        whole = digits[: max(point, 0)].lstrip(b"0")
        if whole:
            whole += b"0" * (point - len(digits))
        if len(whole) > 10:
            self.fault(position, what, token, _INT_ALLOWED, RangeViolation)
        value = int(whole or b"0")
        if 0 <= point < len(digits) and digits[point] >= 0x35:
            value += 1
        if match[1] == b"-":
            value = -value
        if not INT_MIN <= value <= INT_MAX:
            self.fault(position, what, token, _INT_ALLOWED, RangeViolation)
        self.note("text-decimal", position)
        return value

    def rate(self, position: int, token: bytes) -> Fraction:
        """The frame rate token, exact. Rules: FBA-50, FBA-37.

        Raises `InputFormat` (no plain decimal, more than 20 decimal places), `ForbiddenValue` (0),
        `RangeViolation`.
        """
        match = _DECIMAL.fullmatch(token)
        if match is None or match[5] is not None or not (match[2] or match[3]):
            self.fault(position, "frame rate", token, "a decimal number")
        whole = match[2].lstrip(b"0")
        places = (match[3] or b"").rstrip(b"0")
        if len(places) > _RATE_PLACES:
            self.fault(position, "frame rate", token, f"at most {_RATE_PLACES} decimal places")
        value = Fraction(INT_MAX + 1)
        if match[1] != b"-" and len(whole) <= 10:
            value = Fraction(int(whole + places or b"0"), 10 ** len(places))
        if value > INT_MAX:
            self.fault(position, "frame rate", token, f"above 0, at most {INT_MAX}", RangeViolation)
        if value == 0:
            self.fault(position, "frame rate", token, "above 0", ForbiddenValue, rule="FBA-37")
        return value


def printed_rate(rate: Fraction) -> str:
    """A frame rate as the header prints it: exact where 20 decimal places can, else the shortest within 1e-6.

    Rules: FBA-50. 25 -> `25`, 2997/100 -> `29.97`, 30000/1001 -> `29.97003`. Raises `EncodeError`.
    """
    exact = 10**_RATE_PLACES % rate.denominator == 0
    if not 0 < rate <= INT_MAX or (not exact and rate < Fraction(1, 10**6)):
        raise EncodeError(
            "FBA-50", "frame rate", value=str(rate), allowed=f"above 0, at most {INT_MAX}", path="frame_rate"
        )
    if rate.denominator == 1:
        return str(rate.numerator)
    places = 1
    while True:
        scaled = rate * 10**places
        nearest = (2 * scaled.numerator + scaled.denominator) // (2 * scaled.denominator)
        error = abs(Fraction(nearest, 10**places) - rate)
        if error == 0 or (not exact and nearest > 0 and error < Fraction(1, 10**6)):
            break
        places += 1
    whole, part = divmod(nearest, 10**places)
    return f"{whole}.{part:0{places}d}"
