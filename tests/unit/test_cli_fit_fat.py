"""`snhc fit`, `fat`, `dct`, `check`: the samples, exit codes, located errors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from snhc.conformance.cli import check as check_verb
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.findings import SEVERITIES
from snhc.reference_impl.interpolation.fit import load_fit
from snhc.reference_impl.interpolation.fit_text import fit_text
from snhc.reference_impl.model.face_definition import (
    face_definition_from_json,
    fdp_text,
    feature_points,
    parse_face_definition_json,
)
from snhc.reference_impl.model.fat import FatDocument, fat_from_json
from snhc.reference_impl.model.fat_text import fat_text
from snhc.reference_impl.model.feature_motion import feature_motion
from snhc.reference_impl.model.head import feature_vertices, head_definition, load_head

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
STREAM = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
HEADER = '{"format":"snhc-decoded","version":1,"kind":"fba"}\n'


def run(*args: object, stdin: bytes | str | None = None) -> Result:
    return CliRunner().invoke(snhc, [str(arg) for arg in args], input=stdin)


def rows(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def folders(kind: str) -> list[Path]:
    found = sorted((SAMPLES / kind).iterdir())
    assert found
    return found


def frame_line(index: int, **given: int) -> str:
    faps: list[int | None] = [None] * 68
    for name, value in given.items():
        faps[int(name[3:]) - 1] = value
    state = "".join("U" if value is None else "T" for value in faps)
    return json.dumps({"index": index, "time": f"{index}/25", "faps": faps, "state": state}) + "\n"


@pytest.mark.parametrize("folder", folders("fit"), ids=lambda path: path.name)
def test_fit_samples(folder: Path) -> None:
    result = run("fit", folder / "table.json", folder / "input.ndjson")
    assert result.exit_code == 0
    assert rows(result.stdout) == rows((folder / "expected.ndjson").read_text())


@pytest.mark.parametrize("folder", folders("fat"), ids=lambda path: path.name)
def test_fat_samples(folder: Path) -> None:
    result = run("fat", folder / "table.json", folder / "input.ndjson")
    assert result.exit_code == 0
    found, expected = rows(result.stdout), rows((folder / "expected.ndjson").read_text())
    assert found[0] == expected[0] and len(found) == len(expected)
    for ours, theirs in zip(found[1:], expected[1:], strict=True):
        assert (ours["index"], ours["time"]) == (theirs["index"], theirs["time"])
        assert ours["meshes"].keys() == theirs["meshes"].keys()
        for name, points in theirs["meshes"].items():
            for ours_point, theirs_point in zip(ours["meshes"][name], points, strict=True):
                assert ours_point == pytest.approx(theirs_point, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("folder", folders("dctcoef"), ids=lambda path: path.name)
def test_dct_samples(folder: Path) -> None:
    result = run("dct", folder / "input.json")
    assert result.exit_code == 0
    assert rows(result.stdout) == rows((folder / "expected.ndjson").read_text())


def test_dct_readings_are_followed_and_named() -> None:
    path = folders("dctcoef")[0] / "input.json"
    result = run("dct", path, "--reading", "AMB-DCT-1=4")
    assert rows(result.stdout)[0]["readings"] == {"AMB-DCT-1": "4"}
    assert rows(result.stdout)[1:] != rows(run("dct", path).stdout)[1:]


# -- frames ------------------------------------------------------------------------------------------------------------

TABLE: dict[str, Any] = {
    "FAPs": [3, -1, 5, -1], "Graph": [0, 1], "numeratorTerms": [1], "denominatorTerms": [0], "numeratorExp": [1],
    "numeratorCoefs": [-0.5],
}  # fmt: skip


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "table.json"
    path.write_text(json.dumps(TABLE))
    return path


def test_frames_from_standard_input_and_symmetry(table: Path) -> None:
    text = HEADER + frame_line(0, fap3=100, fap19=7) + frame_line(1, fap3=31)
    plain = rows(run("fit", table, "-", stdin=text).stdout)
    assert plain[0]["kind"] == "faces"
    assert [row["faps"][4] for row in plain[1:]] == [-50, -16]  # -15.5: halves away from zero
    assert [row["state"][4] for row in plain[1:]] == ["F", "F"]
    assert plain[1]["faps"][19] is None
    both = rows(run("fit", table, "-", "--symmetry", stdin=text).stdout)
    assert (both[1]["faps"][19], both[1]["state"][19]) == (7, "S")


def test_lines_before_a_broken_one_are_printed(table: Path) -> None:
    text = HEADER + frame_line(0, fap3=100) + '{"index": 1}\n' + frame_line(2, fap3=100)
    for verb in ("fit", "fat"):
        target = table if verb == "fit" else "head"
        result = run(verb, target, "-", "--json-errors", stdin=text)
        error = json.loads(result.stderr.splitlines()[-1])
        assert (result.exit_code, error["class"], error["line"]) == (3, "InputFormat", 3)
        assert len(result.stdout.splitlines()) == 2


def test_no_header_no_output(table: Path) -> None:
    result = run("fit", table, "-", stdin="{}\n")
    assert (result.exit_code, result.stdout) == (3, "")
    empty = run("fit", table, "-", stdin=HEADER)
    assert (empty.exit_code, len(empty.stdout.splitlines())) == (0, 1)


def test_faulty_tables_have_a_path(tmp_path: Path) -> None:
    path = tmp_path / "table.json"
    path.write_text(json.dumps({**TABLE, "numeratorCoefs": []}))
    result = run("fit", path, "-", "--json-errors", stdin=HEADER)
    error = json.loads(result.stderr)
    assert (result.exit_code, error["class"], error["path"]) == (4, "InconsistentSemantics", "numeratorCoefs[0]")
    assert run("fit", tmp_path / "none.json", "-", stdin=HEADER).exit_code == 3
    limited = run("fit", path, "-", "--json-errors", "--limit", "fit_sets=1", stdin=HEADER)
    assert json.loads(limited.stderr)["class"] == "ResourceLimit"


def test_an_output_file_is_left_whole_or_not_at_all(table: Path, tmp_path: Path) -> None:
    target = tmp_path / "out.ndjson"
    assert run("fit", table, "-", "-o", target, stdin=HEADER + "x\n").exit_code == 3
    assert not target.exists()
    assert run("fit", table, "-", "-o", target, stdin=HEADER + frame_line(0)).exit_code == 0
    assert len(target.read_text().splitlines()) == 2


def test_readings_of_tables(tmp_path: Path) -> None:
    model = {
        "fapu": {"MW": 1},
        "meshes": {"m": {"vertices": [[0, 0, 0]], "faces": []}},
        "tables": [
            {"fapID": 6, "meshes": [
                {"mesh": "m", "intervalBorders": [-100, 0, 100], "coordIndex": [0],
                 "displacements": [[1, 0, 0], [0, 1, 0]]}
            ]}
        ],
    }  # fmt: skip
    path = tmp_path / "model.json"
    path.write_text(json.dumps(model))
    text = HEADER + frame_line(0, fap6=-50)
    result = rows(run("fat", path, "-", stdin=text).stdout)
    assert result[1]["meshes"] == {"m": [[50, 0, 0]]}
    slope = rows(run("fat", path, "-", "--reading", "AMB-FAT-1=slope", stdin=text).stdout)
    assert slope[0]["readings"] == {"AMB-FAT-1": "slope"}
    assert slope[1]["meshes"] == {"m": [[-50, 0, 0]]}


def test_low_level_faps_over_rule_expressions_on_the_head() -> None:
    faps: list[int | None] = [None] * 68
    frame = {"index": 0, "time": "0/1", "faps": faps, "state": "UT" + "U" * 66,
             "expression": {"select1": 6, "intensity1": 63, "select2": 0, "intensity2": 0}}  # fmt: skip
    surprised = rows(run("fat", "head", "-", stdin=HEADER + json.dumps(frame)).stdout)[1]["meshes"]
    faps[2] = 0
    frame["state"] = "UTT" + "U" * 65
    shut = rows(run("fat", "head", "-", stdin=HEADER + json.dumps(frame)).stdout)[1]["meshes"]
    neutral = rows(run("fat", "head", "-", stdin=HEADER + frame_line(0)).stdout)[1]["meshes"]
    assert surprised["teeth_lower"] != neutral["teeth_lower"]
    assert shut["teeth_lower"] == neutral["teeth_lower"]
    assert shut["left_brow"] == surprised["left_brow"] != neutral["left_brow"]


# -- decode ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def stream(tmp_path: Path) -> Path:
    """FAPs 3 and 19 in three frames."""
    path = tmp_path / "s.fba"
    mask = " ".join("1" if fap in (3, 19) else "0" for fap in range(1, 69))
    text = "2.1 test 25 3\n" + "".join(f"{mask}\n{n} {n * 31} 40\n" for n in range(3))
    assert run("encode", "-", "--quant", "0", "-o", path, stdin=text).exit_code == 0
    return path


def test_decode_fills_as_fit_does(stream: Path, table: Path) -> None:
    decoded = run("decode", stream, "--quiet").stdout
    for extra in ((), ("--symmetry",)):
        found = run("decode", stream, "--fit", table, *extra, "--quiet")
        assert found.exit_code == 0
        assert rows(found.stdout) == rows(run("fit", table, "-", *extra, stdin=decoded).stdout)
    assert [row["state"][4] + row["state"][19] for row in rows(found.stdout)[1:]] == ["FS"] * 3
    assert rows(run("decode", stream, "--symmetry", "--quiet").stdout)[1]["state"][4] == "U"


def test_decode_gives_vertices_as_fat_does(stream: Path, table: Path) -> None:
    for extra in ((), ("--fit", table)):
        decoded = run("decode", stream, *extra, "--quiet").stdout
        found = run("decode", stream, *extra, "--vertices", "head", "--nframes", "2", "--quiet")
        assert found.exit_code == 0
        assert found.stdout.splitlines() == run("fat", "head", "-", stdin=decoded).stdout.splitlines()[:3]


def test_filled_frames_in_other_formats(stream: Path, table: Path, tmp_path: Path) -> None:
    text = run("decode", stream, "--fit", table, "--format", "fap", "--quiet").stdout.splitlines()
    assert [n + 1 for n, digit in enumerate(text[1].split()) if digit == "1"] == [3, 5, 19]
    assert text[4].split() == ["1", "31", "-16", "40"]
    cells = run("decode", stream, "--fit", table, "--format", "csv", "--quiet").stdout.splitlines()[2].split(",")
    assert cells[3][4] == "F" and "-16" in cells
    for args in (("--vertices", "head", "--format", "csv"), ("--fit", table, "--format", "obj")):
        assert run("decode", stream, *args).exit_code == 2


def test_faults_of_decode(stream: Path, table: Path, tmp_path: Path) -> None:
    assert run("decode", stream, "--fit", tmp_path / "none.json").exit_code == 3
    assert run("decode", stream, "--vertices", tmp_path / "none.json").exit_code == 3
    mesh = folders("mesh")[0] / "input.m2d"
    for args in (("--fit", table), ("--vertices", "head")):
        assert run("decode", mesh, *args, "--quiet").exit_code == 4
        assert run("decode", mesh, *args, "--quiet").stdout == ""


@pytest.mark.parametrize("order", ["pitch-yaw-roll", "roll-pitch-yaw"])
def test_the_order_of_the_heads_rotations_can_be_chosen(order: str, tmp_path: Path) -> None:
    turns = {48: 12_240, 49: 20_400, 50: -8_160}
    path = tmp_path / "s.fba"
    mask = " ".join("1" if fap in turns else "0" for fap in range(1, 69))
    text = f"2.1 test 25 1\n{mask}\n0 {' '.join(map(str, turns.values()))}\n"
    assert run("encode", "-", "--quant", "4", "-o", path, stdin=text).exit_code == 0
    faps = rows(run("decode", path, "--quiet").stdout)[1]["faps"]
    assert all(faps[fap - 1] for fap in turns)
    chosen = ("--reading", f"AMB-FAC-2={order}")
    found = rows(run("decode", path, "--vertices", "head", "--quiet", *chosen).stdout)
    assert found[0]["readings"] == {"AMB-FAC-2": order}
    followed = rows(run("decode", path, "--vertices", "head", "--quiet").stdout)
    for lines, name in ((found, order), (followed, "yaw-pitch-roll")):
        want = feature_motion(face_definition_from_json(head_definition()), faps, order=name).points
        for point, (mesh, vertex) in feature_vertices().items():
            assert lines[1]["meshes"][mesh][vertex] == pytest.approx(want[point], abs=1e-6), (name, point)
    assert found[1]["meshes"]["skin"] != followed[1]["meshes"]["skin"]
    pictures = [tmp_path / "a.glb", tmp_path / "b.glb", tmp_path / "c.png", tmp_path / "d.png"]
    for picture, extra in zip(pictures, ((), chosen, (), chosen), strict=True):
        assert run("render", path, "--software", "--size", "60x72", "-o", picture, *extra).exit_code == 0
    assert len({picture.read_bytes() for picture in pictures}) == 4


# -- check -------------------------------------------------------------------------------------------------------------


def check(data: bytes | str, *args: str) -> Result:
    return run("check", "-", "--format", "json", *args, stdin=data)


def test_severities_are_those_of_findings() -> None:
    assert check_verb.SEVERITIES == SEVERITIES


def test_the_shipped_head_is_a_face_without_findings() -> None:
    text = json.dumps(head_definition())
    assert check(text, "--fail-on", "info").stdout == ""
    as_fdp = fdp_text(parse_face_definition_json(text))
    # .fdp text has no eye centres and diameters; nothing else is lost.
    assert check(as_fdp, "--fail-on", "info").exit_code == 0


def test_a_face_with_a_misplaced_point_has_a_located_warning() -> None:
    definition = head_definition()
    definition["points"]["2.6"]["position"][0] += 10
    del definition["points"]["6.1"]
    result = check(json.dumps(definition))
    assert result.exit_code == 0
    found = rows(result.stdout)
    assert [(row["id"], row["path"]) for row in found] == [
        ("face-point-missing", "points"), ("feature-point-location", "points.2.6.x"),
    ]  # fmt: skip
    assert check(json.dumps(definition), "--fail-on", "warning").exit_code == 1
    assert len(rows(check(json.dumps(definition), "--tolerance", "50").stdout)) == 1


def test_streams_texts_and_tables(table: Path) -> None:
    result = check(STREAM, "--fail-on", "warning")
    assert (result.exit_code, [row["id"] for row in rows(result.stdout)]) == (0, ["no-sequence-header"])
    assert check(STREAM, "--fail-on", "info").exit_code == 1
    assert check(STREAM[:30]).exit_code == 4
    assert check(table.read_text()).exit_code == 0
    assert check('{"tables": [{"fapID": 70}]}').exit_code == 4
    assert check('{"other": 1}').exit_code == 3
    assert check("words\n").exit_code == 3
    mask = " ".join("1" if fap == 3 else "0" for fap in range(1, 69))
    fap = f"2.1 test 25 1\n{mask}\n0 -4\n"
    assert check(fap).exit_code == 0


def fdp_node(definition: dict[str, Any], document: FatDocument) -> str:
    """The model as one FDP node, whose 84 points give the units."""
    points = definition["points"]
    numbers = " ".join(str(c) for row in feature_points() for c in points[row.point]["position"])
    scene, _, tables = fat_text(document).partition("FaceDefTables")
    return (
        f"#VRML V2.0 utf8\nDEF HEAD FDP {{\n featurePointsCoord Coordinate {{ point [ {numbers} ] }}\n"
        f" faceSceneGraph [ {scene} ]\n faceDefTables [ FaceDefTables{tables} ]\n}}\n"
    )


def test_node_texts(table: Path, tmp_path: Path) -> None:
    fit = "# a table\n" + fit_text(load_fit(table), "T")
    assert fit.splitlines()[1] == "DEF T FIT {"
    assert (check(fit).exit_code, check(fit).stdout) == (0, "")
    found = check(fit.replace("FAPs [ 3", "FAPs [ 70"), "--json-errors")
    assert (found.exit_code, json.loads(found.stderr)["path"], json.loads(found.stderr)["line"]) == (4, "FAPs[0]", 3)
    assert json.loads(check(fit, "--limit", "fit_sets=1", "--json-errors").stderr)["class"] == "ResourceLimit"

    model = fdp_node(head_definition(), fat_from_json(load_head()))
    assert (check(model).exit_code, check(model).stdout) == (0, "")
    found = check(model.replace("intervalBorders [ -1800 1800 ]", "intervalBorders [ 1800 -1800 ]", 1), "--json-errors")
    assert (found.exit_code, json.loads(found.stderr)["rule"]) == (4, "FAT-11")
    path = tmp_path / "head.wrl"
    path.write_text(model)
    frames = HEADER + frame_line(0, fap31=120)
    assert rows(run("fat", path, "-", stdin=frames).stdout) == rows(run("fat", "head", "-", stdin=frames).stdout)


def test_a_face_set_that_is_meant_by_its_group_is_told() -> None:
    text = (
        "DEF S Group { children Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0 ] } } } }\n"
        "FaceDefTables { fapID 48 faceDefMesh FaceDefMesh { faceSceneGraphNode USE S intervalBorders [ 0 1 ] "
        "coordIndex 0 displacements [ 1 0 0 ] } }\n"
    )
    assert [(row["id"], row["line"]) for row in rows(check(text).stdout)] == [("face-set-indirect", 2)]


@pytest.mark.parametrize(
    "text", ["Group {}", "InitialObjectDescriptor { objectDescriptorID 1 }", "FIT { FAPs [", "DEF X"]
)
def test_other_texts_are_not_taken(text: str) -> None:
    found = check(text + "\n", "--json-errors")
    assert (found.exit_code, json.loads(found.stderr)["class"]) == (3, "InputFormat")


def test_units_from_a_file_beside_the_model(tmp_path: Path) -> None:
    (tmp_path / "face.json").write_text(json.dumps(head_definition()))
    path = tmp_path / "model.json"
    path.write_text(json.dumps({**load_head(), "fapu": {"face": "face.json"}}))
    assert run("check", path).exit_code == 0
    # Standard input stands beside nothing.
    assert check(path.read_text()).exit_code == 3


def test_negative_values_of_unidirectional_faps_where_they_are_sent(tmp_path: Path) -> None:
    stream = tmp_path / "s.fba"
    masks = [" ".join("1" if fap == sent else "0" for fap in range(1, 69)) for sent in (3, 48, 3)]
    text = f"2.1 test 25 3\n{masks[0]}\n0 -40\n{masks[1]}\n1 500\n{masks[2]}\n2 10\n"
    assert run("encode", "-", "--intra-period", "1", "-o", stream, stdin=text).exit_code == 0
    states = [row["state"][2] for row in rows(run("decode", stream, "--quiet").stdout)[1:]]
    assert states == ["T", "R", "T"]
    found = [row for row in rows(check(stream.read_bytes()).stdout) if row["id"] == "negative-unidirectional"]
    assert [row["path"] for row in found] == ["frame[0].faps[2]"]
