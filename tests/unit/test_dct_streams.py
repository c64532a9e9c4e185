"""Whole streams with DCT segments: samples, the worked example, faults, and where segments meet other planes.

Rules: DCT-1, DCT-3, DCT-12..15, FBA-12, FBA-35, FBA-38, FBA-40, CNF-1, CNF-6, CNF-7, CNF-21.
"""

from __future__ import annotations

import json
from io import BytesIO

import pytest
from fba_helpers import SAMPLES, case_files, case_names, check_input, check_partition, decoded, traced
from strategies_dct import check_plainly, plain

from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.bitstream.source import PipeSource
from snhc.reference_impl.face.decoded import ndjson
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import (
    decode_planes,
    read_stream,
    trace_stream,
    write_faulty,
    write_stream,
)
from snhc.vectors.builders import all_lists, body, empty, inter, intra, stream
from snhc.vectors.dct_builders import coefficients, dct_inter, dct_intra, listed

DCT = case_names("dct")
NEG = case_names("neg", "dct-")


def test_all_cases_are_here() -> None:
    assert len(DCT) == 16
    assert len(NEG) == 2


@pytest.mark.parametrize("name", DCT)
def test_sample(name: str) -> None:
    case, data, expected = case_files("dct", name)
    frames, _, error = decoded(data)
    assert error is None
    lines = [json.loads(line) for line in ndjson(frames)]
    assert len(lines) - 1 == case["lines"]
    for line in expected[1:]:
        ours = lines[1 + line["index"]]
        assert {key: ours.get(key) for key in line} == line
    ends = [plane.end for plane in decode_planes(data)]
    assert ends[: len(case["spans"])] == [end for _, end in case["spans"]]
    check_partition(data)
    check_plainly(data)
    assert traced(data) == decoded(data)
    assert write_stream(read_stream(data)) == data


@pytest.mark.parametrize("name", NEG)
def test_rejected_as_named(name: str) -> None:
    case, data, expected = case_files("neg", name)
    wanted = json.loads((SAMPLES / "neg" / name / "expected.json").read_text())
    error = check_input(data)
    assert error is not None
    assert (error.error_class, error.rule, list(error.bits or ())) == (wanted["class"], wanted["rule"], wanted["bits"])
    frames = decoded(data)[0]
    assert len(frames) == case["lines"]
    lines = [json.loads(line) for line in ndjson(frames)]
    for line in expected[1:]:
        ours = lines[1 + line["index"]]
        assert {key: ours.get(key) for key in line} == line


# -- DCT-EX-1 ----------------------------------------------------------------------------------------------------------

EXAMPLE = bytes.fromhex("000001baa112c00049255244001a970bfff4018a9cb93f000001b1")
NONE = ["marker_bit 1", "fap_mask_type 0"]
PRINTED = [
    (0, f"{0x1BA:032b}", ["fba_object_start_code 442"]),
    (32, "101", ["is_intra 1", "fba_object_mask 1"]),
    (35, "000", ["is_frame_rate 0", "is_time_code 0", "skip_frames 0"]),
    (38, "01000", ["fap_quant 8"]),
    (43, "100", NONE),
    (46, "1011000000000000000", ["marker_bit 1", "fap_mask_type 1", "fap_group_mask 32768"]),
    (65, "100" * 4, NONE * 4),
    (77, "101010", ["marker_bit 1", "fap_mask_type 1", "fap_group_mask 2"]),
    (83, "100" * 3, NONE * 3),
    (92, "01", ["fba_suggested_gender 0", "fba_object_coding_type 1"]),
    (94, "0000000000000110" "1" "01001" "011" "1000" "010", ["dc 6", "run 0", "ac 251", "run 1", "ac 258", "run 15"]),
    (126, "1111111111111101" "000000000" "110", ["dc -3", "run 14", "ac 257"]),
    (154, "001", ["is_intra 0", "fba_object_mask 1"]),
    (157, "0", ["skip_frames 0"]),
    (158, "10100" "1" "110" "010", ["dc_difference 254", "run 0", "ac 257", "run 15"]),
    (170, "1110" "010", ["dc_difference 256", "run 15"]),
    (177, "0111111", ["stuffing 63"]),
    (184, f"{0x1B1:032b}", ["visual_object_sequence_end_code 433"]),
]  # fmt: skip
FAP_3 = "-52 -67 -89 -108 -112 -93 -50 11 79 140 183 202 198 179 157 142 62 60 58 55 50 45 39 33 27 21 15 10 5 2 0 -2"
FAP_49 = "-659 -1079 -255 -1451 71 -1719 270 -1842 312 -1800 189 -1601 -79 -1275 -451 -871" + " -765" * 16


