"""Documents for mistakes that the other vectors let pass: found by the kill matrix, one each.

Rules: CNF-8, as `mistakes`.
"""

from __future__ import annotations

from ..document_builders import compact, deformation, fat, fat_table, fit, fit_table, frame, linear, moves
from ..recipe import Accept, vector


@vector(
    id="fit.value.order-of-the-set",
    title="Functions in the order of the child set",
    tier="semantic",
    tools=("fit",),
    rules=["FIT-3"],
)
def order_of_the_set() -> Accept:
    """The child set is 12, 5, 9, and so are its functions: not in the order of numbers."""
    table = fit_table([[3], [12, 5, 9]], [(0, 1, [linear(2.0), linear(3.0), linear(4.0)])])
    return Accept(fit(table, frame({3: 10})), values={(0, 12): 20, (0, 5): 30, (0, 9): 40})


@vector(
    id="fit.value.longer-denominator",
    title="More terms below than above",
    tier="semantic",
    tools=("fit",),
    rules=["FIT-3", "FIT-4"],
)
def longer_denominator() -> Accept:
    """60 F / (1 + F + F F) for F = 2 and 3: one term above, three below."""
    function = ([(60.0, (1,))], [(1.0, (0,)), (1.0, (1,)), (1.0, (2,))])
    table = fit_table([[3], [4]], [(0, 1, [function])])
    return Accept(fit(table, frame({3: 2}), frame({3: 3})), values={(0, 4): 17, (1, 4): 14})


@vector(
    id="fat.high-level.select-of-a-low-level-fap",
    title="highLevelSelect beside a low-level FAP",
    tier="semantic",
    tools=("fat",),
    rules=["FAT-8"],
)
def select_of_a_low_level_fap() -> Accept:
    """highLevelSelect 3 in the table of FAP 6 says nothing: FAP 6 moves its vertices."""
    table = fat_table([moves(6, deformation([0, 100], [(1, 0, 0)]), select=3)])
    return Accept(fat(table, frame({6: 4})), points={(0, "M"): [(4.0, 0.0, 0.0), (1.0, 2.0, 3.0), (-4.0, 0.5, 8.0)]})


@vector(
    id="fat.interval.within",
    title="Inside an interval, just past a border",
    tier="semantic",
    tools=("fat",),
    rules=["FAT-2", "FAT-3"],
    value_classes=["border"],
)
def within() -> Accept:
    """One past a border the next vector counts once: 11 is 10 of the first and 1 of the second, -11 alike."""
    borders = [-100, -10, 0, 10, 100]
    vectors = [(0, 0, 1), (0, 1, 0), (1, 0, 0), (2, 0, 0)]
    table = fat_table([moves(6, deformation(borders, vectors))], vertices=[(0, 0, 0)])
    return Accept(
        fat(table, *(frame({6: value}) for value in (9, 10, 11, -9, -10, -11))),
        points={
            (0, "M"): [(9.0, 0.0, 0.0)],
            (1, "M"): [(10.0, 0.0, 0.0)],
            (2, "M"): [(12.0, 0.0, 0.0)],
            (3, "M"): [(0.0, 9.0, 0.0)],
            (4, "M"): [(0.0, 10.0, 0.0)],
            (5, "M"): [(0.0, 10.0, 1.0)],
        },
    )


@vector(
    id="fat.transform.scale-rotation-translation",
    title="Neutral scale, rotation and translation of one node",
    tier="semantic",
    tools=("fat",),
    rules=["FAT-9"],
)
def scale_rotation_translation() -> Accept:
    """(1 0 0) is scaled to (2 0 0), turned about z to (0 2 0), moved to (10 2 0): every other order ends elsewhere."""
    node = {
        "N": {"scale": [2, 1, 1], "rotation": [0, 0, 1, 1.5707963267948966], "translation": [10, 0, 0], "meshes": ["M"]}
    }
    line = {"index": 0, "time": "0/1", "meshes": {"M": [[10.0, 2.0, 0.0]]}}
    return Accept(
        fat(fat_table([], transforms=node, vertices=[(1, 0, 0)]), frame()),
        declared=(compact(line).decode().rstrip("\n"),),
    )
