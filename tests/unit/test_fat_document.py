"""FAT documents: every fault has its class, path and expected length; limits; units from a face definition."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError
from snhc.reference_impl.model.fapu import Fapu
from snhc.reference_impl.model.fat import evaluate, fat_from_json, fat_to_json, load_fat, parse_fat_json
from snhc.reference_impl.model.fat_text import fat_text, parse_fat_text

SAMPLES = sorted((Path(__file__).parents[1] / "fixtures" / "samples" / "fat").iterdir())

GOOD: dict[str, Any] = {
    "fapu": {"ES": 0.05, "ENS": 0.06, "MNS": 0.03, "MW": 0.06, "IRISD": 0.01},
    "meshes": {"M": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}},
    "tables": [
        {
            "fapID": 6,
            "highLevelSelect": 1,
            "meshes": [
                {
                    "mesh": "M",
                    "intervalBorders": [-10, 0, 10],
                    "coordIndex": [0, 2],
                    "displacements": [[1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]],
                }
            ],
            "transforms": [{"node": "N", "field": "rotation", "def": [0, -1, 0, 1]}],
        }
    ],
    "transforms": {"N": {"translation": [0, 0, 0], "rotation": [0, 0, 1, 0], "scale": [1, 1, 1], "meshes": ["M"]}},
}


def changed(path: str, value: object) -> dict[str, Any]:
    document = copy.deepcopy(GOOD)
    at: Any = document
    keys = path.replace("[", ".").replace("]", "").split(".")
    for key in keys[:-1]:
        at = at[int(key)] if isinstance(at, list) else at[key]
    if isinstance(at, list):
        at[int(keys[-1])] = value
    elif value is ...:
        del at[keys[-1]]
    else:
        at[keys[-1]] = value
    return document


T = "tables[0]"
M = f"{T}.meshes[0]"
CASES: list[tuple[str, object, str, str, int | None]] = [
    (f"{M}.intervalBorders", [-10, 10, 0], "InconsistentSemantics", f"{M}.intervalBorders[2]", None),
    (f"{M}.intervalBorders", [-10, 0, 0], "InconsistentSemantics", f"{M}.intervalBorders[2]", None),
    (f"{M}.intervalBorders", [1, 2, 3], "InconsistentSemantics", f"{M}.intervalBorders", None),
    (f"{M}.intervalBorders", [0], "InconsistentSemantics", f"{M}.intervalBorders", 2),
    (f"{M}.intervalBorders", [], "InconsistentSemantics", f"{M}.intervalBorders", 2),
    (f"{M}.intervalBorders", [0, 1 << 31], "RangeViolation", f"{M}.intervalBorders[1]", None),
    (f"{M}.intervalBorders", [0, 1.0], "InputFormat", f"{M}.intervalBorders[1]", None),
    (f"{M}.displacements", [[1, 0, 0]] * 3, "InconsistentSemantics", f"{M}.displacements[3]", 4),
    (f"{M}.displacements", [[1, 0, 0]] * 5, "InconsistentSemantics", f"{M}.displacements[4]", 4),
    (f"{M}.displacements[1]", [1, 0], "InconsistentSemantics", f"{M}.displacements[1]", 3),
    (f"{M}.displacements[1]", [1, 0, "0"], "InputFormat", f"{M}.displacements[1][2]", None),
    (f"{M}.displacements[1]", [1, 0, 1e999], "InputFormat", f"{M}.displacements[1][2]", None),
    (f"{M}.displacements[1]", [1, 0, 10**400], "InputFormat", f"{M}.displacements[1][2]", None),
    (f"{M}.coordIndex[1]", 3, "RangeViolation", f"{M}.coordIndex[1]", None),
    (f"{M}.coordIndex[1]", -1, "RangeViolation", f"{M}.coordIndex[1]", None),
    (f"{M}.mesh", "X", "InconsistentSemantics", f"{M}.mesh", None),
    (f"{M}.mesh", 1, "InputFormat", f"{M}.mesh", None),
    (f"{T}.fapID", 0, "RangeViolation", f"{T}.fapID", None),
    (f"{T}.fapID", 69, "RangeViolation", f"{T}.fapID", None),
    (f"{T}.highLevelSelect", 0, "RangeViolation", f"{T}.highLevelSelect", None),
    (f"{T}.highLevelSelect", 65, "RangeViolation", f"{T}.highLevelSelect", None),
    (f"{T}.transforms[0].node", "X", "InconsistentSemantics", f"{T}.transforms[0].node", None),
    (f"{T}.transforms[0].field", "center", "InputFormat", f"{T}.transforms[0].field", None),
    (f"{T}.transforms[0].def", [0, 1, 0], "InconsistentSemantics", f"{T}.transforms[0].def", 4),
    (f"{T}.transforms[0].def", [0, 0, 0, 1], "RangeViolation", f"{T}.transforms[0].def", None),
    ("transforms.N.rotation", [0, 0, 0, 1], "RangeViolation", "transforms.N.rotation", None),
    ("transforms.N.scale", [1, 1], "InconsistentSemantics", "transforms.N.scale", 3),
    ("transforms.N.meshes", ["X"], "InconsistentSemantics", "transforms.N.meshes[0]", None),
    ("transforms.N.meshes", ["M", "M"], "InconsistentSemantics", "transforms.N.meshes[1]", None),
    ("transforms.N.parent", "N", "InconsistentSemantics", "transforms.N.parent", None),
    ("transforms.N.parent", "X", "InconsistentSemantics", "transforms.N.parent", None),
    ("meshes.M.faces[0]", [0, 1, 3], "RangeViolation", "meshes.M.faces[0][2]", None),
    ("meshes.M.faces[0]", [0, 1], "InconsistentSemantics", "meshes.M.faces[0]", 3),
    ("meshes.M.vertices[2]", [0, None, 0], "InputFormat", "meshes.M.vertices[2][1]", None),
    ("meshes.M.vertices", {}, "InputFormat", "meshes.M.vertices", None),
    ("meshes", [], "InputFormat", "meshes", None),
    ("fapu.MW", ..., "InconsistentSemantics", "fapu.MW", None),
    ("fapu.MW", "0.1", "InputFormat", "fapu.MW", None),
    ("fapu.MW", -1, "RangeViolation", "fapu.MW", None),
    ("fapu.AU", 1e-4, "InconsistentSemantics", "fapu.AU", None),
    ("fapu", {"face": "x.json"}, "InputFormat", "fapu.face", None),
]


@pytest.mark.parametrize(("path", "value", "error_class", "at", "expected"), CASES)
def test_fault(path: str, value: object, error_class: str, at: str, expected: int | None) -> None:
    with pytest.raises(SnhcError) as caught:
        fat_from_json(changed(path, value))
    error = caught.value
    assert (error.error_class, error.path, error.expected) == (error_class, at, expected)
    assert error.allowed


def test_good_document_goes_out_and_in() -> None:
    document = fat_from_json(GOOD)
    assert fat_to_json(document) == GOOD
    assert fat_from_json(changed("transforms.N.rotation", [0, 0, 0, 0])).transforms["N"].rotation == (0, 0, 0, 0)


def test_defaults_and_unknown_keys() -> None:
    document = fat_from_json({"x": 1, "tables": [{}], "transforms": {"T": {}}})
    assert (document.tables[0].fap_id, document.tables[0].high_level_select) == (1, 1)
    assert document.transforms["T"].rotation == (0, 0, 1, 0)
    empty = fat_from_json({**GOOD, "tables": [{"fapID": 6, "meshes": [{"mesh": "M"}]}]})
    assert empty.tables[0].meshes[0].displacements.shape == (0, 0, 3)


def test_another_document_is_no_empty_model() -> None:
    with pytest.raises(InputFormat):
        fat_from_json({"FAPs": []})


def test_vertex_limit(tmp_path: Path) -> None:
    (tmp_path / "a").write_text(json.dumps(GOOD))
    with pytest.raises(SnhcError):
        load_fat(tmp_path / "a", max_vertices=2)
    assert fat_from_json(GOOD, max_vertices=3).meshes
    with pytest.raises(SnhcError) as caught:
        fat_from_json(GOOD, max_vertices=2)
    assert (caught.value.error_class, caught.value.path) == ("ResourceLimit", "meshes.M")
    two = {**GOOD, "meshes": {**GOOD["meshes"], "O": GOOD["meshes"]["M"]}}
    with pytest.raises(SnhcError) as caught:
        fat_from_json(two, max_vertices=5)
    assert caught.value.path == "meshes.O"


def test_json_faults_have_line_and_column() -> None:
    with pytest.raises(SnhcError) as caught:
        parse_fat_json(b'{"fapu":\n  {,}}')
    assert (caught.value.error_class, caught.value.line, caught.value.column) == ("InputFormat", 2, 4)


def test_units_from_a_face_definition(tmp_path: Path) -> None:
    points = {"3.5": [32, 0, 0], "3.6": [-32, 0, 0], "9.15": [0, -50, 0], "2.2": [0, -80, 0], "8.3": [25.6, 0, 0]}
    points |= {"8.4": [-25.6, 0, 0], "3.1": [32, 6, 0], "3.3": [32, -6, 0]}
    (tmp_path / "face.json").write_text(json.dumps({"points": points}))
    (tmp_path / "fat.json").write_text(json.dumps({**GOOD, "fapu": {"face": "face.json"}}))
    assert load_fat(tmp_path / "fat.json").fapu == Fapu(64 / 1024, 50 / 1024, 30 / 1024, 51.2 / 1024, 12 / 1024)
    (tmp_path / "fat.json").write_text(json.dumps({**GOOD, "fapu": {"face": "none.json"}}))
    with pytest.raises(SnhcError) as caught:
        load_fat(tmp_path / "fat.json")
    assert (caught.value.error_class, caught.value.path) == ("InputFormat", "fapu.face")


class Frame:
    faps = tuple(None if i < 2 else 40 - i for i in range(68))
    viseme = (3, 5, 20)
    expression = (2, 30, 4, 10)


@pytest.mark.parametrize("folder", SAMPLES, ids=lambda folder: folder.name)
def test_text_form_says_the_same(folder: Path) -> None:
    document = load_fat(folder / "table.json")
    again, findings = parse_fat_text(fat_text(document), document.fapu)
    assert findings == []
    wanted, got = evaluate(document, Frame()), evaluate(again, Frame())
    assert set(got) == set(wanted)
    for name, points in wanted.items():
        assert np.array_equal(got[name], points)
        assert np.array_equal(again.meshes[name].faces, document.meshes[name].faces)


SCENE = """
DEF Head Transform { rotation 0 1 0 0.5 children [
  DEF Skin Shape { geometry IndexedFaceSet {
    coord DEF Points Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] } coordIndex [ 0 1 2 3 -1 0 1 3 ] } }
  DEF Eye Transform { scale 2 2 2 children [ Group { children [ Shape { geometry IndexedFaceSet {
    coord USE Points } } ] } ] } ] }
