"""Random geometries for the laws of 2D meshes, and oracles that share nothing with the product."""

from __future__ import annotations

from itertools import combinations, pairwise

import shapely
from hypothesis import assume
from hypothesis import strategies as st

Point = tuple[int, int]


def points(size: int) -> st.SearchStrategy[Point]:
    return st.tuples(st.integers(-size, size), st.integers(-size, size))


def _cross(a: Point, b: Point, c: Point) -> int:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@st.composite
def simple_polygons(draw: st.DrawFn, size: int, most: int) -> list[Point]:
    """Any simple polygon: a random closed line, untangled by turning stretches around; straight nodes allowed."""
    ring = draw(st.lists(points(size), min_size=3, max_size=most, unique=True))
    n = len(ring)
    for _ in range(60):
        for i, j in combinations(range(n), 2):
            a, b, c, d = ring[i], ring[(i + 1) % n], ring[j], ring[(j + 1) % n]
            if len({a, b, c, d}) == 4 and shapely.LineString([a, b]).intersects(shapely.LineString([c, d])):
                ring[i + 1 : j + 1] = reversed(ring[i + 1 : j + 1])
                break
        else:
            break
    assume(shapely.Polygon(ring).is_valid and shapely.Polygon(ring).area > 0)
    return ring if draw(st.booleans()) else ring[::-1]


@st.composite
def grid_polygons(draw: st.DrawFn, size: int) -> list[Point]:
    """The outline of a row of columns, in unit steps: long straight runs, right angles, co-circular squares."""
    heights = draw(st.lists(st.tuples(st.integers(0, size), st.integers(1, size)), min_size=1, max_size=size))
    top = [a for a, _ in heights]
    bottom = [a + b for a, b in heights]
    # Neighbouring columns must share more than a corner.
    for k in range(1, len(heights)):
        top[k] = min(top[k], bottom[k - 1] - 1)
        bottom[k] = max(bottom[k], top[k - 1] + 1)
    shape = shapely.union_all([shapely.box(k, a, k + 1, b) for k, (a, b) in enumerate(zip(top, bottom, strict=True))])
    corners = list(shape.exterior.coords)
    ring: list[Point] = []
    for (x0, y0), (x1, y1) in pairwise(corners):
        steps = int(max(abs(x1 - x0), abs(y1 - y0)))
        ring += [(int(x0 + (x1 - x0) * i / steps), int(y0 + (y1 - y0) * i / steps)) for i in range(steps)]
    first = draw(st.integers(0, len(ring) - 1))
    ring = ring[first:] + ring[:first]
    return ring if draw(st.booleans()) else ring[::-1]


@st.composite
def geometries(draw: st.DrawFn, size: int = 8, most: int = 12, interior: int = 8) -> tuple[list[Point], int]:
    """Nodes and the number of boundary nodes."""
    ring = draw(st.one_of(simple_polygons(size, most), grid_polygons(4)))
    shape = shapely.Polygon(ring)
    some = draw(st.lists(points(size), max_size=interior, unique=True))
    inside = [p for p in some if shape.contains(shapely.Point(p))]
    return ring + inside, len(ring)


def in_circle(a: Point, b: Point, c: Point, d: Point) -> int:
    """The determinant: positive where d lies inside the circle through a, b, c."""
    rows = [(x - d[0], y - d[1]) for x, y in (a, b, c)]
    sizes = [x * x + y * y for x, y in rows]
    value = sum(
        sizes[i] * (rows[(i + 1) % 3][0] * rows[(i + 2) % 3][1] - rows[(i + 2) % 3][0] * rows[(i + 1) % 3][1])
        for i in range(3)
    )
    return value if _cross(a, b, c) > 0 else -value


def first_fault(nodes: list[Point], boundary_count: int) -> int | None:
    """The smallest faulty node, by trying every beginning of the list."""
    polygon = shapely.Polygon(nodes[:boundary_count]) if len(nodes) >= boundary_count else None
    for k in range(len(nodes)):
        if nodes[k] in nodes[:k]:
            return k
        if 0 < k < boundary_count and not shapely.LineString(nodes[: k + 1]).is_simple:
            return k
        if polygon is not None and k == boundary_count - 1 and not (polygon.is_valid and polygon.area > 0):
            return k
        if polygon is not None and k >= boundary_count and not polygon.contains(shapely.Point(nodes[k])):
            return k
    return None
