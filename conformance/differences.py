"""What differs between two decoded streams: the comparators.

Rules: CNF-1, CNF-2, CNF-16, CNF-17, FBA-54, MSH-21.

Faces: exact, or near where the caller says so (DCT-8). Meshes: nodes and order exact, triangles as sets of node triples
that may begin at any node but keep their direction, or in order. Floats (vertices, units of a face): within a bound.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

from snhc.reference_impl.face.fap_text import FapTextFrame

from .candidate import Frame

Near = Callable[[int, int, "int | None", "int | None"], bool]
"""Whether two values are close enough: line, FAP, reference, candidate. Rules: CNF-16."""

_EXTRA: Final = ("gender", "coding_type", "fap_quant", "baps")


def exactly(line: int, fap: int, reference: int | None, candidate: int | None) -> bool:
    """Equal. Rules: CNF-16."""
    return reference == candidate


@dataclass(frozen=True, slots=True)
class Difference:
    """The first thing that differs.

    Rules: CNF-16, CNF-17. `frame`: line index, from 0. `what`: `faps`, `state`, `time`, `viseme.blend`, ...,
    `missing frame`, `extra frame`; `nodes[3]`, `triangles`, `order`; `meshes.lips[7]`. `fap`: its number where
    one FAP is at fault.
    """

    frame: int
    what: str
    fap: int | None
    reference: Any
    candidate: Any

    def as_json(self) -> dict[str, Any]:
        """The report's `difference`."""
        return {
            "frame": self.frame, "what": self.what, "fap": self.fap, "reference": self.reference,
            "candidate": self.candidate,
        }  # fmt: skip

    def __str__(self) -> str:
        place = f"frame {self.frame}, {self.what if self.fap is None else f'FAP {self.fap} ({self.what})'}"
        return f"{place}: reference {self.reference}, candidate {self.candidate}"


def difference_of(
    reference: Sequence[Frame], candidate: Sequence[Frame], near: Near = exactly, *, prefix: bool = False
) -> Difference | None:
    """The first difference of two decoded face streams, None if they agree.

    Rules: CNF-1, CNF-16. Keys that the candidate has not, and that CNF-1 does not demand, are not compared. `near`:
    whether FAPs 3..68 are close enough. `prefix`: the candidate may go on after the last frame of the reference.
    """
    return _first(reference, candidate, lambda i, ours, theirs: _face_frame(i, ours, theirs, near), prefix)


_Compare = Callable[[int, Frame, Frame], Difference | None]


def _first(
    reference: Sequence[Frame], candidate: Sequence[Frame], compare: _Compare, prefix: bool
) -> Difference | None:
    for i, (ours, theirs) in enumerate(zip(reference, candidate, strict=False)):
        found = compare(i, ours, theirs)
        if found is not None:
            return found
    return _length(len(reference), len(candidate), prefix)


def _length(reference: int, candidate: int, prefix: bool) -> Difference | None:
    if candidate < reference:
        return Difference(candidate, "missing frame", None, f"{reference} frames", f"{candidate} frames")
    if candidate > reference and not prefix:
        return Difference(reference, "extra frame", None, f"{reference} frames", f"{candidate} frames")
    return None


def _when(i: int, ours: Frame, theirs: Frame, keys: Sequence[str]) -> Difference | None:
    if Fraction(ours["time"]) != Fraction(theirs["time"]):
        return Difference(i, "time", None, ours["time"], theirs["time"])
    for key in keys:
        if ours[key] != theirs[key]:
            return Difference(i, key, None, ours[key], theirs[key])
    return None


def _face_frame(i: int, ours: Frame, theirs: Frame, near: Near) -> Difference | None:
    for number, (a, b) in enumerate(zip(ours["faps"], theirs["faps"], strict=True), 1):
        if a != b and not near(i, number, a, b):
            return Difference(i, "faps", number, a, b)
    for name, fap in (("viseme", 1), ("expression", 2)):
        a, b = ours[name], theirs[name]
        if a is None or b is None:
            if a is not b:
                return Difference(i, name, fap, a, b)
            continue
        for key in a:
            if a[key] != b[key]:
                return Difference(i, f"{name}.{key}", fap, a[key], b[key])
    for number, (a, b) in enumerate(zip(ours["state"], theirs["state"], strict=True), 1):
        if a != b:
            return Difference(i, "state", number, a, b)
    found = _when(i, ours, theirs, ("intra", "index"))
    if found is not None:
        return found
    for key in _EXTRA:
        if key in ours and key in theirs and not _same(ours[key], theirs[key]):
            return Difference(i, key, None, ours[key], theirs[key])
    return None


def _same(ours: Any, theirs: Any) -> bool:
    # In Python 1, 1.0 and True are equal; in JSON they are three values.
    return bool(ours == theirs) and json.dumps(ours, sort_keys=True) == json.dumps(theirs, sort_keys=True)


