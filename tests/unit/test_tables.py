"""The tables of the standard: what they hold, and one located error for every kind of damage.

Rules: FBA-14, FBA-18, FBA-29, FBA-40, DCT-1, DCT-5, MSH-5, MSH-12, MSH-13, SYS-1, SYS-8, FAC-4, FAC-6, FIT-8, CNF-25.
"""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
import sys
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import pytest

from snhc.reference_impl import tables
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.tables.reading import TABLES

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


def test_the_faps_are_68_in_10_groups_of_consecutive_numbers() -> None:
    faps = tables.fap_table()
    assert [fap.number for fap in faps] == list(range(1, 69))
    groups = tables.fap_groups()
    assert [group.count for group in groups] == [2, 16, 12, 8, 4, 5, 3, 10, 4, 4]
    for group in groups:
        members = [fap.number for fap in faps if fap.group == group.group]
        assert members == list(range(group.first_fap, group.last_fap + 1))


def test_rows_read_by_eye() -> None:
    faps = tables.fap_table()
    jaw = faps[2]
    assert (jaw.name, jaw.unit, jaw.QP, jaw.i_max, jaw.p_min) == ("open_jaw", "MNS", 4, 1080, -360)
    assert (faps[46].fdp_group, faps[46].fdp_point) == (6, (3, 4))
    assert (faps[0].fdp_group, faps[0].fdp_point) == (None, ())
    assert {fap.number for fap in faps if fap.direction == "U"} == {3, 14, 41, 42, 47}
    assert tables.bap_table()[185].number == 186
    assert tables.bap_table()[186].i_min is None
    assert tables.fap_dct_base_step()[2] == Fraction(15, 2)
    assert tables.visemes()[1].phonemes == ("p", "b", "m")
    assert tables.visemes()[0].phonemes == ()
    assert tables.expressions()[6].label == "surprise"
    assert tables.profile_level_codes()[1] == tables.ProfileLevel(0x61, "Simple Face Animation", 1)
    assert tables.mesh_motion_range()[7] == tables.MotionRange(7, 6, 64, 2048)
    assert tables.mesh_motion_range()[0].scale is None


def test_every_limit_range_holds_zero() -> None:
    for fap in tables.fap_table():
        assert fap.i_min <= 0 <= fap.i_max
        assert fap.p_min <= 0 <= fap.p_max
    for bap in tables.bap_table():
        limits = (bap.i_min, bap.i_max, bap.p_min, bap.p_max)
        assert all(limit is None for limit in limits) == (bap.number >= 187)


def test_the_bap_groups_hold_every_bap_once() -> None:
    members = [n for group in tables.bap_groups() for n in group.bap_numbers_in_coding_order]
    assert len(tables.bap_groups()) == 24
    assert sorted(members) == list(range(1, 297))
    assert tables.bap_groups()[1].bap_numbers_in_coding_order == (4, 6, 10, 14)


def test_the_counts_of_the_small_tables() -> None:
    assert len(tables.bap_quant_scale()) == len(tables.fap_dct_scale()) == 32
    assert (len(tables.visemes()), len(tables.expressions()), len(tables.left_right_pairs())) == (15, 7, 23)


def test_left_right_pairs_are_named_after_each_other() -> None:
    faps = tables.fap_table()
    for left, right in tables.left_right_pairs():
        names = faps[left - 1].name, faps[right - 1].name
        assert names[1] in (names[0].replace("_l_", "_r_"), names[0].replace("_lm", "_rm"))


def test_the_seven_high_level_symbols_at_some_m() -> None:
    symbols = tables.viseme_expression_symbols()
    assert [symbol.fap for symbol in symbols] == [1, 1, 1, 2, 2, 2, 2]
    assert [symbol.intra_limits(13) for symbol in symbols[:4]] == [(0, 14), (0, 14), (0, 13), (0, 6)]
    assert [symbol.inter_limits(13) for symbol in symbols[1:5]] == [(-14, 14), (-13, 13), (-6, 6), (-13, 13)]
    assert [s.name for s in symbols if s.quantised_by_fap_quant] == [
        "viseme_blend",
        "expression_intensity1",
        "expression_intensity2",
    ]


