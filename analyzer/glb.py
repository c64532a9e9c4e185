"""A moving head as a binary glTF 2.0 file (GLB), with morph targets and animation keys.

Rules: FAT-2..5, FAT-7, FAT-9, FAC-10.

One morph target per interval of each table that the frames use. Its vertices are what the whole interval adds, so
that its weight runs from 0 to 1 inside the interval, past 1 behind the last border, and below 0 only for tables of a
single interval, which serve both signs. The sum of weighted targets is the FAT sum. Transform nodes become nodes:
rotations, translations and scales that move are animated. Normals stay those of the neutral face.

Colours are materials: one primitive per colour, all with the vertices and targets of their mesh. Fields are written
by hand because the libraries at hand drop morph targets.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from fractions import Fraction
from math import sqrt
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import EncodeError, ResourceLimit
from snhc.reference_impl.model.fapu import fap_unit_names
from snhc.reference_impl.model.fat import FatReadings, FrameLike, amplitudes, interval_weights, node_transform
from snhc.reference_impl.model.fat_document import FaceDefMesh, FaceDefTables
from snhc.reference_impl.tables import fap_table

from .face_render import is_eye, vertex_normals
from .face_scene import FOLLOWED, FaceModel, posed_frames

MAX_WEIGHTS: Final = 1 << 27
_FLOAT: Final = 5126
_UINT32: Final = 5125
_ARRAY_BUFFER: Final = 34962
_ELEMENT_BUFFER: Final = 34963
_HIGH: Final = {1: "viseme", 2: "expression"}


class _Buffer:
    """The binary chunk with its views and accessors."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self._zeros: dict[int, int] = {}

    def view(self, data: bytes, target: int | None = None) -> int:
        self.data += bytes(-len(self.data) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.data += data
        self.views.append(view)
        return len(self.views) - 1

    def floats(self, array: NDArray[Any], kind: str, target: int | None = None, bounds: bool = False) -> int:
        rows = np.ascontiguousarray(array, "<f4")
        accessor = {
            "bufferView": self.view(rows.tobytes(), target), "byteOffset": 0, "componentType": _FLOAT,
            "count": len(rows), "type": kind,
        }  # fmt: skip
        return self._add(accessor, rows if bounds else None)

    def indices(self, array: NDArray[Any]) -> int:
        flat = np.ascontiguousarray(array, "<u4").reshape(-1)
        return self._add(
            {
                "bufferView": self.view(flat.tobytes(), _ELEMENT_BUFFER), "byteOffset": 0, "componentType": _UINT32,
                "count": len(flat), "type": "SCALAR",
            },
            None,
        )  # fmt: skip

    def sparse(self, count: int, index: NDArray[Any], rows: NDArray[Any]) -> int:
        """`count` vectors, 0 but for some: they share one view of zeros, which some readers insist on."""
        if count not in self._zeros:
            self._zeros[count] = self.view(bytes(12 * count), _ARRAY_BUFFER)
        values = np.ascontiguousarray(rows, "<f4")
        places = np.ascontiguousarray(index, "<u4")
        accessor = {
            "bufferView": self._zeros[count], "byteOffset": 0, "componentType": _FLOAT, "count": count, "type": "VEC3",
            "sparse": {
                "count": len(places),
                "indices": {"bufferView": self.view(places.tobytes()), "byteOffset": 0, "componentType": _UINT32},
                "values": {"bufferView": self.view(values.tobytes()), "byteOffset": 0},
            },
        }  # fmt: skip
        whole = values if len(places) == count else np.concatenate([values, np.zeros((1, 3), "<f4")])
        return self._add(accessor, whole)

    def _add(self, accessor: dict[str, Any], bounded: NDArray[Any] | None) -> int:
        if bounded is not None:
            rows = bounded.reshape(len(bounded), -1)
            accessor["min"] = rows.min(axis=0).tolist()
            accessor["max"] = rows.max(axis=0).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1


class _Target:
    """One interval of one table on one mesh, with its weight in every frame."""

    __slots__ = ("index", "name", "rows", "weights")

    def __init__(self, name: str, index: NDArray[Any], rows: NDArray[Any], weights: NDArray[np.float32]) -> None:
        self.name = name
        self.index = index
        self.rows = rows
        self.weights = weights


def _targets(
    model: FaceModel, name: str, moving: Sequence[dict[tuple[int, int], float]], readings: FatReadings
) -> list[_Target]:
    out: list[_Target] = []
    for table in model.document.tables:
        unit = model.document.fapu.unit(fap_unit_names()[table.fap_id - 1]) or 0.0
        key = (table.fap_id, table.high_level_select if table.fap_id in _HIGH else 0)
        values = [frame.get(key, 0.0) for frame in moving]
        if not any(values):
            continue
        for mesh in table.meshes:
            if mesh.mesh == name and len(mesh.coord_index):
                out += _table_targets(table, mesh, unit, values, readings)
    return out


def _table_targets(
    table: FaceDefTables, mesh: FaceDefMesh, unit: float, values: Sequence[float], readings: FatReadings
) -> list[_Target]:
    borders = mesh.interval_borders
    intervals = len(borders) - 1
    factors = np.zeros((len(values), intervals))
    for n, value in enumerate(values):
        for interval, factor in interval_weights(borders, value, readings):
            factors[n, interval] = factor
    # An index that stands twice moves its vertex twice.
    index, place = np.unique(mesh.coord_index, return_inverse=True)
    label = _label(table)
    out: list[_Target] = []
    for interval in range(intervals):
        if not factors[:, interval].any():
            continue
        length = max(abs(borders[0]), abs(borders[1])) if intervals == 1 else borders[interval + 1] - borders[interval]
        rows = np.zeros((len(index), 3))
        np.add.at(rows, place, unit * length * mesh.displacements[:, interval])
        name = label if intervals == 1 else f"{label} {borders[interval]}..{borders[interval + 1]}"
        out.append(_Target(name, index, rows, (factors[:, interval] / length).astype(np.float32)))
    return out


def _label(table: FaceDefTables) -> str:
    if table.fap_id in _HIGH:
        return f"{_HIGH[table.fap_id]} {table.high_level_select}"
    return f"{table.fap_id} {fap_table()[table.fap_id - 1].name}"


def _quaternion(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """x, y, z, w of a rotation matrix, by its largest component."""
    m = matrix
    four = np.array(
        [
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
            1 + m[0, 0] + m[1, 1] + m[2, 2],
        ]
    )
    k = int(four.argmax())
    s = 2 * sqrt(float(four[k]))
    out = np.empty(4)
    out[k] = s / 4
    if k == 3:
        out[:3] = (m[2, 1] - m[1, 2]) / s, (m[0, 2] - m[2, 0]) / s, (m[1, 0] - m[0, 1]) / s
        return out
    i, j = (k + 1) % 3, (k + 2) % 3
    out[i] = (m[i, k] + m[k, i]) / s
    out[j] = (m[j, k] + m[k, j]) / s
    out[3] = (m[j, i] - m[i, j]) / s
    return out


def _linear(colour: NDArray[Any]) -> list[float]:
    # glTF's colour factors are linear, the palette is sRGB.
    part = colour.astype(np.float64) / 255
    line = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return [*(round(float(v), 6) for v in line), 1.0]


class _Writer:
    def __init__(self, model: FaceModel, frames: Sequence[FrameLike], times: Sequence[float], r: FatReadings) -> None:
        self._model = model
        self._readings = r
        self._moving = [amplitudes(frame, r) for frame in posed_frames(model, frames)]
        self._buffer = _Buffer()
        self._still = len(times) < 2
        self._times = -1 if self._still else self._buffer.floats(np.array(times)[:, None], "SCALAR", bounds=True)
        self._materials: dict[tuple[bytes, bool], int] = {}
        self._samplers: list[dict[str, Any]] = []
        self._channels: list[dict[str, Any]] = []
        self._meshes: list[dict[str, Any]] = []
        self._nodes: list[dict[str, Any]] = []
        self._material_list: list[dict[str, Any]] = []

    def document(self) -> dict[str, Any]:
        root: dict[str, Any] = {"name": "face", "children": []}
        if self._model.unit != 1.0:
            root["scale"] = [self._model.unit] * 3
        self._nodes.append(root)
        places: dict[str, int] = {}
        below: dict[str, int] = {}
        for name, node in self._model.document.transforms.items():
            places[name] = len(self._nodes)
            self._nodes.append({"name": name})
            below |= dict.fromkeys(node.meshes, places[name])
            self._animate_node(name)
        for name, node in self._model.document.transforms.items():
            self._nodes[places[node.parent] if node.parent else 0].setdefault("children", []).append(places[name])
        for name, mesh in self._model.document.meshes.items():
            if len(mesh.faces):
                self._nodes[below.get(name, 0)].setdefault("children", []).append(len(self._nodes))
                self._mesh(name)
        if not root["children"]:
            raise EncodeError("FAT-1", "meshes", value=0, allowed="a model with faces")
        out: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "snhc"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self._nodes,
            "meshes": self._meshes,
            "materials": self._material_list,
            "buffers": [{"byteLength": len(self._buffer.data)}],
            "bufferViews": self._buffer.views,
            "accessors": self._buffer.accessors,
        }
        if self._channels:
            out["animations"] = [{"name": "faps", "samplers": self._samplers, "channels": self._channels}]
        return out

    @property
    def binary(self) -> bytes:
        return bytes(self._buffer.data)

    def _animate(self, path: str, accessor: int) -> None:
        self._channels.append({"sampler": len(self._samplers), "target": {"node": len(self._nodes) - 1, "path": path}})
        self._samplers.append({"input": self._times, "output": accessor, "interpolation": "LINEAR"})

    def _animate_node(self, name: str) -> None:
        node = self._model.document.transforms[name]
        scales: list[NDArray[np.float64]] = []
        turns: list[NDArray[np.float64]] = []
        shifts: list[NDArray[np.float64]] = []
        for values in self._moving:
            scale, rotations, shift = node_transform(self._model.document, node, values, self._readings)
            matrix = np.eye(3)
            for rotation in rotations:
                matrix = rotation @ matrix
            turn = _quaternion(matrix)
            # q and -q are one rotation; the nearer one makes the short way between keys.
            if turns and float(turn @ turns[-1]) < 0:
                turn = -turn
            scales.append(scale)
            turns.append(turn)
            shifts.append(shift)
        neutral = {"scale": [1.0] * 3, "rotation": [0.0, 0.0, 0.0, 1.0], "translation": [0.0] * 3}
        for path, kind, keys in (
            ("scale", "VEC3", scales),
            ("rotation", "VEC4", turns),
            ("translation", "VEC3", shifts),
        ):
            rows = np.array(keys).astype(np.float32)
            if rows[0].tolist() != neutral[path]:
                self._nodes[-1][path] = rows[0].tolist()
            if not self._still and (rows != rows[0]).any():
                self._animate(path, self._buffer.floats(rows, kind))

    def _mesh(self, name: str) -> None:
        mesh = self._model.document.meshes[name]
        buffer = self._buffer
        targets = _targets(self._model, name, self._moving, self._readings)
        if len(targets) * len(self._moving) > MAX_WEIGHTS:
            raise ResourceLimit(
                "CNF-22", "weights", value=len(targets) * len(self._moving), allowed=f"at most {MAX_WEIGHTS}"
            )
        attributes = {
            "POSITION": buffer.floats(mesh.vertices, "VEC3", _ARRAY_BUFFER, bounds=True),
            "NORMAL": buffer.floats(_normals(mesh.vertices, mesh.faces), "VEC3", _ARRAY_BUFFER),
        }
        morphs = [{"POSITION": buffer.sparse(len(mesh.vertices), t.index, t.rows)} for t in targets]
        colours, which = np.unique(self._model.colours[name], axis=0, return_inverse=True)
        primitives = []
        for number, colour in enumerate(colours):
            primitive: dict[str, Any] = {
                "attributes": attributes,
                "indices": buffer.indices(mesh.faces[which.reshape(-1) == number]),
                "material": self._material(colour, is_eye(name)),
            }
            if morphs:
                primitive["targets"] = morphs
            primitives.append(primitive)
        entry: dict[str, Any] = {"name": name, "primitives": primitives}
        self._nodes.append({"name": name, "mesh": len(self._meshes)})
        if targets:
            weights = np.stack([t.weights for t in targets], axis=1)
            entry["weights"] = weights[0].tolist()
            entry["extras"] = {"targetNames": [t.name for t in targets]}
            if not self._still:
                self._animate("weights", buffer.floats(weights.reshape(-1, 1), "SCALAR"))
        self._meshes.append(entry)

    def _material(self, colour: NDArray[Any], eye: bool) -> int:
        key = (colour.tobytes(), eye)
        if key not in self._materials:
            self._materials[key] = len(self._material_list)
            rough = 0.25 if eye else 0.7
            self._material_list.append(
                {
                    "name": "#" + colour.astype(np.uint8).tobytes().hex() + (" eye" if eye else ""),
                    "pbrMetallicRoughness": {
                        "baseColorFactor": _linear(colour), "metallicFactor": 0.0, "roughnessFactor": rough,
                    },
                }
            )  # fmt: skip
        return self._materials[key]


def _normals(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    normals = vertex_normals(points, faces)
    # glTF wants unit vectors, also where there is no face.
    normals[np.linalg.norm(normals, axis=1) < 0.5] = (0.0, 0.0, 1.0)
    return normals


def distinct_times(times: Sequence[Fraction]) -> tuple[list[int], list[float]]:
    """Which frames become keys, and their times in seconds from the first: strictly increasing in float32.

    Rules: FBA-38. Frames whose time does not increase are left out; glTF has no form for them.
    """
    keep: list[int] = []
    out: list[float] = []
    for n, time in enumerate(times):
        second = float(np.float32(float(time - times[0])))
        if not out or second > out[-1]:
            keep.append(n)
            out.append(second)
    return keep, out


def glb(
    model: FaceModel, frames: Sequence[FrameLike], times: Sequence[Fraction], readings: FatReadings = FOLLOWED
) -> bytes:
    """The GLB file of a model that plays the frames; a single frame gives a still head.

    Rules: FAC-6, FAT-2..5, FAT-7, FAT-9. `times`: seconds, one per frame. Raises EncodeError for no frame or a model
    without faces, ResourceLimit for too many weights.
    """
    keep, seconds = distinct_times(times)
    if not keep:
        raise EncodeError("CNF-19", "frames", value=0, allowed="1 or more")
    writer = _Writer(model, [frames[n] for n in keep], seconds, readings)
    text = json.dumps(writer.document(), separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = writer.binary
    binary += bytes(-len(binary) % 4)
    size = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join(
        (
            struct.pack("<4sII", b"glTF", 2, size),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary), b"BIN\0"),
            binary,
        )
    )
