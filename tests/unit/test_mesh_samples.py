"""Whole sequences: the samples and the worked examples, read by the tests' own parser (MSH-5..21)."""

from __future__ import annotations

import pytest
from mesh_second_parser import Plane, parse, sample, sample_names

from snhc.reference_impl.mesh.motion import VectorCode, decode_vector, move, predict, vector_code
from snhc.reference_impl.mesh.polygon import first_fault
from snhc.reference_impl.mesh.topology import MeshTopology
from snhc.reference_impl.mesh.traversal import traverse
from snhc.reference_impl.mesh.triangulation import delaunay_triangles
from snhc.reference_impl.mesh.uniform import uniform_positions, uniform_triangles


def _topology(plane: Plane, alternation: str = "checkerboard", ties: str = "lowest") -> MeshTopology:
    assert plane.nodes is not None
    xs = [x for x, _ in plane.nodes]
    ys = [y for _, y in plane.nodes]
    if plane.uniform is not None:
        hor, vert, width, height, split = plane.uniform
        assert uniform_positions(hor, vert, width, height) == (xs, ys)
        return traverse(xs, ys, uniform_triangles(hor, vert, split, alternation))
    assert first_fault(xs, ys, plane.boundary_count) is None
    return traverse(xs, ys, delaunay_triangles(xs, ys, plane.boundary_count, ties))


def _decode(planes: list[Plane]) -> list[dict[str, object]]:
    lines: list[dict[str, object]] = []
    xs: list[int] = []
    ys: list[int] = []
    topology = MeshTopology([], [], [])
    for plane in planes:
        line: dict[str, object] = {"intra": plane.intra}
        if plane.nodes is not None:
            topology = _topology(plane)
            xs = [x for x, _ in plane.nodes]
            ys = [y for _, y in plane.nodes]
            line["triangles"] = [list(t) for t in topology.triangles]
            line["order"] = topology.order
        elif plane.range_code:
            vx = [0] * len(xs)
            vy = [0] * len(xs)
            for k, code in enumerate(plane.codes):
                node = topology.order[k]
                prediction = predict(topology, k, vx, vy)
                vx[node], vy[node] = decode_vector(VectorCode(*code), prediction, plane.range_code)
                again = vector_code((vx[node], vy[node]), prediction, plane.range_code)
                if not code[0] and again.zero == 0:
                    assert (again.x_vlc, again.x_res, again.y_vlc, again.y_res) == code[1:]
            xs, ys = move(xs, ys, vx, vy)
        line["nodes"] = [[x, y] for x, y in zip(xs, ys, strict=True)]
        lines.append(line)
    return lines


@pytest.mark.parametrize("name", sample_names())
def test_sample(name: str) -> None:
    planes, expected = sample(name)
    for line in expected:
        del line["index"], line["time"]
    assert _decode(planes) == expected


def test_samples_hold_every_kind_of_plane() -> None:
    planes = [plane for name in sample_names() for plane in sample(name)[0]]
    assert len(sample_names()) == 32
    assert {plane.uniform[4] for plane in planes if plane.uniform} == {0, 1, 2, 3}
    assert any(plane.boundary_count for plane in planes)
    assert {plane.range_code for plane in planes} >= set(range(1, 8))


# The worked examples MSH-EX-1 and MSH-EX-2.
EXAMPLE_1 = "000001bc000001bdc201805141090000 01bd4611815088 28603a0c000001b1"
EXAMPLE_2 = "000001bc000001bdc4000d0160008003de43a9d772fbdc6e5f5b96000001bd48a8c420382500f0143f000001b1"


def test_worked_example_uniform() -> None:
    assert _decode(parse(bytes.fromhex(EXAMPLE_1))) == [
        {
            "intra": True,
            "nodes": [[0, 0], [20, 0], [40, 0], [0, 16], [20, 16], [40, 16]],
            "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 5, 4]],
            "order": [0, 1, 4, 3, 2, 5],
        },
        {"intra": False, "nodes": [[0, 0], [23, -2], [43, -1], [0, 16], [13, 21], [24, 25]]},
    ]


def test_worked_example_delaunay() -> None:
    assert _decode(parse(bytes.fromhex(EXAMPLE_2))) == [
        {
            "intra": True,
            "nodes": [[0, 0], [60, -6], [80, 40], [40, 70], [-10, 50], [35, 30]],
            "triangles": [[0, 1, 5], [0, 5, 4], [1, 2, 5], [3, 4, 5], [2, 3, 5]],
            "order": [0, 1, 5, 4, 2, 3],
        },
        {"intra": False, "nodes": [[2, 1], [62, -5], [80, 40], [0, 103], [-13, 42], [40, 34]]},
    ]


def test_reading_of_ties_changes_only_tied_triangles() -> None:
    """Under the other reading of AMB-MSH-2 the samples still decode, and at least one of them differs."""
    changed = 0
    for name in sample_names():
        for plane in sample(name)[0]:
            if plane.boundary_count:
                lowest = _topology(plane)
                other = _topology(plane, ties="other")
                assert len(lowest.triangles) == len(other.triangles)
                assert sorted(lowest.order) == sorted(other.order)
                changed += sorted(lowest.triangles) != sorted(other.triangles)
    assert changed


def test_reading_of_alternation_changes_only_alternating_splits() -> None:
    seen = set()
    for name in sample_names():
        for plane in sample(name)[0]:
            if plane.uniform and min(plane.uniform[:2]) > 2:
                per_reading = [
                    sorted(_topology(plane, alternation=reading).triangles)
                    for reading in ("checkerboard", "by-column", "by-row")
                ]
                alternates = plane.uniform[4] >= 2
                assert (per_reading[0] != per_reading[1]) == alternates
                assert (per_reading[0] != per_reading[2]) == alternates
                seen.add(alternates)
    assert seen == {False, True}
