"""What stands inside a DCT segment: escapes, runs, every word of every table, readings, entropy profiles.

Rules: DCT-2, DCT-3, DCT-4, DCT-5, DCT-7, DCT-9, DCT-10, DCT-11, AMB-DCT-1..5, CNF-24.
"""

from __future__ import annotations

import csv
import re
import shutil
from functools import cache
from pathlib import Path

import pytest
from fba_helpers import check_input, check_partition, decoded, spans
from plain_dct import PlainPayload

import snhc.reference_impl
from snhc.reference_impl.bitstream.errors import EncodeError, SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.entropy.profile import TABLE_NAMES, EntropyProfile, load_profile
from snhc.reference_impl.face.dct_syntax import CoefficientRun
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.rules import ambiguity
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import (
    Options,
    decode_frames,
    read_stream,
    trace_stream,
    write_faulty,
    write_stream,
)
from snhc.reference_impl.tables.reading import TABLES
from snhc.vectors.builders import stream
from snhc.vectors.dct_builders import Expression, Viseme, coefficients, dct_inter, dct_intra, listed

Row = tuple[str, int, int]
PAYLOAD = re.compile(r"dc|dc_.*|run|ac|ac_.*")


def rows_of(data: bytes) -> list[Row]:
    """(name, value, width) of the coefficients' elements."""
    return [(name, value, end - start) for name, start, end, value, _ in spans(data) if PAYLOAD.fullmatch(name)]


def findings_of(data: bytes) -> list[Finding]:
    usual = ("no-sequence-header", "provisional-tables")
    return [finding for finding in decoded(data)[1] if finding.id not in usual]


def read_back(data: bytes) -> list[CoefficientRun]:
    """The runs of FAP 3 of all planes; writing back gives the same bytes."""
    items = read_stream(data)
    assert write_stream(items) == data
    check_partition(data)
    planes = items[0].fba.planes  # type: ignore[union-attr]
    return [plane.faps.segment.runs[0] for plane in planes]  # type: ignore[union-attr]


def frames_under(data: bytes, amb: str, key: str) -> list[FaceFrame]:
    return list(decode_frames(data, Options(readings=Readings({amb: key}))))


# -- escapes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [0, 32767, -32767])
def test_intra_dc_in_16_bits(value: int) -> None:
    data = write_stream(stream(dct_intra({3: coefficients(value)})))
    assert rows_of(data) == [("dc", value, 16), ("run", 15, 3)]
    assert findings_of(data) == []
    assert read_back(data)[0].dc == value


@pytest.mark.parametrize("value", [32768, -32768, -32769, 2**30 - 1, -(2**30)])
def test_intra_dc_wide(value: int) -> None:
    data = write_stream(stream(dct_intra({3: coefficients(value)}, quant=0)))
    assert rows_of(data) == [("dc", -32768, 16), ("dc_escape", value, 31), ("run", 15, 3)]
    assert findings_of(data) == []
    assert read_back(data)[0].dc == value
    # F[0] * 7.5 / 3 / 4, halves away from zero.
    wanted = (abs(value) * 5 + 4) // 8 * (1 if value > 0 else -1)
    assert decoded(data)[0][0].faps[2] == wanted


@pytest.mark.parametrize("value", [2**30, -(2**30) - 1])
def test_intra_dc_too_wide(value: int) -> None:
    with pytest.raises(EncodeError) as caught:
        write_stream(stream(dct_intra({3: coefficients(value)})))
    assert (caught.value.rule, caught.value.value) == ("DCT-2", value)


def _after(first: FbaPlane, run: CoefficientRun) -> bytes:
    return write_stream(stream(first, dct_inter(first, {3: run})))


