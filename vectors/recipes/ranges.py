"""Limits: defaults, range lists, what stays in force."""

from __future__ import annotations

from ..builders import all_lists, inter, intra, stream
from ..recipe import Accept, family, vector


@family(
    {"3": (3, 1080, 360), "5": (5, 1860, 600), "61": (61, 540, 120), "18": (18, 420, 180), "63": (63, 720, 180)},
    id="fap.range.default.fap-{case}",
    title="Default limits of FAP {case}",
    tier="semantic",
    rules=["FBA-18", "FBA-22"],
    features=["default-ranges"],
    value_classes=["max", "min"],
)
def default_limits(case: tuple[int, int, int]) -> Accept:
    """FAP {case} at both ends of its default intra range and then of its default inter range.

    Limits are symmetric, and rounded outward to a multiple of 60.
    """
    fap, i, p = case
    up, down = intra({fap: i}, quant=0), intra({fap: -i}, quant=0)
    planes = [up, inter(up, {fap: -p}), down, inter(down, {fap: p})]
    return Accept(stream(*planes), values={(0, fap): i, (1, fap): i - p, (2, fap): -i, (3, fap): -i + p})


@family(
    {name: name for name in ("i_max", "i_min", "p_max", "p_min")},
    id="fap.range.one-list.{case}",
    title="Only the list {case} is sent",
    tier="syntax",
    rules=["FBA-13", "FBA-16", "FBA-18", "FBA-19"],
    features=["ranges"],
)
def one_list(name: str) -> Accept:
    """One flag is set and one list sent; the other three limits are the defaults. The ranges are not symmetric."""
    plane = intra({3: 5, 48: -5}, ranges={name: {3: 2, 48: 31}})
    return Accept(stream(plane, inter(plane, {3: 7, 48: -7})), values={(0, 3): 20, (1, 3): 48, (1, 48): -2040})


@vector(
    id="fap.range.widened",
    title="Limits wider than the defaults",
    tier="semantic",
    rules=["FBA-16", "FBA-17"],
    features=["ranges"],
    value_classes=["max", "min"],
)
def widened() -> Accept:
    """v = 31 in all lists: +-1860 for FAPs whose defaults are narrower. The levels stand at the new limits."""
    plane = intra({3: 1860, 61: -1860}, ranges=all_lists(31))
    return Accept(stream(plane, inter(plane, {3: -1860, 61: 1860})), values={(0, 3): 7440, (0, 61): -1860, (1, 3): 0})


@vector(
    id="fap.range.zero",
    title="Limits 0 and 0: symbols that cost no bits",
    tier="semantic",
    rules=["FBA-16", "FBA-20", "FBA-26"],
    features=["ranges"],
    value_classes=["zero"],
)
def zero_ranges() -> Accept:
    """All limits are 0: every model has one symbol, and every segment is the two bits 01."""
    plane = intra({3: 0, 48: 0, 61: 0}, ranges=all_lists(0))
    return Accept(stream(plane, inter(plane)), values={(0, 3): 0, (1, 61): 0}, states={(1, 48): "T"})


@vector(
    id="fap.range.zero-among-others",
    title="One FAP with limits 0 and 0 among others",
    tier="semantic",
    rules=["FBA-16", "FBA-19", "FBA-20"],
    features=["ranges"],
    value_classes=["zero"],
)
def zero_among_others() -> Accept:
    """The limits of FAP 4 are sent as 0 and 0; FAP 3 and 5 have others. The second intra plane sends none.

    Limits of 0 are limits that were sent: a decoder that takes them for "never sent" falls back to the defaults here,
    for this FAP or for all.
    """
    v = {3: 4, 4: 0, 5: 9}
    first = intra({3: 100, 4: 0, 5: -500}, ranges={"i_max": v, "i_min": v, "p_max": v, "p_min": v})
    second = intra({3: -240, 4: 0, 5: 540})
    return Accept(
        stream(first, inter(first, {3: 240, 5: 1}), second, inter(second, {5: -540})),
        values={(1, 3): 1360, (2, 5): 1080, (3, 5): 0},
    )


