"""Cases of a second implementation: every fba case, and the fba-* ones of neg (CNF-1, CNF-6, CNF-7).

The dct-* profiles of neg belong to the tests of the DCT mode; `case_names` selects by profile.
"""

from __future__ import annotations

import json

import pytest
from fba_helpers import SAMPLES, Json, case_files, case_names, check_error, check_partition, decoded, plain, traced

from snhc.reference_impl.face.decoded import ndjson
from snhc.reference_impl.systems.stream import decode_planes, read_stream, write_stream

FBA = case_names("fba")
NEG = case_names("neg", "fba-")


def test_all_cases_are_here() -> None:
    assert len(FBA) == 16
    assert len(NEG) == 14


def _agree(ours: Json, theirs: Json) -> None:
    # Comparators ignore keys they do not know (CNF-1): what the case does not name is not compared.
    assert {name: ours.get(name) for name in theirs} == theirs


@pytest.mark.parametrize("name", FBA)
def test_decoded_lines(name: str) -> None:
    case, data, expected = case_files("fba", name)
    frames, _, error = decoded(data)
    assert error is None
    lines = [json.loads(line) for line in ndjson(frames)]
    assert lines[0] == expected[0]
    assert len(lines) - 1 == case["lines"]
    for line in expected[1:]:
        _agree(lines[1 + line["index"]], line)
    # Long cases store some of their lines; all others store every one.
    assert len(expected) - 1 == case["lines"] or case["profile"] == "long"


@pytest.mark.parametrize("name", FBA)
def test_plane_spans(name: str) -> None:
    case, data, _ = case_files("fba", name)
    found = [[plane.start, plane.end] for plane in decode_planes(data)]
    assert len(found) == case["lines"]
    given = case["spans"]
    # A case gives the start of what stands before a plane, start code included; its end is the plane's own.
    assert [end for _, end in found[: len(given)]] == [end for _, end in given]
    for (start, _), (given_start, _) in zip(found, given, strict=False):
        assert given_start <= start <= given_start + 8 + 32


@pytest.mark.parametrize("name", FBA)
def test_written_back_identically(name: str) -> None:
    _, data, _ = case_files("fba", name)
    items = read_stream(data)
    assert write_stream(items) == data
    assert plain(read_stream(write_stream(items))) == plain(items)


@pytest.mark.parametrize("name", FBA)
def test_trace_partitions_and_agrees(name: str) -> None:
    _, data, _ = case_files("fba", name)
    check_partition(data)
    assert traced(data) == decoded(data)


@pytest.mark.parametrize("name", NEG)
def test_rejected_as_named(name: str) -> None:
    case, data, expected = case_files("neg", name)
    wanted = json.loads((SAMPLES / "neg" / name / "expected.json").read_text())
    frames, _, error = decoded(data)
    assert error is not None
    check_error(error, 8 * len(data))
    assert error.error_class == wanted["class"]
    assert error.bits is not None
    first, end = wanted["bits"]
    if wanted.get("loose"):
        assert error.bits[0] < end and first < error.bits[1]
    else:
        assert error.bits == (first, end)
        assert error.rule == wanted["rule"]
    # Lines completed before the fault are given out, and nothing behind it.
    lines = [json.loads(line) for line in ndjson(frames)]
    assert len(frames) == case["lines"]
    for line in expected[1:]:
        _agree(lines[1 + line["index"]], line)
    frames_traced, _, error_traced = traced(data)
    assert error_traced is not None
    assert frames_traced == frames
    assert error_traced.as_json() == error.as_json()
