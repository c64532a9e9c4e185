"""The coverage book: every cell with the vectors that reach it, or the reason why none does.

Rules: CNF-4, CNF-8. `book.json` is made by `snhc coverage --update` and has the form of `book.schema.json`. It is the
same on every machine: no times, no line numbers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat, cause

from ..manifest import SUITE, load
from .cells import KINDS, Cell
from .holes import Holes, load_holes
from .observe import Observation, observe, sources_of

FORMAT: Final = "snhc-coverage"
VERSION: Final = 1
BOOK_FILE: Final = Path(__file__).parent / "book.json"
SCHEMA_FILE: Final = Path(__file__).parent / "book.schema.json"


@dataclass(frozen=True, slots=True)
class Row:
    """A cell in the book. Rules: CNF-8. `vectors`: ids, sorted, none for a hole; `why`: the reason of a hole, or ""."""

    cell: Cell
    vectors: tuple[str, ...]
    why: str

    @property
    def covered(self) -> bool:
        """Whether a vector reaches it."""
        return bool(self.vectors)


@dataclass(frozen=True, slots=True)
class Share:
    """How many cells of a part are covered. Rules: CNF-8."""

    covered: int
    total: int

    @property
    def percent(self) -> str:
        """Rounded down, so that 100 means all: `99.9`."""
        tenths = 1000 * self.covered // self.total if self.total else 1000
        return f"{tenths // 10}.{tenths % 10}"


@dataclass(frozen=True, slots=True)
class Book:
    """The whole book.

    Rules: CNF-8. `rows`: by key, sorted; `vectors`: all ids of the suite, sorted; `unentered`: as in `Observation`.
    """

    suite: str
    vectors: tuple[str, ...]
    rows: Mapping[str, Row]
    unentered: tuple[str, ...] = ()

    def share(self, select: Callable[[Row], bool] = lambda row: True) -> Share:
        """How many of the selected cells are covered."""
        chosen = [row for row in self.rows.values() if select(row)]
        return Share(sum(row.covered for row in chosen), len(chosen))

    def by_kind(self) -> dict[str, Share]:
        """Of each kind of cell."""
        return {kind: self.share(lambda row, kind=kind: row.cell.kind == kind) for kind in KINDS}  # type: ignore[misc]

    def by_area(self) -> dict[str, Share]:
        """Of each area of the rules: a cell counts in every area that it has a rule of."""
        names = sorted({rule.partition("-")[0] for row in self.rows.values() for rule in row.cell.rules})
        return {name: self.share(lambda row, name=name: in_area(row, name)) for name in names}  # type: ignore[misc]

    def reasons(self) -> dict[str, int]:
        """Reason -> number of holes, the largest first."""
        out: dict[str, int] = {}
        for row in self.rows.values():
            if not row.covered:
                out[row.why] = out.get(row.why, 0) + 1
        return dict(sorted(out.items(), key=lambda item: (-item[1], item[0])))

    def select(self, rules: Iterable[str] = (), text: str = "", holes: bool = False) -> Book:
        """The rows of some rules (`FBA-26`, `FBA`), whose key has a text in it, or that are holes; all must hold."""
        wanted = tuple(rules)
        rows = {
            key: row
            for key, row in self.rows.items()
            if (not wanted or any(of_rule(row, rule) for rule in wanted))
            and text in key
            and (not holes or not row.covered)
        }
        return Book(self.suite, self.vectors, rows, self.unentered)

    def as_json(self) -> dict[str, Any]:
        """The document. Vectors are named by their place; equal sets of them, and reasons, stand once."""
        places = {id: i for i, id in enumerate(self.vectors)}
        sets: dict[str, int] = {}
        reasons: dict[str, int] = {}
        cells: list[dict[str, Any]] = []
        for key, row in self.rows.items():
            out: dict[str, Any] = {"cell": key, "rules": list(row.cell.rules)}
            if row.covered:
                runs = _runs([places[id] for id in row.vectors])
                out["vectors"] = sets.setdefault(runs, len(sets))
            elif row.why:
                out["hole"] = reasons.setdefault(row.why, len(reasons))
            cells.append(out)
        whole = self.share()
        return {
            "format": FORMAT,
            "version": VERSION,
            "suite": self.suite,
            "summary": {
                "covered": whole.covered,
                "cells": whole.total,
                "kinds": {kind: [share.covered, share.total] for kind, share in self.by_kind().items()},
            },
            "unentered": list(self.unentered),
            "vectors": list(self.vectors),
            "sets": list(sets),
            "reasons": list(reasons),
            "cells": cells,
        }

    def text(self) -> str:
        """The file's content: one line per vector, set, reason and cell."""
        parts = []
        for name, value in self.as_json().items():
            if isinstance(value, list):
                lines = ",\n".join("  " + json.dumps(one, ensure_ascii=False) for one in value)
                parts.append(f" {json.dumps(name)}: [\n{lines}\n ]" if value else f" {json.dumps(name)}: []")
            else:
                parts.append(f" {json.dumps(name)}: {json.dumps(value, ensure_ascii=False)}")
        return "{\n" + ",\n".join(parts) + "\n}\n"


