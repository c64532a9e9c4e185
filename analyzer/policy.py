"""Policies: rules of somebody's own for streams, in TOML, on top of what the standard says.

Rules: CNF-23, CNF-25.

    name = "our set-top box"

    [[rule]]
    id = "quantiser"                                  # the finding is `policy.quantiser`
    expression = 'name == "fap_quant" && value > 15'  # the language of `snhc dump --query`
    message = "fap_quant is {value}"                  # fields of the language in braces
    severity = "warning"                              # info, warning, error (left out: error)
    expect = "none"                                   # none: whatever the expression takes is a finding (left out)
                                                      # some: a stream in which it takes nothing is one
    rule = "FBA-9"                                    # left out: the rule of the element

`symbols = true` at the top lets expressions see single arithmetic symbols too, which takes longer.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.findings import SEVERITIES, Finding
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.documents.toml_text import TomlFault, load_toml
from snhc.reference_impl.rules import rules
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, trace_stream

from .parts import Parts
from .query import FIELDS, Query, QueryError, Subject, subjects

PREFIX: Final = "policy."
NONE: Final = "none"
SOME: Final = "some"
MOST_RULES: Final = 1_000
_ID: Final = re.compile(r"[a-z0-9]+([.-][a-z0-9]+)*")
_FIELD: Final = re.compile(r"\{(\w*)\}")
_TOP: Final = {"name": str, "symbols": bool, "rule": list}
_FORM: Final = {"id": str, "expression": str, "message": str, "severity": str, "expect": str, "rule": str}
_NEEDED: Final = ("id", "expression", "message")


@dataclass(frozen=True, slots=True)
class PolicyRule:
    """One rule of a policy. Rules: CNF-23. Fields: as in the file."""

    id: str
    query: Query
    message: str
    severity: str
    expect: str
    rule: str

    def finding(self, subject: Subject) -> Finding:
        """The finding about what the expression takes. Rules: CNF-23."""
        words = _FIELD.sub(lambda match: str(FIELDS[match[1]].get(subject)), self.message)
        rule = self.rule or str(FIELDS["rule"].get(subject))
        path = str(FIELDS["path"].get(subject))
        if subject.row >= 0:
            path = ".".join(filter(None, (path, str(FIELDS["name"].get(subject)))))
        return Finding(PREFIX + self.id, self.severity, rule, words, subject.bits, None, path)


@dataclass(frozen=True, slots=True)
class Policy:
    """A policy. Rules: CNF-25. `symbols`: its expressions see arithmetic symbols too."""

    name: str
    symbols: bool
    rules: tuple[PolicyRule, ...]


def load_policy(path: Path) -> Policy:
    """A policy from its file.

    Rules: CNF-25. Raises OSError, and InputFormat (QueryError for an expression) with the path of the misfit.
    """
    try:
        table = load_toml(path)
    except TomlFault as error:
        raise InputFormat("CNF-25", "policy", value=str(path), allowed=f"TOML: {error}") from error
    _typed(table, _TOP, "")
    rows = table.get("rule", [])
    if not rows or len(rows) > MOST_RULES:
        raise _misfit("rule", len(rows), f"1 to {MOST_RULES} tables [[rule]]")
    out: list[PolicyRule] = []
    for n, row in enumerate(rows):
        out.append(_rule(row, f"rule[{n}]", {rule.id for rule in out}))
    return Policy(table.get("name", path.stem), table.get("symbols", False), tuple(out))


def _rule(row: object, path: str, ids: set[str]) -> PolicyRule:
    if not isinstance(row, dict):
        raise _misfit(path, row, "a table [[rule]]")
    _typed(row, _FORM, path)
    for key in _NEEDED:
        if key not in row:
            raise _misfit(f"{path}.{key}", None, "a text")
    id = row["id"]
    if not _ID.fullmatch(id) or id in ids:
        raise _misfit(f"{path}.id", id, "lower-case words with hyphens, other than those of the rules before it")
    severity, expect, rule = row.get("severity", "error"), row.get("expect", NONE), row.get("rule", "")
    for key, value, allowed in (("severity", severity, SEVERITIES), ("expect", expect, (NONE, SOME))):
        if value not in allowed:
            raise _misfit(f"{path}.{key}", value, ", ".join(allowed))
    if rule and rule not in rules():
        raise _misfit(f"{path}.rule", rule, "a rule of the register (snhc rules)")
    for name in _FIELD.findall(row["message"]):
        if name not in FIELDS:
            raise _misfit(f"{path}.message", name, f"fields of the language: {', '.join(FIELDS)}")
        if expect == SOME:
            raise _misfit(f"{path}.message", name, "no field: there is no element to speak of with expect = some")
    try:
        query = Query(row["expression"])
    except QueryError as error:
        raise InputFormat(
            "CNF-25", f"{path}.expression", value=error.value, allowed=error.allowed, path=f"{path}.expression"
        ) from error
    return PolicyRule(id, query, row["message"], severity, expect, rule)


def _typed(table: Mapping[str, object], form: Mapping[str, type], path: str) -> None:
    for key, value in table.items():
        where = f"{path}.{key}" if path else key
        if key not in form:
            raise _misfit(where, key, ", ".join(form))
        if not isinstance(value, form[key]):
            raise _misfit(where, value, f"a value of type {form[key].__name__}")


def _misfit(path: str, value: object, allowed: str) -> InputFormat:
    return InputFormat("CNF-25", path, value=None if value is None else str(value)[:60], allowed=allowed, path=path)


def check_policy(
    source: Source, policy: Policy, report: Callable[[Finding], None], options: Options = DEFAULT_OPTIONS
) -> None:
    """Report what a stream does against a policy, in the order of the stream; what is missing comes last.

    Rules: CNF-23. All objects are looked at. Memory does not grow with the stream. Raises the fault that ends it, and
    QueryError where an expression has no truth value.
    """
    met: set[str] = set()
    parts = Parts(trace_stream(source, options, symbols=policy.symbols))
    end = 0
    for part in parts:
        if len(part.trace):
            end = part.trace.end[len(part.trace) - 1]
        for subject in subjects(part, source, policy.symbols):
            for rule in policy.rules:
                if (rule.expect == NONE or rule.id not in met) and rule.query(subject):
                    met.add(rule.id)
                    if rule.expect == NONE:
                        report(rule.finding(subject))
    if parts.error is not None:
        raise parts.error
    for missing in _missing(policy, met, end):
        report(missing)


def _missing(policy: Policy, met: set[str], end: int) -> Iterator[Finding]:
    for rule in policy.rules:
        if rule.expect == SOME and rule.id not in met:
            yield Finding(PREFIX + rule.id, rule.severity, rule.rule or "CNF-23", rule.message, (0, end))
