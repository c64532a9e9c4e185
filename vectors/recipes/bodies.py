"""BAP data: bodies share the stream, so decoders of faces have to read over them.

Base steps are ambiguous (AMB-FBA-5): these vectors use bap_quant 0, or parameters whose step is the same either way.
"""

from __future__ import annotations

from ..builders import all_lists, body, empty, inter, intra, stream
from ..recipe import Accept, family, vector


@vector(
    id="fba.body.beside-face",
    title="FAP and BAP data in one plane",
    tier="semantic",
    rules=["FBA-5", "FBA-39", "FBA-40"],
    features=["bap", "inter"],
)
def beside_face() -> Accept:
    """fba_object_mask 3: one temporal header, FAP data first, then BAP data, in intra and inter planes."""
    first = body({8: 100, 9: -100}, face=intra({3: 5, 48: 6}, rate=(25, 0, 0)))
    second = inter(first, {3: 1}, baps={8: -360, 9: 360}, skip=2)
    third = inter(first, {48: -1}, baps={8: 1})
    return Accept(
        stream(first, second, third), values={(1, 3): 24, (2, 48): 850}, times={2: "4/25"},
        text={0: '"baps":{"8":25600,"9":-25600}', 1: '"baps":{"8":-66560,"9":66560}'},
    )  # fmt: skip


@vector(
    id="fba.body.alone",
    title="BAP data alone",
    tier="semantic",
    rules=["FBA-5", "FBA-34", "FBA-39", "FBA-40"],
    features=["bap"],
)
def alone() -> Accept:
    """fba_object_mask 2: no FAP data ever comes, all FAPs are U."""
    first = body({8: 1, 16: -2}, gender=1)
    planes = [first, inter(first, baps={16: 1}), empty()]
    return Accept(stream(*planes), lines=3, text={1: '"baps":{"8":256,"16":-256}'}, states={(0, 3): "U"})


@vector(
    id="fba.body.alternating",
    title="Face and body data in turn",
    tier="semantic",
    rules=["FBA-5", "FBA-15", "FBA-34", "FBA-40"],
    features=["bap", "states", "inter"],
)
def alternating() -> Accept:
    """Planes of FAP data and planes of BAP data in turn: each kind keeps its masks, models and values."""
    face = intra({3: 5})
    bones = body({8: 1, 9: 2})
    planes = [face, bones, inter(face, {3: 1}), inter(bones, baps={9: 1}), inter(face, {3: 1})]
    return Accept(stream(*planes), values={(1, 3): 20, (4, 3): 28}, states={(1, 3): "R", (4, 3): "T"})


@family(
    {str(quant): quant for quant in (0, 1, 4, 31)},
    id="fba.body.bap-quant.{case}",
    title="bap_quant {case}",
    tier="semantic",
    rules=["FBA-40"],
    features=["bap"],
    value_classes=["bap-quant"],
)
def bap_quant(quant: int) -> Accept:
    """bap_quant {case} is an index: the table's scale divides the limits and multiplies the step."""
    first = body({8: 2, 9: -2}, quant=quant, ranges=all_lists(31))
    return Accept(stream(first, inter(first, baps={8: -2})), lines=2, text={1: '"baps":{"8":0,'})


@vector(
    id="fba.body.default-limits.asymmetric",
    title="Default limits of bodies that are not symmetric",
    tier="semantic",
    rules=["FBA-40"],
    features=["bap", "default-ranges"],
    value_classes=["max", "min"],
    notes="That the table's limits are the defaults is this suite's reading.",
)
def asymmetric_limits() -> Accept:
    """BAP 6, 7, 32 and 35 at the ends of their ranges, which are not symmetric; bap_quant 0."""
    first = body({6: 480, 7: -960, 32: 1860, 35: -1860}, quant=0)
    second = inter(first, baps={6: -600, 7: 600, 32: -600, 35: 600})
    return Accept(stream(first, second), text={0: '"baps":{"6":480,"7":-960,"32":1860,"35":-1860}'})


@vector(
    id="fba.body.coding-order",
    title="Groups of bodies are not in the order of numbers",
    tier="syntax",
    rules=["FBA-40"],
    features=["bap", "mask-type-3"],
)
def coding_order() -> Accept:
    """Groups have an order of their own: all of group 2 (4 6 10 14) comes before group 3 (5 7 11 15)."""
    levels = {4: 1, 6: 2, 10: 3, 14: 4, 5: 5, 7: 6, 11: 7, 15: 8}
    first = body(levels, quant=0, types={2: 3, 3: 3})
    return Accept(stream(first), text={0: '"baps":{"4":1,"6":2,"10":3,"14":4,"5":5,"7":6,"11":7,"15":8}'})


@vector(
    id="fba.body.without-default-limits",
    title="BAPs without default limits, all lists sent",
    tier="semantic",
    rules=["FBA-16", "FBA-40"],
    features=["bap", "ranges"],
)
def without_defaults() -> Accept:
    """BAP 187 and later have no default limits; with all four lists they can be coded."""
    first = body({8: 3, 187: 4, 296: -4}, quant=0, ranges=all_lists(1))
    return Accept(stream(first, inter(first, baps={187: 1})), text={1: '"187":5'})
