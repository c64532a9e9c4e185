"""Mesh documents: frames in CNF-1 form as JSON or NDJSON, for the encoder. The form stands in docs/formats-mesh.md.

Rules: CNF-1, CNF-22, CNF-25. Not here: what the frames mean for the syntax (`encode`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from ..bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..documents.json_text import JsonObject, as_array, as_int, as_object, as_text, parse_json

FORMAT: Final = "snhc-mesh"
DECODED: Final = "snhc-decoded"
VERSION: Final = 1
CELLS: Final = ("nodes_hor", "nodes_vert", "rect_hor", "rect_vert", "split_code")
_KEYS: Final = ("index", "time", "intra", "nodes", "triangles", "order", "boundary_count", "uniform")
_WHAT: Final = "mesh document"


@dataclass(frozen=True, slots=True)
class DocumentFrame:
    """One frame of a mesh document.

    Rules: CNF-1.

    `path`: where it stands. `nodes`: positions in half pixels. `triangles`, `order`: as in CNF-1, None where absent.
    `boundary_count`: of a Delaunay mesh, 0 where absent. `uniform`: the values of CELLS, None where absent. `time`:
    seconds, None where absent.
    """

    path: str
    time: Fraction | None
    intra: bool
    nodes: tuple[tuple[int, int], ...]
    triangles: tuple[tuple[int, int, int], ...] | None
    order: tuple[int, ...] | None
    boundary_count: int
    uniform: tuple[int, int, int, int, int] | None

    @property
    def has_geometry(self) -> bool:
        """Whether the frame says what its mesh is, and not only where its nodes are. Rules: CNF-1."""
        return self.triangles is not None or self.boundary_count > 0 or self.uniform is not None


def read_mesh_document(data: bytes, *, limits: Limits = DEFAULT_LIMITS) -> list[DocumentFrame]:
    """The frames of a mesh document, JSON or NDJSON.

    Rules: CNF-1, CNF-22, CNF-25.

    Raises InputFormat (line and column, or path), RangeViolation, InconsistentSemantics (path), ResourceLimit.
    """
    head, _, rest = data.partition(b"\n")
    if b'"' + DECODED.encode() + b'"' in head:
        return list(_lines(head, rest, limits))
    document = as_object(parse_json(data, rule="CNF-25", what=_WHAT, limit=limits.json_bytes), "", "CNF-25")
    _header(document, FORMAT, None)
    return [
        _frame(as_object(entry, f"frames[{i}]", "CNF-1"), f"frames[{i}]", i == 0)
        for i, entry in enumerate(as_array(_get(document, "frames", ""), "frames", "CNF-1"))
    ]


def _lines(head: bytes, rest: bytes, limits: Limits) -> Iterable[DocumentFrame]:
    _header(
        as_object(parse_json(head, rule="CNF-1", what=_WHAT, limit=limits.json_bytes), "", "CNF-1"), DECODED, "mesh"
    )
    index = 0
    for number, line in enumerate(rest.split(b"\n"), 2):
        if line.strip():
            value = parse_json(line, rule="CNF-1", what=_WHAT, limit=limits.json_bytes, line=number)
            yield _frame(as_object(value, f"frames[{index}]", "CNF-1"), f"frames[{index}]", index == 0)
            index += 1


def _get(value: JsonObject, key: str, path: str) -> object:
    if key not in value:
        where = f"{path}.{key}" if path else key
        raise InputFormat("CNF-1", key, value="absent", allowed="a mesh document, which has this key", path=where)
    return value[key]


def _header(document: JsonObject, format: str, kind: str | None) -> None:
    wanted: list[tuple[str, object]] = [("format", format), ("version", VERSION)]
    if kind is not None:
        wanted.append(("kind", kind))
    for key, allowed in wanted:
        value = _get(document, key, "")
        if value != allowed or isinstance(value, bool):
            raise InputFormat("CNF-1", key, value=repr(value)[:40], allowed=repr(allowed), path=key)


def _frame(value: JsonObject, path: str, first: bool) -> DocumentFrame:
    for key in value:
        if key not in _KEYS:
            raise InputFormat("CNF-1", key[:40], value="unknown key", allowed=", ".join(_KEYS), path=path)
    nodes: list[tuple[int, int]] = []
    entries = as_array(_get(value, "nodes", path), f"{path}.nodes", "CNF-1")
    for k, entry in enumerate(entries):
        x, y = _numbers(entry, f"{path}.nodes[{k}]", 2, None)
        nodes.append((x, y))
    triangles = order = uniform = None
    if "triangles" in value:
        found: list[tuple[int, int, int]] = []
        for t, entry in enumerate(as_array(value["triangles"], f"{path}.triangles", "CNF-1")):
            a, b, c = _numbers(entry, f"{path}.triangles[{t}]", 3, len(nodes) - 1)
            found.append((a, b, c))
        triangles = tuple(found)
    if "order" in value:
        order = _numbers(value["order"], f"{path}.order", len(nodes), len(nodes) - 1)
    boundary_count = 0
    if "boundary_count" in value:
        boundary_count = as_int(value["boundary_count"], f"{path}.boundary_count", "MSH-38", 3, 1023)
    if "uniform" in value:
        cells = as_object(value["uniform"], f"{path}.uniform", "CNF-1")
        a, b, c, d, e = (
            as_int(_get(cells, key, f"{path}.uniform"), f"{path}.uniform.{key}", rule, lo, hi)
            for key, (rule, lo, hi) in zip(CELLS, _CELL_RANGES, strict=True)
        )
        uniform = (a, b, c, d, e)
    says = triangles is not None or boundary_count > 0 or uniform is not None
    intra = value.get("intra", first or says)
    if not isinstance(intra, bool):
        raise InputFormat("CNF-1", "intra", value=repr(intra)[:40], allowed="true, false", path=f"{path}.intra")
    if says and not intra:
        raise InconsistentSemantics(
            "MSH-2", "intra", value="false", allowed="true: only intra planes carry geometry", path=f"{path}.intra"
        )
    time = _time(value["time"], f"{path}.time") if "time" in value else None
    return DocumentFrame(path, time, intra, tuple(nodes), triangles, order, boundary_count, uniform)


_CELL_RANGES: Final = (
    ("MSH-31", 2, 1023),
    ("MSH-32", 2, 1023),
    ("MSH-34", 1, 255),
    ("MSH-35", 1, 255),
    ("MSH-36", 0, 3),
)


def _numbers(value: object, path: str, length: int, last: int | None) -> tuple[int, ...]:
    """`length` integers; numbers of nodes 0..last, positions within 32 bits where `last` is None."""
    array = as_array(value, path, "CNF-1")
    if len(array) != length:
        raise InputFormat("CNF-1", path.rsplit(".", 1)[-1], value=len(array), allowed=f"{length} numbers", path=path)
    lo, hi = (0, last) if last is not None else (-(1 << 31), (1 << 31) - 1)
    rule = "CNF-1" if last is not None else "MSH-24"
    return tuple(as_int(entry, f"{path}[{i}]", rule, lo, hi) for i, entry in enumerate(array))


def _time(value: object, path: str) -> Fraction:
    text = as_text(value, path, "CNF-1")
    numerator, _, denominator = text.partition("/")
    parts = (numerator, denominator or "1")
    if not all(part.isascii() and part.isdigit() and len(part) <= 18 for part in parts) or int(parts[1]) == 0:
        raise InputFormat("CNF-1", "time", value=text[:40], allowed='"p/q", seconds', path=path)
    time = Fraction(int(parts[0]), int(parts[1]))
    if time >= 1 << 40:
        raise RangeViolation("CNF-1", "time", value=text, allowed="below 2^40 seconds", path=path)
    return time
