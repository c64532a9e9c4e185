"""Mask types, masks, and the states that follow from them."""

from __future__ import annotations

from ..builders import all_lists, empty, inter, intra, stream
from ..recipe import Accept, family, vector

_GROUPS = {
    2: (3, 18),
    3: (19, 30),
    4: (31, 38),
    5: (39, 42),
    6: (43, 47),
    7: (48, 50),
    8: (51, 60),
    9: (61, 64),
    10: (65, 68),
}


@family(
    {str(group): group for group in _GROUPS},
    id="fap.mask.type-1.group-{case}",
    title="Mask type 1 in group {case}: its first and last FAP",
    tier="syntax",
    rules=["FBA-10", "FBA-14", "FBA-28"],
    features=["mask-type-1"],
    value_classes=["first-in-group", "last-in-group"],
)
def first_and_last_of_group(group: int) -> Accept:
    """The first and the last FAP of group {case} are coded, one after the other, all limits sent.

    The mask has one bit per FAP of the group, the lowest number first; the two levels differ.
    """
    first, last = _GROUPS[group]
    plane = intra({first: 11, last: -7}, ranges=all_lists(1), quant=0)
    states = {(0, first): "T", (0, last): "T", (0, first + 1): "U"}
    return Accept(
        stream(plane, inter(plane, {last: 1})), values={(0, first): 11, (0, last): -7, (1, last): -6}, states=states
    )


@family(
    {str(group): group for group in _GROUPS},
    id="fap.mask.type-3.group-{case}",
    title="Mask type 3 in group {case}",
    tier="syntax",
    rules=["FBA-10", "FBA-14"],
    features=["mask-type-3"],
)
def whole_group(group: int) -> Accept:
    """All FAPs of group {case} are coded without a mask; no other group is."""
    first, last = _GROUPS[group]
    plane = intra(
        {fap: fap - first - 4 for fap in range(first, last + 1)}, types={group: 3}, ranges=all_lists(1), quant=0
    )
    return Accept(stream(plane), values={(0, first): -4, (0, last): last - first - 4})


@vector(
    id="fap.mask.type-0.all",
    title="FAP data without any FAP",
    tier="syntax",
    rules=["FBA-14", "FBA-26", "FBA-28", "FBA-34"],
    features=["mask-type-0", "empty-segment"],
    value_classes=["zero"],
)
def nothing_selected() -> Accept:
    """Every group has mask type 0: the segment of FAPs 3..68 is there nevertheless, the two bits 01."""
    first = intra()
    return Accept(stream(first, inter(first)), lines=2, text={0: f'"state":"{"U" * 68}"', 1: f'"state":"{"U" * 68}"'})


@vector(
    id="fap.mask.type-1.empty-mask",
    title="Mask type 1 with a mask of zeros",
    tier="syntax",
    rules=["FBA-10", "FBA-14"],
    features=["mask-type-1"],
    value_classes=["zero"],
)
def empty_mask() -> Accept:
    """Group 4 has mask type 1 and eight mask bits of 0: nothing of it is coded."""
    return Accept(stream(intra({3: 9}, types={4: 1})), values={(0, 3): 36, (0, 31): None})


@vector(
    id="fap.mask.type-1.full-mask",
    title="Mask type 1 with a mask of ones",
    tier="syntax",
    rules=["FBA-10", "FBA-14"],
    features=["mask-type-1"],
    value_classes=["max"],
)
def full_mask() -> Accept:
    """Group 7 has mask type 1 and selects all its FAPs: as mask type 3, with three bits more."""
    return Accept(stream(intra({48: 1, 49: -2, 50: 3})), values={(0, 48): 170, (0, 49): -340, (0, 50): 510})


@vector(
    id="fap.mask.type-2.several-groups",
    title="Mask type 2 in several groups",
    tier="semantic",
    rules=["FBA-14", "FBA-34"],
    features=["mask-type-2", "states"],
)
def interpolated_groups() -> Accept:
    """FAPs with mask bit 0 in a group of type 2 are to be interpolated by the decoder: state I, no value.

    A left/right copy or an interpolation for other mask types is wrong.
    """
    plane = intra({3: 5, 31: 6, 51: 7}, types={2: 2, 4: 2})
    return Accept(
        stream(plane, inter(plane, {3: 1})), values={(1, 3): 24, (1, 4): None, (1, 32): None, (1, 52): None},
        states={(0, 4): "I", (0, 32): "I", (0, 52): "U", (1, 31): "T"},
    )  # fmt: skip


