"""`snhc render`: pictures and animations of mesh and face streams.

Rules: CNF-19, FAC-10, FBA-38, MSH-17, MSH-20..22.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import click

from .common import Common, Output, common_options, format_of, open_binary, open_input, parse_planes, progress
from .extras import needs_view

if TYPE_CHECKING:
    from snhc.reference_impl.bitstream.source import Source
    from snhc.reference_impl.face.frames import FaceFrame
    from snhc.reference_impl.mesh.records import MeshFrame

SUFFIXES = {".png": "png", ".gif": "gif", ".glb": "glb"}
# The keys of `face_render.VIEWS`, spelled out so that `--help` loads no numpy; a test compares them.
VIEWS = ("front", "three-quarter", "side")
# Its MIN_SIDE and MAX_SIDE, alike.
SIDES = (16, 4096)
FOR_FACES = ("model", "size", "view", "software", "interactive")
FOR_MESHES = ("texture", "scale", "no_numbers")


def parse_size(value: str | None) -> tuple[int, int] | None:
    """`400x480` as width and height. Rules: CNF-19. Raises click.BadParameter."""
    if value is None:
        return None
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", value, re.ASCII)
    if match is None:
        raise click.BadParameter(f"{value!r} is not of the form WIDTHxHEIGHT")
    size = int(match[1]), int(match[2])
    if not all(SIDES[0] <= side <= SIDES[1] for side in size):
        raise click.BadParameter(f"{value!r}: width and height are {SIDES[0]} to {SIDES[1]} pixels")
    return size


@click.command()
@click.argument("file")
@click.option("--texture", metavar="IMAGE", help="Warp this picture along with the mesh.")
@click.option(
    "--planes", metavar="A:B", callback=lambda ctx, param, value: parse_planes(value) or (0, None),
    help="Frames from A up to, not including, B; the first is 0. Default: all.",
)  # fmt: skip
@click.option(
    "--scale", type=click.IntRange(1, 64), default=None, metavar="N",
    help="Pixels per pixel (with --texture, default 1) or per half pixel (default 2).",
)  # fmt: skip
@click.option("--no-numbers", is_flag=True, help="Without --texture: colours and lines only.")
@click.option("--model", metavar="MODEL", help="Faces: a model with face animation tables. Default: the shipped head.")
@click.option(
    "--size", metavar="WxH", callback=lambda ctx, param, value: parse_size(value),
    help="Faces: pixels of a picture. Default: 400x480.",
)  # fmt: skip
@click.option("--view", type=click.Choice(VIEWS), help="Faces: from where. Default: front.")
@click.option("--software", is_flag=True, help="Faces: draw without GL, the same picture on every machine.")
@click.option("--interactive", is_flag=True, help="Faces: play in a window.")
@click.option("--format", "format_", type=click.Choice(tuple(SUFFIXES.values())), help="Default: by -o, else png.")
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(
    file: str,
    texture: str | None,
    planes: tuple[int, int | None],
    scale: int | None,
    no_numbers: bool,
    model: str | None,
    size: tuple[int, int] | None,
    view: str | None,
    software: bool,
    interactive: bool,
    format_: str | None,
    object_number: int,
    common: Common,
) -> None:
    """Draw a face or mesh stream as a picture or an animation.

    FILE is a visual stream, - for standard input. Faces: png shows one frame, or up to 12 of them on a sheet; gif plays
    them; glb holds the model with morph targets and the animation.

    Meshes: png shows the first frame with a mesh, gif all of them. Without --texture the triangles are coloured in the
    order of the traversal, from green to violet, flipped ones red; numbers at nodes are their place in it, blue lines
    are motion vectors.
    """
    chosen = format_of(format_, common.output, SUFFIXES, "png")
    if not interactive and common.output in (None, "-") and sys.stdout.isatty():
        raise click.UsageError(f"{chosen} is not for terminals; give -o FILE")
    if interactive and not _has_display():
        raise click.UsageError("--interactive needs a display, and there is none")
    with open_input(file) as source:
        kind, stream = _begun(source, object_number, common)
        _refuse_options(FOR_MESHES if kind == "fba" else FOR_FACES, "meshes" if kind == "fba" else "faces")
        if kind == "fba":
            from snhc.reference_impl.face.frames import FaceFrame

            frames = (frame for frame in stream if isinstance(frame, FaceFrame))
            look = Look(model, size or (400, 480), view or VIEWS[0], software)
            _faces(frames, planes, chosen, look, interactive, common)
        else:
            from snhc.reference_impl.mesh.records import MeshFrame

            if chosen == "glb":
                raise click.UsageError("glb of a mesh: snhc decode --format glb")
            meshes = (frame for frame in stream if isinstance(frame, MeshFrame))
            _meshes(meshes, planes, chosen, texture, scale, not no_numbers, common)


def _has_display() -> bool:
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _refuse_options(names: tuple[str, ...], what: str) -> None:
    context = click.get_current_context()
    for name in names:
        if context.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE:
            raise click.UsageError(f"--{name.replace('_', '-')} is for {what}; the stream holds none")


def _begun(source: Source, object_number: int, common: Common) -> tuple[str, Iterator[FaceFrame | MeshFrame]]:
    """The kind of the object, and its frames."""
    from snhc.reference_impl.systems.stream import decode_planes

    kinds: list[str] = []
    planes = decode_planes(source, common.options(object_number), common.report, kinds.append)
    first = next(planes, None)
    return kinds[0], (frame for plane in chain(() if first is None else (first,), planes) for frame in plane.frames)


@dataclass(frozen=True, slots=True)
class Look:
    """How a face is to be drawn. Rules: FAC-10. `model`: a file, None for the shipped head."""

    model: str | None
    size: tuple[int, int]
    view: str
    software: bool


def _faces(
    frames: Iterator[FaceFrame],
    wanted: tuple[int, int | None],
    chosen: str,
    look: Look,
    interactive: bool,
    common: Common,
) -> None:
    with needs_view("render"):
        from snhc.analyzer.face_output import Drawing, drawn_count, face_file, pick_frames, show
        from snhc.analyzer.face_scene import fat_readings, load_model

        if chosen != "glb":
            import PIL  # noqa: F401 (asked for here, so that its absence is told before anything is drawn)
    drawing = Drawing(look.size, look.view, look.software, fat_readings(common.readings))
    model = load_model(look.model, common.limits, common.report, common.readings)
    picked = pick_frames(frames, wanted, common.limits)
    if interactive:
        with needs_view("render"):
            show(model, picked, drawing)
        return
    with (
        Output(common.output, common.keep_partial) as out,
        progress(common, "drawing", drawn_count(picked, chosen)) as advance,
    ):
        out.write(face_file(model, picked, chosen, drawing, advance, None if common.quiet else _note))


def _note(text: str) -> None:
    click.echo(f"note: {text}", err=True)


def _meshes(
    frames: Iterator[MeshFrame],
    wanted: tuple[int, int | None],
    chosen: str,
    texture: str | None,
    scale: int | None,
    numbers: bool,
    common: Common,
) -> None:
    with needs_view("render"):
        from snhc.reference_impl.mesh.render import open_picture, picture_file, render_frames

    picture = None
    if texture is not None:
        with open_binary(texture) as image:
            picture = open_picture(image.read(), texture)
    with Output(common.output, common.keep_partial) as out:
        rendered = render_frames(
            frames,
            texture=picture,
            planes=wanted,
            most=1 if chosen == "png" else None,
            scale=scale if scale is not None else 2 if picture is None else 1,
            numbers=numbers,
        )
        out.write(picture_file(rendered, chosen))
