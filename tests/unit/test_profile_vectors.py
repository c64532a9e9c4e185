"""The tier `profile`: what a checker of profiles and levels must say is in the manifest, and is what ours says."""

from __future__ import annotations

import json
from collections import Counter

import pytest
from click.testing import CliRunner

from snhc.analyzer.profiles import check_profile, profile_of
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.tables import profile_level_codes
from snhc.vectors.builders import end_code, face_object, intra, sequence, visual_object
from snhc.vectors.checking import ProfileCheck
from snhc.vectors.generate import RecipeFault, make
from snhc.vectors.manifest import MANIFEST_NAME, SUITE, DecodeOptions, Entry, load, validate
from snhc.vectors.recipe import Accept, Recipe

ENTRIES = {entry.id: entry for entry in load().entries if entry.tier == "profile"}


def test_every_code_is_signalled_and_every_verdict_occurs() -> None:
    checks = [entry.check for entry in ENTRIES.values()]
    assert all(check is not None for check in checks)
    signalled = {check["signalled"] for check in checks if check is not None}
    assert signalled >= {row.code for row in profile_level_codes()} | {0xFE, 0xFF}
    verdicts = Counter(check["verdict"] for check in checks if check is not None)
    assert min(verdicts[verdict] for verdict in ("pass", "fail", "not_checked")) >= 5
    found = {finding["id"] for check in checks if check is not None for finding in check["findings"]}
    assert found >= {"profile-tool", "level-bit-rate", "level-faces", "rate-above-15", "rate-sum-above-60"}


@pytest.mark.parametrize("id", ENTRIES)
def test_the_verb_says_what_the_manifest_says(id: str) -> None:
    """The same through the command: report, findings, and the exit code of CNF-19."""
    entry = ENTRIES[id]
    assert entry.check is not None
    result = CliRunner().invoke(snhc, ["check", str(SUITE / entry.file), "--profile", "signalled", "--format", "json"])
    *findings, report = [json.loads(line) for line in result.stdout.splitlines()]
    said = [
        {key: finding[key] for key in ("id", "severity", "rule", "bits") if key in finding}
        for finding in findings
        if finding["id"] != "trailing-data"
    ]
    assert said == entry.check["findings"]
    assert report["verdict"] == entry.check["verdict"] and report["signalled"] == entry.check["signalled"]
    wanted = {criterion["name"]: criterion["measured"] for criterion in entry.check["criteria"]}
    assert {criterion["name"]: criterion["measured"] for criterion in report["criteria"]} == wanted
    assert result.exit_code == (1 if entry.check["verdict"] == "fail" else 0)


@pytest.mark.parametrize("id", [id for id in ENTRIES if id.startswith("sys.level.")])
def test_profile_is_the_least_level_that_holds_the_stream(id: str) -> None:
    entry = ENTRIES[id]
    data = (SUITE / entry.file).read_bytes()
    names = ("Simple Face Animation@L1", "Simple Face Animation@L2")
    holding = [name for name in names if check_profile(data, asked=profile_of(name)).verdict == "pass"]
    assert entry.profile == (holding[0] if holding else None)


def test_only_the_bit_above_the_limit_makes_the_difference() -> None:
    for level in ("level-1", "level-2"):
        peaks = []
        for case in ("at-the-limit", "one-bit-above"):
            check = ENTRIES[f"sys.level.bit-rate.{level}-{case}"].check
            assert check is not None
            (one,) = [criterion for criterion in check["criteria"] if criterion["name"] == "bit_rate"]
            peaks.append((one["measured"] - one["limit"], one["verdict"], check["verdict"]))
        assert peaks == [(0, "pass", "pass"), (1, "fail", "fail")]


_STREAM = [sequence(0x61), visual_object(), face_object([intra({3: 5}, rate=(15, 0, 0))]), end_code()]


@pytest.mark.parametrize(
    ("check", "said"),
    [
        (ProfileCheck("fail"), "verdict pass, declared fail"),
        (ProfileCheck("pass", ("rate-above-15",)), "findings of the check"),
        (ProfileCheck("pass", measured={"faces": 2}), "faces 1, declared 2"),
        (ProfileCheck("pass", bits={"profile-tool": (0, 1)}), "profile-tool at None"),
        (ProfileCheck("pass", measured={"fases": 1}), "fases None"),
    ],
)
def test_a_recipe_that_declares_another_check_fails(check: ProfileCheck, said: str) -> None:
    recipe = Recipe(
        "test.one", "Title", "Docstring", "profile", ("FBA-1",), (), (), ("fba",), None, DecodeOptions(), "", "0.1.0",
        None, "test.one", lambda: Accept(_STREAM, check=check),
    )  # fmt: skip
    with pytest.raises(RecipeFault, match=said):
        make(recipe)


def test_the_schema_knows_the_check_and_entries_read_back() -> None:
    document = json.loads((SUITE / MANIFEST_NAME).read_text(encoding="utf-8"))
    document["vectors"] = [entry.as_json() for entry in ENTRIES.values()]
    validate(document)
    assert [Entry.from_json(entry).as_json() for entry in document["vectors"]] == document["vectors"]
    document["vectors"][0]["check"]["verdict"] = "perhaps"
    with pytest.raises(InputFormat, match="perhaps"):
        validate(document)
