"""How far the shipped head can go: no triangle turns over inside the ranges that docs/head.md names.

Rules: FAC-4, FAC-10, FAT-4.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from snhc.analyzer.face_render import Camera, SoftwareRenderer
from snhc.analyzer.face_scene import FaceModel, exact_vertices, load_model, still
from snhc.reference_impl.face.fap_text import FapFile, read_fap
from snhc.reference_impl.model.fat import FatDocument, FrameLike, fat_from_json
from snhc.reference_impl.model.fat_bulk import BulkFat
from snhc.reference_impl.model.head import feature_vertices, head_poses, load_head
from snhc.reference_impl.tables import fap_table
from snhc.vectors.sequences import expressions, speech

PAGE = Path(__file__).parents[2] / "docs" / "head.md"
ROW = re.compile(r"\| ([0-9, ]+) \| [^|]+ \| (-?\d+) \| (\d+) \| (\d+) \|")
STEP = 20
# They turn as a whole.
TURNED = {23, 24, 25, 26, 48, 49, 50}
# The size of the pupil is on the ball, the tongue's roll is an angle.
ELSEWHERE = {29, 30, 47}


def rows() -> list[tuple[tuple[int, ...], int, int, int]]:
    found = [
        (tuple(int(fap) for fap in match[1].split(",")), int(match[2]), int(match[3]), int(match[4]))
        for match in map(ROW.fullmatch, PAGE.read_text().splitlines())
        if match
    ]
    assert found
    return found


@cache
def resting() -> tuple[FatDocument, BulkFat]:
    """The head without rotations: what turns is what is pulled."""
    head = load_head()
    tables = [{**table, "transforms": []} for table in head["tables"]]
    document = fat_from_json({"fapu": head["fapu"], "meshes": head["meshes"], "tables": tables})
    return document, BulkFat(document)


def normals(points: NDArray[np.floating], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    corners = points[..., faces, :].astype(np.float64)
    return np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])


def turned_over(frames: Sequence[FrameLike], lid_edges: bool = True) -> NDArray[np.bool_]:
    """Per frame: does a triangle of a mesh but the eyeballs face away from where it faced?

    `lid_edges`: also one of the thickness of the lids, which faces up at the corners of a closed eye.
    """
    document, bulk = resting()
    posed = bulk.evaluate(frames)
    out = np.zeros(len(frames), bool)
    head = load_head()
    edges = [n for n, name in enumerate(head["palette"]) if name in ("lash", "lid_edge")]
    for name, mesh in document.meshes.items():
        if not name.endswith("_eye"):
            faces = mesh.faces if lid_edges else mesh.faces[~np.isin(head["colors"][name], edges)]
            before, after = normals(mesh.vertices, faces), normals(posed[name], faces)
            out |= ((before * after).sum(axis=-1) <= 0).any(axis=-1)
    return out


def together(faps: Sequence[int], value: int) -> FrameLike:
    return still(dict.fromkeys(faps, value))


@pytest.mark.parametrize(("faps", "low", "high", "end"), rows(), ids=lambda v: str(v).strip("()").replace(", ", "+"))
def test_nothing_turns_over_inside_the_range_and_something_does_past_it(
    faps: tuple[int, ...], low: int, high: int, end: int
) -> None:
    table = [fap_table()[fap - 1] for fap in faps]
    assert end == min(fap.i_max * fap.QP for fap in table)
    if any(fap.direction == "U" for fap in table):
        assert low == 0
    inside = [*range(low, high + 1, STEP), high]
    assert not turned_over([together(faps, value) for value in inside]).any()
    beyond = [high + STEP] if high + STEP <= end else []
    if low and low - STEP >= -end:
        beyond.append(low - STEP)
    for value in beyond:
        assert turned_over([together(faps, value)]).all(), value


def test_every_fap_has_a_row() -> None:
    left = {fap for faps, *_ in rows() for fap in faps}
    assert left | TURNED | ELSEWHERE == set(range(3, 69))


@pytest.mark.parametrize("part", [63, 31])
def test_visemes_and_expressions_turn_nothing_over(part: int) -> None:
    visemes, expressions = head_poses()
    poses: list[Mapping[int, int]] = [*visemes.values(), *expressions.values()]
    frames = [still({fap: round(value * part / 63) for fap, value in pose.items()}) for pose in poses]
    assert not turned_over(frames).any()


@pytest.mark.parametrize("make", [speech, expressions])
def test_sequences_turn_nothing_over_but_the_edges_of_closed_lids(make: Callable[..., FapFile]) -> None:
    text = make(400, 3)
    frames = [still({n + 1: v for n, v in enumerate(frame.values) if n > 1 and v is not None}) for frame in text.frames]
    assert not turned_over(frames, lid_edges=False).any()
    assert 0 < turned_over(frames).mean() < 0.05


@pytest.mark.corpus
def test_real_sequences_turn_nothing_over(corpus: Path) -> None:
    files = sorted((corpus / "fap").glob("*.fap"))
    assert files
    for path in files:
        with path.open("rb") as file:
            text = read_fap(file)
        frames = [
            still({n + 1: v for n, v in enumerate(frame.values) if n > 1 and v is not None}) for frame in text.frames
        ]
        assert not turned_over(frames).any(), path.name


def test_brows_do_not_cross() -> None:
    values = [*range(0, 901, STEP)]
    for other in (1.0, 0.5, 0.0):
        posed = resting()[1].evaluate([still({37: v, 38: round(v * other)}) for v in values])
        left, right = posed["left_brow"][..., 0].min(axis=1), posed["right_brow"][..., 0].max(axis=1)
        assert (left - right).min() > 0.5  # mm


def test_the_squeeze_is_exact_until_the_brows_press_against_each_other() -> None:
    model = load_model()
    mesh, vertex = feature_vertices()["4.1"]
    unit = model.document.fapu.unit("ES")
    assert unit is not None
    start = exact_vertices(model, still({}))[mesh][vertex, 0]
    moved = {v: (start - exact_vertices(model, still({37: v}))[mesh][vertex, 0]) / unit for v in range(-900, 901, 20)}
    for value, way in moved.items():
        if -300 <= value <= 140:
            assert way == pytest.approx(value, abs=0.1)
        else:
            assert 0 < abs(way) < abs(value)
    assert list(moved.values()) == sorted(moved.values())


@pytest.mark.parametrize("value", [-200, -100, 100, 200])
def test_a_thrust_eyeball_stays_behind_the_lids(value: int) -> None:
    model = load_model()
    colours = {name: np.full_like(faces, 255 if name.endswith("_eye") else 0) for name, faces in model.colours.items()}
    plain = FaceModel(model.document, colours, {}, {})
    camera = Camera(0, 0, (31, 38, 90), 22)
    renderer = SoftwareRenderer(plain, (120, 110))
    seen = [
        int((renderer.picture(exact_vertices(plain, still({27: v})), camera).max(axis=2) > 60).sum())
        for v in (0, value)
    ]
    assert seen[0] > 800
    assert abs(seen[1] - seen[0]) < 0.05 * seen[0]
