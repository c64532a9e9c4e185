"""The mesh vectors of the suite: a decoder with one wrong diagonal, sign or mean is caught by one of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator

import pytest

import snhc.reference_impl.mesh.motion as motion
import snhc.reference_impl.mesh.state as state
import snhc.reference_impl.mesh.syntax as syntax
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.mesh.topology import HalfEdges
from snhc.reference_impl.systems.stream import decode_frames
from snhc.vectors.manifest import SUITE, Accepted, Entry, load

Triangle = tuple[int, int, int]
ENTRIES = {entry.id: entry for entry in load().entries if "mesh" in entry.tools}
VALID = [id for id, entry in ENTRIES.items() if entry.kind == "valid"]


def positions(entry: Entry) -> list[list[list[int]]]:
    """The nodes of every line that is expected."""
    assert isinstance(entry.expect, Accepted)
    lines = (SUITE / entry.expect.file).read_text(encoding="utf-8").splitlines()[1:]
    return [json.loads(line)["nodes"] for line in lines]


def decoded(entry: Entry) -> list[list[list[int]]] | None:
    """The nodes of every frame, None where the stream is refused."""
    try:
        frames = list(decode_frames((SUITE / entry.file).read_bytes(), entry.options.for_decoder()))
    except SnhcError:
        return None
    return [[list(node) for node in frame.nodes] for frame in frames if isinstance(frame, MeshFrame)]


def caught() -> set[str]:
    """The valid vectors whose node positions are not as expected."""
    return {id for id in VALID if decoded(ENTRIES[id]) != positions(ENTRIES[id])}


def test_there_are_enough_and_the_right_decoder_passes() -> None:
    assert len(ENTRIES) >= 100
    assert {entry.kind for entry in ENTRIES.values()} == {"valid", "invalid", "ambiguous"}
    assert {amb for entry in ENTRIES.values() for amb in entry.readings} == {"AMB-MSH-1", "AMB-MSH-2"}
    assert all(entry.media == "m2d" and entry.file.endswith(".m2d") for entry in ENTRIES.values())
    assert caught() == set()


def _half_edges(triangles: list[Triangle], node_count: int) -> HalfEdges:
    start = [node for triangle in triangles for node in triangle]
    place = {(start[e], start[e + 1 if e % 3 < 2 else e - 2]): e for e in range(len(start))}
    return HalfEdges(start, [place.get((b, a), -1) for a, b in place], node_count)


def _flips(xs: list[int], ys: list[int], mesh: HalfEdges) -> Iterator[HalfEdges]:
    """The mesh with one inner edge replaced by the other diagonal of its two triangles, where they are convex."""

    def turn(a: int, b: int, c: int) -> int:
        return (xs[b] - xs[a]) * (ys[c] - ys[a]) - (ys[b] - ys[a]) * (xs[c] - xs[a])

    triangles = [tuple(mesh.start[3 * t : 3 * t + 3]) for t in range(mesh.triangle_count())]
    for e, o in enumerate(mesh.twin):
        if o <= e:
            continue
        a, b = mesh.start[e], mesh.start[o]
        c, d = mesh.start[e - 1 if e % 3 else e + 2], mesh.start[o - 1 if o % 3 else o + 2]
        if turn(a, d, c) > 0 and turn(d, b, c) > 0:
            rest = [t for k, t in enumerate(triangles) if k not in (e // 3, o // 3)]
            yield _half_edges([*rest, (a, d, c), (d, b, c)], mesh.node_count)  # type: ignore[list-item]


@pytest.mark.parametrize(
    "id", [id for id in VALID if ".diagonal." in id or ".orientation." in id or id in ("mesh.example.2",)]
)
def test_one_wrong_diagonal_of_a_delaunay_mesh_is_caught(id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    inner: Callable[..., HalfEdges] = state.delaunay_triangles
    at = 0
    count = 1
    missed = []

    def flipped(xs: list[int], ys: list[int], boundary_count: int, ties: str) -> HalfEdges:
        nonlocal count
        meshes = list(_flips(xs, ys, inner(xs, ys, boundary_count, ties)))
        count = len(meshes)
        return meshes[at]

    monkeypatch.setattr(state, "delaunay_triangles", flipped)
    while at < count:
        if decoded(ENTRIES[id]) == positions(ENTRIES[id]):
            missed.append(at)
        at += 1
    assert count >= 1
    assert missed == []


@pytest.mark.parametrize("code", [0, 1, 2, 3])
def test_a_wrong_split_is_caught(code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    inner = state.uniform_triangles

    def wrong(hor: int, vert: int, split: int, alternation: str = "checkerboard") -> HalfEdges:
        return inner(hor, vert, split ^ 1 if split == code else split, alternation)

    monkeypatch.setattr(state, "uniform_triangles", wrong)
    assert f"mesh.uniform.split.{code:02b}" in caught()


def _truncating(a: int, b: int) -> int:
    return int((a + b) / 2)


@pytest.mark.pure
def test_wrong_means_are_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    for mean in (_truncating, lambda a, b: (a + b) >> 1):

        def predict(topology, k, vx, vy, mean=mean):  # type: ignore[no-untyped-def]
            first, second = topology.predictors[k]
            if first < 0:
                return 0, 0
            return (
                (vx[first], vy[first])
                if first == second
                else (
                    mean(vx[first], vx[second]),
                    mean(vy[first], vy[second]),
                )
            )

        monkeypatch.setattr(syntax, "predict", predict)
        assert "mesh.motion.rounding" in caught()


@pytest.mark.pure
def test_missing_wrap_is_caught_at_every_range(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion, "wrap", lambda v, range_code: v)
    assert {f"mesh.motion.range.{code}" for code in range(1, 8)} <= caught()


@pytest.mark.pure
def test_zero_flag_taken_for_the_prediction_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    inner = syntax.mesh_motion

    def wrong(io, state, plane):  # type: ignore[no-untyped-def]
        inner(io, state, plane)
        vx, vy = [0] * len(state.xs), [0] * len(state.xs)
        for k, node in enumerate(state.topology.order):
            prediction = motion.predict(state.topology, k, vx, vy)
            code = plane.codes[k]
            vx[node], vy[node] = prediction if code.zero else motion.decode_vector(code, prediction, plane.range_code)
        state.vx, state.vy = vx, vy

    monkeypatch.setattr(syntax, "mesh_motion", wrong)
    assert "mesh.motion.zero-flag-is-no-prediction" in caught()
