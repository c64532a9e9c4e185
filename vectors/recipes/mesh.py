"""2D mesh objects: uniform and Delaunay geometry, motion, planes without data, what stands between planes."""

from __future__ import annotations

from collections.abc import Sequence

from snhc.reference_impl.mesh.motion import motion_range
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.stream import write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import end_code, sequence, visual_object
from ..mesh_builders import (
    Point,
    coded,
    delaunay,
    mesh_object,
    mesh_stream,
    mesh_timed,
    moved,
    still,
    topology_of,
    uniform,
)
from ..recipe import Accept, Ambiguous, family, vector
from ..seeded import Seeded

_MESH = ("mesh",)


def _without_ties(nodes: Sequence[Point], boundary_count: int | None = None) -> MeshPlane:
    """A Delaunay geometry that has one triangulation only: vectors of kind valid hold no other."""
    plane = delaunay(nodes, boundary_count)
    other = Readings({"AMB-MSH-2": "other"})
    if sorted(topology_of(plane).triangles) != sorted(topology_of(plane, other).triangles):
        raise TypeError("co-circular nodes in a vector without ambiguity")
    return plane


def _count(plane: MeshPlane) -> int:
    return len(topology_of(plane).order)


def _all_moved(geometry: MeshPlane, seed: int, reach: int, range_code: int | None = None) -> MeshPlane:
    """Every node moves, each in its own way."""
    numbers = Seeded(seed)
    vectors = {
        node: (numbers.between(-reach, reach), numbers.between(-reach, reach)) for node in range(_count(geometry))
    }
    return moved(geometry, vectors, range_code)


def _lines(frames: Sequence[Sequence[Point]]) -> dict[int, str]:
    """The nodes of some lines, as NDJSON has them."""
    return {k: '"nodes":[' + ",".join(f"[{x},{y}]" for x, y in nodes) + "]" for k, nodes in enumerate(frames) if nodes}


# -- the worked examples -----------------------------------------------------------------------------------------------


@vector(
    id="mesh.example.1",
    title="MSH-EX-1: a uniform mesh and a motion plane",
    tier="syntax",
    rules=["MSH-1", "MSH-2", "MSH-6", "MSH-7", "MSH-12", "MSH-13", "MSH-14", "MSH-15", "MSH-18", "MSH-21"],
    features=["mesh-uniform", "mesh-motion"],
    tools=_MESH,
)
def example_1() -> Accept:
    """The worked example of the specification: 3 x 2 nodes, alternating split, two zero vectors."""
    first = uniform(3, 2, 20, 16, 2)
    motion = moved(first, {1: (3, -2), 4: (-7, 5), 2: (3, -1), 5: (-16, 9)})
    return Accept(
        mesh_stream(first, motion),
        same_as=bytes.fromhex("000001bc000001bdc20180514109000001bd461181508828603a0c000001b1"),
        text={0: '"triangles":[[0,1,4],[0,4,3],[1,2,4],[2,5,4]],"order":[0,1,4,3,2,5]'},
        findings=(),
    )


@vector(
    id="mesh.example.2",
    title="MSH-EX-2: a Delaunay mesh and a motion plane",
    tier="syntax",
    rules=["MSH-5", "MSH-8", "MSH-12", "MSH-13", "MSH-15", "MSH-18", "MSH-19", "MSH-20", "MSH-21"],
    features=["mesh-delaunay", "mesh-motion"],
    tools=_MESH,
)
def example_2() -> Accept:
    """The worked example of the specification: five boundary nodes and one inside."""
    first = _without_ties([(0, 0), (60, -6), (80, 40), (40, 70), (-10, 50), (35, 30)], 5)
    codes = [(1, 1, 1, 0), (0, 0, 0, 0), (2, 0, 2, 0), (-4, 0, -6, 0), None, (-21, 0, 18, 0)]
    return Accept(
        mesh_stream(first, coded(2, codes)),
        same_as=bytes.fromhex(
            "000001bc000001bdc4000d0160008003de43a9d772fbdc6e5f5b96000001bd48a8c420382500f0143f000001b1"
        ),
        text={0: '"triangles":[[0,1,5],[0,5,4],[1,2,5],[3,4,5],[2,3,5]],"order":[0,1,5,4,2,3]'},
        findings=(),
    )


# -- uniform meshes ----------------------------------------------------------------------------------------------------


