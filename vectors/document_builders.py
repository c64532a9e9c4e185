"""Builders of FIT and FAT documents and of the frames that they are used on.

Rules: CNF-1, FIT-1, FIT-2, FIT-3, FIT-5, FAT-1, FAT-8, FAT-9.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from .manifest import FAT, FIT
from .recipe import Document

Terms = Sequence[tuple[float, tuple[int, ...]]]
"""Of a function: coefficient and exponents by parent value. Rules: FIT-3, FIT-4."""
Function = tuple[Terms, Terms]
"""Numerator and denominator (empty: 1). Rules: FIT-3, FIT-4."""
Link = tuple[int, int, Sequence[Function]]
"""Parent set, child set, one function per FAP of the child set. Rules: FIT-2, FIT-3."""
JsonTable = dict[str, object]

HEADER: Final = '{"format":"snhc-decoded","version":1,"kind":"fba"}\n'
_VISEME: Final = ("select1", "select2", "blend", "def")
_EXPRESSION: Final = ("select1", "intensity1", "select2", "intensity2", "init_face", "def")


def compact(value: object) -> bytes:
    """A JSON document on one line. Rules: CNF-4."""
    return (json.dumps(value, separators=(",", ":"), allow_nan=False) + "\n").encode()


def frame(
    faps: Mapping[int, int] | None = None,
    *,
    viseme: tuple[int, int, int] | None = None,
    expression: tuple[int, int, int, int] | None = None,
    states: Mapping[int, str] | None = None,
) -> JsonTable:
    """A frame without index and time; FAPs that are given are T, the others U, `states` are other letters.

    Rules: CNF-1. `viseme`: select1, select2, blend; `expression`: select1, intensity1, select2, intensity2.
    """
    given = faps or {}
    letters = ["T" if fap in given else "U" for fap in range(1, 69)]
    letters[0] = "U" if viseme is None else "T"
    letters[1] = "U" if expression is None else "T"
    for fap, letter in (states or {}).items():
        letters[fap - 1] = letter
    return {
        "intra": True,
        "faps": [given.get(fap) for fap in range(1, 69)],
        "viseme": None if viseme is None else dict(zip(_VISEME, (*viseme, 0), strict=True)),
        "expression": None if expression is None else dict(zip(_EXPRESSION, (*expression, 0, 0), strict=True)),
        "state": "".join(letters),
    }


def frames(found: Iterable[Mapping[str, object]]) -> bytes:
    """The lines of frames at 25 Hz, behind their header. Rules: CNF-1."""
    lines = [compact({"index": i, "time": f"{i}/25" if i else "0/1", **one}).decode() for i, one in enumerate(found)]
    return (HEADER + "".join(lines)).encode()


def linear(*coefs: float) -> Function:
    """c1 F1 + c2 F2 + ... Rules: FIT-4."""
    size = len(coefs)
    return [(c, tuple(int(j == i) for j in range(size))) for i, c in enumerate(coefs)], []


def fit_table(sets: Sequence[Sequence[int]], links: Sequence[Link], impulses: Sequence[int] = ()) -> JsonTable:
    """The nine fields of a FIT node. Rules: FIT-1, FIT-2, FIT-3, FIT-5. `impulses`: pairs, as the terms stand."""
    out: JsonTable = {
        "FAPs": [entry for faps in sets for entry in (*faps, -1)],
        "Graph": [number for parent, child, _ in links for number in (parent, child)],
    }
    for place, side in enumerate(("numerator", "denominator")):
        functions = [function[place] for _, _, functions in links for function in functions]
        out[f"{side}Terms"] = [len(terms) for terms in functions]
        out[f"{side}Exp"] = [power for terms in functions for _, powers in terms for power in powers]
        out[f"{side}Coefs"] = [coef for terms in functions for coef, _ in terms]
    out["numeratorImpulse"] = list(impulses)
    return out


def fit(table: JsonTable, *found: Mapping[str, object]) -> Document:
    """A FIT and the frames that it fills. Rules: CNF-2."""
    return Document(FIT, compact(table), frames(found))


def deformation(
    borders: Sequence[int], vectors: Sequence[Sequence[float]], index: Sequence[int] = (0,), mesh: str = "M"
) -> JsonTable:
    """A FaceDefMesh. Rules: FAT-1. `vectors`: for each entry of `index` one per interval."""
    return {
        "mesh": mesh, "intervalBorders": list(borders), "coordIndex": list(index),
        "displacements": [list(vector) for vector in vectors],
    }  # fmt: skip


def moves(
    fap: int, *meshes: JsonTable, select: int = 1, transforms: Sequence[tuple[str, str, Sequence[float]]] = ()
) -> JsonTable:
    """A FaceDefTables: meshes, and transforms as (node, field, definition). Rules: FAT-8, FAT-9."""
    out: JsonTable = {"fapID": fap, "highLevelSelect": select, "meshes": list(meshes)}
    if transforms:
        out["transforms"] = [{"node": node, "field": kind, "def": list(numbers)} for node, kind, numbers in transforms]
    return out


UNITS: Final = {"ES": 1.0, "ENS": 2.0, "MNS": 0.5, "MW": 1.0, "IRISD": 0.25}
"""Units that differ, so that a FAP in the wrong one shows; MW is 1, as in the worked example. Rules: FAT-6."""
POINTS: Final = ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), (-4.0, 0.5, 8.0))
"""The neutral vertices of mesh M."""


def fat_table(
    tables: Sequence[JsonTable],
    *,
    transforms: Mapping[str, Mapping[str, object]] | None = None,
    vertices: Sequence[Sequence[float]] = POINTS,
    units: Mapping[str, float] | None = None,
) -> JsonTable:
    """A model of one mesh M, a triangle where it has three vertices. Rules: FAT-1, FAT-9."""
    out: JsonTable = {
        "fapu": dict(UNITS if units is None else units),
        "meshes": {"M": {"vertices": [list(v) for v in vertices], "faces": [[0, 1, 2]] if len(vertices) == 3 else []}},
        "tables": list(tables),
    }
    if transforms:
        out["transforms"] = {name: dict(node) for name, node in transforms.items()}
    return out


def fat(table: JsonTable, *found: Mapping[str, object]) -> Document:
    """A model and the frames that move it. Rules: CNF-2."""
    return Document(FAT, compact(table), frames(found))
