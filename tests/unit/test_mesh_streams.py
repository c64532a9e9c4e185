"""Mesh streams: the samples, the worked examples bit by bit, every fault at its own bits, findings, limits.

The vectors of the samples also go through `test_mesh_samples.py`, which shares no parser with the product.
"""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest
from mesh_helpers import (
    EX1,
    EX2,
    check_mesh_input,
    cut_bits,
    decoded,
    node_spans,
    traced,
    with_bits,
)
from mesh_second_parser import SAMPLES, parse, sample_names

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
from snhc.reference_impl.mesh.decoded import mesh_line
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
    mesh_object,
    mesh_stream,
    mesh_timed,
    moved,
    still,
    topology_of,
    uniform,
)

# -- the samples -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sample_names())
def test_sample_decodes_and_writes_back(name: str) -> None:
    data = (SAMPLES / name / "input.m2d").read_bytes()
    expected = (SAMPLES / name / "expected.ndjson").read_text(encoding="utf-8").splitlines()[1:]
    frames, _, error = decoded(data)
    assert error is None
    assert [json.loads(mesh_line(frame)) for frame in frames] == [json.loads(line) for line in expected]
    assert check_mesh_input(data) is None


OTHER_READINGS = [("AMB-MSH-1", "by-column"), ("AMB-MSH-1", "by-row"), ("AMB-MSH-2", "other")]


@pytest.mark.parametrize(("amb", "reading"), OTHER_READINGS)
def test_samples_under_the_other_readings(amb: str, reading: str) -> None:
    """Tied and alternating meshes change, all others do not; node counts and bytes stay."""
    options = Options(readings=Readings({amb: reading}))
    changed = 0
    for name in sample_names():
        data = (SAMPLES / name / "input.m2d").read_bytes()
        usual, _, _ = decoded(data)
        other, _, error = decoded(data, options)
        assert error is None
        assert write_stream(read_stream(data, options)) == data
        assert [len(frame.nodes) for frame in usual] == [len(frame.nodes) for frame in other]
        if usual != other:
            changed += 1
            geometries = [plane for plane in parse(data) if plane.nodes is not None]
            if amb == "AMB-MSH-1":
                assert any(plane.uniform is not None and plane.uniform[4] >= 2 for plane in geometries)
            else:
                assert any(plane.boundary_count for plane in geometries)
    assert changed


# -- the worked examples -----------------------------------------------------------------------------------------------

Row = tuple[int, str, list[str]]
PLANE = f"{0x1BD:032b}"
INTRA_PLANE = ["is_intra 1", "mesh_mask 1", "is_frame_rate 0", "is_time_code 0", "skip_frames 0"]


def _node(x: tuple[int, int], y: tuple[int, int]) -> list[str]:
    return [f"delta_x_len_vlc {x[0]}", f"delta_x {x[1]}", f"delta_y_len_vlc {y[0]}", f"delta_y {y[1]}"]


def _vector(*values: int) -> list[str]:
    names = ["node_motion_vector_flag", "delta_mv_x_vlc", "delta_mv_x_res", "delta_mv_y_vlc", "delta_mv_y_res"]
    if len(values) == 3:
        names = [names[0], names[1], names[3]]
    return [f"{name} {value}" for name, value in zip(names, values, strict=False)]


