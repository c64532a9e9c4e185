"""Mutants of the units of a face.

Rules: FAC-1, FAC-2, FAC-4.
"""

from __future__ import annotations

from .mutant import edit, mutant, value

_DISTANCES = "model.face_definition:FaceDefinition.distances"
_FAPU = "model.face_definition:FaceDefinition.fapu"

mutant(
    "fapu.au-1e-4",
    "AU is 1e-4 rad",
    ["FAC-1"],
    edit("model.fapu:Fapu.unit", "return AU", "return 1e-4"),
)
mutant(
    "fapu.mns-to-8-1",
    "MNS is measured to the outer lip, 8.1, not to 2.2",
    ["FAC-1"],
    edit(_DISTANCES, 'self.point("2.2")[1]', 'self.point("8.1")[1]'),
)
mutant(
    "fapu.fap-19-by-mns",
    "FAP 19 is scaled by MNS",
    ["FAC-1", "FAC-4"],
    value("tables:fap_table()[18].unit", "IRISD", "MNS"),
)
mutant(
    "fapu.mw-at-the-outer-corners",
    "MW is measured between the outer corners of the lips",
    ["FAC-1"],
    edit(_DISTANCES, 'self.point("8.3")[0] - self.point("8.4")[0]', 'self.point("2.4")[0] - self.point("2.5")[0]'),
)
mutant(
    "fapu.ens-euclidean",
    "ENS is the distance in space, not along y",
    ["FAC-1"],
    edit(
        _DISTANCES,
        'abs(self.point("3.5")[1] - self.point("9.15")[1])',
        'sum((a - b) ** 2 for a, b in zip(self.point("3.5"), self.point("9.15"))) ** 0.5',
    ),
)
mutant(
    "fapu.es-euclidean",
    "ES is the distance in space, not along x",
    ["FAC-1"],
    edit(
        _DISTANCES,
        'abs(self.point("3.5")[0] - self.point("3.6")[0])',
        'sum((a - b) ** 2 for a, b in zip(self.point("3.5"), self.point("3.6"))) ** 0.5',
    ),
)
mutant(
    "fapu.signed",
    "Distances keep their sign",
    ["FAC-1"],
    edit(
        _DISTANCES, 'abs(self.point("3.5")[0] - self.point("3.6")[0])', '(self.point("3.6")[0] - self.point("3.5")[0])'
    ),
)
mutant(
    "fapu.right-iris",
    "IRISD is measured at the right eye",
    ["FAC-1"],
    edit(
        _DISTANCES,
        'abs(self.point("3.1")[1] - self.point("3.3")[1])',
        'abs(self.point("3.2")[1] - self.point("3.4")[1])',
    ),
)
mutant(
    "fapu.mean-iris",
    "IRISD is the mean of both eyes",
    ["FAC-1"],
    edit(
        _DISTANCES,
        'abs(self.point("3.1")[1] - self.point("3.3")[1])',
        '(abs(self.point("3.1")[1] - self.point("3.3")[1]) + abs(self.point("3.2")[1] - self.point("3.4")[1])) / 2',
    ),
)
mutant(
    "fapu.per-1000",
    "A unit is the distance / 1000",
    ["FAC-1"],
    edit(_FAPU, "distance / UNITS_PER_DISTANCE", "distance / 1000"),
)
mutant(
    "fapu.not-divided",
    "A unit is the distance itself",
    ["FAC-1"],
    edit(_FAPU, "distance / UNITS_PER_DISTANCE", "distance"),
)
mutant(
    "fapu.es-and-ens",
    "ES and ENS are exchanged",
    ["FAC-1"],
    edit(
        "model.fapu:Fapu.unit",
        'case "ES":\n                return self.es',
        'case "ES":\n                return self.ens',
    ),
    edit(
        "model.fapu:Fapu.unit",
        'case "ENS":\n                return self.ens',
        'case "ENS":\n                return self.es',
    ),
)
mutant(
    "fapu.missing-point-is-0",
    "A missing feature point lies in the origin",
    ["FAC-1", "FAC-2"],
    edit(
        "model.face_definition:FaceDefinition.point",
        "if found is None:",
        "if found is None:\n            return (0.0, 0.0, 0.0)\n        if found is None:",
    ),
)
mutant(
    "fapu.unknown-point-accepted",
    "Points that are no feature points are passed over",
    ["FAC-2"],
    edit("model.face_definition:_check_point_name", "if name not in feature_point_names():", "if False:"),
)
mutant(
    "fapu.iris-not-compared",
    "The two irises are not compared",
    ["FAC-1", "CNF-23"],
    value("model.face_checks:IRIS_TOLERANCE", 0.01, 1e9),
    findings=True,
)
