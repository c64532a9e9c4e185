"""The worked examples, byte for byte."""

from __future__ import annotations

from ..builders import all_lists, inter, intra, stream
from ..recipe import Accept, vector


@vector(
    id="fap.arith.example.1",
    title="Worked stream 1: two FAPs, all four range lists, a skip",
    tier="semantic",
    rules=["FBA-1", "FBA-3", "FBA-5", "FBA-6", "FBA-8", "FBA-10", "FBA-16", "FBA-26", "FBA-32", "FBA-38"],
    features=["ranges", "skip", "inter"],
)
def example_1() -> Accept:
    """FAP 3 and FAP 48 coded at fap_quant 1, rate 25, limits +-1080 and +-360; the last plane skips 17 frames.

    The 42 bytes were made by an independent encoder.
    """
    ranges = {"i_max": 18, "i_min": 18, "p_max": 6, "p_min": 6}
    first = intra({3: 25, 48: -20}, ranges=ranges, rate=(25, 0, 0))
    return Accept(
        stream(first, inter(first, {3: 10, 48: 10}), inter(first, {48: 11}, skip=17)),
        same_as=bytes.fromhex(
            "000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1"
        ),
        values={
            (0, 3): 100, (0, 48): -3400, (1, 3): 140, (1, 48): -1700, (2, 3): 140, (2, 48): 170, (2, 4): None,
        },
        times={0: "0/1", 1: "1/25", 2: "2/25"},
        findings=(),
    )  # fmt: skip


@vector(
    id="fap.arith.example.2",
    title="Worked stream 2: a start-code guard in an intra segment",
    tier="semantic",
    rules=["FBA-18", "FBA-23", "FBA-25", "FBA-26", "FBA-32"],
    features=["guard", "default-ranges"],
    value_classes=["max"],
)
def example_2() -> Accept:
    """FAP 48 and 49 at the highest level: the segment opens with 22 zero bits and a guard.

    A decoder that does not remove the guard, or that rewinds its look-ahead by 14 raw bits, loses its place here.
    """
    first = intra({48: 1860, 49: 1860}, rate=(25, 0, 0))
    return Accept(
        stream(first, inter(first, {48: -3, 49: 2})),
        same_as=bytes.fromhex("000001bab1900192492e92000000049405172f000001b1"),
        values={(0, 48): 316200, (0, 49): 316200, (1, 48): 315690, (1, 49): 316540},
        times={1: "1/25"},
        findings=(),
    )


@vector(
    id="fap.arith.example.3",
    title="Worked stream 3: viseme, expression and one low-level FAP",
    tier="semantic",
    rules=["FBA-10", "FBA-11", "FBA-28", "FBA-29", "FBA-31", "FBA-32", "FBA-33"],
    features=["viseme", "expression", "inter"],
)
def example_3() -> Accept:
    """Three segments per plane, each with its own coder; raw flags between them. fap_quant 2, M = 32.

    Decoders swap the fields of the expression, or take 63 / fap_quant for M.
    """
    first = intra({3: 50}, quant=2, viseme=(4, 7, 20, 1), expression=(1, 25, 3, 5, 1, 0), types={1: 3}, gender=1)
    second = inter(first, {3: -7}, viseme=(3, -7, -4, 0), expression=(0, -1, 3, 12, 0, 1))
    return Accept(
        stream(first, second),
        same_as=bytes.fromhex("000001baa05ec00049249241661efce13a1267aa200e7ec26f000001b1"),
        values={(0, 3): 400, (1, 3): 344},
        times={1: "1/30"},
        text={
            0: '"viseme":{"select1":4,"select2":7,"blend":40,"def":1},"expression":{"select1":1,"intensity1":50,'
            '"select2":3,"intensity2":10,"init_face":1,"def":0},"state":"TTTUU',
            1: '"viseme":{"select1":7,"select2":0,"blend":32,"def":0},"expression":{"select1":1,"intensity1":48,'
            '"select2":6,"intensity2":34,"init_face":0,"def":1},"state":"TTTUU',
        },
        findings=(),
    )


@vector(
    id="fap.arith.example.4",
    title="Worked stream 4: mask type 2 and the states T, R, I, U",
    tier="semantic",
    rules=["FBA-14", "FBA-15", "FBA-30", "FBA-34"],
    features=["mask-type-2", "states"],
)
def example_4() -> Accept:
    """FAPs go from transmitted to retained, to be interpolated and back; FAP 31 returns from I to R as last decoded."""
    first = intra({3: 10, 31: 20, 48: 1, 49: -1, 50: 2}, types={4: 2, 7: 3})
    second = inter(first, {3: 1, 31: -5, 50: -2})
    third = intra({4: -6, 32: 8}, types={4: 2})
    fourth = intra({3: 12}, types={2: 2})
    u = "U"
    return Accept(
        stream(first, second, third, fourth),
        same_as=bytes.fromhex(
            "000001baa032c0004d01279200fd9f553f600a7e49fe9483ff7ff2a032a0004c81249201028d85019a000249249007e97f000001b1"
        ),
        values={(0, 31): 40, (1, 31): 30, (2, 31): None, (3, 31): 30, (3, 32): 16, (3, 33): None, (3, 3): 48},
        text={
            0: f'"state":"{u * 2}T{u * 27}T{"I" * 7}{u * 9}TTT{u * 18}"',
            1: f'"state":"{u * 2}T{u * 27}T{"I" * 7}{u * 9}TTT{u * 18}"',
            2: f'"state":"{u * 2}RT{u * 26}IT{"I" * 6}{u * 9}RRR{u * 18}"',
            3: f'"state":"{u * 2}T{"I" * 15}{u * 12}RR{u * 15}RRR{u * 18}"',
        },
        findings=(),
    )


@vector(
    id="fap.arith.mask.all-groups-type-3",
    title="All 68 FAPs coded",
    tier="semantic",
    rules=["FBA-14", "FBA-16", "FBA-28"],
    features=["mask-type-3", "ranges", "viseme", "expression"],
)
def all_coded() -> Accept:
    """Every group has mask type 3; all limits are sent, so that no default range is used (FAP 47)."""
    first = intra(
        {fap: fap - 36 for fap in range(3, 69)}, types=dict.fromkeys(range(1, 11), 3), ranges=all_lists(2),
        viseme=(1, 2, 3, 0), expression=(1, 2, 3, 4, 0, 0),
    )  # fmt: skip
    second = inter(first, {fap: (fap % 7) - 3 for fap in range(3, 69)}, viseme=(1, 1, 1, 0))
    return Accept(stream(first, second), lines=2, values={(0, 3): -132, (0, 68): 32, (1, 47): (11 + 2) * 512})
