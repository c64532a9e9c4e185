"""Delaunay meshes: named cases of MSH-8 and MSH-9, and large ones against SciPy or edge by edge."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import pytest
from scipy.spatial import ConvexHull, Delaunay

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, RangeViolation
from snhc.reference_impl.mesh.polygon import doubled_area, first_fault
from snhc.reference_impl.mesh.predicates import insertion_order, opposite_angles, orientation
from snhc.reference_impl.mesh.topology import HalfEdges
from snhc.reference_impl.mesh.triangulation import delaunay_triangles

Nodes = list[tuple[int, int]]


def _mesh(nodes: Nodes, boundary_count: int, reading: str = "lowest") -> HalfEdges:
    return delaunay_triangles([x for x, _ in nodes], [y for _, y in nodes], boundary_count, reading)


def _sets(mesh: HalfEdges) -> set[frozenset[int]]:
    return {frozenset(mesh.start[i : i + 3]) for i in range(0, len(mesh.start), 3)}


def test_single_triangle_in_either_orientation() -> None:
    assert _mesh([(0, 0), (4, 0), (0, 4)], 3).start in ([0, 1, 2], [1, 2, 0], [2, 0, 1])
    assert _mesh([(0, 0), (0, 4), (4, 0)], 3).start in ([0, 2, 1], [2, 1, 0], [1, 0, 2])


def test_square_is_a_fan_from_the_lowest_or_the_highest_number() -> None:
    square = [(0, 0), (4, 0), (4, 4), (0, 4)]
    assert _sets(_mesh(square, 4)) == {frozenset({0, 1, 2}), frozenset({0, 2, 3})}
    assert _sets(_mesh(square, 4, "other")) == {frozenset({3, 0, 1}), frozenset({3, 1, 2})}


def test_octagon_on_a_circle() -> None:
    """Eight nodes of the circle with radius 5: one fan, seen from the lowest number."""
    ring = [(5, 0), (4, 3), (3, 4), (0, 5), (-3, 4), (-4, 3), (-4, -3), (3, -4)]
    assert _sets(_mesh(ring, 8)) == {frozenset({0, k, k + 1}) for k in range(1, 7)}
    assert _sets(_mesh(ring[::-1], 8, "other")) == {frozenset({7, k, k + 1}) for k in range(6)}


def test_tied_set_beside_a_straight_boundary_node() -> None:
    """Node 1 lies straight between 0 and 2: no triangle without area, two squares tied apart from each other."""
    nodes = [(0, 0), (4, 0), (8, 0), (8, 4), (4, 4), (0, 4)]
    assert _sets(_mesh(nodes, 6)) == {frozenset(t) for t in ((0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4))}


def test_ties_do_not_join_across_the_polygon() -> None:
    """A slit of the polygon parts co-circular nodes: 3 sees only one side of it."""
    nodes = [(0, 0), (10, 0), (10, 10), (5, 1), (0, 10)]
    assert _sets(_mesh(nodes, 5)) == {frozenset(t) for t in ((0, 1, 3), (1, 2, 3), (0, 3, 4))}


def test_long_edge_that_cuts_through_near_pairs() -> None:
    """Nodes 4 and 7 are close to each other, but the polygon's edges lie between them."""
    nodes = [(0, 0), (100, 0), (100, 100), (0, 100), (0, 52), (80, 51), (80, 49), (0, 48)]
    mesh = _mesh(nodes, 8)
    edges = {frozenset((mesh.start[i], mesh.start[i - i % 3 + (i + 1) % 3])) for i in range(len(mesh.start))}
    assert frozenset({4, 7}) not in edges
    assert {frozenset({4, 5}), frozenset({6, 7}), frozenset({5, 6})} <= edges
    assert mesh.triangle_count() == 6


def test_unknown_reading() -> None:
    with pytest.raises(RangeViolation, match="AMB-MSH-2"):
        _mesh([(0, 0), (4, 0), (0, 4)], 3, "middle")


@pytest.mark.parametrize(
    ("nodes", "boundary_count", "rule"),
    [
        ([(0, 0), (4, 0), (0, 4)], 2, "MSH-38"),
        ([(0, 0), (4, 0), (0, 4)], 4, "MSH-38"),
        ([(0, 0), (16384, 0), (0, 4)], 3, "MSH-24"),
        ([(0, 0), (4, 0), (0, -16385)], 3, "MSH-24"),
    ],
)
def test_ranges(nodes: Nodes, boundary_count: int, rule: str) -> None:
    with pytest.raises(RangeViolation, match=rule):
        _mesh(nodes, boundary_count)


def test_faulty_nodes_are_refused_all_the_same() -> None:
    """The check of MSH-11 comes first; without it the triangulation still says so and ends."""
    square = [(0, 0), (8, 0), (8, 8), (0, 8)]
    for nodes, boundary_count in (
        ([(0, 0), (80, 80), (80, 0), (0, 82)], 4),
        ([*square, (9, 1)], 4),
        ([*square, (4, 0)], 4),
        ([(0, 0), (4, 0), (8, 0), (4, 8), (4, -8)], 5),
    ):
        with pytest.raises(InconsistentSemantics, match="MSH-11"):
            _mesh(nodes, boundary_count)
    with pytest.raises(InconsistentSemantics) as error:
        _mesh([*square, (4, 4), (2, 2), (4, 4)], 4)
    assert (error.value.what, error.value.rule) == ("node", "MSH-11") and error.value.value in (4, 6)


