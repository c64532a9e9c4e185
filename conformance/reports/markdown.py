"""A report as Markdown, for the summary of a CI job.

Rules: CNF-15, CNF-17, CNF-18.
"""

from __future__ import annotations

import re
from html import escape
from typing import Final

from snhc.conformance.compare import BAD, STATUSES
from snhc.conformance.results import Report, Result
from snhc.reference_impl.bitstream.errors import one_line

from .words import divergence, numbers, remarks, where

# Failures told in full per decoder: a summary has a limit of size.
SHOWN: Final = 50
_SPECIAL: Final = re.compile(r"([\\`*_{}\[\]()#+\-.!|~@:])")


def text(report: Report) -> str:
    """The report as Markdown. Rules: CNF-18."""
    lines = [f"# Conformance: suite {_plain(report.suite)}", ""]
    if report.filter:
        lines += [f"Filter: {_code(report.filter)}", ""]
    statuses = [status for status in STATUSES if any(result.status == status for result in report.results)]
    lines += ["| decoder | verdict |" + "".join(f" {_plain(status)} |" for status in statuses)]
    lines += ["|---|---|" + "---:|" * len(statuses)]
    for adapter in report.adapters:
        counts = report.counts(adapter)
        verdict = "✅ pass" if report.passed(adapter) else "❌ **fail**"
        lines.append(
            f"| {_plain(adapter)} | {verdict} |" + "".join(f" {counts.get(status, '')} |" for status in statuses)
        )
    lines += ["", *(f"> {_plain(line)}" for line in remarks(report))]
    for adapter in report.adapters:
        bad = [result for result in report.results if result.adapter == adapter and result.status in BAD]
        if bad:
            lines += ["", f"## {_plain(adapter)}: {_plain(numbers(report, adapter))}", ""]
        for result in bad[:SHOWN]:
            lines += _failure(result)
        if len(bad) > SHOWN:
            lines += ["", f"... and {len(bad) - SHOWN} more."]
    return "\n".join(lines) + "\n"


def _failure(result: Result) -> list[str]:
    facts = [
        ("title", _plain(result.title)), ("where", _plain(where(result))), ("trace", _plain(divergence(result))),
        ("rules", _plain(", ".join(result.rules))), ("again", _code(result.reproduce)),
    ]  # fmt: skip
    # Markup of our own in HTML: a summary line must hold no Markdown.
    return [
        f"<details><summary><b>{escape(result.status)}</b> {escape(result.vector)}: "
        f"{escape(one_line(result.reason))}</summary>",
        "",
        *(f"* {name}: {value}" for name, value in facts if value),
        "",
        "</details>",
    ]


def _plain(text: str) -> str:
    """Text that says nothing to Markdown or HTML. Rules: CNF-18."""
    return _SPECIAL.sub(r"\\\1", escape(one_line(text), quote=False))


def _code(text: str) -> str:
    """Text as code: in an element, for nothing can be escaped between backticks."""
    return f"<code>{_plain(text)}</code>"
