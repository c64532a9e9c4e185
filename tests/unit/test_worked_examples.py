"""The worked streams FBA-EX-1..4: values, bit spans as the tables print them, and written back identically."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from fba_helpers import check_partition, decoded, traced

from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.systems.stream import decode_planes, read_stream, trace_stream, write_stream

OBJECT = "00000000000000000000000110111010"
END = "00000000000000000000000110110001"
NONE = "100"  # marker, mask type 0
# The header of an intra FAP plane without rate, time code and skipped frames.
PLANE = ["is_intra 1", "fba_object_mask 1", "is_frame_rate 0", "is_time_code 0", "skip_frames 0"]
INTER = ["is_intra 0", "fba_object_mask 1", "skip_frames 0"]
NO_GROUP = ["marker_bit 1", "fap_mask_type 0"]
FLAGS = ["is_i_new_max 0", "is_i_new_min 0", "is_p_new_max 0", "is_p_new_min 0"]
FEMALE = ["fba_suggested_gender 0", "fba_object_coding_type 0"]

Row = tuple[int, str, list[str]]


@dataclass
class Example:
    data: bytes
    rows: list[Row]
    segments: list[tuple[int, list[int]]]
    states: list[str]
    times: list[tuple[int, int]]
    values: list[dict[int, int]]


EX1 = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae50000 01b1")


def _list(v: int) -> str:
    # Groups 2..10: a marker before every 4th FAP of each group; FAP 3 stands behind the very first marker, FAP 48
    # behind the first of group 7. Groups have 16, 12, 8, 4, 5, 3, 10, 4, 4 FAPs: 4 3 2 1 2 1 3 1 1 markers = 18.
    return "1" + f"{v:05b}" + "1" * 11 + "1" + f"{v:05b}" + "1" * 5


def _list_names(name: str, v: int) -> list[str]:
    marker = "marker_bit 1"
    return [marker, f"fap_new_{name} {v}", *[marker] * 12, f"fap_new_{name} {v}", *[marker] * 5]


def _letters(**at: str) -> str:
    letters = ["U"] * 68
    for where, letter in at.items():
        first, _, last = where[1:].partition("_")
        for number in range(int(first), int(last or first) + 1):
            letters[number - 1] = letter
    return "".join(letters)


EXAMPLES = {
    "FBA-EX-1": Example(
        EX1,
        [
            (0, OBJECT, ["fba_object_start_code 442"]),
            (32, "101", ["is_intra 1", "fba_object_mask 1"]),
            (35, "10001100100000" + "00", [
                "is_frame_rate 1", "frame_rate 25", "seconds 0", "frequency_offset 0", "is_time_code 0",
                "skip_frames 0",
            ]),
            (51, "00001", ["fap_quant 1"]),
            (56, NONE + "101" + "1" + "0" * 15 + NONE * 4 + "101100" + NONE * 3, [
                *NO_GROUP, "marker_bit 1", "fap_mask_type 1", "fap_group_mask 32768", *NO_GROUP * 4,
                "marker_bit 1", "fap_mask_type 1", "fap_group_mask 4", *NO_GROUP * 3,
            ]),
            (105, "00" + "1111", [
                *FEMALE, "is_i_new_max 1", "is_i_new_min 1", "is_p_new_max 1", "is_p_new_min 1",
            ]),
            (111, _list(18) * 2 + _list(6) * 2, [
                *_list_names("i_max", 18), *_list_names("i_min", 18),
                *_list_names("p_max", 6), *_list_names("p_min", 6),
            ]),
            (223, "", ["fap_segment 2"]),
            (246, "0010", INTER),
            (250, "", ["fap_segment 2"]),
            (270, "0011", ["is_intra 0", "fba_object_mask 1", "skip_frames 1"]),
        ],
        [(223, [25, -20]), (250, [10, 10]), (282, [0, 11])],
        [_letters(f3="T", f48="T")] * 3,
        [(0, 1), (1, 25), (2, 25)],
        [{3: 100, 48: -3400}, {3: 140, 48: -1700}, {3: 140, 48: 170}],
    ),
    "FBA-EX-2": Example(
        bytes.fromhex("000001bab1900192492e92000000049405172f000001b1"),
        [
            (0, OBJECT, ["fba_object_start_code 442"]),
            (32, "101", ["is_intra 1", "fba_object_mask 1"]),
            (35, "10001100100000", ["is_frame_rate 1", "frame_rate 25", "seconds 0", "frequency_offset 0"]),
            (49, "00", ["is_time_code 0", "skip_frames 0"]),
            (51, "00001", ["fap_quant 1"]),
            (56, NONE * 6, NO_GROUP * 6),
            (74, "101110", ["marker_bit 1", "fap_mask_type 1", "fap_group_mask 6"]),
            (80, NONE * 3, NO_GROUP * 3),
            (89, "00", FEMALE),
            (91, "0000", FLAGS),
            (95, "0" * 22 + "1" + "001", ["fap_segment 2"]),
            (121, "001", ["is_intra 0", "fba_object_mask 1"]),
            (124, "0", ["skip_frames 0"]),
            (125, "1000000010100010111001", ["fap_segment 2"]),
            (147, "01111", ["stuffing 15"]),
            (152, END, ["visual_object_sequence_end_code 433"]),
        ],
        [(95, [1860, 1860]), (125, [-3, 2])],
        [_letters(f48_49="T")] * 2,
        [(0, 1), (1, 25)],
        [{48: 316200, 49: 316200}, {48: 315690, 49: 316540}],
    ),
    "FBA-EX-3": Example(
        bytes.fromhex("000001baa05ec00049249241661efce13a1267aa200e7ec26f000001b1"),
        [
            (0, OBJECT, ["fba_object_start_code 442"]),
            (32, "101000", PLANE),
            (38, "00010", ["fap_quant 2"]),
            (43, "111", ["marker_bit 1", "fap_mask_type 3"]),
            (46, "1011000000000000000", ["marker_bit 1", "fap_mask_type 1", "fap_group_mask 32768"]),
            (65, NONE * 8, NO_GROUP * 8),
            (89, "10", ["fba_suggested_gender 1", "fba_object_coding_type 0"]),
            (91, "0000", FLAGS),
            (95, "10110011000011", ["viseme_segment 3"]),
            (109, "1", ["viseme_def 1"]),
            (110, "10111111001110000", ["expression_segment 4"]),
            (127, "10", ["init_face 1", "expression_def 0"]),
            (129, "01110100001", ["fap_segment 1"]),
            (140, "001", ["is_intra 0", "fba_object_mask 1"]),
            (143, "0", ["skip_frames 0"]),
            (144, "01100111101010100", ["viseme_segment 3"]),
            (161, "0", ["viseme_def 0"]),
            (162, "100000000011100111111", ["expression_segment 4"]),
            (183, "01", ["init_face 0", "expression_def 1"]),
            (185, "1000010011", ["fap_segment 1"]),
            (195, "01111", ["stuffing 15"]),
            (200, END, ["visual_object_sequence_end_code 433"]),
        ],
        [
            (95, [4, 7, 20]), (110, [1, 25, 3, 5]), (129, [50]),
            (144, [3, -7, -4]), (162, [0, -1, 3, 12]), (185, [-7]),
        ],
        [_letters(f1_3="T")] * 2,
        [(0, 1), (1, 30)],
        [{3: 400}, {3: 344}],
    ),
    "FBA-EX-4": Example(
        bytes.fromhex(
            "000001baa032c0004d01279200fd9f553f600a7e49fe9483ff7ff2a032a0004c81249201028d85019a000249249007e97f000001b1"
        ),
        [
            (0, OBJECT, ["fba_object_start_code 442"]),
            (32, "10100000001", [*PLANE, "fap_quant 1"]),
            (43, NONE + "1011000000000000000" + NONE + "11010000000" + NONE * 2 + "111" + NONE * 3, [
                *NO_GROUP, "marker_bit 1", "fap_mask_type 1", "fap_group_mask 32768", *NO_GROUP,
                "marker_bit 1", "fap_mask_type 2", "fap_group_mask 128", *NO_GROUP * 2,
                "marker_bit 1", "fap_mask_type 3", *NO_GROUP * 3,
            ]),
            (97, "000000", [*FEMALE, *FLAGS]),
            (103, "01111110110011111010101010011111101100000000010100111111001", ["fap_segment 5"]),
            (162, "0010", INTER),
            (166, "01111111101001010010000011111111110111111111110010", ["fap_segment 5"]),
            (216, "10100000001", [*PLANE, "fap_quant 1"]),
            (227, NONE + "1010100000000000000" + NONE + "11001000000" + NONE * 6, [
                *NO_GROUP, "marker_bit 1", "fap_mask_type 1", "fap_group_mask 16384", *NO_GROUP,
                "marker_bit 1", "fap_mask_type 2", "fap_group_mask 64", *NO_GROUP * 6,
            ]),
            (281, "000000", [*FEMALE, *FLAGS]),
            (287, "1000000101000110110000", ["fap_segment 2"]),
            (309, "10100000001", [*PLANE, "fap_quant 1"]),
            (320, NONE + "1101000000000000000" + NONE * 8, [
                *NO_GROUP, "marker_bit 1", "fap_mask_type 2", "fap_group_mask 32768", *NO_GROUP * 8,
            ]),
            (366, "000000", [*FEMALE, *FLAGS]),
            (372, "011111101001", ["fap_segment 1"]),
            (384, "01111111", ["stuffing 127"]),
            (392, END, ["visual_object_sequence_end_code 433"]),
        ],
        [(103, [10, 20, 1, -1, 2]), (166, [1, -5, 0, 0, -2]), (287, [-6, 8]), (372, [12])],
        [
            _letters(f3="T", f31="T", f32_38="I", f48_50="T"),
            _letters(f3="T", f31="T", f32_38="I", f48_50="T"),
            _letters(f3="R", f4="T", f31="I", f32="T", f33_38="I", f48_50="R"),
            _letters(f3="T", f4_18="I", f31_32="R", f48_50="R"),
        ],
        [(0, 1), (1, 30), (1, 15), (1, 10)],
        [
            {3: 40, 31: 40, 48: 170, 49: -170, 50: 340},
            {3: 44, 31: 30, 48: 170, 49: -170, 50: 0},
            {3: 44, 4: -12, 32: 16, 48: 170, 49: -170, 50: 0},
            {3: 48, 31: 30, 32: 16, 48: 170, 49: -170, 50: 0},
        ],
    ),
}  # fmt: skip


def _segments(data: bytes) -> list[SegmentTrace]:
    return [
        segment for part in trace_stream(data) for _, (segment, _) in sorted(part.trace.segments.items())
    ]  # fmt: skip


@pytest.fixture(params=EXAMPLES)
def example(request: pytest.FixtureRequest) -> Example:
    return EXAMPLES[request.param]


def test_values_states_times(example: Example) -> None:
    frames, _, error = decoded(example.data)
    assert error is None
    found = [{i + 1: value for i, value in enumerate(frame.faps) if value is not None} for frame in frames]
    assert found == example.values
    assert [frame.state for frame in frames] == example.states
    assert [frame.time for frame in frames] == example.times
    assert traced(example.data)[0] == frames


def test_high_level_values_of_example_3() -> None:
    first, second = decoded(EXAMPLES["FBA-EX-3"].data)[0]
    assert first.viseme == (4, 7, 40, 1)
    assert first.expression == (1, 50, 3, 10, 1, 0)
    assert (first.gender, first.fap_quant, first.coding_type) == (1, 2, 0)
    assert second.viseme == (7, 0, 32, 0)
    assert second.expression == (1, 48, 6, 34, 0, 1)
    assert second.gender is None


def test_trace_is_the_printed_table(example: Example) -> None:
    data = example.data
    check_partition(data)
    bits = f"{int.from_bytes(data, 'big'):0{8 * len(data)}b}"
    elements = [
        (start, end, f"{el.name} {value}")
        for part in trace_stream(data)
        for el, start, end, value, _ in part.trace.rows()
    ]
    for offset, printed, names in example.rows:
        first = next(i for i, (start, _, _) in enumerate(elements) if start == offset)
        rows = elements[first : first + len(names)]
        assert [text for _, _, text in rows] == names
        if printed:
            assert bits[offset : rows[-1][1]] == printed


def test_segments_are_the_printed_ones(example: Example) -> None:
    found = [(segment.start, [step.level for step in segment.steps]) for segment in _segments(example.data)]
    assert found == example.segments


def test_guard_of_example_2() -> None:
    first, second = _segments(EXAMPLES["FBA-EX-2"].data)
    # 22 zeros from bit 95, the guard, three more data bits: 25 data bits and 1 guard.
    assert first.guards == ((95 + 22, 1),)
    assert first.end - first.start - len(first.guards) == 25
    assert second.guards == ()
    # 3,721 symbols intra, 1,201 inter; the highest symbol keeps low at 0.
    assert [step.symbols for step in first.steps] == [3721, 3721]
    assert [step.low for step in first.steps] == [0, 0]
    assert [step.symbols for step in second.steps] == [1201, 1201]


def test_planes_of_example_1() -> None:
    assert [(plane.start, plane.end) for plane in decode_planes(EX1)] == [(32, 246), (246, 270), (270, 302)]
    rows = [row for part in trace_stream(EX1) for row in part.trace.rows()]
    # 17 = 15, 2; the segment ends with 01, then the stuffing 01 and the end code.
    assert [(el.name, value) for el, start, _, value, _ in rows if 270 <= start < 282] == [
        ("is_intra", 0), ("fba_object_mask", 1), ("skip_frames", 1),
        ("number_of_frames_to_skip", 15), ("number_of_frames_to_skip", 2),
    ]  # fmt: skip
    assert [(el.name, start, end) for el, start, end, _, _ in rows[-3:]] == [
        ("fap_segment", 282, 302), ("stuffing", 302, 304), ("visual_object_sequence_end_code", 304, 336),
    ]  # fmt: skip
    assert len(EX1) == 42


def test_written_back(example: Example) -> None:
    items = read_stream(example.data)
    assert write_stream(items) == example.data
