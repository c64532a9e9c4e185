"""The tracer: a reader that writes down every element, and can decode segments with the literal coder.

Rules: CNF-17, CNF-21, FBA-21..27. Law: the spans of a trace partition the bits that were read.

Rows are columns of machine numbers, not objects; names and paths are interned. A consumer takes the rows after each
plane, so that memory does not grow with the stream.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from typing import Final

from mypy_extensions import mypyc_attr

from ..bitstream.cursor import BitCursor, OutOfBits
from ..bitstream.findings import Finding
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..entropy.kernel import GUARD_AFTER
from ..entropy.literal import SegmentTrace, decode_literally
from ..entropy.model import Model
from ..entropy.prefix import PrefixTable
from ..entropy.profile import EntropyProfile
from ..entropy.shares import decode_with_shares
from .element import DEFAULT_READINGS, ELEMENTS, STEPS, Element, Readings, Step
from .reader import Reader

ROOT: Final = -1
_ZEROS: Final = "0" * GUARD_AFTER


class Trace:
    """Rows of a trace.

    Rules: CNF-17, CNF-21.

    Columns, one entry per row: `element` (index into ELEMENTS), `start`, `end` (bits), `value` (as the element means
    it: signed where it is), `path` (index into `paths`, -1: the root). `paths`: (parent, step, index) triples.
    `segments`: row -> (symbol steps, labels) of an arithmetic segment; `blobs`: row -> bytes of a byte element.
    """

    __slots__ = ("blobs", "element", "end", "path", "paths", "segments", "start", "value")

    def __init__(self) -> None:
        self.element = array("H")
        self.start = array("q")
        self.end = array("q")
        self.value = array("q")
        self.path = array("i")
        self.paths: list[tuple[int, int, int]] = []
        self.segments: dict[int, tuple[SegmentTrace, list[str]]] = {}
        self.blobs: dict[int, bytes] = {}

    def __len__(self) -> int:
        return len(self.element)

    def el(self, row: int) -> Element:
        """The element of a row. Rules: CNF-21."""
        return ELEMENTS[self.element[row]]

    def steps(self, path: int) -> list[tuple[str, int]]:
        """A path as (name, index) pairs from the root; index -1 where there is none. Rules: CNF-21."""
        out: list[tuple[str, int]] = []
        while path != ROOT:
            parent, step, index = self.paths[path]
            out.append((STEPS[step].name, index))
            path = parent
        out.reverse()
        return out

    def path_text(self, row: int) -> str:
        """`plane[0].fap.group[7]`. Rules: CNF-21."""
        return ".".join(name + (f"[{i}]" if i >= 0 else "") for name, i in self.steps(self.path[row]))

    def rows(self) -> Iterator[tuple[Element, int, int, int, str]]:
        """(element, start, end, value, path) of every row. Rules: CNF-21."""
        for row in range(len(self)):
            yield self.el(row), self.start[row], self.end[row], self.value[row], self.path_text(row)


@mypyc_attr(allow_interpreted_subclasses=True)
class Tracer(Reader):
    """A reader whose trace says what every bit was.

    Rules: CNF-17, CNF-21, FBA-21..27. `symbols`: segments are decoded by the literal coder, and its steps are kept;
    without, by the reader's own, many times as fast. `shares`: without `symbols`, what each symbol costs is kept.
    """

    def __init__(
        self,
        cursor: BitCursor,
        *,
        limits: Limits = DEFAULT_LIMITS,
        readings: Readings = DEFAULT_READINGS,
        draft: bool = False,
        strict: bool = False,
        on_finding: Callable[[Finding], None] | None = None,
        collect: bool = False,
        profile: EntropyProfile | None = None,
        symbols: bool = True,
        shares: bool = False,
    ) -> None:
        super().__init__(
            cursor,
            limits=limits,
            readings=readings,
            draft=draft,
            strict=strict,
            on_finding=on_finding,
            collect=collect,
            profile=profile,
        )
        self.symbols = symbols
        self.shares = shares
        self.trace = Trace()
        self._here = ROOT
        self._interned: dict[tuple[int, int, int], int] = {}

    def take(self) -> Trace:
        """The rows since the last take. Rules: CNF-21."""
        done = self.trace
        self.trace = Trace()
        self._interned.clear()
        self._here = ROOT
        for step, index in zip(self._steps, self._indices, strict=True):
            self._here = self._intern(self._here, step, index)
        return done

    def _intern(self, parent: int, step: int, index: int) -> int:
        key = (parent, step, index)
        path = self._interned.get(key, ROOT)
        if path == ROOT:
            path = len(self.trace.paths)
            self.trace.paths.append(key)
            self._interned[key] = path
        return path

    def enter(self, step: Step, i: int) -> None:
        super().enter(step, i)
        self._here = self._intern(self._here, step.index, i)

    def leave(self) -> None:
        super().leave()
        self._here = self.trace.paths[self._here][0]

    def _row(self, el: Element, start: int, end: int, value: int) -> None:
        trace = self.trace
        trace.element.append(el.index)
        trace.start.append(start)
        trace.end.append(end)
        trace.value.append(value)
        trace.path.append(self._here)

    def u(self, el: Element, n: int, v: int) -> int:
        value = super().u(el, n, v)
        end = self.cursor.tell()
        self._row(el, end - n, end, value)
        return value

    def s(self, el: Element, n: int, v: int) -> int:
        value = super().s(el, n, v)
        self.trace.value[-1] = value
        return value

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        start = self.cursor.tell()
        symbol = super().vlc(el, table, v)
        self._row(el, start, self.cursor.tell(), symbol)
        return symbol

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        start = self.cursor.tell()
        if not self.symbols:
            widths: list[int] = []
            totals: list[int] = []
            if self.shares:
                levels, widths, totals = self._with_shares(el, models, start)
            else:
                levels = super().segment(el, models, labels, v, tail)
            end = self.cursor.tell()
            segment = SegmentTrace(
                start, end, (), self._guards(start, end), tuple(levels), self.tail,
                widths=tuple(widths), totals=tuple(totals),
            )  # fmt: skip
            self.trace.segments[len(self.trace)] = (segment, labels)
            self._row(el, start, end, len(models))
            return levels
        try:
            segment = decode_literally(self.cursor, models)
        except OutOfBits:
            raise self._truncated(el, start, "FBA-27") from None
        for position, value in segment.guards:
            if not value:
                raise self._bad_guard(position)
        self.tail = segment.tail
        self.trace.segments[len(self.trace)] = (segment, labels)
        self._row(el, start, segment.end, len(models))
        return list(segment.levels)

    def _with_shares(self, el: Element, models: list[Model], start: int) -> tuple[list[int], list[int], list[int]]:
        try:
            levels, bad_guard, self.tail, widths, totals = decode_with_shares(self.cursor, models)
        except OutOfBits:
            raise self._truncated(el, start, "FBA-27") from None
        if bad_guard >= 0:
            raise self._bad_guard(bad_guard)
        return levels, widths, totals

    def _guards(self, start: int, end: int) -> tuple[tuple[int, int], ...]:
        """The guards of a good segment: the bit behind every 22 zero bits."""
        first = start >> 3
        data = self.cursor.source.read_at(first, ((end + 7) >> 3) - first)
        if 0 not in data:
            return ()
        bits = format(int.from_bytes(data, "big"), f"0{8 * len(data)}b")[start & 7 : end - (first << 3)]
        found: list[tuple[int, int]] = []
        at = bits.find(_ZEROS)
        while 0 <= at < len(bits) - GUARD_AFTER:
            found.append((start + at + GUARD_AFTER, 1))
            at = bits.find(_ZEROS, at + GUARD_AFTER + 1)
        return tuple(found)

    def raw(self, el: Element, count: int, v: bytes) -> bytes:
        start = self.cursor.tell()
        data = super().raw(el, count, v)
        self.trace.blobs[len(self.trace)] = data
        self._row(el, start, self.cursor.tell(), count)
        return data

    def rest(self, el: Element, v: bytes) -> bytes:
        start = self.cursor.tell()
        data = super().rest(el, v)
        end = self.cursor.tell()
        self.trace.blobs[len(self.trace)] = data
        self._row(el, start, end, (end - start) >> 3)
        return data

    def zeros(self, el: Element, count: int) -> int:
        start = self.cursor.tell()
        count = super().zeros(el, count)
        self._row(el, start, start + count, 0)
        return count
