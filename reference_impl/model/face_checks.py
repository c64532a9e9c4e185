"""Checks of a face definition: the constraints of table 6 and the neutral face.

Rules: FAC-1 (right iris), FAC-2 (AMB-FAC-1), FAC-3, CNF-23. A check whose points the face lacks is not made;
what was not checked is listed by `missing_points`. Not implemented: properties that points cannot decide
(relaxed muscles, the shape of the tongue).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.model.face_definition import FaceDefinition, FeaturePoint, feature_points

DEFAULT_TOLERANCE: Final = 0.02
IRIS_TOLERANCE: Final = 0.01
_AXES: Final = "xyz"
_REFERENCE: Final = re.compile(r"(\d+\.\d+)\.([xyz])")
_MIDPOINT: Final = re.compile(r"\((\d+\.\d+\.[xyz])\+(\d+\.\d+\.[xyz])\)/2")
_ORDER: Final = re.compile(r"([<>]) (\d+\.\d+\.[xyz])")


@dataclass(frozen=True, slots=True)
class FaceCheck:
    """One check that failed.

    Rules: FAC-1, FAC-2, FAC-3. `point`: the point or unit. `axis`: "x", "y", "z" or "". `value`: what was
    measured, `wanted`: what it should be (for orderings: the limit), `tolerance`: model units. `finding`: the
    same for reports.
    """

    point: str
    axis: str
    value: float
    wanted: float
    tolerance: float
    finding: Finding


def missing_points(definition: FaceDefinition) -> tuple[str, ...]:
    """Which of the 84 points a face lacks, in the order of the table. Rules: FAC-2."""
    return tuple(row.point for row in feature_points() if row.point not in definition.points)


def _failure(
    identity: str, rule: str, point: str, axis: str, values: tuple[float, float, float], law: str
) -> FaceCheck:
    value, wanted, tolerance = values
    name = f"{point}.{axis}" if axis else point
    text = f"{name} is {value!r}, {law} is {wanted!r} (tolerance {tolerance!r})"
    return FaceCheck(
        point, axis, value, wanted, tolerance, Finding(identity, "warning", rule, text, path=f"points.{name}")
    )


class _Face:
    def __init__(self, definition: FaceDefinition, tolerance: float | None) -> None:
        self.points = definition.points
        if tolerance is None:
            distance = abs(definition.point("3.5")[0] - definition.point("3.6")[0])
            tolerance = DEFAULT_TOLERANCE * distance
        self.tolerance = tolerance

    def at(self, name: str) -> float | None:
        match = _REFERENCE.fullmatch(name)
        if match is None or match[1] not in self.points:
            return None
        return self.points[match[1]][_AXES.index(match[2])]


def _constraint(face: _Face, row: FeaturePoint, axis: str, text: str) -> list[FaceCheck]:
    value = face.at(f"{row.point}.{axis}")
    if value is None:
        return []
    orders = _ORDER.findall(text)
    if orders:
        out: list[FaceCheck] = []
        for sign, name in orders:
            limit = face.at(name)
            # On the limit is not beyond it, but a face may be that flat: the tolerance counts here too.
            if limit is not None and (limit - value if sign == ">" else value - limit) > face.tolerance:
                law = f"it should be {sign} {name}, which"
                out.append(
                    _failure(
                        "feature-point-location",
                        "FAC-2",
                        row.point,
                        axis,
                        (value, limit, face.tolerance),
                        law,
                    )
                )
        return out
    middle = _MIDPOINT.fullmatch(text)
    names = middle.groups() if middle else (text,)
    parts = [face.at(name) for name in names]
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return []
    wanted = sum(known) / len(known)
    if abs(value - wanted) <= face.tolerance:
        return []
    law = text + (f" (or {row.alternative})" if row.alternative else "")
    return [_failure("feature-point-location", "FAC-2", row.point, axis, (value, wanted, face.tolerance), law)]


def check_locations(
    definition: FaceDefinition, *, tolerance: float | None = None, reading: str = "anatomy"
) -> list[FaceCheck]:
    """The location constraints of table 6 that a face does not keep.

    Rules: FAC-2 (AMB-FAC-1). `tolerance`: model units, by default 2 % of ES0. `reading`: "anatomy" (the eye
    and side the point belongs to) or "printed". An order fails when the value is on the wrong side by more
    than the tolerance. Where the table allows something else (nose bump, uppermost point of the contour) the
    severity is info. Raises `InconsistentSemantics` where the default tolerance needs a pupil that is
    missing.
    """
    face = _Face(definition, tolerance)
    out: list[FaceCheck] = []
    for row in feature_points():
        x = row.printed_x if reading == "printed" and row.printed_x else row.x
        for axis, text in zip(_AXES, (x, row.y, row.z), strict=True):
            if text:
                out += _constraint(face, row, axis, text)
    return out


# (point, axis, other point, law): the two are equal in the neutral face.
_EQUAL: Final = (
    ("2.2", "y", "2.3.y", "lips in contact: 2.3.y"),
    ("2.6", "y", "2.8.y", "lips in contact: 2.8.y"),
    ("2.7", "y", "2.9.y", "lips in contact: 2.9.y"),
    ("2.4", "y", "2.2.y", "line of the lips at corner height: 2.2.y"),
    ("2.5", "y", "2.2.y", "line of the lips at corner height: 2.2.y"),
    ("9.10", "y", "9.11.y", "upper teeth touch lower teeth: 9.11.y"),
    ("6.1", "y", "9.10.y", "tip of the tongue at the boundary of the teeth: 9.10.y"),
)
_EYES: Final = {"left": ("3.5", "3.1", "3.3"), "right": ("3.6", "3.2", "3.4")}


def check_neutral(definition: FaceDefinition, *, tolerance: float | None = None) -> list[FaceCheck]:
    """What the geometry of a face says against its being neutral.

    Rules: FAC-3, FAC-1 (the irises agree within 1 %). `tolerance`: model units, by default 2 % of ES0. Gaze
    needs `eye_centers`; the pupil and the iris need their diameters. Lids are tangent to an iris around the
    pupil when both are equally far from it. Raises as `check_locations`.
    """
    face = _Face(definition, tolerance)
    out: list[FaceCheck] = []

    def equal(point: str, axis: str, value: float | None, wanted: float | None, law: str) -> None:
        if value is not None and wanted is not None and abs(value - wanted) > face.tolerance:
            out.append(_failure("neutral-face", "FAC-3", point, axis, (value, wanted, face.tolerance), law))

    for point, axis, other, law in _EQUAL:
        equal(point, axis, face.at(f"{point}.{axis}"), face.at(other), law)
    heights: dict[str, float] = {}
    for side, (pupil, upper, lower) in _EYES.items():
        y, top, bottom = (face.at(f"{name}.y") for name in (pupil, upper, lower))
        if top is not None and bottom is not None:
            heights[side] = abs(top - bottom)
            equal(pupil, "y", y, (top + bottom) / 2, f"lids tangent to the iris: ({upper}.y+{lower}.y)/2")
            iris = definition.iris_diameters.get(side)
            equal(
                f"iris_diameters.{side}",
                "",
                iris,
                heights[side],
                "lids tangent to the iris: their distance",
            )
        iris = definition.iris_diameters.get(side, heights.get(side))
        if iris is not None:
            wanted = iris / 3
            law = "a third of the iris"
            equal(f"pupil_diameters.{side}", "", definition.pupil_diameters.get(side), wanted, law)
        center = definition.eye_centers.get(side)
        if center is not None:
            for i, axis in enumerate("xy"):
                equal(
                    pupil,
                    axis,
                    face.at(f"{pupil}.{axis}"),
                    center[i],
                    "gaze along z: centre of the eyeball",
                )
    if len(heights) == 2:
        left, right = heights["left"], heights["right"]
        allowed = IRIS_TOLERANCE * left
        if abs(left - right) > allowed:
            out.append(_failure("iris-diameter", "FAC-1", "IRISD0", "", (right, left, allowed), "that of the left eye"))
    return out
