"""Laws of Delaunay meshes: MSH-8..11 and the traversal MSH-18..21, against brute force."""

from __future__ import annotations

import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_shapes import Point, first_fault, geometries, in_circle, points

from snhc.reference_impl.mesh import polygon
from snhc.reference_impl.mesh.topology import HalfEdges
from snhc.reference_impl.mesh.traversal import traverse
from snhc.reference_impl.mesh.triangulation import delaunay_triangles


def _split(nodes: list[Point]) -> tuple[list[int], list[int]]:
    return [x for x, _ in nodes], [y for _, y in nodes]


def _triangles(mesh: HalfEdges) -> list[tuple[int, int, int]]:
    return [(mesh.start[i], mesh.start[i + 1], mesh.start[i + 2]) for i in range(0, len(mesh.start), 3)]


def _area(nodes: list[Point], t: tuple[int, int, int]) -> int:
    (ax, ay), (bx, by), (cx, cy) = (nodes[k] for k in t)
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@settings(max_examples=150, deadline=None)
@given(geometries())
def test_empty_circumcircles_within_the_polygon(geometry: tuple[list[Point], int]) -> None:
    """No node inside a triangle's circle is visible from all its corners; the triangles tile the polygon."""
    nodes, boundary_count = geometry
    xs, ys = _split(nodes)
    assert polygon.first_fault(xs, ys, boundary_count) is None
    mesh = delaunay_triangles(xs, ys, boundary_count)
    triangles = _triangles(mesh)
    shape = shapely.Polygon(nodes[:boundary_count])
    assert len(triangles) == 2 * len(nodes) - boundary_count - 2
    assert all(_area(nodes, t) > 0 for t in triangles)
    assert sum(_area(nodes, t) for t in triangles) == round(2 * shape.area)
    edges = {(a, b) for t in triangles for a, b in (t[:2], t[1:], (t[2], t[0]))}
    assert len(edges) == 3 * len(triangles)
    for k in range(boundary_count):
        following = (k + 1) % boundary_count
        assert ((k, following) in edges) != ((following, k) in edges)
    for t in triangles:
        corners = [nodes[k] for k in t]
        for other, node in enumerate(nodes):
            if other not in t and in_circle(*corners, node) > 0:
                assert not all(shape.covers(shapely.LineString([corner, node])) for corner in corners)


@settings(max_examples=100, deadline=None)
@given(geometries())
def test_neighbours_know_each_other(geometry: tuple[list[Point], int]) -> None:
    nodes, boundary_count = geometry
    xs, ys = _split(nodes)
    mesh = delaunay_triangles(xs, ys, boundary_count)
    outer = 0
    for e, o in enumerate(mesh.twin):
        end = mesh.start[e - e % 3 + (e + 1) % 3]
        if o < 0:
            outer += 1
            assert {mesh.start[e], end} <= set(range(boundary_count))
        else:
            assert mesh.twin[o] == e and mesh.start[o] == end
    assert outer == boundary_count


def _tied_sets(nodes: list[Point], triangles: list[tuple[int, int, int]]) -> list[set[int]]:
    """Triangles joined across edges whose four nodes are on one circle."""
    sets = [{k} for k in range(len(triangles))]
    for i, s in enumerate(triangles):
        for j in range(i):
            t = triangles[j]
            if len({*s, *t}) == 4:
                (other,) = set(t) - set(s)
                if in_circle(*(nodes[k] for k in s), nodes[other]) == 0:
                    joined = sets[i] | sets[j]
                    for k in joined:
                        sets[k] = joined
    return [group for k, group in enumerate(sets) if min(group) == k]


@settings(max_examples=150, deadline=None)
@given(geometries())
def test_ties_are_fans_from_one_node(geometry: tuple[list[Point], int]) -> None:
    """MSH-9 and the other reading of AMB-MSH-2; triangles outside tied sets do not depend on the reading."""
    nodes, boundary_count = geometry
    xs, ys = _split(nodes)
    single = []
    for reading in ("lowest", "other"):
        triangles = _triangles(delaunay_triangles(xs, ys, boundary_count, reading))
        single.append(set())
        for group in _tied_sets(nodes, triangles):
            numbers = {node for k in group for node in triangles[k]}
            hub = min(numbers) if reading == "lowest" else max(numbers)
            assert all(hub in triangles[k] for k in group)
            if len(group) == 1:
                (k,) = group
                single[-1].add(frozenset(triangles[k]))
    assert single[0] == single[1]


