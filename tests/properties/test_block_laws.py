"""Blocks of coefficients read at once are what the syntax says word by word: over streams, damage, cuts and windows.

Rules: DCT-2, DCT-3, DCT-4, CNF-21. Both ways run here, in both forms; of itself a compiled reader goes the fast one.
"""

from __future__ import annotations

from functools import cache
from random import Random
from typing import Any

import pytest
from fba_helpers import plain
from hypothesis import given
from hypothesis import strategies as st
from strategies_dct import DctStream, dct_streams, segment_records

from snhc.conformance.cli.version import form
from snhc.reference_impl.bitstream.cursor import WINDOW, BitCursor
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import BytesSource, Source
from snhc.reference_impl.entropy.blocks import BLOCK, BlockCode, read_blocks
from snhc.reference_impl.entropy.prefix import CodeWord, build_table
from snhc.reference_impl.entropy.profile import load_profile
from snhc.reference_impl.face.dct_syntax import AC_ESCAPE, DC_ESCAPE, END_OF_SEGMENT, OFFSET, WIDE
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.syntax.reader import Reader
from snhc.reference_impl.syntax.tracer import Tracer
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, read_stream, reader, write_stream
from snhc.reference_impl.systems.visual import StreamItem, fresh_items, visual_stream
from snhc.vectors.builders import stream
from snhc.vectors.coverage.probe import Probe
from snhc.vectors.dct_builders import coefficients, dct_inter, dct_intra


class Run:
    """Everything that a reader makes of a stream, and how it read the FAPs of its DCT segments."""

    def __init__(self, data: Source | bytes, by_blocks: bool, options: Options = DEFAULT_OPTIONS) -> None:
        findings: list[Finding] = []
        io = reader(data, options, findings.append, collect=True)
        io.by_blocks = by_blocks
        self.planes: list[Any] = []
        self.at_once = self.by_words = 0
        self.items: list[StreamItem] = []
        error = None
        try:
            for item, plane in visual_stream(io, fresh_items()):
                if plane is None:
                    if item.fba is None or not item.end:
                        self.items.append(item)
                    continue
                assert item.fba is not None and isinstance(plane, FbaPlane)
                item.fba.planes.append(plane)
                segment = plane.faps.segment if plane.faps is not None else None
                if segment is not None:
                    words = len(segment._words) if segment._blocks else len(segment._runs)
                    self.by_words += words
                    self.at_once += len(segment._blocks) // BLOCK - words if segment._blocks else 0
                    blocks = list(segment.blocks())
                    self.planes.append((segment_records(segment), blocks, segment.blocks() == blocks))
                self.planes.append((plane.frames, plain([plane.header, plane.start, plane.end])))
        except SnhcError as fault:
            error = fault.as_json()
        self.said = (self.planes, [str(finding) for finding in findings], error, io.tell())


def same(data: bytes, options: Options = DEFAULT_OPTIONS) -> Run:
    """Both ways say the same; the fast one is returned."""
    fast, literal = Run(data, True, options), Run(data, False, options)
    assert fast.said == literal.said
    assert literal.at_once == 0 and fast.at_once + fast.by_words == literal.by_words
    return fast


