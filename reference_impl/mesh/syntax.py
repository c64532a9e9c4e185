"""The syntax of mesh objects: every table once, for all machines.

Rules: MSH-1..5, MSH-11, MSH-13..17, MSH-24, MSH-25, MSH-30..41, FBA-3, SYS-5.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final

from ..bitstream.errors import (
    EncodeError,
    ForbiddenValue,
    InconsistentSemantics,
    RangeViolation,
    ReservedValue,
    ResourceLimit,
    SnhcError,
)
from ..bitstream.startcodes import MESH_OBJECT, MESH_OBJECT_PLANE, USER_DATA
from ..entropy.prefix import PrefixTable, shipped_table
from ..syntax.base import SyntaxIO
from ..syntax.element import Element, Fault, Step, marker
from ..syntax.framing import stuffing, user_data
from ..syntax.temporal import temporal_header
from .motion import MAX_POSITION, MIN_POSITION, VectorCode, decode_vector, foldovers, has_residual, predict
from .polygon import first_fault
from .records import DELAUNAY, UNIFORM, MeshGeometry, MeshMotion, MeshObject, MeshPlane
from .state import MeshState, reconstruct_mesh

MESH_OBJECT_START_CODE: Final = Element("mesh_object_start_code", "MSH-1", fixed=True)
MESH_OBJECT_PLANE_START_CODE: Final = Element("mesh_object_plane_start_code", "MSH-2", fixed=True)
OBJECT_STUFFING: Final = Element("stuffing", "MSH-2", fixed=True)
PADDING: Final = Element("zero_padding", "MSH-25")
IS_INTRA: Final = Element("is_intra", "MSH-2")
MESH_MASK: Final = Element("mesh_mask", "MSH-2", meaning={0: "no data", 1: "geometry (intra) or motion"})
MESH_TYPE_CODE: Final = Element("mesh_type_code", "MSH-30", meaning={1: "uniform", 2: "Delaunay"})
NODES_HOR: Final = Element("nr_of_mesh_nodes_hor", "MSH-31", lo=2, hi=1023, fault=RangeViolation)
NODES_VERT: Final = Element("nr_of_mesh_nodes_vert", "MSH-32", lo=2, hi=1023, fault=RangeViolation)
MARKER: Final = marker("MSH-33")
RECT_SIZE_HOR: Final = Element("mesh_rect_size_hor", "MSH-34", lo=1, hi=255, fault=RangeViolation)
RECT_SIZE_VERT: Final = Element("mesh_rect_size_vert", "MSH-35", lo=1, hi=255, fault=RangeViolation)
TRIANGLE_SPLIT_CODE: Final = Element(
    "triangle_split_code", "MSH-36",
    meaning={
        0: "top-left to bottom-right", 1: "bottom-left to top-right",
        2: "alternate, top-left to bottom-right first", 3: "alternate, bottom-left to top-right first",
    },
)  # fmt: skip
NR_OF_MESH_NODES: Final = Element("nr_of_mesh_nodes", "MSH-37", lo=3, hi=65535, fault=RangeViolation)
NR_OF_BOUNDARY_NODES: Final = Element("nr_of_boundary_nodes", "MSH-38", lo=3, hi=1023, fault=RangeViolation)
NODE0_X: Final = Element("node0_x", "MSH-39")
NODE0_Y: Final = Element("node0_y", "MSH-39")
DELTA_X_LEN: Final = Element("delta_x_len_vlc", "MSH-5")
DELTA_X: Final = Element("delta_x", "MSH-5")
DELTA_Y_LEN: Final = Element("delta_y_len_vlc", "MSH-5")
DELTA_Y: Final = Element("delta_y", "MSH-5")
MOTION_RANGE_CODE: Final = Element("motion_range_code", "MSH-40", lo=1, hi=7)
NODE_MOTION_VECTOR_FLAG: Final = Element(
    "node_motion_vector_flag", "MSH-41", meaning={0: "a vector follows", 1: "the zero vector"}
)
DELTA_MV_X_VLC: Final = Element("delta_mv_x_vlc", "MSH-41")
DELTA_MV_X_RES: Final = Element("delta_mv_x_res", "MSH-41")
DELTA_MV_Y_VLC: Final = Element("delta_mv_y_vlc", "MSH-41")
DELTA_MV_Y_RES: Final = Element("delta_mv_y_res", "MSH-41")

AT_PLANE: Final = Step("plane")
AT_GEOMETRY: Final = Step("geometry")
AT_MOTION: Final = Step("motion")
AT_NODE: Final = Step("node")

NODE_MIN: Final = -16384
NODE_MAX: Final = 16383

_MOTION_FIRST: Final = Fault(InconsistentSemantics, "MSH-4", "is_intra", "1, before any motion")
_TYPE_0: Final = Fault(ForbiddenValue, "MSH-30", "mesh_type_code", "1, 2")
_TYPE_3: Final = Fault(ReservedValue, "MSH-30", "mesh_type_code", "1, 2")
_NODE_LIMIT: Final = Fault(ResourceLimit, "CNF-22", "nodes of the mesh", "")
_NODE_RANGE: Final = Fault(RangeViolation, "MSH-24", "node position", f"{NODE_MIN}..{NODE_MAX} half pixels")
_MOVED_RANGE: Final = Fault(RangeViolation, "MSH-24", "moved position", f"{MIN_POSITION}..{MAX_POSITION} half pixels")
_MORE_BOUNDARY: Final = Fault(RangeViolation, "MSH-38", "nr_of_boundary_nodes", "")
_BROKEN_POLYGON: Final = Fault(InconsistentSemantics, "MSH-11", "node", "")
_VECTORS: Final = Fault(EncodeError, "MSH-21", "number of vectors", "")
_NO_CODE: Final = Fault(ForbiddenValue, "MSH-25", "start code", "a start code, or the end of the data")


@cache
def _lengths() -> PrefixTable:
    return shipped_table("mesh_delta_len", "MSH-5")


@cache
def _vectors() -> PrefixTable:
    return shipped_table("mvd", "MSH-41")


def mesh_object(io: SyntaxIO, obj: MeshObject, planes: Iterator[MeshPlane]) -> Iterator[MeshPlane]:
    """`mesh_object()`: the start code, then its planes one by one, each with its frame.

    Rules: MSH-1, MSH-2, MSH-25. `planes`: for a reader, fresh planes without end; for a writer, those to write.
    Leaves a following start code for the caller.
    """
    state = MeshState(io.readings)
    start = io.tell()
    io.u(MESH_OBJECT_START_CODE, 32, MESH_OBJECT)
    plane = next(planes, None)
    obj.stuffing = 1 if io.follows(0x7F, 8, bool(obj.stuffing)) else 0
    if obj.stuffing:
        begin = io.tell()
        io.u(OBJECT_STUFFING, 8, 0x7F)
        io.finding("object-stuffing", "a byte 0x7F behind the object start code", begin, begin + 8)
    index = 0
    more = _next_plane(io, obj, plane, not obj.stuffing)
    while more:
        assert plane is not None
        io.enter(AT_PLANE, index)
        mesh_object_plane(io, state, plane)
        plane.frames = reconstruct_mesh(state, plane)
        if plane.motion is not None and state.topology is not None:
            _report_foldovers(io, state, plane)
        following = next(planes, None)
        more = _end_of_plane(io, obj, plane, following)
        io.leave()
        yield plane
        plane = following
        index += 1
    if index == 0:
        io.finding("empty-object", "an object without planes", start, io.tell())


def _next_plane(io: SyntaxIO, obj: MeshObject, plane: MeshPlane | None, behind_object: bool = False) -> bool:
    """Whether a plane follows at this byte; else the object has ended well, or is at fault.

    Directly behind the object start code no other start code may follow (MSH-25).
    """
    if io.at_end(plane is None and not obj.padding):
        return False
    code = io.next_code(MESH_OBJECT_PLANE if plane is not None else -1 if obj.padding else 0)
    if code == MESH_OBJECT_PLANE:
        return True
    if code >= 0 and behind_object and io.reading:
        io.require(False, _NO_CODE, f"{code:08x}", io.tell(), io.tell() + 32)
    if code < 0:
        start = io.tell()
        if io.only_zeros_left(bool(obj.padding)):
            obj.padding = io.zeros(PADDING, obj.padding)
            io.finding("zero-padding", f"{obj.padding} zero bits to the end of the data", start, io.tell())
            return False
        io.require(False, _NO_CODE, io.head(4).hex(), start, start + io.bits_left(32))
    return False


def _end_of_plane(io: SyntaxIO, obj: MeshObject, plane: MeshPlane, following: MeshPlane | None) -> bool:
    start = io.tell()
    if start & 7 == 0 and io.at_end(not plane.stuffing):
        plane.stuffing = 0
        return False
    plane.stuffing = 1
    stuffing(io)
    count = 0
    while io.next_code(USER_DATA if count < len(plane.user_data) else 0) == USER_DATA:
        data = user_data(io, b"" if io.reading else plane.user_data[count])
        if io.reading:
            plane.user_data.append(data)
        count += 1
    return _next_plane(io, obj, following)


def mesh_object_plane(io: SyntaxIO, state: MeshState, plane: MeshPlane) -> None:
    """`mesh_object_plane()` up to its stuffing. Rules: MSH-2, MSH-3, MSH-4."""
    plane.start = io.tell()
    io.u(MESH_OBJECT_PLANE_START_CODE, 32, MESH_OBJECT_PLANE)
    start = io.tell()
    plane.is_intra = io.u(IS_INTRA, 1, plane.is_intra)
    plane.mesh_mask = io.u(MESH_MASK, 1, plane.mesh_mask)
    if plane.mesh_mask and not plane.is_intra:
        io.require(state.topology is not None, _MOTION_FIRST, 0, start, start + 1)
    temporal_header(io, plane.header, plane.is_intra)
    if plane.mesh_mask and plane.is_intra:
        if plane.geometry is None:
            plane.geometry = MeshGeometry()
        io.enter(AT_GEOMETRY, -1)
        # After a faulty geometry the faulty writer goes on with the mesh before it.
        if mesh_geometry(io, plane.geometry):
            state.set_geometry(plane.geometry)
        io.leave()
    elif plane.mesh_mask:
        if plane.motion is None:
            plane.motion = MeshMotion()
        io.enter(AT_MOTION, -1)
        mesh_motion(io, state, plane.motion)
        io.leave()
    plane.end = io.tell()


def mesh_geometry(io: SyntaxIO, geometry: MeshGeometry) -> bool:
    """`mesh_geometry()`; whether it makes a mesh, which machines that refuse faults need not ask.

    Rules: MSH-11, MSH-30..39.
    """
    start = io.tell()
    geometry.type = io.u(MESH_TYPE_CODE, 2, geometry.type)
    io.require(geometry.type != 0, _TYPE_0, geometry.type, start, start + 2)
    io.require(geometry.type != 3, _TYPE_3, geometry.type, start, start + 2)
    if geometry.type == UNIFORM:
        _uniform(io, geometry)
        return True
    return geometry.type == DELAUNAY and _delaunay(io, geometry)


def _uniform(io: SyntaxIO, geometry: MeshGeometry) -> None:
    geometry.nodes_hor = io.u(NODES_HOR, 10, geometry.nodes_hor)
    start = io.tell()
    geometry.nodes_vert = io.u(NODES_VERT, 10, geometry.nodes_vert)
    _check_count(io, geometry.nodes_hor * geometry.nodes_vert, io.limits.mesh_nodes_uniform, start)
    io.marker(MARKER)
    geometry.rect_hor = io.u(RECT_SIZE_HOR, 8, geometry.rect_hor)
    geometry.rect_vert = io.u(RECT_SIZE_VERT, 8, geometry.rect_vert)
    geometry.split_code = io.u(TRIANGLE_SPLIT_CODE, 2, geometry.split_code)


def _check_count(io: SyntaxIO, count: int, limit: int, start: int) -> None:
    if count > limit:
        io.require(False, _NODE_LIMIT.allowing(f"at most {limit}"), count, start, io.tell())


def _delaunay(io: SyntaxIO, geometry: MeshGeometry) -> bool:
    start = io.tell()
    count = io.u(NR_OF_MESH_NODES, 16, len(geometry.xs))
    _check_count(io, count, io.limits.mesh_nodes_delaunay, start)
    io.marker(MARKER)
    start = io.tell()
    geometry.boundary_count = io.u(NR_OF_BOUNDARY_NODES, 10, geometry.boundary_count)
    more = _MORE_BOUNDARY.allowing(f"3..{count}")
    io.require(geometry.boundary_count <= count, more, geometry.boundary_count, start, io.tell())
    io.marker(MARKER)
    spans: list[tuple[int, int]] = []
    try:
        in_range = _nodes(io, geometry, count, spans)
    except SnhcError:
        # A fault of the polygon further up comes first in the stream.
        io.leave()
        _check_polygon(io, geometry, spans)
        raise
    return _check_polygon(io, geometry, spans) and in_range


def _nodes(io: SyntaxIO, geometry: MeshGeometry, count: int, spans: list[tuple[int, int]]) -> bool:
    """Whether all nodes are in range; only the faulty writer gets to hear that they are not."""
    in_range = True
    xs, ys = geometry.xs, geometry.ys
    reading = io.reading
    io.enter(AT_NODE, 0)
    start = io.tell()
    x = io.s(NODE0_X, 13, 0 if reading else xs[0])
    io.marker(MARKER)
    y = io.s(NODE0_Y, 13, 0 if reading else ys[0])
    spans.append((start, io.tell()))
    if reading:
        xs.append(x)
        ys.append(y)
    io.marker(MARKER)
    io.leave()
    for n in range(1, count):
        io.enter(AT_NODE, n)
        start = io.tell()
        x += _delta(io, DELTA_X_LEN, DELTA_X, 0 if reading else xs[n] - x)
        y += _delta(io, DELTA_Y_LEN, DELTA_Y, 0 if reading else ys[n] - y)
        if not (NODE_MIN <= x <= NODE_MAX and NODE_MIN <= y <= NODE_MAX):
            io.require(False, _NODE_RANGE, f"({x}, {y})", start, io.tell())
            in_range = False
        spans.append((start, io.tell()))
        if reading:
            xs.append(x)
            ys.append(y)
        io.leave()
    return in_range


def _delta(io: SyntaxIO, length_element: Element, element: Element, value: int) -> int:
    length = io.vlc(length_element, _lengths(), abs(value).bit_length())
    if length == 0:
        return 0
    lowest = (1 << length) - 1
    code = io.u(element, length, value if value > 0 else value + lowest)
    return code if code >> (length - 1) else code - lowest


def _check_polygon(io: SyntaxIO, geometry: MeshGeometry, spans: list[tuple[int, int]]) -> bool:
    """Whether the nodes make a mesh; only the faulty writer gets to hear that they do not."""
    if len(geometry.xs) < 2:
        return False
    fault = first_fault(geometry.xs, geometry.ys, geometry.boundary_count)
    if fault is None:
        return True
    broken = _BROKEN_POLYGON.allowing(f"a simple polygon around the nodes, not a {fault.kind}", f"node {fault.node}")
    x, y = geometry.xs[fault.node], geometry.ys[fault.node]
    first, last = spans[fault.node] if fault.node < len(spans) else (io.tell(), io.tell())
    io.enter(AT_NODE, fault.node)
    io.require(False, broken, f"({x}, {y})", first, last)
    io.leave()
    return False


def mesh_motion(io: SyntaxIO, state: MeshState, motion: MeshMotion) -> None:
    """`mesh_motion()`: a vector per node, in traversal order. Rules: MSH-12..15, MSH-21, MSH-24, MSH-40, MSH-41."""
    motion.range_code = io.u(MOTION_RANGE_CODE, 3, motion.range_code)
    topology = state.topology
    if topology is None:
        return  # only the faulty writer: there is no mesh to move
    if not io.reading:
        vectors = _VECTORS.allowing(f"{len(topology.order)}")
        io.require(len(motion.codes) == len(topology.order), vectors, len(motion.codes), io.tell(), io.tell())
    range_code = motion.range_code
    xs, ys = state.xs, state.ys
    vx = [0] * len(xs)
    vy = [0] * len(xs)
    reading = io.reading
    for k, node in enumerate(topology.order):
        io.enter(AT_NODE, node)
        start = io.tell()
        code = VectorCode(1) if reading else motion.codes[k]
        _vector(io, code, range_code)
        if reading:
            motion.codes.append(code)
        if not code.zero:
            vx[node], vy[node] = decode_vector(code, predict(topology, k, vx, vy), range_code)
            x, y = xs[node] + vx[node], ys[node] + vy[node]
            if not (MIN_POSITION <= x <= MAX_POSITION and MIN_POSITION <= y <= MAX_POSITION):
                io.require(False, _MOVED_RANGE, f"({x}, {y})", start, io.tell())
        io.leave()
    state.vx, state.vy = vx, vy


def _vector(io: SyntaxIO, code: VectorCode, range_code: int) -> None:
    code.zero = io.u(NODE_MOTION_VECTOR_FLAG, 1, code.zero)
    if code.zero:
        return
    code.x_vlc = io.vlc(DELTA_MV_X_VLC, _vectors(), code.x_vlc)
    if has_residual(code.x_vlc, range_code):
        code.x_res = io.u(DELTA_MV_X_RES, range_code - 1, code.x_res)
    code.y_vlc = io.vlc(DELTA_MV_Y_VLC, _vectors(), code.y_vlc)
    if has_residual(code.y_vlc, range_code):
        code.y_res = io.u(DELTA_MV_Y_RES, range_code - 1, code.y_res)


def _report_foldovers(io: SyntaxIO, state: MeshState, plane: MeshPlane) -> None:
    assert state.topology is not None
    flipped = foldovers(state.xs, state.ys, state.topology.triangles)
    if flipped:
        triangle = state.topology.triangles[flipped[0]]
        io.finding(
            "foldover",
            f"{len(flipped)} triangles have flipped over, the first is {list(triangle)}",
            plane.start,
            plane.end,
        )
