"""FAT generation: evaluating the table at the posed values gives the poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.fat import FatDocument, FatMesh, FatReadings, FloatArray, check_fat, evaluate
from snhc.reference_impl.model.fat_generate import generate_face_def_mesh, generate_table

FAPU = Fapu(0.06, 0.05, 0.03, 0.05, 0.01)


@dataclass(frozen=True)
class Frame:
    faps: tuple[int | None, ...]
    viseme: tuple[int, int, int] | None = None
    expression: tuple[int, int, int, int] | None = None


def face(vertices: FloatArray) -> FatMesh:
    return FatMesh("Face", vertices, np.zeros((0, 3), dtype=np.int64))


@pytest.mark.parametrize("sign", ["direction", "slope"])
@pytest.mark.parametrize(
    "values", [[100], [-100], [100, 300], [-300, -50], [-600, 600], [-900, -20, 1, 40, 700]], ids=str
)
def test_poses_come_back(values: list[int], sign: str) -> None:
    rng = np.random.default_rng(len(values))
    readings = FatReadings(sign=sign)
    neutral = face(rng.normal(size=(30, 3)) * 10)
    posed = {}
    for value in values:
        posed[value] = neutral.vertices.copy()
        posed[value][::3] += rng.normal(size=(10, 3))
    table = generate_table(4, {"Face": neutral}, {v: {"Face": p} for v, p in posed.items()}, FAPU, readings=readings)
    assert table.meshes[0].coord_index.tolist() == list(range(0, 30, 3))
    document = FatDocument(FAPU, {"Face": neutral}, (table,))
    check_fat(document)
    for value in (0, *values):
        faps: list[int | None] = [None] * 68
        faps[3] = value
        got = evaluate(document, Frame(tuple(faps)), readings)["Face"]
        wanted = posed.get(value, neutral.vertices)
        # float32 rounding is the bound of FAT-10; float64 does far better.
        assert np.abs(got - wanted).max() <= 2.0**-24 * np.abs(wanted).max()
        assert np.abs(got - wanted).max() <= 1e-12


def test_expression_tables_are_in_amplitudes() -> None:
    neutral = face(np.zeros((2, 3)))
    pose = np.array([[0.0, 0.0, 0.0], [63.0, 0.0, 6.3]])
    table = generate_table(2, {"Face": neutral}, {63: {"Face": pose}}, FAPU, high_level_select=3)
    document = FatDocument(FAPU, {"Face": neutral}, (table,))
    got = evaluate(document, Frame((None,) * 68, None, (3, 10, 0, 0)))["Face"]
    assert got[1] == pytest.approx([10.0, 0.0, 1.0])


def test_tolerance_and_meshes_that_stay() -> None:
    neutral = {
        "Face": face(np.zeros((3, 3))),
        "Eye": FatMesh("Eye", np.zeros((1, 3)), np.zeros((0, 3), dtype=np.int64)),
    }
    pose = np.array([[0.0, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1.0]])
    posed = {100: {"Face": pose, "Eye": np.zeros((1, 3))}}
    assert generate_table(3, neutral, posed, FAPU).meshes[0].coord_index.tolist() == [1, 2]
    table = generate_table(3, neutral, posed, FAPU, tolerance=1e-5)
    assert [mesh.mesh for mesh in table.meshes] == ["Face"]
    assert table.meshes[0].coord_index.tolist() == [2]


def test_pose_that_does_not_name_a_mesh_is_neutral_there() -> None:
    neutral = {"Face": face(np.zeros((1, 3)))}
    table = generate_table(3, neutral, {100: {"Face": np.ones((1, 3))}, 200: {}}, FAPU)
    document = FatDocument(FAPU, neutral, (table,))
    faps: list[int | None] = [None] * 68
    faps[2] = 200
    assert evaluate(document, Frame(tuple(faps)))["Face"].tolist() == [[0.0, 0.0, 0.0]]


def test_faults() -> None:
    neutral = face(np.zeros((2, 3)))
    good = {5: np.ones((2, 3))}
    cases: list[tuple[str, str]] = []
    for posed, unit in (({}, 1.0), (good, 0.0), (good, float("nan")), ({0: good[5]}, 1.0), ({5: np.ones((3, 3))}, 1.0)):
        with pytest.raises(SnhcError) as caught:
            generate_face_def_mesh(neutral, posed, unit)
        cases.append((caught.value.error_class, caught.value.path))
    assert cases == [
        ("InconsistentSemantics", "posed"),
        ("RangeViolation", "unit"),
        ("RangeViolation", "unit"),
        ("RangeViolation", "posed.0"),
        ("InconsistentSemantics", "posed.5"),
    ]
    for fap, meshes, fapu in ((0, "Face", FAPU), (4, "Face", Fapu()), (4, "Nose", FAPU)):
        with pytest.raises(SnhcError) as caught:
            generate_table(fap, {"Face": neutral}, {5: {meshes: good[5]}}, fapu)
        cases.append((caught.value.error_class, caught.value.path))
    assert cases[5:] == [
        ("RangeViolation", "fapID"),
        ("InconsistentSemantics", "fapu.MNS"),
        ("InconsistentSemantics", "posed.5.Nose"),
    ]
