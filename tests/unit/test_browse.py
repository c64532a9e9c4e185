"""The terminal browser: its document by laws, its keys in a terminal that is none.

Rules: CNF-17, CNF-19, CNF-21, CNF-23.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from textual.pilot import Pilot
from textual.widgets import Static, Tree

from snhc.analyzer.browse.app import Browser
from snhc.analyzer.browse.document import Document, Place
from snhc.analyzer.parts import Parts
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import trace_stream, write_stream
from snhc.vectors.builders import inter, intra, stream

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
FILES = [
    path for path in sorted(SAMPLES.glob("*/*/input.*"))
    if path.suffix in (".fba", ".m2d") and path.stat().st_size < 3_000
][::4]  # fmt: skip
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")


def document(data: bytes, most: int = 10_000) -> Document:
    source = BytesSource(data)
    return Document(source, Parts(trace_stream(source)), most)


def whole(data: bytes) -> Document:
    out = document(data)
    while out.read(7):
        pass
    return out


# -- the document ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name)
def test_every_bit_is_in_the_row_that_holds_it(path: Path) -> None:
    data = path.read_bytes()
    doc = whole(data)
    covered = 0
    for index, part in enumerate(doc.parts):
        for row in range(len(part.trace)):
            start, end = part.trace.start[row], part.trace.end[row]
            covered += end - start
            for bit in {start, (start + end) // 2, end - 1}:
                if start <= bit < end:
                    assert doc.at_bit(bit) == Place(index, row)
    if doc.error is None:
        assert covered == 8 * len(data)
    assert doc.at_bit(8 * len(data)) is None


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name)
def test_a_search_comes_round(path: Path) -> None:
    doc = whole(path.read_bytes())
    word = "marker_bit" if any("marker_bit" in doc.row_title(i, r) for i, r in _rows(doc)) else "code"
    wanted = [Place(i, r) for i, r in _rows(doc) if word in doc.parts[i].trace.el(r).name]
    found: list[Place] = []
    place: Place | None = None
    for _ in wanted:
        place = doc.search(word, place)
        assert place is not None
        found.append(place)
    assert found == wanted
    assert doc.search(word, place) == wanted[0]
    back = [place]
    for _ in wanted[1:]:
        place = doc.search(word, place, backwards=True)
        back.append(place)
    assert back == wanted[::-1]
    assert doc.search("no such word", None) is None


def _rows(doc: Document) -> list[tuple[int, int]]:
    return [(index, row) for index, part in enumerate(doc.parts) for row in range(len(part.trace))]


def test_words_of_a_search() -> None:
    doc = whole(WORKED)
    place = doc.search("fap_quant=1", None)
    assert place is not None
    assert doc.row_title(place.part, place.row) == "fap_quant = 1"
    assert doc.search("fap_quant=2", None) is None
    assert doc.search("head_pitch", None) == doc.search("FAP 48", None), "labels of symbols are searched"
    assert doc.search("FBA-16 group", None) is None
    assert doc.search("FBA-16 new_minmax[2]", None) is not None


def test_details() -> None:
    doc = whole(WORKED)
    place = doc.search("number_of_frames_to_skip", None)
    assert place is not None
    details = doc.details(place)
    found: dict[str, str] = {}
    for label, text in details:
        found.setdefault(label, text)
    assert found["element"] == "number_of_frames_to_skip"
    assert found["path"].startswith("plane[2]")
    assert found["rule"].startswith("FBA-8 ")
    # The span, checked by hand: bits of the worked stream.
    start, end = doc.span(place)
    assert found["bits"].startswith(f"[{start}, {end}), 4 bits")
    assert found["raw"] == f"{int.from_bytes(WORKED, 'big') >> (8 * len(WORKED) - end) & 15:04b}"
    segment = doc.search("fap_segment", None)
    assert segment is not None
    assert [text.split()[:2] for label, text in doc.details(segment) if label == "\t"] == [["FAP", "3"], ["FAP", "48"]]


def test_more_than_the_limit_is_said() -> None:
    first = intra({3: 1})
    data = write_stream(stream(first, *(inter(first, {3: 0}) for _ in range(50))))
    doc = document(data, most=10)
    while doc.read(4):
        pass
    assert (len(doc.parts), doc.whole) == (10, False)
    assert whole(data).whole


# -- the keys ----------------------------------------------------------------------------------------------------------


def drive(
    data: bytes, steps: Callable[[Pilot[Any], Browser], Awaitable[None]], most: int = 10_000, columns: int = 120
) -> None:
    async def main() -> None:
        app = Browser(document(data, most), "stream.fba")
        async with app.run_test(size=(columns, 40)) as pilot:
            await app.workers.wait_for_complete()
            await pilot.pause()
            await steps(pilot, app)

    asyncio.run(main())


def _details(app: Browser) -> str:
    from rich.console import Console

    console = Console(width=200, no_color=True)
    with console.capture() as capture:
        console.print(app.query_one("#details", Static).content)
    return capture.get()


async def _answer(pilot: Pilot[Any], key: str, text: str) -> None:
    await pilot.press(key)
    for letter in text:
        await pilot.press({"_": "underscore", " ": "space", ":": "colon", "=": "equals_sign"}.get(letter, letter))
    await pilot.press("enter")
    await pilot.pause()
    await pilot.pause()


@pytest.mark.parametrize(("columns", "per_line"), [(160, 16), (110, 8), (80, 8), (60, 4)])
def test_hex_lines_fit_the_panel(columns: int, per_line: int) -> None:
    async def steps(pilot: Pilot[Any], app: Browser) -> None:
        # An element of a bit or two, and one whose single bits take the most room.
        for name in ("fap_quant", "i_max"):
            await _answer(pilot, "slash", name)
            hexes = app.query_one("#hex", Static)
            lines = str(hexes.content).rstrip("\n").split("\n")
            assert max(map(len, lines)) <= hexes.size.width, lines
            assert len(lines) <= hexes.size.height
            rows = [line for line in lines if re.match("[0-9a-f]{8}  ", line)]
            assert int(rows[1][:8], 16) - int(rows[0][:8], 16) == per_line
            assert any(line.startswith("bit ") for line in lines)

    drive(WORKED, steps, columns=columns)


def test_keys() -> None:
    async def steps(pilot: Pilot[Any], app: Browser) -> None:
        tree = app.query_one("#tree", Tree)
        assert [str(node.label).partition(":")[0] for node in tree.root.children][:3] == [
            "fba_object  ! 1", "plane 0", "plane 1",
        ]  # fmt: skip
        await _answer(pilot, "slash", "fap_quant")
        assert "FBA-9" in _details(app)
        assert tree.cursor_node is not None
        assert str(tree.cursor_node.label) == "fap_quant = 1"
        await pilot.press("n")
        await pilot.pause()
        assert str(tree.cursor_node.label) == "fap_quant = 1", "there is only one: round again"
        # Byte 31 bit 1 is bit 249, is_frame... of plane 1: the element that the document finds there.
        await _answer(pilot, "b", "31:1")
        place = app.document.at_bit(249)
        assert place is not None
        assert app.document.parts[place.part].trace.el(place.row).name in _details(app)
        await _answer(pilot, "p", "2")
        assert "plane 2" in _details(app)
        await _answer(pilot, "p", "77")
        assert app.status == "no plane '77' in what has been read"
        await _answer(pilot, "b", "x")
        assert app.status == "no bit 'x' in what has been read"
        await pilot.press("e")
        await pilot.pause()
        assert "no-sequence-header" in _details(app)
        theme = app.theme
        await pilot.press("d")
        assert app.theme != theme
        await pilot.press("q")

    drive(WORKED, steps)


def test_a_broken_stream_shows_its_fault() -> None:
    async def steps(pilot: Pilot[Any], app: Browser) -> None:
        assert "ends with an error: Truncated" in app.status
        await pilot.press("e")
        await pilot.pause()
        assert "error" in _details(app)
        assert "FBA-27" in _details(app)

    drive(WORKED[:30], steps)


def test_the_limit_is_said() -> None:
    async def steps(pilot: Pilot[Any], app: Browser) -> None:
        assert app.status.startswith("2 parts; there is more: --planes")

    drive(WORKED, steps, most=2)


def test_without_a_terminal_it_says_so(tmp_path: Path) -> None:
    file = tmp_path / "a.fba"
    file.write_bytes(WORKED)
    result = CliRunner().invoke(snhc, ["browse", str(file)])
    assert result.exit_code == 2
    assert "needs a terminal" in result.stderr
