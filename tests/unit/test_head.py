"""The shipped head: FAC-1..6, FAC-10, FAT-1..9 on our own model."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from snhc.reference_impl.model.face_checks import check_locations, check_neutral, missing_points
from snhc.reference_impl.model.face_definition import (
    FaceDefinition,
    face_definition_from_json,
    feature_point_names,
)
from snhc.reference_impl.model.fat import FatDocument, evaluate, fat_from_json
from snhc.reference_impl.model.feature_motion import feature_motion
from snhc.reference_impl.model.head import (
    HEAD_FILE,
    feature_vertices,
    head_definition,
    head_poses,
    load_head,
)
from snhc.reference_impl.model.head.build import build_document, document_bytes
from snhc.reference_impl.tables import fap_table, left_right_pairs

Array = NDArray[np.float64]
Points = Mapping[str, Array]

MESHES = (
    "skin", "left_eye", "right_eye", "left_brow", "right_brow", "left_ear", "right_ear",
    "teeth_upper", "teeth_lower", "tongue", "hair",
)  # fmt: skip
EYES = {"left_eye": "left", "right_eye": "right"}
AXES = {"left": (0, 1), "right": (0, -1), "up": (1, 1), "down": (1, -1), "forward": (2, 1)}
LINEAR = [fap for fap in fap_table() if fap.positive_motion in AXES and fap.unit != "AU" and fap.fdp_point]
INNER, OUTER = (*range(4, 14),), (*range(51, 61),)
# D is rounded to 0.0005: of a motion of `d` mm at most d * 0.0005 is lost.
ROUNDING = 0.0006
POSITION = 0.0011


@dataclass
class _Frame:
    faps: list[int | None]
    viseme: tuple[int, ...] | None = None
    expression: tuple[int, ...] | None = None


@cache
def _document() -> FatDocument:
    return fat_from_json(load_head())


@cache
def _face() -> FaceDefinition:
    return face_definition_from_json(head_definition())


@cache
def _vertices() -> dict[str, tuple[str, int]]:
    return feature_vertices()


@cache
def _neutral() -> dict[str, Array]:
    return _pose({})


def _values(faps: Mapping[int, int]) -> list[int | None]:
    return [faps.get(n + 1) for n in range(68)]


def _pose(faps: Mapping[int, int] | None = None, **high: tuple[int, ...]) -> dict[str, Array]:
    return evaluate(_document(), _Frame(_values(faps or {}), **high))


def _at(posed: Points, point: str) -> Array:
    mesh, vertex = _vertices()[point]
    found: Array = posed[mesh][vertex]
    return found


def _distance(fap: int, value: int) -> float:
    unit = _face().fapu().unit(fap_table()[fap - 1].unit)
    assert unit is not None
    return value * unit


def _mouth_gap(posed: Points) -> float:
    return float(_at(posed, "2.2")[1] - _at(posed, "2.3")[1])


def _edges(faces: list[list[int]]) -> Counter[tuple[int, int]]:
    return Counter((f[k], f[(k + 1) % 3]) for f in faces for k in range(3))


def _twins(posed: Points, name: str) -> tuple[str, list[int]]:
    """The mirrored mesh and, for every vertex, the one at its mirrored neutral place."""
    neutral = _neutral()
    if name.startswith(("left_", "right_")):
        side, rest = name.split("_", 1)
        name_there = ("right_" if side == "left" else "left_") + rest
    else:
        name_there = name
    here, there = neutral[name] * (-1.0, 1.0, 1.0), neutral[name_there]
    found = []
    for p in here:
        d = np.abs(there - p).max(axis=1)
        found.append(int(d.argmin()))
        assert d.min() < 1e-6, (name, p)
    return name_there, found


@cache
def _mirror_map() -> dict[str, tuple[str, list[int]]]:
    neutral = _neutral()
    return {name: _twins(neutral, name) for name in MESHES}


def test_the_data_file_is_what_the_script_makes() -> None:
    assert document_bytes(build_document()) == HEAD_FILE.read_bytes()


def test_size() -> None:
    head = load_head()
    assert tuple(head["meshes"]) == MESHES
    assert 500 <= sum(len(m["vertices"]) for m in head["meshes"].values()) <= 1500
    assert len(head["meshes"]["skin"]["vertices"]) > 800
    assert HEAD_FILE.stat().st_size < 900_000


@pytest.mark.parametrize("name", MESHES)
def test_meshes_are_closed_and_face_outwards(name: str) -> None:
    mesh = load_head()["meshes"][name]
    points, faces = np.array(mesh["vertices"]), mesh["faces"]
    edges = _edges(faces)
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert {i for face in faces for i in face} == set(range(len(points)))
    # Euler: one closed surface without handles has V - E + F = 2.
    assert len(points) - len(edges) // 2 + len(faces) == 2
    a, b, c = (points[[f[k] for f in faces]] for k in range(3))
    normals = np.cross(b - a, c - a)
    assert np.linalg.norm(normals, axis=1).min() / 2 > 1e-3
    assert float((a * normals).sum()) / 6 > 100
    assert len({tuple(p) for p in mesh["vertices"]}) == len(points)


@pytest.mark.parametrize(
    ("point", "way"),
    [("9.3", (0, 0, 1)), ("5.1", (1, 0, 1)), ("5.2", (-1, 0, 1)), ("11.6", (0, 0, -1)), ("3.5", (0, 0, 1)),
     ("2.1", (0, -1, 1)), ("11.5", (0, 1, 0)), ("8.1", (0, 0, 1)), ("9.10", (0, -1, 1)), ("6.2", (0, 1, 0))],
)  # fmt: skip
def test_normals_at_feature_points(point: str, way: tuple[int, int, int]) -> None:
    name, vertex = _vertices()[point]
    mesh = load_head()["meshes"][name]
    p = np.array(mesh["vertices"])
    normal = sum(
        np.cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]]) for f in mesh["faces"] if vertex in f
    )  # fmt: skip
    assert float(np.dot(normal, way)) > 0.5 * float(np.linalg.norm(normal)) * float(np.linalg.norm(way))


def test_every_face_has_a_colour() -> None:
    head = load_head()
    used = set()
    for name, mesh in head["meshes"].items():
        assert len(head["colors"][name]) == len(mesh["faces"])
        used |= set(head["colors"][name])
    assert used == set(range(len(head["palette"])))
    assert all(len(rgb) == 3 and all(0 <= v <= 255 for v in rgb) for rgb in head["palette"].values())


def test_all_feature_points() -> None:
    face = _face()
    assert missing_points(face) == ()
    assert set(_vertices()) == feature_point_names()
    assert len(set(_vertices().values())) == len(set(face.points.values())) == 84
    posed = _neutral()
    for name, point in face.points.items():
        assert np.abs(_at(posed, name) - point).max() < 1e-9, name
    assert face.points["7.1"] == (0, 0, 0)


def test_table_6_and_the_neutral_face() -> None:
    assert check_locations(_face()) == []
    assert check_neutral(_face()) == []


@pytest.mark.parametrize("mesh", EYES)
def test_drawn_iris_and_pupil_have_their_diameters(mesh: str) -> None:
    head, side = load_head(), EYES[mesh]
    names = list(head["palette"])
    points = np.array(head["meshes"][mesh]["vertices"])
    for name, wanted in (("iris", _face().iris_diameters[side]), ("pupil", _face().pupil_diameters[side])):
        faces = zip(head["meshes"][mesh]["faces"], head["colors"][mesh], strict=True)
        drawn = sorted({i for face, colour in faces if names[colour] == name for i in face})
        assert 2 * np.hypot(points[drawn, 0], points[drawn, 1]).max() == pytest.approx(wanted, abs=0.003)


def test_units_are_those_of_the_feature_points() -> None:
    units = _face().fapu()
    for name in ("ES", "ENS", "MNS", "MW", "IRISD"):
        assert _document().fapu.unit(name) == pytest.approx(units.unit(name), rel=1e-12)


def _colours_around(name: str) -> dict[int, set[int]]:
    head = load_head()
    out: dict[int, set[int]] = {}
    for face, colour in zip(head["meshes"][name]["faces"], head["colors"][name], strict=True):
        for i in face:
            out.setdefault(i, set()).add(colour)
    return out


def test_the_head_is_its_own_mirror_image() -> None:
    mirror = _mirror_map()
    for name, (there, twins) in mirror.items():
        assert sorted(twins) == list(range(len(twins)))
        assert mirror[there][0] == name
    for name, (there, twins) in mirror.items():
        # A quad may be split along the other diagonal over there: the colours around a vertex are the same.
        here, over = _colours_around(name), _colours_around(there)
        assert all(over[twins[i]] == colours for i, colours in here.items()), name


def test_tables_for_every_fap() -> None:
    document = _document()
    low = [t.fap_id for t in document.tables if t.fap_id > 2]
    assert low == list(range(3, 69))
    high = [(t.fap_id, t.high_level_select) for t in document.tables if t.fap_id < 3]
    assert high == [(1, n) for n in range(1, 15)] + [(2, n) for n in range(1, 7)]
    for table in document.tables:
        moved = sum(len(mesh.coord_index) for mesh in table.meshes)
        assert moved > (20 if table.fap_id < 3 else 2) or table.transforms, table.fap_id


@pytest.mark.parametrize("fap", LINEAR, ids=lambda f: f.name)
def test_feature_point_moves_by_value_times_unit(fap: Any) -> None:
    axis, sign = AXES[fap.positive_motion]
    neutral = _neutral()
    values = (100, 333, 600, -150) if fap.direction == "B" else (100, 333, 600)
    # Farther in, the brows press against each other (test_head_limits).
    for value in (70, 140, -150, -300) if fap.number in (37, 38) else values:
        posed = _pose({fap.number: value})
        for number in fap.fdp_point:
            point = f"{fap.fdp_group}.{number}"
            want = sign * _distance(fap.number, value)
            moved = float(_at(posed, point)[axis] - _at(neutral, point)[axis])
            assert moved == pytest.approx(want, abs=abs(want) * ROUNDING + 1e-9), (point, value)


@pytest.mark.parametrize("fap", [*INNER, *OUTER])
def test_lip_faps_move_their_own_feature_point_only(fap: int) -> None:
    neutral, posed = _neutral(), _pose({fap: 200})
    own = f"{fap_table()[fap - 1].fdp_group}.{fap_table()[fap - 1].fdp_point[0]}"
    moved = {p for p in _face().points if np.abs(_at(posed, p) - _at(neutral, p)).max() > 1e-9}
    # 8.9 and 8.10 lie between 8.1 and 8.5, 8.6 and have no FAP of their own.
    assert {p for p in moved if p[:2] in ("2.", "8.")} - {"8.9", "8.10"} == {own}


@pytest.mark.parametrize("faps", [{23: 30000}, {24: -20000, 26: 12000}, {25: -15000, 23: 9000, 27: 100}, {28: 200},
                                  {48: 30000}, {49: -40000}, {50: 25000}, {48: 20000, 49: 30000, 50: -15000, 23: 8000},
                                  {47: 76800}])  # fmt: skip
def test_rotations_are_those_of_the_feature_points(faps: dict[int, int]) -> None:
    posed, want = _pose(faps), feature_motion(_face(), _values(faps)).points
    points = (
        ("3.5", "3.6", "7.1", "9.3", "11.5", "4.1", "10.3", "6.2", "6.3", "6.4") if 47 not in faps else ("6.3", "6.4")
    )
    for point in points:
        assert np.abs(_at(posed, point) - want[point]).max() < 0.02, point


@pytest.mark.parametrize(("fap", "mesh"), [(29, "left_eye"), (30, "right_eye")])
@pytest.mark.parametrize("value", [-341, -100, 150, 420])
def test_pupil_grows(fap: int, mesh: str, value: int) -> None:
    neutral, posed = _neutral(), _pose({fap: value})
    moved = np.flatnonzero(np.abs(posed[mesh] - neutral[mesh]).max(axis=1) > 1e-9)
    centre = _face().eye_centers[EYES[mesh]]
    assert len(moved) == 16
    rings = [np.hypot(*(p[mesh][moved, :2] - centre[:2]).T) * 2 for p in (neutral, posed)]
    assert np.allclose(rings[1] - rings[0], _distance(fap, value), atol=0.01)
    depth = np.linalg.norm(posed[mesh][moved] - centre, axis=1)
    # Chords of the piecewise path lie a little inside the ball.
    assert float(np.abs(depth - 15).max()) < 0.15
    unmoved = {name: np.abs(posed[name] - neutral[name]).max() for name in MESHES if name != mesh}
    assert max(unmoved.values()) == 0


@pytest.mark.parametrize(("left", "right"), left_right_pairs())
def test_left_and_right_mirror_each_other(left: int, right: int) -> None:
    angle = fap_table()[left - 1].unit == "AU"
    value = 20000 if angle else 170
    # Both eyes yaw to the left: the mirror image of one yawing left is the other yawing right.
    back = -value if (left, right) == (23, 24) else value
    here, there = _pose({left: value}), _pose({right: back})
    for name, (twin, index) in _mirror_map().items():
        assert np.abs(here[name] * (-1.0, 1.0, 1.0) - there[twin][index]).max() < POSITION, name


@pytest.mark.parametrize("fap", [3, 4, 5, 14, 16, 17, 18, 44, 45, 46, 47, 51, 52, 63])
def test_middle_faps_keep_the_symmetry(fap: int) -> None:
    posed = _pose({fap: 50000 if fap == 47 else 250})
    for name, (twin, index) in _mirror_map().items():
        assert np.abs(posed[name] * (-1.0, 1.0, 1.0) - posed[twin][index]).max() < POSITION, name


def _lid_edges() -> tuple[list[int], list[int]]:
    """The skin vertices of the left upper and lower lid edge, inner to outer: the rings of 3.1 and 3.3."""
    posed, centre = _neutral(), np.array(_face().eye_centers["left"])
    reach = np.linalg.norm(posed["skin"] - centre, axis=1)
    radius = reach[_vertices()["3.1"][1]]
    ring = [int(i) for i in np.flatnonzero(np.abs(reach - radius) < 0.01)]
    ring.sort(key=lambda i: float(posed["skin"][i, 0]))
    upper = [i for i in ring[1:-1] if posed["skin"][i, 1] > centre[1]]
    lower = [i for i in ring[1:-1] if posed["skin"][i, 1] < centre[1]]
    return upper, lower


@pytest.mark.parametrize(("top", "bottom"), [(1024, 0), (512, 512), (768, 256), (424, 600), (0, 1024)])
def test_lids_meet_when_their_faps_fill_the_iris(top: int, bottom: int) -> None:
    upper, lower = _lid_edges()
    assert len(upper) == len(lower) == 7
    posed = _pose({19: top, 21: bottom, 20: top, 22: bottom})
    a, b = posed["skin"][upper], posed["skin"][lower]
    assert np.abs(a[:, :2] - b[:, :2]).max() < 0.02
    assert np.abs(a[:, 2] - b[:, 2]).max() < 0.35
    assert float(_at(posed, "3.2")[1]) == pytest.approx(float(_at(posed, "3.4")[1]), abs=0.02)


@pytest.mark.parametrize("faps", [{}, {19: 300}, {19: 700}, {19: 1024}, {21: 500}, {19: -300}, {21: -200}])
def test_lids_stay_outside_the_eyeball(faps: dict[int, int]) -> None:
    upper, lower = _lid_edges()
    reach = np.linalg.norm(_pose(faps)["skin"][upper + lower] - np.array(_face().eye_centers["left"]), axis=1)
    assert reach.min() > 15.1
    assert reach.max() < 17.5


def test_mouth_is_closed_in_the_neutral_face() -> None:
    neutral = _neutral()
    assert 0 < _mouth_gap(neutral) < 0.02 * 62
    for upper, lower in (("2.6", "2.8"), ("2.7", "2.9")):
        assert 0 < float(_at(neutral, upper)[1] - _at(neutral, lower)[1]) < 0.02 * 62


def test_open_jaw_moves_chin_and_lower_teeth_but_not_the_lips() -> None:
    # Table 7 of the paper: "Vertical jaw displacement (does not affect mouth opening)".
    neutral, posed = _neutral(), _pose({3: 900})
    assert _mouth_gap(posed) == _mouth_gap(neutral)
    lips = [p for p in _face().points if p.startswith("8.") or p in ("2.2", "2.3", *(f"2.{n}" for n in range(4, 10)))]
    assert len(lips) == 18
    assert all((_at(posed, p) == _at(neutral, p)).all() for p in lips)
    drop = _distance(3, 900)
    assert float(_at(neutral, "9.11")[1] - _at(posed, "9.11")[1]) > 0.8 * drop
    assert (_at(posed, "9.10") == _at(neutral, "9.10")).all()
    # The jaw turns about its joint: the chin goes back as it falls, more and more.
    back = [float(_at(neutral, "2.1")[2] - _at(_pose({3: v}), "2.1")[2]) for v in (300, 600, 900)]
    assert 0 < back[0] < back[1] - back[0] < back[2] - back[1]


def test_mouth_opens() -> None:
    neutral = _neutral()
    assert _mouth_gap(_pose({5: -400})) - _mouth_gap(neutral) == pytest.approx(_distance(5, 400), rel=1e-3)
    assert _mouth_gap(_pose({4: -200})) - _mouth_gap(neutral) == pytest.approx(_distance(4, 200), rel=1e-3)
    assert _mouth_gap(_pose(viseme=(10, 0, 63))) > 15
    assert _mouth_gap(_pose(viseme=(1, 0, 63))) <= _mouth_gap(neutral)
    assert _mouth_gap(_pose(expression=(6, 63, 0, 0))) > 12


@pytest.mark.parametrize("amplitude", [63, 21])
def test_visemes_and_expressions_are_their_poses(amplitude: int) -> None:
    neutral = _neutral()
    for kind, poses in enumerate(head_poses(), 1):
        for select, faps in poses.items():
            low = _pose(faps)
            if kind == 1:
                high = _pose(viseme=(select, 0, amplitude))
            else:
                high = _pose(expression=(select, amplitude, 0, 0))
            for name in MESHES:
                want = neutral[name] + (low[name] - neutral[name]) * amplitude / 63
                assert np.abs(high[name] - want).max() < 0.004, (kind, select, name)


def test_expressions_do_what_the_paper_says() -> None:
    neutral = _neutral()

    def moved(select: int, point: str) -> Array:
        return _at(_pose(expression=(select, 63, 0, 0)), point) - _at(neutral, point)

    joy, sadness, anger, fear, disgust, surprise = range(1, 7)
    # Table 4, one line of it after the other.
    assert moved(joy, "4.1")[1] == 0 and moved(joy, "8.3")[0] > 5 and moved(joy, "8.3")[2] < 0
    assert moved(sadness, "4.1")[1] > 5 > moved(sadness, "4.5")[1] and -5 < moved(sadness, "3.1")[1] < -1
    assert moved(anger, "4.1")[1] < -3 and moved(anger, "4.1")[0] < -2 and moved(anger, "3.1")[1] > 1
    assert moved(fear, "4.1")[1] > 5 and moved(fear, "4.1")[0] < -2 and moved(fear, "3.1")[1] > 1
    assert moved(disgust, "2.2")[1] > 3 and moved(disgust, "2.6")[1] > moved(disgust, "2.7")[1]
    assert min(moved(surprise, p)[1] for p in ("4.1", "4.3", "4.5", "3.1")) > 3 and moved(surprise, "2.1")[1] < -10


def test_jaw_angle_has_the_fall_of_the_chin() -> None:
    # 1200 units are 23.4 mm; the joint is 95.2 mm above and 80.3 mm behind the chin.
    neutral, posed = _at(_neutral(), "2.1"), _at(_pose({3: 1200}), "2.1")
    joint = np.array([0.0, -18 + 38, 8 + 10])
    assert math.dist(joint, posed) == pytest.approx(math.dist(joint, neutral), abs=0.05)
