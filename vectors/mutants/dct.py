"""Mutants of the DCT mode: segments and coefficient documents.

Rules: DCT-1..7, DCT-9..14.
"""

from __future__ import annotations

from .mutant import edit, mutant, value

_DC = "face.dct_syntax:_dc"
_AC = "face.dct_syntax:_ac"
_COEFFICIENT = "face.dct_syntax:_coefficient"
_HIGH = "face.dct_syntax:_high_level"
_VALUES = "face.reconstruct:segment_values"
_READING = "face.dct_transform:Inverse.__init__"
_INVERSE = "face.dct_transform:_inverse"
_ROUND = "face.dct_transform:round_half_away"
_STEP = "face.dct_transform:ac_step"
_BASIS = "face.dct_transform:basis"

mutant(
    "dct.step.dc-ratio-4",
    "The DC step is a quarter of the AC step",
    ["DCT-5"],
    edit(_READING, "reading.dc_step_ratio * reading.dc_divisor", "4 * reading.dc_divisor"),
)
mutant(
    "dct.step.dc-ratio-1",
    "DC and AC have the same step",
    ["DCT-5"],
    edit(_READING, "reading.dc_step_ratio * reading.dc_divisor", "reading.dc_divisor"),
)
mutant(
    "dct.step.quant-0-lossless",
    "fap_quant 0 is a lossless mode: the step is 1",
    ["DCT-5"],
    edit(
        _STEP, "return scale[fap_quant]", "if fap_quant == 0:\n        return Fraction(1)\n    return scale[fap_quant]"
    ),
)
mutant(
    "dct.step.scale-is-quant",
    "fap_quant is the scale itself, not an index",
    ["DCT-5"],
    edit(_STEP, "scale[fap_quant] *", "max(fap_quant, 1) *"),
)
mutant(
    "dct.step.scale-index-base-1",
    "The scale list is indexed from 1",
    ["DCT-5"],
    edit(_STEP, "scale[fap_quant] *", "scale[max(fap_quant - 1, 0)] *"),
)
mutant(
    "dct.step.base-index-base-0",
    "The base steps are indexed by the FAP number, from 0",
    ["DCT-5"],
    edit(_STEP, "fap_dct_base_step()[fap - 1]", "fap_dct_base_step()[min(fap, 67)]"),
)
mutant(
    "dct.step.base-in-integers",
    "Base steps are cut to integers",
    ["DCT-5"],
    edit(_STEP, "fap_dct_base_step()[fap - 1]", "int(fap_dct_base_step()[fap - 1])"),
)
mutant(
    "dct.step.is-qp",
    "The step is QP of the arithmetic mode",
    ["DCT-5"],
    edit(
        _STEP,
        "fap_dct_base_step()[fap - 1]",
        "Fraction(__import__('snhc.reference_impl.tables', fromlist=['x']).fap_table()[fap - 1].QP)",
    ),
)
mutant(
    "dct.value.offset-half-a-step",
    "Coefficients are reconstructed half a step away from zero",
    ["DCT-6"],
    edit(
        _INVERSE,
        "value = level * numerator / denominator",
        "value = (level + (0.5 if level > 0 else -0.5)) * numerator / denominator",
    ),
)
mutant(
    "dct.idct.transposed",
    "The inverse transform uses the basis of the forward one: k and t are exchanged",
    ["DCT-7"],
    edit(_BASIS, "m = (2 * t + 1) * k % 64", "m = (2 * k + 1) * t % 64"),
)
mutant(
    "dct.idct.dc-factor",
    "The DC coefficient has the factor of the others",
    ["DCT-7"],
    edit("face.dct_transform:DctReading.dc_divisor", "return 4 if", "return 2 if"),
)
mutant(
    "dct.idct.unnormalised",
    "The transform is scaled by 2/16, not orthonormal",
    ["DCT-7"],
    edit(_BASIS, 'if normalisation == "orthonormal":', "if False:"),
    edit(
        "face.dct_transform:DctReading.dc_divisor",
        'return 4 if self.normalisation == "orthonormal" else 16',
        "return 16",
    ),
)
mutant(
    "dct.idct.last-coefficient-dropped",
    "The last coefficient is not used",
    ["DCT-7"],
    edit(_INVERSE, "for k in range(1, SEGMENT_FRAMES):", "for k in range(1, SEGMENT_FRAMES - 1):"),
)
mutant(
    "dct.idct.reversed",
    "The instants of a segment come out last first",
    ["DCT-7"],
    edit(
        "face.dct_transform:block_values",
        "_inverse(blocks, at, dc, numerator, denominator, inverse)",
        "_inverse(blocks, at, dc, numerator, denominator, inverse)[::-1]",
    ),
)
mutant(
    "dct.idct.truncated",
    "Values are cut toward zero",
    ["DCT-7"],
    edit(_ROUND, "rest = value - float(whole)", "rest = 0.0"),
)
mutant(
    "dct.idct.halves-up",
    "Halves are rounded up, also below zero",
    ["DCT-7", "DCT-8"],
    edit(_ROUND, "rest <= -0.5", "rest < -0.5"),
    survives="a value from a segment may be off by 1 (DCT-8); the reference alone is held to the halves, by unit tests",
)
mutant(
    "dct.idct.halves-to-even",
    "Halves are rounded to the even integer",
    ["DCT-7", "DCT-8"],
    edit(_ROUND, "whole = int(value)", "return round(value)"),
    survives="a value from a segment may be off by 1 (DCT-8); the reference alone is held to the halves, by unit tests",
)
mutant(
    "dct.dc.intra-15-bits",
    "The intra DC has 15 bits",
    ["DCT-2"],
    edit(_DC, "io.s(DC, 16, WIDE if run.dc_escape else run.dc)", "io.s(DC, 15, 0)"),
)
mutant(
    "dct.dc.intra-unsigned",
    "The intra DC is unsigned",
    ["DCT-2"],
    edit(_DC, "value = io.s(DC, 16, WIDE if run.dc_escape else run.dc)", "value = io.u(DC, 16, 0)"),
)
mutant(
    "dct.dc.intra-no-escape",
    "-32768 is a value of the intra DC, no escape",
    ["DCT-2"],
    edit(_DC, "run.dc_escape = 1 if value == WIDE else 0", "run.dc_escape = 0"),
)
mutant(
    "dct.dc.intra-escape-32-bits",
    "The escaped intra DC has 32 bits",
    ["DCT-2"],
    edit(_DC, "io.s(DC_WIDE, 31, run.dc)", "io.s(DC_WIDE, 32, run.dc)"),
)
mutant(
    "dct.dc.inter-as-value",
    "The inter DC is the value, not the difference to the last segment's",
    ["DCT-3"],
    edit(_VALUES, "dc += state.dct_dc[fap]", "pass"),
)
mutant(
    "dct.dc.inter-predicts-from-values",
    "The inter DC is predicted from the last decoded value",
    ["DCT-3", "DCT-13"],
    edit(_VALUES, "dc += state.dct_dc[fap]", "dc += values[fap]"),
)
mutant(
    "dct.dc.predictor-not-updated",
    "Inter DCs are predicted from the last intra segment",
    ["DCT-3"],
    edit(
        _VALUES,
        "state.dct_dc[fap] = dc",
        "state.dct_dc[fap] = dc if is_intra else state.dct_dc[fap]",
    ),
)
mutant(
    "dct.dc.inter-offset-255",
    "Symbols of the DC table count from -255",
    ["DCT-3"],
    edit(_DC, "run.dc = symbol - OFFSET", "run.dc = symbol - OFFSET + 1"),
)
mutant(
    "dct.dc.inter-escape-is-256",
    "The escape of the DC table is symbol 256, as in the AC table",
    ["DCT-3"],
    edit(_DC, "if symbol != DC_ESCAPE:", "if symbol != AC_ESCAPE:"),
)
mutant(
    "dct.dc.inter-escape-31-bits",
    "The wide escape of the inter DC has 31 bits, as the others",
    ["DCT-3"],
    edit(_DC, "io.s(DC_DIFFERENCE_WIDE, 32, run.dc)", "io.s(DC_DIFFERENCE_WIDE, 31, run.dc)"),
)
mutant(
    "dct.dc.inter-escape-is-the-value",
    "What follows the escape of an inter DC is the DC itself, not the difference",
    ["DCT-3"],
    edit(
        _VALUES,
        "dc += state.dct_dc[fap]",
        "dc += 0 if segment.runs[at // SEGMENT].dc_escape else state.dct_dc[fap]",
    ),
)
mutant(
    "dct.dc.not-reset-by-arithmetic",
    "DC predictors are kept over an intra plane: an intra DC is added to them",
    ["DCT-13", "DCT-2"],
    edit(_VALUES, "if not is_intra:", "if True:"),
)
mutant(
    "dct.ac.run-not-counted-on",
    "A run leads to k + run, not behind it",
    ["DCT-4"],
    edit("face.dct_syntax:CoefficientRun.coefficients", "k += run + 1", "k += max(run, 1)"),
)
mutant(
    "dct.ac.run-from-0",
    "The first run counts from index 0: DC has a place among the AC coefficients",
    ["DCT-4"],
    edit(_AC, "k = 0\n", "k = -1\n"),
    edit("face.dct_syntax:CoefficientRun.coefficients", "k = 0\n", "k = -1\n"),
)
mutant(
    "dct.ac.end-behind-index-15",
    "Behind a coefficient at index 15 an end symbol is expected",
    ["DCT-4"],
    edit("face.dct_syntax:_end_follows", 'io.readings.end_after_last == "sent"', "True"),
)
mutant(
    "dct.ac.run-past-end-ends",
    "A run past index 15 ends the segment without an error",
    ["DCT-4"],
    edit(_AC, "io.require(False, _RUN_PAST_END, step, io.tell() - table.bits_of(step), io.tell())", "return"),
)
mutant(
    "dct.ac.run-past-end-late",
    "A run to index 16 is accepted, and its coefficient dropped",
    ["DCT-4"],
    edit(
        _AC,
        "io.require(False, _RUN_PAST_END, step, io.tell() - table.bits_of(step), io.tell())",
        "io.require(k > SEGMENT, _RUN_PAST_END, step, io.tell() - table.bits_of(step), io.tell())\n            "
        "io.vlc(AC, io.profile.ac, 0)\n            return",
    ),
)
mutant(
    "dct.ac.run-past-end-place",
    "A run past the end is reported at the coefficient behind it",
    ["DCT-4", "CNF-21"],
    edit(
        _AC,
        "_RUN_PAST_END, step, io.tell() - table.bits_of(step), io.tell())\n        if reading",
        "_RUN_PAST_END, step, io.tell(), io.tell() + 1)\n        if reading",
    ),
)
mutant(
    "dct.ac.escape-is-0",
    "The escape of the AC table is symbol 0, as in the DC table",
    ["DCT-4"],
    edit(_COEFFICIENT, "if symbol != AC_ESCAPE:", "if symbol != DC_ESCAPE:"),
)
mutant(
    "dct.ac.escape-32-bits",
    "The wide escape of a coefficient has 32 bits",
    ["DCT-4"],
    edit(_COEFFICIENT, "io.s(AC_WIDE, 31, run.levels[i])", "io.s(AC_WIDE, 32, run.levels[i])"),
)
mutant(
    "dct.ac.no-wide-escape",
    "-32768 behind an escape is a value",
    ["DCT-4"],
    edit(_COEFFICIENT, "if value == WIDE:", "if False:"),
)
mutant(
    "dct.ac.escaped-0-refused",
    "An escaped coefficient of 0 ends the segment",
    ["DCT-4"],
    edit(
        _AC,
        "_coefficient(io, profile, run, i)\n        i += 1",
        "_coefficient(io, profile, run, i)\n        if run.levels[i] == 0:\n            return\n        i += 1",
    ),
)
mutant(
    "dct.ac.offset-255",
    "Symbols of the AC table count from -255",
    ["DCT-4"],
    edit(_COEFFICIENT, "run.levels[i] = symbol - OFFSET", "run.levels[i] = symbol - OFFSET + 1"),
)
mutant(
    "dct.order.descending",
    "FAPs of a segment are taken in descending order",
    ["DCT-1"],
    edit(_VALUES, "for fap in selected:", "for fap in selected[::-1]:"),
)
mutant(
    "dct.order.all-dc-first",
    "The DCs of all FAPs are read before their AC coefficients",
    ["DCT-1"],
    edit(
        "face.dct_syntax:dct_segment",
        "_dc(io, profile, run, is_intra)\n        _ac(io, profile, run)",
        "_dc(io, profile, run, is_intra)",
    ),
    edit(
        "face.dct_syntax:dct_segment",
        "for i, fap in enumerate(selected):",
        "for i, fap in enumerate(selected):\n        if i and False:\n            pass",
    ),
    edit(
        "face.dct_syntax:dct_segment",
        "        io.leave()",
        "        io.leave()\n    for run in segment.runs:\n        _ac(io, profile, run)",
    ),
)
mutant(
    "dct.viseme.behind-the-rest",
    "The expression segment comes before the viseme segment",
    ["DCT-1"],
    edit(
        "face.dct_syntax:dct_segment",
        "    if viseme is not None:",
        "    if viseme is not None and expression is not None and io.reading:\n"
        "        flags = [(INIT_FACE, segment.init_face), (EXPRESSION_DEF, segment.expression_def)]\n"
        "        _high_level(io, profile, segment.expression, expression, _EXPRESSION, (0, 1, 2, 3), is_intra, flags)\n"
        "        expression = None\n    if viseme is not None:",
    ),
)
mutant(
    "dct.viseme.intra-all-frames-absolute",
    "In intra segments every instant carries the fields themselves, not differences",
    ["DCT-9", "DCT-10"],
    edit(_HIGH, "if is_intra and t == 0:", "if is_intra:"),
)
mutant(
    "dct.viseme.inter-first-absolute",
    "The first instant of an inter segment carries the fields themselves",
    ["DCT-9", "DCT-10"],
    edit(_HIGH, "if is_intra and t == 0:", "if t == 0:"),
)
mutant(
    "dct.viseme.predicts-from-first",
    "Differences are those to the first instant of the segment",
    ["DCT-9", "DCT-10"],
    edit(_HIGH, "previous = now", "previous = values[0]"),
)
mutant(
    "dct.viseme.predictor-not-kept",
    "The predictor of the first instant of an inter segment is 0",
    ["DCT-9", "DCT-10", "DCT-13"],
    edit("face.reconstruct:keep_high_level", "state.dct_viseme = segment.viseme[-1]", "pass"),
    edit("face.reconstruct:keep_high_level", "state.dct_expression = segment.expression[-1]", "pass"),
)
mutant(
    "dct.viseme.def-once",
    "viseme_def stands only in the first instant of a segment",
    ["DCT-9"],
    edit(_HIGH, "flag[t] = io.u(element, 1, flag[t])", "flag[t] = io.u(element, 1, flag[t]) if t == 0 else flag[0]"),
)
mutant(
    "dct.viseme.blend-5-bits",
    "viseme_blend has 5 bits",
    ["DCT-9"],
    value("face.dct_syntax:_VISEME[2].bits", 6, 5),
)
mutant(
    "dct.viseme.blend-offset",
    "Differences of blend count from -64",
    ["DCT-9"],
    value("face.dct_syntax:_VISEME[2].offset", 63, 64),
)
mutant(
    "dct.expression.order-of-fba-28",
    "Expression fields come in the order of the arithmetic mode",
    ["DCT-10"],
    edit("face.dct_syntax:dct_segment", "_EXPRESSION_ORDER[io.readings.expression_order]", "(0, 2, 1, 3)"),
)
mutant(
    "dct.expression.select-table-of-visemes",
    "Expression selects are read with the table of viseme selects",
    ["DCT-10"],
    value("face.dct_syntax:_EXPRESSION[0].table", "expression_select", "viseme_select"),
    value("face.dct_syntax:_EXPRESSION[1].table", "expression_select", "viseme_select"),
    value("face.dct_syntax:_EXPRESSION[0].offset", 6, 14),
    value("face.dct_syntax:_EXPRESSION[1].offset", 6, 14),
)
mutant(
    "dct.expression.flags-swapped",
    "expression_def is read before init_face",
    ["DCT-10"],
    edit(
        "face.dct_syntax:dct_segment",
        "[(INIT_FACE, segment.init_face), (EXPRESSION_DEF, segment.expression_def)]",
        "[(EXPRESSION_DEF, segment.expression_def), (INIT_FACE, segment.init_face)]",
    ),
)
mutant(
    "dct.highlevel.scaled",
    "Blend and intensities are multiplied by the scale",
    ["DCT-11"],
    edit("face.reconstruct:high_level_instant", 'if state.readings.dct_intensity == "scaled" else 1', "if True else 1"),
)
mutant(
    "dct.highlevel.range-not-checked",
    "Selects, blend and intensities out of range are accepted",
    ["DCT-12"],
    edit(_HIGH, "io.require(0 <= now[i] <= field.largest, field.outside, now[i], start, io.tell())", "pass"),
)
mutant(
    "dct.highlevel.range-of-differences-only",
    "Selects, blend and intensities are checked in the first instant of an intra segment only",
    ["DCT-12"],
    edit(_HIGH, "io.require(0 <= now[i]", "io.require((t > 0 or not is_intra) or 0 <= now[i]"),
)
mutant(
    "dct.highlevel.above-only",
    "Selects, blend and intensities below 0 are accepted",
    ["DCT-12"],
    edit(_HIGH, "0 <= now[i] <= field.largest", "now[i] <= field.largest"),
)
mutant(
    "dct.highlevel.expression-select-15",
    "Expression selects are checked against 15",
    ["DCT-12"],
    value("face.dct_syntax:_EXPRESSION[0].largest", 6, 15),
    value("face.dct_syntax:_EXPRESSION[1].largest", 6, 15),
)
mutant(
    "dct.highlevel.wraps",
    "Selects, blend and intensities wrap around",
    ["DCT-12"],
    edit(
        _HIGH,
        "now[i] = previous[i] + symbol - field.offset",
        "now[i] = (previous[i] + symbol - field.offset) % (field.largest + 1)",
    ),
)
mutant(
    "dct.time.one-period-per-segment",
    "A segment takes one frame period",
    ["DCT-13", "FBA-38"],
    edit("face.reconstruct:reconstruct", "state.clock.span(len(frames) - 1)", "pass"),
)
mutant(
    "dct.time.fifteen-periods",
    "A segment takes 15 frame periods",
    ["DCT-13"],
    edit("face.reconstruct:reconstruct", "state.clock.span(len(frames) - 1)", "state.clock.span(len(frames) - 2)"),
)
mutant(
    "dct.time.same-for-all",
    "All 16 instants have the time of the plane",
    ["DCT-13"],
    edit("face.reconstruct:reconstruct", "state.clock.after(time, t)", "time"),
)
mutant(
    "dct.time.skip-per-instant",
    "Skipped frames lie between the instants of a segment",
    ["DCT-13"],
    edit(
        "face.reconstruct:reconstruct",
        "state.clock.after(time, t)",
        "state.clock.after(time, t * (header.number_of_frames_to_skip + 1))",
    ),
)
mutant(
    "dct.states.transmitted-once",
    "Only the first instant of a segment is T, the others R",
    ["DCT-14", "FBA-34"],
    edit(
        "face.reconstruct:reconstruct",
        "_frame(state, plane, state.clock.after(time, t), shown, letters,",
        "_frame(state, plane, state.clock.after(time, t), shown, letters if t == 0 else state.letters_without,",
    ),
)
mutant(
    "dct.switch.coding-type-not-kept",
    "Inter planes are always arithmetic",
    ["FBA-12", "FBA-15"],
    edit(
        "face.syntax:fap_levels",
        "if state.faps.coding_type != ARITHMETIC:",
        "if is_intra and state.faps.coding_type != ARITHMETIC:",
    ),
)
mutant(
    "dct.switch.limits-lost",
    "A DCT intra plane resets the limits to the defaults",
    ["FBA-19", "DCT-13"],
    edit(
        "face.syntax:fap_data_header",
        "faps.has_intra = True",
        "if data.coding_type != ARITHMETIC:\n"
        "        faps.limits = [list(defaults) for defaults in faps.parameters.defaults]\n    faps.has_intra = True",
    ),
)
mutant(
    "dct.switch.ranges-in-dct",
    "The flags of the range lists stand before a DCT segment too",
    ["FBA-13", "FBA-12"],
    edit(
        "face.syntax:fap_data_header",
        "if data.coding_type == ARITHMETIC:",
        "if data.coding_type != ARITHMETIC:\n        for _ in range(4):\n"
        "            io.u(FBA_OBJECT_CODING_TYPE, 1, 0)\n    if data.coding_type == ARITHMETIC:",
    ),
)
mutant(
    "dct.finding.non-canonical",
    "Escapes without need are taken in silence",
    ["DCT-3", "DCT-4", "CNF-23"],
    edit("face.dct_syntax:_canonical", "if not ok:", "if False:"),
    findings=True,
)
mutant(
    "dct.finding.non-canonical-always",
    "Every escaped coefficient is reported",
    ["DCT-4", "CNF-23"],
    edit(_COEFFICIENT, "held = -32767 <= value <= 32767", "held = True"),
    findings=True,
)
mutant(
    "dct.finding.provisional",
    "Provisional tables are not reported",
    ["DCT-1", "CNF-23"],
    edit("face.syntax:fap_levels", "if io.profile.provisional and not state.seen_dct:", "if False:"),
    findings=True,
)
mutant(
    "dct.document.inter-as-value",
    "The inter DC of a coefficient document is the value",
    ["DCT-3"],
    edit("face.coefficients:_decode_segment", "dc += last_dc[fap]", "pass"),
)
mutant(
    "dct.document.unset-not-retained",
    "A FAP that a later segment does not send is U",
    ["DCT-13"],
    edit("face.coefficients:decode_document", '"U" if held[fap - 1] is None else "R"', '"U"'),
)
mutant(
    "dct.document.rate-25",
    "Documents run at 25 Hz",
    ["DCT-13"],
    value("face.coefficients:FRAME_RATE", 30, 25),
)
mutant(
    "dct.document.inter-first-accepted",
    "A document may begin with an inter segment",
    ["DCT-13"],
    edit("face.coefficients:_decode_segment", "if first and not segment.intra:", "if False:"),
    edit("face.coefficients:_decode_segment", "if fap not in last_dc:", "if fap not in last_dc and not first:"),
    edit("face.coefficients:_decode_segment", "dc += last_dc[fap]", "dc += last_dc.get(fap, 0)"),
)
mutant(
    "dct.document.never-sent-from-0",
    "A FAP that was never sent is predicted from 0",
    ["DCT-13"],
    edit("face.coefficients:_decode_segment", "if fap not in last_dc:", "if False:"),
    edit("face.coefficients:_decode_segment", "dc += last_dc[fap]", "dc += last_dc.get(fap, 0)"),
)
mutant(
    "dct.document.short-lists-padded",
    "Lists of fewer than 16 coefficients are filled with zeros",
    ["DCT-1"],
    edit(
        "face.coefficients:_segment",
        "if len(array) != SEGMENT_FRAMES:",
        "array = [*array, *[0] * (16 - len(array))]\n        if len(array) != SEGMENT_FRAMES:",
    ),
)
mutant(
    "dct.document.quant-32",
    "fap_quant 32 is accepted",
    ["DCT-5"],
    edit("face.coefficients:parse_document", '"DCT-5", 0, 31)', '"DCT-5", 0, 63)'),
    edit(
        _STEP,
        "if not 0 <= fap_quant < len(scale):",
        "fap_quant = min(fap_quant, 31)\n    if not 0 <= fap_quant < len(scale):",
    ),
)
