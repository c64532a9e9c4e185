"""Steps, IDCT, rounding, quantiser, runs and levels, the comparison model."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.fft import dct, idct

from snhc.reference_impl.bitstream.errors import EncodeError, InconsistentSemantics, RangeViolation
from snhc.reference_impl.face.dct_comparison import comparison_bound, comparison_bounds, first_mismatch
from snhc.reference_impl.face.dct_encode import (
    AC_ESCAPE,
    DC_ESCAPE,
    END_OF_SEGMENT,
    ac_symbol,
    coefficients_of,
    dc_symbol,
    escape_fields,
    forward_transform,
    quantise_segment,
    quantise_segments,
    run_levels,
)
from snhc.reference_impl.face.dct_transform import (
    DctReading,
    ac_step,
    basis,
    dc_step,
    inverse_transform,
    inverse_transforms,
    reconstruct_values,
    round_all_half_away,
    round_half_away,
)

READINGS = [
    DctReading(3, "orthonormal"),
    DctReading(3, "unnormalised"),
    DctReading(4, "orthonormal"),
    DctReading(4, "unnormalised"),
]
readings = st.sampled_from(READINGS)
steps = st.builds(ac_step, st.integers(3, 68), st.integers(0, 31))
levels = st.one_of(st.integers(-3, 3), st.integers(-256, 255), st.integers(-(1 << 31), (1 << 31) - 1))
segments = st.lists(levels, min_size=16, max_size=16)
curves = st.lists(
    st.one_of(st.integers(-20, 20), st.integers(-2000, 2000), st.integers(-(1 << 30), 1 << 30)),
    min_size=16,
    max_size=16,
)


def exact_cosine(m: int) -> Decimal:
    """cos(m pi / 32) to 40 digits, from half-angle square roots: independent of the literals."""
    with localcontext() as context:
        context.prec = 60
        # cos(pi/32) by halving pi/2 four times, then cos(m x) = 2 cos x cos((m-1) x) - cos((m-2) x).
        half = Decimal(0)
        for _ in range(4):
            half = ((1 + half) / 2).sqrt()
        before, now = Decimal(1), half
        for _ in range(m):
            before, now = now, 2 * half * now - before
        return before


def test_every_factor_is_the_nearest_float_of_the_exact_one() -> None:
    with localcontext() as context:
        context.prec = 60
        scale = (Decimal(1) / 8).sqrt()
        for k in range(1, 16):
            for t in range(16):
                cosine = exact_cosine((2 * t + 1) * k)
                assert basis()[k][t] == float(cosine * scale), (k, t)
                assert basis("unnormalised")[k][t] == float(cosine / 8), (k, t)
    assert set(basis()[0]) == {0.25}


def test_steps() -> None:
    # fap_quant 8: scale 12
    assert ac_step(3, 8) == 90
    assert dc_step(3, 8) == 30
    assert ac_step(49, 8) == 3060
    assert dc_step(49, 8, DctReading(dc_step_ratio=4)) == 765
    assert ac_step(3, 0) == Fraction(15, 2)
    assert ac_step(3, 1) == Fraction(15, 2)
    assert dc_step(18, 31) == Fraction(5 * 1039, 3)
    for fap, quant in ((2, 0), (69, 0), (3, 32), (3, -1)):
        with pytest.raises(RangeViolation, match="DCT-5"):
            ac_step(fap, quant)
    with pytest.raises(RangeViolation, match="dc_step_ratio"):
        DctReading(dc_step_ratio=5)
    with pytest.raises(RangeViolation, match="normalisation"):
        DctReading(normalisation="other")  # type: ignore[arg-type]


def test_worked_example() -> None:
    step = ac_step(3, 8)
    assert reconstruct_values([6, -5, 0, 2] + [0] * 12, step) == (
        -52, -67, -89, -108, -112, -93, -50, 11, 79, 140, 183, 202, 198, 179, 157, 142,
    )  # fmt: skip
    assert reconstruct_values([4, 1] + [0] * 14, step) == (
        62, 60, 58, 55, 50, 45, 39, 33, 27, 21, 15, 10, 5, 2, 0, -2,
    )  # fmt: skip
    step = ac_step(49, 8)
    assert reconstruct_values([-3] + [0] * 14 + [1], step) == (
        -659, -1079, -255, -1451, 71, -1719, 270, -1842, 312, -1800, 189, -1601, -79, -1275, -451, -871,
    )  # fmt: skip
    assert reconstruct_values([-3] + [0] * 15, step) == (-765,) * 16


def test_other_readings_give_other_values() -> None:
    # FAP 3, fap_quant 8, DC 6: 6 * 90 / 3 / 4 = 45; 6 * 90 / 4 / 4 = 33.75; 6 * 90 / 3 / 16 = 11.25
    dc_only = [6] + [0] * 15
    assert reconstruct_values(dc_only, ac_step(3, 8)) == (45,) * 16
    assert reconstruct_values(dc_only, ac_step(3, 8), DctReading(dc_step_ratio=4)) == (34,) * 16
    assert reconstruct_values(dc_only, ac_step(3, 8), DctReading(normalisation="unnormalised")) == (11,) * 16


def test_halves_go_away_from_zero() -> None:
    assert [round_half_away(v) for v in (0.5, -0.5, 1.5, -2.5, 0.49999999999999994, -0.0)] == [
        1,
        -1,
        2,
        -3,
        0,
        0,
    ]
    # FAP 18, step 5: DC 6 * 5 / 12 = 2.5 is a tie; with coefficient 8 = 4: 2.5 +- 5 = 7.5 or -2.5.
    step = ac_step(18, 1)
    assert reconstruct_values([6] + [0] * 15, step) == (3,) * 16
    assert reconstruct_values([-6] + [0] * 15, step) == (-3,) * 16
    assert set(reconstruct_values([6, 0, 0, 0, 0, 0, 0, 0, 4] + [0] * 7, step)) == {8, -3}


@given(st.lists(st.floats(-(2.0**62), 2.0**62), min_size=1, max_size=20))
def test_rounding_alike_in_arrays_and_exact(values: list[float]) -> None:
    expected = []
    for value in values:
        exact = Fraction(value)
        magnitude = (2 * abs(exact) + 1) // 2
        expected.append(int(-magnitude if exact < 0 else magnitude))
    assert [round_half_away(v) for v in values] == expected
    assert round_all_half_away(np.array(values)).tolist() == expected


@given(st.lists(st.tuples(segments, steps), min_size=1, max_size=6), readings)
def test_scalar_and_vectorised_inverse_are_the_same_bits(
    rows: list[tuple[list[int], Fraction]], reading: DctReading
) -> None:
    array = np.array([row for row, _ in rows], dtype=np.int64)
    together = inverse_transforms(array, [step for _, step in rows], reading)
    for i, (row, step) in enumerate(rows):
        alone = np.array(inverse_transform(row, step, reading))
        assert together[i].tobytes() == alone.tobytes()
        assert round_all_half_away(together[i]).tolist() == list(reconstruct_values(row, step, reading))


@given(segments, steps)
def test_inverse_agrees_with_scipy_within_the_double_precision_bound(row: list[int], step: Fraction) -> None:
    dequantised = [float(v * step) for v in row]
    dequantised[0] = float(row[0] * step / 3)
    theirs = idct(np.array(dequantised), norm="ortho")
    for got, their, bound in zip(
        inverse_transform(row, step),
        theirs,
        comparison_bounds(row, step, unit_roundoff=2.0**-53),
        strict=True,
    ):
        assert abs(got - their) <= bound


@given(curves)
def test_forward_agrees_with_scipy(values: list[int]) -> None:
    theirs = dct(np.array(values, dtype=np.float64), norm="ortho")
    largest = sum(map(abs, values))
    for got, their in zip(forward_transform(values), theirs, strict=True):
        assert abs(got - their) <= 32 * 2.0**-53 * largest
    plain = dct(np.array(values, dtype=np.float64)) / 2
    for got, their in zip(forward_transform(values, READINGS[1]), plain, strict=True):
        assert abs(got - their) <= 64 * 2.0**-53 * largest


@given(st.lists(st.tuples(curves, steps), min_size=1, max_size=6), readings)
def test_scalar_and_vectorised_quantisers_agree(rows: list[tuple[list[int], Fraction]], reading: DctReading) -> None:
    array = np.array([row for row, _ in rows], dtype=np.int64)
    together = quantise_segments(array, [step for _, step in rows], reading)
    assert together.tolist() == [list(quantise_segment(row, step, reading)) for row, step in rows]


@given(curves, steps, readings)
def test_decoding_what_was_encoded_stays_within_half_a_step_per_coefficient(
    values: list[int], step: Fraction, reading: DctReading
) -> None:
    coefficients = quantise_segment(values, step, reading)
    decoded = reconstruct_values(coefficients, step, reading)
    table = basis(reading.normalisation)
    for t in range(16):
        # Every coefficient is off by half its step at most: sum of c_k |cos| step / 2, and 0.5 for rounding.
        bound = float(step) / 2 * (sum(abs(table[k][t]) for k in range(1, 16)) + table[0][t] / reading.dc_step_ratio)
        assert abs(decoded[t] - values[t]) <= bound + 0.5 + 64 * 2.0**-53 * sum(map(abs, values))


def test_quantiser_is_mid_tread_with_halves_away_from_zero() -> None:
    # Constant v: DC = 4 v. FAP 18, scale 1: DC step 5/3; v = 5: 20 / (5/3) = 12.
    assert quantise_segment([5] * 16, ac_step(18, 1)) == (12,) + (0,) * 15
    # Step 30 (FAP 61, scale 2): DC step 10; sum 20 -> DC 5 = half a step.
    assert quantise_segment([20] + [0] * 15, ac_step(61, 2))[0] == 1
    assert quantise_segment([-20] + [0] * 15, ac_step(61, 2))[0] == -1
    assert quantise_segment([19] + [0] * 15, ac_step(61, 2))[0] == 0
    rows = np.array([[sign * dc] + [0] * 15 for sign in (1, -1) for dc in (19, 20)], dtype=np.int64)
    assert quantise_segments(rows, [ac_step(61, 2)] * 4)[:, 0].tolist() == [0, 1, 0, -1]


@pytest.mark.parametrize("end_after_last", [False, True])
@given(row=segments)
def test_runs_and_levels_are_undone(end_after_last: bool, row: list[int]) -> None:
    pairs = run_levels(row, end_after_last=end_after_last)
    assert coefficients_of(pairs, row[0], end_after_last=end_after_last) == row
    ends = [i for i, pair in enumerate(pairs) if pair == (END_OF_SEGMENT, 0)]
    assert ends == ([len(pairs) - 1] if end_after_last or row[15] == 0 else [])
    assert all(level for run, level in pairs if run != END_OF_SEGMENT)


def test_run_level_pairs_of_the_worked_example() -> None:
    assert run_levels([6, -5, 0, 2] + [0] * 12) == [(0, -5), (1, 2), (15, 0)]
    last = [-3] + [0] * 14 + [1]
    assert run_levels(last) == [(14, 1)]
    assert run_levels(last, end_after_last=True) == [(14, 1), (15, 0)]
    assert coefficients_of([(2, 0), (15, 0)], 7) == [7] + [0] * 15


@pytest.mark.parametrize(
    ("pairs", "error"),
    [
        ([(14, 1), (0, 1)], InconsistentSemantics),
        ([(14, 1), (15, 0)], InconsistentSemantics),
        ([(15, 0), (0, 1)], InconsistentSemantics),
        ([(3, 1)], InconsistentSemantics),
        ([], InconsistentSemantics),
        ([(0, 1), (14, 1)], RangeViolation),
        ([(-1, 1)], RangeViolation),
        ([(16, 1)], RangeViolation),
    ],
)
def test_pairs_that_do_not_make_a_segment(pairs: list[tuple[int, int]], error: type[Exception]) -> None:
    with pytest.raises(error, match="DCT-4"):
        coefficients_of(pairs)


def test_symbols_and_escapes() -> None:
    assert [ac_symbol(v) for v in (-257, -256, -1, 0, 1, 255, 256)] == [256, 0, 255, AC_ESCAPE, 257, 511, 256]
    assert [dc_symbol(v) for v in (-256, -255, 0, 255, 256)] == [DC_ESCAPE, 1, 256, 511, 0]
    assert escape_fields(-32767, 31) == [(-32767, 16)]
    assert escape_fields(-32768, 31) == [(-32768, 16), (-32768, 31)]
    assert escape_fields(32767, 31) == [(32767, 16)]
    assert escape_fields(32768, 32) == [(-32768, 16), (32768, 32)]
    assert escape_fields((1 << 30) - 1, 31)[1] == ((1 << 30) - 1, 31)
    with pytest.raises(EncodeError):
        escape_fields(1 << 30, 31)
    assert escape_fields(-(1 << 31), 32)[1] == (-(1 << 31), 32)


def test_wrong_sizes_and_huge_values_are_located_errors() -> None:
    step = ac_step(3, 8)
    with pytest.raises(RangeViolation, match="16 integers"):
        inverse_transform([1] * 15, step)
    with pytest.raises(RangeViolation, match="float64"):
        inverse_transform([10**400] * 16, step)
    with pytest.raises(RangeViolation, match=r"\(1, 16\)"):
        inverse_transforms(np.zeros((2, 16), dtype=np.int64), [step])
    with pytest.raises(RangeViolation, match=r"2\*\*53"):
        inverse_transforms(np.full((1, 16), 1 << 50, dtype=np.int64), [step])
    assert inverse_transforms(np.zeros((0, 16), dtype=np.int64), []).shape == (0, 16)
    with pytest.raises(EncodeError, match="16 integers"):
        forward_transform([1] * 17)
    with pytest.raises(EncodeError, match=r"2\*\*53"):
        forward_transform([1 << 60] + [0] * 15)
    with pytest.raises(EncodeError, match=r"\(1, 16\)"):
        quantise_segments(np.zeros((2, 16), dtype=np.int64), [step])
    with pytest.raises(EncodeError, match=r"2\*\*40"):
        quantise_segments(np.full((1, 16), 1 << 41, dtype=np.int64), [step])
    with pytest.raises(RangeViolation, match="unit_roundoff"):
        comparison_bound([0] * 16, step, unit_roundoff=0.5)
    with pytest.raises(RangeViolation, match="16 integers"):
        comparison_bound([0] * 15, step)
    with pytest.raises(RangeViolation, match="float64"):
        comparison_bound([10**400] * 16, step)


@given(segments, steps, readings)
def test_a_single_precision_decoder_stays_within_the_bound(row: list[int], step: Fraction, reading: DctReading) -> None:
    single = np.float32
    table = basis(reading.normalisation)
    got = []
    for t in range(16):
        total = single(0)
        for k in reversed(range(16)):
            size = single(float(step)) / single(reading.dc_step_ratio) if k == 0 else single(float(step))
            total = single(total + single(single(row[k]) * size) * single(table[k][t]))
        got.append(round_half_away(float(total)))
    unrounded = inverse_transform(row, step, reading)
    bounds = comparison_bounds(row, step, reading)
    assert all(abs(g - u) <= b for g, u, b in zip(got, unrounded, bounds, strict=True))


def test_the_comparison_allows_one_and_finds_truncation() -> None:
    row, step = [6, -5, 0, 2] + [0] * 12, ac_step(3, 8)
    reference = list(reconstruct_values(row, step))
    unrounded = inverse_transform(row, step)
    bound = comparison_bound(row, step)
    assert 0.5 < bound < 0.501
    assert first_mismatch(reference, reference, bound, unrounded) is None
    near = [v + (1 if i == 4 else 0) for i, v in enumerate(reference)]
    assert first_mismatch(reference, near, bound) is None
    sharp = first_mismatch(reference, near, bound, unrounded)
    assert sharp is not None
    assert (sharp.index, sharp.reference, sharp.candidate, sharp.limit) == (4, -112, -111, bound)
    far = [v + (2 if i == 4 else 0) for i, v in enumerate(reference)]
    found = first_mismatch(reference, far, 50.0)
    assert found is not None
    assert (found.index, found.distance, found.limit) == (4, 2.0, 1.0)
    truncated = [int(v) for v in unrounded]
    assert first_mismatch(reference, truncated, bound) is None
    assert first_mismatch(reference, truncated, bound, unrounded) is not None


def test_other_lengths_are_a_mismatch() -> None:
    found = first_mismatch([1, 2], [1], 0.5)
    assert found is not None
    assert (found.index, found.reference, found.candidate) == (1, 2, None)
    found = first_mismatch([1], [1, 2], 0.5)
    assert found is not None
    assert (found.index, found.reference, found.candidate) == (1, None, 2)
    with pytest.raises(RangeViolation, match="unrounded"):
        first_mismatch([1], [1], 0.5, [1.0, 2.0])
