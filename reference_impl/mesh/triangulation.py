"""Constrained Delaunay triangulation of a Delaunay mesh, restricted to its polygon.

Rules implemented: MSH-8, MSH-9 (with the readings of AMB-MSH-2), MSH-10. Integers only.
Not implemented here: MSH-11 (`polygon.first_fault` comes first: what it accepts can be triangulated).

The steps: all nodes are inserted into a box that holds them (Lawson's flips), the polygon's edges are
enforced, what lies outside is dropped, co-circular sets are made canonical. The corners of the box never
matter: behind the polygon's edges they are visible from no triangle inside.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, RangeViolation
from snhc.reference_impl.mesh.constraints import (
    EDGE_KEY,
    OUTSIDE,
    enforce_polygon,
    fill_region,
    is_polygon_edge,
    next_edge,
    previous_edge,
)
from snhc.reference_impl.mesh.polygon import MAX_COORDINATE, MIN_COORDINATE, doubled_area
from snhc.reference_impl.mesh.predicates import insertion_order, opposite_angles
from snhc.reference_impl.mesh.topology import NO_TWIN, HalfEdges

TIE_READINGS: Final = ("lowest", "other")


def delaunay_triangles(xs: list[int], ys: list[int], boundary_count: int, reading: str = "lowest") -> HalfEdges:
    """The triangles of a Delaunay mesh, canonical where nodes lie on one circle.

    Rules: MSH-8, MSH-9, MSH-10, AMB-MSH-2.

    `xs`, `ys`: positions in half pixels, -16384..16383, free of the faults of MSH-11. `boundary_count`: the
    first so many nodes are the polygon, in either orientation. `reading`: the fan of co-circular nodes starts
    at the `lowest` number, or (`other`) at the highest. Raises RangeViolation for counts, positions and readings
    out of range and InconsistentSemantics for nodes that `polygon.first_fault` would not have let pass.
    """
    if reading not in TIE_READINGS:
        raise RangeViolation("AMB-MSH-2", "reading", value=reading, allowed=", ".join(TIE_READINGS))
    count = len(xs)
    if not 3 <= boundary_count <= count:
        raise RangeViolation("MSH-38", "nr_of_boundary_nodes", value=boundary_count, allowed=f"3..{count}")
    for values in (xs, ys):
        for value in (min(values), max(values)):
            if not MIN_COORDINATE <= value <= MAX_COORDINATE:
                raise RangeViolation("MSH-24", "position", value=value, allowed=f"{MIN_COORDINATE}..{MAX_COORDINATE}")
    box_xs, box_ys, start, twin = _box(xs, ys)
    _insert(box_xs, box_ys, insertion_order(xs, ys), start, twin)
    enforce_polygon(box_xs, box_ys, boundary_count, start, twin)
    clockwise = doubled_area(xs, ys, boundary_count) > 0
    mesh = _inside(start, twin, boundary_count, count, clockwise)
    if mesh.triangle_count() != 2 * count - 2 - boundary_count:
        raise InconsistentSemantics(
            "MSH-11", "triangles", value=mesh.triangle_count(), allowed="nodes inside a simple polygon"
        )
    _join_ties(xs, ys, mesh, reading == "lowest")
    return mesh


def _box(xs: list[int], ys: list[int]) -> tuple[list[int], list[int], list[int], list[int]]:
    """Two triangles around all nodes, with room to spare."""
    left, right = min(xs), max(xs)
    top, bottom = min(ys), max(ys)
    margin = (right - left) + (bottom - top) + 8
    left -= margin
    right += margin
    top -= margin
    bottom += margin
    a = len(xs)
    b, c, d = a + 1, a + 2, a + 3
    start = [0, 0, 0, a, b, c, a, c, d]
    twin = [0, 0, 0, 0, 0, 6, 5, 0, 0]
    return [*xs, left, right, right, left], [*ys, top, top, bottom, bottom], start, twin


def _insert(xs: list[int], ys: list[int], order: list[int], start: list[int], twin: list[int]) -> None:
    """Inserts the nodes one by one, walking from the last one, and flips until every triangle is Delaunay.

    The two functions of `predicates` are written out here: this loop is where the time goes.
    """
    h = OUTSIDE
    for p in order:
        px = xs[p]
        py = ys[p]
        a = start[h]
        n1 = h + 1 if h % 3 < 2 else h - 2
        b = start[n1]
        if (xs[b] - xs[a]) * (py - ys[a]) < (ys[b] - ys[a]) * (px - xs[a]):
            h = twin[h]
        while True:
            corner = h % 3
            if corner == 0:
                n1 = h + 1
                n2 = h + 2
            elif corner == 1:
                n1 = h + 1
                n2 = h - 1
            else:
                n1 = h - 2
                n2 = h - 1
            b = start[n1]
            c = start[n2]
            cx = xs[c] - px
            cy = ys[c] - py
            if (xs[b] - px) * cy < (ys[b] - py) * cx:
                h = twin[n1]
                continue
            a = start[h]
            if cx * (ys[a] - py) < cy * (xs[a] - px):
                h = twin[n2]
                continue
            break
        if (px == xs[a] and py == ys[a]) or (px == xs[b] and py == ys[b]) or (px == xs[c] and py == ys[c]):
            raise InconsistentSemantics("MSH-11", "node", value=p, allowed="nodes at different positions")
        # A node on an edge makes one triangle without area; the first flip takes it away.
        u = len(start)
        v = u + 3
        t1 = twin[n1]
        t2 = twin[n2]
        start[n2] = p
        start += (b, c, p, c, a, p)
        twin[n1] = u + 2
        twin[n2] = v + 1
        twin += (t1, v + 2, n1, t2, n2, u + 1)
        twin[t1] = u
        twin[t2] = v
        stack = [h, u, v]
        while stack:
            e = stack.pop()
            o = twin[e]
            if o < OUTSIDE:
                continue
            e1 = e + 1 if e % 3 < 2 else e - 2
            corner = o % 3
            if corner == 0:
                o1 = o + 1
                o2 = o + 2
            elif corner == 1:
                o1 = o + 1
                o2 = o - 1
            else:
                o1 = o - 2
                o2 = o - 1
            b = start[e1]
            a = start[o1]
            d = start[o2]
            ax = xs[a]
            ay = ys[a]
            bx = xs[b]
            by = ys[b]
            dx = xs[d]
            dy = ys[d]
            cos_p = (ax - px) * (bx - px) + (ay - py) * (by - py)
            cos_d = (ax - dx) * (bx - dx) + (ay - dy) * (by - dy)
            if cos_p >= 0:
                if cos_d >= 0:
                    continue
                sin_p = (ax - px) * (by - py) - (ay - py) * (bx - px)
                sin_d = (bx - dx) * (ay - dy) - (by - dy) * (ax - dx)
                if sin_p * cos_d + cos_p * sin_d >= 0:
                    continue
            elif cos_d >= 0:
                sin_p = (ax - px) * (by - py) - (ay - py) * (bx - px)
                sin_d = (bx - dx) * (ay - dy) - (by - dy) * (ax - dx)
                if sin_p * cos_d + cos_p * sin_d >= 0:
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
            stack.append(e)
            stack.append(o1)


def _inside(start: list[int], twin: list[int], boundary_count: int, count: int, clockwise: bool) -> HalfEdges:
    """The triangles inside the polygon, found by spreading from one of its edges; node numbers are kept."""
    a, b = (0, 1) if clockwise else (1, 0)
    seed = -1
    for e in range(OUTSIDE, len(start)):
        if start[e] == a and start[next_edge(e)] == b:
            seed = e
            break
    found = [seed - seed % 3]
    # new_slot[t]: where triangle t goes, -1 while it has not been reached.
    new_slot = [-1] * (len(start) // 3)
    new_slot[seed // 3] = 0
    # The list grows while it is read.
    for slot in found:
        for e in (slot, slot + 1, slot + 2):
            if is_polygon_edge(start[e], start[next_edge(e)], boundary_count):
                continue
            t = twin[e] // 3
            if new_slot[t] < 0:
                new_slot[t] = 3 * len(found)
                found.append(3 * t)
    new_start: list[int] = []
    new_twin: list[int] = []
    for slot in found:
        for e in (slot, slot + 1, slot + 2):
            new_start.append(start[e])
            if is_polygon_edge(start[e], start[next_edge(e)], boundary_count):
                new_twin.append(NO_TWIN)
            else:
                o = twin[e]
                new_twin.append(new_slot[o // 3] + o % 3)
    return HalfEdges(new_start, new_twin, count)


def _join_ties(xs: list[int], ys: list[int], mesh: HalfEdges, from_lowest: bool) -> None:
    """Makes every co-circular set a fan. Its nodes are on one circle, so no three of them are on a line."""
    start = mesh.start
    twin = mesh.twin
    tied = bytearray(len(start))
    some: list[int] = []
    for e in range(len(start)):
        o = twin[e]
        if o > e and opposite_angles(xs, ys, start[e], start[o], start[previous_edge(e)], start[previous_edge(o)]) == 0:
            tied[e] = 1
            tied[o] = 1
            some.append(e)
    done = bytearray(len(start) // 3)
    for seed in some:
        if done[seed // 3]:
            continue
        done[seed // 3] = 1
        slots = [seed - seed % 3]
        following: dict[int, int] = {}
        around: dict[int, int] = {}
        # The list grows while it is read.
        for slot in slots:
            for e in (slot, slot + 1, slot + 2):
                if not tied[e]:
                    u = start[e]
                    v = start[next_edge(e)]
                    following[u] = v
                    around[u * EDGE_KEY + v] = twin[e]
                    continue
                t = twin[e] // 3
                if not done[t]:
                    done[t] = 1
                    slots.append(3 * t)
        hub = min(following) if from_lowest else max(following)
        fan: list[tuple[int, int, int]] = []
        u = following[hub]
        v = following[u]
        while v != hub:
            fan.append((hub, u, v))
            u = v
            v = following[u]
        fill_region(fan, slots, around, start, twin)