"""
TABLE = """FaceDefTables { fapID 6
  faceDefMesh [ FaceDefMesh { faceSceneGraphNode USE Skin intervalBorders [ -1 1 ] coordIndex 2 displacements 1 2 3 } ]
  faceDefTransform FaceDefTransform { faceSceneGraphNode USE Eye fieldId 4 rotationDef 0 1 0 1 } }
"""
UNITS = Fapu(1.0, 1.0, 1.0, 1.0, 1.0)


def test_text_form_of_a_scene() -> None:
    document, findings = parse_fat_text(TABLE + SCENE, UNITS)
    assert list(document.meshes) == ["Skin", "Mesh1"]
    assert document.meshes["Skin"].faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 3]]
    assert document.meshes["Mesh1"].vertices.shape == (4, 3)
    assert (document.transforms["Eye"].parent, document.transforms["Eye"].meshes) == ("Head", ("Mesh1",))
    assert document.tables[0].meshes[0].displacements.tolist() == [[[1.0, 2.0, 3.0]]]
    assert document.tables[0].transforms[0].definition == (0, 1, 0, 1)
    assert findings == []


def test_text_form_findings() -> None:
    text = SCENE + TABLE.replace("USE Skin", "USE Head").replace("USE Head", "USE Eye", 1).replace(
        "rotationDef 0 1 0 1", ""
    )
    document, findings = parse_fat_text(text, UNITS)
    assert [finding.id for finding in findings] == ["face-set-indirect", "field-id-guessed"]
    assert document.tables[0].meshes[0].mesh == "Mesh1"
    assert document.tables[0].transforms[0].field == "rotation"


def test_two_definitions_leave_the_choice_to_field_id() -> None:
    both = TABLE.replace("fieldId 4 rotationDef 0 1 0 1", "fieldId 7 scaleDef 2 2 2 translationDef 1 2 3")
    document, findings = parse_fat_text(both + SCENE, UNITS)
    assert (document.tables[0].transforms[0].field, document.tables[0].transforms[0].definition) == (
        "translation",
        (1, 2, 3),
    )
    assert [finding.id for finding in findings] == ["field-id-guessed"]


def test_text_form_of_an_fdp_takes_units_from_the_feature_points() -> None:
    points = ", ".join(f"{i} {i * i} 0" for i in range(84))
    text = f"FDP {{ featurePointsCoord Coordinate {{ point [ {points} ] }} faceDefTables [ {TABLE} ] "
    document, _ = parse_fat_text(text + f"faceSceneGraph [ {SCENE} ] }}")
    # 3.5 and 3.6 are neighbours in the table: ES0 = 1.
    assert document.fapu.es == 1 / 1024
    with pytest.raises(SnhcError) as caught:
        parse_fat_text(text.replace("0 0 0, ", "", 1) + f"faceSceneGraph [ {SCENE} ] }}")
    assert (caught.value.error_class, caught.value.expected) == ("InconsistentSemantics", 84)


@pytest.mark.parametrize(
    ("old", "new", "error_class", "line"),
    [
        ("USE Skin", "USE Nobody", "InconsistentSemantics", 2),
        ("USE Skin", "Shape { }", "InputFormat", 2),
        ("USE Eye fieldId 4", "USE Skin fieldId 4", "InconsistentSemantics", 3),
        ("fieldId 4 rotationDef 0 1 0 1", "fieldId 1", "InconsistentSemantics", 3),
        ("rotationDef 0 1 0 1", "rotationDef 0 1 0", "InputFormat", 3),
        ("fapID 6", "fapID 69", "RangeViolation", 1),
        ("fapID 6", "fapID 6 7", "InputFormat", 1),
        ("fapID 6", "fap 6", "InputFormat", 1),
        ("coordIndex 2", "coordIndex 4", "RangeViolation", 1),
        ("coordIndex 2", "coordIndex [ 2 3 ]", "InconsistentSemantics", 2),
        ("displacements 1 2 3", "displacements 1 2", "InputFormat", 2),
        ("-1 1", "1 1", "InconsistentSemantics", 1),
    ],
)
def test_text_form_faults(old: str, new: str, error_class: str, line: int) -> None:
    assert old in TABLE
    with pytest.raises(SnhcError) as caught:
        parse_fat_text(TABLE.replace(old, new) + SCENE, UNITS)
    assert (caught.value.error_class, caught.value.line) == (error_class, line)
    assert caught.value.column


def test_text_form_what_is_not_built() -> None:
    for text in ("center 1 0 0", "scaleOrientation 0 0 1 0.5"):
        with pytest.raises(SnhcError) as caught:
            parse_fat_text(f"Transform {{ {text} }}", UNITS)
        assert caught.value.error_class == "Unsupported"
    with pytest.raises(SnhcError) as caught:
        parse_fat_text("Shape { geometry IndexedFaceSet { coord Group { } } }", UNITS)
    assert caught.value.error_class == "InputFormat"
