"""Mutants of masks and states of FAPs.

Rules: FBA-9..12, FBA-14, FBA-15, FBA-34.
"""

from __future__ import annotations

from .mutant import edit, mutant

_SELECT = "face.state:ParameterState.select"
_FAPS = "face.state:FaceState.select_faps"
_MASKS = "face.syntax:group_masks"

mutant(
    "fba.mask.highest-first",
    "The first bit of fap_group_mask stands for the highest FAP of the group",
    ["FBA-10"],
    edit(_SELECT, "i if highest_first else last - i", "i"),
)
mutant(
    "fba.mask.type-2-without-mask",
    "Mask type 2 is taken to have no mask",
    ["FBA-10", "FBA-14"],
    edit(_MASKS, "if mask_type in (1, 2):", "if mask_type == 1:"),
)
mutant(
    "fba.mask.type-3-with-mask",
    "Mask type 3 is taken to have a mask",
    ["FBA-10", "FBA-14"],
    edit(_MASKS, "if mask_type in (1, 2):", "if mask_type:"),
)
mutant(
    "fba.mask.type-3-as-none",
    "Mask type 3 is taken for: no FAP of the group is coded",
    ["FBA-14"],
    edit(_SELECT, "if mask_type == 3:", "if mask_type == 0:"),
)
mutant(
    "fba.mask.types-1-and-2-swapped",
    "Mask types 1 and 2 are taken for each other: FAPs with bit 0 are interpolated and kept the wrong way round",
    ["FBA-14", "FBA-34"],
    edit(_FAPS, '"I" if mask_type == 2', '"I" if mask_type == 1'),
)
mutant(
    "fba.mask.type-2-retains",
    "FAPs with bit 0 of mask type 2 keep their value instead of being interpolated",
    ["FBA-14", "FBA-34"],
    edit(_FAPS, '"I" if mask_type == 2', '"I" if mask_type == 4'),
)
mutant(
    "fba.mask.type-0-interpolates",
    "FAPs of a group with mask type 0 are to be interpolated",
    ["FBA-14", "FBA-34"],
    edit(_FAPS, '"I" if mask_type == 2', '"I" if mask_type in (0, 2)'),
)
mutant(
    "fba.mask.type-0-resets",
    "FAPs of a group with mask type 0 lose their value",
    ["FBA-14", "FBA-34"],
    edit(_FAPS, '"R" if decoded[number] else "U"', '"R" if decoded[number] and mask_type else "U"'),
)
mutant(
    "fba.mask.ones-inverted",
    "A mask bit 0 says that the FAP is coded",
    ["FBA-14"],
    edit(_SELECT, "(mask >> (i if highest_first else last - i)) & 1", "mask_type and not (mask >> (last - i)) & 1"),
)
mutant(
    "fba.mask.marker-missing",
    "No marker bit is expected before the mask type of group 1",
    ["FBA-10"],
    edit(_MASKS, "io.marker(parameters.group_marker)", "g and io.marker(parameters.group_marker)"),
)
mutant(
    "fba.mask.marker-not-checked",
    "The marker before the mask type is passed over unread",
    ["FBA-10", "CNF-7"],
    edit(_MASKS, "io.marker(parameters.group_marker)", "io.u(FBA_SUGGESTED_GENDER, 1, 1)"),
)
mutant(
    "fba.mask.group-1-apart",
    "Group 1 is taken to have no mask: type 1 selects both of its FAPs",
    ["FBA-10"],
    edit(_MASKS, "if mask_type in (1, 2):", "if mask_type in (1, 2) and (g or len(group) != 2):"),
)
mutant(
    "fba.mask.group-size",
    "FAP 31 to 38 and 39 to 42 are counted as one group too short: group 4 has seven FAPs",
    ["FBA-14"],
    edit(
        _MASKS,
        "io.u(parameters.group_mask, len(group), data.group_mask[g])",
        "io.u(parameters.group_mask, len(group) - (g == 3), data.group_mask[g])",
    ),
)
mutant(
    "fba.mask.not-kept",
    "The masks are forgotten behind the intra plane: inter planes code every FAP that was ever coded",
    ["FBA-15"],
    edit(
        _FAPS,
        "faps.selected = [number for number in selected if number > 2]",
        "faps.selected = [number for number in range(3, 69) if decoded[number]]",
    ),
)
mutant(
    "fba.mask.quant-not-kept",
    "fap_quant of an intra plane is added to the last one",
    ["FBA-9", "FBA-15"],
    edit(
        _SELECT,
        "self.scale = self.parameters.quant_scale[data.quant]",
        "self.scale = self.parameters.quant_scale[(data.quant + self.scale) % 32]",
    ),
)
mutant(
    "fba.mask.gender-before-masks",
    "The suggested gender is read with the wrong meaning: 0 male",
    ["FBA-11"],
    edit(
        "face.syntax:fap_data_header",
        "data.gender = io.u(FBA_SUGGESTED_GENDER, 1, data.gender)",
        "data.gender = 1 - io.u(FBA_SUGGESTED_GENDER, 1, data.gender)",
    ),
)
mutant(
    "fba.mask.coding-type-before-gender",
    "The coding type is read before the suggested gender",
    ["FBA-11", "FBA-12"],
    edit(
        "face.syntax:fap_data_header",
        "data.gender = io.u(FBA_SUGGESTED_GENDER, 1, data.gender)\n"
        "    data.coding_type = io.u(FBA_OBJECT_CODING_TYPE, 1, data.coding_type)",
        "data.coding_type = io.u(FBA_OBJECT_CODING_TYPE, 1, data.coding_type)\n"
        "    data.gender = io.u(FBA_SUGGESTED_GENDER, 1, data.gender)",
    ),
)
mutant(
    "fba.state.coded-stays-transmitted",
    "A coded FAP stays T over planes without FAP data",
    ["FBA-34"],
    edit(_FAPS, 'self.letters_with_data.replace("T", "R")', "self.letters_with_data"),
)
mutant(
    "fba.state.interpolated-becomes-retained",
    "A FAP to be interpolated becomes R over planes without FAP data",
    ["FBA-34"],
    edit(
        _FAPS, 'self.letters_with_data.replace("T", "R")', 'self.letters_with_data.replace("T", "R").replace("I", "R")'
    ),
)
mutant(
    "fba.state.never-decoded-retained",
    "A FAP that was never decoded is R with the value 0",
    ["FBA-34"],
    edit(_FAPS, '"R" if decoded[number] else "U"', '"R"'),
    edit(
        _FAPS,
        "for number in selected:\n            decoded[number] = True",
        "for number in range(1, 69):\n            decoded[number] = True",
    ),
)
mutant(
    "fba.state.interpolated-with-value",
    "A FAP to be interpolated is printed with its last value",
    ["FBA-34"],
    edit(_FAPS, 'in "TR"]', 'in "TRI" and decoded[number]]'),
)
mutant(
    "fba.state.interpolated-forgets",
    "A FAP that returns from I is U: its last value is forgotten",
    ["FBA-34"],
    edit(
        _FAPS,
        "letters[number - 1] = ",
        "decoded[number] = decoded[number] and mask_type != 2\n            letters[number - 1] = ",
    ),
)
mutant(
    "fba.state.intra-resets",
    "An intra plane resets every FAP that it does not code to U",
    ["FBA-34", "FBA-14"],
    edit(_FAPS, "decoded = faps.decoded\n", "decoded = faps.decoded = [False] * 69\n"),
)
mutant(
    "fba.state.retained-not-printed",
    "Only transmitted values are printed",
    ["FBA-34"],
    edit(_FAPS, 'in "TR"]', 'in "T"]'),
)
mutant(
    "fba.state.viseme-interpolated-shown",
    "FAP 1 and 2 are printed although they are to be interpolated",
    ["FBA-34"],
    edit("face.reconstruct:shown_viseme", 'or letters[0] == "I"', "or False"),
    edit("face.reconstruct:shown_expression", 'or letters[1] == "I"', "or False"),
)
mutant(
    "fba.state.viseme-not-retained",
    "FAP 1 is null in planes that do not code it",
    ["FBA-34"],
    edit("face.reconstruct:shown_viseme", 'letters[0] == "I"', 'letters[0] != "T"'),
)
mutant(
    "fba.state.expression-not-retained",
    "FAP 2 is null in planes that do not code it",
    ["FBA-34"],
    edit("face.reconstruct:shown_expression", 'letters[1] == "I"', 'letters[1] != "T"'),
)
mutant(
    "fba.state.left-right-copy",
    "Left and right FAPs are copied from each other in the output, whatever the mask type",
    ["FBA-34", "FBA-14"],
    edit(
        "face.reconstruct:shown_values",
        "return tuple(out)",
        "for a, b in ((19, 20), (21, 22), (29, 30), (31, 32), (33, 34), (35, 36), (37, 38), (39, 40), (41, 42)):\n"
        "        if out[a - 1] is None:\n            out[a - 1] = out[b - 1]\n    return tuple(out)",
    ),
)
mutant(
    "fba.state.index-base-1",
    "Lines are numbered from 1",
    ["CNF-1"],
    edit("face.state:FaceState.__init__", "self.index = 0", "self.index = 1"),
)