def test_example_trace_is_the_printed_table() -> None:
    bits = f"{int.from_bytes(EXAMPLE, 'big'):0{8 * len(EXAMPLE)}b}"
    rows = [row for part in trace_stream(EXAMPLE) for row in part.trace.rows()]
    at = 0
    for start, printed, names in PRINTED:
        assert start == at
        at += len(printed)
        assert bits[start:at] == printed
        assert [f"{el.name} {value}" for el, first, _, value, _ in rows if start <= first < at] == names
        assert at in {end for _, _, end, _, _ in rows}
    assert at == len(bits)
    # A code word is one row: its span is the word, its path the FAP.
    (word,) = [row for row in rows if row[1] == 111]
    assert (word[0].name, word[2], word[4]) == ("ac", 116, "plane[0].fap.fap[3]")


def test_example_values_states_times() -> None:
    frames, findings, error = decoded(EXAMPLE)
    assert error is None
    assert [f.id for f in findings] == ["no-sequence-header", "provisional-tables"]
    assert [frame.faps[2] for frame in frames] == [int(v) for v in FAP_3.split()]
    assert [frame.faps[48] for frame in frames] == [int(v) for v in FAP_49.split()]
    assert [frame.intra for frame in frames] == [True] * 16 + [False] * 16
    assert {frame.state for frame in frames} == {"UUT" + "U" * 45 + "T" + "U" * 19}
    assert [frame.time for frame in frames[:2]] == [(0, 1), (1, 30)]
    assert [frames[i].time for i in (15, 16, 31)] == [(1, 2), (8, 15), (31, 30)]


def test_example_written_from_coefficients() -> None:
    first = dct_intra({3: listed([6, -5, 0, 2]), 49: coefficients(-3, {15: 1})})
    second = dct_inter(first, {3: listed([-2, 1], is_intra=False), 49: listed([0], is_intra=False)})
    assert write_stream(stream(first, second)) == EXAMPLE
    assert write_stream(read_stream(EXAMPLE)) == EXAMPLE


# -- planes of other kinds ---------------------------------------------------------------------------------------------


def test_arithmetic_and_dct_planes_alternate() -> None:
    """At fap_quant 8 the DC step of FAP 3 is 30: a DC of 4 is 30. Limits are kept over DCT planes (FBA-19)."""
    arithmetic = intra({3: 10, 4: 5}, ranges=all_lists(1))
    dct = dct_intra({3: listed([4]), 5: listed([8])})
    again = intra({3: -7, 4: 1})
    planes = [
        arithmetic, inter(arithmetic, {3: 1}), dct, dct_inter(dct, {3: listed([4], is_intra=False)}), again,
        inter(again, {3: 2}), dct_intra({3: listed([-4])}),
    ]  # fmt: skip
    data = write_stream(stream(*planes))
    frames, _, error = decoded(data)
    assert error is None
    assert [frame.faps[2] for frame in frames] == [40, 44] + [30] * 16 + [60] * 16 + [-28, -20] + [-30] * 16
    assert frames[2].faps[3:5] == (10, 60)
    assert frames[2].state[2:5] == "TRT"
    assert frames[34].state[2:5] == "TTR"
    # The last DC is the value itself: an intra plane resets the predictors.
    assert [frame.coding_type for frame in frames if frame.intra][::16] == [0, 1, 1]
    assert write_stream(read_stream(data)) == data
    check_partition(data)


def test_the_coding_type_in_force_stays_until_an_intra_plane() -> None:
    dct = dct_intra({3: listed([4])})
    data = write_stream(stream(dct, empty(), dct_inter(dct), dct_inter(dct, {3: listed([1], is_intra=False)})))
    frames = decoded(data)[0]
    assert len(frames) == 16 + 1 + 16 + 16
    assert [frames[i].faps[2] for i in (15, 16, 17, 33)] == [30, 30, 30, 38]
    assert [frames[i].state[2] for i in (15, 16, 17)] == ["T", "R", "T"]


def test_an_inter_segment_first_is_inconsistent() -> None:
    data = write_faulty(stream(dct_intra({3: listed([4])})), [Mutation("is_intra", "wire", 0)])
    error = check_input(data)
    assert error is not None
    assert (error.error_class, error.rule, error.bits) == ("InconsistentSemantics", "FBA-35", (32, 33))


