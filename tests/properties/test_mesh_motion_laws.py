"""Laws of mesh motion: every range code over its full range (MSH-12..16)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snhc.reference_impl.mesh import motion


@pytest.mark.parametrize("range_code", range(1, 8))
def test_codes_and_differentials_are_one_to_one(range_code: int) -> None:
    limit = motion.motion_range(range_code)
    residuals = range(1 << (range_code - 1))
    seen = {}
    for vlc in range(-32, 33):
        for res in residuals if motion.has_residual(vlc, range_code) else (0,):
            seen[motion.differential(vlc, res, range_code)] = (vlc, res)
    assert sorted(seen) == list(range(-limit, limit + 1))
    assert all(motion.differential_code(d, range_code) == code for d, code in seen.items())


@pytest.mark.parametrize("range_code", range(1, 8))
def test_every_vector_from_every_extreme_prediction(range_code: int) -> None:
    """decode(code(v)) = v, with d in -R..R - 1."""
    limit = motion.motion_range(range_code)
    for prediction in (-limit, -1, 0, 1, limit // 3, limit - 1):
        for v in range(-limit, limit):
            code = motion.vector_code((v, 1), (prediction, 0), range_code)
            d = motion.differential(code.x_vlc, code.x_res, range_code)
            assert -limit <= d <= limit - 1
            assert motion.decode_component(prediction, code.x_vlc, code.x_res, range_code) == v


@given(st.integers(1, 7), st.data())
def test_vectors_round_trip(range_code: int, data: st.DataObject) -> None:
    limit = motion.motion_range(range_code)
    component = st.integers(-limit, limit - 1)
    pair = st.tuples(component, component)
    v, prediction = data.draw(pair), data.draw(pair)
    code = motion.vector_code(v, prediction, range_code)
    assert code.zero == (v == (0, 0))
    assert motion.decode_vector(code, prediction, range_code) == v


@given(st.integers(1, 7), st.data())
def test_wrap_stays_in_range_and_keeps_the_remainder(range_code: int, data: st.DataObject) -> None:
    limit = motion.motion_range(range_code)
    total = data.draw(st.integers(-2 * limit, 2 * limit - 1))
    v = motion.wrap(total, range_code)
    assert -limit <= v < limit
    assert (v - total) % (2 * limit) == 0


@given(st.lists(st.tuples(*[st.integers(-(1 << 31), (1 << 31) - 1)] * 2, *[st.integers(-2048, 2047)] * 2)))
def test_moving_there_and_back(nodes: list[tuple[int, int, int, int]]) -> None:
    xs, ys, vx, vy = ([node[k] for node in nodes] for k in range(4))
    if motion.first_out_of_range(xs, ys, vx, vy, list(range(len(xs)))) < 0:
        there = motion.move(xs, ys, vx, vy)
        assert motion.move(*there, [-v for v in vx], [-v for v in vy]) == (xs, ys)
