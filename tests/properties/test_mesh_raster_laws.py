"""Laws of the rasteriser (MSH-22): neighbours part the pixels between them, whatever their shape."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_shapes import Point, points

from snhc.reference_impl.mesh.polygon import first_fault
from snhc.reference_impl.mesh.rasteriser import covering_triangles, warp
from snhc.reference_impl.mesh.triangulation import delaunay_triangles

Triangle = tuple[int, int, int]


@st.composite
def _squares(draw: st.DrawFn, side: int = 40) -> tuple[list[int], list[int], list[Triangle]]:
    """A triangulated square with random nodes inside, from the origin."""
    inner = draw(st.lists(st.tuples(*[st.integers(1, side - 1)] * 2), max_size=25, unique=True))
    nodes = [(0, 0), (side, 0), (side, side), (0, side), *inner]
    xs, ys = [x for x, _ in nodes], [y for _, y in nodes]
    assert first_fault(xs, ys, 4) is None
    start = delaunay_triangles(xs, ys, 4).start
    return xs, ys, [(start[i], start[i + 1], start[i + 2]) for i in range(0, len(start), 3)]


@settings(max_examples=60, deadline=None)
@given(_squares())
def test_every_pixel_of_a_square_once(square: tuple[list[int], list[int], list[Triangle]]) -> None:
    xs, ys, triangles = square
    times = np.zeros((22, 22), int)
    for t in triangles:
        times += covering_triangles(xs, ys, [t], 22, 22) >= 0
    assert (times[:20, :20] == 1).all()
    assert times.sum() == 400
    # All at once or one by one, in any order: the same triangle owns each pixel.
    owner = covering_triangles(xs, ys, triangles, 22, 22)
    backwards = covering_triangles(xs, ys, triangles[::-1], 22, 22)
    assert (owner == np.where(backwards < 0, -1, len(triangles) - 1 - backwards)).all()


@settings(max_examples=200, deadline=None)
@given(points(30), points(30), points(30), points(30))
def test_two_neighbours_part_the_pixels(a: Point, b: Point, c: Point, d: Point) -> None:
    """c and d on different sides of a-b: no pixel twice; one centre on a-b belongs to exactly one of them."""

    def side(p: Point) -> int:
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    if side(c) * side(d) >= 0:
        return
    xs, ys = zip(*((x + 30, y + 30) for x, y in (a, b, c, d)), strict=True)
    first = covering_triangles(xs, ys, [(0, 1, 2)], 32, 32) >= 0
    second = covering_triangles(xs, ys, [(0, 1, 3)], 32, 32) >= 0
    assert not (first & second).any()
    for px in range(1, 61, 2):
        for py in range(1, 61, 2):
            on_edge = (xs[1] - xs[0]) * (py - ys[0]) == (ys[1] - ys[0]) * (px - xs[0])
            between = (px - xs[0]) * (px - xs[1]) + (py - ys[0]) * (py - ys[1]) < 0
            if on_edge and between:
                assert first[py // 2, px // 2] != second[py // 2, px // 2]


@settings(max_examples=100, deadline=None)
@given(points(40), points(40), points(40), st.integers(1, 24), st.integers(1, 24))
def test_against_the_rule_pixel_by_pixel(a: Point, b: Point, c: Point, width: int, height: int) -> None:
    """Inside, or on a left or top edge; triangles that reach beyond the picture are cut."""
    corners = [a, b, c]
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area < 0:
        corners.reverse()
    drawn = covering_triangles([x for x, _ in (a, b, c)], [y for _, y in (a, b, c)], [(0, 1, 2)], width, height)
    for j in range(height):
        for i in range(width):
            inside = area != 0
            for k in range(3):
                (ax, ay), (bx, by) = corners[k], corners[(k + 1) % 3]
                value = (bx - ax) * (2 * j + 1 - ay) - (by - ay) * (2 * i + 1 - ax)
                left_or_top = by < ay or (by == ay and bx > ax)
                inside = inside and (value > 0 or (value == 0 and left_or_top))
            assert (drawn[j, i] >= 0) == inside


@settings(max_examples=40, deadline=None)
@given(_squares(), st.integers(0, 1000))
def test_identity_warp_gives_the_image(square: tuple[list[int], list[int], list[Triangle]], seed: int) -> None:
    xs, ys, triangles = square
    image = np.random.default_rng(seed).integers(0, 256, (20, 20)).astype(np.uint8)
    drawn, covered = warp(image, xs, ys, xs, ys, triangles, 20, 20)
    assert covered.all() and (drawn == image).all()
