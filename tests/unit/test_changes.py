"""Change lists of the suite: every kind of change, the step that it asks of the version, and what ids must not do."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from snhc.conformance.cli import snhc
from snhc.vectors.changes import SCHEMA_FILE, STEPS, ChangeList, changes_between
from snhc.vectors.manifest import MANIFEST_NAME, Accepted, Entry, Manifest, Rejected, Tolerance, Tombstone, load

SCHEMA = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))
ENTRIES = load().entries
VALID = next(entry for entry in ENTRIES if entry.kind == "valid")
INVALID = next(entry for entry in ENTRIES if entry.kind == "invalid")
AMBIGUOUS = next(entry for entry in ENTRIES if entry.kind == "ambiguous")
OLD = Manifest("1.2.3", (VALID, INVALID, AMBIGUOUS))


def compare(old: Manifest, new: Manifest) -> ChangeList:
    """A change list, whose document fits the schema."""
    found = changes_between(old, new)
    jsonschema.validate(json.loads(found.text()), SCHEMA, jsonschema.Draft202012Validator)
    assert "".join(found.lines()).startswith(f"suite {old.suite} -> {new.suite}: ")
    return found


def changed(entry: Entry, **fields: Any) -> Manifest:
    """The old suite with one entry changed; its version takes a step that is always large enough."""
    return Manifest("9.0.0", tuple(replace(e, **fields) if e is entry else e for e in OLD.entries))


def test_a_suite_has_not_changed_since_itself() -> None:
    found = compare(OLD, OLD)
    assert (found.step, found.required, found.changes, found.faults) == ("none", "1.2.3", (), ())


ZEROS = "0" * 64


@pytest.mark.parametrize(
    ("entry", "fields", "step", "kinds"),
    [
        (VALID, {"sha256": ZEROS}, "major", (("input",), (), ())),
        (VALID, {"media": "bap"}, "major", (("input",), (), ())),
        (VALID, {"options": replace(VALID.options, strict=True)}, "major", (("options",), (), ())),
        (VALID, {"expect": Accepted("fba", "fap/x.ndjson", ZEROS)}, "major", ((), ("expect",), ("files",))),
        (VALID, {"tolerance": Tolerance("dct-8", 1, 0.5)}, "major", ((), ("tolerance",), ())),
        (VALID, {"tools": ("bap",)}, "major", ((), ("tools",), ())),
        (VALID, {"profile": "Simple FBA@L1"}, "major", ((), ("profile",), ())),
        (VALID, {"check": {"verdict": "fail"}}, "major", ((), ("check",), ())),
        (INVALID, {"expect": Rejected("Truncated", "FBA-1", (0, 1))}, "major", ((), ("expect",), ())),
        (INVALID, {"expect": replace(INVALID.expect, allowed=("conceal",))}, "major", ((), ("expect",), ())),
        (AMBIGUOUS, {"readings": {}}, "major", ((), ("readings",), None)),
        (VALID, {"title": "Other", "notes": "Mind."}, "patch", ((), (), ("title", "notes"))),
        (VALID, {"description": "Other words."}, "patch", ((), (), ("description",))),
        (VALID, {"rules": ("FBA-1",), "tier": "real"}, "patch", ((), (), ("tier", "rules"))),
        (VALID, {"features": ("x",), "value_classes": ("y",)}, "patch", ((), (), ("features", "value_classes"))),
        (VALID, {"provenance": {"recipe": "a.b", "generator": 2, "seed": None}}, "patch", ((), (), ("provenance",))),
        (VALID, {"file": "other/name.fba"}, "patch", ((), (), ("files",))),
    ],
)
def test_every_field_counts_as_what_it_means(
    entry: Entry, fields: dict[str, Any], step: str, kinds: tuple[Any, Any, Any]
) -> None:
    found = compare(OLD, changed(entry, **fields))
    (change,) = found.changes
    assert (change.id, change.what, change.step, found.step) == (entry.id, "changed", step, step)
    assert (change.input, change.expectation) == kinds[:2]
    assert kinds[2] is None or change.words == kinds[2]
    assert found.faults == ()


def test_every_field_of_an_entry_is_known() -> None:
    """A field that comes to the manifest must be given a meaning here."""
    from snhc.vectors import changes

    known = {*changes._INPUT, *changes._EXPECTATION, *changes._WORDS, "id"}
    assert {key for entry in ENTRIES for key in entry.as_json()} <= known


def test_added() -> None:
    fresh = replace(VALID, id="test.new", since="1.3.0")
    found = compare(OLD, Manifest("1.3.0", (*OLD.entries, fresh)))
    assert [change.as_json() for change in found.changes] == [{"id": "test.new", "what": "added", "step": "minor"}]
    assert (found.step, found.required, found.faults) == ("minor", "1.3.0", ())


def test_while_the_version_stands_still_only_the_version_is_at_fault() -> None:
    found = compare(OLD, replace(OLD, entries=(*OLD.entries, replace(VALID, id="test.new", since="1.2.3"))))
    assert [fault.kind for fault in found.faults] == ["version"] and found.failed


def test_removed_with_a_tombstone() -> None:
    tombstone = Tombstone(VALID.id, "2.0.0", "it was wrong")
    found = compare(OLD, Manifest("2.0.0", (INVALID, AMBIGUOUS), (tombstone,)))
    assert [change.as_json() for change in found.changes] == [
        {"id": VALID.id, "what": "removed", "step": "major", "reason": "it was wrong"}
    ]
    assert (found.step, found.required, found.faults) == ("major", "2.0.0", ())


DEAD = Tombstone("test.dead", "1.1.0", "wrong")
BURIED = replace(OLD, tombstones=(DEAD,))


@pytest.mark.parametrize(
    ("old", "new", "faults"),
    [
        (OLD, Manifest("2.0.0", (INVALID, AMBIGUOUS)), [("no-tombstone", VALID.id)]),
        (
            BURIED,
            Manifest("1.3.0", (*OLD.entries, replace(VALID, id="test.dead", since="1.3.0")), (DEAD,)),
            [("id-reused", "test.dead")],
        ),
        (
            # Neither does dropping the tombstone help.
            BURIED,
            Manifest("1.3.0", (*OLD.entries, replace(VALID, id="test.dead", since="1.3.0"))),
            [("id-reused", "test.dead"), ("tombstone-lost", "test.dead")],
        ),
        (OLD, Manifest("2.0.0", OLD.entries, (Tombstone(VALID.id, "2.0.0", "w"),)), [("id-reused", VALID.id)]),
        (BURIED, Manifest("1.2.4", OLD.entries), [("tombstone-lost", "test.dead")]),
        (BURIED, Manifest("1.2.4", OLD.entries, (replace(DEAD, removed="1.0.0"),)), [("tombstone-lost", "test.dead")]),
        (
            OLD,
            Manifest("2.0.0", (INVALID, AMBIGUOUS), (Tombstone(VALID.id, "1.2.3", "w"),)),
            [("tombstone-version", VALID.id)],
        ),
        (
            OLD,
            Manifest("2.0.0", (INVALID, AMBIGUOUS), (Tombstone(VALID.id, "2.0.1", "w"),)),
            [("tombstone-version", VALID.id)],
        ),
        (OLD, Manifest("1.3.0", (*OLD.entries, replace(VALID, id="test.new", since="1.2.3"))), [("since", "test.new")]),
        (OLD, Manifest("1.3.0", (*OLD.entries, replace(VALID, id="test.new", since="1.4.0"))), [("since", "test.new")]),
        (OLD, replace(OLD, suite="1.2.2"), [("version", "")]),
    ],
)
def test_what_ids_and_tombstones_must_not_do(old: Manifest, new: Manifest, faults: list[tuple[str, str]]) -> None:
    found = compare(old, new)
    assert [(fault.kind, fault.id) for fault in found.faults] == faults
    # What is only said wrongly does not fail.
    assert found.failed == (not {kind for kind, _ in faults} <= {"since", "tombstone-version"})


@pytest.mark.parametrize(
    ("fields", "version", "good"),
    [
        ({"sha256": ZEROS}, "1.2.3", False), ({"sha256": ZEROS}, "1.2.4", False), ({"sha256": ZEROS}, "1.3.0", False),
        ({"sha256": ZEROS}, "1.99.99", False), ({"sha256": ZEROS}, "2.0.0", True), ({"sha256": ZEROS}, "3.1.4", True),
        ({"title": "x"}, "1.2.3", False), ({"title": "x"}, "1.2.4", True), ({"title": "x"}, "1.10.0", True),
        ({"title": "x"}, "1.2.10", True), ({"title": "x"}, "1.1.99", False),
    ],
)  # fmt: skip
def test_the_version_must_follow(fields: dict[str, Any], version: str, good: bool) -> None:
    found = compare(OLD, replace(changed(VALID, **fields), suite=version))
    assert [fault.kind for fault in found.faults] == ([] if good else ["version"])


def test_before_1_0_0_a_changed_expectation_is_a_major_step_too() -> None:
    old = replace(OLD, suite="0.1.0")
    assert compare(old, replace(changed(VALID, sha256=ZEROS), suite="0.2.0")).required == "1.0.0"


@given(st.lists(st.sampled_from(["input", "expect", "words", "add", "remove"]), max_size=3, unique=True))
def test_the_step_is_the_largest_of_all_changes(kinds: list[str]) -> None:
    """And the version that it asks for is one that has no fault."""
    entries = {entry.id: entry for entry in OLD.entries}
    if "words" in kinds:
        entries[INVALID.id] = replace(INVALID, title="Other")
    if "input" in kinds:
        entries[VALID.id] = replace(VALID, sha256=ZEROS)
    if "expect" in kinds:
        entries[INVALID.id] = replace(INVALID, expect=Rejected("Truncated", "FBA-1", (0, 1)))
    if "add" in kinds:
        entries["test.new"] = replace(VALID, id="test.new", since="1.2.4")
    if "remove" in kinds:
        del entries[AMBIGUOUS.id]
    buried = (Tombstone(AMBIGUOUS.id, "1.2.4", "w"),) if "remove" in kinds else ()
    steps = {"input": "major", "expect": "major", "words": "patch", "add": "minor", "remove": "major"}
    wanted = max((steps[kind] for kind in kinds), key=STEPS.index, default="none")
    found = compare(OLD, Manifest("1.2.4", tuple(entries.values()), buried))
    assert found.step == wanted
    least = compare(OLD, Manifest(found.required, tuple(entries.values()), buried))
    assert [fault for fault in least.faults if fault.kind == "version"] == []
    assert bool([fault for fault in found.faults if fault.kind == "version"]) == (wanted not in ("none", "patch"))


# -- the command -------------------------------------------------------------------------------------------------------


def run(*args: object) -> Result:
    return CliRunner().invoke(snhc, ["generate", *map(str, args)])


def written(folder: Path, manifest: Manifest) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / MANIFEST_NAME).write_text(manifest.text(), encoding="utf-8")
    return folder


def test_of_a_folder_or_a_manifest(tmp_path: Path) -> None:
    old, new = written(tmp_path / "old", OLD), written(tmp_path / "new", changed(VALID, sha256=ZEROS))
    by_folder = run("--changes", old, "--suite", new)
    assert by_folder.exit_code == 0
    assert by_folder.stdout == f"suite 1.2.3 -> 9.0.0: step major\n\nchanged (1):\n  {VALID.id} [major] input: input\n"
    assert run("--changes", old / MANIFEST_NAME, "--suite", new).stdout == by_folder.stdout


def test_faults_are_printed_and_fail(tmp_path: Path) -> None:
    old, new = written(tmp_path / "old", OLD), written(tmp_path / "new", Manifest("1.2.3", (INVALID, AMBIGUOUS)))
    done = run("--changes", old, "--suite", new)
    assert done.exit_code == 1
    assert f"no-tombstone: {VALID.id}" in done.stdout and "version: 1.2.3 after 1.2.3" in done.stdout
    done = run("--changes", old, "--suite", new, "-o", tmp_path / "changes.json")
    assert done.exit_code == 1
    document = json.loads((tmp_path / "changes.json").read_text(encoding="utf-8"))
    assert [fault["fault"] for fault in document["faults"]] == ["no-tombstone", "version"]
    jsonschema.validate(document, SCHEMA)


@pytest.mark.parametrize("content", ["", "{}", "[" * 100_000, '{"format":"snhc-manifest","version":2}', None])
def test_what_is_no_suite_is_an_input_fault(tmp_path: Path, content: str | None) -> None:
    if content is not None:
        (tmp_path / MANIFEST_NAME).write_text(content, encoding="utf-8")
    for old in (tmp_path, tmp_path / MANIFEST_NAME):
        done = run("--changes", old)
        assert done.exit_code == 3 and done.stderr.startswith("snhc: InputFormat: manifest")


def test_an_id_twice_is_an_input_fault(tmp_path: Path) -> None:
    written(tmp_path, Manifest("1.0.0", (VALID, VALID)))
    done = run("--changes", tmp_path)
    assert done.exit_code == 3 and f"{VALID.id} twice" in done.stderr


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
