"""Drawings of failures as inline SVG: FAP curves, meshes. Made of numbers only, so that there is nothing to escape.

Rules: CNF-17, CNF-18. Colours are classes of `report.css`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from markupsafe import Markup

from snhc.analyzer.pages import svg_number as _n
from snhc.analyzer.pages import svg_path

_WIDTH: Final = 860
_HEIGHT: Final = 260
_LEFT: Final = 76
_TOP: Final = 14
_BOTTOM: Final = 34
_RIGHT: Final = 14
_MESH: Final = 520
_MARGIN: Final = 28


def curve(data: Mapping[str, Any]) -> Markup:
    """The curve of a FAP: reference and candidate. Rules: CNF-18. `data`: the `curve` of the evidence."""
    first, frame = int(data["first"]), int(data["frame"])
    series = {name: list(data[name]) for name in ("reference", "candidate")}
    known = [value for values in series.values() for value in values if value is not None]
    if not known:
        return Markup("")
    low, high = float(min(known)), float(max(known))
    if low == high:
        low, high = low - 1, high + 1
    count = max(2, *(len(values) for values in series.values()))

    def x(number: int) -> float:
        return _LEFT + (_WIDTH - _LEFT - _RIGHT) * number / (count - 1)

    def y(value: float) -> float:
        return _TOP + (_HEIGHT - _TOP - _BOTTOM) * (high - value) / (high - low)

    parts = [
        f'<svg class="drawing" role="img" viewBox="0 0 {_WIDTH} {_HEIGHT}" xmlns="http://www.w3.org/2000/svg">'
        f"<title>FAP {int(data['fap'])}, reference and candidate, frames {first} to {first + count - 1}</title>"
    ]
    for value in _ticks(low, high, 5):
        at = _n(y(value))
        parts.append(f'<line class="grid" x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" y1="{at}" y2="{at}"/>')
        parts.append(f'<text class="tick end" x="{_LEFT - 8}" y="{_n(y(value) + 4)}">{_n(value)}</text>')
    for value in _ticks(first, first + count - 1, 8):
        at = _n(x(int(value) - first))
        parts.append(f'<text class="tick middle" x="{at}" y="{_HEIGHT - _BOTTOM + 18}">{int(value)}</text>')
    fault = _n(x(frame - first))
    parts.append(f'<line class="fault" x1="{fault}" x2="{fault}" y1="{_TOP}" y2="{_HEIGHT - _BOTTOM}"/>')
    for name, values in series.items():
        path = svg_path([None if v is None else (x(i), y(v)) for i, v in enumerate(values)])
        parts.append(f'<path class="{name}" d="{path}"/>')
        if len(values) <= 40:
            parts += [
                f'<circle class="{name} dot" cx="{_n(x(i))}" cy="{_n(y(v))}" r="{3 if name == "candidate" else 4.5}"/>'
                for i, v in enumerate(values)
                if v is not None
            ]
    parts.append(f'<text class="tick middle" x="{_n((_LEFT + _WIDTH) / 2)}" y="{_HEIGHT - 2}">frame</text></svg>')
    return Markup("".join(parts))


def _ticks(low: float, high: float, about: int) -> list[float]:
    """Round numbers from low to high."""
    rough = max((high - low) / about, 1)
    size = 10 ** (len(str(int(rough))) - 1)
    step = next(size * factor for factor in (1, 2, 5, 10) if size * factor >= rough)
    start = -(-low // step) * step
    return [start + step * i for i in range(int((high - start) // step) + 1)]


def mesh(data: Mapping[str, Any]) -> Markup:
    """A mesh where it differs. Rules: CNF-18. `data`: the `mesh` of the evidence.

    Reference edges and nodes; where they are not the same the candidate's, joined by a line.
    """
    numbers: Sequence[int] = data["numbers"]
    ours = {n: p for n, p in zip(numbers, data["reference"], strict=True) if p is not None}
    theirs = {n: p for n, p in zip(numbers, data["candidate"], strict=True) if p is not None}
    marks = [n for n in data["marks"] if n in ours]
    if not ours:
        return Markup("")
    # The candidate may have thrown a node anywhere: the picture stays with the mesh.
    xs, ys = [p[0] for p in ours.values()], [p[1] for p in ours.values()]
    width, height = max(max(xs) - min(xs), 1), max(max(ys) - min(ys), 1)
    scale = min((_WIDTH - 2 * _MARGIN) / width, (_MESH - 2 * _MARGIN) / height)

    def at(point: Sequence[int]) -> tuple[float, float]:
        return (
            min(max(_MARGIN + (point[0] - min(xs)) * scale, 4), _WIDTH - 4),
            min(max(_MARGIN + (point[1] - min(ys)) * scale, 4), height * scale + 2 * _MARGIN - 4),
        )

    def edges(triangles: Iterable[Sequence[int]]) -> set[tuple[int, int]]:
        return {(min(a, b), max(a, b)) for t in triangles for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))}

    shared = edges(data["triangles"])
    other = edges(data["candidate_triangles"])
    parts = [
        f'<svg class="drawing" role="img" viewBox="0 0 {_WIDTH} {_n(height * scale + 2 * _MARGIN)}" '
        f'xmlns="http://www.w3.org/2000/svg"><title>Mesh of frame {int(data["frame"])}: {len(ours)} nodes, '
        f"{len(marks)} of them elsewhere</title>"
    ]

    def line(kind: str, a: tuple[float, float], b: tuple[float, float]) -> str:
        return f'<line class="{kind}" x1="{_n(a[0])}" y1="{_n(a[1])}" x2="{_n(b[0])}" y2="{_n(b[1])}"/>'

    parts += [line("edge", at(ours[a]), at(ours[b])) for a, b in sorted(shared) if a in ours and b in ours]
    if other:
        parts += [line("reference", at(ours[a]), at(ours[b])) for a, b in sorted(shared - other) if {a, b} <= set(ours)]
        parts += [
            line("candidate", at(theirs[a]), at(theirs[b])) for a, b in sorted(other - shared) if {a, b} <= set(theirs)
        ]
    for n in marks:
        if n in theirs:
            parts.append(line("candidate", at(ours[n]), at(theirs[n])))
    for n, point in ours.items():
        x, y = at(point)
        parts.append(f'<circle class="reference dot" cx="{_n(x)}" cy="{_n(y)}" r="{4 if n in marks else 2.5}"/>')
    for n in marks:
        x, y = at(ours[n])
        parts.append(f'<text class="tick" x="{_n(x + 7)}" y="{_n(y - 7)}">{int(n)}</text>')
        if n in theirs:
            x, y = at(theirs[n])
            parts.append(f'<circle class="candidate dot" cx="{_n(x)}" cy="{_n(y)}" r="4"/>')
    parts.append("</svg>")
    return Markup("".join(parts))
