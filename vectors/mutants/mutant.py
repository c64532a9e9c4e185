"""What a mutant is, and the list of all.

Rules: CNF-8.

    mutant(
        "fap.value.inter-from-source", "Inter values start from 0, not from the last reconstructed value",
        ["FBA-32"], edit("face.reconstruct:parameter_values", "values[number] += level", "values[number] = level"),
    )

A mutant is data: which text of which function becomes what, or which object gets which value. Ids are permanent, as
those of vectors are.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Final

TOPICS: Final = (
    "framing", "header", "masks", "ranges", "coder", "values", "highlevel", "bodies", "dct", "mesh_geometry",
    "mesh_motion", "mesh_errors", "fit", "fat", "fapu", "systems",
)  # fmt: skip
_ID: Final = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*(\.[a-z0-9]+(-[a-z0-9]+)*)+")


class MutantFault(Exception):
    """A mutant that does not fit the decoder (any more), or is out of form. Rules: CNF-8."""


@dataclass(frozen=True, slots=True)
class Edit:
    """Source text inside one function: `old` stands there exactly once and becomes `new`.

    Rules: CNF-8. `target`: `module:qualified.name`, the module below `snhc.reference_impl`.
    """

    target: str
    old: str
    new: str

    @property
    def shown(self) -> str:
        """The change in words."""
        return f"{self.target}: {_flat(self.old)} -> {_flat(self.new)}"


@dataclass(frozen=True, slots=True)
class Value:
    """An object: what `target` leads to is `old` and becomes `new`.

    Rules: CNF-8. `target`: `module:path`, the path made of names, indices and calls without arguments:
    `tables:fap_table()[46].i_max`, `mesh.syntax:NODES_HOR.lo`.
    """

    target: str
    old: object
    new: object

    @property
    def shown(self) -> str:
        """The change in words."""
        return f"{self.target}: {self.old!r} -> {self.new!r}"


Change = Edit | Value


@dataclass(frozen=True, slots=True)
class Mutant:
    """One mistake.

    Rules: CNF-8. `title`: what the implementer did. `rules`: that it breaks. `findings`: the decoded output stays
    right, only what is reported as a finding is wrong: vectors kill it by the findings that their recipes declare.
    `survives`: why no vector can kill it, "" for all that must be killed.
    """

    id: str
    title: str
    rules: tuple[str, ...]
    changes: tuple[Change, ...]
    topic: str
    findings: bool = False
    survives: str = ""


_MUTANTS: Final[dict[str, Mutant]] = {}


def edit(target: str, old: str, new: str) -> Edit:
    """A change of source text. Rules: CNF-8."""
    return Edit(target, old, new)


def value(target: str, old: object, new: object) -> Value:
    """A change of an object. Rules: CNF-8."""
    return Value(target, old, new)


def mutant(
    id: str, title: str, rules: Iterable[str], *changes: Change, findings: bool = False, survives: str = ""
) -> None:
    """Add a mutant to the list. Rules: CNF-8. Raises MutantFault for a bad or used id, no rule, and no change."""
    if not _ID.fullmatch(id):
        raise MutantFault(f"{id}: not the form of an id")
    if id in _MUTANTS:
        raise MutantFault(f"{id}: this id is used")
    if not changes:
        raise MutantFault(f"{id}: it changes nothing")
    named = tuple(rules)
    if not named:
        raise MutantFault(f"{id}: it breaks no rule")
    _MUTANTS[id] = Mutant(id, title, named, changes, _topic, findings, survives)


_topic = ""


def all_mutants() -> dict[str, Mutant]:
    """Every mutant by id, in the order of the topics. Rules: CNF-8."""
    global _topic
    for topic in TOPICS:
        _topic = topic
        import_module(f"{__package__}.{topic}")
    return dict(_MUTANTS)


def _flat(text: str) -> str:
    return " ".join(text.split())