@pytest.mark.parametrize(
    ("value", "fields"),
    [
        (255, []), (-255, []), (256, [16]), (-256, [16]), (32767, [16]), (-32767, [16]), (32768, [16, 32]),
        (-32768, [16, 32]), (2**31 - 1, [16, 32]), (-(2**31), [16, 32]),
    ],
)  # fmt: skip
def test_inter_dc(value: int, fields: list[int]) -> None:
    data = _after(dct_intra({3: coefficients(5)}), coefficients(value, is_intra=False))
    rows = rows_of(data)[2:-1]
    assert [width for name, _, width in rows if name != "dc_difference"] == fields
    assert rows[0][:2] == ("dc_difference", 0 if fields else value + 256)
    if fields:
        assert rows[-1][1] == value
        assert [row[1] for row in rows[1:-1]] == [-32768] * (len(fields) - 1)
    assert findings_of(data) == []
    assert read_back(data)[1].dc == value


@pytest.mark.parametrize(
    ("value", "fields"),
    [
        (1, []), (255, []), (-256, []), (256, [16]), (-257, [16]), (32767, [16]), (-32767, [16]), (32768, [16, 31]),
        (-32768, [16, 31]), (2**30 - 1, [16, 31]), (-(2**30), [16, 31]),
    ],
)  # fmt: skip
def test_ac(value: int, fields: list[int]) -> None:
    data = write_stream(stream(dct_intra({3: coefficients(0, {4: value})})))
    rows = rows_of(data)[2:-1]
    assert rows[0][:2] == ("ac", 256 if fields else value + 256)
    assert [width for _, _, width in rows[1:]] == fields
    if fields:
        assert rows[-1][1] == value
    assert findings_of(data) == []
    assert read_back(data)[0].levels == [value]


@pytest.mark.parametrize("fields", [1, 2])
@pytest.mark.parametrize("value", [0, 1, -256, 255])
def test_escapes_without_need_are_taken_and_reported(value: int, fields: int) -> None:
    data = write_stream(stream(dct_intra({3: coefficients(7, {2: value}, escapes={2: fields})})))
    (finding,) = findings_of(data)
    assert (finding.id, finding.rule, finding.path) == ("non-canonical", "DCT-3", "plane[0].fap.fap[3]")
    (start,) = [start for name, start, _, _, _ in spans(data) if name == "ac"]
    (end,) = [end for name, _, end, _, _ in spans(data) if name == ("ac_escape" if fields == 1 else "ac_escape_wide")]
    assert finding.bits == (start, end)
    run = read_back(data)[0]
    assert (run.levels, run.escapes) == ([value], [fields])
    # An escaped zero is a coefficient like any other.
    assert run.coefficients() == [7, 0, value] + [0] * 13


@pytest.mark.parametrize(("value", "fields"), [(3, 1), (3, 2), (-255, 1), (300, 2), (-32767, 2)])
def test_inter_dc_escaped_without_need(value: int, fields: int) -> None:
    data = _after(dct_intra({3: coefficients(0)}), coefficients(value, is_intra=False, dc_escape=fields))
    assert [finding.id for finding in findings_of(data)] == ["non-canonical"]
    run = read_back(data)[1]
    assert (run.dc, run.dc_escape) == (value, fields)


def test_intra_dc_escaped_without_need() -> None:
    data = write_stream(stream(dct_intra({3: coefficients(-7, dc_escape=1)})))
    assert [finding.id for finding in findings_of(data)] == ["non-canonical"]
    assert (read_back(data)[0].dc, read_back(data)[0].dc_escape) == (-7, 1)


# -- runs --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("before", range(15))
def test_runs_to_index_15_and_one_past_it(before: int) -> None:
    """From index `before` to 15: no end symbol follows. One more is a RangeViolation at the run's word."""
    ac = {15: -1, **({before: 2} if before else {})}
    plane = dct_intra({3: coefficients(1, ac), 4: listed([9])})
    data = write_stream(stream(plane))
    assert [value for name, value, _ in rows_of(data) if name == "run"][-2:] == [14 - before, 15]
    assert read_back(data)[0].coefficients()[15] == -1
    if not before:
        return
    mutation = Mutation("run", "value", 15 - before, "plane[0].fap.fap[3]", 1)
    error = check_input(write_faulty(stream(plane), [mutation]))
    assert error is not None
    assert (error.error_class, error.rule, error.what, error.value) == ("RangeViolation", "DCT-4", "run", 15 - before)
    assert [error.bits] == mutation.spans