def test_states_of_masks() -> None:
    first = dct_intra({3: listed([4]), 19: listed([1]), 31: listed([0])}, types={3: 2, 4: 3})
    second = dct_intra({4: listed([2])}, types={4: 1})
    frames = decoded(write_stream(stream(first, second, empty())))[0]
    letters = "UUT" + "U" * 15 + "T" + "I" * 11 + "T" * 8 + "U" * 30
    assert [frame.state for frame in frames[:16]] == [letters] * 16
    assert frames[0].faps[19] is None
    assert frames[0].faps[31] == 0
    # Type 1 without a bit retains; type 0 retains what was decoded; type 2 not sent again is retained too.
    after = "UURT" + "U" * 14 + "R" + "U" * 11 + "R" * 8 + "U" * 30
    assert [frame.state for frame in frames[16:32]] == [after] * 16
    assert frames[32].state == after.replace("T", "R")
    assert frames[32].faps[2] == 30


def test_times_over_segments() -> None:
    """Skipped frames lie behind a segment; a plane without data is one instant (DCT-13)."""
    first = dct_intra({3: listed([0])}, rate=(25, 0, 0), time=(0, 1, 0), skip=3)
    planes = [first, dct_inter(first, skip=0), empty(skip=1), dct_inter(first)]
    frames = decoded(write_stream(stream(*planes)))[0]
    ticks = [60 * 25 + n for n in (*range(16), *range(19, 35), 35, *range(37, 53))]
    assert [frame.time[0] * 25 == n * frame.time[1] for frame, n in zip(frames, ticks, strict=True)] == [True] * 49


def test_baps_stand_on_the_first_line() -> None:
    first = body({2: 7, 5: -3}, face=dct_intra({3: listed([4])}), ranges=all_lists(1))
    second = dct_inter(first, baps={2: 1, 5: 0})
    data = write_stream(stream(first, second))
    frames = decoded(data)[0]
    assert [index for index, frame in enumerate(frames) if frame.baps is not None] == [0, 16]
    assert frames[0].baps is not None and list(frames[0].baps) == [2, 5]
    assert frames[16].baps is not None and frames[16].baps[5] == frames[0].baps[5]
    assert frames[16].baps[2] * 7 == frames[0].baps[2] * 8
    check_partition(data)
    assert write_stream(read_stream(data)) == data


# -- start codes in the payload ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", [0xB0, 0xB1, 0xB2, 0xB5, 0xBA, 0xBB, 0xBC])
def test_a_start_code_in_the_payload_is_parsed(code: int) -> None:
    """A wide DC is a 1, 15 zeros, and 31 bits that may begin with more zeros: bytes 00 00 01 xx come about."""
    found = 0
    for shift in range(7, 15):
        value = (0x100 | code) << shift
        plane = dct_intra({3: coefficients(value, {1: 3}), 4: listed([9, 1])})
        items = stream(plane, dct_inter(plane, {4: listed([-9], is_intra=False)}))
        data = write_stream(items)
        assert [p.boundary for p in items[0].fba.planes] == [0, 0]  # type: ignore[union-attr]
        at = data.find(bytes((0, 0, 1, code)), 4)
        if 32 <= 8 * at < plane.end - 32:
            found += 1
        frames, _, error = decoded(data)
        assert error is None
        assert len(frames) == 32
        assert frames[31].faps[3] == 0
        assert plain(read_stream(data)[0].fba.planes[0].faps.segment) == plain(plane.faps.segment)  # type: ignore[union-attr]
        check_partition(data)
    assert found == 1


# -- faults ------------------------------------------------------------------------------------------------------------


def small() -> bytes:
    """A stream of all kinds of DCT elements."""
    first = dct_intra(
        {3: coefficients(40_000, {1: 300, 15: -40_000}), 31: listed([1, 0, 0, 5])},
        viseme=[(1, 2, 3, 0), (2, 1, 60, 1)], expression=[(1, 2, 3, 4, 0, 0), (3, 0, 63, 0, 1, 1)],
    )  # fmt: skip
    second = dct_inter(
        first,
        {3: coefficients(300, {2: 1}, is_intra=False), 31: coefficients(-70_000, is_intra=False)},
        viseme=[(14, 0, 0, 0)], expression=[(6, 6, 63, 63, 0, 0)],
    )  # fmt: skip
    return write_stream(stream(first, second, dct_intra({3: listed([1])})))


