"""Variable length codes as data: rows checked to be prefix-free and to satisfy Kraft's inequality.

Rules: DCT-1, DCT-3, DCT-4, DCT-9, DCT-10, MSH-5, MSH-12. Reading bits with them is **not** here (entropy
room).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.tables.reading import TABLES, broken, read_rows

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, slots=True)
class _Form:
    """The form of one file: columns, name of the symbol and meaning columns, number of rows, first symbol."""

    rule: str
    columns: tuple[str, ...]
    symbol: str
    meaning: str
    count: int
    first: int = 0


_DCT = ("symbol", "meaning", "bits", "code")
_SELECT = ("symbol", "difference", "bits", "code")
_FORMS: Final = {
    "fap_dct_ac_P1": _Form("DCT-4", _DCT, "symbol", "meaning", 512),
    "fap_dct_dc_P1": _Form("DCT-3", _DCT, "symbol", "meaning", 512),
    "fap_dct_runlength_P1": _Form("DCT-4", _DCT, "symbol", "meaning", 16),
    "fap_dct_intensity_P1": _Form("DCT-9", _DCT, "symbol", "meaning", 127),
    "fap_dct_viseme_select": _Form("DCT-9", _SELECT, "symbol", "difference", 29),
    "fap_dct_expression_select": _Form("DCT-10", _SELECT, "symbol", "difference", 13),
    "mesh_delta_len": _Form(
        "MSH-5", ("delta_len", "bits", "code", "delta_code_bits", "value_range"),
        "delta_len", "value_range", 12,
    ),
    "mvd": _Form(
        "MSH-12", ("vlc_value", "mvd_halfsample_if_f1", "bits", "code"),
        "vlc_value", "mvd_halfsample_if_f1", 65, -32,
    ),
}  # fmt: skip
PREFIX_TABLES: Final = tuple(_FORMS)


@dataclass(frozen=True, slots=True)
class PrefixRow:
    """One code word.

    Rules: DCT-1, MSH-5.

    `symbol`: what the word stands for. `meaning`: the symbol in words, as the table file has it. `bits`:
    length of the word. `code`: the word as a string of 0 and 1, first bit first.
    """

    symbol: int
    meaning: str
    bits: int
    code: str


@dataclass(frozen=True, slots=True)
class PrefixTable:
    """A prefix-free code; rows ascend by symbol without gaps.

    Rules: DCT-1, MSH-5, MSH-12.

    `longest`: bits of the longest word. `complete`: every bit string begins with a word (the Kraft sum is 1).
    """

    name: str
    rows: tuple[PrefixRow, ...]
    longest: int
    complete: bool

    def by_code(self) -> dict[str, int]:
        """Word -> symbol, a new dictionary."""
        return {row.code: row.symbol for row in self.rows}

    def by_symbol(self) -> dict[int, str]:
        """Symbol -> word, a new dictionary."""
        return {row.symbol: row.code for row in self.rows}


@cache
def prefix_table(name: str, folder: Path = TABLES) -> PrefixTable:
    """The variable length code `name`, one of `PREFIX_TABLES`, checked.

    Rules: DCT-1, DCT-3, DCT-4, DCT-9, DCT-10, MSH-5, MSH-12.

    `folder`: where `name`.csv lies; someone's own transcription of the DCT tables has the same form. Raises
    `InputFormat` for a wrong number of symbols, a length that is not the word's, words that are not
    prefix-free.
    """
    form = _FORMS[name]
    read = read_rows(folder, f"{name}.csv", form.rule, form.columns, form.count)
    rows: list[PrefixRow] = []
    for number, row in enumerate(read, form.first):
        code = row.text("code")
        if set(code) - {"0", "1"}:
            broken(row, "code", "a string of 0 and 1")
        row.same("bits", len(code))
        rows.append(PrefixRow(row.same(form.symbol, number), row.text(form.meaning), len(code), code))
    # In sorted order a word that begins another stands directly before one that it begins.
    order = sorted(range(len(rows)), key=lambda i: rows[i].code)
    for i, j in pairwise(order):
        if rows[j].code.startswith(rows[i].code):
            broken(read[j], "code", f"words that do not begin with {rows[i].code} (prefix-free)")
    longest = max(row.bits for row in rows)
    # Prefix-free words cannot pass a Kraft sum of 1; the sum only tells whether the code is complete.
    kraft = sum(1 << (longest - row.bits) for row in rows)
    return PrefixTable(name, tuple(rows), longest, kraft == 1 << longest)
