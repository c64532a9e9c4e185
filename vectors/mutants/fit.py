"""Mutants of FAP interpolation tables.

Rules: FIT-1..7, FIT-9.
"""

from __future__ import annotations

from .mutant import edit, mutant

_SUM = "interpolation.fit:_sum"
_VALUE = "interpolation.fit:function_value"
_LIST = "interpolation.fit:value_list"
_EVALUATE = "interpolation.fit:evaluate"
_INTERPOLATE = "interpolation.fit:interpolate"
_TERMS = "interpolation.fit_table:_Cursor.terms"
_IMPULSE = "interpolation.fit_table:_impulse"
_ORDER = "interpolation.fit_table:_order"
_SETS = "interpolation.fit_table:_sets"
_BUILD = "interpolation.fit_table:build_fit"
_ASSEMBLE = "interpolation.fit_table:_assemble"

mutant(
    "fit.value.zero-to-the-zero",
    "0 to the power of 0 is 0",
    ["FIT-4"],
    edit(_TERMS, "zip(rows, exponents, strict=True) if exponent)", "zip(rows, exponents, strict=True))"),
    edit(
        "interpolation.fit:_power",
        "out = base",
        "if exponent == 0:\n        return 1.0 if base else 0.0\n    out = base",
    ),
)
mutant(
    "fit.value.sum-of-powers",
    "The powers of a term are added, not multiplied",
    ["FIT-4"],
    edit(
        _SUM,
        "product *= _power(values[row], exponent)",
        "product = product * (product != 1.0) + _power(values[row], exponent)",
    ),
)
mutant(
    "fit.value.exponent-off-by-one",
    "Powers are one too high",
    ["FIT-4"],
    edit("interpolation.fit:_power", "range(exponent - 1)", "range(exponent)"),
)
mutant(
    "fit.value.denominator-ignored",
    "The denominator is not used",
    ["FIT-4", "FIT-3"],
    edit(_VALUE, "if function.denominator:", "if False:"),
)
mutant(
    "fit.value.no-denominator-is-0",
    "P = 0 is taken for a denominator of 0",
    ["FIT-3"],
    edit(_VALUE, "if function.denominator:", "if True:"),
)
mutant(
    "fit.value.integer-division",
    "Numerator and denominator are divided as integers",
    ["FIT-4", "FIT-7"],
    edit(_VALUE, "result /= denominator", "result //= denominator"),
)
mutant(
    "fit.value.truncated",
    "Results are cut toward zero",
    ["FIT-7"],
    edit(_VALUE, "round_half_away(result)) + 0.0", "float(trunc(result))) + 0.0"),
)
mutant(
    "fit.value.halves-to-even",
    "Halves are rounded to the even integer",
    ["FIT-7"],
    edit(
        "interpolation.fit:round_half_away",
        "whole = float(trunc(value))",
        "return float(round(value))\n    whole = float(trunc(value))",
    ),
)
mutant(
    "fit.value.halves-up",
    "Halves are rounded up, also below zero",
    ["FIT-7"],
    edit(
        "interpolation.fit:round_half_away",
        "if abs(value - whole) >= 0.5:",
        "if value < 0 and whole - value == 0.5:\n        return whole\n    if abs(value - whole) >= 0.5:",
    ),
)
mutant(
    "fit.value.single-precision",
    "Functions are computed in single precision",
    ["FIT-4"],
    edit(
        _SUM,
        "total += term.coef * product",
        "total = __import__('struct').unpack('f', __import__('struct').pack('f', total + term.coef * product))[0] if "
        "abs(total + term.coef * product) < 1e38 else total + term.coef * product",
    ),
)
mutant(
    "fit.value.clipped",
    "Results are clipped to the range of the FAP",
    ["FIT-7"],
    edit(
        _EVALUATE, "faps[fap - 1] = int(values[fap - 1])", "faps[fap - 1] = min(max(int(values[fap - 1]), -1860), 1860)"
    ),
)
mutant(
    "fit.undefined.zero",
    "A denominator of 0 gives the value 0",
    ["FIT-7"],
    edit(
        _VALUE,
        'if denominator == 0:\n            return 0.0 if readings.undefined == "zero-truncated" else None',
        "if denominator == 0:\n            return 0.0",
    ),
)
mutant(
    "fit.undefined.not-finite-is-0",
    "A result that is not finite gives the value 0",
    ["FIT-7"],
    edit(
        _VALUE,
        'if not isfinite(result):\n        return 0.0 if readings.undefined == "zero-truncated" else None',
        "if not isfinite(result):\n        return 0.0",
    ),
)
mutant(
    "fit.undefined.ends-the-search",
    "Where a function is undefined no other link is tried",
    ["FIT-7"],
    edit(_INTERPOLATE, "if value is None:\n            return False", "if value is None:\n            return True"),
)
mutant(
    "fit.undefined.falls-over",
    "A denominator of 0 is an error",
    ["FIT-7"],
    edit(_VALUE, "if denominator == 0:", "if denominator is None:"),
)
mutant(
    "fit.impulse.base-1",
    "Value numbers of impulses count from 1",
    ["FIT-5"],
    edit(_IMPULSE, 'base = 1 if reading == "from-1" else 0', "base = 1"),
)
mutant(
    "fit.impulse.within-the-fap",
    "Value numbers of impulses count within FAP 1 or 2",
    ["FIT-5"],
    edit(_IMPULSE, 'if reading == "within-fap":', "if True:"),
)
mutant(
    "fit.impulse.ignored",
    "Impulses are read and every term counts",
    ["FIT-5"],
    edit(_SUM, "if term.impulse is not None and", "if False and"),
)
mutant(
    "fit.impulse.inverted",
    "A term counts where the value is not that of the impulse",
    ["FIT-5"],
    edit(_SUM, "!= term.impulse[1]", "== term.impulse[1]"),
)
mutant(
    "fit.impulse.at-least",
    "A term counts where the value is at least that of the impulse",
    ["FIT-5"],
    edit(_SUM, "values[term.impulse[0]] != term.impulse[1]", "values[term.impulse[0]] < term.impulse[1]"),
)
mutant(
    "fit.impulse.range-unchecked",
    "A value number past the parents' values is taken for the last one",
    ["FIT-5", "FIT-9"],
    edit(_IMPULSE, '_impulse_fault(number, f"{base}..{len(rows) + base - 1}", index)', "number = base"),
)
mutant(
    "fit.parent.expression-order",
    "FAP 2 expands to select1, select2, intensity1, intensity2",
    ["FIT-5"],
    edit(
        _LIST,
        "map(float, frame.expression[:4])",
        "map(float, (frame.expression[0], frame.expression[2], frame.expression[1], frame.expression[3]))",
    ),
)
mutant(
    "fit.parent.one-value",
    "A set with FAP 1 is read with the viseme fields in another order: blend first",
    ["FIT-5"],
    edit(_LIST, "map(float, frame.viseme[:3])", "map(float, (frame.viseme[2], frame.viseme[0], frame.viseme[1]))"),
)
mutant(
    "fit.parent.sorted",
    "The FAPs of a parent set are taken in ascending order",
    ["FIT-3", "FIT-5"],
    edit(_TERMS, "rows = [row for fap in parent for row", "rows = [row for fap in sorted(parent) for row"),
)
mutant(
    "fit.parent.any",
    "A link is usable when one FAP of its parent set is available; the others count 0",
    ["FIT-6"],
    edit(_INTERPOLATE, "not all(available[parent - 1]", "not any(available[parent - 1]"),
    edit(
        _SUM,
        "product *= _power(values[row], exponent)",
        "product *= _power(values[row] if values[row] == values[row] else 0.0, exponent)",
    ),
)
mutant(
    "fit.parent.coded-only",
    "Only transmitted FAPs are available, retained ones are not",
    ["FIT-6"],
    edit(_LIST, "letter in AVAILABLE_STATES", 'letter in "TF"'),
)
mutant(
    "fit.parent.given-not-available",
    "FAPs of state F in the input are not available",
    ["FIT-6"],
    edit(_LIST, "letter in AVAILABLE_STATES", 'letter in "TR"'),
)
mutant(
    "fit.child.overwritten",
    "Available FAPs are overwritten by their functions",
    ["FIT-6"],
    edit(_INTERPOLATE, "if available[fap - 1] or not all(", "if fap in given or not all("),
)
mutant(
    "fit.child.last-link-wins",
    "Of several links the last one gives the value",
    ["FIT-2", "FIT-6"],
    edit(_INTERPOLATE, "for link in table.incoming[child])", "for link in table.incoming[child][::-1])"),
)
mutant(
    "fit.child.kept-from-the-frame-before",
    "A FAP that was once given is taken for retained: it is not computed anew",
    ["FIT-6"],
    edit(
        _EVALUATE,
        "faps[fap - 1] = int(values[fap - 1])",
        "faps[fap - 1] = CACHE.setdefault((id(table), fap), (table, int(values[fap - 1])))[1]",
    ),
    edit(
        _EVALUATE,
        "values, available = value_list(frame)",
        "CACHE = evaluate.__dict__.setdefault('cache', {})\n    values, available = value_list(frame)",
    ),
)
mutant(
    "fit.child.state-t",
    "FAPs that the table gives have the state T",
    ["FIT-6", "CNF-2"],
    edit(_EVALUATE, 'state[fap - 1] = "F"', 'state[fap - 1] = "T"'),
)
mutant(
    "fit.order.link-order",
    "Links are taken in the order listed, once",
    ["FIT-6"],
    edit(_INTERPOLATE, 'if readings.order == "link-order":', "if True:"),
)
mutant(
    "fit.order.set-number",
    "Child sets are taken in the order of their numbers",
    ["FIT-6"],
    edit(_ORDER, "placed = set(order)", "order = []\n    placed = set(order)"),
)
mutant(
    "fit.order.one-pass",
    "There is one pass only",
    ["FIT-6"],
    edit(_INTERPOLATE, "changed = len(given) > before", "changed = False"),
)
mutant(
    "fit.order.largest-ready-set",
    "Of several ready sets the one with the largest number comes first",
    ["FIT-6"],
    edit(_ORDER, "child = heappop(ready)", "child = max(ready)\n        ready.remove(child)"),
)
mutant(
    "fit.order.values-at-the-end-of-a-pass",
    "Values become available at the end of a pass",
    ["FIT-6"],
    edit(
        _INTERPOLATE, "        before = len(given)\n", "        before = len(given)\n        there = list(available)\n"
    ),
    edit(
        _INTERPOLATE,
        "any(give(link, place) for link in table.incoming[child])",
        "any(give(link, place) for link in table.incoming[child] if all(there[fap - 1] for fap in "
        "table.sets[link.parent]))",
    ),
)
mutant(
    "fit.table.link-order-of-functions",
    "Functions of a link are listed in the order of FAP numbers",
    ["FIT-3"],
    edit(_ASSEMBLE, "for fap in sets[child]:", "for fap in sorted(sets[child]):"),
)
mutant(
    "fit.table.denominators-first",
    "Denominator terms are taken from the numerator's counts",
    ["FIT-3"],
    edit(
        _ASSEMBLE,
        'denominator.terms(whole["denominatorTerms"][number]',
        'denominator.terms(min(whole["numeratorTerms"][number], whole["denominatorTerms"][number])',
    ),
)
mutant(
    "fit.table.parent-and-child",
    "Graph pairs are (child, parent)",
    ["FIT-2"],
    edit(
        "interpolation.fit_table:_pairs",
        "pairs = list(zip(graph[::2], graph[1::2], strict=True))",
        "pairs = list(zip(graph[1::2], graph[::2], strict=True))",
    ),
)
mutant(
    "fit.table.sets-from-1",
    "Sets are numbered from 1",
    ["FIT-1"],
    edit(
        "interpolation.fit_table:_pairs",
        "pairs = list(zip(graph[::2], graph[1::2], strict=True))",
        "graph = [max(number - 1, 0) for number in graph]\n    pairs = list(zip(graph[::2], graph[1::2], strict=True))",
    ),
)
mutant(
    "fit.error.open-set-accepted",
    "The last set needs no -1",
    ["FIT-1", "FIT-9"],
    edit(
        _SETS,
        "if current:\n        raise",
        "if current:\n        sets.append(tuple(current))\n        starts.append(0)\n    if False:\n        raise",
    ),
)
mutant(
    "fit.error.empty-set-accepted",
    "Empty sets are passed over",
    ["FIT-1", "FIT-9"],
    edit(_SETS, "if not current:", "if not current:\n            continue\n        if False:"),
)
mutant(
    "fit.error.fap-0-accepted",
    "0 in FAPs is passed over",
    ["FIT-1"],
    edit(
        _SETS,
        "if fap == 0 or not -1 <= fap <= 68:",
        "if fap == 0:\n            continue\n        if not -1 <= fap <= 68:",
    ),
)
mutant(
    "fit.error.high-level-child-accepted",
    "FAP 1 and 2 may stand in child sets",
    ["FIT-1", "FIT-9"],
    edit("interpolation.fit_table:_pairs", "if fap in HIGH_LEVEL_VALUES:", "if False:"),
)
mutant(
    "fit.error.half-a-link-dropped",
    "Half a link at the end of Graph is dropped",
    ["FIT-2", "FIT-9"],
    edit(
        "interpolation.fit_table:_pairs",
        "if len(graph) % 2:",
        "graph = graph[: len(graph) // 2 * 2]\n    if len(graph) % 2:",
    ),
)
mutant(
    "fit.error.set-number-class",
    "A set number past the sets is reported as inconsistent",
    ["FIT-2", "FIT-9", "CNF-7"],
    edit("interpolation.fit_table:_pairs", 'raise RangeViolation("FIT-2"', 'raise InconsistentSemantics("FIT-2"'),
)
mutant(
    "fit.error.too-many-accepted",
    "Entries beyond what the terms need are ignored",
    ["FIT-3", "FIT-9"],
    edit("interpolation.fit_table:_length", "if count != expected:", "if count < expected:"),
)
mutant(
    "fit.error.missing-are-0",
    "Missing coefficients count 0",
    ["FIT-3", "FIT-9"],
    edit(
        _BUILD,
        '_length(parts, "numeratorCoefs", sum(k for k, _ in counts))',
        'parts["numeratorCoefs"] = [*parts["numeratorCoefs"], *[0.0] * (sum(k for k, _ in counts) - '
        'len(parts["numeratorCoefs"]))]',
    ),
)
mutant(
    "fit.error.exponent-16",
    "Exponents past 15 are accepted",
    ["FIT-3", "FIT-9"],
    edit("interpolation.fit_table:_ranges", "if not lo <= value <= hi:", "if not lo <= value:"),
)
mutant(
    "fit.error.exponent-15-refused",
    "Exponent 15 is refused",
    ["FIT-3"],
    edit(
        "interpolation.fit_table:_ranges",
        "if not lo <= value <= hi:",
        "if not lo <= value < hi + (hi > 15 or hi < 15):",
    ),
)
mutant(
    "fit.error.set-limit-off-by-one",
    "The limit of sets is one too low",
    ["CNF-22"],
    edit(_SETS, "if len(sets) == limit:", "if len(sets) == limit - 1:"),
)
mutant(
    "fit.error.empty-table-refused",
    "A table without links is refused",
    ["FIT-9", "FIT-1"],
    edit(_BUILD, "_ranges(whole)", "if not pairs:\n        _length(whole, 'numeratorTerms', 1)\n    _ranges(whole)"),
)
