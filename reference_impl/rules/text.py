"""The register as plain text.

Rules: CNF-8, CNF-23, CNF-24.
"""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.rules.register import AREAS, ambiguity, finding, rule, rules

if TYPE_CHECKING:
    from collections.abc import Iterator

_WIDTH: Final = 100


def describe(entry_id: str) -> str:
    """One entry as text of several lines, without a final newline.

    Rules: CNF-8, CNF-23, CNF-24.

    `entry_id`: a rule (`FBA-26`, with its ambiguities and their readings), an ambiguity (`AMB-FBA-6`) or a
    kind of finding (`no-end-code`). Raises `InputFormat` for an unknown id.
    """
    if entry_id.startswith("AMB-"):
        return _ambiguity(entry_id)
    if not entry_id.startswith(tuple(f"{area}-" for area in AREAS)):
        kind = finding(entry_id)
        return f"{kind.id}: finding, {kind.severity} ({kind.rule})\n\n{_paragraph(kind.description)}"
    entry = rule(entry_id)
    note = f" ({entry.note})" if entry.note else ""
    lines = [f"{entry.id}: {entry.title}", "", _paragraph(entry.statement), ""]
    lines.append(f"  confidence: {entry.confidence}{note}")
    lines.append(f"  clause (unverified): {entry.clause or 'not known'}")
    lines.append(f"  source: {entry.source}")
    lines.append(f"  built: {'yes' if entry.built else 'no'}")
    for name in entry.ambiguities:
        lines += ["", _ambiguity(name)]
    return "\n".join(lines)


def listing() -> Iterator[str]:
    """One line per rule: id, title, confidence, and a mark where the rule is not built.

    Rules: CNF-8.
    """
    for entry in rules().values():
        mark = "" if entry.built else "; not built"
        yield f"{entry.id:<7} {entry.title} [{entry.confidence}{mark}]"


def _ambiguity(ambiguity_id: str) -> str:
    entry = ambiguity(ambiguity_id)
    lines = [f"{entry.id}: {entry.question}"]
    for key, text in entry.readings.items():
        mark = "*" if key == entry.followed else " "
        lines.append(_paragraph(text, f"  {mark} {key}: ", "      "))
    lines.append(_paragraph(entry.why, "  why: ", "      "))
    lines.append(_paragraph(", ".join(entry.rules), "  rules: ", "      "))
    switch = f"--reading {entry.id}=KEY" if entry.built else "no switch yet"
    lines.append(f"  (* followed; {switch})")
    return "\n".join(lines)


def _paragraph(text: str, first: str = "  ", rest: str = "  ") -> str:
    return fill(text, _WIDTH, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False)
