"""What all pages share: colours and fonts (`base.css`, light and dark), and paths of drawings.

Rules: CNF-18. A page is one file: the sheet stands in it, before the page's own rules.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def base_css() -> str:
    """The style sheet that every page begins with. Rules: CNF-18."""
    return Path(__file__).with_name("base.css").read_text(encoding="utf-8")


def svg_path(points: Iterable[tuple[float, float] | None]) -> str:
    """The `d` of an SVG path, to a hundredth; None is a gap. Rules: CNF-18."""
    out: list[str] = []
    pen = "M"
    for point in points:
        if point is None:
            pen = "M"
        else:
            out.append(f"{pen}{svg_number(point[0])} {svg_number(point[1])}")
            pen = "L"
    return "".join(out)


def svg_number(value: float) -> str:
    """A length of a drawing, to a hundredth and without zeros at its end. Rules: CNF-18."""
    return f"{value:.2f}".rstrip("0").rstrip(".")
