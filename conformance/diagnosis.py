"""What the doctor found: steps, and a verdict. The JSON form fits `doctor.schema.json`.

Rules: CNF-13, CNF-19, CNF-25.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from .adapters import AdapterFault

FORMAT: Final = "snhc-doctor"
VERSION: Final = 1
SCHEMA_FILE: Final = Path(__file__).parent / "doctor.schema.json"
GUIDE: Final = "docs/adapters.md"

OK: Final = "ok"
WRONG: Final = "wrong"
DECODER: Final = "decoder"
NOTE: Final = "note"
NOT_RUN: Final = "not_run"
STATES: Final = (OK, WRONG, DECODER, NOTE, NOT_RUN)


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the walk.

    Rules: CNF-13. `state`: `ok`; `wrong`, the adapter is at fault; `decoder`, the adapter works and the decoder is
    wrong; `note`, worth a look; `not_run`. `what`: what was found. `fix`: what would help. `section`: of the guide.
    """

    name: str
    state: str
    what: str
    fix: str = ""
    section: str = ""

    def as_json(self) -> dict[str, str]:
        """The step in the JSON form."""
        out = {"name": self.name, "state": self.state, "what": self.what}
        if self.fix:
            out["fix"] = self.fix
        if self.section:
            out["guide"] = f"{GUIDE}, section {self.section!r}"
        return out


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """All steps. Rules: CNF-13, CNF-19."""

    adapter: str
    steps: tuple[Step, ...]

    @property
    def exit_code(self) -> int:
        """5 where the adapter is at fault, 1 where only the decoder is, 0 else. Rules: CNF-19."""
        states = {step.state for step in self.steps}
        return AdapterFault.exit_code if WRONG in states else int(DECODER in states)

    def as_json(self) -> dict[str, Any]:
        """The JSON form. Rules: CNF-25."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "adapter": self.adapter,
            "verdict": {0: "ok", 1: "decoder", 5: "adapter"}[self.exit_code],
            "steps": [step.as_json() for step in self.steps],
        }
