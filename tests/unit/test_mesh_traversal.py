"""Traversal: named cases of MSH-18..21; the laws stand in properties/test_mesh_delaunay_laws.py."""

from __future__ import annotations

import pytest

from snhc.reference_impl.bitstream.errors import InconsistentSemantics
from snhc.reference_impl.mesh.topology import HalfEdges
from snhc.reference_impl.mesh.traversal import top_left_node, traverse


def test_top_left_node() -> None:
    assert top_left_node([5, 2, 3], [0, 2, 2]) == 1
    # 5 + 0, 2 + 3, 3 + 2: the one highest up.
    assert top_left_node([2, 5, 3], [3, 0, 2]) == 1
    assert top_left_node([-3, 0], [1, -2]) == 1


def test_right_before_left() -> None:
    """One triangle in the middle of four: base edge 0-1, right <0, 2>, left <1, 2>."""
    xs, ys = [0, 8, 4, -4, 12, 4], [0, 0, 8, 6, 6, -8]
    start = [0, 1, 2, 0, 2, 3, 1, 4, 2, 0, 5, 1]
    twin = [11, 8, 3, 2, -1, -1, -1, -1, 1, -1, -1, 0]
    mesh = HalfEdges(start, twin, 6)
    topology = traverse(xs, ys, mesh)
    # Node 5 is top-left (4 - 8); the next clockwise boundary node is 1, so triangle (0, 5, 1) is labelled first.
    assert topology.triangles == [(0, 5, 1), (0, 1, 2), (0, 2, 3), (1, 4, 2)]
    assert topology.order == [5, 1, 0, 2, 3, 4]
    # The base edge of the middle triangle is 0-1, its right edge leads to 3, its left edge to 4.
    assert topology.predictors == [(-1, -1), (5, 5), (5, 1), (0, 1), (0, 2), (2, 1)]


def test_node_without_triangle() -> None:
    with pytest.raises(InconsistentSemantics) as error:
        traverse([0, 4, 0, 9], [0, 0, 4, 9], HalfEdges([0, 1, 2], [-1, -1, -1], 4))
    assert (error.value.rule, error.value.value) == ("MSH-21", 3)


def test_triangle_that_cannot_be_reached() -> None:
    mesh = HalfEdges([0, 1, 2, 1, 2, 0], [-1, -1, -1, -1, -1, -1], 3)
    with pytest.raises(InconsistentSemantics) as error:
        traverse([0, 4, 0], [0, 0, 4], mesh)
    assert (error.value.rule, error.value.what, error.value.value) == ("MSH-21", "triangle", 1)


def test_top_left_node_inside() -> None:
    with pytest.raises(InconsistentSemantics, match="MSH-19"):
        traverse([0, 4, 0], [0, 0, 4], HalfEdges([0, 1, 2], [0, 0, 0], 3))
