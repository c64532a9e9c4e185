"""Uniform meshes: MSH-6, MSH-7 and the readings of AMB-MSH-1."""

from __future__ import annotations

import pytest

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.mesh.traversal import traverse
from snhc.reference_impl.mesh.uniform import splits_down, uniform_positions, uniform_triangles


def _picture(split_code: int, alternation: str = "checkerboard") -> list[str]:
    """The diagonals that 3 x 3 cells really have, from the triangles' nodes."""
    mesh = uniform_triangles(4, 4, split_code, alternation)
    edges = {(mesh.start[i], mesh.start[i - i % 3 + (i + 1) % 3]) for i in range(len(mesh.start))}
    rows = []
    for row in range(3):
        line = ""
        for col in range(3):
            down = (row * 4 + col, row * 4 + col + 5)
            up = (row * 4 + col + 4, row * 4 + col + 1)
            assert (down in edges) != (up in edges)
            line += "\\" if down in edges else "/"
        rows.append(line)
    return rows


def test_positions_row_by_row() -> None:
    assert uniform_positions(3, 2, 20, 16) == ([0, 20, 40, 0, 20, 40], [0, 0, 0, 16, 16, 16])


@pytest.mark.parametrize(
    ("split_code", "alternation", "rows"),
    [
        (0, "checkerboard", ["\\\\\\", "\\\\\\", "\\\\\\"]),
        (1, "checkerboard", ["///", "///", "///"]),
        (2, "checkerboard", ["\\/\\", "/\\/", "\\/\\"]),
        (3, "checkerboard", ["/\\/", "\\/\\", "/\\/"]),
        (2, "by-column", ["\\/\\", "\\/\\", "\\/\\"]),
        (3, "by-column", ["/\\/", "/\\/", "/\\/"]),
        (2, "by-row", ["\\\\\\", "///", "\\\\\\"]),
        (3, "by-row", ["///", "\\\\\\", "///"]),
    ],
)
def test_splits(split_code: int, alternation: str, rows: list[str]) -> None:
    assert _picture(split_code, alternation) == rows


@pytest.mark.parametrize("alternation", ["checkerboard", "by-column", "by-row"])
@pytest.mark.parametrize("split_code", [0, 1, 2, 3])
@pytest.mark.parametrize(("hor", "vert"), [(2, 2), (2, 5), (5, 2), (4, 3), (7, 6)])
def test_neighbours_and_traversal(hor: int, vert: int, split_code: int, alternation: str) -> None:
    mesh = uniform_triangles(hor, vert, split_code, alternation)
    xs, ys = uniform_positions(hor, vert, 3, 5)
    ends = [mesh.start[e - e % 3 + (e + 1) % 3] for e in range(len(mesh.start))]
    by_edge = {(u, v): e for e, (u, v) in enumerate(zip(mesh.start, ends, strict=True))}
    for (u, v), e in by_edge.items():
        assert mesh.twin[e] == by_edge.get((v, u), -1)
    for t in range(0, len(mesh.start), 3):
        a, b, c = mesh.start[t : t + 3]
        assert (xs[b] - xs[a]) * (ys[c] - ys[a]) - (ys[b] - ys[a]) * (xs[c] - xs[a]) == 15
    topology = traverse(xs, ys, mesh)
    assert topology.order[:2] == [0, 1]
    assert sorted(topology.order) == list(range(hor * vert))
    assert len(topology.triangles) == 2 * (hor - 1) * (vert - 1)


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ((1, 2, 1, 1), "MSH-31"),
        ((1024, 2, 1, 1), "MSH-31"),
        ((2, 1, 1, 1), "MSH-32"),
        ((2, 2, 0, 1), "MSH-34"),
        ((2, 2, 1, 0), "MSH-35"),
        ((2, 2, 1, 256), "MSH-35"),
    ],
)
def test_ranges(arguments: tuple[int, int, int, int], rule: str) -> None:
    with pytest.raises(RangeViolation) as error:
        uniform_positions(*arguments)
    assert error.value.rule == rule


def test_ranges_of_splits() -> None:
    with pytest.raises(RangeViolation, match="MSH-36"):
        splits_down(4, 0, 0)
    with pytest.raises(RangeViolation, match="AMB-MSH-1"):
        splits_down(2, 0, 0, "diagonal")
    with pytest.raises(RangeViolation, match="MSH-31"):
        uniform_triangles(1, 2, 0)
    with pytest.raises(RangeViolation, match="MSH-32"):
        uniform_triangles(2, 1, 0)


def test_largest_row() -> None:
    xs, ys = uniform_positions(1023, 2, 255, 255)
    assert (xs[-1], ys[-1]) == (1022 * 255, 255)
    assert uniform_triangles(1023, 2, 2).triangle_count() == 2044
