"""Every parameter at both ends of its range, and every group's masks: slips in a row of a table show here.

FAP 47 is left out where default ranges are used (AMB-FBA-2). BAPs are coded with bap_quant 0, which makes base steps
not matter (AMB-FBA-5).
"""

from __future__ import annotations

from collections.abc import Mapping

from snhc.reference_impl.bitstream.errors import ForbiddenValue, MarkerBit
from snhc.reference_impl.face.parameters import I_MAX, I_MIN, P_MAX, P_MIN, ParameterSet, bap_set, fap_set
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.faulty import Mutation

from ..builders import all_lists, body, inter, intra, stream
from ..manifest import CONCEAL, REJECT
from ..recipe import Accept, Reject, family, vector

_DISPUTED = 47
_FAPS = tuple(number for number in range(3, 69) if number != _DISPUTED)
_ENDS = {"highest then lowest": (I_MAX, P_MIN), "lowest then highest": (I_MIN, P_MAX)}


def _defaults(parameters: ParameterSet, which: int) -> dict[int, int]:
    limits = parameters.defaults[which]
    return {n: limits[n] for n in range(1, parameters.count + 1) if parameters.has_defaults[n] and n != _DISPUTED}


def _faces(first: int, second: int) -> list[FbaPlane]:
    plane = intra(_defaults(fap_set(), first))
    return [plane, inter(plane, _defaults(fap_set(), second))]


@family(
    _ENDS,
    id="fap.arith.default-ranges.{case}",
    title="All FAPs at the ends of their default ranges, {case}",
    tier="stress",
    rules=["FBA-18", "FBA-28", "FBA-31"],
    features=["default-ranges", "inter", "guard"],
    value_classes=["max", "min"],
)
def faps_at_ends(case: tuple[int, int]) -> Accept:
    """FAPs 3..68 but 47: every level at one end of its intra range, then at the other end of its inter range.

    One wrong limit in a decoder's table makes another number of symbols, and nothing fits from there on.
    """
    signs = {I_MAX: 1, I_MIN: -1}
    sign = signs[case[0]]
    # FAP 48 has the limits -1860..1860 (intra), -600..600 (inter) and the step 170; FAP 3 -1080..1080, the step 4.
    values: Mapping[tuple[int, int], int] = {
        (0, 48): sign * 1860 * 170, (1, 48): sign * (1860 - 600) * 170, (0, 3): sign * 1080 * 4,
    }  # fmt: skip
    return Accept(stream(*_faces(*case)), lines=2, values=values)


@family(
    {"highest": (1, -1), "lowest": (-1, 1)},
    id="fap.arith.range.all-faps.{case}",
    title="All FAPs at the {case} levels of ranges of their own",
    tier="stress",
    rules=["FBA-16", "FBA-17", "FBA-28"],
    features=["ranges", "inter"],
    value_classes=["max", "min"],
)
def faps_in_own_ranges(signs: tuple[int, int]) -> Accept:
    """All four lists are sent, with another limit for every FAP: 60 (n mod 31 + 1). FAP 47 too: no default counts."""
    limits = {number: number % 31 + 1 for number in range(3, 69)}
    first = intra({n: signs[0] * 60 * v for n, v in limits.items()}, ranges=dict.fromkeys(all_lists(1), limits))
    second = inter(first, {n: signs[1] * 60 * v for n, v in limits.items()})
    # 48 mod 31 + 1 = 18; intra and inter levels take each other away.
    return Accept(stream(first, second), values={(0, 48): signs[0] * 18 * 60 * 170, (1, 48): 0, (1, 47): 0})


@family(
    {
        "none": {},
        "first": dict.fromkeys((3, 19, 31, 39, 43, 48, 51, 61, 65), 1),
        "last": dict.fromkeys((18, 30, 38, 42, 47, 50, 60, 64, 68), 1),
    },
    id="fap.mask.in-every-group.{case}",
    title="Mask type 1 in every group, mask: {case}",
    tier="syntax",
    rules=["FBA-10", "FBA-14"],
    features=["mask-type-1"],
    value_classes=["min"],
)
def one_of_every_group(faps: Mapping[int, int]) -> Accept:
    """Every group has mask type 1 and selects one FAP or nothing ({case}); ranges are sent.

    A mask of zeros is legal: the group is announced and holds nothing.
    """
    types = dict.fromkeys(range(1, 11), 1)
    first = intra(faps, types=types, ranges=all_lists(2))
    states = {(0, fap): "T" if fap in faps else "U" for fap in range(3, 69)}
    return Accept(stream(first, inter(first, faps)), states=states)


@vector(
    id="fap.mask.type-2.in-every-group",
    title="Mask type 2 in every group",
    tier="semantic",
    rules=["FBA-10", "FBA-14", "FBA-33"],
    features=["mask-type-2", "states"],
)
def interpolated_in_every_group() -> Accept:
    """Every group selects its first FAP and leaves the others to be interpolated: state I, without a value."""
    faps = dict.fromkeys((3, 19, 31, 39, 43, 48, 51, 61, 65), 1)
    first = intra(faps, types=dict.fromkeys(range(1, 11), 2))
    states = {(0, fap): "T" if fap in faps else "I" for fap in range(3, 69)}
    return Accept(stream(first, inter(first, faps)), states=states)


