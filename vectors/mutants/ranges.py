"""Mutants of limits: lists, defaults, division, what is kept.

Rules: FBA-13, FBA-16..20.
"""

from __future__ import annotations

from .mutant import edit, mutant, value

_LISTS = "face.syntax:new_minmax"
_RANGES = "face.state:ParameterState.set_ranges"

mutant(
    "fba.range.markers-per-list",
    "Markers of a list are counted over the whole list, not from the start of each group",
    ["FBA-16"],
    edit(_LISTS, "limits = data.limits[which]", "limits = data.limits[which]\n        count = -1"),
    edit(
        _LISTS,
        "if position & 3 == 0:",
        "count += 1\n                if count & 3 == 0:",
    ),
)
mutant(
    "fba.range.markers-selected-only",
    "A marker stands only before FAPs that are selected",
    ["FBA-16"],
    edit(_LISTS, "if position & 3 == 0:", "if position & 3 == 0 and number in selected:"),
)
mutant(
    "fba.range.markers-not-in-empty-groups",
    "Groups of mask type 0 are left out of the lists, with their markers",
    ["FBA-16"],
    edit(
        _LISTS,
        "for position, number in enumerate(group):",
        "for position, number in enumerate(group if selected & set(group) else ()):",
    ),
)
mutant(
    "fba.range.markers-behind",
    "The marker stands behind every 4th FAP, not before it",
    ["FBA-16"],
    edit(_LISTS, "if position & 3 == 0:", "if position & 3 == 3:"),
)
mutant(
    "fba.range.markers-every-8",
    "A marker stands before every 8th FAP",
    ["FBA-16"],
    edit(_LISTS, "position & 3 == 0", "position & 7 == 0"),
)
mutant(
    "fba.range.marker-not-checked",
    "Markers of the lists are passed over unread",
    ["FBA-16", "CNF-7"],
    edit(_LISTS, "io.marker(parameters.limit_marker)", "io.u(element, 1, 1)"),
)
mutant(
    "fba.range.all-faps-sent",
    "A limit is read for every FAP of the lists, whether or not it is selected",
    ["FBA-16"],
    edit(_LISTS, "if number in selected:", "if True:"),
)
mutant(
    "fba.range.order-of-lists",
    "The lists are taken in the order minimum, maximum",
    ["FBA-13", "FBA-16"],
    edit(_RANGES, "i_max, i_min, p_max, p_min = self.in_force", "i_min, i_max, p_min, p_max = self.in_force"),
    edit(
        _RANGES, "Model(i_min[number], i_max[number], False)", "Model(-abs(i_min[number]), abs(i_max[number]), False)"
    ),
    edit(_RANGES, "Model(p_min[number], p_max[number], True)", "Model(-abs(p_min[number]), abs(p_max[number]), True)"),
)
mutant(
    "fba.range.intra-for-inter",
    "The limits of intra values are used for inter values as well",
    ["FBA-16", "FBA-18"],
    edit(_RANGES, "Model(p_min[number], p_max[number], True)", "Model(i_min[number], i_max[number], True)"),
)
mutant(
    "fba.range.unit-64",
    "A limit counts 64, not 60",
    ["FBA-16"],
    value("face.state:LIMIT_UNIT", 60, 64),
)
mutant(
    "fba.range.symmetric",
    "The lower limit is the upper one with its sign changed",
    ["FBA-16"],
    edit(
        _RANGES,
        "i_max, i_min, p_max, p_min = self.in_force",
        "i_max, i_min, p_max, p_min = self.in_force\n        i_min, p_min = [-v for v in i_max], [-v for v in p_max]",
    ),
)
mutant(
    "fba.range.not-divided",
    "Limits are not divided by fap_quant",
    ["FBA-17"],
    edit(_RANGES, "divisor = self.scale if self.scale else 1", "divisor = 1"),
)
mutant(
    "fba.range.divided-by-floor",
    "Lower limits are divided with rounding down instead of toward zero",
    ["FBA-17"],
    edit(_RANGES, "limit // divisor if limit >= 0 else -(-limit // divisor)", "limit // divisor"),
)
mutant(
    "fba.range.divided-outward",
    "Limits are divided with rounding away from zero",
    ["FBA-17"],
    edit(
        _RANGES,
        "limit // divisor if limit >= 0 else -(-limit // divisor)",
        "-(-limit // divisor) if limit >= 0 else limit // divisor",
    ),
)
mutant(
    "fba.range.divided-by-step",
    "Limits are divided by the step of the FAP",
    ["FBA-17"],
    edit(_RANGES, "limit = limits[number]", "limit = limits[number] // self.parameters.base_steps[number]"),
)
mutant(
    "fba.range.default-1000",
    "Default ranges are +-1000, not the table",
    ["FBA-18"],
    edit(
        _RANGES,
        "limit = limits[number]",
        "limit = limits[number] if data.new[which] else (1000, -1000, 1000, -1000)[which]",
    ),
)
mutant(
    "fba.range.default-not-rounded",
    "Default limits are not rounded to multiples of 60",
    ["FBA-18"],
    edit("face.parameters:outward", "return v * LIMIT_UNIT if limit > 0 else -v * LIMIT_UNIT", "return limit"),
)
mutant(
    "fba.range.default-rounded-inward",
    "Default limits are rounded toward zero",
    ["FBA-18"],
    edit("face.parameters:outward", "-(-abs(limit) // LIMIT_UNIT)", "abs(limit) // LIMIT_UNIT"),
)
mutant(
    "fba.range.default-one-directional",
    "One-directional FAPs are given a lower limit of 0",
    ["FBA-18"],
    edit("face.parameters:_fap_set", "fap.i_min, fap.i_max", "0 if fap.direction == 'U' else fap.i_min, fap.i_max"),
)
mutant(
    "fba.range.default-47-wide",
    "The default range of FAP 47 is 1080/420",
    ["FBA-18"],
    edit("face.parameters:_fap_set", 'if range_47 == "wide":', "if True:"),
)
mutant(
    "fba.range.table-fap-3",
    "A slip in the table of default limits: 1800 of FAP 3 for 1080",
    ["FBA-18"],
    value("tables:fap_table()[2].i_max", 1080, 1800),
)
mutant(
    "fba.range.table-fap-61",
    "A slip in the table of default limits: FAP 61's row is that of the FAP above it",
    ["FBA-18"],
    value("tables:fap_table()[60].i_max", 540, 1080),
    value("tables:fap_table()[60].i_min", -540, -1080),
)
mutant(
    "fba.range.kept-divided",
    "Limits that are not sent again are kept divided by the old fap_quant",
    ["FBA-19"],
    edit(_RANGES, 'kept = readings.limits_after_quant == "kept"', "kept = True"),
)
mutant(
    "fba.range.not-kept",
    "Limits that an intra plane does not send go back to the defaults",
    ["FBA-19"],
    edit(
        _RANGES,
        "sent = data.new[which]",
        "sent = data.new[which]\n            limits[:] = self.parameters.defaults[which]",
    ),
)
mutant(
    "fba.range.kept-for-the-list",
    "A list that is sent sets the limits of all FAPs, those that are not selected to the defaults",
    ["FBA-19"],
    edit(
        _RANGES,
        "unit = SIGNS[which] * LIMIT_UNIT",
        "unit = SIGNS[which] * LIMIT_UNIT\n                limits[:] = self.parameters.defaults[which]",
    ),
)
mutant(
    "fba.range.zero-means-never-sent",
    "A limit sent as 0 is taken for: never sent, and all limits of the list go back to the defaults",
    ["FBA-19", "FBA-20"],
    edit(
        _RANGES,
        "limits[number] = v[number] * unit",
        "limits[number] = v[number] * unit\n                if 0 in [limits[number] for number in self.selected]:\n"
        "                    limits[:] = self.parameters.defaults[which]",
    ),
)
mutant(
    "fba.range.quant-0-divides-by-32",
    "fap_quant 0 divides the limits by 32",
    ["FBA-17"],
    edit(_RANGES, "divisor = self.scale if self.scale else 1", "divisor = self.scale if self.scale else 32"),
)
mutant(
    "fba.range.empty-costs-bits",
    "A range of one value is taken to cost a bit: the symbol is decoded from two",
    ["FBA-20"],
    edit(
        _RANGES,
        "Model(i_min[number], i_max[number], False)",
        "Model(i_min[number], max(i_max[number], i_min[number] + 1), False)",
    ),
)
mutant(
    "fba.range.flags-once",
    "The flags of intra limits are used for the inter lists too",
    ["FBA-13"],
    edit(_LISTS, "if not data.new[which]:", "if not data.new[which & 1]:"),
)
