"""`snhc dump --format html`: one file that shows a stream, with nothing beside it and no network.

Rules: CNF-17, CNF-21, CNF-22, CNF-23, CNF-25. The page is `viewer.html`, `viewer.css` and the scripts beside this
module, with the sheet of all pages; the data comes as JSON with packed columns, and reaches the screen as text only.
"""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from snhc.analyzer.face_scene import load_model
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.rules import ambiguities, rules
from snhc.reference_impl.systems.stream import Options
from snhc.reference_impl.tables import fap_groups, fap_table

from ..pages import base_css
from ..parts import Parts
from .columns import MOST_BYTES, PartColumns, Rows, too_large
from .frames import FaceFrames, MeshFrames
from .head import head_data

VERSION: Final = 1
_FOLDER: Final = Path(__file__).parent
SCRIPTS: Final = (
    "base.js", "data.js", "listing.js", "tree.js", "hexview.js", "planes.js", "details.js", "curves.js", "meshview.js",
    "pose.js", "headview.js", "search.js", "app.js",
)  # fmt: skip
# Rules of what the page itself shows, beside those of the elements.
_ALWAYS: Final = ("FBA-23", "FBA-25", "FBA-26")
_SLICE: Final = 3 << 16


def dump_html(parts: Parts, source: Source, options: Options, name: str, symbols: bool = False) -> Iterator[str]:
    """The page as pieces of text.

    Rules: CNF-17, CNF-22. `parts`: traced with symbols. `name`: of the file. `symbols`: the page also has the coder's
    registers before each symbol. A fault ends the data, and stands in the page and in `parts.error`. Raises
    ResourceLimit, before anything is yielded, for a stream that is too large for one page.
    """
    data, span = _data(parts, source, options, name, symbols)
    page = (_FOLDER / "viewer.html").read_text(encoding="utf-8")
    head, rest = page.split("/*STYLE*/")
    body, rest = rest.split("/*DATA*/")
    middle, tail = rest.split("/*SCRIPT*/")
    yield head + base_css() + (_FOLDER / "viewer.css").read_text(encoding="utf-8") + body
    # `<` would end the script element, whatever stands around it.
    yield json.dumps(data, ensure_ascii=False, separators=(",", ":"))[:-1].replace("<", "\\u003c")
    yield ',"bytes":"'
    for at in range(span[0], span[1], _SLICE):
        yield b64encode(source.read_at(at, min(_SLICE, span[1] - at))).decode()
    yield '"}' + middle
    for script in SCRIPTS:
        yield f"// {script}\n" + (_FOLDER / script).read_text(encoding="utf-8")
    yield tail


def _data(
    parts: Parts, source: Source, options: Options, name: str, symbols: bool
) -> tuple[dict[str, object], tuple[int, int]]:
    rows, columns = Rows(source, symbols), PartColumns()
    face, mesh = FaceFrames(), MeshFrames()
    last = 0
    for part in parts:
        frames = part.plane.frames if part.plane is not None else []
        is_mesh = part.kind == "mesh_object"
        columns.add(part, len(rows), len(mesh) if is_mesh else len(face.frames))
        rows.add(part)
        for frame in frames:
            if isinstance(frame, MeshFrame):
                mesh.add(frame)
            else:
                assert isinstance(frame, FaceFrame)
                face.add(frame)
        if len(part.trace):
            last = part.trace.end[-1]
    gap = parts.unclaimed(source)
    starts = [start for start in columns.start if start >= 0]
    # Of a fault's rest a piece is enough to see what stands there.
    end = last if gap is None else min(gap[1], max(last, gap[0]) + 8 * _SLICE)
    span = int(starts[0]) >> 3 if starts else 0, (end + 7) >> 3
    if span[1] - span[0] > MOST_BYTES:
        raise too_large("bytes", MOST_BYTES)
    error = parts.error
    known = rows.rules() | {str(finding[4]) for finding in columns.findings} | set(_ALWAYS)
    if error is not None:
        known.add(error.rule)
    data: dict[str, object] = {
        "format": "snhc-viewer",
        "version": VERSION,
        "name": name,
        "size": source.size(),
        "firstByte": span[0],
        "selected": parts.selection is not None,
        "readings": options.readings.chosen,
        "error": error.as_json() if error is not None else None,
        "unclaimed": list(gap) if gap is not None else None,
        **rows.as_json(),
        **columns.as_json(),
        **_register(known),
        "face": None,
        "mesh": mesh.as_json() if len(mesh) else None,
    }
    if face.frames:
        model = load_model(readings=options.readings)
        data["face"] = face.as_json(model)
        data["head"] = head_data(options.readings)
        data["faps"] = {
            str(fap.number): {
                "name": fap.name, "unit": fap.unit, "group": fap.group, "motion": fap.positive_motion, "step": fap.QP,
            }
            for fap in fap_table()
        }  # fmt: skip
        data["groups"] = {str(group.group): [group.first_fap, group.last_fap] for group in fap_groups()}
    return data, span


def _register(known: set[str]) -> dict[str, object]:
    register = rules()
    used = {id: register[id] for id in sorted(known) if id in register}
    asked = sorted({id for rule in used.values() for id in rule.ambiguities})
    return {
        "rules": {
            id: {
                "title": rule.title, "statement": " ".join(rule.statement.split()), "clause": rule.clause,
                "confidence": rule.confidence, "note": " ".join(rule.note.split()),
                "ambiguities": list(rule.ambiguities),
            }
            for id, rule in used.items()
        },
        "ambiguities": {
            id: {
                "question": " ".join(ambiguities()[id].question.split()), "followed": ambiguities()[id].followed,
                "readings": {key: " ".join(text.split()) for key, text in ambiguities()[id].readings.items()},
            }
            for id in asked if id in ambiguities()
        },
    }  # fmt: skip
