"""Pictures of a head: normals, the software renderer, GL, GIF timing, sheets, the verb `render`."""

from __future__ import annotations

import importlib
import io
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from snhc.analyzer import contact_sheet
from snhc.analyzer.face_output import Drawing, drawn_count, face_file, pick_frames
from snhc.analyzer.face_pictures import gif_plan, png, sheet, spread
from snhc.analyzer.face_render import (
    BACKGROUND,
    MAX_SIDE,
    MIN_SIDE,
    VIEWS,
    Camera,
    Picture,
    SoftwareRenderer,
    camera_for,
    is_closed,
    vertex_normals,
)
from snhc.analyzer.face_scene import FaceModel, FaceScene, exact_vertices, load_model, still
from snhc.analyzer.face_vtk import VtkRenderer, gl_window
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import InputFormat, RangeViolation
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.model.fat import fat_from_json
from snhc.reference_impl.model.head import head_definition

render_verb = importlib.import_module("snhc.conformance.cli.render")
SIZE = (100, 120)
FLAT = Camera(0, 0, (0, 0, 0), 5)


@pytest.fixture(scope="module")
def scene() -> FaceScene:
    return FaceScene(load_model())


def covered(picture: Picture) -> NDArray[np.bool_]:
    out: NDArray[np.bool_] = (np.abs(picture.astype(int) - np.array(BACKGROUND)) > 8).any(axis=2)
    return out


