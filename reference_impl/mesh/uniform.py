"""Uniform meshes: node positions and the split of every cell.

Rules implemented: MSH-6, MSH-7 (with the readings of AMB-MSH-1), MSH-11 (counts and cell sizes of uniform
meshes). Not implemented here: the fields and their widths (MSH-31..36: syntax), CNF-22 (the caller's limit on
nodes).
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.mesh.topology import NO_TWIN, HalfEdges

ALTERNATIONS: Final = ("checkerboard", "by-column", "by-row")
MAX_NODES_PER_SIDE: Final = 1023
MAX_CELL_SIZE: Final = 255


def _require(rule: str, what: str, value: int, lo: int, hi: int) -> None:
    if not lo <= value <= hi:
        raise RangeViolation(rule, what, value=value, allowed=f"{lo}..{hi}")


def uniform_positions(nodes_hor: int, nodes_vert: int, rect_hor: int, rect_vert: int) -> tuple[list[int], list[int]]:
    """Positions of the nodes, row by row from the top-left node at the origin.

    Rules: MSH-6, MSH-11.

    `nodes_hor`, `nodes_vert`: nodes per row and per column, 2..1023. `rect_hor`, `rect_vert`: cell size in
    half pixels, 1..255. Returns x and y in half pixels. Raises RangeViolation.
    """
    _require("MSH-31", "nr_of_mesh_nodes_hor", nodes_hor, 2, MAX_NODES_PER_SIDE)
    _require("MSH-32", "nr_of_mesh_nodes_vert", nodes_vert, 2, MAX_NODES_PER_SIDE)
    _require("MSH-34", "mesh_rect_size_hor", rect_hor, 1, MAX_CELL_SIZE)
    _require("MSH-35", "mesh_rect_size_vert", rect_vert, 1, MAX_CELL_SIZE)
    row = [col * rect_hor for col in range(nodes_hor)]
    xs = row * nodes_vert
    ys: list[int] = []
    for line in range(nodes_vert):
        ys.extend([line * rect_vert] * nodes_hor)
    return xs, ys


def splits_down(split_code: int, row: int, col: int, alternation: str = "checkerboard") -> bool:
    """Whether a cell is split from the top-left to the bottom-right (else bottom-left to top-right).

    Rules: MSH-7, AMB-MSH-1.

    `split_code`: triangle_split_code, 0..3. `row`, `col`: the cell. `alternation`: the reading of "alternate"
    (codes 2 and 3), one of `ALTERNATIONS`. Raises RangeViolation.
    """
    _require("MSH-36", "triangle_split_code", split_code, 0, 3)
    if split_code < 2:
        return split_code == 0
    if alternation == "checkerboard":
        parity = row + col
    elif alternation == "by-column":
        parity = col
    elif alternation == "by-row":
        parity = row
    else:
        raise RangeViolation("AMB-MSH-1", "reading", value=alternation, allowed=", ".join(ALTERNATIONS))
    # Code 10 begins with top-left to bottom-right in cell (0, 0), code 11 with the other diagonal.
    return (parity & 1) == (split_code & 1)


def uniform_triangles(nodes_hor: int, nodes_vert: int, split_code: int, alternation: str = "checkerboard") -> HalfEdges:
    """The triangles of a uniform mesh with their neighbours, two per cell, cells row by row.

    Rules: MSH-7, MSH-11, AMB-MSH-1.

    `nodes_hor`, `nodes_vert`: nodes per row and per column, 2..1023. `split_code`, `alternation`: see
    `splits_down`. Raises RangeViolation.
    """
    _require("MSH-31", "nr_of_mesh_nodes_hor", nodes_hor, 2, MAX_NODES_PER_SIDE)
    _require("MSH-32", "nr_of_mesh_nodes_vert", nodes_vert, 2, MAX_NODES_PER_SIDE)
    cols = nodes_hor - 1
    rows = nodes_vert - 1
    # The split depends on the parities alone.
    down = [splits_down(split_code, i >> 1, i & 1, alternation) for i in range(4)]
    number = list(range(nodes_hor * nodes_vert))
    start: list[int] = []
    twin: list[int] = []
    stride = 6 * cols
    for row in range(rows):
        for col in range(cols):
            top_left = row * nodes_hor + col
            a = number[top_left]
            b = number[top_left + 1]
            c = number[top_left + nodes_hor]
            d = number[top_left + nodes_hor + 1]
            base = stride * row + 6 * col
            parity = (row & 1) << 1
            beside = down[parity | (~col & 1)]
            # Half-edge 0 of a cell is its top, 4 its bottom; the right side is 1 and the left side 5 in a
            # cell split downwards, 3 and 2 in the other kind.
            above = base - stride + 4 if row else NO_TWIN
            below = base + stride if row + 1 < rows else NO_TWIN
            right = base + 6 + (5 if beside else 2) if col + 1 < cols else NO_TWIN
            left = base - 6 + (1 if beside else 3) if col else NO_TWIN
            if down[parity | (col & 1)]:
                start += (a, b, d, a, d, c)
                twin += (above, right, base + 3, base + 2, below, left)
            else:
                start += (a, b, c, b, d, c)
                twin += (above, base + 5, left, right, below, base + 1)
    return HalfEdges(start, twin, nodes_hor * nodes_vert)
