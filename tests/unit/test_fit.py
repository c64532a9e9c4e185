"""FIT evaluation: samples, the worked cases (a) to (g), order, undefined functions, readings, symmetry."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from snhc.reference_impl.interpolation.fit import (
    FitReadings,
    apply_symmetry,
    evaluate,
    fit_from_json,
    load_fit,
    round_half_away,
)
from snhc.reference_impl.interpolation.fit_bulk import evaluate_sequence
from snhc.reference_impl.interpolation.fit_table import FitTable
from snhc.reference_impl.interpolation.frames_json import FrameLine, faces_line, frame_from_json, read_frames

SAMPLES = sorted((Path(__file__).parents[1] / "fixtures" / "samples" / "fit").iterdir())


def frame(
    faps: dict[int, int] | None = None,
    *,
    viseme: tuple[int, int, int] | None = None,
    expression: tuple[int, int, int, int] | None = None,
    states: dict[int, str] | None = None,
) -> FrameLine:
    """A frame where the FAPs that are given are transmitted; `states` overrides letters."""
    values: list[int | None] = [None] * 68
    letters = ["U"] * 68
    for fap, value in (faps or {}).items():
        values[fap - 1] = value
        letters[fap - 1] = "T"
    high: dict[str, object] = {"viseme": None, "expression": None}
    if viseme is not None:
        letters[0] = "T"
        high["viseme"] = dict(zip(("select1", "select2", "blend"), viseme, strict=True))
    if expression is not None:
        letters[1] = "T"
        names = ("select1", "intensity1", "select2", "intensity2")
        high["expression"] = dict(zip(names, expression, strict=True))
    for fap, letter in (states or {}).items():
        letters[fap - 1] = letter
    line = {"index": 0, "time": "0/1", "intra": True, "faps": values, **high, "state": "".join(letters)}
    return frame_from_json(line)


Term = tuple[float, tuple[int, ...]]


def table(
    sets: list[list[int]],
    links: list[tuple[int, int, list[tuple[list[Term], list[Term]]]]],
    impulses: list[int] | None = None,
    readings: FitReadings | None = None,
) -> FitTable:
    """A table from sets and links: (parent, child, [(numerator terms, denominator terms) per child FAP])."""
    fields: dict[str, list[float]] = {
        "FAPs": [entry for faps in sets for entry in (*faps, -1)],
        "Graph": [number for parent, child, _ in links for number in (parent, child)],
        "numeratorImpulse": list(impulses or []),
    }
    for side in ("numerator", "denominator"):
        place = 0 if side == "numerator" else 1
        functions = [function[place] for _, _, functions in links for function in functions]
        fields[f"{side}Terms"] = [len(terms) for terms in functions]
        fields[f"{side}Exp"] = [power for terms in functions for _, powers in terms for power in powers]
        fields[f"{side}Coefs"] = [coef for terms in functions for coef, _ in terms]
    return fit_from_json(fields, impulse=(readings or FitReadings()).impulse)


def linear(*coefs: float) -> tuple[list[Term], list[Term]]:
    """c1 F1 + c2 F2 + ..."""
    size = len(coefs)
    return [(c, tuple(int(j == i) for j in range(size))) for i, c in enumerate(coefs)], []


def given(result: FrameLine) -> dict[int, int | None]:
    return {i + 1: result.faps[i] for i, letter in enumerate(result.state) if letter == "F"}


def run(fit: FitTable, source: FrameLine, readings: FitReadings | None = None) -> dict[int, int | None]:
    """The values that were given, by the literal and the vectorised form."""
    chosen = readings or FitReadings()
    result = evaluate(fit, source, chosen)
    assert list(evaluate_sequence(fit, [source], chosen)) == [result]
    return given(result)


@pytest.mark.parametrize("folder", SAMPLES, ids=lambda folder: folder.name)
def test_sample(folder: Path) -> None:
    fit = load_fit(folder / "table.json")
    with (folder / "input.ndjson").open("rb") as stream:
        frames = list(read_frames(stream))
    expected = [json.loads(line) for line in (folder / "expected.ndjson").read_text().splitlines()[1:]]
    assert [json.loads(faces_line(evaluate(fit, f))) for f in frames] == expected
    assert [json.loads(faces_line(f)) for f in evaluate_sequence(fit, frames)] == expected


def test_samples_are_all_there() -> None:
    assert len(SAMPLES) == 16


# Figure 12: expression -> top inner, bottom inner lip; inner lips -> outer lips; expression -> outer lips.
FIGURE_12 = table(
    [[2], [4, 8], [5, 10], [51, 55], [52, 57]],
    [
        (1, 3, [linear(1.0, 0.5), linear(0.0, 1.0)]),
        (2, 4, [linear(1.0, 0.0), linear(0.25, 1.0)]),
        # One impulse term each: expression_select1 (value 0) is joy (1): 2 * intensity1, and so on.
        (0, 1, [([(2.0, (0, 1, 0, 0))], []), ([(3.0, (0, 1, 0, 0))], [])]),
        (0, 2, [([(-2.0, (0, 1, 0, 0))], []), ([(-1.0, (0, 1, 0, 0))], [])]),
        (0, 3, [([(9.0, (0, 1, 0, 0))], []), ([(9.0, (0, 1, 0, 0))], [])]),
    ],
    impulses=[0, 1] * 6,
)


def test_case_a_expression_only_input_drives_the_lips_through_figure_12() -> None:
    # intensity1 40: 4 = 80, 8 = 120, 5 = -80, 10 = -40; 51 = 80 + 60 = 140 (first parent, not 9 * 40), 55 = 120;
    # 52 = -80, 57 = -20 - 40 = -60.
    source = frame(expression=(1, 40, 0, 0))
    assert run(FIGURE_12, source) == {4: 80, 8: 120, 5: -80, 10: -40, 51: 140, 55: 120, 52: -80, 57: -60}


def test_case_b_inner_lip_drives_outer_lip() -> None:
    # No expression: only what the inner lips give. 51 = 100 + 25 = 125, 55 = 50.
    assert run(FIGURE_12, frame({4: 100, 8: 50})) == {51: 125, 55: 50}


def test_case_c_eyebrow_from_its_counterpart() -> None:
    fit = table([[34], [31, 33, 35]], [(0, 1, [linear(0.5), linear(1.0), linear(0.75)])])
    # 0.75 * 102 = 76.5, a half: away from zero.
    assert run(fit, frame({34: 102})) == {31: 51, 33: 102, 35: 77}
    assert run(fit, frame({34: -102})) == {31: -51, 33: -102, 35: -77}


def test_case_d_an_asymmetric_rule_beats_symmetry() -> None:
    fit = table([[6], [7]], [(0, 1, [linear(-0.5)])])
    result = evaluate(fit, frame({6: 100}))
    assert given(result) == {7: -50}
    assert apply_symmetry(result) == result


def test_case_e_two_parents_where_the_first_is_incomplete() -> None:
    fit = table([[4, 5], [6], [10]], [(0, 2, [linear(1.0, 1.0)]), (1, 2, [linear(7.0)])])
    assert run(fit, frame({4: 1, 6: 3})) == {10: 21}
    assert run(fit, frame({4: 1, 5: 2, 6: 3})) == {10: 3}
    assert run(fit, frame({4: 1})) == {}


def test_case_f_cubic_over_quadratic() -> None:
    # (F^3 + 2) / (F^2 - 4): F = 3: 29 / 5 = 5.8 -> 6; F = -3: -25 / 5 = -5; F = 2: undefined.
    fit = table([[3], [4]], [(0, 1, [([(1.0, (3,)), (2.0, (0,))], [(1.0, (2,)), (-4.0, (0,))])])])
    assert run(fit, frame({3: 3})) == {4: 6}
    assert run(fit, frame({3: -3})) == {4: -5}
    assert run(fit, frame({3: 2})) == {}


def test_case_g_impulse_terms_select_one_expression() -> None:
    # joy (1): 2 * intensity1; anger (3): 5 * intensity1; both tests on value 0, expression_select1.
    function: tuple[list[Term], list[Term]] = ([(2.0, (0, 1, 0, 0)), (5.0, (0, 1, 0, 0))], [])
    fit = table([[2], [12]], [(0, 1, [function])], impulses=[0, 1, 0, 3])
    assert run(fit, frame(expression=(1, 10, 2, 60))) == {12: 20}
    assert run(fit, frame(expression=(3, 10, 2, 60))) == {12: 50}
    assert run(fit, frame(expression=(2, 10, 1, 60))) == {12: 0}


def test_parent_values_of_fap_1_and_2_stand_in_the_order_of_the_set() -> None:
    # Set (2, 3, 1): values 0..3 expression, 4 FAP 3, 5..7 viseme. blend (7) when viseme_select1 (5) is 9.
    powers = (0, 0, 0, 0, 1, 0, 0, 1)
    fit = table([[2, 3, 1], [20]], [(0, 1, [([(1.0, powers)], [])])], impulses=[5, 9])
    source = frame({3: 4}, viseme=(9, 2, 30), expression=(1, 2, 3, 4))
    assert run(fit, source) == {20: 120}
    assert run(fit, frame({3: 4}, viseme=(8, 2, 30), expression=(1, 2, 3, 4))) == {20: 0}


def test_impulse_readings_differ() -> None:
    def value(reading: str) -> dict[int, int | None]:
        readings = FitReadings(impulse=reading)
        # Parent (3, 2). Pair (1, 5): from 0 value 1 is expression_select1; from 1 it is FAP 3; within FAP 2 it is
        # expression_intensity1.
        terms: list[Term] = [(1.0, (0, 0, 0, 0, 0))]
        fit = table([[3, 2], [10]], [(0, 1, [(terms, [])])], impulses=[1, 5], readings=readings)
        return {i: run(fit, source)[10] or 0 for i, source in enumerate(sources)}

    sources = [
        frame({3: 9}, expression=(5, 8, 0, 0)),
        frame({3: 5}, expression=(6, 8, 0, 0)),
        frame({3: 9}, expression=(6, 5, 0, 0)),
    ]
    assert value("from-0") == {0: 1, 1: 0, 2: 0}
    assert value("from-1") == {0: 0, 1: 1, 2: 0}
    assert value("within-fap") == {0: 0, 1: 0, 2: 1}


def test_only_unavailable_faps_are_written_and_states_decide() -> None:
    fit = table([[3], [4, 5, 6]], [(0, 1, [linear(1.0), linear(2.0), linear(3.0)])])
    # 3 retained counts as available; 4 to be interpolated and 5 unset are written, 6 transmitted is not.
    source = frame({3: 7, 6: 1}, states={3: "R", 4: "I"})
    result = evaluate(fit, source)
    assert result.faps[3:6] == (7, 14, 1)
    assert result.state[2:6] == "RFFT"
    assert run(fit, frame({3: 7}, states={3: "I"})) == {}


def test_values_from_fit_make_links_usable_and_chains_work_against_the_set_numbers() -> None:
    fit = table([[5], [4], [3]], [(1, 0, [linear(2.0)]), (2, 1, [linear(2.0)])])
    assert fit.order == (1, 0)
    assert run(fit, frame({3: 1})) == {4: 2, 5: 4}


def test_order_takes_the_smallest_ready_set_first_and_cycles_last() -> None:
    one = [linear(1.0)]
    # 3 waits for 4; 1 and 2 are a cycle, 5 stands behind it, 0 is free.
    fit = table(
        [[10], [11], [12], [13], [14], [15], [3]],
        [(2, 1, one), (1, 2, one), (4, 3, one), (6, 4, one), (6, 0, one), (1, 5, one)],
    )
    assert fit.order == (0, 4, 3, 1, 2, 5)


def test_a_link_into_its_own_set_is_a_cycle() -> None:
    one = [linear(1.0)]
    fit = table([[3], [4], [5]], [(1, 1, one), (0, 1, one), (0, 2, one)])
    assert fit.order == (2, 1)


def test_cycle_is_solved_from_whichever_side_is_known() -> None:
    fit = table([[3], [4]], [(0, 1, [linear(2.0)]), (1, 0, [linear(0.5)])])
    assert run(fit, frame({3: 10})) == {4: 20}
    assert run(fit, frame({4: 10})) == {3: 5}
    assert run(fit, frame()) == {}


def test_shared_fap_comes_from_the_set_that_is_first_in_order() -> None:
    # FAP 10 stands in sets 1 and 2; set 1 waits for set 3, set 2 is ready: topological gives 2's value.
    fit = table([[3], [10], [10], [4]], [(3, 1, [linear(5.0)]), (0, 2, [linear(7.0)]), (0, 3, [linear(1.0)])])
    assert run(fit, frame({3: 1})) == {4: 1, 10: 7}
    # One pass in link order: set 1 comes first, but FAP 4 is not there yet.
    assert run(fit, frame({3: 1}), FitReadings(order="link-order")) == {4: 1, 10: 7}
    # With FAP 4 sent the two orders differ.
    assert run(fit, frame({3: 1, 4: 1})) == {10: 7}
    assert run(fit, frame({3: 1, 4: 1}), FitReadings(order="link-order")) == {10: 5}


def test_value_is_available_at_once_inside_its_set() -> None:
    # Parent (3, 20): 20 is also the first FAP of the child set and comes from FAP 3.
    fit = table([[3], [3, 20], [20, 21]], [(0, 2, [linear(4.0), ([], [])]), (1, 2, [linear(0, 0), linear(1.0, 1.0)])])
    assert run(fit, frame({3: 2})) == {20: 8, 21: 0}


def test_zero_denominator_tries_the_next_link() -> None:
    over: tuple[list[Term], list[Term]] = ([(1.0, (0,))], [(1.0, (1,))])
    fit = table([[3], [4], [10]], [(0, 2, [over]), (1, 2, [linear(3.0)])])
    assert run(fit, frame({3: 0, 4: 5})) == {10: 15}
    assert run(fit, frame({3: 2, 4: 5})) == {10: 1}  # 0.5, away from zero
    assert run(fit, frame({3: 0})) == {}
    zero = FitReadings(undefined="zero-truncated")
    assert run(fit, frame({3: 0, 4: 5}), zero) == {10: 0}
    assert run(fit, frame({3: 2, 4: 5}), zero) == {10: 0}


def test_result_that_is_not_finite_is_undefined() -> None:
    power: tuple[list[Term], list[Term]] = ([(1.0, (15,))], [])
    fit = table([[3], [10]], [(0, 1, [power])])
    assert run(fit, frame({3: 10**25})) == {}
    assert run(fit, frame({3: 10})) == {10: 10**15}


def test_no_terms_give_zero_and_zero_to_the_zero_is_one() -> None:
    fit = table([[3], [10, 11]], [(0, 1, [([], []), ([(5.0, (0,))], [])])])
    assert run(fit, frame({3: 0})) == {10: 0, 11: 5}


@pytest.mark.parametrize(
    ("value", "rounded"),
    [(0.5, 1), (-0.5, -1), (2.5, 3), (-2.5, -3), (0.49999999999999994, 0), (2.0**52 + 1, 2**52 + 1), (-7.0, -7)],
)
def test_rounding(value: float, rounded: int) -> None:
    assert round_half_away(value) == rounded


def test_values_are_not_clipped() -> None:
    fit = table([[3], [19]], [(0, 1, [linear(1e6)])])
    assert run(fit, frame({3: 1000})) == {19: 10**9}


def test_symmetry_copies_where_one_side_is_there() -> None:
    source = frame({6: 5, 13: -3, 8: 1, 9: 2}, states={12: "I"})
    result = apply_symmetry(source)
    assert result.faps[6] == 5
    assert result.faps[11] == -3
    assert result.faps[7:9] == (1, 2)
    assert [i + 1 for i, letter in enumerate(result.state) if letter == "S"] == [7, 12]


def test_pass_through_keeps_unknown_keys() -> None:
    source = frame_from_json({**frame({3: 1}).raw, "baps": [1, 2], "gender": 1})
    out = json.loads(faces_line(evaluate(table([[3], [4]], [(0, 1, [linear(2.0)])]), source)))
    assert (out["baps"], out["gender"], out["faps"][3], out["state"][3]) == ([1, 2], 1, 2, "F")
