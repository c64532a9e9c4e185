"""Face animation tables on frames: intervals, several FAPs, visemes and expressions, transforms, readings.

Rules: FAT-1..9, CNF-2, CNF-4.

What is expected is made of + - * / only. Rotations need sine and cosine, which machines round differently: their lines
are declared by the recipes, as numbers, and the reference decoder comes within the tolerance of them. Powers (the
multiplicative reading of AMB-FAT-3) have exponents 0, 1 and 2, which are exact.
"""

from __future__ import annotations

from typing import Final

from ..document_builders import UNITS, JsonTable, compact, deformation, fat, fat_table, frame, moves
from ..recipe import Accept, Ambiguous, family, vector

TOOLS: Final = ("fat",)
Point = tuple[float, float, float]
_ORIGIN: Final[Point] = (0.0, 0.0, 0.0)
_OTHERS: Final[tuple[Point, ...]] = ((1.0, 2.0, 3.0), (-4.0, 0.5, 8.0))
# Table 5 of the paper, FAP 6, vertex 50.
_TABLE_5: Final = moves(6, deformation([-1000, 0, 500, 1000], [(1, 0, 0), (0.9, 0, 0), (1.5, 0, 4)]))
_SELECTED: Final = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def _first(*points: Point) -> dict[tuple[int, str], list[Point]]:
    """Vertex 0 by line; the others stay where they are."""
    return {(i, "M"): [point, *_OTHERS] for i, point in enumerate(points)}


def _unit_table(fap: int, select: int = 1, vector: Point = (1.0, 0.0, 0.0)) -> JsonTable:
    return moves(fap, deformation([0, 100], [vector]), select=select)


@vector(id="fat.interval.example", title="Worked example: Table 5 of the paper", tier="semantic", tools=TOOLS,
        rules=["FAT-2", "FAT-6"])  # fmt: skip
def example() -> Accept:
    """FAP 6 at 600: 500 * (0.9 0 0) + 100 * (1.5 0 4) = (600 0 400)."""
    return Accept(fat(fat_table([_TABLE_5]), frame({6: 600})), points=_first((600.0, 0.0, 400.0)))


@vector(id="fat.ambiguous.sign", title="Worked example, negative twin", tier="semantic", tools=TOOLS,
        rules=["FAT-3", "FAT-6"])  # fmt: skip
def negative() -> Ambiguous:
    """FAP 6 at -500: (500 0 0), as the displacement is the direction moved; or (-500 0 0), if it is a slope."""
    points = {"direction": _first((500.0, 0.0, 0.0)), "slope": _first((-500.0, 0.0, 0.0))}
    return Ambiguous(fat(fat_table([_TABLE_5]), frame({6: -500})), "AMB-FAT-1", points=points)


@vector(id="fat.interval.borders", title="At and past the borders", tier="semantic", tools=TOOLS,
        rules=["FAT-2", "FAT-4"], value_classes=["zero", "above-max"])  # fmt: skip
def borders() -> Accept:
    """Table 5 for 0, 500, 1000, 2000 (the last interval goes on), and for a FAP that is unset."""
    return Accept(
        fat(fat_table([_TABLE_5]), *(frame({6: value}) for value in (0, 500, 1000, 2000)), frame()),
        points=_first(_ORIGIN, (450.0, 0.0, 0.0), (1200.0, 0.0, 2000.0), (2700.0, 0.0, 6000.0), _ORIGIN),
    )


@vector(id="fat.interval.negative-borders", title="Three negative intervals", tier="semantic", tools=TOOLS,
        rules=["FAT-3", "FAT-4"], value_classes=["below-min"])  # fmt: skip
def negative_borders() -> Accept:
    """-250: 50 * 4 + 100 * 2 + 100 * 1 = 500; -400, past the first border: 200 * 4 + 300; 300: nothing."""
    table = moves(6, deformation([-300, -200, -100, 0], [(4, 0, 0), (2, 0, 0), (1, 0, 0)]))
    found = [frame({6: value}) for value in (-250, -400, -100, 300)]
    return Accept(
        fat(fat_table([table]), *found),
        points=_first((500.0, 0.0, 0.0), (1100.0, 0.0, 0.0), (100.0, 0.0, 0.0), _ORIGIN),
    )


