"""What `snhc check --profile` must say of a vector: the manifest's `check`, held against what a recipe declares.

Rules: CNF-3, CNF-23, SYS-8, SYS-9, SYS-10, SYS-11, SYS-12. Adapters decode and are not held to it: it is for tools that
check streams.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from snhc.analyzer.profiles import check_profile
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.systems.stream import Options


@dataclass(frozen=True, slots=True)
class ProfileCheck:
    """What a recipe declares of the check against the signalled profile. Rules: SYS-9, SYS-10.

    `verdict`: pass, fail or not_checked. `findings`: ids, in the order in which they are reported, reading first;
    all but `no-sequence-header` and `trailing-data`. `bits`: by id, where the first of them is. `measured`: by name of
    the criterion, as exact as it is.
    """

    verdict: str
    findings: tuple[str, ...] = ()
    bits: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    measured: Mapping[str, int | Fraction] = field(default_factory=dict)


# A stream of several objects is decoded one object at a time, which is no news here.
_UNSAID = ("no-sequence-header", "trailing-data")


def profile_check(data: bytes, options: Options, declared: ProfileCheck) -> tuple[dict[str, Any], list[str]]:
    """The manifest's `check` of a stream, and in which ways it is not what was declared. Rules: CNF-3, SYS-8..12."""
    found: list[Finding] = []
    report = check_profile(data, options, on_finding=found.append)
    findings = [finding for finding in (*found, *report.findings) if finding.id not in _UNSAID]
    document = report.as_json()
    faults = []
    if report.verdict != declared.verdict:
        faults.append(f"verdict {report.verdict}, declared {declared.verdict}")
    ids = tuple(finding.id for finding in findings)
    if ids != declared.findings:
        faults.append(f"findings of the check {ids}, declared {declared.findings}")
    for id, bits in declared.bits.items():
        got = next((finding.bits for finding in findings if finding.id == id), None)
        if got != bits:
            faults.append(f"{id} at {got}, declared {bits}")
    measured = {criterion.name: criterion.measured for criterion in report.criteria}
    for name, value in declared.measured.items():
        if measured.get(name) != value:
            faults.append(f"{name} {measured.get(name)}, declared {value}")
    check = {
        "signalled": document["signalled"],
        "profile": None if report.checked is None else f"{report.checked.profile}@L{report.checked.level}",
        "verdict": document["verdict"],
        "criteria": [
            {key: criterion[key] for key in ("name", "unit", "measured", "limit", "verdict")}
            for criterion in document["criteria"]
        ],
        "findings": [_finding(finding) for finding in findings],
    }
    return check, faults


def _finding(finding: Finding) -> dict[str, Any]:
    """Without the message: its words are ours, and may change."""
    out = finding.as_json()
    del out["message"]
    out.pop("path", None)
    return out
