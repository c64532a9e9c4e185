"""Why cells are empty: reasons for patterns of cells, and the modules that are no part of the decoder.

Rules: CNF-8. The reasons stand in `holes.toml`. A reason must be needed: one that matches nothing, or a cell that a
vector reaches, is a mistake, and so is a hole without a reason.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat, cause
from snhc.reference_impl.documents.toml_text import TomlFault, parse_toml

HOLES_FILE: Final = Path(__file__).parent / "holes.toml"


@dataclass(frozen=True, slots=True)
class Reason:
    """Why the cells that a pattern matches are empty. Rules: CNF-8. `pattern`: `*` stands for any text."""

    pattern: str
    why: str


@dataclass(frozen=True, slots=True)
class Holes:
    """`holes.toml`. Rules: CNF-8. `outside`: patterns of modules whose branches do not count, and why."""

    reasons: tuple[Reason, ...]
    outside: tuple[Reason, ...]

    def is_outside(self, module: str) -> bool:
        """Whether a module is no part of the decoder that the suite asks."""
        return any(matches(one.pattern, module) for one in self.outside)

    def explain(self, cells: Collection[str], hit: Collection[str]) -> tuple[dict[str, str], list[str]]:
        """The reason of every hole (the first that matches), and what is wrong with the reasons."""
        why: dict[str, str] = {}
        faults: list[str] = []
        for reason in self.reasons:
            found = [key for key in cells if matches(reason.pattern, key)]
            if not found:
                faults.append(f"reason for no cell: {reason.pattern}")
            faults += [f"reason for a covered cell: {reason.pattern}: {key}" for key in found if key in hit]
            for key in found:
                why.setdefault(key, reason.why)
        faults += [f"hole without a reason: {key}" for key in cells if key not in hit and key not in why]
        return {key: text for key, text in why.items() if key not in hit}, faults


@cache
def _pattern(text: str) -> re.Pattern[str]:
    return re.compile(".*".join(re.escape(part) for part in text.split("*")), re.DOTALL)


def matches(pattern: str, text: str) -> bool:
    """Whether a pattern is the whole of a text; `*` stands for anything, also nothing. Rules: CNF-8."""
    return _pattern(pattern).fullmatch(text) is not None


def load_holes(path: Path = HOLES_FILE) -> Holes:
    """Read the reasons. Rules: CNF-8. Raises InputFormat for a file that is out of form."""
    try:
        table: dict[str, Any] = parse_toml(path.read_bytes())
    except (OSError, TomlFault) as error:
        raise InputFormat("CNF-8", path.name, value=cause(error), allowed="a TOML file") from error
    found: dict[str, list[Reason]] = {"hole": [], "outside": []}
    for name, entries in table.items():
        for entry in entries if name in found and isinstance(entries, list) else [None]:
            if not isinstance(entry, dict) or set(entry) != {"cells" if name == "hole" else "modules", "why"}:
                raise InputFormat(
                    "CNF-8", path.name, value=name, allowed="[[hole]] with cells and why, [[outside]] with modules, why"
                )
            patterns, why = entry["cells" if name == "hole" else "modules"], " ".join(str(entry["why"]).split())
            found[name] += [Reason(str(pattern), why) for pattern in patterns]
    return Holes(tuple(found["hole"]), tuple(found["outside"]))