def test_records_that_no_segment_holds_are_refused() -> None:
    run = coefficients(0, {15: 1})
    run.runs.append(0)
    run.levels.append(1)
    run.escapes.append(0)
    with pytest.raises(EncodeError):
        write_stream(stream(dct_intra({3: run})))
    with pytest.raises(EncodeError):
        write_stream(stream(dct_intra({3: coefficients(0, {1: 300}, escapes={1: 0})})))


# -- every word --------------------------------------------------------------------------------------------------------

WORDS = {
    "viseme_select": ("viseme_select1_difference", "viseme_select2_difference"),
    "expression_select": ("expression_select1_difference", "expression_select2_difference"),
    "intensity": ("viseme_blend_difference", "expression_intensity1_difference", "expression_intensity2_difference"),
    "runlength": ("run",),
    "dc": ("dc_difference",),
    "ac": ("ac",),
}


def _steps(largest: int) -> list[int]:
    """Values of 0..largest whose differences are every one from -largest to largest."""
    out = [0]
    for d in range(largest + 1):
        out += [d, 0]
    return out


@cache
def every_word() -> bytes:
    numbers = range(3, 69)
    levels = iter([v for v in range(-256, 256) if v] + [256])
    faps = {}
    for fap in numbers:
        if fap < 18:
            # Runs of every length, from index 0.
            faps[fap] = coefficients(0, {fap - 2: 1})
        else:
            faps[fap] = coefficients(0, {k: next(levels, 1) for k in range(1, 16)})
    instants = 128
    selects, expression, amounts = (_steps(n) + [0] * (instants + 17) for n in (14, 6, 63))
    visemes: list[Viseme] = [(selects[t], selects[t + 1], amounts[t], t & 1) for t in range(instants + 16)]
    expressions: list[Expression] = [
        (expression[t], expression[t + 1], amounts[t], amounts[t + 1], t & 1, 0) for t in range(instants + 16)
    ]
    first = dct_intra(faps, viseme=visemes[:16], expression=expressions[:16])
    planes = [first]
    differences = iter([*range(-255, 256), 256])
    for at in range(16, instants + 16, 16):
        runs = {fap: coefficients(next(differences, 0), is_intra=False) for fap in numbers}
        planes.append(dct_inter(first, runs, viseme=visemes[at : at + 16], expression=expressions[at : at + 16]))
    return write_stream(stream(*planes))


@pytest.mark.parametrize("table", TABLE_NAMES)
def test_every_symbol_of_every_table(table: str) -> None:
    data = every_word()
    read_back(data)
    seen = {value for name, _, _, value, _ in spans(data) if name in WORDS[table]}
    symbols = {word.symbol for word in getattr(load_profile(), table).words}
    assert seen == symbols


def test_traces_say_what_a_word_stands_for() -> None:
    first = dct_intra({3: coefficients(0, {1: -5})}, viseme=[(1, 2, 3, 0), (14, 0, 3, 0)])
    data = _after_viseme(first)
    words = {
        (el.name, el.meaning[value])
        for part in trace_stream(data)
        for el, _, _, value, _ in part.trace.rows()
        if value in el.meaning
    }
    assert words >= {
        ("ac", "-5"), ("ac", "escape"), ("dc_difference", "7"), ("run", "end of the segment"),
        ("viseme_select1_difference", "13"), ("viseme_select2_difference", "-2"), ("viseme_blend_difference", "0"),
    }  # fmt: skip


def _after_viseme(first: FbaPlane) -> bytes:
    second = dct_inter(first, {3: coefficients(7, {1: 300}, is_intra=False)}, viseme=[(14, 0, 3, 0)])
    return write_stream(stream(first, second))


# -- readings ----------------------------------------------------------------------------------------------------------


