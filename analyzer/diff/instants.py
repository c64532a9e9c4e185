"""Decoded instants of any input: streams, `.fap` text, decoded NDJSON; one at a time.

Rules: CNF-1, CNF-2 (recognised by content), FBA-54.

A channel is a curve over time: a FAP, a field of FAP 1 or 2, all x coordinates of a mesh. The places of a channel are
its nodes or vertices; a FAP has one place.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Final

from snhc.analyzer.check import kind_of_text
from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.documents.json_text import (
    MAX_LINE_BYTES,
    as_array,
    as_float,
    as_int,
    as_object,
    as_text,
    entries,
    parse_json,
)
from snhc.reference_impl.face.decoded import EXPRESSION_KEYS, VISEME_KEYS
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.interpolation.frames_json import frame_from_json
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, decode_frames

LONGEST_LINE: Final = 64 * MAX_LINE_BYTES
FACE_KINDS: Final = ("fba", "faces")
KINDS: Final = (*FACE_KINDS, "mesh", "vertices")
_HEAD: Final = 4096


@dataclass(frozen=True, slots=True)
class Instant:
    """One decoded line. Rules: CNF-1. `values`: channel -> one number per place, None where there is none.

    `words`: what is compared but is no number: states, triangles.
    """

    index: int
    time: Fraction
    values: Mapping[str, Sequence[float | None]]
    words: Mapping[str, object] = field(default_factory=dict)


class Instants:
    """The instants of an input, one by one; `kind` is known once the first has been asked for.

    Rules: CNF-1, CNF-2. A fault of a stream ends it and then stands in `error`; faults of text, and data that is no
    stream at all, are raised.
    """

    def __init__(self, source: Source, options: Options = DEFAULT_OPTIONS) -> None:
        self.form = form_of(source)
        self.kind = "fba"
        self.error: SnhcError | None = None
        self._source = source
        self._options = options

    def __iter__(self) -> Iterator[Instant]:
        if self.form == "fap":
            return self._fap()
        if self.form == "ndjson":
            return self._ndjson()
        return self._stream()

    def _stream(self) -> Iterator[Instant]:
        try:
            for frame in decode_frames(self._source, self._options):
                yield self._instant(frame)
        except InputFormat:
            raise
        except SnhcError as error:
            self.error = error

    def _instant(self, frame: FaceFrame | MeshFrame) -> Instant:
        time = Fraction(*frame.time)
        if isinstance(frame, MeshFrame):
            self.kind = "mesh"
            return Instant(frame.index, time, _nodes(frame.nodes), _topology(frame.triangles, frame.order))
        words: dict[str, object] = {"state": frame.state}
        if frame.baps is not None:
            words["baps"] = {str(number): value for number, value in frame.baps.items()}
        return face_instant(frame.index, time, frame.faps, frame.viseme, frame.expression, words)

    def _fap(self) -> Iterator[Instant]:
        from snhc.reference_impl.face.fap_text import FapReader

        reader = FapReader(_lines(self._source), strict=self._options.strict, limits=self._options.limits)
        first: int | None = None
        for index, frame in enumerate(reader):
            first = frame.number if first is None else first
            state = "".join("T" if bit else "U" for bit in frame.mask)
            time = Fraction(frame.number - first) / reader.frame_rate
            yield face_instant(index, time, frame.values, frame.viseme, frame.expression, {"state": state})

    def _ndjson(self) -> Iterator[Instant]:
        kind = ""
        for number, line in enumerate(_lines(self._source), 1):
            if not line.strip():
                continue
            root = parse_json(line, rule="CNF-1", what="line", limit=self._options.limits.json_bytes, line=number)
            if not kind:
                self.kind = kind = _kind(root)
                continue
            yield _decoded(root, kind)


def form_of(source: Source) -> str:
    """`ndjson`, `fap` or `stream`, by the first bytes. Rules: CNF-2."""
    form = kind_of_text(source.read_at(0, _HEAD))
    return {"json": "ndjson", "fap": "fap"}.get(form, "stream")


def face_instant(
    index: int,
    time: Fraction,
    faps: Sequence[int | None],
    viseme: Sequence[int] | None,
    expression: Sequence[int] | None,
    words: Mapping[str, object],
) -> Instant:
    """One line of a face. Rules: CNF-1."""
    values: dict[str, Sequence[float | None]] = {f"FAP {n}": (v,) for n, v in enumerate(faps, 1) if n > 2}
    for prefix, keys, given in (("viseme", VISEME_KEYS, viseme), ("expression", EXPRESSION_KEYS, expression)):
        for place, key in enumerate(keys):
            known = given is not None and place < len(given)
            values[f"{prefix}.{key}"] = (given[place] if known and given is not None else None,)
    return Instant(index, time, values, words)


def _nodes(nodes: Sequence[tuple[int, int]]) -> dict[str, Sequence[float | None]]:
    return {"x": [x for x, _ in nodes], "y": [y for _, y in nodes]}


def _topology(triangles: Sequence[Sequence[int]] | None, order: Sequence[int] | None) -> dict[str, object]:
    out: dict[str, object] = {}
    if triangles is not None:
        # As sets: where a triangle begins, and which comes first, is no difference.
        out["triangles"] = sorted(_turned(triangle) for triangle in triangles)
    if order is not None:
        out["order"] = list(order)
    return out


def _turned(triangle: Sequence[int]) -> tuple[int, ...]:
    first = min(range(len(triangle)), key=lambda i: triangle[i]) if triangle else 0
    return (*triangle[first:], *triangle[:first])


def _lines(source: Source) -> Iterator[bytes]:
    offset = held = 0
    # Of the line that is not at its end yet; joined once, however many pieces it comes in.
    pieces: list[bytes] = []
    while chunk := source.read_at(offset, 1 << 16):
        offset += len(chunk)
        first, *lines = chunk.split(b"\n")
        pieces.append(first)
        held += len(first)
        if held > LONGEST_LINE:
            raise InputFormat("CNF-22", "line", value=f"{held} bytes", allowed=f"at most {LONGEST_LINE}")
        for line in lines:
            yield b"".join(pieces) + b"\n"
            pieces = [line]
            held = len(line)
    if held:
        yield b"".join(pieces)


def _kind(root: object) -> str:
    header = as_object(root, "", "CNF-1")
    if header.get("format") != "snhc-decoded":
        raise InputFormat(
            "CNF-1", "format", value=json.dumps(header.get("format"))[:40], allowed="snhc-decoded", path="format"
        )
    kind = as_text(header.get("kind"), "kind", "CNF-1")
    if kind not in KINDS:
        raise InputFormat("CNF-2", "kind", value=kind[:40], allowed=", ".join(KINDS), path="kind")
    return kind


def _decoded(root: object, kind: str) -> Instant:
    if kind in FACE_KINDS:
        frame = frame_from_json(root)
        words: dict[str, object] = {"state": frame.state}
        if isinstance(frame.raw.get("baps"), dict):
            words["baps"] = frame.raw["baps"]
        raw: Any = frame.raw
        viseme = None if frame.viseme is None else (*frame.viseme, *_flags(raw["viseme"], VISEME_KEYS[3:]))
        expression = (
            None if frame.expression is None else (*frame.expression, *_flags(raw["expression"], EXPRESSION_KEYS[4:]))
        )
        return face_instant(frame.index, Fraction(frame.time), frame.faps, viseme, expression, words)
    line = as_object(root, "", "CNF-1")
    index = as_int(line.get("index"), "index", "CNF-1", 0, (1 << 63) - 1)
    time = _time(line.get("time"))
    if kind == "mesh":
        nodes = [_point(point, path) for path, point in entries(line.get("nodes"), "nodes", "CNF-1")]
        triangles = _index_lists(line.get("triangles"), "triangles")
        order = line.get("order")
        numbers = None if order is None else [as_int(n, path, "CNF-1") for path, n in entries(order, "order", "CNF-1")]
        return Instant(index, time, _nodes(nodes), _topology(triangles, numbers))
    values: dict[str, Sequence[float | None]] = {}
    for name, points in as_object(line.get("meshes"), "meshes", "CNF-2").items():
        path = f"meshes.{name}"
        rows = [
            [as_float(v, at, "CNF-2") for at, v in entries(p, q, "CNF-2")] for q, p in entries(points, path, "CNF-2")
        ]
        for axis, letter in enumerate("xyz"):
            values[f"{name}.{letter}"] = [row[axis] if axis < len(row) else None for row in rows]
    return Instant(index, time, values)


def _flags(raw: object, keys: Sequence[str]) -> tuple[int, ...]:
    entry = as_object(raw, "", "CNF-1")
    return tuple(as_int(entry[key], key, "CNF-1") for key in keys if key in entry)


def _time(value: object) -> Fraction:
    text = as_text(value, "time", "CNF-1")
    try:
        return Fraction(text)
    except (ValueError, ZeroDivisionError) as error:
        raise InputFormat("CNF-1", "time", value=text[:40], allowed='"p/q"', path="time") from error


def _point(value: object, path: str) -> tuple[int, int]:
    pair = as_array(value, path, "CNF-1")
    if len(pair) != 2:
        raise InputFormat("CNF-1", "node", value=len(pair), allowed="two numbers", path=path)
    return as_int(pair[0], f"{path}[0]", "CNF-1"), as_int(pair[1], f"{path}[1]", "CNF-1")


def _index_lists(value: object, path: str) -> list[list[int]] | None:
    if value is None:
        return None
    return [
        [as_int(n, at, "CNF-1") for at, n in entries(triangle, q, "CNF-1")]
        for q, triangle in entries(value, path, "CNF-1")
    ]
