"""2D mesh objects: planes without data, headers, what stands between planes."""

from __future__ import annotations

from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.systems.stream import write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import end_code, sequence, visual_object
from ..mesh_builders import (
    mesh_object,
    mesh_stream,
    mesh_timed,
    moved,
    node_lines,
    still,
    uniform,
)
from ..recipe import Accept, family, vector
from ..seeded import Seeded

_MESH = ("mesh",)


@vector(
    id="mesh.plane.without-data",
    title="Planes with mesh_mask 0",
    tier="syntax",
    rules=["MSH-3"],
    features=["mesh-plane-without-data"],
    tools=_MESH,
)
def without_data() -> Accept:
    """Intra and inter planes without data, before any geometry (no nodes) and behind it (the mesh stays)."""
    first = uniform(2, 2, 4, 6)
    nodes = [(0, 0), (4, 0), (0, 6), (4, 6)]
    return Accept(
        mesh_stream(still(1), still(), first, still(), still(1)),
        text={0: '"nodes":[]', 1: '"nodes":[]', **{k: node_lines([nodes])[0] for k in (2, 3, 4)}},
        findings=(),
    )


@vector(
    id="mesh.plane.times",
    title="Rates, time codes and skips in mesh planes",
    tier="semantic",
    rules=["MSH-2", "FBA-6", "FBA-7", "FBA-8", "FBA-37", "FBA-38"],
    features=["mesh-motion", "frame-rate", "time-code", "skip"],
    tools=_MESH,
)
def times() -> Accept:
    """The temporal header is that of face planes, also in planes without data."""
    first = mesh_timed(uniform(2, 2, 4, 4), rate=(25, 0, 0), time=(0, 1, 0), skip=4)
    second = mesh_timed(moved(first, {0: (1, 1)}), skip=15)
    third = mesh_timed(still(1), rate=(10, 8, 1))
    return Accept(
        mesh_stream(first, second, third, still()), times={0: "60/1", 1: "301/5", 2: "1521/25", 3: "91403/1500"}
    )


@vector(
    id="mesh.plane.user-data",
    title="User data behind planes",
    tier="syntax",
    rules=["MSH-2", "SYS-5"],
    features=["user-data"],
    tools=_MESH,
)
def user_data() -> Accept:
    """One plane with one piece, one with two (one of them empty), the last one with a piece before the end code."""
    planes = [uniform(2, 2, 4, 4), still(), still(1)]
    planes[0].user_data = [b"snhc"]
    planes[1].user_data = [b"", b"\x00\x00\x02\xb2"]
    planes[2].user_data = [b"\xff" * 40]
    return Accept(mesh_stream(*planes), lines=3, findings=())


@family(
    {f"{bits} bits": bits for bits in range(1, 9)},
    id="mesh.plane.stuffing.{case}",
    title="Stuffing of {case}",
    tier="syntax",
    rules=["MSH-2", "FBA-3"],
    features=["stuffing"],
    tools=_MESH,
)
def stuffing(bits: int) -> Accept:
    """The plane ends so that {case} are left to the byte boundary; eight where it ends on one."""
    first = uniform(2, 2, 4, 4)
    # 5 bits of header and 1 more, then 3 bits of range and one flag or one vector of 13 to 33 bits per node.
    for k in range(200):
        numbers = Seeded(k)
        vectors = {node: (numbers.between(-31, 31), numbers.between(-31, 31)) for node in range(4)}
        plane = moved(first, vectors)
        stream = mesh_stream(first, plane, still())
        if _stuffing_of(stream, plane) == bits:
            return Accept(stream, lines=3)
    raise TypeError(f"no plane leaves {bits} bits")


def _stuffing_of(stream: list[StreamItem], plane: MeshPlane) -> int:
    write_stream(stream)
    return 8 - plane.end % 8


@vector(
    id="mesh.object.stuffed",
    title="A byte 7F behind the object start code",
    tier="syntax",
    rules=["MSH-2"],
    features=["object-stuffing"],
    tools=_MESH,
)
def stuffed() -> Accept:
    """Taken, with a finding."""
    item = mesh_object([uniform(2, 2, 4, 4)], stuffing=1)
    return Accept([item, end_code()], findings=("object-stuffing",))


@vector(
    id="mesh.object.empty",
    title="An object without planes",
    tier="syntax",
    rules=["MSH-1"],
    features=["empty-object"],
    tools=_MESH,
)
def empty_object() -> Accept:
    """A byte 0x7F and another start code directly behind the object's: no plane, no frame; two findings."""
    item = mesh_object([])
    assert item.mesh is not None
    item.mesh.stuffing = 1
    return Accept([item, end_code()], lines=0, findings=("object-stuffing", "empty-object"))


@vector(
    id="mesh.object.zero-padding",
    title="Zero bytes up to the end of the data",
    tier="syntax",
    rules=["MSH-25"],
    features=["zero-padding"],
    tools=_MESH,
)
def zero_padding() -> Accept:
    """Five zero bytes behind the stuffing of the last plane."""
    return Accept([mesh_object([uniform(2, 2, 4, 4)], padding=40)], lines=1, findings=("zero-padding",))


@vector(
    id="mesh.object.no-end-code",
    title="The data ends with the last plane",
    tier="syntax",
    rules=["MSH-2", "MSH-25"],
    features=["stuffing"],
    tools=_MESH,
)
def no_end_code() -> Accept:
    """The last plane has 40 bits behind its start code: it ends on a byte, and needs no stuffing there."""
    last = mesh_timed(still(1), rate=(25, 0, 0), time=(0, 0, 1), skip=0)
    last.stuffing = 0
    return Accept([mesh_object([uniform(2, 2, 4, 4), last])], lines=2, findings=())


@vector(
    id="mesh.object.headers",
    title="Sequence and visual object headers",
    tier="syntax",
    rules=["SYS-2", "SYS-3", "SYS-4", "SYS-6"],
    features=["visual-headers"],
    tools=("mesh", "systems"),
)
def headers() -> Accept:
    """visual_object_type 3 announces a mesh."""
    first = uniform(2, 2, 4, 4)
    items = [sequence(0x61), visual_object(verid=2, priority=1, type=3), *mesh_stream(first, still())]
    return Accept(items, lines=2)
