"""FAT evaluation over many frames: a hinge basis times one matrix, in float32.

Rules: FAT-2 .. FAT-9 (the speed line of the FAT section). Every interval of every table is a column: a hinge
of the amplitude, clamp(FAP - I_j), and FAPU * D for all vertices. One column of ones holds the neutral
positions, so that the vertices of a block of frames are a single matrix product.

The bound. u = 2^-24. The literal form computes each coordinate as P + sum_c w_c A_c with A_c = FAPU * D; let
n be the number of columns and S = |P| + sum_c |w_c| |A_c|. Here w and A are rounded to float32 (a factor 1 +
u each), and a dot product of n terms in any order, fused or not, errs by at most gamma_n sum |w||A|, gamma_n
= n u / (1 - n u); the float64 errors of the literal form and of A and w themselves are below gamma_1 for n <
2^27. In all: gamma_(n+3) S, plus n 2^-126 for numbers that leave the normal range. Below nodes every step x
-> M x + t of a chain turns a bound B of points of size S into |M| (B + gamma_8 S) + gamma_8 |t|, where |M| is
the product of the absolute values of the scale and rotation matrices; gamma_8 covers the roundings of M, of
t, of the product and of the sums.

Not implemented here: FAT-10 (`fat_generate`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import RangeViolation, ResourceLimit
from snhc.reference_impl.model.fapu import fap_unit_names
from snhc.reference_impl.model.fat import (
    DEFAULT_READINGS,
    HIGH_LEVEL_SELECTS,
    MAX_AMPLITUDE,
    FatReadings,
    FrameLike,
    amplitudes,
    node_chain,
    node_transform,
)
from snhc.reference_impl.model.fat_document import FaceDefMesh, FatDocument, FloatArray

Float32Array = NDArray[np.float32]

BLOCK_FRAMES: Final = 128
MAX_MATRIX: Final = 1 << 28
CHANNELS: Final = 68 + 14 + 6
_U: Final = 2.0**-24
_TINY: Final = 2.0**-126


def _gamma(n: int) -> float:
    return n * _U / (1.0 - n * _U)


def channel(fap: int, select: int) -> int:
    """The column of `channels` that drives a table; -1 where no frame can.

    Rules: FAT-8. `fap`: 1..68, `select`: highLevelSelect, read for FAP 1 and 2.
    """
    if fap not in HIGH_LEVEL_SELECTS:
        return fap - 1
    if select > HIGH_LEVEL_SELECTS[fap]:
        return -1
    return 67 + select if fap == 1 else 81 + select


def channels(frames: Sequence[FrameLike], readings: FatReadings = DEFAULT_READINGS) -> FloatArray:
    """The amplitudes of many frames, as `fat.amplitudes`: float64 (N, 88), 0 where nothing moves.

    Rules: FAT-8 (AMB-FAT-2). Columns 0..67: FAP 1..68 (0 and 1 unused), 68..81 visemes 1..14, 82..87
    expressions 1..6.
    """
    count = len(frames)
    out = np.zeros((count, CHANNELS))
    # numpy reads None as NaN; a null FAP moves nothing, like 0.
    faps = np.array([frame.faps for frame in frames], dtype=np.float64).reshape(count, 68)
    out[:, 2:68] = np.nan_to_num(faps[:, 2:], nan=0.0)
    rows = np.arange(count)
    high: list[tuple[int, int, FloatArray, FloatArray]] = []
    visemes = np.array([(f.viseme or (0, 0, 0))[:3] for f in frames], dtype=np.float64).reshape(count, 3)
    first = visemes[:, 2].clip(0, MAX_AMPLITUDE)
    second = MAX_AMPLITUDE - first
    if readings.viseme == "fraction":
        first, second = first / MAX_AMPLITUDE, second / MAX_AMPLITUDE
    high += [(1, 67, visemes[:, 0], first), (1, 67, visemes[:, 1], second)]
    moods = np.array([(f.expression or (0, 0, 0, 0))[:4] for f in frames], dtype=np.float64).reshape(count, 4)
    for at in (0, 2):
        high.append((2, 81, moods[:, at], moods[:, at + 1].clip(0, MAX_AMPLITUDE)))
    for fap, base, select, value in high:
        on = (select >= 1) & (select <= HIGH_LEVEL_SELECTS[fap])
        np.add.at(out, (rows[on], base + select[on].astype(np.intp)), value[on])
    return out


@dataclass(frozen=True, slots=True)
class Hinge:
    """One hinge: sign * clamp(side * (amplitude - start), 0, length); `side` 0 is the linear one, without
    clamp.

    Rules: FAT-3, FAT-4, FAT-5.
    """

    channel: int
    start: float
    side: int
    length: float
    sign: float


def hinges(borders: Sequence[int], source: int, readings: FatReadings) -> Iterator[tuple[int, Hinge]]:
    """(interval, hinge) of one mesh table; end intervals have no upper clamp. Rules: FAT-3, FAT-4, FAT-5."""
    intervals = len(borders) - 1
    if intervals == 1:
        yield 0, Hinge(source, 0.0, 0, np.inf, 1.0)
        return
    for j in range(intervals):
        length = float(borders[j + 1] - borders[j])
        if borders[j] >= 0:
            yield j, Hinge(source, float(borders[j]), 1, np.inf if j == intervals - 1 else length, 1.0)
        else:
            sign = -1.0 if readings.sign == "slope" else 1.0
            yield j, Hinge(source, float(borders[j + 1]), -1, np.inf if j == 0 else length, sign)


class _Mesh:
    """The columns of one mesh and its matrix, (1 + columns, V * 3); row 0 holds the neutral positions.

    `magnitude`: sums of absolute values, float64: tables that share a column may cancel, their errors do not.
    """

    __slots__ = ("columns", "magnitude", "matrix", "vertices")

    def __init__(self, document: FatDocument, name: str, readings: FatReadings) -> None:
        neutral = document.meshes[name].vertices
        self.vertices = len(neutral)
        uses: dict[Hinge, list[tuple[FaceDefMesh, int, float]]] = {}
        for table in document.tables:
            source = channel(table.fap_id, table.high_level_select)
            if source < 0:
                continue
            unit = document.fapu.unit(fap_unit_names()[table.fap_id - 1]) or 0.0
            for mesh in table.meshes:
                if mesh.mesh == name and len(mesh.coord_index):
                    for interval, column in hinges(mesh.interval_borders, source, readings):
                        uses.setdefault(column, []).append((mesh, interval, unit))
        self.columns = tuple(uses)
        shape = (1 + len(uses), self.vertices, 3)
        if shape[0] * shape[1] * 3 > MAX_MATRIX:
            raise ResourceLimit(
                "CNF-22", "matrix", value=shape[0] * shape[1] * 3, allowed=f"at most {MAX_MATRIX} numbers",
                path=f"meshes.{name}",
            )  # fmt: skip
        matrix = np.empty(shape, dtype=np.float32)
        magnitude = np.zeros(shape)
        matrix[0] = neutral
        magnitude[0] = np.abs(neutral)
        for i, column in enumerate(self.columns, 1):
            total = np.zeros_like(neutral)
            for mesh, interval, unit in uses[column]:
                part = unit * mesh.displacements[:, interval]
                np.add.at(total, mesh.coord_index, part)
                np.add.at(magnitude[i], mesh.coord_index, np.abs(part))
            matrix[i] = total
        self.matrix = matrix.reshape(shape[0], -1)
        self.magnitude = magnitude.reshape(shape[0], -1)

    def basis(self, amplitude: FloatArray) -> FloatArray:
        out = np.ones((len(amplitude), 1 + len(self.columns)))
        for i, column in enumerate(self.columns, 1):
            value = amplitude[:, column.channel]
            if column.side:
                value = (column.side * (value - column.start)).clip(0.0, column.length)
            out[:, i] = column.sign * value
        return out


class BulkFat:
    """A document made ready for many frames.

    Rules: FAT-2 .. FAT-9. `evaluate` gives float32; `bound` how far each of its coordinates can be from
    `fat.evaluate`.
    """

    def __init__(self, document: FatDocument, readings: FatReadings = DEFAULT_READINGS) -> None:
        self._document = document
        self._readings = readings
        self._meshes = {name: _Mesh(document, name, readings) for name in document.meshes}
        self._chains = {
            mesh: node_chain(document, node) for node in document.transforms.values() for mesh in node.meshes
        }

    def evaluate(self, frames: Sequence[FrameLike]) -> dict[str, Float32Array]:
        """The vertices of every mesh for every frame: {name: float32 (N, V, 3)}, model units.

        Rules: FAT-2 .. FAT-9. The whole result is held: for long sequences use `blocks`. Raises
        `RangeViolation` where a value leaves the range of float32.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            out = self._evaluate(frames)
        for name, points in out.items():
            if not np.isfinite(points).all():
                raise RangeViolation(
                    "FAT-2", "vertices", value="not finite", allowed="the range of float32", path=f"meshes.{name}"
                )
        return out

    def _evaluate(self, frames: Sequence[FrameLike]) -> dict[str, Float32Array]:
        amplitude = channels(frames, self._readings)
        steps = self._steps(frames)
        out: dict[str, Float32Array] = {}
        for name, mesh in self._meshes.items():
            points = (mesh.basis(amplitude).astype(np.float32) @ mesh.matrix).reshape(len(frames), mesh.vertices, 3)
            for node in self._chains.get(name, ()):
                linear, translation, _ = steps[node]
                points = points @ linear.astype(np.float32).transpose(0, 2, 1)
                points += translation.astype(np.float32)[:, None, :]
            out[name] = points
        return out

    def blocks(self, frames: Sequence[FrameLike], size: int = BLOCK_FRAMES) -> Iterator[dict[str, Float32Array]]:
        """`evaluate` for `size` frames at a time. Rules: FAT-2 .. FAT-9."""
        for start in range(0, len(frames), size):
            yield self.evaluate(frames[start : start + size])

    def bound(self, frames: Sequence[FrameLike]) -> dict[str, FloatArray]:
        """The largest difference to `fat.evaluate`, per coordinate: {name: float64 (N, V, 3)}, model units.

        Rules: FAT-2 .. FAT-9. The derivation stands at the top of this module.
        """
        amplitude = channels(frames, self._readings)
        steps = self._steps(frames)
        out: dict[str, FloatArray] = {}
        for name, mesh in self._meshes.items():
            size = (np.abs(mesh.basis(amplitude)) @ mesh.magnitude).reshape(len(frames), mesh.vertices, 3)
            terms = 1 + len(mesh.columns)
            error = _gamma(terms + 3) * size + terms * _TINY
            for node in self._chains.get(name, ()):
                _, translation, magnitude = steps[node]
                shift = np.abs(translation)[:, None, :]
                turned = magnitude.transpose(0, 2, 1)
                error = (error + _gamma(8) * size) @ turned + _gamma(8) * shift + _TINY
                size = size @ turned + shift
            out[name] = error
        return out

    def _steps(self, frames: Sequence[FrameLike]) -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
        """Per node: linear part (N, 3, 3), translation (N, 3), product of the absolute matrices (N, 3, 3)."""
        wanted = {node for chain in self._chains.values() for node in chain}
        out: dict[str, tuple[FloatArray, FloatArray, FloatArray]] = {}
        if not wanted:
            return out
        moving = [amplitudes(frame, self._readings) for frame in frames]
        for name in wanted:
            node = self._document.transforms[name]
            linear = np.empty((len(frames), 3, 3))
            magnitude = np.empty((len(frames), 3, 3))
            translation = np.empty((len(frames), 3))
            for n, values in enumerate(moving):
                scale, rotations, translation[n] = node_transform(self._document, node, values, self._readings)
                linear[n] = np.diag(scale)
                magnitude[n] = np.abs(linear[n])
                for matrix in rotations:
                    linear[n] = matrix @ linear[n]
                    magnitude[n] = np.abs(matrix) @ magnitude[n]
            out[name] = linear, translation, magnitude
        return out
