"""What several renderers say in the same words.

Rules: CNF-15, CNF-17, CNF-18.
"""

from __future__ import annotations

from snhc.conformance.compare import STATUSES
from snhc.conformance.results import Report, Result
from snhc.reference_impl.bitstream.errors import one_line


def where(result: Result) -> str:
    """The place of a failure in words, "" for none. Rules: CNF-17."""
    if result.location is not None:
        return str(result.location)
    document = result.evidence.get("document", {})
    return ", ".join(place["path"] for place in document.get("paths", []))


def numbers(report: Report, adapter: str) -> str:
    """`3 pass, 1 fail`. Rules: CNF-15."""
    counts = report.counts(adapter)
    return ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts.get(status)) or "nothing run"


def remarks(report: Report) -> list[str]:
    """What is to be said of the whole run: missing shards, an empty run, the ledger. Rules: CNF-15, CNF-20."""
    out = [
        f"{adapter}: shards {', '.join(map(str, shards.missing))} of {shards.count} are not here"
        for adapter, shards in report.shards.items()
        if shards.missing
    ]
    if not report.results:
        out.append("no vector was selected: an empty run fails")
    out += [f"ledger: {note.entry}: {note.message}" for note in report.notes]
    return [one_line(line) for line in out]


def divergence(result: Result) -> str:
    """What the decoder's own trace showed, "" for nothing. Rules: CNF-17."""
    found = result.evidence.get("divergence")
    if found is None:
        return ""
    if "fault" in found:
        return f"its trace: {found['fault']}"
    if found.get("agree"):
        return "its trace agrees with the reference trace"
    sides = []
    for name in ("reference", "candidate"):
        element = found.get(name)
        if element is None:
            sides.append(f"{name} has ended")
        else:
            value = element.get("value", element.get("levels", "?"))
            place = f" ({element['path']})" if element.get("path") else ""
            sides.append(f"{name} {element.get('element', '?')} = {value} at {element.get('bits', '?')}{place}")
    return "its trace differs first: " + ", ".join(sides)
