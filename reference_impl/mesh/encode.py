"""From frames to mesh object planes: geometry, the smallest motion range, canonical triangles.

Rules: MSH-2, MSH-3, MSH-4, MSH-5, MSH-6..9, MSH-11, MSH-13..16, MSH-24, MSH-40, CNF-1.
Not here: time (`systems.mesh_encoding`), designing meshes for pictures (`design_encoder`, `tracking`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, final

from ..bitstream.errors import (
    EncodeError,
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..syntax.element import DEFAULT_READINGS, Readings
from .document import DocumentFrame
from .motion import predict, smallest_range_code, vector_code
from .polygon import first_fault
from .records import DELAUNAY, UNIFORM, MeshGeometry, MeshMotion, MeshPlane
from .state import MeshState
from .syntax import NODE_MAX, NODE_MIN
from .topology import MeshTopology
from .uniform import MAX_CELL_SIZE, MAX_NODES_PER_SIDE, uniform_positions

FAR: Final = ("error", "intra")
"""What happens to vectors outside -2048..2047 half pixels: refused, or a new intra plane is sent."""

_MAX_DELTA: Final = 2047
_NODE0: Final = 4096
_MAX_BOUNDARY_NODES: Final = 1023


def motion_plane(
    topology: MeshTopology, vx: Sequence[int], vy: Sequence[int], range_code: int | None = None
) -> MeshPlane:
    """An inter plane, with the smallest motion range unless it is given.

    Rules: MSH-12..16, MSH-40, MSH-41.

    `vx`, `vy`: vectors by node number, in half pixels. Raises EncodeError for one outside the range.
    """
    plane = MeshPlane()
    plane.mesh_mask = 1
    motion = MeshMotion()
    xs, ys = list(vx), list(vy)
    motion.range_code = smallest_range_code(xs, ys) if range_code is None else range_code
    motion.codes = [
        vector_code((xs[node], ys[node]), predict(topology, k, xs, ys), motion.range_code)
        for k, node in enumerate(topology.order)
    ]
    plane.motion = motion
    return plane


def geometry_plane(geometry: MeshGeometry) -> MeshPlane:
    """An intra plane. Rules: MSH-2, MSH-30."""
    plane = MeshPlane()
    plane.is_intra = plane.mesh_mask = 1
    plane.geometry = geometry
    return plane


def uniform_geometry(cells: tuple[int, int, int, int, int]) -> MeshGeometry:
    """Rules: MSH-31..36. `cells`: nodes per row and column, cell width and height in half pixels, split code."""
    geometry = MeshGeometry()
    geometry.type = UNIFORM
    geometry.nodes_hor, geometry.nodes_vert, geometry.rect_hor, geometry.rect_vert, geometry.split_code = cells
    return geometry


def delaunay_geometry(nodes: Sequence[tuple[int, int]], boundary_count: int) -> MeshGeometry:
    """Rules: MSH-5, MSH-37..39. `nodes`: positions in half pixels, the boundary first."""
    geometry = MeshGeometry()
    geometry.type = DELAUNAY
    geometry.boundary_count = boundary_count
    geometry.xs = [x for x, _ in nodes]
    geometry.ys = [y for _, y in nodes]
    return geometry


@final
class MeshEncoder:
    """Turns frames into planes, one by one.

    Rules: MSH-2..16, CNF-1.

    `far`: one of FAR. `readings`: under which triangles are canonical (AMB-MSH-1, AMB-MSH-2). `limits`: on nodes.
    """

    def __init__(
        self, *, far: str = "error", readings: Readings = DEFAULT_READINGS, limits: Limits = DEFAULT_LIMITS
    ) -> None:
        if far not in FAR:
            raise EncodeError("MSH-13", "far", value=far, allowed=", ".join(FAR))
        self._far = far
        self._limits = limits
        self._state = MeshState(readings)
        self._geometry: MeshGeometry | None = None

    def plane(self, frame: DocumentFrame) -> MeshPlane:
        """The plane of the next frame, without its temporal header.

        Rules: MSH-2..5, MSH-11, MSH-16, MSH-24. A frame whose nodes stay where they were becomes a plane without
        data. Raises InputFormat, RangeViolation, InconsistentSemantics, ResourceLimit, EncodeError, with the path.
        """
        state = self._state
        if frame.has_geometry:
            return self._intra(frame, self._geometry_of(frame))
        before = list(zip(state.xs, state.ys, strict=True))
        if list(frame.nodes) == before:
            plane = MeshPlane()
            plane.is_intra = 1 if frame.intra else 0
            return plane
        if frame.intra:
            raise InputFormat(
                "CNF-1", "frame", value="an intra frame with other nodes and no geometry",
                allowed="triangles, boundary_count or uniform", path=frame.path,
            )  # fmt: skip
        if state.topology is None:
            raise InconsistentSemantics(
                "MSH-4", "intra", value="false", allowed="true, before any motion", path=f"{frame.path}.intra"
            )
        if len(frame.nodes) != len(before):
            raise InconsistentSemantics(
                "MSH-16", "nodes", value=len(frame.nodes), allowed="as many as before the motion",
                expected=len(before), path=f"{frame.path}.nodes",
            )  # fmt: skip
        return self._inter(frame, before)

    def _inter(self, frame: DocumentFrame, before: list[tuple[int, int]]) -> MeshPlane:
        state = self._state
        assert state.topology is not None and self._geometry is not None
        vx = [new[0] - old[0] for new, old in zip(frame.nodes, before, strict=True)]
        vy = [new[1] - old[1] for new, old in zip(frame.nodes, before, strict=True)]
        for node, v in enumerate(zip(vx, vy, strict=True)):
            if not (-2048 <= v[0] <= 2047 and -2048 <= v[1] <= 2047):
                if self._far == "intra" and self._geometry.type == DELAUNAY:
                    return self._intra(frame, delaunay_geometry(frame.nodes, self._geometry.boundary_count))
                raise RangeViolation(
                    "MSH-13", "motion vector", value=f"{v}", allowed="-2048..2047 half pixels",
                    path=f"{frame.path}.nodes[{node}]",
                )  # fmt: skip
        plane = motion_plane(state.topology, vx, vy)
        state.xs = [x for x, _ in frame.nodes]
        state.ys = [y for _, y in frame.nodes]
        return plane

    def _intra(self, frame: DocumentFrame, geometry: MeshGeometry) -> MeshPlane:
        if geometry.type == DELAUNAY:
            self._check_delaunay(frame, geometry)
        self._state.set_geometry(geometry)
        self._geometry = geometry
        self._check_topology(frame)
        return geometry_plane(geometry)

    def _geometry_of(self, frame: DocumentFrame) -> MeshGeometry:
        if frame.uniform is not None and frame.boundary_count:
            raise InconsistentSemantics(
                "MSH-30",
                "uniform",
                value="beside boundary_count",
                allowed="one of the two",
                path=f"{frame.path}.uniform",
            )
        cells = frame.uniform
        if cells is None and not frame.boundary_count:
            cells = self._cells_of(frame)
        if cells is None:
            assert frame.boundary_count or frame.triangles is not None
            return delaunay_geometry(frame.nodes, frame.boundary_count or self._boundary_count_of(frame))
        self._check_count(frame, cells[0] * cells[1], self._limits.mesh_nodes_uniform)
        xs, ys = uniform_positions(*cells[:4])
        for node, place in enumerate(zip(xs, ys, strict=True)):
            if node >= len(frame.nodes) or frame.nodes[node] != place:
                break
        else:
            node = len(xs)
        if node < len(xs) or len(frame.nodes) > len(xs):
            found = f"{frame.nodes[node]}" if node < len(frame.nodes) else f"{len(frame.nodes)} nodes"
            wanted = f"({xs[node]}, {ys[node]})" if node < len(xs) else f"{len(xs)} nodes"
            raise InconsistentSemantics(
                "MSH-6", "node of a uniform mesh", value=found, allowed=wanted, path=f"{frame.path}.nodes[{node}]"
            )
        return uniform_geometry(cells)

    def _cells_of(self, frame: DocumentFrame) -> tuple[int, int, int, int, int] | None:
        """The cells of nodes that stand like those of a uniform mesh; no polygon could run that way."""
        nodes = frame.nodes
        hor = 0
        while hor < len(nodes) and nodes[hor][1] == 0:
            hor += 1
        if not 2 <= hor <= MAX_NODES_PER_SIDE or len(nodes) % hor or len(nodes) < 2 * hor:
            return None
        vert = len(nodes) // hor
        width, height = nodes[1][0], nodes[hor][1]
        if vert > MAX_NODES_PER_SIDE or not (1 <= width <= MAX_CELL_SIZE and 1 <= height <= MAX_CELL_SIZE):
            return None
        xs, ys = uniform_positions(hor, vert, width, height)
        if list(nodes) != list(zip(xs, ys, strict=True)):
            return None
        given = sorted(frame.triangles or ())
        for split in range(4):
            state = MeshState(self._state.readings)
            state.set_geometry(uniform_geometry((hor, vert, width, height, split)))
            assert state.topology is not None
            if sorted(state.topology.triangles) == given:
                return hor, vert, width, height, split
        raise InconsistentSemantics(
            "MSH-7", "triangles", value=f"{len(given)} triangles", allowed="those of one split code",
            path=f"{frame.path}.triangles",
        )  # fmt: skip

    def _boundary_count_of(self, frame: DocumentFrame) -> int:
        """How many edges belong to one triangle only; the first so many nodes are then the polygon."""
        edges: set[tuple[int, int]] = set()
        for triangle in frame.triangles or ():
            for k in range(3):
                a, b = triangle[k], triangle[(k + 1) % 3]
                if (b, a) in edges:
                    edges.remove((b, a))
                else:
                    edges.add((a, b))
        if not 3 <= len(edges) <= min(len(frame.nodes), _MAX_BOUNDARY_NODES):
            raise RangeViolation(
                "MSH-38", "boundary edges of the triangles", value=len(edges),
                allowed=f"3..{min(len(frame.nodes), _MAX_BOUNDARY_NODES)}", path=f"{frame.path}.triangles",
            )  # fmt: skip
        return len(edges)

    def _check_count(self, frame: DocumentFrame, count: int, limit: int) -> None:
        if count > limit:
            raise ResourceLimit("CNF-22", "nodes of the mesh", value=count, allowed=f"at most {limit}", path=frame.path)

    def _check_delaunay(self, frame: DocumentFrame, geometry: MeshGeometry) -> None:
        """Everything that the syntax demands of the nodes, with the path of the first one at fault."""
        nodes = frame.nodes
        path = f"{frame.path}.nodes"
        self._check_count(frame, len(nodes), self._limits.mesh_nodes_delaunay)
        if not 3 <= geometry.boundary_count <= len(nodes):
            raise RangeViolation(
                "MSH-38", "boundary_count", value=geometry.boundary_count, allowed=f"3..{len(nodes)}",
                path=f"{frame.path}.boundary_count",
            )  # fmt: skip
        fault = first_fault(geometry.xs, geometry.ys, geometry.boundary_count)
        worst: SnhcError | None = None
        at = len(nodes) if fault is None else fault.node
        for node, (x, y) in enumerate(nodes[: at + 1]):
            before = nodes[node - 1] if node else (0, 0)
            most = _MAX_DELTA if node else _NODE0
            steps = (x - before[0], y - before[1])
            if not all(NODE_MIN <= v <= NODE_MAX for v in (x, y)):
                worst = RangeViolation(
                    "MSH-24", "node position", value=f"({x}, {y})", allowed=f"{NODE_MIN}..{NODE_MAX} half pixels"
                )
            elif not all(-most <= v <= most - (node == 0) for v in steps):
                worst = RangeViolation(
                    "MSH-5" if node else "MSH-39", "step to the node" if node else "node 0", value=f"{steps}",
                    allowed=f"-{most}..{most - (node == 0)} half pixels",
                )  # fmt: skip
            if worst is not None:
                worst.path = f"{path}[{node}]"
                raise worst
        if fault is not None:
            raise InconsistentSemantics(
                "MSH-11", f"node {fault.node}", value=f"{nodes[fault.node]}",
                allowed=f"a simple polygon around the nodes, not a {fault.kind}", path=f"{path}[{fault.node}]",
            )  # fmt: skip

    def _check_topology(self, frame: DocumentFrame) -> None:
        topology = self._state.topology
        assert topology is not None
        if frame.triangles is not None:
            _same("MSH-8", "triangle", frame.triangles, topology.triangles, f"{frame.path}.triangles")
        if frame.order is not None:
            _same("MSH-21", "order", frame.order, topology.order, f"{frame.path}.order")


def _same(rule: str, what: str, given: Sequence[object], canonical: Sequence[object], path: str) -> None:
    if len(given) != len(canonical):
        raise InconsistentSemantics(
            rule, f"number of {what}s" if what == "triangle" else what, value=len(given),
            allowed=f"{len(canonical)}", expected=len(canonical), path=path,
        )  # fmt: skip
    for k, (ours, theirs) in enumerate(zip(canonical, given, strict=True)):
        if ours != theirs:
            raise InconsistentSemantics(
                rule, what, value=f"{theirs}", allowed=f"the canonical {ours}", path=f"{path}[{k}]"
            )


def encode_frames(
    frames: Iterable[DocumentFrame],
    *,
    far: str = "error",
    readings: Readings = DEFAULT_READINGS,
    limits: Limits = DEFAULT_LIMITS,
) -> list[MeshPlane]:
    """The planes of a document, without temporal headers. Rules: MSH-2..16, CNF-1. Raises as `MeshEncoder.plane`."""
    encoder = MeshEncoder(far=far, readings=readings, limits=limits)
    return [encoder.plane(frame) for frame in frames]
