"""What a motion is made of: the neutral model, one FaceDefMesh, weights and pieces.

Rules: FAT-1 .. FAT-5, FAC-2, FAC-10.
Not here: which FAP moves what (`mouth`, `face`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .skin import Skin

Array = NDArray[np.float64]


@dataclass(slots=True)
class Model:
    """Neutral meshes (mm, eyes at y = 0; eyeballs from their centres) with their feature points. Rules: FAC-10.

    `units`: FAPU in mm. `marks`: feature point to (mesh, vertex).
    """

    skin: Skin
    meshes: dict[str, Array]
    marks: dict[str, tuple[str, int]]
    units: dict[str, float]
    motion: Mapping[str, Any]

    def point(self, name: str) -> Array:
        """Position of a feature point (mm). Rules: FAC-2."""
        mesh, vertex = self.marks[name]
        point: Array = self.meshes[mesh][vertex]
        return point


@dataclass(slots=True)
class Move:
    """One FaceDefMesh: `steps` (vertices, intervals, 3) displacements per FAP unit and FAPU. Rules: FAT-1."""

    mesh: str
    borders: list[int]
    index: list[int]
    steps: Array


Moves = dict[int, list[Move]]


def smooth(v: float) -> float:
    """0 below 0, 1 above 1, a cubic between. Rules: FAC-10."""
    v = min(max(v, 0.0), 1.0)
    return v * v * (3 - 2 * v)


def _linear(mesh: str, borders: list[int], weights: Mapping[int, tuple[float, float, float]]) -> Move:
    return Move(mesh, borders, list(weights), np.array(list(weights.values())).reshape(-1, 1, 3))


def weighted(mesh: str, borders: list[int], weights: Mapping[int, float], by: Iterable[float]) -> Move:
    """One linear interval: every vertex goes along `by`, times its weight. Rules: FAT-5."""
    x, y, z = by
    return _linear(mesh, borders, {i: (w * x, w * y, w * z) for i, w in weights.items() if abs(w) > 0.004})


def pieces(mesh: str, borders: list[int], unit: float, pose: Callable[[int, float], dict[int, Array]]) -> Move:
    """Several linear intervals from displacements (mm) at every border.

    Rules: FAT-2, FAT-3. `pose(border, unit)`: vertex to displacement, the same vertices at every border.
    """
    poses = {b: pose(b, unit) for b in borders}
    index = list(next(iter(poses.values())))
    steps = np.zeros((len(index), len(borders) - 1, 3))
    for j, (a, b) in enumerate(pairwise(borders)):
        for n, i in enumerate(index):
            d = (poses[b][i] - poses[a][i]) / ((b - a) * unit)
            # FAT-3: in a negative interval D is the direction moved as the value falls.
            steps[n, j] = d if a >= 0 else -d
    return Move(mesh, borders, index, steps)


def mirrored(model: Model, moves: list[Move]) -> list[Move]:
    """The same moves on the other side of the head. Rules: FAC-10."""
    out = []
    twin = model.skin.index
    for move in moves:
        index = move.index
        if move.mesh == "skin":
            index = [twin[model.skin.twin(model.skin.keys[i])] for i in index]
        out.append(Move(move.mesh.replace("left", "right"), move.borders, index, move.steps * (-1.0, 1.0, 1.0)))
    return out


def both(model: Model, fap: int, right: int, moves: list[Move]) -> Moves:
    """A motion of the left side and its mirror image as two FAPs. Rules: FAC-10."""
    return {fap: moves, right: mirrored(model, moves)}
