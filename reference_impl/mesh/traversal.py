"""The breadth-first traversal that orders triangles and motion vectors.

Rules implemented: MSH-18, MSH-19, MSH-20, MSH-21, CNF-1 (form and order of the triangles).
Not implemented here: MSH-12..16 (`motion`).
"""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import InconsistentSemantics
from snhc.reference_impl.mesh.topology import HalfEdges, MeshTopology


def top_left_node(xs: list[int], ys: list[int]) -> int:
    """The node with the smallest x + y; among equals the one with the smallest y.

    Rules: MSH-18.

    `xs`, `ys`: positions in half pixels, at least one node. Returns the node number.
    """
    best = 0
    for node in range(1, len(xs)):
        diagonal = xs[node] + ys[node] - xs[best] - ys[best]
        if diagonal < 0 or (diagonal == 0 and ys[node] < ys[best]):
            best = node
    return best


def _initial_base_edge(mesh: HalfEdges, node: int) -> int:
    """The boundary half-edge that leaves the node; it leads to the next clockwise node, as triangles do."""
    start = mesh.start
    twin = mesh.twin
    for edge in range(len(start)):
        if twin[edge] < 0 and start[edge] == node:
            return edge
    raise InconsistentSemantics("MSH-19", "top-left node", value=node, allowed="a node of the mesh's boundary")


def traverse(xs: list[int], ys: list[int], mesh: HalfEdges) -> MeshTopology:
    """Labels the triangles breadth-first and lists the nodes in the order of their motion vectors.

    Rules: MSH-18, MSH-19, MSH-20, MSH-21, CNF-1.

    `xs`, `ys`: positions of the intra plane in half pixels. `mesh`: its triangles. Raises
    InconsistentSemantics, without bits, where a node or a triangle cannot be reached.
    """
    start = mesh.start
    twin = mesh.twin
    base = _initial_base_edge(mesh, top_left_node(xs, ys))
    count = mesh.triangle_count()
    labelled = bytearray(count)
    done = bytearray(mesh.node_count)
    labelled[base // 3] = 1
    queue = [base]
    first = start[base]
    second = start[base + 1 if base % 3 < 2 else base - 2]
    done[first] = 1
    done[second] = 1
    order = [first, second]
    predictors = [(-1, -1), (first, first)]
    triangles: list[tuple[int, int, int]] = []
    # The queue grows while it is read: every triangle enters it once, by its base edge.
    for edge in queue:
        corner = edge % 3
        if corner == 0:
            after = edge + 1
            before = edge + 2
        elif corner == 1:
            after = edge + 1
            before = edge - 1
        else:
            after = edge - 2
            before = edge - 1
        el = start[edge]
        em = start[after]
        en = start[before]
        if el < em and el < en:
            triangles.append((el, em, en))
        elif em < en:
            triangles.append((em, en, el))
        else:
            triangles.append((en, el, em))
        if not done[en]:
            done[en] = 1
            order.append(en)
            predictors.append((el, em))
        right = twin[before]  # across <l, n>
        if right >= 0 and not labelled[right // 3]:
            labelled[right // 3] = 1
            queue.append(right)
        left = twin[after]  # across <m, n>
        if left >= 0 and not labelled[left // 3]:
            labelled[left // 3] = 1
            queue.append(left)
    if len(order) != mesh.node_count:
        raise InconsistentSemantics("MSH-21", "node", value=done.index(0), allowed="nodes that the traversal reaches")
    if len(triangles) != count:
        raise InconsistentSemantics(
            "MSH-21", "triangle", value=labelled.index(0), allowed="triangles that the traversal reaches"
        )
    return MeshTopology(triangles, order, predictors)
