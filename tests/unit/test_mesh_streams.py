"""Mesh streams: the samples, the worked examples bit by bit, findings, what stands between planes.

The vectors of the samples also go through `test_mesh_samples.py`, which shares no parser with the product; faults and
limits are in `test_mesh_faults.py`.
"""

from __future__ import annotations

import json

import pytest
from mesh_helpers import (
    EX1,
    EX2,
    check_mesh_input,
    decoded,
    traced,
)
from mesh_second_parser import SAMPLES, parse, sample_names

from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    ForbiddenValue,
)
from snhc.reference_impl.mesh.decoded import mesh_line
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.stream import Options, read_stream, trace_stream, write_stream
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


# -- the writer --------------------------------------------------------------------------------------------------------


def test_writer_refuses_motion_with_a_vector_too_many() -> None:
    with pytest.raises(EncodeError) as caught:
        write_stream(mesh_stream(uniform(2, 2, 4, 4), coded(1, [None] * 5)))
    assert caught.value.rule == "MSH-21"
    with pytest.raises(EncodeError):
        write_stream(mesh_stream(coded(1, [])))
