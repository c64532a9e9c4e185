"""JSON documents: size limits, located errors, typed access by path.

Rules: CNF-22 (JSON document 256 MiB, text line 1 MiB), CNF-25 (a fault in a JSON table has a path).
Not implemented: JSON Schema (a document is checked by the code that reads it, so that every fault has its own
rule).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Final, NoReturn, cast

from snhc.reference_impl.bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
)

MAX_JSON_BYTES: Final = 256 << 20
MAX_LINE_BYTES: Final = 1 << 20

# What Python's parser says, in words of what would be right.
_EXPECTED: Final = {
    "Expecting value": "a value",
    "Expecting ',' delimiter": "a comma, or the end of the list",
    "Expecting ':' delimiter": "a colon",
    "Expecting property name enclosed in double quotes": "a name in double quotes",
    "Illegal trailing comma before end of object": "no comma before the end",
    "Illegal trailing comma before end of array": "no comma before the end",
    "Extra data": "nothing behind its end",
    "Unterminated string starting at": "a string that ends",
    "Invalid control character at": "control characters as escapes",
    "Invalid \\escape": "an escape that JSON has",
    "Invalid \\uXXXX escape": "four hexadecimal digits",
}
JsonObject = Mapping[str, object]


class _NotJson(Exception):
    """A token that Python's parser takes although JSON has it not."""


def _constant(token: str) -> NoReturn:
    raise _NotJson(token)


def parse_json(data: bytes | str, *, rule: str, what: str, limit: int = MAX_JSON_BYTES, line: int = 1) -> object:
    """Parse one JSON text.

    Rules: CNF-22, CNF-25.

    `data`: UTF-8 bytes (a byte order mark is dropped) or text. `what`: the name used in errors. `limit`:
    bytes, or characters for text. `line`: number of the first line of `data` in its file, from 1. Raises
    `ResourceLimit` past the limit, `InputFormat` (line, column) where the text is not JSON; NaN and Infinity
    are not JSON.
    """
    if len(data) > limit:
        raise ResourceLimit("CNF-22", what, value=len(data), allowed=f"at most {limit} bytes", line=line)
    try:
        text = data.decode("utf-8-sig") if isinstance(data, bytes) else data.removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        at = data[: error.start] if isinstance(data, bytes) else b""
        raise InputFormat(
            rule, what, value=f"byte 0x{error.object[error.start]:02X}", allowed="UTF-8",
            line=line + at.count(b"\n"), column=len(at) - at.rfind(b"\n"),
        ) from None  # fmt: skip
    try:
        return cast(object, json.loads(text, parse_constant=_constant))
    except json.JSONDecodeError as error:
        raise InputFormat(
            rule,
            what,
            value=json.dumps(text[error.pos], ensure_ascii=False) if error.pos < len(text) else "its end",
            allowed=f"JSON: {_EXPECTED.get(error.msg, error.msg)}",
            line=line + error.lineno - 1,
            column=error.colno,
        ) from None
    except _NotJson as error:
        at_text = text[: max(text.find(str(error)), 0)]
        raise InputFormat(
            rule, what, value=str(error), allowed="a finite number",
            line=line + at_text.count("\n"), column=len(at_text) - at_text.rfind("\n"),
        ) from None  # fmt: skip
    except RecursionError:
        raise InputFormat(rule, what, value="nested too deeply", allowed="a JSON text", line=line, column=1) from None
    except ValueError:
        # Python refuses integers of more than some thousand digits.
        raise InputFormat(
            rule, what, value="integer with too many digits", allowed="a JSON text", line=line, column=1
        ) from None


def _kind(value: object) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return str(value) if abs(value) < 1e300 else "a huge number"
    if isinstance(value, str):
        return json.dumps(value[:40])
    return "an object" if isinstance(value, Mapping) else "an array"


def _wrong(value: object, path: str, rule: str, allowed: str) -> InputFormat:
    name = path.rsplit(".", 1)[-1] or "document"
    return InputFormat(rule, name, value=_kind(value), allowed=allowed, path=path)


def as_object(value: object, path: str, rule: str) -> JsonObject:
    """The value as an object, or `InputFormat` at `path`. Rules: CNF-25."""
    if not isinstance(value, Mapping):
        raise _wrong(value, path, rule, "an object")
    return value


def as_array(value: object, path: str, rule: str) -> Sequence[object]:
    """The value as an array, or `InputFormat` at `path`. Rules: CNF-25."""
    if not isinstance(value, list):
        raise _wrong(value, path, rule, "an array")
    return value


def as_text(value: object, path: str, rule: str) -> str:
    """The value as a string, or `InputFormat` at `path`. Rules: CNF-25."""
    if not isinstance(value, str):
        raise _wrong(value, path, rule, "a string")
    return value


def as_int(value: object, path: str, rule: str, lo: int | None = None, hi: int | None = None) -> int:
    """The value as an integer in lo..hi.

    Rules: CNF-7, CNF-25. Raises `InputFormat` where it is no integer, `RangeViolation` where it is out of
    range.
    """
    if not isinstance(value, int) or isinstance(value, bool):
        raise _wrong(value, path, rule, "an integer")
    if (lo is not None and value < lo) or (hi is not None and value > hi):
        name = path.rsplit(".", 1)[-1]
        raise RangeViolation(
            rule,
            name,
            value=value if abs(value) < 1 << 63 else "a huge number",
            allowed=f"{lo}..{hi}",
            path=path,
        )
    return value


def as_float(value: object, path: str, rule: str) -> float:
    """The value as a finite float64, or `InputFormat` at `path`. Rules: CNF-25."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise _wrong(value, path, rule, "a number")
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not isfinite(number):
        raise _wrong(value, path, rule, "a finite number")
    return number


def int_list(value: object, path: str, rule: str, lo: int | None = None, hi: int | None = None) -> tuple[int, ...]:
    """The value as integers in lo..hi. Rules: CNF-7, CNF-25. Raises as `as_int`, at the entry."""
    return tuple(as_int(v, f"{path}[{i}]", rule, lo, hi) for i, v in enumerate(as_array(value, path, rule)))


def float_list(value: object, path: str, rule: str, length: int | None = None) -> tuple[float, ...]:
    """The value as finite floats.

    Rules: CNF-7, CNF-25. `length`: the number of entries wanted; another one is `InconsistentSemantics` with
    the expected length.
    """
    array = as_array(value, path, rule)
    if length is not None and len(array) != length:
        raise InconsistentSemantics(
            rule,
            path.rsplit(".", 1)[-1],
            value=len(array),
            allowed=f"{length} numbers",
            path=path,
            expected=length,
        )
    return tuple(as_float(v, f"{path}[{i}]", rule) for i, v in enumerate(array))


def entries(value: object, path: str, rule: str) -> Iterator[tuple[str, object]]:
    """The entries of an array with their paths. Rules: CNF-25."""
    for i, entry in enumerate(as_array(value, path, rule)):
        yield f"{path}[{i}]", entry
