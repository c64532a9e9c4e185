"""Whole face streams as records, made from the rules of the specification alone.

The limits that levels must keep (FBA-16..20, 29, 40) are worked out here a second time, from the tables' files, and
not asked of the codec. What decides the shape of a stream is drawn; masses of small numbers come from a seed that is
drawn too.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any, Final

from hypothesis import strategies as st

import snhc.reference_impl.tables as shipped
from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.face.records import FbaObject, FbaPlane, ParameterData
from snhc.reference_impl.syntax.base import BARE_CODE, END, PLANE, STUFFED_CODE, STUFFED_END, ZERO_PADDING
from snhc.reference_impl.syntax.temporal import TemporalHeader
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import Options, write_stream
from snhc.reference_impl.systems.visual import StreamItem, VisualObjectHeader

Draw = Any  # hypothesis' draw function: what it gives has the type of the strategy
TABLES: Final = Path(shipped.__file__).parent
STYLES: Final = ("zero", "small", "high", "low", "uniform", "mixed", "edges")


def _rows(name: str) -> list[dict[str, str]]:
    with (TABLES / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def _outward(limit: int) -> int:
    v = (abs(limit) + 59) // 60 * 60
    return v if limit > 0 else -v


def _defaults(rows: Iterable[dict[str, str]]) -> dict[int, list[int]]:
    """number -> [i_max, i_min, p_max, p_min] at quantiser 1 (FBA-18)."""
    names = ("i_max", "i_min", "p_max", "p_min")
    return {int(r["number"]): [_outward(int(r[n])) for n in names] for r in rows if all(r[n] for n in names)}


FAP_GROUPS: Final = [list(range(int(r["first_fap"]), int(r["last_fap"]) + 1)) for r in _rows("fap_groups")]
BAP_GROUPS: Final = [[int(n) for n in r["bap_numbers_in_coding_order"].split()] for r in _rows("bap_groups")]
FAP_DEFAULTS: Final = _defaults(_rows("fap_table"))
FAP_STEPS: Final = {int(r["number"]): int(r["QP"]) for r in _rows("fap_table")}
BAP_DEFAULTS: Final = _defaults(_rows("bap_table"))
BAP_SCALE: Final = [int(r["scale"]) for r in _rows("bap_quant_scale")]


def _divided(limit: int, divisor: int) -> int:
    return int(abs(limit) // max(divisor, 1)) * (1 if limit >= 0 else -1)  # truncates toward zero (FBA-17)


def level_in(rng: Random, style: str, lo: int, hi: int) -> int:
    """A level of [lo, hi] in the given style."""
    if style == "mixed":
        style = rng.choice(STYLES[:5])
    if style == "high":
        return hi
    if style == "low":
        return lo
    if style == "edges":
        return rng.choice((lo, hi, max(lo, hi - 1), min(hi, lo + 1)))
    if style == "small":
        return min(hi, max(lo, rng.randint(-3, 3)))
    if style == "uniform":
        return rng.randint(lo, hi)
    return min(hi, max(lo, 0))


@dataclass
class _Kind:
    """What is in force for the FAPs or the BAPs (FBA-15, FBA-19)."""

    groups: list[list[int]]
    range_groups: list[list[int]]
    defaults: dict[int, list[int]]
    mask_types: tuple[int, ...]
    has_intra: bool = False
    divisor: int = 1
    selected: list[int] = field(default_factory=list)
    limits: dict[int, list[int]] = field(default_factory=dict)

    def intra(self, rng: Random, data: ParameterData, density: float, quant: int, divisor: int, lists: int) -> None:
        """Masks, quantiser and range lists of an intra plane; `lists`: the four flags as bits."""
        data.quant = quant
        self.divisor = divisor
        self.selected = []
        for g, group in enumerate(self.groups):
            if rng.random() >= density:
                continue
            kind = rng.choice(self.mask_types)
            data.mask_type[g] = kind
            if kind in (1, 2):
                data.group_mask[g] = rng.getrandbits(len(group))
                bits = f"{data.group_mask[g]:0{len(group)}b}"
                self.selected += [number for number, bit in zip(group, bits, strict=True) if bit == "1"]
            elif kind == 3:
                self.selected += group
        if any(number > 2 and number not in self.defaults for number in self.selected):
            lists = 15
        data.gender = rng.getrandbits(1)
        data.new = [(lists >> which) & 1 for which in range(4)]
        # A reader leaves the lists out where none was sent.
        data.limits = [[0] * (max(map(max, self.groups)) + 1) for _ in range(4)] if lists else []
        for group in self.range_groups:
            for number in group:
                if number not in self.selected:
                    continue
                limit = self.limits.setdefault(number, list(self.defaults.get(number, [0] * 4)))
                for which in range(4):
                    if data.new[which]:
                        v = rng.choice((0, 1, 31, rng.randint(0, 31)))
                        data.limits[which][number] = v
                        limit[which] = 60 * v if which in (0, 2) else -60 * v
        self.has_intra = True

    def levels(self, rng: Random, style: str, intra: bool) -> list[int]:
        top, bottom = (0, 1) if intra else (2, 3)
        return [
            level_in(rng, style, _divided(self.limits[n][bottom], self.divisor),
                     _divided(self.limits[n][top], self.divisor))
            for n in self.selected
            if n in self.limits
        ]  # fmt: skip


class Planes:
    """Makes the planes of one object, in order; holds what is in force."""

    def __init__(self, rng: Random, plane_code: int = 0x1BB) -> None:
        self.rng = rng
        self.plane_code = plane_code
        self.faps = _Kind(FAP_GROUPS, FAP_GROUPS[1:], FAP_DEFAULTS, (0, 1, 2, 3))
        self.baps = _Kind(BAP_GROUPS, BAP_GROUPS, BAP_DEFAULTS, (0, 1, 3))
        self.selects = {1: [0, 0], 2: [0, 0]}

    def plane(
        self, *, intra: bool, mask: int, boundary: int = PLANE, quant: int = 1, density: float = 0.3, lists: int = 0,
        style: str = "small",
    ) -> FbaPlane:  # fmt: skip
        rng = self.rng
        plane = FbaPlane()
        plane.boundary = boundary
        plane.start_code = self.plane_code if boundary in (STUFFED_CODE, BARE_CODE) else 0
        plane.is_intra = int(intra)
        plane.fba_object_mask = mask
        if mask & 1:
            plane.faps = ParameterData(10)
            if intra:
                self.faps.intra(rng, plane.faps, density, quant, quant, lists)
            self._high_level(plane.faps, style, intra)
            plane.faps.levels = self.faps.levels(rng, style, intra)
        if mask & 2:
            plane.baps = ParameterData(24)
            if intra:
                self.baps.intra(rng, plane.baps, density / 2, quant, BAP_SCALE[quant], lists)
            plane.baps.levels = self.baps.levels(rng, style, intra)
        return plane

    def _high_level(self, data: ParameterData, style: str, intra: bool) -> None:
        q = self.faps.divisor
        m = (63 + q // 2) // q if q else 63
        for fap, largest in ((1, 14), (2, 6)):
            if fap not in self.faps.selected:
                continue
            before = self.selects[fap]
            selects = [level_in(self.rng, style, 0 if intra else -b, largest if intra else largest - b) for b in before]
            self.selects[fap] = selects if intra else [b + s for b, s in zip(before, selects, strict=True)]
            amounts = [level_in(self.rng, style, 0 if intra else -m, m) for _ in range(fap)]
            if fap == 1:
                data.viseme = [*selects, *amounts]
                data.viseme_def = self.rng.getrandbits(1)
            else:
                data.expression = [selects[0], amounts[0], selects[1], amounts[1]]
                data.init_face = self.rng.getrandbits(1)
                data.expression_def = self.rng.getrandbits(1)


@dataclass
class Stream:
    """A generated stream: the records as made, the bytes that the writer made of them, and how to read them."""

    items: list[StreamItem]
    data: bytes
    options: Options

    def __repr__(self) -> str:
        return f"Stream({self.data.hex()}, draft={self.options.draft})"


def header(draw: Draw, intra: bool) -> TemporalHeader:
    """A temporal header with any branch taken (FBA-6..8)."""
    h = TemporalHeader()
    if intra and draw(st.booleans()):
        h.is_frame_rate = 1
        h.frame_rate = draw(st.integers(0, 255))
        h.seconds = draw(st.integers(0, 15).filter(lambda s: bool(s or h.frame_rate)))
        h.frequency_offset = draw(st.integers(0, 1))
    if intra and draw(st.booleans()):
        h.is_time_code = 1
        h.time_code_hours = draw(st.integers(0, 23))
        h.time_code_minutes = draw(st.integers(0, 59))
        h.time_code_seconds = draw(st.integers(0, 59))
    if draw(st.booleans()):
        h.skip_frames = 1
        h.number_of_frames_to_skip = draw(st.sampled_from((0, 1, 14, 15, 16, 29, 30, 31, 45)) | st.integers(0, 200))
    return h


@st.composite
def fba_objects(draw: Draw, draft: bool = False, max_planes: int = 6) -> FbaObject:
    """An object with planes of all kinds, ended by whatever follows."""
    obj = FbaObject()
    obj.start_code = 0x101 if draft and draw(st.booleans()) else 0x1BA
    make = Planes(Random(draw(st.integers(0, 2**32 - 1))), 0x103 if draft else 0x1BB)
    # Lone planes, and runs of planes without data that would emulate a start code (FBA-41).
    for index in range(draw(st.integers(0, max_planes))):
        if draw(st.integers(0, 9)) == 0:
            for _ in range(draw(st.integers(1, 40))):
                obj.planes.append(make.plane(intra=False, mask=0))
            continue
        mask = draw(st.integers(0, 3))
        ready = (not mask & 1 or make.faps.has_intra) and (not mask & 2 or make.baps.has_intra)
        intra = draw(st.integers(0, 3)) == 0 if ready else True
        kinds = (PLANE, STUFFED_CODE, BARE_CODE) if index == 0 and not obj.planes else (PLANE, PLANE, STUFFED_CODE)
        plane = make.plane(
            intra=intra,
            mask=mask,
            boundary=draw(st.sampled_from(kinds)),
            quant=draw(st.sampled_from((0, 1, 2, 31)) | st.integers(0, 31)),
            density=draw(st.sampled_from((0.0, 0.15, 0.5, 1.0))),
            lists=draw(st.sampled_from((0, 15)) | st.integers(0, 15)),
            style=draw(st.sampled_from(STYLES)),
        )
        plane.header = header(draw, intra)
        obj.planes.append(plane)
    return obj


def user_data(draw: Draw) -> list[StreamItem]:
    """Some `user_data`, whose bytes may hold anything but a start code prefix (SYS-5)."""
    items = []
    for _ in range(draw(st.integers(0, 2))):
        item = StreamItem(0x1B2)
        item.user_data = draw(st.binary(max_size=12).filter(_without_prefix))
        items.append(item)
    return items


def _without_prefix(data: bytes) -> bool:
    # The bytes that follow begin with 00 00 01: the prefix may not begin earlier by a zero at the end.
    return (data + b"\0\0\1").find(b"\0\0\1") == len(data)


@st.composite
def streams(draw: Draw, max_planes: int = 6, draft: bool | None = None) -> Stream:
    """A whole stream: headers, user data, one or two objects, and an end of any kind."""
    is_draft = draft if draft is not None else draw(st.integers(0, 7)) == 0
    items: list[StreamItem] = []
    count = draw(st.sampled_from((1, 1, 1, 2)))
    for number in range(count):
        in_sequence = draw(st.booleans())
        if in_sequence:
            item = StreamItem(0x1B0)
            item.profile = draw(st.sampled_from((0x61, 0x62, 0x63, 0x64, 0xFE)) | st.integers(0, 255))
            items += [item, *user_data(draw)]
        if in_sequence or draw(st.booleans()):
            item = StreamItem(0x1B5)
            item.header = VisualObjectHeader()
            item.header.type = 4
            if draw(st.booleans()):
                item.header.identifier = 1
                item.header.verid = draw(st.integers(0, 15))
                item.header.priority = draw(st.integers(1, 7))
            items += [item, *user_data(draw)]
        obj = draw(fba_objects(is_draft, max_planes))
        item = StreamItem(obj.start_code)
        item.fba = obj
        items.append(item)
        if number + 1 < count and draw(st.booleans()):
            items.append(StreamItem(0x1B1))
    return finished(items, draw(st.sampled_from(("code", "trailing", "stuffed", "bare", "zeros"))), draw, is_draft)


def finished(items: list[StreamItem], end: str, draw: Draw, draft: bool = False) -> Stream:
    """The stream with the wanted end, or an end code where its last bits forbid that end (FBA-3, FBA-42)."""
    obj = items[-1].fba
    assert obj is not None
    options = Options(draft=draft)
    if end in ("stuffed", "bare", "zeros"):
        obj.end = {"stuffed": STUFFED_END, "bare": END, "zeros": ZERO_PADDING}[end]
        try:
            if end == "zeros":
                obj.end = STUFFED_END
                written(items, draft)
                last = bit_after_planes(items, draft)
                obj.end = ZERO_PADDING
                # At least 8 bits: a single zero bit before the end of the data is stuffing.
                obj.padding = 8 - (last & 7) + 8 * int(draw(st.integers(1, 20)))
            return Stream(items, written(items, draft), options)
        except EncodeError as error:
            assert error.rule in ("FBA-3", "FBA-42")
    obj.end = STUFFED_CODE
    obj.padding = 0
    items.append(StreamItem(0x1B1))
    if end == "trailing":
        item = StreamItem(0)
        item.trailing = draw(st.sampled_from((b"\0\0\1\xc0xyz", b"\0", b"\0\0\1")) | st.binary(min_size=1, max_size=20))
        if item.trailing[:3] != b"\0\0\1" or item.trailing[3:4] in (b"", b"\xc0"):
            items.append(item)
    return Stream(items, written(items, draft), options)


def bit_after_planes(items: list[StreamItem], draft: bool) -> int:
    """Where the planes of the last object, which ends with STUFFED_END, end."""
    data = written(items, draft)
    bits = int.from_bytes(data, "big")
    # The stuffing is a 0 bit and then 1 bits.
    ones = 0
    while (bits >> ones) & 1:
        ones += 1
    return 8 * len(data) - ones - 1


def written(items: list[StreamItem], draft: bool) -> bytes:
    writer = Writer()
    writer.draft = draft
    return write_stream(items, writer)
