"""Visemes and expressions."""

from __future__ import annotations

from ..builders import all_lists, empty, inter, intra, stream
from ..recipe import Accept, family, vector


@family(
    {str(quant): quant for quant in (0, 1, 2, 4, 13, 31)},
    id="fap.highlevel.largest.fap-quant-{case}",
    title="Largest blend and intensities at fap_quant {case}",
    tier="semantic",
    rules=["FBA-29", "FBA-31"],
    features=["viseme", "expression", "fap-quant"],
    value_classes=["max"],
)
def largest(quant: int) -> Accept:
    """All seven symbols at the top of their intra range, then at the bottom of their inter range; fap_quant {case}.

    M is (63 + fap_quant / 2) / fap_quant: a decoder that takes 63 / fap_quant has fewer symbols for some quantisers.
    """
    m = (63 + quant // 2) // quant if quant else 63
    step = quant or 1
    first = intra(quant=quant, viseme=(14, 14, m, 1), expression=(6, m, 6, m, 1, 1), types={1: 3})
    second = inter(first, viseme=(-14, -14, -m, 0), expression=(-6, -m, -6, -m, 0, 0))
    return Accept(
        stream(first, second),
        text={
            0: f'"viseme":{{"select1":14,"select2":14,"blend":{m * step},"def":1}}',
            1: '"expression":{"select1":0,"intensity1":0,"select2":0,"intensity2":0,"init_face":0,"def":0}',
        },
    )


@vector(
    id="fap.highlevel.quantiser-changes",
    title="M changes with fap_quant",
    tier="semantic",
    rules=["FBA-29", "FBA-30"],
    features=["viseme", "expression", "fap-quant"],
)
def m_changes() -> Accept:
    """fap_quant 1 and M = 63, then 31 and M = 2, then 8 and M = 8. A decoder that keeps M goes wrong at once."""
    planes = []
    for quant, m in ((1, 63), (31, 2), (8, 8)):
        first = intra(
            {3: 1}, quant=quant, viseme=(1, 2, m, 0), expression=(3, m, 4, 0, 0, 0), types={1: 3}, ranges=all_lists(1)
        )
        planes += [first, inter(first, viseme=(0, 0, -m, 0), expression=(0, -m, 0, m, 0, 0))]
    return Accept(
        stream(*planes),
        text={2: '"blend":62', 3: '"intensity2":62', 4: '"blend":64', 5: '"intensity2":64'},
        findings=("intensity-range",) * 3,
    )


@vector(
    id="fap.highlevel.field-order",
    title="Seven different numbers",
    tier="syntax",
    rules=["FBA-28"],
    features=["viseme", "expression"],
)
def field_order() -> Accept:
    """All fields differ: select1, intensity1, select2, intensity2 in this order. Decoders swap fields."""
    return Accept(
        stream(intra(viseme=(1, 2, 33, 0), expression=(3, 44, 5, 55, 0, 1), types={1: 3})),
        text={
            0: '"viseme":{"select1":1,"select2":2,"blend":33,"def":0},"expression":{"select1":3,"intensity1":44,'
            '"select2":5,"intensity2":55,"init_face":0,"def":1}'
        },
    )


@vector(
    id="fap.highlevel.out-of-range",
    title="Blend and intensities outside 0..63",
    tier="semantic",
    rules=["FBA-32"],
    features=["viseme", "expression", "inter"],
    value_classes=["negative", "above-max"],
)
def out_of_range() -> Accept:
    """Inter differences take the blend below 0 and an intensity above 63. They are not clipped in decoding."""
    first = intra(viseme=(1, 2, 10, 0), expression=(3, 60, 4, 10, 0, 0), types={1: 3})
    second = inter(first, viseme=(0, 0, -20, 0), expression=(0, 40, 0, 0, 0, 0))
    third = inter(first, viseme=(0, 0, 20, 0), expression=(0, -40, 0, 0, 0, 0))
    return Accept(
        stream(first, second, third), text={1: '"blend":-10', 2: '"blend":10'},
        findings=("intensity-range", "intensity-range"),
    )  # fmt: skip


@vector(
    id="fap.highlevel.models-adapt",
    title="The models of visemes and expressions adapt",
    tier="semantic",
    rules=["FBA-24", "FBA-29", "FBA-30"],
    features=["viseme", "expression", "inter"],
)
def models_adapt() -> Accept:
    """Twenty inter planes that go around the visemes and expressions; the models of the selects adapt too."""
    first = intra(viseme=(0, 14, 0, 0), expression=(0, 0, 6, 63, 0, 0), types={1: 3})
    planes = [first]
    for i in range(20):
        up = i % 14 != 13
        planes.append(
            inter(
                first,
                viseme=(1 if up else -13, -1 if up else 13, 3, i & 1),
                expression=(1 if i % 6 != 5 else -5, 3, -1 if i % 6 != 5 else 5, -3, 0, 0),
            )
        )
    return Accept(stream(*planes), lines=21, text={20: '"select1":6,"select2":8,"blend":60,"def":1'})


@vector(
    id="fap.highlevel.retained",
    title="Viseme and expression are retained",
    tier="semantic",
    rules=["FBA-34"],
    features=["viseme", "expression", "states"],
)
def retained() -> Accept:
    """Planes without data and intra planes without group 1 keep viseme and expression, in state R."""
    first = intra(viseme=(1, 2, 30, 1), expression=(3, 40, 5, 50, 1, 0), types={1: 3})
    return Accept(
        stream(first, empty(), intra({3: 1})), states={(1, 1): "R", (2, 2): "R"},
        text={2: '"viseme":{"select1":1,"select2":2,"blend":30,"def":1}'},
    )  # fmt: skip
