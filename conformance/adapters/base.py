"""What every adapter is: a decoder that can be asked, and what it did.

Rules: CNF-9, CNF-13, CNF-14.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol, Self

from snhc.vectors.manifest import DecodeOptions, Entry

FORMATS: Final = ("ndjson", "fap", "csv")
OPTION_NAMES: Final = ("draft", "strict", "object", "limit")
DEFAULT_TIMEOUT: Final = 10.0
REJECTED: Final = 1


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a decoder did with a vector.

    Rules: CNF-9, CNF-14. `code`: 0 accepted, 1 rejected, anything else (None: stopped) neither. `stopped`: "",
    `timeout`, `output`, `start` (it could not be started). `detail`: why, in words.
    """

    code: int | None
    stdout: bytes = b""
    stderr: bytes = b""
    stopped: str = ""
    detail: str = ""
    seconds: float = 0.0


class Adapter(Protocol):
    """A decoder that can be asked, by several threads at the same time; it can be pickled. Rules: CNF-9, CNF-13."""

    @property
    def name(self) -> str:
        """What reports call it."""

    @property
    def format(self) -> str:
        """One of FORMATS."""

    @property
    def reproduce(self) -> str:
        """The words that name it on the command line of `snhc run`."""

    def lacks(self, entry: Entry) -> str:
        """What a vector needs and the decoder does not claim, "" for nothing. Rules: CNF-13."""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Decode one vector. Rules: CNF-9. `aux`: its second file, None where it has one only."""

    def timed(self, seconds: float) -> Self:
        """The same adapter with another time limit per vector. Rules: CNF-14."""

    def close(self) -> None:
        """End whatever still runs for it; it may be asked again. Rules: CNF-10, CNF-14."""


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