def _bytes(bits: str, filler: str) -> bytes:
    bits += filler * (-len(bits) % 8)
    return int(bits or "0", 2).to_bytes(len(bits) // 8, "big")


@pytest.mark.parametrize("filler", "01")
def test_truncation_behind_every_bit(filler: str) -> None:
    data = small()
    bits = f"{int.from_bytes(data, 'big'):0{8 * len(data)}b}"
    classes = set()
    for n in range(8, len(bits)):
        error = check_input(_bytes(bits[:n], filler))
        classes.add("" if error is None else error.error_class)
    assert "Truncated" in classes


def test_every_single_bit_flip() -> None:
    data = small()
    classes = set()
    for bit in range(8 * len(data)):
        broken = bytearray(data)
        broken[bit >> 3] ^= 0x80 >> (bit & 7)
        error = check_input(bytes(broken))
        classes.add("" if error is None else error.error_class)
    assert classes >= {"", "RangeViolation", "Truncated", "MarkerBit"}


@pytest.mark.parametrize(
    ("element", "path", "to", "what"),
    [
        ("viseme_select1", "plane[0]", 15, "viseme_select1"),
        ("viseme_select2", "plane[0]", 15, "viseme_select2"),
        ("expression_select1", "plane[0]", 7, "expression_select1"),
        ("expression_select2", "plane[0]", 7, "expression_select2"),
        ("viseme_select1_difference", "plane[1]", 28, "viseme_select1"),
        ("viseme_select2_difference", "plane[1]", 0, "viseme_select2"),
        ("viseme_blend_difference", "plane[1]", 126, "viseme_blend"),
        ("expression_select1_difference", "plane[1]", 12, "expression_select1"),
        ("expression_select2_difference", "plane[1]", 0, "expression_select2"),
        ("expression_intensity1_difference", "plane[1]", 126, "expression_intensity1"),
        ("expression_intensity2_difference", "plane[1]", 0, "expression_intensity2"),
    ],
)
def test_values_outside_their_set(element: str, path: str, to: int, what: str) -> None:
    first = dct_intra(viseme=[(1, 1, 5, 0)], expression=[(1, 1, 5, 5, 0, 0)])
    second = dct_inter(first, viseme=[(1, 1, 5, 0)], expression=[(1, 1, 5, 5, 0, 0)])
    mutation = Mutation(element, "value", to, path)
    error = check_input(write_faulty(stream(first, second), [mutation]))
    assert error is not None
    assert (error.error_class, error.rule, error.what) == ("RangeViolation", "DCT-12", what)
    assert [error.bits] == mutation.spans


@pytest.mark.parametrize("element", ["dc", "run", "ac", "dc_difference", "viseme_blend_difference", "dc_escape"])
def test_truncated_elements(element: str) -> None:
    data = small()
    mutation = Mutation(element, "cut", 1)
    broken = write_faulty(read_stream(data), [mutation])
    error = check_input(broken)
    if element in ("run", "ac"):
        # Short words: what fills the last byte may end them.
        assert error is None or error.error_class in ("Truncated", "RangeViolation", "InconsistentSemantics")
        return
    assert error is not None
    assert (error.error_class, error.what) == ("Truncated", element)
    assert error.bits == (mutation.spans[0][0], 8 * len(broken))


def test_a_level_of_zero_has_no_word() -> None:
    """The writer cannot send a zero without an escape: symbol 256 is the escape itself."""
    plane = dct_intra({3: coefficients(0, {4: 0})})
    data = write_faulty(stream(plane), [])
    assert [e.id for e in decoded(data)[1]] == ["no-sequence-header", "non-canonical", "provisional-tables"]
    with pytest.raises(EncodeError):
        write_stream(stream(dct_intra(viseme=[(15, 0, 0, 0)])))


@pytest.mark.parametrize("shift", range(3))
def test_segments_across_windows_of_the_cursor(shift: int) -> None:
    """Words and wide fields over the 64 KiB boundaries of the reader's window, from memory and from a pipe."""
    runs = {
        fap: coefficients(-(2**30) + fap, {k: (2**30 - fap * k if k % 4 else 3 - k) for k in range(1, 16)})
        for fap in range(3, 69)
    }
    planes = [empty(is_intra=1) for _ in range(shift)] + [dct_intra(runs, quant=1) for _ in range(17)]
    items = stream(*planes)
    data = write_stream(items)
    assert len(data) > (1 << 16) + 1000
    wanted = [frame for plane in planes for frame in plane.frames]
    assert decoded(data)[0] == wanted
    assert decoded(PipeSource(BytesIO(data)))[0] == wanted
    assert write_stream(read_stream(data)) == data
