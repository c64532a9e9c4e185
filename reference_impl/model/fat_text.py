"""FAT documents in the VRML/BT text form: FaceDefTables nodes and the scene graph that they move.

Rules: FAT-1, FAT-9, FAT-11, SYS-55, SYS-56 (indirect face sets, AMB-SYS-10), SYS-58, CNF-25.
Either one FDP node (featurePointsCoord, faceDefTables, faceSceneGraph) or the nodes side by side, in any
order. Not implemented: ROUTEs, Transform.center and scaleOrientation (`Unsupported`); normals, textures and
materials are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, SnhcError, Unsupported
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.documents.bt_text import BtNode, Token, floats, ints, nodes, parse_nodes, unknown_field
from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES
from snhc.reference_impl.model.face_definition import FaceDefinition, feature_points
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.fat_document import (
    MAX_FAT_VERTICES,
    NEUTRAL_ROTATION,
    NEUTRAL_SCALE,
    NEUTRAL_TRANSLATION,
    FaceDefMesh,
    FaceDefTables,
    FaceDefTransform,
    FatDocument,
    FatMesh,
    FloatArray,
    TransformNode,
    check_fat,
)

_TABLES: Final = frozenset(("fapID", "highLevelSelect", "faceDefMesh", "faceDefTransform"))
_MESH: Final = frozenset(("faceSceneGraphNode", "intervalBorders", "coordIndex", "displacements"))
_TRANSFORM: Final = frozenset(("faceSceneGraphNode", "fieldId", "rotationDef", "scaleDef", "translationDef"))
_DEFS: Final = {"rotationDef": "rotation", "scaleDef": "scale", "translationDef": "translation"}
# AMB-SYS-10 (a): the index in the ALL set of Transform.
_FIELD_IDS: Final = {4: "rotation", 5: "scale", 7: "translation"}
_GROUPS: Final = frozenset(("Group", "Shape", "Transform", "FDP", "Switch", "Anchor", "Billboard", "Collision"))


def _vector(node: BtNode, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    if name not in node.fields:
        return default
    values = floats(node.fields[name], name)
    if len(values) != len(default):
        place = node.places[name]
        raise InputFormat(
            "SYS-59", name, value=len(values), allowed=f"{len(default)} numbers", line=place.line, column=place.column
        )
    return values


def _points(node: BtNode, name: str) -> FloatArray:
    values = floats(node.fields.get(name, ()), name)
    if len(values) % 3:
        place = node.places[name]
        raise InputFormat(
            "SYS-59", name, value=len(values), allowed="three numbers each", line=place.line, column=place.column
        )
    out = np.array(values, dtype=np.float64).reshape(-1, 3)
    out.flags.writeable = False
    return out


def _children(node: BtNode) -> Iterator[BtNode]:
    for values in node.fields.values():
        for value in values:
            if isinstance(value, BtNode):
                yield value


@dataclass(slots=True)
class _Scene:
    meshes: dict[str, FatMesh] = field(default_factory=dict)
    transforms: dict[str, TransformNode] = field(default_factory=dict)
    # Every DEF name: the meshes at or below that node.
    below: dict[str, list[str]] = field(default_factory=dict)
    tables: list[BtNode] = field(default_factory=list)
    coordinates: dict[str, BtNode] = field(default_factory=dict)
    places: dict[str, Token] = field(default_factory=dict)
    feature_coordinates: BtNode | None = None

    def unique(self, name: str, stem: str, taken: dict[str, FatMesh] | dict[str, TransformNode]) -> str:
        if name and name not in taken:
            return name
        number = 1
        while f"{stem}{number}" in taken:
            number += 1
        return f"{stem}{number}"

    def coordinate(self, node: BtNode, name: str) -> BtNode | None:
        found = nodes(node.fields.get(name, ()), name)
        if not found:
            return None
        coordinate = found[0] if found[0].type else self.coordinates.get(found[0].name)
        if coordinate is None or coordinate.type != "Coordinate":
            raise InputFormat(
                "SYS-59", name, value=found[0].type or found[0].name, allowed="a Coordinate node",
                line=found[0].start.line, column=found[0].start.column,
            )  # fmt: skip
        return coordinate

    def names(self, node: BtNode) -> None:
        if node.type == "Coordinate" and node.name:
            self.coordinates[node.name] = node
        for child in _children(node):
            self.names(child)

    def walk(self, node: BtNode, parent: str, label: str) -> list[str]:
        """Collect a node; returns the meshes below it. `label`: the DEF name of the Shape above."""
        found: list[str] = []
        inner = parent
        if node.type == "FaceDefTables":
            self.tables.append(node)
            return found
        if node.type == "IndexedFaceSet":
            found = [self.face_set(node, parent, node.name or label)]
        elif node.type == "Transform":
            inner = self.transform(node, parent)
        elif node.type == "FDP" and "featurePointsCoord" in node.fields:
            self.feature_coordinates = self.coordinate(node, "featurePointsCoord")
        if node.type in _GROUPS:
            for child in _children(node):
                found += self.walk(child, inner, node.name if node.type == "Shape" else "")
        if node.type and node.name:
            self.below[node.name] = found
        return found

    def transform(self, node: BtNode, parent: str) -> str:
        turned = _vector(node, "scaleOrientation", NEUTRAL_ROTATION)[3] != 0
        for name, bad in (("center", any(_vector(node, "center", NEUTRAL_TRANSLATION))), ("scaleOrientation", turned)):
            if bad:
                place = node.places[name]
                raise Unsupported("FAT-9", name, value="not 0", allowed="0", line=place.line, column=place.column)
        name = self.unique(node.name, "Transform", self.transforms)
        self.places[f"transforms.{name}"] = node.start
        self.transforms[name] = TransformNode(
            name,
            _vector(node, "translation", NEUTRAL_TRANSLATION),
            _vector(node, "rotation", NEUTRAL_ROTATION),
            _vector(node, "scale", NEUTRAL_SCALE),
            (),
            parent,
        )
        return name

    def face_set(self, node: BtNode, parent: str, label: str) -> str:
        name = self.unique(label, "Mesh", self.meshes)
        self.places[f"meshes.{name}"] = node.start
        coordinate = self.coordinate(node, "coord")
        vertices = _points(coordinate, "point") if coordinate else np.zeros((0, 3))
        faces: list[tuple[int, int, int]] = []
        polygon: list[int] = []
        for index in (*ints(node.fields.get("coordIndex", ()), "coordIndex"), -1):
            if index != -1:
                polygon.append(index)
                continue
            faces += [(polygon[0], polygon[i], polygon[i + 1]) for i in range(1, len(polygon) - 1)]
            polygon = []
        self.meshes[name] = FatMesh(name, vertices, np.array(faces, dtype=np.int64).reshape(-1, 3))
        if parent:
            above = self.transforms[parent]
            self.transforms[parent] = replace(above, meshes=(*above.meshes, name))
        return name


def _target(node: BtNode) -> BtNode:
    found = nodes(node.fields.get("faceSceneGraphNode", ()), "faceSceneGraphNode")
    if len(found) != 1 or found[0].type:
        place = found[0].start if found else node.start
        raise InputFormat(
            "SYS-59", "faceSceneGraphNode", value=found[0].type if found else "NULL", allowed="USE name",
            line=place.line, column=place.column,
        )  # fmt: skip
    return found[0]


def _single(node: BtNode, name: str, default: int) -> int:
    values = ints(node.fields.get(name, ()), name)
    if name in node.fields and len(values) != 1:
        place = node.places[name]
        raise InputFormat(
            "SYS-59", name, value=len(values), allowed="one integer", line=place.line, column=place.column
        )
    return values[0] if values else default


def _face_def_mesh(scene: _Scene, node: BtNode, path: str, findings: list[Finding]) -> FaceDefMesh:
    unknown_field(node, _MESH)
    use = _target(node)
    name = use.name
    below = scene.below.get(name, [])
    if name not in scene.meshes:
        if len(below) != 1:
            raise InconsistentSemantics(
                "SYS-56", "faceSceneGraphNode", value=name, allowed="a node with exactly one IndexedFaceSet",
                path=path, line=use.start.line, column=use.start.column,
            )  # fmt: skip
        name = below[0]
        findings.append(
            Finding(
                "face-set-indirect", "info", "SYS-56", f"{use.name} stands for its face set {name}", None,
                use.start.line, path,
            )
        )  # fmt: skip
    borders = ints(node.fields.get("intervalBorders", ()), "intervalBorders")
    index = np.array(ints(node.fields.get("coordIndex", ()), "coordIndex"), dtype=np.int64)
    flat = _points(node, "displacements")
    intervals = max(len(borders) - 1, 0)
    if len(flat) != len(index) * intervals:
        place = node.places.get("displacements", node.end)
        raise InconsistentSemantics(
            "FAT-11", "displacements", value=len(flat), allowed="one vector per coordIndex entry and interval",
            path=f"{path}.displacements", expected=len(index) * intervals, line=place.line, column=place.column,
        )  # fmt: skip
    return FaceDefMesh(name, borders, index, flat.reshape(len(index), intervals, 3))


def _face_def_transform(scene: _Scene, node: BtNode, path: str, findings: list[Finding]) -> FaceDefTransform:
    unknown_field(node, _TRANSFORM)
    use = _target(node)
    if use.name not in scene.transforms:
        raise InconsistentSemantics(
            "SYS-56", "faceSceneGraphNode", value=use.name, allowed="a Transform node", path=path,
            line=use.start.line, column=use.start.column,
        )  # fmt: skip
    coded = [name for name in _DEFS if name in node.fields]
    number = _single(node, "fieldId", 1)
    if len(coded) == 1:
        kind = _DEFS[coded[0]]
    elif number in _FIELD_IDS:
        kind = _FIELD_IDS[number]
        findings.append(
            Finding(
                "field-id-guessed", "warning", "SYS-56", f"fieldId {number} was taken for {kind}", None,
                node.start.line, path,
            )
        )  # fmt: skip
    else:
        raise InconsistentSemantics(
            "SYS-56", "fieldId", value=number, allowed="4 rotation, 5 scale, 7 translation, or exactly one ...Def",
            path=path, line=node.start.line, column=node.start.column,
        )  # fmt: skip
    defaults = {"rotation": NEUTRAL_ROTATION, "scale": NEUTRAL_SCALE, "translation": NEUTRAL_TRANSLATION}
    return FaceDefTransform(use.name, kind, _vector(node, f"{kind}Def", defaults[kind]))


def _table(scene: _Scene, node: BtNode, path: str, findings: list[Finding]) -> FaceDefTables:
    unknown_field(node, _TABLES)
    meshes = nodes(node.fields.get("faceDefMesh", ()), "faceDefMesh")
    transforms = nodes(node.fields.get("faceDefTransform", ()), "faceDefTransform")
    return FaceDefTables(
        _single(node, "fapID", 1),
        _single(node, "highLevelSelect", 1),
        tuple(_face_def_mesh(scene, n, f"{path}.meshes[{i}]", findings) for i, n in enumerate(meshes)),
        tuple(_face_def_transform(scene, n, f"{path}.transforms[{i}]", findings) for i, n in enumerate(transforms)),
    )


def parse_fat_text(
    data: bytes | str,
    fapu: Fapu | None = None,
    *,
    max_vertices: int = MAX_FAT_VERTICES,
    limit: int = MAX_JSON_BYTES,
) -> tuple[FatDocument, list[Finding]]:
    """A FAT document from the text form, checked.

    Rules: FAT-1, FAT-9, FAT-11, SYS-55, SYS-56, SYS-58, CNF-25.

    `fapu`: the units; None takes them from the 84 points of featurePointsCoord, in the order of table 6.
    Meshes and nodes have their DEF names (a face set without one that of its Shape, else MeshN and
    TransformN). Raises `InputFormat` (line, column; also where there is neither a table nor a face set),
    `Unsupported`, and what `check_fat` raises with path, line and column of the table.
    """
    found = parse_nodes(data, limit=limit)
    scene = _Scene()
    for node in found:
        scene.names(node)
    for node in found:
        scene.walk(node, "", "")
    if not scene.tables and not scene.meshes:
        start = found[0].start if found else None
        raise InputFormat(
            "FAT-1", "text", value=start.text if start else "empty", allowed="FaceDefTables or IndexedFaceSet nodes",
            line=start.line if start else 1, column=start.column if start else 1,
        )  # fmt: skip
    if fapu is None:
        fapu = _feature_units(scene)
    findings: list[Finding] = []
    tables = tuple(_table(scene, node, f"tables[{i}]", findings) for i, node in enumerate(scene.tables))
    document = FatDocument(fapu, scene.meshes, tables, scene.transforms)
    try:
        check_fat(document, max_vertices=max_vertices)
    except SnhcError as error:
        place = _place(scene, error.path)
        if place is not None:
            error.line, error.column = place.line, place.column
        raise
    return document, findings


def _place(scene: _Scene, path: str) -> Token | None:
    for i, table in enumerate(scene.tables):
        if path.startswith(f"tables[{i}]"):
            return table.start
    return next((place for name, place in scene.places.items() if path.startswith(f"{name}.")), None)


def _feature_units(scene: _Scene) -> Fapu:
    if scene.feature_coordinates is None:
        return Fapu()
    points = _points(scene.feature_coordinates, "point")
    rows = feature_points()
    if len(points) != len(rows):
        place = scene.feature_coordinates.start
        raise InconsistentSemantics(
            "FAC-2", "featurePointsCoord", value=len(points), allowed="the 84 feature points", expected=len(rows),
            path="featurePointsCoord", line=place.line, column=place.column,
        )  # fmt: skip
    values = {row.point: (float(x), float(y), float(z)) for row, (x, y, z) in zip(rows, points, strict=True)}
    return FaceDefinition(values).fapu()


def _numbers(values: Sequence[float]) -> str:
    return " ".join(map(repr, values))


def fat_text(document: FatDocument) -> str:
    """The text form of a document (the units are not part of it); reading it back gives the same tables and
    meshes.

    Rules: FAT-1, FAT-9, SYS-58. Meshes that stand below no node come first, then the nodes, then the tables.
    """
    lines: list[str] = []
    below = {mesh for node in document.transforms.values() for mesh in node.meshes}

    def face_set(name: str) -> str:
        mesh = document.meshes[name]
        faces = " ".join(f"{a} {b} {c} -1" for a, b, c in mesh.faces.tolist())
        return (
            f"Shape {{ geometry DEF {name} IndexedFaceSet {{ coord Coordinate {{ point [ "
            f"{_numbers(mesh.vertices.reshape(-1).tolist())} ] }} coordIndex [ {faces} ] }} }}"
        )

    def transform(node: TransformNode) -> str:
        inner = [transform(child) for child in document.transforms.values() if child.parent == node.name]
        inner = [*map(face_set, node.meshes), *inner]
        return (
            f"DEF {node.name} Transform {{ translation {_numbers(node.translation)} rotation {_numbers(node.rotation)} "
            f"scale {_numbers(node.scale)} children [ {' '.join(inner)} ] }}"
        )

    lines += [face_set(name) for name in document.meshes if name not in below]
    lines += [transform(node) for node in document.transforms.values() if not node.parent]
    for table in document.tables:
        lines.append(f"FaceDefTables {{ fapID {table.fap_id} highLevelSelect {table.high_level_select}")
        lines.append("  faceDefMesh [")
        for mesh in table.meshes:
            lines.append(
                f"    FaceDefMesh {{ faceSceneGraphNode USE {mesh.mesh} "
                f"intervalBorders [ {_numbers(mesh.interval_borders)} ] "
                f"coordIndex [ {_numbers(mesh.coord_index.tolist())} ] "
                f"displacements [ {_numbers(mesh.displacements.reshape(-1).tolist())} ] }}"
            )
        lines.append("  ]")
        lines.append("  faceDefTransform [")
        for item in table.transforms:
            lines.append(
                f"    FaceDefTransform {{ faceSceneGraphNode USE {item.node} "
                f"{item.field}Def {_numbers(item.definition)} }}"
            )
        lines.append("  ]")
        lines.append("}")
    return "\n".join(lines) + "\n"
