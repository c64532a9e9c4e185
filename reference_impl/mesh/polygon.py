"""The boundary polygon of a Delaunay mesh: orientation and the exact checks.

Rules implemented: MSH-10, MSH-11 (relations between nodes). Integers only. The boundary is checked over a
grid, the interior nodes by one sweep from top to bottom with a binary search per node. Not implemented here:
the ranges of counts and positions (MSH-11, MSH-24: syntax).
"""

from __future__ import annotations

from bisect import bisect_right
from math import isqrt
from typing import Final, final

# Packs a position of -16384..16383 into one integer; any larger offset would do.
_SPAN: Final = 1 << 17

MIN_COORDINATE: Final = -16384
MAX_COORDINATE: Final = 16383

REPEATED: Final = "repeated node"
SPIKE: Final = "spike of 0 degrees"
CROSSING: Final = "crossing boundary edges"
TOUCHING: Final = "touching boundary edges"
ZERO_AREA: Final = "zero area"
OUTSIDE: Final = "interior node outside the polygon"
ON_POLYGON: Final = "interior node on the polygon"


@final
class NodeFault:
    """The first faulty node in stream order.

    Rules: MSH-11.

    `node`: the smallest k such that nodes 0..k show the fault. `kind`: the fault in words.
    """

    __slots__ = ("kind", "node")

    def __init__(self, node: int, kind: str) -> None:
        self.node = node
        self.kind = kind


def doubled_area(xs: list[int], ys: list[int], boundary_count: int) -> int:
    """Twice the signed area of the boundary polygon, in square half pixels.

    Rules: MSH-10.

    Positive: the nodes run clockwise on screen (y down). The first `boundary_count` nodes are the polygon.
    """
    area = 0
    x, y = xs[boundary_count - 1], ys[boundary_count - 1]
    for k in range(boundary_count):
        area += x * ys[k] - y * xs[k]
        x, y = xs[k], ys[k]
    return area


def first_fault(xs: list[int], ys: list[int], boundary_count: int) -> NodeFault | None:
    """The first node that makes the geometry impossible, or None.

    Rules: MSH-11.

    `xs`, `ys`: positions in half pixels, in stream order; **those read so far will do**: with fewer nodes
    than the polygon has, only the open line is judged, so that a reader that meets another fault can ask
    whether an earlier node was the first. `boundary_count`: nr_of_boundary_nodes, at least 3.
    """
    seen = _first_repeated(xs, ys)
    fault = _boundary_fault(xs, ys, boundary_count)
    if fault is None and len(xs) > boundary_count:
        fault = _interior_fault(xs, ys, boundary_count)
    if seen >= 0 and (fault is None or seen <= fault.node):
        return NodeFault(seen, REPEATED)
    return fault


def _first_repeated(xs: list[int], ys: list[int]) -> int:
    seen: set[int] = set()
    for k in range(len(xs)):
        key = xs[k] * _SPAN + ys[k]
        if key in seen:
            return k
        seen.add(key)
    return -1


def _meeting(xs: list[int], ys: list[int], a: int, b: int, c: int, d: int) -> str:
    """How the closed segments a-b and c-d meet: a kind of fault, or nothing."""
    ax, ay, bx, by = xs[a], ys[a], xs[b], ys[b]
    cx, cy, dx, dy = xs[c], ys[c], xs[d], ys[d]
    ux = bx - ax
    uy = by - ay
    side_c = ux * (cy - ay) - uy * (cx - ax)
    side_d = ux * (dy - ay) - uy * (dx - ax)
    if (side_c > 0 and side_d > 0) or (side_c < 0 and side_d < 0):
        return ""
    vx = dx - cx
    vy = dy - cy
    side_a = vx * (ay - cy) - vy * (ax - cx)
    side_b = vx * (by - cy) - vy * (bx - cx)
    if (side_a > 0 and side_b > 0) or (side_a < 0 and side_b < 0):
        return ""
    if side_c == 0 and side_d == 0:
        # On one line: they meet where their extents do.
        if max(min(ax, bx), min(cx, dx)) > min(max(ax, bx), max(cx, dx)):
            return ""
        if max(min(ay, by), min(cy, dy)) > min(max(ay, by), max(cy, dy)):
            return ""
        return TOUCHING
    if side_a and side_b and side_c and side_d:
        return CROSSING
    return TOUCHING


def _turns_back(xs: list[int], ys: list[int], a: int, b: int, c: int) -> bool:
    """Whether the line a-b-c runs back over itself at b."""
    ux = xs[b] - xs[a]
    uy = ys[b] - ys[a]
    vx = xs[c] - xs[b]
    vy = ys[c] - ys[b]
    return ux * vy == uy * vx and ux * vx + uy * vy <= 0


