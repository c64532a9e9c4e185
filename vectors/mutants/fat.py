"""Mutants of face animation tables.

Rules: FAT-1..9, FAT-11.
"""

from __future__ import annotations

from .mutant import edit, mutant

_WEIGHTS = "model.fat:interval_weights"
_AMPLITUDES = "model.fat:amplitudes"
_EVALUATE = "model.fat:evaluate"
_NODE = "model.fat:node_transform"
_MATRIX = "model.fat:rotation_matrix"
_BORDERS = "model.fat_document:check_borders"

mutant(
    "fat.interval.whole-length-of-the-last",
    "In the interval of the FAP the whole length of the interval counts",
    ["FAT-2"],
    edit(_WEIGHTS, "(j, fap - borders[j])]", "(j, float(borders[j + 1] - borders[j]))]"),
)
mutant(
    "fat.interval.only-the-last",
    "Only the vector of the FAP's own interval counts, times the FAP",
    ["FAT-2"],
    edit(
        _WEIGHTS,
        "return [*((i, float(borders[i + 1] - borders[i])) for i in range(k, j)), (j, fap - borders[j])]",
        "return [(j, fap)]",
    ),
)
mutant(
    "fat.interval.one-too-far",
    "The interval of a FAP is searched one too far: the vector of the one above its own counts",
    ["FAT-2"],
    edit(
        _WEIGHTS, "while j < intervals - 1 and fap > borders[j + 1]:", "while j < intervals - 1 and fap > borders[j]:"
    ),
)
mutant(
    "fat.interval.clamped-above",
    "A FAP above the last border is clamped to it",
    ["FAT-4"],
    edit(_WEIGHTS, "if fap > 0:", "fap = min(fap, borders[-1]) if borders[-1] > 0 else fap\n    if fap > 0:"),
)
mutant(
    "fat.interval.clamped-below",
    "A FAP below the first border is clamped to it",
    ["FAT-4"],
    edit(_WEIGHTS, "if fap > 0:", "fap = max(fap, borders[0]) if borders[0] < 0 else fap\n    if fap > 0:"),
)
mutant(
    "fat.interval.slope",
    "Vectors of negative intervals are slopes: their sign is changed",
    ["FAT-3"],
    edit(_WEIGHTS, 'sign = -1.0 if readings.sign == "slope" else 1.0', "sign = -1.0"),
)
mutant(
    "fat.interval.slope-last-only",
    "In the interval of a negative FAP the sign is changed, in the others it is not",
    ["FAT-3"],
    edit(_WEIGHTS, "(j, sign * (borders[j + 1] - fap)),", "(j, sign * (fap - borders[j + 1])),"),
)
mutant(
    "fat.interval.negative-from-the-far-end",
    "A negative FAP counts from the lower border of its interval",
    ["FAT-3"],
    edit(_WEIGHTS, "(j, sign * (borders[j + 1] - fap)),", "(j, sign * (fap - borders[j])),"),
)
mutant(
    "fat.interval.side-without-intervals",
    "On a side without intervals the vector of the nearest one is used",
    ["FAT-4"],
    edit(
        _WEIGHTS,
        "if k == intervals:\n            return []",
        "if k == intervals:\n            return [(intervals - 1, fap)]",
    ),
    edit(_WEIGHTS, "if k == 0:\n        return []", "if k == 0:\n        return [(0, fap)]"),
)
mutant(
    "fat.interval.single-one-sided",
    "A single interval moves on its own side only",
    ["FAT-5"],
    edit(
        _WEIGHTS,
        "if intervals == 1:\n        return [(0, fap)]",
        "if intervals == 1:\n"
        "        return [(0, fap)] if borders[0] <= min(fap, 0) or borders[1] >= max(fap, 1) > 0 else []",
    ),
)
mutant(
    "fat.interval.single-absolute",
    "A single interval moves in its direction for both signs",
    ["FAT-5"],
    edit(
        _WEIGHTS, "if intervals == 1:\n        return [(0, fap)]", "if intervals == 1:\n        return [(0, abs(fap))]"
    ),
)
mutant(
    "fat.interval.single-from-the-border",
    "A single interval counts from its lower border",
    ["FAT-5"],
    edit(
        _WEIGHTS,
        "if intervals == 1:\n        return [(0, fap)]",
        "if intervals == 1:\n        return [(0, fap - borders[0])]",
    ),
)
mutant(
    "fat.layout.by-interval",
    "Displacements are listed interval by interval, not vertex by vertex",
    ["FAT-1"],
    edit(
        "model.fat_json:_face_def_mesh",
        "flat.reshape(len(index), intervals, 3)",
        "flat.reshape(intervals, len(index), 3).transpose(1, 0, 2)",
    ),
)
mutant(
    "fat.layout.index-twice-once",
    "An index that stands twice in coordIndex moves its vertex once",
    ["FAT-7", "FAT-1"],
    edit(
        _EVALUATE,
        "np.add.at(out[mesh.mesh], mesh.coord_index, unit * moved)",
        "out[mesh.mesh][mesh.coord_index] += unit * moved",
    ),
)
mutant(
    "fat.layout.index-base-1",
    "coordIndex counts from 1",
    ["FAT-1", "FAT-11"],
    edit(_EVALUATE, "mesh.coord_index, unit * moved", "mesh.coord_index - 1, unit * moved"),
)
mutant(
    "fat.sum.last-wins",
    "Of several FAPs that move a vertex the last one counts",
    ["FAT-7"],
    edit(
        _EVALUATE,
        "np.add.at(out[mesh.mesh], mesh.coord_index, unit * moved)",
        "out[mesh.mesh][mesh.coord_index] = document.meshes[mesh.mesh].vertices[mesh.coord_index] + unit * moved",
    ),
)
mutant(
    "fat.sum.not-from-neutral",
    "Displacements are added to the frame before, not to the neutral position",
    ["FAT-7"],
    edit(
        _EVALUATE,
        "out = {name: mesh.vertices.copy() for name, mesh in document.meshes.items()}",
        "out = {name: mesh.vertices for name, mesh in document.meshes.items()}\n    for points in out.values():\n"
        "        points.flags.writeable = True",
    ),
)
mutant(
    "fat.sum.fapu-ignored",
    "Displacements are not multiplied by FAPU",
    ["FAT-2"],
    edit(_EVALUATE, "unit * moved)", "moved)"),
)
mutant(
    "fat.sum.faps-below-0-dropped",
    "Negative FAPs move nothing",
    ["FAT-3"],
    edit(_WEIGHTS, "if intervals < 1 or fap == 0:", "if intervals < 1 or fap <= 0:"),
)
mutant(
    "fat.sum.other-meshes-not-printed",
    "Meshes that do not move are not printed",
    ["FAT-9"],
    edit(
        _EVALUATE,
        "return out",
        "return {n: p for n, p in out.items() if not np.array_equal(p, document.meshes[n].vertices)}",
    ),
)
mutant(
    "fat.high-level.second-blend",
    "The second viseme has the amplitude of the first",
    ["FAT-8"],
    edit(_AMPLITUDES, "second = MAX_AMPLITUDE - first", "second = first"),
)
mutant(
    "fat.high-level.visemes-exchanged",
    "blend belongs to the second viseme",
    ["FAT-8"],
    edit(
        _AMPLITUDES,
        "high += [(1, select1, first), (1, select2, second)]",
        "high += [(1, select2, first), (1, select1, second)]",
    ),
)
mutant(
    "fat.high-level.blend-64",
    "The second viseme has 64 - blend",
    ["FAT-8"],
    edit(_AMPLITUDES, "second = MAX_AMPLITUDE - first", "second = MAX_AMPLITUDE + 1 - first"),
)
mutant(
    "fat.high-level.blend-fraction",
    "The amplitude of a viseme is blend/63",
    ["FAT-8"],
    edit(_AMPLITUDES, 'if readings.viseme == "fraction":', "if True:"),
)
mutant(
    "fat.high-level.not-clamped",
    "blend and intensities are not clamped to 0..63",
    ["FAT-8"],
    edit("model.fat:_clamped", "return min(max(value, 0), MAX_AMPLITUDE)", "return value"),
)
mutant(
    "fat.high-level.sum-clamped",
    "The sum of equal selects is clamped to 63",
    ["FAT-8", "FAT-9"],
    edit(
        _AMPLITUDES,
        "out[fap, select] = out.get((fap, select), 0.0) + value",
        "out[fap, select] = min(out.get((fap, select), 0.0) + value, 63.0)",
    ),
)
mutant(
    "fat.high-level.equal-selects-once",
    "Of two equal selects the second counts",
    ["FAT-8"],
    edit(_AMPLITUDES, "out[fap, select] = out.get((fap, select), 0.0) + value", "out[fap, select] = value"),
)
mutant(
    "fat.high-level.select-ignored",
    "Every table of FAP 1 or 2 is driven by the first select",
    ["FAT-8"],
    edit(
        "model.fat:_select",
        "return table.high_level_select if table.fap_id in HIGH_LEVEL_SELECTS else 0",
        "return 1 if table.fap_id in HIGH_LEVEL_SELECTS else 0",
    ),
)
mutant(
    "fat.high-level.select-for-all",
    "highLevelSelect is held against low-level FAPs too",
    ["FAT-8"],
    edit(
        "model.fat:_select",
        "if table.fap_id in HIGH_LEVEL_SELECTS else 0",
        "if table.fap_id in HIGH_LEVEL_SELECTS or table.high_level_select > 1 else 0",
    ),
)
mutant(
    "fat.high-level.expression-6",
    "Expression 6 moves nothing",
    ["FAT-8"],
    edit(_AMPLITUDES, "if 1 <= select <= HIGH_LEVEL_SELECTS[fap]:", "if 1 <= select < 6 + 9 * (fap == 1):"),
)
mutant(
    "fat.high-level.select-0",
    "Select 0 moves the first table",
    ["FAT-8"],
    edit(
        _AMPLITUDES,
        "if 1 <= select <= HIGH_LEVEL_SELECTS[fap]:",
        "select = max(select, 1)\n        if 1 <= select <= HIGH_LEVEL_SELECTS[fap]:",
    ),
)
mutant(
    "fat.high-level.with-unit",
    "Visemes and expressions are multiplied by a unit of the face",
    ["FAT-8"],
    edit(
        _EVALUATE,
        "unit = document.fapu.unit(fap_unit_names()[table.fap_id - 1]) or 0.0",
        "unit = document.fapu.unit(fap_unit_names()[table.fap_id - 1] if table.fap_id > 2 else 'MNS') or 0.0",
    ),
)
mutant(
    "fat.transform.left-handed",
    "Rotations are left-handed",
    ["FAT-9"],
    edit(_MATRIX, "c, s = cos(angle), sin(angle)", "c, s = cos(angle), -sin(angle)"),
)
mutant(
    "fat.transform.axis-not-normalised",
    "The axis is not normalised",
    ["FAT-9"],
    edit(_MATRIX, "x, y, z = x / length, y / length, z / length", "x, y, z = axis"),
)
mutant(
    "fat.transform.fap-before-neutral",
    "FAP rotations come before the neutral rotation",
    ["FAT-9"],
    edit(
        _NODE,
        "rotations.append(rotation_matrix(item.definition[:3], value * unit * item.definition[3]))",
        "rotations.insert(0, rotation_matrix(item.definition[:3], value * unit * item.definition[3]))",
    ),
)
mutant(
    "fat.transform.descending",
    "FAP rotations come in descending order",
    ["FAT-9"],
    edit(_NODE, "key=lambda table: table.fap_id)", "key=lambda table: -table.fap_id)"),
)
mutant(
    "fat.transform.document-order",
    "FAP rotations come in the order of the document",
    ["FAT-9"],
    edit(_NODE, "sorted(document.tables, key=lambda table: table.fap_id)", "document.tables"),
)
mutant(
    "fat.transform.translation-first",
    "Translations come before rotations",
    ["FAT-9"],
    edit(_EVALUATE, "points = out[name] * scale", "points = out[name] * scale + translation"),
    edit(_EVALUATE, "out[name] = points + translation", "out[name] = points"),
)
mutant(
    "fat.transform.scale-last",
    "The scale comes behind the rotations",
    ["FAT-9"],
    edit(_EVALUATE, "points = out[name] * scale", "points = out[name]"),
    edit(_EVALUATE, "out[name] = points + translation", "out[name] = points * scale + translation"),
)
mutant(
    "fat.transform.translation-without-neutral",
    "The neutral translation is lost where a FAP translates",
    ["FAT-9"],
    edit(_NODE, "translation = translation + unit * value", "translation = unit * value"),
)
mutant(
    "fat.transform.scale-multiplies",
    "Scales are multiplied",
    ["FAT-9"],
    edit(_NODE, 'elif readings.scale == "additive":', "elif False:"),
)
mutant(
    "fat.transform.degrees",
    "Angles are degrees",
    ["FAT-9"],
    edit(_NODE, "value * unit * item.definition[3]", "value * unit * item.definition[3] * 0.017453292519943295"),
)
mutant(
    "fat.transform.displaced-behind",
    "Meshes are displaced behind the transformation of their node",
    ["FAT-9"],
    edit(
        _EVALUATE,
        "for node in document.transforms.values():",
        "shift = {n: out[n] - document.meshes[n].vertices for n in out}\n"
        "        out = {n: document.meshes[n].vertices.copy() for n in out}\n"
        "        for node in document.transforms.values():",
    ),
    edit(
        _EVALUATE,
        "    for name, points in out.items():",
        "    out = {n: out[n] + shift[n] for n in out}\n    for name, points in out.items():",
    ),
)
mutant(
    "fat.error.borders-unsorted",
    "Borders that do not increase are sorted",
    ["FAT-11", "FAT-1"],
    edit(_BORDERS, "if borders[i] <= borders[i - 1]:", "if False:"),
)
mutant(
    "fat.error.borders-equal",
    "Two equal borders are accepted",
    ["FAT-11", "FAT-1"],
    edit(_BORDERS, "if borders[i] <= borders[i - 1]:", "if borders[i] < borders[i - 1]:"),
)
mutant(
    "fat.error.borders-without-0",
    "Several intervals without a border 0 are accepted",
    ["FAT-11"],
    edit(_BORDERS, "if len(borders) > 2 and 0 not in borders:", "if False:"),
)
mutant(
    "fat.error.single-needs-0",
    "A single interval needs a border 0",
    ["FAT-11", "FAT-5"],
    edit(_BORDERS, "if len(borders) > 2 and 0 not in borders:", "if len(borders) > 1 and 0 not in borders:"),
)
mutant(
    "fat.error.index-past-the-mesh",
    "An index past the mesh is not noticed until it is used",
    ["FAT-11"],
    edit("model.fat_document:_check_indices", "if len(bad):", "if False:"),
)
mutant(
    "fat.error.index-negative",
    "Negative indices count from the end",
    ["FAT-11"],
    edit("model.fat_document:_check_indices", "(indices < 0) | (indices >= count)", "indices >= count"),
)
mutant(
    "fat.error.too-many-vectors",
    "Displacements too many are ignored",
    ["FAT-11"],
    edit(
        "model.fat_json:_face_def_mesh",
        "if len(flat) != len(index) * intervals:",
        "flat = flat[: len(index) * intervals]\n    if len(flat) != len(index) * intervals:",
    ),
)
mutant(
    "fat.error.fapid-0",
    "fapID 0 is accepted",
    ["FAT-8"],
    edit("model.fat_json:_table", '"FAT-8", 1, 68)', '"FAT-8", 0, 68)'),
    edit("model.fat_document:_check_table", "if not 1 <= table.fap_id <= 68:", "if not 0 <= table.fap_id <= 68:"),
)
mutant(
    "fat.error.select-65",
    "highLevelSelect 65 is accepted",
    ["FAT-8"],
    edit("model.fat_json:_table", '"FAT-8", 1, 64)', '"FAT-8", 1, 255)'),
    edit("model.fat_document:_check_table", "if not 1 <= table.high_level_select <= 64:", "if False:"),
)
mutant(
    "fat.error.no-axis",
    "A rotation about the axis 0 0 0 is accepted",
    ["FAT-9"],
    edit("model.fat_document:_check_axis", "if rotation[3] != 0 and not any(rotation[:3]):", "if False:"),
)
mutant(
    "fat.error.no-unit",
    "A unit that is not given counts 0",
    ["FAC-1"],
    edit("model.fat_document:_check_table", "document.fapu.unit(unit) is None and", "False and"),
)
mutant(
    "fat.error.names-class",
    "A mesh that is not there is reported as a wrong format",
    ["FAT-11", "CNF-7"],
    edit("model.fat_document:_check_name", 'raise InconsistentSemantics("FAT-11"', 'raise InputFormat("FAT-11"'),
)
