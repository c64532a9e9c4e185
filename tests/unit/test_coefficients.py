"""Coefficient documents: samples, states, prediction, located errors."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from snhc.reference_impl.face.coefficients import DctFrame, decode_document, parse_document
from snhc.reference_impl.face.dct_transform import DctReading

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples" / "dctcoef"
ZEROS = [0] * 15


def decode(document: object, reading: DctReading | None = None) -> list[DctFrame]:
    parsed = parse_document(json.dumps(document))
    return list(decode_document(parsed) if reading is None else decode_document(parsed, reading))


def segment(intra: object, coefficients: object) -> dict[str, object]:
    return {"intra": intra, "coefficients": coefficients}


def document(*segments: object, fap_quant: object = 8) -> dict[str, object]:
    return {"fap_quant": fap_quant, "segments": list(segments)}


def test_there_are_samples() -> None:
    assert len(list(SAMPLES.iterdir())) == 16


@pytest.mark.parametrize("case", sorted(SAMPLES.iterdir()), ids=lambda path: path.name)
def test_samples_are_met_exactly(case: Path) -> None:
    expected = [json.loads(line) for line in (case / "expected.ndjson").read_text().splitlines()][1:]
    frames = decode_document(parse_document((case / "input.json").read_bytes()))
    assert [frame.as_json() for frame in frames] == expected


def test_worked_example() -> None:
    frames = decode(
        document(
            segment(True, {"3": [6, -5, 0, 2] + [0] * 12, "49": [-3] + [0] * 14 + [1]}),
            segment(False, {"3": [-2, 1] + [0] * 14, "49": [0] * 16}),
        )
    )
    assert [frame.faps[2] for frame in frames] == [
        -52, -67, -89, -108, -112, -93, -50, 11, 79, 140, 183, 202, 198, 179, 157, 142,
        62, 60, 58, 55, 50, 45, 39, 33, 27, 21, 15, 10, 5, 2, 0, -2,
    ]  # fmt: skip
    assert [frame.faps[48] for frame in frames] == [
        -659, -1079, -255, -1451, 71, -1719, 270, -1842, 312, -1800, 189, -1601, -79, -1275, -451, -871,
        *[-765] * 16,
    ]  # fmt: skip
    assert [frame.intra for frame in frames] == [True] * 16 + [False] * 16
    assert (frames[15].time, frames[16].time, frames[31].time) == (
        Fraction(1, 2),
        Fraction(8, 15),
        Fraction(31, 30),
    )
    assert {frame.state for frame in frames} == {"UUT" + "U" * 45 + "T" + "U" * 19}
    assert list(frames[16].as_json()) == ["index", "time", "intra", "faps", "viseme", "expression", "state"]
    assert frames[0].as_json()["time"] == "0/1"


def test_a_fap_left_out_is_retained_and_its_predictor_lives_on() -> None:
    # FAP 18, scale 1: step 5, DC step 5/3, value = DC * 5/12.
    frames = decode(
        document(
            segment(True, {"18": [12, *ZEROS], "3": [0] * 16}),
            segment(False, {"3": [0] * 16}),
            segment(False, {"18": [12, *ZEROS]}),
            segment(True, {"18": [12, *ZEROS]}),
            fap_quant=1,
        )
    )
    assert [frames[i].faps[17] for i in (0, 16, 32, 48)] == [5, 5, 10, 5]
    assert [frames[i].state[17] for i in (0, 16, 32, 48)] == ["T", "R", "T", "T"]
    assert [frames[i].state[2] for i in (0, 16, 32, 48)] == ["T", "T", "R", "R"]


def test_prediction_runs_on_quantised_integers() -> None:
    # DC 1 is 5/12, rounded 0; twelve of them are 5, where adding rounded values would stay at 0.
    frames = decode(
        document(segment(True, {"18": [1, *ZEROS]}), *[segment(False, {"18": [1, *ZEROS]})] * 11, fap_quant=1)
    )
    assert frames[0].faps[17] == 0
    assert frames[-1].faps[17] == 5


def test_readings_reach_the_values() -> None:
    doc = document(segment(True, {"3": [6, *ZEROS]}))
    assert decode(doc)[0].faps[2] == 45
    assert decode(doc, DctReading(dc_step_ratio=4))[0].faps[2] == 34
    assert decode(doc, DctReading(normalisation="unnormalised"))[0].faps[2] == 11


def test_empty_documents_and_segments() -> None:
    assert decode(document()) == []
    frames = decode(document(segment(True, {})))
    assert len(frames) == 16
    assert frames[0].state == "U" * 68
    assert frames[0].faps == (None,) * 68


GOOD = [0] * 16


@pytest.mark.parametrize(
    ("doc", "error", "path"),
    [
        ([], InputFormat, ""),
        ({"segments": []}, InputFormat, ""),
        ({"fap_quant": 1}, InputFormat, ""),
        (document(fap_quant="8"), InputFormat, "fap_quant"),
        (document(fap_quant=True), InputFormat, "fap_quant"),
        (document(fap_quant=32), RangeViolation, "fap_quant"),
        (document(fap_quant=-1), RangeViolation, "fap_quant"),
        ({"fap_quant": 1, "segments": {}}, InputFormat, "segments"),
        (document(7), InputFormat, "segments[0]"),
        (document({"coefficients": {}}), InputFormat, "segments[0]"),
        (document({"intra": True}), InputFormat, "segments[0]"),
        (document(segment(1, {})), InputFormat, "segments[0].intra"),
        (document(segment(None, {})), InputFormat, "segments[0].intra"),
        (document(segment(True, [])), InputFormat, "segments[0].coefficients"),
        (document(segment(True, {"1": GOOD})), InputFormat, "segments[0].coefficients"),
        (document(segment(True, {"2": GOOD})), InputFormat, "segments[0].coefficients"),
        (document(segment(True, {"69": GOOD})), InputFormat, "segments[0].coefficients"),
        (document(segment(True, {"03": GOOD})), InputFormat, "segments[0].coefficients"),
        (document(segment(True, {"x": GOOD})), InputFormat, "segments[0].coefficients"),
        (document(segment(True, {"3": 5})), InputFormat, "segments[0].coefficients.3"),
        (document(segment(True, {"3": GOOD[1:]})), InputFormat, "segments[0].coefficients.3"),
        (document(segment(True, {"3": [*GOOD, 0]})), InputFormat, "segments[0].coefficients.3"),
        (document(segment(True, {"3": [*ZEROS, 1.0]})), InputFormat, "segments[0].coefficients.3[15]"),
        (document(segment(True, {"3": [*ZEROS, False]})), InputFormat, "segments[0].coefficients.3[15]"),
        (document(segment(True, {"3": [1 << 31, *ZEROS]})), RangeViolation, "segments[0].coefficients.3[0]"),
        (document(segment(True, {"3": [10**500, *ZEROS]})), RangeViolation, "segments[0].coefficients.3[0]"),
    ],
)
def test_a_wrong_document_is_one_error_with_a_path(doc: object, error: type[SnhcError], path: str) -> None:
    with pytest.raises(error) as caught:
        parse_document(json.dumps(doc))
    assert caught.value.path == path


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (b'{"fap_quant": 1,\n "segments": [}', 2),
        (b'{\n\n"a": NaN}', 3),
        (b"\xff", 1),
        (b"[" * 100_000, 1),
        (b"", 1),
    ],
    ids=["syntax", "constant", "utf-8", "depth", "empty"],
)
def test_what_is_no_json_has_a_line(text: bytes, line: int) -> None:
    with pytest.raises(InputFormat) as caught:
        parse_document(text)
    assert caught.value.line == line


def test_size_limit() -> None:
    with pytest.raises(ResourceLimit, match="CNF-22"):
        parse_document(json.dumps(document()), limit=10)


def test_an_inter_segment_needs_what_it_predicts_from() -> None:
    with pytest.raises(InconsistentSemantics) as caught:
        decode(document(segment(False, {})))
    assert caught.value.path == "segments[0].intra"
    frames = decode_document(
        parse_document(json.dumps(document(segment(True, {"3": GOOD}), segment(False, {"3": GOOD, "4": GOOD}))))
    )
    for _ in range(16):
        next(frames)
    with pytest.raises(InconsistentSemantics) as caught:
        next(frames)
    assert caught.value.path == "segments[1].coefficients.4"
    assert caught.value.value == 4
