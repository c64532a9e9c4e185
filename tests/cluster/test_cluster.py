"""Cases on a Dask cluster: a real one, one of whose two workers is killed during the run.

Rules: CNF-20.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from distributed import LocalCluster

from snhc.conformance.adapters import BuiltIn, OneShot, Outcome
from snhc.conformance.cli.run import command
from snhc.conformance.filters import selector
from snhc.conformance.runner import Progress, run
from snhc.vectors.manifest import Entry, load

HARNESS = Path(__file__).parent.parent / "harness"
MANIFEST = load(check_schema=False)


@pytest.fixture
def cluster() -> Iterator[LocalCluster]:
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as one:
        yield one


@dataclass(frozen=True, slots=True)
class Slow(BuiltIn):
    """Leaves time for a kill."""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        time.sleep(0.05)
        return BuiltIn.decode(self, entry, path, aux)


def test_a_worker_is_killed_and_nothing_is_lost_or_counted_twice(cluster: LocalCluster) -> None:
    select = selector("fap.*|fba.error.*")
    whole = run(MANIFEST, [BuiltIn()], select=select)
    victim = next(iter(cluster.workers.values())).process.pid
    seen: Counter[tuple[str, str]] = Counter()
    killed = []

    def progress(now: Progress) -> None:
        if now.result is not None:
            seen[now.result.key] += 1
        if now.done == 20:
            os.kill(victim, signal.SIGKILL)
            killed.append(victim)

    report = run(MANIFEST, [Slow()], select=select, cluster=cluster.scheduler_address, progress=progress)
    assert killed and len(report.results) > 60
    assert set(seen.values()) == {1}
    assert [replace(r, seconds=0.0) for r in report.results] == [replace(r, seconds=0.0) for r in whole.results]


def test_programs_run_on_workers_and_commands_name_the_suite_at_home(cluster: LocalCluster) -> None:
    program = OneShot("wrong", (sys.executable, str(HARNESS / "wrong_value.py"), "{input}"), timeout=20.0)
    select = selector("fap.arith.example.*")
    there = run(MANIFEST, [program], select=select, cluster=cluster.scheduler_address)
    here = run(MANIFEST, [program], select=select)
    assert [replace(r, seconds=0.0) for r in there.results] == [replace(r, seconds=0.0) for r in here.results]
    assert {r.status for r in there.results} == {"fail"} and all(r.evidence for r in there.results)


@dataclass(frozen=True, slots=True)
class Deadly(BuiltIn):
    """Takes every worker down on one vector."""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        if entry.id == "fap.arith.example.1":
            # Others are sent after it meanwhile.
            time.sleep(0.5)
            os.kill(os.getpid(), signal.SIGKILL)
        return BuiltIn.decode(self, entry, path, aux)


def test_a_case_that_outlives_no_worker_is_a_crash(cluster: LocalCluster) -> None:
    report = run(MANIFEST, [Deadly()], select=selector("fap.arith.example.*"), cluster=cluster.scheduler_address)
    assert {r.vector: r.status for r in report.results}["fap.arith.example.1"] == "crash"
    assert Counter(r.status for r in report.results)["pass"] == len(report.results) - 1


def test_what_waits_behind_a_deadly_case_is_not_blamed() -> None:
    """A single worker always has the next case before it when it dies."""
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        report = run(MANIFEST, [Deadly()], select=selector("fap.arith.example.*"), cluster=cluster.scheduler_address)
    assert [r.status for r in report.results] == ["crash", *["pass"] * (len(report.results) - 1)]


def test_a_cluster_whose_workers_are_all_gone_ends_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snhc.conformance.running.cluster.ALONE_SECONDS", 2.0)
    started = time.monotonic()
    journal = tmp_path / "journal"
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:

        def progress(now: Progress) -> None:
            if now.done == 5:
                cluster.scale(0)

        with pytest.raises(OSError, match="has had no worker for 2 s") as caught:
            run(
                MANIFEST, [Slow()], select=selector("fap.*"), cluster=cluster.scheduler_address, progress=progress,
                journal=journal,
            )  # fmt: skip
        assert caught.value.filename == cluster.scheduler_address
    assert time.monotonic() - started < 60
    # What was there is kept.
    assert journal.read_bytes().count(b"\n") >= 6


def test_an_address_that_does_not_answer_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snhc.conformance.running.cluster.CONNECT_SECONDS", 1)
    done = CliRunner().invoke(command, ["--cluster", "tcp://127.0.0.1:1", "--filter", "fap.arith.example.1"])
    assert isinstance(done.exception, OSError) and done.exception.filename == "tcp://127.0.0.1:1"
