"""The doctor names the step that fails, who is at fault, and what would help.

Rules: CNF-13, CNF-19, CNF-25.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner, Result

from snhc.conformance import doctor
from snhc.conformance.cli.doctor import command
from snhc.conformance.diagnosis import GUIDE, SCHEMA_FILE, STATES, Diagnosis, Step
from snhc.vectors.manifest import load

ROOT = Path(__file__).parents[2]
HARNESS = ROOT / "tests" / "harness"
PYTHON = os.path.realpath(sys.executable)
MANIFEST = load(check_schema=False)


def _examined(path: Path, text: str) -> Diagnosis:
    path.write_text(text)
    return doctor.examine(str(path), MANIFEST)


def _harness(script: str, *words: str, persistent: bool = False, more: str = "") -> str:
    command = [PYTHON, "-S", str(HARNESS / f"{'persistent' if persistent else script}.py")]
    command += [script, *words] if persistent else ["{input}", *words]
    return f"command = {json.dumps(command)}\n" + ('protocol = "persistent"\n' if persistent else "") + more


def _first_bad(diagnosis: Diagnosis) -> Step:
    return next(step for step in diagnosis.steps if step.state in ("wrong", "decoder"))


FILES = {
    "command = [": ("toml", "it is no TOML"),
    "comand = ['x']": ("keys", "comand is unknown"),
    "command = ['x']\ntimeout = 'long'": ("keys", "timeout is"),
    "command = ['no-such-program']": ("program", "there is no program no-such-program"),
    "command = ['./there']": ("program", "may not be executed"),
    "command = ['./carriage']": ("program", "ends with a carriage return"),
    "command = ['./shebang']": ("program", "names /no/such/interpreter"),
    "library = 'lib.so'": ("program", "there is no file"),
    "object = 'no_such_module:x'": ("hello", "No module named 'no_such_module'"),
    "command = ['./there', '{input}']\ntools = []": ("program", "may not be executed"),
}


@pytest.mark.parametrize("text", FILES)
def test_what_is_wrong_with_the_file(tmp_path: Path, text: str) -> None:
    (tmp_path / "there").write_text("x")
    for name, first in (("carriage", "#!/bin/sh\r\n"), ("shebang", "#!/no/such/interpreter\n")):
        (tmp_path / name).write_bytes(first.encode())
        (tmp_path / name).chmod(0o755)
    diagnosis = _examined(tmp_path / "a.toml", text)
    name, words = FILES[text]
    last = diagnosis.steps[-1]
    assert (last.name, last.state, words in last.what) == (name, "wrong", True), last
    assert last.fix and last.section and diagnosis.exit_code == 5


ONE_SHOT = {
    # name: step, state
    "hangs": ("decode", "wrong"),
    "rejects_everything": ("decode", "wrong"),
    "exits_2": ("decode", "wrong"),
    "crashes": ("decode", "wrong"),
    "falls_over": ("decode", "wrong"),
    "floods": ("decode", "wrong"),
    "takes_memory": ("decode", "wrong"),
    "prints_nothing": ("output", "wrong"),
    "prints_on_stderr": ("output", "wrong"),
    "not_utf8": ("output", "wrong"),
    "prints_garbage": ("header", "wrong"),
    "float_values": ("frames", "wrong"),
    "nan_values": ("frames", "wrong"),
    "wrong_value": ("values", "decoder"),
    "missing_frame": ("values", "decoder"),
    "accepts_everything": ("values", "decoder"),
    "exits_0_after_error": ("reject", "decoder"),
    "wrong_class": ("reject", "decoder"),
}
MUTANTS = {
    "wrong_kind": "header", "no_header": "header", "byte_order_mark": "header", "one_json_list": "header",
    "words_behind": "frames", "blank_lines": "frames", "no_state": "frames",
}  # fmt: skip


@pytest.mark.parametrize("name", ONE_SHOT)
def test_the_step_that_fails_is_named(tmp_path: Path, name: str) -> None:
    more = "timeout = 0.7\n" if name == "hangs" else "timeout = 20\nmemory_bytes = 134217728\noutput_bytes = 65536\n"
    diagnosis = _examined(tmp_path / "a.toml", _harness(name, more=more))
    step = _first_bad(diagnosis)
    assert (step.name, step.state) == ONE_SHOT[name], step
    assert diagnosis.exit_code == (5 if step.state == "wrong" else 1)


@pytest.mark.parametrize("name", MUTANTS)
def test_output_of_another_form_is_named(tmp_path: Path, name: str) -> None:
    step = _first_bad(_examined(tmp_path / "a.toml", _harness("mutants", name)))
    assert (step.name, step.state) == (MUTANTS[name], "wrong"), step


PERSISTENT = {
    "never_answers_hello": "hello",
    "dies_at_hello": "hello",
    "wrong_version": "hello",
    "claims_nothing": "claims",
    "two_answers": "decode",
    "lingers_after_bye": "bye",
    "talks_after_bye": "bye",
    "exits_7_after_bye": "bye",
}


@pytest.mark.parametrize("name", PERSISTENT)
def test_the_step_of_the_conversation_that_fails_is_named(tmp_path: Path, name: str) -> None:
    more = "start_timeout = 0.7\n" if name == "never_answers_hello" else ""
    diagnosis = _examined(tmp_path / "a.toml", _harness(name, persistent=True, more=more))
    step = _first_bad(diagnosis)
    assert (step.name, step.state) == (PERSISTENT[name], "wrong"), step
    assert diagnosis.exit_code == 5


def test_a_decoder_that_answers_otherwise_the_second_time(tmp_path: Path) -> None:
    script = tmp_path / "counts.py"
    counter = tmp_path / "count"
    counter.mkdir()
    (counter / "n").write_text("")
    script.write_text(
        f"import sys, os\nsys.path.insert(0, {str(HARNESS)!r})\nfrom _shared import answer, finish\n"
        f"path = {str(counter / 'n')!r}\nn = os.path.getsize(path)\nopen(path, 'a').write('x')\n"
        "lines, said, code = answer()\nfinish(lines + ['\\n'] * 0 if n == 0 else lines[:1], said, code)\n"
    )
    text = f"command = {json.dumps([PYTHON, str(script), '{input}'])}\nwritable = [{json.dumps(str(counter))}]\n"
    diagnosis = _examined(tmp_path / "a.toml", text)
    assert (_first_bad(diagnosis).name, diagnosis.exit_code) == ("again", 5)


@pytest.mark.parametrize("persistent", [False, True])
def test_a_sound_adapter(tmp_path: Path, persistent: bool) -> None:
    diagnosis = _examined(tmp_path / "a.toml", _harness("correct", persistent=persistent))
    assert {step.state for step in diagnosis.steps} == {"ok"} and diagnosis.exit_code == 0
    names = [step.name for step in diagnosis.steps]
    assert names[:4] == ["file", "toml", "keys", "program"] and ("bye" in names) is persistent


def test_options_are_tried(tmp_path: Path) -> None:
    options = "[options]\ndraft = []\nstrict = []\nobject = []\nlimit = []\n"
    steps = _examined(tmp_path / "a.toml", _harness("correct", more=options)).steps
    assert {step.what.partition(":")[0] for step in steps if step.name == "options" and step.state == "ok"} == {
        "draft", "strict", "object", "limit",
    }  # fmt: skip


# -- the command -------------------------------------------------------------------------------------------------------


def _called(*words: str) -> Result:
    return CliRunner().invoke(command, list(words))


def test_the_json_form_fits_its_schema(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(_harness("wrong_value"))
    result = _called(str(path), "--format", "json")
    document = json.loads(result.output)
    schema = json.loads(SCHEMA_FILE.read_text())
    jsonschema.validate(document, schema)
    assert (result.exit_code, document["verdict"]) == (1, "decoder")
    assert schema["properties"]["steps"]["items"]["properties"]["state"]["enum"] == list(STATES)


def test_a_program_that_falls_over_is_no_rejection(tmp_path: Path) -> None:
    step = _first_bad(_examined(tmp_path / "a.toml", _harness("falls_over")))
    assert "fell over" in step.what and step.what.endswith("it said: ZeroDivisionError")
    assert "rejected" not in step.what and "traceback" in step.fix
    assert "was rejected" in _first_bad(_examined(tmp_path / "a.toml", _harness("rejects_everything"))).what


def test_a_program_that_falls_over_on_broken_streams_is_told_so(tmp_path: Path) -> None:
    code = (
        f"import sys; sys.path.insert(0, {str(HARNESS)!r}); from _shared import answer, finish; "
        "told = answer(); assert told[2] == 0, 'boom'; finish(*told)"
    )
    text = f"command = {json.dumps([PYTHON, '-S', '-c', code, '{input}'])}\n"
    steps = {step.name: step for step in _examined(tmp_path / "a.toml", text).steps}
    for name in ("reject", "empty"):
        assert "AssertionError: boom" in steps[name].what and "without a traceback" in steps[name].fix


def test_the_text_says_what_is_wrong_and_what_helps(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text("command = ['pyhton3', 'x.py']\n")
    result = _called(str(path))
    assert result.exit_code == 5 and "\x1b" not in result.output
    assert "WRONG   program  there is no program pyhton3" in result.output
    assert 'see: docs/adapters.md, "The TOML file"' in result.output
    assert _called(str(tmp_path / "none.toml")).exit_code == 5


def test_every_section_that_is_named_is_in_the_guide() -> None:
    import ast

    tree = ast.parse(Path(doctor.__file__).read_text())
    texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    headings = {line.lstrip("# ") for line in (ROOT / GUIDE).read_text().splitlines() if line.startswith("#")}
    named = {
        "The TOML file", "The program", "Tools", "Limits", "What it prints", "The verdict", "A shared library",
        "One process for all vectors",
    }  # fmt: skip
    assert named <= texts and named <= headings
