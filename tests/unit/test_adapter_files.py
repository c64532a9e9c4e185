"""Adapter files: their form, and what becomes of them.

Rules: CNF-9, CNF-11, CNF-13, CNF-19, CNF-25.
"""

from __future__ import annotations

import json
import os
import pickle
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner

from snhc.conformance.adapters import (
    OPTION_NAMES,
    AdapterFault,
    BuiltIn,
    Claims,
    OneShot,
    Outcome,
    Persistent,
    find,
    from_command,
    load,
    messages,
)
from snhc.conformance.adapters.file import SCHEMA_FILE
from snhc.conformance.adapters.messages import SCHEMA_FILE as PROTOCOL_SCHEMA
from snhc.conformance.cli import snhc
from snhc.conformance.cli.run import command as run_command
from snhc.conformance.compare import judge
from snhc.conformance.runner import run
from snhc.reference_impl.bitstream.limits import Limits
from snhc.vectors.manifest import KINDS, SUITE, TOOLS, Manifest
from snhc.vectors.manifest import load as load_manifest

HARNESS = Path(__file__).parent.parent / "harness"
VALID = "fap.arith.example.1"
INVALID = "fba.error.time-code.hours-24"
MANIFEST = load_manifest(check_schema=False)
ENTRIES = {entry.id: entry for entry in MANIFEST.entries}


