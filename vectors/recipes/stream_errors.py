"""Whole streams with one fault each, streams at the limits, and streams of several sequences."""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import (
    ForbiddenValue,
    InconsistentSemantics,
    RangeViolation,
    ReservedValue,
    ResourceLimit,
    Truncated,
)
from snhc.reference_impl.syntax.base import STUFFED_CODE
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.stream import write_faulty, write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import all_lists, empty, end_code, face_object, inter, intra, sequence, stream, user_data, visual_object
from ..manifest import CONCEAL, REJECT, DecodeOptions
from ..mesh_builders import Point, delaunay, mesh_object, mesh_stream, moved, still, uniform
from ..recipe import Accept, Reject, family, vector

_MESH: Final = ("mesh",)
_NODES: Final[list[Point]] = [(0, 0), (61, -7), (83, 40), (41, 73), (-13, 50), (33, 30)]


@family(
    {
        "end code": "000001b1", "user data": "000001b2414243000001ba", "face plane": "000001bb8000000001b1",
        "mesh plane": "000001bd8000000001b1",
    },
    id="fba.error.no-object-before.{case}",
    title="The stream begins with: {case}",
    tier="error",
    rules=["FBA-1"],
    features=["start-codes"],
)  # fmt: skip
def no_object(text: str) -> Reject:
    """A known start code that cannot be the first: {case}. What it belongs to is not there."""
    return Reject(bytes.fromhex(text), InconsistentSemantics, "FBA-1", bits=(0, 32))


@vector(
    id="fba.error.object-number",
    title="The third object of a stream that has one",
    tier="error",
    rules=["FBA-44"],
    features=["objects"],
    options=DecodeOptions(object_number=2),
)
def object_number() -> Reject:
    """A decoder that is asked for an object that is not there says so; the fault lies over all data."""
    data = write_stream(stream(intra({3: 5})))
    return Reject(data, InconsistentSemantics, "FBA-44", bits=(0, 8 * len(data)))


@vector(
    id="fba.sequence.second-without-end-code",
    title="A second sequence without an end code before it",
    tier="syntax",
    rules=["FBA-44", "SYS-1", "SYS-2"],
    features=["objects", "sequence-header"],
    options=DecodeOptions(object_number=1),
)
def second_sequence() -> Accept:
    """Two sequences with a face object each; the first does not end, and the second object is asked for."""
    items: list[StreamItem] = []
    for level in (5, 7):
        items += [sequence(0x61), visual_object(), face_object([intra({3: level})], end=STUFFED_CODE)]
    return Accept([*items, end_code()], values={(0, 3): 28}, findings=("no-end-code",))


@vector(
    id="sys.bare.face-object",
    title="A stream that begins with the face object",
    tier="syntax",
    rules=["SYS-7"],
    features=["sequence-header"],
)
def bare() -> Accept:
    """No sequence and no visual object around it: face streams may stand alone, their profile is then unknown."""
    return Accept(stream(intra({3: 5})), values={(0, 3): 20}, findings=())


@family(
    {
        "behind the sequence header": ("000001b061", "SYS-2", (40, 40)),
        "within a start code": ("000001b0610000", "SYS-2", (40, 56)),
        "behind the visual object": ("000001b061000001b523", "SYS-6", (80, 80)),
        "within the object start code": ("000001b061000001b523000001", "SYS-6", (80, 104)),
        "in user data": ("000001b061000001b2414243", "SYS-5", (40, 96)),
    },
    id="sys.error.ends.{case}",
    title="The data ends {case}",
    tier="error",
    rules=["CNF-21"],
    features=["truncated", "sequence-header"],
)
def ends_early(case: tuple[str, str, tuple[int, int]]) -> Reject:
    """An object has to come, and the data ends {case}."""
    text, rule, bits = case
    return Reject(bytes.fromhex(text), Truncated, rule, bits=bits)


# -- limits ------------------------------------------------------------------------------------------------------------


def _with_user_data(size: int) -> list[StreamItem]:
    return [sequence(0x61), user_data(b"u" * size), visual_object(), face_object([intra({3: 5})]), end_code()]


