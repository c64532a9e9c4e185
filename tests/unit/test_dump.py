"""Dumps: the partition law, text and JSON, faults and findings in place."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from snhc.analyzer.dump import TreeOptions, dump_tree
from snhc.analyzer.dump_csv import dump_csv
from snhc.analyzer.dump_json import SCHEMA, dump_json
from snhc.analyzer.elements import settled_bits
from snhc.analyzer.parts import Part, Parts, Selection
from snhc.analyzer.tree import Node, build_tree
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, trace_stream

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
STREAMS = sorted(
    path
    for kind in ("fba", "neg", "dct", "mesh")
    for path in [*(SAMPLES / kind).glob("*/input.fba"), *(SAMPLES / kind).glob("*/input.m2d")]
    # Some of the negative samples are no visual stream at all.
    if path.read_bytes().startswith(b"\0\0\1")
)


def parts_of(data: bytes, selection: Selection | None = None, options: Options = DEFAULT_OPTIONS) -> Parts:
    return Parts(trace_stream(data, options), selection)


def text_of(data: bytes, selection: Selection | None = None, **options: Any) -> str:
    return "".join(dump_tree(parts_of(data, selection), BytesSource(data), TreeOptions(**options)))


def document_of(data: bytes, symbols: bool = False, options: Options = DEFAULT_OPTIONS) -> dict[str, Any]:
    pieces = dump_json(parts_of(data, options=options), BytesSource(data), options, symbols)
    document: dict[str, Any] = json.loads("".join(pieces))
    return document


def elements_of(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [element for part in document["parts"] for element in part["elements"]]


def validator() -> jsonschema.Draft202012Validator:
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_there_are_samples() -> None:
    assert len(STREAMS) >= 50


@pytest.mark.parametrize("path", STREAMS, ids=lambda path: path.parent.name)
def test_the_spans_partition_what_was_read(path: Path) -> None:
    data = path.read_bytes()
    at = 0
    parts = parts_of(data)
    for part in parts:
        for row in range(len(part.trace)):
            assert part.trace.start[row] == at
            at = part.trace.end[row]
    gap = parts.unclaimed(BytesSource(data))
    if parts.error is None:
        assert at == 8 * len(data)
        assert gap is None
    else:
        # A relation can be at fault in an element before the last one, a guard inside the one that failed.
        assert parts.error.bits is not None
        assert (gap or (at, at)) == (at, 8 * len(data))


@pytest.mark.parametrize("path", STREAMS, ids=lambda path: path.parent.name)
def test_json_is_valid_and_holds_the_stream(path: Path) -> None:
    data = path.read_bytes()
    document = document_of(data, symbols=len(data) < 300)
    if len(data) < 1500:
        # The validator is slow; large samples have nothing that small ones lack.
        validator().validate(document)
    bits = "".join(
        element["raw"] if "raw" in element else f"{int('1' + element['bytes'], 16):b}"[1:]
        for element in elements_of(document)
    )
    everything = f"{int.from_bytes(b'1' + data, 'big'):b}"[6:]
    gap = document["unclaimed"]
    if gap is not None:
        assert document["error"] is not None
        assert gap["bits"] == [len(bits), len(everything)]
        bits += gap["raw"] + f"{int('1' + gap['bytes'], 16):b}"[1:]
    assert bits == everything


def leaves(part: Part) -> list[int]:
    return list(build_tree(part.trace).rows())


@pytest.mark.parametrize("path", STREAMS[::8], ids=lambda path: path.parent.name)
def test_the_leaves_of_the_tree_are_the_rows(path: Path) -> None:
    for part in parts_of(path.read_bytes()):
        assert leaves(part) == list(range(len(part.trace)))
        check_names(part, build_tree(part.trace), [])


def check_names(part: Part, node: Node, above: list[str]) -> None:
    """Every row stands below the levels of its path."""
    for child in node.children:
        if isinstance(child, int):
            assert part.trace.path_text(child) == ".".join(above)
        else:
            check_names(part, child, [*above, child.name])


def test_nodes_span_their_rows() -> None:
    part = list(parts_of(WORKED))[1]
    plane = build_tree(part.trace).children[1]
    assert not isinstance(plane, int)
    assert (plane.name, plane.start, plane.end) == ("plane[0]", 32, 246)
    fap = plane.children[-1]
    assert not isinstance(fap, int)
    assert (fap.name, fap.start, fap.end) == ("fap", 51, 246)


def test_text_shows_spans_bits_values_meanings_and_rules() -> None:
    lines = text_of(WORKED).splitlines()
    line = next(line for line in lines if "fba_object_mask" in line)
    assert line.split(None, 2)[:2] == ["[33,", "35)"]
    assert "fba_object_mask = 1 (FAP data)" in line
    assert line.endswith("FBA-5")
    assert " .01..... " in line
    assert any("plane[1]: inter, FAP data, time 1/25 s" in line and line.startswith("[246, 270)") for line in lines)
    assert any("fap_segment = 2 symbols: 0 11" in line for line in lines)


def test_columns_are_aligned() -> None:
    rules = [line.rindex("FBA-") for line in text_of(WORKED).splitlines() if "marker_bit" in line]
    assert len(set(rules)) == 1


def test_findings_stand_in_place() -> None:
    lines = text_of(WORKED[:-4]).splitlines()
    assert "no-sequence-header" in lines[2]
    assert "no-end-code" in lines[-1]
    parts = document_of(WORKED[:-4])["parts"]
    assert [finding["id"] for finding in parts[-1]["findings"]] == ["no-end-code"]


def test_an_error_stands_at_the_end_behind_its_elements() -> None:
    cut = WORKED[:32]
    lines = text_of(cut).splitlines()
    assert "error: Truncated: fap_segment at bits [250, 256)" in lines[-2]
    assert "skip_frames = 0" in lines[-3]
    assert lines[-1].startswith("[250, 256)")
    assert lines[-1].endswith("unclaimed: 6 bits from the fault to the end")
    document = document_of(cut)
    validator().validate(document)
    assert document["error"]["class"] == "Truncated"
    assert document["error"]["bits"] == [250, 256]
    assert document["parts"][-1]["kind"] is None
    assert document["parts"][-1]["elements"][-1]["path"] == "plane[1]"


def test_an_error_in_a_header_names_its_item() -> None:
    lines = text_of(bytes.fromhex("000001b580")).splitlines()
    assert lines[1].strip() == "visual_object"
    assert "error: ReservedValue: visual_object_priority=0" in lines[-2]


def test_no_visual_stream_is_refused_before_any_output() -> None:
    with pytest.raises(InputFormat):
        parts_of(b"2.1 name 25 1\n")
    with pytest.raises(InputFormat):
        parts_of(b"")


def test_symbols_are_those_of_the_worked_stream() -> None:
    segment = next(e for e in elements_of(document_of(WORKED, symbols=True)) if e["element"] == "fap_segment")
    assert segment["labels"] == ["FAP 3 open_jaw", "FAP 48 head_pitch"]
    # 100 / 4 and -3400 / 170: the base steps of FAP 3 and FAP 48.
    assert segment["levels"] == [25, -20]
    assert len(segment["symbols"]) == 2
    first = segment["symbols"][0]
    # i_max and i_min are 1080: 2161 symbols, each in a bin of width 1; level 25 is symbol 1105.
    assert (first["low"], first["high"], first["total"], first["symbols"]) == (0, 65535, 2161, 2161)
    assert first["cum"] == [2161 - 1106, 2161 - 1105]
    assert first["bits_read"] == 16
    # All data bits but the 14 of the look-ahead belong to the segment; there are no guards.
    last = segment["symbols"][-1]
    assert last["bits_read"] + last["shifts"] - 14 == segment["bits"][1] - segment["bits"][0]
    assert "FAP 48 head_pitch" in text_of(WORKED, symbols=True)
    assert "FAP 48 head_pitch" not in text_of(WORKED)


def test_guards_are_shown() -> None:
    # A sample with runs of zeros; a guard is a 1 behind 22 zero bits, and a run of them begins anew behind it.
    data = (SAMPLES / "fba" / "fba-11-00003" / "input.fba").read_bytes()
    shown = 0
    for element in elements_of(document_of(data)):
        first = element["bits"][0]
        for bit in element.get("guards", []):
            assert element["raw"][bit - first - 22 : bit - first + 1] == "0" * 22 + "1"
            shown += 1
    assert shown > 100
    assert sum(" guard " in line for line in text_of(data).splitlines()) == shown
    assert sum(" guard " in line for line in text_of(data, symbols=True).splitlines()) == shown


def test_depth_closes_nodes() -> None:
    lines = text_of(WORKED, depth=1).splitlines()
    assert [line.split("plane")[1][:3] for line in lines if "plane[" in line] == ["[0]", "[1]", "[2]"]
    assert not any("is_intra" in line for line in lines)
    deeper = text_of(WORKED, depth=2)
    assert "is_intra" in deeper
    assert "fap_quant" not in deeper


def test_selected_planes_only_and_nothing_read_behind_them() -> None:
    broken_behind = WORKED[:33]
    lines = text_of(broken_behind, Selection(0, 0, 1)).splitlines()
    assert sum("plane[" in line for line in lines) == 1
    assert not any("error" in line for line in lines)
    assert "plane[2]" in text_of(WORKED, Selection(0, 2, None))
    assert "plane[1]" not in text_of(WORKED, Selection(0, 2, None))


def test_planes_count_in_their_object() -> None:
    # The second object begins at bit 304, where the first one ends.
    two = WORKED[:-4] + WORKED
    lines = text_of(two, Selection(1, 0, 1)).splitlines()
    assert lines[2].startswith("[336, 550)")
    assert len([line for line in lines if "plane[" in line]) == 1


def test_colour_only_when_asked_for() -> None:
    assert "\x1b[" not in text_of(WORKED)
    coloured = text_of(WORKED, colour=True)
    assert "\x1b[" in coloured
    plain = re.sub(r"\x1b\[[0-9]*m", "", coloured)
    assert [line.rstrip() for line in plain.splitlines()] == text_of(WORKED).splitlines()


def test_readings_are_named() -> None:
    options = Options(readings=Readings({"AMB-FBA-6": "before"}), limits=DEFAULT_LIMITS)
    document = document_of(WORKED, options=options)
    validator().validate(document)
    assert document["readings"] == {"AMB-FBA-6": "before"}


def test_trailing_bytes_are_in_the_json() -> None:
    document = document_of(WORKED + b"\x80xyz")
    validator().validate(document)
    assert elements_of(document)[-1]["bytes"] == b"\x80xyz".hex()
    assert "80 78 79 7a" in text_of(WORKED + b"\x80xyz")


def test_padding_takes_no_room() -> None:
    # The planes end at bit 302; the rest is zeros.
    padded = WORKED[:37] + bytes([WORKED[37] & 0xFC]) + bytes(1_000_000)
    document = document_of(padded)
    validator().validate(document)
    last = elements_of(document)[-1]
    assert last["element"] == "zero_padding"
    assert last["bits"] == [302, 8 * len(padded)]
    assert "raw" not in last
    assert len(json.dumps(document)) < 60_000


def test_bytes_stand_beside_the_tree_bit_by_bit() -> None:
    """Bits are shown once, by the element that they belong to, in their place in their byte."""
    shown: dict[int, str] = {}
    for line in text_of(WORKED, all_bytes=True).splitlines()[1:]:
        match = re.match(r"\[(\d+), (\d+)\) +([0-9a-f]{6}) +([01. ]{8,26})  ", line)
        if match is None:
            continue
        first = 8 * int(match[3], 16)
        for at, digit in enumerate(match[4].rstrip().replace(" ", "")):
            if digit in "01":
                assert first + at not in shown
                shown[first + at] = digit
        assert sum(digit in "01" for digit in match[4]) == int(match[2]) - int(match[1])
    bits = f"{int.from_bytes(WORKED, 'big'):0{8 * len(WORKED)}b}"
    assert len(shown) > 60
    assert all(bits[at] == digit for at, digit in shown.items())


def test_shared_bytes_of_long_elements_are_marked_and_long_ones_cut() -> None:
    # The segment of the third plane, 20 bits: its first byte is shared with what stands before it.
    line = next(line for line in text_of(WORKED).splitlines() if line.startswith("[282, 302)") and "segment" in line)
    assert "  'a0 0a e5'  " in line
    long = WORKED + bytes(range(200))
    assert len(text_of(long).splitlines()) + 21 == len(text_of(long, all_bytes=True).splitlines())
    assert "|18 19" not in text_of(long)
    assert " 1e ..." in text_of(long)
    assert " 1e ..." not in text_of(long, all_bytes=True)
    assert "|01234567|" in text_of(long, all_bytes=True)


def test_symbols_settle_the_bits_of_their_segment() -> None:
    """In order, without a gap, and all but the last two: those end the segment (FBA-26)."""
    seen = 0
    for path in STREAMS[:40]:
        for part in parts_of(path.read_bytes()):
            for segment, _ in part.trace.segments.values():
                at = segment.start
                for start, end in settled_bits(segment):
                    assert (start, end >= start) == (at, True)
                    at = end
                guards = sum(position >= at for position, _ in segment.guards)
                assert segment.end - at == 2 + guards
                seen += len(segment.guards)
    assert seen > 100


@pytest.mark.parametrize("path", STREAMS[::3], ids=lambda path: path.parent.name)
def test_a_trace_without_symbols_is_the_same_but_for_them(path: Path) -> None:
    data = path.read_bytes()
    pairs = zip(trace_stream(data), trace_stream(data, symbols=False), strict=True)
    for literal, fast in pairs:
        assert list(literal.trace.rows()) == list(fast.trace.rows())
        assert str(literal.error) == str(fast.error)
        for row, (segment, labels) in literal.trace.segments.items():
            assert fast.trace.segments[row] == (replace(segment, steps=(), ahead=(), past_end=False), labels)


def test_csv_has_every_bit_once() -> None:
    rows = list(csv.DictReader("".join(dump_csv(parts_of(WORKED), BytesSource(WORKED))).splitlines()))
    assert "".join(row["raw"] for row in rows) == f"{int.from_bytes(WORKED, 'big'):0{8 * len(WORKED)}b}"
    mask = next(row for row in rows if row["element"] == "fba_object_mask")
    assert (mask["plane"], mask["path"], mask["value"], mask["meaning"]) == ("0", "plane[0]", "1", "FAP data")
    assert next(row for row in rows if row["kind"] == "segment")["levels"] == "25 -20"
    symbols = "".join(dump_csv(parts_of(WORKED), BytesSource(WORKED), symbols=True))
    assert "FAP 48 head_pitch,symbol," in symbols
    cut = WORKED[:32]
    last = "".join(dump_csv(parts_of(cut), BytesSource(cut))).splitlines()[-1]
    assert last.startswith(",,,,unclaimed,unclaimed,250,256,6,")
