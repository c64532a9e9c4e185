"""Kernel, literal coder and the tests' own cumulative-list coder are one coder (FBA-21..27)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_coder import PlainModel, decode, encode, encode_data_bits, guarded
from strategies import STYLES, level_in

from snhc.reference_impl.bitstream.cursor import BitCursor, OutOfBits
from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.bitstream.sink import BitSink
from snhc.reference_impl.entropy.kernel import decode_segment, encode_segment, segment_code, write_guarded
from snhc.reference_impl.entropy.literal import SymbolStep, decode_literally
from snhc.reference_impl.entropy.model import FENWICK_FROM, MAX_FREQUENCY, NO_NODE, Model, fresh_tree, tree_of
from snhc.reference_impl.entropy.shares import decode_with_shares

Range = tuple[int, int, bool]  # lo, hi, adaptive
ZEROS_BEHIND = "1" + "0" * 15  # look-ahead that is not all zero


def _ours(ranges: list[Range]) -> list[Model]:
    return [Model(*r) for r in ranges]


def _plain(ranges: list[Range]) -> list[PlainModel]:
    return [PlainModel(*r) for r in ranges]


def _bytes(bits: str) -> bytes:
    bits += "0" * (-len(bits) % 8)
    return int("1" + bits, 2).to_bytes(len(bits) // 8 + 1, "big")[1:] if bits else b""


def _cursor(bits: str, start: int) -> BitCursor:
    cursor = BitCursor.of(_bytes(bits))
    cursor.seek(start)
    return cursor


def _same(models: list[Model], plain: list[PlainModel]) -> None:
    for model, reference in zip(models, plain, strict=True):
        if model.n == 1:
            continue  # the frequency of an only symbol is never seen
        assert (model.freq or [1] * model.n) == reference.frequencies
        assert model.total == sum(reference.frequencies)


def _encoded(models: list[Model], levels: list[int], before: str) -> str:
    sink = BitSink()
    for bit in before:
        sink.write(int(bit), 1)
    encode_segment(sink, models, levels)
    data = int.from_bytes(b"\1" + sink.getvalue(), "big")
    return f"{data:b}"[1:][: sink.tell()]


@st.composite
def segments(draw: Any) -> tuple[list[Range], list[list[int]], str, str]:
    """Ranges, levels of several segments over the same models, and the raw bits before the first."""
    rng = Random(draw(st.integers(0, 2**32 - 1)))
    sizes = draw(st.lists(st.sampled_from((1, 2, 3, 60, 121, 361, 512, 513, 1201, 3721)) | st.integers(1, 3721),
                          max_size=12))  # fmt: skip
    adaptive = draw(st.booleans())
    ranges = []
    for n in sizes:
        below = rng.randint(0, n - 1)
        ranges.append((-below, n - 1 - below, adaptive))
    styles = draw(st.lists(st.sampled_from(STYLES), min_size=1, max_size=5))
    levels = [[level_in(rng, style, lo, hi) for lo, hi, _ in ranges] for style in styles]
    return ranges, levels, draw(st.text("01", max_size=9)), draw(st.text("01", max_size=40))


def _shares(steps: Sequence[SymbolStep]) -> list[Fraction]:
    return [Fraction(step.cum_high - step.cum_low, step.total) for step in steps]


@given(segments())
def test_three_coders_agree(case: tuple[list[Range], list[list[int]], str, str]) -> None:
    ranges, levels, before, after = case
    encoders, plain_encoders = _ours(ranges), _plain(ranges)
    fast, literal, plain = _ours(ranges), _ours(ranges), _plain(ranges)
    sharing = _ours(ranges)
    bits = before
    for wanted in levels:
        start = len(bits)
        bits = _encoded(encoders, wanted, bits)
        assert bits[start:] == encode(plain_encoders, wanted)
        _same(encoders, plain_encoders)
        for tail in ("", after, ZEROS_BEHIND, "0" * 40):
            models = [_copy(model) for model in fast]
            cursor = _cursor(bits + tail, start)
            assert decode_segment(cursor, models) == (wanted, -1, 0)
            assert cursor.tell() == len(bits)
        decode_segment(_cursor(bits + after, start), fast)
        cursor = _cursor(bits + after, start)
        trace = decode_literally(cursor, literal)
        assert [step.level for step in trace.steps] == wanted
        assert cursor.tell() == trace.end == len(bits)
        cursor = _cursor(bits + after, start)
        *decoded, widths, totals = decode_with_shares(cursor, sharing)
        assert decoded == [wanted, -1, 0]
        assert cursor.tell() == len(bits)
        assert [Fraction(*share) for share in zip(widths, totals, strict=True)] == _shares(trace.steps)
        assert decode(bits + after, start, plain) == (wanted, len(bits), [])
        _same(fast, plain)
        _same(literal, plain)


def _copy(model: Model) -> Model:
    other = Model(model.lo, model.lo + model.n - 1, model.adaptive)
    if model.freq is not None:
        other.freq = list(model.freq)
        other.total = sum(other.freq)
    return other


@given(st.binary(min_size=0, max_size=120), st.integers(0, 7), st.data())
def test_any_bits_decode_alike(data: bytes, start: int, draw: st.DataObject) -> None:
    """Whatever the bits: the same levels, the same end or want of data, the same bad guard (FBA-25..27)."""
    # Bytes that are mostly zero bring guards, good and bad, into segment and look-ahead.
    mask = draw.draw(st.sampled_from((0xFF, 0x11, 0x01, 0x00)))
    data = bytes(byte & mask for byte in data)
    start = min(start, 8 * len(data))
    sizes = draw.draw(st.lists(st.sampled_from((1, 2, 15, 121, 361, 1201, 3721)), max_size=30))
    ranges = [(-(n // 2), n - 1 - n // 2, draw.draw(st.booleans())) for n in sizes]
    bits = "".join(f"{byte:08b}" for byte in data)
    levels, end, bad = decode(bits, start, _plain(ranges))
    if end > len(bits):
        # Truncated wins over a bad guard.
        for decoder in (decode_segment, decode_literally):
            with pytest.raises(OutOfBits):
                decoder(_cursor(bits, start), _ours(ranges))
        return
    cursor = _cursor(bits, start)
    decoded, fault, tail = decode_segment(cursor, _ours(ranges))
    assert (decoded, fault) == (levels, bad[0] if bad else -1)
    assert cursor.tell() == end
    cursor = _cursor(bits, start)
    trace = decode_literally(cursor, _ours(ranges))
    assert [step.level for step in trace.steps] == levels
    assert [position for position, value in trace.guards if not value] == bad
    assert trace.tail == tail
    assert cursor.tell() == end
    if not bad:
        # Whatever the last two bits: levels and tail write back to the same bits (FBA-43).
        sink = BitSink()
        encode_segment(sink, _ours(ranges), levels, tail)
        assert f"{sink.bits_from(0, sink.tell()):0{sink.tell()}b}" == bits[start:end]


@pytest.mark.parametrize("zeros", range(60))
@pytest.mark.parametrize("last", ["1", "01", "10", "0", "11"])
def test_guards_stand_behind_22_zeros_where_a_data_bit_follows(zeros: int, last: str) -> None:
    bits = "1" + "0" * zeros + last
    sink = BitSink()
    write_guarded(sink, int(bits, 2), len(bits))
    out = f"{int.from_bytes(sink.getvalue(), 'big'):b}"[: sink.tell()]
    assert out == guarded(bits)
    # A run that a 1 follows has a guard behind each 22 zeros; one that ends the segment none behind its last.
    runs = [len(run) for run in re.findall("0+(?=1)", bits)]
    at_end = len(bits) - len(bits.rstrip("0"))
    guards = sum(run // 22 for run in runs) + (max(at_end - 1, 0) // 22)
    assert len(out) - len(bits) == guards


def _with_guard_at(wanted: int) -> tuple[list[Range], list[int], str]:
    """A segment whose guard stands `wanted` data bits behind its first bit."""
    rng = Random(wanted)
    while True:
        # Some symbols to get there, then the highest of large alphabets: low stays put and zeros go out.
        count = rng.randint(0, 3 + wanted // 4)
        ranges: list[Range] = [(0, 2 ** rng.randint(1, 7) - 1, False) for _ in range(count)]
        levels = [rng.randint(lo, hi) for lo, hi, _ in ranges]
        ranges += [(-1860, 1860, False)] * 4
        levels += [1860] * 3 + [rng.randint(-1860, 1860)]
        data = encode_data_bits(_plain(ranges), levels)
        run = data.find("0" * 22)
        if run >= 0 and run + 22 == wanted and run + 22 < len(data):
            return ranges, levels, data


@pytest.mark.parametrize("place", range(22, 60))
def test_guard_at_every_place(place: int) -> None:
    """A guard at any distance from the preloaded 16 bits, at any alignment; made 0, it is the fault (FBA-27)."""
    ranges, levels, data = _with_guard_at(place)
    for start in range(8):
        good = "1" * start + guarded(data)
        assert len(good) > start + len(data)
        bad = "1" * start + guarded(data, "0")
        for bits, fault in ((good, -1), (bad, start + place)):
            cursor = _cursor(bits + ZEROS_BEHIND, start)
            assert decode_segment(cursor, _ours(ranges)) == (levels, fault, 0)
            assert cursor.tell() == len(good)
            trace = decode_literally(_cursor(bits + ZEROS_BEHIND, start), _ours(ranges))
            assert [step.level for step in trace.steps] == levels
            assert (start + place, 0 if fault >= 0 else 1) in trace.guards


@pytest.mark.parametrize("zeros", range(16, 26))
def test_a_guard_in_the_look_ahead_is_not_taken(zeros: int) -> None:
    """Zeros that begin in the segment and go on behind it: the next element begins at the segment's end (FBA-26)."""
    seen = 0
    rng = Random(zeros)
    for _ in range(4_000):
        ranges: list[Range] = [(-1860, 1860, False)] * 2
        levels = [1860, 1860 - rng.randint(0, 400)]
        data = encode_data_bits(_plain(ranges), levels)
        if len(data) - len(data.rstrip("0")) == 0:
            continue
        seen += 1
        bits = guarded(data) + "0" * zeros + "1"
        cursor = _cursor(bits, 0)
        assert decode_segment(cursor, _ours(ranges)) == (levels, -1, 0)
        assert cursor.tell() == len(guarded(data))
        assert decode_literally(_cursor(bits, 0), _ours(ranges)).end == len(guarded(data))
        if seen > 20:
            return
    assert seen


