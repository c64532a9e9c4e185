"""The kill matrix as data: which vectors kill which mutants.

Rules: CNF-8. The form is JSON without times, so that the same decoder and suite give the same bytes. `matrix.json`
beside this module is the last full run.

    {"format": "snhc-kill-matrix", "version": 1, "suite": "0.1.0", "vectors": 640, "complete": true,
     "mutants": [{"id": ..., "title": ..., "rules": [...], "change": [...], "topic": ..., "findings": false,
                  "survives": "", "first": "vector that killed it first, rules' vectors before all others",
                  "kills": {"fail": [vector ids], "crash": [...], "timeout": [...]}}]}
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat, cause

from .mutant import Mutant

FORMAT: Final = "snhc-kill-matrix"
VERSION: Final = 1
MATRIX: Final = Path(__file__).parent / "matrix.json"
KILLED: Final = ("fail", "crash", "timeout")
"""A wrong output or verdict, an exception (no memory is one), no end."""
TOLD: Final = ("reading", "concealed")
"""The decoder passes, and the report says in which of the ways that are allowed."""
HOW: Final = KILLED + TOLD


@dataclass(frozen=True, slots=True)
class Line:
    """What became of one mutant.

    Rules: CNF-8. `kills`: by way, the vectors that kill it, sorted; with early stop only the first. `first`: the first
    one in the order in which they were tried, "" for a survivor.
    """

    id: str
    title: str
    rules: tuple[str, ...]
    change: tuple[str, ...]
    topic: str
    findings: bool
    survives: str
    first: str
    kills: Mapping[str, tuple[str, ...]]

    @classmethod
    def of(cls, mutant: Mutant, first: str, kills: Mapping[str, Sequence[str]]) -> Line:
        """The line of a mutant. Rules: CNF-8."""
        return cls(
            mutant.id, mutant.title, mutant.rules, tuple(change.shown for change in mutant.changes), mutant.topic,
            mutant.findings, mutant.survives, first, {how: tuple(sorted(kills[how])) for how in HOW if kills.get(how)},
        )  # fmt: skip

    @property
    def killed(self) -> bool:
        """Whether a vector fails: else the mutant is told apart, or survives. Rules: CNF-8."""
        return any(how in self.kills for how in KILLED)

    @property
    def killers(self) -> tuple[str, ...]:
        """All vectors that kill it, sorted. Rules: CNF-8."""
        return tuple(sorted(vector for vectors in self.kills.values() for vector in vectors))


@dataclass(frozen=True, slots=True)
class Matrix:
    """All mutants against a suite.

    Rules: CNF-8. `vectors`: ids of all vectors that were run; `complete`: every mutant met every vector that it could
    change, or was given up behind several timeouts; else each only up to its first killer.
    """

    suite: str
    vectors: tuple[str, ...]
    complete: bool
    lines: tuple[Line, ...]

    @property
    def survivors(self) -> tuple[Line, ...]:
        """The mutants that no vector kills. Rules: CNF-8."""
        return tuple(line for line in self.lines if not line.kills)

    @property
    def unexplained(self) -> tuple[Line, ...]:
        """Survivors without a reason, and mutants that are killed although a reason says that they cannot be."""
        return tuple(line for line in self.lines if bool(line.kills) == bool(line.survives))

    def columns(self) -> dict[str, tuple[str, ...]]:
        """The mutants that each vector kills, by vector id, sorted. Rules: CNF-8."""
        out: dict[str, list[str]] = {vector: [] for vector in self.vectors}
        for line in self.lines:
            for vector in line.killers:
                out[vector].append(line.id)
        return {vector: tuple(mutants) for vector, mutants in out.items()}

    def alone(self) -> dict[str, tuple[str, ...]]:
        """The vectors that are the only killer of a mutant, with those mutants. Rules: CNF-8."""
        out: dict[str, list[str]] = {}
        for line in self.lines:
            if len(line.killers) == 1:
                out.setdefault(line.killers[0], []).append(line.id)
        return {vector: tuple(mutants) for vector, mutants in sorted(out.items())}

    def redundant(self) -> tuple[str, ...]:
        """The vectors whose mutants are each killed by some other vector as well, or that kill none.

        Rules: CNF-8. For information: a vector documents a rule whether or not a mutant needs it.
        """
        needed = self.alone()
        return tuple(vector for vector in self.vectors if vector not in needed)

    def enough(self) -> tuple[str, ...]:
        """A small set of vectors that kills all that are killed: greedily, the one that kills most first.

        Rules: CNF-8.
        """
        left = {line.id: set(line.killers) for line in self.lines if line.kills}
        columns = {vector: set(mutants) for vector, mutants in self.columns().items() if mutants}
        out: list[str] = []
        while left:
            best = min(columns, key=lambda vector: (-len(columns[vector] & left.keys()), vector))
            out.append(best)
            for mutant in columns.pop(best):
                left.pop(mutant, None)
        return tuple(sorted(out))

    def as_json(self) -> dict[str, Any]:
        """The document. Rules: CNF-8."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "suite": self.suite,
            "complete": self.complete,
            "vectors": list(self.vectors),
            "mutants": [
                {
                    "id": line.id,
                    "title": line.title,
                    "rules": list(line.rules),
                    "change": list(line.change),
                    "topic": line.topic,
                    "findings": line.findings,
                    "survives": line.survives,
                    "first": line.first,
                    "kills": {how: list(vectors) for how, vectors in line.kills.items()},
                }
                for line in self.lines
            ],
        }

    def text(self) -> str:
        """The file's content, one line per mutant and per field of the whole. Rules: CNF-8."""
        document = self.as_json()
        rows = ",\n".join("  " + json.dumps(row, ensure_ascii=False) for row in document.pop("mutants"))
        head = "".join(f" {json.dumps(key)}: {json.dumps(value)},\n" for key, value in document.items())
        return "{\n" + head + ' "mutants": [\n' + rows + "\n ]\n}\n"


