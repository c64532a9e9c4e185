"""What a mesh is made of: half-edges and the traversal's result.

Rules: CNF-1 (the form of the triangles), MSH-21 (the node order). Nothing is computed here.
"""

from __future__ import annotations

from typing import Final, final

NO_TWIN: Final = -1


@final
class HalfEdges:
    """The triangles of a mesh with their neighbours.

    Rules: CNF-1, MSH-8.

    `start`: three node numbers per triangle, clockwise on screen (y down); half-edge 3 t + i runs from
    `start[3 t + i]` to the next node of triangle t. `twin`: the half-edge of the neighbour that runs the
    other way, `NO_TWIN` on the boundary of the mesh. `node_count`: number of nodes, those without a triangle
    included.
    """

    __slots__ = ("node_count", "start", "twin")

    def __init__(self, start: list[int], twin: list[int], node_count: int) -> None:
        self.start = start
        self.twin = twin
        self.node_count = node_count

    def triangle_count(self) -> int:
        """The number of triangles. Rules: CNF-1."""
        return len(self.start) // 3


@final
class MeshTopology:
    """What motion decoding needs to know of an intra plane, kept until the next one.

    Rules: MSH-15, MSH-16, MSH-19, MSH-20, MSH-21, CNF-1.

    `triangles`: node triples in traversal order, clockwise on screen, lowest number first. `order`: node
    numbers in the order of their motion vectors. `predictors`: for each entry of `order` the two nodes whose
    vectors predict it: (-1, -1) for the first, (n0, n0) for the second.
    """

    __slots__ = ("order", "predictors", "triangles")

    def __init__(
        self, triangles: list[tuple[int, int, int]], order: list[int], predictors: list[tuple[int, int]]
    ) -> None:
        self.triangles = triangles
        self.order = order
        self.predictors = predictors