@family(
    {"00": 0, "01": 1},
    id="mesh.uniform.split.{case}",
    title="triangle_split_code {case}",
    tier="semantic",
    rules=["MSH-7", "MSH-36", "MSH-20"],
    features=["mesh-uniform", "mesh-motion"],
    value_classes=["split-code"],
    tools=_MESH,
)
def split(code: int) -> Accept:
    """All cells split one way ({case}), then every node moves: one wrong diagonal changes the order of the vectors."""
    first = uniform(4, 3, 10, 12, code)
    return Accept(mesh_stream(first, _all_moved(first, code, 30)), lines=2)


@family(
    {"10": 2, "11": 3},
    id="mesh.uniform.split.{case}",
    title="triangle_split_code {case}, one row of cells",
    tier="semantic",
    rules=["MSH-7", "MSH-36", "MSH-20"],
    features=["mesh-uniform", "mesh-motion"],
    value_classes=["split-code"],
    tools=_MESH,
    notes="By the parity of the row alone all cells of one row would be alike: that reading is refused here.",
)
def split_in_turn(code: int) -> Accept:
    """The split alternates from cell to cell in one row ({case}); then every node moves."""
    first = uniform(5, 2, 10, 12, code)
    return Accept(mesh_stream(first, _all_moved(first, code, 30)), lines=2)


@family(
    {
        "smallest": (2, 2, 1, 1), "one row": (40, 2, 255, 1), "one column": (2, 40, 1, 255),
        "wide": (1023, 2, 255, 255), "tall": (2, 1023, 3, 255), "square": (32, 32, 16, 16),
    },
    id="mesh.uniform.size.{case}",
    title="Uniform mesh, {case}",
    tier="syntax",
    rules=["MSH-6", "MSH-31", "MSH-32", "MSH-34", "MSH-35"],
    features=["mesh-uniform"],
    value_classes=["min", "max"],
    tools=_MESH,
)  # fmt: skip
def size(case: tuple[int, int, int, int]) -> Accept:
    """Nodes are numbered row by row from the top-left, which is the origin; sizes are in half pixels ({case})."""
    hor, vert, width, height = case
    last = f"[{(hor - 1) * width},{(vert - 1) * height}]]"
    return Accept(mesh_stream(uniform(hor, vert, width, height)), text={0: last}, findings=())


@vector(
    id="mesh.uniform.rows-not-columns",
    title="Three columns and two rows are not two and three",
    tier="syntax",
    rules=["MSH-31", "MSH-32", "MSH-34", "MSH-35"],
    features=["mesh-uniform"],
    tools=_MESH,
)
def rows_not_columns() -> Accept:
    """All four numbers differ. Decoders swap columns and rows, or cells and nodes."""
    nodes = [(0, 0), (5, 0), (10, 0), (0, 7), (5, 7), (10, 7)]
    return Accept(mesh_stream(uniform(3, 2, 5, 7)), text=_lines([nodes]))


# -- Delaunay meshes ---------------------------------------------------------------------------------------------------

_PENTAGON = [(0, 0), (61, -7), (83, 40), (41, 73), (-13, 50)]


@vector(
    id="mesh.delaunay.triangle",
    title="The smallest Delaunay mesh",
    tier="syntax",
    rules=["MSH-8", "MSH-37", "MSH-38"],
    features=["mesh-delaunay"],
    value_classes=["min"],
    tools=_MESH,
)
def triangle() -> Accept:
    """Three nodes, all on the boundary; node 0 has negative coordinates."""
    nodes = [(-4096, -1), (-4090, 3), (-4093, 9)]
    return Accept(mesh_stream(_without_ties(nodes)), text={0: '"triangles":[[0,1,2]],"order":[0,1,2]'})


@family(
    {"clockwise": False, "counter-clockwise": True},
    id="mesh.delaunay.orientation.{case}",
    title="Boundary nodes run {case}",
    tier="semantic",
    rules=["MSH-10", "MSH-19", "MSH-20"],
    features=["mesh-delaunay", "mesh-motion"],
    tools=_MESH,
)
def orientation(reverse: bool) -> Accept:
    """The same outline in both directions: triangles and traversal are clockwise on screen in both."""
    ring = list(reversed(_PENTAGON)) if reverse else _PENTAGON
    first = _without_ties([*ring, (33, 30), (12, 41)], 5)
    return Accept(mesh_stream(first, _all_moved(first, 5, 20)), lines=2)


