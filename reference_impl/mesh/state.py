"""What a mesh decoder keeps from plane to plane.

Rules: MSH-3, MSH-6..9, MSH-12..17, MSH-18..21.
"""

from __future__ import annotations

from typing import final

from ..syntax.element import Readings
from ..syntax.temporal import Clock
from .motion import move
from .records import UNIFORM, MeshFrame, MeshGeometry, MeshPlane
from .topology import MeshTopology
from .traversal import traverse
from .triangulation import delaunay_triangles
from .uniform import uniform_positions, uniform_triangles


@final
class MeshState:
    """Positions, topology and clock of one mesh object.

    Rules: MSH-3, MSH-16, FBA-38.

    `xs`, `ys`: positions in half pixels by node number; `nodes`: the same for frames, so that planes without data
    share them. `vx`, `vy`: the vectors of the last motion plane.
    """

    __slots__ = ("_shape", "clock", "index", "nodes", "readings", "topology", "vx", "vy", "xs", "ys")

    def __init__(self, readings: Readings) -> None:
        self.readings = readings
        self.clock = Clock()
        self.index = 0
        self.topology: MeshTopology | None = None
        self.nodes: tuple[tuple[int, int], ...] = ()
        self._shape = (0, 0, 0)  # of the uniform mesh whose topology stands
        self.xs: list[int] = []
        self.ys: list[int] = []
        self.vx: list[int] = []
        self.vy: list[int] = []

    def set_geometry(self, geometry: MeshGeometry) -> None:
        """Positions and topology of a geometry without faults. Rules: MSH-6, MSH-7, MSH-8, MSH-9, MSH-18..21."""
        if geometry.type == UNIFORM:
            self.xs, self.ys = uniform_positions(
                geometry.nodes_hor, geometry.nodes_vert, geometry.rect_hor, geometry.rect_vert
            )
            # The traversal of a uniform mesh does not depend on its cell sizes: a stream that sends the same mesh over
            # and over (10 bytes for a million nodes) must not pay for it each time.
            shape = (geometry.nodes_hor, geometry.nodes_vert, geometry.split_code)
            if shape == self._shape:
                return
            self._shape = shape
            mesh = uniform_triangles(*shape, self.readings.mesh_split)
        else:
            self._shape = (0, 0, 0)
            self.xs = list(geometry.xs)
            self.ys = list(geometry.ys)
            ties = "lowest" if self.readings.mesh_ties == "fan" else "other"
            mesh = delaunay_triangles(self.xs, self.ys, geometry.boundary_count, ties)
        self.topology = traverse(self.xs, self.ys, mesh)


def reconstruct_mesh(state: MeshState, plane: MeshPlane) -> list[MeshFrame]:
    """The frame of a plane; the state moves on. Rules: MSH-3, MSH-16, FBA-38, CNF-1."""
    time = state.clock.tick(plane.header, state.readings.skipped_frames == "before")
    triangles = order = None
    if plane.motion is not None:
        state.xs, state.ys = move(state.xs, state.ys, state.vx, state.vy)
    if plane.geometry is not None and state.topology is not None:
        triangles = tuple(state.topology.triangles)
        order = tuple(state.topology.order)
    if plane.motion is not None or plane.geometry is not None:
        state.nodes = tuple(zip(state.xs, state.ys, strict=True))
    frame = MeshFrame(state.index, time, bool(plane.is_intra), state.nodes, triangles, order)
    state.index += 1
    return [frame]
