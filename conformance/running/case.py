"""One case: a decoder, a vector, and what came of it.

Rules: CNF-13, CNF-15, CNF-17.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from snhc.conformance.adapters import Adapter
from snhc.conformance.compare import BAD, Verdict, judge
from snhc.conformance.results import Result
from snhc.conformance.where import Findings, examine
from snhc.vectors.manifest import SUITE, Entry


@dataclass(frozen=True, slots=True)
class Case:
    """A decoder and a vector. Rules: CNF-15. It can be pickled, if the adapter can.

    `words`: what else of the command line the decoder was told, for the command that does it again.
    """

    adapter: Adapter
    entry: Entry
    words: str = ""

    @property
    def key(self) -> tuple[str, str]:
        """Names of both: what makes a case, and its result, one of its kind."""
        return self.adapter.name, self.entry.id


def run_case(case: Case, suite: Path, traces: Path | None = None, shown: Path | None = None) -> Result:
    """Ask the decoder, judge what it did, and look for the place where it went wrong. Rules: CNF-13, CNF-15, CNF-17.

    `traces`: a folder with the decoder's own traces. `shown`: the suite that the command which does it again names, if
    it is not `suite`.
    """
    adapter, entry = case.adapter, case.entry
    lacks = adapter.lacks(entry)
    if lacks:
        return _result(case, Verdict("not_applicable", f"not claimed: {lacks}"), 0.0, Findings(), shown or suite)
    outcome = adapter.decode(entry, suite / entry.file, suite / entry.aux if entry.aux else None)
    verdict = judge(entry, outcome, suite, adapter.format)
    found = Findings()
    if verdict.status in BAD:
        found = examine(entry, suite, adapter, outcome, verdict, traces)
    return _result(case, verdict, round(outcome.seconds, 6), found, shown or suite)


def broken_case(case: Case, suite: Path, reason: str) -> Result:
    """The result of a case whose worker died: a crash. Rules: CNF-15, CNF-20."""
    return _result(case, Verdict("crash", reason), 0.0, Findings(), suite)


def _result(case: Case, verdict: Verdict, seconds: float, found: Findings, suite: Path) -> Result:
    entry = case.entry
    return Result(
        case.adapter.name, entry.id, entry.title, entry.tier, entry.kind, entry.file, entry.tools, entry.rules,
        verdict.status, verdict.reason, verdict.reading, seconds, verdict.difference, found.location,
        reproduce(case, suite), found.expected, found.got, found.evidence,
    )  # fmt: skip


def reproduce(case: Case, suite: Path) -> str:
    """The command that runs one vector again. Rules: CNF-17."""
    words = ["snhc run", *filter(None, (case.adapter.reproduce, case.words))]
    if suite != SUITE:
        words.append(f"--suite {shlex.quote(str(suite))}")
    return " ".join([*words, f"--filter {case.entry.id}"])
