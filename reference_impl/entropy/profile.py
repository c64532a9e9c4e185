"""Entropy profiles: the six prefix codes that the DCT mode is read with, shipped or from a folder.

Rules: DCT-1, DCT-3, DCT-4, DCT-9, DCT-10 (which table codes what), CNF-7, CNF-25.

Not part of a profile: the scale list and the base steps (DCT-5) are normative.

Four of the standard's tables could not be established, so a set of tables is an explicit, named thing. `P1`
is the shipped one; its intensity, runlength, dc and ac tables are provisional. A folder with six files of the
same form replaces it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.entropy.prefix import CodeWord, PrefixTable, build_table
from snhc.reference_impl.tables.reading import TABLES

MAX_TABLE_BYTES: Final = 1 << 20
_SHIPPED: Final = "P1"


@dataclass(frozen=True, slots=True)
class _Form:
    """One file: rule, name of the second column, number of symbols.

    `offset`: what is taken from a symbol to get its meaning. `special`: the symbol whose second column may be
    a text, None where there is none.
    """

    rule: str
    column: str
    symbols: int
    offset: int
    special: int | None = None


_FORMS: Final = {
    "viseme_select": _Form("DCT-9", "difference", 29, 14),
    "expression_select": _Form("DCT-10", "difference", 13, 6),
    "intensity": _Form("DCT-9", "meaning", 127, 63),
    "runlength": _Form("DCT-4", "meaning", 16, 0, 15),
    "dc": _Form("DCT-3", "meaning", 512, 256, 0),
    "ac": _Form("DCT-4", "meaning", 512, 256, 256),
}
TABLE_NAMES: Final = tuple(_FORMS)


@dataclass(frozen=True, slots=True)
class EntropyProfile:
    """Six checked prefix codes and their name; symbols are those of the table files, from 0.

    Rules: DCT-3, DCT-4, DCT-9, DCT-10.

    `viseme_select` (symbol - 14), `expression_select` (symbol - 6), `intensity` (symbol - 63): differences.
    `dc`: symbol - 256, 0 escapes. `runlength`: 0..14, 15 ends the segment. `ac`: symbol - 256, 256 escapes.
    `provisional_tables`: names of the tables whose words are those of a provisional shipped table.
    """

    name: str
    viseme_select: PrefixTable
    expression_select: PrefixTable
    intensity: PrefixTable
    runlength: PrefixTable
    dc: PrefixTable
    ac: PrefixTable
    provisional_tables: tuple[str, ...]

    @property
    def provisional(self) -> bool:
        """Whether dumps and reports must say "provisional entropy tables". Rules: DCT-1."""
        return bool(self.provisional_tables)

    @property
    def label(self) -> str:
        """The name as headers, dumps and reports show it: `P1 (provisional entropy tables)`. Rules: DCT-1."""
        return f"{self.name} (provisional entropy tables)" if self.provisional else self.name


def load_profile(folder: Path | None = None) -> EntropyProfile:
    """Load and check an entropy profile.

    Rules: DCT-1, DCT-3, DCT-4, DCT-9, DCT-10, CNF-7, CNF-25.

    `folder`: holds one file per table, `fap_dct_dc.csv` or with one suffix `fap_dct_dc_NAME.csv`; None: the
    shipped profile `P1`. The profile has the folder's name. A folder that still holds words of `P1` is
    provisional too. Raises one `InputFormat` with the file as its path: a file that is missing, twice there,
    unreadable, not UTF-8 or over 1 MiB, a wrong header or row, or the law of `build_table` that is broken.
    """
    if folder is None:
        return _shipped_profile()
    if not folder.is_dir():
        raise InputFormat("DCT-1", "entropy profile", value=folder.name, allowed="a folder of tables", path=str(folder))
    shipped = _shipped_profile()
    tables = {name: _load_table(name, _find_file(folder, name)) for name in TABLE_NAMES}
    same = tuple(name for name in shipped.provisional_tables if _words(tables[name]) == _words(getattr(shipped, name)))
    return EntropyProfile(folder.resolve().name, **tables, provisional_tables=same)


@cache
def _shipped_profile() -> EntropyProfile:
    files = {name: _find_file(TABLES, name) for name in TABLE_NAMES}
    provisional = tuple(name for name, file in files.items() if file.stem.endswith(f"_{_SHIPPED}"))
    tables = {name: _load_table(name, file) for name, file in files.items()}
    return EntropyProfile(_SHIPPED, **tables, provisional_tables=provisional)


def _words(table: PrefixTable) -> dict[int, str]:
    return {word.symbol: word.code for word in table.words}


def _find_file(folder: Path, name: str) -> Path:
    exact = folder / f"fap_dct_{name}.csv"
    if exact.exists():
        return exact
    rule = _FORMS[name].rule
    try:
        found = sorted(folder.glob(f"fap_dct_{name}_*.csv"))
    except OSError as error:
        raise InputFormat(rule, f"{name} table", value=error.strerror, path=str(folder)) from error
    if not found:
        raise InputFormat(rule, f"{name} table", value="missing", allowed="one file of this name", path=str(exact))
    if len(found) > 1:
        names = ", ".join(file.name for file in found)
        raise InputFormat(rule, f"{name} table", value=names, allowed="one file per table", path=str(folder))
    return found[0]


def _load_table(name: str, file: Path) -> PrefixTable:
    form = _FORMS[name]
    lines = _read_lines(form.rule, name, file)
    header = f"symbol,{form.column},bits,code"
    if not lines or lines[0] != header:
        got = lines[0][:80] if lines else "an empty file"
        raise InputFormat(form.rule, "header", value=got, allowed=header, path=str(file), line=1)
    words: list[CodeWord] = []
    for number, line in enumerate(lines[1:], 2):
        cells = line.split(",")
        if len(cells) != 4:
            raise InputFormat(form.rule, "row", value=line[:80], allowed="4 cells", path=str(file), line=number)
        symbol = _integer(form, file, number, "symbol", cells[0])
        bits = _integer(form, file, number, "bits", cells[2])
        _check_meaning(form, file, number, symbol, cells[1])
        words.append(CodeWord(symbol, bits, cells[3], number))
    return build_table(name, form.rule, words, source=str(file), symbols=range(form.symbols))


def _read_lines(rule: str, name: str, file: Path) -> list[str]:
    if not file.is_file():
        raise InputFormat(rule, f"{name} table", value="no regular file", allowed="a CSV file", path=str(file))
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_TABLE_BYTES + 1)
    except OSError as error:
        raise InputFormat(rule, f"{name} table", value=error.strerror, path=str(file)) from error
    if len(data) > MAX_TABLE_BYTES:
        allowed = f"at most {MAX_TABLE_BYTES} bytes"
        raise InputFormat(rule, f"{name} table", value="too large", allowed=allowed, path=str(file))
    try:
        # Spreadsheets put a byte order mark in front and end lines with CR LF.
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        raise InputFormat(
            rule, f"{name} table", value=f"byte 0x{data[error.start]:02x}", allowed="UTF-8", path=str(file),
            line=before.count(b"\n") + 1, column=len(before) - before.rfind(b"\n"),
        ) from error  # fmt: skip
    lines = text.replace("\r\n", "\n").split("\n")
    while lines and not lines[-1]:
        lines.pop()
    return lines


def _integer(form: _Form, file: Path, line: int, column: str, cell: str) -> int:
    if not (cell.isascii() and cell.isdigit() and len(cell) <= 9):
        raise InputFormat(
            form.rule,
            column,
            value=cell[:40],
            allowed="a decimal integer, 0 or more",
            path=str(file),
            line=line,
        )
    return int(cell)


def _check_meaning(form: _Form, file: Path, line: int, symbol: int, cell: str) -> None:
    # A transcription that slipped by a row shows here: the second column says the same as the first.
    if symbol != form.special and cell not in ("", str(symbol - form.offset)):
        raise InputFormat(
            form.rule, f"{form.column}: symbol {symbol}", value=cell[:40], allowed=str(symbol - form.offset),
            path=str(file), line=line,
        )  # fmt: skip
