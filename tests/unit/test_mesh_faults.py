"""Mesh streams: every fault at its own bits, truncation, limits, hostile input."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mesh_helpers import (
    EX1,
    EX2,
    check_mesh_input,
    cut_bits,
    decoded,
    node_spans,
    with_bits,
)

import snhc.reference_impl.mesh.polygon as polygon
from snhc.reference_impl.bitstream.cursor import BitCursor
from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    ForbiddenValue,
    InconsistentSemantics,
    MarkerBit,
    RangeViolation,
    ReservedValue,
    ResourceLimit,
    SnhcError,
    Truncated,
)
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.mesh.records import MeshMotion
from snhc.reference_impl.mesh.state import MeshState
from snhc.reference_impl.mesh.syntax import mesh_motion
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.syntax.reader import Reader
from snhc.reference_impl.systems.stream import Options, read_stream, trace_stream, write_faulty, write_stream
from snhc.vectors.mesh_builders import (
    coded,
    delaunay,
    mesh_stream,
    mesh_timed,
    moved,
    still,
    uniform,
)

# -- every fault at its own bits ---------------------------------------------------------------------------------------

MOTION_FIRST = bytes.fromhex("000001bc000001bd50000001b1")

WIRE_FAULTS: dict[str, tuple[bytes, type[SnhcError], str, tuple[int, int]]] = {
    "type 00": (with_bits(EX1, 69, "00"), ForbiddenValue, "MSH-30", (69, 71)),
    "type 11": (with_bits(EX1, 69, "11"), ReservedValue, "MSH-30", (69, 71)),
    "no column": (with_bits(EX1, 71, "0" * 10), RangeViolation, "MSH-31", (71, 81)),
    "one column": (with_bits(EX1, 71, f"{1:010b}"), RangeViolation, "MSH-31", (71, 81)),
    "one row": (with_bits(EX1, 81, f"{1:010b}"), RangeViolation, "MSH-32", (81, 91)),
    "marker behind the rows": (with_bits(EX1, 91, "0"), MarkerBit, "MSH-33", (91, 92)),
    "cell width 0": (with_bits(EX1, 92, "0" * 8), RangeViolation, "MSH-34", (92, 100)),
    "cell height 0": (with_bits(EX1, 100, "0" * 8), RangeViolation, "MSH-35", (100, 108)),
    "stuffing 00": (with_bits(EX1, 110, "00"), ForbiddenValue, "FBA-3", (110, 112)),
    "stuffing 10": (with_bits(EX1, 110, "10"), ForbiddenValue, "FBA-3", (110, 112)),
    "stuffing 11": (with_bits(EX1, 110, "11"), ForbiddenValue, "FBA-3", (110, 112)),
    "stuffing of one bit": (with_bits(EX1, 215, "1"), ForbiddenValue, "FBA-3", (215, 216)),
    "no start code behind a plane": (with_bits(EX1, 112, "1"), ForbiddenValue, "MSH-25", (112, 144)),
    "two bytes behind a plane": (EX1[:14] + b"\xab\xcd", ForbiddenValue, "MSH-25", (112, 128)),
    "two nodes": (with_bits(EX2, 71, f"{2:016b}"), RangeViolation, "MSH-37", (71, 87)),
    "no nodes": (with_bits(EX2, 71, "0" * 16), RangeViolation, "MSH-37", (71, 87)),
    "marker behind N": (with_bits(EX2, 87, "0"), MarkerBit, "MSH-33", (87, 88)),
    "two boundary nodes": (with_bits(EX2, 88, f"{2:010b}"), RangeViolation, "MSH-38", (88, 98)),
    "more boundary nodes than nodes": (with_bits(EX2, 88, f"{7:010b}"), RangeViolation, "MSH-38", (88, 98)),
    "marker behind Nb": (with_bits(EX2, 98, "0"), MarkerBit, "MSH-33", (98, 99)),
    "marker behind node0_x": (with_bits(EX2, 112, "0"), MarkerBit, "MSH-33", (112, 113)),
    "marker behind node0_y": (with_bits(EX2, 126, "0"), MarkerBit, "MSH-33", (126, 127)),
    "no word of the lengths, x": (with_bits(EX2, 127, "1111111110"), ReservedValue, "MSH-5", (127, 136)),
    "no word of the lengths, y": (with_bits(EX2, 137, "1111111110"), ReservedValue, "MSH-5", (137, 146)),
    "motion range 0": (with_bits(EX1, 147, "000"), ForbiddenValue, "MSH-40", (147, 150)),
    "no word of the vectors, x": (with_bits(EX1, 152, "0" * 13), ReservedValue, "MSH-41", (152, 165)),
    "no word of the vectors, y": (with_bits(EX1, 157, "0" * 12 + "1"), ReservedValue, "MSH-41", (157, 170)),
    "motion first": (MOTION_FIRST, InconsistentSemantics, "MSH-4", (64, 65)),
    "garbage behind the object code": (EX1[:4] + b"\x12\x34\x56\x78", ForbiddenValue, "MSH-25", (32, 64)),
    "one byte behind the object code": (EX1[:4] + b"\x12", ForbiddenValue, "MSH-25", (32, 40)),
    "garbage behind 7F": (EX1[:4] + b"\x7f\x12\x34\x56\x78", ForbiddenValue, "MSH-25", (40, 72)),
    "two bytes 7F": (EX1[:4] + b"\x7f\x7f" + EX1[4:], ForbiddenValue, "MSH-25", (40, 72)),
    "half a start code": (EX1[:14] + b"\0\0\1", ForbiddenValue, "MSH-25", (112, 136)),
    # is_frame_rate, rate 0 and 0 sixteenths.
    "frame rate 0": (EX1[:8] + b"\xe0\0\0\0", ForbiddenValue, "FBA-37", (67, 80)),
}


@pytest.mark.parametrize("name", WIRE_FAULTS)
def test_fault_on_the_wire(name: str) -> None:
    data, error_class, rule, bits = WIRE_FAULTS[name]
    error = check_mesh_input(data)
    assert error is not None
    assert (type(error), error.rule, error.bits) == (error_class, rule, bits)


SQUARE = [(0, 0), (40, 0), (40, 40), (0, 40)]

POLYGON_FAULTS: dict[str, tuple[list[tuple[int, int]], int, int, str]] = {
    "crossing": ([(0, 0), (40, 40), (40, 0), (0, 30)], 4, 3, polygon.CROSSING),
    "crossing in the closing edge": ([(0, 0), (40, 0), (10, 30), (10, -10)], 4, 3, polygon.CROSSING),
    "closing edge alone": ([(0, 0), (30, 0), (30, 30), (20, -20), (60, 10)], 5, 3, polygon.CROSSING),
    "touching": ([(0, 0), (40, 0), (40, 40), (20, 0), (0, 40)], 5, 3, polygon.TOUCHING),
    "edge through a node": ([(0, 0), (20, 20), (0, 40), (40, 40), (10, 10), (-9, 8)], 6, 4, polygon.TOUCHING),
    "spike": ([(0, 0), (40, 0), (10, 0), (10, 40)], 4, 2, polygon.SPIKE),
    "spike at the first node": ([(0, 0), (40, 0), (40, 40), (20, 0)], 4, 3, polygon.TOUCHING),
    "repeated on the boundary": ([(0, 0), (40, 0), (40, 40), (40, 0), (0, 40)], 5, 3, polygon.REPEATED),
    "repeated at once": ([(0, 0), (40, 0), (40, 0), (0, 40)], 4, 2, polygon.REPEATED),
    "repeated inside": ([*SQUARE, (7, 8), (9, 9), (7, 8)], 4, 6, polygon.REPEATED),
    "inside as on the boundary": ([*SQUARE, (7, 8), (40, 40)], 4, 5, polygon.REPEATED),
    "zero area": ([(0, 0), (20, 0), (40, 0)], 3, 2, polygon.ZERO_AREA),
    "outside": ([*SQUARE, (7, 8), (41, 20), (9, 9)], 4, 5, polygon.OUTSIDE),
    "on the polygon": ([*SQUARE, (7, 8), (40, 20), (41, 1)], 4, 5, polygon.ON_POLYGON),
}


def _without_triangulation(nodes: list[tuple[int, int]], boundary_count: int) -> bytes:
    return write_faulty(mesh_stream(delaunay(nodes, boundary_count)), [])


@pytest.mark.parametrize("name", POLYGON_FAULTS)
def test_fault_of_the_polygon(name: str) -> None:
    nodes, boundary_count, node, kind = POLYGON_FAULTS[name]
    error = check_mesh_input(_without_triangulation(nodes, boundary_count))
    assert isinstance(error, InconsistentSemantics)
    assert (error.rule, error.bits) == ("MSH-11", node_spans(nodes)[node])
    assert error.path == f"plane[0].geometry.node[{node}]"
    assert kind in error.allowed
    with pytest.raises(EncodeError):
        write_stream(mesh_stream(delaunay(nodes, boundary_count)))


def test_the_faulty_node_comes_before_what_follows_it() -> None:
    """A fault behind the first faulty node is never the one reported; a fault before it always is."""
    nodes, boundary_count, node, _ = POLYGON_FAULTS["touching"]
    data = _without_triangulation(nodes, boundary_count)
    spans = node_spans(nodes)
    for count in range(spans[0][0] // 8, (spans[-1][1] + 7) // 8 + 1):
        error = check_mesh_input(data[:count])
        assert error is not None
        if 8 * count < spans[node][1]:
            assert isinstance(error, Truncated), count
        else:
            assert (type(error), error.bits) == (InconsistentSemantics, spans[node]), count
    later = with_bits(data, spans[node + 1][0], "1111111110")
    error = check_mesh_input(later)
    assert error is not None and error.bits == spans[node]
    earlier = check_mesh_input(with_bits(data, spans[node - 1][0], "1111111110"))
    assert isinstance(earlier, ReservedValue)


def _far(last: tuple[int, int]) -> list[tuple[int, int]]:
    """A triangle whose third node is reached in the longest steps there are; straight nodes are legal."""
    nodes = [(4095, 0)]
    while len(nodes) < 7:
        nodes.append((nodes[-1][0] + 2047, 0))
    nodes.append(last)
    back = [(x, 700) for x in range(last[0] - 1000, 4095, -2000)]
    return nodes + back


@pytest.mark.parametrize(("last", "taken"), [((16383, 9), True), ((16384, 9), False)])
def test_nodes_stay_within_their_range(last: tuple[int, int], taken: bool) -> None:
    nodes = _far((last[0] - 9, 5))
    nodes[7:8] = [nodes[7], last]
    data = _without_triangulation(nodes, len(nodes))
    error = check_mesh_input(data)
    if taken:
        assert error is None
    else:
        assert isinstance(error, RangeViolation)
        assert (error.rule, error.bits) == ("MSH-24", node_spans(nodes)[8])


def test_the_other_end_of_the_range() -> None:
    up = [(0, -4096 - 2047 * k) for k in range(7)]
    back = [(700, y) for y in range(-15000, -4096, 2000)]
    assert check_mesh_input(_without_triangulation([*up, (5, -16384), *back], 7 + 1 + len(back))) is None
    ring = [*up, (5, -16385), *back]
    error = check_mesh_input(_without_triangulation(ring, len(ring)))
    assert isinstance(error, RangeViolation)
    assert error.bits == node_spans(ring)[7]


def test_a_node_out_of_range_behind_a_fault_of_the_polygon() -> None:
    nodes = _far((16384, 9))
    nodes[3] = (nodes[1][0] + 40, 0)  # back over the edge before it
    nodes[4] = (nodes[3][0] + 2047, 3)
    for k in (5, 6, 7):
        nodes[k] = (nodes[k - 1][0] + 2047, 3)
    nodes.insert(8, (16384, 9))
    error = check_mesh_input(_without_triangulation(nodes, len(nodes)))
    assert isinstance(error, InconsistentSemantics)
    assert error.bits == node_spans(nodes[:5])[3]


def _moved(x: int, code: str) -> MeshState:
    """Motion of a mesh whose node 0 stands at x, from the bits of its first vector."""
    state = MeshState(Readings())
    plane = uniform(2, 2, 1, 1)
    assert plane.geometry is not None
    state.set_geometry(plane.geometry)
    state.xs[0] = x
    bits = "001" + code + "1" * 3
    bits += "0" * (-len(bits) % 8)
    io = Reader(BitCursor(BytesSource(int(bits, 2).to_bytes(len(bits) // 8, "big"))))
    mesh_motion(io, state, MeshMotion())
    return state


@pytest.mark.parametrize(("x", "code"), [((1 << 31) - 1, "00101"), (-(1 << 31), "00111")])
def test_moved_positions_stay_within_32_bits(x: int, code: str) -> None:
    """Flag 0, x +1 (010) or -1 (011), y 0 (1)."""
    step = 1 if x > 0 else -1
    _moved(x - step, code)
    with pytest.raises(RangeViolation) as caught:
        _moved(x, code)
    assert caught.value.rule == "MSH-24"
    assert caught.value.bits == (3, 3 + len(code))


# -- truncation and flips ----------------------------------------------------------------------------------------------


def _with_everything() -> bytes:
    """Every element of both kinds of geometry, of the temporal header, and user data."""
    first = mesh_timed(delaunay([*SQUARE, (13, 17)], 4), rate=(25, 3, 1), time=(1, 2, 3), skip=17)
    second = moved(first, {0: (-5, 9), 4: (100, -3), 2: (0, 1)})
    second.user_data = [b"abc", b""]
    third = mesh_timed(uniform(2, 3, 9, 8, 3), skip=0)
    return write_stream(mesh_stream(first, second, third, still(), coded(7, [(-32, 63, 32, 1), *[None] * 5])))


EVERYTHING = _with_everything()


def test_truncation_inside_every_element() -> None:
    """Data that ends inside an element is Truncated from the first bit of that element on."""
    seen = set()
    starts = [row for part in trace_stream(EVERYTHING) for row in part.trace.rows()]
    for element, start, end, _, path in starts:
        for count in range(-(-(start + 1) // 8), -(-end // 8)):
            error = check_mesh_input(EVERYTHING[:count])
            if element.name in ("user_data", "mesh_object_start_code", "visual_object_sequence_end_code") or (
                element.name in ("mesh_object_plane_start_code", "user_data_start_code")
            ):
                continue
            assert isinstance(error, Truncated), (element.name, count)
            assert error.bits == (start, 8 * count)
            assert error.rule == element.rule
            assert (error.what, error.path) == (element.name, path)
            seen.add(element.name)
    # Elements of one bit and those that happen to begin and end in one byte cannot be cut by whole bytes.
    assert {"nr_of_mesh_nodes", "node0_x", "node0_y", "delta_x", "frame_rate", "delta_mv_x_vlc"} <= seen


def test_data_that_ends_between_elements() -> None:
    """Where the next element has no bit at all, its whole absence is what is reported."""
    starts = {row[1]: row for part in trace_stream(EVERYTHING) for row in part.trace.rows()}
    checked = 0
    for count in range(9, len(EVERYTHING)):
        if 8 * count in starts and starts[8 * count][4].startswith("plane"):
            element = starts[8 * count][0]
            error = check_mesh_input(EVERYTHING[:count])
            if element.name == "stuffing" or element.name.endswith("start_code") or element.name == "user_data":
                assert error is None, (element.name, count)
            else:
                assert isinstance(error, Truncated)
                assert (error.what, error.bits) == (element.name, (8 * count, 8 * count))
                checked += 1
    assert checked


@pytest.mark.parametrize("data", [EX1, EX2, EVERYTHING], ids=["MSH-EX-1", "MSH-EX-2", "everything"])
def test_every_truncation(data: bytes) -> None:
    classes = set()
    for count in range(8 * len(data)):
        error = check_mesh_input(cut_bits(data, count))
        classes.add(type(error).__name__ if error is not None else "")
    assert {"Truncated", ""} <= classes


@pytest.mark.parametrize("data", [EX1, EX2], ids=["MSH-EX-1", "MSH-EX-2"])
def test_every_single_bit_flip(data: bytes) -> None:
    classes = set()
    whole = int.from_bytes(data, "big")
    for bit in range(8 * len(data)):
        error = check_mesh_input((whole ^ 1 << bit).to_bytes(len(data), "big"))
        classes.add(type(error).__name__ if error is not None else "")
    assert {"", "ForbiddenValue", "InputFormat", "Unsupported", "RangeViolation", "MarkerBit"} <= classes


# -- limits and hostile input ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "name", "most", "bits"),
    [
        (EX1, "mesh_nodes_uniform", 5, (81, 91)),
        (EX2, "mesh_nodes_delaunay", 5, (71, 87)),
        (write_stream(mesh_stream(mesh_timed(still(), skip=20))), "skipped_frames", 19, (67, 75)),
    ],
    ids=["uniform", "delaunay", "skip"],
)
def test_limit(data: bytes, name: str, most: int, bits: tuple[int, int]) -> None:
    below = Options(limits=DEFAULT_LIMITS.with_values({name: most}))
    error = check_mesh_input(data, below)
    assert isinstance(error, ResourceLimit)
    assert error.bits == bits
    assert check_mesh_input(data, Options(limits=DEFAULT_LIMITS.with_values({name: most + 1}))) is None


def test_limits_of_user_data_and_collected_planes() -> None:
    first = uniform(2, 2, 4, 4)
    first.user_data = [b"12345"]
    data = write_stream(mesh_stream(first, still()))
    start = data.index(b"\0\0\1\xb2") * 8
    error = check_mesh_input(data, Options(limits=DEFAULT_LIMITS.with_values({"user_data_bytes": 4})))
    assert isinstance(error, ResourceLimit)
    assert error.bits == (start, start + 72)
    with pytest.raises(ResourceLimit) as caught:
        read_stream(data, Options(limits=DEFAULT_LIMITS.with_values({"collected_planes": 1})))
    assert caught.value.rule == "CNF-22"


def _counted(monkeypatch: pytest.MonkeyPatch, module: object, name: str) -> Callable[[], int]:
    calls = 0
    inner = getattr(module, name)

    def count(*args: object) -> object:
        nonlocal calls
        calls += 1
        return inner(*args)

    monkeypatch.setattr(module, name, count)
    return lambda: calls


def test_many_nodes_in_forty_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Work goes with the bits that are there, not with the count that is announced."""
    header = f"{0x1BC:032b}{0x1BD:032b}11000" + "10" + "1" * 16 + "1" + "1" * 10 + "1" + "0" * 13 + "1" + "0" * 13 + "1"
    bits = header + "0100" + "0001" * 1000
    data = int(bits[:320], 2).to_bytes(40, "big")
    reads = _counted(monkeypatch, BitCursor, "read")
    pairs = _counted(monkeypatch, polygon, "_meeting")
    _, _, error = decoded(data)
    assert isinstance(error, SnhcError)
    assert reads() < 320
    assert pairs() < 320


