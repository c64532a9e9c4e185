"""Making the polygon's edges part of a Delaunay triangulation, on half-edges.

Rules implemented: MSH-8 (every polygon edge is a mesh edge). Integers only.
Not implemented here: which triangles are kept, ties (`triangulation`).

An edge that is missing replaces the triangles it crosses: the nodes on each of its sides see it, so one pass along them
gives triangles (a stack of ears), and Lawson's flips make those Delaunay again.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics
from snhc.reference_impl.mesh.predicates import opposite_angles, orientation

# Half-edges 0..2 belong to no triangle: the outer sides have them as neighbour, which spares every flip a question.
OUTSIDE: Final = 3
# Directed edges as one integer: larger than any node number, helping nodes included.
EDGE_KEY: Final = 1 << 20


def next_edge(e: int) -> int:
    """The next half-edge of the triangle. Rules: MSH-8."""
    return e + 1 if e % 3 < 2 else e - 2


def previous_edge(e: int) -> int:
    """The half-edge before this one in the triangle. Rules: MSH-8."""
    return e - 1 if e % 3 else e + 2


def is_polygon_edge(u: int, v: int, boundary_count: int) -> bool:
    """Whether two nodes follow each other on the boundary polygon, in either direction. Rules: MSH-8."""
    if u >= boundary_count or v >= boundary_count:
        return False
    step = u - v
    return step == 1 or step == -1 or step == boundary_count - 1 or step == 1 - boundary_count


def fill_region(
    triangles: list[tuple[int, int, int]],
    slots: list[int],
    around: dict[int, int],
    start: list[int],
    twin: list[int],
) -> None:
    """Puts new triangles into the slots of old ones that covered the same region.

    Rules: MSH-8, MSH-9.

    `slots`: first half-edges. `around`: directed edge (as a key) of the region's rim -> the half-edge beyond
    it, not asked for edges that have the region on both sides.
    """
    made: dict[int, int] = {}
    for i in range(len(triangles)):
        a, b, c = triangles[i]
        slot = slots[i]
        start[slot] = a
        start[slot + 1] = b
        start[slot + 2] = c
        made[a * EDGE_KEY + b] = slot
        made[b * EDGE_KEY + c] = slot + 1
        made[c * EDGE_KEY + a] = slot + 2
    for key, e in made.items():
        beyond = made.get(key % EDGE_KEY * EDGE_KEY + key // EDGE_KEY, -2)
        if beyond == -2:
            beyond = around[key]
            if beyond >= 0:
                twin[beyond] = e
        twin[e] = beyond


def enforce_polygon(xs: list[int], ys: list[int], boundary_count: int, start: list[int], twin: list[int]) -> None:
    """Makes every polygon edge an edge of the triangulation, which stays constrained Delaunay.

    Rules: MSH-8.

    `xs`, `ys`: positions in half pixels, helping nodes last. `boundary_count`: the polygon's nodes. `start`, `twin`:
    half-edges from `OUTSIDE` on, changed in place. Raises InconsistentSemantics where polygon edges cross or touch.
    """
    leaving = [0] * len(xs)
    for e in range(OUTSIDE, len(start)):
        leaving[start[e]] = e
    for a in range(boundary_count):
        b = a + 1 if a + 1 < boundary_count else 0
        first = e = leaving[a]
        while True:
            x = start[next_edge(e)]
            if x == b:
                break
            back = previous_edge(e)
            if orientation(xs, ys, a, x, b) > 0 and orientation(xs, ys, a, b, start[back]) > 0:
                _cut(xs, ys, a, b, e, boundary_count, start, twin, leaving)
                break
            e = twin[back]
            if e == first:
                raise InconsistentSemantics("MSH-11", "boundary edge from node", value=a, allowed="a simple polygon")


def _ears(xs: list[int], ys: list[int], chain: list[int], side: int) -> list[tuple[int, int, int]]:
    """Triangles between a chain and the segment between its ends, from which all of it is seen.

    `side` 1: the chain lies on the segment's right on screen, so its triangles run backwards along it; -1:
    left.
    """
    ears: list[tuple[int, int, int]] = []
    stack = [chain[0]]
    for i in range(1, len(chain)):
        w = chain[i]
        while len(stack) > 1 and side * orientation(xs, ys, w, stack[-1], stack[-2]) > 0:
            middle = stack.pop()
            ears.append((w, middle, stack[-1]) if side > 0 else (stack[-1], middle, w))
        stack.append(w)
    return ears


def _cut(
    xs: list[int],
    ys: list[int],
    a: int,
    b: int,
    e: int,
    boundary_count: int,
    start: list[int],
    twin: list[int],
    leaving: list[int],
) -> None:
    """Makes a-b an edge: replaces the triangles that it crosses; half-edge e leaves a in the first one."""
    back = previous_edge(e)
    right = [a, start[back]]  # nodes with positive orientation to a-b, on the right on screen
    left = [a, start[next_edge(e)]]
    rim = [back, e]
    slots = [e - e % 3]
    crossed = next_edge(e)
    while True:
        o = twin[crossed]
        o1 = next_edge(o)
        o2 = previous_edge(o)
        w = start[o2]
        slots.append(o - o % 3)
        side = orientation(xs, ys, a, b, w)
        if (side == 0 and w != b) or is_polygon_edge(start[o], start[o1], boundary_count):
            raise InconsistentSemantics("MSH-11", "boundary edge from node", value=a, allowed="a simple polygon")
        if w == b:
            rim += (o1, o2)
            break
        if side > 0:
            right.append(w)
            rim.append(o2)
            crossed = o1
        else:
            left.append(w)
            rim.append(o1)
            crossed = o2
    right.append(b)
    left.append(b)
    around: dict[int, int] = {}
    for edge in rim:
        around[start[edge] * EDGE_KEY + start[next_edge(edge)]] = twin[edge]
    fill_region(_ears(xs, ys, right, 1) + _ears(xs, ys, left, -1), slots, around, start, twin)
    stack: list[int] = []
    for slot in slots:
        for edge in (slot, slot + 1, slot + 2):
            leaving[start[edge]] = edge
            stack.append(edge)
    _flip_until_delaunay(xs, ys, stack, boundary_count, start, twin, leaving)


def _flip_until_delaunay(
    xs: list[int],
    ys: list[int],
    stack: list[int],
    boundary_count: int,
    start: list[int],
    twin: list[int],
    leaving: list[int],
) -> None:
    while stack:
        e = stack.pop()
        o = twin[e]
        if o < OUTSIDE:
            continue
        e1 = next_edge(e)
        e2 = previous_edge(e)
        o1 = next_edge(o)
        o2 = previous_edge(o)
        a = start[e]
        b = start[o]
        p = start[e2]
        d = start[o2]
        if is_polygon_edge(a, b, boundary_count) or opposite_angles(xs, ys, a, b, p, d) >= 0:
            continue
        t1 = twin[o1]
        t2 = twin[o2]
        t3 = twin[e1]
        start[e1] = d
        start[o] = p
        start[o1] = d
        start[o2] = b
        twin[e] = t1
        twin[t1] = e
        twin[o1] = t2
        twin[t2] = o1
        twin[o2] = t3
        twin[t3] = o2
        twin[e1] = o
        twin[o] = e1
        leaving[a] = e
        leaving[d] = o1
        leaving[p] = e2
        leaving[b] = o2
        stack += (e, e2, o1, o2)
