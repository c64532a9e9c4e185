"""The ledger of known failures: what may fail, why, and until when.

Rules: CNF-15. A TOML file; its form is `ledger.schema.json`:

    [[known]]
    vectors = "fap.arith.range.*"             # id or pattern; | between alternatives
    adapter = "my decoder"                    # name or pattern
    reason = "i_max is not widened"
    link = "https://example.org/issues/17"
    expires = 2027-03-01                      # the last day on which it excuses
    statuses = ["fail"]                       # left out: fail, error, timeout, crash

A failure that an entry excuses is `xfail`. A known failure must still fail: a pass is `xpass`, which is bad, until the
entry is taken out. Behind its last day an entry excuses nothing, and that is said; so is one that fits no vector of the
suite, or no decoder of the run. Where several entries fit, the first that has not expired counts.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import date, timedelta
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.documents.toml_text import TomlFault, load_toml

from .filters import MOST_GLOB, long_glob
from .results import Known, Note, Report, Result

SCHEMA_FILE: Final = Path(__file__).parent / "ledger.schema.json"
EXCUSABLE: Final = ("fail", "error", "timeout", "crash")
# A draft is good for so long.
DRAFT_DAYS: Final = 90


@dataclass(frozen=True, slots=True)
class Entry:
    """One known failure. Rules: CNF-15. Fields: as in the file."""

    vectors: str
    adapter: str
    reason: str
    link: str
    expires: date
    statuses: tuple[str, ...] = EXCUSABLE

    def fits(self, adapter: str, vector: str) -> bool:
        """Whether it speaks of this decoder and vector."""
        return fnmatchcase(adapter, self.adapter) and self.fits_vector(vector)

    def fits_vector(self, vector: str) -> bool:
        """Whether it speaks of this vector."""
        return any(fnmatchcase(vector, pattern.strip()) for pattern in self.vectors.split("|"))

    def __str__(self) -> str:
        return f"{self.vectors} [{self.adapter}]"


@dataclass(frozen=True, slots=True)
class Ledger:
    """The entries in their order. Rules: CNF-15."""

    entries: tuple[Entry, ...]

    def apply(self, report: Report, suite: Sequence[str], today: date) -> Report:
        """The report with known failures as such, and with what is to be said of the ledger.

        Rules: CNF-15. `suite`: the ids of all its vectors, also of those that were not run.
        """
        notes = list(report.notes)
        for entry in self.entries:
            if today > entry.expires:
                notes.append(
                    Note("expired", str(entry), f"expired on {entry.expires}, excuses nothing: {entry.reason}")
                )
            if not any(entry.fits_vector(vector) for vector in suite):
                notes.append(Note("unmatched", str(entry), "fits no vector of the suite"))
            elif not any(fnmatchcase(adapter, entry.adapter) for adapter in report.adapters):
                notes.append(Note("unmatched", str(entry), "fits no decoder of the run"))
        return replace(
            report, results=tuple(self._judged(result, today) for result in report.results), notes=tuple(notes)
        )

    def _judged(self, result: Result, today: date) -> Result:
        fitting = [entry for entry in self.entries if entry.fits(result.adapter, result.vector)]
        alive = [entry for entry in fitting if today <= entry.expires]
        if not fitting:
            return result
        entry = (alive or fitting)[0]
        known = Known(entry.reason, entry.link, entry.expires.isoformat(), not alive, result.status)
        if not alive:
            return replace(result, known=known)
        for entry in alive:
            known = Known(entry.reason, entry.link, entry.expires.isoformat(), False, result.status)
            if result.status in entry.statuses:
                return replace(result, status="xfail", known=known)
        if result.status == "pass":
            reason = f"passes, but is known to fail ({known.reason}): take it out of the ledger"
            return replace(result, status="xpass", reason=reason, known=known)
        return replace(result, known=known)


def load(path: Path) -> Ledger:
    """Read a ledger. Rules: CNF-15, CNF-25. Raises InputFormat with the path of the first misfit, OSError."""
    import jsonschema

    try:
        document = load_toml(path)
    except TomlFault as error:
        raise InputFormat("CNF-15", "ledger", value=str(path), allowed=f"TOML: {error}") from error
    # JSON Schema knows no dates: as the text that they are written as.
    plain = json.loads(json.dumps(document, default=lambda value: f"{value}"))
    schema = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))
    errors = sorted(
        jsonschema.Draft202012Validator(schema).iter_errors(plain), key=lambda error: [str(p) for p in error.path]
    )
    if errors:
        where = errors[0].json_path
        raise InputFormat("CNF-15", f"{path.name}: {where}", value=errors[0].message, allowed="its schema", path=where)
    entries: list[Entry] = []
    for number, known in enumerate(plain.get("known", [])):
        try:
            expires = date.fromisoformat(known["expires"])
        except ValueError as error:
            where = f"$.known[{number}].expires"
            raise InputFormat(
                "CNF-15",
                f"{path.name}: {where}",
                value=known["expires"],
                allowed="a day such as 2027-03-01",
                path=where,
            ) from error
        for key, long in (("vectors", long_glob(known["vectors"])), ("adapter", len(known["adapter"]) > MOST_GLOB)):
            if long:
                where = f"$.known[{number}].{key}"
                raise InputFormat(
                    "CNF-15", f"{path.name}: {where}", value=known[key], path=where,
                    allowed=f"patterns of at most {MOST_GLOB} characters",
                )  # fmt: skip
        entries.append(
            Entry(
                known["vectors"],
                known["adapter"],
                known["reason"],
                known["link"],
                expires,
                tuple(known.get("statuses", EXCUSABLE)),
            )
        )
    return Ledger(tuple(entries))


def draft(results: Iterable[Result], today: date) -> str:
    """A ledger of the failures that none excuses yet, as TOML; the links are left for people to fill in.

    Rules: CNF-15. It is not valid before they have: a failure that nobody looks after is not known.
    """
    lines = ["# Known failures. Each needs a link to where it is looked after before `snhc run --ledger` takes this."]
    for result in results:
        if result.status in EXCUSABLE:
            lines += [
                "", "[[known]]", f"vectors = {_quoted(result.vector)}", f"adapter = {_quoted(result.adapter)}",
                f"reason = {_quoted(result.reason[:200])}", 'link = ""',
                f"expires = {today + timedelta(DRAFT_DAYS)}", f"statuses = [{_quoted(result.status)}]",
            ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    # A basic string of TOML: what JSON escapes, and nothing that cannot be shown.
    return json.dumps(re.sub(r"[^\x20-\x7e\xa0-\ud7ff\ue000-\ufffd]", "?", text), ensure_ascii=False)
