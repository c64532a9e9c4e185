"""FAPs and BAPs as the syntax sees them: groups, default limits, steps.

Rules: FBA-14, FBA-16, FBA-18, FBA-29, FBA-31, FBA-40. The numbers are in tables/.
"""

from __future__ import annotations

from functools import cache
from typing import Final, final

from ..bitstream.errors import ForbiddenValue
from ..syntax.element import Element, marker
from ..tables import (
    bap_groups,
    bap_quant_scale,
    bap_table,
    fap_groups,
    fap_table,
    viseme_expression_symbols,
)

# The four range lists in the order of the wire (FBA-16).
I_MAX: Final = 0
I_MIN: Final = 1
P_MAX: Final = 2
P_MIN: Final = 3
LIST_NAMES: Final = ("i_max", "i_min", "p_max", "p_min")
SIGNS: Final = (1, -1, 1, -1)
LIMIT_UNIT: Final = 60
LARGEST_V: Final = 31

VISEME_LABELS: Final = ["viseme_select1", "viseme_select2", "viseme_blend"]
EXPRESSION_LABELS: Final = [
    "expression_select1", "expression_intensity1", "expression_select2", "expression_intensity2",
]  # fmt: skip
LARGEST_SELECT: Final = {1: 14, 2: 6}


def outward(limit: int) -> int:
    """A limit rounded outward to a multiple of 60. Rules: FBA-18."""
    v = -(-abs(limit) // LIMIT_UNIT)
    return v * LIMIT_UNIT if limit > 0 else -v * LIMIT_UNIT


@final
class ParameterSet:
    """All FAPs 3..68 or all BAPs: what the syntax functions need to know of them.

    Rules: FBA-14, FBA-16, FBA-18, FBA-31, FBA-40.

    `count`: highest number. `groups`: the numbers of each group in coding order. `range_groups`: the groups that
    the range lists walk (FAPs: without group 1). `defaults`: per list (I_MAX .. P_MIN) the default limit by number,
    0 where there is none. `has_defaults`, `base_steps`, `labels`: by number. `disputed`: numbers whose default limits
    decoders disagree about (AMB-FBA-2).
    """

    __slots__ = (
        "base_steps", "count", "defaults", "disputed", "group_marker", "group_mask", "groups", "has_defaults", "labels",
        "limit_elements", "limit_marker", "mask_type", "new_flags", "quant", "quant_scale", "range_groups",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        rules: tuple[str, str, str, str],
        groups: list[list[int]],
        range_groups: list[list[int]],
        forbidden_mask_types: tuple[int, ...],
        quant_scale: list[int],
    ) -> None:
        quant_rule, mask_rule, flag_rule, range_rule = rules
        self.groups = groups
        self.range_groups = range_groups
        self.count = max(max(group) for group in groups)
        self.quant_scale = quant_scale
        self.disputed: frozenset[int] = frozenset()
        size = self.count + 1
        self.defaults: list[list[int]] = [[0] * size for _ in LIST_NAMES]
        self.has_defaults = [False] * size
        self.base_steps = [1] * size
        self.labels = [""] * size
        self.quant = Element(f"{name}_quant", quant_rule)
        self.group_marker = marker(mask_rule)
        self.mask_type = Element(
            f"{name}_mask_type",
            mask_rule,
            lo=0,
            hi=3,
            forbidden=forbidden_mask_types,
            fault=ForbiddenValue,
            meaning={
                0: "none coded",
                1: "mask; the others keep their value",
                2: "mask; the others are interpolated",
                3: "all coded",
            },
        )
        self.group_mask = Element(f"{name}_group_mask", mask_rule)
        self.new_flags = [Element(f"is_{list_name[0]}_new_{list_name[2:]}", flag_rule) for list_name in LIST_NAMES]
        self.limit_marker = marker(range_rule)
        self.limit_elements = [Element(f"{name}_new_{list_name}", range_rule) for list_name in LIST_NAMES]

    def set_defaults(self, number: int, i_min: int, i_max: int, p_min: int, p_max: int) -> None:
        """Default limits of one parameter, rounded outward. Rules: FBA-18, FBA-40."""
        for which, limit in enumerate((i_max, i_min, p_max, p_min)):
            self.defaults[which][number] = outward(limit)
        self.has_defaults[number] = True


def fap_set(range_47: str = "table") -> ParameterSet:
    """FAPs 3..68; `range_47` is the reading of AMB-FBA-2. Rules: FBA-14, FBA-16, FBA-18, FBA-31."""
    return _fap_set(range_47)


@cache
def _fap_set(range_47: str) -> ParameterSet:
    groups = [list(range(g.first_fap, g.last_fap + 1)) for g in fap_groups()]
    faps = ParameterSet("fap", ("FBA-9", "FBA-10", "FBA-13", "FBA-16"), groups, groups[1:], (), list(range(32)))
    for fap in fap_table():
        faps.base_steps[fap.number] = fap.QP
        faps.labels[fap.number] = f"FAP {fap.number} {fap.name}"
        if fap.number > 2:
            faps.set_defaults(fap.number, fap.i_min, fap.i_max, fap.p_min, fap.p_max)
    faps.disputed = frozenset({47})
    if range_47 == "wide":
        faps.set_defaults(47, -1080, 1080, -420, 420)
    return faps


def bap_set(base_step: str = "base_step") -> ParameterSet:
    """BAPs 1..296; `base_step` is the reading of AMB-FBA-5. Rules: FBA-40."""
    return _bap_set(base_step)


@cache
def _bap_set(base_step: str) -> ParameterSet:
    groups = [list(g.bap_numbers_in_coding_order) for g in bap_groups()]
    rules = ("FBA-40", "FBA-40", "FBA-40", "FBA-40")
    baps = ParameterSet("bap", rules, groups, groups, (2,), list(bap_quant_scale()))
    for bap in bap_table():
        baps.base_steps[bap.number] = bap.base_step if base_step == "base_step" else bap.base_step_variant_b
        baps.labels[bap.number] = f"BAP {bap.number} {bap.name}"
        if bap.i_min is not None and bap.i_max is not None and bap.p_min is not None and bap.p_max is not None:
            baps.set_defaults(bap.number, bap.i_min, bap.i_max, bap.p_min, bap.p_max)
    return baps


@cache
def high_level_limits(fap_quant: int) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]:
    """(min, max) of the seven symbols of FAP 1 and 2: (intra, inter). Rules: FBA-29."""
    m = (63 + fap_quant // 2) // fap_quant if fap_quant else 63
    symbols = viseme_expression_symbols()
    return tuple(s.intra_limits(m) for s in symbols), tuple(s.inter_limits(m) for s in symbols)


@cache
def high_level_quantised() -> tuple[bool, ...]:
    """Which of the seven symbols have the step fap_quant; the selects have step 1. Rules: FBA-29, FBA-31."""
    return tuple(s.quantised_by_fap_quant for s in viseme_expression_symbols())
