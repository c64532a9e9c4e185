"""Entropy profiles: the shipped one, folders, and one located error per fault."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.entropy.prefix import LENGTH_BITS, LENGTH_MASK
from snhc.reference_impl.entropy.profile import MAX_TABLE_BYTES, TABLE_NAMES, load_profile
from snhc.reference_impl.tables.reading import TABLES

RUNLENGTH = "fap_dct_runlength_P1.csv"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    out = tmp_path / "mine"
    out.mkdir()
    for name in TABLE_NAMES:
        for file in TABLES.glob(f"fap_dct_{name}*.csv"):
            shutil.copy(file, out / file.name)
    return out


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert text.count(old) == 1
    file.write_text(text.replace(old, new))


def test_p1_holds_six_complete_tables_and_says_what_is_provisional() -> None:
    profile = load_profile()
    assert profile.name == "P1"
    assert profile.provisional
    assert profile.provisional_tables == ("intensity", "runlength", "dc", "ac")
    sizes = {name: len(getattr(profile, name)) for name in TABLE_NAMES}
    assert sizes == {
        "viseme_select": 29,
        "expression_select": 13,
        "intensity": 127,
        "runlength": 16,
        "dc": 512,
        "ac": 512,
    }
    assert all(getattr(profile, name).kraft == 1 for name in TABLE_NAMES)
    assert max(getattr(profile, name).max_length for name in TABLE_NAMES) == 17


def test_the_words_of_the_worked_example() -> None:
    profile = load_profile()
    # DCT-EX-1: run 0, AC -5, run 1, AC 2, end; run 14; inter DC -2 and 0.
    assert profile.runlength.encode(0) == (0b1, 1)
    assert profile.ac.encode(-5 + 256) == (0b01001, 5)
    assert profile.runlength.encode(1) == (0b011, 3)
    assert profile.ac.encode(2 + 256) == (0b1000, 4)
    assert profile.runlength.encode(15) == (0b010, 3)
    assert profile.runlength.encode(14) == (0, 9)
    assert profile.dc.encode(-2 + 256) == (0b10100, 5)
    assert profile.dc.encode(0 + 256) == (0b1110, 4)


def test_every_word_of_the_profile_is_read_back() -> None:
    profile = load_profile()
    for name in TABLE_NAMES:
        table = getattr(profile, name)
        for word in table.words:
            found = table.lookup(int(word.code, 2) << (table.max_length - word.bits))
            assert (found >> LENGTH_BITS, found & LENGTH_MASK) == (word.symbol, word.bits)


def test_a_folder_has_its_own_name_and_copied_tables_stay_provisional(folder: Path) -> None:
    text = (folder / RUNLENGTH).read_text()
    (folder / RUNLENGTH).unlink()
    # An own transcription: two words change places. CR LF and a byte order mark do no harm.
    text = text.replace("3,3,4,0010", "3,3,4,0011").replace("2,2,4,0011\n", "2,2,4,0010\n", 1)
    (folder / "fap_dct_runlength.csv").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    profile = load_profile(folder)
    assert profile.name == "mine"
    assert profile.provisional_tables == ("intensity", "dc", "ac")
    assert profile.runlength.encode(3) == (0b0011, 4)


def swap(old: str, new: str) -> Callable[[Path], None]:
    return lambda file: edit(file, old, new)


def append(text: bytes) -> Callable[[Path], None]:
    def apply(file: Path) -> None:
        file.write_bytes(file.read_bytes() + text)

    return apply


def empty(file: Path) -> None:
    file.write_bytes(b"")


def make_folder(file: Path) -> None:
    file.unlink()
    file.mkdir()


FAULTS: dict[str, tuple[Callable[[Path], None], str, int | None]] = {
    # Symbol 13 is 000000001; with 10 bits for symbol 14 the sum is 1 - 1/512 + 1/1024.
    "prefix": (swap("14,14,9,000000000", "14,14,10,0000000010"), "prefix: symbol 14", 16),
    # 01 begins 011 (symbol 1); the sum is 1 - 1/8 + 1/4.
    "Kraft": (swap("15,end of segment,3,010", "15,end of segment,2,01"), "Kraft: symbol 1", 3),
    "length": (swap("3,3,4,0010", "3,3,4,10"), "length: symbol 3", 5),
    "no word": (swap("3,3,4,0010", "3,3,4,2"), "length: symbol 3", 5),
    "too few": (swap("3,3,4,0010\n", ""), "count: symbol 3 is missing", None),
    "twice": (swap("3,3,4,0010", "2,2,4,0010"), "count: symbol 2", 5),
    "unknown": (append(b"16,16,4,0000\n"), "count: symbol 16", 18),
    "meaning": (swap("3,3,4,0010", "3,4,4,0010"), "meaning: symbol 3", 5),
    "symbol": (swap("3,3,4,0010", "-3,3,4,0010"), "symbol", 5),
    "bits": (swap("3,3,4,0010", "3,3,four,0010"), "bits", 5),
    "cells": (swap("3,3,4,0010", "3,3,4"), "row", 5),
    "blank line": (swap("3,3,4,0010", ""), "row", 5),
    "header": (swap("symbol,meaning", "symbol,difference"), "header", 1),
    "empty": (empty, "header", 1),
    "not UTF-8": (append(b"\xff\n"), "runlength table", 18),
    "too large": (append(b"\n" * MAX_TABLE_BYTES), "runlength table", None),
    "no file": (make_folder, "runlength table", None),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_one_error_that_names_file_symbol_and_law(folder: Path, fault: str) -> None:
    spoil, what, line = FAULTS[fault]
    spoil(folder / RUNLENGTH)
    with pytest.raises(InputFormat) as caught:
        load_profile(folder)
    error = caught.value
    assert error.what == what
    assert error.path == str(folder / RUNLENGTH)
    assert error.rule == "DCT-4"
    assert error.line == line


def test_what_is_no_regular_file_is_not_opened(folder: Path) -> None:
    # A pipe would be read for ever.
    make_folder(folder / RUNLENGTH)
    with pytest.raises(InputFormat, match="no regular file"):
        load_profile(folder)


def test_a_missing_table_a_second_one_and_a_missing_folder(folder: Path) -> None:
    shutil.copy(folder / RUNLENGTH, folder / "fap_dct_runlength_Q.csv")
    with pytest.raises(InputFormat, match="one file per table"):
        load_profile(folder)
    (folder / RUNLENGTH).unlink()
    (folder / "fap_dct_runlength_Q.csv").unlink()
    with pytest.raises(InputFormat, match="runlength table=missing") as caught:
        load_profile(folder)
    assert caught.value.path == str(folder / "fap_dct_runlength.csv")
    with pytest.raises(InputFormat, match="a folder of tables"):
        load_profile(folder / "nowhere")
