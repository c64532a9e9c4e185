"""The tables of the standard, typed.

Rules: FBA-1, FBA-4, FBA-14, FBA-18, FBA-20, FBA-29, FBA-31, FBA-40, DCT-5, MSH-12, MSH-13, SYS-1, SYS-8,
FAC-4, FAC-6, FIT-8.

Records carry the column names of their files. Every function takes `folder`, the place of the files, reads
each file once and raises `InputFormat` (file, line, law) if it is damaged.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.tables.reading import TABLES, Row, broken, check_bracket, read_rows
from snhc.reference_impl.tables.records import (
    M_FORMULA,
    Bap,
    BapGroup,
    Expression,
    Fap,
    FapGroup,
    HighLevelSymbol,
    MotionRange,
    ProfileLevel,
    StartCode,
    Viseme,
)

if TYPE_CHECKING:
    from fractions import Fraction
    from pathlib import Path

_LIMITS: Final = ("i_min", "i_max", "p_min", "p_max")


@cache
def fap_table(folder: Path = TABLES) -> tuple[Fap, ...]:
    """The 68 FAPs; index 0 is FAP 1.

    Rules: FBA-18, FBA-31, FAC-4.
    """
    columns = (
        "number",
        "name",
        "group",
        "unit",
        "direction",
        "positive_motion",
        "fdp_group",
        "fdp_point",
        "QP",
    )
    rows = read_rows(folder, "fap_table.csv", "FBA-18", (*columns, *_LIMITS), 68)
    names: set[str] = set()
    out: list[Fap] = []
    for number, row in enumerate(rows, 1):
        check_bracket(row, ("i_min", "p_min"), ("i_max", "p_max"))
        _choice(row, "unit", ("MNS", "MW", "ENS", "ES", "IRISD", "AU", "na"))
        _choice(row, "direction", ("B", "U", "na"))
        _once(row, "name", names)
        point = row.cells["fdp_point"]
        out.append(
            Fap(
                row.same("number", number), row.text("name"), row.integer("group", 1, 10), row.text("unit"),
                row.text("direction"), row.text("positive_motion"), row.integer_or_none("fdp_group", ("na",)),
                () if point == "na" else row.integers("fdp_point", ";"), row.integer("QP", 1),
                *(row.integer(limit) for limit in _LIMITS),
            )
        )  # fmt: skip
    for row, fap in zip(rows, out, strict=True):
        group = fap_groups(folder)[fap.group - 1]
        if not group.first_fap <= fap.number <= group.last_fap:
            broken(row, "group", f"the group of FAP {fap.number} in fap_groups.csv")
    return tuple(out)


@cache
def fap_groups(folder: Path = TABLES) -> tuple[FapGroup, ...]:
    """The 10 FAP groups, index 0 is group 1; they cover FAP 1..68 without gaps.

    Rules: FBA-14, FBA-10.
    """
    columns = ("group", "name", "count", "first_fap", "last_fap")
    out: list[FapGroup] = []
    following = 1
    rows = read_rows(folder, "fap_groups.csv", "FBA-14", columns, 10)
    for number, row in enumerate(rows, 1):
        count = row.integer("count", 1, 68)
        group = FapGroup(
            row.same("group", number), row.text("name"), count,
            row.same("first_fap", following), row.same("last_fap", following + count - 1),
        )  # fmt: skip
        following += count
        out.append(group)
    if following != 69:
        broken(rows[-1], "last_fap", "68")
    return tuple(out)


@cache
def bap_table(folder: Path = TABLES) -> tuple[Bap, ...]:
    """The 296 BAPs; index 0 is BAP 1.

    Rules: FBA-40.
    """
    columns = ("number", "name", "group", "index_in_group", "unit", "base_step", "base_step_variant_b")
    rows = read_rows(folder, "bap_table.csv", "FBA-40", (*columns, *_LIMITS), 296)
    names: set[str] = set()
    out: list[Bap] = []
    for number, row in enumerate(rows, 1):
        check_bracket(row, ("i_min", "p_min"), ("i_max", "p_max"))
        _choice(row, "unit", ("1e-5 rad", "mm", "na"))
        _once(row, "name", names)
        if len({row.cells[limit] == "" for limit in _LIMITS}) != 1:
            broken(row, "i_min", "all four limits or none")
        out.append(
            Bap(
                row.same("number", number), row.text("name"), row.integer("group", 1, 24),
                row.integer("index_in_group", 0), row.text("unit"), row.integer("base_step", 1),
                row.integer("base_step_variant_b", 1), *(row.integer_or_none(limit) for limit in _LIMITS),
            )
        )  # fmt: skip
    for row, bap in zip(rows, out, strict=True):
        members = bap_groups(folder)[bap.group - 1].bap_numbers_in_coding_order
        if bap.number not in members:
            broken(row, "group", f"the group of BAP {bap.number} in bap_groups.csv")
        if members.index(bap.number) != bap.index_in_group:
            broken(row, "index_in_group", f"{members.index(bap.number)}, its place in bap_groups.csv")
    return tuple(out)


@cache
def bap_groups(folder: Path = TABLES) -> tuple[BapGroup, ...]:
    """The 24 BAP groups, index 0 is group 1; every BAP stands in exactly one.

    Rules: FBA-40.
    """
    columns = ("group", "name", "count", "bap_numbers_in_coding_order")
    seen: set[int] = set()
    out: list[BapGroup] = []
    rows = read_rows(folder, "bap_groups.csv", "FBA-40", columns, 24)
    for number, row in enumerate(rows, 1):
        members = row.integers("bap_numbers_in_coding_order", " ")
        row.same("count", len(members))
        if len(set(members)) != len(members) or seen & set(members) or not set(members) <= set(range(1, 297)):
            broken(row, "bap_numbers_in_coding_order", "each BAP 1..296 in one group, once")
        seen |= set(members)
        out.append(BapGroup(row.same("group", number), row.text("name"), len(members), members))
    if len(seen) != 296:
        broken(rows[-1], "bap_numbers_in_coding_order", "groups that hold every BAP 1..296")
    return tuple(out)


@cache
def bap_quant_scale(folder: Path = TABLES) -> tuple[int, ...]:
    """bap_quant 0..31 -> scale; scale 0 stands for "value = level".

    Rules: FBA-40.
    """
    return _scale(folder, "bap_quant_scale.csv", "FBA-40", ("bap_pred_quant_index", "scale"))


@cache
def fap_dct_scale(folder: Path = TABLES) -> tuple[int, ...]:
    """fap_quant 0..31 -> fap_scale of the DCT mode.

    Rules: DCT-5.
    """
    return _scale(folder, "fap_dct_scale.csv", "DCT-5", ("fap_quant", "fap_scale"))


def _scale(folder: Path, file: str, rule: str, columns: tuple[str, str]) -> tuple[int, ...]:
    out: list[int] = []
    for number, row in enumerate(read_rows(folder, file, rule, columns, 32)):
        row.same(columns[0], number)
        out.append(row.integer(columns[1], out[-1] if out else 0))
    return tuple(out)


@cache
def fap_dct_base_step(folder: Path = TABLES) -> tuple[Fraction, ...]:
    """AC base step of FAP 1..68 (index 0 is FAP 1), exact.

    Rules: DCT-5.
    """
    rows = read_rows(folder, "fap_dct_base_step.csv", "DCT-5", ("fap", "base_step"), 68)
    for number, row in enumerate(rows, 1):
        row.same("fap", number)
    return tuple(row.decimal("base_step") for row in rows)


@cache
def start_codes(folder: Path = TABLES) -> tuple[StartCode, ...]:
    """All start codes; the two draft codes lie inside the range of video objects.

    Rules: SYS-1, FBA-1, FBA-2, FBA-4.
    """
    names: set[str] = set()
    taken: dict[str, set[int]] = {"": set(), "draft": set()}
    out: list[StartCode] = []
    for row in read_rows(folder, "start_codes.csv", "SYS-1", ("name", "value", "last", "compat"), None):
        value = row.hexadecimal("value", 8)
        last = row.hexadecimal("last", 8) if row.cells["last"] else value
        if not 0x100 <= value <= 0x1FF:
            broken(row, "value", "00000100..000001FF")
        if not value <= last <= 0x1FF:
            broken(row, "last", "value..000001FF")
        _choice(row, "compat", ("", "draft"))
        compat = row.cells["compat"]
        if taken[compat] & set(range(value, last + 1)):
            broken(row, "value", "codes that no other row has")
        taken[compat] |= set(range(value, last + 1))
        _once(row, "name", names)
        out.append(StartCode(row.text("name"), value, last, compat))
    return tuple(out)


def start_code(name: str, folder: Path = TABLES) -> int:
    """The 32-bit value of the start code `name` (`fba_object_start_code`), the first one of a range.

    Rules: SYS-1, FBA-1, FBA-2, FBA-4.
    """
    for code in start_codes(folder):
        if code.name == name:
            return code.value
    raise InputFormat("SYS-1", "name", value=name, allowed="a name of the table", path="start_codes.csv")


@cache
def viseme_expression_symbols(folder: Path = TABLES) -> tuple[HighLevelSymbol, ...]:
    """The seven symbols of FAP 1 (three) and FAP 2 (four) in the coding order of the arithmetic mode.

    Rules: FBA-28, FBA-29.
    """
    columns = ("order", "name", "fap", "quantised_by_fap_quant", *_LIMITS)
    out: list[HighLevelSymbol] = []
    for number, row in enumerate(read_rows(folder, "viseme_expression_symbols.csv", "FBA-29", columns, 7)):
        for limit in _LIMITS:
            cell = row.cells[limit]
            if cell.removeprefix("-") != M_FORMULA:
                row.integer(limit)
            # As text: a limit with a sign is a lower one, M is positive.
            if cell != "0" and cell.startswith("-") != limit.endswith("min"):
                broken(row, limit, "limits that bracket 0")
        quantised = row.integer("quantised_by_fap_quant", 0, 1) == 1
        fap = row.same("fap", 1 if number < 3 else 2)
        out.append(
            HighLevelSymbol(
                row.same("order", number), row.text("name"), fap, quantised,
                *(row.cells[limit] for limit in _LIMITS),
            )
        )  # fmt: skip
    return tuple(out)


@cache
def visemes(folder: Path = TABLES) -> tuple[Viseme, ...]:
    """Visemes 0..14; 0 is silence and has no phonemes.

    Rules: FAC-6.
    """
    rows = read_rows(folder, "visemes.csv", "FAC-6", ("viseme_select", "label", "phonemes", "example"), 15)
    out: list[Viseme] = []
    for number, row in enumerate(rows):
        cell = row.text("phonemes")
        phonemes = () if cell == "none" else tuple(cell.split())
        out.append(Viseme(row.same("viseme_select", number), row.text("label"), phonemes, row.text("example")))
    return tuple(out)


@cache
def expressions(folder: Path = TABLES) -> tuple[Expression, ...]:
    """Expressions 0..6; 0 is neutral.

    Rules: FAC-6.
    """
    rows = read_rows(folder, "expressions.csv", "FAC-6", ("expression_select", "label"), 7)
    return tuple(Expression(row.same("expression_select", n), row.text("label")) for n, row in enumerate(rows))


@cache
def left_right_pairs(folder: Path = TABLES) -> tuple[tuple[int, int], ...]:
    """Pairs of FAPs that mirror each other; no FAP stands in two.

    Rules: FIT-8.
    """
    seen: set[str] = set()
    out: list[tuple[int, int]] = []
    for row in read_rows(folder, "fap_left_right_pairs.csv", "FIT-8", ("fap_a", "fap_b"), 23):
        pair = row.integer("fap_a", 3, 68), row.integer("fap_b", 3, 68)
        _once(row, "fap_a", seen)
        _once(row, "fap_b", seen)
        out.append(pair)
    return tuple(out)


@cache
def profile_level_codes(folder: Path = TABLES) -> tuple[ProfileLevel, ...]:
    """The known values of profile_and_level_indication.

    Rules: SYS-8.
    """
    seen: set[str] = set()
    out: list[ProfileLevel] = []
    for row in read_rows(folder, "profile_level_codes.csv", "SYS-8", ("code_hex", "profile", "level"), 9):
        _once(row, "code_hex", seen)
        out.append(ProfileLevel(row.hexadecimal("code_hex", 2), row.text("profile"), row.integer("level", 1)))
    return tuple(out)


@cache
def profile_tools(folder: Path = TABLES) -> dict[str, frozenset[str]]:
    """Which of the tools `face`, `body` and `mesh` a profile contains, by the profile's name; none where it has none.

    Rules: SYS-9, SYS-8.
    """
    names = {row.profile for row in profile_level_codes(folder)}
    out: dict[str, set[str]] = {name: set() for name in names}
    for row in read_rows(folder, "profile_tools.csv", "SYS-9", ("profile", "tool"), 7):
        _choice(row, "profile", tuple(sorted(names)))
        _choice(row, "tool", ("face", "body", "mesh"))
        out[row.text("profile")].add(row.text("tool"))
    return {name: frozenset(tools) for name, tools in out.items()}


@cache
def mesh_motion_range(folder: Path = TABLES) -> tuple[MotionRange, ...]:
    """motion_range_code 0..7; index 0 is the forbidden code.

    Rules: MSH-12, MSH-13.
    """
    columns = ("motion_range_code", "r_size_bits", "scale", "range_R_half_pel(-R..R-1)")
    out: list[MotionRange] = []
    for code, row in enumerate(read_rows(folder, "mesh_motion_range.csv", "MSH-13", columns, 8)):
        row.same(columns[0], code)
        if code == 0:
            out.append(MotionRange(0, None, None, None))
            continue
        size = row.same("r_size_bits", code - 1)
        out.append(MotionRange(code, size, row.same("scale", 1 << size), row.same(columns[3], 32 << size)))
    return tuple(out)


def _choice(row: Row, column: str, allowed: tuple[str, ...]) -> None:
    if row.cells[column] not in allowed:
        broken(row, column, ", ".join(value or "empty" for value in allowed))


def _once(row: Row, column: str, seen: set[str]) -> None:
    if row.cells[column] in seen:
        broken(row, column, "values that no other row has")
    seen.add(row.cells[column])
