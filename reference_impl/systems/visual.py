"""Visual object sequences: the headers around a face object, and files that begin without them.

Rules: SYS-1, SYS-2, SYS-3, SYS-4, SYS-5, SYS-6, SYS-7, SYS-8 (names of profiles), SYS-9, FBA-1, FBA-3, FBA-44.
Not here: level checks (SYS-10..12), MP4 and BIFS (SYS-13..62).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, final

from ..bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    ReservedValue,
    TrailingData,
    Truncated,
    Unsupported,
)
from ..bitstream.startcodes import (
    FBA_OBJECT_PLANE,
    MESH_OBJECT,
    MESH_OBJECT_PLANE,
    USER_DATA,
    VISUAL_OBJECT,
    VISUAL_OBJECT_SEQUENCE,
    VISUAL_OBJECT_SEQUENCE_END,
)
from ..documents.kinds import HEAD_BYTES, hint, kind_of_input
from ..face.records import FbaObject, FbaPlane
from ..face.syntax import fba_object, is_fba_object
from ..mesh.records import MeshObject, MeshPlane
from ..mesh.syntax import mesh_object
from ..syntax.base import SyntaxIO
from ..syntax.element import Element, Fault
from ..syntax.framing import stuffing, user_data
from ..tables import profile_level_codes, profile_tools, start_codes

SEQUENCE_START_CODE: Final = Element("visual_object_sequence_start_code", "SYS-2", fixed=True)
SEQUENCE_END_CODE: Final = Element("visual_object_sequence_end_code", "FBA-1", fixed=True)
PROFILE_AND_LEVEL: Final = Element("profile_and_level_indication", "SYS-2")
VISUAL_OBJECT_START_CODE: Final = Element("visual_object_start_code", "SYS-3", fixed=True)
IS_VISUAL_OBJECT_IDENTIFIER: Final = Element("is_visual_object_identifier", "SYS-3")
VISUAL_OBJECT_VERID: Final = Element("visual_object_verid", "SYS-3")
VISUAL_OBJECT_PRIORITY: Final = Element("visual_object_priority", "SYS-3", lo=1, hi=7, fault=ReservedValue)
VISUAL_OBJECT_TYPE: Final = Element(
    "visual_object_type", "SYS-4", lo=1, hi=5, fault=ReservedValue,
    meaning={1: "video", 2: "still texture", 3: "mesh", 4: "FBA", 5: "3D mesh"},
)  # fmt: skip
TRAILING: Final = Element("trailing_data", "FBA-3")

TYPE_MESH: Final = 3
TYPE_FBA: Final = 4

AnyPlane = FbaPlane | MeshPlane

_NOT_OURS: Final = Fault(
    InputFormat, "FBA-1", "start code", "a file that begins with a start code 000001B0, 000001B5, 000001BA or 000001BC"
)
_MP4: Final = Fault(Unsupported, "SYS-13", "file", "a visual stream; MP4 files are not read")
_NOT_BUILT_TYPE: Final = Fault(Unsupported, "SYS-4", "visual_object_type", "3 (mesh), 4 (FBA)")
_NOT_BUILT: Final = Fault(
    Unsupported,
    "SYS-4",
    "start code",
    "an FBA or mesh object, 000001BA or 000001BC (files of the drafts: --compat draft)",
)
_NO_OBJECT: Final = Fault(InconsistentSemantics, "FBA-1", "start code", "an object before it")
_WRONG_OBJECT: Final = Fault(InconsistentSemantics, "SYS-6", "start code", "the object that visual_object_type names")
_NO_VISUAL_OBJECT: Final = Fault(InconsistentSemantics, "SYS-2", "start code", "visual_object or user_data")
_TRAILING: Final = Fault(TrailingData, "FBA-3", "data behind the end", "nothing, or another sequence or object")
_OPEN_USER_DATA: Final = Fault(Truncated, "SYS-5", "user_data", "a start code behind it")


# Where a stream stands: what may come next depends on it.
_BEGIN: Final = 0
_IN_SEQUENCE: Final = 1  # behind visual_object_sequence: a visual object must come (SYS-2)
_IN_OBJECT: Final = 2  # behind visual_object: the object that it names must come (SYS-6)
_BEHIND_OBJECT: Final = 3
_CLOSED: Final = 4
_OPEN: Final = (_IN_SEQUENCE, _IN_OBJECT)
_ENDS_EARLY: Final = {
    _IN_SEQUENCE: Fault(Truncated, "SYS-2", "start code", "visual_object before the end of the data"),
    _IN_OBJECT: Fault(
        Truncated, "SYS-6", "start code", "the object that visual_object_type names before the end of the data"
    ),
}


@final
class VisualObjectHeader:
    """`visual_object()` up to the object. Rules: SYS-3, SYS-4."""

    __slots__ = ("identifier", "priority", "type", "verid")

    def __init__(self) -> None:
        self.identifier = 0
        self.verid = 1
        self.priority = 1
        self.type = TYPE_FBA


@final
class StreamItem:
    """One thing of a visual stream: what `code` says.

    Rules: SYS-1, SYS-2, SYS-3, SYS-5, FBA-1.

    `code`: 0x1B0 sequence (`profile`), 0x1B1 its end, 0x1B2 `user_data`, 0x1B5 `header`, an FBA object's code
    (`fba`), 0x1BC a mesh object (`mesh`), 0 bytes behind the end (`trailing`). `start`, `end`: its bits; of an object
    only the start is known before its planes have been read.
    """

    __slots__ = ("code", "end", "fba", "header", "mesh", "profile", "start", "trailing", "user_data")

    def __init__(self, code: int = 0) -> None:
        self.code = code
        self.profile = 0
        self.user_data = b""
        self.header: VisualObjectHeader | None = None
        self.fba: FbaObject | None = None
        self.mesh: MeshObject | None = None
        self.trailing = b""
        self.start = 0
        self.end = 0


def profile_name(code: int) -> str:
    """`Simple Face Animation L1`, or "" for an unknown code. Rules: SYS-8."""
    for row in profile_level_codes():
        if row.code == code:
            return f"{row.profile} L{row.level}"
    return {0xFE: "none of these", 0xFF: "none needed"}.get(code, "")


def tools_outside(code: int) -> frozenset[str]:
    """The tools that a signalled profile does not contain; what is no known profile excludes none.

    Rules: SYS-8, SYS-9.
    """
    for row in profile_level_codes():
        if row.code == code:
            return frozenset(("face", "body", "mesh")) - profile_tools()[row.profile]
    return frozenset()


def visual_stream(io: SyntaxIO, items: Iterator[StreamItem]) -> Iterator[tuple[StreamItem, AnyPlane | None]]:
    """A whole stream: (item, None) for each item once its header is known, (item, plane) for each plane.

    An object's item comes twice: before its planes (`end` still 0) and behind them.

    Rules: SYS-1..7, FBA-1, FBA-3, FBA-44. `items`: for a reader, fresh items without end; for a writer, the items to
    write.
    """
    phase = _BEGIN
    expected = 0  # visual_object_type that the next object must have; 0: any
    in_sequence = False
    while True:
        item = next(items, None)
        if io.at_end(item is None):
            if phase == _BEGIN and io.reading:
                _refuse(io, -1, 0)
            io.require(phase not in _OPEN, _ENDS_EARLY.get(phase, _WRONG_OBJECT), None, io.tell(), io.tell())
            break
        assert item is not None
        item.start = io.tell()
        item.code = io.next_code(item.code)
        code = item.code
        is_object = (is_fba_object(io, code) and expected in (0, TYPE_FBA)) or (
            code == MESH_OBJECT and expected in (0, TYPE_MESH)
        )
        if code == VISUAL_OBJECT_SEQUENCE and phase not in _OPEN:
            if phase == _BEHIND_OBJECT:
                io.finding(
                    "no-end-code", "a sequence begins before the last one has ended", item.start, item.start + 32
                )
            in_sequence = True
            phase = _IN_SEQUENCE
            _sequence_header(io, item)
            yield item, None
        elif code == VISUAL_OBJECT and phase != _IN_OBJECT:
            _bare(io, in_sequence, item.start)
            phase = _IN_OBJECT
            expected = _visual_object(io, item)
            yield item, None
        elif code == USER_DATA and phase in _OPEN:
            _user_data(io, item)
            yield item, None
        elif is_object and phase != _IN_SEQUENCE:
            if not expected:
                _bare(io, in_sequence, item.start)
            yield from _object(io, item)
            phase = _BEHIND_OBJECT
            expected = 0
            yield item, None
        elif code == VISUAL_OBJECT_SEQUENCE_END and phase == _BEHIND_OBJECT:
            io.u(SEQUENCE_END_CODE, 32, code)
            item.end = io.tell()
            in_sequence = False
            phase = _CLOSED
            yield item, None
        elif phase in _OPEN:
            _misplaced(io, code, item.start, phase)
        elif phase == _BEGIN:
            _refuse(io, code, item.start)
        else:
            _trailing(io, item)
            yield item, None


def _object(io: SyntaxIO, item: StreamItem) -> Iterator[tuple[StreamItem, AnyPlane | None]]:
    """The item of an object, then each of its planes."""
    io.tool("mesh" if item.code == MESH_OBJECT else "face")
    if item.code == MESH_OBJECT:
        if item.mesh is None:
            item.mesh = MeshObject()
        yield item, None
        mesh_planes = iter(item.mesh.planes) if not io.reading else _fresh_mesh_planes()
        for mesh_plane in mesh_object(io, item.mesh, mesh_planes):
            yield item, mesh_plane
    else:
        if item.fba is None:
            item.fba = FbaObject()
        item.fba.start_code = item.code
        yield item, None
        planes = item.fba.coming
        if planes is None:
            planes = iter(item.fba.planes) if not io.reading else _fresh_planes()
        for plane in fba_object(io, item.fba, planes):
            yield item, plane
    item.end = io.tell()


def _misplaced(io: SyntaxIO, code: int, start: int, phase: int) -> None:
    """What must stand here is not there: another start code, other bytes, or too few of them."""
    bits = io.bits_left(32) if code < 0 else 32
    if bits < 32:
        io.require(False, _ENDS_EARLY[phase], None, start, start + bits)
    value = f"{code:08x}" if code >= 0 else io.head(4).hex()
    io.require(False, _NO_VISUAL_OBJECT if phase == _IN_SEQUENCE else _WRONG_OBJECT, value, start, start + 32)


def _fresh_planes() -> Iterator[FbaPlane]:
    while True:
        yield FbaPlane()


def _fresh_mesh_planes() -> Iterator[MeshPlane]:
    while True:
        yield MeshPlane()


def fresh_items() -> Iterator[StreamItem]:
    """What a reader passes to `visual_stream`. Rules: SYS-1."""
    while True:
        yield StreamItem()


def _refuse(io: SyntaxIO, code: int, start: int) -> None:
    bits = io.bits_left(32)
    if code < 0:
        _not_a_stream(io, bits)
        head = io.head(4)
        io.require(False, _NOT_OURS, head.hex() if head else None, start, start + bits)
    known = any(row.value <= code <= row.last for row in start_codes())
    if code in (VISUAL_OBJECT_SEQUENCE_END, USER_DATA, FBA_OBJECT_PLANE, MESH_OBJECT_PLANE):
        io.require(False, _NO_OBJECT, f"{code:08x}", start, start + 32)
    io.require(False, _NOT_BUILT if known else _NOT_OURS, f"{code:08x}", start, start + 32)


def _not_a_stream(io: SyntaxIO, bits: int) -> None:
    """A file of another kind is called by its name."""
    head = io.head(HEAD_BYTES)
    io.require(kind_of_input(head) != "mp4", _MP4, "MP4", 0, bits)
    known = hint(head)
    if known:
        io.require(False, _NOT_OURS.allowing(f"{_NOT_OURS.allowed}; {known}"), head[:4].hex(), 0, bits)


def _bare(io: SyntaxIO, in_sequence: bool, start: int) -> None:
    if not in_sequence and start == 0:
        io.finding("no-sequence-header", "the stream begins without visual_object_sequence", start, start + 32)


def _sequence_header(io: SyntaxIO, item: StreamItem) -> None:
    io.u(SEQUENCE_START_CODE, 32, item.code)
    start = io.tell()
    item.profile = io.u(PROFILE_AND_LEVEL, 8, item.profile)
    item.end = io.tell()
    io.outside = tools_outside(item.profile)
    if not profile_name(item.profile):
        io.finding("profile-unknown", f"profile_and_level_indication 0x{item.profile:02X}", start, io.tell())


def _user_data(io: SyntaxIO, item: StreamItem) -> None:
    item.user_data = user_data(io, item.user_data)
    item.end = io.tell()
    # Only a start code ends user data, and an object must follow it anyway.
    io.require(not io.reading or not io.at_end(False), _OPEN_USER_DATA, None, item.start, item.end)


def _visual_object(io: SyntaxIO, item: StreamItem) -> int:
    header = item.header
    if header is None:
        header = VisualObjectHeader()
        item.header = header
    io.u(VISUAL_OBJECT_START_CODE, 32, item.code)
    header.identifier = io.u(IS_VISUAL_OBJECT_IDENTIFIER, 1, header.identifier)
    if header.identifier:
        header.verid = io.u(VISUAL_OBJECT_VERID, 4, header.verid)
        header.priority = io.u(VISUAL_OBJECT_PRIORITY, 3, header.priority)
    start = io.tell()
    header.type = io.u(VISUAL_OBJECT_TYPE, 4, header.type)
    io.require(header.type in (TYPE_FBA, TYPE_MESH), _NOT_BUILT_TYPE, header.type, start, io.tell())
    stuffing(io)
    item.end = io.tell()
    return header.type


def _trailing(io: SyntaxIO, item: StreamItem) -> None:
    item.code = 0
    start = io.tell()
    item.trailing = io.rest(TRAILING, item.trailing)
    item.end = io.tell()
    io.require(not io.strict, _TRAILING, f"{(item.end - start) >> 3} bytes", start, item.end)
    io.finding("trailing-data", f"{(item.end - start) >> 3} bytes behind the end", start, item.end)
