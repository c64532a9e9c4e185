"""Spreading and keeping a run: shards, workers, journals, interrupts.

Rules: CNF-15, CNF-19, CNF-20.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from signals import hears_interrupts

from snhc.conformance.adapters import BuiltIn, OneShot, Outcome
from snhc.conformance.filters import selector
from snhc.conformance.reports.merge import merge
from snhc.conformance.results import Report
from snhc.conformance.runner import Progress, run
from snhc.conformance.running.case import Case
from snhc.conformance.running.journal import fingerprint
from snhc.conformance.running.local import run_local
from snhc.conformance.running.shards import Shard, parse_shard
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import SUITE, Entry, Manifest
from snhc.vectors.manifest import load as load_manifest

HARNESS = Path(__file__).parent.parent / "harness"
MANIFEST = load_manifest(check_schema=False)
FEW = "fap.arith.example.*|fba.error.time-code.*"


def decoder(name: str) -> OneShot:
    return OneShot(name, (sys.executable, str(HARNESS / f"{name}.py"), "{input}"), timeout=20.0)


def timeless(report: Report) -> dict[str, Any]:
    document = report.as_json()
    for result in document["results"]:
        result["seconds"] = 0
    return document


# -- shards ------------------------------------------------------------------------------------------------------------


@given(st.lists(st.integers(), max_size=60), st.integers(1, 20))
def test_every_vector_is_in_exactly_one_shard_and_shards_are_balanced(entries: list[int], count: int) -> None:
    numbered = list(enumerate(entries))
    parts = [Shard(i, count).of(numbered) for i in range(1, count + 1)]
    assert sorted(entry for part in parts for entry in part) == numbered
    sizes = [len(part) for part in parts]
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize("text", ["", "1", "0/2", "3/2", "-1/2", "1/2/3", "a/b", "1/0", " 1/2", "1/9999999", "١/٢"])
def test_what_is_no_shard_is_refused(text: str) -> None:
    with pytest.raises(InputFormat):
        parse_shard(text)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_shards_join_to_the_unbroken_run(count: int) -> None:
    adapters = [decoder("wrong_value"), BuiltIn()]
    select = selector(FEW)
    whole = run(MANIFEST, adapters, select=select, filter=FEW, jobs=2)
    parts = [
        run(MANIFEST, adapters, select=select, filter=FEW, jobs=2, shard=Shard(i, count)) for i in range(1, count + 1)
    ]
    assert len(whole.results) > 2 * count
    joined = merge(parts[::-1], [str(i) for i in range(count)])
    assert timeless(joined) == timeless(whole)


def test_a_missing_shard_is_said() -> None:
    part = run(MANIFEST, [BuiltIn()], select=selector(FEW), filter=FEW, shard=Shard(2, 3))
    assert merge([part], ["a"]).shards["snhc"].missing == (1, 3)


# -- workers -----------------------------------------------------------------------------------------------------------


def _cases(adapter: Any, expression: str = FEW) -> list[Case]:
    return [Case(adapter, entry) for entry in MANIFEST.entries if selector(expression)(entry)]


def test_processes_give_what_one_thread_gives() -> None:
    cases = _cases(BuiltIn(), "fap.arith.*")
    alone = {result.key: replace(result, seconds=0.0) for result in run_local(cases, SUITE, 1)}
    spread = list(run_local(cases, SUITE, 2, few=0))
    assert len(spread) == len(cases)
    assert {result.key: replace(result, seconds=0.0) for result in spread} == alone


@dataclass(frozen=True, slots=True)
class Deadly(BuiltIn):
    """Takes its process down with it on one vector."""

    victim: str = ""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        if entry.id == self.victim:
            os._exit(9)
        # Calling super() does not work in a slotted dataclass.
        return BuiltIn.decode(self, entry, path, aux)


def test_a_vector_that_kills_its_worker_is_a_crash_and_nothing_else_is_lost() -> None:
    adapter = Deadly(victim="fap.arith.example.2")
    cases = _cases(adapter)
    results = list(run_local(cases, SUITE, 2, few=0))
    assert sorted(result.vector for result in results) == [case.entry.id for case in cases]
    assert {result.vector: result.status for result in results if result.status != "pass"} == {
        "fap.arith.example.2": "crash"
    }


def test_progress_counts_every_case() -> None:
    seen: list[Progress] = []
    report = run(MANIFEST, [BuiltIn()], select=selector(FEW), progress=seen.append)
    assert [one.done for one in seen] == list(range(len(report.results) + 1))
    assert {one.total for one in seen} == {len(report.results)}


def test_an_empty_selection_fails() -> None:
    report = run(MANIFEST, [BuiltIn()], select=selector("no.such.vector"))
    assert (report.passed("snhc"), report.exit_code) == (False, 1)


# -- journals ----------------------------------------------------------------------------------------------------------


def _run(tmp_path: Path, resume: bool, adapter: Any = None, expression: str = FEW, **more: Any) -> Report:
    return run(
        MANIFEST, [adapter or BuiltIn()], select=selector(expression), filter=expression, resume=resume,
        journal=tmp_path / "j", **more,
    )  # fmt: skip


class Stopped(Exception):
    """In the place of a kill."""


def _stop_after(count: int) -> Any:
    def progress(now: Progress) -> None:
        if now.done >= count:
            raise Stopped

    return progress


def test_what_stands_in_the_journal_is_not_run_again(tmp_path: Path) -> None:
    whole = _run(tmp_path, False)
    (tmp_path / "j").unlink()
    with pytest.raises(Stopped):
        _run(tmp_path, False, progress=_stop_after(3))
    # What a kill leaves of the last line.
    with (tmp_path / "j").open("ab") as file:
        file.write(b'{"adapter": "snhc", "vec')
    seen: list[Progress] = []
    resumed = _run(tmp_path, True, progress=seen.append)
    assert seen[0].done == 3 and timeless(resumed) == timeless(whole)
    assert sum(one.result is not None for one in seen) == len(whole.results) - 3


def test_without_resume_a_run_begins_anew(tmp_path: Path) -> None:
    with pytest.raises(Stopped):
        _run(tmp_path, False, progress=_stop_after(3))
    seen: list[Progress] = []
    _run(tmp_path, False, progress=seen.append)
    assert seen[0].done == 0


def test_evidence_survives_the_journal(tmp_path: Path) -> None:
    adapter = decoder("wrong_value")
    whole = _run(tmp_path, False, adapter)
    assert any(result.evidence for result in whole.results)
    resumed = _run(tmp_path, True, adapter)
    assert json.dumps(resumed.as_json()) == json.dumps(whole.as_json())


@pytest.mark.parametrize("change", ["filter", "shard", "decoder", "suite"])
def test_the_journal_of_another_run_is_refused(tmp_path: Path, change: str) -> None:
    _run(tmp_path, False)
    with pytest.raises(InputFormat, match="journal"):
        if change == "filter":
            _run(tmp_path, True, expression="fap.arith.example.1")
        elif change == "shard":
            _run(tmp_path, True, shard=Shard(1, 2))
        elif change == "decoder":
            _run(tmp_path, True, decoder("correct"))
        else:
            other = Manifest("9.9.9", MANIFEST.entries)
            run(other, [BuiltIn()], select=selector(FEW), filter=FEW, resume=True, journal=tmp_path / "j")


def test_a_program_that_has_changed_is_another_decoder(tmp_path: Path) -> None:
    program = tmp_path / "decoder"
    program.write_text("one")
    adapter = OneShot("x", ("./decoder", "{input}"), folder=tmp_path)
    before = fingerprint(adapter)
    assert fingerprint(adapter) == before
    program.write_text("two")
    assert fingerprint(adapter) != before


@pytest.mark.parametrize(
    "text",
    [
        b"\n", b"[]\n", b"{}\n", b'{"format": "snhc-journal", "version": 2}\n', b"\xff\n",
        # Without a line end, or with a last line that has none: a file that somebody wrote, not what a kill left.
        b"my notes", b"[", b"[1,\n2]", b'{"format": "snhc-report", "version": 1}\n{"a"',
    ],
)  # fmt: skip
def test_what_is_no_journal_is_refused(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "j").write_bytes(text)
    with pytest.raises(InputFormat):
        _run(tmp_path, True)
    assert (tmp_path / "j").read_bytes() == text


@pytest.mark.parametrize("size", [0, 1, 20, 60])
def test_a_journal_that_was_cut_in_its_first_line_begins_anew(tmp_path: Path, size: int) -> None:
    with pytest.raises(Stopped):
        _run(tmp_path, False, progress=_stop_after(1))
    path = tmp_path / "j"
    path.write_bytes(path.read_bytes()[:size])
    assert _run(tmp_path, True).results


def test_a_journal_belongs_to_one_run_at_a_time(tmp_path: Path) -> None:
    def progress(now: Progress) -> None:
        if now.done == 1:
            _run(tmp_path, True)

    with pytest.raises(InputFormat, match="no other run"):
        _run(tmp_path, False, progress=progress)


# -- a real kill -------------------------------------------------------------------------------------------------------

SLOW = """
import os, subprocess, sys, time
time.sleep(0.15)
os.execv(sys.executable, [sys.executable, {harness!r}, *sys.argv[1:]])
"""


def _slow(tmp_path: Path) -> list[str]:
    script = tmp_path / "slow.py"
    script.write_text(SLOW.format(harness=str(HARNESS / "wrong_value.py")))
    adapter = tmp_path / "slow.toml"
    adapter.write_text(f'command = ["{sys.executable}", "slow.py", "{{input}}"]\n')
    return ["run", str(adapter), "--filter", FEW, "-j", "2"]


def _snhc(*words: str, scratch: Path | None = None) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "snhc.conformance.cli", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=hears_interrupts, env={**os.environ, **({} if scratch is None else {"TMPDIR": str(scratch)})},
    )  # fmt: skip


def _wait_for_lines(path: Path, count: int) -> None:
    for _ in range(3000):
        if path.exists() and path.read_bytes().count(b"\n") >= count:
            return
        time.sleep(0.02)
    raise AssertionError("the journal does not grow")


def _document(path: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(path.read_text())
    for result in document["results"]:
        result["seconds"] = 0
    return document


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_killed_run_resumes_to_the_report_of_an_unbroken_one(tmp_path: Path, how: signal.Signals) -> None:
    words = _slow(tmp_path)
    whole, broken = tmp_path / "whole.json", tmp_path / "broken.json"
    unbroken = _snhc(*words, "-o", str(whole))
    unbroken.communicate(timeout=60)
    assert unbroken.returncode == 1
    assert not whole.with_name("whole.json.journal").exists()

    journal = broken.with_name("broken.json.journal")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    process = _snhc(*words, "-o", str(broken), scratch=scratch)
    _wait_for_lines(journal, 4)
    assert list(scratch.iterdir())
    process.send_signal(how)
    _, said = process.communicate(timeout=30)
    done = journal.read_bytes().count(b"\n") - 1
    total = len(_document(whole)["results"])
    assert not broken.exists() and 3 <= done < total
    if how != signal.SIGKILL:
        assert process.returncode == 128 + how
        assert not list(scratch.iterdir())
        assert f"interrupted after {done} of {total}; go on with --resume {journal}" in said.decode()

    again = _snhc(*words, "-o", str(broken), "--resume", str(journal), scratch=scratch)
    again.communicate(timeout=60)
    assert again.returncode == 1 and not journal.exists()
    # What a kill left is gone now too.
    assert not list(scratch.iterdir())
    assert _document(broken) == _document(whole)


def test_a_signal_that_is_ignored_stays_so(tmp_path: Path) -> None:
    def as_by_nohup() -> None:
        hears_interrupts()
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    target = tmp_path / "out.ndjson"
    process = subprocess.Popen(
        [sys.executable, "-m", "snhc.conformance.cli", "decode", "-", "-o", str(target)],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=as_by_nohup,
    )  # fmt: skip
    for _ in range(600):
        if any(tmp_path.iterdir()):
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGHUP)
    process.communicate((SUITE / "fap" / "fap.arith.example.1.fba").read_bytes(), timeout=60)
    assert process.returncode == 0 and target.exists()