@vector(
    id="fap.mask.type-2.all-coded",
    title="Mask type 2 with all FAPs of the group coded",
    tier="syntax",
    rules=["FBA-14", "FBA-34"],
    features=["mask-type-2"],
    value_classes=["max"],
)
def interpolated_none() -> Accept:
    """Nothing is left to interpolate: all three FAPs of group 7 are T."""
    return Accept(stream(intra({48: 1, 49: 2, 50: 3}, types={7: 2})), states={(0, 48): "T", (0, 50): "T"})


@family(
    {"1": 1, "2": 2, "3": 3},
    id="fap.mask.group-1.type-{case}",
    title="Group 1 with mask type {case}",
    tier="syntax",
    rules=["FBA-10", "FBA-14", "FBA-28", "FBA-34"],
    features=["viseme", "expression"],
)
def group_one(mask_type: int) -> Accept:
    """FAP 1 and 2 are masked as all others, here with mask type {case}; types 1 and 2 code the viseme alone."""
    expression = (2, 30, 3, 40, 0, 0) if mask_type == 3 else None
    plane = intra({3: 4}, viseme=(1, 2, 30, 0), expression=expression, types={1: mask_type})
    return Accept(stream(plane), states={(0, 1): "T", (0, 2): {1: "U", 2: "I", 3: "T"}[mask_type]})


@vector(
    id="fap.mask.group-1.expression-alone",
    title="The expression without the viseme",
    tier="syntax",
    rules=["FBA-10", "FBA-28"],
    features=["expression"],
)
def expression_alone() -> Accept:
    """The mask 01 of group 1 selects FAP 2: its segment and its two flags, and no viseme_def."""
    return Accept(stream(intra({3: 4}, expression=(2, 30, 3, 40, 1, 1))), states={(0, 1): "U", (0, 2): "T"})


@vector(
    id="fap.mask.persistence",
    title="Masks stay in force for inter planes",
    tier="semantic",
    rules=["FBA-15", "FBA-30", "FBA-34"],
    features=["inter", "states"],
)
def masks_persist() -> Accept:
    """Inter planes code the FAPs that the last intra plane selected; another intra plane selects others."""
    first = intra({3: 5, 61: 2})
    second = intra({4: 6, 61: -2})
    planes = [first, inter(first, {3: 1, 61: 1}), second, inter(second, {4: 1, 61: -1})]
    return Accept(
        stream(*planes), values={(1, 3): 24, (1, 61): 3, (2, 3): 24, (3, 3): 24, (3, 4): 14, (3, 61): -3},
        states={(1, 3): "T", (2, 3): "R", (1, 4): "U", (3, 4): "T"},
    )  # fmt: skip


@vector(
    id="fap.mask.states.plane-without-data",
    title="States on planes without FAP data",
    tier="semantic",
    rules=["FBA-34"],
    features=["states", "plane-without-data"],
)
def states_without_data() -> Accept:
    """Without FAP data T becomes R and the others stay: I stays I, U stays U; then T again."""
    first = intra({3: 5, 31: 1}, types={4: 2})
    planes = [empty(), first, empty(), inter(first, {3: 1})]
    return Accept(
        stream(*planes),
        states={
            (0, 3): "U", (1, 3): "T", (1, 32): "I", (2, 3): "R", (2, 32): "I", (2, 4): "U", (3, 3): "T", (3, 32): "I",
        },
        values={(0, 3): None, (2, 3): 20, (3, 3): 24},
    )  # fmt: skip


@vector(
    id="fap.mask.states.type-0-retains",
    title="A group of mask type 0 keeps its values",
    tier="semantic",
    rules=["FBA-14", "FBA-34"],
    features=["states", "mask-type-0"],
)
def type_0_retains() -> Accept:
    """The second intra plane codes nothing of group 2: its FAPs keep their values in state R."""
    return Accept(stream(intra({3: 5, 4: 6}), intra({61: 7})), values={(1, 3): 20, (1, 4): 12}, states={(1, 3): "R"})
