"""The records of the tables; their fields carry the column names of the files.

Rules: FBA-14, FBA-18, FBA-29, FBA-31, FBA-40, FAC-4, FAC-6, MSH-13, SYS-1, SYS-8.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

M_FORMULA: Final = "(63+q/2)/q"  # the formula of FBA-29 as the table file prints it


@dataclass(frozen=True, slots=True)
class Fap:
    """One facial animation parameter.

    Rules: FBA-18, FBA-31, FAC-4.

    `unit`: MNS, MW, ENS, ES, IRISD, AU or na. `direction`: B bidirectional, U unidirectional, na.
    `fdp_group`, `fdp_point`: the feature point(s) it moves, None and () where there is none. `QP`:
    quantiser step at fap_quant 1. `i_min`..`p_max`: default limits as printed, in quantised values at
    fap_quant 1, not yet rounded to 60.
    """

    number: int
    name: str
    group: int
    unit: str
    direction: str
    positive_motion: str
    fdp_group: int | None
    fdp_point: tuple[int, ...]
    QP: int
    i_min: int
    i_max: int
    p_min: int
    p_max: int


@dataclass(frozen=True, slots=True)
class FapGroup:
    """One FAP group: `count` FAPs, first_fap..last_fap.

    Rules: FBA-14.
    """

    group: int
    name: str
    count: int
    first_fap: int
    last_fap: int


@dataclass(frozen=True, slots=True)
class Bap:
    """One body animation parameter.

    Rules: FBA-40.

    `index_in_group`: place in the coding order of its group, from 0. `base_step`, `base_step_variant_b`:
    the two readings of AMB-FBA-5. Limits are None for BAPs without defaults (187..296).
    """

    number: int
    name: str
    group: int
    index_in_group: int
    unit: str
    base_step: int
    base_step_variant_b: int
    i_min: int | None
    i_max: int | None
    p_min: int | None
    p_max: int | None


@dataclass(frozen=True, slots=True)
class BapGroup:
    """One BAP group; its members in coding order, which is not always ascending.

    Rules: FBA-40.
    """

    group: int
    name: str
    count: int
    bap_numbers_in_coding_order: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class StartCode:
    """A start code or a range of them, `value`..`last` (equal for a single code), 32 bits each.

    Rules: SYS-1, FBA-1, FBA-2, FBA-4.

    `compat`: "" or "draft" (taken under `--compat draft` only).
    """

    name: str
    value: int
    last: int
    compat: str


@dataclass(frozen=True, slots=True)
class HighLevelSymbol:
    """One of the seven symbols of FAP 1 and FAP 2, in coding order.

    Rules: FBA-28, FBA-29.

    `quantised_by_fap_quant`: its step is fap_quant. A limit is a number or `(63+q/2)/q` (M), with a sign.
    """

    order: int
    name: str
    fap: int
    quantised_by_fap_quant: bool
    i_min: str
    i_max: str
    p_min: str
    p_max: str

    def intra_limits(self, m: int) -> tuple[int, int]:
        """(min, max) of the quantised value in an intra plane; `m`: M of FBA-29. Rules: FBA-29."""
        return _limit(self.i_min, m), _limit(self.i_max, m)

    def inter_limits(self, m: int) -> tuple[int, int]:
        """(min, max) of the quantised difference in an inter plane; `m`: M of FBA-29. Rules: FBA-29."""
        return _limit(self.p_min, m), _limit(self.p_max, m)


@dataclass(frozen=True, slots=True)
class Viseme:
    """One viseme: its phonemes (SAMPA-like) and an example.

    Rules: FAC-6.
    """

    viseme_select: int
    label: str
    phonemes: tuple[str, ...]
    example: str


@dataclass(frozen=True, slots=True)
class Expression:
    """One expression. Rules: FAC-6."""

    expression_select: int
    label: str


@dataclass(frozen=True, slots=True)
class ProfileLevel:
    """One value of profile_and_level_indication. Rules: SYS-8."""

    code: int
    profile: str
    level: int


@dataclass(frozen=True, slots=True)
class MotionRange:
    """What one motion_range_code means; half-pixel vectors lie in -range_R..range_R - 1.

    Rules: MSH-12, MSH-13.

    Code 0 is forbidden: the three numbers are None.
    """

    motion_range_code: int
    r_size_bits: int | None
    scale: int | None
    range_R: int | None  # noqa: N815


def _limit(cell: str, m: int) -> int:
    if cell.endswith(M_FORMULA):
        return -m if cell.startswith("-") else m
    return int(cell)
