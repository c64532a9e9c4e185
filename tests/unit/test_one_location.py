"""A fault has one location: decode, dump and the suite say the same class, rule and bits (CNF-7, CNF-17, CNF-21)."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from snhc.conformance.cli import snhc
from snhc.vectors.manifest import DOCUMENTS, SUITE, DecodeOptions, Entry, load

ENTRIES = [
    entry
    for entry in load(SUITE).entries
    if entry.kind == "invalid" and entry.media not in DOCUMENTS and entry.options == DecodeOptions()
]


def test_there_are_vectors_to_look_at() -> None:
    assert len(ENTRIES) > 100


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.id for entry in ENTRIES])
def test_decode_dump_and_suite_agree(entry: Entry) -> None:
    expected = entry.as_json()["expect"]["reject"]
    faults = []
    for verb in ("decode", "dump"):
        result = CliRunner().invoke(snhc, [verb, str(SUITE / entry.file), "--json-errors"])
        assert result.exit_code == (3 if expected["class"] == "InputFormat" else 4)
        faults.append(json.loads(result.stderr.splitlines()[-1]))
    assert faults[0] == faults[1]
    assert {key: faults[0][key] for key in ("class", "rule", "bits")} == {
        key: expected[key] for key in ("class", "rule", "bits")
    }