def test_start_codes_by_name() -> None:
    single = {code.name: code.value for code in tables.start_codes() if code.value == code.last and not code.compat}
    assert single == {
        "visual_object_sequence_start_code": 0x1B0,
        "visual_object_sequence_end_code": 0x1B1,
        "user_data_start_code": 0x1B2,
        "visual_object_start_code": 0x1B5,
        "fba_object_start_code": 0x1BA,
        "fba_object_plane_start_code": 0x1BB,
        "mesh_object_start_code": 0x1BC,
        "mesh_object_plane_start_code": 0x1BD,
        "still_texture_object_start_code": 0x1BE,
    }
    assert all(tables.start_code(name) == value for name, value in single.items())
    video = next(code for code in tables.start_codes() if code.name == "video_object_start_code")
    assert (video.value, video.last) == (0x100, 0x11F)
    assert {code.value for code in tables.start_codes() if code.compat == "draft"} == {0x101, 0x103}
    with pytest.raises(InputFormat, match="no_such_code"):
        tables.start_code("no_such_code")


@pytest.mark.parametrize("name", tables.PREFIX_TABLES)
def test_codes_are_prefix_free_and_complete_but_for_the_reserved_words_of_the_mesh(name: str) -> None:
    table = tables.prefix_table(name)
    codes = [row.code for row in table.rows]
    assert not any(b.startswith(a) for a in codes for b in codes if a is not b)
    kraft = sum(Fraction(1, 1 << len(code)) for code in codes)
    # The standard leaves 111111111x and 00000000000x unassigned.
    holes = {"mesh_delta_len": Fraction(1, 512), "mvd": Fraction(1, 2048)}.get(name, Fraction(0))
    assert kraft == 1 - holes
    assert table.complete == (holes == 0)
    assert table.longest == max(map(len, codes))
    assert {table.by_code()[code]: code for code in codes} == table.by_symbol()


def test_code_words_read_by_eye() -> None:
    assert tables.prefix_table("mesh_delta_len").by_symbol()[5] == "110"
    assert tables.prefix_table("mvd").by_symbol()[-32] == "0000000000101"
    assert tables.prefix_table("fap_dct_viseme_select").by_symbol()[14] == "1"
    assert tables.prefix_table("fap_dct_runlength_P1").rows[15].meaning == "end of segment"


def test_a_table_is_read_once_and_cannot_be_changed() -> None:
    assert tables.fap_table() is tables.fap_table()
    with pytest.raises(dataclasses.FrozenInstanceError):
        tables.fap_table()[0].QP = 2  # type: ignore[misc]


