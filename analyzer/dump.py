"""A trace as text: one line per element, with bit span, bytes, value, meaning and rule.

Rules: CNF-17, CNF-21, CNF-23, FBA-21..27 (symbols). The same as JSON is in `dump_json`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.face.syntax import FBA_OBJECT_MASK
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.syntax.tracer import Trace
from snhc.reference_impl.systems.visual import AnyPlane

from .dump_layout import WIDE, Layout
from .elements import meaning, number_text, settled_bits
from .hexdump import hex_lines
from .parts import Part, Parts, raw_bits
from .query import Query, Subject
from .tree import Node, build_tree

LEVELS_WIDTH: Final = 40
BITS_PER_LINE: Final = 64
# Lines of bytes that a long element shows; all of them only when asked for.
LINES_SHOWN: Final = 4
# A rule with the blank before it.
_RULE_ROOM: Final = 7

_BOLD: Final = "\x1b[1m"
_DIM: Final = "\x1b[2m"
_RED: Final = "\x1b[31m"
_GREEN: Final = "\x1b[32m"
_YELLOW: Final = "\x1b[33m"
_CYAN: Final = "\x1b[36m"
_RESET: Final = "\x1b[0m"
_OTHERS: Final = re.compile(r"[. ]+|'|\.\.\.")


@dataclass(frozen=True, slots=True)
class TreeOptions:
    """How the tree is shown. Rules: CNF-17.

    `depth`: levels below an item that are opened, None for all: 1 shows planes as one line each. `symbols`:
    arithmetic segments symbol by symbol. `all_bytes`: long elements with all their bytes. `colour`: ANSI colours.
    `layout`: the columns.
    """

    depth: int | None = None
    symbols: bool = False
    all_bytes: bool = False
    colour: bool = False
    layout: Layout = WIDE


def dump_tree(
    parts: Parts, source: Source, options: TreeOptions | None = None, query: Query | None = None
) -> Iterator[str]:
    """The dump of a stream, line by line, each with its newline.

    Rules: CNF-17, CNF-21, CNF-23. A fault stands where it is, and behind it what it leaves unread; `parts.error` holds
    it. `query`: no tree, but a line with its path for every element, plane and symbol that it takes.
    """
    printer = _Printer(source, options if options is not None else TreeOptions())
    yield printer.title()
    for part in parts:
        yield from printer.part(part) if query is None else printer.taken(part, query)
    if query is not None:
        return
    gap = parts.unclaimed(source)
    if gap is not None:
        yield from printer.unclaimed(*gap)


class _Printer:
    def __init__(self, source: Source, options: TreeOptions) -> None:
        self._source = source
        self._options = options
        self._layout = self._options.layout
        self._span_width = self._layout.span
        self._most = None if options.all_bytes else LINES_SHOWN
        self._pending: list[Finding] = []

    def _colour(self, text: str, code: str) -> str:
        return f"{code}{text}{_RESET}" if self._options.colour and code and text else text

    def title(self) -> str:
        """The names of the columns."""
        layout = self._layout
        left = f"{'bits':<{self._span_width}} "
        left += f"{'byte':<{layout.offset}} " if layout.offset else ""
        left += f"{'data':<{layout.data}} " if layout.data else ""
        return self._colour(f"{left}{'element':<{self._name_width(left)}} rule", _DIM) + "\n"

    def _name_width(self, left: str) -> int:
        """How wide elements are, where a line begins like that; a narrow terminal has the rules at its right."""
        name, most = self._layout.name, self._layout.most
        return min(name, max(most - len(left) - _RULE_ROOM, 0)) if most else name

    def line(
        self, span: tuple[int, int] | None, data: tuple[int, str] | None, text: str, rule: str = "", code: str = "",
        *, fold: bool = False,
    ) -> str:  # fmt: skip
        """A line: `data` is a byte offset with digits. `fold`: a text that has no room goes on below."""
        layout = self._layout
        shown_span = f"[{span[0]}, {span[1]})" if span is not None else ""
        # Spans ascend: the column moves once where numbers grow longer.
        self._span_width = max(self._span_width, len(shown_span)) if layout.most else self._span_width
        offset, digits = (f"{data[0]:06x}", data[1]) if data is not None else ("", "")
        left = f"{shown_span:<{self._span_width}} "
        left += f"{offset:<{layout.offset}} " if layout.offset else ""
        # Colours come last: they must not count as width.
        out = self._colour(left, _DIM)
        if layout.data:
            digits = layout.fitted(digits, layout.data)
            out += self._digits(digits, code) + " " * (layout.data + 1 - len(digits))
            left += f"{digits:<{layout.data}} "
        room = layout.most - len(left) - (max(len(rule) + 1, _RULE_ROOM) if rule else 0)
        text, *more = layout.folded(text, room) if fold else [layout.fitted(text, room)]
        name = f"{text:<{self._name_width(left)}}" if rule else text
        out += self._colour(name, code) + (" " + self._colour(rule, _CYAN) if rule else "")
        return out.rstrip() + "\n" + "".join(" " * len(left) + self._colour(line, code) + "\n" for line in more)

    def _digits(self, digits: str, code: str) -> str:
        if not self._options.colour or not digits:
            return digits
        own = code if code in (_RED, _YELLOW) else _GREEN
        # The bits of others, and the marks, are dim.
        out, at = "", 0
        for match in _OTHERS.finditer(digits):
            out += self._colour(digits[at : match.start()], own) + self._colour(match[0], _DIM)
            at = match.end()
        return out + self._colour(digits[at:], own)

    def _data(self, span: tuple[int, int], most: int | None) -> Iterator[tuple[int, str, str]]:
        """The bytes of a span, as many to a line as there is room for."""
        per_line = self._layout.per_line
        return hex_lines(self._source, *span, most, per_line) if per_line else iter(())

    def lines(
        self, span: tuple[int, int], text: str, rule: str = "", code: str = "", *, fold: bool = False
    ) -> Iterator[str]:
        """A line with the data of its span, which may go on below it."""
        data = self._data(span, self._most)
        first = next(data, None)
        yield self.line(span, first[:2] if first is not None else None, text, rule, code, fold=fold)
        for offset, digits, _ in data:
            yield self.line(None, (offset, digits), "", "", code)

    def part(self, part: Part) -> Iterator[str]:
        """The lines of a part."""
        tree = build_tree(part.trace)
        self._pending = sorted(part.findings, key=lambda finding: finding.bits[1] if finding.bits else 0)
        if part.opens:
            yield self.line(None, None, part.kind, code=_BOLD)
        if part.error is not None and len(part.trace) and part.trace.path[0] < 0:
            # The item failed in its own header: only its rows say what it is.
            name = part.trace.el(0).name.removesuffix("_start_code")
            yield self.line(None, None, name, code=_BOLD)
        for child in tree.children:
            if isinstance(child, Node) and part.closes:
                # Behind the last plane: the path counts on, but no plane is there.
                for below in child.children:
                    yield from self._child(part, below, 1)
            else:
                yield from self._child(part, child, 1)
        yield from self._findings(None, 1)
        if part.error is not None:
            yield self._error(part.error)

    def taken(self, part: Part, query: Query) -> Iterator[str]:
        """What of a part an expression takes, one after the other."""
        trace = part.trace
        if query.takes_plane(part, self._source):
            plane = part.plane
            assert plane is not None
            count = plane.end - plane.start
            text = f"plane[{part.plane_number}]: {plane_words(plane)}"
            yield self.line((plane.start, plane.end), (plane.start >> 3, f"{count} bits"), text, code=_BOLD, fold=True)
        for row in range(len(trace)):
            above = trace.path_text(row)
            if query.takes_row(part, row, self._source):
                element = trace.el(row)
                text = f"{above}.{row_words(trace, row)}" if above else row_words(trace, row)
                yield from self.lines((trace.start[row], trace.end[row]), text, element.rule, fold=True)
            segment = trace.segments.get(row)
            if segment is None or not self._options.symbols:
                continue
            for number, span in enumerate(settled_bits(segment[0])):
                subject = Subject(part, row, self._source, number, span)
                if query(subject):
                    text = f"{above}.{trace.el(row).name}: {segment[1][number]} = {segment[0].levels[number]}"
                    yield from self.lines(span, text, "FBA-23", fold=True)
        if part.error is not None:
            yield self._error(part.error)

    def _child(self, part: Part, child: Node | int, level: int) -> Iterator[str]:
        depth = self._options.depth
        if isinstance(child, int):
            yield from self._row(part, child, level)
            yield from self._findings(part.trace.end[child], level)
            return
        title = child.name
        if level == 1 and part.plane is not None:
            title += f": {plane_words(part.plane)}"
        count = child.end - child.start
        digits = f"{count} bit{'s' if count != 1 else ''}"
        yield self.line(
            (child.start, child.end), (child.start >> 3, digits), self._layout.indent * level + title, code=_BOLD
        )
        if depth is not None and level >= depth:
            yield from self._findings(child.end, level + 1)
            return
        for below in child.children:
            yield from self._child(part, below, level + 1)

    def _row(self, part: Part, row: int, level: int) -> Iterator[str]:
        trace = part.trace
        element = trace.el(row)
        span = trace.start[row], trace.end[row]
        indent = self._layout.indent * level
        text = indent + row_words(trace, row)
        if row in trace.blobs:
            yield self.line(span, None, text, element.rule)
            for offset, digits, characters in self._data(span, self._most):
                yield self.line(None, (offset, digits), f"{indent}{self._layout.indent}|{characters}|")
            return
        yield from self.lines(span, text, element.rule)
        segment = trace.segments.get(row)
        if segment is None:
            return
        steps, labels = segment
        if self._options.symbols and steps.steps:
            yield from self._symbols(steps, labels, level + 1)
        else:
            yield from self._guards(steps, indent + self._layout.indent)

    def _guards(self, segment: SegmentTrace, indent: str) -> Iterator[str]:
        for position, _ in segment.guards:
            yield from self.lines((position, position + 1), f"{indent}guard", "FBA-25")

    def _symbols(self, segment: SegmentTrace, labels: list[str], level: int) -> Iterator[str]:
        indent = self._layout.indent * level
        bits = raw_bits(self._source, segment.start, segment.end)
        count = self._layout.bits(self._span_width, len(indent), BITS_PER_LINE)
        for at in range(0, len(bits), count):
            span = segment.start + at, segment.start + min(at + count, len(bits))
            yield self.line(span, None, indent + bits[at : at + count])
        yield from self._guards(segment, indent)
        width = max((len(label) for label in labels), default=0)
        yield self.line(None, None, indent + symbol_titles(width), code=_DIM)
        for step, label, span in zip(segment.steps, labels, settled_bits(segment), strict=True):
            total = f"{step.total}" + ("*" if step.rescaled else "")
            yield self.line(
                span if span[0] < span[1] else None, None,
                f"{indent}{label:<{width}} {step.level:>6} {'P' if step.adaptive else 'I':>5} {step.low:>6} "
                f"{step.high:>6} {step.code_value:>6} {step.c:>6} {step.cum_low:>6} {step.cum_high:>6} {total:>7} "
                f"{step.bits_before:>6} {step.shifts:>6}",
            )  # fmt: skip
        if any(step.rescaled for step in segment.steps):
            yield self.line(None, None, f"{indent}* the frequencies were halved before the update", "FBA-24")

    def _findings(self, upto: int | None, level: int) -> Iterator[str]:
        while self._pending:
            finding = self._pending[0]
            if upto is not None and finding.bits is not None and finding.bits[1] > upto:
                return
            self._pending.pop(0)
            text = f"{self._layout.indent * level}! {finding.severity} {finding.id}: {finding.message}"
            yield self.line(finding.bits, None, text, finding.rule, _YELLOW, fold=True)

    def _error(self, error: SnhcError) -> str:
        span = error.bits
        data = next(self._data(span, 1), None) if span is not None else None
        return self.line(span, data[:2] if data else None, f"error: {error}", code=_RED, fold=True)

    def unclaimed(self, start: int, end: int) -> Iterator[str]:
        """The bits that the fault leaves unread."""
        text = f"unclaimed: {end - start} bits from the fault to the end"
        yield from self.lines((start, end), text, code=_YELLOW, fold=True)


def row_words(trace: Trace, row: int) -> str:
    """`fba_object_mask = 1 (FAP data)`. Rules: CNF-17, CNF-21."""
    element = trace.el(row)
    width, value = trace.end[row] - trace.start[row], trace.value[row]
    segment = trace.segments.get(row)
    if segment is not None:
        return f"{element.name} = {_levels(segment[0])}"
    if row in trace.blobs:
        return f"{element.name} = {width >> 3} bytes"
    if width > BITS_PER_LINE:
        return f"{element.name} = {width} bits"
    words = meaning(element, value)
    return f"{element.name} = {number_text(element, value, width)}" + (f" ({words})" if words else "")


def symbol_titles(width: int) -> str:
    """The column titles of the symbols of a segment. Rules: FBA-23."""
    return (
        f"{'symbol':<{width}} {'level':>6} {'model':>5} {'low':>6} {'high':>6} {'code':>6} {'c':>6} {'cum_lo':>6} "
        f"{'cum_hi':>6} {'total':>7} {'read':>6} {'shift':>6}"
    )


def plane_words(plane: AnyPlane) -> str:
    """`intra, FAP data, time 0/1 s`. Rules: FBA-5, MSH-2."""
    if isinstance(plane, MeshPlane):
        data = "motion" if plane.motion is not None else "geometry" if plane.geometry is not None else "no data"
    else:
        data = FBA_OBJECT_MASK.meaning[plane.fba_object_mask]
    words = f"{'intra' if plane.is_intra else 'inter'}, {data}"
    if plane.frames:
        time = plane.frames[0].time
        words += f", time {time[0]}/{time[1]} s"
    return words


def _levels(segment: SegmentTrace) -> str:
    count = len(segment.levels)
    text = f"{count} symbol{'s' if count != 1 else ''}:"
    for shown, level in enumerate(segment.levels):
        if len(text) > LEVELS_WIDTH:
            return f"{text} ... ({count - shown} more)"
        text += f" {level}"
    return text
