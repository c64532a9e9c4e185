"""Prefix codes: the checks on load, look-up, words at the end of the data."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.errors import EncodeError, InputFormat
from snhc.reference_impl.entropy.prefix import (
    LENGTH_BITS,
    LENGTH_MASK,
    NO_WORD,
    CodeWord,
    PrefixTable,
    build_table,
    shipped_table,
)


def make(*codes: str, first: int = 0) -> PrefixTable:
    return build_table("t", "DCT-4", [CodeWord(first + i, len(c), c) for i, c in enumerate(codes)])


def split(found: int) -> tuple[int, int] | None:
    return None if found == NO_WORD else (found >> LENGTH_BITS, found & LENGTH_MASK)


@st.composite
def codes(draw: st.DrawFn) -> list[str]:
    """Prefix-free words up to 16 bits, complete or with words left out."""
    words = ["0", "1"]
    for at in draw(st.lists(st.integers(0, 400), max_size=40)):
        word = words.pop(at % len(words))
        words += [word] if len(word) == 16 else [word + "0", word + "1"]
    dropped = draw(st.sets(st.integers(0, len(words) - 1), max_size=len(words) - 1))
    return draw(st.permutations([w for i, w in enumerate(words) if i not in dropped]))


@given(codes(), st.integers(-50, 50), st.data())
def test_lookup_finds_exactly_the_word_that_a_window_begins_with(
    words: list[str], first: int, data: st.DataObject
) -> None:
    table = make(*words, first=first)
    n = table.max_length
    window = data.draw(st.integers(0, (1 << n) - 1))
    text = f"{window:0{n}b}"
    expected = next(((first + i, len(w)) for i, w in enumerate(words) if text.startswith(w)), None)
    assert split(table.lookup(window)) == expected


@given(codes())
def test_what_encode_gives_lookup_reads(words: list[str]) -> None:
    table = make(*words, first=-3)
    for symbol in range(-3, len(words) - 3):
        code, length = table.encode(symbol)
        assert f"{code:0{length}b}" == words[symbol + 3]
        for filler in (0, (1 << (table.max_length - length)) - 1):
            assert split(table.lookup(code << (table.max_length - length) | filler)) == (symbol, length)


@given(codes(), st.data())
def test_is_beginning_tells_an_end_inside_a_word_from_an_unassigned_one(words: list[str], data: st.DataObject) -> None:
    table = make(*words)
    length = data.draw(st.integers(0, table.max_length))
    value = data.draw(st.integers(0, (1 << length) - 1))
    text = f"{value:0{length}b}" if length else ""
    assert table.is_beginning(value, length) == any(w.startswith(text) for w in words)


def test_kraft_sum_is_exact_and_unassigned_windows_are_no_word() -> None:
    table = make("0", "10", "1101")
    assert table.kraft == Fraction(13, 16)  # 8/16 + 4/16 + 1/16
    assert [split(table.lookup(w)) for w in (0b1100, 0b1101, 0b1110, 0b1111)] == [None, (2, 4), None, None]
    assert len(table) == 3
    assert 2 in table
    assert 3 not in table


def test_words_behind_the_direct_table_are_found_and_gaps_between_them_are_not() -> None:
    # 12 and 17 bits: both begin in the same entry of the direct part.
    table = make("000000000011", "00000000001011111", "1")
    assert split(table.lookup(0b00000000001111111)) == (0, 12)
    assert split(table.lookup(0b00000000001011111)) == (1, 17)
    assert split(table.lookup(0b00000000001011110)) is None
    assert split(table.lookup(0)) is None


def test_encode_refuses_a_symbol_the_table_has_not() -> None:
    with pytest.raises(EncodeError) as caught:
        make("0", "1").encode(2)
    assert caught.value.value == 2
    assert caught.value.rule == "DCT-4"


@pytest.mark.parametrize(
    ("words", "law", "line"),
    [
        ([CodeWord(0, 1, "0", 2), CodeWord(1, 2, "1", 3)], "length: symbol 1", 3),
        ([CodeWord(0, 0, "", 2), CodeWord(1, 1, "1", 3)], "length: symbol 0", 2),
        ([CodeWord(0, 33, "0" * 33, 2), CodeWord(1, 1, "1", 3)], "length: symbol 0", 2),
        ([CodeWord(0, 2, "0x", 2), CodeWord(1, 1, "1", 3)], "length: symbol 0", 2),
        ([CodeWord(0, 1, "0", 2), CodeWord(0, 1, "1", 3)], "count: symbol 0", 3),
        ([CodeWord(0, 1, "0", 2), CodeWord(2, 1, "1", 3)], "count: symbol 2", 3),
        ([CodeWord(1, 1, "0", 2)], "count: symbol 0 is missing", None),
        ([], "count: symbol 0 is missing", None),
        # 01 begins 011, and 1/4 + 1/8 is far from full.
        ([CodeWord(0, 2, "01", 2), CodeWord(1, 3, "011", 3)], "prefix: symbol 1", 3),
        # 1/2 + 1/2 + 1/4 = 5/4
        ([CodeWord(0, 1, "0", 2), CodeWord(1, 2, "01", 3), CodeWord(2, 1, "1", 4)], "Kraft: symbol 1", 3),
    ],
)
def test_each_broken_law_is_one_located_error(words: list[CodeWord], law: str, line: int | None) -> None:
    with pytest.raises(InputFormat) as caught:
        build_table("t", "DCT-4", words, source="t.csv", symbols=range(3 if law.startswith("Kraft") else 2))
    assert (caught.value.what, caught.value.path, caught.value.line) == (law, "t.csv", line)


def test_the_message_names_both_words_and_the_sum() -> None:
    words = [CodeWord(0, 1, "0"), CodeWord(1, 2, "01"), CodeWord(2, 1, "1")]
    with pytest.raises(InputFormat, match=r"sum 5/4.*0 \(symbol 0\) begins 01 \(symbol 1\)"):
        build_table("t", "DCT-4", words)


def test_an_empty_table_without_wanted_symbols_is_refused() -> None:
    with pytest.raises(InputFormat, match="count: t table"):
        build_table("t", "MSH-5", [])


@pytest.mark.parametrize(("name", "rule"), [("mvd", "MSH-12"), ("mesh_delta_len", "MSH-5")])
def test_shipped_mesh_tables_decode_what_they_encode(name: str, rule: str) -> None:
    table = shipped_table(name, rule)
    for word in table.words:
        assert split(table.lookup(int(word.code, 2) << (table.max_length - word.bits))) == (
            word.symbol,
            word.bits,
        )
