"""A trace as text: one line per element, with bit span, raw bits, value, meaning and rule.

Rules: CNF-17, CNF-21, CNF-23, FBA-21..27 (symbols). The same as JSON is in `dump_json`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.face.syntax import FBA_OBJECT_MASK
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.systems.visual import PROFILE_AND_LEVEL, AnyPlane, profile_name

from .parts import Part, Parts, raw_bits
from .tree import Node, build_tree

SPAN_WIDTH: Final = 20
RAW_WIDTH: Final = 18
NAME_WIDTH: Final = 62
# Longer elements show hexadecimal digits, or their first bits.
BINARY_BITS: Final = 16
LEVELS_WIDTH: Final = 44
BITS_PER_LINE: Final = 64
BYTES_SHOWN: Final = 16
INDENT: Final = "  "

_BOLD: Final = "\x1b[1m"
_DIM: Final = "\x1b[2m"
_RED: Final = "\x1b[31m"
_YELLOW: Final = "\x1b[33m"
_CYAN: Final = "\x1b[36m"
_RESET: Final = "\x1b[0m"


@dataclass(frozen=True, slots=True)
class TreeOptions:
    """How the tree is shown. Rules: CNF-17.

    `depth`: levels below an item that are opened, None for all: 1 shows planes as one line each. `symbols`:
    arithmetic segments symbol by symbol. `colour`: ANSI colours.
    """

    depth: int | None = None
    symbols: bool = False
    colour: bool = False


def dump_tree(parts: Parts, source: Source, options: TreeOptions | None = None) -> Iterator[str]:
    """The dump of a stream, line by line, each with its newline.

    Rules: CNF-17, CNF-21, CNF-23. A fault stands in the last line; `parts.error` holds it.
    """
    printer = _Printer(source, options if options is not None else TreeOptions())
    yield printer.line("bits", "raw", "element", "rule", _DIM)
    for part in parts:
        yield from printer.part(part)


class _Printer:
    def __init__(self, source: Source, options: TreeOptions) -> None:
        self._source = source
        self._options = options
        self._pending: list[Finding] = []

    def _colour(self, text: str, code: str) -> str:
        return f"{code}{text}{_RESET}" if self._options.colour and code else text

    def line(self, span: str, raw: str, text: str, rule: str = "", code: str = "") -> str:
        # Colours come last: they must not count as width.
        shown = f"{text:<{NAME_WIDTH}}" if rule else text
        left = f"{span:<{SPAN_WIDTH}} {raw:<{RAW_WIDTH}} "
        if code == _DIM:
            return self._colour(f"{left}{shown} {rule}".rstrip(), code) + "\n"
        out = self._colour(left, _DIM) + self._colour(shown, code) + (" " + self._colour(rule, _CYAN) if rule else "")
        return out.rstrip() + "\n"

    def part(self, part: Part) -> Iterator[str]:
        tree = build_tree(part.trace)
        self._pending = sorted(part.findings, key=lambda finding: finding.bits[1] if finding.bits else 0)
        if part.opens:
            yield self.line("", "", part.kind, code=_BOLD)
        if part.error is not None and len(part.trace) and part.trace.path[0] < 0:
            # The item failed in its own header: only its rows say what it is.
            name = part.trace.el(0).name.removesuffix("_start_code")
            yield self.line("", "", name, code=_BOLD)
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
        yield self.line(
            f"[{child.start}, {child.end})", f"{count} bit{'s' if count != 1 else ''}", INDENT * level + title,
            code=_BOLD,
        )  # fmt: skip
        if depth is not None and level >= depth:
            yield from self._findings(child.end, level + 1)
            return
        for below in child.children:
            yield from self._child(part, below, level + 1)

    def _row(self, part: Part, row: int, level: int) -> Iterator[str]:
        trace = part.trace
        element = trace.el(row)
        start, end, value = trace.start[row], trace.end[row], trace.value[row]
        span = f"[{start}, {end})"
        indent = INDENT * level
        segment = trace.segments.get(row)
        if segment is not None:
            steps, labels = segment
            yield self.line(span, self._raw(start, end), f"{indent}{element.name} = {_levels(steps)}", element.rule)
            if self._options.symbols:
                yield from self._symbols(steps, labels, level + 1)
            else:
                for position, bit in steps.guards:
                    yield self.line(f"[{position}, {position + 1})", str(bit), f"{indent}{INDENT}guard", "FBA-25")
            return
        if row in trace.blobs:
            raw = self._source.read_at(start >> 3, BYTES_SHOWN).hex(" ") if end > start else ""
            more = " ..." if end - start > 8 * BYTES_SHOWN else ""
            text = f"{indent}{element.name} = {(end - start) >> 3} bytes"
            yield self.line(span, "", text, element.rule)
            if raw:
                yield self.line("", "", f"{indent}{INDENT}{raw[: 3 * ((end - start) >> 3)].strip()}{more}")
            return
        if end - start > BITS_PER_LINE:
            yield self.line(span, "", f"{indent}{element.name} = {end - start} bits", element.rule)
            return
        words = profile_name(value) if element is PROFILE_AND_LEVEL else element.meaning.get(value, "")
        shown = f"0x{value:08x}" if end - start == 32 and element.name.endswith("_code") else str(value)
        text = f"{indent}{element.name} = {shown}" + (f" ({words})" if words else "")
        yield self.line(span, self._raw(start, end), text, element.rule)

    def _raw(self, start: int, end: int) -> str:
        width = end - start
        if width <= BINARY_BITS:
            return raw_bits(self._source, start, end)
        if width <= 32 and width % 4 == 0:
            return f"0x{int(raw_bits(self._source, start, end), 2):0{width // 4}x}"
        return raw_bits(self._source, start, start + BINARY_BITS) + ".."

    def _symbols(self, segment: SegmentTrace, labels: list[str], level: int) -> Iterator[str]:
        indent = INDENT * level
        bits = raw_bits(self._source, segment.start, segment.end)
        for at in range(0, len(bits), BITS_PER_LINE):
            span = f"[{segment.start + at}, {segment.start + min(at + BITS_PER_LINE, len(bits))})"
            yield self.line(span, "", indent + bits[at : at + BITS_PER_LINE])
        for position, bit in segment.guards:
            yield self.line(f"[{position}, {position + 1})", str(bit), f"{indent}guard", "FBA-25")
        width = max((len(label) for label in labels), default=0)
        yield self.line("", "", indent + symbol_titles(width), code=_DIM)
        for step, label in zip(segment.steps, labels, strict=True):
            total = f"{step.total}" + ("*" if step.rescaled else "")
            yield self.line(
                "", "",
                f"{indent}{label:<{width}} {step.level:>6} {'P' if step.adaptive else 'I':>5} {step.low:>6} "
                f"{step.high:>6} {step.code_value:>6} {step.c:>6} {step.cum_low:>6} {step.cum_high:>6} {total:>7} "
                f"{step.bits_before:>6} {step.shifts:>6}",
            )  # fmt: skip
        if any(step.rescaled for step in segment.steps):
            yield self.line("", "", f"{indent}* the frequencies were halved before the update", "FBA-24")

    def _findings(self, upto: int | None, level: int) -> Iterator[str]:
        while self._pending:
            finding = self._pending[0]
            if upto is not None and finding.bits is not None and finding.bits[1] > upto:
                return
            self._pending.pop(0)
            span = f"[{finding.bits[0]}, {finding.bits[1]})" if finding.bits is not None else ""
            text = f"{INDENT * level}! {finding.severity} {finding.id}: {finding.message}"
            yield self.line(span, "", text, finding.rule, _YELLOW)

    def _error(self, error: SnhcError) -> str:
        span = f"[{error.bits[0]}, {error.bits[1]})" if error.bits is not None else ""
        return self.line(span, "", f"error: {error}", code=_RED)


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
    count = len(segment.steps)
    text = f"{count} symbol{'s' if count != 1 else ''}:"
    for shown, step in enumerate(segment.steps):
        if len(text) > LEVELS_WIDTH:
            return f"{text} ... ({count - shown} more)"
        text += f" {step.level}"
    return text
