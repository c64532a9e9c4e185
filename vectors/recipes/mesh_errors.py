"""Mesh streams with one fault each."""

from __future__ import annotations

from collections.abc import Sequence

from snhc.reference_impl.bitstream.errors import (
    ForbiddenValue,
    InconsistentSemantics,
    MarkerBit,
    RangeViolation,
    ReservedValue,
    ResourceLimit,
    SnhcError,
    Truncated,
)
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import trace_stream, write_faulty
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import trailing
from ..manifest import CONCEAL, REJECT, DecodeOptions
from ..mesh_builders import Point, coded, delaunay, mesh_object, mesh_stream, mesh_timed, moved, still, uniform
from ..recipe import Reject, family, vector

_MESH = ("mesh",)
_NODES: list[Point] = [(0, 0), (61, -7), (83, 40), (41, 73), (-13, 50), (33, 30)]


def _uniform() -> list[StreamItem]:
    first = uniform(3, 2, 20, 16, 0)
    return mesh_stream(first, moved(first, {1: (3, -2), 4: (-7, 5)}), still())


def _delaunay() -> list[StreamItem]:
    first = delaunay(_NODES, 5)
    return mesh_stream(first, moved(first, {0: (2, 1), 5: (5, 4)}), still())


@family(
    {
        "0": (0, ForbiddenValue), "3": (3, ReservedValue),
    },
    id="mesh.error.type.{case}",
    title="mesh_type_code {case}",
    tier="error",
    rules=["MSH-30"],
    features=["mesh-uniform"],
    tools=_MESH,
)  # fmt: skip
def type_code(case: tuple[int, type[SnhcError]]) -> Reject:
    """mesh_type_code {case} is no kind of mesh."""
    return Reject(_uniform(), case[1], "MSH-30", (Mutation("mesh_type_code", "wire", case[0]),))


@family(
    {
        "columns 1": ("nr_of_mesh_nodes_hor", 1, "MSH-31"),
        "columns 0": ("nr_of_mesh_nodes_hor", 0, "MSH-31"),
        "rows 1": ("nr_of_mesh_nodes_vert", 1, "MSH-32"),
        "cell width 0": ("mesh_rect_size_hor", 0, "MSH-34"),
        "cell height 0": ("mesh_rect_size_vert", 0, "MSH-35"),
    },
    id="mesh.error.uniform.{case}",
    title="Uniform mesh, {case}",
    tier="error",
    rules=["MSH-11"],
    features=["mesh-uniform"],
    tools=_MESH,
)
def uniform_range(case: tuple[str, int, str]) -> Reject:
    """Too few nodes, or cells without extent: {case}."""
    return Reject(_uniform(), RangeViolation, case[2], (Mutation(case[0], "wire", case[1]),))


