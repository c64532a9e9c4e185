"""FAT evaluation, literally: ordered float64, one frame at a time. The reference that the bulk form is held
against.

Rules: FAT-2 .. FAT-9. The document is in `fat_document`, its JSON form in `fat_json`; both are offered here
too. Readings in `FatReadings`: AMB-FAT-1, AMB-FAT-2, AMB-FAT-3. Not implemented here: bulk evaluation
(`fat_bulk`), FAT-10.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, isfinite, sin, sqrt
from typing import Final, Protocol

import numpy as np

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.model.fapu import fap_unit_names
from snhc.reference_impl.model.fat_document import (
    FaceDefMesh,
    FaceDefTables,
    FaceDefTransform,
    FatDocument,
    FatMesh,
    FloatArray,
    IntArray,
    TransformNode,
    check_fat,
)
from snhc.reference_impl.model.fat_json import fat_from_json, fat_to_json, load_fat, parse_fat_json

__all__ = [
    "FaceDefMesh",
    "FaceDefTables",
    "FaceDefTransform",
    "FatDocument",
    "FatMesh",
    "FatReadings",
    "FloatArray",
    "FrameLike",
    "IntArray",
    "TransformNode",
    "amplitudes",
    "check_fat",
    "evaluate",
    "fat_from_json",
    "fat_to_json",
    "interval_weights",
    "load_fat",
    "node_chain",
    "node_transform",
    "parse_fat_json",
    "rotate",
    "rotation_matrix",
]

HIGH_LEVEL_SELECTS: Final = {1: 14, 2: 6}
MAX_AMPLITUDE: Final = 63


class FrameLike(Protocol):
    """What a frame must have: CNF-1 values.

    Rules: CNF-1. `faps`: 68 values or None. `viseme`: (select1, select2, blend, ...) or None. `expression`:
    (select1, intensity1, select2, intensity2, ...) or None.
    """

    @property
    def faps(self) -> Sequence[int | None]:
        """FAP i + 1 in FAP units. Rules: CNF-1."""

    @property
    def viseme(self) -> Sequence[int] | None:
        """FAP 1. Rules: CNF-1."""

    @property
    def expression(self) -> Sequence[int] | None:
        """FAP 2. Rules: CNF-1."""


@dataclass(frozen=True, slots=True)
class FatReadings:
    """Which reading of each ambiguity is followed; the defaults are the register's.

    Rules: FAT-3, FAT-8, FAT-9. `sign` (AMB-FAT-1): "direction" or "slope".
    `viseme` (AMB-FAT-2): "blend" or "fraction". `scale` (AMB-FAT-3): "additive" or "multiplicative".
    """

    sign: str = "direction"
    viseme: str = "blend"
    scale: str = "additive"


DEFAULT_READINGS: Final = FatReadings()


def _clamped(value: int) -> int:
    return min(max(value, 0), MAX_AMPLITUDE)


def amplitudes(frame: FrameLike, readings: FatReadings = DEFAULT_READINGS) -> dict[tuple[int, int], float]:
    """The amplitude of every table of a frame that may move something: {(fapID, highLevelSelect or 0):
    value}.

    Rules: FAT-8, FAC-6 (AMB-FAT-2). Low-level FAPs have select 0. Blend and intensities are clamped to 0..63
    before equal selects add; select 0 and selects past 14 (viseme) or 6 (expression) give nothing.
    """
    out: dict[tuple[int, int], float] = {}
    high: list[tuple[int, int, float]] = []
    if frame.viseme is not None:
        select1, select2, blend = frame.viseme[:3]
        first = float(_clamped(blend))
        second = MAX_AMPLITUDE - first
        if readings.viseme == "fraction":
            first, second = first / MAX_AMPLITUDE, second / MAX_AMPLITUDE
        high += [(1, select1, first), (1, select2, second)]
    if frame.expression is not None:
        select1, intensity1, select2, intensity2 = frame.expression[:4]
        high += [(2, select1, float(_clamped(intensity1))), (2, select2, float(_clamped(intensity2)))]
    for fap, select, value in high:
        if 1 <= select <= HIGH_LEVEL_SELECTS[fap]:
            out[fap, select] = out.get((fap, select), 0.0) + value
    for i in range(2, 68):
        low = frame.faps[i]
        if low is not None:
            out[i + 1, 0] = float(low)
    return out


def interval_weights(
    borders: Sequence[int], fap: float, readings: FatReadings = DEFAULT_READINGS
) -> list[tuple[int, float]]:
    """The factors of the interval vectors D for one FAP value, in the order of the printed sums.

    Rules: FAT-2, FAT-3, FAT-4, FAT-5 (AMB-FAT-1). `borders`: checked. Returns (interval from 0, factor in FAP
    units).
    """
    intervals = len(borders) - 1
    if intervals < 1 or fap == 0:
        return []
    if intervals == 1:
        return [(0, fap)]
    k = borders.index(0)
    if fap > 0:
        if k == intervals:
            return []
        j = k
        while j < intervals - 1 and fap > borders[j + 1]:
            j += 1
        return [*((i, float(borders[i + 1] - borders[i])) for i in range(k, j)), (j, fap - borders[j])]
    if k == 0:
        return []
    j = k - 1
    while j > 0 and fap < borders[j]:
        j -= 1
    sign = -1.0 if readings.sign == "slope" else 1.0
    return [
        (j, sign * (borders[j + 1] - fap)),
        *((i, sign * (borders[i + 1] - borders[i])) for i in range(j + 1, k)),
    ]


def rotation_matrix(axis: Sequence[float], angle: float) -> FloatArray:
    """The 3 x 3 matrix of a right-handed rotation of column vectors.

    Rules: FAT-9. `axis`: normalised here; an axis of length 0 rotates nothing. `angle`: radians.
    """
    if not isfinite(angle):
        raise RangeViolation("FAT-9", "rotation", value="angle not finite", allowed="the range of float64")
    x, y, z = axis
    biggest = max(abs(x), abs(y), abs(z))
    if biggest == 0:
        return np.eye(3)
    # Scaled first: the squares of very long or very short axes leave the range of float64.
    x, y, z = x / biggest, y / biggest, z / biggest
    length = sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    c, s = cos(angle), sin(angle)
    t = 1.0 - c
    return np.array(
        [
            [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
        ]
    )


def node_transform(
    document: FatDocument,
    node: TransformNode,
    moving: Mapping[tuple[int, int], float],
    readings: FatReadings = DEFAULT_READINGS,
) -> tuple[FloatArray, list[FloatArray], FloatArray]:
    """Scale (3,), rotation matrices in the order of application, translation (3,) of one node for one frame.

    Rules: FAT-9 (AMB-FAT-3). `moving`: the result of `amplitudes`. The neutral rotation comes first, then the
    FAPs' rotations in ascending FAP number, tables of one FAP in document order, each in the parent's frame.
    """
    scale = np.array(node.scale)
    translation = np.array(node.translation)
    rotations = [rotation_matrix(node.rotation[:3], node.rotation[3])]
    for table in sorted(document.tables, key=lambda table: table.fap_id):
        value = moving.get((table.fap_id, _select(table)))
        if value is None:
            continue
        unit = document.fapu.unit(fap_unit_names()[table.fap_id - 1]) or 0.0
        for item in table.transforms:
            if item.node != node.name:
                continue
            if item.field == "rotation":
                rotations.append(rotation_matrix(item.definition[:3], value * unit * item.definition[3]))
            elif item.field == "translation":
                translation = translation + unit * value * np.array(item.definition)
            elif readings.scale == "additive":
                scale = scale + unit * value * np.array(item.definition)
            else:
                scale = scale * np.array(item.definition) ** (unit * value)
    return scale, rotations, translation


def node_chain(document: FatDocument, node: TransformNode) -> list[str]:
    """The names of a node and of all nodes above it, innermost first.

    Rules: FAT-9.
    """
    names = [node.name]
    while node.parent:
        node = document.transforms[node.parent]
        names.append(node.name)
    return names


def _select(table: FaceDefTables) -> int:
    return table.high_level_select if table.fap_id in HIGH_LEVEL_SELECTS else 0


def rotate(matrix: FloatArray, points: FloatArray) -> FloatArray:
    """Rotate points (N, 3) with a fixed order of additions, so that every platform gives the same numbers.

    Rules: FAT-9.
    """
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in matrix], axis=1)


def evaluate(
    document: FatDocument, frame: FrameLike, readings: FatReadings = DEFAULT_READINGS
) -> dict[str, FloatArray]:
    """The vertices of every mesh for one frame: {name: float64 (V, 3)}, model units.

    Rules: FAT-2 .. FAT-9. Displacements of several FAPs add, each from the neutral position, tables in
    document order; then the neutral scale, the neutral rotation, FAP rotations, translations of the node
    above the mesh. Null FAPs move nothing; every mesh is in the result. Raises `RangeViolation` where a value
    leaves the range of float64.
    """
    moving = amplitudes(frame, readings)
    out = {name: mesh.vertices.copy() for name, mesh in document.meshes.items()}
    with np.errstate(over="ignore", invalid="ignore"):
        for table in document.tables:
            value = moving.get((table.fap_id, _select(table)))
            if value is None:
                continue
            unit = document.fapu.unit(fap_unit_names()[table.fap_id - 1]) or 0.0
            for mesh in table.meshes:
                weights = interval_weights(mesh.interval_borders, value, readings)
                if not weights:
                    continue
                first, factor = weights[0]
                moved = factor * mesh.displacements[:, first]
                for interval, factor in weights[1:]:
                    moved = moved + factor * mesh.displacements[:, interval]
                # An index that stands twice moves its vertex twice: `+=` would do it once.
                np.add.at(out[mesh.mesh], mesh.coord_index, unit * moved)
        steps = {name: node_transform(document, node, moving, readings) for name, node in document.transforms.items()}
        for node in document.transforms.values():
            for name in node.meshes:
                for above in node_chain(document, node):
                    scale, rotations, translation = steps[above]
                    points = out[name] * scale
                    for matrix in rotations:
                        points = rotate(matrix, points)
                    out[name] = points + translation
    for name, points in out.items():
        if not np.isfinite(points).all():
            raise RangeViolation(
                "FAT-2", "vertices", value="not finite", allowed="the range of float64", path=f"meshes.{name}"
            )
    return out
