"""Laws of FIT and FAT: both forms agree, what is sent stays, tables go out and in, generation gives the poses
back.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from snhc.reference_impl.interpolation.fit import (
    FitReadings,
    FitTable,
    apply_symmetry,
    evaluate,
    fit_from_json,
    fit_to_fields,
    round_half_away,
)
from snhc.reference_impl.interpolation.fit_bulk import evaluate_sequence
from snhc.reference_impl.interpolation.fit_text import fit_text, parse_fit_text
from snhc.reference_impl.interpolation.frames_json import FrameLine, faces_line, frame_from_json
from snhc.reference_impl.model import fat
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.fat_generate import generate_table

WIDTH = {1: 3, 2: 4}
LOW = st.integers(3, 9)
COEFS = st.sampled_from([0.0, 1.0, -1.0, 0.5, -0.75, 2.0, 1 / 3, 1e200])


@st.composite
def fit_fields(draw: st.DrawFn) -> dict[str, list[float]]:
    """Small random tables that share FAPs and have cycles, impulses and denominators."""
    sets = draw(st.lists(st.lists(LOW, min_size=1, max_size=3), min_size=1, max_size=5))
    sets += draw(st.lists(st.lists(st.sampled_from([1, 2, 3]), min_size=1, max_size=2), max_size=2))
    children = [i for i, faps in enumerate(sets) if not {1, 2} & set(faps)]
    number = st.integers(0, len(sets) - 1)
    links = draw(st.lists(st.tuples(number, st.sampled_from(children)), max_size=6))
    out: dict[str, list[float]] = {name: [] for name in fit_to_fields(fit_from_json({}))}
    out["FAPs"] = [entry for faps in sets for entry in (*faps, -1)]
    for parent, child in links:
        out["Graph"] += [parent, child]
        width = sum(WIDTH.get(fap, 1) for fap in sets[parent])
        for _ in sets[child]:
            for side, most in (("numerator", 3), ("denominator", 2)):
                terms = draw(st.integers(0, most))
                out[f"{side}Terms"].append(terms)
                size = terms * width
                out[f"{side}Exp"] += draw(st.lists(st.integers(0, 3), min_size=size, max_size=size))
                out[f"{side}Coefs"] += draw(st.lists(COEFS, min_size=terms, max_size=terms))
                if side == "numerator" and {1, 2} & set(sets[parent]):
                    for _ in range(terms):
                        out["numeratorImpulse"] += [draw(st.integers(0, width - 1)), draw(st.integers(0, 3))]
    return out


@st.composite
def face_frames(draw: st.DrawFn) -> FrameLine:
    faps: list[int | None] = [None] * 68
    state = ["U"] * 68
    line: dict[str, object] = {"index": 0, "time": "0/1", "intra": True, "viseme": None, "expression": None}
    for fap in range(3, 10):
        letter = draw(st.sampled_from("TRIUU"))
        state[fap - 1] = letter
        if letter in "TR":
            faps[fap - 1] = draw(st.one_of(st.integers(-3, 3), st.integers(-(10**6), 10**6), st.just(10**120)))
    small = st.integers(0, 3)
    if draw(st.booleans()):
        state[0] = "T"
        line["viseme"] = {"select1": draw(small), "select2": draw(small), "blend": draw(small)}
    if draw(st.booleans()):
        state[1] = "R"
        line["expression"] = {name: draw(small) for name in ("select1", "intensity1", "select2", "intensity2")}
    return frame_from_json({**line, "faps": faps, "state": "".join(state)})


READINGS = st.builds(
    FitReadings,
    undefined=st.sampled_from(["next-nearest", "zero-truncated"]),
    order=st.sampled_from(["topological", "link-order"]),
)


@settings(max_examples=300)
@given(fit_fields(), st.lists(face_frames(), max_size=6), READINGS, st.integers(1, 7))
def test_vectorised_fit_is_frame_by_frame_fit(
    fields: dict[str, list[float]], frames: list[FrameLine], readings: FitReadings, block: int
) -> None:
    table = fit_from_json(fields)
    wanted = [evaluate(table, frame, readings) for frame in frames]
    assert list(evaluate_sequence(table, frames, readings, block=block)) == wanted


def exact(table: FitTable, frame: FrameLine) -> FrameLine:
    """FIT-6 with exact fractions: another way to the same numbers while float64 is exact enough."""
    values: dict[int, Fraction] = {}
    high: dict[int, tuple[int, ...] | None] = {1: frame.viseme, 2: frame.expression}
    ready = {i + 1 for i, letter in enumerate(frame.state) if letter in "TR"}
    for row, value in enumerate(frame.faps):
        values[row] = Fraction(value or 0)
    for row, value in enumerate((*(high[1] or (0,) * 3), *(high[2] or (0,) * 4)), 68):
        values[row] = Fraction(value)

    def total(terms: Any) -> Fraction:
        out = Fraction(0)
        for term in terms:
            if term.impulse is None or values[term.impulse[0]] == term.impulse[1]:
                product = Fraction(term.coef)
                for row, power in term.powers:
                    product *= values[row] ** power
                out += product
        return out

    faps, state = list(frame.faps), list(frame.state)
    again = True
    while again:
        again = False
        for child in table.order:
            for place, fap in enumerate(table.sets[child]):
                for link in table.incoming[child]:
                    function = link.functions[place]
                    below = total(function.denominator) if function.denominator else Fraction(1)
                    if fap in ready or not ready.issuperset(table.sets[link.parent]) or below == 0:
                        continue
                    result = total(function.numerator) / below
                    nearest = int(abs(result) + Fraction(1, 2)) * (1 if result >= 0 else -1)
                    values[fap - 1] = Fraction(nearest)
                    faps[fap - 1], state[fap - 1] = nearest, "F"
                    ready.add(fap)
                    again = True
    return frame.with_faps(tuple(faps), "".join(state))


@st.composite
def dyadic(draw: st.DrawFn) -> tuple[FitTable, FrameLine]:
    """Tables whose arithmetic is exact in float64: no denominators, coefficients of few bits, two layers at
    most.
    """
    fields = draw(fit_fields())
    fields["numeratorCoefs"] = [0.5 if c > 1e9 or c == 1 / 3 else c for c in fields["numeratorCoefs"]]
    fields["numeratorExp"] = [min(e, 1) for e in fields["numeratorExp"]]
    fields["denominatorTerms"] = [0] * len(fields["denominatorTerms"])
    fields["denominatorExp"], fields["denominatorCoefs"] = [], []
    frame = draw(face_frames())
    faps = tuple(None if v is None else v % 7 - 3 for v in frame.faps)
    return fit_from_json(fields), frame.with_faps(faps, frame.state)


@given(dyadic())
def test_fit_against_exact_fractions(case: tuple[FitTable, FrameLine]) -> None:
    table, frame = case
    got, wanted = evaluate(table, frame), exact(table, frame)
    if all(abs(value or 0) < 2**40 for value in wanted.faps):
        assert (got.faps, got.state) == (wanted.faps, wanted.state)


@given(fit_fields(), face_frames())
def test_fit_writes_unavailable_faps_only_and_is_idempotent(fields: dict[str, list[float]], frame: FrameLine) -> None:
    table = fit_from_json(fields)
    out = evaluate(table, frame)
    children = {fap for link in table.links for fap in table.sets[link.child]}
    for i, (before, after) in enumerate(zip(frame.state, out.state, strict=True)):
        if before != after:
            assert (before in "IU", after, i + 1 in children) == (True, "F", True)
        else:
            assert out.faps[i] == frame.faps[i]
    # What FIT gave counts as available: a second run finds nothing to do.
    assert evaluate(table, out) == out
    assert json.loads(faces_line(out))["faps"] == list(out.faps)


@given(fit_fields())
def test_fit_tables_go_out_and_in(fields: dict[str, list[float]]) -> None:
    table = fit_from_json(fields)
    assert fit_from_json(fit_to_fields(table)) == table
    assert parse_fit_text(fit_text(table)) == table
    assert fit_to_fields(table)["FAPs"] == fields["FAPs"]


@given(fit_fields())
def test_order_holds_every_child_once_and_keeps_every_dependency_that_is_no_cycle(
    fields: dict[str, list[float]],
) -> None:
    table = fit_from_json(fields)
    children = {link.child for link in table.links}
    assert sorted(table.order) == sorted(children)
    waits = {
        child: {
            other
            for link in table.incoming[child]
            for other in children
            if set(table.sets[other]) & set(table.sets[link.parent])
        }
        for child in children
    }
    done: set[int] = set()
    for child in table.order:
        ready = sorted(c for c in children - done if waits[c] <= done)
        assert child == (ready[0] if ready else min(children - done))
        done.add(child)
        if not ready:
            break
    rest = [child for child in table.order if child not in done]
    assert rest == sorted(rest)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_rounding_is_exact(value: float) -> None:
    exact_half = Fraction(1, 2)
    away = int(abs(Fraction(value)) + exact_half)
    assert round_half_away(value) == (away if value >= 0 else -away)


@given(face_frames())
def test_symmetry_changes_only_what_is_unavailable(frame: FrameLine) -> None:
    out = apply_symmetry(frame)
    for before, after in zip(
        zip(frame.state, frame.faps, strict=True), zip(out.state, out.faps, strict=True), strict=True
    ):
        assert before == after or (before[0] in "IU" and after[0] == "S" and after[1] is not None)
    assert apply_symmetry(out) == out


class Frame:
    """A frame of one low-level FAP."""

    viseme = None
    expression = None

    def __init__(self, fap: int, value: int) -> None:
        self.faps = tuple(value if i == fap - 1 else None for i in range(68))


BORDERS = st.lists(st.integers(-1000, 1000), min_size=1, max_size=5, unique=True)
COORDINATE = st.floats(-1000, 1000, width=32)
UNITS = Fapu(0.06, 0.05, 0.03, 0.05, 0.01)


@settings(max_examples=60)
@given(BORDERS, st.integers(3, 68), st.data())
def test_generation_reproduces_its_input(values: list[int], fap: int, data: st.DataObject) -> None:
    values = [value for value in values if value]
    if not values:
        return
    point = st.lists(COORDINATE, min_size=3, max_size=3)
    cloud = st.lists(point, min_size=2, max_size=2)
    neutral = fat.FatMesh("M", np.array(data.draw(cloud)), np.zeros((0, 3), dtype=np.int64))
    posed = {value: {"M": np.array(data.draw(cloud))} for value in values}
    table = generate_table(fap, {"M": neutral}, posed, UNITS)
    document = fat.FatDocument(UNITS, {"M": neutral}, (table,))
    fat.check_fat(document)
    assert fat.evaluate(document, Frame(fap, 0))["M"].tolist() == neutral.vertices.tolist()
    for value, meshes in posed.items():
        got = fat.evaluate(document, Frame(fap, value))["M"]
        # Each interval adds a difference of coordinates of at most 2000.
        assert np.abs(got - meshes["M"]).max() <= 2.0**-24 * 2000


@given(BORDERS, st.integers(-3000, 3000), st.integers(-3000, 3000))
def test_motion_is_continuous_and_neutral_at_zero(borders: list[int], a: int, b: int) -> None:
    line = sorted({*borders, 0})
    if len(line) < 3:
        return
    intervals = len(line) - 1

    def length(value: int) -> dict[int, float]:
        return dict(fat.interval_weights(line, value))

    assert length(0) == {}
    low, high = sorted((a, b))
    # Interval lengths are what lies between 0 and the value: monotone, and they add up to it.
    for value in (low, high):
        side = [j for j in range(intervals) if (line[j] >= 0) == (value > 0)]
        if side:
            assert sum(length(value).values()) == abs(value)
            assert set(length(value)) <= set(side)
    if low >= 0:
        assert all(length(low).get(j, 0.0) <= length(high).get(j, 0.0) for j in range(intervals))
    if high <= 0:
        assert all(length(high).get(j, 0.0) <= length(low).get(j, 0.0) for j in range(intervals))
