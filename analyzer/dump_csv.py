"""A trace as CSV: a line per element, for tables and shells.

Rules: CNF-17, CNF-21, CNF-25. The columns are described in docs/dump.md.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from io import StringIO
from typing import Final

from snhc.reference_impl.bitstream.source import Source

from .elements import kind_of_row, meaning, settled_bits
from .parts import Part, Parts, raw_bits
from .query import SYMBOL, Query, Subject

COLUMNS: Final = (
    "item", "object", "plane", "path", "element", "kind", "start", "end", "bits", "raw", "value", "meaning", "levels",
    "rule",
)  # fmt: skip
# Longer elements leave `raw` empty: no table wants a file in a cell.
MOST_RAW: Final = 16384


def dump_csv(parts: Parts, source: Source, symbols: bool = False, query: Query | None = None) -> Iterator[str]:
    """The dump as lines of CSV (RFC 4180, but each ends in a bare newline).

    Rules: CNF-17, CNF-25. `symbols`: a line for every arithmetic symbol too, with the bits that it settles. `query`:
    only what it takes. What a fault leaves unread is the last line, `unclaimed`. `parts.error` holds the fault.
    """
    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(COLUMNS)
    for part in parts:
        for fields in _rows(part, source, symbols, query):
            writer.writerow(fields)
        yield buffer.getvalue()
        buffer.seek(0)
        buffer.truncate()
    gap = parts.unclaimed(source) if query is None else None
    if gap is not None:
        writer.writerow(("", "", "", "", "unclaimed", "unclaimed", *gap, gap[1] - gap[0], "", "", "", "", ""))
    yield buffer.getvalue()


def _rows(part: Part, source: Source, symbols: bool, query: Query | None) -> Iterator[tuple[object, ...]]:
    trace = part.trace
    plane = part.plane_number if part.plane_number >= 0 else ""
    for row in range(len(trace)):
        element = trace.el(row)
        start, end, value = trace.start[row], trace.end[row], trace.value[row]
        head = (part.item_number, part.kind, plane, trace.path_text(row))
        segment = trace.segments.get(row)
        if query is None or query.takes_row(part, row, source):
            raw = raw_bits(source, start, end) if end - start <= MOST_RAW else ""
            levels = " ".join(map(str, segment[0].levels)) if segment is not None else ""
            yield (
                *head, element.name, kind_of_row(trace, row), start, end, end - start, raw, value,
                meaning(element, value), levels, element.rule,
            )  # fmt: skip
        if segment is None or not symbols:
            continue
        for number, span in enumerate(settled_bits(segment[0])):
            if query is None or query(Subject(part, row, source, number, span)):
                yield (
                    *head, segment[1][number], SYMBOL, *span, span[1] - span[0], raw_bits(source, *span),
                    segment[0].levels[number], "", "", "FBA-23",
                )  # fmt: skip