@settings(max_examples=80, deadline=None)
@given(geometries(), st.data())
def test_numbering_does_not_matter_without_ties(geometry: tuple[list[Point], int], data: st.DataObject) -> None:
    nodes, boundary_count = geometry
    xs, ys = _split(nodes)
    first = _triangles(delaunay_triangles(xs, ys, boundary_count))
    if any(len(group) > 1 for group in _tied_sets(nodes, first)):
        return
    start = data.draw(st.integers(0, boundary_count - 1))
    ring = nodes[start:boundary_count] + nodes[:start]
    if data.draw(st.booleans()):
        ring.reverse()
    turned = ring + data.draw(st.permutations(nodes[boundary_count:]))
    second = _triangles(delaunay_triangles(*_split(turned), boundary_count))
    assert {frozenset(nodes[k] for k in t) for t in first} == {frozenset(turned[k] for k in t) for t in second}


@settings(max_examples=400, deadline=None)
@given(st.lists(points(3), min_size=3, max_size=9), st.data())
def test_first_fault_is_the_smallest(nodes: list[Point], data: st.DataObject) -> None:
    """Against shapely on every beginning of the list; also where nodes are still missing."""
    boundary_count = data.draw(st.integers(3, len(nodes) + 2))
    fault = polygon.first_fault(*_split(nodes), boundary_count)
    assert (None if fault is None else fault.node) == first_fault(nodes, boundary_count)


@settings(max_examples=150, deadline=None)
@given(geometries(), st.data())
def test_one_wrong_node_is_found(geometry: tuple[list[Point], int], data: st.DataObject) -> None:
    """A good geometry with one node anywhere else: still good, or the smallest faulty node."""
    nodes, boundary_count = geometry
    assert polygon.first_fault(*_split(nodes), boundary_count) is None
    nodes = list(nodes)
    nodes[data.draw(st.integers(0, len(nodes) - 1))] = data.draw(points(8))
    fault = polygon.first_fault(*_split(nodes), boundary_count)
    assert (None if fault is None else fault.node) == first_fault(nodes, boundary_count)


@settings(max_examples=100, deadline=None)
@given(geometries())
def test_traversal_as_the_paper_words_it(geometry: tuple[list[Point], int]) -> None:
    """Labels, base edges and nodes by literal search over a plain list of triangles."""
    nodes, boundary_count = geometry
    xs, ys = _split(nodes)
    mesh = delaunay_triangles(xs, ys, boundary_count)
    result = traverse(xs, ys, mesh)
    triangles = _triangles(mesh)

    def turned(t: tuple[int, int, int], el: int, em: int) -> tuple[int, int, int]:
        return next(r for r in (t, t[1:] + t[:1], t[2:] + t[:2]) if {r[0], r[1]} == {el, em})

    ring = nodes[:boundary_count]
    area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:] + ring[:1], strict=True))
    top_left = min(range(len(nodes)), key=lambda k: (xs[k] + ys[k], ys[k]))
    following = (top_left + (1 if area > 0 else -1)) % boundary_count
    labelled = [next(turned(t, top_left, following) for t in triangles if {top_left, following} <= set(t))]
    unlabelled = [t for t in triangles if set(t) != set(labelled[0])]
    order = [top_left, following]
    predictors = [(-1, -1), (top_left, top_left)]
    current = 0
    while current < len(labelled):
        el, em, en = labelled[current]
        # The base edge is shared with the lowest-labelled neighbour.
        lowest = min(
            (k for k, t in enumerate(labelled) if k != current and len({*t} & {el, em, en}) == 2), default=None
        )
        if current:
            assert lowest is not None and {el, em} <= set(labelled[lowest])
        if en not in order:
            order.append(en)
            predictors.append((el, em))
        for side in ((el, en), (em, en)):
            for t in unlabelled:
                if set(side) <= set(t):
                    labelled.append(turned(t, *side))
                    unlabelled.remove(t)
                    break
        current += 1
    assert [frozenset(t) for t in result.triangles] == [frozenset(t) for t in labelled]
    assert all(t[0] == min(t) and _area(nodes, t) > 0 for t in result.triangles)
    assert result.order == order
    assert sorted(order) == list(range(len(nodes)))
    assert [set(p) for p in result.predictors] == [set(p) for p in predictors]
