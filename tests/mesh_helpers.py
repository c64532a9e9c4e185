"""What the tests of mesh streams share: records compared, decoder against tracer, where nodes stand in the bits."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from fba_helpers import check_error, fields_of, key
from unit.mesh_second_parser import TABLES, _words

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.mesh.motion import VectorCode
from snhc.reference_impl.mesh.records import MeshFrame, MeshGeometry, MeshMotion, MeshObject, MeshPlane
from snhc.reference_impl.syntax.temporal import TemporalHeader
from snhc.reference_impl.systems.stream import (
    DEFAULT_OPTIONS,
    Options,
    decode_frames,
    read_stream,
    trace_stream,
    write_stream,
)
from snhc.reference_impl.systems.visual import StreamItem, VisualObjectHeader

RECORDS = (
    StreamItem, MeshObject, MeshPlane, MeshGeometry, MeshMotion, TemporalHeader, VectorCode, VisualObjectHeader,
)  # fmt: skip
DERIVED = {"start", "end", "frames"}

EX1 = bytes.fromhex("000001bc000001bdc20180514109000001bd461181508828603a0c000001b1")
EX2 = bytes.fromhex("000001bc000001bdc4000d0160008003de43a9d772fbdc6e5f5b96000001bd48a8c420382500f0143f000001b1")

assert TABLES.is_dir()


def plain(value: object) -> object:
    """A record as nested dicts and lists without what reading derives, for comparison."""
    if isinstance(value, RECORDS):
        return {name: plain(getattr(value, name)) for name in fields_of(value) if name not in DERIVED}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return value


def decoded(data: Any, options: Options = DEFAULT_OPTIONS) -> tuple[list[MeshFrame], list[Finding], SnhcError | None]:
    """(frames, findings, error or None) of the first object as the decoder sees them."""
    frames: list[MeshFrame] = []
    findings: list[Finding] = []
    try:
        for frame in decode_frames(data, options, findings.append):
            assert isinstance(frame, MeshFrame)
            frames.append(frame)
    except SnhcError as error:
        return frames, findings, error
    return frames, findings, None


def traced(data: Any, options: Options = DEFAULT_OPTIONS) -> tuple[list[MeshFrame], list[Finding], SnhcError | None]:
    """The same as the tracer sees them, which must also partition what it has read."""
    frames: list[MeshFrame] = []
    findings: list[Finding] = []
    error = None
    first = None
    at = 0
    for part in trace_stream(data, options):
        findings += part.findings
        if first is None and part.item is not None and part.item.mesh is not None:
            first = part.item
        if isinstance(part.plane, MeshPlane) and part.item is first:
            frames += part.plane.frames
        for element, start, end, _, path in part.trace.rows():
            assert start == at, f"{path}.{element.name} begins at {start}, the row before ended at {at}"
            assert end > start or element.name == "user_data"
            at = end
        error = part.error
    if error is None:
        assert at == 8 * len(data)
    return frames, findings, error


def check_mesh_input(data: bytes, options: Options = DEFAULT_OPTIONS) -> SnhcError | None:
    """The law of any input: a decode that writes back to the same bytes, or one located fault; tracer = decoder."""
    frames, findings, error = decoded(data, options)
    frames_traced, findings_traced, error_traced = traced(data, options)
    for fault in (error, error_traced):
        if fault is not None:
            check_error(fault, 8 * len(data))
    assert frames == frames_traced
    # The decoder stops behind the first object and says so; the tracer walks on.
    others = any(finding.id == "trailing-data" for finding in findings)
    if not others and not (error is not None and error.rule == "FBA-44"):
        assert key(error) == key(error_traced)
        assert findings == findings_traced
    if error_traced is None:
        assert write_stream(read_stream(data, options)) == data
    return error


def with_bits(data: bytes, start: int, word: str) -> bytes:
    """The data with other bits from bit `start` on."""
    bits = bytearray(f"{int.from_bytes(data, 'big'):0{8 * len(data)}b}", "ascii")
    bits[start : start + len(word)] = word.encode()
    return int(bits, 2).to_bytes(len(data), "big")


def cut_bits(data: bytes, count: int) -> bytes:
    """The first `count` bits, then zero bits to the byte boundary."""
    whole = data[: (count + 7) // 8]
    spare = 8 * len(whole) - count
    return (int.from_bytes(whole, "big") >> spare << spare).to_bytes(len(whole), "big")


def node_spans(nodes: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Where the nodes of a Delaunay geometry stand in a stream that begins with it and has no temporal fields."""
    lengths = {value: len(code) for code, value in _words("mesh_delta_len.csv", "delta_len").items()}
    # 2 start codes, 5 flags, type, N, marker, Nb, marker.
    at = 64 + 5 + 2 + 16 + 1 + 10 + 1
    spans = [(at, at + 27)]
    at += 28
    for (x0, y0), (x1, y1) in pairwise(nodes):
        sizes = [abs(d).bit_length() for d in (x1 - x0, y1 - y0)]
        width = sum(lengths[size] + size for size in sizes)
        spans.append((at, at + width))
        at += width
    return spans
