"""From levels to values: steps, prediction, no clipping."""

from __future__ import annotations

from snhc.reference_impl.tables import fap_table

from ..builders import all_lists, inter, intra, stream
from ..recipe import Accept, family, vector


@family(
    {str(quant): quant for quant in (0, 1, 2, 3, 16, 31)},
    id="fap.value.fap-quant.{case}",
    title="fap_quant {case}",
    tier="semantic",
    rules=["FBA-9", "FBA-17", "FBA-31", "FBA-32"],
    features=["fap-quant"],
    value_classes=["fap-quant"],
)
def fap_quant(quant: int) -> Accept:
    """FAPs of several steps (4, 2, 1, 128, 170) at fap_quant {case}: the value is level * QP * fap_quant.

    At fap_quant 0 it is the level itself: QP is not applied.
    """
    levels = {3: 7, 4: -5, 14: 3, 23: -2, 48: 9}
    steps = {3: 4, 4: 2, 14: 1, 23: 128, 48: 170}
    first = intra(levels, quant=quant)
    second = inter(first, dict.fromkeys(levels, 1))
    step = {fap: steps[fap] * quant if quant else 1 for fap in levels}
    values = {(0, fap): level * step[fap] for fap, level in levels.items()}
    values.update({(1, fap): (level + 1) * step[fap] for fap, level in levels.items()})
    return Accept(stream(first, second), values=values)


@vector(
    id="fap.value.every-step",
    title="The step of every FAP",
    tier="semantic",
    rules=["FBA-31"],
    features=["mask-type-3", "ranges"],
    value_classes=["every-fap"],
)
def every_step() -> Accept:
    """Level 1 for every FAP 3..68: the values are the steps of the table, times fap_quant 2."""
    numbers = range(3, 69)
    plane = intra(dict.fromkeys(numbers, 1), quant=2, types=dict.fromkeys(range(2, 11), 3), ranges=all_lists(1))
    steps = {fap.number: fap.QP for fap in fap_table()}
    return Accept(stream(plane), values={(0, fap): 2 * steps[fap] for fap in numbers})


@vector(
    id="fap.value.prediction",
    title="Inter values add to the last reconstructed ones",
    tier="semantic",
    rules=["FBA-32"],
    features=["inter"],
    value_classes=["negative", "zero"],
)
def prediction() -> Accept:
    """Sums of differences of both signs, across 0 and back. An intra plane begins anew."""
    first = intra({3: 10, 48: -10})
    planes = [first, *(inter(first, {3: d, 48: -d}) for d in (-10, -10, 5, 20, -360)), intra({3: 1, 48: 1})]
    return Accept(
        stream(*planes), values={(1, 3): 0, (2, 3): -40, (3, 3): -20, (5, 3): -1380, (5, 48): 58650, (6, 48): 170}
    )


@vector(
    id="fap.value.no-clipping",
    title="Sums leave the intra range: no clipping",
    tier="semantic",
    rules=["FBA-32"],
    features=["inter"],
    value_classes=["max"],
    notes="Another reading clips (AMB-FBA-4); this vector follows the register.",
)
def no_clipping_one_directional() -> Accept:
    """FAP 3 is one-directional, but its range is symmetric: a negative value is coded and reconstructed as it is."""
    first = intra({3: -25})
    return Accept(stream(first, inter(first, {3: -1})), values={(0, 3): -100, (1, 3): -104})


@vector(
    id="fap.value.quantiser-change-keeps-values",
    title="Values are kept in FAP units when fap_quant changes",
    tier="semantic",
    rules=["FBA-15", "FBA-31", "FBA-32", "FBA-34"],
    features=["fap-quant", "states"],
)
def quant_change() -> Accept:
    """FAP 4 is retained across an intra plane with another fap_quant: its value does not change with the step."""
    first = intra({3: 5, 4: 6}, quant=5, ranges=all_lists(4))
    second = intra({3: 5}, quant=2, ranges=all_lists(4))
    planes = [first, second, inter(second, {3: -1})]
    return Accept(stream(*planes), values={(0, 3): 100, (0, 4): 60, (1, 3): 40, (1, 4): 60, (2, 3): 32})
