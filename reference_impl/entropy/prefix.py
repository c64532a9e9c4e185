"""Prefix codes: checked tables of code words, and the look-up that the syntax machines decode with.

Rules: DCT-1, DCT-3, DCT-4, DCT-9, DCT-10, MSH-5, MSH-12 (the form of the words), CNF-21, CNF-26 (what an
unmatched word spans).

Not implemented here: which words a table holds (data files) and what a symbol means (the syntax functions).

A table is checked when it is made: length column, symbols, words that begin other words, Kraft sum. Look-up
is direct in the first `_DIRECT_BITS` bits and a binary search behind them: one flat list of 2**17 entries per
table would cost three megabytes for words that hardly ever come, and words of any length up to
`MAX_WORD_BITS` stay cheap.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import Final

from snhc.reference_impl.bitstream.errors import EncodeError, InputFormat
from snhc.reference_impl.tables import prefix as _files

MAX_WORD_BITS: Final = 32
NO_WORD: Final = 0
LENGTH_BITS: Final = 6
LENGTH_MASK: Final = (1 << LENGTH_BITS) - 1
_DIRECT_BITS: Final = 10


@dataclass(frozen=True)
class CodeWord:
    """One row of a code table as it was written down.

    Rules: DCT-1.

    `symbol`: any integer. `bits`: the length column. `code`: the word as `0` and `1`, first bit first.
    `line`: line of the text file, from 1; 0 where there is none.
    """

    symbol: int
    bits: int
    code: str
    line: int = 0


class PrefixTable:
    """A frozen prefix code. Made by `build_table` only, which checks it.

    Rules: DCT-1, CNF-26.

    `name`: shown in traces. `rule`: the rule that reads the table. `words`: the rows, in table order.
    `max_length`: bits of the longest word, which is also what an unmatched word spans (cut at the end of the
    data). `kraft`: exact sum of 2**-length; 1 means that every bit sequence begins with a word. `direct`: what `lookup`
    finds by the first `direct_bits` bits of a window, NO_WORD where more are needed.
    """

    __slots__ = (
        "_codes", "_starts", "_values", "direct", "direct_bits", "kraft", "max_length", "name", "rule",
        "words",
    )  # fmt: skip

    def __init__(self, name: str, rule: str, words: tuple[CodeWord, ...]) -> None:
        self.name: Final[str] = name
        self.rule: Final[str] = rule
        self.words: Final[tuple[CodeWord, ...]] = words
        longest = max(len(word.code) for word in words)
        self.max_length: Final[int] = longest
        self.kraft: Final[Fraction] = Fraction(sum(1 << (longest - len(word.code)) for word in words), 1 << longest)
        self._codes: Final[dict[int, tuple[int, int]]] = {w.symbol: (int(w.code, 2), len(w.code)) for w in words}
        # Prefix-free words cover disjoint intervals of the left-aligned windows: sorted by their first
        # window, the word of a window is the last one that starts at or before it.
        aligned = sorted((int(w.code, 2) << (longest - len(w.code)), len(w.code), w.symbol) for w in words)
        self._starts: Final[list[int]] = [start for start, _, _ in aligned]
        self._values: Final[list[int]] = [symbol << LENGTH_BITS | length for _, length, symbol in aligned]
        direct_bits = min(longest, _DIRECT_BITS)
        self.direct_bits: Final[int] = direct_bits
        direct = [NO_WORD] * (1 << direct_bits)
        for start, length, symbol in aligned:
            if length <= direct_bits:
                first = start >> (longest - direct_bits)
                count = 1 << (direct_bits - length)
                direct[first : first + count] = [symbol << LENGTH_BITS | length] * count
        self.direct: Final[list[int]] = direct

    def lookup(self, window: int) -> int:
        """Find the word that a window begins with.

        Rules: DCT-1, CNF-26.

        `window`: the next `max_length` bits as an unsigned integer, zero padded behind the end of the data.
        Result: `symbol << LENGTH_BITS | length`, or `NO_WORD`. Both parts are ints in one so that no tuple is
        made per symbol: `symbol = found >> LENGTH_BITS`, `length = found & LENGTH_MASK`. A length greater
        than the bits that are left means that the data ends inside a word.
        """
        found = self.direct[window >> (self.max_length - self.direct_bits)]
        if found != NO_WORD:
            return found
        i = bisect_right(self._starts, window) - 1
        if i < 0:
            return NO_WORD
        found = self._values[i]
        spare = self.max_length - (found & LENGTH_MASK)
        return found if window >> spare == self._starts[i] >> spare else NO_WORD

    def is_beginning(self, value: int, length: int) -> bool:
        """Tell whether bits are the beginning of at least one word, or a whole word.

        Rules: CNF-21, CNF-26.

        `value`, `length`: the bits that are left, as an unsigned integer and their number, 0..`max_length`.
        True for the last bits of the data where no word matched means that the data ends inside a word
        (`Truncated`); False that no word begins so (`ReservedValue`). The span is the same.
        """
        first = value << (self.max_length - length)
        past = (value + 1) << (self.max_length - length)
        i = bisect_right(self._starts, first - 1)
        return i < len(self._starts) and self._starts[i] < past and self._values[i] & LENGTH_MASK >= length

    def encode(self, symbol: int) -> tuple[int, int]:
        """The word of a symbol as (code, length).

        Rules: DCT-1.

        Raises `EncodeError` for a symbol that the table does not hold.
        """
        found = self._codes.get(symbol)
        if found is None:
            raise EncodeError(self.rule, f"{self.name} symbol", value=symbol, allowed="a symbol of the table")
        return found

    def bits_of(self, symbol: int) -> int:
        """The length of the word of a symbol. Rules: DCT-1, CNF-21. Raises `EncodeError` as `encode`."""
        return self.encode(symbol)[1]

    def __contains__(self, symbol: object) -> bool:
        return symbol in self._codes

    def __len__(self) -> int:
        return len(self.words)


def build_table(
    name: str, rule: str, words: Sequence[CodeWord], *, source: str = "", symbols: range | None = None
) -> PrefixTable:
    """Check code words and make the table of them.

    Rules: DCT-1, CNF-7, CNF-25.

    `name`: of the table. `rule`: the rule that reads it. `words`: rows in table order. `source`: file name
    for errors. `symbols`: the symbols that have to be there, each once; None: any, each once. Raises one
    `InputFormat` that names the file, the symbol, its line and the law that is broken: `length` (the bits
    column and the word disagree, or the word is no word), `count` (a symbol twice, unknown or missing),
    `Kraft` (the sum of 2**-length passes 1), `prefix` (a word begins another one).
    """
    seen: set[int] = set()
    for word in words:
        if not word.code or len(word.code) > MAX_WORD_BITS or word.code.strip("01"):
            raise _broken(rule, source, word, "length", word.code, f"1..{MAX_WORD_BITS} characters 0 and 1")
        if word.bits != len(word.code):
            raise _broken(rule, source, word, "length", f"{word.bits} bits", f"{len(word.code)}, as in {word.code}")
        if symbols is not None and word.symbol not in symbols:
            raise _broken(rule, source, word, "count", word.symbol, f"{symbols[0]}..{symbols[-1]}")
        if word.symbol in seen:
            raise _broken(rule, source, word, "count", word.symbol, "each symbol once")
        seen.add(word.symbol)
    if not words or (symbols is not None and len(words) != len(symbols)):
        missing = next((s for s in symbols if s not in seen), None) if symbols is not None else None
        raise InputFormat(
            rule,
            f"count: {name} table" if missing is None else f"count: symbol {missing} is missing",
            value=f"{len(words)} symbols",
            path=source,
            expected=len(symbols) if symbols is not None else "at least 1",
        )
    _check_prefixes(rule, source, words)
    return PrefixTable(name, rule, tuple(words))


@cache
def shipped_table(name: str, rule: str) -> PrefixTable:
    """One of the variable length codes of `tables/` (`mvd`, `mesh_delta_len`, ...), ready for decoding.

    Rules: DCT-1, MSH-5, MSH-12.

    `name`: file name without `.csv`. `rule`: the rule that reads the table. Raises `InputFormat` for a
    damaged file.
    """
    rows = _files.prefix_table(name).rows
    return build_table(name, rule, [CodeWord(r.symbol, r.bits, r.code) for r in rows], source=f"{name}.csv")


def _check_prefixes(rule: str, source: str, words: Sequence[CodeWord]) -> None:
    # In the order of the words as text, a word that begins others stands directly before one of them.
    ordered = sorted(words, key=lambda word: word.code)
    for before, after in pairwise(ordered):
        if after.code.startswith(before.code):
            break
    else:
        return
    # A Kraft sum above 1 cannot be without such a pair; it is named as the graver fault of the two.
    kraft = sum((Fraction(1, 1 << len(word.code)) for word in words), Fraction(0))
    clash = f"{before.code} (symbol {before.symbol}) begins {after.code} (symbol {after.symbol})"
    if kraft > 1:
        raise _broken(rule, source, after, "Kraft", f"sum {kraft}", f"at most 1; {clash}")
    raise _broken(rule, source, after, "prefix", after.code, f"no word that begins another; {clash}")


def _broken(rule: str, source: str, word: CodeWord, law: str, value: int | str, allowed: str) -> InputFormat:
    return InputFormat(
        rule,
        f"{law}: symbol {word.symbol}",
        value=value,
        allowed=allowed,
        path=source,
        line=word.line or None,
    )
