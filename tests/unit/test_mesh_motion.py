"""Motion arithmetic: named values of MSH-12..17 and MSH-24."""

from __future__ import annotations

import pytest

from snhc.reference_impl.bitstream.errors import EncodeError, ForbiddenValue, RangeViolation
from snhc.reference_impl.mesh import motion
from snhc.reference_impl.mesh.topology import MeshTopology


@pytest.mark.parametrize(
    ("vlc", "res", "range_code", "d"),
    [
        (-32, 0, 1, -32),
        (5, 0, 1, 5),
        (0, 0, 7, 0),
        (1, 0, 2, 1),
        (-4, 0, 2, -7),  # the worked example: |vlc| - 1 = 3, times 2, plus 0, plus 1
        (-21, 0, 2, -41),
        (32, 63, 7, 2048),
        (-32, 63, 7, -2048),
        (-1, 5, 4, -6),
    ],
)
def test_differential(vlc: int, res: int, range_code: int, d: int) -> None:
    assert motion.differential(vlc, res, range_code) == d
    assert motion.differential_code(d, range_code) == (vlc, res)


def test_wrap_both_ways() -> None:
    # range 1: R = 32
    assert [motion.wrap(v, 1) for v in (-64, -33, -32, 31, 32, 63)] == [0, 31, -32, 31, -32, -1]
    assert motion.decode_component(30, 4, 0, 1) == -30
    assert motion.vector_code((-30, 0), (30, 0), 1).x_vlc == 4


def test_writer_keeps_to_the_half_open_range() -> None:
    """d = R is not used where -R says the same."""
    code = motion.vector_code((31, 1), (-1, 0), 1)  # 32 = -32 modulo 64
    assert (code.x_vlc, code.y_vlc) == (-32, 1)


def test_zero_flag_means_the_zero_vector() -> None:
    assert motion.vector_code((0, 0), (7, 7), 1).zero == 1
    assert motion.decode_vector(motion.VectorCode(1), (7, 7), 1) == (0, 0)
    # Flag 0 with a vector of (0, 0) is legal.
    assert motion.decode_vector(motion.VectorCode(0, -7, 0, -7, 0), (7, 7), 1) == (0, 0)


def test_prediction() -> None:
    topology = MeshTopology([(0, 1, 2)], [1, 2, 0], [(-1, -1), (1, 1), (1, 2)])
    vx, vy = [0, 5, -2], [0, -4, -3]
    assert motion.predict(topology, 0, vx, vy) == (0, 0)
    assert motion.predict(topology, 1, vx, vy) == (5, -4)
    assert motion.predict(topology, 2, vx, vy) == (2, -3)  # (3 + 1) >> 1, (-7 + 1) >> 1


def test_residual_bits() -> None:
    assert motion.has_residual(3, 2)
    assert not motion.has_residual(3, 1)
    assert not motion.has_residual(0, 7)


def test_smallest_range_code() -> None:
    assert motion.smallest_range_code([], []) == 1
    assert motion.smallest_range_code([31], [-32]) == 1
    assert motion.smallest_range_code([32], [0]) == 2
    assert motion.smallest_range_code([0], [-33]) == 2
    assert motion.smallest_range_code([-2048], [2047]) == 7
    with pytest.raises(EncodeError, match="MSH-13"):
        motion.smallest_range_code([2048], [0])


def test_what_no_code_can_say() -> None:
    with pytest.raises(ForbiddenValue, match="MSH-40"):
        motion.motion_range(0)
    with pytest.raises(ForbiddenValue, match="MSH-40"):
        motion.motion_range(8)
    assert [motion.motion_range(r) for r in range(1, 8)] == [32, 64, 128, 256, 512, 1024, 2048]
    with pytest.raises(EncodeError, match="MSH-12"):
        motion.differential_code(33, 1)
    with pytest.raises(EncodeError, match="MSH-13"):
        motion.vector_code((32, 0), (0, 0), 1)
    with pytest.raises(EncodeError, match="MSH-13"):
        motion.vector_code((0, -33), (0, 0), 1)


def test_positions_stay_within_32_bits() -> None:
    high, low = (1 << 31) - 1, -(1 << 31)
    assert motion.move([high - 1], [low + 1], [1], [-1]) == ([high], [low])
    for xs, ys, vx, vy in (
        ([high], [0], [1], [0]),
        ([low], [0], [-1], [0]),
        ([0], [high], [0], [1]),
        ([0], [low], [0], [-1]),
    ):
        assert motion.first_out_of_range(xs, ys, vx, vy, [0]) == 0
        with pytest.raises(RangeViolation, match="MSH-24"):
            motion.move(xs, ys, vx, vy)
    # In the order of the stream, not by node number.
    assert motion.first_out_of_range([high, 0, high], [0, 0, 0], [1, 1, 1], [0, 0, 0], [1, 2, 0]) == 1
    assert motion.first_out_of_range([0], [0], [1], [1], [0]) == -1


def test_foldover() -> None:
    triangles = [(0, 1, 2), (0, 2, 3)]
    xs, ys = [0, 4, 4, 0], [0, 0, 4, 4]
    assert motion.foldovers(xs, ys, triangles) == []
    # Node 1 moves across the diagonal: its triangle flips.
    assert motion.foldovers([0, 1, 4, 0], [0, 3, 4, 4], triangles) == [0]
    assert motion.foldovers([0, 1, 4, 6], [0, 3, 4, 0], triangles) == [0, 1]
    # On the diagonal: shrunk to a line, not flipped.
    assert motion.foldovers([0, 2, 4, 0], [0, 2, 4, 4], triangles) == []
