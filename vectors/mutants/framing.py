"""Mutants of the framing of FBA objects: start codes, stuffing, the end.

Rules: FBA-1..5, FBA-35, FBA-41, FBA-42, FBA-44.
"""

from __future__ import annotations

from .mutant import edit, mutant

_OBJECT = "face.syntax:fba_object"
_BOUNDARY = "syntax.reader:Reader.boundary"

mutant(
    "fba.framing.stuffing-not-checked",
    "Stuffing bits are not checked: wherever a start code follows the byte boundary, the object ends, so that a last "
    "plane of fewer than 8 bits is dropped",
    ["FBA-3"],
    edit(_BOUNDARY, "cursor.peek(width) == MASKS[width - 1] and cursor.has(width)", "cursor.has(width)"),
)
mutant(
    "fba.framing.stuffing-of-ones",
    "Stuffing is taken for 1 bits only, without the 0 before them",
    ["FBA-3"],
    edit(_BOUNDARY, "MASKS[width - 1]", "MASKS[width]"),
)
mutant(
    "fba.framing.no-stuffing-when-aligned",
    "At a byte boundary no stuffing is expected, although a whole byte 0x7F stands there",
    ["FBA-3"],
    edit(_BOUNDARY, "width = 8 - (bit & 7)", "width = -bit & 7 or 16"),
)
mutant(
    "fba.framing.byte-align-between-planes",
    "Planes are taken to begin at byte boundaries",
    ["FBA-41", "FBA-2"],
    edit(
        "face.syntax:_plane_start_code",
        "if plane.boundary == PLANE:",
        "if plane.boundary == PLANE:\n        io.tell() & 7 and io.u(NEXT_START_CODE, 8 - (io.tell() & 7), 0)",
    ),
)
mutant(
    "fba.framing.plane-code-required",
    "Every plane must have its start code; what has none is not looked at",
    ["FBA-2"],
    edit(_BOUNDARY, "return PLANE", "return END"),
)
mutant(
    "fba.framing.end-of-data-unnoticed",
    "The end of the data is not noticed: a plane is read where there is nothing left",
    ["FBA-3", "FBA-1"],
    edit(_BOUNDARY, "if not cursor.has(1):\n            return END", "if not cursor.has(1):\n            return PLANE"),
)
mutant(
    "fba.framing.end-code-required",
    "Stuffing must be followed by a start code: the end of the data behind it is not accepted",
    ["FBA-3", "FBA-1"],
    edit(_BOUNDARY, "return STUFFED_END", "return PLANE"),
)
mutant(
    "fba.framing.empty-object-refused",
    "An object without planes is taken for an error: the first plane is read without looking for the end",
    ["FBA-44", "FBA-1"],
    edit(
        _BOUNDARY,
        "if not cursor.has(width + 1):",
        "if after_object_code and cursor.peek(width + 32) & 0xFF == 0xB1:\n                return PLANE\n            "
        "if not cursor.has(width + 1):",
    ),
)
mutant(
    "fba.framing.other-start-code-goes-on",
    "Behind stuffing any start code is taken for that of a plane",
    ["FBA-3", "FBA-44"],
    edit(_OBJECT, "if code != FBA_OBJECT_PLANE and", "if code == 0x1B1 and"),
)
mutant(
    "fba.framing.start-code-cut-is-the-end",
    "A start code that the end of the data cuts off is taken for the end",
    ["FBA-44", "FBA-3"],
    edit(
        _BOUNDARY,
        "if not cursor.has(width + 32):",
        "if not cursor.has(width + 32):\n                    return STUFFED_END",
    ),
)
mutant(
    "fba.framing.zero-padding-as-planes",
    "Zero bits up to the end of the data are read as planes without data",
    ["FBA-42"],
    edit(_BOUNDARY, 'self.readings.trailing_zeros == "padding"', "False"),
)
mutant(
    "fba.framing.zero-bits-end-the-object",
    "Eight zero bits are taken for padding, whatever follows them",
    ["FBA-42", "FBA-5"],
    edit(_BOUNDARY, "cursor.only_zeros_left()", "cursor.peek(8) == 0"),
)
mutant(
    "fba.framing.unstuffed-first-plane-refused",
    "A plane start code directly behind the object start code is read as plane data",
    ["FBA-3", "FBA-44"],
    edit(_BOUNDARY, "self._bare_plane_code()", "False"),
)
mutant(
    "fba.framing.mask-bits-swapped",
    "fba_object_mask: bit 0 is taken for BAP data and bit 1 for FAP data",
    ["FBA-5"],
    edit("face.syntax:fba_object_plane", "mask = plane.fba_object_mask", "mask = (0, 2, 1, 3)[plane.fba_object_mask]"),
    edit(_OBJECT, "if plane.fba_object_mask:", "if plane.faps or plane.baps:"),
)
mutant(
    "fba.framing.mask-0-without-header",
    "A plane without data has no temporal header",
    ["FBA-5"],
    edit("face.syntax:fba_object_plane", 'if mask or io.readings.empty_plane_header == "header":', "if mask:"),
)
mutant(
    "fba.framing.mask-0-ends-the-object",
    "A plane without data ends the object",
    ["FBA-5", "FBA-41"],
    edit(
        _OBJECT,
        "plane.frames = reconstruct(state, plane)",
        "if not plane.fba_object_mask:\n            return\n        plane.frames = reconstruct(state, plane)",
    ),
)
mutant(
    "fba.framing.mask-0-gives-no-line",
    "A plane without data gives no output",
    ["FBA-5", "FBA-34"],
    edit(
        "face.reconstruct:reconstruct",
        "return [_frame(state, plane, time, shown_values(state), state.letters_without, baps)]",
        "return [_frame(state, plane, time, shown_values(state), state.letters_without, baps)] "
        "if plane.baps is not None else []",
    ),
)
mutant(
    "fba.framing.bap-before-fap",
    "With both kinds of data the BAP data is read first",
    ["FBA-5", "FBA-40"],
    edit(
        "face.syntax:fba_object_plane",
        "    if mask & 1:\n        data = plane.faps\n",
        "    if mask == 3:\n        plane.baps = ParameterData(BAP_GROUPS)\n"
        "        bap_data(io, state.baps, plane.baps, "
        "plane.is_intra)\n        mask = 1\n    if mask & 1:\n        data = plane.faps\n",
    ),
)
mutant(
    "fba.framing.idle-limit-off-by-one",
    "The limit of planes without data is passed one plane too early",
    ["FBA-42", "CNF-22"],
    edit(_OBJECT, "idle > io.limits.idle_planes", "idle >= io.limits.idle_planes"),
)
mutant(
    "fba.framing.idle-not-limited",
    "Planes without data are counted per object, not up to the next one with data, and never refused",
    ["FBA-42", "CNF-22"],
    edit(_OBJECT, "idle > io.limits.idle_planes", "False"),
)
mutant(
    "fba.framing.idle-not-reset",
    "The count of planes without data is not reset by a plane with data",
    ["FBA-42"],
    edit(_OBJECT, "idle = 0\n        else:", "idle = idle + 0\n        else:"),
)
mutant(
    "fba.framing.idle-not-reset-by-code",
    "The count of planes without data is not reset by a start code",
    ["FBA-42", "FBA-44"],
    edit(_OBJECT, "idle = 1 if plane.start_code else idle + 1", "idle = idle + 1"),
)
mutant(
    "fba.framing.inter-first-accepted",
    "Inter FAP data before the first intra plane is decoded, from zero",
    ["FBA-35"],
    edit("face.syntax:fba_object_plane", "io.require(state.faps.has_intra, _INTER_FIRST, 0, start, start + 1)", "pass"),
)
mutant(
    "fba.framing.inter-first-of-the-other-kind",
    "An intra plane of one kind of data is taken to be enough for inter planes of the other",
    ["FBA-35", "FBA-40"],
    edit("face.syntax:fba_object_plane", "state.baps.has_intra", "state.faps.has_intra or state.baps.has_intra"),
)
mutant(
    "fba.framing.idle-plane-at-the-whole-plane",
    "Data before its first intra plane is reported at fba_object_mask, not at is_intra",
    ["FBA-35", "CNF-21"],
    edit(
        "face.syntax:fba_object_plane",
        "io.require(state.faps.has_intra, _INTER_FIRST, 0, start, start + 1)",
        "io.require(state.faps.has_intra, _INTER_FIRST, 0, start + 1, start + 3)",
    ),
)
mutant(
    "fba.framing.draft-codes-always",
    "The plane start code of the drafts is taken without being asked for",
    ["FBA-4"],
    edit(_OBJECT, "not (io.draft and code == DRAFT_PLANE)", "code != DRAFT_PLANE"),
)
mutant(
    "fba.framing.second-object-goes-on",
    "The state of the first object is kept for the second: decoding goes on into it",
    ["FBA-44"],
    edit(
        "systems.stream:decode_planes",
        "if number == options.object_number:\n                yield plane",
        "yield plane",
    ),
)
mutant(
    "fba.framing.last-plane-dropped",
    "The plane before the end of the data is dropped where no end code follows",
    ["FBA-1", "FBA-3"],
    edit(
        _OBJECT,
        "plane.frames = reconstruct(state, plane)",
        "if io.at_end(False):\n            return\n        plane.frames = reconstruct(state, plane)",
    ),
)
mutant(
    "fba.framing.padding-not-reported",
    "Zero padding is passed over in silence",
    ["FBA-42", "CNF-23"],
    edit("face.syntax:_end_of_data", 'io.finding("zero-padding"', 'str("zero-padding") or io.finding("zero-padding"'),
    findings=True,
)
mutant(
    "fba.framing.no-end-code-not-reported",
    "A missing end code is not reported",
    ["FBA-1", "CNF-23"],
    edit("face.syntax:_end_of_data", 'io.finding("no-end-code"', '"" and io.finding("no-end-code"'),
    findings=True,
)
mutant(
    "fba.framing.trailing-data-not-reported",
    "What follows the end code is not reported",
    ["FBA-3", "CNF-23"],
    edit("systems.visual:_trailing", 'io.finding("trailing-data"', '"" and io.finding("trailing-data"'),
    findings=True,
)
mutant(
    "fba.framing.second-object-not-reported",
    "Another object behind the one that is decoded is not reported",
    ["FBA-44", "CNF-23"],
    edit("systems.stream:decode_planes", 'io.finding("trailing-data"', '"" and io.finding("trailing-data"'),
    findings=True,
)
mutant(
    "fba.framing.draft-codes-not-reported",
    "Start codes of the drafts are taken in silence",
    ["FBA-4", "CNF-23"],
    edit(_OBJECT, "if obj.start_code == DRAFT_OBJECT:", "if False:"),
    edit("face.syntax:_plane_start_code", "if plane.start_code == DRAFT_PLANE:", "if False:"),
    findings=True,
)
mutant(
    "fba.framing.empty-object-not-reported",
    "An object without planes is passed over in silence",
    ["FBA-44", "CNF-23"],
    edit(_OBJECT, "if index == 0:\n        io.finding", "if index < 0:\n        io.finding"),
    findings=True,
)
mutant(
    "fba.framing.strict-is-not",
    "--strict does not refuse what follows the end",
    ["FBA-3", "CNF-7"],
    edit("systems.visual:_trailing", "io.require(not io.strict,", "io.require(True,"),
)
mutant(
    "fba.framing.trailing-data-refused",
    "Bytes behind the end code are an error without --strict",
    ["FBA-3", "CNF-7"],
    edit("systems.visual:_trailing", "io.require(not io.strict,", "io.require(False,"),
)
