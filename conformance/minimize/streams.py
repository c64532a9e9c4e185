"""Streams that the reference accepts: items, planes, parts of planes, parameters and magnitudes.

Rules: CNF-17. The records of the smallest stream so far are read anew for each edit: what is tried is always what the
writer makes of edited records, and what the reader makes of that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, TypeVar

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.records import FbaPlane, ParameterData
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.syntax.base import PLANE
from snhc.reference_impl.systems.stream import read_stream, write_stream
from snhc.reference_impl.systems.visual import AnyPlane, StreamItem

from . import faces, meshes
from .ddmin import ddmin, lower

if TYPE_CHECKING:
    from .shrink import Shrinker

Edit = Callable[[list[StreamItem]], None]
_T = TypeVar("_T")


class Stream:
    """The stream of a shrinker, as records. Rules: CNF-17."""

    def __init__(self, shrinker: Shrinker) -> None:
        self.shrinker = shrinker
        self._options = shrinker.entry.options.for_decoder()

    def items(self) -> list[StreamItem]:
        """Fresh records of the smallest stream so far."""
        return read_stream(self.shrinker.data, self._options)

    def planes(self, items: list[StreamItem]) -> list[AnyPlane]:
        """The planes of all objects."""
        return [
            plane
            for item in items
            for plane in ([*item.fba.planes] if item.fba is not None else [*item.mesh.planes] if item.mesh else [])
        ]

    def reduce(self, units: Sequence[_T], keeping: Callable[[list[_T]], Edit]) -> list[_T]:
        """The units that are needed. Rules: CNF-17. `keeping`: the edit of this stream that leaves the others out."""
        base = self.shrinker.data
        return ddmin(units, lambda kept: self.tries(keeping(kept), base))

    def lower(self, value: int, setting: Callable[[int], Edit]) -> None:
        """A number made as small as may be. Rules: CNF-17. `setting`: the edit of this stream that sets it."""
        base = self.shrinker.data
        lower(value, lambda smaller: self.tries(setting(smaller), base))

    def tries(self, edit: Edit, base: bytes | None = None) -> bool:
        """Whether the stream still fails in the same way after an edit. `base`: the stream to edit."""
        items = self.items() if base is None else read_stream(base, self._options)
        try:
            edit(items)
            data = write_stream(items)
        except (SnhcError, IndexError, ValueError):
            # There is no such stream.
            return False
        return self.shrinker.takes(data)


def shrink(shrinker: Shrinker) -> None:
    """One round of all passes. Rules: CNF-17."""
    stream = Stream(shrinker)
    _items(stream)
    _planes(stream)
    _parts(stream)
    if any(item.fba is not None for item in stream.items()):
        faces.parameters(stream)
        faces.magnitudes(stream)
        faces.coefficients(stream)
    if any(item.mesh is not None for item in stream.items()):
        meshes.shrink(stream)
    _skips(stream)


def _items(stream: Stream) -> None:
    count = len(stream.items())

    def keeping(kept: list[int]) -> Edit:
        def edit(items: list[StreamItem]) -> None:
            items[:] = [items[i] for i in kept]

        return edit

    stream.reduce(range(count), keeping)


def _planes(stream: Stream) -> None:
    for number, item in enumerate(stream.items()):
        planes = item.fba.planes if item.fba is not None else item.mesh.planes if item.mesh is not None else []

        def keeping(kept: list[int], number: int = number) -> Edit:
            def edit(items: list[StreamItem]) -> None:
                one = items[number]
                if one.fba is not None:
                    one.fba.planes = [one.fba.planes[i] for i in kept]
                elif one.mesh is not None:
                    one.mesh.planes = [one.mesh.planes[i] for i in kept]

            return edit

        stream.reduce(range(len(planes)), keeping)


def _no_baps(plane: AnyPlane) -> bool:
    if isinstance(plane, FbaPlane) and plane.baps is not None:
        plane.baps = None
        plane.fba_object_mask &= ~2
        return True
    return False


def _no_faps(plane: AnyPlane) -> bool:
    if isinstance(plane, FbaPlane) and plane.faps is not None:
        plane.faps = None
        plane.fba_object_mask &= ~1
        return True
    return False


def _no_start_code(plane: AnyPlane) -> bool:
    if isinstance(plane, FbaPlane) and plane.start_code:
        plane.start_code = 0
        plane.boundary = PLANE
        return True
    return False


def _no_user_data(plane: AnyPlane) -> bool:
    if isinstance(plane, MeshPlane) and plane.user_data:
        plane.user_data = []
        return True
    return False


def _no_mesh_data(plane: AnyPlane) -> bool:
    if isinstance(plane, MeshPlane) and plane.motion is not None:
        plane.motion = None
        plane.mesh_mask = 0
        return True
    return False


def _no_time_code(plane: AnyPlane) -> bool:
    had = plane.header.is_time_code
    plane.header.is_time_code = 0
    return bool(had)


def _no_frame_rate(plane: AnyPlane) -> bool:
    had = plane.header.is_frame_rate
    plane.header.is_frame_rate = 0
    return bool(had)


def _no_skip(plane: AnyPlane) -> bool:
    had = plane.header.skip_frames
    plane.header.skip_frames = plane.header.number_of_frames_to_skip = 0
    return bool(had)


def _no_lists(which: str, number: int) -> Callable[[AnyPlane], bool]:
    def drop(plane: AnyPlane) -> bool:
        data: ParameterData | None = getattr(plane, which, None)
        if data is None or not data.new[number]:
            return False
        data.new[number] = 0
        return True

    return drop


def _no_flag(name: str) -> Callable[[AnyPlane], bool]:
    def drop(plane: AnyPlane) -> bool:
        data: ParameterData | None = getattr(plane, "faps", None)
        if data is None or not getattr(data, name):
            return False
        setattr(data, name, 0)
        return True

    return drop


def _no_tails(plane: AnyPlane) -> bool:
    found = False
    for data in (getattr(plane, "faps", None), getattr(plane, "baps", None)):
        if data is not None and any(data.tails):
            data.tails = [0, 0, 0]
            found = True
    return found


def _quant_1(plane: AnyPlane) -> bool:
    data: ParameterData | None = getattr(plane, "faps", None)
    if not plane.is_intra or data is None or data.quant == 1:
        return False
    data.quant = 1
    return True


_DROPS: Final[list[Callable[[AnyPlane], bool]]] = [
    _no_baps, _no_faps, _no_start_code, _no_user_data, _no_mesh_data, _no_time_code, _no_frame_rate, _no_skip,
    *(_no_lists(which, number) for which in ("faps", "baps") for number in range(4)),
    *(_no_flag(name) for name in ("gender", "viseme_def", "init_face", "expression_def")), _no_tails, _quant_1,
]  # fmt: skip


def _parts(stream: Stream) -> None:
    """What planes carry beyond what they must; one kind at a time, over all planes."""
    for drop in _DROPS:
        # Asked on records that are thrown away: asking drops.
        able = [i for i, plane in enumerate(stream.planes(stream.items())) if drop(plane)]

        def dropping(kept: list[int], able: list[int] = able, drop: Callable[[AnyPlane], bool] = drop) -> Edit:
            def edit(items: list[StreamItem]) -> None:
                planes = stream.planes(items)
                for i in set(able) - set(kept):
                    drop(planes[i])

            return edit

        stream.reduce(able, dropping)


def _skips(stream: Stream) -> None:
    for i, plane in enumerate(stream.planes(stream.items())):

        def skipping(count: int, i: int = i) -> Edit:
            def edit(items: list[StreamItem]) -> None:
                header = stream.planes(items)[i].header
                header.number_of_frames_to_skip = count

            return edit

        if plane.header.skip_frames:
            stream.lower(plane.header.number_of_frames_to_skip, skipping)
