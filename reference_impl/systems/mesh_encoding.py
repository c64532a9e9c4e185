"""From mesh documents and pictures to whole streams.

Rules: MSH-1, MSH-2, MSH-23, FBA-6..8, FBA-37, FBA-38, SYS-2, SYS-3. Pictures need `snhc[view]`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING, Final

from ..bitstream.errors import EncodeError, InconsistentSemantics
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..bitstream.startcodes import (
    MESH_OBJECT,
    VISUAL_OBJECT,
    VISUAL_OBJECT_SEQUENCE,
    VISUAL_OBJECT_SEQUENCE_END,
)
from ..face.requests import rate_fields
from ..mesh.document import DocumentFrame
from ..mesh.encode import delaunay_geometry, encode_frames, geometry_plane, motion_plane, uniform_geometry
from ..mesh.records import MeshObject, MeshPlane
from ..syntax.element import DEFAULT_READINGS, Readings
from .visual import TYPE_MESH, StreamItem, VisualObjectHeader

if TYPE_CHECKING:
    from ..mesh.design_encoder import Picture

DEFAULT_RATE: Final = Fraction(30)
DESIGNS: Final = ("content", "uniform")
# A period is divided by at most so much to make a rate that the header can say.
_MOST_PARTS: Final = 4096


def mesh_stream(planes: Iterable[MeshPlane], *, profile: int | None = None, end_code: bool = True) -> list[StreamItem]:
    """Planes as a stream.

    Rules: MSH-1, SYS-2, SYS-3. `profile`: profile_and_level_indication of a sequence header, None for none.
    """
    items: list[StreamItem] = []
    if profile is not None:
        sequence = StreamItem(VISUAL_OBJECT_SEQUENCE)
        sequence.profile = profile
        header = StreamItem(VISUAL_OBJECT)
        header.header = VisualObjectHeader()
        header.header.type = TYPE_MESH
        items += [sequence, header]
    mesh = StreamItem(MESH_OBJECT)
    mesh.mesh = MeshObject()
    mesh.mesh.planes = list(planes)
    items.append(mesh)
    if end_code:
        items.append(StreamItem(VISUAL_OBJECT_SEQUENCE_END))
    return items


def encode_mesh(
    frames: Sequence[DocumentFrame],
    *,
    rate: Fraction | None = None,
    far: str = "error",
    profile: int | None = None,
    end_code: bool = True,
    readings: Readings = DEFAULT_READINGS,
    limits: Limits = DEFAULT_LIMITS,
) -> list[StreamItem]:
    """A mesh document as a stream.

    Rules: MSH-1..16, FBA-37, FBA-38, CNF-1.

    `rate`: planes per second; None: 30 where the frames' times allow it, else the lowest rate that does. `far`: what
    happens to vectors outside -2048..2047 (`mesh.encode.FAR`). Raises as `mesh.encode.MeshEncoder.plane`;
    EncodeError or InconsistentSemantics for times that no header can say.
    """
    planes = encode_frames(frames, far=far, readings=readings, limits=limits)
    if not planes:
        raise EncodeError("MSH-1", "frames", value=0, allowed="1 or more")
    set_times(planes, [frame.time for frame in frames], rate)
    return mesh_stream(planes, profile=profile, end_code=end_code)


def set_times(planes: Sequence[MeshPlane], times: Sequence[Fraction | None], rate: Fraction | None) -> None:
    """Fill the temporal headers: rate and time code in the first plane, frames skipped wherever time jumps.

    Rules: FBA-6..8, FBA-37, FBA-38.

    `times`: seconds by plane; None, for all of them: one plane per period. Raises InconsistentSemantics for times
    that do not grow, EncodeError for those that no rate or time code makes.
    """
    known = [time for time in times if time is not None]
    if known and len(known) != len(times):
        raise InconsistentSemantics(
            "FBA-38", "time", value="absent", allowed="a time in every frame or in none",
            path=f"frames[{times.index(None)}]",
        )  # fmt: skip
    for k in range(1, len(known)):
        if known[k] <= known[k - 1]:
            raise InconsistentSemantics(
                "FBA-38", "time", value=str(known[k]), allowed=f"after {known[k - 1]}", path=f"frames[{k}].time"
            )
    steps = [known[k] - known[k - 1] for k in range(1, len(known))]
    chosen = _rate_of(steps) if rate is None else rate
    first = planes[0]
    if chosen != DEFAULT_RATE:
        frame_rate, seconds, offset, said = rate_fields(chosen)
        if said != chosen:
            raise EncodeError("FBA-37", "frame rate", value=str(chosen), allowed="sixteenths, times 1000/1001 or not")
        _needs_intra(first, "frame rate", str(chosen))
        h = first.header
        h.is_frame_rate, h.frame_rate, h.seconds, h.frequency_offset = 1, frame_rate, seconds, offset
    if known and known[0] != 0:
        _set_time_code(first, known[0])
    for k, step in enumerate(steps):
        periods = step * chosen
        if periods.denominator != 1:
            raise EncodeError(
                "FBA-38", "time", value=str(known[k + 1]), allowed=f"whole periods of 1/{chosen} s after the first",
                path=f"frames[{k + 1}].time",
            )  # fmt: skip
        if periods > 1:
            planes[k].header.skip_frames = 1
            planes[k].header.number_of_frames_to_skip = int(periods) - 1


def _needs_intra(plane: MeshPlane, what: str, value: str) -> None:
    if not plane.is_intra:
        raise EncodeError("FBA-6", what, value=value, allowed="a first frame that is intra", path="frames[0].intra")


def _set_time_code(plane: MeshPlane, time: Fraction) -> None:
    if time.denominator != 1 or time >= 86400:
        raise EncodeError(
            "FBA-7", "time", value=str(time), allowed="whole seconds below 86400 for the first frame",
            path="frames[0].time",
        )  # fmt: skip
    _needs_intra(plane, "time", str(time))
    h = plane.header
    h.is_time_code = 1
    h.time_code_hours, rest = divmod(int(time), 3600)
    h.time_code_minutes, h.time_code_seconds = divmod(rest, 60)


def _rate_of(steps: Sequence[Fraction]) -> Fraction:
    if all((step * DEFAULT_RATE).denominator == 1 for step in steps):
        return DEFAULT_RATE
    numerator, denominator = 0, 1
    for step in steps:
        denominator = lcm(denominator, step.denominator)
    for step in steps:
        numerator = gcd(numerator, step.numerator * (denominator // step.denominator))
    lowest = Fraction(denominator, numerator)
    for parts in range(1, _MOST_PARTS + 1):
        rate = lowest * parts
        if rate >= 256:
            break
        if rate * 16 >= Fraction(1000, 1001) and rate_fields(rate)[3] == rate:
            return rate
    raise EncodeError("FBA-37", "frame rate", value=str(lowest), allowed="sixteenths below 256, times 1000/1001 or not")


@dataclass(frozen=True, slots=True)
class PictureEncoding:
    """A stream made from pictures.

    Rules: MSH-23.

    `psnr`: of self-transfiguration, in dB, for each picture after the first: the first one, warped along the mesh,
    against it, over the pixels that the mesh covers; infinite where they are equal. `nodes`, `triangles`: how many.
    """

    items: list[StreamItem]
    psnr: tuple[float, ...]
    nodes: int
    triangles: int


def encode_pictures(
    pictures: Sequence[Picture],
    *,
    design: str = "content",
    mask: Picture | None = None,
    interior_nodes: int = 100,
    spacing: float = 6.0,
    tolerance: float = 1.5,
    split_code: int = 2,
    search: int = 7,
    passes: int = 2,
    rate: Fraction | None = None,
    profile: int | None = None,
    end_code: bool = True,
) -> PictureEncoding:
    """A mesh designed for the first picture and tracked over the others, as a stream.

    Rules: MSH-1, MSH-22, MSH-23.

    `pictures`: luminance, 2D arrays of one shape, 0..255. `design`: `content` (Delaunay; `mask`, `interior_nodes`,
    `spacing`, `tolerance` as in `content_based_design`) or `uniform` (`split_code`). `search`, `passes`: as in
    `track`. `rate`: planes per second, None: 30. Raises EncodeError.
    """
    from ..mesh.design_encoder import content_based_design, uniform_design
    from ..mesh.tracking import self_transfiguration, track_sequence

    if not pictures:
        raise EncodeError("MSH-23", "pictures", value=0, allowed="1 or more")
    if design not in DESIGNS:
        raise EncodeError("MSH-23", "design", value=design, allowed=", ".join(DESIGNS))
    sequence = list(pictures)
    if design == "uniform":
        height, width = sequence[0].shape[:2]
        mesh = uniform_design(width, height, split_code)
        assert mesh.cells is not None
        first = geometry_plane(uniform_geometry(mesh.cells))
    else:
        mesh = content_based_design(
            sequence[0], mask, interior_nodes=interior_nodes, spacing=spacing, tolerance=tolerance
        )
        first = geometry_plane(delaunay_geometry(list(zip(mesh.xs, mesh.ys, strict=True)), mesh.boundary_count))
    vectors = track_sequence(sequence, mesh, search=search, passes=passes)
    planes = [first, *(motion_plane(mesh.topology, vx, vy) for vx, vy in vectors)]
    set_times(planes, [None] * len(planes), rate)
    return PictureEncoding(
        mesh_stream(planes, profile=profile, end_code=end_code),
        tuple(self_transfiguration(sequence, mesh, vectors)),
        len(mesh.xs),
        len(mesh.topology.triangles),
    )