def test_dc_step_ratio() -> None:
    """AMB-DCT-1: at fap_quant 8 the AC step of FAP 3 is 90; a DC of 24 is 24 * 30 / 4 or 24 * 22.5 / 4."""
    data = write_stream(stream(dct_intra({3: listed([24]), 4: listed([0, 3])})))
    three, four = (frames_under(data, "AMB-DCT-1", key) for key in ("3", "4"))
    assert [frame.faps[2] for frame in three] == [180] * 16
    assert [frame.faps[2] for frame in four] == [135] * 16
    assert [frame.faps[3] for frame in three] == [frame.faps[3] for frame in four]
    assert three == decoded(data)[0]


def test_normalisation() -> None:
    """AMB-DCT-2: the DC factor is 1/4 or 1/16; AC factors sqrt(1/8) or 1/8."""
    data = write_stream(stream(dct_intra({3: listed([32]), 4: listed([0, 0, 0, 0, 0, 0, 0, 0, 16])})))
    one, other = (frames_under(data, "AMB-DCT-2", key) for key in ("orthonormal", "unnormalised"))
    assert [one[0].faps[2], other[0].faps[2]] == [240, 60]
    # cos(8 pi / 32) is sqrt(1/2): 16 * 90 / 4, and 16 * 90 / 8 * sqrt(1/2).
    assert [one[0].faps[3], other[0].faps[3]] == [360, 127]
    assert one == decoded(data)[0]


def test_intensity() -> None:
    """AMB-DCT-3: fap_scale of fap_quant 8 is 12; the predictors are what was sent."""
    first = dct_intra({3: listed([4])}, viseme=[(1, 2, 5, 1)], expression=[(3, 4, 6, 7, 1, 0)])
    data = write_stream(stream(first, dct_inter(first, viseme=[(1, 2, 6, 1)], expression=[(3, 4, 7, 7, 1, 0)])))
    one, other = (frames_under(data, "AMB-DCT-3", key) for key in ("unscaled", "scaled"))
    assert [f.viseme for f in (one[0], one[16])] == [(1, 2, 5, 1), (1, 2, 6, 1)]
    assert [f.viseme for f in (other[0], other[16])] == [(1, 2, 60, 1), (1, 2, 72, 1)]
    assert one[0].expression == (3, 6, 4, 7, 1, 0)
    assert [f.expression for f in (other[0], other[16])] == [(3, 72, 4, 84, 1, 0), (3, 84, 4, 84, 1, 0)]
    assert [f.faps for f in one] == [f.faps for f in other]


def test_end_after_index_15() -> None:
    """AMB-DCT-4: a stream of either reading decodes alike under its own, and not under the other."""
    readings = Readings({"AMB-DCT-4": "sent"})
    items = stream(dct_intra({3: coefficients(4, {15: 2}), 4: listed([1])}), dct_intra({4: listed([2, 1])}))
    without, sent = write_stream(items), write_stream(items, Writer(readings=readings))
    assert [name for name, *_ in rows_of(without)].count("run") + 1 == [
        name for name, start, end, value, path in spans(sent, Options(readings=readings))
    ].count("run")
    assert frames_under(sent, "AMB-DCT-4", "sent") == frames_under(without, "AMB-DCT-4", "none") == decoded(without)[0]
    for data, options in ((sent, Options()), (without, Options(readings=readings))):
        try:
            wrong = list(decode_frames(data, options))
        except SnhcError:
            continue
        assert wrong != decoded(without)[0]


def test_something_else_where_the_end_must_be() -> None:
    readings = Readings({"AMB-DCT-4": "sent"})
    data = write_stream(stream(dct_intra({3: coefficients(4, {15: 2}), 4: listed([1])})))
    error = check_input(data, Options(readings=readings))
    assert error is not None
    assert (error.error_class, error.rule, error.what) == ("RangeViolation", "DCT-4", "run")


