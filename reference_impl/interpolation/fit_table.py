"""FIT documents: fields, validity, the graph and its order.

Rules: FIT-1, FIT-2, FIT-3, FIT-5 (impulses), FIT-6 (order of the sets), FIT-9, CNF-22 (sets, links), CNF-25.
Not implemented here: evaluation (`fit`, `fit_bulk`), the VRML/BT text form (`fit_text`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import Final, NoReturn

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation, ResourceLimit
from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES, as_object, float_list, int_list, parse_json

MAX_SETS: Final = 256
MAX_LINKS: Final = 1024
HIGH_LEVEL_VALUES: Final = {1: 3, 2: 4}
# Rows of the value list: FAP 3..68 have row FAP - 1, FAP 1 and 2 their seven values behind them.
VALUE_ROWS: Final = {1: (68, 69, 70), 2: (71, 72, 73, 74)}
VALUE_COUNT: Final = 75
FIT_FIELDS: Final[dict[str, tuple[str, int, int]]] = {
    "FAPs": ("FIT-1", -1, 68),
    "Graph": ("FIT-2", 0, MAX_LINKS),
    "numeratorExp": ("FIT-3", 0, 15),
    "denominatorExp": ("FIT-3", 0, 15),
    "numeratorImpulse": ("FIT-5", 0, 1023),
    "numeratorTerms": ("FIT-3", 0, 10),
    "denominatorTerms": ("FIT-3", 0, 10),
}
FIT_COEFS: Final[tuple[str, ...]] = ("numeratorCoefs", "denominatorCoefs")


@dataclass(frozen=True, slots=True)
class Term:
    """One product of equation 1.

    Rules: FIT-4, FIT-5. `coef`: c_i or b_i. `powers`: (row of the value list, exponent) in parent order,
    exponents of 0 left out. `impulse`: (row, value) that must match for the term to count, or None.
    """

    coef: float
    powers: tuple[tuple[int, int], ...]
    impulse: tuple[int, int] | None


@dataclass(frozen=True, slots=True)
class FitFunction:
    """The rational function of one child FAP in one link.

    Rules: FIT-3, FIT-4. `denominator` is empty where it is 1.
    """

    fap: int
    numerator: tuple[Term, ...]
    denominator: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class FitLink:
    """One link: parent set, child set, one function per child FAP.

    Rules: FIT-2, FIT-3.
    """

    parent: int
    child: int
    functions: tuple[FitFunction, ...]


@dataclass(frozen=True, slots=True)
class FitTable:
    """A valid FIT.

    Rules: FIT-1, FIT-2, FIT-6. `sets`: FAP numbers. `links`: in Graph order. `order`: the child sets in the
    order of one pass. `incoming`: the links of each set, in Graph order.
    """

    sets: tuple[tuple[int, ...], ...]
    links: tuple[FitLink, ...]
    order: tuple[int, ...]
    incoming: tuple[tuple[FitLink, ...], ...]


def _sets(faps: Sequence[int], limit: int) -> tuple[list[tuple[int, ...]], list[int]]:
    sets: list[tuple[int, ...]] = []
    starts: list[int] = []
    current: list[int] = []
    for i, fap in enumerate(faps):
        path = f"FAPs[{i}]"
        if fap == 0 or not -1 <= fap <= 68:
            raise RangeViolation("FIT-1", "FAPs", value=fap, allowed="-1, 1..68", path=path)
        if fap != -1:
            if len(sets) == limit:
                raise ResourceLimit("CNF-22", "FAPs", value=limit + 1, allowed=f"at most {limit} sets", path=path)
            current.append(fap)
            continue
        if not current:
            raise InconsistentSemantics("FIT-1", "FAPs", value=-1, allowed="sets that are not empty", path=path)
        sets.append(tuple(current))
        starts.append(i - len(current))
        current = []
    if current:
        raise InconsistentSemantics(
            "FIT-1", "FAPs", value="open set", allowed="-1 behind every set", path=f"FAPs[{len(faps)}]",
            expected=len(faps) + 1,
        )  # fmt: skip
    return sets, starts


def _pairs(
    graph: Sequence[int], sets: Sequence[tuple[int, ...]], starts: Sequence[int], limit: int
) -> list[tuple[int, int]]:
    if len(graph) > 2 * limit:
        raise ResourceLimit(
            "CNF-22",
            "Graph",
            value=(len(graph) + 1) // 2,
            allowed=f"at most {limit} links",
            path=f"Graph[{2 * limit}]",
        )
    for i, number in enumerate(graph):
        if not 0 <= number < len(sets):
            allowed = f"0..{len(sets) - 1}" if sets else "nothing, as there is no set"
            raise RangeViolation("FIT-2", "Graph", value=number, allowed=allowed, path=f"Graph[{i}]")
    if len(graph) % 2:
        raise InconsistentSemantics(
            "FIT-2", "Graph", value=len(graph), allowed="pairs (parent set, child set)",
            path=f"Graph[{len(graph)}]", expected=len(graph) + 1,
        )  # fmt: skip
    pairs = list(zip(graph[::2], graph[1::2], strict=True))
    for child in sorted({child for _, child in pairs}):
        for i, fap in enumerate(sets[child]):
            if fap in HIGH_LEVEL_VALUES:
                raise RangeViolation(
                    "FIT-1",
                    "FAPs",
                    value=fap,
                    allowed="3..68 in a child set",
                    path=f"FAPs[{starts[child] + i}]",
                )
    return pairs


def _length(fields: Mapping[str, Sequence[float]], name: str, expected: int) -> None:
    count = len(fields[name])
    if count != expected:
        raise InconsistentSemantics(
            FIT_FIELDS.get(name, ("FIT-3",))[0], name, value=count, allowed=f"{expected} entries",
            path=f"{name}[{min(count, expected)}]", expected=expected,
        )  # fmt: skip


def _ranges(fields: Mapping[str, Sequence[int]]) -> None:
    for name, (rule, lo, hi) in FIT_FIELDS.items():
        if name in ("FAPs", "Graph"):
            continue
        for i, value in enumerate(fields[name]):
            if not lo <= value <= hi:
                raise RangeViolation(rule, name, value=value, allowed=f"{lo}..{hi}", path=f"{name}[{i}]")


def _order(sets: Sequence[tuple[int, ...]], pairs: Sequence[tuple[int, int]]) -> tuple[int, ...]:
    """The child sets, each after all that can supply a FAP of one of its parents; what is left, by number."""
    children = sorted({child for _, child in pairs})
    suppliers: dict[int, list[int]] = {}
    for child in children:
        for fap in set(sets[child]):
            suppliers.setdefault(fap, []).append(child)
    # A set that can supply a FAP of its own parent cannot come after itself: it is a cycle of one.
    waits: dict[int, set[int]] = {child: set() for child in children}
    for parent, child in pairs:
        for fap in set(sets[parent]):
            waits[child].update(suppliers.get(fap, ()))
    behind: dict[int, list[int]] = {child: [] for child in children}
    for child, before in waits.items():
        for supplier in before:
            behind[supplier].append(child)
    ready = [child for child in children if not waits[child]]
    heapify(ready)
    open_count = {child: len(before) for child, before in waits.items()}
    order: list[int] = []
    while ready:
        child = heappop(ready)
        order.append(child)
        for later in behind[child]:
            open_count[later] -= 1
            if open_count[later] == 0:
                heappush(ready, later)
    placed = set(order)
    return (*order, *(child for child in children if child not in placed))


def _impulse_fault(value: int, allowed: str, index: int) -> NoReturn:
    raise RangeViolation("FIT-5", "numeratorImpulse", value=value, allowed=allowed, path=f"numeratorImpulse[{index}]")


def _impulse(parent: Sequence[int], pair: tuple[int, int], index: int, reading: str) -> tuple[int, int]:
    """The row and value of an impulse pair (AMB-FIT-1)."""
    rows = [row for fap in parent for row in VALUE_ROWS.get(fap, (fap - 1,))]
    number, value = pair
    if reading == "within-fap":
        high = next(fap for fap in parent if fap in HIGH_LEVEL_VALUES)
        rows = list(VALUE_ROWS[high])
    base = 1 if reading == "from-1" else 0
    if not base <= number < len(rows) + base:
        _impulse_fault(number, f"{base}..{len(rows) + base - 1}", index)
    return rows[number - base], value


def build_fit(
    fields: Mapping[str, Sequence[int]],
    coefs: Mapping[str, Sequence[float]],
    *,
    impulse: str = "from-0",
    max_sets: int = MAX_SETS,
    max_links: int = MAX_LINKS,
) -> FitTable:
    """A table from the nine fields of the node, checked.

    Rules: FIT-1, FIT-2, FIT-3, FIT-5, FIT-9, CNF-22. Absent fields are empty.

    `fields`: the seven MFInt32 by name. `coefs`: numeratorCoefs, denominatorCoefs. `impulse`: reading of
    AMB-FIT-1: "from-0" (over the whole parent list), "1" (from 1), "within" (from 0 within the first FAP 1
    or 2 of the parent set). Raises one error naming field, index and expected length: `RangeViolation` (FAP 0
    or past 68, set past the sets, FAP 1 or 2 in a child set, an entry outside its field's range, a value
    number past the parents' values), `InconsistentSemantics` (empty or open set, list lengths),
    `ResourceLimit`.
    """
    whole = {name: fields.get(name, ()) for name in FIT_FIELDS}
    parts = {name: coefs.get(name, ()) for name in FIT_COEFS}
    sets, starts = _sets(whole["FAPs"], max_sets)
    pairs = _pairs(whole["Graph"], sets, starts, max_links)
    _ranges(whole)
    functions = sum(len(sets[child]) for _, child in pairs)
    _length(whole, "numeratorTerms", functions)
    _length(whole, "denominatorTerms", functions)
    widths = [sum(HIGH_LEVEL_VALUES.get(fap, 1) for fap in sets[parent]) for parent, _ in pairs]
    pulsed = [any(fap in HIGH_LEVEL_VALUES for fap in sets[parent]) for parent, _ in pairs]
    numerators, denominators = iter(whole["numeratorTerms"]), iter(whole["denominatorTerms"])
    counts = [
        (sum(next(numerators) for _ in sets[child]), sum(next(denominators) for _ in sets[child])) for _, child in pairs
    ]
    _length(whole, "numeratorExp", sum(width * k for width, (k, _) in zip(widths, counts, strict=True)))
    _length(whole, "denominatorExp", sum(width * p for width, (_, p) in zip(widths, counts, strict=True)))
    _length(whole, "numeratorImpulse", sum(2 * k for on, (k, _) in zip(pulsed, counts, strict=True) if on))
    _length(parts, "numeratorCoefs", sum(k for k, _ in counts))
    _length(parts, "denominatorCoefs", sum(p for _, p in counts))
    return _assemble(whole, parts, sets, pairs, impulse)


class _Cursor:
    """Reads the lists from front to back; their lengths have been checked."""

    def __init__(self, exponents: Sequence[int], coefs: Sequence[float], impulses: Sequence[int], reading: str) -> None:
        self._exponents = exponents
        self._coefs = coefs
        self._impulses = impulses
        self._reading = reading
        self._exponent = self._coef = self._impulse = 0

    def terms(self, count: int, parent: Sequence[int], pulsed: bool) -> tuple[Term, ...]:
        rows = [row for fap in parent for row in VALUE_ROWS.get(fap, (fap - 1,))]
        out: list[Term] = []
        for _ in range(count):
            exponents = self._exponents[self._exponent : self._exponent + len(rows)]
            self._exponent += len(rows)
            impulse = None
            if pulsed:
                at = self._impulse
                self._impulse += 2
                pair = self._impulses[at], self._impulses[at + 1]
                impulse = _impulse(parent, pair, at, self._reading)
            powers = tuple((row, exponent) for row, exponent in zip(rows, exponents, strict=True) if exponent)
            out.append(Term(float(self._coefs[self._coef]), powers, impulse))
            self._coef += 1
        return tuple(out)


def _assemble(
    whole: Mapping[str, Sequence[int]],
    parts: Mapping[str, Sequence[float]],
    sets: Sequence[tuple[int, ...]],
    pairs: Sequence[tuple[int, int]],
    reading: str,
) -> FitTable:
    numerator = _Cursor(whole["numeratorExp"], parts["numeratorCoefs"], whole["numeratorImpulse"], reading)
    denominator = _Cursor(whole["denominatorExp"], parts["denominatorCoefs"], (), reading)
    links: list[FitLink] = []
    number = 0
    for parent, child in pairs:
        pulsed = any(fap in HIGH_LEVEL_VALUES for fap in sets[parent])
        functions: list[FitFunction] = []
        for fap in sets[child]:
            functions.append(
                FitFunction(
                    fap,
                    numerator.terms(whole["numeratorTerms"][number], sets[parent], pulsed),
                    denominator.terms(whole["denominatorTerms"][number], sets[parent], False),
                )
            )
            number += 1
        links.append(FitLink(parent, child, tuple(functions)))
    incoming = tuple(tuple(link for link in links if link.child == i) for i in range(len(sets)))
    return FitTable(tuple(sets), tuple(links), _order(sets, pairs), incoming)


def fit_from_json(
    value: object, *, impulse: str = "from-0", max_sets: int = MAX_SETS, max_links: int = MAX_LINKS
) -> FitTable:
    """A table from parsed JSON: one object with the nine field names.

    Rules: FIT-1, FIT-9, CNF-25. Absent fields are empty, keys that are not known are ignored. Raises
    `InputFormat` (types) and what `build_fit` raises.
    """
    root = as_object(value, "", "FIT-9")
    if root and not any(name in root for name in (*FIT_FIELDS, *FIT_COEFS)):
        # Some other document; an empty object is an empty table.
        raise InputFormat("FIT-9", "FIT", value="no field of one", allowed=", ".join((*FIT_FIELDS, *FIT_COEFS)))
    fields = {name: int_list(root.get(name, []), name, rule) for name, (rule, _, _) in FIT_FIELDS.items()}
    coefs = {name: float_list(root.get(name, []), name, "FIT-3") for name in FIT_COEFS}
    return build_fit(fields, coefs, impulse=impulse, max_sets=max_sets, max_links=max_links)


def parse_fit_json(
    data: bytes | str,
    *,
    impulse: str = "from-0",
    max_sets: int = MAX_SETS,
    max_links: int = MAX_LINKS,
    limit: int = MAX_JSON_BYTES,
) -> FitTable:
    """A table from JSON text.

    Rules: FIT-1, FIT-9, CNF-22, CNF-25. Raises as `fit_from_json`; `InputFormat` with line and column where
    the text is not JSON.
    """
    value = parse_json(data, rule="FIT-9", what="FIT document", limit=limit)
    return fit_from_json(value, impulse=impulse, max_sets=max_sets, max_links=max_links)


def fit_to_fields(table: FitTable) -> dict[str, list[float]]:
    """The nine fields of a table, ready for `json.dumps`; reading them back gives the same table.

    Rules: FIT-1, FIT-2, FIT-3, FIT-5. Impulses are counted from 0 over the whole parent list.
    """
    # In the seven integer fields every entry is an int, which is a float to the type checker.
    out: dict[str, list[float]] = {name: [] for name in (*FIT_FIELDS, *FIT_COEFS)}
    for faps in table.sets:
        out["FAPs"] += [*faps, -1]
    for link in table.links:
        out["Graph"] += [link.parent, link.child]
        rows = [row for fap in table.sets[link.parent] for row in VALUE_ROWS.get(fap, (fap - 1,))]
        for function in link.functions:
            for side, terms in (("numerator", function.numerator), ("denominator", function.denominator)):
                out[f"{side}Terms"].append(len(terms))
                for term in terms:
                    out[f"{side}Coefs"].append(term.coef)
                    left = list(term.powers)
                    for row in rows:
                        # A FAP that stands twice in the parent set has two columns of exponents.
                        exponent = left.pop(0)[1] if left and left[0][0] == row else 0
                        out[f"{side}Exp"].append(exponent)
                    if term.impulse is not None:
                        out["numeratorImpulse"] += [rows.index(term.impulse[0]), term.impulse[1]]
    return out