EXAMPLES: dict[str, tuple[bytes, list[Row], list[str]]] = {
    "MSH-EX-1": (
        EX1,
        [
            (0, f"{0x1BC:032b}", ["mesh_object_start_code 444"]),
            (32, PLANE, ["mesh_object_plane_start_code 445"]),
            (64, "11000", INTRA_PLANE),
            (69, "01", ["mesh_type_code 1"]),
            (71, "0000000011", ["nr_of_mesh_nodes_hor 3"]),
            (81, "0000000010", ["nr_of_mesh_nodes_vert 2"]),
            (91, "1", ["marker_bit 1"]),
            (92, "00010100", ["mesh_rect_size_hor 20"]),
            (100, "00010000", ["mesh_rect_size_vert 16"]),
            (108, "10", ["triangle_split_code 2"]),
            (110, "01", ["stuffing 1"]),
            (112, PLANE, ["mesh_object_plane_start_code 445"]),
            (144, "010", ["is_intra 0", "mesh_mask 1", "skip_frames 0"]),
            (147, "001", ["motion_range_code 1"]),
            (150, "1", _vector(1)),
            (151, "0000100011", _vector(0, 3, -2)),
            (161, "0000001010100001000", _vector(0, -9, 6)),
            (180, "1", _vector(1)),
            (181, "00000101000011", _vector(0, 5, -3)),
            (195, "00000001110100000110", _vector(0, -14, 7)),
            (215, "0", ["stuffing 0"]),
            (216, f"{0x1B1:032b}", ["visual_object_sequence_end_code 433"]),
        ],
        [
            '{"index":0,"time":"0/1","intra":true,"nodes":[[0,0],[20,0],[40,0],[0,16],[20,16],[40,16]],'
            '"triangles":[[0,1,4],[0,4,3],[1,2,4],[2,5,4]],"order":[0,1,4,3,2,5]}',
            '{"index":1,"time":"1/30","intra":false,"nodes":[[0,0],[23,-2],[43,-1],[0,16],[13,21],[24,25]]}',
        ],
    ),
    "MSH-EX-2": (
        EX2,
        [
            (0, f"{0x1BC:032b}", ["mesh_object_start_code 444"]),
            (32, PLANE, ["mesh_object_plane_start_code 445"]),
            (64, "11000", INTRA_PLANE),
            (69, "10", ["mesh_type_code 2"]),
            (71, "0000000000000110", ["nr_of_mesh_nodes 6"]),
            (87, "1", ["marker_bit 1"]),
            (88, "0000000101", ["nr_of_boundary_nodes 5"]),
            (98, "1", ["marker_bit 1"]),
            (99, "0000000000000100000000000001", ["node0_x 0", "marker_bit 1", "node0_y 0", "marker_bit 1"]),
            (127, "1110111100100001", _node((6, 60), (3, 1))),
            (143, "110101001110101110", _node((5, 20), (6, 46))),
            (161, "111001011111011110", _node((6, 23), (5, 30))),
            (179, "111000110111001011", _node((6, 13), (5, 11))),
            (197, "111010110111001011", _node((6, 45), (5, 11))),
            (215, "0", ["stuffing 0"]),
            (216, PLANE, ["mesh_object_plane_start_code 445"]),
            (248, "010", ["is_intra 0", "mesh_mask 1", "skip_frames 0"]),
            (251, "010", ["motion_range_code 2"]),
            (254, "001010100", _vector(0, 1, 1, 1, 0)),
            (263, "011", _vector(0, 0, 0)),
            (266, "00010000100", _vector(0, 2, 0, 2, 0)),
            (277, "000001110000010010", _vector(0, -4, 0, -6, 0)),
            (295, "1", _vector(1)),
            (296, "0000000011110000000101000", _vector(0, -21, 0, 18, 0)),
            (321, "0111111", ["stuffing 63"]),
            (328, f"{0x1B1:032b}", ["visual_object_sequence_end_code 433"]),
        ],
        [
            '{"index":0,"time":"0/1","intra":true,"nodes":[[0,0],[60,-6],[80,40],[40,70],[-10,50],[35,30]],'
            '"triangles":[[0,1,5],[0,5,4],[1,2,5],[3,4,5],[2,3,5]],"order":[0,1,5,4,2,3]}',
            '{"index":1,"time":"1/30","intra":false,"nodes":[[2,1],[62,-5],[80,40],[0,103],[-13,42],[40,34]]}',
        ],
    ),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_worked_example(name: str) -> None:
    data, rows, lines = EXAMPLES[name]
    bits = f"{int.from_bytes(data, 'big'):0{8 * len(data)}b}"
    trace = [row for part in trace_stream(data) for row in part.trace.rows()]
    at = 0
    for offset, word, names in rows:
        assert offset == at
        here = [row for row in trace if offset <= row[1] < offset + len(word)]
        assert [f"{element.name} {value}" for element, _, _, value, _ in here] == names
        assert "".join(bits[start:end] for _, start, end, _, _ in here) == word
        at += len(word)
    assert at == 8 * len(data)
    frames, findings, error = decoded(data)
    assert error is None
    assert [mesh_line(frame) for frame in frames] == lines
    assert [finding.id for finding in findings] == ["no-sequence-header"]
    assert write_stream(read_stream(data)) == data
    assert traced(data) == (frames, findings, None)


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


# -- findings, user data, the end --------------------------------------------------------------------------------------


def _ids(data: bytes) -> list[tuple[str, tuple[int, int] | None]]:
    """Findings of a stream that decodes, but for the missing sequence header."""
    assert check_mesh_input(data) is None
    _, findings, error = decoded(data)
    assert error is None
    return [(finding.id, finding.bits) for finding in findings if finding.id != "no-sequence-header"]


def test_foldover_is_a_finding_of_its_plane() -> None:
    first = delaunay([(0, 0), (10, 0), (0, 10)])
    over = moved(first, {0: (20, 20)})
    back = moved(first, {0: (-20, -20)})
    flat = moved(first, {0: (5, 5)})
    data = write_stream(mesh_stream(first, over, back, flat))
    planes = [part.plane for part in trace_stream(data) if part.plane is not None]
    assert _ids(data) == [("foldover", (planes[1].start, planes[1].end))]
    frames, _, _ = decoded(data)
    assert [frame.nodes[0] for frame in frames] == [(0, 0), (20, 20), (0, 0), (5, 5)]


def test_stuffing_behind_the_object_code() -> None:
    data = EX1[:4] + b"\x7f" + EX1[4:]
    assert _ids(data) == [("object-stuffing", (32, 40))]
    assert [frame.nodes for frame in decoded(data)[0]] == [frame.nodes for frame in decoded(EX1)[0]]


@pytest.mark.parametrize("zeros", [1, 2, 3, 40])
def test_zero_padding(zeros: int) -> None:
    assert _ids(EX1[:14] + bytes(zeros)) == [("zero-padding", (112, 112 + 8 * zeros))]


@pytest.mark.parametrize("tail", [b"", b"\x7f", b"\x7f\x00\x00\x01\xb1"])
def test_object_without_planes(tail: bytes) -> None:
    ids = [id for id, _ in _ids(EX1[:4] + tail)]
    assert ids == (["object-stuffing"] if tail[:1] == b"\x7f" else []) + ["empty-object"]
    assert decoded(EX1[:4] + tail)[0] == []


@pytest.mark.parametrize("code", ["000001b1", "000001b2", "000001ba", "000001bc"])
def test_another_start_code_directly_behind_the_object(code: str) -> None:
    error = traced(EX1[:4] + bytes.fromhex(code))[2]
    assert error is not None
    assert (error.error_class, error.rule, error.bits) == ("ForbiddenValue", "MSH-25", (32, 64))


@pytest.mark.parametrize("content", [[b""], [b"text"], [b"\x00\x00", b"\x01\xff"], [bytes(7), b"", b"x" * 300]])
@pytest.mark.parametrize("last", [False, True])
def test_user_data_behind_a_plane(content: list[bytes], last: bool) -> None:
    first = uniform(2, 2, 4, 4)
    first.user_data = content
    planes = [first] if last else [first, still()]
    data = write_stream(mesh_stream(*planes))
    assert _ids(data) == []
    (item, _) = read_stream(data)
    assert item.mesh is not None and item.mesh.planes[0].user_data == content
    open_end = write_stream([mesh_object(planes)])
    assert _ids(open_end) == []


def test_plane_that_ends_exactly_with_the_data() -> None:
    """57 bits up to the split code; a rate of 13 bits and a skip of 4 and 5 make whole bytes of it."""
    planes = [mesh_timed(uniform(2, 2, 4, 4), rate=(25, 0, 0)), still()]
    for plane in planes:
        plane.stuffing = 0
    second = mesh_timed(still(), skip=0)
    # is_intra, mesh_mask, skip_frames and 4 bits: 7 bits, one more group of 4 would be 11; 29 bits of an intra plane.
    exact = mesh_timed(still(1), rate=(25, 0, 0), time=(0, 0, 1), skip=0)
    assert (2 + 1 + 13 + 1 + 18 + 1 + 4) % 8 == 0
    exact.stuffing = 0
    data = write_stream([mesh_object([second, exact])])
    assert _ids(data) == []
    (item,) = read_stream(data)
    assert item.mesh is not None and [plane.stuffing for plane in item.mesh.planes] == [1, 0]
    # The same with a whole byte of stuffing.
    assert _ids(data + b"\x7f") == []
    assert read_stream(data + b"\x7f")[0].mesh is not None
    wrong = check_mesh_input(data + b"\x80")
    assert isinstance(wrong, ForbiddenValue) and wrong.rule == "FBA-3"


def test_planes_without_data_repeat_the_mesh() -> None:
    first = uniform(2, 2, 4, 4)
    frames, _, _ = decoded(
        write_stream(mesh_stream(still(1), still(), first, still(), still(1), moved(first, {0: (1, 1)})))
    )
    assert [len(frame.nodes) for frame in frames] == [0, 0, 4, 4, 4, 4]
    assert [frame.intra for frame in frames] == [True, False, True, False, True, False]
    assert [frame.triangles is not None for frame in frames] == [False, False, True, False, False, False]
    assert frames[3].nodes is frames[2].nodes


# -- split codes and motion ranges -------------------------------------------------------------------------------------

SPLITS = {0: ["\\\\\\", "\\\\\\"], 1: ["///", "///"], 2: ["\\/\\", "/\\/"], 3: ["/\\/", "\\/\\"]}


@pytest.mark.parametrize("split", SPLITS)
def test_split_code(split: int) -> None:
    frames, _, error = decoded(write_stream(mesh_stream(uniform(4, 3, 4, 4, split))))
    assert error is None and frames[0].triangles is not None
    edges = {frozenset((t[i], t[i - 1])) for t in frames[0].triangles for i in range(3)}
    for row in range(2):
        for col in range(3):
            a = 4 * row + col
            down, up = frozenset((a, a + 5)) in edges, frozenset((a + 1, a + 4)) in edges
            assert down != up
            assert SPLITS[split][row][col] == ("\\" if down else "/")


@pytest.mark.parametrize("range_code", range(1, 8))
def test_motion_range(range_code: int) -> None:
    """The ends of the range, and both ways around it: v, then -R - 1 + ... wraps to the other end."""
    limit = 16 << range_code
    first = uniform(2, 2, 4, 4)
    order = topology_of(first).order
    vectors = {order[0]: (limit - 1, -limit), order[1]: (-limit, limit - 1), order[2]: (0, 0), order[3]: (1, -1)}
    plane = moved(first, vectors, range_code)
    frames, _, error = decoded(write_stream(mesh_stream(first, plane)))
    assert error is None
    got = {
        node: (new[0] - old[0], new[1] - old[1])
        for node, (old, new) in enumerate(zip(frames[0].nodes, frames[1].nodes, strict=True))
    }
    assert got == vectors
    assert plane.motion is not None
    # From limit - 1 to -limit it is one step up and around.
    assert (plane.motion.codes[1].x_vlc, plane.motion.codes[1].x_res) == (1, 0)
    assert (plane.motion.codes[1].y_vlc, plane.motion.codes[1].y_res) == (-1, 0)
    with pytest.raises(EncodeError):
        moved(first, {0: (limit, 0)}, range_code)


def test_zero_flag_and_a_vector_that_comes_out_as_zero() -> None:
    first = uniform(2, 2, 4, 4)
    # Node n1 is predicted by n0 = (1, 0): d = (-1, 0) gives (0, 0) without the flag.
    frames, _, _ = decoded(write_stream(mesh_stream(first, coded(1, [(1, 0, 0, 0), (-1, 0, 0, 0), None, None]))))
    assert frames[1].nodes == ((1, 0), (4, 0), (0, 4), (4, 4))


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


# -- the faulty writer and the writer ----------------------------------------------------------------------------------


def test_faulty_writer_goes_on_behind_a_faulty_polygon() -> None:
    nodes, boundary_count, node, _ = POLYGON_FAULTS["crossing"]
    first = uniform(2, 2, 4, 4)
    data = write_faulty(mesh_stream(first, delaunay(nodes, boundary_count), moved(first, {0: (1, 1)})), [])
    error = check_mesh_input(data)
    assert error is not None and error.path == f"plane[1].geometry.node[{node}]"


def test_writer_refuses_motion_with_a_vector_too_many() -> None:
    with pytest.raises(EncodeError) as caught:
        write_stream(mesh_stream(uniform(2, 2, 4, 4), coded(1, [None] * 5)))
    assert caught.value.rule == "MSH-21"
    with pytest.raises(EncodeError):
        write_stream(mesh_stream(coded(1, [])))
