"""The cells of the book: names for what the probe met, and all the names that there could be.

Rules: CNF-8. Nothing is listed here that stands elsewhere: elements, faults, code tables, parameters, limits, findings,
ambiguities and rules are taken from where they are declared, branches and raised errors from the source. Two things are
learnt by reading the suite: how wide a field is, and which code table it uses.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from snhc.reference_impl.bitstream.errors import ERROR_CLASSES
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.entropy.model import FENWICK_FROM
from snhc.reference_impl.entropy.prefix import PrefixTable, shipped_table
from snhc.reference_impl.entropy.profile import load_profile
from snhc.reference_impl.face.parameters import EXPRESSION_LABELS, VISEME_LABELS, bap_set, fap_set
from snhc.reference_impl.face.syntax import BAP_SEGMENT, EXPRESSION_SEGMENT, FAP_SEGMENT, VISEME_SEGMENT
from snhc.reference_impl.mesh.syntax import DELTA_MV_X_VLC, DELTA_X_LEN
from snhc.reference_impl.rules import ambiguities, findings, rules
from snhc.reference_impl.syntax.element import ELEMENTS, FAULTS, Element

from .branches import Source
from .probe import BOUNDARIES, Met, fault_key, key_of
from .values import all_classes

KINDS: Final = {
    "rule": "Rules, by name of a vector",
    "element": "Syntax elements, by value class",
    "cut": "Data that ends at an element",
    "group": "Masks, by group",
    "word": "Words of the code tables",
    "segment": "Arithmetic segments",
    "model": "States of the models",
    "level": "Parameters, by level",
    "plane": "Planes and their boundaries",
    "fault": "Faults of the syntax",
    "error": "Errors, by class and rule",
    "finding": "Findings",
    "reading": "Readings of ambiguities",
    "limit": "Limits",
    "branch": "Branches of the decoder",
}
"""The kinds of cells, and what they are."""

SEGMENTS: Final = (FAP_SEGMENT, VISEME_SEGMENT, EXPRESSION_SEGMENT, BAP_SEGMENT)
_FRAMES: Final = {1: "intra", 0: "inter"}
_SEGMENT_KINDS: Final = (
    "empty", "one symbol", "several symbols", "ends as an encoder ends it", "ends otherwise", "guard", "guard 0",
    "several guards", "guard in the look-ahead, 1", "guard in the look-ahead, 0",
    "look-ahead past the end of the data",
)  # fmt: skip
_MODEL_KINDS: Final = {
    1: ("single-symbol model", "uniform", "no bits fetched"),
    0: (
        "single-symbol model", "first symbol", "adapted", "rescale", f"{FENWICK_FROM} symbols or more",
        "no bits fetched",
    ),
}  # fmt: skip
_LEVELS: Final = ("coded", "lowest", "highest")
_MASKS: Final = ("none", "all", "first only", "last only")


@dataclass(frozen=True, slots=True)
class Cell:
    """One thing that a vector can reach. Rules: CNF-8. `key`: its name; `rules`: the rules that it belongs to."""

    key: str
    rules: tuple[str, ...]

    @property
    def kind(self) -> str:
        """The first word of the name, one of `KINDS`."""
        return self.key.partition("/")[0]


@dataclass(frozen=True, slots=True)
class Learnt:
    """What reading the suite tells. Rules: CNF-8.

    `elements`: those met, by key; `widths`: of each, (bits, signed); `tables`: those used, by name; `users`: the
    elements of each table; `bytes`: the elements that are whole bytes.
    """

    elements: Mapping[str, Element]
    widths: Mapping[str, frozenset[tuple[int, bool]]]
    tables: Mapping[str, PrefixTable]
    users: Mapping[str, frozenset[str]]
    bytes: frozenset[str]


def learn(met: Iterable[Met], elements: Mapping[str, Element], tables: Mapping[str, PrefixTable]) -> Learnt:
    """Sum up what the probes met. Rules: CNF-8."""
    widths: dict[str, set[tuple[int, bool]]] = {}
    users: dict[str, set[str]] = {}
    whole: set[str] = set()
    for what, key, *rest in met:
        if what == "value":
            widths.setdefault(str(key), set()).add((int(rest[0]), bool(rest[1])))
        elif what == "fixed":
            widths.setdefault(str(key), set()).add((int(rest[0]), False))
        elif what == "used":
            users.setdefault(str(rest[0]), set()).add(str(key))
        elif what == "bytes":
            whole.add(str(key))
    return Learnt(
        dict(elements),
        {key: frozenset(found) for key, found in widths.items()},
        {**_shipped(), **tables},
        {name: frozenset(found) for name, found in users.items()},
        frozenset(whole),
    )


def _shipped() -> dict[str, PrefixTable]:
    profile = load_profile()
    tables = [getattr(profile, name) for name in profile.__dataclass_fields__]
    found = [table for table in tables if isinstance(table, PrefixTable)]
    found += [shipped_table("mesh_delta_len", DELTA_X_LEN.rule), shipped_table("mvd", DELTA_MV_X_VLC.rule)]
    return {table.name: table for table in found}


def name_of(met: Met, learnt: Learnt) -> list[str]:
    """The cells of one thing that a probe met. Rules: CNF-8."""
    what, *rest = met
    if what == "value":
        key, n, _, name = rest
        if len(learnt.widths[str(key)]) == 1:
            return [f"element/{key}/{name}"]
        # Of a field of many widths the ends count in each.
        return [f"element/{key}/{n} bits, {name}"] if str(name).startswith(("min ", "max ")) else []
    if what == "fixed":
        key, n = rest
        return [f"element/{key}/read" if len(learnt.widths[str(key)]) == 1 else f"element/{key}/{n} bits"]
    if what == "used":
        key, name, symbol = rest
        words = learnt.tables[str(name)].words
        ends = {min(w.symbol for w in words): "smallest", max(w.symbol for w in words): "largest"}
        return [f"element/{key}/{ends[int(symbol)]} symbol"] if int(symbol) in ends else []
    if what == "noword":
        key, name = rest
        return [f"element/{key}/no word", f"word/{name}/no word"]
    if what in ("bytes", "read"):
        return [f"element/{rest[0]}/{rest[1] if what == 'bytes' else 'read'}"]
    if what == "outside":
        el = learnt.elements[str(rest[0])]
        return [f"error/{el.fault.__name__}/{el.domain_rule}"]
    if what == "group":
        return [f"group/{rest[0]}/{rest[1]}/{rest[2]}"]
    if what == "word":
        return [f"word/{rest[0]}/{rest[1]}"]
    if what == "dct":
        return [f"level/DCT FAP {rest[0]}/{_FRAMES[int(rest[1])]}/coded"]
    if what == "boundary":
        place = "behind the object start code" if rest[1] else "behind a plane"
        return [f"plane/FBA boundary/{place}/{BOUNDARIES[int(rest[0])]}"]
    if what == "stuffing":
        return [f"plane/mesh object/{'with' if rest[0] else 'without'} stuffing"]
    if what in ("segment", "model", "level"):
        key, intra, name = rest
        return [f"{what}/{key}/{_FRAMES[int(intra)]}/{name}"]
    return ["/".join(str(word) for word in met)]


def universe(learnt: Learnt, sources: Iterable[Source]) -> dict[str, Cell]:
    """Every cell that the declarations and the source know of. Rules: CNF-8."""
    found: dict[str, Cell] = {}
    sources = tuple(sources)
    for cells in (_of_elements(learnt), _of_words(learnt), _of_parameters(), _of_planes(), _of_registers(sources)):
        for cell in cells:
            found.setdefault(cell.key, cell)
    for source in sources:
        for branch in source.branches:
            found[branch.key] = Cell(branch.key, branch.rules)
    return found


def _of_elements(learnt: Learnt) -> Iterator[Cell]:
    declared = {key_of(el): el for el in ELEMENTS}
    for key, el in declared.items():
        own = (el.rule,) if el.domain_rule == el.rule else (el.rule, el.domain_rule)
        yield Cell(f"cut/{key}", own)
        yield from _error("Truncated", el.rule)
        if el.restricted:
            yield from _error(el.fault.__name__, el.domain_rule)
        widths = sorted(learnt.widths.get(key, ()))
        if el.fixed:
            for n, _ in widths if len(widths) > 1 else ():
                yield Cell(f"element/{key}/{n} bits", own)
            if len(widths) < 2:
                yield Cell(f"element/{key}/read", own)
            continue
        for n, signed in widths:
            several = len(widths) > 1
            for name in all_classes(el, n, signed) if not several else _ends(el, n, signed):
                yield Cell(f"element/{key}/{f'{n} bits, ' if several else ''}{name}", own)
        users = [name for name, keys in learnt.users.items() if key in keys]
        for name in users:
            for end in ("smallest symbol", "largest symbol", *(["no word"] if learnt.tables[name].kraft < 1 else [])):
                yield Cell(f"element/{key}/{end}", own)
            if learnt.tables[name].kraft < 1:
                yield from _error("ReservedValue", el.rule)
        for name in ("empty", "some") if key in learnt.bytes else ():
            yield Cell(f"element/{key}/{name}", own)
        if (
            not widths
            and not users
            and key not in learnt.bytes
            and key not in {key_of(segment) for segment in SEGMENTS}
        ):
            yield Cell(f"element/{key}/read", own)


def _ends(el: Element, n: int, signed: bool) -> list[str]:
    # One bit has no classes `min` and `max` of its own, and all widths are to be alike.
    return [name for name in all_classes(el, n, signed) if name.startswith(("min ", "max "))]


def _of_words(learnt: Learnt) -> Iterator[Cell]:
    for name, table in learnt.tables.items():
        for word in table.words:
            yield Cell(f"word/{name}/{word.symbol}", (table.rule,))
        if table.kraft < 1:
            yield Cell(f"word/{name}/no word", (table.rule,))


def _of_parameters() -> Iterator[Cell]:
    for parameters, segment in ((fap_set(), FAP_SEGMENT), (bap_set(), BAP_SEGMENT)):
        for g, group in enumerate(parameters.groups, 1):
            for value in range(4):
                word = "" if parameters.mask_type.allows(value) else "refused "
                yield Cell(f"group/{key_of(parameters.mask_type)}/{g}/{word}{value}", (parameters.mask_type.rule,))
            for name in _MASKS if len(group) > 1 else ("none", "all"):
                yield Cell(f"group/{key_of(parameters.group_mask)}/{g}/{name}", (parameters.group_mask.rule,))
        for number, label in enumerate(parameters.labels):
            if number and (parameters is not fap_set() or number > 2):
                yield from _levels(label, (segment.rule,))
                if parameters is fap_set():
                    for frame in _FRAMES.values():
                        yield Cell(f"level/DCT FAP {number}/{frame}/coded", ("DCT-1",))
    for label in (*VISEME_LABELS, *EXPRESSION_LABELS):
        yield from _levels(label, (VISEME_SEGMENT.rule,))
    for el in SEGMENTS:
        for intra, frame in _FRAMES.items():
            for kind in _SEGMENT_KINDS:
                yield Cell(f"segment/{key_of(el)}/{frame}/{kind}", (el.rule,))
            for kind in _MODEL_KINDS[intra]:
                yield Cell(f"model/{key_of(el)}/{frame}/{kind}", (el.rule,))


def _levels(label: str, own: tuple[str, ...]) -> Iterator[Cell]:
    for frame in _FRAMES.values():
        for name in _LEVELS:
            yield Cell(f"level/{label}/{frame}/{name}", own)


def _of_planes() -> Iterator[Cell]:
    for frame in _FRAMES.values():
        for code in ("with a start code", "without a start code"):
            for data in ("no data", "FAP", "BAP", "FAP and BAP"):
                yield Cell(f"plane/FBA/{frame}/{data}, {code}", ("FBA-5", "FBA-2"))
        for mode in ("arithmetic", "DCT"):
            yield Cell(f"plane/FBA/{frame}/{mode}", ("FBA-12",))
        for data in ("no data", "data"):
            yield Cell(f"plane/mesh/{frame}/{data}", ("MSH-2",))
    for kind in ("uniform", "Delaunay"):
        yield Cell(f"plane/mesh/intra/{kind}", ("MSH-30",))
    for place in ("behind the object start code", "behind a plane"):
        for name in BOUNDARIES.values():
            yield Cell(f"plane/FBA boundary/{place}/{name}", ("FBA-3", "FBA-42", "FBA-44"))
    for word in ("with", "without"):
        yield Cell(f"plane/mesh object/{word} stuffing", ("MSH-2",))


def _error(error: str, rule: str) -> Iterator[Cell]:
    yield Cell(f"error/{error}/{rule}", (rule,))
    yield Cell(f"rule/{rule}/broken", (rule,))


def _of_registers(sources: Iterable[Source]) -> Iterator[Cell]:
    for fault in FAULTS:
        error, rule, what = fault_key(fault)
        if error in ERROR_CLASSES:
            yield Cell(f"fault/{error}/{rule}/{what}", (rule,))
            yield from _error(error, rule)
    for source in sources:
        for error, rule in source.errors:
            yield from _error(error, rule)
    for entry in rules().values():
        if entry.built:
            yield Cell(f"rule/{entry.id}/named", (entry.id,))
    for kind in findings().values():
        yield Cell(f"finding/{kind.id}", (kind.rule,))
    for amb in ambiguities().values():
        for reading in amb.readings:
            yield Cell(f"reading/{amb.id}/{reading}", amb.rules)
    for name in Limits.names():
        yield Cell(f"limit/{name}/reached", ("CNF-22",))
        yield Cell(f"limit/{name}/passed", ("CNF-22",))
