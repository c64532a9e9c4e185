"""Pictures of meshes without a texture: wireframe, traversal, motion vectors.

Rules: MSH-20, MSH-21 (the order shown), MSH-17 (flipped triangles are red). Needs Pillow, which is in
`snhc[view]`. Not implemented here: textured pictures (`rasteriser`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.bitstream.errors import RangeViolation, ResourceLimit
from snhc.reference_impl.mesh.motion import foldovers
from snhc.reference_impl.mesh.topology import MeshTopology

if TYPE_CHECKING:
    from PIL import Image

_MARGIN: Final = 24
_MAX_PIXELS: Final = 1 << 26
_LINE: Final = (40, 40, 60)
_FLIPPED: Final = (220, 40, 40)
_VECTOR: Final = (0, 110, 200)
_TEXT: Final = (120, 0, 90)


def _traversal_colour(place: int, count: int) -> tuple[int, int, int]:
    """From light green (labelled first) to light violet (last)."""
    part = place / max(1, count - 1)
    return round(190 + 40 * part), round(240 - 55 * part), round(190 + 55 * part)


def draw_mesh(
    xs: Sequence[int],
    ys: Sequence[int],
    topology: MeshTopology,
    *,
    scale: float = 2.0,
    order: bool = False,
    labels: bool = False,
    numbers: bool = True,
    previous: tuple[Sequence[int], Sequence[int]] | None = None,
    bounds: tuple[int, int, int, int] | None = None,
) -> Image.Image:
    """A wireframe picture of a mesh.

    Rules: MSH-17, MSH-20, MSH-21.

    `xs`, `ys`: positions in half pixels. `scale`: picture pixels per half pixel, above 0. `order`: triangles
    coloured by their label, nodes with their place in the traversal. `labels`: node numbers instead of
    places. `numbers`: whether anything is written at all. `previous`: positions of the plane before; motion vectors
    are drawn from there. `bounds`: least x, least y, greatest x, greatest y that the picture shows, None: what it
    needs. Raises RangeViolation, ResourceLimit.
    """
    from PIL import Image, ImageDraw

    if not scale > 0:
        raise RangeViolation("MSH-21", "scale", value=str(scale), allowed="above 0")
    all_xs = [*xs, *(previous[0] if previous else ())] or [0]
    all_ys = [*ys, *(previous[1] if previous else ())] or [0]
    left, top, right, bottom = bounds or (min(all_xs), min(all_ys), max(all_xs), max(all_ys))
    width = round((right - left) * scale) + 2 * _MARGIN
    height = round((bottom - top) * scale) + 2 * _MARGIN
    if width * height > _MAX_PIXELS:
        raise ResourceLimit("MSH-21", "pixels", value=width * height, allowed=f"up to {_MAX_PIXELS}: a smaller scale")

    def place(x: int, y: int) -> tuple[int, int]:
        return round((x - left) * scale) + _MARGIN, round((y - top) * scale) + _MARGIN

    picture = Image.new("RGB", (width, height), (255, 255, 255))
    pen = ImageDraw.Draw(picture)
    at = [place(x, y) for x, y in zip(xs, ys, strict=True)]
    flipped = set(foldovers(list(xs), list(ys), topology.triangles))
    count = len(topology.triangles)
    for t, (a, b, c) in enumerate(topology.triangles):
        fill = _traversal_colour(t, count) if order else None
        if t in flipped:
            fill = (255, 205, 205)
        if fill is not None:
            pen.polygon([at[a], at[b], at[c]], fill=fill)
    # Flipped ones last: they lie over their neighbours' edges.
    for t in sorted(range(count), key=lambda t: t in flipped):
        a, b, c = topology.triangles[t]
        pen.line([at[a], at[b], at[c], at[a]], fill=_FLIPPED if t in flipped else _LINE)
        if order and numbers:
            centre = ((at[a][0] + at[b][0] + at[c][0]) // 3, (at[a][1] + at[b][1] + at[c][1]) // 3)
            pen.text(centre, str(t), fill=(90, 90, 90), anchor="mm")
    if previous is not None:
        for node, (x, y) in enumerate(zip(previous[0], previous[1], strict=True)):
            pen.line([place(x, y), at[node]], fill=_VECTOR, width=2)
    for k, node in enumerate(topology.order):
        x, y = at[node]
        pen.ellipse([x - 2, y - 2, x + 2, y + 2], fill=_VECTOR)
        if (order or labels) and numbers:
            pen.text((x + 4, y - 10), str(node if labels else k), fill=_TEXT)
    return picture
