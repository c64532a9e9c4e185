"""Face definitions: the 84 feature points, FAP units, the two file forms.

Rules: FAC-1, FAC-2 (the list of points), CNF-25. The checks of FAC-2 and FAC-3 are in `face_checks`.
Not implemented: meshes of a model (`fat_document`), missing points (FAC-11), adaptation (FAC-12 .. FAC-14).
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
)
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.documents.json_text import (
    MAX_JSON_BYTES,
    as_float,
    as_int,
    as_object,
    as_text,
    float_list,
    parse_json,
)
from snhc.reference_impl.model.fapu import UNITS_PER_DISTANCE, Fapu

Vec3 = tuple[float, float, float]

FORMAT: Final = "snhc-face"
SIDES: Final = ("left", "right")
_FEATURE_POINTS: Final = Path(__file__).parent / "feature_points.csv"
_POINT_NAME: Final = re.compile(r"[1-9][0-9]?\.[1-9][0-9]?")
_MAX_LINES: Final = 100_000


@dataclass(frozen=True, slots=True)
class FeaturePoint:
    """One row of table 6 of the paper.

    Rules: FAC-2. `point`: "group.number". `x`, `y`, `z`: constraints (`7.1.x`, `(2.2.x+2.4.x)/2`, `> 8.7.x
    and < 8.3.x`) or empty. `alternative`: what the table allows instead. `printed_x`: the formula as printed
    where the one followed differs (AMB-FAC-1).
    """

    point: str
    description: str
    x: str
    y: str
    z: str
    alternative: str
    printed_x: str


@cache
def feature_points() -> tuple[FeaturePoint, ...]:
    """The 84 feature points in the order of the table. Rules: FAC-2."""
    with _FEATURE_POINTS.open(encoding="utf-8", newline="") as file:
        return tuple(FeaturePoint(**row) for row in csv.DictReader(file))


@cache
def feature_point_names() -> frozenset[str]:
    """The names of the 84 points. Rules: FAC-2."""
    return frozenset(row.point for row in feature_points())


@dataclass(frozen=True, slots=True)
class FaceDefinition:
    """The feature points of a neutral face.

    Rules: FAC-1, FAC-2. Right-handed model coordinates: x to the face's left, y up, z out of the face.

    `points`: {"2.1": (x, y, z)}, some or all of the 84. `vertices`: {"2.1": (mesh or its number as text,
    vertex)} where known. `eye_centers`: {"left", "right"}: centres of the eyeballs. `iris_diameters`,
    `pupil_diameters`: the same keys.
    """

    points: Mapping[str, Vec3]
    name: str = ""
    vertices: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    eye_centers: Mapping[str, Vec3] = field(default_factory=dict)
    iris_diameters: Mapping[str, float] = field(default_factory=dict)
    pupil_diameters: Mapping[str, float] = field(default_factory=dict)

    def point(self, name: str) -> Vec3:
        """One feature point.

        Rules: FAC-2. Raises `InconsistentSemantics` at `points.<name>` where the face has it not.
        """
        found = self.points.get(name)
        if found is None:
            raise InconsistentSemantics(
                "FAC-2",
                "points",
                value=f"no {name}",
                allowed="a face with this feature point",
                path=f"points.{name}",
            )
        return found

    def distances(self) -> dict[str, float]:
        """ES0, ENS0, MNS0, MW0, IRISD0 in model units.

        Rules: FAC-1. IRISD0 is that of the left eye. Raises `InconsistentSemantics` where a point is missing.
        """
        return {
            "ES0": abs(self.point("3.5")[0] - self.point("3.6")[0]),
            "ENS0": abs(self.point("3.5")[1] - self.point("9.15")[1]),
            "MNS0": abs(self.point("9.15")[1] - self.point("2.2")[1]),
            "MW0": abs(self.point("8.3")[0] - self.point("8.4")[0]),
            "IRISD0": abs(self.point("3.1")[1] - self.point("3.3")[1]),
        }

    def fapu(self) -> Fapu:
        """The FAP units: distance / 1024.

        Rules: FAC-1. Raises as `distances`.
        """
        units = {name[:-1].lower(): distance / UNITS_PER_DISTANCE for name, distance in self.distances().items()}
        return Fapu(**units)


def _check_point_name(name: str, path: str) -> None:
    if name not in feature_point_names():
        raise InputFormat("FAC-2", "points", value=name, allowed="the feature points 2.1 .. 11.6", path=path)


def _vec3(value: object, path: str, rule: str) -> Vec3:
    x, y, z = float_list(value, path, rule, 3)
    return x, y, z


def _sides(root: Mapping[str, object], key: str) -> dict[str, object]:
    found = dict(as_object(root.get(key, {}), key, "FAC-3"))
    for side in found:
        if side not in SIDES:
            raise InputFormat("FAC-3", key, value=side, allowed="left, right", path=f"{key}.{side}")
    return found


def _diameters(root: Mapping[str, object], key: str) -> dict[str, float]:
    out: dict[str, float] = {}
    for side, value in _sides(root, key).items():
        out[side] = as_float(value, f"{key}.{side}", "FAC-3")
        if out[side] <= 0:
            raise RangeViolation("FAC-3", key, value=str(out[side]), allowed="above 0", path=f"{key}.{side}")
    return out


def face_definition_from_json(value: object) -> FaceDefinition:
    """A face definition from parsed JSON.

    Rules: FAC-1, FAC-2, CNF-25. The form:

        {"format": "snhc-face", "version": 1, "name": "...",
         "points": {"2.1": [x, y, z], "2.2": {"position": [x, y, z], "mesh": "Face", "vertex": 17}, ...},
         "eye_centers": {"left": [x, y, z], "right": [x, y, z]}, "iris_diameters": {"left": d, "right": d},
         "pupil_diameters": {"left": d, "right": d}}

    All but `points` may be absent; keys that are not known are ignored. Raises `InputFormat` and
    `InconsistentSemantics` with a path.
    """
    root = as_object(value, "", "FAC-2")
    if as_text(root.get("format", FORMAT), "format", "FAC-2") != FORMAT:
        raise InputFormat("FAC-2", "format", value=str(root["format"]), allowed=FORMAT, path="format")
    if as_int(root.get("version", 1), "version", "FAC-2") != 1:
        raise InputFormat("FAC-2", "version", value=str(root["version"]), allowed="1", path="version")
    points: dict[str, Vec3] = {}
    vertices: dict[str, tuple[str, int]] = {}
    for name, entry in as_object(root.get("points"), "points", "FAC-2").items():
        path = f"points.{name}"
        _check_point_name(name, path)
        if isinstance(entry, Mapping):
            points[name] = _vec3(entry.get("position"), f"{path}.position", "FAC-2")
            if "vertex" in entry:
                vertex = as_int(entry["vertex"], f"{path}.vertex", "FAC-2", 0, (1 << 31) - 1)
                vertices[name] = as_text(entry.get("mesh", ""), f"{path}.mesh", "FAC-2"), vertex
        else:
            points[name] = _vec3(entry, path, "FAC-2")
    centers = {side: _vec3(v, f"eye_centers.{side}", "FAC-5") for side, v in _sides(root, "eye_centers").items()}
    return FaceDefinition(
        points,
        as_text(root.get("name", ""), "name", "FAC-2"),
        vertices,
        centers,
        _diameters(root, "iris_diameters"),
        _diameters(root, "pupil_diameters"),
    )


def parse_face_definition_json(data: bytes | str) -> FaceDefinition:
    """A face definition from JSON text.

    Rules: FAC-2, CNF-22, CNF-25. Raises as `face_definition_from_json`.
    """
    return face_definition_from_json(parse_json(data, rule="FAC-2", what="face definition"))


def _column(line: str, index: int) -> int:
    return [match.start() for match in re.finditer(r"\S+", line)][index] + 1


def _number(token: str, line: str, number: int, index: int) -> float:
    try:
        value = float(token)
    except ValueError:
        value = float("nan")
    if not isfinite(value) or "_" in token:
        raise InputFormat(
            "FAC-2",
            "coordinate",
            value=token[:40],
            allowed="a finite number",
            line=number,
            column=_column(line, index),
        )
    return value


def parse_fdp(data: bytes | str) -> tuple[FaceDefinition, list[Finding]]:
    """A face definition from `.fdp` text: one line `g.n x y z m.v` per feature point.

    Rules: FAC-2, CNF-22, CNF-25. m.v (mesh number and vertex) may be missing or negative (no vertex). Blank
    lines, `#` comments, commas, carriage returns and a byte order mark are skipped. Findings: points outside
    the 84 of groups 2..11 (kept out), a point given twice (the last one counts). Raises `InputFormat` (line,
    column) for any other line, `ResourceLimit` past 256 MiB or 100,000 lines.
    """
    if len(data) > MAX_JSON_BYTES:
        raise ResourceLimit("CNF-22", "fdp", value=len(data), allowed=f"at most {MAX_JSON_BYTES} bytes", line=1)
    text = data.decode("utf-8-sig", "replace") if isinstance(data, bytes) else data.removeprefix("\ufeff")
    points: dict[str, Vec3] = {}
    vertices: dict[str, tuple[str, int]] = {}
    findings: list[Finding] = []
    for number, raw in enumerate(text.split("\n"), 1):
        if number > _MAX_LINES:
            raise ResourceLimit("CNF-22", "fdp", value=number, allowed=f"at most {_MAX_LINES} lines", line=number)
        line = raw.partition("#")[0].replace(",", " ")
        tokens = line.split()
        if not tokens:
            continue
        name = tokens[0]
        if not _POINT_NAME.fullmatch(name):
            raise InputFormat(
                "FAC-2",
                "feature point",
                value=name[:40],
                allowed="group.number",
                line=number,
                column=_column(line, 0),
            )
        if len(tokens) not in (4, 5):
            raise InputFormat(
                "FAC-2", "line", value=f"{len(tokens)} words", allowed="g.n x y z m.v", line=number,
                column=_column(line, 0),
            )  # fmt: skip
        x, y, z = (_number(tokens[i], line, number, i) for i in (1, 2, 3))
        if name not in feature_point_names():
            findings.append(
                Finding(
                    "fdp-point-unknown",
                    "info",
                    "FAC-2",
                    f"{name} is not a feature point: left out",
                    line=number,
                )
            )
            continue
        if name in points:
            findings.append(
                Finding(
                    "fdp-point-twice",
                    "warning",
                    "FAC-2",
                    f"{name} stands twice: the last counts",
                    line=number,
                )
            )
            vertices.pop(name, None)
        points[name] = x, y, z
        if len(tokens) == 5:
            place = re.fullmatch(r"(-?[0-9]{1,9})\.(-?[0-9]{1,9})", tokens[4])
            if place is None:
                raise InputFormat(
                    "FAC-2",
                    "vertex",
                    value=tokens[4][:40],
                    allowed="mesh.vertex",
                    line=number,
                    column=_column(line, 4),
                )
            if int(place[1]) >= 0 and int(place[2]) >= 0:
                vertices[name] = place[1], int(place[2])
    if not points:
        raise InputFormat("FAC-2", "fdp", value="no feature point", allowed="lines g.n x y z m.v", line=1, column=1)
    return FaceDefinition(points, vertices=vertices), findings


def fdp_text(definition: FaceDefinition) -> str:
    """The `.fdp` form of a definition, in the order of the table; mesh names that are no numbers give no m.v.

    Rules: FAC-2. Reading it back gives the same points.
    """
    lines: list[str] = []
    for row in feature_points():
        point = definition.points.get(row.point)
        if point is None:
            continue
        mesh, vertex = definition.vertices.get(row.point, ("", -1))
        place = f"{mesh}.{vertex}" if mesh.isascii() and mesh.isdigit() else "-1.-1"
        lines.append(f"{row.point} {point[0]!r} {point[1]!r} {point[2]!r} {place}")
    return "\n".join(lines) + "\n"


def load_face_definition(path: Path) -> FaceDefinition:
    """A face definition from a file of either form, told apart by content.

    Rules: FAC-1, FAC-2, CNF-2. Raises as the two parsers; `OSError` where the file cannot be read. Findings
    of the text form are dropped: call `parse_fdp` for them.
    """
    data = path.read_bytes()
    if data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{":
        return parse_face_definition_json(data)
    return parse_fdp(data)[0]
