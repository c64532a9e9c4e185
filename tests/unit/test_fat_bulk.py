"""Bulk FAT evaluation: within the derived bound of the literal one for 10,000 random frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import RangeViolation, ResourceLimit
from snhc.reference_impl.model import fat_bulk
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.fat import (
    FaceDefMesh,
    FaceDefTables,
    FaceDefTransform,
    FatDocument,
    FatMesh,
    FatReadings,
    TransformNode,
    amplitudes,
    check_fat,
    evaluate,
)
from snhc.reference_impl.model.fat_bulk import BulkFat, channel, channels


@dataclass(frozen=True)
class Frame:
    faps: tuple[int | None, ...]
    viseme: tuple[int, int, int] | None
    expression: tuple[int, int, int, int] | None


def random_frames(count: int, seed: int) -> list[Frame]:
    rng = np.random.default_rng(seed)
    values = rng.integers(-2000, 2000, (count, 68))
    null = rng.random((count, 68)) < 0.2
    high = rng.integers((0, 0, -9, 0, -9, 0, -9), (16, 16, 80, 8, 80, 8, 80), (count, 7))
    out: list[Frame] = []
    for row, none, h in zip(values.tolist(), null.tolist(), high.tolist(), strict=True):
        faps = tuple(None if n or i < 2 else v for i, (v, n) in enumerate(zip(row, none, strict=True)))
        out.append(Frame(faps, None if none[0] else (h[0], h[1], h[2]), None if none[1] else (h[3], h[4], h[5], h[6])))
    return out


def model(seed: int) -> FatDocument:
    rng = np.random.default_rng(seed)
    meshes = {
        name: FatMesh(name, rng.normal(size=(size, 3)) * 100, np.zeros((0, 3), dtype=np.int64))
        for name, size in (("Face", 12), ("Eye", 5), ("Still", 2))
    }
    tables: list[FaceDefTables] = []
    selects = [(1, s) for s in (1, 5, 14, 20)] + [(2, s) for s in (1, 6)]
    for fap, select in [*selects, *((fap, 1) for fap in (3, 6, 12, 12, 19, 31, 41, 44, 48, 60))]:
        parts: list[FaceDefMesh] = []
        for name in ("Face", "Eye"):
            outer = np.unique(rng.integers(-900, 900, rng.integers(1, 5)))
            borders = tuple(int(b) for b in np.unique([*outer, 0]))
            borders = (-5, 7) if len(borders) < 2 or rng.random() < 0.2 else borders
            index = rng.integers(0, len(meshes[name].vertices), rng.integers(1, 9))
            vectors = rng.normal(size=(len(index), len(borders) - 1, 3)) * (1 if fap != 48 else 1e4)
            parts.append(FaceDefMesh(name, borders, index, vectors))
        turns: tuple[FaceDefTransform, ...] = ()
        if fap in (6, 19, 48):
            kind = {6: "scale", 19: "translation", 48: "rotation"}[fap]
            turns = (
                FaceDefTransform("Eye", kind, tuple(rng.normal(size=4 if fap == 48 else 3).tolist())),
                FaceDefTransform("Head", "rotation", tuple(rng.normal(size=4).tolist())),
            )
        tables.append(FaceDefTables(fap, select, tuple(parts), turns))
    transforms = {
        "Head": TransformNode("Head", (1.0, 2.0, 3.0), (1.0, 2.0, 3.0, 0.4), (1.5, 1.0, 0.5)),
        "Eye": TransformNode("Eye", (4.0, 0.0, 0.0), (0.0, 1.0, 0.0, -2.0), (1.0, 1.0, 1.0), ("Eye",), "Head"),
    }
    document = FatDocument(Fapu(0.05, 0.06, 0.03, 0.06, 0.01), meshes, tuple(tables), transforms)
    check_fat(document)
    return document


@pytest.mark.parametrize(
    "readings", [FatReadings(), FatReadings(sign="slope", viseme="fraction")], ids=["followed", "other"]
)
def test_literal_and_bulk_agree_within_the_bound(readings: FatReadings) -> None:
    document = model(7)
    frames = random_frames(5000, 11 if readings.sign == "slope" else 12)
    bulk = BulkFat(document, readings)
    worst = 0.0
    for start in range(0, len(frames), 1000):
        part = frames[start : start + 1000]
        got, bound = bulk.evaluate(part), bulk.bound(part)
        for n, frame in enumerate(part):
            for name, points in evaluate(document, frame, readings).items():
                error = np.abs(got[name][n] - points)
                assert (error <= bound[name][n]).all()
                worst = max(worst, float((error / bound[name][n]).max()))
    # The bound is of use: errors come within two orders of magnitude of it, and below 1e-4 of the positions.
    assert 0.01 < worst < 1.0
    points, bound = bulk.evaluate(frames[:100]), bulk.bound(frames[:100])
    assert all(bound[name].max() < 1e-4 * np.abs(points[name]).max() for name in points)


def test_bound_is_small_for_a_still_face() -> None:
    document = model(7)
    still = Frame((None,) * 68, None, None)
    bound = BulkFat(document).bound([still])["Face"][0]
    assert (bound < 1e-5 * np.abs(document.meshes["Face"].vertices) + 1e-30).all()


def test_values_past_float32_are_one_error() -> None:
    faps: list[int | None] = [None] * 68
    faps[2] = 10**100
    with pytest.raises(RangeViolation) as caught:
        BulkFat(model(7)).evaluate([Frame(tuple(faps), None, None)])
    assert caught.value.path.startswith("meshes.")


def test_blocks_are_the_whole() -> None:
    document = model(3)
    frames = random_frames(50, 5)
    bulk = BulkFat(document)
    whole = bulk.evaluate(frames)
    parts = list(bulk.blocks(frames, 16))
    assert [len(part["Face"]) for part in parts] == [16, 16, 16, 2]
    bound = bulk.bound(frames)
    for name, points in whole.items():
        # BLAS may sum in another order for another shape.
        assert (np.abs(np.concatenate([part[name] for part in parts]) - points) <= 2 * bound[name]).all()


@pytest.mark.parametrize("viseme", ["blend", "fraction"])
def test_channels_are_the_amplitudes(viseme: str) -> None:
    readings = FatReadings(viseme=viseme)
    frames = random_frames(300, 9)
    table = channels(frames, readings)
    for frame, row in zip(frames, table, strict=True):
        wanted = np.zeros(fat_bulk.CHANNELS)
        for (fap, select), value in amplitudes(frame, readings).items():
            wanted[channel(fap, select)] = value
        assert np.array_equal(row, wanted)


def test_matrix_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fat_bulk, "MAX_MATRIX", 100)
    with pytest.raises(ResourceLimit) as caught:
        BulkFat(model(7))
    assert caught.value.path == "meshes.Face"
