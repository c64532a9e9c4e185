"""2D mesh objects: motion, and what it leaves of the triangles."""

from __future__ import annotations

from snhc.reference_impl.mesh.motion import motion_range

from ..mesh_builders import (
    coded,
    mesh_stream,
    moved,
    node_lines,
    still,
    uniform,
    without_ties,
)
from ..recipe import Accept, family, vector

_MESH = ("mesh",)


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
    return Accept(mesh_stream(first, moved(first, ends, code)), text={1: node_lines([after])[0]})


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
        mesh_stream(first, coded(1, codes)), text=node_lines([[], [(10, -6), (20, 0), (0, 20), (25, 17)]]), findings=()
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
        text=node_lines([[], [(1, -1), (20, 0), (1, 20), (21, 20)], [(-2, -3), (17, -3), (-2, 18), (18, 18)]]),
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
        text=node_lines([[], [], [], [], [], [(6141, -6144), (6161, -6144), (6141, -6124), (6161, -6124)]]),
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
    first = without_ties([(0, 0), (20, 1), (1, 23)])
    return Accept(
        mesh_stream(first, moved(first, {0: (30, 30)}), moved(first, {0: (-30, -30), 1: (3, 3)})),
        findings=("foldover",),
    )
