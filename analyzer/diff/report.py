"""The report of a comparison: for the terminal, as JSON.

Rules: CNF-17, CNF-18, CNF-25. The JSON report fits `diff.schema.json`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.tables import fap_table

from .syntax import SyntaxDiff
from .values import ValueDiff

SCHEMA: Final = Path(__file__).with_name("diff.schema.json")
WORST: Final = 16
"""Channels in the terminal's table."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two inputs compared.

    Rules: CNF-17. `syntax`: None where an input is no stream, or it was not wanted; `values`: None where they were not
    wanted. `error`: the fault that ended one of them.
    """

    a: str
    b: str
    align: str
    tolerance: float
    syntax: SyntaxDiff | None
    values: ValueDiff | None
    error: SnhcError | None = None

    @property
    def equal(self) -> bool:
        """Whether nothing that was compared differs."""
        return (self.syntax is None or self.syntax.equal) and (self.values is None or self.values.equal)

    def as_json(self) -> dict[str, Any]:
        """The JSON report. Rules: CNF-25."""
        return {
            "format": "snhc-diff", "version": 1, "a": self.a, "b": self.b, "equal": self.equal,
            "align": self.align, "tolerance": self.tolerance,
            "syntax": None if self.syntax is None else self.syntax.as_json(),
            "values": None if self.values is None else self.values.as_json(),
        }  # fmt: skip


def json_text(comparison: Comparison) -> str:
    """The JSON report as text. Rules: CNF-25."""
    return json.dumps(comparison.as_json(), indent=1, ensure_ascii=False) + "\n"


def title_of(channel: str) -> str:
    """`FAP 48 head_pitch`; other channels as they are. Rules: FAC-4."""
    if channel.startswith("FAP "):
        return f"{channel} {fap_table()[int(channel[4:]) - 1].name}"
    return channel


def terminal_lines(comparison: Comparison) -> Iterator[str]:
    """The report for people, line by line. Rules: CNF-17."""
    yield f"A: {comparison.a}\n"
    yield f"B: {comparison.b}\n"
    if comparison.equal:
        yield "no difference: " + "; ".join(_compared(comparison)) + "\n"
        return
    if comparison.syntax is not None:
        yield from _syntax(comparison.syntax)
    if comparison.values is not None:
        yield from _values(comparison.values)


def _compared(comparison: Comparison) -> Iterator[str]:
    syntax, values = comparison.syntax, comparison.values
    if syntax is not None:
        yield f"syntax of {syntax.pairs} planes"
    if values is not None:
        within = f" (within {comparison.tolerance:g})" if comparison.tolerance else ""
        yield f"values of {values.compared} instants{within}"


def _syntax(found: SyntaxDiff) -> Iterator[str]:
    planes = f"{found.pairs} planes in both"
    if found.planes_a > found.pairs:
        planes += f", {found.planes_a - found.pairs} only in A"
    if found.planes_b > found.pairs:
        planes += f", {found.planes_b - found.pairs} only in B"
    yield f"\nsyntax: {planes}; {found.bits_a} bits in A, {found.bits_b} in B\n"
    if found.equal:
        yield "  no element differs\n"
        return
    if found.first is not None:
        yield f"  first divergence: {found.first}\n"
    rows = [
        (name, count.rule, str(count.compared), str(count.different), str(count.only_a), str(count.only_b))
        for name, count in sorted(found.elements.items(), key=lambda item: (-item[1].at_odds, item[0]))
        if count.at_odds
    ]
    yield from _table(("element", "rule", "compared", "differ", "only A", "only B"), rows[:WORST])
    if len(rows) > WORST:
        yield f"  ... and {len(rows) - WORST} more elements\n"
    for name, error in (("A", found.error_a), ("B", found.error_b)):
        if error is not None:
            yield f"  {name} ends with an error: {error}\n"
    yield from _shown(found.shown, found.differences)


def _values(found: ValueDiff) -> Iterator[str]:
    instants = f"{found.compared} instants in both"
    if found.only_a:
        instants += f", {found.only_a} only in A"
    if found.only_b:
        instants += f", {found.only_b} only in B"
    yield f"\nvalues: {instants}\n"
    if found.equal:
        yield "  no value differs\n"
        return
    if found.first is not None:
        yield f"  first divergence: {found.first}\n"
    rows = [
        (
            title_of(name), str(channel.compared), str(channel.different + channel.missing), f"{channel.largest:g}",
            f"{channel.rms:.2f}", "-" if channel.psnr is None else f"{channel.psnr:.2f}",
        )
        for name, channel in sorted(found.channels.items(), key=lambda item: (-item[1].rms, item[0]))
        if channel.different or channel.missing
    ]  # fmt: skip
    yield from _table(("channel", "compared", "differ", "max", "rms", "PSNR dB"), rows[:WORST])
    if len(rows) > WORST:
        yield f"  ... and {len(rows) - WORST} more channels\n"
    for name, (both, differ) in found.words.items():
        if differ:
            yield f"  {name}: {differ} of {both} differ\n"
    yield from _shown(found.shown, found.differences)


def _shown(shown: Sequence[object], count: int) -> Iterator[str]:
    yield f"  differences: {count}\n"
    for one in shown:
        yield f"    {one}\n"
    if count > len(shown):
        yield f"    ... and {count - len(shown)} more (--max)\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    if not rows:
        return
    widths = [max(len(row[n]) for row in (head, *rows)) for n in range(len(head))]
    for row in (head, *rows):
        left = 2 if head[1] == "rule" else 1
        cells = [
            cell.ljust(width) if n < left else cell.rjust(width)
            for n, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  " + "  ".join(cells).rstrip() + "\n"
