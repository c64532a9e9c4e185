"""The page of a stream in a browser: bits to elements and back, keys, search, faults, pictures, many planes."""

from __future__ import annotations

import sys
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Page
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from snhc.analyzer.face_scene import FaceScene, load_model
from snhc.analyzer.html.page import dump_html
from snhc.analyzer.parts import Parts
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, decode_frames, trace_stream

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "benchmarks"), str(TESTS)]
SUITE = TESTS.parent / "vectors" / "suite"
SAMPLES = TESTS / "fixtures" / "samples"
FACE = (SAMPLES / "fba" / "fba-11-00003" / "input.fba").read_bytes()
DCT = (SAMPLES / "dct" / "dct-11-00003" / "input.fba").read_bytes()
MESH = (SUITE / "mesh" / "mesh.real.flag.small.m2d").read_bytes()
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
HOSTILE = b"<img src=x onerror=\"document.title='stolen'\"></script>"

SETTLE = "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 0)));"


class Viewer:
    """A page that is open, with what tests ask of it."""

    def __init__(self, page: Page, data: bytes, path: Path, symbols: bool = False) -> None:
        parts = Parts(trace_stream(data))
        path.write_text(
            "".join(dump_html(parts, BytesSource(data), DEFAULT_OPTIONS, path.name, symbols)), encoding="utf-8"
        )
        self.page = page
        self.browser = page.open(path)
        self.settle()

    def settle(self) -> None:
        self.browser.execute_async_script(SETTLE)

    def run(self, script: str) -> Any:
        found = self.browser.execute_script(script)
        self.settle()
        return found

    def one(self, selector: str) -> Any:
        return self.browser.find_element("css selector", selector)

    def text(self, selector: str) -> str:
        return str(self.one(selector).text)

    def focus(self, selector: str) -> None:
        self.run(f"document.querySelector({selector!r}).focus()")

    def press(self, *keys: str) -> None:
        ActionChains(self.browser).send_keys(*keys).perform()
        self.settle()

    @property
    def selected(self) -> dict[str, Any]:
        found: dict[str, Any] = self.run(
            "const {part, row, symbol, bit, bits} = snhc.app.selected; return {part, row, symbol, bit, bits}"
        )
        return found


@pytest.fixture
def face(page: Page, tmp_path: Path) -> Viewer:
    return Viewer(page, FACE, tmp_path / "face.html", symbols=True)


def test_a_click_on_a_bit_finds_its_element_and_back(face: Viewer) -> None:
    # Byte 4 is 0xa0: is_intra, fba_object_mask (2), and so on; the third bit is the mask's second.
    cell = face.one('[data-byte="4"]')
    width = cell.size["width"]
    ActionChains(face.browser).move_to_element_with_offset(
        cell, int(width * (2.5 / 8) - width / 2), 0
    ).click().perform()
    face.settle()
    assert face.selected["bit"] == 34
    assert face.selected["bits"] == [33, 35]
    assert face.text("#about h3") == "fba_object_mask"
    assert "FBA-5" in face.text("#about .rule h4")
    assert "confirmed" in face.text("#about .rule")
    row = face.one('#tree [aria-selected="true"]')
    assert "fba_object_mask" in row.text
    assert "34" in face.text("#place")
    # And back: a click in the tree selects the bits.
    wanted = next(one for one in face.browser.find_elements("css selector", "#tree .row") if "fap_quant" in one.text)
    wanted.click()
    face.settle()
    assert face.selected["bits"] == [38, 43]
    pressed = face.browser.find_elements("css selector", "#strip .in")
    assert [one.get_attribute("data-bit") for one in pressed] == ["38", "39", "40", "41", "42"]
    # A bit of the strip is a button with a name.
    button = face.one('#strip [data-bit="43"]')
    assert button.get_attribute("aria-label") == "bit 43 is 1, marker_bit"
    button.click()
    face.settle()
    assert face.text("#about h3") == "marker_bit"
    assert face.browser.current_url.endswith("#bit=43")


