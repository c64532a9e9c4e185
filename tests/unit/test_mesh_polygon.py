"""The faults of MSH-11 one by one, at the node that shows them, and orientation (MSH-10)."""

from __future__ import annotations

import pytest

from snhc.reference_impl.mesh.polygon import (
    CROSSING,
    ON_POLYGON,
    OUTSIDE,
    REPEATED,
    SPIKE,
    TOUCHING,
    ZERO_AREA,
    doubled_area,
    first_fault,
)

Nodes = list[tuple[int, int]]
SQUARE: Nodes = [(0, 0), (8, 0), (8, 8), (0, 8)]


def _fault(nodes: Nodes, boundary_count: int) -> tuple[int, str] | None:
    fault = first_fault([x for x, _ in nodes], [y for _, y in nodes], boundary_count)
    return None if fault is None else (fault.node, fault.kind)


@pytest.mark.parametrize(
    ("nodes", "boundary_count", "expected"),
    [
        (SQUARE, 4, None),
        (SQUARE[::-1], 4, None),
        ([*SQUARE, (1, 1), (7, 7)], 4, None),
        # Straight boundary nodes are legal, at the first and the last node too.
        ([(4, 0), (8, 0), (8, 4), (8, 8), (0, 8), (0, 0)], 6, None),
        ([(0, 0), (8, 0), (8, 8), (8, 0), (0, 8)], 5, (3, REPEATED)),
        ([(0, 0), (0, 0), (8, 8)], 3, (1, REPEATED)),
        ([(0, 0), (8, 0), (0, 0)], 3, (2, REPEATED)),
        ([*SQUARE, (1, 1), (2, 2), (1, 1)], 4, (6, REPEATED)),
        ([*SQUARE, (8, 0)], 4, (4, REPEATED)),
        ([(0, 0), (8, 0), (4, 0), (4, 4)], 4, (2, SPIKE)),
        # The spike at node 0 and the one at the last node show with the closing edge.
        ([(8, 0), (0, 0), (0, 8), (-4, 4), (-4, 0)], 5, (4, SPIKE)),
        ([(0, 0), (8, 8), (8, 4), (8, 0), (12, 0)], 5, (4, SPIKE)),
        ([(0, 0), (8, 8), (8, 0), (0, 8), (-8, 8)], 5, (3, CROSSING)),
        ([(0, 0), (8, 0), (8, 8), (4, 8), (4, -4)], 5, (4, CROSSING)),
        ([(0, 0), (8, 0), (8, 8), (4, 4), (12, 4)], 5, (4, CROSSING)),
        # Only the closing edge crosses.
        ([(0, 0), (4, -4), (4, 4), (8, 4)], 4, (3, CROSSING)),
        # A node on an edge; an edge through a node; edges that lie on each other.
        ([(0, 0), (8, 0), (8, 8), (4, 0), (0, 8)], 5, (3, TOUCHING)),
        ([(0, 0), (8, 0), (4, 4), (8, 8), (0, 8), (4, 6), (4, 2), (2, 2)], 8, (6, TOUCHING)),
        ([(0, 0), (8, 0), (8, 4), (6, 0), (2, 0), (0, 4)], 6, (3, TOUCHING)),
        # On the closing edge lies node 2.
        ([(0, 0), (8, 0), (4, 4), (8, 9), (8, 8)], 5, (4, TOUCHING)),
        ([(0, 0), (4, 0), (8, 0)], 3, (2, ZERO_AREA)),
        ([(4, 4), (0, 0), (8, 8)], 3, (2, SPIKE)),
        ([*SQUARE, (9, 1)], 4, (4, OUTSIDE)),
        ([*SQUARE, (1, -1)], 4, (4, OUTSIDE)),
        ([*SQUARE, (1, 9)], 4, (4, OUTSIDE)),
        ([*SQUARE, (4, 0)], 4, (4, ON_POLYGON)),
        ([*SQUARE, (4, 8)], 4, (4, ON_POLYGON)),
        ([*SQUARE, (8, 4)], 4, (4, ON_POLYGON)),
        ([*SQUARE, (1, 1), (9, 9), (1, 1), (4, 0)], 4, (5, OUTSIDE)),
        # Level with a node: the notch's tip lies at the height of the interior node.
        ([(0, 0), (8, 0), (4, 4), (8, 8), (0, 8), (1, 4)], 5, None),
        ([(0, 0), (8, 0), (4, 4), (8, 8), (0, 8), (6, 4)], 5, (5, OUTSIDE)),
        # Open lines, as far as they have been read.
        ([(0, 0)], 3, None),
        ([(0, 0), (4, 0), (8, 0)], 4, None),
        ([(0, 0), (8, 8), (8, 0), (0, 8)], 9, (3, CROSSING)),
    ],
)
def test_faults(nodes: Nodes, boundary_count: int, expected: tuple[int, str] | None) -> None:
    assert _fault(nodes, boundary_count) == expected
    # Nothing depends on where the polygon lies, up to the corners of MSH-24.
    for dx, dy in ((-16384 + 8, -16384 + 8), (16383 - 12, 16383 - 9)):
        assert _fault([(x + dx, y + dy) for x, y in nodes], boundary_count) == expected


def test_orientation() -> None:
    xs, ys = [0, 8, 8, 0, 3], [0, 0, 8, 8, 3]
    assert doubled_area(xs, ys, 4) == 128
    assert doubled_area(xs[3::-1], ys[3::-1], 4) == -128


def test_longest_polygon() -> None:
    """1,023 boundary nodes, a comb of long teeth: the fault is the last node's."""
    nodes = [(-16383, -16384), (16383, -16384)]
    nodes += [(16383 - 32 * i, 16383 if i % 2 == 0 else -16380) for i in range(1021)]
    assert _fault(nodes, 1023) is None
    assert _fault([*nodes[:-1], (16000, 16000)], 1023) == (1022, CROSSING)
