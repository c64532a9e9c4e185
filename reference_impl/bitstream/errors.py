"""Error classes: one per cause, attributes instead of prose.

Rules: CNF-7, CNF-19, CNF-21, CNF-25.

A fault is *located*: bitstreams by a half-open bit span, text by line and column, JSON documents by a path. The
message is always made from the same parts: what was read, where, what is allowed, which rule.
"""

from __future__ import annotations

from typing import ClassVar, Final

MOST_SHOWN: Final = 400


def one_line(text: str) -> str:
    """The text with everything that is not printable escaped: what an input holds must neither break a line nor steer
    a terminal.

    Rules: CNF-7.
    """
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode("ascii") for char in text)


def shortened(text: str) -> str:
    """The text, or its beginning and its end: what an input holds may be as long as the input.

    Rules: CNF-7.
    """
    return text if len(text) <= MOST_SHOWN else f"{text[: MOST_SHOWN // 2]} ... {text[-MOST_SHOWN // 4 :]}"


def cause(error: Exception) -> str:
    """Why a document could not be read, in words for people: what Python says of it is for programmers.

    Rules: CNF-7. `error`: what decoding, parsing or taking a document apart has raised.
    """
    if isinstance(error, UnicodeDecodeError):
        return f"byte 0x{error.object[error.start]:02x} at {error.start} is no text"
    if isinstance(error, OSError):
        return error.strerror or str(error)
    if isinstance(error, KeyError):
        return f"{error.args[0]} is missing"
    if isinstance(error, TypeError | AttributeError | IndexError):
        return "a value is of another kind"
    if isinstance(error, RecursionError):
        return "nested too deeply"
    return str(error)


class SnhcError(Exception):
    """Base of all located faults; never raised itself.

    Rules: CNF-7, CNF-25.

    `rule`: rule id. `what`: element, field or token that was read. `value`: what it said (None where nothing could
    be read). `allowed`: what the rule allows, in words. `bits`: half-open span from bit 0 of the input. `path`:
    element path (`plane[0].fap.group[7]`) or JSON path. `line`, `column`: from 1, text inputs. `expected`: the
    expected length or value where a table does not fit together.
    """

    exit_code: ClassVar[int] = 4

    def __init__(
        self,
        rule: str,
        what: str,
        *,
        value: int | str | None = None,
        allowed: str = "",
        bits: tuple[int, int] | None = None,
        path: str = "",
        line: int | None = None,
        column: int | None = None,
        expected: int | str | None = None,
    ) -> None:
        super().__init__(rule, what)
        self.rule = rule
        self.what = what
        self.value = value
        self.allowed = allowed
        self.bits = bits
        self.path = path
        self.line = line
        self.column = column
        self.expected = expected

    @property
    def error_class(self) -> str:
        """The class name of CNF-7. Rules: CNF-7."""
        return type(self).__name__

    @property
    def message(self) -> str:
        """`bap_mask_type=2 at bits [131, 133) (plane[0].bap.group[7]): allowed 0, 1, 3 (FBA-40)`. Rules: CNF-7."""
        what = shortened(self.what)
        parts = [what if self.value is None else f"{what}={shortened(str(self.value))}"]
        if self.bits is not None:
            parts.append(f"at bits [{self.bits[0]}, {self.bits[1]})")
        if self.line is not None:
            parts.append(f"at line {self.line}" + ("" if self.column is None else f", column {self.column}"))
        if self.path:
            parts.append(f"({shortened(self.path)})")
        text = " ".join(parts)
        if self.allowed:
            text += f": allowed {self.allowed}"
        if self.expected is not None:
            text += f": expected {self.expected}"
        return one_line(f"{text} ({self.rule})")

    def __str__(self) -> str:
        return f"{self.error_class}: {self.message}"

    def as_json(self) -> dict[str, object]:
        """The object that `--json-errors` prints. Rules: CNF-25."""
        out: dict[str, object] = {"class": self.error_class, "rule": self.rule}
        if self.bits is not None:
            out["bits"] = list(self.bits)
        if self.line is not None:
            out["line"] = self.line
            out["column"] = self.column if self.column is not None else 1
        if self.path:
            out["path"] = self.path
        out["element"] = self.what
        out["value"] = self.value
        out["allowed"] = self.allowed
        if self.expected is not None:
            out["expected"] = self.expected
        out["message"] = self.message
        return out


class Truncated(SnhcError):
    """The data ends inside an element. Rules: CNF-7, CNF-21."""


class MarkerBit(SnhcError):
    """A marker or guard bit is 0. Rules: CNF-7."""


class ForbiddenValue(SnhcError):
    """A value that the text forbids. Rules: CNF-7."""


class ReservedValue(SnhcError):
    """An unassigned code or VLC word. Rules: CNF-7."""


class RangeViolation(SnhcError):
    """A count, size, position, select or run out of its range. Rules: CNF-7."""


class InconsistentSemantics(SnhcError):
    """Order of planes, polygons, tables that do not fit together. Rules: CNF-7."""


class TrailingData(SnhcError):
    """Bytes after the end, refused under `--strict` only. Rules: CNF-7."""


class ResourceLimit(SnhcError):
    """A limit of CNF-22 is passed. Rules: CNF-7, CNF-22."""


class Unsupported(SnhcError):
    """Defined by the standard, not built here: our fault, not the stream's. Rules: CNF-7."""


class InputFormat(SnhcError):
    """Not the kind of file it should be. Rules: CNF-7, CNF-19."""

    exit_code: ClassVar[int] = 3


class EncodeError(SnhcError):
    """A value that the syntax cannot hold was given to a writer (usage, not a stream's fault). Rules: CNF-19."""

    exit_code: ClassVar[int] = 3


ERROR_CLASSES: Final[dict[str, type[SnhcError]]] = {
    cls.__name__: cls
    for cls in (
        Truncated, MarkerBit, ForbiddenValue, ReservedValue, RangeViolation,
        InconsistentSemantics, TrailingData, ResourceLimit, Unsupported, InputFormat,
    )
}  # fmt: skip
