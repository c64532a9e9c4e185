"""A trace as JSON: the same as the text dump, for programs, and enough to write the stream again.

Rules: CNF-17, CNF-21, CNF-23, CNF-25. The schema is `dump.schema.json`.

One part per line, written as it is traced; the document is valid JSON also where a fault ends it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.systems.stream import Options
from snhc.reference_impl.systems.visual import TRAILING, AnyPlane

from .elements import meaning
from .parts import BOUNDARIES, Part, Parts, raw_bits
from .query import Query

VERSION: Final = 1
SCHEMA: Final = Path(__file__).with_name("dump.schema.json")
_CHUNK: Final = 1 << 15
# The longest field of fixed width has 32 bits; only runs of zeros are longer than a segment may be.
_LONGEST_RAW: Final = 16384


def dump_json(
    parts: Parts, source: Source, options: Options, symbols: bool = False, query: Query | None = None
) -> Iterator[str]:
    """The dump as pieces of one JSON document; `symbols`: also every arithmetic symbol.

    Rules: CNF-17, CNF-25. `query`: only the elements that it takes. `parts.error` holds the fault that ended it.
    """
    wanted = parts.selection
    head = {
        "format": "snhc-dump",
        "version": VERSION,
        "compat": "draft" if options.draft else None,
        "strict": options.strict,
        "readings": options.readings.chosen,
        "entropy_profile": options.profile.name if options.profile is not None else None,
        "planes": [wanted.first, wanted.last] if wanted is not None else None,
        "object": wanted.object_number if wanted is not None else None,
        "query": query.text if query is not None else None,
    }
    yield json.dumps(head, ensure_ascii=False)[:-1] + ', "parts": ['
    separator = "\n"
    for part in parts:
        rows: Iterable[int] = range(len(part.trace))
        if query is not None:
            rows = [row for row in rows if query.takes_row(part, row, source)]
            if not rows and not query.takes_plane(part, source):
                continue
        yield separator
        yield from _part(part, rows, source, symbols)
        separator = ",\n"
    error = parts.error.as_json() if parts.error is not None else None
    gap = parts.unclaimed(source)
    yield f'\n], "error": {json.dumps(error, ensure_ascii=False)}, "unclaimed": '
    if gap is None or query is not None:
        yield "null}\n"
        return
    start, end = gap
    aligned = -(-start // 8) * 8
    yield f'{{"bits": [{start}, {end}], "raw": "{raw_bits(source, start, aligned)}", "bytes": "'
    yield from _hex(source, aligned >> 3, end >> 3)
    yield '"}}\n'


def _part(part: Part, rows: Iterable[int], source: Source, symbols: bool) -> Iterator[str]:
    fields: dict[str, object] = {"item": part.item_number, "kind": part.kind or None}
    if part.plane is not None:
        fields["plane"] = _plane(part.plane, part.plane_number)
    fields["findings"] = [finding.as_json() for finding in part.findings]
    yield json.dumps(fields, ensure_ascii=False)[:-1] + ', "elements": ['
    separator = ""
    for row in rows:
        yield separator
        yield from _element(part, row, source, symbols)
        separator = ", "
    yield "]}"


def _plane(plane: AnyPlane, number: int) -> dict[str, object]:
    out: dict[str, object] = {
        "index": number,
        "bits": [plane.start, plane.end],
        "intra": bool(plane.is_intra),
    }
    if isinstance(plane, MeshPlane):
        out["mesh_mask"] = plane.mesh_mask
    else:
        out["fba_object_mask"] = plane.fba_object_mask
        out["boundary"] = BOUNDARIES[plane.boundary]
    if plane.frames:
        out["time"] = f"{plane.frames[0].time[0]}/{plane.frames[0].time[1]}"
    return out


def _element(part: Part, row: int, source: Source, symbols: bool) -> Iterator[str]:
    trace = part.trace
    element = trace.el(row)
    start, end, value = trace.start[row], trace.end[row], trace.value[row]
    fields: dict[str, object] = {
        "element": element.name,
        "rule": element.rule,
        "path": trace.path_text(row),
        "bits": [start, end],
    }
    if row in trace.blobs or element is TRAILING:
        # Read from the source again, piece by piece: bytes behind the end may be many.
        yield json.dumps(fields)[:-1] + ', "bytes": "'
        yield from _hex(source, start >> 3, end >> 3)
        yield '"}'
        return
    if end - start <= _LONGEST_RAW:
        fields["raw"] = raw_bits(source, start, end)
    segment = trace.segments.get(row)
    if segment is None:
        fields["value"] = value
        words = meaning(element, value)
        if words:
            fields["meaning"] = words
    else:
        steps, labels = segment
        fields["labels"] = labels
        fields["levels"] = list(steps.levels)
        fields["guards"] = [position for position, _ in steps.guards]
        if steps.tail:
            fields["tail"] = steps.tail
        if symbols:
            fields["symbols"] = _symbols(steps)
    yield json.dumps(fields, ensure_ascii=False)


def _hex(source: Source, first: int, last: int) -> Iterator[str]:
    for at in range(first, last, _CHUNK):
        yield source.read_at(at, min(_CHUNK, last - at)).hex()


def _symbols(segment: SegmentTrace) -> list[dict[str, object]]:
    return [
        {
            "level": step.level,
            "model": "P" if step.adaptive else "I",
            "symbols": step.symbols,
            "low": step.low,
            "high": step.high,
            "code_value": step.code_value,
            "c": step.c,
            "cum": [step.cum_low, step.cum_high],
            "total": step.total,
            "bits_read": step.bits_before,
            "shifts": step.shifts,
            "rescaled": step.rescaled,
        }
        for step in segment.steps
    ]
