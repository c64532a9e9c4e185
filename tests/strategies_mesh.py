"""Whole mesh streams as records, made from the rules of the specification alone."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from hypothesis import strategies as st
from properties.mesh_shapes import geometries

from snhc.reference_impl.mesh.motion import VectorCode
from snhc.reference_impl.mesh.records import MeshMotion, MeshPlane
from snhc.reference_impl.systems.visual import StreamItem
from snhc.vectors.builders import end_code
from snhc.vectors.mesh_builders import delaunay, mesh_object, still, uniform


@dataclass
class MeshStream:
    """`items`: what is written. `sized`: a second parser that knows no end of user data can read it."""

    items: list[StreamItem]
    sized: bool

    @property
    def planes(self) -> list[MeshPlane]:
        assert self.items[0].mesh is not None
        return self.items[0].mesh.planes


@st.composite
def uniform_planes(draw: st.DrawFn) -> MeshPlane:
    sides = st.one_of(st.integers(2, 6), st.integers(2, 40))
    hor = draw(sides)
    vert = draw(st.integers(2, max(2, 80 // hor)))
    return uniform(hor, vert, draw(st.integers(1, 255)), draw(st.integers(1, 255)), draw(st.integers(0, 3)))


@st.composite
def delaunay_planes(draw: st.DrawFn) -> MeshPlane:
    """Random simple polygons and outlines of columns, at any scale and place that the steps allow."""
    nodes, boundary_count = draw(geometries())
    reach = max(max(abs(x), abs(y)) for x, y in nodes)
    scale = draw(st.one_of(st.just(1), st.integers(1, max(1, 2047 // (2 * reach + 1)))))
    x0, y0 = draw(st.tuples(st.integers(-2000, 2000), st.integers(-2000, 2000)))
    return delaunay([(x0 + x * scale, y0 + y * scale) for x, y in nodes], boundary_count)


@st.composite
def motion_planes(draw: st.DrawFn, count: int) -> MeshPlane:
    """Any codes that the syntax has; decoding wraps them into the range."""
    plane = MeshPlane()
    plane.mesh_mask = 1
    plane.motion = MeshMotion()
    plane.motion.range_code = draw(st.integers(1, 7))
    rng = Random(draw(st.integers(0, 2**32)))
    most = draw(st.sampled_from((2, 8, 32)))
    zero = draw(st.sampled_from((0.0, 0.3, 1.0)))
    top = (1 << (plane.motion.range_code - 1)) - 1

    def component() -> tuple[int, int]:
        vlc = rng.randint(-most, most)
        return vlc, rng.randint(0, top) if vlc else 0

    for _ in range(count):
        flag = rng.random() < zero
        plane.motion.codes.append(VectorCode(1) if flag else VectorCode(0, *component(), *component()))
    return plane


@st.composite
def _headers(draw: st.DrawFn, plane: MeshPlane) -> None:
    h = plane.header
    if plane.is_intra:
        if draw(st.booleans()):
            h.is_frame_rate = 1
            h.frame_rate = draw(st.integers(0, 255))
            h.seconds = draw(st.integers(0 if h.frame_rate else 1, 15))
            h.frequency_offset = draw(st.integers(0, 1))
        if draw(st.booleans()):
            h.is_time_code = 1
            h.time_code_hours = draw(st.integers(0, 23))
            h.time_code_minutes = draw(st.integers(0, 59))
            h.time_code_seconds = draw(st.integers(0, 59))
    if draw(st.booleans()):
        h.skip_frames = 1
        h.number_of_frames_to_skip = draw(st.one_of(st.integers(0, 50), st.sampled_from((15, 30, 45, 1000))))


def _node_count(plane: MeshPlane) -> int:
    geometry = plane.geometry
    assert geometry is not None
    return len(geometry.xs) if geometry.xs else geometry.nodes_hor * geometry.nodes_vert


_CONTENT = st.binary(max_size=6).filter(lambda content: b"\0\0\1" not in content and content[:1] != b"\1")


@st.composite
def mesh_streams(draw: st.DrawFn) -> MeshStream:
    """Geometry of both kinds, motion of all ranges, planes without data, every temporal header, every end."""
    planes: list[MeshPlane] = []
    nodes = -1
    for _ in range(draw(st.integers(1, 6))):
        kinds = ["uniform", "delaunay", "still"] + ["motion"] * 3 * (nodes >= 0)
        kind = draw(st.sampled_from(kinds))
        if kind == "uniform":
            plane = draw(uniform_planes())
        elif kind == "delaunay":
            plane = draw(delaunay_planes())
        elif kind == "motion":
            plane = draw(motion_planes(nodes))
        else:
            plane = still(draw(st.integers(0, 1)))
        if plane.geometry is not None:
            nodes = _node_count(plane)
        draw(_headers(plane))
        plane.user_data = draw(st.lists(_CONTENT, max_size=2)) if draw(st.booleans()) else []
        planes.append(plane)
    stuffing = draw(st.integers(0, 1))
    if draw(st.booleans()):
        return MeshStream([mesh_object(planes, stuffing=stuffing), end_code()], True)
    padding = 8 * draw(st.integers(0, 4))
    if padding:
        # User data would swallow the zeros.
        planes[-1].user_data = []
    return MeshStream([mesh_object(planes, stuffing=stuffing, padding=padding)], not planes[-1].user_data)
