"""FIT documents: every fault names its class, field, index and expected length; limits; both forms."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError
from snhc.reference_impl.documents.bt_text import tokens
from snhc.reference_impl.documents.json_text import parse_json
from snhc.reference_impl.interpolation.fit import fit_from_json, fit_to_fields, load_fit, parse_fit_json
from snhc.reference_impl.interpolation.fit_text import fit_text, parse_fit_text

SAMPLES = sorted((Path(__file__).parents[1] / "fixtures" / "samples" / "fit").iterdir())

# Two links: (1, 2) -> (10, 11) with 7 parent values and impulses, and (10) -> (12) with a denominator.
GOOD: dict[str, list[float]] = {
    "FAPs": [1, 2, -1, 10, 11, -1, 10, -1, 12, -1],
    "Graph": [0, 1, 2, 3],
    "numeratorTerms": [1, 2, 1],
    "denominatorTerms": [0, 0, 2],
    "numeratorExp": [*([1] * 21), 1],
    "denominatorExp": [1, 0],
    "numeratorImpulse": [0, 1, 3, 2, 6, 63],
    "numeratorCoefs": [1.0, 2.0, 3.0, 4.0],
    "denominatorCoefs": [1.0, 2.0],
}


def fault(changes: dict[str, object], **limits: int) -> SnhcError:
    with pytest.raises(SnhcError) as caught:
        fit_from_json({**GOOD, **changes}, **limits)
    return caught.value


def test_good_table() -> None:
    fit = fit_from_json(GOOD)
    assert fit.sets == ((1, 2), (10, 11), (10,), (12,))
    assert [(link.parent, link.child, len(link.functions)) for link in fit.links] == [(0, 1, 2), (2, 3, 1)]
    assert fit.order == (1, 3)
    assert fit_to_fields(fit) == GOOD


def test_absent_fields_are_empty_and_other_keys_ignored() -> None:
    assert fit_from_json({}).sets == ()
    assert fit_from_json({"comment": 1, "FAPs": []}).sets == ()


def test_another_document_is_no_empty_table() -> None:
    with pytest.raises(InputFormat):
        fit_from_json({"meshes": {}})


CASES: list[tuple[dict[str, object], str, str, int | None]] = [
    ({"FAPs": [3, 0, -1]}, "RangeViolation", "FAPs[1]", None),
    ({"FAPs": [3, 69, -1]}, "RangeViolation", "FAPs[1]", None),
    ({"FAPs": [3, -2, -1]}, "RangeViolation", "FAPs[1]", None),
    ({"FAPs": [3, -1, -1]}, "InconsistentSemantics", "FAPs[2]", None),
    ({"FAPs": [-1]}, "InconsistentSemantics", "FAPs[0]", None),
    ({"FAPs": [3, -1, 4]}, "InconsistentSemantics", "FAPs[3]", 4),
    ({"Graph": [0, 4]}, "RangeViolation", "Graph[1]", None),
    ({"Graph": [-1, 1]}, "RangeViolation", "Graph[0]", None),
    ({"Graph": [0, 1, 2]}, "InconsistentSemantics", "Graph[3]", 4),
    ({"Graph": [1, 0, 2, 3]}, "RangeViolation", "FAPs[0]", None),
    ({"FAPs": [10, -1, 11, 2, -1], "Graph": [0, 1]}, "RangeViolation", "FAPs[3]", None),
    ({"numeratorExp": [16]}, "RangeViolation", "numeratorExp[0]", None),
    ({"denominatorExp": [0, -1]}, "RangeViolation", "denominatorExp[1]", None),
    ({"numeratorImpulse": [0, 1024]}, "RangeViolation", "numeratorImpulse[1]", None),
    ({"numeratorTerms": [11, 1, 1]}, "RangeViolation", "numeratorTerms[0]", None),
    ({"denominatorTerms": [0, 0, 11]}, "RangeViolation", "denominatorTerms[2]", None),
    ({"numeratorTerms": [1, 2]}, "InconsistentSemantics", "numeratorTerms[2]", 3),
    ({"denominatorTerms": [0, 0, 2, 0]}, "InconsistentSemantics", "denominatorTerms[3]", 3),
    ({"numeratorExp": [1] * 21}, "InconsistentSemantics", "numeratorExp[21]", 22),
    ({"numeratorExp": [1] * 23}, "InconsistentSemantics", "numeratorExp[22]", 22),
    ({"denominatorExp": [1]}, "InconsistentSemantics", "denominatorExp[1]", 2),
    ({"numeratorImpulse": [0, 1, 3, 2, 6]}, "InconsistentSemantics", "numeratorImpulse[5]", 6),
    ({"numeratorImpulse": [0, 1, 3, 2, 6, 6, 0, 0]}, "InconsistentSemantics", "numeratorImpulse[6]", 6),
    ({"numeratorImpulse": [0, 1, 7, 2, 6, 63]}, "RangeViolation", "numeratorImpulse[2]", None),
    ({"numeratorCoefs": [1.0]}, "InconsistentSemantics", "numeratorCoefs[1]", 4),
    ({"denominatorCoefs": []}, "InconsistentSemantics", "denominatorCoefs[0]", 2),
    ({"FAPs": 3}, "InputFormat", "FAPs", None),
    ({"FAPs": [3.0, -1]}, "InputFormat", "FAPs[0]", None),
    ({"FAPs": [True, -1]}, "InputFormat", "FAPs[0]", None),
    ({"Graph": ["0", 1]}, "InputFormat", "Graph[0]", None),
    ({"numeratorCoefs": [1.0, None, 1, 1]}, "InputFormat", "numeratorCoefs[1]", None),
    ({"numeratorCoefs": [1e999, 1, 1, 1]}, "InputFormat", "numeratorCoefs[0]", None),
    ({"numeratorCoefs": [10**400, 1, 1, 1]}, "InputFormat", "numeratorCoefs[0]", None),
]


@pytest.mark.parametrize(("changes", "error_class", "path", "expected"), CASES)
def test_fault(changes: dict[str, object], error_class: str, path: str, expected: int | None) -> None:
    error = fault(changes)
    assert (error.error_class, error.path, error.expected) == (error_class, path, expected)
    assert error.rule.startswith("FIT-")
    assert error.allowed


def test_limits() -> None:
    assert fault({}, max_sets=3).error_class == "ResourceLimit"
    assert fault({}, max_sets=3).path == "FAPs[8]"
    assert fault({}, max_links=1).path == "Graph[2]"
    assert fit_from_json(GOOD, max_sets=4, max_links=2).sets
    many = {"FAPs": [3, -1] * 257}
    assert fault(many).error_class == "ResourceLimit"
    assert fit_from_json({"FAPs": [3, -1] * 256}).sets
    assert fault({"Graph": [0, 1] * 1025}).path == "Graph[2048]"


def test_limits_reach_every_reader(tmp_path: Path) -> None:
    (tmp_path / "a").write_text(json.dumps(GOOD))
    (tmp_path / "b").write_text(fit_text(fit_from_json(GOOD)))
    for name in ("a", "b"):
        for limit in ({"max_sets": 3}, {"max_links": 1}):
            with pytest.raises(SnhcError) as caught:
                load_fit(tmp_path / name, **limit)
            assert caught.value.error_class == "ResourceLimit"


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        (b"{\n 1}", 2, 2),
        (b'{"FAPs":\n [NaN]}', 2, 3),
        (b'{"FAPs":\n \xff}', 2, 2),
        (b"[" * 100000, 1, 1),
        (b'{"FAPs": [' + b"9" * 5000 + b"]}", 1, 1),
        (b"", 1, 1),
    ],
)
def test_text_that_is_not_json(text: bytes, line: int, column: int) -> None:
    with pytest.raises(SnhcError) as caught:
        parse_fit_json(text)
    assert (caught.value.error_class, caught.value.line, caught.value.column) == ("InputFormat", line, column)


def test_document_size_limit() -> None:
    assert parse_json(b"[1]", rule="FIT-9", what="document", limit=3) == [1]
    with pytest.raises(SnhcError) as caught:
        parse_json(b"[12]", rule="FIT-9", what="document", limit=3)
    assert (caught.value.error_class, caught.value.rule) == ("ResourceLimit", "CNF-22")
    with pytest.raises(SnhcError) as caught:
        list(tokens("FIT { }", limit=6))
    assert (caught.value.error_class, caught.value.rule) == ("ResourceLimit", "CNF-22")


def test_document_that_is_not_an_object() -> None:
    with pytest.raises(SnhcError) as caught:
        parse_fit_json("[]")
    assert caught.value.error_class == "InputFormat"


@pytest.mark.parametrize("folder", SAMPLES, ids=lambda folder: folder.name)
def test_text_form_says_the_same(folder: Path, tmp_path: Path) -> None:
    fit = load_fit(folder / "table.json")
    (tmp_path / "table.bt").write_text("#VRML V2.0 utf8\n" + fit_text(fit, "Rules"))
    assert load_fit(tmp_path / "table.bt") == fit
    assert fit_from_json(json.loads(json.dumps(fit_to_fields(fit)))) == fit


def test_text_form_single_values_need_no_brackets() -> None:
    text = """DEF R FIT { # a comment
      FAPs [ 3, -1 4 -1 ] Graph [ 0 1 ] numeratorTerms 1 denominatorTerms 0
      numeratorExp 1 numeratorCoefs 2.5e0 }"""
    assert fit_to_fields(parse_fit_text(text))["numeratorCoefs"] == [2.5]


@pytest.mark.parametrize(
    ("text", "error_class", "line", "column"),
    [
        ("", "InputFormat", 1, 1),
        ("Group { }", "InputFormat", 1, 1),
        ("FIT { }\nFIT { }", "InputFormat", 2, 1),
        ("FIT {\n FAPs [ 3 x -1 ] }", "InputFormat", 2, 13),
        ("FIT {\n FAPs [ 3 1.5 -1 ] }", "InputFormat", 2, 11),
        ("FIT { Faps [ ] }", "InputFormat", 1, 7),
        ("FIT { FAPs [ ] FAPs [ ] }", "InputFormat", 1, 16),
        ("FIT { FAPs [ 3", "InputFormat", 1, 15),
        ('FIT { FAPs "abc', "InputFormat", 1, 12),
        ("FIT { numeratorCoefs 1e999 }", "InputFormat", 1, 22),
        ("FIT {\n FAPs [ 3 0 -1 ] }", "RangeViolation", 2, 11),
        ("FIT {\n FAPs [ 3 -1 ] Graph [ 0 0 ] }", "InconsistentSemantics", 2, 30),
        ("A { b " * 200, "ResourceLimit", 1, 607),
    ],
)
def test_text_form_faults(text: str, error_class: str, line: int, column: int) -> None:
    with pytest.raises(SnhcError) as caught:
        parse_fit_text(text)
    assert (caught.value.error_class, caught.value.line, caught.value.column) == (error_class, line, column)


def test_within_fap_reading_checks_its_own_range() -> None:
    with pytest.raises(SnhcError) as caught:
        fit_from_json({**GOOD, "numeratorImpulse": [0, 1, 3, 2, 2, 2]}, impulse="within-fap")
    assert caught.value.path == "numeratorImpulse[2]"
    with pytest.raises(SnhcError) as caught:
        fit_from_json(GOOD, impulse="from-1")
    assert caught.value.path == "numeratorImpulse[0]"