def _cells(x0: int, y0: int, x1: int, y1: int, width: int, height: int, columns: int) -> list[int]:
    """Every grid cell that the segment meets, perhaps a few beside it. Positions from the grid's corner."""
    if y0 > y1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    dx = x1 - x0
    dy = y1 - y0
    first_row = y0 // height
    last_row = y1 // height
    cells: list[int] = []
    for row in range(first_row, last_row + 1):
        # The stretch of the segment within this row, rounded outwards.
        if dy == 0:
            xa, xb = x0, x1
        else:
            xa = x0 + (max(y0, row * height) - y0) * dx // dy
            xb = x0 + (min(y1, row * height + height) - y0) * dx // dy
        if xa > xb:
            xa, xb = xb, xa
        last = min((xb + 1) // width, columns - 1)
        for column in range(xa // width, last + 1):
            cells.append(row * columns + column)
    return cells


def _boundary_fault(xs: list[int], ys: list[int], boundary_count: int) -> NodeFault | None:
    count = min(len(xs), boundary_count)
    if count < 2:
        return None
    left = min(xs[:count])
    top = min(ys[:count])
    columns = isqrt(count) + 1
    width = (max(xs[:count]) - left) // columns + 1
    height = (max(ys[:count]) - top) // columns + 1
    grid: list[list[int]] = [[] for _ in range(columns * columns)]
    # tested[j]: the last edge that edge j was tested against, so that no pair is looked at twice.
    tested = [-1] * count
    edges = count if count == boundary_count else count - 1
    for edge in range(edges):
        closing = edge == count - 1
        end = 0 if closing else edge + 1
        node = edge if closing else end
        if xs[edge] == xs[end] and ys[edge] == ys[end]:
            return NodeFault(node, REPEATED)
        if edge and _turns_back(xs, ys, edge - 1, edge, end):
            return NodeFault(node, ZERO_AREA if closing and not doubled_area(xs, ys, count) else SPIKE)
        if closing and _turns_back(xs, ys, edge, 0, 1):
            return NodeFault(node, ZERO_AREA if not doubled_area(xs, ys, count) else SPIKE)
        ax = xs[edge] - left
        ay = ys[edge] - top
        bx = xs[end] - left
        by = ys[end] - top
        # The neighbours share a node with this edge: the turns above have judged them.
        tested[edge - 1] = edge
        if closing:
            tested[0] = edge
        for cell in _cells(ax, ay, bx, by, width, height, columns):
            for other in grid[cell]:
                if tested[other] != edge:
                    tested[other] = edge
                    kind = _meeting(xs, ys, edge, end, other, other + 1)
                    if kind:
                        return NodeFault(node, kind)
            grid[cell].append(edge)
    return None


def _status_position(xs: list[int], ys: list[int], low: list[int], high: list[int], status: list[int], e: int) -> int:
    """Where edge e, which begins at the sweep line, belongs among the active edges, left to right."""
    x = xs[low[e]]
    y = ys[low[e]]
    ex = xs[high[e]] - x
    ey = ys[high[e]] - y
    first = 0
    last = len(status)
    while first < last:
        middle = (first + last) >> 1
        f = status[middle]
        fx = xs[low[f]]
        fy = ys[low[f]]
        ux = xs[high[f]] - fx
        uy = ys[high[f]] - fy
        # Downward edges: positive means that the point lies to the left of the edge on screen.
        side = ux * (y - fy) - uy * (x - fx)
        if side == 0:
            side = ux * ey - uy * ex
        if side < 0:
            first = middle + 1
        else:
            last = middle
    return first


def _interior_fault(xs: list[int], ys: list[int], boundary_count: int) -> NodeFault | None:
    """Sweeps a simple polygon from top to bottom and judges every interior node.

    An edge is active from its upper end to just above its lower end; horizontal edges are kept apart.
    Nodes at a corner of the polygon are repeated nodes, which have been found before.
    """
    low: list[int] = [0] * boundary_count  # upper end on screen: the smaller y
    high: list[int] = [0] * boundary_count
    begins: dict[int, list[int]] = {}
    ends: dict[int, list[int]] = {}
    flat: dict[int, list[tuple[int, int]]] = {}
    for a in range(boundary_count):
        b = a + 1 if a + 1 < boundary_count else 0
        if ys[a] == ys[b]:
            flat.setdefault(ys[a], []).append((min(xs[a], xs[b]), max(xs[a], xs[b])))
            continue
        low[a], high[a] = (a, b) if ys[a] < ys[b] else (b, a)
        begins.setdefault(ys[low[a]], []).append(a)
        ends.setdefault(ys[high[a]], []).append(a)
    for spans in flat.values():
        spans.sort()
    # A node of the polygon shares its y with an event, so the events are the levels of the polygon's nodes
    # alone.
    levels = sorted(set(ys[:boundary_count]))
    by_level = sorted(range(boundary_count, len(xs)), key=ys.__getitem__)
    status: list[int] = []
    next_level = 0
    worst = -1
    kind = ""
    for node in by_level:
        x = xs[node]
        y = ys[node]
        while next_level < len(levels) and levels[next_level] <= y:
            level = levels[next_level]
            for e in ends.get(level, ()):
                status.remove(e)
            for e in begins.get(level, ()):
                status.insert(_status_position(xs, ys, low, high, status, e), e)
            next_level += 1
        if 0 <= worst < node:
            continue
        first = 0
        last = len(status)
        touches = False
        while first < last:
            middle = (first + last) >> 1
            f = status[middle]
            fx = xs[low[f]]
            fy = ys[low[f]]
            side = (xs[high[f]] - fx) * (y - fy) - (ys[high[f]] - fy) * (x - fx)
            if side < 0:
                first = middle + 1
            elif side == 0:
                touches = True
                break
            else:
                last = middle
        if not touches and y in flat:
            spans = flat[y]
            at = bisect_right(spans, (x, _SPAN)) - 1
            touches = at >= 0 and spans[at][1] >= x
        if touches:
            worst, kind = node, ON_POLYGON
        elif first & 1 == 0:
            worst, kind = node, OUTSIDE
    return None if worst < 0 else NodeFault(worst, kind)
