"""`snhc render`: pictures and animations of mesh streams.

Rules: CNF-19, MSH-17, MSH-20..22.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from .common import Common, Output, common_options, format_of, open_binary, open_input
from .extras import needs_view

if TYPE_CHECKING:
    from snhc.reference_impl.bitstream.source import Source
    from snhc.reference_impl.mesh.records import MeshFrame

SUFFIXES = {".png": "png", ".gif": "gif"}


def parse_planes(value: str | None) -> tuple[int, int | None]:
    """`A:B`, `A:`, `:B` or `A` (that one) as first and behind the last. Rules: CNF-19. Raises click.BadParameter."""
    if value is None:
        return 0, None
    match = re.fullmatch(r"(\d{0,9})(:?)(\d{0,9})", value, re.ASCII)
    if match is None or (not match[2] and (not match[1] or match[3])):
        raise click.BadParameter(f"{value!r} is not of the form A:B")
    first = int(match[1] or 0)
    last = first + 1 if not match[2] else int(match[3]) if match[3] else None
    if last is not None and last <= first:
        raise click.BadParameter(f"{value!r} holds no plane")
    return first, last


@click.command()
@click.argument("file")
@click.option("--texture", metavar="IMAGE", help="Warp this picture along with the mesh.")
@click.option(
    "--planes", metavar="A:B", callback=lambda ctx, param, value: parse_planes(value),
    help="Frames from A up to, not including, B; the first is 0. Default: all.",
)  # fmt: skip
@click.option(
    "--scale", type=click.IntRange(1, 64), default=None, metavar="N",
    help="Pixels per pixel (with --texture, default 1) or per half pixel (default 2).",
)  # fmt: skip
@click.option("--format", "format_", type=click.Choice(tuple(SUFFIXES.values())), help="Default: by -o, else png.")
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(
    file: str,
    texture: str | None,
    planes: tuple[int, int | None],
    scale: int | None,
    format_: str | None,
    object_number: int,
    common: Common,
) -> None:
    """Draw a mesh stream as a picture or an animation.

    FILE is a visual stream with a mesh object, - for standard input. png shows the first frame with a mesh, gif all of
    them. Without --texture the triangles are coloured in the order of the traversal, from green to violet, flipped ones
    red; numbers at nodes are their place in it, blue lines are motion vectors.
    """
    chosen = format_of(format_, common.output, SUFFIXES, "png")
    if common.output in (None, "-") and sys.stdout.isatty():
        raise click.UsageError(f"{chosen} is not for terminals; give -o FILE")
    with needs_view("render"):
        from snhc.reference_impl.mesh.render import open_picture, picture_file, render_frames

    picture = None
    if texture is not None:
        with open_binary(texture) as image:
            picture = open_picture(image.read(), texture)
    with open_input(file) as source, Output(common.output, common.keep_partial) as out:
        rendered = render_frames(
            _frames(source, object_number, common),
            texture=picture,
            planes=planes,
            most=1 if chosen == "png" else None,
            scale=scale if scale is not None else 2 if picture is None else 1,
        )
        out.write(picture_file(rendered, chosen))


def _frames(source: Source, object_number: int, common: Common) -> Iterator[MeshFrame]:
    from snhc.reference_impl.bitstream.errors import Unsupported
    from snhc.reference_impl.mesh.records import MeshPlane
    from snhc.reference_impl.systems.stream import decode_planes

    def begin(kind: str) -> None:
        if kind != "mesh":
            raise Unsupported("MSH-22", "object", value=kind, allowed="a mesh object; rendering faces is not built yet")

    for plane in decode_planes(source, common.options(object_number), common.report, begin):
        assert isinstance(plane, MeshPlane)
        yield from plane.frames