@vector(
    id="sys.error.limit.user-data",
    title="More user data than the limit allows",
    tier="error",
    rules=["SYS-5", "CNF-22"],
    features=["user-data", "limits"],
    value_classes=["above-limit"],
    options=DecodeOptions(limits={"user_data_bytes": 8}),
)
def too_much_user_data() -> Reject:
    """Nine bytes where eight are allowed: the fault lies over the whole element, its start code too."""
    return Reject(_with_user_data(9), ResourceLimit, "CNF-22", bits=(40, 40 + 32 + 72), allowed=(REJECT, CONCEAL))


@vector(
    id="sys.limit.user-data.reached",
    title="As much user data as the limit allows",
    tier="stress",
    rules=["SYS-5", "CNF-22"],
    features=["user-data", "limits"],
    options=DecodeOptions(limits={"user_data_bytes": 8}),
)
def enough_user_data() -> Accept:
    """Eight bytes, and that many are allowed."""
    return Accept(_with_user_data(8), values={(0, 3): 20})


@vector(
    id="sys.user-data.long",
    title="User data longer than any buffer of one read",
    tier="stress",
    rules=["SYS-5"],
    features=["user-data"],
)
def long_user_data() -> Accept:
    """70,000 bytes, in which zeros stand and no start code: two zero bytes, and a 1 behind one of them."""
    content = (b"\0\0\2" + b"\0\1" + b"text ") * 7_000
    items = [sequence(0x61), user_data(content), visual_object(), face_object([intra({3: 5})]), end_code()]
    return Accept(items, values={(0, 3): 20})


def _across(head: list[StreamItem], item: StreamItem, before: int) -> list[StreamItem]:
    """A stream whose 65,536th byte lies `before` bytes behind the beginning of the object."""
    header = visual_object(type=4 if item.fba else 3)
    # The faulty writer does not ask for the object that has to follow.
    size = len(write_faulty([*head, user_data(b""), header], []))
    content = (b"user data. " * 6_000)[: (1 << 16) - size - before]
    return [*head, user_data(content), header, item, end_code()]


@family(
    {"segments": 150, "range lists": 20},
    id="fba.stream.across-64-kib.{case}",
    title="Planes across the 65,536th byte: {case}",
    tier="stress",
    rules=["FBA-26", "SYS-5"],
    features=["user-data", "inter"],
)
def across_segments(before: int) -> Accept:
    """User data moves the planes to where buffers of a power of two end, within {case} or what is looked ahead at."""
    first = intra({3: 5, 48: 100, 61: -7}, ranges=all_lists(9))
    planes = [first, *(inter(first, {3: i % 3 - 1, 48: i % 7 - 3}) for i in range(60))]
    return Accept(_across([sequence(0x61)], face_object(planes), before), lines=61, values={(0, 48): 17000})


@vector(
    id="mesh.stream.across-64-kib",
    title="Mesh planes across the 65,536th byte",
    tier="stress",
    rules=["MSH-41", "SYS-5"],
    features=["user-data", "mesh-motion"],
    tools=_MESH,
)
def across_vectors() -> Accept:
    """As with faces, with motion vectors: code words and fields of all widths lie across the end of a buffer."""
    first = uniform(5, 4, 40, 40, 3)
    planes = [first]
    for step in range(8):
        planes.append(moved(first, {n: (3 * n + step - 9, 40 - 5 * n - step) for n in range(20)}))
    return Accept(_across([sequence(0xFE)], mesh_object(planes), 200), lines=9)


@vector(
    id="mesh.error.limit.user-data",
    title="More user data in a mesh than the limit allows",
    tier="error",
    rules=["MSH-2", "CNF-22"],
    features=["user-data", "limits"],
    value_classes=["above-limit"],
    tools=_MESH,
    options=DecodeOptions(limits={"user_data_bytes": 8}),
)
def too_much_in_a_mesh() -> Reject:
    """Nine bytes behind the first plane where eight are allowed."""
    plane = uniform(2, 2, 4, 4)
    plane.user_data = [b"123456789"]
    data = write_stream(mesh_stream(plane, still()))
    start = 8 * data.index(b"\0\0\1\xb2")
    return Reject(data, ResourceLimit, "CNF-22", bits=(start, start + 32 + 72), allowed=(REJECT, CONCEAL))