@vector(id="fat.interval.one-sided", title="No interval on the negative side", tier="semantic", tools=TOOLS,
        rules=["FAT-4"], value_classes=["below-min"])  # fmt: skip
def one_sided() -> Accept:
    """Borders 0, 100, 200: a negative value moves nothing."""
    table = moves(6, deformation([0, 100, 200], [(1, 0, 0), (2, 0, 0)]))
    return Accept(fat(fat_table([table]), frame({6: -50}), frame({6: 150})), points=_first(_ORIGIN, (200.0, 0.0, 0.0)))


@family(
    {"zero first": (0, 100), "zero last": (-100, 0), "no zero": (10, 20), "zero inside": (-5, 5)},
    id="fat.interval.single.{case}", title="One interval, {case}", tier="semantic", tools=TOOLS, rules=["FAT-5"],
)  # fmt: skip
def single(pair: tuple[int, int]) -> Accept:
    """One interval ({case}) is linear for both signs, wherever its borders are."""
    table = moves(6, deformation(pair, [(0.5, 0.0, -2.0)]))
    found = [frame({6: value}) for value in (300, -300, 15)]
    return Accept(
        fat(fat_table([table]), *found), points=_first((150.0, 0.0, -600.0), (-150.0, 0.0, 600.0), (7.5, 0.0, -30.0))
    )


@vector(id="fat.layout.vectors", title="Vectors by vertex, then by interval", tier="syntax", tools=TOOLS,
        rules=["FAT-1", "FAT-2"])  # fmt: skip
def layout() -> Accept:
    """Two vertices, two intervals: all vectors of vertex 2 stand before those of vertex 0."""
    table = moves(6, deformation([-10, 0, 10], [(0, 1, 0), (0, 2, 0), (0, 3, 0), (0, 4, 0)], index=[2, 0]))
    points = {
        (0, "M"): [(0.0, 20.0, 0.0), (1.0, 2.0, 3.0), (-4.0, 10.5, 8.0)],
        (1, "M"): [(0.0, 15.0, 0.0), (1.0, 2.0, 3.0), (-4.0, 5.5, 8.0)],
    }
    return Accept(fat(fat_table([table]), frame({6: 5}), frame({6: -5})), points=points)


@vector(id="fat.layout.index-twice", title="A vertex that is named twice", tier="syntax", tools=TOOLS,
        rules=["FAT-1", "FAT-7"])  # fmt: skip
def twice() -> Accept:
    """Both entries of coordIndex count: 10 + 30 per step."""
    table = moves(6, deformation([0, 9], [(10, 0, 0), (30, 0, 0)], index=[0, 0]))
    return Accept(fat(fat_table([table]), frame({6: 2})), points=_first((80.0, 0.0, 0.0)))


@vector(id="fat.sum.two-faps", title="Two FAPs on one vertex", tier="semantic", tools=TOOLS, rules=["FAT-7"])
def two_faps() -> Accept:
    """FAP 6 (unit 1) and FAP 4 (unit 1/2) add, each from the neutral position; so do two tables of one FAP."""
    tables = [_unit_table(6), _unit_table(4, vector=(0.0, 2.0, 0.0)), _unit_table(6, vector=(0.0, 0.0, 0.25))]
    return Accept(
        fat(fat_table(tables), frame({4: 8, 6: 4}), frame({4: -8}), frame({6: 4})),
        points=_first((4.0, 8.0, 1.0), (0.0, -8.0, 0.0), (4.0, 0.0, 1.0)),
    )


@vector(id="fat.sum.two-meshes", title="Two meshes", tier="syntax", tools=TOOLS, rules=["FAT-1", "FAT-9"])
def two_meshes() -> Accept:
    """One FAP moves vertices of both; every mesh is on every line, the one that no table names too."""
    table = fat_table([moves(6, deformation([0, 1], [(1, 0, 0)]), deformation([0, 1], [(0, 1, 0)], mesh="N"))])
    meshes = {"M": {"vertices": [[0.0, 0.0, 0.0]]}, "N": {"vertices": [[5.0, 5.0, 5.0]]}}
    document = {**table, "meshes": {**meshes, "Z": {"vertices": [[1.5, 0.0, 0.0]], "faces": []}}}
    rest = {"N": (5.0, 5.0, 5.0), "Z": (1.5, 0.0, 0.0)}
    return Accept(
        fat(document, frame({6: 3}), frame()),
        points={
            (0, "M"): [(3.0, 0.0, 0.0)], (0, "N"): [(5.0, 8.0, 5.0)], (0, "Z"): [rest["Z"]],
            (1, "M"): [_ORIGIN], (1, "N"): [rest["N"]], (1, "Z"): [rest["Z"]],
        },
    )  # fmt: skip


