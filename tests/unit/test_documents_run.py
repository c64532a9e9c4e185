"""Vectors of documents and the comparators with a tolerance: right outputs pass, each near miss fails.

Rules: CNF-9, CNF-13, CNF-16, CNF-25, DCT-8, FAC-1.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import snhc.reference_impl.model.face_definition as face_definition
from snhc.conformance.adapters import BuiltIn, OneShot, Outcome
from snhc.conformance.compare import Verdict, judge, related
from snhc.conformance.differences import mesh_difference
from snhc.conformance.runner import run, verify
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.model import fapu, fat
from snhc.vectors.documents import decode_document
from snhc.vectors.manifest import DOCUMENTS, SUITE, Accepted, Entry, Manifest, load, validate

MANIFEST = load(check_schema=False)
ENTRIES = {entry.id: entry for entry in MANIFEST.entries}
OURS = [entry for entry in MANIFEST.entries if entry.media in DOCUMENTS]


def expected(entry: Entry) -> bytes:
    assert isinstance(entry.expect, Accepted)
    return (SUITE / entry.expect.file).read_bytes()


def changed(entry: Entry, change: Callable[[list[Any]], None]) -> bytes:
    """What is expected, with its lines changed."""
    lines = [json.loads(line) for line in expected(entry).splitlines()]
    change(lines)
    return "".join(json.dumps(line) + "\n" for line in lines).encode()


def verdict(id: str, output: bytes, format: str = "ndjson") -> Verdict:
    return judge(ENTRIES[id], Outcome(0, output), SUITE, format)


def after(id: str, change: Callable[[list[Any]], None]) -> str:
    return verdict(id, changed(ENTRIES[id], change)).status


def test_there_are_enough_of_each_and_the_reference_passes() -> None:
    counts = {media: sum(entry.media == media for entry in OURS) for media in DOCUMENTS}
    assert counts["dctcoef"] >= 30 and counts["fit"] >= 25 and counts["fat"] >= 25 and counts["face"] >= 10
    report = run(Manifest(MANIFEST.suite, tuple(OURS)), [BuiltIn()])
    assert {result.status for result in report.results} == {"pass"}
    found = {amb for entry in OURS for amb in entry.readings}
    assert found >= {f"AMB-{tool}-{n}" for tool in ("FIT", "FAT") for n in (1, 2, 3)}


def test_single_precision_passes_and_more_does_not() -> None:
    bound = ENTRIES["fat.interval.example"].tolerance
    assert bound is not None and bound.model == "geometry"

    def shifted(by: float) -> Callable[[list[Any]], None]:
        return lambda lines: lines[1]["meshes"]["M"][0].__setitem__(2, 400.0 + by)

    assert after("fat.interval.example", shifted(bound.bound)) == "pass"
    assert after("fat.interval.example", shifted(2 * bound.bound)) == "fail"
    assert after("fat.interval.example", lambda lines: lines[1]["meshes"]["M"].pop()) == "fail"
    assert (
        after("fat.interval.example", lambda lines: lines[1]["meshes"].update(N=lines[1]["meshes"].pop("M"))) == "fail"
    )
    assert after("fat.interval.example", lambda lines: lines[1]["meshes"]["M"][0].__setitem__(0, "600")) == "error"


def test_a_dct_value_may_be_one_off_where_rounding_allows_it() -> None:
    # FAP 3 is 2.5 before rounding, 3 after it; FAP 18 is 5/12.
    def value(fap: int, number: int) -> Callable[[list[Any]], None]:
        return lambda lines: lines[1]["faps"].__setitem__(fap - 1, number)

    assert after("dct.coefficients.halves", value(3, 2)) == "pass"
    assert after("dct.coefficients.halves", value(3, 4)) == "fail"
    assert after("dct.coefficients.halves", value(18, 1)) == "fail"
    # Unset FAPs are exact.
    assert after("dct.coefficients.halves", value(20, 0)) == "fail"


def test_a_decoder_that_truncates_fails_and_one_in_single_precision_passes() -> None:
    from snhc.vectors.documents import unrounded

    entry = ENTRIES["dct.coefficients.dense"]
    rows = unrounded((SUITE / entry.file).read_bytes())

    def by(step: Callable[[float], int]) -> Callable[[list[Any]], None]:
        def change(lines: list[Any]) -> None:
            for line, row in zip(lines[1:], rows, strict=True):
                line["faps"] = [None if x is None else step(x) for x in row]

        return change

    assert after(entry.id, by(int)) == "fail"
    assert after(entry.id, by(lambda x: round(x * (1 + 2.0**-24)))) == "pass"


def test_streams_with_coefficients_are_compared_alike() -> None:
    entry = ENTRIES["fap.dct.example.1"]
    assert entry.tolerance is not None and entry.tolerance.model == "dct-8"

    def value(number: int) -> Callable[[list[Any]], None]:
        return lambda lines: lines[12]["faps"].__setitem__(2, number)

    assert after(entry.id, value(202)) == "pass"
    assert after(entry.id, value(204)) == "fail"
    # An arithmetic stream has no tolerance.
    assert (
        after("fap.arith.example.1", lambda lines: lines[1]["faps"].__setitem__(2, lines[1]["faps"][2] + 1)) == "fail"
    )


def test_mesh_output_of_a_foreign_decoder() -> None:
    ids = [id for id, entry in ENTRIES.items() if "mesh" in entry.tools and entry.kind == "valid"]
    loose = next(id for id in ids if "MSH-21" not in ENTRIES[id].rules and b"[[0," in expected(ENTRIES[id]))
    strict = next(id for id in ids if "MSH-21" in ENTRIES[id].rules)
    spaced = lambda lines: None  # noqa: E731
    assert after(loose, spaced) == "pass" and after(strict, spaced) == "pass"

    def reversed_list(lines: list[Any]) -> None:
        lines[1]["triangles"].reverse()

    def turned(lines: list[Any]) -> None:
        lines[1]["triangles"] = [[b, c, a] for a, b, c in lines[1]["triangles"]]

    def mirrored(lines: list[Any]) -> None:
        a, b, c = lines[1]["triangles"][0]
        lines[1]["triangles"][0] = [a, c, b]

    assert after(loose, turned) == "pass" and after(loose, mirrored) == "fail"
    assert after(strict, reversed_list) == "fail"
    assert after(strict, lambda lines: lines[1]["order"].reverse()) == "fail"
    assert after(strict, lambda lines: lines[1]["nodes"][0].__setitem__(0, -1)) == "fail"
    assert after(strict, lambda lines: lines[1].pop("triangles")) == "fail"
    assert after(strict, lambda lines: lines[1]["nodes"][0].__setitem__(0, 0.5)) == "error"
    assert after(strict, lambda lines: lines.pop()) == "fail"


def test_triangles_are_compared_as_multisets() -> None:
    frame = {"index": 0, "time": "0/1", "intra": True, "nodes": [], "triangles": [[0, 1, 2], [1, 3, 2]], "order": []}
    other = {**frame, "triangles": [[3, 2, 1], [0, 1, 2]]}
    double = {**frame, "triangles": [[0, 1, 2], [0, 1, 2]]}
    assert mesh_difference([frame], [other]) is None
    assert mesh_difference([frame], [other], ordered=True) is not None
    assert mesh_difference([frame], [double]) is not None


def test_faces_are_exact() -> None:
    assert after("fit.case.c-eyebrow", lambda lines: None) == "pass"
    assert after("fit.case.c-eyebrow", lambda lines: lines[1]["faps"].__setitem__(30, 51)) == "fail"
    state = "fit.case.c-eyebrow"
    assert after(state, lambda lines: lines[1].update(state=lines[1]["state"].replace("F", "T"))) == "fail"


@pytest.mark.parametrize(
    ("said", "status"),
    [
        ({"class": "RangeViolation", "path": "Graph[1]"}, "pass"), ({"path": "Graph"}, "pass"), ({}, "pass"),
        ({"path": "Graph[0]"}, "fail"), ({"path": "FAPs[1]"}, "fail"), ({"class": "InputFormat"}, "fail"),
        ({"path": 1}, "error"), ({"path": "Graph[1]", "line": "1"}, "error"),
    ],
)  # fmt: skip
def test_what_a_rejection_says_of_its_path(said: dict[str, object], status: str) -> None:
    outcome = Outcome(1, b"", json.dumps(said).encode())
    assert judge(ENTRIES["fit.error.set-2-of-2"], outcome, SUITE, "ndjson").status == status


def test_lines_of_frames_are_held_against_the_manifest() -> None:
    id = "fit.error.frames.time"
    for line, status in ((3, "pass"), (2, "fail")):
        outcome = Outcome(1, b"", json.dumps({"path": "time", "line": line}).encode())
        assert judge(ENTRIES[id], outcome, SUITE, "ndjson").status == status
    assert judge(ENTRIES[id], Outcome(0), SUITE, "ndjson").status == "fail"


def test_paths_are_related_step_by_step() -> None:
    assert related("Graph", "Graph[3]") and related("a.b[1].c", "a.b") and related("a.b", "a.b")
    assert not related("Graph[3]", "Graph[30]") and not related("Gra", "Graph")


def test_an_adapter_gets_the_second_file(tmp_path: Path) -> None:
    script = tmp_path / "echo.py"
    script.write_text(
        "import sys\nprint([word.rpartition('/')[2] for word in sys.argv[1:]], file=sys.stderr)\nsys.exit(3)\n"
    )
    command = (sys.executable, str(script), "{media}", "{input}", "{aux}")
    adapter = OneShot("echo", command, tools=("fba", "fit"))
    chosen = Manifest("0.0.0", (ENTRIES["fap.arith.example.1"], ENTRIES["fit.case.d-asymmetric"]))
    one, two = [result.reason for result in run(chosen, [adapter]).results]
    assert "'fba'" in one and one.count("'") == 4
    assert "['fit', 'fit.case.d-asymmetric.table.json', 'fit.case.d-asymmetric.frames.ndjson']" in two


def test_tools_that_are_not_claimed_and_formats_that_cannot_hold_it() -> None:
    entry = ENTRIES["fit.case.d-asymmetric"]
    assert OneShot("x", ("x", "{input}")).lacks(entry) == "fit"
    assert OneShot("x", ("x", "{input}"), tools=("fit",)).lacks(entry) == "{aux} in the command"
    assert OneShot("x", ("x", "{input}", "{aux}"), tools=("fit",)).lacks(entry) == ""
    assert OneShot("x", ("x", "{input}", "{aux}"), "fap", tools=("fit",)).lacks(entry) == "format ndjson"
    assert OneShot("x", ("x",), "fap", tools=("dctcoef",)).lacks(ENTRIES["dct.coefficients.halves"]) == ""


def test_fap_text_of_coefficients() -> None:
    text = "\n".join(
        [
            "2.1 halves 30 16",
            *(f"{'0 0 1 1 1 1' + ' 0' * 11 + ' 1' + ' 0' * 50}\n{i} {{}} -3 8 -8 0" for i in range(16)),
        ]
    )
    assert verdict("dct.coefficients.halves", (text.replace("{}", "2") + "\n").encode(), "fap").status == "pass"
    assert verdict("dct.coefficients.halves", (text.replace("{}", "4") + "\n").encode(), "fap").status == "fail"


def test_another_second_file_is_refused(tmp_path: Path) -> None:
    entry = ENTRIES["fit.case.d-asymmetric"]
    assert isinstance(entry.expect, Accepted)
    for name in (entry.file, entry.aux, entry.expect.file):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes((SUITE / name).read_bytes())
    verify([entry], tmp_path)
    (tmp_path / entry.aux).write_bytes(b"")
    with pytest.raises(InputFormat, match="frames"):
        verify([entry], tmp_path)


@pytest.mark.parametrize(
    "change",
    [{"bits": [0, 1]}, {"path": ""}, {"line": 0}],
)
def test_the_schema_refuses_places_that_do_not_fit(change: dict[str, object]) -> None:
    document = json.loads(MANIFEST.text())
    entry = next(entry for entry in document["vectors"] if entry["id"] == "fit.error.fap-0")
    document["vectors"] = [entry]
    validate(document)
    entry["expect"]["reject"].update(change)
    with pytest.raises(InputFormat):
        validate(document)


# -- the mistakes of FAC-1 ---------------------------------------------------------------------------------------------


def failing(media: tuple[str, ...]) -> set[str]:
    """The valid vectors whose output is not within their tolerance."""
    out = set()
    for entry in OURS:
        if entry.media in media and entry.kind == "valid":
            aux = (SUITE / entry.aux).read_bytes() if entry.aux else b""
            decoded = decode_document(entry.media, (SUITE / entry.file).read_bytes(), aux, entry.options.for_decoder())
            outcome = Outcome(0 if decoded.error is None else 1, decoded.text.encode())
            if judge(entry, outcome, SUITE, "ndjson").status != "pass":
                out.add(entry.id)
    return out


def test_the_right_units_pass() -> None:
    assert failing(("face", "fat")) == set()


def test_au_of_ten_times_its_size_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fapu, "AU", 1e-4)
    assert failing(("face", "fat")) >= {"fat.transform.translation", "fat.transform.rotation", "fapu.unit-by-fap"}


def test_mns_to_the_outer_lip_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    real = face_definition.FaceDefinition.point
    monkeypatch.setattr(
        face_definition.FaceDefinition, "point", lambda self, name: real(self, "8.1" if name == "2.2" else name)
    )
    assert "fapu.mns-at-the-inner-lip" in failing(("face",))


def test_fap_19_in_mns_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    names = list(fapu.fap_unit_names())
    names[18] = "MNS"
    monkeypatch.setattr(fat, "fap_unit_names", lambda: tuple(names))
    monkeypatch.setattr("snhc.vectors.documents.fap_unit_names", lambda: tuple(names))
    assert failing(("face", "fat")) >= {"fat.units.by-fap", "fapu.unit-by-fap"}


def test_a_table_that_is_read_with_the_other_sign_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fat, "DEFAULT_READINGS", fat.FatReadings(sign="slope"))
    monkeypatch.setattr("snhc.vectors.documents.fat_readings", lambda readings: fat.FatReadings(sign="slope"))
    assert "fat.interval.negative-borders" in failing(("fat",))