@vector(
    id="mesh.error.limit.delaunay",
    title="More nodes of a Delaunay mesh than the limit allows",
    tier="error",
    rules=["CNF-22"],
    features=["mesh-delaunay", "limits"],
    value_classes=["above-limit"],
    tools=_MESH,
    options=DecodeOptions(limits={"mesh_nodes_delaunay": 5}),
)
def too_many_nodes() -> Reject:
    """Six nodes where five are allowed: the fault is the count."""
    items = mesh_stream(delaunay(_NODES, 5))
    mutation = Mutation("nr_of_mesh_nodes", "flip")
    write_faulty(items, [mutation])
    return Reject(write_stream(items), ResourceLimit, "CNF-22", bits=mutation.spans[0])


@vector(
    id="mesh.limit.nodes.reached",
    title="As many nodes as the limits allow",
    tier="stress",
    rules=["CNF-22"],
    features=["mesh-delaunay", "mesh-uniform", "limits"],
    tools=_MESH,
    options=DecodeOptions(limits={"mesh_nodes_delaunay": 6, "mesh_nodes_uniform": 6}),
)
def enough_nodes() -> Accept:
    """A Delaunay mesh and a uniform mesh of six nodes, and that many are allowed."""
    return Accept(mesh_stream(delaunay(_NODES, 5), uniform(3, 2, 20, 16, 1)), lines=2)


@vector(
    id="fba.limit.skipped-frames.reached",
    title="As many skipped frames as the limit allows",
    tier="stress",
    rules=["FBA-8", "CNF-22"],
    features=["skip", "limits"],
    options=DecodeOptions(limits={"skipped_frames": 50}),
)
def enough_skipped() -> Accept:
    """50 frames are skipped, and that many are allowed: 51 periods of 1/30 second."""
    return Accept(stream(intra({3: 1}, skip=50), intra({3: 1})), times={1: "17/10"})


@vector(
    id="fba.limit.idle-planes.reached",
    title="As many planes without data as the limit allows",
    tier="stress",
    rules=["FBA-42", "CNF-22"],
    features=["plane-without-data", "limits"],
    options=DecodeOptions(limits={"idle_planes": 3}),
)
def enough_idle() -> Accept:
    """Three planes without data in a row, and that many are allowed; a plane with data begins the count anew."""
    idle = [empty(is_intra=1) for _ in range(6)]
    return Accept(stream(intra({3: 1}), *idle[:3], intra({3: 1}), *idle[3:], intra({3: 2})), lines=9)


# -- meshes ------------------------------------------------------------------------------------------------------------


@family(
    {
        "rows 0": ("nr_of_mesh_nodes_vert", 0, "MSH-32"),
        "boundary nodes 0": ("nr_of_boundary_nodes", 0, "MSH-38"),
    },
    id="mesh.error.count.{case}",
    title="Mesh with {case}",
    tier="error",
    rules=["MSH-11"],
    features=["mesh-uniform", "mesh-delaunay"],
    value_classes=["zero"],
    tools=_MESH,
)
def no_nodes(case: tuple[str, int, str]) -> Reject:
    """A count that makes no mesh: {case}."""
    element, value, rule = case
    items = mesh_stream(uniform(3, 2, 20, 16) if rule == "MSH-32" else delaunay(_NODES, 5))
    return Reject(items, RangeViolation, rule, (Mutation(element, "wire", value),))


