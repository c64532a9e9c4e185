"""Designing meshes for pictures: the encoder's side.

Rules implemented: MSH-23 (informative): uniform and content-based design. Positions are in half pixels, pictures are
2D arrays of luminance, 0..255. Needs SciPy and scikit-image, which are in `snhc[view]`.
Not implemented here: tracking (`tracking`), writing the planes (syntax).
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.mesh.polygon import first_fault
from snhc.reference_impl.mesh.rasteriser import MAX_SIDE
from snhc.reference_impl.mesh.topology import MeshTopology
from snhc.reference_impl.mesh.traversal import traverse
from snhc.reference_impl.mesh.triangulation import delaunay_triangles
from snhc.reference_impl.mesh.uniform import (
    MAX_CELL_SIZE,
    MAX_NODES_PER_SIDE,
    uniform_positions,
    uniform_triangles,
)

Picture = NDArray[Any]

MACROBLOCK: Final = 16
MAX_STEP: Final = 2047  # half pixels between nodes that follow each other: MSH-5
MAX_NODE0: Final = 4096
_MAX_BOUNDARY_NODES: Final = 1023
_MAX_NODES: Final = 65535
_MAX_PICTURE_SIDE: Final = 8191  # 16382 half pixels: MSH-24


@final
class DesignedMesh:
    """A mesh made for a picture, with what its geometry syntax needs.

    Rules: MSH-6, MSH-7, MSH-8, MSH-23.

    `xs`, `ys`: positions in half pixels. `topology`: triangles and traversal. `boundary_count`:
    nr_of_boundary_nodes, 0 for uniform meshes. `cells`: (nodes_hor, nodes_vert, rect_hor, rect_vert,
    split_code) of uniform meshes, else None.
    """

    __slots__ = ("boundary_count", "cells", "topology", "xs", "ys")

    def __init__(
        self,
        xs: list[int],
        ys: list[int],
        topology: MeshTopology,
        boundary_count: int,
        cells: tuple[int, int, int, int, int] | None,
    ) -> None:
        self.xs = xs
        self.ys = ys
        self.topology = topology
        self.boundary_count = boundary_count
        self.cells = cells


def check_picture(picture: Picture, what: str) -> None:
    """Refuses what is not a picture of luminance of a fitting size. Rules: MSH-23. Raises EncodeError."""
    if picture.ndim != 2 or not all(2 <= side <= _MAX_PICTURE_SIDE for side in picture.shape):
        raise EncodeError(
            "MSH-23",
            what,
            value=f"shape {picture.shape}",
            allowed=f"two axes of 2..{_MAX_PICTURE_SIDE} pixels",
        )


def uniform_design(width: int, height: int, split_code: int = 2) -> DesignedMesh:
    """A uniform mesh over a bounding box, with about as many triangles as the box has macroblocks.

    Rules: MSH-6, MSH-7, MSH-23.

    `width`, `height`: of the box in pixels; the mesh covers at least the box. `split_code`: 0..3.
    Raises EncodeError.
    """
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise EncodeError("MSH-23", "bounding box", value=f"{width} x {height}", allowed=f"1..{MAX_SIDE} pixels a side")
    # Two triangles per cell: a cell has the area of two macroblocks.
    cell = MACROBLOCK * 2**0.5

    def cells_along(side: int) -> tuple[int, int]:
        count = max(1, round(side / cell))
        count = min(max(count, -(-2 * side // MAX_CELL_SIZE)), MAX_NODES_PER_SIDE - 1)
        return count, -(-2 * side // count)

    columns, rect_hor = cells_along(width)
    rows, rect_vert = cells_along(height)
    xs, ys = uniform_positions(columns + 1, rows + 1, rect_hor, rect_vert)
    topology = traverse(xs, ys, uniform_triangles(columns + 1, rows + 1, split_code))
    return DesignedMesh(xs, ys, topology, 0, (columns + 1, rows + 1, rect_hor, rect_vert, split_code))


def _outline(mask: NDArray[np.bool_], tolerance: float) -> list[tuple[int, int]]:
    """The longest outline of the mask as a simple polygon of half-pixel positions."""
    measure: Any = import_module("skimage.measure")
    if mask.all():
        bottom, right = 2 * mask.shape[0], 2 * mask.shape[1]
        return [(0, 0), (right, 0), (right, bottom), (0, bottom)]
    contours = measure.find_contours(np.pad(mask, 1).astype(np.float64), 0.5)
    if not contours:
        raise EncodeError("MSH-23", "mask", value="empty", allowed="at least one pixel")
    contour = max(contours, key=len)
    for _ in range(32):
        line = measure.approximate_polygon(contour, tolerance)[:-1]
        # Array index 1 is pixel 0 after padding; its centre is half pixel 1.
        points = [(round(2 * x) - 1, round(2 * y) - 1) for y, x in line.tolist()]
        nodes = [p for k, p in enumerate(points) if p != points[k - 1]]
        if 3 <= len(nodes) <= _MAX_BOUNDARY_NODES:
            fault = first_fault([p[0] for p in nodes], [p[1] for p in nodes], len(nodes))
            if fault is None:
                return nodes
        # Rounding has folded the outline or it is too long: a coarser one has fewer corners.
        tolerance = tolerance * 1.25 if len(nodes) > 4 else tolerance * 0.5
    raise EncodeError("MSH-23", "mask", value="outline", allowed="a shape of more than a few pixels")


def _reachable(outline: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The same outline from the node nearest the origin on, long edges divided: steps that the syntax can hold."""
    first = min(range(len(outline)), key=lambda k: (max(abs(outline[k][0]), abs(outline[k][1])), k))
    if max(abs(outline[0][0]), abs(outline[0][1])) < MAX_NODE0:
        first = 0
    nodes = outline[first:] + outline[:first]
    out: list[tuple[int, int]] = []
    for (x, y), (next_x, next_y) in zip(nodes, nodes[1:] + nodes[:1], strict=True):
        size = max(abs(next_x - x), abs(next_y - y))
        parts = -(-size // MAX_STEP)
        out += [(x + (next_x - x) * k // parts, y + (next_y - y) * k // parts) for k in range(parts)]
    if len(out) > _MAX_BOUNDARY_NODES or first_fault([p[0] for p in out], [p[1] for p in out], len(out)) is not None:
        raise EncodeError("MSH-5", "outline", value="long edges", allowed=f"edges within {MAX_STEP} half pixels")
    return out


def _ordered(nodes: list[tuple[int, int]], last: tuple[int, int]) -> list[tuple[int, int]]:
    """Interior nodes in an order whose steps the syntax can hold: as they are, else in bands to and fro."""
    if all(max(abs(b[0] - a[0]), abs(b[1] - a[1])) <= MAX_STEP for a, b in zip([last, *nodes], nodes, strict=False)):
        return nodes
    band = MAX_STEP // 2
    return sorted(nodes, key=lambda p: (p[1] // band, p[0] if p[1] // band % 2 == last[1] // band % 2 else -p[0], p[1]))


def _salient_nodes(
    picture: Picture, mask: NDArray[np.bool_], outline: list[tuple[int, int]], count: int, spacing: float
) -> list[tuple[int, int]]:
    """Up to `count` pixel centres of strong gradient, `spacing` pixels from each other and the outline."""
    from scipy.ndimage import distance_transform_edt, gaussian_gradient_magnitude

    gradient = gaussian_gradient_magnitude(picture.astype(np.float64), 1.0)
    open_ = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1] > spacing
    xs = [p[0] for p in outline]
    ys = [p[1] for p in outline]
    size = int(np.ceil(spacing))
    steps = np.arange(-size, size + 1)
    disc = steps[:, None] ** 2 + steps[None, :] ** 2 <= spacing * spacing
    chosen: list[tuple[int, int]] = []
    # Strongest first; equal ones from the top and the left.
    for at in np.argsort(-gradient, axis=None, kind="stable").tolist():
        if len(chosen) >= count:
            break
        j, i = divmod(at, picture.shape[1])
        if not open_[j, i]:
            continue
        node = (2 * i + 1, 2 * j + 1)
        # The polygon cuts corners of the mask.
        if first_fault([*xs, node[0]], [*ys, node[1]], len(outline)) is not None:
            open_[j, i] = False
            continue
        chosen.append(node)
        top, left = max(0, j - size), max(0, i - size)
        part = open_[top : j + size + 1, left : i + size + 1]
        part &= ~disc[top - j + size :, left - i + size :][: part.shape[0], : part.shape[1]]
    return chosen


def content_based_design(
    picture: Picture,
    mask: Picture | None = None,
    *,
    interior_nodes: int = 100,
    spacing: float = 6.0,
    tolerance: float = 1.5,
) -> DesignedMesh:
    """A Delaunay mesh that fits an object: its outline as a polygon, interior nodes at strong gradients.

    Rules: MSH-8, MSH-23.

    `picture`: luminance. `mask`: non-zero on the object, of the picture's shape; None: the whole picture.
    `interior_nodes`: at most so many, 0..64,000. `spacing`: smallest distance between interior nodes and to
    the outline, in pixels, at least 1. `tolerance`: of the outline, in pixels, above 0. Raises EncodeError.
    """
    check_picture(picture, "picture")
    inside: NDArray[np.bool_] = np.ones(picture.shape, bool) if mask is None else np.asarray(mask) != 0
    if inside.shape != picture.shape:
        raise EncodeError("MSH-23", "mask", value=f"shape {inside.shape}", allowed=f"{picture.shape}")
    if not 0 <= interior_nodes <= _MAX_NODES - _MAX_BOUNDARY_NODES:
        raise EncodeError("MSH-23", "interior nodes", value=interior_nodes, allowed="0..64512")
    if not (spacing >= 1 and tolerance > 0):
        raise EncodeError("MSH-23", "spacing, tolerance", value=f"{spacing}, {tolerance}", allowed=">= 1, above 0")
    outline = _reachable(_outline(inside, tolerance))
    nodes = outline + _ordered(_salient_nodes(picture, inside, outline, interior_nodes, spacing), outline[-1])
    xs = [p[0] for p in nodes]
    ys = [p[1] for p in nodes]
    topology = traverse(xs, ys, delaunay_triangles(xs, ys, len(outline)))
    return DesignedMesh(xs, ys, topology, len(outline), None)
