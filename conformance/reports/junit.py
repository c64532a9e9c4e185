"""A report as JUnit XML: a test suite per decoder, a test case per vector.

Rules: CNF-15, CNF-18. The form is `junit.xsd`. `fail` and `xpass` are failures; `error`, `timeout` and `crash` are
errors; `not_applicable`, `skipped` and `xfail` are skipped. A run with no result at all has one failing case: an empty
run fails.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from snhc.conformance.results import Report, Result

from .words import divergence, where

SCHEMA_FILE: Final = Path(__file__).parent / "junit.xsd"
_KINDS: Final = {
    "fail": "failure", "xpass": "failure", "error": "error", "timeout": "error", "crash": "error",
    "not_applicable": "skipped", "skipped": "skipped", "xfail": "skipped",
}  # fmt: skip
# What XML 1.0 cannot hold, not even escaped.
_FORBIDDEN: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def text(report: Report) -> str:
    """The report as XML. Rules: CNF-18."""
    root = ElementTree.Element("testsuites", name="snhc")
    totals = {"tests": 0, "failures": 0, "errors": 0, "skipped": 0}
    seconds = 0.0
    for adapter in report.adapters:
        results = [result for result in report.results if result.adapter == adapter]
        suite = ElementTree.SubElement(root, "testsuite", name=_clean(adapter))
        properties = ElementTree.SubElement(suite, "properties")
        for name, value in (("suite", report.suite), ("suite_sha256", report.digest), ("filter", report.filter)):
            ElementTree.SubElement(properties, "property", name=name, value=_clean(value))
        for result in results:
            _case(suite, result)
        if not results:
            case = ElementTree.SubElement(suite, "testcase", name="empty run", classname=_clean(adapter), time="0")
            ElementTree.SubElement(case, "failure", type="fail", message="no vector was selected")
        kinds = [_KINDS.get(result.status) for result in results] or ["failure"]
        counts = {
            "tests": len(kinds), "failures": kinds.count("failure"), "errors": kinds.count("error"),
            "skipped": kinds.count("skipped"),
        }  # fmt: skip
        for name, count in counts.items():
            suite.set(name, str(count))
            totals[name] += count
        took = sum(result.seconds for result in results)
        suite.set("time", f"{took:.6f}")
        seconds += took
    for name, count in totals.items():
        root.set(name, str(count))
    root.set("time", f"{seconds:.6f}")
    ElementTree.indent(root)
    return f"<?xml version='1.0' encoding='utf-8'?>\n{ElementTree.tostring(root, encoding='unicode')}\n"


def _case(suite: ElementTree.Element, result: Result) -> None:
    case = ElementTree.SubElement(
        suite, "testcase", name=_clean(result.vector), classname=_clean(f"{result.adapter}.{result.tier}"),
        time=f"{result.seconds:.6f}",
    )  # fmt: skip
    kind = _KINDS.get(result.status)
    if kind is None:
        return
    reason = result.reason
    if result.status == "xfail" and result.known is not None:
        reason = f"known until {result.known.expires}: {result.known.reason} ({result.known.link}); {result.reason}"
    if kind == "skipped":
        ElementTree.SubElement(case, kind, message=_clean(f"{result.status}: {reason}"))
        return
    bad = ElementTree.SubElement(case, kind, type=result.status, message=_clean(reason))
    lines = [result.title, reason]
    lines += [f"where: {where(result)}"] if where(result) else []
    lines += [divergence(result)] if divergence(result) else []
    lines += [f"rules: {', '.join(result.rules)}", f"again: {result.reproduce}"]
    bad.text = _clean("\n".join(lines))


def _clean(text: str) -> str:
    return _FORBIDDEN.sub("?", text)
