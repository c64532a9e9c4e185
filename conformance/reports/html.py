"""A report as one HTML file, which works from `file://` and asks no network.

Rules: CNF-15, CNF-17, CNF-18. The template escapes everything (`report.html.j2`, autoescape); a content security policy
lets only the style and the script of this package run, told by their checksums. Failures are sections that their links
open, without any script; the script filters the matrix.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from markupsafe import Markup

from snhc.analyzer.pages import base_css
from snhc.conformance.compare import BAD, STATUSES
from snhc.conformance.results import Report, Result
from snhc.reference_impl.bitstream.errors import one_line
from snhc.reference_impl.rules import Rule, rules
from snhc.vectors.manifest import TIERS

from . import drawings
from .words import divergence, numbers, remarks, where

_HERE: Final = Path(__file__).parent
_PER_LINE: Final = 16
# Marked bytes whose bits are shown one by one.
_BYTES_AS_BITS: Final = 12


def text(report: Report) -> str:
    """The report as HTML. Rules: CNF-18."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_shown,
    )
    environment.filters["printable"] = one_line
    style = base_css() + (_HERE / "report.css").read_text(encoding="utf-8")
    script = (_HERE / "report.js").read_text(encoding="utf-8")
    by_vector: dict[str, dict[str, Result]] = {}
    for result in report.results:
        by_vector.setdefault(result.vector, {})[result.adapter] = result
    vectors = dict(sorted(by_vector.items(), key=lambda item: (_rank(item[1]), item[0])))
    # In the order of the matrix: the next failure is the one of the next row.
    told = [one for row in vectors.values() for one in row.values() if one.status in BAD or one.status == "xfail"]
    pages = {result.key: number for number, result in enumerate(told)}
    return environment.get_template("report.html.j2").render(
        report=report,
        adapters=[(name, report.passed(name), numbers(report, name), report.counts(name)) for name in report.adapters],
        statuses=[status for status in STATUSES if any(result.status == status for result in report.results)],
        tiers=[tier for tier in TIERS if any(result.tier == tier for result in report.results)],
        tools=sorted({tool for result in report.results for tool in result.tools}),
        rules=_known(sorted({rule for result in report.results for rule in result.rules}, key=_natural)),
        remarks=remarks(report),
        vectors=list(vectors.items()),
        bad=BAD,
        pages=pages,
        failures=[_page(result, vectors[result.vector]) for result in told],
        style=style,
        script=script,
        policy=f"default-src 'none'; style-src {_source(style)}; script-src {_source(script)}; base-uri 'none'; "
        "form-action 'none'",
    )


def _rank(results: Mapping[str, Result]) -> int:
    """What failed comes first, then what is known to fail."""
    statuses = {result.status for result in results.values()}
    return 0 if statuses.intersection(BAD) else 1 if "xfail" in statuses else 2


def _shown(value: Any) -> Any:
    """Texts without what steers a display; our own markup as it is."""
    if isinstance(value, str) and not isinstance(value, Markup):
        return "\n".join(one_line(line) for line in value.split("\n"))
    return value


def _source(content: str) -> str:
    return f"'sha256-{base64.b64encode(sha256(content.encode()).digest()).decode()}'"


def _natural(rule: str) -> tuple[str, int]:
    area, _, number = rule.rpartition("-")
    return area, int(number) if number.isdigit() else 0


def _known(ids: list[str]) -> list[Rule]:
    return [rules()[id] for id in ids if id in rules()]


def _page(result: Result, others: Mapping[str, Result]) -> dict[str, Any]:
    evidence = result.evidence
    # The rule at fault first.
    first = [result.location.rule] if result.location is not None and result.location.rule else []
    first += [result.expected["rule"]] if "rule" in result.expected else []
    return {
        "result": result,
        "where": where(result),
        "divergence": divergence(result),
        "rules": _known(list(dict.fromkeys([*first, *result.rules]))),
        "trace": evidence.get("trace", []),
        "symbols": evidence.get("symbols", []),
        "lines": _hexdump(evidence["bytes"]) if "bytes" in evidence else [],
        "bits": _bits(evidence["bytes"]) if "bytes" in evidence else [],
        "curve": drawings.curve(evidence["curve"]) if "curve" in evidence else "",
        "fap": evidence.get("curve", {}).get("fap"),
        "mesh": drawings.mesh(evidence["mesh"]) if "mesh" in evidence else "",
        "document": evidence.get("document", {}),
        "others": [other for other in others.values() if other.adapter != result.adapter],
        "link": _link(result),
    }


def _link(result: Result) -> str:
    """Of the ledger: only what a browser may follow without running it."""
    link = result.known.link if result.known is not None else ""
    return link if link.lower().startswith(("https://", "http://")) else ""


def _marked(data: Mapping[str, Any], bit: int) -> bool:
    return any(first <= bit < end for first, end in data["marks"])


def _hexdump(data: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, bool]]]]:
    """Lines: offset, and bytes with whether a marked bit is in them."""
    content, first = bytes.fromhex(data["hex"]), data["first"]
    lines = []
    for at in range(0, len(content), _PER_LINE):
        cells = [
            (f"{byte:02x}", any(_marked(data, (first + at + i) * 8 + bit) for bit in range(8)))
            for i, byte in enumerate(content[at : at + _PER_LINE])
        ]
        lines.append((f"{first + at:06x}", cells))
    return lines


def _bits(data: Mapping[str, Any]) -> list[tuple[int, list[tuple[str, bool]]]]:
    """The bytes with marked bits: number of the first bit, its eight bits with whether each is marked."""
    content, first = bytes.fromhex(data["hex"]), data["first"]
    out = []
    for i, byte in enumerate(content):
        start = (first + i) * 8
        cells = [(str(byte >> (7 - bit) & 1), _marked(data, start + bit)) for bit in range(8)]
        if any(marked for _, marked in cells):
            out.append((start, cells))
    return out[:_BYTES_AS_BITS]
