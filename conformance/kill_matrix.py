"""The engine of the kill matrix: every mutant against the vectors, judged as any decoder is.

Rules: CNF-8, CNF-14, CNF-15, CNF-16.

A mutant is killed by a vector where the mutated decoder does not pass (`fail`, `crash`, `timeout`): the comparators
decide (`compare.judge`), with the decoder restored, since they ask it. It is told apart where it passes, but the report
of a run says more than that: it follows another reading of an ambiguity (`reading`), or goes on behind a fault where
that is allowed (`concealed`). A mutant that is about findings is killed where the findings that a recipe declares are
not those that are reported.

Workers are processes in the pure form (SNHC_PURE=1). Each vector has a limit of processor time, each worker one of
memory; a worker that does not answer at all is killed and replaced.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from types import CodeType, FrameType
from typing import Any, Final

from snhc.vectors.decoding import Decoded, decode_input
from snhc.vectors.manifest import SUITE, Entry, Manifest, load
from snhc.vectors.mutants.matrix import HOW, KILLED, Line, Matrix
from snhc.vectors.mutants.mutant import Edit, Mutant, MutantFault
from snhc.vectors.mutants.patching import ROOT, applied, forget

from .adapters import Outcome
from .adapters.builtin import outcome_of
from .compare import judge

SECONDS: Final = 1.0
"""Processor time of a vector, at least; slow vectors have `SLOWER` times what they need without a mutant."""
SLOWER: Final = 10.0
SILENCE: Final = 120.0
"""Wall-clock seconds without a sign after which a worker is killed."""
MEMORY: Final = 2 << 30
# A mutant that hangs on so many vectors will hang on the others too.
TIMEOUTS: Final = 3
_CHUNK: Final = 64


@dataclass(frozen=True, slots=True)
class Kill:
    """One vector that kills a mutant. Rules: CNF-8. `how`: one of `matrix.HOW`; `reason`: in words."""

    vector: str
    how: str
    reason: str


@dataclass(frozen=True, slots=True)
class Found:
    """What became of one mutant. Rules: CNF-8. `kills`: in the order in which they were found."""

    mutant: str
    kills: tuple[Kill, ...]
    seconds: float


class _TimeUp(BaseException):
    """The processor time of a vector is used up; no `except Exception` of the decoder may catch it."""


def relevant_first(mutant: Mutant, entries: Iterable[Entry], seconds: dict[str, float]) -> list[str]:
    """Vector ids in the order in which a mutant meets them: those of its rules, then the others; slow ones last.

    Rules: CNF-8. `seconds`: what each vector needs without a mutant.
    """
    rules = set(mutant.rules)

    def key(entry: Entry) -> tuple[bool, bool, bool, str]:
        tagged = bool(rules & set(entry.rules))
        # Of two that are tagged alike, one about nothing else says more.
        return not tagged, seconds.get(entry.id, 0.0) > 0.1, not rules >= set(entry.rules), entry.id

    return [entry.id for entry in sorted(entries, key=key)]


# -- in the worker -----------------------------------------------------------------------------------------------------


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    def up(number: int, frame: FrameType | None) -> None:
        raise _TimeUp

    before = signal.signal(signal.SIGVTALRM, up)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


@dataclass(frozen=True, slots=True)
class _Got:
    outcome: Outcome
    findings: tuple[str, ...] = ()

    def same(self, other: _Got, findings: bool) -> bool:
        if findings:
            return self.findings == other.findings
        a, b = self.outcome, other.outcome
        return (a.code, a.stdout, a.stderr, a.stopped) == (b.code, b.stdout, b.stderr, b.stopped)


class Bench:
    """The vectors of a suite in memory, and what the decoder makes of them without a mutant.

    Rules: CNF-8. Raises MutantFault where the decoder fails its own suite: nothing could be learnt then.
    """

    def __init__(self, suite: Path = SUITE, only: Callable[[Entry], bool] = lambda entry: True) -> None:
        self.suite = suite
        self.manifest: Manifest = load(suite, check_schema=False)
        self.entries = {entry.id: entry for entry in self.manifest.entries if only(entry)}
        self._data = {
            id: ((suite / entry.file).read_bytes(), (suite / entry.aux).read_bytes() if entry.aux else None)
            for id, entry in self.entries.items()
        }
        self.seconds: dict[str, float] = {}
        self._clean: dict[str, _Got] = {}
        self._readings: dict[str, str] = {}
        self._declared: dict[str, tuple[str, ...]] | None = None
        for id, entry in self.entries.items():
            self.decode(id)  # loads what is loaded once
            started = time.process_time()
            self._clean[id] = self.decode(id)
            self.seconds[id] = time.process_time() - started
            verdict = judge(entry, self._clean[id].outcome, suite, "ndjson")
            if verdict.status not in ("pass", "not_applicable"):
                raise MutantFault(f"without any mutant the decoder fails {id}: {verdict.reason}")
            self._readings[id] = verdict.reading

    def decode(self, id: str) -> _Got:
        """What the decoder, as it is now, makes of a vector. Rules: CNF-8, CNF-9."""
        entry = self.entries[id]
        data, aux = self._data[id]
        try:
            decoded: Decoded = decode_input(entry.media, data, aux, entry.options.for_decoder())
        except Exception as error:  # noqa: BLE001 (that it falls over is the result)
            return _Got(Outcome(None, detail=f"{type(error).__name__}: {error}"[:200]))
        return _Got(outcome_of(decoded), tuple(finding.id for finding in decoded.findings))

    def reach(self) -> dict[str, frozenset[str]]:
        """The functions of the decoder that each vector enters, as targets of edits, with nothing kept from before.

        Rules: CNF-8. A mutant that edits no function of these cannot change what the decoder makes of the vector.
        """
        out: dict[str, frozenset[str]] = {}
        for id in self.entries:
            codes: dict[CodeType, str] = {}

            def entered(frame: FrameType, event: str, argument: object, codes: dict[CodeType, str] = codes) -> None:
                if event == "call" and frame.f_code not in codes:
                    codes[frame.f_code] = frame.f_globals.get("__name__", "")

            forget()
            before = sys.getprofile()
            sys.setprofile(entered)
            try:
                self.decode(id)
            finally:
                sys.setprofile(before)
            out[id] = frozenset(
                f"{module.removeprefix(ROOT + '.')}:{code.co_qualname}"
                for code, module in codes.items()
                if module.startswith(f"{ROOT}.")
            )
        return out

    def _mutated(self, id: str) -> _Got:
        try:
            with _limited(max(SECONDS, SLOWER * self.seconds[id])):
                return self.decode(id)
        except _TimeUp:
            return _Got(Outcome(None, stopped="timeout"))

    def run(
        self, mutant: Mutant, order: Sequence[str], stop: bool, at: Callable[[str], None] = lambda id: None
    ) -> list[Kill]:
        """The vectors that kill a mutant, in the order given; with `stop` the first only. Rules: CNF-8."""
        kills: list[Kill] = []
        timeouts = 0
        if mutant.findings:
            order = [id for id in order if id in self._declarations()]
        # The first vector alone: it is the one that is known, or thought, to kill.
        for first, end in pairwise([0, *range(1, len(order), _CHUNK), len(order)]):
            different: list[tuple[str, _Got]] = []
            with applied(mutant):
                for id in order[first:end]:
                    at(id)
                    got = self._mutated(id)
                    if not got.same(self._clean[id], mutant.findings):
                        different.append((id, got))
                    if got.outcome.stopped:
                        timeouts += 1
                        if timeouts == TIMEOUTS:
                            break
            for id, got in different:
                kill = self._judged(mutant, id, got)
                if kill is not None:
                    kills.append(kill)
                    if stop and kill.how in KILLED:
                        return kills
            if timeouts == TIMEOUTS:
                break
        return kills

    def _judged(self, mutant: Mutant, id: str, got: _Got) -> Kill | None:
        if got.outcome.stopped:
            return Kill(id, "timeout", got.outcome.detail or "no end")
        if mutant.findings:
            wanted = self._declarations()[id]
            given = tuple(finding for finding in got.findings if finding != "no-sequence-header")
            if got.outcome.code is None:
                return Kill(id, "crash", got.outcome.detail)
            return Kill(id, "fail", f"findings {given}, declared {wanted}") if given != wanted else None
        verdict = judge(self.entries[id], got.outcome, self.suite, "ndjson")
        if verdict.status in ("pass", "not_applicable"):
            if verdict.status == "pass" and verdict.reading != self._readings[id]:
                return Kill(id, "reading", f"follows {verdict.reading}")
            if verdict.reason == "concealed":
                return Kill(id, "concealed", "goes on behind the fault")
            return None
        return Kill(id, verdict.status if verdict.status in HOW else "fail", verdict.reason)

    def _declarations(self) -> dict[str, tuple[str, ...]]:
        """The findings that recipes declare, by vector."""
        if self._declared is None:
            from snhc.vectors.recipe import Accept, Ambiguous, all_recipes

            builds = {id: recipe.build() for id, recipe in all_recipes().items() if id in self.entries}
            self._declared = {
                id: build.findings
                for id, build in builds.items()
                if isinstance(build, Accept | Ambiguous) and build.findings is not None
            }
        return self._declared


def _work(connection: Connection, suite: str) -> None:
    """A worker: mutants in, `Found` out, and the id of each vector as a sign of life."""
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    # Who stops the run is the parent; it kills its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        bench = Bench(Path(suite))
    except MutantFault as fault:
        connection.send(fault)
        return
    connection.send(bench.seconds)
    while True:
        task = connection.recv()
        if task is None:
            connection.send(bench.reach())
            continue
        mutant, order, stop = task
        started = time.monotonic()
        try:
            kills = bench.run(mutant, order, stop, connection.send)
        except MutantFault as fault:
            connection.send(fault)
        else:
            connection.send(Found(mutant.id, tuple(kills), time.monotonic() - started))


# -- in the parent -----------------------------------------------------------------------------------------------------


class _Worker:
    """A process that tries mutants, as the parent holds it."""

    def __init__(self, suite: Path) -> None:
        self._suite = suite
        self._start()

    def _start(self) -> None:
        context = get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, str(self._suite)), daemon=True)
        self._process.start()
        theirs.close()
        self.seconds: dict[str, float] = self._answer()

    def _answer(self) -> Any:
        if not self._connection.poll(SILENCE):
            raise TimeoutError
        answer = self._connection.recv()
        if isinstance(answer, MutantFault):
            raise answer
        return answer

    def run(self, mutant: Mutant, order: Sequence[str], stop: bool) -> Found:
        """Try one mutant; what kills the worker counts as a timeout of the vector it was at."""
        left = list(order)
        kills: list[Kill] = []
        started = time.monotonic()
        while True:
            now = ""
            try:
                self._connection.send((mutant, left, stop))
                while isinstance(answer := self._answer(), str):
                    now = answer
            except (OSError, EOFError):
                self.close()
                self._start()
                if not now:
                    raise MutantFault(f"{mutant.id}: the worker ended before its first vector") from None
                kills.append(Kill(now, "timeout", "the process had to be killed"))
                # What the process had found went with it: all others are asked again.
                left = [id for id in left if id != now]
                if stop or len(kills) == TIMEOUTS or not left:
                    return Found(mutant.id, tuple(kills), time.monotonic() - started)
                continue
            found: Found = answer
            return Found(mutant.id, (*kills, *found.kills), time.monotonic() - started)

    def reach(self) -> dict[str, frozenset[str]]:
        """As `Bench.reach`."""
        self._connection.send(None)
        answer: dict[str, frozenset[str]] = self._answer()
        return answer

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()
        self._connection.close()


@contextmanager
def _pure() -> Iterator[None]:
    """Processes started in this block run the decoder in its pure form."""
    before = os.environ.get("SNHC_PURE")
    os.environ["SNHC_PURE"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["SNHC_PURE"]
        else:
            os.environ["SNHC_PURE"] = before


def run_mutants(
    mutants: Sequence[Mutant],
    *,
    suite: Path = SUITE,
    stop: bool = False,
    jobs: int = 2,
    first: Callable[[Mutant], Sequence[str]] = lambda mutant: (),
    progress: Callable[[Found], None] | None = None,
) -> list[Found]:
    """Try mutants against a suite; results in the order given.

    Rules: CNF-8. `stop`: each only up to its first killer. `jobs`: processes. `first`: vectors that a mutant is to meet
    before all others. Raises MutantFault for a mutant that does not fit the decoder.
    """
    entries = load(suite, check_schema=False).entries
    there = {entry.id for entry in entries}
    reach: dict[str, frozenset[str]] = {}
    free: SimpleQueue[_Worker] = SimpleQueue()
    workers: list[_Worker] = []

    def one(mutant: Mutant) -> Found:
        worker = free.get()
        try:
            order = relevant_first(mutant, entries, workers[0].seconds)
            lead = [id for id in first(mutant) if id in there]
            order = [*lead, *(id for id in order if id not in lead)]
            targets = {change.target for change in mutant.changes if isinstance(change, Edit)}
            if reach and len(targets) == len({change.target for change in mutant.changes}):
                order = [id for id in order if targets & reach[id]]
            found = worker.run(mutant, order, stop)
        finally:
            free.put(worker)
        if progress is not None:
            progress(found)
        return found

    with _pure():
        try:
            with ThreadPoolExecutor(jobs) as pool:
                for worker in pool.map(_Worker, [suite] * min(jobs, len(mutants))):
                    workers.append(worker)
                    free.put(worker)
                if not stop:
                    reach.update(workers[0].reach())
                return list(pool.map(one, mutants))
        finally:
            for worker in workers:
                worker.close()


def kill_matrix(
    mutants: Sequence[Mutant],
    *,
    suite: Path = SUITE,
    stop: bool = False,
    jobs: int = 2,
    progress: Callable[[Found], None] | None = None,
) -> Matrix:
    """The matrix of mutants and vectors. Rules: CNF-8. Arguments and errors as `run_mutants`."""
    manifest = load(suite, check_schema=False)
    found = run_mutants(mutants, suite=suite, stop=stop, jobs=jobs, progress=progress)
    lines = []
    for mutant, one in zip(mutants, found, strict=True):
        kills: dict[str, list[str]] = {}
        for kill in one.kills:
            kills.setdefault(kill.how, []).append(kill.vector)
        lines.append(Line.of(mutant, one.kills[0].vector if one.kills else "", kills))
    return Matrix(manifest.suite, tuple(entry.id for entry in manifest.entries), not stop, tuple(lines))
