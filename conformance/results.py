"""What a run found: one result per decoder and vector, and the report that holds them.

Rules: CNF-15, CNF-17, CNF-18, CNF-19, CNF-20. The JSON form is `reports/report.schema.json`; a report that was saved
is read again, joined with others, and rendered.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from .compare import BAD, STATUSES
from .differences import Difference
from .where import Location

FORMAT: Final = "snhc-report"
VERSION: Final = 1
GOOD: Final = 0
FAILURE: Final = 1
ADAPTER_FAULT: Final = 5


@dataclass(frozen=True, slots=True)
class Known:
    """The ledger entry that a result falls under. Rules: CNF-15. `status`: the one before the ledger was asked."""

    reason: str
    link: str
    expires: str
    expired: bool
    status: str

    def as_json(self) -> dict[str, Any]:
        """The result's `known`."""
        return {
            "reason": self.reason, "link": self.link, "expires": self.expires, "expired": self.expired,
            "status": self.status,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Result:
    """One vector with one decoder.

    Rules: CNF-15, CNF-17. `file`: the input, in the suite. `reproduce`: the command that does it again. `expected`,
    `got`: what the manifest demands of a rejection and what the decoder said, empty where neither is at stake.
    `evidence`: what a report shows of a failure (`where.examine`), empty for others. `known`: its entry of the ledger.
    """

    adapter: str
    vector: str
    title: str
    tier: str
    kind: str
    file: str
    tools: tuple[str, ...]
    rules: tuple[str, ...]
    status: str
    reason: str
    reading: str
    seconds: float
    difference: Difference | None
    location: Location | None
    reproduce: str
    expected: Mapping[str, Any] = field(default_factory=dict)
    got: Mapping[str, Any] = field(default_factory=dict)
    evidence: Mapping[str, Any] = field(default_factory=dict)
    known: Known | None = None

    @property
    def key(self) -> tuple[str, str]:
        """Decoder and vector: what makes a result one of its kind."""
        return self.adapter, self.vector

    def as_json(self) -> dict[str, Any]:
        """The report's result."""
        out: dict[str, Any] = {
            "adapter": self.adapter, "vector": self.vector, "title": self.title, "tier": self.tier,
            "kind": self.kind, "file": self.file, "tools": list(self.tools), "rules": list(self.rules),
            "status": self.status, "reason": self.reason, "seconds": self.seconds,
            "reproduce": self.reproduce,
        }  # fmt: skip
        if self.reading:
            out["reading"] = self.reading
        if self.difference is not None:
            out["difference"] = self.difference.as_json()
        if self.location is not None:
            out["location"] = self.location.as_json()
        for name in ("expected", "got", "evidence"):
            if getattr(self, name):
                out[name] = dict(getattr(self, name))
        if self.known is not None:
            out["known"] = self.known.as_json()
        return out

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Result:
        """A result of a report that fits the schema."""
        difference, location, known = data.get("difference"), data.get("location"), data.get("known")
        return cls(
            data["adapter"], data["vector"], data["title"], data["tier"], data["kind"], data["file"],
            tuple(data["tools"]), tuple(data["rules"]), data["status"], data["reason"],
            data.get("reading", ""), data["seconds"],
            None if difference is None else Difference(**difference),
            None if location is None else Location.from_json(location),
            data["reproduce"], data.get("expected", {}), data.get("got", {}), data.get("evidence", {}),
            None if known is None else Known(**known),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Shards:
    """Which parts of a run a report holds. Rules: CNF-20. `present`: numbers from 1 to `count`, ascending."""

    count: int
    present: tuple[int, ...]

    @property
    def missing(self) -> tuple[int, ...]:
        """The numbers that are not there."""
        return tuple(number for number in range(1, self.count + 1) if number not in self.present)


@dataclass(frozen=True, slots=True)
class Note:
    """What is to be said of a ledger entry: it has expired, or there is nothing that it fits. Rules: CNF-15."""

    kind: str
    entry: str
    message: str

    def as_json(self) -> dict[str, str]:
        """One of the report's `notes`."""
        return {"kind": self.kind, "entry": self.entry, "message": self.message}


@dataclass(frozen=True, slots=True)
class Report:
    """A whole run, a shard of one, or several of them joined.

    Rules: CNF-15, CNF-19, CNF-20. `suite`: its version; `digest`: sha256 of its manifest; `filter`: as given;
    `adapters`: names in order; `results`: by adapter, then as in the manifest: by
    vector id. `shards`: by adapter, of those of which a
    part has been run. `notes`: on the ledger.
    """

    suite: str
    filter: str
    adapters: tuple[str, ...]
    results: tuple[Result, ...]
    digest: str = ""
    shards: Mapping[str, Shards] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()

    def counts(self, adapter: str) -> dict[str, int]:
        """Status -> number of vectors, of one decoder."""
        return dict(Counter(result.status for result in self.results if result.adapter == adapter))

    def passed(self, adapter: str) -> bool:
        """Whether the verdict is pass: at least one pass, and nothing bad. Rules: CNF-15."""
        counts = self.counts(adapter)
        return counts.get("pass", 0) > 0 and not any(counts.get(status, 0) for status in BAD)

    @property
    def exit_code(self) -> int:
        """0 where all pass; 5 where adapters are at fault and nothing else is; else 1. Rules: CNF-15, CNF-19."""
        if self.adapters and all(self.passed(adapter) for adapter in self.adapters):
            return GOOD
        bad = {result.status for result in self.results if result.status in BAD}
        return ADAPTER_FAULT if bad == {"error"} else FAILURE

    def as_json(self) -> dict[str, Any]:
        """The JSON report. Rules: CNF-18."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "suite": self.suite,
            "suite_sha256": self.digest,
            "filter": self.filter,
            "adapters": [self._adapter(name) for name in self.adapters],
            "notes": [note.as_json() for note in self.notes],
            "results": [result.as_json() for result in self.results],
        }

    def _adapter(self, name: str) -> dict[str, Any]:
        counts = self.counts(name)
        out: dict[str, Any] = {
            "name": name,
            "verdict": "pass" if self.passed(name) else "fail",
            "counts": {status: counts.get(status, 0) for status in STATUSES},
        }
        if name in self.shards:
            out["shards"] = {"count": self.shards[name].count, "present": list(self.shards[name].present)}
        return out

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Report:
        """A report that fits the schema."""
        return cls(
            data["suite"], data["filter"], tuple(adapter["name"] for adapter in data["adapters"]),
            tuple(Result.from_json(result) for result in data["results"]), data["suite_sha256"],
            {
                adapter["name"]: Shards(adapter["shards"]["count"], tuple(adapter["shards"]["present"]))
                for adapter in data["adapters"]
                if "shards" in adapter
            },
            tuple(Note(**note) for note in data["notes"]),
        )  # fmt: skip
