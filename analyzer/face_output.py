"""Decoded face frames as picture, animation, GLB file or window: what `snhc render` does with a face.

Rules: CNF-19, FBA-38, FAC-5, FAC-6, FAC-10.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat, ResourceLimit
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.model.fat import FatReadings

from .face_pictures import gif, gif_plan, png, sheet, spread
from .face_render import Camera, Picture, Renderer, SoftwareRenderer, camera_for, check_size
from .face_scene import FOLLOWED, FaceModel, FaceScene

FORMATS: Final = ("png", "gif", "glb")
# Frames on a contact sheet, and how many stand side by side; pictures that make the palette of a GIF.
SHEET_FRAMES: Final = 12
SHEET_COLUMNS: Final = 4
_SAMPLES: Final = 6


@dataclass(frozen=True, slots=True)
class Drawing:
    """How a face is drawn.

    Rules: FAC-10. `size`: width and height in pixels. `view`: a name of `face_render.VIEWS`. `software`: without GL.
    """

    size: tuple[int, int] = (400, 480)
    view: str = "front"
    software: bool = False
    readings: FatReadings = FOLLOWED


def pick_frames(
    frames: Iterable[FaceFrame], wanted: tuple[int, int | None] = (0, None), limits: Limits = DEFAULT_LIMITS
) -> list[FaceFrame]:
    """The frames from `wanted[0]` up to, not including, `wanted[1]`.

    Rules: CNF-22, FBA-44. Raises ResourceLimit past `collected_planes`, InputFormat where none is left.
    """
    out: list[FaceFrame] = []
    for frame in islice(frames, wanted[0], wanted[1]):
        if len(out) >= limits.collected_planes:
            raise ResourceLimit("CNF-22", "frames", value=len(out) + 1, allowed=f"at most {limits.collected_planes}")
        out.append(frame)
    if not out:
        raise InputFormat("CNF-19", "frames", value="none", allowed="a stream with the frames that are wanted")
    return out


def times_of(frames: Sequence[FaceFrame]) -> list[Fraction]:
    """Seconds, one per frame. Rules: FBA-38."""
    return [Fraction(*frame.time) for frame in frames]


def choose_renderer(model: FaceModel, drawing: Drawing) -> tuple[Renderer, str]:
    """The renderer that works here, and why it is the one in software: empty if GL draws or `software` was asked for.

    Rules: CNF-19.
    """
    check_size(drawing.size)
    if drawing.software:
        return SoftwareRenderer(model, drawing.size), ""
    try:
        from .face_vtk import VtkRenderer, gl_window

        if gl_window() is not None:
            return VtkRenderer(model, drawing.size), ""
    except ModuleNotFoundError as error:
        return SoftwareRenderer(model, drawing.size), f"{error.name} is not installed"
    return SoftwareRenderer(model, drawing.size), "no GL works here"


def face_file(
    model: FaceModel,
    frames: Sequence[FaceFrame],
    format: str,
    drawing: Drawing = Drawing(),
    on_progress: Callable[[int], None] | None = None,
    on_note: Callable[[str], None] | None = None,
) -> bytes:
    """The file of a format of FORMATS.

    Rules: CNF-19, FBA-38, FAC-6. png: one frame, or a sheet of up to SHEET_FRAMES of them, evenly spread. gif: all,
    with the stream's timing. glb: all, as morph targets with keys. `on_note`: told when GL is wanted but does not work.
    """
    times = times_of(frames)
    if format == "glb":
        from .glb import glb

        return glb(model, frames, times, drawing.readings)
    scene = FaceScene(model, drawing.readings)
    renderer, why = choose_renderer(model, drawing)
    if why and on_note is not None:
        on_note(f"drawn in software: {why}")
    camera = camera_for(scene, drawing.view, drawing.size)
    if format == "gif":
        plan = gif_plan(times)
        chosen = [frames[n] for n, _ in plan]
        some = [chosen[n] for n in spread(len(chosen), _SAMPLES)]
        samples = list(_pictures(scene, renderer, camera, some))
        return gif(_pictures(scene, renderer, camera, chosen), [d for _, d in plan], samples, on_progress)
    shown = [frames[n] for n in spread(len(frames), SHEET_FRAMES)]
    pictures = list(_pictures(scene, renderer, camera, shown, on_progress))
    if len(pictures) == 1:
        return png(pictures[0])
    labels = [f"frame {frame.index}, {float(time):.3f} s" for frame, time in zip(shown, times_of(shown), strict=True)]
    return png(sheet(pictures, labels, SHEET_COLUMNS))


def drawn_count(frames: Sequence[FaceFrame], format: str) -> int:
    """How many pictures `face_file` reports to `on_progress`. Rules: CNF-19."""
    if format == "gif":
        return len(gif_plan(times_of(frames)))
    return min(len(frames), SHEET_FRAMES)


def _pictures(
    scene: FaceScene,
    renderer: Renderer,
    camera: Camera,
    frames: Sequence[FaceFrame],
    on_progress: Callable[[int], None] | None = None,
) -> Iterator[Picture]:
    for done, vertices in enumerate(scene.each(frames), 1):
        yield renderer.picture(vertices, camera)
        if on_progress is not None:
            on_progress(done)


def show(model: FaceModel, frames: Sequence[FaceFrame], drawing: Drawing = Drawing()) -> None:
    """Open a window and play the frames with the stream's timing until it is closed. Rules: FBA-38, FAC-10."""
    from .face_vtk import play

    scene = FaceScene(model, drawing.readings)
    plan = gif_plan(times_of(frames))
    poses = scene.each([frames[n] for n, _ in plan])
    camera = camera_for(scene, drawing.view, drawing.size)
    play(model, poses, [duration / 100 for _, duration in plan], camera, drawing.size)