def test_order_of_expression_fields() -> None:
    """AMB-DCT-5: the same record under both; the bytes differ, and are crossed when read under the other."""
    readings = Readings({"AMB-DCT-5": "fba-28"})
    items = stream(dct_intra(expression=[(1, 2, 3, 4, 0, 1)]))
    here, there = write_stream(items), write_stream(items, Writer(readings=readings))
    names = ["expression_select1", "expression_intensity1", "expression_select2", "expression_intensity2"]
    assert [name for name, *_ in spans(there, Options(readings=readings)) if name in names] == names
    assert [name for name, *_ in spans(here) if name in names] == [names[0], names[2], names[1], names[3]]
    assert frames_under(there, "AMB-DCT-5", "fba-28") == decoded(here)[0]
    assert decoded(here)[0][0].expression == (1, 3, 2, 4, 0, 1)
    error = check_input(here, Options(readings=readings))
    assert here != there
    assert error is not None or frames_under(here, "AMB-DCT-5", "fba-28") != decoded(here)[0]


@pytest.mark.parametrize(
    ("amb", "name"),
    [
        ("AMB-DCT-1", "dc_step_ratio"), ("AMB-DCT-2", "normalisation"), ("AMB-DCT-3", "dct_intensity"),
        ("AMB-DCT-4", "end_after_last"), ("AMB-DCT-5", "expression_order"),
    ],
)  # fmt: skip
def test_each_reading_is_asked_for_in_one_place(amb: str, name: str) -> None:
    assert len(ambiguity(amb).readings) == 2
    root = Path(next(iter(snhc.reference_impl.__path__)))
    asked = [file for file in root.rglob("*.py") for _ in re.finditer(rf"readings\.{name}\b", file.read_text())]
    assert len(asked) == 1


# -- entropy profiles --------------------------------------------------------------------------------------------------


@pytest.fixture
def permuted(tmp_path: Path) -> tuple[Path, EntropyProfile]:
    """P1 with the words of each table given to its symbols in the opposite order."""
    folder = tmp_path / "turned"
    folder.mkdir()
    for name in TABLE_NAMES:
        (file,) = TABLES.glob(f"fap_dct_{name}*.csv")
        shutil.copy(file, folder / file.name)
        with file.open(newline="") as lines:
            header, *rows = csv.reader(lines)
        codes = [row[3] for row in reversed(rows)]
        text = [",".join(header)]
        text += [f"{row[0]},{row[1]},{len(code)},{code}" for row, code in zip(rows, codes, strict=True)]
        (folder / file.name).write_text("\n".join(text) + "\n")
    return folder, load_profile(folder)


def test_a_profile_from_a_folder_end_to_end(permuted: tuple[Path, EntropyProfile]) -> None:
    folder, profile = permuted
    assert (profile.name, profile.provisional, profile.label) == ("turned", False, "turned")
    assert load_profile().label == "P1 (provisional entropy tables)"
    first = dct_intra({3: listed([6, -5, 0, 2]), 49: coefficients(-3, {15: 1})}, viseme=[(1, 2, 3, 0), (2, 0, 9, 1)])
    items = stream(first, dct_inter(first, {3: listed([-2, 300], is_intra=False)}, viseme=[(4, 4, 4, 0)]))
    p1, turned = write_stream(items), write_stream(items, Writer(profile=profile))
    assert p1 != turned
    options = Options(profile=profile)
    wanted = list(decode_frames(p1))
    assert list(decode_frames(turned, options)) == wanted
    check_partition(turned, options)
    assert write_stream(read_stream(turned, options), Writer(profile=profile)) == turned
    assert decoded(turned)[0] != wanted
    assert decoded(p1, options)[0] != wanted
    # Tables of someone's own are not provisional; those of P1 are, which is said once.
    assert [finding.id for finding in decoded(turned, options)[1]] == ["no-sequence-header"]
    assert [finding.id for finding in decoded(p1)[1]] == ["no-sequence-header", "provisional-tables"]
    # The plain decoder of the tests, from the same folder.
    second = PlainPayload(f"{int.from_bytes(turned, 'big'):0{8 * len(turned)}b}", folder)
    at = min(start for name, start, *_ in spans(turned, options) if name == "viseme_select1")
    visemes, _, runs = second.payload(at, [1, 3, 49], True)
    assert visemes[:2] == [[1, 2, 3, 0], [2, 0, 9, 1]]
    assert runs[3][:4] == [6, -5, 0, 2]
