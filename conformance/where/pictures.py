"""What can be drawn of a difference: the curve of a FAP, reference against candidate; a mesh where it differs.

Rules: CNF-17, CNF-18. The candidate's output is read again, and nothing of it is trusted.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from snhc.conformance.candidate import Frame, Malformed, csv_rows, fap_text, ndjson
from snhc.conformance.differences import Difference
from snhc.reference_impl.face.fap_text import FapTextFrame
from snhc.vectors.decoding import decode_input
from snhc.vectors.manifest import Accepted, Entry

FRAMES_AROUND: Final = 60
# Of a larger mesh the nodes around the one that differs are shown.
NODES: Final = 400
# What a float of a plot can hold without trouble.
_LARGEST: Final = 1 << 53


def pictures(entry: Entry, suite: Path, difference: Difference, output: bytes, format: str) -> dict[str, Any]:
    """`curve` or `mesh`, where the difference is of that kind. Rules: CNF-17, CNF-18."""
    kind = entry.expect.kind if isinstance(entry.expect, Accepted) else "mesh" if entry.media == "m2d" else "fba"
    try:
        if kind in ("fba", "faces") and difference.fap is not None and difference.fap > 2:
            return _curve(entry, suite, difference, output, format, kind)
        if kind == "mesh" and difference.what.startswith(("nodes", "triangles", "order")):
            return _mesh(_reference(entry, suite, "mesh"), ndjson(output, "mesh"), difference)
    except Malformed:
        # Behind the difference the output may be anything.
        return {}
    return {}


def _reference(entry: Entry, suite: Path, kind: str) -> list[Frame]:
    if isinstance(entry.expect, Accepted):
        return ndjson((suite / entry.expect.file).read_bytes(), kind)
    aux = (suite / entry.aux).read_bytes() if entry.aux else None
    decoded = decode_input(entry.media, (suite / entry.file).read_bytes(), aux, entry.options.for_decoder())
    return ndjson(decoded.text.encode(), kind)


def _curve(entry: Entry, suite: Path, difference: Difference, output: bytes, format: str, kind: str) -> dict[str, Any]:
    assert difference.fap is not None
    reference = _reference(entry, suite, kind)
    if format == "fap":
        candidate: Sequence[Any] = fap_text(output)
        # These frames are those with FAP data only, and hold what was sent in them.
        reference = [frame for frame in reference if "T" in frame["state"]]
    else:
        candidate = csv_rows(output) if format == "csv" else ndjson(output, kind)
    first = max(0, difference.frame - FRAMES_AROUND)
    last = difference.frame + FRAMES_AROUND + 1
    ours = [_value(frame, difference.fap) for frame in reference[first:last]]
    theirs = [_value(frame, difference.fap) for frame in candidate[first:last]]
    return {
        "curve": {
            "fap": difference.fap, "first": first, "frame": difference.frame, "reference": ours, "candidate": theirs
        }
    }  # fmt: skip


def _value(frame: Any, fap: int) -> int | None:
    if isinstance(frame, FapTextFrame):
        value = frame.values[fap - 1]
    else:
        value = frame["faps"][fap - 1]
    return value if value is not None and abs(value) < _LARGEST else None


def _mesh(reference: list[Frame], candidate: list[Frame], difference: Difference) -> dict[str, Any]:
    frame = difference.frame
    if frame >= len(reference) or frame >= len(candidate):
        return {}
    ours, theirs = reference[frame]["nodes"], candidate[frame]["nodes"]
    triangles = _triangles(reference, frame)
    differing = [n for n, (a, b) in enumerate(zip(ours, theirs, strict=False)) if a != b]
    shown = list(range(len(ours)))
    if len(shown) > NODES:
        x, y = ours[differing[0]] if differing else ours[0]
        shown = sorted(sorted(shown, key=lambda n: (ours[n][0] - x) ** 2 + (ours[n][1] - y) ** 2)[:NODES])
    kept = set(shown)
    return {
        "mesh": {
            "frame": frame,
            "numbers": shown,
            "reference": [_point(ours[n]) for n in shown],
            "candidate": [_point(theirs[n]) if n < len(theirs) else None for n in shown],
            "triangles": [t for t in triangles if kept.issuperset(t)],
            "candidate_triangles": [t for t in _triangles(candidate, frame) if kept.issuperset(t) and len(set(t)) == 3],
            "marks": [n for n in differing if n in kept],
        }
    }


def _point(node: list[int]) -> list[int] | None:
    return node if all(abs(value) < _LARGEST for value in node) else None


def _triangles(frames: list[Frame], frame: int) -> list[list[int]]:
    """Those of the last geometry."""
    for number in range(frame, -1, -1):
        if "triangles" in frames[number]:
            triangles: list[list[int]] = frames[number]["triangles"]
            return triangles
    return []
