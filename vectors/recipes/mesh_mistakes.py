"""Mesh streams for mistakes that the other vectors let pass: found by the kill matrix, one each.

Rules: CNF-8, as `mistakes`.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import ForbiddenValue, InconsistentSemantics, RangeViolation

from ..manifest import CONCEAL, REJECT
from ..mesh_builders import Point, all_moved, delaunay, mesh_stream, moved, node_lines, uniform, without_ties
from ..recipe import Accept, Reject, family, vector
from .mesh_errors import node_spans

TOOLS: Final = ("mesh",)


@vector(
    id="mesh.uniform.again.other-cells",
    title="The same uniform mesh with other cells",
    tier="semantic",
    rules=["MSH-6", "MSH-16"],
    features=["mesh-uniform", "mesh-motion"],
    tools=TOOLS,
)
def again_other_cells() -> Accept:
    """Motion, then the same numbers of nodes with larger cells: the positions are those of the new geometry."""
    first, second = uniform(3, 2, 10, 10, 1), uniform(3, 2, 20, 7, 1)
    return Accept(
        mesh_stream(first, all_moved(first, 1, 9), second),
        text=node_lines([[], [], [(0, 0), (20, 0), (40, 0), (0, 7), (20, 7), (40, 7)]]),
    )


@vector(
    id="mesh.uniform.again.other-split",
    title="The same uniform mesh with another split",
    tier="semantic",
    rules=["MSH-7", "MSH-16", "MSH-21"],
    features=["mesh-uniform", "mesh-motion"],
    tools=TOOLS,
)
def again_other_split() -> Accept:
    """Only triangle_split_code changes between two geometries: the order of the vectors does too."""
    first, second = uniform(4, 3, 10, 10, 0), uniform(4, 3, 10, 10, 1)
    return Accept(mesh_stream(first, all_moved(first, 2, 9), second, all_moved(second, 3, 9)), lines=4)


@vector(
    id="mesh.uniform.again.behind-delaunay",
    title="The same uniform mesh before and behind a Delaunay mesh",
    tier="semantic",
    rules=["MSH-7", "MSH-16", "MSH-21"],
    features=["mesh-uniform", "mesh-delaunay", "mesh-motion"],
    tools=TOOLS,
)
def again_behind_delaunay() -> Accept:
    """Nothing of the Delaunay mesh between them is left, and nothing of the first mesh may be taken for the third."""
    first = uniform(3, 3, 10, 10, 1)
    between = without_ties([(0, 0), (60, -6), (80, 40), (40, 70), (-10, 50), (35, 30)], 5)
    return Accept(
        mesh_stream(first, all_moved(first, 4, 9), between, all_moved(between, 5, 9), first, all_moved(first, 6, 9)),
        lines=6,
    )


@vector(
    id="mesh.delaunay.top-left-tie",
    title="Two nodes with the smallest x + y",
    tier="semantic",
    rules=["MSH-18", "MSH-19", "MSH-21"],
    features=["mesh-delaunay", "mesh-motion"],
    tools=TOOLS,
)
def top_left_tie() -> Accept:
    """Node 0 at (0 10) and node 1 at (10 0) lie on one diagonal: node 1 has the smaller y, and begins the traversal."""
    first = without_ties([(0, 10), (10, 0), (43, 12), (28, 41)])
    return Accept(mesh_stream(first, all_moved(first, 7, 9)), lines=2, text={0: '"order":[1,'})


@vector(
    id="mesh.delaunay.again-behind-motion",
    title="A second Delaunay mesh of as many nodes, behind motion",
    tier="semantic",
    rules=["MSH-2", "MSH-16"],
    features=["mesh-delaunay", "mesh-motion"],
    tools=TOOLS,
)
def again_behind_motion() -> Accept:
    """Positions are those of the new geometry: no vector of the planes before is added to them."""
    first = without_ties([(0, 0), (40, 3), (37, 45), (-5, 38)])
    second = without_ties([(5, 1), (50, 9), (40, 60), (-9, 44)])
    return Accept(
        mesh_stream(first, all_moved(first, 8, 9), second),
        text=node_lines([[], [], [(5, 1), (50, 9), (40, 60), (-9, 44)]]),
    )


@vector(
    id="mesh.motion.zero-flag-behind-a-vector",
    title="A node moves, then has the zero flag",
    tier="semantic",
    rules=["MSH-14", "MSH-15", "MSH-16"],
    features=["mesh-motion"],
    tools=TOOLS,
)
def zero_behind_vector() -> Accept:
    """In the second motion plane nodes 0 and 1 have the zero flag: they stand still, and predict with (0 0)."""
    first = uniform(2, 2, 20, 20)
    return Accept(
        mesh_stream(first, moved(first, {0: (4, 6), 1: (8, 2), 2: (5, 5), 3: (1, 1)}), moved(first, {2: (3, 3)})),
        text=node_lines([[], [], [(4, 6), (28, 2), (8, 28), (21, 21)]]),
    )


@family(
    {"lowest": -16384, "highest": 16383},
    id="mesh.delaunay.node-range.{case}",
    title="A node at the {case} position",
    tier="stress",
    rules=["MSH-24"],
    features=["mesh-delaunay"],
    value_classes=["min", "max"],
    tools=TOOLS,
)
def node_range(end: int) -> Accept:
    """Nodes reach the {case} position that is allowed, in x and in y."""
    step = 2047 if end > 0 else -2047
    nodes: list[Point] = [(4095, 4000) if end > 0 else (-4096, -4000)]
    while abs(nodes[-1][0] + step) < abs(end):
        nodes.append((nodes[-1][0] + step, nodes[-1][1] + step))
    nodes.append((end, end))
    # Back beside the diagonal.
    aside = 500 if end > 0 else -500
    nodes += [(x, y - aside) for x, y in nodes[-2:0:-1]]
    return Accept(mesh_stream(without_ties(nodes)), lines=1)


@vector(
    id="mesh.error.node-range.below",
    title="A node beyond -16384 half pixels",
    tier="error",
    rules=["MSH-24"],
    features=["mesh-delaunay"],
    value_classes=["below-min"],
    tools=TOOLS,
)
def node_range_below() -> Reject:
    """Steps of nearly 1024 pixels lead to y = -16385."""
    nodes: list[Point] = [(0, -4096)]
    while len(nodes) < 7:
        nodes.append((0, nodes[-1][1] - 2047))
    nodes += [(9, -16385), *((700, y) for y in range(-15000, -4095, 2000))]
    plane = delaunay(nodes)
    return Reject(mesh_stream(plane), RangeViolation, "MSH-24", bits=node_spans(plane)[7])


@family(
    {"upper": (20, 0), "lower": (20, 30)},
    id="mesh.error.polygon.node-on-a-flat-edge.{case}",
    title="An interior node on the horizontal {case} edge of the polygon",
    tier="error",
    rules=["MSH-11"],
    features=["mesh-delaunay"],
    tools=TOOLS,
)
def node_on_a_flat_edge(node: Point) -> Reject:
    """Node 4 lies on the {case} edge, between two corners of the same y."""
    plane = delaunay([(0, 0), (40, 0), (45, 30), (-5, 30), node], 4)
    return Reject(mesh_stream(plane), InconsistentSemantics, "MSH-11", bits=node_spans(plane)[4])


@vector(
    id="mesh.error.no-start-code.another-object-code",
    title="Another start code directly behind the object start code",
    tier="error",
    rules=["MSH-25"],
    features=["start-codes"],
    tools=TOOLS,
)
def another_object_code() -> Reject:
    """000001BC is followed by 000001B1 without stuffing: an object without planes ends with 7F."""
    return Reject(bytes.fromhex("000001bc000001b1"), ForbiddenValue, "MSH-25", bits=(32, 64), allowed=(REJECT, CONCEAL))
