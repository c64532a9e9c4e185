"""Mutants of BAP data.

Rules: FBA-40.
"""

from __future__ import annotations

from .mutant import edit, mutant

_DATA = "face.syntax:bap_data"
_SET = "face.parameters:_bap_set"

mutant(
    "fba.body.numeric-order",
    "BAPs are coded in the order of their numbers, not group by group",
    ["FBA-40"],
    edit("face.state:ParameterState.select", "self.selected = selected", "self.selected = sorted(selected)"),
)
mutant(
    "fba.body.variant-b",
    "The other set of base steps is used",
    ["FBA-40"],
    edit(_SET, 'bap.base_step if base_step == "base_step" else bap.base_step_variant_b', "bap.base_step_variant_b"),
)
mutant(
    "fba.body.quant-as-scale",
    "bap_quant is the scale itself, not an index",
    ["FBA-40"],
    edit(_SET, "list(bap_quant_scale())", "list(range(32))"),
)
mutant(
    "fba.body.mask-type-2-accepted",
    "bap_mask_type 2 is accepted",
    ["FBA-40"],
    edit(_SET, "rules, groups, groups, (2,)", "rules, groups, groups, ()"),
)
mutant(
    "fba.body.limits-symmetric",
    "Default limits of BAPs are made symmetric",
    ["FBA-40"],
    edit(
        _SET,
        "baps.set_defaults(bap.number, bap.i_min, bap.i_max,",
        "baps.set_defaults(bap.number, -bap.i_max, bap.i_max,",
    ),
)
mutant(
    "fba.body.no-segment-for-none",
    "BAP data is read without the suggested gender",
    ["FBA-40"],
    edit(_DATA, "data.gender = io.u(BAP_SUGGESTED_GENDER, 1, data.gender)", "pass"),
)
mutant(
    "fba.body.values-not-kept",
    "BAPs of inter planes are values, not differences",
    ["FBA-40", "FBA-32"],
    edit(
        "face.reconstruct:reconstruct",
        "parameter_values(state.baps, plane.baps, plane.is_intra, False)",
        "parameter_values(state.baps, plane.baps, 1, False)",
    ),
)
mutant(
    "fba.body.models-of-the-face",
    "I models of BAPs are used for inter planes",
    ["FBA-40", "FBA-30"],
    edit(_DATA, "models = state.i_models if is_intra else state.p_models", "models = state.i_models"),
)
mutant(
    "fba.body.not-read-over",
    "BAP data beside FAP data is not read over",
    ["FBA-40", "FBA-5"],
    edit(
        "face.syntax:fba_object_plane",
        "if mask & 2:\n        data = plane.baps",
        "if mask == 2:\n        data = plane.baps",
    ),
)
mutant(
    "fba.body.faps-retained-lost",
    "A plane with BAP data alone makes all FAPs unset",
    ["FBA-40", "FBA-34"],
    edit(
        "face.reconstruct:reconstruct",
        "return [_frame(state, plane, time, shown_values(state), state.letters_without, baps)]",
        "return [_frame(state, plane, time, shown_values(state), "
        "state.letters_without if baps is None else 'U' * 68, baps)]",
    ),
)
mutant(
    "fba.body.gender-of-the-body",
    "The suggested gender of the body is the line's",
    ["FBA-40"],
    edit(
        "face.reconstruct:_frame",
        "None if header is None else header.gender",
        "None if header is None else (plane.baps or header).gender",
    ),
)
mutant(
    "fba.body.on-every-line-of-a-segment",
    "BAPs beside a DCT segment stand on all 16 lines",
    ["FBA-40", "DCT-13"],
    edit("face.reconstruct:reconstruct", "baps if t == 0 else None", "baps"),
    survives="`baps` is an extra key (CNF-1): where the reference has none comparators do not look at it",
)
mutant(
    "fba.body.quant-0-applies-step",
    "bap_quant 0 applies the base step",
    ["FBA-40", "FBA-31"],
    edit(
        "face.reconstruct:reconstruct",
        "values = state.baps.values",
        "values = [v * s if not state.baps.scale else v for v, s in zip(state.baps.values, "
        "state.baps.parameters.base_steps)]",
    ),
)
mutant(
    "fba.body.limits-undivided",
    "Limits of BAPs are divided by bap_quant, not by its scale",
    ["FBA-40", "FBA-17"],
    edit(
        "face.state:ParameterState.set_ranges",
        "divisor = self.scale if self.scale else 1",
        "divisor = self.quant if self.quant else 1",
    ),
)