def test_every_bit_has_the_element_of_the_trace(face: Viewer) -> None:
    found = face.run("""
        const stream = snhc.app.stream;
        return Array.from({ length: stream.endBit }, (_, bit) => {
            const row = stream.rowAt(bit);
            return stream.path(row) + "/" + stream.element(row).name;
        });
    """)
    wanted = [
        f"{part.trace.path_text(row) if not part.closes else ''}/{part.trace.el(row).name}"
        for part in Parts(trace_stream(FACE))
        for row in range(len(part.trace))
        for _ in range(part.trace.start[row], part.trace.end[row])
    ]
    assert found == wanted


def test_symbols_settle_the_same_bits_as_in_the_dump(face: Viewer) -> None:
    from snhc.analyzer.elements import settled_bits

    found = face.run("const s = snhc.app.stream; return Array.from(s.segments.row, (_, segment) => s.settled(segment))")
    wanted = [
        [list(span) for span in settled_bits(segment)]
        for part in Parts(trace_stream(FACE))
        for segment, _ in part.trace.segments.values()
    ]
    assert found == wanted


def test_a_bit_of_a_segment_is_a_symbol_with_the_coder(face: Viewer) -> None:
    face.run("snhc.app.hex.choose(1350)")
    assert face.text("#about h3") == "FAP 3 open_jaw"
    assert "P model" in face.text("#about") or "I model" in face.text("#about")
    assert "FBA-23" in face.text("#about .rule h4")
    # The last two bits belong to no symbol.
    end = face.run(
        "const s = snhc.app.stream; const end = s.end(s.segments.row[0]); snhc.app.hex.choose(end - 1); return end"
    )
    assert face.selected["bits"] == [end - 2, end]
    assert "end the segment" in face.text("#about")


def test_this_bit_moves_that_vertex(face: Viewer) -> None:
    face.run("snhc.app.hex.choose(1350)")
    words = face.text("#head-words")
    assert words.startswith("FAP 3 open_jaw")
    assert face.run("return snhc.app.head.movedVertices") > 50
    # Only the jaw: the brows glow for FAP 31 only.
    jaw = face.run("return Array.from(snhc.app.head.glow).map((by) => by > 0.05)")
    face.run("snhc.app.head.show(0, [31])")
    brow = face.run("return Array.from(snhc.app.head.glow).map((by) => by > 0.05)")
    assert any(brow)
    assert not any(a and b for a, b in zip(jaw, brow, strict=True))


def test_a_value_of_a_range_list_is_of_its_fap(page: Page, tmp_path: Path) -> None:
    # Worked stream 1: FAPs 3 and 48, all four lists.
    viewer = Viewer(page, (SUITE / "fap" / "fap.arith.example.1.fba").read_bytes(), tmp_path / "ranges.html")
    found = viewer.run("""
        const s = snhc.app.stream;
        const rows = Array.from({ length: s.rowCount }, (_, row) => row);
        return rows.filter((row) => s.path(row).includes("new_minmax") && s.fapsOf(row, -1).length)
          .map((row) => [s.element(row).name, s.rows.value[row], ...s.fapsOf(row, -1), row]);
    """)
    names = ("fap_new_i_max", "fap_new_i_min", "fap_new_p_max", "fap_new_p_min")
    values = (18, 18, 6, 6)
    assert [one[:3] for one in found] == [
        [name, value, fap] for name, value in zip(names, values, strict=True) for fap in (3, 48)
    ]
    viewer.run(f"snhc.app.hex.choose(snhc.app.stream.start[{found[1][3]}])")
    assert viewer.text("#head-words").startswith("FAP 48 head_pitch")
    assert viewer.run("return [...snhc.app.curves.strong]") == [48]


def test_objects_stand_one_after_another_on_the_axis(page: Page, tmp_path: Path) -> None:
    one = (SUITE / "fap" / "fap.arith.example.1.fba").read_bytes()
    # An object ends where the next one begins.
    viewer = Viewer(page, one.removesuffix(bytes.fromhex("000001b1")) + one, tmp_path / "objects.html")
    viewer.run("snhc.app.openView('curves', false)")
    time, axis, begins = viewer.run(
        "const c = snhc.app.curves; return [[...snhc.app.stream.face.time], [...c.axis], [...c.begins]]"
    )
    half = len(time) // 2
    assert time[:half] == time[half:] and half > 1 and begins == [half]
    assert all(a < b for a, b in pairwise(axis)) and axis[:half] == time[:half]
    # Every place on the axis chooses its own frame: also those of the second object.
    frames = viewer.run(
        "const c = snhc.app.curves; return [...c.axis].map((_, i) => { c._choose(i); return c.frame; })"
    )
    assert frames == list(range(len(time)))
    page.shot("objects")


