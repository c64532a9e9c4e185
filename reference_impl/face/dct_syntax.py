"""The syntax of DCT segments: visemes and expressions by differences, then DC and AC of each selected FAP.

Rules: DCT-1, DCT-2, DCT-3, DCT-4, DCT-9, DCT-10, DCT-12, DCT-15.

Escapes that a reader takes although the table holds the value are kept in the record, so that writing back is exact.
"""

from __future__ import annotations

from typing import Final, final

from ..bitstream.errors import RangeViolation
from ..entropy.blocks import BlockCode
from ..entropy.profile import EntropyProfile
from ..syntax.base import SyntaxIO
from ..syntax.element import Element, Fault, Step
from .parameters import LARGEST_SELECT

SEGMENT: Final = 16
END_OF_SEGMENT: Final = 15
OFFSET: Final = 256
DC_ESCAPE: Final = 0
AC_ESCAPE: Final = 256
WIDE: Final = -32768

DC: Final = Element("dc", "DCT-2")
DC_WIDE: Final = Element("dc_escape", "DCT-2")
# What traces show of a word is its symbol: what people want to see is what it stands for.
_SIGNED: Final = {symbol: str(symbol - OFFSET) for symbol in range(2 * OFFSET)}
DC_DIFFERENCE: Final = Element("dc_difference", "DCT-3", meaning={**_SIGNED, DC_ESCAPE: "escape"})
DC_DIFFERENCE_16: Final = Element("dc_difference_escape", "DCT-3")
DC_DIFFERENCE_WIDE: Final = Element("dc_difference_escape_wide", "DCT-3")
RUN: Final = Element("run", "DCT-4", meaning={END_OF_SEGMENT: "end of the segment"})
AC: Final = Element("ac", "DCT-4", meaning={**_SIGNED, AC_ESCAPE: "escape"})
AC_16: Final = Element("ac_escape", "DCT-4")
AC_WIDE: Final = Element("ac_escape_wide", "DCT-4")
VISEME_DEF: Final = Element("viseme_def", "DCT-9")
INIT_FACE: Final = Element("init_face", "DCT-10")
EXPRESSION_DEF: Final = Element("expression_def", "DCT-10")

_RUN_PAST_END: Final = Fault(RangeViolation, "DCT-4", "run", "a run that stays within index 15")

AT_INSTANT: Final = Step("instant")
AT_FAP_NUMBER: Final = Step("fap")


@final
class _Field:
    """One field of a viseme or expression: how it is sent first, and as a difference."""

    __slots__ = ("bits", "difference", "first", "largest", "offset", "outside", "table")

    def __init__(self, name: str, rule: str, bits: int, largest: int, table: str, offset: int) -> None:
        self.first = Element(name, rule)
        meaning = {symbol: str(symbol - offset) for symbol in range(2 * offset + 1)}
        self.difference = Element(f"{name}_difference", rule, meaning=meaning)
        self.bits = bits
        self.largest = largest
        self.table = table
        self.offset = offset
        self.outside = Fault(RangeViolation, "DCT-12", name, f"0..{largest}")


_VISEME: Final = [
    _Field("viseme_select1", "DCT-9", 4, LARGEST_SELECT[1], "viseme_select", 14),
    _Field("viseme_select2", "DCT-9", 4, LARGEST_SELECT[1], "viseme_select", 14),
    _Field("viseme_blend", "DCT-9", 6, 63, "intensity", 63),
]
_EXPRESSION: Final = [
    _Field("expression_select1", "DCT-10", 4, LARGEST_SELECT[2], "expression_select", 6),
    _Field("expression_select2", "DCT-10", 4, LARGEST_SELECT[2], "expression_select", 6),
    _Field("expression_intensity1", "DCT-10", 6, 63, "intensity", 63),
    _Field("expression_intensity2", "DCT-10", 6, 63, "intensity", 63),
]
# AMB-DCT-5: the order of the fields on the wire; values are kept as select1, select2, intensity1, intensity2.
_EXPRESSION_ORDER: Final = {"segments": (0, 1, 2, 3), "fba-28": (0, 2, 1, 3)}


@final
class CoefficientRun:
    """The coefficients of one FAP in one segment, as sent.

    Rules: DCT-2, DCT-3, DCT-4.

    `dc`: the value (intra) or the difference (inter); `dc_escape`: 0 none, 1 and 2 the number of escape fields.
    `runs`, `levels`, `escapes`: per coefficient; `escapes` counts its escape fields.
    """

    __slots__ = ("dc", "dc_escape", "escapes", "levels", "runs")

    def __init__(self) -> None:
        self.dc = 0
        self.dc_escape = 0
        self.runs: list[int] = []
        self.levels: list[int] = []
        self.escapes: list[int] = []

    def coefficients(self) -> list[int]:
        """The 16 quantised integers, the DC as sent. Rules: DCT-4."""
        out = [0] * SEGMENT
        out[0] = self.dc
        k = 0
        for run, level in zip(self.runs, self.levels, strict=True):
            k += run + 1
            out[k] = level
        return out


