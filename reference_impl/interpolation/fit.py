"""FIT evaluation, frame by frame in pure Python: the reference.

Rules: FIT-4, FIT-5, FIT-6, FIT-7, FIT-8. The table and its JSON form are in `fit_table` and offered here too;
whole sequences at once: `fit_bulk`, with identical results. Readings in `FitReadings`: AMB-FIT-1 (taken when
a table is read), AMB-FIT-2, AMB-FIT-3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, trunc
from pathlib import Path
from typing import Final

from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES
from snhc.reference_impl.interpolation.fit_table import (
    FIT_COEFS,
    FIT_FIELDS,
    MAX_LINKS,
    MAX_SETS,
    VALUE_COUNT,
    FitFunction,
    FitLink,
    FitTable,
    Term,
    build_fit,
    fit_from_json,
    fit_to_fields,
    parse_fit_json,
)
from snhc.reference_impl.interpolation.frames_json import AVAILABLE_STATES, FrameLine
from snhc.reference_impl.tables import left_right_pairs

__all__ = [
    "FIT_COEFS",
    "FIT_FIELDS",
    "MAX_LINKS",
    "MAX_SETS",
    "FitFunction",
    "FitLink",
    "FitReadings",
    "FitTable",
    "Term",
    "apply_symmetry",
    "build_fit",
    "evaluate",
    "fit_from_json",
    "fit_to_fields",
    "function_value",
    "interpolate",
    "load_fit",
    "parse_fit",
    "parse_fit_json",
    "round_half_away",
    "value_list",
]

SYMMETRY_AVAILABLE: Final = AVAILABLE_STATES


@dataclass(frozen=True, slots=True)
class FitReadings:
    """Which reading of each ambiguity is followed; the defaults are the register's.

    Rules: FIT-5, FIT-6, FIT-7. `impulse` (AMB-FIT-1): "from-0", "from-1" or "within-fap", taken when the
    table is read. `undefined` (AMB-FIT-2): "next-nearest" or "zero-truncated". `order` (AMB-FIT-3):
    "topological" or "link-order" (the links in Graph order, one pass).
    """

    impulse: str = "from-0"
    undefined: str = "next-nearest"
    order: str = "topological"


DEFAULT_READINGS: Final = FitReadings()


def load_fit(
    path: Path,
    readings: FitReadings = DEFAULT_READINGS,
    *,
    max_sets: int = MAX_SETS,
    max_links: int = MAX_LINKS,
    limit: int = MAX_JSON_BYTES,
) -> FitTable:
    """A table from a file of either form.

    Rules: FIT-1, FIT-9, CNF-2. Raises as `parse_fit`; `OSError` where the file cannot be read.
    """
    with path.open("rb") as file:
        data = file.read(limit + 1)
    return parse_fit(data, readings, max_sets=max_sets, max_links=max_links, limit=limit)


def parse_fit(
    data: bytes,
    readings: FitReadings = DEFAULT_READINGS,
    *,
    max_sets: int = MAX_SETS,
    max_links: int = MAX_LINKS,
    limit: int = MAX_JSON_BYTES,
) -> FitTable:
    """A table from JSON or from the VRML/BT text form, told apart by content.

    Rules: FIT-1, FIT-9, CNF-2, CNF-22. `limit`: bytes. Raises as the two parsers.
    """
    from snhc.reference_impl.interpolation.fit_text import parse_fit_text

    as_json = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] in (b"{", b"[")
    parse = parse_fit_json if as_json else parse_fit_text
    return parse(data, impulse=readings.impulse, max_sets=max_sets, max_links=max_links, limit=limit)


def _power(base: float, exponent: int) -> float:
    # Left to right: the same bits on every platform, which pow() does not promise.
    out = base
    for _ in range(exponent - 1):
        out *= base
    return out


def _sum(terms: Sequence[Term], values: Sequence[float]) -> float:
    total = 0.0
    for term in terms:
        if term.impulse is not None and values[term.impulse[0]] != term.impulse[1]:
            continue
        product = 1.0
        for row, exponent in term.powers:
            product *= _power(values[row], exponent)
        total += term.coef * product
    return total


def round_half_away(value: float) -> float:
    """The nearest integer as a float, halves away from zero; exact for every finite float64. Rules: FIT-7."""
    whole = float(trunc(value))
    if abs(value - whole) >= 0.5:
        return whole + (1.0 if value > 0 else -1.0)
    return whole


def function_value(
    function: FitFunction, values: Sequence[float], readings: FitReadings = DEFAULT_READINGS
) -> float | None:
    """Equation 1 for one frame, rounded; None where it is undefined.

    Rules: FIT-4, FIT-5, FIT-7 (AMB-FIT-2). float64, in the order of the table: each power by repeated
    multiplication, products and sums from left to right, the coefficient times the product. `values`: the
    list of `value_list`.
    """
    result = _sum(function.numerator, values)
    if function.denominator:
        denominator = _sum(function.denominator, values)
        if denominator == 0:
            return 0.0 if readings.undefined == "zero-truncated" else None
        result /= denominator
    if not isfinite(result):
        return 0.0 if readings.undefined == "zero-truncated" else None
    # Adding 0.0 makes a negative zero positive.
    return (float(trunc(result)) if readings.undefined == "zero-truncated" else round_half_away(result)) + 0.0


def value_list(frame: FrameLine) -> tuple[list[float], list[bool]]:
    """The values of a frame and which FAPs are available.

    Rules: FIT-5, FIT-6. Returns 75 floats (FAP f in place f - 1; viseme_select1, viseme_select2,
    viseme_blend, expression_select1, expression_intensity1, expression_select2, expression_intensity2 behind
    FAP 68; NaN where there is none) and 68 flags: state T, R or F.
    """
    nan = float("nan")
    values = [nan if fap is None else float(fap) for fap in frame.faps]
    values += [nan] * 3 if frame.viseme is None else map(float, frame.viseme[:3])
    values += [nan] * 4 if frame.expression is None else map(float, frame.expression[:4])
    available = [letter in AVAILABLE_STATES for letter in frame.state]
    available[0] = available[0] and frame.viseme is not None
    available[1] = available[1] and frame.expression is not None
    for i in range(2, 68):
        available[i] = available[i] and frame.faps[i] is not None
    return values, available


def interpolate(
    table: FitTable, values: list[float], available: list[bool], readings: FitReadings = DEFAULT_READINGS
) -> list[int]:
    """Fill values and flags in place; returns the FAPs that were given a value, in the order in which it
    happened.

    Rules: FIT-6, FIT-7 (AMB-FIT-2, AMB-FIT-3). Child sets in `table.order`; for each unavailable FAP the
    first usable link in Graph order whose function is defined; a value is available at once and never
    changed; passes repeat until nothing changes.
    """
    assert len(values) == VALUE_COUNT
    given: list[int] = []

    def give(link: FitLink, place: int) -> bool:
        fap = link.functions[place].fap
        if available[fap - 1] or not all(available[parent - 1] for parent in table.sets[link.parent]):
            return False
        value = function_value(link.functions[place], values, readings)
        if value is None:
            return False
        values[fap - 1] = value
        available[fap - 1] = True
        given.append(fap)
        return True

    if readings.order == "link-order":
        for link in table.links:
            for place in range(len(link.functions)):
                give(link, place)
        return given
    changed = True
    while changed:
        before = len(given)
        for child in table.order:
            for place in range(len(table.sets[child])):
                any(give(link, place) for link in table.incoming[child])
        changed = len(given) > before
    return given


def evaluate(table: FitTable, frame: FrameLine, readings: FitReadings = DEFAULT_READINGS) -> FrameLine:
    """The frame with the FAPs that the table gives, state F.

    Rules: FIT-4, FIT-5, FIT-6, FIT-7, CNF-2. Only unavailable FAPs are written; values are not clipped.
    """
    values, available = value_list(frame)
    given = interpolate(table, values, available, readings)
    if not given:
        return frame
    faps, state = list(frame.faps), list(frame.state)
    for fap in given:
        faps[fap - 1] = int(values[fap - 1])
        state[fap - 1] = "F"
    return frame.with_faps(tuple(faps), "".join(state))


def apply_symmetry(frame: FrameLine) -> FrameLine:
    """Where one side of a left/right pair is available and the other is not, the other side copies it, state
    S.

    Rules: FIT-8. Informative, on request only, after FIT; never scored.
    """
    faps, state = list(frame.faps), list(frame.state)
    for pair in left_right_pairs():
        for fap, other in (pair, pair[::-1]):
            if frame.state[fap - 1] in SYMMETRY_AVAILABLE and frame.state[other - 1] in "IU":
                faps[other - 1] = frame.faps[fap - 1]
                state[other - 1] = "S"
    return frame.with_faps(tuple(faps), "".join(state))
