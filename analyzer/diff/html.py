"""The report of a comparison as one page that needs nothing else.

Rules: CNF-17, CNF-18.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Final

from ..pages import base_css, svg_path
from .report import Comparison, title_of
from .values import ValueDiff

CURVES: Final = 12
POINTS: Final = 1_000


@dataclass(frozen=True, slots=True)
class Curve:
    """Two curves in a box of 1000 x 100. Rules: CNF-18. `a`, `b`: SVG paths, with gaps where there is no value."""

    title: str
    low: str
    high: str
    start: str
    end: str
    a: str
    b: str


def html_text(comparison: Comparison) -> str:
    """The page. Rules: CNF-18. What the inputs hold stands in it as text, never as markup."""
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    page = environment.from_string(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    syntax, values = comparison.syntax, comparison.values
    elements = [] if syntax is None else [
        (name, count)
        for name, count in sorted(syntax.elements.items(), key=lambda item: (-item[1].at_odds, item[0]))
        if count.at_odds
    ]  # fmt: skip
    channels = [] if values is None else [
        (title_of(name), channel)
        for name, channel in sorted(values.channels.items(), key=lambda item: (-item[1].rms, item[0]))
        if channel.different or channel.missing
    ]  # fmt: skip
    curves = [] if values is None else list(_curves(values))
    return page.render(base=base_css(), c=comparison, elements=elements, channels=channels, curves=curves) + "\n"


def _curves(values: ValueDiff) -> Iterator[Curve]:
    names = [name for name in values.curves if values.channels[name].different]
    names.sort(key=lambda name: (-values.channels[name].rms, name))
    times = values.times
    for name in names[:CURVES]:
        a, b = values.curves[name]
        known = [value for value in (*a, *b) if not isnan(value)]
        if not known or len(times) < 2 or times[-1] <= times[0]:
            continue
        low, high = min(known), max(known)
        yield Curve(
            title_of(name), f"{low:g}", f"{high:g}", f"{times[0]:.2f}", f"{times[-1]:.2f}",
            _path(times, a, low, high), _path(times, b, low, high),
        )  # fmt: skip


def _path(times: array[float], values: array[float], low: float, high: float) -> str:
    """At most two points per bin of time, its least and greatest, so that no peak is lost."""
    span = (times[-1] - times[0]) or 1.0
    height = (high - low) or 1.0
    step = max(1, len(values) // POINTS)
    points: list[tuple[float, float] | None] = []
    for first in range(0, len(values), step):
        known = [n for n in range(first, min(first + step, len(values))) if not isnan(values[n])]
        if not known:
            points.append(None)
            continue
        for n in sorted({min(known, key=values.__getitem__), max(known, key=values.__getitem__)}):
            points.append((1000.0 * (times[n] - times[0]) / span, 97.0 - 94.0 * (values[n] - low) / height))
    return svg_path(points)
