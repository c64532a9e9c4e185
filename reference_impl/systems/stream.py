"""Whole streams: decode, read, write, trace.

Rules: FBA-1, FBA-44, CNF-1, CNF-21, CNF-22, CNF-24.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

from ..bitstream.cursor import BitCursor
from ..bitstream.errors import InconsistentSemantics, ResourceLimit, SnhcError
from ..bitstream.findings import Finding
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..bitstream.source import BytesSource, Source
from ..bitstream.startcodes import MESH_OBJECT, VISUAL_OBJECT, VISUAL_OBJECT_SEQUENCE
from ..entropy.profile import EntropyProfile
from ..face.frames import FaceFrame
from ..face.syntax import is_fba_object
from ..mesh.records import MeshFrame, MeshPlane
from ..syntax.element import DEFAULT_READINGS, Readings
from ..syntax.faulty import FaultyWriter, Mutation, was_cut
from ..syntax.reader import Reader
from ..syntax.tracer import Trace, Tracer
from ..syntax.writer import Writer
from .visual import AnyPlane, StreamItem, fresh_items, visual_stream


@dataclass(frozen=True, slots=True)
class Options:
    """How a stream is to be read.

    Rules: FBA-4, FBA-44, CNF-22, CNF-24.

    `draft`: take the start codes of the drafts. `strict`: bytes behind the end are an error. `object_number`: which
    object to decode, from 0. `limits`, `readings`: in force. `profile`: entropy tables of DCT segments, None: shipped.
    """

    draft: bool = False
    strict: bool = False
    object_number: int = 0
    limits: Limits = DEFAULT_LIMITS
    readings: Readings = field(default=DEFAULT_READINGS)
    profile: EntropyProfile | None = None


DEFAULT_OPTIONS = Options()
# What a writer hands on at once: taking the bytes of each plane would cost more than copying them.
PIECE_BITS: Final = 8 * 256


def reader(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    on_finding: Callable[[Finding], None] | None = None,
    collect: bool = False,
) -> Reader:
    """A reader over a source or bytes. Rules: CNF-21, CNF-24."""
    return Reader(
        BitCursor(_source(source)),
        limits=options.limits,
        readings=options.readings,
        draft=options.draft,
        strict=options.strict,
        on_finding=on_finding,
        collect=collect,
        profile=options.profile,
    )


def _ignore(finding: Finding) -> None:
    """Nobody asked for findings: keeping them would make memory grow with the stream."""


def _source(source: Source | bytes) -> Source:
    return BytesSource(source) if isinstance(source, bytes) else source


def is_object(item: StreamItem) -> bool:
    """Whether an item is a face or mesh object. Rules: SYS-4."""
    return item.fba is not None or item.mesh is not None


def decode_planes(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    on_finding: Callable[[Finding], None] | None = None,
    on_object: Callable[[str], None] | None = None,
) -> Iterator[AnyPlane]:
    """The planes of one object, each with its frames.

    Rules: FBA-1, FBA-44. Memory does not grow with the stream. `on_object` is called
    with its kind (`fba`, `mesh`) when the object has been found.
    Raises the first fault in stream order; planes before it have been yielded.
    """
    io = reader(source, options, on_finding if on_finding is not None else _ignore)
    stream = visual_stream(io, fresh_items())
    number = -1
    for item, plane in stream:
        if plane is not None:
            if number == options.object_number:
                yield plane
        elif is_object(item) and not item.end:
            number += 1
            if number == options.object_number and on_object is not None:
                on_object("mesh" if item.mesh is not None else "fba")
        elif is_object(item) and number == options.object_number:
            break
    if number < options.object_number:
        raise InconsistentSemantics(
            "FBA-44", "objects in the stream", value=number + 1, bits=(0, io.cursor.end()),
            allowed=f"{options.object_number + 1} or more",
        )  # fmt: skip
    while not io.at_end(False):
        code = io.next_code(0)
        if code in (VISUAL_OBJECT_SEQUENCE, VISUAL_OBJECT, MESH_OBJECT) or is_fba_object(io, code):
            io.finding("trailing-data", "another object follows, which is not decoded", io.tell(), io.tell() + 32)
            break
        next(stream, None)


def decode_frames(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    on_finding: Callable[[Finding], None] | None = None,
) -> Iterator[FaceFrame | MeshFrame]:
    """The frames of one object. Rules: FBA-1, FBA-44, CNF-1."""
    for plane in decode_planes(source, options, on_finding):
        yield from plane.frames


def read_stream(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    on_finding: Callable[[Finding], None] | None = None,
) -> list[StreamItem]:
    """Everything that a stream holds, as records that write back to the same bytes.

    Rules: FBA-43, CNF-22. Raises ResourceLimit past `collected_planes`.
    """
    io = reader(source, options, on_finding, collect=True)
    items: list[StreamItem] = []
    count = 0
    for item, plane in visual_stream(io, fresh_items()):
        if plane is None:
            if not is_object(item) or not item.end:
                items.append(item)
            continue
        count += 1
        if count > options.limits.collected_planes:
            raise ResourceLimit(
                "CNF-22", "planes collected", value=count, bits=(plane.start, plane.end),
                allowed=f"at most {options.limits.collected_planes}",
            )  # fmt: skip
        if isinstance(plane, MeshPlane):
            assert item.mesh is not None
            item.mesh.planes.append(plane)
        else:
            assert item.fba is not None
            item.fba.planes.append(plane)
    return items


def write_stream(items: Iterable[StreamItem], writer: Writer | None = None) -> bytes:
    """The bytes of a stream.

    Rules: FBA-3, FBA-41. Raises EncodeError where a record holds what the syntax cannot. A plane that would read as
    a start code gets one before it, also in its record.
    """
    io = writer if writer is not None else Writer()
    for _ in visual_stream(io, iter(list(items))):
        pass
    return io.sink.getvalue()


def write_pieces(items: Iterable[StreamItem], writer: Writer) -> Iterator[bytes]:
    """The bytes of a stream, piece by piece. Rules: FBA-3, FBA-41, CNF-22.

    Memory does not grow with an object whose planes are `coming`. Raises EncodeError as `write_stream` does, when the
    pieces before have been handed on.
    """
    due = PIECE_BITS
    try:
        for _ in visual_stream(writer, iter(items)):
            if writer.tell() >= due:
                yield writer.take()
                due = writer.tell() + PIECE_BITS
    except (Exception, KeyboardInterrupt):
        yield writer.take()
        raise
    yield writer.sink.getvalue()


def write_faulty(
    items: Iterable[StreamItem],
    mutations: list[Mutation],
    *,
    readings: Readings = DEFAULT_READINGS,
    profile: EntropyProfile | None = None,
) -> bytes:
    """The bytes of a stream with mutations, whose spans are recorded in them. Rules: CNF-6."""
    io = FaultyWriter(mutations, readings=readings, profile=profile)
    try:
        write_stream(items, io)
    except Exception as error:
        if not was_cut(error):
            raise
    return io.sink.getvalue()


@dataclass(frozen=True, slots=True)
class TracePart:
    """The rows of one item header or one plane.

    Rules: CNF-17, CNF-21. `error`: the fault that ended the stream, in the last part only.
    """

    item: StreamItem | None
    plane: AnyPlane | None
    trace: Trace
    findings: tuple[Finding, ...]
    error: SnhcError | None = None


def trace_stream(
    source: Source | bytes, options: Options = DEFAULT_OPTIONS, *, symbols: bool = True, shares: bool = False
) -> Iterator[TracePart]:
    """The trace of a whole stream, part by part; a fault ends it and stands in the last part.

    Rules: CNF-17, CNF-21. Memory does not grow with the stream. `symbols`, `shares`: as in `Tracer`.
    """
    findings: list[Finding] = []
    io = Tracer(
        BitCursor(_source(source)),
        limits=options.limits,
        readings=options.readings,
        draft=options.draft,
        strict=options.strict,
        on_finding=findings.append,
        profile=options.profile,
        symbols=symbols,
        shares=shares,
    )
    item: StreamItem | None = None
    plane: AnyPlane | None = None
    try:
        for item, plane in visual_stream(io, fresh_items()):
            yield TracePart(item, plane, io.take(), tuple(findings))
            findings.clear()
    except SnhcError as error:
        yield TracePart(item, None, io.take(), tuple(findings), error)
        return
    if len(io.trace) or findings:
        yield TracePart(item, None, io.take(), tuple(findings))
