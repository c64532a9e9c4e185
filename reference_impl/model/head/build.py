"""Make the shipped head: `python -m snhc.reference_impl.model.head.build` writes `head.json` again, byte for byte.

Rules: FAC-1, FAC-2, FAC-3, FAC-6, FAC-10, FAT-1, FAT-5, FAT-8, FAT-9.
Not here: the shapes (`skin`, `parts`, `shape.json`), the motions (`mouth`, `face`, `motion.json`).

Visemes and expressions are `poses.json`: low-level FAP values at amplitude 63, turned into displacements per unit of
amplitude by the project's own FAT evaluation. The model's origin is feature point 7.1, in millimetres. All numbers
are rounded, so that the last bit of a machine's arithmetic does not show.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.model.fapu import UNITS_PER_DISTANCE
from snhc.reference_impl.model.fat import evaluate, fat_from_json

from . import HEAD_FILE, head_nodes, head_poses
from .face import face_moves
from .mouth import mouth_moves
from .moves import Model, Move
from .parts import Part, brow, ear, eyeball, hair, teeth, tongue
from .skin import Key, Skin

_FOLDER: Final = Path(__file__).parent
_EYES: Final = ("left_eye", "right_eye")
_POSE_AMPLITUDE: Final = 63
# Feature point to grid vertex, lid ring or lip ring of the left half; the right twin is in `_RIGHT_OF`.
_CENTRE_MARKS: Final[dict[str, Key]] = {
    "2.1": ("grid", 4, 0),
    "2.2": ("lip", 4, 0),
    "2.3": ("lip", 4, 10),
    "2.10": ("grid", 5, 0),
    "7.1": ("spine",),
    "8.1": ("lip", 2, 0),
    "8.2": ("lip", 2, 10),
    "9.3": ("grid", 13, 0),
    "9.12": ("grid", 15, 0),
    "9.15": ("grid", 11, 0),
    "11.4": ("crown",),
    "11.6": ("grid", 17, 12),
}
_LEFT_MARKS: Final[dict[str, Key]] = {
    "2.4": ("lip", 4, 5),
    "2.6": ("lip", 4, 2),
    "2.8": ("lip", 4, 8),
    "2.11": ("grid", 4, 3),
    "2.13": ("grid", 4, 8),
    "3.1": ("lid", 1, 3, 0),
    "3.3": ("lid", 1, 3, 8),
    "3.7": ("lid", 1, 3, 4),
    "3.9": ("lid", 1, 1, 8),
    "3.11": ("lid", 1, 3, 12),
    "3.13": ("lid", 1, 1, 0),
    "5.1": ("grid", 8, 5),
    "5.3": ("grid", 14, 5),
    "8.3": ("lip", 2, 5),
    "8.5": ("lip", 2, 2),
    "8.7": ("lip", 2, 8),
    "8.10": ("lip", 2, 1),
    "9.1": ("grid", 12, 2),
    "9.5": ("grid", 11, 2),
    "9.7": ("grid", 17, 1),
    "9.13": ("grid", 15, 1),
}
_RIGHT_OF: Final = {
    "2.4": "2.5",
    "2.6": "2.7",
    "2.8": "2.9",
    "2.11": "2.12",
    "2.13": "2.14",
    "3.1": "3.2",
    "3.3": "3.4",
    "3.5": "3.6",
    "3.7": "3.12",
    "3.9": "3.10",
    "3.11": "3.8",
    "3.13": "3.14",
    "4.1": "4.2",
    "4.3": "4.4",
    "4.5": "4.6",
    "5.1": "5.2",
    "5.3": "5.4",
    "8.3": "8.4",
    "8.5": "8.6",
    "8.7": "8.8",
    "8.10": "8.9",
    "9.1": "9.2",
    "9.5": "9.4",
    "9.7": "9.6",
    "9.13": "9.14",
    "10.1": "10.2",
    "10.3": "10.4",
    "10.5": "10.6",
    "10.7": "10.8",
    "10.9": "10.10",
}
# FAP to (node, field, definition). Positive: yaw to the left (+x), pitch down, roll to the right, thrust forward.
_TRANSFORMS: Final[dict[int, tuple[str, str, list[int]]]] = {
    23: ("left_eye_yaw", "rotation", [0, 1, 0, 1]),
    24: ("right_eye_yaw", "rotation", [0, 1, 0, 1]),
    25: ("left_eye_pitch", "rotation", [1, 0, 0, 1]),
    26: ("right_eye_pitch", "rotation", [1, 0, 0, 1]),
    27: ("left_eye_yaw", "translation", [0, 0, 1]),
    28: ("right_eye_yaw", "translation", [0, 0, 1]),
    48: ("head_pitch", "rotation", [1, 0, 0, 1]),
    49: ("head_yaw", "rotation", [0, 1, 0, 1]),
    50: ("head_roll", "rotation", [0, 0, 1, 1]),
}


def _data(name: str) -> Any:
    return json.loads((_FOLDER / name).read_text(encoding="utf-8"))


def _number(value: float, digits: int) -> float | int:
    rounded = round(float(value), digits)
    return int(rounded) if rounded == int(rounded) else rounded


def _rows(array: NDArray[np.float64], digits: int) -> list[list[float | int]]:
    return [[_number(v, digits) for v in row] for row in array]


@dataclass(slots=True)
class _Pose:
    faps: list[int | None]
    viseme: tuple[int, ...] | None = None
    expression: tuple[int, ...] | None = None


def _parts(shape: dict[str, Any], skin: Skin) -> dict[str, Part]:
    eye, left_ear, left_brow = eyeball(shape), ear(shape), brow(shape, skin.loft)
    eye.marks = {"3.5": eye.marks["pupil"]}
    return {
        "skin": Part([skin.points[k] for k in skin.keys], skin.faces, skin.colours, _skin_marks(skin)),
        "left_eye": eye,
        "right_eye": eye.mirrored(_RIGHT_OF),
        "left_brow": left_brow,
        "right_brow": left_brow.mirrored(_RIGHT_OF),
        "left_ear": left_ear,
        "right_ear": left_ear.mirrored(_RIGHT_OF),
        "teeth_upper": teeth(shape, "upper"),
        "teeth_lower": teeth(shape, "lower"),
        "tongue": tongue(shape),
        "hair": hair(shape, skin),
    }


def _skin_marks(skin: Skin) -> dict[str, int]:
    marks = {name: skin.index[key] for name, key in (_CENTRE_MARKS | _LEFT_MARKS).items()}
    return marks | {_RIGHT_OF[name]: skin.index[skin.twin(key)] for name, key in _LEFT_MARKS.items()}


def _face(
    parts: dict[str, Part], shape: dict[str, Any], vertices: dict[str, list[list[float | int]]]
) -> dict[str, Any]:
    eye, origin = shape["eye"], shape["origin"]
    ball = [eye["centre"][c] - origin[c] for c in range(3)]
    centres = {"left": ball, "right": [-ball[0], *ball[1:]]}
    points = {}
    for mesh, part in parts.items():
        offset = centres[mesh.split("_")[0]] if mesh in _EYES else [0, 0, 0]
        for name, vertex in part.marks.items():
            position = [_number(v + o, 3) for v, o in zip(vertices[mesh][vertex], offset, strict=True)]
            points[name] = {"position": position, "mesh": mesh, "vertex": vertex}
    iris, pupil = 2 * eye["iris"], 2 * shape["iris"]["rings"][0][0]
    return {
        "format": "snhc-face",
        "version": 1,
        "name": "head",
        "points": dict(sorted(points.items(), key=lambda item: [int(n) for n in item[0].split(".")])),
        "eye_centers": centres,
        "iris_diameters": {"left": iris, "right": iris},
        "pupil_diameters": {"left": pupil, "right": pupil},
    }


def _units(face: dict[str, Any]) -> dict[str, float]:
    at = {name: entry["position"] for name, entry in face["points"].items()}
    distances = {
        "ES": at["3.5"][0] - at["3.6"][0],
        "ENS": at["3.5"][1] - at["9.15"][1],
        "MNS": at["9.15"][1] - at["2.2"][1],
        "MW": at["8.3"][0] - at["8.4"][0],
        "IRISD": at["3.1"][1] - at["3.3"][1],
    }
    return {name: round(distance, 3) / UNITS_PER_DISTANCE for name, distance in distances.items()}


def _nodes(face: dict[str, Any], meshes: list[str]) -> dict[str, Any]:
    nodes = head_nodes([m for m in meshes if m not in _EYES])
    for side in ("left", "right"):
        nodes[f"{side}_eye_yaw"] = {"parent": "head_roll", "translation": face["eye_centers"][side]}
        nodes[f"{side}_eye_pitch"] = {"parent": f"{side}_eye_yaw", "meshes": [f"{side}_eye"]}
    return nodes


def _mesh_entry(move: Move, digits: int) -> dict[str, Any]:
    keep = [n for n in range(len(move.index)) if float(np.abs(move.steps[n]).max()) >= 0.5 * 10.0**-digits]
    order = sorted(keep, key=lambda n: move.index[n])
    return {
        "mesh": move.mesh,
        "intervalBorders": move.borders,
        "coordIndex": [move.index[n] for n in order],
        "displacements": [row for n in order for row in _rows(move.steps[n], digits)],
    }


def _low_tables(model: Model) -> list[dict[str, Any]]:
    moves = mouth_moves(model) | face_moves(model)
    tables = []
    for fap in sorted(moves.keys() | _TRANSFORMS.keys()):
        table: dict[str, Any] = {"fapID": fap, "highLevelSelect": 1}
        table["meshes"] = [_mesh_entry(move, 3) for move in moves.get(fap, [])]
        if fap in _TRANSFORMS:
            node, field, definition = _TRANSFORMS[fap]
            table["transforms"] = [{"node": node, "field": field, "def": definition}]
        tables.append(table)
    return tables


def _high_tables(document: dict[str, Any]) -> list[dict[str, Any]]:
    low = fat_from_json({key: document[key] for key in ("fapu", "meshes")} | {"tables": _no_transforms(document)})
    tables = []
    for fap, poses in enumerate(head_poses(), 1):
        for select, values in poses.items():
            posed = evaluate(low, _Pose([values.get(n + 1) for n in range(68)]))
            meshes = []
            for name, points in posed.items():
                step = (points - low.meshes[name].vertices)[:, None, :] / _POSE_AMPLITUDE
                move = Move(name, [0, _POSE_AMPLITUDE], list(range(len(points))), step)
                if float(np.abs(step).max()) > 1e-4:
                    meshes.append(_mesh_entry(move, 4))
            tables.append({"fapID": fap, "highLevelSelect": select, "meshes": meshes})
    return tables


def _no_transforms(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [{**table, "transforms": []} for table in document["tables"]]


def build_document() -> dict[str, Any]:
    """The head as a FAT document with colours and a face definition; see `load_head`. Rules: FAC-10, FAT-1."""
    shape, palette = _data("shape.json"), _data("palette.json")
    skin = Skin(shape)
    parts = _parts(shape, skin)
    vertices = {}
    for name, part in parts.items():
        shift = np.zeros(3) if name in _EYES else np.array(shape["origin"])
        vertices[name] = _rows(np.array(part.vertices) - shift, 3)
    face = _face(parts, shape, vertices)
    units = _units(face)
    neutral = {name: np.array(part.vertices) for name, part in parts.items()}
    marks = {point: (name, vertex) for name, part in parts.items() for point, vertex in part.marks.items()}
    model = Model(skin, neutral, marks, units, _data("motion.json"))
    names = list(palette)
    document: dict[str, Any] = {
        "fapu": units,
        "face": face,
        "palette": palette,
        "colors": {name: [names.index(c) for c in part.colours] for name, part in parts.items()},
        "meshes": {
            name: {"vertices": vertices[name], "faces": [list(f) for f in part.faces]} for name, part in parts.items()
        },
        "transforms": _nodes(face, list(parts)),
        "tables": _low_tables(model),
    }
    document["tables"] = _high_tables(document) + document["tables"]
    return document


def document_bytes(document: dict[str, Any]) -> bytes:
    """The document as compact JSON, a line per mesh, table, node and so on. Rules: FAC-10."""

    def compact(value: object) -> str:
        return json.dumps(value, separators=(",", ":"))

    lines = []
    for key, value in document.items():
        if isinstance(value, dict):
            inner = ",\n".join(f" {compact(k)}:{compact(v)}" for k, v in value.items())
            lines.append(f"{compact(key)}:{{\n{inner}\n}}")
        else:
            inner = ",\n".join(f" {compact(v)}" for v in value)
            lines.append(f"{compact(key)}:[\n{inner}\n]")
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode("ascii")


def main() -> int:
    """Write the data file anew. Rules: FAC-10."""
    HEAD_FILE.write_bytes(document_bytes(build_document()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
