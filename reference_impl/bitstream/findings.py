"""Findings: things accepted but wrong or odd.

Rules: CNF-23. The ids are permanent; their register is `rules/findings.toml`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

SEVERITIES: Final = ("info", "warning", "error")


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding, located like an error.

    Rules: CNF-23.

    `id`: registered, permanent. `severity`: one of `info`, `warning`, `error`. `bits`: half-open span, bitstreams;
    `line`: from 1, text inputs.
    """

    id: str
    severity: str
    rule: str
    message: str
    bits: tuple[int, int] | None = None
    line: int | None = None
    path: str = ""

    def as_json(self) -> dict[str, object]:
        """The object of CNF-23. Rules: CNF-23."""
        out: dict[str, object] = {"id": self.id, "severity": self.severity, "rule": self.rule}
        if self.bits is not None:
            out["bits"] = list(self.bits)
        if self.line is not None:
            out["line"] = self.line
        if self.path:
            out["path"] = self.path
        out["message"] = self.message
        return out

    def __str__(self) -> str:
        where = ""
        if self.bits is not None:
            where = f" at bits [{self.bits[0]}, {self.bits[1]})"
        elif self.line is not None:
            where = f" at line {self.line}"
        path = f" ({self.path})" if self.path else ""
        return f"{self.severity}: {self.id}{where}{path}: {self.message} ({self.rule})"
