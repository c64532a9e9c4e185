"""Reports of a run: for the terminal, and as JSON.

Rules: CNF-15, CNF-17, CNF-18 (terminal, JSON). The JSON report fits `report.schema.json`.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from snhc.vectors.manifest import TIERS

from .compare import BAD, STATUSES
from .runner import Report, Result

if TYPE_CHECKING:
    from rich.console import Console

FORMAT: Final = "snhc-report"
VERSION: Final = 1
SCHEMA_FILE: Final = Path(__file__).parent / "report.schema.json"
_STYLES: Final[Mapping[str, str]] = {
    "pass": "green", "xfail": "yellow", "not_applicable": "dim", "skipped": "dim",
    **dict.fromkeys(BAD, "bold red"),
}  # fmt: skip


def as_json(report: Report) -> dict[str, Any]:
    """The JSON report. Rules: CNF-18."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "suite": report.suite,
        "filter": report.filter,
        "adapters": [
            {
                "name": name,
                "verdict": "pass" if report.passed(name) else "fail",
                "counts": {status: report.counts(name).get(status, 0) for status in STATUSES},
            }
            for name in report.adapters
        ],
        "results": [_result(result) for result in report.results],
    }


def _result(result: Result) -> dict[str, Any]:
    out: dict[str, Any] = {
        "adapter": result.adapter, "vector": result.vector, "title": result.title, "tier": result.tier,
        "kind": result.kind, "rules": list(result.rules), "status": result.status, "reason": result.reason,
        "seconds": round(result.seconds, 6), "reproduce": result.reproduce,
    }  # fmt: skip
    if result.reading:
        out["reading"] = result.reading
    if result.difference is not None:
        d = result.difference
        out["difference"] = {
            "frame": d.frame, "what": d.what, "fap": d.fap, "reference": d.reference, "candidate": d.candidate,
        }  # fmt: skip
    if result.location is not None:
        out["location"] = result.location.as_json()
    return out


def json_text(report: Report) -> str:
    """The JSON report as text. Rules: CNF-18."""
    return json.dumps(as_json(report), ensure_ascii=False, indent=1) + "\n"


def terminal_text(report: Report, *, colour: bool = False, width: int = 100) -> str:
    """The report for people: failures in detail, then a table of tiers, then a verdict for each decoder.

    Rules: CNF-17, CNF-18.
    """
    from rich.console import Console

    buffer = io.StringIO()
    console = Console(
        file=buffer, force_terminal=colour, no_color=not colour, width=width, highlight=False, soft_wrap=True
    )
    for result in report.results:
        if result.status in BAD:
            _failure(console, result)
    for name in report.adapters:
        _table(console, report, name)
    if not report.results:
        console.print("no vector was selected: an empty run fails", style="bold red")
    for name in report.adapters:
        passed = report.passed(name)
        counts = report.counts(name)
        numbers = ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts.get(status))
        console.print(f"{name}: ", style="bold", end="", markup=False)
        console.print("pass" if passed else "FAIL", style="bold green" if passed else "bold red", end="")
        console.print(f" ({numbers or 'nothing run'}; suite {report.suite})", markup=False)
    return buffer.getvalue()


def _failure(console: Console, result: Result) -> None:
    console.print(f"{result.status.upper()} ", style=_STYLES[result.status], end="")
    console.print(f"{result.vector} ", style="bold", end="", markup=False)
    console.print(f"[{result.adapter}] {result.title}", markup=False)
    console.print(f"  {_printable(result.reason)}", markup=False)
    if result.location is not None:
        console.print(f"  where: {result.location}", markup=False)
    console.print(f"  rules: {', '.join(result.rules)}", markup=False)
    console.print(f"  again: {result.reproduce}", markup=False)


def _printable(text: str) -> str:
    # A foreign program's words must not steer the terminal.
    return "".join(char if char.isprintable() else "?" for char in text)


def _table(console: Console, report: Report, name: str) -> None:
    from rich.table import Table

    results = [result for result in report.results if result.adapter == name]
    statuses = [status for status in STATUSES if any(result.status == status for result in results)]
    if not statuses:
        return
    table = Table(title=f"{name}, suite {report.suite}", title_justify="left")
    table.add_column("tier")
    for status in statuses:
        table.add_column(status, justify="right", style=_STYLES[status])
    for tier in TIERS:
        counts = [sum(r.tier == tier and r.status == status for r in results) for status in statuses]
        if any(counts):
            table.add_row(tier, *(str(count) if count else "" for count in counts))
    console.print(table)
