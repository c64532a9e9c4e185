"""What every adapter is: a decoder that can be asked, what it claims, and what it did.

Rules: CNF-9, CNF-13, CNF-14, CNF-24.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Protocol, Self

from snhc.reference_impl.bitstream.errors import ResourceLimit, SnhcError
from snhc.reference_impl.rules import ambiguities
from snhc.vectors.decoding import decode_input
from snhc.vectors.manifest import KINDS, DecodeOptions, Entry, Rejected

FORMATS: Final = ("ndjson", "fap", "csv")
# How an option of the manifest is told to a decoder; `reading` is for CNF-24.
OPTION_NAMES: Final = ("draft", "strict", "object", "limit", "reading")
DEFAULT_TIMEOUT: Final = 10.0
REJECTED: Final = 1
# What `.fap` text and CSV can hold.
_FACE_TOOLS: Final = frozenset({"fba", "dct-p1", "dctcoef"})


class AdapterFault(SnhcError):
    """An adapter file that is none, or an adapter that there is not. Rules: CNF-9, CNF-19."""

    exit_code = 5


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a decoder did with a vector.

    Rules: CNF-9, CNF-14. `code`: 0 accepted, 1 rejected, anything else (None: stopped) neither. `stopped`: "",
    `timeout`, `output`, `memory`, `warden` (what watched it was killed), `start` (it could not be started),
    `protocol` (it does not keep to the messages), `unclaimed` (it cannot do it and has said so). `detail`: why, in
    words. `readings`: those that it says it follows. `peak`: resident memory, bytes, 0 where it was not measured.
    """

    code: int | None
    stdout: bytes = b""
    stderr: bytes = b""
    stopped: str = ""
    detail: str = ""
    seconds: float = 0.0
    readings: Mapping[str, str] = field(default_factory=dict)
    peak: int = 0


class Adapter(Protocol):
    """A decoder that can be asked, by several threads at the same time; it can be pickled. Rules: CNF-9, CNF-13."""

    @property
    def name(self) -> str:
        """What reports call it."""

    @property
    def format(self) -> str:
        """One of FORMATS: that of the last output."""

    @property
    def reproduce(self) -> str:
        """The words that name it on the command line of `snhc run`."""

    def lacks(self, entry: Entry) -> str:
        """What a vector needs and the adapter file does not claim, "" for nothing. Rules: CNF-13."""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Decode one vector. Rules: CNF-9. `aux`: its second file, None where it has one only."""

    def timed(self, seconds: float) -> Self:
        """The same adapter with another time limit per vector. Rules: CNF-14."""

    def following(self, readings: Mapping[str, str]) -> Self:
        """The same adapter, asked to follow other readings. Rules: CNF-24."""

    def close(self) -> None:
        """End whatever still runs for it; it may be asked again. Rules: CNF-10, CNF-14."""


@dataclass(frozen=True, slots=True, repr=False)
class Claims:
    """What a decoder says it can do. Rules: CNF-13, CNF-24.

    `tools`: of the manifest's. `kinds`: of vectors: `valid`, `invalid`, `ambiguous`. `profiles`: None for any.
    `limits`: its own, below those of CNF-22. `readings`: that it follows where the standard is ambiguous. `options`,
    `formats`: names of OPTION_NAMES and FORMATS.
    """

    tools: frozenset[str] = frozenset({"fba"})
    kinds: frozenset[str] = frozenset(KINDS)
    profiles: frozenset[str] | None = None
    limits: Mapping[str, int] = field(default_factory=dict)
    readings: Mapping[str, str] = field(default_factory=dict)
    options: frozenset[str] = frozenset()
    formats: tuple[str, ...] = ("ndjson",)

    def __repr__(self) -> str:
        # The same in every process: the journal of a run knows an adapter by it, and sets have no order.
        fields = {name: getattr(self, name) for name in self.__dataclass_fields__}
        shown = {name: sorted(value) if isinstance(value, frozenset) else value for name, value in fields.items()}
        return f"Claims({', '.join(f'{name}={value!r}' for name, value in shown.items())})"

    def lacks(self, entry: Entry) -> str:
        """What a vector needs and is not claimed, "" for nothing. Rules: CNF-13. Not looked at: limits."""
        missing = [tool for tool in entry.tools if tool not in self.tools]
        if entry.kind not in self.kinds:
            missing.append(f"{entry.kind} vectors")
        if entry.profile is not None and self.profiles is not None and entry.profile not in self.profiles:
            missing.append(f"profile {entry.profile}")
        if "ndjson" not in self.formats and not _FACE_TOOLS.issuperset(entry.tools):
            missing.append("format ndjson")
        missing += [f"option {name}" for name, _ in needed(entry.options) if name not in self.options]
        return ", ".join(missing)

    def exceeded(self, entry: Entry, path: Path, aux: Path | None) -> str:
        """The claimed limit that a vector goes beyond, "" for none. Rules: CNF-13, CNF-22.

        What a vector needs is found by decoding it under these limits.
        """
        if not self.limits or (isinstance(entry.expect, Rejected) and entry.expect.error_class == "ResourceLimit"):
            return ""
        lower = {**self.limits, **entry.options.limits}
        options = DecodeOptions(entry.options.draft, entry.options.strict, entry.options.object_number, lower)
        second = None if aux is None else aux.read_bytes()
        error = decode_input(entry.media, path.read_bytes(), second, options.for_decoder()).error
        return f"limit: {error.message}" if isinstance(error, ResourceLimit) else ""

    def narrowed(self, other: Claims) -> Claims:
        """What both claim; readings are those of `other` where it names them. Rules: CNF-13."""
        profiles = self.profiles
        if other.profiles is not None:
            profiles = other.profiles if profiles is None else profiles & other.profiles
        limits = dict(self.limits)
        for name, value in other.limits.items():
            limits[name] = min(value, limits.get(name, value))
        return Claims(
            self.tools & other.tools, self.kinds & other.kinds, profiles, limits, {**self.readings, **other.readings},
            self.options & other.options, tuple(name for name in self.formats if name in other.formats),
        )  # fmt: skip


def unknown_reading(readings: Mapping[str, str]) -> str:
    """What is wrong with claimed readings, "" for nothing. Rules: CNF-24."""
    known = ambiguities()
    for amb, key in readings.items():
        if amb not in known:
            return f"there is no ambiguity {amb:.80}"
        if key not in known[amb].readings:
            return f"{amb} has no reading {key!r:.80}; it has {', '.join(known[amb].readings)}"
    return ""


def needed(options: DecodeOptions) -> list[tuple[str, dict[str, str]]]:
    """The options that a vector needs: name of OPTION_NAMES, values for its words. Rules: CNF-26."""
    out: list[tuple[str, dict[str, str]]] = []
    if options.draft:
        out.append(("draft", {}))
    if options.strict:
        out.append(("strict", {}))
    if options.object_number:
        out.append(("object", {"value": str(options.object_number)}))
    out += [("limit", {"name": name, "value": str(value)}) for name, value in options.limits.items()]
    return out
