"""Pictures and animations of decoded mesh streams: textured, or wireframe with traversal and motion.

Rules: MSH-16, MSH-17, MSH-20, MSH-21, MSH-22. Needs numpy and Pillow, which are in `snhc[view]`. Not here: drawing
itself (`rasteriser`, `drawing`).
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Final

import numpy as np
from PIL import Image

from ..bitstream.errors import InputFormat, RangeViolation, ResourceLimit
from .drawing import draw_mesh
from .rasteriser import warp
from .records import MeshFrame
from .topology import MeshTopology

FORMATS: Final = ("png", "gif")
_MAX_PIXELS: Final = 1 << 28
_LEAST_MS: Final = 20  # browsers show anything shorter more slowly

Rendered = tuple[MeshFrame, "Image.Image"]


def open_picture(data: bytes, name: str) -> Image.Image:
    """A picture file as luminance or RGB. Rules: MSH-22. Raises InputFormat, ResourceLimit."""
    try:
        with Image.open(io.BytesIO(data)) as picture:
            return picture.convert("L" if picture.mode in ("1", "L") else "RGB")
    except Image.DecompressionBombError as error:
        raise ResourceLimit("MSH-22", name, value=str(error)[:80], allowed="a picture of fewer pixels") from None
    except (OSError, SyntaxError, ValueError):
        # The library's words name an object in memory, not the file.
        raise InputFormat("MSH-22", name, value="unreadable", allowed="a picture, such as PNG or JPEG") from None


def render_frames(
    frames: Iterable[MeshFrame],
    *,
    texture: Image.Image | None = None,
    planes: tuple[int, int | None] = (0, None),
    most: int | None = None,
    scale: int = 2,
    numbers: bool = True,
) -> list[Rendered]:
    """A picture of every frame that has a mesh, all of one size.

    Rules: MSH-16, MSH-17, MSH-20, MSH-21, MSH-22.

    `frames`: of one object, from its first on. `texture`: lies under the mesh of each intra plane, pixel for pixel, and
    is warped along; None: triangles coloured in traversal order, nodes with their place in it, motion vectors.
    `planes`: first and behind the last frame to draw. `most`: at most so many pictures. `scale`: picture pixels per
    pixel (with texture) or half pixel, from 1. `numbers`: whether the places in the traversal are written. Raises
    RangeViolation, ResourceLimit, and InputFormat where there is nothing to draw.
    """
    if scale < 1:
        raise RangeViolation("MSH-22", "scale", value=scale, allowed="1 or more")
    chosen = list(_chosen(frames, planes, most))
    if not chosen:
        raise InputFormat("MSH-22", "frames", value="none with a mesh", allowed="frames with a mesh to draw")
    if texture is not None:
        _check_size(len(chosen), texture.width * scale * texture.height * scale)
        return [(item[0], _textured(item, texture, scale)) for item in chosen]
    xs = [x for frame, _, _, before in chosen for nodes in (frame, before) if nodes for x, _ in nodes.nodes]
    ys = [y for frame, _, _, before in chosen for nodes in (frame, before) if nodes for _, y in nodes.nodes]
    bounds = (min(xs), min(ys), max(xs), max(ys))
    _check_size(len(chosen), (bounds[2] - bounds[0]) * scale * (bounds[3] - bounds[1]) * scale)
    return [(item[0], _drawn(item, bounds, scale, numbers)) for item in chosen]


# Frame, the intra frame it moves from, its topology, the frame before it unless the mesh is new.
_Chosen = tuple[MeshFrame, MeshFrame, MeshTopology, MeshFrame | None]


def _chosen(frames: Iterable[MeshFrame], planes: tuple[int, int | None], most: int | None) -> Iterable[_Chosen]:
    intra: MeshFrame | None = None
    before: MeshFrame | None = None
    topology = MeshTopology([], [], [])
    count = 0
    for number, frame in enumerate(frames):
        if (planes[1] is not None and number >= planes[1]) or count == most:
            return
        if frame.triangles is not None and frame.order is not None:
            intra, before = frame, None
            topology = MeshTopology(list(frame.triangles), list(frame.order), [])
        if intra is not None and number >= planes[0]:
            yield frame, intra, topology, before
            count += 1
        before = frame


def _check_size(count: int, pixels: int) -> None:
    if count * pixels > _MAX_PIXELS:
        raise ResourceLimit(
            "MSH-22", "pixels", value=count * pixels, allowed=f"up to {_MAX_PIXELS}: a smaller scale, or fewer planes"
        )


def _textured(item: _Chosen, texture: Image.Image, scale: int) -> Image.Image:
    frame, intra, topology, _ = item
    drawn, _ = warp(
        np.asarray(texture),
        [x for x, _ in intra.nodes],
        [y for _, y in intra.nodes],
        [x * scale for x, _ in frame.nodes],
        [y * scale for _, y in frame.nodes],
        topology.triangles,
        texture.width * scale,
        texture.height * scale,
    )
    return Image.fromarray(drawn)


def _drawn(item: _Chosen, bounds: tuple[int, int, int, int], scale: int, numbers: bool) -> Image.Image:
    frame, _, topology, before = item
    xs, ys = [x for x, _ in frame.nodes], [y for _, y in frame.nodes]
    previous = ([x for x, _ in before.nodes], [y for _, y in before.nodes]) if before is not None else None
    return draw_mesh(xs, ys, topology, scale=scale, order=True, numbers=numbers, previous=previous, bounds=bounds)


def picture_file(rendered: Sequence[Rendered], format: str) -> bytes:
    """PNG of the first picture, or an animated GIF of all, at the speed that the frames' times say.

    Rules: MSH-22. `format`: one of FORMATS. Raises InputFormat for another.
    """
    if format not in FORMATS:
        raise InputFormat("MSH-22", "format", value=format, allowed=", ".join(FORMATS))
    out = io.BytesIO()
    first = rendered[0][1]
    if format == "png":
        first.save(out, "PNG", optimize=True)
        return out.getvalue()
    # RGB first: pictures of luminance would share one grey palette, pictures of meshes need their own colours.
    pictures = [picture.convert("RGB").quantize(256, dither=Image.Dither.NONE) for _, picture in rendered]
    pictures[0].save(
        out, "GIF", save_all=True, append_images=pictures[1:], duration=_durations(rendered), loop=0, disposal=1
    )
    return out.getvalue()


def _durations(rendered: Sequence[Rendered]) -> list[int]:
    """Milliseconds that each picture stands; the last as long as the one before it."""
    times = [Fraction(*frame.time) for frame, _ in rendered]
    steps = [later - earlier for earlier, later in pairwise(times)]
    steps.append(steps[-1] if steps else Fraction(1))
    return [min(max(round(1000 * step), _LEAST_MS), 60_000) for step in steps]
