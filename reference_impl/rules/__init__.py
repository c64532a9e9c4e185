"""The rule register: every rule, ambiguity and finding of the suite as data, with its loader.

Rules: CNF-8, CNF-23, CNF-24. Importing the package reads no file; looking up one rule reads one file.
"""

from __future__ import annotations

from snhc.reference_impl.rules.register import (
    AREAS,
    CONFIDENCES,
    Ambiguity,
    FindingKind,
    Rule,
    ambiguities,
    ambiguity,
    finding,
    findings,
    rule,
    rules,
)
from snhc.reference_impl.rules.text import describe, listing

__all__ = [
    "AREAS",
    "CONFIDENCES",
    "Ambiguity",
    "FindingKind",
    "Rule",
    "ambiguities",
    "ambiguity",
    "describe",
    "finding",
    "findings",
    "listing",
    "rule",
    "rules",
]