def test_predicates() -> None:
    xs, ys = [0, 8, 4, 4, 4, 4], [0, 0, 4, -4, -3, -5]
    assert orientation(xs, ys, 0, 1, 2) == 32
    assert [opposite_angles(xs, ys, 0, 1, 2, d) for d in (3,)] == [0]
    assert opposite_angles(xs, ys, 0, 1, 2, 4) < 0 < opposite_angles(xs, ys, 0, 1, 2, 5)
    # A node between a and b: the circle is the other half-plane.
    assert opposite_angles([0, 8, 4, 4], [0, 0, 0, -4000], 0, 1, 2, 3) < 0


def test_insertion_order_is_a_permutation_with_short_steps() -> None:
    """Along the last round of a 64 x 64 grid the mean step is near 1: the curve leaves out no neighbour."""
    xs = [k % 64 for k in range(4096)]
    ys = [k // 64 for k in range(4096)]
    order = insertion_order(xs, ys)
    assert sorted(order) == list(range(4096))
    steps = [abs(xs[a] - xs[b]) + abs(ys[a] - ys[b]) for a, b in pairwise(order)]
    assert sum(steps) / len(steps) < 2.5


@pytest.mark.parametrize("seed", range(5))
def test_agrees_with_scipy_on_convex_input_without_ties(seed: int) -> None:
    source = random.Random(seed)
    cloud = list({(source.randint(-900, 900), source.randint(-900, 900)) for _ in range(300)})
    hull = [int(k) for k in ConvexHull(cloud).vertices]
    if seed % 2:
        hull.reverse()
    nodes = [cloud[k] for k in hull] + [p for k, p in enumerate(cloud) if k not in hull]
    assert first_fault([x for x, _ in nodes], [y for _, y in nodes], len(hull)) is None
    lowest, other = _sets(_mesh(nodes, len(hull))), _sets(_mesh(nodes, len(hull), "other"))
    expected = {frozenset(map(int, t)) for t in Delaunay(nodes).simplices}
    # Where the two readings agree there is no tie.
    assert lowest & other <= expected
    assert len(lowest & other) > 0.95 * len(lowest)
    assert len(lowest) == len(expected)


def _check_edge_by_edge(nodes: Nodes, boundary_count: int) -> None:
    xs = [x for x, _ in nodes]
    ys = [y for _, y in nodes]
    assert first_fault(xs, ys, boundary_count) is None
    mesh = delaunay_triangles(xs, ys, boundary_count)
    start, twin = mesh.start, mesh.twin
    assert mesh.triangle_count() == 2 * len(nodes) - 2 - boundary_count
    area = 0
    for t in range(0, len(start), 3):
        part = orientation(xs, ys, start[t], start[t + 1], start[t + 2])
        assert part > 0
        area += part
    assert area == abs(doubled_area(xs, ys, boundary_count))
    for e, o in enumerate(twin):
        a, b = start[e], start[e - e % 3 + (e + 1) % 3]
        if o < 0:
            assert max(a, b) < boundary_count and (a - b) % boundary_count in (1, boundary_count - 1)
        else:
            p, d = start[e - e % 3 + (e + 2) % 3], start[o - o % 3 + (o + 2) % 3]
            assert opposite_angles(xs, ys, a, b, p, d) >= 0


def test_comb_with_crowded_teeth() -> None:
    """200 long teeth, nodes along one side of each: the polygon's edges cut through many shorter links."""
    nodes = [(-16000, -16000), (16000, -16000)]
    nodes += [(16000 - 80 * i, 16000 if i % 2 == 0 else -15900) for i in range(401)]
    boundary_count = len(nodes)
    inner = [(15999 - 160 * i, y) for i in range(200) for y in range(10000, 15000, 500)]
    source = random.Random(7)
    source.shuffle(inner)
    _check_edge_by_edge(nodes + inner, boundary_count)


@pytest.mark.parametrize("seed", range(8))
def test_ragged_star(seed: int) -> None:
    """A star of 90 uneven rays: its edges are far from those that its nodes alone would have."""
    source = random.Random(seed)
    nodes = []
    for k in range(90):
        radius = source.choice((400, 80, 200)) * source.uniform(0.7, 1)
        angle = math.radians(4 * k)
        nodes.append((round(radius * math.cos(angle)), round(radius * math.sin(angle))))
    if seed % 2:
        nodes.reverse()
    for _ in range(60):
        node = (source.randint(-300, 300), source.randint(-300, 300))
        if first_fault([x for x, _ in [*nodes, node]], [y for _, y in [*nodes, node]], 90) is None:
            nodes.append(node)
    assert len(nodes) > 95
    _check_edge_by_edge(nodes, 90)


def test_dense_rows_along_a_slot() -> None:
    """One edge cuts off thousands of nodes from the teeth on its other side."""
    nodes = [(-2000, -50), (2000, -50), (2000, 60), (-2000, 60), (-2000, 55)]
    nodes += [(-1970 + 40 * i, 50 - i % 2) for i in range(96)]
    nodes += [(1999, 40), (1999, 0), (-2000, 0)]
    boundary_count = len(nodes)
    nodes += [(x, y) for y in (-1, -2) for x in range(-1999, 2000)]
    _check_edge_by_edge(nodes, boundary_count)


def test_polygon_of_the_coarsest_and_finest_nodes() -> None:
    """The whole range of MSH-24 and a knot of neighbouring half pixels in its middle."""
    corners = [(-16384, -16384), (16383, -16384), (16383, 16383), (-16384, 16383)]
    _check_edge_by_edge(corners + [(x, y) for x in range(20) for y in range(20)], 4)
