"""The bit cursor against a string of bits, over windows smaller than the data (CNF-21, FBA-27, FBA-42)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.cursor import WINDOW, BitCursor, OutOfBits
from snhc.reference_impl.bitstream.sink import BitSink

Step = tuple[str, int]
STEPS = st.lists(
    st.tuples(st.sampled_from(["read"] * 4 + ["peek", "has", "seek", "zeros"]), st.integers(0, 48)), max_size=60
)


def _bits(data: bytes) -> str:
    return "".join(f"{byte:08b}" for byte in data)


@given(st.binary(max_size=60), STEPS, st.integers(0, 255))
def test_like_a_string_of_bits(data: bytes, steps: list[Step], mask: int) -> None:
    data = bytes(byte & mask for byte in data)
    bits = _bits(data)
    cursor = BitCursor.of(data)
    at = 0
    for what, n in steps:
        if what == "read":
            n = min(n, 32)
            if at + n > len(bits):
                with pytest.raises(OutOfBits):
                    cursor.read(n)
            else:
                assert cursor.read(n) == int(bits[at : at + n] or "0", 2)
                at += n
        elif what == "peek":
            assert cursor.peek(n) == int(bits[at : at + n].ljust(n, "0") or "0", 2)
        elif what == "has":
            assert cursor.has(n) == (at + n <= len(bits))
        elif what == "seek":
            at = min(len(bits), n * 10)
            cursor.seek(at)
        else:
            assert cursor.only_zeros_left() == ("1" not in bits[at:])
        # Whatever was asked, the position is the sum of what was read.
        assert cursor.tell() == at
    assert cursor.end() == len(bits)


@pytest.mark.parametrize("n", [1, 7, 13, 32])
@pytest.mark.parametrize("extra", [-3, -1, 0, 1, 5])
def test_reading_over_the_end_of_a_window(n: int, extra: int) -> None:
    data = bytes((i * 151 + (i >> 8)) & 0xFF for i in range(2 * WINDOW + extra))
    bits = 8 * len(data)
    for near in (8 * WINDOW, 16 * WINDOW + 8 * min(extra, 0)):
        cursor = BitCursor.of(data)
        at = near - 100
        cursor.seek(at)
        while at + n <= min(near + 100, bits):
            expected = int.from_bytes(data[at >> 3 : (at >> 3) + 6].ljust(6, b"\0"), "big")
            expected = (expected >> (48 - (at & 7) - n)) & ((1 << n) - 1)
            assert cursor.peek(n) == expected
            assert cursor.read(n) == expected
            at += n
            assert cursor.tell() == at


@pytest.mark.parametrize("end", [0, 1, 4095, WINDOW - 1, WINDOW, WINDOW + 1, 3 * WINDOW])
def test_the_data_ends_where_it_ends(end: int) -> None:
    cursor = BitCursor.of(b"\xff" * end)
    cursor.seek(8 * end)
    assert not cursor.has(1)
    assert cursor.peek(48) == 0
    assert cursor.only_zeros_left()
    with pytest.raises(OutOfBits):
        cursor.read(1)
    assert cursor.read(0) == 0
    # A failed read does not move.
    assert cursor.tell() == 8 * end
    if end:
        cursor.seek(8 * end - 3)
        with pytest.raises(OutOfBits):
            cursor.read(4)
        assert cursor.tell() == 8 * end - 3
        assert cursor.read(3) == 7


@pytest.mark.parametrize("one", [0, 47, 48, 49, 8 * WINDOW - 1, 8 * WINDOW, 20 * WINDOW + 3])
def test_the_last_one_is_found_at_any_distance(one: int) -> None:
    data = bytearray(3 * WINDOW)
    data[one >> 3] = 0x80 >> (one & 7)
    cursor = BitCursor.of(bytes(data))
    for at in sorted({0, max(one - 100, 0), max(one - 1, 0), one, one + 1, 8 * len(data)}):
        cursor.seek(at)
        assert cursor.only_zeros_left() == (at > one), at


def _write_all(fields: list[tuple[int, int]]) -> tuple[BitSink, str]:
    sink, bits = BitSink(), ""
    for value, n in fields:
        sink.write(value, n)
        bits += f"{value & ((1 << n) - 1):0{n}b}" if n else ""
    return sink, bits


FIELDS = st.lists(st.tuples(st.integers(0, 2**40), st.integers(0, 40)), max_size=30)


@given(FIELDS, st.data())
def test_sink(fields: list[tuple[int, int]], draw: st.DataObject) -> None:
    sink, bits = _write_all(fields)
    assert sink.tell() == len(bits)
    assert _bits(sink.getvalue()) == bits + "0" * (-len(bits) % 8)
    start = draw.draw(st.integers(0, len(bits)))
    n = draw.draw(st.integers(0, 60))
    assert sink.bits_from(start, n) == int(bits[start : start + n].ljust(n, "0") or "0", 2)
    cut = draw.draw(st.integers(0, len(bits)))
    sink.cut(cut)
    assert sink.tell() == cut
    sink.write(5, 3)
    assert _bits(sink.getvalue())[: cut + 3] == bits[:cut] + "101"


@given(FIELDS, FIELDS)
def test_sink_taken_in_pieces(first: list[tuple[int, int]], second: list[tuple[int, int]]) -> None:
    sink, before = _write_all(first)
    whole = len(before) & ~7
    taken = sink.take(len(before))
    assert 8 * len(taken) == whole
    assert sink.take(len(before)) == b""
    bits = before
    for value, n in second:
        sink.write(value, n)
        bits += f"{value & ((1 << n) - 1):0{n}b}" if n else ""
    assert sink.tell() == len(bits)
    assert _bits(taken + sink.getvalue())[: len(bits)] == bits
    # What has not been taken can still be looked at and cut off.
    kept = 8 * len(taken)
    assert sink.bits_from(kept, len(bits) - kept) == int(bits[kept:] or "0", 2)
    sink.cut(kept)
    assert sink.tell() == kept


def test_written_is_read() -> None:
    sink, _ = _write_all([(i, i % 33) for i in range(500)])
    cursor = BitCursor.of(sink.getvalue())
    for i in range(500):
        assert cursor.read(i % 33) == i & ((1 << (i % 33)) - 1)