def test_a_thousand_crossing_edges(monkeypatch: pytest.MonkeyPatch) -> None:
    """A star whose edges all cross is found out at its third edge; the pairs that are looked at stay few."""
    nodes = [(2000 if k % 2 else -2000 + k, k - 500) for k in range(1023)]
    nodes[3] = (2000, -900)
    data = _without_triangulation([(max(-4096, min(4095, x)) // 2, y) for x, y in nodes], 1023)
    pairs = _counted(monkeypatch, polygon, "_meeting")
    _, _, error = decoded(data)
    assert isinstance(error, InconsistentSemantics)
    assert error.rule == "MSH-11"
    assert pairs() < 20 * 1023


def test_a_comb_of_long_edges_is_no_quadratic_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """1,023 edges side by side without a fault: the grid keeps the pairs well below their half million."""
    teeth = [(1000 if k % 4 in (1, 2) else -1000, 2 * k) for k in range(1000)]
    # Back up along the left side in long steps.
    nodes = [*teeth, (-1020, 1900), (-1020, 950), (-1020, 0)]
    data = _without_triangulation(nodes, len(nodes))
    pairs = _counted(monkeypatch, polygon, "_meeting")
    _, _, error = decoded(data)
    assert error is None
    assert pairs() < 100 * len(nodes)


def test_largest_uniform_header_with_a_lower_limit() -> None:
    """1023 x 1023 nodes are refused before a list is made where the limit says so."""
    data = write_faulty(
        mesh_stream(uniform(2, 2, 1, 1)),
        [Mutation("nr_of_mesh_nodes_hor", "wire", 1023), Mutation("nr_of_mesh_nodes_vert", "wire", 1023)],
    )
    error = check_mesh_input(data, Options(limits=DEFAULT_LIMITS.with_values({"mesh_nodes_uniform": 1_046_528})))
    assert isinstance(error, ResourceLimit)
    assert error.value == 1_046_529


# -- the faulty writer -------------------------------------------------------------------------------------------------


def test_faulty_writer_goes_on_behind_a_faulty_polygon() -> None:
    nodes, boundary_count, node, _ = POLYGON_FAULTS["crossing"]
    first = uniform(2, 2, 4, 4)
    data = write_faulty(mesh_stream(first, delaunay(nodes, boundary_count), moved(first, {0: (1, 1)})), [])
    error = check_mesh_input(data)
    assert error is not None and error.path == f"plane[1].geometry.node[{node}]"
