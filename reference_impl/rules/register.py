"""Loading the register: one TOML file per area, `ambiguities.toml`, `findings.toml`.

Rules: CNF-8, CNF-23, CNF-24.

A rule file begins with a table `[area]` (document, clause) and holds one table per rule, named by its id.
Every file is checked when it is read; one that breaks the form gives one `InputFormat` that names file and
entry. References between the files are checked by the tests, so that looking up one rule reads one file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat, cause
from snhc.reference_impl.bitstream.findings import SEVERITIES

if TYPE_CHECKING:
    from collections.abc import Mapping

REGISTER: Final = Path(__file__).parent
AREAS: Final = ("FBA", "DCT", "MSH", "FIT", "FAT", "FAC", "SYS", "TTS", "CNF")
CONFIDENCES: Final = (
    "paper",
    "confirmed",
    "strong memory",
    "memory",
    "derived",
    "one implementation",
    "this suite",
)
_RULE_ID: Final = re.compile(rf"({'|'.join(AREAS)})-[1-9]\d*")
_AMBIGUITY_ID: Final = re.compile(rf"AMB-({'|'.join(AREAS)})-[1-9]\d*")
_KEY: Final = re.compile(r"[a-z0-9]+([-_][a-z0-9]+)*")
_RULE_FORM: Final = {
    "title": str, "statement": str, "confidence": str, "note": str, "clause": str, "ambiguities": list,
    "built": bool,
}  # fmt: skip
_AMBIGUITY_FORM: Final = {"question": str, "readings": dict, "rules": list, "why": str, "built": bool}
_FINDING_FORM: Final = {"severity": str, "rule": str, "description": str}


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule of the register.

    Rules: CNF-8.

    `statement`: the rule in our own words. `clause`: edition and clause, from memory, "" where unknown.
    `confidence`: one of `CONFIDENCES`; `note`: where parts of the rule have another one. `source`: the
    document of the project's specification. `ambiguities`: ids of the readings it takes part in. `built`:
    the product implements it.
    """

    id: str
    title: str
    statement: str
    clause: str
    confidence: str
    note: str
    source: str
    ambiguities: tuple[str, ...]
    built: bool


@dataclass(frozen=True, slots=True)
class Ambiguity:
    """Two or more readings of the standard.

    Rules: CNF-24.

    `followed`: key of the reading followed by default. `readings`: key -> description; the keys are what
    `--reading AMB-FBA-6=before` takes. `rules`: ids of the rules affected. `why`: why that one. `built`: the
    decoder can switch.
    """

    id: str
    question: str
    followed: str
    readings: Mapping[str, str]
    rules: tuple[str, ...]
    why: str
    built: bool


@dataclass(frozen=True, slots=True)
class FindingKind:
    """A registered kind of finding: something accepted but wrong or odd.

    Rules: CNF-23.

    `severity`: info, warning or error. `rule`: the rule it is measured by.
    """

    id: str
    severity: str
    rule: str
    description: str


class _Entry:
    """One table of a register file, its cells checked against a form."""

    def __init__(self, file: str, name: str, cells: object, form: Mapping[str, type], rule_id: str) -> None:
        self.file, self.name, self.rule_id = file, name, rule_id
        if not isinstance(cells, dict):
            raise self.fault("entry", cells, "a table")
        self.cells: dict[str, Any] = cells
        for key, value in cells.items():
            if key not in form:
                raise self.fault(key, value, ", ".join(form))
            if type(value) is not form[key]:
                raise self.fault(key, value, f"a {form[key].__name__}")

    def fault(self, key: str, value: object, law: str) -> InputFormat:
        path = f"{self.file} {self.name}"
        return InputFormat(self.rule_id, key, value=str(value), allowed=law, path=path)

    def text(self, key: str, default: str | None = None) -> str:
        """A text as one line; without a default it may not be missing or empty."""
        value = " ".join(str(self.cells.get(key, default or "")).split())
        if not value and default is None:
            raise self.fault(key, value, "a text that is not empty")
        return value

    def choice(self, key: str, allowed: tuple[str, ...]) -> str:
        value = self.text(key)
        if value not in allowed:
            raise self.fault(key, value, ", ".join(allowed))
        return value

    def ids(self, key: str, form: re.Pattern[str]) -> tuple[str, ...]:
        values = self.cells.get(key, [])
        for value in values:
            if not isinstance(value, str) or not form.fullmatch(value) or values.count(value) > 1:
                raise self.fault(key, value, f"different ids of the form {form.pattern}")
        return tuple(values)

    def flag(self, key: str) -> bool:
        return bool(self.cells.get(key, False))


