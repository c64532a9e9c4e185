"""CNF-1 frames in, CNF-2 lines out.

Rules: CNF-1 (kinds `fba` and `faces`), CNF-2 (`faces`, `vertices`), CNF-22 (text line 1 MiB), CNF-25.
Not implemented: kind `mesh`, `scene`, `epf`; body animation parameters are passed through unread.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Final, Protocol

from snhc.reference_impl.bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from snhc.reference_impl.documents.json_text import (
    MAX_LINE_BYTES,
    as_array,
    as_float,
    as_int,
    as_object,
    as_text,
    parse_json,
)

FORMAT: Final = "snhc-decoded"
FAP_COUNT: Final = 68
AVAILABLE_STATES: Final = "TRF"
STATES: Final = "TRIUFS"
_TIME: Final = re.compile(r"-?[0-9]{1,40}(/0*[1-9][0-9]{0,40})?")
_VISEME: Final = ("select1", "select2", "blend")
_EXPRESSION: Final = ("select1", "intensity1", "select2", "intensity2")
_INT32: Final = (1 << 31) - 1


class LineStream(Protocol):
    """A stream that gives lines of bytes or text, at most `limit` long. Rules: CNF-22."""

    def readline(self, limit: int = ..., /) -> bytes | str:
        """The next line with its end; empty at the end of the stream. Rules: CNF-22."""


@dataclass(frozen=True, slots=True)
class FrameLine:
    """One frame of a face as a line of any decoder gives it; keys that are not read pass through.

    Rules: CNF-1. `time`: seconds, "p/q" or an integer as text. `faps`: 68 entries, FAP i + 1 in FAP units,
    None while unset; entries 0 and 1 are None. `viseme`: (select1, select2, blend). `expression`: (select1,
    intensity1, select2, intensity2). `state`: 68 letters. `raw`: the object that was read, for pass-through.
    """

    index: int
    time: str
    intra: bool
    faps: tuple[int | None, ...]
    viseme: tuple[int, int, int] | None
    expression: tuple[int, int, int, int] | None
    state: str
    raw: Mapping[str, object]

    def with_faps(self, faps: tuple[int | None, ...], state: str) -> FrameLine:
        """The frame with other values and states. Rules: CNF-2."""
        return replace(self, faps=faps, state=state)


def _high_level(value: object, path: str, names: tuple[str, ...]) -> tuple[int, ...] | None:
    if value is None:
        return None
    entry = as_object(value, path, "CNF-1")
    return tuple(as_int(entry.get(name), f"{path}.{name}", "CNF-1", -_INT32 - 1, _INT32) for name in names)


def _faps(value: object) -> tuple[int | None, ...]:
    array = as_array(value, "faps", "CNF-1")
    if len(array) != FAP_COUNT:
        raise InconsistentSemantics(
            "CNF-1", "faps", value=len(array), allowed="68 values", path="faps", expected=FAP_COUNT
        )
    out: list[int | None] = []
    for i, entry in enumerate(array):
        if entry is not None:
            as_int(entry, f"faps[{i}]", "CNF-1")
            as_float(entry, f"faps[{i}]", "CNF-1")
            if i < 2:
                raise RangeViolation("CNF-1", "faps", value=str(entry)[:40], allowed="null", path=f"faps[{i}]")
        out.append(entry)  # type: ignore[arg-type]
    return tuple(out)


def frame_from_json(value: object) -> FrameLine:
    """One frame from a parsed line.

    Rules: CNF-1, CNF-25. `intra`, `viseme` and `expression` may be absent. Raises `InputFormat` (types),
    `InconsistentSemantics` (68 entries, a state T, R, F or S without a value), `RangeViolation` (entries 0
    and 1), each with a path.
    """
    root = as_object(value, "", "CNF-1")
    index = as_int(root.get("index"), "index", "CNF-1", 0, (1 << 63) - 1)
    when = root.get("time")
    time = str(when) if isinstance(when, int) and not isinstance(when, bool) else as_text(when, "time", "CNF-1")
    if not _TIME.fullmatch(time):
        raise InputFormat("CNF-1", "time", value=time[:40], allowed='an integer or "p/q"', path="time")
    intra = root.get("intra", False)
    if not isinstance(intra, bool):
        raise InputFormat("CNF-1", "intra", value=str(intra)[:40], allowed="true, false", path="intra")
    faps = _faps(root.get("faps"))
    state = as_text(root.get("state"), "state", "CNF-1")
    if len(state) != FAP_COUNT:
        raise InconsistentSemantics(
            "CNF-1", "state", value=len(state), allowed="68 letters", path="state", expected=FAP_COUNT
        )
    viseme = _high_level(root.get("viseme"), "viseme", _VISEME)
    expression = _high_level(root.get("expression"), "expression", _EXPRESSION)
    for i, letter in enumerate(state):
        if letter not in STATES:
            raise InputFormat("CNF-1", "state", value=letter, allowed=", ".join(STATES), path=f"state[{i}]")
        if letter not in "UI":
            held = viseme if i == 0 else expression if i == 1 else faps[i]
            if held is None:
                name = ("viseme", "expression")[i] if i < 2 else f"faps[{i}]"
                raise InconsistentSemantics(
                    "CNF-1", "state", value=letter, allowed=f"U or I, as {name} is null", path=f"state[{i}]"
                )
    return FrameLine(
        index,
        time,
        intra,
        faps,
        None if viseme is None else (viseme[0], viseme[1], viseme[2]),
        None if expression is None else (expression[0], expression[1], expression[2], expression[3]),
        state,
        root,
    )


def _lines(stream: LineStream, limit: int) -> Iterator[tuple[int, bytes | str]]:
    number = 0
    while line := stream.readline(limit + 2):
        number += 1
        body = line.rstrip(b"\r\n") if isinstance(line, bytes) else line.rstrip("\r\n")
        if len(body) > limit:
            raise ResourceLimit(
                "CNF-22", "line", value="too long", allowed=f"at most {limit} bytes", line=number, column=1
            )
        if body.strip():
            yield number, body


def read_header(value: object, kinds: Sequence[str]) -> str:
    """Check the header object of CNF-1; returns its kind.

    Rules: CNF-1. Raises `InputFormat` with a path.
    """
    root = as_object(value, "", "CNF-1")
    for name, allowed in (("format", (FORMAT,)), ("version", (1,)), ("kind", tuple(kinds))):
        if root.get(name) not in allowed or isinstance(root.get(name), bool):
            raise InputFormat(
                "CNF-1", name, value=str(root.get(name))[:40], allowed=", ".join(map(str, allowed)), path=name
            )
    return str(root["kind"])


def read_frames(stream: LineStream, *, limit: int = MAX_LINE_BYTES) -> Iterator[FrameLine]:
    """The frames of an NDJSON stream of kind `fba` or `faces`, one at a time.

    Rules: CNF-1, CNF-22, CNF-25. `stream`: opened in binary or text mode; blank lines are skipped. `limit`:
    longest line in bytes. Every error carries the line (and the path inside it); a missing header is
    `InputFormat` at line 1.
    """
    kind = ""
    for number, line in _lines(stream, limit):
        try:
            value = parse_json(line, rule="CNF-1", what="line", limit=limit, line=number)
            if kind:
                yield frame_from_json(value)
            else:
                kind = read_header(value, ("fba", "faces"))
        except SnhcError as error:
            error.line = number
            error.column = error.column or 1
            raise
    if not kind:
        raise InputFormat("CNF-1", "header", value="no line", allowed="the header line", line=1, column=1)


def _dump(value: Mapping[str, object]) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def faces_line(frame: FrameLine) -> str:
    """One line of kind `faces`: values and states after FIT, the other keys of the frame passed through.

    Rules: CNF-1, CNF-2.
    """
    return _dump({**frame.raw, "faps": list(frame.faps), "state": frame.state})


class _Rows(Protocol):
    def tolist(self) -> list[list[float]]: ...


def vertices_line(frame: FrameLine, meshes: Mapping[str, _Rows]) -> str:
    """One line of kind `vertices`: floats are shortest round-trip decimals.

    Rules: CNF-1, CNF-2. `meshes`: {name: float64 (V, 3)}. Raises `RangeViolation` for a number that is not
    finite.
    """
    rows = {name: points.tolist() for name, points in meshes.items()}
    for name, points in rows.items():
        for i, point in enumerate(points):
            if not all(map(isfinite, point)):
                raise RangeViolation(
                    "CNF-2",
                    "vertices",
                    value="not finite",
                    allowed="finite floats",
                    path=f"meshes.{name}[{i}]",
                )
    return _dump({"index": frame.index, "time": frame.raw.get("time", frame.time), "meshes": rows})
