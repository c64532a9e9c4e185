"""The driver: passes over an input until none of them makes it smaller, or the budget is spent.

Rules: CNF-17.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from snhc.conformance.adapters import Adapter, Outcome
from snhc.conformance.compare import Verdict
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import DOCUMENTS, Entry

from . import documents, raw, streams
from .target import Signature, Subject, Target

RUNS: Final = 1000
SECONDS: Final = 300.0


@dataclass(frozen=True, slots=True)
class Budget:
    """What minimising may cost. Rules: CNF-17. `runs`: of the candidate; `seconds`: of time, None for any."""

    runs: int = RUNS
    seconds: float | None = SECONDS


@dataclass(frozen=True, slots=True)
class Minimized:
    """The result.

    Rules: CNF-17. `complete`: no pass makes it smaller; else the budget was spent, or an
    `interrupt` came. `entry`: the vector made of it, in the folder that was given.
    """

    data: bytes
    aux: bytes | None
    signature: Signature
    verdict: Verdict
    outcome: Outcome
    entry: Entry
    runs: int
    complete: bool
    interrupt: KeyboardInterrupt | None = None


class Spent(Exception):
    """The budget is spent: the smallest input so far stands. Rules: CNF-17."""


class Shrinker:
    """The smallest failing input so far, and the test that a smaller one has to pass. Rules: CNF-17."""

    def __init__(
        self,
        target: Target,
        subject: Subject,
        wanted: Signature,
        budget: Budget,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        self.data = subject.data
        self.aux = subject.aux
        self.entry = subject.entry
        self._target = target
        self._wanted = wanted
        self._budget = budget
        self._progress = progress
        self._started = time.monotonic()

    @property
    def rejected(self) -> bool:
        """Whether the reference rejects it."""
        return self._wanted.reference != "accepted"

    def takes(self, data: bytes | None, aux: bytes | None = None) -> bool:
        """Whether an input fails in the same way; if so it is the one to go on with. None: it could not be written.

        Raises Spent.
        """
        if data is None:
            return False
        aux = self.aux if aux is None else aux
        if (data, aux) == (self.data, self.aux):
            return True
        budget = self._budget
        if self._target.runs >= budget.runs or (
            budget.seconds is not None and time.monotonic() - self._started > budget.seconds
        ):
            raise Spent
        if self._target.signature(data, aux, self._wanted.reference) != self._wanted:
            return False
        self.data, self.aux = data, aux
        if self._progress is not None:
            self._progress(self._target.runs, len(data) + len(aux or b""))
        return True


def minimize(
    adapter: Adapter,
    subject: Subject,
    folder: Path,
    budget: Budget | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Minimized:
    """Shrink an input on which a decoder fails.

    Rules: CNF-17. Deterministic, unless the time of the budget ends it. `folder`: where the inputs of the candidate
    are written. `progress`: is told the runs and the size in bytes. An interrupt ends it with the
    smallest input so far, if there is a smaller one. Raises InputFormat where the decoder does not fail.
    """
    target = Target(adapter, subject, folder)
    wanted = target.signature(subject.data, subject.aux)
    if wanted is None:
        verdict, _, _ = target.ask(subject.data, subject.aux)
        words = f"{verdict.status}: {verdict.reason}" if verdict.reason else verdict.status
        raise InputFormat("CNF-17", subject.entry.id, value=words, allowed=f"an input on which {adapter.name} fails")
    shrinker = Shrinker(target, subject, wanted, budget or Budget(), progress)
    complete = True
    interrupt: KeyboardInterrupt | None = None
    try:
        while True:
            before = (shrinker.data, shrinker.aux)
            if subject.entry.media in DOCUMENTS:
                documents.shrink(shrinker)
            elif not shrinker.rejected:
                streams.shrink(shrinker)
            else:
                raw.shrink(shrinker)
            if (shrinker.data, shrinker.aux) == before:
                break
    except Spent:
        complete = False
    except KeyboardInterrupt as error:
        if (shrinker.data, shrinker.aux) == (subject.data, subject.aux):
            raise
        # What has been found so far is worth more than nothing; whoever called decides when to go.
        complete, interrupt = False, error
    verdict, outcome, entry = target.ask(shrinker.data, shrinker.aux)
    return Minimized(
        shrinker.data, shrinker.aux, wanted, verdict, outcome, entry, target.runs, complete, interrupt
    )  # fmt: skip
