"""The reference decoder as an adapter.

Rules: CNF-9, CNF-19.
"""

from __future__ import annotations

import json
import time
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from snhc.reference_impl.syntax.element import Readings
from snhc.vectors.decoding import Decoded, decode_input
from snhc.vectors.manifest import Entry

from .base import REJECTED, Outcome


def outcome_of(decoded: Decoded, seconds: float = 0.0, readings: Mapping[str, str] | None = None) -> Outcome:
    """What the reference decoder made of an input, as an adapter's outcome. Rules: CNF-9, CNF-19, CNF-24."""
    error = decoded.error
    return Outcome(
        0 if error is None else REJECTED,
        decoded.text.encode(),
        b"" if error is None else json.dumps(error.as_json()).encode() + b"\n",
        seconds=seconds,
        readings=readings or {},
    )


@dataclass(frozen=True, slots=True)
class BuiltIn:
    """The reference decoder of this installation, in this process. Rules: CNF-9, CNF-19."""

    name: str = "snhc"
    format: str = "ndjson"
    reproduce: str = ""
    readings: Mapping[str, str] = field(default_factory=dict)

    def lacks(self, entry: Entry) -> str:
        """Nothing: what is not built says `Unsupported` itself."""
        return ""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Decode one vector; a fault is a rejection with its JSON line, an internal error is a crash."""
        started = time.monotonic()
        try:
            chosen = Readings(dict(self.readings))
            second = None if aux is None else aux.read_bytes()
            decoded = decode_input(entry.media, path.read_bytes(), second, entry.options.for_decoder(chosen))
        except Exception:  # noqa: BLE001 (a bug of the reference decoder is a result, like any other decoder's crash)
            return Outcome(None, stderr=traceback.format_exc().encode(), detail="internal error")
        return outcome_of(decoded, time.monotonic() - started, self.readings)

    def timed(self, seconds: float) -> Self:
        """Itself: it runs in this process, and nothing can stop it."""
        return self

    def following(self, readings: Mapping[str, str]) -> Self:
        """The same with other readings."""
        return replace(self, readings={**self.readings, **readings})

    def close(self) -> None:
        """Nothing runs."""
