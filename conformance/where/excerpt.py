"""The reference trace around a place: a few elements, the symbols of a segment, the bytes with marked bits.

Rules: CNF-17, CNF-18, CNF-21, FBA-21..27 (symbols).
"""

from __future__ import annotations

from typing import Any, Final

from snhc.analyzer.parts import raw_bits
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.systems.stream import TracePart

from .location import Hit

BEFORE: Final = 8
AFTER: Final = 6
SYMBOLS_AROUND: Final = 6
BYTES_PER_LINE: Final = 16
LINES: Final = 8
# Longer elements show their first bits only.
_RAW_BITS: Final = 64


def excerpt(data: bytes, hit: Hit, fap: int | None) -> dict[str, Any]:
    """`trace`, `bytes`, and `symbols` where an arithmetic segment is at fault. Rules: CNF-17.

    `fap`: the FAP that differs, whose symbol is marked; None for none.
    """
    source = BytesSource(data)
    rows: list[dict[str, Any]] = []
    at = 0
    for part in (hit.before, hit.part, hit.after):
        if part is None:
            continue
        if part is hit.part:
            at = len(rows) + max(hit.row, 0)
        rows += [_row(part, row, source) for row in range(len(part.trace))]
        if part.error is not None:
            if part is hit.part and hit.row < 0:
                at = len(rows)
            error = part.error
            bits = list(error.bits) if error.bits is not None else [len(data) * 8, len(data) * 8]
            rows.append(
                {
                    "path": error.path, "element": error.what, "bits": bits, "raw": _raw(source, bits[0], bits[1]),
                    "value": str(error.value), "rule": error.rule, "error": str(error),
                }
            )  # fmt: skip
    at = min(at, len(rows) - 1)
    if at < 0:
        return {}
    rows[at]["mark"] = True
    first, last = rows[at]["bits"]
    out: dict[str, Any] = {
        "trace": rows[max(0, at - BEFORE) : at + AFTER + 1],
        "bytes": _bytes(data, first, last),
    }
    if hit.row >= 0 and hit.row in hit.part.trace.segments:
        out["symbols"] = _symbols(*hit.part.trace.segments[hit.row], fap)
    return out


def _raw(source: BytesSource, start: int, end: int) -> str:
    return raw_bits(source, start, min(end, start + _RAW_BITS)) + (".." if end - start > _RAW_BITS else "")


def _row(part: TracePart, row: int, source: BytesSource) -> dict[str, Any]:
    trace = part.trace
    el, start, end = trace.el(row), trace.start[row], trace.end[row]
    out: dict[str, Any] = {
        "path": trace.path_text(row), "element": el.name, "bits": [start, end], "raw": _raw(source, start, end),
        "value": str(trace.value[row]), "rule": el.rule,
    }  # fmt: skip
    if row in trace.segments:
        segment, _ = trace.segments[row]
        out["value"] = f"{len(segment.steps)} symbols"
    elif row in trace.blobs:
        out["value"] = f"{(end - start) >> 3} bytes"
    elif el.meaning.get(trace.value[row]):
        out["meaning"] = el.meaning[trace.value[row]]
    return out


def _symbols(segment: SegmentTrace, labels: list[str], fap: int | None) -> list[dict[str, Any]]:
    marked = [number for number, label in enumerate(labels) if fap is not None and label.split(" ")[1:2] == [str(fap)]]
    middle = marked[0] if marked else 0
    first = max(0, middle - SYMBOLS_AROUND)
    return [
        {
            "label": labels[number], "level": step.level, "model": "P" if step.adaptive else "I", "low": step.low,
            "high": step.high, "code_value": step.code_value, "c": step.c, "cum": [step.cum_low, step.cum_high],
            "total": step.total, "bits_read": step.bits_before, "mark": number in marked,
        }
        for number, step in list(enumerate(segment.steps))[first : middle + SYMBOLS_AROUND + 1]
    ]  # fmt: skip


def _bytes(data: bytes, first: int, last: int) -> dict[str, Any]:
    """Some lines of a hexdump, one line before the place; `marks`: the span, absolute."""
    line = BYTES_PER_LINE * 8
    start = max(0, first // line - 1) * BYTES_PER_LINE
    end = min(len(data), start + LINES * BYTES_PER_LINE, (max(last, first + 1) // line + 2) * BYTES_PER_LINE)
    return {"first": start, "hex": data[start:end].hex(), "marks": [[first, last]]}
