"""Face animation tables from posed meshes.

Rules: FAT-10, FAC-40 (figure 7 of the paper). Only what `FaceDefMesh` can say is generated; transforms are
not.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, RangeViolation
from snhc.reference_impl.model.fapu import Fapu, fap_unit_names
from snhc.reference_impl.model.fat import DEFAULT_READINGS, FatReadings
from snhc.reference_impl.model.fat_document import (
    FaceDefMesh,
    FaceDefTables,
    FatMesh,
    FloatArray,
    check_borders,
)


def generate_face_def_mesh(
    neutral: FatMesh,
    posed: Mapping[int, FloatArray],
    unit: float,
    *,
    tolerance: float = 0.0,
    readings: FatReadings = DEFAULT_READINGS,
) -> FaceDefMesh:
    """The intervals and displacements that carry `neutral` through its poses.

    Rules: FAT-10, FAC-40, FAT-2, FAT-3 (AMB-FAT-1).

    `posed`: {FAP value, not 0: float64 (V, 3)}, the same vertices as `neutral`, model units. `unit`: FAPU of
    the FAP, above 0. `tolerance`: vertices that move by no more than this in any pose, per coordinate, are
    left out. Evaluating the result at a posed value gives that mesh within float32 rounding (about 1e-15
    relative in float64). One pose gives a table of one interval, which is linear through 0 to both sides
    (FAT-5). Raises `InconsistentSemantics` (another number of vertices, no pose), `RangeViolation` (FAP value
    0, unit not above 0).
    """
    if not posed:
        raise InconsistentSemantics("FAT-10", "posed", value=0, allowed="one pose or more", path="posed", expected=1)
    if not unit > 0:
        raise RangeViolation("FAT-10", "unit", value=str(unit), allowed="above 0", path="unit")
    for value, points in posed.items():
        if value == 0:
            raise RangeViolation("FAT-10", "posed", value=0, allowed="FAP values other than 0", path="posed.0")
        if points.shape != neutral.vertices.shape:
            raise InconsistentSemantics(
                "FAT-10", "vertices", value=len(points), allowed="the topology of the neutral mesh",
                path=f"posed.{value}", expected=len(neutral.vertices),
            )  # fmt: skip
    borders = sorted({0, *posed})
    check_borders(borders, "posed")
    # Total displacement at every border, in units; 0 at the border 0.
    moved = np.zeros((len(borders), *neutral.vertices.shape))
    for i, value in enumerate(borders):
        if value:
            moved[i] = (np.asarray(posed[value], dtype=np.float64) - neutral.vertices) / unit
    affected = np.flatnonzero((np.abs(moved) * unit > tolerance).any(axis=(0, 2)))
    k = borders.index(0)
    steps = np.empty((len(affected), len(borders) - 1, 3))
    for j in range(len(borders) - 1):
        # FAT-3 as printed: the vector of a negative interval points the way the vertex moves, away from 0.
        near, far = (j, j + 1) if j >= k else (j + 1, j)
        sign = -1.0 if j < k and readings.sign == "slope" else 1.0
        steps[:, j] = sign * (moved[far][affected] - moved[near][affected]) / (borders[j + 1] - borders[j])
    if len(borders) == 2 and k == 1 and readings.sign == "direction":
        # One interval is linear with a signed FAP (FAT-5): the vector of [I, 0] is met with a negative factor.
        steps = -steps
    return FaceDefMesh(neutral.name, tuple(borders), affected.astype(np.int64), steps)


def generate_table(
    fap_id: int,
    neutral: Mapping[str, FatMesh],
    posed: Mapping[int, Mapping[str, FloatArray]],
    fapu: Fapu,
    *,
    high_level_select: int = 1,
    tolerance: float = 0.0,
    readings: FatReadings = DEFAULT_READINGS,
) -> FaceDefTables:
    """One table for one FAP from whole models; meshes that no pose moves are left out.

    Rules: FAT-10, FAC-40, FAT-8. `posed`: {FAP value (amplitude for FAP 1 and 2): {mesh name: (V, 3)}}; a
    mesh that a pose does not name is neutral there. Raises as `generate_face_def_mesh`, and `RangeViolation`
    for a fapID outside 1..68, `InconsistentSemantics` for a mesh that is not there or a unit that is not
    given.
    """
    if not 1 <= fap_id <= 68:
        raise RangeViolation("FAT-8", "fapID", value=fap_id, allowed="1..68", path="fapID")
    name = fap_unit_names()[fap_id - 1]
    unit = fapu.unit(name)
    if unit is None:
        raise InconsistentSemantics("FAC-1", "fapu", value="absent", allowed=f"the unit {name}", path=f"fapu.{name}")
    for value, meshes in posed.items():
        for mesh in meshes:
            if mesh not in neutral:
                raise InconsistentSemantics(
                    "FAT-10",
                    "mesh",
                    value=mesh,
                    allowed="a mesh of the neutral model",
                    path=f"posed.{value}.{mesh}",
                )
    tables: list[FaceDefMesh] = []
    for mesh, rest in neutral.items():
        if not any(mesh in meshes for meshes in posed.values()):
            continue
        poses = {value: meshes.get(mesh, rest.vertices) for value, meshes in posed.items()}
        table = generate_face_def_mesh(rest, poses, unit, tolerance=tolerance, readings=readings)
        if len(table.coord_index):
            tables.append(table)
    return FaceDefTables(fap_id, high_level_select, tuple(tables))
