"""The journal of a run: each result is written down as it comes, so that an interrupted run can go on.

Rules: CNF-20. A text file of JSON lines: the first says which run it is, each other is one result before the ledger was
asked. A line is written in one go; what a kill left of the last one is cut off. A journal belongs to one run at a time
(it is locked), and to one set of decoders: it holds checksums of the programs that they name.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from snhc.conformance.adapters import Adapter
from snhc.conformance.results import Result
from snhc.reference_impl.bitstream.errors import InputFormat, cause

FORMAT: Final = "snhc-journal"
VERSION: Final = 1
# What a journal begins with; a kill may leave less of it.
_START: Final = json.dumps({"format": FORMAT, "version": VERSION})[:-1].encode()


def fingerprint(adapter: Adapter) -> str:
    """A checksum of what an adapter is: its description, and the content of the files that its command names.

    Rules: CNF-20. What a program loads itself is not seen.
    """
    digest = sha256(repr(adapter).encode())
    folder = getattr(adapter, "folder", None)
    words: Sequence[str] = getattr(adapter, "command", ())
    for number, word in enumerate(words):
        there = (folder or Path()) / word
        found = there if there.is_file() else Path(shutil.which(word) or "") if number == 0 else None
        if found is not None and found.is_file():
            with found.open("rb") as file:
                digest.update(sha256(file.read()).digest())
    return digest.hexdigest()


def identity(
    suite: str, digest: str, filter: str, shard: str, vectors: Sequence[str], adapters: Sequence[Adapter]
) -> dict[str, Any]:
    """What a run must have in common with its journal. Rules: CNF-20."""
    return {
        "format": FORMAT, "version": VERSION, "suite": suite, "suite_sha256": digest, "filter": filter, "shard": shard,
        "vectors": sha256("\n".join(vectors).encode()).hexdigest(),
        "adapters": {adapter.name: fingerprint(adapter) for adapter in adapters},
    }  # fmt: skip


_NAMES: Final = {
    "suite": "version of the suite", "suite_sha256": "suite", "filter": "filter", "shard": "shard",
    "vectors": "selection of vectors", "adapters": "set of decoders, or one of them has changed",
}  # fmt: skip


class Journal:
    """An open journal. Rules: CNF-20. `done`: the results that stood in it, by decoder and vector."""

    def __init__(self, path: Path, run: Mapping[str, Any], *, resume: bool) -> None:
        """Open it: go on with what stands there if `resume`, else begin anew.

        Raises InputFormat for the journal of another run, or one that another process writes.
        """
        self.path = path
        self.done: dict[tuple[str, str], Result] = {}
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
        try:
            self._lock()
            if resume:
                self._read(run)
            if not self.done:
                os.ftruncate(self._file, 0)
                self._line(dict(run))
        except BaseException:
            os.close(self._file)
            raise

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputFormat(
                "CNF-20", "journal", value=str(self.path), allowed="one that no other run is writing"
            ) from None

    def _read(self, run: Mapping[str, Any]) -> None:
        text = self.path.read_bytes()
        whole = text.rfind(b"\n") + 1
        lines = text[:whole].splitlines()
        # Nothing is cut off or written before it is sure that the file is a journal: it may be a user's only copy.
        head = self._parsed(lines[0], 1) if lines else None
        if head is None and text and not _START.startswith(text[: len(_START)]):
            raise self._foreign()
        if head is not None and (head.get("format") != FORMAT or head.get("version") != VERSION):
            raise self._foreign()
        if whole < len(text):
            os.ftruncate(self._file, whole)
        if head is None:
            return
        for name, words in _NAMES.items():
            if head.get(name) != run[name]:
                raise InputFormat("CNF-20", "journal", value=f"of another {words}", allowed="the journal of this run")
        for number, line in enumerate(lines[1:], 2):
            try:
                result = Result.from_json(self._parsed(line, number))
            except (KeyError, TypeError, AttributeError, IndexError) as error:
                raise InputFormat("CNF-20", f"journal line {number}", value=cause(error), allowed="a result") from error
            self.done[result.key] = result

    def _foreign(self) -> InputFormat:
        return InputFormat("CNF-20", "journal", value=str(self.path), allowed=f"a {FORMAT} of version {VERSION}")

    @staticmethod
    def _parsed(line: bytes, number: int) -> dict[str, Any]:
        try:
            value = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise InputFormat("CNF-20", f"journal line {number}", value=cause(error), allowed="JSON") from error
        if not isinstance(value, dict):
            raise InputFormat("CNF-20", f"journal line {number}", value=type(value).__name__, allowed="an object")
        return value

    def _line(self, value: Mapping[str, Any]) -> None:
        data = memoryview(json.dumps(value, ensure_ascii=False).encode("utf-8", "replace") + b"\n")
        while data:
            data = data[os.write(self._file, data) :]

    def add(self, result: Result) -> None:
        """Write down one result. Rules: CNF-20."""
        self._line(result.as_json())

    def remove(self) -> None:
        """The run is complete and its report written: the journal has done its work. Rules: CNF-20."""
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Give it free for another run."""
        os.close(self._file)
