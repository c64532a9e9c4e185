"""Frames as columns: every row is the frame's, whatever the rows before it were (CNF-1, CNF-25)."""

from __future__ import annotations

from array import array
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snhc.reference_impl.face.columns import FAPS, FaceColumns
from snhc.reference_impl.face.frames import FaceFrame

EDGES = (0, 1, -1, 2**31, -(2**31) - 1, 2**63 - 1, -(2**63))


def frame(faps: tuple[int | None, ...]) -> FaceFrame:
    return FaceFrame(0, (0, 1), False, faps, None, None, "U" * FAPS)


def rows(rng: Random, count: int) -> list[tuple[int | None, ...]]:
    """Rows whose unset values stay for a while, then change by one or altogether."""
    unset = set(rng.sample(range(FAPS), 30))
    out: list[tuple[int | None, ...]] = []
    for _ in range(count):
        change = rng.random()
        if change < 0.2:
            unset ^= {rng.randrange(FAPS)}
        elif change < 0.25:
            unset = set(rng.sample(range(FAPS), rng.randint(0, FAPS)))
        out.append(tuple(None if i in unset else rng.choice(EDGES) for i in range(FAPS)))
    return out


@given(st.integers(0, 2**32 - 1))
def test_values_and_set_flags(seed: int) -> None:
    wanted = rows(Random(seed), 20)
    columns = FaceColumns()
    for faps in wanted:
        columns.add(frame(faps))
    values = array("q", bytes(columns.faps))
    assert values.tolist() == [0 if value is None else value for faps in wanted for value in faps]
    assert list(columns.faps_set) == [value is not None for faps in wanted for value in faps]


@pytest.mark.parametrize("value", [2**63, -(2**63) - 1])
@pytest.mark.parametrize("others", [None, 0])
def test_what_64_bits_do_not_hold_is_refused_whole(value: int, others: int | None) -> None:
    columns = FaceColumns()
    before: tuple[int | None, ...] = (0,) * FAPS
    columns.add(frame(before))
    with pytest.raises(OverflowError):
        columns.add(frame((others,) * 40 + (value,) + (others,) * (FAPS - 41)))
    columns.add(frame(before))
    assert columns.rows == 2
    assert len(columns.faps) == 2 * 8 * FAPS
    assert bytes(columns.faps_set) == bytes([1]) * 2 * FAPS
