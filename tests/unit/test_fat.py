"""FAT evaluation: samples, the worked example, intervals, high-level FAPs, transforms, readings."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.interpolation.frames_json import read_frames, vertices_line
from snhc.reference_impl.model.fat import FatReadings, FloatArray, evaluate, fat_from_json, load_fat
from snhc.reference_impl.model.fat_bulk import BulkFat

SAMPLES = sorted((Path(__file__).parents[1] / "fixtures" / "samples" / "fat").iterdir())


@dataclass(frozen=True)
class Frame:
    faps: tuple[int | None, ...]
    viseme: tuple[int, int, int] | None = None
    expression: tuple[int, int, int, int] | None = None


def frame(
    faps: dict[int, int] | None = None,
    viseme: tuple[int, int, int] | None = None,
    expression: tuple[int, int, int, int] | None = None,
) -> Frame:
    found = faps or {}
    return Frame(tuple(found.get(i + 1) for i in range(68)), viseme, expression)


def moved(
    tables: list[dict[str, object]],
    source: Frame,
    readings: FatReadings | None = None,
    transforms: dict[str, object] | None = None,
    vertices: list[list[float]] | None = None,
) -> list[list[float]]:
    """The vertices of mesh M for one frame, by both forms."""
    points = vertices or [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]
    document = fat_from_json(
        {
            "fapu": {"ES": 1, "ENS": 1, "MNS": 0.5, "MW": 1, "IRISD": 1},
            "meshes": {"M": {"vertices": points, "faces": []}},
            "tables": tables,
            "transforms": transforms or {},
        }
    )
    chosen = readings or FatReadings()
    out = evaluate(document, source, chosen)["M"]
    bulk = BulkFat(document, chosen)
    assert (np.abs(bulk.evaluate([source])["M"][0] - out) <= bulk.bound([source])["M"][0]).all()
    return [[float(x) for x in row] for row in out]


def mesh_table(
    fap: int, borders: list[int], vectors: list[list[float]], index: int = 0, select: int = 1
) -> dict[str, object]:
    mesh = {"mesh": "M", "intervalBorders": borders, "coordIndex": [index], "displacements": vectors}
    return {"fapID": fap, "highLevelSelect": select, "meshes": [mesh]}


def first(tables: list[dict[str, object]], source: Frame, readings: FatReadings | None = None) -> list[float]:
    return moved(tables, source, readings)[0]


@pytest.mark.parametrize("folder", SAMPLES, ids=lambda folder: folder.name)
def test_sample(folder: Path) -> None:
    document = load_fat(folder / "table.json")
    with (folder / "input.ndjson").open("rb") as stream:
        frames = list(read_frames(stream))
    expected = [json.loads(line) for line in (folder / "expected.ndjson").read_text().splitlines()[1:]]
    assert len(frames) == len(expected)
    for source, wanted in zip(frames, expected, strict=True):
        got = json.loads(vertices_line(source, evaluate(document, source)))
        assert (got["index"], got["time"], list(got["meshes"])) == (
            wanted["index"],
            wanted["time"],
            list(wanted["meshes"]),
        )
        for name, points in wanted["meshes"].items():
            assert np.abs(np.array(got["meshes"][name]) - np.array(points)).max() < 1e-6


def test_samples_are_all_there() -> None:
    assert len(SAMPLES) == 16


# Table 5 of the paper, FAP 6 (MW, here 1), vertex 50.
TABLE_5 = [mesh_table(6, [-1000, 0, 500, 1000], [[1, 0, 0], [0.9, 0, 0], [1.5, 0, 4]])]


def test_worked_example_and_its_negative_twin() -> None:
    # 500 * (0.9 0 0) + 100 * (1.5 0 4) = (600 0 400)
    assert first(TABLE_5, frame({6: 600})) == [600.0, 0.0, 400.0]
    # (0 - -500) * (1 0 0)
    assert first(TABLE_5, frame({6: -500})) == [500.0, 0.0, 0.0]
    assert first(TABLE_5, frame({6: -500}), FatReadings(sign="slope")) == [-500.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("value", "wanted"),
    [(0, 0.0), (500, 450.0), (1000, 1200.0), (1500, 1950.0), (-1000, 1000.0), (-1500, 1500.0), (1, 0.9), (None, 0.0)],
)
def test_borders_and_extrapolation(value: int | None, wanted: float) -> None:
    source = frame({} if value is None else {6: value})
    assert first(TABLE_5, source)[0] == pytest.approx(wanted, rel=1e-12)


def test_negative_side_with_several_intervals() -> None:
    tables = [mesh_table(6, [-300, -200, -100, 0], [[4, 0, 0], [2, 0, 0], [1, 0, 0]])]
    # -250: 50 * 4 + 100 * 2 + 100 * 1; -400: 200 * 4 + 300.
    assert first(tables, frame({6: -250}))[0] == 500.0
    assert first(tables, frame({6: -400}))[0] == 1100.0
    assert first(tables, frame({6: -100}))[0] == 100.0
    # No interval on the positive side.
    assert first(tables, frame({6: 100}))[0] == 0.0
    assert first([mesh_table(6, [0, 10, 20], [[1, 0, 0], [2, 0, 0]])], frame({6: -5}))[0] == 0.0


@pytest.mark.parametrize("borders", [[-10, 10], [5, 10], [0, 100], [-100, 0]])
def test_one_interval_is_linear_for_both_signs(borders: list[int]) -> None:
    tables = [mesh_table(6, borders, [[2, 0, 0]])]
    for value in (-500, -3, 0, 7, 600):
        assert first(tables, frame({6: value}))[0] == 2.0 * value
        assert first(tables, frame({6: value}), FatReadings(sign="slope"))[0] == 2.0 * value


def test_units_scale_and_several_faps_add() -> None:
    tables = [
        mesh_table(3, [-10, 10], [[1, 0, 0]]),  # MNS, 0.5
        mesh_table(6, [-10, 10], [[0, 1, 0]]),
        mesh_table(6, [-10, 10], [[0, 1, 0]]),
        mesh_table(48, [-10, 10], [[0, 0, 1]]),  # AU
    ]
    x, y, z = first(tables, frame({3: 10, 6: 3, 48: 100}))
    assert (x, y) == (5.0, 6.0)
    assert z == pytest.approx(1e-3)


def test_index_that_stands_twice_moves_twice() -> None:
    table = mesh_table(6, [-10, 10], [[1, 0, 0], [0, 1, 0]])
    meshes = table["meshes"]
    assert isinstance(meshes, list)
    meshes[0]["coordIndex"] = [1, 1]
    assert moved([table], frame({6: 2}))[1] == [3.0, 4.0, 3.0]


VISEMES = [mesh_table(1, [0, 63], [[1, 0, 0]], select=3), mesh_table(1, [0, 63], [[0, 1, 0]], select=7)]
MOODS = [mesh_table(2, [0, 32, 63], [[1, 0, 0], [2, 0, 0]], select=4), mesh_table(2, [0, 63], [[0, 1, 0]], select=2)]


def test_visemes() -> None:
    assert first(VISEMES, frame(viseme=(3, 7, 20))) == [20.0, 43.0, 0.0]
    # Equal selects add: 20 + 43.
    assert first(VISEMES, frame(viseme=(3, 3, 20))) == [63.0, 0.0, 0.0]
    assert first(VISEMES, frame(viseme=(0, 7, 20))) == [0.0, 43.0, 0.0]
    assert first(VISEMES, frame(viseme=(5, 15, 20))) == [0.0, 0.0, 0.0]
    # Clamped to 0..63 before the sum.
    assert first(VISEMES, frame(viseme=(3, 7, 90))) == [63.0, 0.0, 0.0]
    assert first(VISEMES, frame(viseme=(3, 7, -5))) == [0.0, 63.0, 0.0]


def test_viseme_reading() -> None:
    got = first(VISEMES, frame(viseme=(3, 7, 21)), FatReadings(viseme="fraction"))
    assert got == pytest.approx([1 / 3, 2 / 3, 0.0])


def test_expressions() -> None:
    # 32 * 1 + 8 * 2 = 48 for 40.
    assert first(MOODS, frame(expression=(4, 40, 2, 5))) == [48.0, 5.0, 0.0]
    # The sum of equal selects is not clamped: 80 -> 32 + 48 * 2.
    assert first(MOODS, frame(expression=(4, 40, 4, 40))) == [128.0, 0.0, 0.0]
    # Each intensity is: 63 + 63.
    assert first(MOODS, frame(expression=(4, 99, 4, 63))) == [220.0, 0.0, 0.0]
    assert first(MOODS, frame(expression=(0, 40, 7, 40))) == [0.0, 0.0, 0.0]


def test_select_of_low_level_tables_is_not_read() -> None:
    assert first([mesh_table(6, [-1, 1], [[1, 0, 0]], select=9)], frame({6: 2}))[0] == 2.0


def node(**fields: object) -> dict[str, object]:
    return {"N": {"meshes": ["M"], **fields}}


def driven(fap: int, field: str, values: list[float]) -> dict[str, object]:
    return {"fapID": fap, "transforms": [{"node": "N", "field": field, "def": values}]}


def test_table_5_rotation() -> None:
    # FAP 23 in AU: angle = 50000 * 1e-5 * 1 about (0 -1 0).
    angle = 0.5
    x, y, z = moved([driven(23, "rotation", [0, -1, 0, 1])], frame({23: 50000}), transforms=node())[1]
    # A turn by -angle about +y: x' = x cos - z sin, z' = x sin + z cos.
    assert (x, y, z) == pytest.approx((cos(angle) - 3 * sin(angle), 2.0, sin(angle) + 3 * cos(angle)), abs=1e-12)


def test_axis_is_normalised_and_neutral_rotation_comes_first() -> None:
    half = round(pi / 2 / 1e-5)
    tables = [driven(23, "rotation", [0, 0, 5, 1])]
    # Neutral: quarter turn about x takes (1 2 3) to (1 -3 2); then about z: (3 1 2).
    got = moved(tables, frame({23: half}), transforms=node(rotation=[2, 0, 0, pi / 2]))[1]
    assert got == pytest.approx([3.0, 1.0, 2.0], abs=1e-4)


def test_rotations_apply_in_ascending_fap_number_in_the_parents_frame() -> None:
    half = round(pi / 2 / 1e-5)
    tables = [driven(25, "rotation", [1, 0, 0, 1]), driven(23, "rotation", [0, 0, 1, 1])]
    # 23 first: (1 2 3) -> (-2 1 3); then 25: (-2 -3 1).
    assert moved(tables, frame({23: half, 25: half}), transforms=node())[1] == pytest.approx([-2, -3, 1], abs=1e-4)


def test_order_displacement_scale_rotation_translation() -> None:
    tables = [
        mesh_table(6, [-1, 1], [[1, 0, 0]], index=1),
        driven(6, "translation", [0, 0, 1]),
        driven(15, "scale", [1, 0, 0]),
    ]
    transforms = node(translation=[100, 0, 0], rotation=[0, 0, 1, pi / 2], scale=[2, 1, 1])
    # (1 2 3) + 4 in x -> (5 2 3); scale (2 + 3, 1, 1): (25 2 3); turn: (-2 25 3); + (100 0 4).
    got = moved(tables, frame({6: 4, 15: 3}), transforms=transforms)[1]
    assert got == pytest.approx([98.0, 25.0, 7.0], abs=1e-9)


def test_scale_reading() -> None:
    tables = [driven(15, "scale", [2, 1, 3])]
    got = moved(tables, frame({15: 2}), FatReadings(scale="multiplicative"), node(scale=[5, 1, 1]))[1]
    # (1 2 3) * (5 * 2^2, 1, 3^2)
    assert got == [20.0, 2.0, 27.0]
    assert moved(tables, frame({15: 2}), transforms=node(scale=[5, 1, 1]))[1] == [9.0, 6.0, 21.0]


def test_node_above_a_node_comes_last() -> None:
    transforms: dict[str, object] = {
        "Head": {"translation": [10, 0, 0], "rotation": [0, 0, 1, pi / 2]},
        "N": {"translation": [1, 0, 0], "meshes": ["M"], "parent": "Head"},
    }
    # (0 0 0) -> (1 0 0) -> turned (0 1 0) -> (10 1 0)
    assert moved([], frame(), transforms=transforms)[0] == pytest.approx([10.0, 1.0, 0.0])


def test_every_mesh_is_printed_and_null_moves_nothing() -> None:
    assert moved(TABLE_5, frame()) == [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]


def test_values_past_float64_are_one_error() -> None:
    tables = [mesh_table(6, [-1, 1], [[1e300, 0, 0]])]
    document = fat_from_json({"fapu": {"MW": 1}, "meshes": {"M": {"vertices": [[0, 0, 0]]}}, "tables": tables})
    with pytest.raises(RangeViolation) as caught:
        evaluate(document, frame({6: 10**200}))
    assert caught.value.path == "meshes.M"


def scalar(document_tables: list[dict[str, object]], fap: int) -> FloatArray:
    """The printed equations for one vertex, in plain Python: an oracle that shares no code."""
    table = document_tables[0]["meshes"]
    assert isinstance(table, list)
    borders, vectors = table[0]["intervalBorders"], table[0]["displacements"]
    k = borders.index(0)
    total = [0.0, 0.0, 0.0]
    for j in range(len(borders) - 1):
        low = borders[j] if j or fap >= 0 or k == 0 else min(fap, borders[0])
        high = borders[j + 1] if j < len(borders) - 2 else max(fap, borders[-1])
        if fap > 0 and j >= k:
            length = max(0, min(fap, high) - low)
        elif fap < 0 and j < k:
            length = max(0, borders[j + 1] - max(fap, low))
        else:
            length = 0
        total = [t + length * v for t, v in zip(total, vectors[j], strict=True)]
    return np.array(total)


def test_all_integer_faps_against_the_printed_equations() -> None:
    tables = [mesh_table(6, [-7, -3, 0, 2, 9], [[1, 5, 0], [2, 0, 1], [3, 0, 2], [4, 1, 0]])]
    for value in range(-12, 14):
        assert np.allclose(first(tables, frame({6: value})), scalar(tables, value), rtol=1e-12)
