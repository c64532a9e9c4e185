"""Rasteriser: named cases of MSH-22."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import RangeViolation, ResourceLimit
from snhc.reference_impl.mesh.rasteriser import (
    affine_parameters,
    covering_triangles,
    sample_bilinear,
    source_positions,
    warp,
)
from snhc.reference_impl.mesh.traversal import traverse
from snhc.reference_impl.mesh.uniform import uniform_positions, uniform_triangles


def _uniform(split_code: int, hor: int = 5, vert: int = 4, width: int = 7, height: int = 6):  # type: ignore[no-untyped-def]
    xs, ys = uniform_positions(hor, vert, width, height)
    return xs, ys, traverse(xs, ys, uniform_triangles(hor, vert, split_code)).triangles


def _picture(height: int, width: int, channels: int = 0) -> np.ndarray:
    shape = (height, width, channels) if channels else (height, width)
    return np.random.default_rng(5).integers(0, 256, shape).astype(np.uint8)


def test_rows_of_a_small_triangle() -> None:
    """Corner at the origin, legs of 4 pixels: centres on the long side belong to the triangle right of it."""
    lower_left = covering_triangles([0, 8, 0], [0, 8, 8], [(0, 1, 2)], 4, 4)
    upper_right = covering_triangles([0, 8, 8], [0, 0, 8], [(0, 1, 2)], 4, 4)
    assert (lower_left >= 0).tolist() == np.tri(4, 4, -1, dtype=bool).tolist()
    assert (upper_right >= 0).tolist() == np.triu(np.ones((4, 4), bool)).tolist()


@pytest.mark.parametrize("split_code", [0, 1, 2, 3])
@pytest.mark.parametrize("channels", [0, 3])
def test_identity_warp_is_exact(split_code: int, channels: int) -> None:
    xs, ys, triangles = _uniform(split_code)
    image = _picture(9, 14, channels)
    drawn, covered = warp(image, xs, ys, xs, ys, triangles, 14, 9)
    assert covered.all()
    assert (drawn == image).all()


def test_shift_by_whole_and_half_pixels() -> None:
    xs, ys, triangles = _uniform(2, 5, 4, 8, 8)
    image = _picture(12, 16)
    drawn, covered = warp(image, xs, ys, [x + 6 for x in xs], [y - 4 for y in ys], triangles, 16, 12)
    assert (drawn[:10, 3:] == image[2:, :13]).all()
    assert covered.tolist() == np.pad(np.ones((10, 13), bool), ((0, 2), (3, 0))).tolist()
    assert not drawn[~covered].any()
    drawn, _ = warp(image, xs, ys, [x + 1 for x in xs], ys, triangles, 16, 12)
    # Half a pixel: the mean of two neighbours, halves up.
    expected = (image[:, :-1].astype(int) + image[:, 1:] + 1) // 2
    assert (drawn[:, 1:] == expected).all()


def test_background_and_types() -> None:
    xs, ys, triangles = [0, 4, 0], [0, 0, 4], [(0, 1, 2)]
    image = np.full((2, 2), 0.5)
    drawn, covered = warp(image, xs, ys, xs, ys, triangles, 3, 3, np.full((3, 3), 7.0))
    assert drawn.dtype == np.float64
    assert covered.sum() == 1 and (drawn[covered] == 0.5).all() and (drawn[~covered] == 7.0).all()
    with pytest.raises(RangeViolation, match="background"):
        warp(image, xs, ys, xs, ys, triangles, 3, 3, np.zeros((2, 3)))


def test_later_triangle_is_seen_and_flipped_ones_are_drawn() -> None:
    xs, ys = [0, 8, 8, 0], [0, 0, 8, 8]
    twice = covering_triangles(xs, ys, [(0, 1, 2), (0, 2, 1), (0, 2, 3)], 4, 4)
    assert set(twice.ravel().tolist()) == {1, 2}
    assert (covering_triangles(xs, ys, [(0, 2, 0)], 4, 4) == -1).all()
    assert covering_triangles([], [], [], 2, 3).tolist() == [[-1, -1]] * 3


def test_bilinear_samples() -> None:
    image = np.array([[0.0, 8.0], [16.0, 24.0]])
    x = np.array([1.0, 2.0, 3.0, -9.0, 99.0])
    y = np.array([1.0, 2.0, 1.0, -9.0, 99.0])
    assert sample_bilinear(image, x, y).tolist() == [0.0, 12.0, 8.0, 0.0, 24.0]


def test_affine_parameters_agree_with_the_drawing() -> None:
    source, target = [(0, 0), (20, 3), (5, 17)], [(2, 1), (25, 0), (3, 22)]
    a = affine_parameters(source, target)
    assert all(
        (a[0] * x + a[1] * y + a[2], a[3] * x + a[4] * y + a[5]) == s for s, (x, y) in zip(source, target, strict=True)
    )
    txs, tys = [p[0] for p in target], [p[1] for p in target]
    owner = covering_triangles(txs, tys, [(0, 1, 2)], 16, 16)
    pixels, sx, sy = source_positions(owner, [p[0] for p in source], [p[1] for p in source], txs, tys, [(0, 1, 2)])
    assert len(pixels) > 40
    for at, x, y in zip(pixels.tolist(), sx.tolist(), sy.tolist(), strict=True):
        px, py = 2 * (at % 16) + 1, 2 * (at // 16) + 1
        assert x == float(a[0] * px + a[1] * py + a[2])
        assert y == float(a[3] * px + a[4] * py + a[5])
    assert affine_parameters(target, target) == tuple(map(Fraction, (1, 0, 0, 0, 1, 0)))
    with pytest.raises(RangeViolation, match="MSH-22"):
        affine_parameters(source, [(0, 0), (1, 1), (2, 2)])


def test_limits() -> None:
    with pytest.raises(RangeViolation, match="width"):
        covering_triangles([0], [0], [], 0, 4)
    with pytest.raises(ResourceLimit, match="pixels"):
        covering_triangles([0], [0], [], 32768, 32768)
    with pytest.raises(ResourceLimit, match="position"):
        covering_triangles([0, 1 << 20, 0], [0, 0, 4], [(0, 1, 2)], 4, 4)


def test_far_corners_do_not_overflow() -> None:
    far = 1 << 19
    xs, ys = [-far, far, far, -far], [-far, -far, far, far]
    drawn, covered = warp(_picture(3, 3), xs, ys, xs, ys, [(0, 1, 2), (0, 2, 3)], 3, 3)
    assert covered.all() and (drawn == _picture(3, 3)).all()


def test_drawing() -> None:
    """The wireframe is deterministic, shows the order, flipped triangles in red and vectors in blue."""
    from snhc.reference_impl.mesh.drawing import draw_mesh

    xs, ys = uniform_positions(4, 3, 20, 20)
    topology = traverse(xs, ys, uniform_triangles(4, 3, 2))
    plain = np.asarray(draw_mesh(xs, ys, topology))
    assert plain.shape == (2 * 40 + 48, 2 * 60 + 48, 3)
    assert (plain == np.asarray(draw_mesh(xs, ys, topology))).all()
    # The first cell's diagonal runs down from the top-left node.
    assert plain[24 + 20, 24 + 20].tolist() == [40, 40, 60]
    assert plain[24 + 20, 24 + 60].tolist() == [40, 40, 60]
    assert plain[24 + 12, 24 + 26].tolist() == [255, 255, 255]
    ordered = np.asarray(draw_mesh(xs, ys, topology, order=True))
    assert ordered[24 + 12, 24 + 32].tolist() == [190, 240, 190]
    assert [230, 185, 245] in ordered.reshape(-1, 3).tolist()
    moved = [*xs[:5], xs[5] + 30, *xs[6:]]
    folded = np.asarray(draw_mesh(moved, ys, topology, previous=(xs, ys)))
    assert [220, 40, 40] in folded.reshape(-1, 3).tolist()
    assert [255, 205, 205] in folded.reshape(-1, 3).tolist()
    assert [0, 110, 200] in folded[24 + 40, 24 + 44 : 24 + 95].tolist()
    with pytest.raises(RangeViolation, match="scale"):
        draw_mesh(xs, ys, topology, scale=0)
    with pytest.raises(ResourceLimit, match="pixels"):
        draw_mesh([0, 1 << 30, 0], [0, 0, 1 << 30], topology)
