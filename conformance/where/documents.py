"""Places in documents: the JSON path that stands behind a difference.

Rules: CNF-17, CNF-25, DCT-13, FIT-1, FAT-5.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final

from snhc.conformance.differences import Difference
from snhc.vectors.manifest import DCT_COEFFICIENTS, FACE, FAT, FIT, Entry

FRAMES_PER_SEGMENT: Final = 16
_SHOWN: Final = 8
_EXCERPT: Final = 200


def document_evidence(entry: Entry, suite: Path, difference: Difference | None, path: str) -> dict[str, Any]:
    """`document`: the paths, each with what stands there. Rules: CNF-17, CNF-25. `path`: of a fault, "" for none."""
    try:
        document = json.loads((suite / entry.file).read_bytes())
    except (ValueError, RecursionError):
        # Some vectors are no JSON: their fault has a line.
        return {}
    paths = [path] if path else []
    if difference is not None:
        paths = _PATHS[entry.media](document, difference)
    found = [{"path": path, "value": _value(document, path)} for path in paths[:_SHOWN]]
    out: dict[str, Any] = {"paths": found}
    if difference is not None and entry.aux:
        # The first line of the frames is their header.
        out["frames_line"] = difference.frame + 2
    return {"document": out}


def _value(document: Any, path: str) -> str | None:
    for step in re.findall(r"[^.\[\]]+", path):
        if isinstance(document, list) and step.isdigit() and int(step) < len(document):
            document = document[int(step)]
        elif isinstance(document, dict):
            # Points are named 2.2.
            key = next((key for key in document if path.endswith(key) and "." in key), step)
            if key not in document:
                return None
            document = document[key]
            if key != step:
                break
        else:
            return None
    text = json.dumps(document, ensure_ascii=False)
    return text if len(text) <= _EXCERPT else text[:_EXCERPT] + " ..."


def _coefficients(document: Any, difference: Difference) -> list[str]:
    number = difference.frame // FRAMES_PER_SEGMENT
    path = f"segments[{number}]"
    if difference.fap is not None:
        key = str(difference.fap)
        # What a segment does not send is kept from the one before.
        for back in range(min(number, len(document["segments"]) - 1), -1, -1):
            if key in document["segments"][back]["coefficients"]:
                return [f"segments[{back}].coefficients.{key}"]
    return [path]


def _table(document: Any, difference: Difference) -> list[str]:
    if difference.fap is None:
        return ["Graph"]
    return [f"FAPs[{i}]" for i, fap in enumerate(document.get("FAPs", [])) if fap == difference.fap]


def _vertices(document: Any, difference: Difference) -> list[str]:
    match = re.match(r"meshes\.(.+?)\[([0-9]+)\]", difference.what)
    if match is None:
        return ["meshes"]
    name, vertex = match[1], int(match[2])
    return [f"meshes.{name}.vertices[{vertex}]"] + [
        f"tables[{t}].meshes[{m}].coordIndex[{mesh['coordIndex'].index(vertex)}]"
        for t, table in enumerate(document.get("tables", []))
        for m, mesh in enumerate(table.get("meshes", []))
        if mesh.get("mesh") == name and vertex in mesh.get("coordIndex", [])
    ]


def _face(document: Any, difference: Difference) -> list[str]:
    return ["points"]


_PATHS: Final = {DCT_COEFFICIENTS: _coefficients, FIT: _table, FAT: _vertices, FACE: _face}
