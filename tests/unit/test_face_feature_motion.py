"""Feature point motion from FAPs; visemes and expressions as poses; unidirectional FAPs."""

from __future__ import annotations

from math import cos, pi, sin

import pytest

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.model.face_definition import FaceDefinition, Vec3, feature_points
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.feature_motion import (
    eye_center,
    feature_motion,
    head_rotation,
    high_level_faps,
    unidirectional_findings,
)
from snhc.reference_impl.tables import fap_table

UNITS = Fapu(es=0.5, ens=0.25, mns=0.125, mw=2.0, irisd=0.0625)
POINTS: dict[str, Vec3] = {row.point: (float(i), float(-i), 2.0 * i) for i, row in enumerate(feature_points(), 1)}
FACE = FaceDefinition(POINTS, eye_centers={"left": (20.0, -19.0, 30.0), "right": (21.0, -20.0, 31.0)})
HALF = pi / 2 * 1e5


def faps(values: dict[int, float]) -> list[float | None]:
    return [values.get(i + 1) for i in range(68)]


def moves(values: dict[int, float]) -> dict[str, tuple[float, ...]]:
    """What moved and by how much."""
    after = feature_motion(FACE, faps(values), fapu=UNITS).points
    out = {}
    for name, point in after.items():
        step = tuple(round(a - b, 9) for a, b in zip(point, POINTS[name], strict=True))
        if any(step):
            out[name] = step
    return out


LINEAR: list[tuple[int, str, Vec3]] = [
    (3, "2.1", (0, -1.25, 0)), (4, "2.2", (0, -1.25, 0)), (5, "2.3", (0, 1.25, 0)), (6, "2.4", (20, 0, 0)),
    (7, "2.5", (-20, 0, 0)), (12, "2.4", (0, 1.25, 0)), (14, "2.1", (0, 0, 1.25)), (15, "2.1", (-20, 0, 0)),
    (16, "2.3", (0, 0, 1.25)), (18, "2.10", (0, 1.25, 0)), (19, "3.1", (0, -0.625, 0)), (21, "3.3", (0, 0.625, 0)),
    (31, "4.1", (0, 2.5, 0)), (37, "4.1", (-5, 0, 0)), (38, "4.2", (5, 0, 0)), (39, "5.1", (5, 0, 0)),
    (41, "5.3", (0, 2.5, 0)), (43, "6.1", (-20, 0, 0)), (45, "6.1", (0, 0, 20)), (46, "6.2", (0, 1.25, 0)),
    (53, "8.3", (20, 0, 0)), (61, "9.1", (2.5, 0, 0)), (64, "9.3", (-2.5, 0, 0)), (67, "10.3", (2.5, 0, 0)),
]  # fmt: skip


@pytest.mark.parametrize(("fap", "point", "step"), LINEAR)
def test_linear_faps(fap: int, point: str, step: Vec3) -> None:
    assert moves({fap: 10}) == {point: step}


def test_every_fap_but_the_pupils_and_the_whole_head_moves_its_points_only() -> None:
    for record in fap_table()[2:]:
        moved = set(moves({record.number: 10000}))
        if record.number in (48, 49, 50):
            assert moved == set(POINTS) - {"7.1"}
        elif record.number in (23, 25, 27):
            assert moved == {"3.5"}
        elif record.number in (24, 26, 28):
            assert moved == {"3.6"}
        elif record.number in (29, 30):
            assert moved == set()
        else:
            assert moved == {f"{record.fdp_group}.{number}" for number in record.fdp_point}


def test_faps_of_one_point_add() -> None:
    assert moves({3: 10, 14: 10, 15: 10}) == {"2.1": (-20, -1.25, 1.25)}


def test_pupils_grow() -> None:
    growth = feature_motion(FACE, faps({29: 16, 30: -16}), fapu=UNITS).pupil_growth
    assert growth == {"left": 1.0, "right": -1.0}


def test_tongue_borders_roll_upward() -> None:
    center = POINTS["6.2"]
    face = FaceDefinition({**POINTS, "6.3": (center[0] + 4, center[1], 0), "6.4": (center[0] - 4, center[1], 0)})
    after = feature_motion(face, faps({47: 10000}), fapu=UNITS).points
    assert after["6.3"][:2] == pytest.approx((center[0] + 4 * cos(0.1), center[1] + 4 * sin(0.1)))
    assert after["6.4"][:2] == pytest.approx((center[0] - 4 * cos(0.1), center[1] + 4 * sin(0.1)))


EYES = FaceDefinition({**POINTS, "3.5": (20.0, -19.0, 40.0), "3.6": (21.0, -20.0, 41.0)}, eye_centers=FACE.eye_centers)


