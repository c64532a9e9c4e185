"""Running decoders over a suite.

Rules: CNF-13, CNF-15, CNF-17, CNF-19, CNF-20. How cases are spread, and what keeps them, is in `running`; the ledger of
known failures in `ledger`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from hashlib import sha256
from pathlib import Path

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import MANIFEST_NAME, SUITE, Entry, Manifest, read_files

from .adapters import Adapter
from .ledger import Ledger
from .results import Report, Result, Shards
from .running.case import Case
from .running.journal import Journal, identity
from .running.local import run_local
from .running.shards import Shard


def verify(entries: Iterable[Entry], suite: Path) -> None:
    """Hold the files of a suite against their checksums. Rules: CNF-3. Raises InputFormat for one that differs."""
    for entry in entries:
        read_files(entry, suite)


def files_of(entry: Entry) -> dict[str, str]:
    """The files of a vector, relative to the suite, and their sha256. Rules: CNF-3."""
    return entry.files()


@dataclass(frozen=True, slots=True)
class Progress:
    """What `run` tells while it runs. Rules: CNF-18, CNF-20. `done`: of `total`, those of a journal counted."""

    done: int
    total: int
    result: Result | None = None


def run(
    manifest: Manifest,
    adapters: Sequence[Adapter],
    *,
    suite: Path = SUITE,
    select: Callable[[Entry], bool] = lambda entry: True,
    filter: str = "",
    jobs: int = 1,
    shard: Shard | None = None,
    cluster: str | None = None,
    journal: Path | None = None,
    resume: bool = False,
    ledger: Ledger | None = None,
    today: date | None = None,
    traces: Path | None = None,
    words: str = "",
    progress: Callable[[Progress], None] | None = None,
) -> Report:
    """Run decoders over the selected vectors; results stand in the order of the adapters and the manifest.

    Rules: CNF-15, CNF-20. `shard`: only this part of the selection. `cluster`: address of a Dask scheduler, instead of
    `jobs` at the same time here. `journal`: a file that keeps the results as they come, and is gone when all are there;
    `resume`: those that stand in it are not run again. `ledger`: known failures, as of `today`. `traces`: a folder with
    the decoders' own traces, `VECTOR.json` or `ADAPTER/VECTOR.json`. `words`: as in `Case`.

    Raises InputFormat for a suite whose files are not those of its manifest, for two adapters of one name, and for the
    journal of another run.
    """
    names = [adapter.name for adapter in adapters]
    for name in names:
        if names.count(name) > 1:
            raise InputFormat(
                "CNF-15", "adapter name", value=name, allowed="a name that no other adapter of the run has"
            )
    entries = [entry for entry in manifest.entries if select(entry)]
    if shard is not None:
        entries = shard.of(entries)
    verify(entries, suite)
    digest = _digest(manifest, suite)
    cases = [Case(adapter, entry, words) for adapter in adapters for entry in entries]
    kept: Journal | None = None
    if journal is not None:
        run_id = identity(
            manifest.suite, digest, filter, str(shard or ""), [entry.id for entry in entries], list(adapters)
        )
        kept = Journal(journal, run_id, resume=resume)
    try:
        results = dict(kept.done) if kept is not None else {}
        left = [case for case in cases if case.key not in results]
        if progress is not None:
            progress(Progress(len(results), len(cases)))
        for result in _results(left, suite, jobs, cluster, traces):
            if result.key in results:
                raise AssertionError(f"{result.key} was run twice")
            results[result.key] = result
            if kept is not None:
                kept.add(result)
            if progress is not None:
                progress(Progress(len(results), len(cases), result))
    finally:
        for adapter in adapters:
            adapter.close()
        if kept is not None:
            kept.close()
    report = Report(
        manifest.suite, filter, tuple(names), tuple(results[case.key] for case in cases), digest,
        {} if shard is None else {name: Shards(shard.count, (shard.number,)) for name in names},
    )  # fmt: skip
    if ledger is None:
        return report
    return ledger.apply(report, [entry.id for entry in manifest.entries], today or date.today())


def _results(
    cases: Sequence[Case], suite: Path, jobs: int, cluster: str | None, traces: Path | None
) -> Iterator[Result]:
    if cluster is None:
        yield from run_local(cases, suite, jobs, traces)
    elif cases:
        from .running.cluster import run_cluster

        yield from run_cluster(cases, suite, cluster, traces)


def _digest(manifest: Manifest, suite: Path) -> str:
    """What tells one suite from another of the same version: the sha256 of its manifest."""
    path = suite / MANIFEST_NAME
    data = path.read_bytes() if path.is_file() else manifest.text().encode()
    return sha256(data).hexdigest()
