"""The report for people at a terminal.

Rules: CNF-15, CNF-17, CNF-18.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from snhc.conformance.compare import BAD, STATUSES
from snhc.conformance.results import Report, Result
from snhc.reference_impl.bitstream.errors import one_line
from snhc.vectors.manifest import TIERS

from .words import divergence, numbers, remarks, where

if TYPE_CHECKING:
    from rich.console import Console

# Failures told in full per decoder; a report file holds all.
SHOWN: Final = 20
_STYLES: Final[Mapping[str, str]] = {
    "pass": "green", "xfail": "yellow", "not_applicable": "dim", "skipped": "dim",
    **dict.fromkeys(BAD, "bold red"),
}  # fmt: skip


def terminal_text(report: Report, *, colour: bool = False, width: int = 100) -> str:
    """Failures in detail, a table of tiers for each decoder, a matrix of tools for several, and the verdicts.

    Rules: CNF-17, CNF-18. Of each decoder the first SHOWN failures are told.
    """
    from rich.console import Console

    buffer = io.StringIO()
    console = Console(
        file=buffer, force_terminal=colour, no_color=not colour, width=width, highlight=False, soft_wrap=True
    )
    for name in report.adapters:
        bad = [result for result in report.results if result.adapter == name and result.status in BAD]
        for result in bad[:SHOWN]:
            _failure(console, result)
        if len(bad) > SHOWN:
            more = f"... and {len(bad) - SHOWN} more of {one_line(name)}; -o report.html shows all"
            console.print(more, markup=False)
    for name in report.adapters:
        _table(console, report, name)
    if len(report.adapters) > 1:
        _matrix(console, report)
    _verdicts(console, report)
    return buffer.getvalue()


def verdict_text(report: Report, *, colour: bool = False) -> str:
    """The verdicts alone, a line for each decoder: what people see of a report that goes to a file.

    Rules: CNF-15, CNF-18.
    """
    from rich.console import Console

    buffer = io.StringIO()
    _verdicts(Console(file=buffer, force_terminal=colour, no_color=not colour, highlight=False, soft_wrap=True), report)
    return buffer.getvalue()


def _verdicts(console: Console, report: Report) -> None:
    for line in remarks(report):
        console.print(line, style="bold red" if not report.results else "yellow", markup=False)
    for name in report.adapters:
        passed = report.passed(name)
        console.print(f"{one_line(name)}: ", style="bold", end="", markup=False)
        console.print("pass" if passed else "FAIL", style="bold green" if passed else "bold red", end="")
        console.print(f" ({numbers(report, name)}; suite {report.suite})", markup=False)


def _failure(console: Console, result: Result) -> None:
    console.print(f"{result.status.upper()} ", style=_STYLES[result.status], end="")
    console.print(f"{result.vector} ", style="bold", end="", markup=False)
    console.print(one_line(f"[{result.adapter}] {result.title}"), markup=False)
    console.print(f"  {one_line(result.reason)}", markup=False)
    for label, text in (("where", where(result)), ("trace", divergence(result))):
        if text:
            console.print(f"  {label}: {one_line(text)}", markup=False)
    if result.known is not None and result.known.expired:
        console.print(f"  known until {result.known.expires}: {one_line(result.known.reason)}", markup=False)
    console.print(f"  rules: {', '.join(result.rules)}", markup=False)
    console.print(f"  again: {one_line(result.reproduce)}", markup=False)


def _table(console: Console, report: Report, name: str) -> None:
    from rich.markup import escape
    from rich.table import Table

    results = [result for result in report.results if result.adapter == name]
    statuses = [status for status in STATUSES if any(result.status == status for result in results)]
    if not statuses:
        return
    table = Table(title=escape(one_line(f"{name}, suite {report.suite}")), title_justify="left")
    table.add_column("tier")
    for status in statuses:
        table.add_column(status, justify="right", style=_STYLES[status])
    for tier in TIERS:
        counts = [sum(r.tier == tier and r.status == status for r in results) for status in statuses]
        if any(counts):
            table.add_row(tier, *(str(count) if count else "" for count in counts))
    console.print(table)


def _matrix(console: Console, report: Report) -> None:
    """Decoders side by side: passes of the vectors that apply, by tool."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(title="passed of applicable, by tools", title_justify="left")
    table.add_column("tools")
    for name in report.adapters:
        table.add_column(escape(one_line(name)), justify="right", overflow="fold")
    for tools in dict.fromkeys(result.tools for result in report.results):
        cells = [", ".join(tools)]
        for name in report.adapters:
            statuses = [r.status for r in report.results if r.adapter == name and r.tools == tools]
            counted = [status for status in statuses if status not in ("not_applicable", "skipped")]
            passes = counted.count("pass")
            style = "dim" if not counted else "green" if not set(counted) & set(BAD) else "bold red"
            cells.append(f"[{style}]{f'{passes}/{len(counted)}' if counted else '-'}[/]")
        table.add_row(*cells)
    console.print(table)