def damaged(rng: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


@cache
def ordinary(planes: int = 3) -> bytes:
    """Planes of 66 FAPs with small coefficients: no escapes, words of all lengths, blocks up to index 15."""
    rng = Random(5)

    def faps(is_intra: bool) -> dict[int, Any]:
        made = {}
        for fap in range(3, 69):
            levels = {
                k: rng.choice((1, -1)) * rng.choice((1, 2, 9, 100, 255)) for k in range(1, 16) if rng.random() < 0.2
            }
            made[fap] = coefficients(rng.randint(-255, 255), levels, is_intra=is_intra)
        return made

    first = dct_intra(faps(True), types=dict.fromkeys(range(2, 11), 3))
    return write_stream(stream(first, *(dct_inter(first, faps(False)) for _ in range(planes - 1))))


@given(dct_streams())
def test_streams(drawn: DctStream) -> None:
    data = write_stream(drawn.items)
    run = same(data, drawn.options)
    assert write_stream(run.items) == data


@given(dct_streams(), st.integers(0, 2**32 - 1))
def test_damaged_streams(drawn: DctStream, seed: int) -> None:
    same(damaged(Random(seed), write_stream(drawn.items)))


@given(dct_streams(max_planes=2), st.data())
def test_cut_streams(drawn: DctStream, data: st.DataObject) -> None:
    whole = write_stream(drawn.items)
    same(whole[: data.draw(st.integers(0, len(whole)))])


def test_every_bit_of_a_segment_turned_and_every_cut() -> None:
    faps = {fap: coefficients(fap - 5, {1 + fap % 15: fap - 4, 15: 300 * (fap % 3)}) for fap in range(5, 11)}
    first = dct_intra(faps)
    inter = {fap: coefficients(30 * (fap - 7), {2: 1, 9: -fap}, is_intra=False) for fap in faps}
    data = write_stream(stream(first, dct_inter(first, inter)))
    faults = 0
    for bit in range(8 * len(data)):
        turned = bytearray(data)
        turned[bit >> 3] ^= 0x80 >> (bit & 7)
        faults += same(bytes(turned)).said[2] is not None
    # Most bits of a segment are followed by bits that then mean something else.
    assert faults > len(data)
    for end in range(len(data)):
        same(data[:end])


def test_ordinary_blocks_are_read_at_once() -> None:
    run = same(ordinary())
    # The last ones have fewer than 32 bits behind them.
    assert run.at_once >= 3 * 66 - 2


def test_an_escape_costs_its_own_block_only() -> None:
    faps = {fap: coefficients(1, {3: 1}) for fap in range(5, 25)}
    for fap, levels in ((7, {3: 300}), (12, {3: 40_000})):
        faps[fap] = coefficients(1, levels)
    faps[14] = coefficients(50_000)
    run = same(write_stream(stream(dct_intra(faps), dct_intra({5: coefficients(0)}))))
    # The fourth one is the last of the stream.
    assert (run.at_once, run.by_words) == (17, 4)


def test_longer_than_a_window() -> None:
    data = ordinary(220)
    assert len(data) > 1.5 * WINDOW
    run = same(data)
    assert run.by_words < 5
    assert run.at_once > 219 * 66


class Trickle(BytesSource):
    """Gives few bytes at a time, as a pipe whose writer is slow, and notes how far it was asked for."""

    asked = 0

    def read_some(self, offset: int, least: int, most: int) -> tuple[bytes, bool]:
        self.asked = max(self.asked, offset + least)
        data = self.read_at(offset, max(least, 50))
        return data, len(data) < max(least, 50)


def test_from_a_slow_source() -> None:
    data = ordinary()
    source = Trickle(data)
    run = Run(source, True)
    assert run.said == Run(data, False).said
    # At the end of each 50 bytes there are one or two blocks with fewer than 32 bits behind them.
    assert run.by_words < 2 * (len(data) / 50 + 1) < run.at_once


def test_a_plane_does_not_wait_for_what_comes_long_after_it() -> None:
    source = Trickle(ordinary())
    io = reader(source)
    io.by_blocks = True
    plane = next(plane for _, plane in visual_stream(io, fresh_items()) if plane is not None)
    assert source.asked < plane.end // 8 + 64


def test_records_read_at_once_may_be_changed() -> None:
    run = Run(ordinary(), True)
    assert run.items[0].fba is not None
    data = run.items[0].fba.planes[1].faps
    assert data is not None and data.segment is not None
    changed = next(r for r in data.segment.runs if r.levels)
    changed.levels[0] = 77
    again = read_stream(write_stream(run.items))[0].fba
    assert again is not None and again.planes[1].faps is not None and again.planes[1].faps.segment is not None
    assert segment_records(again.planes[1].faps.segment) == segment_records(data.segment)


def test_the_other_reading_of_the_end_is_read_by_words() -> None:
    options = Options(readings=Readings({"AMB-DCT-4": "sent"}))
    run = same(ordinary(), options)
    assert run.at_once == 0


def _code(**other: Any) -> BlockCode:
    profile = load_profile()
    tables = {"dc": profile.dc, "runs": profile.runlength, "levels": profile.ac, **other}
    return BlockCode(
        **tables, offset=OFFSET, dc_escape=DC_ESCAPE, level_escape=AC_ESCAPE, wide=WIDE, end=END_OF_SEGMENT
    )


@pytest.mark.parametrize("offset", range(8))
def test_the_cursor_stands_before_the_first_block_not_read(offset: int) -> None:
    code = _code()
    bits = "1" * offset
    for levels in ((1, -2), (3,), (), (1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1)):
        words = [code.dc.encode(OFFSET + 4)]  # type: ignore[union-attr]
        for level in levels:
            words += [code.runs.encode(0), code.levels.encode(OFFSET + level)]
        if len(levels) < 15:
            words.append(code.runs.encode(END_OF_SEGMENT))
        bits += "".join(f"{word:0{length}b}" for word, length in words)
    before = len(bits)
    word, length = code.dc.encode(DC_ESCAPE)  # type: ignore[union-attr]
    bits += f"{word:0{length}b}" + "0" * 64
    cursor = BitCursor.of(int(bits.ljust(-(-len(bits) // 8) * 8, "0"), 2).to_bytes(-(-len(bits) // 8), "big"))
    cursor.read(offset)
    blocks = [0] * (6 * BLOCK)
    assert read_blocks(cursor, code, blocks, 1) == 5
    assert cursor.tell() == before
    assert blocks[: 5 * BLOCK] == [
        *[0] * BLOCK, *[4, 1, -2], *[0] * 13, *[4, 3], *[0] * 14, 4, *[0] * 15, 4, *[1] * 15,
    ]  # fmt: skip


def test_words_too_long_for_one_loading_are_left() -> None:
    long = build_table("long", "DCT-4", [CodeWord(257, 1, "0"), CodeWord(258, 30, "1" * 30)])
    cursor = BitCursor.of(bytes(64))
    assert read_blocks(cursor, _code(levels=long), [0] * (2 * BLOCK), 0) == 0
    assert cursor.tell() == 0


def test_only_the_compiled_reader_reads_at_once_of_itself() -> None:
    cursor = BitCursor.of(b"")
    assert Reader(cursor).by_blocks == (form() == "compiled")
    assert not Tracer(cursor).by_blocks
    assert not Probe(cursor, DEFAULT_OPTIONS).by_blocks
