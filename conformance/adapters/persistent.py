"""Persistent adapters: processes that are asked for many vectors, one after another.

Rules: CNF-10, CNF-11, CNF-12, CNF-13, CNF-14, CNF-24.

Every thread that asks gets a process of its own: one that waits, or a new one. Whatever goes wrong is the status of one
vector; its process is then killed, and another one is started for the next. What cannot even be greeted is not started
again and again: every vector gets the same answer.

Decoders in Python (CNF-11) and shared libraries (CNF-12) are asked in the same way: `host.py` speaks for them.
"""

from __future__ import annotations

import contextlib
import json
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from snhc.conformance.process import Surroundings
from snhc.vectors.manifest import TOOLS, Entry

from . import messages
from .base import DEFAULT_TIMEOUT, FORMATS, OPTION_NAMES, REJECTED, Claims, Outcome
from .messages import Message
from .session import Broken, Session

# What the file of a persistent adapter claims that says nothing: whatever the process says.
ANYTHING = Claims(tools=frozenset(TOOLS), options=frozenset(OPTION_NAMES), formats=FORMATS)


@dataclass(slots=True)
class _Pool:
    lock: threading.Lock = field(default_factory=threading.Lock)
    idle: list[tuple[Session, Claims]] = field(default_factory=list)
    # From the first answer to hello on.
    claims: Claims | None = None
    broken: Outcome | None = None


@dataclass(frozen=True, slots=True)
class Persistent:
    """A decoder whose process is asked for many vectors. Rules: CNF-10, CNF-13, CNF-14.

    `claims`: of the adapter file; what the process does not claim too is not claimed. `timeout`: seconds per vector;
    `start_timeout`: to the answer to hello.
    """

    name: str
    command: tuple[str, ...]
    claims: Claims = ANYTHING
    around: Surroundings = field(default_factory=Surroundings)
    timeout: float = DEFAULT_TIMEOUT
    start_timeout: float = DEFAULT_TIMEOUT
    reproduce: str = ""
    _pool: _Pool = field(default_factory=_Pool, repr=False, compare=False)

    def __reduce__(self) -> tuple[type[Persistent], tuple[object, ...]]:
        # Locks and processes stay where they are.
        return Persistent, (
            self.name, self.command, self.claims, self.around, self.timeout, self.start_timeout, self.reproduce,
        )  # fmt: skip

    @property
    def folder(self) -> Path | None:
        """Where relative names in the command lie."""
        return self.around.folder

    @property
    def format(self) -> str:
        """The first of FORMATS that file and process claim."""
        formats = (self._pool.claims or self.claims).formats
        return formats[0] if formats else "ndjson"

    def lacks(self, entry: Entry) -> str:
        """What the file does not claim, nor the process as far as it has been asked."""
        return (self._pool.claims or self.claims).lacks(entry)

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Ask a process; start one if none waits."""
        started = time.monotonic()
        pool = self._pool
        with pool.lock:
            if pool.broken is not None:
                return pool.broken
            waiting = pool.idle.pop() if pool.idle else None
        try:
            session, claims = waiting or self._greeted()
        except Broken as error:
            outcome = Outcome(None, b"", b"", "start", error.detail or error.stopped, time.monotonic() - started)
            with pool.lock:
                # A process that has once been greeted is worth another try.
                if pool.claims is None:
                    pool.broken = outcome
            return outcome
        try:
            lacks = claims.lacks(entry) or claims.exceeded(entry, path, aux)
        except BaseException:
            session.close()
            raise
        if lacks:
            self._back(session, claims)
            return Outcome(None, stopped="unclaimed", detail=lacks)
        started = time.monotonic()
        try:
            answer = session.decode(entry, path, aux, claims.formats[0], self.timeout)
        except Broken as error:
            stderr = session.stderr
            session.close()
            # An end of the process is no way to stop it.
            stopped = "" if error.stopped == "crash" else error.stopped
            return Outcome(None, b"", stderr, stopped, error.detail, time.monotonic() - started)
        except BaseException:
            session.close()
            raise
        seconds = time.monotonic() - started
        stderr = session.stderr
        self._back(session, claims)
        return replace(outcome_of(answer, stderr), seconds=seconds, readings=claims.readings)

    def _greeted(self) -> tuple[Session, Claims]:
        session = Session(self.command, self.around)
        try:
            claims = messages.claims(session.hello(self.claims.readings, self.start_timeout))
            both = self.claims.narrowed(claims)
            if not both.formats:
                raise Broken("protocol", f"it gives {', '.join(claims.formats)}, not {', '.join(self.claims.formats)}")
        except Broken as error:
            tail = session.stderr.decode("utf-8", "replace").strip().splitlines()
            session.close()
            if tail and tail[-1][:200] not in error.detail:
                raise Broken(error.stopped, f"{error.detail}: {tail[-1][:200]}") from error
            raise
        except BaseException:
            session.close()
            raise
        with self._pool.lock:
            self._pool.claims = both
        return session, both

    def _back(self, session: Session, claims: Claims) -> None:
        with self._pool.lock:
            self._pool.idle.append((session, claims))

    def timed(self, seconds: float) -> Self:
        """The same with another time limit, and processes of its own."""
        return replace(self, timeout=seconds, _pool=_Pool())

    def following(self, readings: Mapping[str, str]) -> Self:
        """The same, told by hello; with processes of its own."""
        claims = replace(self.claims, readings={**self.claims.readings, **readings})
        return replace(self, claims=claims, _pool=_Pool())

    def close(self) -> None:
        """Say bye to all processes that wait."""
        with self._pool.lock:
            idle, self._pool.idle = self._pool.idle, []
            self._pool.claims = self._pool.broken = None
        for session, _ in idle:
            # Every vector has had its answer: how a process leaves changes nothing any more (`doctor` looks at it).
            with contextlib.suppress(Broken):
                session.bye()
            session.close()


def outcome_of(answer: Message, stderr: bytes) -> Outcome:
    """What an answer to `decode` means. Rules: CNF-9, CNF-10."""
    try:
        # A host hands on bytes that are no UTF-8 as they are.
        output = answer.get("output", "").encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        return Outcome(None, stopped="protocol", detail="output is no text: half of a surrogate pair")
    if answer["status"] == "accepted":
        return Outcome(0, output)
    if answer["status"] == "rejected":
        return Outcome(REJECTED, output, json.dumps(answer.get("error", {})).encode() + b"\n")
    return Outcome(None, output, stderr, "", answer.get("detail", "") or "it says crash")
