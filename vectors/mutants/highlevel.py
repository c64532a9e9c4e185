"""Mutants of FAP 1 and 2 in the arithmetic mode.

Rules: FBA-28, FBA-29, FBA-31..33.
"""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import RangeViolation, ReservedValue

from .mutant import edit, mutant, value

_LEVELS = "face.syntax:fap_levels"
_VALUES = "face.reconstruct:high_level_values"
_LIMITS = "face.parameters:high_level_limits"
_SHOWN = "face.reconstruct:shown_expression"

mutant(
    "fba.highlevel.m-truncated",
    "M is 63/q instead of (63 + q/2)/q",
    ["FBA-29"],
    edit(_LIMITS, "(63 + fap_quant // 2) // fap_quant", "63 // fap_quant"),
)
mutant(
    "fba.highlevel.m-rounded-up",
    "M is 63/q rounded up",
    ["FBA-29"],
    edit(_LIMITS, "(63 + fap_quant // 2) // fap_quant", "-(-63 // fap_quant)"),
)
mutant(
    "fba.highlevel.m-kept",
    "M of the previous fap_quant is kept",
    ["FBA-29", "FBA-30"],
    edit(
        "face.state:FaceState.set_high_level_models",
        "high_level_limits(self.faps.quant)",
        "high_level_limits(self.faps.quant)  # unused",
    ),
    edit(
        "face.state:FaceState.set_high_level_models",
        "self.high_i_models =",
        "self.high_i_models = self.high_i_models or",
    ),
    edit(
        "face.state:FaceState.set_high_level_models",
        "self.high_p_models = [",
        "self.high_p_models = [Model(m.lo, m.lo + m.n - 1, True) for m in self.high_p_models] or [",
    ),
)
mutant(
    "fba.highlevel.m-64",
    "Without a quantiser M is 64",
    ["FBA-29"],
    edit(_LIMITS, "if fap_quant else 63", "if fap_quant else 64"),
)
mutant(
    "fba.highlevel.selects-one-short",
    "Viseme selects are 0..13",
    ["FBA-29"],
    value("tables:viseme_expression_symbols()[0].i_max", "14", "13"),
    value("tables:viseme_expression_symbols()[1].i_max", "14", "13"),
)
mutant(
    "fba.highlevel.expression-select-14",
    "Expression selects have the range of viseme selects",
    ["FBA-29"],
    value("tables:viseme_expression_symbols()[3].i_max", "6", "14"),
    value("tables:viseme_expression_symbols()[5].i_max", "6", "14"),
)
mutant(
    "fba.highlevel.inter-selects-0-to-14",
    "Differences of selects have the range of the selects themselves",
    ["FBA-29"],
    value("tables:viseme_expression_symbols()[0].p_min", "-14", "0"),
    value("tables:viseme_expression_symbols()[1].p_min", "-14", "0"),
)
mutant(
    "fba.highlevel.select-quantised",
    "Selects are multiplied by fap_quant",
    ["FBA-31"],
    edit(_VALUES, "level * step if quantised[first + i] else level", "level * step"),
)
mutant(
    "fba.highlevel.blend-not-quantised",
    "Blend and intensities are not multiplied by fap_quant",
    ["FBA-31"],
    edit(_VALUES, "level * step if quantised[first + i] else level", "level"),
)
mutant(
    "fba.highlevel.quant-0",
    "fap_quant 0 makes blend and intensities 0",
    ["FBA-31"],
    edit(_VALUES, "step = state.faps.quant if state.faps.quant else 1", "step = state.faps.quant"),
)
mutant(
    "fba.highlevel.clipped",
    "Blend and intensities are clipped to 0..63 in the decoder",
    ["FBA-32"],
    edit(_VALUES, "if clip and quantised[first + i]:", "if quantised[first + i]:"),
)
mutant(
    "fba.highlevel.inter-not-predicted",
    "FAP 1 and 2 of inter planes are values, not differences",
    ["FBA-32"],
    edit(_VALUES, "if not is_intra:", "if False:"),
)
mutant(
    "fba.highlevel.select-not-predicted",
    "Selects of inter planes are values, not differences",
    ["FBA-32"],
    edit(_VALUES, "if not is_intra:", "if not is_intra and quantised[first + i]:"),
)
mutant(
    "fba.highlevel.expression-fields-swapped",
    "Expression fields are taken in the order select1, select2, intensity1, intensity2",
    ["FBA-28"],
    edit(
        _SHOWN,
        "return select1, intensity1, select2, intensity2, init_face",
        "return select1, select2, intensity1, intensity2, init_face",
    ),
)
mutant(
    "fba.highlevel.expressions-exchanged",
    "First and second expression are exchanged",
    ["FBA-28"],
    edit(
        _SHOWN,
        "return select1, intensity1, select2, intensity2, init_face",
        "return select2, intensity2, select1, intensity1, init_face",
    ),
)
mutant(
    "fba.highlevel.flags-swapped",
    "init_face and expression_def are exchanged",
    ["FBA-28", "FBA-33"],
    edit(
        _SHOWN,
        "return select1, intensity1, select2, intensity2, init_face, definition",
        "return select1, intensity1, select2, intensity2, definition, init_face",
    ),
)
mutant(
    "fba.highlevel.viseme-def-before",
    "viseme_def is read before the viseme segment",
    ["FBA-28"],
    edit(
        _LEVELS,
        "start = io.tell()\n        data.viseme = _segment",
        "data.viseme_def = io.u(VISEME_DEF, 1, 0)\n        start = io.tell()\n        data.viseme = _segment",
    ),
    edit(_LEVELS, "data.viseme_def = io.u(VISEME_DEF, 1, data.viseme_def)", "pass"),
)
mutant(
    "fba.highlevel.one-segment",
    "FAP 1 and 2 have no segments of their own: their symbols are the first of the one segment of the plane",
    ["FBA-28"],
    edit(
        _LEVELS,
        "data.viseme = _segment(io, VISEME_SEGMENT, high[:3], VISEME_LABELS, data.viseme, data.tails, 0)",
        "data.viseme = _segment(io, VISEME_SEGMENT, high[:3], VISEME_LABELS, data.viseme, data.tails, 0)\n"
        "        io.cursor.seek(io.tell() - 2)",
    ),
)
mutant(
    "fba.highlevel.no-segment-for-the-rest",
    "With FAP 1 or 2 and no other FAP the last segment is left out",
    ["FBA-28"],
    edit(
        _LEVELS,
        "data.levels = _segment(io, FAP_SEGMENT,",
        "if not models and (state.has_viseme or state.has_expression):\n        return\n"
        "    data.levels = _segment(io, FAP_SEGMENT,",
    ),
)
mutant(
    "fba.highlevel.select-not-checked",
    "A select that leaves its range is accepted",
    ["FBA-32"],
    edit(
        "face.syntax:_check_high_level",
        "io.require(0 <= values[i] <= LARGEST_SELECT[fap], _SELECT[fap], values[i], start, io.tell())",
        "pass",
    ),
)
mutant(
    "fba.highlevel.select-checked-above-only",
    "A select below 0 is accepted",
    ["FBA-32"],
    edit("face.syntax:_check_high_level", "0 <= values[i] <= LARGEST_SELECT[fap]", "values[i] <= LARGEST_SELECT[fap]"),
)
mutant(
    "fba.highlevel.select-checked-as-viseme",
    "An expression select is checked against 14",
    ["FBA-32"],
    edit("face.syntax:_check_high_level", "0 <= values[i] <= LARGEST_SELECT[fap]", "0 <= values[i] <= 14"),
)
mutant(
    "fba.highlevel.select-class",
    "A select out of range is reported as a reserved value",
    ["FBA-32", "CNF-7"],
    value("face.syntax:_SELECT[1].error", RangeViolation, ReservedValue),
    value("face.syntax:_SELECT[2].error", RangeViolation, ReservedValue),
)
mutant(
    "fba.highlevel.models-not-reset",
    "The P models of FAP 1 and 2 are not reset by an intra plane",
    ["FBA-30"],
    edit(
        "face.state:FaceState.set_high_level_models",
        "self.high_p_models = [Model(lo, hi, True) for lo, hi in inter]",
        "kept = self.high_p_models\n"
        "        self.high_p_models = [m if (m.lo, m.n) == (lo, hi - lo + 1) else Model(lo, hi, True) for m, (lo, "
        "hi) in zip(kept or [Model(0, 0, True)] * 7, inter)]",
    ),
)
mutant(
    "fba.highlevel.models-do-not-adapt",
    "The P models of FAP 1 and 2 do not adapt",
    ["FBA-24", "FBA-29"],
    edit("face.state:FaceState.set_high_level_models", "Model(lo, hi, True)", "Model(lo, hi, False)"),
)
mutant(
    "fba.highlevel.intensity-not-reported",
    "Blend and intensities out of 0..63 are not reported",
    ["FBA-32", "CNF-23"],
    edit("face.syntax:_check_high_level", "if not 0 <= values[i] <= 63:", "if False:"),
    findings=True,
)
mutant(
    "fba.highlevel.intensity-below-not-reported",
    "Blend and intensities below 0 are not reported",
    ["FBA-32", "CNF-23"],
    edit("face.syntax:_check_high_level", "if not 0 <= values[i] <= 63:", "if values[i] > 63:"),
    findings=True,
)
