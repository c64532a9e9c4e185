"""FIT evaluation over whole sequences: numpy over frames, the float64 operations of `fit` in the same order.

Rules: FIT-4, FIT-5, FIT-6, FIT-7. The results are identical to `fit.evaluate`, bit for bit: elementwise
products, sums and quotients only, no pow(), no reductions. Not implemented here: FIT-8
(`fit.apply_symmetry`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.interpolation.fit import DEFAULT_READINGS, FitReadings
from snhc.reference_impl.interpolation.fit_table import VALUE_COUNT, FitFunction, FitLink, FitTable, Term
from snhc.reference_impl.interpolation.frames_json import AVAILABLE_STATES, FAP_COUNT, FrameLine

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

BLOCK_FRAMES: Final = 2048


def block_arrays(frames: Sequence[FrameLine]) -> tuple[FloatArray, BoolArray]:
    """The values and flags of `fit.value_list` for many frames: float64 (75, N) and bool (68, N).

    Rules: FIT-5, FIT-6.
    """
    count = len(frames)
    values = np.empty((VALUE_COUNT, count))
    # numpy reads None as NaN.
    values[:FAP_COUNT] = np.array([frame.faps for frame in frames], dtype=np.float64).reshape(count, FAP_COUNT).T
    none3, none4 = (None,) * 3, (None,) * 4
    values[68:71] = np.array([f.viseme or none3 for f in frames], dtype=np.float64).reshape(count, 3).T
    values[71:75] = np.array([f.expression or none4 for f in frames], dtype=np.float64).reshape(count, 4).T
    states = np.frombuffer("".join(frame.state for frame in frames).encode("ascii"), dtype=np.uint8)
    available = np.isin(states.reshape(count, FAP_COUNT).T, np.frombuffer(AVAILABLE_STATES.encode(), dtype=np.uint8))
    available[0] &= ~np.isnan(values[68])
    available[1] &= ~np.isnan(values[71])
    available[2:] &= ~np.isnan(values[2:FAP_COUNT])
    return values, available


def _sum(terms: Sequence[Term], rows: dict[int, FloatArray], count: int) -> FloatArray:
    total = np.zeros(count)
    for term in terms:
        product: FloatArray | None = None
        for row, exponent in term.powers:
            base = rows[row]
            power = base
            for _ in range(exponent - 1):
                power = power * base
            # The literal form starts from 1.0, and 1.0 * power is power.
            product = power if product is None else product * power
        value = np.full(count, term.coef) if product is None else term.coef * product
        if term.impulse is not None:
            value = np.where(rows[term.impulse[0]] == term.impulse[1], value, 0.0)
        total += value
    return total


def _function(
    function: FitFunction, rows: dict[int, FloatArray], count: int, readings: FitReadings
) -> tuple[FloatArray, BoolArray]:
    result = _sum(function.numerator, rows, count)
    defined = np.ones(count, dtype=np.bool_)
    if function.denominator:
        denominator = _sum(function.denominator, rows, count)
        defined = denominator != 0
        result = result / denominator
    defined &= np.isfinite(result)
    whole = np.trunc(result)
    if readings.undefined == "zero-truncated":
        return np.where(defined, whole, 0.0) + 0.0, np.ones(count, dtype=np.bool_)
    away = np.abs(result - whole) >= 0.5
    return whole + np.where(away, np.sign(result), 0.0) + 0.0, defined


def _rows_of(function: FitFunction) -> set[int]:
    terms = (*function.numerator, *function.denominator)
    rows = {row for term in terms for row, _ in term.powers}
    return rows | {term.impulse[0] for term in terms if term.impulse is not None}


def interpolate_block(
    table: FitTable, values: FloatArray, available: BoolArray, readings: FitReadings = DEFAULT_READINGS
) -> BoolArray:
    """Fill values and flags of many frames in place; returns which FAPs were given a value, bool (68, N).

    Rules: FIT-4, FIT-5, FIT-6, FIT-7 (AMB-FIT-2, AMB-FIT-3). `values`: float64 (75, N), `available`: bool
    (68, N), as `block_arrays` makes them. A frame whose last pass changed nothing is not changed by further
    passes, so that all frames can go through the passes together.
    """
    given = np.zeros_like(available)
    parents = [np.array(faps, dtype=np.intp) - 1 for faps in table.sets]
    needs = {id(function): _rows_of(function) for link in table.links for function in link.functions}

    def give(link: FitLink, place: int) -> bool:
        function = link.functions[place]
        fap = function.fap - 1
        wanted = ~available[fap]
        if not wanted.any():
            return False
        wanted &= available[parents[link.parent]].all(axis=0)
        index = np.flatnonzero(wanted)
        if not len(index):
            return False
        rows = {row: values[row, index] for row in needs[id(function)]}
        result, defined = _function(function, rows, len(index), readings)
        index = index[defined]
        if not len(index):
            return False
        values[fap, index] = result[defined]
        available[fap, index] = True
        given[fap, index] = True
        return True

    changed = True
    with np.errstate(all="ignore"):
        if readings.order == "link-order":
            for link in table.links:
                for place in range(len(link.functions)):
                    give(link, place)
            return given
        while changed:
            changed = False
            for child in table.order:
                for place in range(len(table.sets[child])):
                    for link in table.incoming[child]:
                        changed |= give(link, place)
    return given


def _written(frames: Sequence[FrameLine], values: FloatArray, given: BoolArray) -> Iterator[FrameLine]:
    where = np.flatnonzero(given.any(axis=1))
    columns = [(int(fap), values[fap].tolist(), given[fap].tolist()) for fap in where]
    for n, frame in enumerate(frames):
        hits = [(fap, column[n]) for fap, column, flags in columns if flags[n]]
        if not hits:
            yield frame
            continue
        faps, state = list(frame.faps), list(frame.state)
        for fap, value in hits:
            faps[fap] = int(value)
            state[fap] = "F"
        yield frame.with_faps(tuple(faps), "".join(state))


def evaluate_sequence(
    table: FitTable,
    frames: Iterable[FrameLine],
    readings: FitReadings = DEFAULT_READINGS,
    *,
    block: int = BLOCK_FRAMES,
) -> Iterator[FrameLine]:
    """`fit.evaluate` for every frame of a sequence, identical results.

    Rules: FIT-4, FIT-5, FIT-6, FIT-7, CNF-2. `block`: frames that are held at a time.
    """
    source = iter(frames)
    while held := list(islice(source, block)):
        values, available = block_arrays(held)
        given = interpolate_block(table, values, available, readings)
        yield from _written(held, values, given)