def in_area(row: Row, area: str) -> bool:
    """Whether a cell has a rule of an area (`FBA`). Rules: CNF-8."""
    return any(rule.partition("-")[0] == area for rule in row.cell.rules)


def of_rule(row: Row, name: str) -> bool:
    """Whether a cell belongs to a rule (`FBA-26`) or an area (`FBA`). Rules: CNF-8."""
    return name in row.cell.rules or in_area(row, name)


def _runs(places: list[int]) -> str:
    """`0-3 7`: runs of numbers, ends included."""
    out: list[str] = []
    first = last = -1
    for place in [*places, -1]:
        if first >= 0 and place == last + 1:
            last = place
            continue
        if first >= 0:
            out.append(str(first) if first == last else f"{first}-{last}")
        first = last = place
    return " ".join(out)


def _places(runs: str) -> list[int]:
    out: list[int] = []
    for run in runs.split():
        first, _, last = run.partition("-")
        out += range(int(first), int(last or first) + 1)
    return out


def make_book(suite: Path = SUITE) -> tuple[Book, list[str]]:
    """Run the suite and make its book; what is wrong with the reasons for its holes. Rules: CNF-8."""
    holes = load_holes()
    manifest = load(suite)
    observed = observe(manifest.entries, suite, sources_of(holes.is_outside))
    return bind(observed, holes, manifest.suite, [entry.id for entry in manifest.entries])


def bind(observed: Observation, holes: Holes, suite: str, vectors: Iterable[str]) -> tuple[Book, list[str]]:
    """A book of what was observed. Rules: CNF-8."""
    why, faults = holes.explain(observed.cells, observed.hits)
    rows = {
        key: Row(cell, tuple(sorted(observed.hits.get(key, ()))), why.get(key, ""))
        for key, cell in sorted(observed.cells.items())
    }
    return Book(suite, tuple(sorted(vectors)), rows, observed.unentered), faults


def load_book(path: Path = BOOK_FILE) -> Book:
    """Read a book. Rules: CNF-8. Raises InputFormat for one that is missing or out of form."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputFormat("CNF-8", "coverage book", value=cause(error), allowed="a readable book.json") from error
    validate(document)
    vectors = document["vectors"]
    sets = [tuple(vectors[place] for place in _places(runs)) for runs in document["sets"]]
    rows = {
        cell["cell"]: Row(
            Cell(cell["cell"], tuple(cell["rules"])),
            sets[cell["vectors"]] if "vectors" in cell else (),
            document["reasons"][cell["hole"]] if "hole" in cell else "",
        )
        for cell in document["cells"]
    }
    return Book(document["suite"], tuple(vectors), rows, tuple(document["unentered"]))


def validate(document: object) -> None:
    """Hold a document against the schema. Rules: CNF-8. Raises InputFormat with the path of the first misfit."""
    import jsonschema

    schema = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))
    error = next(iter(jsonschema.Draft202012Validator(schema).iter_errors(document)), None)
    if error is not None:
        raise InputFormat(
            "CNF-8", "coverage book", value=error.message[:200], allowed="what the schema says", path=error.json_path
        )


def lost(old: Book, new: Book) -> list[str]:
    """Cells that a vector reached and none reaches now, and modules that none enters now.

    Rules: CNF-8. Cells that are gone are not lost.
    """
    left = {module for module in new.unentered if any(key.startswith(f"branch/{module}/") for key in old.rows)}
    out = [f"branch/{module}/*" for module in sorted(left)]
    return out + [key for key, row in old.rows.items() if row.covered and key in new.rows and not new.rows[key].covered]


def check(path: Path = BOOK_FILE, suite: Path = SUITE) -> list[str]:
    """What is wrong with a book: cells lost, holes and their reasons, and whether it is stale. Rules: CNF-4, CNF-8."""
    new, faults = make_book(suite)
    try:
        old = load_book(path)
        faults = [f"lost: {key}" for key in lost(old, new)] + faults
        stale = path.read_text(encoding="utf-8") != new.text()
    except InputFormat as error:
        return [*faults, str(error)]
    if stale:
        faults.append(f"stale: {_change(old, new)} (snhc coverage --update makes it anew)")
    return faults


def _change(old: Book, new: Book) -> str:
    gone, added = len(old.rows.keys() - new.rows.keys()), len(new.rows.keys() - old.rows.keys())
    other = sum(old.rows[key] != row for key, row in new.rows.items() if key in old.rows)
    return f"{added} cells are new, {gone} are gone, {other} have other vectors, rules or reasons"
