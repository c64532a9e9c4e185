"""Face animation tables with one fault each.

Rules: FAT-1, FAT-8, FAT-9, FAT-11, FAC-1, CNF-1, CNF-6, CNF-22, CNF-25.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from snhc.reference_impl.bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)

from ..document_builders import JsonTable, compact, deformation, fat, fat_table, frame, frames, moves
from ..manifest import FAT, DecodeOptions
from ..recipe import Document, Reject, family, vector

TOOLS: Final = ("fat",)
_X: Final = (1.0, 0.0, 0.0)
_BORDERS: Final = "tables[0].meshes[0].intervalBorders"
_COUNT: Final = "tables[0].meshes[0].displacements"


def _reject(table: JsonTable, error: type[SnhcError], rule: str, path: str) -> Reject:
    return Reject(fat(table, frame({6: 100})), error, rule, path=path, lines=None)


@family(
    {
        "descending": ([-100, 0, 50, 40], [_X] * 3, f"{_BORDERS}[3]"),
        "equal": ([-100, 0, 0, 40], [_X] * 3, f"{_BORDERS}[2]"),
        "no zero": ([-100, 10, 50], [_X] * 2, _BORDERS),
        "one": ([0], [], _BORDERS),
        "none": ([], [], _BORDERS),
        "vectors missing": ([-100, 0, 50], [_X], f"{_COUNT}[1]"),
        "vectors too many": ([-100, 0, 50], [_X] * 3, f"{_COUNT}[2]"),
    },
    id="fat.error.borders.{case}", title="Borders and vectors: {case}", tier="error", tools=TOOLS,
    rules=["FAT-1", "FAT-11"],
)  # fmt: skip
def borders(case: tuple[list[int], Sequence[Sequence[float]], str]) -> Reject:
    """Interval borders or displacements that do not fit ({case})."""
    found, vectors, path = case
    return _reject(fat_table([moves(6, deformation(found, vectors))]), InconsistentSemantics, "FAT-11", path)


@family(
    {"3 of 3": 3, "minus 1": -1}, id="fat.error.index.{case}", title="coordIndex {case}", tier="error", tools=TOOLS,
    rules=["FAT-11"], value_classes=["above-max", "below-min"],
)  # fmt: skip
def index(number: int) -> Reject:
    """The second entry of coordIndex is {case}: the mesh has vertices 0 to 2."""
    table = fat_table([moves(6, deformation([0, 1], [_X, _X], index=[0, number]))])
    return _reject(table, RangeViolation, "FAT-11", "tables[0].meshes[0].coordIndex[1]")


@family(
    {
        "fapID 0": ("fapID", 0, RangeViolation, "FAT-8"), "fapID 69": ("fapID", 69, RangeViolation, "FAT-8"),
        "select 0": ("highLevelSelect", 0, RangeViolation, "FAT-8"),
        "select 65": ("highLevelSelect", 65, RangeViolation, "FAT-8"),
        "text": ("fapID", "6", InputFormat, "FAT-8"),
    },
    id="fat.error.table.{case}", title="Table: {case}", tier="error", tools=TOOLS, rules=["FAT-8"],
)  # fmt: skip
def table_field(case: tuple[str, object, type[SnhcError], str]) -> Reject:
    """A field of the table is out of its domain: {case}."""
    name, value, error, rule = case
    return _reject(fat_table([{**moves(6, deformation([0, 1], [_X])), name: value}]), error, rule, f"tables[0].{name}")


@vector(id="fat.error.no-such-mesh", title="A mesh that is not there", tier="error", tools=TOOLS, rules=["FAT-11"])
def no_mesh() -> Reject:
    """The table names mesh Q, the model has M."""
    table = fat_table([moves(6, deformation([0, 1], [_X], mesh="Q"))])
    return _reject(table, InconsistentSemantics, "FAT-11", "tables[0].meshes[0].mesh")


@vector(id="fat.error.no-such-node", title="A node that is not there", tier="error", tools=TOOLS, rules=["FAT-9"])
def no_node() -> Reject:
    """A transform of a node that the model has not."""
    table = fat_table([moves(6, transforms=[("neck", "scale", (1, 1, 1))])])
    return _reject(table, InconsistentSemantics, "FAT-11", "tables[0].transforms[0].node")


@vector(id="fat.error.no-such-field", title="A field that is not there", tier="error", tools=TOOLS, rules=["FAT-9"])
def no_field() -> Reject:
    """A transform can rotate, scale and translate, but not shear."""
    table = fat_table([moves(6, transforms=[("node", "shear", (1, 1, 1))])], transforms={"node": {"meshes": ["M"]}})
    return _reject(table, InputFormat, "FAT-9", "tables[0].transforms[0].field")


@vector(id="fat.error.no-axis", title="A rotation without an axis", tier="error", tools=TOOLS, rules=["FAT-9"])
def no_axis() -> Reject:
    """The axis (0 0 0) has no direction."""
    transforms = [("node", "rotation", (0.0, 0.0, 0.0, 1.0))]
    table = fat_table([moves(23, transforms=transforms)], transforms={"node": {"meshes": ["M"]}})
    return _reject(table, RangeViolation, "FAT-9", "tables[0].transforms[0].def")


@vector(id="fat.error.no-unit", title="A unit that is needed and not given", tier="error", tools=TOOLS, rules=["FAC-1"])
def no_unit() -> Reject:
    """FAP 19 needs IRISD, the model has MNS only; one that takes MNS goes on."""
    table = fat_table([moves(19, deformation([0, 1], [_X]))], units={"MNS": 0.5})
    return _reject(table, InconsistentSemantics, "FAC-1", "fapu.IRISD")


@vector(id="fat.error.au", title="AU = 1e-4", tier="error", tools=TOOLS, rules=["FAC-1"])
def au() -> Reject:
    """A document that says AU is 1e-4 rad: it is 1e-5, always."""
    table = fat_table([moves(6, deformation([0, 1], [_X]))], units={"MW": 1.0, "AU": 0.0001})
    return _reject(table, InconsistentSemantics, "FAC-1", "fapu.AU")


@vector(id="fat.error.face", title="A triangle past the vertices", tier="error", tools=TOOLS, rules=["FAT-11"])
def face() -> Reject:
    """Vertex 3 of a mesh with vertices 0 to 2."""
    table = fat_table([])
    mesh = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2], [0, 1, 3]]}
    return _reject({**table, "meshes": {"M": mesh}}, RangeViolation, "FAT-11", "meshes.M.faces[1][2]")


@vector(id="fat.error.limit.vertices", title="More vertices than the limit", tier="error", tools=TOOLS,
        rules=["CNF-22"], options=DecodeOptions(limits={"fat_vertices": 2}))  # fmt: skip
def too_many() -> Reject:
    """Three vertices where two are allowed."""
    return _reject(fat_table([]), ResourceLimit, "CNF-22", "meshes.M")


@vector(id="fat.error.not-json", title="A model that is not JSON", tier="error", tools=TOOLS, rules=["FAT-1"])
def not_json() -> Reject:
    """NaN is a word that JSON has not."""
    data = b'{"fapu":{"MW":NaN}}'
    return Reject(Document(FAT, data, frames([frame({6: 1})])), InputFormat, "FAT-1", line=1)


@vector(id="fat.error.frames.state", title="Frames: 67 letters", tier="error", tools=TOOLS, rules=["CNF-1", "CNF-25"])
def short_state() -> Reject:
    """The second frame has a letter too few; the vertices of the first one are there."""
    good = frames([frame({6: 1})])
    bad = compact({"index": 1, "time": "1/25", **frame({6: 1}), "state": "U" * 67})
    document = Document(FAT, compact(fat_table([moves(6, deformation([0, 1], [_X]))])), good + bad)
    return Reject(document, InconsistentSemantics, "CNF-1", path="state", line=3, lines=1)
