"""What the browser shows, without the browser: parts of a trace, places in them, their bytes and words.

Rules: CNF-17, CNF-21, CNF-23.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from snhc.analyzer.dump import plane_words
from snhc.analyzer.parts import Part, Parts, raw_bits
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.rules import ambiguities, rules
from snhc.reference_impl.systems.visual import PROFILE_AND_LEVEL, profile_name

RAW_SHOWN: Final = 256
# Labels of lines whose columns must stay in line; the second has no words of its own.
SYMBOLS: Final = "symbols"
SYMBOL: Final = "\t"


@dataclass(frozen=True, slots=True)
class Place:
    """A row of a part. Rules: CNF-21. `row` -1: the part as a whole."""

    part: int
    row: int = -1


class Document:
    """The parts of a stream that have been read so far.

    Rules: CNF-17, CNF-21. `most`: parts that are kept at the most; `whole` says whether the stream had no more.
    """

    def __init__(self, source: Source, parts: Parts, most: int) -> None:
        self.source = source
        self.parts: list[Part] = []
        self.whole = False
        self._iterator = iter(parts)
        self._most = most
        self._starts: list[int] = []
        self._parts = parts

    @property
    def error(self) -> SnhcError | None:
        """The fault that ended the stream, once it has been met."""
        return self._parts.error

    def read(self, count: int) -> list[Part]:
        """Read on by at most `count` parts; an empty list at the end of the stream or at the limit. Rules: CNF-17."""
        new: list[Part] = []
        while len(new) < count and len(self.parts) < self._most:
            part = next(self._iterator, None)
            if part is None:
                self.whole = True
                break
            new.append(part)
            self._starts.append(self._start_of(part))
            self.parts.append(part)
        return new

    def _start_of(self, part: Part) -> int:
        if len(part.trace):
            return part.trace.start[0]
        if part.error is not None and part.error.bits is not None:
            return part.error.bits[0]
        return self._starts[-1] if self._starts else 0

    # -- places --------------------------------------------------------------------------------------------------------

    def span(self, place: Place) -> tuple[int, int]:
        """The bits of a place. Rules: CNF-21."""
        part = self.parts[place.part]
        trace = part.trace
        if place.row >= 0:
            return trace.start[place.row], trace.end[place.row]
        if not len(trace):
            bits = part.error.bits if part.error is not None else None
            return bits if bits is not None else (0, 0)
        return trace.start[0], trace.end[len(trace) - 1]

    def at_bit(self, bit: int) -> Place | None:
        """The row that holds a bit; None for one that no row read so far holds. Rules: CNF-21."""
        index = bisect_right(self._starts, bit) - 1
        # Parts without rows begin where the next one does.
        while index >= 0:
            trace = self.parts[index].trace
            row = bisect_right(trace.start, bit) - 1
            # Elements of no bits stand at the same place as the one that holds the bit.
            while row >= 0 and trace.start[row] <= bit:
                if bit < trace.end[row]:
                    return Place(index, row)
                row -= 1
            if len(trace):
                return None
            index -= 1
        return None

    def plane(self, number: int) -> Place | None:
        """A plane of the first object that has so many. Rules: CNF-17."""
        for index, part in enumerate(self.parts):
            if part.plane is not None and part.plane_number == number:
                return Place(index)
        return None

    def search(self, words: str, after: Place | None, backwards: bool = False) -> Place | None:
        """The next row whose name, path, rule or value holds all words; around the end once. Rules: CNF-21.

        `name=value` is met by that value only. None where no row fits.
        """
        wanted = words.lower().split()
        if not wanted or not self.parts:
            return None
        start = after if after is not None else Place(0, -1)
        count = len(self.parts)
        for n in range(count + 1):
            index = (start.part + (-n if backwards else n)) % count
            trace = self.parts[index].trace
            rows = range(len(trace))
            if n == 0:
                rows = range(start.row) if backwards else range(start.row + 1, len(trace))
            elif n == count:
                rows = range(start.row + 1, len(trace)) if backwards else range(start.row + 1)
            for row in reversed(rows) if backwards else rows:
                if _fits(self.parts[index], row, wanted):
                    return Place(index, row)
        return None

    def trouble(self, after: Place | None) -> Place | None:
        """The next part with a finding or the fault, around the end once. Rules: CNF-23."""
        first = 0 if after is None else after.part + 1
        count = len(self.parts)
        for n in range(count):
            part = self.parts[(first + n) % count]
            if part.findings or part.error is not None:
                return Place((first + n) % count)
        return None

    # -- words ---------------------------------------------------------------------------------------------------------

    def title(self, index: int) -> str:
        """What the tree calls a part. Rules: CNF-17."""
        part = self.parts[index]
        start, end = self.span(Place(index))
        if part.error is not None:
            return f"error: {type(part.error).__name__}"
        if part.plane is not None:
            return f"plane {part.plane_number}: {plane_words(part.plane)}, {end - start} bits"
        return (part.kind if part.opens else f"end of {part.kind}") or "data"

    def row_title(self, index: int, row: int) -> str:
        """What the tree calls a row: `fap_quant = 2`. Rules: CNF-17."""
        trace = self.parts[index].trace
        element = trace.el(row)
        segment = trace.segments.get(row)
        if segment is not None:
            return f"{element.name}: {len(segment[1])} symbols"
        if row in trace.blobs:
            return f"{element.name}: {(trace.end[row] - trace.start[row]) >> 3} bytes"
        words = _meaning(self.parts[index], row)
        return f"{element.name} = {trace.value[row]}" + (f" ({words})" if words else "")

    def details(self, place: Place) -> Iterator[tuple[str, str]]:
        """(label, text) pairs about a place: element, value, bits, rule and how sure we are of it. Rules: CNF-17."""
        part = self.parts[place.part]
        start, end = self.span(place)
        if place.row < 0:
            yield "part", self.title(place.part)
            yield "bits", f"[{start}, {end}), {end - start} bits, byte {start >> 3}"
        else:
            trace = part.trace
            element = trace.el(place.row)
            yield "element", element.name
            if path := trace.path_text(place.row):
                yield "path", path
            yield "bits", f"[{start}, {end}), {end - start} bits, byte {start >> 3} bit {start & 7}"
            if 0 < end - start <= RAW_SHOWN:
                yield "raw", raw_bits(self.source, start, end)
            if place.row not in trace.segments and place.row not in trace.blobs:
                yield "value", str(trace.value[place.row])
            if words := _meaning(part, place.row):
                yield "meaning", words
            if element.restricted:
                yield "allowed", element.allowed
            yield from _symbols(part, place.row)
            yield from _rule(element.rule)
        for finding in part.findings:
            if finding.bits is None or place.row < 0 or (finding.bits[0] < end and start < finding.bits[1]):
                yield finding.severity, f"{finding.id}: {finding.message} ({finding.rule})"
        if part.error is not None and place.row < 0:
            yield "error", str(part.error)
            yield from _rule(part.error.rule)

    def hex_lines(self, first: int, count: int, per_line: int) -> list[tuple[int, bytes]]:
        """`count` lines of bytes from the line of byte `first` on, fewer at the end of the data. Rules: CNF-21."""
        offset = max(0, first - first % per_line)
        data = self.source.read_at(offset, count * per_line)
        return [(offset + at, data[at : at + per_line]) for at in range(0, len(data), per_line)]


def _meaning(part: Part, row: int) -> str:
    element, value = part.trace.el(row), part.trace.value[row]
    return profile_name(value) if element is PROFILE_AND_LEVEL else element.meaning.get(value, "")


def _fits(part: Part, row: int, wanted: list[str]) -> bool:
    trace = part.trace
    element = trace.el(row)
    name = element.name.lower()
    exact = f"{name}={trace.value[row]}"
    text = ""
    for word in wanted:
        if "=" in word:
            if word != exact:
                return False
        elif word not in name:
            if not text:
                labels = trace.segments[row][1] if row in trace.segments else []
                text = " ".join((trace.path_text(row), element.rule, *labels)).lower()
            if word not in text:
                return False
    return True


def _rule(id: str) -> Iterator[tuple[str, str]]:
    rule = rules().get(id)
    if rule is None:
        yield "rule", id
        return
    yield "rule", f"{id} {rule.title} ({rule.confidence})"
    yield "", rule.statement.strip().replace("\n", " ")
    if rule.clause:
        yield "clause", f"{rule.clause} (unverified)"
    for ambiguity in rule.ambiguities:
        entry = ambiguities()[ambiguity]
        yield "ambiguity", f"{ambiguity}: {entry.question} Followed: {entry.followed}"


def _symbols(part: Part, row: int) -> Iterator[tuple[str, str]]:
    """The columns that fit beside a tree; `snhc dump --symbols` has all."""
    segment = part.trace.segments.get(row)
    if segment is None:
        return
    steps, labels = segment
    width = max((len(label) for label in labels), default=0)
    yield SYMBOLS, f"{'':<{width}} {'level':>5}   {'low':>5} {'high':>5} {'code':>5} {'total':>5} bits"
    for label, step in zip(labels, steps.steps, strict=True):
        yield (
            SYMBOL,
            f"{label:<{width}} {step.level:>5} {'P' if step.adaptive else 'I'} {step.low:>5} {step.high:>5} "
            f"{step.code_value:>5} {step.total:>5} {step.shifts:>4}",
        )
    for position, bit in steps.guards:
        yield "guard", f"{bit} at bit {position} (FBA-25)"