@family(
    {
        "nodes 2": ("nr_of_mesh_nodes", 2, "MSH-37"),
        "nodes 0": ("nr_of_mesh_nodes", 0, "MSH-37"),
        "boundary nodes 2": ("nr_of_boundary_nodes", 2, "MSH-38"),
        "boundary nodes 7 of 6": ("nr_of_boundary_nodes", 7, "MSH-38"),
    },
    id="mesh.error.delaunay.{case}",
    title="Delaunay mesh, {case}",
    tier="error",
    rules=["MSH-11"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def delaunay_range(case: tuple[str, int, str]) -> Reject:
    """Counts that make no polygon: {case}."""
    return Reject(_delaunay(), RangeViolation, case[2], (Mutation(case[0], "wire", case[1]),))


@family(
    {"behind N": 0, "behind Nb": 1, "behind node0_x": 2, "behind node0_y": 3},
    id="mesh.error.marker.{case}",
    title="Marker {case} is 0",
    tier="error",
    rules=["MSH-33"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def marker(which: int) -> Reject:
    """The marker {case} of a Delaunay geometry is 0."""
    mutation = Mutation("marker_bit", "wire", 0, occurrence=which)
    return Reject(_delaunay(), MarkerBit, "MSH-33", (mutation,), allowed=(REJECT, CONCEAL))


@vector(
    id="mesh.error.marker.uniform",
    title="Marker of a uniform geometry is 0",
    tier="error",
    rules=["MSH-33"],
    features=["mesh-uniform"],
    tools=_MESH,
)
def uniform_marker() -> Reject:
    """The only marker of a uniform geometry is 0."""
    mutation = Mutation("marker_bit", "wire", 0)
    return Reject(_uniform(), MarkerBit, "MSH-33", (mutation,), allowed=(REJECT, CONCEAL))


def _first_bit(items: list[StreamItem], element: str, occurrence: int = 0) -> int:
    """Where an element stands in the stream as it is without faults."""
    for part in trace_stream(write_faulty(items, [])):
        for name, start, _, _, _ in part.trace.rows():
            if name.name == element:
                if occurrence == 0:
                    return start
                occurrence -= 1
    raise TypeError(f"{element} is not in the stream")


@family(
    {"delta_x_len_vlc": 0, "delta_y_len_vlc": 0},
    id="mesh.error.word.{case}",
    title="A word that is no length: {case}",
    tier="error",
    rules=["MSH-5"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def no_length(occurrence: int) -> Reject:
    """1111111110 at the first length of a node. The longest word has nine bits: so many are looked at."""
    element = "delta_x_len_vlc"
    start = _first_bit(_delaunay(), element, occurrence)
    mutation = Mutation(element, "word", 0b1111111110, occurrence=occurrence, width=10)
    return Reject(_delaunay(), ReservedValue, "MSH-5", (mutation,), (start, start + 9))


@family(
    {"delta_mv_x_vlc": "delta_mv_x_vlc", "delta_mv_y_vlc": "delta_mv_y_vlc"},
    id="mesh.error.word.{case}",
    title="A word that is no vector: {case}",
    tier="error",
    rules=["MSH-5", "MSH-41"],
    features=["mesh-motion"],
    tools=_MESH,
)
def no_vector(element: str) -> Reject:
    """Thirteen zero bits at the first {case}."""
    return Reject(_uniform(), ReservedValue, "MSH-41", (Mutation(element, "word", 0, width=13),))


@vector(
    id="mesh.error.motion.range-0",
    title="motion_range_code 0",
    tier="error",
    rules=["MSH-40"],
    features=["mesh-motion"],
    tools=_MESH,
)
def range_0() -> Reject:
    """motion_range_code 0 is forbidden."""
    return Reject(_uniform(), ForbiddenValue, "MSH-40", (Mutation("motion_range_code", "wire", 0),))


@vector(
    id="mesh.error.motion.first",
    title="Motion before geometry",
    tier="error",
    rules=["MSH-4"],
    features=["mesh-motion"],
    tools=_MESH,
)
def motion_first() -> Reject:
    """The first plane with data is an inter plane, behind an intra plane without data."""
    items = mesh_stream(still(1), coded(1, []))
    start = _second_plane(items)
    return Reject(items, InconsistentSemantics, "MSH-4", bits=(start, start + 1))


def _second_plane(items: list[StreamItem]) -> int:
    """The bit behind the start code of the second plane."""
    data = write_faulty(items, [])
    return 8 * (data.index(b"\x00\x00\x01\xbd", 8) + 4)


@family(
    {"all ones": 0b11, "zero in the middle": 0b10, "all zero": 0b00},
    id="mesh.error.stuffing.{case}",
    title="Wrong stuffing, {case}",
    tier="error",
    rules=["MSH-2", "FBA-3"],
    features=["stuffing"],
    tools=_MESH,
)
def wrong_stuffing(bits: int) -> Reject:
    """The two bits behind a uniform geometry are not 01: {case}."""
    return Reject(_uniform(), ForbiddenValue, "FBA-3", (Mutation("stuffing", "wire", bits),), allowed=(REJECT, CONCEAL))


@vector(
    id="mesh.error.stuffing.byte",
    title="A wrong byte of stuffing",
    tier="error",
    rules=["MSH-2", "FBA-3"],
    features=["stuffing"],
    tools=_MESH,
)
def wrong_byte() -> Reject:
    """The plane ends on a byte; FF instead of 7F stands before the next start code."""
    plane = mesh_timed(still(1), rate=(25, 0, 0), time=(0, 0, 1), skip=0)
    mutation = Mutation("stuffing", "wire", 0xFF)
    return Reject(mesh_stream(plane, still()), ForbiddenValue, "FBA-3", (mutation,), allowed=(REJECT, CONCEAL))


@family(
    {"behind the object code": b"", "behind a plane": b"x"},
    id="mesh.error.no-start-code.{case}",
    title="No start code {case}",
    tier="error",
    rules=["MSH-25"],
    features=["start-codes"],
    tools=_MESH,
)
def no_start_code(case: bytes) -> Reject:
    """Bytes that are no start code stand {case}, where only a plane, another object or the end may follow."""
    planes = [uniform(2, 2, 4, 4)] if case else []
    data = write_faulty([mesh_object(planes)], [])
    return Reject(
        data + b"\x12\x34\x56\x78\x9a", ForbiddenValue, "MSH-25", bits=(8 * len(data), 8 * len(data) + 32),
        allowed=(REJECT, CONCEAL),
    )  # fmt: skip


@vector(
    id="mesh.error.strict.trailing",
    title="Bytes behind the end code",
    tier="error",
    rules=["FBA-3"],
    features=["trailing-data"],
    tools=_MESH,
    options=DecodeOptions(strict=True),
)
def trailing_strict() -> Reject:
    """Under --strict nothing may stand behind the end."""
    from snhc.reference_impl.bitstream.errors import TrailingData

    items = [*mesh_stream(uniform(2, 2, 4, 4)), trailing(b"more")]
    size = len(write_faulty(items, []))
    return Reject(items, TrailingData, "FBA-3", bits=(8 * size - 32, 8 * size))


# -- polygons ----------------------------------------------------------------------------------------------------------


def node_spans(plane: MeshPlane) -> list[tuple[int, int]]:
    """Where the nodes of a geometry stand in a stream of this plane alone. Rules: MSH-11, MSH-24.

    Only the writer knows: the stream need not decode.
    """
    spans: list[tuple[int, int]] = []
    assert plane.geometry is not None
    for node in range(len(plane.geometry.xs)):
        names = ("delta_x_len_vlc", "delta_y_len_vlc", "delta_x", "delta_y") if node else ("node0_x", "node0_y")
        mutations = [Mutation(name, "flip", 0, path=f"plane[0].geometry.node[{node}]") for name in names]
        write_faulty(mesh_stream(plane), mutations)
        bits = [bit for mutation in mutations for span in mutation.spans for bit in span]
        spans.append((min(bits), max(bits)))
    return spans


_SQUARE: list[Point] = [(0, 0), (40, 0), (40, 40), (0, 40)]


@family(
    {
        "crossing": ([(0, 0), (40, 40), (40, 0), (0, 30)], 4, 3),
        "crossing of the closing edge": ([(0, 0), (30, 0), (30, 30), (20, -20), (60, 10)], 5, 3),
        "node on an edge": ([(0, 0), (40, 0), (40, 40), (20, 0), (0, 40)], 5, 3),
        "edge over a node": ([(0, 0), (20, 20), (0, 40), (40, 40), (10, 10), (-9, 8)], 6, 4),
        "spike": ([(0, 0), (40, 0), (10, 0), (10, 40)], 4, 2),
        "repeated boundary node": ([(0, 0), (40, 0), (40, 40), (40, 0), (0, 40)], 5, 3),
        "repeated interior node": ([*_SQUARE, (7, 8), (9, 9), (7, 8)], 4, 6),
        "zero area": ([(0, 0), (20, 0), (40, 0)], 3, 2),
        "node outside": ([*_SQUARE, (7, 8), (41, 20), (9, 9)], 4, 5),
        "node on the polygon": ([*_SQUARE, (7, 8), (40, 20), (41, 1)], 4, 5),
        "repeated node next to it": ([(1, 0), (2, 2), (2, 2)], 3, 2),
        "spike at the first node": ([(2, 1), (1, 1), (1, 2), (0, 1)], 4, 3),
        "two nodes outside": ([(7, 34), (31, 27), (20, 34), (39, 4), (3, 12)], 3, 3),
        "node level with an edge": ([(3, 2), (4, 6), (5, 6), (0, 6)], 3, 3),
    },
    id="mesh.error.polygon.{case}",
    title="Faulty polygon: {case}",
    tier="error",
    rules=["MSH-11"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def polygon(case: tuple[Sequence[Point], int, int]) -> Reject:
    """{case}: the fault is at the first node with which the nodes so far show it."""
    nodes, boundary_count, node = case
    plane = delaunay(nodes, boundary_count)
    return Reject(mesh_stream(plane), InconsistentSemantics, "MSH-11", bits=node_spans(plane)[node])


@vector(
    id="mesh.error.polygon.before-a-truncation",
    title="A faulty polygon, and then the data ends",
    tier="error",
    rules=["MSH-11"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def before_truncation() -> Reject:
    """Two nodes of six hundred announced ones cross; the data ends far before the last: the fault comes first."""
    plane = delaunay([(0, 0), (40, 40), (40, 0), (0, 30), (-9, 30), (-9, 20)])
    spans = node_spans(plane)
    data = write_faulty(
        mesh_stream(plane),
        [
            Mutation("nr_of_mesh_nodes", "wire", 600),
            Mutation("nr_of_boundary_nodes", "wire", 500),
            Mutation("delta_y", "cut", 1, path="plane[0].geometry.node[5]"),
        ],
    )
    return Reject(data, InconsistentSemantics, "MSH-11", bits=spans[3])


@vector(
    id="mesh.error.node-range",
    title="A node beyond 16383 half pixels",
    tier="error",
    rules=["MSH-24"],
    features=["mesh-delaunay"],
    value_classes=["above-max"],
    tools=_MESH,
)
def node_range() -> Reject:
    """Seven steps of nearly 1024 pixels lead to x = 16384."""
    nodes: list[Point] = [(4095, 0)]
    while len(nodes) < 7:
        nodes.append((nodes[-1][0] + 2047, 0))
    nodes += [(16384, 9), *((x, 700) for x in range(15000, 4095, -2000))]
    plane = delaunay(nodes)
    return Reject(mesh_stream(plane), RangeViolation, "MSH-24", bits=node_spans(plane)[7])


# -- truncation and limits ---------------------------------------------------------------------------------------------


@family(
    {
        "nr_of_mesh_nodes_hor": ("nr_of_mesh_nodes_hor", 0, "MSH-31", 1),
        "nr_of_mesh_nodes_vert": ("nr_of_mesh_nodes_vert", 0, "MSH-32", 7),
        "mesh_rect_size_vert": ("mesh_rect_size_vert", 0, "MSH-35", 4),
        "nr_of_mesh_nodes": ("nr_of_mesh_nodes", 0, "MSH-37", 9),
        "nr_of_boundary_nodes": ("nr_of_boundary_nodes", 0, "MSH-38", 8),
        "node0_x": ("node0_x", 0, "MSH-39", 5),
        "node0_y": ("node0_y", 0, "MSH-39", 7),
    },
    id="mesh.error.truncated.{case}",
    title="The data ends inside {case}",
    tier="error",
    rules=["MSH-11"],
    features=["truncation"],
    tools=_MESH,
)
def truncated(case: tuple[str, int, str, int]) -> Reject:
    """The data ends inside {case}, at the end of a byte."""
    element, occurrence, rule, bits = case
    items = _uniform() if rule in ("MSH-31", "MSH-32", "MSH-34", "MSH-35") else _delaunay()
    mutation = Mutation(element, "cut", bits, occurrence=occurrence)
    return Reject(items, Truncated, rule, (mutation,))


@family(
    {name: name for name in ("delta_x_len_vlc", "delta_x", "delta_y_len_vlc", "delta_y")}
    | {name: name for name in ("delta_mv_x_vlc", "delta_mv_x_res", "delta_mv_y_vlc", "delta_mv_y_res")},
    id="mesh.error.truncated.{case}",
    title="The data ends inside {case}",
    tier="error",
    rules=["MSH-5", "MSH-41"],
    features=["truncation"],
    tools=_MESH,
)
def truncated_node(element: str) -> Reject:
    """The data ends inside the {case} of some node, at the end of a byte."""
    first = delaunay([(0, 0), (611, -70), (831, 400), (410, 731), (-131, 501), (333, 30), (40, 52), (91, 33)], 5)
    motion = moved(first, {k: (201 - 57 * k, 91 * k - 330) for k in range(8)})
    items = mesh_stream(first, motion)
    for part in trace_stream(write_faulty(items, [])):
        for name, start, end, _, _ in part.trace.rows():
            # The first byte that ends inside one of them.
            cut = (start // 8 + 1) * 8
            if name.name == element and start < cut < end:
                data = write_faulty(items, [])[: cut // 8]
                return Reject(data, Truncated, name.rule, bits=(start, cut))
    raise TypeError(f"no byte ends inside {element}")


@vector(
    id="mesh.error.limit.uniform",
    title="More nodes than the limit allows",
    tier="error",
    rules=["CNF-22"],
    features=["mesh-uniform", "limits"],
    tools=_MESH,
    options=DecodeOptions(limits={"mesh_nodes_uniform": 5}),
)
def limit_uniform() -> Reject:
    """Six nodes where five are allowed: the fault is at the second count."""
    start = _first_bit(_uniform(), "nr_of_mesh_nodes_vert")
    return Reject(_uniform(), ResourceLimit, "CNF-22", bits=(start, start + 10))


@vector(
    id="mesh.error.hostile.many-nodes",
    title="65,535 nodes in forty bytes",
    tier="error",
    rules=["MSH-37", "CNF-22"],
    features=["mesh-delaunay", "truncation"],
    tools=_MESH,
)
def hostile() -> Reject:
    """A decoder that takes memory by the count, before it reads, is easily made to fail."""
    head = f"{0x1BC:032b}{0x1BD:032b}11000" + "10" + "1" * 16 + "1" + "1" * 10 + "1" + "0" * 13 + "1" + "0" * 13 + "1"
    # Steps of (+1, -1) half pixels, 0101 0100, then of (+1, +1), 0101 0101: two straight lines without a fault.
    bits = (head + "01010100" * 3 + "01010101" * 30)[:320]
    data = int(bits, 2).to_bytes(40, "big")
    return Reject(data, Truncated, "MSH-5", bits=(319, 320))