@pytest.mark.parametrize("start", range(8))
def test_empty_segment_is_01(start: int) -> None:
    for ranges in ([], [(0, 0, True)], [(0, 0, False)] * 3):
        assert _encoded(_ours(ranges), [0] * len(ranges), "0" * start) == "0" * start + "01"
        cursor = _cursor("0" * start + "01", start)
        assert decode_segment(cursor, _ours(ranges)) == ([0] * len(ranges), -1, 0)
        assert cursor.tell() == start + 2
        # Exactly 2 + shifts data bits: a third bit is never needed, one alone is too few.
        with pytest.raises(OutOfBits):
            decode_segment(_cursor("0" * 7, 7), _ours(ranges))


@given(segments())
def test_length_is_2_and_the_shifts(case: tuple[list[Range], list[list[int]], str, str]) -> None:
    ranges, levels, before, _ = case
    bits = _encoded(_ours(ranges), levels[0], before)
    trace = decode_literally(_cursor(bits, len(before)), _ours(ranges))
    assert trace.end - trace.start - len(trace.guards) == 2 + sum(step.shifts for step in trace.steps)


@pytest.mark.parametrize("n", [2, 61, 361, FENWICK_FROM - 1, FENWICK_FROM, 3721])
@pytest.mark.parametrize("style", ["small", "high", "low", "uniform"])
def test_rescale(n: int, style: str) -> None:
    """Past Max_frequency every frequency is halved, rounded up (FBA-24); all searches follow."""
    rng = Random(n)
    lo = -(n // 2)
    ours, reader, literal, sharing = (Model(lo, lo + n - 1, True) for _ in range(4))
    plain = PlainModel(lo, lo + n - 1, True)
    # Start close to the limit, with frequencies of both parities.
    start = [1 + rng.randint(0, 2 * (MAX_FREQUENCY - 40 - n) // n) for _ in range(n)]
    start[rng.randrange(n)] += MAX_FREQUENCY - 40 - sum(start)
    if min(start) < 1:
        start = [1] * n
        start[0] += MAX_FREQUENCY - 40 - n
    for model in (ours, reader, literal, sharing):
        model.freq = list(start)
        model.total = sum(start)
    plain.frequencies = list(start)
    for _ in range(100):
        levels = [level_in(rng, style, lo, lo + n - 1)]
        code, count = segment_code([ours], levels)
        bits = f"{code:0{count}b}"
        assert bits == encode_data_bits([plain], levels)
        assert decode_segment(_cursor(guarded(bits), 0), [reader]) == (levels, -1, 0)
        assert ours.freq == reader.freq == plain.frequencies
        assert ours.total == reader.total == sum(plain.frequencies)
        (step,) = decode_literally(_cursor(guarded(bits), 0), [literal]).steps
        *_, widths, totals = decode_with_shares(_cursor(guarded(bits), 0), [sharing])
        assert (widths, totals) == ([step.cum_high - step.cum_low], [step.total])
    assert plain.halvings == 1


@pytest.mark.parametrize("tail", range(-3, 4))
def test_a_tail_is_written_where_it_decodes_and_refused_where_it_does_not(tail: int) -> None:
    """What an encoder cannot write back is an EncodeError, never another segment."""
    refused = 0
    for n in (2, 3, 5, 9, 61):
        for level in range(n):
            sink = BitSink()
            try:
                encode_segment(sink, [Model(0, n - 1, False)], [level], tail)
            except EncodeError:
                refused += 1
                continue
            end = sink.tell()
            read = []
            # The segment's look-ahead reaches into what stands behind it: an odd end may need ones there, or zeros.
            for behind in (0, 0x7FFF):
                whole = BitSink()
                whole.write(sink.bits_from(0, end), end)
                whole.write(behind, 15)
                cursor = BitCursor.of(whole.getvalue())
                read.append((*decode_segment(cursor, [Model(0, n - 1, False)]), cursor.tell()))
            assert ([level], -1, tail, end) in read
    # What an encoder sends is always good; far from it something must be refused.
    assert not refused if tail == 0 else refused or abs(tail) == 1


@given(st.integers(FENWICK_FROM, 3721), st.integers(0, 2**32 - 1))
def test_tree_of_ones_and_its_search(n: int, seed: int) -> None:
    """The tree of a fresh model is the one that its frequencies give, before and after counting (FBA-22)."""
    rng = Random(seed)
    model = Model(0, n - 1, True)
    freq = model.rebuild()
    assert model.tree == fresh_tree(n) == tree_of([1] * n)
    for _ in range(20):
        c = rng.choice((0, model.total - 1, rng.randrange(model.total)))
        above = 0
        wanted = n
        while above <= c:
            wanted -= 1
            above += freq[wanted]
        assert model.take(c) == (wanted, above)
        freq[wanted] += 1
        model.total += 1
        assert model.tree[: n + 1] == tree_of(freq)[: n + 1]
        assert min(model.tree[n + 1 :], default=NO_NODE) >= NO_NODE