def _toml(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "adapter.toml"
    path.write_text(text)
    return path


def _statuses(adapter: OneShot | Persistent | BuiltIn, *ids: str) -> tuple[str, ...]:
    chosen = Manifest(MANIFEST.suite, tuple(ENTRIES[id] for id in ids))
    return tuple(result.status for result in run(chosen, [adapter]).results)


def test_an_adapter_file(tmp_path: Path) -> None:
    shutil.copy(HARNESS / "rejects_everything.py", tmp_path / "mine.py")
    path = _toml(
        tmp_path, f'name = "mine"\ncommand = [{sys.executable!r}, "mine.py", "{{input}}"]\ntimeout = 5\n'
        '[options]\nstrict = ["--strict"]\n'
    )  # fmt: skip
    adapter = load(path)
    assert isinstance(adapter, OneShot)
    assert (adapter.name, adapter.format, adapter.timeout) == ("mine", "ndjson", 5.0)
    assert adapter.options == {"strict": ("--strict",)}
    # The program lies beside the file and is found from anywhere.
    assert _statuses(adapter, VALID, INVALID) == ("fail", "pass")


FULL = """
version = 1
name = "all keys"
command = ["./decoder"]
protocol = "persistent"
format = "fap"
timeout = 2.5
start_timeout = 30
output_bytes = 1000
memory_bytes = 67108864
tools = ["fba", "mesh"]
kinds = ["valid"]
profiles = ["Simple Face Animation@L1"]
pass_environment = ["LICENCE"]
writable = ["cache", "/var/cache/x"]
limits = { mesh_nodes_delaunay = 100 }
readings = { AMB-FBA-6 = "before" }
environment = { MODE = "fast" }
"""


def test_a_persistent_adapter_with_all_keys(tmp_path: Path) -> None:
    text = FULL.replace("mesh_nodes_delaunay", next(iter(Limits.names())))
    adapter = load(_toml(tmp_path, text))
    assert isinstance(adapter, Persistent)
    assert (adapter.name, adapter.format, adapter.timeout, adapter.start_timeout) == ("all keys", "fap", 2.5, 30.0)
    assert adapter.claims == Claims(
        frozenset({"fba", "mesh"}), frozenset({"valid"}), frozenset({"Simple Face Animation@L1"}),
        {next(iter(Limits.names())): 100}, {"AMB-FBA-6": "before"}, frozenset(OPTION_NAMES), ("fap",),
    )  # fmt: skip
    assert adapter.around.writable == (str(tmp_path / "cache"), "/var/cache/x")
    assert adapter.around.passed == ("LICENCE",) and adapter.around.variables == {"MODE": "fast"}
    assert (adapter.around.output_bytes, adapter.around.memory_bytes) == (1000, 64 << 20)
    again = pickle.loads(pickle.dumps(adapter))
    assert again == adapter


WRONG = {
    "command = []": "command",
    "": "command=none: allowed exactly one of command, library, decoder, object",
    'command = "x"': "allowed a list of words, the program first",
    'command = ["x"]\nformat = "xml"': 'format="xml": allowed one of ndjson, fap, csv',
    'command = ["x"]\ncolour = 1': "colour=unknown",
    'comand = ["x"]': "did you mean command?",
    'command = ["x"]\ntimeout = 0': "timeout=0",
    'command = ["x"]\ntimeout = true': "timeout=true",
    'command = ["x"]\nmemory_bytes = 1': "64 MiB",
    'command = ["x"]\n[options]\ndraft = "-d"': "options",
    'command = ["x"]\n[options]\nother = ["-d"]': "options",
    "command = [": "allowed TOML",
    "command = [1]": "command",
    'command = [""]': "command",
    'command = ["x"]\ntools = ["foo"]': "tools",
    'command = ["x"]\nkinds = ["good"]': "kinds",
    'command = ["x"]\nprofiles = ["Simple"]': "name@level",
    'command = ["x"]\nlimits = { nodes = 1 }': "limits",
    'command = ["x"]\nreadings = { x = "y" }': "readings",
    'command = ["x"]\nlibrary = "y"': "command and library",
    'library = "y"\nprotocol = "persistent"': "protocol=given: allowed with command",
    'command = ["x"]\nprotocol = "persistent"\n[options]\ndraft = ["-d"]': "options=given: allowed with one-shot",
    'library = "y"\n[options]\ndraft = ["-d"]': "options=given",
    'library = "y"\ninterpreter = "python"': "interpreter=given",
    'object = "module"': "package.module:object",
    "version = 2\ncommand = ['x']": "version",
}


@pytest.mark.parametrize("text", WRONG)
def test_adapter_files_that_are_wrong(tmp_path: Path, text: str) -> None:
    path = _toml(tmp_path, text)
    with pytest.raises(AdapterFault) as caught:
        load(path)
    assert WRONG[text] in caught.value.message
    result = CliRunner().invoke(run_command, [str(path)])
    assert isinstance(result.exception, AdapterFault) and result.exception.exit_code == 5


def test_an_adapter_file_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "adapter.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(AdapterFault, match=r"adapter\.toml"):
        load(path)


def test_the_schemas_are_schemas_and_say_what_the_code_says() -> None:
    schemas = [json.loads(path.read_text()) for path in (SCHEMA_FILE, PROTOCOL_SCHEMA)]
    for schema in schemas:
        jsonschema.Draft202012Validator.check_schema(schema)
    adapter, protocol = schemas
    for properties in (adapter["properties"], protocol["$defs"]["hello_answer"]["properties"]):
        assert properties["tools"]["items"]["enum"] == list(TOOLS)
        assert properties["kinds"]["items"]["enum"] == list(KINDS)
        assert properties["limits"]["propertyNames"]["enum"] == list(Limits.names())
    assert adapter["properties"]["options"]["propertyNames"]["enum"] == list(OPTION_NAMES)
    # Every key says what it takes: errors are made of that.
    assert all(entry["description"] for entry in adapter["properties"].values())


def test_a_command_line_is_split_as_a_shell_would() -> None:
    assert from_command("'my decoder' --in {input}").command == ("my decoder", "--in", "{input}")
    for text in ("", "'open"):
        with pytest.raises(AdapterFault):
            from_command(text)


def test_words_that_name_an_adapter(tmp_path: Path) -> None:
    path = _toml(tmp_path, 'command = ["x"]')
    assert isinstance(find(str(path)), OneShot)
    assert find("snhc") == BuiltIn(reproduce="snhc")
    point = find("decoder:mine")
    assert isinstance(point, Persistent)
    assert (point.name, point.reproduce, point.command[-2:]) == ("mine", "decoder:mine", ("--decoder", "mine"))
    with pytest.raises(FileNotFoundError):
        find("nothing.toml")


# -- claims ------------------------------------------------------------------------------------------------------------


def _adapter(**changes: object) -> OneShot:
    command = (sys.executable, "-S", str(HARNESS / "correct.py"), "{input}")
    return replace(OneShot("correct", command), **changes)  # type: ignore[arg-type]


def test_kinds_and_profiles_that_are_not_claimed_are_not_applicable() -> None:
    assert _statuses(_adapter(kinds=("valid",)), VALID, INVALID) == ("pass", "not_applicable")
    profiled = next(entry for entry in ENTRIES.values() if entry.profile)
    tools = ("fba", "mesh", "systems", "bap", "dct-p1")
    assert _adapter(tools=tools).lacks(profiled) == ""
    assert _adapter(tools=tools, profiles=()).lacks(profiled) == f"profile {profiled.profile}"
    assert _adapter(tools=tools, profiles=(profiled.profile,)).lacks(profiled) == ""
    assert _adapter(profiles=()).lacks(ENTRIES[VALID]) == ""


def test_vectors_beyond_a_limit_that_is_claimed_are_not_applicable() -> None:
    skipping = "fba.header.skip.31"
    low, high = ({"skipped_frames": value} for value in (10, 100_000))
    assert _statuses(_adapter(limits=low), "fba.body.alternating", skipping) == ("pass", "not_applicable")
    assert _statuses(_adapter(limits=high), "fba.body.alternating", skipping) == ("pass", "pass")


def test_a_reading_that_is_claimed_has_to_be_followed() -> None:
    entry = ENTRIES["fba.ambiguous.skipped-frames"]
    outputs = {key: (SUITE / expect.file).read_bytes() for key, expect in entry.readings["AMB-FBA-6"].items()}  # type: ignore[union-attr]
    for claimed in outputs:
        for key, output in outputs.items():
            verdict = judge(entry, Outcome(0, output, readings={"AMB-FBA-6": claimed}), SUITE, "ndjson")
            assert verdict.status == ("pass" if key == claimed else "fail")
    # Of other ambiguities nothing is said.
    assert judge(entry, Outcome(0, output, readings={"AMB-FBA-1": "x"}), SUITE, "ndjson").status == "pass"


def test_readings_become_words_of_the_command() -> None:
    adapter = _adapter(options={"reading": ("--reading", "{name}={value}")}, readings={"AMB-FBA-6": "before"})
    assert adapter.words(ENTRIES[VALID], Path("x"), None)[-2:] == ["--reading", "AMB-FBA-6=before"]


def test_an_adapter_is_known_by_its_text_in_every_process(tmp_path: Path) -> None:
    # What a run keeps for its resumption is told apart by that.
    path = _toml(tmp_path, FULL.replace("mesh_nodes_delaunay", next(iter(Limits.names()))))
    code = (
        f"from pathlib import Path; from snhc.conformance.adapters import load; print(repr(load(Path({str(path)!r}))))"
    )
    said = {
        subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=True
        ).stdout
        for seed in ("1", "2", "3")
    }
    assert len(said) == 1 and b"tools=['fba', 'mesh']" in said.pop()


