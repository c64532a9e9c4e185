"""One CSV file: rows with their line numbers, typed cells, one located error for a damaged file.

Rules: CNF-7, CNF-25.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn

from snhc.reference_impl.bitstream.errors import InputFormat, cause

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from fractions import Fraction

TABLES: Final = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a table file; every accessor raises one located `InputFormat` for a cell that does not fit.

    Rules: CNF-7.

    `file`: name of the table file. `line`: from 1, the header is line 1. `rule`: the rule that states the
    table.
    """

    file: str
    line: int
    rule: str
    cells: dict[str, str]

    def fault(self, column: str, law: str) -> InputFormat:
        """The error for one cell. `law`: what the table allows there."""
        return InputFormat(self.rule, column, value=self.cells[column], allowed=law, line=self.line, path=self.file)

    def text(self, column: str) -> str:
        """The cell, not empty."""
        if not self.cells[column]:
            raise self.fault(column, "a text that is not empty")
        return self.cells[column]

    def integer(self, column: str, lo: int | None = None, hi: int | None = None) -> int:
        """The cell as a decimal integer in lo..hi (None: no bound)."""
        cell = self.cells[column]
        digits = cell[1:] if cell.startswith("-") else cell
        if not (digits.isascii() and digits.isdigit()):
            raise self.fault(column, "a decimal integer")
        value = int(cell)
        if (lo is not None and value < lo) or (hi is not None and value > hi):
            raise self.fault(column, f"{'' if lo is None else lo}..{'' if hi is None else hi}")
        return value

    def integer_or_none(self, column: str, empty: Sequence[str] = ("",)) -> int | None:
        """The cell as an integer, None where it says that there is none (`empty`)."""
        return None if self.cells[column] in empty else self.integer(column)

    def integers(self, column: str, separator: str) -> tuple[int, ...]:
        """The cell as a list of integers."""
        parts = self.cells[column].split(separator)
        if not all(part.isascii() and part.isdigit() for part in parts):
            raise self.fault(column, f"decimal integers separated by {separator!r}")
        return tuple(map(int, parts))

    def hexadecimal(self, column: str, digits: int) -> int:
        """The cell as exactly `digits` hexadecimal digits, with or without 0x in front."""
        cell = self.cells[column].removeprefix("0x")
        if len(cell) != digits or any(c not in "0123456789abcdefABCDEF" for c in cell):
            raise self.fault(column, f"{digits} hexadecimal digits")
        return int(cell, 16)

    def decimal(self, column: str) -> Fraction:
        """The cell as an exact number > 0 (`7.5` is 15/2)."""
        from fractions import Fraction

        whole, _, part = self.cells[column].partition(".")
        if not (whole + part).isascii() or not whole.isdigit() or (part and not part.isdigit()):
            raise self.fault(column, "a decimal number")
        value = Fraction(self.cells[column])
        if value <= 0:
            raise self.fault(column, "a number above 0")
        return value

    def same(self, column: str, value: int) -> int:
        """The cell, which must be `value` (numbering columns)."""
        if self.integer(column) != value:
            raise self.fault(column, str(value))
        return value


def read_rows(folder: Path, file: str, rule: str, columns: Sequence[str], count: int | None) -> tuple[Row, ...]:
    """The rows of one table file, its header and number of rows checked.

    Rules: CNF-7, CNF-25.

    `columns`: the header, exactly. `count`: rows it must have, None: at least one. Raises `InputFormat`
    naming file, line and law.
    """
    try:
        with (folder / file).open(encoding="utf-8", newline="") as stream:
            reader = csv.reader(stream, strict=True)
            found = [(reader.line_num, cells) for cells in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputFormat(rule, "table", value=cause(error), allowed="a readable CSV file", path=file) from error
    if not found or found[0][1] != list(columns):
        header = ",".join(found[0][1]) if found else ""
        raise InputFormat(rule, "header", value=header, allowed=",".join(columns), line=1, path=file)
    for line, cells in found:
        if len(cells) != len(columns):
            raise InputFormat(rule, "cells", value=len(cells), allowed=str(len(columns)), line=line, path=file)
    if len(found) - 1 != count and (count is not None or len(found) == 1):
        law = "1 or more" if count is None else str(count)
        raise InputFormat(rule, "rows", value=len(found) - 1, allowed=law, line=found[-1][0], path=file)
    return tuple(Row(file, line, rule, dict(zip(columns, cells, strict=True))) for line, cells in found[1:])


def broken(row: Row, column: str, law: str) -> NoReturn:
    """Raise the error of a law that binds several rows, at the row that breaks it.

    Rules: CNF-7.
    """
    raise row.fault(column, law)


def check_bracket(row: Row, lows: Iterable[str], highs: Iterable[str]) -> None:
    """Limits bracket 0: every low limit is <= 0, every high limit >= 0; empty cells are no limits.

    Rules: FBA-20.
    """
    for column in lows:
        if (row.integer_or_none(column) or 0) > 0:
            broken(row, column, "0 or less")
    for column in highs:
        if (row.integer_or_none(column) or 0) < 0:
            broken(row, column, "0 or more")
