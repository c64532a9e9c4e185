"""A report as SARIF 2.1.0: a run per decoder, a result per bad vector, at the bytes that it failed on.

Rules: CNF-15, CNF-17, CNF-18. Known failures are there too, suppressed. The rules are those of the register.
"""

from __future__ import annotations

import json
from typing import Any, Final
from urllib.parse import quote

from snhc.conformance.compare import BAD
from snhc.conformance.results import Report, Result
from snhc.reference_impl.rules import Rule, rules

from .words import divergence, where

SCHEMA: Final = "https://json.schemastore.org/sarif-2.1.0.json"
_BASE: Final = "SUITE"


def text(report: Report) -> str:
    """The report as a SARIF log. Rules: CNF-18."""
    log = {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [_run(report, adapter) for adapter in report.adapters],
    }
    return json.dumps(log, ensure_ascii=False, indent=1) + "\n"


def _run(report: Report, adapter: str) -> dict[str, Any]:
    from importlib.metadata import version

    told = [r for r in report.results if r.adapter == adapter and (r.status in BAD or r.status == "xfail")]
    ids = list(dict.fromkeys(_rule(result) for result in told))
    passed = report.passed(adapter)
    return {
        "tool": {
            "driver": {
                "name": "snhc",
                "semanticVersion": version("snhc"),
                "rules": [_descriptor(rules()[id]) if id in rules() else {"id": id} for id in ids],
            }
        },
        "automationDetails": {"id": f"snhc/{quote(adapter, safe='', errors='replace')}/"},
        "invocations": [{"executionSuccessful": True, "exitCodeDescription": "pass" if passed else "fail"}],
        "originalUriBaseIds": {_BASE: {"description": {"text": f"folder of suite {report.suite}"}}},
        "properties": {
            "adapter": adapter, "verdict": "pass" if passed else "fail", "counts": report.counts(adapter),
            "suite": report.suite, "suite_sha256": report.digest, "filter": report.filter,
        },
        "results": [_result(result, ids) for result in told],
    }  # fmt: skip


def _rule(result: Result) -> str:
    if result.location is not None and result.location.rule:
        return result.location.rule
    return str(result.expected.get("rule") or result.rules[0] if result.rules else "CNF-15")


def _descriptor(rule: Rule) -> dict[str, Any]:
    return {
        "id": rule.id,
        "shortDescription": {"text": rule.title},
        "fullDescription": {"text": rule.statement},
        "properties": {"confidence": rule.confidence, "clause": rule.clause},
    }


def _result(result: Result, ids: list[str]) -> dict[str, Any]:
    rule = _rule(result)
    message = f"{result.vector} [{result.adapter}]: {result.status}: {result.reason}"
    message += f"\nwhere: {where(result)}" if where(result) else ""
    message += f"\n{divergence(result)}" if divergence(result) else ""
    message += f"\nagain: {result.reproduce}"
    physical: dict[str, Any] = {"artifactLocation": {"uri": quote(result.file), "uriBaseId": _BASE}}
    bits = _bits(result)
    if bits is not None:
        first, end = bits[0] >> 3, (bits[1] + 7) >> 3
        physical["region"] = {"byteOffset": first, "byteLength": max(end - first, 0)}
    out: dict[str, Any] = {
        "ruleId": rule,
        "ruleIndex": ids.index(rule),
        "kind": "fail",
        "level": "error",
        "message": {"text": message},
        "locations": [
            {
                "physicalLocation": physical,
                "logicalLocations": [{"fullyQualifiedName": _logical(result), "kind": "element"}],
            }
        ],
        "partialFingerprints": {"adapterAndVector/v1": f"{result.adapter}/{result.vector}"},
        "properties": {
            "status": result.status, "title": result.title, "tier": result.tier, "tools": list(result.tools),
            "rules": list(result.rules), "reproduce": result.reproduce,
        },
    }  # fmt: skip
    if bits is not None:
        out["properties"]["bits"] = list(bits)
    if result.status == "xfail" and result.known is not None:
        known = result.known
        justification = f"{known.reason} ({known.link}, until {known.expires})"
        out["suppressions"] = [{"kind": "external", "status": "accepted", "justification": justification}]
    return out


def _bits(result: Result) -> tuple[int, int] | None:
    if result.location is not None:
        return result.location.bits or result.location.plane_bits
    bits = result.expected.get("bits")
    return (bits[0], bits[1]) if bits is not None else None


def _logical(result: Result) -> str:
    path = result.location.path if result.location is not None else ""
    return f"{result.vector}/{path}" if path else result.vector