@pytest.mark.parametrize(
    ("fap", "point", "wanted"),
    [
        (23, "3.5", (30.0, -19.0, 30.0)),  # yaw left: +x
        (24, "3.6", (31.0, -20.0, 31.0)),
        (25, "3.5", (20.0, -29.0, 30.0)),  # pitch down: -y
        (26, "3.6", (21.0, -30.0, 31.0)),
    ],
)
def test_eyeballs_turn_about_their_centres(fap: int, point: str, wanted: Vec3) -> None:
    assert feature_motion(EYES, faps({fap: HALF}), fapu=UNITS).points[point] == pytest.approx(wanted)


def test_eyeball_is_thrust_with_its_centre() -> None:
    motion = feature_motion(EYES, faps({27: 10, 23: HALF}), fapu=UNITS)
    assert motion.eye_centers["left"] == (20.0, -19.0, 35.0)
    assert motion.points["3.5"] == pytest.approx((30.0, -19.0, 35.0))


def test_eye_centre_by_default_is_one_iris_behind_the_pupil() -> None:
    assert eye_center(FaceDefinition({"3.5": (1, 2, 100)}), "left", UNITS) == (1, 2, 36)
    assert eye_center(FaceDefinition({}), "left", UNITS) is None


HEAD = FaceDefinition({"7.1": (1.0, 1.0, 1.0), "9.3": (1.0, 1.0, 3.0), "11.4": (1.0, 3.0, 1.0)})


@pytest.mark.parametrize(
    ("fap", "nose", "top"),
    [
        (48, (1, -1, 1), (1, 1, 3)),  # pitch down: the nose goes down, the top forward
        (49, (3, 1, 1), (1, 3, 1)),  # yaw left: the nose to +x
        (50, (1, 1, 3), (-1, 1, 1)),  # roll right: the top to -x
    ],
)
def test_head_turns_about_7_1(fap: int, nose: Vec3, top: Vec3) -> None:
    motion = feature_motion(HEAD, faps({fap: HALF}), fapu=UNITS)
    assert motion.points["9.3"] == pytest.approx(nose)
    assert motion.points["11.4"] == pytest.approx(top)
    assert motion.points["7.1"] == (1, 1, 1)


def test_head_order() -> None:
    values = faps({48: HALF, 49: HALF})
    # Intrinsic yaw, then pitch: the nose pitches down first, then yaw about y leaves it there.
    assert feature_motion(HEAD, values, fapu=UNITS).points["9.3"] == pytest.approx((1, -1, 1))
    other = feature_motion(HEAD, values, fapu=UNITS, order="pitch-yaw-roll").points["9.3"]
    assert other == pytest.approx((3, 1, 1))
    with pytest.raises(SnhcError) as caught:
        head_rotation(0, 0, 0, "roll")
    assert caught.value.error_class == "InputFormat"


def test_faults() -> None:
    with pytest.raises(SnhcError) as caught:
        feature_motion(FACE, [None] * 67, fapu=UNITS)
    assert caught.value.expected == 68
    with pytest.raises(SnhcError) as caught:
        feature_motion(FACE, faps({6: 1}), fapu=Fapu(mns=1.0))
    assert caught.value.path == "fapu.MW"
    with pytest.raises(SnhcError) as caught:
        feature_motion(FaceDefinition({"9.3": (0, 0, 0)}), faps({48: 1}), fapu=UNITS)
    assert caught.value.path == "points.7.1"
    # A unit that no value needs may be missing, and 0 moves nothing.
    assert feature_motion(FACE, faps({6: 0, 3: 1}), fapu=Fapu(mns=1.0)).points["2.4"] == POINTS["2.4"]


def test_visemes_and_expressions_mix() -> None:
    visemes = {1: {3: 100.0, 51: 50.0}, 10: {3: 700.0}}
    expressions = {1: {31: 63.0}, 6: {31: 126.0, 3: 63.0}}
    low: list[int | None] = [None] * 68
    low[50] = 7
    got = high_level_faps(low, (1, 10, 21), (1, 63, 6, 21), visemes, expressions)
    # 3: 100 / 3 + 700 * 2 / 3 + 63 / 3 = 521; 31: 63 + 42 = 105; FAP 51 is overridden.
    assert got[2] == pytest.approx(521.0)
    assert got[30] == pytest.approx(105.0)
    assert got[50] == 7.0
    assert [i + 1 for i, value in enumerate(got) if value is not None] == [3, 31, 51]
    assert high_level_faps(low, None, None, visemes, expressions)[50] == 7.0
    # Clamped; select 0 is neutral.
    assert high_level_faps(low, (0, 10, 99), (1, 99, 0, 63), visemes, expressions)[2] == 0.0
    assert high_level_faps(low, None, (1, 99, 0, 63), visemes, expressions)[30] == 63.0


def test_unidirectional_faps() -> None:
    values: list[int | None] = [-1] * 68
    values[0] = values[1] = None
    found = unidirectional_findings(values, 4)
    assert [f.path for f in found] == [f"frame[4].faps[{fap - 1}]" for fap in (3, 14, 41, 42, 47)]
    assert {(f.id, f.rule) for f in found} == {("negative-unidirectional", "FAC-7")}
    assert unidirectional_findings([None, None, *[0] * 66], 0) == []
