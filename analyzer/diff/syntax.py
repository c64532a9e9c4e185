"""What differs in the syntax of two streams: element by element, aligned by plane and path.

Rules: CNF-17, CNF-21.

Planes pair by their time (or number), what stands around them in its order. Inside a pair an element is found again by
its path, its name and which of several it is; symbols of an arithmetic segment by their label (`FAP 48`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from snhc.analyzer.parts import Part, Parts, path_names, raw_bits
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, trace_stream

from .align import NUMBER, TIME, pairs
from .values import SHOWN

Span = tuple[int, int]
_Key = tuple[str, str, int]


@dataclass(frozen=True, slots=True)
class SyntaxDifference:
    """One element that differs.

    Rules: CNF-17, CNF-21. `plane_a`, `plane_b`: numbers, None outside planes or where a side has none. `path` without
    the plane. `a`, `b`: values; None where that side has no such element. `bits_a`, `bits_b` likewise.
    """

    plane_a: int | None
    plane_b: int | None
    path: str
    element: str
    rule: str
    a: int | str | None
    b: int | str | None
    bits_a: Span | None
    bits_b: Span | None

    def as_json(self) -> dict[str, Any]:
        """The difference as an object of the report."""
        return {
            "plane": [self.plane_a, self.plane_b], "path": self.path, "element": self.element, "rule": self.rule,
            "a": self.a, "b": self.b,
            "bits_a": None if self.bits_a is None else list(self.bits_a),
            "bits_b": None if self.bits_b is None else list(self.bits_b),
        }  # fmt: skip

    def __str__(self) -> str:
        if self.plane_a is None and self.plane_b is None:
            where = "outside planes"
        elif self.plane_a == self.plane_b or self.plane_b is None:
            where = f"plane {self.plane_a}"
        elif self.plane_a is None:
            where = f"plane {self.plane_b} of B"
        else:
            where = f"plane {self.plane_a} of A, {self.plane_b} of B"
        name = f"{self.path}.{self.element}" if self.path else self.element
        return f"{where}: {name}: {_side('A', self.a, self.bits_a)}, {_side('B', self.b, self.bits_b)} ({self.rule})"


def _side(name: str, value: int | str | None, bits: Span | None) -> str:
    if bits is None:
        return f"{name} has none"
    return f"{name} {value} at bits [{bits[0]}, {bits[1]})"


@dataclass(slots=True)
class Count:
    """How often an element was compared, differed, and stood on one side only. Rules: CNF-17."""

    rule: str
    compared: int = 0
    different: int = 0
    only_a: int = 0
    only_b: int = 0

    @property
    def at_odds(self) -> int:
        """How often the two sides are not alike."""
        return self.different + self.only_a + self.only_b


@dataclass(slots=True)
class SyntaxDiff:
    """What differs in the syntax.

    Rules: CNF-17. `planes`: pairs, then planes of A and of B alone. `bits_a`, `bits_b`: of everything that was read.
    `elements`: name -> counts. `error_a`, `error_b`: the fault that ended a stream.
    """

    pairs: int = 0
    planes_a: int = 0
    planes_b: int = 0
    bits_a: int = 0
    bits_b: int = 0
    differences: int = 0
    elements: dict[str, Count] = field(default_factory=dict)
    shown: list[SyntaxDifference] = field(default_factory=list)
    error_a: SnhcError | None = None
    error_b: SnhcError | None = None

    @property
    def equal(self) -> bool:
        """Whether no element differs and both end alike."""
        return not self.differences and (self.error_a is None) == (self.error_b is None)

    @property
    def first(self) -> SyntaxDifference | None:
        """The first difference in the order of the streams."""
        return self.shown[0] if self.shown else None

    def as_json(self) -> dict[str, Any]:
        """The `syntax` of the report."""
        return {
            "planes": {"both": self.pairs, "a": self.planes_a, "b": self.planes_b},
            "bits": {"a": self.bits_a, "b": self.bits_b},
            "different": self.differences,
            "elements": {
                name: {
                    "rule": count.rule, "compared": count.compared, "different": count.different,
                    "only_a": count.only_a, "only_b": count.only_b,
                }
                for name, count in sorted(self.elements.items())
                if count.at_odds
            },
            "first": None if self.first is None else self.first.as_json(),
            "differences": [one.as_json() for one in self.shown],
            "error_a": None if self.error_a is None else self.error_a.as_json(),
            "error_b": None if self.error_b is None else self.error_b.as_json(),
        }  # fmt: skip


def diff_syntax(
    a: Source, b: Source, options: Options = DEFAULT_OPTIONS, *, align: str = TIME, shown: int = SHOWN
) -> SyntaxDiff:
    """Compare two streams element by element.

    Rules: CNF-17, CNF-21. `align`: pair planes by `time` or by `number`. A fault ends its stream and stands in the
    result. Memory does not grow with the streams. Raises InputFormat where one is no stream at all.
    """
    found = SyntaxDiff()
    left, right = (Parts(trace_stream(source, options, symbols=False)) for source in (a, b))
    for x, y in pairs(_places(left), _places(right), _by_number if align == NUMBER else _by_time):
        if x is not None:
            found.bits_a = max(found.bits_a, x.end)
            found.planes_a += x.part.plane is not None
        if y is not None:
            found.bits_b = max(found.bits_b, y.end)
            found.planes_b += y.part.plane is not None
        if x is not None and y is not None and x.part.plane is not None:
            found.pairs += 1
        _compare(found, x, y, a, b, shown)
    found.error_a, found.error_b = left.error, right.error
    return found


@dataclass(frozen=True, slots=True)
class _Place:
    part: Part
    key: tuple[int, int, Fraction, int]
    """Object, 0 headers before its planes, 1 planes, 2 what closes it; time and number of the plane."""

    @property
    def end(self) -> int:
        trace = self.part.trace
        return trace.end[len(trace) - 1] if len(trace) else 0


def _by_time(place: _Place) -> tuple[int, int, Fraction]:
    return place.key[:3]


def _by_number(place: _Place) -> tuple[int, int, int]:
    return place.key[0], place.key[1], place.key[3]


def _places(parts: Parts) -> Iterator[_Place]:
    objects = 0
    inside = 0
    latest = Fraction(0)
    for part in parts:
        if part.plane is not None:
            inside = 1
            time = Fraction(*part.plane.frames[0].time) if part.plane.frames else latest
            # Time codes may go back; order must not.
            latest = max(latest, time)
            yield _Place(part, (objects, 1, latest, part.plane_number))
        elif inside:
            inside = 0
            yield _Place(part, (objects, 2, Fraction(0), 0))
            objects += 1
            latest = Fraction(0)
        else:
            yield _Place(part, (objects, 0, Fraction(0), 0))


def _compare(found: SyntaxDiff, x: _Place | None, y: _Place | None, a: Source, b: Source, shown: int) -> None:
    ours = {} if x is None else _elements(x.part, a)
    theirs = {} if y is None else _elements(y.part, b)
    plane_a = x.part.plane_number if x is not None and x.part.plane is not None else None
    plane_b = y.part.plane_number if y is not None and y.part.plane is not None else None
    for key, (rule, value, bits) in ours.items():
        count = found.elements.setdefault(key[1], Count(rule))
        other = theirs.get(key)
        if other is None:
            count.only_a += 1
            _add(found, shown, SyntaxDifference(plane_a, plane_b, key[0], key[1], rule, value, None, bits, None))
            continue
        count.compared += 1
        if value != other[1]:
            count.different += 1
            _add(
                found, shown, SyntaxDifference(plane_a, plane_b, key[0], key[1], rule, value, other[1], bits, other[2])
            )
    for key, (rule, value, bits) in theirs.items():
        if key not in ours:
            found.elements.setdefault(key[1], Count(rule)).only_b += 1
            _add(found, shown, SyntaxDifference(plane_a, plane_b, key[0], key[1], rule, None, value, None, bits))


def _add(found: SyntaxDiff, most: int, difference: SyntaxDifference) -> None:
    found.differences += 1
    if len(found.shown) < most:
        found.shown.append(difference)


def _elements(part: Part, source: Source) -> dict[_Key, tuple[str, int | str, Span]]:
    """Path without the plane, name, which of several -> rule, value, bits."""
    trace = part.trace
    paths: dict[int, str] = {}
    out: dict[_Key, tuple[str, int | str, Span]] = {}
    seen: dict[tuple[str, str], int] = {}

    def put(path: str, name: str, rule: str, value: int | str, span: Span) -> None:
        which = seen.get((path, name), 0)
        seen[path, name] = which + 1
        out[path, name, which] = (rule, value, span)

    for row in range(len(trace)):
        at = trace.path[row]
        path = paths.get(at)
        if path is None:
            names = path_names(trace, at)
            path = paths[at] = ".".join(names[1:] if names and names[0].startswith("plane[") else names)
        element = trace.el(row)
        span = (trace.start[row], trace.end[row])
        segment = trace.segments.get(row)
        if segment is None:
            blob = trace.blobs.get(row)
            put(path, element.name, element.rule, trace.value[row] if blob is None else _hex(blob), span)
            continue
        steps, labels = segment
        for label, level in zip(labels, steps.levels, strict=True):
            put(f"{path}.{element.name}" if path else element.name, label, element.rule, level, span)
        # Levels alike, bits not: an end of the segment that no encoder writes.
        if steps.tail:
            put(path, element.name, element.rule, raw_bits(source, span[1] - 2, span[1]), (span[1] - 2, span[1]))
    return out


def _hex(blob: bytes) -> str:
    return blob[:32].hex() + (f"... ({len(blob)} bytes)" if len(blob) > 32 else "")