def grown(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The mask and the pixels next to it."""
    wide = np.pad(mask, 1)
    return np.any([np.roll(wide, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)], axis=0)[1:-1, 1:-1]


def plain(vertices: list[list[float]], faces: list[list[int]], colours: list[list[int]]) -> FaceModel:
    document = fat_from_json({"meshes": {"m": {"vertices": vertices, "faces": faces}}})
    return FaceModel(document, {"m": np.array(colours, np.uint8)}, {}, {})


# -- scene -------------------------------------------------------------------------------------------------------------


def test_bulk_and_literal_agree_and_frames_may_be_asked_for_one_by_one(scene: FaceScene) -> None:
    frames = [still({3: 300, 48: 9000}), still({}, (4, 2, 20)), still({4: 7}, None, (3, 40, 1, 9))]
    whole = scene.vertices(frames)
    for n, each in enumerate(scene.each(frames, 2)):
        exact = exact_vertices(scene.model, frames[n])
        for name, points in each.items():
            assert np.allclose(points, whole[name][n], atol=1e-4)
            assert np.abs(points - exact[name]).max() < 1e-3  # mm


def test_the_head_turns_about_7_1(scene: FaceScene) -> None:
    place = head_definition()["points"]["7.1"]
    turned = scene.vertices([still({48: 30_000, 49: -40_000, 50: 20_000})])
    moved = turned[place["mesh"]][0]
    assert np.allclose(moved[place["vertex"]], place["position"], atol=1e-4)
    # Rigid: no length changes, and the crown has moved by centimetres.
    neutral = scene.neutral()[place["mesh"]]
    assert np.allclose(np.linalg.norm(moved, axis=1), np.linalg.norm(neutral, axis=1), atol=1e-3)
    assert np.linalg.norm(moved - neutral, axis=1).max() > 30


def test_unknown_faps_and_files() -> None:
    with pytest.raises(RangeViolation):
        still({2: 5})
    with pytest.raises(OSError):
        load_model("/no/such/model.json")


def test_models_with_and_without_colours(tmp_path: Path) -> None:
    path = tmp_path / "m.json"
    document = {"meshes": {"m": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}}}
    path.write_text(json.dumps(document))
    assert load_model(str(path)).colours["m"].shape == (1, 3)
    path.write_text(json.dumps({**document, "palette": {"a": [1, 2, 3]}, "colors": {"m": [0]}}))
    assert load_model(str(path)).colours["m"].tolist() == [[1, 2, 3]]
    for bad in (
        {"colors": {"m": [0, 0]}},
        {"palette": {"a": [1, 2]}},
        {"palette": {"a": [1, 2, 3]}, "colors": {"m": [1]}},
    ):
        path.write_text(json.dumps({**document, **bad}))
        with pytest.raises((InputFormat, RangeViolation)):
            load_model(str(path))


# -- software renderer -------------------------------------------------------------------------------------------------


def test_a_square_covers_its_pixels_exactly() -> None:
    # Seen from the front 10 units are 120 pixels: the square [-2, 2) x [-2, 2) covers 48 x 48 of them. Its
    # diagonal runs through the middles of samples, which belong to one of the two faces, not to none.
    model = plain([[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]], [[0, 1, 2], [0, 2, 3]], [[200, 100, 50]] * 2)
    picture = SoftwareRenderer(model, SIZE).picture({"m": model.document.meshes["m"].vertices}, FLAT)
    inside = covered(picture)
    assert inside.sum() == 48 * 48
    assert inside[36:84, 26:74].all()
    # One plane, one normal: one colour, also along the edge that the two faces share.
    assert len(np.unique(picture[inside], axis=0)) == 1


def test_the_nearer_face_is_seen_in_either_order() -> None:
    near, far = [[-1, -1, 1], [1, -1, 1], [0, 1, 1]], [[-2, -2, 0], [2, -2, 0], [0, 2, 0]]
    pictures = []
    for order in ((near, far), (far, near)):
        colours = [[255, 0, 0] if part is near else [0, 0, 255] for part in order]
        model = plain([*order[0], *order[1]], [[0, 1, 2], [3, 4, 5]], colours)
        pictures.append(SoftwareRenderer(model, SIZE).picture({"m": model.document.meshes["m"].vertices}, FLAT))
    assert np.array_equal(*pictures)
    red, _, blue = pictures[0][60, 50]
    assert red > blue


def test_closed_meshes_show_their_outside_open_ones_both_sides() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    outward = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert is_closed(outward) and not is_closed(outward[:3]) and not is_closed(outward[[0, 1, 2, 2]])
    turned = plain([[0, 0, 0], [0, 2, 0], [2, 0, 0]], [[0, 1, 2]], [[200, 0, 0]])
    assert covered(SoftwareRenderer(turned, SIZE).picture({"m": turned.document.meshes["m"].vertices}, FLAT)).any()
    solid = plain(corners, outward.tolist(), [[200, 0, 0]] * 4)
    renderer = SoftwareRenderer(solid, SIZE)
    assert covered(renderer.picture({"m": np.array(corners, np.float64)}, FLAT)).any()
    # Inside out nothing of it is to be seen from outside but its far side's inside, which is not drawn either.
    flipped = plain(corners, outward[:, [0, 2, 1]].tolist(), [[200, 0, 0]] * 4)
    inside_out = SoftwareRenderer(flipped, SIZE).picture({"m": np.array(corners, np.float64)}, FLAT)
    assert covered(inside_out).any()


def test_normals_do_not_depend_on_how_a_corner_is_cut() -> None:
    # A cube's corner with one of its three sides cut in two: weighted by angles the normal stays the diagonal.
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]], np.float64)
    faces = np.array([[0, 4, 1], [0, 2, 4], [0, 1, 3], [0, 3, 2]])
    assert np.allclose(vertex_normals(points, faces)[0], [-1 / np.sqrt(3)] * 3)
    assert np.array_equal(vertex_normals(points[:2], np.zeros((0, 3), np.int64)), np.zeros((2, 3)))


def test_the_same_picture_in_every_run_and_left_right_symmetry(scene: FaceScene) -> None:
    camera = camera_for(scene, "front", SIZE)
    first = SoftwareRenderer(scene.model, SIZE).picture(scene.neutral(), camera)
    assert np.array_equal(first, SoftwareRenderer(scene.model, SIZE).picture(scene.neutral(), camera))
    silhouette = covered(first)
    assert (silhouette ^ silhouette[:, ::-1]).sum() < 0.01 * silhouette.sum()
    assert 0.3 < silhouette.mean() < 0.7
    assert not silhouette[0].any() and not silhouette[:, 0].any()
    for view in VIEWS:
        seen = covered(SoftwareRenderer(scene.model, SIZE).picture(scene.neutral(), camera_for(scene, view, SIZE)))
        assert not (seen[0] | seen[-1]).any() and not (seen[:, 0] | seen[:, -1]).any()


def test_faces_move_in_pictures(scene: FaceScene) -> None:
    renderer = SoftwareRenderer(scene.model, SIZE)
    eyes = Camera(0, 0, (0, 42, 60), 25)
    lids = {19: 1024, 20: 1024}

    def white(picture: Picture) -> int:
        part = picture.astype(int)
        return int(((part.min(axis=2) > 150) & (part.max(axis=2) - part.min(axis=2) < 25)).sum())

    open_eyes, shut = (renderer.picture(pose, eyes) for pose in scene.each([still(), still(lids)]))
    assert white(open_eyes) > 50 and white(shut) < white(open_eyes) / 10


def test_far_away_vertices_and_empty_models_are_drawn_too() -> None:
    model = plain([[0, 0, 0], [1e30, 0, 0], [0, 1e30, 0]], [[0, 1, 2]], [[200, 0, 0]])
    assert covered(SoftwareRenderer(model, SIZE).picture({"m": model.document.meshes["m"].vertices}, FLAT)).any()
    empty = plain([], [], [])
    camera = camera_for(FaceScene(empty), "front", SIZE)
    assert not covered(SoftwareRenderer(empty, SIZE).picture({"m": np.zeros((0, 3))}, camera)).any()
    for bad in ((8, 100), (100, 5000)):
        with pytest.raises(RangeViolation):
            SoftwareRenderer(empty, bad)


def test_gl_draws_the_same(scene: FaceScene) -> None:
    if gl_window() is None:
        pytest.skip("no GL works here")
    renderer = VtkRenderer(scene.model, SIZE)
    software = SoftwareRenderer(scene.model, SIZE)
    pose = next(scene.each([still({3: 400, 5: -500, 52: -400, 49: 20_000})]))
    for view in ("front", "side"):
        camera = camera_for(scene, view, SIZE)
        ours, theirs = software.picture(pose, camera), renderer.picture(pose, camera)
        assert theirs.shape == ours.shape
        # Samples lie elsewhere inside the pixels: silhouettes may differ where they are one pixel wide, not beyond.
        assert not (covered(ours) & ~grown(covered(theirs))).any()
        # GL averages over a wider neighbourhood.
        assert not (covered(theirs) & ~grown(grown(covered(ours)))).any()
        both = covered(ours) & covered(theirs)
        assert np.abs(ours[both].astype(int) - theirs[both].astype(int)).mean() < 8
    renderer.close()


# -- files -------------------------------------------------------------------------------------------------------------


@given(st.lists(st.fractions(0, 5, max_denominator=1001), min_size=1, max_size=30), st.booleans())
def test_gif_timing(times: list[Fraction], ascending: bool) -> None:
    plan = gif_plan(sorted(times) if ascending else times)
    assert plan[0][0] == 0 and [n for n, _ in plan] == sorted({n for n, _ in plan})
    assert all(duration >= 2 for _, duration in plan)
    if ascending:
        first = min(times)
        shown = 0
        for n, duration in plan:
            # Errors do not add up: every frame starts within half a hundredth of its time (equal times: later ones).
            if len(set(times)) == len(times):
                assert abs(shown - (sorted(times)[n] - first) * 100) <= 1
            shown += duration


def test_gif_timing_of_usual_rates() -> None:
    assert [d for _, d in gif_plan([Fraction(n, 25) for n in range(5)])] == [4] * 5
    assert [d for _, d in gif_plan([Fraction(n, 30) for n in range(7)])] == [3, 4, 3, 3, 4, 3, 3]
    fast = gif_plan([Fraction(n, 200) for n in range(200)])
    assert {d for _, d in fast} == {2} and 50 <= len(fast) <= 51
    assert gif_plan([Fraction(1)]) == [(0, 4)] and gif_plan([]) == []


def test_spread_and_sheets() -> None:
    assert spread(3, 12) == [0, 1, 2] and spread(100, 1) == [0]
    assert spread(100, 12)[0] == 0 and spread(100, 12)[-1] == 99 and len(set(spread(100, 12))) == 12
    one = np.full((20, 30, 3), 7, np.uint8)
    whole = sheet([one] * 5, list("abcde"), 4)
    assert whole.shape == (2 * 36, 4 * 30, 3)
    assert len(png(whole, 16)) < len(png(whole)) * 2


def frames_of(count: int) -> list[FaceFrame]:
    faps = [[0 if fap < 3 else 10 * n if fap == 3 else None for fap in range(1, 69)] for n in range(count)]
    out = []
    for n, row in enumerate(faps):
        row[0] = row[1] = None
        state = "".join("U" if value is None else "T" for value in row)
        out.append(FaceFrame(n, (n, 25), n == 0, tuple(row), None, None, state))
    return out


def test_files_of_frames(scene: FaceScene) -> None:
    look = Drawing((40, 48), "side", software=True)
    frames = frames_of(15)
    done: list[int] = []
    moving = Image.open(io.BytesIO(face_file(scene.model, frames, "gif", look, done.append)))
    assert moving.size == (40, 48) and done[-1] == drawn_count(frames, "gif") == 15
    total = 0
    for n in range(moving.n_frames):  # type: ignore[attr-defined]
        moving.seek(n)
        total += moving.info["duration"]
    assert total == 15 * 40 and moving.info["loop"] == 0
    assert Image.open(io.BytesIO(face_file(scene.model, frames, "png", look))).size == (4 * 40, 3 * (48 + 16))
    assert Image.open(io.BytesIO(face_file(scene.model, frames[:1], "png", look))).size == (40, 48)
    assert face_file(scene.model, frames, "glb", look)[:4] == b"glTF"
    assert [frame.index for frame in pick_frames(frames, (3, 5))] == [3, 4]
    with pytest.raises(InputFormat):
        pick_frames(frames, (15, None))


def test_contact_sheets_show_everything(scene: FaceScene) -> None:
    names = {name: [shot.label for shot in shots] for name, shots, _, _ in contact_sheet.sheets()}
    assert [len(names[name]) for name in ("faps-03-35", "faps-36-68", "visemes", "expressions")] == [33, 33, 15, 7]
    assert [label.split()[0] for label in names["faps-03-35"] + names["faps-36-68"]] == [str(n) for n in range(3, 69)]
    shots = contact_sheet.fap_shots()[:2]
    assert contact_sheet.draw(shots, (32, 32), 2, scene).shape == (48, 64, 3)


# -- verb --------------------------------------------------------------------------------------------------------------


def run(*args: object, stdin: bytes | str | None = None) -> Result:
    return CliRunner().invoke(snhc, [str(arg) for arg in args], input=stdin)


@pytest.fixture
def stream(tmp_path: Path) -> Path:
    path = tmp_path / "s.fba"
    mask = " ".join("1" if fap == 3 else "0" for fap in range(1, 69))
    text = "2.1 test 25 3\n" + "".join(f"{mask}\n{n} {n * 100}\n" for n in range(3))
    assert run("encode", "-", "-o", path, stdin=text).exit_code == 0
    return path


def test_views_are_those_of_the_renderer() -> None:
    assert tuple(VIEWS) == render_verb.VIEWS
    assert (MIN_SIDE, MAX_SIDE) == render_verb.SIDES


def test_the_verb_draws_faces(stream: Path, tmp_path: Path) -> None:
    picture = tmp_path / "p.png"
    assert run("render", stream, "--software", "--size", "50x60", "--planes", "1", "-o", picture).exit_code == 0
    assert Image.open(io.BytesIO(picture.read_bytes())).size == (50, 60)
    for name in ("p.gif", "p.glb"):
        assert run("render", stream, "--software", "--size", "50x60", "-o", tmp_path / name).exit_code == 0
    assert Image.open(io.BytesIO((tmp_path / "p.gif").read_bytes())).n_frames == 3  # type: ignore[attr-defined]
    assert (tmp_path / "p.glb").read_bytes()[:4] == b"glTF"


def test_the_verb_refuses(stream: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    target = tmp_path / "p.png"
    for size in ("50", "0x0", "5x5", "400x0", "4097x400"):
        assert run("render", stream, "-o", target, "--software", "--size", size).exit_code == 2, size
    for args in (("--texture", "x.png"), ("--scale", "2"), ("--view", "back"), ("--interactive",)):
        assert run("render", stream, "-o", target, *args).exit_code == 2, args
    assert run("render", stream, "-o", target, "--software", "--planes", "9:").exit_code == 3
    assert run("render", stream, "-o", target, "--model", tmp_path / "none.json").exit_code == 3
    assert not target.exists()
