"""Running decoders over a suite.

Rules: CNF-13, CNF-15, CNF-17, CNF-19, CNF-20 (local cores). Not here: ledger, shards, clusters, resuming.
"""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path, PurePosixPath

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import SUITE, Accepted, Entry, Expect, Manifest

from .adapters import Adapter, BuiltIn
from .compare import BAD, Verdict, judge
from .differences import Difference
from .where import Location, locate

GOOD = 0
FAILURE = 1
ADAPTER_FAULT = 5


@dataclass(frozen=True, slots=True)
class Result:
    """One vector with one decoder. Rules: CNF-15, CNF-17. `reproduce`: the command that does it again."""

    adapter: str
    vector: str
    title: str
    tier: str
    kind: str
    rules: tuple[str, ...]
    status: str
    reason: str
    reading: str
    seconds: float
    difference: Difference | None
    location: Location | None
    reproduce: str


@dataclass(frozen=True, slots=True)
class Report:
    """A whole run. Rules: CNF-15, CNF-19. `suite`: its version; `adapters`: names in order; `filter`: as given."""

    suite: str
    filter: str
    adapters: tuple[str, ...]
    results: tuple[Result, ...]

    def counts(self, adapter: str) -> dict[str, int]:
        """Status -> number of vectors, of one decoder."""
        return dict(Counter(result.status for result in self.results if result.adapter == adapter))

    def passed(self, adapter: str) -> bool:
        """Whether the verdict is pass: at least one pass, and nothing bad. Rules: CNF-15."""
        counts = self.counts(adapter)
        return counts.get("pass", 0) > 0 and not any(counts.get(status, 0) for status in BAD)

    @property
    def exit_code(self) -> int:
        """0 where all pass; 5 where adapters are at fault and nothing else is; else 1. Rules: CNF-15, CNF-19."""
        if self.adapters and all(self.passed(adapter) for adapter in self.adapters):
            return GOOD
        bad = {result.status for result in self.results if result.status in BAD}
        return ADAPTER_FAULT if bad == {"error"} else FAILURE


def verify(entries: Iterable[Entry], suite: Path) -> None:
    """Hold the files of a suite against their checksums. Rules: CNF-3. Raises InputFormat for one that differs."""
    for entry in entries:
        expects: list[Expect] = [entry.expect, *(e for readings in entry.readings.values() for e in readings.values())]
        files = {entry.file: entry.sha256} | ({entry.aux: entry.aux_sha256} if entry.aux else {})
        files |= {e.file: e.sha256 for e in expects if isinstance(e, Accepted)}
        for name, checksum in files.items():
            path = suite / name
            # By its name alone: in a tree of links (an editable install) every file really lies elsewhere.
            if not _inside(name) or not path.is_file():
                raise InputFormat("CNF-3", f"{entry.id}: file", value=name, allowed="a file of the suite")
            if sha256(path.read_bytes()).hexdigest() != checksum:
                raise InputFormat("CNF-3", f"{entry.id}: {name}", value="another content", allowed=f"sha256 {checksum}")


def _inside(name: str) -> bool:
    path = PurePosixPath(name)
    return not path.is_absolute() and ".." not in path.parts


def run(
    manifest: Manifest,
    adapters: Sequence[Adapter],
    *,
    suite: Path = SUITE,
    select: Callable[[Entry], bool] = lambda entry: True,
    filter: str = "",
    jobs: int = 1,
    progress: Callable[[Result], None] | None = None,
) -> Report:
    """Run decoders over the selected vectors; results stand in the order of the adapters and the manifest.

    Rules: CNF-15, CNF-20. Raises InputFormat for a suite whose files are not those of its
    manifest, and for two adapters of one name.
    """
    names = [adapter.name for adapter in adapters]
    for name in names:
        if names.count(name) > 1:
            raise InputFormat(
                "CNF-15", "adapter name", value=name, allowed="a name that no other adapter of the run has"
            )
    entries = [entry for entry in manifest.entries if select(entry)]
    verify(entries, suite)

    def one(task: tuple[Adapter, Entry]) -> Result:
        result = _one(task[0], task[1], suite)
        if progress is not None:
            progress(result)
        return result

    tasks = [(adapter, entry) for adapter in adapters for entry in entries]
    try:
        # Threads wait for processes; the built-in decoder would only wait for itself.
        if jobs > 1 and any(not isinstance(adapter, BuiltIn) for adapter in adapters):
            with ThreadPoolExecutor(jobs) as pool:
                results = list(pool.map(one, tasks))
        else:
            results = [one(task) for task in tasks]
    finally:
        for adapter in adapters:
            adapter.close()
    return Report(manifest.suite, filter, tuple(adapter.name for adapter in adapters), tuple(results))


def _one(adapter: Adapter, entry: Entry, suite: Path) -> Result:
    lacks = adapter.lacks(entry)
    seconds = 0.0
    if lacks:
        verdict = Verdict("not_applicable", f"not claimed: {lacks}")
    else:
        outcome = adapter.decode(entry, suite / entry.file, suite / entry.aux if entry.aux else None)
        seconds = outcome.seconds
        verdict = judge(entry, outcome, suite, adapter.format)
    location: Location | None = None
    if verdict.difference is not None:
        location = locate(entry, suite, verdict.difference, fap_frames=adapter.format == "fap")
    return Result(
        adapter.name, entry.id, entry.title, entry.tier, entry.kind, entry.rules, verdict.status, verdict.reason,
        verdict.reading, seconds, verdict.difference, location, _reproduce(adapter, entry, suite),
    )  # fmt: skip


def _reproduce(adapter: Adapter, entry: Entry, suite: Path) -> str:
    words = ["snhc run"]
    if adapter.reproduce:
        words.append(adapter.reproduce)
    if suite != SUITE:
        words.append(f"--suite {shlex.quote(str(suite))}")
    return " ".join([*words, f"--filter {entry.id}"])
