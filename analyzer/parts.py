"""The parts of a trace that are wanted, and what to call them.

Rules: CNF-17, CNF-21.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.bitstream.startcodes import (
    MESH_OBJECT,
    USER_DATA,
    VISUAL_OBJECT,
    VISUAL_OBJECT_SEQUENCE,
    VISUAL_OBJECT_SEQUENCE_END,
)
from snhc.reference_impl.syntax.base import BARE_CODE, END, PLANE, STUFFED_CODE, STUFFED_END, ZERO_PADDING
from snhc.reference_impl.syntax.tracer import ROOT, Trace
from snhc.reference_impl.systems.stream import TracePart, is_object
from snhc.reference_impl.systems.visual import AnyPlane, StreamItem

KINDS: Final = {
    0: "trailing_data",
    VISUAL_OBJECT_SEQUENCE: "visual_object_sequence",
    VISUAL_OBJECT_SEQUENCE_END: "visual_object_sequence_end",
    USER_DATA: "user_data",
    VISUAL_OBJECT: "visual_object",
    MESH_OBJECT: "mesh_object",
}
BOUNDARIES: Final = {
    PLANE: "plane",
    STUFFED_CODE: "stuffed_code",
    BARE_CODE: "bare_code",
    STUFFED_END: "stuffed_end",
    END: "end",
    ZERO_PADDING: "zero_padding",
}


def kind_of(item: StreamItem) -> str:
    """What an item is: `fba_object`, `user_data`, ... Rules: SYS-1."""
    return "fba_object" if item.fba is not None else KINDS.get(item.code, "unknown")


@dataclass(frozen=True, slots=True)
class Selection:
    """Planes [first, last) of one object, counted from 0; last None: up to its end. Rules: CNF-17."""

    object_number: int
    first: int
    last: int | None


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


class Part:
    """A part of a trace with its place in the stream.

    Rules: CNF-17, CNF-21.

    `item_number`: of the item it belongs to, from 0. `opens`: it begins that item. `plane_number`: -1 where it is no
    whole plane. `closes`: it is what stands behind the planes of an object.
    """

    __slots__ = ("closes", "error", "findings", "item_number", "kind", "opens", "plane", "plane_number", "trace")

    def __init__(self, part: TracePart, item_number: int, plane_number: int, opens: bool, closes: bool) -> None:
        self.trace: Trace = part.trace
        self.plane: AnyPlane | None = part.plane if part.error is None else None
        self.findings = part.findings
        self.error: SnhcError | None = part.error
        self.item_number = item_number
        self.plane_number = plane_number
        self.opens = opens
        self.closes = closes
        self.kind = kind_of(part.item) if part.item is not None and part.error is None else ""


class Parts:
    """The parts of a stream's trace in order; memory does not grow with it.

    Rules: CNF-17, CNF-19.

    Making it reads the first part: InputFormat, where the data is no visual stream at all, is raised there. Any other
    fault ends the last part, and then stands in `error`. `missed`: after the last part, what the selection asked for
    and the stream does not hold; empty where it had something to show.
    """

    def __init__(self, parts: Iterator[TracePart], selection: Selection | None = None) -> None:
        self._parts = parts
        self.selection = selection
        self._first = next(parts, None)
        self.error: SnhcError | None = None
        self.missed = ""
        self._end = 0
        if self._first is not None and isinstance(self._first.error, InputFormat):
            raise self._first.error

    def __iter__(self) -> Iterator[Part]:
        wanted = self.selection
        objects = planes = 0
        for part, object_number in self._numbered():
            objects = object_number + 1
            if part.error is not None:
                self.error = part.error
            if len(part.trace):
                self._end = part.trace.end[-1]
            if wanted is None or part.error is not None:
                yield part
            elif object_number == wanted.object_number and part.plane is not None:
                planes = part.plane_number + 1
                if part.plane_number >= wanted.first:
                    yield part
                if wanted.last is not None and planes >= wanted.last:
                    return
        if wanted is not None and planes <= wanted.first and self.error is None:
            what = f"object {wanted.object_number} has {_count(planes, 'plane')}"
            if wanted.object_number >= objects:
                what = f"the stream has {_count(objects, 'object')}"
            self.missed = f"{what}; the first is number 0"

    def unclaimed(self, source: Source) -> tuple[int, int] | None:
        """The bits that no row claims because a fault ended the trace; None without one, or where none are left.

        Rules: CNF-17, CNF-21. Together with all rows they partition the data.
        """
        end = 8 * source.size() if self.error is not None else 0
        return (self._end, end) if end > self._end else None

    def _numbered(self) -> Iterator[tuple[Part, int]]:
        item_number = object_number = plane_number = -1
        before: StreamItem | None = None
        for part in self._all():
            item = part.item
            opens = part.error is None and item is not before
            if opens:
                before = item
                item_number += 1
                if item is not None and is_object(item):
                    object_number += 1
                    plane_number = -1
            is_plane = part.plane is not None and part.error is None
            if is_plane:
                plane_number += 1
            closes = not opens and not is_plane and part.error is None
            yield (
                Part(part, max(item_number, 0), plane_number if is_plane else -1, opens, closes),
                object_number,
            )

    def _all(self) -> Iterator[TracePart]:
        if self._first is not None:
            yield self._first
            self._first = None
            yield from self._parts


def raw_bits(source: Source, start: int, end: int) -> str:
    """The bits [start, end) as a text of 0 and 1. Rules: CNF-21."""
    if end <= start:
        return ""
    first, last = start >> 3, (end + 7) >> 3
    number = int.from_bytes(source.read_at(first, last - first), "big")
    number >>= (last << 3) - end
    return format(number & ((1 << (end - start)) - 1), f"0{end - start}b")


def path_names(trace: Trace, path: int) -> list[str]:
    """The levels of a path: `plane[0]`, `fap`, `group[7]`. Rules: CNF-21."""
    if path == ROOT:
        return []
    return [name + (f"[{index}]" if index >= 0 else "") for name, index in trace.steps(path)]
