"""FAP interpolation tables on frames: the worked cases, order, undefined functions, impulses, readings.

Rules: FIT-1..7, CNF-2. Results keep away from halves by more than 1e-6, but for the vectors of AMB-FIT-2 and of the
rounding itself, where they are exact.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import RangeViolation

from ..document_builders import Function, JsonTable, fit, fit_table, frame, linear
from ..recipe import Accept, Ambiguous, vector

TOOLS: Final = ("fit",)
_ONE: Final = [linear(1.0)]


def _given(*lines: dict[int, int | None]) -> dict[tuple[int, int], int | None]:
    return {(i, fap): value for i, line in enumerate(lines) for fap, value in line.items()}


def _states(*lines: dict[int, str]) -> dict[tuple[int, int], str]:
    return {(i, fap): letter for i, line in enumerate(lines) for fap, letter in line.items()}


def _figure_12() -> JsonTable:
    """Expression -> top and bottom inner lip; inner lips -> outer lips; expression -> outer lips."""
    return fit_table(
        [[2], [4, 8], [5, 10], [51, 55], [52, 57]],
        [
            (1, 3, [linear(1.0, 0.5), linear(0.0, 1.0)]),
            (2, 4, [linear(1.0, 0.0), linear(0.25, 1.0)]),
            (0, 1, [([(2.0, (0, 1, 0, 0))], []), ([(3.0, (0, 1, 0, 0))], [])]),
            (0, 2, [([(-2.0, (0, 1, 0, 0))], []), ([(-1.0, (0, 1, 0, 0))], [])]),
            (0, 3, [([(9.0, (0, 1, 0, 0))], []), ([(9.0, (0, 1, 0, 0))], [])]),
        ],
        impulses=[0, 1] * 6,
    )


@vector(id="fit.case.a-expression", title="Expression alone drives the lips", tier="semantic", tools=TOOLS,
        rules=["FIT-1", "FIT-2", "FIT-3", "FIT-4", "FIT-5", "FIT-6"], features=["graph", "impulse"])  # fmt: skip
def case_a() -> Accept:
    """Joy at 40 through the graph of figure 12. FAP 51 has two parents: its first one, the inner lips, counts.

    51 = 80 + 120 / 2 = 140, and not 9 * 40; 57 = -80 / 4 - 40.
    """
    return Accept(
        fit(_figure_12(), frame(expression=(1, 40, 0, 0))),
        values=_given({4: 80, 8: 120, 5: -80, 10: -40, 51: 140, 55: 120, 52: -80, 57: -60, 6: None}),
        states=_states({2: "T", 4: "F", 51: "F", 6: "U"}),
    )


@vector(id="fit.case.b-inner-lip", title="Inner lips drive outer lips", tier="semantic", tools=TOOLS,
        rules=["FIT-2", "FIT-4", "FIT-6"], features=["graph"])  # fmt: skip
def case_b() -> Accept:
    """The same graph without an expression: what hangs on it alone stays unset."""
    return Accept(
        fit(_figure_12(), frame({4: 100, 8: 50}), frame({4: 100}), frame({5: -8, 10: 4})),
        values=_given({51: 125, 55: 50, 5: None, 52: None}, {51: None, 55: None}, {52: -8, 57: 2, 51: None}),
        states=_states({4: "T", 51: "F", 52: "U"}),
    )


@vector(id="fit.case.c-eyebrow", title="One eyebrow from the other", tier="semantic", tools=TOOLS,
        rules=["FIT-3", "FIT-4", "FIT-7"], features=["linear"])  # fmt: skip
def case_c() -> Accept:
    """Three linear functions of FAP 34, with factors 1/2, 1 and 3/4."""
    table = fit_table([[34], [31, 33, 35]], [(0, 1, [linear(0.5), linear(1.0), linear(0.75)])])
    return Accept(
        fit(table, frame({34: 100}), frame({34: -103}), frame({34: 0})),
        values=_given({31: 50, 33: 100, 35: 75}, {33: -103, 35: -77}, {31: 0, 33: 0, 35: 0}),
    )


@vector(id="fit.case.d-asymmetric", title="A left-to-right rule that is no mirror", tier="semantic", tools=TOOLS,
        rules=["FIT-4", "FIT-6"])  # fmt: skip
def case_d() -> Accept:
    """The right corner of the mouth moves by -1/2 of the left one, not as much. A decoder that mirrors gives 100."""
    return Accept(fit(fit_table([[6], [7]], [(0, 1, [linear(-0.5)])]), frame({6: 100})), values=_given({7: -50}))


@vector(id="fit.case.e-incomplete-parent", title="The first parent is incomplete", tier="semantic", tools=TOOLS,
        rules=["FIT-2", "FIT-6"])  # fmt: skip
def case_e() -> Accept:
    """First parent FAP 4 and 5, second parent FAP 6: without FAP 5 the second is used, with it the first."""
    table = fit_table([[4, 5], [6], [10]], [(0, 2, [linear(1.0, 1.0)]), (1, 2, [linear(7.0)])])
    return Accept(
        fit(table, frame({4: 1, 6: 3}), frame({4: 1, 5: 2, 6: 3}), frame({4: 1})),
        values=_given({10: 21}, {10: 3}, {10: None}),
        states=_states({10: "F"}, {10: "F"}, {10: "U"}),
    )


def _rational() -> JsonTable:
    function: Function = ([(1.0, (3,)), (2.0, (0,))], [(1.0, (2,)), (-4.0, (0,))])
    return fit_table([[3], [4]], [(0, 1, [function])])


@vector(id="fit.case.f-rational", title="Cubic over quadratic", tier="semantic", tools=TOOLS,
        rules=["FIT-3", "FIT-4", "FIT-7"], features=["denominator"])  # fmt: skip
def case_f() -> Accept:
    """(F^3 + 2) / (F^2 - 4) for F = 3, -3, 1000, 1: 5.8, -5, a little more than 1000, and -1."""
    return Accept(
        fit(_rational(), frame({3: 3}), frame({3: -3}), frame({3: 1000}), frame({3: 1})),
        values=_given({4: 6}, {4: -5}, {4: 1000}, {4: -1}),
    )


@vector(id="fit.case.g-impulse", title="Impulses select one expression", tier="semantic", tools=TOOLS,
        rules=["FIT-5"], features=["impulse"])  # fmt: skip
def case_g() -> Accept:
    """Joy counts twice, anger five times, by expression_select1; for the others no term is left, which gives 0."""
    function: Function = ([(2.0, (0, 1, 0, 0)), (5.0, (0, 1, 0, 0))], [])
    table = fit_table([[2], [12]], [(0, 1, [function])], impulses=[0, 1, 0, 3])
    moods = [(1, 10, 2, 60), (3, 10, 2, 60), (2, 10, 1, 60)]
    return Accept(fit(table, *(frame(expression=mood) for mood in moods)), values=_given({12: 20}, {12: 50}, {12: 0}))


@vector(id="fit.impulse.order-of-the-set", title="Parent values in the order of the set", tier="semantic", tools=TOOLS,
        rules=["FIT-3", "FIT-5"], features=["impulse"])  # fmt: skip
def impulse_order() -> Accept:
    """Set (2, 3, 1): values 0..3 are the expression, 4 is FAP 3, 5..7 the viseme. FAP 3 * blend where select1 is 9."""
    table = fit_table([[2, 3, 1], [20]], [(0, 1, [([(1.0, (0, 0, 0, 0, 1, 0, 0, 1))], [])])], impulses=[5, 9])
    mood = (1, 2, 3, 4)
    return Accept(
        fit(
            table, frame({3: 4}, viseme=(9, 2, 30), expression=mood), frame({3: 4}, viseme=(8, 9, 30), expression=mood),
            frame({3: 4}, viseme=(9, 2, 30)),
        ),
        values=_given({20: 120}, {20: 0}, {20: None}),
    )  # fmt: skip


@vector(id="fit.impulse.on-a-low-level-value", title="An impulse on a low-level FAP", tier="semantic", tools=TOOLS,
        rules=["FIT-5"], features=["impulse"])  # fmt: skip
def impulse_low() -> Accept:
    """Value 3 of the set (1, 5) is FAP 5: the term counts only where it is 1000."""
    table = fit_table([[1, 5], [16]], [(0, 1, [([(1.0, (0, 0, 1, 0))], [])])], impulses=[3, 1000])
    found = [frame({5: value}, viseme=(1, 0, 40)) for value in (1000, 999)]
    return Accept(fit(table, *found), values=_given({16: 40}, {16: 0}))


@vector(id="fit.state.only-unavailable", title="Only what is unavailable is written", tier="semantic", tools=TOOLS,
        rules=["FIT-6"])  # fmt: skip
def states() -> Accept:
    """T and R are available and stay as they are; I and U are written. A parent that is I makes no link usable."""
    table = fit_table([[3], [4, 5, 6, 7]], [(0, 1, [linear(1.0), linear(2.0), linear(3.0), linear(4.0)])])
    return Accept(
        fit(
            table, frame({3: 7, 4: 50, 6: 1, 7: 2}, states={3: "R", 4: "I", 7: "R"}), frame({3: 7}, states={3: "I"}),
        ),
        values=_given({4: 7, 5: 14, 6: 1, 7: 2}, {4: None, 5: None}),
        states=_states({3: "R", 4: "F", 5: "F", 6: "T", 7: "R"}, {4: "U"}),
    )  # fmt: skip


@vector(id="fit.state.from-fit", title="Frames that were filled before", tier="semantic", tools=TOOLS, rules=["FIT-6"])
def filled_before() -> Accept:
    """State F is available, S (by symmetry) is not: nothing is made from it."""
    table = fit_table([[3], [4], [5], [6]], [(0, 1, _ONE), (2, 3, _ONE)])
    return Accept(
        fit(table, frame({3: 9, 5: 8}, states={3: "F", 5: "S"})),
        values=_given({4: 9, 6: None}), states=_states({3: "F", 4: "F", 5: "S", 6: "U"}),
    )  # fmt: skip


@vector(id="fit.state.incomplete-high-level", title="An expression that is to be interpolated", tier="semantic",
        tools=TOOLS, rules=["FIT-5", "FIT-6"])  # fmt: skip
def high_level_state() -> Accept:
    """FAP 2 with values but state I is not available; with state R it is."""
    table = fit_table([[2], [12]], [(0, 1, [([(1.0, (0, 1, 0, 0))], [])])], impulses=[0, 1])
    found = [frame(expression=(1, 30, 0, 0), states={2: letter}) for letter in "IR"]
    return Accept(fit(table, *found), values=_given({12: None}, {12: 30}))


@vector(id="fit.order.chain", title="A chain against the numbers of the sets", tier="semantic", tools=TOOLS,
        rules=["FIT-6"], features=["graph"])  # fmt: skip
def chain() -> Accept:
    """FAP 3 gives 4, which gives 5, which gives 6; sets and links stand the other way round."""
    table = fit_table([[6], [5], [4], [3]], [(1, 0, [linear(2.0)]), (2, 1, [linear(2.0)]), (3, 2, [linear(2.0)])])
    return Accept(fit(table, frame({3: 1})), values=_given({4: 2, 5: 4, 6: 8}))


@vector(id="fit.order.smallest-ready-set", title="Of two ready sets the smaller one is first", tier="semantic",
        tools=TOOLS, rules=["FIT-6"], features=["graph"])  # fmt: skip
def smallest() -> Accept:
    """FAP 10 stands in sets 1 and 2, both ready: set 1 gives it, though its link is the second one."""
    table = fit_table([[3], [10], [10, 11]], [(0, 2, [linear(7.0), linear(7.0)]), (0, 1, [linear(5.0)])])
    return Accept(fit(table, frame({3: 1})), values=_given({10: 5, 11: 7}))


@vector(id="fit.order.at-once", title="A value is available at once", tier="semantic", tools=TOOLS, rules=["FIT-6"])
def at_once() -> Accept:
    """FAP 20, the first of its child set, is a parent of FAP 21, the second one."""
    table = fit_table(
        [[3], [3, 20], [20, 21]],
        [(0, 2, [linear(4.0), ([(0.0, (1,))], [(0.0, (0,))])]), (1, 2, [linear(0.0, 0.0), linear(1.0, 1.0)])],
    )
    return Accept(fit(table, frame({3: 2})), values=_given({20: 8, 21: 10}))


@vector(id="fit.order.cycle", title="A cycle of two sets", tier="semantic", tools=TOOLS, rules=["FIT-6"],
        features=["graph", "cycle"])  # fmt: skip
def cycle() -> Accept:
    """FAP 3 gives 4 and 4 gives 3: whichever is there gives the other, and nothing comes from nothing."""
    table = fit_table([[3], [4]], [(0, 1, [linear(2.0)]), (1, 0, [linear(0.5)])])
    return Accept(
        fit(table, frame({3: 10}), frame({4: 10}), frame({3: 1, 4: 1}), frame()),
        values=_given({3: 10, 4: 20}, {3: 5, 4: 10}, {3: 1, 4: 1}, {3: None, 4: None}),
        states=_states({4: "F"}, {3: "F"}, {3: "T", 4: "T"}, {3: "U"}),
    )


@vector(id="fit.order.cycle-passes", title="A cycle that takes several passes", tier="stress", tools=TOOLS,
        rules=["FIT-6"], features=["graph", "cycle"])  # fmt: skip
def passes() -> Accept:
    """A ring of twelve sets, each fed by the one with the next number: one value a pass, and never a second time."""
    faps = list(range(19, 31))
    sets = [[fap] for fap in faps]
    table = fit_table(sets, [((i + 1) % len(faps), i, [linear(1.0)]) for i in range(len(faps))])
    return Accept(fit(table, frame({30: 5}), frame({24: -7})), values={
        **{(0, fap): 5 for fap in faps}, **{(1, fap): -7 for fap in faps},
    })  # fmt: skip


@vector(id="fit.undefined.zero-denominator", title="A denominator of 0 leads to the next link", tier="semantic",
        tools=TOOLS, rules=["FIT-7"], features=["denominator"])  # fmt: skip
def zero_denominator() -> Accept:
    """12 / F: for F = 0 the second parent is used, and where it is not there nothing is written."""
    over: Function = ([(12.0, (0,))], [(1.0, (1,))])
    table = fit_table([[3], [4], [10]], [(0, 2, [over]), (1, 2, [linear(3.0)])])
    return Accept(
        fit(table, frame({3: 0, 4: 5}), frame({3: 4, 4: 5}), frame({3: 0})),
        values=_given({10: 15}, {10: 3}, {10: None}), states=_states({10: "F"}, {10: "F"}, {10: "U"}),
    )  # fmt: skip


@vector(id="fit.undefined.zero-over-zero", title="0 / 0 is undefined too", tier="semantic", tools=TOOLS,
        rules=["FIT-7"], features=["denominator"])  # fmt: skip
def zero_over_zero() -> Accept:
    """F / F is 1, but not for F = 0."""
    table = fit_table([[3], [10]], [(0, 1, [([(1.0, (1,))], [(1.0, (1,))])])])
    return Accept(fit(table, frame({3: 0}), frame({3: -9})), values=_given({10: None}, {10: 1}))


@vector(id="fit.undefined.not-finite", title="A result that float64 does not hold", tier="stress", tools=TOOLS,
        rules=["FIT-4", "FIT-7"], value_classes=["max"])  # fmt: skip
def not_finite() -> Accept:
    """F^15 twice: (2^31 - 1)^30 is finite, 1e300 times it is not. The other FAP of the set is not concerned."""
    table = fit_table(
        [[3, 4], [10, 11]], [(0, 1, [([(1e300, (15, 15))], []), ([(1e-270, (15, 15))], [(1.0, (0, 0))])])]
    )
    return Accept(fit(table, frame({3: 2**31 - 1, 4: 2**31 - 1})), values=_given({10: None}))


@vector(id="fit.value.zero-to-the-zero", title="0 to the power of 0 is 1", tier="syntax", tools=TOOLS,
        rules=["FIT-3", "FIT-4"], value_classes=["zero"])  # fmt: skip
def zero_power() -> Accept:
    """5 F^0 for F = 0 is 5; a function without terms is 0."""
    table = fit_table([[3], [10, 11]], [(0, 1, [([], []), ([(5.0, (0,))], [])])])
    return Accept(fit(table, frame({3: 0})), values=_given({10: 0, 11: 5}))


@vector(id="fit.value.halves", title="Halves are rounded away from zero", tier="semantic", tools=TOOLS,
        rules=["FIT-7"], value_classes=["half"])  # fmt: skip
def halves() -> Accept:
    """F / 2 for odd F, exactly: 0.5, -0.5, 2.5, -2.5."""
    table = fit_table([[3], [10]], [(0, 1, [linear(0.5)])])
    return Accept(
        fit(table, *(frame({3: value}) for value in (1, -1, 5, -5))),
        values=_given({10: 1}, {10: -1}, {10: 3}, {10: -3}),
    )


@vector(id="fit.value.not-clipped", title="Values are not clipped", tier="stress", tools=TOOLS, rules=["FIT-7"],
        value_classes=["above-max"])  # fmt: skip
def not_clipped() -> Accept:
    """1e6 F: far past the range of any FAP."""
    table = fit_table([[3], [19]], [(0, 1, [linear(1e6)])])
    return Accept(fit(table, frame({3: 1000}), frame({3: -1000})), values=_given({19: 10**9}, {19: -(10**9)}))


@vector(id="fit.value.full-function", title="Ten terms over ten terms", tier="stress", tools=TOOLS,
        rules=["FIT-3", "FIT-4"], features=["denominator"], value_classes=["max"])  # fmt: skip
def ten_terms() -> Accept:
    """The most terms that the field holds, with exponents up to 15, in three parents."""
    top = [(float(i + 1), (i % 3, i % 2, 15 if i == 9 else i % 4)) for i in range(10)]
    bottom = [(1.0, (i % 2, 0, i % 3)) for i in range(10)]
    table = fit_table([[3, 4, 5], [20]], [(0, 1, [(top, bottom)])])
    return Accept(fit(table, frame({3: 3, 4: -2, 5: 2}), frame({3: 1, 4: 1, 5: 1}), frame({3: -7, 4: 11, 5: -1})))


@vector(id="fit.value.empty-table", title="A table without links", tier="syntax", tools=TOOLS, rules=["FIT-1", "FIT-9"])
def empty() -> Accept:
    """Absent fields are empty: the frames come out as they went in."""
    return Accept(fit({}, frame({3: 1}), frame()), values=_given({3: 1, 4: None}, {3: None}), lines=2)


@vector(id="fit.ambiguous.impulse", title="What the first number of an impulse pair counts", tier="semantic",
        tools=TOOLS, rules=["FIT-5"], features=["impulse"])  # fmt: skip
def impulse_base() -> Ambiguous:
    """Parent (3, 2), pair (1, 5): from 0 that is expression_select1, from 1 FAP 3, within FAP 2 its intensity1."""
    table = fit_table([[3, 2], [10]], [(0, 1, [([(1.0, (0, 0, 0, 0, 0))], [])])], impulses=[1, 5])
    moods = [(9, (5, 8, 0, 0)), (5, (6, 8, 0, 0)), (9, (6, 5, 0, 0))]
    found = [frame({3: fap}, expression=mood) for fap, mood in moods]
    values = {
        "from-0": _given({10: 1}, {10: 0}, {10: 0}), "from-1": _given({10: 0}, {10: 1}, {10: 0}),
        "within-fap": _given({10: 0}, {10: 0}, {10: 1}),
    }  # fmt: skip
    return Ambiguous(fit(table, *found), "AMB-FIT-1", values=values)


@vector(id="fit.ambiguous.impulse-range", title="Value number 0", tier="semantic", tools=TOOLS, rules=["FIT-5"],
        features=["impulse"])  # fmt: skip
def impulse_zero() -> Ambiguous:
    """Pair (0, 7) of the parent (3, 2): FAP 3, expression_select1, or, counted from 1, nothing that is there."""
    table = fit_table([[3, 2], [10]], [(0, 1, [([(1.0, (0, 0, 0, 0, 0))], [])])], impulses=[0, 7])
    found = [frame({3: 7}, expression=(1, 8, 0, 0)), frame({3: 8}, expression=(7, 8, 0, 0))]
    return Ambiguous(
        fit(table, *found), "AMB-FIT-1", faults={"from-1": (RangeViolation, "FIT-5", "numeratorImpulse[0]")},
        values={"from-0": _given({10: 1}, {10: 0}), "within-fap": _given({10: 0}, {10: 1})},
    )  # fmt: skip


@vector(id="fit.ambiguous.undefined", title="Undefined functions and rounding", tier="semantic", tools=TOOLS,
        rules=["FIT-7"], features=["denominator"])  # fmt: skip
def undefined() -> Ambiguous:
    """12 / F with a second parent: for F = 0 that, or 0; for F = 7 the nearest integer 2, or 1.71 cut to 1."""
    over: Function = ([(12.0, (0,))], [(1.0, (1,))])
    table = fit_table([[3], [4], [10]], [(0, 2, [over]), (1, 2, [linear(3.0)])])
    values = {"next-nearest": _given({10: 15}, {10: 2}), "zero-truncated": _given({10: 0}, {10: 1})}
    return Ambiguous(fit(table, frame({3: 0, 4: 5}), frame({3: 7, 4: 5})), "AMB-FIT-2", values=values)


@vector(id="fit.ambiguous.order", title="Order of sets that share a FAP", tier="semantic", tools=TOOLS,
        rules=["FIT-6"], features=["graph"])  # fmt: skip
def order() -> Ambiguous:
    """FAP 10 stands in a set that waits for FAP 4 and in one that is ready; the link of the first one comes first.

    In the second frame a chain stands against the order of the links: one pass does not reach its end.
    """
    table = fit_table(
        [[3], [10], [10], [4], [20], [21]],
        [
            (3, 1, [linear(5.0)]), (0, 2, [linear(7.0)]), (0, 3, [linear(1.0)]), (4, 5, [linear(1.0)]),
            (0, 4, [linear(2.0)]),
        ],
    )  # fmt: skip
    values = {
        "topological": _given({10: 7, 4: 1}, {10: 7, 4: 1, 20: 2, 21: 2}),
        "link-order": _given({10: 5, 4: 1}, {10: 7, 4: 1, 20: 2, 21: None}),
    }
    return Ambiguous(fit(table, frame({3: 1, 4: 1}), frame({3: 1})), "AMB-FIT-3", values=values)