# -- bodies ------------------------------------------------------------------------------------------------------------


@family(
    _ENDS,
    id="fba.body.default-ranges.{case}",
    title="All BAPs at the ends of their default ranges, {case}",
    tier="stress",
    rules=["FBA-40"],
    features=["bap", "default-ranges", "guard"],
    value_classes=["max", "min"],
)
def baps_at_ends(case: tuple[int, int]) -> Accept:
    """The BAPs that have default limits, every level at one end of its intra range, then at the other of its inter one.

    Parameters in coding order, which is not the order of numbers.
    """
    first = body(_defaults(bap_set(), case[0]), quant=0)
    second = inter(first, baps=_defaults(bap_set(), case[1]))
    return Accept(stream(first, second), lines=2)


@family(
    {"highest": (1, -1), "lowest": (-1, 1)},
    id="fba.body.all-parameters.{case}",
    title="All 296 BAPs at the {case} levels of ranges of their own",
    tier="stress",
    rules=["FBA-16", "FBA-40"],
    features=["bap", "ranges", "mask-type-3", "guard"],
    value_classes=["max", "min"],
)
def all_baps(signs: tuple[int, int]) -> Accept:
    """Mask type 3 in all 24 groups; all four lists, with another limit for every BAP: 60 (n mod 31 + 1)."""
    limits = {number: number % 31 + 1 for number in range(1, 297)}
    types = dict.fromkeys(range(1, 25), 3)
    levels = {n: signs[0] * 60 * v for n, v in limits.items()}
    first = body(levels, quant=0, types=types, ranges=dict.fromkeys(all_lists(1), limits))
    second = inter(first, baps={n: signs[1] * 60 * v for n, v in limits.items()})
    # 296 mod 31 + 1 = 18.
    return Accept(stream(first, second), text={0: f'"296":{signs[0] * 1080}', 1: '"296":0'})


def _of_each_group(place: int) -> dict[int, int]:
    return {group[place]: 1 for group in bap_set().groups}


@family(
    {
        "none": {},
        "first": _of_each_group(0),
        "last": _of_each_group(-1),
        "all": dict.fromkeys(range(1, 297), 1),
    },
    id="fba.body.mask.in-every-group.{case}",
    title="Mask type 1 in every group of the body, mask: {case}",
    tier="syntax",
    rules=["FBA-40"],
    features=["bap", "mask-type-1"],
    value_classes=["max", "min"],
)
def body_masks(baps: Mapping[int, int]) -> Accept:
    """Every group has mask type 1; its mask selects: {case}. The lists are walked in the order of the groups."""
    first = body(baps, quant=0, types=dict.fromkeys(range(1, 25), 1), ranges=all_lists(1))
    return Accept(stream(first, inter(first, baps=baps)), lines=2)


@vector(
    id="fba.body.range.zero",
    title="BAPs with ranges of one value",
    tier="semantic",
    rules=["FBA-16", "FBA-22", "FBA-40"],
    features=["bap", "ranges"],
    value_classes=["zero"],
)
def ranges_of_nothing() -> Accept:
    """The limits of BAP 8 are 0: it has a model of one symbol, which costs no bits. BAP 9 has the limits 60."""
    limits = {8: 0, 9: 1}
    first = body({8: 0, 9: 60}, quant=0, ranges=dict.fromkeys(all_lists(1), limits))
    return Accept(stream(first, inter(first, baps={8: 0, 9: -60})), text={0: '"baps":{"8":0,"9":60}'})


@family(
    {str(group): group for group in range(1, 25) if group != 5},
    id="fba.error.body.mask-type-2.group-{case}",
    title="Body mask type 2 in group {case}",
    tier="error",
    rules=["FBA-40"],
    features=["bap", "mask-type-2"],
)
def body_mask_type(group: int) -> Reject:
    """Mask type 2 does not exist for bodies, here in group {case}."""
    path = f"plane[0].bap.group[{group}]"
    items = stream(body({1: 1}))
    return Reject(items, ForbiddenValue, "FBA-40", (Mutation("bap_mask_type", "wire", 2, path),))


@family(
    {"intra": 0, "inter": 1},
    id="fba.error.body.guard-zero.{case}",
    title="A guard of value 0 in the BAP data of an {case} plane",
    tier="error",
    rules=["FBA-25", "FBA-40"],
    features=["bap", "guard"],
)
def body_guard(plane: int) -> Reject:
    """Eight BAPs at the highest level make runs of 22 zeros; the guards behind them are 0. They carry no data."""
    faps = dict.fromkeys(range(8, 16), 1860)
    first = body(faps, quant=0, ranges=all_lists(31))
    items = stream(first, inter(first, baps=faps))
    mutation = Mutation("bap_segment", "guard", path=f"plane[{plane}]")
    return Reject(items, MarkerBit, "FBA-25", (mutation,), allowed=(REJECT, CONCEAL))
