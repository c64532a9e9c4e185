"""Feature points, units and their known mistakes, both file forms, the checks of table 6 and of the neutral
face.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.model.face_checks import check_locations, check_neutral, missing_points
from snhc.reference_impl.model.face_definition import (
    FaceDefinition,
    Vec3,
    face_definition_from_json,
    fdp_text,
    feature_points,
    load_face_definition,
    parse_face_definition_json,
    parse_fdp,
)
from snhc.reference_impl.model.fapu import AU, Fapu, fap_unit_names
from snhc.reference_impl.model.feature_motion import feature_motion
from snhc.reference_impl.rules.register import finding

# A neutral face that keeps every constraint: ES0 64, ENS0 50, MNS0 30, MW0 52, IRISD0 12. Left half; 7.1.x is 0.
LEFT: dict[str, Vec3] = {
    "2.4": (24, -80, 90), "2.6": (12, -80, 94), "2.8": (12, -80, 94), "2.11": (20, -110, 85), "2.13": (55, -90, 20),
    "3.1": (32, 6, 80), "3.3": (32, -6, 80), "3.5": (32, 0, 82), "3.7": (47, 0, 75), "3.9": (32, -9, 80),
    "3.11": (17, 0, 78), "3.13": (32, 10, 80), "4.1": (14, 22, 88), "4.3": (32, 27, 86), "4.5": (50, 22, 78),
    "5.1": (45, -80, 70), "5.3": (40, -35, 80), "6.3": (12, -84, 70), "8.3": (26, -80, 89), "8.5": (13, -75, 96),
    "8.7": (13, -86, 95), "8.10": (5, -74, 98), "9.1": (16, -46, 90), "9.5": (10, -50, 95), "9.7": (9, 0, 90),
    "9.13": (8, -20, 98), "10.1": (75, 20, -10), "10.3": (78, -10, -30), "10.5": (70, -40, -5), "10.7": (68, -38, 0),
    "10.9": (70, 18, -5), "11.3": (55, 60, 60),
}  # fmt: skip
RIGHT = {
    "2.4": "2.5", "2.6": "2.7", "2.8": "2.9", "2.11": "2.12", "2.13": "2.14", "3.1": "3.2", "3.3": "3.4", "3.5": "3.6",
    "3.7": "3.12", "3.9": "3.10", "3.11": "3.8", "3.13": "3.14", "4.1": "4.2", "4.3": "4.4", "4.5": "4.6", "5.1": "5.2",
    "5.3": "5.4", "6.3": "6.4", "8.3": "8.4", "8.5": "8.6", "8.7": "8.8", "8.10": "8.9", "9.1": "9.2", "9.5": "9.4",
    "9.7": "9.6", "9.13": "9.14", "10.1": "10.2", "10.3": "10.4", "10.5": "10.6", "10.7": "10.8", "10.9": "10.10",
    "11.3": "11.2",
}  # fmt: skip
MIDDLE: dict[str, Vec3] = {
    "2.1": (0, -125, 80), "2.2": (0, -80, 96), "2.3": (0, -80, 95), "2.10": (0, -115, 92), "6.1": (0, -80, 88),
    "6.2": (0, -84, 70), "7.1": (0, -60, 0), "8.1": (0, -75, 98), "8.2": (0, -88, 97), "9.3": (0, -40, 115),
    "9.8": (0, -70, 88), "9.9": (0, -90, 86), "9.10": (0, -80, 89), "9.11": (0, -80, 89), "9.12": (0, -20, 102),
    "9.15": (0, -50, 100), "11.1": (0, 75, 80), "11.4": (0, 120, -20), "11.5": (0, 125, -20), "11.6": (0, 0, -90),
}  # fmt: skip
POINTS: dict[str, Vec3] = {
    **LEFT,
    **{RIGHT[name]: (-x, y, z) for name, (x, y, z) in LEFT.items()},
    **MIDDLE,
}
FACE = FaceDefinition(
    POINTS,
    eye_centers={"left": (32, 0, 70), "right": (-32, 0, 70)},
    iris_diameters={"left": 12, "right": 12},
    pupil_diameters={"left": 4, "right": 4},
)


def with_point(name: str, point: Vec3) -> FaceDefinition:
    return replace(FACE, points={**POINTS, name: point})


def shifted(name: str, axis: int, by: float) -> FaceDefinition:
    point = list(POINTS[name])
    point[axis] += by
    return with_point(name, (point[0], point[1], point[2]))


def test_there_are_84_feature_points() -> None:
    rows = feature_points()
    assert len({row.point for row in rows}) == 84
    counts = [sum(row.point.startswith(f"{group}.") for row in rows) for group in range(2, 12)]
    assert counts == [14, 14, 6, 4, 4, 1, 10, 15, 10, 6]
    assert set(POINTS) == {row.point for row in rows}
    assert [row.point for row in rows if row.printed_x] == ["3.10", "3.13", "5.4"]


def test_units() -> None:
    assert FACE.distances() == {"ES0": 64, "ENS0": 50, "MNS0": 30, "MW0": 52, "IRISD0": 12}
    assert FACE.fapu() == Fapu(es=64 / 1024, ens=50 / 1024, mns=30 / 1024, mw=52 / 1024, irisd=12 / 1024)
    assert AU == 1e-5
    names = fap_unit_names()
    assert (names[0], names[2], names[18], names[22], names[36]) == ("na", "MNS", "IRISD", "AU", "ES")


def test_unit_needs_its_points() -> None:
    with pytest.raises(SnhcError) as caught:
        FaceDefinition({"3.5": (1, 0, 0)}).fapu()
    assert (caught.value.error_class, caught.value.path) == ("InconsistentSemantics", "points.3.6")


def test_known_mistakes_give_another_result() -> None:
    """FAC-1: AU = 1e-4, MNS to 8.1 instead of 2.2, FAP 19 scaled by MNS."""
    faps: list[float | None] = [None] * 68
    faps[2], faps[18], faps[48] = 512.0, 512.0, 10000.0
    points = feature_motion(FACE, faps).points
    still = feature_motion(FACE, [None if i == 48 else v for i, v in enumerate(faps)]).points
    # FAP 3 moves the chin by 512 * 30 / 1024 = 15; FAP 19 the lid by 512 * 12 / 1024 = 6.
    assert still["2.1"] == (0, -140, 80)
    assert still["3.1"] == (32, 0, 80)
    wrong_mns = replace(FACE.fapu(), mns=abs(POINTS["9.15"][1] - POINTS["8.1"][1]) / 1024)
    assert feature_motion(FACE, faps, fapu=wrong_mns).points["2.1"] != points["2.1"]
    wrong_19 = replace(FACE.fapu(), irisd=FACE.fapu().mns)
    assert feature_motion(FACE, faps, fapu=wrong_19).points["3.1"] != points["3.1"]
    tenfold = [None if v is None else v * 10 if i == 48 else v for i, v in enumerate(faps)]
    assert feature_motion(FACE, tenfold).points["9.3"] != points["9.3"]


def test_json_form(tmp_path: Path) -> None:
    document = {
        "format": "snhc-face",
        "version": 1,
        "name": "head",
        "points": {"2.1": [0, 1.5, -2], "2.2": {"position": [1, 2, 3], "mesh": "Face", "vertex": 7}},
        "eye_centers": {"left": [1, 2, 3]},
        "iris_diameters": {"left": 3},
        "more": None,
    }
    face = parse_face_definition_json(json.dumps(document))
    assert face.points == {"2.1": (0, 1.5, -2), "2.2": (1, 2, 3)}
    assert (face.name, face.vertices) == ("head", {"2.2": ("Face", 7)})
    assert (face.eye_centers, face.iris_diameters) == ({"left": (1, 2, 3)}, {"left": 3})
    (tmp_path / "a").write_text("\ufeff " + json.dumps(document))
    assert load_face_definition(tmp_path / "a") == face


@pytest.mark.parametrize(
    ("document", "path"),
    [
        ([], ""),
        ({}, "points"),
        ({"format": "x", "points": {}}, "format"),
        ({"version": 2, "points": {}}, "version"),
        ({"points": {"12.1": [0, 0, 0]}}, "points.12.1"),
        ({"points": {"2.1": [0, 0]}}, "points.2.1"),
        ({"points": {"2.1": [0, 0, None]}}, "points.2.1[2]"),
        ({"points": {"2.1": {"vertex": 1}}}, "points.2.1.position"),
        ({"points": {"2.1": {"position": [0, 0, 0], "vertex": -1}}}, "points.2.1.vertex"),
        ({"points": {}, "eye_centers": {"both": [0, 0, 0]}}, "eye_centers.both"),
        ({"points": {}, "pupil_diameters": {"left": 0}}, "pupil_diameters.left"),
    ],
)
def test_json_faults(document: object, path: str) -> None:
    with pytest.raises(SnhcError) as caught:
        face_definition_from_json(document)
    assert caught.value.path == path


def test_fdp_form(tmp_path: Path) -> None:
    text = "\ufeff# face\r\n\r\n2.1 0.0 -7.25e1, 80 3.17\r\n3.5 32 0 82\n"
    text += "7.1 0 0 0 -1.-1 # none\n14.2 1 2 3 0.1\n2.1 1 2 3\n"
    face, findings = parse_fdp(text.encode())
    assert face.points == {"2.1": (1, 2, 3), "3.5": (32, 0, 82), "7.1": (0, 0, 0)}
    assert face.vertices == {}
    assert [(f.id, f.line) for f in findings] == [("fdp-point-unknown", 6), ("fdp-point-twice", 7)]
    assert parse_fdp("2.1 0 0 0 3.17")[0].vertices == {"2.1": ("3", 17)}
    assert parse_fdp(fdp_text(FACE))[0].points == POINTS
    (tmp_path / "face.fdp").write_text(fdp_text(FACE))
    assert load_face_definition(tmp_path / "face.fdp").fapu() == FACE.fapu()


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("", 1, 1),
        ("# only\n", 1, 1),
        ("2.1 0 0 0\n  x 1 2 3", 2, 3),
        ("2.1 0 0", 1, 1),
        ("2.1 0 0 0 1.1 5", 1, 1),
        ("2.1 0 a 0", 1, 7),
        ("2.1 0 0 nan", 1, 9),
        ("2.1 0 1_0 0", 1, 7),
        ("2.1 0 0 0 5", 1, 11),
        ("2 0 0 0 1.1", 1, 1),
    ],
)
def test_fdp_faults(text: str, line: int, column: int) -> None:
    with pytest.raises(SnhcError) as caught:
        parse_fdp(text)
    assert (caught.value.error_class, caught.value.line, caught.value.column) == ("InputFormat", line, column)


def test_fdp_limit() -> None:
    with pytest.raises(SnhcError) as caught:
        parse_fdp("\n" * 100_001)
    assert caught.value.error_class == "ResourceLimit"


def test_a_good_face_has_no_findings() -> None:
    assert check_locations(FACE) == []
    assert check_neutral(FACE) == []
    assert missing_points(FACE) == ()
    assert missing_points(FaceDefinition({}))[:2] == ("2.1", "2.2")


# Tolerance 2 % of ES0: 1.28.
@pytest.mark.parametrize(
    ("point", "axis", "by"),
    [
        *[(p, 0, 1.4) for p in ("2.6", "2.7", "2.8", "2.9", "3.1", "3.2", "3.3", "3.4", "3.9", "3.10", "3.13", "3.14")],
        *[(p, 0, 1.4) for p in ("4.3", "4.4", "8.5", "8.6", "8.7", "8.8")],
        *[(p, 0, -1.4) for p in ("2.1", "2.10", "6.1", "6.2", "8.1", "9.3", "9.8", "9.9", "9.10", "9.11", "9.12")],
        *[(p, 0, 1.4) for p in ("2.2", "2.3", "8.2", "9.15", "11.1", "11.4", "11.5", "11.6")],
        ("2.11", 0, 7.5), ("2.11", 0, -8.5), ("2.12", 0, 8.5), ("2.12", 0, -7.5),
        ("5.3", 0, 8.5), ("5.3", 0, -9.5), ("5.4", 0, 9.5), ("5.4", 0, -8.5), ("5.3", 1, 16.5), ("5.4", 1, -16.5),
        ("11.2", 0, 25.0), ("11.3", 0, -25.0), ("5.1", 1, 1.4), ("5.2", 1, -1.4), ("9.12", 1, 1.4),
        ("9.13", 1, 1.4), ("9.14", 1, 1.4), ("11.6", 1, 1.4), ("6.3", 2, 1.4), ("6.4", 2, 1.4), ("10.3", 1, 1.4),
        ("10.4", 1, 1.4), ("11.4", 2, 12.0), ("11.4", 2, -12.0), ("11.5", 2, 1.4),
    ],
)  # fmt: skip
def test_every_location_constraint(point: str, axis: int, by: float) -> None:
    found = [check for check in check_locations(shifted(point, axis, by)) if check.point == point]
    assert [(check.point, check.axis) for check in found] == [(point, "xyz"[axis])]
    (check,) = found
    assert check.tolerance == pytest.approx(1.28)
    assert check.value == POINTS[point][axis] + by
    assert check.finding.id == "feature-point-location"
    assert check.finding.path == f"points.{point}.{'xyz'[axis]}"
    assert repr(check.value) in check.finding.message
    # The same shift is within a tolerance that is large enough.
    wide = check_locations(shifted(point, axis, by), tolerance=abs(by) + 0.01)
    assert not any(check.point == point for check in wide)


def test_rows_as_printed() -> None:
    found = {check.point: check.wanted for check in check_locations(FACE, reading="printed")}
    # 3.10 against the left eye, 3.13 against the right one; 5.4.x > 3.6.x and < 3.12.x cannot hold.
    assert found["3.10"] == 32
    assert found["3.13"] == -32
    assert set(found) == {"3.10", "3.13", "5.4"}


@pytest.mark.parametrize(
    ("face", "point", "axis"),
    [
        (shifted("2.3", 1, -1.4), "2.2", "y"),
        (shifted("2.8", 1, -1.4), "2.6", "y"),
        (shifted("2.7", 1, 1.4), "2.7", "y"),
        (shifted("2.4", 1, 1.4), "2.4", "y"),
        (shifted("2.5", 1, 1.4), "2.5", "y"),
        (shifted("9.11", 1, -1.4), "9.10", "y"),
        (shifted("6.1", 1, 1.4), "6.1", "y"),
        (shifted("3.5", 1, 1.4), "3.5", "y"),
        (shifted("3.6", 0, 1.4), "3.6", "x"),
        (replace(FACE, iris_diameters={"left": 14}), "iris_diameters.left", ""),
        (replace(FACE, pupil_diameters={"right": 6}), "pupil_diameters.right", ""),
    ],
)
def test_neutral_face(face: FaceDefinition, point: str, axis: str) -> None:
    found = check_neutral(face)
    assert (point, axis) in {(check.point, check.axis) for check in found}
    assert {check.finding.id for check in found} == {"neutral-face"}
    assert check_neutral(face, tolerance=10.0) == []


def test_right_iris_must_agree() -> None:
    found = check_neutral(shifted("3.2", 1, 0.13))
    assert [(check.point, check.finding.id) for check in found] == [("IRISD0", "iris-diameter")]
    assert (found[0].value, found[0].wanted, found[0].tolerance) == pytest.approx((12.13, 12, 0.12))
    assert check_neutral(shifted("3.2", 1, 0.11)) == []


def test_checks_without_points_are_not_made() -> None:
    assert check_locations(FaceDefinition({}), tolerance=1.0) == []
    assert check_locations(FaceDefinition({"7.1": (50, 0, 0)}), tolerance=1.0) == []
    assert check_neutral(FaceDefinition({}), tolerance=1.0) == []
    with pytest.raises(SnhcError):
        check_locations(FaceDefinition({}))


def test_findings_are_registered() -> None:
    for name in ("feature-point-location", "neutral-face", "iris-diameter", "negative-unidirectional"):
        assert finding(name).severity == "warning"