# -- other readings ----------------------------------------------------------------------------------------------------


def _reference(readings: dict[str, str]) -> BuiltIn:
    return BuiltIn(readings=readings)


BEFORE = {"AMB-FBA-6": "before"}
# Streams that show the reading without having been made for it, and one that was.
SHOWING = ("fap.arith.example.1", "fba.body.alternating", "fba.ambiguous.skipped-frames", INVALID)


def test_a_decoder_that_follows_another_reading_is_held_against_that_reading() -> None:
    assert _statuses(_reference(BEFORE), *SHOWING) == ("pass",) * 4
    # The same output without the claim, and the claim without the output.
    for id, claimed, followed in ((VALID, {}, BEFORE), (VALID, BEFORE, {})):
        entry = ENTRIES[id]
        outcome = replace(_reference(followed).decode(entry, SUITE / entry.file), readings=claimed)
        verdict = judge(entry, outcome, SUITE, "ndjson")
        assert verdict.status == "fail" and verdict.difference is not None and verdict.difference.what == "time"


def test_an_ambiguous_stream_may_follow_any_reading_of_its_own_beside_one_that_is_claimed() -> None:
    entry = ENTRIES["fap.ambiguous.clipping"]
    for key in entry.readings["AMB-FBA-4"]:
        outcome = _reference({**BEFORE, "AMB-FBA-4": key}).decode(entry, SUITE / entry.file)
        verdict = judge(entry, replace(outcome, readings=BEFORE), SUITE, "ndjson")
        assert verdict.status == "pass" and f"AMB-FBA-4={key}" in verdict.reading


def test_readings_are_handed_to_every_kind_of_adapter() -> None:
    for adapter in (_adapter(), BuiltIn()):
        assert adapter.following(BEFORE).readings == BEFORE
    assert Persistent("x", ("x",)).following(BEFORE).claims.readings == BEFORE
    result = CliRunner().invoke(snhc, ["run", "--reading", "AMB-FBA-6=before", "--filter", "|".join(SHOWING)])
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(("id", "key"), [("AMB-FBA-99", "x"), ("AMB-FBA-6", "sideways")])
def test_readings_that_there_are_not_are_refused(tmp_path: Path, id: str, key: str) -> None:
    with pytest.raises(AdapterFault, match=id):
        load(_toml(tmp_path, f'command = ["x"]\nreadings = {{ {id} = "{key}" }}\n'))
    question = messages.hello(1, {})
    line = json.dumps({**question, "readings": {id: key}}).encode()
    with pytest.raises(messages.Misfit, match=id):
        messages.answer(line, question)
