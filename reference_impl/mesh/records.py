"""Mesh object planes: mutable records of exactly what the wire says, and the frozen frames they decode to.

Rules: MSH-2, MSH-5, MSH-30..41, CNF-1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from ..syntax.temporal import TemporalHeader
from .motion import VectorCode

UNIFORM = 1
DELAUNAY = 2


@dataclass(frozen=True, slots=True)
class MeshFrame:
    """One instant of a mesh.

    Rules: CNF-1, MSH-3.

    `time`: seconds as (numerator, denominator). `nodes`: positions in half pixels by node number, () before any
    geometry. `triangles`, `order`: of a plane that carries geometry, else None: node triples in traversal order,
    clockwise on screen, lowest number first; and the node order of motion decoding.
    """

    index: int
    time: tuple[int, int]
    intra: bool
    nodes: tuple[tuple[int, int], ...]
    triangles: tuple[tuple[int, int, int], ...] | None = None
    order: tuple[int, ...] | None = None


@final
class MeshGeometry:
    """`mesh_geometry()`.

    Rules: MSH-5, MSH-30..39.

    `type`: UNIFORM or DELAUNAY. Uniform: nodes per row and column, cell sizes in half pixels, `split_code` 0..3.
    Delaunay: `boundary_count`, and all node positions `xs`, `ys` in half pixels, the boundary first.
    """

    __slots__ = ("boundary_count", "nodes_hor", "nodes_vert", "rect_hor", "rect_vert", "split_code", "type", "xs", "ys")

    def __init__(self) -> None:
        self.type = DELAUNAY
        self.nodes_hor = 2
        self.nodes_vert = 2
        self.rect_hor = 1
        self.rect_vert = 1
        self.split_code = 0
        self.boundary_count = 3
        self.xs: list[int] = []
        self.ys: list[int] = []


@final
class MeshMotion:
    """`mesh_motion()`: the range and the vectors' codes in traversal order. Rules: MSH-40, MSH-41."""

    __slots__ = ("codes", "range_code")

    def __init__(self) -> None:
        self.range_code = 1
        self.codes: list[VectorCode] = []


@final
class MeshPlane:
    """One `mesh_object_plane()`.

    Rules: MSH-2, MSH-3.

    `stuffing`: 0 where the data ends exactly behind the plane. `user_data`: what stands behind the stuffing. `frames`:
    what it decodes to. `start`, `end`: its bits, from the start code to behind its data.
    """

    __slots__ = (
        "end", "frames", "geometry", "header", "is_intra", "mesh_mask", "motion", "start", "stuffing", "user_data",
    )  # fmt: skip

    def __init__(self) -> None:
        self.is_intra = 0
        self.mesh_mask = 0
        self.header = TemporalHeader()
        self.geometry: MeshGeometry | None = None
        self.motion: MeshMotion | None = None
        self.stuffing = 1
        self.user_data: list[bytes] = []
        self.frames: list[MeshFrame] = []
        self.start = 0
        self.end = 0


@final
class MeshObject:
    """A `mesh_object()` without its planes.

    Rules: MSH-1, MSH-25.

    `stuffing`: 1 where a byte 0x7F stands behind the object start code. `padding`: zero bits to the end of the data.
    """

    __slots__ = ("padding", "planes", "stuffing")

    def __init__(self) -> None:
        self.stuffing = 0
        self.padding = 0
        self.planes: list[MeshPlane] = []