def _parse(folder: Path, file: str, rule_id: str) -> dict[str, Any]:
    import tomllib

    try:
        return tomllib.loads((folder / file).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputFormat(rule_id, "register", value=cause(error), allowed="a readable TOML file", path=file) from error


@cache
def _area(area: str, folder: Path) -> Mapping[str, Rule]:
    file = f"{area.lower()}.toml"
    tables = _parse(folder, file, "CNF-8")
    head = _Entry(file, "area", tables.pop("area", None), {"document": str, "clause": str}, "CNF-8")
    out: dict[str, Rule] = {}
    for name, cells in tables.items():
        entry = _Entry(file, name, cells, _RULE_FORM, "CNF-8")
        match = _RULE_ID.fullmatch(name)
        if match is None or match[1] != area:
            raise entry.fault("entry", name, f"{area}- and a number")
        out[name] = Rule(
            name, entry.text("title"), entry.text("statement"), entry.text("clause", head.text("clause", "")),
            entry.choice("confidence", CONFIDENCES), entry.text("note", ""), head.text("document"),
            entry.ids("ambiguities", _AMBIGUITY_ID), entry.flag("built"),
        )  # fmt: skip
    return MappingProxyType(out)


def rule(rule_id: str, folder: Path = REGISTER) -> Rule:
    """The rule `rule_id` (`FBA-26`); reads the file of its area only.

    Rules: CNF-8.

    Raises `InputFormat` for an id that the register does not hold.
    """
    area = rule_id.partition("-")[0]
    found = _area(area, folder).get(rule_id) if area in AREAS else None
    if found is None:
        raise InputFormat("CNF-8", "rule id", value=rule_id, allowed="an id that `snhc rules` lists")
    return found


@cache
def rules(folder: Path = REGISTER) -> Mapping[str, Rule]:
    """All rules by id, area by area in the order of the files.

    Rules: CNF-8.
    """
    return MappingProxyType({key: value for area in AREAS for key, value in _area(area, folder).items()})


@cache
def ambiguities(folder: Path = REGISTER) -> Mapping[str, Ambiguity]:
    """All ambiguities by id.

    Rules: CNF-24.
    """
    file = "ambiguities.toml"
    out: dict[str, Ambiguity] = {}
    for name, cells in _parse(folder, file, "CNF-24").items():
        entry = _Entry(file, name, cells, _AMBIGUITY_FORM, "CNF-24")
        if not _AMBIGUITY_ID.fullmatch(name):
            raise entry.fault("entry", name, f"an id of the form {_AMBIGUITY_ID.pattern}")
        readings = entry.cells.get("readings", {})
        if len(readings) < 2:
            raise entry.fault("readings", len(readings), "2 or more, the one followed first")
        for key, text in readings.items():
            if not _KEY.fullmatch(key) or not isinstance(text, str) or not text.strip():
                raise entry.fault("readings", key, "keys of a-z, 0-9, - and _ with a description")
        out[name] = Ambiguity(
            name, entry.text("question"), next(iter(readings)),
            MappingProxyType({key: " ".join(text.split()) for key, text in readings.items()}),
            entry.ids("rules", _RULE_ID), entry.text("why"), entry.flag("built"),
        )  # fmt: skip
    return MappingProxyType(out)


def ambiguity(ambiguity_id: str, folder: Path = REGISTER) -> Ambiguity:
    """The ambiguity `ambiguity_id` (`AMB-FBA-6`).

    Rules: CNF-24.

    Raises `InputFormat` for an id that the register does not hold.
    """
    found = ambiguities(folder).get(ambiguity_id)
    if found is None:
        law = f"an id of the register, {', '.join(ambiguities(folder))}"
        raise InputFormat("CNF-24", "ambiguity id", value=ambiguity_id, allowed=law)
    return found


@cache
def findings(folder: Path = REGISTER) -> Mapping[str, FindingKind]:
    """All kinds of findings by id.

    Rules: CNF-23.
    """
    file = "findings.toml"
    out: dict[str, FindingKind] = {}
    for name, cells in _parse(folder, file, "CNF-23").items():
        entry = _Entry(file, name, cells, _FINDING_FORM, "CNF-23")
        if not _KEY.fullmatch(name):
            raise entry.fault("entry", name, "an id of a-z, 0-9 and -")
        measured = entry.text("rule")
        if not _RULE_ID.fullmatch(measured):
            raise entry.fault("rule", measured, f"an id of the form {_RULE_ID.pattern}")
        severity = entry.choice("severity", SEVERITIES)
        out[name] = FindingKind(name, severity, measured, entry.text("description"))
    return MappingProxyType(out)


def finding(finding_id: str, folder: Path = REGISTER) -> FindingKind:
    """The kind of finding `finding_id` (`no-end-code`).

    Rules: CNF-23.

    Raises `InputFormat` for an id that the register does not hold.
    """
    found = findings(folder).get(finding_id)
    if found is None:
        raise InputFormat("CNF-23", "finding id", value=finding_id, allowed="a registered id")
    return found
