"""Feature point motion from the FAPs of a frame; visemes and expressions as poses.

Rules: FAC-4, FAC-5 (AMB-FAC-2), FAC-6, FAC-7. Not implemented here: vertices (`fat`), init_face (FBA-33).
The definition of a visual `viseme` or `expression` is the model's: `high_level_faps` mixes poses that it is
given.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from math import cos, sin
from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.model.face_definition import FaceDefinition, Vec3
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.tables import fap_table

Matrix = tuple[Vec3, Vec3, Vec3]

HEAD_ORDERS: Final = frozenset("-".join(order) for order in permutations(("yaw", "pitch", "roll")))
MAX_AMPLITUDE: Final = 63
# x to the face's left, y up, z out of the face.
_DIRECTIONS: Final[dict[str, Vec3]] = {
    "left": (1.0, 0.0, 0.0),
    "right": (-1.0, 0.0, 0.0),
    "up": (0.0, 1.0, 0.0),
    "down": (0.0, -1.0, 0.0),
    "forward": (0.0, 0.0, 1.0),
}
_PUPILS: Final = {"left": "3.5", "right": "3.6"}
_EYE_FAPS: Final = {"left": (23, 25, 27, 29), "right": (24, 26, 28, 30)}
_HEAD_FAPS: Final = (48, 49, 50)
_TONGUE_ROLL: Final = 47
_TONGUE_BORDERS: Final = {"6.3": 1.0, "6.4": -1.0}
_IDENTITY: Final[Matrix] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class FeatureMotion:
    """The feature points of one frame.

    Rules: FAC-5. `points`: {"2.1": (x, y, z)}, model units. `head`: rotation about 7.1. `eyes`: {"left",
    "right"}: rotation of the eyeball about its centre, in the head's frame. `eye_centers`: the centres before
    the head turns. `pupil_growth`: added to the diameter of each pupil, model units.
    """

    points: Mapping[str, Vec3]
    head: Matrix
    eyes: Mapping[str, Matrix] = field(default_factory=dict)
    eye_centers: Mapping[str, Vec3] = field(default_factory=dict)
    pupil_growth: Mapping[str, float] = field(default_factory=dict)


def _axis_rotation(axis: str, angle: float) -> Matrix:
    c, s = cos(angle), sin(angle)
    if axis == "x":
        return (1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)
    if axis == "y":
        return (c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)
    return (c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)


def _apply(m: Matrix, v: Vec3) -> Vec3:
    x, y, z = (row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in m)
    return x, y, z


def _product(a: Matrix, b: Matrix) -> Matrix:
    columns = [_apply(a, (b[0][i], b[1][i], b[2][i])) for i in range(3)]
    x, y, z = ((columns[0][i], columns[1][i], columns[2][i]) for i in range(3))
    return x, y, z


def _about(m: Matrix, center: Vec3, v: Vec3) -> Vec3:
    x, y, z = _apply(m, (v[0] - center[0], v[1] - center[1], v[2] - center[2]))
    return center[0] + x, center[1] + y, center[2] + z


def _moved(v: Vec3, direction: Vec3, distance: float) -> Vec3:
    return v[0] + direction[0] * distance, v[1] + direction[1] * distance, v[2] + direction[2] * distance


def head_rotation(pitch: float, yaw: float, roll: float, order: str = "yaw-pitch-roll") -> Matrix:
    """The rotation of the head.

    Rules: FAC-5 (AMB-FAC-2). Angles in radians: pitch down, yaw to the face's left, roll to its right.
    `order`: one of the six
    orders of yaw, pitch and roll, intrinsic (each about the axes that the ones before it have
    turned).
    """
    if order not in HEAD_ORDERS:
        raise InputFormat("FAC-5", "order", value=order, allowed=", ".join(sorted(HEAD_ORDERS)))
    parts = {
        "pitch": _axis_rotation("x", pitch),
        "yaw": _axis_rotation("y", yaw),
        "roll": _axis_rotation("z", roll),
    }
    out = _IDENTITY
    for name in order.split("-"):
        out = _product(out, parts[name])
    return out


def eye_center(definition: FaceDefinition, side: str, fapu: Fapu) -> Vec3 | None:
    """The centre of an eyeball, None where the face has no such eye.

    Rules: FAC-5. Where the definition gives none: one iris diameter behind the pupil, which is the radius of
    a human eyeball within some per cent.
    """
    given = definition.eye_centers.get(side)
    pupil = definition.points.get(_PUPILS[side])
    if given is not None or pupil is None or fapu.irisd is None:
        return given
    return pupil[0], pupil[1], pupil[2] - 1024 * fapu.irisd


def feature_motion(
    definition: FaceDefinition,
    faps: Sequence[float | None],
    *,
    fapu: Fapu | None = None,
    order: str = "yaw-pitch-roll",
) -> FeatureMotion:
    """Where the feature points of a face are in one frame.

    Rules: FAC-4, FAC-5 (AMB-FAC-2). `faps`: 68 values in FAP units, None moves nothing; FAP 1 and 2 are not
    read. `fapu`: the units, by default those of the definition. Linear FAPs move their points by value * FAPU
    along the named axis; FAP 23..28 turn and thrust the eyeball and its pupil; 29, 30 are in `pupil_growth`;
    47 turns the borders of the tongue upward about 6.2; then 48..50 turn every point about 7.1. Points that
    the definition lacks are left out. Raises `InconsistentSemantics` (a unit or point that is needed and
    missing, not 68 values).
    """
    if len(faps) != 68:
        raise InconsistentSemantics("CNF-1", "faps", value=len(faps), allowed="68 values", path="faps", expected=68)
    units = definition.fapu() if fapu is None else fapu
    points = dict(definition.points)

    def scaled(fap: int) -> float:
        value = faps[fap - 1]
        if value is None or value == 0:
            return 0.0
        unit = units.unit(table[fap - 1].unit)
        if unit is None:
            name = table[fap - 1].unit
            raise InconsistentSemantics(
                "FAC-1", "fapu", value="absent", allowed=f"the unit {name}", path=f"fapu.{name}"
            )
        return value * unit

    table = fap_table()
    for record in table[2:]:
        direction = _DIRECTIONS.get(record.positive_motion)
        if direction is None or record.unit == "AU" or record.fdp_group is None:
            continue
        distance = scaled(record.number)
        for number in record.fdp_point:
            name = f"{record.fdp_group}.{number}"
            if distance and name in points:
                points[name] = _moved(points[name], direction, distance)
    _roll_tongue(points, scaled(_TONGUE_ROLL))
    eyes, centers, growth = _turn_eyes(definition, points, units, scaled)
    head = head_rotation(scaled(_HEAD_FAPS[0]), scaled(_HEAD_FAPS[1]), scaled(_HEAD_FAPS[2]), order)
    if head != _IDENTITY:
        pivot = definition.point("7.1")
        points = {name: _about(head, pivot, point) for name, point in points.items()}
    return FeatureMotion(points, head, eyes, centers, growth)


def _roll_tongue(points: dict[str, Vec3], angle: float) -> None:
    if angle and "6.2" in points:
        for name, side in _TONGUE_BORDERS.items():
            if name in points:
                turn = _axis_rotation("z", side * angle)
                points[name] = _about(turn, points["6.2"], points[name])


def _turn_eyes(
    definition: FaceDefinition, points: dict[str, Vec3], units: Fapu, scaled: Callable[[int], float]
) -> tuple[dict[str, Matrix], dict[str, Vec3], dict[str, float]]:
    eyes: dict[str, Matrix] = {}
    centers: dict[str, Vec3] = {}
    growth: dict[str, float] = {}
    for side, (yaw, pitch, thrust, dilate) in _EYE_FAPS.items():
        center = eye_center(definition, side, units)
        eyes[side] = _product(_axis_rotation("y", scaled(yaw)), _axis_rotation("x", scaled(pitch)))
        growth[side] = scaled(dilate)
        if center is None:
            continue
        forward = scaled(thrust)
        pupil = points.get(_PUPILS[side])
        centers[side] = _moved(center, _DIRECTIONS["forward"], forward)
        if pupil is not None and (forward or eyes[side] != _IDENTITY):
            thrusted = _moved(pupil, _DIRECTIONS["forward"], forward)
            points[_PUPILS[side]] = _about(eyes[side], centers[side], thrusted)
    return eyes, centers, growth


Pose = Mapping[int, float]


def high_level_faps(
    faps: Sequence[int | None],
    viseme: Sequence[int] | None,
    expression: Sequence[int] | None,
    visemes: Mapping[int, Pose],
    expressions: Mapping[int, Pose],
) -> tuple[float | None, ...]:
    """The 68 values of a frame with FAP 1 and 2 turned into low-level FAPs; low-level FAPs override.

    Rules: FAC-6. `viseme`: (select1, select2, blend, ...), `expression`: (select1, intensity1, select2,
    intensity2, ...) or None. `visemes`, `expressions`: {select: {FAP: value at full amplitude}}; select 0 and
    selects without a pose are neutral. Mouth = v1 * blend/63 + v2 * (1 - blend/63); expressions add pose *
    intensity/63; what both give adds.
    """
    mixed: dict[int, float] = {}

    def add(poses: Mapping[int, Pose], select: int, weight: float) -> None:
        for fap, value in poses.get(select, {}).items():
            mixed[fap] = mixed.get(fap, 0.0) + value * weight

    if viseme is not None:
        blend = min(max(viseme[2], 0), MAX_AMPLITUDE) / MAX_AMPLITUDE
        add(visemes, viseme[0], blend)
        add(visemes, viseme[1], 1.0 - blend)
    if expression is not None:
        for select, intensity in (expression[0:2], expression[2:4]):
            add(expressions, select, min(max(intensity, 0), MAX_AMPLITUDE) / MAX_AMPLITUDE)
    out: list[float | None] = [None, None]
    for i in range(2, 68):
        low = faps[i]
        out.append(mixed.get(i + 1) if low is None else float(low))
    return tuple(out)


def unidirectional_findings(faps: Sequence[int | None], index: int) -> list[Finding]:
    """A finding for every negative value of a unidirectional FAP.

    Rules: FAC-7. `faps`: 68 values. `index`: of the frame, for the path.
    """
    return [
        Finding(
            "negative-unidirectional",
            "warning",
            "FAC-7",
            f"FAP {record.number} ({record.name}) is {value}, a unidirectional FAP is 0 or more",
            path=f"frame[{index}].faps[{record.number - 1}]",
        )
        for record, value in zip(fap_table(), faps, strict=True)
        if record.direction == "U" and value is not None and value < 0
    ]