def load_matrix(path: Path = MATRIX) -> Matrix:
    """A matrix from its file. Rules: CNF-8. Raises InputFormat for a file that is none."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["format"] != FORMAT or document["version"] != VERSION:
            raise ValueError(f"{document['format']} version {document['version']}")
        return Matrix(
            document["suite"],
            tuple(document["vectors"]),
            document["complete"],
            tuple(
                Line(
                    row["id"], row["title"], tuple(row["rules"]), tuple(row["change"]), row["topic"], row["findings"],
                    row["survives"], row["first"], {how: tuple(ids) for how, ids in row["kills"].items()},
                )
                for row in document["mutants"]
            ),
        )  # fmt: skip
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputFormat(
            "CNF-8", "kill matrix", value=str(path), allowed=f"{FORMAT} {VERSION}: {cause(error)}"
        ) from error


def merged(saved: Matrix, new: Matrix, order: Sequence[str]) -> Matrix:
    """A saved matrix with the lines of a new one in place of its own.

    Rules: CNF-8. `order`: ids of all mutants that there are. Lines of others are dropped, as are kills of vectors that
    the suite no longer has.
    """
    there = set(new.vectors)
    lines = {line.id: line for line in (*saved.lines, *new.lines)}
    kept: list[Line] = []
    for id in order:
        if id in lines:
            line = lines[id]
            kills = {how: tuple(v for v in vectors if v in there) for how, vectors in line.kills.items()}
            kills = {how: vectors for how, vectors in kills.items() if vectors}
            left = sorted(vector for vectors in kills.values() for vector in vectors)
            first = line.first if line.first in left else next(iter(left), "")
            kept.append(replace(line, kills=kills, first=first))
    return Matrix(new.suite, new.vectors, saved.complete and new.complete, tuple(kept))


def lost_kills(before: Matrix, now: Matrix) -> list[tuple[str, str]]:
    """(mutant, vector) pairs of an earlier matrix that no longer kill, of mutants and vectors that still exist.

    Rules: CNF-8. `now`: complete.
    """
    killers = {line.id: set(line.killers) for line in now.lines}
    there = set(now.vectors)
    return [
        (line.id, vector)
        for line in before.lines
        if line.id in killers
        for vector in line.killers
        if vector in there and vector not in killers[line.id]
    ]
