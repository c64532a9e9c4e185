"""Software rasteriser of textured meshes, with exact integer coverage.

Rules implemented: MSH-22. A pixel (i, j) covers the half-pixel square from (2 i, 2 j) to (2 i + 2, 2 j + 2);
its centre is (2 i + 1, 2 j + 1), so that a uniform mesh over an image covers each of its pixels once. A
centre on an edge belongs to the triangle that lies below (horizontal edges) or to the right of it: neighbours
neither overlap nor leave gaps. Where a folded mesh covers a pixel twice, the later triangle is seen. Every
run gives the same picture. Not implemented here: lines and labels (`drawing`).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import RangeViolation, ResourceLimit

Pixels = NDArray[Any]
Triangles = Sequence[tuple[int, int, int]]

# Beyond these the products of three coordinates would leave 64 bits.
MAX_TEXTURED_POSITION: Final = 1 << 19
MAX_SIDE: Final = 1 << 15
_MAX_PIXELS: Final = 1 << 28
_CHUNK: Final = 1 << 20


def affine_parameters(
    source: Sequence[tuple[int, int]], target: Sequence[tuple[int, int]]
) -> tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction]:
    """The exact a1..a6 of eq. 2, (x, y) = (a1 x' + a2 y' + a3, a4 x' + a5 y' + a6): target nodes to source nodes.

    Rules: MSH-22.

    `source`, `target`: three (x, y) each, in half pixels: texture and current positions. Raises
    RangeViolation for a target triangle without area.
    """
    (x0, y0), (x1, y1), (x2, y2) = target
    area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
    if area == 0:
        raise RangeViolation("MSH-22", "area of a triangle", value=0, allowed="not 0")
    rows: list[Fraction] = []
    for axis in (0, 1):
        s0, s1, s2 = (node[axis] for node in source)
        a = Fraction((s1 - s0) * (y2 - y0) - (s2 - s0) * (y1 - y0), area)
        b = Fraction((s2 - s0) * (x1 - x0) - (s1 - s0) * (x2 - x0), area)
        rows += [a, b, s0 - a * x0 - b * y0]
    return rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]


def _size(width: int, height: int) -> None:
    for what, value in (("width", width), ("height", height)):
        if not 1 <= value <= MAX_SIDE:
            raise RangeViolation("MSH-22", what, value=value, allowed=f"1..{MAX_SIDE}")
    if width * height > _MAX_PIXELS:
        raise ResourceLimit("MSH-22", "pixels", value=width * height, allowed=f"up to {_MAX_PIXELS}")


def _corners(xs: Sequence[int], ys: Sequence[int], triangles: Triangles) -> NDArray[np.int64]:
    """Corner positions, (triangles, 3, 2), each turned clockwise on screen."""
    if len(xs) and max(max(xs), -min(xs), max(ys), -min(ys)) > MAX_TEXTURED_POSITION:
        raise ResourceLimit(
            "MSH-22", "position of a textured mesh", allowed=f"within {MAX_TEXTURED_POSITION} half pixels"
        )
    nodes = np.stack([np.asarray(xs, np.int64), np.asarray(ys, np.int64)], axis=1)
    return nodes[np.asarray(triangles, np.int64).reshape(-1, 3)]


def _doubled_areas(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    u = corners[:, 1] - corners[:, 0]
    v = corners[:, 2] - corners[:, 0]
    areas: NDArray[np.int64] = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return areas


def covering_triangles(
    xs: Sequence[int], ys: Sequence[int], triangles: Triangles, width: int, height: int
) -> NDArray[np.int32]:
    """For each pixel the number of the triangle that covers its centre, or -1.

    Rules: MSH-22.

    `xs`, `ys`: positions in half pixels. `triangles`: in drawing order, in any orientation. `width`,
    `height`: pixels. Returns (height, width). Raises RangeViolation, ResourceLimit.
    """
    _size(width, height)
    owner = np.full(width * height, -1, np.int32)
    corners = _corners(xs, ys, triangles)
    areas = _doubled_areas(corners)
    corners = np.where((areas < 0)[:, None, None], corners[:, [0, 2, 1]], corners)
    # The pixels whose centres lie within the triangle's extent, cut at the picture's sides.
    first = np.maximum(-((1 - corners.min(axis=1)) // 2), 0)
    last = np.minimum((corners.max(axis=1) - 1) // 2, np.array([width - 1, height - 1]))
    extent = last - first + 1
    drawn = np.flatnonzero((areas != 0) & (extent > 0).all(axis=1))
    side = extent.max(axis=1, initial=0)
    size = 4
    while drawn.size:
        # Triangles of about one size are drawn together, in blocks of size x size pixels.
        fits = side[drawn] <= size
        if size >= 64:
            for k in range(len(drawn)):
                t = int(drawn[k])
                _draw(
                    owner,
                    corners,
                    first,
                    drawn[k : k + 1],
                    int(extent[t, 0]),
                    int(extent[t, 1]),
                    width,
                    height,
                )
            return owner.reshape(height, width)
        batch = drawn[fits]
        drawn = drawn[~fits]
        step = max(1, _CHUNK // (size * size))
        for at in range(0, len(batch), step):
            _draw(owner, corners, first, batch[at : at + step], size, size, width, height)
        size *= 2
    return owner.reshape(height, width)


def _draw(
    owner: NDArray[np.int32],
    corners: NDArray[np.int64],
    first: NDArray[np.int64],
    batch: NDArray[np.int64],
    columns: int,
    rows: int,
    width: int,
    height: int,
) -> None:
    i = first[batch, 0][:, None] + np.arange(columns)
    j = first[batch, 1][:, None] + np.arange(rows)
    inside = (i < width)[:, None, :] & (j < height)[:, :, None]
    px = 2 * i + 1
    py = 2 * j + 1
    for k in range(3):
        a = corners[batch, k]
        b = corners[batch, (k + 1) % 3]
        dx = b[:, 0] - a[:, 0]
        dy = b[:, 1] - a[:, 1]
        # Clockwise with y down: upward edges are on the left, edges to the right without slope on top.
        least = np.where((dy < 0) | ((dy == 0) & (dx > 0)), 0, 1)
        along = dx[:, None] * (py - a[:, 1, None]) - least[:, None]
        across = dy[:, None] * (px - a[:, 0, None])
        inside &= along[:, :, None] >= across[:, None, :]
    t, row, column = np.nonzero(inside)
    np.maximum.at(owner, j[t, row] * width + i[t, column], batch[t].astype(np.int32))


def sample_bilinear(image: Pixels, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bilinear samples of an image; beyond its sides the nearest pixel counts.

    Rules: MSH-22.

    `image`: (height, width) or (height, width, channels). `x`, `y`: positions in **half pixels**, of one
    shape. Returns that shape, with the channels behind.
    """
    height, width = image.shape[:2]
    u = np.clip((x - 1.0) / 2.0, 0.0, width - 1.0)
    v = np.clip((y - 1.0) / 2.0, 0.0, height - 1.0)
    i = np.floor(u).astype(np.int64)
    j = np.floor(v).astype(np.int64)
    fu = u - i
    fv = v - j
    if image.ndim == 3:
        fu = fu[..., None]
        fv = fv[..., None]
    right = np.minimum(i + 1, width - 1)
    below = np.minimum(j + 1, height - 1)
    upper = image[j, i] * (1.0 - fu) + image[j, right] * fu
    lower = image[below, i] * (1.0 - fu) + image[below, right] * fu
    samples: NDArray[np.float64] = upper * (1.0 - fv) + lower * fv
    return samples