@final
class SegmentData:
    """One DCT segment.

    Rules: DCT-1, DCT-9, DCT-10.

    `viseme`: 16 lists select1, select2, blend; `expression`: 16 lists select1, select2, intensity1, intensity2: the
    values themselves, not the differences. `viseme_def`, `init_face`, `expression_def`: 16 flags each. `runs`: one
    per selected FAP 3..68, ascending.

    What a machine has read by blocks stays as it is, 16 integers per FAP, until somebody asks for `runs`.
    """

    __slots__ = (
        "_blocks", "_runs", "_words", "expression", "expression_def", "init_face", "viseme", "viseme_def",
    )  # fmt: skip

    def __init__(self) -> None:
        self.viseme: list[list[int]] = []
        self.viseme_def: list[int] = []
        self.expression: list[list[int]] = []
        self.init_face: list[int] = []
        self.expression_def: list[int] = []
        self._runs: list[CoefficientRun] = []
        self._blocks: list[int] = []
        # Of these FAPs, counted from 0, the block does not hold what was sent.
        self._words: dict[int, CoefficientRun] = {}

    @property
    def runs(self) -> list[CoefficientRun]:
        """The coefficients as sent, per selected FAP; they may be changed. Rules: DCT-1, DCT-4."""
        if self._blocks:
            blocks, words = self._blocks, self._words
            self.runs = [
                words[i] if i in words else _run_of(blocks[SEGMENT * i : SEGMENT * (i + 1)])
                for i in range(len(blocks) // SEGMENT)
            ]
        return self._runs

    @runs.setter
    def runs(self, runs: list[CoefficientRun]) -> None:
        self._runs = runs
        self._blocks = []
        self._words = {}

    def begin_blocks(self, count: int) -> list[int]:
        """Room for the blocks of `count` FAPs, for a machine to read into. Rules: DCT-1."""
        self._blocks = [0] * (SEGMENT * count)
        return self._blocks

    def word_by_word(self, i: int) -> CoefficientRun:
        """What FAP number i, from 0, is read into word by word, beside others read by blocks. Rules: DCT-4."""
        run = CoefficientRun()
        self._words[i] = run
        return run

    def blocks(self) -> list[int]:
        """16 quantised integers per FAP, each DC as sent; not to be changed. Rules: DCT-4."""
        blocks = self._blocks
        if blocks:
            for i, run in self._words.items():
                blocks[SEGMENT * i : SEGMENT * (i + 1)] = run.coefficients()
            return blocks
        out: list[int] = []
        for run in self._runs:
            out += run.coefficients()
        return out


def _run_of(block: list[int]) -> CoefficientRun:
    """What the ordinary words of a block said: no escapes, and no coefficient of 0."""
    run = CoefficientRun()
    run.dc = block[0]
    skipped = 0
    for level in block[1:]:
        if level:
            run.runs.append(skipped)
            run.levels.append(level)
            run.escapes.append(0)
            skipped = 0
        else:
            skipped += 1
    return run


def dct_segment(
    io: SyntaxIO,
    segment: SegmentData,
    is_intra: int,
    selected: list[int],
    viseme: list[int] | None,
    expression: list[int] | None,
) -> None:
    """One segment of 16 instants.

    Rules: DCT-1, DCT-9, DCT-10, DCT-15 (by syntax alone: nothing looks for start codes inside). `selected`: the coded
    FAPs 3..68. `viseme`, `expression`: the values of the instant
    before (select1, select2, blend; select1, select2, intensity1, intensity2), None where FAP 1 or 2 is not coded.
    """
    profile = io.profile
    if viseme is not None:
        _high_level(
            io, profile, segment.viseme, viseme, _VISEME, (0, 1, 2), is_intra, [(VISEME_DEF, segment.viseme_def)]
        )
    if expression is not None:
        order = _EXPRESSION_ORDER[io.readings.expression_order]
        flags = [(INIT_FACE, segment.init_face), (EXPRESSION_DEF, segment.expression_def)]
        _high_level(io, profile, segment.expression, expression, _EXPRESSION, order, is_intra, flags)
    reading = io.reading
    by_blocks = io.by_blocks and not _end_follows(io)
    runs = segment.runs
    code = _block_code(profile, is_intra)
    blocks = segment.begin_blocks(len(selected)) if by_blocks else []
    read = 0
    for i, fap in enumerate(selected):
        if by_blocks:
            if i >= read:
                read = io.blocks(code, blocks, i)
            if i < read:
                continue
            run = segment.word_by_word(i)
        else:
            if reading:
                runs.append(CoefficientRun())
            run = runs[i]
        io.enter(AT_FAP_NUMBER, fap)
        _dc(io, profile, run, is_intra)
        _ac(io, profile, run)
        io.leave()


def _block_code(profile: EntropyProfile, is_intra: int) -> BlockCode:
    return BlockCode(
        None if is_intra else profile.dc, profile.runlength, profile.ac, offset=OFFSET, dc_escape=DC_ESCAPE,
        level_escape=AC_ESCAPE, wide=WIDE, end=END_OF_SEGMENT,
    )  # fmt: skip


def _high_level(
    io: SyntaxIO,
    profile: EntropyProfile,
    values: list[list[int]],
    previous: list[int],
    fields: list[_Field],
    order: tuple[int, ...],
    is_intra: int,
    flags: list[tuple[Element, list[int]]],
) -> None:
    reading = io.reading
    for t in range(SEGMENT):
        if reading:
            values.append([0] * len(fields))
            for _, flag in flags:
                flag.append(0)
        now = values[t]
        io.enter(AT_INSTANT, t)
        for i in order:
            field = fields[i]
            start = io.tell()
            if is_intra and t == 0:
                now[i] = io.u(field.first, field.bits, now[i])
            else:
                table = getattr(profile, field.table)
                symbol = io.vlc(field.difference, table, now[i] - previous[i] + field.offset)
                now[i] = previous[i] + symbol - field.offset
            io.require(0 <= now[i] <= field.largest, field.outside, now[i], start, io.tell())
        for element, flag in flags:
            flag[t] = io.u(element, 1, flag[t])
        io.leave()
        previous = now


def _dc(io: SyntaxIO, profile: EntropyProfile, run: CoefficientRun, is_intra: int) -> None:
    start = io.tell()
    if is_intra:
        value = io.s(DC, 16, WIDE if run.dc_escape else run.dc)
        run.dc_escape = 1 if value == WIDE else 0
        if run.dc_escape:
            value = io.s(DC_WIDE, 31, run.dc)
            _canonical(io, not -32767 <= value <= 32767, "dc", value, start)
        run.dc = value
        return
    symbol = io.vlc(DC_DIFFERENCE, profile.dc, DC_ESCAPE if run.dc_escape else run.dc + OFFSET)
    if symbol != DC_ESCAPE:
        run.dc_escape = 0
        run.dc = symbol - OFFSET
        return
    value = io.s(DC_DIFFERENCE_16, 16, WIDE if run.dc_escape == 2 else run.dc)
    run.dc_escape = 1
    held = -255 <= value <= 255
    if value == WIDE:
        run.dc_escape = 2
        value = io.s(DC_DIFFERENCE_WIDE, 32, run.dc)
        held = -32767 <= value <= 32767
    run.dc = value
    _canonical(io, not held, "dc_difference", value, start)


def _ac(io: SyntaxIO, profile: EntropyProfile, run: CoefficientRun) -> None:
    k = 0
    i = 0
    reading = io.reading
    table = profile.runlength
    while k < SEGMENT - 1:
        more = i < len(run.runs)
        step = io.vlc(RUN, table, run.runs[i] if not reading and more else END_OF_SEGMENT)
        if step == END_OF_SEGMENT:
            return
        k += step + 1
        if k >= SEGMENT:
            io.require(False, _RUN_PAST_END, step, io.tell() - table.bits_of(step), io.tell())
        if reading:
            run.runs.append(step)
            run.levels.append(0)
            run.escapes.append(0)
        elif not more:
            # Only a faulty writer comes here: the flow follows a changed run.
            return
        _coefficient(io, profile, run, i)
        i += 1
    io.require(reading or i == len(run.runs), _RUN_PAST_END, len(run.runs), io.tell(), io.tell())
    if _end_follows(io):
        start = io.tell()
        step = io.vlc(RUN, table, END_OF_SEGMENT)
        io.require(step == END_OF_SEGMENT, _RUN_PAST_END, step, start, io.tell())


def _end_follows(io: SyntaxIO) -> bool:
    """Whether an end symbol stands behind a coefficient at index 15 too (AMB-DCT-4)."""
    return io.readings.end_after_last == "sent"


def _coefficient(io: SyntaxIO, profile: EntropyProfile, run: CoefficientRun, i: int) -> None:
    escape = run.escapes[i]
    symbol = io.vlc(AC, profile.ac, AC_ESCAPE if escape else run.levels[i] + OFFSET)
    if symbol != AC_ESCAPE:
        run.escapes[i] = 0
        run.levels[i] = symbol - OFFSET
        return
    start = io.tell() - profile.ac.bits_of(AC_ESCAPE)
    value = io.s(AC_16, 16, WIDE if escape == 2 else run.levels[i])
    run.escapes[i] = 1
    held = -256 <= value <= 255
    if value == WIDE:
        run.escapes[i] = 2
        value = io.s(AC_WIDE, 31, run.levels[i])
        held = -32767 <= value <= 32767
    run.levels[i] = value
    _canonical(io, not held, "ac", value, start)


def _canonical(io: SyntaxIO, ok: bool, what: str, value: int, start: int) -> None:
    if not ok:
        io.finding("non-canonical", f"{what} {value} is escaped without need", start, io.tell())