def test_importing_the_tables_reads_no_file_and_loads_no_numpy() -> None:
    code = (
        "import sys; from snhc.reference_impl import tables; "
        "assert tables.fap_table.cache_info().currsize == 0; assert 'numpy' not in sys.modules; tables.fap_table()"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


DAMAGES = [
    ("fap_table", tables.fap_table, "68,pull_r_ear", "69,pull_r_ear", "number", 69),
    ("fap_table", tables.fap_table, "4,-1080,1080", "4,1,1080", "i_min", 4),
    ("fap_table", tables.fap_table, "4,-1080,1080", "4,-1080,-1", "i_max", 4),
    ("fap_table", tables.fap_table, "4,-1080,1080", "0,-1080,1080", "QP", 4),
    ("fap_table", tables.fap_table, "3,open_jaw,2", "3,open_jaw,3", "group", 4),
    ("fap_table", tables.fap_table, "3,open_jaw,2,MNS", "3,open_jaw,2,mns", "unit", 4),
    ("fap_table", tables.fap_table, "3,open_jaw", "3,expression", "name", 4),
    ("fap_table", tables.fap_table, "3,open_jaw", "drei,open_jaw", "number", 4),
    ("fap_table", tables.fap_table, "3,open_jaw,", "3,open_jaw,1,", "cells", 4),
    ("fap_table", tables.fap_table, "number,name", "Number,name", "header", 1),
    ("fap_groups", tables.fap_groups, "10,ears,4,65,68", "10,ears,4,65,69", "last_fap", 11),
    ("fap_groups", tables.fap_groups, "10,ears,4,65,68", "10,ears,3,65,67", "last_fap", 11),
    ("fap_groups", tables.fap_groups, "9,nose,4,61", "9,nose,4,60", "first_fap", 10),
    ("bap_groups", tables.bap_groups, "1,pelvis,3,1 2 3", "1,pelvis,3,1 2 4", "bap_numbers_in_coding_order", 3),
    ("bap_groups", tables.bap_groups, "1,pelvis,3,1 2 3", "1,pelvis,2,1 2", "bap_numbers_in_coding_order", 25),
    ("bap_groups", tables.bap_groups, "1,pelvis,3,", "1,pelvis,4,", "count", 2),
    ("bap_table", tables.bap_table, "4,l_hip_flexion,2,0", "4,l_hip_flexion,2,1", "index_in_group", 5),
    ("bap_table", tables.bap_table, "4,l_hip_flexion,2", "4,l_hip_flexion,3", "group", 5),
    ("bap_table", tables.bap_table, "64,170,-960,960,-600,600", "64,170,,960,-600,600", "i_min", 2),
    ("bap_quant_scale", tables.bap_quant_scale, "31,127\n", "", "rows", 32),
    ("bap_quant_scale", tables.bap_quant_scale, "31,127", "31,1", "scale", 33),
    ("fap_dct_scale", tables.fap_dct_scale, "31,1039", "30,1039", "fap_quant", 33),
    ("fap_dct_base_step", tables.fap_dct_base_step, "3,7.5", "3,7.5e", "base_step", 4),
    ("fap_dct_base_step", tables.fap_dct_base_step, "3,7.5", "3,0", "base_step", 4),
    ("visemes", tables.visemes, "14,ou,U,book\n", "", "rows", 15),
    ("expressions", tables.expressions, "6,surprise", "6,", "label", 8),
    ("left_right_pairs", tables.left_right_pairs, "8,9", "8,7", "fap_b", 3),
    ("left_right_pairs", tables.left_right_pairs, "8,9", "8,69", "fap_b", 3),
    ("start_codes", tables.start_codes, "000001BA", "000001BB", "value", 9),
    ("start_codes", tables.start_codes, "000001BA", "1BA", "value", 8),
    ("start_codes", tables.start_codes, "0000011F", "000000FF", "last", 2),
    ("start_codes", tables.start_codes, "00000103,,draft", "00000103,,early", "compat", 14),
    ("profile_level_codes", tables.profile_level_codes, "0x62", "0x61", "code_hex", 4),
    ("viseme_expression_symbols", tables.viseme_expression_symbols, "0,0,14,-14", "0,0,14,14", "p_min", 2),
    ("viseme_expression_symbols", tables.viseme_expression_symbols, "0,(63+q/2)/q", "0,63/q", "i_max", 4),
    ("mesh_motion_range", tables.mesh_motion_range, "7,6,64,2048", "7,6,64,2047", "range_R", 9),
    ("mvd", lambda f: tables.prefix_table("mvd", f), "-32,-16,13,", "-32,-16,12,", "bits", 2),
    ("mvd", lambda f: tables.prefix_table("mvd", f), "-32,-16,", "-33,-16,", "vlc_value", 2),
    ("mesh_delta_len", lambda f: tables.prefix_table("mesh_delta_len", f), "1,3,010", "1,3,001", "code", 3),
    ("mesh_delta_len", lambda f: tables.prefix_table("mesh_delta_len", f), "1,3,010", "1,3,012", "code", 3),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "load", "old", "new", "what", "line"),
    DAMAGES,
    ids=[f"{d[0]}-{d[4]}-{d[5]}-{d[3]}" for d in DAMAGES],
)
def test_a_damaged_table_is_one_located_error(
    tmp_path: Path, name: str, load: Callable[[Path], Any], old: str, new: str, what: str, line: int
) -> None:
    folder = shutil.copytree(TABLES, tmp_path / "tables", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    file = folder / {"left_right_pairs": "fap_left_right_pairs.csv"}.get(name, f"{name}.csv")
    text = file.read_text(encoding="utf-8")
    assert load(folder), "the copy loads before it is damaged"
    load.cache_clear() if hasattr(load, "cache_clear") else tables.prefix_table.cache_clear()
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputFormat) as caught:
        load(folder)
    fault = caught.value
    assert (fault.path, fault.line) == (file.name, line)
    assert fault.what.startswith(what)
    assert fault.allowed


@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe", b'number,"name\n'])
def test_a_file_that_is_no_table_is_one_error(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "expressions.csv").write_bytes(content)
    with pytest.raises(InputFormat, match=r"expressions\.csv"):
        tables.expressions(tmp_path)