def source_positions(
    owner: NDArray[np.int32],
    texture_xs: Sequence[int],
    texture_ys: Sequence[int],
    xs: Sequence[int],
    ys: Sequence[int],
    triangles: Triangles,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Where in the texture the covered pixels come from: the inverse affine map of each triangle.

    Rules: MSH-22.

    `owner`: of `covering_triangles`. `texture_xs`, `texture_ys`: positions on the intra plane, `xs`, `ys`:
    current positions, in half pixels. Returns the covered pixels (indices into the flat picture) and their x
    and y in half pixels. Numerators are exact integers: a map that leaves a triangle in place gives its own
    positions exactly.
    """
    flat = owner.ravel()
    pixels = np.flatnonzero(flat >= 0)
    source = _corners(texture_xs, texture_ys, triangles)[flat[pixels]]
    target = _corners(xs, ys, triangles)
    areas = _doubled_areas(target)[flat[pixels]]
    target = target[flat[pixels]]
    px = 2 * (pixels % owner.shape[1]) + 1
    py = 2 * (pixels // owner.shape[1]) + 1
    weighted = np.zeros((len(pixels), 2), np.int64)
    for k in range(3):
        a = target[:, (k + 1) % 3]
        b = target[:, (k + 2) % 3]
        weight = (b[:, 0] - a[:, 0]) * (py - a[:, 1]) - (b[:, 1] - a[:, 1]) * (px - a[:, 0])
        weighted += weight[:, None] * source[:, k]
    positions = weighted / areas[:, None]
    return pixels, positions[:, 0], positions[:, 1]


def warp(
    image: Pixels,
    texture_xs: Sequence[int],
    texture_ys: Sequence[int],
    xs: Sequence[int],
    ys: Sequence[int],
    triangles: Triangles,
    width: int,
    height: int,
    background: Pixels | None = None,
) -> tuple[Pixels, NDArray[np.bool_]]:
    """Draws the texture on the moved mesh.

    Rules: MSH-22.

    `image`: the texture, (rows, columns) or (rows, columns, channels). `texture_xs`, `texture_ys`: positions
    on the intra plane; `xs`, `ys`: current positions, in half pixels. `triangles`: node triples. `width`,
    `height`: of the picture, in pixels. `background`: what shows where there is no mesh, black if None.
    Returns the picture, of the texture's type (integers rounded, halves up), and the coverage, (height,
    width). Raises RangeViolation, ResourceLimit.
    """
    owner = covering_triangles(xs, ys, triangles, width, height)
    pixels, x, y = source_positions(owner, texture_xs, texture_ys, xs, ys, triangles)
    samples = sample_bilinear(image, x, y)
    if np.issubdtype(image.dtype, np.integer):
        samples = np.floor(samples + 0.5)
    shape = (height, width, *image.shape[2:])
    picture = np.zeros(shape, image.dtype) if background is None else np.array(background, image.dtype)
    if picture.shape != shape:
        raise RangeViolation("MSH-22", "shape of the background", value=f"{picture.shape}", allowed=f"{shape}")
    picture.reshape(width * height, *image.shape[2:])[pixels] = samples.astype(image.dtype)
    return picture, owner >= 0
