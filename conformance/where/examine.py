"""The evidence of a failure: place, trace, bits, symbols, curves, mesh, document.

Rules: CNF-17, CNF-18.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from snhc.conformance.candidate import Malformed
from snhc.conformance.compare import said, span
from snhc.vectors.manifest import DOCUMENTS, Accepted, Entry, Rejected

from .documents import document_evidence
from .excerpt import excerpt
from .foreign import divergence, trace_file
from .location import Hit, Location, find, find_bits
from .pictures import pictures

if TYPE_CHECKING:
    from snhc.conformance.adapters import Adapter, Outcome
    from snhc.conformance.compare import Verdict

# The end of what a decoder said is where it says why.
STDERR: Final = 2000


@dataclass(frozen=True, slots=True)
class Findings:
    """What is known of a failure.

    Rules: CNF-17. `expected`, `got`: of a rejection: `class`, `rule`, `bits`, `path`, `line`. `evidence`: what reports
    show: `trace`, `symbols`, `bytes`, `curve`, `mesh`, `document`, `divergence`, each where there is one.
    """

    location: Location | None = None
    expected: Mapping[str, Any] = field(default_factory=dict)
    got: Mapping[str, Any] = field(default_factory=dict)
    evidence: Mapping[str, Any] = field(default_factory=dict)


def examine(
    entry: Entry, suite: Path, adapter: Adapter, outcome: Outcome, verdict: Verdict, traces: Path | None = None
) -> Findings:
    """Look into a failure. Rules: CNF-17. `traces`: a folder with the decoder's own traces."""
    got: dict[str, Any] = {}
    expected: dict[str, Any] = {}
    hit: Hit | None = None
    evidence: dict[str, Any] = {}
    difference = verdict.difference
    if difference is not None:
        hit = find(entry, suite, difference, fap_frames=adapter.format == "fap")
        evidence |= pictures(entry, suite, difference, outcome.stdout, adapter.format)
    else:
        got = _said(outcome)
        if not entry.readings:
            expected = _expected(entry)
        bits = got.get("bits") if isinstance(entry.expect, Accepted) else expected.get("bits")
        if bits is not None:
            hit = find_bits(entry, suite, (bits[0], bits[1]))
    if hit is not None:
        fap = difference.fap if difference is not None else None
        evidence |= excerpt((suite / entry.file).read_bytes(), hit, fap)
    if entry.media in DOCUMENTS:
        evidence |= document_evidence(entry, suite, difference, str(expected.get("path") or got.get("path") or ""))
    own = trace_file(traces, adapter.name, entry.id)
    if own is not None:
        evidence["divergence"] = divergence(entry, suite, own)
    return Findings(hit.location if hit is not None else None, expected, got, evidence)


def _expected(entry: Entry) -> dict[str, Any]:
    expect = entry.expect
    if isinstance(expect, Rejected):
        return {"outcome": "rejected", **expect.as_json()["reject"]}
    return {"outcome": "accepted"}


def _said(outcome: Outcome) -> dict[str, Any]:
    """How it ended, and what of the JSON line on standard error has a form that can be shown."""
    out: dict[str, Any] = {"outcome": _end(outcome)}
    line = said(outcome.stderr)
    if isinstance(line.get("class"), str):
        out["class"] = line["class"][:100]
    try:
        bits = span(line)
    except Malformed:
        bits = None
    if bits is not None and 0 <= bits[0] <= bits[1] < 1 << 62:
        out["bits"] = list(bits)
    if isinstance(line.get("path"), str):
        out["path"] = line["path"][:1000]
    if type(line.get("line")) is int:
        out["line"] = line["line"]
    words = outcome.stderr.decode("utf-8", "replace").strip()
    if words:
        out["stderr"] = words[-STDERR:]
    return out


def _end(outcome: Outcome) -> str:
    if outcome.stopped:
        return outcome.stopped
    if outcome.code is None:
        return outcome.detail or "no exit code"
    return {0: "accepted", 1: "rejected"}.get(outcome.code, f"exit code {outcome.code}")