def fap_difference(
    reference: Sequence[FapTextFrame], candidate: Sequence[FapTextFrame], near: Near = exactly, *, prefix: bool = False
) -> Difference | None:
    """The first difference of two `.fap` texts. Rules: FBA-54, CNF-16. Frame numbers count from the first frame.

    `near`, `prefix`: as in `difference_of`.
    """
    for i, (ours, theirs) in enumerate(zip(reference, candidate, strict=False)):
        for number, (a, b) in enumerate(zip(ours.mask, theirs.mask, strict=True), 1):
            if a != b:
                return Difference(i, "mask", number, a, b)
        for number, (x, y) in enumerate(zip(ours.values, theirs.values, strict=True), 1):
            if x != y and not near(i, number, x, y):
                return Difference(i, "faps", number, x, y)
        if ours.viseme != theirs.viseme:
            return Difference(i, "viseme", 1, ours.viseme, theirs.viseme)
        if ours.expression != theirs.expression:
            return Difference(i, "expression", 2, ours.expression, theirs.expression)
        a, b = ours.number - reference[0].number, theirs.number - candidate[0].number
        if a != b:
            return Difference(i, "frame number", None, a, b)
    return _length(len(reference), len(candidate), prefix)


# -- meshes ------------------------------------------------------------------------------------------------------------


def mesh_difference(
    reference: Sequence[Frame], candidate: Sequence[Frame], *, ordered: bool = False, prefix: bool = False
) -> Difference | None:
    """The first difference of two decoded meshes.

    Rules: CNF-1, CNF-16, MSH-21. `ordered`: triangles in the same order, each with its lowest node first; else the
    same triangles. `prefix`: as in `difference_of`.
    """
    return _first(reference, candidate, lambda i, ours, theirs: _mesh_frame(i, ours, theirs, ordered), prefix)


def _mesh_frame(i: int, ours: Frame, theirs: Frame, ordered: bool) -> Difference | None:
    a, b = ours["nodes"], theirs["nodes"]
    if len(a) != len(b):
        return Difference(i, "nodes", None, f"{len(a)} nodes", f"{len(b)} nodes")
    for n, (x, y) in enumerate(zip(a, b, strict=True)):
        if x != y:
            return Difference(i, f"nodes[{n}]", None, x, y)
    for key in ("triangles", "order"):
        if (key in ours) != (key in theirs):
            return Difference(i, key, None, *(f"{key} given" if key in f else "none" for f in (ours, theirs)))
    if "triangles" in ours:
        found = _triangles(i, ours["triangles"], theirs["triangles"], ordered)
        if found is not None:
            return found
        if ours["order"] != theirs["order"]:
            return Difference(i, "order", None, ours["order"], theirs["order"])
    return _when(i, ours, theirs, ("intra", "index"))


def _triangles(i: int, ours: list[list[int]], theirs: list[list[int]], ordered: bool) -> Difference | None:
    if ordered:
        for t, (a, b) in enumerate(zip(ours, theirs, strict=False)):
            if a != b:
                return Difference(i, f"triangles[{t}]", None, a, b)
    else:
        wanted, given = Counter(map(_turned, ours)), Counter(map(_turned, theirs))
        missing, surplus = sorted((wanted - given).elements()), sorted((given - wanted).elements())
        if missing and surplus:
            return Difference(i, "triangles", None, list(missing[0]), list(surplus[0]))
    if len(ours) != len(theirs):
        return Difference(i, "triangles", None, f"{len(ours)} triangles", f"{len(theirs)} triangles")
    return None


def _turned(triangle: Sequence[int]) -> tuple[int, ...]:
    at = triangle.index(min(triangle))
    return (*triangle[at:], *triangle[:at])


# -- floats ------------------------------------------------------------------------------------------------------------


def float_difference(
    reference: Sequence[Frame], candidate: Sequence[Frame], bound: float, *, prefix: bool = False
) -> Difference | None:
    """The first difference of two lists of vertices, or of the units of a face.

    Rules: CNF-2, CNF-16. `bound`: how far each number may be off. `prefix`: as in `difference_of`.
    """

    def compare(i: int, ours: Frame, theirs: Frame) -> Difference | None:
        for key in ("meshes", "units", "faps"):
            if key in ours:
                found = _numbers(i, key, ours[key], theirs[key], bound)
                if found is not None:
                    return found
        if "time" in ours:
            return _when(i, ours, theirs, ("index",))
        return (
            None if ours["index"] == theirs["index"] else Difference(i, "index", None, ours["index"], theirs["index"])
        )

    return _first(reference, candidate, compare, prefix)


def _numbers(i: int, path: str, ours: Any, theirs: Any, bound: float) -> Difference | None:
    fap = int(path[5:-1]) + 1 if path.startswith("faps[") else None
    if isinstance(ours, dict):
        if set(ours) - set(theirs):
            return Difference(i, path, None, sorted(ours), sorted(theirs))
        pairs = [(f"{path}.{key}", ours[key], theirs[key]) for key in ours]
    elif isinstance(ours, list):
        if len(ours) != len(theirs):
            return Difference(i, path, None, f"{len(ours)} entries", f"{len(theirs)} entries")
        pairs = [(f"{path}[{n}]", a, b) for n, (a, b) in enumerate(zip(ours, theirs, strict=True))]
    elif ours is None or theirs is None:
        return None if ours is theirs else Difference(i, path, fap, ours, theirs)
    else:
        return None if abs(ours - theirs) <= bound else Difference(i, path, fap, ours, theirs)
    for name, a, b in pairs:
        found = _numbers(i, name, a, b, bound)
        if found is not None:
            return found
    return None