@vector(id="fat.units.by-fap", title="Each FAP in its own unit", tier="semantic", tools=TOOLS,
        rules=["FAC-1", "FAT-2"])  # fmt: skip
def units() -> Accept:
    """FAP 3 MNS 1/2, FAP 19 IRISD 1/4, FAP 31 ENS 2, FAP 37 ES 1, FAP 61 ENS 2. FAP 19 in MNS gives twice as much."""
    faps = {3: 0.5, 6: 1.0, 19: 0.25, 31: 2.0, 37: 1.0, 61: 2.0}
    return Accept(
        fat(fat_table([_unit_table(fap) for fap in faps]), *(frame({fap: 64}) for fap in faps)),
        points=_first(*((64.0 * unit, 0.0, 0.0) for unit in faps.values())),
    )


@vector(id="fat.high-level.visemes", title="Two visemes and their blend", tier="semantic", tools=TOOLS,
        rules=["FAT-8"])  # fmt: skip
def visemes() -> Ambiguous:
    """Blend 40 of visemes 3 and 5: 40 and 23 steps, or 40/63 and 23/63; blend 63 and 0: one of them alone."""
    tables = [moves(1, deformation([0, 63], [_SELECTED[i]]), select=select) for i, select in enumerate((3, 5))]
    found = [frame(viseme=(3, 5, blend)) for blend in (40, 63, 0)]
    points = {
        "blend": _first((40.0, 23.0, 0.0), (63.0, 0.0, 0.0), (0.0, 63.0, 0.0)),
        "fraction": _first((40.0 / 63.0, 23.0 / 63.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    }
    return Ambiguous(fat(fat_table(tables), *found), "AMB-FAT-2", points=points)


@vector(id="fat.high-level.select", title="Selects without a table", tier="semantic", tools=TOOLS, rules=["FAT-8"])
def selects() -> Accept:
    """Select 0 and a viseme without a table move nothing; equal selects add up to 63 = blend + 63 - blend."""
    tables = [moves(1, deformation([0, 63], [(1, 0, 0)]), select=3)]
    visemes = [(0, 0, 40), (4, 3, 40), (3, 0, 40), (3, 3, 40)]
    return Accept(
        fat(fat_table(tables), *(frame(viseme=viseme) for viseme in visemes)),
        points=_first(_ORIGIN, (23.0, 0.0, 0.0), (40.0, 0.0, 0.0), (63.0, 0.0, 0.0)),
    )


@vector(id="fat.high-level.expressions", title="Two expressions", tier="semantic", tools=TOOLS, rules=["FAT-8"])
def expressions() -> Accept:
    """Joy at 10 and fear at 63; then both selects joy: 10 + 63, which is not clamped; intensity 0 moves nothing."""
    tables = [moves(2, deformation([0, 63], [_SELECTED[i]]), select=select) for i, select in enumerate((1, 4))]
    moods = [(1, 10, 4, 63), (1, 10, 1, 63), (1, 0, 0, 63)]
    return Accept(
        fat(fat_table(tables), *(frame(expression=mood) for mood in moods)),
        points=_first((10.0, 63.0, 0.0), (73.0, 0.0, 0.0), _ORIGIN),
    )


@vector(id="fat.high-level.clamped", title="Amplitudes past 0..63", tier="stress", tools=TOOLS, rules=["FAT-8"],
        value_classes=["above-max", "below-min"])  # fmt: skip
def clamped() -> Accept:
    """Blend 100 is 63, which leaves 0 for the other; -5 is 0. Intensities alike, before equal selects add."""
    tables = [
        moves(1, deformation([0, 63], [(1, 0, 0)]), select=1), moves(1, deformation([0, 63], [(0, 1, 0)]), select=2),
        moves(2, deformation([0, 63], [(0, 0, 1)]), select=6),
    ]  # fmt: skip
    found = [
        frame(viseme=(1, 2, 100)), frame(viseme=(1, 2, -5)), frame(expression=(6, 200, 6, -3)),
        frame(expression=(6, 100, 6, 100)),
    ]  # fmt: skip
    return Accept(
        fat(fat_table(tables), *found),
        points=_first((63.0, 0.0, 0.0), (0.0, 63.0, 0.0), (0.0, 0.0, 63.0), (0.0, 0.0, 126.0)),
    )


@vector(id="fat.high-level.intervals", title="An expression in two intervals", tier="semantic", tools=TOOLS,
        rules=["FAT-2", "FAT-8"])  # fmt: skip
def high_intervals() -> Accept:
    """Borders 0, 20, 63: surprise at 30 is 20 * (1 0 0) + 10 * (0 1 0)."""
    table = moves(2, deformation([0, 20, 63], [(1, 0, 0), (0, 1, 0)]), select=6)
    found = [frame(expression=(6, value, 0, 0)) for value in (30, 20, 63)]
    return Accept(
        fat(fat_table([table]), *found), points=_first((20.0, 10.0, 0.0), (20.0, 0.0, 0.0), (20.0, 43.0, 0.0))
    )


@vector(id="fat.high-level.with-low-level", title="A viseme and a low-level FAP", tier="semantic", tools=TOOLS,
        rules=["FAT-7", "FAT-8"])  # fmt: skip
def mixed() -> Accept:
    """The tables of FAP 1, 2 and 6 add on one vertex."""
    tables = [_unit_table(1, 2), _unit_table(2, 3, (0.0, 1.0, 0.0)), _unit_table(6, vector=(0.0, 0.0, 1.0))]
    source = frame({6: -7}, viseme=(2, 0, 9), expression=(3, 5, 0, 0))
    return Accept(fat(fat_table(tables), source), points=_first((9.0, 5.0, -7.0)))


def _node(**fields: object) -> dict[str, dict[str, object]]:
    return {"node": {**fields, "meshes": ["M"]}}


@vector(id="fat.transform.translation", title="Translation by a FAP", tier="semantic", tools=TOOLS,
        rules=["FAT-9", "FAC-1"])  # fmt: skip
def translation() -> Accept:
    """FAP 48 in AU: 100000 steps are 1 along y, on top of the neutral translation. With AU = 1e-4 it is 10."""
    tables = [moves(48, transforms=[("node", "translation", (0, 1, 0))])]
    table = fat_table(tables, transforms=_node(translation=[8, 0, 0]), vertices=[(1, 2, 3)])
    return Accept(
        fat(table, frame({48: 100_000}), frame()), points={(0, "M"): [(9.0, 3.0, 3.0)], (1, "M"): [(9.0, 2.0, 3.0)]}
    )


@vector(id="fat.ambiguous.scale", title="Scale by a FAP", tier="semantic", tools=TOOLS, rules=["FAT-9"])
def scale() -> Ambiguous:
    """FAP 6 at 0, 1 and 2 with scaleDef (3 1 1/2): neutral + FAP * def, or neutral * def to the power of FAP."""
    tables = [moves(6, transforms=[("node", "scale", (3, 1, 0.5))])]
    table = fat_table(tables, transforms=_node(scale=[2, 2, 2]), vertices=[(1, 1, 1)])
    found = [frame({6: value}) for value in (0, 1, 2)]
    at_rest: Point = (2.0, 2.0, 2.0)
    points = {
        "additive": [at_rest, (5.0, 3.0, 2.5), (8.0, 4.0, 3.0)],
        "multiplicative": [at_rest, (6.0, 2.0, 1.0), (18.0, 2.0, 0.5)],
    }
    return Ambiguous(
        fat(table, *found), "AMB-FAT-3",
        points={key: {(i, "M"): [point] for i, point in enumerate(row)} for key, row in points.items()},
    )  # fmt: skip


@vector(id="fat.transform.order", title="Displacement, scale, translation", tier="semantic", tools=TOOLS,
        rules=["FAT-9"])  # fmt: skip
def transform_order() -> Accept:
    """The vertex is displaced to (4 0 0), scaled by 2, then moved by 10: 18, and neither 28 nor 14."""
    tables = [moves(6, deformation([0, 1], [(1, 0, 0)]), transforms=[("node", "translation", (2.5, 0, 0))])]
    table = fat_table(tables, transforms=_node(scale=[2, 1, 1]), vertices=[_ORIGIN])
    return Accept(fat(table, frame({6: 4})), points={(0, "M"): [(18.0, 0.0, 0.0)]})


def _rows(*points: Point) -> tuple[str, ...]:
    times = ("0/1", *(f"{i}/25" for i in range(1, len(points))))
    return tuple(
        compact({"index": i, "time": time, "meshes": {"M": [list(point)]}}).decode().rstrip("\n")
        for i, (time, point) in enumerate(zip(times, points, strict=True))
    )


# Of 1/2 and of the neutral angle 1.
_COS_HALF: Final = 0.8775825618903728
_SIN_HALF: Final = 0.479425538604203
_HALF_PI: Final = 1.5707963267948966


@vector(id="fat.transform.rotation", title="Rotation by a FAP: Table 5", tier="semantic", tools=TOOLS,
        rules=["FAT-9", "FAC-1"])  # fmt: skip
def rotation() -> Accept:
    """FAP 23 about (0 -1 0), factor 1: 50000 AU are half a radian. The axis is normalised: (0 -7 0) is the same."""
    tables = [moves(23, transforms=[("node", "rotation", (0, -7, 0, 1))])]
    table = fat_table(tables, transforms=_node(), vertices=[(1, 2, 0)])
    lines = _rows((_COS_HALF, 2.0, _SIN_HALF), (_COS_HALF, 2.0, -_SIN_HALF), (1.0, 2.0, 0.0))
    return Accept(fat(table, frame({23: 50_000}), frame({23: -50_000}), frame()), declared=lines)


@vector(id="fat.transform.neutral-rotation", title="Neutral rotation before the FAP's", tier="semantic", tools=TOOLS,
        rules=["FAT-9"])  # fmt: skip
def neutral_rotation() -> Accept:
    """A quarter turn about z, then one about x by the FAP: (1 0 0) goes to (0 1 0), then to (0 0 1)."""
    tables = [moves(48, transforms=[("node", "rotation", (1, 0, 0, _HALF_PI))])]
    table = fat_table(tables, transforms=_node(rotation=[0, 0, 1, _HALF_PI]), vertices=[(1, 0, 0)])
    return Accept(fat(table, frame(), frame({48: 100_000})), declared=_rows((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


@vector(id="fat.transform.two-rotations", title="Rotations in ascending FAP number", tier="semantic", tools=TOOLS,
        rules=["FAT-9"])  # fmt: skip
def two_rotations() -> Accept:
    """FAP 48 about x comes before FAP 49 about y, though its table stands behind it: (0 0 1) goes to (0 -1 0)."""
    tables = [
        moves(49, transforms=[("node", "rotation", (0, 1, 0, _HALF_PI))]),
        moves(48, transforms=[("node", "rotation", (1, 0, 0, _HALF_PI))]),
    ]
    table = fat_table(tables, transforms=_node(), vertices=[(0, 0, 1)])
    source = [frame({48: 100_000, 49: 100_000}), frame({48: 200_000, 49: 100_000})]
    return Accept(fat(table, *source), declared=_rows((0.0, -1.0, 0.0), (-1.0, 0.0, 0.0)))


@vector(id="fat.stress.many-columns", title="All low-level FAPs on one vertex", tier="stress", tools=TOOLS,
        rules=["FAT-7"], value_classes=["max", "min"])  # fmt: skip
def many() -> Accept:
    """66 tables of four intervals, in units that differ, all on vertex 0, with large values of both signs."""
    tables = [
        moves(fap, deformation([-200, 0, 100, 400], [(fap, -1, 0.125), (0, fap, 0.5), (0.25, 0.75, -fap)]))
        for fap in range(3, 69)
    ]
    found = [frame({fap: sign * (97 * fap % 1861) for fap in range(3, 69)}) for sign in (1, -1)]
    return Accept(fat(fat_table(tables, units={**UNITS, "ES": 0.03}), *found), lines=2)