@vector(
    id="mesh.error.word.delta-y-length",
    title="A word that is no length: delta_y_len_vlc",
    tier="error",
    rules=["MSH-5"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def no_length() -> Reject:
    """1111111110 at the length of a y step. The longest word has nine bits: so many are looked at."""
    items = mesh_stream(delaunay(_NODES, 5))
    mutation = Mutation("delta_y_len_vlc", "word", 0b1111111110, width=10)
    write_faulty(items, [mutation])
    start = mutation.spans[0][0]
    broken = (Mutation("delta_y_len_vlc", "word", 0b1111111110, width=10),)
    return Reject(items, ReservedValue, "MSH-5", broken, (start, start + 9))


@family(
    {"end code": "000001b1", "face object": "000001ba", "unknown code": "000001dd"},
    id="mesh.error.behind-object-code.{case}",
    title="Behind the mesh object start code: {case}",
    tier="error",
    rules=["MSH-25"],
    features=["start-codes"],
    tools=_MESH,
)
def other_code(text: str) -> Reject:
    """A start code directly behind mesh_object_start_code that is not the one of a plane: {case}."""
    data = bytes.fromhex("000001bc" + text)
    return Reject(data, ForbiddenValue, "MSH-25", bits=(32, 64))


@vector(
    id="mesh.object.empty.end",
    title="A mesh object and the end of the data",
    tier="syntax",
    rules=["MSH-1", "MSH-25"],
    features=["empty-object"],
    tools=_MESH,
)
def empty_mesh() -> Accept:
    """mesh_object_start_code alone: no lines, and no fault."""
    return Accept([mesh_object([])], lines=0)


@vector(
    id="mesh.motion.same-geometry-again",
    title="The same geometry twice",
    tier="semantic",
    rules=["MSH-4", "MSH-31", "MSH-36"],
    features=["mesh-uniform", "mesh-motion"],
    tools=_MESH,
)
def same_again() -> Accept:
    """A uniform mesh, motion, and the same uniform mesh again: the nodes go back to their grid."""
    first = uniform(3, 2, 20, 16, 1)
    again = uniform(3, 2, 20, 16, 1)
    planes = [first, moved(first, {1: (3, -2)}), again, moved(again, {4: (1, 1)})]
    return Accept(mesh_stream(*planes), lines=4)


@vector(
    id="mesh.delaunay.two-obtuse-angles",
    title="Thin triangles: both opposite angles are obtuse",
    tier="semantic",
    rules=["MSH-8"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def obtuse() -> Accept:
    """Two of the three interior nodes lie side by side: an edge between them has two obtuse angles opposite to it.

    A test that takes the sum of the cosines alone, or only one of the angles, keeps the wrong diagonal.
    """
    nodes = [
        (3, 67), (0, 59), (-14, 13), (-67, 15), (4, -37), (7, -57), (23, -16), (20, -26), (42, -13),
        (0, 3), (1, 0), (1, 9),
    ]  # fmt: skip
    return Accept(mesh_stream(delaunay(nodes, 9)), lines=1)


def _steps() -> list[Point]:
    """Interior nodes whose steps have the largest and smallest code of every length 1..11, in x and in y."""
    ends = [sign * ((1 << length) - 1) for length in range(1, 12) for sign in (1, -1)]
    # The last ones, so that the steps do not lead back to where they began.
    x_steps, y_steps = [*ends, 5], [*ends[7:], *ends[:7], 9]
    nodes: list[Point] = [(0, 0)]
    while x_steps:
        x, y = nodes[-1]
        free = [(dx, dy) for dx in x_steps for dy in y_steps if (x + dx, y + dy) not in nodes]
        # Back towards the middle, so that all nodes stay inside.
        dx, dy = next((step for step in free if step[0] * x <= 0 and step[1] * y <= 0), free[0])
        x_steps.remove(dx)
        y_steps.remove(dy)
        nodes.append((x + dx, y + dy))
    return nodes[1:]


@family(
    {"lowest": -4096, "highest": 4095},
    id="mesh.delaunay.step-codes.node0-y-{case}",
    title="Steps with the ends of every length, node0_y {case}",
    tier="stress",
    rules=["MSH-5", "MSH-39"],
    features=["mesh-delaunay"],
    value_classes=["max", "min", "every-length"],
    tools=_MESH,
)
def step_codes(y0: int) -> Accept:
    """A polygon that begins at the {case} node0_y, and inside it nodes at steps of 2^n - 1 and 1 - 2^n for n = 1..11.

    These are the codes with all bits 1 and all bits 0 of each length, in x and in y.
    """
    sign = 1 if y0 > 0 else -1
    # A wide polygon, walked in steps that the eleven bits hold, to end near the first interior node.
    corners = [
        (-4096, 4095), (-2050, 4090), (-7, 4085), (2030, 4078), (4070, 4071), (4066, 2031), (4061, 3), (4054, -2040),
        (4049, -4083), (2011, -4079), (-30, -4073), (-2071, -4066), (-4111, -4060), (-4106, -2021), (-4099, 20),
        (-4091, 2061),
    ]  # fmt: skip
    boundary = [(-4096, y0), *((x, sign * y) for x, y in corners[1:])]
    towards = [(-2051, sign * 1021), (-11, sign * 13)]
    inside = [(x - 11, y + sign * 13) for x, y in _steps()]
    return Accept(mesh_stream(delaunay([*boundary, *towards, *inside], len(boundary))), lines=1)
