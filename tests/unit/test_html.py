"""The page of a stream: its data, its limits, and that nothing of a stream is markup. tests/browser has the rest."""

from __future__ import annotations

import base64
import json
import re
from array import array
from pathlib import Path
from typing import Any

import pytest

from snhc.analyzer.html import columns, frames, page
from snhc.analyzer.html.packing import packed
from snhc.analyzer.html.page import SCRIPTS, dump_html
from snhc.analyzer.parts import Parts, Selection
from snhc.reference_impl.bitstream.errors import ResourceLimit
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, trace_stream

TESTS = Path(__file__).parents[1]
SAMPLES = TESTS / "fixtures" / "samples"
FACE = (SAMPLES / "fba" / "fba-11-00003" / "input.fba").read_bytes()
DCT = (SAMPLES / "dct" / "dct-11-00003" / "input.fba").read_bytes()
MESH = (TESTS.parent / "vectors" / "suite" / "mesh" / "mesh.real.flag.small.m2d").read_bytes()
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
HOSTILE = b"</script><script>alert(1)</script><!--<img src=x onerror=alert(2)>"


def page_of(data: bytes, name: str = "a.fba", selection: Selection | None = None, symbols: bool = False) -> str:
    parts = Parts(trace_stream(data), selection)
    return "".join(dump_html(parts, BytesSource(data), DEFAULT_OPTIONS, name, symbols))


def data_of(text: str) -> dict[str, Any]:
    match = re.search(r'<script type="application/json" id="snhc-data">(.*?)</script>', text, re.DOTALL)
    assert match is not None
    data: dict[str, Any] = json.loads(match[1])
    return data


def unpacked(text: str) -> array[Any]:
    column = array(text[0])
    column.frombytes(base64.b64decode(text[2:]))
    return column


@pytest.mark.parametrize("data", [FACE, DCT, MESH, WORKED, WORKED[:32], WORKED + b"\x80behind"])
def test_the_columns_are_the_trace(data: bytes) -> None:
    made = data_of(page_of(data))
    rows = [
        (part.trace.el(row).name, part.trace.end[row] - part.trace.start[row], part.trace.value[row])
        for part in Parts(trace_stream(data))
        for row in range(len(part.trace))
    ]
    columns = {name: unpacked(text) for name, text in made["rows"].items()}
    found = zip(columns["element"], columns["width"], columns["value"], strict=True)
    assert [(made["elements"][element]["name"], width, value) for element, width, value in found] == rows
    assert base64.b64decode(made["bytes"]) == data
    levels = [
        level
        for part in Parts(trace_stream(data))
        for segment, _ in part.trace.segments.values()
        for level in segment.levels
    ]
    assert list(unpacked(made["symbols"]["level"])) == levels
    assert len(unpacked(made["symbols"]["shifts"])) == len(levels)


def test_every_rule_that_is_named_is_explained() -> None:
    made = data_of(page_of(FACE))
    assert {element["rule"] for element in made["elements"]} <= set(made["rules"])
    asked = {id for rule in made["rules"].values() for id in rule["ambiguities"]}
    assert asked == set(made["ambiguities"])
    assert all(rule["statement"] and rule["confidence"] for rule in made["rules"].values())


def test_pages_are_the_same_every_time() -> None:
    assert page_of(FACE) == page_of(FACE)
    assert page_of(MESH) == page_of(MESH)


def test_nothing_of_a_stream_is_markup() -> None:
    data = bytes.fromhex("000001b061000001b2") + HOSTILE + bytes.fromhex("000001b5") + bytes([0b0_0100_011]) + WORKED
    text = page_of(data, name="</script><b>.fba")
    assert "<b>" not in text
    assert data_of(text)["name"] == "</script><b>.fba"
    assert text.count("<script") == 2
    # Text reaches the page by `append` and `textContent` only.
    scripts = "".join((Path(page.__file__).parent / script).read_text() for script in SCRIPTS)
    for way in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "new Function"):
        assert way not in scripts


def test_nothing_is_loaded() -> None:
    text = page_of(WORKED)
    assert "default-src 'none'" in text
    for way in ("http:", "https:", "fetch(", "XMLHttpRequest", "import(", "@import", "url("):
        assert way not in text


def test_a_fault_and_what_it_leaves_are_there() -> None:
    made = data_of(page_of(WORKED[:32]))
    assert made["error"]["class"] == "Truncated"
    assert made["unclaimed"] == [250, 256]
    assert "FBA-27" in made["rules"]


def test_selected_planes_have_their_bytes_only() -> None:
    made = data_of(page_of(WORKED, selection=Selection(0, 1, 2)))
    assert made["selected"]
    assert (made["firstByte"], base64.b64decode(made["bytes"])) == (246 >> 3, WORKED[246 >> 3 : 34])
    assert list(unpacked(made["parts"]["plane"])) == [1]


def test_registers_of_the_coder_only_when_asked_for() -> None:
    assert "low" not in data_of(page_of(WORKED))["symbols"]
    made = data_of(page_of(WORKED, symbols=True))["symbols"]
    assert unpacked(made["high"])[0] == 65535


@pytest.mark.parametrize(("what", "most"), [("MOST_ROWS", 20), ("MOST_SYMBOLS", 2)])
def test_a_stream_too_large_for_a_page_is_refused(what: str, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, what, most)
    with pytest.raises(ResourceLimit, match="--planes"):
        page_of(WORKED)
    monkeypatch.undo()
    monkeypatch.setattr(page, "MOST_BYTES", 10)
    with pytest.raises(ResourceLimit, match="--planes"):
        page_of(WORKED)


def test_padding_of_any_length_is_refused_and_not_a_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "MOST_BYTES", 1000)
    padded = WORKED[:37] + bytes([WORKED[37] & 0xFC]) + bytes(2000)
    with pytest.raises(ResourceLimit, match="bytes of the page"):
        page_of(padded)


def test_values_of_any_size_fit_a_column() -> None:
    assert frames._column([1, None, -5])[0] == "i"
    huge = frames._column([1 << 40, None])
    assert (huge[0], list(unpacked(huge))) == ("d", [float(1 << 40), float(frames.UNSET)])


def test_columns_are_little_endian() -> None:
    assert packed("H", [1, 256]) == "H:" + base64.b64encode(bytes([1, 0, 0, 1])).decode()
