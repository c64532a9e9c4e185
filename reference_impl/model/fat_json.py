"""FAT documents as JSON, in and out.

Rules: FAT-1, FAT-8 (selects), FAT-9 (field names), FAT-11, FAC-1 (units), CNF-22, CNF-25 (faults have a
path). The key `parent` of a transform (the node above it) is this project's own addition.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from pathlib import Path

import numpy as np

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation, ResourceLimit
from snhc.reference_impl.documents.json_text import (
    JsonObject,
    as_array,
    as_float,
    as_int,
    as_object,
    as_text,
    entries,
    float_list,
    int_list,
    parse_json,
)
from snhc.reference_impl.model.fapu import AU, UNIT_NAMES, Fapu
from snhc.reference_impl.model.fat_document import (
    MAX_FAT_VERTICES,
    NEUTRAL_ROTATION,
    NEUTRAL_SCALE,
    NEUTRAL_TRANSLATION,
    TRANSFORM_FIELDS,
    FaceDefMesh,
    FaceDefTables,
    FaceDefTransform,
    FatDocument,
    FatMesh,
    FloatArray,
    IntArray,
    TransformNode,
    check_borders,
    check_fat,
    count_fault,
)


def vectors(value: object, path: str) -> FloatArray:
    """An array of three-component vectors.

    Rules: FAT-1, CNF-25. Returns float64 (N, 3). Raises `InputFormat` or `InconsistentSemantics` at the
    entry.
    """
    array = as_array(value, path, "FAT-1")
    # The types decide: numpy would take the string "1" for a number.
    if not (
        set(map(type, array)) <= {list}
        and set(map(len, array)) <= {3}  # type: ignore[arg-type]
        and set(map(type, chain.from_iterable(array))) <= {int, float}  # type: ignore[arg-type]
    ):
        for i, entry in enumerate(array):
            float_list(entry, f"{path}[{i}]", "FAT-1", 3)
    try:
        out = np.array(array, dtype=np.float64).reshape(-1, 3)
    except OverflowError:
        out = np.full((len(array), 3), np.inf)
    if not np.isfinite(out).all():
        for i, entry in enumerate(array):
            float_list(entry, f"{path}[{i}]", "FAT-1", 3)
    out.flags.writeable = False
    return out


def _indices(value: object, path: str) -> IntArray:
    out = np.array(int_list(value, path, "FAT-1", -(1 << 31), (1 << 31) - 1), dtype=np.int64)
    out.flags.writeable = False
    return out


def _faces(value: object, path: str) -> IntArray:
    rows: list[tuple[int, ...]] = []
    for at, entry in entries(value, path, "FAT-1"):
        row = int_list(entry, at, "FAT-1", -(1 << 31), (1 << 31) - 1)
        if len(row) != 3:
            raise InconsistentSemantics("FAT-1", "faces", value=len(row), allowed="triangles", path=at, expected=3)
        rows.append(row)
    out = np.array(rows, dtype=np.int64).reshape(-1, 3)
    out.flags.writeable = False
    return out


ReadDefinition = Callable[[str], Fapu]


def _fapu(value: object, read_definition: ReadDefinition | None) -> Fapu:
    units = as_object(value, "fapu", "FAC-1")
    if "face" in units:
        name = as_text(units["face"], "fapu.face", "FAC-1")
        if read_definition is None:
            raise InputFormat(
                "FAC-1",
                "face",
                value=name,
                allowed="unit values (the document is not read from a folder)",
                path="fapu.face",
            )
        return read_definition(name)
    found: dict[str, float] = {}
    for name in UNIT_NAMES:
        if name in units:
            unit = as_float(units[name], f"fapu.{name}", "FAC-1")
            if unit < 0:
                raise RangeViolation("FAC-1", name, value=str(unit), allowed="0 or more", path=f"fapu.{name}")
            found[name.lower()] = unit
    if "AU" in units and as_float(units["AU"], "fapu.AU", "FAC-1") != AU:
        raise InconsistentSemantics("FAC-1", "AU", value=str(units["AU"]), allowed=str(AU), path="fapu.AU")
    return Fapu(**found)


def _face_def_mesh(value: object, path: str) -> FaceDefMesh:
    node = as_object(value, path, "FAT-1")
    borders = int_list(node.get("intervalBorders", []), f"{path}.intervalBorders", "FAT-1", -(1 << 31), (1 << 31) - 1)
    index = _indices(node.get("coordIndex", []), f"{path}.coordIndex")
    flat = vectors(node.get("displacements", []), f"{path}.displacements")
    check_borders(borders, f"{path}.intervalBorders", empty=not len(index))
    intervals = max(len(borders) - 1, 0)
    if len(flat) != len(index) * intervals:
        raise count_fault(len(flat), len(index) * intervals, f"{path}.displacements")
    return FaceDefMesh(
        as_text(node.get("mesh"), f"{path}.mesh", "FAT-1"),
        borders,
        index,
        flat.reshape(len(index), intervals, 3),
    )


def _face_def_transform(value: object, path: str) -> FaceDefTransform:
    node = as_object(value, path, "FAT-9")
    name = as_text(node.get("node"), f"{path}.node", "FAT-9")
    kind = as_text(node.get("field"), f"{path}.field", "FAT-9")
    if kind not in TRANSFORM_FIELDS:
        raise InputFormat("FAT-9", "field", value=kind, allowed=", ".join(TRANSFORM_FIELDS), path=f"{path}.field")
    return FaceDefTransform(name, kind, float_list(node.get("def"), f"{path}.def", "FAT-9", TRANSFORM_FIELDS[kind]))


def _table(value: object, path: str) -> FaceDefTables:
    node = as_object(value, path, "FAT-1")
    return FaceDefTables(
        as_int(node.get("fapID", 1), f"{path}.fapID", "FAT-8", 1, 68),
        as_int(node.get("highLevelSelect", 1), f"{path}.highLevelSelect", "FAT-8", 1, 64),
        tuple(_face_def_mesh(v, at) for at, v in entries(node.get("meshes", []), f"{path}.meshes", "FAT-1")),
        tuple(
            _face_def_transform(v, at) for at, v in entries(node.get("transforms", []), f"{path}.transforms", "FAT-9")
        ),
    )


def _node(name: str, value: object) -> TransformNode:
    path = f"transforms.{name}"
    node = as_object(value, path, "FAT-9")
    return TransformNode(
        name,
        float_list(node.get("translation", list(NEUTRAL_TRANSLATION)), f"{path}.translation", "FAT-9", 3),
        float_list(node.get("rotation", list(NEUTRAL_ROTATION)), f"{path}.rotation", "FAT-9", 4),
        float_list(node.get("scale", list(NEUTRAL_SCALE)), f"{path}.scale", "FAT-9", 3),
        tuple(as_text(v, at, "FAT-9") for at, v in entries(node.get("meshes", []), f"{path}.meshes", "FAT-9")),
        as_text(node.get("parent", ""), f"{path}.parent", "FAT-9"),
    )


def fat_from_json(
    value: object, *, read_definition: ReadDefinition | None = None, max_vertices: int = MAX_FAT_VERTICES
) -> FatDocument:
    """A FAT document from parsed JSON, checked.

    Rules: FAT-1, FAT-8, FAT-9, FAT-11, FAC-1, CNF-22, CNF-25. Keys that are not known are ignored.

    `read_definition`: gives the units of the face definition that {"fapu": {"face": name}} names.
    Raises `InputFormat` (wrong types), and what `check_fat` raises; every fault has a path.
    """
    root: JsonObject = as_object(value, "", "FAT-1")
    if root and not any(key in root for key in ("fapu", "meshes", "tables", "transforms")):
        # Some other document; an empty object is a model without meshes.
        raise InputFormat("FAT-1", "FAT", value="no key of one", allowed="fapu, meshes, tables, transforms")
    meshes: dict[str, FatMesh] = {}
    for name, entry in as_object(root.get("meshes", {}), "meshes", "FAT-1").items():
        path = f"meshes.{name}"
        mesh = as_object(entry, path, "FAT-1")
        points = as_array(mesh.get("vertices", []), f"{path}.vertices", "FAT-1")
        if len(points) > max_vertices:
            raise ResourceLimit("CNF-22", "vertices", value=len(points), allowed=f"at most {max_vertices}", path=path)
        meshes[name] = FatMesh(
            name, vectors(points, f"{path}.vertices"), _faces(mesh.get("faces", []), f"{path}.faces")
        )
    fapu = _fapu(root.get("fapu", {}), read_definition)
    nodes = as_object(root.get("transforms", {}), "transforms", "FAT-9")
    tables = tuple(_table(v, at) for at, v in entries(root.get("tables", []), "tables", "FAT-1"))
    document = FatDocument(fapu, meshes, tables, {name: _node(name, v) for name, v in nodes.items()})
    check_fat(document, max_vertices=max_vertices)
    return document


def parse_fat_json(
    data: bytes | str, *, read_definition: ReadDefinition | None = None, max_vertices: int = MAX_FAT_VERTICES
) -> FatDocument:
    """A FAT document from JSON text.

    Rules: FAT-1, FAT-11, CNF-22, CNF-25. Arguments and errors as `fat_from_json`; `InputFormat` with line and
    column where the text is not JSON.
    """
    value = parse_json(data, rule="FAT-1", what="FAT document")
    return fat_from_json(value, read_definition=read_definition, max_vertices=max_vertices)


def load_fat(path: Path, *, max_vertices: int = MAX_FAT_VERTICES) -> FatDocument:
    """A FAT document from a JSON file; {"fapu": {"face": name}} is read from the same folder.

    Rules: FAT-1, FAT-11, FAC-1. Raises as `fat_from_json`; `OSError` where the file cannot be read.
    """
    return parse_fat_json(path.read_bytes(), read_definition=definition_reader(path.parent), max_vertices=max_vertices)


def definition_reader(folder: Path) -> ReadDefinition:
    """A function that reads the units of a face definition in a folder. Rules: FAC-1."""
    from snhc.reference_impl.model.face_definition import load_face_definition

    def read(name: str) -> Fapu:
        try:
            return load_face_definition(folder / name).fapu()
        except OSError as error:
            raise InputFormat(
                "FAC-1", "face", value=name, allowed=f"a readable file ({error.strerror})", path="fapu.face"
            ) from None

    return read


def fat_to_json(document: FatDocument) -> dict[str, object]:
    """The JSON form of a document, ready for `json.dumps`; reading it back gives the same numbers.

    Rules: FAT-1, FAT-9.
    """
    units = {name: document.fapu.unit(name) for name in UNIT_NAMES}
    return {
        "fapu": {name: value for name, value in units.items() if value is not None},
        "meshes": {
            name: {"vertices": mesh.vertices.tolist(), "faces": mesh.faces.tolist()}
            for name, mesh in document.meshes.items()
        },
        "tables": [
            {
                "fapID": table.fap_id,
                "highLevelSelect": table.high_level_select,
                "meshes": [
                    {
                        "mesh": mesh.mesh,
                        "intervalBorders": list(mesh.interval_borders),
                        "coordIndex": mesh.coord_index.tolist(),
                        "displacements": mesh.displacements.reshape(-1, 3).tolist(),
                    }
                    for mesh in table.meshes
                ],
                "transforms": [
                    {"node": item.node, "field": item.field, "def": list(item.definition)} for item in table.transforms
                ],
            }
            for table in document.tables
        ],
        "transforms": {
            name: {
                "translation": list(node.translation),
                "rotation": list(node.rotation),
                "scale": list(node.scale),
                "meshes": list(node.meshes),
                **({"parent": node.parent} if node.parent else {}),
            }
            for name, node in document.transforms.items()
        },
    }