@cache
def viseme_stream() -> bytes:
    """Any stream of the suite with visemes that decodes."""
    for path in sorted((SUITE / "fap").glob("*viseme*.fba")):
        if "error" not in path.name:
            data = path.read_bytes()
            if any(getattr(frame, "viseme", None) for frame in decode_frames(data)):
                return data
    raise AssertionError("no stream with visemes")


@pytest.mark.parametrize("which", ["arithmetic", "dct", "viseme"])
def test_the_head_is_posed_as_the_reference_poses_it(page: Page, tmp_path: Path, which: str) -> None:
    data = {"arithmetic": WORKED, "dct": DCT, "viseme": viseme_stream()}[which]
    viewer = Viewer(page, data, tmp_path / "head.html")
    frames = [frame for frame in decode_frames(data) if hasattr(frame, "faps")]
    scene = FaceScene(load_model())
    for index in {0, len(frames) // 2, len(frames) - 1}:
        found = np.array(
            viewer.run(f"snhc.app.head.show({index}, []); return Array.from(snhc.app.head.points)")
        ).reshape(-1, 3)
        posed = scene.vertices([frames[index]])
        wanted = np.concatenate([posed[name][0] for name in scene.model.document.meshes])
        # Both are float32; values far out of range give large coordinates.
        assert np.allclose(found, wanted, rtol=2e-4, atol=2e-3 + 2e-6 * np.abs(wanted).max())


def test_the_tree_by_keyboard(face: Viewer) -> None:
    face.focus("#tree")
    face.press(Keys.HOME)
    assert face.text('#tree [aria-selected="true"] .label') == "fba_object"
    # Behind the finding of the object and its start code.
    face.press(Keys.ARROW_DOWN, Keys.ARROW_DOWN, Keys.ARROW_DOWN)
    assert face.text('#tree [aria-selected="true"] .label') == "plane[0]"
    assert face.one('#tree [aria-selected="true"]').get_attribute("aria-expanded") == "true"
    face.press(Keys.ARROW_LEFT)
    assert face.one('#tree [aria-selected="true"]').get_attribute("aria-expanded") == "false"
    face.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert face.text('#tree [aria-selected="true"] .label') == "is_intra"
    assert face.text("#about .big") == "1"
    face.press(Keys.ARROW_LEFT)
    assert face.text('#tree [aria-selected="true"] .label') == "plane[0]"
    face.press("]")
    assert face.text('#tree [aria-selected="true"] .label') == "plane[1]"
    active = face.one("#tree").get_attribute("aria-activedescendant")
    assert face.one(f"#{active}").get_attribute("aria-selected") == "true"


def test_bits_and_planes_by_keyboard(face: Viewer) -> None:
    face.focus("#hex")
    face.press(Keys.HOME, Keys.ARROW_DOWN, Keys.ARROW_RIGHT)
    assert face.selected["bit"] == 65
    face.press(Keys.END)
    assert face.selected["bit"] == 8 * len(FACE) - 1
    assert face.text("#about h3") == "visual_object_sequence_end_code"
    face.focus("#plane-list")
    face.press(Keys.END)
    assert face.one('#plane-list [aria-selected="true"] .number').text == "9"
    face.press(Keys.ARROW_UP)
    assert face.one('#plane-list [aria-selected="true"]').get_attribute("aria-label").startswith("plane 8, intra")


def test_names_and_roles(face: Viewer) -> None:
    for role, count in (("tree", 1), ("listbox", 1), ("grid", 1), ("tablist", 1), ("search", 1)):
        assert len(face.browser.find_elements("css selector", f'[role="{role}"]')) == count
    nameless = face.run("""
        const named = (one) => one.getAttribute("aria-label") || one.getAttribute("aria-labelledby")
            || one.textContent.trim();
        const wanted = "button, input, canvas, [role=tree], [role=grid], [role=listbox], [role=tab]";
        return [...document.querySelectorAll(wanted)]
            .filter((one) => !one.closest("[hidden], label") && !named(one)).map((one) => one.outerHTML);
    """)
    assert nameless == []
    levels = face.run(
        "return [...document.querySelectorAll('[role=treeitem]')].map((one) => Number(one.getAttribute('aria-level')))"
    )
    assert levels[0] == 1
    assert all(b <= a + 1 for a, b in pairwise(levels))


def test_search(face: Viewer) -> None:
    face.press("/")
    face.press("fap_quant")
    assert face.text("#found") == "2 hits"
    face.press(Keys.ENTER)
    assert face.text("#about h3") == "fap_quant"
    assert face.selected["bits"] == [38, 43]
    face.press(Keys.ENTER)
    assert face.text("#found") == "2 of 2"
    assert face.selected["bits"][0] > 43
    face.run("snhc.byId('query').value = 'FBA-16 =31 plane[0]'; snhc.byId('query').dispatchEvent(new Event('input'))")
    wanted = sum(
        part.trace.el(row).rule == "FBA-16" and part.trace.value[row] == 31
        for part in Parts(trace_stream(FACE)) if part.plane_number == 0
        for row in range(len(part.trace))
    )  # fmt: skip
    assert face.text("#found") == f"{wanted} hit{'s' if wanted != 1 else ''}"
    face.run("snhc.byId('query').value = '[1350'; snhc.byId('query').dispatchEvent(new Event('input'))")
    face.focus("#query")
    face.press(Keys.ENTER)
    assert face.selected["bit"] == 1350


def test_an_address_keeps_the_place(face: Viewer) -> None:
    face.run("location.hash = '#bit=1350'")
    assert face.text("#about h3") == "FAP 3 open_jaw"


def test_a_fault_stands_in_its_place(page: Page, tmp_path: Path) -> None:
    viewer = Viewer(page, WORKED[:32], tmp_path / "cut.html")
    button = viewer.one("#fault")
    assert "Truncated" in button.text
    button.click()
    viewer.settle()
    assert viewer.text("#about h3") == "Truncated"
    assert "FBA-27" in viewer.text("#about .rule h4")
    labels = [one.text for one in viewer.browser.find_elements("css selector", "#tree .label")]
    at = next(i for i, label in enumerate(labels) if label.startswith("fap_segment at bits [250, 256)"))
    assert labels[at + 1] == "unclaimed: 6 bits from the fault to the end"
    assert "plane[1]" in labels
    viewer.run("snhc.app.hex.choose(253)")
    assert viewer.text("#about h3") == "unclaimed"


def test_user_data_stays_text(page: Page, tmp_path: Path) -> None:
    data = bytes.fromhex("000001b061000001b2") + HOSTILE + bytes.fromhex("000001b5") + bytes([0b0_0100_011]) + WORKED
    viewer = Viewer(page, data, tmp_path / "hostile.html")
    viewer.run("snhc.app.hex.choose(8 * 12)")
    assert viewer.text("#about h3") == "user_data"
    assert "<img src=x onerror=" in viewer.text("#about")
    assert viewer.browser.title == "hostile.html – snhc"
    assert not viewer.browser.find_elements("css selector", "img")


def test_a_mesh_and_its_nodes(page: Page, tmp_path: Path) -> None:
    viewer = Viewer(page, MESH, tmp_path / "mesh.html")
    assert viewer.text("#tabs") == "Mesh"
    viewer.run("snhc.app.planes.choose(2)")
    viewer.focus("#mesh")
    viewer.press(Keys.ARROW_RIGHT)
    assert viewer.selected["row"] >= 0
    first, second, frame, *_ = list(decode_frames(MESH))
    x, y = frame.nodes[0]
    words = viewer.text("#mesh-words")
    assert f"node 0 at ({x / 2:g}, {y / 2:g}) pixels" in words
    moved = (x - second.nodes[0][0], y - second.nodes[0][1])
    assert f"moved by ({moved[0] / 2:g}, {moved[1] / 2:g})" in words
    assert f"{len(first.triangles)} triangles" in words
    assert "node" in viewer.text('#tree [aria-selected="true"]') or viewer.selected["row"] >= 0


def test_dct_segments(page: Page, tmp_path: Path) -> None:
    viewer = Viewer(page, DCT, tmp_path / "dct.html")
    viewer.run("snhc.app.openView('curves', false)")
    frames = viewer.run("return snhc.app.stream.face.time.length")
    assert frames == len(list(decode_frames(DCT)))
    row = viewer.run("""
        const s = snhc.app.stream;
        const row = Array.from({ length: s.rowCount }, (_, row) => row).find((row) => s.fapsOf(row, -1).length === 1);
        snhc.app.hex.choose(s.start[row]);
        return row;
    """)
    assert row > 0
    assert "FAP" in viewer.text("#about dl")
    assert "curves" in viewer.one("#curves").get_attribute("aria-label")


def test_dark_and_light(face: Viewer) -> None:
    def paper() -> str:
        return str(face.run("return getComputedStyle(document.body).backgroundColor"))

    before = paper()
    name = face.one("#theme").get_attribute("aria-label")
    face.one("#theme").click()
    face.settle()
    assert paper() != before
    assert face.one("#theme").get_attribute("aria-label") != name
    # What is written must stand out from what it is written on (WCAG AA: 4.5).
    for _ in range(2):
        contrast = face.run("""
            const linear = (v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
            const luminance = (text) => {
                const [r, g, b] = text.match(/[\\d.]+/g).slice(0, 3).map((v) => linear(v / 255));
                return 0.2126 * r + 0.7152 * g + 0.0722 * b;
            };
            const probe = document.createElement("span");
            document.body.append(probe);
            const read = (name) => {
                probe.style.color = `var(--${name})`;
                return luminance(getComputedStyle(probe).color);
            };
            const names = "ink soft accent k-code k-head k-mask k-data k-bytes k-gap warn bad".split(" ");
            const panel = read("panel");
            const ratio = (one) => (Math.max(one, panel) + 0.05) / (Math.min(one, panel) + 0.05);
            const out = Object.fromEntries(names.map((name) => [name, ratio(read(name))]));
            probe.remove();
            return out;
        """)
        assert min(contrast.values()) >= 4.5, contrast
        face.one("#theme").click()
        face.settle()


def test_ten_thousand_planes_stay_responsive(page: Page, tmp_path: Path) -> None:
    from test_bench_fba import small_residuals

    viewer = Viewer(page, small_residuals(10_000), tmp_path / "many.html")
    assert viewer.run("return snhc.app.stream.planes.length") == 10_000
    listings = "[snhc.app.tree, snhc.app.hex, snhc.app.planes].map((one) => one.listing)"
    assert viewer.run("return document.querySelectorAll('*').length") < 2_500

    def work(script: str) -> int:
        before = sum(viewer.run(f"return {listings}.map((one) => one.made)"))
        viewer.run(script)
        return int(sum(viewer.run(f"return {listings}.map((one) => one.made)")) - before)

    # A step makes what is in sight a few times anew, whatever the length: not one row per plane.
    assert work("snhc.app.planes.choose(9_999)") < 1_500
    assert viewer.one('#plane-list [aria-selected="true"] .number').text == "9999"
    assert work("snhc.byId('tree').scrollTop = snhc.byId('tree').scrollHeight / 2") < 500
    assert work("snhc.byId('hex').scrollTop = snhc.byId('hex').scrollHeight / 2") < 500
    assert work("snhc.app.hex.choose(snhc.app.stream.endBit >> 1)") < 1_500
    milliseconds = viewer.run("""
        const began = performance.now();
        for (let i = 0; i < 20; i++) snhc.app.planes.choose((i * 4999) % 10000);
        return (performance.now() - began) / 20;
    """)
    # Generous: what is bounded above is the work.
    assert milliseconds < 1_000
    assert viewer.run("return document.querySelectorAll('*').length") < 2_500
