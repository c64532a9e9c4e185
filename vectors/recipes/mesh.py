"""2D mesh objects: uniform and Delaunay geometry."""

from __future__ import annotations

from ..mesh_builders import (
    Point,
    all_moved,
    coded,
    delaunay,
    mesh_stream,
    moved,
    node_lines,
    uniform,
    without_ties,
)
from ..recipe import Accept, Ambiguous, family, vector
from ..seeded import Seeded

_MESH = ("mesh",)


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
    first = without_ties([(0, 0), (60, -6), (80, 40), (40, 70), (-10, 50), (35, 30)], 5)
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
    return Accept(mesh_stream(first, all_moved(first, code, 30)), lines=2)


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
    return Accept(mesh_stream(first, all_moved(first, code, 30)), lines=2)


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
    return Accept(mesh_stream(uniform(3, 2, 5, 7)), text=node_lines([nodes]))


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
    return Accept(mesh_stream(without_ties(nodes)), text={0: '"triangles":[[0,1,2]],"order":[0,1,2]'})


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
    first = without_ties([*ring, (33, 30), (12, 41)], 5)
    return Accept(mesh_stream(first, all_moved(first, 5, 20)), lines=2)


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
    return Accept(mesh_stream(without_ties(nodes)), text=node_lines([nodes]))


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
    first = without_ties([*teeth, (42, 79)], 9)
    return Accept(mesh_stream(first, all_moved(first, 11, 3)), lines=2, findings=())


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
    first = without_ties([(0, 0), (200, 0), (203, 100), (-1, 97), (60, 3), (101, 2), (143, 5)], 4)
    return Accept(mesh_stream(first, all_moved(first, 12, 2)), lines=2, findings=())


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
    first = without_ties(nodes)
    return Accept(mesh_stream(first, all_moved(first, 13, 1)), lines=2)


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
    first = without_ties([(1105, 0), (47, 1104), (-943, 576), (-576 + step, -943)])
    vectors = {0: (31, -17), 1: (-29, 23), 2: (5, 60), 3: (-50, -41)}
    motion = moved(first, vectors)
    assert first.geometry is not None
    ends = [
        (x + vectors[k][0], y + vectors[k][1])
        for k, (x, y) in enumerate(zip(first.geometry.xs, first.geometry.ys, strict=True))
    ]
    shared = "[0,1,3],[1,2,3]" if step > 0 else "[0,2,3],[0,1,2]"
    return Accept(mesh_stream(first, motion), text={1: node_lines([ends])[0], 0: shared}, findings=())


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
    first = without_ties([(-1000, -1000), (1001, -998), (999, 1003), (-1003, 997), *inner], 4)
    return Accept(mesh_stream(first, all_moved(first, 8, 15), all_moved(first, 9, 500)), lines=3)


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
    second = without_ties([*_PENTAGON, (33, 30)], 5)
    return Accept(mesh_stream(first, all_moved(first, 1, 9), second, all_moved(second, 2, 9)), lines=4)


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
    return Ambiguous(mesh_stream(first, all_moved(first, code, 20)), "AMB-MSH-1")


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
    return Ambiguous(mesh_stream(first, all_moved(first, 21, 2)), "AMB-MSH-2")