@family(
    {"0": 0, "1": 1, "2": 2, "3": 4, "5": 16, "8": 128, "10": 512, "11": 1024},
    id="mesh.delaunay.delta-length.{case}",
    title="Differences of {case} bits",
    tier="syntax",
    rules=["MSH-5"],
    features=["mesh-delaunay"],
    value_classes=["delta-length"],
    tools=_MESH,
)
def delta_length(low: int) -> Accept:
    """Differences with {case} bits, of both signs and at both ends of the class, among others of 2 and of 10 bits.

    The code of a negative number is one's complement: decoders read two's complement.
    """
    high = max(2 * low - 1, 0)
    left = low - high - 800
    nodes = [(0, 0), (low, 600), (low - high, 1200), (left, 1203), (left - low, 620), (left - low + high, 5)]
    return Accept(mesh_stream(_without_ties(nodes)), text=_lines([nodes]))


@vector(
    id="mesh.delaunay.concave",
    title="A concave outline",
    tier="semantic",
    rules=["MSH-8"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def concave() -> Accept:
    """A comb: an unconstrained triangulation, or the convex hull, would bridge the gaps."""
    teeth = [(0, 0), (14, 61), (27, 3), (41, 64), (55, 1), (69, 60), (83, 7), (85, 90), (-3, 93)]
    first = _without_ties([*teeth, (42, 79)], 9)
    return Accept(mesh_stream(first, _all_moved(first, 11, 3)), lines=2, findings=())


@vector(
    id="mesh.delaunay.constrained-edge",
    title="A boundary edge that is no Delaunay edge",
    tier="semantic",
    rules=["MSH-8"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def constrained_edge() -> Accept:
    """Interior nodes close to a long boundary edge: flipping that edge would be Delaunay, and is not allowed."""
    first = _without_ties([(0, 0), (200, 0), (203, 100), (-1, 97), (60, 3), (101, 2), (143, 5)], 4)
    return Accept(mesh_stream(first, _all_moved(first, 12, 2)), lines=2, findings=())


@vector(
    id="mesh.delaunay.straight-nodes",
    title="Boundary nodes of 180 degrees",
    tier="semantic",
    rules=["MSH-8", "MSH-11"],
    features=["mesh-delaunay"],
    tools=_MESH,
)
def straight_nodes() -> Accept:
    """Three boundary nodes on a line are legal, and no triangle is made of them."""
    nodes = [(0, 0), (10, 0), (37, 0), (90, 0), (97, 53), (61, 70), (3, 70), (-2, 31)]
    first = _without_ties(nodes)
    return Accept(mesh_stream(first, _all_moved(first, 13, 1)), lines=2)


@family(
    {"one inside": 1, "one outside": -1},
    id="mesh.delaunay.diagonal.{case}",
    title="A diagonal that half a pixel decides, {case}",
    tier="stress",
    rules=["MSH-8", "MSH-15", "MSH-20", "MSH-21"],
    features=["mesh-delaunay", "mesh-motion"],
    tools=_MESH,
)
def diagonal(step: int) -> Accept:
    """Four nodes of which three lie on a circle and the fourth half a pixel off it ({case}); in-circle tests in
    floating point, or by an angle that is rounded, choose the other diagonal.

    All vectors differ, so that a decoder with the other diagonal reads other predictions, or other nodes.
    """
    # 1105^2 = 1104^2 + 47^2 = 943^2 + 576^2.
    first = _without_ties([(1105, 0), (47, 1104), (-943, 576), (-576 + step, -943)])
    vectors = {0: (31, -17), 1: (-29, 23), 2: (5, 60), 3: (-50, -41)}
    motion = moved(first, vectors)
    assert first.geometry is not None
    ends = [
        (x + vectors[k][0], y + vectors[k][1])
        for k, (x, y) in enumerate(zip(first.geometry.xs, first.geometry.ys, strict=True))
    ]
    shared = "[0,1,3],[1,2,3]" if step > 0 else "[0,2,3],[0,1,2]"
    return Accept(mesh_stream(first, motion), text={1: _lines([ends])[0], 0: shared}, findings=())


@vector(
    id="mesh.delaunay.many-nodes",
    title="A thousand nodes anywhere",
    tier="stress",
    rules=["MSH-5", "MSH-8", "MSH-15", "MSH-20", "MSH-21"],
    features=["mesh-delaunay", "mesh-motion"],
    tools=_MESH,
    seed=7,
)
def many_nodes() -> Accept:
    """996 interior nodes in no order; each of them moves, twice."""
    numbers = Seeded(7)
    inner: dict[Point, None] = {}
    while len(inner) < 996:
        inner[(numbers.between(-998, 997), numbers.between(-996, 995))] = None
    first = _without_ties([(-1000, -1000), (1001, -998), (999, 1003), (-1003, 997), *inner], 4)
    return Accept(mesh_stream(first, _all_moved(first, 8, 15), _all_moved(first, 9, 500)), lines=3)


@vector(
    id="mesh.delaunay.second-geometry",
    title="A second intra plane replaces the mesh",
    tier="semantic",
    rules=["MSH-2", "MSH-16", "MSH-21"],
    features=["mesh-uniform", "mesh-delaunay", "mesh-motion"],
    tools=_MESH,
)
def second_geometry() -> Accept:
    """Uniform, motion, Delaunay with another number of nodes, motion: nothing of the first mesh is left."""
    first = uniform(3, 3, 20, 20, 1)
    second = _without_ties([*_PENTAGON, (33, 30)], 5)
    return Accept(mesh_stream(first, _all_moved(first, 1, 9), second, _all_moved(second, 2, 9)), lines=4)


# -- motion ------------------------------------------------------------------------------------------------------------


@family(
    {str(code): code for code in range(1, 8)},
    id="mesh.motion.range.{case}",
    title="motion_range_code {case}",
    tier="syntax",
    rules=["MSH-12", "MSH-13", "MSH-40", "MSH-41"],
    features=["mesh-motion"],
    value_classes=["min", "max"],
    tools=_MESH,
)
def motion_range_code(code: int) -> Accept:
    """Both ends of the range, where differences wrap around, and residuals of {case} - 1 bits."""
    limit = motion_range(code)
    first = uniform(3, 2, 255, 255, 0)
    ends = {
        0: (limit - 1, -limit), 1: (-limit, limit - 1), 4: (limit - 1, 0), 3: (1, -limit), 2: (-1, 1),
        5: (limit // 2, 3 - limit // 3),
    }  # fmt: skip
    assert first.geometry is not None
    nodes = [(0, 0), (255, 0), (510, 0), (0, 255), (255, 255), (510, 255)]
    after = [(x + ends[k][0], y + ends[k][1]) for k, (x, y) in enumerate(nodes)]
    return Accept(mesh_stream(first, moved(first, ends, code)), text={1: _lines([after])[0]})


@vector(
    id="mesh.motion.range.too-wide",
    title="A range wider than the vectors need",
    tier="semantic",
    rules=["MSH-12", "MSH-40"],
    features=["mesh-motion"],
    tools=_MESH,
)
def too_wide() -> Accept:
    """motion_range_code 7 for vectors of one half pixel: residuals of six bits, codes of 1 and -1."""
    first = uniform(2, 2, 8, 8)
    return Accept(mesh_stream(first, moved(first, {0: (1, -1), 1: (-1, 1), 3: (1, 1)}, 7)), findings=())


@vector(
    id="mesh.motion.all-zero",
    title="Zero flags only",
    tier="syntax",
    rules=["MSH-14", "MSH-41"],
    features=["mesh-motion"],
    value_classes=["zero"],
    tools=_MESH,
)
def all_zero() -> Accept:
    """Every node has the zero flag: one bit per node, and the mesh stays."""
    first = uniform(3, 3, 6, 6, 3)
    return Accept(mesh_stream(first, moved(first, {}), moved(first, {8: (1, 1)})), lines=3)


@vector(
    id="mesh.motion.zero-flag-is-no-prediction",
    title="The zero flag is the zero vector, not the prediction",
    tier="semantic",
    rules=["MSH-14", "MSH-15"],
    features=["mesh-motion"],
    value_classes=["zero"],
    tools=_MESH,
)
def zero_flag() -> Accept:
    """Node 0 moves by (10, -6), the next has the zero flag and stays; it predicts the third with (0, 0).

    The fourth comes without the flag from a prediction and a difference that give (0, 0).
    """
    first = uniform(2, 2, 20, 20)
    # Order 0, 1, 3, 2; node 3 is predicted by 0 and 1: (5, -3); node 2 by 0 and 3: ((10 + 5 + 1) >> 1, ...) = (8, -4).
    codes = [(10, 0, -6, 0), None, (0, 0, 0, 0), (-8, 0, 4, 0)]
    return Accept(
        mesh_stream(first, coded(1, codes)), text=_lines([[], [(10, -6), (20, 0), (0, 20), (25, 17)]]), findings=()
    )


@vector(
    id="mesh.motion.rounding",
    title="The mean of two vectors is rounded up",
    tier="semantic",
    rules=["MSH-15"],
    features=["mesh-motion"],
    value_classes=["negative"],
    tools=_MESH,
)
def rounding() -> Accept:
    """Sums of odd numbers of both signs: (a + b + 1) >> 1, an arithmetic shift. Truncation gives other values."""
    first = uniform(2, 2, 20, 20)
    # Node 3: ((1 + 0 + 1) >> 1, (-1 + 0 + 1) >> 1) = (1, 0); node 2, from 0 and 3: (3 >> 1, 0 >> 1) = (1, 0).
    codes = [(1, 0, -1, 0), (-1, 0, 1, 0), (0, 0, 0, 0), (0, 0, 0, 0)]
    second = [(-3, 0, -2, 0), (0, 0, -1, 0), (0, 0, 0, 0), (0, 0, 0, 0)]
    # n0 (-3, -2), n1 (-3, -3), n3 ((-6 + 1) >> 1, (-5 + 1) >> 1) = (-3, -2), n2 (-3, (-4 + 1) >> 1) = (-3, -2).
    return Accept(
        mesh_stream(first, coded(1, codes), coded(1, second)),
        text=_lines([[], [(1, -1), (20, 0), (1, 20), (21, 20)], [(-2, -3), (17, -3), (-2, 18), (18, 18)]]),
    )


@vector(
    id="mesh.motion.sums-up",
    title="Motion adds up over planes",
    tier="semantic",
    rules=["MSH-16"],
    features=["mesh-motion"],
    tools=_MESH,
)
def sums_up() -> Accept:
    """Vectors are from plane to plane, also over planes without data; far from the picture in the end."""
    first = uniform(2, 2, 20, 20)
    far = moved(first, dict.fromkeys(range(4), (2047, -2048)))
    return Accept(
        mesh_stream(first, far, still(), far, still(1), far),
        text=_lines([[], [], [], [], [], [(6141, -6144), (6161, -6144), (6141, -6124), (6161, -6124)]]),
        findings=(),
    )


@vector(
    id="mesh.motion.foldover",
    title="A triangle flips over, and back",
    tier="semantic",
    rules=["MSH-17"],
    features=["mesh-motion", "foldover"],
    tools=_MESH,
)
def foldover() -> Accept:
    """No error: a finding of the plane. Traversal and prediction stay those of the intra plane."""
    first = _without_ties([(0, 0), (20, 1), (1, 23)])
    return Accept(
        mesh_stream(first, moved(first, {0: (30, 30)}), moved(first, {0: (-30, -30), 1: (3, 3)})),
        findings=("foldover",),
    )


# -- planes, headers, what stands around them --------------------------------------------------------------------------


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
        text={0: '"nodes":[]', 1: '"nodes":[]', **{k: _lines([nodes])[0] for k in (2, 3, 4)}},
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


# -- readings ----------------------------------------------------------------------------------------------------------


@family(
    {"10": 2, "11": 3},
    id="mesh.ambiguous.split.{case}",
    title="How triangle_split_code {case} alternates",
    tier="semantic",
    rules=["MSH-7"],
    features=["mesh-uniform", "mesh-motion"],
    tools=_MESH,
)
def alternation(code: int) -> Ambiguous:
    """Two by two cells with code {case}, and motion that shows the order: a checkerboard, columns, or rows."""
    first = uniform(3, 3, 10, 12, code)
    return Ambiguous(mesh_stream(first, _all_moved(first, code, 20)), "AMB-MSH-1")


@vector(
    id="mesh.ambiguous.ties.square",
    title="Four nodes on a circle",
    tier="semantic",
    rules=["MSH-9"],
    features=["mesh-delaunay", "delaunay-tie"],
    tools=_MESH,
)
def square() -> Ambiguous:
    """A square has two Delaunay triangulations; the one followed is the fan from the lowest node."""
    first = delaunay([(0, 0), (40, 0), (40, 40), (0, 40)])
    return Ambiguous(mesh_stream(first, moved(first, {0: (3, 1), 1: (-2, 5), 2: (7, 7), 3: (-1, -9)})), "AMB-MSH-2")


@vector(
    id="mesh.ambiguous.ties.interior",
    title="Co-circular nodes inside a mesh",
    tier="semantic",
    rules=["MSH-9", "MSH-20"],
    features=["mesh-delaunay", "delaunay-tie"],
    tools=_MESH,
)
def interior_ties() -> Ambiguous:
    """Eight interior nodes on one circle, numbered to and fro: their polygon is the fan from its lowest node."""
    ring = [(25, 0), (-15, 20), (24, 7), (-7, 24), (0, -25), (15, 20), (7, 24), (-24, -7)]
    first = delaunay([(-101, -97), (103, -90), (95, 107), (-93, 99), *ring], 4)
    return Ambiguous(mesh_stream(first, _all_moved(first, 21, 2)), "AMB-MSH-2")
