"""FIT and FAT speed. Figures are printed by pytest-benchmark; nothing is asserted about time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from snhc.reference_impl.interpolation.fit import FitTable, evaluate, fit_from_json
from snhc.reference_impl.interpolation.fit_bulk import block_arrays, evaluate_sequence, interpolate_block
from snhc.reference_impl.interpolation.frames_json import FrameLine, frame_from_json
from snhc.reference_impl.model import fat
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.fat_bulk import BulkFat


def lip_table() -> FitTable:
    """Inner lips drive outer lips (10 linear functions), one eyebrow drives the others, left drives right."""
    inner, outer = [4, 5, 8, 9, 10, 11, 12, 13], [51, 52, 55, 56, 57, 58, 59, 60]
    brow, others = [34], [31, 32, 33, 35, 36]
    left, right = [6, 19, 39], [7, 20, 40]
    sets = [inner, outer, brow, others, left, right]
    out: dict[str, list[float]] = {"FAPs": [e for faps in sets for e in (*faps, -1)], "Graph": [0, 1, 2, 3, 4, 5]}
    out |= {"numeratorTerms": [], "denominatorTerms": [], "numeratorExp": [], "numeratorCoefs": []}
    for parent, child in ((inner, outer), (brow, others), (left, right)):
        for i in range(len(child)):
            terms = 2 if len(parent) > 1 else 1
            out["numeratorTerms"].append(terms)
            out["denominatorTerms"].append(0)
            for k in range(terms):
                out["numeratorExp"] += [int(j == (i + k) % len(parent)) for j in range(len(parent))]
                out["numeratorCoefs"].append(0.75 if k == 0 else 0.25)
    return fit_from_json(out)


def frames(count: int) -> list[FrameLine]:
    rng = np.random.default_rng(3)
    sent = {4, 5, 6, 8, 9, 10, 11, 12, 13, 19, 34, 39}
    state = "".join("T" if i + 1 in sent else "U" for i in range(68))
    out = []
    for n, row in enumerate(rng.integers(-500, 500, (count, 68)).tolist()):
        faps = [v if i + 1 in sent else None for i, v in enumerate(row)]
        out.append(frame_from_json({"index": n, "time": f"{n}/25", "faps": faps, "state": state}))
    return out


def test_fit_frame_by_frame(benchmark: BenchmarkFixture) -> None:
    table, source = lip_table(), frames(200)
    result = benchmark(lambda: [evaluate(table, frame) for frame in source])
    benchmark.extra_info["frames"] = len(source)
    assert result[0].state.count("F") == 16


def test_fit_sequence_of_records(benchmark: BenchmarkFixture) -> None:
    table, source = lip_table(), frames(20_000)
    result = benchmark(lambda: list(evaluate_sequence(table, source)))
    benchmark.extra_info["frames"] = len(source)
    assert result[0] == evaluate(table, source[0])


def test_fit_arrays(benchmark: BenchmarkFixture) -> None:
    table = lip_table()
    values, available = block_arrays(frames(20_000))

    def run() -> int:
        return int(interpolate_block(table, values.copy(), available.copy()).sum())

    assert benchmark(run) == 16 * 20_000
    benchmark.extra_info["frames"] = 20_000


@dataclass(frozen=True)
class Frame:
    faps: tuple[int | None, ...]
    viseme: tuple[int, int, int] | None = None
    expression: tuple[int, int, int, int] | None = None


@pytest.fixture(scope="module")
def head() -> fat.FatDocument:
    """14,000 vertices, 66 FAPs, three intervals each; every FAP moves every vertex (the worst case)."""
    rng = np.random.default_rng(1)
    size = 14_000
    mesh = fat.FatMesh("Face", rng.normal(size=(size, 3)), np.zeros((0, 3), dtype=np.int64))
    tables = tuple(
        fat.FaceDefTables(
            fap,
            1,
            (fat.FaceDefMesh("Face", (-600, 0, 300, 600), np.arange(size), rng.normal(size=(size, 3, 3)) * 1e-3),),
        )
        for fap in range(3, 69)
    )
    return fat.FatDocument(Fapu(0.03, 0.03, 0.03, 0.03, 0.03), {"Face": mesh}, tables)


def fat_frames(count: int) -> list[Frame]:
    rng = np.random.default_rng(2)
    return [Frame((None, None, *row)) for row in rng.integers(-700, 700, (count, 66)).tolist()]


def test_fat_literal(benchmark: BenchmarkFixture, head: fat.FatDocument) -> None:
    source = fat_frames(4)
    result = benchmark(lambda: [fat.evaluate(head, frame)["Face"] for frame in source])
    benchmark.extra_info["frames"] = len(source)
    assert result[0].shape == (14_000, 3)


def test_fat_bulk(benchmark: BenchmarkFixture, head: fat.FatDocument) -> None:
    bulk, source = BulkFat(head), fat_frames(1024)
    total = benchmark(lambda: sum(len(part["Face"]) for part in bulk.blocks(source)))
    benchmark.extra_info["frames"] = len(source)
    assert total == len(source)