@vector(
    id="fap.range.asymmetric",
    title="Limits that are not symmetric",
    tier="semantic",
    rules=["FBA-16", "FBA-20", "FBA-22"],
    features=["ranges"],
    value_classes=["max", "min", "zero"],
)
def asymmetric() -> Accept:
    """Maximum and minimum differ in every list, one of them is 0: symbol s stands for s + min."""
    ranges = {"i_max": {3: 0, 48: 31}, "i_min": {3: 10, 48: 0}, "p_max": {3: 1, 48: 0}, "p_min": {3: 0, 48: 7}}
    plane = intra({3: -600, 48: 1860}, ranges=ranges)
    return Accept(
        stream(plane, inter(plane, {3: 60, 48: -420}), inter(plane, {3: 0, 48: 0})),
        values={(0, 3): -2400, (0, 48): 316200, (1, 3): -2160, (1, 48): 244800},
    )


@vector(
    id="fap.range.kept-per-fap",
    title="Limits are kept per FAP",
    tier="semantic",
    rules=["FBA-15", "FBA-19"],
    features=["ranges"],
)
def kept_per_fap() -> Accept:
    """Limits of FAP 3 are sent, then those of FAP 48 while FAP 3 is not coded; then FAP 3 is coded again without any.

    Its limits are those last sent for it, not the defaults.
    """
    first = intra({3: 60}, ranges=all_lists(1))
    second = intra({48: 120}, ranges=all_lists(2))
    third = intra({3: -60, 48: -120})
    planes = [first, second, third, inter(third, {3: 60, 48: 120})]
    return Accept(stream(*planes), values={(2, 3): -240, (3, 3): 0, (3, 48): 0})


@vector(
    id="fap.range.markers",
    title="Markers of groups without coded FAPs",
    tier="syntax",
    rules=["FBA-16"],
    features=["ranges"],
    value_classes=["first-in-group", "last-in-group"],
)
def markers() -> Accept:
    """Each list has 18 markers, before every fourth FAP counted from the start of each group, coded or not.

    FAPs in the middle of groups are coded, so that markers and limits alternate in many ways.
    """
    plane = intra({6: 1, 7: 2, 10: 3, 18: 4, 30: 5, 38: 6, 42: 7, 50: 8, 60: 9, 64: 10, 68: 11}, ranges=all_lists(3))
    return Accept(stream(plane, inter(plane, {68: -1})), values={(0, 6): 2, (0, 60): 18, (1, 68): 10})


@vector(
    id="fap.range.fap-quant",
    title="Limits divided by fap_quant",
    tier="semantic",
    rules=["FBA-17", "FBA-31"],
    features=["ranges", "fap-quant"],
    value_classes=["max", "min"],
)
def divided() -> Accept:
    """fap_quant 7: limits of 60 become 8 (truncated), 300 becomes 42. The levels stand at the limits in force."""
    ranges = {"i_max": 5, "i_min": 1, "p_max": 1, "p_min": 5}
    plane = intra({3: 42, 48: -8}, quant=7, ranges=ranges)
    return Accept(stream(plane, inter(plane, {3: -42, 48: 8})), values={(0, 3): 1176, (0, 48): -9520, (1, 3): 0})


@vector(
    id="fap.range.fap-quant-changed",
    title="fap_quant changes, all limits sent again",
    tier="semantic",
    rules=["FBA-15", "FBA-17", "FBA-19"],
    features=["ranges", "fap-quant"],
)
def quant_changed() -> Accept:
    """fap_quant 3, then 20, each with all four lists: what holds when they are not sent again is ambiguous."""
    first = intra({3: 20, 31: -20}, quant=3, ranges=all_lists(1))
    second = intra({3: 30, 31: -30}, quant=20, ranges=all_lists(10))
    planes = [first, inter(first, {3: -20}), second, inter(second, {31: 30})]
    return Accept(stream(*planes), values={(0, 3): 240, (1, 3): 0, (2, 3): 2400, (2, 31): -1200, (3, 31): 0})


@vector(
    id="fap.range.fap-quant-31",
    title="Limits at fap_quant 31",
    tier="semantic",
    rules=["FBA-17", "FBA-18"],
    features=["default-ranges", "fap-quant"],
    value_classes=["max"],
)
def quant_31() -> Accept:
    """Default limits divided by 31: FAP 3 +-34 and +-11."""
    plane = intra({3: 34}, quant=31)
    return Accept(stream(plane, inter(plane, {3: -11})), values={(0, 3): 4216, (1, 3): 2852})
