"""Dumps in JSON encode again: unchanged to the same bytes, edited to what they say."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from snhc.analyzer.dump_encode import encode_dump
from snhc.analyzer.dump_json import dump_json
from snhc.analyzer.parts import Parts, Selection
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import EncodeError, InputFormat, ResourceLimit
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, decode_frames, read_stream, trace_stream

TESTS = Path(__file__).parents[1]
SUITE = TESTS.parent / "vectors" / "suite"
STREAMS = sorted(
    path
    for folder in (TESTS / "fixtures" / "samples", SUITE)
    for suffix in ("fba", "m2d")
    for path in folder.rglob(f"*.{suffix}")
    if path.read_bytes().startswith(b"\0\0\1")
)
SAMPLE = (TESTS / "fixtures" / "samples" / "fba" / "fba-11-00003" / "input.fba").read_bytes()
MESH = (SUITE / "mesh" / "mesh.delaunay.triangle.m2d").read_bytes()
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")


def dumped(data: bytes, options: Options = DEFAULT_OPTIONS, selection: Selection | None = None) -> str:
    parts = Parts(trace_stream(data, options, symbols=False), selection)
    return "".join(dump_json(parts, BytesSource(data), options))


def test_there_are_streams_of_every_kind() -> None:
    names = {path.parent.name.split("-")[0] for path in STREAMS}
    assert len(STREAMS) > 400
    assert {"fba", "dct", "mesh", "neg", "sys"} <= names


@pytest.mark.parametrize("draft", [False, True])
@pytest.mark.parametrize("which", range(8))
def test_unchanged_dumps_give_the_same_bytes(which: int, draft: bool) -> None:
    """Good streams and broken ones: what a fault leaves unread is in the dump too."""
    options = Options(draft=draft)
    done = 0
    for path in STREAMS[which::8]:
        data = path.read_bytes()
        try:
            text = dumped(data, options)
        except InputFormat:
            continue
        assert encode_dump(text.encode()) == data, path
        done += 1
    assert done > 40


def test_with_headers_user_data_and_bytes_behind_the_end() -> None:
    # visual_object: no identifier, type 4 (FBA), stuffing 0b011
    head = bytes.fromhex("000001b061000001b2686921000001b5") + bytes([0b0_0100_011])
    data = head + WORKED + b"\x80behind"
    assert encode_dump(dumped(data).encode()) == data
    document = json.loads(dumped(data))
    element = next(e for part in document["parts"] for e in part["elements"] if e["element"] == "user_data")
    element["bytes"] = b"longer than before".hex()
    made = encode_dump(json.dumps(document).encode())
    assert read_stream(made)[1].user_data == b"longer than before"
    element["bytes"] = "000001b2"
    with pytest.raises(EncodeError, match="no start code prefix"):
        encode_dump(json.dumps(document).encode())


def edited(data: bytes, change: Callable[[dict[str, Any]], bool]) -> bytes:
    """The stream of a dump of which the first element is changed that `change` takes (it then returns true)."""
    document = json.loads(dumped(data))
    assert any(change(element) for part in document["parts"] for element in part["elements"])
    return encode_dump(json.dumps(document).encode())


def set_value(name: str, value: int) -> Callable[[dict[str, Any]], bool]:
    def change(element: dict[str, Any]) -> bool:
        if element["element"] != name:
            return False
        element["value"] = value
        return True

    return change


def test_an_edited_level_moves_the_value_and_nothing_else() -> None:
    def change(element: dict[str, Any]) -> bool:
        if element["element"] != "fap_segment":
            return False
        element["levels"][0] += 3
        return True

    before, after = list(decode_frames(WORKED)), list(decode_frames(edited(WORKED, change)))
    # FAP 3 has base step 1 and quant 4.
    moved = [(b.faps[2], a.faps[2]) for b, a in zip(before, after, strict=True)]
    assert all(a - b == 12 for b, a in moved)
    assert [b.faps[3:] for b in before] == [a.faps[3:] for a in after]


def test_an_edited_field_says_what_it_says() -> None:
    quant = next(frame.fap_quant for frame in decode_frames(WORKED))
    assert quant != 9
    made = edited(WORKED, set_value("fap_quant", 9))
    assert next(iter(decode_frames(made))).fap_quant == 9


def test_an_edited_mesh_moves_its_node() -> None:
    made = edited(MESH, set_value("node0_x", 5))
    (before, *_), (after, *_) = decode_frames(MESH), decode_frames(made)
    assert after.nodes[0][0] == 5
    assert len(after.nodes) == len(before.nodes)


def test_bits_behind_a_longer_element_move() -> None:
    """A delta of two bits more: everything behind it moves, and the stuffing is made anew."""
    document = json.loads(dumped(MESH))
    rows = [element for part in document["parts"] for element in part["elements"]]
    at = next(k for k, element in enumerate(rows) if element["element"] == "delta_x" and element["value"] > 1)
    length = rows[at - 1]["value"]
    rows[at - 1]["value"] = length + 2
    rows[at]["value"] = 4 * rows[at]["value"]
    made = encode_dump(json.dumps(document).encode())
    (before, *_), (after, *_) = decode_frames(MESH), decode_frames(made)
    assert after.nodes != before.nodes
    assert len(made) >= len(MESH)
    assert encode_dump(dumped(made).encode()) == made


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("fap_quant", 32, "fap_quant=32 (plane[0].fap): allowed 0..31 (FBA-9)"),
        ("marker_bit", 0, "marker_bit=0 (plane[0].fap.group[1]): allowed 1 (FBA-10)"),
        ("is_intra", 0, "allowed 1, before any inter plane with data of this kind (FBA-35)"),
        ("is_frame_rate", 0, "is_time_code=frame_rate (parts[1].elements[4])"),
        ("fba_object_mask", 0, "allowed this element here"),
    ],
)
def test_what_cannot_be_is_refused_at_its_place(name: str, value: int, said: str) -> None:
    with pytest.raises(EncodeError) as caught:
        edited(WORKED, set_value(name, value))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"version": 2}, "version"),
        ({"planes": [0, 1]}, "a part of a stream"),
        ({"query": "true"}, "a part of a stream"),
        ({"parts": 7}, "parts"),
        ({"parts": [{"elements": [{}]}]}, "parts[0].elements[0].element"),
        ({"parts": [{"elements": [{"element": "x", "bits": [0]}]}]}, "bits"),
        ({"parts": [{"elements": [{"element": "x", "bits": [0, 8], "bytes": "x"}]}]}, "bytes=x"),
        ({"parts": [{"elements": [{"element": "x", "bits": [0, 8], "value": 1.5}]}]}, "an integer"),
        ({"readings": {"AMB-FBA-99": "x"}}, "AMB-FBA-99"),
    ],
)
def test_documents_that_are_none_are_refused(change: dict[str, Any], said: str) -> None:
    document = json.loads(dumped(WORKED)) | change
    with pytest.raises(InputFormat) as caught:
        encode_dump(json.dumps(document).encode())
    assert said in str(caught.value)


def test_the_verbs_go_round(tmp_path: Path) -> None:
    stream, text, back = tmp_path / "a.fba", tmp_path / "a.json", tmp_path / "b.fba"
    stream.write_bytes(SAMPLE)
    run = CliRunner().invoke
    assert run(snhc, ["dump", str(stream), "-o", str(text), "--symbols"]).exit_code == 0
    assert run(snhc, ["encode", str(text), "-o", str(back)]).exit_code == 0
    assert back.read_bytes() == SAMPLE
    assert run(snhc, ["dump", str(stream), "--planes", "1", "-o", str(text)]).exit_code == 0
    result = run(snhc, ["encode", str(text), "-o", str(back)])
    assert (result.exit_code, "a part of a stream" in result.stderr) == (3, True)


def test_a_dump_may_be_too_long() -> None:
    with pytest.raises(ResourceLimit, match="at most 10 bytes"):
        encode_dump(b'{"format": "snhc-dump"}', limits=Limits(json_bytes=10))
