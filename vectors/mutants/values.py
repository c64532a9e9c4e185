"""Mutants of reconstruction: steps, prediction, clipping.

Rules: FBA-31, FBA-32.
"""

from __future__ import annotations

from .mutant import edit, mutant, value

_VALUES = "face.reconstruct:parameter_values"
_STEPS = "face.state:ParameterState.set_steps"

mutant(
    "fba.value.inter-from-zero",
    "Inter values are taken for the values themselves",
    ["FBA-32"],
    edit(_VALUES, "values[number] += level * step", "values[number] = level * step"),
)
mutant(
    "fba.value.intra-adds",
    "Intra values are added to the last ones",
    ["FBA-32"],
    edit(_VALUES, "values[number] = level * step", "values[number] += level * step"),
)
mutant(
    "fba.value.difference-subtracted",
    "Differences are subtracted",
    ["FBA-32"],
    edit(_VALUES, "values[number] += level * step", "values[number] -= level * step"),
)
mutant(
    "fba.value.qp-ignored",
    "The step is fap_quant for every FAP: QP of the table is not used",
    ["FBA-31"],
    edit(_STEPS, "base_steps[number] * self.scale", "self.scale"),
)
mutant(
    "fba.value.quant-ignored",
    "The step is QP of the table whatever fap_quant is",
    ["FBA-31"],
    edit(_STEPS, "base_steps[number] * self.scale if", "base_steps[number] if"),
)
mutant(
    "fba.value.quant-0-applies-qp",
    "fap_quant 0 applies QP of the table",
    ["FBA-31"],
    edit(_STEPS, "if self.scale else 1 for", "if self.scale else base_steps[number] for"),
)
mutant(
    "fba.value.quant-0-zeroes",
    "fap_quant 0 makes every value 0",
    ["FBA-31"],
    edit(_STEPS, "base_steps[number] * self.scale if self.scale else 1", "base_steps[number] * self.scale"),
)
mutant(
    "fba.value.quant-as-power",
    "fap_quant is an exponent: the step doubles with each",
    ["FBA-31", "FBA-9"],
    edit(_STEPS, "base_steps[number] * self.scale if", "base_steps[number] * (1 << self.scale - 1) if"),
)
mutant(
    "fba.value.index-base",
    "The table of QP is read one row off",
    ["FBA-31"],
    edit(_STEPS, "base_steps[number] *", "base_steps[number - 1] *"),
)
mutant(
    "fba.value.table-qp-48",
    "A slip in the table: QP 128 of the head rotations for 170",
    ["FBA-31"],
    value("tables:fap_table()[47].QP", 170, 128),
)
mutant(
    "fba.value.clipped",
    "Values are clipped to the range of the intra limits",
    ["FBA-32"],
    edit(_VALUES, "if clip:", "if True:"),
)
mutant(
    "fba.value.clipped-1080",
    "Values are clipped to +-1080",
    ["FBA-32"],
    edit(
        _VALUES,
        "if clip:",
        "for number in state.selected:\n        values[number] = min(max(values[number], -1080), 1080)\n    if clip:",
    ),
)
mutant(
    "fba.value.sixteen-bits",
    "Values are kept in 16 bits and wrap around",
    ["FBA-32"],
    edit(
        _VALUES,
        "if clip:",
        "for number in state.selected:\n        values[number] = (values[number] + 32768) % 65536 - 32768\n"
        "    if clip:",
    ),
)
mutant(
    "fba.value.unselected-set-to-0",
    "An intra plane sets the FAPs that it does not code to 0",
    ["FBA-32", "FBA-14"],
    edit(_VALUES, "if is_intra:", "if is_intra:\n        values[:] = [0] * len(values)"),
)
mutant(
    "fba.value.predicts-from-level",
    "A new fap_quant rescales the values that are kept",
    ["FBA-32", "FBA-31"],
    edit(
        "face.state:ParameterState.select",
        "self.scale = self.parameters.quant_scale[data.quant]",
        "if self.scale:\n            self.values = [v * (data.quant or 1) // self.scale for v in self.values]\n"
        "        self.scale = self.parameters.quant_scale[data.quant]",
    ),
)
