"""FAT documents: the records and their validity.

Rules: FAT-1, FAT-8 (selects), FAT-9 (field names), FAT-11, CNF-22 (vertices), CNF-25 (faults have a path).
Not implemented here: the JSON form (`fat_json`), evaluation (`fat`, `fat_bulk`), the VRML/BT text form
(`fat_text`), generation (`fat_generate`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation, ResourceLimit
from snhc.reference_impl.model.fapu import Fapu, fap_unit_names

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MAX_FAT_VERTICES: Final = 2_000_000
TRANSFORM_FIELDS: Final = {"rotation": 4, "scale": 3, "translation": 3}
NEUTRAL_TRANSLATION: Final = (0.0, 0.0, 0.0)
NEUTRAL_ROTATION: Final = (0.0, 0.0, 1.0, 0.0)
NEUTRAL_SCALE: Final = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class FatMesh:
    """One IndexedFaceSet.

    Rules: FAT-1. `vertices`: float64 (V, 3), model units. `faces`: int64 (F, 3), indices from 0.
    """

    name: str
    vertices: FloatArray
    faces: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class FaceDefMesh:
    """What one FAP does to one mesh.

    Rules: FAT-1. `interval_borders`: strictly increasing. `coord_index`: int64 (N,). `displacements`: float64
    (N, borders - 1, 3), one vector per entry of `coord_index` and interval.
    """

    mesh: str
    interval_borders: tuple[int, ...]
    coord_index: IntArray
    displacements: FloatArray


@dataclass(frozen=True, slots=True)
class FaceDefTransform:
    """What one FAP does to one Transform node.

    Rules: FAT-9. `field`: "rotation" (`definition`: axis, factor), "scale" or "translation" (three numbers).
    """

    node: str
    field: str
    definition: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FaceDefTables:
    """The table of one FAP, or of one viseme or expression.

    Rules: FAT-8. `fap_id`: 1..68. `high_level_select`: 1..64, read for FAP 1 (viseme) and 2 (expression)
    only.
    """

    fap_id: int
    high_level_select: int = 1
    meshes: tuple[FaceDefMesh, ...] = ()
    transforms: tuple[FaceDefTransform, ...] = ()


@dataclass(frozen=True, slots=True)
class TransformNode:
    """One Transform node and the meshes directly below it.

    Rules: FAT-9. `rotation`: axis and angle in radians. `parent`: the Transform node above it, or empty; its
    transformation comes after this one's.
    """

    name: str
    translation: tuple[float, ...] = NEUTRAL_TRANSLATION
    rotation: tuple[float, ...] = NEUTRAL_ROTATION
    scale: tuple[float, ...] = NEUTRAL_SCALE
    meshes: tuple[str, ...] = ()
    parent: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class FatDocument:
    """A valid model: units, meshes, tables, transforms, in document order.

    Rules: FAT-1, FAT-11.
    """

    fapu: Fapu
    meshes: Mapping[str, FatMesh]
    tables: tuple[FaceDefTables, ...] = ()
    transforms: Mapping[str, TransformNode] = field(default_factory=dict)


def check_fat(document: FatDocument, *, max_vertices: int = MAX_FAT_VERTICES) -> None:
    """Raise the first fault of a document, in document order.

    Rules: FAT-1, FAT-11, FAT-9, CNF-22.

    Raises `ResourceLimit` (vertices), `RangeViolation` (an index outside the mesh, fapID, highLevelSelect, a
    rotation axis of length 0) and `InconsistentSemantics` (borders, counts, a mesh or node that is not there,
    a unit that is needed and not given). Every fault has a path, list lengths the expected one.
    """
    total = 0
    for name, mesh in document.meshes.items():
        total += len(mesh.vertices)
        path = f"meshes.{name}"
        if total > max_vertices:
            raise ResourceLimit("CNF-22", "vertices", value=total, allowed=f"at most {max_vertices}", path=path)
        _check_indices(mesh.faces.reshape(-1), len(mesh.vertices), f"{path}.faces", group=3)
    parents: dict[str, str] = {}
    for name, node in document.transforms.items():
        _check_axis(node.rotation, f"transforms.{name}.rotation")
        for i, child in enumerate(node.meshes):
            path = f"transforms.{name}.meshes[{i}]"
            _check_name(child, document.meshes, "meshes", path)
            if child in parents:
                raise InconsistentSemantics(
                    "FAT-9", "meshes", value=child, allowed="each mesh below one node, once", path=path
                )
            parents[child] = name
    _check_parents(document)
    for t, table in enumerate(document.tables):
        _check_table(document, table, f"tables[{t}]")


def _check_parents(document: FatDocument) -> None:
    rooted: set[str] = {""}
    for name in document.transforms:
        chain_up = [name]
        while chain_up[-1] not in rooted:
            above = document.transforms[chain_up[-1]].parent
            path = f"transforms.{chain_up[-1]}.parent"
            if above:
                _check_name(above, document.transforms, "parent", path)
            if above in chain_up:
                raise InconsistentSemantics("FAT-9", "parent", value=above, allowed="no cycle", path=path)
            chain_up.append(above)
        rooted.update(chain_up)


def _check_table(document: FatDocument, table: FaceDefTables, path: str) -> None:
    if not 1 <= table.fap_id <= 68:
        raise RangeViolation("FAT-8", "fapID", value=table.fap_id, allowed="1..68", path=f"{path}.fapID")
    if not 1 <= table.high_level_select <= 64:
        raise RangeViolation(
            "FAT-8",
            "highLevelSelect",
            value=table.high_level_select,
            allowed="1..64",
            path=f"{path}.highLevelSelect",
        )
    unit = fap_unit_names()[table.fap_id - 1]
    if document.fapu.unit(unit) is None and (table.meshes or table.transforms):
        raise InconsistentSemantics(
            "FAC-1",
            "fapu",
            value="absent",
            allowed=f"the unit {unit} that FAP {table.fap_id} needs",
            path=f"fapu.{unit}",
        )
    for m, mesh in enumerate(table.meshes):
        at = f"{path}.meshes[{m}]"
        _check_name(mesh.mesh, document.meshes, "mesh", f"{at}.mesh")
        check_borders(mesh.interval_borders, f"{at}.intervalBorders", empty=not len(mesh.coord_index))
        intervals = max(len(mesh.interval_borders) - 1, 0)
        if mesh.displacements.shape != (len(mesh.coord_index), intervals, 3):
            raise count_fault(mesh.displacements.size // 3, len(mesh.coord_index) * intervals, f"{at}.displacements")
        _check_indices(mesh.coord_index, len(document.meshes[mesh.mesh].vertices), f"{at}.coordIndex")
    for m, transform in enumerate(table.transforms):
        at = f"{path}.transforms[{m}]"
        _check_name(transform.node, document.transforms, "node", f"{at}.node")
        if transform.field not in TRANSFORM_FIELDS:
            raise InputFormat(
                "FAT-9",
                "field",
                value=transform.field,
                allowed=", ".join(TRANSFORM_FIELDS),
                path=f"{at}.field",
            )
        if transform.field == "rotation":
            _check_axis(transform.definition, f"{at}.def")


def check_borders(borders: Sequence[int], path: str, *, empty: bool = False) -> None:
    """Raise where interval borders do not increase strictly, or none is 0 although there are two intervals or
    more.

    Rules: FAT-1, FAT-11. `empty`: the node moves no vertex, so that it may have no borders. Raises
    `InconsistentSemantics` at the border.
    """
    if len(borders) < 2 and not (empty and not borders):
        raise InconsistentSemantics(
            "FAT-11",
            "intervalBorders",
            value=len(borders),
            allowed="two borders or more",
            path=path,
            expected=2,
        )
    for i in range(1, len(borders)):
        if borders[i] <= borders[i - 1]:
            raise InconsistentSemantics(
                "FAT-11",
                "intervalBorders",
                value=borders[i],
                allowed=f"more than {borders[i - 1]}",
                path=f"{path}[{i}]",
            )
    if len(borders) > 2 and 0 not in borders:
        raise InconsistentSemantics(
            "FAT-11",
            "intervalBorders",
            value="no 0",
            allowed="one border is 0 where there are several intervals",
            path=path,
        )


def count_fault(count: int, expected: int, path: str) -> InconsistentSemantics:
    """The error for a wrong number of displacements.

    Rules: FAT-11. `path`: of the list; the error points at the first entry that is missing or too much.
    """
    return InconsistentSemantics(
        "FAT-11", "displacements", value=count, allowed="one vector per coordIndex entry and interval",
        path=f"{path}[{min(count, expected)}]", expected=expected,
    )  # fmt: skip


def _check_name(name: str, names: Mapping[str, object], what: str, path: str) -> None:
    if name not in names:
        raise InconsistentSemantics("FAT-11", what, value=name, allowed="a name of this document", path=path)


def _check_axis(rotation: tuple[float, ...], path: str) -> None:
    if rotation[3] != 0 and not any(rotation[:3]):
        raise RangeViolation("FAT-9", "rotation", value="axis 0 0 0", allowed="an axis longer than 0", path=path)


def _check_indices(indices: IntArray, count: int, path: str, group: int = 0) -> None:
    bad = np.flatnonzero((indices < 0) | (indices >= count))
    if len(bad):
        i = int(bad[0])
        where = f"[{i // group}][{i % group}]" if group else f"[{i}]"
        raise RangeViolation(
            "FAT-11",
            path.rsplit(".", 1)[-1],
            value=int(indices[i]),
            allowed=f"0..{count - 1}",
            path=path + where,
        )
