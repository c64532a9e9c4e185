"""Builders of mesh planes and streams for recipes and tests.

Rules: MSH-1..3, MSH-5, MSH-12..15, MSH-30..41, FBA-6..8.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from snhc.reference_impl.bitstream.startcodes import MESH_OBJECT
from snhc.reference_impl.mesh.encode import delaunay_geometry, geometry_plane, motion_plane, uniform_geometry
from snhc.reference_impl.mesh.motion import VectorCode
from snhc.reference_impl.mesh.records import MeshMotion, MeshObject, MeshPlane
from snhc.reference_impl.mesh.state import MeshState
from snhc.reference_impl.mesh.topology import MeshTopology
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings
from snhc.reference_impl.systems.visual import StreamItem

from .builders import end_code
from .seeded import Seeded

Point = tuple[int, int]


def mesh_timed(
    plane: MeshPlane,
    *,
    rate: tuple[int, int, int] | None = None,
    time: tuple[int, int, int] | None = None,
    skip: int | None = None,
) -> MeshPlane:
    """Set the temporal header of a mesh plane, as `builders.timed`. Rules: FBA-6, FBA-7, FBA-8."""
    h = plane.header
    if rate is not None:
        h.is_frame_rate = 1
        h.frame_rate, h.seconds, h.frequency_offset = rate
    if time is not None:
        h.is_time_code = 1
        h.time_code_hours, h.time_code_minutes, h.time_code_seconds = time
    if skip is not None:
        h.skip_frames = 1
        h.number_of_frames_to_skip = skip
    return plane


def uniform(nodes_hor: int, nodes_vert: int, rect_hor: int, rect_vert: int, split_code: int = 0) -> MeshPlane:
    """An intra plane with a uniform mesh. Rules: MSH-31..36."""
    return geometry_plane(uniform_geometry((nodes_hor, nodes_vert, rect_hor, rect_vert, split_code)))


def delaunay(nodes: Sequence[Point], boundary_count: int | None = None) -> MeshPlane:
    """An intra plane with a Delaunay mesh; all nodes are boundary nodes unless said otherwise. Rules: MSH-37..39."""
    return geometry_plane(delaunay_geometry(nodes, len(nodes) if boundary_count is None else boundary_count))


def still(is_intra: int = 0) -> MeshPlane:
    """A plane without data. Rules: MSH-3."""
    plane = MeshPlane()
    plane.is_intra = is_intra
    return plane


def topology_of(plane: MeshPlane, readings: Readings = DEFAULT_READINGS) -> MeshTopology:
    """Triangles and node order of a geometry plane. Rules: MSH-6..9, MSH-18..21."""
    state = MeshState(readings)
    assert plane.geometry is not None
    state.set_geometry(plane.geometry)
    assert state.topology is not None
    return state.topology


def moved(
    geometry: MeshPlane,
    vectors: Mapping[int, Point],
    range_code: int | None = None,
    readings: Readings = DEFAULT_READINGS,
) -> MeshPlane:
    """An inter plane that moves nodes of the mesh of `geometry`; the others get the zero vector.

    Rules: MSH-12..16. `vectors`: by node. `range_code`: None for the smallest that fits.
    """
    topology = topology_of(geometry, readings)
    vx = [vectors.get(node, (0, 0))[0] for node in range(len(topology.order))]
    vy = [vectors.get(node, (0, 0))[1] for node in range(len(topology.order))]
    return motion_plane(topology, vx, vy, range_code)


def coded(range_code: int, codes: Iterable[tuple[int, int, int, int] | None]) -> MeshPlane:
    """An inter plane from the codes themselves, in traversal order: vlc, res of x and y; None is the zero flag.

    Rules: MSH-40, MSH-41.
    """
    plane = MeshPlane()
    plane.mesh_mask = 1
    plane.motion = MeshMotion()
    plane.motion.range_code = range_code
    plane.motion.codes = [VectorCode(1) if code is None else VectorCode(0, *code) for code in codes]
    return plane


def mesh_object(planes: Iterable[MeshPlane], *, stuffing: int = 0, padding: int = 0) -> StreamItem:
    """A mesh object; `stuffing`, `padding` as in `MeshObject`. Rules: MSH-1, MSH-25."""
    item = StreamItem(MESH_OBJECT)
    item.mesh = MeshObject()
    item.mesh.planes = list(planes)
    item.mesh.stuffing = stuffing
    item.mesh.padding = padding
    return item


def mesh_stream(*planes: MeshPlane) -> list[StreamItem]:
    """The plain form: one mesh object, then the end code. Rules: MSH-1."""
    return [mesh_object(planes), end_code()]


def without_ties(nodes: Sequence[Point], boundary_count: int | None = None) -> MeshPlane:
    """A Delaunay geometry that has one triangulation only: vectors of kind valid hold no other. Rules: MSH-12."""
    plane = delaunay(nodes, boundary_count)
    other = Readings({"AMB-MSH-2": "other"})
    if sorted(topology_of(plane).triangles) != sorted(topology_of(plane, other).triangles):
        raise TypeError("co-circular nodes in a vector without ambiguity")
    return plane


def node_count(plane: MeshPlane) -> int:
    """How many nodes a geometry has. Rules: MSH-21."""
    return len(topology_of(plane).order)


def all_moved(geometry: MeshPlane, seed: int, reach: int, range_code: int | None = None) -> MeshPlane:
    """Every node moves, each in its own way. Rules: MSH-13."""
    numbers = Seeded(seed)
    vectors = {
        node: (numbers.between(-reach, reach), numbers.between(-reach, reach)) for node in range(node_count(geometry))
    }
    return moved(geometry, vectors, range_code)


def node_lines(frames: Sequence[Sequence[Point]]) -> dict[int, str]:
    """The nodes of some lines, as NDJSON has them. Rules: CNF-1."""
    return {k: '"nodes":[' + ",".join(f"[{x},{y}]" for x, y in nodes) + "]" for k, nodes in enumerate(frames) if nodes}
